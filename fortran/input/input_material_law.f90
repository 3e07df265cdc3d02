! SPDX-License-Identifier: GPL-3.0-or-later
!> Laws of materials in the group &material.
module dda_input_material_law
   use dda_kinds, only: wp
   use dda_branches, only: branches_type, curve_type, fit_branches
   use dda_errors, only: error_type
   use dda_hysteretic_law, only: new_hysteretic_law
   use dda_input_group, only: group_type, input_error, given, is_set
   use dda_input_groups, only: material_values, read_values
   use dda_input_strength, only: check_strength, solid_of
   use dda_material, only: material_type
   use dda_soil_curves, only: soil_type, curve_of
   implicit none
   private
   public :: check_law, set_law

contains

   !> Check that the variables of a law are given and consistent with the rest of the material.
   subroutine check_law(group, own, material, error)
      type(group_type), intent(in) :: group           !< &material
      type(material_values), intent(in) :: own        !< values of the group
      type(material_type), intent(in) :: material     !< material as read, without its law
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(soil_type) :: soil

      if (allocated(error)) return
      if (own%law == 'mohr_coulomb') call check_strength(group, own, error)
      if (own%law /= 'hysteretic') return
      call read_soil(group, own, material, soil, error)
   end subroutine check_law

   !> Set the law of a material, which then includes the damping at small strains.
   subroutine set_law(group, material, limit, error)
      type(group_type), intent(in) :: group            !< &material
      type(material_type), intent(inout) :: material   !< material as read
      real(wp), intent(in) :: limit            !< largest ω_l permitted by all stages, rad/s
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(material_values) :: own
      type(soil_type) :: soil
      type(curve_type) :: curve
      type(branches_type) :: branches

      call read_values(group, own, error)
      if (own%law == 'mohr_coulomb') allocate (material%own_law, source=solid_of(own, material))
      if (own%law /= 'hysteretic') return
      call read_soil(group, own, material, soil, error)
      if (.not. allocated(error)) call curve_of(soil, curve, error)
      if (allocated(error)) return
      associate (damping => material%damping, masing => own%damping_curve == 'masing')
         if (.not. given(group, 'damping_ratio')) &
            damping%ratio = merge(0.0_wp, curve%damping(1), masing)
         call fit_branches(curve, own%branches, masing, damping, limit, branches, error)
         if (allocated(error)) return
         damping = branches%body
         damping%by_law = .true.
      end associate
      allocate (material%own_law, source=new_hysteretic_law(branches))
   end subroutine set_law

   !> Read the soil that a group describes.
   subroutine read_soil(group, own, material, soil, error)
      type(group_type), intent(in) :: group        !< &material
      type(material_values), intent(in) :: own     !< values of the group
      type(material_type), intent(in) :: material  !< material with its moduli
      type(soil_type), intent(out) :: soil         !< soil as requested
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      soil%curve = own%curve(:len(soil%curve))
      soil%plasticity = own%plasticity_index
      soil%stress = own%mean_stress
      soil%consolidation = own%ocr
      soil%frequency = own%reference_frequency
      soil%reference = own%reference_strain
      soil%factor = own%curve_factor
      soil%power = own%curve_power
      if (is_set(own%shear_strength)) soil%reference = own%shear_strength*2.0_wp &
         *(1.0_wp + material%poisson_ratio)/material%young_modulus
      call check_curve(group, own, error)
      if (allocated(error)) return
      if (soil%curve == 'gqh') soil%theta = own%curve_fit
      if (soil%curve == 'table') soil%table = curve_type(own%strains, own%reductions, own%dampings)
   end subroutine read_soil

   !> Check the values of a curve.
   subroutine check_curve(group, own, error)
      type(group_type), intent(in) :: group     !< &material
      type(material_values), intent(in) :: own  !< values of the group
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer :: n

      if (own%curve == 'gqh' .and. size(own%curve_fit) /= 5) call input_error(error, group, &
         "curve = 'gqh' needs the five numbers of curve_fit")
      if (own%curve /= 'table') return
      n = size(own%strains)
      if (n < 2 .or. size(own%reductions) /= n .or. size(own%dampings) /= n) then
         call input_error(error, group, &
            "curve = 'table' needs as many strains, reductions and dampings, two at least")
      else if (any(own%strains(2:) <= own%strains(:n - 1))) then
         call input_error(error, group, 'strains must ascend')
      end if
   end subroutine check_curve

end module dda_input_material_law
