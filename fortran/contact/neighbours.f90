! SPDX-License-Identifier: GPL-3.0-or-later
!> Neighbour search: near pairs of blocks by a grid of cells in O(n), then probes of each pair.
!>
!> A probe is a convex vertex with the edges of another block within a search distance.  The search
!> distance exceeds the contact distance by a margin; the list is valid until a vertex has moved by
!> half of the margin.
module dda_neighbours
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type, is_convex
   use dda_counting_sort, only: sort_by_key
   use dda_growth, only: grow
   implicit none
   private
   public :: neighbours_type, find_neighbours, find_near_pairs, find_corners

   !> largest number of near pairs in a small model; large models may have 100 pairs per block
   integer, parameter :: most_pairs = 1000000

   !> Near pairs and probes.
   type :: neighbours_type
      ! unsaved, set by a search that ends the run: overflowed
      ! unsaved, listed again from the present positions, without effect on results: first_corner
      ! unsaved, listed again from the present positions, without effect on results: corner
      ! unsaved, the input: convex, convex_block
      integer :: n_pairs = 0
      integer :: n_probes = 0
      integer, allocatable :: pair(:,:)      !< [2, pairs] near blocks, first < second
      integer, allocatable :: probe(:,:)     !< [2, probes] vertex, and number of the near pair
      integer, allocatable :: first_edge(:)  !< [probes+1] first edge of each probe
      integer, allocatable :: edge(:)        !< edges of the probes, given by their first vertices
      integer, allocatable :: first_corner(:) !< [probes+1] first corner of each probe
      !> convex end vertices of each probe's edges that its vertex can reach before the next search
      integer, allocatable :: corner(:)
      !> there are too many pairs, so the list is incomplete
      logical :: overflowed = .false.
      logical, allocatable :: convex(:)      !< [vertices] the angle is below 180°
      logical, allocatable :: convex_block(:) !< [n] all its angles are below 180°
      real(wp) :: reach = 0.0_wp             !< search distance, m
      real(wp) :: travel = 0.0_wp            !< bound on the displacement since the search, m
   end type neighbours_type

   !> Square cells over the bounding boxes of all blocks.
   type :: grid_type
      real(wp) :: origin(2)               !< lower left corner, m
      real(wp) :: cell                    !< side of a cell, m
      integer :: shape(2)                 !< cells in x and in y
      integer, allocatable :: first(:)    !< [cells+1] first member of each cell
      integer, allocatable :: member(:)   !< blocks whose boxes reach into the cell
   end type grid_type

