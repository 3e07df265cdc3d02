! SPDX-License-Identifier: GPL-3.0-or-later
!> The springs that a contact puts into K̂ or takes out when its state changes or its bond breaks.
module dda_spring_changes
   use dda_kinds, only: wp
   use dda_contact, only: contacts_type, contact_open, contact_slide
   use dda_contact_terms, only: normal_spring, shear_spring
   use dda_friction, only: laws_type
   use dda_rank_one, only: rank_one_type, add_change
   implicit none
   private
   public :: note_change

contains

   !> Note what a new state of contact c changes: its normal spring, its shear spring, both or none.
   pure subroutine note_change(changes, contacts, laws, c, state, bonded)
      type(rank_one_type), intent(inout) :: changes  !< springs put in or taken out
      type(contacts_type), intent(in) :: contacts  !< this step's list
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c  !< number of the contact
      integer, intent(in) :: state   !< to come
      logical, intent(in) :: bonded  !< to come
      real(wp) :: change(2)

      change = springs_of(laws, state, bonded) &
         - springs_of(laws, contacts%state(c), contacts%bonded(c))
      associate (v => contacts%block_v(c), e => contacts%block_e(c))
         if (abs(change(1)) > 0.0_wp) call add_change(changes, v, contacts%normal_v(:, c), e, &
            contacts%normal_e(:, c), change(1))
         if (abs(change(2)) > 0.0_wp) call add_change(changes, v, contacts%shear_v(:, c), e, &
            contacts%shear_e(:, c), change(2))
      end associate
   end subroutine note_change

   !> Normal and shear spring in a state, N/m, without what sliding contacts retain.
   pure function springs_of(laws, state, bonded) result(springs)
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: state  !< contact_open, contact_slide or contact_stick
      logical, intent(in) :: bonded  !< the contact is
      real(wp) :: springs(2)

      springs = 0.0_wp
      if (state == contact_open) return
      springs(1) = normal_spring(laws, bonded)
      if (state /= contact_slide) springs(2) = shear_spring(laws, state, bonded, 0.0_wp)
   end function springs_of

end module dda_spring_changes
