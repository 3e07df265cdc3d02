! SPDX-License-Identifier: GPL-3.0-or-later
!> Joint laws applied to the contacts of a model: forces at a trial d, and states at the end of
!> a step.
!>
!> The normal spring acts exactly in penetration.  Its potential is convex, so it cannot create
!> energy.  The shear force is proportional to the slip since the contact began
!> to stick, up to a bound that depends on the normal force of the same iteration.
module dda_friction
   use dda_kinds, only: wp, pi
   use dda_contact, only: contacts_type, contact_open, contact_slide, is_carried, is_struck
   use dda_coulomb, only: coulomb_contact_type, respond
   use dda_joint_bond, only: add_bond, bond_after, is_cohesive, slider_stretch
   use dda_joint_contact, only: assumed_state, frozen_friction, joint_bound, joint_response, &
      joint_slide, limit_friction, store_state, state_of
   use dda_joint_law, only: add_columns, column_type, joint_state_type, response_type, shared, &
      weakened
   use dda_joint_laws, only: law_slot_type, create_joint_law
   use dda_material, only: joint_type
   use dda_ordered_sums, only: pieces, first_of, last_of, parallel_from
   implicit none
   private
   public :: laws_type, set_laws, weaker_joint, law_of, find_response, acting, &
      end_stretch, accept_contacts, acts_at_theta, shear_stiffness_of, inelastic_slip, &
      slip_counts, bond_length_of, multiplier_of, find_bound, frozen_bound_of, slide_response, &
      closed_springs, same_branch, start_force, is_simple

   real(wp), parameter :: round_off = 1.0e-9_wp  !< ignored slip/stretch

   !> Stiffness of all contacts and strength of each joint material.
   type :: laws_type
      real(wp) :: normal_stiffness = 0.0_wp     !< k_n, N/m per metre of thickness
      real(wp) :: shear_stiffness = 0.0_wp      !< k_s, N/m per metre of thickness
      logical :: augmented = .false.            !< contacts have multipliers (augmented Lagrangian)
      real(wp) :: theta = 1.0_wp            !< θ, 0 … 1: bonded joints act at t₀ + θΔt
      logical :: damped = .false.    !< some joints have damping or impacts, see dda_contact_damping
      real(wp), allocatable :: restitution(:)   !< [joints] restitution; negative: not prescribed
      real(wp), allocatable :: damping(:)       !< [joints] normal dashpot, N s/m per metre
      real(wp), allocatable :: friction_angle(:) !< [joints] φ, degrees
      real(wp), allocatable :: friction(:)      !< [joints] tan φ
      real(wp), allocatable :: cohesion(:)      !< [joints] Pa
      real(wp), allocatable :: tension(:)       !< [joints] Pa
      logical :: plain = .true.                 !< all joints have Coulomb's law
      logical :: dilating = .false.             !< slip of some joint lifts its contacts
      logical :: curved = .false.               !< the friction of some joint is a curve of slip
      logical :: with_net_slip = .false.        !< some law depends on the direction of slip
      logical :: cohesive = .false.             !< some law has bonds with damage
      integer, allocatable :: points(:)         !< [joints] contacts of an overlap: 2, 3, 5, 9 or 17
      logical :: pointed = .false.              !< a joint has more than two contact points
      type(column_type), allocatable :: columns(:) !< variables that laws store per contact
      type(law_slot_type), allocatable :: slot(:)  !< [joints] law of each joint
   end type laws_type

