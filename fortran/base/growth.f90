! SPDX-License-Identifier: GPL-3.0-or-later
!> Allocatable arrays that grow: contents are retained, new elements are zero.
!>
!> `grow` does nothing if the array is large enough; otherwise the array at least doubles, so that
!> appending n values one by one copies fewer than 2n.  On request, the array has exactly
!> the required size.  Old and new arrays exist together only while the old is copied into the new.
module dda_growth
   use, intrinsic :: iso_fortran_env, only: int8
   use dda_kinds, only: wp, long
   implicit none
   private
   public :: grow

   !> Enlarge an allocatable array to a number of elements, or of columns of `rows` elements.
   !> The array need not be allocated.
   interface grow
      module procedure grow_integers, grow_reals, grow_logicals, grow_texts, grow_bytes, &
         grow_integer_columns, grow_real_columns
   end interface grow

contains

   !> Enlarge an array of default integers.
   pure subroutine grow_integers(list, required, exactly)
      integer, allocatable, intent(inout) :: list(:)  !< [≥ least] old elements, then 0
      integer, intent(in) :: required  !< elements needed
      logical, intent(in), optional :: exactly  !< .true.: exactly this number
      integer, allocatable :: longer(:)

      if (.not. allocated(list)) allocate (list(0))
      if (size(list) >= required) return
      allocate (longer(enlarged_size(size(list), required, exactly)))
      longer(:size(list)) = list
      longer(size(list) + 1:) = 0
      call move_alloc(longer, list)
   end subroutine grow_integers

   !> Enlarge an array of double-precision numbers.
   pure subroutine grow_reals(list, required, exactly)
      real(wp), allocatable, intent(inout) :: list(:)  !< [≥ least] old elements, then 0
      integer, intent(in) :: required  !< elements needed
      logical, intent(in), optional :: exactly  !< .true.: exactly this number
      real(wp), allocatable :: longer(:)

      if (.not. allocated(list)) allocate (list(0))
      if (size(list) >= required) return
      allocate (longer(enlarged_size(size(list), required, exactly)))
      longer(:size(list)) = list
      longer(size(list) + 1:) = 0.0_wp
      call move_alloc(longer, list)
   end subroutine grow_reals

   !> Enlarge an array of logical values.
   pure subroutine grow_logicals(list, required, exactly)
      logical, allocatable, intent(inout) :: list(:)  !< [≥ least] old elements, then .false.
      integer, intent(in) :: required  !< elements needed
      logical, intent(in), optional :: exactly  !< .true.: exactly this number
      logical, allocatable :: longer(:)

      if (.not. allocated(list)) allocate (list(0))
      if (size(list) >= required) return
      allocate (longer(enlarged_size(size(list), required, exactly)))
      longer(:size(list)) = list
      longer(size(list) + 1:) = .false.
      call move_alloc(longer, list)
   end subroutine grow_logicals

   !> Enlarge an array of texts of equal length.
   pure subroutine grow_texts(list, required)
      character(len=*), allocatable, intent(inout) :: list(:)  !< [≥ least] old elements, then blank
      integer, intent(in) :: required  !< elements needed
      character(len=len(list)), allocatable :: longer(:)

      if (.not. allocated(list)) allocate (list(0))
      if (size(list) >= required) return
      allocate (longer(enlarged_size(size(list), required)))
      longer(:size(list)) = list
      longer(size(list) + 1:) = ' '
      call move_alloc(longer, list)
   end subroutine grow_texts

   !> Enlarge an array of bytes, possibly to more than 2³¹ elements.
   pure subroutine grow_bytes(list, required)
      integer(int8), allocatable, intent(inout) :: list(:)  !< [≥ least] old elements, then 0
      integer(long), intent(in) :: required  !< elements needed
      integer(int8), allocatable :: longer(:)

      if (.not. allocated(list)) allocate (list(0))
      if (size(list, kind=long) >= required) return
      allocate (longer(max(required, 2*size(list, kind=long))))
      longer(:size(list, kind=long)) = list
      longer(size(list, kind=long) + 1:) = 0_int8
      call move_alloc(longer, list)
   end subroutine grow_bytes

   !> Enlarge an array by columns of default integers.
   pure subroutine grow_integer_columns(list, rows, required, exactly)
      integer, allocatable, intent(inout) :: list(:,:)  !< [rows, ≥ least] old elements, then 0
      integer, intent(in) :: rows  !< size of a column
      integer, intent(in) :: required  !< columns needed
      logical, intent(in), optional :: exactly  !< .true.: exactly this number
      integer, allocatable :: longer(:,:)

      if (.not. allocated(list)) allocate (list(rows, 0))
      if (size(list, 2) >= required) return
      allocate (longer(rows, enlarged_size(size(list, 2), required, exactly)))
      longer(:, :size(list, 2)) = list
      longer(:, size(list, 2) + 1:) = 0
      call move_alloc(longer, list)
   end subroutine grow_integer_columns

   !> Enlarge an array by columns of double-precision numbers.
   pure subroutine grow_real_columns(list, rows, required, exactly)
      real(wp), allocatable, intent(inout) :: list(:,:)  !< [rows, ≥ least] old elements, then 0
      integer, intent(in) :: rows  !< size of a column
      integer, intent(in) :: required  !< columns needed
      logical, intent(in), optional :: exactly  !< .true.: exactly this number
      real(wp), allocatable :: longer(:,:)

      if (.not. allocated(list)) allocate (list(rows, 0))
      if (size(list, 2) >= required) return
      allocate (longer(rows, enlarged_size(size(list, 2), required, exactly)))
      longer(:, :size(list, 2)) = list
      longer(:, size(list, 2) + 1:) = 0.0_wp
      call move_alloc(longer, list)
   end subroutine grow_real_columns

   !> New size of an array that has become too small.
   pure integer function enlarged_size(present_size, required, exactly)
      integer, intent(in) :: present_size, required  !< present and required number of elements
      logical, intent(in), optional :: exactly    !< .true.: exactly this number

      enlarged_size = max(required, 2*present_size)
      if (present(exactly)) enlarged_size = merge(required, enlarged_size, exactly)
   end function enlarged_size

end module dda_growth
