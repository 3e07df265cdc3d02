! SPDX-License-Identifier: GPL-3.0-or-later
!> One time step: search contacts, assemble, solve by open–close iteration, integrate.  If
!> necessary and permitted, the step is repeated with a smaller Δt.
module dda_time_step
   use dda_kinds, only: wp
   use dda_breaking, only: break_faces
   use dda_friction, only: accept_contacts
   use dda_columns, only: column_count, column_of, pass_columns_to_sides, name_column
   use dda_contact_damping, only: damp_contacts, find_static_forces
   use dda_contact_search, only: find_contacts
   use dda_damage_passes, only: most_passes
   use dda_diagnostics, only: explain, check_state
   use dda_elements, only: accept_elements, has_unconverged_bounds, table_search_failed, &
      check_flow, prepare_elements, revise_elements, unconverged_block
   use dda_energy, only: add_energy, energy_algorithmic, energy_impact, energy_input, &
      energy_kinetic_damping
   use dda_energy_budget, only: update_step, update_state
   use dda_errors, only: error_type, error_convergence, error_input, error_interrupted, &
      error_memory, fail
   use dda_impact, only: count_impacts, resolve_impacts
   use dda_joint_law, only: weakened
   use dda_kinematics, only: damp_velocity, predict, integrate, largest_displacement
   use dda_body_drift, only: begin_drift
   use dda_matrix_pattern, only: assemble_step
   use dda_model, only: half_size
   use dda_material_search, only: shorten_step
   use dda_open_close, only: solve_contacts, counts_of, add_counts, most_bound_rounds
   use dda_original_rules, only: solve_by_original_rules
   use dda_scheme, only: end_time
   use dda_simulation, only: simulation_type, next_step, exchange_lists
   use dda_static_relaxation, only: many_changes, solve_statics
   use dda_stopwatch, only: begin_laps, record_lap, phase_assemble, phase_iterate, phase_update
   use dda_text, only: to_text
   implicit none
   private
   public :: advance

   !> factors of an adaptive Δt after a failure and a success
   real(wp), parameter :: shrink = 0.3_wp, growth = 1.3_wp
   integer, parameter :: most_attempts = 40                  !< largest number of attempts per step
   !> largest number of rounds of element states or Newton's method
   integer, parameter :: most_rounds = 60
   integer, parameter :: most_searches = 3  !< largest number of contact searches with the same Δt

