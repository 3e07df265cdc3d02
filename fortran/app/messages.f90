! SPDX-License-Identifier: GPL-3.0-or-later
!> Lines for the terminal or the log of a batch job, each flushed at once, so that they appear in
!> chronological order.  Progress lines show the completed fraction and the remaining time.
module dda_messages
   use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
   use dda_kinds, only: wp, long
   implicit none
   private
   public :: say, warn, progress_type, start_progress, show_progress

   real(wp), parameter :: interval = 5.0_wp  !< time between progress lines, s

   !> Times of the start of the run and of the last line.
   type :: progress_type
      integer(long) :: has_started = 0, last_shown = 0, rate = 1
      real(wp) :: first = 0.0_wp     !< time of the model at the start, s
      logical :: quiet = .false.
   end type progress_type

contains

   !> Write a line of results to the standard output.
   subroutine say(line)
      character(len=*), intent(in) :: line   !< line without its line end

      call write_line(output_unit, line)
   end subroutine say

   !> Write a line to the standard error, after all earlier output has been flushed.
   subroutine warn(line)
      character(len=*), intent(in) :: line   !< line without its line end

      call write_line(error_unit, line)
   end subroutine warn

   !> Write a line and flush; a closed pipe does not end a run.
   subroutine write_line(unit, line)
      integer, intent(in) :: unit            !< unit of the standard output or error
      character(len=*), intent(in) :: line   !< line without its line end
      integer :: unused

      write (unit, '(a)', iostat=unused) line
      flush (unit, iostat=unused)
   end subroutine write_line

   !> Start the clock.
   subroutine start_progress(progress, time, quiet)
      type(progress_type), intent(out) :: progress  !< progress of this run
      real(wp), intent(in) :: time   !< time of the model, s
      logical, intent(in) :: quiet   !< write no progress lines

      progress%quiet = quiet
      progress%first = time
      call system_clock(progress%has_started, progress%rate)
      progress%last_shown = progress%has_started
   end subroutine start_progress

   !> Write a progress line if the interval has passed or the run has ended.
   subroutine show_progress(progress, time, duration)
      type(progress_type), intent(inout) :: progress     !< progress of this run
      real(wp), intent(in) :: time, duration  !< time of the model, s
      integer(long) :: clock
      real(wp) :: elapsed, remaining_time
      character(len=160) :: line

      if (progress%quiet) return
      call system_clock(clock)
      if (clock - progress%last_shown < interval*progress%rate .and. time < duration) return
      progress%last_shown = clock
      elapsed = real(clock - progress%has_started, wp)/real(progress%rate, wp)
      remaining_time = elapsed*(duration - time)/max(time - progress%first, tiny(1.0_wp))
      write (line, '(a,f0.3,a,f0.3,a,f5.1,a,f0.1,a,f0.1,a)') 't = ', time, ' of ', duration, &
         ' s, ', 100*time/duration, ' %, spent ', elapsed, ' s, left ', remaining_time, ' s'
      call say(trim(line))
   end subroutine show_progress

end module dda_messages
