! SPDX-License-Identifier: GPL-3.0-or-later
!> The contacts of a static step, where most of them change their states.
!>
!> In statics inertia hardly holds a block whose contacts all slide, so that the open–close
!> iteration overshoots where it finds such a block, and tries states one after the other.  The
!> central path of `dda_interior_point` avoids that; at its end the forces are those of the law.
module dda_static_path
   use dda_kinds, only: wp
   use dda_contact, only: contacts_type, contact_stick
   use dda_contact_evaluation, only: measure_contacts
   use dda_errors, only: error_type, error_convergence, error_interrupted, fail
   use dda_friction, only: laws_type
   use dda_interior_point, only: interior_type, begin_interior, set_base_point, set_targets, &
      correct_targets, set_bound_steps, assume_interior, find_step, take_step, mean_product
   use dda_interrupts, only: stop_requested
   use dda_linear_solver, only: solver_type, solve
   use dda_open_close, only: open_close_type, add_counts, begin_iteration, check_strength, &
      close_contacts, counts_of, evaluate, iterate, solve_assumed, take_states
   use dda_system, only: system_type
   implicit none
   private
   public :: close_static, follow_path

   integer, parameter :: few_iterations = 40     !< after which the path is tried
   integer, parameter :: many_changes = 2000     !< of the first iteration: the path at once
   integer, parameter :: most_iterations = 200   !< along the path
   integer, parameter :: most_corrections = 2    !< of a Newton step (Gondzio)
   real(wp), parameter :: accuracy = 1.0e-6_wp   !< of the first residual, of solves along the path
   real(wp), parameter :: long_enough = 0.95_wp  !< step length that needs no correction
   real(wp), parameter :: lengthening = 0.2_wp   !< of the step that a correction seeks
   real(wp), parameter :: least_fraction = 0.9_wp !< of the step length to the boundary
   real(wp), parameter :: last_radius = 0.1_wp   !< of the tolerance
   real(wp), parameter :: divergence_limit = 1.0e3_wp  !< of the radius, in first ones
   integer, parameter :: centring_power = 3      !< of the products that the predictor leaves

