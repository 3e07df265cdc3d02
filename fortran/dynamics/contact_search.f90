! SPDX-License-Identifier: GPL-3.0-or-later
!> List the contacts of a step from the geometry, with the histories of the previous list.
module dda_contact_search
   use dda_kinds, only: wp
   use dda_errors, only: error_type, error_input, fail
   use dda_energy_budget, only: update_geometric
   use dda_contact, only: contacts_type, contact_open
   use dda_contact_damping, only: damp_contacts
   use dda_contact_joints, only: set_joints
   use dda_contact_points, only: add_points, move_points
   use dda_damage_passes, only: begin_damage
   use dda_crossings, only: release_separated
   use dda_energy, only: add_energy, energy_length, energy_geometric
   use dda_joint_contact, only: state_of
   use dda_joint_lines, only: begin_lines
   use dda_tributary, only: set_lengths
   use dda_detection, only: measure_depths, detect_contacts
   use dda_history, only: inherit
   use dda_neighbours, only: find_neighbours
   use dda_model, only: force_noise, half_size
   use dda_simulation, only: simulation_type, next_step, exchange_lists
   use dda_matrix_pattern, only: set_pattern_of_run
   use dda_stopwatch, only: record_lap, phase_detect, phase_search
   use dda_text, only: to_text
   implicit none
   private
   public :: find_contacts

   !> smallest factor `rounding` of the force noise
   real(wp), parameter :: least_rounding = 1.0e-5_wp
   real(wp), parameter :: search_margin = 1.0_wp   !< search margin/contact distance

contains

   !> List the contacts of the present geometry; search neighbours if blocks have moved too far.
   subroutine find_contacts(simulation, error)
      type(simulation_type), intent(inout) :: simulation  !< a run and its state
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure

      associate (detection => simulation%detection, neighbours => simulation%neighbours)
         detection%travel = 2.5_wp*simulation%speed*simulation%time_step
         call measure_depths(detection, simulation%contacts(simulation%now), simulation%blocks)
         ! The list must retain all contacts in compression.
         detection%distance = max(detection%least, detection%travel, 2*detection%deepest) &
            + highest_lift(simulation)
         if (detection%distance + 2*neighbours%travel > neighbours%reach) &
            call search_neighbours(simulation, (1.0_wp + search_margin)*detection%distance, error)
         simulation%iteration%rounding = 1.0_wp
         if (any(simulation%blocks%body > 0) .and. .not. simulation%in_statics) &
            simulation%iteration%rounding = min(1.0_wp, max(least_rounding, &
            0.1_wp*detection%travel/half_size(simulation%blocks)))
      end associate
      if (allocated(error)) return
      call renew_contacts(simulation)
      call record_lap(simulation%system%watch, phase_detect)
   end subroutine find_contacts

   !> Search for neighbours, and update the pattern of the matrix and its ordering.
   subroutine search_neighbours(simulation, reach, error)
      type(simulation_type), intent(inout) :: simulation  !< a run and its state
      real(wp), intent(in) :: reach  !< search distance, m
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure

      call release_separated(simulation%detection%across, simulation%blocks, reach)
      call find_neighbours(simulation%neighbours, simulation%blocks, reach)
      if (simulation%neighbours%overflowed) then
         call fail(error, error_input, 'step '//to_text(simulation%step + 1)//' at t = '// &
            to_text(simulation%time)//' s: too many pairs of blocks lie within '//to_text(reach)// &
            ' m of each other; use larger blocks, or a smaller '// &
            'max_displacement_ratio or time_step')
         return
      end if
      call set_pattern_of_run(simulation)
      simulation%counters%searches = simulation%counters%searches + 1
      call record_lap(simulation%system%watch, phase_search)
   end subroutine search_neighbours

   !> Make a new list from geometry, with the histories of the old list.
   subroutine renew_contacts(simulation)
      type(simulation_type), intent(inout) :: simulation  !< a run and its state
      integer :: old

      old = simulation%now
      call exchange_lists(simulation)
      associate (contacts => simulation%contacts(simulation%now))
         contacts%time_step = merge(0.0_wp, simulation%time_step, simulation%in_statics)
         call detect_contacts(contacts, simulation%blocks, simulation%neighbours, &
            simulation%detection)
         if (contacts%with_laws) contacts%point(:contacts%n) = 0
         if (simulation%laws%pointed) call add_points(simulation%points, contacts, &
            simulation%blocks, simulation%laws, simulation%detection%distance)
         ! A successor may have a gap that differs by at most the displacement in a step.
         associate (history => simulation%history, detection => simulation%detection)
            history%max_penetration = detection%travel + detection%pressed
            history%largest_jump = detection%travel + 2*detection%deepest + detection%largest_corner
         end associate
         call inherit(contacts, simulation%contacts(old), simulation%history, &
            simulation%step > 0 .or. simulation%stage > 1)
         if (simulation%laws%pointed) call move_points(contacts, simulation%blocks, &
            simulation%laws, simulation%history%matched)
         call set_joints(contacts, simulation%blocks, simulation%laws, simulation%detection)
         if (simulation%laws%damped) call damp_contacts(contacts, simulation%laws, &
            simulation%blocks, next_step(simulation))
         contacts%was_closed(:contacts%n) = contacts%gap(:contacts%n) < 0.0_wp
         if (simulation%model%contact%original_rules) &
            contacts%was_closed(:contacts%n) = contacts%state(:contacts%n) /= contact_open
         if (contacts%with_laws) call prepare_laws(simulation, contacts)
         if (simulation%step > 0) call update_geometric(simulation%energy, &
            simulation%blocks, contacts, simulation%laws, simulation%elements, &
            next_step(simulation))
      end associate
   end subroutine renew_contacts

   !> Set the tributary lengths and linearisations of joint laws for a new list.
   pure subroutine prepare_laws(simulation, contacts)
      type(simulation_type), intent(inout) :: simulation  !< a run and its state
      type(contacts_type), intent(inout) :: contacts      !< new list
      real(wp) :: gained, stiffest
      integer :: c

      do c = 1, contacts%n
         associate (law => simulation%laws%slot(contacts%joint(c))%law)
            contacts%was_closed(c) = law%lift(state_of(contacts, law, c)) - contacts%gap(c) > 0.0_wp
         end associate
      end do
      call set_lengths(contacts, simulation%blocks, simulation%laws, gained)
      if (simulation%step > 0) then
         call add_energy(simulation%energy, energy_length, gained)
         call add_energy(simulation%energy, energy_geometric, -gained)
      end if
      call begin_lines(contacts, simulation%laws)
      if (contacts%with_net_slip) call begin_damage(contacts, simulation%laws)
      stiffest = max(0.0_wp, maxval(contacts%tangent(1, :contacts%n), &
         contacts%state(:contacts%n) /= contact_open))
      simulation%iteration%noise = force_noise(simulation%model, stiffest)
   end subroutine prepare_laws

   !> Return the largest dilation of the contacts due to slip, m.
   pure real(wp) function highest_lift(simulation) result(highest)
      type(simulation_type), intent(in) :: simulation  !< a run and its state
      integer :: c

      highest = 0.0_wp
      if (.not. simulation%laws%dilating) return
      associate (contacts => simulation%contacts(simulation%now))
         do c = 1, contacts%n
            associate (law => simulation%laws%slot(contacts%joint(c))%law)
               highest = max(highest, law%lift(state_of(contacts, law, c)))
            end associate
         end do
      end associate
   end function highest_lift

end module dda_contact_search
