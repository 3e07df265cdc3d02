! SPDX-License-Identifier: GPL-3.0-or-later
!> The open–close iteration on random systems: its solution obeys the contact law, and without
!> friction it is the one that trying all combinations of open and closed contacts finds.
module test_open_close
   use dda_kinds, only: wp, pi
   use dda_system, only: system_type
   use dda_compact_block, only: compact
   use dda_contact, only: contact_open, contact_slide, contact_stick, contacts_type, reserve
   use dda_contact_evaluation, only: evaluate_contacts
   use dda_contact_terms, only: contact_terms_type, update_contact_terms
   use dda_errors, only: error_convergence
   use dda_friction, only: laws_type
   use dda_lapack, only: dposv
   use dda_open_close, only: evaluate, iterate, most_bound_rounds, solve_contacts, open_close_type
   use dda_neighbours, only: neighbours_type
   use dda_rank_one, only: most_changes
   use dda_linear_solver, only: analyse, choose_solver, solver_type
   use dda_simulation, only: simulation_type
   use models, only: begin, contact_text, control_text, random, random_vector, relative_balance, run
   use systems, only: energy, flat, gap_row, gradient, linear_matrix, normal_force, pattern_of, &
      random_system, stiffness, unbalanced, unknowns
   use dda_text, only: to_text
   use testing, only: case, check, check_close, check_fails, check_no_error, error
   implicit none

   type(system_type) :: system
   type(contacts_type) :: contacts
   type(laws_type) :: laws

