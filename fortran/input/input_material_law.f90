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

   !> Variables that a law asks for are there, and go with the rest of the material.
   subroutine check_law(group, own, material, error)
      type(group_type), intent(in) :: group           !< &material
      type(material_values), intent(in) :: own        !< its values
      type(material_type), intent(in) :: material     !< as read, without its law
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(soil_type) :: soil

      if (allocated(error)) return
      if (own%law == 'mohr_coulomb') call check_strength(group, own, error)
      if (own%law /= 'hysteretic') return
      if (material%damping%alpha > 0.0_wp .or. material%damping%beta > 0.0_wp) call input_error( &
         error, group, "law 'hysteretic' has a damping ratio of small strains at all "// &
         'frequencies: leave out rayleigh_alpha, rayleigh_beta and rayleigh_frequencies')
      call read_soil(group, own, material, soil, error)
   end subroutine check_law

   !> The law of a material, whose damping of small strains is the law's from now on.
   subroutine set_law(group, material, limit, error)
      type(group_type), intent(in) :: group            !< &material
      type(material_type), intent(inout) :: material   !< as read
      real(wp), intent(in) :: limit            !< largest ω_l that all stages can take, rad/s
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
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

   !> The soil that a group describes.
   subroutine read_soil(group, own, material, soil, error)
      type(group_type), intent(in) :: group        !< &material
      type(material_values), intent(in) :: own     !< its values
      type(material_type), intent(in) :: material  !< with its moduli
      type(soil_type), intent(out) :: soil         !< as asked for
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays

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
      call require_of_curve(group, own, error)
      if (allocated(error)) return
      if (soil%curve == 'gqh') soil%theta = own%curve_fit
      if (soil%curve == 'table') soil%table = curve_type(own%strains, own%reductions, own%dampings)
   end subroutine read_soil

   !> Variables that each curve needs.
   subroutine require_of_curve(group, own, error)
      type(group_type), intent(in) :: group     !< &material
      type(material_values), intent(in) :: own  !< its values
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      integer :: n

      select case (own%curve)
      case ('')
         call input_error(error, group, "law = 'hysteretic' needs a curve: 'darendeli', "// &
            "'hyperbolic', 'mkz', 'gqh' or 'table'")
      case ('darendeli')
         if (.not. is_set(own%mean_stress)) call input_error(error, group, &
            "curve = 'darendeli' needs the mean_stress")
      case ('table')
         n = size(own%strains)
         if (n < 2 .or. size(own%reductions) /= n .or. size(own%dampings) /= n) then
            call input_error(error, group, &
               "curve = 'table' needs as many strains, reductions and dampings, two at least")
         else if (any(own%strains(2:) <= own%strains(:n - 1))) then
            call input_error(error, group, 'strains must ascend')
         end if
      case default
         if (is_set(own%reference_strain) .eqv. is_set(own%shear_strength)) call input_error( &
            error, group, 'curve = '''//trim(own%curve)//''' needs the reference_strain, or '// &
            'the shear_strength in its place')
         if (own%curve == 'gqh' .and. size(own%curve_fit) /= 5) call input_error(error, group, &
            "curve = 'gqh' needs the five numbers of curve_fit")
      end select
   end subroutine require_of_curve

end module dda_input_material_law
