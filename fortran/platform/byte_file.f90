! SPDX-License-Identifier: GPL-3.0-or-later
!> File of bytes.  It uses the C library, which reports each failed write and can flush to the disk.
module dda_byte_file
   use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_f_pointer, c_int, c_loc, c_long, &
      c_null_char, c_null_ptr, c_ptr, c_size_t
   use, intrinsic :: iso_fortran_env, only: int8
   use dda_kinds, only: long
   use dda_errors, only: error_type, error_file, fail
   use dda_file_system, only: file_status_type, status_of, status_of_descriptor, is_same, &
      is_special, remove_file
   use dda_text, only: to_text
   implicit none
   private
   public :: byte_file_type, open_file, open_again, to_read, to_append, to_overwrite, lock_file, &
      size_of_file, is_under
   public :: write_bytes, read_bytes, go_to, cut_file, flush_stream, close_file, reserve_space, &
      flush_file, check_plain

   !> Modes of opening: read; write a new file that replaces an old one; append; overwrite an
   !> existing file from its beginning, which reuses its disk blocks (`cut_file` removes the old
   !> rest).  Links are never followed for writing.
   character(len=*), parameter :: to_read = 'rb', to_create = 'w+b', to_append = 'a+b', &
      to_overwrite = 'r+b'
   integer(c_int), parameter :: exclusive = 2_c_int, at_once = 4_c_int  !< LOCK_EX, LOCK_NB
   integer(c_int), parameter :: from_end = 2_c_int                      !< SEEK_END
   integer(c_int), parameter :: fully_buffered = 0_c_int                !< _IOFBF
   !> size of a buffer, bytes; with the 4 KiB of the C library, the main job took 3 % more time
   integer, parameter :: buffer_size = 131072

   !> An open file, and its name for messages.
   type :: byte_file_type
      character(len=:), allocatable :: name
      type(c_ptr) :: stream = c_null_ptr
      integer(int8), pointer :: buffer(:) => null()  !< buffer of the stream
   end type byte_file_type

   interface
      type(c_ptr) function c_fopen(path, mode) bind(c, name='fopen')
         import :: c_char, c_ptr
         character(kind=c_char), intent(in) :: path(*), mode(*)  !< texts that end in NUL
      end function c_fopen

      type(c_ptr) function c_fdopen(descriptor, mode) bind(c, name='fdopen')
         import :: c_char, c_int, c_ptr
         integer(c_int), value :: descriptor  !< descriptor of an open file
         character(kind=c_char), intent(in) :: mode(*)  !< text that ends in NUL
      end function c_fdopen

      integer(c_int) function c_dup(descriptor) bind(c, name='dup')
         import :: c_int
         integer(c_int), value :: descriptor  !< descriptor of an open file
      end function c_dup

      integer(c_int) function c_setvbuf(stream, buffer, mode, length) bind(c, name='setvbuf')
         import :: c_int, c_ptr, c_size_t
         type(c_ptr), value :: stream, buffer  !< FILE*; memory that remains until it is closed
         integer(c_int), value :: mode  !< _IO…
         integer(c_size_t), value :: length  !< bytes
      end function c_setvbuf

      integer(c_int) function c_fclose(stream) bind(c, name='fclose')
         import :: c_int, c_ptr
         type(c_ptr), value :: stream
      end function c_fclose

      integer(c_size_t) function c_fwrite(from, item_size, count, stream) bind(c, name='fwrite')
         import :: c_ptr, c_size_t
         type(c_ptr), value :: from, stream
         integer(c_size_t), value :: item_size, count
      end function c_fwrite

      integer(c_size_t) function c_fread(to, item_size, count, stream) bind(c, name='fread')
         import :: c_ptr, c_size_t
         type(c_ptr), value :: to, stream
         integer(c_size_t), value :: item_size, count
      end function c_fread

      integer(c_int) function c_fseek(stream, offset, origin) bind(c, name='fseek')
         import :: c_int, c_long, c_ptr
         type(c_ptr), value :: stream  !< FILE*
         integer(c_long), value :: offset  !< bytes
         integer(c_int), value :: origin  !< SEEK_…
      end function c_fseek

      integer(c_long) function c_ftell(stream) bind(c, name='ftell')
         import :: c_long, c_ptr
         type(c_ptr), value :: stream  !< FILE*
      end function c_ftell

      integer(c_int) function c_fflush(stream) bind(c, name='fflush')
         import :: c_int, c_ptr
         type(c_ptr), value :: stream
      end function c_fflush

      integer(c_int) function c_ferror(stream) bind(c, name='ferror')
         import :: c_int, c_ptr
         type(c_ptr), value :: stream
      end function c_ferror

      integer(c_int) function c_fileno(stream) bind(c, name='fileno')
         import :: c_int, c_ptr
         type(c_ptr), value :: stream
      end function c_fileno

      integer(c_int) function c_fsync(descriptor) bind(c, name='fsync')
         import :: c_int
         integer(c_int), value :: descriptor  !< descriptor of an open file
      end function c_fsync

      integer(c_int) function c_ftruncate(descriptor, length) bind(c, name='ftruncate')
         import :: c_int, c_long
         integer(c_int), value :: descriptor  !< descriptor of an open file
         integer(c_long), value :: length  !< bytes
      end function c_ftruncate

      integer(c_int) function c_posix_fallocate(descriptor, offset, length) &
         bind(c, name='posix_fallocate')
         import :: c_int, c_long
         integer(c_int), value :: descriptor  !< descriptor of an open file
         integer(c_long), value :: offset, length  !< bytes
      end function c_posix_fallocate

      integer(c_int) function c_flock(descriptor, operation) bind(c, name='flock')
         import :: c_int
         integer(c_int), value :: descriptor, operation  !< descriptor of an open file; LOCK_…
      end function c_flock

      type(c_ptr) function c_errno() bind(c, name='__errno_location')
         import :: c_ptr
      end function c_errno

      type(c_ptr) function c_strerror(number) bind(c, name='strerror')
         import :: c_int, c_ptr
         integer(c_int), value :: number  !< errno
      end function c_strerror

      integer(c_size_t) function c_strlen(text) bind(c, name='strlen')
         import :: c_ptr, c_size_t
         type(c_ptr), value :: text  !< text that ends in NUL
      end function c_strlen
   end interface

