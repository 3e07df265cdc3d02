! SPDX-License-Identifier: GPL-3.0-or-later
!> Reservoir water that moves with an upstream face: Westergaard's added mass.
!>
!> At a depth z below the level of a reservoir of depth H, the face has the mass (7/8) ρ √(Hz) per
!> area, in the direction of its normal (Westergaard 1933; for sloping faces Clough 1982).  With
!> s = √z the integrals over a straight face are polynomials of degree 6 in s, for which four Gauss
!> points are exact.  The mass belongs to the wet points of the initial geometry.
module dda_added_mass
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type, shape_matrix
   use dda_body_force, only: base_force
   use dda_edge_load, only: edge_load_type
   use dda_edge_part, only: edge_part_type, part_normal, reference_at
   use dda_element, only: element_type
   use dda_energy, only: energy_type, add_energy, energy_algorithmic, energy_input, energy_water
   use dda_linear_terms, only: linear_term_type, linear_terms_type, add_term, of_mass, &
      term_reservoir
   use dda_motion, only: motion_type
   use dda_scheme, only: step_type, end_rate, momentum_weight
   implicit none
   private
   public :: added_mass_type, new_added_mass

   integer, parameter :: points = 4  !< Gauss points on a straight face
   real(wp), parameter :: abscissa(points) = 0.5_wp + 0.5_wp*[-0.8611363115940526_wp, &
      -0.3399810435848563_wp, 0.3399810435848563_wp, 0.8611363115940526_wp]
   real(wp), parameter :: weight(points) = 0.5_wp*[0.3478548451374538_wp, 0.6521451548625461_wp, &
      0.6521451548625461_wp, 0.3478548451374538_wp]
   real(wp), parameter :: westergaard = 0.875_wp  !< 7/8
   real(wp), parameter :: standard_gravity = 9.81_wp  !< unit weight/density of water, m/s²

   !> A mass that moves with a point of a face, in the direction of the normal of the face.
   type :: wet_point_type
      type(edge_part_type) :: part
      real(wp) :: reference(2) = 0.0_wp  !< offset ρ, m
      real(wp) :: mass = 0.0_wp          !< kg per metre of thickness
   end type wet_point_type

   !> All added masses of a model.
   type, extends(element_type) :: added_mass_type
      type(wet_point_type), allocatable :: point(:)
      integer :: base_motion(2) = 0      !< motions of the base in x and y; 0: none
   contains
      procedure :: add_linear_terms, add_force, add_stored_energy, add_to_budget, freeze_for_statics
   end type added_mass_type

