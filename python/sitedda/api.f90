! SPDX-License-Identifier: GPL-3.0-or-later
!> All that f2py reads: the engine behind integer handles and plain arrays.
!>
!> Every routine returns a status, 0 or the kind of an error, and a message.  Python holds the
!> handle and frees it; a handle that is not open is an error, never a crash.
module api
   use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_double_complex, c_int, c_ptr
   use dda_advice, only: penalty_type, penalty_for_frequency, penalty_for_shift
   use dda_check_report, only: report_type, report_text, add_notes
   use dda_check_simulation, only: check_simulation
   use dda_contact_table, only: contact_table, contact_variables, whole_columns
   use dda_damping, only: damping_type, fit_body, most_mechanisms
   use dda_elements, only: block_stress, bolt_states
   use dda_energy, only: energy_terms, energy_values
   use dda_baseline, only: baseline_type, motion_curve_type, make_motion_curve
   use dda_branches, only: branches_type, curve_type, fit_branches, set_body
   use dda_errors, only: error_type, error_input, fail
   use dda_input, only: read_model
   use dda_input_boundaries, only: boundary_kinds
   use dda_input_changes, only: change_type, change_text
   use dda_interrupts, only: ask_host, fail_if_stopped, request_stop
   use dda_input_catalogue, only: find_group
   use dda_input_joint, only: reduced_strengths
   use dda_input_text, only: group_type, parse_group, split_groups
   use dda_input_variable, only: unset
   use dda_joint_law, only: strength_type
   use dda_maxima, only: known, maxima_table, number_of_maxima
   use dda_measure, only: measure_point
   use dda_kinds, only: long, pi
   use dda_linear_model, only: linear_model_type, linearise
   use dda_model, only: model_type
   use dda_model_description, only: model_description
   use dda_model_notes, only: model_notes, note_length
   use dda_modes, only: modes_type, find_modes
   use dda_process, only: process_id
   use dda_peak_check, only: peak_warning
   use dda_record, only: record_type, read_record
   use dda_response_spectrum, only: oscillator_peaks
   use dda_run, only: run_type, begin_run, open_drawn, resume_run, change_run, continue_run, &
      flush_run, save_run, end_run, is_done
   use dda_settings, only: name_output
   use dda_scheme, only: scheme_type, scheme_named, integration_names
   use dda_scheme_response, only: free_damping, period_elongation, forced_damping, steps_to_decay, &
      amplification_roots, steady_type, steady_weights, step_for_damping, theta_for_damping
   use dda_running_maxima, only: take_residuals
   use dda_simulation, only: simulation_type, end_of_run, summary, ending
   use dda_shear_column, only: shear_column_type, shear_state_type, begin_column, shake_column, &
      end_accelerations, energy_balance
   use dda_site_response, only: response_peak_type, amplification_peak
   use dda_start, only: set_rates
   use dda_spectrum, only: spectral_peak_type, fourier_spectrum, amplification, find_peak
   use dda_stopwatch, only: phase_names, seconds_of
   use dda_diagnostics, only: audit_warning
   use dda_team, only: team_words
   use dda_text, only: joined, to_text
   use dda_transfer, only: transfer_type, prepare_transfer, transfer_at, undamped_transfer_at
   use dda_version, only: version, commit
   implicit none
   private
   public :: open_run, advance_run, change_input, save_state, finish_run, close_run, &
      set_block_states, make_table, read_table, make_text, read_text
   public :: check_run, mode_shapes, transfer_of, first_mode_penalty, shift_penalty
   public :: read_ground_motion
   public :: scheme_numbers, scheme_vibration, scheme_steady, scheme_for_damping, body_of
   public :: soil_branches, shake_soil
   public :: spectrum_of, amplification_of, peak_of, oscillator_peaks_of
   public :: hear_python, stop_engine
   public :: engine_version, engine_commit, engine_names, parse_input, parsed_input, &
      reduced_joint, make_changes

   integer, parameter :: most_runs = 65536

   type(group_type), allocatable :: parsed(:)     !< of the text that was parsed last

   !> One slot of the table of open runs.
   type :: slot_type
      type(run_type), pointer :: run => null()
      integer(c_int) :: process = 0   !< that opened it
      !> on the model as it was read, a line each
      character(len=note_length), allocatable :: notes(:)
      real(c_double), allocatable :: table(:,:)  !< that was made last
      character(len=:), allocatable :: text      !< that was made last
   end type slot_type

   type(slot_type) :: slots(0:most_runs)

   interface
      !> Python: take the lock of the interpreter, which this thread may or may not hold; its state.
      integer(c_int) function take_lock() bind(c, name='PyGILState_Ensure')
         import :: c_int
      end function take_lock

      !> Python: give the lock back.
      subroutine give_lock(state) bind(c, name='PyGILState_Release')
         import :: c_int
         integer(c_int), value :: state  !< from `take_lock`
      end subroutine give_lock

      !> Python: the exception that waits to be raised in this thread, or null.
      type(c_ptr) function exception() bind(c, name='PyErr_Occurred')
         import :: c_ptr
      end function exception

      !> Python: call the handlers of signals that have come; not 0 if one raises an exception.
      integer(c_int) function call_handlers() bind(c, name='PyErr_CheckSignals')
         import :: c_int
      end function call_handlers
   end interface

