! SPDX-License-Identifier: GPL-3.0-or-later
!> Loads on edges at t₀ + θΔt: tractions and water pressure, by exact integrals of ∫ Tᵀ f ds.
!>
!> Pressure is linear between the positions at which an edge crosses a water level, the phreatic
!> line or the abscissa of a point of this line.  Two Gauss points are exact, because the shape
!> matrix is linear too.  Full hydrostatic pressure around a block equals its buoyancy to rounding
!> errors.  Loads use the ends and normals at the start of the step.
module dda_edge_loads
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type, position_of, shape_matrix
   use dda_edge_load, only: edge_load_type, values_at, load_uniform, load_level, load_surface, &
      load_line
   use dda_edge_part, only: edge_part_type, reference_at
   use dda_element, only: element_type
   use dda_energy, only: energy_type, add_energy, energy_input
   use dda_scheme, only: step_type, load_time
   implicit none
   private
   public :: edge_loads_type

   real(wp), parameter :: first_gauss = 0.5_wp - 0.5_wp/sqrt(3.0_wp)  !< first Gauss point, 0 … 1
   real(wp), parameter :: end_tolerance = 1.0e-9_wp  !< relative, for a phreatic line

   !> All loads on edges of a model.
   type, extends(element_type) :: edge_loads_type
      type(edge_load_type), allocatable :: load(:)
      logical :: frozen = .false.       !< loads are constant, with their values at `time`
      real(wp) :: time = 0.0_wp         !< s
   contains
      procedure :: add_force, add_to_budget, freeze_for_statics
   end type edge_loads_type

