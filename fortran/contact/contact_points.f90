! SPDX-License-Identifier: GPL-3.0-or-later
!> Contacts between the corners of an overlap, for joints with more than two contact points.
!>
!> A point is a material point of the shorter edge at a given fraction of the overlap; its `vertex`
!> is the number of that edge.  The point therefore moves with a block that slides on a longer one.
!> A point is not moved while it is bonded, or while the overlap has changed by less than a
!> hundredth of its length.  A new point begins with the history of the nearest contact of its
!> overlap, so that the stress is continuous.
!>
!> If an edge continues in a straight line, the overlap ends at a point there, not at a corner.
module dda_contact_points
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type
   use dda_contact, only: contacts_type, reserve
   use dda_contact_geometry, only: candidate_type, on_edge, set_contacts, set_point
   use dda_friction, only: laws_type, weaker_joint
   use dda_growth, only: grow
   use dda_overlap, only: overlap_type, overlap_of, has_points, node, narrow, wide
   implicit none
   private
   public :: point_list_type, add_points, move_points

   !> moves below this fraction of the overlap are ignored
   real(wp), parameter :: least_change = 1.0e-2_wp

   !> A list of contacts with points, before the geometry is computed.
   type :: point_list_type
      integer :: n = 0                                   !< contacts
      integer :: pair = 1  !< first contact of the near pair being processed
      type(candidate_type), allocatable :: candidate(:)  !< [n]
      integer, allocatable :: point(:)                   !< [n] number in the overlap; 0: corner
      real(wp), allocatable :: fraction(:)  !< [n] position as a fraction of the edge
   end type point_list_type

