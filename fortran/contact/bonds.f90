! SPDX-License-Identifier: GPL-3.0-or-later
!> Bonds: at the start, joints of parallel edges in touch hold cohesion and tension.
!>
!> Where bonded corners meet, as four of a lattice or three at a step of its surface, those across
!> have no contact: the blocks cannot touch before a bond breaks there, and a contact would take
!> part of what the bonds carry.
module dda_bonds
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type
   use dda_contact, only: contacts_type, contact_stick
   use dda_friction, only: laws_type
   use dda_tributary, only: contact_overlap
   implicit none
   private
   public :: bond_contacts, find_opposites, part_opposites

   real(wp), parameter :: touching = 1.0e-6_wp    !< of the edge's length: no gap

contains

   !> Bond each contact in touch along parallel edges, over its share of their overlap.
   !>
   !> Under a joint law, contacts in touch also begin with their peak strength, unless that has a
   !> cohesion or tension which they cannot hold.
   subroutine bond_contacts(contacts, blocks, laws)
      type(contacts_type), intent(inout) :: contacts  !< first list of the run
      type(blocks_type), intent(in) :: blocks         !< in their first state
      type(laws_type), intent(in) :: laws             !< strengths of the joint materials
      real(wp) :: length
      logical :: holds
      integer :: c

      do c = 1, contacts%n
         associate (e => contacts%edge(c), joint => contacts%joint(c))
            holds = max(laws%cohesion(joint), laws%tension(joint)) > 0.0_wp
            if (laws%plain .and. .not. holds) cycle
            if (contacts%gap(c) > touching*blocks%length(e)) cycle
            if (.not. (laws%plain .or. holds)) contacts%weakened(c) = 0.0_wp
            if (.not. holds) cycle
            length = contact_overlap(blocks, e, contacts%vertex(c))
         end associate
         if (length <= 0.0_wp) cycle
         contacts%bonded(c) = .true.
         contacts%bond_length(c) = length
         contacts%state(c) = contact_stick
         if (.not. laws%plain) contacts%weakened(c) = 0.0_wp
      end do
   end subroutine bond_contacts

   !> Corners across a place where bonded corners meet: joined by bonds with others there, and
   !> without a face in common.  Their contacts are marked.
   pure subroutine find_opposites(contacts, blocks, opposite, across)
      type(contacts_type), intent(in) :: contacts   !< first list of the run, bonded
      type(blocks_type), intent(in) :: blocks       !< in their first state
      integer, intent(inout) :: opposite(:,:)       !< [any,vertices] vertices across, else 0
      logical, intent(out) :: across(:)             !< [n] contacts of such corners
      integer :: place(size(opposite, 2)), room(2), c

      call number_places(contacts, place)
      across = .false.
      do c = 1, contacts%n
         associate (v => contacts%vertex(c), w => contacts%corner(c))
            if (contacts%bonded(c) .or. w == 0) cycle
            if (place(v) /= place(w)) cycle
            if (contact_overlap(blocks, contacts%edge(c), v) > 0.0_wp) cycle
            room = [findloc(opposite(:, v), 0, 1), findloc(opposite(:, w), 0, 1)]
            across(c) = all(room > 0)
            if (.not. across(c)) cycle
            opposite(room(1), v) = w
            opposite(room(2), w) = v
         end associate
      end do
   end subroutine find_opposites

   !> Number the vertices by the places where bonds join corners: equal numbers at a place.
   pure subroutine number_places(contacts, place)
      type(contacts_type), intent(in) :: contacts  !< first list of the run, bonded
      integer, intent(out) :: place(:)             !< [vertices]
      logical :: changed
      integer :: c, v

      place = [(v, v=1, size(place))]
      changed = .true.
      do while (changed)
         changed = .false.
         do c = 1, contacts%n
            associate (v => contacts%vertex(c), w => contacts%corner(c))
               if (.not. contacts%bonded(c) .or. w == 0) cycle
               if (place(v) == place(w)) cycle
               place([v, w]) = min(place(v), place(w))
               changed = .true.
            end associate
         end do
      end do
   end subroutine number_places

   !> Where a bond has broken in this step, the corners there can meet again.
   pure subroutine part_opposites(contacts, opposite)
      type(contacts_type), intent(in) :: contacts  !< this step's list, solved
      integer, intent(inout) :: opposite(:,:)      !< [any,vertices] vertices across, else 0
      integer :: c

      do c = 1, contacts%n
         if (.not. contacts%was_bonded(c) .or. contacts%bonded(c)) cycle
         call part(opposite, contacts%vertex(c))
         if (contacts%corner(c) > 0) call part(opposite, contacts%corner(c))
      end do
   end subroutine part_opposites

   !> A vertex and those across can meet.
   pure subroutine part(opposite, v)
      integer, intent(inout) :: opposite(:,:)  !< [any,vertices] vertices across, else 0
      integer, intent(in) :: v                 !< vertex
      integer :: i

      do i = 1, size(opposite, 1)
         associate (w => opposite(i, v))
            if (w > 0) where (opposite(:, w) == v) opposite(:, w) = 0
         end associate
      end do
      opposite(:, v) = 0
   end subroutine part

end module dda_bonds
