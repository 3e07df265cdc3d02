! SPDX-License-Identifier: GPL-3.0-or-later
!> Gap and foot of a vertex at an edge, and selection of the entrance edge of two corners.
!>
!> Two corners have up to four (vertex, edge) choices.  Edges that can separate the two blocks are
!> entrance edges (Shi's first-entrance theory); the one with least penetration is used.
!>
!> A vertex that slides to the next block of equal height is below the corner of that block by its
!> penetration.  Its contact with that corner is glancing: the overlap hardly exceeds the
!> penetration.  A glancing contact cannot be an entrance, because the vertex would catch there.
module dda_entrance
   use dda_kinds, only: wp, pi
   use dda_blocks, only: blocks_type
   implicit none
   private
   public :: choice_type, corners_type, project_vertex, list_choices, is_glancing, entrance_edge, &
      other_end

   !> sine of the angle below which edges are parallel
   real(wp), parameter :: parallel_angle = 3.0_wp*pi/180.0_wp
   real(wp), parameter :: parallel_sine = sin(parallel_angle)
   real(wp), parameter :: same_direction = cos(2*parallel_angle)
   real(wp), parameter :: opposite = -cos(parallel_angle)
   !> largest difference of equal penetrations/corner size
   real(wp), parameter :: equal_depth = 1.0e-9_wp
   real(wp), parameter :: least_overlap = 1.0e-6_wp  !< smallest overlap/corner size

   !> A possible contact of a vertex with an edge of another block.
   type :: choice_type
      integer :: vertex, edge
      real(wp) :: normal(2)    !< outward normal of the edge
      real(wp) :: gap          !< signed distance to the edge, m
      real(wp) :: overshoot   !< distance of the foot beyond the end of the edge, m, ≤ 0 on the edge
      logical :: past_end      !< the vertex is nearer to the end than to the start of the edge
   end type choice_type

   !> The choices at corners v and w: vertex v on both edges at w, and vertex w on both edges at v.
   type :: corners_type
      integer :: vertex(4), edge(4)
      real(wp) :: along(2, 4)  !< unit vectors of the edges
      real(wp) :: gap(4), overshoot(4)
      !> least sine of the angles between the edge and the two edges at the vertex; negative if the
      !> edge cannot separate the blocks
      real(wp) :: separation(4)
      !> the contact is glancing; the edge ends at the other corner
      logical :: glancing(4)
   end type corners_type

contains

   !> Project a vertex on an edge of another block.
   pure subroutine project_vertex(blocks, vertex, edge, choice)
      type(blocks_type), intent(in) :: blocks   !< present geometry
      integer, intent(in) :: vertex, edge       !< vertex, and edge given by its first vertex
      type(choice_type), intent(out) :: choice  !< result
      real(wp) :: direction(2)

      call measure_foot(vertex, edge, blocks%vertex, blocks%along, blocks%length, direction, &
         choice%gap, choice%overshoot, choice%past_end)
      choice%vertex = vertex
      choice%edge = edge
      choice%normal = [direction(2), -direction(1)]
   end subroutine project_vertex

   !> Find gap and foot of vertex v at edge e, and the direction of the edge.
   !> The shapes of the arrays are explicit, because the compiler then needs no descriptors.
   pure subroutine measure_foot(v, e, vertex, along, length, direction, gap, overshoot, past_end)
      integer, intent(in) :: v, e               !< vertex, and edge given by its first vertex
      real(wp), intent(in) :: vertex(2, *), along(2, *), length(*)  !< see `blocks_type`
      real(wp), intent(out) :: direction(2)     !< unit vector of the edge
      real(wp), intent(out) :: gap, overshoot   !< m, see `choice_type`
      logical, intent(out) :: past_end          !< see `choice_type`
      real(wp) :: x, y, foot

      x = vertex(1, v) - vertex(1, e)
      y = vertex(2, v) - vertex(2, e)
      direction = along(:, e)
      foot = direction(1)*x + direction(2)*y
      gap = direction(2)*x - direction(1)*y
      overshoot = max(-foot, foot - length(e))
      past_end = foot > 0.5_wp*length(e)
   end subroutine measure_foot

   !> List the choices at corners v and w.
   pure subroutine list_choices(blocks, v, w, tolerance, travel, corners)
      type(blocks_type), intent(in) :: blocks      !< present geometry
      integer, intent(in) :: v, w                  !< vertices of two blocks
      real(wp), intent(in) :: tolerance, travel    !< m, see `is_glancing`
      type(corners_type), intent(out) :: corners   !< result
      logical, parameter :: at_end(4) = [.true., .false., .true., .false.]  !< corner at edge end
      logical :: past_end
      integer :: i

      corners%vertex = [v, v, w, w]
      corners%edge = [blocks%previous(w), w, blocks%previous(v), v]
      do i = 1, 4
         call measure_foot(corners%vertex(i), corners%edge(i), blocks%vertex, blocks%along, &
            blocks%length, corners%along(:, i), corners%gap(i), corners%overshoot(i), past_end)
         corners%glancing(i) = (past_end .eqv. at_end(i)) .and. &
            is_glancing(corners%gap(i), corners%overshoot(i), tolerance, travel)
      end do
      if (size(blocks%joined) == 0) then  ! without cells, all edges at a vertex belong to one block
         call set_separations(corners%along, corners%separation)
      else
         do i = 1, 4
            corners%separation(i) = separation(blocks, corners%vertex(i), corners%edge(i))
         end do
      end if
   end subroutine list_choices

   !> Set the separations of the choices from the sines of the angles between the edges.
   !> `sine(i, j)` belongs to the angle from edge i, at corner w, to edge j, at corner v.
   pure subroutine set_separations(along, separation)
      real(wp), intent(in) :: along(2, 4)        !< directions of the edges
      real(wp), intent(out) :: separation(4)     !< see `corners_type`
      real(wp) :: sine(2, 3:4)
      integer :: j

      do j = 3, 4
         sine(:, j) = along(1, 1:2)*along(2, j) - along(2, 1:2)*along(1, j)
      end do
      separation = [min(sine(1, 3), -sine(1, 4)), min(sine(2, 3), -sine(2, 4)), &
         min(-sine(1, 3), sine(2, 3)), min(-sine(1, 4), sine(2, 4))]
   end subroutine set_separations

   !> Return the least sine of the angles between an edge and another body's outline at a vertex.
   !> Several cells may meet at the vertex.  The result is −1 for an edge inside a body.
   pure real(wp) function separation(blocks, vertex, edge)
      type(blocks_type), intent(in) :: blocks  !< present geometry
      integer, intent(in) :: vertex, edge      !< vertex and edge of two blocks

      separation = -1.0_wp
      if (blocks%inner(edge)) return
      associate (along => blocks%along(:, edge), &
         before => blocks%along(:, blocks%outline(1, vertex)), &
         after => blocks%along(:, blocks%outline(2, vertex)))
         separation = min(along(1)*before(2) - along(2)*before(1), &
            along(2)*after(1) - along(1)*after(2))
      end associate
   end function separation

   !> .true. if a contact is glancing: its foot is at an end of the edge and it penetrates little.
   !> The vertex must be able to reach the edge in this step, and penetrate at most the tolerance.
   elemental logical function is_glancing(gap, overshoot, tolerance, travel)  ! total
      real(wp), intent(in) :: gap, overshoot   !< gap and overshoot of a vertex at an edge, m
      real(wp), intent(in) :: tolerance        !< depth of a glancing contact, m
      real(wp), intent(in) :: travel           !< largest approach in this step, m

      is_glancing = gap > -tolerance .and. gap <= travel + tolerance &
         .and. overshoot <= 0.0_wp .and. overshoot > -tolerance
   end function is_glancing

   !> Select the choice of least penetration among the choices that can separate the blocks.
   !> Of two parallel edges, the one that contains the foot is used.  If all choices are glancing,
   !> the edge along which the corners move is used.
   pure integer function entrance_edge(blocks, corners, size, tolerance) result(best)
      type(blocks_type), intent(in) :: blocks    !< present geometry and velocities
      type(corners_type), intent(in) :: corners  !< choices
      real(wp), intent(in) :: size               !< size of the corner, m
      real(wp), intent(in) :: tolerance          !< depth of a glancing contact, m
      real(wp) :: small
      integer :: i
      logical :: admissible(4)

      admissible = .not. corners%separation < -parallel_sine
      if (any(corners%glancing)) call exclude_choices(blocks, corners, tolerance, admissible)
      small = equal_depth*size
      best = 0
      do i = 1, 4
         if (.not. admissible(i)) cycle
         if (corners%overshoot(i) > small) then
            if (has_better_foot(corners, admissible, i, small)) cycle
         end if
         if (best == 0) best = i
         if (corners%gap(i) > corners%gap(best) + small) best = i
      end do
      if (best == 0) best = maxloc(corners%separation, 1)
   end function entrance_edge

   !> .true. if a parallel choice has a smaller overshoot than choice i.
   pure logical function has_better_foot(corners, admissible, i, small) result(found)
      type(corners_type), intent(in) :: corners  !< choices
      logical, intent(in) :: admissible(4)       !< choices to compare
      integer, intent(in) :: i                   !< a choice
      real(wp), intent(in) :: small              !< largest difference of equal overshoots, m
      integer :: j

      do j = 1, 4
         found = admissible(j) .and. corners%overshoot(j) < corners%overshoot(i) - small
         if (found) found = are_parallel(corners, i, j)
         if (found) return
      end do
   end function has_better_foot

   !> Find the choice at the other end of a short overlap of parallel edges; 0 if there is none.
   !> In longer overlaps, detection finds the contacts at both ends without this search.
   pure integer function other_end(blocks, corners, entrance, size, distance) result(other)
      type(blocks_type), intent(in) :: blocks    !< present geometry
      type(corners_type), intent(in) :: corners  !< choices
      integer, intent(in) :: entrance            !< the selected choice
      real(wp), intent(in) :: size               !< size of the corner, m
      real(wp), intent(in) :: distance           !< distance for listing contacts, m
      integer :: k

      do k = merge(3, 1, entrance <= 2), merge(4, 2, entrance <= 2)
         other = k
         if (any(corners%overshoot([entrance, k]) > -least_overlap*size)) cycle
         if (blocks%inner(corners%edge(k)) .or. corners%gap(k) > distance) cycle
         if (dot_product(corners%along(:, entrance), corners%along(:, k)) < opposite) return
      end do
      other = 0
   end function other_end

   !> Exclude the glancing choices that cannot be the entrance.
   !> If a choice is neither glancing nor deeper than the tolerance, glancing choices of other
   !> directions are excluded.  Otherwise glancing choices that are approached faster are excluded.
   pure subroutine exclude_choices(blocks, corners, tolerance, admissible)
      type(blocks_type), intent(in) :: blocks    !< present geometry and velocities
      type(corners_type), intent(in) :: corners  !< choices
      real(wp), intent(in) :: tolerance          !< depth of a glancing contact, m
      logical, intent(inout) :: admissible(4)    !< choices that can separate the blocks
      logical :: regular(4)
      integer :: i, j

      regular = admissible .and. corners%gap >= -tolerance .and. .not. corners%glancing
      if (.not. any(regular)) then
         call exclude_faster(blocks, corners, admissible)
         return
      end if
      do i = 1, 4
         if (.not. corners%glancing(i)) cycle
         do j = 1, 4
            if (.not. regular(j)) cycle
            if (.not. are_parallel(corners, i, j)) admissible(i) = .false.
            if (.not. admissible(i)) exit
         end do
      end do
   end subroutine exclude_choices

   !> Exclude the glancing choices that do not have the direction of slowest approach.
   pure subroutine exclude_faster(blocks, corners, admissible)
      type(blocks_type), intent(in) :: blocks    !< present geometry and velocities
      type(corners_type), intent(in) :: corners  !< choices
      logical, intent(inout) :: admissible(4)    !< choices that can separate the blocks
      real(wp) :: speed(4)
      integer :: i, slowest

      speed = huge(1.0_wp)
      do i = 1, 4
         if (admissible(i) .and. corners%glancing(i)) speed(i) = -dot_product( &
            [corners%along(2, i), -corners%along(1, i)], &
            velocity_at(blocks, corners%vertex(i), corners%vertex(i)) - velocity_at(blocks, &
            corners%edge(i), corners%vertex(i)))
      end do
      slowest = minloc(speed, 1)
      do i = 1, 4
         if (.not. corners%glancing(i)) cycle
         if (.not. are_parallel(corners, slowest, i)) admissible(i) = .false.
      end do
   end subroutine exclude_faster

   !> Velocity, m/s, of the block with vertex `own_vertex` at the position of another vertex.
   pure function velocity_at(blocks, own_vertex, vertex) result(velocity)
      type(blocks_type), intent(in) :: blocks  !< present geometry and velocities
      integer, intent(in) :: own_vertex, vertex  !< vertex of the block; vertex at the position
      real(wp) :: velocity(2)

      associate (rate => blocks%velocity(:, blocks%owner(own_vertex)), &
         arm => blocks%vertex(:, vertex) - blocks%position(1:2, blocks%owner(own_vertex)))
         velocity = rate(1:2) + rate(3)*[-arm(2), arm(1)]
      end associate
   end function velocity_at

   !> .true. if the normals of choices i and j push the two blocks apart in the same direction.
   pure logical function are_parallel(corners, i, j)
      type(corners_type), intent(in) :: corners  !< choices
      integer, intent(in) :: i, j                !< two choices
      real(wp) :: cosine

      cosine = dot_product(corners%along(:, i), corners%along(:, j))
      if ((i <= 2) .neqv. (j <= 2)) cosine = -cosine
      are_parallel = cosine > same_direction
   end function are_parallel

end module dda_entrance
