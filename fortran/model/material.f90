! SPDX-License-Identifier: GPL-3.0-or-later
!> Materials of blocks and joints.
module dda_material
   use dda_kinds, only: wp
   use dda_damping, only: damping_type
   use dda_group_values, only: joint_values, material_values
   use dda_material_law, only: material_law_type
   implicit none
   private
   public :: material_type, joint_type, elasticity, set_velocities

   !> Block material: isotropic and linear elastic, or viscoelastic.
   type, extends(material_values) :: material_type
      logical :: has_velocities = .false.      !< moduli are given by velocities of S and P waves
      type(damping_type) :: damping = damping_type()
      class(material_law_type), allocatable :: own_law  !< not allocated: linear elastic
   contains
      procedure :: has_law, yields
   end type material_type

   !> Joint material: name of its law, and parameters of laws (see `docs/joints.md`).
   type, extends(joint_values) :: joint_type
      real(wp) :: normal_stiffness = 0.0_wp !< Pa/m; 0: contact stiffness, N/m
      real(wp) :: shear_stiffness = 0.0_wp  !< Pa/m; 0: from the normal stiffness
   contains
      procedure :: is_plain
   end type joint_type

contains

   !> .true. if the material has its own law.
   elemental logical function has_law(material)  ! total
      class(material_type), intent(in) :: material  !< material or joint

      has_law = allocated(material%own_law)
   end function has_law

   !> .true. if the law of the material limits its stresses.
   elemental logical function yields(material)
      class(material_type), intent(in) :: material  !< material or joint

      yields = .false.
      if (allocated(material%own_law)) yields = material%own_law%yields()
   end function yields

   !> Set Young's modulus and Poisson's ratio from the velocities of S and P waves in the solid.
   pure subroutine set_velocities(material, shear_velocity, pressure_velocity)
      type(material_type), intent(inout) :: material  !< material with its density
      real(wp), intent(in) :: shear_velocity, pressure_velocity  !< m/s, different

      associate (s => shear_velocity**2, p => pressure_velocity**2)
         material%poisson_ratio = 0.5_wp*(p - 2.0_wp*s)/(p - s)
         material%young_modulus = 2.0_wp*material%density*s*(1.0_wp + material%poisson_ratio)
      end associate
      material%has_velocities = .true.
   end subroutine set_velocities

   !> .true. if the law is Coulomb friction with springs at corners, the usual law.
   pure logical function is_plain(joint)  ! total
      class(joint_type), intent(in) :: joint  !< material or joint

      is_plain = joint%law == 'coulomb' .and. joint%normal_stiffness == 0.0_wp &
         .and. joint%shear_stiffness == 0.0_wp .and. joint%contact_points == 2
   end function is_plain

   !> Elastic matrix D of σ = D ε, Pa, for (εx, εy, γxy).
   pure function elasticity(material, plane_strain) result(d)
      type(material_type), intent(in) :: material  !< Young's modulus and Poisson's ratio
      logical, intent(in) :: plane_strain          !< plane strain; .false.: plane stress
      real(wp) :: d(3, 3)
      real(wp) :: e, nu

      e = material%young_modulus
      nu = material%poisson_ratio
      if (plane_strain) then
         e = e/(1.0_wp - nu**2)
         nu = nu/(1.0_wp - nu)
      end if
      d = 0.0_wp
      d(1, 1) = 1.0_wp
      d(2, 2) = 1.0_wp
      d(1, 2) = nu
      d(2, 1) = nu
      d(3, 3) = 0.5_wp*(1.0_wp - nu)
      d = d*e/(1.0_wp - nu**2)
   end function elasticity

end module dda_material
