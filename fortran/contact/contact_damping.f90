! SPDX-License-Identifier: GPL-3.0-or-later
!> Dashpots of unbonded contacts, and the impact law: how a contact acts in a step where its joint
!> has a `restitution` or a `damping`.
!>
!> Each way is an affine change of the gap and the stretch that the springs see,
!>
!>     acting gap = gap₀ + gain·(gap₁ − gap₀) + shift ,   N = max(0, −k_n × acting gap) ,
!>
!> so that laws, open–close iteration and line search stay as they are, with a potential that is
!> still convex.
!>
!> *Damped*: the spring acts at z = gap + lead × velocity of the gap, lead = (1 − χ)Δt, and
!> z₁ = z₀ + Δt × velocity at the end: backward Euler in z, with roots 0, 0 for stiff contacts.  It
!> is the dashpot that supports have, its force never tensile.  A `damping` adds a dashpot on the
!> velocity at the end.  *Struck*: the velocity of the gap at the end is at least `target`.
!> *Carried*: it is at least 0, on top of the force that the contact had; sticking contacts do not
!> slip.  *Lifted*: it opens, and has its force for the share of the step before the impact.
module dda_contact_damping
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type
   use dda_contact, only: contacts_type, not_damped, is_damped, is_struck, is_carried, is_lifted
   use dda_contact_gradients, only: find_rows, relative_motion, rows_type
   use dda_friction, only: end_stretch, laws_type
   use dda_ordered_sums, only: pieces, first_of, last_of, parallel_from
   use dda_scheme, only: step_type, end_rate, momentum_weight, velocity_weight
   implicit none
   private
   public :: losses_type, damp_contacts, find_static_forces, strike, carry, lift, is_approached, &
      softness_of, spring_energy, losses_of

   !> of the way of a step: a contact pressed by less than this is being closed, not at rest
   real(wp), parameter :: just_touched = 0.25_wp
   !> stiffness of the impact law over M/(χΔt²): what a velocity misses of its target
   real(wp), parameter :: rigidity = 1.0e5_wp

   !> Energy of a contact at the end of a step, and what it has lost in it, J per metre.
   type :: losses_type
      real(wp) :: stored = 0.0_wp       !< in its springs
      real(wp) :: friction = 0.0_wp     !< by slip
      real(wp) :: damping = 0.0_wp      !< in dashpots
      real(wp) :: impact = 0.0_wp       !< in impacts, with their friction
      real(wp) :: algorithmic = 0.0_wp  !< by the time integration
   end type losses_type

