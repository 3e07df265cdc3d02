! SPDX-License-Identifier: GPL-3.0-or-later
!> The laws of the joints of a model, and what they make of its contacts: forces at a trial d, and
!> states at the end of a step.
!>
!> The normal spring acts exactly in penetration, without a dead band: its potential is convex, so
!> it cannot create energy.  The shear force is elastic in the slip since the contact stuck, up to
!> a bound that follows the normal force of the same iteration.
module dda_friction
   use dda_kinds, only: wp, pi
   use dda_contact, only: contacts_type, contact_slide, is_carried, is_struck
   use dda_coulomb, only: coulomb_contact_type, respond, bound_friction
   use dda_joint_bond, only: accept_bond, add_bond, is_cohesive, slider_stretch
   use dda_joint_contact, only: response_type, state_of, joint_response, acts_before_end, &
      opens_at_centre, slip_lifts
   use dda_joint_law, only: joint_state_type
   use dda_joint_laws, only: law_slot_type, new_joint_law
   use dda_material, only: joint_type
   use dda_ordered_sums, only: pieces, first_of, last_of, parallel_from
   implicit none
   private
   public :: laws_type, set_laws, weaker_joint, law_of, find_response, acting_gap, acting_stretch, &
      end_stretch, accept_contacts, acts_at_theta, shear_stiffness_of, inelastic_slip, &
      slip_counts, bond_length_of, multiplier_of

   !> Stiffness of all contacts and strength of each joint material.
   type :: laws_type
      real(wp) :: normal_stiffness = 0.0_wp     !< k_n, N/m per metre of thickness
      real(wp) :: shear_stiffness = 0.0_wp      !< k_s, N/m per metre of thickness
      logical :: augmented = .false.            !< augmented Lagrangian: with multipliers
      real(wp) :: theta = 1.0_wp                !< share of the step at which bonded joints act
      logical :: damped = .false.               !< some joints are, see dda_contact_damping
      real(wp), allocatable :: restitution(:)   !< [joints] of impacts; negative: not prescribed
      real(wp), allocatable :: damping(:)       !< [joints] normal dashpot, N s/m per metre
      real(wp), allocatable :: friction_angle(:) !< [joints] φ, degrees
      real(wp), allocatable :: friction(:)      !< [joints] tan φ
      real(wp), allocatable :: cohesion(:)      !< [joints] Pa
      real(wp), allocatable :: tension(:)       !< [joints] Pa
      logical :: plain = .true.                 !< no joint has a law but Coulomb's, as above
      logical :: dilating = .false.             !< slip lifts contacts of some joint
      logical :: curved = .false.               !< so does closure the normal stiffness
      logical :: with_net_slip = .false.        !< some law asks for the way of slip
      logical :: cohesive = .false.             !< some law has bonds that are damaged
      integer, allocatable :: points(:)         !< [joints] contacts of an overlap: 2, 3 or 5
      logical :: pointed = .false.              !< of some joint more than the two at its ends
      type(law_slot_type), allocatable :: slot(:)  !< [joints] if not plain
   end type laws_type

