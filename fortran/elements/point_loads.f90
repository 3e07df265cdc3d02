! SPDX-License-Identifier: GPL-3.0-or-later
!> Point loads: force histories at material points, evaluated at t₀ + θΔt.
module dda_point_loads
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type, motion_of, shape_matrix
   use dda_element, only: element_type
   use dda_energy, only: energy_type, add_energy, energy_input
   use dda_scheme, only: step_type, load_time
   use dda_support, only: load_type, load_at
   implicit none
   private
   public :: point_loads_type

   !> All point loads of a model.
   type, extends(element_type) :: point_loads_type
      type(load_type), allocatable :: load(:)
   contains
      procedure :: add_force, add_to_budget, freeze_for_statics
   end type point_loads_type

contains

   !> Add the forces Tᵀ f.
   subroutine add_force(self, blocks, step, load)
      class(point_loads_type), intent(in) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(step_type), intent(in) :: step  !< the present step
      real(wp), intent(inout) :: load(:,:)  !< [6,blocks] forces, N/m …
      integer :: i, b

      do i = 1, size(self%load)
         b = self%load(i)%block
         load(:, b) = load(:, b) + matmul(load_at(self%load(i), load_time(step)), &
            shape_matrix(blocks, b, self%load(i)%reference))
      end do
   end subroutine add_force

   !> Add the work f·Td to the budget.
   subroutine add_to_budget(self, blocks, step, d, energy)
      class(point_loads_type), intent(in) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(step_type), intent(in) :: step  !< the present step
      real(wp), intent(in) :: d(:,:)  !< [6,blocks] increments of the coordinates
      type(energy_type), intent(inout) :: energy  !< energy budget, J per metre
      integer :: i, b

      do i = 1, size(self%load)
         b = self%load(i)%block
         call add_energy(energy, energy_input, dot_product(load_at(self%load(i), &
            load_time(step)), motion_of(blocks, b, self%load(i)%reference, d(:, b))))
      end do
   end subroutine add_to_budget

   !> Fix the forces in static stages at their values at a given time.
   subroutine freeze_for_statics(self, blocks, time)
      class(point_loads_type), intent(inout) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      real(wp), intent(in) :: time  !< time, s
      real(wp), parameter :: infinity = 0.5_wp*huge(1.0_wp)
      integer :: i

      do i = 1, size(self%load)
         self%load(i)%force = spread(load_at(self%load(i), time), 2, 2)
         self%load(i)%time = [-infinity, infinity]
         self%load(i)%start = 0.0_wp
      end do
   end subroutine freeze_for_statics

end module dda_point_loads
