! SPDX-License-Identifier: GPL-3.0-or-later
!> Find the faces between cells of bodies, with a tolerance, in O(n); also find the pairs of joined
!> cells, between which no contact is possible.
module dda_cell_faces
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type
   use dda_counting_sort, only: sort_by_key
   use dda_growth, only: grow
   use dda_neighbours, only: neighbours_type, find_near_pairs
   use dda_polygon, only: distance_to_boundary
   use dda_weld, only: weld_type, is_shifted, new_weld, weld_open
   implicit none
   private
   public :: find_faces, find_gap, separate_cells

   real(wp), parameter :: same_position = 1.0e-6_wp  !< distance tolerance/smaller radius
   real(wp), parameter :: near = 0.1_wp  !< largest gap of joined cells/smaller radius

contains

   !> List all faces in the order of their cells.
   !> Pairs of cells are marked as joined if they share a face or a corner, or nearly touch.
   subroutine find_faces(blocks, welds)
      type(blocks_type), intent(inout) :: blocks  !< blocks with bodies; `joined` is set
      type(weld_type), allocatable, intent(out) :: welds(:)  !< faces of all bodies
      type(neighbours_type) :: neighbours
      integer, allocatable :: joined(:,:)
      integer :: p, n, pairs

      allocate (welds(0))
      if (.not. any(blocks%body > 0)) return
      call find_near_pairs(neighbours, blocks, near*maxval(blocks%radius, mask=blocks%body > 0))
      deallocate (welds)
      allocate (welds(4*blocks%n), joined(2, 8*blocks%n))
      n = 0
      pairs = 0
      do p = 1, neighbours%n_pairs
         associate (a => neighbours%pair(1, p), b => neighbours%pair(2, p))
            if (blocks%body(a) == 0 .or. blocks%body(a) /= blocks%body(b)) cycle
            call add_faces(blocks, a, b, welds, n)
            if (.not. are_near(blocks, a, b)) cycle
            pairs = pairs + 1
            call grow(joined, 2, pairs)
            joined(:, pairs) = [a, b]
         end associate
      end do
      welds = welds(:n)
      call store_joined_pairs(blocks, joined(:, :pairs))
   end subroutine find_faces

   !> Store the joined pairs, grouped by their first cells.
   subroutine store_joined_pairs(blocks, joined)
      type(blocks_type), intent(inout) :: blocks  !< receives the lists
      integer, intent(in) :: joined(:,:)          !< [2, pairs] cells of each pair, first < second
      integer, allocatable :: order(:)

      call sort_by_key(blocks%n, joined(1, :), blocks%joined_first, order)
      blocks%joined = joined(2, order)
   end subroutine store_joined_pairs

   !> Allow contacts between cells that are no longer connected by a path of intact faces.
   !> A path contains only cells that were initially joined to both cells of the pair.
   subroutine separate_cells(blocks, first, welds)
      type(blocks_type), intent(inout) :: blocks  !< blocks whose lists are replaced
      type(blocks_type), intent(in) :: first  !< blocks with the lists of all initially joined cells
      type(weld_type), intent(in) :: welds(:)     !< faces of all bodies
      type(weld_type), allocatable :: intact(:)
      integer, allocatable :: start(:), face(:), joined(:,:)
      integer :: a, i, n

      intact = pack(welds, welds%state /= weld_open)
      intact = pack(intact, .not. is_shifted(intact))
      call sort_by_key(blocks%n, [(intact(i)%block, i=1, size(intact))], start, face)
      face = (face + 1)/2
      allocate (joined(2, size(first%joined)))
      n = 0
      do a = 1, blocks%n
         do i = first%joined_first(a), first%joined_first(a + 1) - 1
            if (.not. is_path_of_faces(first, intact, start, face, [a, first%joined(i)])) cycle
            n = n + 1
            joined(:, n) = [a, first%joined(i)]
         end do
      end do
      call store_joined_pairs(blocks, joined(:, :n))
   end subroutine separate_cells

   !> .true. if a path through intact faces connects two joined cells.
   pure logical function is_path_of_faces(first, intact, start, face, pair)
      type(blocks_type), intent(in) :: first  !< blocks with the lists of all initially joined cells
      type(weld_type), intent(in) :: intact(:)   !< intact faces
      integer, intent(in) :: start(:), face(:)   !< start of each cell in `face`; its faces
      integer, intent(in) :: pair(2)             !< two joined cells
      integer, parameter :: longest = 64            !< largest number of cells of a path
      integer :: list(longest), at, cells, k, next

      list(1) = pair(1)
      cells = 1
      at = 1
      is_path_of_faces = .false.
      do while (at <= cells)
         do k = start(list(at)), start(list(at) + 1) - 1
            next = sum(intact(face(k))%block) - list(at)
            is_path_of_faces = next == pair(2)
            if (is_path_of_faces) return
            if (cells == longest) cycle
            if (any(list(:cells) == next)) cycle
            if (.not. were_joined(first, next, pair(1))) cycle
            if (.not. were_joined(first, next, pair(2))) cycle
            cells = cells + 1
            list(cells) = next
         end do
         at = at + 1
      end do
   end function is_path_of_faces

   !> .true. if two cells were joined at the start of the run.
   pure logical function were_joined(first, a, b)
      type(blocks_type), intent(in) :: first  !< blocks with the lists of all initially joined cells
      integer, intent(in) :: a, b             !< cells

      associate (low => min(a, b), high => max(a, b))
         were_joined = any(first%joined(first%joined_first(low):first%joined_first(low + 1) - 1) &
            == high)
      end associate
   end function were_joined

   !> Append the faces that two cells share.
   subroutine add_faces(blocks, a, b, welds, n)
      type(blocks_type), intent(in) :: blocks  !< blocks at the start
      integer, intent(in) :: a, b              !< cells of a body
      type(weld_type), allocatable, intent(inout) :: welds(:)  !< entries 1 … n are used
      integer, intent(inout) :: n              !< number of faces
      type(weld_type), allocatable :: more(:)
      real(wp) :: small, low, high
      integer :: e, f

      small = same_position*min(blocks%radius(a), blocks%radius(b))
      do e = blocks%first(a), blocks%first(a + 1) - 1
         do f = blocks%first(b), blocks%first(b + 1) - 1
            call find_overlap(blocks, e, f, small, low, high)
            if (high - low <= small) cycle
            if (n == size(welds)) then
               allocate (more(2*n))
               more(:n) = welds
               call move_alloc(more, welds)
            end if
            n = n + 1
            welds(n) = new_weld(blocks, e, f, low, high, [0.0_wp, 0.0_wp])
         end do
      end do
   end subroutine add_faces

   !> Find the interval of edge e along which edge f runs in the opposite direction.
   !> Unit: m from the first vertex of e; the interval is empty if the edges do not touch.
   pure subroutine find_overlap(blocks, e, f, small, low, high)
      type(blocks_type), intent(in) :: blocks  !< blocks at the start
      integer, intent(in) :: e, f              !< edges, given by their first vertices
      real(wp), intent(in) :: small            !< distance tolerance, m
      real(wp), intent(out) :: low, high       !< ends of the interval, m
      real(wp) :: from(2), to(2), normal(2)

      low = 0.0_wp
      high = 0.0_wp
      associate (along => blocks%along(:, e), length => blocks%length(e))
         if (dot_product(along, blocks%along(:, f)) > -0.5_wp) return
         normal = [along(2), -along(1)]
         from = blocks%vertex(:, f) - blocks%vertex(:, e)
         to = blocks%vertex(:, blocks%next(f)) - blocks%vertex(:, e)
         if (max(abs(dot_product(normal, from)), abs(dot_product(normal, to))) > small) return
         low = max(0.0_wp, dot_product(along, to))
         high = min(length, dot_product(along, from))
      end associate
   end subroutine find_overlap

   !> Find two joined cells with free edges that face each other across a gap; 0 if there are none.
   !> Such a gap would be an unintended crack: neither welds nor contacts act across it.
   pure subroutine find_gap(blocks, a, b)
      type(blocks_type), intent(in) :: blocks  !< blocks with `joined` and inner edges
      integer, intent(out) :: a, b             !< cells of a body
      real(wp) :: radius, low, high
      integer :: i, e, f

      b = 0
      do a = 1, merge(blocks%n, 0, size(blocks%joined) > 0)
         do i = blocks%joined_first(a), blocks%joined_first(a + 1) - 1
            b = blocks%joined(i)
            radius = min(blocks%radius(a), blocks%radius(b))
            do e = blocks%first(a), blocks%first(a + 1) - 1
               if (blocks%inner(e)) cycle
               do f = blocks%first(b), blocks%first(b + 1) - 1
                  if (blocks%inner(f)) cycle
                  call find_overlap(blocks, e, f, near*radius, low, high)
                  if (high - low > near*radius) return
               end do
            end do
         end do
      end do
      a = 0
   end subroutine find_gap

   !> .true. if two cells of a body touch or nearly touch.
   pure logical function are_near(blocks, a, b)
      type(blocks_type), intent(in) :: blocks  !< blocks at the start
      integer, intent(in) :: a, b              !< cells of a body
      real(wp) :: reach

      reach = near*min(blocks%radius(a), blocks%radius(b))
      are_near = has_vertex_near(a, b)
      if (.not. are_near) are_near = has_vertex_near(b, a)

   contains

      !> .true. if a vertex of cell `one` is near cell `other`.
      pure logical function has_vertex_near(one, other) result(found)
         integer, intent(in) :: one, other  !< cells
         integer :: v

         associate (outline => blocks%vertex(:, blocks%first(other):blocks%first(other + 1) - 1))
            do v = blocks%first(one), blocks%first(one + 1) - 1
               found = distance_to_boundary(outline, blocks%vertex(:, v)) <= reach
               if (found) return
            end do
         end associate
      end function has_vertex_near
   end function are_near

end module dda_cell_faces
