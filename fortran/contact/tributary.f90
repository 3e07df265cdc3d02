! SPDX-License-Identifier: GPL-3.0-or-later
!> Tributary length: the length of joint assigned to a contact.
!>
!> The contacts at both ends of an overlap share its length, so that the stiffness of a joint does
!> not depend on the number of touching corners.  A length is set when the contact closes and
!> updated when the overlap has changed by more than a hundredth.  An update does not change the
!> stress; the change of spring energy enters the energy budget.  If no edge at the vertex is
!> parallel to the touched edge, the length is half the shorter edge.
module dda_tributary
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type
   use dda_contact, only: contacts_type, contact_open
   use dda_friction, only: laws_type
   use dda_joint_contact, only: start_energy
   use dda_overlap, only: overlap_type, overlap_of, has_points, weight, narrow, wide
   implicit none
   private
   public :: contact_overlap, set_lengths

   real(wp), parameter :: least_change = 1.0e-2_wp  !< smaller relative changes are ignored
   real(wp), parameter :: least = 1.0e-9_wp       !< smallest length of a contact/edge length

contains

   !> Set the lengths of the contacts of a new list; joints and history must be set.
   pure subroutine set_lengths(contacts, blocks, laws, gained)
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step
      type(blocks_type), intent(in) :: blocks         !< present geometry
      type(laws_type), intent(in) :: laws             !< joint laws
      real(wp), intent(out) :: gained  !< energy gain of the springs, J per metre
      real(wp) :: length, stiffness_fraction, former_energy
      integer :: c

      gained = 0.0_wp
      do c = 1, contacts%n
         if (contacts%bonded(c)) cycle
         call find_length(contacts, blocks, laws, c, length, stiffness_fraction)
         if (abs(length - contacts%length(c)) <= least_change*contacts%length(c) .and. &
            abs(stiffness_fraction - contacts%stiffness_fraction(c)) <= &
            least_change*stiffness_fraction) cycle
         if (contacts%length(c) > 0.0_wp .and. contacts%state(c) /= contact_open .and. &
            .not. has_parallel_edge(contacts, blocks, c)) cycle
         associate (law => laws%slot(contacts%joint(c))%law, closed => contacts%was_closed(c))
            former_energy = 0.0_wp
            if (contacts%length(c) > 0.0_wp .and. contacts%state(c) /= contact_open) &
               former_energy = start_energy(contacts, law, c, closed)
            contacts%length(c) = length
            contacts%stiffness_fraction(c) = stiffness_fraction
            if (former_energy > 0.0_wp) &
               gained = gained + start_energy(contacts, law, c, closed) - former_energy
         end associate
      end do
   end subroutine set_lengths

   !> Find the tributary length of contact c, m, and its fraction of the stiffness of a contact.
   pure subroutine find_length(contacts, blocks, laws, c, length, stiffness_fraction)
      type(contacts_type), intent(in) :: contacts  !< with geometry
      type(blocks_type), intent(in) :: blocks      !< present geometry
      type(laws_type), intent(in) :: laws          !< joint laws
      integer, intent(in) :: c                     !< number of the contact
      real(wp), intent(out) :: length, stiffness_fraction  !< length, m; fraction
      real(wp) :: weighted
      integer :: n

      stiffness_fraction = 1.0_wp
      n = laws%points(contacts%joint(c))
      if (n > 2) then
         weighted = weighted_overlap(contacts, blocks, c, n)
         if (weighted > 0.0_wp) then
            length = weighted
            stiffness_fraction = 2*weight(n, max(1, contacts%point(c)))
            return
         end if
      end if
      length = tributary_length(contacts, blocks, c)
   end subroutine find_length

   !> Return the tributary length of contact c, m.
   pure real(wp) function tributary_length(contacts, blocks, c) result(length)
      type(contacts_type), intent(in) :: contacts  !< with geometry
      type(blocks_type), intent(in) :: blocks      !< present geometry
      integer, intent(in) :: c                     !< number of the contact
      integer :: e, v, end_edge

      e = contacts%edge(c)
      v = contacts%vertex(c)
      if (has_parallel_edge(contacts, blocks, c)) then
         length = max(least*blocks%length(e), contact_overlap(blocks, e, v))
         return
      end if
      end_edge = v
      if (abs(dot_product(contacts%normal(:, c), blocks%along(:, blocks%previous(v)))) < &
         abs(dot_product(contacts%normal(:, c), blocks%along(:, v)))) end_edge = blocks%previous(v)
      length = 0.5_wp*min(blocks%length(e), blocks%length(end_edge))
   end function tributary_length

   !> .true. if an edge at the vertex is parallel to the touched edge.
   pure logical function has_parallel_edge(contacts, blocks, c)  ! total
      type(contacts_type), intent(in) :: contacts  !< with geometry
      type(blocks_type), intent(in) :: blocks      !< present geometry
      integer, intent(in) :: c                     !< number of the contact

      associate (normal => contacts%normal(:, c), v => contacts%vertex(c))
         has_parallel_edge = abs(dot_product(normal, blocks%along(:, v))) <= narrow .or. &
            abs(dot_product(normal, blocks%along(:, blocks%previous(v)))) <= narrow
      end associate
   end function has_parallel_edge

   !> Return the tributary length, m, of vertex v on edge e in the overlaps of e with edges at v.
   pure real(wp) function contact_overlap(blocks, e, v) result(length)
      type(blocks_type), intent(in) :: blocks  !< present geometry
      integer, intent(in) :: e, v              !< touched edge, touching vertex

      length = shared_overlap(blocks, e, v) + shared_overlap(blocks, e, blocks%previous(v))
   end function contact_overlap

   !> Return the tributary length, m, of a contact in the overlap of e and f; 0 if not parallel.
   !>
   !> The contacts at the two ends share the overlap.  If an edge continues in a straight line at
   !> one end, such as at a change of joint, the whole overlap belongs to the contact at the other
   !> end.
   pure real(wp) function shared_overlap(blocks, e, f) result(length)
      type(blocks_type), intent(in) :: blocks  !< present geometry
      integer, intent(in) :: e, f              !< edges, given by their first vertices
      type(overlap_type) :: overlap

      overlap = overlap_of(blocks, e, f, narrow)
      length = overlap%length
      if (overlap%corner_from .and. overlap%corner_to) length = 0.5_wp*length
   end function shared_overlap

   !> Return the tributary length of contact c, m, if its joint has points between corners.
   pure real(wp) function weighted_overlap(contacts, blocks, c, n) result(length)
      type(contacts_type), intent(in) :: contacts  !< with geometry
      type(blocks_type), intent(in) :: blocks      !< present geometry
      integer, intent(in) :: c                     !< number of the contact
      integer, intent(in) :: n                     !< number of points of the joint
      type(overlap_type) :: overlap
      integer :: end_edge(2), k

      length = 0.0_wp
      end_edge = [contacts%vertex(c), blocks%previous(contacts%vertex(c))]
      do k = 1, merge(1, 2, contacts%point(c) > 0)
         overlap = overlap_of(blocks, contacts%edge(c), end_edge(k), &
            merge(wide, narrow, contacts%point(c) > 0))
         if (has_points(blocks, contacts%edge(c), end_edge(k), overlap)) &
            length = length + weight(n, max(1, contacts%point(c)))*overlap%length
      end do
   end function weighted_overlap

end module dda_tributary
