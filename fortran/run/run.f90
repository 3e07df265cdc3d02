! SPDX-License-Identifier: GPL-3.0-or-later
!> Run from input to output, for both the native executable and Python.
!>
!> During the run each sample and frame is appended to the journal, and a partial output and
!> checkpoints are written at intervals.  These files remain if a run ends before its duration;
!> `resume_run` continues from them.
!>
!> A check of the model takes the time of about 100 steps and the memory of two models.  A check is
!> performed for small models, and for models of medium size if the run is long.
module dda_run
   use dda_kinds, only: wp, long
   use dda_added_stages, only: add_stages
   use dda_byte_file, only: cut_file
   use dda_changes, only: change_now
   use dda_checkpoint, only: checkpoints_type, begin_checkpoints, save_checkpoint, &
      load_checkpoint, has_checkpoint, remove_spare, remove_checkpoints
   use dda_doubts, only: add_doubt, add_doubts
   use dda_errors, only: error_type, error_interrupted
   use dda_input, only: read_model
   use dda_interrupts, only: stop_was_requested, stop_requested
   use dda_frame, only: append_frame
   use dda_free_memory, only: reserve_type, make_reserve
   use dda_journal, only: journal_type, open_journal, close_journal, keep_name, flush_journal, &
      begin_row, append_numbers, row_sample, journal_suffix
   use dda_model, only: model_type, run_steps, run_duration
   use dda_output_file, only: write_output, writing_memory, is_complete
   use dda_output_place, only: check_target, partial
   use dda_own_file, only: journal_file, netcdf_file, remove_own
   use dda_rate_limiter, only: rate_limiter_type, is_due, begin_task, end_task
   use dda_output_variables, only: size_of_sample
   use dda_sample, only: collect_sample
   use dda_running_maxima, only: count_step, count_stage, collect_residuals
   use dda_simulation, only: simulation_type, finished, stage_finished
   use dda_start, only: start
   use dda_output_times, only: aim_type, aim_at_output, reach_output, is_output_time
   use dda_stages, only: begin_first_stage, begin_next_stage
   use dda_stop_rule, only: apply_stop_rule
   use dda_team, only: begin_team
   use dda_time_step, only: advance
   use dda_text, only: to_text
   use dda_check_report, only: report_type, add_notes, verdict_ok
   use dda_check_simulation, only: check_model
   use dda_joint_ends, only: bending_topic
   use dda_model_notes, only: model_notes
   implicit none
   private
   public :: run_type, begin_run, prepare_run, resume_run, change_run, continue_run, flush_run, &
      save_run, end_run, is_done

   !> Simulation and the files that it writes.
   type :: run_type
      type(simulation_type) :: simulation
      type(journal_type) :: journal
      type(checkpoints_type) :: checkpoints
      type(rate_limiter_type) :: publishing                 !< rate limiter of partial outputs
      real(wp), allocatable :: sample(:)            !< [`size_of_sample`] work space
      type(reserve_type) :: reserve                 !< memory reserved for writing the output
      character(len=:), allocatable :: notice       !< position from which a resumed run continues
      integer(long) :: save_time = 0                    !< clock count at the last checkpoint
      integer(long) :: journal_time = 0                 !< clock count when the journal was written
      logical :: writes = .false.                   !< files are open
      logical :: waits = .false.                    !< the first stage has not yet begun
      logical :: has_output = .false.               !< the run will write an output
      logical :: sound = .true.                     !< no step has failed
      logical :: was_complete = .false.  !< the output was complete before the run was resumed
   end type run_type

   real(wp), parameter :: longest_wait = 1.0_wp  !< s after which the journal is written
   integer, parameter :: few_blocks = 200  !< largest model that is checked for every run
   integer, parameter :: many_blocks = 5000       !< largest model that is checked for long runs
   integer(long), parameter :: many_steps = 2500 !< steps of a long run: a check takes less than 5 %
   !> Limit of open–close iterations in the check's search for equilibrium; the limit is the number
   !> of steps of the run if this is larger.  Stable models need fewer iterations; in an unstable
   !> model the search costs at most as much as the run.
   integer(long), parameter :: min_budget = 200

