! SPDX-License-Identifier: GPL-3.0-or-later
!> Stable sorting: by insertion for short lists, such as the crossings of an edge; by merging for
!> long lists.
module dda_sorting
   use dda_kinds, only: wp
   implicit none
   private
   public :: ascending_order, merged_order

contains

   !> Order in which keys ascend; equal keys retain their order.
   pure function ascending_order(key) result(order)
      real(wp), intent(in) :: key(:)  !< [any] keys
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

   !> Order in which keys of a long list ascend, by merging.
   pure recursive function merged_order(key) result(order)
      real(wp), intent(in) :: key(:)  !< [any] keys
      integer :: order(size(key))
      integer :: first_half(size(key)/2), second_half(size(key) - size(key)/2), i, k, l

      associate (half => size(first_half))
         if (half == 0) then
            order = 1
            return
         end if
         first_half = merged_order(key(:half))
         second_half = merged_order(key(half + 1:)) + half
      end associate
      k = 1
      l = 1
      do i = 1, size(order)
         if (l > size(second_half)) then
            order(i) = first_half(k)
         else if (k > size(first_half)) then
            order(i) = second_half(l)
         else
            order(i) = merge(first_half(k), second_half(l), key(first_half(k)) <= &
               key(second_half(l)))
         end if
         if (k <= size(first_half)) then
            if (order(i) == first_half(k)) then
               k = k + 1
               cycle
            end if
         end if
         l = l + 1
      end do
   end function merged_order

end module dda_sorting
