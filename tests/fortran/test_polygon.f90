! SPDX-License-Identifier: GPL-3.0-or-later
!> Polygons against triangulation, winding numbers and unions of rectangles.
module test_polygon
   use dda_kinds, only: wp, pi
   use dda_polygon, only: area_of, centroid_of, contains_point, distance_to_boundary, is_simple, &
      overlap_depth, second_moments
   use models, only: fan, random_vector, rectangle, shifted, star, turned
   use testing, only: check, check_close
   implicit none

contains

   !> Area, centroid and second moments from the triangles of a fan.
   subroutine star_shaped_polygons()
      real(wp), allocatable :: vertices(:,:), points(:,:), weights(:)
      real(wp) :: centre(2), moments(3)
      integer :: i

      do i = 1, 200
         centre = 3.0_wp*random_vector(2)
         vertices = shifted(star(3 + modulo(i, 15), 0.2_wp, 2.0_wp), centre)
         call fan(vertices, centre, points, weights)
         call check_close(area_of(vertices), sum(weights), 'area', relative=1.0e-13_wp)
         call check_close(centroid_of(vertices), matmul(points, weights)/sum(weights), 'centroid', &
            absolute=1.0e-12_wp)
         moments = [sum(weights*points(1, :)**2), sum(weights*points(2, :)**2), &
            sum(weights*points(1, :)*points(2, :))]
         call check_close(second_moments(vertices), moments, 'second moments', relative=1.0e-12_wp)
         call check_close(area_of(vertices(:, size(vertices, 2):1:-1)), -sum(weights), &
            'clockwise', relative=1.0e-13_wp)
      end do
   end subroutine star_shaped_polygons

   !> A comb is the union of its back and its teeth, and no star.
   subroutine a_comb()
      integer, parameter :: teeth = 5
      real(wp) :: vertices(2, 4*teeth), area, first(2), second(3), parts(2, 4)
      integer :: i

      vertices(:, 1) = [0.0_wp, 0.0_wp]
      vertices(:, 2) = [2.0_wp*teeth - 1.0_wp, 0.0_wp]
      do i = 1, teeth
         vertices(:, 4*i - 1) = [2.0_wp*(teeth - i) + 1.0_wp, 3.0_wp]
         vertices(:, 4*i) = [2.0_wp*(teeth - i), 3.0_wp]
         if (i == teeth) exit
         vertices(:, 4*i + 1) = [2.0_wp*(teeth - i), 1.0_wp]
         vertices(:, 4*i + 2) = [2.0_wp*(teeth - i) - 1.0_wp, 1.0_wp]
      end do
      area = 0.0_wp
      first = 0.0_wp
      second = 0.0_wp
      do i = 0, teeth
         parts = rectangle(2.0_wp*i - 2.0_wp, 1.0_wp, 2.0_wp*i - 1.0_wp, 3.0_wp)
         if (i == 0) parts = rectangle(0.0_wp, 0.0_wp, 2.0_wp*teeth - 1.0_wp, 1.0_wp)
         call add_rectangle(parts, area, first, second)
      end do
      call check(is_simple(vertices), 'simple')
      call check_close(area_of(vertices), area, 'area', relative=1.0e-14_wp)
      call check_close(centroid_of(vertices), first/area, 'centroid', relative=1.0e-14_wp)
      call check_close(second_moments(vertices), second, 'second moments', relative=1.0e-14_wp)
   end subroutine a_comb

   !> ∫1, ∫(x, y) and ∫(x², y², xy) of an upright rectangle.
   pure subroutine add_rectangle(corners, area, first, second)
      real(wp), intent(in) :: corners(2, 4)
      real(wp), intent(inout) :: area, first(2), second(3)
      real(wp) :: middle(2), width(2), a

      middle = 0.5_wp*(corners(:, 1) + corners(:, 3))
      width = corners(:, 3) - corners(:, 1)
      a = product(width)
      area = area + a
      first = first + a*middle
      second(1:2) = second(1:2) + a*(middle**2 + width**2/12.0_wp)
      second(3) = second(3) + a*product(middle)
   end subroutine add_rectangle

   !> Area and centroid keep their digits at map coordinates.
   subroutine far_from_the_origin()
      real(wp) :: vertices(2, 4)

      vertices = shifted(rectangle(-0.5_wp, -0.5_wp, 0.5_wp, 0.5_wp), [5.0e5_wp, 4.0e6_wp])
      call check_close(area_of(vertices), 1.0_wp, 'area', relative=1.0e-9_wp)
      call check_close(centroid_of(vertices), [5.0e5_wp, 4.0e6_wp], 'centroid', absolute=1.0e-8_wp)
   end subroutine far_from_the_origin

   subroutine simple_or_not()
      real(wp), allocatable :: vertices(:,:)
      integer :: i, m

      do i = 1, 100
         m = 3 + modulo(i, 12)
         vertices = star(m, 0.3_wp, 2.0_wp)
         call check(is_simple(vertices), 'a star is simple')
         call check(is_simple(vertices(:, m:1:-1)), 'clockwise too')
         call check(.not. is_simple(vertices(:, [1, 2, 3, 3])), 'a vertex twice')
         call check(.not. is_simple(vertices(:, [1, 2, 3, 1])), 'the first vertex again')
      end do
      call check(.not. is_simple(turned(bow_tie(), 0.3_wp)), 'bow tie')
      call check(.not. is_simple(reshape([0, 0, 4, 0, 4, 2, 2, 0, 0, 2]*1.0_wp, [2, 5])), &
         'a vertex on an edge')
      call check(.not. is_simple(reshape([0, 0, 4, 0, 2, 0, 2, 2]*1.0_wp, [2, 4])), &
         'an edge runs back')
      call check(.not. is_simple(reshape([0, 0, 1, 0, 2, 0]*1.0_wp, [2, 3])), 'a line')
      call check(.not. is_simple(reshape([0, 0, 2, 0, 2, 2, 1, 1, 0, 2, 1, 1]*1.0_wp, [2, 6])), &
         'a vertex on a vertex')
      call check(is_simple(reshape([0, 0, 1, 0, 2, 0, 2, 1, 0, 1]*1.0_wp, [2, 5])), &
         'a vertex amid a straight edge')
   end subroutine simple_or_not

   pure function bow_tie() result(vertices)
      real(wp) :: vertices(2, 4)

      vertices = reshape([0.0_wp, 0.0_wp, 1.0_wp, 1.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [2, 4])
   end function bow_tie

   !> Against the sum of the angles that the edges subtend at a point.
   subroutine points_inside()
      real(wp), allocatable :: vertices(:,:)
      real(wp) :: point(2), outer_point(2), square(2, 4)
      integer :: i, k, n_wrong, n_inside

      n_wrong = 0
      n_inside = 0
      do i = 1, 100
         vertices = star(3 + modulo(i, 15), 0.2_wp, 2.0_wp)
         do k = 1, 50
            point = 2.0_wp*random_vector(2)
            if (contains_point(vertices, point, 0.0_wp)) n_inside = n_inside + 1
            if (contains_point(vertices, point, 0.0_wp) .neqv. winding(vertices, point) > pi) &
               n_wrong = n_wrong + 1
         end do
      end do
      call check(n_wrong == 0, 'as the winding number says')
      call check(n_inside > 500 .and. n_inside < 4500, 'both kinds occur')
      square = turned(rectangle(-1.0_wp, -1.0_wp, 1.0_wp, 1.0_wp), 0.4_wp)
      outer_point = 0.5_wp*(square(:, 1) + square(:, 2))*(1.0_wp + 1.0e-6_wp)
      call check(.not. contains_point(square, outer_point, 0.0_wp), 'a hair outside')
      call check(contains_point(square, outer_point, 2.0e-6_wp), 'is inside with a tolerance')
      call check(.not. contains_point(square, outer_point, 5.0e-7_wp), 'but not with a smaller one')
      do i = 1, 4
         call check(contains_point(square, square(:, i), 1.0e-12_wp), 'a corner')
      end do
   end subroutine points_inside

   !> Sum of signed angles: 2π inside, 0 outside.
   pure real(wp) function winding(vertices, point)
      real(wp), intent(in) :: vertices(:,:), point(2)
      real(wp) :: a(2), b(2)
      integer :: i

      winding = 0.0_wp
      do i = 1, size(vertices, 2)
         a = vertices(:, i) - point
         b = vertices(:, modulo(i, size(vertices, 2)) + 1) - point
         winding = winding + atan2(a(1)*b(2) - a(2)*b(1), dot_product(a, b))
      end do
   end function winding

   !> Against many points along the boundary.
   subroutine distance_to_the_boundary()
      real(wp), allocatable :: vertices(:,:)
      real(wp) :: point(2), min_distance
      integer :: i, j, k
      integer, parameter :: parts = 2000

      do i = 1, 10
         vertices = star(7, 0.2_wp, 2.0_wp)
         point = 2.0_wp*random_vector(2)
         min_distance = huge(1.0_wp)
         do j = 1, 7
            do k = 0, parts
               min_distance = min(min_distance, norm2(point - vertices(:, j) &
                  - real(k, wp)/parts*(vertices(:, modulo(j, 7) + 1) - vertices(:, j))))
            end do
         end do
         call check_close(distance_to_boundary(vertices, point), min_distance, 'distance', &
            absolute=1.0e-4_wp)
      end do
   end subroutine distance_to_the_boundary

   !> Touching is no overlap, however the two are turned.
   subroutine touching_neighbours()
      real(wp) :: square(2, 4), notched(2, 6), angle
      integer :: i

      square = rectangle(0.0_wp, 0.0_wp, 1.0_wp, 1.0_wp)
      notched = reshape([0, 0, 2, 0, 2, 2, 1, 2, 1, 1, 0, 1]*1.0_wp, [2, 6])
      do i = 0, 20
         angle = 0.31_wp*i
         call touch(square, shifted(square, [1.0_wp, 0.0_wp]), angle, 'side by side')
         call touch(square, shifted(square, [1.0_wp, 0.4_wp]), angle, 'side by side, shifted')
         call touch(square, shifted(square, [1.0_wp, 1.0_wp]), angle, 'corner to corner')
         call touch(square, shifted(turned(square, 0.25_wp*pi), [0.5_wp, 1.0_wp]), angle, &
            'corner on edge')
         call touch(square, rectangle(-3.0_wp, 1.0_wp, 4.0_wp, 2.0_wp), angle, &
            'long edge on short edge')
         call touch(notched, shifted(square, [0.0_wp, 1.0_wp]), angle, 'in a notch')
         call touch(square, shifted(square, [3.0_wp, 0.0_wp]), angle, 'apart')
      end do
   end subroutine touching_neighbours

   subroutine touch(a, b, angle, label)
      real(wp), intent(in) :: a(:,:), b(:,:), angle
      character(len=*), intent(in) :: label

      call check_close(overlap_depth(turned(a, angle), turned(b, angle)), 0.0_wp, label, &
         absolute=1.0e-14_wp)
      call check_close(overlap_depth(turned(b, angle), turned(a, angle)), 0.0_wp, label// &
         ', other way', absolute=1.0e-14_wp)
   end subroutine touch

   !> A star cut from vertex to centre to vertex: the parts touch along two edges.
   subroutine halves_of_a_star()
      real(wp) :: vertices(2, 9), first_half(2, 6), second_half(2, 6)
      integer :: i

      do i = 1, 50
         vertices = star(9, 0.5_wp, 2.0_wp)
         first_half(:, :5) = vertices(:, 1:5)
         first_half(:, 6) = 0.0_wp
         second_half(:, :5) = vertices(:, 5:9)
         second_half(:, 6) = 0.0_wp
         call check_close(overlap_depth(first_half, second_half), 0.0_wp, 'they touch', &
            absolute=1.0e-14_wp)
         call check(overlap_depth(first_half, vertices) > 0.05_wp, 'a part and the whole overlap')
      end do
   end subroutine halves_of_a_star

   subroutine overlaps()
      real(wp) :: square(2, 4), cross(2, 4), depth
      integer :: i

      square = rectangle(0.0_wp, 0.0_wp, 1.0_wp, 1.0_wp)
      do i = 1, 9
         depth = 10.0_wp**(-i)
         call check_close(overlap_depth(square, shifted(square, [1.0_wp - depth, 0.0_wp])), depth, &
            'side by side', relative=1.0e-6_wp)
         call check_close(overlap_depth(square, &
            shifted(square, [1.0_wp - depth, 1.0_wp - depth])), depth, 'corners', &
            relative=1.0e-6_wp)
      end do
      call check(overlap_depth(square, square) > 0.4_wp, 'the same twice')
      cross = rectangle(-1.0_wp, 0.4_wp, 2.0_wp, 0.6_wp)
      call check(overlap_depth(square, cross) > 0.09_wp, 'a cross, no vertex of one in the other')
      call check(overlap_depth(square, rectangle(0.4_wp, 0.4_wp, 0.6_wp, 0.6_wp)) > 0.39_wp, &
         'one in the other')
      call check(overlap_depth(rectangle(0.4_wp, 0.4_wp, 0.6_wp, 0.6_wp), square) > 0.39_wp, &
         'the other way')
   end subroutine overlaps

end module test_polygon