contains

   !> Take one step.
   subroutine advance(simulation, error)
      type(simulation_type), intent(inout) :: simulation  !< a run and its state
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      real(wp) :: loss, move
      integer :: attempt, searches

      move = 0.0_wp
      searches = 0
      call begin_laps(simulation%system%watch)
      call damp_velocity(simulation%blocks, simulation%model%control%dynamic_factor, loss)
      call add_energy(simulation%energy, energy_kinetic_damping, loss)
      do attempt = 1, most_attempts
         call find_contacts(simulation, error)
         if (allocated(error)) return
         call solve_columns(simulation, attempt > 1, error)
         if (.not. allocated(error)) call solve_step(simulation, error)
         if (.not. allocated(error)) then
            move = largest_displacement(simulation%blocks, simulation%system%d)
            call record_move(simulation, move)
            if (.not. moves_too_far(simulation, move)) exit
         end if
         call prepare_retry(simulation, attempt, searches, move, error)
         if (allocated(error)) return
      end do
      call record_lap(simulation%system%watch, phase_iterate)
      call accept_columns(simulation, error)
      call accept_solution(simulation)
      if (.not. allocated(error)) call check_state(simulation, error)
      call record_lap(simulation%system%watch, phase_update)
   end subroutine advance

   !> Find the increment d of this step: assemble; iterate contacts, elements and material laws.
   subroutine solve_step(simulation, error)
      type(simulation_type), intent(inout) :: simulation  !< a run and its state
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      integer :: round, changed, former_counts(3)

      associate (contacts => simulation%contacts(simulation%now), counters => simulation%counters)
         contacts%was_bonded(:contacts%n) = contacts%bonded(:contacts%n)
         if (contacts%with_laws) &
            contacts%was_weakened(:contacts%n) = contacts%memory(weakened, :contacts%n)
         call predict(simulation%blocks, simulation%system%d, next_step(simulation))
         call prepare_elements(simulation%elements, simulation%blocks, next_step(simulation), &
            simulation%system%d)
         call check_flow(simulation%elements, error)
         if (allocated(error)) return
         former_counts = 0
         do round = 1, most_rounds
            call assemble_step(simulation, error)
            if (allocated(error)) exit
            call begin_drift(simulation%system, simulation%solver, simulation%blocks, &
               next_step(simulation))
            call record_lap(simulation%system%watch, phase_assemble)
            if (simulation%laws%damped .and. round > 1) call damp_contacts(contacts, &
               simulation%laws, simulation%blocks, next_step(simulation))  ! no impacts yet
            if (simulation%elements%nonlinear) simulation%linear_about = simulation%system%d
            call iterate_contacts(simulation, error)
            call add_counts(simulation%iteration, former_counts)
            former_counts = counts_of(simulation%iteration)
            if (allocated(error)) exit
            if (simulation%elements%nonlinear) call shorten_step(simulation)
            call revise_elements(simulation%elements, simulation%blocks, next_step(simulation), &
               simulation%system%d, changed)
            if (changed == 0) exit
         end do
         if (round > most_rounds) call fail(error, error_convergence, unconverged_text(simulation))
         counters%iterations = counters%iterations + simulation%iteration%iterations
         counters%most_iterations = max(counters%most_iterations, simulation%iteration%iterations)
      end associate
   end subroutine solve_step

   !> Return the message on element states or stresses that have not converged in a step.
   pure function unconverged_text(simulation) result(text)
      type(simulation_type), intent(in) :: simulation  !< a run and its state
      character(len=:), allocatable :: text
      integer :: block

      block = unconverged_block(simulation%elements)
      text = 'states of bolts or of water in joints do not converge in '//to_text(most_rounds)// &
         ' rounds'
      if (block > 0) text = 'the stress of the material law does not converge in block '// &
         to_text(block)
   end function unconverged_text

   !> Solve the step for the free-field columns, and pass the solutions to the sides of the model.
   !> In statics the columns are already in equilibrium.
   subroutine solve_columns(simulation, repeated, error)
      type(simulation_type), intent(inout) :: simulation  !< a run and its state
      logical, intent(in) :: repeated  !< another attempt at the same step
      type(error_type), allocatable, intent(out) :: error  !< error of the last column that fails
      type(error_type), allocatable :: failure
      integer :: i

      if (simulation%in_statics) return
      do i = 1, column_count(simulation)
         call solve_column(column_of(simulation, i), simulation%time_step, repeated, failure)
         call name_column(simulation, i, failure)
         if (allocated(failure)) call move_alloc(failure, error)
      end do
      if (.not. allocated(error)) call pass_columns_to_sides(simulation)
   end subroutine solve_columns

   !> Solve the step of a column; repeat it with a wider contact search if the column moves too far.
   subroutine solve_column(run, time_step, repeated, error)
      type(simulation_type), intent(inout) :: run  !< run of the column
      real(wp), intent(in) :: time_step            !< Δt of the model, s
      logical, intent(in) :: repeated                 !< another attempt at the same step
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      real(wp) :: move
      integer :: search

      run%time_step = time_step
      do search = 1, most_searches
         if (repeated .or. search > 1) call exchange_lists(run)
         call find_contacts(run, error)
         if (.not. allocated(error)) call solve_step(run, error)
         if (allocated(error)) return
         move = largest_displacement(run%blocks, run%system%d)
         call record_move(run, move)
         if (.not. moves_too_far(run, move)) return
      end do
      call fail(error, error_convergence, 'a vertex moves too far in one step')
   end subroutine solve_column

   !> Accept the solutions of the columns.
   subroutine accept_columns(simulation, error)
      type(simulation_type), intent(inout) :: simulation  !< a run and its state
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      integer :: i

      if (simulation%in_statics) return
      do i = 1, column_count(simulation)
         call accept_solution(column_of(simulation, i))
         call check_state(column_of(simulation, i), error)
         call name_column(simulation, i, error)
         if (allocated(error)) return
      end do
   end subroutine accept_columns

   !> Iterate the contact states by the method that the input selects.
   subroutine iterate_contacts(simulation, error)
      type(simulation_type), intent(inout) :: simulation  !< a run and its state
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure

      associate (contacts => simulation%contacts(simulation%now))
         if (simulation%model%contact%original_rules) then
            call solve_by_original_rules(simulation%iteration, simulation%system, &
               simulation%solver, contacts, simulation%laws, half_size(simulation%model%blocks), &
               simulation%step == 0, error)
         else
            simulation%iteration%rounds = most_bound_rounds
            if (simulation%model%control%adaptive) simulation%iteration%rounds = 0
            if (simulation%in_statics) simulation%iteration%rounds = 1  ! then Δt is reduced
            if (simulation%iteration%may_relax .and. (simulation%iteration%relaxes .or. &
               contacts%n > many_changes)) then
               call solve_statics(simulation%iteration, simulation%system, simulation%solver, &
                  contacts, simulation%laws, error)
            else
               call solve_contacts(simulation%iteration, simulation%system, simulation%solver, &
                  contacts, simulation%laws, error)
            end if
            if (simulation%laws%damped .and. .not. allocated(error)) &
               call resolve_impacts(simulation%impacts, simulation%iteration, simulation%system, &
               simulation%solver, contacts, simulation%laws, simulation%blocks, &
               next_step(simulation), norm2(simulation%model%control%gravity), error)
         end if
      end associate
   end subroutine iterate_contacts

   !> Return the largest allowed displacement of a vertex in a step, m.
   !> In statics it is at most the distance for which contacts are listed.
   pure real(wp) function allowed_move(simulation)  ! total
      type(simulation_type), intent(in) :: simulation  !< a run and its state

      allowed_move = simulation%model%control%max_displacement_ratio &
         *half_size(simulation%model%blocks)
      if (simulation%in_statics) allowed_move = min(allowed_move, simulation%detection%least)
   end function allowed_move

   !> Store the largest speed for the next search, and count steps beyond the maximum displacement.
   !> In statics a step beyond the maximum is repeated with a shorter Δt, so the recorded speed is
   !> limited.
   pure subroutine record_move(simulation, move)
      type(simulation_type), intent(inout) :: simulation  !< a run and its state
      real(wp), intent(in) :: move  !< upper bound of vertex displacements, m
      real(wp) :: reached

      reached = min(move, half_size(simulation%model%blocks))
      if (simulation%in_statics) reached = min(move, allowed_move(simulation))
      simulation%speed = reached/simulation%time_step
      if (move > allowed_move(simulation)) &
         simulation%counters%too_far = simulation%counters%too_far + 1
   end subroutine record_move

   !> .true. if a vertex moves beyond the maximum displacement, or so far that unlisted contacts may
   !> touch.
   pure logical function moves_too_far(simulation, move)
      type(simulation_type), intent(in) :: simulation  !< a run and its state
      real(wp), intent(in) :: move  !< upper bound of vertex displacements, m

      moves_too_far = ((simulation%model%control%adaptive .or. simulation%in_statics) .and. &
         move > allowed_move(simulation)) &
         .or. 2*move > simulation%detection%distance
   end function moves_too_far

   !> Prepare another attempt at the step: with a smaller Δt if allowed, else with a wider search.
   !>
   !> In statics Δt is also reduced if a vertex moves beyond the maximum displacement, because the
   !> list of contacts is valid only near the positions at the start of the step.
   subroutine prepare_retry(simulation, attempt, searches, move, error)
      type(simulation_type), intent(inout) :: simulation  !< a run and its state
      integer, intent(in) :: attempt  !< number of the attempt
      integer, intent(inout) :: searches  !< searches with the same Δt; in statics, attempts
      real(wp), intent(in) :: move  !< upper bound of vertex displacements, m
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      character(len=:), allocatable :: reason
      logical :: shorter

      if (allocated(error)) then
         if (error%kind == error_interrupted) return
      end if
      shorter = simulation%model%control%adaptive .and. &
         shrink*simulation%time_step >= simulation%model%control%least_time_step
      if (simulation%in_statics .and. .not. allocated(error)) &
         shorter = move > allowed_move(simulation)
      searches = merge(searches + merge(0, 1, shorter), attempt, simulation%in_statics)
      reason = 'a vertex moves too far in one step'
      if (allocated(error)) then
         reason = error%message
         shorter = shorter .and. error%kind /= error_memory .and. error%kind /= error_input
      end if
      if (shorter .and. attempt < most_attempts) then
         simulation%time_step = shrink*simulation%time_step
         simulation%counters%repeated = simulation%counters%repeated + 1
         if (allocated(error)) deallocate (error)
      else if (allocated(error) .or. searches > most_searches) then
         call explain(simulation, reason, error)
         return
      end if
      ! The next attempt starts from the contacts of the last accepted step.
      call exchange_lists(simulation)
   end subroutine prepare_retry

   !> Accept the solution of the step as the new state.
   subroutine accept_solution(simulation)
      type(simulation_type), intent(inout) :: simulation  !< a run and its state
      real(wp) :: path

      simulation%last_time_step = simulation%time_step
      path = simulation%speed*simulation%time_step
      associate (contacts => simulation%contacts(simulation%now), d => simulation%system%d, &
         step => next_step(simulation))
         call update_step(simulation%energy, simulation%blocks, contacts, simulation%laws, &
            simulation%elements, step, d)
         if (simulation%laws%damped) then
            call add_energy(simulation%energy, energy_input, simulation%impacts%work)
            call add_energy(simulation%energy, energy_impact, simulation%impacts%energy_lost)
            call count_impacts(simulation%impacts)
         end if
         call add_energy(simulation%energy, energy_algorithmic, &
            simulation%iteration%unbalanced_work)
         call accept_elements(simulation%elements, simulation%blocks, step, d)
         call integrate(simulation%blocks, d, step)
         call update_state(simulation%energy, simulation%blocks)
         call accept_contacts(contacts, simulation%laws)
         if (simulation%laws%damped) call find_static_forces(contacts)
         simulation%neighbours%travel = simulation%neighbours%travel + path
         simulation%path = simulation%path + path
         call record_changes(simulation)
         simulation%step = simulation%step + 1
         call move_clock(simulation, end_time(step))
      end associate
      if (.not. simulation%in_statics) call break_faces(simulation)
   end subroutine accept_solution

   !> Count broken bonds, steps with unconverged damage or friction bounds, and changes of contact
   !> states; changes in the first step are not counted.
   pure subroutine record_changes(simulation)
      type(simulation_type), intent(inout) :: simulation  !< a run and its state

      associate (counters => simulation%counters, iteration => simulation%iteration)
         counters%broken = counters%broken + iteration%broken
         if (simulation%laws%cohesive) counters%broken = counters%broken + spent_bonds(simulation)
         if (iteration%passes > most_passes) &
            counters%unconverged_damage = counters%unconverged_damage + 1
         if (has_unconverged_bounds(simulation%elements)) &
            counters%unconverged_bounds = counters%unconverged_bounds + 1
         if (table_search_failed(simulation%elements)) counters%tables_off = counters%tables_off + 1
         if (simulation%step > 0) counters%changes = counters%changes + iteration%changes &
            + iteration%broken
      end associate
   end subroutine record_changes

   !> Return the number of cohesive bonds that have failed completely in the last step.
   pure integer function spent_bonds(simulation)
      type(simulation_type), intent(in) :: simulation  !< a run and its state

      associate (contacts => simulation%contacts(simulation%now), n => &
         simulation%contacts(simulation%now)%n)
         spent_bonds = count(contacts%was_bonded(:n) .and. .not. contacts%bonded(:n) .and. &
            contacts%was_weakened(:n) < 1.0_wp .and. contacts%acting_damage(:n) < 1.0_wp)
      end associate
   end function spent_bonds

   !> Advance time, by exact multiples of a fixed Δt; increase an adaptive Δt after each step.
   pure subroutine move_clock(simulation, time)
      type(simulation_type), intent(inout) :: simulation  !< a run and its state
      real(wp), intent(in) :: time  !< time at the end of the step, s
      real(wp) :: remaining

      associate (control => simulation%model%control)
         if (.not. control%adaptive) then
            simulation%time = simulation%first_time + real(simulation%step &
               - simulation%first_step, wp)*control%time_step
            return
         end if
         simulation%time = time
         remaining = simulation%first_time + real(control%step_count, wp)*control%time_step - time
         simulation%time_step = min(control%time_step, growth*simulation%time_step)
         if (remaining > 0.0_wp) simulation%time_step = min(simulation%time_step, remaining)
      end associate
   end subroutine move_clock

end module dda_time_step
