! SPDX-License-Identifier: GPL-3.0-or-later
!> Edges of the groups &boundary; no edge may have two boundaries in the same direction.
module dda_input_boundary_edges
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type
   use dda_boundary, only: boundary_edge_type
   use dda_edge_piece, only: edge_piece_type, piece_normal
   use dda_errors, only: error_type
   use dda_input_group, only: group_type, input_error
   use dda_model, only: model_type
   use dda_text, only: to_text, quoted
   implicit none
   private
   public :: claim_edges

   real(wp), parameter :: least_share = 1.0e-9_wp   !< smallest common part over the edge
   real(wp), parameter :: parallel = 1.0e-6_wp      !< sine of the angle between equal directions

contains

   !> Add the parts of a group; reject parts that have a boundary in the same direction.
   subroutine claim_edges(model, lines, group, pieces, direction, error)
      type(model_type), intent(inout) :: model  !< model; receives the parts
      integer, intent(in) :: lines(:)  !< [groups &boundary so far] line numbers in the input
      type(group_type), intent(in) :: group  !< group of the input
      type(edge_piece_type), intent(in) :: pieces(:)  !< parts of the group
      character(len=*), intent(in) :: direction  !< direction as in `boundary_edge_type`
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      logical :: taken(size(model%blocks%owner))
      integer :: i, k

      taken = .false.
      taken(model%boundary_edges%piece%edge) = .true.
      do i = 1, size(pieces)
         if (.not. taken(pieces(i)%edge)) cycle
         do k = 1, size(model%boundary_edges)
            if (.not. overlaps(model%blocks, pieces(i), direction, model%boundary_edges(k))) cycle
            call input_error(error, group, 'edge '//to_text(pieces(i)%edge &
               - model%blocks%first(pieces(i)%block) + 1)//' of block '// &
               name_of(model, pieces(i)%block)//' has the &boundary of line '// &
               to_text(lines(model%boundary_edges(k)%group))//' already: leave the edge out '// &
               'of one group, or set different directions')
            return
         end do
      end do
      model%boundary_edges = [model%boundary_edges, (boundary_edge_type(size(lines), pieces(i), &
         direction), i=1, size(pieces))]
   end subroutine claim_edges

   !> .true. if a part overlaps a part of another group, and both act in one direction.
   pure logical function overlaps(blocks, piece, direction, other)
      type(blocks_type), intent(in) :: blocks         !< blocks of the model
      type(edge_piece_type), intent(in) :: piece      !< new part
      character(len=*), intent(in) :: direction       !< direction of the new boundary
      type(boundary_edge_type), intent(in) :: other   !< existing part
      real(wp) :: a(2), b(2)

      overlaps = piece%edge == other%piece%edge .and. min(piece%to, other%piece%to) &
         - max(piece%from, other%piece%from) > least_share
      if (.not. overlaps .or. direction == 'xy' .or. other%direction == 'xy') return
      a = unit_vector(blocks, piece, direction)
      b = unit_vector(blocks, piece, other%direction)
      overlaps = abs(a(1)*b(2) - a(2)*b(1)) <= parallel
   end function overlaps

   !> Direction of a boundary that acts in one direction.
   pure function unit_vector(blocks, piece, direction) result(vector)
      type(blocks_type), intent(in) :: blocks      !< blocks of the model
      type(edge_piece_type), intent(in) :: piece   !< part of an edge with the boundary
      character(len=*), intent(in) :: direction    !< 'x', 'y' or 'normal'
      real(wp) :: vector(2)

      vector = piece_normal(blocks, piece)
      if (direction == 'x') vector = [1.0_wp, 0.0_wp]
      if (direction == 'y') vector = [0.0_wp, 1.0_wp]
   end function unit_vector

   !> Text of a block: its name, or its number if it has none.
   pure function name_of(model, b) result(name)
      type(model_type), intent(in) :: model  !< model with its blocks
      integer, intent(in) :: b               !< number of the block
      character(len=:), allocatable :: name

      name = to_text(b)
      if (model%block_names(b) /= '') name = quoted(trim(model%block_names(b)))
   end function name_of

end module dda_input_boundary_edges
