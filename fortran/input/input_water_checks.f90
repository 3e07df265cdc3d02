! SPDX-License-Identifier: GPL-3.0-or-later
!> Checks that groups on water in joints do not contradict each other, in any stage.
module dda_input_water_checks
   use dda_kinds, only: wp
   use dda_edge_load, only: edge_load_type
   use dda_errors, only: error_type
   use dda_flow, only: acts_at, connected_nodes, find_boundary_pressure, flow_boundary_type, &
      flow_steady, flow_type
   use dda_input_group, only: group_type, fail_input, positions
   use dda_model, only: model_type
   use dda_text, only: to_text
   implicit none
   private
   public :: check_water

   real(wp), parameter :: tolerance = 1.0e-6_wp  !< relative difference of equal values

contains

   !> Check the water in joints: one fluid, and one pressure at a node.
   subroutine check_water(model, groups, error)
      type(model_type), intent(in) :: model      !< model with its stages
      type(group_type), intent(in) :: groups(:)  !< groups of the input, in its order
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(edge_load_type), allocatable :: loads(:)
      real(wp), allocatable :: unit_weight(:)
      logical :: has_steady
      integer :: s

      if (allocated(error) .or. .not. allocated(model%flow)) return
      has_steady = any([(model%flow%state(merge(1, 2, model%stages(s)%static)) == flow_steady, &
         s=1, size(model%stages))])
      call find_unit_weights(model%flow, groups, unit_weight, error)
      call check_boundaries(model, groups, unit_weight, has_steady, error)
      if (has_steady) call check_inflows(model%flow, groups, error)
      loads = model%edge_loads
      do s = 1, size(model%stages)
         associate (stage => model%stages(s), bolts => size(model%bolts))
            loads%present = (loads%present .or. stage%added(bolts + 1:)) .and. &
               .not. stage%dropped(bolts + 1:)
            call compare_boundaries(model%flow, groups, loads%present, unit_weight, error)
         end associate
      end do
   end subroutine check_water

   !> Find the unit weight at each node; it must be equal in connected joints.
   subroutine find_unit_weights(flow, groups, unit_weight, error)
      type(flow_type), intent(in) :: flow        !< flow of the model
      type(group_type), intent(in) :: groups(:)  !< groups of the input, in its order
      real(wp), allocatable, intent(out) :: unit_weight(:)   !< [nodes] N/m³
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer :: part(size(flow%pressure)), law_of(size(flow%pressure)), at(size(flow%law)), c

      allocate (unit_weight(size(part)))
      part = connected_nodes(flow, [(.false., c=1, size(flow%channel))])
      at = positions(groups, 'flow')
      law_of = 0
      do c = 1, size(flow%channel)
         associate (channel => flow%channel(c), law => law_of(part(flow%channel(c)%node(1))))
            if (law == 0) law = channel%law
            unit_weight(channel%node) = flow%law(channel%law)%unit_weight
            if (differ(flow%law(law)%unit_weight, flow%law(channel%law)%unit_weight)) &
               call fail_input(error, groups(at(channel%law)), 'unit_weight = '// &
               to_text(flow%law(channel%law)%unit_weight)//' differs from '// &
               to_text(flow%law(law)%unit_weight)//' of connected joints; one fluid flows in both')
         end associate
      end do
   end subroutine find_unit_weights

   !> Check the fluid and the least pressure of each boundary.
   subroutine check_boundaries(model, groups, unit_weight, has_steady, error)
      type(model_type), intent(in) :: model        !< model with flow
      type(group_type), intent(in) :: groups(:)    !< groups of the input, in its order
      real(wp), intent(in) :: unit_weight(:)       !< [nodes] N/m³
      logical, intent(in) :: has_steady            !< a stage has steady flow
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      real(wp) :: least(size(unit_weight))
      integer :: b, c, node

      associate (flow => model%flow)
         do c = 1, size(flow%channel)
            least(flow%channel(c)%node) = flow%law(flow%channel(c)%law)%cavitation
         end do
         where (has_steady .or. flow%saturation < 1.0_wp) least = 0.0_wp
         do b = 1, size(flow%boundary)
            associate (boundary => flow%boundary(b), group => groups(group_of(groups, flow, b)))
               node = boundary%node(1)
               if (boundary%load > 0) then
                  associate (own => model%edge_loads(boundary%load)%unit_weight)
                     if (differ(own, unit_weight(node))) call fail_input(error, group, &
                        'unit_weight = '//to_text(own)//' differs from '// &
                        to_text(unit_weight(node))//' of &flow in the joint at '// &
                        place_of(model%flow, node))
                  end associate
               end if
               if (boundary%inflow .or. boundary%head) cycle
               if (minval(boundary%value) < maxval(least(boundary%node))) call fail_input(error, &
                  group, 'pressure = '//to_text(minval(boundary%value))//' is below the least '// &
                  'pressure of the water, '//to_text(maxval(least(boundary%node)))// &
                  ' (cavitation_pressure; 0 in steady flow and with saturation below 1)')
            end associate
         end do
      end associate
   end subroutine check_boundaries

   !> Refuse an inflow in steady flow without a head or pressure that determines the pressures.
   subroutine check_inflows(flow, groups, error)
      type(flow_type), intent(in) :: flow        !< flow of the model
      type(group_type), intent(in) :: groups(:)  !< groups of the input, in its order
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer :: part(size(flow%pressure)), b, c
      logical :: has_head(size(flow%pressure))

      part = connected_nodes(flow, [(.false., c=1, size(flow%channel))])
      has_head = .false.
      do b = 1, size(flow%boundary)
         if (.not. flow%boundary(b)%inflow) has_head(part(flow%boundary(b)%node)) = .true.
      end do
      do b = 1, size(flow%boundary)
         associate (boundary => flow%boundary(b))
            if (.not. boundary%inflow .or. all(has_head(part(boundary%node)))) cycle
            if (any(abs(boundary%value) > 0.0_wp)) call fail_input(error, &
               groups(group_of(groups, flow, b)), 'steady flow with `inflow` needs a head or '// &
               'pressure at another node of the connected joints; add a &flow_boundary, or set '// &
               'another state and state_at_rest of &flow')
         end associate
      end do
   end subroutine check_inflows

   !> Compare the boundaries that act on the same node in a stage.
   subroutine compare_boundaries(flow, groups, loads_present, unit_weight, error)
      type(flow_type), intent(in) :: flow          !< flow of the model
      type(group_type), intent(in) :: groups(:)    !< groups of the input, in its order
      logical, intent(in) :: loads_present(:)      !< [edge loads] the load acts in the stage
      real(wp), intent(in) :: unit_weight(:)       !< [nodes] N/m³
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer :: owner(size(unit_weight)), b, i, round

      owner = 0
      do round = 1, 2  ! heads and pressures, then inflows
         do b = 1, size(flow%boundary)
            if (flow%boundary(b)%inflow .neqv. round == 2) cycle
            if (flow%boundary(b)%load > 0) then
               if (.not. loads_present(flow%boundary(b)%load)) cycle
            end if
            do i = 1, size(flow%boundary(b)%node)
               associate (node => flow%boundary(b)%node(i))
                  if (owner(node) > 0) call compare_pair(flow, groups, owner(node), b, node, &
                     unit_weight(node), error)
                  if (owner(node) == 0 .and. round == 1) owner(node) = b
                  if (allocated(error)) return
               end associate
            end do
         end do
      end do
   end subroutine compare_boundaries

   !> Refuse two boundaries with different values at a node, at any of their times.
   subroutine compare_pair(flow, groups, first, second, node, unit_weight, error)
      type(flow_type), intent(in) :: flow          !< flow of the model
      type(group_type), intent(in) :: groups(:)    !< groups of the input, in its order
      integer, intent(in) :: first, second         !< boundaries; the first has no inflow
      integer, intent(in) :: node                  !< number of the node
      real(wp), intent(in) :: unit_weight          !< N/m³
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      real(wp) :: time, pressure(2)
      logical :: is_open
      integer :: k

      associate (a => flow%boundary(first), b => flow%boundary(second), &
         group => groups(group_of(groups, flow, second)), &
         former => groups(group_of(groups, flow, first)), &
         elevation => unit_weight*flow%position(2, node))
         do k = 1, size(a%time) + size(b%time)
            if (k <= size(a%time)) time = a%time(k)
            if (k > size(a%time)) time = b%time(k - size(a%time))
            if (.not. (acts_at(a, time) .and. acts_at(b, time))) cycle
            call find_boundary_pressure(a, time, unit_weight, elevation, pressure(1), is_open)
            if (b%inflow .and. .not. is_open) call fail_input(error, group, 'an inflow at '// &
               place_of(flow, node)//' cannot be prescribed: '//former%location// &
               ' prescribes the pressure of this node')
            if (b%inflow) cycle
            call find_boundary_pressure(b, time, unit_weight, elevation, pressure(2), is_open)
            if (differ(pressure(1), pressure(2))) call fail_input(error, group, &
               'the node at '//place_of(flow, node)//' has the pressure '//to_text(pressure(2))// &
               ' Pa, but '//to_text(pressure(1))//' Pa by '//former%location)
         end do
      end associate
   end subroutine compare_pair

   !> .true. if two values differ by more than rounding.
   pure logical function differ(a, b)
      real(wp), intent(in) :: a, b  !< values

      differ = abs(a - b) > tolerance*max(abs(a), abs(b))
   end function differ

   !> Return the position in the input of the group of a boundary.
   pure integer function group_of(groups, flow, b)
      type(group_type), intent(in) :: groups(:)  !< groups of the input, in its order
      type(flow_type), intent(in) :: flow        !< flow of the model
      integer, intent(in) :: b                   !< number of the boundary
      integer, allocatable :: list(:)
      integer :: i

      if (flow%boundary(b)%load > 0) then
         list = pack([(i, i=1, size(groups))], [(groups(i)%name == 'water' .or. groups(i)%name == &
            'traction', i=1, size(groups))])  ! numbered like the edge loads
         group_of = list(flow%boundary(b)%load)
      else
         list = positions(groups, 'flow_boundary')  ! these boundaries come first
         group_of = list(b)
      end if
   end function group_of

   !> Return the place of a node.
   pure function place_of(flow, node) result(text)
      type(flow_type), intent(in) :: flow  !< flow of the model
      integer, intent(in) :: node          !< number of the node
      character(len=:), allocatable :: text

      text = '('//to_text(flow%position(:, node) + flow%origin)//')'
   end function place_of

end module dda_input_water_checks
