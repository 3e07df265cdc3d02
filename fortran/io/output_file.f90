!> The output of a run: a netCDF-4 file that xarray opens as it is.
!>
!> It grows under the name FILE.partial and gets its own name when the run is complete.
module dda_output_file
   use, intrinsic :: iso_c_binding, only: c_null_char
   use, intrinsic :: iso_fortran_env, only: compiler_options, compiler_version
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type, stress_of
   use dda_contact, only: contacts_type
   use dda_energy, only: energy_terms, energy_names, energy_values
   use dda_errors, only: error_type, error_file, fail
   use dda_file_system, only: rename_file, same_file, in_use, is_folder, folder_of
   use dda_measure, only: measure_point
   use dda_model, only: model_type
   use dda_netcdf_calls, only: dataset_type, checked, define, define_dimension, describe, put
   use dda_simulation, only: simulation_type, summary
   use dda_text, only: quoted
   use dda_version, only: version
   use netcdf, only: nf90_create, nf90_close, nf90_enddef, nf90_netcdf4, nf90_clobber, nf90_unlimited, &
      nf90_double, nf90_int, nf90_char, nf90_put_att, nf90_put_var
   implicit none
   private
   public :: output_type, open_output, note_step, record_sample, record_frame, finish_output, abandon_output

   integer, parameter :: buffered = 1024                 !< samples between writes
   integer, parameter :: per_sample = 2 + energy_terms   !< Δt, iterations, energies
   character(len=*), parameter :: partial = '.partial'

   !> An output file that is being written; the integers without comment are netCDF variables.
   type :: output_type
      character(len=:), allocatable :: file       !< final name
      type(dataset_type) :: dataset
      integer :: samples = 0                      !< written and buffered
      integer :: waiting = 0                      !< buffered
      integer :: frames = 0
      integer :: contacts = 0                     !< contact states written
      integer :: most_iterations = 0              !< since the last sample
      integer :: time, time_step, iterations, displacement, velocity, acceleration
      integer :: energy(energy_terms)
      integer :: frame_time, coordinates, rates, stress, vertices, vertex, block, name, place, owner
      integer :: density, modulus
      integer :: contact(9)
      real(wp), allocatable :: time_buffer(:)     !< [buffered]
      real(wp), allocatable :: sample(:,:)        !< [buffered, per_sample]
      real(wp), allocatable :: point(:,:,:,:)     !< [2, points, buffered, 3] displacement, velocity, acceleration
   end type output_type

