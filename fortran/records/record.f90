! SPDX-License-Identifier: GPL-3.0-or-later
!> Recorded motions in any of the formats of the strong-motion networks.
module dda_record
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use dda_kinds, only: wp
   use dda_errors, only: error_type, fail, error_input
   use dda_text, only: lower_case, quoted, to_text
   use dda_text_lines, only: line_reader_type, open_lines
   use dda_record_type, only: record_type, acceleration, velocity, displacement, unit_type, &
      find_unit, known_units
   use dda_record_samples, only: check_time_step
   use dda_record_smc, only: read_smc
   use dda_record_at2, only: read_at2
   use dda_record_knet, only: read_knet
   use dda_record_esm, only: read_esm
   use dda_record_cosmos, only: read_cosmos
   use dda_record_text, only: read_text
   use dda_record_format, only: detect_format, known_formats
   implicit none
   private
   public :: record_type, read_record

   ! largest value of a record, SI units: beyond any ground motion, far from overflow
   real(wp), parameter :: largest_value = 1.0e9_wp

contains

   !> Read a record, check it against its header, and convert it to SI units.
   subroutine read_record(record, file, format, quantity, unit, error, time_step, channel)
      type(record_type), intent(out) :: record  !< record as read
      character(len=*), intent(in) :: file      !< path
      !> 'auto', 'smc', 'at2', 'knet', 'esm', 'cosmos' or 'text'
      character(len=*), intent(in) :: format
      !> 'acceleration', 'velocity', 'displacement'; blank: as in the header
      character(len=*), intent(in) :: quantity
      !> 'm/s2', 'cm/s2', 'gal', 'g', 'm/s', …; blank: as in the header
      character(len=*), intent(in) :: unit
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      !> time step, s; needed for one column of text, otherwise checked; ≤ 0: not given
      real(wp), intent(in), optional :: time_step
      !> format cosmos: number of the section with this quantity, from 1 (default)
      integer, intent(in), optional :: channel
      type(line_reader_type) :: reader
      type(unit_type) :: stated_unit
      character(len=:), allocatable :: stated_quantity
      real(wp) :: step
      integer :: section

      step = 0.0_wp
      if (present(time_step)) step = time_step
      section = 1
      if (present(channel)) section = channel
      stated_unit = find_unit(unit)
      call check_request(file, format, quantity, unit, stated_unit, step, error)
      if (allocated(error)) return
      ! The caller names the quantity, or the unit implies it.
      stated_quantity = trim(lower_case(quantity))
      if (stated_quantity == '') stated_quantity = trim(stated_unit%quantity)
      record%file = trim(file)
      record%format = trim(lower_case(format))
      record%quantity = ''
      record%station = ''
      record%description = ''
      record%unit = ''
      call open_lines(reader, file)
      if (record%format == 'auto') call detect_format(reader, record%format)
      if (record%format == 'text') record%time_step = max(step, 0.0_wp)
      call read_format(reader, record, stated_quantity, section)
      if (.not. allocated(reader%error)) call check_header(reader, record, stated_quantity, unit, &
         stated_unit, step)
      if (.not. allocated(reader%error)) call to_si(reader, record)
      if (allocated(reader%error)) error = reader%error
   end subroutine read_record

   !> Check that the requested format, quantity, unit and time step are known and consistent.
   subroutine check_request(file, format, quantity, unit, stated_unit, step, error)
      character(len=*), intent(in) :: file, format, quantity, unit  !< values given by the caller
      type(unit_type), intent(in) :: stated_unit  !< unit that the caller names
      real(wp), intent(in) :: step  !< time step, s; ≤ 0: not given
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      character(len=:), allocatable :: failure

      failure = ''
      if (.not. any(lower_case(format) == [character(len=6) :: &
         'auto', 'smc', 'at2', 'knet', 'esm', 'cosmos', 'text'])) then
         failure = 'the format '//quoted(format)//' is unknown; known are '//known_formats
      else if (.not. any(lower_case(quantity) == [character(len=12) :: '', acceleration, velocity, &
         displacement])) then
         failure = 'the quantity '//quoted(quantity)//' is unknown; known are '// &
            'acceleration, velocity, displacement'
      else if (len_trim(unit) > 0 .and. stated_unit%scale <= 0.0_wp) then
         failure = 'the unit '//quoted(unit)//' is unknown; known are '//known_units
      else if (len_trim(unit) > 0 .and. len_trim(quantity) > 0 .and. stated_unit%quantity &
         /= lower_case(quantity)) then
         failure = quoted(unit)//' is a unit of '//trim(stated_unit%quantity)// &
            ', but the quantity is '//trim(quantity)
      else if (.not. ieee_is_finite(step)) then
         failure = 'the time step is not a finite number'
      end if
      if (failure /= '') call fail(error, error_input, 'record '//quoted(file)//': '//failure)
   end subroutine check_request

   !> Read the file by the reader of its format.
   subroutine read_format(reader, record, quantity, section)
      type(line_reader_type), intent(inout) :: reader  !< reader of the file
      type(record_type), intent(inout) :: record  !< record, filled from the file
      !> 'acceleration', 'velocity', 'displacement' or blank
      character(len=*), intent(in) :: quantity
      integer, intent(in) :: section  !< section of a COSMOS file, from 1

      if (section /= 1 .and. record%format /= 'cosmos') call refuse_file(reader, ': channel '// &
         to_text(section)//' was requested, but files of format '//record%format//' have only one')
      select case (record%format)
      case ('smc')
         call read_smc(reader, record)
      case ('at2')
         call read_at2(reader, record)
      case ('knet')
         call read_knet(reader, record)
      case ('esm')
         call read_esm(reader, record)
      case ('cosmos')
         call read_cosmos(reader, record, quantity, section)
      case default
         call read_text(reader, record)
      end select
   end subroutine read_format

   !> Set quantity, unit and time step from the header or the caller.  If both give a value, the
   !> values must agree.
   subroutine check_header(reader, record, stated_quantity, unit, stated_unit, step)
      type(line_reader_type), intent(inout) :: reader  !< reader of the file; receives errors
      type(record_type), intent(inout) :: record  !< record; receives what the header lacks
      character(len=*), intent(in) :: stated_quantity, unit  !< of the caller, or blank
      type(unit_type), intent(in) :: stated_unit  !< unit that the caller names
      real(wp), intent(in) :: step  !< time step, s; ≤ 0: not given
      real(wp), parameter :: close_enough = 1.0e-3_wp
      type(unit_type) :: stated

      if (record%quantity == '') record%quantity = stated_quantity
      if (record%unit == '') record%unit = trim(unit)
      stated = find_unit(record%unit)
      call check_time_step(reader, record%time_step)
      if (record%quantity == '') then
         call refuse_file(reader, ' does not state its quantity; give its unit')
      else if (stated_quantity /= '' .and. stated_quantity /= record%quantity) then
         call refuse_file(reader, ' contains '//record%quantity//', not '//stated_quantity)
      else if (record%unit == '') then
         call refuse_file(reader, ' does not state its unit; give one of '//known_units)
      else if (stated%quantity /= record%quantity) then
         call refuse_file(reader, ' states the unit '//quoted(record%unit)// &
            ', which is not one of '//record%quantity)
      else if (len_trim(unit) > 0 .and. stated%name /= stated_unit%name) then
         call refuse_file(reader, ' states the unit '//quoted(record%unit)//', but '// &
            quoted(unit)//' was given; leave the unit blank')
      else if (step > 0.0_wp .and. abs(step - record%time_step) &
         > close_enough*record%time_step) then
         call refuse_file(reader, ' has a time step of '//to_text(record%time_step)//' s, but '// &
            to_text(step)//' s was given')
      end if
   end subroutine check_header

   !> Convert the samples to SI units.
   subroutine to_si(reader, record)
      type(line_reader_type), intent(inout) :: reader  !< reader of the file; receives errors
      type(record_type), intent(inout) :: record  !< record with its unit
      type(unit_type) :: unit
      integer :: worst

      unit = find_unit(record%unit)
      worst = maxloc(abs(record%values), 1)
      if (abs(record%values(worst)) > largest_value) call refuse_file(reader, ': sample '// &
         to_text(worst)//' is '//to_text(record%values(worst))//' '//record%unit// &
         ', beyond any motion of the ground')
      record%values = record%values*unit%scale
   end subroutine to_si

   !> Return an input error of the file as a whole; an earlier error is retained.
   subroutine refuse_file(reader, message)
      type(line_reader_type), intent(inout) :: reader  !< reader of the file; receives errors
      character(len=*), intent(in) :: message  !< message after the name of the file

      if (.not. allocated(reader%error)) call fail(reader%error, error_input, &
         quoted(reader%file)//message)
   end subroutine refuse_file

end module dda_record
