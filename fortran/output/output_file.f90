!> The output of a run: a netCDF-4 file that xarray opens as it is.
!>
!> It is always written as a whole from the journal, under a third name, and then renamed: to FILE
!> when the run is complete, from time to time before that to FILE.partial.  Either can therefore be
!> opened at any moment, and a run that dies while it writes leaves the last one as it was.
module dda_output_file
   use, intrinsic :: iso_c_binding, only: c_null_char
   use, intrinsic :: iso_fortran_env, only: compiler_options, compiler_version
   use dda_kinds, only: wp, long
   use dda_blocks, only: blocks_type
   use dda_byte_file, only: reserve_space, flush_file
   use dda_energy, only: energy_terms
   use dda_errors, only: error_type, error_file, fail
   use dda_file_system, only: rename_file, remove_file, same_file, is_folder, folder_of
   use dda_journal, only: journal_type, reader_type, open_reader, read_row, read_numbers, &
      close_reader, row_sample
   use dda_model, only: model_type
   use dda_netcdf_calls, only: dataset_type, checked, define, define_dimension, describe, put, &
      text_of
   use dda_sample, only: sample_head, contact_columns, sample_size, frame_size
   use dda_simulation, only: simulation_type, summary
   use dda_linear_solver, only: work_done
   use dda_text, only: joined, quoted
   use dda_diagnostics, only: audit_warning
   use dda_version, only: version
   use netcdf, only: nf90_create, nf90_open, nf90_close, nf90_enddef, nf90_netcdf4, nf90_clobber, &
      nf90_nowrite, nf90_noerr, nf90_set_fill, nf90_nofill, nf90_double, nf90_int, nf90_char, &
      nf90_put_att, nf90_put_var
   implicit none
   private
   public :: check_target, write_output, is_complete, partial_name

   integer, parameter :: buffered = 1024          !< samples between writes
   integer(long), parameter :: overhead = 262144  !< bytes of a file without data and texts

   !> An output file that is being written; the integers without comment are netCDF variables.
   type :: output_type
      type(dataset_type) :: dataset
      integer :: points = 0
      integer :: samples = 0                      !< written and buffered
      integer :: waiting = 0                      !< buffered
      integer :: frames = 0
      integer :: contacts = 0                     !< contact states written
      integer :: time, time_step, iterations, stage
      integer :: motion(3)                        !< displacement, velocity, acceleration
      integer :: energy(size(energy_terms))
      integer :: frame_time, coordinates, rates, stress, vertices, vertex, block, name, place, owner
      integer :: density, modulus
      integer :: contact_frame, contact(contact_columns)
      real(wp), allocatable :: sample(:,:)        !< [buffered, numbers of a sample]
   end type output_type

