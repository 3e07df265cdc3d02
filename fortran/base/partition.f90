! SPDX-License-Identifier: GPL-3.0-or-later
!> Partition of items into parts that are connected pair by pair.
module dda_partition
   implicit none
   private
   public :: join, name_parts

contains

   !> Unite the parts of two items; the smaller of the two roots becomes the common root.
   pure subroutine join(part, a, b)
      integer, intent(inout) :: part(:)  !< [items] parent, an item of the same part; root: itself
      integer, intent(in) :: a, b        !< items
      integer :: root(2), i

      root = [a, b]
      do i = 1, 2
         do while (part(root(i)) /= root(i))
            part(root(i)) = part(part(root(i)))
            root(i) = part(root(i))
         end do
      end do
      part(maxval(root)) = minval(root)
   end subroutine join

   !> Set the part of each item to the first item of the part.
   pure subroutine name_parts(part)
      integer, intent(inout) :: part(:)  !< [items] partition after the last `join`
      integer :: i

      do i = 1, size(part)
         part(i) = part(part(i))  ! a root precedes its members
      end do
   end subroutine name_parts

end module dda_partition
