!> Plain columns: values with a time step given by the caller, or time and value.
!>
!> `#` and `!` begin a comment; blanks, tabs or commas separate.
module dda_record_text
   use dda_kinds, only: wp, long
   use dda_errors, only: error_type
   use dda_text, only: to_text
   use dda_text_lines, only: line_reader_type, next_line, fail_at
   use dda_text_numbers, only: next_number, number_found, number_none
   use dda_record_type, only: record_type
   use dda_record_samples, only: sample_list_type, append, take_values, refuse_word, &
      check_time_step, most_samples
   implicit none
   private
   public :: read_text, without_comment

   ! a step may differ from the first by this part, for printed digits
   real(wp), parameter :: even = 0.02_wp

   !> The columns met so far.
   type :: column_type
      integer :: columns = 0               ! 1 or 2, from the first line with numbers
      real(wp) :: start = 0.0_wp           ! first time (s)
      real(wp) :: last = 0.0_wp            ! latest time (s)
      real(wp) :: step = 0.0_wp            ! first step (s)
      type(sample_list_type) :: values
   end type column_type

contains

   !> Read one or two columns; `record%time_step` > 0 is the caller's.
   subroutine read_text(reader, record, error)
      type(line_reader_type), intent(inout) :: reader        !< at the start of the file
      type(record_type), intent(inout) :: record  !< filled from the file
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      type(column_type) :: column
      character(len=:), allocatable :: text
      logical :: found

      do
         call next_line(reader, text, found, error)
         if (allocated(error)) return
         if (.not. found) exit
         call take_row(reader, without_comment(text), column, error)
         if (allocated(error)) return
      end do
      call finish(reader, record, column, error)
   end subroutine read_text

   !> A line up to its comment.
   pure function without_comment(text) result(data)
      character(len=*), intent(in) :: text  !< line of the file
      character(len=:), allocatable :: data

      data = text(:scan(text//'#', '#!') - 1)
   end function without_comment

   !> Add the numbers of a line to the column.
   subroutine take_row(reader, text, column, error)
      type(line_reader_type), intent(in) :: reader  !< of the file, for messages
      character(len=*), intent(in) :: text  !< line of the file
      type(column_type), intent(inout) :: column  !< of samples, so far
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      real(wp) :: row(2)
      integer :: numbers

      call read_row(reader, text, row, numbers, error)
      if (allocated(error) .or. numbers == 0) return
      if (column%columns == 0) column%columns = numbers
      if (numbers /= column%columns) then
         call fail_at(error, reader, to_text(numbers)//' number(s), but the lines above have '// &
            to_text(column%columns))
      else if (column%values%count >= most_samples) then
         call fail_at(error, reader, 'more than '//to_text(most_samples)//' samples are not read')
      else
         if (numbers == 2) call take_time(reader, row(1), column, error)
         if (.not. allocated(error)) call append(column%values, row(numbers))
      end if
   end subroutine take_row

   !> The one or two numbers of a line.
   subroutine read_row(reader, text, row, numbers, error)
      type(line_reader_type), intent(in) :: reader  !< of the file, for messages
      character(len=*), intent(in) :: text  !< line of the file
      real(wp), intent(out) :: row(2)  !< time (s) and value, or the value alone
      integer, intent(out) :: numbers  !< in the line
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      integer :: position, state
      real(wp) :: value

      row = 0.0_wp
      numbers = 0
      position = 1
      do
         call next_number(text, position, value, state, commas=.true.)
         if (state == number_none) return
         if (state /= number_found) then
            call refuse_word(reader, text, position, state, error)
            return
         end if
         if (numbers == 2) then
            call fail_at(error, reader, 'more than two columns; a record has values, or times '// &
               'and values')
            return
         end if
         numbers = numbers + 1
         row(numbers) = value
      end do
   end subroutine read_row

   !> Times must rise by one and the same step.
   subroutine take_time(reader, time, column, error)
      type(line_reader_type), intent(in) :: reader  !< of the file, for messages
      real(wp), intent(in) :: time  !< s
      type(column_type), intent(inout) :: column  !< of samples, so far
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      real(wp), parameter :: largest = 1.0e9_wp              ! s
      real(wp) :: step

      if (abs(time) > largest) then
         call fail_at(error, reader, 'the time '//to_text(time)//' s is beyond any record')
         return
      end if
      step = time - column%last
      if (column%values%count == 0) column%start = time
      if (column%values%count == 1) column%step = step
      if (column%values%count >= 1 .and. step <= 0.0_wp) then
         call fail_at(error, reader, 'the time '//to_text(time)//' s does not follow '// &
            to_text(column%last)//' s')
      else if (column%values%count > 1 .and. abs(step - column%step) > even*column%step) then
         call fail_at(error, reader, 'the time '//to_text(time)//' s comes '//to_text(step)// &
            ' s after the one above, not '//to_text(column%step)// &
            ' s: the times are not evenly spaced, or have too few digits')
      end if
      column%last = time
   end subroutine take_time

   !> Time step and samples from the column.
   subroutine finish(reader, record, column, error)
      type(line_reader_type), intent(in) :: reader  !< of the file, for messages
      type(record_type), intent(inout) :: record  !< filled from the file
      type(column_type), intent(inout) :: column  !< of samples, so far
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      real(wp) :: step
      integer :: count

      count = column%values%count
      if (count < 2) then
         call fail_at(error, reader, 'the file ends after '//to_text(count)// &
            ' sample(s); at least 2 are needed')
      else if (column%columns == 1 .and. record%time_step <= 0.0_wp) then
         call fail_at(error, reader, 'one column of values needs a time step; give time_step')
      else if (column%columns == 2) then
         step = (column%last - column%start)/real(count - 1, wp)
         call check_time_step(reader, step, error)
         record%time_step = step
         if (abs(column%start) > 0.0_wp) record%description = 'times in the file begin at '// &
            to_text(column%start)//' s'
      end if
      if (.not. allocated(error)) call take_values(column%values, record%values)
   end subroutine finish

end module dda_record_text
