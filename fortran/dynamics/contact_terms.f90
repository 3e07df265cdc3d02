! SPDX-License-Identifier: GPL-3.0-or-later
!> The springs of the contacts in K̂ and their forces at d = 0, so that only what differs is
!> assembled again.
!>
!> A contact assumes N = N₀ − K_n (z − z₀) and T = T₀ + K_s s in a gap z and a slip s.  Its state,
!> its law, the instant that it acts at, its damping and what it retains are in these four numbers.
!> Of a spring that a state lacks, a fraction may stay for an iteration, about the last iterate:
!> that regularises the iteration where it would overshoot, and vanishes at its solution.
!>
!> Within a step the geometry of the contacts stays and the open–close iteration changes few of
!> their states: where its spring or force is not the one assembled, a contact marks both its
!> blocks as dirty.
module dda_contact_terms
   use dda_kinds, only: wp, long
   use dda_contact, only: capacity_of, contacts_type, contact_open, contact_slide
   use dda_contact_gradients, only: find_rows, rows_type
   use dda_friction, only: laws_type, acting_gap, acting_stretch, acts_at_theta, multiplier_of, &
      shear_stiffness_of
   use dda_growth, only: grow
   use dda_joint_bond, only: bond_forces, bond_springs, is_cohesive
   use dda_joint_contact, only: centre_shift
   use dda_ordered_sums, only: pieces, first_of, last_of, parallel_from
   use dda_rank_one, only: rank_one_type, drift, add_change
   implicit none
   private
   public :: contact_terms_type, prepare_contact_terms, update_contact_terms, is_free, is_clean, &
      is_dirty_force, is_dirty_stiffness

   integer, parameter :: is_clean = 0
   integer, parameter :: is_dirty_force = 1      !< the right-hand side
   integer, parameter :: is_dirty_stiffness = 2  !< the matrix too

   integer, parameter :: none = -1   !< no state

   !> Terms of the contacts that have to be assembled, and that a solver has not yet seen.
   type :: contact_terms_type
      logical :: rebuild = .true.             !< the contacts or the linear part are others
      logical :: other_matrix = .true.        !< K̂ is not that of the last call
      integer, allocatable :: dirty(:)        !< [blocks] what has to be assembled again
      integer, allocatable :: changed(:)      !< [contacts] what that is for
      !> springs and forces of contacts that neither slide nor are bonded follow from their states
      logical :: by_state = .false.
      !> [contacts] state that K̂ and f̂ have of such a contact in this step, else `none`
      integer, allocatable :: steady(:)
      type(rank_one_type) :: spring_changes   !< since the solver was renewed
   end type contact_terms_type

