! SPDX-License-Identifier: GPL-3.0-or-later
!> A vertex against an edge, and which of the edges at two corners is the entrance.
!>
!> Of the up to four (vertex, edge) choices at two corners, those whose edge can separate the two
!> blocks are entrance edges (Shi's first-entrance theory), and the one of least penetration acts.
!>
!> A vertex that is pressed into one block and slides on to the next one of the same height stands a
!> little lower than that one's corner.  It must not catch on its side: an edge that is hit by
!> little more than that depth is a glancing contact, and is not an entrance.
module dda_entrance
   use dda_kinds, only: wp, pi
   use dda_blocks, only: blocks_type
   implicit none
   private
   public :: choice_type, project, list_choices, is_glancing, entrance_edge

   !> edges nearer than this are parallel
   real(wp), parameter :: parallel_angle = 3.0_wp*pi/180.0_wp
   real(wp), parameter :: parallel_sine = sin(parallel_angle)
   real(wp), parameter :: same_direction = cos(2*parallel_angle)
   real(wp), parameter :: tie = 1.0e-9_wp         !< of the corner size: no difference

   !> One (vertex, edge) choice.
   type :: choice_type
      integer :: vertex, edge
      real(wp) :: normal(2)    !< outward normal of the edge
      real(wp) :: gap          !< m
      logical :: past_end      !< it is nearer to the edge's end than to its start
      real(wp) :: overshoot    !< how far the foot lies beyond the edge, m, ≤ 0 on it
      real(wp) :: separation   !< least sine of the angle between the edge and the vertex' own edges
   end type choice_type

contains

   !> Project a vertex on an edge of another block.
   pure subroutine project(blocks, vertex, edge, choice)
      type(blocks_type), intent(in) :: blocks   !< present geometry
      integer, intent(in) :: vertex, edge       !< an edge is named by its first vertex
      type(choice_type), intent(out) :: choice  !< its `separation` is not computed
      real(wp) :: along(2), from(2), length, foot

      along = blocks%along(:, edge)
      length = blocks%length(edge)
      from = blocks%vertex(:, vertex) - blocks%vertex(:, edge)
      foot = dot_product(along, from)
      choice%vertex = vertex
      choice%edge = edge
      choice%normal = [along(2), -along(1)]
      choice%gap = dot_product(choice%normal, from)
      choice%overshoot = max(-foot, foot - length)
      choice%past_end = foot > 0.5_wp*length
      choice%separation = 0.0_wp
   end subroutine project

   !> The up to four choices at corners v and w: v on the edges before and after w, w on those
   !> before and after v.
   pure subroutine list_choices(blocks, v, w, tolerance, travel, choice, glancing)
      type(blocks_type), intent(in) :: blocks      !< present geometry
      integer, intent(in) :: v, w                  !< vertices of two blocks
      real(wp), intent(in) :: tolerance, travel    !< m, see `is_glancing`
      type(choice_type), intent(out) :: choice(4)  !< in that order
      !> at the corner that is met, not at the other end of the edge
      logical, intent(out) :: glancing(4)

      call project_corner(blocks, v, blocks%previous(w), choice(1))
      call project_corner(blocks, v, w, choice(2))
      call project_corner(blocks, w, blocks%previous(v), choice(3))
      call project_corner(blocks, w, v, choice(4))
      glancing = is_glancing(choice, tolerance, travel) .and. (choice%past_end .eqv. &
         [.true., .false., .true., .false.])
   end subroutine list_choices

   !> As `project`, with how well the edge separates the vertex' own block from it.
   pure subroutine project_corner(blocks, vertex, edge, choice)
      type(blocks_type), intent(in) :: blocks   !< present geometry
      integer, intent(in) :: vertex, edge       !< an edge is named by its first vertex
      type(choice_type), intent(out) :: choice  !< complete

      call project(blocks, vertex, edge, choice)
      choice%separation = &
         min(-dot_product(choice%normal, blocks%along(:, blocks%previous(vertex))), &
         dot_product(choice%normal, blocks%along(:, vertex)))
   end subroutine project_corner

   !> The vertex is outside or within the tolerance, can reach the edge in this step, and its foot
   !> lies on the edge within the tolerance of an end.
   elemental logical function is_glancing(choice, tolerance, travel)
      type(choice_type), intent(in) :: choice  !< vertex projected on an edge
      real(wp), intent(in) :: tolerance        !< m, depth of a glancing contact
      real(wp), intent(in) :: travel           !< m, farthest approach in this step

      is_glancing = choice%gap > -tolerance .and. choice%gap <= travel + tolerance &
         .and. choice%overshoot <= 0.0_wp .and. choice%overshoot > -tolerance
   end function is_glancing

   !> Which choice is the entrance: of those that can separate the blocks, that of least
   !> penetration; of parallel edges, the one that holds the foot.  A glancing one only if there is
   !> no other; if all are, the one along which the corners move.
   pure integer function entrance_edge(blocks, choice, corner, tolerance, glancing) result(best)
      type(blocks_type), intent(in) :: blocks    !< present geometry and velocities
      type(choice_type), intent(in) :: choice(4) !< at two corners, see `list_choices`
      real(wp), intent(in) :: corner             !< m, size of the corner
      real(wp), intent(in) :: tolerance          !< m, depth of a glancing contact
      logical, intent(in) :: glancing(4)         !< choices that are glancing contacts
      real(wp) :: small
      integer :: i
      logical :: admissible(4)

      admissible = .not. choice%separation < -parallel_sine
      if (any(glancing)) admissible = admissible &
         .and. .not. excluded(blocks, choice, tolerance, glancing)
      small = tie*corner
      best = 0
      do i = 1, 4
         if (.not. admissible(i)) cycle
         if (choice(i)%overshoot > small) then
            if (superseded(choice, admissible, i, small)) cycle
         end if
         if (best == 0) best = i
         if (choice(i)%gap > choice(best)%gap + small) best = i
      end do
      if (best == 0) best = maxloc(choice%separation, 1)
   end function entrance_edge

   !> The foot on the edge of choice i is farther off than that on a parallel edge.
   pure logical function superseded(choice, admissible, i, small)
      type(choice_type), intent(in) :: choice(4)  !< at two corners
      logical, intent(in) :: admissible(4)        !< choices that may be the entrance
      integer, intent(in) :: i                    !< one of them
      real(wp), intent(in) :: small               !< m, no difference
      integer :: j

      superseded = .false.
      do j = 1, 4
         if (.not. admissible(j) .or. .not. choice(j)%overshoot < choice(i)%overshoot - small) cycle
         superseded = superseded .or. parallel(choice, i, j)
      end do
   end function superseded

   !> Glancing choices for which another one of a different direction is neither glancing nor deep;
   !> where there is none, the glancing ones along which the corners do not move.
   pure function excluded(blocks, choice, tolerance, glancing)
      type(blocks_type), intent(in) :: blocks     !< present geometry and velocities
      type(choice_type), intent(in) :: choice(4)  !< at two corners
      real(wp), intent(in) :: tolerance           !< m, depth of a glancing contact
      logical, intent(in) :: glancing(4)          !< choices that are glancing contacts
      logical :: excluded(4), regular(4)
      integer :: i, j

      regular = choice%separation >= -parallel_sine .and. choice%gap >= -tolerance &
         .and. .not. glancing
      if (.not. any(regular)) then
         excluded = approached_faster(blocks, choice, &
            glancing .and. choice%separation >= -parallel_sine)
         return
      end if
      excluded = .false.
      do i = 1, 4
         do j = 1, 4
            if (regular(j) .and. .not. parallel(choice, i, j)) excluded(i) = glancing(i)
         end do
      end do
   end function excluded

   !> Of the admissible choices, those of another direction than the one approached least fast.
   pure function approached_faster(blocks, choice, admissible) result(faster)
      type(blocks_type), intent(in) :: blocks     !< present geometry and velocities
      type(choice_type), intent(in) :: choice(4)  !< at two corners
      logical, intent(in) :: admissible(4)        !< choices to compare
      logical :: faster(4)
      real(wp) :: speed(4)
      integer :: i

      speed = huge(1.0_wp)
      do i = 1, 4
         if (admissible(i)) speed(i) = -dot_product(choice(i)%normal, &
            velocity_at(blocks, choice(i)%vertex, choice(i)%vertex) - velocity_at(blocks, &
            choice(i)%edge, choice(i)%vertex))
      end do
      do i = 1, 4
         faster(i) = admissible(i) .and. .not. parallel(choice, i, minloc(speed, 1))
      end do
   end function approached_faster

   !> Velocity, m/s, of the block that owns vertex `own` at the place of another vertex.
   pure function velocity_at(blocks, own, vertex) result(velocity)
      type(blocks_type), intent(in) :: blocks  !< present geometry and velocities
      integer, intent(in) :: own, vertex       !< a vertex of the block; where its velocity is taken
      real(wp) :: velocity(2)

      associate (rate => blocks%velocity(:, blocks%owner(own)), &
         arm => blocks%vertex(:, vertex) - blocks%position(1:2, blocks%owner(own)))
         velocity = rate(1:2) + rate(3)*[-arm(2), arm(1)]
      end associate
   end function velocity_at

   !> The normals of choices i and j push the two blocks apart in the same direction.
   pure logical function parallel(choice, i, j)
      type(choice_type), intent(in) :: choice(4)  !< 1, 2: vertex of the first block; 3, 4: second
      integer, intent(in) :: i, j                 !< two of them

      parallel = dot_product(choice(i)%normal, choice(j)%normal)*merge(1, -1, &
         (i <= 2) .eqv. (j <= 2)) > same_direction
   end function parallel

end module dda_entrance
