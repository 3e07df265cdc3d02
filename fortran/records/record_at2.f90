!> PEER formats AT2, VT2 and DT2: four lines of header, samples.
!>
!> Reference: Pacific Earthquake Engineering Research Center, NGA ground motion database, header
!> lines `NPTS= 4000, DT= .0050 SEC` and, before 2004, `4000 0.0050 NPTS, DT`; the line above says
!> `… TIME SERIES IN UNITS OF G`.
module dda_record_at2
   use dda_kinds, only: wp, long
   use dda_errors, only: error_type
   use dda_text, only: lower_case, quoted
   use dda_text_lines, only: line_reader_type, fail_at
   use dda_text_numbers, only: next_number, number_found
   use dda_record_type, only: record_type, quantity_in
   use dda_record_units, only: unit_type, find_unit
   use dda_record_samples, only: read_trace, take_line, check_count, check_time_step, &
      first_number
   implicit none
   private
   public :: is_at2, read_at2

   integer, parameter :: most_header_lines = 10

contains

   !> Whether a header line is the one that counts the samples.
   pure function is_at2(text) result(is)
      character(len=*), intent(in) :: text  !< line of the file
      logical :: is

      is = index(lower_case(text), 'npts') > 0
   end function is_at2

   !> Read the one trace of a PEER file, in the file's unit.
   subroutine read_at2(reader, record, error)
      type(line_reader_type), intent(inout) :: reader        !< at the start of the file
      type(record_type), intent(inout) :: record  !< filled from the file
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      integer(long) :: samples

      call read_lines(reader, record, samples, error)
      if (.not. allocated(error)) call read_trace(reader, samples, 'samples', record%values, error)
   end subroutine read_at2

   !> The header, up to the line that counts the samples.
   subroutine read_lines(reader, record, samples, error)
      type(line_reader_type), intent(inout) :: reader  !< of the file
      type(record_type), intent(inout) :: record  !< filled from the file
      integer(long), intent(out) :: samples  !< declared by the header
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      character(len=:), allocatable :: text
      integer :: line

      samples = 0
      do line = 1, most_header_lines
         call take_line(reader, text, 'a header line with NPTS', error)
         if (allocated(error)) return
         call read_title(text, line, record)
         if (is_at2(text)) then
            call read_counts(reader, lower_case(text), samples, record%time_step, error)
            return
         end if
      end do
      call fail_at(error, reader, 'none of the first lines states NPTS, as a PEER header does')
   end subroutine read_lines

   !> Event and station from line 2, quantity and unit from the words of any line.
   subroutine read_title(text, line, record)
      character(len=*), intent(in) :: text  !< line of the file
      integer, intent(in) :: line  !< its number
      type(record_type), intent(inout) :: record  !< filled from the file
      character(len=*), parameter :: before_unit = 'units of '
      character(len=:), allocatable :: title, name
      type(unit_type) :: unit
      integer :: at

      if (line == 2) record%description = trim(adjustl(text))
      title = lower_case(text)
      at = index(title, before_unit)
      if (at == 0) return
      if (quantity_in(title) /= '') record%quantity = quantity_in(title)
      name = adjustl(title(at + len(before_unit):))
      ! What may follow is a full stop, a comma or more words ("G. FILTER POINTS: …").
      at = scan(name//' ', ' .,;')
      unit = find_unit(name(:at - 1))
      record%unit = trim(unit%name)
   end subroutine read_title

   !> Both styles of the line that counts; `text` in lower case.
   subroutine read_counts(reader, text, samples, time_step, error)
      type(line_reader_type), intent(in) :: reader  !< of the file, for messages
      character(len=*), intent(in) :: text  !< line of the file
      integer(long), intent(out) :: samples  !< declared by the header
      real(wp), intent(out) :: time_step  !< s
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      real(wp) :: count

      samples = 0
      time_step = 0.0_wp
      if (index(text, '=') > 0) then
         call read_named(reader, text, 'npts', count, error)
         if (.not. allocated(error)) call read_named(reader, text, 'dt', time_step, error)
      else
         call read_leading(reader, text, count, time_step, error)
      end if
      if (.not. allocated(error)) call check_count(reader, count, samples, error)
      if (.not. allocated(error)) call check_time_step(reader, time_step, error)
   end subroutine read_counts

   !> `name = number`
   subroutine read_named(reader, text, name, value, error)
      type(line_reader_type), intent(in) :: reader  !< of the file, for messages
      character(len=*), intent(in) :: text, name  !< line in lower case; 'npts' or 'dt'
      real(wp), intent(out) :: value  !< as stated
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      character(len=:), allocatable :: rest
      integer :: at

      value = 0.0_wp
      at = index(text, name)
      if (at > 0) then
         rest = adjustl(text(at + len(name):))
         if (index(rest, '=') == 1) then
            call first_number(reader, rest(2:), name, value, error)
            return
         end if
      end if
      call fail_at(error, reader, quoted(text)//" does not state '"//name//"= number'")
   end subroutine read_named

   !> `number number NPTS, DT`
   subroutine read_leading(reader, text, count, time_step, error)
      type(line_reader_type), intent(in) :: reader  !< of the file, for messages
      character(len=*), intent(in) :: text  !< line of the file
      real(wp), intent(out) :: count, time_step  !< samples; s
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      integer :: position, first, second

      position = 1
      call next_number(text, position, count, first, commas=.true.)
      call next_number(text, position, time_step, second, commas=.true.)
      if (first /= number_found .or. second /= number_found) call fail_at(error, reader, &
         quoted(text)//' does not begin with the number of samples and the time step')
   end subroutine read_leading

end module dda_record_at2
