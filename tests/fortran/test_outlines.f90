! SPDX-License-Identifier: GPL-3.0-or-later
!> Generators: the requested number of blocks, of the right size, without gaps and overlaps.
module test_outlines
   use dda_kinds, only: wp
   use dda_outlines, only: add_drums, add_layers, add_outline, add_wall, outlines_type
   use dda_polygon, only: area_of, overlap_depth
   use dda_text, only: to_text
   use models, only: rectangle, star
   use testing, only: case, check, check_close
   implicit none

contains

   subroutine both_walls()
      call walls(0.0_wp)
      call walls(0.02_wp)
   end subroutine both_walls

   pure function outline(outlines, i) result(vertices)
      type(outlines_type), intent(in) :: outlines
      integer, intent(in) :: i
      real(wp), allocatable :: vertices(:,:)

      vertices = outlines%vertices(:, outlines%first(i):outlines%first(i + 1) - 1)
   end function outline

   pure real(wp) function total_area(outlines)
      type(outlines_type), intent(in) :: outlines
      integer :: i

      total_area = 0.0_wp
      do i = 1, outlines%n
         total_area = total_area + area_of(outline(outlines, i))
      end do
   end function total_area

   real(wp) function deepest_overlap(outlines) result(depth)
      type(outlines_type), intent(in) :: outlines
      integer :: i, j

      depth = 0.0_wp
      do i = 1, outlines%n
         do j = i + 1, outlines%n
            depth = max(depth, overlap_depth(outline(outlines, i), outline(outlines, j)))
         end do
      end do
   end function deepest_overlap

   !> The list grows and retains its content.
   subroutine growth()
      type(outlines_type) :: outlines
      real(wp) :: vertices(2, 12, 100)
      integer :: i
      logical :: unchanged

      do i = 1, 100
         vertices(:, :, i) = star(12, 0.5_wp, 2.0_wp)
         call add_outline(outlines, vertices(:, :3 + modulo(i, 10), i), i, 2*i, 3*i, 'b'// &
            to_text(i))
      end do
      unchanged = outlines%n == 100
      do i = 1, 100
         unchanged = unchanged .and. outlines%material(i) == i .and. outlines%source(i) == 3*i
         unchanged = unchanged .and. all(outlines%joint(outlines%first(i):outlines%first(i + 1) &
            - 1) == 2*i)
         unchanged = unchanged .and. outlines%name(i) == 'b'//to_text(i)
         unchanged = unchanged .and. outlines%first(i + 1) - outlines%first(i) == 3 + modulo(i, 10)
         unchanged = unchanged .and. all(outline(outlines, i) == vertices(:, :3 + modulo(i, 10), i))
      end do
      call check(unchanged, 'all as they were added')
   end subroutine growth

   subroutine layers()
      type(outlines_type) :: outlines
      integer :: i

      call add_layers(outlines, -1.0_wp, 2.0_wp, 15.0_wp, 0.5_wp, 20, 3, 4, 5, 'layer')
      call check(outlines%n == 20, 'twenty')
      do i = 1, 20
         call check_close(outline(outlines, i), rectangle(-1.0_wp, 2.0_wp + 0.5_wp*(i - 1), &
            14.0_wp, 2.0_wp + 0.5_wp*i), 'layer', relative=1.0e-15_wp)
      end do
      call check(outlines%name(20) == 'layer_20', 'named')
      call check(all(outlines%material(:20) == 3) .and. all(outlines%joint(:80) == 4) .and. &
         all(outlines%source(:20) == 5), 'of what they are')
   end subroutine layers

   !> A tapering column is one trapezium.
   subroutine drums()
      type(outlines_type) :: outlines
      real(wp), allocatable :: low(:,:), high(:,:)
      integer :: i

      call add_drums(outlines, 5.0_wp, 1.0_wp, 0.5_wp, [0.8_wp, 0.6_wp], 10, 1, 1, 1, '')
      call check_close(total_area(outlines), 0.7_wp*5.0_wp, 'area', relative=1.0e-14_wp)
      call check_close(deepest_overlap(outlines), 0.0_wp, 'no overlap', absolute=1.0e-14_wp)
      do i = 1, 9
         low = outline(outlines, i)
         high = outline(outlines, i + 1)
         call check_close(low(:, 3), high(:, 2), 'right edges meet')
         call check_close(low(:, 4), high(:, 1), 'left edges meet')
      end do
      low = outline(outlines, 1)
      call check_close(low(1, 1:2), [4.6_wp, 5.4_wp], 'foot', relative=1.0e-15_wp)
      call check_close(high(1, 3:4), [5.3_wp, 4.7_wp], 'head', relative=1.0e-15_wp)
      call check(outlines%name(3) == '', 'nameless')
   end subroutine drums

   !> Full and broken courses by turns; each fills its height from end to end.
   subroutine walls(head_joint)
      real(wp), intent(in) :: head_joint
      type(outlines_type) :: outlines
      integer :: bricks, courses, joints

      call case('walls')
      do bricks = 1, 4
         do courses = 1, 5
            call clear(outlines)
            call add_wall(outlines, 1.0_wp, -2.0_wp, [0.6_wp, 0.3_wp], bricks, courses, 1, 1, 1, &
               'brick', head_joint)
            call check(outlines%n == bricks*courses + courses/2, 'count')
            joints = courses*(bricks - 1) + courses/2
            call check_close(total_area(outlines), 0.18_wp*bricks*courses &
               - 0.3_wp*head_joint*joints, 'area', relative=1.0e-13_wp)
            call check_close(deepest_overlap(outlines), 0.0_wp, 'no overlap', absolute=1.0e-14_wp)
            associate (v => outlines%vertices(:, :outlines%n_vertices))
               call check_close(minval(v, 2), [1.0_wp, -2.0_wp], 'lower left', relative=1.0e-14_wp)
               call check_close(maxval(v, 2), [1.0_wp + 0.6_wp*bricks, -2.0_wp + 0.3_wp*courses], &
                  'upper right', relative=1.0e-14_wp)
            end associate
         end do
      end do
   end subroutine walls

   subroutine clear(outlines)
      type(outlines_type), intent(out) :: outlines

      outlines%n = 0
   end subroutine clear

end module test_outlines
