! SPDX-License-Identifier: GPL-3.0-or-later
!> The edges that a group names: by a side of the model, along a polyline, or by blocks and the
!> numbers of their edges.  All that is given must hold, and only pieces of the outline count.
!>
!> A group that acts on edges has the variables `edge_variables` of the catalogue in its namelist,
!> as components of `edge_choice_type`, and hands them to `choose_edges`.
module dda_input_edges
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type
   use dda_edge_piece, only: edge_piece_type
   use dda_errors, only: error_type
   use dda_input_group, only: place_type, input_error, require_choice, require_list, unset, &
      is_set, name_length
   use dda_input_names, only: mark_names, list_length
   use dda_outline, only: outline_of, pieces_on_side, pieces_along
   use dda_text, only: to_text
   implicit none
   private
   public :: edge_choice_type, choose_edges, take_polyline, most_values

   integer, parameter :: most_values = 512  !< coordinates of a polyline, or numbers of edges

   !> Which edges, as read from a group.
   type :: edge_choice_type
      character(len=name_length) :: side = ''
      real(wp) :: along(most_values) = unset
      character(len=list_length) :: blocks = ''
      real(wp) :: edges(most_values) = unset
   end type edge_choice_type

contains

   !> The pieces of the outline that a group names; none is an input error.
   subroutine choose_edges(choice, place, blocks, names, origin, pieces, error)
      type(edge_choice_type), intent(in) :: choice   !< as read
      type(place_type), intent(in) :: place          !< of the group
      type(blocks_type), intent(in) :: blocks        !< of the model
      character(len=*), intent(in) :: names(:)       !< [n] of the blocks
      real(wp), intent(in) :: origin(2)              !< m, of the engine's coordinates
      type(edge_piece_type), allocatable, intent(out) :: pieces(:)  !< in the order of the blocks
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      logical :: wanted(blocks%n), along
      real(wp), allocatable :: line(:,:)

      allocate (pieces(0))
      along = any(is_set(choice%along))
      if (choice%side == '' .and. .not. along .and. choice%blocks == '') &
         call input_error(error, place, 'it names no edges; give side, along, or blocks')
      if (choice%side /= '') call require_choice(error, place, 'side', choice%side)
      wanted = choice%blocks == ''
      call mark_names(choice%blocks, 'blocks', names, place, wanted, error)
      if (along) call take_polyline(place, 'along', choice%along, origin, line, error)
      call check_numbers(choice, place, error)
      if (allocated(error)) return
      call outline_of(blocks, wanted, pieces)
      if (any(is_set(choice%edges))) pieces = numbered(blocks, pieces, &
         pack(nint(choice%edges), is_set(choice%edges)))
      if (choice%side /= '') pieces = pieces_on_side(blocks, pieces, choice%side)
      if (along) pieces = pieces_along(blocks, pieces, line)
      if (size(pieces) == 0) call input_error(error, place, &
         'no edge of the outline is there; an edge that another block touches is not part of it')
   end subroutine choose_edges

   !> A polyline from a list x, y, x, y … in the engine's coordinates.
   subroutine take_polyline(place, name, given, origin, line, error)
      type(place_type), intent(in) :: place  !< of the group
      character(len=*), intent(in) :: name  !< of the variable
      real(wp), intent(in) :: given(:)  !< m, as read
      real(wp), intent(in) :: origin(2)  !< of the engine's coordinates, m
      real(wp), allocatable, intent(out) :: line(:,:)  !< [2,points] m
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      integer :: n

      n = count(is_set(given))
      call require_list(error, place, name, given(:n))
      if (n < 4 .or. modulo(n, 2) == 1) call input_error(error, place, name//' has '// &
         to_text(n)//' values; it needs x and y of two points at least')
      if (allocated(error)) return
      line = reshape(given(:n), [2, n/2]) - spread(origin, 2, n/2)
   end subroutine take_polyline

   !> Numbers of edges are whole, and belong to blocks that are named.
   subroutine check_numbers(choice, place, error)
      type(edge_choice_type), intent(in) :: choice   !< as read
      type(place_type), intent(in) :: place          !< of the group
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      real(wp), allocatable :: numbers(:)
      integer :: i

      numbers = pack(choice%edges, is_set(choice%edges))
      if (size(numbers) == 0) return
      call require_list(error, place, 'edges', numbers)
      if (choice%blocks == '') call input_error(error, place, &
         'edges are numbers of edges of blocks: give blocks too')
      do i = 1, size(numbers)
         if (allocated(error)) return
         if (abs(numbers(i) - anint(numbers(i))) > 0.0_wp) call input_error(error, place, &
            'edges: '//to_text(numbers(i))//' is not a whole number')
      end do
   end subroutine check_numbers

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
