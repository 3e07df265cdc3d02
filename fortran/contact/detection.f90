!> Which vertex meets which edge now, from the probes of the last search.
!>
!> Vertex to edge: the foot of the vertex lies on the edge.  Vertex to vertex: of the up to four
!> (vertex, edge) choices at two corners, those whose edge can separate the two blocks are entrance
!> edges (Shi's first-entrance theory), and the one of least penetration acts.  Corners of parallel
!> edges give one contact, on the edge that holds the foot: so blocks of equal width stacked on each
!> other get two contacts per joint, one at each end.
!>
!> A vertex that presses on one block and comes to the next one of the same height is a little lower than
!> that one's corner.  It must not run into its side: what would be hit by less than the depth that contacts
!> have now is passed over.
module dda_detection
   use dda_kinds, only: wp, pi
   use dda_blocks, only: blocks_type
   use dda_neighbours, only: neighbours_type
   use dda_contact, only: contacts_type, reserve
   use dda_ordered_sums, only: pieces, first_of, last_of, parallel_from
   implicit none
   private
   public :: detection_type, prepare_detection, detect_contacts

   real(wp), parameter :: parallel_angle = 3.0_wp*pi/180.0_wp  !< edges nearer than this are parallel
   real(wp), parameter :: parallel_sine = sin(parallel_angle)
   real(wp), parameter :: same_direction = cos(2*parallel_angle)
   real(wp), parameter :: corner_share = 0.05_wp  !< of the shorter edge: size of a corner
   real(wp), parameter :: tie = 1.0e-9_wp         !< of the corner size: no difference

   !> A contact that was found.
   type :: find_type
      integer :: vertex, edge
      integer :: corner        !< vertex met corner to corner, else 0
      integer :: pair          !< which near pair the two blocks are
   end type find_type

   !> Distances that steer the detection, and room for what it finds.
   type :: detection_type
      real(wp) :: least = 0.0_wp         !< least distance at which a contact is listed, m
      real(wp) :: distance = 0.0_wp      !< distance in this step, m
      real(wp) :: travel = 0.0_wp        !< farthest that two vertices may approach each other in this step, m
      real(wp) :: skin = 0.0_wp          !< depth of what is passed over, m
      real(wp) :: largest_corner = 0.0_wp !< m
      real(wp), allocatable :: corner(:) !< [vertices] size of the corner at each vertex, m
      type(find_type), allocatable :: find(:) !< [edges of the probes] a probe finds no more than it has edges
      integer, allocatable :: finds(:)   !< [pieces of the probes] found in each
   end type detection_type

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

   !> Sizes of corners: a share of the shorter edge at each vertex, at most the contact distance.
   subroutine prepare_detection(detection, blocks, distance)
      type(detection_type), intent(out) :: detection
      type(blocks_type), intent(in) :: blocks
      real(wp), intent(in) :: distance
      real(wp) :: here(2)
      integer :: v

      detection%least = distance
      detection%distance = distance
      allocate (detection%corner(size(blocks%owner)))
      do v = 1, size(detection%corner)
         here = blocks%reference(:, v)
         detection%corner(v) = min(distance, corner_share*min(norm2(blocks%reference(:, blocks%next(v)) - here), &
            norm2(blocks%reference(:, blocks%previous(v)) - here)))
      end do
      detection%largest_corner = maxval(detection%corner)
   end subroutine prepare_detection

   !> List all contacts nearer than the distance of this step, with geometry; history is left blank.
   !>
   !> Pieces of the probes are looked through in any order; what they find is listed in the order of the probes.
   subroutine detect_contacts(contacts, blocks, neighbours, detection)
      type(contacts_type), intent(inout) :: contacts
      type(blocks_type), intent(in) :: blocks
      type(neighbours_type), intent(in) :: neighbours
      type(detection_type), intent(inout) :: detection
      integer :: i

      call make_room(detection, neighbours)
      if (neighbours%n_probes < parallel_from) then
         do i = 1, size(detection%finds)
            call look_through(detection, blocks, neighbours, i)
         end do
      else
         !$omp parallel do schedule(dynamic, 1)
         do i = 1, size(detection%finds)
            call look_through(detection, blocks, neighbours, i)
         end do
      end if
      contacts%n = sum(detection%finds)
      call reserve(contacts, contacts%n)
      if (neighbours%n_probes < parallel_from) then
         do i = 1, size(detection%finds)
            call take_over(contacts, blocks, neighbours, detection, i)
         end do
      else
         !$omp parallel do schedule(static)
         do i = 1, size(detection%finds)
            call take_over(contacts, blocks, neighbours, detection, i)
         end do
      end if
   end subroutine detect_contacts

   !> Put what a piece of the probes has found into the list, behind what the pieces before it have found.
   pure subroutine take_over(contacts, blocks, neighbours, detection, piece)
      type(contacts_type), intent(inout) :: contacts
      type(blocks_type), intent(in) :: blocks
      type(neighbours_type), intent(in) :: neighbours
      type(detection_type), intent(in) :: detection
      integer, intent(in) :: piece
      integer :: k, listed, found

      listed = sum(detection%finds(:piece - 1))
      found = neighbours%first_edge(first_of(piece, neighbours%n_probes)) - 1
      do k = 1, detection%finds(piece)
         call set_contact(contacts, listed + k, blocks, detection%find(found + k))
      end do
   end subroutine take_over

   subroutine make_room(detection, neighbours)
      type(detection_type), intent(inout) :: detection
      type(neighbours_type), intent(in) :: neighbours

      if (.not. allocated(detection%find)) allocate (detection%find(0), detection%finds(0))
      if (size(detection%find) < neighbours%first_edge(neighbours%n_probes + 1) - 1) then
         deallocate (detection%find)
         allocate (detection%find(size(neighbours%edge)))
      end if
      if (size(detection%finds) == pieces(neighbours%n_probes)) return
      deallocate (detection%finds)
      allocate (detection%finds(pieces(neighbours%n_probes)))
   end subroutine make_room

   !> What a piece of the probes finds.
   subroutine look_through(detection, blocks, neighbours, piece)
      type(detection_type), intent(inout) :: detection
      type(blocks_type), intent(in) :: blocks
      type(neighbours_type), intent(in) :: neighbours
      integer, intent(in) :: piece
      integer :: p, v, w, start, last
      logical :: met

      start = neighbours%first_edge(first_of(piece, neighbours%n_probes)) - 1
      last = start
      do p = first_of(piece, neighbours%n_probes), last_of(piece, neighbours%n_probes)
         v = neighbours%probe(1, p)
         w = nearest_corner(blocks, neighbours, p, detection%distance)
         if (w > 0) then
            if (within_corner(blocks, detection, v, w)) then
               if (v < w) call meet_corner(last, blocks, neighbours, p, w, detection, .true.)
               cycle
            end if
         end if
         call meet_edges(last, blocks, neighbours, p, detection, met)
         if (.not. met .and. v < w) call meet_corner(last, blocks, neighbours, p, w, detection, .false.)
      end do
      detection%finds(piece) = last - start
   end subroutine look_through

   !> The convex vertex of the other block nearest to the probe's vertex, within `distance`; else 0.
   pure integer function nearest_corner(blocks, neighbours, p, distance) result(nearest)
      type(blocks_type), intent(in) :: blocks
      type(neighbours_type), intent(in) :: neighbours
      integer, intent(in) :: p
      real(wp), intent(in) :: distance
      real(wp) :: least, apart
      integer :: i, k, w

      nearest = 0
      least = distance**2
      do i = neighbours%first_edge(p), neighbours%first_edge(p + 1) - 1
         w = neighbours%edge(i)
         do k = 1, 2
            if (k == 2) w = blocks%next(w)
            apart = sum((blocks%vertex(:, neighbours%probe(1, p)) - blocks%vertex(:, w))**2)
            if (apart >= least .or. .not. neighbours%convex(w)) cycle
            least = apart
            nearest = w
         end do
      end do
   end function nearest_corner

   pure logical function within_corner(blocks, detection, v, w)
      type(blocks_type), intent(in) :: blocks
      type(detection_type), intent(in) :: detection
      integer, intent(in) :: v, w

      within_corner = sum((blocks%vertex(:, v) - blocks%vertex(:, w))**2) < min(detection%corner(v), detection%corner(w))**2
   end function within_corner

   !> A vertex against one edge of another block.
   pure function examine(blocks, vertex, edge) result(choice)
      type(blocks_type), intent(in) :: blocks
      integer, intent(in) :: vertex, edge
      type(choice_type) :: choice
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
   end function examine

   !> Vertex to edge.  A convex block is entered through one edge, that of least penetration; a notch
   !> may hold a vertex with two.
   subroutine meet_edges(last, blocks, neighbours, p, detection, met)
      integer, intent(inout) :: last  !< of what was found
      type(blocks_type), intent(in) :: blocks
      type(neighbours_type), intent(in) :: neighbours
      integer, intent(in) :: p
      type(detection_type), intent(inout) :: detection
      logical, intent(out) :: met
      type(choice_type) :: choice, best
      integer :: i

      met = .false.
      best%gap = -huge(1.0_wp)
      do i = neighbours%first_edge(p), neighbours%first_edge(p + 1) - 1
         choice = examine(blocks, neighbours%probe(1, p), neighbours%edge(i))
         if (abs(choice%gap) > detection%distance .or. .not. faces(blocks, neighbours, choice, detection)) cycle
         if (neighbours%convex_block(blocks%owner(choice%edge))) then
            if (choice%gap > best%gap) best = choice
         else if (.not. hidden(blocks, neighbours, p, choice, detection%corner(choice%vertex))) then
            call note(detection, last, choice, neighbours%probe(2, p), 0)
            met = .true.
         end if
      end do
      if (best%gap > -huge(1.0_wp)) then
         call note(detection, last, best, neighbours%probe(2, p), 0)
         met = .true.
      end if
   end subroutine meet_edges

   !> The foot lies on the edge; or it lies beyond an end where the block has a notch, which a penetrating
   !> vertex does.  A corner that would only be grazed is left to `meet_corner`.
   pure logical function faces(blocks, neighbours, choice, detection)
      type(blocks_type), intent(in) :: blocks
      type(neighbours_type), intent(in) :: neighbours
      type(choice_type), intent(in) :: choice
      type(detection_type), intent(in) :: detection
      integer :: end_vertex

      end_vertex = choice%edge
      if (choice%past_end) end_vertex = blocks%next(choice%edge)
      faces = choice%overshoot <= 0.0_wp
      if (faces .and. .not. grazes(choice, skin_of(detection, choice%vertex, end_vertex), detection%travel)) return
      if (choice%overshoot > detection%distance .or. (choice%gap >= 0.0_wp .and. .not. faces)) return
      faces = .not. neighbours%convex(end_vertex)
   end function faces

   !> Depth, m, of what is passed over where two corners meet: less than their size.
   pure real(wp) function skin_of(detection, v, w)
      type(detection_type), intent(in) :: detection
      integer, intent(in) :: v, w

      skin_of = min(detection%skin, detection%corner(v), detection%corner(w))
   end function skin_of

   !> The vertex is still outside, within the skin, and its foot is on the edge, but hardly.
   elemental logical function grazes(choice, skin, travel)
      type(choice_type), intent(in) :: choice
      real(wp), intent(in) :: skin, travel

      grazes = choice%gap > -skin .and. choice%gap <= travel + skin .and. choice%overshoot <= 0.0_wp .and. choice%overshoot > -skin
   end function grazes

   !> The edge is behind another edge of the same block that the vertex is nearer to entering: across
   !> a convex corner, or on the other face of a thin part.  That other edge counts up to a corner's size beyond its
   !> ends: a vertex at the foot of a stair is on its tread.
   pure logical function hidden(blocks, neighbours, p, choice, size)
      type(blocks_type), intent(in) :: blocks
      type(neighbours_type), intent(in) :: neighbours
      integer, intent(in) :: p
      type(choice_type), intent(in) :: choice
      real(wp), intent(in) :: size
      type(choice_type) :: other
      integer :: i
      logical :: across

      hidden = .false.
      if (choice%gap >= 0.0_wp) return
      do i = neighbours%first_edge(p), neighbours%first_edge(p + 1) - 1
         other = examine(blocks, choice%vertex, neighbours%edge(i))
         if (other%overshoot > size .or. other%gap <= choice%gap .or. choice%overshoot > 0.0_wp) cycle
         across = blocks%next(other%edge) == choice%edge .and. neighbours%convex(choice%edge)
         across = across .or. (blocks%next(choice%edge) == other%edge .and. neighbours%convex(other%edge))
         if (across .or. dot_product(other%normal, choice%normal) < -0.5_wp) hidden = .true.
      end do
   end function hidden

   !> Vertex to vertex.  Far from each other (not `close`), only if neither has its foot on an edge.
   subroutine meet_corner(last, blocks, neighbours, p, w, detection, close)
      integer, intent(inout) :: last  !< of what was found
      type(blocks_type), intent(in) :: blocks
      type(neighbours_type), intent(in) :: neighbours
      integer, intent(in) :: p, w
      type(detection_type), intent(inout) :: detection
      logical, intent(in) :: close
      type(choice_type) :: choice(4)
      logical :: grazed(4)  !< at the corner that is met, not at the other end of the edge
      integer :: v, best

      v = neighbours%probe(1, p)
      choice(1) = examine_corner(blocks, v, blocks%previous(w))
      choice(2) = examine_corner(blocks, v, w)
      choice(3) = examine_corner(blocks, w, blocks%previous(v))
      choice(4) = examine_corner(blocks, w, v)
      grazed = grazes(choice, skin_of(detection, v, w), detection%travel) .and. &
         (choice%past_end .eqv. [.true., .false., .true., .false.])
      if (.not. close .and. any(choice%overshoot <= 0.0_wp .and. .not. grazed)) return
      best = entrance(blocks, choice, tie*detection%corner(v), skin_of(detection, v, w), detection%travel)
      if (choice(best)%gap > detection%distance) return
      if (choice(best)%gap < 0.0_wp .and. choice(best)%overshoot > max(detection%travel, detection%corner(v))) return
      call note(detection, last, choice(best), neighbours%probe(2, p), merge(w, v, choice(best)%vertex == v))
   end subroutine meet_corner

   !> As `examine`, with how well the edge separates the vertex' own block from it.
   pure function examine_corner(blocks, vertex, edge) result(choice)
      type(blocks_type), intent(in) :: blocks
      integer, intent(in) :: vertex, edge
      type(choice_type) :: choice

      choice = examine(blocks, vertex, edge)
      choice%separation = min(-dot_product(choice%normal, blocks%along(:, blocks%previous(vertex))), &
         dot_product(choice%normal, blocks%along(:, vertex)))
   end function examine_corner

   !> The entrance edge of least penetration; of parallel ones, that which holds the foot.  One that is grazed only
   !> if there is no other; where all are, the one along which the corners move.
   pure integer function entrance(blocks, choice, small, skin, travel) result(best)
      type(blocks_type), intent(in) :: blocks
      type(choice_type), intent(in) :: choice(4)
      real(wp), intent(in) :: small, skin, travel
      integer :: i, j
      logical :: displaced, passed(4)

      passed = .false.
      if (any(grazes(choice, skin, travel))) passed = passed_over(blocks, choice, grazes(choice, skin, travel))
      best = 0
      do i = 1, 4
         if (choice(i)%separation < -parallel_sine .or. passed(i)) cycle
         displaced = .false.
         do j = 1, 4
            if (choice(j)%separation < -parallel_sine .or. passed(j) .or. .not. parallel(choice, i, j)) cycle
            if (choice(j)%overshoot < choice(i)%overshoot - small .and. choice(i)%overshoot > small) displaced = .true.
         end do
         if (displaced) cycle
         if (best == 0) best = i
         if (choice(i)%gap > choice(best)%gap + small) best = i
      end do
      if (best == 0) best = maxloc(choice%separation, 1)
   end function entrance

   !> Choices that are grazed where another one, which pushes another way, is not; where all that separate are grazed,
   !> those along which the corners do not move.
   pure function passed_over(blocks, choice, grazed) result(passed)
      type(blocks_type), intent(in) :: blocks
      type(choice_type), intent(in) :: choice(4)
      logical, intent(in) :: grazed(4)
      logical :: passed(4), good(4)
      integer :: i, j

      good = choice%separation >= -parallel_sine .and. .not. grazed
      if (.not. any(good)) then
         passed = approached(blocks, choice)
         return
      end if
      passed = .false.
      do i = 1, 4
         do j = 1, 4
            if (good(j) .and. .not. parallel(choice, i, j)) passed(i) = grazed(i)
         end do
      end do
   end function passed_over

   !> Of the choices that separate, another one, which pushes another way, is approached less fast.
   pure function approached(blocks, choice) result(faster)
      type(blocks_type), intent(in) :: blocks
      type(choice_type), intent(in) :: choice(4)
      logical :: faster(4)
      real(wp) :: speed(4)
      integer :: i

      do i = 1, 4
         speed(i) = huge(1.0_wp)
         if (choice(i)%separation >= -parallel_sine) speed(i) = -dot_product(choice(i)%normal, &
            velocity_at(blocks, choice(i)%vertex, choice(i)%vertex) - velocity_at(blocks, choice(i)%edge, choice(i)%vertex))
      end do
      do i = 1, 4
         faster(i) = .not. parallel(choice, i, minloc(speed, 1))
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

      parallel = dot_product(choice(i)%normal, choice(j)%normal)*merge(1, -1, (i <= 2) .eqv. (j <= 2)) > same_direction
   end function parallel

   pure subroutine note(detection, last, choice, pair, corner)
      type(detection_type), intent(inout) :: detection
      integer, intent(inout) :: last
      type(choice_type), intent(in) :: choice
      integer, intent(in) :: pair, corner

      last = last + 1
      detection%find(last) = find_type(choice%vertex, choice%edge, corner, pair)
   end subroutine note

   !> A contact with its gap and the rows that move gap and slip.
   !>
   !> ∂gap/∂q is exact with the edge block's material point at the foot; ∂slip/∂q with its rotation taken at
   !> the vertex, so that the pair of shear forces carries no moment.
   pure subroutine set_contact(contacts, c, blocks, find)
      type(contacts_type), intent(inout) :: contacts
      integer, intent(in) :: c
      type(blocks_type), intent(in) :: blocks
      type(find_type), intent(in) :: find
      real(wp) :: along(2), normal(2), from(2), gap, reach(2), reference(2)
      integer :: i, j

      i = blocks%owner(find%vertex)
      j = blocks%owner(find%edge)
      along = blocks%along(:, find%edge)
      normal = [along(2), -along(1)]
      from = blocks%vertex(:, find%vertex) - blocks%vertex(:, find%edge)
      gap = dot_product(normal, from)
      contacts%vertex(c) = find%vertex
      contacts%edge(c) = find%edge
      contacts%corner(c) = find%corner
      contacts%block_v(c) = i
      contacts%block_e(c) = j
      contacts%pair(c) = find%pair
      contacts%gap(c) = gap
      contacts%normal(:, c) = normal
      reach = blocks%vertex(:, find%vertex) - blocks%position(1:2, i)
      call set_rows(blocks%axes(:, :, i), reach, reach, blocks%reference(:, find%vertex), normal, contacts%normal_v(:, c), &
         contacts%shear_v(:, c))
      reach = blocks%vertex(:, find%vertex) - blocks%position(1:2, j)
      reference = blocks%reference(:, find%edge) + (blocks%reference(:, blocks%next(find%edge)) &
         - blocks%reference(:, find%edge))*(dot_product(from, along)/blocks%length(find%edge))
      call set_rows(blocks%axes(:, :, j), reach - gap*normal, reach, reference, normal, contacts%normal_e(:, c), &
         contacts%shear_e(:, c))
   end subroutine set_contact

   !> What moves a material point along the normal, and along the edge (`direction_row`, for both).
   pure subroutine set_rows(axes, foot, reach, reference, normal, normal_row, shear_row)
      real(wp), intent(in) :: axes(2, 2)
      real(wp), intent(in) :: foot(2), reach(2)  !< present offsets that turn the normal and the shear force
      real(wp), intent(in) :: reference(2), normal(2)
      real(wp), intent(out) :: normal_row(6), shear_row(6)
      real(wp) :: x, y

      x = axes(1, 1)*normal(1) + axes(2, 1)*normal(2)
      y = axes(1, 2)*normal(1) + axes(2, 2)*normal(2)
      normal_row = [normal(1), normal(2), normal(2)*foot(1) - normal(1)*foot(2), &
         x*reference(1), y*reference(2), 0.5_wp*(x*reference(2) + y*reference(1))]
      shear_row = [-normal(2), normal(1), normal(1)*reach(1) + normal(2)*reach(2), &
         -y*reference(1), x*reference(2), 0.5_wp*(x*reference(1) - y*reference(2))]
   end subroutine set_rows

end module dda_detection
