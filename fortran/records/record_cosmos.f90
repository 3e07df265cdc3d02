! SPDX-License-Identifier: GPL-3.0-or-later
!> COSMOS format (V1, V2: `.V1c`, `.V2c`) and the older CSMIP format (`.V2`).
!>
!> Reference: COSMOS, *Strong Motion Data Format*, version 1.20 (2001).  A file is a sequence of
!> parts, each of which begins with a line that counts its content: text, integers, reals, comments,
!> samples.  Real 62 is the time step in milliseconds, real 63 the duration in seconds.  A CSMIP
!> section states its own time step: `15050 points of accel data equally spaced at .020 sec, in
!> cm/sec2`.  The file is read line by line, so that it may have any number of channels and of
!> sections of acceleration, velocity and displacement.
module dda_record_cosmos
   use dda_kinds, only: wp, long
   use dda_text, only: lower_case, quoted, to_text
   use dda_text_lines, only: line_reader_type, read_next_line, fail_at
   use dda_text_numbers, only: whole_number
   use dda_record_type, only: record_type, quantity_in, unit_type, find_unit
   use dda_record_samples, only: sample_list_type, read_values, skip_comments, read_first_number, &
      check_count, check_duration, check_time_step
   implicit none
   private
   public :: read_cosmos, csmip_section

   !> text in the line before samples of a CSMIP section, in lower case
   character(len=*), parameter :: csmip_section = 'data equally spaced at'
   integer, parameter :: step_at = 62, duration_at = 63      ! positions among the reals
   integer, parameter :: station_line = 5                    ! of the text header
   integer(long), parameter :: max_header_numbers = 10000

   !> State of the reader between sections.
   type :: state_type
      integer :: wanted = 1                      ! number of the section of the quantity
      integer :: seen = 0                        ! sections of the quantity so far
      real(wp) :: time_step = 0.0_wp             ! s, from the last real header
      real(wp) :: duration = 0.0_wp              ! s, from the last real header; 0: unknown
      integer :: text_line = 0                   ! lines since the last section ended
      logical :: in_samples = .false.            ! the next lines are samples to skip
      character(len=:), allocatable :: title, station ! of the text header
   end type state_type