contains

   !> Set stiffness and strength of contacts from the joint materials.
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
      allocate (laws%slot(size(joints)))
      do j = 1, size(joints)
         call create_joint_law(laws%slot(j), joints(j), normal_stiffness, shear_ratio)
         laws%dilating = laws%dilating .or. laws%slot(j)%law%dilates
         laws%curved = laws%curved .or. laws%slot(j)%law%curved .or. laws%slot(j)%law%has_slip_curve
         laws%with_net_slip = laws%with_net_slip .or. laws%slot(j)%law%depends_on_direction()
         laws%cohesive = laws%cohesive .or. laws%slot(j)%law%cohesive
      end do
      laws%columns = shared(:merge(3, 2, laws%with_net_slip))
      do j = 1, size(joints)
         call add_columns(laws%columns, laws%slot(j)%law)
      end do
   end subroutine set_laws

   !> Find the weaker of two joint materials, which governs a contact between them.
   !> The weaker one has less friction; if equal, less cohesion; then less tension; then the lower
   !> number.
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

   !> Return the law of a contact, from its joint material.
   pure function law_of(laws, joint, bonded, length, multiplier) result(law)
      type(laws_type), intent(in) :: laws     !< stiffness, and strengths of the joint materials
      integer, intent(in) :: joint            !< joint material
      logical, intent(in) :: bonded           !< the bond is intact
      real(wp), intent(in) :: length          !< bonded length, m
      real(wp), intent(in) :: multiplier      !< multiplier of the augmented Lagrangian, N/m, else 0
      type(coulomb_contact_type) :: law

      law = coulomb_contact_type(laws%normal_stiffness, laws%shear_stiffness, multiplier, &
         laws%friction(joint), 0.0_wp, 0.0_wp, bonded)
      if (.not. bonded) return
      law%cohesion_force = laws%cohesion(joint)*length
      law%tension_force = laws%tension(joint)*length
   end function law_of

   !> Return the bonded length of contact c, m; 0 in a model without strengths.
   pure real(wp) function bond_length_of(contacts, c) result(length)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      integer, intent(in) :: c                     !< number of the contact

      length = 0.0_wp
      if (contacts%with_strengths) length = contacts%bond_length(c)
   end function bond_length_of

   !> Return the multiplier of contact c, N/m; 0 in a model without an augmented Lagrangian.
   pure real(wp) function multiplier_of(contacts, c) result(multiplier)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      integer, intent(in) :: c                     !< number of the contact

      multiplier = 0.0_wp
      if (contacts%with_multipliers) multiplier = contacts%multiplier(c)
   end function multiplier_of

   !> Return the normal force of the linearised law of contact c at the initial gap, N/m.
   pure real(wp) function start_force(contacts, laws, c) result(force)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c        !< number of the contact

      force = multiplier_of(contacts, c) - laws%normal_stiffness*contacts%gap(c)
      if (.not. laws%plain) force = contacts%line(1, c) - contacts%tangent(1, c)*contacts%gap(c)
   end function start_force

   !> Find the forces of contact c for a gap and a trial stretch at the end of the step.
   pure subroutine find_response(contacts, laws, c, gap, stretch, response)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c        !< number of the contact
      real(wp), intent(in) :: gap     !< gap at the end of the step, m
      real(wp), intent(in) :: stretch !< stretch at the end of the step without slip, m
      type(response_type), intent(out) :: response  !< state and forces
      real(wp) :: at(2)  ! gap and stretch at which the contact acts, m

      at = acting(contacts, laws, c, [gap, stretch])
      if (.not. laws%plain) then
         associate (law => laws%slot(contacts%joint(c))%law)
            response = joint_response(law, state_of(contacts, law, c), at(1), at(2))
            if (is_cohesive(contacts, law, c)) call add_bond(contacts, law, c, laws%theta, gap, &
               stretch, response)
         end associate
         return
      end if
      call respond(law_of(laws, contacts%joint(c), contacts%bonded(c), &
         bond_length_of(contacts, c), multiplier_of(contacts, c)), at(1), at(2), response)
      if (allocated(contacts%frozen_bound) .and. .not. contacts%bonded(c)) call limit_friction( &
         response, contacts%frozen_bound(c), laws%shear_stiffness*at(2))
   end subroutine find_response

   !> Find the frozen quantities of contact c for the next pass, from the solution of the last one:
   !> the largest friction, and the fraction of the slip of the step that lifts the contact.
   elemental subroutine find_bound(contacts, laws, c, bound, lifting, difference)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step with trial forces
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c        !< number of the contact
      real(wp), intent(out) :: bound  !< N/m
      real(wp), intent(out) :: lifting  !< 0 … 1
      real(wp), intent(out) :: difference  !< of the forces from their law, N/m

      lifting = 1.0_wp
      difference = 0.0_wp
      if (laws%plain) then
         bound = laws%friction(contacts%joint(c))*max(0.0_wp, contacts%normal_force(c))
      else
         associate (law => laws%slot(contacts%joint(c))%law)
            call joint_bound(law, state_of(contacts, law, c), contacts%shear_force(c), &
               acting(contacts, laws, c, [contacts%new_gap(c), contacts%stretch(c) &
               + contacts%slip(c)]), bound, lifting, difference)
         end associate
      end if
   end subroutine find_bound

   !> Return the frozen friction of contact c in the direction of its assumed force, N/m.
   pure real(wp) function frozen_bound_of(contacts, laws, c) result(bound)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step, with frozen bounds
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c  !< number of the contact
      type(joint_state_type) :: state

      bound = contacts%frozen_bound(c)
      if (laws%plain) return
      associate (law => laws%slot(contacts%joint(c))%law)
         state = assumed_state(law, state_of(contacts, law, c))
         state%slip_sign = sign(1.0_wp, contacts%slide_force(c))
         bound = frozen_friction(law, state)
         if (law%has_slip_curve) bound = huge(bound)  ! the line of the curve applies at any force
      end associate
   end function frozen_bound_of

   !> Return the friction of contact c in the assumed direction without the part due to tilt, N/m.
   pure real(wp) function slide_response(contacts, laws, c, gap, stretch) result(friction)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c        !< number of the contact
      real(wp), intent(in) :: gap     !< gap at the end of the step, m
      real(wp), intent(in) :: stretch !< stretch at the end of the step without slip, m
      real(wp) :: at(2)

      if (.not. laws%plain) then
         friction = joint_slide(contacts, laws%slot(contacts%joint(c))%law, c, gap, stretch)
      else if (allocated(contacts%frozen_bound)) then
         friction = contacts%slip_sign(c)*contacts%frozen_bound(c)
      else
         at = acting(contacts, laws, c, [gap, stretch])
         friction = contacts%slip_sign(c)*laws%friction(contacts%joint(c))*max(0.0_wp, &
            multiplier_of(contacts, c) - laws%normal_stiffness*at(1))
      end if
   end function slide_response

   !> Return the normal and shear stiffness of contact c if it is closed and sticks, N/m.
   pure function closed_springs(contacts, laws, c) result(springs)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c        !< number of the contact
      real(wp) :: springs(2)

      springs = [laws%normal_stiffness, laws%shear_stiffness]
      if (.not. laws%plain) springs = contacts%tangent(:, c)
   end function closed_springs

   !> .true. if the forces of contact c are linear in the displacement between two responses.
   pure logical function same_branch(contacts, laws, c, a, b)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c        !< number of the contact
      type(response_type), intent(in) :: a, b  !< responses at both ends of a straight path

      same_branch = a%state == b%state .and. .not. (a%state == contact_slide .and. &
         a%slider*b%slider < 0.0_wp)
      if (laws%plain .or. .not. same_branch) return
      associate (law => laws%slot(contacts%joint(c))%law)
         same_branch = .not. (law%curved .or. law%dilates .or. law%has_slip_curve)
      end associate
   end function same_branch

   !> .true. if all joints are Coulomb joints whose contacts act at the end of the step, undamped.
   !> Tests of each contact for other features would take 5 % of the time of a quiet wall.
   pure logical function is_simple(laws)  ! total
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts

      is_simple = laws%plain .and. laws%theta >= 1.0_wp .and. .not. (laws%damped .or. laws%cohesive)
   end function is_simple

   !> .true. if contact c acts at t₀ + θΔt, θ < 1: it is bonded and cannot slip or crush.
   elemental logical function acts_at_theta(contacts, laws, c) result(acts)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c         !< number of the contact

      acts = contacts%bonded(c) .and. laws%theta < 1.0_wp
      if (laws%plain .or. .not. acts) return
      associate (law => laws%slot(contacts%joint(c))%law)
         acts = law%brittle .and. .not. law%crushes .and. contacts%memory(weakened, c) < 1.0_wp
      end associate
   end function acts_at_theta

   !> Return the shear stiffness of contact c, N/m.
   elemental real(wp) function shear_stiffness_of(contacts, laws, c) result(stiffness)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c         !< number of the contact

      stiffness = laws%shear_stiffness
      if (laws%plain) return
      associate (law => laws%slot(contacts%joint(c))%law)
         stiffness = law%shear_spring(state_of(contacts, law, c))
      end associate
   end function shear_stiffness_of

   !> Return the gap and trial stretch, m, at which the law of contact c is evaluated.
   pure function acting(contacts, laws, c, trial)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c           !< number of the contact
      real(wp), intent(in) :: trial(2)   !< gap and stretch at the end of the step, m
      real(wp) :: acting(2)

      acting = trial
      if (contacts%bonded(c)) then
         if (acts_at_theta(contacts, laws, c)) acting = [contacts%gap(c), contacts%stretch(c)] &
            + laws%theta*(trial - [contacts%gap(c), contacts%stretch(c)])
      else if (laws%damped) then
         acting = [contacts%gap(c), contacts%stretch(c)] + contacts%gain(:, c) &
            *(trial - [contacts%gap(c), contacts%stretch(c)]) + contacts%shift(:, c)
      end if
   end function acting

   !> Return the elastic stretch of the shear spring of contact c after the converged step, m.
   !> Impact forces are excluded, because they do not act in the spring.
   elemental real(wp) function end_stretch(contacts, laws, c)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c  !< number of the contact

      end_stretch = contacts%shear_force(c)/shear_stiffness_of(contacts, laws, c)
      if (acts_at_theta(contacts, laws, c)) end_stretch = contacts%stretch(c) + contacts%slip(c)
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

   !> Update states and stretches of contacts at the end of the converged step.
   subroutine accept_contacts(contacts, laws)
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer :: p

      if (contacts%n < parallel_from) then
         call accept_contacts_range(contacts, laws, 1, contacts%n)
         return
      end if
      !$omp parallel do schedule(static)
      do p = 1, pieces(contacts%n)
         call accept_contacts_range(contacts, laws, first_of(p, contacts%n), last_of(p, contacts%n))
      end do
   end subroutine accept_contacts

   !> Update states and stretches of contacts first … last.
   pure subroutine accept_contacts_range(contacts, laws, first, last)
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: first, last  !< first and last contact
      real(wp) :: stretch, slip
      logical :: counts
      integer :: c

      if (is_simple(laws)) then
         contacts%state(first:last) = contacts%trial_state(first:last)
         contacts%stretch(first:last) = contacts%shear_force(first:last)/laws%shear_stiffness
         return
      end if
      do c = first, last
         stretch = end_stretch(contacts, laws, c)
         if (.not. laws%plain) then
            associate (law => laws%slot(contacts%joint(c))%law)
               if (is_cohesive(contacts, law, c)) then
                  call store_state(contacts, law, c, bond_after(contacts, law, c))
                  contacts%bonded(c) = contacts%memory(weakened, c) < 1.0_wp
               else
                  slip = 0.0_wp
                  counts = slip_counts(contacts, laws, c)
                  if (counts) slip = inelastic_slip(contacts, laws, c)
                  if (counts .or. law%crushes) call store_state(contacts, law, c, &
                     law%state_after_slip(state_of(contacts, law, c), slip, &
                     contacts%shear_force(c)))
               end if
            end associate
         end if
         contacts%state(c) = contacts%trial_state(c)
         if (laws%curved) then
            if (slip_is_inelastic(contacts, laws, c, stretch)) contacts%state(c) = contact_slide
         end if
         contacts%stretch(c) = stretch
      end do
   end subroutine accept_contacts_range

   !> .true. if friction is a curve of slip and most of the slip of contact c is inelastic.
   pure logical function slip_is_inelastic(contacts, laws, c, stretch)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c         !< number of the contact
      real(wp), intent(in) :: stretch  !< stretch of the shear spring at the end of the step, m
      real(wp) :: inelastic

      inelastic = contacts%slip(c) - (stretch - contacts%stretch(c))
      slip_is_inelastic = laws%slot(contacts%joint(c))%law%has_slip_curve .and. &
         contacts%trial_state(c) /= contact_open .and. abs(inelastic) > &
         max(0.5_wp*abs(contacts%slip(c)), round_off*abs(stretch))
   end function slip_is_inelastic

   !> .true. if the inelastic slip of contact c changes the state of its law.
   pure logical function slip_counts(contacts, laws, c)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c  !< number of the contact

      associate (law => laws%slot(contacts%joint(c))%law)
         slip_counts = contacts%trial_state(c) == contact_slide .or. &
            (law%has_slip_curve .and. contacts%trial_state(c) /= contact_open)
         if (slip_counts .and. law%dilates) slip_counts = contacts%was_closed(c)
         if (slip_counts .or. .not. contacts%with_net_slip) return
         ! A contact may open while slip returns to zero net slip.
         slip_counts = contacts%trial_past_centre(c) .or. (law%has_centre .and. &
            contacts%was_closed(c) .and. contacts%trial_state(c) == contact_open)
      end associate
   end function slip_counts

   !> Return the inelastic slip of contact c in the converged step, m.
   pure real(wp) function inelastic_slip(contacts, laws, c)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c         !< number of the contact

      inelastic_slip = contacts%slip(c) - (end_stretch(contacts, laws, c) - contacts%stretch(c))
   end function inelastic_slip

end module dda_friction
