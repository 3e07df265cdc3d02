! SPDX-License-Identifier: GPL-3.0-or-later
!> Tributary lengths: the length of joint that a contact stands for.
!>
!> Where two edges lie along each other, the contacts at the two ends of their overlap share it, so
!> that a joint has the same stiffness however many corners touch.  A length is taken when the
!> contact closes, and kept while the overlap differs by less than a hundredth; when it is taken
!> anew the stress stays, and the energy that the springs gain or lose is booked.  A corner on an
!> edge with no parallel has half the shorter of the two edges, as if they were about to close.
module dda_tributary
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type, is_convex
   use dda_contact, only: contacts_type, contact_open
   use dda_friction, only: laws_type
   use dda_joint_contact, only: closure_of, joint_energy, state_of
   implicit none
   private
   public :: contact_overlap, set_lengths

   real(wp), parameter :: touching = 1.0e-6_wp    !< of the edge's length: no gap
   real(wp), parameter :: parallel = 0.0523_wp    !< sine of 3°
   real(wp), parameter :: same = 1.0e-2_wp        !< of a length, a change that is none
   real(wp), parameter :: least = 1.0e-9_wp       !< of the edge's length, of a contact

contains

   !> Lengths of the contacts of a new list, with joints and history.
   pure subroutine set_lengths(contacts, blocks, laws, gained)
      type(contacts_type), intent(inout) :: contacts  !< this step's list
      type(blocks_type), intent(in) :: blocks         !< present geometry
      type(laws_type), intent(in) :: laws             !< joint laws
      real(wp), intent(out) :: gained                 !< by the springs, J per metre of thickness
      real(wp) :: length, before
      integer :: c

      gained = 0.0_wp
      do c = 1, contacts%n
         if (contacts%bonded(c)) cycle
         length = tributary_length(contacts, blocks, c)
         if (abs(length - contacts%length(c)) <= same*contacts%length(c)) cycle
         if (contacts%length(c) > 0.0_wp .and. contacts%state(c) /= contact_open .and. &
            .not. lies_along(contacts, blocks, c)) cycle
         before = energy_of(contacts, laws, c)
         if (contacts%length(c) <= 0.0_wp .or. contacts%state(c) == contact_open) before = 0.0_wp
         contacts%length(c) = length
         if (before > 0.0_wp) gained = gained + energy_of(contacts, laws, c) - before
      end do
   end subroutine set_lengths

   !> Energy of the springs of contact c in the present geometry, J per metre of thickness.
   pure real(wp) function energy_of(contacts, laws, c)
      type(contacts_type), intent(in) :: contacts  !< this step's list
      type(laws_type), intent(in) :: laws          !< joint laws
      integer, intent(in) :: c                     !< number of the contact

      associate (law => laws%slot(contacts%joint(c))%law)
         energy_of = joint_energy(law, state_of(contacts, c), closure_of(contacts, law, c, &
            contacts%gap(c)), contacts%stretch(c), contacts%was_closed(c))
      end associate
   end function energy_of

   !> The length of joint that contact c stands for, m.
   pure real(wp) function tributary_length(contacts, blocks, c) result(length)
      type(contacts_type), intent(in) :: contacts  !< with geometry
      type(blocks_type), intent(in) :: blocks      !< present geometry
      integer, intent(in) :: c                     !< number of the contact
      integer :: e, v, own

      e = contacts%edge(c)
      v = contacts%vertex(c)
      if (lies_along(contacts, blocks, c)) then
         length = max(least*blocks%length(e), contact_overlap(blocks, e, v))
         return
      end if
      own = v
      if (abs(dot_product(contacts%normal(:, c), blocks%along(:, blocks%previous(v)))) < &
         abs(dot_product(contacts%normal(:, c), blocks%along(:, v)))) own = blocks%previous(v)
      length = 0.5_wp*min(blocks%length(e), blocks%length(own))
   end function tributary_length

   !> One of the edges at the vertex lies along the edge touched.
   pure logical function lies_along(contacts, blocks, c)
      type(contacts_type), intent(in) :: contacts  !< with geometry
      type(blocks_type), intent(in) :: blocks      !< present geometry
      integer, intent(in) :: c                     !< number of the contact

      associate (normal => contacts%normal(:, c), v => contacts%vertex(c))
         lies_along = abs(dot_product(normal, blocks%along(:, v))) <= parallel .or. &
            abs(dot_product(normal, blocks%along(:, blocks%previous(v)))) <= parallel
      end associate
   end function lies_along

   !> Share, m, of a contact of vertex v and edge e in the overlaps of e and the two edges at v.
   pure real(wp) function contact_overlap(blocks, e, v) result(length)
      type(blocks_type), intent(in) :: blocks  !< present geometry
      integer, intent(in) :: e, v              !< edge touched, vertex that touches

      length = shared_overlap(blocks, e, v) + shared_overlap(blocks, e, blocks%previous(v))
   end function contact_overlap

   !> A contact's share, m, of the length over which edge f runs along edge e; 0 unless they are
   !> parallel.
   !>
   !> The contacts at the two ends of the overlap share it; one that ends where an edge goes
   !> straight on, as at a change of joint, has no contact there and belongs to that at the other
   !> end.
   pure real(wp) function shared_overlap(blocks, e, f) result(share)
      type(blocks_type), intent(in) :: blocks  !< present geometry
      integer, intent(in) :: e, f              !< edges, named by their first vertex
      real(wp) :: start(2), along(2), other(2), length, first, last, small
      logical :: at_first, at_last

      share = 0.0_wp
      start = blocks%vertex(:, e)
      along = edge_vector(blocks, e)
      length = norm2(along)
      along = along/length
      other = edge_vector(blocks, f)
      if (abs(along(1)*other(2) - along(2)*other(1)) > parallel*norm2(other)) return
      first = dot_product(along, blocks%vertex(:, f) - start)
      last = dot_product(along, blocks%vertex(:, blocks%next(f)) - start)
      share = max(0.0_wp, min(length, max(first, last)) - max(0.0_wp, min(first, last)))
      small = touching*length
      ! Edge f runs against edge e.
      at_first = (last >= -small .and. is_convex(blocks, blocks%next(f))) &
         .or. (last <= small .and. is_convex(blocks, e))
      at_last = (first <= length + small .and. is_convex(blocks, f)) &
         .or. (first >= length - small .and. is_convex(blocks, blocks%next(e)))
      if (at_first .and. at_last) share = 0.5_wp*share
   end function shared_overlap

   !> Vector from the first to the last vertex of edge e, m.
   pure function edge_vector(blocks, e) result(vector)
      type(blocks_type), intent(in) :: blocks  !< present geometry
      integer, intent(in) :: e                 !< edge, named by its first vertex
      real(wp) :: vector(2)

      vector = blocks%vertex(:, blocks%next(e)) - blocks%vertex(:, e)
   end function edge_vector

end module dda_tributary
