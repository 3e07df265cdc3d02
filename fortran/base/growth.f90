!> Arrays that grow: what they hold stays, what is new is zero.
!>
!> `grow` does nothing where there is room already; else the array at least doubles, so that
!> appending n values one by one copies fewer than 2n.
module dda_growth
   use, intrinsic :: iso_fortran_env, only: int8
   use dda_kinds, only: wp, long
   implicit none
   private
   public :: grow

   !> Room for `room` values, or for `room` columns of `rows` values, in an allocatable array, which
   !> need not be allocated yet.
   interface grow
      module procedure grow_integers, grow_reals, grow_logicals, grow_texts, grow_bytes, &
         grow_integer_columns, grow_real_columns
   end interface grow

contains

   pure subroutine grow_integers(list, room)
      integer, allocatable, intent(inout) :: list(:)  !< [room or more] kept, then 0
      integer, intent(in) :: room  !< least size
      integer, allocatable :: larger(:)
      integer :: length

      length = 0
      if (allocated(list)) length = size(list)
      if (allocated(list) .and. length >= room) return
      allocate (larger(max(room, 2*length)), source=0)
      if (length > 0) larger(:length) = list
      call move_alloc(larger, list)
   end subroutine grow_integers

   pure subroutine grow_reals(list, room)
      real(wp), allocatable, intent(inout) :: list(:)  !< [room or more] kept, then 0
      integer, intent(in) :: room  !< least size
      real(wp), allocatable :: larger(:)
      integer :: length

      length = 0
      if (allocated(list)) length = size(list)
      if (allocated(list) .and. length >= room) return
      allocate (larger(max(room, 2*length)), source=0.0_wp)
      if (length > 0) larger(:length) = list
      call move_alloc(larger, list)
   end subroutine grow_reals

   pure subroutine grow_logicals(list, room)
      logical, allocatable, intent(inout) :: list(:)  !< [room or more] kept, then .false.
      integer, intent(in) :: room  !< least size
      logical, allocatable :: larger(:)
      integer :: length

      length = 0
      if (allocated(list)) length = size(list)
      if (allocated(list) .and. length >= room) return
      allocate (larger(max(room, 2*length)), source=.false.)
      if (length > 0) larger(:length) = list
      call move_alloc(larger, list)
   end subroutine grow_logicals

   pure subroutine grow_texts(list, room)
      character(len=*), allocatable, intent(inout) :: list(:)  !< [room or more] kept, then blank
      integer, intent(in) :: room  !< least size
      character(len=len(list)), allocatable :: larger(:)
      integer :: length

      length = 0
      if (allocated(list)) length = size(list)
      if (allocated(list) .and. length >= room) return
      allocate (larger(max(room, 2*length)))
      larger = ''
      if (length > 0) larger(:length) = list
      call move_alloc(larger, list)
   end subroutine grow_texts

   pure subroutine grow_bytes(list, room)
      integer(int8), allocatable, intent(inout) :: list(:)  !< [room or more] kept, then 0
      integer(long), intent(in) :: room  !< least size
      integer(int8), allocatable :: larger(:)
      integer(long) :: length

      length = 0
      if (allocated(list)) length = size(list, kind=long)
      if (allocated(list) .and. length >= room) return
      allocate (larger(max(room, 2*length)), source=0_int8)
      if (length > 0) larger(:length) = list
      call move_alloc(larger, list)
   end subroutine grow_bytes

   pure subroutine grow_integer_columns(list, rows, room)
      integer, allocatable, intent(inout) :: list(:,:)  !< [rows, room or more] kept, then 0
      integer, intent(in) :: rows  !< size of a column
      integer, intent(in) :: room  !< least number of columns
      integer, allocatable :: larger(:,:)
      integer :: length

      length = 0
      if (allocated(list)) length = size(list, 2)
      if (allocated(list) .and. length >= room) return
      allocate (larger(rows, max(room, 2*length)), source=0)
      if (length > 0) larger(:, :length) = list
      call move_alloc(larger, list)
   end subroutine grow_integer_columns

   pure subroutine grow_real_columns(list, rows, room)
      real(wp), allocatable, intent(inout) :: list(:,:)  !< [rows, room or more] kept, then 0
      integer, intent(in) :: rows  !< size of a column
      integer, intent(in) :: room  !< least number of columns
      real(wp), allocatable :: larger(:,:)
      integer :: length

      length = 0
      if (allocated(list)) length = size(list, 2)
      if (allocated(list) .and. length >= room) return
      allocate (larger(rows, max(room, 2*length)), source=0.0_wp)
      if (length > 0) larger(:, :length) = list
      call move_alloc(larger, list)
   end subroutine grow_real_columns

end module dda_growth
