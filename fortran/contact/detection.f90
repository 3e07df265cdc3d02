! SPDX-License-Identifier: GPL-3.0-or-later
!> Contact detection: contacts of the present geometry among the probes of the last search.
!>
!> Vertex to edge: the foot of the vertex lies on the edge.  Vertex to vertex: the contact is on the
!> entrance edge of the two corners (see dda_entrance).  Corners of parallel edges have one contact,
!> on the edge that contains the foot.  Stacked blocks of equal width therefore have two contacts
!> per joint, one at each end.
module dda_detection
   !$ use omp_lib, only: omp_get_thread_num
   use dda_kinds, only: wp, pi
   use dda_blocks, only: blocks_type
   use dda_contact, only: contacts_type, is_point, reserve
   use dda_crossings, only: most_across
   use dda_contact_geometry, only: candidate_type, set_contacts
   use dda_entrance, only: choice_type, corners_type, project_vertex, list_choices, is_glancing, &
      entrance_edge, other_end
   use dda_neighbours, only: neighbours_type
   use dda_ordered_sums, only: pieces, first_of, last_of, parallel_from
   use dda_team, only: largest_team
   implicit none
   private
   public :: detection_type, prepare_detection, measure_depths, detect_contacts, tolerance_of

   integer, parameter :: spare = 64  !< memory for one more contact per 64 contacts is allocated
   real(wp), parameter :: corner_ratio = 0.05_wp  !< size of a corner/its shorter edge
   !> cosine of the largest angle between straight edges, 3°
   real(wp), parameter :: straight = cos(3.0_wp*pi/180.0_wp)

   !> Distances that control the detection, and work arrays for the candidates.
   type :: detection_type
      real(wp) :: least = 0.0_wp         !< smallest distance for listing contacts, m
      real(wp) :: distance = 0.0_wp      !< distance for listing contacts in this step, m
      !> largest approach of two vertices in this step, m
      real(wp) :: travel = 0.0_wp
      real(wp) :: deepest = 0.0_wp       !< deepest penetration of a contact in compression, m
      real(wp) :: largest_corner = 0.0_wp !< largest size of a corner, m
      !> deepest penetration in compression, measured from the gap with zero force, m
      real(wp) :: pressed = 0.0_wp
      !> [vertices] deepest penetration of each vertex in compression, m
      real(wp), allocatable :: depth(:)
      !> [2, vertices] edges that each vertex is pressed against; 0: none
      integer, allocatable :: pressing(:,:)
      !> [2,vertices] touching vertex and edge of the bonded contact of each vertex with a corner of
      !> higher number; 0: none
      integer, allocatable :: bond(:,:)
      logical :: has_bonds = .false.     !< `bond` is not zero
      real(wp), allocatable :: corner(:) !< [vertices] size of the corner at each vertex, m
      logical, allocatable :: flat(:)    !< [vertices] vertex between two cells on a straight side
      !> [most_across,vertices] opposite corners at a crossing of joints, or 0; empty if no joints
      !> cross
      integer, allocatable :: across(:,:)
      !> [edges in a thread's chunk of probes] candidates; a probe has at most one contact per edge
      type(candidate_type), allocatable :: candidate(:)
      integer :: listed = 0              !< number of contacts in the last large list
   end type detection_type

contains

   !> Set the sizes of corners: a fraction of the shorter edge, at most the contact distance.
   subroutine prepare_detection(detection, blocks, distance)
      type(detection_type), intent(out) :: detection  !< ready for the first step
      type(blocks_type), intent(in) :: blocks         !< reference shapes
      real(wp), intent(in) :: distance                !< smallest distance for listing contacts, m
      real(wp) :: point(2)
      integer :: v

      detection%least = distance
      detection%distance = distance
      allocate (detection%depth(size(blocks%owner)), source=0.0_wp)
      allocate (detection%pressing(2, size(blocks%owner)), source=0)
      allocate (detection%bond(2, size(blocks%owner)), source=0)
      allocate (detection%corner(size(blocks%owner)), detection%candidate(0))
      allocate (detection%across(most_across, 0))
      do v = 1, size(detection%corner)
         point = blocks%reference(:, v)
         detection%corner(v) = &
            min(distance, corner_ratio*min(norm2(blocks%reference(:, blocks%next(v)) - point), &
            norm2(blocks%reference(:, blocks%previous(v)) - point)))
      end do
      detection%flat = [(is_flat(blocks, v), v=1, size(blocks%owner))]
      detection%largest_corner = maxval(detection%corner)
   end subroutine prepare_detection

   !> .true. if two cells of a body meet at vertex v on a straight side of the body.
   pure logical function is_flat(blocks, v)
      type(blocks_type), intent(in) :: blocks  !< at the start
      integer, intent(in) :: v                 !< vertex

      is_flat = blocks%inner(v) .or. blocks%inner(blocks%previous(v))
      if (is_flat) is_flat = dot_product(blocks%along(:, blocks%outline(1, v)), &
         blocks%along(:, blocks%outline(2, v))) > straight
   end function is_flat

   !> Find the penetrations at the end of the last step, the edges that each vertex is pressed
   !> against, and the bonds of corners.
   !>
   !> The penetration includes the surface displacement due to the strain of cells, because a corner
   !> that slides to the next body is below its surface by this displacement.
   pure subroutine measure_depths(detection, contacts, blocks)
      type(detection_type), intent(inout) :: detection  !< depths are replaced
      type(contacts_type), intent(in) :: contacts       !< contacts of the last step
      type(blocks_type), intent(in) :: blocks           !< present geometry
      real(wp) :: depth, pressed, deepest, hardest
      logical :: with_cells
      integer :: c, v, w

      with_cells = size(blocks%joined) > 0
      deepest = 0.0_wp
      hardest = 0.0_wp
      detection%depth = 0.0_wp
      call clear(size(detection%pressing), detection%pressing)
      if (detection%has_bonds) call clear(size(detection%bond), detection%bond)
      detection%has_bonds = .false.
      do c = 1, contacts%n
         if (contacts%bonded(c) .and. contacts%corner(c) > 0) then
            detection%has_bonds = .true.
            detection%bond(:, min(contacts%vertex(c), contacts%corner(c))) = [contacts%vertex(c), &
               contacts%edge(c)]
         end if
         pressed = -contacts%new_gap(c)
         if (pressed <= 0.0_wp) cycle
         depth = pressed - contacts%offset(c)
         deepest = max(deepest, depth)
         hardest = max(hardest, pressed)
         if (is_point(contacts, c)) cycle
         v = contacts%vertex(c)
         w = contacts%corner(c)
         if (with_cells) depth = depth + surface_settlement(blocks, contacts%block_v(c)) &
            + surface_settlement(blocks, contacts%block_e(c))
         detection%depth(v) = max(detection%depth(v), depth)
         if (w > 0) detection%depth(w) = max(detection%depth(w), depth)
         detection%pressing(:, v) = [contacts%edge(c), detection%pressing(1, v)]
      end do
      detection%deepest = deepest
      detection%pressed = hardest
   end subroutine measure_depths

   !> Return the surface displacement of a cell of a body due to its strain, m; 0 for other blocks.
   pure real(wp) function surface_settlement(blocks, b)
      type(blocks_type), intent(in) :: blocks  !< present geometry
      integer, intent(in) :: b                 !< block

      surface_settlement = 0.0_wp
      if (blocks%body(b) > 0) surface_settlement = maxval(abs(blocks%position(4:6, b))) &
         *sqrt(blocks%whole_area(b))
   end function surface_settlement

   !> Set the vertices and edges of all vertices to 0.
   pure subroutine clear(n, numbers)
      integer, intent(in) :: n            !< size
      integer, intent(out) :: numbers(n)  !< set to zero

      numbers = 0
   end subroutine clear

   !> List all contacts within the distance of this step, with geometry but without history.
   !>
   !> A large list is allocated with slightly more memory than the last list needed.  If this does
   !> not suffice, detection is repeated with enough memory.
   subroutine detect_contacts(contacts, blocks, neighbours, detection)
      type(contacts_type), intent(inout) :: contacts     !< list that is replaced
      type(blocks_type), intent(in) :: blocks            !< present geometry
      type(neighbours_type), intent(in) :: neighbours    !< probes of the last search
      type(detection_type), intent(inout) :: detection   !< distances of this step
      integer :: capacity, edges

      associate (n => neighbours%n_probes)
         if (n < parallel_from) then
            call allocate_candidates(detection, neighbours%first_edge(n + 1) - 1)
            call detect_contacts_range(detection, blocks, neighbours, 1, n, 0, contacts%n)
            call reserve(contacts, contacts%n)
            call set_contacts(contacts, 1, blocks, contacts%n, detection%candidate)
            return
         end if
      end associate
      edges = most_edges(neighbours)
      call allocate_candidates(detection, edges*largest_team())
      capacity = detection%listed + detection%listed/spare
      do
         call reserve(contacts, capacity)
         call detect_in_chunks(contacts, capacity, blocks, neighbours, detection, edges)
         if (contacts%n <= capacity) exit
         capacity = contacts%n
      end do
      detection%listed = contacts%n
   end subroutine detect_contacts

   !> Allocate memory for candidates.
   pure subroutine allocate_candidates(detection, candidates)
      type(detection_type), intent(inout) :: detection  !< receives the memory
      integer, intent(in) :: candidates                 !< largest number of candidates in a chunk

      if (size(detection%candidate) >= candidates) return
      deallocate (detection%candidate)
      allocate (detection%candidate(candidates))
   end subroutine allocate_candidates

   !> Return the largest number of edges in a chunk of probes.
   pure integer function most_edges(neighbours) result(most)
      type(neighbours_type), intent(in) :: neighbours  !< probes of the last search
      integer :: p

      most = 0
      associate (n => neighbours%n_probes, first_edge => neighbours%first_edge)
         do p = 1, pieces(n)
            most = max(most, first_edge(last_of(p, n) + 1) - first_edge(first_of(p, n)))
         end do
      end associate
   end function most_edges

   !> Test all probes in chunks by several threads; the list has the order of the probes.
   !> Contacts beyond its capacity are counted but not stored.
   subroutine detect_in_chunks(contacts, capacity, blocks, neighbours, detection, edges)
      type(contacts_type), intent(inout) :: contacts     !< list that is replaced
      integer, intent(in) :: capacity                    !< capacity
      type(blocks_type), intent(in) :: blocks            !< present geometry
      type(neighbours_type), intent(in) :: neighbours    !< probes of the last search
      type(detection_type), intent(inout) :: detection   !< distances of this step
      integer, intent(in) :: edges                       !< largest number of edges in a chunk
      integer :: p, n, found, before, first, listed

      n = neighbours%n_probes
      listed = 0
      !$omp parallel do ordered schedule(dynamic, 1) private(found, before, first)
      do p = 1, pieces(n)
         before = 0
         !$ before = edges*omp_get_thread_num()
         call detect_contacts_range(detection, blocks, neighbours, first_of(p, n), last_of(p, n), &
            before, found)
         !$omp ordered
         first = listed + 1
         listed = listed + found
         !$omp end ordered
         if (first + found - 1 <= capacity) &
            call set_contacts(contacts, first, blocks, found, detection%candidate(before + 1))
      end do
      contacts%n = listed
   end subroutine detect_in_chunks

   !> Find the candidates of some probes; store them after the candidates of other threads.
   subroutine detect_contacts_range(detection, blocks, neighbours, first, last, before, found)
      type(detection_type), intent(inout) :: detection  !< receives the candidates
      type(blocks_type), intent(in) :: blocks           !< present geometry
      type(neighbours_type), intent(in) :: neighbours   !< probes
      integer, intent(in) :: first, last                !< probes to test
      integer, intent(in) :: before                     !< number of earlier candidates
      integer, intent(out) :: found                     !< number of candidates
      integer :: p, v, w, at
      real(wp) :: apart
      logical :: near, has_contact

      at = before
      do p = first, last
         v = neighbours%probe(1, p)
         call find_corner(v, blocks%vertex, neighbours%corner, neighbours%first_corner(p), &
            neighbours%first_corner(p + 1) - 1, detection%distance, w, apart)
         near = w > 0
         if (near) near = apart < min(detection%corner(v), detection%corner(w))**2
         if (near) then
            if (v < w) call test_vertex(at, blocks, neighbours, p, w, detection, near)
            if (v > w) call add_other_end(at, blocks, neighbours, p, w, detection)
            cycle
         end if
         call test_edges(at, blocks, neighbours, p, detection, has_contact)
         if (.not. has_contact .and. v < w) call test_vertex(at, blocks, neighbours, p, w, &
            detection, near)
      end do
      found = at - before
   end subroutine detect_contacts_range

   !> Find the corner nearest to vertex v, or 0.
   !> The shapes of the arrays are explicit, because the compiler then needs no descriptors.
   pure subroutine find_corner(v, vertex, corner, first, last, distance, nearest, least)
      integer, intent(in) :: v                 !< vertex
      real(wp), intent(in) :: vertex(2, *)     !< present positions of all vertices, m
      integer, intent(in) :: corner(*)         !< convex vertices of other blocks, by probes
      integer, intent(in) :: first, last       !< first and last corner of the probe
      real(wp), intent(in) :: distance         !< search distance, m
      integer, intent(out) :: nearest          !< vertex, or 0
      real(wp), intent(out) :: least           !< square of the distance, m²
      real(wp) :: apart
      integer :: i

      nearest = 0
      least = distance**2
      do i = first, last
         associate (w => corner(i))
            apart = (vertex(1, v) - vertex(1, w))**2 + (vertex(2, v) - vertex(2, w))**2
            if (apart >= least) cycle
            least = apart
            nearest = w
         end associate
      end do
   end subroutine find_corner

   !> Find the contacts of a vertex with the edges of another block: one, or two in concave corners.
   !> On a convex block, the contact is on the edge of least penetration.
   subroutine test_edges(last, blocks, neighbours, p, detection, has_contact)
      integer, intent(inout) :: last                    !< position of the last candidate
      type(blocks_type), intent(in) :: blocks           !< present geometry
      type(neighbours_type), intent(in) :: neighbours   !< probes
      integer, intent(in) :: p                          !< probe to test
      type(detection_type), intent(inout) :: detection  !< receives the candidates
      logical, intent(out) :: has_contact               !< a contact was found
      type(choice_type) :: choice
      real(wp) :: least
      integer :: i, entered

      has_contact = .false.
      entered = 0
      least = -huge(1.0_wp)
      do i = neighbours%first_edge(p), neighbours%first_edge(p + 1) - 1
         call project_vertex(blocks, neighbours%probe(1, p), neighbours%edge(i), choice)
         if (abs(choice%gap) > detection%distance .or. .not. has_foot(blocks, neighbours, choice, &
            detection)) cycle
         ! A vertex with little penetration at a corner has not left the block.
         if (choice%gap < -detection%least) then
            if (has_left_block(blocks, neighbours, choice)) cycle
         end if
         if (neighbours%convex_block(blocks%owner(choice%edge))) then
            if (choice%gap <= least) cycle
            least = choice%gap
            entered = choice%edge
         else if (.not. is_hidden(blocks, neighbours, p, choice, &
            detection%corner(choice%vertex))) then
            call add_candidate(detection, last, choice%vertex, choice%edge, neighbours%probe(2, &
               p), 0)
            has_contact = .true.
         end if
      end do
      if (entered > 0) then
         call add_candidate(detection, last, neighbours%probe(1, p), entered, neighbours%probe(2, &
            p), 0)
         has_contact = .true.
      end if
   end subroutine test_edges

   !> .true. if the foot of a vertex lies on the edge, or, for a penetrating vertex, beyond an end
   !> of the edge at a concave corner.
   pure logical function has_foot(blocks, neighbours, choice, detection)  ! total
      type(blocks_type), intent(in) :: blocks          !< present geometry
      type(neighbours_type), intent(in) :: neighbours  !< marks of convex vertices
      type(choice_type), intent(in) :: choice          !< vertex projected on an edge
      type(detection_type), intent(in) :: detection    !< distances of this step
      integer :: end_vertex

      has_foot = choice%overshoot <= 0.0_wp
      ! A contact far from both ends of the edge is not glancing.
      if (choice%overshoot <= -detection%largest_corner) return
      end_vertex = choice%edge
      if (choice%past_end) end_vertex = blocks%next(choice%edge)
      if (has_foot) then
         if (was_pressed(detection, choice%vertex, choice%edge)) return
         if (.not. is_glancing(choice%gap, choice%overshoot, tolerance_of(detection, &
            choice%vertex, end_vertex), detection%travel)) return
      end if
      if (choice%overshoot > detection%distance .or. (choice%gap >= 0.0_wp .and. .not. has_foot)) &
         return
      has_foot = .not. neighbours%convex(end_vertex)
   end function has_foot

   !> .true. if the vertex was pressed against the edge in the last step.
   !> Such a contact is never glancing.  Otherwise vibrating corners would alternate between their
   !> edges, and each change would increase the penetration slightly.
   pure logical function was_pressed(detection, vertex, edge)
      type(detection_type), intent(in) :: detection  !< pressed edges of the last step
      integer, intent(in) :: vertex, edge            !< vertex, and edge given by its first vertex

      was_pressed = detection%pressing(1, vertex) == edge .or. &
         detection%pressing(2, vertex) == edge
   end function was_pressed

   !> .true. if the corners v and w were pressed against each other in the last step.
   pure logical function were_pressed(detection, blocks, v, w)
      type(detection_type), intent(in) :: detection  !< pressed edges of the last step
      type(blocks_type), intent(in) :: blocks        !< blocks: edges at the vertices
      integer, intent(in) :: v, w                    !< vertices of two blocks

      were_pressed = any(detection%pressing(:, v) == w) &
         .or. any(detection%pressing(:, v) == blocks%previous(w)) &
         .or. any(detection%pressing(:, w) == v) &
         .or. any(detection%pressing(:, w) == blocks%previous(v))
   end function were_pressed

   !> .true. if the corners v < w have a bonded contact that remains on its edge.
   !> An intact bond neither opens nor slides, so that no other edge can be the entrance.  A contact
   !> at a flat vertex is selected anew, because `add_other_end` depends on the selection.
   pure logical function has_bond(detection, blocks, v, w)
      type(detection_type), intent(in) :: detection  !< bonds of the last step
      type(blocks_type), intent(in) :: blocks        !< blocks: edges at the vertices
      integer, intent(in) :: v, w                    !< vertices of two blocks

      associate (edge => detection%bond(2, v))
         if (detection%bond(1, v) == v) then
            has_bond = any([w, blocks%previous(w)] == edge)
         else
            has_bond = detection%bond(1, v) == w
         end if
      end associate
      if (has_bond) has_bond = .not. (detection%flat(v) .or. detection%flat(w))
   end function has_bond

   !> Return the largest penetration of a glancing contact of two corners, m.
   !> The value is twice the penetration in the last step, but less than the size of the corners.
   pure real(wp) function tolerance_of(detection, v, w)
      type(detection_type), intent(in) :: detection  !< penetrations and sizes of corners
      integer, intent(in) :: v, w                    !< vertices of two blocks

      tolerance_of = min(2*max(detection%depth(v), detection%depth(w)), detection%corner(v), &
         detection%corner(w))
   end function tolerance_of

   !> .true. if a vertex behind the chosen edge is nevertheless outside the block.
   !> The vertex is then outside another edge; in a concave block, this edge is between vertex and
   !> foot.
   pure logical function has_left_block(blocks, neighbours, choice)
      type(blocks_type), intent(in) :: blocks          !< present geometry
      type(neighbours_type), intent(in) :: neighbours  !< marks of convex blocks
      type(choice_type), intent(in) :: choice          !< the vertex projected on an edge
      type(choice_type) :: other
      real(wp) :: path(2), along, behind
      integer :: e, b

      b = blocks%owner(choice%edge)
      path = -(choice%gap*choice%normal &
         + max(choice%overshoot, 0.0_wp)*merge(1, -1, choice%past_end)*blocks%along(:, choice%edge))
      has_left_block = .false.
      do e = blocks%first(b), blocks%first(b + 1) - 1
         if (e == choice%edge) cycle
         call project_vertex(blocks, choice%vertex, e, other)
         if (other%gap <= 0.0_wp) cycle
         has_left_block = neighbours%convex_block(b)
         if (has_left_block) return
         behind = -(other%gap + dot_product(other%normal, path))
         if (behind < 0.0_wp) cycle
         along = dot_product(blocks%along(:, e), blocks%vertex(:, choice%vertex) &
            - blocks%vertex(:, e) + path*(other%gap/(other%gap + behind)))
         has_left_block = along >= 0.0_wp .and. along <= blocks%length(e)
         if (has_left_block) return
      end do
   end function has_left_block

   !> .true. if the vertex penetrates another edge less than the chosen edge.
   !> The other edge is across a convex corner, or on the opposite face of a thin part.  The chosen
   !> edge is extended at both ends by the size of a corner, for a vertex at the foot of a step.
   pure logical function is_hidden(blocks, neighbours, p, choice, size)
      type(blocks_type), intent(in) :: blocks          !< present geometry
      type(neighbours_type), intent(in) :: neighbours  !< probes
      integer, intent(in) :: p                         !< probe of the vertex
      type(choice_type), intent(in) :: choice          !< the vertex projected on the edge
      real(wp), intent(in) :: size                     !< size of the corner at the vertex, m
      type(choice_type) :: other
      integer :: i
      logical :: across

      is_hidden = .false.
      if (choice%gap >= 0.0_wp) return
      do i = neighbours%first_edge(p), neighbours%first_edge(p + 1) - 1
         call project_vertex(blocks, choice%vertex, neighbours%edge(i), other)
         if (other%overshoot > size .or. other%gap <= choice%gap .or. choice%overshoot > 0.0_wp) &
            cycle
         across = blocks%next(other%edge) == choice%edge .and. neighbours%convex(choice%edge)
         across = across .or. (blocks%next(choice%edge) == other%edge &
            .and. neighbours%convex(other%edge))
         if (across .or. dot_product(other%normal, choice%normal) < -0.5_wp) is_hidden = .true.
      end do
   end function is_hidden

   !> Add the contact of two convex vertices, if there is one.
   !> Corners that are not close have a contact only if no vertex has a foot on the other block.
   subroutine test_vertex(last, blocks, neighbours, p, w, detection, close)
      integer, intent(inout) :: last                    !< position of the last candidate
      type(blocks_type), intent(in) :: blocks           !< present geometry
      type(neighbours_type), intent(in) :: neighbours   !< probes
      integer, intent(in) :: p                          !< probe to test
      integer, intent(in) :: w                          !< vertex of the other block
      type(detection_type), intent(inout) :: detection  !< receives the candidate
      logical, intent(in) :: close  !< distance is less than the size of the corners
      type(corners_type) :: corners
      real(wp) :: tolerance
      integer :: v, best

      v = neighbours%probe(1, p)
      if (close .and. size(detection%across, 2) > 0) then
         if (any(detection%across(:, v) == w)) then
            if (.not. were_pressed(detection, blocks, v, w)) return
         end if
      end if
      if (close .and. detection%has_bonds) then
         if (has_bond(detection, blocks, v, w)) then
            call add_candidate(detection, last, detection%bond(1, v), detection%bond(2, v), &
               neighbours%probe(2, p), merge(w, v, detection%bond(1, v) == v))
            return
         end if
      end if
      call list_corners(blocks, v, w, detection, corners, tolerance)
      if (.not. close) then
         if (any(corners%overshoot <= 0.0_wp .and. .not. corners%glancing)) return
      end if
      best = entrance_edge(blocks, corners, detection%corner(v), tolerance)
      if (corners%gap(best) > detection%distance) return
      ! The foot of a deeper corner lies on an edge, so `test_edges` has added the contact.
      if (.not. close .and. corners%gap(best) < -tolerance) return
      call add_candidate(detection, last, corners%vertex(best), corners%edge(best), &
         neighbours%probe(2, p), merge(w, v, corners%vertex(best) == v))
   end subroutine test_vertex

   !> List the vertex–edge choices at two corners and mark the glancing ones.
   pure subroutine list_corners(blocks, v, w, detection, corners, tolerance)
      type(blocks_type), intent(in) :: blocks         !< present geometry
      integer, intent(in) :: v, w                     !< vertices of two blocks
      type(detection_type), intent(in) :: detection   !< pressed edges of the last step
      type(corners_type), intent(out) :: corners      !< result
      real(wp), intent(out) :: tolerance              !< depth of a glancing contact, m
      integer :: i

      tolerance = tolerance_of(detection, v, w)
      call list_choices(blocks, v, w, tolerance, detection%travel, corners)
      do i = 1, 4
         if (corners%glancing(i)) corners%glancing(i) = &
            .not. was_pressed(detection, corners%vertex(i), corners%edge(i))
      end do
   end subroutine list_corners

   !> Add the contact at the other end of an overlap between sides of two bodies.
   !> `test_vertex` omits this contact.  Only the probe of the higher vertex adds it.
   subroutine add_other_end(last, blocks, neighbours, p, w, detection)
      integer, intent(inout) :: last                    !< position of the last candidate
      type(blocks_type), intent(in) :: blocks           !< present geometry
      type(neighbours_type), intent(in) :: neighbours   !< probes
      integer, intent(in) :: p                          !< probe to test
      integer, intent(in) :: w  !< vertex of the other block, < that of the probe
      type(detection_type), intent(inout) :: detection  !< receives the candidate
      type(corners_type) :: corners
      real(wp) :: tolerance
      integer :: v, best

      v = neighbours%probe(1, p)
      if (.not. (detection%flat(v) .or. detection%flat(w))) return
      call list_corners(blocks, w, v, detection, corners, tolerance)
      best = other_end(blocks, corners, entrance_edge(blocks, corners, detection%corner(w), &
         tolerance), min(detection%corner(v), detection%corner(w)), detection%distance)
      if (best > 0) call add_candidate(detection, last, corners%vertex(best), corners%edge(best), &
         neighbours%probe(2, p), merge(w, v, corners%vertex(best) == v))
   end subroutine add_other_end

   !> Append a candidate.
   pure subroutine add_candidate(detection, last, vertex, edge, pair, corner)
      type(detection_type), intent(inout) :: detection     !< receives the candidate
      integer, intent(inout) :: last                       !< position of the last candidate
      integer, intent(in) :: vertex, edge, pair, corner    !< see `candidate_type`

      last = last + 1
      detection%candidate(last) = candidate_type(vertex, edge, corner, pair)
   end subroutine add_candidate

end module dda_detection
