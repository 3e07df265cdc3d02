!> Bonds: at the start, joints of parallel edges in touch are whole and hold cohesion and tension.
module dda_bonds
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type, next_vertex, previous_vertex
   use dda_contact, only: contacts_type, contact_stick
   use dda_friction, only: laws_type
   implicit none
   private
   public :: bond_contacts

   real(wp), parameter :: touching = 1.0e-6_wp    !< of the edge's length: no gap
   real(wp), parameter :: parallel = 0.0523_wp    !< sine of 3°

contains

   !> Bond each contact in touch along parallel edges over half of their overlap (two contacts share
   !> it).
   subroutine bond_contacts(contacts, blocks, laws)
      type(contacts_type), intent(inout) :: contacts
      type(blocks_type), intent(in) :: blocks
      type(laws_type), intent(in) :: laws
      real(wp) :: length, overlap
      integer :: c

      do c = 1, contacts%n
         if (max(laws%cohesion(contacts%joint(c)), laws%tension(contacts%joint(c))) <= 0.0_wp) cycle
         length = norm2(blocks%vertex(:, next_vertex(blocks, contacts%edge(c))) - blocks%vertex(:, &
            contacts%edge(c)))
         overlap = max(overlap_of(blocks, contacts%edge(c), contacts%vertex(c)), &
            overlap_of(blocks, contacts%edge(c), previous_vertex(blocks, contacts%vertex(c))))
         if (overlap <= 0.0_wp .or. contacts%gap(c) > touching*length) cycle
         contacts%bonded(c) = .true.
         contacts%bond_length(c) = 0.5_wp*overlap
         contacts%state(c) = contact_stick
      end do
   end subroutine bond_contacts

   !> Length over which edge f runs along edge e, m; 0 unless they are parallel.
   pure real(wp) function overlap_of(blocks, e, f) result(overlap)
      type(blocks_type), intent(in) :: blocks
      integer, intent(in) :: e, f
      real(wp) :: start(2), along(2), other(2), length, first, last

      overlap = 0.0_wp
      start = blocks%vertex(:, e)
      along = blocks%vertex(:, next_vertex(blocks, e)) - start
      length = norm2(along)
      along = along/length
      other = blocks%vertex(:, next_vertex(blocks, f)) - blocks%vertex(:, f)
      if (abs(along(1)*other(2) - along(2)*other(1)) > parallel*norm2(other)) return
      first = dot_product(along, blocks%vertex(:, f) - start)
      last = dot_product(along, blocks%vertex(:, next_vertex(blocks, f)) - start)
      overlap = max(0.0_wp, min(length, max(first, last)) - max(0.0_wp, min(first, last)))
   end function overlap_of

end module dda_bonds
