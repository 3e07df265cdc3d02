! SPDX-License-Identifier: GPL-3.0-or-later
!> Static equilibrium of a simulation under gravity and the loads at the present time.
!>
!> Velocities are set to zero after each step, so a step of backward Euler (θ = χ = 1) solves
!>
!>     (M/Δt² + K) d = f − K q₀ − ∇U(q₀ + d) ,
!>
!> which is statics with a proximal term.  The unbalanced force M d/Δt² decreases with larger Δt.
!> Touching contacts are first assumed to stick.  The first Δt is long enough for blocks to share
!> their loads before friction is mobilised; with the Δt of dynamics, stiff joints would slip while
!> the weight is applied.  A step that does not converge is repeated with a shorter Δt; after a
!> converged step, Δt is increased.  Steps in which many contacts change are relaxed
!> (`dda_static_relaxation`).  If relaxed steps stall, the search begins again without relaxation,
!> and vice versa: packings of 1,500 polygons converge only without relaxation, walls of 4,000
!> bricks only with it.
!>
!> Equilibrium: with all velocities zero and contact laws evaluated in the present geometry, the
!> unbalanced force on each block is at most 10⁻⁶ of its weight, 4 times the tolerance of contact
!> forces, or the force in its springs due to rounding of coordinates.  If this limit exceeds 10⁻³
!> of the weight of an unsupported block, the outcome reports that the block may still slide.  The
!> search ends if blocks fall without limit (`dda_falling`) or if it stalls.
!>
!> In equilibrium, each penetration must follow from its contact force.  If a gap offset permits a
!> deeper penetration, the offset is removed, and the steps continue.
!>
!> Statics excludes material damping: materials have the given modulus, and Maxwell branches restart
!> without stress.
module dda_equilibrium
   use dda_kinds, only: wp, long
   use dda_blocks, only: blocks_type, begin_memory
   use dda_columns, only: pass_columns_to_sides
   use dda_contact, only: contacts_type, contact_slide
   use dda_contact_evaluation, only: evaluate_contacts
   use dda_contact_gradients, only: find_rows, rows_type
   use dda_contact_search, only: find_contacts
   use dda_elements, only: set_elements, freeze_elements, balance_elements, prepare_elements
   use dda_damping, only: is_damped
   use dda_energy, only: energy_type, add_energy, energy_kinetic, energy_kinetic_damping, &
      energy_algorithmic, energy_strain
   use dda_energy_budget, only: strain_energy
   use dda_errors, only: error_type, error_convergence, error_input, error_interrupted, &
      error_memory, error_solver, fail
   use dda_falling, only: find_falling
   use dda_kinematics, only: damp_velocity, largest_displacement
   use dda_matrix_pattern, only: assemble_step, fit_pattern
   use dda_model, only: half_size
   use dda_scheme, only: scheme_type
   use dda_settings, only: control_type
   use dda_simulation, only: simulation_type, next_step, exchange_lists, block_name
   use dda_text, only: counted, quoted, short_text, to_text
   use dda_time_step, only: advance
   implicit none
   private
   public :: equilibrium_type, equilibrate, evaluate_present, find_farthest_block

   !> Record of the search for equilibrium.
   type :: equilibrium_type
      integer :: steps = 0                      !< number of static steps
      integer(long) :: budget = 0               !< largest number of open–close iterations
      logical :: at_rest = .false.              !< equilibrium has been reached
      real(wp) :: largest_force = huge(1.0_wp)        !< largest unbalanced force on a block, N/m
      integer :: block = 0  !< block with the largest ratio of force to tolerance
      real(wp) :: unbalanced = huge(1.0_wp)     !< unbalanced force of that block, N/m
      real(wp) :: tolerance = 0.0_wp              !< tolerance of that force, N/m
      real(wp) :: tolerance_ratio = 0.0_wp  !< largest tolerance of an unsupported block/its weight
      integer :: tolerance_block = 0            !< number of this unsupported block
      integer :: unexplained = 0  !< contact with a penetration not due to its force, or 0
      integer :: releases = 0                   !< number of removals of gap offsets
      integer :: falling = 0                    !< number of blocks that fall without limit
      integer :: first_falling = 0              !< first of the falling blocks
      !> largest allowed displacement of a centroid, m
      real(wp) :: displacement_limit = huge(1.0_wp)
      !> displacement of `block` if it exceeds `displacement_limit`, else 0, m
      real(wp) :: distance = 0.0_wp
      character(len=:), allocatable :: text    !< outcome as a text
   end type equilibrium_type

   integer, parameter :: most_steps = 200  !< largest number of static steps
   integer(long), parameter :: most_iterations = 20000  !< largest total of open–close iterations
   !> largest number of iterations without halving the unbalanced force: `stalled_iterations` +
   !> `stalled_work`/blocks, or + `yield_work`/blocks with yielding materials.  Walls need 50;
   !> stages with yielding materials converge early or never
   integer(long), parameter :: stalled_iterations = 200, stalled_work = 500000, yield_work = 20000
   real(wp), parameter :: tolerance = 1.0e-6_wp    !< largest unbalanced force/weight
   real(wp), parameter :: residual_factor = 4.0_wp  !< largest unbalanced force/contact tolerance
   !> tolerance/weight above which a block may still slide
   real(wp), parameter :: doubtful_ratio = 1.0e-3_wp
   real(wp), parameter :: rounding = 4.0_wp  !< rounding error of coordinates/last bit
   real(wp), parameter :: first_ratio = 1.0e-5_wp  !< M/(Δt² k_n) in the first step
   real(wp), parameter :: growth = 10.0_wp  !< factor of Δt after a step of at most few_iterations
   real(wp), parameter :: slow_growth = 2.0_wp     !< factor of Δt after a step with more iterations
   !> number of steps without halving after which the unbalanced force is a rounding error; models
   !> on dashpots must reach this limit
   integer, parameter :: max_stalled = 3
   !> largest number of relaxed steps without halving the unbalanced force; then the search begins
   !> again.  Walls of 4,000 bricks need up to 7; packings of polygons never converge
   integer, parameter :: max_stalled_relaxed = 8
   integer, parameter :: most_searches = 2  !< largest number of further searches
   real(wp), parameter :: nearly_balanced = 1.0e-3_wp  !< unbalanced force/weight near convergence
   !> largest penetration/contact distance without force in equilibrium
   real(wp), parameter :: fully_explained = 1.0e-3_wp
   !> number of offset removals after which a vertex may remain between the two edges that it pushes
   !> apart
   integer, parameter :: max_releases = 5
   integer, parameter :: few_iterations = 20  !< open–close iterations that permit `growth`
   real(wp), parameter :: shrink = 0.1_wp          !< factor of Δt after a failed step
   real(wp), parameter :: max_step_ratio = 1.0e2_wp       !< largest Δt/first Δt
   real(wp), parameter :: min_step_ratio = 1.0e-5_wp     !< smallest Δt/first Δt
   !> largest total displacement in a search for equilibrium/half the model size
   real(wp), parameter :: max_fall = 1.0_wp
   !> errors that another search would meet also
   integer, parameter :: final_errors(3) = [error_interrupted, error_memory, error_input]

