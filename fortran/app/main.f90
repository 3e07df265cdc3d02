!> sitedda-native: run an input without Python.
program sitedda_native
   use, intrinsic :: iso_fortran_env, only: error_unit
   use dda_kinds, only: long
   use dda_arguments, only: arguments_type, read_arguments, resume_command, usage
   use dda_check_report, only: report_type, report_text, verdict_fail
   use dda_check_simulation, only: check_simulation
   use dda_errors, only: error_type, error_check, error_interrupted, fail
   use dda_input, only: read_model_file
   use dda_model, only: model_type
   use dda_output_file, only: partial_name
   use dda_progress, only: progress_type, start_progress, show_progress
   use dda_run, only: run_type, begin_run, resume_run, continue_run, end_run, is_done
   use dda_interrupts, only: watch_interrupts, stop_requested
   use dda_simulation, only: simulation_type, summary
   use dda_start, only: start
   use dda_site_response, only: amplification_peak, peak_text
   use dda_spectrum, only: peak_type
   use dda_text, only: to_text
   use dda_diagnostics, only: audit_warning
   use dda_version, only: version
   implicit none

   type(arguments_type) :: arguments
   type(error_type), allocatable :: error

   call watch_interrupts
   call read_arguments(arguments, error)
   call leave_on(error)
   select case (arguments%command)
   case ('help')
      print '(a)', usage()
   case ('version')
      print '(a)', 'sitedda-native '//version
   case ('check')
      call check_input(arguments%file, error)
      call leave_on(error)
   case ('run', 'resume')
      if (arguments%check_first) call check_input(arguments%file, error)
      call leave_on(error)
      call run_input(arguments, error)
      call leave_on(error)
   end select

contains

   !> Print what a run will meet; an error if it should not be started.
   subroutine check_input(file, error)
      character(len=*), intent(in) :: file
      type(error_type), allocatable, intent(out) :: error
      type(model_type) :: model
      type(simulation_type), allocatable :: simulation
      type(report_type), allocatable :: report

      call read_model_file(model, file, error)
      if (allocated(error)) return
      allocate (simulation, report)
      call start(simulation, model, error)
      if (.not. allocated(error)) call check_simulation(simulation, report, error)
      if (allocated(error)) return
      write (*, '(a)', advance='no') report_text(report)
      if (report%worst == verdict_fail) call fail(error, error_check, file//': the check fails')
   end subroutine check_input

   !> Run an input file to its end and print what it asks for.
   subroutine run_input(arguments, error)
      type(arguments_type), intent(in) :: arguments
      type(error_type), allocatable, intent(out) :: error
      type(model_type) :: model
      type(run_type), allocatable :: run

      call read_model_file(model, arguments%file, error)
      if (allocated(error)) return
      if (arguments%output /= '') model%output%file = arguments%output
      allocate (run)
      if (arguments%command == 'resume') then
         call resume_run(run, model, error)
         if (.not. allocated(error)) print '(a)', run%notice
      else
         call begin_run(run, model, .true., error)
      end if
      if (.not. allocated(error)) call step_to_end(run, arguments, error)
      call close_run(run, error)
      if (allocated(error)) return
      print '(a)', summary(run%simulation)
      if (audit_warning(run%simulation) /= '') write (error_unit, '(a)') 'warning: '// &
         audit_warning(run%simulation)
      print '(a)', 'output: '//model%output%file
      call print_amplifications(model, error)
   end subroutine run_input

   !> Step until the run is done or a signal asks it to stop.
   subroutine step_to_end(run, arguments, error)
      type(run_type), intent(inout) :: run
      type(arguments_type), intent(in) :: arguments
      type(error_type), allocatable, intent(out) :: error
      type(progress_type) :: progress

      call start_progress(progress, run%simulation%time, arguments%quiet)
      do while (.not. is_done(run))
         call continue_run(run, 1_long, error)
         if (allocated(error)) return
         if (stop_requested() .and. .not. is_done(run)) then
            call fail(error, error_interrupted, 'interrupted at t = '// &
               to_text(run%simulation%time)//' s; the results so far are in '// &
               partial_name(run%simulation%model%output%file)//'; to go on: '// &
               resume_command(arguments))
            return
         end if
         associate (control => run%simulation%model%control)
            call show_progress(progress, run%simulation%time, control%steps*control%time_step)
         end associate
      end do
   end subroutine step_to_end

   !> Close the output also after an error, which stays the one to report.
   subroutine close_run(run, error)
      type(run_type), intent(inout) :: run
      type(error_type), allocatable, intent(inout) :: error
      type(error_type), allocatable :: trouble

      call end_run(run, trouble)
      if (.not. allocated(error) .and. allocated(trouble)) error = trouble
   end subroutine close_run

   subroutine print_amplifications(model, error)
      type(model_type), intent(in) :: model
      type(error_type), allocatable, intent(out) :: error
      type(peak_type) :: peak
      integer :: i

      do i = 1, size(model%amplifications)
         call amplification_peak(model%output%file, model%amplifications(i), peak, error)
         if (allocated(error)) return
         print '(a)', peak_text(model, model%amplifications(i), peak)
      end do
   end subroutine print_amplifications

   !> The only stop: an error becomes a message and an exit status.
   subroutine leave_on(error)
      type(error_type), allocatable, intent(in) :: error

      if (.not. allocated(error)) return
      write (error_unit, '(a)') 'sitedda-native: '//error%message
      stop error%kind, quiet=.true.
   end subroutine leave_on

end program sitedda_native
