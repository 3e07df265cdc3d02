! SPDX-License-Identifier: GPL-3.0-or-later
!> Tables of numbers, and texts, of a run.
module api_tables
   use, intrinsic :: iso_c_binding, only: c_double
   use api_failure, only: error
   use dda_contact_table, only: contact_table, closed_contacts
   use dda_diagnostics, only: audit_warning
   use dda_broken_faces, only: edge_damage
   use dda_elements, only: block_stress, bolt_states, channel_columns, get_flow_states, &
      node_columns, plastic_strain, prepare_elements, stress_error
   use dda_energy, only: energy_values
   use dda_errors, only: error_type, error_input, fail
   use dda_maxima, only: stored_value
   use dda_measure, only: measure_point
   use dda_model_description, only: model_description
   use dda_output_schema, only: maxima_table, number_of_maxima
   use dda_peak_check, only: check_peak
   use dda_run, only: run_type, is_done
   use dda_running_maxima, only: collect_residuals
   use dda_simulation, only: simulation_type, end_of_run, next_step, summary, ending
   use dda_site_response, only: response_peak_type, find_amplification_peak
   use dda_stopwatch, only: seconds_of
   use dda_system, only: assemble_linear
   use dda_team, only: team_text
   implicit none
   private
   public :: take_table, take_text

