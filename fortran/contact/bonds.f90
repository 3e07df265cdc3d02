! SPDX-License-Identifier: GPL-3.0-or-later
!> Bonds: at the start, joints of parallel edges in touch hold cohesion and tension.
!>
!> Where four bonded corners meet, those across have no contact: the blocks cannot touch before a
!> bond breaks there, and a contact would take part of what the bonds carry.
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

   !> Corners across a place where four bonded corners meet; their contacts are marked.
   pure subroutine find_opposites(contacts, opposite, across)
      type(contacts_type), intent(in) :: contacts   !< first list of the run, bonded
      integer, intent(inout) :: opposite(:)         !< [vertices] the vertex across, else 0
      logical, intent(out) :: across(:)             !< [n] contacts of such corners
      integer :: bonded_to(2, size(opposite)), c

      bonded_to = 0
      do c = 1, contacts%n
         associate (v => contacts%vertex(c), w => contacts%corner(c))
            if (.not. contacts%bonded(c) .or. w == 0) cycle
            bonded_to(:, v) = [w, bonded_to(1, v)]
            bonded_to(:, w) = [v, bonded_to(1, w)]
         end associate
      end do
      across = .false.
      do c = 1, contacts%n
         associate (v => contacts%vertex(c), w => contacts%corner(c))
            if (contacts%bonded(c) .or. w == 0) cycle
            across(c) = all(bonded_to(:, [v, w]) > 0) .and. (all(bonded_to(:, v) &
               == bonded_to(:, w)) .or. all(bonded_to(:, v) == bonded_to([2, 1], w)))
            if (.not. across(c)) cycle
            opposite(v) = w
            opposite(w) = v
         end associate
      end do
   end subroutine find_opposites

   !> Where a bond has broken in this step, the corners there can meet again.
   pure subroutine part_opposites(contacts, opposite)
      type(contacts_type), intent(in) :: contacts  !< this step's list, solved
      integer, intent(inout) :: opposite(:)        !< [vertices] the vertex across, else 0
      integer :: c

      do c = 1, contacts%n
         if (.not. contacts%was_bonded(c) .or. contacts%bonded(c)) cycle
         call part(opposite, contacts%vertex(c))
         if (contacts%corner(c) > 0) call part(opposite, contacts%corner(c))
      end do
   end subroutine part_opposites

   !> A vertex and the one across can meet.
   pure subroutine part(opposite, v)
      integer, intent(inout) :: opposite(:)  !< [vertices] the vertex across, else 0
      integer, intent(in) :: v               !< vertex

      if (opposite(v) > 0) opposite(opposite(v)) = 0
      opposite(v) = 0
   end subroutine part

end module dda_bonds