contains

   !> The partial output of an unfinished run.
   pure function partial_name(file) result(name)
      character(len=*), intent(in) :: file  !< path of the output
      character(len=:), allocatable :: name

      name = file//'.partial'
   end function partial_name

   !> The output must not be a folder, the input or a record.
   subroutine check_target(file, model, error)
      character(len=*), intent(in) :: file  !< path of the output
      type(model_type), intent(in) :: model  !< as read from the input
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      logical :: folder
      integer :: i

      folder = is_folder(file)
      if (file == '' .or. folder) then
         call fail(error, error_file, 'the output '//quoted(file)//' is a folder, not a file name')
      else if (.not. is_folder(folder_of(file))) then
         call fail(error, error_file, file//': the folder '//folder_of(file)//' does not exist')
      else if (same_file(file, model%file)) then
         call fail(error, error_file, 'the output '//file//' would replace the input')
      end if
      do i = 1, size(model%motions)
         if (allocated(error)) return
         if (same_file(file, model%motions(i)%file)) call fail(error, error_file, 'the output '// &
            file//' would replace the record of motion '//trim(model%motions(i)%name))
      end do
   end subroutine check_target

   !> Write all that the journal holds to FILE, or to FILE.partial if the run is not complete.
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
      output%dataset%file = file//'.writing'
      ! HDF5 crashes if the disk fills up while it writes, so the space is allocated first.
      call reserve_space(output%dataset%file, bytes_for(journal, simulation), error)
      if (.not. allocated(error)) call write_dataset(output, journal, simulation, complete, error)
      if (.not. allocated(error) .and. complete) call flush_file(output%dataset%file, error)
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

      bytes = overhead + 2*len(simulation%model%text) + journal%bytes &
         + 256*size(simulation%model%points) + 32*size(simulation%blocks%owner)
      do i = 1, size(simulation%model%motions)
         bytes = bytes + 2*len(simulation%model%motions(i)%source)
      end do
   end function bytes_for

   !> Create the file, write everything, close it.
   subroutine write_dataset(output, journal, simulation, complete, error)
      type(output_type), intent(inout) :: output  !< file being written
      type(journal_type), intent(in) :: journal  !< of the run
      type(simulation_type), intent(in) :: simulation  !< at its present time
      logical, intent(in) :: complete  !< the run has reached its duration
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      integer :: unused

      associate (dataset => output%dataset)
         call checked(dataset, nf90_create(dataset%file, ior(nf90_netcdf4, nf90_clobber), &
            dataset%id), 'create the file')
         if (.not. allocated(dataset%error)) then
            ! All that is defined is written, unless there are no points.
            if (size(simulation%model%points) > 0) &
               call checked(dataset, nf90_set_fill(dataset%id, nf90_nofill, unused), 'set it up')
            call describe_run(dataset, simulation, merge('yes', 'no ', complete))
            call define_file(output, journal, simulation)
            call copy_rows(output, journal, simulation, error)
            call checked(dataset, nf90_close(dataset%id), 'close the file')
         end if
         if (.not. allocated(error) .and. allocated(dataset%error)) error = dataset%error
      end associate
   end subroutine write_dataset

   !> Dimensions, variables, and the values that do not change.
   subroutine define_file(output, journal, simulation)
      type(output_type), intent(inout) :: output  !< file being written
      type(journal_type), intent(in) :: journal  !< of the run
      type(simulation_type), intent(in) :: simulation  !< at its present time
      integer :: time, point, axis, frame

      output%points = size(simulation%model%points)
      associate (dataset => output%dataset)
         time = define_dimension(dataset, 'time', journal%samples)
         point = define_dimension(dataset, 'point', max(1, output%points))
         axis = define_dimension(dataset, 'axis', 2)
         frame = define_dimension(dataset, 'frame', journal%frames)
         output%block = define_dimension(dataset, 'block', simulation%blocks%n)
         call define_history(output, time, point, axis)
         call define_frames(output, frame, output%block, axis, simulation%blocks)
         call define_contacts(output, journal%contacts)
         call define_names(output, simulation, point, axis)
         if (.not. allocated(dataset%error)) call checked(dataset, nf90_enddef(dataset%id), &
            'end the definitions')
      end associate
      call write_constants(output, simulation)
   end subroutine define_file

   !> All that is needed to repeat the run.
   subroutine describe_run(dataset, simulation, complete)
      type(dataset_type), intent(inout) :: dataset  !< open; keeps the first error
      type(simulation_type), intent(in) :: simulation  !< at its present time
      character(len=*), intent(in) :: complete  !< 'yes' or 'no'
      character(len=:), allocatable :: audit

      call describe(dataset, 'title', simulation%model%title)
      call describe(dataset, 'source', 'sitedda '//version)
      call describe(dataset, 'compiler', compiler_version()//' '//compiler_options())
      call describe(dataset, 'input_file', simulation%model%file)
      call describe(dataset, 'input_text', simulation%model%text)
      call describe(dataset, 'motions', sources_of(simulation%model))
      call describe(dataset, 'step_control', summary(simulation))
      call describe(dataset, 'stages', joined(simulation%model%stages%name, ', '))
      audit = audit_warning(simulation)
      if (audit == '') audit = 'balances'
      call describe(dataset, 'energy_audit', audit)
      call describe(dataset, 'solver', work_done(simulation%solver))
      call describe(dataset, 'complete', trim(complete))
   end subroutine describe_run

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

   !> Whether the output exists, is complete, and was made from this input and these records.
   logical function is_complete(file, model)
      character(len=*), intent(in) :: file      !< output
      type(model_type), intent(in) :: model  !< as read from the input
      type(dataset_type) :: dataset

      dataset%file = file
      is_complete = nf90_open(file, nf90_nowrite, dataset%id) == nf90_noerr
      if (.not. is_complete) return
      is_complete = text_of(dataset, 'complete') == 'yes' &
         .and. text_of(dataset, 'input_text') == model%text &
         .and. text_of(dataset, 'motions') == sources_of(model)
      call checked(dataset, nf90_close(dataset%id), 'close the file')
   end function is_complete

   !> Samples of measured points and energies.
   subroutine define_history(output, time, point, axis)
      type(output_type), intent(inout) :: output  !< file being written
      integer, intent(in) :: time, point, axis  !< netCDF dimensions
      integer :: i

      associate (dataset => output%dataset)
         output%time = define(dataset, 'time', nf90_double, [time], 's', 'time')
         output%motion(1) = define(dataset, 'displacement', nf90_double, [axis, point, time], 'm', &
            'displacement of a measured point')
         output%motion(2) = define(dataset, 'velocity', nf90_double, [axis, point, time], 'm s-1', &
            'velocity of a measured point')
         output%motion(3) = define(dataset, 'acceleration', nf90_double, [axis, point, time], &
            'm s-2', 'acceleration of a measured point')
         output%time_step = define(dataset, 'time_step', nf90_double, [time], 's', &
            'time step that led here')
         output%iterations = define(dataset, 'iterations', nf90_double, [time], '1', &
            'most open-close iterations of a step since the last sample')
         output%stage = define(dataset, 'stage', nf90_int, [time], '1', &
            'stage of the run, from 1; see the attribute stages')
         do i = 1, size(energy_terms)
            output%energy(i) = define(dataset, 'energy_'//trim(energy_terms(i)%name), nf90_double, &
               [time], 'J m-1', trim(energy_terms(i)%meaning)//', per metre of thickness')
         end do
      end associate
   end subroutine define_history

   !> States of all blocks, now and then.
   subroutine define_frames(output, frame, block, axis, blocks)
      type(output_type), intent(inout) :: output  !< file being written
      integer, intent(in) :: frame, block, axis  !< netCDF dimensions
      type(blocks_type), intent(in) :: blocks  !< of the model
      integer :: coordinate, component

      associate (dataset => output%dataset)
         coordinate = define_dimension(dataset, 'coordinate', 6)
         component = define_dimension(dataset, 'component', 3)
         output%vertex = define_dimension(dataset, 'vertex', size(blocks%owner))
         output%frame_time = define(dataset, 'frame_time', nf90_double, [frame], 's', &
            'time of a frame')
         output%coordinates = define(dataset, 'block_coordinates', nf90_double, &
            [coordinate, block, frame], 'm m rad 1 1 1', &
            'x and y of the centroid, rotation, strains ex ey gxy in axes of the block')
         output%rates = define(dataset, 'block_rates', nf90_double, [coordinate, block, frame], &
            'm s-1, m s-1, rad s-1, s-1, s-1, s-1', 'rates of block_coordinates')
         output%stress = define(dataset, 'block_stress', nf90_double, [component, block, frame], &
            'Pa', 'sigma_x, sigma_y, tau_xy in axes of the model, tension positive')
         output%vertices = define(dataset, 'vertices', nf90_double, [axis, output%vertex, frame], &
            'm', 'places of the vertices')
      end associate
   end subroutine define_frames

   !> Contact states of all frames, one after the other.
   subroutine define_contacts(output, contacts)
      type(output_type), intent(inout) :: output  !< file being written
      integer, intent(in) :: contacts  !< number of contacts in all frames
      integer :: contact

      associate (dataset => output%dataset)
         contact = define_dimension(dataset, 'contact', contacts)
         output%contact_frame = define(dataset, 'contact_frame', nf90_int, [contact], '1', &
            'frame, from 0')
         output%contact(1) = define(dataset, 'contact_vertex', nf90_int, [contact], '1', &
            'vertex that touches, from 0')
         output%contact(2) = define(dataset, 'contact_edge', nf90_int, [contact], '1', &
            'edge touched, by its first vertex, from 0')
         output%contact(3) = define(dataset, 'contact_state', nf90_int, [contact], '1', &
            '0 open, 1 slide, 2 stick')
         output%contact(4) = define(dataset, 'contact_bonded', nf90_int, [contact], '1', &
            '1 while cohesion and tension hold')
         output%contact(5) = define(dataset, 'contact_gap', nf90_double, [contact], 'm', &
            'gap, negative is penetration')
         output%contact(6) = define(dataset, 'contact_normal_force', nf90_double, [contact], &
            'N m-1', 'compression positive')
         output%contact(7) = define(dataset, 'contact_shear_force', nf90_double, [contact], &
            'N m-1', 'resists slip')
         output%contact(8) = define(dataset, 'contact_stretch', nf90_double, [contact], 'm', &
            'elastic shear stretch')
      end associate
   end subroutine define_contacts

   !> Names that let xarray select points and blocks, and the shape of the model.
   subroutine define_names(output, simulation, point, axis)
      type(output_type), intent(inout) :: output  !< file being written
      type(simulation_type), intent(in) :: simulation  !< at its present time
      integer, intent(in) :: point, axis  !< netCDF dimensions
      integer :: letter

      associate (dataset => output%dataset)
         letter = define_dimension(dataset, 'letter', len(simulation%model%points%name))
         output%name = define(dataset, 'point', nf90_char, [letter, point], '1', &
            'name of a measured point')
         output%place = define(dataset, 'point_place', nf90_double, [axis, point], 'm', &
            'first place of a measured point')
         output%density = define(dataset, 'block_density', nf90_double, [output%block], 'kg m-3', &
            'density')
         output%modulus = define(dataset, 'block_shear_modulus', nf90_double, [output%block], &
            'Pa', 'shear modulus')
         output%owner = define(dataset, 'vertex_block', nf90_int, [output%vertex], '1', &
            'block of a vertex, from 0')
         if (allocated(dataset%error)) return
         call checked(dataset, nf90_put_att(dataset%id, output%name, '_Encoding', 'utf-8'), &
            'describe point')
      end associate
   end subroutine define_names

   !> Values that do not depend on time.
   subroutine write_constants(output, simulation)
      type(output_type), intent(inout) :: output  !< file being written
      type(simulation_type), intent(in) :: simulation  !< at its present time
      integer :: i

      associate (dataset => output%dataset, points => simulation%model%points, &
         owner => simulation%blocks%owner)
         do i = 1, size(points)
            call put(dataset, output%place, points(i)%place + simulation%model%origin, [1, i], &
               [2, 1])
            if (allocated(dataset%error)) return
            call checked(dataset, nf90_put_var(dataset%id, output%name, &
               null_padded(points(i)%name), [1, i], [len(points%name), 1]), 'write names')
         end do
         call put(dataset, output%owner, owner - 1, [1], [size(owner)])
         call put(dataset, output%density, simulation%blocks%mass/simulation%blocks%area, [1], &
            [simulation%blocks%n])
         call put(dataset, output%modulus, simulation%blocks%stiffness(3, 3, &
            :)/simulation%blocks%area, [1], [simulation%blocks%n])
      end associate
   end subroutine write_constants

   !> A text whose end readers can see.
   pure function null_padded(text) result(padded)
      character(len=*), intent(in) :: text  !< to pad
      character(len=len(text)) :: padded

      padded = trim(text)//repeat(c_null_char, len(text) - len_trim(text))
   end function null_padded

   !> All rows of the journal, in its order.
   subroutine copy_rows(output, journal, simulation, error)
      type(output_type), intent(inout) :: output  !< file being written
      type(journal_type), intent(in) :: journal  !< of the run
      type(simulation_type), intent(in) :: simulation  !< at its present time
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(reader_type) :: reader
      real(wp), allocatable :: sample(:), frame(:)
      integer :: kind, contacts

      allocate (sample(sample_size(simulation)))
      allocate (output%sample(buffered, size(sample)))
      call open_reader(reader, journal, error)
      do while (.not. (allocated(error) .or. allocated(output%dataset%error)))
         call read_row(reader, kind, contacts, error)
         if (allocated(error) .or. kind == 0) exit
         if (kind == row_sample) then
            if (output%waiting == buffered) call put_samples(output)
            output%waiting = output%waiting + 1
            output%samples = output%samples + 1
            call read_numbers(reader, sample, error)
            output%sample(output%waiting, :) = sample
         else
            if (allocated(frame)) deallocate (frame)
            allocate (frame(frame_size(simulation, contacts)))
            call read_numbers(reader, frame, error)
            call put_frame(output, frame, simulation%blocks%n, size(simulation%blocks%owner), &
               contacts)
         end if
      end do
      if (.not. allocated(error)) call put_samples(output)
      call close_reader(reader, error)
   end subroutine copy_rows

   !> Write the buffered samples.
   subroutine put_samples(output)
      type(output_type), intent(inout) :: output  !< file being written
      integer :: first, n, i, kind, at

      n = output%waiting
      first = output%samples - n + 1
      output%waiting = 0
      associate (dataset => output%dataset, sample => output%sample, width => 2*output%points)
         call put(dataset, output%time, sample(:n, 1), [first], [n])
         call put(dataset, output%time_step, sample(:n, 2), [first], [n])
         call put(dataset, output%iterations, sample(:n, 3), [first], [n])
         call put(dataset, output%stage, sample(:n, 4), [first], [n])
         do i = 1, size(energy_terms)
            call put(dataset, output%energy(i), sample(:n, 4 + i), [first], [n])
         end do
         if (width == 0) return
         do kind = 1, 3
            at = sample_head + (kind - 1)*width
            call put(dataset, output%motion(kind), &
               reshape(transpose(sample(:n, at + 1:at + width)), [width*n]), [1, 1, first], &
               [2, output%points, n])
         end do
      end associate
   end subroutine put_samples

   !> Write a frame: all blocks and contacts.
   subroutine put_frame(output, frame, n, vertices, contacts)
      type(output_type), intent(inout) :: output  !< file being written
      real(wp), contiguous, intent(in) :: frame(:)  !< [`frame_size`]
      integer, intent(in) :: n, vertices, contacts  !< numbers of blocks, vertices, contacts
      integer :: f, at

      output%frames = output%frames + 1
      f = output%frames
      call put(output%dataset, output%frame_time, frame(1:1), [f], [1])
      at = 1
      call put_part(output%coordinates, 6, n)
      call put_part(output%rates, 6, n)
      call put_part(output%stress, 3, n)
      call put_part(output%vertices, 2, vertices)
      if (contacts > 0) call put_contacts(output, frame(at + 1:), contacts)

   contains

      !> The next numbers of the frame, as a variable.
      subroutine put_part(variable, width, count)
         integer, intent(in) :: variable, width, count  !< netCDF variable; its shape in a frame

         call put(output%dataset, variable, frame(at + 1:at + width*count), [1, 1, f], &
            [width, count, 1])
         at = at + width*count
      end subroutine put_part

   end subroutine put_frame

   !> The columns of the contacts of a frame: the first ones are whole numbers.
   subroutine put_contacts(output, columns, n)
      type(output_type), intent(inout) :: output  !< file being written
      integer, intent(in) :: n  !< number of contacts
      real(wp), intent(in) :: columns(n, contact_columns)  !< as of `take_contacts`
      integer, parameter :: whole = 4
      integer :: i, at(1)

      at = output%contacts + 1
      call put(output%dataset, output%contact_frame, spread(output%frames - 1, 1, n), at, [n])
      do i = 1, contact_columns
         if (i <= whole) then
            call put(output%dataset, output%contact(i), nint(columns(:, i)), at, [n])
         else
            call put(output%dataset, output%contact(i), columns(:, i), at, [n])
         end if
      end do
      output%contacts = output%contacts + n
   end subroutine put_contacts

end module dda_output_file
