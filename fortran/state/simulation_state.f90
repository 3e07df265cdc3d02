! SPDX-License-Identifier: GPL-3.0-or-later
!> State of a run, written to an archive or restored into a run that has just started.
module dda_simulation_state
   use dda_archive, only: archive_type, fail_archive, serialise, serialise_label, &
      serialise_number, serialise_count, serialise_list, check_list
   use dda_breaking, only: can_break, restore_faces
   use dda_matrix_pattern, only: set_pattern_of_run
   use dda_blocks, only: blocks_type, has_memory
   use dda_columns, only: column_count, column_of
   use dda_changes, only: adopt_values
   use dda_doubts, only: serialise_doubts
   use dda_elements, only: serialise_elements, set_elements
   use dda_errors, only: error_type
   use dda_input, only: read_model
   use dda_model, only: model_type
   use dda_neighbours, only: find_corners, neighbours_type
   use dda_open_close, only: open_close_type
   use dda_simulation, only: simulation_type, stop_state_type
   use dda_linear_solver, only: solver_type, is_solver_name, set_method
   use dda_stages, only: restore_stages
   use dda_support, only: point_type
   use dda_weld, only: weld_open, weld_intact
   use dda_base_motion, only: base_type, base_kinds
   use dda_first_contacts, only: first_contacts_type
   use dda_maxima, only: maxima_table, number_of_maxima
   use dda_running_maxima, only: reserve_maxima
   use dda_block_matrix, only: block_matrix_type
   use dda_contact, only: contacts_type, operation_type, for_each_variable, reserve
   use dda_kinds, only: wp
   implicit none
   private
   public :: serialise_simulation

   !> Write the arrays to an archive, or read them from it.
   type, extends(operation_type) :: serialisation_type
      integer :: n                              !< contacts
      type(archive_type), pointer :: archive => null()
   contains
      procedure :: apply => serialise_variable
   end type serialisation_type

