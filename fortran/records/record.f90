!> Read a recorded motion in any of the formats of the strong-motion networks.
module dda_record
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use dda_kinds, only: wp
   use dda_errors, only: error_type, fail, error_input
   use dda_text, only: lower_case, quoted, to_text
   use dda_text_lines, only: line_reader_type, open_lines, close_lines
   use dda_record_type, only: record_type, acceleration, velocity, displacement
   use dda_record_units, only: unit_type, find_unit, known_units
   use dda_record_samples, only: check_time_step
   use dda_record_smc, only: read_smc
   use dda_record_at2, only: read_at2
   use dda_record_knet, only: read_knet
   use dda_record_esm, only: read_esm
   use dda_record_cosmos, only: read_cosmos
   use dda_record_text, only: read_text
   use dda_record_format, only: detect, known_formats
   implicit none
   private
   public :: record_type, read_record

   ! SI; beyond any motion of the ground, far from overflow
   real(wp), parameter :: largest_value = 1.0e9_wp

contains

   !> Read a record, check it against its own header, and give it in SI units.
   subroutine read_record(record, file, format, quantity, unit, error, time_step, channel)
      type(record_type), intent(out) :: record  !< as read
      character(len=*), intent(in) :: file      !< path
      !> 'auto', 'smc', 'at2', 'knet', 'esm', 'cosmos' or 'text'
      character(len=*), intent(in) :: format
      !> 'acceleration', 'velocity', 'displacement'; blank: the header's
      character(len=*), intent(in) :: quantity
      !> 'm/s2', 'cm/s2', 'gal', 'g', 'm/s', …; blank: the header's
      character(len=*), intent(in) :: unit
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      !> s; needed for one column of text, else checked; ≤ 0: not given
      real(wp), intent(in), optional :: time_step
      !> cosmos: which section of the quantity, from 1 (default)
      integer, intent(in), optional :: channel
      type(line_reader_type) :: reader
      type(unit_type) :: given
      real(wp) :: step

      call check_request(file, format, quantity, unit, given, error)
      if (allocated(error)) return
      call prepare(record, file, format)
      call given_step(file, time_step, step, error)
      if (.not. allocated(error) .and. record%format == 'auto') call detect(record%format, file, &
         error)
      if (.not. allocated(error)) call open_lines(reader, file, error)
      if (allocated(error)) return
      if (record%format == 'text') record%time_step = step
      call read_format(reader, record, wanted_quantity(quantity, given), channel, error)
      if (.not. allocated(error)) call agree_quantity(reader, record, quantity, given, error)
      if (.not. allocated(error)) call agree_unit(reader, record, unit, given, error)
      if (.not. allocated(error)) call agree_step(reader, record, step, error)
      if (.not. allocated(error)) call to_si(reader, record, error)
      call close_lines(reader)
   end subroutine read_record

   !> Format, quantity and unit that the caller asks for must exist and agree.
   subroutine check_request(file, format, quantity, unit, given, error)
      character(len=*), intent(in) :: file, format, quantity, unit  !< as the caller gives them
      type(unit_type), intent(out) :: given  !< unit that the caller names
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure

      given = find_unit(unit)
      if (.not. any(lower_case(format) == [character(len=6) :: &
         'auto', 'smc', 'at2', 'knet', 'esm', 'cosmos', 'text'])) then
         call fail(error, error_input, 'record '//quoted(file)//': the format '//quoted(format)// &
            ' is unknown; known are '//known_formats)
      else if (.not. any(lower_case(quantity) == [character(len=12) :: '', acceleration, velocity, &
         displacement])) then
         call fail(error, error_input, 'record '//quoted(file)//': the quantity '// &
            quoted(quantity)//' is none of acceleration, velocity, displacement')
      else if (len_trim(unit) > 0 .and. given%scale <= 0.0_wp) then
         call fail(error, error_input, 'record '//quoted(file)//': the unit '//quoted(unit)// &
            ' is unknown; known are '//known_units)
      else if (len_trim(unit) > 0 .and. len_trim(quantity) > 0 .and. given%quantity &
         /= lower_case(quantity)) then
         call fail(error, error_input, 'record '//quoted(file)//': '//quoted(unit)// &
            ' is a unit of '//trim(given%quantity)//', but the quantity is '//trim(quantity))
      end if
   end subroutine check_request

   !> Set what the caller gives; the rest stays blank.
   subroutine prepare(record, file, format)
      type(record_type), intent(inout) :: record  !< filled from the file
      character(len=*), intent(in) :: file, format  !< path; 'auto' or a format

      record%file = trim(file)
      record%format = trim(lower_case(format))
      record%quantity = ''
      record%station = ''
      record%description = ''
      record%unit = ''
   end subroutine prepare

   !> The caller's time step, 0 if there is none.
   subroutine given_step(file, time_step, step, error)
      character(len=*), intent(in) :: file  !< path
      real(wp), intent(in), optional :: time_step  !< s; ≤ 0: not given
      real(wp), intent(out) :: step  !< s; 0: not given
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure

      step = 0.0_wp
      if (.not. present(time_step)) return
      if (.not. ieee_is_finite(time_step)) then
         call fail(error, error_input, 'record '//quoted(file)// &
            ': the time step is not a finite number')
         return
      end if
      step = max(time_step, 0.0_wp)
   end subroutine given_step

   !> The quantity to look for: named, or implied by the unit.
   pure function wanted_quantity(quantity, given) result(wanted)
      !> 'acceleration', 'velocity', 'displacement' or blank
      character(len=*), intent(in) :: quantity
      type(unit_type), intent(in) :: given  !< unit that the caller names
      character(len=:), allocatable :: wanted

      wanted = trim(lower_case(quantity))
      if (wanted == '') wanted = trim(given%quantity)
   end function wanted_quantity

   !> Read the file by the reader of its format.
   subroutine read_format(reader, record, quantity, channel, error)
      type(line_reader_type), intent(inout) :: reader  !< of the file
      type(record_type), intent(inout) :: record  !< filled from the file
      !> 'acceleration', 'velocity', 'displacement' or blank
      character(len=*), intent(in) :: quantity
      integer, intent(in), optional :: channel  !< of a COSMOS file, from 1 (default)
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      integer :: section

      section = 1
      if (present(channel)) section = channel
      if (section /= 1 .and. record%format /= 'cosmos') then
         call fail(error, error_input, quoted(reader%file)//': channel '//to_text(section)// &
            ' was asked for, but a file of the format '//record%format//' has one')
         return
      end if
      select case (record%format)
      case ('smc')
         call read_smc(reader, record, error)
      case ('at2')
         call read_at2(reader, record, error)
      case ('knet')
         call read_knet(reader, record, error)
      case ('esm')
         call read_esm(reader, record, error)
      case ('cosmos')
         call read_cosmos(reader, record, quantity, section, error)
      case default
         call read_text(reader, record, error)
      end select
   end subroutine read_format

   !> The quantity is the header's, the caller's or the unit's; they must not contradict.
   subroutine agree_quantity(reader, record, quantity, given, error)
      type(line_reader_type), intent(in) :: reader  !< of the file, for messages
      type(record_type), intent(inout) :: record  !< filled from the file
      !> 'acceleration', 'velocity', 'displacement' or blank
      character(len=*), intent(in) :: quantity
      type(unit_type), intent(in) :: given  !< unit that the caller names
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      character(len=:), allocatable :: wanted

      wanted = wanted_quantity(quantity, given)
      if (record%quantity == '') record%quantity = wanted
      if (record%quantity == '') then
         call fail(error, error_input, quoted(reader%file)// &
            ' does not say what it holds; give quantity or unit')
      else if (wanted /= '' .and. wanted /= record%quantity) then
         call fail(error, error_input, quoted(reader%file)//' holds '//record%quantity//', not '// &
            wanted)
      end if
   end subroutine agree_quantity

   !> The unit is the header's or the caller's; they must not contradict.
   subroutine agree_unit(reader, record, unit, given, error)
      type(line_reader_type), intent(in) :: reader  !< of the file, for messages
      type(record_type), intent(inout) :: record  !< filled from the file
      character(len=*), intent(in) :: unit  !< blank if the caller names none
      type(unit_type), intent(in) :: given  !< unit that the caller names
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      type(unit_type) :: stated

      stated = find_unit(record%unit)
      if (record%unit == '' .and. len_trim(unit) == 0) then
         call fail(error, error_input, quoted(reader%file)// &
            ' does not state its unit; give one of '//known_units)
      else if (record%unit == '') then
         record%unit = trim(unit)
      else if (stated%quantity /= record%quantity) then
         call fail(error, error_input, quoted(reader%file)//' states the unit '// &
            quoted(record%unit)//', which is not one of '//record%quantity)
      else if (len_trim(unit) > 0 .and. stated%name /= given%name) then
         call fail(error, error_input, quoted(reader%file)//' states the unit '// &
            quoted(record%unit)//', but '//quoted(unit)//' was given; leave the unit blank')
      end if
   end subroutine agree_unit

   !> The time step must be possible, and that of the caller if there is one.
   subroutine agree_step(reader, record, step, error)
      type(line_reader_type), intent(in) :: reader  !< of the file, for messages
      type(record_type), intent(in) :: record  !< as read
      real(wp), intent(in) :: step  !< s, 0: not given
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      real(wp), parameter :: close_enough = 1.0e-3_wp

      call check_time_step(reader, record%time_step, error)
      if (allocated(error) .or. step <= 0.0_wp) return
      if (abs(step - record%time_step) > close_enough*record%time_step) &
         call fail(error, error_input, quoted(reader%file)//' has a time step of '// &
         to_text(record%time_step)//' s, but '//to_text(step)//' s was given')
   end subroutine agree_step

   !> Convert the samples to SI units.
   subroutine to_si(reader, record, error)
      type(line_reader_type), intent(in) :: reader  !< of the file, for messages
      type(record_type), intent(inout) :: record  !< filled from the file
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      type(unit_type) :: unit
      integer :: worst

      unit = find_unit(record%unit)
      worst = maxloc(abs(record%values), 1)
      if (abs(record%values(worst)) > largest_value) then
         call fail(error, error_input, quoted(reader%file)//': sample '//to_text(worst)//' is '// &
            to_text(record%values(worst))//' '//record%unit//', beyond any motion of the ground')
         return
      end if
      record%values = record%values*unit%scale
   end subroutine to_si

end module dda_record
