! SPDX-License-Identifier: GPL-3.0-or-later
!> Group &material: elasticity by moduli or by wave velocities, and damping.
module dda_input_material
   use dda_kinds, only: wp
   use dda_blocks, only: set_damping
   use dda_damping, only: damping_type, fit_body, has_body, highest_relaxation, set_rayleigh
   use dda_errors, only: error_type
   use dda_input_group, only: group_type, input_error, given, require, is_set
   use dda_input_groups, only: material_values, read_values
   use dda_input_material_law, only: check_law, set_law
   use dda_material, only: material_type, set_velocities
   use dda_model, only: model_type
   use dda_scheme, only: scheme_type, scheme_named
   use dda_text, only: to_text
   implicit none
   private
   public :: read_material, fit_materials

contains

   !> Read &material.
   subroutine read_material(group, new, error)
      type(group_type), intent(in) :: group  !< group of the input
      type(material_type), intent(out) :: new  !< values of the group
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      call read_values(group, new%material_values, error)
      call read_elasticity(error, group, new)
      call read_damping(error, group, new%material_values, new%damping)
      call check_law(group, new%material_values, new, error)
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
         if (pressure <= shear) call input_error(error, group, 'pressure_velocity = '// &
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
      if (allocated(failure)) call input_error(error, group, &
         'shear_velocity and pressure_velocity give young_modulus = '// &
         to_text(new%young_modulus)//' Pa and poisson_ratio = '//to_text(new%poisson_ratio)// &
         ': '//failure%message(index(failure%message, '): ') + 3:))
   end subroutine check_derived

   !> Read a constant damping ratio, or Rayleigh damping.
   subroutine read_damping(error, group, own, damping)
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(group_type), intent(in) :: group  !< group of the input
      type(material_values), intent(in) :: own  !< values of the group
      type(damping_type), intent(inout) :: damping   !< damping as requested, not yet fitted

      if (given(group, 'rayleigh_alpha') .or. given(group, 'rayleigh_beta')) then
         damping%alpha = own%rayleigh_alpha
         damping%beta = own%rayleigh_beta
      else if (given(group, 'rayleigh_frequencies')) then
         call check_band(error, group, 'rayleigh_frequencies', own%rayleigh_frequencies)
         if (.not. allocated(error)) call set_rayleigh(damping, own%damping_ratio, &
            own%rayleigh_frequencies)
      else if (given(group, 'damping_ratio') .or. own%law == 'hysteretic') then
         damping%ratio = own%damping_ratio
         damping%reference = own%reference_frequency
         call check_band(error, group, 'damping_band', own%damping_band)
         if (given(group, 'damping_band')) damping%band = own%damping_band
         if (is_set(own%mechanisms)) damping%n = own%mechanisms
      end if
   end subroutine read_damping

   !> Check that two frequencies ascend.
   subroutine check_band(error, group, name, band)
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(group_type), intent(in) :: group  !< group of the input
      character(len=*), intent(in) :: name   !< name of the variable
      real(wp), intent(in) :: band(2)        !< Hz

      if (band(2) <= band(1)) call input_error(error, group, name// &
         ' = '//to_text(band(1))//', '//to_text(band(2))//' must ascend')
   end subroutine check_band

   !> Fit laws and branches of all materials to the time steps of all stages, and assign them to the
   !> blocks.
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
         call input_error(error, groups(i), failure%message)
         return
      end do
      call set_damping(model%blocks, model%materials%damping)
   end subroutine fit_materials

end module dda_input_material
