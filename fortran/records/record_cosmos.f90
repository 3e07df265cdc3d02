!> COSMOS format (V1, V2: `.V1c`, `.V2c`) and its CSMIP forerunner (`.V2`).
!>
!> Reference: COSMOS, *Strong Motion Data Format*, version 1.20 (2001).  A file is a sequence of
!> parts, each announced by a line that counts what follows: text, integers, reals, comments,
!> samples.  Real 62 is the time step in milliseconds, real 63 the duration in seconds.  A CSMIP
!> section announces its own time step: `15050 points of accel data equally spaced at .020 sec, in
!> cm/sec2`.  The file is walked line by line, so that it may hold any number of channels and of
!> sections of acceleration, velocity and displacement.
module dda_record_cosmos
   use dda_kinds, only: wp, long
   use dda_errors, only: error_type
   use dda_text, only: lower_case, quoted, to_text
   use dda_text_lines, only: line_reader_type, next_line, fail_at
   use dda_text_numbers, only: whole_number
   use dda_record_type, only: record_type, quantity_in
   use dda_record_units, only: unit_type, find_unit
   use dda_record_samples, only: sample_list_type, read_values, take_values, take_line, &
      first_number, check_count, check_duration, check_time_step
   implicit none
   private
   public :: is_cosmos, is_cosmos_section, read_cosmos

   integer, parameter :: step_at = 62, duration_at = 63      ! places among the reals
   integer, parameter :: station_line = 5                    ! of the text header
   integer(long), parameter :: most_header_numbers = 10000

   !> A line that announces samples.
   type :: section_type
      character(len=:), allocatable :: quantity  ! blank: none of the three
      character(len=:), allocatable :: unit      ! as written
      real(wp) :: count = 0.0_wp                 ! samples
      real(wp) :: time_step = 0.0_wp             ! s
   end type section_type

   !> State of the reader between sections.
   type :: state_type
      integer :: wanted = 1                      ! which section of the quantity
      integer :: seen = 0                        ! sections of the quantity so far
      real(wp) :: time_step = 0.0_wp             ! s, from the last real header
      real(wp) :: duration = 0.0_wp              ! s, likewise; 0: unknown
      integer :: text_line = 0                   ! lines since the last section ended
      logical :: in_samples = .false.            ! among lines of samples that are passed over
      character(len=:), allocatable :: title, station
   end type state_type

