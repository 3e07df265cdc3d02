! SPDX-License-Identifier: GPL-3.0-or-later
!> Operations on files that Fortran does not have: rename, exchange, remove, identity (C library).
module dda_file_system
   use, intrinsic :: iso_c_binding, only: c_char, c_int, c_int8_t, c_int16_t, c_int32_t, &
      c_int64_t, c_null_char
   use dda_kinds, only: long
   implicit none
   private
   public :: rename_file, exchange_files, remove_file, same_file, is_file, is_folder, folder_of
   public :: file_status_type, status_of, status_of_descriptor, is_same, is_special

   !> AT_FDCWD, RENAME_EXCHANGE
   integer(c_int), parameter :: working_folder = -100_c_int, exchange = 2_c_int
   !> AT_SYMLINK_NOFOLLOW, AT_EMPTY_PATH; STATX_BASIC_STATS
   integer(c_int), parameter :: not_through_links = 256_c_int, of_descriptor = 4096_c_int, &
      basic = 2047_c_int
   integer, parameter :: kinds = 61440, regular = 32768, link = 40960  !< S_IFMT, S_IFREG, S_IFLNK
   integer, parameter :: writable = 128  !< S_IWUSR

   !> Status of a file.
   type :: file_status_type
      logical :: exists = .false.
      logical :: regular = .false.  !< regular file: no folder, link, pipe or device
      logical :: link = .false.     !< symbolic link
      logical :: protected = .false. !< the owner has no permission to write it
      integer(long) :: names = 0    !< number of hard links
      integer(long) :: inode = 0, device(2) = 0
   end type file_status_type

   !> struct statx of Linux
   type, bind(c) :: statx_type
      integer(c_int32_t) :: mask, block_size
      integer(c_int64_t) :: attributes
      integer(c_int32_t) :: names, user, group
      integer(c_int16_t) :: mode, unused
      integer(c_int64_t) :: inode, size, blocks, attributes_mask
      integer(c_int8_t) :: times(64)
      integer(c_int32_t) :: special_device(2), device(2)
      integer(c_int64_t) :: reserved(14)
   end type statx_type

   interface
      integer(c_int) function c_rename(from, to) bind(c, name='rename')
         import :: c_char, c_int
         character(kind=c_char), intent(in) :: from(*), to(*)  !< paths that end in NUL
      end function c_rename

      integer(c_int) function c_renameat2(from_folder, from, to_folder, to, flags) &
         bind(c, name='renameat2')
         import :: c_char, c_int
         !> descriptors or AT_FDCWD; RENAME_…
         integer(c_int), value :: from_folder, to_folder, flags
         character(kind=c_char), intent(in) :: from(*), to(*)  !< paths that end in NUL
      end function c_renameat2

      integer(c_int) function c_unlink(path) bind(c, name='unlink')
         import :: c_char, c_int
         character(kind=c_char), intent(in) :: path(*)  !< path that ends in NUL
      end function c_unlink

      integer(c_int) function c_statx(folder, path, flags, mask, info) bind(c, name='statx')
         import :: c_char, c_int, statx_type
         integer(c_int), value :: folder, flags, mask  !< descriptor or AT_FDCWD; AT_…; STATX_…
         character(kind=c_char), intent(in) :: path(*)  !< path that ends in NUL
         type(statx_type), intent(out) :: info  !< status, valid if the function returns 0
      end function c_statx
   end interface

contains

   !> Rename a file atomically; .false. on failure.
   logical function rename_file(from, to) result(done)
      character(len=*), intent(in) :: from, to  !< paths

      done = c_rename(from//c_null_char, to//c_null_char) == 0
   end function rename_file

   !> Exchange the names of two files atomically; .false. if that is not possible.
   !> The exchange fails if a file does not exist, or if the file system has no exchange.
   logical function exchange_files(first, second) result(done)
      character(len=*), intent(in) :: first, second  !< paths

      done = c_renameat2(working_folder, first//c_null_char, working_folder, second//c_null_char, &
         exchange) == 0
   end function exchange_files

   !> Remove a file if it exists.
   subroutine remove_file(name)
      character(len=*), intent(in) :: name  !< path
      integer(c_int) :: unused

      unused = c_unlink(name//c_null_char)
   end subroutine remove_file

   !> .true. if two paths lead to the same existing file, by links of any kind.
   logical function same_file(first, second) result(same)
      character(len=*), intent(in) :: first, second  !< paths

      same = is_same(status_of(first, .true.), status_of(second, .true.))
   end function same_file

   !> .true. if two statuses belong to the same existing file.
   pure logical function is_same(first, second)
      type(file_status_type), intent(in) :: first, second  !< statuses of files

      is_same = first%exists .and. second%exists .and. first%inode == second%inode .and. &
         all(first%device == second%device)
   end function is_same

   !> Status of a file; for a symbolic link, the status of the link unless `follow` is .true.
   type(file_status_type) function status_of(name, follow) result(status)
      character(len=*), intent(in) :: name           !< path
      logical, intent(in), optional :: follow        !< follow a link to its target
      integer(c_int) :: flags
      type(statx_type) :: info

      flags = not_through_links
      if (present(follow)) flags = merge(0_c_int, flags, follow)
      if (c_statx(working_folder, name//c_null_char, flags, basic, info) == 0) &
         status = status_from(info)
   end function status_of

   !> Status of an open file.
   type(file_status_type) function status_of_descriptor(descriptor) result(status)
      integer(c_int), intent(in) :: descriptor  !< descriptor of an open file
      type(statx_type) :: info

      if (c_statx(descriptor, c_null_char, of_descriptor, basic, info) == 0) &
         status = status_from(info)
   end function status_of_descriptor

   !> Convert a statx structure of Linux to a status.
   pure type(file_status_type) function status_from(info) result(status)
      type(statx_type), intent(in) :: info  !< structure, filled by Linux

      status%exists = .true.
      status%regular = iand(int(info%mode), kinds) == regular
      status%link = iand(int(info%mode), kinds) == link
      status%protected = iand(int(info%mode), writable) == 0
      status%names = info%names
      status%inode = info%inode
      status%device = info%device
   end function status_from

   !> .true. if a name belongs to a pipe, a device, a socket or a folder; a read might never end.
   logical function is_special(name)
      character(len=*), intent(in) :: name  !< path; links are followed
      type(file_status_type) :: entry

      entry = status_of(name, follow=.true.)
      is_special = entry%exists .and. .not. entry%regular
   end function is_special

   !> .true. if a file exists.
   logical function is_file(name)
      character(len=*), intent(in) :: name  !< path

      inquire (file=name, exist=is_file)
   end function is_file

   !> .true. if a folder exists.
   logical function is_folder(name)
      character(len=*), intent(in) :: name  !< path

      inquire (file=name//'/.', exist=is_folder)
   end function is_folder

   !> Part of a path up to its last slash; '.' if it has none.
   pure function folder_of(path) result(folder)
      character(len=*), intent(in) :: path  !< path of a file
      character(len=:), allocatable :: folder

      folder = path(:index(path, '/', back=.true.))
      if (folder == '') folder = '.'
   end function folder_of

end module dda_file_system
