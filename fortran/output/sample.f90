! SPDX-License-Identifier: GPL-3.0-or-later
!> The output of a run as rows of numbers: samples of points and energies, frames of blocks and
!> contacts.
module dda_sample
   use dda_kinds, only: wp
   use dda_blocks, only: stress_of
   use dda_contact, only: contacts_type
   use dda_bolts, only: bolt_columns
   use dda_boundary_motion, only: boundary_series, take_boundary_motions
   use dda_elements, only: bolt_states
   use dda_energy, only: energy_terms, energy_values
   use dda_measure, only: measure_point
   use dda_simulation, only: simulation_type
   implicit none
   private
   public :: sample_head, most_columns, contact_columns, sample_size, frame_size, take_sample, &
      take_frame

   !> time, Δt, iterations, stage, energies
   integer, parameter :: sample_head = 4 + size(energy_terms)
   integer, parameter :: plain_columns = 9   !< of a contact
   integer, parameter :: most_columns = 12   !< of one under a joint law

contains

   !> Numbers of a contact.
   pure integer function contact_columns(simulation)
      type(simulation_type), intent(in) :: simulation  !< at its present time

      contact_columns = merge(plain_columns, most_columns, simulation%laws%plain)
   end function contact_columns

   !> Numbers of a sample.
   pure integer function sample_size(simulation)
      type(simulation_type), intent(in) :: simulation  !< at its present time

      sample_size = sample_head + 6*size(simulation%model%points) &
         + bolt_columns*size(simulation%model%bolts) &
         + 2*boundary_series*size(simulation%model%boundary_motions)
   end function sample_size

   !> Numbers of a frame with so many contacts.
   pure integer function frame_size(simulation, contacts)
      type(simulation_type), intent(in) :: simulation  !< at its present time
      integer, intent(in) :: contacts  !< number of contacts of the frame

      frame_size = 2 + 15*simulation%blocks%n + 2*size(simulation%blocks%owner) &
         + contact_columns(simulation)*contacts
   end function frame_size

   !> Time, Δt, iterations, stage, energies; then [2, points, 3] displacement, velocity,
   !> acceleration; then [columns, bolts] of the bolts; then [2, boundaries, series] of boundaries
   !> that something comes in through.
   subroutine take_sample(simulation, iterations, sample)
      type(simulation_type), intent(in) :: simulation  !< at its present time
      integer, intent(in) :: iterations  !< most of a step since the last sample
      real(wp), intent(out) :: sample(:)  !< [`sample_size`]
      real(wp) :: motion(2, 3), through(2, size(simulation%model%boundary_motions), boundary_series)
      integer :: i, kind, at

      sample(:4) = [simulation%time, simulation%last_time_step, real(iterations, wp), &
         real(simulation%stage, wp)]
      sample(5:sample_head) = energy_values(simulation%energy)
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
      associate (bolts => size(simulation%model%bolts))
         if (bolts > 0) sample(at + 1:at + bolt_columns*bolts) = pack(bolt_states( &
            simulation%elements, bolts), .true.)
         at = at + bolt_columns*bolts
      end associate
      if (size(through) == 0) return
      call take_boundary_motions(simulation, through)
      sample(at + 1:) = pack(through, .true.)
   end subroutine take_sample

   !> Time, stage; coordinates, rates [6, n]; stresses [3, n]; vertices [2, vertices]; contacts
   !> [contacts, columns].
   subroutine take_frame(simulation, frame)
      type(simulation_type), intent(in) :: simulation  !< at its present time
      real(wp), allocatable, intent(out) :: frame(:)  !< [`frame_size`]
      integer :: b, n, vertices, contacts, at

      n = simulation%blocks%n
      vertices = size(simulation%blocks%owner)
      contacts = simulation%contacts(simulation%now)%n
      allocate (frame(frame_size(simulation, contacts)))
      frame(:2) = [simulation%time, real(simulation%stage, wp)]
      at = 2
      associate (blocks => simulation%blocks, origin => simulation%model%origin)
         call place(frame, at, blocks%position, 6*n)
         do b = 0, n - 1
            frame(6*b + 3:6*b + 4) = frame(6*b + 3:6*b + 4) + origin
         end do
         call place(frame, at, blocks%velocity, 6*n)
         do b = 1, n
            call place(frame, at, stress_of(blocks, b), 3)
         end do
         call place(frame, at, blocks%vertex + spread(origin, 2, vertices), 2*vertices)
      end associate
      call take_contacts(simulation%contacts(simulation%now), contacts, frame(at + 1:))
   end subroutine take_frame

   !> Append numbers to a frame.
   pure subroutine place(frame, at, values, count)
      real(wp), intent(inout) :: frame(:)  !< [`frame_size`]
      integer, intent(inout) :: at  !< numbers in the frame so far
      integer, intent(in) :: count  !< of the values
      real(wp), intent(in) :: values(count)  !< to append

      frame(at + 1:at + count) = values
      at = at + count
   end subroutine place

   !> Vertex and edge from 0, state, bonded, joint from 0; distance, normal force, shear force,
   !> stretch.
   pure subroutine take_contacts(contacts, n, columns)
      type(contacts_type), intent(in) :: contacts  !< of the last step
      integer, intent(in) :: n  !< number of contacts
      real(wp), intent(out) :: columns(n, *)  !< [n, `contact_columns`] of the frame

      columns(:n, 1) = contacts%vertex(:n) - 1
      columns(:n, 2) = contacts%edge(:n) - 1
      columns(:n, 3) = contacts%state(:n)
      columns(:n, 4) = merge(1, 0, contacts%bonded(:n))
      columns(:n, 5) = contacts%joint(:n) - 1
      columns(:n, 6) = contacts%new_gap(:n) + contacts%offset(:n)
      columns(:n, 7) = contacts%normal_force(:n)
      columns(:n, 8) = contacts%shear_force(:n)
      columns(:n, 9) = contacts%stretch(:n)
      if (.not. contacts%with_laws) return
      columns(:n, 10) = contacts%length(:n)
      columns(:n, 11) = contacts%slip_path(:n)
      columns(:n, 12) = contacts%weakened(:n)
   end subroutine take_contacts

end module dda_sample