contains

   !> Create the masses of the reservoirs of a model.
   pure type(added_mass_type) function new_added_mass(loads, base_motion, motions, blocks) &
      result(self)
      type(edge_load_type), intent(in) :: loads(:)  !< loads of the model
      integer, intent(in) :: base_motion(2)         !< base motion of the model
      type(motion_type), intent(in) :: motions(:)   !< motions of the model
      type(blocks_type), intent(in) :: blocks       !< blocks in their present state
      integer :: i, k

      self%base_motion = base_motion
      self%motions = motions
      allocate (self%point(0))
      do i = 1, size(loads)
         if (.not. (loads(i)%present .and. loads(i)%reservoir > 0.0_wp)) cycle
         do k = 1, size(loads(i)%part)
            if (.not. blocks%removed(loads(i)%part(k)%block)) &
               self%point = [self%point, added_masses(loads(i), k, blocks)]
         end do
      end do
   end function new_added_mass

   !> Return the masses on part k of a load.
   pure function added_masses(load, k, blocks) result(point)
      type(edge_load_type), intent(in) :: load  !< load of a reservoir
      integer, intent(in) :: k                  !< number of the part
      type(blocks_type), intent(in) :: blocks   !< blocks in their present state
      type(wet_point_type), allocatable :: point(:)
      real(wp) :: depth(2), root(2), s, area
      integer :: i

      depth = load%level(1) - load%ends(2, :, k)
      allocate (point(0))
      if (maxval(depth) <= 0.0_wp) return
      root = sqrt(max(0.0_wp, depth))
      do i = 1, points
         s = root(1) + abscissa(i)*(root(2) - root(1))
         area = weight(i)*abs((root(2) - root(1))*2.0_wp*s/(depth(2) - depth(1))) &
            *norm2(load%ends(:, 2, k) - load%ends(:, 1, k))
         point = [point, wet_point_type(load%part(k), reference_at(blocks, load%part(k), &
            (s**2 - depth(1))/(depth(2) - depth(1))), &
            westergaard*load%unit_weight/standard_gravity*sqrt(load%reservoir)*s*area)]
      end do
   end function added_masses

   !> Return the row nᵀT of a point (T: `shape_matrix` of dda_blocks).
   pure function normal_row(point, blocks) result(row)
      type(wet_point_type), intent(in) :: point  !< point of a face
      type(blocks_type), intent(in) :: blocks    !< blocks in their present state
      real(wp) :: row(6)

      row = matmul(part_normal(blocks, point%part), shape_matrix(blocks, point%part%block, &
         point%reference))
   end function normal_row

   !> Append a mass term for each wet point.
   subroutine add_linear_terms(self, blocks, step, terms)
      class(added_mass_type), intent(in) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(step_type), intent(in) :: step  !< the present step
      type(linear_terms_type), intent(inout) :: terms  !< springs and dashpots
      type(linear_term_type) :: term
      integer :: i

      term%kind = term_reservoir
      term%instant = of_mass
      do i = 1, size(self%point)
         term%source = i
         term%block_a = self%point(i)%part%block
         term%coefficient = self%point(i)%mass
         term%row_a = normal_row(self%point(i), blocks)
         call add_term(terms, term)
      end do
   end subroutine add_linear_terms

   !> Add the momentum at the start of the step, and the inertia in the frame of the base.
   subroutine add_force(self, blocks, step, load)
      class(added_mass_type), intent(in) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(step_type), intent(in) :: step  !< the present step
      real(wp), intent(inout) :: load(:,:)  !< [6,blocks] forces, N/m …
      real(wp) :: row(6), force(2)
      integer :: i

      force = base_force(self%base_motion, self%motions, step)
      do i = 1, size(self%point)
         associate (point => self%point(i), b => self%point(i)%part%block)
            row = normal_row(point, blocks)
            load(:, b) = load(:, b) + point%mass*(momentum_weight(step) &
               *dot_product(row, blocks%velocity(:, b)) + dot_product(row(:2), force))*row
         end associate
      end do
   end subroutine add_force

   !> Add the kinetic energy of the water.
   subroutine add_stored_energy(self, blocks, step, energy)
      class(added_mass_type), intent(in) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(step_type), intent(in) :: step  !< the next step
      type(energy_type), intent(inout) :: energy  !< energy budget, J per metre
      integer :: i

      do i = 1, size(self%point)
         associate (point => self%point(i), b => self%point(i)%part%block)
            call add_energy(energy, energy_water, 0.5_wp*point%mass*dot_product(normal_row(point, &
               blocks), blocks%velocity(:, b))**2)
         end associate
      end do
   end subroutine add_stored_energy

   !> Add the kinetic energy, the loss and the work of the water in a step to the budget.  The loss
   !> by the scheme is (χ − ½) m Δv²; the work is the work of inertia in the frame of the base.
   subroutine add_to_budget(self, blocks, step, d, energy)
      class(added_mass_type), intent(in) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(step_type), intent(in) :: step  !< the present step
      real(wp), intent(in) :: d(:,:)  !< [6,blocks] increments of the coordinates
      type(energy_type), intent(inout) :: energy  !< energy budget, J per metre
      real(wp) :: row(6), force(2), displacement, velocity, end_velocity
      integer :: i

      force = base_force(self%base_motion, self%motions, step)
      do i = 1, size(self%point)
         associate (point => self%point(i), b => self%point(i)%part%block)
            row = normal_row(point, blocks)
            displacement = dot_product(row, d(:, b))
            velocity = dot_product(row, blocks%velocity(:, b))
            end_velocity = end_rate(step, displacement, velocity)
            call add_energy(energy, energy_water, 0.5_wp*point%mass*end_velocity**2)
            call add_energy(energy, energy_algorithmic, (step%scheme%chi - 0.5_wp)*point%mass &
               *(end_velocity - velocity)**2)
            call add_energy(energy, energy_input, point%mass*dot_product(row(:2), &
               force)*displacement)
         end associate
      end do
   end subroutine add_to_budget

   !> Stop the base motion in static stages.
   subroutine freeze_for_statics(self, blocks, time)
      class(added_mass_type), intent(inout) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      real(wp), intent(in) :: time  !< time, s

      self%base_motion = 0
   end subroutine freeze_for_statics

end module dda_added_mass