contains

   !> Find all pairs and probes within a distance.
   subroutine find_neighbours(neighbours, blocks, reach)
      type(neighbours_type), intent(inout) :: neighbours  !< pairs and probes are replaced
      type(blocks_type), intent(in) :: blocks             !< present geometry
      real(wp), intent(in) :: reach                       !< search distance, m

      if (.not. allocated(neighbours%convex)) call mark_convex(neighbours, blocks)
      call find_near_pairs(neighbours, blocks, reach)
      if (neighbours%overflowed) neighbours%n_pairs = 0
      call find_probes(neighbours, blocks, reach)
      neighbours%reach = reach
      neighbours%travel = 0.0_wp
      call find_corners(neighbours, blocks)
   end subroutine find_neighbours

   !> Find pairs of blocks whose boxes are closer than a distance.
   subroutine find_near_pairs(neighbours, blocks, reach)
      !> receives pairs, or `overflowed` if too many
      type(neighbours_type), intent(inout) :: neighbours
      type(blocks_type), intent(in) :: blocks             !< present geometry
      real(wp), intent(in) :: reach                       !< search distance, m
      real(wp), allocatable :: box(:,:)

      allocate (box(4, blocks%n))
      call bound_blocks(blocks, 0.5_wp*reach, box)
      call find_pairs(neighbours, blocks%n, box)
      if (any(blocks%removed) .or. size(blocks%joined) > 0) call drop_pairs(neighbours, blocks)
      call sort_pairs(neighbours, blocks%n)
   end subroutine find_near_pairs

   !> Sort pairs by matrix rows, so that contacts are read in the order of memory.
   subroutine sort_pairs(neighbours, n)
      type(neighbours_type), intent(inout) :: neighbours  !< pairs
      integer, intent(in) :: n                            !< number of blocks
      integer, allocatable :: start(:), by_first(:), by_second(:), sorted(:,:)

      associate (pair => neighbours%pair(:, :neighbours%n_pairs))
         call sort_by_key(n, pair(1, :), start, by_first)
         call sort_by_key(n, pair(2, by_first), start, by_second)
         sorted = pair(:, by_first(by_second))
      end associate
      call move_alloc(sorted, neighbours%pair)
   end subroutine sort_pairs

   !> Remove pairs with a block removed from the model, and pairs of blocks joined in a body.
   pure subroutine drop_pairs(neighbours, blocks)
      type(neighbours_type), intent(inout) :: neighbours  !< pairs
      type(blocks_type), intent(in) :: blocks             !< blocks, with their bodies
      integer :: p, n

      n = 0
      do p = 1, neighbours%n_pairs
         associate (a => neighbours%pair(1, p), b => neighbours%pair(2, p))
            if (blocks%removed(a) .or. blocks%removed(b)) cycle
            if (size(blocks%joined) > 0) then
               if (any(blocks%joined(blocks%joined_first(a):blocks%joined_first(a + 1) - 1) == b)) &
                  cycle
            end if
            n = n + 1
            neighbours%pair(:, n) = [a, b]
         end associate
      end do
      neighbours%n_pairs = n
   end subroutine drop_pairs

   !> Mark the convex vertices and the convex blocks; both are constant during the run.
   subroutine mark_convex(neighbours, blocks)
      type(neighbours_type), intent(inout) :: neighbours  !< `convex`, `convex_block`
      type(blocks_type), intent(in) :: blocks             !< reference shapes
      integer :: v, b

      allocate (neighbours%convex(size(blocks%owner)), neighbours%convex_block(blocks%n))
      do v = 1, size(blocks%owner)
         neighbours%convex(v) = is_convex(blocks, v)
      end do
      do b = 1, blocks%n
         neighbours%convex_block(b) = all(neighbours%convex(blocks%first(b):blocks%first(b + 1) &
            - 1))
      end do
   end subroutine mark_convex

   !> Compute the bounding boxes of the blocks, enlarged by a margin.
   subroutine bound_blocks(blocks, margin, box)
      type(blocks_type), intent(in) :: blocks  !< present geometry
      real(wp), intent(in) :: margin           !< m
      real(wp), intent(out) :: box(:,:)        !< [4, n] xmin, ymin, xmax, ymax, m
      integer :: b

      do b = 1, blocks%n
         associate (vertex => blocks%vertex(:, blocks%first(b):blocks%first(b + 1) - 1))
            box(1:2, b) = minval(vertex, 2) - margin
            box(3:4, b) = maxval(vertex, 2) + margin
         end associate
      end do
   end subroutine bound_blocks

   !> Find pairs of overlapping boxes.
   !> Each pair is listed once, in the cell that contains the lower left corner of the overlap.
   subroutine find_pairs(neighbours, n, box)
      !> receives pairs, or `overflowed` if too many
      type(neighbours_type), intent(inout) :: neighbours
      integer, intent(in) :: n                            !< number of blocks
      real(wp), intent(in) :: box(:,:)                    !< [4, n] xmin, ymin, xmax, ymax, m
      type(grid_type) :: grid
      integer :: cell, i, j, a, b, most, index(2)

      call fill_grid(grid, n, box)
      neighbours%n_pairs = 0
      neighbours%overflowed = .false.
      most = most_pairs + 100*min(n, 10000000)
      call grow(neighbours%pair, 2, 4*n + 8)
      do cell = 1, size(grid%first) - 1
         do i = grid%first(cell), grid%first(cell + 1) - 1
            do j = i + 1, grid%first(cell + 1) - 1
               a = grid%member(i)
               b = grid%member(j)
               if (any(box(1:2, a) > box(3:4, b)) .or. any(box(1:2, b) > box(3:4, a))) cycle
               index = cell_index(grid, max(box(1:2, a), box(1:2, b)))
               if (1 + index(1) + index(2)*grid%shape(1) /= cell) cycle
               neighbours%overflowed = neighbours%n_pairs == most
               if (neighbours%overflowed) return
               neighbours%n_pairs = neighbours%n_pairs + 1
               call grow(neighbours%pair, 2, neighbours%n_pairs)
               neighbours%pair(:, neighbours%n_pairs) = [min(a, b), max(a, b)]
            end do
         end do
      end do
   end subroutine find_pairs

   !> Fill a grid of about n cells: each lists the boxes that overlap it.
   subroutine fill_grid(grid, n, box)
      type(grid_type), intent(out) :: grid  !< grid with members
      integer, intent(in) :: n              !< number of blocks
      real(wp), intent(in) :: box(:,:)      !< [4, n] xmin, ymin, xmax, ymax, m
      real(wp) :: extent(2)
      integer, allocatable :: cell(:), member(:), order(:)
      integer :: b, column, row, k, low(2), high(2)

      grid%origin = minval(box(1:2, :n), 2)
      extent = maxval(box(3:4, :n), 2) - grid%origin
      grid%cell = max(1.5_wp*sum(box(3:4, :n) - box(1:2, :n))/(2*n), &
         sqrt(product(extent)/(2*n + 1)), maxval(extent)/(2*n + 1), tiny(1.0_wp))
      grid%shape = 1 + int(extent/grid%cell)
      k = 0
      do b = 1, n
         low = cell_index(grid, box(1:2, b))
         high = cell_index(grid, box(3:4, b))
         call grow(cell, k + product(high - low + 1))
         call grow(member, k + product(high - low + 1))
         do row = low(2), high(2)
            do column = low(1), high(1)
               k = k + 1
               cell(k) = 1 + column + row*grid%shape(1)
               member(k) = b
            end do
         end do
      end do
      call sort_by_key(product(grid%shape), cell(:k), grid%first, order)
      grid%member = member(order)
   end subroutine fill_grid

   !> Return the column and row, from 0, of the cell of a point.
   pure function cell_index(grid, point) result(index)
      type(grid_type), intent(in) :: grid  !< origin, shape and size of the cells
      real(wp), intent(in) :: point(2)     !< m
      integer :: index(2)

      index = max(0, min(grid%shape - 1, int((point - grid%origin)/grid%cell)))
   end function cell_index

   !> Find, for each pair, the convex vertices of one block near edges of the other.
   subroutine find_probes(neighbours, blocks, reach)
      type(neighbours_type), intent(inout) :: neighbours  !< pairs; probes are replaced
      type(blocks_type), intent(in) :: blocks             !< present geometry
      real(wp), intent(in) :: reach                       !< search distance, m
      integer :: p

      call grow(neighbours%probe, 2, 8*blocks%n + 8)
      call grow(neighbours%first_edge, 8*blocks%n + 9)
      call grow(neighbours%edge, 16*blocks%n + 16)
      neighbours%n_probes = 0
      neighbours%first_edge(1) = 1
      do p = 1, neighbours%n_pairs
         associate (a => neighbours%pair(1, p), b => neighbours%pair(2, p))
            call probe_block(neighbours, blocks, p, a, b, reach)
            call probe_block(neighbours, blocks, p, b, a, reach)
         end associate
      end do
      ! The arrays persist for many steps, so unused memory is released.
      associate (n => neighbours%n_probes)
         neighbours%probe = neighbours%probe(:, :n)
         neighbours%first_edge = neighbours%first_edge(:n + 1)
         neighbours%edge = neighbours%edge(:neighbours%first_edge(n + 1) - 1)
      end associate
   end subroutine find_probes

   !> Find the probes of vertices of block a on edges of block b.
   subroutine probe_block(neighbours, blocks, pair, a, b, reach)
      type(neighbours_type), intent(inout) :: neighbours  !< probes are appended
      type(blocks_type), intent(in) :: blocks             !< present geometry
      integer, intent(in) :: pair, a, b  !< number of the near pair, and its two blocks
      real(wp), intent(in) :: reach                       !< search distance, m
      real(wp) :: low(2), high(2)
      integer :: v, e, n, last

      low = minval(blocks%vertex(:, blocks%first(b):blocks%first(b + 1) - 1), 2) - reach
      high = maxval(blocks%vertex(:, blocks%first(b):blocks%first(b + 1) - 1), 2) + reach
      do v = blocks%first(a), blocks%first(a + 1) - 1
         if (.not. neighbours%convex(v)) cycle
         if (blocks%inner(v) .and. blocks%inner(blocks%previous(v))) cycle
         if (any(blocks%vertex(:, v) < low) .or. any(blocks%vertex(:, v) > high)) cycle
         n = neighbours%n_probes + 1
         last = neighbours%first_edge(n) - 1
         do e = blocks%first(b), blocks%first(b + 1) - 1
            if (blocks%inner(e)) cycle
            if (distance_to_edge(blocks, v, e) > reach) cycle
            last = last + 1
            call grow(neighbours%edge, last)
            neighbours%edge(last) = e
         end do
         if (last < neighbours%first_edge(n)) cycle
         call grow(neighbours%probe, 2, n)
         call grow(neighbours%first_edge, n + 1)
         neighbours%probe(:, n) = [v, pair]
         neighbours%first_edge(n + 1) = last + 1
         neighbours%n_probes = n
      end do
   end subroutine probe_block

   !> List, for each probe, the convex end vertices of its edges that are near its vertex.
   !>
   !> Vertices farther apart than twice `reach − travel` cannot touch before the next search.
   subroutine find_corners(neighbours, blocks)
      type(neighbours_type), intent(inout) :: neighbours  !< probes; corners are replaced
      type(blocks_type), intent(in) :: blocks             !< present geometry
      integer :: p, i, k, w, corners
      real(wp) :: near

      call grow(neighbours%first_corner, neighbours%n_probes + 1)
      call grow(neighbours%corner, 8*blocks%n + 8)
      near = 2*(neighbours%reach - 2*neighbours%travel)
      corners = 0
      do p = 1, neighbours%n_probes
         neighbours%first_corner(p) = corners + 1
         w = 0
         do i = neighbours%first_edge(p), neighbours%first_edge(p + 1) - 1
            ! An end vertex shared by two edges is listed once.
            do k = merge(2, 1, w == neighbours%edge(i)), 2
               w = neighbours%edge(i)
               if (k == 2) w = blocks%next(w)
               if (.not. neighbours%convex(w)) cycle
               if (norm2(blocks%vertex(:, neighbours%probe(1, p)) - blocks%vertex(:, w)) > near) &
                  cycle
               corners = corners + 1
               call grow(neighbours%corner, corners)
               neighbours%corner(corners) = w
            end do
         end do
      end do
      neighbours%first_corner(neighbours%n_probes + 1) = corners + 1
      neighbours%corner = neighbours%corner(:corners)
   end subroutine find_corners

   !> Return the distance from vertex v to the nearest point of edge e, m.
   pure real(wp) function distance_to_edge(blocks, v, e)
      type(blocks_type), intent(in) :: blocks  !< present geometry
      integer, intent(in) :: v, e              !< vertex, and edge given by its first vertex
      real(wp) :: from(2), along(2), ratio

      from = blocks%vertex(:, v) - blocks%vertex(:, e)
      along = blocks%vertex(:, blocks%next(e)) - blocks%vertex(:, e)
      ratio = min(1.0_wp, max(0.0_wp, dot_product(from, along)/dot_product(along, along)))
      distance_to_edge = norm2(from - ratio*along)
   end function distance_to_edge

end module dda_neighbours
