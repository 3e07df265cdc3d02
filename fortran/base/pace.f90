!> A chore that may take a small share of a run's time, however long it takes: it waits in proportion to what it cost.
module dda_pace
   use dda_kinds, only: long
   implicit none
   private
   public :: pace_type, is_due, begin_chore, end_chore

   !> Clock counts, but for the patience.
   type :: pace_type
      integer :: patience = 100    !< times its own cost between the end of a chore and the next one
      integer(long) :: begun = 0, ended = 0
      integer(long) :: cost = 0    !< of the last time
   end type pace_type

contains

   !> Enough time has passed since the last time.
   logical function is_due(pace)
      type(pace_type), intent(in) :: pace
      integer(long) :: now

      call system_clock(now)
      is_due = now - pace%ended >= pace%patience*pace%cost
   end function is_due

   subroutine begin_chore(pace)
      type(pace_type), intent(inout) :: pace

      call system_clock(pace%begun)
   end subroutine begin_chore

   subroutine end_chore(pace)
      type(pace_type), intent(inout) :: pace

      call system_clock(pace%ended)
      pace%cost = pace%ended - pace%begun
   end subroutine end_chore

end module dda_pace
