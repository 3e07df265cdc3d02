! SPDX-License-Identifier: GPL-3.0-or-later
!> Groups &traction and &water: loads on edges.
module dda_input_edge_loads
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type, position_of
   use dda_edge_load, only: edge_load_type, load_uniform, load_level, load_surface, load_line
   use dda_edge_part, only: edge_part_type, reference_at
   use dda_errors, only: error_type
   use dda_input_edges, only: choose_edges, read_polyline
   use dda_input_group, only: group_type, fail_input, given, require_new_name, mark_names
   use dda_input_groups, only: traction_values, water_values, read_values
   use dda_input_points, only: set_times, set_values
   use dda_model, only: model_type
   use dda_outline, only: find_outline, parts_along
   use dda_text, only: to_text
   implicit none
   private
   public :: read_edge_loads

   !> largest fraction of a line that is off all edges
   real(wp), parameter :: max_uncovered = 1.0e-6_wp
   real(wp), parameter :: min_slope = 0.5_wp !< sine of the slope of an upstream face: 30°

contains

   !> Read all groups &traction and &water of an input.
   subroutine read_edge_loads(model, groups, error)
      type(model_type), intent(inout) :: model  !< model with its blocks
      type(group_type), intent(in) :: groups(:)  !< groups of the input, in its order
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(edge_load_type) :: new
      integer :: i

      if (allocated(error)) return
      allocate (model%edge_loads(0))
      do i = 1, size(groups)
         select case (groups(i)%name)
         case ('traction')
            call read_traction(groups(i), model, new, error)
         case ('water')
            call read_water(groups(i), model, new, error)
         case default
            cycle
         end select
         if (allocated(error)) return
         if (new%name /= '') call require_new_name(error, groups(i), new%name, &
            [model%edge_loads%name, model%bolts%name])
         call mark_ends(model%blocks, new)
         model%edge_loads = [model%edge_loads, new]
      end do
   end subroutine read_edge_loads

   !> Set the initial ends of the parts.
   pure subroutine mark_ends(blocks, load)
      type(blocks_type), intent(in) :: blocks  !< blocks in their initial state
      type(edge_load_type), intent(inout) :: load  !< load with its parts
      integer :: k, i

      if (allocated(load%ends)) deallocate (load%ends)
      allocate (load%ends(2, 2, size(load%part)))
      do k = 1, size(load%part)
         do i = 1, 2
            load%ends(:, i, k) = position_of(blocks, load%part(k)%block, reference_at(blocks, &
               load%part(k), i - 1.0_wp))
         end do
      end do
   end subroutine mark_ends

   !> Read &traction.
   subroutine read_traction(group, model, new, error)
      type(group_type), intent(in) :: group  !< group of the input
      type(model_type), intent(in) :: model  !< model with its blocks
      type(edge_load_type), intent(out) :: new  !< values of the group
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      type(traction_values) :: input

      call read_values(group, input, error)
      new%name = input%name
      new%follows = input%follows
      new%unit_weight = input%unit_weight
      if (.not. allocated(error)) call choose_edges(group, input%edges, model, new%part, error)
      new%kind = merge(load_level, load_uniform, given(group, 'level'))
      new%acts_always = size(input%time) == 0
      call set_times(error, group, input%time, new%time)
      call set_values(error, group, 'normal', input%normal, new%time, new%normal)
      call set_values(error, group, 'shear', input%shear, new%time, new%shear)
      if (new%kind == load_uniform) input%level = [model%origin(2)]
      call set_values(error, group, 'level', input%level - model%origin(2), new%time, new%level)
      if (input%added_mass .and. .not. allocated(error)) &
         call set_reservoir(new, model, group, input%reservoir_depth, error)
   end subroutine read_traction

   !> Set the depth of the reservoir whose water moves with the steep edges of a load.
   subroutine set_reservoir(load, model, group, depth, error)
      type(edge_load_type), intent(inout) :: load  !< load with its parts and level
      type(model_type), intent(in) :: model  !< model with its blocks
      type(group_type), intent(in) :: group  !< group of the input
      real(wp), intent(in) :: depth          !< reservoir_depth of the input, m
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      real(wp) :: water_depth, edge(2)
      integer :: k

      call mark_ends(model%blocks, load)
      water_depth = load%level(1) - minval(load%ends(2, :, :))
      load%reservoir = water_depth
      if (given(group, 'reservoir_depth')) load%reservoir = depth
      if (water_depth <= 0.0_wp) then
         call fail_input(error, group, 'added_mass requires a selected edge below the level')
      else if (load%reservoir < (1.0_wp - max_uncovered)*water_depth) then
         call fail_input(error, group, 'reservoir_depth = '//to_text(depth)// &
            ' m is less than the depth of water at these edges, '//to_text(water_depth)//' m')
      end if
      do k = 1, size(load%part)
         edge = load%ends(:, 2, k) - load%ends(:, 1, k)
         if (abs(edge(2)) < min_slope*norm2(edge)) call fail_input(error, group, &
            'added_mass is for upstream faces; the edge from ('//to_text(load%ends(:, 1, k) &
            + model%origin)//') to ('//to_text(load%ends(:, 2, k) + model%origin)// &
            ') is too flat; give this edge a &traction without added_mass')
      end do
   end subroutine set_reservoir

   !> Read &water.
   subroutine read_water(group, model, new, error)
      type(group_type), intent(in) :: group  !< group of the input
      type(model_type), intent(in) :: model  !< model with its blocks
      type(edge_load_type), intent(out) :: new  !< values of the group
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(water_values) :: input

      call read_values(group, input, error)
      new%name = input%name
      new%unit_weight = input%unit_weight
      call find_wettable_edges(model, group, input, new%part, error)
      if (allocated(error)) return
      if (given(group, 'surface')) then
         call set_surface(new, model, group, input%surface, error)
      else
         call set_line(new, model, group, input, error)
      end if
      call set_times(error, group, input%time, new%time)
      call set_values(error, group, 'scale', input%scale, new%time, new%normal)
      call set_values(error, group, 'rise', input%rise, new%time, new%level)
      new%shear = spread(0.0_wp, 1, size(new%time))
      new%acts_always = .true.
   end subroutine read_water

   !> Edges on which water may act: all edges, edges of joints between blocks, or the outline.
   subroutine find_wettable_edges(model, group, input, parts, error)
      type(model_type), intent(in) :: model  !< model with its blocks
      type(group_type), intent(in) :: group  !< group of the input
      type(water_values), intent(in) :: input  !< values of the group
      type(edge_part_type), allocatable, intent(out) :: parts(:)  !< parts of edges
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      logical :: all_blocks(model%blocks%n), is_selected(size(model%joints))
      type(edge_part_type), allocatable :: outline_parts(:)
      integer :: v

      all_blocks = .true.
      is_selected = input%joints == ''
      allocate (parts(0))
      call mark_names(input%joints, 'joints', model%joints%name, group, is_selected, error)
      if (allocated(error)) return
      associate (blocks => model%blocks)
         parts = [(edge_part_type(blocks%owner(v), v), v=1, size(blocks%owner))]
         if (input%acts_on /= 'all') call find_outline(blocks, all_blocks, outline_parts)
         if (input%acts_on == 'faces') parts = outline_parts
         if (input%acts_on == 'joints') parts = remaining_parts(parts, outline_parts)
         parts = pack(parts, is_selected(blocks%joint(parts%edge)))
      end associate
   end subroutine find_wettable_edges

   !> Parts of whole edges that remain after removal of some parts, in the order of the edges.
   function remaining_parts(edges, parts) result(remaining)
      type(edge_part_type), intent(in) :: edges(:)   !< whole edges
      type(edge_part_type), intent(in) :: parts(:)  !< parts to remove
      type(edge_part_type), allocatable :: remaining(:)
      type(edge_part_type) :: part
      integer :: i, k, n

      allocate (remaining(size(edges) + size(parts)))
      n = 0
      k = 1
      do i = 1, size(edges)
         part = edges(i)
         do
            if (k > size(parts)) exit
            if (parts(k)%edge /= part%edge) exit
            part%to = parts(k)%from
            call append_rest()
            part%from = parts(k)%to
            k = k + 1
         end do
         part%to = 1.0_wp
         call append_rest()
      end do
      remaining = remaining(:n)

   contains

      !> Append the present part to the list, unless it is negligibly short.
      subroutine append_rest()
         if (part%to - part%from <= max_uncovered) return
         n = n + 1
         remaining(n) = part
      end subroutine append_rest
   end function remaining_parts

   !> Set a phreatic line within the model.
   subroutine set_surface(load, model, group, points, error)
      type(edge_load_type), intent(inout) :: load  !< load with its parts
      type(model_type), intent(in) :: model  !< model with its blocks
      type(group_type), intent(in) :: group  !< group of the input
      real(wp), intent(in) :: points(:,:)    !< [2,points] points of the line, m
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      real(wp), allocatable :: line(:,:)
      real(wp) :: left_end, right_end, rounding
      integer :: j

      load%kind = load_surface
      call read_polyline(group, 'surface', points, model%origin, line, error)
      if (allocated(error)) return
      left_end = minval(model%blocks%vertex(1, :))
      right_end = maxval(model%blocks%vertex(1, :))
      rounding = max_uncovered*model%blocks%half_size
      do j = 1, size(line, 2)
         if (line(1, j) < left_end - rounding .or. line(1, j) > right_end &
            + rounding) call fail_input(error, group, '`surface` reaches ('//to_text(line(:, &
            j) + model%origin)//'), outside the model, which reaches from x = '//to_text(left_end &
            + model%origin(1))//' to '//to_text(right_end + model%origin(1)))
         if (j == 1) cycle
         if (line(1, j) <= line(1, j - 1)) call fail_input(error, group, &
            'x must increase from point to point of `surface`')
      end do
      load%line = line
   end subroutine set_surface

   !> Set heads or pressures at the points of a line on edges, with linear interpolation.
   subroutine set_line(load, model, group, input, error)
      type(edge_load_type), intent(inout) :: load  !< load with the parts on which it may act
      type(model_type), intent(in) :: model  !< model with its blocks
      type(group_type), intent(in) :: group  !< group of the input
      type(water_values), intent(in) :: input  !< values of the group
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      real(wp), allocatable :: line(:,:), values(:)
      type(edge_part_type), allocatable :: candidates(:), covered(:)
      integer :: j, n

      load%kind = load_line
      call read_polyline(group, 'along', input%along, model%origin, line, error)
      n = size(line, 2)
      values = [input%head, input%pressure]
      if (size(values) /= n) call fail_input(error, group, '`head` or `pressure` must have as '// &
         'many values as `along` has points ('//to_text(n)//')')
      if (allocated(error)) return
      if (given(group, 'head')) values = load%unit_weight*(values - line(2, :) - model%origin(2))
      candidates = load%part
      load%part = [edge_part_type ::]
      allocate (load%at_ends(2, 0))
      do j = 1, n - 1
         covered = parts_along(model%blocks, candidates, line(:, j:j + 1))
         call check_cover(model, group, line(:, j:j + 1), covered, error)
         call add_pressures(load, model%blocks, line(:, j:j + 1), values(j:j + 1), covered)
      end do
   end subroutine set_line

   !> Add pressures at the ends of parts on a segment.
   pure subroutine add_pressures(load, blocks, segment, values, parts)
      type(edge_load_type), intent(inout) :: load  !< load with the earlier parts
      type(blocks_type), intent(in) :: blocks  !< blocks in their initial state
      real(wp), intent(in) :: segment(2, 2), values(2)  !< ends of the segment, m; pressures, Pa
      type(edge_part_type), intent(in) :: parts(:)  !< parts on the segment
      real(wp) :: new_values(2, size(parts))
      integer :: k, i

      do k = 1, size(parts)
         do i = 1, 2
            new_values(i, k) = values(1) + fraction_along(blocks, parts(k), i, segment) &
               *(values(2) - values(1))
         end do
      end do
      load%part = [load%part, parts]
      load%at_ends = reshape([load%at_ends, new_values], [2, size(load%part)])
   end subroutine add_pressures

   !> Position of an end of a part along a segment: 0 at its first point, 1 at its second.
   pure real(wp) function fraction_along(blocks, part, i, segment) result(fraction)
      type(blocks_type), intent(in) :: blocks     !< blocks in their initial state
      type(edge_part_type), intent(in) :: part  !< part of an edge
      integer, intent(in) :: i                    !< end of the part, 1 or 2
      real(wp), intent(in) :: segment(2, 2)       !< ends of the segment, m
      real(wp) :: direction(2)

      direction = segment(:, 2) - segment(:, 1)
      fraction = dot_product(direction, position_of(blocks, part%block, &
         reference_at(blocks, part, i - 1.0_wp)) - segment(:, 1))/dot_product(direction, direction)
   end function fraction_along

   !> Check that all of a segment lies on edges.
   subroutine check_cover(model, group, segment, parts, error)
      type(model_type), intent(in) :: model  !< model with its blocks
      type(group_type), intent(in) :: group  !< group of the input
      real(wp), intent(in) :: segment(2, 2)  !< ends of the segment, m
      type(edge_part_type), intent(in) :: parts(:)  !< parts on the segment
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      real(wp) :: direction(2), covered, reach, fraction(2)
      logical :: extended
      integer :: k, i

      if (allocated(error)) return
      direction = segment(:, 2) - segment(:, 1)
      covered = 0.0_wp
      extended = .true.
      do while (extended)
         extended = .false.
         do k = 1, size(parts)
            fraction = [(fraction_along(model%blocks, parts(k), i, segment), i=1, 2)]
            reach = maxval(fraction)
            if (minval(fraction) > covered + max_uncovered .or. reach <= covered &
               + max_uncovered) cycle
            covered = reach
            extended = .true.
         end do
      end do
      if (covered < 1.0_wp - max_uncovered) call fail_input(error, group, &
         '`along` passes ('//to_text(segment(:, 1) + covered*direction &
         + model%origin)//'), outside the model or away from its joints and faces')
   end subroutine check_cover

end module dda_input_edge_loads
