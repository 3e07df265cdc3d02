! SPDX-License-Identifier: GPL-3.0-or-later
!> Insertion sort, stable: for short lists, such as the crossings of an edge.
module dda_sorting
   use dda_kinds, only: wp
   implicit none
   private
   public :: ascending_order

contains

   !> The order in which keys ascend; equal keys keep theirs.
   pure function ascending_order(key) result(order)
      real(wp), intent(in) :: key(:)  !< [any] what to sort by
      integer :: order(size(key))
      integer :: i, j

      do i = 1, size(key)
         j = i - 1
         do while (j >= 1)
            if (key(order(j)) <= key(i)) exit
            order(j + 1) = order(j)
            j = j - 1
         end do
         order(j + 1) = i
      end do
   end function ascending_order

end module dda_sorting
