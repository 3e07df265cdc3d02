!> Lines of an untrusted text file.
!>
!> A file may be a folder, an image, a gigabyte on one line: every such thing is an error with a
!> file name and a line number, found before it costs more than a buffer.  Line ends of any kind,
!> a byte-order mark and a DOS end-of-file byte are taken as what they mean.
module dda_text_lines
   use dda_kinds, only: long
   use dda_errors, only: error_type, fail, error_file, error_input
   use dda_text, only: to_text, quoted
   implicit none
   private
   public :: line_reader_type, open_lines, next_line, put_back, close_lines, fail_at, longest_line

   integer, parameter :: longest_line = 10000               !< characters; longer is no record
   integer(long), parameter :: largest_file = 268435456_long !< bytes (256 MiB)
   integer, parameter :: buffer_size = 65536                !< bytes read at a time

   integer, parameter :: tab = 9, line_feed = 10, form_feed = 12, carriage_return = 13, dos_end = &
      26, blank = 32
   character(len=*), parameter :: byte_order_mark = char(239)//char(187)//char(191)

   !> An open file and the place in it.
   type :: line_reader_type
      character(len=:), allocatable :: file        !< its name, for messages
      integer :: line = 0                          !< number of the line last handed out
      integer, private :: unit = -1                !< Fortran unit, −1 when closed
      integer(long), private :: unread = 0         !< bytes not yet in the buffer
      character(len=:), allocatable, private :: buffer  !< the bytes being looked at
      integer, private :: position = 1             !< next byte in the buffer
      integer, private :: filled = 0               !< bytes in the buffer
      logical, private :: after_return = .false.   !< the last line ended with a carriage return
      logical, private :: again = .false.          !< `next_line` returns `last` once more
      character(len=:), allocatable, private :: last !< the line last handed out
   end type line_reader_type