contains

   subroutine frictional()
      call with_friction(10.0_wp, 25)
      call with_friction(30.0_wp, 60)
   end subroutine frictional

   subroutine close_all(system, contacts, iteration)
      type(system_type), intent(inout) :: system
      type(contacts_type), intent(inout) :: contacts
      type(open_close_type), intent(inout) :: iteration
      type(solver_type) :: solver

      call choose_solver(solver, 'auto', error)
      call analyse(solver, system%matrix)
      iteration%weight = 10.0_wp
      iteration%relative_tolerance = 1.0e-12_wp
      call solve_contacts(iteration, system, solver, contacts, laws, error)
   end subroutine close_all

   !> Up to eight contacts, 2⁸ combinations.
   subroutine against_all_combinations()
      type(open_close_type) :: iteration
      real(wp) :: expected(unknowns)
      integer :: i, solutions, largest_count

      largest_count = 0
      do i = 1, 80
         call random_system(system, contacts, laws, 1 + modulo(i, 8), 0.0_wp)
         call try_all(expected, solutions)
         call check(solutions == 1, 'one combination solves it')
         call close_all(system, contacts, iteration)
         call check_no_error(error, 'converges')
         call check_close(flat(system%d), expected, 'd', relative=1.0e-9_wp)
         largest_count = max(largest_count, iteration%iterations)
      end do
      call check(largest_count <= 8, 'in no more iterations than contacts')
   end subroutine against_all_combinations

   !> The combination whose solution penetrates exactly at its closed contacts.
   subroutine try_all(d, solutions)
      real(wp), intent(out) :: d(unknowns)
      integer, intent(out) :: solutions
      real(wp) :: k(unknowns, unknowns), x(unknowns), row(unknowns)
      integer :: n_closed, c, info
      logical :: is_solution

      solutions = 0
      do n_closed = 0, 2**contacts%n - 1
         k = linear_matrix(system)
         x = flat(system%load)
         do c = 1, contacts%n
            if (.not. btest(n_closed, c - 1)) cycle
            row = gap_row(contacts, c)
            k = k + stiffness*spread(row, 2, unknowns)*spread(row, 1, unknowns)
            x = x - stiffness*contacts%gap(c)*row
         end do
         call dposv('L', unknowns, 1, k, unknowns, x, unknowns, info)
         is_solution = info == 0
         do c = 1, contacts%n
            is_solution = is_solution .and. ((contacts%gap(c) + dot_product(gap_row(contacts, &
               c), x) < 0.0_wp) .eqv. btest(n_closed, c - 1))
         end do
         if (.not. is_solution) cycle
         solutions = solutions + 1
         d = x
      end do
   end subroutine try_all

   !> Without friction the solution does not depend on the initial states.
   subroutine from_any_first_states()
      type(system_type) :: system, second_system
      type(contacts_type) :: contacts, second_contacts
      type(open_close_type) :: iteration
      integer :: i, c

      do i = 1, 60
         call random_system(system, contacts, laws, 20, 0.0_wp)
         second_system = system
         second_contacts = contacts
         do c = 1, 20
            second_contacts%state(c) = modulo(c*i, 3)
         end do
         call close_all(system, contacts, iteration)
         call check_no_error(error, 'converges')
         call close_all(second_system, second_contacts, iteration)
         call check_no_error(error, 'converges from other states')
         call check_close(second_system%d, system%d, 'd', relative=1.0e-9_wp)
      end do
   end subroutine from_any_first_states

   !> With frozen bounds the energy decreases in each iteration, from any start, until its gradient
   !> is zero.
   subroutine frozen_bounds_descend()
      integer :: i

      do i = 1, 1000
         call descend_from(10.0_wp**random(-3.0_wp, 0.0_wp), 1 + modulo(i, 12))
      end do
   end subroutine frozen_bounds_descend

   !> The energy after one iteration, two, … of a random system.
   subroutine descend_from(distance, count)
      real(wp), intent(in) :: distance    !< of the start
      integer, intent(in) :: count   !< contacts
      type(system_type) :: start, system
      type(contacts_type) :: first, contacts
      type(open_close_type) :: iteration
      type(solver_type) :: solver
      real(wp) :: former_energy, new_energy
      logical :: converged
      integer :: c, limit

      call random_system(start, first, laws, count, 60.0_wp)
      start%d = distance*reshape(random_vector(unknowns), [6, 2])
      first%frozen_bound = [(max(0.0_wp, random(-5.0_wp, 20.0_wp)), c=1, count)]
      first%state(:count) = [(modulo(c, 3), c=1, count)]
      iteration%weight = 10.0_wp
      iteration%relative_tolerance = 1.0e-12_wp
      former_energy = energy(start, first, start%d, first%frozen_bound)
      do limit = 1, 100
         system = start
         contacts = first
         iteration%max_iterations = limit
         call choose_solver(solver, 'auto', error)
         call analyse(solver, system%matrix)
         call iterate(iteration, system, solver, contacts, laws, converged, error)
         call check_no_error(error, 'iterates')
         new_energy = energy(system, contacts, system%d, first%frozen_bound)
         call check(new_energy <= former_energy + 1.0e-11_wp*abs(former_energy), &
            'the energy does not rise')
         if (converged) exit
         former_energy = new_energy
      end do
      call check(converged, 'converges')
      call check(maxval(abs(gradient(system, contacts, system%d, &
         first%frozen_bound))) <= 1.0e-8_wp, &
         'balance at its end')
   end subroutine descend_from

   !> A difference of 1e-14 of a force is tolerated if the force was there at the start of the step,
   !> and not if an iterate far off exerts it.
   subroutine tolerance_of_the_step()
      type(open_close_type) :: iteration
      integer :: i, with_tolerance

      do i = 1, 20
         do with_tolerance = 0, 1
            call random_system(system, contacts, laws, 1, 0.0_wp)
            call close_all(system, contacts, iteration)
            call check_no_error(error, 'converges')
            contacts%spring(:, 1) = 0.0_wp
            system%d = 0.0_wp
            if (with_tolerance == 1) contacts%gap(1) = -1.0e13_wp
            if (with_tolerance == 0) system%d = -1.0e13_wp*reshape(gap_row(contacts, 1), [6, 2])
            call evaluate(iteration, system, contacts, laws)
            contacts%free_force(:, 1) = [(1.0_wp + 1.0e-14_wp)*contacts%normal_force(1), 0.0_wp]
            call evaluate(iteration, system, contacts, laws)
            call check((iteration%residual <= iteration%tolerance) .eqv. with_tolerance == 1, &
               'tolerated')
         end do
      end do
   end subroutine tolerance_of_the_step

   !> The shorter ways for simple contacts yield what the general ones do with multipliers of zero.
   subroutine simple_contacts()
      type(contact_terms_type) :: terms, general_terms
      type(contacts_type) :: general
      real(wp) :: d(6, 2), largest(2), residual(2)
      real(wp), parameter :: rounding = 1.0e-14_wp
      integer :: i, c, bonds

      bonds = 0
      do i = 1, 40
         call random_system(system, contacts, laws, 8, 30.0_wp)
         laws%cohesion = 0.3_wp
         laws%tension = 0.2_wp
         do c = 1, contacts%n
            call assume_state(modulo(c + i, 3), c)
         end do
         bonds = bonds + count(contacts%bonded(:contacts%n))
         general = contacts
         general%with_multipliers = .true.
         allocate (general%multiplier(size(contacts%gap)), source=0.0_wp)
         terms%dirty = [0, 0]
         general_terms%dirty = [0, 0]
         call update_contact_terms(terms, contacts, laws)
         call update_contact_terms(general_terms, general, laws)
         d = 0.1_wp*reshape(random_vector(12), [6, 2])
         largest = 0.0_wp
         call evaluate_contacts(contacts, laws, d, largest(1), residual(1))
         call evaluate_contacts(general, laws, d, largest(2), residual(2))
         associate (n => contacts%n)
            call check_close(contacts%spring(:, :n), general%spring(:, :n), 'springs', rounding)
            call check_close(contacts%free_force(:, :n), general%free_force(:, :n), &
               'forces at d = 0', rounding)
            call check_close(contacts%normal_force(:n), general%normal_force(:n), &
               'normal forces', rounding)
            call check_close(contacts%shear_force(:n), general%shear_force(:n), &
               'shear forces', rounding)
            call check_close(contacts%strength_ratio(:n), general%strength_ratio(:n), &
               'overloads', rounding)
            call check(all(contacts%trial_state(:n) == general%trial_state(:n)), 'states')
         end associate
         call check_close([largest(1), residual(1)], [largest(2), residual(2)], &
            'largest values', rounding)
      end do
      call check(bonds > 20, 'some are bonded')
   end subroutine simple_contacts

   !> After two blocks have moved, evaluating their contacts gives what evaluating all gives, also
   !> for the tolerance and the worst contact.
   subroutine contacts_of_moved_blocks()
      integer, parameter :: systems = 5, each = 6, n = systems*each
      type(system_type) :: full_system, system
      type(contacts_type) :: partly, wholly, contacts
      type(open_close_type) :: part, whole
      integer :: i, k, moved, elsewhere

      call systems_beside(full_system, systems, 2*systems)
      call reserve(partly, n)
      do i = 1, systems
         do
            call random_system(system, contacts, laws, each, 30.0_wp)
            if (size(system%linear%column) == 0) exit
         end do
         call put(system, contacts, 2*i - 2, full_system, partly)
      end do
      call assume_nothing(partly)
      elsewhere = 0
      do i = 1, 40
         moved = 1 + modulo(i, systems)
         full_system%d = reshape(random_vector(12*systems), [6, 2*systems])
         call evaluate(part, full_system, partly, laws)
         full_system%d(:, 2*moved - 1:2*moved) = reshape(random_vector(12), [6, 2])
         wholly = partly
         whole = part
         call evaluate(part, full_system, partly, laws, [(k, k=each*(moved - 1) + 1, each*moved)])
         call evaluate(whole, full_system, wholly, laws)
         call check_close([part%residual, part%tolerance], [whole%residual, whole%tolerance], &
            'residual and tolerance', relative=1.0e-14_wp)
         call check(part%unconverged == whole%unconverged, 'worst contact')
         call check_close(partly%force_residual(:n), wholly%force_residual(:n), 'differences', &
            relative=1.0e-14_wp)
         call check(all(partly%trial_state(:n) == wholly%trial_state(:n)), 'states')
         if ((whole%unconverged - 1)/each + 1 /= moved) elsewhere = elsewhere + 1
      end do
      call check(elsewhere > 10 .and. elsewhere < 40, 'the worst contact may not have moved')
   end subroutine contacts_of_moved_blocks

   !> Clear what an iteration has assumed on contacts.
   subroutine assume_nothing(contacts)
      type(contacts_type), intent(inout) :: contacts

      contacts%bonded = .false.
      contacts%slide_force = 0.0_wp
      contacts%slip_sign = 1.0_wp
      contacts%close_count = 0
      contacts%retained = 0.0_wp
      contacts%retained_at = 0.0_wp
      contacts%spring = 0.0_wp
      contacts%free_force = 0.0_wp
   end subroutine assume_nothing

   !> Let contact c begin an iteration in a state; every second sticking contact is bonded.
   subroutine assume_state(state, c)
      integer, intent(in) :: state, c

      contacts%state(c) = state
      contacts%bonded(c) = state == contact_stick .and. modulo(c, 2) == 0
      contacts%bond_length(c) = random(0.1_wp, 1.0_wp)
      contacts%slide_force(c) = random(-1.0_wp, 1.0_wp)
      contacts%slip_sign(c) = sign(1.0_wp, contacts%slide_force(c))
      contacts%close_count(c) = 100*modulo(c, 2)
      contacts%retained(c) = 0.0_wp
      contacts%retained_at(c) = 0.0_wp
      contacts%spring(:, c) = 0.0_wp
      contacts%free_force(:, c) = 0.0_wp
   end subroutine assume_state

   !> Closed contacts that would pull at the gap of the solution without them stay closed where that
   !> force is half the tolerance, once they are more than a low-rank update takes; they open where
   !> it is twice as large.
   subroutine tolerated_tension()
      integer :: opened

      call pull_contacts(most_changes + 1, 0.5_wp, opened)
      call check(opened == 0, 'many stay closed within the tolerance')
      call pull_contacts(most_changes, 0.5_wp, opened)
      call check(opened == most_changes, 'no more than an update takes all open')
      call pull_contacts(most_changes + 1, 2.0_wp, opened)
      call check(opened == most_changes + 1, 'all open beyond the tolerance')
   end subroutine tolerated_tension

   !> Solve systems of one closed contact each beside each other, which ends at a tension.
   subroutine pull_contacts(systems, tension, opened)
      integer, intent(in) :: systems
      real(wp), intent(in) :: tension    !< tension, of the tolerance
      integer, intent(out) :: opened   !< contacts
      type(system_type) :: full_system, system
      type(contacts_type) :: all_contacts, contacts
      type(open_close_type) :: iteration
      real(wp) :: k(unknowns, unknowns), x(unknowns, 2), row(unknowns)
      integer :: i, info

      call systems_beside(full_system, systems, 2*systems)
      call reserve(all_contacts, systems)
      iteration%noise = 1.0e-3_wp
      do i = 1, systems
         do
            call random_system(system, contacts, laws, 1, 0.0_wp)
            if (size(system%linear%column) == 0) exit
         end do
         call leave_out_slip(contacts%gradient_v(:, 1))
         call leave_out_slip(contacts%gradient_e(:, 1))
         row = gap_row(contacts, 1)
         k = linear_matrix(system)
         x = reshape([flat(system%load), row], [unknowns, 2])
         call dposv('L', unknowns, 2, k, unknowns, x, unknowns, info)
         contacts%state(1) = contact_stick
         contacts%stretch(1) = 0.0_wp
         contacts%gap(1) = tension*iteration%noise*(1.0_wp/stiffness + dot_product(row, x(:, 2))) &
            - dot_product(row, x(:, 1))
         call put(system, contacts, 2*i - 2, full_system, all_contacts)
      end do
      call close_all(full_system, all_contacts, iteration)
      call check_no_error(error, 'converges')
      opened = count(all_contacts%trial_state(:systems) == contact_open)
   end subroutine pull_contacts

   !> Only rotation and equal axial strains of a block move a contact, and without slip.
   subroutine leave_out_slip(rows)
      real(wp), intent(inout) :: rows(6, 2)

      rows([1, 2, 6], 1) = 0.0_wp
      rows(5, 1) = rows(4, 1)
      rows(:, 2) = 0.0_wp
   end subroutine leave_out_slip

   !> The pattern of systems of two blocks beside each other, and of more blocks without contacts.
   subroutine systems_beside(full_system, systems, blocks)
      type(system_type), intent(out) :: full_system
      integer, intent(in) :: systems, blocks
      type(neighbours_type) :: neighbours
      real(wp) :: unit(6, 6)
      integer :: i

      neighbours%n_pairs = systems
      neighbours%pair = reshape([(i, i=1, 2*systems)], [2, systems])
      call pattern_of(full_system, blocks, neighbours)
      unit = 0.0_wp
      do i = 1, 6
         unit(i, i) = 1.0_wp
      end do
      full_system%constant = spread(compact(unit), 2, blocks)
   end subroutine systems_beside

   !> Independent systems, each a region, have the solution of each system alone.  The complete
   !> system, mostly at rest, needs no more iterations than to establish this.
   subroutine independent_regions()
      integer, parameter :: systems = 60, idle = 200, each = 40
      type(system_type) :: full_system, system
      type(contacts_type) :: all_contacts, contacts
      type(open_close_type) :: iteration
      real(wp) :: expected(6, 2*systems + idle)
      integer :: i, max_iterations_alone

      call systems_beside(full_system, systems, 2*systems + idle)
      full_system%load = 1.0_wp
      expected = 1.0_wp
      call reserve(all_contacts, systems*each)
      max_iterations_alone = 0
      do i = 1, systems
         do
            call random_system(system, contacts, laws, each, 0.0_wp)
            if (size(system%linear%column) == 0) exit
         end do
         call put(system, contacts, 2*i - 2, full_system, all_contacts)
         call close_all(system, contacts, iteration)
         call check_no_error(error, 'one converges')
         max_iterations_alone = max(max_iterations_alone, iteration%iterations)
         expected(:, 2*i - 1:2*i) = system%d
      end do
      call close_all(full_system, all_contacts, iteration)
      call check_no_error(error, 'all converge')
      call check_close(full_system%d, expected, 'd', relative=1.0e-9_wp)
      call check(iteration%iterations <= 3 .and. max_iterations_alone > 6, &
         'in few iterations of the whole')
   end subroutine independent_regions

   !> Insert a system of two blocks after `offset` blocks.
   subroutine put(system, contacts, offset, full_system, all_contacts)
      type(system_type), intent(in) :: system
      type(contacts_type), intent(in) :: contacts
      integer, intent(in) :: offset
      type(system_type), intent(inout) :: full_system
      type(contacts_type), intent(inout) :: all_contacts
      integer :: first, last

      full_system%has_terms(offset + 1:offset + 2) = .true.
      full_system%linear%diagonal(:, :, offset + 1:offset + 2) = system%linear%diagonal
      full_system%load(:, offset + 1:offset + 2) = system%load
      first = all_contacts%n + 1
      last = all_contacts%n + contacts%n
      all_contacts%n = last
      associate (n => contacts%n)
         all_contacts%block_v(first:last) = contacts%block_v(:n) + offset
         all_contacts%block_e(first:last) = contacts%block_e(:n) + offset
         all_contacts%pair(first:last) = offset/2 + 1
         all_contacts%joint(first:last) = contacts%joint(:n)
         all_contacts%state(first:last) = contacts%state(:n)
         all_contacts%gap(first:last) = contacts%gap(:n)
         all_contacts%stretch(first:last) = contacts%stretch(:n)
         all_contacts%normal(:, first:last) = contacts%normal(:, :n)
         all_contacts%gradient_v(:, first:last) = contacts%gradient_v(:, :n)
         all_contacts%gradient_e(:, first:last) = contacts%gradient_e(:, :n)
      end associate
   end subroutine put

   !> With friction, the forces that the law answers to d are in balance with it.
   subroutine with_friction(angle, max_allowed)
      real(wp), intent(in) :: angle
      integer, intent(in) :: max_allowed
      type(open_close_type) :: iteration
      integer :: i, c, failed, largest_count, states(0:2)

      call case('with friction')
      failed = 0
      largest_count = 0
      states = 0
      do i = 1, 200
         call random_system(system, contacts, laws, 1 + modulo(i, 10), angle)
         call close_all(system, contacts, iteration)
         if (allocated(error)) then
            failed = failed + 1
            cycle
         end if
         largest_count = max(largest_count, iteration%iterations)
         do c = 1, contacts%n
            states(contacts%state(c)) = states(contacts%state(c)) + 1
         end do
         call check_balance(system, contacts, tan(angle*pi/180.0_wp))
      end do
      call check(failed == 0, 'all converge')
      call check(largest_count <= max_allowed, 'in few iterations')
      call check(all(states([contact_open, contact_slide, contact_stick]) > 20), 'all states occur')
   end subroutine with_friction

   !> Friction so high that some steps do not converge: frozen bounds find some of them,
   !> with forces in balance, and are gone after the others.
   subroutine locking_friction()
      type(system_type) :: system, repeated
      type(contacts_type) :: contacts, contacts_again
      type(open_close_type) :: iteration
      real(wp), parameter :: angle = 81.0_wp
      integer :: i, locked, n_closed

      locked = 0
      n_closed = 0
      do i = 1, 1500
         call random_system(system, contacts, laws, 2 + modulo(i, 19), angle)
         repeated = system
         contacts_again = contacts
         iteration%rounds = 0
         call close_all(system, contacts, iteration)
         if (.not. allocated(error)) cycle
         locked = locked + 1
         iteration%rounds = most_bound_rounds
         call close_all(repeated, contacts_again, iteration)
         call check(.not. allocated(contacts_again%frozen_bound), 'bounds are released')
         if (allocated(error)) cycle
         n_closed = n_closed + 1
         call check_balance(repeated, contacts_again, tan(angle*pi/180.0_wp))
      end do
      call check(locked > 0, 'some do not converge')
      call check(4*n_closed > locked, 'a share of them does with bounds from outside')
   end subroutine locking_friction

   !> Falling masonry in the midpoint rule, which shakes: steps close in which bricks lock.
   subroutine a_wall_that_locks()
      type(simulation_type) :: simulation

      call settle(1.0e-2_wp, 'friction_angle = 35', 10, 19, simulation)
      call check(simulation%step == 20, 'every step closes')
      call check(relative_balance(simulation%energy) < 1.0e-6_wp, 'audit')
      call check(simulation%counters%most_iterations < 400, &
         'no step goes round to the last iteration')
   end subroutine a_wall_that_locks

   !> If steps are short, each contact whose slip the full step reverses sticks; else this takes
   !> 489 iterations.
   subroutine a_wall_that_slides()
      type(simulation_type) :: simulation

      call settle(5.0e-3_wp, 'friction_angle = 15', 6, 9, simulation)
      call check(simulation%step == 20, 'every step closes')
      call check(simulation%counters%iterations < 430, 'in few iterations')
   end subroutine a_wall_that_slides

   !> Regions are iterated for joints with a law, too: without them, this takes 269 iterations.
   subroutine a_wall_with_regions()
      type(simulation_type) :: simulation

      call settle(5.0e-3_wp, 'friction_angle = 35 normal_stiffness_per_area = 1e11'// &
         ' shear_stiffness_per_area = 4e10', 22, 24, simulation)
      call check(simulation%step == 20, 'every step converges')
      call check(simulation%counters%iterations < 200, 'in few iterations')
      call settle(1.0e-3_wp, "law = 'barton_bandis' friction_angle = 30 jrc = 10 jcs = 5e7"// &
         ' normal_stiffness_per_area = 1e11 max_closure = 5e-4', 22, 24, simulation)
      call check(simulation%step == 20, 'every step converges with memory')
      call settle(1.0e-3_wp, "law = 'mohr_coulomb' friction_angle = 35 dilation_angle = 5"// &
         ' dilation_slip = 5e-3 normal_stiffness_per_area = 1e11'// &
         ' shear_stiffness_per_area = 4e10', 22, 24, simulation)
      call check(simulation%step == 20, 'every step converges with dilation')
   end subroutine a_wall_with_regions

   !> Twenty steps of a wall on which gravity acts suddenly.
   subroutine settle(time_step, joint, bricks, courses, simulation)
      real(wp), intent(in) :: time_step        !< s
      character(len=*), intent(in) :: joint    !< variables of the joints
      integer, intent(in) :: bricks, courses   !< numbers of them
      type(simulation_type), intent(out) :: simulation
      character(len=:), allocatable :: right_x
      integer :: i

      right_x = to_text(real(max(bricks, 10) + 1, wp))
      call begin(simulation, control_text(time_step, 20, "integration = 'midpoint'"// &
         ' gravity = 0.0 -9.81')//contact_text(1.5e12_wp, '')// &
         " &material name = 'base' density = 2500.0 young_modulus = 1.0e15 poisson_ratio = 0.0 /"//&
         " &material name = 'stone' density = 2500.0 young_modulus = 5.0e9 poisson_ratio = 0.2 /"//&
         " &joint name = 'dry' "//joint//' /'// &
         " &block name = 'base' material = 'base' joint = '' vertices = -1.0 -1.0 "//right_x// &
         ' -1.0 '//right_x//' 0.0 -1.0 0.0 /'// &
         " &wall name = 'brick' material = 'stone' left = 0.0 bottom = 0.0 brick_length = 1.0"// &
         ' brick_height = 0.5 bricks = '//to_text(bricks)//' courses = '//to_text(courses)//' /'// &
         ' &fixed_point x = -1.0 y = -1.0 / &fixed_point x = '//right_x//' y = -1.0 /'// &
         ' &fixed_point x = '//right_x//' y = 0.0 / &fixed_point x = -1.0 y = 0.0 /')
      do i = 1, 20
         call run(simulation, 1)
      end do
   end subroutine settle

   subroutine check_balance(system, contacts, mu)
      type(system_type), intent(in) :: system
      type(contacts_type), intent(in) :: contacts
      real(wp), intent(in) :: mu
      real(wp) :: largest
      integer :: c

      largest = maxval(abs(system%load))
      do c = 1, contacts%n
         largest = max(largest, normal_force(system, contacts, c))
      end do
      call check_close(unbalanced(system, contacts, mu), spread(0.0_wp, 1, unknowns), &
         'forces in balance', absolute=1.0e-9_wp*largest)
   end subroutine check_balance

   subroutine no_contacts()
      type(open_close_type) :: iteration

      call random_system(system, contacts, laws, 1, 0.0_wp)
      contacts%n = 0
      call close_all(system, contacts, iteration)
      call check_no_error(error, 'converges')
      call check(iteration%iterations == 1, 'at once')
      call check_close(matmul(linear_matrix(system), flat(system%d)), flat(system%load), &
         'K d = f', relative=1.0e-12_wp)
   end subroutine no_contacts

   subroutine too_few_iterations()
      type(open_close_type) :: iteration

      call random_system(system, contacts, laws, 20, 20.0_wp)
      contacts%gap(:20) = -abs(contacts%gap(:20))
      iteration%max_iterations = 1
      call close_all(system, contacts, iteration)
      call check_fails(error, 'does not converge')
      if (allocated(error)) call check(error%kind == error_convergence, 'its kind')
      call check(iteration%unconverged > 0, 'the worst contact is known')
   end subroutine too_few_iterations

end module test_open_close
