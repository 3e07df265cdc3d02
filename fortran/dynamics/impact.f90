! SPDX-License-Identifier: GPL-3.0-or-later
!> Impacts: the restitution is a property of the joint, independent of contact stiffness and Δt.
!>
!> The step is first solved with the dashpots of `damp_contacts`, which stop closing contacts.
!> Contacts that closed faster than twice the velocity that gravity causes in a step are struck, and
!> the step is solved again with
!>
!>     v⁺ = v_free + M̂⁻¹ (N p + T t),  0 ≤ p ⊥ Nᵀ(v⁺ + e v⁻) ≥ 0,  |t| ≤ μ p,  Tᵀv⁺ = 0 if stuck,
!>
!> by the same open–close iteration, with rigid contact conditions on the velocity.  In this
!> solution struck blocks, their other closed contacts and their supports are rigid; bonds are
!> springs as in other steps.  Solutions are repeated until no further contact is struck.  A contact
!> that the impact opens, such as the corner about which a block has rocked, retains its force for
!> the fraction of the step before the impact.
!>
!> With e = 0 the contact closes its gap in this step, v⁺ = −z₀/Δt, and stops in the next step; the
!> sum of both impulses is the impulse of one impact.
module dda_impact
   use dda_kinds, only: wp, long
   use dda_blocks, only: blocks_type
   use dda_compact_block, only: main_diagonal
   use dda_contact, only: contacts_type, contact_open, is_carried, is_damped, is_lifted, is_struck
   use dda_contact_damping, only: losses_type, carry, is_approached, lift, losses_of, strike
   use dda_errors, only: error_type, error_convergence, fail
   use dda_friction, only: laws_type
   use dda_linear_solver, only: record_rigid_terms, solver_type
   use dda_linear_terms, only: linear_term_type, add_product, at_end, term_support
   use dda_model, only: half_size
   use dda_open_close, only: open_close_type, add_counts, counts_of, solve_contacts
   use dda_scheme, only: step_type
   use dda_system, only: system_type, begin_diagonal
   implicit none
   private
   public :: impacts_type, prepare_impacts, resolve_impacts, count_impacts

   !> smallest velocity of an impact/velocity that gravity causes in a step
   real(wp), parameter :: slow = 2.0_wp
   real(wp), parameter :: zero_gap = 0.01_wp   !< gap/path in a step below which a gap counts as 0
   real(wp), parameter :: rigid = 1.0e8_wp  !< strain stiffness of a struck block/K̂
   real(wp), parameter :: unyielding = 1.0e5_wp !< stiffness of rigid supports over inertia in K̂
   integer, parameter :: most_rounds = 20       !< largest number of solutions per step
   !> largest gain/exchanged energies, due to rounding
   real(wp), parameter :: gain_allowed = 1.0e-6_wp

   !> Impacts of a step, and their counts.
   type :: impacts_type
      logical, allocatable :: hit(:)      !< [blocks] struck in this step
      logical, allocatable :: stiff(:)    !< [blocks] made rigid in K̂
      real(wp), allocatable :: before(:)  !< [blocks] fraction of the step before its impact
      logical :: lifting = .true.         !< opening contacts retain force until the impact
      !> factor of restitution; < 1 to prevent an energy gain
      real(wp) :: restitution_factor = 1.0_wp
      real(wp) :: work = 0.0_wp           !< work of rigid supports, J per metre
      real(wp) :: energy_lost = 0.0_wp    !< energy lost by rigid strains, J per metre
      integer :: struck = 0               !< number of contacts struck in this step
      integer(long) :: steps = 0          !< number of accepted steps with impacts
      integer(long) :: contacts = 0       !< number of contacts struck in these steps
      integer(long) :: reduced = 0  !< steps in which restitution was reduced to prevent a gain
   end type impacts_type

