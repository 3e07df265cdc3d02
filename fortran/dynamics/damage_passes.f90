! SPDX-License-Identifier: GPL-3.0-or-later
!> Damage of bonds within a step: each pass solves the step and updates the damage.
!> The first pass, without further damage, is the stiffest; each pass opens the bonds more.  Passes
!> converge to the solution of the step if it is unique.  A step with unconverged damage is accepted
!> and counted, because its dissipated energy is exact for this damage (`dda_joint_bond`).
module dda_damage_passes
   use dda_kinds, only: wp
   use dda_contact, only: contacts_type
   use dda_friction, only: laws_type
   use dda_joint_bond, only: energy_consistent_damage, is_cohesive
   use dda_joint_law, only: weakened
   implicit none
   private
   public :: begin_damage, renew_damage, most_passes

   integer, parameter :: most_passes = 40  !< largest number of passes per step
   real(wp), parameter :: tolerance = 1.0e-6_wp  !< tolerance of the damage

contains

   !> Set the acting damage: the present damage for bonds, one for other contacts.
   pure subroutine begin_damage(contacts, laws)
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer :: c

      do c = 1, contacts%n
         contacts%acting_damage(c) = 1.0_wp
         if (is_cohesive(contacts, laws%slot(contacts%joint(c))%law, c)) &
            contacts%acting_damage(c) = contacts%memory(weakened, c)
      end do
   end subroutine begin_damage

   !> Update the damage for the solution of the last pass.
   !> If `passes` exceeds `most_passes`, the step is accepted without convergence.
   pure subroutine renew_damage(contacts, laws, passes, converged)
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step, evaluated
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(inout) :: passes  !< number of passes in this step
      logical, intent(out) :: converged  !< the damage has converged or is accepted
      real(wp) :: acting_damage
      integer :: c

      converged = .true.
      do c = 1, contacts%n
         associate (law => laws%slot(contacts%joint(c))%law)
            if (.not. is_cohesive(contacts, law, c)) cycle
            acting_damage = energy_consistent_damage(contacts, law, c)
            if (abs(acting_damage - contacts%acting_damage(c)) <= tolerance) cycle
            if (passes < most_passes) contacts%acting_damage(c) = acting_damage
            converged = .false.
         end associate
      end do
      if (converged) return
      passes = passes + 1
      converged = passes > most_passes
   end subroutine renew_damage

end module dda_damage_passes
