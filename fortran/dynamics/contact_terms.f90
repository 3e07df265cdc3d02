! SPDX-License-Identifier: GPL-3.0-or-later
!> Springs of the contacts in K̂ and contact forces at d = 0.  A row is assembled again only if
!> springs or forces of its block have changed.
!>
!> In an iteration, a contact has the forces N = N₀ − K_n (z − z₀) and T = T₀ + K_s s at gap z and
!> slip s.  N₀, K_n, T₀ and K_s depend on its state, its law, the time in the step at which
!> its springs act, its damping and its retained stiffness.  To prevent overshoot, an open contact
!> may retain a fraction of its normal spring, and a sliding contact a fraction of its shear spring.
!> The force of this fraction is zero at the last iterate, so the solution does not change.
!>
!> Within a step the geometry of the contacts is constant and the open–close iteration changes few
!> of their states.  If the spring or force of a contact differs from the assembled value, both its
!> blocks are marked as dirty.
module dda_contact_terms
   use dda_kinds, only: wp, long
   use dda_contact, only: capacity_of, contacts_type, contact_open, contact_slide, contact_stick
   use dda_contact_gradients, only: acting_rows, rows_type
   use dda_friction, only: laws_type, acting, acts_at_theta, closed_springs, frozen_bound_of, &
      is_simple, multiplier_of
   use dda_growth, only: grow
   use dda_joint_bond, only: add_bond_terms, is_cohesive
   use dda_joint_contact, only: centre_shift
   use dda_ordered_sums, only: pieces, first_of, last_of, parallel_from
   use dda_rank_one, only: rank_one_type, ignored_change, add_change
   implicit none
   private
   public :: contact_terms_type, update_contact_terms, is_free, is_clean, &
      is_dirty_force, is_dirty_stiffness

   integer, parameter :: is_clean = 0            !< no part must be assembled again
   integer, parameter :: is_dirty_force = 1      !< the right-hand side must be assembled again
   !> the matrix and the right-hand side must be assembled again
   integer, parameter :: is_dirty_stiffness = 2

   integer, parameter :: none = -1   !< no assembled state

   !> Terms of the contacts that must be assembled, or passed to the solver.
   type :: contact_terms_type
      logical :: rebuild = .true.             !< contacts or linear part are new
      logical :: matrix_changed = .true.      !< K̂ has changed since the solver was last renewed
      integer, allocatable :: dirty(:)        !< [blocks] parts that must be assembled again
      integer, allocatable :: changed(:)      !< [contacts] parts that have changed
      !> springs and forces of contacts that neither slide nor are bonded depend only on the state
      logical :: by_state = .false.
      !> [contacts] assembled state if a contact neither slides nor is bonded, else `none`
      integer, allocatable :: assembled_state(:)
      type(rank_one_type) :: spring_changes   !< changes since the last factorisation
   end type contact_terms_type

