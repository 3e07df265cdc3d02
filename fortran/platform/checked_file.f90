! SPDX-License-Identifier: GPL-3.0-or-later
!> File of an archive, with data that show whether the file is complete.  It contains a mark with
!> the format version, the archive, its length, and a checksum.
module dda_checked_file
   use, intrinsic :: iso_fortran_env, only: int8
   use dda_kinds, only: long
   use dda_archive, only: archive_type, archive_stream_type, write_archive, read_archive
   use dda_byte_file, only: byte_file_type, open_file, to_read, to_overwrite, &
      size_of_file, read_bytes, write_bytes, cut_file, flush_stream, close_file
   use dda_checksum, only: checksum_type, begin_checksum, add_bytes
   use dda_errors, only: error_type, error_file, fail
   use dda_text, only: to_text
   implicit none
   private
   public :: begin_writing, end_writing, begin_reading, end_reading

   character(len=8), parameter :: mark = 'SITEDDA'//achar(26)
   integer(long), parameter :: format_version = 2
   integer, parameter :: head_bytes = 16, length_bytes = 8, sum_bytes = 8
   integer(long), parameter :: chunk = 2_long**20  !< bytes per read for the checksum

   !> An open file, and the checksum of the written bytes.
   type, extends(archive_stream_type) :: checked_stream_type
      type(byte_file_type) :: file
      type(checksum_type) :: checksum
      type(error_type), allocatable :: error  !< first error; later calls have no effect
   contains
      procedure :: put => put_bytes, get => get_bytes
   end type checked_stream_type

contains

   !> Begin to write an archive; a file of that name is overwritten.
   subroutine begin_writing(name, archive, error)
      character(len=*), intent(in) :: name  !< path
      type(archive_type), intent(inout) :: archive  !< archive to be written
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(checked_stream_type), allocatable :: stream
      integer(int8) :: head(head_bytes)

      allocate (stream)
      call open_file(stream%file, name, to_overwrite, error)
      if (allocated(error)) return
      call begin_checksum(stream%checksum)
      head = transfer([transfer(mark, 0_long), format_version], head)
      call stream%put(head)
      call move_alloc(stream, archive%stream)
      call write_archive(archive)
   end subroutine begin_writing

   !> End writing the archive; flush it to the disk or only to the system.
   subroutine end_writing(archive, to_disk, error)
      type(archive_type), intent(inout) :: archive  !< archive being written
      logical, intent(in) :: to_disk  !< flush to disk; .false.: only to the system
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer(int8) :: buffer(length_bytes)

      select type (stream => archive%stream)
       type is (checked_stream_type)
         call stream%put(archive%bytes(:archive%at - archive%before))
         buffer = transfer(archive%at, buffer)
         call stream%put(buffer)
         buffer = transfer(stream%checksum%value, buffer)
         call write_bytes(stream%file, buffer, stream%error)
         call cut_file(stream%file, head_bytes + archive%at + length_bytes + sum_bytes, &
            stream%error)
         call flush_stream(stream%file, to_disk, stream%error)
      end select
      call end_stream(archive, error)
   end subroutine end_writing

   !> Begin to read an archive; it is an error if the file is no complete archive of this format.
   subroutine begin_reading(name, archive, error)
      character(len=*), intent(in) :: name  !< path
      type(archive_type), intent(inout) :: archive  !< archive to be read
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(checked_stream_type), allocatable :: stream
      integer(int8) :: head(head_bytes)
      integer(long) :: bytes

      allocate (stream)
      call open_file(stream%file, name, to_read, error)
      if (allocated(error)) return
      bytes = size_of_file(stream%file) - head_bytes - length_bytes - sum_bytes
      if (bytes < 0) call fail(error, error_file, name//' is cut short')
      call read_bytes(stream%file, head, error)
      if (.not. allocated(error)) call check_head(name, head, error)
      if (.not. allocated(error)) call check_content(name, stream%file, head, bytes, error)
      if (allocated(error)) then
         call close_file(stream%file, error)
         return
      end if
      call move_alloc(stream, archive%stream)
      call read_archive(archive, bytes)
   end subroutine begin_reading

   !> End reading the archive.
   subroutine end_reading(archive, error)
      type(archive_type), intent(inout) :: archive  !< archive being read
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      call end_stream(archive, error)
   end subroutine end_reading

   !> Close the file of an archive and return its error.
   subroutine end_stream(archive, error)
      type(archive_type), intent(inout) :: archive  !< archive; loses its stream
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      select type (stream => archive%stream)
       type is (checked_stream_type)
         call close_file(stream%file, stream%error)
         if (.not. allocated(error)) call move_alloc(stream%error, error)
      end select
      deallocate (archive%stream)
   end subroutine end_stream

   !> Write bytes, and add them to the checksum.
   subroutine put_bytes(self, bytes)
      class(checked_stream_type), intent(inout) :: self  !< file that is open for writing
      integer(int8), contiguous, intent(inout) :: bytes(:)  !< [any] bytes, unchanged

      call add_bytes(self%checksum, bytes)
      call write_bytes(self%file, bytes, self%error)
   end subroutine put_bytes

   !> Read bytes of a file with correct checksum; zeros after an error.
   subroutine get_bytes(self, bytes)
      class(checked_stream_type), intent(inout) :: self  !< file that is open for reading
      integer(int8), contiguous, intent(inout) :: bytes(:)  !< [any]

      call read_bytes(self%file, bytes, self%error)
      if (allocated(self%error)) bytes = 0
   end subroutine get_bytes

   !> Check that a file begins with the mark and the version of this format.
   subroutine check_head(name, head, error)
      character(len=*), intent(in) :: name  !< path
      integer(int8), intent(in) :: head(head_bytes)  !< first bytes of the file
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer(long) :: fields(2)

      fields = transfer(head, fields)
      if (transfer(fields(1), mark) /= mark) then
         call fail(error, error_file, name//' is not a checkpoint of sitedda')
      else if (fields(2) /= format_version) then
         call fail(error, error_file, name//' has the format version '//to_text(fields(2))// &
            ', but this program reads version '//to_text(format_version))
      end if
   end subroutine check_head

   !> Check length and checksum, and return to the start of the archive.
   subroutine check_content(name, file, head, bytes, error)
      character(len=*), intent(in) :: name           !< path
      type(byte_file_type), intent(in) :: file       !< file, read up to its head
      integer(int8), intent(in) :: head(head_bytes)  !< first bytes of the file
      integer(long), intent(in) :: bytes             !< bytes between head and length
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer(int8), allocatable :: part(:)
      integer(int8) :: length(length_bytes), stored_sum(sum_bytes), second_head(head_bytes)
      type(checksum_type) :: checksum
      integer(long) :: remaining, n

      allocate (part(min(chunk, bytes)))
      call begin_checksum(checksum)
      call add_bytes(checksum, head)
      remaining = bytes
      do while (remaining > 0)
         n = min(chunk, remaining)
         call read_bytes(file, part(:n), error)
         call add_bytes(checksum, part(:n))
         remaining = remaining - n
      end do
      call read_bytes(file, length, error)
      call add_bytes(checksum, length)
      call read_bytes(file, stored_sum, error)
      if (allocated(error)) return
      if (transfer(length, bytes) /= bytes) then
         call fail(error, error_file, name//' is cut short or has grown')
      else if (transfer(stored_sum, bytes) /= checksum%value) then
         call fail(error, error_file, name//' is damaged, because its checksum is wrong')
      else if (size_of_file(file) > 0) then  ! size_of_file returns to the beginning
         call read_bytes(file, second_head, error)
      end if
   end subroutine check_content

end module dda_checked_file
