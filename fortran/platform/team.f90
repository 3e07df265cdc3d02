! SPDX-License-Identifier: GPL-3.0-or-later
!> Number of threads that work together, adjusted to other programs on the processors.
!>
!> Threads of a team wait for the slowest thread in each loop.  If another program uses the
!> processor of one thread in turn, each wait may last a time slice of some milliseconds, and two
!> threads may take many times as long as one.  Linux counts the time for which a runnable thread
!> waited for a processor.  If the team loses more processors by waiting than `tolerated_loss`, it
!> is reduced to the mean number of available processors, and later enlarged again.  Results do not
!> depend on the number of threads.
module dda_team
   !$ use omp_lib, only: omp_get_max_threads, omp_set_num_threads
   use dda_kinds, only: wp, long
   use dda_text, only: short_text, to_text
   implicit none
   private
   public :: begin_team, adjust_team, largest_team, team_text

   real(wp), parameter :: check_interval = 0.3_wp  !< time between checks, many time slices, s
   real(wp), parameter :: tolerated_loss = 0.25_wp  !< mean number of processors that may be lost
   real(wp), parameter :: first_pause = 5.0_wp    !< time until all threads are tried again, s
   real(wp), parameter :: longest_pause = 64.0_wp !< limit of the pause, s; failures double it
   character(len=*), parameter :: waits = '/proc/thread-self/schedstat'

   !> Threads of this process.
   type :: team_type
      integer :: allowed_threads = 1                   !< threads that the user allows
      integer :: n_threads = 1
      integer(long) :: last_check = 0           !< clock count of the last check
      real(wp) :: last_waiting = -1.0_wp  !< total waiting time at the last check, s; < 0: unknown
      real(wp) :: pause = first_pause       !< time until all threads are tried again, s
      real(wp) :: reduced_for = 0.0_wp      !< time since the team was reduced, s
      real(wp) :: reduced_in_total = 0.0_wp  !< time with fewer threads than allowed, s
   end type team_type

   type(team_type) :: team

contains

   !> Begin with the number of threads that the user allows.
   subroutine begin_team()
      integer :: threads

      threads = 1
      !$ threads = omp_get_max_threads()
      if (threads == team%n_threads) threads = team%allowed_threads  ! reduced by an earlier run
      team = team_type()
      team%allowed_threads = threads
      call set_size(threads)
   end subroutine begin_team

   !> Largest number of threads that the team may have.
   integer function largest_team() result(threads)
      threads = team%allowed_threads
      !$ threads = max(threads, omp_get_max_threads())
   end function largest_team

   !> Adjust the team size between two iterations, at intervals.
   subroutine adjust_team()
      integer(long) :: time, rate
      real(wp) :: seconds, former_waiting

      if (team%allowed_threads == 1) return
      call system_clock(time, rate)
      seconds = real(time - team%last_check, wp)/real(rate, wp)
      if (seconds < check_interval) return
      former_waiting = team%last_waiting
      team%last_check = time
      team%last_waiting = waiting_time()
      if (former_waiting >= 0.0_wp) call resize_team((team%last_waiting - former_waiting)/seconds, &
         seconds)
   end subroutine adjust_team

   !> Set the team size by the waiting times of the last seconds.
   subroutine resize_team(waiting, seconds)
      real(wp), intent(in) :: waiting     !< mean number of processors for which the team waited
      real(wp), intent(in) :: seconds  !< time since the last check, s

      if (team%n_threads < team%allowed_threads) then
         team%reduced_for = team%reduced_for + seconds
         team%reduced_in_total = team%reduced_in_total + seconds
      end if
      if (waiting > tolerated_loss .and. team%n_threads > 1) then
         if (team%n_threads == team%allowed_threads .and. team%reduced_in_total > 0.0_wp) &
            team%pause = min(2*team%pause, longest_pause)
         call set_size(max(1, min(team%n_threads - 1, &
            int(team%n_threads - waiting + tolerated_loss))))
      else if (team%n_threads < team%allowed_threads .and. team%reduced_for > team%pause) then
         call set_size(team%allowed_threads)
      else if (team%n_threads == team%allowed_threads) then
         team%pause = first_pause
      end if
   end subroutine resize_team

   !> Set the number of threads of parallel loops.
   subroutine set_size(threads)
      integer, intent(in) :: threads  !< threads of the team

      team%n_threads = threads
      team%reduced_for = 0.0_wp
      team%last_check = 0
      team%last_waiting = -1.0_wp
      !$ call omp_set_num_threads(threads)
   end subroutine set_size

   !> Time for which the threads of the team have waited for processors since their start, s.
   real(wp) function waiting_time() result(total)
      real(wp) :: seconds

      total = 0.0_wp
      !$omp parallel private(seconds) reduction(+: total)
      seconds = thread_waiting_time()
      total = total + seconds
      !$omp end parallel
   end function waiting_time

   !> Time for which this thread has waited for a processor, s; 0 if unknown.
   real(wp) function thread_waiting_time() result(seconds)
      real(wp), parameter :: nano = 1.0e-9_wp
      integer(long) :: counts(2)  ! time on a processor, time of waiting for a processor, ns
      integer :: unit, status

      seconds = 0.0_wp
      open (newunit=unit, file=waits, status='old', action='read', iostat=status)
      if (status /= 0) return
      read (unit, *, iostat=status) counts
      close (unit)
      if (status == 0) seconds = nano*counts(2)
   end function thread_waiting_time

   !> Text on the time lost to other programs; blank if the team was never reduced.
   function team_text() result(text)
      character(len=:), allocatable :: text

      text = ''
      if (team%reduced_in_total <= 0.0_wp) return
      text = 'other programs used the processors: '//short_text(team%reduced_in_total)// &
         ' s with fewer than '//to_text(team%allowed_threads)//' threads'
   end function team_text

end module dda_team
