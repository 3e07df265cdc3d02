! SPDX-License-Identifier: GPL-3.0-or-later
!> Initial state of a run, and velocities that the caller sets.
module dda_start
   use dda_kinds, only: wp
   use dda_errors, only: error_type, error_input, fail
   use dda_system, only: prepare_system
   use dda_elements, only: set_elements, match_velocities, update_stored
   use dda_energy, only: add_energy, total_energy, energy_kinetic, energy_initial, energy_input
   use dda_energy_budget, only: start_energy_budget
   use dda_blocks, only: begin_motion, keep_first_state
   use dda_bonds, only: bond_contacts
   use dda_crossings, only: find_crossings, most_across
   use dda_column_model, only: column_model
   use dda_columns, only: make_columns, column_of, name_column
   use dda_confinement, only: confine_contacts
   use dda_contact, only: contacts_type, reserve, filter_contacts
   use dda_contact_search, only: find_contacts
   use dda_detection, only: prepare_detection
   use dda_friction, only: laws_type, set_laws
   use dda_history, only: prepare_history
   use dda_impact, only: prepare_impacts
   use dda_model, only: model_type, half_size, contact_distance, force_noise
   use dda_kinematics, only: kinetic_energy, largest_displacement
   use dda_original_rules, only: lock_touching
   use dda_scheme, only: scheme_named
   use dda_simulation, only: simulation_type, block_name, next_step
   use dda_linear_solver, only: choose_solver
   use dda_stop_rule, only: prepare_stop_rule
   implicit none
   private
   public :: start, set_rates

   !> largest gap of touching blocks/half the model size
   real(wp), parameter :: touching = 1.0e-12_wp

