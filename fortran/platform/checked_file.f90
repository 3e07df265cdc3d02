! SPDX-License-Identifier: GPL-3.0-or-later
!> An archive in a file that shows whether it is whole: a mark, the version of the format, the
!> length, and a checksum at the end.
module dda_checked_file
   use, intrinsic :: iso_fortran_env, only: int8
   use dda_kinds, only: long
   use dda_archive, only: archive_type
   use dda_byte_file, only: byte_file_type, open_file, to_read, to_overwrite, &
      size_of_file, read_bytes, write_bytes, cut_file, flush_stream, close_file
   use dda_checksum, only: checksum_type, begin_checksum, add_bytes
   use dda_errors, only: error_type, error_file, fail
   use dda_text, only: to_text
   implicit none
   private
   public :: write_checked, read_checked

   character(len=8), parameter :: mark = 'SITEDDA'//achar(26)
   integer(long), parameter :: format_version = 1
   integer, parameter :: head_bytes = 24, sum_bytes = 8

contains

   !> Write an archive over a file of that name, flushed to the disk or only to the system.
   subroutine write_checked(name, archive, to_disk, error)
      character(len=*), intent(in) :: name  !< path
      type(archive_type), intent(in) :: archive  !< written
      logical, intent(in) :: to_disk  !< else only to the system
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(byte_file_type) :: file
      integer(int8) :: head(head_bytes)

      head = transfer([transfer(mark, 0_long), format_version, archive%at], head)
      call open_file(file, name, to_overwrite, error)
      call write_bytes(file, head, error)
      call write_bytes(file, archive%bytes(:archive%at), error)
      call write_bytes(file, sum_of(head, archive%bytes(:archive%at)), error)
      call cut_file(file, head_bytes + archive%at + sum_bytes, error)
      call flush_stream(file, to_disk, error)
      call close_file(file, error)
   end subroutine write_checked

   !> Read an archive back; an error if the file is not one, is of another format, or is not whole.
   subroutine read_checked(name, archive, error)
      character(len=*), intent(in) :: name  !< path
      type(archive_type), intent(inout) :: archive  !< written or read
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(byte_file_type) :: file
      integer(int8) :: head(head_bytes), found(sum_bytes)
      integer(long) :: bytes

      call open_file(file, name, to_read, error)
      if (allocated(error)) return
      bytes = size_of_file(file) - head_bytes - sum_bytes
      if (bytes < 0) call fail(error, error_file, name//' is cut short')
      call read_bytes(file, head, error)
      if (.not. allocated(error)) call check_head(name, head, bytes, error)
      if (.not. allocated(error)) then
         if (allocated(archive%bytes)) deallocate (archive%bytes)
         allocate (archive%bytes(bytes))
         call read_bytes(file, archive%bytes, error)
         call read_bytes(file, found, error)
      end if
      if (.not. allocated(error)) then
         if (any(found /= sum_of(head, archive%bytes))) call fail(error, error_file, name// &
            ' is damaged: its checksum is wrong')
      end if
      call close_file(file, error)
   end subroutine read_checked

   !> Mark, version and length must be those of a whole file.
   subroutine check_head(name, head, bytes, error)
      character(len=*), intent(in) :: name  !< path
      integer(int8), intent(in) :: head(head_bytes)  !< of the file
      integer(long), intent(in) :: bytes  !< that the file has between its head and its checksum
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      integer(long) :: words(3)

      words = transfer(head, words)
      if (transfer(words(1), mark) /= mark) then
         call fail(error, error_file, name//' is not a checkpoint of sitedda')
      else if (words(2) /= format_version) then
         call fail(error, error_file, name//' has format '//to_text(words(2))// &
            ', this version reads '//to_text(format_version))
      else if (words(3) /= bytes) then
         call fail(error, error_file, name//' is cut short or has grown: it holds '// &
            to_text(bytes)//' bytes of '//to_text(words(3)))
      end if
   end subroutine check_head

   !> The checksum of head and content.
   pure function sum_of(head, bytes) result(sum)
      integer(int8), contiguous, intent(in) :: head(:), bytes(:)  !< [head_bytes], [bytes]
      integer(int8) :: sum(sum_bytes)
      type(checksum_type) :: checksum

      call begin_checksum(checksum)
      call add_bytes(checksum, head)
      call add_bytes(checksum, bytes)
      sum = transfer(checksum%value, sum)
   end function sum_of

end module dda_checked_file
