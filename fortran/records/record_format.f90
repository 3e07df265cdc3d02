! SPDX-License-Identifier: GPL-3.0-or-later
!> Detection of the format of a record from its first lines, independent of the file name.
module dda_record_format
   use dda_kinds, only: wp
   use dda_text, only: lower_case
   use dda_text_lines, only: line_reader_type, read_next_line, rewind_lines, fail_at
   use dda_text_numbers, only: read_next_number, number_found, number_none
   use dda_record_cosmos, only: csmip_section
   use dda_record_text, only: heading_columns, without_comment
   implicit none
   private
   public :: detect_format, known_formats

   !> lists of formats for messages
   character(len=*), parameter :: names = "'smc', 'at2', 'knet', 'esm', 'cosmos', 'text'"
   character(len=*), parameter :: known_formats = "'auto', "//names
   integer, parameter :: lines_to_look_at = 60     ! a CSMIP header is 45 lines long
   integer, parameter :: at2_header = 10           ! lines in which NPTS identifies the PEER format

contains

   !> Find the format of a file; return an error if no line identifies it.
   subroutine detect_format(reader, format)
      type(line_reader_type), intent(inout) :: reader  !< reader, rewound to the start of the file
      character(len=:), allocatable, intent(out) :: format    !< 'smc', 'at2', …
      character(len=:), allocatable :: text, first
      logical :: has_line, open
      integer :: heading

      format = ''
      first = ''
      heading = 0
      open = .true.
      do while (reader%line < lines_to_look_at .and. format == '')
         call read_next_line(reader, text, has_line)
         if (.not. has_line) exit
         if (reader%line == 1) first = text
         format = identified_by(text, lower_case(text), first, reader%line)
         if (format == '' .and. open) call detect_columns(without_comment(text), heading, open, &
            format)
      end do
      call rewind_lines(reader)
      if (format /= '') return
      call read_next_line(reader, text, has_line)
      call fail_at(reader, 'the format is not recognised; name one of '//names)
   end subroutine detect_format

   !> Decide whether columns of numbers begin at this line, or after a line with their names.
   !> A line of other text excludes the format 'text'.
   subroutine detect_columns(text, heading, open, format)
      character(len=*), intent(in) :: text      !< line of the file, without comment
      integer, intent(inout) :: heading  !< number of columns named by an earlier line; 0: none
      logical, intent(inout) :: open            !< columns may still follow
      character(len=:), allocatable, intent(inout) :: format  !< receives 'text' if columns follow
      integer :: numbers

      if (text == '') return
      numbers = row_length(text)
      open = numbers == 0 .and. heading == 0 .and. heading_columns(text) > 0
      if (numbers > 0 .and. (heading == 0 .or. heading == numbers)) format = 'text'
      heading = heading_columns(text)
   end subroutine detect_columns

   !> Format identified by a line of a header; blank if none.
   pure function identified_by(text, lowered, first, line) result(format)
      !> the line; the line in lower case; the first line of the file
      character(len=*), intent(in) :: text, lowered, first
      integer, intent(in) :: line  !< number of the line
      character(len=:), allocatable :: format

      format = ''
      if (index(lowered, csmip_section) > 0) format = 'cosmos'
      if (line <= at2_header .and. index(lowered, 'npts') > 0) format = 'at2'
      ! SMC: a digit and a title, then a line with an asterisk
      if (line == 2 .and. scan(first, '0123456789') == 1 .and. index(first, ' ') == 2 &
         .and. len(first) > 2 .and. index(text, '*') == 1) format = 'smc'
      if (line > 1) return
      if (index(lowered, '(format v') > 0) format = 'cosmos'
      if (index(text, 'Origin Time') == 1) format = 'knet'
      if (index(text, 'EVENT_NAME:') == 1) format = 'esm'
   end function identified_by

   !> Count of numbers in a line; 0 if the line contains other text.
   pure integer function row_length(text) result(numbers)
      character(len=*), intent(in) :: text  !< line of the file, without comment
      real(wp) :: value
      integer :: position, state

      position = 1
      numbers = 0
      do
         call read_next_number(text, position, value, state, commas=.true.)
         if (state /= number_found) exit
         numbers = numbers + 1
      end do
      if (state /= number_none) numbers = 0
   end function row_length

end module dda_record_format