contains

   !> Create the file and write what does not change.
   subroutine open_output(output, simulation, file, error)
      type(output_type), intent(out) :: output
      type(simulation_type), intent(in) :: simulation
      character(len=*), intent(in) :: file
      type(error_type), allocatable, intent(out) :: error
      integer :: points

      output%file = file
      output%dataset%file = file//partial
      points = size(simulation%model%points)
      allocate (output%time_buffer(buffered), output%sample(buffered, per_sample), output%point(2, points, buffered, 3))
      call check_target(file, simulation%model, error)
      if (allocated(error)) return
      call checked(output%dataset, nf90_create(output%dataset%file, ior(nf90_netcdf4, nf90_clobber), output%dataset%id), &
         'create the file')
      call define_file(output, simulation)
      if (allocated(output%dataset%error)) error = output%dataset%error
   end subroutine open_output

   !> The output must not be a folder, the input or a record, and nobody else may be writing it.
   subroutine check_target(file, model, error)
      character(len=*), intent(in) :: file
      type(model_type), intent(in) :: model
      type(error_type), allocatable, intent(out) :: error
      logical :: folder
      integer :: i

      folder = is_folder(file)
      if (file == '' .or. folder) then
         call fail(error, error_file, 'the output '//quoted(file)//' is a folder, not a file name')
      else if (.not. is_folder(folder_of(file))) then
         call fail(error, error_file, file//': the folder '//folder_of(file)//' does not exist')
      else if (same_file(file, model%file)) then
         call fail(error, error_file, 'the output '//file//' would replace the input')
      else if (in_use(file//partial)) then
         call fail(error, error_file, file//partial//' is being written by another run')
      end if
      do i = 1, size(model%motions)
         if (allocated(error)) return
         if (same_file(file, model%motions(i)%file)) call fail(error, error_file, &
            'the output '//file//' would replace the record of motion '//trim(model%motions(i)%name))
      end do
   end subroutine check_target

   subroutine define_file(output, simulation)
      type(output_type), intent(inout) :: output
      type(simulation_type), intent(in) :: simulation
      integer :: time, point, axis, frame

      associate (dataset => output%dataset)
         call describe_run(dataset, simulation)
         time = define_dimension(dataset, 'time', nf90_unlimited)
         point = define_dimension(dataset, 'point', max(1, size(simulation%model%points)))
         axis = define_dimension(dataset, 'axis', 2)
         frame = define_dimension(dataset, 'frame', nf90_unlimited)
         output%block = define_dimension(dataset, 'block', simulation%blocks%n)
         call define_history(output, time, point, axis, size(simulation%model%points))
         call define_frames(output, frame, output%block, axis, simulation%blocks)
         call define_contacts(output)
         call define_names(output, simulation, point, axis)
         if (.not. allocated(dataset%error)) call checked(dataset, nf90_enddef(dataset%id), 'end the definitions')
      end associate
      call write_constants(output, simulation)
   end subroutine define_file

   !> All that is needed to repeat the run.
   subroutine describe_run(dataset, simulation)
      type(dataset_type), intent(inout) :: dataset
      type(simulation_type), intent(in) :: simulation
      integer :: i
      character(len=:), allocatable :: motions

      motions = ''
      do i = 1, size(simulation%model%motions)
         if (i > 1) motions = motions//new_line('a')
         motions = motions//simulation%model%motions(i)%source
      end do
      call describe(dataset, 'title', simulation%model%title)
      call describe(dataset, 'source', 'sitedda '//version)
      call describe(dataset, 'compiler', compiler_version()//' '//compiler_options())
      call describe(dataset, 'input_file', simulation%model%file)
      call describe(dataset, 'input_text', simulation%model%text)
      call describe(dataset, 'motions', motions)
      call describe(dataset, 'complete', 'no')
   end subroutine describe_run

   !> Samples of measured points and energies.
   subroutine define_history(output, time, point, axis, points)
      type(output_type), intent(inout) :: output
      integer, intent(in) :: time, point, axis, points
      character(len=16) :: names(energy_terms)
      integer :: i, chunks(3)

      chunks = [2, max(1, points), buffered]
      names = energy_names()
      associate (dataset => output%dataset)
         output%time = define(dataset, 'time', nf90_double, [time], 's', 'time', [buffered])
         output%displacement = define(dataset, 'displacement', nf90_double, [axis, point, time], 'm', &
            'displacement of a measured point', chunks)
         output%velocity = define(dataset, 'velocity', nf90_double, [axis, point, time], 'm s-1', &
            'velocity of a measured point', chunks)
         output%acceleration = define(dataset, 'acceleration', nf90_double, [axis, point, time], 'm s-2', &
            'acceleration of a measured point', chunks)
         output%time_step = define(dataset, 'time_step', nf90_double, [time], 's', 'time step that led here', [buffered])
         output%iterations = define(dataset, 'iterations', nf90_double, [time], '1', &
            'most open-close iterations of a step since the last sample', [buffered])
         do i = 1, energy_terms
            output%energy(i) = define(dataset, 'energy_'//trim(names(i)), nf90_double, [time], 'J m-1', &
               trim(names(i))//' energy per metre of thickness', [buffered])
         end do
      end associate
   end subroutine define_history

   !> States of all blocks, now and then.
   subroutine define_frames(output, frame, block, axis, blocks)
      type(output_type), intent(inout) :: output
      integer, intent(in) :: frame, block, axis
      type(blocks_type), intent(in) :: blocks
      integer :: coordinate, component

      associate (dataset => output%dataset)
         coordinate = define_dimension(dataset, 'coordinate', 6)
         component = define_dimension(dataset, 'component', 3)
         output%vertex = define_dimension(dataset, 'vertex', size(blocks%owner))
         output%frame_time = define(dataset, 'frame_time', nf90_double, [frame], 's', 'time of a frame')
         output%coordinates = define(dataset, 'block_coordinates', nf90_double, [coordinate, block, frame], &
            'm m rad 1 1 1', 'x and y of the centroid, rotation, strains ex ey gxy in axes of the block')
         output%rates = define(dataset, 'block_rates', nf90_double, [coordinate, block, frame], &
            'm s-1, m s-1, rad s-1, s-1, s-1, s-1', 'rates of block_coordinates')
         output%stress = define(dataset, 'block_stress', nf90_double, [component, block, frame], 'Pa', &
            'sigma_x, sigma_y, tau_xy in axes of the model, tension positive')
         output%vertices = define(dataset, 'vertices', nf90_double, [axis, output%vertex, frame], 'm', 'places of the vertices')
      end associate
   end subroutine define_frames

   !> Contact states of all frames, one after the other.
   subroutine define_contacts(output)
      type(output_type), intent(inout) :: output
      integer :: contact

      associate (dataset => output%dataset)
         contact = define_dimension(dataset, 'contact', nf90_unlimited)
         output%contact(1) = define(dataset, 'contact_frame', nf90_int, [contact], '1', 'frame, from 0')
         output%contact(2) = define(dataset, 'contact_vertex', nf90_int, [contact], '1', 'vertex that touches, from 0')
         output%contact(3) = define(dataset, 'contact_edge', nf90_int, [contact], '1', &
            'edge touched, by its first vertex, from 0')
         output%contact(4) = define(dataset, 'contact_state', nf90_int, [contact], '1', '0 open, 1 slide, 2 stick')
         output%contact(5) = define(dataset, 'contact_bonded', nf90_int, [contact], '1', '1 while cohesion and tension hold')
         output%contact(6) = define(dataset, 'contact_gap', nf90_double, [contact], 'm', 'gap, negative is penetration')
         output%contact(7) = define(dataset, 'contact_normal_force', nf90_double, [contact], 'N m-1', 'compression positive')
         output%contact(8) = define(dataset, 'contact_shear_force', nf90_double, [contact], 'N m-1', 'resists slip')
         output%contact(9) = define(dataset, 'contact_stretch', nf90_double, [contact], 'm', 'elastic shear stretch')
      end associate
   end subroutine define_contacts

   !> Names that let xarray select points and blocks, and the shape of the model.
   subroutine define_names(output, simulation, point, axis)
      type(output_type), intent(inout) :: output
      type(simulation_type), intent(in) :: simulation
      integer, intent(in) :: point, axis
      integer :: letter

      associate (dataset => output%dataset)
         letter = define_dimension(dataset, 'letter', len(simulation%model%points%name))
         output%name = define(dataset, 'point', nf90_char, [letter, point], '1', 'name of a measured point')
         output%place = define(dataset, 'point_place', nf90_double, [axis, point], 'm', 'first place of a measured point')
         output%density = define(dataset, 'block_density', nf90_double, [output%block], 'kg m-3', 'density')
         output%modulus = define(dataset, 'block_shear_modulus', nf90_double, [output%block], 'Pa', 'shear modulus')
         output%owner = define(dataset, 'vertex_block', nf90_int, [output%vertex], '1', 'block of a vertex, from 0')
         if (allocated(dataset%error)) return
         call checked(dataset, nf90_put_att(dataset%id, output%name, '_Encoding', 'utf-8'), 'describe point')
      end associate
   end subroutine define_names

   subroutine write_constants(output, simulation)
      type(output_type), intent(inout) :: output
      type(simulation_type), intent(in) :: simulation
      integer :: i

      associate (dataset => output%dataset, points => simulation%model%points, owner => simulation%blocks%owner)
         do i = 1, size(points)
            call put(dataset, output%place, points(i)%place + simulation%model%origin, [1, i], [2, 1])
            if (allocated(dataset%error)) return
            call checked(dataset, nf90_put_var(dataset%id, output%name, null_padded(points(i)%name), [1, i], &
               [len(points%name), 1]), 'write names')
         end do
         call put(dataset, output%owner, owner - 1, [1], [size(owner)])
         call put(dataset, output%density, simulation%blocks%mass/simulation%blocks%area, [1], [simulation%blocks%n])
         call put(dataset, output%modulus, simulation%blocks%stiffness(3, 3, :)/simulation%blocks%area, [1], &
            [simulation%blocks%n])
      end associate
   end subroutine write_constants

   !> A text whose end readers can see.
   pure function null_padded(text) result(padded)
      character(len=*), intent(in) :: text
      character(len=len(text)) :: padded

      padded = trim(text)//repeat(c_null_char, len(text) - len_trim(text))
   end function null_padded

   !> Take a sample of points, energies and step control; write when the buffer is full.
   subroutine record_sample(output, simulation, error)
      type(output_type), intent(inout) :: output
      type(simulation_type), intent(in) :: simulation
      type(error_type), allocatable, intent(out) :: error
      integer :: i, k

      k = output%waiting + 1
      output%time_buffer(k) = simulation%time
      output%sample(k, 1) = simulation%last_time_step
      output%sample(k, 2) = real(output%most_iterations, wp)
      output%sample(k, 3:) = energy_values(simulation%energy)
      do i = 1, size(simulation%model%points)
         call measure_point(simulation%blocks, simulation%model%points(i), output%point(:, i, k, 1), &
            output%point(:, i, k, 2), output%point(:, i, k, 3))
      end do
      output%most_iterations = 0
      output%waiting = k
      output%samples = output%samples + 1
      if (k == buffered) call flush_samples(output)
      call move_error(output, error)
   end subroutine record_sample

   !> Note how hard a step was that is not sampled itself.
   pure subroutine note_step(output, simulation)
      type(output_type), intent(inout) :: output
      type(simulation_type), intent(in) :: simulation

      output%most_iterations = max(output%most_iterations, simulation%iteration%iterations)
   end subroutine note_step

   !> Write the buffered samples.
   subroutine flush_samples(output)
      type(output_type), intent(inout) :: output
      integer :: first, n, i, points

      n = output%waiting
      if (n == 0) return
      first = output%samples - n + 1
      points = size(output%point, 2)
      associate (dataset => output%dataset)
         call put(dataset, output%time, output%time_buffer(:n), [first], [n])
         call put(dataset, output%time_step, output%sample(:n, 1), [first], [n])
         call put(dataset, output%iterations, output%sample(:n, 2), [first], [n])
         do i = 1, energy_terms
            call put(dataset, output%energy(i), output%sample(:n, 2 + i), [first], [n])
         end do
         if (points > 0) then
            call put_points(output, output%displacement, 1, first, n)
            call put_points(output, output%velocity, 2, first, n)
            call put_points(output, output%acceleration, 3, first, n)
         end if
      end associate
      output%waiting = 0
   end subroutine flush_samples

   subroutine put_points(output, variable, which, first, n)
      type(output_type), intent(inout) :: output
      integer, intent(in) :: variable, which, first, n

      call put(output%dataset, variable, reshape(output%point(:, :, :n, which), [size(output%point(:, :, :n, which))]), &
         [1, 1, first], [2, size(output%point, 2), n])
   end subroutine put_points

   !> Take a frame: all blocks and contacts.
   subroutine record_frame(output, simulation, error)
      type(output_type), intent(inout) :: output
      type(simulation_type), intent(in) :: simulation
      type(error_type), allocatable, intent(out) :: error
      real(wp), allocatable :: values(:,:)
      integer :: b, f, n

      output%frames = output%frames + 1
      f = output%frames
      n = simulation%blocks%n
      associate (dataset => output%dataset, blocks => simulation%blocks, origin => simulation%model%origin)
         call put(dataset, output%frame_time, [simulation%time], [f], [1])
         values = blocks%position
         values(1:2, :) = values(1:2, :) + spread(origin, 2, n)
         call put(dataset, output%coordinates, reshape(values, [6*n]), [1, 1, f], [6, n, 1])
         call put(dataset, output%rates, reshape(blocks%velocity, [6*n]), [1, 1, f], [6, n, 1])
         values = blocks%vertex + spread(origin, 2, size(blocks%owner))
         call put(dataset, output%vertices, reshape(values, [size(values)]), [1, 1, f], [2, size(blocks%owner), 1])
         values = reshape([(stress_of(blocks, b), b=1, n)], [3, n])
         call put(dataset, output%stress, reshape(values, [3*n]), [1, 1, f], [3, n, 1])
      end associate
      call record_contacts(output, simulation%contacts(simulation%now))
      call move_error(output, error)
   end subroutine record_frame

   subroutine record_contacts(output, contacts)
      type(output_type), intent(inout) :: output
      type(contacts_type), intent(in) :: contacts
      integer :: n, at(1)

      n = contacts%n
      at = output%contacts + 1
      associate (dataset => output%dataset)
         call put(dataset, output%contact(1), spread(output%frames - 1, 1, n), at, [n])
         call put(dataset, output%contact(2), contacts%vertex(:n) - 1, at, [n])
         call put(dataset, output%contact(3), contacts%edge(:n) - 1, at, [n])
         call put(dataset, output%contact(4), contacts%state(:n), at, [n])
         call put(dataset, output%contact(5), merge(1, 0, contacts%bonded(:n)), at, [n])
         call put(dataset, output%contact(6), contacts%new_gap(:n), at, [n])
         call put(dataset, output%contact(7), contacts%normal_force(:n), at, [n])
         call put(dataset, output%contact(8), contacts%shear_force(:n), at, [n])
         call put(dataset, output%contact(9), contacts%stretch(:n), at, [n])
      end associate
      output%contacts = output%contacts + n
   end subroutine record_contacts

   !> Close a complete output and give it its name.
   subroutine finish_output(output, simulation, error)
      type(output_type), intent(inout) :: output
      type(simulation_type), intent(in) :: simulation
      type(error_type), allocatable, intent(out) :: error

      call close_output(output, simulation, 'yes', error)
      if (allocated(error)) return
      if (.not. rename_file(output%dataset%file, output%file)) call fail(error, error_file, &
         output%dataset%file//' cannot be renamed to '//output%file)
   end subroutine finish_output

   !> Close an output that stays incomplete, under its partial name.
   subroutine abandon_output(output, simulation, error)
      type(output_type), intent(inout) :: output
      type(simulation_type), intent(in) :: simulation
      type(error_type), allocatable, intent(out) :: error

      call close_output(output, simulation, 'no', error)
   end subroutine abandon_output

   subroutine close_output(output, simulation, complete, error)
      type(output_type), intent(inout) :: output
      type(simulation_type), intent(in) :: simulation
      character(len=*), intent(in) :: complete
      type(error_type), allocatable, intent(out) :: error

      if (output%dataset%id < 0) return
      call flush_samples(output)
      call describe(output%dataset, 'step_control', summary(simulation))
      call describe(output%dataset, 'complete', complete)
      call checked(output%dataset, nf90_close(output%dataset%id), 'close the file')
      output%dataset%id = -1
      call move_error(output, error)
   end subroutine close_output

   subroutine move_error(output, error)
      type(output_type), intent(inout) :: output
      type(error_type), allocatable, intent(out) :: error

      if (allocated(output%dataset%error)) error = output%dataset%error
   end subroutine move_error

end module dda_output_file
