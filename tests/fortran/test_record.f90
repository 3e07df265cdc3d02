! SPDX-License-Identifier: GPL-3.0-or-later
!> Every format gives the same motion back: 100 sin(2πt) cm/s², 50 samples every 0.02 s.
module test_record
   use dda_kinds, only: wp, pi
   use dda_record, only: record_type, read_record
   use record_files, only: contents, data_file, loma_prieta, remove_scratch, scratch_name, &
      write_changed
   use testing, only: check, check_close, check_fails, check_no_error, error
   implicit none

   integer, parameter :: samples = 50
   real(wp), parameter :: step = 0.02_wp, omega = 2.0_wp*pi
   !> half a unit of the last digit, in parts of the peak
   real(wp), parameter :: printing_error = 1.0e-6_wp
   type(record_type) :: record

contains

   subroutine each_format_yields_the_motion()
      call expect_sine('sine.smc', 'smc', 1.0e-5_wp)
      call expect_sine('sine.at2', 'at2', printing_error)
      call expect_sine('sine_old.at2', 'at2', 1.0e-2_wp)
      call expect_sine('sine.knet', 'knet', 1.0e-5_wp)
      call expect_sine('sine.esm', 'esm', printing_error)
      call expect_sine('sine.v2c', 'cosmos', printing_error)
      call expect_sine('sine.v2', 'cosmos', printing_error)
      call expect_sine('sine_old.v2', 'cosmos', printing_error)
   end subroutine each_format_yields_the_motion

   !> By name and by content; quantity and unit come from the header.
   subroutine expect_sine(name, format, precision)
      character(len=*), intent(in) :: name, format
      real(wp), intent(in) :: precision

      call read_record(record, data_file(name), 'auto', '', '', error)
      call check_no_error(error, name//' by content')
      if (allocated(error)) return
      call check(record%format == format, name//' is told by its content: '//record%format)
      call read_record(record, data_file(name), format, 'acceleration', '', error)
      call check_no_error(error, name)
      if (allocated(error)) return
      call check_close(record%values, sine(1.0_wp), name, relative=precision)
      call check_close(record%time_step, step, name//' step', relative=1.0e-15_wp)
      call check(record%quantity == 'acceleration', name//' quantity')
      call check(len(record%station) + len(record%description) > 0, name//' says what it is')
   end subroutine expect_sine

   subroutine sections_of_a_cosmos_file()
      call expect_section('sine.v2c', 'acceleration', 1, sine(1.0_wp))
      call expect_section('sine.v2c', 'acceleration', 2, -sine(1.0_wp))
      call expect_section('sine.v2c', 'velocity', 1, (1.0_wp - cos(omega*times()))/omega)
      call expect_section('sine.v2c', 'displacement', 1, (times() - sin(omega*times())/omega)/omega)
      call expect_section('sine.v2', 'velocity', 1, (1.0_wp - cos(omega*times()))/omega)
      call expect_section('sine.v2', 'displacement', 1, (times() - sin(omega*times())/omega)/omega)
      call expect_no_section('sine.v2c', 3, 'channel 3')
      call expect_no_section('sine.v2c', 0, 'channel 0')
      call expect_no_section('sine.smc', 2, 'channel 2')
   end subroutine sections_of_a_cosmos_file

   subroutine expect_section(file_name, quantity, channel, expected)
      character(len=*), intent(in) :: file_name, quantity
      integer, intent(in) :: channel
      real(wp), intent(in) :: expected(:)

      call read_record(record, data_file(file_name), 'auto', quantity, '', error, channel=channel)
      call check_no_error(error, file_name//' '//quantity)
      if (.not. allocated(error)) call check_close(record%values, expected, &
         file_name//' '//quantity, relative=printing_error)
   end subroutine expect_section

   subroutine expect_no_section(file_name, channel, expected_text)
      character(len=*), intent(in) :: file_name
      integer, intent(in) :: channel
      character(len=*), intent(in) :: expected_text

      call read_record(record, data_file(file_name), 'auto', 'acceleration', '', error, &
         channel=channel)
      call check_fails(error, expected_text)
   end subroutine expect_no_section

   subroutine columns_of_text()
      call read_record(record, data_file('sine one column.txt'), 'auto', 'acceleration', 'gal', &
         error, time_step=step)
      call check_no_error(error, 'one column')
      if (.not. allocated(error)) call check_close(record%values, sine(1.0_wp), 'one column', &
         relative=printing_error)
      call read_record(record, data_file('sine_time.csv'), 'auto', '', 'cm/s^2', error)
      call check_no_error(error, 'two columns')
      if (allocated(error)) return
      call check_close(record%values, sine(1.0_wp), 'two columns', relative=printing_error)
      call check_close(record%time_step, step, 'step from the times', relative=1.0e-12_wp)
      call check(record%unit == 'cm/s^2', 'unit as given')
      call read_record(record, data_file('sine one column.txt'), 'text', '', 'mm', error, &
         time_step=step)
      call check_no_error(error, 'numbers as millimetres')
      if (allocated(error)) return
      call check(record%quantity == 'displacement', 'the unit implies the quantity')
      call check_close(record%values, sine(0.1_wp), 'millimetres', relative=printing_error)
   end subroutine columns_of_text

   subroutine words_of_the_header()
      call read_record(record, data_file('sine.esm'), 'auto', '', '', error)
      call check_no_error(error, 'esm')
      if (.not. allocated(error)) call check(index(record%station, 'Plätze') > 0, &
         'a name in UTF-8: '//record%station)
      call read_record(record, data_file('sine.v2c'), 'auto', '', '', error, channel=2)
      call check_no_error(error, 'cosmos')
      if (.not. allocated(error)) call check(index(record%description, 'section 2 of 2') > 0, &
         record%description)
   end subroutine words_of_the_header

   !> Valid files with changed headers: the header defines the meaning of the samples.
   subroutine headers_of_other_kinds()
      character(len=:), allocatable :: smc, at2

      smc = contents(data_file('sine.smc'))
      at2 = contents(data_file('sine.at2'))
      call expect_changed(smc, 'CORRECTED ACCELEROGRAM', 'CORRECTED VELOCITY    ', 'velocity', &
         1.0_wp, step)
      call expect_changed(smc, 'CORRECTED ACCELEROGRAM', 'CORRECTED DISPLACEMENT', 'displacement', &
         1.0_wp, step)
      call expect_changed(at2, 'ACCELERATION TIME SERIES IN UNITS OF G', &
         'VELOCITY TIME SERIES IN UNITS OF M/S', 'velocity', 1.0_wp/9.80665_wp, step)
      ! A number that its unit follows without a blank, and begins like an exponent.
      call expect_changed(at2, 'DT=   .0200 SEC', 'DT= .0100each', 'acceleration', 1.0_wp, 0.01_wp)
      ! A comment where a part of the file may begin.
      call expect_changed(contents(data_file('sine.v2c')), '      50 acceleration pts', &
         '| a comment'//new_line('a')//'      50 acceleration pts', 'acceleration', 1.0_wp, step)
      call expect_changed(contents(data_file('sine_time.csv')), '0.00,'//achar(9)//'0.000000', '', &
         '', 0.0_wp, step)
      call remove_scratch()
   end subroutine headers_of_other_kinds

   !> Read a file with a changed text.  A blank quantity means that the first sample was removed.
   subroutine expect_changed(bytes, old, new, quantity, amplitude, time_step)
      character(len=*), intent(in) :: bytes, old, new, quantity
      real(wp), intent(in) :: amplitude, time_step
      character(len=:), allocatable :: unit
      real(wp) :: wave(samples)

      call write_changed(bytes, old, new)
      unit = ''
      if (quantity == '') unit = 'gal'
      call read_record(record, scratch_name, 'auto', '', unit, error)
      call check_no_error(error, new)
      if (allocated(error)) return
      call check_close(record%time_step, time_step, new//' step', relative=1.0e-12_wp)
      if (quantity == '') then
         wave = sine(1.0_wp)
         call check_close(record%values, wave(2:), 'the rest', relative=printing_error)
         call check(index(record%description, 'begin at 0.02 s') > 0, record%description)
      else
         call check(record%quantity == quantity, new//': '//record%quantity)
         call check_close(record%values, sine(amplitude), new, relative=1.0e-5_wp)
      end if
   end subroutine expect_changed

   subroutine units_and_quantities_must_agree()
      call expect_unit('sine.smc', '', 'gal', '')
      call expect_unit('sine.smc', '', 'g', "'g' was given")
      call expect_unit('sine.smc', 'velocity', '', 'not velocity')
      call expect_unit('sine.smc', 'velocity', 'cm/s2', 'is a unit of acceleration')
      call expect_unit('sine.smc', '', 'furlong', "'furlong' is unknown")
      call expect_unit('sine.smc', 'jerk', '', "'jerk'")
      call expect_unit('sine one column.txt', 'acceleration', '', 'does not state its unit')
      call expect_unit('sine one column.txt', '', '', 'does not state its quantity')
      call expect_unit('sine.esm', '', 'cm', 'not displacement')
   end subroutine units_and_quantities_must_agree

   subroutine expect_unit(name, quantity, unit, names)
      character(len=*), intent(in) :: name, quantity, unit
      character(len=*), intent(in) :: names       !< in the error; blank: none expected

      call read_record(record, data_file(name), 'auto', quantity, unit, error, time_step=step)
      if (names == '') then
         call check_no_error(error, name)
      else
         call check_fails(error, names)
      end if
   end subroutine expect_unit

   subroutine time_steps_must_agree()
      call read_record(record, data_file('sine.at2'), 'at2', '', '', error, time_step=0.01_wp)
      call check_fails(error, '0.01')
      call read_record(record, data_file('sine_time.csv'), 'text', '', 'gal', error, &
         time_step=0.01_wp)
      call check_fails(error, '0.01')
      call read_record(record, data_file('sine one column.txt'), 'text', '', 'gal', error)
      call check_fails(error, 'time_step')
      call read_record(record, data_file('sine.at2'), 'at2', '', '', error, time_step=step)
      call check_no_error(error, 'the same step')
   end subroutine time_steps_must_agree

   !> The record of the Loma Prieta earthquake, against the numbers of its own header.
   subroutine a_real_smc_record()
      call read_record(record, data_file(loma_prieta), 'auto', 'acceleration', '', error)
      call check_no_error(error, 'Loma Prieta')
      if (allocated(error)) return
      call check(size(record%values) == 7183, 'number of samples')
      call check_close(record%time_step, 0.005_wp, 'time step')
      call check_close(record%values(1), 0.12714_wp, 'first sample', relative=1.0e-15_wp)
      call check_close(record%values(7183), 0.077033_wp, 'last sample', relative=1.0e-15_wp)
      call check_close(minval(record%values), -2.225194_wp, 'peak', relative=1.0e-4_wp)
      call check(index(record%station, 'APEEL Array #2') > 0, record%station)
   end subroutine a_real_smc_record

   function times() result(time)
      real(wp) :: time(samples)
      integer :: i

      time = [(real(i - 1, wp)*step, i=1, samples)]
   end function times

   function sine(amplitude) result(value)
      real(wp), intent(in) :: amplitude
      real(wp) :: value(samples)

      value = amplitude*sin(omega*times())
   end function sine

end module test_record