contains

   !> Find static equilibrium of a simulation; time, step count and settings are restored.
   !> If equilibrium is not found, the error names a moving or unbalanced block.
   subroutine equilibrate(simulation, equilibrium, error, budget, displacement_limit)
      type(simulation_type), intent(inout) :: simulation  !< between two steps
      type(equilibrium_type), intent(out) :: equilibrium  !< record of the search
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      integer(long), intent(in), optional :: budget  !< largest number of open–close iterations
      !> displacement above which the search fails, m
      real(wp), intent(in), optional :: displacement_limit
      type(simulation_type), allocatable :: start
      type(error_type), allocatable :: failure
      type(control_type) :: control
      type(scheme_type) :: scheme
      real(wp) :: time
      integer(long) :: step

      control = simulation%model%control
      scheme = simulation%scheme
      time = simulation%time
      step = simulation%step
      call begin_statics(simulation)
      equilibrium%budget = most_iterations
      if (present(budget)) equilibrium%budget = min(budget, most_iterations)
      if (present(displacement_limit)) equilibrium%displacement_limit = displacement_limit
      if (simulation%iteration%may_relax .and. .not. present(budget)) start = simulation
      call step_to_rest(simulation, equilibrium, failure)
      if (allocated(start)) call search_again(simulation, start, equilibrium, failure)
      call write_outcome(simulation, equilibrium, failure)
      if (.not. equilibrium%at_rest) call fail(error, error_convergence, equilibrium%text)
      if (allocated(failure)) then
         if (any(failure%kind == final_errors)) call move_alloc(failure, error)
      end if
      simulation%in_statics = .false.
      simulation%iteration%may_stop = .false.
      simulation%iteration%may_relax = .false.
      simulation%iteration%unbalanced_work = 0.0_wp
      simulation%model%control = control
      simulation%scheme = scheme
      simulation%laws%theta = scheme%theta
      simulation%time = time
      simulation%step = step
      simulation%time_step = control%time_step
      simulation%blocks%damps = any(is_damped(simulation%blocks%damping))
      call begin_memory(simulation%blocks)
      call set_elements(simulation%elements, simulation%model, simulation%blocks, time)
      call fit_pattern(simulation)
      if (equilibrium%at_rest) call balance_elements(simulation%elements, simulation%blocks, &
         simulation%system%rhs)
   end subroutine equilibrate

   !> Search again: without relaxation if relaxed steps stalled, else with relaxation.
   !> The search begins at the initial state, or at the present state if relaxed steps have nearly
   !> reached equilibrium.  If no search reaches equilibrium, the first search is reported.
   subroutine search_again(simulation, start, equilibrium, error)
      type(simulation_type), intent(inout) :: simulation  !< between two steps
      type(simulation_type), intent(in) :: start          !< state before the first static step
      type(equilibrium_type), intent(inout) :: equilibrium  !< record of the search so far
      type(error_type), allocatable, intent(inout) :: error  !< error of the last step, if it failed
      type(simulation_type), allocatable :: first_record
      type(equilibrium_type) :: record
      type(error_type), allocatable :: failure
      integer :: search
      logical :: relaxes

      if (is_decided(equilibrium, error)) return
      first_record = simulation
      record = equilibrium
      if (allocated(error)) failure = error
      associate (iteration => simulation%iteration)
         do search = 1, most_searches
            if (.not. iteration%may_relax .or. is_decided(equilibrium, error)) exit
            if (allocated(error)) deallocate (error)
            relaxes = .not. iteration%relaxes
            if (relaxes .or. equilibrium%largest_force > nearly_balanced*iteration%weight) &
               simulation = start
            iteration%may_relax = relaxes
            iteration%relaxes = relaxes
            iteration%converged = .true.
            call step_to_rest(simulation, equilibrium, error)
         end do
      end associate
      if (is_decided(equilibrium, error)) return
      simulation = first_record
      equilibrium = record
      call move_alloc(failure, error)
   end subroutine search_again

   !> .true. if another search cannot change the outcome.
   pure logical function is_decided(equilibrium, error)  ! total
      type(equilibrium_type), intent(in) :: equilibrium  !< record of the search so far
      type(error_type), allocatable, intent(in) :: error  !< error of the last step, if it failed

      is_decided = equilibrium%at_rest .or. equilibrium%falling > 0 &
         .or. equilibrium%distance > 0.0_wp
      if (allocated(error)) is_decided = is_decided .or. any(error%kind == final_errors)
   end function is_decided

   !> Remove the stresses of Maxwell branches; their energy is dissipated.
   subroutine remove_damping_stress(blocks, energy)
      type(blocks_type), intent(inout) :: blocks  !< between two steps
      type(energy_type), intent(inout) :: energy  !< energy budget, J per metre
      real(wp) :: initial_energy

      if (.not. blocks%damps) return
      initial_energy = energy%value(energy_strain)
      blocks%damps = .false.
      energy%value(energy_strain) = strain_energy(blocks)
      call add_energy(energy, energy_algorithmic, initial_energy - energy%value(energy_strain))
   end subroutine remove_damping_stress

   !> Select backward Euler, stop all blocks, and freeze time-dependent values at the present time.
   subroutine begin_statics(simulation)
      type(simulation_type), intent(inout) :: simulation  !< between two steps

      simulation%model%control%dynamic_factor = 0.0_wp
      simulation%model%control%adaptive = .false.
      simulation%time_step = sqrt(maxval(simulation%blocks%mass) &
         /(first_ratio*simulation%laws%normal_stiffness))
      simulation%in_statics = .true.
      associate (laws => simulation%laws)
         simulation%iteration%may_relax = .not. (laws%damped .or. laws%augmented .or. laws%dilating)
      end associate
      simulation%iteration%relaxes = .false.
      simulation%iteration%converged = .true.
      simulation%iteration%may_stop = .true.
      simulation%scheme = scheme_type(1.0_wp, 1.0_wp)
      simulation%laws%theta = 1.0_wp
      call freeze_elements(simulation%elements, simulation%blocks, simulation%time)
      call pass_columns_to_sides(simulation)
      call stop_blocks(simulation)
      call remove_damping_stress(simulation%blocks, simulation%energy)
   end subroutine begin_statics

   !> Perform static steps until forces balance and explain all penetrations.
   subroutine step_to_rest(simulation, equilibrium, error)
      type(simulation_type), intent(inout) :: simulation  !< between two steps
      type(equilibrium_type), intent(inout) :: equilibrium  !< record of the search
      type(error_type), allocatable, intent(out) :: error  !< error of a step with the shortest Δt
      real(wp) :: first_time_step, distance, smallest_force
      real(wp), allocatable :: initial_positions(:,:)
      integer(long) :: iterations, last_progress
      integer :: stalled

      initial_positions = simulation%blocks%position(1:2, :)
      smallest_force = huge(1.0_wp)
      stalled = 0
      first_time_step = simulation%time_step
      iterations = simulation%counters%iterations
      last_progress = iterations
      distance = 0.0_wp
      do
         call find_unbalanced_forces(simulation, equilibrium, error)
         if (allocated(error)) return
         equilibrium%at_rest = equilibrium%unbalanced <= equilibrium%tolerance &
            .and. simulation%iteration%converged
         call find_unexplained_penetration(simulation, equilibrium)
         if (.not. equilibrium%at_rest) call record_falling(simulation, equilibrium)
         if (equilibrium%falling > 0) return
         if (equilibrium%largest_force < 0.5_wp*smallest_force) last_progress = &
            simulation%counters%iterations
         stalled = merge(0, stalled + 1, equilibrium%largest_force < 0.5_wp*smallest_force)
         smallest_force = min(smallest_force, equilibrium%largest_force)
         if (equilibrium%at_rest .and. (stalled >= max_stalled .or. &
            size(simulation%model%boundaries) + size(simulation%model%free_fields) == 0)) return
         if (equilibrium%steps == most_steps) return
         if (distance > max_fall*half_size(simulation%blocks)) return
         if (simulation%counters%iterations - iterations > equilibrium%budget) return
         if (simulation%counters%iterations - last_progress > stalled_iterations &
            + merge(yield_work, stalled_work, any(simulation%model%materials%yields())) &
            /simulation%blocks%n) return
         if (simulation%iteration%relaxes .and. stalled >= max_stalled_relaxed .and. &
            equilibrium%largest_force > nearly_balanced*simulation%iteration%weight) return
         if (equilibrium%unexplained > 0 .and. equilibrium%releases < max_releases) &
            call remove_contact_offsets(simulation, equilibrium)
         call perform_static_step(simulation, first_time_step, error)
         if (allocated(error)) equilibrium%at_rest = .false.
         if (allocated(error)) return
         equilibrium%steps = equilibrium%steps + 1
         distance = distance + largest_displacement(simulation%blocks, simulation%system%d)
         if (distance > equilibrium%displacement_limit) &
            call limit_movement(simulation, equilibrium, initial_positions)
         if (equilibrium%distance > 0.0_wp) return
      end do
   end subroutine step_to_rest

   !> Record the block with the largest displacement if the displacement exceeds the limit.
   subroutine limit_movement(simulation, equilibrium, initial_positions)
      type(simulation_type), intent(in) :: simulation  !< between two steps
      type(equilibrium_type), intent(inout) :: equilibrium  !< block and displacement are set
      real(wp), intent(in) :: initial_positions(:,:)  !< [2,blocks] centroids at the beginning, m
      real(wp) :: distance
      integer :: block

      call find_farthest_block(simulation%blocks, initial_positions, block, distance)
      if (distance <= equilibrium%displacement_limit) return
      equilibrium%at_rest = .false.
      equilibrium%block = block
      equilibrium%distance = distance
   end subroutine limit_movement

   !> Perform one static step; if it fails, the blocks do not move and Δt is reduced.
   subroutine perform_static_step(simulation, first_time_step, error)
      type(simulation_type), intent(inout) :: simulation  !< between two steps
      real(wp), intent(in) :: first_time_step  !< Δt of the first step, s
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      integer(long) :: step

      do
         simulation%speed = 0.0_wp
         step = simulation%step
         call advance(simulation, error)
         if (.not. allocated(error)) exit
         if (simulation%step > step .or. simulation%time_step <= min_step_ratio*first_time_step &
            .or. .not. (error%kind == error_convergence .or. error%kind == error_solver)) return
         simulation%time_step = shrink*simulation%time_step
         call exchange_lists(simulation)  ! restore the contacts of the last accepted step
      end do
      simulation%time_step = min(max_step_ratio*first_time_step, &
         simulation%time_step*merge(growth, slow_growth, simulation%iteration%iterations <= &
         few_iterations))
      call stop_blocks(simulation)
   end subroutine perform_static_step

   !> Set all velocities to zero and add the lost kinetic energy to the budget.
   subroutine stop_blocks(simulation)
      type(simulation_type), intent(inout) :: simulation  !< between two steps
      real(wp) :: loss

      call damp_velocity(simulation%blocks, 0.0_wp, loss)
      call add_energy(simulation%energy, energy_kinetic_damping, loss)
      simulation%energy%value(energy_kinetic) = 0.0_wp
      simulation%blocks%acceleration = 0.0_wp
      simulation%blocks%mean_velocity = 0.0_wp
   end subroutine stop_blocks

   !> List the contacts of the present geometry and evaluate their laws at d = 0.
   subroutine evaluate_present(simulation, error)
      type(simulation_type), intent(inout) :: simulation  !< between two steps
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      real(wp) :: unused(2)

      simulation%speed = 0.0_wp
      call find_contacts(simulation, error)
      if (allocated(error)) return
      simulation%system%d = 0.0_wp
      unused = 0.0_wp
      call evaluate_contacts(simulation%contacts(simulation%now), simulation%laws, &
         simulation%system%d, unused(1), unused(2))
   end subroutine evaluate_present

   !> Find the unbalanced forces on the blocks at rest: sums of contact forces, stresses, loads and
   !> element forces.  Moments are divided by the block radius.
   subroutine find_unbalanced_forces(simulation, equilibrium, error)
      type(simulation_type), intent(inout) :: simulation  !< contacts are listed again
      type(equilibrium_type), intent(inout) :: equilibrium  !< largest force and block are set
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      type(rows_type) :: rows
      integer :: c

      equilibrium%largest_force = huge(1.0_wp)
      equilibrium%unbalanced = huge(1.0_wp)
      equilibrium%block = 0
      call evaluate_present(simulation, error)
      if (allocated(error)) return
      associate (contacts => simulation%contacts(simulation%now), system => simulation%system, &
         blocks => simulation%blocks)
         call prepare_elements(simulation%elements, blocks, next_step(simulation), system%d)
         call assemble_step(simulation, error)
         if (allocated(error)) return
         system%rhs = system%load
         do c = 1, contacts%n
            associate (v => contacts%block_v(c), e => contacts%block_e(c), &
               n => contacts%normal_force(c), s => contacts%shear_force(c))
               call find_rows(contacts, c, rows)
               system%rhs(:, v) = system%rhs(:, v) + n*rows%normal_v - s*rows%shear_v
               system%rhs(:, e) = system%rhs(:, e) - n*rows%normal_e + s*rows%shear_e
            end associate
         end do
      end associate
      call compare_with_tolerance(simulation, equilibrium)
   end subroutine find_unbalanced_forces

   !> Find the largest unbalanced force, the block with the largest ratio of force to tolerance, and
   !> the unsupported block with the largest ratio of tolerance to weight.
   subroutine compare_with_tolerance(simulation, equilibrium)
      type(simulation_type), intent(in) :: simulation  !< unbalanced forces are in `system%rhs`
      type(equilibrium_type), intent(inout) :: equilibrium  !< largest force and blocks are set
      real(wp) :: force(6), size_of, tolerance, weight
      logical :: is_largest
      integer :: b

      equilibrium%largest_force = 0.0_wp
      equilibrium%tolerance = 1.0_wp
      equilibrium%tolerance_ratio = 0.0_wp
      associate (blocks => simulation%blocks, system => simulation%system)
         do b = 1, blocks%n
            force = system%rhs(:, b)
            size_of = norm2(force(1:2)) + (abs(force(3)) + norm2(force(4:6)))/blocks%radius(b)
            tolerance = allowed_force(simulation, b)
            is_largest = equilibrium%block == 0
            if (.not. is_largest) is_largest = &
               .not. size_of*equilibrium%tolerance <= equilibrium%unbalanced*tolerance
            if (is_largest) then
               equilibrium%block = b
               equilibrium%unbalanced = size_of
               equilibrium%tolerance = tolerance
            end if
            if (.not. size_of <= huge(size_of)) return
            equilibrium%largest_force = max(equilibrium%largest_force, size_of)
            weight = block_weight(simulation, b)
            if (blocks%removed(b) .or. system%has_terms(b) .or. &
               tolerance <= equilibrium%tolerance_ratio*weight) cycle
            equilibrium%tolerance_ratio = tolerance/max(weight, tiny(weight))
            equilibrium%tolerance_block = b
         end do
      end associate
   end subroutine compare_with_tolerance

   !> Tolerance of the unbalanced force on block b in equilibrium, N/m.
   pure real(wp) function allowed_force(simulation, b) result(allowed)
      type(simulation_type), intent(in) :: simulation  !< between two steps
      integer, intent(in) :: b  !< number of the block

      associate (iteration => simulation%iteration)
         allowed = max(tolerance*block_weight(simulation, b), &
            residual_factor*max(iteration%tolerance, iteration%noise))
      end associate
      if (simulation%system%has_terms(b)) allowed = max(allowed, rounding*epsilon(1.0_wp) &
         *half_size(simulation%blocks)*simulation%laws%normal_stiffness &
         *simulation%model%contact%fixed_point_ratio)
   end function allowed_force

   !> Weight of block b, N per metre of thickness.
   pure real(wp) function block_weight(simulation, b)
      type(simulation_type), intent(in) :: simulation  !< between two steps
      integer, intent(in) :: b  !< number of the block

      block_weight = norm2(simulation%model%control%gravity)*simulation%blocks%mass(b)
   end function block_weight

   !> Find the compressed contact whose penetration most exceeds the penetration due to its force.
   !> The excess is the gap offset.
   subroutine find_unexplained_penetration(simulation, equilibrium)
      type(simulation_type), intent(in) :: simulation  !< simulation whose contacts are evaluated
      !> record; not at rest if a contact is found
      type(equilibrium_type), intent(inout) :: equilibrium
      integer :: c
      real(wp) :: largest_excess

      equilibrium%unexplained = 0
      if (.not. equilibrium%at_rest) return
      largest_excess = fully_explained*simulation%detection%least
      associate (contacts => simulation%contacts(simulation%now))
         do c = 1, contacts%n
            if (contacts%new_gap(c) >= 0.0_wp .or. -contacts%offset(c) <= largest_excess) cycle
            largest_excess = -contacts%offset(c)
            equilibrium%unexplained = c
         end do
      end associate
      equilibrium%at_rest = equilibrium%unexplained == 0 &
         .or. (equilibrium%releases == max_releases .and. &
            largest_excess <= simulation%detection%least)
   end subroutine find_unexplained_penetration

   !> Record blocks that no contact forces can support and no block below can stop.
   subroutine record_falling(simulation, equilibrium)
      type(simulation_type), intent(in) :: simulation  !< simulation with its loads and contacts
      type(equilibrium_type), intent(inout) :: equilibrium  !< number and first block are set
      logical :: is_falling(simulation%blocks%n)

      call find_falling(simulation%blocks, simulation%contacts(simulation%now), simulation%laws, &
         simulation%system%load, simulation%system%has_terms, is_falling)
      equilibrium%falling = count(is_falling)
      equilibrium%first_falling = findloc(is_falling, .true., 1)
   end subroutine record_falling

   !> Remove the gap offsets of penetrating contacts, so that their forces match the penetration.
   !> A vertex that changes edges in a soft contact, such as in a fallen pile, receives an offset,
   !> because a force due to its penetration would add energy.
   subroutine remove_contact_offsets(simulation, equilibrium)
      type(simulation_type), intent(inout) :: simulation  !< simulation whose contacts are evaluated
      type(equilibrium_type), intent(inout) :: equilibrium  !< record; releases are counted

      associate (contacts => simulation%contacts(simulation%now))
         contacts%new_gap(:contacts%n) = contacts%new_gap(:contacts%n) &
            + min(0.0_wp, contacts%offset(:contacts%n))
         contacts%offset(:contacts%n) = max(0.0_wp, contacts%offset(:contacts%n))
      end associate
      equilibrium%unexplained = 0
      equilibrium%releases = equilibrium%releases + 1
   end subroutine remove_contact_offsets

   !> Find the block that has moved farthest from given positions, and its distance.
   subroutine find_farthest_block(blocks, initial_positions, block, distance)
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      real(wp), intent(in) :: initial_positions(:,:)        !< [≥2,blocks] centroids, m
      integer, intent(out) :: block            !< number of the block; 0: no block has moved
      real(wp), intent(out) :: distance        !< distance, m
      real(wp) :: displacement
      integer :: b

      block = 0
      distance = 0.0_wp
      do b = 1, blocks%n
         if (blocks%removed(b)) cycle
         displacement = norm2(blocks%position(1:2, b) - initial_positions(1:2, b))
         if (displacement <= distance) cycle
         distance = displacement
         block = b
      end do
   end subroutine find_farthest_block

   !> Write the outcome of the search as a text.
   subroutine write_outcome(simulation, equilibrium, error)
      type(simulation_type), intent(in) :: simulation  !< a run and its state
      type(equilibrium_type), intent(inout) :: equilibrium  !< record of the search
      type(error_type), allocatable, intent(in) :: error  !< error of the last step, if it failed

      if (equilibrium%at_rest) then
         equilibrium%text = equilibrium_text(simulation, equilibrium)
         return
      end if
      if (equilibrium%unexplained > 0) then
         equilibrium%text = 'forces balance after '//static_steps_text(equilibrium)// &
            ', but '//penetration_text(simulation, equilibrium%unexplained)
         return
      end if
      equilibrium%text = 'not at rest after '//static_steps_text(equilibrium)
      if (equilibrium%falling > 0) then
         equilibrium%text = equilibrium%text//': block '//block_name(simulation, &
            equilibrium%first_falling)//falling_text(equilibrium%falling - 1)// &
            ': no forces at the contacts can balance the loads, and no block is below'
         return
      end if
      if (equilibrium%distance > 0.0_wp) then
         equilibrium%text = equilibrium%text//': block '//block_name(simulation, &
            equilibrium%block)//' has moved by '//short_text(equilibrium%distance)// &
            ' m; displacement of &stage is '//short_text(equilibrium%displacement_limit)//' m'// &
            sliding_contact_text(simulation, equilibrium%block)
         return
      end if
      if (equilibrium%block > 0) equilibrium%text = equilibrium%text//': block '// &
         block_name(simulation, equilibrium%block)//' has an unbalanced force of '// &
         short_text(equilibrium%unbalanced)//' N/m, allowed '//short_text(equilibrium%tolerance)// &
         sliding_contact_text(simulation, equilibrium%block)
      if (.not. simulation%iteration%converged) equilibrium%text = equilibrium%text// &
         ', and the contacts of the last step do not converge'
      if (allocated(error)) equilibrium%text = equilibrium%text//'; then '//error%message
   end subroutine write_outcome

   !> Text on the most loaded contact and its joint: among the sliding contacts of block b; if none
   !> slides, among all sliding contacts; if there are none, among all contacts of b.
   function sliding_contact_text(simulation, b) result(text)
      type(simulation_type), intent(in) :: simulation  !< a run and its state
      integer, intent(in) :: b                         !< block with an unbalanced force
      character(len=:), allocatable :: text
      integer :: c, most_loaded(3), sliding
      logical :: of_block

      most_loaded = 0
      sliding = 0
      text = '; check supports, joints and gaps'
      if (any(simulation%model%materials%yields())) text = '; a material may yield: load or '// &
         'excavate in several stages, or check supports, joints and gaps'
      associate (contacts => simulation%contacts(simulation%now), joints => simulation%model%joints)
         do c = 1, contacts%n
            of_block = contacts%block_v(c) == b .or. contacts%block_e(c) == b
            if (of_block) most_loaded(3) = larger_force(contacts, most_loaded(3), c)
            if (contacts%state(c) /= contact_slide) cycle
            sliding = sliding + 1
            most_loaded(2) = larger_force(contacts, most_loaded(2), c)
            if (of_block) most_loaded(1) = larger_force(contacts, most_loaded(1), c)
         end do
         c = merge(most_loaded(1), most_loaded(2), most_loaded(1) > 0)
         if (c == 0) then
            if (most_loaded(3) > 0) text = '; no contact slides; largest contact force on the '// &
               'block '//short_text(contacts%normal_force(most_loaded(3)))//' N/m on '// &
               joint_label(joints(contacts%joint(most_loaded(3)))%name)//'; check this joint, '// &
               'supports and gaps'
            return
         end if
         text = '; '//counted(to_text(sliding), 'contact slides', 'contacts slide')//': block '// &
            block_name(simulation, contacts%block_v(c))//' slides on '// &
            block_name(simulation, contacts%block_e(c))//' along '// &
            joint_label(joints(contacts%joint(c))%name)//'; increase its friction, add a '// &
            'support or a bolt, or let the block slide in a dynamic stage'
      end associate
   end function sliding_contact_text

   !> Name of a joint material in a message.
   pure function joint_label(name) result(label)
      character(len=*), intent(in) :: name  !< name in the input; blank: none
      character(len=:), allocatable :: label

      label = 'joint '//quoted(trim(name))
      if (name == '') label = 'the joint without a name'
   end function joint_label

   !> Select the contact with the larger normal force; `first` may be 0.
   pure integer function larger_force(contacts, first, second)
      type(contacts_type), intent(in) :: contacts  !< contacts of the last step
      integer, intent(in) :: first, second         !< contacts; first may be 0

      larger_force = second
      if (first == 0) return
      if (contacts%normal_force(first) >= contacts%normal_force(second)) larger_force = first
   end function larger_force

   !> Text ' falls', or ' and N others fall'.
   pure function falling_text(n) result(text)
      integer, intent(in) :: n  !< number of other blocks
      character(len=:), allocatable :: text

      select case (n)
      case (0)
         text = ' falls'
      case (1)
         text = ' and another fall'
      case default
         text = ' and '//to_text(n)//' others fall'
      end select
   end function falling_text

   !> Text on two blocks whose penetration exceeds the penetration due to their contact force.
   function penetration_text(simulation, c) result(text)
      type(simulation_type), intent(in) :: simulation  !< a run and its state
      integer, intent(in) :: c                         !< contact with this penetration
      character(len=:), allocatable :: text

      associate (contacts => simulation%contacts(simulation%now))
         text = 'block '//block_name(simulation, contacts%block_v(c))//' penetrates '// &
            short_text(-contacts%new_gap(c) - contacts%offset(c))//' m into block '// &
            block_name(simulation, contacts%block_e(c))//'; the contact force '// &
            'accounts for '//short_text(-contacts%new_gap(c))//' m of this'
      end associate
   end function penetration_text

   !> Text that states the number of static steps.
   pure function static_steps_text(equilibrium) result(text)
      type(equilibrium_type), intent(in) :: equilibrium  !< record of the search
      character(len=:), allocatable :: text

      text = counted(to_text(equilibrium%steps), 'static step', 'static steps')
   end function static_steps_text

   !> Text on the accuracy of the equilibrium.
   function equilibrium_text(simulation, equilibrium) result(text)
      type(simulation_type), intent(in) :: simulation  !< a run and its state
      type(equilibrium_type), intent(in) :: equilibrium  !< record of a search with equilibrium
      character(len=:), allocatable :: text
      real(wp) :: weight

      text = 'at rest after '//static_steps_text(equilibrium)//', largest unbalanced force '// &
         short_text(equilibrium%largest_force)//' N/m'
      weight = norm2(simulation%model%control%gravity)*sum(simulation%blocks%mass)
      if (weight > 0.0_wp) text = text//', '//short_text(equilibrium%largest_force/weight)// &
         ' of the weight'
      if (equilibrium%tolerance_ratio > doubtful_ratio) text = text//'; but a force below '// &
         short_text(equilibrium%tolerance_ratio)//' of the weight of block '// &
         block_name(simulation, equilibrium%tolerance_block)// &
            ' is neglected, so this block may still slide '// &
         '(reduce force_tolerance or normal_stiffness of &contact)'
      if (equilibrium%unexplained > 0) text = text//'; but '// &
         penetration_text(simulation, equilibrium%unexplained)//': a vertex lies between two edges'
   end function equilibrium_text

end module dda_equilibrium
