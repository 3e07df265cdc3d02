! SPDX-License-Identifier: GPL-3.0-or-later
!> Operations on files that Fortran lacks: rename, exchange, remove, identity (C library).
module dda_file_system
   use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_int, c_null_char, c_ptr
   implicit none
   private
   public :: rename_file, exchange_files, remove_file, same_file, is_file, is_folder, folder_of

   integer, parameter :: longest_path = 4096
   !> AT_FDCWD, RENAME_EXCHANGE
   integer(c_int), parameter :: working_folder = -100_c_int, exchange = 2_c_int

   interface
      integer(c_int) function c_rename(from, to) bind(c, name='rename')
         import :: c_char, c_int
         character(kind=c_char), intent(in) :: from(*), to(*)  !< paths, ending in NUL
      end function c_rename

      integer(c_int) function c_renameat2(from_folder, from, to_folder, to, flags) &
         bind(c, name='renameat2')
         import :: c_char, c_int
         !> descriptors or AT_FDCWD; RENAME_…
         integer(c_int), value :: from_folder, to_folder, flags
         character(kind=c_char), intent(in) :: from(*), to(*)  !< paths, ending in NUL
      end function c_renameat2

      integer(c_int) function c_unlink(path) bind(c, name='unlink')
         import :: c_char, c_int
         character(kind=c_char), intent(in) :: path(*)  !< ending in NUL
      end function c_unlink

      type(c_ptr) function c_realpath(path, resolved) bind(c, name='realpath')
         import :: c_char, c_ptr
         character(kind=c_char), intent(in) :: path(*)  !< ending in NUL
         character(kind=c_char), intent(out) :: resolved(*)  !< [PATH_MAX]
      end function c_realpath
   end interface

contains

   !> Rename a file atomically; .false. on failure.
   logical function rename_file(from, to) result(done)
      character(len=*), intent(in) :: from, to  !< paths

      done = c_rename(from//c_null_char, to//c_null_char) == 0
   end function rename_file

   !> Exchange the names of two files atomically; .false. if one is not there or the file
   !> system cannot do it.
   logical function exchange_files(first, second) result(done)
      character(len=*), intent(in) :: first, second  !< paths

      done = c_renameat2(working_folder, first//c_null_char, working_folder, second//c_null_char, &
         exchange) == 0
   end function exchange_files

   !> Remove a file if it is there.
   subroutine remove_file(name)
      character(len=*), intent(in) :: name  !< path
      integer(c_int) :: unused

      unused = c_unlink(name//c_null_char)
   end subroutine remove_file

   !> Whether two paths lead to the same existing file.
   logical function same_file(first, second) result(same)
      character(len=*), intent(in) :: first, second  !< paths
      character(len=longest_path) :: first_path, second_path

      same = .false.
      if (.not. resolve(first, first_path)) return
      if (.not. resolve(second, second_path)) return
      same = first_path == second_path
   end function same_file

   !> The name without links and dots; .false. if there is no such file.
   logical function resolve(name, path) result(exists)
      character(len=*), intent(in) :: name  !< path
      character(len=longest_path), intent(out) :: path  !< absolute, without links
      integer :: length

      exists = c_associated(c_realpath(name//c_null_char, path))
      if (.not. exists) return
      length = index(path, c_null_char)
      if (length > 0) path(length:) = ''
   end function resolve

   !> Whether a file exists.
   logical function is_file(name)
      character(len=*), intent(in) :: name  !< path

      inquire (file=name, exist=is_file)
   end function is_file

   !> Whether a folder exists.
   logical function is_folder(name)
      character(len=*), intent(in) :: name  !< path

      inquire (file=name//'/.', exist=is_folder)
   end function is_folder

   !> The part of a path up to its last slash; '.' if it has none.
   pure function folder_of(path) result(folder)
      character(len=*), intent(in) :: path  !< path of a file
      character(len=:), allocatable :: folder

      folder = path(:index(path, '/', back=.true.))
      if (folder == '') folder = '.'
   end function folder_of

end module dda_file_system
