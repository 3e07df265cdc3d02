!> ESM / ITACA ASCII format (DYNA 1.2): 64 lines `KEY: value`, one sample a line.
!>
!> Reference: ORFEUS Engineering Strong Motion database, file format ASCII DYNA 1.2: keys
!> SAMPLING_INTERVAL_S, NDATA, DURATION_S, UNITS, DATA_TYPE.  Older headers are a few lines shorter,
!> so the header is taken to end where the first line stands that is not `KEY: value`.
module dda_record_esm
   use dda_kinds, only: wp, long
   use dda_errors, only: error_type
   use dda_text, only: lower_case, quoted
   use dda_text_lines, only: line_reader_type, next_line, put_back, fail_at
   use dda_record_type, only: record_type, quantity_in
   use dda_record_units, only: unit_type, find_unit
   use dda_record_samples, only: read_trace, check_count, check_time_step, check_duration, &
      first_number
   implicit none
   private
   public :: is_esm, read_esm

   !> Values of an ESM header.
   type :: esm_header_type
      real(wp) :: count = -1.0_wp     ! samples
      real(wp) :: duration = -1.0_wp  ! s
   end type esm_header_type

contains

   !> Whether a file that begins so is an ESM file.
   pure function is_esm(first) result(is)
      character(len=*), intent(in) :: first   !< its first line
      logical :: is

      is = index(first, 'EVENT_NAME:') == 1
   end function is_esm

   !> Read the one trace of an ESM file, in the file's unit.
   subroutine read_esm(reader, record, error)
      type(line_reader_type), intent(inout) :: reader        !< at the start of the file
      type(record_type), intent(inout) :: record  !< filled from the file
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      type(esm_header_type) :: header
      integer(long) :: samples

      call read_header(reader, record, header, error)
      if (.not. allocated(error)) call check_header(reader, record, header, samples, error)
      if (.not. allocated(error)) call read_trace(reader, samples, 'samples (NDATA)', &
         record%values, error)
   end subroutine read_esm

   !> All lines `KEY: value`.
   subroutine read_header(reader, record, header, error)
      type(line_reader_type), intent(inout) :: reader  !< of the file
      type(record_type), intent(inout) :: record  !< filled from the file
      type(esm_header_type), intent(out) :: header  !< as read
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      character(len=:), allocatable :: text
      logical :: found
      integer :: colon

      do
         call next_line(reader, text, found, error)
         if (allocated(error) .or. .not. found) return
         colon = index(text, ':')
         if (colon == 0) exit
         call read_item(reader, text(:colon - 1), trim(adjustl(text(colon + 1:))), record, header, &
            error)
         if (allocated(error)) return
      end do
      call put_back(reader)
   end subroutine read_header

   !> Take what one line of the header states.
   subroutine read_item(reader, key, value, record, header, error)
      type(line_reader_type), intent(in) :: reader  !< of the file, for messages
      character(len=*), intent(in) :: key, value  !< of a line `KEY: value`
      type(record_type), intent(inout) :: record  !< filled from the file
      type(esm_header_type), intent(inout) :: header  !< as read so far
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure

      select case (trim(adjustl(key)))
      case ('EVENT_NAME')
         record%description = value
      case ('EVENT_DATE_YYYYMMDD', 'STREAM')
         record%description = record%description//' '//value
      case ('STATION_CODE')
         record%station = value
      case ('STATION_NAME')
         record%station = record%station//' '//value
      case ('SAMPLING_INTERVAL_S')
         call first_number(reader, value, key, record%time_step, error)
      case ('NDATA')
         call first_number(reader, value, key, header%count, error)
      case ('DURATION_S')
         if (len(value) > 0) call first_number(reader, value, key, header%duration, error)
      case ('UNITS')
         call read_unit(reader, value, record, error)
      case ('DATA_TYPE')
         call read_kind(reader, value, record, error)
      end select
   end subroutine read_item

   !> The unit, blank if the header has none.
   subroutine read_unit(reader, value, record, error)
      type(line_reader_type), intent(in) :: reader  !< of the file, for messages
      character(len=*), intent(in) :: value  !< of the line
      type(record_type), intent(inout) :: record  !< filled from the file
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      type(unit_type) :: unit

      unit = find_unit(value)
      if (unit%scale > 0.0_wp) then
         record%unit = value
      else if (len(value) > 0) then
         call fail_at(error, reader, 'UNITS: '//quoted(value)//' is not a unit of motion')
      end if
   end subroutine read_unit

   !> The quantity; a spectrum is an error.
   subroutine read_kind(reader, value, record, error)
      type(line_reader_type), intent(in) :: reader  !< of the file, for messages
      character(len=*), intent(in) :: value  !< of the line
      type(record_type), intent(inout) :: record  !< filled from the file
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      character(len=:), allocatable :: kind

      kind = lower_case(value)
      if (index(kind, 'spectr') > 0) then
         call fail_at(error, reader, 'DATA_TYPE: '//quoted(value)//' is not a time series')
      else if (quantity_in(kind) /= '') then
         record%quantity = quantity_in(kind)
      else
         call fail_at(error, reader, 'DATA_TYPE: '//quoted(value)// &
            ' is not acceleration, velocity or displacement')
      end if
   end subroutine read_kind

   !> Number of samples, time step and duration must be there and agree.
   subroutine check_header(reader, record, header, samples, error)
      type(line_reader_type), intent(in) :: reader  !< of the file, for messages
      type(record_type), intent(in) :: record  !< as read
      type(esm_header_type), intent(in) :: header  !< as read
      integer(long), intent(out) :: samples  !< declared by the header
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure

      samples = 0
      if (header%count < 0.0_wp .or. record%time_step <= 0.0_wp) then
         call fail_at(error, reader, 'the header above does not state NDATA and '// &
            'SAMPLING_INTERVAL_S'//' as positive numbers')
         return
      end if
      call check_count(reader, header%count, samples, error)
      if (.not. allocated(error)) call check_time_step(reader, record%time_step, error)
      if (allocated(error) .or. header%duration < 0.0_wp) return
      call check_duration(reader, samples, record%time_step, header%duration, error)
   end subroutine check_header

end module dda_record_esm
