! SPDX-License-Identifier: GPL-3.0-or-later
!> Bond of a contact under a cohesive law: a fraction 1 − D of the bond acts at t₀ + θΔt, and a
!> fraction D of the unbonded contact at the end of the step.
!>
!> The contact slides as if there were no bond.  Its slip p is the shear of the bond minus the shear
!> of the contact spring.  Within a step a damage D* between D₀ (before) and D₁ (after) acts.  The
!> step dissipates E₁ (D₁ − D*) + E₀ (D* − D₀), with the bond energies E₀ (before) and E₁ (after).
!> D* is chosen so that this is the fracture energy g(D₁) − g(D₀) for any Δt.
module dda_joint_bond
   use dda_kinds, only: wp
   use dda_contact, only: contacts_type
   use dda_cohesive, only: cohesive_type, dissipation_bounds
   use dda_joint_contact, only: state_of
   use dda_joint_law, only: joint_law_type, joint_state_type, net_slip, response_type, slip_path, &
      weakened
   implicit none
   private
   public :: is_cohesive, add_bond, add_bond_terms, slider_stretch, energy_consistent_damage, &
      bond_losses, bond_after

contains

   !> .true. if contact c has a bond with gradual damage.
   pure logical function is_cohesive(contacts, law, c)
      type(contacts_type), intent(in) :: contacts  !< list with joint laws
      class(joint_law_type), intent(in) :: law     !< law of the contact
      integer, intent(in) :: c                     !< number of the contact

      is_cohesive = law%cohesive .and. contacts%bonded(c)
   end function is_cohesive

   !> Return the normal and shear stiffness of an undamaged bond, N/m.
   pure function bond_springs(law, state) result(springs)
      class(joint_law_type), intent(in) :: law     !< law of the contact
      type(joint_state_type), intent(in) :: state  !< state of the contact
      real(wp) :: springs(2)

      springs = [law%initial_spring(state), law%shear_spring(state)]
   end function bond_springs

   !> Add the bond to the response of the unbonded contact, which has the weight D*.
   pure subroutine add_bond(contacts, law, c, theta, gap, stretch, response)
      type(contacts_type), intent(in) :: contacts     !< contacts of this step
      class(joint_law_type), intent(in) :: law        !< law of the contact
      integer, intent(in) :: c                        !< number of the contact
      real(wp), intent(in) :: theta                 !< θ, 0 … 1: bonds act at t₀ + θΔt
      real(wp), intent(in) :: gap, stretch !< gap and stretch at the end of the step without slip, m
      type(response_type), intent(inout) :: response  !< response of the unbonded contact
      real(wp) :: forces(2)

      associate (slip => stretch - contacts%stretch(c), acting => contacts%acting_damage(c))
         forces = bond_springs(law, state_of(contacts, law, c))*[-contacts%gap(c) - theta*(gap &
            - contacts%gap(c)), contacts%memory(net_slip, c) + contacts%stretch(c) + theta*slip]
         response%normal_force = acting*response%normal_force + (1.0_wp - acting)*forces(1)
         response%shear_force = acting*response%slider + (1.0_wp - acting)*forces(2)
      end associate
   end subroutine add_bond

   !> Add the bond to the springs of the unbonded contact and to its forces at d = 0.
   pure subroutine add_bond_terms(contacts, law, c, theta, springs, forces)
      type(contacts_type), intent(in) :: contacts   !< contacts of this step
      class(joint_law_type), intent(in) :: law      !< law of the contact
      integer, intent(in) :: c                      !< number of the contact
      real(wp), intent(in) :: theta                 !< θ, 0 … 1: bonds act at t₀ + θΔt
      real(wp), intent(inout) :: springs(2), forces(2)  !< normal and shear value, N/m

      associate (acting => contacts%acting_damage(c), &
         bond => bond_springs(law, state_of(contacts, law, c)))
         springs = acting*springs + (1.0_wp - acting)*theta*bond
         forces = acting*forces + (1.0_wp - acting)*bond*[-contacts%gap(c), &
            contacts%memory(net_slip, c) + contacts%stretch(c)]
      end associate
   end subroutine add_bond_terms

   !> Return the stretch of the shear spring of the unbonded contact c after the converged step, m.
   pure real(wp) function slider_stretch(contacts, law, c) result(stretch)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step with trial forces
      class(joint_law_type), intent(in) :: law     !< law of the contact
      integer, intent(in) :: c                     !< number of the contact

      stretch = contacts%slider(c)/law%shear_spring(state_of(contacts, law, c))
   end function slider_stretch

   !> Return the slip of the bond at the end of the step, m.
   pure real(wp) function new_slip(contacts, law, c) result(slip)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step with trial forces
      class(joint_law_type), intent(in) :: law     !< law of the contact
      integer, intent(in) :: c                     !< number of the contact

      slip = contacts%memory(net_slip, c) + contacts%slip(c) &
         - (slider_stretch(contacts, law, c) - contacts%stretch(c))
   end function new_slip

   !> Return the damage D* of contact c that dissipates the fracture energy at the solution.
   pure real(wp) function energy_consistent_damage(contacts, law, c) result(acting_damage)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step with trial forces
      class(joint_law_type), intent(in) :: law     !< law of the contact
      integer, intent(in) :: c                     !< number of the contact

      acting_damage = contacts%memory(weakened, c)
      select type (law)
      class is (cohesive_type)
         acting_damage = law%damage_in_step([contacts%gap(c), contacts%new_gap(c)], &
            [contacts%memory(net_slip, c), new_slip(contacts, law, c)], acting_damage)
      end select
   end function energy_consistent_damage

   !> Return the dissipation of contact c in the converged step by friction and by fracture, J/m.
   pure function bond_losses(contacts, law, c, after) result(losses)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      class(joint_law_type), intent(in) :: law     !< law of the contact
      integer, intent(in) :: c                     !< number of the contact
      type(joint_state_type), intent(in) :: after  !< state after the step
      real(wp) :: losses(2), rise(2)

      losses = 0.0_wp
      select type (law)
      class is (cohesive_type)
         associate (acting => contacts%acting_damage(c), before => contacts%memory(net_slip, c), &
            slip => after%memory(net_slip))
            rise = [acting - contacts%memory(weakened, c), after%memory(weakened) - acting]
            losses(1) = acting*contacts%slider(c)*(slip - before) + law%shear_spring(after) &
               *(rise(1)*before*contacts%stretch(c) + rise(2)*slip*slider_stretch(contacts, law, c))
            losses(2) = contacts%length(c)*(rise(1)*law%bond_energy(contacts%gap(c), before) &
               + rise(2)*law%bond_energy(contacts%new_gap(c), slip))
         end associate
      end select
   end function bond_losses

   !> Return the state of contact c after the converged step.
   pure type(joint_state_type) function bond_after(contacts, law, c) result(after)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      class(joint_law_type), intent(in) :: law     !< law of the contact
      integer, intent(in) :: c                     !< number of the contact
      real(wp) :: energies(2)

      after = state_of(contacts, law, c)
      select type (law)
      class is (cohesive_type)
         associate (slip => after%memory(net_slip), before => contacts%memory(net_slip, c), &
            damage => after%memory(weakened))
            slip = new_slip(contacts, law, c)
            after%memory(slip_path) = after%memory(slip_path) + abs(slip - before)
            damage = law%damage(contacts%new_gap(c), slip, max(damage, contacts%acting_damage(c)))
            energies = [law%bond_energy(contacts%gap(c), before), &
               law%bond_energy(contacts%new_gap(c), slip)]
            after%memory(dissipation_bounds) = after%memory(dissipation_bounds) &
               + (damage - contacts%memory(weakened, c))*energies
         end associate
      end select
   end function bond_after

end module dda_joint_bond
