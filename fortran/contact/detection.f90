!> Which vertex meets which edge now, from the probes of the last search.
!>
!> Vertex to edge: the foot of the vertex lies on the edge.  Vertex to vertex: the entrance edge of
!> the two corners (see dda_entrance).  Corners of parallel edges give one contact, on the edge that
!> holds the foot: so blocks of equal width stacked on each other get two contacts per joint, one at
!> each end.
module dda_detection
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type
   use dda_contact, only: contacts_type, reserve
   use dda_contact_geometry, only: find_type, set_contacts
   use dda_entrance, only: choice_type, examine, list_choices, grazes, entrance
   use dda_neighbours, only: neighbours_type
   use dda_ordered_sums, only: pieces, first_of, last_of, parallel_from
   implicit none
   private
   public :: detection_type, prepare_detection, measure_depths, detect_contacts

   real(wp), parameter :: corner_share = 0.05_wp  !< of the shorter edge: size of a corner

   !> Distances that steer the detection, and room for what it finds.
   type :: detection_type
      real(wp) :: least = 0.0_wp         !< least distance at which a contact is listed, m
      real(wp) :: distance = 0.0_wp      !< distance in this step, m
      !> farthest that two vertices may approach each other in this step, m
      real(wp) :: travel = 0.0_wp
      real(wp) :: deepest = 0.0_wp       !< deepest penetration of a contact that presses, m
      real(wp) :: largest_corner = 0.0_wp !< m
      !> the same beyond the depth at which a contact was met first, m
      real(wp) :: pressed = 0.0_wp
      !> [vertices] deepest penetration of each vertex where it presses, m
      real(wp), allocatable :: depth(:)
      !> [2, vertices] edges on which each vertex presses, else 0
      integer, allocatable :: pressing(:,:)
      real(wp), allocatable :: corner(:) !< [vertices] size of the corner at each vertex, m
      !> [edges of the probes] a probe finds no more than it has edges
      type(find_type), allocatable :: find(:)
      integer, allocatable :: finds(:)   !< [pieces of the probes] found in each
   end type detection_type

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
      allocate (detection%depth(size(blocks%owner)), source=0.0_wp)
      allocate (detection%pressing(2, size(blocks%owner)), source=0)
      allocate (detection%corner(size(blocks%owner)))
      do v = 1, size(detection%corner)
         here = blocks%reference(:, v)
         detection%corner(v) = &
            min(distance, corner_share*min(norm2(blocks%reference(:, blocks%next(v)) - here), &
            norm2(blocks%reference(:, blocks%previous(v)) - here)))
      end do
      detection%largest_corner = maxval(detection%corner)
   end subroutine prepare_detection

   !> How deep the last step's contacts went, and which of them press.
   pure subroutine measure_depths(detection, contacts)
      type(detection_type), intent(inout) :: detection
      type(contacts_type), intent(in) :: contacts
      real(wp) :: depth, pressed, deepest, hardest
      integer :: c

      deepest = 0.0_wp
      hardest = 0.0_wp
      detection%depth = 0.0_wp
      detection%pressing = 0
      do c = 1, contacts%n
         pressed = -contacts%new_gap(c)
         if (pressed <= 0.0_wp) cycle
         depth = pressed - contacts%offset(c)
         deepest = max(deepest, depth)
         hardest = max(hardest, pressed)
         call deepen(detection%depth(contacts%vertex(c)), depth)
         if (contacts%corner(c) > 0) call deepen(detection%depth(contacts%corner(c)), depth)
         detection%pressing(2, contacts%vertex(c)) = detection%pressing(1, contacts%vertex(c))
         detection%pressing(1, contacts%vertex(c)) = contacts%edge(c)
      end do
      detection%deepest = deepest
      detection%pressed = hardest
   end subroutine measure_depths

   elemental subroutine deepen(deepest, depth)
      real(wp), intent(inout) :: deepest
      real(wp), intent(in) :: depth

      deepest = max(deepest, depth)
   end subroutine deepen

   !> List all contacts nearer than the distance of this step, with geometry; history is left blank.
   !>
   !> Pieces of the probes are looked through in any order; what they find is listed in the order of
   !> the probes.
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

   !> Put what a piece of the probes has found into the list, behind what the pieces before it have
   !> found.
   pure subroutine take_over(contacts, blocks, neighbours, detection, piece)
      type(contacts_type), intent(inout) :: contacts
      type(blocks_type), intent(in) :: blocks
      type(neighbours_type), intent(in) :: neighbours
      type(detection_type), intent(in) :: detection
      integer, intent(in) :: piece
      integer :: listed, found

      listed = sum(detection%finds(:piece - 1))
      found = neighbours%first_edge(first_of(piece, neighbours%n_probes)) - 1
      call set_contacts(contacts, listed + 1, blocks, detection%finds(piece), &
         detection%find(found + 1))
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
         if (.not. met .and. v < w) call meet_corner(last, blocks, neighbours, p, w, detection, &
            .false.)
      end do
      detection%finds(piece) = last - start
   end subroutine look_through

   !> The convex vertex of the other block nearest to the probe's vertex, within `distance`; else 0.
   pure integer function nearest_corner(blocks, neighbours, p, distance) result(nearest)
      type(blocks_type), intent(in) :: blocks
      type(neighbours_type), intent(in) :: neighbours
      integer, intent(in) :: p
      real(wp), intent(in) :: distance
      real(wp) :: here(2), least, apart
      integer :: i, w

      nearest = 0
      least = distance**2
      here = blocks%vertex(:, neighbours%probe(1, p))
      do i = neighbours%first_corner(p), neighbours%first_corner(p + 1) - 1
         w = neighbours%corner(i)
         apart = (here(1) - blocks%vertex(1, w))**2 + (here(2) - blocks%vertex(2, w))**2
         if (apart >= least) cycle
         least = apart
         nearest = w
      end do
   end function nearest_corner

   pure logical function within_corner(blocks, detection, v, w)
      type(blocks_type), intent(in) :: blocks
      type(detection_type), intent(in) :: detection
      integer, intent(in) :: v, w

      within_corner = sum((blocks%vertex(:, v) - blocks%vertex(:, w))**2) &
         < min(detection%corner(v), detection%corner(w))**2
   end function within_corner

   !> Vertex to edge.  A convex block is entered through one edge, that of least penetration; a
   !> notch may hold a vertex with two.
   subroutine meet_edges(last, blocks, neighbours, p, detection, met)
      integer, intent(inout) :: last  !< of what was found
      type(blocks_type), intent(in) :: blocks
      type(neighbours_type), intent(in) :: neighbours
      integer, intent(in) :: p
      type(detection_type), intent(inout) :: detection
      logical, intent(out) :: met
      type(choice_type) :: choice
      real(wp) :: least
      integer :: i, entered

      met = .false.
      entered = 0
      least = -huge(1.0_wp)
      do i = neighbours%first_edge(p), neighbours%first_edge(p + 1) - 1
         call examine(blocks, neighbours%probe(1, p), neighbours%edge(i), choice)
         if (abs(choice%gap) > detection%distance .or. .not. faces(blocks, neighbours, choice, &
            detection)) cycle
         if (neighbours%convex_block(blocks%owner(choice%edge))) then
            if (choice%gap <= least) cycle
            least = choice%gap
            entered = choice%edge
         else if (.not. hidden(blocks, neighbours, p, choice, detection%corner(choice%vertex))) then
            call note(detection, last, choice%vertex, choice%edge, neighbours%probe(2, p), 0)
            met = .true.
         end if
      end do
      if (entered > 0) then
         call note(detection, last, neighbours%probe(1, p), entered, neighbours%probe(2, p), 0)
         met = .true.
      end if
   end subroutine meet_edges

   !> The foot lies on the edge; or it lies beyond an end where the block has a notch, which a
   !> penetrating vertex does.  A corner that would only be grazed is left to `meet_corner`.
   pure logical function faces(blocks, neighbours, choice, detection)
      type(blocks_type), intent(in) :: blocks
      type(neighbours_type), intent(in) :: neighbours
      type(choice_type), intent(in) :: choice
      type(detection_type), intent(in) :: detection
      integer :: end_vertex

      faces = choice%overshoot <= 0.0_wp
      ! far from both ends: nothing to graze
      if (choice%overshoot <= -detection%largest_corner) return
      end_vertex = choice%edge
      if (choice%past_end) end_vertex = blocks%next(choice%edge)
      if (faces) then
         if (presses(detection, choice)) return
         if (.not. grazes(choice, skin_of(detection, choice%vertex, end_vertex), &
            detection%travel)) return
      end if
      if (choice%overshoot > detection%distance .or. (choice%gap >= 0.0_wp .and. .not. faces)) &
         return
      faces = .not. neighbours%convex(end_vertex)
   end function faces

   !> The vertex pressed on the edge in the last step.  It is not grazed then: two corners that
   !> press on each other and tremble would else change their edges for ever, and sink a little each
   !> time.
   elemental logical function presses(detection, choice)
      type(detection_type), intent(in) :: detection
      type(choice_type), intent(in) :: choice

      presses = any(detection%pressing(:, choice%vertex) == choice%edge)
   end function presses

   !> Depth, m, of what is passed over where two corners meet: twice that to which they are pressed
   !> into others now, less than their size.
   pure real(wp) function skin_of(detection, v, w)
      type(detection_type), intent(in) :: detection
      integer, intent(in) :: v, w

      skin_of = min(2*max(detection%depth(v), detection%depth(w)), detection%corner(v), &
         detection%corner(w))
   end function skin_of

   !> The edge is behind another edge of the same block that the vertex is nearer to entering:
   !> across a convex corner, or on the other face of a thin part.  That other edge counts up to a
   !> corner's size beyond its ends: a vertex at the foot of a stair is on its tread.
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
         call examine(blocks, choice%vertex, neighbours%edge(i), other)
         if (other%overshoot > size .or. other%gap <= choice%gap .or. choice%overshoot > 0.0_wp) &
            cycle
         across = blocks%next(other%edge) == choice%edge .and. neighbours%convex(choice%edge)
         across = across .or. (blocks%next(choice%edge) == other%edge &
            .and. neighbours%convex(other%edge))
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
      real(wp) :: skin
      logical :: grazed(4)
      integer :: v, best

      v = neighbours%probe(1, p)
      skin = skin_of(detection, v, w)
      call list_choices(blocks, v, w, skin, detection%travel, choice, grazed)
      grazed = grazed .and. .not. presses(detection, choice)
      if (.not. close .and. any(choice%overshoot <= 0.0_wp .and. .not. grazed)) return
      best = entrance(blocks, choice, detection%corner(v), skin, grazed)
      if (choice(best)%gap > detection%distance) return
      ! A corner that is in, has its foot on an edge.
      if (.not. close .and. choice(best)%gap < -skin) return
      call note(detection, last, choice(best)%vertex, choice(best)%edge, neighbours%probe(2, p), &
         merge(w, v, choice(best)%vertex == v))
   end subroutine meet_corner

   pure subroutine note(detection, last, vertex, edge, pair, corner)
      type(detection_type), intent(inout) :: detection
      integer, intent(inout) :: last
      integer, intent(in) :: vertex, edge, pair, corner

      last = last + 1
      detection%find(last) = find_type(vertex, edge, corner, pair)
   end subroutine note

end module dda_detection
