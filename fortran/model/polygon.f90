! SPDX-License-Identifier: GPL-3.0-or-later
!> Simple polygons: exact area, centroid and second moments, and tests of validity.
!>
!> Vertices are counter-clockwise, [2, m].  Integrals are sums over the edges (Green's theorem),
!> exact for any simple polygon, convex or not (Shi's simplex integration in two dimensions).
module dda_polygon
   use dda_kinds, only: wp
   use dda_sorting, only: ascending_order
   implicit none
   private
   public :: area_of, centroid_of, second_moments, is_simple, contains_point, distance_to_boundary
   public :: overlap_depth

contains

   !> Signed area, m²: positive for counter-clockwise vertices.
   pure real(wp) function area_of(vertices)
      real(wp), intent(in) :: vertices(:,:)  !< [2, m] counter-clockwise, m
      integer :: i, j
      real(wp) :: a(2), b(2)

      area_of = 0.0_wp
      do i = 1, size(vertices, 2)
         j = mod(i, size(vertices, 2)) + 1
         a = vertices(:, i) - vertices(:, 1)
         b = vertices(:, j) - vertices(:, 1)
         area_of = area_of + 0.5_wp*(a(1)*b(2) - a(2)*b(1))
      end do
   end function area_of

   !> Centre of area, m.
   pure function centroid_of(vertices) result(centroid)
      real(wp), intent(in) :: vertices(:,:)  !< [2, m] counter-clockwise, m
      real(wp) :: centroid(2)
      integer :: i, j
      real(wp) :: a(2), b(2), twice_area

      centroid = 0.0_wp
      twice_area = 0.0_wp
      do i = 1, size(vertices, 2)
         j = mod(i, size(vertices, 2)) + 1
         a = vertices(:, i) - vertices(:, 1)
         b = vertices(:, j) - vertices(:, 1)
         twice_area = twice_area + (a(1)*b(2) - a(2)*b(1))
         centroid = centroid + (a(1)*b(2) - a(2)*b(1))*(a + b)/3.0_wp
      end do
      centroid = vertices(:, 1) + centroid/twice_area
   end function centroid_of

   !> Second moments (∫x², ∫y², ∫xy) of the polygon about the origin of its coordinates, m⁴.
   pure function second_moments(vertices) result(moments)
      real(wp), intent(in) :: vertices(:,:)  !< [2, m] counter-clockwise, m
      real(wp) :: moments(3)
      integer :: i, j
      real(wp) :: a(2), b(2), cross

      moments = 0.0_wp
      do i = 1, size(vertices, 2)
         j = mod(i, size(vertices, 2)) + 1
         a = vertices(:, i)
         b = vertices(:, j)
         cross = a(1)*b(2) - a(2)*b(1)
         moments(1) = moments(1) + cross*(a(1)**2 + a(1)*b(1) + b(1)**2)/12.0_wp
         moments(2) = moments(2) + cross*(a(2)**2 + a(2)*b(2) + b(2)**2)/12.0_wp
         moments(3) = moments(3) + cross*(2*a(1)*a(2) + a(1)*b(2) + b(1)*a(2) + 2*b(1)*b(2))/24.0_wp
      end do
   end function second_moments

   !> .true. if all edges have a length and only neighbouring edges touch, at their common vertex.
   pure logical function is_simple(vertices)
      real(wp), intent(in) :: vertices(:,:)  !< [2, m] counter-clockwise, m
      integer :: i, j, m

      m = size(vertices, 2)
      is_simple = .false.
      do i = 1, m
         if (all(vertices(:, i) == vertices(:, mod(i, m) + 1))) return
         if (folds_back(vertices, i)) return
         do j = i + 2, m
            if (i == 1 .and. j == m) cycle
            if (edges_meet(vertices, i, j)) return
         end do
      end do
      is_simple = .true.
   end function is_simple

   !> .true. if the edge after vertex i runs back along the edge before this vertex.
   pure logical function folds_back(vertices, i)
      real(wp), intent(in) :: vertices(:,:)  !< [2, m] counter-clockwise, m
      integer, intent(in) :: i               !< vertex
      real(wp) :: incoming(2), outgoing(2)
      integer :: m

      m = size(vertices, 2)
      incoming = vertices(:, i) - vertices(:, mod(i + m - 2, m) + 1)
      outgoing = vertices(:, mod(i, m) + 1) - vertices(:, i)
      folds_back = incoming(1)*outgoing(2) - incoming(2)*outgoing(1) == 0.0_wp &
         .and. dot_product(incoming, outgoing) < 0.0_wp
   end function folds_back

   !> .true. if edges i and j have at least one common point.
   pure logical function edges_meet(vertices, i, j)
      real(wp), intent(in) :: vertices(:,:)  !< [2, m] counter-clockwise, m
      integer, intent(in) :: i, j            !< edges, given by their first vertices
      real(wp) :: a(2), b(2), c(2), d(2)
      integer :: m

      m = size(vertices, 2)
      a = vertices(:, i)
      b = vertices(:, mod(i, m) + 1)
      c = vertices(:, j)
      d = vertices(:, mod(j, m) + 1)
      edges_meet = side(a, b, c)*side(a, b, d) <= 0 .and. side(c, d, a)*side(c, d, b) <= 0
      if (side(a, b, c) == 0 .and. side(a, b, d) == 0) then
         edges_meet = all(max(min(a, b), min(c, d)) <= min(max(a, b), max(c, d)))
      end if
   end function edges_meet

   !> Side of the line a→b on which p lies: +1 left, −1 right, 0 on the line.
   pure integer function side(a, b, p)  ! total
      real(wp), intent(in) :: a(2), b(2), p(2)  !< points, m
      real(wp) :: cross

      cross = (b(1) - a(1))*(p(2) - a(2)) - (b(2) - a(2))*(p(1) - a(1))
      side = merge(1, merge(-1, 0, cross < 0.0_wp), cross > 0.0_wp)
   end function side

   !> .true. if the point lies inside, or on the boundary within the tolerance.
   pure logical function contains_point(vertices, point, tolerance)
      real(wp), intent(in) :: vertices(:,:)  !< [2, m] counter-clockwise, m
      real(wp), intent(in) :: point(2)       !< m
      real(wp), intent(in) :: tolerance      !< m
      integer :: i, j
      logical :: is_inside
      real(wp) :: a(2), b(2)

      is_inside = .false.
      do i = 1, size(vertices, 2)
         j = mod(i, size(vertices, 2)) + 1
         a = vertices(:, i)
         b = vertices(:, j)
         if ((a(2) > point(2)) .neqv. (b(2) > point(2))) then
            if (point(1) < a(1) + (point(2) - a(2))/(b(2) - a(2))*(b(1) - a(1))) &
               is_inside = .not. is_inside
         end if
      end do
      contains_point = is_inside
      if (.not. is_inside .and. tolerance > 0.0_wp) &
         contains_point = distance_to_boundary(vertices, point) <= tolerance
   end function contains_point

   !> Distance from a point to the nearest edge, m.
   pure real(wp) function distance_to_boundary(vertices, point)
      real(wp), intent(in) :: vertices(:,:)  !< [2, m] counter-clockwise, m
      real(wp), intent(in) :: point(2)       !< m
      integer :: i, j
      real(wp) :: edge(2), ratio

      distance_to_boundary = huge(1.0_wp)
      do i = 1, size(vertices, 2)
         j = mod(i, size(vertices, 2)) + 1
         edge = vertices(:, j) - vertices(:, i)
         ratio = dot_product(point - vertices(:, i), edge)/dot_product(edge, edge)
         ratio = min(1.0_wp, max(0.0_wp, ratio))
         distance_to_boundary = min(distance_to_boundary, &
            norm2(point - vertices(:, i) - ratio*edge))
      end do
   end function distance_to_boundary

   !> Depth of the overlap of two polygons, m: 0 if they are apart or only touch.
   !>
   !> The result is the depth of the deepest sample of one polygon inside the other.  Samples are
   !> its centroid, its vertices, and the midpoints of the parts into which the other polygon cuts
   !> its edges.
   pure real(wp) function overlap_depth(first, second)
      real(wp), intent(in) :: first(:,:), second(:,:)  !< [2, any] counter-clockwise, m

      overlap_depth = max(sample_depth(first, second), sample_depth(second, first))
   end function overlap_depth

   !> Depth of the deepest sample of `first` inside `second`, m.
   pure real(wp) function sample_depth(first, second)
      real(wp), intent(in) :: first(:,:), second(:,:)  !< [2, any] counter-clockwise, m
      real(wp) :: a(2), b(2), cut, cuts(size(second, 2) + 2), centre(2)
      integer :: i, j, k, m, next

      centre = centroid_of(first)
      sample_depth = depth_inside(second, centre)
      if (.not. contains_point(first, centre, 0.0_wp)) sample_depth = 0.0_wp
      do i = 1, size(first, 2)
         a = first(:, i)
         b = first(:, mod(i, size(first, 2)) + 1)
         cuts(1:2) = [0.0_wp, 1.0_wp]
         m = 2
         do j = 1, size(second, 2)
            next = merge(1, j + 1, j == size(second, 2))
            cut = crossing(a, b, second(:, j), second(:, next))
            if (cut <= 0.0_wp .or. cut >= 1.0_wp) cycle
            m = m + 1
            cuts(m) = cut
         end do
         cuts(:m) = cuts(ascending_order(cuts(:m)))
         sample_depth = max(sample_depth, depth_inside(second, a))
         do k = 1, m - 1
            sample_depth = max(sample_depth, &
               depth_inside(second, a + 0.5_wp*(cuts(k) + cuts(k + 1))*(b - a)))
         end do
      end do
   end function sample_depth

   !> Distance of an inner point to the boundary, m; 0 for other points.
   pure real(wp) function depth_inside(vertices, point)
      real(wp), intent(in) :: vertices(:,:)  !< [2, m] counter-clockwise, m
      real(wp), intent(in) :: point(2)       !< m

      depth_inside = 0.0_wp
      if (contains_point(vertices, point, 0.0_wp)) depth_inside = distance_to_boundary(vertices, &
         point)
   end function depth_inside

   !> Crossing of line a→b with edge c–d, as a fraction of a→b; −1 if there is none.
   pure real(wp) function crossing(a, b, c, d)
      real(wp), intent(in) :: a(2), b(2), c(2), d(2)  !< ends of the line and of the edge, m
      real(wp) :: determinant, on_edge

      crossing = -1.0_wp
      determinant = (b(1) - a(1))*(d(2) - c(2)) - (b(2) - a(2))*(d(1) - c(1))
      if (determinant == 0.0_wp) return
      on_edge = ((c(1) - a(1))*(b(2) - a(2)) - (c(2) - a(2))*(b(1) - a(1)))/determinant
      if (on_edge < 0.0_wp .or. on_edge > 1.0_wp) return
      crossing = ((c(1) - a(1))*(d(2) - c(2)) - (c(2) - a(2))*(d(1) - c(1)))/determinant
   end function crossing

end module dda_polygon
