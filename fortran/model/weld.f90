! SPDX-License-Identifier: GPL-3.0-or-later
!> Bodies: cells that are welded at their common faces, so that the body can bend.
!>
!> A cell is a block with a body number.  A face is the part of an edge that two cells of a body
!> have in common.  The triangles between the face and the centroids of its cells have the strain of
!> the face; the remainder of a cell has the strain of the cell (see `dda_weld_springs`).
module dda_weld
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type
   implicit none
   private
   public :: weld_type, set_welds, new_weld, assign_triangles, welds_within, is_shifted, is_intact
   public :: weld_intact, weld_cracked, weld_open

   integer, parameter :: weld_intact = 0    !< intact face: springs connect its two cells
   integer, parameter :: weld_cracked = 1  !< face replaced by a joint, and closed
   integer, parameter :: weld_open = 2     !< face separated: its edges are sides of the body

   !> A welded face, from a to b in the order of the first cell, in the reference shapes.
   type :: weld_type
      integer :: block(2) = 0            !< cells of the face
      integer :: edge(2) = 0  !< edges that contain the face, given by their first vertices
      real(wp) :: length = 0.0_wp        !< L, m
      real(wp) :: along(2) = 0.0_wp      !< unit vector from a to b
      real(wp) :: middle(2, 2) = 0.0_wp  !< offsets ρ of the midpoint in both cells, m
      real(wp) :: area(2) = 0.0_wp       !< area of both triangles, m²
      !> added to positions of the second cell if it is an image in level ground, m; else 0
      real(wp) :: shift(2) = 0.0_wp
      integer :: joint = 0               !< joint that replaces the face when it breaks; 0: never
      integer :: state = weld_intact
      !> [component,cell] initial stress of cells due to the break of the face, Pa m²
      real(wp) :: break_stress(3, 2) = 0.0_wp
      real(wp) :: break_fraction = 0.0_wp  !< remaining fraction of this stress
   end type weld_type

