!> A run from input to output: the same for the native executable and for Python.
module dda_run
   use dda_kinds, only: wp, long
   use dda_errors, only: error_type
   use dda_model, only: model_type
   use dda_output_file, only: output_type, open_output, note_step, record_sample, record_frame, finish_output, abandon_output
   use dda_simulation, only: simulation_type, start, advance, finished
   implicit none
   private
   public :: run_type, begin_run, continue_run, end_run, is_done

   !> A simulation and the file it writes.
   type :: run_type
      type(simulation_type) :: simulation
      type(output_type) :: output
      logical :: writes = .false.
   end type run_type

contains

   !> Set up the simulation of a model and, if it is to write, its output with the first state.
   subroutine begin_run(run, model, writes, error)
      type(run_type), intent(out) :: run
      type(model_type), intent(in) :: model
      logical, intent(in) :: writes
      type(error_type), allocatable, intent(out) :: error

      call start(run%simulation, model, error)
      if (allocated(error) .or. .not. writes) return
      call open_output(run%output, run%simulation, model%output%file, error)
      run%writes = .not. allocated(error)
      if (run%writes) call record_sample(run%output, run%simulation, error)
      if (run%writes .and. .not. allocated(error)) call record_frame(run%output, run%simulation, error)
   end subroutine begin_run

   !> Take up to `steps` steps, recording on the way; stops early when the run is done.
   subroutine continue_run(run, steps, error)
      type(run_type), intent(inout) :: run
      integer(long), intent(in) :: steps
      type(error_type), allocatable, intent(out) :: error
      integer(long) :: i

      do i = 1, steps
         if (is_done(run)) return
         call advance(run%simulation, error)
         if (allocated(error)) return
         if (run%writes) call record_step(run, error)
         if (allocated(error)) return
      end do
   end subroutine continue_run

   !> Samples and frames are due at multiples of their intervals, and at the end.
   subroutine record_step(run, error)
      type(run_type), intent(inout) :: run
      type(error_type), allocatable, intent(out) :: error
      logical :: last

      last = finished(run%simulation)
      call note_step(run%output, run%simulation)
      associate (settings => run%simulation%model%output, step => run%simulation%step)
         if (last .or. modulo(step, int(settings%history_interval, long)) == 0) &
            call record_sample(run%output, run%simulation, error)
         if (allocated(error)) return
         if (due(step, settings%block_interval) .or. last) call record_frame(run%output, run%simulation, error)
      end associate
   end subroutine record_step

   pure logical function due(step, interval)
      integer(long), intent(in) :: step
      integer, intent(in) :: interval

      due = .false.
      if (interval > 0) due = modulo(step, int(interval, long)) == 0
   end function due

   !> The duration asked for has been reached.
   pure logical function is_done(run)
      type(run_type), intent(in) :: run

      is_done = finished(run%simulation)
   end function is_done

   !> Close the output: under its own name if the run is done, else under its partial name.
   subroutine end_run(run, error)
      type(run_type), intent(inout) :: run
      type(error_type), allocatable, intent(out) :: error

      if (.not. run%writes) return
      run%writes = .false.
      if (is_done(run)) then
         call finish_output(run%output, run%simulation, error)
      else
         call abandon_output(run%output, run%simulation, error)
      end if
   end subroutine end_run

end module dda_run
