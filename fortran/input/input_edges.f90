! SPDX-License-Identifier: GPL-3.0-or-later
!> Edges that a group selects: by a side of the model, along a polyline, or by blocks and the
!> numbers of their edges.  A part must satisfy all given criteria and belong to the outline.
!>
!> Groups that act on edges include the part `edges` of the schema.
module dda_input_edges
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type
   use dda_edge_piece, only: edge_piece_type
   use dda_errors, only: error_type
   use dda_input_group, only: group_type, input_error, name_length, mark_names
   use dda_input_groups, only: edges_values
   use dda_model, only: model_type
   use dda_outline, only: outline_of, pieces_on_side, pieces_along
   use dda_text, only: to_text
   implicit none
   private
   public :: choose_edges, read_polyline

contains

   !> Select the parts of the outline that satisfy the criteria of a group; none is an input error.
   subroutine choose_edges(group, edges, model, pieces, error, side)
      type(group_type), intent(in) :: group          !< group of the input
      type(edges_values), intent(in) :: edges        !< criteria of the group
      type(model_type), intent(in) :: model          !< model with its blocks
      type(edge_piece_type), allocatable, intent(out) :: pieces(:)  !< parts in the order of blocks
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      character(len=*), intent(in), optional :: side !< side that replaces the side of the group
      logical :: selected(model%blocks%n)
      character(len=name_length) :: chosen_side
      real(wp), allocatable :: line(:,:)
      integer :: i

      allocate (pieces(0))
      chosen_side = edges%side
      if (present(side)) chosen_side = side
      if (chosen_side == '' .and. size(edges%along) == 0 .and. edges%blocks == '') &
         call input_error(error, group, 'the group selects no edges; give `side`, `along` '// &
            'or `blocks`')
      selected = edges%blocks == ''
      call mark_names(edges%blocks, 'blocks', model%block_names, group, selected, error)
      if (size(edges%along) > 0) call read_polyline(group, 'along', edges%along, &
         model%origin, line, error)
      i = findloc(abs(edges%edges - anint(edges%edges)) > 0.0_wp, .true., 1)
      if (i > 0) call input_error(error, group, 'edges: '//to_text(edges%edges(i))// &
         ' is not a whole number')
      if (allocated(error)) return
      call outline_of(model%blocks, selected, pieces)
      if (size(edges%edges) > 0) pieces = pack(pieces, [(any(pieces(i)%edge &
         - model%blocks%first(pieces(i)%block) + 1 == nint(edges%edges)), i=1, size(pieces))])
      if (chosen_side /= '') pieces = pieces_on_side(model%blocks, pieces, trim(chosen_side))
      if (allocated(line)) pieces = pieces_along(model%blocks, pieces, line)
      if (size(pieces) == 0) call input_error(error, group, &
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

      if (size(points, 2) < 2) call input_error(error, group, name//' has '// &
         to_text(size(points))//' values; x and y of at least two points are needed')
      line = points - spread(origin, 2, size(points, 2))
   end subroutine read_polyline

end module dda_input_edges
