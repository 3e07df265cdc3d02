!> Bonds: at the start, joints of parallel edges in touch hold cohesion and tension.
module dda_bonds
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type
   use dda_contact, only: contacts_type, contact_stick
   use dda_friction, only: laws_type
   implicit none
   private
   public :: bond_contacts

   real(wp), parameter :: touching = 1.0e-6_wp    !< of the edge's length: no gap
   real(wp), parameter :: parallel = 0.0523_wp    !< sine of 3°

contains

   !> Bond each contact in touch along parallel edges, over half of their overlap: the contacts at
   !> its two ends share it.
   subroutine bond_contacts(contacts, blocks, laws)
      type(contacts_type), intent(inout) :: contacts  !< first list of the run
      type(blocks_type), intent(in) :: blocks         !< in their first state
      type(laws_type), intent(in) :: laws             !< strengths of the joint materials
      real(wp) :: overlap
      integer :: c, e, v

      do c = 1, contacts%n
         e = contacts%edge(c)
         v = contacts%vertex(c)
         if (max(laws%cohesion(contacts%joint(c)), laws%tension(contacts%joint(c))) <= 0.0_wp) cycle
         overlap = max(overlap_of(blocks, e, v), overlap_of(blocks, e, blocks%previous(v)))
         if (overlap <= 0.0_wp .or. contacts%gap(c) > touching*norm2(edge_vector(blocks, e))) cycle
         contacts%bonded(c) = .true.
         contacts%bond_length(c) = 0.5_wp*overlap
         contacts%state(c) = contact_stick
      end do
   end subroutine bond_contacts

   !> Length over which edge f runs along edge e, m; 0 unless they are parallel.
   pure real(wp) function overlap_of(blocks, e, f) result(overlap)
      type(blocks_type), intent(in) :: blocks  !< present geometry
      integer, intent(in) :: e, f              !< edges, named by their first vertex
      real(wp) :: start(2), along(2), other(2), length, first, last

      overlap = 0.0_wp
      start = blocks%vertex(:, e)
      along = edge_vector(blocks, e)
      length = norm2(along)
      along = along/length
      other = edge_vector(blocks, f)
      if (abs(along(1)*other(2) - along(2)*other(1)) > parallel*norm2(other)) return
      first = dot_product(along, blocks%vertex(:, f) - start)
      last = dot_product(along, blocks%vertex(:, blocks%next(f)) - start)
      overlap = max(0.0_wp, min(length, max(first, last)) - max(0.0_wp, min(first, last)))
   end function overlap_of

   !> Vector from the first to the last vertex of edge e, m.
   pure function edge_vector(blocks, e) result(vector)
      type(blocks_type), intent(in) :: blocks  !< present geometry
      integer, intent(in) :: e                 !< edge, named by its first vertex
      real(wp) :: vector(2)

      vector = blocks%vertex(:, blocks%next(e)) - blocks%vertex(:, e)
   end function edge_vector

end module dda_bonds