contains

   !> Read the `channel`-th section with the quantity, in the unit of the file.
   subroutine read_cosmos(reader, record, quantity, channel)
      type(line_reader_type), intent(inout) :: reader        !< reader at the start of the file
      type(record_type), intent(inout) :: record  !< record, filled from the file
      character(len=*), intent(in) :: quantity  !< quantity; blank: quantity of the first section
      integer, intent(in) :: channel  !< number of the section among those with the quantity, from 1
      type(state_type) :: state
      character(len=:), allocatable :: text
      logical :: has_line

      record%quantity = quantity
      state%wanted = channel
      state%title = ''
      state%station = ''
      do
         call read_next_line(reader, text, has_line)
         if (.not. has_line) exit
         call read_part(reader, text, lower_case(text), record, state)
      end do
      if (allocated(record%values)) then
         record%description = record%description//' (section '//to_text(state%wanted)//' of '// &
            to_text(state%seen)//' with '//record%quantity//')'
      else if (state%seen == 0) then
         call fail_at(reader, 'the file ends and has no section of '// &
            trim(record%quantity//' samples'))
      else
         call fail_at(reader, 'channel '//to_text(state%wanted)//' was requested, but the file '// &
            'has '//to_text(state%seen)//' section(s) of '//record%quantity)
      end if
   end subroutine read_cosmos

   !> Read one line at the top level of the file, and the part that it announces.
   subroutine read_part(reader, text, lowered, record, state)
      type(line_reader_type), intent(inout) :: reader  !< reader of the file
      character(len=*), intent(in) :: text, lowered  !< line of the file; the line in lower case
      type(record_type), intent(inout) :: record  !< record, filled from the file
      type(state_type), intent(inout) :: state  !< state of the reader
      type(sample_list_type) :: list
      integer(long) :: count

      if (index(text, '|') == 1) then
         return
      else if (index(lowered, 'integer-header values') > 0) then
         call read_header(reader, lowered, 'integer-header values', list)
      else if (index(lowered, 'real-header values') > 0) then
         call read_header(reader, lowered, 'real-header values', list)
         call read_header_reals(list, state)
      else if (index(lowered, 'comment line') > 0 .and. index(lowered, 'follow') > 0) then
         call read_announced_count(reader, lowered, 'comment lines', count)
         call skip_comments(reader, count, '')
      else if (index(lowered, csmip_section) > 0 .or. (index(lowered, ' pts') > 0 .and. &
         index(lowered, 'units=') > 0)) then
         call read_wanted_section(reader, lowered, record, state)
      else if (index(lowered, 'end-of-data') > 0 .or. index(lowered, 'end of data') > 0) then
         state%in_samples = .false.
         state%text_line = 0
      else if (.not. state%in_samples) then
         ! The second line of the text header names the record, the fifth the station.
         state%text_line = state%text_line + 1
         if (state%text_line == 2) state%title = trim(adjustl(text))
         if (state%text_line == station_line) state%station = trim(adjustl(text))
      end if
   end subroutine read_part

   !> Read a section of samples if it is the requested section, otherwise skip it.
   !> Its first line is `42000 acceleration pts, approx 210 secs,
   !> units=cm/sec2(04),Format=(1E15.6)`, or CSMIP.
   subroutine read_wanted_section(reader, lowered, record, state)
      type(line_reader_type), intent(inout) :: reader  !< reader of the file
      character(len=*), intent(in) :: lowered  !< line of the file, in lower case
      type(record_type), intent(inout) :: record  !< record, filled from the file
      type(state_type), intent(inout) :: state  !< state of the reader
      character(len=*), parameter :: before_step = 'spaced at'
      character(len=:), allocatable :: quantity
      real(wp) :: count
      integer :: at

      quantity = quantity_in(lowered)
      call read_first_number(reader, lowered, 'number of samples', count)
      state%in_samples = .true.
      if (record%quantity == '') record%quantity = quantity
      if (quantity == '' .or. quantity /= record%quantity) return
      state%seen = state%seen + 1
      if (state%seen /= state%wanted) return
      record%time_step = state%time_step
      record%unit = unit_word(text_after(lowered, 'units='))
      at = index(lowered, before_step)
      if (at > 0) then
         call read_first_number(reader, lowered(at + len(before_step):), 'time step', &
            record%time_step)
         record%unit = unit_word(text_after(lowered, ' in '))
         ! CSMIP: `SEC.  (UNITS: CM/SEC/SEC)`.
         if (record%unit == '') record%unit = unit_word(text_after(lowered, 'units:'))
      end if
      call read_section(reader, count, record, state)
   end subroutine read_wanted_section

   !> Text after the last occurrence of a word; blank if it does not occur.
   pure function text_after(text, key) result(remainder)
      character(len=*), intent(in) :: text, key  !< text to be searched; word to be found
      character(len=:), allocatable :: remainder
      integer :: at

      remainder = ''
      at = index(text, key, back=.true.)
      if (at > 0) remainder = text(at + len(key):)
   end function text_after

   !> First word of a text, without a suffix `(04)`, a comma or a full stop.
   pure function unit_word(text) result(name)
      character(len=*), intent(in) :: text  !< line of the file
      character(len=:), allocatable :: name

      name = adjustl(text)
      name = name(:scan(name//' ', ' (),.;') - 1)
   end function unit_word

   !> Read the samples of a section.
   subroutine read_section(reader, count, record, state)
      type(line_reader_type), intent(inout) :: reader  !< reader of the file
      real(wp), intent(in) :: count  !< count of samples, as announced
      type(record_type), intent(inout) :: record  !< record with its quantity, unit and time step
      type(state_type), intent(in) :: state  !< state of the reader
      type(unit_type) :: unit
      type(sample_list_type) :: list
      integer(long) :: samples

      unit = find_unit(record%unit)
      if (unit%quantity /= record%quantity) call fail_at(reader, quoted(record%unit)// &
         ' is not a unit of '//record%quantity)
      call check_count(reader, count, samples)
      call check_time_step(reader, record%time_step)
      if (state%duration > 0.0_wp) call check_duration(reader, samples, record%time_step, &
         state%duration)
      call read_values(reader, samples, 'samples', list)
      if (allocated(reader%error)) return
      record%values = list%values(:list%count)
      record%station = state%station
      record%description = state%title
   end subroutine read_section

   !> Read time step and duration among the reals; unknown values are negative.
   pure subroutine read_header_reals(list, state)
      type(sample_list_type), intent(in) :: list  !< numbers of the header
      type(state_type), intent(inout) :: state  !< state of the reader
      real(wp), parameter :: largest = 1.0e9_wp

      state%time_step = 0.0_wp
      state%duration = 0.0_wp
      if (list%count < duration_at) return
      ! The file has milliseconds; division converts 5 ms to exactly the number 0.005.
      state%time_step = min(list%values(step_at), largest)/1000.0_wp
      state%duration = min(list%values(duration_at), largest)
   end subroutine read_header_reals

   !> Read the numbers that a line announces.
   subroutine read_header(reader, lowered, items, list)
      type(line_reader_type), intent(inout) :: reader  !< reader of the file
      !> line in lower case; items that the line counts, for messages
      character(len=*), intent(in) :: lowered, items
      type(sample_list_type), intent(out) :: list  !< numbers read
      integer(long) :: count

      call read_announced_count(reader, lowered, items, count)
      call read_values(reader, count, items, list)
   end subroutine read_header

   !> Read the count at the beginning of an announcing line.
   pure subroutine read_announced_count(reader, lowered, items, count)
      type(line_reader_type), intent(inout) :: reader  !< reader of the file; receives errors
      !> line in lower case; items that the line counts, for messages
      character(len=*), intent(in) :: lowered, items
      integer(long), intent(out) :: count  !< count stated in the line
      real(wp) :: value

      call read_first_number(reader, lowered, 'number of '//items, value)
      count = whole_number(value)
      if (count < 0 .or. count > max_header_numbers) call fail_at(reader, &
         to_text(value)//' '//items//' are declared, an impossible number')
   end subroutine read_announced_count

end module dda_record_cosmos
