!> A task that may take a small share of a run's time, however long it takes: it waits in proportion
!> to what it cost.
module dda_rate_limiter
   use dda_kinds, only: long
   implicit none
   private
   public :: rate_limiter_type, is_due, begin_task, end_task

   !> Clock counts, but for the ratio.
   type :: rate_limiter_type
      !> times its own cost between the end of a task and the next one
      integer :: cost_ratio = 100
      integer(long) :: begun = 0, ended = 0
      integer(long) :: cost = 0    !< of the last time
   end type rate_limiter_type

contains

   !> Enough time has passed since the last time.
   logical function is_due(pace)
      type(rate_limiter_type), intent(in) :: pace
      integer(long) :: now

      call system_clock(now)
      is_due = now - pace%ended >= pace%cost_ratio*pace%cost
   end function is_due

   subroutine begin_task(pace)
      type(rate_limiter_type), intent(inout) :: pace

      call system_clock(pace%begun)
   end subroutine begin_task

   subroutine end_task(pace)
      type(rate_limiter_type), intent(inout) :: pace

      call system_clock(pace%ended)
      pace%cost = pace%ended - pace%begun
   end subroutine end_task

end module dda_rate_limiter
