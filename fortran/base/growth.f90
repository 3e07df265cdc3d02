!> Allocatable arrays that grow: contents are kept, new elements are zero.
!>
!> `grow` does nothing if the array is large enough; else the array at least doubles, so that
!> appending n values one by one copies fewer than 2n.
module dda_growth
   use, intrinsic :: iso_fortran_env, only: int8
   use dda_kinds, only: wp, long
   implicit none
   private
   public :: grow

   !> At least so many elements, or columns of `rows` elements, in an allocatable array, which need
   !> not be allocated yet.
   interface grow
      module procedure grow_integers, grow_reals, grow_logicals, grow_texts, grow_bytes, &
         grow_integer_columns, grow_real_columns
   end interface grow

contains

   !> Default integers.
   pure subroutine grow_integers(list, least)
      integer, allocatable, intent(inout) :: list(:)  !< [≥ least] kept, then 0
      integer, intent(in) :: least  !< elements needed
      integer, allocatable :: larger(:)

      if (.not. allocated(list)) allocate (list(0))
      if (size(list) >= least) return
      allocate (larger(max(least, 2*size(list))), source=0)
      larger(:size(list)) = list
      call move_alloc(larger, list)
   end subroutine grow_integers

   !> Double precision.
   pure subroutine grow_reals(list, least)
      real(wp), allocatable, intent(inout) :: list(:)  !< [≥ least] kept, then 0
      integer, intent(in) :: least  !< elements needed
      real(wp), allocatable :: larger(:)

      if (.not. allocated(list)) allocate (list(0))
      if (size(list) >= least) return
      allocate (larger(max(least, 2*size(list))), source=0.0_wp)
      larger(:size(list)) = list
      call move_alloc(larger, list)
   end subroutine grow_reals

   !> Logicals.
   pure subroutine grow_logicals(list, least)
      logical, allocatable, intent(inout) :: list(:)  !< [≥ least] kept, then .false.
      integer, intent(in) :: least  !< elements needed
      logical, allocatable :: larger(:)

      if (.not. allocated(list)) allocate (list(0))
      if (size(list) >= least) return
      allocate (larger(max(least, 2*size(list))), source=.false.)
      larger(:size(list)) = list
      call move_alloc(larger, list)
   end subroutine grow_logicals

   !> Texts of one length.
   pure subroutine grow_texts(list, least)
      character(len=*), allocatable, intent(inout) :: list(:)  !< [≥ least] kept, then blank
      integer, intent(in) :: least  !< elements needed
      character(len=len(list)), allocatable :: larger(:)

      if (.not. allocated(list)) allocate (list(0))
      if (size(list) >= least) return
      allocate (larger(max(least, 2*size(list))))
      larger = ''
      larger(:size(list)) = list
      call move_alloc(larger, list)
   end subroutine grow_texts

   !> Bytes, of which there may be more than 2³¹.
   pure subroutine grow_bytes(list, least)
      integer(int8), allocatable, intent(inout) :: list(:)  !< [≥ least] kept, then 0
      integer(long), intent(in) :: least  !< elements needed
      integer(int8), allocatable :: larger(:)

      if (.not. allocated(list)) allocate (list(0))
      if (size(list, kind=long) >= least) return
      allocate (larger(max(least, 2*size(list, kind=long))), source=0_int8)
      larger(:size(list, kind=long)) = list
      call move_alloc(larger, list)
   end subroutine grow_bytes

   !> Columns of default integers.
   pure subroutine grow_integer_columns(list, rows, least)
      integer, allocatable, intent(inout) :: list(:,:)  !< [rows, ≥ least] kept, then 0
      integer, intent(in) :: rows  !< size of a column
      integer, intent(in) :: least  !< columns needed
      integer, allocatable :: larger(:,:)

      if (.not. allocated(list)) allocate (list(rows, 0))
      if (size(list, 2) >= least) return
      allocate (larger(rows, max(least, 2*size(list, 2))), source=0)
      larger(:, :size(list, 2)) = list
      call move_alloc(larger, list)
   end subroutine grow_integer_columns

   !> Columns of double precision.
   pure subroutine grow_real_columns(list, rows, least)
      real(wp), allocatable, intent(inout) :: list(:,:)  !< [rows, ≥ least] kept, then 0
      integer, intent(in) :: rows  !< size of a column
      integer, intent(in) :: least  !< columns needed
      real(wp), allocatable :: larger(:,:)

      if (.not. allocated(list)) allocate (list(rows, 0))
      if (size(list, 2) >= least) return
      allocate (larger(rows, max(least, 2*size(list, 2))), source=0.0_wp)
      larger(:, :size(list, 2)) = list
      call move_alloc(larger, list)
   end subroutine grow_real_columns

end module dda_growth
