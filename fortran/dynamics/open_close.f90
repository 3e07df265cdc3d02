! SPDX-License-Identifier: GPL-3.0-or-later
!> Open–close iteration: find contact states that are consistent with the solution.
!>
!> Each iteration assumes the states, solves, evaluates the contact laws, and adopts the states of
!> the laws (open, sticking, sliding).  Convergence is judged by the largest difference between the
!> assumed force of a contact and the force by its law.
module dda_open_close
   use dda_kinds, only: wp
   use dda_contact_terms, only: update_contact_terms
   use dda_damage_passes, only: renew_damage
   use dda_errors, only: error_type, error_convergence, fail
   use dda_block_vectors, only: copy_vector
   use dda_contact, only: contacts_type, contact_open, contact_slide, contact_stick
   use dda_contact_evaluation, only: evaluate_contacts, evaluate_some
   use dda_friction, only: acting, laws_type, shear_stiffness_of, start_force
   use dda_interrupts, only: fail_if_stopped, fail_within_step, stop_within_step
   use dda_friction_bounds, only: bounds_type, freeze_bounds, unfreeze_bounds, renew_bounds
   use dda_growth, only: grow
   use dda_line_search, only: descend
   use dda_linear_solver, only: solver_type
   use dda_ordered_sums, only: pieces, first_of, last_of, parallel_from
   use dda_rank_one, only: most_changes
   use dda_slide_forces, only: slides_type, list_slides, evaluate_slides, slide_difference, &
      least_converged, assume_next_forces
   use dda_joint_lines, only: break_joint, drop_friction, has_bond, renew_lines
   use dda_step_solution, only: solve_equations
   use dda_stopwatch, only: record_lap, phase_assemble, phase_iterate, phase_solve
   use dda_system, only: system_type
   implicit none
   private
   public :: open_close_type, solve_contacts, solve_assumed, begin_iteration, counts_of, &
      add_counts, iterate, evaluate, check_strength, adopt_trial_states, fail_if_step_stopped, &
         loose_residual, retained_fraction, most_bound_rounds

   real(wp), parameter :: short_step = 0.5_wp  !< α of the line search after an overshoot
   real(wp), parameter :: very_short_step = 0.1_wp  !< α below which a step is very short
   integer, parameter :: most_short_steps = 6        !< very short steps before a whole step
   integer, parameter :: few_solves = 45  !< number of first solutions in which `rounding` applies
   !> largest number of rounds if Δt cannot be reduced: each has a phase with free and a phase with
   !> frozen friction bounds, because one may converge if the other does not.  With 4 rounds, 5 of
   !> 216 hard walls of Plesha, continuously yielding and restituting joints would not converge
   integer, parameter :: most_bound_rounds = 8
   !> iteration limit with frozen bounds over the limit with free bounds: frozen bounds converge
   !> slowly but reliably, in about 200 iterations for a wall of 120 bricks at Δt = 20 ms
   integer, parameter :: patience = 8
   !> force difference/tolerance below which lines are kept
   real(wp), parameter :: least_share = 0.1_wp
   integer, parameter :: most_friction_solves = 60   !< largest number of solutions at fixed states
   !> relative residual of all but the final solution
   real(wp), parameter :: loose_residual = 1.0e-2_wp
   real(wp), parameter :: friction_reduction = 0.2_wp !< target ratio of slide-force differences
   !> successive short steps before all sliding contacts retain stiffness.  With 2, walls under
   !> gravity need 1.3 times as many factorisations; with 8, static stages do not converge
   integer, parameter :: most_overshoots = 4
   real(wp), parameter :: near_whole = 0.9_wp  !< α above which a step has not overshot
   !> changes/contacts above which overshoot is expected
   real(wp), parameter :: many_changes = 0.05_wp
   !> first retained fraction of the secant shear stiffness; also its factor per iteration
   real(wp), parameter :: retained_fraction = 0.3_wp
   real(wp), parameter :: first_retained = 0.01_wp   !< first `retained` of all sliding contacts
   real(wp), parameter :: least_retained = 0.03_wp   !< smallest retained fraction

   !> Settings and outcome of the iteration of one step.
   type :: open_close_type
      ! unsaved, cleared at the start of each step: region_residual, keeps_states
      ! unsaved, the input: max_iterations, relative_tolerance, weight, penetration_tolerance
      ! unsaved, the input; under joint laws set in each step: noise
      ! unsaved, set in static stages: may_stop, may_relax, relaxes
      ! unsaved, set in each step: rounds, converged, unbalanced_work, rounding
      ! unsaved, counted in each step: passes
      ! unsaved, set in static steps: most_changes
      ! unsaved, listed in each iteration: slides
      ! unsaved, found in each iteration: reversed
      integer :: max_iterations = 400
      integer :: most_changes = huge(1)   !< largest number of changes in the first iteration
      integer :: rounds = 0  !< rounds with frozen friction bounds before the step fails
      real(wp) :: relative_tolerance = 1.0e-9_wp      !< tolerance/largest force
      real(wp) :: penetration_tolerance = 0.0_wp      !< penetration, m; > 0: augmented Lagrangian
      real(wp) :: weight = 0.0_wp                     !< largest block weight, N/m
      real(wp) :: noise = 0.0_wp  !< contact force due to rounding of positions, N/m
      !> factor of `noise` in the first `few_solves` solutions: rounding errors of increments are
      !> smaller than rounding errors of positions.  It is below 1 for bodies, because
      !> friction would otherwise lag at each corner of a cell
      real(wp) :: rounding = 1.0_wp
      logical :: may_stop = .false.  !< a signal may stop the iteration at once
      integer :: iterations = 0                       !< number of solutions in this step
      integer :: changes = 0                          !< number of changed states in this step
      integer :: broken = 0                           !< number of broken bonds in this step
      real(wp) :: residual = 0.0_wp                   !< largest force difference, N/m
      real(wp) :: tolerance = 0.0_wp                  !< tolerance of the force difference, N/m
      integer :: unconverged = 0  !< contact with the largest difference; 0: converged
      integer :: short_steps = 0                      !< successive very short steps
      integer :: passes = 0                           !< number of passes that update bond damage
      integer :: overshoots = 0  !< successive short steps with sliding contacts
      logical :: shortened = .false.                  !< the last step was short
      logical, allocatable :: reversed(:)  !< [contacts] the slip in the whole step reverses
      !> residual at the last iteration of regions, N/m; regions are iterated again if it decreases
      real(wp) :: region_residual = huge(1.0_wp)
      logical :: keeps_states = .false.  !< contacts within the tolerance keep their states
      real(wp) :: retained = 0.0_wp                   !< least retained fraction of sliding contacts
      logical :: may_relax = .false.  !< relaxation is used if many states change
      logical :: relaxes = .false.     !< all static steps are relaxed
      logical :: converged = .true.  !< the last relaxed step has converged
      real(wp) :: unbalanced_work = 0.0_wp  !< work of unbalanced forces in a relaxed step, J/m
      real(wp) :: reduction = 0.0_wp  !< relative residual of solutions: `loose_residual` or 0
      type(slides_type) :: slides                     !< sliding contacts and their forces
   end type open_close_type

   interface
      !> Iterate the contacts in regions (groups of blocks) where states change; fix other blocks.
      recursive module subroutine iterate_regions(iteration, system, contacts, laws)
         type(open_close_type), intent(inout) :: iteration  !< open–close iteration of the step
         type(system_type), intent(inout) :: system  !< equations of the step; d changes
         type(contacts_type), intent(inout) :: contacts  !< contacts of this step, evaluated
         type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      end subroutine iterate_regions
   end interface

