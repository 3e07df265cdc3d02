!> Tell the format of a record by its first lines, whatever the file is called.
module dda_record_format
   use dda_kinds, only: wp
   use dda_errors, only: error_type
   use dda_text_lines, only: line_reader_type, open_lines, next_line, close_lines, fail_at
   use dda_text_numbers, only: next_number, number_found, number_none
   use dda_record_smc, only: is_smc
   use dda_record_at2, only: is_at2
   use dda_record_knet, only: is_knet
   use dda_record_esm, only: is_esm
   use dda_record_cosmos, only: is_cosmos, is_cosmos_section
   use dda_record_text, only: without_comment
   implicit none
   private
   public :: detect, known_formats

   !> for messages
   character(len=*), parameter :: known_formats = "'auto', 'smc', 'at2', 'knet', 'esm', "// &
      "'cosmos', 'text'"
   integer, parameter :: lines_to_look_at = 60     ! a CSMIP header is 45 lines long
   integer, parameter :: at2_header = 10           ! lines among which NPTS counts as PEER's

contains

   !> Find the format; it is an error if no line gives it away.
   subroutine detect(format, file, error)
      character(len=:), allocatable, intent(out) :: format    !< 'smc', 'at2', …
      character(len=*), intent(in) :: file                    !< path
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      type(line_reader_type) :: reader
      character(len=:), allocatable :: text, first
      logical :: found, begun

      format = ''
      first = ''
      begun = .false.
      call open_lines(reader, file, error)
      if (allocated(error)) return
      do while (reader%line < lines_to_look_at .and. format == '')
         call next_line(reader, text, found, error)
         if (allocated(error) .or. .not. found) exit
         if (reader%line == 1) first = text
         format = told_by(text, first, reader%line)
         ! Columns have nothing but numbers from their first line on; a title rules them out.
         if (format == '' .and. .not. begun .and. is_row(text)) format = 'text'
         begun = begun .or. without_comment(text) /= ''
      end do
      if (.not. allocated(error) .and. format == '') call fail_at(error, reader, &
         'the lines so far are of no known format; name one of '//known_formats)
      call close_lines(reader)
   end subroutine detect

   !> The format that a line of a header gives away, blank if it does not.
   pure function told_by(text, first, line) result(format)
      character(len=*), intent(in) :: text, first  !< line; first line of the file
      integer, intent(in) :: line  !< its number
      character(len=:), allocatable :: format

      format = ''
      if (is_cosmos_section(text)) format = 'cosmos'
      if (line <= at2_header .and. is_at2(text)) format = 'at2'
      if (line == 2 .and. is_smc(first, text)) format = 'smc'
      if (line > 1) return
      if (is_cosmos(text)) format = 'cosmos'
      if (is_knet(text)) format = 'knet'
      if (is_esm(text)) format = 'esm'
   end function told_by

   !> Whether a line holds numbers and nothing else.
   pure function is_row(text) result(is)
      character(len=*), intent(in) :: text  !< line of the file
      logical :: is
      character(len=:), allocatable :: data
      real(wp) :: value
      integer :: position, state

      data = without_comment(text)
      position = 1
      call next_number(data, position, value, state, commas=.true.)
      is = state == number_found
      do while (state == number_found)
         call next_number(data, position, value, state, commas=.true.)
      end do
      is = is .and. state == number_none
   end function is_row

end module dda_record_format