contains

   !> Iterate until every contact exerts what was assumed of it: by states, and along the path where
   !> many change or they do not settle soon.
   subroutine close_static(iteration, system, solver, contacts, laws, error)
      type(open_close_type), intent(inout) :: iteration  !< of the step
      type(system_type), intent(inout) :: system  !< equations of the step
      type(solver_type), intent(inout) :: solver  !< linear solver
      type(contacts_type), intent(inout) :: contacts  !< this step's list
      type(laws_type), intent(in) :: laws  !< plain, not damped
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      logical :: closed, many
      integer :: most, before(3)

      most = iteration%max_iterations
      iteration%max_iterations = min(most, few_iterations)
      iteration%most_changes = many_changes
      call iterate(iteration, system, solver, contacts, laws, closed, error)
      many = iteration%iterations == 1
      iteration%max_iterations = most
      iteration%most_changes = huge(1)
      do while (.not. (closed .or. allocated(error)))
         before = counts_of(iteration)
         call follow_path(iteration, system, solver, contacts, laws, closed, error)
         call add_counts(iteration, before)
         if (.not. closed) exit
         call check_strength(iteration, contacts, laws, closed)
      end do
      if (closed .or. allocated(error)) return
      if (many) then
         call fail(error, error_convergence, 'the path of the static step does not converge')
      else
         before = counts_of(iteration)
         call close_contacts(iteration, system, solver, contacts, laws, error)
         call add_counts(iteration, before)
      end if
   end subroutine close_static

   !> Follow the path from the radius of a block's weight to the law.
   subroutine follow_path(iteration, system, solver, contacts, laws, closed, error)
      type(open_close_type), intent(inout) :: iteration  !< of the step
      type(system_type), intent(inout) :: system  !< equations of the step
      type(solver_type), intent(inout) :: solver  !< linear solver
      type(contacts_type), intent(inout) :: contacts  !< this step's list
      type(laws_type), intent(in) :: laws  !< plain, not damped
      logical, intent(out) :: closed  !< every contact exerts what was assumed of it
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      type(interior_type) :: points
      real(wp) :: radius, mean, length, start(6, size(system%d, 2))
      integer :: i

      closed = .false.
      radius = iteration%weight
      if (.not. radius > 0.0_wp) radius = max(maxval(abs(system%load)), iteration%tolerance)
      call begin_path(iteration, system, contacts, laws, radius, points)
      do i = 1, most_iterations
         if (stop_requested()) call fail(error, error_interrupted, 'interrupted')
         if (allocated(error)) exit
         iteration%iterations = i
         iteration%reduction = accuracy
         start = system%d
         mean = mean_product(points, 0.0_wp)
         if (.not. mean < (divergence_limit*radius)**2) exit
         call find_next_step(iteration, system, solver, contacts, laws, points, length, error)
         if (allocated(error)) exit
         length = max(least_fraction, 1.0_wp - sqrt(mean)/radius)*length
         call take_step(points, length)
         system%d = start + length*(system%d - start)
         call evaluate(iteration, system%d, contacts, laws)
         if (iteration%residual <= iteration%tolerance) &
            call finish_path(iteration, system, solver, contacts, laws, closed, error)
         if (closed .or. allocated(error)) exit
      end do
      deallocate (contacts%imposed_spring, contacts%imposed_force)
      if (.not. closed) then
         system%d = 0.0_wp
         call evaluate(iteration, system%d, contacts, laws)
      end if
      call take_states(contacts, 1, contacts%n)
   end subroutine follow_path

   !> Begin the path at d = 0.
   subroutine begin_path(iteration, system, contacts, laws, radius, points)
      type(open_close_type), intent(inout) :: iteration  !< of the step
      type(system_type), intent(inout) :: system  !< equations of the step
      type(contacts_type), intent(inout) :: contacts  !< this step's list
      type(laws_type), intent(in) :: laws  !< plain, not damped
      real(wp), intent(in) :: radius  !< to begin with, N/m
      type(interior_type), intent(out) :: points  !< of the contacts

      call begin_iteration(iteration, contacts)
      system%d = 0.0_wp
      call measure_contacts(contacts, system%d)
      call begin_interior(points, contacts, laws, radius)
      allocate (contacts%imposed_spring(2, contacts%n), contacts%imposed_force(2, contacts%n))
      contacts%state(:contacts%n) = contact_stick
      system%held%rebuild = .true.
   end subroutine begin_path

   !> The next Newton step: a predictor, whose targets are zero, gives the barrier parameter;
   !> correctors lengthen the step.
   subroutine find_next_step(iteration, system, solver, contacts, laws, points, longest, error)
      type(open_close_type), intent(inout) :: iteration  !< of the step
      type(system_type), intent(inout) :: system  !< gets the d of the whole step
      type(solver_type), intent(inout) :: solver  !< linear solver
      type(contacts_type), intent(inout) :: contacts  !< this step's list
      type(laws_type), intent(in) :: laws  !< plain, not damped
      type(interior_type), intent(inout) :: points  !< of the contacts
      real(wp), intent(out) :: longest  !< step length to the boundary
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      real(wp) :: barrier, present, last, targets(3, contacts%n)
      integer :: i

      present = mean_product(points, 0.0_wp)
      call set_base_point(points, contacts, laws)
      call set_bound_steps(points, contacts, laws, 0.0_wp)
      call set_targets(points, 0.0_wp, 0.0_wp)
      call solve_step(longest)
      barrier = min(1.0_wp, mean_product(points, longest)/present)**centring_power
      barrier = max(barrier*present, (last_radius*iteration%tolerance)**2)
      call set_targets(points, barrier, present)
      call set_bound_steps(points, contacts, laws, longest)
      call solve_step(longest)
      do i = 1, most_corrections
         if (longest > long_enough .or. allocated(error)) exit
         last = longest
         targets = points%target
         call correct_targets(points, barrier, min(1.0_wp, longest + lengthening))
         call set_bound_steps(points, contacts, laws, longest)
         call solve_step(longest)
         if (longest >= last) cycle
         points%target = targets
         call solve_step(longest)
         exit
      end do

   contains

      !> The Newton step to the present targets.
      subroutine solve_step(length)
         real(wp), intent(out) :: length  !< step length to the boundary

         length = 0.0_wp
         if (allocated(error)) return
         call assume_interior(points, contacts, laws)
         call solve_assumed(iteration, system, solver, contacts, laws, error)
         if (allocated(error)) return
         call measure_contacts(contacts, system%d)
         call find_step(points, contacts, laws, length)
      end subroutine solve_step
   end subroutine find_next_step

   !> Forces are within the tolerance: solve the whole Newton step exactly, and evaluate again.
   subroutine finish_path(iteration, system, solver, contacts, laws, closed, error)
      type(open_close_type), intent(inout) :: iteration  !< of the step
      type(system_type), intent(inout) :: system  !< equations of the step
      type(solver_type), intent(inout) :: solver  !< linear solver
      type(contacts_type), intent(inout) :: contacts  !< this step's list
      type(laws_type), intent(in) :: laws  !< plain, not damped
      logical, intent(out) :: closed  !< every contact exerts what was assumed of it
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      real(wp) :: d(6, size(system%d, 2))

      d = system%d
      call solve(solver, system%matrix, system%rhs, system%d, error)
      if (allocated(error)) return
      call evaluate(iteration, system%d, contacts, laws)
      closed = iteration%residual <= iteration%tolerance
      if (closed) return
      system%d = d
      call measure_contacts(contacts, d)
   end subroutine finish_path

end module dda_static_path
