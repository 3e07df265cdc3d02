! SPDX-License-Identifier: GPL-3.0-or-later
!> Time spent in each phase of the steps; measured only on request.
module dda_stopwatch
   use, intrinsic :: iso_fortran_env, only: int64
   use dda_kinds, only: wp
   implicit none
   private
   public :: stopwatch_type, begin_laps, record_lap, seconds_of, phase_names
   public :: phase_search, phase_detect, phase_assemble, phase_factorise, phase_solve, &
      phase_iterate, phase_update

   integer, parameter :: phase_search = 1     !< neighbour search and symbolic factorisation
   integer, parameter :: phase_detect = 2     !< contacts and their history
   integer, parameter :: phase_assemble = 3
   integer, parameter :: phase_factorise = 4
   integer, parameter :: phase_solve = 5
   integer, parameter :: phase_iterate = 6    !< open–close iteration without linear solves
   integer, parameter :: phase_update = 7     !< new state and energy audit

   character(len=*), parameter :: phase_names(7) = [character(len=9) :: 'search', 'detect', &
      'assemble', 'factorise', 'solve', 'iterate', 'update']

   !> Clock counts by phase.
   type :: stopwatch_type
      logical :: running = .false.
      integer(int64) :: since = 0                       !< clock count at the end of the last lap
      integer(int64) :: spent(size(phase_names)) = 0
   end type stopwatch_type

contains

   !> Start timing; the time since the last lap is not counted.
   subroutine begin_laps(watch)
      type(stopwatch_type), intent(inout) :: watch  !< stopwatch; ignored unless running

      if (watch%running) call system_clock(watch%since)
   end subroutine begin_laps

   !> Add the time since the last lap to a phase.
   subroutine record_lap(watch, phase)
      type(stopwatch_type), intent(inout) :: watch  !< stopwatch; ignored unless running
      integer, intent(in) :: phase                  !< one of `phase_…`
      integer(int64) :: time

      if (.not. watch%running) return
      call system_clock(time)
      watch%spent(phase) = watch%spent(phase) + (time - watch%since)
      watch%since = time
   end subroutine record_lap

   !> Seconds spent in each phase.
   function seconds_of(watch) result(seconds)
      type(stopwatch_type), intent(in) :: watch  !< stopwatch between laps
      real(wp) :: seconds(size(phase_names))
      integer(int64) :: rate

      call system_clock(count_rate=rate)
      seconds = real(watch%spent, wp)/real(rate, wp)
   end function seconds_of

end module dda_stopwatch
