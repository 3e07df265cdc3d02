! SPDX-License-Identifier: GPL-3.0-or-later
!> Near pairs and probes against a search of everything by everything.
module test_neighbours
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type, is_convex, update_geometry
   use dda_neighbours, only: find_neighbours, neighbours_type
   use dda_outlines, only: add_outline, outlines_type
   use models, only: make_rock_blocks, place_blocks, random, random_vector, rectangle, shifted, star
   use testing, only: check
   implicit none

   type(blocks_type) :: blocks

contains

   subroutine random_blocks_of_very_different_size()
      integer :: i

      do i = 1, 20
         call try_random(10 + 5*i)
      end do
   end subroutine random_blocks_of_very_different_size

   !> Sizes over three decades; searched again after everything has moved.
   subroutine try_random(n)
      integer, intent(in) :: n
      type(outlines_type) :: outlines
      type(neighbours_type) :: neighbours
      real(wp) :: scale
      integer :: i

      do i = 1, n
         scale = 10.0_wp**random(-2.0_wp, 1.0_wp)
         call add_outline(outlines, shifted(scale*star(3 + modulo(i, 7), 0.3_wp, 1.0_wp), &
            15.0_wp*random_vector(2)), 1, 1, 1, '')
      end do
      call make_rock_blocks(outlines, blocks)
      call find_neighbours(neighbours, blocks, 0.3_wp)
      call compare(neighbours, 0.3_wp)
      blocks%position(1:2, :) = 20.0_wp*reshape(random_vector(2*n), [2, n])
      blocks%position(3, :) = 3.0_wp*random_vector(n)
      call update_geometry(blocks)
      call find_neighbours(neighbours, blocks, 1.0_wp)
      call compare(neighbours, 1.0_wp)
   end subroutine try_random

   !> Every convex vertex within reach of an edge of another block is a probe with that edge; no
   !> other.
   subroutine compare(neighbours, reach)
      type(neighbours_type), intent(in) :: neighbours
      real(wp), intent(in) :: reach
      logical, allocatable :: listed(:,:), paired(:,:)
      integer :: p, i, v, e, missed, extra, repeated, wrong_pair

      allocate (listed(size(blocks%owner), size(blocks%owner)), paired(blocks%n, blocks%n), &
         source=.false.)
      repeated = 0
      wrong_pair = 0
      do p = 1, neighbours%n_pairs
         associate (a => neighbours%pair(1, p), b => neighbours%pair(2, p))
            if (a >= b) wrong_pair = wrong_pair + 1
            if (paired(a, b)) repeated = repeated + 1
            paired(a, b) = .true.
         end associate
      end do
      do p = 1, neighbours%n_probes
         v = neighbours%probe(1, p)
         do i = neighbours%first_edge(p), neighbours%first_edge(p + 1) - 1
            e = neighbours%edge(i)
            if (listed(v, e)) repeated = repeated + 1
            listed(v, e) = .true.
            if (.not. is_pair(neighbours%pair(:, neighbours%probe(2, p)), blocks%owner(v), &
               blocks%owner(e))) wrong_pair = wrong_pair + 1
         end do
      end do
      missed = 0
      extra = 0
      do v = 1, size(blocks%owner)
         do e = 1, size(blocks%owner)
            if (within(v, e, reach) .and. .not. listed(v, e)) missed = missed + 1
            if (listed(v, e) .and. .not. within(v, e, reach)) extra = extra + 1
         end do
      end do
      call check(missed == 0, 'none missed')
      call check(extra == 0, 'none beyond reach')
      call check(repeated == 0, 'none twice')
      call check(wrong_pair == 0, 'probes name their pair, pairs ascend')
      call check(all([(corners_listed(neighbours, p, reach), p=1, neighbours%n_probes)]), &
         'corners within reach are listed')
   end subroutine compare

   !> Probe p lists every convex vertex of the other block within reach; vertices beyond may be
   !> listed if they are convex.
   pure logical function corners_listed(neighbours, p, reach)
      type(neighbours_type), intent(in) :: neighbours
      integer, intent(in) :: p
      real(wp), intent(in) :: reach
      integer :: w, other

      associate (corner => neighbours%corner(neighbours%first_corner(p):neighbours%first_corner(p &
         + 1) - 1), v => neighbours%probe(1, p))
         other = blocks%owner(neighbours%edge(neighbours%first_edge(p)))
         corners_listed = all(blocks%owner(corner) == other) .and. all(neighbours%convex(corner))
         do w = blocks%first(other), blocks%first(other + 1) - 1
            if (.not. is_convex(blocks, w) .or. norm2(blocks%vertex(:, v) - blocks%vertex(:, w)) &
               > reach) cycle
            corners_listed = corners_listed .and. any(corner == w)
         end do
      end associate
   end function corners_listed

   pure logical function is_pair(pair, a, b)
      integer, intent(in) :: pair(2), a, b

      is_pair = pair(1) == min(a, b) .and. pair(2) == max(a, b)
   end function is_pair

   !> A convex vertex of one block and an edge of another are within reach.
   logical function within(v, e, reach)
      integer, intent(in) :: v, e
      real(wp), intent(in) :: reach
      real(wp) :: a(2), b(2), p(2), fraction

      within = .false.
      if (blocks%owner(v) == blocks%owner(e) .or. .not. is_convex(blocks, v)) return
      a = blocks%vertex(:, e)
      b = blocks%vertex(:, blocks%next(e))
      p = blocks%vertex(:, v)
      fraction = max(0.0_wp, min(1.0_wp, dot_product(p - a, b - a)/sum((b - a)**2)))
      within = norm2(p - a - fraction*(b - a)) <= reach
   end function within

   subroutine make_lattice(n)
      integer, intent(in) :: n
      type(outlines_type) :: outlines
      integer :: i, j

      do i = 1, n
         do j = 1, n
            call add_outline(outlines, rectangle(real(i, wp), real(j, wp), real(i + 1, wp), &
               real(j + 1, wp)), 1, 1, 1, '')
         end do
      end do
      call make_rock_blocks(outlines, blocks)
   end subroutine make_lattice

   !> n × n squares side by side: 2n(n−1) joints and 2(n−1)² diagonals.
   subroutine a_lattice()
      type(neighbours_type) :: neighbours
      integer :: n

      do n = 1, 9
         call discard_iterations(neighbours)
         call make_lattice(n)
         call find_neighbours(neighbours, blocks, 0.01_wp)
         call check(neighbours%n_pairs == 2*n*(n - 1) + 2*(n - 1)**2, 'pairs')
         call compare(neighbours, 0.01_wp)
      end do
   end subroutine a_lattice

   subroutine discard_iterations(neighbours)
      type(neighbours_type), intent(out) :: neighbours

      neighbours%n_pairs = 0
   end subroutine discard_iterations

   subroutine one_block()
      type(neighbours_type) :: near

      call place_blocks(blocks, rectangle(0.0_wp, 0.0_wp, 1.0_wp, 1.0_wp))
      call find_neighbours(near, blocks, 5.0_wp)
      call check(near%n_pairs == 0 .and. near%n_probes == 0, 'has no neighbours')
   end subroutine one_block

   !> One distant block a million sizes away costs neither memory nor pairs.
   subroutine a_distant_block()
      type(outlines_type) :: outlines
      type(neighbours_type) :: neighbours
      integer :: i

      do i = 1, 100
         call add_outline(outlines, rectangle(real(i, wp), 0.0_wp, real(i + 1, wp), 1.0_wp), 1, 1, &
            1, '')
      end do
      call add_outline(outlines, rectangle(1.0e6_wp, 1.0e6_wp, 1.0e6_wp + 1.0_wp, &
         1.0e6_wp + 1.0_wp), 1, 1, 1, '')
      call make_rock_blocks(outlines, blocks)
      call find_neighbours(neighbours, blocks, 0.01_wp)
      call check(neighbours%n_pairs == 99, 'the row has 99 joints')
      call compare(neighbours, 0.01_wp)
   end subroutine a_distant_block

   !> With 36 times as many blocks, pairs, probes and time per block are about the same, apart from
   !> the rim.
   subroutine cost_per_block()
      real(wp) :: small_grid(2), large_grid(2)

      small_grid = measure(25)
      large_grid = measure(150)
      call check(abs(large_grid(1)/small_grid(1) - 1.0_wp) < 0.1_wp, 'probes per block do not grow')
      call check(large_grid(2) < 6.0_wp*small_grid(2), &
         'time per block does not grow sixfold for 36 '//'times the blocks')
   end subroutine cost_per_block

   !> Probes and least seconds for each block of an n × n lattice.
   function measure(n) result(cost)
      integer, intent(in) :: n
      real(wp) :: cost(2)
      type(neighbours_type) :: neighbours
      real(wp) :: from, to
      integer :: i, k

      call make_lattice(n)
      cost(2) = huge(1.0_wp)
      do i = 1, 5
         call cpu_time(from)
         do k = 1, max(1, 10000/n**2)
            call find_neighbours(neighbours, blocks, 0.01_wp)
         end do
         call cpu_time(to)
         cost(2) = min(cost(2), (to - from)/real(n**2*max(1, 10000/n**2), wp))
      end do
      cost(1) = real(neighbours%n_probes, wp)/real(n**2, wp)
   end function measure

end module test_neighbours
