! SPDX-License-Identifier: GPL-3.0-or-later
!> Output of a run: a netCDF-4 file that xarray can open.
!>
!> The file is always written completely from the journal under a temporary name, and then renamed:
!> to FILE.partial at intervals during the run, to FILE when the run is complete.  Both files can
!> therefore be opened at any time, and a run that is killed while writing does not damage them.
module dda_output_file
   use, intrinsic :: iso_fortran_env, only: compiler_options, compiler_version
   use dda_kinds, only: wp, long
   use dda_base_motion, only: base_text
   use dda_byte_file, only: reserve_space, flush_file, close_file
   use dda_errors, only: error_type, error_file, fail
   use dda_file_system, only: rename_file, remove_file, is_special
   use dda_journal, only: journal_type, reader_type, open_reader, read_row, read_numbers, row_sample
   use dda_maxima, only: stored_value
   use dda_model, only: model_type, block_sources
   use dda_output_place, only: partial, writing
   use dda_output_schema
   use dda_output_variables, only: families_of, is_in, lengths_of, numbers_of, offset_in_sample, &
      size_of_sample
   use dda_own_file, only: check_replaceable, netcdf_file
   use dda_netcdf_calls, only: dataset_type, path_of, checked, define_dimension, define_variable, &
      describe, describe_flags, describe_number, describe_variable, put, put_names, text_of
   use dda_run_verdict, only: run_verdict_type, new_verdict, add_samples, &
      add_joint_samples, conclude
   use dda_verdict_lines, only: doubt_lines, figure_lines
   use dda_simulation, only: simulation_type, summary, ending
   use dda_linear_solver, only: work_done
   use dda_stage, only: stage_type
   use dda_text, only: joined
   use dda_diagnostics, only: audit_warning
   use dda_version, only: version, commit
   use netcdf, only: nf90_create, nf90_open, nf90_close, nf90_enddef, nf90_netcdf4, nf90_clobber, &
      nf90_nowrite, nf90_noerr, nf90_set_fill, nf90_nofill, nf90_double, nf90_int, nf90_char
   implicit none
   private
   public :: write_output, writing_memory, is_complete

   !> least and largest number of samples written at once; HDF5 copies writes below 64 KiB
   integer, parameter :: fewest_buffered = 1024, most_buffered = 8192
   integer, parameter :: buffered_numbers = 1048576  !< numbers written at once
   !> spare rows of the buffer, so that its columns do not compete for the same cache lines
   integer, parameter :: spare_rows = 8
   integer(long), parameter :: overhead = 262144  !< file size without data and texts, bytes
   real(wp), parameter :: library_bytes = 5.0e6_wp  !< measured memory of netCDF and HDF5, bytes

   !> Output file that is being written.
   type :: output_type
      type(dataset_type) :: dataset
      logical :: has(number_of_families)          !< the model has this family of variables
      integer :: lengths(size(dimension_names))   !< lengths of dimensions
      integer :: samples = 0                      !< number of samples, written or buffered
      integer :: waiting = 0                      !< number of buffered samples
      integer :: frames = 0                       !< number of written frames
      integer :: contacts = 0                     !< number of written contact states
      type(run_verdict_type) :: verdict
      real(wp), allocatable :: column(:,:)        !< [buffered samples, values of a sample]
   end type output_type