contains

   !> Whether a first line is that of a COSMOS file.
   pure function is_cosmos(first) result(is)
      character(len=*), intent(in) :: first  !< line of the file
      logical :: is

      is = index(lower_case(first), '(format v') > 0
   end function is_cosmos

   !> Whether a line announces samples in the manner of CSMIP.
   pure function is_cosmos_section(text) result(is)
      character(len=*), intent(in) :: text  !< line of the file
      logical :: is

      is = index(lower_case(text), 'data equally spaced at') > 0
   end function is_cosmos_section

   !> Read one section, in the file's unit: the `channel`-th with the quantity.
   subroutine read_cosmos(reader, record, quantity, channel, error)
      type(line_reader_type), intent(inout) :: reader        !< at the start of the file
      type(record_type), intent(inout) :: record  !< filled from the file
      character(len=*), intent(in) :: quantity               !< blank: that of the first section
      !> 1, 2, … among the sections of the quantity
      integer, intent(in) :: channel
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      type(state_type) :: state
      character(len=:), allocatable :: text
      logical :: found

      record%quantity = quantity
      state%wanted = channel
      state%title = ''
      state%station = ''
      do
         call next_line(reader, text, found, error)
         if (allocated(error)) return
         if (.not. found) exit
         call take_part(reader, text, record, state, error)
         if (allocated(error)) return
      end do
      call check_found(reader, record, state, error)
   end subroutine read_cosmos

   !> One line at the top level of the file, and what it announces.
   subroutine take_part(reader, text, record, state, error)
      type(line_reader_type), intent(inout) :: reader  !< of the file
      character(len=*), intent(in) :: text  !< line of the file
      type(record_type), intent(inout) :: record  !< filled from the file
      type(state_type), intent(inout) :: state  !< of the reader
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      character(len=:), allocatable :: lowered

      lowered = lower_case(text)
      if (index(text, '|') == 1) then
         return
      else if (index(lowered, 'integer-header values') > 0) then
         call skip_integers(reader, lowered, error)
      else if (index(lowered, 'real-header values') > 0) then
         call read_reals(reader, lowered, state, error)
      else if (index(lowered, 'comment line') > 0 .and. index(lowered, 'follow') > 0) then
         call skip_comments(reader, lowered, error)
      else if (is_section(lowered)) then
         call take_section(reader, lowered, record, state, error)
      else if (index(lowered, 'end-of-data') > 0 .or. index(lowered, 'end of data') > 0) then
         state%in_samples = .false.
         state%text_line = 0
      else if (.not. state%in_samples) then
         call take_title(text, state)
      end if
   end subroutine take_part

   !> Whether a line announces samples, in either style.
   pure function is_section(lowered) result(is)
      character(len=*), intent(in) :: lowered  !< line of the file, in lower case
      logical :: is

      is = is_cosmos_section(lowered) .or. (index(lowered, ' pts') > 0 .and. index(lowered, &
         'units=') > 0)
   end function is_section

   !> The text header: its second line names the record, its fifth the station.
   pure subroutine take_title(text, state)
      character(len=*), intent(in) :: text  !< line of the file
      type(state_type), intent(inout) :: state  !< of the reader

      state%text_line = state%text_line + 1
      if (state%text_line == 2) state%title = trim(adjustl(text))
      if (state%text_line == station_line) state%station = trim(adjustl(text))
   end subroutine take_title

   !> A section of samples: read it, or only count it.
   subroutine take_section(reader, lowered, record, state, error)
      type(line_reader_type), intent(inout) :: reader  !< of the file
      character(len=*), intent(in) :: lowered  !< line of the file, in lower case
      type(record_type), intent(inout) :: record  !< filled from the file
      type(state_type), intent(inout) :: state  !< of the reader
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      type(section_type) :: section

      call read_announcement(reader, lowered, state, section, error)
      if (allocated(error)) return
      state%in_samples = .true.
      if (len_trim(record%quantity) == 0) record%quantity = section%quantity
      if (section%quantity == '' .or. section%quantity /= record%quantity) return
      state%seen = state%seen + 1
      if (state%seen == state%wanted) call read_section(reader, section, record, state, error)
   end subroutine take_section

   !> `42000 acceleration pts, approx 210 secs, units=cm/sec2(04),Format=(1E15.6)` or the CSMIP
   !> line.
   subroutine read_announcement(reader, lowered, state, section, error)
      type(line_reader_type), intent(in) :: reader  !< of the file, for messages
      character(len=*), intent(in) :: lowered  !< line of the file, in lower case
      type(state_type), intent(in) :: state  !< of the reader
      type(section_type), intent(out) :: section  !< as announced
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      character(len=*), parameter :: before_step = 'spaced at'
      integer :: at

      section%quantity = quantity_in(lowered)
      call first_number(reader, lowered, 'number of samples', section%count, error)
      if (allocated(error)) return
      at = index(lowered, before_step)
      if (at > 0) then
         call first_number(reader, lowered(at + len(before_step):), 'time step', &
            section%time_step, error)
         section%unit = unit_word(after(lowered, ' in '))
         ! The older style: `SEC.  (UNITS: CM/SEC/SEC)`.
         if (section%unit == '') section%unit = unit_word(after(lowered, 'units:'))
      else
         section%time_step = state%time_step
         section%unit = unit_word(after(lowered, 'units='))
      end if
   end subroutine read_announcement

   !> The text behind the last occurrence of a word, blank if it does not occur.
   pure function after(text, word) result(rest)
      character(len=*), intent(in) :: text, word  !< looked through; looked for
      character(len=:), allocatable :: rest
      integer :: at

      rest = ''
      at = index(text, word, back=.true.)
      if (at > 0) rest = text(at + len(word):)
   end function after

   !> The first word, without a suffix of the formats: `(04)`, a comma, a full stop.
   pure function unit_word(text) result(word)
      character(len=*), intent(in) :: text  !< line of the file
      character(len=:), allocatable :: word

      word = adjustl(text)
      word = word(:scan(word//' ', ' (),.;') - 1)
   end function unit_word

   !> Read the samples of a section.
   subroutine read_section(reader, section, record, state, error)
      type(line_reader_type), intent(inout) :: reader  !< of the file
      type(section_type), intent(in) :: section  !< as announced
      type(record_type), intent(inout) :: record  !< filled from the file
      type(state_type), intent(inout) :: state  !< of the reader
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      type(unit_type) :: unit
      type(sample_list_type) :: list
      integer(long) :: samples

      unit = find_unit(section%unit)
      if (unit%quantity /= section%quantity) then
         call fail_at(error, reader, quoted(section%unit)//' is not a unit of '//section%quantity)
         return
      end if
      call check_count(reader, section%count, samples, error)
      if (.not. allocated(error)) call check_time_step(reader, section%time_step, error)
      if (allocated(error)) return
      if (state%duration > 0.0_wp) call check_duration(reader, samples, section%time_step, &
         state%duration, error)
      if (.not. allocated(error)) call read_values(reader, samples, 'samples', list, error)
      if (allocated(error)) return
      call take_values(list, record%values)
      record%time_step = section%time_step
      record%unit = section%unit
      record%station = state%station
      record%description = state%title
   end subroutine read_section

   !> An error unless the section asked for has been read.
   subroutine check_found(reader, record, state, error)
      type(line_reader_type), intent(in) :: reader  !< of the file, for messages
      type(record_type), intent(inout) :: record  !< filled from the file
      type(state_type), intent(in) :: state  !< of the reader
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure

      if (allocated(record%values)) then
         record%description = record%description//' (section '//to_text(state%wanted)//' of '// &
            to_text(state%seen)//' with '//record%quantity//')'
      else if (state%seen == 0) then
         call fail_at(error, reader, 'the file ends and has no section of '// &
            trim(record%quantity//' samples'))
      else
         call fail_at(error, reader, 'channel '//to_text(state%wanted)// &
            ' was asked for, but the file has '//to_text(state%seen)//' section(s) of '// &
            record%quantity)
      end if
   end subroutine check_found

   !> `100 Integer-header values follow on 10 lines, Format= (10I8)`: none is needed here.
   subroutine skip_integers(reader, lowered, error)
      type(line_reader_type), intent(inout) :: reader  !< of the file
      character(len=*), intent(in) :: lowered  !< line of the file, in lower case
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      type(sample_list_type) :: list

      call read_header(reader, lowered, 'integer-header values', list, error)
   end subroutine skip_integers

   !> Time step and duration; unknown ones are negative.
   subroutine read_reals(reader, lowered, state, error)
      type(line_reader_type), intent(inout) :: reader  !< of the file
      character(len=*), intent(in) :: lowered  !< line of the file, in lower case
      type(state_type), intent(inout) :: state  !< of the reader
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      type(sample_list_type) :: list
      real(wp), parameter :: largest = 1.0e9_wp

      call read_header(reader, lowered, 'real-header values', list, error)
      if (allocated(error)) return
      state%time_step = 0.0_wp
      state%duration = 0.0_wp
      if (list%count < duration_at) return
      ! Milliseconds in the file; division keeps 5 ms the same number as 0.005.
      state%time_step = min(list%values(step_at), largest)/1000.0_wp
      state%duration = min(list%values(duration_at), largest)
   end subroutine read_reals

   !> Read the numbers that a line announces.
   subroutine read_header(reader, lowered, what, list, error)
      type(line_reader_type), intent(inout) :: reader  !< of the file
      !> line in lower case; what it counts, for messages
      character(len=*), intent(in) :: lowered, what
      type(sample_list_type), intent(out) :: list  !< numbers read
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      integer(long) :: count

      call announced(reader, lowered, what, count, error)
      if (.not. allocated(error)) call read_values(reader, count, what, list, error)
   end subroutine read_header

   !> Skip the comment lines that a line announces.
   subroutine skip_comments(reader, lowered, error)
      type(line_reader_type), intent(inout) :: reader  !< of the file
      character(len=*), intent(in) :: lowered  !< line of the file, in lower case
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      character(len=:), allocatable :: text
      integer(long) :: count, line

      call announced(reader, lowered, 'comment lines', count, error)
      if (allocated(error)) return
      do line = 1, count
         call take_line(reader, text, 'the end of the comments', error)
         if (allocated(error)) return
      end do
   end subroutine skip_comments

   !> The count at the beginning of an announcing line.
   subroutine announced(reader, lowered, what, count, error)
      type(line_reader_type), intent(in) :: reader  !< of the file, for messages
      !> line in lower case; what it counts, for messages
      character(len=*), intent(in) :: lowered, what
      integer(long), intent(out) :: count  !< as the line states it
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      real(wp) :: value

      count = 0
      call first_number(reader, lowered, 'number of '//what, value, error)
      if (allocated(error)) return
      count = whole_number(value)
      if (count < 0 .or. count > most_header_numbers) call fail_at(error, reader, &
         to_text(value)//' '//what//' are announced')
   end subroutine announced

end module dda_record_cosmos