contains

   !> Allocate the impacts for n blocks.
   subroutine prepare_impacts(impacts, n)
      type(impacts_type), intent(out) :: impacts  !< no impacts
      integer, intent(in) :: n  !< number of blocks

      allocate (impacts%hit(n), impacts%stiff(n), source=.false.)
      allocate (impacts%before(n), source=0.0_wp)
   end subroutine prepare_impacts

   !> Find the impacts in a solved step, and solve the step again with the impact law.
   subroutine resolve_impacts(impacts, iteration, system, solver, contacts, laws, blocks, step, &
      gravity, error)
      type(impacts_type), intent(inout) :: impacts  !< impacts of this step
      type(open_close_type), intent(inout) :: iteration  !< open–close iteration of the step
      type(system_type), intent(inout) :: system  !< equations of the step
      type(solver_type), intent(inout) :: solver  !< linear solver
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step, solved
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(step_type), intent(in) :: step  !< the present step
      real(wp), intent(in) :: gravity  !< m/s²
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      integer :: round, found, lifted

      impacts%struck = 0
      impacts%restitution_factor = 1.0_wp
      impacts%lifting = .true.
      impacts%work = 0.0_wp
      impacts%energy_lost = 0.0_wp
      do round = 1, most_rounds
         if (gains_energy(contacts, laws, step) .and. impacts%restitution_factor > 0.0_wp) then
            call reduce_impacts(impacts, contacts, laws, blocks, step)
         else
            call strike_closed(impacts, iteration, contacts, laws, blocks, step, &
               slow*gravity*step%time_step, impacts%struck == 0, found)
            call lift_opened(impacts, contacts, laws, lifted)
            if (found + lifted == 0) exit
            impacts%struck = impacts%struck + found
            call stiffen_neighbours(impacts, contacts, laws, blocks, step)
            if (found > 0) call make_blocks_rigid(impacts, system, impacts%struck == found)
            call record_rigid_terms(solver)
         end if
         call solve_again(iteration, system, solver, contacts, laws, blocks, error)
         if (allocated(error)) return
      end do
      if (round > most_rounds) call fail(error, error_convergence, &
         'the impacts do not converge with the restitution of their joints')
      if (impacts%struck == 0) return
      impacts%work = rigid_support_work(impacts, system)
      impacts%energy_lost = rigid_strain_loss(impacts, system)
   end subroutine resolve_impacts

   !> Count the impacts of an accepted step.
   pure subroutine count_impacts(impacts)
      type(impacts_type), intent(inout) :: impacts  !< impacts of this step

      if (impacts%struck == 0) return
      impacts%steps = impacts%steps + 1
      impacts%contacts = impacts%contacts + impacts%struck
      if (impacts%restitution_factor < 1.0_wp) impacts%reduced = impacts%reduced + 1
   end subroutine count_impacts

   !> Mark contacts as struck if they close in the solution faster than `slowest`.
   pure subroutine strike_closed(impacts, iteration, contacts, laws, blocks, step, slowest, &
      first, struck)
      type(impacts_type), intent(inout) :: impacts  !< impacts of this step
      type(open_close_type), intent(in) :: iteration  !< converged iteration
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step, solved
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(step_type), intent(in) :: step  !< the present step
      real(wp), intent(in) :: slowest  !< smallest velocity of an impact, m/s
      logical, intent(in) :: first  !< no contact has been struck in this step
      integer, intent(out) :: struck  !< number of contacts newly struck
      integer :: c

      struck = 0
      do c = 1, contacts%n
         if (contacts%damping(c) /= is_damped) cycle
         if (contacts%normal_force(c) <= iteration%tolerance) cycle
         if (contacts%rate(1, c) >= -slowest .or. .not. is_approached(contacts, step, c)) cycle
         if (laws%restitution(contacts%joint(c)) < 0.0_wp) cycle
         if (first .and. struck == 0) impacts%hit = .false.
         struck = struck + 1
         call strike(contacts, laws, blocks, step, c, opening_velocity(impacts, contacts, laws, &
            step, c))
         call record_hit(impacts, contacts%block_v(c), fraction_before_touch(contacts, step, c))
         call record_hit(impacts, contacts%block_e(c), fraction_before_touch(contacts, step, c))
      end do
   end subroutine strike_closed

   !> Record that a block is struck after a fraction of the step.
   pure subroutine record_hit(impacts, b, fraction)
      type(impacts_type), intent(inout) :: impacts  !< impacts of this step
      integer, intent(in) :: b  !< number of the block
      real(wp), intent(in) :: fraction  !< fraction of the step before the impact

      if (.not. impacts%hit(b)) impacts%before(b) = 0.0_wp
      impacts%hit(b) = .true.
      impacts%before(b) = max(impacts%before(b), fraction)
   end subroutine record_hit

   !> Return the fraction of the step before contact c touches at its present velocity, or 0.
   pure real(wp) function fraction_before_touch(contacts, step, c) result(fraction)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      type(step_type), intent(in) :: step  !< the present step
      integer, intent(in) :: c  !< number of the contact

      fraction = 0.0_wp
      associate (displacement => -step%time_step*contacts%rate(1, c))
         if (contacts%spring_gap(c) > zero_gap*displacement) &
            fraction = min(1.0_wp, contacts%gap(c)/displacement)
      end associate
   end function fraction_before_touch

   !> Let contacts that the impact opens retain their force until the impact.
   pure subroutine lift_opened(impacts, contacts, laws, lifted)
      type(impacts_type), intent(in) :: impacts  !< impacts of this step
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step, solved
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(out) :: lifted  !< number of these contacts
      real(wp) :: fraction
      integer :: c

      lifted = 0
      do c = 1, contacts%n
         if (contacts%damping(c) /= is_carried .or. contacts%trial_state(c) /= contact_open) cycle
         fraction = 0.0_wp
         if (impacts%hit(contacts%block_v(c))) fraction = impacts%before(contacts%block_v(c))
         if (impacts%hit(contacts%block_e(c))) &
            fraction = max(fraction, impacts%before(contacts%block_e(c)))
         if (.not. (fraction > 0.0_wp .and. impacts%lifting)) cycle
         call lift(contacts, laws, c, fraction)
         lifted = lifted + 1
      end do
   end subroutine lift_opened

   !> Return the opening velocity of a struck contact after the impact, m/s.
   pure real(wp) function opening_velocity(impacts, contacts, laws, step, c) result(target)
      type(impacts_type), intent(in) :: impacts  !< impacts of this step
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      type(step_type), intent(in) :: step  !< the present step
      integer, intent(in) :: c  !< number of the contact

      associate (rate => contacts%rate(1, c), spring_gap => contacts%spring_gap(c))
         target = -impacts%restitution_factor*laws%restitution(contacts%joint(c))*rate
         if (target > 0.0_wp .or. impacts%restitution_factor < 1.0_wp) return
         if (spring_gap > -zero_gap*step%time_step*rate) target = -spring_gap/step%time_step
      end associate
   end function opening_velocity

   !> Make the other closed contacts of struck blocks rigid.
   pure subroutine stiffen_neighbours(impacts, contacts, laws, blocks, step)
      type(impacts_type), intent(in) :: impacts  !< impacts of this step
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step, solved
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(step_type), intent(in) :: step  !< the present step
      integer :: c

      do c = 1, contacts%n
         if (contacts%damping(c) /= is_damped .or. .not. contacts%static_force(c) > 0.0_wp) cycle
         if (laws%restitution(contacts%joint(c)) < 0.0_wp) cycle
         if (impacts%hit(contacts%block_v(c)) .or. impacts%hit(contacts%block_e(c))) &
            call carry(contacts, laws, blocks, step, c)
      end do
   end subroutine stiffen_neighbours

   !> Make struck blocks rigid: fix their strains, and their positions at supports.
   !> Supports fix positions, because with fixed velocities repeatedly struck blocks would drift.
   pure subroutine make_blocks_rigid(impacts, system, first)
      type(impacts_type), intent(inout) :: impacts  !< impacts of this step
      type(system_type), intent(inout) :: system  !< equations of the step
      logical, intent(in) :: first  !< first impacts in this step
      real(wp) :: k, own(6)
      integer :: b, i

      if (first) impacts%stiff = .false.
      do i = 1, system%terms%n
         associate (term => system%terms%term(i), b => system%terms%term(i)%block_a)
            if (.not. has_free_support(impacts, term)) cycle
            k = unyielding_spring(system, b, term%row_a)
            call begin_diagonal(system, b)
            call add_product(system%linear%diagonal(:, :, b), k, term%row_a, term%row_a)
         end associate
      end do
      do b = 1, system%linear%n
         if (.not. impacts%hit(b) .or. impacts%stiff(b)) cycle
         impacts%stiff(b) = .true.
         call begin_diagonal(system, b)
         own = main_diagonal(system%constant(:, b))
         do i = 4, 6
            system%linear%diagonal(i, i, b) = system%linear%diagonal(i, i, b) + rigid*own(i)
         end do
      end do
   end subroutine make_blocks_rigid

   !> .true. if a support of a struck block has not been made rigid in this step.
   pure logical function has_free_support(impacts, term)
      type(impacts_type), intent(in) :: impacts  !< impacts of this step
      type(linear_term_type), intent(in) :: term  !< spring or dashpot of an element

      has_free_support = .false.
      if (is_support(term)) has_free_support = impacts%hit(term%block_a) .and. &
         .not. impacts%stiff(term%block_a)
   end function has_free_support

   !> .true. if the term is a fixed support that acts at the end of the step.
   !> Moving supports are not made rigid, because the block would lag behind the support.
   pure logical function is_support(term)
      type(linear_term_type), intent(in) :: term  !< spring or dashpot of an element

      is_support = term%kind == term_support .and. term%instant == at_end .and. &
         term%block_b == 0 .and. .not. any(term%motion > 0 .and. abs(term%row_a(:2)) > 0.0_wp)
   end function is_support

   !> Return the stiffness that makes a support rigid relative to the inertia of its block, N/m.
   pure real(wp) function unyielding_spring(system, b, row) result(stiffness)
      type(system_type), intent(in) :: system  !< equations of the step
      integer, intent(in) :: b  !< number of the block
      real(wp), intent(in) :: row(6)  !< gradient of the supported displacement
      real(wp) :: own(6)

      own = main_diagonal(system%constant(:, b))
      stiffness = unyielding/sum(row(:3)**2/own(:3))
   end function unyielding_spring

   !> Return the energy lost by making the strains of struck blocks rigid, J per metre of thickness.
   pure real(wp) function rigid_strain_loss(impacts, system) result(loss)
      type(impacts_type), intent(in) :: impacts  !< impacts of this step
      type(system_type), intent(in) :: system  !< equations of the step, solved
      real(wp) :: own(6)
      integer :: b, i

      loss = 0.0_wp
      do b = 1, system%linear%n
         if (.not. impacts%stiff(b)) cycle
         own = main_diagonal(system%constant(:, b))
         do i = 4, 6
            loss = loss + rigid*own(i)*system%d(i, b)**2
         end do
      end do
   end function rigid_strain_loss

   !> Return the work of the rigid supports of struck blocks in a step, J per metre of thickness.
   pure real(wp) function rigid_support_work(impacts, system) result(work)
      type(impacts_type), intent(in) :: impacts  !< impacts of this step
      type(system_type), intent(in) :: system  !< equations of the step, solved
      real(wp) :: displacement
      integer :: i

      work = 0.0_wp
      do i = 1, system%terms%n
         associate (term => system%terms%term(i), b => system%terms%term(i)%block_a)
            if (.not. is_support(term)) cycle
            if (.not. impacts%stiff(b)) cycle
            displacement = dot_product(term%row_a, system%d(:, b))
            work = work - unyielding_spring(system, b, term%row_a)*displacement**2
         end associate
      end do
   end function rigid_support_work

   !> Repeat the open–close iteration with the present dashpots and impacts.
   !> Struck contacts are stiffer by the factor `gain`, so rounding errors of displacements may
   !> cause larger forces than rounding errors of positions.
   subroutine solve_again(iteration, system, solver, contacts, laws, blocks, error)
      type(open_close_type), intent(inout) :: iteration  !< open–close iteration of the step
      type(system_type), intent(inout) :: system  !< equations of the step
      type(solver_type), intent(inout) :: solver  !< linear solver
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step, solved
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      integer :: former_counts(3)
      real(wp) :: noise

      noise = iteration%noise
      iteration%noise = noise*max(1.0_wp, maxval(contacts%gain(:, :contacts%n)) &
         *maxval(abs(system%d(1:2, :)))/half_size(blocks))
      former_counts = counts_of(iteration)
      contacts%state(:contacts%n) = contacts%trial_state(:contacts%n)
      system%contact_terms%rebuild = .true.
      call solve_contacts(iteration, system, solver, contacts, laws, error)
      iteration%noise = noise
      call add_counts(iteration, former_counts)
   end subroutine solve_again

   !> .true. if the impacts increase the energy, which is possible for Newton's law with friction.
   pure logical function gains_energy(contacts, laws, step)  ! total
      type(contacts_type), intent(in) :: contacts  !< contacts of this step, solved
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      type(step_type), intent(in) :: step  !< the present step
      type(losses_type) :: losses
      real(wp) :: loss, scale
      integer :: c

      loss = 0.0_wp
      scale = 0.0_wp
      do c = 1, contacts%n
         if (contacts%damping(c) < is_struck) cycle
         losses = losses_of(contacts, laws, step, c)
         loss = loss + losses%impact
         scale = scale + step%time_step*(abs(contacts%normal_force(c)*contacts%rate(1, c)) &
            + abs(contacts%shear_force(c)*contacts%rate(2, c)))
      end do
      gains_energy = loss < -gain_allowed*scale
   end function gains_energy

   !> Reduce impacts that would increase the energy.  Successive calls first remove the forces
   !> before the impact, then halve the restitution, and finally set it to zero.
   pure subroutine reduce_impacts(impacts, contacts, laws, blocks, step)
      type(impacts_type), intent(inout) :: impacts  !< impacts of this step
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step, solved
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(step_type), intent(in) :: step  !< the present step
      integer :: c

      if (.not. impacts%lifting) &
         impacts%restitution_factor = merge(0.5_wp*impacts%restitution_factor, 0.0_wp, &
            impacts%restitution_factor > 0.2_wp)
      impacts%lifting = .false.
      do c = 1, contacts%n
         if (contacts%damping(c) == is_lifted) call carry(contacts, laws, blocks, step, c)
         if (contacts%damping(c) == is_struck) call strike(contacts, laws, blocks, step, c, &
            opening_velocity(impacts, contacts, laws, step, c))
      end do
   end subroutine reduce_impacts

end module dda_impact
