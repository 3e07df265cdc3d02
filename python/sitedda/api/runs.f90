! SPDX-License-Identifier: GPL-3.0-or-later
!> Runs behind integer handles.
!>
!> Python owns the handle and frees it; a handle that is not open is an error, never a crash.
module api_runs
   use, intrinsic :: iso_c_binding, only: c_double, c_int
   use api_failure, only: check_size, error
   use api_handles, only: find_run, max_runs, slots
   use api_tables, only: take_table, take_text
   use dda_check_report, only: report_type, report_text, add_notes
   use dda_check_simulation, only: check_simulation
   use dda_errors, only: error_type, error_input, fail
   use dda_input, only: read_model
   use dda_interrupts, only: fail_if_stopped
   use dda_kinds, only: long
   use dda_model, only: model_type
   use dda_model_notes, only: add_notes_to_error, model_notes
   use dda_process, only: process_id
   use dda_run, only: run_type, begin_run, prepare_run, resume_run, change_run, continue_run, &
      flush_run, save_run, end_run, is_done
   use dda_settings, only: name_output
   use dda_start, only: set_rates
   implicit none
   private
   public :: open_run, advance_run, change_input, save_state, finish_run, close_run, &
      set_block_states, make_table, read_table, make_text, read_text, check_run

contains

   !> Read an input text and begin a run of it.
   subroutine open_run(file, text, output, writes, drawn, handle)
      !> file of the text; its folder contains the records
      character(len=*), intent(in) :: file
      character(len=*), intent(in) :: text
      character(len=*), intent(in) :: output    !< output file instead of the input's, or blank
      integer(c_int), intent(in) :: writes      !< 1: write the output file; 2: continue with one
      integer(c_int), intent(in) :: drawn       !< 1: the first stage begins with the first advance
      integer(c_int), intent(out) :: handle
      type(model_type) :: model

      call read_model(model, file, text, error)
      if (.not. allocated(error)) call fail_if_stopped(error)
      if (.not. allocated(error)) then
         if (output /= '') call name_output(model%output, output)
         handle = findloc([(associated(slots(handle)%run), handle=1, max_runs)], .false., 1)
         if (handle == 0) call fail(error, error_input, 'too many simulations are open')
      end if
      if (.not. allocated(error)) then
         allocate (slots(handle)%run)
         slots(handle)%process = process_id()
         slots(handle)%notes = model_notes(model)
         if (writes == 2) then
            call resume_run(slots(handle)%run, model, error)
         else if (drawn == 1) then
            call prepare_run(slots(handle)%run, model, writes == 1, error)
         else
            call begin_run(slots(handle)%run, model, writes == 1, error)
         end if
         if (writes /= 2) call add_notes_to_error(error, slots(handle)%notes)
         if (allocated(error)) deallocate (slots(handle)%run)
      end if
   end subroutine open_run

   !> Take up to `steps` steps.
   subroutine advance_run(handle, steps, done)
      integer(c_int), intent(in) :: handle, steps
      integer(c_int), intent(out) :: done  !< 1: the duration is reached
      !f2py threadsafe
      type(run_type), pointer :: run

      done = 0
      call find_run(handle, run, error)
      if (allocated(error)) return
      call continue_run(run, int(steps, long), error)
      call flush_run(run, error)
      done = merge(1, 0, is_done(run))
   end subroutine advance_run

   !> Change the input of a run between two steps; the words list the changes.
   subroutine change_input(handle, text, words)
      integer(c_int), intent(in) :: handle
      character(len=*), intent(in) :: text, words
      type(run_type), pointer :: run

      call find_run(handle, run, error)
      if (.not. allocated(error)) call change_run(run, text, words, error)
   end subroutine change_input

   !> Write a checkpoint now, if the run writes an output.
   subroutine save_state(handle)
      integer(c_int), intent(in) :: handle
      type(run_type), pointer :: run

      call find_run(handle, run, error)
      if (.not. allocated(error)) call save_run(run, error)
   end subroutine save_state

   !> Close the output file: named if the run is done, else left as FILE.partial with a checkpoint.
   subroutine finish_run(handle)
      integer(c_int), intent(in) :: handle
      type(run_type), pointer :: run

      call find_run(handle, run, error)
      if (.not. allocated(error)) call end_run(run, error)
   end subroutine finish_run

   !> Free a run; an output that is still open is closed as it is.
   subroutine close_run(handle)
      integer(c_int), intent(in) :: handle
      type(error_type), allocatable :: unused  ! Python frees a run between two other calls
      type(run_type), pointer :: run

      call find_run(handle, run, unused)
      if (allocated(unused)) return
      call end_run(run, unused)
      deallocate (slots(handle)%run)
   end subroutine close_run

   !> Make a table of a run, which `read_table` hands over; its shape.
   subroutine make_table(handle, what, sizes)
      integer(c_int), intent(in) :: handle
      character(len=*), intent(in) :: what      !< see `take_table`
      integer(c_int), intent(out) :: sizes(2)
      type(run_type), pointer :: run

      sizes = 0
      call find_run(handle, run, error)
      if (.not. allocated(error)) call take_table(run, what, slots(handle)%table)
      if (.not. allocated(error)) sizes = shape(slots(handle)%table)
   end subroutine make_table

   !> The table that was made last.
   subroutine read_table(handle, rows, columns, values)
      integer(c_int), intent(in) :: handle, rows, columns
      real(c_double), intent(out) :: values(rows, columns)

      values = slots(handle)%table
   end subroutine read_table

   !> Make a text of a run, which `read_text` hands over; its length in bytes.
   subroutine make_text(handle, what, length)
      integer(c_int), intent(in) :: handle
      character(len=*), intent(in) :: what     !< see `take_text`
      integer(c_int), intent(out) :: length
      type(run_type), pointer :: run

      length = 0
      call find_run(handle, run, error)
      if (allocated(error)) return
      call take_text(run, slots(handle)%notes, what, slots(handle)%text)
      length = len(slots(handle)%text)
   end subroutine make_text

   !> The text that was made last of a run.
   subroutine read_text(handle, n, bytes)
      integer(c_int), intent(in) :: handle, n
      integer(c_int), intent(out) :: bytes(n)
      integer :: i

      bytes = [(iachar(slots(handle)%text(i:i)), i=1, n)]
   end subroutine read_text

   !> Set the rates of all blocks, such as a mode's shape for a free vibration.
   subroutine set_block_states(handle, n, rates)
      integer(c_int), intent(in) :: handle, n
      real(c_double), intent(in) :: rates(6, n)
      type(run_type), pointer :: run

      call find_run(handle, run, error)
      if (.not. allocated(error)) call check_size(n, run%simulation%blocks%n)
      if (.not. allocated(error)) call set_rates(run%simulation, rates, error)
   end subroutine set_block_states

   !> The check report as text, its worst verdict (1 ok, 2 warn, 3 fail), and its numbers:
   !> omega_max, its bracket (rad/s), its residual, shift of the first frequency, band (Hz), steps
   !> in which the slowest alternating mode falls to 1/e (0: no mode alternates; huge: it does
   !> not decay), memory (bytes) and duration (s) of the run, about.
   subroutine check_run(handle, text, worst, numbers)
      integer(c_int), intent(in) :: handle
      character(len=16384), intent(out) :: text
      integer(c_int), intent(out) :: worst
      real(c_double), intent(out) :: numbers(10)
      type(run_type), pointer :: run
      type(report_type), allocatable :: report

      call find_run(handle, run, error)
      if (allocated(error)) return
      allocate (report)
      call add_notes(report, slots(handle)%notes)
      call check_simulation(run%simulation, report, error)
      if (allocated(error)) return
      text = report_text(report)
      worst = report%worst_verdict
      numbers = [report%omega_max%omega, report%omega_max%bracket%lower, &
         report%omega_max%bracket%upper, report%omega_max%residual, report%frequency_shift, &
         report%band%lowest, report%band%highest, report%ringing_steps, report%memory_bytes, &
         report%run_seconds]
   end subroutine check_run

end module api_runs
