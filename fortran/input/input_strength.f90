! SPDX-License-Identifier: GPL-3.0-or-later
!> The law 'mohr_coulomb' in the group &material.
module dda_input_strength
   use dda_kinds, only: wp, pi
   use dda_errors, only: error_type
   use dda_input_group, only: group_type, input_error, is_set, value_or
   use dda_input_groups, only: material_values, read_values
   use dda_joint_law, only: reduced_type => strength_type, reduced_angle
   use dda_material, only: material_type
   use dda_mohr_coulomb_solid, only: mohr_coulomb_solid_type
   use dda_text, only: to_text
   use dda_yield_return, only: strength_type
   implicit none
   private
   public :: check_strength, solid_of, reduce_solid

   real(wp), parameter :: degree = pi/180.0_wp
   real(wp), parameter :: rounding = 1.0e-9_wp  !< relative rounding of decimal input values

contains

   !> Check that strengths are given together.
   subroutine check_strength(group, own, error)
      type(group_type), intent(in) :: group     !< &material
      type(material_values), intent(in) :: own  !< values of the group
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      if (own%dilation_angle > own%friction_angle) call input_error(error, group, &
         'dilation_angle = '//to_text(own%dilation_angle)//' must not be above friction_angle = ' &
         //to_text(own%friction_angle)//': yielding would add energy')
      if (is_set(own%tensile_strength)) call check_tension('', own%tensile_strength, &
         own%cohesion, own%friction_angle)
      if (is_set(own%residual_tensile_strength)) call check_tension('residual_', &
         own%residual_tensile_strength, value_or(own%residual_cohesion, own%cohesion), &
         value_or(own%residual_friction_angle, own%friction_angle))
      call check_residual('cohesion', own%cohesion, own%residual_cohesion)
      call check_residual('friction_angle', own%friction_angle, own%residual_friction_angle)
      call check_residual('tensile_strength', value_or(own%tensile_strength, &
         cone_apex(own%cohesion, own%friction_angle)), own%residual_tensile_strength)
      if (.not. is_set(own%softening_displacement) .and. any(is_set([own%residual_cohesion, &
         own%residual_friction_angle, own%residual_tensile_strength]))) call input_error(error, &
         group, 'residual strengths need softening_displacement')

   contains

      !> Check that the tensile strength does not exceed c cot φ.
      subroutine check_tension(prefix, tension, cohesion, angle)
         character(len=*), intent(in) :: prefix              !< prefix of the names
         real(wp), intent(in) :: tension, cohesion, angle    !< Pa, Pa, degrees

         if (angle <= 0.0_wp) return
         if (tension > (1.0_wp + rounding)*cone_apex(cohesion, angle)) call input_error(error, &
            group, prefix//'tensile_strength = '//to_text(tension)//' Pa must not be above '// &
            prefix//'cohesion / tan('//prefix//'friction_angle) = '//to_text(cone_apex(cohesion, &
            angle))//' Pa')
      end subroutine check_tension

      !> Check that a residual strength does not exceed the peak strength.
      subroutine check_residual(name, peak, residual)
         character(len=*), intent(in) :: name       !< name of the strength
         real(wp), intent(in) :: peak, residual     !< values as given

         if (.not. is_set(residual) .or. .not. is_set(peak)) return
         if (residual > peak) call input_error(error, group, 'residual_'//name//' = '// &
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
      type(material_values) :: own

      allocate (strengths(0))
      call read_values(group, own, error)
      if (allocated(error) .or. own%law /= 'mohr_coulomb') return
      associate (angle => reduced_angle(own%friction_angle, factor))
         strengths = [reduced_type('cohesion', own%cohesion/factor), &
            reduced_type('friction_angle', angle), &
            reduced_type('dilation_angle', min(own%dilation_angle, angle))]
      end associate
      call append_strength('tensile_strength', own%tensile_strength, own%tensile_strength/factor)
      call append_strength('residual_cohesion', own%residual_cohesion, own%residual_cohesion/factor)
      call append_strength('residual_tensile_strength', own%residual_tensile_strength, &
         own%residual_tensile_strength/factor)
      call append_strength('residual_friction_angle', own%residual_friction_angle, &
         reduced_angle(own%residual_friction_angle, factor))

   contains

      !> Append a strength, if it is given.
      subroutine append_strength(name, given, value)
         character(len=*), intent(in) :: name   !< name of the variable
         real(wp), intent(in) :: given, value   !< value as given; divided value

         if (is_set(given)) strengths = [strengths, reduced_type(name, value)]
      end subroutine append_strength
   end subroutine reduce_solid

   !> Create the law that a group describes.
   pure type(mohr_coulomb_solid_type) function solid_of(own, material) result(law)
      type(material_values), intent(in) :: own      !< values of &material
      type(material_type), intent(in) :: material   !< material with its elasticity

      law%peak = make_strength(own%cohesion, own%friction_angle, own%tensile_strength)
      law%peak%dilation = degree*own%dilation_angle
      law%residual = law%peak
      if (is_set(own%softening_displacement)) then
         law%softening = own%softening_displacement
         law%residual = make_strength(value_or(own%residual_cohesion, own%cohesion), &
            value_or(own%residual_friction_angle, own%friction_angle), &
            value_or(own%residual_tensile_strength, law%peak%tension))
         law%residual%dilation = min(law%peak%dilation, law%residual%friction)
      end if
      if (is_set(own%initial_stress_z)) law%beyond = own%initial_stress_z &
         - material%poisson_ratio*sum(own%initial_stress(1:2))
   end function solid_of

   !> Return a strength without dilation.
   pure type(strength_type) function make_strength(cohesion, angle, tension) result(strength)
      real(wp), intent(in) :: cohesion, angle, tension  !< Pa; degrees; Pa or not set

      strength%cohesion = cohesion
      strength%friction = degree*angle
      strength%tension = min(cone_apex(cohesion, angle), value_or(tension, huge(1.0_wp)))
   end function make_strength

end module dda_input_strength
