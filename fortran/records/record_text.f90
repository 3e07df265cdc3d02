! SPDX-License-Identifier: GPL-3.0-or-later
!> Plain columns: values with a time step given by the caller, or time and value.
!>
!> `#` and `!` begin a comment; blanks, tabs or commas separate.
!> The first line may name the columns.
module dda_record_text
   use dda_kinds, only: wp, long
   use dda_text, only: lower_case, to_text
   use dda_text_lines, only: line_reader_type, read_next_line, fail_at
   use dda_record_type, only: record_type
   use dda_record_samples, only: sample_list_type, append, read_row, max_samples
   implicit none
   private
   public :: read_text, without_comment, heading_columns

   ! largest relative difference of a step from the first step, due to rounded times
   real(wp), parameter :: even = 0.02_wp

   !> Columns read so far.
   type :: column_type
      integer :: columns = 0               ! 1 or 2, from the first line with numbers or names
      logical :: has_started = .false.     ! a line with numbers or names has been read
      real(wp) :: start = 0.0_wp           ! first time (s)
      real(wp) :: last = 0.0_wp            ! latest time (s)
      real(wp) :: step = 0.0_wp            ! first step (s)
      type(sample_list_type) :: values
   end type column_type

contains

   !> Read one or two columns; a `record%time_step` > 0 is given by the caller.
   subroutine read_text(reader, record)
      type(line_reader_type), intent(inout) :: reader        !< reader at the start of the file
      type(record_type), intent(inout) :: record  !< record, filled from the file
      type(column_type) :: column
      character(len=:), allocatable :: text
      logical :: has_line

      do
         call read_next_line(reader, text, has_line)
         if (.not. has_line) exit
         call read_line(reader, without_comment(text), column)
      end do
      call set_samples(reader, record, column)
   end subroutine read_text

   !> A line without its comment.
   pure function without_comment(text) result(data)
      character(len=*), intent(in) :: text  !< line of the file
      character(len=:), allocatable :: data

      data = text(:scan(text//'#', '#!') - 1)
   end function without_comment

   !> Read the names of the columns, or numbers.
   subroutine read_line(reader, text, column)
      type(line_reader_type), intent(inout) :: reader  !< reader of the file; receives errors
      character(len=*), intent(in) :: text  !< line of the file, without comment
      type(column_type), intent(inout) :: column  !< columns read so far

      if (text == '') return
      if (.not. column%has_started) column%columns = heading_columns(text)
      if (column%has_started .or. column%columns == 0) call add_row(reader, text, column)
      column%has_started = .true.
   end subroutine read_line

   !> Number of columns that a line names; 0 if the line is not a heading.
   !> A name does not begin like a number; units in brackets are ignored.
   pure integer function heading_columns(text) result(columns)  ! total
      character(len=*), intent(in) :: text  !< line of the file, without comment
      character(len=:), allocatable :: names
      character :: separator
      integer :: last

      columns = 0
      names = adjustl(without_brackets(text))
      separator = merge(',', ' ', index(names, ',') > 0)
      do while (names /= '')
         last = index(names//separator, separator)
         if (verify(names(:1), '+-.0123456789,') == 0 &
            .or. any(lower_case(names(:min(3, last - 1))) == ['nan', 'inf'])) then
            columns = 0
            return
         end if
         columns = columns + 1
         names = adjustl(names(min(last, len(names)) + 1:))
      end do
   end function heading_columns

   !> A text without brackets and their content, with blanks instead of tabs.
   pure function without_brackets(text) result(outside)
      character(len=*), intent(in) :: text  !< any
      character(len=:), allocatable :: outside
      integer :: i, depth

      outside = ''
      depth = 0
      do i = 1, len(text)
         if (scan(text(i:i), '([') > 0) depth = depth + 1
         if (depth == 0) outside = outside//merge(' ', text(i:i), text(i:i) == achar(9))
         if (scan(text(i:i), ')]') > 0) depth = max(0, depth - 1)
      end do
   end function without_brackets

   !> Add the numbers of a line to the column: time and value, or only the value.
   subroutine add_row(reader, text, column)
      type(line_reader_type), intent(inout) :: reader  !< reader of the file; receives errors
      character(len=*), intent(in) :: text  !< line of the file, without comment
      type(column_type), intent(inout) :: column  !< columns read so far
      type(sample_list_type) :: row

      call read_row(reader, text, .true., 2_long, &
         'more than two columns; a record has values, or times and values', row)
      if (row%count == 0) return
      if (column%columns == 0) column%columns = row%count
      if (row%count /= column%columns) call fail_at(reader, to_text(row%count)// &
         ' number(s), but earlier lines have '//to_text(column%columns))
      if (column%values%count >= max_samples) call fail_at(reader, 'more than '// &
         to_text(max_samples)//' samples are not supported')
      if (row%count == 2) call check_time(reader, row%values(1), column)
      call append(column%values, row%values(row%count))
   end subroutine add_row

   !> Check that times increase by a constant step.
   subroutine check_time(reader, time, column)
      type(line_reader_type), intent(inout) :: reader  !< reader of the file; receives errors
      real(wp), intent(in) :: time  !< time, s
      type(column_type), intent(inout) :: column  !< columns read so far
      real(wp), parameter :: largest = 1.0e9_wp              ! s
      real(wp) :: step

      if (abs(time) > largest) call fail_at(reader, 'the time '//to_text(time)// &
         ' s is beyond any record')
      step = time - column%last
      if (column%values%count == 0) column%start = time
      if (column%values%count == 1) column%step = step
      if (column%values%count >= 1 .and. step <= 0.0_wp) then
         call fail_at(reader, 'the time '//to_text(time)//' s does not follow '// &
            to_text(column%last)//' s')
      else if (column%values%count > 1 .and. abs(step - column%step) > even*column%step) then
         call fail_at(reader, 'the time '//to_text(time)//' s is '//to_text(step)// &
            ' s after the preceding time, not '//to_text(column%step)// &
            ' s; the times are not evenly spaced, or have too few digits')
      end if
      column%last = time
   end subroutine check_time

   !> Set time step and samples from the column.
   subroutine set_samples(reader, record, column)
      type(line_reader_type), intent(inout) :: reader  !< reader of the file; receives errors
      type(record_type), intent(inout) :: record  !< record, filled from the file
      type(column_type), intent(in) :: column  !< complete column of samples

      associate (count => column%values%count)
         if (count < 2) call fail_at(reader, 'the file ends after '//to_text(count)// &
            ' sample(s); at least 2 are needed')
         if (column%columns == 1 .and. record%time_step <= 0.0_wp) &
            call fail_at(reader, 'one column of values needs a time step; give time_step')
         if (allocated(reader%error)) return
         if (column%columns == 2) record%time_step = (column%last - column%start)/ &
            real(count - 1, wp)
         if (abs(column%start) > 0.0_wp) record%description = 'times in the file begin at '// &
            to_text(column%start)//' s'
         record%values = column%values%values(:count)
      end associate
   end subroutine set_samples

end module dda_record_text