contains

   !> Nothing is assembled yet.
   subroutine prepare_contact_terms(terms, n)
      type(contact_terms_type), intent(out) :: terms  !< what K̂ and f̂ have of the contacts
      integer, intent(in) :: n  !< blocks

      allocate (terms%dirty(n), source=is_dirty_stiffness)
   end subroutine prepare_contact_terms

   !> Assemble the contacts in their assumed states; blocks of those that have changed become dirty.
   subroutine update_contact_terms(terms, contacts, laws)
      type(contact_terms_type), intent(inout) :: terms  !< what K̂ and f̂ have of the contacts
      type(contacts_type), intent(inout) :: contacts  !< this step's list
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer :: p, c

      call grow(terms%changed, capacity_of(contacts), exactly=.true.)
      call grow(terms%steady, capacity_of(contacts), exactly=.true.)
      terms%by_state = laws%plain .and. .not. (laws%augmented .or. laws%damped .or. &
         allocated(contacts%imposed_spring) .or. allocated(contacts%held_bound))
      if (terms%rebuild .or. .not. terms%by_state) terms%steady(:contacts%n) = none
      if (contacts%n < parallel_from) then
         call compare_range(terms, contacts, laws, 1, contacts%n)
      else
         !$omp parallel do schedule(static)
         do p = 1, pieces(contacts%n)
            call compare_range(terms, contacts, laws, first_of(p, contacts%n), &
               last_of(p, contacts%n))
         end do
      end if
      if (terms%rebuild) terms%dirty = is_dirty_stiffness
      terms%other_matrix = terms%rebuild .or. any(terms%changed(:contacts%n) == is_dirty_stiffness)
      do c = 1, contacts%n
         if (terms%changed(c) == is_clean) cycle
         if (terms%changed(c) == is_dirty_stiffness) call renew_springs(terms, contacts, laws, c)
         associate (v => contacts%block_v(c), e => contacts%block_e(c))
            terms%dirty(v) = max(terms%dirty(v), terms%changed(c))
            terms%dirty(e) = max(terms%dirty(e), terms%changed(c))
         end associate
      end do
   end subroutine update_contact_terms

   !> Forces at rest of contacts first … last, and what has changed; in a new list all forces have.
   pure subroutine compare_range(terms, contacts, laws, first, last)
      type(contact_terms_type), intent(inout) :: terms  !< what K̂ and f̂ have of the contacts
      type(contacts_type), intent(inout) :: contacts  !< this step's list
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: first, last  !< of the range
      real(wp) :: forces(2)
      integer :: c

      do c = first, last
         terms%changed(c) = is_clean
         if (terms%steady(c) == contacts%state(c) .and. .not. contacts%retained(c) > 0.0_wp) cycle
         forces = forces_at_rest(contacts, laws, c)
         if (.not. terms%rebuild) then
            if (.not. all(same_bits(forces, contacts%free_force(:, c)))) &
               terms%changed(c) = is_dirty_force
         end if
         contacts%free_force(:, c) = forces
         if (.not. all(same_bits(acting_springs(contacts, laws, c), contacts%spring(:, c)))) &
            terms%changed(c) = is_dirty_stiffness
         terms%steady(c) = merge(contacts%state(c), none, terms%by_state .and. .not. &
            (contacts%state(c) == contact_slide .or. contacts%bonded(c) .or. &
            contacts%retained(c) > 0.0_wp))
      end do
   end subroutine compare_range

   !> Other springs of contact c, recorded for the solver.
   pure subroutine renew_springs(terms, contacts, laws, c)
      type(contact_terms_type), intent(inout) :: terms  !< what K̂ and f̂ have of the contacts
      type(contacts_type), intent(inout) :: contacts  !< this step's list
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c  !< number of the contact
      type(rows_type) :: rows
      real(wp) :: springs(2)
      logical :: matters(2)

      call find_rows(contacts, c, rows)
      springs = acting_springs(contacts, laws, c)
      associate (change => springs - contacts%spring(:, c), changes => terms%spring_changes, &
         v => contacts%block_v(c), e => contacts%block_e(c))
         matters = abs(change) > drift*max(springs, contacts%spring(:, c))
         if (matters(1)) call add_change(changes, v, rows%normal_v, e, rows%normal_e, change(1))
         if (matters(2)) call add_change(changes, v, rows%shear_v, e, rows%shear_e, change(2))
      end associate
      contacts%spring(:, c) = springs
   end subroutine renew_springs

   !> Also the sign of zero and what is no number.
   elemental logical function same_bits(a, b)
      real(wp), intent(in) :: a, b

      same_bits = transfer(a, 0_long) == transfer(b, 0_long)
   end function same_bits

   !> Contact c has no force and retains no spring.
   elemental logical function is_free(contacts, c)
      type(contacts_type), intent(in) :: contacts  !< this step's list
      integer, intent(in) :: c  !< number of the contact

      is_free = contacts%state(c) == contact_open .and. .not. contacts%retained(c) > 0.0_wp
      if (is_free) is_free = .not. rubs_open(contacts, c)
      if (is_free) is_free = .not. contacts%bonded(c)
   end function is_free

   !> Contact c is open, and has friction at a frozen bound all the same.
   elemental logical function rubs_open(contacts, c)
      type(contacts_type), intent(in) :: contacts  !< this step's list
      integer, intent(in) :: c  !< number of the contact

      rubs_open = .false.
      if (allocated(contacts%held_bound)) rubs_open = contacts%state(c) == contact_open .and. &
         contacts%held_bound(c) > 0.0_wp
   end function rubs_open

   !> The friction of contact c has come to its frozen bound.
   elemental logical function at_frozen_bound(contacts, c)
      type(contacts_type), intent(in) :: contacts  !< this step's list
      integer, intent(in) :: c  !< number of the contact

      at_frozen_bound = abs(contacts%slide_force(c)) >= contacts%held_bound(c)
   end function at_frozen_bound

   !> Normal and shear stiffness of contact c in K̂, N/m.
   pure function acting_springs(contacts, laws, c) result(springs)
      type(contacts_type), intent(in) :: contacts  !< this step's list
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c  !< number of the contact
      real(wp) :: springs(2)

      springs = springs_alone(contacts, laws, c)
      if (.not. laws%cohesive) return
      associate (law => laws%slot(contacts%joint(c))%law)
         if (is_cohesive(contacts, law, c)) springs = bond_springs(contacts, law, c, laws%theta, &
            springs)
      end associate
   end function acting_springs

   !> The same without a bond that is damaged.
   pure function springs_alone(contacts, laws, c) result(springs)
      type(contacts_type), intent(in) :: contacts  !< this step's list
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c  !< number of the contact
      real(wp) :: springs(2)

      if (allocated(contacts%imposed_spring)) then
         springs = contacts%imposed_spring(:, c)
         return
      end if
      springs = 0.0_wp
      if (is_free(contacts, c)) return
      springs = [laws%normal_stiffness, shear_stiffness_of(contacts, laws, c)]
      if (.not. laws%plain) springs(1) = contacts%tangent(c)
      if (rubs_open(contacts, c)) then
         springs(1) = 0.0_wp
         if (at_frozen_bound(contacts, c)) springs(2) = 0.0_wp
      else if (contacts%state(c) == contact_open) then
         springs = [contacts%retained(c)*springs(1), 0.0_wp]
      end if
      if (contacts%state(c) == contact_slide) springs(2) = contacts%retained(c)*springs(2)
      if (acts_at_theta(contacts, laws, c)) springs = laws%theta*springs
      if (laws%damped) springs = [contacts%normal_gain(c), contacts%shear_gain(c)]*springs
   end function springs_alone

   !> Normal and shear force of contact c at d = 0 in its assumed state, N/m.
   pure function forces_at_rest(contacts, laws, c) result(forces)
      type(contacts_type), intent(in) :: contacts  !< this step's list
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c  !< number of the contact
      real(wp) :: forces(2)

      forces = forces_alone(contacts, laws, c)
      if (.not. laws%cohesive) return
      associate (law => laws%slot(contacts%joint(c))%law)
         if (is_cohesive(contacts, law, c)) forces = bond_forces(contacts, law, c, forces)
      end associate
   end function forces_at_rest

   !> The same without a bond that is damaged.
   pure function forces_alone(contacts, laws, c) result(forces)
      type(contacts_type), intent(in) :: contacts  !< this step's list
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c  !< number of the contact
      real(wp) :: forces(2), springs(2), gap, stretch

      if (allocated(contacts%imposed_force)) then
         forces = contacts%imposed_force(:, c)
         return
      end if
      forces = 0.0_wp
      if (is_free(contacts, c)) return
      if (contacts%bonded(c) .and. contacts%state(c) == contact_open .and. &
         .not. contacts%retained(c) > 0.0_wp) return
      gap = acting_gap(contacts, laws, c, contacts%gap(c))
      stretch = acting_stretch(contacts, laws, c, contacts%stretch(c))
      if (contacts%with_net_slip) stretch = stretch + centre_shift(contacts, c)
      forces(1) = multiplier_of(contacts, c) - laws%normal_stiffness*gap
      if (.not. laws%plain) forces(1) = contacts%normal_free(c) - contacts%tangent(c)*gap
      forces(2) = shear_stiffness_of(contacts, laws, c)*stretch
      if (rubs_open(contacts, c)) then
         forces(1) = 0.0_wp
         if (at_frozen_bound(contacts, c)) forces(2) = contacts%slide_force(c)
         return
      end if
      if (.not. contacts%retained(c) > 0.0_wp .and. contacts%state(c) /= contact_slide) return
      springs = springs_alone(contacts, laws, c)
      if (contacts%state(c) == contact_slide) forces(2) = contacts%slide_force(c) &
         - springs(2)*contacts%retained_at(c)
      if (contacts%state(c) == contact_open) &
         forces = [springs(1)*(contacts%retained_at(c) - contacts%gap(c)), 0.0_wp]
   end function forces_alone

end module dda_contact_terms
