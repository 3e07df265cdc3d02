!> Insertion sort, stable and in place: for short lists, such as the neighbours of a block.
module dda_sorting
   use dda_kinds, only: wp
   implicit none
   private
   public :: insertion_sort

   !> Sort a list in ascending order.
   interface insertion_sort
      module procedure sort_integers, sort_reals
   end interface insertion_sort

contains

   pure subroutine sort_integers(list)
      integer, intent(inout) :: list(:)  !< [any] sorted
      integer :: i, j, moving

      do i = 2, size(list)
         moving = list(i)
         j = i - 1
         do while (j >= 1)
            if (list(j) <= moving) exit
            list(j + 1) = list(j)
            j = j - 1
         end do
         list(j + 1) = moving
      end do
   end subroutine sort_integers

   pure subroutine sort_reals(list)
      real(wp), intent(inout) :: list(:)  !< [any] sorted
      real(wp) :: moving
      integer :: i, j

      do i = 2, size(list)
         moving = list(i)
         j = i - 1
         do while (j >= 1)
            if (list(j) <= moving) exit
            list(j + 1) = list(j)
            j = j - 1
         end do
         list(j + 1) = moving
      end do
   end subroutine sort_reals

end module dda_sorting
