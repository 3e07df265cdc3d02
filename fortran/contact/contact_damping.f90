! SPDX-License-Identifier: GPL-3.0-or-later
!> Dashpots and impact law of unbonded contacts in a step, if their joint has a `restitution`
!> or a `damping`.
!>
!> With both, gap and stretch of the springs are affine functions of the true values,
!>
!>     acting gap = gap₀ + gain·(gap₁ − gap₀) + shift ,   N = max(0, −k_n × acting gap) ,
!>
!> Laws, open–close iteration and line search then need no change, and the potential stays convex.
!>
!> *Damped*: the spring acts at z = gap + lead × velocity of the gap, lead = (1 − χ)Δt, and z₁ = z₀
!> + Δt × velocity at the end.  This is backward Euler in z; stiff contacts have two zero roots.
!> Supports have the same dashpot; at contacts its force is never tensile.  A `damping` adds a
!> dashpot on the velocity at the end.  *Struck*: the gap has at least the velocity `target` at the
!> end.  *Carried*: the gap does not close, the present contact force also acts, and a sticking
!> contact does not slip.  *Lifted*: the contact opens; its force acts during the part of the step
!> before the impact.
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

   !> ratio of penetration to approach in a step below which a closing contact has just touched
   real(wp), parameter :: just_touched = 0.25_wp
   !> stiffness of the impact law over M/(χΔt²); its inverse is the relative velocity error
   real(wp), parameter :: rigidity = 1.0e5_wp

   !> Energy of a contact at the end of a step, and its losses in the step, J per metre.
   type :: losses_type
      real(wp) :: stored = 0.0_wp       !< energy in the springs
      real(wp) :: friction = 0.0_wp     !< loss by slip
      real(wp) :: damping = 0.0_wp      !< loss in dashpots
      real(wp) :: impact = 0.0_wp       !< loss in impacts, including their friction
      real(wp) :: algorithmic = 0.0_wp  !< loss by the time integration
   end type losses_type

