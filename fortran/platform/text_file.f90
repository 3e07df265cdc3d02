! SPDX-License-Identifier: GPL-3.0-or-later
!> A complete text file as one string.
module dda_text_file
   use dda_errors, only: error_type, error_input, error_file, fail
   use dda_file_system, only: is_special
   use dda_kinds, only: long
   use dda_text, only: to_text
   implicit none
   private
   public :: read_text_file, short_path

contains

   !> Read a file, which must exist, be regular and not exceed the largest size.
   subroutine read_text_file(file, text, largest, error)
      character(len=*), intent(in) :: file  !< path
      character(len=:), allocatable, intent(out) :: text  !< the whole file
      integer(long), intent(in) :: largest  !< largest number of bytes that are read
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      character(len=256) :: message
      integer(long) :: bytes
      integer :: unit, status
      logical :: exists

      inquire (file=file, exist=exists)
      if (.not. exists) then
         call fail(error, error_input, short_path(file)//': there is no such file')
         return
      end if
      if (is_special(file)) then
         call fail(error, error_file, short_path(file)//' cannot be read, because it is not a '// &
            'regular file')
         return
      end if
      open (newunit=unit, file=file, access='stream', form='unformatted', status='old', &
         action='read', iostat=status, iomsg=message)
      if (status == 0) then
         inquire (unit=unit, size=bytes)
         if (bytes < 0 .or. bytes > largest) then
            call fail(error, error_input, short_path(file)//' is not a text file, or is '// &
               'larger than '//to_text(largest)//' bytes: it is '//to_text(bytes)//' bytes long')
         else
            allocate (character(len=bytes) :: text)
            read (unit, iostat=status, iomsg=message) text
         end if
         close (unit)
      end if
      if (status /= 0) call fail(error, error_file, short_path(file)//' cannot be read: '// &
         trim(message))
   end subroutine read_text_file

   !> Path for messages; a very long path is reduced to its end, which distinguishes files.
   pure function short_path(file) result(short)
      character(len=*), intent(in) :: file  !< path
      character(len=:), allocatable :: short
      integer, parameter :: longest_path = 300

      short = trim(file)
      if (len(short) > longest_path) short = '…'//short(len(short) - 70:)
   end function short_path

end module dda_text_file