contains

   !> Save or restore a simulation; on reading, it must have the model that was written.
   recursive subroutine serialise_simulation(archive, simulation)
      type(archive_type), intent(inout) :: archive  !< archive that is written or read
      type(simulation_type), intent(inout) :: simulation  !< simulation and its state
      integer :: i

      call serialise_clock(archive, simulation)
      call serialise_changes(archive, simulation)
      call serialise_stage(archive, simulation)
      call serialise_counters(archive, simulation)
      call serialise_stop(archive, simulation%stop)
      call serialise_maxima(archive, simulation)
      call serialise_label(archive, 'energy')
      call serialise(archive, simulation%energy%value)
      call serialise_blocks(archive, simulation%blocks)
      call serialise_label(archive, 'corners')
      call serialise(archive, simulation%detection%across)
      call serialise_label(archive, 'elements')
      call serialise_elements(simulation%elements, archive)
      call serialise_neighbours(archive, simulation%neighbours, simulation%blocks)
      call serialise_contacts(archive, simulation%contacts(simulation%now), simulation%blocks, &
         simulation%neighbours, size(simulation%model%joints))
      call serialise_iteration(archive, simulation%iteration, simulation%contacts(simulation%now)%n)
      if (archive%reading .and. .not. allocated(archive%failure)) then
         call find_corners(simulation%neighbours, simulation%blocks)
         call set_pattern_of_run(simulation)
      end if
      call serialise_solver(archive, simulation%solver, simulation%system%matrix)
      do i = 1, column_count(simulation)
         call serialise_simulation(archive, column_of(simulation, i))
      end do
      call serialise_label(archive, 'end')
   end subroutine serialise_simulation

   !> Save or restore step, time, bounds on movement and the index of the present contact list.
   subroutine serialise_clock(archive, simulation)
      type(archive_type), intent(inout) :: archive  !< archive that is written or read
      type(simulation_type), intent(inout) :: simulation  !< simulation and its state

      call serialise_label(archive, 'clock')
      call serialise(archive, simulation%step)
      call serialise(archive, simulation%time)
      call serialise(archive, simulation%last_time_step)
      call serialise(archive, simulation%speed)
      call serialise(archive, simulation%path)
      call serialise_number(archive, simulation%now, 1, size(simulation%contacts))
   end subroutine serialise_clock

   !> Save or restore the changes of the model due to stages.
   subroutine serialise_stage(archive, simulation)
      type(archive_type), intent(inout) :: archive  !< archive that is written or read
      type(simulation_type), intent(inout) :: simulation  !< simulation and its state
      integer :: i

      call serialise_label(archive, 'stage')
      call serialise_number(archive, simulation%stage, 1, size(simulation%model%stages))
      call serialise(archive, simulation%first_step)
      call serialise(archive, simulation%first_time)
      call serialise(archive, simulation%statics)
      call serialise_doubts(archive, simulation%doubts)
      call serialise_points(archive, simulation%model%points)
      do i = 1, size(simulation%model%boundary_motions)
         call serialise_points(archive, simulation%model%boundary_motions(i)%point)
      end do
      do i = 1, size(simulation%model%motions)
         call serialise(archive, simulation%model%motions(i)%curve%start)
      end do
      if (archive%reading .and. .not. allocated(archive%failure)) call restore_stages(simulation)
      ! A change of the input may have changed the steps since the stage began.
      call serialise(archive, simulation%model%control%step_count)
      call serialise(archive, simulation%model%control%time_step)
      call serialise(archive, simulation%time_step)
      call serialise_targets(archive, simulation)
      call serialise_faces(archive, simulation)
      if (archive%reading .and. .not. allocated(archive%failure)) call set_elements( &
         simulation%elements, simulation%model, simulation%blocks, simulation%time)
   end subroutine serialise_stage

   !> Save or restore the origin of the displacements of points.
   subroutine serialise_points(archive, points)
      type(archive_type), intent(inout) :: archive  !< archive that is written or read
      type(point_type), intent(inout) :: points(:)  !< measured points
      integer :: i

      do i = 1, size(points)
         call serialise(archive, points(i)%position)
      end do
   end subroutine serialise_points

   !> Save or restore targets of fixed points, and start times of loads.
   subroutine serialise_targets(archive, simulation)
      type(archive_type), intent(inout) :: archive  !< archive that is written or read
      type(simulation_type), intent(inout) :: simulation  !< simulation and its state
      integer :: i

      do i = 1, size(simulation%model%fixed_points)
         call serialise(archive, simulation%model%fixed_points(i)%position)
      end do
      do i = 1, size(simulation%model%loads)
         call serialise(archive, simulation%model%loads(i)%start)
      end do
   end subroutine serialise_targets

   !> Save or restore welded faces that have broken.
   subroutine serialise_faces(archive, simulation)
      type(archive_type), intent(inout) :: archive  !< archive that is written or read
      type(simulation_type), intent(inout) :: simulation  !< simulation and its state
      integer :: i

      if (.not. can_break(simulation%model)) return
      associate (welds => simulation%model%welds)
         do i = 1, size(welds)
            call serialise_number(archive, welds(i)%state, weld_intact, weld_open)
            call serialise(archive, welds(i)%break_stress)
            call serialise(archive, welds(i)%break_fraction)
         end do
      end associate
      if (archive%reading .and. .not. allocated(archive%failure)) call restore_faces(simulation)
   end subroutine serialise_faces

   !> Save or restore changes between steps; on reading, the changed input is read again.
   subroutine serialise_changes(archive, simulation)
      type(archive_type), intent(inout) :: archive  !< archive that is written or read
      type(simulation_type), intent(inout) :: simulation  !< simulation and its state
      type(model_type) :: model
      type(error_type), allocatable :: error

      call serialise_label(archive, 'changes')
      call serialise(archive, simulation%changed_text)
      call serialise(archive, simulation%changes)
      if (.not. archive%reading .or. allocated(archive%failure) &
         .or. simulation%changed_text == '') return
      call read_model(model, simulation%model%file, simulation%changed_text, error)
      if (allocated(error)) then
         call fail_archive(archive, 'the input with its changes: '//error%message)
      else
         call adopt_values(simulation, model)
      end if
   end subroutine serialise_changes

   !> Save or restore the counts of the run.
   subroutine serialise_counters(archive, simulation)
      type(archive_type), intent(inout) :: archive  !< archive that is written or read
      type(simulation_type), intent(inout) :: simulation  !< simulation and its state

      call serialise_label(archive, 'counters')
      associate (counters => simulation%counters)
         call serialise(archive, counters%iterations)
         call serialise(archive, counters%searches)
         call serialise(archive, counters%repeated)
         call serialise(archive, counters%too_far)
         call serialise(archive, counters%broken)
         call serialise(archive, counters%unconverged_damage)
         call serialise(archive, counters%unconverged_bounds)
         call serialise(archive, counters%tables_off)
         call serialise(archive, counters%changes)
         call serialise(archive, counters%most_iterations)
      end associate
      associate (impacts => simulation%impacts)
         call serialise(archive, impacts%steps)
         call serialise(archive, impacts%contacts)
         call serialise(archive, impacts%reduced)
      end associate
   end subroutine serialise_counters

   !> Save or restore the state of the stop rule.
   subroutine serialise_stop(archive, stop_state)
      type(archive_type), intent(inout) :: archive          !< archive that is written or read
      type(stop_state_type), intent(inout) :: stop_state    !< stop rule, with arrays if set

      call serialise_label(archive, 'stop')
      call serialise(archive, stop_state%reason)
      call serialise(archive, stop_state%since)
      if (.not. allocated(stop_state%first)) return
      call serialise(archive, stop_state%first)
      call serialise(archive, stop_state%window)
   end subroutine serialise_stop

   !> Save or restore the outcome of the last iteration, which determines the next tolerance.
   !> Settings of the iteration are not saved, but read from the input.
   subroutine serialise_iteration(archive, iteration, contacts)
      type(archive_type), intent(inout) :: archive  !< archive that is written or read
      type(open_close_type), intent(inout) :: iteration  !< open–close iteration of the step
      integer, intent(in) :: contacts  !< contacts in the list

      call serialise_label(archive, 'iteration')
      call serialise(archive, iteration%iterations)
      call serialise(archive, iteration%changes)
      call serialise(archive, iteration%broken)
      call serialise(archive, iteration%residual)
      call serialise(archive, iteration%tolerance)
      call serialise(archive, iteration%short_steps)
      call serialise_number(archive, iteration%unconverged, 0, contacts)
      call serialise(archive, iteration%overshoots)
      call serialise(archive, iteration%shortened)
      call serialise(archive, iteration%retained)
      call serialise(archive, iteration%reduction)
   end subroutine serialise_iteration

   !> Save or restore the state of blocks.
   !> Derived values are computed again, except the initial vertices, which the input determines.
   subroutine serialise_blocks(archive, blocks)
      type(archive_type), intent(inout) :: archive  !< archive that is written or read
      type(blocks_type), intent(inout) :: blocks  !< blocks in their present state

      call serialise_label(archive, 'blocks')
      call serialise(archive, blocks%initial_stress)
      call serialise(archive, blocks%position)
      call serialise(archive, blocks%velocity)
      call serialise(archive, blocks%acceleration)
      call serialise(archive, blocks%mean_velocity)
      if (has_memory(blocks)) then
         call serialise(archive, blocks%rest_strain)
         call serialise(archive, blocks%memory)
      end if
      call serialise(archive, blocks%axes)
      call serialise(archive, blocks%gradient)
      call serialise(archive, blocks%vertex)
      call serialise(archive, blocks%along)
      call serialise(archive, blocks%length)
   end subroutine serialise_blocks

   !> Save or restore the largest values, if the run records them.
   subroutine serialise_maxima(archive, simulation)
      type(archive_type), intent(inout) :: archive        !< archive that is written or read
      type(simulation_type), intent(inout) :: simulation  !< simulation and its state
      integer :: contacts

      call serialise_label(archive, 'maxima')
      call serialise(archive, simulation%maxima%counting)
      if (.not. simulation%maxima%counting .or. allocated(archive%failure)) return
      contacts = 0
      if (.not. archive%reading) contacts = size(simulation%maxima%contacts%vertex)
      call serialise_count(archive, contacts)
      if (archive%reading .and. .not. allocated(archive%failure)) call reserve_maxima(simulation, &
         contacts)
      if (allocated(archive%failure)) return
      call serialise(archive, simulation%maxima%first)
      call serialise(archive, simulation%maxima%points_from)
      call serialise_base(archive, simulation%maxima%base, size(simulation%model%points))
      call serialise_first(archive, simulation%maxima%contacts, size(simulation%blocks%owner))
      call serialise_largest(archive, simulation)
   end subroutine serialise_maxima

   !> Save or restore the reference state of displacements and rotations.
   subroutine serialise_base(archive, base, points)
      type(archive_type), intent(inout) :: archive  !< archive that is written or read
      type(base_type), intent(inout) :: base        !< base of the model
      integer, intent(in) :: points                 !< number of measured points

      call serialise_number(archive, base%kind, 0, base_kinds)
      call serialise_number(archive, base%point, 0, points)
      call serialise(archive, base%coefficient)
      call serialise(archive, base%zero)
      call serialise(archive, base%displacement)
      call serialise(archive, base%velocity)
      call serialise(archive, base%acceleration)
   end subroutine serialise_base

   !> Save or restore the initial contacts, and the last search of them.
   subroutine serialise_first(archive, first, vertices)
      type(archive_type), intent(inout) :: archive       !< archive that is written or read
      type(first_contacts_type), intent(inout) :: first  !< first contacts, with memory
      integer, intent(in) :: vertices                    !< number of vertices of the model

      call serialise_list(archive, first%vertex, 1, vertices)
      call serialise_list(archive, first%edge, 1, vertices)
      call serialise(archive, first%foot_fraction)
      call serialise(archive, first%gap)
      call serialise(archive, first%shortest)
      call serialise(archive, first%last_scan)
      call serialise(archive, first%path)
   end subroutine serialise_first

   !> Save or restore values, times, and their blocks or points.
   subroutine serialise_largest(archive, simulation)
      type(archive_type), intent(inout) :: archive        !< archive that is written or read
      type(simulation_type), intent(inout) :: simulation  !< simulation and its state
      integer :: i, upper

      do i = 1, number_of_maxima
         associate (largest => simulation%maxima%largest(i))
            upper = simulation%blocks%n
            if (maxima_table(i)%of_points) upper = size(simulation%model%points)
            call serialise(archive, largest%value)
            call serialise(archive, largest%time)
            call serialise_list(archive, largest%owners, 0, upper)
         end associate
      end do
   end subroutine serialise_largest

   !> Save or restore a solver that has analysed the matrix.
   subroutine serialise_solver(archive, solver, matrix)
      type(archive_type), intent(inout) :: archive  !< archive that is written or read
      type(solver_type), intent(inout) :: solver  !< linear solver
      type(block_matrix_type), intent(in) :: matrix  !< matrix; only its pattern is read
      character(len=:), allocatable :: method

      call serialise_label(archive, 'solver')
      method = trim(solver%method)
      call serialise(archive, method)
      if (.not. is_solver_name(method)) call fail_archive(archive, 'its solver name is unknown')
      call serialise(archive, solver%last_iterations)
      call serialise(archive, solver%n_shifted)
      call serialise(archive, solver%exact)
      call serialise(archive, solver%solves)
      call serialise(archive, solver%factors)
      call serialise(archive, solver%iterations)
      call serialise(archive, solver%repeated_directly)
      if (allocated(archive%failure)) return
      if (method == 'auto') return
      if (method /= solver%method) call set_method(solver, matrix, method)
      call solver%active%serialise(matrix, archive)
   end subroutine serialise_solver

   !> Save or restore the complete contact list.
   !> The next step inherits from the list, and frames contain it.
   subroutine serialise_contacts(archive, contacts, blocks, neighbours, joints)
      type(archive_type), target, intent(inout) :: archive  !< archive that is written or read
      type(contacts_type), intent(inout) :: contacts        !< list, replaced when read
      type(blocks_type), intent(in) :: blocks               !< blocks of the model
      type(neighbours_type), intent(in) :: neighbours       !< neighbours, already written or read
      integer, intent(in) :: joints                         !< number of joint materials
      type(serialisation_type) :: serialisation
      integer :: n, vertices

      call serialise_label(archive, 'contacts')
      call serialise_count(archive, contacts%n)
      n = contacts%n
      vertices = size(blocks%owner)
      if (archive%reading) call reserve(contacts, n)
      serialisation%n = n
      serialisation%archive => archive
      call for_each_variable(contacts, serialisation)
      call check_list(archive, contacts%vertex(:n), 1, vertices)
      call check_list(archive, contacts%edge(:n), 1, vertices)
      call check_list(archive, contacts%corner(:n), 0, vertices)
      call check_list(archive, contacts%block_v(:n), 1, blocks%n)
      call check_list(archive, contacts%block_e(:n), 1, blocks%n)
      call check_list(archive, contacts%pair(:n), 1, neighbours%n_pairs)
      call check_list(archive, contacts%joint(:n), 1, joints)
   end subroutine serialise_contacts

   !> Save or restore one variable of a list.
   subroutine serialise_variable(operation, integers, logicals, reals, columns)
      class(serialisation_type), intent(inout) :: operation  !< archive and number of contacts
      integer, allocatable, intent(inout), optional :: integers(:)   !< [capacity]
      logical, allocatable, intent(inout), optional :: logicals(:)   !< [capacity]
      real(wp), allocatable, intent(inout), optional :: reals(:)     !< [capacity]
      real(wp), allocatable, intent(inout), optional :: columns(:,:) !< [any, capacity]

      associate (archive => operation%archive, n => operation%n)
         if (present(integers)) call serialise(archive, integers(:n))
         if (present(logicals)) call serialise(archive, logicals(:n))
         if (present(reals)) call serialise(archive, reals(:n))
         if (present(columns)) call serialise(archive, columns(:, :n))
      end associate
   end subroutine serialise_variable

   !> Save or restore pairs and probes of the last search, which cannot be computed again.
   subroutine serialise_neighbours(archive, neighbours, blocks)
      type(archive_type), intent(inout) :: archive        !< archive that is written or read
      type(neighbours_type), intent(inout) :: neighbours  !< neighbours, replaced when read
      type(blocks_type), intent(in) :: blocks             !< blocks of the model
      integer :: pairs, probes, edges

      call serialise_label(archive, 'neighbours')
      edges = neighbours%first_edge(neighbours%n_probes + 1) - 1
      call serialise_count(archive, neighbours%n_pairs)
      call serialise_count(archive, neighbours%n_probes)
      call serialise_count(archive, edges)
      pairs = neighbours%n_pairs
      probes = neighbours%n_probes
      if (archive%reading) then
         deallocate (neighbours%pair, neighbours%probe, neighbours%first_edge, neighbours%edge)
         allocate (neighbours%pair(2, pairs), neighbours%probe(2, probes), &
            neighbours%first_edge(probes + 1), source=1)
         allocate (neighbours%edge(edges), source=1)
      end if
      call serialise(archive, neighbours%pair(:, :pairs))
      call check_list(archive, neighbours%pair(1, :pairs), 1, blocks%n)
      call check_list(archive, neighbours%pair(2, :pairs), 1, blocks%n)
      call serialise(archive, neighbours%probe(:, :probes))
      call check_list(archive, neighbours%probe(1, :probes), 1, size(blocks%owner))
      call check_list(archive, neighbours%probe(2, :probes), 1, pairs)
      call serialise_list(archive, neighbours%first_edge(:probes + 1), 1, edges + 1)
      call serialise_list(archive, neighbours%edge(:edges), 1, size(blocks%owner))
      call serialise(archive, neighbours%reach)
      call serialise(archive, neighbours%travel)
   end subroutine serialise_neighbours

end module dda_simulation_state
