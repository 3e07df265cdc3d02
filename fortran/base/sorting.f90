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
      integer :: lower(size(key)/2), upper(size(key) - size(key)/2), i, k, l

      associate (half => size(lower))
         if (half == 0) then
            order = 1
            return
         end if
         lower = merged_order(key(:half))
         upper = merged_order(key(half + 1:)) + half
      end associate
      k = 1
      l = 1
      do i = 1, size(order)
         if (l > size(upper)) then
            order(i) = lower(k)
         else if (k > size(lower)) then
            order(i) = upper(l)
         else
            order(i) = merge(lower(k), upper(l), key(lower(k)) <= key(upper(l)))
         end if
         if (k <= size(lower)) then
            if (order(i) == lower(k)) then
               k = k + 1
               cycle
            end if
         end if
         l = l + 1
      end do
   end function merged_order

end module dda_sorting
