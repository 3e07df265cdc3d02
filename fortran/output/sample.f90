! SPDX-License-Identifier: GPL-3.0-or-later
!> Sample of the output as a row of numbers: energies, maxima, measured points and joints, bolts,
!> water in joints, and boundaries.
module dda_sample
   use dda_kinds, only: wp
   use dda_elements, only: bolt_states, channel_columns, get_flow_states, node_columns
   use dda_energy, only: energy_values
   use dda_joint_motion, only: measure_joint
   use dda_maxima, only: stored_value
   use dda_measure, only: measure_point
   use dda_output_schema, only: columns_of, energy_terms, in_bolts, in_boundary_motions, &
      in_measured_joints, in_run, number_of_maxima
   use dda_simulation, only: simulation_type
   use dda_baseline, only: displacement_at, velocity_at, acceleration_at
   use dda_boundary, only: boundary_motion_type
   use dda_columns, only: column_of
   implicit none
   private
   public :: collect_sample

   integer, parameter :: before_energies = columns_of(in_run)  !< values before the energies
   integer, parameter :: before_maxima = before_energies + size(energy_terms)
   integer, parameter :: before_base = before_maxima + number_of_maxima  !< … the base motion
   integer, parameter :: before_points = before_base + 2                 !< … the points

contains

   !> Collect a sample, variable by variable, in the order of the schema.
   subroutine collect_sample(simulation, iterations, sample)
      type(simulation_type), intent(in) :: simulation  !< simulation at its present time
      integer, intent(in) :: iterations  !< most iterations of a step since the last sample
      real(wp), intent(out) :: sample(:)  !< [`size_of_sample`] values
      real(wp) :: motion(2, 3), boundary_motions(2, size(simulation%model%boundary_motions), &
         columns_of(in_boundary_motions)), joint(columns_of(in_measured_joints))
      integer :: i, kind, at

      sample(:before_energies) = [simulation%time, simulation%last_time_step, real(iterations, &
         wp), real(simulation%stage, wp)]
      sample(before_energies + 1:before_maxima) = energy_values(simulation%energy)
      sample(before_maxima + 1:before_base) = stored_value(simulation%maxima%largest)
      sample(before_base + 1:before_points) = simulation%maxima%base%displacement
      associate (points => simulation%model%points)
         do i = 1, size(points)
            call measure_point(simulation%blocks, points(i), motion(:, 1), motion(:, 2), &
               motion(:, 3))
            do kind = 1, 3
               at = before_points + 2*((kind - 1)*size(points) + i - 1)
               sample(at + 1:at + 2) = motion(:, kind)
            end do
         end do
         at = before_points + 6*size(points)
      end associate
      associate (joints => simulation%model%measured_joints)
         do i = 1, size(joints)
            call measure_joint(joints(i), simulation%maxima%contacts, &
               simulation%contacts(simulation%now), simulation%blocks, joint)
            sample(at + i:at + size(joint)*size(joints):size(joints)) = joint
         end do
         at = at + size(joint)*size(joints)
      end associate
      associate (bolts => size(simulation%model%bolts), columns => columns_of(in_bolts))
         if (bolts > 0) sample(at + 1:at + columns*bolts) = pack(transpose(bolt_states( &
            simulation%elements, bolts)), .true.)
         at = at + columns*bolts
      end associate
      if (allocated(simulation%model%flow)) call collect_flow(simulation, sample, at)
      if (size(boundary_motions) == 0) return
      call collect_boundary_motions(simulation, boundary_motions)
      sample(at + 1:) = pack(boundary_motions, .true.)
   end subroutine collect_sample

   !> Collect the values of water in joints.
   subroutine collect_flow(simulation, sample, at)
      type(simulation_type), intent(in) :: simulation  !< simulation at its present time
      real(wp), intent(inout) :: sample(:)  !< [`size_of_sample`] values
      integer, intent(inout) :: at          !< position before these values; on return, after them
      real(wp) :: nodes(node_columns, size(simulation%model%flow%pressure)), &
         channels(channel_columns, size(simulation%model%flow%channel))

      call get_flow_states(simulation%elements, nodes, channels)
      sample(at + 1:at + size(nodes)) = pack(transpose(nodes), .true.)
      at = at + size(nodes)
      sample(at + 1:at + size(channels)) = pack(transpose(channels), .true.)
      at = at + size(channels)
   end subroutine collect_flow

   !> Collect the incoming and present motions of all boundaries.
   subroutine collect_boundary_motions(simulation, motions)
      type(simulation_type), intent(in) :: simulation  !< simulation at its present time
      !> [2,boundary motions,6] displacement, velocity, acceleration (m, s): incoming, then actual
      real(wp), intent(out) :: motions(:,:,:)
      real(wp) :: part(2, 3)
      integer :: i, k

      motions = 0.0_wp
      do i = 1, size(simulation%model%boundary_motions)
         associate (motion => simulation%model%boundary_motions(i))
            motions(:, i, :3) = incoming_motion(simulation, motion)
            do k = 1, size(motion%point)
               call measure_point(simulation%blocks, motion%point(k), part(:, 1), part(:, 2), &
                  part(:, 3))
               motions(:, i, 4:) = motions(:, i, 4:) + motion%weight(k)*part
            end do
         end associate
      end do
   end subroutine collect_boundary_motions

   !> Find displacement, velocity and acceleration of the incoming motion.
   function incoming_motion(simulation, motion) result(wave)
      type(simulation_type), intent(in) :: simulation  !< simulation at its present time
      type(boundary_motion_type), intent(in) :: motion  !< motion of a boundary
      real(wp) :: wave(2, 3)
      type(simulation_type), pointer :: column
      integer :: axis

      wave = 0.0_wp
      if (motion%field > 0) then
         column => column_of(simulation, motion%field)
         call measure_point(column%blocks, column%model%points(1), wave(:, 1), wave(:, 2), &
            wave(:, 3))
         return
      end if
      do axis = 1, 2
         if (motion%motion(axis) == 0) cycle
         associate (curve => simulation%model%motions(motion%motion(axis))%curve, &
            time => simulation%time)
            wave(axis, :) = motion%factor*[displacement_at(curve, time), &
               velocity_at(curve, time), acceleration_at(curve, time)]
         end associate
      end do
   end function incoming_motion

end module dda_sample
