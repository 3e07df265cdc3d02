! SPDX-License-Identifier: GPL-3.0-or-later
!> Bonds: cohesion and tensile strength of joints along edges that touch at the start of a run.
module dda_bonds
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type
   use dda_contact, only: contacts_type, contact_stick
   use dda_friction, only: laws_type
   use dda_joint_law, only: weakened
   use dda_tributary, only: contact_overlap
   implicit none
   private
   public :: bond_contacts

   real(wp), parameter :: touching = 1.0e-6_wp    !< largest gap of touching edges/edge length

contains

   !> Bond each touching contact of parallel edges over its tributary length.
   !>
   !> A joint with a law but without cohesion and tension has no bonds; its touching contacts begin
   !> at peak strength.
   subroutine bond_contacts(contacts, blocks, laws)
      type(contacts_type), intent(inout) :: contacts  !< first list of the run
      type(blocks_type), intent(in) :: blocks         !< blocks in their first state
      type(laws_type), intent(in) :: laws             !< strengths of the joint materials
      real(wp) :: length
      logical :: holds
      integer :: c

      do c = 1, contacts%n
         associate (e => contacts%edge(c), joint => contacts%joint(c))
            holds = max(laws%cohesion(joint), laws%tension(joint)) > 0.0_wp
            if (laws%plain .and. .not. holds) cycle
            if (contacts%gap(c) > touching*blocks%length(e)) cycle
            if (.not. (laws%plain .or. holds)) contacts%memory(weakened, c) = 0.0_wp
            if (.not. holds) cycle
            length = contact_overlap(blocks, e, contacts%vertex(c))
         end associate
         if (length <= 0.0_wp) cycle
         if (laws%pointed) length = contacts%length(c)
         contacts%bonded(c) = .true.
         contacts%bond_length(c) = length
         contacts%state(c) = contact_stick
         if (.not. laws%plain) contacts%memory(weakened, c) = 0.0_wp
      end do
   end subroutine bond_contacts

end module dda_bonds
