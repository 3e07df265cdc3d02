!> The run: one derived type holds its whole state, `advance` moves it on.  No input, no output.
module dda_simulation
   use dda_kinds, only: wp, long
   use dda_errors, only: error_type, error_convergence, error_input, fail
   use dda_text, only: to_text
   use dda_assembly, only: system_type, prepare_system, set_matrix_pattern, assemble_base
   use dda_audit, only: open_books, book_geometry, book_step, book_motion
   use dda_blocks, only: blocks_type
   use dda_bonds, only: bond_contacts
   use dda_contact, only: contacts_type, reserve, contact_open
   use dda_detection, only: detection_type, prepare_detection, detect_contacts
   use dda_energy, only: energy_type
   use dda_friction, only: laws_type, set_laws
   use dda_history, only: history_type, prepare_history, inherit
   use dda_model, only: model_type, half_size, contact_distance
   use dda_neighbours, only: neighbours_type, find_neighbours
   use dda_newmark, only: carry_velocity, integrate, kinetic_energy, farthest_move
   use dda_open_close, only: iteration_type, close_contacts
   use dda_original_rules, only: close_by_original_rules, lock_touching
   use dda_solver, only: solver_type, choose_solver, analyse
   implicit none
   private
   public :: simulation_type, start, advance, finished, summary, set_rates

   real(wp), parameter :: search_margin = 1.0_wp   !< of the contact distance, searched beyond need
   real(wp), parameter :: shrink = 0.3_wp, recover = 1.3_wp  !< of Δt when adaptive
   real(wp), parameter :: touching = 1.0e-12_wp    !< of half the model size: no gap
   integer, parameter :: most_attempts = 40        !< at one step

   !> What has been counted since the start.
   type :: counters_type
      integer(long) :: iterations = 0      !< open–close iterations
      integer(long) :: searches = 0        !< neighbour searches
      integer(long) :: repeated = 0        !< steps taken again with a smaller Δt
      integer(long) :: too_far = 0         !< steps beyond the maximum displacement ratio
      integer(long) :: broken = 0          !< bonds broken
      integer :: most_iterations = 0       !< in one step
   end type counters_type

   !> Everything a run is made of.
   type :: simulation_type
      type(model_type) :: model                !< what does not change
      type(blocks_type) :: blocks              !< coordinates, velocities, vertices
      type(contacts_type) :: contacts(2)       !< this step's list and the last one's
      integer :: now = 1                       !< which of them is this step's
      type(neighbours_type) :: neighbours
      type(detection_type) :: detection
      type(history_type) :: history
      type(laws_type) :: laws
      type(system_type) :: system
      type(solver_type) :: solver
      type(iteration_type) :: iteration
      type(energy_type) :: energy
      type(counters_type) :: counters
      integer(long) :: step = 0                !< steps done
      real(wp) :: time = 0.0_wp                !< s
      real(wp) :: time_step = 0.0_wp           !< Δt of the next step, s
      real(wp) :: last_time_step = 0.0_wp      !< Δt of the last step, s
      real(wp) :: speed = 0.0_wp               !< bound on the farthest move of a vertex in the last step / Δt, m/s
   end type simulation_type