contains

   !> Begin a run: set up the simulation of a model and, if requested, its output.
   subroutine begin_run(run, model, writes, error)
      type(run_type), intent(out) :: run  !< run and its files
      type(model_type), intent(in) :: model  !< model as read from the input
      logical, intent(in) :: writes  !< the run has an output
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure

      call prepare_run(run, model, writes, error)
      if (.not. allocated(error)) call begin_stages(run, error)
   end subroutine begin_run

   !> Create the simulation of a model in its initial geometry; `continue_run` begins the first
   !> stage.
   subroutine prepare_run(run, model, writes, error)
      type(run_type), intent(out) :: run  !< run and its files
      type(model_type), intent(in) :: model  !< model as read from the input
      logical, intent(in) :: writes  !< the run has an output
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure

      call begin_team
      run%waits = .true.
      run%has_output = writes
      call start(run%simulation, model, error)
      if (writes .and. .not. allocated(error)) call add_input_warnings(run%simulation, model)
   end subroutine prepare_run

   !> Begin the first stages, open the files, and record the first state.
   subroutine begin_stages(run, error)
      type(run_type), intent(inout) :: run  !< run as set up by `prepare_run`
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure

      run%waits = .false.
      call begin_first_stage(run%simulation, error)
      run%sound = .not. allocated(error)
      if (allocated(error) .or. .not. run%has_output) return
      call open_files(run, .false., error)
      if (.not. allocated(error)) call begin_files(run, error)
      if (allocated(error)) call close_files(run)
   end subroutine begin_stages

   !> Continue from the last checkpoint of the output, or from the start if there is none.
   !> If the output is complete, do nothing.
   subroutine resume_run(run, model, error)
      type(run_type), intent(out) :: run  !< run and its files
      type(model_type), intent(in) :: model  !< model as read from the input
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure

      call begin_team
      call start(run%simulation, model, error)
      if (allocated(error)) return
      call add_input_warnings(run%simulation, model)
      call open_files(run, .true., error)
      if (allocated(error)) return
      if (has_checkpoint(run%checkpoints)) then
         call load_checkpoint(run%checkpoints, run%simulation, run%journal, model, run%notice, &
            error)
         if (.not. allocated(error)) call write_partial_output(run, error)
         if (.not. allocated(error)) run%notice = 'resumed at step '// &
            to_text(run%simulation%step)//', t = '//to_text(run%simulation%time)//' s, '//run%notice
      else if (is_complete(model%output%file, model)) then
         call skip_to_end(run)
      else
         call begin_first_stage(run%simulation, error)
         if (.not. allocated(error)) call begin_files(run, error)
         run%notice = 'there is no checkpoint of '//model%output%file//': starting at time 0'
      end if
      if (allocated(error)) call close_files(run)
   end subroutine resume_run

   !> Mark a run as complete, because a complete output exists.
   subroutine skip_to_end(run)
      type(run_type), intent(inout) :: run  !< run and its files

      run%was_complete = .true.
      run%notice = run%simulation%model%output%file//' is complete'
      call remove_leftovers(run)
      call close_files(run)
      run%simulation%stage = size(run%simulation%model%stages)
      run%simulation%step = run_steps(run%simulation%model)
      run%simulation%first_step = run%simulation%step &
         - run%simulation%model%stages(run%simulation%stage)%steps
      run%simulation%time = run_duration(run%simulation%model)
      associate (last => run%simulation%model%stages(run%simulation%stage))
         run%simulation%first_time = run%simulation%time - last%steps*last%time_step
         run%simulation%model%control%step_count = last%steps
         run%simulation%model%control%time_step = last%time_step
      end associate
   end subroutine skip_to_end

   !> Open and lock the journal, so that other runs cannot write the same output.
   subroutine open_files(run, resumes, error)
      type(run_type), intent(inout) :: run  !< run and its files
      logical, intent(in) :: resumes  !< resume from a checkpoint, if there is one
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      associate (model => run%simulation%model)
         call check_target(model, resumes, error)
         if (.not. allocated(error)) call open_journal(run%journal, model%output%file, error)
         call begin_checkpoints(run%checkpoints, model)
      end associate
      call reserve_for_output(run, error)
      run%writes = .not. allocated(error)
      allocate (run%sample(size_of_sample(run%simulation)))
      call system_clock(run%save_time)
      run%journal_time = run%save_time
   end subroutine open_files

   !> Close the journal, so that other runs can write the output.
   subroutine close_files(run)
      type(run_type), intent(inout) :: run  !< run and its files
      type(error_type), allocatable :: unused

      call close_journal(run%journal, unused)
      if (allocated(run%reserve%bytes)) deallocate (run%reserve%bytes)
      run%writes = .false.
   end subroutine close_files

   !> Record the first state in new files.
   subroutine begin_files(run, error)
      type(run_type), intent(inout) :: run  !< run and its files
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      call add_check_warnings(run%simulation)
      call remove_checkpoints(run%checkpoints)
      call cut_file(run%journal%file, 0_long, error)
      call record_sample(run, error)
      call append_frame(run%journal, run%simulation, error)
      if (.not. allocated(error)) call write_partial_output(run, error)
   end subroutine begin_files

   !> Perform up to `steps` steps and record them.
   !> Stop earlier if the run is complete or a stop is requested.
   subroutine continue_run(run, steps, error)
      type(run_type), intent(inout) :: run  !< run and its files
      integer(long), intent(in) :: steps  !< number of steps
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      integer(long) :: last
      type(aim_type) :: aim
      logical :: checks_interrupts

      if (run%waits) call begin_stages(run, error)
      if (allocated(error)) return
      last = run%simulation%step + steps
      do while (run%simulation%step < last .and. .not. is_done(run))
         checks_interrupts = stage_finished(run%simulation)
         if (checks_interrupts) then
            call begin_next_stage(run%simulation, error)
            if (.not. allocated(error)) call count_stage(run%simulation)
         else
            call aim_at_output(run%simulation, aim)
            call advance(run%simulation, error)
            if (.not. allocated(error)) call reach_output(run%simulation, aim)
            if (.not. allocated(error)) call count_step(run%simulation)
         end if
         if (.not. allocated(error)) call apply_stop_rule(run%simulation)
         if (allocated(error)) then
            run%sound = .false.
            if (error%kind /= error_interrupted) call add_doubt(run%simulation%doubts, 'failed', &
               error%message)
            return
         end if
         if (.not. run%writes) then
            if (stop_was_requested()) return
            cycle
         else if (.not. checks_interrupts) then
            call record_step(run, error)
         else if (run%simulation%model%stages(run%simulation%stage)%static) then
            ! the state at the beginning of a dynamic stage is already recorded
            call record_sample(run, error)
            call append_frame(run%journal, run%simulation, error)
         end if
         if (allocated(error) .or. stop_was_requested()) return
      end do
   end subroutine continue_run

   !> Record samples and frames at multiples of their intervals, and at the end.
   subroutine record_step(run, error)
      type(run_type), intent(inout) :: run  !< run and its files
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer(long) :: time, rate
      logical :: last, save

      last = finished(run%simulation)
      run%journal%iterations = max(run%journal%iterations, run%simulation%iteration%iterations)
      associate (settings => run%simulation%model%output, step => run%simulation%step)
         if (last .or. ends_interval(step, settings%history_interval) .or. &
            is_output_time(run%simulation, settings%history_seconds)) call record_sample(run, error)
         if (last .or. ends_interval(step, settings%block_interval) .or. &
            is_output_time(run%simulation, settings%block_seconds)) call append_frame( &
            run%journal, run%simulation, error)
         if (allocated(error) .or. last) return
         call system_clock(time, rate)
         save = is_past(run%save_time, 60.0_wp*settings%checkpoint_minutes, time, rate)
         if (save .or. ends_interval(step, settings%checkpoint_interval)) call save_run(run, error)
      end associate
      if (is_past(run%journal_time, longest_wait, time, rate)) then
         call flush_journal(run%journal, .false., error)
         run%journal_time = time
      end if
      if (is_due(run%publishing, time) .and. .not. allocated(error)) &
         call write_partial_output(run, error)
   end subroutine record_step

   !> .true. if the number of a step is a multiple of an interval.
   pure logical function ends_interval(step, interval)  ! total
      integer(long), intent(in) :: step  !< number of the step
      integer, intent(in) :: interval  !< steps; 0: never

      ends_interval = .false.
      if (interval > 0) ends_interval = modulo(step, int(interval, long)) == 0
   end function ends_interval

   !> .true. if a number of seconds have passed since a clock count; 0: never.
   pure logical function is_past(start, seconds, time, rate)
      integer(long), intent(in) :: start       !< clock count
      real(wp), intent(in) :: seconds          !< s; 0: never
      integer(long), intent(in) :: time, rate  !< present clock count, counts per second

      is_past = seconds > 0.0_wp .and. real(time - start, wp) >= seconds*real(rate, wp)
   end function is_past

   !> Append a sample to the journal.
   subroutine record_sample(run, error)
      type(run_type), intent(inout) :: run  !< run and its files
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      call collect_sample(run%simulation, run%journal%iterations, run%sample)
      call begin_row(run%journal, row_sample, 0, error)
      call append_numbers(run%journal, run%sample, size(run%sample), error)
   end subroutine record_sample

   !> Write the partial output, which can be read during the run.
   subroutine write_partial_output(run, error)
      type(run_type), intent(inout) :: run  !< run and its files
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      call keep_name(run%journal, error)
      if (allocated(error)) return
      call begin_task(run%publishing)
      call collect_residuals(run%simulation)
      call write_in_reserve(run, .false., error)
      call end_task(run%publishing)
   end subroutine write_partial_output

   !> Release the reserved memory, write the output, and reserve the memory again.
   subroutine write_in_reserve(run, complete, error)
      type(run_type), intent(inout) :: run  !< run and its files
      logical, intent(in) :: complete  !< the run has reached its duration
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      call reserve_for_output(run, error)
      if (allocated(error)) return
      deallocate (run%reserve%bytes)
      call write_output(run%simulation%model%output%file, run%journal, run%simulation, complete, &
         error)
      if (.not. complete) call reserve_for_output(run, error)
   end subroutine write_in_reserve

   !> Reserve the memory for writing the output.
   subroutine reserve_for_output(run, error)
      type(run_type), intent(inout) :: run  !< run and its files
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      call make_reserve(run%reserve, writing_memory(run%simulation), 'writing '// &
         run%simulation%model%output%file, 'use fewer blocks, or a machine with more', error)
   end subroutine reserve_for_output

   !> Flush the buffer of the journal before a fork, because the new process would copy the buffer.
   subroutine flush_run(run, error)
      type(run_type), intent(inout) :: run  !< run and its files
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      if (run%writes) call flush_journal(run%journal, .false., error)
   end subroutine flush_run

   !> Write a checkpoint now.
   subroutine save_run(run, error)
      type(run_type), intent(inout) :: run  !< run and its files
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      if (.not. (run%writes .and. run%sound)) return
      call save_checkpoint(run%checkpoints, run%simulation, run%journal, error)
      call system_clock(run%save_time)
   end subroutine save_run

   !> Apply a changed input to the variables that may change between two steps.
   subroutine change_run(run, text, description, error)
      type(run_type), intent(inout) :: run  !< run and its files
      character(len=*), intent(in) :: text  !< text of the changed input
      character(len=*), intent(in) :: description !< description of the changes
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      type(model_type) :: model

      call read_model(model, run%simulation%model%file, text, error)
      if (allocated(error)) return
      if (size(model%stages) > size(run%simulation%model%stages)) then
         call add_stages(run%simulation, model, error)
      else
         call change_now(run%simulation, model, error)
      end if
      if (allocated(error)) return
      associate (simulation => run%simulation)
         simulation%changed_text = text
         if (simulation%changes /= '') simulation%changes = simulation%changes//'; '
         simulation%changes = simulation%changes//'t = '//to_text(simulation%time)//' s: '// &
            description
      end associate
   end subroutine change_run

   !> .true. if the run has reached its duration.
   pure logical function is_done(run)  ! total
      type(run_type), intent(in) :: run  !< run and its files

      is_done = finished(run%simulation)
   end function is_done

   !> Write the output and close the files.
   !> The output of an incomplete run is partial, with a checkpoint.
   subroutine end_run(run, error)
      type(run_type), intent(inout) :: run  !< run and its files
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      type(error_type), allocatable :: failure

      if (.not. run%writes) return
      call keep_name(run%journal, error)
      call collect_residuals(run%simulation)
      if (is_done(run) .and. run%sound .and. .not. allocated(error)) &
         call write_in_reserve(run, .true., error)
      if (is_done(run) .and. run%sound .and. .not. allocated(error)) then
         call remove_leftovers(run)
      else
         call save_run(run, failure)
         call remove_spare(run%checkpoints)
         if (.not. allocated(error)) call write_partial_output(run, error)
         if (allocated(failure)) error = failure
      end if
      call close_files(run)
   end subroutine end_run

   !> Remove files that only an unfinished run needs.
   !> Checkpoints are removed first, because they need the journal.
   subroutine remove_leftovers(run)
      type(run_type), intent(in) :: run  !< run and its files

      associate (file => run%simulation%model%output%file)
         call remove_checkpoints(run%checkpoints)
         call remove_own(file//journal_suffix, journal_file)
         call remove_own(file//partial, netcdf_file)
      end associate
   end subroutine remove_leftovers

   !> Add notes on probable mistakes in a model to the warnings of its run.
   subroutine add_input_warnings(simulation, model)
      type(simulation_type), intent(inout) :: simulation  !< run of the model
      type(model_type), intent(in) :: model               !< model as read from the input
      type(report_type), allocatable :: report

      allocate (report)
      call add_notes(report, model_notes(model))
      call add_lines(simulation, report)
   end subroutine add_input_warnings

   !> Add lines of the check that are not ok to the warnings of a run that begins.
   subroutine add_check_warnings(simulation)
      type(simulation_type), intent(inout) :: simulation  !< simulation whose first stage has begun
      type(report_type), allocatable :: report
      type(error_type), allocatable :: error
      logical :: is_long

      is_long = run_steps(simulation%model) >= many_steps
      associate (n => simulation%blocks%n)
         if (n > many_blocks .or. (n > few_blocks .and. .not. is_long)) return
      end associate
      allocate (report)
      call check_model(simulation, report, error, &
         budget=max(min_budget, run_steps(simulation%model)))
      if (stop_requested()) return  ! the run reports the stop
      call add_lines(simulation, report)
      if (allocated(error)) call add_doubt(simulation%doubts, '', error%message, .true.)
   end subroutine add_check_warnings

   !> Add the short text of each line of the check that is not ok.
   !> Lines on bending are omitted, because the end of the run reports bending.
   pure subroutine add_lines(simulation, report)
      type(simulation_type), intent(inout) :: simulation  !< warnings are added
      type(report_type), intent(in) :: report             !< report of the check
      integer :: i

      do i = 1, report%n
         associate (line => report%line(i))
            if (line%verdict == verdict_ok .or. line%brief%topic == bending_topic) cycle
            call add_doubts(simulation%doubts, [line%brief])
         end associate
      end do
   end subroutine add_lines

end module dda_run
