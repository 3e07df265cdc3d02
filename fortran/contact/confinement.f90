! SPDX-License-Identifier: GPL-3.0-or-later
!> Initial contact forces from the initial stress: the input geometry is the loaded geometry.
!>
!> A touching contact has N = −n·σn L and s = t·σn L; L is its tributary length and σ is the mean of
!> both blocks' stresses at the contact.  Its normal spring has zero force at the gap `offset`,
!> chosen so that the force is N at the start.
module dda_confinement
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type
   use dda_contact, only: contacts_type, contact_stick
   use dda_friction, only: laws_type, shear_stiffness_of
   use dda_joint_contact, only: state_of
   use dda_tributary, only: contact_overlap
   implicit none
   private
   public :: confine_contacts

   real(wp), parameter :: touching = 1.0e-6_wp    !< largest gap of touching edges/edge length

contains

   !> Set the forces of touching contacts from the stress of their blocks.
   pure subroutine confine_contacts(contacts, blocks, laws, gradient, crushed)
      type(contacts_type), intent(inout) :: contacts  !< first list of the run
      type(blocks_type), intent(in) :: blocks         !< blocks in their first state
      type(laws_type), intent(in) :: laws             !< laws of the joints
      real(wp), intent(in) :: gradient(:,:)           !< [2,blocks] ∂σx/∂y and ∂σy/∂y, Pa/m
      integer, intent(out) :: crushed  !< contact whose law cannot reach the force, else 0
      real(wp) :: traction(2), normal, length, closure
      integer :: c

      crushed = 0
      do c = 1, contacts%n
         associate (e => contacts%edge(c), n => contacts%normal(:, c))
            if (contacts%gap(c) > touching*blocks%length(e)) cycle
            if (laws%plain) then
               length = contact_overlap(blocks, e, contacts%vertex(c))
            else
               length = contacts%length(c)
            end if
            traction = length*matmul(mean_stress_at(contacts, blocks, gradient, c), n)
            normal = -dot_product(n, traction)
            if (normal <= 0.0_wp) cycle
            if (laws%plain) then
               closure = normal/laws%normal_stiffness
            else
               associate (law => laws%slot(contacts%joint(c))%law)
                  closure = law%closure(state_of(contacts, law, c), normal)
               end associate
            end if
            if (.not. closure < huge(1.0_wp)) then
               crushed = c
               return
            end if
            contacts%state(c) = contact_stick
            contacts%was_closed(c) = .true.
            contacts%offset(c) = contacts%offset(c) + closure
            contacts%gap(c) = contacts%gap(c) - closure
            contacts%new_gap(c) = contacts%gap(c)
            contacts%stretch(c) = dot_product([-n(2), n(1)], traction) &
               /shear_stiffness_of(contacts, laws, c)
         end associate
      end do
   end subroutine confine_contacts

   !> Return the mean stress of the blocks of contact c at its position, Pa.
   pure function mean_stress_at(contacts, blocks, gradient, c) result(tensor)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      type(blocks_type), intent(in) :: blocks      !< blocks in their first state
      real(wp), intent(in) :: gradient(:,:)        !< [2,blocks] ∂σx/∂y and ∂σy/∂y, Pa/m
      integer, intent(in) :: c                     !< number of the contact
      real(wp) :: tensor(2, 2), stress(3), height
      integer :: side, b

      tensor = 0.0_wp
      height = blocks%vertex(2, contacts%vertex(c))
      if (contacts%with_laws) height = height + contacts%fraction(c) &
         *(blocks%vertex(2, blocks%next(contacts%vertex(c))) - height)
      do side = 1, 2
         b = merge(contacts%block_v(c), contacts%block_e(c), side == 1)
         stress = blocks%initial_stress(:, b)
         stress(1:2) = stress(1:2) + gradient(:, b)*(height - blocks%position(2, b))
         tensor = tensor + 0.5_wp*reshape(stress([1, 3, 3, 2]), [2, 2])
      end do
   end function mean_stress_at

end module dda_confinement
