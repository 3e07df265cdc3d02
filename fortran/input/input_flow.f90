! SPDX-License-Identifier: GPL-3.0-or-later
!> Groups &flow and &flow_boundary: the network of water in joints.
module dda_input_flow
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type
   use dda_counting_sort, only: sort_by_key
   use dda_edge_load, only: load_level, load_surface, load_uniform
   use dda_errors, only: error_type
   use dda_flow, only: channel_type, connected_nodes, flow_boundary_type, flow_law_type, &
      flow_states, flow_type, flow_transient, flow_undrained
   use dda_input_edges, only: read_polyline
   use dda_input_group, only: group_type, fail_input, given, is_set, positions, value_or, mark_names
   use dda_input_groups, only: flow_boundary_values, flow_values, read_values
   use dda_input_points, only: set_times, set_values
   use dda_interpolation, only: table_value
   use dda_model, only: model_type
   use dda_neighbours, only: find_near_pairs, neighbours_type
   use dda_outline, only: common_span, sides, touching
   use dda_text, only: to_text
   implicit none
   private
   public :: read_flow

   real(wp), parameter :: min_length = 1.0e-6_wp  !< smallest length of a channel/edge length

   !> most nodes with flow, which a dense factor solves together (4000: some seconds per step)
   integer, parameter :: max_nodes = 4000
   !> most nodes × blocks² of transient flow, which are added to K̂ (4e8: some seconds per step)
   real(wp), parameter :: max_springs = 4.0e8_wp

