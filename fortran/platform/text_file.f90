!> A whole text file as one string.
module dda_text_file
   use dda_errors, only: error_type, error_input, error_file, fail
   use dda_kinds, only: long
   use dda_text, only: to_text
   implicit none
   private
   public :: read_text_file

   integer(long), parameter :: largest = 1024_long**3  !< bytes

contains

   !> Read a file; it must exist, be a file, and fit in memory.
   subroutine read_text_file(file, text, error)
      character(len=*), intent(in) :: file  !< path
      character(len=:), allocatable, intent(out) :: text  !< the whole file
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      character(len=256) :: message
      integer(long) :: bytes
      integer :: unit, status
      logical :: exists

      inquire (file=file, exist=exists)
      if (.not. exists) then
         call fail(error, error_input, file//': there is no such file')
         return
      end if
      open (newunit=unit, file=file, access='stream', form='unformatted', status='old', &
         action='read', iostat=status, iomsg=message)
      if (status /= 0) then
         call fail(error, error_file, file//' cannot be read: '//trim(message))
         return
      end if
      inquire (unit=unit, size=bytes)
      if (bytes < 0 .or. bytes > largest) then
         call fail(error, error_input, file//' is not a text file, or is larger than '// &
            to_text(largest)//' bytes')
      else
         allocate (character(len=bytes) :: text)
         read (unit, iostat=status, iomsg=message) text
         if (status /= 0) call fail(error, error_file, file//' cannot be read: '//trim(message))
      end if
      close (unit, iostat=status)
   end subroutine read_text_file

end module dda_text_file