contains

   !> Add the forces ∫ Tᵀ f ds.
   subroutine add_force(self, blocks, step, load)
      class(edge_loads_type), intent(in) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(step_type), intent(in) :: step  !< the present step
      real(wp), intent(inout) :: load(:,:)  !< [6,blocks] forces, N/m …
      integer :: i, k, b

      do i = 1, size(self%load)
         if (.not. self%load(i)%present) cycle
         do k = 1, size(self%load(i)%part)
            b = self%load(i)%part(k)%block
            if (.not. blocks%removed(b)) load(:, b) = load(:, b) &
               + force_on_part(self%load(i), k, blocks, load_instant(self, step))
         end do
      end do
   end subroutine add_force

   !> Add the work f·d to the budget.
   subroutine add_to_budget(self, blocks, step, d, energy)
      class(edge_loads_type), intent(in) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(step_type), intent(in) :: step  !< the present step
      real(wp), intent(in) :: d(:,:)  !< [6,blocks] increments of the coordinates
      type(energy_type), intent(inout) :: energy  !< energy budget, J per metre
      integer :: i, k, b

      do i = 1, size(self%load)
         if (.not. self%load(i)%present) cycle
         do k = 1, size(self%load(i)%part)
            b = self%load(i)%part(k)%block
            if (.not. blocks%removed(b)) call add_energy(energy, energy_input, &
               dot_product(force_on_part(self%load(i), k, blocks, load_instant(self, step)), &
               d(:, b)))
         end do
      end do
   end subroutine add_to_budget

   !> Return the time of the loads of a step, s.
   pure real(wp) function load_instant(self, step)
      class(edge_loads_type), intent(in) :: self  !< elements of this kind
      type(step_type), intent(in) :: step  !< the present step

      load_instant = merge(self%time, load_time(step), self%frozen)
   end function load_instant

   !> Return the generalised force of a load on part k: N per metre; N for rotation and strains.
   pure function force_on_part(load, k, blocks, time) result(force)
      type(edge_load_type), intent(in) :: load  !< load
      integer, intent(in) :: k  !< number of the part
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      real(wp), intent(in) :: time  !< time, s
      real(wp) :: force(6)
      real(wp) :: ends(2, 2), values(3)
      integer :: i

      force = 0.0_wp
      if (.not. load%acts_always .and. (time < load%time(1) .or. time > &
         load%time(size(load%time)))) return
      ends = load%ends(:, :, k)
      if (load%follows) then
         associate (part => load%part(k))
            do i = 1, 2
               ends(:, i) = position_of(blocks, part%block, reference_at(blocks, part, i - 1.0_wp))
            end do
         end associate
      end if
      values = values_at(load, time)
      associate (factor => values(1), shear => values(2), rise => values(3))
         select case (load%kind)
         case (load_uniform)
            call add_linear_traction(force, load%part(k), blocks, ends, [0.0_wp, 1.0_wp], &
               [factor, factor], shear)
         case (load_level)
            call add_wet_pressure(force, load%part(k), blocks, ends, [0.0_wp, 1.0_wp], &
               load%unit_weight*(rise - ends(2, :)), 1.0_wp)
         case (load_surface)
            call add_below_line(force, load, k, blocks, ends, rise, factor)
         case (load_line)
            call add_wet_pressure(force, load%part(k), blocks, ends, [0.0_wp, 1.0_wp], &
               load%at_ends(:, k) + load%unit_weight*rise, factor)
         end select
      end associate
   end function force_on_part

   !> Add hydrostatic pressure below a phreatic line, which is straight between its points.
   pure subroutine add_below_line(force, load, k, blocks, ends, rise, factor)
      real(wp), intent(inout) :: force(6)  !< force, N/m …
      type(edge_load_type), intent(in) :: load  !< load with a phreatic line
      integer, intent(in) :: k  !< number of the part
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      real(wp), intent(in) :: ends(2, 2)  !< ends of the part, m
      real(wp), intent(in) :: rise, factor  !< rise of the phreatic line, m; factor of the pressure
      real(wp) :: span(2), head(2), x(2), tolerance
      integer :: j

      associate (line => load%line)
         tolerance = end_tolerance*(line(1, size(line, 2)) - line(1, 1))
         do j = 1, size(line, 2) - 1
            span = fractions_between(ends(1, :), line(1, j) - merge(tolerance, 0.0_wp, j == 1), &
               line(1, j + 1) + merge(tolerance, 0.0_wp, j == size(line, 2) - 1))
            if (span(2) <= span(1)) cycle
            x = ends(1, 1) + span*(ends(1, 2) - ends(1, 1))
            head = line(2, j) + (x - line(1, j))*(line(2, j + 1) - line(2, j)) &
               /(line(1, j + 1) - line(1, j)) + rise
            call add_wet_pressure(force, load%part(k), blocks, ends, span, &
               load%unit_weight*(head - ends(2, 1) - span*(ends(2, 2) - ends(2, 1))), factor)
            if (ends(1, 1) == ends(1, 2)) return  ! a vertical edge
         end do
      end associate
   end subroutine add_below_line

   !> Return the interval of an edge, as fractions, between two abscissae; first > last: empty.
   pure function fractions_between(x, lower, upper) result(span)
      real(wp), intent(in) :: x(2)       !< abscissae of the ends of the edge, m
      real(wp), intent(in) :: lower, upper  !< m
      real(wp) :: span(2)

      span = merge([0.0_wp, 1.0_wp], [1.0_wp, 0.0_wp], x(1) >= lower .and. x(1) <= upper)
      if (x(1) == x(2)) return
      span = ([lower, upper] - x(1))/(x(2) - x(1))
      span = [max(0.0_wp, minval(span)), min(1.0_wp, maxval(span))]
   end function fractions_between

   !> Add the positive part of a linear pressure over a part of an edge.
   pure subroutine add_wet_pressure(force, part, blocks, ends, span, pressure, factor)
      real(wp), intent(inout) :: force(6)  !< force, N/m …
      type(edge_part_type), intent(in) :: part  !< part of an edge
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      real(wp), intent(in) :: ends(2, 2)  !< ends of the part, m
      real(wp), intent(in) :: span(2)  !< start and end as fractions of the part
      real(wp), intent(in) :: pressure(2)  !< pressure at start and end, Pa
      real(wp), intent(in) :: factor  !< factor of the pressure
      real(wp) :: wet(2), dry

      if (maxval(pressure) <= 0.0_wp) return
      wet = span
      if (minval(pressure) < 0.0_wp) then
         dry = span(1) + (span(2) - span(1))*pressure(1)/(pressure(1) - pressure(2))
         wet(merge(1, 2, pressure(1) < 0.0_wp)) = dry
      end if
      call add_linear_traction(force, part, blocks, ends, wet, factor*max(pressure, 0.0_wp), 0.0_wp)
   end subroutine add_wet_pressure

   !> Add ∫ Tᵀ (−p n + τ t) ds over a part of an edge, p linear and τ constant.
   pure subroutine add_linear_traction(force, part, blocks, ends, span, pressure, shear)
      real(wp), intent(inout) :: force(6)  !< force, N/m …
      type(edge_part_type), intent(in) :: part  !< part of an edge
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      real(wp), intent(in) :: ends(2, 2)  !< ends of the part, m
      real(wp), intent(in) :: span(2)  !< start and end as fractions of the part
      real(wp), intent(in) :: pressure(2)  !< pressure at start and end, Pa
      real(wp), intent(in) :: shear  !< shear in the counter-clockwise sense, Pa
      real(wp) :: edge(2), fraction, p
      integer :: i

      edge = ends(:, 2) - ends(:, 1)
      do i = 1, 2
         fraction = merge(first_gauss, 1.0_wp - first_gauss, i == 1)
         p = pressure(1) + fraction*(pressure(2) - pressure(1))
         force = force + 0.5_wp*(span(2) - span(1))*matmul(shear*edge - p*[edge(2), -edge(1)], &
            shape_matrix(blocks, part%block, reference_at(blocks, part, span(1) &
            + fraction*(span(2) - span(1)))))
      end do
   end subroutine add_linear_traction

   !> Fix the loads in static stages at their values at a given time.
   subroutine freeze_for_statics(self, blocks, time)
      class(edge_loads_type), intent(inout) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      real(wp), intent(in) :: time  !< time, s

      self%frozen = .true.
      self%time = time
   end subroutine freeze_for_statics

end module dda_edge_loads
