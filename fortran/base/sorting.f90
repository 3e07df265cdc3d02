!> Insertion sort, stable and in place: for short lists, such as the crossings of an edge.
module dda_sorting
   use dda_kinds, only: wp
   implicit none
   private
   public :: insertion_sort

contains

   !> Sort a list in ascending order.
   pure subroutine insertion_sort(list)
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
   end subroutine insertion_sort

end module dda_sorting
