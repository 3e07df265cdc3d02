! SPDX-License-Identifier: GPL-3.0-or-later
!> Rate limiter for a side task, such as writing a checkpoint: the pause after the task is
!> proportional to its cost, which limits its fraction of the run time.
module dda_rate_limiter
   use dda_kinds, only: long
   implicit none
   private
   public :: rate_limiter_type, is_due, begin_task, end_task

   !> Times and pause of a task, in clock counts.
   type :: rate_limiter_type
      integer :: cost_ratio = 100  !< ratio of pause to cost
      integer(long) :: has_started = 0, ended = 0  !< start and end of the last execution
      integer(long) :: cost = 0    !< duration of the last execution
   end type rate_limiter_type

contains

   !> .true. if the pause since the last execution is over.
   pure logical function is_due(limiter, time)  ! total
      type(rate_limiter_type), intent(in) :: limiter  !< limiter of the task
      integer(long), intent(in) :: time               !< clock count

      is_due = time - limiter%ended >= limiter%cost_ratio*limiter%cost
   end function is_due

   !> Record the start of the task.
   subroutine begin_task(limiter)
      type(rate_limiter_type), intent(inout) :: limiter  !< limiter of the task

      call system_clock(limiter%has_started)
   end subroutine begin_task

   !> Record the end of the task; its cost determines the next pause.
   subroutine end_task(limiter)
      type(rate_limiter_type), intent(inout) :: limiter  !< limiter of the task

      call system_clock(limiter%ended)
      limiter%cost = limiter%ended - limiter%has_started
   end subroutine end_task

end module dda_rate_limiter
