! SPDX-License-Identifier: GPL-3.0-or-later
!> Relaxed static steps on random systems: their final states and unbalanced forces.
module test_static_relaxation
   use dda_kinds, only: wp, pi
   use dda_contact, only: contact_stick, contacts_type
   use dda_friction, only: laws_type
   use dda_linear_solver, only: analyse, choose_solver, solver_type
   use dda_open_close, only: add_counts, begin_iteration, solve_contacts, counts_of, &
      open_close_type
   use dda_static_relaxation, only: solve_statics, relax
   use dda_system, only: system_type
   use systems, only: flat, linear_matrix, random_system, shear_stiffness, unbalanced, unknowns
   use testing, only: case, check, check_close, check_no_error, error
   implicit none

   integer, parameter :: n_contacts = 20                    !< contacts
   integer, parameter :: most_steps = 40
   type(system_type) :: system
   type(contacts_type) :: contacts
   type(laws_type) :: laws
   type(solver_type) :: solver
   type(open_close_type) :: iteration

contains

   subroutine frictional()
      call with_friction(10.0_wp)
      call with_friction(35.0_wp)
   end subroutine frictional

   !> An iteration that the random systems are to be solved by.
   subroutine prepare(iteration, solver, system)
      type(open_close_type), intent(out) :: iteration
      type(solver_type), intent(out) :: solver
      type(system_type), intent(in) :: system

      iteration%weight = 10.0_wp
      iteration%relative_tolerance = 1.0e-12_wp
      call choose_solver(solver, 'auto', error)
      call analyse(solver, system%matrix)
   end subroutine prepare

   !> Accept the step: the next step begins at its end.
   subroutine accept(system, contacts)
      type(system_type), intent(inout) :: system
      type(contacts_type), intent(inout) :: contacts
      integer :: n

      n = contacts%n
      system%load = system%load - reshape(matmul(linear_matrix(system), flat(system%d)), &
         shape(system%load))
      contacts%gap(:n) = contacts%new_gap(:n)
      contacts%stretch(:n) = contacts%shear_force(:n)/shear_stiffness
   end subroutine accept

   !> Without friction, the steps end at the solution of the open–close iteration.
   subroutine without_friction()
      type(system_type) :: system, relaxed
      type(contacts_type) :: contacts, relaxed_contacts
      real(wp) :: total(unknowns)
      integer :: i, step, largest_count

      largest_count = 0
      do i = 1, 40
         call random_system(system, contacts, laws, n_contacts, 0.0_wp)
         relaxed = system
         relaxed_contacts = contacts
         call prepare(iteration, solver, system)
         call solve_contacts(iteration, system, solver, contacts, laws, error)
         call check_no_error(error, 'the states converge')
         call prepare(iteration, solver, relaxed)
         total = 0.0_wp
         do step = 1, most_steps
            call relax(iteration, relaxed, solver, relaxed_contacts, laws, error)
            call check_no_error(error, 'relaxes')
            total = total + flat(relaxed%d)
            if (iteration%converged) exit
            call accept(relaxed, relaxed_contacts)
         end do
         largest_count = max(largest_count, step)
         call check_close(total, flat(system%d), 'd', relative=1.0e-6_wp)
         call check(all(relaxed_contacts%state(:n_contacts) == contacts%trial_state(:n_contacts)), &
            'same states')
      end do
      call check(largest_count < most_steps, 'all close')
   end subroutine without_friction

   !> The steps end in balance by the law; earlier unbalanced forces do the work that the iteration
   !> reports.
   subroutine with_friction(angle)
      real(wp), intent(in) :: angle  !< degrees
      real(wp) :: residual(unknowns), mu
      integer :: i, step, open_steps, failed

      call case('with friction')
      mu = tan(angle*pi/180.0_wp)
      open_steps = 0
      failed = 0
      do i = 1, 100
         call random_system(system, contacts, laws, n_contacts, angle)
         call prepare(iteration, solver, system)
         do step = 1, most_steps
            call relax(iteration, system, solver, contacts, laws, error)
            call check_no_error(error, 'relaxes')
            residual = unbalanced(system, contacts, mu)
            call check_close(iteration%unbalanced_work, dot_product(residual, flat(system%d)), &
               'work of unbalanced forces', absolute=1.0e-12_wp, relative=1.0e-6_wp)
            if (iteration%converged) exit
            open_steps = open_steps + 1
            call accept(system, contacts)
         end do
         if (.not. iteration%converged) then
            failed = failed + 1
            cycle
         end if
         call check_close(residual, 0.0_wp*residual, 'forces in balance', absolute=1.0e-6_wp)
      end do
      call check(open_steps > 10, 'some steps do not converge')
      call check(failed == 0, 'all end')
   end subroutine with_friction

   !> Bonds are checked after the contacts converge; broken bonds transmit no force.
   subroutine overloaded_bonds()
      integer :: i, step, n_broken, n_bonded

      n_broken = 0
      n_bonded = 0
      do i = 1, 20
         call random_system(system, contacts, laws, n_contacts, 10.0_wp)
         laws%cohesion = 5.0_wp
         laws%tension = 5.0_wp
         contacts%bonded(:n_contacts) = .true.
         contacts%bond_length(:n_contacts) = 1.0_wp
         contacts%state(:n_contacts) = contact_stick
         call prepare(iteration, solver, system)
         do step = 1, most_steps
            call relax(iteration, system, solver, contacts, laws, error)
            call check_no_error(error, 'relaxes')
            n_broken = n_broken + iteration%broken
            call check(all(contacts%bonded(:n_contacts) .or. &
               contacts%normal_force(:n_contacts) >= 0.0_wp), 'a broken one holds no tension')
            if (iteration%converged) exit
            call accept(system, contacts)
         end do
         call check(iteration%converged, 'ends')
         n_bonded = n_bonded + count(contacts%bonded(:n_contacts))
         call check(all(contacts%normal_force(:n_contacts) >= -5.0_wp*(1 + 1.0e-9_wp)), &
            'no bond holds more than its strength')
      end do
      call check(n_broken > 20 .and. n_bonded > 20, 'some break, some hold')
   end subroutine overloaded_bonds

   !> A static step of many changes counts the iteration before it is relaxed, and begins again.
   subroutine all_iterations_of_a_static_step_count()
      type(system_type) :: system, repeated
      type(contacts_type) :: contacts, repeated_contacts
      type(open_close_type) :: iteration, relaxed
      integer :: before(3)
      integer, parameter :: high_limit = 10000, low_limit = 2

      call random_system(system, contacts, laws, high_limit, 10.0_wp)
      repeated = system
      repeated_contacts = contacts
      call prepare(iteration, solver, system)
      call solve_statics(iteration, system, solver, contacts, laws, error)
      call check_no_error(error, 'relaxes')
      call prepare(relaxed, solver, repeated)
      call relax(relaxed, repeated, solver, repeated_contacts, laws, error)
      call check_no_error(error, 'relaxes')
      call check(iteration%iterations == 1 + relaxed%iterations, 'states tried and relaxed')
      call check(iteration%changes > relaxed%changes, 'changes before it')
      call check_close(system%d, repeated%d, 'it begins as if nothing had been tried', &
         relative=1.0e-9_wp)
      iteration%broken = low_limit
      before = counts_of(iteration)
      call begin_iteration(iteration, contacts)
      call check(all(counts_of(iteration) == 0), 'begun anew')
      call add_counts(iteration, before)
      call check(all(counts_of(iteration) == before), 'iterations, changes and broken bonds')
   end subroutine all_iterations_of_a_static_step_count

end module test_static_relaxation
