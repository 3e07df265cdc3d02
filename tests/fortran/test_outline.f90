! SPDX-License-Identifier: GPL-3.0-or-later
!> The outline of a model and its parts: every part once, of the right length, on the right side.
module test_outline
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type
   use dda_edge_part, only: edge_part_type, part_length, part_normal, gauss_points, reference_at
   use dda_outline, only: find_outline, parts_on_side, parts_along
   use dda_outlines, only: outlines_type, add_outline
   use models, only: make_rock_blocks, rectangle
   use testing, only: check, check_close
   implicit none

   type(blocks_type) :: blocks

contains

   !> Blocks from their polygons.
   subroutine make(first, vertices)
      integer, intent(in) :: first(:)
      real(wp), intent(in) :: vertices(:,:)
      type(outlines_type) :: outlines
      integer :: i

      do i = 1, size(first) - 1
         call add_outline(outlines, vertices(:, first(i):first(i + 1) - 1), 1, 1, 1, '')
      end do
      call make_rock_blocks(outlines, blocks)
   end subroutine make

   pure real(wp) function length_of(parts)
      type(edge_part_type), intent(in) :: parts(:)
      integer :: i

      length_of = sum([(part_length(blocks, parts(i)), i=1, size(parts))])
   end function length_of

   !> Three by two blocks of 2 m × 1 m.
   subroutine grid()
      type(edge_part_type), allocatable :: all_parts(:), edges(:)
      real(wp) :: vertices(2, 24)
      integer :: i, j

      do j = 0, 1
         do i = 0, 2
            vertices(:, 12*j + 4*i + 1:12*j + 4*i + 4) = rectangle(2.0_wp*i, 1.0_wp*j, &
               2.0_wp*i + 2.0_wp, j + 1.0_wp)
         end do
      end do
      call make([(4*i + 1, i=0, 6)], vertices)
      call find_outline(blocks, spread(.true., 1, 6), all_parts)
      call check(size(all_parts) == 10, 'ten edges are free')
      call check_close(length_of(all_parts), 16.0_wp, 'their length', relative=1.0e-12_wp)
      edges = parts_on_side(blocks, all_parts, 'left')
      call check(all_equal(edges%block, [1, 4]), 'blocks of the left side')
      call check_close(part_normal(blocks, edges(1)), [-1.0_wp, 0.0_wp], 'normal of the left side')
      edges = parts_on_side(blocks, all_parts, 'bottom')
      call check(all_equal(edges%block, [1, 2, 3]), 'blocks of the bottom')
      call check(size(parts_on_side(blocks, all_parts, 'surface')) == 3, 'three edges face upwards')
      edges = parts_along(blocks, all_parts, reshape([1.0_wp, 2.0_wp, 6.0_wp, 2.0_wp, 6.0_wp, &
         1.5_wp], [2, 3]))
      call check_close(length_of(edges), 5.5_wp, 'pieces along a polyline', &
         relative=1.0e-12_wp)
      call find_outline(blocks, [.false., .true., spread(.false., 1, 4)], edges)
      call check(size(edges) == 1 .and. edges(1)%block == 2, 'the one free edge of a block')
   end subroutine grid

   pure logical function all_equal(a, b)
      integer, intent(in) :: a(:), b(:)

      all_equal = size(a) == size(b)
      if (all_equal) all_equal = all(a == b)
   end function all_equal

   !> A narrow block on the middle of a wide one leaves two free parts of its top.
   subroutine steps()
      type(edge_part_type), allocatable :: edges(:)

      call make([1, 5, 9, 13], reshape([rectangle(0.0_wp, 0.0_wp, 10.0_wp, 1.0_wp), &
         rectangle(4.0_wp, 1.0_wp, 5.0_wp, 2.0_wp), rectangle(5.0_wp, 1.0_wp, 7.0_wp, 2.0_wp)], &
         [2, 12]))
      call find_outline(blocks, [.true., .false., .false.], edges)
      edges = parts_on_side(blocks, edges, 'surface')
      call check(size(edges) == 2, 'two pieces are free')
      call check_close([edges%from, edges%to], [0.0_wp, 0.6_wp, 0.3_wp, 1.0_wp], 'shares of '// &
         'the edge', absolute=1.0e-12_wp)
      call find_outline(blocks, spread(.true., 1, 3), edges)
      call check_close(length_of(edges), 10.0_wp + 2.0_wp + 7.0_wp + 2.0_wp + 3.0_wp, &
         'length of the outline', relative=1.0e-12_wp)
   end subroutine steps

   !> A face that is no side of the box.
   subroutine slope()
      type(edge_part_type), allocatable :: edges(:)

      call make([1, 4], reshape([0.0_wp, 0.0_wp, 4.0_wp, 0.0_wp, 0.0_wp, 3.0_wp], &
         [2, 3]))
      call find_outline(blocks, [.true.], edges)
      edges = parts_along(blocks, edges, reshape([4.0_wp, 0.0_wp, 0.0_wp, 3.0_wp], [2, 2]))
      call check(size(edges) == 1, 'the slope')
      call check_close(part_normal(blocks, edges(1)), [0.6_wp, 0.8_wp], 'its normal')
      call check_close(part_length(blocks, edges(1)), 5.0_wp, 'its length')
   end subroutine slope

   !> The two points integrate squares of linear functions along a part.
   subroutine points_of_gauss()
      type(edge_part_type) :: part
      real(wp) :: reference(2, 2), ends(2, 2), centre(2)

      call make([1, 5], rectangle(0.0_wp, 0.0_wp, 4.0_wp, 1.0_wp))
      part = edge_part_type(1, 1, 0.25_wp, 1.0_wp)
      centre = blocks%position(1:2, 1)
      reference = gauss_points(blocks, part) + spread(centre, 2, 2)
      ends(:, 1) = reference_at(blocks, part, 0.0_wp) + centre
      ends(:, 2) = reference_at(blocks, part, 1.0_wp) + centre
      call check_close(ends(1, :), [1.0_wp, 4.0_wp], 'ends of the piece')
      call check_close(0.5_wp*part_length(blocks, part)*sum(reference(1, :)**2), 21.0_wp, &
         'integral of x²', relative=1.0e-12_wp)
   end subroutine points_of_gauss

end module test_outline
