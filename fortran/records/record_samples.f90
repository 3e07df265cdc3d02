! SPDX-License-Identifier: GPL-3.0-or-later
!> Samples and header numbers of a record file.
!>
!> Memory is allocated for the content of the file, not for the size that its header declares.
module dda_record_samples
   use dda_growth, only: grow
   use dda_kinds, only: wp, long
   use dda_text, only: lower_case, to_text, quoted
   use dda_text_lines, only: line_reader_type, read_next_line, fail_at
   use dda_text_numbers, only: read_next_number, word_at, whole_number, &
      number_found, number_none, number_large
   use dda_record_type, only: quantity_in
   implicit none
   private
   public :: sample_list_type, append, read_values, read_row, read_trace, read_line, skip_comments
   public :: read_first_number, read_quantity, check_count, check_duration, check_time_step, &
      max_samples

   integer(long), parameter :: max_samples = 10000000_long   !< 14 hours at 200 samples/s
   real(wp), parameter :: shortest_step = 1.0e-6_wp, longest_step = 100.0_wp   ! s

   !> A growing list of samples.
   type :: sample_list_type
      real(wp), allocatable :: values(:)   !< [capacity] samples; the first `count` are in use
      integer :: count = 0                 !< samples so far
   end type sample_list_type

contains

   !> Append a value to the list.
   pure subroutine append(list, value)
      type(sample_list_type), intent(inout) :: list  !< list to which values are added
      real(wp), intent(in) :: value  !< value to add

      call grow(list%values, list%count + 1)
      list%count = list%count + 1
      list%values(list%count) = value
   end subroutine append

   !> Read the next line, which must exist.
   subroutine read_line(reader, text, item)
      type(line_reader_type), intent(inout) :: reader  !< reader of the file
      character(len=:), allocatable, intent(out) :: text  !< line without its end
      character(len=*), intent(in) :: item  !< expected content of the line, for the message
      logical :: has_line

      call read_next_line(reader, text, has_line)
      if (.not. has_line) call fail_at(reader, 'the file ends here, before '//item)
   end subroutine read_line

   !> Skip comment lines, each of which must begin with a mark.
   subroutine skip_comments(reader, comments, mark)
      type(line_reader_type), intent(inout) :: reader  !< reader of the file
      integer(long), intent(in) :: comments  !< number of comment lines
      character(len=*), intent(in) :: mark  !< mark: '|', or '' for any line
      character(len=:), allocatable :: text
      integer(long) :: line

      do line = 1, comments
         call read_line(reader, text, 'the end of the comments')
         if (index(text, mark) /= 1) call fail_at(reader, quoted(text)// &
            ' is not a comment, but the header declares '//to_text(comments)// &
            ' comment lines, each beginning with '//mark)
         if (allocated(reader%error)) return
      end do
   end subroutine skip_comments

   !> Read a declared number of values from the following lines, with or without blanks between.
   subroutine read_values(reader, declared, items, list)
      type(line_reader_type), intent(inout) :: reader  !< reader of the file
      integer(long), intent(in) :: declared                !< number declared by the header
      character(len=*), intent(in) :: items                 !< 'samples', … for messages
      type(sample_list_type), intent(inout) :: list        !< list to which values are added
      character(len=:), allocatable :: text, excess_message
      logical :: has_line

      excess_message = 'more than the '//to_text(declared)//' '//items//' that the header declares'
      do while (list%count < declared)
         call read_next_line(reader, text, has_line)
         if (.not. has_line) call fail_at(reader, 'the file ends after '//to_text(list%count)// &
            ' of the '//to_text(declared)//' '//items//' that its header declares')
         call read_row(reader, text, .false., declared, excess_message, list)
         if (allocated(reader%error)) return
      end do
   end subroutine read_values

   !> Read a declared number of samples, followed only by blank lines.
   subroutine read_trace(reader, declared, items, values)
      type(line_reader_type), intent(inout) :: reader      !< reader before the first sample
      integer(long), intent(in) :: declared                !< number declared by the header
      character(len=*), intent(in) :: items                 !< 'samples', … for messages
      real(wp), allocatable, intent(out) :: values(:)      !< [samples] values in the file's unit
      type(sample_list_type) :: list
      character(len=:), allocatable :: text
      logical :: has_line

      call read_values(reader, declared, items, list)
      do
         call read_next_line(reader, text, has_line)
         if (.not. has_line) exit
         if (len(word_at(text, 1)) > 0) call fail_at(reader, quoted(text)//' follows the '// &
            to_text(declared)//' samples that the header declares')
      end do
      if (.not. allocated(reader%error)) values = list%values(:list%count)
   end subroutine read_trace

   !> Read the numbers of one line.
   subroutine read_row(reader, text, commas, max_count, excess_message, list)
      type(line_reader_type), intent(inout) :: reader  !< reader of the file; receives errors
      character(len=*), intent(in) :: text  !< line of the file
      logical, intent(in) :: commas  !< .true.: commas may separate numbers; .false.: fixed width
      integer(long), intent(in) :: max_count  !< largest number of values in the list
      character(len=*), intent(in) :: excess_message  !< message if the line has more numbers
      type(sample_list_type), intent(inout) :: list  !< list to which values are added
      integer :: position, state
      real(wp) :: value

      position = 1
      do
         call read_next_number(text, position, value, state, joined=.not. commas, commas=commas)
         if (state == number_none) return
         if (state == number_large) then
            call fail_at(reader, quoted(word_at(text, position))//' is too large a number')
         else if (state /= number_found) then
            call fail_at(reader, quoted(word_at(text, position))//' is not a number')
         else if (list%count >= max_count) then
            call fail_at(reader, excess_message)
         end if
         if (allocated(reader%error)) return
         call append(list, value)
      end do
   end subroutine read_row

   !> Read the quantity that a header line names; a spectrum is an error.
   pure subroutine read_quantity(reader, text, quantity)
      type(line_reader_type), intent(inout) :: reader  !< reader of the file; receives errors
      character(len=*), intent(in) :: text  !< line of the file
      character(len=:), allocatable, intent(out) :: quantity  !< quantity; blank on failure

      quantity = quantity_in(lower_case(text))
      if (index(lower_case(text), 'spectr') > 0) then
         call fail_at(reader, quoted(text)//' is not a time series')
      else if (quantity == '') then
         call fail_at(reader, quoted(text)//' is not acceleration, velocity or displacement')
      end if
   end subroutine read_quantity

   !> Read the number at the start of a header text; a unit directly after it is ignored.
   pure subroutine read_first_number(reader, text, name, value)
      type(line_reader_type), intent(inout) :: reader  !< reader of the file; receives errors
      character(len=*), intent(in) :: text                 !< '100Hz', ' .005 SEC,', …
      character(len=*), intent(in) :: name                 !< name of the number, for the message
      real(wp), intent(out) :: value  !< value stated
      integer :: position, state, last
      character(len=:), allocatable :: number

      number = word_at(text, 1)
      last = verify(number//' ', '+-.0123456789EeDd') - 1
      ! A unit may begin with the letter of an exponent ('2e' of '2east'): drop such letters.
      do while (last > 0)
         if (index('EeDd', number(last:last)) == 0) exit
         last = last - 1
      end do
      position = 1
      call read_next_number(number(:last), position, value, state)
      if (state == number_large) then
         call fail_at(reader, name//': '//quoted(number)//' is too large a number')
      else if (state /= number_found) then
         call fail_at(reader, name//': '//quoted(number)//' is not a number')
      end if
   end subroutine read_first_number

   !> Check a declared number of samples.
   pure subroutine check_count(reader, value, count)
      type(line_reader_type), intent(inout) :: reader  !< reader of the file; receives errors
      real(wp), intent(in) :: value                        !< value as stated in the header
      integer(long), intent(out) :: count                  !< samples

      count = whole_number(value)
      if (count > max_samples) then
         call fail_at(reader, 'the header declares '//to_text(count)// &
            ' samples; at most '//to_text(max_samples)//' are read')
      else if (count < 2) then
         call fail_at(reader, 'the header declares '//to_text(value)// &
            ' samples; at least 2 are needed')
      end if
   end subroutine check_count

   !> Check that a declared duration fits the declared samples.
   !> The tolerance includes rounding and headers that count n or n − 1 steps.
   pure subroutine check_duration(reader, count, time_step, duration)
      type(line_reader_type), intent(inout) :: reader  !< reader of the file; receives errors
      integer(long), intent(in) :: count                   !< samples
      real(wp), intent(in) :: time_step, duration          !< s
      real(wp), parameter :: rounding = 0.01_wp

      if (abs(real(count, wp)*time_step - duration) <= 2.0_wp*time_step + rounding*abs(duration)) &
         return
      call fail_at(reader, 'the header states '//to_text(duration)//' s, but '//to_text(count)// &
         ' samples at '//to_text(time_step)//' s last '//to_text(real(count, wp)*time_step)//' s')
   end subroutine check_duration

   !> Check that a time step is possible for a record.
   pure subroutine check_time_step(reader, time_step)
      type(line_reader_type), intent(inout) :: reader  !< reader of the file; receives errors
      real(wp), intent(in) :: time_step                    !< Δt, s

      if (time_step >= shortest_step .and. time_step <= longest_step) return
      call fail_at(reader, 'the time step '//to_text(time_step)//' s is not between '// &
         to_text(shortest_step)//' and '//to_text(longest_step)//' s')
   end subroutine check_time_step

end module dda_record_samples
