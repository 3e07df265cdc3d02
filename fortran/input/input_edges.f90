! SPDX-License-Identifier: GPL-3.0-or-later
!> Edges that a group selects: by a side of the model, along a polyline, or by blocks and the
!> numbers of their edges.  A part must satisfy all given criteria and belong to the outline.
!>
!> Groups that act on edges include the part `edges` of the schema.
module dda_input_edges
   use dda_kinds, only: wp
   use dda_edge_part, only: edge_part_type
   use dda_errors, only: error_type
   use dda_input_group, only: group_type, fail_input, name_length, mark_names
   use dda_input_groups, only: edges_values
   use dda_model, only: model_type
   use dda_outline, only: find_outline, parts_on_side, parts_along
   use dda_text, only: to_text
   implicit none
   private
   public :: choose_edges, read_polyline

contains

   !> Select the parts of the outline that satisfy the criteria of a group; none is an input error.
   subroutine choose_edges(group, edges, model, parts, error, side)
      type(group_type), intent(in) :: group          !< group of the input
      type(edges_values), intent(in) :: edges        !< criteria of the group
      type(model_type), intent(in) :: model          !< model with its blocks
      type(edge_part_type), allocatable, intent(out) :: parts(:)  !< parts in the order of blocks
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      character(len=*), intent(in), optional :: side !< side that replaces the side of the group
      logical :: is_selected(model%blocks%n)
      character(len=name_length) :: chosen_side
      real(wp), allocatable :: line(:,:)
      integer :: i

      allocate (parts(0))
      chosen_side = edges%side
      if (present(side)) chosen_side = side
      if (chosen_side == '' .and. size(edges%along) == 0 .and. edges%blocks == '') &
         call fail_input(error, group, 'the group selects no edges; give `side`, `along` '// &
            'or `blocks`')
      is_selected = edges%blocks == ''
      call mark_names(edges%blocks, 'blocks', model%block_names, group, is_selected, error)
      if (size(edges%along) > 0) call read_polyline(group, 'along', edges%along, &
         model%origin, line, error)
      i = findloc(abs(edges%edges - anint(edges%edges)) > 0.0_wp, .true., 1)
      if (i > 0) call fail_input(error, group, 'edges: '//to_text(edges%edges(i))// &
         ' is not a whole number')
      if (allocated(error)) return
      call find_outline(model%blocks, is_selected, parts)
      if (size(edges%edges) > 0) parts = pack(parts, [(any(parts(i)%edge &
         - model%blocks%first(parts(i)%block) + 1 == nint(edges%edges)), i=1, size(parts))])
      if (chosen_side /= '') parts = parts_on_side(model%blocks, parts, trim(chosen_side))
      if (allocated(line)) parts = parts_along(model%blocks, parts, line)
      if (size(parts) == 0) call fail_input(error, group, &
         'no edge of the outline is selected; edges that touch another block are excluded')
   end subroutine choose_edges

   !> Convert a polyline to the engine's coordinates.
   subroutine read_polyline(group, name, points, origin, line, error)
      type(group_type), intent(in) :: group  !< group of the input
      character(len=*), intent(in) :: name  !< name of the variable
      real(wp), intent(in) :: points(:,:)   !< [2,points] positions, m
      real(wp), intent(in) :: origin(2)  !< origin of the engine's coordinates, m
      real(wp), allocatable, intent(out) :: line(:,:)  !< [2,points] m
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      if (size(points, 2) < 2) call fail_input(error, group, name//' has '// &
         to_text(size(points))//' values; x and y of at least two points are needed')
      line = points - spread(origin, 2, size(points, 2))
   end subroutine read_polyline

end module dda_input_edges
