! SPDX-License-Identifier: GPL-3.0-or-later
!> Run an input and print how far a measured point of it moves.
!>
!> usage: crest FILE.nml POINT
program crest
   use, intrinsic :: iso_fortran_env, only: error_unit
   use sitedda, only: wp, analysis_type, error_type, exit_status, read_input, begin_analysis, &
      advance_analysis, end_analysis, is_complete, present_time, read_history
   implicit none
   integer, parameter :: steps = 500  ! between lines
   type(analysis_type) :: analysis
   type(error_type), allocatable :: error, trouble
   character(len=256) :: file, point
   real(wp), allocatable :: time(:), x(:), y(:)
   integer :: largest

   call get_command_argument(1, file)
   call get_command_argument(2, point)
   call read_input(analysis, trim(file), error, changes=['output.file=crest.nc'])
   if (.not. allocated(error)) call begin_analysis(analysis, error)
   do while (.not. (allocated(error) .or. is_complete(analysis)))
      call advance_analysis(analysis, steps, error)
      print '(a, f8.3, a)', 't =', present_time(analysis), ' s'
   end do
   call end_analysis(analysis, trouble)  ! also after an error: what there is stays readable
   if (.not. allocated(error) .and. allocated(trouble)) error = trouble
   if (.not. allocated(error)) call read_history(analysis, 'displacement', time, x, error, &
      point=trim(point), axis='x')
   if (.not. allocated(error)) call read_history(analysis, 'displacement', time, y, error, &
      point=trim(point), axis='y')
   if (allocated(error)) then
      write (error_unit, '(2a)') 'crest: ', error%message
      stop exit_status(error), quiet=.true.
   end if
   largest = maxloc(hypot(x, y), 1)
   print '(a, es12.5, a, f8.3, a)', 'largest', hypot(x(largest), y(largest)), ' m at t =', &
      time(largest), ' s'
end program crest
