! SPDX-License-Identifier: GPL-3.0-or-later
!> Header of a netCDF file of the classic format, checked before the library reads it.
!>
!> The library (4.9) divides by the size of a variable's type.  An invalid type of a damaged file
!> has the size 0 and would end the program.  The header has lists of dimensions, attributes and
!> variables (NetCDF Classic Format Specification).
module dda_classic_header
   use, intrinsic :: iso_fortran_env, only: int8
   use dda_kinds, only: long
   implicit none
   private
   public :: has_known_types

   integer(long), parameter :: size_of_type(6) = [1, 1, 2, 4, 4, 8]  !< byte, char, …, double

   !> A position in the header.
   type :: cursor_type
      integer(int8), allocatable :: bytes(:)
      integer(long) :: at = 5          !< next byte; initially after magic number and version
      integer(long) :: offset_size = 4 !< bytes of the position of a variable
      logical :: is_valid = .true.
   end type cursor_type

contains

   !> .true. if the header has all its lists, and the types of attributes and variables are valid.
   pure logical function has_known_types(bytes)
      integer(int8), intent(in) :: bytes(:)  !< bytes of the file, including the header
      type(cursor_type) :: cursor
      integer(long) :: i, n

      cursor%bytes = bytes
      if (size(bytes) >= 4) then
         if (bytes(4) == 2) cursor%offset_size = 8
         cursor%is_valid = bytes(4) == 1 .or. bytes(4) == 2
      end if
      call skip_bytes(cursor, 4_long)  ! number of records
      call begin_list(cursor, n)
      do i = 1, n
         call skip_name(cursor)
         call skip_bytes(cursor, 4_long)
      end do
      call skip_attributes(cursor)
      call begin_list(cursor, n)
      do i = 1, n
         call skip_variable(cursor)
      end do
      has_known_types = cursor%is_valid
   end function has_known_types

   !> Skip name, dimensions, attributes, type, size and position of a variable.
   pure subroutine skip_variable(cursor)
      type(cursor_type), intent(inout) :: cursor  !< at a variable; on return, behind the variable
      integer(long) :: dimensions, bytes

      call skip_name(cursor)
      call read_number(cursor, dimensions)
      call skip_bytes(cursor, 4*dimensions)
      call skip_attributes(cursor)
      call read_type(cursor, bytes)
      call skip_bytes(cursor, 4 + cursor%offset_size)
   end subroutine skip_variable

   !> Skip a list of attributes: name, type and values, padded to four bytes.
   pure subroutine skip_attributes(cursor)
      type(cursor_type), intent(inout) :: cursor  !< before a list; on return, behind the list
      integer(long) :: i, n, bytes, values

      call begin_list(cursor, n)
      do i = 1, n
         call skip_name(cursor)
         call read_type(cursor, bytes)
         call read_number(cursor, values)
         call skip_bytes(cursor, padded_size(bytes*values))
      end do
   end subroutine skip_attributes

   !> Read the kind of a list and its number of entries, at most the length of the file.
   pure subroutine begin_list(cursor, n)
      type(cursor_type), intent(inout) :: cursor  !< before a list; on return, at the first entry
      integer(long), intent(out) :: n  !< number of entries

      call skip_bytes(cursor, 4_long)
      call read_number(cursor, n)
      if (n > size(cursor%bytes)) cursor%is_valid = .false.
      if (.not. cursor%is_valid) n = 0
   end subroutine begin_list

   !> Skip a name: its length, and letters padded to four bytes.
   pure subroutine skip_name(cursor)
      type(cursor_type), intent(inout) :: cursor  !< before a name; on return, behind the name
      integer(long) :: letters

      call read_number(cursor, letters)
      call skip_bytes(cursor, padded_size(letters))
   end subroutine skip_name

   !> Read a valid type, as the bytes of a value.
   pure subroutine read_type(cursor, bytes)
      type(cursor_type), intent(inout) :: cursor  !< before a type; on return, behind the type
      integer(long), intent(out) :: bytes  !< 0 for an invalid type
      integer(long) :: kind

      bytes = 0
      call read_number(cursor, kind)
      cursor%is_valid = cursor%is_valid .and. kind >= 1 .and. kind <= size(size_of_type)
      if (cursor%is_valid) bytes = size_of_type(kind)
   end subroutine read_type

   !> Read a number of four bytes, most significant first; not negative.
   pure subroutine read_number(cursor, number)
      type(cursor_type), intent(inout) :: cursor  !< before a number; on return, behind the number
      integer(long), intent(out) :: number  !< 0 beyond the end of the file
      integer :: i

      number = 0
      call skip_bytes(cursor, 4_long)
      if (.not. cursor%is_valid) return
      do i = 4, 1, -1
         number = 256*number + modulo(int(cursor%bytes(cursor%at - i), long), 256_long)
      end do
   end subroutine read_number

   !> Skip a number of bytes, unless the file ends before.
   pure subroutine skip_bytes(cursor, bytes)
      type(cursor_type), intent(inout) :: cursor  !< cursor to move
      integer(long), intent(in) :: bytes  !< number of bytes

      cursor%is_valid = cursor%is_valid .and. cursor%at + bytes <= size(cursor%bytes) + 1
      if (cursor%is_valid) cursor%at = cursor%at + bytes
   end subroutine skip_bytes

   !> Number of bytes, padded to a multiple of four.
   pure integer(long) function padded_size(bytes)
      integer(long), intent(in) :: bytes  !< number of bytes

      padded_size = (bytes + 3)/4*4
   end function padded_size

end module dda_classic_header