contains

   !> Set the dashpots of all contacts for the next step, before impacts are detected.
   subroutine damp_contacts(contacts, laws, blocks, step)
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step; their joints are set
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(step_type), intent(in) :: step  !< the next step
      integer :: p

      if (contacts%n < parallel_from) then
         call set_dashpots_range(contacts, laws, blocks, step, 1, contacts%n)
         return
      end if
      !$omp parallel do schedule(static)
      do p = 1, pieces(contacts%n)
         call set_dashpots_range(contacts, laws, blocks, step, first_of(p, contacts%n), &
            last_of(p, contacts%n))
      end do
   end subroutine damp_contacts

   !> Set the dashpots of contacts first … last.
   pure subroutine set_dashpots_range(contacts, laws, blocks, step, first, last)
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step, with joints
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(step_type), intent(in) :: step  !< the next step
      integer, intent(in) :: first, last  !< first and last contact
      integer :: c

      do c = first, last
         contacts%rate(:, c) = relative_motion(contacts, c, &
            blocks%velocity(:, contacts%block_v(c)), blocks%velocity(:, contacts%block_e(c)))
         contacts%damping(c) = not_damped
         contacts%lead(c) = 0.0_wp
         contacts%spring_gap(c) = contacts%gap(c)
         contacts%gain(:, c) = 1.0_wp
         contacts%shift(:, c) = 0.0_wp
         if (.not. contacts%bonded(c)) call set_dashpots(contacts, laws, step, c)
      end do
   end subroutine set_dashpots_range

   !> Set the dashpots of an unbonded contact.
   pure subroutine set_dashpots(contacts, laws, step, c)
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      type(step_type), intent(in) :: step  !< the next step
      integer, intent(in) :: c  !< number of the contact
      real(wp) :: tau, velocity_part

      associate (rate => contacts%rate(1, c), gap => contacts%gap(c), j => contacts%joint(c))
         velocity_part = velocity_weight(step)*step%time_step
         if (laws%restitution(j) >= 0.0_wp) then
            contacts%damping(c) = is_damped
            contacts%lead(c) = (1.0_wp - step%scheme%chi)*step%time_step
            contacts%spring_gap(c) = gap + contacts%lead(c)*rate
            ! If the contact has just touched, its approach velocity does not compress the spring.
            if (is_approached(contacts, step, c)) contacts%spring_gap(c) &
               = max(contacts%spring_gap(c), min(gap, 0.0_wp))
            contacts%gain(:, c) = 1.0_wp/step%scheme%chi
            contacts%shift(:, c) = [contacts%spring_gap(c) - gap, 0.0_wp] &
               - velocity_part*contacts%rate(:, c)
         end if
         if (.not. laws%damping(j) > 0.0_wp) return
         contacts%damping(c) = is_damped
         tau = laws%damping(j)/laws%normal_stiffness
         contacts%gain(1, c) = contacts%gain(1, c) + momentum_weight(step)*tau
         contacts%shift(1, c) = contacts%shift(1, c) - velocity_weight(step)*tau*rate
      end associate
   end subroutine set_dashpots

   !> Find the normal forces of contacts without impact forces after the converged step.
   pure subroutine find_static_forces(contacts)
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step with their solution
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

   !> .true. if the contact closes and has just touched: its velocity has not acted on the spring.
   pure logical function is_approached(contacts, step, c)  ! total
      type(contacts_type), intent(in) :: contacts  !< contacts of this step, with rates
      type(step_type), intent(in) :: step  !< the present step
      integer, intent(in) :: c  !< number of the contact

      is_approached = contacts%rate(1, c) < 0.0_wp .and. &
         contacts%gap(c) >= just_touched*step%time_step*contacts%rate(1, c)
   end function is_approached

   !> Strike a contact: its gap must have at least the velocity `target` at the end of the step.
   !>
   !> If the contact only closes its gap in this step (target = −z₀/Δt), the fraction α = 1 −
   !> target/v⁻ of the impact acts in this step and the rest in the next one.  The slip velocity is
   !> reduced to (1 − α) of its value.  The two steps together have the effect of one impact for any
   !> α.
   pure subroutine strike(contacts, laws, blocks, step, c, target)
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(step_type), intent(in) :: step  !< the present step
      integer, intent(in) :: c  !< number of the contact
      real(wp), intent(in) :: target  !< least velocity of the gap at the end, m/s
      real(wp) :: gain, remaining

      gain = rigid_gain(contacts, laws, blocks, step, c)
      remaining = 0.0_wp
      if (target < 0.0_wp) remaining = target/contacts%rate(1, c)
      contacts%damping(c) = is_struck
      contacts%gain(:, c) = gain
      contacts%shift(:, c) = -[contacts%gap(c), contacts%stretch(c)] &
         - gain*displacement_in_step(step, contacts%rate(:, c), [target, &
         remaining*contacts%rate(2, c)])
   end subroutine strike

   !> Carry a closed contact of a struck block: it retains its force and neither closes nor slips.
   pure subroutine carry(contacts, laws, blocks, step, c)
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(step_type), intent(in) :: step  !< the present step
      integer, intent(in) :: c  !< number of the contact
      real(wp) :: gain

      gain = rigid_gain(contacts, laws, blocks, step, c)
      contacts%damping(c) = is_carried
      contacts%gain(:, c) = gain
      contacts%shift(:, c) = [-contacts%static_force(c)/laws%normal_stiffness - contacts%gap(c), &
         0.0_wp] - gain*displacement_in_step(step, contacts%rate(:, c), 0.0_wp)
   end subroutine carry

   !> Lift a contact that the impact opens: apply its force for a fraction of the step.
   pure subroutine lift(contacts, laws, c, fraction)
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c  !< number of the contact
      real(wp), intent(in) :: fraction  !< fraction of the step before the impact

      contacts%damping(c) = is_lifted
      contacts%gain(:, c) = 0.0_wp
      contacts%shift(:, c) = [-fraction*contacts%static_force(c)/laws%normal_stiffness &
         - contacts%gap(c), (fraction - 1.0_wp)*contacts%stretch(c)]
   end subroutine lift

   !> Return the displacement in a step, from the velocities at its start and end, m.
   elemental real(wp) function displacement_in_step(step, first, last) result(displacement)
      type(step_type), intent(in) :: step  !< the present step
      real(wp), intent(in) :: first, last  !< velocities at start and end of the step, m/s

      displacement = step%time_step*((1.0_wp - step%scheme%chi)*first + step%scheme%chi*last)
   end function displacement_in_step

   !> Return the gain with which a contact spring is nearly rigid relative to the inertia of its
   !> blocks.
   pure real(wp) function rigid_gain(contacts, laws, blocks, step, c) result(gain)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(step_type), intent(in) :: step  !< the present step
      integer, intent(in) :: c  !< number of the contact

      gain = max(1.0_wp/step%scheme%chi, rigidity/(step%scheme%chi*step%time_step**2 &
         *softness_of(contacts, blocks, c)*laws%normal_stiffness))
   end function rigid_gain

   !> Return the inverse effective mass of both blocks along the contact normal, 1/kg per metre.
   pure real(wp) function softness_of(contacts, blocks, c) result(softness)
      type(contacts_type), intent(in) :: contacts  !< list of contacts
      type(blocks_type), intent(in) :: blocks      !< blocks
      integer, intent(in) :: c                     !< number of the contact
      type(rows_type) :: rows

      call find_rows(contacts, c, rows)
      softness = inverse_mass_along(blocks%inertia(:, contacts%block_v(c)), rows%normal_v) &
         + inverse_mass_along(blocks%inertia(:, contacts%block_e(c)), rows%normal_e)
   end function softness_of

   !> Return the inverse of the effective mass of one block for rigid motions, 1/kg per metre.
   pure real(wp) function inverse_mass_along(inertia, row) result(softness)
      real(wp), intent(in) :: inertia(4)  !< see `blocks_type`
      real(wp), intent(in) :: row(6)      !< ∂gap/∂q

      softness = sum(row(1:2)**2)/inertia(1) + row(3)**2/(inertia(2) + inertia(3))
   end function inverse_mass_along

   !> Return the energy in the springs of a damped contact at the start of the step, J per metre.
   pure real(wp) function spring_energy(contacts, laws, c) result(energy)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c  !< number of the contact

      energy = 0.5_wp*laws%normal_stiffness*min(contacts%spring_gap(c), 0.0_wp)**2 &
         + 0.5_wp*laws%shear_stiffness*contacts%stretch(c)**2
   end function spring_energy

   !> Compute the energy of a damped contact at the end of the converged step, and its losses.
   !>
   !> The work of an impulse is its product with the mean velocity.  The displacement of the scheme
   !> differs from mean velocity × Δt; this difference is an algorithmic loss, zero for χ = ½.
   pure type(losses_type) function losses_of(contacts, laws, step, c) result(losses)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step with their solution
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      type(step_type), intent(in) :: step  !< the present step
      integer, intent(in) :: c  !< number of the contact
      real(wp) :: opening, rate(2), stretch, total_loss

      associate (normal => contacts%normal_force(c), shear => contacts%shear_force(c), &
         slip => contacts%slip(c), start_stretch => contacts%stretch(c))
         opening = contacts%new_gap(c) - contacts%gap(c)
         rate = end_rate(step, [opening, slip], contacts%rate(:, c))
         stretch = end_stretch(contacts, laws, c)
         losses%stored = 0.5_wp*laws%normal_stiffness*min(contacts%new_gap(c) &
            + contacts%lead(c)*rate(1), 0.0_wp)**2 + 0.5_wp*laws%shear_stiffness*stretch**2
         total_loss = spring_energy(contacts, laws, c) - losses%stored - normal*opening + shear*slip
         if (contacts%damping(c) >= is_struck) then
            losses%algorithmic = -(step%scheme%chi - 0.5_wp)*step%time_step &
               *dot_product([normal, -shear], rate - contacts%rate(:, c))
            losses%impact = total_loss - losses%algorithmic
         else
            losses%friction = shear*(contacts%gain(2, c)*slip + contacts%shift(2, c) &
               - (stretch - start_stretch))
            losses%damping = total_loss - losses%friction
         end if
      end associate
   end function losses_of

end module dda_contact_damping
