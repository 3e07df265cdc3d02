!> One time step: search, assemble, solve, open–close, integrate; with a smaller Δt if it must be
!> and may.
module dda_time_step
   use dda_kinds, only: wp
   use dda_errors, only: error_type
   use dda_system, only: assemble_base
   use dda_energy_budget, only: update_step, update_state
   use dda_contact_search, only: find_contacts
   use dda_model, only: half_size
   use dda_kinematics, only: damp_velocity, predict, integrate, farthest_move
   use dda_open_close, only: close_contacts
   use dda_original_rules, only: close_by_original_rules
   use dda_simulation, only: simulation_type
   use dda_linear_solver, only: weigh_loads
   use dda_stopwatch, only: begin_laps, lap, phase_assemble, phase_iterate, phase_update
   use dda_diagnostics, only: explain, check_state
   implicit none
   private
   public :: advance

   real(wp), parameter :: shrink = 0.3_wp, recover = 1.3_wp  !< of Δt when adaptive
   integer, parameter :: most_attempts = 40        !< at one step

contains

   !> Take one step.
   subroutine advance(simulation, error)
      type(simulation_type), intent(inout) :: simulation
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: loss
      integer :: attempt

      call begin_laps(simulation%system%watch)
      call damp_velocity(simulation%blocks, simulation%model%control%dynamic_factor, loss)
      simulation%energy%kinetic_damping = simulation%energy%kinetic_damping + loss
      do attempt = 1, most_attempts
         call find_contacts(simulation, error)
         if (allocated(error)) return
         call solve_step(simulation, error)
         if (.not. allocated(error)) then
            if (.not. too_far(simulation)) exit
         end if
         call retry(simulation, attempt, error)
         if (allocated(error)) return
      end do
      call lap(simulation%system%watch, phase_iterate)
      call accept(simulation)
      call check_state(simulation, error)
      call lap(simulation%system%watch, phase_update)
   end subroutine advance

   !> Assemble and iterate for the increment d of this step.
   subroutine solve_step(simulation, error)
      type(simulation_type), intent(inout) :: simulation
      type(error_type), allocatable, intent(out) :: error

      associate (contacts => simulation%contacts(simulation%now))
         contacts%was_bonded(:contacts%n) = contacts%bonded(:contacts%n)
         call assemble_base(simulation%system, simulation%model, simulation%blocks, &
            simulation%time + simulation%time_step, simulation%time_step)
         call weigh_loads(simulation%solver, simulation%system%load)
         call predict(simulation%blocks, simulation%system%d, simulation%time_step)
         call lap(simulation%system%watch, phase_assemble)
         if (simulation%model%contact%original_rules) then
            call close_by_original_rules(simulation%iteration, simulation%system, &
               simulation%solver, contacts, simulation%laws, half_size(simulation%model%blocks), &
               simulation%step == 0, error)
         else
            call close_contacts(simulation%iteration, simulation%system, simulation%solver, &
               contacts, simulation%laws, error)
         end if
      end associate
      simulation%counters%iterations = simulation%counters%iterations &
         + simulation%iteration%iterations
      simulation%counters%most_iterations = max(simulation%counters%most_iterations, &
         simulation%iteration%iterations)
   end subroutine solve_step

   !> The step moves a vertex beyond the maximum displacement, or beyond what contacts were listed
   !> for.
   logical function too_far(simulation)
      type(simulation_type), intent(inout) :: simulation
      real(wp) :: move, allowed

      move = farthest_move(simulation%blocks, simulation%system%d)
      allowed = simulation%model%control%max_displacement_ratio*half_size(simulation%model%blocks)
      simulation%speed = min(move, half_size(simulation%model%blocks))/simulation%time_step
      too_far = simulation%model%control%adaptive .and. move > allowed
      if (move > allowed) simulation%counters%too_far = simulation%counters%too_far + 1
      if (2*move > simulation%detection%distance) too_far = .true.
   end function too_far

   !> Prepare another attempt at the step: a smaller Δt if it is allowed to shrink, else a wider
   !> search.
   subroutine retry(simulation, attempt, error)
      type(simulation_type), intent(inout) :: simulation
      integer, intent(in) :: attempt
      type(error_type), allocatable, intent(inout) :: error
      character(len=:), allocatable :: reason

      reason = 'a vertex moves too far in one step'
      if (allocated(error)) reason = error%message
      if (simulation%model%control%adaptive .and. shrink*simulation%time_step &
         >= simulation%model%control%least_time_step .and. attempt < most_attempts) then
         simulation%time_step = shrink*simulation%time_step
         simulation%counters%repeated = simulation%counters%repeated + 1
         if (allocated(error)) deallocate (error)
      else if (allocated(error) .or. attempt > 3) then
         call explain(simulation, reason, error)
         return
      end if
      ! The next attempt starts from the contacts of the last good step, not from what went wrong.
      simulation%now = 3 - simulation%now
   end subroutine retry

   !> Make the solution of the step the new state.
   subroutine accept(simulation)
      type(simulation_type), intent(inout) :: simulation
      real(wp) :: end_time

      end_time = simulation%time + simulation%time_step
      simulation%last_time_step = simulation%time_step
      associate (contacts => simulation%contacts(simulation%now), d => simulation%system%d)
         call update_step(simulation%energy, simulation%model, simulation%blocks, contacts, &
            simulation%laws, d, end_time, simulation%time_step)
         call integrate(simulation%blocks, d, simulation%time_step)
         call update_state(simulation%energy, simulation%blocks)
         contacts%stretch(:contacts%n) = &
            contacts%shear_force(:contacts%n)/simulation%laws%shear_stiffness
         contacts%state(:contacts%n) = contacts%trial_state(:contacts%n)
      end associate
      simulation%neighbours%travel = simulation%neighbours%travel &
         + simulation%speed*simulation%time_step
      simulation%path = simulation%path + simulation%speed*simulation%time_step
      simulation%counters%broken = simulation%counters%broken + simulation%iteration%broken
      simulation%step = simulation%step + 1
      call move_clock(simulation, end_time)
   end subroutine accept

   !> With a fixed Δt, time is an exact multiple of it; an adaptive Δt recovers after each good
   !> step.
   subroutine move_clock(simulation, end_time)
      type(simulation_type), intent(inout) :: simulation
      real(wp), intent(in) :: end_time
      real(wp) :: left

      associate (control => simulation%model%control)
         if (.not. control%adaptive) then
            simulation%time = real(simulation%step, wp)*control%time_step
            return
         end if
         simulation%time = end_time
         left = real(control%steps, wp)*control%time_step - end_time
         simulation%time_step = min(control%time_step, recover*simulation%time_step)
         if (left > 0.0_wp) simulation%time_step = min(simulation%time_step, left)
      end associate
   end subroutine move_clock

end module dda_time_step