contains

   !> Update the terms of contacts in their assumed states; blocks with changes become dirty.
   subroutine update_contact_terms(terms, contacts, laws)
      type(contact_terms_type), intent(inout) :: terms  !< assembled terms of the contacts
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer :: p, c

      call grow(terms%changed, capacity_of(contacts), exactly=.true.)
      call grow(terms%assembled_state, capacity_of(contacts), exactly=.true.)
      terms%by_state = laws%plain .and. .not. (laws%augmented .or. laws%damped .or. &
         allocated(contacts%imposed_spring) .or. allocated(contacts%frozen_bound))
      if (terms%rebuild .or. .not. terms%by_state) terms%assembled_state(:contacts%n) = none
      if (contacts%n < parallel_from) then
         call compare_forces_range(terms, contacts, laws, 1, contacts%n)
      else
         !$omp parallel do schedule(static)
         do p = 1, pieces(contacts%n)
            call compare_forces_range(terms, contacts, laws, first_of(p, contacts%n), &
               last_of(p, contacts%n))
         end do
      end if
      if (terms%rebuild) terms%dirty = is_dirty_stiffness
      terms%matrix_changed = terms%rebuild .or. &
         any(terms%changed(:contacts%n) == is_dirty_stiffness)
      do c = 1, contacts%n
         if (terms%changed(c) == is_clean) cycle
         if (terms%changed(c) == is_dirty_stiffness) call renew_springs(terms, contacts, laws, c)
         associate (v => contacts%block_v(c), e => contacts%block_e(c))
            terms%dirty(v) = max(terms%dirty(v), terms%changed(c))
            terms%dirty(e) = max(terms%dirty(e), terms%changed(c))
         end associate
      end do
   end subroutine update_contact_terms

   !> Mark contacts first … last if their spring or force at d = 0 differs from the assembled value.
   pure subroutine compare_forces_range(terms, contacts, laws, first, last)
      type(contact_terms_type), intent(inout) :: terms  !< assembled terms of the contacts
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: first, last  !< first and last contact
      real(wp) :: springs(2), forces(2)
      logical :: simple
      integer :: c

      simple = is_simple(laws) .and. .not. (contacts%with_multipliers .or. &
         allocated(contacts%imposed_spring))
      do c = first, last
         terms%changed(c) = is_clean
         if (terms%assembled_state(c) == contacts%state(c) .and. .not. contacts%retained(c) &
            > 0.0_wp) cycle
         if (simple .and. contacts%state(c) == contact_stick) then
            springs = [laws%normal_stiffness, laws%shear_stiffness]
            forces = [0.0_wp - springs(1)*contacts%gap(c), 0.0_wp + springs(2)*contacts%stretch(c)]
         else
            call find_terms(contacts, laws, c, springs, forces)
         end if
         if (.not. terms%rebuild) then
            if (.not. all(same_bits(forces, contacts%free_force(:, c)))) &
               terms%changed(c) = is_dirty_force
         end if
         contacts%free_force(:, c) = forces
         if (.not. all(same_bits(springs, contacts%spring(:, c)))) &
            terms%changed(c) = is_dirty_stiffness
         if (tilt_differs(contacts, c)) terms%changed(c) = is_dirty_stiffness
         terms%assembled_state(c) = merge(contacts%state(c), none, terms%by_state .and. .not. &
            (contacts%state(c) == contact_slide .or. contacts%bonded(c) .or. &
            contacts%retained(c) > 0.0_wp))
      end do
   end subroutine compare_forces_range

   !> Record a change of the springs of contact c for the solver.
   pure subroutine renew_springs(terms, contacts, laws, c)
      type(contact_terms_type), intent(inout) :: terms  !< assembled terms of the contacts
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c  !< number of the contact
      type(rows_type) :: rows
      real(wp) :: springs(2), forces(2)
      logical :: matters(2)

      call find_terms(contacts, laws, c, springs, forces)
      if (tilt_differs(contacts, c)) then  ! the normal spring acts on other rows
         call acting_rows(contacts, c, rows)
         call add_change(terms%spring_changes, contacts%block_v(c), rows%normal_v, &
            contacts%block_e(c), rows%normal_e, -contacts%spring(1, c))
         contacts%spring(1, c) = 0.0_wp
         contacts%tilt(2, c) = contacts%tilt(1, c)
      end if
      call acting_rows(contacts, c, rows)
      associate (change => springs - contacts%spring(:, c), changes => terms%spring_changes, &
         v => contacts%block_v(c), e => contacts%block_e(c))
         matters = abs(change) > ignored_change*max(springs, contacts%spring(:, c))
         if (matters(1)) call add_change(changes, v, rows%normal_v, e, rows%normal_e, change(1))
         if (matters(2)) call add_change(changes, v, rows%shear_v, e, rows%shear_e, change(2))
      end associate
      contacts%spring(:, c) = springs
   end subroutine renew_springs

   !> .true. if the assumed rise per unit of slip of contact c differs from the value in K̂.
   pure logical function tilt_differs(contacts, c)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      integer, intent(in) :: c  !< number of the contact

      tilt_differs = contacts%with_laws
      if (tilt_differs) tilt_differs = .not. same_bits(contacts%tilt(1, c), contacts%tilt(2, c))
   end function tilt_differs

   !> .true. if all bits are equal, including the sign of zero and the bits of NaN.
   elemental logical function same_bits(a, b)
      real(wp), intent(in) :: a, b

      same_bits = transfer(a, 0_long) == transfer(b, 0_long)
   end function same_bits

   !> .true. if contact c has no force and retains no spring.
   elemental logical function is_free(contacts, c)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      integer, intent(in) :: c  !< number of the contact

      is_free = contacts%state(c) == contact_open .and. .not. contacts%retained(c) > 0.0_wp
      if (is_free) is_free = .not. has_open_friction(contacts, c)
      if (is_free) is_free = .not. contacts%bonded(c)
   end function is_free

   !> .true. if contact c is open but retains friction, because friction bounds are frozen.
   elemental logical function has_open_friction(contacts, c)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      integer, intent(in) :: c  !< number of the contact

      has_open_friction = .false.
      if (allocated(contacts%frozen_bound)) has_open_friction = contacts%state(c) &
         == contact_open .and. &
         contacts%frozen_bound(c) > 0.0_wp
   end function has_open_friction

   !> Find the stiffness of contact c in K̂ and its forces at d = 0, in its assumed state.
   pure subroutine find_terms(contacts, laws, c, springs, forces)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c  !< number of the contact
      real(wp), intent(out) :: springs(2), forces(2)  !< normal and shear value, N/m

      if (allocated(contacts%imposed_spring)) then
         springs = contacts%imposed_spring(:, c)
         forces = contacts%imposed_force(:, c)
      else if (is_free(contacts, c)) then
         springs = 0.0_wp
         forces = 0.0_wp
      else
         call find_force_terms(contacts, laws, c, springs, forces)
      end if
      if (.not. laws%cohesive) return
      associate (law => laws%slot(contacts%joint(c))%law)
         if (is_cohesive(contacts, law, c)) &
            call add_bond_terms(contacts, law, c, laws%theta, springs, forces)
      end associate
   end subroutine find_terms

   !> Find the stiffness and forces of a contact that is not free, without a damaged bond.
   pure subroutine find_force_terms(contacts, laws, c, springs, forces)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c  !< number of the contact
      real(wp), intent(out) :: springs(2), forces(2)  !< normal and shear value, N/m
      real(wp) :: at(2)
      logical :: open_friction, at_bound

      open_friction = has_open_friction(contacts, c)
      at_bound = open_friction
      if (open_friction) &
         at_bound = abs(contacts%slide_force(c)) >= frozen_bound_of(contacts, laws, c)
      springs = closed_springs(contacts, laws, c)
      forces = [multiplier_of(contacts, c), 0.0_wp]
      at = acting(contacts, laws, c, [contacts%gap(c), contacts%stretch(c)])
      if (contacts%with_net_slip) at(2) = at(2) + centre_shift(contacts, c)
      if (.not. laws%plain) then
         forces = contacts%line(:, c)
         at(1) = at(1) - contacts%tilt(1, c)*at(2)
      end if
      forces = forces + springs*[-at(1), at(2)]
      if (contacts%state(c) == contact_open) then
         springs(1) = contacts%retained(c)*springs(1)
         if (at_bound .or. .not. open_friction) springs(2) = 0.0_wp
      else if (contacts%state(c) == contact_slide) then
         springs(2) = contacts%retained(c)*springs(2)
      end if
      if (acts_at_theta(contacts, laws, c)) springs = laws%theta*springs
      if (laws%damped) springs = contacts%gain(:, c)*springs
      if (contacts%state(c) == contact_open) then
         forces(1) = 0.0_wp
         if (contacts%retained(c) > 0.0_wp) &
            forces(1) = springs(1)*(contacts%retained_at(c) - contacts%gap(c))
         if (.not. open_friction) forces(2) = 0.0_wp
         if (at_bound) forces(2) = contacts%slide_force(c)
      else if (contacts%state(c) == contact_slide) then
         forces(2) = contacts%slide_force(c) - springs(2)*contacts%retained_at(c)
      end if
   end subroutine find_force_terms

end module dda_contact_terms
