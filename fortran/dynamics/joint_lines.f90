! SPDX-License-Identifier: GPL-3.0-or-later
!> Contacts under joint laws in the open–close iteration: the lines that stand for their normal
!> forces, and their breaking.
module dda_joint_lines
   use dda_kinds, only: wp
   use dda_contact, only: contacts_type, contact_open
   use dda_contact_evaluation, only: assumed_normal
   use dda_friction, only: acting_gap, find_response, laws_type
   use dda_joint_contact, only: closure_of, line_of, response_type, state_of, touch_law
   implicit none
   private
   public :: begin_lines, renew_lines, break_joint, has_bond, stiffest_contact

contains

   !> Lines that touch the laws at the closures of the start of the step.
   pure subroutine begin_lines(contacts, laws)
      type(contacts_type), intent(inout) :: contacts  !< this step's list
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer :: c

      if (contacts%with_net_slip) contacts%past_centre(:contacts%n) = .false.
      do c = 1, contacts%n
         associate (law => laws%slot(contacts%joint(c))%law)
            call touch_law(contacts, law, c, max(0.0_wp, closure_of(contacts, law, c, &
               contacts%gap(c))), contacts%tangent(c), contacts%normal_free(c))
         end associate
      end do
   end subroutine begin_lines

   !> Lines for the next iteration, where the law is farther from the present one than allowed.
   pure subroutine renew_lines(contacts, laws, allowed)
      type(contacts_type), intent(inout) :: contacts  !< this step's list, evaluated
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      real(wp), intent(in) :: allowed  !< difference of normal forces, N/m
      type(response_type) :: response
      real(wp) :: gap, off
      integer :: c

      do c = 1, contacts%n
         off = abs(contacts%normal_force(c) - assumed_normal(contacts, c))
         if (off <= allowed .and. .not. passes_centre(contacts, c)) cycle
         if (contacts%with_net_slip) contacts%past_centre(c) = contacts%trial_past_centre(c)
         gap = acting_gap(contacts, laws, c, contacts%new_gap(c))
         call find_response(contacts, laws, c, contacts%new_gap(c), &
            contacts%stretch(c) + contacts%slip(c), response)
         call line_of(contacts, laws%slot(contacts%joint(c))%law, c, gap, response, &
            contacts%tangent(c), contacts%normal_free(c))
      end do
   end subroutine renew_lines

   !> The law lets contact c slip from its centre, or back to it, other than was assumed.
   pure logical function passes_centre(contacts, c)
      type(contacts_type), intent(in) :: contacts  !< this step's list, evaluated
      integer, intent(in) :: c  !< number of the contact

      passes_centre = contacts%with_net_slip
      if (passes_centre) passes_centre = contacts%past_centre(c) .neqv. &
         contacts%trial_past_centre(c)
   end function passes_centre

   !> Contact c would resist shear or tension without a normal force.
   pure logical function has_bond(contacts, laws, c)
      type(contacts_type), intent(in) :: contacts  !< this step's list
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c  !< number of the contact

      associate (law => laws%slot(contacts%joint(c))%law, state => state_of(contacts, c))
         has_bond = law%strength(state, 0.0_wp) > 0.0_wp .or. law%tension(state) > 0.0_wp
      end associate
   end function has_bond

   !> The contact loses its peak strength; its bond goes on only where the residual tension holds.
   pure subroutine break_joint(contacts, laws, c)
      type(contacts_type), intent(inout) :: contacts  !< this step's list, evaluated
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c  !< number of the contact
      real(wp) :: tension

      contacts%weakened(c) = 1.0_wp
      tension = laws%slot(contacts%joint(c))%law%tension(state_of(contacts, c))
      contacts%bonded(c) = contacts%bonded(c) .and. tension > 0.0_wp .and. &
         -contacts%normal_force(c) <= tension
   end subroutine break_joint

   !> Largest normal stiffness of a closed contact, N/m; 0 if there is none.
   pure real(wp) function stiffest_contact(contacts) result(stiffest)
      type(contacts_type), intent(in) :: contacts  !< this step's list
      integer :: c

      stiffest = 0.0_wp
      do c = 1, contacts%n
         if (contacts%state(c) /= contact_open) stiffest = max(stiffest, contacts%tangent(c))
      end do
   end function stiffest_contact

end module dda_joint_lines