contains

   !> Dashpots of all contacts in the step to come, before any is struck.
   subroutine damp_contacts(contacts, laws, blocks, step)
      type(contacts_type), intent(inout) :: contacts  !< this step's list, with joints
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      type(blocks_type), intent(in) :: blocks  !< in their present state
      type(step_type), intent(in) :: step  !< the one to come
      integer :: p

      if (contacts%n < parallel_from) then
         call damp_range(contacts, laws, blocks, step, 1, contacts%n)
         return
      end if
      !$omp parallel do schedule(static)
      do p = 1, pieces(contacts%n)
         call damp_range(contacts, laws, blocks, step, first_of(p, contacts%n), &
            last_of(p, contacts%n))
      end do
   end subroutine damp_contacts

   !> Contacts first … last.
   pure subroutine damp_range(contacts, laws, blocks, step, first, last)
      type(contacts_type), intent(inout) :: contacts  !< this step's list, with joints
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      type(blocks_type), intent(in) :: blocks  !< in their present state
      type(step_type), intent(in) :: step  !< the one to come
      integer, intent(in) :: first, last  !< of the range
      real(wp) :: rate(2)
      integer :: c

      do c = first, last
         rate = relative_motion(contacts, c, blocks%velocity(:, contacts%block_v(c)), &
            blocks%velocity(:, contacts%block_e(c)))
         contacts%gap_rate(c) = rate(1)
         contacts%slip_rate(c) = rate(2)
         contacts%damping(c) = not_damped
         contacts%lead(c) = 0.0_wp
         contacts%spring_gap(c) = contacts%gap(c)
         contacts%normal_gain(c) = 1.0_wp
         contacts%shear_gain(c) = 1.0_wp
         contacts%normal_shift(c) = 0.0_wp
         contacts%shear_shift(c) = 0.0_wp
         if (.not. contacts%bonded(c)) call damp(contacts, laws, step, c)
      end do
   end subroutine damp_range

   !> The dashpots of an unbonded contact.
   pure subroutine damp(contacts, laws, step, c)
      type(contacts_type), intent(inout) :: contacts  !< this step's list
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      type(step_type), intent(in) :: step  !< the one to come
      integer, intent(in) :: c  !< number of the contact
      real(wp) :: tau, behind

      associate (rate => contacts%gap_rate(c), gap => contacts%gap(c), j => contacts%joint(c))
         behind = velocity_weight(step)*step%time_step
         if (laws%restitution(j) >= 0.0_wp) then
            contacts%damping(c) = is_damped
            contacts%lead(c) = (1.0_wp - step%scheme%chi)*step%time_step
            contacts%spring_gap(c) = gap + contacts%lead(c)*rate
            ! A velocity that the contact has not yet felt is no compression of its spring.
            if (is_approached(contacts, step, c)) contacts%spring_gap(c) &
               = max(contacts%spring_gap(c), min(gap, 0.0_wp))
            contacts%normal_gain(c) = 1.0_wp/step%scheme%chi
            contacts%shear_gain(c) = 1.0_wp/step%scheme%chi
            contacts%normal_shift(c) = contacts%spring_gap(c) - gap - behind*rate
            contacts%shear_shift(c) = -behind*contacts%slip_rate(c)
         end if
         if (.not. laws%damping(j) > 0.0_wp) return
         contacts%damping(c) = is_damped
         tau = laws%damping(j)/laws%normal_stiffness
         contacts%normal_gain(c) = contacts%normal_gain(c) + momentum_weight(step)*tau
         contacts%normal_shift(c) = contacts%normal_shift(c) - velocity_weight(step)*tau*rate
      end associate
   end subroutine damp

   !> After the converged step: the normal forces of contacts without those of impacts.
   pure subroutine find_static_forces(contacts)
      type(contacts_type), intent(inout) :: contacts  !< this step's list, solved
      integer :: c

      do c = 1, contacts%n
         select case (contacts%damping(c))
         case (is_struck, is_lifted)
            contacts%static_force(c) = 0.0_wp
         case (is_carried)
            contacts%static_force(c) = min(contacts%static_force(c), contacts%normal_force(c))
         case default
            contacts%static_force(c) = max(0.0_wp, contacts%normal_force(c))
         end select
      end do
   end subroutine find_static_forces

   !> The contact closes at a velocity that its spring has not yet felt.
   pure logical function is_approached(contacts, step, c)
      type(contacts_type), intent(in) :: contacts  !< this step's list, with rates
      type(step_type), intent(in) :: step  !< the one being taken
      integer, intent(in) :: c  !< number of the contact

      is_approached = contacts%gap_rate(c) < 0.0_wp .and. &
         contacts%gap(c) >= just_touched*step%time_step*contacts%gap_rate(c)
   end function is_approached

   !> The contact is hit: its gap leaves the step at a velocity of at least `target`.
   !>
   !> One that only goes to its touch in this step, target = −z₀/Δt, takes the share
   !> α = 1 − target/v⁻ of an impact that leaves Tᵀv⁺: friction is that of the whole impact, so the
   !> slip is to end at (1 − α) of its velocity.  The step after takes the rest, and both together
   !> what a single step would have taken, whatever α is.
   pure subroutine strike(contacts, laws, blocks, step, c, target)
      type(contacts_type), intent(inout) :: contacts  !< this step's list
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      type(blocks_type), intent(in) :: blocks  !< in their present state
      type(step_type), intent(in) :: step  !< the one being taken
      integer, intent(in) :: c  !< number of the contact
      real(wp), intent(in) :: target  !< m/s
      real(wp) :: gain, left

      gain = rigid_gain(contacts, laws, blocks, step, c)
      left = 0.0_wp
      if (target < 0.0_wp) left = target/contacts%gap_rate(c)
      contacts%damping(c) = is_struck
      contacts%normal_gain(c) = gain
      contacts%shear_gain(c) = gain
      contacts%normal_shift(c) = -contacts%gap(c) - gain*way_of(step, contacts%gap_rate(c), target)
      contacts%shear_shift(c) = -contacts%stretch(c) &
         - gain*way_of(step, contacts%slip_rate(c), left*contacts%slip_rate(c))
   end subroutine strike

   !> A closed contact of a block that is hit: it keeps its force and does not yield.
   pure subroutine carry(contacts, laws, blocks, step, c)
      type(contacts_type), intent(inout) :: contacts  !< this step's list
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      type(blocks_type), intent(in) :: blocks  !< in their present state
      type(step_type), intent(in) :: step  !< the one being taken
      integer, intent(in) :: c  !< number of the contact
      real(wp) :: gain

      gain = rigid_gain(contacts, laws, blocks, step, c)
      contacts%damping(c) = is_carried
      contacts%normal_gain(c) = gain
      contacts%shear_gain(c) = gain
      contacts%normal_shift(c) = -contacts%static_force(c)/laws%normal_stiffness - contacts%gap(c) &
         - gain*way_of(step, contacts%gap_rate(c), 0.0_wp)
      contacts%shear_shift(c) = -gain*way_of(step, contacts%slip_rate(c), 0.0_wp)
   end subroutine carry

   !> A contact that the impact opens: its force lasts for a share of the step.
   pure subroutine lift(contacts, laws, c, share)
      type(contacts_type), intent(inout) :: contacts  !< this step's list
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c  !< number of the contact
      real(wp), intent(in) :: share  !< of the step, before the impact

      contacts%damping(c) = is_lifted
      contacts%normal_gain(c) = 0.0_wp
      contacts%shear_gain(c) = 0.0_wp
      contacts%normal_shift(c) = -share*contacts%static_force(c)/laws%normal_stiffness &
         - contacts%gap(c)
      contacts%shear_shift(c) = (share - 1.0_wp)*contacts%stretch(c)
   end subroutine lift

   !> Way of a coordinate in a step between two velocities, m.
   pure real(wp) function way_of(step, first, last) result(way)
      type(step_type), intent(in) :: step  !< the one being taken
      real(wp), intent(in) :: first, last  !< m/s, at its start and its end

      way = step%time_step*((1.0_wp - step%scheme%chi)*first + step%scheme%chi*last)
   end function way_of

   !> Gain that makes the spring of a contact rigid beside the inertia of its two blocks.
   pure real(wp) function rigid_gain(contacts, laws, blocks, step, c) result(gain)
      type(contacts_type), intent(in) :: contacts  !< this step's list
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      type(blocks_type), intent(in) :: blocks  !< in their present state
      type(step_type), intent(in) :: step  !< the one being taken
      integer, intent(in) :: c  !< number of the contact

      gain = max(1.0_wp/step%scheme%chi, rigidity/(step%scheme%chi*step%time_step**2 &
         *softness_of(contacts, blocks, c)*laws%normal_stiffness))
   end function rigid_gain

   !> Inverse of the mass that a contact sees of its two blocks along its normal, 1/kg per metre.
   pure real(wp) function softness_of(contacts, blocks, c) result(softness)
      type(contacts_type), intent(in) :: contacts  !< any list
      type(blocks_type), intent(in) :: blocks      !< in any state
      integer, intent(in) :: c                     !< number of the contact
      type(rows_type) :: rows

      call find_rows(contacts, c, rows)
      softness = softness_along(blocks%inertia(:, contacts%block_v(c)), rows%normal_v) &
         + softness_along(blocks%inertia(:, contacts%block_e(c)), rows%normal_e)
   end function softness_of

   !> The same of one block, by its rigid motions.
   pure real(wp) function softness_along(inertia, row) result(softness)
      real(wp), intent(in) :: inertia(4)  !< as in `blocks_type`
      real(wp), intent(in) :: row(6)      !< ∂gap/∂q

      softness = sum(row(1:2)**2)/inertia(1) + row(3)**2/(inertia(2) + inertia(3))
   end function softness_along

   !> Stored in the springs of a damped contact at the start of the step, J per metre.
   pure real(wp) function spring_energy(contacts, laws, c) result(energy)
      type(contacts_type), intent(in) :: contacts  !< this step's list
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c  !< number of the contact

      energy = 0.5_wp*laws%normal_stiffness*min(contacts%spring_gap(c), 0.0_wp)**2 &
         + 0.5_wp*laws%shear_stiffness*contacts%stretch(c)**2
   end function spring_energy

   !> Energy of a damped contact at the end of the converged step, and its losses.
   !>
   !> An impulse takes its product with the mean velocity; what the scheme makes the way differ
   !> from that is algorithmic, and nothing where χ = ½.
   pure type(losses_type) function losses_of(contacts, laws, step, c) result(losses)
      type(contacts_type), intent(in) :: contacts  !< this step's list, solved
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      type(step_type), intent(in) :: step  !< the one being taken
      integer, intent(in) :: c  !< number of the contact
      real(wp) :: opened, gap_rate, slip_rate, stretch, lost

      associate (normal => contacts%normal_force(c), shear => contacts%shear_force(c), &
         slip => contacts%slip(c), before => contacts%stretch(c))
         opened = contacts%new_gap(c) - contacts%gap(c)
         gap_rate = end_rate(step, opened, contacts%gap_rate(c))
         slip_rate = end_rate(step, slip, contacts%slip_rate(c))
         stretch = end_stretch(contacts, laws, c)
         losses%stored = 0.5_wp*laws%normal_stiffness*min(contacts%new_gap(c) &
            + contacts%lead(c)*gap_rate, 0.0_wp)**2 + 0.5_wp*laws%shear_stiffness*stretch**2
         lost = spring_energy(contacts, laws, c) - losses%stored - normal*opened + shear*slip
         if (contacts%damping(c) >= is_struck) then
            losses%algorithmic = -(step%scheme%chi - 0.5_wp)*step%time_step &
               *(normal*(gap_rate - contacts%gap_rate(c)) &
               - shear*(slip_rate - contacts%slip_rate(c)))
            losses%impact = lost - losses%algorithmic
         else
            losses%friction = shear*(contacts%shear_gain(c)*slip + contacts%shear_shift(c) &
               - (stretch - before))
            losses%damping = lost - losses%friction
         end if
      end associate
   end function losses_of

end module dda_contact_damping
