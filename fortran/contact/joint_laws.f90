! SPDX-License-Identifier: GPL-3.0-or-later
!> Registration of the joint laws by name, and their stiffness.
module dda_joint_laws
   use dda_kinds, only: wp
   use dda_barton_bandis, only: new_barton_bandis
   use dda_cohesive, only: new_cohesive
   use dda_continuously_yielding, only: new_continuously_yielding
   use dda_coulomb, only: new_coulomb
   use dda_crushing, only: new_crushing
   use dda_joint_law, only: joint_law_type
   use dda_material, only: joint_type
   use dda_mohr_coulomb, only: new_mohr_coulomb
   use dda_plesha, only: new_plesha
   use dda_rate_state, only: new_rate_state
   implicit none
   private
   public :: law_slot_type, create_joint_law

   !> Container of a joint law of any type.
   type :: law_slot_type
      class(joint_law_type), allocatable :: law
   end type law_slot_type

contains

   !> Create the law of a joint material; new laws are registered here.
   subroutine create_joint_law(slot, joint, normal_stiffness, shear_ratio)
      type(law_slot_type), intent(out) :: slot  !< receives the law; empty if the name is unknown
      type(joint_type), intent(in) :: joint     !< checked input
      real(wp), intent(in) :: normal_stiffness  !< default k_n of contacts, N/m
      real(wp), intent(in) :: shear_ratio       !< default k_n/k_s of contacts

      select case (joint%law)
      case ('barton_bandis')
         allocate (slot%law, source=new_barton_bandis(joint))
      case ('cohesive')
         allocate (slot%law, source=new_cohesive(joint))
      case ('continuously_yielding')
         allocate (slot%law, source=new_continuously_yielding(joint))
      case ('coulomb')
         allocate (slot%law, source=new_coulomb(joint))
      case ('crushing')
         allocate (slot%law, source=new_crushing(joint))
      case ('mohr_coulomb')
         allocate (slot%law, source=new_mohr_coulomb(joint))
      case ('plesha')
         allocate (slot%law, source=new_plesha(joint))
      case ('rate_state')
         allocate (slot%law, source=new_rate_state(joint))
      case default
         return  ! the input reader rejects unknown laws
      end select
      associate (law => slot%law)
         law%normal_per_area = joint%normal_stiffness > 0.0_wp
         law%normal_stiffness = merge(joint%normal_stiffness, normal_stiffness, law%normal_per_area)
         law%shear_stiffness = law%normal_stiffness/shear_ratio
         law%shear_per_area = law%normal_per_area
         if (joint%shear_stiffness > 0.0_wp) then
            law%shear_per_area = .true.
            law%shear_stiffness = joint%shear_stiffness
         end if
      end associate
   end subroutine create_joint_law

end module dda_joint_laws
