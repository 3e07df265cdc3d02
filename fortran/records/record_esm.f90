! SPDX-License-Identifier: GPL-3.0-or-later
!> ESM / ITACA ASCII format (DYNA 1.2): 64 lines `KEY: value`, one sample per line.
!>
!> Reference: ORFEUS Engineering Strong Motion database, file format ASCII DYNA 1.2: keys
!> SAMPLING_INTERVAL_S, NDATA, DURATION_S, UNITS, DATA_TYPE.  Older headers are a few lines shorter,
!> so the header ends at the first line that is not `KEY: value`.
module dda_record_esm
   use dda_kinds, only: wp, long
   use dda_text, only: quoted
   use dda_text_lines, only: line_reader_type, read_next_line, repeat_line, fail_at
   use dda_record_type, only: record_type, unit_type, find_unit
   use dda_record_samples, only: read_trace, check_count, check_time_step, check_duration, &
      read_first_number, read_quantity
   implicit none
   private
   public :: read_esm

contains

   !> Read the trace of an ESM file, in the unit of the file.
   subroutine read_esm(reader, record)
      type(line_reader_type), intent(inout) :: reader        !< reader at the start of the file
      type(record_type), intent(inout) :: record  !< record, filled from the file
      character(len=:), allocatable :: text
      real(wp) :: count, duration  ! number of samples, s; < 0: not in the header
      integer(long) :: samples
      logical :: has_line

      count = -1.0_wp
      duration = -1.0_wp
      do
         call read_next_line(reader, text, has_line)
         if (.not. has_line .or. index(text, ':') == 0) exit
         call read_item(reader, text, record, count, duration)
      end do
      if (has_line) call repeat_line(reader)
      if (count < 0.0_wp .or. record%time_step <= 0.0_wp) call fail_at(reader, &
         'NDATA and SAMPLING_INTERVAL_S must be positive numbers in the header above')
      call check_count(reader, count, samples)
      call check_time_step(reader, record%time_step)
      if (duration >= 0.0_wp) call check_duration(reader, samples, record%time_step, duration)
      call read_trace(reader, samples, 'samples (NDATA)', record%values)
   end subroutine read_esm

   !> Read one line of the header.
   subroutine read_item(reader, text, record, count, duration)
      type(line_reader_type), intent(inout) :: reader  !< reader of the file; receives errors
      character(len=*), intent(in) :: text  !< line `KEY: value`
      type(record_type), intent(inout) :: record  !< record, filled from the file
      real(wp), intent(inout) :: count, duration  !< number of samples; duration, s
      character(len=:), allocatable :: key, value
      type(unit_type) :: unit

      key = trim(adjustl(text(:index(text, ':') - 1)))
      value = trim(adjustl(text(index(text, ':') + 1:)))
      select case (key)
      case ('EVENT_NAME')
         record%description = value
      case ('EVENT_DATE_YYYYMMDD', 'STREAM')
         record%description = record%description//' '//value
      case ('STATION_CODE')
         record%station = value
      case ('STATION_NAME')
         record%station = record%station//' '//value
      case ('SAMPLING_INTERVAL_S')
         call read_first_number(reader, value, key, record%time_step)
      case ('NDATA')
         call read_first_number(reader, value, key, count)
      case ('DURATION_S')
         if (value /= '') call read_first_number(reader, value, key, duration)
      case ('UNITS')
         unit = find_unit(value)
         if (unit%scale > 0.0_wp) record%unit = value
         if (unit%scale <= 0.0_wp .and. value /= '') call fail_at(reader, &
            'UNITS: '//quoted(value)//' is not a unit of motion')
      case ('DATA_TYPE')
         call read_quantity(reader, text, record%quantity)
      end select
   end subroutine read_item

end module dda_record_esm
