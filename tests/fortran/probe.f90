! SPDX-License-Identifier: GPL-3.0-or-later
!> Answers a list of hostile files one by one: reads each, takes a few steps, looks for what is not
!> finite.
!>
!> Requests on standard input, `input FILE` or `record FILE`; one answer each on standard output:
!> `ok`, `refused KIND MESSAGE`, or `not finite WHAT`.  The fuzzer tests/robustness/fuzz.py sends
!> the requests and watches time, memory and life of this process.
program probe
   use, intrinsic :: ieee_exceptions, only: ieee_all, ieee_get_halting_mode, ieee_set_halting_mode
   use, intrinsic :: iso_fortran_env, only: output_unit
   use dda_kinds, only: wp, long
   use dda_check_report, only: report_type
   use dda_check_simulation, only: check_simulation
   use dda_energy, only: energy_values
   use dda_errors, only: error_type
   use dda_input, only: read_model_file
   use dda_measure, only: measure_point
   use dda_model, only: model_type
   use dda_record, only: record_type, read_record
   use dda_baseline, only: motion_curve_type, make_motion_curve
   use dda_run, only: run_type, begin_run, continue_run
   use dda_simulation, only: simulation_type
   use dda_text, only: to_text
   implicit none
   integer, parameter :: max_blocks_stepped = 300  !< blocks; larger models are read and set up only
   integer, parameter :: max_blocks_checked = 40       !< blocks of models that the check looks at
   integer(long), parameter :: steps = 5
   character(len=4096) :: request
   logical :: halting(size(ieee_all))
   integer :: status

   call ieee_get_halting_mode(ieee_all, halting)
   do
      read (*, '(a)', iostat=status) request
      if (status /= 0) exit
      ! Reading meets NaN and infinity on purpose; the pre-check and the steps must not.
      call ieee_set_halting_mode(ieee_all, .false.)
      if (index(request, 'record ') == 1) then
         call answer_record(trim(request(8:)))
      else
         call answer_input(trim(request(7:)))
      end if
      flush (output_unit)
   end do

contains

   subroutine answer_input(file)
      character(len=*), intent(in) :: file
      type(model_type) :: model
      type(run_type), allocatable :: run
      type(error_type), allocatable :: error
      character(len=:), allocatable :: fault

      fault = ''
      call read_model_file(model, file, error)
      allocate (run)
      if (.not. allocated(error)) call begin_run(run, model, .false., error)
      call ieee_set_halting_mode(ieee_all, halting)
      if (.not. allocated(error) .and. run%simulation%blocks%n <= max_blocks_checked) &
         fault = strange_line(run%simulation)
      if (.not. allocated(error) .and. run%simulation%blocks%n <= max_blocks_stepped) &
         call continue_run(run, steps, error)
      if (allocated(error)) then
         call refuse(error)
      else
         if (fault == '') fault = strange_part(run%simulation)
         call judge(fault)
      end if
   end subroutine answer_input

   !> Return the part of the check report that is not finite; blank: none.  The check may reject
   !> the model, but must return.
   function strange_line(simulation) result(name)
      type(simulation_type), intent(in) :: simulation
      character(len=:), allocatable :: name
      type(report_type), allocatable :: report
      type(error_type), allocatable :: error
      integer :: i

      name = ''
      allocate (report)
      call check_simulation(simulation, report, error)
      if (allocated(error)) return
      associate (highest => report%omega_max)
         if (strange([highest%omega, highest%residual, highest%bracket%lower, &
            highest%bracket%upper, report%frequency_shift, report%band%lowest, &
            report%band%highest])) name = 'check, numbers of the report'
      end associate
      if (report%has_modes) then
         if (strange([report%modes%frequency, report%modes%damping, report%modes%elongation])) &
            name = 'check, modes'
      end if
      do i = 1, report%n
         associate (found => report%line(i)%finding)
            if (index(found, 'NaN') == 0 .and. index(found, 'Infinity') == 0 &
               .and. index(found, '**') == 0) cycle
            name = 'check, '//report%line(i)%subject//': '//found
         end associate
      end do
   end function strange_line

   !> Return the part of the state that is not finite; blank: none.
   function strange_part(simulation) result(fault)
      type(simulation_type), intent(in) :: simulation
      character(len=:), allocatable :: fault
      real(wp) :: motion(2, 3)
      integer :: i

      fault = ''
      do i = 1, size(simulation%model%points)
         call measure_point(simulation%blocks, simulation%model%points(i), motion(:, 1), &
            motion(:, 2), motion(:, 3))
         if (strange(reshape(motion, [6]))) fault = 'measured point '//to_text(i)
      end do
      associate (contacts => simulation%contacts(simulation%now))
         if (strange(contacts%normal_force(:contacts%n)) &
            .or. strange(contacts%shear_force(:contacts%n)) &
            .or. strange(contacts%new_gap(:contacts%n)) &
            .or. strange(contacts%stretch(:contacts%n))) fault = 'contacts'
      end associate
      if (strange(energy_values(simulation%energy))) fault = 'energies'
      if (strange(reshape(simulation%blocks%velocity, &
         [6*simulation%blocks%n]))) fault = 'velocities'
      if (strange(reshape(simulation%blocks%vertex, [size(simulation%blocks%vertex)]))) &
         fault = 'vertices'
      if (strange(reshape(simulation%blocks%position, [6*simulation%blocks%n]))) &
         fault = 'coordinates'
   end function strange_part

   subroutine answer_record(file)
      character(len=*), intent(in) :: file
      type(record_type) :: record
      type(motion_curve_type) :: curve
      type(error_type), allocatable :: error
      character(len=:), allocatable :: fault

      call read_record(record, file, 'auto', '', '', error)
      if (.not. allocated(error)) call make_motion_curve(curve, record%quantity, record%values, &
         record%time_step, error)
      if (allocated(error)) then
         call refuse(error)
         return
      end if
      fault = ''
      if (strange(curve%acceleration) .or. strange(curve%velocity) &
         .or. strange(curve%displacement)) fault = 'motion'
      if (strange([curve%time_step, curve%duration])) fault = 'times'
      call judge(fault)
   end subroutine answer_record

   pure logical function strange(values)
      real(wp), intent(in) :: values(:)

      strange = .not. all(abs(values) <= huge(1.0_wp))
   end function strange

   subroutine judge(fault)
      character(len=*), intent(in) :: fault

      if (fault == '') print '(a)', 'ok'
      if (fault /= '') print '(2a)', 'not finite ', fault
   end subroutine judge

   subroutine refuse(error)
      type(error_type), intent(in) :: error

      print '(3a)', 'refused ', to_text(error%kind)//' ', error%message
   end subroutine refuse

end program probe
