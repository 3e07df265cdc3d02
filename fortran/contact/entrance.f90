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
      real(wp) :: normal(4, 2)
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
      real(wp) :: along(2), from(2)

      along = blocks%along(:, edge)
      from = blocks%vertex(:, vertex) - blocks%vertex(:, edge)
      choice%vertex = vertex
      choice%edge = edge
      choice%normal = [along(2), -along(1)]
      call measure_foot(along(1), along(2), from(1), from(2), blocks%length(edge), choice%gap, &
         choice%overshoot, choice%past_end)
   end subroutine project_vertex

   !> Find gap and foot of a vertex, from its position relative to the start of an edge.
   elemental subroutine measure_foot(along_x, along_y, x, y, length, gap, overshoot, past_end)
      real(wp), intent(in) :: along_x, along_y  !< unit vector of the edge
      real(wp), intent(in) :: x, y              !< position of the vertex, m
      real(wp), intent(in) :: length            !< length of the edge, m
      real(wp), intent(out) :: gap, overshoot   !< m, see `choice_type`
      logical, intent(out) :: past_end          !< see `choice_type`
      real(wp) :: foot

      foot = along_x*x + along_y*y
      gap = along_y*x - along_x*y
      overshoot = max(-foot, foot - length)
      past_end = foot > 0.5_wp*length
   end subroutine measure_foot

   !> List the choices at corners v and w.
   pure subroutine list_choices(blocks, v, w, tolerance, travel, corners)
      type(blocks_type), intent(in) :: blocks      !< present geometry
      integer, intent(in) :: v, w                  !< vertices of two blocks
      real(wp), intent(in) :: tolerance, travel    !< m, see `is_glancing`
      type(corners_type), intent(out) :: corners   !< result
      integer, parameter :: before(4) = [3, 3, 1, 1], after(4) = [4, 4, 2, 2]  !< edges at vertex
      logical, parameter :: at_end(4) = [.true., .false., .true., .false.]  !< corner at edge end
      real(wp) :: along(4, 2), from(4, 2), length(4)
      logical :: past_end(4)
      integer :: i

      corners%vertex = [v, v, w, w]
      corners%edge = [blocks%previous(w), w, blocks%previous(v), v]
      do i = 1, 4
         along(i, :) = blocks%along(:, corners%edge(i))
         from(i, :) = blocks%vertex(:, corners%vertex(i)) - blocks%vertex(:, corners%edge(i))
         length(i) = blocks%length(corners%edge(i))
      end do
      call measure_foot(along(:, 1), along(:, 2), from(:, 1), from(:, 2), length, corners%gap, &
         corners%overshoot, past_end)
      corners%normal(:, 1) = along(:, 2)
      corners%normal(:, 2) = -along(:, 1)
      if (size(blocks%joined) == 0) then  ! without cells, all edges at a vertex belong to one block
         corners%separation = min( &
            along(:, 1)*along(before, 2) - along(:, 2)*along(before, 1), &
            along(:, 2)*along(after, 1) - along(:, 1)*along(after, 2))
      else
         do i = 1, 4
            corners%separation(i) = separation(blocks, corners%vertex(i), corners%edge(i))
         end do
      end if
      corners%glancing = is_glancing(corners%gap, corners%overshoot, tolerance, travel) &
         .and. (past_end .eqv. at_end)
   end subroutine list_choices

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
      if (any(corners%glancing)) admissible = admissible &
         .and. .not. excluded_choices(blocks, corners, tolerance)
      small = equal_depth*size
      best = 0
      do i = 1, 4
         if (.not. admissible(i)) cycle
         if (corners%overshoot(i) > small) then  ! a parallel choice may have a smaller overshoot
            if (any(admissible .and. corners%overshoot < corners%overshoot(i) - small .and. &
               parallel_choices(corners, i))) cycle
         end if
         if (best == 0) best = i
         if (corners%gap(i) > corners%gap(best) + small) best = i
      end do
      if (best == 0) best = maxloc(corners%separation, 1)
   end function entrance_edge

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
         if (dot_product(corners%normal(entrance, :), corners%normal(k, :)) < opposite) return
      end do
      other = 0
   end function other_end

   !> Mark the glancing choices that cannot be the entrance.
   !> If a choice is neither glancing nor deeper than the tolerance, glancing choices of other
   !> directions are excluded.  Otherwise glancing choices that are approached faster are excluded.
   pure function excluded_choices(blocks, corners, tolerance)  ! total
      type(blocks_type), intent(in) :: blocks    !< present geometry and velocities
      type(corners_type), intent(in) :: corners  !< choices
      real(wp), intent(in) :: tolerance          !< depth of a glancing contact, m
      logical :: excluded_choices(4), regular(4)
      integer :: i

      regular = corners%separation >= -parallel_sine .and. corners%gap >= -tolerance &
         .and. .not. corners%glancing
      if (.not. any(regular)) then
         excluded_choices = faster_choices(blocks, corners, &
            corners%glancing .and. corners%separation >= -parallel_sine)
         return
      end if
      excluded_choices = corners%glancing
      do i = 1, 4
         if (corners%glancing(i)) excluded_choices(i) = any(regular .and. .not. &
            parallel_choices(corners, i))
      end do
   end function excluded_choices

   !> Mark the admissible choices that do not have the direction of slowest approach.
   pure function faster_choices(blocks, corners, admissible) result(faster)
      type(blocks_type), intent(in) :: blocks    !< present geometry and velocities
      type(corners_type), intent(in) :: corners  !< choices
      logical, intent(in) :: admissible(4)       !< choices to compare
      logical :: faster(4)
      real(wp) :: speed(4)
      integer :: i

      speed = huge(1.0_wp)
      do i = 1, 4
         if (admissible(i)) speed(i) = -dot_product(corners%normal(i, :), &
            velocity_at(blocks, corners%vertex(i), corners%vertex(i)) - velocity_at(blocks, &
            corners%edge(i), corners%vertex(i)))
      end do
      faster = admissible .and. .not. parallel_choices(corners, minloc(speed, 1))
   end function faster_choices

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

   !> Mark the choices whose normals push the two blocks apart in the same direction as choice i.
   pure function parallel_choices(corners, i) result(parallel)  ! total
      type(corners_type), intent(in) :: corners  !< choices
      integer, intent(in) :: i                   !< a choice
      logical :: parallel(4)
      integer :: j

      do j = 1, 4
         parallel(j) = dot_product(corners%normal(i, :), corners%normal(j, :))*merge(1, -1, &
            (i <= 2) .eqv. (j <= 2)) > same_direction
      end do
   end function parallel_choices

end module dda_entrance
