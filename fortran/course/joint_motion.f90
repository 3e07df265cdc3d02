! SPDX-License-Identifier: GPL-3.0-or-later
!> Slip, opening and force of the joint between two sets of blocks.
!>
!> Slip and opening are measured at the contacts that touched when counting began
!> (`dda_first_contacts`); forces are summed over all contacts of the last step.  Slip is positive
!> if the first set moves to the right, with the second set drawn below it.
module dda_joint_motion
   use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type
   use dda_contact, only: contacts_type
   use dda_errors, only: error_type, error_input, fail
   use dda_first_contacts, only: first_contacts_type, foot_movement
   use dda_output_schema, only: columns_of, in_measured_joints
   use dda_simulation, only: simulation_type
   use dda_support, only: measured_joint_type
   use dda_text, only: quoted
   implicit none
   private
   public :: measure_joint, check_measured_joints, joint_columns

   integer, parameter :: joint_columns = columns_of(in_measured_joints)  !< values per joint

contains

   !> Measure a joint: mean slip and largest opening, m (NaN if its blocks are removed); forces,
   !> N/m: normal (compression positive), resisting shear, resultant (x, y) on the first set.
   pure subroutine measure_joint(joint, first_contacts, contacts, blocks, values)
      type(measured_joint_type), intent(in) :: joint   !< joint of the model
      type(first_contacts_type), intent(in) :: first_contacts   !< contacts when counting began
      type(contacts_type), intent(in) :: contacts      !< contacts of the last step
      type(blocks_type), intent(in) :: blocks          !< blocks in their present state
      real(wp), intent(out) :: values(joint_columns)   !< slip, opening, forces
      real(wp) :: movement(2), force(2), slip, opening
      integer :: c, n

      n = 0
      slip = 0.0_wp
      opening = 0.0_wp
      do c = 1, size(first_contacts%vertex)
         if (.not. is_between(joint, blocks%owner(first_contacts%vertex(c)), &
            blocks%owner(first_contacts%edge(c)))) cycle
         movement = foot_movement(first_contacts, blocks, c)
         n = n + 1
         slip = slip - movement(1)  ! vertices are counter-clockwise, so a top edge runs to the left
         opening = max(opening, movement(2))
      end do
      values(:2) = ieee_value(slip, ieee_quiet_nan)
      if (n > 0) values(:2) = [slip/n, opening]
      values(3:) = 0.0_wp
      do c = 1, contacts%n
         if (.not. is_between(joint, contacts%block_v(c), contacts%block_e(c))) cycle
         associate (edge => contacts%edge(c), normal => contacts%normal_force(c), &
            shear => contacts%shear_force(c))
            force = normal*contacts%normal(:, c) - shear*blocks%along(:, edge)
            if (joint%side(contacts%block_v(c)) == 2) force = -force
            values(3:) = values(3:) + [normal, -shear, force]
         end associate
      end do
   end subroutine measure_joint

   !> .true. if a contact of blocks `block_a` and `block_b` belongs to the joint.
   pure logical function is_between(joint, block_a, block_b)
      type(measured_joint_type), intent(in) :: joint  !< joint of the model
      integer, intent(in) :: block_a, block_b               !< blocks

      is_between = joint%side(block_a) + joint%side(block_b) == 3
   end function is_between

   !> Reject a joint without contacts at the start of the run.
   subroutine check_measured_joints(simulation, error)
      type(simulation_type), intent(in) :: simulation        !< simulation whose maxima have begun
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer :: i, c
      logical :: has_contact

      associate (joints => simulation%model%measured_joints, first => simulation%maxima%contacts, &
         owner => simulation%blocks%owner)
         do i = 1, size(joints)
            has_contact = any([(is_between(joints(i), owner(first%vertex(c)), &
               owner(first%edge(c))), c=1, size(first%vertex))])
            if (has_contact .or. allocated(error)) cycle
            call fail(error, error_input, simulation%model%file//': &measured_joint '// &
               quoted(trim(joints(i)%name))//': when the run begins, no block of '// &
               '`blocks` touches a block of `against`; name blocks that share a joint')
         end do
      end associate
   end subroutine check_measured_joints

end module dda_joint_motion
