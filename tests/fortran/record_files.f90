! SPDX-License-Identifier: GPL-3.0-or-later
!> Files for the tests of records: paths of the data, and scratch files that tests write.
module record_files
   use testing, only: check
   implicit none
   private
   public :: data_file, loma_prieta, write_scratch, write_changed, remove_scratch, contents, &
      scratch_name

   !> the record of the project, as a name for `data_file`
   character(len=*), parameter :: loma_prieta = &
      '../../../inputs/records/LomaPrieta1989_USGS1002_APEEL2_133.smc'

   !> A blank and letters beyond ASCII: paths are bytes to the reader.
   !> in the working folder
   character(len=*), parameter :: scratch_name = 'sitedda scratch récord.txt'

contains

   !> Path of a file under `tests/data/records`; the environment says where `tests/data` is.
   function data_file(name) result(path)
      character(len=*), intent(in) :: name
      character(len=:), allocatable :: path
      integer :: length, status

      call get_environment_variable('SITEDDA_TEST_DATA', length=length, status=status)
      if (status /= 0) length = 0
      allocate (character(len=length) :: path)
      if (length > 0) call get_environment_variable('SITEDDA_TEST_DATA', path)
      path = path//'/records/'//name
   end function data_file

   !> Write bytes without conversion.
   subroutine write_scratch(bytes)
      character(len=*), intent(in) :: bytes
      integer :: unit

      open (newunit=unit, file=scratch_name, access='stream', form='unformatted', action='write', &
         status='replace')
      write (unit) bytes
      close (unit)
   end subroutine write_scratch

   !> Write bytes with another text instead of the first occurrence of `old`, which must exist.
   subroutine write_changed(bytes, old, new)
      character(len=*), intent(in) :: bytes, old, new
      integer :: at

      at = index(bytes, old)
      call check(at > 0, "the file has '"//old//"'")
      call write_scratch(bytes(:at - 1)//new//bytes(at + len(old):))
   end subroutine write_changed

   subroutine remove_scratch()
      integer :: unit, status

      open (newunit=unit, file=scratch_name, status='old', iostat=status)
      if (status == 0) close (unit, status='delete')
   end subroutine remove_scratch

   !> Return all bytes of a file; empty if it does not exist.
   function contents(path) result(bytes)
      character(len=*), intent(in) :: path
      character(len=:), allocatable :: bytes
      integer :: unit, length, status

      open (newunit=unit, file=path, access='stream', form='unformatted', action='read', &
         status='old', iostat=status)
      length = 0
      if (status == 0) inquire (unit=unit, size=length)
      allocate (character(len=length) :: bytes)
      if (status /= 0) return
      read (unit) bytes
      close (unit)
   end function contents

end module record_files