contains

   !> Open a file for reading line by line.
   subroutine open_lines(reader, file, error)
      type(line_reader_type), intent(out) :: reader          !< ready for `next_line`
      character(len=*), intent(in) :: file                   !< path, any bytes
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      integer :: status
      character(len=200) :: reason

      reader%file = trim(file)
      if (len_trim(file) == 0) then
         call fail(error, error_file, 'a record needs the name of a file; the name is blank')
         return
      end if
      open (newunit=reader%unit, file=reader%file, access='stream', form='unformatted', &
         action='read', status='old', iostat=status, iomsg=reason)
      if (status /= 0) then
         reader%unit = -1
         call fail(error, error_file, quoted_path(file)//' cannot be opened: '//trim(reason))
         return
      end if
      inquire (unit=reader%unit, size=reader%unread)
      call check_size(reader, error)
      if (allocated(error)) call close_lines(reader)
   end subroutine open_lines

   !> A file of a size that can be read.
   subroutine check_size(reader, error)
      type(line_reader_type), intent(inout) :: reader  !< of the file
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure

      if (reader%unread <= 0) then
         call fail(error, error_file, quoted_path(reader%file)//' is empty')
      else if (reader%unread > largest_file) then
         call fail(error, error_file, quoted_path(reader%file)//' is '//to_text(reader%unread)// &
            ' bytes long; a record of more than '//to_text(largest_file)//' bytes is not read')
      else
         allocate (character(len=buffer_size) :: reader%buffer)
      end if
   end subroutine check_size

   !> Close the file; harmless if it is closed.
   subroutine close_lines(reader)
      type(line_reader_type), intent(inout) :: reader  !< of the file
      integer :: status

      ! Nothing was written, so a failing close loses nothing.
      if (reader%unit /= -1) close (reader%unit, iostat=status)
      reader%unit = -1
   end subroutine close_lines

   !> The next line without its end; `found` is false at the end of the file.
   subroutine next_line(reader, text, found, error)
      type(line_reader_type), intent(inout) :: reader  !< of the file
      character(len=:), allocatable, intent(out) :: text     !< the line
      logical, intent(out) :: found                          !< whether there was one
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      character(len=longest_line) :: line
      integer :: length

      found = .false.
      if (reader%again) then
         reader%again = .false.
         text = reader%last
         found = .true.
         return
      end if
      call gather(reader, line, length, found, error)
      if (allocated(error) .or. .not. found) then
         found = .false.
         text = ''
         return
      end if
      text = line(:length)
      if (reader%line == 1 .and. index(text, byte_order_mark) == 1) &
         text = text(len(byte_order_mark) + 1:)
      reader%last = text
   end subroutine next_line

   !> The next call of `next_line` returns the same line again.
   subroutine put_back(reader)
      type(line_reader_type), intent(inout) :: reader  !< of the file

      reader%again = allocated(reader%last)
   end subroutine put_back

   !> Collect bytes up to a line end: LF, CR LF or CR.
   subroutine gather(reader, line, length, found, error)
      type(line_reader_type), intent(inout) :: reader  !< of the file
      character(len=longest_line), intent(inout) :: line  !< its first `length` characters
      integer, intent(out) :: length  !< of the line
      logical, intent(out) :: found  !< .false. at the end of the file
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      integer :: byte

      length = 0
      found = .false.
      do
         call next_byte(reader, byte, error)
         if (allocated(error) .or. byte < 0) return
         if (byte == line_feed .and. reader%after_return) then
            reader%after_return = .false.
            cycle
         end if
         reader%after_return = byte == carriage_return
         if (.not. found) reader%line = reader%line + 1
         found = .true.
         if (byte == line_feed .or. byte == carriage_return) return
         if (byte < blank .and. byte /= tab .and. byte /= form_feed) &
            call refuse_byte(reader, byte, error)
         if (length == longest_line) call fail_at(error, reader, 'the line is longer than '// &
            to_text(longest_line)//' characters: not a text record')
         if (allocated(error)) return
         length = length + 1
         line(length:length) = achar(byte)
         if (byte >= 128) line(length:length) = char(byte)
      end do
   end subroutine gather

   !> The next byte, −1 at the end of the file.
   subroutine next_byte(reader, byte, error)
      type(line_reader_type), intent(inout) :: reader  !< of the file
      integer, intent(out) :: byte  !< 0 … 255; −1 at the end of the file
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure

      byte = -1
      if (reader%position > reader%filled) call refill(reader, error)
      if (allocated(error) .or. reader%filled == 0) return
      byte = ichar(reader%buffer(reader%position:reader%position))
      reader%position = reader%position + 1
      if (byte == dos_end .and. nothing_left(reader)) then
         reader%position = reader%filled + 1
         byte = -1
      end if
   end subroutine next_byte

   !> Files from DOS may end with a Ctrl-Z; it means the end only if nothing but filling follows.
   pure function nothing_left(reader) result(nothing)
      type(line_reader_type), intent(in) :: reader  !< of the file, for messages
      logical :: nothing
      character(len=*), parameter :: filling = ' '//achar(0)//achar(line_feed)// &
         achar(carriage_return)//achar(dos_end)

      nothing = .false.
      if (reader%unread == 0) nothing = verify(reader%buffer(reader%position:reader%filled), &
         filling) == 0
   end function nothing_left

   !> Read the next part of the file into the buffer.
   subroutine refill(reader, error)
      type(line_reader_type), intent(inout) :: reader  !< of the file
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      integer :: status
      character(len=200) :: reason

      reader%filled = int(min(reader%unread, int(buffer_size, long)))
      reader%position = 1
      if (reader%filled == 0) return
      read (reader%unit, iostat=status, iomsg=reason) reader%buffer(:reader%filled)
      if (status /= 0) then
         reader%filled = 0
         ! A folder opens like a file with some compilers and fails only here.
         call fail(error, error_file, quoted_path(reader%file)//' cannot be read: '//trim(reason))
         return
      end if
      reader%unread = reader%unread - reader%filled
   end subroutine refill

   !> The error for a byte that no text holds.
   subroutine refuse_byte(reader, byte, error)
      type(line_reader_type), intent(in) :: reader  !< of the file, for messages
      integer, intent(in) :: byte  !< 0 … 255
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure

      call fail_at(error, reader, 'the byte '//to_text(byte)// &
         ' does not occur in a text file (binary, or UTF-16?)')
   end subroutine refuse_byte

   !> An input error at the line last read, with file and line number.
   pure subroutine fail_at(error, reader, what)
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      type(line_reader_type), intent(in) :: reader  !< of the file, for messages
      character(len=*), intent(in) :: what                   !< a sentence without its full stop

      call fail(error, error_input, quoted_path(reader%file)//', line '//to_text(reader%line)// &
         ': '//what)
   end subroutine fail_at

   !> A path in quotes; of a very long one the end, which tells files apart.
   pure function quoted_path(file) result(inside)
      character(len=*), intent(in) :: file  !< path
      character(len=:), allocatable :: inside
      integer, parameter :: longest_path = 300
      integer :: length

      length = len_trim(file)
      if (length <= longest_path) then
         inside = "'"//file(:length)//"'"
      else
         inside = quoted('…'//file(length - 70:length))
      end if
   end function quoted_path

end module dda_text_lines
