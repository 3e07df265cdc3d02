! SPDX-License-Identifier: GPL-3.0-or-later
!> The table of open runs.
module api_handles
   use, intrinsic :: iso_c_binding, only: c_double, c_int
   use dda_errors, only: error_type, error_input, fail
   use dda_model_notes, only: note_length
   use dda_process, only: process_id
   use dda_run, only: run_type
   implicit none
   private
   public :: find_run, max_runs, slots

   integer, parameter :: max_runs = 65536

   !> One slot of the table of open runs.
   type :: slot_type
      type(run_type), pointer :: run => null()
      integer(c_int) :: process = 0   !< that opened it
      !> on the model as it was read, a line each
      character(len=note_length), allocatable :: notes(:)
      real(c_double), allocatable :: table(:,:)  !< that was made last
      character(len=:), allocatable :: text      !< that was made last
   end type slot_type

   type(slot_type) :: slots(max_runs)

contains

   !> The open run of a handle; an error otherwise.
   subroutine find_run(handle, run, error)
      integer(c_int), intent(in) :: handle
      type(run_type), pointer, intent(out) :: run
      type(error_type), allocatable, intent(out) :: error

      run => null()
      if (handle >= 1 .and. handle <= max_runs) run => slots(handle)%run
      if (.not. associated(run)) then
         call fail(error, error_input, 'the simulation is closed')
      else if (run%writes .and. slots(handle)%process /= process_id()) then
         ! The files are those of the process that this one was forked from.
         call fail(error, error_input, 'the simulation writes an output for another process')
      end if
   end subroutine find_run

end module api_handles
