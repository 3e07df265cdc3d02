! SPDX-License-Identifier: GPL-3.0-or-later
!> Group &joint: strength and stiffness of a joint material by its law.
module dda_input_joint
   use dda_kinds, only: wp
   use dda_errors, only: error_type
   use dda_input_group, only: group_type, fail_input, given, value_or
   use dda_input_groups, only: read_values
   use dda_input_text, only: parse_group, split_groups
   use dda_input_material, only: reduce_solid
   use dda_joint_law, only: strength_type
   use dda_joint_laws, only: law_slot_type, create_joint_law
   use dda_material, only: joint_type
   use dda_text, only: quoted, to_text
   implicit none
   private
   public :: read_joint, find_reduced_strengths

   real(wp), parameter :: any_ratio = 1.0e-6_wp  !< k_n/k_s that is valid for every law

contains

   !> Read &joint.
   subroutine read_joint(group, shear_ratio, new, error)
      type(group_type), intent(in) :: group  !< group of the input
      real(wp), intent(in) :: shear_ratio    !< default k_n/k_s of contacts
      type(joint_type), intent(out) :: new  !< values of the group
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(law_slot_type) :: slot
      character(len=:), allocatable :: failure

      call read_values(group, new%joint_values, error)
      if (allocated(error)) return
      new%normal_stiffness = value_or(new%normal_stiffness_per_area, 0.0_wp)
      new%shear_stiffness = value_or(new%shear_stiffness_per_area, 0.0_wp)
      call create_joint_law(slot, new, 1.0_wp, 1.0_wp)
      if (.not. allocated(slot%law)) call fail_input(error, group, 'law = '// &
         quoted(trim(new%law))//' is not registered in dda_joint_laws')
      if (allocated(error)) return
      if (.not. given(group, 'contact_points')) new%contact_points = slot%law%points
      if (all(new%contact_points /= [2, 3, 5, 9, 17])) call fail_input(error, group, &
         'contact_points = '//to_text(new%contact_points)//' must be 2, 3, 5, 9 or 17')
      if (allocated(error)) return
      if (.not. given(group, 'friction_angle')) new%friction_angle = 0.0_wp  ! weakest joint
      call slot%law%check_and_derive(new, shear_ratio, failure)
      if (failure /= '') call fail_input(error, group, failure)
   end subroutine read_joint

   !> Values of variables of &joint or &material for which all strengths are divided by a factor.
   subroutine find_reduced_strengths(file, text, factor, strengths, error)
      character(len=*), intent(in) :: file  !< path, for messages
      character(len=*), intent(in) :: text  !< text of one group &joint or &material
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
      call read_joint(groups(1), any_ratio, joint, error)
      if (allocated(error)) return
      call create_joint_law(slot, joint, 1.0_wp, 1.0_wp)
      strengths = slot%law%reduced_strengths(factor)
   end subroutine find_reduced_strengths

end module dda_input_joint
