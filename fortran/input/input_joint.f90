! SPDX-License-Identifier: GPL-3.0-or-later
!> The group &joint: strength and stiffness of a joint material by its law.
module dda_input_joint
   use dda_kinds, only: wp
   use dda_barton_bandis, only: closure_of_joint
   use dda_errors, only: error_type
   use dda_input_group, only: group_type, input_error, given, require, is_set, value_or
   use dda_input_groups, only: read_values
   use dda_input_text, only: parse_group, split_groups
   use dda_input_strength, only: reduce_solid
   use dda_joint_law, only: strength_type
   use dda_joint_laws, only: law_slot_type, new_joint_law
   use dda_material, only: joint_type
   use dda_plesha, only: steepest_climb
   use dda_text, only: quoted, to_text
   implicit none
   private
   public :: read_joint, reduced_strengths

contains

   !> &joint
   subroutine read_joint(group, new, error)
      type(group_type), intent(in) :: group  !< of the input
      type(joint_type), intent(out) :: new  !< as the group says
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(law_slot_type) :: slot

      call read_values(group, new%joint_values, error)
      call read_contacts(error, group, new)
      if (allocated(error)) return
      call new_joint_law(slot, new, 1.0_wp, 1.0_wp)
      if (.not. allocated(slot%law)) call input_error(error, group, 'law = '// &
         quoted(trim(new%law))//' is not registered in dda_joint_laws')
      new%residual_friction_angle = value_or(new%residual_friction_angle, new%friction_angle)
      if (new%law == 'mohr_coulomb') call read_residual(error, group, new)
      if (new%law == 'mohr_coulomb') call read_slip(error, group, new)
      if (new%law == 'barton_bandis') call read_rough(error, group, new)
      if (new%law == 'plesha') call read_asperities(error, group, new)
      if (new%law == 'cohesive') call read_fracture(error, group, new)
   end subroutine read_joint

   !> What contacts of a joint of any law may have.
   subroutine read_contacts(error, group, new)
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(group_type), intent(in) :: group    !< of the input
      type(joint_type), intent(inout) :: new   !< with its law

      if (new%law == 'cohesive' .and. .not. given(group, 'contact_points')) new%contact_points = 3
      if (all(new%contact_points /= [2, 3, 5])) call input_error(error, group, &
         'contact_points = '//to_text(new%contact_points)//' must be 2, 3 or 5')
      new%normal_stiffness = value_or(new%normal_stiffness_per_area, 0.0_wp)
      new%shear_stiffness = value_or(new%shear_stiffness_per_area, 0.0_wp)
   end subroutine read_contacts

   !> The variables of a group &joint or &material with which all strength is divided by a factor,
   !> as its law says.
   subroutine reduced_strengths(file, text, factor, strengths, error)
      character(len=*), intent(in) :: file  !< path, for messages
      character(len=*), intent(in) :: text  !< one group &joint or &material
      real(wp), intent(in) :: factor        !< above 0
      type(strength_type), allocatable, intent(out) :: strengths(:)  !< names and values
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      type(group_type), allocatable :: groups(:)
      type(joint_type) :: joint
      type(law_slot_type) :: slot

      allocate (strengths(0))
      call split_groups(file, text, groups, error)
      if (allocated(error)) return
      call parse_group(text, groups(1), error)
      if (allocated(error)) return
      if (groups(1)%name == 'material') then
         call reduce_solid(groups(1), factor, strengths, error)
         return
      end if
      call read_joint(groups(1), joint, error)
      if (allocated(error)) return
      call new_joint_law(slot, joint, 1.0_wp, 1.0_wp)
      strengths = slot%law%reduced(joint, factor)
   end subroutine reduced_strengths

   !> Residual strength, which is at most the peak strength.
   subroutine read_residual(error, group, new)
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(group_type), intent(in) :: group    !< of the input
      type(joint_type), intent(inout) :: new   !< with its peak strength

      call compare('friction_angle', new%residual_friction_angle, new%friction_angle)
      call compare('cohesion', new%residual_cohesion, new%cohesion)
      call compare('tensile_strength', new%residual_tensile_strength, new%tensile_strength)

   contains

      subroutine compare(name, residual, peak)
         character(len=*), intent(in) :: name  !< of the peak's variable
         real(wp), intent(in) :: residual, peak

         if (residual > peak) call input_error(error, group, 'residual_'//name//' = '// &
            to_text(residual)//' is above the peak, '//name//' = '//to_text(peak)// &
            ': a joint does not grow stronger by failing')
      end subroutine compare

   end subroutine read_residual

   !> Weakening and dilation.
   subroutine read_slip(error, group, new)
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(group_type), intent(in) :: group    !< of the input
      type(joint_type), intent(inout) :: new   !< with its strength

      if (new%dilation_angle > new%residual_friction_angle) call input_error(error, group, &
         'dilation_angle = '//to_text(new%dilation_angle)//' is above the residual friction '// &
         'angle, '//to_text(new%residual_friction_angle)//': slip would give energy')
      if (is_set(new%dilation_slip) .and. new%dilation_angle <= 0.0_wp) &
         call input_error(error, group, 'dilation_slip has no meaning without a '// &
         'dilation_angle above 0')
   end subroutine read_slip

   !> Fracture energies and softening.
   subroutine read_fracture(error, group, new)
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(group_type), intent(in) :: group    !< of the input
      type(joint_type), intent(inout) :: new   !< with its strength and stiffness

      call require(error, group, 'fracture_energy', [new%fracture_energy])
      if (allocated(error)) return
      new%shear_fracture_energy = value_or(new%shear_fracture_energy, &
         10*new%fracture_energy)
      if (.not. min(new%cohesion, new%tensile_strength) > 0.0_wp) call input_error(error, group, &
         'a joint of law = '//quoted(trim(new%law))//' needs cohesion and tensile_strength above 0')
      if (.not. new%normal_stiffness > 0.0_wp) call input_error(error, group, &
         'a joint of law = '//quoted(trim(new%law))//' needs normal_stiffness_per_area: how '// &
         'far it opens up to its strength follows from that')
   end subroutine read_fracture

   !> Asperities of Plesha.
   subroutine read_asperities(error, group, new)
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(group_type), intent(in) :: group    !< of the input
      type(joint_type), intent(inout) :: new   !< with its friction angle

      call require(error, group, 'asperity_angle', [new%asperity_angle])
      if (allocated(error)) return
      associate (angle => new%asperity_angle, friction => new%friction_angle)
         if (angle > friction) call input_error(error, group, 'asperity_angle = '// &
            to_text(angle)//' is above friction_angle = '//to_text(friction)//': the joint '// &
            'would slip back by itself')
         if (angle + friction > steepest_climb) call input_error(error, group, &
            'asperity_angle = '//to_text(angle)//' and friction_angle = '//to_text(friction)// &
            ' must not be more than '//to_text(steepest_climb)//' together: no shear force '// &
            'would climb the asperities')
      end associate
      if (new%shear_stiffness > 0.0_wp .and. .not. new%normal_stiffness > 0.0_wp) &
         call input_error(error, group, 'shear_stiffness_per_area of a joint of law = '// &
         quoted(trim(new%law))//' needs normal_stiffness_per_area too')
   end subroutine read_asperities

   !> Roughness, wall strength and closure of Barton and Bandis.
   subroutine read_rough(error, group, new)
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(group_type), intent(in) :: group    !< of the input
      type(joint_type), intent(inout) :: new   !< with its stiffness
      logical :: by_closure

      call require(error, group, 'jrc jcs', [new%jrc, new%jcs])
      by_closure = new%normal_stiffness > 0.0_wp .and. is_set(new%max_closure)
      if (is_set(new%compressive_strength)) then
         if (new%normal_stiffness > 0.0_wp .or. is_set(new%max_closure)) call input_error(error, &
            group, 'compressive_strength gives the closure of the joint: leave it out, or '// &
            'leave out normal_stiffness_per_area and max_closure')
      else if (.not. by_closure) then
         call input_error(error, group, 'the closure of the joint is missing: give '// &
            'normal_stiffness_per_area (k_ni) and max_closure (V_m), or compressive_strength')
      end if
      if (allocated(error)) return
      if (by_closure) return
      call closure_of_joint(new%jrc, new%jcs, new%compressive_strength, new%normal_stiffness, &
         new%max_closure)
      if (.not. min(new%normal_stiffness, new%max_closure) > 0.0_wp) call input_error(error, &
         group, 'jrc = '//to_text(new%jrc)//', jcs = '//to_text(new%jcs)//' and '// &
         'compressive_strength = '//to_text(new%compressive_strength)//' are outside the '// &
         'range of the empirical '// &
         'formulas: they give no positive k_ni and V_m; give normal_stiffness_per_area and '// &
         'max_closure instead')
   end subroutine read_rough

end module dda_input_joint
