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
      integer :: length

      length = 0
      if (allocated(list)) length = size(list)
      if (allocated(list) .and. length >= least) return
      allocate (larger(max(least, 2*length)), source=0)
      if (length > 0) larger(:length) = list
      call move_alloc(larger, list)
   end subroutine grow_integers

   !> Double precision.
   pure subroutine grow_reals(list, least)
      real(wp), allocatable, intent(inout) :: list(:)  !< [≥ least] kept, then 0
      integer, intent(in) :: least  !< elements needed
      real(wp), allocatable :: larger(:)
      integer :: length

      length = 0
      if (allocated(list)) length = size(list)
      if (allocated(list) .and. length >= least) return
      allocate (larger(max(least, 2*length)), source=0.0_wp)
      if (length > 0) larger(:length) = list
      call move_alloc(larger, list)
   end subroutine grow_reals

   !> Logicals.
   pure subroutine grow_logicals(list, least)
      logical, allocatable, intent(inout) :: list(:)  !< [≥ least] kept, then .false.
      integer, intent(in) :: least  !< elements needed
      logical, allocatable :: larger(:)
      integer :: length

      length = 0
      if (allocated(list)) length = size(list)
      if (allocated(list) .and. length >= least) return
      allocate (larger(max(least, 2*length)), source=.false.)
      if (length > 0) larger(:length) = list
      call move_alloc(larger, list)
   end subroutine grow_logicals

   !> Texts of one length.
   pure subroutine grow_texts(list, least)
      character(len=*), allocatable, intent(inout) :: list(:)  !< [≥ least] kept, then blank
      integer, intent(in) :: least  !< elements needed
      character(len=len(list)), allocatable :: larger(:)
      integer :: length

      length = 0
      if (allocated(list)) length = size(list)
      if (allocated(list) .and. length >= least) return
      allocate (larger(max(least, 2*length)))
      larger = ''
      if (length > 0) larger(:length) = list
      call move_alloc(larger, list)
   end subroutine grow_texts

   !> Bytes, of which there may be more than 2³¹.
   pure subroutine grow_bytes(list, least)
      integer(int8), allocatable, intent(inout) :: list(:)  !< [≥ least] kept, then 0
      integer(long), intent(in) :: least  !< elements needed
      integer(int8), allocatable :: larger(:)
      integer(long) :: length

      length = 0
      if (allocated(list)) length = size(list, kind=long)
      if (allocated(list) .and. length >= least) return
      allocate (larger(max(least, 2*length)), source=0_int8)
      if (length > 0) larger(:length) = list
      call move_alloc(larger, list)
   end subroutine grow_bytes

   !> Columns of default integers.
   pure subroutine grow_integer_columns(list, rows, least)
      integer, allocatable, intent(inout) :: list(:,:)  !< [rows, ≥ least] kept, then 0
      integer, intent(in) :: rows  !< size of a column
      integer, intent(in) :: least  !< columns needed
      integer, allocatable :: larger(:,:)
      integer :: length

      length = 0
      if (allocated(list)) length = size(list, 2)
      if (allocated(list) .and. length >= least) return
      allocate (larger(rows, max(least, 2*length)), source=0)
      if (length > 0) larger(:, :length) = list
      call move_alloc(larger, list)
   end subroutine grow_integer_columns

   !> Columns of double precision.
   pure subroutine grow_real_columns(list, rows, least)
      real(wp), allocatable, intent(inout) :: list(:,:)  !< [rows, ≥ least] kept, then 0
      integer, intent(in) :: rows  !< size of a column
      integer, intent(in) :: least  !< columns needed
      real(wp), allocatable :: larger(:,:)
      integer :: length

      length = 0
      if (allocated(list)) length = size(list, 2)
      if (allocated(list) .and. length >= least) return
      allocate (larger(rows, max(least, 2*length)), source=0.0_wp)
      if (length > 0) larger(:, :length) = list
      call move_alloc(larger, list)
   end subroutine grow_real_columns

end module dda_growth
