! SPDX-License-Identifier: GPL-3.0-or-later
!> Overlap of two edges that lie along each other, and the contacts that share it.
!>
!> A joint with two contact points has a contact at each end of an overlap, each with half of its
!> length.  With 3, 5, 9 or 17 points, Lobatto's rule sets the positions and weights.  The rule
!> is exact for a stress that is linear along the overlap, so the bending stiffness is exact.
module dda_overlap
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type, is_convex
   implicit none
   private
   public :: overlap_type, overlap_of, has_points, node, weight, narrow, wide

   real(wp), parameter :: touching = 1.0e-6_wp  !< largest gap of touching edges/edge length
   real(wp), parameter :: narrow = 0.0523_wp    !< sine of 3°
   real(wp), parameter :: wide = 0.2588_wp      !< sine of 15°
   !> overlaps below this fraction of the shorter edge have no points between corners
   real(wp), parameter :: least = 0.05_wp
   !> Lobatto rules of 9 and 17 points: positions in −1 … 1 and weights, from the end to the middle
   real(wp), parameter :: nodes_9(5) = [1.0_wp, 0.899757995411460157_wp, 0.677186279510737753_wp, &
      0.363117463826178159_wp, 0.0_wp], weights_9(5) = [0.013888888888888889_wp, &
      0.082747680780402763_wp, 0.137269356250080868_wp, 0.173214255486523173_wp, &
      0.185759637188208617_wp], nodes_17(9) = [1.0_wp, 0.973132176631418314_wp, &
      0.910879995915573596_wp, 0.815696251221770307_wp, 0.691028980627684705_wp, &
      0.541385399330101539_wp, 0.372174433565477042_wp, 0.189511973518317388_wp, 0.0_wp], &
      weights_17(9) = [0.003676470588235294_wp, 0.022460970271627105_wp, 0.03959913525184356_wp, &
      0.055296454503514081_wp, 0.06899387310096328_wp, 0.08019733099881077_wp, &
      0.088502126757828935_wp, 0.093608169838809618_wp, 0.095330937376734717_wp]

   !> Overlap of edge f with edge e, which run in opposite directions.
   type :: overlap_type
      real(wp) :: length = 0.0_wp   !< length, m; 0: the edges do not overlap
      !> fractions of f at the start and at the end of the overlap
      real(wp) :: from = 0.0_wp, to = 0.0_wp
      !> the overlap ends at a corner
      logical :: corner_from = .false., corner_to = .false.
   end type overlap_type

contains

   !> Find the overlap of edges f and e, given by their first vertices.
   pure type(overlap_type) function overlap_of(blocks, e, f, sine) result(overlap)
      type(blocks_type), intent(in) :: blocks  !< present geometry
      integer, intent(in) :: e, f              !< edges
      real(wp), intent(in) :: sine             !< sine of the largest angle between the edges
      real(wp) :: start(2), along(2), other(2), length, first, last, small

      start = blocks%vertex(:, e)
      along = edge_vector(blocks, e)
      length = norm2(along)
      along = along/length
      other = edge_vector(blocks, f)
      if (abs(along(1)*other(2) - along(2)*other(1)) > sine*norm2(other)) return
      first = dot_product(along, blocks%vertex(:, f) - start)
      last = dot_product(along, blocks%vertex(:, blocks%next(f)) - start)
      overlap%length = max(0.0_wp, min(length, max(first, last)) - max(0.0_wp, min(first, last)))
      small = touching*length
      overlap%corner_to = (last >= -small .and. is_convex(blocks, blocks%next(f))) &
         .or. (last <= small .and. is_convex(blocks, e))
      overlap%corner_from = (first <= length + small .and. is_convex(blocks, f)) &
         .or. (first >= length - small .and. is_convex(blocks, blocks%next(e)))
      if (.not. first > last) return
      overlap%from = max(0.0_wp, first - length)/(first - last)
      overlap%to = min(1.0_wp, first/(first - last))
   end function overlap_of

   !> .true. if the overlap is long enough for points between its corners.
   pure logical function has_points(blocks, e, f, overlap)
      type(blocks_type), intent(in) :: blocks      !< present geometry
      integer, intent(in) :: e, f                  !< edges
      type(overlap_type), intent(in) :: overlap    !< overlap of the edges

      has_points = overlap%to > overlap%from .and. &
         overlap%length > least*min(blocks%length(e), blocks%length(f))
   end function has_points

   !> Return the position of point i of n in an overlap, 0 … 1.
   pure real(wp) function node(n, i)
      integer, intent(in) :: n  !< number of points: 2, 3, 5, 9 or 17
      integer, intent(in) :: i  !< number of the point, 1 … n
      real(wp) :: half

      half = 1.0_wp
      if (n == 5) half = merge(1.0_wp, sqrt(3.0_wp/7.0_wp), i == 1 .or. i == 5)
      if (n == 9) half = nodes_9(min(i, n + 1 - i))
      if (n == 17) half = nodes_17(min(i, n + 1 - i))
      if (2*i == n + 1) half = 0.0_wp
      node = 0.5_wp + sign(0.5_wp*half, real(2*i - n - 1, wp))
   end function node

   !> Return the weight of point i of n in an overlap.
   pure real(wp) function weight(n, i)
      integer, intent(in) :: n  !< number of points: 2, 3, 5, 9 or 17
      integer, intent(in) :: i  !< number of the point, 1 … n

      select case (n)
      case (3)
         weight = merge(2.0_wp/3.0_wp, 1.0_wp/6.0_wp, i == 2)
      case (5)
         weight = 49.0_wp/180.0_wp
         if (i == 3) weight = 16.0_wp/45.0_wp
         if (i == 1 .or. i == 5) weight = 0.05_wp
      case (9)
         weight = weights_9(min(i, n + 1 - i))
      case (17)
         weight = weights_17(min(i, n + 1 - i))
      case default
         weight = 0.5_wp
      end select
   end function weight

   !> Return the vector from the first to the last vertex of edge e, m.
   pure function edge_vector(blocks, e) result(vector)
      type(blocks_type), intent(in) :: blocks  !< present geometry
      integer, intent(in) :: e                 !< edge, given by its first vertex
      real(wp) :: vector(2)

      vector = blocks%vertex(:, blocks%next(e)) - blocks%vertex(:, e)
   end function edge_vector

end module dda_overlap
