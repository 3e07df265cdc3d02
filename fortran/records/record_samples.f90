!> Samples and header numbers as they come out of a record file.
!>
!> Memory follows what the file holds, never what its header claims.
module dda_record_samples
   use dda_growth, only: grow
   use dda_kinds, only: wp, long
   use dda_errors, only: error_type
   use dda_text, only: to_text, quoted
   use dda_text_lines, only: line_reader_type, next_line, fail_at
   use dda_text_numbers, only: next_number, word_at, whole_number, &
      number_found, number_none, number_large
   implicit none
   private
   public :: sample_list_type, append, take_values, read_values, read_trace, take_line, first_number
   public :: check_count, check_duration, check_time_step, refuse_word, most_samples

   integer(long), parameter :: most_samples = 10000000_long   !< 14 hours at 200 samples/s
   real(wp), parameter :: shortest_step = 1.0e-6_wp, longest_step = 100.0_wp   ! s

   !> A list that grows.
   type :: sample_list_type
      real(wp), allocatable :: values(:)   !< the first `count` are in use [capacity]
      integer :: count = 0                 !< samples so far
   end type sample_list_type

contains

   !> Add a value.
   pure subroutine append(list, value)
      type(sample_list_type), intent(inout) :: list  !< values are added to it
      real(wp), intent(in) :: value  !< to add

      call grow(list%values, list%count + 1)
      list%count = list%count + 1
      list%values(list%count) = value
   end subroutine append

   !> The values of a list, in an array of their number.
   pure subroutine take_values(list, values)
      type(sample_list_type), intent(inout) :: list  !< empty afterwards
      real(wp), allocatable, intent(out) :: values(:)   !< [samples]

      if (.not. allocated(list%values)) allocate (list%values(0))
      values = list%values(:list%count)
      deallocate (list%values)
      list%count = 0
   end subroutine take_values

   !> The next line, which must be there.
   subroutine take_line(reader, text, what, error)
      type(line_reader_type), intent(inout) :: reader  !< of the file
      character(len=:), allocatable, intent(out) :: text  !< without its line end
      !> what the line is to hold, for the message
      character(len=*), intent(in) :: what
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      logical :: found

      call next_line(reader, text, found, error)
      if (allocated(error) .or. found) return
      call fail_at(error, reader, 'the file ends here, before '//what)
   end subroutine take_line

   !> Read a declared number of values from the lines that follow; they may run together.
   subroutine read_values(reader, expected, what, list, error)
      type(line_reader_type), intent(inout) :: reader  !< of the file
      integer(long), intent(in) :: expected                !< how many the header declares
      character(len=*), intent(in) :: what                 !< 'samples', … for messages
      type(sample_list_type), intent(inout) :: list        !< values are added to it
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      character(len=:), allocatable :: text
      logical :: found

      do while (list%count < expected)
         call next_line(reader, text, found, error)
         if (allocated(error)) return
         if (.not. found) then
            call fail_at(error, reader, 'the file ends after '//to_text(list%count)//' of the '// &
               to_text(expected)//' '//what//' that its header declares')
            return
         end if
         call read_row(reader, text, expected, what, list, error)
         if (allocated(error)) return
      end do
   end subroutine read_values

   !> A declared number of samples, and nothing behind them.
   subroutine read_trace(reader, expected, what, values, error)
      type(line_reader_type), intent(inout) :: reader      !< before the first sample
      integer(long), intent(in) :: expected                !< how many the header declares
      character(len=*), intent(in) :: what                 !< 'samples', … for messages
      real(wp), allocatable, intent(out) :: values(:)      !< [samples] in the file's unit
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      type(sample_list_type) :: list

      call read_values(reader, expected, what, list, error)
      if (.not. allocated(error)) call expect_end(reader, expected, error)
      if (.not. allocated(error)) call take_values(list, values)
   end subroutine read_trace

   !> The numbers of one line.
   subroutine read_row(reader, text, expected, what, list, error)
      type(line_reader_type), intent(in) :: reader  !< of the file, for messages
      character(len=*), intent(in) :: text  !< line of the file
      integer(long), intent(in) :: expected  !< how many the header declares
      character(len=*), intent(in) :: what  !< what is counted, for messages
      type(sample_list_type), intent(inout) :: list  !< values are added to it
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      integer :: position, state
      real(wp) :: value

      position = 1
      do
         call next_number(text, position, value, state, joined=.true.)
         if (state == number_none) return
         if (state /= number_found) then
            call refuse_word(reader, text, position, state, error)
            return
         end if
         if (list%count >= expected) then
            call fail_at(error, reader, 'more than the '//to_text(expected)//' '//what// &
               ' that the header declares')
            return
         end if
         call append(list, value)
      end do
   end subroutine read_row

   !> Nothing but blank lines may follow.
   subroutine expect_end(reader, expected, error)
      type(line_reader_type), intent(inout) :: reader  !< of the file
      integer(long), intent(in) :: expected                !< samples read, for the message
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      character(len=:), allocatable :: text
      logical :: found

      do
         call next_line(reader, text, found, error)
         if (allocated(error) .or. .not. found) return
         if (len(word_at(text, 1)) > 0) then
            call fail_at(error, reader, quoted(text)//' follows the '//to_text(expected)// &
               ' samples that the header declares')
            return
         end if
      end do
   end subroutine expect_end

   !> The error for what is not a number.
   pure subroutine refuse_word(reader, text, position, state, error)
      type(line_reader_type), intent(in) :: reader  !< of the file, for messages
      character(len=*), intent(in) :: text  !< line of the file
      integer, intent(in) :: position                      !< where the word stands
      integer, intent(in) :: state                         !< `number_bad` or `number_large`
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure

      if (state == number_large) then
         call fail_at(error, reader, quoted(word_at(text, position))//' is too large a number')
      else
         call fail_at(error, reader, quoted(word_at(text, position))//' is not a number')
      end if
   end subroutine refuse_word

   !> The number that begins a piece of header text; what follows it directly (a unit) is ignored.
   pure subroutine first_number(reader, text, what, value, error)
      type(line_reader_type), intent(in) :: reader  !< of the file, for messages
      character(len=*), intent(in) :: text                 !< '100Hz', ' .005 SEC,', …
      character(len=*), intent(in) :: what                 !< what the number is, for the message
      real(wp), intent(out) :: value  !< as stated
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      integer :: position, state, last
      character(len=:), allocatable :: word

      word = word_at(text, 1)
      last = verify(word//' ', '+-.0123456789EeDd') - 1
      ! A unit may begin with the exponent's letter ('2e' of '2east'): drop letters without digits.
      do while (last > 0)
         if (index('EeDd', word(last:last)) == 0) exit
         last = last - 1
      end do
      position = 1
      call next_number(word(:last), position, value, state)
      if (state == number_large) then
         call fail_at(error, reader, what//': '//quoted(word)//' is too large a number')
      else if (state /= number_found) then
         call fail_at(error, reader, what//': '//quoted(word)//' is not a number')
      end if
   end subroutine first_number

   !> A declared number of samples that can be read.
   pure subroutine check_count(reader, value, count, error)
      type(line_reader_type), intent(in) :: reader  !< of the file, for messages
      real(wp), intent(in) :: value                        !< as the header states it
      integer(long), intent(out) :: count                  !< samples
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure

      count = whole_number(value)
      if (count > most_samples) then
         call fail_at(error, reader, 'the header declares '//to_text(count)// &
            ' samples; at most '//to_text(most_samples)//' are read')
      else if (count < 2) then
         call fail_at(error, reader, 'the header declares '//to_text(value)// &
            ' samples; at least 2 are needed')
      end if
   end subroutine check_count

   !> A declared duration must fit the declared samples, up to rounding and to counting n or n − 1
   !> steps.
   pure subroutine check_duration(reader, count, time_step, duration, error)
      type(line_reader_type), intent(in) :: reader  !< of the file, for messages
      integer(long), intent(in) :: count                   !< samples
      real(wp), intent(in) :: time_step, duration          !< s
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      real(wp), parameter :: rounding = 0.01_wp

      if (abs(real(count, wp)*time_step - duration) <= 2.0_wp*time_step + rounding*abs(duration)) &
         return
      call fail_at(error, reader, 'the header states '//to_text(duration)//' s, but '// &
         to_text(count)//' samples at '//to_text(time_step)//' s last '// &
         to_text(real(count, wp)*time_step)//' s')
   end subroutine check_duration

   !> A time step that a record can have.
   pure subroutine check_time_step(reader, time_step, error)
      type(line_reader_type), intent(in) :: reader  !< of the file, for messages
      real(wp), intent(in) :: time_step                    !< s
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure

      if (time_step >= shortest_step .and. time_step <= longest_step) return
      call fail_at(error, reader, 'the time step '//to_text(time_step)//' s is not between '// &
         to_text(shortest_step)//' and '//to_text(longest_step)//' s')
   end subroutine check_time_step

end module dda_record_samples
