! SPDX-License-Identifier: GPL-3.0-or-later
!> Contacts under joint laws in the open–close iteration: linearisation and bond failure.  The
!> "line" of a contact is the linear function of gap and slip that replaces its normal force.
module dda_joint_lines
   use dda_kinds, only: wp
   use dda_contact, only: contacts_type, contact_open, contact_slide, contact_stick
   use dda_contact_gradients, only: assumed_forces, motion_in_step
   use dda_friction, only: acting, find_response, laws_type
   use dda_joint_contact, only: line_of, linearise_normal, linearise_shear, state_of, tilt_line
   use dda_joint_law, only: joint_law_type, joint_state_type, response_type, weakened
   implicit none
   private
   public :: begin_lines, renew_lines, drop_friction, break_joint, has_bond

contains

   !> Set lines that are tangent to the laws at the start of the step.
   pure subroutine begin_lines(contacts, laws)
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      type(joint_state_type) :: state
      integer :: c

      if (contacts%with_net_slip) contacts%past_centre(:contacts%n) = .false.
      do c = 1, contacts%n
         associate (law => laws%slot(contacts%joint(c))%law)
            state = state_of(contacts, law, c)
            call linearise_normal(law, state, max(0.0_wp, law%lift(state) - contacts%gap(c)), &
               contacts%tangent(1, c), contacts%line(1, c))
            call begin_dilation(contacts, law, state, c)
            if (law%has_slip_curve .and. contacts%state(c) == contact_slide) &
               contacts%state(c) = contact_stick  ! sliding follows from the laws
            call linearise_shear(contacts, law, c, contacts%line(1, c) - contacts%tangent(1, c) &
               *contacts%gap(c), contacts%stretch(c) + law%expected_slip(state))
         end associate
      end do
   end subroutine begin_lines

   !> Set the rise per unit of slip of a contact that slid in the last step, for the same direction.
   pure subroutine begin_dilation(contacts, law, start, c)
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step
      class(joint_law_type), intent(in) :: law        !< law of the contact
      type(joint_state_type), intent(in) :: start     !< state of the contact
      integer, intent(in) :: c                        !< number of the contact
      type(joint_state_type) :: state
      real(wp) :: fraction, shear

      contacts%tilt(1, c) = 0.0_wp
      if (contacts%state(c) /= contact_slide .or. .not. start%lifts) return
      state = start
      state%slip_sign = contacts%slip_sign(c)
      shear = law%shear_spring(state)
      contacts%tilt(1, c) = state%slip_sign*law%rise(state, 0.0_wp)
      fraction = shear/(shear + contacts%tangent(1, c)*contacts%tilt(1, c)**2)
      contacts%tangent(1, c) = fraction*contacts%tangent(1, c)
      contacts%line(1, c) = fraction*contacts%line(1, c) - contacts%tangent(1, c) &
         *contacts%tilt(1, c)*contacts%slide_force(c)/shear
   end subroutine begin_dilation

   !> Linearise contacts again if their forces by line and by law differ by more than `tolerance`.
   pure subroutine renew_lines(contacts, laws, tolerance)
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step, evaluated
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      real(wp), intent(in) :: tolerance  !< allowed difference, N/m
      type(response_type) :: response
      real(wp) :: largest, difference(2), trial(2), at(2)
      logical :: may_change
      integer :: c

      if (laws%plain) return
      do c = 1, contacts%n
         associate (law => laws%slot(contacts%joint(c))%law)
            difference = abs([contacts%normal_force(c), contacts%shear_force(c)] &
               - assumed_forces(contacts, c, motion_in_step(contacts, c)))
            largest = merge(maxval(difference), difference(1), law%has_slip_curve)
            may_change = law%dilates
            if (contacts%with_net_slip) then
               may_change = may_change .or. (contacts%past_centre(c) .neqv. &
                  contacts%trial_past_centre(c))
               contacts%past_centre(c) = contacts%trial_past_centre(c)
            end if
            if (largest <= tolerance .and. .not. may_change) cycle
            trial = [contacts%new_gap(c), contacts%stretch(c) + contacts%slip(c)]
            at = acting(contacts, laws, c, trial)
            call find_response(contacts, laws, c, trial(1), trial(2), response)
            call line_of(contacts, law, c, at(1), response, contacts%tangent(1, c), &
               contacts%line(1, c))
            if (law%has_slip_curve) call linearise_shear(contacts, law, c, response%bound, at(2))
            if (law%dilates) call tilt_line(contacts, law, c, at, response)
         end associate
      end do
   end subroutine renew_lines

   !> Remove assumed friction from the lines of dilating contacts, and the dilation of contact c.
   pure subroutine drop_friction(contacts, laws, c)
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step, evaluated
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c  !< number of the contact

      if (.not. laws%dilating) return
      associate (n => contacts%n)
         contacts%line(1, :n) = contacts%line(1, :n) + contacts%tangent(1, :n) &
            *contacts%tilt(1, :n)*contacts%slide_force(:n)/contacts%tangent(2, :n)
      end associate
      contacts%tilt(1, c) = 0.0_wp
      associate (law => laws%slot(contacts%joint(c))%law)
         call linearise_normal(law, state_of(contacts, law, c), 0.0_wp, contacts%tangent(1, c), &
            contacts%line(1, c))
      end associate
   end subroutine drop_friction

   !> .true. if contact c can resist shear or tension without a normal force.
   pure logical function has_bond(contacts, laws, c)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c  !< number of the contact

      has_bond = laws%plain
      if (has_bond) return
      associate (law => laws%slot(contacts%joint(c))%law)
         associate (state => state_of(contacts, law, c))
            has_bond = law%strength(state, 0.0_wp) > 0.0_wp .or. law%tension(state) > 0.0_wp
         end associate
      end associate
   end function has_bond

   !> Remove the peak strength of a contact; its bond remains if the residual tension suffices.
   pure subroutine break_joint(contacts, laws, c)
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step, evaluated
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c  !< number of the contact
      real(wp) :: tension

      if (laws%plain) then
         contacts%bonded(c) = .false.
         return
      end if
      contacts%memory(weakened, c) = 1.0_wp
      associate (law => laws%slot(contacts%joint(c))%law)
         tension = law%tension(state_of(contacts, law, c))
      end associate
      contacts%bonded(c) = contacts%bonded(c) .and. tension > 0.0_wp .and. &
         -contacts%normal_force(c) <= tension
   end subroutine break_joint

end module dda_joint_lines