contains

   !> Create the face of edges e and f between two positions, m from the start of edge e.
   pure type(weld_type) function new_weld(blocks, e, f, start, end_position, shift) result(weld)
      type(blocks_type), intent(in) :: blocks  !< blocks at the start
      integer, intent(in) :: e, f              !< edges, given by their first vertices
      real(wp), intent(in) :: start, end_position        !< m
      real(wp), intent(in) :: shift(2)         !< shift of the second edge, m
      real(wp) :: normal(2), middle(2)
      integer :: i

      weld%block = blocks%owner([e, f])
      weld%edge = [e, f]
      weld%length = end_position - start
      weld%along = blocks%along(:, e)
      weld%shift = shift
      middle = blocks%vertex(:, e) + 0.5_wp*(start + end_position)*weld%along
      normal = [weld%along(2), -weld%along(1)]
      do i = 1, 2
         weld%middle(:, i) = middle - blocks%position(1:2, weld%block(i))
         if (i == 2) weld%middle(:, i) = weld%middle(:, i) - shift
         weld%area(i) = 0.5_wp*weld%length*abs(dot_product(normal, weld%middle(:, i)))
      end do
   end function new_weld

   !> Set the fraction of each cell's area outside face triangles, and mark the edges within bodies.
   pure subroutine set_welds(blocks, welds)
      type(blocks_type), intent(inout) :: blocks  !< blocks of the input, with their bodies
      type(weld_type), intent(in) :: welds(:)     !< all faces between neighbours
      real(wp), parameter :: max_free = 1.0e-6_wp  !< largest free fraction of an edge within a body
      real(wp) :: free_angle(size(blocks%owner))
      integer :: i

      free_angle = blocks%length
      do i = 1, size(welds)
         if (welds(i)%state == weld_open) cycle
         free_angle(welds(i)%edge) = free_angle(welds(i)%edge) - welds(i)%length
      end do
      blocks%inner = free_angle < max_free*blocks%length
      call find_outlines(blocks, pack(welds, welds%state /= weld_open))
      blocks%interior_fraction = 1.0_wp
      call assign_triangles(blocks, welds)
      call store_body_areas(blocks)
   end subroutine set_welds

   !> Store the area of each body in its cells.
   pure subroutine store_body_areas(blocks)
      type(blocks_type), intent(inout) :: blocks  !< blocks with their bodies
      real(wp) :: total(maxval(blocks%body))
      integer :: b

      total = 0.0_wp
      do b = 1, blocks%n
         if (blocks%body(b) > 0) total(blocks%body(b)) = total(blocks%body(b)) + blocks%area(b)
      end do
      do b = 1, blocks%n
         if (blocks%body(b) > 0) blocks%whole_area(b) = total(blocks%body(b))
      end do
   end subroutine store_body_areas

   !> Assign the triangles beside faces to the faces; they have the strain of the face, not of the
   !> cell.
   pure subroutine assign_triangles(blocks, welds)
      type(blocks_type), intent(inout) :: blocks  !< blocks at the start
      type(weld_type), intent(in) :: welds(:)     !< faces
      real(wp), parameter :: min_area = 1.0e-9_wp  !< area/cell area that counts as 0
      integer :: i, k, b

      do i = 1, size(welds)
         if (.not. is_intact(welds(i))) cycle
         do k = 1, 2
            b = welds(i)%block(k)
            blocks%interior_fraction(b) = blocks%interior_fraction(b) &
               - welds(i)%area(k)/blocks%area(b)
         end do
      end do
      where (blocks%interior_fraction < min_area) blocks%interior_fraction = 0.0_wp
   end subroutine assign_triangles

   !> .true. if the second cell of a face is an image at another position.
   elemental logical function is_shifted(weld)
      type(weld_type), intent(in) :: weld  !< face

      is_shifted = any(abs(weld%shift) > 0.0_wp)
   end function is_shifted

   !> .true. if the face is intact: springs connect its cells.
   elemental logical function is_intact(weld)  ! total
      type(weld_type), intent(in) :: weld  !< face

      is_intact = weld%state == weld_intact
   end function is_intact

   !> Faces between some of the blocks, with the numbers of these blocks.
   pure function welds_within(welds, block, vertex) result(inner_welds)
      type(weld_type), intent(in) :: welds(:)  !< faces of a model
      integer, intent(in) :: block(:)          !< [blocks] new number of each block, or 0
      integer, intent(in) :: vertex(:)         !< [vertices] new number of each vertex, or 0
      type(weld_type), allocatable :: inner_welds(:)
      integer :: i

      inner_welds = pack(welds, [(all(block(welds(i)%block) > 0), i=1, size(welds))])
      do i = 1, size(inner_welds)
         inner_welds(i)%block = block(inner_welds(i)%block)
         inner_welds(i)%edge = vertex(inner_welds(i)%edge)
      end do
   end function welds_within

   !> Find the edges of the outline at each vertex of a body.
   !> The search passes from cell to cell around the vertex.
   pure subroutine find_outlines(blocks, welds)
      type(blocks_type), intent(inout) :: blocks  !< blocks with inner edges
      type(weld_type), intent(in) :: welds(:)     !< all faces
      integer, parameter :: max_cells = 64       !< largest number of cells around a vertex
      integer :: neighbour(2, size(blocks%owner)), v, at, pass

      blocks%outline(1, :) = blocks%previous
      blocks%outline(2, :) = [(v, v=1, size(blocks%owner))]
      neighbour = 0
      do v = 1, size(welds)
         call mark_ends(blocks, welds(v), neighbour)
      end do
      do v = 1, size(blocks%owner)
         if (blocks%body(blocks%owner(v)) == 0) cycle
         at = v
         do pass = 1, max_cells
            if (.not. blocks%inner(blocks%previous(at)) .or. neighbour(1, at) == 0) exit
            at = neighbour(1, at)
         end do
         blocks%outline(1, v) = blocks%previous(at)
         at = v
         do pass = 1, max_cells
            if (.not. blocks%inner(at) .or. neighbour(2, at) == 0) exit
            at = neighbour(2, at)
         end do
         blocks%outline(2, v) = at
      end do
   end subroutine find_outlines

   !> Record, for vertices at the ends of a face, the vertex of the other cell at the same position,
   !> as neighbour before or after the vertex.
   pure subroutine mark_ends(blocks, weld, neighbour)
      type(blocks_type), intent(in) :: blocks    !< blocks at the start
      type(weld_type), intent(in) :: weld        !< face
      integer, intent(inout) :: neighbour(:,:)      !< [2, vertices] neighbours, or 0
      real(wp), parameter :: end_tolerance = 1.0e-5_wp    !< tolerance/smaller radius
      real(wp) :: tolerance

      tolerance = end_tolerance*minval(blocks%radius(weld%block))
      associate (e => weld%edge(1), f => weld%edge(2), next => blocks%next)
         if (have_equal_positions(e, next(f))) then
            neighbour(2, e) = next(f)
            neighbour(1, next(f)) = e
         end if
         if (have_equal_positions(next(e), f)) then
            neighbour(1, next(e)) = f
            neighbour(2, f) = next(e)
         end if
      end associate

   contains

      !> .true. if two vertices have the same position.
      pure logical function have_equal_positions(v, w)
         integer, intent(in) :: v, w  !< vertices

         have_equal_positions = norm2(blocks%vertex(:, v) - blocks%vertex(:, w)) <= tolerance
      end function have_equal_positions
   end subroutine mark_ends

end module dda_weld
