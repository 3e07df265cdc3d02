! SPDX-License-Identifier: GPL-3.0-or-later
!> The complete state of a run, as one derived type.
module dda_simulation
   use dda_kinds, only: wp, long
   use dda_base_motion, only: base_type
   use dda_system, only: system_type
   use dda_blocks, only: blocks_type
   use dda_contact, only: contacts_type, move_step_arrays
   use dda_contact_points, only: point_list_type
   use dda_detection, only: detection_type
   use dda_doubts, only: doubt_type
   use dda_elements, only: elements_type
   use dda_energy, only: energy_type
   use dda_first_contacts, only: first_contacts_type
   use dda_friction, only: laws_type
   use dda_history, only: history_type
   use dda_impact, only: impacts_type
   use dda_maxima, only: largest_type, number_of_maxima
   use dda_model, only: model_type
   use dda_neighbours, only: neighbours_type
   use dda_open_close, only: open_close_type
   use dda_linear_solver, only: solver_type, work_done
   use dda_scheme, only: scheme_type, step_type
   use dda_text, only: counted, to_text
   implicit none
   private
   public :: simulation_type, column_runs_type, counters_type, stop_state_type, maxima_type, &
      next_step, exchange_lists, end_of_run, finished, stage_finished, summary, ending, &
      block_name, gravity_is_sudden

   !> Counts since the start of the run.
   type :: counters_type
      integer(long) :: iterations = 0      !< number of open–close iterations
      integer(long) :: searches = 0        !< neighbour searches
      integer(long) :: repeated = 0        !< steps repeated with a smaller Δt
      integer(long) :: too_far = 0         !< steps beyond the maximum displacement ratio
      integer(long) :: broken = 0          !< number of broken bonds
      !> steps in which the damage of bonds did not converge
      integer(long) :: unconverged_damage = 0
      integer(long) :: unconverged_bounds = 0  !< steps in which frozen bounds did not converge
      integer(long) :: tables_off = 0      !< steps in which no water table was found
      integer(long) :: changes = 0         !< contact states changed after the first step
      integer :: most_iterations = 0       !< largest number of iterations in one step
   end type counters_type

   !> State of the stop rule; without &stop only `reason` is used, and it is blank.
   type :: stop_state_type
      character(len=:), allocatable :: reason   !< reason for an early end of the run, else blank
      real(wp), allocatable :: first(:,:)       !< [3, blocks] initial positions
      real(wp), allocatable :: window(:,:)      !< [3, blocks] positions for the test of equilibrium
      real(wp) :: since = 0.0_wp                !< time at which the window began, s
   end type stop_state_type

   !> Largest values of all steps since counting began (`dda_running_maxima`).
   type :: maxima_type
      ! unsaved, set before it is written: last, moved
      ! unsaved, the input: size_of, least_size, below
      logical :: counting = .false.
      type(largest_type) :: largest(number_of_maxima)  !< maxima so far
      type(largest_type) :: last(number_of_maxima)     !< present state, see `collect_residuals`
      integer :: moved(3) = 0  !< numbers of initial contacts, slipped and opened contacts
      type(base_type) :: base                   !< reference motion of displacements and rates
      type(first_contacts_type) :: contacts     !< contacts for slip and opening
      real(wp), allocatable :: first(:,:)     !< [3,blocks] initial positions
      real(wp), allocatable :: size_of(:)       !< [blocks] root of the area of block or body, m
      real(wp) :: least_size = 0.0_wp           !< smallest value of `size_of`, m
      integer, allocatable :: below(:)          !< [points] point below each point, or 0
      !> displacement of the base when the point displacements were last set to zero, m
      real(wp) :: points_from(2) = 0.0_wp
   end type maxima_type

   !> Runs of the free-field columns (`dda_columns`).
   type, abstract :: column_runs_type
   end type column_runs_type

   !> All data of a run.
   type :: simulation_type
      ! unsaved, the input: model, detection, laws
      ! unsaved, the input, by the stage: scheme
      ! unsaved, positions of old contacts, found in each step: history
      ! unsaved, used only within a static stage, in which no checkpoint is written: in_statics
      ! unsaved, set at the start of each round of a step: linear_about
      ! unsaved, set at the end of each round, before it is used: solution
      type(model_type) :: model                !< constant data
      type(blocks_type) :: blocks              !< coordinates, velocities, vertices
      type(contacts_type) :: contacts(2)       !< contacts of this step and of the last step
      integer :: now = 1                       !< index of this step's list
      type(neighbours_type) :: neighbours
      type(detection_type) :: detection
      type(point_list_type) :: points
      type(history_type) :: history
      type(laws_type) :: laws
      type(elements_type) :: elements          !< supports, loads, body forces …
      !> [6,blocks] increment at which material laws are linearised, and the resulting solution
      real(wp), allocatable :: linear_about(:,:), solution(:,:)
      type(scheme_type) :: scheme              !< time integration
      type(system_type) :: system
      type(solver_type) :: solver
      type(open_close_type) :: iteration
      type(impacts_type) :: impacts
      type(energy_type) :: energy
      type(counters_type) :: counters
      type(stop_state_type) :: stop
      type(maxima_type) :: maxima
      class(column_runs_type), allocatable :: columns  !< runs of free-field columns
      integer :: stage = 0                     !< present stage
      integer(long) :: first_step = 0          !< steps before the present stage
      real(wp) :: first_time = 0.0_wp          !< time at the start of the present stage, s
      integer(long) :: step = 0                !< number of completed steps
      real(wp) :: time = 0.0_wp                !< s
      real(wp) :: time_step = 0.0_wp           !< Δt of the next step, s
      real(wp) :: last_time_step = 0.0_wp      !< Δt of the last step, s
      !> upper bound of vertex displacements/Δt in the last step, m/s
      real(wp) :: speed = 0.0_wp
      real(wp) :: path = 0.0_wp  !< sum of largest vertex displacements of all steps, m
      logical :: in_statics = .false.          !< a static stage is running
      character(len=:), allocatable :: statics  !< text on static stages so far, or blank
      !> warnings of the check and of static stages
      type(doubt_type), allocatable :: doubts(:)
      !> input that includes changes between steps; text on these changes, or blank
      character(len=:), allocatable :: changed_text, changes
   end type simulation_type

