! SPDX-License-Identifier: GPL-3.0-or-later
!> Group &material: elasticity by moduli or by wave velocities, damping, and laws.
module dda_input_material
   use dda_kinds, only: wp, pi
   use dda_blocks, only: set_damping
   use dda_damping, only: damping_type, fit_body, has_body, highest_relaxation, set_rayleigh
   use dda_errors, only: error_type
   use dda_input_group, only: group_type, fail_input, given, require, is_set, value_or
   use dda_input_groups, only: material_values, read_values
   use dda_material, only: material_type, set_velocities
   use dda_model, only: model_type
   use dda_scheme, only: scheme_type, scheme_named
   use dda_text, only: to_text
   use dda_branches, only: branches_type, curve_type, fit_branches
   use dda_hysteretic_law, only: new_hysteretic_law
   use dda_soil_curves, only: soil_type, find_curve
   use dda_joint_law, only: reduced_type => strength_type, reduced_angle
   use dda_mohr_coulomb_solid, only: mohr_coulomb_solid_type
   use dda_yield_return, only: strength_type
   implicit none
   private
   public :: read_material, fit_materials, reduce_solid

   real(wp), parameter :: degree = pi/180.0_wp
   real(wp), parameter :: rounding = 1.0e-9_wp  !< relative rounding of decimal input values

