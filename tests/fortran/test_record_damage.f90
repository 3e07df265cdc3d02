! SPDX-License-Identifier: GPL-3.0-or-later
!> Damaged and hostile record files: one clear error each, never a crash, never a wrong motion.
module test_record_damage
   use, intrinsic :: ieee_arithmetic, only: ieee_positive_inf, ieee_value
   use dda_kinds, only: wp
   use dda_errors, only: error_file, error_input
   use dda_record, only: record_type, read_record
   use record_files, only: data_file, write_changed, write_scratch, contents, scratch_name
   use testing, only: check, check_fails, check_no_error, error
   implicit none

   character(len=*), parameter :: nl = new_line('a')
   type(record_type) :: record

contains

   subroutine missing_files()
      call read_record(record, data_file(''), 'auto', '', '', error)
      call check_fails(error, 'records')
      if (allocated(error)) call check(error%kind == error_file, 'a folder is an error of the file')
      call read_record(record, 'no such file', 'auto', '', '', error)
      call check_fails(error, 'no such file')
      call read_record(record, ' ', 'auto', '', '', error)
      call check_fails(error, 'blank')
      call read_record(record, scratch_name, 'sac', '', '', error)
      call check_fails(error, "'sac'")
      call write_scratch('')
      call expect_error('auto', 'empty')
   end subroutine missing_files

   !> An invalid time step, and a path that is too long.
   subroutine invalid_requests()
      call read_record(record, scratch_name, 'text', '', 'm', error, time_step=ieee_value(1.0_wp, &
         ieee_positive_inf))
      call check_fails(error, 'not a finite number')
      call read_record(record, repeat('folder/', 100)//'record.smc', 'smc', '', '', error)
      call check_fails(error, 'record.smc')
      if (allocated(error)) call check(len(error%message) < 500, 'a long path is shortened')
   end subroutine invalid_requests

   !> A hole of 300 MB behind the first byte: refused by its size, not read.
   subroutine a_file_that_is_too_large()
      integer :: unit

      open (newunit=unit, file=scratch_name, access='stream', form='unformatted', action='write', &
         status='replace')
      write (unit, pos=300000000) '1'
      close (unit)
      call expect_error('text', 'bytes long')
   end subroutine a_file_that_is_too_large

   subroutine binary_files()
      call write_scratch('1.0'//nl//'2.0'//achar(0)//nl)
      call expect_error('text', 'line 2: the byte 0')
      call write_scratch(repeat('1.0 ', 500000))
      call expect_error('text', 'line 1: the line is longer')
      call write_scratch(repeat(char(200)//char(3)//'x', 100))
      call expect_error('auto', 'the byte 3')
      call write_scratch('once upon a time'//nl//'there was no record'//nl)
      call expect_error('auto', 'format is not recognised')
   end subroutine binary_files

   subroutine counts_that_do_not_fit()
      call damaged('.smc', '        50    -32768', '        51    -32768', 'after 50 of the 51')
      call damaged('.smc', '        50    -32768', '        45    -32768', 'more than the 45')
      call damaged('.smc', '        50    -32768', '1000000000000 -32768', '1000000000000 samples')
      call damaged('.smc', '        50    -32768', '         1    -32768', 'at least 2')
      call damaged('.at2', 'NPTS=     50', 'NPTS=     45', 'follows the 45')
      call damaged('.at2', 'NPTS=     50', 'NPTS=   1e12', '1000000000000 samples')
      call damaged('.at2', 'NPTS=     50', 'NPTS=   50.5', '50.5')
      call damaged('.at2', 'NPTS=     50', 'NPTS=    -10', '-10')
      call damaged('.knet', 'Time(s)  1', 'Time(s)  2', 'after 50 of the 100')
      call damaged('.knet', 'Time(s)  1', 'Time(s) .5', 'the 25')
      call damaged('.knet', 'Time(s)  1', 'Time(s)  1e300', '1e300')
      call damaged('.esm', 'NDATA: 50', 'NDATA: 49', 'follows the 49')
      call damaged('.esm', 'DURATION_S: 1.000', 'DURATION_S: 3.000', '3 s')
      call damaged('.v2c', '      50 acceleration pts', '99999999 acceleration pts', '99999999')
      call damaged('.v2c', ' 100 Integer-header', '9999 Integer-header', 'Real-header')
   end subroutine counts_that_do_not_fit

   subroutine invalid_numbers()
      call damaged('.at2', '0.0000000E+00', '          NaN', "line 5: 'NaN'")
      call damaged('.at2', '0.0000000E+00', '       1e400 ', "'1e400' is too large")
      call damaged('.at2', '0.0000000E+00', '   3*5       ', "'3*5'")
      call damaged('.at2', '0.0000000E+00', '*************', "'****")
      call damaged('.at2', '0.0000000E+00', '        1e200', 'beyond any motion')
      call damaged('.smc', ' 0.0000E+0 1.2533E+1', ' Infinity  1.2533E+1', "'Infinity'")
      call damaged('.smc', ' 0.0000E+0 1.2533E+1', '12.345678901.2533E+1', '12.34567890')
      call damaged('_time.csv', '12.533323', '12.53,3323', 'more than two columns')
      call damaged('.knet', '   52569 ', '   52569e12 ', 'counts')
   end subroutine invalid_numbers

   subroutine columns_that_do_not_fit()
      call expect_text('0 1'//nl//'1 2'//nl//'3 2'//nl//'4 3', &
         'line 3: the time 3 s is 2 s after')
      call expect_text('0 1'//nl//'1 2'//nl//'1 2'//nl, 'line 3: the time 1 s does not follow')
      call expect_text('0 1'//nl//'1'//nl, 'line 2: 1 number(s)')
      call expect_text('1 2 3'//nl, 'more than two columns')
      call expect_text('# nothing'//nl//'1.5 ! one'//nl, 'after 1 sample')
      call expect_text('1'//nl//'2,,3'//nl, 'line 2')
      call expect_text('0 1'//nl//'1e200 2'//nl//'3 4'//nl, 'beyond any record')
      call expect_text('0 1'//nl//'1e-9 2'//nl//'2e-9 4'//nl, 'time step')
      call expect_text('1'//nl//'x'//nl, "line 2: 'x' is not a number")
   end subroutine columns_that_do_not_fit

   subroutine headers_that_do_not_fit()
      call damaged('.smc', '  0.5000000E+02', '  0.1700000E+39', 'sampling rate')
      call damaged('.smc', 'CORRECTED ACCELEROGRAM', 'RESPONSE SPECTRA      ', 'not a time series')
      call damaged('.smc', '| 100 sin', '  100 sin', 'is not a comment')
      call damaged('.smc', '    -32768    -32768    -32768', '    -32768    -32768', &
         'integers of an SMC header')
      call damaged('.at2', 'DT=   .0200', 'DT=      -1', 'time step -1')
      call damaged('.at2', 'DT=   .0200', 'DX=   .0200', 'dt= number')
      call damaged('.at2', 'UNITS OF G', 'UNITS OF H', 'does not state its unit')
      call damaged('_old.at2', '      50   .02000', '      50  unknown', 'does not begin with')
      call write_scratch(repeat('a line without numbers'//nl, 20))
      call expect_error('at2', 'the first lines do not state NPTS')
      call damaged('.knet', '2000(gal)/8388608', '2000(gal)/0      ', 'scale factor')
      call damaged('.knet', '2000(gal)/8388608', '2000 gal          ', 'scale factor')
      call damaged('.knet', '50Hz', 'many', "'many'")
      call damaged('.esm', 'UNITS: cm/s^2', 'UNITS: cm/s^3', 'cm/s^3')
      call damaged('.esm', 'UNITS: cm/s^2', 'UNITS: cm/s', 'not one of acceleration')
      call damaged('.esm', 'DATA_TYPE: ACC', 'DATA_TYPE: ABC', 'ABCELERATION')
      call damaged('.esm', 'NDATA', 'MDATA', 'NDATA')
      call damaged('.v2c', '      20.000000', '    -999.000000', 'time step')
      call damaged('.smc', 'CORRECTED ACCELEROGRAM', 'CORRECTED SEISMOGRAM  ', &
         'is not acceleration, velocity')
      call damaged('.smc', '    -32768         2', '    -32768        -2', '-2 comment lines')
      call damaged('.smc', '  0.1700000E+39  0.5000000E+02', '  0.1700000E+39'//nl// &
         '  0.5000000E+02', 'lines instead of')
      call damaged('.knet', '50Hz', '0Hz ', 'positive numbers')
      call damaged('.esm', 'DATA_TYPE: ACCELERATION', 'DATA_TYPE: RESPONSE SPECTRUM', &
         'not a time series')
      call damaged('.esm', 'DATA_TYPE: ACCELERATION', 'DATA_TYPE: VELOCITY', 'not one of velocity')
      call damaged('.esm', 'DATA_TYPE: ACCELERATION', 'DATA_TYPE: DISPLACEMENT', &
         'not one of displacement')
      call damaged('.v2c', ' 100 Integer-header', '-100 Integer-header', 'declared')
      call damaged('.v2c', 'units=cm/sec2', 'units=counts ', "'counts'")
      call damaged('.v2c', '       1.000000', '       9.000000', '9 s')
   end subroutine headers_that_do_not_fit

   !> A truncated file is an error, unless only a line end is missing.
   subroutine a_file_that_is_cut_anywhere()
      character(len=8), parameter :: names(7) = [character(len=8) :: '.smc', '.at2', '.knet', &
         '.esm', '.v2c', '.v2', '_old.at2']
      character(len=:), allocatable :: bytes
      integer :: i, length, retained

      do i = 1, size(names)
         bytes = contents(data_file('sine'//trim(names(i))))
         ! Other sections follow in these two; what matters is the cut within the last one.
         length = len(bytes)
         if (names(i) == '.v2c') length = index(bytes, 'Corrected velocity')
         if (names(i) == '.v2') length = index(bytes, 'points of veloc')
         do retained = 1, length - 200, 37
            call write_scratch(bytes(:retained))
            call read_record(record, scratch_name, 'auto', 'acceleration', '', error)
            call check(allocated(error), trim(names(i))//' cut short is an error')
         end do
      end do
   end subroutine a_file_that_is_cut_anywhere

   !> LF, CR LF, CR, a missing last line end and a final Ctrl-Z are equivalent.
   subroutine line_ends()
      character(len=2), parameter :: ends(3) = [achar(10)//' ', achar(13)//achar(10), achar(13)// &
         ' ']
      integer :: i

      do i = 1, size(ends)
         call write_scratch('1'//trim(ends(i))//trim(ends(i))//'2'//trim(ends(i))//achar(9)//'3'// &
            achar(26)//ends(i))
         call read_record(record, scratch_name, 'text', '', 'm', error, time_step=0.1_wp)
         call check_no_error(error, 'line end')
         if (.not. allocated(error)) call check(size(record%values) == 3, 'three samples')
      end do
   end subroutine line_ends

   !> Replace the first occurrence in a good file; the damage must be found and named.
   subroutine damaged(suffix, old, new, names)
      character(len=*), intent(in) :: suffix, old, new, names

      call write_changed(contents(data_file('sine'//suffix)), old, new)
      call expect_error('auto', names)
   end subroutine damaged

   subroutine expect_text(bytes, names)
      character(len=*), intent(in) :: bytes, names

      call write_scratch(bytes)
      call expect_error('text', names)
   end subroutine expect_text

   subroutine expect_error(format, names)
      character(len=*), intent(in) :: format, names
      type(record_type) :: record
      character(len=:), allocatable :: unit

      unit = ''
      if (format == 'text' .or. index(names, 'columns') > 0) unit = 'm/s2'
      if (format == 'text') call read_record(record, scratch_name, format, '', unit, error, &
         time_step=0.1_wp)
      if (format /= 'text') call read_record(record, scratch_name, format, '', unit, error)
      call check_fails(error, names)
      if (.not. allocated(error)) return
      call check(index(error%message, scratch_name) > 0, 'the file is named: '//error%message)
      call check(error%kind == error_input .or. error%kind == error_file, 'kind of the error')
   end subroutine expect_error

end module test_record_damage