contains

   !> Open a file in a mode of fopen: `to_read`, …
   subroutine open_file(file, name, mode, error)
      type(byte_file_type), intent(out) :: file  !< opened file
      character(len=*), intent(in) :: name, mode  !< path; mode
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      type(file_status_type) :: entry
      logical :: create

      file%name = name
      if (mode == to_read) then
         if (is_special(name)) then
            call fail(error, error_file, name//' cannot be read, because it is not a regular file')
            return
         end if
         file%stream = c_fopen(name//c_null_char, mode//c_null_char)
         if (.not. c_associated(file%stream)) call fail_system(file, 'cannot be read', error)
         call add_buffer(file)
         return
      end if
      entry = status_of(name)
      call check_plain(name, entry, error)
      if (allocated(error)) return
      if (entry%names > 1 .and. mode == to_append) then
         call fail(error, error_file, name//' has another name (a hard link): '// &
            'appending would change both files; remove one, or name another output')
         return
      end if
      create = mode == to_create .or. (entry%names > 1 .and. mode == to_overwrite)
      if (entry%exists .and. create) call remove_file(name)
      if (entry%exists .and. .not. create) then
         file%stream = c_fopen(name//c_null_char, mode//c_null_char)
      else  ! x: only if the name does not exist, not even as a link
         file%stream = c_fopen(name//c_null_char, merge(mode, to_create, mode == to_append)//'x'// &
            c_null_char)
         if (c_associated(file%stream)) entry = status_of(name)  ! else errno contains the reason
      end if
      if (.not. c_associated(file%stream)) then
         call fail_system(file, 'cannot be written', error)
      else if (.not. is_same(entry, status_of_descriptor(c_fileno(file%stream)))) then
         call fail(error, error_file, name//' cannot be written, because it was replaced '// &
            'during the run')
         call close_file(file, error)
      end if
      call add_buffer(file)
   end subroutine open_file

   !> Give a stream that has just been opened a larger buffer, if there is memory for it.
   subroutine add_buffer(file)
      type(byte_file_type), intent(inout) :: file  !< file, if it is open
      integer(c_int) :: unused
      integer :: status

      if (.not. c_associated(file%stream)) return
      allocate (file%buffer(buffer_size), stat=status)
      if (status == 0) unused = c_setvbuf(file%stream, c_loc(file%buffer), fully_buffered, &
         int(buffer_size, c_size_t))
   end subroutine add_buffer

   !> Check that a file to be written or replaced is a regular file.
   subroutine check_plain(name, entry, error)
      character(len=*), intent(in) :: name            !< path
      type(file_status_type), intent(in) :: entry     !< the existing entry
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      if (allocated(error) .or. .not. entry%exists) return
      if (entry%link) then
         call fail(error, error_file, name//' is a link, and links are never overwritten; '// &
            'remove it, or name another output')
      else if (.not. entry%regular) then
         call fail(error, error_file, name//' is not a regular file and is not replaced; '// &
            'name another output')
      else if (entry%protected) then
         call fail(error, error_file, name//' is write-protected and is not replaced; '// &
            'make it writable, or name another output')
      end if
   end subroutine check_plain

   !> Open an open file again, to read it from its beginning; its name may have changed.
   subroutine open_again(file, original, error)
      type(byte_file_type), intent(out) :: file       !< opened file
      type(byte_file_type), intent(in) :: original      !< open file, flushed; not written meanwhile
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer(long) :: unused

      file%name = original%name
      file%stream = c_fdopen(c_dup(c_fileno(original%stream)), to_read//c_null_char)
      call add_buffer(file)
      if (c_associated(file%stream)) then
         unused = size_of_file(file)
      else
         call fail_system(file, 'cannot be read', error)
      end if
   end subroutine open_again

   !> .true. if a name belongs to an open file.
   logical function is_under(file, name)
      type(byte_file_type), intent(in) :: file  !< open
      character(len=*), intent(in) :: name      !< path

      is_under = is_same(status_of(name), status_of_descriptor(c_fileno(file%stream)))
   end function is_under

   !> Lock the file against other processes; .false. if another process has locked it.
   logical function lock_file(file) result(locked)
      type(byte_file_type), intent(in) :: file  !< open

      locked = c_flock(c_fileno(file%stream), ior(exclusive, at_once)) == 0
   end function lock_file

   !> Size of an open file, whose position is set to its beginning.
   integer(long) function size_of_file(file) result(bytes)
      type(byte_file_type), intent(in) :: file  !< open

      bytes = 0
      if (c_fseek(file%stream, 0_c_long, from_end) == 0) bytes = c_ftell(file%stream)
      if (c_fseek(file%stream, 0_c_long, 0_c_int) /= 0) bytes = 0
   end function size_of_file

   !> Write bytes at the position of the file.
   subroutine write_bytes(file, bytes, error)
      type(byte_file_type), intent(in) :: file  !< open
      integer(int8), contiguous, target, intent(in) :: bytes(:)  !< [bytes]
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer(c_size_t) :: length

      length = size(bytes, kind=c_size_t)
      if (allocated(error) .or. length == 0) return
      if (c_fwrite(c_loc(bytes), 1_c_size_t, length, file%stream) /= length) &
         call fail_system(file, 'cannot be written', error)
   end subroutine write_bytes

   !> Fill `bytes` from the file; it is an error if the file is too short.
   subroutine read_bytes(file, bytes, error)
      type(byte_file_type), intent(in) :: file  !< open
      integer(int8), contiguous, target, intent(inout) :: bytes(:)  !< [bytes] filled
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer(c_size_t) :: length

      length = size(bytes, kind=c_size_t)
      if (allocated(error) .or. length == 0) return
      if (c_fread(c_loc(bytes), 1_c_size_t, length, file%stream) /= length) &
         call fail(error, error_file, file%name//': the file ends too early')
   end subroutine read_bytes

   !> Set the position of a file to a number of bytes after its beginning.
   subroutine go_to(file, bytes, error)
      type(byte_file_type), intent(in) :: file  !< open
      integer(long), intent(in) :: bytes  !< position
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      if (allocated(error)) return
      if (c_fseek(file%stream, int(bytes, c_long), 0_c_int) /= 0) &
         call fail_system(file, 'cannot be read', error)
   end subroutine go_to

   !> Truncate a file that is open for writing to a length.
   subroutine cut_file(file, bytes, error)
      type(byte_file_type), intent(in) :: file  !< open
      integer(long), intent(in) :: bytes  !< size
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      call flush_stream(file, .false., error)
      if (allocated(error)) return
      if (c_ftruncate(c_fileno(file%stream), int(bytes, c_long)) /= 0) &
         call fail_system(file, 'cannot be cut', error)
   end subroutine cut_file

   !> Flush the buffer to the system or to the disk; an error also if an earlier write failed.
   !> Data in the system outlive this process; data on the disk also outlive a power failure.
   subroutine flush_stream(file, to_disk, error)
      type(byte_file_type), intent(in) :: file  !< open
      logical, intent(in) :: to_disk  !< flush to disk; .false.: only to the system
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      if (allocated(error)) return
      if (c_fflush(file%stream) /= 0) then
         call fail_system(file, 'cannot be written', error)
      else if (c_ferror(file%stream) /= 0) then
         call fail(error, error_file, file%name//' is incomplete')
      else if (to_disk) then
         if (c_fsync(c_fileno(file%stream)) /= 0) call fail_system(file, &
            'cannot be flushed to the disk', error)
      end if
   end subroutine flush_stream

   !> Close a file, also after an error.
   subroutine close_file(file, error)
      type(byte_file_type), intent(inout) :: file  !< file to close
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer(c_int) :: status

      if (.not. c_associated(file%stream)) return
      status = c_fclose(file%stream)
      file%stream = c_null_ptr
      if (associated(file%buffer)) deallocate (file%buffer)
      if (status /= 0 .and. .not. allocated(error)) call fail_system(file, 'cannot be written', &
         error)
   end subroutine close_file

   !> Create a file with disk space for its content; an old file of that name is replaced.
   subroutine reserve_space(name, bytes, error)
      character(len=*), intent(in) :: name  !< path
      integer(long), intent(in) :: bytes  !< size
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(byte_file_type) :: file
      integer(c_int) :: status

      call open_file(file, name, to_create, error)
      if (allocated(error)) return
      status = c_posix_fallocate(c_fileno(file%stream), 0_c_long, int(bytes, c_long))
      if (status /= 0) call fail(error, error_file, name//': there is no space for '// &
         to_text(bytes)//' bytes: '//system_message(status))
      call close_file(file, error)
   end subroutine reserve_space

   !> Flush a closed file to the disk.
   subroutine flush_file(name, error)
      character(len=*), intent(in) :: name  !< path
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(byte_file_type) :: file

      call open_file(file, name, to_overwrite, error)
      call flush_stream(file, .true., error)
      call close_file(file, error)
   end subroutine flush_file

   !> Return the error of a failed call, with the reason given by the system.
   subroutine fail_system(file, failure, error)
      type(byte_file_type), intent(in) :: file  !< open
      character(len=*), intent(in) :: failure  !< the failed action: 'cannot be read', …
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer(c_int), pointer :: number

      call c_f_pointer(c_errno(), number)
      call fail(error, error_file, file%name//' '//failure//': '//system_message(number))
   end subroutine fail_system

   !> Text of an error number.
   function system_message(number) result(text)
      integer(c_int), intent(in) :: number  !< errno
      character(len=:), allocatable :: text
      character(kind=c_char), pointer :: letter(:)
      type(c_ptr) :: message

      message = c_strerror(number)
      call c_f_pointer(message, letter, [c_strlen(message)])
      text = transfer(letter, repeat(' ', size(letter)))
   end function system_message

end module dda_byte_file
