! SPDX-License-Identifier: GPL-3.0-or-later
!> Files that may be replaced: regular files that begin like files of this program.
module dda_own_file
   use, intrinsic :: iso_fortran_env, only: int8
   use dda_kinds, only: long
   use dda_byte_file, only: byte_file_type, open_file, to_read, size_of_file, read_bytes, &
      close_file, check_plain
   use dda_errors, only: error_type, error_file, fail
   use dda_file_system, only: file_status_type, status_of, remove_file
   implicit none
   private
   public :: own_kind_type, netcdf_file, checkpoint_file, journal_file, check_replaceable, &
      remove_own

   integer, parameter :: mark_length = 16

   !> A kind of file, identified by its first bytes.
   type :: own_kind_type
      character(len=24) :: name        !< name of the kind for messages
      character(len=mark_length) :: mark(4)  !< possible first bytes; blank: unused
   end type own_kind_type

   type(own_kind_type), parameter :: netcdf_file = own_kind_type('a netCDF file', &
      [character(len=mark_length) :: achar(137)//'HDF'//achar(13)//achar(10)//achar(26)// &
      achar(10), 'CDF'//achar(1), 'CDF'//achar(2), 'CDF'//achar(5)])
   type(own_kind_type), parameter :: checkpoint_file = own_kind_type('a checkpoint', &
      [character(len=mark_length) :: 'SITEDDA'//achar(26), '', '', ''])
   !> First row of a journal: a sample without contacts, numbers 1 and 0.
   type(own_kind_type), parameter :: journal_file = own_kind_type('a journal', &
      [character(len=mark_length) :: repeat(achar(0), 6)//achar(240)//achar(63)// &
      repeat(achar(0), 8), '', '', ''])

contains

   !> Return an error if the file of a name must not be replaced.
   subroutine check_replaceable(name, kind, error)
      character(len=*), intent(in) :: name     !< path
      type(own_kind_type), intent(in) :: kind  !< kind of a file that may be replaced
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(file_status_type) :: entry

      if (allocated(error)) return
      entry = status_of(name)
      if (.not. entry%exists) return
      call check_plain(name, entry, error)
      if (allocated(error)) return
      if (begins_as(name, kind, error)) return
      if (.not. allocated(error)) call fail(error, error_file, name//' exists and is not '// &
         trim(kind%name)//' of an earlier run, so it is not replaced; move it away, or name '// &
         'another output')
   end subroutine check_replaceable

   !> Remove a file if it is of a given kind.
   subroutine remove_own(name, kind)
      character(len=*), intent(in) :: name     !< path
      type(own_kind_type), intent(in) :: kind  !< kind of a file that may be removed
      type(error_type), allocatable :: failure
      type(file_status_type) :: entry

      entry = status_of(name)
      if (.not. entry%regular) return
      if (begins_as(name, kind, failure)) call remove_file(name)
   end subroutine remove_own

   !> .true. if a file begins like files of a kind.
   !> An empty file, or a file of zeros whose content never reached the disk, may be of any kind.
   logical function begins_as(name, kind, error)
      character(len=*), intent(in) :: name     !< path of a regular file
      type(own_kind_type), intent(in) :: kind  !< kind of file
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(byte_file_type) :: file
      integer(int8), allocatable :: bytes(:)
      character(len=mark_length) :: head
      integer :: i, n

      begins_as = .false.
      call open_file(file, name, to_read, error)
      if (allocated(error)) return
      allocate (bytes(min(int(mark_length, long), size_of_file(file))))
      call read_bytes(file, bytes, error)
      call close_file(file, error)
      if (allocated(error)) return
      begins_as = all(bytes == 0)
      head = transfer(bytes, head)
      do i = 1, size(kind%mark)
         n = min(len_trim(kind%mark(i)), size(bytes))
         if (n > 0) begins_as = begins_as .or. head(:n) == kind%mark(i)(:n)
      end do
   end function begins_as

end module dda_own_file
