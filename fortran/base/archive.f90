! SPDX-License-Identifier: GPL-3.0-or-later
!> Serialisation of a state: one list of calls both writes it to bytes and reads it back.
!>
!> `serialise` writes a value or an array if the archive is being written, and reads it if the
!> archive is being read, so that the two directions cannot differ.  Every array is preceded by its
!> size.  The first mismatch is stored in `failure` and ends the reading.  The bytes of a
!> large state pass through a stream, since an array of them would need as much memory as the state.
module dda_archive
   use, intrinsic :: iso_c_binding, only: c_f_pointer, c_loc, c_ptr
   use, intrinsic :: iso_fortran_env, only: int8
   use dda_growth, only: grow
   use dda_kinds, only: wp, sp, long
   implicit none
   private
   public :: archive_type, archive_stream_type, write_archive, read_archive, serialise, &
      serialise_label, serialise_number, serialise_count, serialise_list, check_list, fail_archive

   integer(long), parameter :: buffer_size = 2_long**20  !< size of the buffer of a stream, bytes

   !> Stream that receives the buffer of an archive when it is full, and refills it when it is
   !> empty.
   type, abstract :: archive_stream_type
   contains
      procedure(move_bytes), deferred :: put  !< write all these bytes
      procedure(move_bytes), deferred :: get  !< read all these bytes
   end type archive_stream_type

   abstract interface
      subroutine move_bytes(self, bytes)
         import :: archive_stream_type, int8
         class(archive_stream_type), intent(inout) :: self  !< stream at its position
         integer(int8), contiguous, intent(inout) :: bytes(:)  !< [any] bytes, written or read
      end subroutine move_bytes
   end interface

   !> Serialised bytes, and the position in them.
   type :: archive_type
      logical :: reading = .false.
      integer(int8), allocatable :: bytes(:)     !< all bytes, or the buffer of the stream
      class(archive_stream_type), allocatable :: stream
      integer(long) :: at = 0                    !< number of bytes written or read
      integer(long) :: before = 0  !< number of archive bytes before the first element of `bytes`
      integer(long) :: length = 0                !< number of bytes to be read
      character(len=:), allocatable :: failure   !< reason for which reading has ended
   end type archive_type

   !> Serialise a value, an array with a known size, or a text.
   interface serialise
      module procedure serialise_integers, serialise_longs, serialise_reals, serialise_singles, &
         serialise_logicals, serialise_text
   end interface serialise