contains

   !> Initialise a run of a model, and the runs of its free-field columns.
   recursive subroutine start(simulation, model, error)
      type(simulation_type), intent(out) :: simulation  !< a run and its state
      type(model_type), intent(in) :: model  !< model as read from the input
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure

      simulation%model = model
      simulation%blocks = model%blocks
      call keep_first_state(simulation%model%blocks)
      call begin_motion(simulation%blocks)
      simulation%statics = ''
      allocate (simulation%doubts(0))
      simulation%changed_text = ''
      simulation%changes = ''
      call prepare_stop_rule(simulation)
      simulation%time_step = model%control%time_step
      simulation%scheme = scheme_named(model%control%integration, model%control%theta)
      call set_elements(simulation%elements, model, simulation%blocks, 0.0_wp)
      call match_velocities(simulation%elements, simulation%blocks, next_step(simulation))
      call choose_solver(simulation%solver, model%control%solver, error)
      if (allocated(error)) return
      call set_laws(simulation%laws, model%joints, model%contact%normal_stiffness, &
         model%contact%shear_ratio)
      call prepare_detection(simulation%detection, simulation%blocks, contact_distance(model))
      call prepare_history(simulation%history, size(simulation%blocks%owner), &
         touching*half_size(simulation%blocks))
      call prepare_system(simulation%system, simulation%blocks%n)
      call prepare_impacts(simulation%impacts, simulation%blocks%n)
      call prepare_iteration(simulation, model)
      simulation%speed = largest_displacement(simulation%blocks, simulation%blocks%velocity)
      call allocate_list_variables(simulation%contacts, simulation%laws)
      call reserve(simulation%contacts(simulation%now), 1)
      call find_contacts(simulation, error)
      if (allocated(error)) return
      associate (contacts => simulation%contacts(simulation%now))
         contacts%new_gap(:contacts%n) = contacts%gap(:contacts%n)
      end associate
      call bond_contacts(simulation%contacts(simulation%now), simulation%blocks, simulation%laws)
      if (allocated(model%stress_gradient)) call set_initial_contact_forces(simulation, error)
      if (allocated(error)) return
      if (.not. model%contact%original_rules) call skip_crossings(simulation)
      if (model%contact%original_rules) call lock_touching(simulation%contacts(simulation%now), &
         half_size(model%blocks))
      call start_energy_budget(simulation%energy, simulation%blocks, &
         simulation%contacts(simulation%now), simulation%laws, simulation%elements, &
         next_step(simulation))
      call start_columns(simulation, model, error)
   end subroutine start

   !> Set the contact forces that balance the initial stress.
   subroutine set_initial_contact_forces(simulation, error)
      type(simulation_type), intent(inout) :: simulation  !< run with its initial contacts
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      integer :: c

      associate (contacts => simulation%contacts(simulation%now))
         call confine_contacts(contacts, simulation%blocks, simulation%laws, &
            simulation%model%stress_gradient, c)
         if (c > 0) call fail(error, error_input, '&in_situ: the initial stress exceeds the '// &
            'strength of the joint between block '//block_name(simulation, contacts%block_v(c)) &
            //' and block '//block_name(simulation, contacts%block_e(c))// &
            '; use a larger crushing_strength or a smaller stress')
      end associate
   end subroutine set_initial_contact_forces

   !> Allocate the optional variables of the lists of contacts.
   elemental subroutine allocate_list_variables(contacts, laws)
      type(contacts_type), intent(inout) :: contacts  !< empty list
      type(laws_type), intent(in) :: laws             !< laws of the joints

      contacts%with_laws = .not. laws%plain
      contacts%initial_memory = laws%columns%initial
      contacts%with_net_slip = laws%with_net_slip
      contacts%with_damping = laws%damped
      contacts%with_multipliers = laws%augmented
      contacts%with_strengths = .not. laws%plain .or. any(max(laws%cohesion, laws%tension) > 0.0_wp)
   end subroutine allocate_list_variables

   !> Set limits and tolerances of the open–close iteration.
   subroutine prepare_iteration(simulation, model)
      type(simulation_type), intent(inout) :: simulation  !< run with contact laws and scheme
      type(model_type), intent(in) :: model  !< model as read from the input

      associate (iteration => simulation%iteration, contact => model%contact)
         iteration%max_iterations = contact%max_iterations
         iteration%penetration_tolerance = contact%penetration_tolerance
         iteration%relative_tolerance = contact%force_tolerance
         iteration%weight = norm2(model%control%gravity)*maxval(simulation%blocks%mass)
         iteration%noise = force_noise(model, 0.0_wp)
         simulation%laws%theta = simulation%scheme%theta
         simulation%laws%augmented = contact%penetration_tolerance > 0.0_wp
      end associate
   end subroutine prepare_iteration

   !> Start the runs of the free-field columns.
   recursive subroutine start_columns(simulation, model, error)
      type(simulation_type), intent(inout) :: simulation  !< new run
      type(model_type), intent(in) :: model  !< model as read from the input
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      integer :: i

      associate (fields => model%free_fields)
         call make_columns(simulation, size(fields))
         do i = 1, size(fields)
            call start(column_of(simulation, i), column_model(model, fields(i)), error)
            call name_column(simulation, i, error)
            if (allocated(error)) return
         end do
      end associate
   end subroutine start_columns

   !> Remove contacts between diagonally opposite corners at a crossing of joints.
   subroutine skip_crossings(simulation)
      type(simulation_type), intent(inout) :: simulation  !< simulation with its first contacts

      integer, allocatable :: opposite_vertices(:,:)

      allocate (opposite_vertices(most_across, size(simulation%blocks%owner)), source=0)
      associate (contacts => simulation%contacts(simulation%now))
         block
            logical :: is_opposite(contacts%n)

            call find_crossings(contacts, simulation%blocks, opposite_vertices, is_opposite)
            if (.not. any(is_opposite)) return
            call filter_contacts(contacts, .not. is_opposite)
         end block
      end associate
      call move_alloc(opposite_vertices, simulation%detection%across)
   end subroutine skip_crossings

   !> Set the velocities of all blocks; supports then correct them.
   !> The change of kinetic energy is initial energy before the first step, and energy input later.
   subroutine set_rates(simulation, rates, error)
      type(simulation_type), intent(inout) :: simulation  !< a run and its state
      real(wp), intent(in) :: rates(:,:)  !< [6,blocks] velocities, m/s, rad/s, 1/s
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      real(wp) :: former_energy

      if (.not. all(abs(rates) <= huge(1.0_wp))) call fail(error, error_input, &
         'rates must be finite')
      if (allocated(error)) return
      simulation%blocks%velocity = rates
      call match_velocities(simulation%elements, simulation%blocks, next_step(simulation))
      associate (energy => simulation%energy)
         former_energy = total_energy(energy)
         energy%value(energy_kinetic) = kinetic_energy(simulation%blocks)
         call update_stored(simulation%elements, simulation%blocks, next_step(simulation), energy)
         call add_energy(energy, merge(energy_initial, energy_input, simulation%step == 0), &
            total_energy(energy) - former_energy)
      end associate
      simulation%speed = largest_displacement(simulation%blocks, simulation%blocks%velocity)
   end subroutine set_rates

end module dda_start
