! SPDX-License-Identifier: GPL-3.0-or-later
!> A sample of the output as a row of numbers: energies, maxima, measured points and joints, bolts
!> and boundaries.
module dda_sample
   use dda_kinds, only: wp
   use dda_bolts, only: bolt_columns
   use dda_boundary_motion, only: boundary_series, take_boundary_motions
   use dda_elements, only: bolt_states
   use dda_energy, only: energy_terms, energy_values
   use dda_joint_motion, only: joint_columns, measure_joint
   use dda_maxima, only: number_of_maxima, known
   use dda_measure, only: measure_point
   use dda_simulation, only: simulation_type
   implicit none
   private
   public :: sample_energies, sample_head, sample_size, take_sample

   integer, parameter :: sample_energies = 4 + size(energy_terms)  !< behind the last of them
   !> time, Δt, iterations, stage, energies, maxima
   integer, parameter :: sample_head = sample_energies + number_of_maxima

contains

   !> Numbers of a sample.
   pure integer function sample_size(simulation)
      type(simulation_type), intent(in) :: simulation  !< at its present time

      sample_size = sample_head + 6*size(simulation%model%points) &
         + joint_columns*size(simulation%model%measured_joints) &
         + bolt_columns*size(simulation%model%bolts) &
         + 2*boundary_series*size(simulation%model%boundary_motions)
   end function sample_size

   !> Time, Δt, iterations, stage, energies, the largest values so far; then [2, points, 3]
   !> displacement, velocity, acceleration; then [columns, joints] and [columns, bolts] of measured
   !> joints and bolts; then [2, boundaries, series] of boundaries that something comes in through.
   subroutine take_sample(simulation, iterations, sample)
      type(simulation_type), intent(in) :: simulation  !< at its present time
      integer, intent(in) :: iterations  !< most of a step since the last sample
      real(wp), intent(out) :: sample(:)  !< [`sample_size`]
      real(wp) :: motion(2, 3), through(2, size(simulation%model%boundary_motions), boundary_series)
      integer :: i, kind, at

      sample(:4) = [simulation%time, simulation%last_time_step, real(iterations, wp), &
         real(simulation%stage, wp)]
      sample(5:sample_energies) = energy_values(simulation%energy)
      sample(sample_energies + 1:sample_head) = known(simulation%maxima%largest)
      associate (points => simulation%model%points)
         do i = 1, size(points)
            call measure_point(simulation%blocks, points(i), motion(:, 1), motion(:, 2), &
               motion(:, 3))
            do kind = 1, 3
               at = sample_head + 2*((kind - 1)*size(points) + i - 1)
               sample(at + 1:at + 2) = motion(:, kind)
            end do
         end do
         at = sample_head + 6*size(points)
      end associate
      associate (joints => simulation%model%measured_joints)
         do i = 1, size(joints)
            call measure_joint(joints(i), simulation%maxima%contacts, &
               simulation%contacts(simulation%now), simulation%blocks, &
               sample(at + 1:at + joint_columns))
            at = at + joint_columns
         end do
      end associate
      associate (bolts => size(simulation%model%bolts))
         if (bolts > 0) sample(at + 1:at + bolt_columns*bolts) = pack(bolt_states( &
            simulation%elements, bolts), .true.)
         at = at + bolt_columns*bolts
      end associate
      if (size(through) == 0) return
      call take_boundary_motions(simulation, through)
      sample(at + 1:) = pack(through, .true.)
   end subroutine take_sample

end module dda_sample