contains

   subroutine set_laws(laws, joints, normal_stiffness, shear_ratio)
      type(laws_type), intent(out) :: laws      !< not augmented
      type(joint_type), intent(in) :: joints(:) !< [joints] joint materials
      real(wp), intent(in) :: normal_stiffness  !< k_n, N/m per metre of thickness
      real(wp), intent(in) :: shear_ratio       !< k_n / k_s
      integer :: j

      laws%normal_stiffness = normal_stiffness
      laws%shear_stiffness = normal_stiffness/shear_ratio
      laws%friction_angle = joints%friction_angle
      laws%friction = tan(joints%friction_angle*pi/180.0_wp)
      laws%cohesion = joints%cohesion
      laws%tension = joints%tensile_strength
      laws%restitution = joints%restitution
      laws%damping = joints%damping
      laws%points = joints%contact_points
      laws%pointed = any(laws%points > 2)
      laws%damped = any(joints%restitution >= 0.0_wp .or. joints%damping > 0.0_wp)
      do j = 1, size(joints)
         laws%plain = laws%plain .and. joints(j)%is_plain()
      end do
      if (laws%plain) return
      allocate (laws%slot(size(joints)))
      do j = 1, size(joints)
         call new_joint_law(laws%slot(j), joints(j), normal_stiffness, shear_ratio)
         laws%dilating = laws%dilating .or. laws%slot(j)%law%dilates
         laws%curved = laws%curved .or. laws%slot(j)%law%curved
         laws%with_net_slip = laws%with_net_slip .or. laws%slot(j)%law%has_centre &
            .or. laws%slot(j)%law%cohesive
         laws%cohesive = laws%cohesive .or. laws%slot(j)%law%cohesive
      end do
   end subroutine set_laws

   !> The weaker of two joint materials, which governs where they meet: that of less friction; of
   !> equal ones that of less cohesion, then of less tensile strength, then the first.
   pure integer function weaker_joint(laws, a, b) result(weaker)
      type(laws_type), intent(in) :: laws  !< strengths of the joint materials
      integer, intent(in) :: a, b          !< joint materials

      weaker = a
      if (a == b) return
      if (laws%friction_angle(a) /= laws%friction_angle(b)) then
         if (laws%friction_angle(b) < laws%friction_angle(a)) weaker = b
      else if (laws%cohesion(a) /= laws%cohesion(b)) then
         if (laws%cohesion(b) < laws%cohesion(a)) weaker = b
      else if (laws%tension(a) /= laws%tension(b)) then
         if (laws%tension(b) < laws%tension(a)) weaker = b
      else
         weaker = min(a, b)
      end if
   end function weaker_joint

   !> The law of a contact of a joint material.
   pure function law_of(laws, joint, bonded, length, multiplier) result(law)
      type(laws_type), intent(in) :: laws     !< stiffness, and strengths of the joint materials
      integer, intent(in) :: joint            !< joint material
      logical, intent(in) :: bonded           !< the bond is not broken
      real(wp), intent(in) :: length          !< m, that the bond acts on
      real(wp), intent(in) :: multiplier      !< N/m, of the augmented Lagrangian, else 0
      type(coulomb_contact_type) :: law

      law = coulomb_contact_type(laws%normal_stiffness, laws%shear_stiffness, multiplier, &
         laws%friction(joint), 0.0_wp, 0.0_wp, bonded)
      if (.not. bonded) return
      law%cohesion_force = laws%cohesion(joint)*length
      law%tension_force = laws%tension(joint)*length
   end function law_of

   !> Length that the bond of contact c acts on, m; 0 in a model without strengths.
   pure real(wp) function bond_length_of(contacts, c) result(length)
      type(contacts_type), intent(in) :: contacts  !< this step's list
      integer, intent(in) :: c                     !< number of the contact

      length = 0.0_wp
      if (contacts%with_strengths) length = contacts%bond_length(c)
   end function bond_length_of

   !> Multiplier of contact c, N/m; 0 in a model without an augmented Lagrangian.
   pure real(wp) function multiplier_of(contacts, c) result(multiplier)
      type(contacts_type), intent(in) :: contacts  !< this step's list
      integer, intent(in) :: c                     !< number of the contact

      multiplier = 0.0_wp
      if (contacts%with_multipliers) multiplier = contacts%multiplier(c)
   end function multiplier_of

   !> Forces of contact c if the step ends at a gap and a trial stretch.
   pure subroutine find_response(contacts, laws, c, gap, stretch, response)
      type(contacts_type), intent(in) :: contacts  !< this step's list
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c        !< number of the contact
      real(wp), intent(in) :: gap     !< at the end of the step, m
      real(wp), intent(in) :: stretch !< of the shear spring if nothing slips, then, m
      type(response_type), intent(out) :: response  !< state and forces
      real(wp) :: at_gap, at_stretch  ! where it acts, m

      at_gap = acting_gap(contacts, laws, c, gap)
      at_stretch = acting_stretch(contacts, laws, c, stretch)
      if (.not. laws%plain) then
         associate (law => laws%slot(contacts%joint(c))%law)
            response = joint_response(contacts, law, c, at_gap, at_stretch)
            if (is_cohesive(contacts, law, c)) call add_bond(contacts, law, c, laws%theta, gap, &
               stretch, response)
         end associate
         return
      end if
      call respond(law_of(laws, contacts%joint(c), contacts%bonded(c), &
         bond_length_of(contacts, c), multiplier_of(contacts, c)), at_gap, at_stretch, response)
      if (allocated(contacts%held_bound) .and. .not. contacts%bonded(c)) call bound_friction( &
         response, contacts%held_bound(c), laws%shear_stiffness*at_stretch)
   end subroutine find_response

   !> Contact c acts at t₀ + θΔt, θ < 1: it is bonded, and a law of its own lets it.
   elemental logical function acts_at_theta(contacts, laws, c) result(acts)
      type(contacts_type), intent(in) :: contacts  !< this step's list
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c         !< number of the contact

      acts = contacts%bonded(c) .and. laws%theta < 1.0_wp
      if (acts .and. .not. laws%plain) &
         acts = acts_before_end(laws%slot(contacts%joint(c))%law, contacts%weakened(c))
   end function acts_at_theta

   !> Shear stiffness of contact c, N/m.
   elemental real(wp) function shear_stiffness_of(contacts, laws, c) result(stiffness)
      type(contacts_type), intent(in) :: contacts  !< this step's list
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c         !< number of the contact

      stiffness = laws%shear_stiffness
      if (.not. laws%plain) stiffness = &
         laws%slot(contacts%joint(c))%law%shear_spring(state_of(contacts, c))
   end function shear_stiffness_of

   !> The trial stretch at which contact c acts, m.
   elemental real(wp) function acting_stretch(contacts, laws, c, stretch)
      type(contacts_type), intent(in) :: contacts  !< this step's list
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c         !< number of the contact
      real(wp), intent(in) :: stretch  !< at the end of the step, m

      acting_stretch = stretch
      if (contacts%bonded(c)) then
         if (acts_at_theta(contacts, laws, c)) &
            acting_stretch = contacts%stretch(c) + laws%theta*(stretch - contacts%stretch(c))
      else if (laws%damped) then
         acting_stretch = contacts%stretch(c) + contacts%shear_gain(c) &
            *(stretch - contacts%stretch(c)) + contacts%shear_shift(c)
      end if
   end function acting_stretch

   !> The gap at which contact c acts, m.
   elemental real(wp) function acting_gap(contacts, laws, c, gap)
      type(contacts_type), intent(in) :: contacts  !< this step's list
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c     !< number of the contact
      real(wp), intent(in) :: gap  !< at the end of the step, m

      acting_gap = gap
      if (contacts%bonded(c)) then
         if (acts_at_theta(contacts, laws, c)) &
            acting_gap = contacts%gap(c) + laws%theta*(gap - contacts%gap(c))
      else if (laws%damped) then
         acting_gap = contacts%gap(c) + contacts%normal_gain(c)*(gap - contacts%gap(c)) &
            + contacts%normal_shift(c)
      end if
   end function acting_gap

   !> Elastic stretch of the shear spring of contact c after the converged step, m.  Impacts are no
   !> force of springs.
   elemental real(wp) function end_stretch(contacts, laws, c)
      type(contacts_type), intent(in) :: contacts  !< this step's list
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c  !< number of the contact

      end_stretch = contacts%shear_force(c)/shear_stiffness_of(contacts, laws, c)
      if (acts_at_theta(contacts, laws, c)) &
         end_stretch = contacts%stretch(c) + contacts%slip(c)
      if (laws%cohesive) then
         associate (law => laws%slot(contacts%joint(c))%law)
            if (is_cohesive(contacts, law, c)) end_stretch = slider_stretch(contacts, law, c)
         end associate
      end if
      if (.not. laws%damped) return
      if (contacts%damping(c) < is_struck) return
      end_stretch = 0.0_wp
      if (contacts%damping(c) == is_carried .and. contacts%normal_force(c) > 0.0_wp) &
         end_stretch = contacts%stretch(c)
   end function end_stretch

   !> States and stretches at the end of the converged step.
   subroutine accept_contacts(contacts, laws)
      type(contacts_type), intent(inout) :: contacts  !< this step's list
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer :: p

      if (contacts%n < parallel_from) then
         call accept_range(contacts, laws, 1, contacts%n)
         return
      end if
      !$omp parallel do schedule(static)
      do p = 1, pieces(contacts%n)
         call accept_range(contacts, laws, first_of(p, contacts%n), last_of(p, contacts%n))
      end do
   end subroutine accept_contacts

   !> Contacts first … last.
   pure subroutine accept_range(contacts, laws, first, last)
      type(contacts_type), intent(inout) :: contacts  !< this step's list
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: first, last  !< of the range
      real(wp) :: stretch
      integer :: c

      do c = first, last
         stretch = end_stretch(contacts, laws, c)
         if (.not. laws%plain) then
            associate (law => laws%slot(contacts%joint(c))%law)
               if (is_cohesive(contacts, law, c)) then
                  call accept_bond(contacts, law, c)
               else if (slip_counts(contacts, laws, c)) then
                  call accept_slip(contacts, laws, c)
               end if
            end associate
         end if
         contacts%stretch(c) = stretch
         contacts%state(c) = contacts%trial_state(c)
      end do
   end subroutine accept_range

   !> Slip of contact c beyond the elastic one, and how far it has weakened the contact.
   pure subroutine accept_slip(contacts, laws, c)
      type(contacts_type), intent(inout) :: contacts  !< this step's list
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c  !< number of the contact

      type(joint_state_type) :: state

      state = laws%slot(contacts%joint(c))%law%slipped(state_of(contacts, c), &
         inelastic_slip(contacts, laws, c), contacts%shear_force(c))
      contacts%slip_path(c) = state%slip_path
      contacts%weakened(c) = state%weakened
      if (.not. contacts%with_net_slip) return
      contacts%net_slip(c) = state%net_slip
      contacts%lifted(c) = state%lifted
   end subroutine accept_slip

   !> Slip of contact c beyond the elastic one counts in the converged step, under a joint law.
   pure logical function slip_counts(contacts, laws, c)
      type(contacts_type), intent(in) :: contacts  !< this step's list
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c  !< number of the contact

      associate (law => laws%slot(contacts%joint(c))%law)
         slip_counts = contacts%trial_state(c) == contact_slide
         if (slip_counts .and. law%dilates) slip_counts = slip_lifts(contacts, law, c)
         if (slip_counts .or. .not. contacts%with_net_slip) return
         slip_counts = contacts%trial_past_centre(c)
         if (.not. slip_counts) slip_counts = opens_at_centre(contacts, law, c)
      end associate
   end function slip_counts

   !> Slip of contact c in the converged step beyond that of its shear spring, m.
   pure real(wp) function inelastic_slip(contacts, laws, c)
      type(contacts_type), intent(in) :: contacts  !< this step's list
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c         !< number of the contact

      inelastic_slip = contacts%slip(c) - (end_stretch(contacts, laws, c) - contacts%stretch(c))
   end function inelastic_slip

end module dda_friction
