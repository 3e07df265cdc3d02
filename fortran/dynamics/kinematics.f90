! SPDX-License-Identifier: GPL-3.0-or-later
!> Update of the coordinates and velocities of the blocks in each step (see `dda_scheme`).
module dda_kinematics
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type, momentum_of, update_geometry
   use dda_material_damping, only: update_memories
   use dda_ordered_sums, only: pieces, first_of, last_of, most_pieces, parallel_from
   use dda_scheme, only: step_type, momentum_weight, velocity_weight
   implicit none
   private
   public :: damp_velocity, predict, integrate, kinetic_energy, largest_displacement

contains

   !> Multiply the velocities at the start of a step by the dynamic factor; return the energy loss.
   subroutine damp_velocity(blocks, dynamic_factor, loss)
      type(blocks_type), intent(inout) :: blocks  !< blocks in their present state
      real(wp), intent(in) :: dynamic_factor  !< factor of the velocity
      real(wp), intent(out) :: loss  !< energy loss, J per metre of thickness
      real(wp) :: initial_energy

      loss = 0.0_wp
      if (dynamic_factor == 1.0_wp) return
      initial_energy = kinetic_energy(blocks)
      blocks%velocity = dynamic_factor*blocks%velocity
      loss = initial_energy - kinetic_energy(blocks)
   end subroutine damp_velocity

   !> Predict the increment of a step from the last four mean velocities, for iterative solvers.
   !> The characteristic equation is (z − 1)³(z + 1) = 0.  The prediction is therefore exact for a
   !> linear acceleration and for stiff modes, whose velocity changes sign in each step.
   subroutine predict(blocks, d, step)
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      real(wp), intent(out) :: d(6, blocks%n)  !< increments of the coordinates
      type(step_type), intent(in) :: step  !< the present step
      integer :: p

      if (blocks%n < parallel_from) then
         call predict_range(blocks, d, step, 1, blocks%n)
         return
      end if
      !$omp parallel do schedule(static)
      do p = 1, pieces(blocks%n)
         call predict_range(blocks, d, step, first_of(p, blocks%n), last_of(p, blocks%n))
      end do
   end subroutine predict

   !> Predict the increment of blocks first … last.
   pure subroutine predict_range(blocks, d, step, first, last)
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      real(wp), intent(inout) :: d(6, blocks%n)  !< increments of the coordinates
      type(step_type), intent(in) :: step  !< the present step
      integer, intent(in) :: first, last  !< first and last block
      integer :: b

      do b = first, last
         associate (mean => blocks%mean_velocity(:, :, b))
            d(:, b) = step%time_step*(2*(mean(:, 1) - mean(:, 3)) + mean(:, 4))
         end associate
      end do
   end subroutine predict_range

   !> Accept the step: new coordinates, velocities, accelerations and vertices.
   subroutine integrate(blocks, d, step)
      type(blocks_type), intent(inout) :: blocks  !< blocks in their present state
      real(wp), intent(in) :: d(:,:)      !< [6,n] increments of the coordinates
      type(step_type), intent(in) :: step  !< the present step
      integer :: p

      if (blocks%damps) call update_memories(blocks, step, d)
      if (blocks%n < parallel_from) then
         call integrate_range(blocks, d, step, 1, blocks%n)
      else
         !$omp parallel do schedule(static)
         do p = 1, pieces(blocks%n)
            call integrate_range(blocks, d, step, first_of(p, blocks%n), last_of(p, blocks%n))
         end do
      end if
      call update_geometry(blocks)
   end subroutine integrate

   !> Update blocks first … last.
   pure subroutine integrate_range(blocks, d, step, first, last)
      type(blocks_type), intent(inout) :: blocks  !< blocks in their present state
      real(wp), intent(in) :: d(6, blocks%n)  !< increments of the coordinates
      type(step_type), intent(in) :: step  !< the present step
      integer, intent(in) :: first, last  !< first and last block
      integer :: b

      do b = first, last
         call store_mean_velocity(d(:, b), step%time_step, blocks%mean_velocity(:, :, b))
      end do
      call integrate_coordinates(6*(last - first + 1), momentum_weight(step), &
         velocity_weight(step), step%time_step, d(:, first), blocks%position(:, first), &
         blocks%velocity(:, first), blocks%acceleration(:, first))
   end subroutine integrate_range

   !> Store the mean velocity of a step before those of the last three steps.
   pure subroutine store_mean_velocity(d, time_step, mean_velocity)
      real(wp), intent(in) :: d(6), time_step  !< increments of the coordinates; Δt, s
      real(wp), intent(inout) :: mean_velocity(6, 4)  !< see `blocks_type`
      real(wp) :: latest(6)
      integer :: i

      !GCC$ unroll 1
      do i = 1, 6  ! unrolled, the loop would not be vectorised
         latest(i) = d(i)/time_step
      end do
      mean_velocity(:, 4) = mean_velocity(:, 3)
      mean_velocity(:, 3) = mean_velocity(:, 2)
      mean_velocity(:, 2) = mean_velocity(:, 1)
      mean_velocity(:, 1) = latest
   end subroutine store_mean_velocity

   !> Update n coordinates; a loop over those of all blocks can be vectorised.
   pure subroutine integrate_coordinates(n, weight, former_weight, time_step, d, position, &
      velocity, acceleration)
      integer, intent(in) :: n             !< number of coordinates
      real(wp), intent(in) :: weight, former_weight  !< weights of d, 1/s, and of v in the new v
      real(wp), intent(in) :: time_step    !< Δt, s
      real(wp), intent(in) :: d(n)         !< increments of the coordinates
      real(wp), intent(inout) :: position(n), velocity(n)
      real(wp), intent(out) :: acceleration(n)
      real(wp) :: new
      integer :: i

      do i = 1, n
         new = weight*d(i) - former_weight*velocity(i)
         acceleration(i) = (new - velocity(i))/time_step
         velocity(i) = new
         position(i) = position(i) + d(i)
      end do
   end subroutine integrate_coordinates

   !> Return the kinetic energy ½ vᵀMv, J/m.
   real(wp) function kinetic_energy(blocks)
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      real(wp) :: part(most_pieces)
      integer :: p

      if (blocks%n < parallel_from) then
         kinetic_energy = kinetic_energy_range(blocks, 1, blocks%n)
         return
      end if
      !$omp parallel do schedule(static)
      do p = 1, pieces(blocks%n)
         part(p) = kinetic_energy_range(blocks, first_of(p, blocks%n), last_of(p, blocks%n))
      end do
      kinetic_energy = sum(part(:pieces(blocks%n)))
   end function kinetic_energy

   !> Return the kinetic energy of blocks first … last, J/m.
   pure real(wp) function kinetic_energy_range(blocks, first, last)
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      integer, intent(in) :: first, last  !< first and last block
      integer :: b

      kinetic_energy_range = 0.0_wp
      do b = first, last
         kinetic_energy_range = kinetic_energy_range + 0.5_wp*dot_product(blocks%velocity(:, b), &
            momentum_of(blocks%inertia(:, b), blocks%velocity(:, b)))
      end do
   end function kinetic_energy_range

   !> Return an upper bound on the displacement of any vertex due to d, m.
   real(wp) function largest_displacement(blocks, d) result(move)
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      real(wp), intent(in) :: d(:,:)  !< [6,blocks] increments of the coordinates
      integer :: p

      if (blocks%n < parallel_from) then
         move = farthest_in_range(blocks, d, 1, blocks%n)
         return
      end if
      move = 0.0_wp
      !$omp parallel do reduction(max:move) schedule(static)
      do p = 1, pieces(blocks%n)
         move = max(move, farthest_in_range(blocks, d, first_of(p, blocks%n), last_of(p, blocks%n)))
      end do
   end function largest_displacement

   pure real(wp) function farthest_in_range(blocks, d, first, last) result(move)
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      real(wp), intent(in) :: d(:,:)  !< [6,blocks] increments of the coordinates
      integer, intent(in) :: first, last  !< first and last block
      integer :: b

      move = 0.0_wp
      do b = first, last
         move = max(move, sqrt(sum(d(1:2, b)**2)) + blocks%radius(b)*(abs(d(3, b)) &
            + sqrt(sum(d(4:6, b)**2))))
      end do
   end function farthest_in_range

end module dda_kinematics
