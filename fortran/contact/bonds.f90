! SPDX-License-Identifier: GPL-3.0-or-later
!> Bonds: at the start, joints of parallel edges in touch hold cohesion and tension.
module dda_bonds
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type, is_convex
   use dda_contact, only: contacts_type, contact_stick
   use dda_friction, only: laws_type
   implicit none
   private
   public :: bond_contacts

   real(wp), parameter :: touching = 1.0e-6_wp    !< of the edge's length: no gap
   real(wp), parameter :: parallel = 0.0523_wp    !< sine of 3°

contains

   !> Bond each contact in touch along parallel edges, over its share of their overlap.
   subroutine bond_contacts(contacts, blocks, laws)
      type(contacts_type), intent(inout) :: contacts  !< first list of the run
      type(blocks_type), intent(in) :: blocks         !< in their first state
      type(laws_type), intent(in) :: laws             !< strengths of the joint materials
      real(wp) :: length
      integer :: c, e, v

      do c = 1, contacts%n
         e = contacts%edge(c)
         v = contacts%vertex(c)
         if (max(laws%cohesion(contacts%joint(c)), laws%tension(contacts%joint(c))) <= 0.0_wp) cycle
         length = shared_overlap(blocks, e, v) + shared_overlap(blocks, e, blocks%previous(v))
         if (length <= 0.0_wp .or. contacts%gap(c) > touching*norm2(edge_vector(blocks, e))) cycle
         contacts%bonded(c) = .true.
         contacts%bond_length(c) = length
         contacts%state(c) = contact_stick
      end do
   end subroutine bond_contacts

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

end module dda_bonds
