! SPDX-License-Identifier: GPL-3.0-or-later
!> Stages of a run: static equilibrium, excavation, changes, dynamics, in the order of the input.
!>
!> A static stage takes no time, and its steps are not counted.  If the first stage is static, the
!> energy budget begins after this stage, with the stored energy; dissipation in later static stages
!> has its own term.
module dda_stages
   use dda_kinds, only: wp, long
   use dda_blocks, only: change_material, position_of, remove_block, update_geometry
   use dda_columns, only: column_count, column_of, name_column
   use dda_contact, only: filter_contacts
   use dda_crossings, only: release_removed
   use dda_doubts, only: add_doubt
   use dda_elements, only: block_stress, match_velocities, set_elements
   use dda_energy, only: energy_type, add_energy, total_energy, &
      energy_kinetic, energy_strain, energy_contact, energy_support, energy_water, energy_welded, &
      energy_gravity, energy_geometric, energy_algorithmic, energy_kinetic_damping, energy_static, &
      energy_removed, energy_changed, energy_initial, energy_zeroed
   use dda_energy_budget, only: start_energy_budget
   use dda_equilibrium, only: equilibrium_type, equilibrate, evaluate_present, find_farthest_block
   use dda_errors, only: error_type, error_input, error_interrupted, fail
   use dda_friction, only: accept_contacts
   use dda_model, only: model_type
   use dda_motion, only: displacement_of
   use dda_joint_motion, only: check_measured_joints
   use dda_running_maxima, only: begin_maxima, restart_points
   use dda_scheme, only: scheme_named
   use dda_simulation, only: simulation_type, counters_type, next_step, block_name
   use dda_stage, only: stage_type, never
   use dda_start, only: start
   use dda_stop_rule, only: begin_stop_rule
   use dda_support, only: point_type
   use dda_text, only: quoted, short_text, to_text
   implicit none
   private
   public :: begin_simulation, begin_first_stage, begin_next_stage, restore_stages, update_budget, &
      place_now

