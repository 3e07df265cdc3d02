! SPDX-License-Identifier: GPL-3.0-or-later
!> Coulomb joint: friction N tan φ, and a brittle bond with cohesion c L and tension T L, which
!> fails suddenly.
!>
!> If all joints have this law and contacts are at corners only, the state of a contact is its
!> stretch and bond, and `respond` computes its forces.  With the code for general laws, a step
!> takes 1.2 times (15 layers) to 1.7 times (static wall of 1,000 bricks) as long.
module dda_coulomb
   use dda_kinds, only: wp, pi
   use dda_contact, only: contact_open, contact_slide, contact_stick
   use dda_joint_law, only: joint_law_type, joint_state_type, response_type, strength_type, weakened
   use dda_material, only: joint_type
   implicit none
   private
   public :: coulomb_type, new_coulomb, coulomb_contact_type, respond

   !> Strength before and after bond failure.
   type, extends(joint_law_type) :: coulomb_type
      real(wp) :: friction = 0.0_wp   !< tan φ
      real(wp) :: cohesion = 0.0_wp   !< cohesion before the bond breaks, Pa
      real(wp) :: tensile = 0.0_wp    !< tensile strength before the bond breaks, Pa
   contains
      procedure :: strength, tension
   end type coulomb_type

   !> Data of one contact under Coulomb's law, which has no further state.
   type :: coulomb_contact_type
      real(wp) :: normal_stiffness    !< k_n, N/m per metre of thickness
      real(wp) :: shear_stiffness     !< k_s, N/m per metre of thickness
      real(wp) :: multiplier          !< multiplier of the augmented Lagrangian, N/m
      real(wp) :: friction            !< tan φ
      real(wp) :: cohesion_force      !< cohesion × length while bonded, else 0, N/m
      real(wp) :: tension_force       !< tensile strength × length while bonded, else 0, N/m
      logical :: bonded               !< the bond is intact and transmits tension
   end type coulomb_contact_type

contains

   !> Create the law of a joint material, but do not set its stiffness.
   pure type(coulomb_type) function new_coulomb(joint) result(law)
      type(joint_type), intent(in) :: joint  !< checked input

      law%friction = tan(joint%friction_angle*pi/180.0_wp)
      law%cohesion = joint%cohesion
      law%tensile = joint%tensile_strength
      law%brittle = max(joint%cohesion, joint%tensile_strength) > 0.0_wp
      law%inputs = [strength_type('friction_angle', joint%friction_angle, is_angle=.true.), &
         strength_type('cohesion', joint%cohesion), &
         strength_type('tensile_strength', joint%tensile_strength)]
   end function new_coulomb

   !> Return the largest shear force, N/m.
   pure real(wp) function strength(law, state, normal_force)  ! total
      class(coulomb_type), intent(in) :: law       !< law of the joint
      type(joint_state_type), intent(in) :: state  !< state of the contact
      real(wp), intent(in) :: normal_force         !< compression positive, N/m

      strength = law%friction*max(normal_force, 0.0_wp) &
         + (1.0_wp - state%memory(weakened))*law%cohesion*state%length
   end function strength

   !> Return the largest tension of a bonded contact, N/m.
   pure real(wp) function tension(law, state)  ! total
      class(coulomb_type), intent(in) :: law       !< law of the joint
      type(joint_state_type), intent(in) :: state  !< state of the contact

      tension = (1.0_wp - state%memory(weakened))*law%tensile*state%length
   end function tension

   !> Find the forces of a contact at a gap and a trial elastic stretch of its shear spring.
   !>
   !> Components are assigned one by one: copying a structure stalls the processor's next reads.
   pure subroutine respond(law, gap, trial_stretch, response)
      type(coulomb_contact_type), intent(in) :: law  !< law of the contact
      real(wp), intent(in) :: gap, trial_stretch     !< m
      type(response_type), intent(out) :: response   !< state and forces
      real(wp) :: trial

      response%state = contact_open
      response%normal_force = 0.0_wp
      response%shear_force = 0.0_wp
      response%bound = 0.0_wp
      response%strength_ratio = 0.0_wp
      if (law%normal_stiffness*gap >= law%multiplier .and. .not. law%bonded) return
      response%normal_force = law%multiplier - law%normal_stiffness*gap
      response%bound = law%friction*max(response%normal_force, 0.0_wp) + law%cohesion_force
      trial = law%shear_stiffness*trial_stretch
      if (abs(trial) <= response%bound .or. law%bonded) then
         response%state = contact_stick
         response%shear_force = trial
      else
         response%state = contact_slide
         response%shear_force = sign(response%bound, trial)
      end if
      response%slider = response%shear_force
      ! positive if the tension exceeds its strength or the shear force its bound
      if (law%bonded) response%strength_ratio = max(-response%normal_force - law%tension_force, &
         abs(response%shear_force) - response%bound)/max(law%tension_force, law%cohesion_force, &
         tiny(1.0_wp))
   end subroutine respond

end module dda_coulomb