contains

   !> Read the groups &flow and &flow_boundary of an input.
   subroutine read_flow(model, groups, error)
      type(model_type), intent(inout) :: model  !< model with its blocks and edge loads
      type(group_type), intent(in) :: groups(:)  !< groups of the input, in its order
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(flow_values), allocatable :: input(:)
      type(flow_boundary_values) :: unused
      integer :: law_of(size(model%joints)), i
      integer, allocatable :: at(:), boundary(:)

      at = positions(groups, 'flow')
      boundary = positions(groups, 'flow_boundary')
      if (size(at) == 0) then
         if (size(boundary) == 0) return
         call read_values(groups(boundary(1)), unused, error)
         call fail_input(error, groups(boundary(1)), 'no water flows in joints; give a group &flow')
         return
      end if
      allocate (model%flow, input(size(at)))
      allocate (model%flow%law(size(at)), model%flow%boundary(0))
      law_of = 0
      do i = 1, size(at)
         call read_law(model, groups(at(i)), i, input(i), law_of, error)
      end do
      if (allocated(error)) return
      call find_channels(model%flow, model%blocks, law_of, &
         [(value_or(input(i)%channel_length, huge(1.0_wp)), i=1, size(input))])
      if (size(model%flow%channel) == 0) call fail_input(error, groups(at(1)), &
         'no edge with one of these joints touches another edge along its length')
      call limit_nodes(model%flow, groups(at(1)), error)
      model%flow%origin = model%origin
      call set_first_state(model%flow, input, model%origin(2))
      do i = 1, size(boundary)
         call read_boundary(model, groups(boundary(i)), error)
      end do
      call set_water(model, groups, error)
   end subroutine read_flow

   !> Reject more connected nodes with flow than can be solved together.
   subroutine limit_nodes(flow, group, error)
      type(flow_type), intent(in) :: flow    !< with its nodes
      type(group_type), intent(in) :: group  !< group of the input
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer, allocatable :: sizes(:,:)
      integer :: largest_part(2)

      if (allocated(error) .or. all(flow%state == flow_undrained)) return
      sizes = part_sizes(flow)
      if (maxval(sizes(1, :)) > max_nodes) call fail_input(error, group, 'the joints have '// &
         to_text(maxval(sizes(1, :)))//' connected nodes, and at most '//to_text(max_nodes)// &
         ' can be solved together; give state = ''undrained'' and state_at_rest = ''undrained'',' &
         //' or select fewer joints')
      largest_part = sizes(:, maxloc(sizes(1, :)*real(sizes(2, :), wp)**2, 1))
      if (largest_part(1)*real(largest_part(2), wp)**2 > max_springs .and. any(flow%state == &
         flow_transient)) call fail_input(error, group, 'transient flow with '// &
         to_text(largest_part(1))//' connected nodes beside '// &
         to_text(largest_part(2))//' blocks requires too much time and memory (nodes × '// &
         'blocks² above 4e8); give another state and state_at_rest, or select fewer joints')
   end subroutine limit_nodes

   !> Return the numbers of nodes and of blocks beside them for each part of connected nodes.
   pure function part_sizes(flow) result(sizes)
      type(flow_type), intent(in) :: flow  !< with its nodes and channels
      integer, allocatable :: sizes(:,:)   !< [2,nodes] values at the first node of a part, else 0
      integer :: part(size(flow%position, 2)), i, side
      integer, allocatable :: start(:), order(:), last_part(:)

      part = connected_nodes(flow, [(.false., i=1, size(flow%channel))])
      allocate (sizes(2, size(part)), source=0)
      allocate (last_part(maxval([(flow%channel(i)%block, i=1, size(flow%channel))])), source=0)
      do i = 1, size(part)
         sizes(1, part(i)) = sizes(1, part(i)) + 1
      end do
      call sort_by_key(size(part), [(part(flow%channel(i)%node(1)), i=1, size(flow%channel))], &
         start, order)
      do i = 1, size(order)
         associate (channel => flow%channel(order(i)), p => part(flow%channel(order(i))%node(1)))
            do side = 1, 2
               if (last_part(channel%block(side)) == p) cycle
               last_part(channel%block(side)) = p
               sizes(2, p) = sizes(2, p) + 1
            end do
         end associate
      end do
   end function part_sizes

   !> Read the law of the water in the joints of a group; the first group sets the flow state.
   subroutine read_law(model, group, i, input, law_of, error)
      type(model_type), intent(inout) :: model   !< model with flow
      type(group_type), intent(in) :: group      !< group of the input
      integer, intent(in) :: i                   !< number of the group
      type(flow_values), intent(out) :: input      !< values of the group
      integer, intent(inout) :: law_of(:)        !< [joints] group of each joint; 0: none
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      logical :: is_selected(size(law_of))

      if (allocated(error)) return
      call read_values(group, input, error)
      is_selected = input%joints == ''
      call mark_names(input%joints, 'joints', model%joints%name, group, is_selected, error)
      if (allocated(error)) return
      if (any(is_selected .and. law_of > 0)) call fail_input(error, group, 'joint '// &
         trim(model%joints(findloc(is_selected .and. law_of > 0, .true., 1))%name)// &
         ' belongs to another group &flow; set different joints in each group')
      where (is_selected) law_of = i
      if (i == 1) then
         model%flow%state = [findloc(flow_states, input%state_at_rest, 1), &
            findloc(flow_states, input%state, 1)]
      else if (given(group, 'state') .or. given(group, 'state_at_rest')) then
         call fail_input(error, group, '`state` applies to all groups &flow; set it in the '// &
            'first group')
      end if
      model%flow%law(i) = flow_law_type(input%aperture, value_or(input%residual_aperture, &
         0.1_wp*input%aperture), value_or(input%max_aperture, 10.0_wp*input%aperture), &
         input%opening_factor, input%viscosity, input%bulk_modulus, input%unit_weight, &
         input%cavitation_pressure)
      associate (law => model%flow%law(i))
         if (input%pressure < law%cavitation) call fail_input(error, group, 'pressure = '// &
            to_text(input%pressure)//' is below cavitation_pressure = '//to_text(law%cavitation))
         if (law%min_aperture > law%aperture .or. law%max_aperture < &
            law%aperture) call fail_input(error, group, 'aperture = '// &
            to_text(law%aperture)//' is not between residual_aperture = '// &
            to_text(law%min_aperture)//' and max_aperture = '//to_text(law%max_aperture))
      end associate
   end subroutine read_law

   !> Find channels wherever edges of two blocks lie along each other.
   subroutine find_channels(flow, blocks, law_of, max_length)
      type(flow_type), intent(inout) :: flow   !< flow; receives channels and positions of nodes
      type(blocks_type), intent(in) :: blocks  !< blocks in their initial state
      integer, intent(in) :: law_of(:)         !< [joints] group of each joint; 0: none
      real(wp), intent(in) :: max_length(:)       !< [groups] longest channel, m
      type(neighbours_type) :: neighbours
      integer :: p, e, f, law, n

      allocate (flow%channel(16), flow%position(2, 0))
      n = 0
      call find_near_pairs(neighbours, blocks, 4*touching*blocks%half_size)
      do p = 1, neighbours%n_pairs
         associate (a => neighbours%pair(1, p), b => neighbours%pair(2, p))
            do e = blocks%first(a), blocks%first(a + 1) - 1
               if (blocks%inner(e)) cycle
               do f = blocks%first(b), blocks%first(b + 1) - 1
                  if (blocks%inner(f)) cycle
                  law = law_of(blocks%joint(e))
                  if (law == 0) law = law_of(blocks%joint(f))
                  if (law > 0) call add_channels(flow%channel, n, blocks, [e, f], law, &
                     max_length(law))
               end do
            end do
         end associate
      end do
      flow%channel = flow%channel(:n)
      call number_nodes(flow, blocks)
      n = size(flow%position, 2)
      allocate (flow%pressure(n), source=0.0_wp)
      allocate (flow%saturation(n), source=1.0_wp)
   end subroutine find_channels

   !> Add the channels of two edges, if they lie along each other.
   subroutine add_channels(channels, count, blocks, edges, law, max_length)
      type(channel_type), allocatable, intent(inout) :: channels(:)  !< list to append to
      integer, intent(inout) :: count          !< number of channels
      type(blocks_type), intent(in) :: blocks  !< blocks in their initial state
      integer, intent(in) :: edges(2)          !< edges by their first vertices
      integer, intent(in) :: law               !< group &flow
      real(wp), intent(in) :: max_length          !< longest channel, m
      type(channel_type) :: channel
      real(wp) :: span(2), length
      integer :: i, k, n, side

      associate (e => edges(1), f => edges(2))
         span = common_span(blocks, e, blocks%vertex(:, f), blocks%vertex(:, blocks%next(f)), &
            -1.0_wp)
         if (span(2) - span(1) <= min_length) return
         length = (span(2) - span(1))*blocks%length(e)
         n = max(1, ceiling(length/max_length - min_length))
         channel%block = blocks%owner(edges)
         channel%edge = e
         channel%law = law
         channel%length = length/n
         do i = 1, n
            do k = 1, 2
               do side = 1, 2
                  channel%reference(:, k, side) = blocks%vertex(:, e) + blocks%along(:, e) &
                     *blocks%length(e)*(span(1) + (span(2) - span(1))*(i + k - 2)/n) &
                     - blocks%position(1:2, blocks%owner(edges(side)))
               end do
            end do
            if (count == size(channels)) channels = [channels, channels]  ! double the memory
            count = count + 1
            channels(count) = channel
         end do
      end associate
   end subroutine add_channels

   !> Number the ends of channels; ends at the same position are one node.
   !> Nodes are found by the cells of a grid, which have linked lists of nodes.
   pure subroutine number_nodes(flow, blocks)
      type(flow_type), intent(inout) :: flow   !< flow; receives nodes and their positions
      type(blocks_type), intent(in) :: blocks  !< blocks in their initial state
      real(wp) :: node_position(2, 2*size(flow%channel)), lowest(2), extent(2), cell, tolerance
      integer, allocatable :: first(:,:)  ! node of each cell
      integer :: next(size(node_position, 2)), c, k, n, at(2)  ! next: next node of the same cell

      if (size(flow%channel) == 0) return
      tolerance = 4*touching*blocks%half_size
      lowest = minval(blocks%vertex, 2)
      extent = maxval(blocks%vertex, 2) - lowest
      cell = max(sqrt(product(extent)/size(next)), 2*tolerance)
      allocate (first(0:int(extent(1)/cell) + 2, 0:int(extent(2)/cell) + 2), source=0)
      n = 0
      do c = 1, size(flow%channel)
         associate (channel => flow%channel(c))
            do k = 1, 2
               node_position(:, n + 1) = channel%reference(:, k, 1) &
                  + blocks%position(1:2, channel%block(1))
               at = int((node_position(:, n + 1) - lowest)/cell) + 1
               channel%node(k) = find_near_node(at, node_position(:, n + 1))
               if (channel%node(k) > 0) cycle
               n = n + 1
               next(n) = first(at(1), at(2))
               first(at(1), at(2)) = n
               channel%node(k) = n
            end do
         end associate
      end do
      flow%position = node_position(:, :n)

   contains

      !> Find a node within reach of a position; 0 if there is none.
      pure integer function find_near_node(at, position)
         integer, intent(in) :: at(2)         !< cell of the position
         real(wp), intent(in) :: position(2)  !< m
         integer :: i, j

         do j = at(2) - 1, min(at(2) + 1, ubound(first, 2))
            do i = at(1) - 1, min(at(1) + 1, ubound(first, 1))
               find_near_node = first(i, j)
               do while (find_near_node > 0)
                  if (all(abs(node_position(:, find_near_node) - position) <= tolerance)) return
                  find_near_node = next(find_near_node)
               end do
            end do
         end do
      end function find_near_node
   end subroutine number_nodes

   !> Set initial pressure and saturation.
   pure subroutine set_first_state(flow, input, origin)
      type(flow_type), intent(inout) :: flow     !< with its nodes
      type(flow_values), intent(in) :: input(:)    !< values of the group
      real(wp), intent(in) :: origin             !< y of the engine's coordinates, m
      integer :: c, k, node

      do c = 1, size(flow%channel)
         associate (values => input(flow%channel(c)%law))
            do k = 1, 2
               node = flow%channel(c)%node(k)
               flow%pressure(node) = values%pressure
               if (is_set(values%head)) flow%pressure(node) = max(0.0_wp, &
                  values%unit_weight*(values%head - origin - flow%position(2, node)))
               flow%saturation(node) = values%saturation
               if (values%saturation < 1.0_wp) flow%pressure(node) = 0.0_wp
            end do
         end associate
      end do
   end subroutine set_first_state

   !> Read &flow_boundary.
   subroutine read_boundary(model, group, error)
      type(model_type), intent(inout) :: model  !< model with flow
      type(group_type), intent(in) :: group     !< group of the input
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(flow_boundary_values) :: input
      type(flow_boundary_type) :: new
      real(wp), allocatable :: line(:,:)

      if (allocated(error)) return
      call read_values(group, input, error)
      if (size(input%along) > 0) call read_polyline(group, 'along', input%along, model%origin, &
         line, error)
      if (input%side == '' .and. size(input%along) == 0) call fail_input(error, group, &
         'the group selects no nodes; give `side` or `along`')
      if (allocated(error)) return
      new%node = find_nodes(model, input, line)
      if (size(new%node) == 0) call fail_input(error, group, &
         'no node of a joint with water lies at this side or line')
      new%inflow = given(group, 'inflow')
      new%head = given(group, 'head')
      call set_times(error, group, input%time, new%time)
      call set_values(error, group, '`head`, `pressure` or `inflow`', [input%head &
         - model%origin(2), input%pressure, input%inflow], new%time, new%value)
      if (.not. allocated(error)) model%flow%boundary = [model%flow%boundary, new]
   end subroutine read_boundary

   !> Find nodes on a side of the model, on a polyline, or on both.
   pure function find_nodes(model, input, line) result(list)
      type(model_type), intent(in) :: model            !< model with flow
      type(flow_boundary_values), intent(in) :: input    !< values of the group
      real(wp), allocatable, intent(in) :: line(:,:)   !< [2,points] m; not allocated: none
      integer, allocatable :: list(:)
      logical :: is_selected(size(model%flow%pressure))
      real(wp) :: tolerance, at
      integer :: axis, i

      is_selected = .true.
      tolerance = 4*touching*model%blocks%half_size
      associate (node_position => model%flow%position, vertex => model%blocks%vertex)
         if (input%side /= '') then
            axis = merge(1, 2, input%side == sides(1) .or. input%side == sides(2))
            at = maxval(vertex(axis, :))
            if (input%side == sides(1) .or. input%side == sides(3)) at = minval(vertex(axis, :))
            is_selected = abs(node_position(axis, :) - at) <= tolerance
         end if
         if (allocated(line)) then
            do i = 1, size(is_selected)
               is_selected(i) = is_selected(i) .and. is_on(line, node_position(:, i), tolerance)
            end do
         end if
      end associate
      list = pack([(i, i=1, size(is_selected))], is_selected)
   end function find_nodes

   !> .true. if a point lies on a polyline.
   pure logical function is_on(line, point, reach)  ! total
      real(wp), intent(in) :: line(:,:)        !< [2,points] m
      real(wp), intent(in) :: point(2), reach  !< m
      real(wp) :: side(2), fraction
      integer :: j

      is_on = .true.
      do j = 1, size(line, 2) - 1
         side = line(:, j + 1) - line(:, j)
         fraction = dot_product(point - line(:, j), side)/max(tiny(1.0_wp), dot_product(side, side))
         if (norm2(line(:, j) + max(0.0_wp, min(1.0_wp, fraction))*side - point) <= reach) return
      end do
      is_on = .false.
   end function is_on

   !> Set the heads of nodes on faces under water from &water or a level of &traction.
   !> In joints, &flow gives the water pressure.
   subroutine set_water(model, groups, error)
      type(model_type), intent(inout) :: model   !< model with flow and edge loads
      type(group_type), intent(in) :: groups(:)  !< groups of the input, in its order
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer, allocatable :: at(:)
      integer :: i, k, load

      at = pack([(i, i=1, size(groups))], [(groups(i)%name == 'water' .or. groups(i)%name == &
         'traction', i=1, size(groups))])  ! numbered like the edge loads
      do load = 1, size(at)
         if (allocated(error)) return
         associate (water => model%edge_loads(load), group => groups(at(load)))
            if (water%kind == load_uniform) cycle
            if (.not. has_no_channel(model, load)) call fail_input(error, group, &
               '&flow determines the pressure in joints; set acts_on = ''faces''')
            if (water%kind /= load_level .and. any(abs(water%normal - 1.0_wp) > 0.0_wp)) &
               call fail_input(error, group, '`scale` cannot be used together with &flow')
            do k = 1, size(water%part)
               do i = 1, size(model%flow%pressure)
                  call set_node_head(model, load, k, i)
               end do
            end do
         end associate
      end do
   end subroutine set_water

   !> .true. if no channel has an edge on which a load acts as a whole.
   pure logical function has_no_channel(model, load)
      type(model_type), intent(in) :: model  !< model with flow and edge loads
      integer, intent(in) :: load            !< number
      integer :: c, k

      has_no_channel = .true.
      associate (ends => model%edge_loads(load)%ends)
         do c = 1, size(model%flow%channel)
            associate (node => model%flow%channel(c)%node, node_position => model%flow%position)
               do k = 1, size(ends, 3)
                  if (is_on(ends(:, :, k), 0.5_wp*(node_position(:, node(1)) + node_position(:, &
                     node(2))), touching*model%blocks%half_size)) has_no_channel = .false.
               end do
            end associate
         end do
      end associate
   end function has_no_channel

   !> Set the head of a node that lies on part k of the faces under water.
   subroutine set_node_head(model, load, k, node)
      type(model_type), intent(inout) :: model  !< model with flow and edge loads
      integer, intent(in) :: load, k, node      !< numbers
      type(flow_boundary_type) :: new
      real(wp) :: head, face(2)
      integer :: b

      associate (water => model%edge_loads(load), node_position => model%flow%position(:, node))
         if (.not. is_on(water%ends(:, :, k), node_position, &
            4*touching*model%blocks%half_size)) return
         do b = 1, size(model%flow%boundary)
            if (model%flow%boundary(b)%load /= load) cycle
            if (any(model%flow%boundary(b)%node == node)) return  ! by another part of the load
         end do
         head = 0.0_wp
         if (water%kind == load_surface) then
            associate (line => water%line)
               if (node_position(1) < line(1, 1) .or. node_position(1) > line(1, size(line, &
                  2))) return
               head = table_value(line(1, :), line(2, :), node_position(1))
            end associate
         else if (water%kind /= load_level) then
            face = water%ends(:, 2, k) - water%ends(:, 1, k)
            head = node_position(2) + (water%at_ends(1, k) + (water%at_ends(2, k) - &
               water%at_ends(1, k)) *dot_product(node_position - water%ends(:, 1, k), &
               face)/dot_product(face, face)) /water%unit_weight
         end if
         new = flow_boundary_type(node=[node], head=.true., load=load, &
            acts_always=water%acts_always, time=water%time, value=head + water%level)
      end associate
      model%flow%boundary = [model%flow%boundary, new]
   end subroutine set_node_head

end module dda_input_flow
