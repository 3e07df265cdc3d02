! SPDX-License-Identifier: GPL-3.0-or-later
!> Parts of edges that form the outline of a model, and parts of the outline in a given region.
!>
!> A part of an edge belongs to the outline if no edge of another block runs along it.  Parts are
!> listed in the order of the blocks and their edges.
module dda_outline
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type
   use dda_counting_sort, only: sort_by_key
   use dda_edge_part, only: edge_part_type
   use dda_neighbours, only: neighbours_type, find_near_pairs
   implicit none
   private
   public :: sides, find_outline, parts_on_side, parts_along, common_span, touching

   !> Names of the sides of the bounding box, and of the upward surface.
   character(len=*), parameter :: sides(5) = [character(len=7) :: 'left', 'right', 'bottom', &
      'top', 'surface']

   real(wp), parameter :: touching = 1.0e-6_wp  !< largest zero gap/half the model size
   real(wp), parameter :: parallel = 0.0523_wp  !< sine of 3°
   real(wp), parameter :: least = 1.0e-6_wp     !< smallest fraction of an edge that is listed

contains

   !> Find the outline of the marked blocks in a model.
   subroutine find_outline(blocks, wanted, parts)
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      logical, intent(in) :: wanted(:)         !< [blocks] marks of the blocks
      type(edge_part_type), allocatable, intent(out) :: parts(:)  !< parts of their edges
      type(neighbours_type) :: neighbours
      integer, allocatable :: first(:), order(:), other(:)
      integer :: b, e, n

      allocate (parts(0))
      call find_near_pairs(neighbours, blocks, 4*touching*blocks%half_size)
      associate (pair => neighbours%pair(:, :neighbours%n_pairs))
         call sort_by_key(blocks%n, reshape(pair, [size(pair)]), first, order)
         other = reshape(pair([2, 1], :), [size(pair)])
         other = other(order)  ! the near blocks of each block
      end associate
      n = 0
      do b = 1, blocks%n
         if (.not. wanted(b) .or. blocks%removed(b)) cycle
         do e = blocks%first(b), blocks%first(b + 1) - 1
            call add_free_parts(blocks, e, other(first(b):first(b + 1) - 1), parts, n)
         end do
      end do
      parts = parts(:n)
   end subroutine find_outline

   !> Append the parts of edge e along which no edge of another block runs.
   pure subroutine add_free_parts(blocks, e, others, parts, n)
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      integer, intent(in) :: e                 !< edge, given by its first vertex
      integer, intent(in) :: others(:)         !< near blocks
      type(edge_part_type), allocatable, intent(inout) :: parts(:)  !< list to append to
      integer, intent(inout) :: n              !< number of entries of the list
      real(wp) :: free, span(2)
      integer :: i, f

      free = 0.0_wp
      do while (free < 1.0_wp - least)
         span = [1.0_wp, 1.0_wp]  ! next covered interval after `free`
         do i = 1, size(others)
            do f = blocks%first(others(i)), blocks%first(others(i) + 1) - 1
               call choose_first(common_span(blocks, e, blocks%vertex(:, f), &
                  blocks%vertex(:, blocks%next(f)), -1.0_wp), free, span)
            end do
         end do
         if (span(1) - free > least) call add_part(parts, n, edge_part_type(blocks%owner(e), e, &
            free, span(1)))
         free = span(2)
      end do
   end subroutine add_free_parts

   !> Replace `span` by interval `new` if `new` begins earlier and extends beyond a position.
   pure subroutine choose_first(new, free, span)
      real(wp), intent(in) :: new(2)       !< ends as fractions of an edge; empty if first > last
      real(wp), intent(in) :: free         !< position, as a fraction of the edge
      real(wp), intent(inout) :: span(2)   !< best interval so far

      if (new(2) - max(new(1), free) <= least) return
      if (max(new(1), free) < span(1) - least .or. (max(new(1), free) <= span(1) + least .and. &
         new(2) > span(2))) span = [max(new(1), free), new(2)]
   end subroutine choose_first

   !> Find the interval of edge e, as fractions of its length, along which a segment runs.
   !> `sense`: required direction of the segment, same (1), opposite (−1) or any (0).
   !> The interval is empty if its first value exceeds its last.
   pure function common_span(blocks, e, from, to, sense) result(span)
      type(blocks_type), intent(in) :: blocks   !< blocks in their present state
      integer, intent(in) :: e                  !< edge, given by its first vertex
      real(wp), intent(in) :: from(2), to(2)    !< ends of the segment, m
      real(wp), intent(in) :: sense             !< 1, −1 or 0
      real(wp) :: span(2)
      real(wp) :: other(2), a(2), b(2), tolerance

      span = [1.0_wp, 0.0_wp]
      tolerance = touching*blocks%half_size
      other = to - from
      associate (along => blocks%along(:, e), length => blocks%length(e), &
         start => blocks%vertex(:, e))
         if (abs(along(1)*other(2) - along(2)*other(1)) > parallel*norm2(other)) return
         if (sense*dot_product(along, other) < 0.0_wp) return
         a = [dot_product(along, from - start), along(1)*(from(2) - start(2)) &
            - along(2)*(from(1) - start(1))]
         b = [dot_product(along, to - start), along(1)*(to(2) - start(2)) &
            - along(2)*(to(1) - start(1))]
         if (min(abs(a(2)), abs(b(2))) > tolerance .and. a(2)*b(2) > 0.0_wp) return
         span = [max(0.0_wp, min(a(1), b(1))), min(length, max(a(1), b(1)))]/length
         if (distance_at(0.5_wp*sum(span)*length) > tolerance) span = [1.0_wp, 0.0_wp]
      end associate

   contains

      !> Return the distance of a point of the segment from the edge, m.
      pure real(wp) function distance_at(x)
         real(wp), intent(in) :: x  !< position along the edge, m

         distance_at = abs(a(2) + (b(2) - a(2))*(x - a(1))/(b(1) - a(1)))
      end function distance_at
   end function common_span

   !> Append a part of an edge to a list.
   pure subroutine add_part(parts, n, part)
      type(edge_part_type), allocatable, intent(inout) :: parts(:)  !< list to append to
      integer, intent(inout) :: n                 !< number of entries of the list
      type(edge_part_type), intent(in) :: part  !< part to append
      type(edge_part_type), allocatable :: more(:)

      if (n == size(parts)) then
         allocate (more(2*n + 8))
         more(:n) = parts
         call move_alloc(more, parts)
      end if
      n = n + 1
      parts(n) = part
   end subroutine add_part

   !> Select the parts on a side of the bounding box; for 'surface', the parts that face upwards.
   pure function parts_on_side(blocks, parts, side) result(selected)
      type(blocks_type), intent(in) :: blocks            !< blocks in their present state
      type(edge_part_type), intent(in) :: parts(:)     !< parts to choose from
      character(len=*), intent(in) :: side               !< one of `sides`
      type(edge_part_type), allocatable :: selected(:)
      real(wp) :: line, outward(2)
      integer :: i, axis

      if (side == 'surface') then
         selected = pack(parts, -blocks%along(1, parts%edge) > parallel)
         return
      end if
      axis = merge(1, 2, side == 'left' .or. side == 'right')
      outward = 0.0_wp
      outward(axis) = merge(-1.0_wp, 1.0_wp, side == 'left' .or. side == 'bottom')
      line = maxval(outward(axis)*blocks%vertex(axis, :))
      selected = pack(parts, [(is_on_side(parts(i)%edge), i=1, size(parts))])

   contains

      pure logical function is_on_side(e)
         integer, intent(in) :: e  !< edge

         is_on_side = outward(1)*blocks%along(2, e) - outward(2)*blocks%along(1, e) > 0.0_wp .and. &
            all(line - outward(axis)*blocks%vertex(axis, [e, blocks%next(e)]) &
            <= touching*blocks%half_size)
      end function is_on_side
   end function parts_on_side

   !> Select the parts that lie on a polyline.
   pure function parts_along(blocks, parts, line) result(selected)
      type(blocks_type), intent(in) :: blocks          !< blocks in their present state
      type(edge_part_type), intent(in) :: parts(:)   !< parts to choose from
      real(wp), intent(in) :: line(:,:)  !< [2, points] polyline in the engine's coordinates, m
      type(edge_part_type), allocatable :: selected(:)
      real(wp) :: span(2)
      integer :: i, k, n

      allocate (selected(0))
      n = 0
      do i = 1, size(parts)
         do k = 1, size(line, 2) - 1
            span = common_span(blocks, parts(i)%edge, line(:, k), line(:, k + 1), 0.0_wp)
            span = [max(span(1), parts(i)%from), min(span(2), parts(i)%to)]
            if (span(2) - span(1) > least) call add_part(selected, n, &
               edge_part_type(parts(i)%block, parts(i)%edge, span(1), span(2)))
         end do
      end do
      selected = selected(:n)
   end function parts_along

end module dda_outline