contains

   !> Return the scheme, time and Δt of the next step.
   pure type(step_type) function next_step(simulation)
      type(simulation_type), intent(in) :: simulation  !< a run and its state

      next_step = step_type(simulation%scheme, simulation%time, simulation%time_step)
   end function next_step

   !> Exchange the lists of contacts of this step and of the last one.
   pure subroutine exchange_lists(simulation)
      type(simulation_type), intent(inout) :: simulation  !< a run and its state

      simulation%now = 3 - simulation%now
      call move_step_arrays(simulation%contacts(3 - simulation%now), &
         simulation%contacts(simulation%now))
   end subroutine exchange_lists

   !> Return the time at the end of all stages, s.
   pure real(wp) function end_of_run(simulation)
      type(simulation_type), intent(in) :: simulation  !< a run and its state

      associate (stages => simulation%model%stages, control => simulation%model%control)
         end_of_run = simulation%first_time + sum(stages(simulation%stage + 1:)%steps &
            *stages(simulation%stage + 1:)%time_step)
         if (simulation%stage == 0) return
         if (.not. stages(simulation%stage)%static) end_of_run = end_of_run &
            + real(control%step_count, wp)*control%time_step
      end associate
   end function end_of_run

   !> .true. if all stages have ended, or the stop rule has ended the run.
   pure logical function finished(simulation)  ! total
      type(simulation_type), intent(in) :: simulation  !< a run and its state

      finished = simulation%stop%reason /= ''
      if (.not. finished) finished = simulation%stage >= size(simulation%model%stages) .and. &
         stage_finished(simulation)
   end function finished

   !> .true. if the present stage has ended; a static stage takes no time.
   pure logical function stage_finished(simulation) result(done)  ! total
      type(simulation_type), intent(in) :: simulation  !< a run and its state

      done = simulation%stage == 0
      if (.not. done) done = simulation%model%stages(simulation%stage)%static
      if (done) return
      associate (control => simulation%model%control)
         if (control%adaptive) then
            done = simulation%time - simulation%first_time >= (real(control%step_count, wp) &
               - 1.0e-9_wp)*control%time_step
         else
            done = simulation%step - simulation%first_step >= control%step_count
         end if
      end associate
   end function stage_finished

   !> Return a text on the numbers of steps and iterations; counts of zero are omitted.
   pure function summary(simulation) result(text)
      type(simulation_type), intent(in) :: simulation  !< a run and its state
      character(len=:), allocatable :: text

      associate (counters => simulation%counters, impacts => simulation%impacts)
         text = counted(to_text(simulation%step), 'step', 'steps')//', '// &
            counted(to_text(counters%iterations), 'open-close iteration', 'open-close '// &
            'iterations')//' (most '//to_text(counters%most_iterations)//' in a step)'// &
            count_text(counters%searches, 'neighbour search', 'neighbour searches')// &
            count_text(counters%repeated, 'step', 'steps', ' repeated with a smaller time step')// &
            count_text(counters%too_far, 'step', 'steps', ' beyond max_displacement_ratio')// &
            count_text(counters%tables_off, 'step', 'steps', ' without a water table')
         if (counters%unconverged_damage > 0) text = text//'; in '// &
            to_text(counters%unconverged_damage)// &
            ' steps the damage of cohesive joints did not converge: failure times depend on Δt'
         if (counters%unconverged_bounds > 0) text = text//'; in '// &
            to_text(counters%unconverged_bounds)// &
            ' steps frozen quantities did not converge: the damage of broken faces, or the '// &
            'mean stress on which the strength of materials with dilation_angle below '// &
            'friction_angle depends'
         if (impacts%steps > 0) text = text//'; '//counted(to_text(impacts%contacts), 'impact', &
            'impacts')//' in '//counted(to_text(impacts%steps), 'step', 'steps')// &
            count_text(int(impacts%reduced, long), 'of these steps', 'of these steps', &
            ' with reduced restitution, because the given value would add energy')
      end associate
      if (simulation%statics /= '') text = text//'; '//simulation%statics
      if (simulation%changes /= '') text = text//'; changed between steps: '//simulation%changes
      if (simulation%solver%repeated_directly > 0) text = text//'; solver: '// &
         work_done(simulation%solver)
   end function summary

   !> Return ', ' with a count and its noun; blank if the count is zero.
   pure function count_text(count, singular, plural, suffix) result(text)
      integer(long), intent(in) :: count         !< count
      character(len=*), intent(in) :: singular, plural  !< see `counted`
      character(len=*), intent(in), optional :: suffix  !< words after the noun
      character(len=:), allocatable :: text

      text = ''
      if (count == 0) return
      text = ', '//counted(to_text(count), singular, plural)
      if (present(suffix)) text = text//suffix
   end function count_text

   !> Return the reason for the end of the run; blank until then.
   pure function ending(simulation) result(text)
      type(simulation_type), intent(in) :: simulation  !< a run and its state
      character(len=:), allocatable :: text

      text = ''
      if (simulation%stop%reason /= '') then
         text = 'stopped at t = '//to_text(simulation%time)//' s: '//simulation%stop%reason
      else if (finished(simulation)) then
         text = 'duration reached'
      end if
   end function ending

   !> .true. if gravity acts suddenly, without static stage or initial stress.
   pure logical function gravity_is_sudden(model)  ! total
      type(model_type), intent(in) :: model  !< model as read from the input

      gravity_is_sudden = norm2(model%control%gravity) > 0.0_wp .and. &
         model%control%dynamic_factor > 0.0_wp .and. .not. model%stages(1)%static .and. &
         .not. any(abs(model%blocks%initial_stress) > 0.0_wp)
   end function gravity_is_sudden

   pure function block_name(simulation, b) result(name)
      type(simulation_type), intent(in) :: simulation  !< a run and its state
      integer, intent(in) :: b  !< number of the block
      character(len=:), allocatable :: name

      name = to_text(b)
      if (simulation%model%block_names(b) /= '') name = name//" '"// &
         trim(simulation%model%block_names(b))//"'"
   end function block_name

end module dda_simulation
