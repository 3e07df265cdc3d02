! SPDX-License-Identifier: GPL-3.0-or-later
!> Evaluation of all contacts at a trial d: gaps, slips, forces by the contact laws, and differences
!> between these forces and the forces assumed in the solution.
module dda_contact_evaluation
   use dda_kinds, only: wp
   use dda_contact, only: contacts_type, contact_open, contact_slide, contact_stick
   use dda_contact_gradients, only: assumed_forces, measure_range, motion_in_step
   use dda_coulomb, only: respond
   use dda_friction, only: bond_length_of, find_response, is_simple, law_of, laws_type
   use dda_joint_contact, only: most_closings
   use dda_joint_law, only: response_type
   use dda_ordered_sums, only: pieces, first_of, last_of, parallel_from
   implicit none
   private
   public :: evaluate_contacts, evaluate_some

contains

   !> Compute forces and states of all contacts by their laws at d.
   subroutine evaluate_contacts(contacts, laws, d, largest, residual)
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      real(wp), intent(in), contiguous :: d(:,:)  !< [6,blocks] increments of the coordinates
      real(wp), intent(inout) :: largest   !< largest force so far, N/m
      real(wp), intent(out) :: residual    !< largest difference from the assumed forces, N/m
      integer :: p

      residual = 0.0_wp
      if (contacts%n < parallel_from) then
         call measure_range(contacts, d, 1, contacts%n)
         call evaluate_range(contacts, laws, 1, contacts%n, largest, residual)
         return
      end if
      !$omp parallel do reduction(max:largest, residual) schedule(static)
      do p = 1, pieces(contacts%n)
         call measure_range(contacts, d, first_of(p, contacts%n), last_of(p, contacts%n))
         call evaluate_range(contacts, laws, first_of(p, contacts%n), &
            last_of(p, contacts%n), largest, residual)
      end do
   end subroutine evaluate_contacts

   !> Compute forces and states of some contacts at d; the blocks of the others have not changed.
   pure subroutine evaluate_some(contacts, laws, d, list, largest, residual)
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step, all evaluated
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      real(wp), intent(in), contiguous :: d(:,:)  !< [6,blocks] increments of the coordinates
      integer, intent(in) :: list(:)  !< numbers of the contacts
      real(wp), intent(inout) :: largest   !< largest force so far, N/m
      real(wp), intent(out) :: residual    !< largest difference from the assumed forces, N/m
      integer :: i, c

      residual = 0.0_wp
      do i = 1, size(list)
         call measure_range(contacts, d, list(i), list(i))
         call evaluate_range(contacts, laws, list(i), list(i), largest, residual)
      end do
      do c = 1, contacts%n
         largest = max(largest, abs(contacts%normal_force(c)), abs(contacts%shear_force(c)))
         residual = max(residual, contacts%force_residual(c))
      end do
   end subroutine evaluate_some

   !> Evaluate contacts first … last; update the largest force and the largest difference.
   pure subroutine evaluate_range(contacts, laws, first, last, largest, residual)
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: first, last  !< first and last contact
      real(wp), intent(inout) :: largest, residual  !< largest force and difference, N/m
      type(response_type) :: response
      real(wp) :: assumed(2)
      logical :: simple
      integer :: c

      simple = is_simple(laws) .and. .not. (contacts%with_multipliers .or. &
         allocated(contacts%frozen_bound))
      do c = first, last
         if (simple) then
            call respond(law_of(laws, contacts%joint(c), contacts%bonded(c), &
               bond_length_of(contacts, c), 0.0_wp), contacts%new_gap(c), &
               contacts%stretch(c) + contacts%slip(c), response)
         else
            call find_response(contacts, laws, c, contacts%new_gap(c), &
               contacts%stretch(c) + contacts%slip(c), response)
         end if
         assumed = assumed_forces(contacts, c, motion_in_step(contacts, c))
         contacts%force_residual(c) = max(abs(response%normal_force - assumed(1)), &
            abs(response%shear_force - assumed(2)))
         residual = max(residual, contacts%force_residual(c))
         contacts%trial_state(c) = next_state(contacts, laws, response, c)
         if (contacts%with_net_slip) then
            contacts%trial_past_centre(c) = response%past_centre
            contacts%slider(c) = response%slider
         end if
         contacts%normal_force(c) = response%normal_force
         contacts%shear_force(c) = response%shear_force
         if (contacts%with_strengths) contacts%strength_ratio(c) = response%strength_ratio
         largest = max(largest, abs(response%normal_force), abs(response%shear_force))
      end do
   end subroutine evaluate_range

   !> Return the state that the next iteration assumes.
   !> If slip reverses, the contact first sticks, because its force would otherwise jump to the
   !> opposite friction bound.  A contact that closes repeatedly first slides, because a shear force
   !> could open the contact again.
   pure integer function next_state(contacts, laws, response, c)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      type(response_type), intent(in) :: response  !< response of the law
      integer, intent(in) :: c  !< number of the contact
      real(wp) :: friction

      next_state = response%state
      if (allocated(contacts%frozen_bound)) return
      friction = response%shear_force
      if (contacts%with_net_slip) friction = response%slider
      if (contacts%state(c) == contact_slide .and. response%state == contact_slide &
         .and. friction*contacts%slip_sign(c) < 0.0_wp) next_state = contact_stick
      if (contacts%state(c) /= contact_open .or. contacts%close_count(c) < most_closings .or. &
         contacts%bonded(c)) return
      if (response%state == contact_stick .and. &
         .not. laws%slot(contacts%joint(c))%law%has_slip_curve) next_state = contact_slide
   end function next_state

end module dda_contact_evaluation