contains

   !> Start a run of a model, with its stages up to the first dynamic stage.
   subroutine begin_simulation(simulation, model, error)
      type(simulation_type), intent(out) :: simulation  !< ready for its first step
      type(model_type), intent(in) :: model             !< model as read from the input
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure

      call start(simulation, model, error)
      if (.not. allocated(error)) call begin_first_stage(simulation, error)
   end subroutine begin_simulation

   !> Begin the first stage of a simulation; after static stages, also the first dynamic stage.
   subroutine begin_first_stage(simulation, error)
      type(simulation_type), intent(inout) :: simulation  !< between two steps
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure

      call begin_next_stage(simulation, error)
      if (.not. allocated(error) .and. size(simulation%model%stages) > 1) then
         if (simulation%model%stages(1)%static .and. .not. simulation%model%stages(2)%static) &
            call begin_next_stage(simulation, error)
      end if
      if (allocated(error)) return
      call begin_stop_rule(simulation)
      call begin_maxima(simulation)
      call check_measured_joints(simulation, error)
   end subroutine begin_first_stage

   !> Begin the next stage, first for the columns of free fields.
   recursive subroutine begin_next_stage(simulation, error)
      type(simulation_type), intent(inout) :: simulation  !< between two steps
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      integer :: s, i

      do i = 1, column_count(simulation)
         call begin_next_stage(column_of(simulation, i), error)
         call name_column(simulation, i, error)
         if (allocated(error)) return
      end do
      s = simulation%stage + 1
      simulation%stage = s
      simulation%first_step = simulation%step
      simulation%first_time = simulation%time
      call set_stepping(simulation, s)
      associate (stage => simulation%model%stages(s))
         if (changes_model(stage) .or. s > 1) call change_model(simulation, s, error)
         if (allocated(error)) return
         if (stage%zero_displacements) call zero_displacements(simulation)
         if (stage%static) call refuse_moving_supports(simulation, error)
         if (stage%static .and. .not. allocated(error)) call find_equilibrium(simulation, error)
      end associate
      if (findloc(simulation%model%stages%static, .false., 1) == s .and. .not. allocated(error)) &
         call displace_block(simulation, error)
      if (allocated(error)) error%message = simulation%model%file//': stage '// &
         quoted(trim(simulation%model%stages(s)%name))//unsettled_stage_text(error)
   end subroutine begin_next_stage

   !> Displace a block slightly when dynamics begin, if the input has `displaced_block`.
   !>
   !> Runs with and without this displacement agree as long as the motion is predictable.  Bonds,
   !> joint crossings and the contacts whose slip is measured are determined before the displacement
   !> and thus equal in both runs.  The change of stored energy belongs to the initial state.
   subroutine displace_block(simulation, error)
      type(simulation_type), intent(inout) :: simulation  !< between two steps
      type(error_type), allocatable, intent(inout) :: error  !< allocated on failure
      real(wp) :: distance(2)

      associate (control => simulation%model%control, b => simulation%model%control%displaced, &
         blocks => simulation%blocks)
         if (b == 0) return
         if (blocks%removed(b)) call fail(error, error_input, 'displaced_block of &control is '// &
            'block '//block_name(simulation, b)//', which is removed before the first dynamic '// &
            'stage')
         if (allocated(error)) return
         distance = control%displaced_by*sqrt(blocks%area(b))
         blocks%position(1:2, b) = blocks%position(1:2, b) + distance
         call update_geometry(blocks)
         simulation%neighbours%travel = simulation%neighbours%travel + norm2(distance)
      end associate
      call evaluate_present(simulation, error)
      if (.not. allocated(error)) call update_budget(simulation, energy_initial, 1.0_wp)
   end subroutine displace_block

   !> Reject supports that still move after their record: their blocks cannot reach equilibrium.
   subroutine refuse_moving_supports(simulation, error)
      type(simulation_type), intent(in) :: simulation  !< between two steps
      type(error_type), allocatable, intent(out) :: error  !< error with the name of the motion
      integer :: i, m

      associate (model => simulation%model)
         do m = 1, size(model%motions)
            associate (curve => model%motions(m)%curve)
               if (.not. abs(curve%velocity_after) > 0.0_wp .or. simulation%time &
                  < curve%start + curve%duration) cycle
               if (.not. any([(any(model%fixed_points(i)%motion == m .and. &
                  model%fixed_points(i)%fixed_along), i=1, size(model%fixed_points)), &
                  (any(model%boundaries(i)%motion == m), i=1, size(model%boundaries))])) cycle
               call fail(error, error_input, quoted(trim(model%motions(m)%name))//' of &'// &
                  'motion continues with '//short_text(curve%velocity_after)//' m/s after its '// &
                  'record, but supports cannot move in a static stage: set '// "after_end = 'hold'")
               return
            end associate
         end do
      end associate
   end subroutine refuse_moving_supports

   !> Text on the reason why a stage has not reached equilibrium, and what to do.
   pure function unsettled_stage_text(error) result(text)
      type(error_type), intent(in) :: error  !< error of the static steps
      character(len=:), allocatable :: text

      text = ' does not settle: '//error%message
      if (error%kind == error_interrupted) text = ' was interrupted before equilibrium; '// &
         'resume starts the stage again'
   end function unsettled_stage_text

   !> .true. if the stage begins a motion or changes blocks, supports, materials or joints.
   pure logical function changes_model(stage)  ! total
      type(stage_type), intent(in) :: stage  !< stage that begins

      changes_model = any(stage%removed) .or. any(stage%released) .or. any(stage%holds) &
         .or. any(stage%loads) .or. .not. all(stage%begins) &
         .or. any(stage%added) .or. any(stage%dropped) &
         .or. changes_numbers(stage%joint) .or. changes_numbers(stage%material)
   end function changes_model

   !> .true. if a joint or material is replaced by another one.
   pure logical function changes_numbers(list)  ! total
      integer, intent(in) :: list(:)  !< [joints or materials] number of the replacement
      integer :: i

      changes_numbers = any(list /= [(i, i=1, size(list))])
   end function changes_numbers

   !> Set Δt, number of steps and time integration of a dynamic stage.
   subroutine set_stepping(simulation, s)
      type(simulation_type), intent(inout) :: simulation  !< between two steps
      integer, intent(in) :: s  !< stage

      associate (stage => simulation%model%stages(s), control => simulation%model%control)
         if (stage%static) return
         control%time_step = stage%time_step
         control%step_count = stage%steps
         control%integration = stage%integration
         control%theta = stage%theta
         simulation%scheme = scheme_named(stage%integration, stage%theta)
         simulation%laws%theta = simulation%scheme%theta
         simulation%time_step = stage%time_step
      end associate
   end subroutine set_stepping

   !> Set blocks, supports, motions, materials and joints of a stage, and update the energy budget.
   subroutine change_model(simulation, s, error)
      type(simulation_type), intent(inout) :: simulation  !< between two steps
      integer, intent(in) :: s  !< stage
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      integer :: i

      call evaluate_present(simulation, error)
      if (allocated(error)) return
      associate (stage => simulation%model%stages(s))
         call begin_motions(simulation, s)
         call replace_properties(simulation, s)
         call add_attachments(simulation%model, stage)
         associate (contacts => simulation%contacts(simulation%now))
            contacts%joint(:contacts%n) = stage%joint(contacts%joint(:contacts%n))
         end associate
         call activate_points(simulation, s)
         call set_elements(simulation%elements, simulation%model, simulation%blocks, &
            simulation%time)
         if (any(stage%holds)) call match_velocities(simulation%elements, simulation%blocks, &
            next_step(simulation))
         call update_budget(simulation, energy_changed, 1.0_wp)
         call remove_parts(simulation, s)
         call set_elements(simulation%elements, simulation%model, simulation%blocks, &
            simulation%time)
         if (any(stage%added) .or. any(stage%dropped)) simulation%neighbours%reach = 0.0_wp
         if (any(stage%removed)) then
            associate (contacts => simulation%contacts(simulation%now))
               call release_removed(simulation%detection%across, contacts, stage%removed)
               call filter_contacts(contacts, [(.not. (stage%removed(contacts%block_v(i)) .or. &
                  stage%removed(contacts%block_e(i))), i=1, contacts%n)])
            end associate
            simulation%neighbours%reach = 0.0_wp  ! search neighbours again
         end if
         call update_budget(simulation, energy_removed, -1.0_wp)
      end associate
   end subroutine change_model

   !> Update the stored energies, and add their change to a term of the budget.
   subroutine update_budget(simulation, term, sign_of)
      type(simulation_type), intent(inout) :: simulation  !< between two steps
      integer, intent(in) :: term  !< term of the budget
      real(wp), intent(in) :: sign_of  !< 1: the term is a gain; −1: a loss
      type(energy_type) :: present_energy
      real(wp) :: former_energy
      integer, parameter :: state(*) = [energy_kinetic, energy_strain, energy_contact, &
         energy_support, energy_water, energy_welded]

      call start_energy_budget(present_energy, simulation%blocks, &
         simulation%contacts(simulation%now), simulation%laws, simulation%elements, &
         next_step(simulation))
      former_energy = total_energy(simulation%energy)
      simulation%energy%value(state) = present_energy%value(state)
      call add_energy(simulation%energy, term, sign_of*(total_energy(simulation%energy) &
         - former_energy))
   end subroutine update_budget

   !> Start the motions of a stage; motions of later stages do not start.
   subroutine begin_motions(simulation, s)
      type(simulation_type), intent(inout) :: simulation  !< between two steps
      integer, intent(in) :: s  !< stage
      integer :: m, k

      do m = 1, size(simulation%model%motions)
         do k = 1, size(simulation%model%stages)
            if (simulation%model%stages(k)%begins(m)) exit
         end do
         if (k > s) simulation%model%motions(m)%curve%start = never
         if (k == s) simulation%model%motions(m)%curve%start = simulation%time
      end do
   end subroutine begin_motions

   !> Activate the fixed points of a stage at their present positions, and the loads of the stage.
   subroutine activate_points(simulation, s)
      type(simulation_type), intent(inout) :: simulation  !< between two steps
      integer, intent(in) :: s  !< stage
      integer :: i

      associate (model => simulation%model, stage => simulation%model%stages(s))
         do i = 1, size(model%fixed_points)
            if (.not. stage%holds(i)) cycle
            model%fixed_points(i)%fixed_along = model%fixed_points(i)%waiting
            model%fixed_points(i)%position = place_now(simulation, i)
         end do
         do i = 1, size(model%loads)
            if (stage%loads(i)) model%loads(i)%start = simulation%time
         end do
      end associate
   end subroutine activate_points

   !> Position of a fixed point without its prescribed displacement, m.
   pure function place_now(simulation, i) result(position)
      type(simulation_type), intent(in) :: simulation  !< between two steps
      integer, intent(in) :: i  !< fixed point
      real(wp) :: position(2)

      associate (point => simulation%model%fixed_points(i), motions => simulation%model%motions)
         position = position_of(simulation%blocks, point%block, point%reference) &
            - matmul(point%axes, displacement_of(motions, point%motion, simulation%time))
      end associate
   end function place_now

   !> Replace materials and joints of blocks.
   subroutine replace_properties(simulation, s)
      type(simulation_type), intent(inout) :: simulation  !< between two steps
      integer, intent(in) :: s  !< stage
      integer :: b, replacement

      associate (stage => simulation%model%stages(s), blocks => simulation%blocks)
         blocks%joint = stage%joint(blocks%joint)
         do b = 1, blocks%n
            associate (joint => blocks%joint(blocks%first(b):blocks%first(b + 1) - 1))
               blocks%mixed(b) = any(joint /= joint(1))
            end associate
            if (blocks%removed(b)) cycle
            replacement = stage%material(blocks%material(b))
            if (replacement == blocks%material(b)) cycle
            call change_material(blocks, b, replacement, simulation%model%materials(replacement), &
               simulation%model%control%plane_strain)
         end do
         simulation%system%constant_step%time_step = 0.0_wp  ! M and K have changed
      end associate
   end subroutine replace_properties

   !> Add bolts and edge loads of the stage.
   pure subroutine add_attachments(model, stage)
      type(model_type), intent(inout) :: model  !< model; bolts and edge loads change
      type(stage_type), intent(in) :: stage  !< stage that begins

      associate (n => size(model%bolts))
         model%bolts%present = model%bolts%present .or. stage%added(:n)
         model%edge_loads%present = model%edge_loads%present .or. stage%added(n + 1:)
      end associate
   end subroutine add_attachments

   !> Remove bolts and edge loads of the stage, and bolts of removed blocks.
   pure subroutine drop_attachments(model, is_removed, stage)
      type(model_type), intent(inout) :: model  !< model; bolts and edge loads change
      logical, intent(in) :: is_removed(:)         !< [blocks]
      type(stage_type), intent(in) :: stage  !< stage that begins
      integer :: i, n

      n = size(model%bolts)
      do i = 1, n
         if (stage%dropped(i) .or. any(is_removed(model%bolts(i)%block))) &
            model%bolts(i)%present = .false.
      end do
      model%edge_loads%present = model%edge_loads%present .and. .not. stage%dropped(n + 1:)
   end subroutine drop_attachments

   !> Remove blocks and supports of the stage, with the supports and loads of these blocks.
   subroutine remove_parts(simulation, s)
      type(simulation_type), intent(inout) :: simulation  !< between two steps
      integer, intent(in) :: s  !< stage
      integer :: b

      associate (stage => simulation%model%stages(s), model => simulation%model)
         do b = 1, simulation%blocks%n
            if (stage%removed(b)) call remove_block(simulation%blocks, b)
         end do
         do b = 1, size(model%fixed_points)
            if (stage%released(b) .or. simulation%blocks%removed(model%fixed_points(b)%block)) &
               model%fixed_points(b)%fixed_along = .false.
         end do
         call drop_attachments(model, simulation%blocks%removed, stage)
         do b = 1, size(model%loads)
            if (simulation%blocks%removed(model%loads(b)%block)) model%loads(b)%start = never
         end do
      end associate
   end subroutine remove_parts

   !> Reset displacements of measured points and boundaries, and the potential of gravity.
   subroutine zero_displacements(simulation)
      type(simulation_type), intent(inout) :: simulation  !< between two steps
      integer :: i

      associate (points => simulation%model%points, energy => simulation%energy)
         call set_displacement_origins(points)
         call restart_points(simulation)
         do i = 1, size(simulation%model%boundary_motions)
            call set_displacement_origins(simulation%model%boundary_motions(i)%point)
         end do
         call add_energy(energy, energy_zeroed, -energy%value(energy_gravity))
         energy%value(energy_gravity) = 0.0_wp
      end associate

   contains

      !> Set the present positions of points as origins of their displacements.
      pure subroutine set_displacement_origins(points)
         type(point_type), intent(inout) :: points(:)  !< measured points
         integer :: k

         do k = 1, size(points)
            points(k)%position = position_of(simulation%blocks, points(k)%block, &
               points(k)%reference)
         end do
      end subroutine set_displacement_origins
   end subroutine zero_displacements

   !> Find static equilibrium under gravity and the loads of the present time.
   subroutine find_equilibrium(simulation, error)
      type(simulation_type), intent(inout) :: simulation  !< between two steps
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      type(equilibrium_type) :: equilibrium
      type(energy_type) :: initial_energy
      real(wp), allocatable :: initial_positions(:,:), stress(:,:)
      integer(long) :: broken_bonds

      stress = block_stress(simulation%elements, simulation%blocks)
      initial_energy = simulation%energy
      broken_bonds = simulation%counters%broken
      initial_positions = simulation%blocks%position(1:2, :)
      call equilibrate(simulation, equilibrium, error, &
         displacement_limit=simulation%model%stages(simulation%stage)%displacement)
      if (allocated(error)) return
      call accept_contacts(simulation%contacts(simulation%now), simulation%laws)
      broken_bonds = simulation%counters%broken - broken_bonds
      if (broken_bonds > 0) call add_doubt(simulation%doubts, 'bonds', to_text(broken_bonds)// &
         ' broken in static steps; remaining contacts of brittle joints may be too strong '// &
         '(use contact_points = 5)')
      associate (energy => simulation%energy, stage => simulation%model%stages(simulation%stage))
         if (simulation%statics /= '') simulation%statics = simulation%statics//'; '
         simulation%statics = simulation%statics//'stage '//quoted(trim(stage%name))//' '// &
            equilibrium%text//static_movement_text(simulation, initial_positions)
         if (simulation%stage > 1) then
            call assign_static_losses(energy, initial_energy)
            return
         end if
         simulation%statics = simulation%statics//stress_correction_text(simulation, stress)
         simulation%counters = counters_type(searches=simulation%counters%searches)
         simulation%path = 0.0_wp
         simulation%last_time_step = 0.0_wp
         simulation%iteration%iterations = 0
         call start_energy_budget(energy, simulation%blocks, simulation%contacts(simulation%now), &
            simulation%laws, simulation%elements, next_step(simulation))
      end associate
   end subroutine find_equilibrium

   !> Text on the largest change of the initial stress in a static stage.
   function stress_correction_text(simulation, initial_stress) result(text)
      type(simulation_type), intent(in) :: simulation  !< simulation in equilibrium
      real(wp), intent(in) :: initial_stress(:,:)              !< [3,blocks] initial stress, Pa
      character(len=:), allocatable :: text
      real(wp) :: stress_change(3, simulation%blocks%n)
      integer :: peak_index(2)

      text = ''
      if (.not. allocated(simulation%model%stress_gradient)) return
      stress_change = abs(block_stress(simulation%elements, simulation%blocks) - initial_stress)
      peak_index = maxloc(stress_change)
      text = '; in-situ stress corrected by at most '//short_text(stress_change(peak_index(1), &
         peak_index(2)))//' Pa, '//short_text(stress_change(peak_index(1), &
         peak_index(2))/maxval(abs(initial_stress)))//' of the largest stress, in block '// &
         block_name(simulation, peak_index(2))
   end function stress_correction_text

   !> Text on the largest movement in a static stage, and on the largest distance from the input.
   function static_movement_text(simulation, initial_positions) result(text)
      type(simulation_type), intent(in) :: simulation  !< simulation in equilibrium
      real(wp), intent(in) :: initial_positions(:,:)         !< [2,blocks] centroids at the start, m
      character(len=:), allocatable :: text
      integer :: b
      real(wp) :: distance

      call find_farthest_block(simulation%blocks, initial_positions, b, distance)
      if (b == 0) then
         text = '; no block moved'
      else
         text = '; block '//block_name(simulation, b)//' moved farthest, by '// &
            short_text(distance)//' m'
      end if
      if (simulation%stage == 1) return
      call find_farthest_block(simulation%blocks, simulation%model%blocks%position, b, distance)
      if (b > 0) text = text//'; block '//block_name(simulation, b)//' is '// &
         short_text(distance)//' m from its position in the input'
   end function static_movement_text

   !> Move the losses of static steps from the numerical terms to the term of static stages.
   pure subroutine assign_static_losses(energy, initial_energy)
      type(energy_type), intent(inout) :: energy  !< energy budget, J per metre
      type(energy_type), intent(in) :: initial_energy  !< budget at the beginning of the stage
      integer, parameter :: terms(*) = [energy_algorithmic, energy_kinetic_damping, &
         energy_geometric]
      real(wp), parameter :: signs(*) = [1.0_wp, 1.0_wp, -1.0_wp]

      call add_energy(energy, energy_static, dot_product(signs, energy%value(terms) &
         - initial_energy%value(terms)))
      energy%value(terms) = initial_energy%value(terms)
   end subroutine assign_static_losses

   !> Apply the changes of all stages so far to the model of a run that resumes from a checkpoint.
   subroutine restore_stages(simulation)
      type(simulation_type), intent(inout) :: simulation  !< between two steps
      integer :: s, i

      do s = 1, simulation%stage
         call set_stepping(simulation, s)
         call replace_properties(simulation, s)
         call add_attachments(simulation%model, simulation%model%stages(s))
         associate (points => simulation%model%fixed_points)
            do i = 1, size(points)
               if (simulation%model%stages(s)%holds(i)) points(i)%fixed_along = points(i)%waiting
            end do
         end associate
         call remove_parts(simulation, s)
      end do
   end subroutine restore_stages

end module dda_stages
