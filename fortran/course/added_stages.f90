! SPDX-License-Identifier: GPL-3.0-or-later
!> Stages that are added to a running simulation: excavation, release of supports, other joints.
!>
!> The last stage of the run ends at the present time or, with adaptive steps, at the second next
!> multiple of its Δt.  Its steps are then bit-identical to a run with these stages in its input.
!> Added stages cannot add supported points, loads, motions or bolts, because these are part of the
!> model from the start.
module dda_added_stages
   use dda_kinds, only: wp, long
   use dda_column_model, only: column_model
   use dda_columns, only: column_count, column_of
   use dda_errors, only: error_type, error_input, fail
   use dda_model, only: model_type
   use dda_simulation, only: simulation_type
   use dda_stage, only: stage_type
   use dda_text, only: quoted
   implicit none
   private
   public :: add_stages, adopt_stages

contains

   !> Append the additional stages of a changed input to a run.
   recursive subroutine add_stages(simulation, model, error)
      type(simulation_type), intent(inout) :: simulation  !< between two steps
      type(model_type), intent(in) :: model  !< model of the changed input
      type(error_type), allocatable, intent(out) :: error  !< the stages cannot be appended
      integer :: i

      call check_added_stages(simulation, model, error)
      if (allocated(error)) return
      do i = 1, column_count(simulation)
         call add_stages(column_of(simulation, i), column_model(model, model%free_fields(i)), error)
         if (allocated(error)) return
      end do
      call end_present_stage(simulation)
      call adopt_stages(simulation%model, model)
   end subroutine add_stages

   !> Check that added stages follow a dynamic stage and only change the model.
   subroutine check_added_stages(simulation, model, error)
      type(simulation_type), intent(in) :: simulation  !< between two steps
      type(model_type), intent(in) :: model  !< model of the changed input
      type(error_type), allocatable, intent(out) :: error  !< error with the name of the stage
      integer :: i

      associate (stages => simulation%model%stages)
         if (simulation%stage < size(stages) .or. stages(size(stages))%static .or. &
            simulation%step == simulation%first_step) then
            call fail(error, error_input, model%file//': stages can be added only after the '// &
               'first step of the last stage, which must be dynamic')
            return
         end if
         do i = size(stages) + 1, size(model%stages)
            associate (stage => model%stages(i))
               if (.not. (any(stage%holds) .or. any(stage%loads) .or. any(stage%begins) .or. &
                  any(stage%added))) cycle
               call fail(error, error_input, model%file//': stage '//quoted(trim(stage%name))// &
                  ' is added during the run, so it cannot use `hold`, `loads`, `motions` or '// &
                  '`add`, which only stages of the original input may use')
               return
            end associate
         end do
      end associate
   end subroutine check_added_stages

   !> End the present stage at the present time, or at the second next multiple of an adaptive Δt.
   pure subroutine end_present_stage(simulation)
      type(simulation_type), intent(inout) :: simulation  !< between two steps
      real(wp), parameter :: rounding = 1.0e-9_wp  !< rounding error of times/Δt
      integer(long) :: steps

      associate (control => simulation%model%control)
         steps = simulation%step - simulation%first_step
         if (control%adaptive) steps = floor((simulation%time - simulation%first_time) &
            /control%time_step + rounding, long) + 2
         control%step_count = min(control%step_count, steps)
      end associate
   end subroutine end_present_stage

   !> Copy the additional stages of a changed input to the model of the run.
   pure subroutine adopt_stages(run_model, model)
      type(model_type), intent(inout) :: run_model  !< model of the run
      type(model_type), intent(in) :: model   !< model of the changed input
      type(stage_type), allocatable :: stages(:)
      integer :: n_stages

      n_stages = size(run_model%stages)
      if (size(model%stages) <= n_stages) return
      allocate (stages(size(model%stages)))
      stages(:n_stages) = run_model%stages
      stages(n_stages + 1:) = model%stages(n_stages + 1:)
      stages(n_stages)%steps = model%stages(n_stages)%steps
      stages(n_stages)%duration = model%stages(n_stages)%duration
      call move_alloc(stages, run_model%stages)
   end subroutine adopt_stages

end module dda_added_stages