contains

   !> A table of a run: one of its blocks and contacts, or of its course.
   subroutine take_table(run, what, table)
      type(run_type), intent(inout) :: run
      character(len=*), intent(in) :: what
      real(c_double), allocatable, intent(out) :: table(:,:)

      call take_state(run%simulation, what, table)
      if (.not. allocated(table)) call take_course(run, what, table)
      if (.not. (allocated(table) .or. allocated(error))) call fail(error, error_input, &
         'there is no table '//what)
   end subroutine take_table

   !> 'coordinates' and 'rates' [6, blocks], 'stresses' [3, blocks];
   !> 'stress_errors' and 'plastic_strains' [1, blocks]; 'edge_damages' [1, vertices]; 'blocks':
   !> material from 0, body, 1 if it is removed [blocks, 3]; 'vertices' [2, vertices]; 'edges', by
   !> the vertex where each begins: block and joint from 0, 1 within a body [vertices, 3];
   !> 'loads' [6, blocks]: forces on the coordinates of the blocks but those of contacts;
   !> 'contacts' [contacts, columns], 'closed contacts' [contacts, 5]; 'boundary_edges': edge and
   !> group from 0, shares of the edge [parts, 4]; 'bolts': axial and shear force, stretch, state
   !> [4, bolts]; 'water', by channel: pressures and saturations of both nodes, flux, first
   !> positions of the nodes, block beside it from 0 [10, channels]; 'points': displacement,
   !> velocity, acceleration [2, 3 points]; 'base': displacement of what displacements are relative
   !> to [2, 1], m.
   subroutine take_state(simulation, what, table)
      type(simulation_type), intent(inout) :: simulation
      character(len=*), intent(in) :: what
      real(c_double), allocatable, intent(out) :: table(:,:)
      logical :: fits
      integer :: i

      associate (blocks => simulation%blocks, model => simulation%model)
         select case (what)
         case ('coordinates')
            table = blocks%position
            table(1:2, :) = table(1:2, :) + spread(model%origin, 2, blocks%n)
         case ('rates')
            table = blocks%velocity
         case ('stresses')
            table = block_stress(simulation%elements, blocks)
         case ('stress_errors')
            table = reshape(stress_error(simulation%elements, blocks), [1, blocks%n])
         case ('plastic_strains')
            table = reshape(plastic_strain(simulation%elements, blocks), [1, blocks%n])
         case ('edge_damages')
            table = reshape(edge_damage(simulation%elements, model%welds, size(blocks%owner)), &
               [1, size(blocks%owner)])
         case ('blocks')
            table = as_columns([blocks%material - 1, blocks%body, merge(1, 0, blocks%removed)], 3)
         case ('vertices')
            table = blocks%vertex + spread(model%origin, 2, size(blocks%owner))
         case ('edges')
            table = as_columns([blocks%owner - 1, blocks%joint - 1, merge(1, 0, blocks%inner)], 3)
         case ('loads')
            simulation%system%d = 0.0_c_double
            call prepare_elements(simulation%elements, blocks, next_step(simulation), &
               simulation%system%d)
            call assemble_linear(simulation%system, simulation%elements, blocks, &
               next_step(simulation), fits)  ! the loads do not depend on the pattern
            table = simulation%system%load
         case ('contacts')
            table = contact_table(simulation)
         case ('closed contacts')
            table = closed_contacts(simulation)
         case ('boundary_edges')
            associate (edges => model%boundary_edges)
               table = reshape([real(edges%part%edge - 1, c_double), real(edges%group - 1, &
                  c_double), edges%part%from, edges%part%to], [size(edges), 4])
            end associate
         case ('bolts')
            allocate (table(4, size(model%bolts)))
            if (size(table) > 0) table = bolt_states(simulation%elements, size(model%bolts))
         case ('water')
            table = channel_table(simulation)
         case ('base')
            table = reshape(simulation%maxima%base%displacement, [2, 1])
         case ('points')
            allocate (table(2, 3*size(model%points)))
            do i = 1, size(model%points)
               call measure_point(blocks, model%points(i), table(:, 3*i - 2), table(:, 3*i - 1), &
                  table(:, 3*i))
            end do
         end select
      end associate
   end subroutine take_state

   !> The table 'water'.
   function channel_table(simulation) result(table)
      type(simulation_type), intent(in) :: simulation  !< a run and its state
      real(c_double), allocatable :: table(:,:)
      real(c_double), allocatable :: of_nodes(:,:), of_channels(:,:)
      integer :: c

      allocate (table(10, 0))
      if (.not. allocated(simulation%model%flow)) return
      associate (flow => simulation%model%flow)
         allocate (of_nodes(node_columns, size(flow%pressure)), &
            of_channels(channel_columns, size(flow%channel)), source=0.0_c_double)
         call get_flow_states(simulation%elements, of_nodes, of_channels)
         table = reshape([(of_nodes(1, flow%channel(c)%node), of_nodes(2, flow%channel(c)%node), &
            of_channels(1, c), flow%position(:, flow%channel(c)%node(1)) + &
            simulation%model%origin, flow%position(:, flow%channel(c)%node(2)) + &
            simulation%model%origin, real(flow%channel(c)%block(1) - 1, c_double), c=1, &
            size(flow%channel))], [10, size(flow%channel)])
      end associate
   end function channel_table

   !> Whole numbers one after the other, as columns of a table.
   pure function as_columns(numbers, columns) result(table)
      integer, intent(in) :: numbers(:), columns
      real(c_double) :: table(size(numbers)/columns, columns)

      table = reshape(real(numbers, c_double), shape(table))
   end function as_columns

   !> 'clock': time, duration, last time step (s), steps done, open-close iterations of the last
   !> step, gravity (m/s2), penalty stiffness (N/m); of the present stage: its number, the step and
   !> the time (s) that it began after, its steps and their length (s); 'energies'; 'counts';
   !> 'phases': seconds since the first call, which starts the watch [1, n]; 'maxima': largest
   !> values of all steps, their times, present values, blocks and points from 0 [7, maxima].
   subroutine take_course(run, what, table)
      type(run_type), intent(inout) :: run
      character(len=*), intent(in) :: what
      real(c_double), allocatable, intent(out) :: table(:,:)

      associate (simulation => run%simulation, solver => run%simulation%solver)
         select case (what)
         case ('clock')
            table = as_row([simulation%time, end_of_run(simulation), simulation%last_time_step, &
               real(simulation%step, c_double), real(simulation%iteration%iterations, c_double), &
               simulation%model%control%gravity, simulation%model%contact%normal_stiffness, &
               real(simulation%stage, c_double), real(simulation%first_step, c_double), &
               simulation%first_time, real(simulation%model%control%step_count, c_double), &
               simulation%model%control%time_step])
         case ('energies')
            table = as_row(energy_values(simulation%energy))
         case ('counts')
            table = as_row(real([simulation%step, simulation%counters%iterations, &
               simulation%counters%searches, solver%solves, solver%factors, solver%iterations, &
               solver%repeated_directly, simulation%counters%broken], c_double))
         case ('phases')
            simulation%system%watch%running = .true.
            table = as_row(seconds_of(simulation%system%watch))
         case ('maxima')
            call take_maxima(run, table)
         end select
      end associate
   end subroutine take_course

   !> Numbers as a table.
   pure function as_row(numbers) result(table)
      real(c_double), intent(in) :: numbers(:)
      real(c_double) :: table(1, size(numbers))

      table(1, :) = numbers
   end function as_row

   !> Largest values; a complete output that has only been opened has none.
   subroutine take_maxima(run, table)
      type(run_type), intent(inout) :: run
      real(c_double), allocatable, intent(out) :: table(:,:)
      integer :: i

      if (run%was_complete) call fail(error, error_input, 'the output is complete: read its maxima')
      if (allocated(error)) return
      allocate (table(7, number_of_maxima), source=-1.0_c_double)
      call collect_residuals(run%simulation)
      associate (found => run%simulation%maxima)
         table(1, :) = stored_value(found%largest)
         table(2, :) = found%largest%time
         table(3, :) = stored_value(found%last)
         do i = 1, number_of_maxima
            if (maxima_table(i)%of_points) table(6:7, i) = found%largest(i)%owners - 1
            if (.not. maxima_table(i)%of_points) table(4:5, i) = found%largest(i)%owners - 1
         end do
      end associate
   end subroutine take_maxima

   !> A text of a run: 'output', 'title', 'solver', 'summary', 'ending', 'warning', 'notice',
   !> 'threads'; 'changed', the input with the changes between steps, and 'values', what it means;
   !> 'description', 'notes', 'points' and 'blocks' (names), 'peaks' (what is wrong with those of
   !> amplifications), a line each.
   subroutine take_text(run, notes, what, text)
      type(run_type), intent(in) :: run
      character(len=*), intent(in) :: notes(:)   !< on the model as it was read
      character(len=*), intent(in) :: what
      character(len=:), allocatable, intent(out) :: text

      text = ''
      associate (model => run%simulation%model)
         select case (what)
         case ('output')
            text = model%output%file
         case ('title')
            text = model%title
         case ('solver')
            text = trim(run%simulation%solver%method)
         case ('notice')
            if (allocated(run%notice)) text = run%notice
         case ('summary')
            text = summary(run%simulation)
         case ('ending')
            text = ending(run%simulation)
         case ('description')
            text = lines(model_description(model))
         case ('notes')
            text = lines(notes)
         case ('threads')
            text = team_text()
         case ('warning')
            text = audit_warning(run%simulation)
         case ('peaks')
            call find_peak_warnings(run, text)
         case ('input')
            text = model%text
         case ('changed')
            text = run%simulation%changed_text
         case ('values')
            text = model%values
         case ('points')
            text = lines(model%points%name)
         case ('blocks')
            text = lines(model%block_names)
         end select
      end associate
   end subroutine take_text

   !> Texts, each with its line end.
   pure function lines(texts) result(all)
      character(len=*), intent(in) :: texts(:)
      character(len=:), allocatable :: all
      integer :: i, at

      allocate (character(len=sum(len_trim(texts)) + size(texts)) :: all)
      at = 0
      do i = 1, size(texts)
         all(at + 1:at + len_trim(texts(i)) + 1) = trim(texts(i))//new_line('a')
         at = at + len_trim(texts(i)) + 1
      end do
   end function lines

   !> Warnings about the peaks of amplifications in the finished output, a line each.
   subroutine find_peak_warnings(run, text)
      type(run_type), intent(in) :: run
      character(len=:), allocatable, intent(inout) :: text
      type(error_type), allocatable :: unused
      type(response_peak_type) :: peak
      character(len=:), allocatable :: warning
      integer :: i

      if (run%was_complete .or. .not. is_done(run)) return
      associate (model => run%simulation%model)
         do i = 1, size(model%amplifications)
            call find_amplification_peak(model%output%file, model%amplifications(i), peak, unused)
            if (allocated(unused)) cycle  ! the caller that requests the peak itself gets its error
            call check_peak(run%simulation, model%amplifications(i), peak, warning)
            if (warning /= '') text = text//warning//new_line('a')
         end do
      end associate
   end subroutine find_peak_warnings

end module api_tables
