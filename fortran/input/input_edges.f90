! SPDX-License-Identifier: GPL-3.0-or-later
!> The edges that a group names: by a side of the model, along a polyline, or by blocks and the
!> numbers of their edges.  All that is given must hold, and only pieces of the outline count.
!>
!> A group that acts on edges takes the part `edges` of the schema.
module dda_input_edges
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type
   use dda_edge_piece, only: edge_piece_type
   use dda_errors, only: error_type
   use dda_input_group, only: group_type, input_error, get, get_list, get_text, given, name_length
   use dda_input_names, only: mark_names
   use dda_outline, only: outline_of, pieces_on_side, pieces_along
   use dda_text, only: to_text
   implicit none
   private
   public :: choose_edges, take_polyline

contains

   !> The pieces of the outline that a group names; none is an input error.
   subroutine choose_edges(group, blocks, names, origin, pieces, error, side)
      type(group_type), intent(in) :: group          !< of the input
      type(blocks_type), intent(in) :: blocks        !< of the model
      character(len=*), intent(in) :: names(:)       !< [n] of the blocks
      real(wp), intent(in) :: origin(2)              !< m, of the engine's coordinates
      type(edge_piece_type), allocatable, intent(out) :: pieces(:)  !< in the order of the blocks
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      character(len=*), intent(in), optional :: side !< in place of that of the group
      logical :: wanted(blocks%n)
      character(len=name_length) :: own
      character(len=:), allocatable :: list
      real(wp), allocatable :: line(:,:), numbers(:)

      allocate (pieces(0))
      own = ''
      list = ''
      call get(group, 'side', own, error)
      if (present(side)) own = side
      call get_text(group, 'blocks', list)
      if (own == '' .and. .not. given(group, 'along') .and. list == '') &
         call input_error(error, group, 'it names no edges; give side, along, or blocks')
      wanted = list == ''
      call mark_names(list, 'blocks', names, group, wanted, error)
      if (given(group, 'along')) call take_polyline(group, 'along', origin, line, error)
      call take_numbers(group, list == '', numbers, error)
      if (allocated(error)) return
      call outline_of(blocks, wanted, pieces)
      if (size(numbers) > 0) pieces = numbered(blocks, pieces, nint(numbers))
      if (own /= '') pieces = pieces_on_side(blocks, pieces, trim(own))
      if (allocated(line)) pieces = pieces_along(blocks, pieces, line)
      if (size(pieces) == 0) call input_error(error, group, &
         'no edge of the outline is there; an edge that another block touches is not part of it')
   end subroutine choose_edges

   !> A polyline from a list x, y, x, y … in the engine's coordinates.
   subroutine take_polyline(group, name, origin, line, error)
      type(group_type), intent(in) :: group  !< of the input
      character(len=*), intent(in) :: name  !< of the variable
      real(wp), intent(in) :: origin(2)  !< of the engine's coordinates, m
      real(wp), allocatable, intent(out) :: line(:,:)  !< [2,points] m
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      real(wp), allocatable :: values(:)
      integer :: n

      call get_list(group, name, values, error)
      n = size(values)
      if (n < 4 .or. modulo(n, 2) == 1) call input_error(error, group, name//' has '// &
         to_text(n)//' values; it needs x and y of two points at least')
      if (allocated(error)) return
      line = reshape(values, [2, n/2]) - spread(origin, 2, n/2)
   end subroutine take_polyline

   !> Numbers of edges are whole, and belong to blocks that are named.
   subroutine take_numbers(group, unnamed, numbers, error)
      type(group_type), intent(in) :: group  !< of the input
      logical, intent(in) :: unnamed         !< it names no blocks
      real(wp), allocatable, intent(out) :: numbers(:)  !< none: all edges
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      integer :: i

      call get_list(group, 'edges', numbers, error)
      if (size(numbers) > 0 .and. unnamed) call input_error(error, group, &
         'edges are numbers of edges of blocks: give blocks too')
      do i = 1, size(numbers)
         if (abs(numbers(i) - anint(numbers(i))) > 0.0_wp) call input_error(error, group, &
            'edges: '//to_text(numbers(i))//' is not a whole number')
      end do
   end subroutine take_numbers

   !> Pieces of edges of the given numbers in their blocks, the first from the first vertex on.
   pure function numbered(blocks, pieces, numbers) result(found)
      type(blocks_type), intent(in) :: blocks          !< of the model
      type(edge_piece_type), intent(in) :: pieces(:)   !< to choose from
      integer, intent(in) :: numbers(:)                !< of edges, from 1
      type(edge_piece_type), allocatable :: found(:)
      integer :: i

      found = pack(pieces, [(any(pieces(i)%edge - blocks%first(pieces(i)%block) + 1 == numbers), &
         i=1, size(pieces))])
   end function numbered

end module dda_input_edges