contains

   !> Write all data of the journal to FILE, or to FILE.partial if the run is not complete.
   subroutine write_output(file, journal, simulation, complete, error)
      character(len=*), intent(in) :: file  !< path of the output
      type(journal_type), intent(in) :: journal  !< journal of the run
      type(simulation_type), intent(in) :: simulation  !< simulation at its present time
      logical, intent(in) :: complete  !< the run has reached its duration
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(output_type) :: output
      character(len=:), allocatable :: name

      name = file//partial
      if (complete) name = file
      output%dataset%file = file//writing
      call check_replaceable(output%dataset%file, netcdf_file, error)
      if (allocated(error)) return
      ! HDF5 crashes if the disk fills up while it writes, so the space is allocated first.
      call reserve_space(output%dataset%file, bytes_for(journal, simulation), error)
      if (.not. allocated(error)) call write_dataset(output, journal, simulation, complete, error)
      if (.not. allocated(error) .and. complete) call flush_file(output%dataset%file, error)
      call check_replaceable(name, netcdf_file, error)
      if (.not. allocated(error)) then
         if (.not. rename_file(output%dataset%file, name)) call fail(error, error_file, &
            output%dataset%file//' cannot be renamed to '//name)
      end if
      if (allocated(error)) call remove_file(output%dataset%file)
   end subroutine write_output

   !> Upper bound on the size of the file, bytes.
   pure integer(long) function bytes_for(journal, simulation) result(bytes)
      type(journal_type), intent(in) :: journal  !< journal of the run
      type(simulation_type), intent(in) :: simulation  !< simulation at its present time
      integer :: i

      bytes = overhead + 2*(len(simulation%model%text) + len(simulation%model%values)) &
         + 2*len(simulation%changes) + journal%bytes + 256*size(simulation%model%points) &
         + 64*size(simulation%model%joints) &
         + 64*size(simulation%blocks%owner) + 128*simulation%blocks%n &
         + 64*size(simulation%model%boundary_edges)
      do i = 1, size(simulation%model%motions)
         bytes = bytes + 2*len(simulation%model%motions(i)%source)
      end do
   end function bytes_for

   !> Upper bound on the memory of `write_output`, bytes.
   !> The bound includes two frames, the samples, copies of parts of both, and texts.
   pure real(wp) function writing_memory(simulation) result(bytes)
      type(simulation_type), intent(in) :: simulation  !< simulation at its present time
      integer, parameter :: number_bytes = storage_size(1.0_wp)/8  ! bytes of a number
      real(wp) :: frame, samples

      associate (contacts => simulation%contacts(simulation%now)%n, n => simulation%blocks%n)
         frame = real(max(6*n, 2*contacts), wp) + 3*n + 3*2*size(simulation%blocks%owner) &
            + 3*contacts
      end associate
      samples = 3*real(buffered_samples(simulation), wp)*size_of_sample(simulation)
      bytes = library_bytes + number_bytes*(frame + samples) + 4*len(simulation%model%text) &
         + 4*len(simulation%changes)
   end function writing_memory

   !> Number of samples that are written at once.
   pure integer function buffered_samples(simulation)
      type(simulation_type), intent(in) :: simulation  !< simulation at its present time

      buffered_samples = max(fewest_buffered, min(most_buffered, &
         buffered_numbers/max(1, size_of_sample(simulation))))
   end function buffered_samples

   !> Create the file, write everything, close it.
   subroutine write_dataset(output, journal, simulation, complete, error)
      type(output_type), intent(inout) :: output  !< file being written
      type(journal_type), intent(in) :: journal  !< journal of the run
      type(simulation_type), intent(in) :: simulation  !< simulation at its present time
      logical, intent(in) :: complete  !< the run has reached its duration
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer :: unused

      associate (dataset => output%dataset)
         call checked(dataset, nf90_create(path_of(dataset%file), ior(nf90_netcdf4, &
            nf90_clobber), dataset%id), 'create the file')
         if (.not. allocated(dataset%error)) then
            ! Without points, some variables are not written.
            if (size(simulation%model%points) > 0) &
               call checked(dataset, nf90_set_fill(dataset%id, nf90_nofill, unused), 'set it up')
            call describe_run(dataset, simulation, merge('yes', 'no ', complete))
            output%has = families_of(simulation)
            output%lengths = lengths_of(simulation)
            call define_file(output, journal)
            call write_constants(dataset, simulation)
            output%verdict = new_verdict(simulation, output%lengths(dim_point), &
               output%lengths(dim_measured_joint))
            call copy_rows(output, journal, simulation, error)
            call describe_verdict(dataset, output%verdict)
            call checked(dataset, nf90_close(dataset%id), 'close the file')
         end if
         if (.not. allocated(error) .and. allocated(dataset%error)) error = dataset%error
      end associate
   end subroutine write_dataset

   !> Define the variables that the model has, and their dimensions.
   subroutine define_file(output, journal)
      type(output_type), intent(inout) :: output  !< open dataset; retains the first error
      type(journal_type), intent(in) :: journal  !< journal of the run
      integer :: lengths(size(dimension_names)), i
      logical :: is_used(0:size(dimension_names))

      lengths = output%lengths
      lengths([dim_time, dim_frame, dim_contact]) = [journal%samples, journal%frames, &
         journal%contacts]
      lengths(dim_point) = max(1, lengths(dim_point))
      is_used = .false.
      do i = 1, size(output_variables)
         associate (variable => output_variables(i))
            if (output%has(variable%family)) is_used(variable%dimensions) = .true.
         end associate
      end do
      do i = 1, size(lengths)
         if (is_used(i)) call define_dimension(output%dataset, trim(dimension_names(i)), lengths(i))
      end do
      do i = 1, size(output_variables)
         if (output%has(output_variables(i)%family)) call define_output_variable(output%dataset, &
            output_variables(i))
      end do
      if (.not. allocated(output%dataset%error)) call checked(output%dataset, &
         nf90_enddef(output%dataset%id), 'end the definitions')
   end subroutine define_file

   !> Define a variable with its attributes.
   subroutine define_output_variable(dataset, variable)
      type(dataset_type), intent(inout) :: dataset  !< open dataset; retains the first error
      type(output_variable_type), intent(in) :: variable  !< variable of the schema
      integer, parameter :: kinds(3) = [nf90_char, nf90_double, nf90_int]
      character(len=:), allocatable :: name

      name = trim(variable%name)
      call define_variable(dataset, name, kinds(variable%kind), &
         dimension_names(variable%dimensions(:count(variable%dimensions > 0))))
      call describe_variable(dataset, name, 'units', variable%units)
      call describe_variable(dataset, name, 'long_name', variable%meaning)
      call describe_variable(dataset, name, 'coordinates', variable%coordinates)
      call describe_flags(dataset, name, variable%flags)
      if (variable%kind == is_text) call describe_variable(dataset, name, '_Encoding', 'utf-8')
   end subroutine define_output_variable

   !> Write the attributes: all data needed to repeat the run, and the outcome.
   subroutine describe_run(dataset, simulation, complete)
      type(dataset_type), intent(inout) :: dataset  !< open dataset; retains the first error
      type(simulation_type), intent(in) :: simulation  !< simulation at its present time
      character(len=*), intent(in) :: complete  !< 'yes' or 'no'
      character(len=:), allocatable :: audit

      call describe(dataset, 'Conventions', 'CF-1.11')
      call describe(dataset, 'title', simulation%model%title)
      call describe(dataset, 'source', 'sitedda '//version)
      call describe(dataset, 'commit', commit)
      call describe(dataset, 'compiler', compiler_version()//' '//compiler_options())
      call describe(dataset, 'input_file', simulation%model%file)
      call describe(dataset, 'input_text', simulation%model%text)
      call describe(dataset, 'input_values', simulation%model%values)
      call describe(dataset, 'block_files', block_sources(simulation%model))
      call describe(dataset, 'motions', records_text(simulation%model))
      call describe(dataset, 'step_control', summary(simulation))
      call describe(dataset, 'contacts_changed', trim(merge('no ', 'yes', &
         simulation%counters%changes == 0)))
      call describe(dataset, 'changes', simulation%changes)
      call describe(dataset, 'stages', joined(simulation%model%stages%name, new_line('a')))
      audit = audit_warning(simulation)
      if (audit == '') audit = 'balances'
      call describe(dataset, 'energy_audit', audit)
      call describe(dataset, 'ending', ending(simulation))
      call describe(dataset, 'solver', work_done(simulation%solver))
      call describe(dataset, 'complete', trim(complete))
      call describe(dataset, 'maxima_base', base_text(simulation%maxima%base, simulation%model))
   end subroutine describe_run

   !> Write the verdict on the run as attributes, in words and numbers.
   subroutine describe_verdict(dataset, verdict)
      type(dataset_type), intent(inout) :: dataset  !< open dataset; retains the first error
      type(run_verdict_type), intent(in) :: verdict  !< verdict on all frames
      integer :: i

      if (verdict%events == '') return
      call describe(dataset, 'verdict', verdict%events)
      call describe(dataset, 'figures', figure_lines(verdict))
      call describe(dataset, 'doubts', doubt_lines(verdict))
      do i = 1, size(verdict%values)
         call describe_number(dataset, verdict%values(i)%name, verdict%values(i)%value)
      end do
   end subroutine describe_verdict

   !> Text that describes each record of a model and its processing, one per line.
   pure function records_text(model) result(text)  ! total
      type(model_type), intent(in) :: model  !< model as read from the input
      character(len=:), allocatable :: text
      integer :: i

      text = ''
      do i = 1, size(model%motions)
         if (i > 1) text = text//new_line('a')
         text = text//model%motions(i)%source
      end do
   end function records_text

   !> .true. if an output is complete and was computed from the input and records of the model.
   logical function is_complete(file, model)
      character(len=*), intent(in) :: file      !< path of the output
      type(model_type), intent(in) :: model  !< model as read from the input
      type(dataset_type) :: dataset

      dataset%file = file
      is_complete = .not. is_special(file)
      if (is_complete) is_complete = nf90_open(path_of(file), nf90_nowrite, dataset%id) == &
         nf90_noerr
      if (.not. is_complete) return
      is_complete = text_of(dataset, 'complete') == 'yes' .and. text_of(dataset, 'changes') == '' &
         .and. text_of(dataset, 'input_text') == model%text &
         .and. text_of(dataset, 'block_files') == block_sources(model) &
         .and. text_of(dataset, 'motions') == records_text(model)
      call checked(dataset, nf90_close(dataset%id), 'close the file')
   end function is_complete

   !> Write values that do not depend on time.
   subroutine write_constants(dataset, simulation)
      type(dataset_type), intent(inout) :: dataset  !< open dataset; retains the first error
      type(simulation_type), intent(in) :: simulation  !< simulation at its present time
      integer :: i

      associate (points => simulation%model%points, blocks => simulation%blocks)
         do i = 1, size(points)
            call put(dataset, 'point_place', points(i)%position + simulation%model%origin, [1, i], &
               [2, 1])
         end do
         call put_names(dataset, 'axis', ['x', 'y'])
         call put_names(dataset, 'coordinate', [character(len=12) :: 'x', 'y', &
            'rotation', 'strain_x', 'strain_y', 'shear_strain'])
         call put_names(dataset, 'coordinate_unit', [character(len=5) :: 'm', 'm', &
            'rad', '1', '1', '1'])
         call put_names(dataset, 'rate_unit', [character(len=5) :: 'm/s', 'm/s', &
            'rad/s', '1/s', '1/s', '1/s'])
         call put_names(dataset, 'component', ['xx', 'yy', 'xy'])
         call put_names(dataset, 'block', simulation%model%block_names, 'block ')
         call put(dataset, 'block_removal', removal_stage(simulation%model%stages, blocks%n), [1], &
            [blocks%n])
         call put_names(dataset, 'point', points%name)
         call put_names(dataset, 'joint', simulation%model%joints%name)
         if (size(simulation%model%measured_joints) > 0) call put_names(dataset, 'measured_joint', &
            simulation%model%measured_joints%name)
         call put(dataset, 'block_material', real(simulation%model%blocks%material - 1, wp), [1], &
            [blocks%n])
         if (size(simulation%model%body_names) > 0) then
            call put_names(dataset, 'body', simulation%model%body_names)
            call put(dataset, 'block_body', real(blocks%body, wp), [1], [blocks%n])
            call put(dataset, 'edge_welded', merge(1.0_wp, 0.0_wp, blocks%inner), [1], &
               [size(blocks%owner)])
         end if
         call put(dataset, 'edge_joint', real(simulation%model%blocks%joint - 1, wp), [1], &
            [size(blocks%owner)])
         call put_maxima(dataset, simulation)
         call put_bolts(dataset, simulation)
         if (allocated(simulation%model%flow)) call put_flow(dataset, simulation%model)
         call put_boundaries(dataset, simulation)
         call put(dataset, 'vertex_block', real(blocks%owner - 1, wp), [1], [size(blocks%owner)])
         call put(dataset, 'block_density', blocks%mass/blocks%area, [1], [blocks%n])
         call put(dataset, 'block_shear_modulus', blocks%stiffness(3, 3, :)/blocks%area, [1], &
            [blocks%n])
      end associate
   end subroutine write_constants

   !> Write the largest values of the run up to the present time.
   subroutine put_maxima(dataset, simulation)
      type(dataset_type), intent(inout) :: dataset  !< open dataset; retains the first error
      type(simulation_type), intent(in) :: simulation  !< simulation at its present time
      integer, parameter :: n = number_of_maxima
      real(wp) :: owner_index(2, n, 2)
      integer :: i

      associate (maxima => simulation%maxima)
         owner_index = -1.0_wp
         do i = 1, n
            owner_index(:, i, merge(2, 1, maxima_table(i)%of_points)) = maxima%largest(i)%owners - 1
         end do
         call put_names(dataset, 'maximum', maxima_table%name)
         call put_names(dataset, 'maximum_unit', maxima_table%units)
         call put(dataset, 'largest', stored_value(maxima%largest), [1], [n])
         call put(dataset, 'largest_time', maxima%largest%time, [1], [n])
         call put(dataset, 'largest_block', pack(owner_index(:, :, 1), .true.), [1, 1], [2, n])
         call put(dataset, 'largest_point', pack(owner_index(:, :, 2), .true.), [1, 1], [2, n])
         call put(dataset, 'residual', stored_value(maxima%last), [1], [n])
      end associate
   end subroutine put_maxima

   !> Write the network of water in joints.
   subroutine put_flow(dataset, model)
      type(dataset_type), intent(inout) :: dataset  !< open dataset; retains the first error
      type(model_type), intent(in) :: model  !< model with flow
      integer :: c

      associate (channels => size(model%flow%channel), nodes => size(model%flow%pressure))
         call put(dataset, 'flow_node_place', pack(model%flow%position + spread(model%origin, 2, &
            nodes), .true.), [1, 1], [2, nodes])
         do c = 1, channels
            call put(dataset, 'flow_channel_node', real(model%flow%channel(c)%node - 1, wp), &
               [1, c], [2, 1])
            call put(dataset, 'flow_channel_block', real(model%flow%channel(c)%block - 1, wp), &
               [1, c], [2, 1])
         end do
      end associate
   end subroutine put_flow

   !> Write constants of the bolts.
   subroutine put_bolts(dataset, simulation)
      type(dataset_type), intent(inout) :: dataset  !< open dataset; retains the first error
      type(simulation_type), intent(in) :: simulation  !< simulation at its present time
      integer :: i, k, at

      at = 0
      associate (bolts => simulation%model%bolts, origin => simulation%model%origin)
         if (size(bolts) == 0) return
         call put_names(dataset, 'bolt', bolts%name)
         do i = 1, size(bolts)
            associate (block => bolts(i)%block, position => bolts(i)%position, n => &
               size(bolts(i)%block))
               call put(dataset, 'bolt_block', real(block([1, n]) - 1, wp), [1, i], [2, 1])
               call put(dataset, 'bolt_place', pack(position(:, [1, n]) + spread(origin, 2, 2), &
                  .true.), [1, i], [4, 1])
               do k = 2, n - 1
                  at = at + 1
                  call put(dataset, 'bolt_through', [real(i - 1, wp)], [at], [1])
                  call put(dataset, 'bolt_through_block', [real(block(k) - 1, wp)], [at], [1])
                  call put(dataset, 'bolt_through_place', position(:, k) + origin, [1, at], [2, 1])
               end do
            end associate
         end do
      end associate
   end subroutine put_bolts

   !> Write names and edges of boundaries.
   subroutine put_boundaries(dataset, simulation)
      type(dataset_type), intent(inout) :: dataset  !< open dataset; retains the first error
      type(simulation_type), intent(in) :: simulation  !< simulation at its present time

      associate (edges => simulation%model%boundary_edges, &
         motions => simulation%model%boundary_motions)
         if (size(edges) == 0) return
         call put_names(dataset, 'boundary', motions%name)
         call put_names(dataset, 'boundary_kind', merge('free_field', 'compliant ', &
            motions%field > 0))
         call put(dataset, 'boundary_edge', real(edges%part%edge - 1, wp), [1], [size(edges)])
         call put(dataset, 'boundary_edge_group', real(edges%group - 1, wp), [1], [size(edges)])
         call put(dataset, 'boundary_edge_from', edges%part%from, [1], [size(edges)])
         call put(dataset, 'boundary_edge_to', edges%part%to, [1], [size(edges)])
      end associate
   end subroutine put_boundaries

   !> [blocks] number of the stage that removes each block; 0: none.
   pure function removal_stage(stages, n) result(removal)
      type(stage_type), intent(in) :: stages(:)  !< stages of the model
      integer, intent(in) :: n                   !< number of blocks
      real(wp) :: removal(n)
      integer :: s

      removal = 0.0_wp
      do s = 1, size(stages)
         where (stages(s)%removed) removal = s
      end do
   end function removal_stage

   !> Copy all rows of the journal to the file.
   subroutine copy_rows(output, journal, simulation, error)
      type(output_type), intent(inout) :: output  !< file being written
      type(journal_type), intent(in) :: journal  !< journal of the run
      type(simulation_type), intent(in) :: simulation  !< simulation at its present time
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(reader_type) :: reader
      real(wp) :: sample(size_of_sample(simulation))
      integer :: kind, contacts, capacity

      capacity = min(buffered_samples(simulation), journal%samples)
      allocate (output%column(capacity + spare_rows, size(sample)))
      call open_reader(reader, journal, error)
      do while (.not. (allocated(error) .or. allocated(output%dataset%error)))
         call read_row(reader, journal, kind, contacts, error)
         if (allocated(error) .or. kind == 0) exit
         if (kind == row_sample) then
            if (output%waiting == capacity) call put_samples(output, simulation)
            output%waiting = output%waiting + 1
            output%samples = output%samples + 1
            call read_numbers(reader, journal, sample, error)
            output%column(output%waiting, :) = sample
         else
            call put_frame(output, reader, journal, contacts, error)
         end if
      end do
      if (.not. allocated(error)) call put_samples(output, simulation)
      if (output%frames > 0 .and. .not. allocated(error)) call conclude(output%verdict, simulation)
      call close_file(reader%file, error)
   end subroutine copy_rows

   !> Write the buffered samples, and add them to the verdict.
   subroutine put_samples(output, simulation)
      type(output_type), intent(inout) :: output  !< file being written
      type(simulation_type), intent(in) :: simulation  !< simulation at its present time
      integer :: n, i, at, m

      n = output%waiting
      output%waiting = 0
      at = 0
      do i = 1, size(output_variables)
         associate (variable => output_variables(i))
            if (.not. is_in(variable, each_time, output%has(variable%family))) cycle
            m = numbers_of(variable, output%lengths)
            if (m > 0) call put_row(output, variable, rows_of(output%column(:n, at + 1:at + m)), &
               output%samples - n + 1, n)
            at = at + m
         end associate
      end do
      associate (velocity => offset_in_sample(simulation, out_velocity), &
         acceleration => offset_in_sample(simulation, out_acceleration), &
         joints => offset_in_sample(simulation, out_joint_slip), column => output%column(:n, :))
         call add_samples(output%verdict, column(:, 1), transpose(column(:, &
            velocity + 1:acceleration)), transpose(column(:, &
            acceleration + 1:2*acceleration - velocity)))
         call add_joint_samples(output%verdict, transpose(column(:, joints + 1:joints &
            + columns_of(in_measured_joints)*output%lengths(dim_measured_joint))))
      end associate
   end subroutine put_samples

   !> Values of all samples, sample by sample.
   pure function rows_of(column) result(values)
      real(wp), intent(in) :: column(:,:)  !< [samples, values]
      real(wp), allocatable :: values(:)
      integer :: i, k

      allocate (values(size(column)))
      do k = 1, size(column, 2)
         do i = 1, size(column, 1)
            values(size(column, 2)*(i - 1) + k) = column(i, k)
         end do
      end do
   end function rows_of

   !> Write values of a variable in consecutive rows (indices of the slowest dimension).
   subroutine put_row(output, variable, values, first, rows)
      type(output_type), intent(inout) :: output  !< file being written
      type(output_variable_type), intent(in) :: variable  !< variable of the schema
      real(wp), contiguous, intent(in) :: values(:)  !< values in the order of the file
      integer, intent(in) :: first, rows             !< index and length in the slowest dimension

      integer :: starts(size(variable%dimensions)), counts(size(variable%dimensions)), n

      n = count(variable%dimensions > 0)
      starts = 1
      starts(n) = first
      counts(:n - 1) = output%lengths(variable%dimensions(:n - 1))
      counts(n) = rows
      call put(output%dataset, variable%name, values, starts(:n), counts(:n))
   end subroutine put_row

   !> Write the next frame of the journal, variable by variable.
   subroutine put_frame(output, reader, journal, contacts, error)
      type(output_type), intent(inout) :: output  !< file being written
      type(reader_type), intent(inout) :: reader  !< reader of the journal, after the row header
      type(journal_type), intent(in) :: journal  !< journal of the run
      integer, intent(in) :: contacts  !< number of contacts
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      output%frames = output%frames + 1
      call copy_variables(output, reader, journal, each_frame, output%frames, 1, error)
      if (contacts == 0) return
      call put(output%dataset, 'contact_frame', spread(real(output%frames - 1, wp), 1, contacts), &
         [output%contacts + 1], [contacts])
      call copy_variables(output, reader, journal, each_contact, output%contacts + 1, contacts, &
         error)
      output%contacts = output%contacts + contacts
   end subroutine put_frame

   !> Copy the next numbers of the journal to variables with a value per frame or contact.
   subroutine copy_variables(output, reader, journal, row, first, rows, error)
      type(output_type), intent(inout) :: output  !< file being written
      type(reader_type), intent(inout) :: reader  !< reader of the journal
      type(journal_type), intent(in) :: journal  !< journal of the run
      integer, intent(in) :: row           !< each_frame or each_contact
      integer, intent(in) :: first, rows   !< index and length in the slowest dimension
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      real(wp), allocatable :: buffer(:)
      integer :: i

      do i = 1, size(output_variables)
         associate (variable => output_variables(i))
            if (.not. is_in(variable, row, output%has(variable%family))) cycle
            if (allocated(buffer)) deallocate (buffer)
            allocate (buffer(rows*numbers_of(variable, output%lengths)))
            call read_numbers(reader, journal, buffer, error)
            call put_row(output, variable, buffer, first, rows)
         end associate
      end do
   end subroutine copy_variables

end module dda_output_file
