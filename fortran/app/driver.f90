! SPDX-License-Identifier: GPL-3.0-or-later
!> The commands of the native executable.
module dda_driver
   use dda_kinds, only: long
   use dda_arguments, only: arguments_type, names_output, resume_command, usage
   use dda_check_report, only: report_type, report_text, add_notes, verdict_fail
   use dda_check_simulation, only: check_simulation
   use dda_errors, only: error_type, error_check, error_interrupted, fail
   use dda_input, only: read_model_file
   use dda_interrupts, only: fail_if_stopped, stop_requested
   use dda_messages, only: say, warn, progress_type, start_progress, show_progress
   use dda_model, only: model_type
   use dda_model_description, only: model_description
   use dda_model_notes, only: add_notes_to_error, model_notes
   use dda_output_place, only: partial
   use dda_run, only: run_type, begin_run, resume_run, continue_run, end_run, is_done
   use dda_run_verdict, only: run_verdict_type, new_verdict, judge_movement
   use dda_simulation, only: simulation_type, end_of_run, summary
   use dda_peak_check, only: check_peak
   use dda_settings, only: name_output
   use dda_site_response, only: response_peak_type, find_amplification_peak, peak_text
   use dda_stages, only: begin_simulation
   use dda_team, only: team_text
   use dda_text, only: screen_width, to_text, wrapped
   use dda_verdict_lines, only: no_bars, screen_text
   use dda_version, only: version
   implicit none
   private
   public :: act