contains

   !> Iterate until the assumed force of each contact equals the force by its law.
   !>
   !> If a quarter of the permitted iterations does not suffice, phases with frozen (constant) and
   !> with free friction bounds alternate, for at most `iteration%rounds` rounds.
   subroutine solve_contacts(iteration, system, solver, contacts, laws, error)
      type(open_close_type), intent(inout) :: iteration  !< open–close iteration of the step
      type(system_type), intent(inout) :: system  !< equations of the step
      type(solver_type), intent(inout) :: solver  !< linear solver
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      logical :: converged, by_bounds
      integer :: before(3), most, rounds, round

      iteration%keeps_states = .false.
      by_bounds = iteration%rounds > 0
      before = 0
      most = iteration%max_iterations
      rounds = 1
      if (by_bounds .and. most/4 > few_solves) then  ! a small limit is not divided
         rounds = iteration%rounds
         iteration%max_iterations = most/4
      end if
      do round = 1, rounds
         call iterate(iteration, system, solver, contacts, laws, converged, error)
         call add_counts(iteration, before)
         if (by_bounds .and. .not. (converged .or. allocated(error))) &
            call find_bounds(iteration, system, solver, contacts, laws, &
            merge(patience, 1, rounds > 1)*iteration%max_iterations, round, converged, error)
         if (converged .or. allocated(error)) exit
         before = counts_of(iteration)
      end do
      iteration%max_iterations = most
      if (.not. (converged .or. allocated(error))) call fail(error, error_convergence, &
         'the open–close iteration does not converge')
   end subroutine solve_contacts

   !> Iterate with frozen friction bounds until they agree with the normal forces.
   subroutine find_bounds(iteration, system, solver, contacts, laws, limit, round, converged, &
      error)
      type(open_close_type), intent(inout) :: iteration  !< open–close iteration of the step
      type(system_type), intent(inout) :: system  !< equations of the step
      type(solver_type), intent(inout) :: solver  !< linear solver
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: limit  !< iteration limit per set of bounds; half of the total limit
      integer, intent(in) :: round  !< number of this search in the step, from 1
      logical, intent(out) :: converged  !< the bounds and all contact forces have converged
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      type(bounds_type) :: bounds
      integer :: before(3), most, saved_limit

      call freeze_bounds(bounds, contacts, laws, round)
      saved_limit = iteration%max_iterations
      most = iteration%iterations + 2*limit
      iteration%max_iterations = limit
      do while (iteration%iterations < most)
         before = counts_of(iteration)
         call iterate(iteration, system, solver, contacts, laws, converged, error)
         call add_counts(iteration, before)
         if (allocated(error) .or. .not. converged) exit
         call renew_bounds(bounds, contacts, laws, iteration%tolerance)
         converged = bounds%difference <= iteration%tolerance
         if (converged) exit
         iteration%unconverged = bounds%unconverged
         iteration%residual = bounds%difference
      end do
      iteration%max_iterations = saved_limit
      call unfreeze_bounds(contacts)
   end subroutine find_bounds

   !> Iterate states until the assumed forces equal the forces by the laws.
   recursive subroutine iterate(iteration, system, solver, contacts, laws, converged, error)
      type(open_close_type), intent(inout) :: iteration  !< open–close iteration of the step
      type(system_type), intent(inout) :: system  !< equations of the step
      type(solver_type), intent(inout) :: solver  !< linear solver
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      logical, intent(out) :: converged  !< the forces have converged
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      integer :: changed, diverged, i
      logical :: exactly

      call begin_iteration(iteration, contacts)
      converged = .false.
      if (allocated(contacts%frozen_bound)) then  ! consistent states, so that the energy decreases
         call evaluate(iteration, system, contacts, laws)
         call adopt_states(iteration, contacts, laws, changed)
      end if
      exactly = .not. any(contacts%state(:contacts%n) == contact_slide)
      if (.not. exactly) iteration%reduction = loose_residual
      do i = 1, iteration%max_iterations
         call fail_if_step_stopped(iteration%may_stop, error)
         if (allocated(error)) return
         iteration%iterations = i
         call solve_assumed(iteration, system, solver, contacts, laws, error)
         if (allocated(error)) return
         call find_forces(iteration, system, solver, contacts, laws, exactly, diverged, error)
         if (allocated(error)) return
         if (diverged > 0) then
            call force_to_stick(system, contacts, laws, diverged)
            exactly = .false.
            cycle
         end if
         if (iteration%residual <= iteration%tolerance) &
            call finish_solve(iteration, system, solver, contacts, laws, error)
         if (allocated(error)) return
         iteration%reduction = loose_residual
         if (iteration%residual <= iteration%tolerance) then
            call check_strength(iteration, contacts, laws, converged)
            if (converged) return
         end if
         call iterate_regions(iteration, system, contacts, laws)
         call globalise(iteration, system, contacts, laws)
         call adopt_states(iteration, contacts, laws, changed)
         exactly = changed == 0
         iteration%changes = iteration%changes + changed
         if (iteration%changes > iteration%most_changes .and. i == 1) return
      end do
   end subroutine iterate

   !> Return an error if a signal or an earlier error stops the step.
   subroutine fail_if_step_stopped(may_stop, error)
      logical, intent(in) :: may_stop  !< a signal may stop the iteration at once
      type(error_type), allocatable, intent(inout) :: error  !< allocated if the step is stopped

      if (may_stop) then
         call fail_if_stopped(error)
      else if (stop_within_step()) then
         call fail_within_step(error)
      end if
   end subroutine fail_if_step_stopped

   !> Reset the iteration for a new step.
   pure subroutine begin_iteration(iteration, contacts)
      type(open_close_type), intent(inout) :: iteration  !< open–close iteration of the step
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step

      iteration%converged = .true.
      iteration%unbalanced_work = 0.0_wp
      iteration%iterations = 0
      iteration%changes = 0
      iteration%broken = 0
      iteration%passes = 0
      iteration%overshoots = 0
      iteration%shortened = .false.
      iteration%region_residual = huge(1.0_wp)
      iteration%retained = 0.0_wp
      iteration%reduction = 0.0_wp
      iteration%short_steps = 0
      iteration%unconverged = 0  ! contact numbers of the previous list are invalid
      contacts%close_count(:contacts%n) = 0
      contacts%retained(:contacts%n) = 0.0_wp
   end subroutine begin_iteration

   !> Return the number of iterations, changed states and broken bonds of the step so far.
   pure function counts_of(iteration) result(counts)
      type(open_close_type), intent(in) :: iteration  !< open–close iteration of the step
      integer :: counts(3)

      counts = [iteration%iterations, iteration%changes, iteration%broken]
   end function counts_of

   !> Add the counts before a restart of the iteration within the step.
   pure subroutine add_counts(iteration, before)
      type(open_close_type), intent(inout) :: iteration  !< open–close iteration of the step
      integer, intent(in) :: before(3)  !< counts from `counts_of`

      iteration%iterations = iteration%iterations + before(1)
      iteration%changes = iteration%changes + before(2)
      iteration%broken = iteration%broken + before(3)
   end subroutine add_counts

   !> Solve for d with the contacts in their assumed states.
   subroutine solve_assumed(iteration, system, solver, contacts, laws, error)
      type(open_close_type), intent(inout) :: iteration  !< open–close iteration of the step
      type(system_type), intent(inout) :: system  !< equations of the step
      type(solver_type), intent(inout) :: solver  !< linear solver
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure

      call record_lap(system%watch, phase_iterate)
      call update_contact_terms(system%contact_terms, contacts, laws)
      call copy_vector(size(system%d, 2), system%d, system%previous_d)
      call record_lap(system%watch, phase_assemble)
      call solve_equations(system, solver, contacts, error, iteration%reduction)
      call record_lap(system%watch, phase_solve)
   end subroutine solve_assumed

   !> Find the friction forces of the assumed states, and evaluate the laws at the solution.
   !> If no state changes, the friction forces are iterated again, to the full tolerance.
   subroutine find_forces(iteration, system, solver, contacts, laws, exactly, diverged, error)
      type(open_close_type), intent(inout) :: iteration  !< open–close iteration of the step
      type(system_type), intent(inout) :: system  !< equations of the step
      type(solver_type), intent(inout) :: solver  !< linear solver
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      logical, intent(in) :: exactly  !< satisfy the tolerance at once
      integer, intent(out) :: diverged  !< see `solve_friction`
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      integer :: pass

      call list_slides(iteration%slides, contacts)
      do pass = 1, 2
         call solve_friction(iteration, system, solver, contacts, laws, &
            exactly .or. pass == 2, diverged, error)
         if (allocated(error)) return
         call record_lap(system%watch, phase_solve)
         if (diverged > 0) return
         call evaluate(iteration, system, contacts, laws)
         if (exactly .or. iteration%slides%n == 0 .or. will_change(contacts)) return
      end do
   end subroutine find_forces

   !> .true. if a contact retains stiffness, or if its state differs from the state by its law.
   pure logical function will_change(contacts)  ! total
      type(contacts_type), intent(in) :: contacts  !< contacts of this step, evaluated

      will_change = any(contacts%trial_state(:contacts%n) /= contacts%state(:contacts%n) &
         .or. contacts%retained(:contacts%n) > 0.0_wp)
   end function will_change

   !> Evaluate the laws and the residual at d.
   subroutine evaluate(iteration, system, contacts, laws, moved)
      type(open_close_type), intent(inout) :: iteration  !< open–close iteration of the step
      type(system_type), intent(in) :: system  !< equations of the step, solved
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in), optional :: moved(:)  !< contacts of changed blocks; without it, all
      real(wp) :: largest

      largest = iteration%weight
      if (present(moved)) then
         call evaluate_some(contacts, laws, system%d, moved, largest, iteration%residual)
      else
         call evaluate_contacts(contacts, laws, system%d, largest, iteration%residual)
      end if
      iteration%tolerance = tolerance_of(iteration, system, contacts, laws, largest)
      iteration%unconverged = 0
      if (iteration%residual > iteration%tolerance) &
         iteration%unconverged = maxloc(contacts%force_residual(:contacts%n), 1)
      if (system%contact_terms%by_state) call keep_states(iteration, contacts)
   end subroutine evaluate

   !> Return the tolerance of the force difference at an iterate, N/m, from its largest force.
   !> `given_force` limits the largest force in the final check.  Iterates far from the solution
   !> have very large forces, with which any difference would be tolerated.
   pure real(wp) function tolerance_of(iteration, system, contacts, laws, largest) result(tolerance)
      type(open_close_type), intent(in) :: iteration  !< open–close iteration of the step
      type(system_type), intent(in) :: system  !< equations of the step
      type(contacts_type), intent(in) :: contacts  !< contacts of this step, evaluated
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      real(wp), intent(in) :: largest  !< largest force of the iterate, N/m
      real(wp) :: noise

      noise = noise_after(iteration, iteration%iterations)
      tolerance = max(iteration%relative_tolerance*largest, noise)
      if (iteration%residual > tolerance .or. .not. tolerance > noise) return
      if (iteration%residual > noise .or. allocated(contacts%frozen_bound)) &
         tolerance = max(noise, iteration%relative_tolerance*min(largest, &
         max(iteration%weight, given_force(system, contacts, laws))))
   end function tolerance_of

   !> Sum of loads and inertia forces of all blocks, plus the largest contact force at d = 0, N/m.
   pure real(wp) function given_force(system, contacts, laws) result(given)
      type(system_type), intent(in) :: system  !< equations of the step
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer :: c

      given = 0.0_wp
      do c = 1, contacts%n
         if (contacts%gap(c) < 0.0_wp) given = max(given, start_force(contacts, laws, c))
      end do
      given = given + sum(maxval(abs(system%load(1:2, :)), 1))
   end function given_force

   !> Let contacts within the tolerance keep their states, if too many of them would change.
   !> The limit is the number of changes in a low-rank update; the rule applies until the step ends.
   !>
   !> Between blocks that fall together, gaps are rounding errors and states are random.  Many
   !> changes of such states would require a new factorisation in each iteration.
   pure subroutine keep_states(iteration, contacts)
      type(open_close_type), intent(inout) :: iteration  !< open–close iteration of the step
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step, evaluated
      integer :: n

      n = contacts%n
      if (.not. iteration%keeps_states) iteration%keeps_states = most_changes < count( &
         contacts%trial_state(:n) /= contacts%state(:n) .and. &
         contacts%force_residual(:n) <= iteration%tolerance)
      if (.not. iteration%keeps_states) return
      where (contacts%force_residual(:n) <= iteration%tolerance) &
         contacts%trial_state(:n) = contacts%state(:n)
   end subroutine keep_states

   !> Return the tolerated rounding error of contact forces after a number of solutions, N/m.
   pure real(wp) function noise_after(iteration, solves) result(noise)
      type(open_close_type), intent(in) :: iteration  !< open–close iteration of the step
      integer, intent(in) :: solves  !< number of solutions

      noise = iteration%noise*merge(iteration%rounding, 1.0_wp, solves <= few_solves)
   end function noise_after

   !> Solve to full accuracy and evaluate again; nothing is done for a direct solver.
   subroutine finish_solve(iteration, system, solver, contacts, laws, error)
      type(open_close_type), intent(inout) :: iteration  !< open–close iteration of the step
      type(system_type), intent(inout) :: system  !< equations of the step
      type(solver_type), intent(inout) :: solver  !< linear solver
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure

      if (solver%exact) return
      call solve_equations(system, solver, contacts, error, 0.0_wp)
      if (.not. allocated(error)) call evaluate(iteration, system, contacts, laws)
   end subroutine finish_solve

   !> Find the friction forces that correspond to the normal forces, for fixed states.
   subroutine solve_friction(iteration, system, solver, contacts, laws, exactly, diverged, error)
      type(open_close_type), intent(inout) :: iteration  !< open–close iteration of the step
      type(system_type), intent(inout) :: system  !< equations of the step
      type(solver_type), intent(inout) :: solver  !< linear solver
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      logical, intent(in) :: exactly !< satisfy the tolerance; else only reduce differences
      integer, intent(out) :: diverged !< contact whose friction force diverges; 0: none
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      real(wp) :: difference, first, wanted, reduction
      integer :: i

      diverged = 0
      if (iteration%slides%n == 0) return
      wanted = iteration%tolerance
      do i = 1, most_friction_solves
         call evaluate_slides(iteration%slides, contacts, laws, system%d)
         difference = slide_difference(iteration%slides)
         if (i == 1) first = difference
         if (.not. difference*epsilon(1.0_wp) <= first) exit  ! the difference has no accurate digit
         if (i == 1 .and. .not. exactly) wanted = max(wanted, friction_reduction*difference)
         wanted = max(wanted, noise_after(iteration, i))
         reduction = loose_residual
         if (difference > wanted) then
            call assume_next_forces(iteration%slides, contacts, system)
         else if (exactly .and. .not. solver%exact) then
            reduction = 0.0_wp
         else
            return
         end if
         if (exactly) then
            call solve_equations(system, solver, contacts, error, reduction, difference > wanted)
         else
            call solve_equations(system, solver, contacts, error, reduction, .true., &
               iteration%slides%rhs_change)
         end if
         if (allocated(error)) return
      end do
      diverged = least_converged(iteration%slides)
   end subroutine solve_friction

   !> Change the contact whose friction force diverges to sticking, and discard the solution.
   !> At high friction, no solution may exist with this contact sliding.
   pure subroutine force_to_stick(system, contacts, laws, diverged)
      type(system_type), intent(inout) :: system  !< equations of the step
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: diverged  !< number of the contact

      call drop_friction(contacts, laws, diverged)
      contacts%state(diverged) = contact_stick
      contacts%slide_force(:contacts%n) = 0.0_wp
      system%d = system%previous_d
   end subroutine force_to_stick

   !> Apply a line search if states change, and retain stiffness if iterations remain short.
   !>
   !> If freely sliding contacts must stick, the line search shortens the iteration strongly, and
   !> only the first of these contacts stick.  The other reversed contacts are also set to stick,
   !> because each of them would shorten another iteration.  If iterations remain short, all sliding
   !> contacts retain a growing fraction of their shear stiffness until whole iterations succeed.
   subroutine globalise(iteration, system, contacts, laws)
      type(open_close_type), intent(inout) :: iteration  !< open–close iteration of the step
      type(system_type), intent(inout) :: system  !< equations of the step
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      real(wp) :: alpha
      logical :: overshot, frozen
      integer :: n

      frozen = allocated(contacts%frozen_bound)
      if (iteration%iterations == 1 .and. .not. (laws%curved .or. frozen)) return
      n = contacts%n
      alpha = 1.0_wp
      call grow(iteration%reversed, n)
      iteration%reversed(:n) = contacts%state(:n) == contact_slide .and. &
         contacts%trial_state(:n) == contact_stick
      overshot = any(iteration%reversed(:n))
      if (frozen .or. laws%curved .or. &
         (iteration%short_steps < most_short_steps .and. &
         any(contacts%trial_state(:n) /= contacts%state(:n)))) then
         call descend(system, contacts, laws, alpha)
         if (alpha < 1.0_wp) call evaluate(iteration, system, contacts, laws)
      end if
      if (alpha < 1.0_wp .and. .not. frozen) where (iteration%reversed(:n) .and. &
         contacts%trial_state(:n) == contact_slide) contacts%trial_state(:n) = contact_stick
      iteration%short_steps = merge(iteration%short_steps + 1, 0, alpha < very_short_step)
      iteration%shortened = alpha < near_whole
      iteration%overshoots = merge(iteration%overshoots + 1, 0, alpha < short_step .and. overshot)
      if (iteration%overshoots >= most_overshoots) &
         iteration%retained = min(1.0_wp, max(first_retained, 3*iteration%retained))
      if (alpha > short_step) iteration%retained = iteration%retained/10
      if (iteration%retained < 0.1_wp*first_retained) iteration%retained = 0.0_wp
   end subroutine globalise

   !> Accept a converged step if no bond is overloaded, no penetration exceeds the tolerance, and
   !> damage has converged.  Else update bonds, multipliers or damage, and continue to iterate.
   subroutine check_strength(iteration, contacts, laws, converged)
      type(open_close_type), intent(inout) :: iteration  !< open–close iteration of the step
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      logical, intent(out) :: converged  !< the step is accepted
      integer :: broken

      call break_bonds(iteration, contacts, laws, broken)
      converged = broken == 0
      if (converged) call update_multipliers(iteration, contacts, converged)
      if (converged .and. laws%cohesive) &
         call renew_damage(contacts, laws, iteration%passes, converged)
   end subroutine check_strength

   !> Break the bonds that are overloaded in the converged solution; the iteration continues.
   subroutine break_bonds(iteration, contacts, laws, broken)
      type(open_close_type), intent(inout) :: iteration  !< open–close iteration of the step
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(out) :: broken  !< number of contacts that lose peak strength
      integer :: c

      broken = 0
      if (.not. contacts%with_strengths) return
      do c = 1, contacts%n
         if (contacts%strength_ratio(c) <= 0.0_wp) cycle
         broken = broken + 1
         if (has_bond(contacts, laws, c)) iteration%broken = iteration%broken + 1
         call break_joint(contacts, laws, c)
      end do
   end subroutine break_bonds

   !> Set the multipliers of the augmented Lagrangian to the contact forces (Uzawa's iteration).
   !> Multipliers change only if the gap of a closed contact exceeds the penetration tolerance.
   subroutine update_multipliers(iteration, contacts, converged)
      type(open_close_type), intent(in) :: iteration  !< open–close iteration of the step
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step
      logical, intent(out) :: converged  !< no multiplier has changed
      integer :: c

      converged = .true.
      if (iteration%penetration_tolerance <= 0.0_wp) return
      converged = .not. any(abs(contacts%new_gap(:contacts%n)) > iteration%penetration_tolerance &
         .and. contacts%state(:contacts%n) /= contact_open .and. &
         .not. contacts%bonded(:contacts%n))
      if (converged) return
      do c = 1, contacts%n
         if (.not. contacts%bonded(c)) &
            contacts%multiplier(c) = max(0.0_wp, contacts%normal_force(c))
      end do
   end subroutine update_multipliers

   !> Adopt the states that follow from the laws, and count the changes.
   subroutine adopt_states(iteration, contacts, laws, changed)
      type(open_close_type), intent(inout) :: iteration  !< open–close iteration of the step
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(out) :: changed  !< number of contacts that change
      logical :: by_contact
      integer :: n, p

      n = contacts%n
      call renew_lines(contacts, laws, least_share*iteration%tolerance)
      changed = count(contacts%trial_state(:n) /= contacts%state(:n))
      by_contact = iteration%shortened .or. changed > many_changes*n
      if (n < parallel_from) then
         call adopt_range(iteration, contacts, laws, by_contact, 1, n)
         return
      end if
      !$omp parallel do schedule(static)
      do p = 1, pieces(n)
         call adopt_range(iteration, contacts, laws, by_contact, first_of(p, n), last_of(p, n))
      end do
   end subroutine adopt_states

   !> Adopt the states that follow from the laws in contacts first … last.
   pure subroutine adopt_range(iteration, contacts, laws, by_contact, first, last)
      type(open_close_type), intent(in) :: iteration  !< open–close iteration of the step
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step, evaluated
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      logical, intent(in) :: by_contact  !< the iteration overshoots, or is expected to
      integer, intent(in) :: first, last  !< first and last contact
      integer :: c

      do c = first, last
         call retain_stiffness(iteration, contacts, laws, by_contact, c)
         if (contacts%state(c) == contact_open .and. contacts%trial_state(c) /= contact_open) &
            contacts%close_count(c) = contacts%close_count(c) + 1
      end do
      call adopt_trial_states(contacts, first, last)
   end subroutine adopt_range

   !> Adopt the states and friction forces of the last evaluation in contacts first … last.
   pure subroutine adopt_trial_states(contacts, first, last)
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step
      integer, intent(in) :: first, last  !< first and last contact

      contacts%state(first:last) = contacts%trial_state(first:last)
      contacts%slide_force(first:last) = contacts%shear_force(first:last)
      if (contacts%with_net_slip) contacts%slide_force(first:last) = contacts%slider(first:last)
      if (contacts%with_laws) contacts%slide_force(first:last) = contacts%slide_force(first:last) &
         - contacts%tilt(1, first:last)*contacts%normal_force(first:last)
      contacts%slip_sign(first:last) = sign(1.0_wp, contacts%slide_force(first:last))
   end subroutine adopt_trial_states

   !> Retain a fraction of the spring that contact c loses in its next state.
   !>
   !> Only inertia resists motion in a contact without a spring, so the next solution would
   !> overshoot.  An opening contact retains a fraction of its spring for one iteration.  A sliding
   !> contact retains a fraction of the secant stiffness to its bound, which decreases in each
   !> iteration.
   pure subroutine retain_stiffness(iteration, contacts, laws, by_contact, c)
      type(open_close_type), intent(in) :: iteration  !< open–close iteration of the step
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step, evaluated
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      logical, intent(in) :: by_contact  !< the iteration overshoots, or is expected to
      integer, intent(in) :: c  !< number of the contact
      real(wp) :: fraction

      associate (state => contacts%trial_state(c), before => contacts%state(c))
         fraction = 0.0_wp
         if (by_contact .and. state == before) then
            fraction = retained_fraction*contacts%retained(c)
            if (state == contact_open .or. fraction < least_retained) fraction = 0.0_wp
         else if (by_contact .and. state == contact_slide) then
            fraction = retained_fraction*secant_fraction(contacts, laws, c)
         else if (by_contact .and. state == contact_open) then
            fraction = least_retained
         end if
         if (state == contact_slide) fraction = max(fraction, iteration%retained)
         contacts%retained(c) = fraction
         contacts%retained_at(c) = merge(contacts%slip(c), contacts%new_gap(c), &
            state == contact_slide)
      end associate
   end subroutine retain_stiffness

   !> Return the secant stiffness of a sliding contact over its shear stiffness, at most 1.
   pure real(wp) function secant_fraction(contacts, laws, c) result(fraction)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step, evaluated
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c  !< number of the contact
      real(wp) :: at(2)

      at = shear_stiffness_of(contacts, laws, c)*acting(contacts, laws, c, &
         [contacts%new_gap(c), contacts%stretch(c) + contacts%slip(c)])
      fraction = min(1.0_wp, abs(contacts%shear_force(c))/max(abs(at(2)), tiny(1.0_wp)))
   end function secant_fraction

end module dda_open_close
