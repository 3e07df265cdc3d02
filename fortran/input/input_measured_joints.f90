! SPDX-License-Identifier: GPL-3.0-or-later
!> Groups &measured_joint.
module dda_input_measured_joints
   use dda_errors, only: error_type
   use dda_input_group, only: group_type, input_error, positions, require_new_name, mark_names
   use dda_input_groups, only: measured_joint_values, read_values
   use dda_measured_joint, only: measured_joint_type
   use dda_model, only: model_type
   use dda_text, only: quoted
   implicit none
   private
   public :: read_measured_joints

contains

   !> Read all measured joints of an input.
   subroutine read_measured_joints(model, groups, error)
      type(model_type), intent(inout) :: model   !< model with its blocks
      type(group_type), intent(in) :: groups(:)  !< groups of the input, in its order
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(measured_joint_type) :: new
      integer, allocatable :: joints(:)
      integer :: i

      allocate (model%measured_joints(0))
      joints = positions(groups, 'measured_joint')
      do i = 1, size(joints)
         associate (group => groups(joints(i)))
            call read_measured_joint(group, model%block_names, new, error)
            if (allocated(error)) return
            call require_new_name(error, group, new%name, model%measured_joints%name)
         end associate
         model%measured_joints = [model%measured_joints, new]
      end do
   end subroutine read_measured_joints

   !> Read one group; default of `against` are all other blocks.
   subroutine read_measured_joint(group, names, new, error)
      type(group_type), intent(in) :: group    !< group of the input
      character(len=*), intent(in) :: names(:) !< [n] names of the blocks
      type(measured_joint_type), intent(out) :: new          !< values of the group
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(measured_joint_values) :: own
      logical :: one(size(names)), other(size(names))

      one = .false.
      other = .false.
      call read_values(group, own, error)
      if (allocated(error)) return
      new%name = own%name
      call mark_names(own%blocks, 'blocks', names, group, one, error)
      call mark_names(own%against, 'against', names, group, other, error)
      if (own%against == '') other = .not. one
      if (any(one .and. other)) call input_error(error, group, 'block '//quoted(trim( &
         names(findloc(one .and. other, .true., 1))))//' is in both blocks and against')
      if (.not. any(other)) call input_error(error, group, &
         '`blocks` selects all blocks, so none remains for `against`')
      new%side = merge(1, merge(2, 0, other), one)
   end subroutine read_measured_joint

end module dda_input_measured_joints