contains

   !> Read &material.
   subroutine read_material(group, new, error)
      type(group_type), intent(in) :: group  !< group of the input
      type(material_type), intent(out) :: new  !< values of the group
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      call read_values(group, new%material_values, error)
      call read_elasticity(error, group, new)
      call read_damping(error, group, new%material_values, new%damping)
      call check_law(group, new, error)
   end subroutine read_material

   !> Read Young's modulus and Poisson's ratio, or the velocities of S and P waves.
   subroutine read_elasticity(error, group, new)
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(group_type), intent(in) :: group  !< group of the input
      type(material_type), intent(inout) :: new  !< material; receives the values

      associate (shear => new%shear_velocity, pressure => new%pressure_velocity)
         if (.not. is_set(shear)) then
            call require(error, group, 'young_modulus poisson_ratio', [new%young_modulus, &
               new%poisson_ratio])
            return
         end if
         if (pressure <= shear) call fail_input(error, group, 'pressure_velocity = '// &
            to_text(pressure)//' m/s must be above shear_velocity = '//to_text(shear)//' m/s')
         if (allocated(error)) return
         call set_velocities(new, shear, pressure)
      end associate
      call check_derived(error, group, new)
   end subroutine read_elasticity

   !> Check that the moduli derived from velocities are permitted.
   subroutine check_derived(error, group, new)
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(group_type), intent(in) :: group  !< group of the input
      type(material_type), intent(in) :: new  !< material with moduli from velocities
      type(error_type), allocatable :: failure

      call require(failure, group, 'young_modulus poisson_ratio', [new%young_modulus, &
         new%poisson_ratio])
      if (allocated(failure)) call fail_input(error, group, &
         'shear_velocity and pressure_velocity give young_modulus = '// &
         to_text(new%young_modulus)//' Pa and poisson_ratio = '//to_text(new%poisson_ratio)// &
         ': '//failure%message(index(failure%message, '): ') + 3:))
   end subroutine check_derived

   !> Read a constant damping ratio, or Rayleigh damping.
   subroutine read_damping(error, group, input, damping)
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(group_type), intent(in) :: group  !< group of the input
      type(material_values), intent(in) :: input  !< values of the group
      type(damping_type), intent(inout) :: damping   !< damping as requested, not yet fitted

      if (given(group, 'rayleigh_alpha') .or. given(group, 'rayleigh_beta')) then
         damping%alpha = input%rayleigh_alpha
         damping%beta = input%rayleigh_beta
      else if (given(group, 'rayleigh_frequencies')) then
         call check_band(error, group, 'rayleigh_frequencies', input%rayleigh_frequencies)
         if (.not. allocated(error)) call set_rayleigh(damping, input%damping_ratio, &
            input%rayleigh_frequencies)
      else if (given(group, 'damping_ratio') .or. input%law == 'hysteretic') then
         damping%ratio = input%damping_ratio
         damping%reference = input%reference_frequency
         call check_band(error, group, 'damping_band', input%damping_band)
         if (given(group, 'damping_band')) damping%band = input%damping_band
         if (is_set(input%mechanisms)) damping%n = input%mechanisms
      end if
   end subroutine read_damping

   !> Check that two frequencies ascend.
   subroutine check_band(error, group, name, band)
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(group_type), intent(in) :: group  !< group of the input
      character(len=*), intent(in) :: name   !< name of the variable
      real(wp), intent(in) :: band(2)        !< Hz

      if (band(2) <= band(1)) call fail_input(error, group, name//' = '//to_text(band)// &
         ' must ascend')
   end subroutine check_band

   !> Fit laws and branches of all materials to the time steps of all stages.
   !> The blocks receive the fitted laws and branches of their materials.
   subroutine fit_materials(model, groups, error)
      type(model_type), intent(inout) :: model  !< model with its stages
      type(group_type), intent(in) :: groups(:)  !< groups of the input, in its order
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(error_type), allocatable :: failure
      type(scheme_type) :: scheme
      real(wp) :: limit
      integer :: i, m

      limit = huge(1.0_wp)
      do i = 1, size(model%stages)
         associate (stage => model%stages(i))
            if (stage%static) cycle
            scheme = scheme_named(stage%integration, stage%theta)
            limit = min(limit, highest_relaxation(scheme%theta, stage%time_step))
         end associate
      end do
      m = 0
      do i = 1, size(groups)
         if (groups(i)%name /= 'material') cycle
         m = m + 1
         call set_law(groups(i), model%materials(m), limit, failure)
         associate (damping => model%materials(m)%damping)
            if (.not. (damping%by_law .or. allocated(failure))) then
               if (has_body(damping)) call fit_body(damping, limit, failure)
            end if
         end associate
         if (.not. allocated(failure)) cycle
         call fail_input(error, groups(i), failure%message)
         return
      end do
      call set_damping(model%blocks, model%materials%damping)
   end subroutine fit_materials

   !> Check that the variables of a law are given and consistent with the rest of the material.
   subroutine check_law(group, material, error)
      type(group_type), intent(in) :: group           !< &material
      type(material_type), intent(in) :: material     !< material as read, without its law
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(soil_type) :: soil

      if (allocated(error)) return
      if (material%law == 'mohr_coulomb') call check_strength(group, &
         material%material_values, error)
      if (material%law == 'hysteretic') call read_soil(group, material, soil, error)
   end subroutine check_law

   !> Set the law of a material, which then includes the damping at small strains.
   subroutine set_law(group, material, limit, error)
      type(group_type), intent(in) :: group            !< &material
      type(material_type), intent(inout) :: material   !< material as read
      real(wp), intent(in) :: limit            !< largest ω_l permitted by all stages, rad/s
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(soil_type) :: soil
      type(curve_type) :: curve
      type(branches_type) :: branches

      if (material%law == 'mohr_coulomb') allocate (material%own_law, source=solid_of(material))
      if (material%law /= 'hysteretic') return
      call read_soil(group, material, soil, error)
      if (.not. allocated(error)) call find_curve(soil, curve, error)
      if (allocated(error)) return
      associate (damping => material%damping, masing => material%damping_curve == 'masing')
         if (.not. given(group, 'damping_ratio')) &
            damping%ratio = merge(0.0_wp, curve%damping(1), masing)
         call fit_branches(curve, material%branches, masing, damping, limit, branches, error)
         if (allocated(error)) return
         damping = branches%body
         damping%by_law = .true.
      end associate
      allocate (material%own_law, source=new_hysteretic_law(branches))
   end subroutine set_law

   !> Read the soil that a group describes.
   subroutine read_soil(group, input, soil, error)
      type(group_type), intent(in) :: group        !< &material
      type(material_type), intent(in) :: input     !< values of the group, with its moduli
      type(soil_type), intent(out) :: soil         !< soil as requested
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      soil%curve = input%curve(:len(soil%curve))
      soil%plasticity = input%plasticity_index
      soil%stress = input%mean_stress
      soil%consolidation = input%ocr
      soil%frequency = input%reference_frequency
      soil%reference = input%reference_strain
      soil%factor = input%curve_factor
      soil%power = input%curve_power
      if (is_set(input%shear_strength)) soil%reference = input%shear_strength*2.0_wp &
         *(1.0_wp + input%poisson_ratio)/input%young_modulus
      call check_curve(group, input%material_values, error)
      if (allocated(error)) return
      if (soil%curve == 'gqh') soil%theta = input%curve_fit
      if (soil%curve == 'table') soil%table = curve_type(input%strains, input%reductions, &
         input%dampings)
   end subroutine read_soil

   !> Check the values of a curve.
   subroutine check_curve(group, input, error)
      type(group_type), intent(in) :: group     !< &material
      type(material_values), intent(in) :: input  !< values of the group
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer :: n

      if (input%curve == 'gqh' .and. size(input%curve_fit) /= 5) call fail_input(error, group, &
         "curve = 'gqh' needs the five numbers of curve_fit")
      if (input%curve /= 'table') return
      n = size(input%strains)
      if (n < 2 .or. size(input%reductions) /= n .or. size(input%dampings) /= n) then
         call fail_input(error, group, &
            "curve = 'table' needs equal numbers of strains, reductions and dampings, "// &
            'at least two of each')
      else if (any(input%strains(2:) <= input%strains(:n - 1))) then
         call fail_input(error, group, 'the values of `strains` must ascend')
      end if
   end subroutine check_curve

   !> Check that strengths are given together.
   subroutine check_strength(group, input, error)
      type(group_type), intent(in) :: group     !< &material
      type(material_values), intent(in) :: input  !< values of the group
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      if (input%dilation_angle > input%friction_angle) call fail_input(error, group, &
         'dilation_angle = '//to_text(input%dilation_angle)// &
            ' must not be above friction_angle = ' &
         //to_text(input%friction_angle)//', because yielding would add energy')
      if (is_set(input%tensile_strength)) call check_tension('', input%tensile_strength, &
         input%cohesion, input%friction_angle)
      if (is_set(input%residual_tensile_strength)) call check_tension('residual_', &
         input%residual_tensile_strength, value_or(input%residual_cohesion, input%cohesion), &
         value_or(input%residual_friction_angle, input%friction_angle))
      call check_residual('cohesion', input%cohesion, input%residual_cohesion)
      call check_residual('friction_angle', input%friction_angle, input%residual_friction_angle)
      call check_residual('tensile_strength', value_or(input%tensile_strength, &
         cone_apex(input%cohesion, input%friction_angle)), input%residual_tensile_strength)
      if (.not. is_set(input%softening_displacement) .and. any(is_set([input%residual_cohesion, &
         input%residual_friction_angle, input%residual_tensile_strength]))) call fail_input(error, &
         group, 'residual strengths need softening_displacement')

   contains

      !> Check that the tensile strength does not exceed c cot φ.
      subroutine check_tension(prefix, tension, cohesion, angle)
         character(len=*), intent(in) :: prefix              !< prefix of the names
         real(wp), intent(in) :: tension, cohesion, angle    !< Pa; Pa; degrees

         if (angle <= 0.0_wp) return
         if (tension > (1.0_wp + rounding)*cone_apex(cohesion, angle)) call fail_input(error, &
            group, prefix//'tensile_strength = '//to_text(tension)//' Pa must not be above '// &
            prefix//'cohesion / tan('//prefix//'friction_angle) = '//to_text(cone_apex(cohesion, &
            angle))//' Pa')
      end subroutine check_tension

      !> Check that a residual strength does not exceed the peak strength.
      subroutine check_residual(name, peak, residual)
         character(len=*), intent(in) :: name       !< name of the strength
         real(wp), intent(in) :: peak, residual     !< values as given

         if (.not. is_set(residual) .or. .not. is_set(peak)) return
         if (residual > peak) call fail_input(error, group, 'residual_'//name//' = '// &
            to_text(residual)//' must not be above '//name//' = '//to_text(peak))
      end subroutine check_residual
   end subroutine check_strength

   !> Apex of the cone, c cot φ, Pa.
   pure real(wp) function cone_apex(cohesion, angle)
      real(wp), intent(in) :: cohesion, angle  !< Pa; degrees

      cone_apex = huge(1.0_wp)
      if (angle > 0.0_wp) cone_apex = cohesion/tan(degree*angle)
   end function cone_apex

   !> Divide the strengths c, tan φ and T of a group &material by a factor; limit dilation to φ.
   subroutine reduce_solid(group, factor, strengths, error)
      type(group_type), intent(in) :: group  !< &material
      real(wp), intent(in) :: factor         !< above 0
      type(reduced_type), allocatable, intent(out) :: strengths(:)  !< names and values
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(material_values) :: input

      allocate (strengths(0))
      call read_values(group, input, error)
      if (allocated(error) .or. input%law /= 'mohr_coulomb') return
      associate (angle => reduced_angle(input%friction_angle, factor))
         strengths = [reduced_type('cohesion', input%cohesion/factor), &
            reduced_type('friction_angle', angle), &
            reduced_type('dilation_angle', min(input%dilation_angle, angle))]
      end associate
      call append_strength('tensile_strength', input%tensile_strength, &
         input%tensile_strength/factor)
      call append_strength('residual_cohesion', input%residual_cohesion, &
         input%residual_cohesion/factor)
      call append_strength('residual_tensile_strength', input%residual_tensile_strength, &
         input%residual_tensile_strength/factor)
      call append_strength('residual_friction_angle', input%residual_friction_angle, &
         reduced_angle(input%residual_friction_angle, factor))

   contains

      !> Append a strength, if it is given.
      subroutine append_strength(name, unreduced, value)
         character(len=*), intent(in) :: name   !< name of the variable
         real(wp), intent(in) :: unreduced, value   !< value in the input; divided value

         if (is_set(unreduced)) strengths = [strengths, reduced_type(name, value)]
      end subroutine append_strength
   end subroutine reduce_solid

   !> Create the law that a group describes.
   pure type(mohr_coulomb_solid_type) function solid_of(input) result(law)
      type(material_type), intent(in) :: input  !< values of &material, with its elasticity

      law%peak = make_strength(input%cohesion, input%friction_angle, input%tensile_strength)
      law%peak%dilation = degree*input%dilation_angle
      law%residual = law%peak
      if (is_set(input%softening_displacement)) then
         law%softening = input%softening_displacement
         law%residual = make_strength(value_or(input%residual_cohesion, input%cohesion), &
            value_or(input%residual_friction_angle, input%friction_angle), &
            value_or(input%residual_tensile_strength, law%peak%tension))
         law%residual%dilation = min(law%peak%dilation, law%residual%friction)
      end if
      if (is_set(input%initial_stress_z)) law%out_of_plane = input%initial_stress_z &
         - input%poisson_ratio*sum(input%initial_stress(1:2))
   end function solid_of

   !> Return a strength without dilation.
   pure type(strength_type) function make_strength(cohesion, angle, tension) result(strength)
      real(wp), intent(in) :: cohesion, angle, tension  !< Pa; degrees; Pa or not set

      strength%cohesion = cohesion
      strength%friction = degree*angle
      strength%tension = min(cone_apex(cohesion, angle), value_or(tension, huge(1.0_wp)))
   end function make_strength

end module dda_input_material
