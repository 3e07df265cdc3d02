! SPDX-License-Identifier: GPL-3.0-or-later
!> Solution of a static step in which many contacts change states.
!>
!> In statics inertia hardly restrains a block whose contacts all slide, so the open–close iteration
!> overshoots.  Here all iterations use one matrix S (modified Newton), in which open and sliding
!> contacts retain a fraction of their springs:
!>
!>     S (d' − d) = f̂ + Σ [N(d) ∂g − T(d) ∂s] − K d ,
!>
!> with K and f̂ without contacts, and N and T by the contact laws.  Anderson acceleration
!> compensates for the excess stiffness of S.  An unconverged step is accepted with its slip, and
!> the next step begins with shear forces at their bounds.  Contacts whose slip would reverse in the
!> next step stick there, so that their springs restrain the blocks again.
module dda_static_relaxation
   use dda_kinds, only: wp
   use dda_anderson, only: anderson_type, accelerate
   use dda_block_matrix, only: multiply
   use dda_contact, only: contacts_type, contact_open, contact_slide, contact_stick
   use dda_contact_assembly, only: assemble_contacts
   use dda_errors, only: error_type, error_convergence, fail
   use dda_friction, only: closed_springs, laws_type
   use dda_linear_solver, only: solver_type
   use dda_open_close, only: open_close_type, add_counts, begin_iteration, check_strength, &
      counts_of, evaluate, fail_if_step_stopped, iterate, loose_residual, retained_fraction, &
         solve_assumed, &
      adopt_trial_states
   use dda_ordered_sums, only: inner_product, parallel_from
   use dda_system, only: system_type
   implicit none
   private
   public :: solve_statics, relax, many_changes

   !> least number of contacts for relaxation, and least number of changed states that starts it
   integer, parameter :: many_changes = 2000
   !> open–close iterations after which a step is relaxed: walls of 4,000 bricks with open head
   !> joints then reach equilibrium in 20 % of the computing time
   integer, parameter :: few_iterations = 40
   integer, parameter :: most_iterations = 21    !< iterations of a relaxed step
   real(wp), parameter :: ascent = 10.0_wp  !< largest accepted last/smallest correction
   !> residual, over tolerance, to check bonds
   real(wp), parameter :: bond_check_residual = 1.0e3_wp

   !> Iterates of a step, scaled by the square roots of the diagonal of S.
   type :: iterate_type
      type(anderson_type) :: memory         !< Anderson acceleration
      !> [6n] square roots of the diagonal, which scale translations, rotations and strains
      real(wp), allocatable :: scale(:)
      real(wp), allocatable :: x(:)         !< [6n] scaled d
      real(wp), allocatable :: image(:)     !< [6n] scaled d'
      real(wp), allocatable :: best(:,:)    !< [6,n] d with the smallest correction, not scaled
      real(wp) :: correction = 0.0_wp       !< ‖image − x‖²; twice an energy, J/m
      real(wp) :: least_correction = huge(1.0_wp)  !< smallest correction so far, J/m
   end type iterate_type

contains

   !> Iterate until assumed forces equal the forces by the laws.
   !> If many contacts change states, this step and the following steps of the stage are relaxed.
   subroutine solve_statics(iteration, system, solver, contacts, laws, error)
      type(open_close_type), intent(inout) :: iteration  !< open–close iteration of the step
      type(system_type), intent(inout) :: system  !< equations of the step
      type(solver_type), intent(inout) :: solver  !< linear solver
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      logical :: converged
      integer :: former_counts(3)

      former_counts = 0
      if (.not. iteration%relaxes) then
         call attempt_states(iteration, system, solver, contacts, laws, converged, error)
         if (converged .or. allocated(error)) return
         former_counts = counts_of(iteration)
         iteration%relaxes = .true.
      end if
      call relax(iteration, system, solver, contacts, laws, error)
      call add_counts(iteration, former_counts)
   end subroutine solve_statics

   !> Attempt the open–close iteration; stop if too many states change in one iteration.
   subroutine attempt_states(iteration, system, solver, contacts, laws, converged, error)
      type(open_close_type), intent(inout) :: iteration  !< open–close iteration of the step
      type(system_type), intent(inout) :: system  !< equations of the step
      type(solver_type), intent(inout) :: solver  !< linear solver
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      logical, intent(out) :: converged  !< if .false., contacts have their former states
      type(error_type), allocatable, intent(out) :: error  !< allocated if the step has failed
      integer, allocatable :: states(:)
      integer :: max_iterations

      states = contacts%state(:contacts%n)
      max_iterations = iteration%max_iterations
      iteration%max_iterations = min(max_iterations, few_iterations)
      iteration%most_changes = many_changes
      iteration%keeps_states = .false.
      call iterate(iteration, system, solver, contacts, laws, converged, error)
      iteration%most_changes = huge(1)
      iteration%max_iterations = max_iterations
      if (converged .or. allocated(error)) return
      contacts%state(:contacts%n) = states
   end subroutine attempt_states

   !> Iterate with S, from d = 0 and the contact states of the last step.
   subroutine relax(iteration, system, solver, contacts, laws, error)
      type(open_close_type), intent(inout) :: iteration  !< open–close iteration of the step
      type(system_type), intent(inout) :: system  !< equations of the step
      type(solver_type), intent(inout) :: solver  !< linear solver
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      type(iterate_type) :: iterates
      integer :: i

      call begin_iteration(iteration, contacts)
      system%contact_terms%rebuild = .true.
      system%d = 0.0_wp
      call evaluate(iteration, system, contacts, laws)
      call impose_springs(iteration, contacts, laws)
      do i = 1, most_iterations
         call fail_if_step_stopped(iteration%may_stop, error)
         if (allocated(error)) exit
         iteration%iterations = i
         iteration%reduction = loose_residual
         call impose_forces(contacts)
         call compute_next(iterates, i, iteration, system, solver, contacts, laws, error)
         if (allocated(error)) exit
         if (force_of_correction(iterates%correction, laws) <= iteration%tolerance) exit
         call accelerate(iterates%memory, iterates%x, iterates%image)
         system%d = reshape(iterates%x/iterates%scale, shape(system%d))
         call evaluate(iteration, system, contacts, laws)
      end do
      if (.not. allocated(error)) call accept_best(iterates, iteration, system, contacts, laws)
      deallocate (contacts%imposed_spring, contacts%imposed_force)
   end subroutine relax

   !> Set the springs of S from the states before the step and the gaps and forces at d = 0.
   !> The retained fraction of an open contact decreases with its gap, like its secant stiffness.
   subroutine impose_springs(iteration, contacts, laws)
      type(open_close_type), intent(in) :: iteration  !< open–close iteration of the step
      type(contacts_type), intent(inout) :: contacts  !< contacts that stick; springs are set
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      real(wp) :: fraction(2), springs(2), gap_force
      integer :: c

      allocate (contacts%imposed_spring(2, contacts%n), contacts%imposed_force(2, contacts%n))
      !$omp parallel do private(fraction, springs, gap_force) schedule(static) &
      !$omp& if (contacts%n >= parallel_from)
      do c = 1, contacts%n
         fraction = 1.0_wp
         springs = closed_springs(contacts, laws, c)
         gap_force = springs(1)*max(0.0_wp, contacts%gap(c))
         if (contacts%state(c) == contact_open .and. .not. contacts%normal_force(c) > 0.0_wp) &
            fraction = retained_fraction/(1.0_wp + gap_force/max(iteration%weight, tiny(1.0_wp)))
         if (contacts%state(c) == contact_slide) fraction(2) = retained_fraction
         contacts%imposed_spring(:, c) = fraction*springs
         contacts%state(c) = contact_stick
      end do
   end subroutine impose_springs

   !> Linearise the contact forces at the last evaluation, with the springs of S.
   subroutine impose_forces(contacts)
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step, evaluated
      integer :: c

      !$omp parallel do schedule(static) if (contacts%n >= parallel_from)
      do c = 1, contacts%n
         contacts%imposed_force(:, c) = [contacts%normal_force(c), contacts%shear_force(c)] &
            + contacts%imposed_spring(:, c) &
            *[contacts%new_gap(c) - contacts%gap(c), -contacts%slip(c)]
      end do
   end subroutine impose_forces

   !> Compute the next d with S, and store the present d if its correction is the smallest so far.
   !> The first iterate, d = 0, is never stored.  The last iterate is stored if its correction is at
   !> most `ascent` times the smallest one, because its slip is closer to the solution.
   subroutine compute_next(iterates, i, iteration, system, solver, contacts, laws, error)
      type(iterate_type), intent(inout) :: iterates  !< iterates of the step
      integer, intent(in) :: i  !< number of the iteration
      type(open_close_type), intent(inout) :: iteration  !< open–close iteration of the step
      type(system_type), intent(inout) :: system  !< equations of the step; d becomes d'
      type(solver_type), intent(inout) :: solver  !< linear solver
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      real(wp), allocatable :: d(:,:)
      integer :: b, j

      d = system%d
      call solve_assumed(iteration, system, solver, contacts, laws, error)
      if (allocated(error)) return
      if (i == 1) iterates%scale = [((sqrt(system%matrix%diagonal(j, j, b)), j=1, 6), b=1, &
         system%matrix%n)]
      iterates%x = iterates%scale*reshape(d, [size(d)])
      iterates%image = iterates%scale*reshape(system%d, [size(d)])
      iterates%correction = inner_product(size(d, 2), iterates%image - iterates%x, &
         iterates%image - iterates%x)
      if (i > 2 .and. .not. iterates%correction < iterates%least_correction &
         *merge(ascent, 1.0_wp, i == most_iterations)) return
      iterates%least_correction = iterates%correction
      iterates%best = d
      if (i == 1) iterates%best = system%d
   end subroutine compute_next

   !> Return the contact force that corresponds to a correction, N/m.
   pure real(wp) function force_of_correction(correction, laws) result(force)
      real(wp), intent(in) :: correction   !< correction, J/m
      type(laws_type), intent(in) :: laws  !< stiffness of the contacts

      force = sqrt(correction*laws%normal_stiffness)
   end function force_of_correction

   !> Accept the stored increment d, and compute the work of the unbalanced forces.
   subroutine accept_best(iterates, iteration, system, contacts, laws)
      type(iterate_type), intent(in) :: iterates  !< iterates of the step
      type(open_close_type), intent(inout) :: iteration  !< open–close iteration of the step
      type(system_type), intent(inout) :: system  !< equations of the step; f̂ is overwritten
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      real(wp), allocatable :: internal(:,:)
      logical :: strong

      system%d = iterates%best
      call evaluate(iteration, system, contacts, laws)
      iteration%converged = force_of_correction(iterates%least_correction, &
         laws) <= bond_check_residual*iteration%tolerance
      if (iteration%converged) then
         call check_strength(iteration, contacts, laws, strong)
         iteration%converged = strong
         if (.not. strong) call evaluate(iteration, system, contacts, laws)
      end if
      call impose_forces(contacts)
      call assemble_contacts(system, contacts, laws)
      allocate (internal, mold=system%d)
      call multiply(system%matrix, system%d, internal)
      iteration%unbalanced_work = inner_product(system%matrix%n, system%d, system%rhs - internal)
      call adopt_trial_states(contacts, 1, contacts%n)
   end subroutine accept_best

end module dda_static_relaxation
