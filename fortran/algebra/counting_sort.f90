! SPDX-License-Identifier: GPL-3.0-or-later
!> Sorting by small integer keys, in linear time.
module dda_counting_sort
   implicit none
   private
   public :: sort_by_key

contains

   !> List items by ascending key; items with equal keys retain their order.
   pure subroutine sort_by_key(n, key, start, order)
      integer, intent(in) :: n                       !< largest key
      integer, intent(in) :: key(:)                  !< [items] keys, 1 … n
      integer, allocatable, intent(out) :: start(:)  !< [n+1] start of each key in `order`
      integer, allocatable, intent(out) :: order(:)  !< [items] item numbers sorted by key
      integer :: next(n), i

      allocate (start(n + 1), source=0)
      allocate (order(size(key)))
      do i = 1, size(key)
         start(key(i) + 1) = start(key(i) + 1) + 1
      end do
      start(1) = 1
      do i = 1, n
         start(i + 1) = start(i) + start(i + 1)
      end do
      next = start(:n)
      do i = 1, size(key)
         order(next(key(i))) = i
         next(key(i)) = next(key(i)) + 1
      end do
   end subroutine sort_by_key

end module dda_counting_sort
