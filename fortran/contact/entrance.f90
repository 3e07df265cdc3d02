!> One vertex against one edge, and which of the edges at two corners is the entrance.
!>
!> Of the up to four (vertex, edge) choices at two corners, those whose edge can separate the two
!> blocks are entrance edges (Shi's first-entrance theory), and the one of least penetration acts.
!>
!> A vertex that presses on one block and comes to the next one of the same height is a little lower
!> than that one's corner.  It must not run into its side: what would be hit by little more than
!> that depth is grazed, and passed over.
module dda_entrance
   use dda_kinds, only: wp, pi
   use dda_blocks, only: blocks_type
   implicit none
   private
   public :: choice_type, examine, list_choices, grazes, entrance

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

   !> A vertex against one edge of another block.
   pure subroutine examine(blocks, vertex, edge, choice)
      type(blocks_type), intent(in) :: blocks
      integer, intent(in) :: vertex, edge
      type(choice_type), intent(out) :: choice
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
   end subroutine examine

   !> The up to four choices at corners v and w: v on the edges before and after w, w on those
   !> before and after v.
   pure subroutine list_choices(blocks, v, w, skin, travel, choice, grazed)
      type(blocks_type), intent(in) :: blocks
      integer, intent(in) :: v, w
      real(wp), intent(in) :: skin, travel
      type(choice_type), intent(out) :: choice(4)
      !> at the corner that is met, not at the other end of the edge
      logical, intent(out) :: grazed(4)

      call examine_corner(blocks, v, blocks%previous(w), choice(1))
      call examine_corner(blocks, v, w, choice(2))
      call examine_corner(blocks, w, blocks%previous(v), choice(3))
      call examine_corner(blocks, w, v, choice(4))
      grazed = grazes(choice, skin, travel) .and. (choice%past_end .eqv. [.true., .false., .true., &
         .false.])
   end subroutine list_choices

   !> As `examine`, with how well the edge separates the vertex' own block from it.
   pure subroutine examine_corner(blocks, vertex, edge, choice)
      type(blocks_type), intent(in) :: blocks
      integer, intent(in) :: vertex, edge
      type(choice_type), intent(out) :: choice

      call examine(blocks, vertex, edge, choice)
      choice%separation = &
         min(-dot_product(choice%normal, blocks%along(:, blocks%previous(vertex))), &
         dot_product(choice%normal, blocks%along(:, vertex)))
   end subroutine examine_corner

   !> The vertex is still outside, within the skin, and its foot is on the edge, but hardly.
   elemental logical function grazes(choice, skin, travel)
      type(choice_type), intent(in) :: choice
      real(wp), intent(in) :: skin, travel

      grazes = choice%gap > -skin .and. choice%gap <= travel + skin &
         .and. choice%overshoot <= 0.0_wp .and. choice%overshoot > -skin
   end function grazes

   !> The entrance edge of least penetration; of parallel ones, that which holds the foot.  One that
   !> is grazed only if there is no other; where all are, the one along which the corners move.
   pure integer function entrance(blocks, choice, corner, skin, grazed) result(best)
      type(blocks_type), intent(in) :: blocks
      type(choice_type), intent(in) :: choice(4)
      real(wp), intent(in) :: corner      !< size of the corner, m
      real(wp), intent(in) :: skin        !< depth that is passed over, m
      logical, intent(in) :: grazed(4)
      real(wp) :: small
      integer :: i
      logical :: at_hand(4)

      at_hand = .not. choice%separation < -parallel_sine
      if (any(grazed)) at_hand = at_hand .and. .not. passed_over(blocks, choice, skin, grazed)
      small = tie*corner
      best = 0
      do i = 1, 4
         if (.not. at_hand(i)) cycle
         if (choice(i)%overshoot > small) then
            if (displaced(choice, at_hand, i, small)) cycle
         end if
         if (best == 0) best = i
         if (choice(i)%gap > choice(best)%gap + small) best = i
      end do
      if (best == 0) best = maxloc(choice%separation, 1)
   end function entrance

   !> The foot on the edge of choice i is farther off than that on a parallel edge.
   pure logical function displaced(choice, at_hand, i, small)
      type(choice_type), intent(in) :: choice(4)
      logical, intent(in) :: at_hand(4)
      integer, intent(in) :: i
      real(wp), intent(in) :: small
      integer :: j

      displaced = .false.
      do j = 1, 4
         if (.not. at_hand(j) .or. .not. choice(j)%overshoot < choice(i)%overshoot - small) cycle
         displaced = displaced .or. parallel(choice, i, j)
      end do
   end function displaced

   !> Choices that are grazed where another one, which pushes another way, is neither that nor deep
   !> in; where there is none, those of the grazed ones along which the corners do not move.
   pure function passed_over(blocks, choice, skin, grazed) result(passed)
      type(blocks_type), intent(in) :: blocks
      type(choice_type), intent(in) :: choice(4)
      real(wp), intent(in) :: skin
      logical, intent(in) :: grazed(4)
      logical :: passed(4), good(4)
      integer :: i, j

      good = choice%separation >= -parallel_sine .and. choice%gap >= -skin .and. .not. grazed
      if (.not. any(good)) then
         passed = approached(blocks, choice, grazed .and. choice%separation >= -parallel_sine)
         return
      end if
      passed = .false.
      do i = 1, 4
         do j = 1, 4
            if (good(j) .and. .not. parallel(choice, i, j)) passed(i) = grazed(i)
         end do
      end do
   end function passed_over

   !> Of the choices at hand, another one, which pushes another way, is approached less fast.
   pure function approached(blocks, choice, at_hand) result(faster)
      type(blocks_type), intent(in) :: blocks
      type(choice_type), intent(in) :: choice(4)
      logical, intent(in) :: at_hand(4)
      logical :: faster(4)
      real(wp) :: speed(4)
      integer :: i

      speed = huge(1.0_wp)
      do i = 1, 4
         if (at_hand(i)) speed(i) = -dot_product(choice(i)%normal, &
            velocity_at(blocks, choice(i)%vertex, choice(i)%vertex) - velocity_at(blocks, &
            choice(i)%edge, choice(i)%vertex))
      end do
      do i = 1, 4
         faster(i) = at_hand(i) .and. .not. parallel(choice, i, minloc(speed, 1))
      end do
   end function approached

   !> Velocity, m/s, of the block that owns vertex `own` at the place of a vertex.
   pure function velocity_at(blocks, own, vertex) result(velocity)
      type(blocks_type), intent(in) :: blocks
      integer, intent(in) :: own, vertex
      real(wp) :: velocity(2)

      associate (rate => blocks%velocity(:, blocks%owner(own)), &
         arm => blocks%vertex(:, vertex) - blocks%position(1:2, blocks%owner(own)))
         velocity = rate(1:2) + rate(3)*[-arm(2), arm(1)]
      end associate
   end function velocity_at

   !> Choices i and j push the two blocks apart in the same direction.
   pure logical function parallel(choice, i, j)
      type(choice_type), intent(in) :: choice(4)
      integer, intent(in) :: i, j

      parallel = dot_product(choice(i)%normal, choice(j)%normal)*merge(1, -1, &
         (i <= 2) .eqv. (j <= 2)) > same_direction
   end function parallel

end module dda_entrance
