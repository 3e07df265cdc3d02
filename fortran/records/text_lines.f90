! SPDX-License-Identifier: GPL-3.0-or-later
!> Lines of an untrusted text file.
!>
!> Folders, images and endless lines cause an error with file name and line number.
!> Line ends of any kind, a byte-order mark and a DOS end-of-file byte are interpreted.  The reader
!> retains the first error, and returns no lines after it.
module dda_text_lines
   use dda_kinds, only: long
   use dda_errors, only: error_type, fail, error_file, error_input
   use dda_text, only: to_text
   use dda_text_file, only: read_text_file, short_path
   implicit none
   private
   public :: line_reader_type, open_lines, read_next_line, repeat_line, rewind_lines, fail_at

   integer, parameter :: longest_line = 10000  !< characters; lines of records are shorter
   integer(long), parameter :: largest_file = 268435456_long !< bytes (256 MiB)

   integer, parameter :: blank = 32  !< lowest code that is not a control character
   character, parameter :: tab = achar(9), line_feed = achar(10), form_feed = achar(12), &
      carriage_return = achar(13), dos_end = achar(26)
   character(len=*), parameter :: byte_order_mark = char(239)//char(187)//char(191)

   !> A file and the position in it.
   type :: line_reader_type
      character(len=:), allocatable :: file        !< name of the file, for messages
      type(error_type), allocatable :: error       !< first error
      integer :: line = 0                          !< number of the last returned line
      integer, private :: next = 1                 !< position of the next line in the text
      integer, private :: last = 1                 !< position of the last returned line
      character(len=:), allocatable, private :: text
   end type line_reader_type

contains

   !> Read a file, whose lines are then returned one by one.
   subroutine open_lines(reader, file)
      type(line_reader_type), intent(out) :: reader          !< reader, ready for `read_next_line`
      character(len=*), intent(in) :: file                   !< path, any bytes
      integer :: length, dos

      reader%file = trim(file)
      if (reader%file == '') then
         call fail(reader%error, error_file, 'a record needs the name of a file; the name is blank')
         return
      end if
      call read_text_file(reader%file, reader%text, largest_file, reader%error)
      if (allocated(reader%error)) return
      if (len(reader%text) == 0) call fail(reader%error, error_file, "'"//short_path(file)// &
         "' is empty")
      ! Files from DOS may end with Ctrl-Z; it marks the end only if nothing but padding follows.
      length = verify(reader%text, ' '//achar(0)//line_feed//carriage_return//dos_end, back=.true.)
      dos = index(reader%text(length + 1:), dos_end)
      if (dos > 0) reader%text = reader%text(:length + dos - 1)
   end subroutine open_lines

   !> Return the next line without its end; `found` is false at the end of the file or on error.
   subroutine read_next_line(reader, text, found)
      type(line_reader_type), intent(inout) :: reader  !< reader of the file
      character(len=:), allocatable, intent(out) :: text     !< the line
      logical, intent(out) :: found                          !< a line was found
      integer :: line_end

      text = ''
      found = .false.
      if (allocated(reader%error)) return
      if (reader%next > len(reader%text)) return
      line_end = scan(reader%text(reader%next:), line_feed//carriage_return) + reader%next - 1
      if (line_end < reader%next) line_end = len(reader%text) + 1
      text = reader%text(reader%next:min(line_end, reader%next + longest_line) - 1)
      reader%last = reader%next
      reader%next = line_end + 1
      if (reader%text(line_end:min(line_end + 1, len(reader%text))) == carriage_return//line_feed) &
         reader%next = line_end + 2
      reader%line = reader%line + 1
      if (line_end - reader%last > longest_line) call fail_at(reader, 'the line is longer than '// &
         to_text(longest_line)//' characters, so the file is not a text record')
      if (reader%line == 1 .and. index(text, byte_order_mark) == 1) &
         text = text(len(byte_order_mark) + 1:)
      call check_bytes(reader, text)
      found = .not. allocated(reader%error)
   end subroutine read_next_line

   !> Let the next call of `read_next_line` return the same line again.
   pure subroutine repeat_line(reader)
      type(line_reader_type), intent(inout) :: reader  !< reader of the file

      reader%next = reader%last
      reader%line = reader%line - 1
   end subroutine repeat_line

   !> Let the next call of `read_next_line` return the first line.
   pure subroutine rewind_lines(reader)
      type(line_reader_type), intent(inout) :: reader  !< reader of the file

      reader%next = 1
      reader%line = 0
   end subroutine rewind_lines

   !> Check that a text has no control characters except tabs and form feeds.
   pure subroutine check_bytes(reader, text)
      type(line_reader_type), intent(inout) :: reader  !< reader of the file
      character(len=*), intent(in) :: text  !< line of the file
      integer :: i

      do i = 1, len(text)
         if (ichar(text(i:i)) < blank .and. scan(text(i:i), tab//form_feed) == 0) &
            call fail_at(reader, 'the byte '//to_text(ichar(text(i:i)))// &
            ' does not occur in text; the file may be binary or UTF-16')
      end do
   end subroutine check_bytes

   !> Return an input error with file and number of the last line; an earlier error is retained.
   pure subroutine fail_at(reader, message)
      type(line_reader_type), intent(inout) :: reader  !< reader of the file; receives errors
      character(len=*), intent(in) :: message                   !< sentence without the full stop

      if (.not. allocated(reader%error)) call fail(reader%error, error_input, &
         "'"//short_path(reader%file)//"', line "//to_text(reader%line)//': '//message)
   end subroutine fail_at

end module dda_text_lines
