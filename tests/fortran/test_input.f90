! SPDX-License-Identifier: GPL-3.0-or-later
!> The input: every group arrives in the model, and every mistake is refused by file, group, line
!> and value.
module test_input
   use, intrinsic :: ieee_exceptions, only: ieee_all, ieee_get_halting_mode, ieee_set_halting_mode
   use dda_kinds, only: wp
   use dda_errors, only: error_file, error_input
   use dda_input, only: read_model, read_model_file
   use dda_input_catalogue, only: find_variable
   use dda_input_boundaries, only: boundary_kinds
   use dda_input_variable, only: variable_type
   use dda_joint_laws, only: law_slot_type, create_joint_law
   use dda_material, only: joint_type
   use dda_record_format, only: known_formats
   use dda_record_type, only: known_units
   use dda_scheme, only: integration_names
   use dda_solver_table, only: solver_names
   use dda_model, only: contact_distance, default_stiffness, half_size, model_type
   use dda_settings, only: amplification_type
   use dda_text, only: joined, to_text
   use models, only: rock
   use record_files, only: remove_scratch, scratch_name, write_scratch
   use testing, only: check, check_close, check_fails, check_no_error, error
   implicit none

   character, parameter :: newline = achar(10)
   character(len=*), parameter :: control = '&control time_step = 1.0e-3 steps = 10 /'//newline
   character(len=*), parameter :: joint = '&joint friction_angle = 30.0 /'//newline
   character(len=*), parameter :: square = '&block vertices = 0 0 1 0 1 1 0 1 /'//newline
   ! groups on lines 1 to 4
   character(len=*), parameter :: complete_input = control//rock//newline//joint//square
   type(model_type) :: model

