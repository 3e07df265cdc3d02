! SPDX-License-Identifier: GPL-3.0-or-later
!> Body force per unit mass at t₀ + θΔt: gravity minus the acceleration of the base, if the model is
!> in the frame of the base.
module dda_body_force
   use dda_kinds, only: wp
   use dda_baseline, only: step_acceleration
   use dda_blocks, only: blocks_type
   use dda_element, only: element_type
   use dda_energy, only: energy_type, add_energy, energy_gravity, energy_input
   use dda_motion, only: motion_type
   use dda_ordered_sums, only: pieces, first_of, last_of, most_pieces, parallel_from
   use dda_scheme, only: step_type, end_time, load_time
   implicit none
   private
   public :: body_force_type, base_force

   !> Gravity and base acceleration.
   type, extends(element_type) :: body_force_type
      real(wp) :: gravity(2) = 0.0_wp   !< m/s²
      integer :: base_motion(2) = 0     !< motions of the base in x and y; 0: none
   contains
      procedure :: add_force, add_to_budget, freeze_for_statics
   end type body_force_type

contains

   !> Return the negative base acceleration, m/s²; zero in static stages.
   pure function base_force(base_motion, motions, step) result(force)
      integer, intent(in) :: base_motion(2)       !< motions of the base in x and y; 0: none
      type(motion_type), intent(in) :: motions(:)  !< prescribed motions
      type(step_type), intent(in) :: step  !< the present step
      real(wp) :: force(2)
      integer :: axis

      force = 0.0_wp
      do axis = 1, 2
         if (base_motion(axis) == 0) cycle
         force(axis) = -step_acceleration(motions(base_motion(axis))%curve, step%time, &
            end_time(step), load_time(step))
      end do
   end function base_force

   !> Add the forces m (g − a) of all blocks.
   subroutine add_force(self, blocks, step, load)
      class(body_force_type), intent(in) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(step_type), intent(in) :: step  !< the present step
      real(wp), intent(inout) :: load(:,:)  !< [6,blocks] forces, N/m …
      real(wp) :: force(2)
      integer :: b

      force = self%gravity + base_force(self%base_motion, self%motions, step)
      do b = 1, blocks%n
         load(1:2, b) = load(1:2, b) + blocks%mass(b)*force
      end do
   end subroutine add_force

   !> Add the potential of gravity and the work of the base acceleration to the budget.
   subroutine add_to_budget(self, blocks, step, d, energy)
      class(body_force_type), intent(in) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(step_type), intent(in) :: step  !< the present step
      real(wp), intent(in) :: d(:,:)  !< [6,blocks] increments of the coordinates
      type(energy_type), intent(inout) :: energy  !< energy budget, J per metre
      real(wp) :: partial(2, most_pieces), moment(2)
      integer :: p

      if (blocks%n < parallel_from) then
         moment = sum_mass_increments(blocks, d, 1, blocks%n)
      else
         !$omp parallel do schedule(static)
         do p = 1, pieces(blocks%n)
            partial(:, p) = sum_mass_increments(blocks, d, first_of(p, blocks%n), last_of(p, &
               blocks%n))
         end do
         moment = sum(partial(:, :pieces(blocks%n)), 2)
      end if
      call add_energy(energy, energy_gravity, -dot_product(self%gravity, moment))
      call add_energy(energy, energy_input, dot_product( &
         base_force(self%base_motion, self%motions, step), moment))
   end subroutine add_to_budget

   !> Stop base motions in static stages, so that only gravity acts.
   subroutine freeze_for_statics(self, blocks, time)
      class(body_force_type), intent(inout) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      real(wp), intent(in) :: time  !< time, s

      self%base_motion = 0
   end subroutine freeze_for_statics

   !> Sum m d of blocks first … last.
   pure function sum_mass_increments(blocks, d, first, last) result(moment)
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      real(wp), intent(in) :: d(:,:)  !< [6,blocks] increments of the coordinates
      integer, intent(in) :: first, last  !< first and last index
      real(wp) :: moment(2)
      integer :: b

      moment = 0.0_wp
      do b = first, last
         moment = moment + blocks%mass(b)*d(1:2, b)
      end do
   end function sum_mass_increments

end module dda_body_force
