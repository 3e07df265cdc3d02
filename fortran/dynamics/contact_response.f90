!> Forces of a listed contact at the end of a step.
!>
!> A bonded joint acts at t₀ + θΔt, a unilateral contact and its friction at the end of the step
!> (`dda_scheme`).
module dda_contact_response
   use dda_kinds, only: wp
   use dda_contact, only: contacts_type
   use dda_friction, only: laws_type, response_type, law_of, respond
   implicit none
   private
   public :: contact_response, acting_gap, acting_stretch, end_stretch, accept_contacts

contains

   !> What contact c exerts if the step ends at a gap and a trial stretch.
   pure type(response_type) function contact_response(contacts, laws, c, gap, stretch) &
      result(response)
      type(contacts_type), intent(in) :: contacts
      type(laws_type), intent(in) :: laws
      integer, intent(in) :: c        !< number of the contact
      real(wp), intent(in) :: gap     !< at the end of the step, m
      real(wp), intent(in) :: stretch !< of the shear spring if nothing slips, then, m

      response = respond(law_of(laws, contacts%joint(c), contacts%bonded(c), &
         contacts%bond_length(c), contacts%multiplier(c)), acting_gap(contacts, laws, c, gap), &
         acting_stretch(contacts, laws, c, stretch))
   end function contact_response

   !> The trial stretch at which contact c acts, m.
   elemental real(wp) function acting_stretch(contacts, laws, c, stretch)
      type(contacts_type), intent(in) :: contacts
      type(laws_type), intent(in) :: laws
      integer, intent(in) :: c         !< number of the contact
      real(wp), intent(in) :: stretch  !< at the end of the step, m

      acting_stretch = stretch
      if (contacts%bonded(c) .and. laws%theta < 1.0_wp) &
         acting_stretch = contacts%stretch(c) + laws%theta*(stretch - contacts%stretch(c))
   end function acting_stretch

   !> The gap at which contact c acts, m.
   elemental real(wp) function acting_gap(contacts, laws, c, gap)
      type(contacts_type), intent(in) :: contacts
      type(laws_type), intent(in) :: laws
      integer, intent(in) :: c     !< number of the contact
      real(wp), intent(in) :: gap  !< at the end of the step, m

      acting_gap = gap
      if (contacts%bonded(c) .and. laws%theta < 1.0_wp) &
         acting_gap = contacts%gap(c) + laws%theta*(gap - contacts%gap(c))
   end function acting_gap

   !> Elastic stretch of the shear spring of contact c after the converged step, m.
   elemental real(wp) function end_stretch(contacts, laws, c)
      type(contacts_type), intent(in) :: contacts
      type(laws_type), intent(in) :: laws
      integer, intent(in) :: c  !< number of the contact

      end_stretch = contacts%shear_force(c)/laws%shear_stiffness
      if (contacts%bonded(c) .and. laws%theta < 1.0_wp) &
         end_stretch = contacts%stretch(c) + contacts%slip(c)
   end function end_stretch

   !> States and stretches at the end of the converged step.
   pure subroutine accept_contacts(contacts, laws)
      type(contacts_type), intent(inout) :: contacts
      type(laws_type), intent(in) :: laws
      integer :: c

      do c = 1, contacts%n
         contacts%stretch(c) = end_stretch(contacts, laws, c)
         contacts%state(c) = contacts%trial_state(c)
      end do
   end subroutine accept_contacts

end module dda_contact_response