contains

   !> Insert the points of all overlaps after the corners of the same pair of blocks.
   subroutine add_points(list, contacts, blocks, laws, distance)
      type(point_list_type), intent(inout) :: list    !< list; its memory is reused
      type(contacts_type), intent(inout) :: contacts  !< contacts at corners, without history
      type(blocks_type), intent(in) :: blocks         !< present geometry
      type(laws_type), intent(in) :: laws             !< numbers of points of the joints
      real(wp), intent(in) :: distance                !< largest distance of a listed contact, m
      integer :: first, last, c

      list%n = 0
      if (.not. allocated(list%candidate)) allocate (list%candidate(0), list%point(0), &
         list%fraction(0))
      first = 1
      do while (first <= contacts%n)
         last = first
         do while (last < contacts%n)
            if (contacts%pair(last + 1) /= contacts%pair(first)) exit
            last = last + 1
         end do
         list%pair = list%n + 1
         do c = first, last
            call append_point(list, candidate_type(contacts%vertex(c), contacts%edge(c), &
               contacts%corner(c), contacts%pair(c)), 0, 0.0_wp)
         end do
         do c = first, last
            call add_overlap(list, contacts, c, contacts%vertex(c), blocks, laws, distance)
            call add_overlap(list, contacts, c, blocks%previous(contacts%vertex(c)), blocks, &
               laws, distance)
         end do
         first = last + 1
      end do
      contacts%n = list%n
      call reserve(contacts, list%n)
      call set_contacts(contacts, 1, blocks, list%n, list%candidate)
      contacts%point(:list%n) = list%point(:list%n)
      do c = 1, list%n
         if (list%point(c) > 0) call set_point(contacts, c, blocks, list%fraction(c))
      end do
   end subroutine add_points

   !> Add the points of the overlap between the touched edge of corner c and an edge at the corner.
   !> Points already added for another corner are omitted.
   subroutine add_overlap(list, contacts, c, shorter, blocks, laws, distance)
      type(point_list_type), intent(inout) :: list  !< receives the points
      type(contacts_type), intent(in) :: contacts   !< contacts at corners
      integer, intent(in) :: c, shorter             !< contact; edge that ends at its vertex
      type(blocks_type), intent(in) :: blocks       !< present geometry
      type(laws_type), intent(in) :: laws           !< numbers of points of the joints
      real(wp), intent(in) :: distance              !< largest distance of a listed contact, m
      type(overlap_type) :: overlap
      real(wp) :: fraction
      integer :: e, f, i, n

      n = laws%points(weaker_joint(laws, blocks%joint(contacts%edge(c)), blocks%joint(shorter)))
      if (n == 2) return
      call sort_edges(blocks, contacts%edge(c), shorter, e, f)
      if (any(list%point(list%pair:list%n) > 0 .and. list%candidate(list%pair:list%n)%edge == e &
         .and. list%candidate(list%pair:list%n)%vertex == f)) return
      overlap = overlap_of(blocks, e, f, wide)
      if (.not. has_points(blocks, e, f, overlap)) return
      do i = 1, n
         if (i == 1 .and. overlap%corner_from) cycle
         if (i == n .and. overlap%corner_to) cycle
         fraction = point_fraction(overlap, n, i)
         if (abs(point_distance(blocks, e, f, fraction)) <= distance) call append_point(list, &
            candidate_type(f, e, 0, contacts%pair(c)), i, fraction)
      end do
   end subroutine add_overlap

   !> Sort two edges by length: the longer one is touched, the shorter one has the points.
   pure subroutine sort_edges(blocks, a, b, touched, shorter)
      type(blocks_type), intent(in) :: blocks  !< reference shapes
      integer, intent(in) :: a, b              !< edges
      integer, intent(out) :: touched, shorter  !< longer edge, shorter edge
      real(wp) :: length(2)

      length = [norm2(blocks%reference(:, blocks%next(a)) - blocks%reference(:, a)), &
         norm2(blocks%reference(:, blocks%next(b)) - blocks%reference(:, b))]
      touched = min(a, b)
      shorter = max(a, b)
      if (abs(length(1) - length(2)) <= least_change*maxval(length)) return
      touched = merge(a, b, length(1) > length(2))
      shorter = merge(b, a, length(1) > length(2))
   end subroutine sort_edges

   !> Return the fraction of the edge length at which point i of n lies.
   pure real(wp) function point_fraction(overlap, n, i) result(fraction)
      type(overlap_type), intent(in) :: overlap  !< overlap of the edge with another edge
      integer, intent(in) :: n, i                !< number of points; number of this point

      fraction = overlap%from + node(n, i)*(overlap%to - overlap%from)
   end function point_fraction

   !> Return the signed distance of a point of edge f to edge e, m.
   pure real(wp) function point_distance(blocks, e, f, fraction) result(distance)
      type(blocks_type), intent(in) :: blocks  !< present geometry
      integer, intent(in) :: e, f              !< edges
      real(wp), intent(in) :: fraction         !< position as a fraction of f
      real(wp) :: from(2)

      from = on_edge(blocks%vertex, f, blocks%next(f), fraction) - blocks%vertex(:, e)
      distance = blocks%along(2, e)*from(1) - blocks%along(1, e)*from(2)
   end function point_distance

   !> Append a contact to the list of points.
   subroutine append_point(list, candidate, point, fraction)
      type(point_list_type), intent(inout) :: list    !< receives a contact
      type(candidate_type), intent(in) :: candidate   !< vertex and edge
      integer, intent(in) :: point                    !< number in the overlap; 0: corner
      real(wp), intent(in) :: fraction                !< position as a fraction of the edge
      type(candidate_type), allocatable :: longer(:)

      list%n = list%n + 1
      if (list%n > size(list%candidate)) then
         allocate (longer(2*list%n))
         longer(:list%n - 1) = list%candidate
         call move_alloc(longer, list%candidate)
         call grow(list%point, 2*list%n)
         call grow(list%fraction, 2*list%n)
      end if
      list%candidate(list%n) = candidate
      list%point(list%n) = point
      list%fraction(list%n) = fraction
   end subroutine append_point

   !> Set the position, history and geometry of all points.
   pure subroutine move_points(contacts, blocks, laws, matched)
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step, with history
      type(blocks_type), intent(in) :: blocks         !< present geometry
      type(laws_type), intent(in) :: laws             !< numbers of points of the joints
      logical, intent(in) :: matched(:)               !< [n] contacts with a history
      type(overlap_type) :: overlap
      real(wp) :: new_fraction, shift
      integer :: c, n

      do c = 1, contacts%n
         if (contacts%point(c) == 0) cycle
         associate (e => contacts%edge(c), f => contacts%vertex(c))
            n = laws%points(weaker_joint(laws, blocks%joint(e), blocks%joint(f)))
            overlap = overlap_of(blocks, e, f, merge(narrow, wide, matched(c)))
            new_fraction = point_fraction(overlap, n, contacts%point(c))
            shift = abs(new_fraction - contacts%fraction(c))*blocks%length(f)
         end associate
         if (.not. matched(c)) then
            contacts%fraction(c) = new_fraction
            call copy_nearest_history(contacts, c, blocks, laws, matched)
         else if (.not. contacts%bonded(c) .and. shift > least_change*overlap%length .and. &
            overlap%length > 0.0_wp) then
            contacts%fraction(c) = new_fraction
         end if
         call set_point(contacts, c, blocks, contacts%fraction(c))
         contacts%gap(c) = contacts%gap(c) - contacts%offset(c)
      end do
   end subroutine move_points

   !> Copy the history of the nearest contact of the same overlap that has a history.
   pure subroutine copy_nearest_history(contacts, c, blocks, laws, matched)
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step
      integer, intent(in) :: c                        !< point without a history
      type(blocks_type), intent(in) :: blocks         !< present geometry
      type(laws_type), intent(in) :: laws             !< laws of the joints and their columns
      logical, intent(in) :: matched(:)               !< [n] contacts with a history
      real(wp) :: distance, least_distance
      integer :: k, nearest, step

      least_distance = huge(1.0_wp)
      nearest = 0
      do step = -1, 1, 2
         k = c + step
         do while (k >= 1 .and. k <= contacts%n)
            if (contacts%pair(k) /= contacts%pair(c)) exit
            distance = abs(contact_fraction(contacts, k, blocks, contacts%edge(c), &
               contacts%vertex(c)) - contacts%fraction(c))
            if (matched(k) .and. distance < least_distance) then
               least_distance = distance
               nearest = k
            end if
            k = k + step
         end do
      end do
      if (nearest == 0) return
      contacts%offset(c) = contacts%offset(nearest)
      contacts%state(c) = contacts%state(nearest)
      contacts%stretch(c) = contacts%stretch(nearest)
      contacts%slip_sign(c) = contacts%slip_sign(nearest)
      contacts%memory(:, c) = merge(contacts%memory(:, c), contacts%memory(:, nearest), &
         laws%columns%of_contact)
   end subroutine copy_nearest_history

   !> Return contact k's position as a fraction of edge f; huge if not on the overlap of e and f.
   pure real(wp) function contact_fraction(contacts, k, blocks, e, f) result(fraction)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      integer, intent(in) :: k                     !< number of the contact
      type(blocks_type), intent(in) :: blocks      !< present geometry
      integer, intent(in) :: e, f                  !< edges
      real(wp) :: along(2)

      fraction = huge(1.0_wp)
      associate (v => contacts%vertex(k), touched => contacts%edge(k))
         if (contacts%point(k) > 0) then
            if (v == f .and. touched == e) fraction = contacts%fraction(k)
         else if ((touched == e .and. any(v == [f, blocks%next(f)])) .or. &
            (touched == f .and. any(v == [e, blocks%next(e)]))) then
            along = blocks%vertex(:, blocks%next(f)) - blocks%vertex(:, f)
            fraction = dot_product(blocks%vertex(:, v) - blocks%vertex(:, f), along) &
               /dot_product(along, along)
         end if
      end associate
   end function contact_fraction

end module dda_contact_points
