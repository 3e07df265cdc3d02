! SPDX-License-Identifier: GPL-3.0-or-later
!> The output of a run: a netCDF-4 file that xarray opens as it is.
!>
!> It is always written as a whole from the journal, under a third name, and then renamed: to FILE
!> when the run is complete, from time to time before that to FILE.partial.  Either can therefore be
!> opened at any moment, and a run that is killed while it writes leaves the last one as it was.
module dda_output_file
   use, intrinsic :: iso_fortran_env, only: compiler_options, compiler_version
   use dda_kinds, only: wp, long
   use dda_base_motion, only: base_words
   use dda_byte_file, only: reserve_space, flush_file, close_file
   use dda_bolt, only: bolt_type
   use dda_breaking, only: can_break
   use dda_bolts, only: bolt_columns
   use dda_boundary_motion, only: boundary_series
   use dda_energy, only: energy_terms
   use dda_errors, only: error_type, error_file, fail
   use dda_file_system, only: rename_file, remove_file, is_special
   use dda_contact_table, only: contact_columns, contact_variables
   use dda_joint_motion, only: joint_columns
   use dda_journal, only: journal_type, reader_type, open_reader, read_row, read_numbers, &
      row_sample
   use dda_maxima, only: known, maxima_table, number_of_maxima
   use dda_model, only: model_type, block_sources
   use dda_output_place, only: partial_name, writing_name
   use dda_own_file, only: check_replaceable, netcdf_file
   use dda_netcdf_calls, only: dataset_type, variable_type, path_of, checked, define_variables, &
      define_dimension, describe, describe_number, name_length, put, put_names, text_of
   use dda_run_verdict, only: run_verdict_type, new_verdict, add_samples, &
      add_joint_samples, conclude
   use dda_verdict_lines, only: doubt_lines, figure_lines
   use dda_sample, only: sample_energies, sample_head, sample_size
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

   integer, parameter :: buffered = 1024          !< samples between writes
   integer(long), parameter :: overhead = 262144  !< bytes of a file without data and texts
   real(wp), parameter :: library_bytes = 5.0e6_wp  !< of memory: netCDF and HDF5, measured

   character(len=*), parameter :: motions(3) = [character(len=12) :: 'displacement', 'velocity', &
      'acceleration']

   !> Samples of measured points, behind them the energies.
   type(variable_type), parameter :: sample_variables(7) = [ &
      variable_type('time', nf90_double, 'time', 's', 'time'), &
      variable_type('displacement', nf90_double, 'axis point time', 'm', &
         'displacement of a measured point'), &
      variable_type('velocity', nf90_double, 'axis point time', 'm/s', &
         'velocity of a measured point'), &
      variable_type('acceleration', nf90_double, 'axis point time', 'm/s^2', &
         'acceleration of a measured point'), &
      variable_type('time_step', nf90_double, 'time', 's', 'time step that led here'), &
      variable_type('iterations', nf90_double, 'time', '1', &
         'most open-close iterations of a step since the last sample'), &
      variable_type('stage', nf90_int, 'time', '1', &
         'stage of the run, from 1; see the attribute stages')]

   !> States of all blocks, now and then.
   type(variable_type), parameter :: frame_variables(7) = [ &
      variable_type('frame', nf90_double, 'frame', 's', 'time of a frame'), &
      variable_type('frame_time', nf90_double, 'frame', 's', 'time of a frame'), &
      variable_type('frame_stage', nf90_int, 'frame', '1', &
         'stage of a frame, from 1; see the attribute stages'), &
      variable_type('block_coordinates', nf90_double, 'coordinate block frame', '', &
         'x and y of the centroid, rotation, strains ex ey gxy in axes of the block'), &
      variable_type('block_rates', nf90_double, 'coordinate block frame', '', &
         'rates of block_coordinates'), &
      variable_type('block_stress', nf90_double, 'component block frame', 'Pa', &
         'sigma_x, sigma_y, tau_xy in axes of the model, tension positive'), &
      variable_type('vertices', nf90_double, 'axis vertex frame', 'm', 'places of the vertices')]

   !> The largest values of all steps, see `dda_maxima`.
   type(variable_type), parameter :: maxima_variables(8) = [ &
      variable_type('maximum', nf90_char, 'letter maximum', '1', 'what a largest value is of'), &
      variable_type('maximum_unit', nf90_char, 'letter maximum', '1', 'unit of a largest value'), &
      variable_type('largest', nf90_double, 'maximum', '', &
         'largest value of all steps; not a number: there is none'), &
      variable_type('largest_time', nf90_double, 'maximum', 's', 'when it was so large'), &
      variable_type('largest_block', nf90_int, 'side maximum', '1', &
         'its block, of contacts those of vertex and edge, from 0; -1: none'), &
      variable_type('largest_point', nf90_int, 'side maximum', '1', &
         'its measured point, of drift also the one below, from 0; -1: none'), &
      variable_type('residual', nf90_double, 'maximum', '', 'largest value at the end'), &
      variable_type('largest_so_far', nf90_double, 'maximum time', '', &
         'largest value of all steps up to a sample')]

   !> Measured joints, of models that have some; the first ones in the order of `measure_joint`.
   type(variable_type), parameter :: joint_variables(joint_columns + 1) = [ &
      variable_type('joint_slip', nf90_double, 'measured_joint time', 'm', &
         'mean slip of a measured joint, to the right where the blocks against it are below'), &
      variable_type('joint_opening', nf90_double, 'measured_joint time', 'm', &
         'widest opening of a measured joint'), &
      variable_type('joint_normal_force', nf90_double, 'measured_joint time', 'N/m', &
         'normal forces of its contacts added up, compression positive'), &
      variable_type('joint_shear_force', nf90_double, 'measured_joint time', 'N/m', &
         'shear forces of its contacts added up, positive against positive slip'), &
      variable_type('joint_force_x', nf90_double, 'measured_joint time', 'N/m', &
         'force along x on its blocks by those against them'), &
      variable_type('joint_force_y', nf90_double, 'measured_joint time', 'N/m', &
         'force along y on its blocks by those against them'), &
      variable_type('measured_joint', nf90_char, 'letter measured_joint', '1', &
         'name of a measured joint')]

   !> Bolts, of models that have some.
   type(variable_type), parameter :: bolt_variables(bolt_columns + 3) = [ &
      variable_type('bolt_force', nf90_double, 'bolt time', 'N/m', &
         'axial force of a bolt, tension positive'), &
      variable_type('bolt_shear_force', nf90_double, 'bolt time', 'N/m', &
         'shear force of a grouted bolt at a joint'), &
      variable_type('bolt_elongation', nf90_double, 'bolt time', 'm', &
         'elongation since it was put in'), &
      variable_type('bolt_state', nf90_int, 'bolt time', '1', &
         '0 not there, 1 elastic, 2 yields, 3 slack, 4 broken'), &
      variable_type('bolt', nf90_char, 'letter bolt', '1', &
         'name of a bolt, once for each joint that a grouted one crosses'), &
      variable_type('bolt_block', nf90_int, 'axis bolt', '1', 'blocks of its ends, from 0'), &
      variable_type('bolt_place', nf90_double, 'coordinate4 bolt', 'm', &
         'first places of its ends: x, y, x, y')]

   !> Points that cables pass, of models that have some.
   type(variable_type), parameter :: through_variables(3) = [ &
      variable_type('bolt_through', nf90_int, 'through', '1', &
         'bolt that passes a point between its ends, from 0, in the order of its points'), &
      variable_type('bolt_through_block', nf90_int, 'through', '1', &
         'block that the point is in, from 0'), &
      variable_type('bolt_through_place', nf90_double, 'axis through', 'm', &
         'first place of the point')]

   !> Boundaries that something comes in through, of models that have some; the first six in the
   !> order of `take_boundary_motions`.
   type(variable_type), parameter :: motion_variables(boundary_series + 2) = [ &
      variable_type('incoming_displacement', nf90_double, 'axis boundary time', 'm', &
         'displacement of what comes in: a wave, or the free field at its surface'), &
      variable_type('incoming_velocity', nf90_double, 'axis boundary time', 'm/s', &
         'velocity of what comes in'), &
      variable_type('incoming_acceleration', nf90_double, 'axis boundary time', 'm/s^2', &
         'acceleration of what comes in'), &
      variable_type('boundary_displacement', nf90_double, 'axis boundary time', 'm', &
         'displacement of a boundary: mean of its edges, of a free-field side its upper end'), &
      variable_type('boundary_velocity', nf90_double, 'axis boundary time', 'm/s', &
         'velocity of a boundary'), &
      variable_type('boundary_acceleration', nf90_double, 'axis boundary time', 'm/s^2', &
         'acceleration of a boundary'), &
      variable_type('boundary', nf90_char, 'letter boundary', '1', &
         'name of a boundary that something comes in through'), &
      variable_type('boundary_kind', nf90_char, 'letter boundary', '1', &
         'its kind: compliant or free_field')]

   !> Edges of the groups &boundary, of models that have some.
   type(variable_type), parameter :: edge_variables(4) = [ &
      variable_type('boundary_edge', nf90_int, 'boundary_edge', '1', &
         'edge that has a boundary, by its first vertex, from 0'), &
      variable_type('boundary_edge_group', nf90_int, 'boundary_edge', '1', &
         'its group &boundary, from 0 in the order of the input'), &
      variable_type('boundary_edge_from', nf90_double, 'boundary_edge', '1', &
         'share of the edge at which the boundary begins'), &
      variable_type('boundary_edge_to', nf90_double, 'boundary_edge', '1', &
         'share of the edge at which the boundary ends')]

   !> Names that let xarray select by them, and the shape of the model.
   type(variable_type), parameter :: model_variables(15) = [ &
      variable_type('axis', nf90_char, 'letter axis', '1', 'axis of the model'), &
      variable_type('coordinate', nf90_char, 'letter coordinate', '1', 'coordinate of a block'), &
      variable_type('coordinate_unit', nf90_char, 'letter coordinate', '1', &
         'unit of a block coordinate'), &
      variable_type('rate_unit', nf90_char, 'letter coordinate', '1', &
         'unit of the rate of a block coordinate'), &
      variable_type('component', nf90_char, 'letter component', '1', 'component of the stress'), &
      variable_type('block', nf90_char, 'letter block', '1', 'name of a block'), &
      variable_type('block_removal', nf90_int, 'block', '1', &
         'stage in which a block is removed, from 1; 0: it stays'), &
      variable_type('point', nf90_char, 'letter point', '1', 'name of a measured point'), &
      variable_type('point_place', nf90_double, 'axis point', 'm', &
         'first place of a measured point'), &
      variable_type('block_material', nf90_int, 'block', '1', &
         'material of a block at the start, from 0 in the order of the input'), &
      variable_type('edge_joint', nf90_int, 'vertex', '1', &
         'joint of the edge that begins at a vertex at the start, from 0'), &
      variable_type('block_density', nf90_double, 'block', 'kg/m^3', 'density'), &
      variable_type('block_shear_modulus', nf90_double, 'block', 'Pa', 'shear modulus'), &
      variable_type('vertex_block', nf90_int, 'vertex', '1', 'block of a vertex, from 0'), &
      variable_type('joint', nf90_char, 'letter joint', '1', 'name of a joint material')]

   type(variable_type), parameter :: body_variables(4) = [ &
      variable_type('edge_welded', nf90_int, 'vertex', '1', &
         '1: the edge that begins at a vertex lies within a body'), &
      variable_type('body', nf90_char, 'letter body', '1', 'name of a body'), &
      variable_type('block_body', nf90_int, 'block', '1', &
         'body that a block is a cell of, from 1; 0: none'), &
      variable_type('block_stress_error', nf90_double, 'block frame', 'Pa', &
         'error of the stress of a cell, estimated by the jumps at its faces')]

   type(variable_type), parameter :: yield_variables(1) = [ &
      variable_type('block_plastic_strain', nf90_double, 'block frame', '1', &
         'largest plastic strain in a block, as the law of its material counts it')]

   type(variable_type), parameter :: crack_variables(1) = [ &
      variable_type('edge_damage', nf90_double, 'vertex frame', '1', &
         'damage of the faces of the edge that begins at a vertex: 0 whole, 1 broken')]

   !> An output file that is being written.
   type :: output_type
      type(dataset_type) :: dataset
      integer :: points = 0
      integer :: joints = 0                       !< measured
      integer :: bolts = 0
      integer :: boundaries = 0                   !< that something comes in through
      integer :: samples = 0                      !< written and buffered
      integer :: waiting = 0                      !< buffered
      integer :: frames = 0
      integer :: contacts = 0                     !< contact states written
      type(run_verdict_type) :: verdict
      real(wp), allocatable :: sample(:,:)        !< [numbers of a sample, buffered]
   end type output_type

