! SPDX-License-Identifier: GPL-3.0-or-later
!> The springs that a contact puts into K̂ or takes out when its state changes or its bond breaks.
module dda_spring_changes
   use dda_kinds, only: wp
   use dda_contact, only: contacts_type, contact_open, contact_slide
   use dda_contact_terms, only: line_spring, normal_spring, shear_spring
   use dda_friction, only: laws_type
   use dda_rank_one, only: rank_one_type, add_change
   implicit none
   private
   public :: note_change, note_difference, springs_of

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

      change = springs_of(contacts, laws, c, state, bonded) &
         - springs_of(contacts, laws, c, contacts%state(c), contacts%bonded(c))
      if (laws%damped) change = change*[contacts%normal_gain(c), contacts%shear_gain(c)]
      call note_difference(changes, contacts, c, change)
   end subroutine note_change

   !> Note other springs of contact c in the state that it has.
   pure subroutine note_difference(changes, contacts, c, change)
      type(rank_one_type), intent(inout) :: changes  !< springs put in or taken out
      type(contacts_type), intent(in) :: contacts  !< this step's list
      integer, intent(in) :: c  !< number of the contact
      real(wp), intent(in) :: change(2)  !< of the normal and of the shear spring, N/m

      associate (v => contacts%block_v(c), e => contacts%block_e(c))
         if (abs(change(1)) > 0.0_wp) call add_change(changes, v, contacts%normal_v(:, c), e, &
            contacts%normal_e(:, c), change(1))
         if (abs(change(2)) > 0.0_wp) call add_change(changes, v, contacts%shear_v(:, c), e, &
            contacts%shear_e(:, c), change(2))
      end associate
   end subroutine note_difference

   !> Normal and shear spring in a state, N/m, without what sliding contacts retain.
   pure function springs_of(contacts, laws, c, state, bonded) result(springs)
      type(contacts_type), intent(in) :: contacts  !< this step's list
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c  !< number of the contact
      integer, intent(in) :: state  !< contact_open, contact_slide or contact_stick
      logical, intent(in) :: bonded  !< the contact is
      real(wp) :: springs(2)

      springs = 0.0_wp
      if (state == contact_open) return
      springs(1) = normal_spring(laws, bonded)
      if (.not. laws%plain) springs(1) = line_spring(contacts, laws, c)
      if (state /= contact_slide) springs(2) = shear_spring(contacts, laws, c, state, bonded, &
         0.0_wp)
   end function springs_of

end module dda_spring_changes
