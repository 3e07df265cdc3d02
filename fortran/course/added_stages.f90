! SPDX-License-Identifier: GPL-3.0-or-later
!> Stages that are added to a run which has begun: excavation, supports that let go, other joints.
!>
!> The last stage of the run ends now; with adaptive steps at the next but one multiple of its Δt,
!> so that no step before would have been another.  An input with these stages then gives the same
!> bits from its start on.  What a stage brings, points that it holds, loads, motions, bolts, is not
!> there before it, so such a stage cannot be added.
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
   public :: has_more_stages, add_stages, adopt_stages

contains

   !> A changed input goes on where the run would end.
   pure logical function has_more_stages(simulation, model) result(more)
      type(simulation_type), intent(in) :: simulation  !< a run and its state
      type(model_type), intent(in) :: model  !< of the changed input

      more = size(model%stages) > size(simulation%model%stages)
   end function has_more_stages

   !> Let the stages that a changed input has at its end follow.
   recursive subroutine add_stages(simulation, model, error)
      type(simulation_type), intent(inout) :: simulation  !< between two steps
      type(model_type), intent(in) :: model  !< of the changed input
      type(error_type), allocatable, intent(out) :: error  !< they cannot follow
      integer :: i

      call check_added(simulation, model, error)
      if (allocated(error)) return
      do i = 1, column_count(simulation)
         call add_stages(column_of(simulation, i), column_model(model, model%free_fields(i)), error)
         if (allocated(error)) return
      end do
      call end_stage(simulation)
      call adopt_stages(simulation%model, model)
   end subroutine add_stages

   !> They follow a dynamic stage, the last one, and bring nothing that was there from the start.
   subroutine check_added(simulation, model, error)
      type(simulation_type), intent(in) :: simulation  !< between two steps
      type(model_type), intent(in) :: model  !< of the changed input
      type(error_type), allocatable, intent(out) :: error  !< names the stage
      integer :: i

      associate (stages => simulation%model%stages)
         if (simulation%stage < size(stages) .or. stages(size(stages))%static .or. &
            simulation%step == simulation%first_step) then
            call fail(error, error_input, model%file//': stages can be added to a run that has '// &
               'taken steps in its last stage, a dynamic one')
            return
         end if
         do i = size(stages) + 1, size(model%stages)
            associate (stage => model%stages(i))
               if (.not. (any(stage%holds) .or. any(stage%loads) .or. any(stage%begins) .or. &
                  any(stage%added))) cycle
               call fail(error, error_input, model%file//': stage '//quoted(trim(stage%name))// &
                  ' is added during the run and cannot hold, add, or begin loads and motions: '// &
                  'these wait from the start of a run')
               return
            end associate
         end do
      end associate
   end subroutine check_added

   !> The present stage ends after as many steps of its Δt as an input can say.
   pure subroutine end_stage(simulation)
      type(simulation_type), intent(inout) :: simulation  !< between two steps
      real(wp), parameter :: rounding = 1.0e-9_wp  !< of Δt, as where a stage ends
      integer(long) :: steps

      associate (control => simulation%model%control)
         steps = simulation%step - simulation%first_step
         if (control%adaptive) steps = floor((simulation%time - simulation%first_time) &
            /control%time_step + rounding, long) + 2
         control%step_count = min(control%step_count, steps)
      end associate
   end subroutine end_stage

   !> Stages that a changed input has more.
   pure subroutine adopt_stages(own, model)
      type(model_type), intent(inout) :: own  !< of the run
      type(model_type), intent(in) :: model   !< of the changed input
      type(stage_type), allocatable :: stages(:)
      integer :: old

      old = size(own%stages)
      if (size(model%stages) <= old) return
      allocate (stages(size(model%stages)))
      stages(:old) = own%stages
      stages(old + 1:) = model%stages(old + 1:)
      stages(old)%steps = model%stages(old)%steps
      stages(old)%duration = model%stages(old)%duration
      call move_alloc(stages, own%stages)
   end subroutine adopt_stages

end module dda_added_stages