contains

   !> Write all that the journal has to FILE, or to FILE.partial if the run is not complete.
   subroutine write_output(file, journal, simulation, complete, error)
      character(len=*), intent(in) :: file  !< path of the output
      type(journal_type), intent(in) :: journal  !< of the run
      type(simulation_type), intent(in) :: simulation  !< at its present time
      logical, intent(in) :: complete  !< the run has reached its duration
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(output_type) :: output
      character(len=:), allocatable :: name

      name = partial_name(file)
      if (complete) name = file
      output%dataset%file = writing_name(file)
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

   !> Upper bound of the size of the file, bytes.
   pure integer(long) function bytes_for(journal, simulation) result(bytes)
      type(journal_type), intent(in) :: journal  !< of the run
      type(simulation_type), intent(in) :: simulation  !< at its present time
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

   !> Upper bound of the memory that `write_output` takes, bytes: a frame and the first one, samples
   !> and copies of parts of them, texts.
   pure real(wp) function writing_memory(simulation) result(bytes)
      type(simulation_type), intent(in) :: simulation  !< at its present time
      integer, parameter :: word = storage_size(1.0_wp)/8  ! bytes of a number
      real(wp) :: frame, samples

      associate (contacts => simulation%contacts(simulation%now)%n, n => simulation%blocks%n)
         frame = real(max(6*n, 2*contacts), wp) + 3*n + 3*2*size(simulation%blocks%owner) &
            + 3*contacts
      end associate
      samples = 3*real(buffered, wp)*sample_size(simulation)
      bytes = library_bytes + word*(frame + samples) + 4*len(simulation%model%text) &
         + 4*len(simulation%changes)
   end function writing_memory

   !> Create the file, write everything, close it.
   subroutine write_dataset(output, journal, simulation, complete, error)
      type(output_type), intent(inout) :: output  !< file being written
      type(journal_type), intent(in) :: journal  !< of the run
      type(simulation_type), intent(in) :: simulation  !< at its present time
      logical, intent(in) :: complete  !< the run has reached its duration
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      integer :: unused

      associate (dataset => output%dataset)
         call checked(dataset, nf90_create(path_of(dataset%file), ior(nf90_netcdf4, &
            nf90_clobber), dataset%id), 'create the file')
         if (.not. allocated(dataset%error)) then
            ! All that is defined is written, unless there are no points.
            if (size(simulation%model%points) > 0) &
               call checked(dataset, nf90_set_fill(dataset%id, nf90_nofill, unused), 'set it up')
            call describe_run(dataset, simulation, merge('yes', 'no ', complete))
            call define_file(dataset, journal, simulation)
            call write_constants(dataset, simulation)
            output%points = size(simulation%model%points)
            output%joints = size(simulation%model%measured_joints)
            output%bolts = size(simulation%model%bolts)
            output%boundaries = size(simulation%model%boundary_motions)
            output%verdict = new_verdict(simulation, output%points, output%joints)
            call copy_rows(output, journal, simulation, error)
            call describe_verdict(dataset, output%verdict)
            call checked(dataset, nf90_close(dataset%id), 'close the file')
         end if
         if (.not. allocated(error) .and. allocated(dataset%error)) error = dataset%error
      end associate
   end subroutine write_dataset

   !> Dimensions and variables.
   subroutine define_file(dataset, journal, simulation)
      type(dataset_type), intent(inout) :: dataset  !< open; keeps the first error
      type(journal_type), intent(in) :: journal  !< of the run
      type(simulation_type), intent(in) :: simulation  !< at its present time
      integer :: i

      call define_dimension(dataset, 'time', journal%samples)
      call define_dimension(dataset, 'point', max(1, size(simulation%model%points)))
      call define_dimension(dataset, 'axis', 2)
      call define_dimension(dataset, 'frame', journal%frames)
      call define_dimension(dataset, 'block', simulation%blocks%n)
      call define_dimension(dataset, 'coordinate', 6)
      call define_dimension(dataset, 'component', 3)
      call define_dimension(dataset, 'vertex', size(simulation%blocks%owner))
      call define_dimension(dataset, 'contact', journal%contacts)
      call define_dimension(dataset, 'letter', name_length)
      call define_dimension(dataset, 'joint', size(simulation%model%joints))
      call define_dimension(dataset, 'maximum', number_of_maxima)
      call define_dimension(dataset, 'side', 2)
      call define_variables(dataset, [sample_variables, &
         (variable_type('energy_'//energy_terms(i)%name, nf90_double, 'time', 'J/m', &
         trim(energy_terms(i)%meaning)//', per metre of thickness'), i=1, size(energy_terms)), &
         frame_variables, contact_variables(:contact_columns(simulation)), model_variables, &
         maxima_variables])
      associate (model => simulation%model)
         if (size(model%bolts) > 0) call define_dimension(dataset, 'coordinate4', 4)
         call define_family(dataset, 'measured_joint', size(model%measured_joints), joint_variables)
         call define_family(dataset, 'bolt', size(model%bolts), bolt_variables)
         call define_family(dataset, 'body', size(model%body_names), body_variables)
         if (any(model%materials%yields())) call define_variables(dataset, yield_variables)
         if (can_break(model)) call define_variables(dataset, crack_variables)
         call define_family(dataset, 'through', points_between(model%bolts), through_variables)
         call define_family(dataset, 'boundary_edge', size(model%boundary_edges), edge_variables)
         call define_family(dataset, 'boundary', size(model%boundary_motions), motion_variables)
      end associate
      if (.not. allocated(dataset%error)) call checked(dataset, nf90_enddef(dataset%id), &
         'end the definitions')
   end subroutine define_file

   !> Variables of what a model may have, and their dimension; none if it has nothing of it.
   subroutine define_family(dataset, dimension, length, variables)
      type(dataset_type), intent(inout) :: dataset         !< open; keeps the first error
      character(len=*), intent(in) :: dimension            !< name
      integer, intent(in) :: length                        !< of the dimension
      type(variable_type), intent(in) :: variables(:)      !< along it

      if (length == 0) return
      call define_dimension(dataset, dimension, length)
      call define_variables(dataset, variables)
   end subroutine define_family

   !> All that is needed to repeat the run.
   subroutine describe_run(dataset, simulation, complete)
      type(dataset_type), intent(inout) :: dataset  !< open; keeps the first error
      type(simulation_type), intent(in) :: simulation  !< at its present time
      character(len=*), intent(in) :: complete  !< 'yes' or 'no'
      character(len=:), allocatable :: audit

      call describe(dataset, 'title', simulation%model%title)
      call describe(dataset, 'source', 'sitedda '//version)
      call describe(dataset, 'commit', commit)
      call describe(dataset, 'compiler', compiler_version()//' '//compiler_options())
      call describe(dataset, 'input_file', simulation%model%file)
      call describe(dataset, 'input_text', simulation%model%text)
      call describe(dataset, 'input_values', simulation%model%values)
      call describe(dataset, 'block_files', block_sources(simulation%model))
      call describe(dataset, 'motions', sources_of(simulation%model))
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
      call describe(dataset, 'coordinates', &
         'frame_time frame_stage stage coordinate_unit rate_unit maximum_unit block_removal')
      call describe(dataset, 'maxima_base', base_words(simulation%maxima%base, simulation%model))
   end subroutine describe_run

   !> Verdict, in words and numbers.
   subroutine describe_verdict(dataset, verdict)
      type(dataset_type), intent(inout) :: dataset  !< open; keeps the first error
      type(run_verdict_type), intent(in) :: verdict  !< of all frames
      integer :: i

      if (verdict%happened == '') return
      call describe(dataset, 'verdict', verdict%happened)
      call describe(dataset, 'figures', figure_lines(verdict))
      call describe(dataset, 'doubts', doubt_lines(verdict))
      do i = 1, size(verdict%values)
         call describe_number(dataset, verdict%values(i)%name, verdict%values(i)%value)
      end do
   end subroutine describe_verdict

   !> The records of a model and what was done to them, a line each.
   pure function sources_of(model) result(text)
      type(model_type), intent(in) :: model  !< as read from the input
      character(len=:), allocatable :: text
      integer :: i

      text = ''
      do i = 1, size(model%motions)
         if (i > 1) text = text//new_line('a')
         text = text//model%motions(i)%source
      end do
   end function sources_of

   !> The output exists, is complete, and was made from this input and these records.
   logical function is_complete(file, model)
      character(len=*), intent(in) :: file      !< output
      type(model_type), intent(in) :: model  !< as read from the input
      type(dataset_type) :: dataset

      dataset%file = file
      is_complete = .not. is_special(file)
      if (is_complete) is_complete = nf90_open(path_of(file), nf90_nowrite, dataset%id) == &
         nf90_noerr
      if (.not. is_complete) return
      is_complete = text_of(dataset, 'complete') == 'yes' .and. text_of(dataset, 'changes') == '' &
         .and. text_of(dataset, 'input_text') == model%text &
         .and. text_of(dataset, 'block_files') == block_sources(model) &
         .and. text_of(dataset, 'motions') == sources_of(model)
      call checked(dataset, nf90_close(dataset%id), 'close the file')
   end function is_complete

   !> Values that do not depend on time.
   subroutine write_constants(dataset, simulation)
      type(dataset_type), intent(inout) :: dataset  !< open; keeps the first error
      type(simulation_type), intent(in) :: simulation  !< at its present time
      integer :: i

      associate (points => simulation%model%points, blocks => simulation%blocks)
         do i = 1, size(points)
            call put(dataset, 'point_place', points(i)%place + simulation%model%origin, [1, i], &
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
         call put(dataset, 'block_removal', removal_of(simulation%model%stages, blocks%n), [1], &
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
         call put_boundaries(dataset, simulation)
         call put(dataset, 'vertex_block', real(blocks%owner - 1, wp), [1], [size(blocks%owner)])
         call put(dataset, 'block_density', blocks%mass/blocks%area, [1], [blocks%n])
         call put(dataset, 'block_shear_modulus', blocks%stiffness(3, 3, :)/blocks%area, [1], &
            [blocks%n])
      end associate
   end subroutine write_constants

   !> The largest values of the run up to the present time.
   subroutine put_maxima(dataset, simulation)
      type(dataset_type), intent(inout) :: dataset  !< open; keeps the first error
      type(simulation_type), intent(in) :: simulation  !< at its present time
      integer, parameter :: n = number_of_maxima
      real(wp) :: who(2, n, 2)
      integer :: i

      associate (maxima => simulation%maxima)
         who = -1.0_wp
         do i = 1, n
            who(:, i, merge(2, 1, maxima_table(i)%of_points)) = maxima%largest(i)%who - 1
         end do
         call put_names(dataset, 'maximum', maxima_table%name)
         call put_names(dataset, 'maximum_unit', maxima_table%units)
         call put(dataset, 'largest', known(maxima%largest), [1], [n])
         call put(dataset, 'largest_time', maxima%largest%time, [1], [n])
         call put(dataset, 'largest_block', pack(who(:, :, 1), .true.), [1, 1], [2, n])
         call put(dataset, 'largest_point', pack(who(:, :, 2), .true.), [1, 1], [2, n])
         call put(dataset, 'residual', known(maxima%last), [1], [n])
      end associate
   end subroutine put_maxima

   !> Constants of the bolts.
   subroutine put_bolts(dataset, simulation)
      type(dataset_type), intent(inout) :: dataset  !< open; keeps the first error
      type(simulation_type), intent(in) :: simulation  !< at its present time
      integer :: i, k, at

      at = 0
      associate (bolts => simulation%model%bolts, origin => simulation%model%origin)
         if (size(bolts) == 0) return
         call put_names(dataset, 'bolt', bolts%name)
         do i = 1, size(bolts)
            associate (block => bolts(i)%block, place => bolts(i)%place, n => size(bolts(i)%block))
               call put(dataset, 'bolt_block', real(block([1, n]) - 1, wp), [1, i], [2, 1])
               call put(dataset, 'bolt_place', pack(place(:, [1, n]) + spread(origin, 2, 2), &
                  .true.), [1, i], [4, 1])
               do k = 2, n - 1
                  at = at + 1
                  call put(dataset, 'bolt_through', [real(i - 1, wp)], [at], [1])
                  call put(dataset, 'bolt_through_block', [real(block(k) - 1, wp)], [at], [1])
                  call put(dataset, 'bolt_through_place', place(:, k) + origin, [1, at], [2, 1])
               end do
            end associate
         end do
      end associate
   end subroutine put_bolts

   !> Points that cables pass between their ends.
   pure integer function points_between(bolts) result(n)
      type(bolt_type), intent(in) :: bolts(:)  !< of a model
      integer :: i

      n = sum([(size(bolts(i)%block) - 2, i=1, size(bolts))])
   end function points_between

   !> Names and edges of boundaries.
   subroutine put_boundaries(dataset, simulation)
      type(dataset_type), intent(inout) :: dataset  !< open; keeps the first error
      type(simulation_type), intent(in) :: simulation  !< at its present time

      associate (edges => simulation%model%boundary_edges, &
         motions => simulation%model%boundary_motions)
         if (size(edges) == 0) return
         call put_names(dataset, 'boundary', motions%name)
         call put_names(dataset, 'boundary_kind', merge('free_field', 'compliant ', &
            motions%field > 0))
         call put(dataset, 'boundary_edge', real(edges%piece%edge - 1, wp), [1], [size(edges)])
         call put(dataset, 'boundary_edge_group', real(edges%group - 1, wp), [1], [size(edges)])
         call put(dataset, 'boundary_edge_from', edges%piece%from, [1], [size(edges)])
         call put(dataset, 'boundary_edge_to', edges%piece%to, [1], [size(edges)])
      end associate
   end subroutine put_boundaries

   !> The stage that removes each block; 0: none does.
   pure function removal_of(stages, n) result(removal)
      type(stage_type), intent(in) :: stages(:)  !< of the model
      integer, intent(in) :: n                   !< blocks
      real(wp) :: removal(n)
      integer :: s

      removal = 0.0_wp
      do s = 1, size(stages)
         where (stages(s)%removed) removal = s
      end do
   end function removal_of

   !> All rows of the journal, in its order.
   subroutine copy_rows(output, journal, simulation, error)
      type(output_type), intent(inout) :: output  !< file being written
      type(journal_type), intent(in) :: journal  !< of the run
      type(simulation_type), intent(in) :: simulation  !< at its present time
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(reader_type) :: reader
      integer :: kind, contacts

      allocate (output%sample(sample_size(simulation), buffered))
      call open_reader(reader, journal, error)
      do while (.not. (allocated(error) .or. allocated(output%dataset%error)))
         call read_row(reader, kind, contacts, error)
         if (allocated(error) .or. kind == 0) exit
         if (kind == row_sample) then
            if (output%waiting == buffered) call put_samples(output)
            output%waiting = output%waiting + 1
            output%samples = output%samples + 1
            call read_numbers(reader, output%sample(:, output%waiting), error)
         else
            call put_frame(output, reader, simulation, contacts, error)
         end if
      end do
      if (.not. allocated(error)) call put_samples(output)
      if (output%frames > 0 .and. .not. allocated(error)) call conclude(output%verdict, simulation)
      call close_file(reader%file, error)
   end subroutine copy_rows

   !> Write the buffered samples, and take them into the verdict.
   subroutine put_samples(output)
      type(output_type), intent(inout) :: output  !< file being written
      integer :: first, n, i, at

      n = output%waiting
      first = output%samples - n + 1
      output%waiting = 0
      associate (dataset => output%dataset, sample => output%sample)
         call put(dataset, 'time', sample(1, :n), [first], [n])
         call put(dataset, 'time_step', sample(2, :n), [first], [n])
         call put(dataset, 'iterations', sample(3, :n), [first], [n])
         call put(dataset, 'stage', sample(4, :n), [first], [n])
         do i = 1, size(energy_terms)
            call put(dataset, 'energy_'//trim(energy_terms(i)%name), sample(4 + i, :n), [first], &
               [n])
         end do
         call put(dataset, 'largest_so_far', reshape(sample(sample_energies + 1:sample_head, :n), &
            [number_of_maxima*n]), [1, first], [number_of_maxima, n])
         at = sample_head
         associate (velocity => at + 2*output%points, acceleration => at + 4*output%points, &
            last => at + 6*output%points)
            call add_samples(output%verdict, sample(1, :n), sample(velocity + 1:acceleration, :n), &
               sample(acceleration + 1:last, :n))
         end associate
         call put_motions(motions, output%points)
         call add_joint_samples(output%verdict, sample(at + 1:at + joint_columns*output%joints, :n))
         call put_columns(output, joint_variables(:joint_columns)%name, output%joints, n, at)
         call put_columns(output, bolt_variables(:bolt_columns)%name, output%bolts, n, at)
         call put_motions(motion_variables(:boundary_series)%name, output%boundaries)
      end associate

   contains

      !> The next numbers of the samples, as vectors of points or boundaries.
      subroutine put_motions(names, count)
         character(len=*), intent(in) :: names(:)  !< of the variables
         integer, intent(in) :: count              !< points or boundaries
         integer :: kind

         do kind = 1, merge(size(names), 0, count > 0)
            call put(output%dataset, trim(names(kind)), reshape(output%sample( &
               at + 1:at + 2*count, :n), [2*count*n]), [1, 1, first], [2, count, n])
            at = at + 2*count
         end do
      end subroutine put_motions
   end subroutine put_samples

   !> The next numbers of the samples, as columns of joints or bolts.
   subroutine put_columns(output, names, count, n, at)
      type(output_type), intent(inout) :: output  !< file being written
      character(len=*), intent(in) :: names(:)    !< of the variables
      integer, intent(in) :: count                !< joints or bolts
      integer, intent(in) :: n                    !< samples buffered
      integer, intent(inout) :: at !< numbers of a sample before these; then with them
      integer :: column

      do column = 1, merge(size(names), 0, count > 0)
         call put(output%dataset, trim(names(column)), reshape(output%sample(at + column: &
            at + size(names)*count:size(names), :n), [count*n]), [1, output%samples - n + 1], &
            [count, n])
      end do
      at = at + size(names)*count
   end subroutine put_columns

   !> Write the next frame of the journal, part by part.
   subroutine put_frame(output, reader, simulation, contacts, error)
      type(output_type), intent(inout) :: output  !< file being written
      type(reader_type), intent(inout) :: reader  !< of the journal, behind the head of the row
      type(simulation_type), intent(in) :: simulation  !< whose frame it is
      integer, intent(in) :: contacts  !< number of contacts
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      real(wp), allocatable :: part(:)
      real(wp) :: head(2)
      integer :: f, i

      output%frames = output%frames + 1
      f = output%frames
      call read_numbers(reader, head, error)
      call put(output%dataset, 'frame', head(1:1), [f], [1])
      call put(output%dataset, 'frame_time', head(1:1), [f], [1])
      call put(output%dataset, 'frame_stage', head(2:2), [f], [1])
      associate (n => simulation%blocks%n, vertices => size(simulation%blocks%owner))
         call copy('block_coordinates', [1, 1, f], [6, n, 1])
         call copy('block_rates', [1, 1, f], [6, n, 1])
         call copy('block_stress', [1, 1, f], [3, n, 1])
         call copy('vertices', [1, 1, f], [2, vertices, 1])
         if (size(simulation%model%body_names) > 0) call copy('block_stress_error', [1, f], [n, 1])
         if (any(simulation%model%materials%yields())) &
            call copy('block_plastic_strain', [1, f], [n, 1])
         if (can_break(simulation%model)) call copy('edge_damage', [1, f], [vertices, 1])
      end associate
      if (contacts == 0) return
      part = spread(real(f - 1, wp), 1, contacts)
      call put(output%dataset, 'contact_frame', part, [output%contacts + 1], [contacts])
      do i = 1, contact_columns(simulation)
         call copy(contact_variables(i)%name, [output%contacts + 1], [contacts])
      end do
      output%contacts = output%contacts + contacts

   contains

      !> The next numbers of the frame, as a variable.
      subroutine copy(name, first, counts)
         character(len=*), intent(in) :: name  !< of the variable
         integer, intent(in) :: first(:), counts(:)  !< [dimensions] of the file

         if (allocated(part)) deallocate (part)
         allocate (part(product(counts)))
         call read_numbers(reader, part, error)
         call put(output%dataset, trim(name), part, first, counts)
      end subroutine copy
   end subroutine put_frame

end module dda_output_file
