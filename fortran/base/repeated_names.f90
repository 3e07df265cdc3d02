! SPDX-License-Identifier: GPL-3.0-or-later
!> Names that occur repeatedly in a list, found in linear time.
module dda_repeated_names
   use dda_kinds, only: long
   implicit none
   private
   public :: find_repeated

contains

   !> Find the first name that has occurred before, and count the other repeated names.
   pure subroutine find_repeated(names, first, n_further)
      character(len=*), intent(in) :: names(:)  !< [any] names; blank names are ignored
      integer, intent(out) :: first            !< position of the first repeated name; 0: none
      integer, intent(out) :: n_further              !< other names that appear more than once
      integer, allocatable :: slot(:)           ! open addressing, at most half full
      logical, allocatable :: is_repeated(:)     ! the name at this position is known to be repeated
      integer :: i, at

      first = 0
      n_further = -1
      allocate (slot(0:2*size(names)), source=0)
      allocate (is_repeated(size(names)), source=.false.)
      do i = 1, size(names)
         if (names(i) == '') cycle
         at = hash_slot(names(i), size(slot))
         do while (slot(at) > 0)
            if (names(slot(at)) == names(i)) exit
            at = modulo(at + 1, size(slot))
         end do
         if (slot(at) == 0) then
            slot(at) = i
         else if (.not. is_repeated(slot(at))) then
            is_repeated(slot(at)) = .true.
            n_further = n_further + 1
            if (first == 0) first = i
         end if
      end do
      n_further = max(n_further, 0)
   end subroutine find_repeated

   !> Position of a name in a hash table.
   pure integer function hash_slot(name, slots)
      character(len=*), intent(in) :: name  !< any
      integer, intent(in) :: slots          !< positions, from 0
      integer(long) :: value
      integer :: i

      value = 0
      do i = 1, len_trim(name)
         value = modulo(257*value + iachar(name(i:i)), 2147483647_long)
      end do
      hash_slot = int(modulo(value, int(slots, long)))
   end function hash_slot

end module dda_repeated_names