contains

   !> Set up a run of a model.
   subroutine start(simulation, model, error)
      type(simulation_type), intent(out) :: simulation
      type(model_type), intent(in) :: model
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: gravity

      simulation%model = model
      simulation%blocks = model%blocks
      simulation%time_step = model%control%time_step
      call choose_solver(simulation%solver, model%control%solver, error)
      if (allocated(error)) return
      call set_laws(simulation%laws, model%joints, model%contact%normal_stiffness, model%contact%shear_ratio)
      call prepare_detection(simulation%detection, simulation%blocks, contact_distance(model))
      call prepare_history(simulation%history, size(simulation%blocks%owner), touching*half_size(simulation%blocks))
      call prepare_system(simulation%system, simulation%blocks%n)
      gravity = norm2(model%control%gravity)
      simulation%iteration%max_iterations = model%contact%max_iterations
      simulation%iteration%penetration_tolerance = model%contact%penetration_tolerance
      simulation%laws%augmented = model%contact%penetration_tolerance > 0.0_wp
      simulation%iteration%relative_tolerance = model%contact%force_tolerance
      simulation%iteration%weight = gravity*maxval(simulation%blocks%mass)
      simulation%iteration%noise = 16*epsilon(1.0_wp)*half_size(simulation%blocks)*model%contact%normal_stiffness
      simulation%speed = farthest_move(simulation%blocks, simulation%blocks%velocity)
      call reserve(simulation%contacts(1), simulation%blocks%n)
      call reserve(simulation%contacts(2), simulation%blocks%n)
      call find_contacts(simulation)
      associate (contacts => simulation%contacts(simulation%now))
         contacts%new_gap(:contacts%n) = contacts%gap(:contacts%n)
      end associate
      call bond_contacts(simulation%contacts(simulation%now), simulation%blocks, simulation%laws)
      if (model%contact%original_rules) call lock_touching(simulation%contacts(simulation%now), half_size(model%blocks))
      call open_books(simulation%energy, simulation%model, simulation%blocks, &
         simulation%contacts(simulation%now), simulation%laws)
   end subroutine start

   !> Set the rates of all blocks; the energy that this brings is input, or part of the first state.
   subroutine set_rates(simulation, rates, error)
      type(simulation_type), intent(inout) :: simulation
      real(wp), intent(in) :: rates(:,:)  !< [6, blocks]
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: gain

      if (.not. all(abs(rates) <= huge(1.0_wp))) then
         call fail(error, error_input, 'rates must be finite')
         return
      end if
      simulation%blocks%velocity = rates
      gain = kinetic_energy(simulation%blocks) - simulation%energy%kinetic
      simulation%energy%kinetic = simulation%energy%kinetic + gain
      if (simulation%step == 0) then
         simulation%energy%initial = simulation%energy%initial + gain
      else
         simulation%energy%input = simulation%energy%input + gain
      end if
      simulation%speed = farthest_move(simulation%blocks, rates)
   end subroutine set_rates

   !> Take one step.
   subroutine advance(simulation, error)
      type(simulation_type), intent(inout) :: simulation
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: loss
      integer :: attempt

      call carry_velocity(simulation%blocks, simulation%model%control%dynamic_factor, loss)
      simulation%energy%kinetic_damping = simulation%energy%kinetic_damping + loss
      do attempt = 1, most_attempts
         call find_contacts(simulation)
         call solve_step(simulation, error)
         if (.not. allocated(error)) then
            if (.not. too_far(simulation)) exit
         end if
         call retry(simulation, attempt, error)
         if (allocated(error)) return
      end do
      call accept(simulation)
   end subroutine advance

   !> List the contacts of the present geometry, search for neighbours if the old search is used up.
   subroutine find_contacts(simulation)
      type(simulation_type), intent(inout) :: simulation
      real(wp) :: distance

      distance = max(simulation%detection%distance, 2.5_wp*simulation%speed*simulation%time_step, &
         2*deepest_penetration(simulation%contacts(simulation%now)))
      if (distance + 2*simulation%neighbours%travel > simulation%neighbours%reach) then
         call find_neighbours(simulation%neighbours, simulation%blocks, (1.0_wp + search_margin)*distance)
         call set_matrix_pattern(simulation%system, simulation%blocks%n, simulation%neighbours)
         call analyse(simulation%solver, simulation%system%matrix)
         simulation%counters%searches = simulation%counters%searches + 1
      end if
      call renew_contacts(simulation, distance)
   end subroutine find_contacts

   !> How deep the last step's contacts went, m: what presses must not be lost from the list.
   pure real(wp) function deepest_penetration(contacts) result(depth)
      type(contacts_type), intent(in) :: contacts

      depth = max(0.0_wp, -minval(contacts%new_gap(:contacts%n)))
      if (contacts%n == 0) depth = 0.0_wp
   end function deepest_penetration

   !> A new list from geometry, with the histories of the old one.
   subroutine renew_contacts(simulation, distance)
      type(simulation_type), intent(inout) :: simulation
      real(wp), intent(in) :: distance
      integer :: old, c

      old = simulation%now
      simulation%now = 3 - old
      associate (contacts => simulation%contacts(simulation%now))
         call detect_contacts(contacts, simulation%blocks, simulation%neighbours, simulation%detection, distance)
         do c = 1, contacts%n
            contacts%joint(c) = weaker_joint(simulation, contacts%block_v(c), contacts%block_e(c))
         end do
         call inherit(contacts, simulation%contacts(old), simulation%history)
         contacts%was_closed(:contacts%n) = contacts%gap(:contacts%n) < 0.0_wp
         if (simulation%model%contact%original_rules) &
            contacts%was_closed(:contacts%n) = contacts%state(:contacts%n) /= contact_open
         if (simulation%step > 0) call book_geometry(simulation%energy, simulation%model, simulation%blocks, contacts, &
            simulation%laws, simulation%time)
      end associate
   end subroutine renew_contacts

   !> Of two joint materials that meet, the one with less friction governs.
   pure integer function weaker_joint(simulation, i, j)
      type(simulation_type), intent(in) :: simulation
      integer, intent(in) :: i, j

      weaker_joint = simulation%blocks%joint(i)
      associate (friction => simulation%laws%friction)
         if (friction(simulation%blocks%joint(j)) < friction(weaker_joint)) weaker_joint = simulation%blocks%joint(j)
      end associate
   end function weaker_joint

   !> Assemble and iterate for the increment d of this step.
   subroutine solve_step(simulation, error)
      type(simulation_type), intent(inout) :: simulation
      type(error_type), allocatable, intent(out) :: error

      associate (contacts => simulation%contacts(simulation%now))
         contacts%was_bonded(:contacts%n) = contacts%bonded(:contacts%n)
         call assemble_base(simulation%system, simulation%model, simulation%blocks, &
            simulation%time + simulation%time_step, simulation%time_step)
         if (simulation%model%contact%original_rules) then
            call close_by_original_rules(simulation%iteration, simulation%system, simulation%solver, contacts, &
               simulation%laws, half_size(simulation%model%blocks), simulation%step == 0, error)
         else
            call close_contacts(simulation%iteration, simulation%system, simulation%solver, contacts, simulation%laws, error)
         end if
      end associate
      simulation%counters%iterations = simulation%counters%iterations + simulation%iteration%iterations
      simulation%counters%most_iterations = max(simulation%counters%most_iterations, simulation%iteration%iterations)
   end subroutine solve_step

   !> The step moves a vertex beyond the maximum displacement, or beyond what contacts were listed for.
   logical function too_far(simulation)
      type(simulation_type), intent(inout) :: simulation
      real(wp) :: move, allowed

      move = farthest_move(simulation%blocks, simulation%system%d)
      allowed = simulation%model%control%max_displacement_ratio*half_size(simulation%model%blocks)
      simulation%speed = move/simulation%time_step
      too_far = simulation%model%control%adaptive .and. move > allowed
      if (move > allowed) simulation%counters%too_far = simulation%counters%too_far + 1
      if (2*move > max(simulation%detection%distance, simulation%neighbours%reach - 2*simulation%neighbours%travel)) &
         too_far = .true.
   end function too_far

   !> Prepare another attempt at the step: a smaller Δt if it is allowed to shrink, else a wider search.
   subroutine retry(simulation, attempt, error)
      type(simulation_type), intent(inout) :: simulation
      integer, intent(in) :: attempt
      type(error_type), allocatable, intent(inout) :: error
      character(len=:), allocatable :: reason

      associate (contacts => simulation%contacts(simulation%now))
         contacts%bonded(:contacts%n) = contacts%was_bonded(:contacts%n)
      end associate
      reason = 'a vertex moves too far in one step'
      if (allocated(error)) reason = error%message
      if (simulation%model%control%adaptive .and. &
         shrink*simulation%time_step >= simulation%model%control%least_time_step .and. attempt < most_attempts) then
         simulation%time_step = shrink*simulation%time_step
         simulation%counters%repeated = simulation%counters%repeated + 1
         if (allocated(error)) deallocate (error)
      else if (allocated(error) .or. attempt > 3) then
         call explain(simulation, reason, error)
      end if
   end subroutine retry

   !> An error that says what, where and what to try.
   subroutine explain(simulation, reason, error)
      type(simulation_type), intent(in) :: simulation
      character(len=*), intent(in) :: reason
      type(error_type), allocatable, intent(inout) :: error
      character(len=:), allocatable :: place, advice
      integer :: c

      place = ''
      c = simulation%iteration%worst
      if (c > 0) then
         associate (contacts => simulation%contacts(simulation%now))
            place = '; worst contact: a vertex of block '//block_name(simulation, contacts%block_v(c))// &
               ' on an edge of block '//block_name(simulation, contacts%block_e(c))//', force off by '// &
               to_text(simulation%iteration%residual)//' N/m, allowed '//to_text(simulation%iteration%tolerance)
         end associate
      end if
      advice = "; try a smaller time_step, or time_step_control = 'adaptive'"
      if (simulation%model%control%adaptive) advice = '; try a smaller least_time_step or a lower normal_stiffness'
      call fail(error, error_convergence, 'step '//to_text(simulation%step + 1)//' at t = '//to_text(simulation%time)// &
         ' s, time step '//to_text(simulation%time_step)//' s: '//reason//place//advice)
   end subroutine explain

   pure function block_name(simulation, b) result(name)
      type(simulation_type), intent(in) :: simulation
      integer, intent(in) :: b
      character(len=:), allocatable :: name

      name = to_text(b)
      if (simulation%model%block_names(b) /= '') name = name//" '"//trim(simulation%model%block_names(b))//"'"
   end function block_name

   !> Make the solution of the step the new state.
   subroutine accept(simulation)
      type(simulation_type), intent(inout) :: simulation
      real(wp) :: end_time

      end_time = simulation%time + simulation%time_step
      simulation%last_time_step = simulation%time_step
      associate (contacts => simulation%contacts(simulation%now), d => simulation%system%d)
         call book_step(simulation%energy, simulation%model, simulation%blocks, contacts, simulation%laws, d, &
            end_time, simulation%time_step)
         call integrate(simulation%blocks, d, simulation%time_step)
         call book_motion(simulation%energy, simulation%blocks)
         contacts%stretch(:contacts%n) = contacts%shear_force(:contacts%n)/simulation%laws%shear_stiffness
         contacts%state(:contacts%n) = contacts%answer(:contacts%n)
      end associate
      simulation%neighbours%travel = simulation%neighbours%travel + simulation%speed*simulation%time_step
      simulation%counters%broken = simulation%counters%broken + simulation%iteration%broken
      simulation%step = simulation%step + 1
      call move_clock(simulation, end_time)
   end subroutine accept

   !> With a fixed Δt, time is an exact multiple of it; an adaptive Δt recovers after each good step.
   subroutine move_clock(simulation, end_time)
      type(simulation_type), intent(inout) :: simulation
      real(wp), intent(in) :: end_time
      real(wp) :: left

      associate (control => simulation%model%control)
         if (.not. control%adaptive) then
            simulation%time = real(simulation%step, wp)*control%time_step
            return
         end if
         simulation%time = end_time
         left = real(control%steps, wp)*control%time_step - end_time
         simulation%time_step = min(control%time_step, recover*simulation%time_step)
         if (left > 0.0_wp) simulation%time_step = min(simulation%time_step, left)
      end associate
   end subroutine move_clock

   !> The duration asked for has been reached.
   pure logical function finished(simulation)
      type(simulation_type), intent(in) :: simulation

      associate (control => simulation%model%control)
         if (control%adaptive) then
            finished = simulation%time >= (real(control%steps, wp) - 1.0e-9_wp)*control%time_step
         else
            finished = simulation%step >= control%steps
         end if
      end associate
   end function finished

   !> What step control did, in words.
   pure function summary(simulation) result(text)
      type(simulation_type), intent(in) :: simulation
      character(len=:), allocatable :: text

      associate (counters => simulation%counters)
         text = to_text(simulation%step)//' steps, '//to_text(counters%iterations)//' open-close iterations (most '// &
            to_text(counters%most_iterations)//' in a step), '//to_text(counters%searches)//' neighbour searches, '// &
            to_text(counters%repeated)//' steps repeated with a smaller time step, '//to_text(counters%too_far)// &
            ' steps beyond max_displacement_ratio, '//to_text(counters%broken)//' bonds broken'
      end associate
   end function summary

end module dda_simulation