contains

   !> From here on a signal whose handler in Python raises an exception, as Ctrl-C does, ends what
   !> the engine is at; the exception is raised when the call returns.
   subroutine hear_python()
      call ask_host(has_exception)
   end subroutine hear_python

   !> Whether a handler of a signal has raised an exception: 1 yes.
   integer(c_int) function has_exception() bind(c)
      integer(c_int) :: state

      state = take_lock()
      has_exception = 1
      if (.not. c_associated(exception())) has_exception = merge(1_c_int, 0_c_int, &
         call_handlers() /= 0)
      call give_lock(state)
   end function has_exception

   !> Ask the engine to stop in this thread, for a signal; 0: no longer.
   subroutine stop_engine(number)
      integer(c_int), intent(in) :: number  !< of the signal

      call request_stop(number)
   end subroutine stop_engine

   !> The open run of a handle; an error otherwise.
   subroutine find_run(handle, run, error)
      integer(c_int), intent(in) :: handle
      type(run_type), pointer, intent(out) :: run
      type(error_type), allocatable, intent(out) :: error

      run => null()
      if (handle >= 1 .and. handle <= most_runs) run => slots(handle)%run
      if (.not. associated(run)) then
         call fail(error, error_input, 'the simulation is closed')
      else if (run%writes .and. slots(handle)%process /= process_id()) then
         ! The files are those of the process that this one was forked from.
         call fail(error, error_input, 'the simulation writes an output for another process')
      end if
   end subroutine find_run

   !> An error as status and message.
   subroutine report(error, status, message)
      type(error_type), allocatable, intent(in) :: error
      integer(c_int), intent(out) :: status
      character(len=2048), intent(out) :: message

      status = 0
      message = ''
      if (.not. allocated(error)) return
      status = error%kind
      message = error%message
   end subroutine report

   !> Read an input text and begin a run of it.
   subroutine open_run(file, text, output, writes, drawn, handle, status, message)
      !> where the text is from; its folder holds the records
      character(len=*), intent(in) :: file
      character(len=*), intent(in) :: text
      character(len=*), intent(in) :: output    !< output file in place of the input's, or blank
      integer(c_int), intent(in) :: writes      !< 1: write the output file; 2: go on with one
      integer(c_int), intent(in) :: drawn       !< 1: the first stage begins with the first advance
      integer(c_int), intent(out) :: handle, status
      character(len=2048), intent(out) :: message
      type(error_type), allocatable :: error
      type(model_type) :: model

      handle = 0
      call read_model(model, file, text, error)
      if (.not. allocated(error)) call fail_if_stopped(error)
      if (.not. allocated(error)) then
         if (output /= '') call name_output(model%output, output)
         handle = findloc([(associated(slots(handle)%run), handle=1, most_runs)], .false., 1)
         if (handle == 0) call fail(error, error_input, 'too many simulations are open')
      end if
      if (.not. allocated(error)) then
         allocate (slots(handle)%run)
         slots(handle)%process = process_id()
         slots(handle)%notes = model_notes(model)
         if (writes == 2) then
            call resume_run(slots(handle)%run, model, error)
         else if (drawn == 1) then
            call open_drawn(slots(handle)%run, model, writes == 1, error)
         else
            call begin_run(slots(handle)%run, model, writes == 1, error)
         end if
         if (allocated(error)) call drop(handle)
      end if
      call report(error, status, message)
   end subroutine open_run

   subroutine drop(handle)
      integer(c_int), intent(inout) :: handle

      deallocate (slots(handle)%run)
      handle = 0
   end subroutine drop

   !> Take up to `steps` steps.
   subroutine advance_run(handle, steps, done, status, message)
      integer(c_int), intent(in) :: handle, steps
      integer(c_int), intent(out) :: done  !< 1: the duration is reached
      integer(c_int), intent(out) :: status
      character(len=2048), intent(out) :: message
      !f2py threadsafe
      type(error_type), allocatable :: error
      type(run_type), pointer :: run

      done = 0
      call find_run(handle, run, error)
      if (.not. allocated(error)) then
         call continue_run(run, int(steps, long), error)
         call flush_run(run, error)
         done = merge(1, 0, is_done(run))
      end if
      call report(error, status, message)
   end subroutine advance_run

   !> Change the input of a run between two steps; the words say what is changed.
   subroutine change_input(handle, text, words, status, message)
      integer(c_int), intent(in) :: handle
      character(len=*), intent(in) :: text, words
      integer(c_int), intent(out) :: status
      character(len=2048), intent(out) :: message
      type(error_type), allocatable :: error
      type(run_type), pointer :: run

      call find_run(handle, run, error)
      if (.not. allocated(error)) call change_run(run, text, words, error)
      call report(error, status, message)
   end subroutine change_input

   !> Write a checkpoint now, if the run writes an output.
   subroutine save_state(handle, status, message)
      integer(c_int), intent(in) :: handle
      integer(c_int), intent(out) :: status
      character(len=2048), intent(out) :: message
      type(error_type), allocatable :: error
      type(run_type), pointer :: run

      call find_run(handle, run, error)
      if (.not. allocated(error)) call save_run(run, error)
      call report(error, status, message)
   end subroutine save_state

   !> Close the output file: named if the run is done, else left as FILE.partial with a checkpoint.
   subroutine finish_run(handle, status, message)
      integer(c_int), intent(in) :: handle
      integer(c_int), intent(out) :: status
      character(len=2048), intent(out) :: message
      type(error_type), allocatable :: error
      type(run_type), pointer :: run

      call find_run(handle, run, error)
      if (.not. allocated(error)) call end_run(run, error)
      call report(error, status, message)
   end subroutine finish_run

   !> Free a run; an output that is still open is closed as it is.
   subroutine close_run(handle)
      integer(c_int), intent(in) :: handle
      type(error_type), allocatable :: error
      type(run_type), pointer :: run

      call find_run(handle, run, error)
      if (allocated(error)) return
      call end_run(run, error)
      deallocate (slots(handle)%run)
   end subroutine close_run

   !> Make a table of a run, which `read_table` hands over; its shape.
   subroutine make_table(handle, what, sizes, status, message)
      integer(c_int), intent(in) :: handle
      character(len=*), intent(in) :: what      !< see `take_table`
      integer(c_int), intent(out) :: sizes(2)
      integer(c_int), intent(out) :: status
      character(len=2048), intent(out) :: message
      type(error_type), allocatable :: error
      type(run_type), pointer :: run

      call find_run(handle, run, error)
      if (.not. allocated(error)) call take_table(run, what, slots(handle)%table, error)
      sizes = 0
      if (.not. allocated(error)) sizes = shape(slots(handle)%table)
      call report(error, status, message)
   end subroutine make_table

   !> The table that was made last.
   subroutine read_table(handle, rows, columns, values)
      integer(c_int), intent(in) :: handle, rows, columns
      real(c_double), intent(out) :: values(rows, columns)

      values = slots(handle)%table
   end subroutine read_table

   !> A table of a run: one of its blocks and contacts, or of its course.
   subroutine take_table(run, what, table, error)
      type(run_type), intent(inout) :: run
      character(len=*), intent(in) :: what
      real(c_double), allocatable, intent(out) :: table(:,:)
      type(error_type), allocatable, intent(inout) :: error

      call take_state(run%simulation, what, table)
      if (.not. allocated(table)) call take_course(run, what, table, error)
      if (.not. (allocated(table) .or. allocated(error))) call fail(error, error_input, &
         'there is no table '//what)
   end subroutine take_table

   !> 'coordinates' and 'rates' [6, blocks], 'stresses' [3, blocks]; 'blocks': material from 0,
   !> body, 1 if it is removed [blocks, 3]; 'vertices' [2, vertices]; 'edges', by the vertex where
   !> each begins: block and joint from 0, 1 within a body [vertices, 3]; 'contacts' [contacts,
   !> columns]; 'boundary_edges': edge and group from 0, shares of the edge [pieces, 4]; 'bolts':
   !> axial and shear force, stretch, state [4, bolts]; 'points': displacement, velocity,
   !> acceleration [2, 3 points].
   subroutine take_state(simulation, what, table)
      type(simulation_type), intent(inout) :: simulation
      character(len=*), intent(in) :: what
      real(c_double), allocatable, intent(out) :: table(:,:)
      integer :: i

      associate (blocks => simulation%blocks, model => simulation%model)
         select case (what)
         case ('coordinates')
            table = blocks%position
            table(1:2, :) = table(1:2, :) + spread(model%origin, 2, blocks%n)
         case ('rates')
            table = blocks%velocity
         case ('stresses')
            table = block_stress(simulation%elements, blocks)
         case ('blocks')
            table = as_columns([blocks%material - 1, blocks%body, merge(1, 0, blocks%removed)], 3)
         case ('vertices')
            table = blocks%vertex + spread(model%origin, 2, size(blocks%owner))
         case ('edges')
            table = as_columns([blocks%owner - 1, blocks%joint - 1, merge(1, 0, blocks%inner)], 3)
         case ('contacts')
            table = contact_table(simulation)
         case ('boundary_edges')
            associate (edges => model%boundary_edges)
               table = reshape([real(edges%piece%edge - 1, c_double), real(edges%group - 1, &
                  c_double), edges%piece%from, edges%piece%to], [size(edges), 4])
            end associate
         case ('bolts')
            allocate (table(4, size(model%bolts)))
            if (size(table) > 0) table = bolt_states(simulation%elements, size(model%bolts))
         case ('points')
            allocate (table(2, 3*size(model%points)))
            do i = 1, size(model%points)
               call measure_point(blocks, model%points(i), table(:, 3*i - 2), table(:, 3*i - 1), &
                  table(:, 3*i))
            end do
         end select
      end associate
   end subroutine take_state

   !> Whole numbers one after the other, as columns of a table.
   pure function as_columns(numbers, columns) result(table)
      integer, intent(in) :: numbers(:), columns
      real(c_double) :: table(size(numbers)/columns, columns)

      table = reshape(real(numbers, c_double), shape(table))
   end function as_columns

   !> 'clock': time, duration, last time step (s), steps done, open-close iterations of the last
   !> step, gravity (m/s2), penalty stiffness (N/m); of the present stage: its number, the step and
   !> the time (s) that it began after, its steps and their length (s); 'energies'; 'counts';
   !> 'phases': seconds since the first call, which starts the watch [1, n]; 'maxima': largest
   !> values of all steps, their times, present values, blocks and points from 0 [7, maxima].
   subroutine take_course(run, what, table, error)
      type(run_type), intent(inout) :: run
      character(len=*), intent(in) :: what
      real(c_double), allocatable, intent(out) :: table(:,:)
      type(error_type), allocatable, intent(inout) :: error

      associate (simulation => run%simulation, solver => run%simulation%solver)
         select case (what)
         case ('clock')
            table = as_row([simulation%time, end_of_run(simulation), simulation%last_time_step, &
               real(simulation%step, c_double), real(simulation%iteration%iterations, c_double), &
               simulation%model%control%gravity, simulation%model%contact%normal_stiffness, &
               real(simulation%stage, c_double), real(simulation%first_step, c_double), &
               simulation%first_time, real(simulation%model%control%steps, c_double), &
               simulation%model%control%time_step])
         case ('energies')
            table = as_row(energy_values(simulation%energy))
         case ('counts')
            table = as_row(real([simulation%step, simulation%counters%iterations, &
               simulation%counters%searches, solver%solves, solver%factors, solver%iterations, &
               solver%handed_over, simulation%counters%broken], c_double))
         case ('phases')
            simulation%system%watch%running = .true.
            table = as_row(seconds_of(simulation%system%watch))
         case ('maxima')
            call take_maxima(run, table, error)
         end select
      end associate
   end subroutine take_course

   !> Numbers as a table.
   pure function as_row(numbers) result(table)
      real(c_double), intent(in) :: numbers(:)
      real(c_double) :: table(1, size(numbers))

      table(1, :) = numbers
   end function as_row

   !> Largest values; a complete output that has only been opened has none.
   subroutine take_maxima(run, table, error)
      type(run_type), intent(inout) :: run
      real(c_double), allocatable, intent(out) :: table(:,:)
      type(error_type), allocatable, intent(inout) :: error
      integer :: i

      if (run%was_complete) call fail(error, error_input, 'the output is complete: read its maxima')
      if (allocated(error)) return
      allocate (table(7, number_of_maxima), source=-1.0_c_double)
      call take_residuals(run%simulation)
      associate (found => run%simulation%maxima)
         table(1, :) = known(found%largest)
         table(2, :) = found%largest%time
         table(3, :) = known(found%last)
         do i = 1, number_of_maxima
            if (maxima_table(i)%of_points) table(6:7, i) = found%largest(i)%who - 1
            if (.not. maxima_table(i)%of_points) table(4:5, i) = found%largest(i)%who - 1
         end do
      end associate
   end subroutine take_maxima

   !> Make a text of a run, which `read_text` hands over; its length in bytes.  'output', 'title',
   !> 'solver', 'summary', 'ending', 'warning', 'notice', 'threads'; 'changed', the input with the
   !> changes between steps, and 'values', what it means; 'description', 'notes', 'points' and
   !> 'blocks' (names), 'peaks' (what is wrong with those of amplifications), a line each.
   subroutine make_text(handle, what, length, status, message)
      integer(c_int), intent(in) :: handle
      character(len=*), intent(in) :: what
      integer(c_int), intent(out) :: length, status
      character(len=2048), intent(out) :: message
      type(error_type), allocatable :: error
      type(run_type), pointer :: run
      character(len=:), allocatable :: made

      call find_run(handle, run, error)
      length = 0
      if (.not. allocated(error)) then
         made = ''
         associate (model => run%simulation%model)
            select case (what)
            case ('output')
               made = model%output%file
            case ('title')
               made = model%title
            case ('solver')
               made = trim(run%simulation%solver%method)
            case ('notice')
               if (allocated(run%notice)) made = run%notice
            case ('summary')
               made = summary(run%simulation)
            case ('ending')
               made = ending(run%simulation)
            case ('description')
               made = lines(model_description(model))
            case ('notes')
               made = lines(slots(handle)%notes)
            case ('threads')
               made = team_words()
            case ('warning')
               made = audit_warning(run%simulation)
            case ('peaks')
               call find_peak_warnings(run, made)
            case ('changed')
               made = run%simulation%changed_text
            case ('values')
               made = model%values
            case ('points')
               made = lines(model%points%name)
            case ('blocks')
               made = lines(model%block_names)
            end select
         end associate
         length = len(made)
         call move_alloc(made, slots(handle)%text)
      end if
      call report(error, status, message)
   end subroutine make_text

   !> Texts, each with its line end.
   pure function lines(texts) result(all)
      character(len=*), intent(in) :: texts(:)
      character(len=:), allocatable :: all
      integer :: i, at

      allocate (character(len=sum(len_trim(texts)) + size(texts)) :: all)
      at = 0
      do i = 1, size(texts)
         all(at + 1:at + len_trim(texts(i)) + 1) = trim(texts(i))//new_line('a')
         at = at + len_trim(texts(i)) + 1
      end do
   end function lines

   !> The text that was made last of a run; of handle 0, by `make_changes`.
   subroutine read_text(handle, n, bytes)
      integer(c_int), intent(in) :: handle, n
      integer(c_int), intent(out) :: bytes(n)
      integer :: i

      bytes = [(iachar(slots(handle)%text(i:i)), i=1, n)]
   end subroutine read_text

   !> What is wrong with the peaks of the amplifications in the finished output, a line each.
   subroutine find_peak_warnings(run, text)
      type(run_type), intent(in) :: run
      character(len=:), allocatable, intent(inout) :: text
      type(error_type), allocatable :: unused
      type(response_peak_type) :: peak
      character(len=:), allocatable :: warning
      integer :: i

      if (run%was_complete .or. .not. is_done(run)) return
      associate (model => run%simulation%model)
         do i = 1, size(model%amplifications)
            call amplification_peak(model%output%file, model%amplifications(i), peak, unused)
            if (allocated(unused)) cycle  ! who asks for the peak itself is told
            call peak_warning(run%simulation, model%amplifications(i), peak, warning)
            if (warning /= '') text = text//warning//new_line('a')
         end do
      end associate
   end subroutine find_peak_warnings

   !> Set the rates of all blocks, such as a mode's shape for a free vibration.
   subroutine set_block_states(handle, n, rates, status, message)
      integer(c_int), intent(in) :: handle, n
      real(c_double), intent(in) :: rates(6, n)
      integer(c_int), intent(out) :: status
      character(len=2048), intent(out) :: message
      type(error_type), allocatable :: error
      type(run_type), pointer :: run

      call find_run(handle, run, error)
      if (.not. allocated(error)) call check_size(n, run%simulation%blocks%n, error)
      if (.not. allocated(error)) call set_rates(run%simulation, rates, error)
      call report(error, status, message)
   end subroutine set_block_states

   subroutine check_size(given, wanted, error)
      integer, intent(in) :: given, wanted
      type(error_type), allocatable, intent(out) :: error

      if (given /= wanted) call fail(error, error_input, 'the array has not the size of the model')
   end subroutine check_size

   !> A complete output that has only been opened has no state.
   subroutine require_state(run, error)
      type(run_type), intent(in) :: run
      type(error_type), allocatable, intent(inout) :: error

      if (run%was_complete) call fail(error, error_input, 'the output is complete: read its maxima')
   end subroutine require_state

   !> Largest displacement, velocity and absolute acceleration of oscillators under a motion.
   subroutine oscillator_peaks_of(n, acceleration, time_step, oscillators, frequency, damping, &
      largest)
      integer(c_int), intent(in) :: n, oscillators
      real(c_double), intent(in) :: acceleration(n), time_step, frequency(oscillators), damping
      real(c_double), intent(out) :: largest(3, oscillators)
      integer :: i

      do i = 1, oscillators
         largest(:, i) = oscillator_peaks(acceleration, time_step, frequency(i), damping)
      end do
   end subroutine oscillator_peaks_of

   !> One-sided Fourier spectrum of a series, [bins] = padding*samples/2 + 1.
   subroutine spectrum_of(n, series, time_step, padding, taper, bins, frequency, spectrum, status, &
      message)
      integer(c_int), intent(in) :: n, padding, bins
      real(c_double), intent(in) :: series(n), time_step, taper
      real(c_double), intent(out) :: frequency(bins)
      complex(c_double_complex), intent(out) :: spectrum(bins)
      integer(c_int), intent(out) :: status
      character(len=2048), intent(out) :: message
      type(error_type), allocatable :: error
      real(c_double), allocatable :: f(:)
      complex(c_double_complex), allocatable :: s(:)

      frequency = 0.0_c_double
      spectrum = 0.0_c_double
      call fourier_spectrum(series, time_step, f, s, error, padding, taper)
      if (.not. allocated(error)) call check_size(bins, size(f), error)
      if (.not. allocated(error)) then
         frequency = f
         spectrum = s
      end if
      call report(error, status, message)
   end subroutine spectrum_of

   !> Ratio of the spectra of two series.
   subroutine amplification_of(n, surface, base, time_step, padding, taper, bins, frequency, &
      ratio, status, message)
      integer(c_int), intent(in) :: n, padding, bins
      real(c_double), intent(in) :: surface(n), base(n), time_step, taper
      real(c_double), intent(out) :: frequency(bins)
      complex(c_double_complex), intent(out) :: ratio(bins)
      integer(c_int), intent(out) :: status
      character(len=2048), intent(out) :: message
      type(error_type), allocatable :: error
      real(c_double), allocatable :: f(:)
      complex(c_double_complex), allocatable :: r(:)

      frequency = 0.0_c_double
      ratio = 0.0_c_double
      call amplification(surface, base, time_step, f, r, error, padding, taper)
      if (.not. allocated(error)) call check_size(bins, size(f), error)
      if (.not. allocated(error)) then
         frequency = f
         ratio = r
      end if
      call report(error, status, message)
   end subroutine amplification_of

   !> Peak between two frequencies: frequency, amplitude, bin width, 1 if interpolated.
   subroutine peak_of(bins, frequency, amplitude, lowest, highest, peak, status, message)
      integer(c_int), intent(in) :: bins
      real(c_double), intent(in) :: frequency(bins), amplitude(bins), lowest, highest
      real(c_double), intent(out) :: peak(4)
      integer(c_int), intent(out) :: status
      character(len=2048), intent(out) :: message
      type(error_type), allocatable :: error
      type(spectral_peak_type) :: found

      call find_peak(frequency, amplitude, lowest, highest, found, error)
      peak = [found%frequency, found%amplitude, found%bin_width, merge(1.0_c_double, 0.0_c_double, &
         found%interpolated)]
      call report(error, status, message)
   end subroutine peak_of

   !> The check report as text, its worst verdict (1 ok, 2 warn, 3 fail), and its numbers:
   !> omega_max, its bracket (rad/s), its residual, shift of the first frequency, band (Hz), steps
   !> in which the slowest alternating mode falls to 1/e (0: none alternates; huge: it does not
   !> decay), memory (bytes) and duration (s) of the run, about.
   subroutine check_run(handle, text, worst, numbers, status, message)
      integer(c_int), intent(in) :: handle
      character(len=16384), intent(out) :: text
      integer(c_int), intent(out) :: worst
      real(c_double), intent(out) :: numbers(10)
      integer(c_int), intent(out) :: status
      character(len=2048), intent(out) :: message
      type(error_type), allocatable :: error
      type(run_type), pointer :: run
      type(report_type), allocatable :: found

      text = ''
      worst = 0
      numbers = 0.0_c_double
      allocate (found)
      call find_run(handle, run, error)
      if (.not. allocated(error)) then
         call add_notes(found, slots(handle)%notes)
         call check_simulation(run%simulation, found, error)
      end if
      if (.not. allocated(error)) then
         text = report_text(found)
         worst = found%worst
         numbers = [found%highest%omega, found%highest%bracket%lower, found%highest%bracket%upper, &
            found%highest%residual, found%shift, found%band%lowest, found%band%highest, &
            found%ringing, found%memory, found%seconds]
      end if
      call report(error, status, message)
   end subroutine check_run

   !> Lowest modes: frequency (Hz), damping and period elongation by the scheme, participation in x
   !> and y (sqrt(kg)), effective mass in x and y as shares; shapes [6, blocks, modes],
   !> mass-normalised.
   subroutine mode_shapes(handle, which, n, wanted, found, values, shapes, words, status, message)
      integer(c_int), intent(in) :: handle, n, wanted
      character(len=*), intent(in) :: which  !< contacts: 'auto', 'closed', 'present' or 'settled'
      integer(c_int), intent(out) :: found
      real(c_double), intent(out) :: values(7, wanted), shapes(6, n, wanted)
      character(len=2048), intent(out) :: words
      integer(c_int), intent(out) :: status
      character(len=2048), intent(out) :: message
      type(error_type), allocatable :: error
      type(run_type), pointer :: run
      type(linear_model_type) :: linear
      type(modes_type) :: modes
      integer :: i

      found = 0
      values = 0.0_c_double
      shapes = 0.0_c_double
      words = ''
      call find_run(handle, run, error)
      if (.not. allocated(error)) call check_size(n, run%simulation%blocks%n, error)
      if (.not. allocated(error)) call linearise(linear, run%simulation, which, error)
      if (.not. allocated(error)) call find_modes(linear, wanted, modes, error)
      if (.not. allocated(error)) then
         found = min(wanted, modes%n)
         words = modes%words
         do i = 1, found
            values(:, i) = [modes%frequency(i), modes%damping(i), modes%elongation(i), &
               modes%participation(:, i), modes%effective_mass(:, i)]
            shapes(:, :, i) = modes%shape(:, :, i)
         end do
      end if
      call report(error, status, message)
   end subroutine mode_shapes

   !> Transfer function between two measured points (from 1) for base motion along an axis (1 x, 2
   !> y).
   subroutine transfer_of(handle, which, points, axis, n, frequency, damped, values, status, &
      message)
      integer(c_int), intent(in) :: handle, points(2), axis, n, damped
      character(len=*), intent(in) :: which
      real(c_double), intent(in) :: frequency(n)
      complex(c_double_complex), intent(out) :: values(n)
      integer(c_int), intent(out) :: status
      character(len=2048), intent(out) :: message
      type(error_type), allocatable :: error
      type(run_type), pointer :: run
      type(linear_model_type) :: linear
      type(transfer_type) :: transfer
      integer :: i

      values = 0.0_c_double
      call find_run(handle, run, error)
      if (.not. allocated(error)) call linearise(linear, run%simulation, which, error)
      if (.not. allocated(error)) call prepare_transfer(transfer, linear, points, [axis, axis], &
         axis, maxval(frequency), error)
      if (.not. allocated(error)) then
         do i = 1, n
            call fail_if_stopped(error)
            if (allocated(error)) exit
            if (damped == 1) then
               values(i) = transfer_at(transfer, frequency(i))
            else
               values(i) = undamped_transfer_at(transfer, frequency(i))
            end if
         end do
      end if
      call report(error, status, message)
   end subroutine transfer_of

   !> The penalty that gives the first mode a frequency (Hz): stiffness, frequency, stiff limit.
   subroutine first_mode_penalty(handle, which, target, values, status, message)
      integer(c_int), intent(in) :: handle
      character(len=*), intent(in) :: which
      real(c_double), intent(in) :: target
      real(c_double), intent(out) :: values(3)
      integer(c_int), intent(out) :: status
      character(len=2048), intent(out) :: message
      type(error_type), allocatable :: error
      type(run_type), pointer :: run
      type(linear_model_type) :: linear
      type(penalty_type) :: penalty

      values = 0.0_c_double
      call find_run(handle, run, error)
      if (.not. allocated(error)) call linearise(linear, run%simulation, which, error)
      if (.not. allocated(error)) call penalty_for_frequency(linear, target, penalty, error)
      if (.not. allocated(error)) call take_penalty(penalty, values, error)
      call report(error, status, message)
   end subroutine first_mode_penalty

   !> The penalty that lowers the first frequency by a percentage of its stiff limit.
   subroutine shift_penalty(handle, which, percent, values, status, message)
      integer(c_int), intent(in) :: handle
      character(len=*), intent(in) :: which
      real(c_double), intent(in) :: percent
      real(c_double), intent(out) :: values(3)
      integer(c_int), intent(out) :: status
      character(len=2048), intent(out) :: message
      type(error_type), allocatable :: error
      type(run_type), pointer :: run
      type(linear_model_type) :: linear
      type(penalty_type) :: penalty

      values = 0.0_c_double
      call find_run(handle, run, error)
      if (.not. allocated(error)) call linearise(linear, run%simulation, which, error)
      if (.not. allocated(error)) call penalty_for_shift(linear, percent, penalty, error)
      if (.not. allocated(error)) call take_penalty(penalty, values, error)
      call report(error, status, message)
   end subroutine shift_penalty

   subroutine take_penalty(penalty, values, error)
      type(penalty_type), intent(in) :: penalty
      real(c_double), intent(out) :: values(3)
      type(error_type), allocatable, intent(out) :: error

      values = [penalty%normal_stiffness, penalty%frequency, penalty%limit]
      if (.not. penalty%found) call fail(error, error_input, penalty%words)
   end subroutine take_penalty

   !> A record as acceleration, velocity and displacement [3, n] at its samples; n = 0 asks for the
   !> size only. options: time step (s, or 0), drift order (-1: 2 for accelerations, else 0), taper,
   !> scale.
   subroutine read_ground_motion(file, form, quantity, unit, options, channel, n, samples, &
      time_step, motion, about, status, message)
      character(len=*), intent(in) :: file, form, quantity, unit
      real(c_double), intent(in) :: options(4)
      integer(c_int), intent(in) :: channel, n
      integer(c_int), intent(out) :: samples
      real(c_double), intent(out) :: time_step
      real(c_double), intent(out) :: motion(3, n)
      character(len=2048), intent(out) :: about
      integer(c_int), intent(out) :: status
      character(len=2048), intent(out) :: message
      type(error_type), allocatable :: error
      type(record_type) :: record
      type(motion_curve_type) :: curve
      type(baseline_type) :: baseline

      samples = 0
      time_step = 0.0_c_double
      motion = 0.0_c_double
      about = ''
      call read_record(record, file, form, quantity, unit, error, options(1), channel)
      if (.not. allocated(error)) then
         baseline%order = nint(options(2))
         if (baseline%order == -1) baseline%order = merge(2, 0, record%quantity == 'acceleration')
         baseline%taper = options(3)
         baseline%scale = options(4)
         call make_motion_curve(curve, record%quantity, record%values, record%time_step, error, &
            baseline)
      end if
      if (.not. allocated(error)) then
         samples = size(curve%displacement)
         time_step = curve%time_step
         about = record%station//new_line('a')//record%description//new_line('a')//record%format// &
            new_line('a')//record%unit//new_line('a')//curve%method
         if (n > 0) call check_size(n, samples, error)
         if (n == samples) then
            motion(1, :) = curve%acceleration
            motion(2, :) = curve%velocity
            motion(3, :) = curve%displacement
         end if
      end if
      call report(error, status, message)
   end subroutine read_ground_motion

   !> theta and chi of a time integration by name; theta counts for 'theta' only.
   subroutine scheme_numbers(name, theta, numbers, status, message)
      character(len=*), intent(in) :: name
      real(c_double), intent(in) :: theta
      real(c_double), intent(out) :: numbers(2)
      integer(c_int), intent(out) :: status
      character(len=2048), intent(out) :: message
      type(error_type), allocatable :: error
      type(scheme_type) :: scheme

      if (.not. any(integration_names == name)) call fail(error, error_input, "integration '"// &
         name//"' is not known; there are 'dda', 'midpoint', 'theta' and 'backward_euler'")
      scheme = scheme_named(name, theta)
      numbers = [scheme%theta, scheme%chi]
      call report(error, status, message)
   end subroutine scheme_numbers

   !> What the scheme (theta, chi) makes of oscillators with frequencies (Hz) at a time step (s):
   !> damping ratio and period elongation in free vibration, damping ratio in steady vibration,
   !> steps in which an alternating velocity falls to 1/e; both roots of the amplification matrix.
   subroutine scheme_vibration(theta, chi, time_step, n, frequency, values, roots)
      integer(c_int), intent(in) :: n
      real(c_double), intent(in) :: theta, chi, time_step, frequency(n)
      real(c_double), intent(out) :: values(4, n)
      complex(c_double_complex), intent(out) :: roots(2, n)
      type(scheme_type) :: scheme
      integer :: i

      scheme = scheme_type(theta, chi)
      associate (omega => 2.0_c_double*pi*frequency)
         values(1, :) = free_damping(scheme, omega, time_step)
         values(2, :) = period_elongation(scheme, omega, time_step)
         values(3, :) = forced_damping(scheme, omega, time_step)
         values(4, :) = steps_to_decay(scheme, omega, time_step)
         do i = 1, n
            roots(:, i) = amplification_roots(scheme, omega(i), time_step)
         end do
      end associate
   end subroutine scheme_vibration

   !> Factors of the equations in steady vibration at frequencies (Hz), elastic terms having 1: of M
   !> in place of -omega^2 (1/s^2), of stiffness at the end of the step, of dashpots on d/dt and on
   !> the end velocity (1/s), of loads.
   subroutine scheme_steady(theta, chi, time_step, dynamic_factor, n, frequency, factors)
      integer(c_int), intent(in) :: n
      real(c_double), intent(in) :: theta, chi, time_step, dynamic_factor, frequency(n)
      complex(c_double_complex), intent(out) :: factors(5, n)
      type(steady_type) :: steady
      integer :: i

      do i = 1, n
         steady = steady_weights(scheme_type(theta, chi), 2.0_c_double*pi*frequency(i), time_step, &
            dynamic_factor)
         factors(:, i) = [steady%inertia, steady%end_stiffness, steady%mean_dashpot, &
            steady%end_dashpot, steady%load]
      end do
   end subroutine scheme_steady

   !> The time step (s) of the scheme (theta, chi), and theta = chi at a time step, for damping
   !> ratios in steady vibration at frequencies (Hz).
   subroutine scheme_for_damping(theta, chi, time_step, n, damping, frequency, steps, thetas)
      integer(c_int), intent(in) :: n
      real(c_double), intent(in) :: theta, chi, time_step, damping(n), frequency(n)
      real(c_double), intent(out) :: steps(n), thetas(n)

      associate (omega => 2.0_c_double*pi*frequency)
         steps = step_for_damping(scheme_type(theta, chi), damping, omega)
         thetas = theta_for_damping(damping, omega, time_step)
      end associate
   end subroutine scheme_for_damping

   !> The generalised Maxwell body of a damping ratio over a band (Hz; 0: automatic) with a number
   !> of mechanisms (0: automatic) up to a frequency (rad/s): its mechanisms, and largest modulus,
   !> misfit and band.
   subroutine body_of(ratio, reference, band, mechanisms, limit, n, omega, weight, numbers, &
      status, message)
      real(c_double), intent(in) :: ratio, reference, band(2), limit
      integer(c_int), intent(in) :: mechanisms
      integer(c_int), intent(out) :: n
      real(c_double), intent(out) :: omega(16), weight(16), numbers(4)
      integer(c_int), intent(out) :: status
      character(len=2048), intent(out) :: message
      type(error_type), allocatable :: error
      type(damping_type) :: damping

      damping%ratio = ratio
      damping%reference = reference
      damping%band = band
      damping%n = mechanisms
      if (mechanisms /= 0 .and. (mechanisms < 2 .or. mechanisms > most_mechanisms)) then
         call fail(error, error_input, 'mechanisms must be in 2 ... 16')
      else
         call fit_body(damping, limit, error)
      end if
      n = damping%n
      omega = damping%omega
      weight = damping%weight
      numbers = [damping%unrelaxed, damping%misfit, damping%band]
      call report(error, status, message)
   end subroutine body_of

   !> Branches of a soil from its curves over the strain (m rows), by Masing's rules or with the
   !> damping given, and a damping ratio of small strains: strains, moduli over that of small
   !> strains and shares that slip; strain from which the body of small strains slips, its cap,
   !> largest relative error of the modulus, largest error of the damping ratio.
   subroutine soil_branches(m, strain, reduction, damping, masing, ratio, reference, n, branches, &
      numbers, status, message)
      integer(c_int), intent(in) :: m, n, masing
      real(c_double), intent(in) :: strain(m), reduction(m), damping(m), ratio, reference
      real(c_double), intent(out) :: branches(n, 3), numbers(4)
      integer(c_int), intent(out) :: status
      character(len=2048), intent(out) :: message
      type(error_type), allocatable :: error
      type(branches_type) :: fitted

      branches = 0.0_c_double
      numbers = 0.0_c_double
      call fit_branches(curve_type(strain, reduction, damping), n, masing /= 0, &
         damping_type(ratio=ratio, reference=reference), huge(1.0_c_double), fitted, error)
      if (.not. allocated(error)) then
         branches(:, 1) = fitted%strain
         branches(:, 2) = fitted%modulus
         branches(:, 3) = fitted%slipping
         numbers = [fitted%body_strain, fitted%body_cap, fitted%misfit]
      end if
      call report(error, status, message)
   end subroutine soil_branches

   !> A column of cells (thickness, density, modulus), of soils with branches and a damping ratio of
   !> small strains, whose body slips from a strain on.  Its base has an acceleration at each step,
   !> or an outcrop of the half-space has it (density times velocity above 0).  Each `every`th step:
   !> accelerations and displacements of the nodes, strains and stresses of the cells; the largest
   !> of both in all steps, the energies at the end, iterations of each step.
   subroutine shake_soil(cells, layers, soil, soils, n, branches, ratio, limit, reference, &
      dashpot, time_step, steps, base, every, kept, acceleration, displacement, strain, stress, &
      largest, energy, iterations, status, message)
      integer(c_int), intent(in) :: cells, soils, n, steps, every, kept
      real(c_double), intent(in) :: layers(3, cells), branches(n, 3, soils), ratio(soils), &
         limit(soils), reference, dashpot, time_step, base(steps + 1)
      integer(c_int), intent(in) :: soil(cells)
      real(c_double), intent(out) :: acceleration(cells + 1, kept), displacement(cells + 1, kept), &
         strain(cells, kept), stress(cells, kept), largest(2, cells), energy(5)
      integer(c_int), intent(out) :: iterations(steps)
      integer(c_int), intent(out) :: status
      character(len=2048), intent(out) :: message
      type(error_type), allocatable :: error
      type(shear_column_type) :: column
      type(shear_state_type) :: state
      real(c_double) :: velocity, change
      integer :: i

      call take_column(layers, soil, branches, ratio, limit, reference, dashpot, column, error)
      acceleration = 0.0_c_double
      displacement = 0.0_c_double
      strain = 0.0_c_double
      stress = 0.0_c_double
      iterations = 0
      velocity = 0.0_c_double
      if (.not. allocated(error)) then
         call begin_column(column, state)
         acceleration(:, 1) = end_accelerations(column, state, base(1), 0.0_c_double)
      end if
      do i = 1, steps
         if (mod(i, 256) == 0 .and. .not. allocated(error)) call fail_if_stopped(error)
         if (allocated(error)) exit
         change = 0.5_c_double*time_step*(base(i) + base(i + 1))
         call shake_column(column, time_step, velocity + 0.5_c_double*change, state, error)
         if (allocated(error)) error%message = 't = '//to_text(i*time_step)//' s: '//error%message
         velocity = velocity + change
         iterations(i) = state%iterations
         if (mod(i, every) /= 0) cycle
         associate (k => i/every + 1)
            acceleration(:, k) = end_accelerations(column, state, base(i + 1), velocity)
            displacement(:, k) = state%displacement
            strain(:, k) = state%strain
            stress(:, k) = state%stress
         end associate
      end do
      energy = 0.0_c_double
      largest = 0.0_c_double
      if (.not. allocated(error)) then
         energy = energy_balance(column, state)
         largest = state%largest
      end if
      call report(error, status, message)
   end subroutine shake_soil

   !> The column of `shake_soil`.
   subroutine take_column(layers, soil, branches, ratio, limit, reference, dashpot, column, error)
      real(c_double), intent(in) :: layers(:,:), branches(:,:,:), ratio(:), limit(:), &
         reference, dashpot
      integer(c_int), intent(in) :: soil(:)
      type(shear_column_type), intent(out) :: column
      type(error_type), allocatable, intent(inout) :: error
      integer :: s

      column%thickness = layers(1, :)
      column%density = layers(2, :)
      column%modulus = layers(3, :)
      column%soil = soil
      column%dashpot = dashpot
      allocate (column%branches(size(ratio)))
      do s = 1, size(ratio)
         associate (own => column%branches(s))
            own%n = size(branches, 1)
            own%strain = branches(:, 1, s)
            own%modulus = branches(:, 2, s)
            own%slipping = branches(:, 3, s)
            if (.not. allocated(error)) call set_body(own, &
               damping_type(ratio=ratio(s), reference=reference), huge(1.0_c_double), limit(s), &
               error)
         end associate
      end do
   end subroutine take_column

   subroutine engine_version(text)
      character(len=32), intent(out) :: text

      text = version
   end subroutine engine_version

   subroutine engine_commit(text)
      character(len=32), intent(out) :: text

      text = commit
   end subroutine engine_commit

   !> Names, with blanks between: 'energies', 'phases' and 'counts' in the order of their
   !> values, 'maxima' with their 'maxima units' and 'maxima numbers', 'boundary kinds' and more
   subroutine engine_names(what, names)
      character(len=*), intent(in) :: what       !< one of these; else the names are blank
      character(len=2048), intent(out) :: names

      names = ''
      select case (what)
      case ('energies')
         names = joined(energy_terms%name, ' ')
      case ('maxima')
         names = joined(maxima_table%name, ' ')
      case ('maxima units')
         names = joined(maxima_table%units, ' ')
      case ('maxima numbers')
         names = joined(maxima_table%number, ' ')
      case ('phases')
         names = joined(phase_names, ' ')
      case ('counts')
         names = 'steps iterations searches solves factors solver_iterations handed_over broken'
      case ('contacts')
         names = joined(contact_variables(1:)%name(9:), ' ')
      case ('whole contacts')
         names = joined(contact_variables(1:whole_columns)%name(9:), ' ')
      case ('boundary kinds')
         names = joined(boundary_kinds%name, ' ')
      case ('boundary kinds at rest')
         names = joined(boundary_kinds%at_rest, ' ')
      end select
   end subroutine engine_names

   !> Read a text as groups of values, which `parsed_input` then hands out.
   subroutine parse_input(file, text, skipped, sizes, status, message)
      character(len=*), intent(in) :: file, text   !< path, for messages; of the input
      character(len=*), intent(in) :: skipped      !< groups whose values are not read: 'one two'
      integer(c_int), intent(out) :: sizes(4)      !< groups, values, numbers, bytes of texts
      integer(c_int), intent(out) :: status
      character(len=2048), intent(out) :: message
      type(error_type), allocatable :: error
      integer :: i

      sizes = 0
      call split_groups(file, text, parsed, error)
      do i = 1, size(parsed)
         if (allocated(error)) exit
         if (index(' '//skipped//' ', ' '//parsed(i)%name//' ') == 0 .and. &
            find_group(parsed(i)%name) > 0) call parse_group(text, parsed(i), error)
         call count_values(parsed(i), sizes)
      end do
      call report(error, status, message)
   end subroutine parse_input

   !> Add the sizes of a group to those of the groups before it.
   pure subroutine count_values(group, sizes)
      type(group_type), intent(inout) :: group   !< gets no values where it was not read
      integer(c_int), intent(inout) :: sizes(4)  !< see `parse_input`
      integer :: i, k

      if (.not. allocated(group%values)) allocate (group%values(0))
      sizes(1:2) = sizes(1:2) + [1, size(group%values)]
      do i = 1, size(group%values)
         associate (value => group%values(i))
            sizes(3) = sizes(3) + value%n
            if (.not. allocated(value%words)) cycle
            do k = 1, value%n
               if (allocated(value%words(k)%text)) sizes(4) = sizes(4) + len(value%words(k)%text)
            end do
         end associate
      end do
   end subroutine count_values

   !> The groups of the text that was parsed last: line, first and last byte, number of values;
   !> of each value the position of its variable in the schema, and how many it has; numbers, or
   !> the lengths of texts, and the texts.  What is left out is -huge.
   subroutine parsed_input(n_groups, n_values, n_numbers, n_bytes, groups, values, numbers, bytes)
      integer(c_int), intent(in) :: n_groups, n_values, n_numbers, n_bytes  !< of `parse_input`
      integer(c_int), intent(out) :: groups(4, n_groups), values(2, n_values)
      real(c_double), intent(out) :: numbers(n_numbers)
      integer(c_int), intent(out) :: bytes(n_bytes)
      integer :: g, i, k, v, n, b, c

      v = 0
      n = 0
      b = 0
      do g = 1, size(parsed)
         groups(:, g) = [parsed(g)%line, parsed(g)%first, parsed(g)%last, size(parsed(g)%values)]
         do i = 1, size(parsed(g)%values)
            v = v + 1
            associate (value => parsed(g)%values(i))
               values(:, v) = [value%variable, value%n]
               do k = 1, value%n
                  n = n + 1
                  numbers(n) = unset
                  if (allocated(value%numbers)) numbers(n) = value%numbers(k)
                  if (.not. allocated(value%words)) cycle
                  if (.not. allocated(value%words(k)%text)) cycle
                  numbers(n) = len(value%words(k)%text)
                  do c = 1, len(value%words(k)%text)
                     b = b + 1
                     bytes(b) = iachar(value%words(k)%text(c:c))
                  end do
               end do
            end associate
         end do
      end do
      deallocate (parsed)
   end subroutine parsed_input

   !> Change variables of a text, which `changed_text` gives then.
   subroutine make_changes(file, text, words, n, lengths, variables, length, status, message)
      character(len=*), intent(in) :: file, text   !< path, for messages; of the input
      character(len=*), intent(in) :: words        !< path and value of each change, without gaps
      integer(c_int), intent(in) :: n              !< changes
      integer(c_int), intent(in) :: lengths(2, n)  !< bytes of path and value; -1: takes it out
      integer(c_int), intent(out) :: variables(n)  !< their positions in the schema
      integer(c_int), intent(out) :: length        !< bytes of the new text
      integer(c_int), intent(out) :: status
      character(len=2048), intent(out) :: message
      type(change_type) :: changes(n)
      type(error_type), allocatable :: error
      integer :: i, at

      at = 0
      do i = 1, n
         changes(i)%path = words(at + 1:at + lengths(1, i))
         at = at + lengths(1, i)
         if (lengths(2, i) >= 0) changes(i)%value = words(at + 1:at + lengths(2, i))
         at = at + max(0_c_int, lengths(2, i))
      end do
      slots(0)%text = text
      call change_text(file, slots(0)%text, changes, error)
      variables = changes%variable
      length = len(slots(0)%text)
      call report(error, status, message)
   end subroutine make_changes

   !> The variables of a group &joint with which all its strength is divided by a factor.
   subroutine reduced_joint(text, factor, names, values, status, message)
      character(len=*), intent(in) :: text
      real(c_double), intent(in) :: factor
      character(len=2048), intent(out) :: names  !< with blanks between
      real(c_double), intent(out) :: values(32)
      integer(c_int), intent(out) :: status
      character(len=2048), intent(out) :: message
      type(strength_type), allocatable :: strengths(:)
      type(error_type), allocatable :: error

      call reduced_strengths('model', text, factor, strengths, error)
      names = joined(strengths%name, ' ')
      values = 0
      values(:size(strengths)) = strengths%value
      call report(error, status, message)
   end subroutine reduced_joint

end module api