contains

   !> Perform a command.
   subroutine act(arguments, error)
      type(arguments_type), intent(in) :: arguments  !< arguments of the command line
      type(error_type), allocatable, intent(out) :: error  !< error of the command

      select case (arguments%command)
      case ('help')
         call say(usage())
      case ('version')
         call say('sitedda-native '//version)
      case ('check')
         call check_input(arguments, error)
      case ('run', 'resume')
         if (arguments%check_first) call check_input(arguments, error)
         if (.not. allocated(error)) call run_input(arguments, error)
      end select
   end subroutine act

   !> Print the check of an input; return an error if the check fails.
   subroutine check_input(arguments, error)
      type(arguments_type), intent(in) :: arguments        !< arguments of the command line
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      type(model_type) :: model
      type(simulation_type), allocatable :: simulation
      type(report_type), allocatable :: report
      character(len=:), allocatable :: text

      call read_model_file(model, arguments%file, error, arguments%changes)
      if (allocated(error)) return
      call fail_if_stopped(error)
      if (allocated(error)) return
      call print_description(model)
      allocate (simulation, report)
      call add_notes(report, model_notes(model))
      call begin_simulation(simulation, model, error)
      if (.not. allocated(error)) call check_simulation(simulation, report, error)
      call add_notes_to_error(error, model_notes(model))
      if (allocated(error)) return
      text = report_text(report)
      call say(text(:len(text) - 1))
      if (report%worst_verdict == verdict_fail) call fail(error, error_check, &
         arguments%file//': the check fails')
   end subroutine check_input

   !> Run an input file to its end and print the requested results.
   subroutine run_input(arguments, error)
      type(arguments_type), intent(in) :: arguments  !< arguments of the command line
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      type(model_type), allocatable :: model
      type(run_type), allocatable :: run

      allocate (model)
      call read_model_file(model, arguments%file, error, arguments%changes)
      if (allocated(error)) return
      if (names_output(arguments)) call name_output(model%output, model%output%file)
      if (arguments%output /= '') call name_output(model%output, arguments%output)
      if (.not. arguments%check_first) call print_description(model)
      if (.not. arguments%check_first) call print_notes(model)
      call fail_if_stopped(error)
      if (allocated(error)) return
      allocate (run)
      if (arguments%command == 'resume') then
         call resume_run(run, model, error)
         if (.not. allocated(error)) call say(run%notice)
      else
         call begin_run(run, model, .true., error)
      end if
      deallocate (model)  ! the run has a copy
      if (.not. allocated(error)) call step_to_end(run, arguments, error)
      call close_run(run, error)
      if (allocated(error)) return
      if (.not. run%was_complete) call print_summary(run%simulation)
      call print_amplifications(run%simulation, run%was_complete, error)
   end subroutine run_input

   !> Print the assumptions of a model: its elastic law, and the kind of its motions.
   subroutine print_description(model)
      type(model_type), intent(in) :: model  !< model as read from the input
      integer :: i

      associate (lines => model_description(model))
         do i = 1, size(lines)
            call print_wrapped(trim(lines(i)))
         end do
      end associate
   end subroutine print_description

   !> Print a text, wrapped to the width of the screen.
   subroutine print_wrapped(message)
      character(len=*), intent(in) :: message  !< words with single blanks between
      character(len=:), allocatable :: text

      text = wrapped(message, 6, screen_width)
      call say(text(:len(text) - 1))
   end subroutine print_wrapped

   !> Print probable mistakes in a model.
   subroutine print_notes(model)
      type(model_type), intent(in) :: model  !< model as read from the input
      integer :: i

      associate (notes => model_notes(model))
         do i = 1, size(notes)
            call print_wrapped('note: '//trim(notes(i)))
         end do
      end associate
   end subroutine print_notes

   !> Perform steps until the run is complete or a signal stops it.
   subroutine step_to_end(run, arguments, error)
      type(run_type), intent(inout) :: run  !< run and its files
      type(arguments_type), intent(in) :: arguments  !< arguments of the command line
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      type(progress_type) :: progress

      call start_progress(progress, run%simulation%time, arguments%quiet)
      do while (.not. is_done(run))
         call continue_run(run, 1_long, error)
         if (allocated(error)) return
         if (stop_requested() .and. .not. is_done(run)) call fail(error, error_interrupted, &
            'interrupted at t = '//to_text(run%simulation%time)//' s; the results so far are '// &
            'in '//run%simulation%model%output%file//partial//'; to continue: '// &
            resume_command(arguments))
         if (allocated(error)) return
         call show_progress(progress, run%simulation%time, end_of_run(run%simulation))
      end do
   end subroutine step_to_end

   !> Close the output; an earlier error is retained.
   subroutine close_run(run, error)
      type(run_type), intent(inout) :: run  !< run and its files
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(error_type), allocatable :: failure

      call end_run(run, failure)
      if (.not. allocated(failure)) return
      if (.not. allocated(error)) then
         error = failure
      else if (error%kind == error_interrupted) then  ! the named output does not exist
         error = error_type(failure%kind, 'interrupted at t = '// &
            to_text(run%simulation%time)//' s; '//failure%message)
      else
         error%message = error%message//'; '//failure%message
      end if
   end subroutine close_run

   !> Print events, results, warnings, counts of the run, and its output.
   subroutine print_summary(simulation)
      type(simulation_type), intent(in) :: simulation  !< simulation at its present time
      type(run_verdict_type) :: verdict
      character(len=:), allocatable :: text

      verdict = new_verdict(simulation, 0, 0)
      call judge_movement(verdict, simulation)
      call say(screen_text(verdict))
      text = wrapped(summary(simulation), 0, screen_width)
      call say(new_line('a')//text(:len(text) - 1))
      if (team_text() /= '') call say('note: '//team_text())
      call say('output: '//simulation%model%output%file)
      call say(no_bars)
   end subroutine print_summary

   !> Print the amplification peaks of an input from its output.
   !> Their differences from the exact peaks are printed too.
   subroutine print_amplifications(simulation, was_complete, error)
      type(simulation_type), intent(in) :: simulation  !< simulation at the end of the run
      logical, intent(in) :: was_complete  !< the output was complete, so nothing was run
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      type(response_peak_type) :: peak
      character(len=:), allocatable :: warning
      integer :: i

      associate (model => simulation%model)
         do i = 1, size(model%amplifications)
            call find_amplification_peak(model%output%file, model%amplifications(i), peak, error)
            if (allocated(error)) return
            call print_wrapped(peak_text(model, model%amplifications(i), peak))
            if (was_complete) cycle
            call check_peak(simulation, model%amplifications(i), peak, warning)
            if (warning /= '') call warn('warning: '//warning)
         end do
      end associate
   end subroutine print_amplifications

end module dda_driver
