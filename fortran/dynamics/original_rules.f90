! SPDX-License-Identifier: GPL-3.0-or-later
!> Open–close rules of the original DDA, for comparison (`contact_rules = 'original'`).
!>
!> In Shi's code and its successors, an open contact closes only if its penetration exceeds a dead
!> band, and then with full stiffness.  Changes between slip and stick do not affect convergence.
!> Friction of a sliding contact uses the normal force of the last iteration.  The
!> energy audit reports energy created by the dead band as a negative numerical loss.
module dda_original_rules
   use dda_kinds, only: wp
   use dda_system, only: system_type
   use dda_contact, only: contacts_type, contact_open, contact_slide, contact_stick
   use dda_errors, only: error_type, error_convergence, fail
   use dda_coulomb, only: coulomb_contact_type
   use dda_friction, only: bond_length_of, laws_type, law_of
   use dda_contact_gradients, only: assumed_forces, measure_range, motion_in_step
   use dda_open_close, only: open_close_type, fail_if_step_stopped, solve_assumed
   use dda_linear_solver, only: solver_type
   implicit none
   private
   public :: solve_by_original_rules, lock_touching

   integer, parameter :: most_iterations = 8         !< iterations per step
   real(wp), parameter :: close_band = 2.0e-4_wp  !< s0: penetration/half size to close a contact
   real(wp), parameter :: open_band = 2.0e-7_wp      !< f0: gap/half size to open a contact
   real(wp), parameter :: reversal_band = 1.0e-7_wp  !< reverse slip/half size to stick
   !> friction coefficient (tan 0.9°) below which a sliding contact never sticks
   real(wp), parameter :: least_friction = 0.0157_wp

contains

   !> Iterate until no contact opens or closes.
   subroutine solve_by_original_rules(iteration, system, solver, contacts, laws, half_size, &
      first_step, error)
      type(open_close_type), intent(inout) :: iteration  !< open–close iteration of the step
      type(system_type), intent(inout) :: system  !< equations of the step
      type(solver_type), intent(inout) :: solver  !< linear solver
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      real(wp), intent(in) :: half_size    !< half the model size w0, m
      logical, intent(in) :: first_step    !< first step of the run, with at least two iterations
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      real(wp) :: force(2)
      integer :: i, c, switched

      iteration%changes = 0
      iteration%broken = 0
      do i = 1, most_iterations
         call fail_if_step_stopped(iteration%may_stop, error)
         if (allocated(error)) return
         iteration%iterations = i
         call solve_assumed(iteration, system, solver, contacts, laws, error)
         if (allocated(error)) return
         call measure_range(contacts, system%d, 1, contacts%n)
         do c = 1, contacts%n
            force = assumed_forces(contacts, c, motion_in_step(contacts, c))
            contacts%normal_force(c) = force(1)
            contacts%shear_force(c) = force(2)
            contacts%trial_state(c) = next_state(contacts, laws, half_size, c)
         end do
         switched = count((contacts%trial_state(:contacts%n) == contact_open) &
            .neqv. (contacts%state(:contacts%n) == contact_open))
         iteration%changes = iteration%changes + switched
         if (switched == 0 .and. .not. (first_step .and. i == 1)) then
            call remove_bonds(iteration, contacts)
            call adopt_original_states(contacts, laws)
            return
         end if
         call adopt_original_states(contacts, laws)
      end do
      call fail(error, error_convergence, 'the open–close iteration does not converge by the '// &
         'original rules')
   end subroutine solve_by_original_rules

   !> Set touching contacts to sticking at the start of a run.
   pure subroutine lock_touching(contacts, half_size)
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step
      real(wp), intent(in) :: half_size  !< half the model size, m

      where (contacts%gap(:contacts%n) <= open_band*half_size) contacts%state(:contacts%n) = &
         contact_stick
      contacts%was_closed(:contacts%n) = contacts%state(:contacts%n) /= contact_open
   end subroutine lock_touching

   !> Return the next state of a contact by the transition table of the original rules.
   pure integer function next_state(contacts, laws, half_size, c) result(next)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      real(wp), intent(in) :: half_size  !< half the model size, m
      integer, intent(in) :: c  !< number of the contact
      type(coulomb_contact_type) :: law
      real(wp) :: gap, offset, friction

      law = law_of(laws, contacts%joint(c), contacts%bonded(c), bond_length_of(contacts, c), 0.0_wp)
      gap = contacts%new_gap(c)
      offset = contacts%stretch(c) + contacts%slip(c)
      friction = merge(law%friction, 0.0_wp, gap <= 0.0_wp)
      next = contact_open
      if (contacts%state(c) == contact_open) then
         if (gap > -close_band*half_size) return
         next = merge(contact_stick, contact_slide, abs(offset) < abs(gap)*law%friction)
      else if (gap > law%tension_force/law%normal_stiffness + open_band*half_size) then
         return
      else if (contacts%state(c) == contact_stick) then
         next = merge(contact_stick, contact_slide, abs(gap)*friction &
            + law%cohesion_force/law%normal_stiffness > abs(offset) &
            *law%shear_stiffness/law%normal_stiffness)
      else
         next = contact_slide
         if (sign(1.0_wp, contacts%slide_force(c))*contacts%slip(c) < -reversal_band*half_size &
            .and. law%friction > least_friction) next = contact_stick
      end if
   end function next_state

   !> Adopt the states, and set the friction of the next iteration from the present normal force.
   pure subroutine adopt_original_states(contacts, laws)
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      type(coulomb_contact_type) :: law
      integer :: c

      do c = 1, contacts%n
         if (contacts%trial_state(c) == contact_slide) then
            law = law_of(laws, contacts%joint(c), contacts%bonded(c), &
               bond_length_of(contacts, c), 0.0_wp)
            contacts%slide_force(c) = &
               sign(law%normal_stiffness*abs(contacts%new_gap(c))*law%friction &
               + law%cohesion_force, merge(contacts%slide_force(c), contacts%stretch(c) &
               + contacts%slip(c), contacts%state(c) == contact_slide))
         end if
         contacts%state(c) = contacts%trial_state(c)
      end do
   end subroutine adopt_original_states

   !> Remove cohesion and tension of contacts that do not stick at the end of a step.
   pure subroutine remove_bonds(iteration, contacts)
      type(open_close_type), intent(inout) :: iteration  !< open–close iteration of the step
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step
      integer :: c

      do c = 1, contacts%n
         if (.not. contacts%bonded(c) .or. contacts%trial_state(c) == contact_stick) cycle
         contacts%bonded(c) = .false.
         iteration%broken = iteration%broken + 1
      end do
   end subroutine remove_bonds

end module dda_original_rules