contains

   !> The words of the schema are the words of the engine, in the same order.
   subroutine published_words()
      type(law_slot_type) :: slot
      type(joint_type) :: joint
      type(variable_type) :: law
      integer :: first, last
      logical :: halting(size(ieee_all))

      call check(words_of('control', 'solver') == listed(solver_names), 'solvers')
      call check(words_of('control', 'integration') == listed(integration_names), 'schemes')
      call check(words_of('stage', 'integration') == listed(integration_names), 'stages')
      call check(words_of('boundary', 'kind') == listed(boundary_kinds%name), 'boundaries')
      call check(words_of('motion', 'format') == known_formats, 'formats')
      call check(words_of('motion', 'unit') == known_units, 'units')
      law = find_variable('joint', 'law')
      call ieee_get_halting_mode(ieee_all, halting)
      call ieee_set_halting_mode(ieee_all, .false.)  ! values of the joint are undefined
      last = 0
      do
         first = last + index(law%allowed(last + 1:), "'")
         if (first == last) exit
         last = first + index(law%allowed(first + 1:), "'")
         joint%law = law%allowed(first + 1:last - 1)
         call create_joint_law(slot, joint, 1.0_wp, 1.0_wp)
         call check(allocated(slot%law), 'law '//trim(joint%law))
         if (allocated(slot%law)) deallocate (slot%law)
      end do
      call ieee_set_halting_mode(ieee_all, halting)
   end subroutine published_words

   !> Words that the schema allows.
   function words_of(group, name) result(text)
      character(len=*), intent(in) :: group, name
      character(len=:), allocatable :: text
      type(variable_type) :: variable

      variable = find_variable(group, name)
      text = trim(variable%allowed)
   end function words_of

   !> Names in quotes, with commas between.
   function listed(names) result(text)
      character(len=*), intent(in) :: names(:)
      character(len=:), allocatable :: text

      text = "'"//joined(names, "', '")//"'"
   end function listed

   subroutine accept(model, text)
      type(model_type), intent(out) :: model
      character(len=*), intent(in) :: text

      call read_model(model, 'folder/in.nml', text, error)
      call check_no_error(error, 'is read')
   end subroutine accept

   !> The message names the file, and each of up to three things.
   subroutine refuse(text, first, second, third)
      character(len=*), intent(in) :: text, first
      character(len=*), intent(in), optional :: second, third
      type(model_type) :: model

      call read_model(model, 'folder/in.nml', text, error)
      call check_fails(error, 'folder/in.nml')
      call check_fails(error, first)
      if (present(second)) call check_fails(error, second)
      if (present(third)) call check_fails(error, third)
      if (allocated(error)) call check(error%kind == error_input, 'its kind')
   end subroutine refuse

   subroutine run_control_contact_output()
      call accept(model, '&run title = ''A title'' / &control time_step = 0.01 duration = 1.0 '// &
         'least_time_step = 1.0e-5 dynamic_factor = 0.9 max_displacement_ratio = 0.02 '// &
         'gravity = 1.0 -9.81 time_step_control = ''adaptive'''// &
         ' analysis = ''plane_strain'' solver = ''direct'' / &contact normal_stiffness = 2.0e9 '// &
         'shear_ratio = 3.0 fixed_point_ratio = 50.0 max_iterations = 77 force_tolerance = '// &
         '1.0e-8 / &output file = ''o.nc'' history_interval = 4 block_interval = 9 / '//rock// &
         joint//square)
      call check(model%title == 'A title', 'title')
      associate (c => model%control)
         call check_close([c%time_step, c%least_time_step, c%dynamic_factor, &
            c%max_displacement_ratio, c%gravity], [0.01_wp, 1.0e-5_wp, 0.9_wp, 0.02_wp, 1.0_wp, &
            -9.81_wp], 'numbers of control')
         call check(c%steps == 100 .and. c%adaptive .and. c%plane_strain &
            .and. c%solver == 'direct', 'words of control')
      end associate
      associate (c => model%contact)
         call check_close([c%normal_stiffness, c%shear_ratio, c%fixed_point_ratio, &
            c%force_tolerance], [2.0e9_wp, 3.0_wp, 50.0_wp, 1.0e-8_wp], 'contact')
         call check(c%max_iterations == 77, 'iterations')
      end associate
      call check(model%output%file == 'o.nc' .and. model%output%history_interval == 4 .and. &
         model%output%block_interval == 9, 'output')
   end subroutine run_control_contact_output

   subroutine defaults()
      call accept(model, complete_input)
      call check(.not. model%control%adaptive .and. .not. model%control%plane_strain, &
         'fixed step, plane stress')
      call check_close(model%control%gravity, [0.0_wp, 0.0_wp], 'no gravity')
      call check_close(model%contact%normal_stiffness, 40.0_wp*5.0e9_wp, '40 E', &
         relative=1.0e-15_wp)
      call check_close(default_stiffness(model%materials), 40.0_wp*5.0e9_wp, '40 E by itself', &
         relative=1.0e-15_wp)
      call check_close(model%contact%shear_ratio, 2.5_wp, 'k_n / k_s')
      call check(model%output%file == 'in.nc', 'output name: '//model%output%file)
      call check_close(half_size(model%blocks), 0.5_wp, 'half size')
      call check_close(contact_distance(model), 2.5_wp*0.01_wp*0.5_wp, 'contact distance', &
         relative=1.0e-15_wp)
   end subroutine defaults

   !> The defaults in the catalogue are the defaults of the reader.
   subroutine published_defaults()
      type(amplification_type) :: amplification

      call accept(model, complete_input)
      associate (control => model%control, contact => model%contact, output => model%output)
         call published('control', 'dynamic_factor', control%dynamic_factor)
         call published('control', 'max_displacement_ratio', control%max_displacement_ratio)
         call published('contact', 'shear_ratio', contact%shear_ratio)
         call published('contact', 'fixed_point_ratio', contact%fixed_point_ratio)
         call published('contact', 'penetration_tolerance', contact%penetration_tolerance)
         call published('contact', 'max_iterations', real(contact%max_iterations, wp))
         call published('output', 'history_interval', real(output%history_interval, wp))
         call published('output', 'block_interval', real(output%block_interval, wp))
         call published('output', 'checkpoint_interval', real(output%checkpoint_interval, wp))
         call published('output', 'checkpoint_minutes', output%checkpoint_minutes)
         call published('amplification', 'padding', real(amplification%padding, wp))
         call published('contact', 'force_tolerance', contact%force_tolerance)
      end associate
   end subroutine published_defaults

   !> The published default begins with a number.
   subroutine published(group, name, value)
      character(len=*), intent(in) :: group, name
      real(wp), intent(in) :: value
      type(variable_type) :: variable

      variable = find_variable(group, name)
      call check_close(variable%preset, value, name//' = '//to_text(value))
   end subroutine published

   subroutine materials_and_joints()
      call accept(model, control// &
         '&material name = ''a'' density = 1000.0 young_modulus = 1.0e9 poisson_ratio = 0.2'// &
         ' initial_stress = 1.0 2.0 3.0 initial_velocity = 4.0 5.0 6.0 /'//rock// &
         '&joint name = ''j'' friction_angle = 10.0 cohesion = 11.0 tensile_strength = 12.0 /'// &
         '&joint name = ''k'' friction_angle = 20.0 /'//square// &
         '&block name = ''b'' material = ''rock'' joint = ''k'' vertices = 2 0 3 0 3 1 /')
      call check(size(model%materials) == 2 .and. size(model%joints) == 2, 'two of each')
      associate (m => model%materials(1))
         call check_close([m%density, m%young_modulus, m%poisson_ratio, m%initial_stress, &
            m%initial_velocity], [1000.0_wp, 1.0e9_wp, 0.2_wp, 1.0_wp, 2.0_wp, 3.0_wp, 4.0_wp, &
            5.0_wp, 6.0_wp], 'material')
      end associate
      associate (j => model%joints(1))
         call check_close([j%friction_angle, j%cohesion, j%tensile_strength], &
            [10.0_wp, 11.0_wp, 12.0_wp], 'joint')
      end associate
      call check(all(model%blocks%material == [1, 2]) .and. &
         all(model%blocks%joint == [1, 1, 1, 1, 2, 2, 2]), 'named or the first')
      call check(.not. any(model%blocks%mixed), 'one joint a block')
      call check(model%block_names(2) == 'b', 'name of a block')
      call check_close(model%blocks%velocity(1:3, 1), [4.0_wp, 5.0_wp, 6.0_wp], 'first velocity')
      call check_close(model%blocks%mass, [1000.0_wp, 1250.0_wp], 'masses', relative=1.0e-14_wp)
   end subroutine materials_and_joints

   !> One joint per edge; omitted and blank ones are the joint of the block.
   subroutine edge_joints()
      character(len=*), parameter :: three = control//rock// &
         '&joint name = ''a'' friction_angle '// &
         '= 10.0 / &joint name = ''b'' friction_angle = 20.0 / &joint name = ''c'' '// &
         'friction_angle = 30.0 / &block vertices = 0 0 1 0 1 1 0 1 '

      call accept(model, three//'joint = ''b'' edge_joints = ''c'', '''', ''a'' /'// &
         '&block vertices = 2 0 3 0 3 1 edge_joints = , , ''b'' /'// &
         '&layers joint = ''c'' bottom = 2.0 width = 1.0 thickness = 1.0 /'// &
         '&block vertices = 5 0 6 0 6 1 edge_joints = 3*''c'' /')
      call check(all(model%blocks%joint == [3, 2, 1, 2, 1, 1, 2, 3, 3, 3, 3, 3, 3, 3]), 'joints')
      call check(all(model%blocks%mixed .eqv. [.true., .true., .false., .false.]), 'mixed')
   end subroutine edge_joints

   subroutine generators()
      call accept(model, control//rock//joint// &
         '&layers width = 4.0 thickness = 0.5 count = 3 left = 1.0 bottom = 2.0 /'// &
         '&drums centre = 20.0 width = 1.0 top_width = 0.8 height = 0.5 count = 4 /'// &
         '&wall left = 30.0 brick_length = 0.6 brick_height = 0.3 bricks = 3 courses = 2 name '// &
         '= ''w'' /')
      call check(model%blocks%n == 3 + 4 + 7, 'blocks')
      call check_close(sum(model%blocks%area), 3*4.0_wp*0.5_wp + 0.9_wp*2.0_wp + 6*0.18_wp, &
         'area', relative=1.0e-13_wp)
      call check(model%block_names(1) == 'layer_1' .and. model%block_names(7) == 'drum_4' .and. &
         model%block_names(14) == 'w_7', 'names')
   end subroutine generators

   subroutine points()
      type(model_type) :: model

      call accept(model, complete_input//'&fixed_point x = 0.25 y = 0.5 direction = ''x'' /'// &
         '&measured_point name = ''top'' x = 1.0 y = 1.0 block = ''1'' /'// &
         '&measured_point name = ''foot'' x = 0.5 y = 0.0 /'// &
         '&load x = 0.5 y = 1.0 time = 0.0 1.0 2.0 force_y = 3.0 4.0 5.0 /'// &
         '&amplification surface = ''top'' base = ''foot'' direction = ''y'' lowest = 1.0 '// &
         'highest = 9.0 padding = 4 /')
      associate (p => model%fixed_points(1))
      call check(all(p%fixed_along .eqv. [.true., .false.]) .and. p%block == 1, 'block, fixed in x')
         call check_close(p%reference, [-0.25_wp, 0.0_wp], 'where', absolute=1.0e-15_wp)
      end associate
      call check_close(model%points(1)%reference, [0.5_wp, 0.5_wp], 'a corner', absolute=1.0e-15_wp)
      associate (load => model%loads(1))
         call check_close(load%time, [0.0_wp, 1.0_wp, 2.0_wp], 'times')
         call check_close(load%force, reshape([0, 3, 0, 4, 0, 5]*1.0_wp, [2, 3]), 'forces')
      end associate
      associate (a => model%amplifications(1))
         call check(a%surface == 1 .and. a%base == 2 .and. a%axis == 2 .and. a%padding == 4, &
            'amplification')
      end associate
   end subroutine points

   subroutine motions()
      call accept(model, '&control time_step = 1.0e-3 steps = 10 base_motion_y = ''q'' /'//rock// &
         joint//square//'&motion name = ''p'' quantity = ''displacement'' time_step = 0.5 '// &
         'values = 0.0 1.0 3.0 2.0 /&motion name = ''q'' quantity = ''velocity'' time_step '// &
         '= 0.1 values = 0.0 1.0 0.0 scale = 2.0 /'// &
         '&fixed_point x = 0.5 y = 0.5 motion_x = ''q'' motion_y = ''p'' /')
      call check(all(model%control%base_motion == [0, 2]), 'of the base')
      call check(all(model%fixed_points(1)%motion == [2, 1]), 'of a point')
      call check_close(model%motions(1)%curve%displacement, [0.0_wp, 1.0_wp, 3.0_wp, 2.0_wp], &
         'samples')
      call check_close(model%motions(2)%curve%velocity, [0.0_wp, 2.0_wp, 0.0_wp], 'scaled', &
         absolute=1.0e-15_wp)
      call check(index(model%motions(2)%source, 'velocity') > 0, 'source: '// &
         model%motions(2)%source)
   end subroutine motions

   !> Map coordinates: the engine works round the middle, nothing is lost.
   subroutine origin()
      call accept(model, control//rock//joint// &
         '&block vertices = 500000 4000000 500002 4000000 500002 4000001'// &
         ' 500000 4000001 / &measured_point name = ''p'' x = 500000.5 y = 4000000.25 /')
      call check_close(model%origin, [500001.0_wp, 4000000.5_wp], 'middle')
      call check_close(model%blocks%position(1:2, 1), [0.0_wp, 0.0_wp], 'centroid', &
         absolute=1.0e-12_wp)
      call check_close(model%points(1)%position, [-0.5_wp, -0.25_wp], 'point', absolute=1.0e-9_wp)
   end subroutine origin

   subroutine files()
      call write_scratch(complete_input)
      call read_model_file(model, scratch_name, error)
      call remove_scratch()
      call check_no_error(error, 'a name with a blank and an accent')
      call check(model%text == complete_input .and. model%file == scratch_name, &
         'text and name are kept')
      call read_model_file(model, 'no/such.nml', error)
      call check_fails(error, 'no/such.nml')
      if (allocated(error)) call check(error%kind == error_file .or. error%kind == error_input, &
         'its kind')
   end subroutine files

   subroutine overlaps()
      call refuse(complete_input//'&layers width = 1.0 thickness = 1.0 count = 2 /', '&layers', &
         'line 5', 'overlaps')
      call accept(model, complete_input// &
         '&block vertices = 1 0 2 0 2 1 1 1 / &block vertices = 0 1 2 1 2 2 0 2 /')
      call check(model%blocks%n == 3, 'touching blocks are read')
   end subroutine overlaps

   !> A byte that is no letter, and a name of 20 MB: on the stack it would end the program.
   subroutine unreadable_names()
      call refuse('&control time_step = 1.0e-3 st'//char(255)//'eps = 10 /'//newline//rock// &
         joint//square, '&control', 'line 1', 'cannot be read here')
      call refuse(complete_input//'&block '//repeat('x', 20000000)//' = 1 /', '&block', 'line 5')
   end subroutine unreadable_names

   !> Sizes and positions at which rounding would destroy the shape, also in generated blocks.
   subroutine bad_sizes_and_places()
      character(len=*), parameter :: before = control//rock//newline//joint//newline

      call refuse(before//'&layers bottom = 1e16 width = 10.0 thickness = 1.0 count = 3 /', &
         '&layers', 'line 5', 'block 1 layer_1 reaches farther')
      call refuse(complete_input//'&layers left = -2e9 width = 1.0 thickness = 1.0 /', '&layers', &
         'line 5', 'block 2 layer_1')
      call refuse(before//'&layers width = 1e-100 thickness = 1e-100 /', 'less than 1e-9 m')
      call refuse(complete_input// &
         '&layers left = -9e8 width = 1e7 thickness = 1e7 / &layers left = 9e8 '// &
         'width = 1e7 thickness = 1e7 /', '&block', 'line 4', &
         'block 1 measures 1 m, too little compared with')
      call refuse(before//'&drums width = 1e6 height = 1e-9 count = 2 /', '&drums', &
         'block 1 drum_1 has no area')
      call refuse(before//'&drums width = 1.0 top_width = 1e-14 height = 1.0 count = 2 /', &
         '&drums', 'block 2 drum_2 has a side of', 'too little compared with the 2 m')
      call accept(model, before//'&drums width = 1.0 top_width = 1e-9 height = 1.0 count = 2 /')
      call refuse(before//'&wall brick_length = 1.0 brick_height = 1.0 bricks = 2 name = '''// &
         repeat('n', 57)//''' /', '&wall', 'too long: at most 56')
   end subroutine bad_sizes_and_places

   !> An input cut off anywhere is read or refused with a message; nothing else happens.
   subroutine truncated_input()
      character(len=*), parameter :: text = complete_input// &
         '&motion name = ''m'' quantity = ''velocity'' time_step = 0.1 values ='// &
         ' 0.0 1.0 0.0 / &fixed_point x = 0.5 y = 0.5 motion_x = ''m'' / &load x = 0.5 y = 1.0 '// &
         'time = 0.0 1.0 force_x = 3.0 4.0 /'
      integer :: i, empty

      empty = 0
      do i = 0, len(text)
         call read_model(model, 'in.nml', text(:i), error)
         if (.not. allocated(error)) cycle
         if (index(error%message, 'in.nml') == 0) empty = empty + 1
      end do
      call check(empty == 0, 'every message names the file')
   end subroutine truncated_input

end module test_input