contains

   !> Begin an archive for writing; its stream, if any, is at its beginning.
   pure subroutine write_archive(archive)
      type(archive_type), intent(inout) :: archive  !< archive to be written

      archive%reading = .false.
      archive%at = 0
      archive%before = 0
      if (allocated(archive%failure)) deallocate (archive%failure)
      if (.not. allocated(archive%bytes)) allocate (archive%bytes(buffer_size))
   end subroutine write_archive

   !> Begin to read `bytes` from their start, or a stream of a given length from its position.
   pure subroutine read_archive(archive, length)
      type(archive_type), intent(inout) :: archive     !< archive to be read
      integer(long), intent(in), optional :: length    !< length of the stream, bytes

      archive%reading = .true.
      archive%at = 0
      archive%before = 0
      if (allocated(archive%failure)) deallocate (archive%failure)
      if (.not. allocated(archive%bytes)) allocate (archive%bytes(buffer_size))
      archive%length = size(archive%bytes, kind=long)
      if (.not. present(length)) return
      archive%before = -archive%length  ! the buffer contains no data of the stream
      archive%length = length
   end subroutine read_archive

   !> Record a failure, after which nothing is read; an earlier reason is retained.
   pure subroutine fail_archive(archive, reason)
      type(archive_type), intent(inout) :: archive  !< archive that is written or read
      character(len=*), intent(in) :: reason  !< reason, for messages

      if (.not. allocated(archive%failure)) archive%failure = reason
   end subroutine fail_archive

   !> Copy bytes from an address to the archive, or from the archive to the address.
   subroutine transfer_bytes(archive, address, bytes)
      type(archive_type), intent(inout) :: archive  !< archive that is written or read
      type(c_ptr), intent(in) :: address        !< address of the value
      integer(long), intent(in) :: bytes      !< bytes of the value
      integer(int8), pointer, contiguous :: value(:)
      integer(long) :: n_copied, n_part, offset

      if (archive%reading .and. bytes > archive%length - archive%at) &
         call fail_archive(archive, 'the data end too early')
      if (allocated(archive%failure) .or. bytes == 0) return
      call c_f_pointer(address, value, [bytes])
      n_copied = 0
      do while (n_copied < bytes)
         call extend_buffer(archive, bytes - n_copied)
         offset = archive%at - archive%before
         n_part = min(bytes - n_copied, size(archive%bytes, kind=long) - offset)
         if (archive%reading) then
            call copy_bytes(archive%bytes(offset + 1:offset + n_part), &
               value(n_copied + 1:n_copied + n_part))
         else
            call copy_bytes(value(n_copied + 1:n_copied + n_part), &
               archive%bytes(offset + 1:offset + n_part))
         end if
         archive%at = archive%at + n_part
         n_copied = n_copied + n_part
      end do
   end subroutine transfer_bytes

   !> Enlarge the buffer if the next position would lie beyond its end.
   subroutine extend_buffer(archive, bytes)
      type(archive_type), intent(inout) :: archive  !< archive that is written or read
      integer(long), intent(in) :: bytes           !< number of bytes that follow
      integer(long) :: offset

      offset = archive%at - archive%before
      if (.not. allocated(archive%stream)) then
         if (.not. archive%reading) call grow(archive%bytes, offset + bytes)
      else if (offset == size(archive%bytes, kind=long)) then
         if (.not. archive%reading) call archive%stream%put(archive%bytes)
         archive%before = archive%at
         if (archive%reading) call archive%stream%get(archive%bytes(:min(archive%length &
            - archive%at, size(archive%bytes, kind=long))))
      end if
   end subroutine extend_buffer

   !> Copy bytes between positions that do not overlap.
   pure subroutine copy_bytes(from, to)
      integer(int8), contiguous, intent(in) :: from(:)     !< [bytes]
      integer(int8), contiguous, intent(inout) :: to(:)    !< [bytes]

      to = from
   end subroutine copy_bytes

   !> Serialise a label between parts of the state; it is checked on reading.
   subroutine serialise_label(archive, label)
      type(archive_type), intent(inout) :: archive  !< archive that is written or read
      character(len=*), intent(in) :: label  !< label of the part that follows
      character(len=:), allocatable :: text

      text = label
      call serialise_text(archive, text)
      if (text /= label) call fail_archive(archive, label//' are missing')
   end subroutine serialise_label

   !> Serialise a number that must lie within limits.
   subroutine serialise_number(archive, value, lowest, highest)
      type(archive_type), intent(inout) :: archive  !< archive that is written or read
      integer, intent(inout) :: value  !< value, written or read
      integer, intent(in) :: lowest, highest  !< limits, included

      call serialise_integers(archive, value)
      if (value < lowest .or. value > highest) &
         call fail_archive(archive, 'a number is out of range')
      if (archive%reading .and. allocated(archive%failure)) value = lowest
   end subroutine serialise_number

   !> Serialise a count; on reading, at least as many bytes must remain in the archive.
   subroutine serialise_count(archive, count)
      type(archive_type), intent(inout) :: archive  !< archive that is written or read
      integer, intent(inout) :: count  !< count, written or read
      integer(long) :: limit

      limit = huge(count)
      if (archive%reading) limit = min(limit, archive%length - archive%at)
      call serialise_number(archive, count, 0, int(limit))
   end subroutine serialise_count

   !> Serialise the size and the bytes of an array; a size that is read must fit the array.
   subroutine serialise_array(archive, address, items, bits)
      type(archive_type), intent(inout) :: archive  !< archive that is written or read
      type(c_ptr), intent(in) :: address  !< address of the values
      integer(long), intent(in) :: items  !< items of the array
      integer, intent(in) :: bits        !< bits of an item
      integer(long), target :: bytes
      integer(long) :: expected_bytes

      expected_bytes = items*bits/8
      bytes = expected_bytes
      call transfer_bytes(archive, c_loc(bytes), storage_size(bytes, long)/8)
      if (bytes /= expected_bytes) call fail_archive(archive, 'an array has another size')
      call transfer_bytes(archive, address, expected_bytes)
   end subroutine serialise_array

   !> Serialise default integers.
   subroutine serialise_integers(archive, values)
      type(archive_type), intent(inout) :: archive  !< archive that is written or read
      integer, contiguous, target, intent(inout) :: values(..)  !< any shape, written or read

      call serialise_array(archive, c_loc(values), size(values, kind=long), storage_size(values))
   end subroutine serialise_integers

   !> Serialise 64-bit integers.
   subroutine serialise_longs(archive, values)
      type(archive_type), intent(inout) :: archive  !< archive that is written or read
      integer(long), contiguous, target, intent(inout) :: values(..)  !< any shape, written or read

      call serialise_array(archive, c_loc(values), size(values, kind=long), storage_size(values))
   end subroutine serialise_longs

   !> Serialise double-precision numbers.
   subroutine serialise_reals(archive, values)
      type(archive_type), intent(inout) :: archive  !< archive that is written or read
      real(wp), contiguous, target, intent(inout) :: values(..)  !< any shape, written or read

      call serialise_array(archive, c_loc(values), size(values, kind=long), storage_size(values))
   end subroutine serialise_reals

   !> Serialise single-precision numbers.
   subroutine serialise_singles(archive, values)
      type(archive_type), intent(inout) :: archive  !< archive that is written or read
      real(sp), contiguous, target, intent(inout) :: values(..)  !< any shape, written or read

      call serialise_array(archive, c_loc(values), size(values, kind=long), storage_size(values))
   end subroutine serialise_singles

   !> Serialise logical values.
   subroutine serialise_logicals(archive, values)
      type(archive_type), intent(inout) :: archive  !< archive that is written or read
      logical, contiguous, target, intent(inout) :: values(..)  !< any shape, written or read

      call serialise_array(archive, c_loc(values), size(values, kind=long), storage_size(values))
   end subroutine serialise_logicals

   !> Serialise a text; on reading, the text gets the length that was written.
   subroutine serialise_text(archive, text)
      type(archive_type), intent(inout) :: archive  !< archive that is written or read
      character(len=:), allocatable, intent(inout) :: text  !< text, written or read
      character(len=:), allocatable, target :: buffer
      integer :: length

      length = len(text)
      call serialise_count(archive, length)
      allocate (character(len=length) :: buffer)
      if (.not. archive%reading) buffer = text
      call transfer_bytes(archive, c_loc(buffer), int(length, long))
      text = buffer
   end subroutine serialise_text

   !> Serialise integers that must lie within limits, such as indices.
   subroutine serialise_list(archive, values, lowest, highest)
      type(archive_type), intent(inout) :: archive  !< archive that is written or read
      integer, contiguous, intent(inout) :: values(:)  !< values, written or read
      integer, intent(in) :: lowest, highest  !< limits, included

      call serialise_integers(archive, values)
      call check_list(archive, values, lowest, highest)
   end subroutine serialise_list

   !> Record a failure if indices that have been read exceed their limits.
   pure subroutine check_list(archive, values, lowest, highest)
      type(archive_type), intent(inout) :: archive  !< archive that is written or read
      integer, intent(in) :: values(:), lowest, highest  !< indices and their limits, included

      if (.not. archive%reading .or. allocated(archive%failure)) return
      if (any(values < lowest .or. values > highest)) &
         call fail_archive(archive, 'a number in a list is out of range')
   end subroutine check_list

end module dda_archive
