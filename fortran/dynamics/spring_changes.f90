!> The springs that a contact puts into K̂ or takes out when its state changes.
module dda_spring_changes
   use dda_kinds, only: wp
   use dda_contact, only: contacts_type, contact_open, contact_stick
   use dda_friction, only: laws_type
   use dda_rank_one, only: rank_one_type, add_change
   implicit none
   private
   public :: note_change

contains

   !> Note what a new state of contact c changes: its normal spring, its shear spring, both or none.
   pure subroutine note_change(changes, contacts, laws, c, state)
      type(rank_one_type), intent(inout) :: changes
      type(contacts_type), intent(in) :: contacts
      type(laws_type), intent(in) :: laws
      integer, intent(in) :: c
      integer, intent(in) :: state  !< to come
      integer :: normal, shear      ! 1 put in, −1 taken out

      normal = merge(1, 0, state /= contact_open) - merge(1, 0, contacts%state(c) /= contact_open)
      shear = merge(1, 0, state == contact_stick) - merge(1, 0, contacts%state(c) == contact_stick)
      associate (v => contacts%block_v(c), e => contacts%block_e(c))
         if (normal /= 0) call add_change(changes, v, contacts%normal_v(:, c), e, &
            contacts%normal_e(:, c), normal*laws%normal_stiffness)
         if (shear /= 0) call add_change(changes, v, contacts%shear_v(:, c), e, &
            contacts%shear_e(:, c), shear*laws%shear_stiffness)
      end associate
   end subroutine note_change

end module dda_spring_changes
