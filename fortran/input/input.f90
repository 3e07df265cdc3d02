! SPDX-License-Identifier: GPL-3.0-or-later
!> Conversion of a namelist file into a model; all values are checked and all names are resolved.
module dda_input
   use dda_kinds, only: wp, long
   use dda_errors, only: error_type, error_input, fail
   use dda_free_memory, only: require_addresses
   use dda_input_group, only: group_type, fail_input, positions, require_new_name
   use dda_input_groups, only: control_values, run_values, read_values
   use dda_input_catalogue, only: find_group, unknown_group
   use dda_input_schema, only: input_groups
   use dda_input_text, only: parse_group, split_groups
   use dda_input_changes, only: typed_change, change_text, change_type
   use dda_input_bodies, only: read_bodies
   use dda_input_bolts, only: read_bolts
   use dda_input_flow, only: read_flow
   use dda_input_boundaries, only: read_boundaries, check_rest
   use dda_input_in_situ, only: read_in_situ
   use dda_input_joint, only: read_joint
   use dda_input_edge_loads, only: read_edge_loads
   use dda_input_free_field, only: check_columns
   use dda_input_material, only: read_material, fit_materials
   use dda_input_materials, only: read_motion
   use dda_input_points, only: read_fixed_point, read_load, read_point, read_amplification, &
      read_measured_joints, find_motions, number_of_block
   use dda_input_resolved, only: resolved_values
   use dda_input_settings, only: read_control, read_output, read_stop, &
      check_output_times, require_analysis
   use dda_input_stages, only: read_stages
   use dda_input_water_checks, only: check_water
   use dda_input_welds, only: check_bodies
   use dda_material, only: joint_type
   use dda_model, only: model_type, default_stiffness
   use dda_settings, only: contact_settings_type
   use dda_stage, only: stage_type
   use dda_support, only: fixed_point_type, load_type, point_type
   use dda_text, only: quoted
   use dda_text_file, only: read_text_file
   implicit none
   private
   public :: read_model_file, read_model

   integer(long), parameter :: largest_input = 1024_long**3  !< largest size of an input, bytes
   real(wp), parameter :: reading_bytes = 2.0_wp**20  !< measured memory for any input, bytes
   integer, parameter :: text_copies = 3  !< number of copies of the text in memory

contains

   !> Read a model from a file, after changes to its text.
   subroutine read_model_file(model, file, error, changes)
      type(model_type), intent(out) :: model  !< model of the input
      character(len=*), intent(in) :: file  !< path
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      character(len=*), intent(in), optional :: changes(:) !< changes, each 'NAME=VALUE'
      character(len=:), allocatable :: text
      type(change_type), allocatable :: typed(:)
      integer :: i

      call read_text_file(file, text, largest_input, error)
      if (present(changes)) then
         allocate (typed(size(changes)))
         do i = 1, size(changes)
            typed(i) = typed_change(trim(changes(i)))
         end do
         call change_text(file, text, typed, error)
      end if
      if (.not. allocated(error)) call read_model(model, file, text, error)
   end subroutine read_model_file

   !> Read a model from a text; paths in it are relative to the folder of `file`.
   subroutine read_model(model, file, text, error)
      type(model_type), intent(out) :: model  !< model of the input
      character(len=*), intent(in) :: file   !< source of the text
      character(len=*), intent(in) :: text  !< text of the input
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      type(group_type), allocatable :: groups(:)
      type(control_values) :: control
      character(len=:), allocatable :: folder
      integer :: i

      call require_addresses(reading_bytes + text_copies*len(text), file// &
         ': reading the input', 'use a machine with more', error)
      if (allocated(error)) return
      model%file = file
      model%text = text
      folder = file(:index(file, '/', back=.true.))
      allocate (model%block_files(0))
      call split_groups(file, text, groups, error)
      if (.not. allocated(error)) call check_names(file, groups, error)
      do i = 1, size(groups)
         call parse_group(text, groups(i), error)
      end do
      if (.not. allocated(error)) call read_settings(model, file, groups, control, error)
      if (.not. allocated(error)) call read_substances(model, file, folder, groups, error)
      if (.not. allocated(error)) call resolve_base_motion(model, groups, control, error)
      if (.not. allocated(error)) call read_bodies(model, file, folder, groups, error)
      if (.not. allocated(error)) call read_in_situ(model, groups, error)
      if (.not. allocated(error) .and. control%displaced_block /= '') model%control%displaced = &
         number_of_block(groups(minval(positions(groups, 'control'))), 'displaced_block', &
         model%block_names, control%displaced_block, error)
      if (.not. allocated(error)) call read_points(model, groups, error)
      if (.not. allocated(error)) call read_measured_joints(model, groups, error)
      if (.not. allocated(error)) call read_bolts(model, groups, error)
      if (.not. allocated(error)) call read_edge_loads(model, groups, error)
      if (.not. allocated(error)) call read_flow(model, groups, error)
      if (.not. allocated(error)) call read_boundaries(model, groups, error)
      if (.not. allocated(error)) call read_stages(model, groups, error)
      if (.not. allocated(error)) call read_ends(model, groups, error)
      if (.not. allocated(error)) call fit_materials(model, groups, error)
      call check_water(model, groups, error)
      call check_rest(model, groups, error)
      call check_columns(model, groups, error)
      call check_bodies(model, error)
      if (allocated(error)) return
      if (model%stages(1)%static) call refuse_velocities(file, model, error)
      call read_amplifications(model, groups, error)
      if (.not. allocated(error)) model%values = resolved_values(model, groups)
   end subroutine read_model

   !> Check that every group is known, and that groups that cannot repeat appear once.
   subroutine check_names(file, groups, error)
      character(len=*), intent(in) :: file  !< path
      type(group_type), intent(in) :: groups(:)  !< groups of the input, in its order
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer :: i, g, occurrences(size(input_groups))

      occurrences = 0
      do i = 1, size(groups)
         g = find_group(groups(i)%name)
         if (g > 0) then
            if (input_groups(g)%built) g = 0
         end if
         if (g == 0) call fail_input(error, groups(i), unknown_group(groups(i)%name, file))
         if (allocated(error)) return
         occurrences(g) = occurrences(g) + 1
         if (occurrences(g) > 1 .and. .not. input_groups(g)%repeats) call fail_input(error, &
            groups(i), 'this group may appear only once')
      end do
      if (size(positions(groups, 'control')) == 0) call refuse_missing(error, file, &
         'the group &control')
   end subroutine check_names

   !> Set the error for a missing group that every input must have.
   subroutine refuse_missing(error, file, group)
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      character(len=*), intent(in) :: file, group  !< path; name of the group

      if (.not. allocated(error)) call fail(error, error_input, file//': '//group//' is missing')
   end subroutine refuse_missing

   !> Read the groups that appear once.
   subroutine read_settings(model, file, groups, control, error)
      type(model_type), intent(inout) :: model  !< model; receives the values of groups
      character(len=*), intent(in) :: file  !< path
      type(group_type), intent(in) :: groups(:)  !< groups of the input, in its order
      type(control_values), intent(out) :: control  !< values of &control
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(run_values) :: run
      logical :: staged
      integer :: i

      model%title = ''
      model%output%file = default_output(file)
      staged = size(positions(groups, 'stage')) > 0
      do i = 1, size(groups)
         select case (groups(i)%name)
         case ('run')
            call read_values(groups(i), run, error)
            model%title = run%title
         case ('control')
            call read_control(groups(i), staged, model%control, control, error)
         case ('contact')
            call read_values(groups(i), model%contact%contact_values, error)
            model%contact%original_rules = model%contact%contact_rules == 'original'
         case ('output')
            call read_output(groups(i), model%output, error)
         end select
         if (allocated(error)) return
      end do
      if (.not. model%contact%original_rules) return
      call refuse_setting(model%control%integration /= 'dda', &
         "needs integration = 'dda' of &control, "//'not '//quoted(trim(model%control%integration)))
      call refuse_setting(model%control%settle, &
         'has no static stages, so settle of &control must be .false.')
      call refuse_setting(staged, 'does not support &stage')

   contains

      !> Reject a setting that cannot be combined with the original rules.
      subroutine refuse_setting(condition, reason)
         logical, intent(in) :: condition            !< the input has the setting
         character(len=*), intent(in) :: reason  !< reason

         if (condition .and. .not. allocated(error)) call fail(error, error_input, file// &
            ": contact_rules = 'original' of &contact "//reason)
      end subroutine refuse_setting

   end subroutine read_settings

   !> Default name of the output: the name of the input with .nc, in the working folder.
   pure function default_output(file) result(name)
      character(len=*), intent(in) :: file  !< path
      character(len=:), allocatable :: name
      integer :: length

      name = file(index(file, '/', back=.true.) + 1:)
      length = len(name)
      if (length > 4) then
         if (name(length - 3:) == '.nml') name = name(:length - 4)
      end if
      name = name//'.nc'
   end function default_output

   !> Read materials, joints and motions.
   subroutine read_substances(model, file, folder, groups, error)
      type(model_type), intent(inout) :: model  !< model; receives the values of groups
      character(len=*), intent(in) :: file, folder  !< path; folder of the path, '' or ending in '/'
      type(group_type), intent(in) :: groups(:)  !< groups of the input, in its order
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer, allocatable :: group_numbers(:)
      integer :: i

      group_numbers = positions(groups, 'material')
      allocate (model%materials(size(group_numbers)))
      if (size(group_numbers) == 0) call refuse_missing(error, file, 'the group &material')
      do i = 1, size(group_numbers)
         call read_material(groups(group_numbers(i)), model%materials(i), error)
         if (model%materials(i)%has_velocities) call require_analysis(error, &
            groups(group_numbers(i)), model%control, 'shear_velocity and pressure_velocity')
         call require_new_name(error, groups(group_numbers(i)), model%materials(i)%name, &
            model%materials(:i - 1)%name)
      end do
      group_numbers = positions(groups, 'joint')
      allocate (model%joints(size(group_numbers)))
      if (size(group_numbers) == 0) call refuse_missing(error, file, 'the group &joint')
      do i = 1, size(group_numbers)
         call read_joint(groups(group_numbers(i)), model%contact%shear_ratio, model%joints(i), &
            error)
         call check_rules(groups(group_numbers(i)), model%joints(i), model%contact, error)
         call require_new_name(error, groups(group_numbers(i)), model%joints(i)%name, &
            model%joints(:i - 1)%name)
         call refuse_damping(groups(group_numbers(i)), model%joints(:i), model%contact, error)
      end do
      group_numbers = positions(groups, 'motion')
      allocate (model%motions(size(group_numbers)))
      do i = 1, size(group_numbers)
         if (allocated(error)) return
         call read_motion(groups(group_numbers(i)), folder, model%motions(i), error)
         call require_new_name(error, groups(group_numbers(i)), model%motions(i)%name, &
            model%motions(:i - 1)%name)
      end do
      if (allocated(error)) return
      ! An omitted stiffness is 0.
      if (.not. model%contact%normal_stiffness > 0.0_wp) model%contact%normal_stiffness = &
         default_stiffness(model%materials)
   end subroutine read_substances

   !> Check that the contact rules permit the law of a joint.
   subroutine check_rules(group, joint, contact, error)
      type(group_type), intent(in) :: group  !< the &joint group
      type(joint_type), intent(in) :: joint  !< joint as read
      type(contact_settings_type), intent(in) :: contact  !< contact settings of the model
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      if (allocated(error)) return
      if (joint%is_plain()) return
      if (contact%original_rules) call fail_input(error, group, "contact_rules = 'original' "// &
         'support only normal_stiffness, Coulomb friction and contacts at corners: leave out '// &
         'law, stiffness per area and contact_points')
      if (contact%penetration_tolerance > 0.0_wp) call fail_input(error, group, 'a joint with '// &
         'a law, stiffness or contact_points of its own cannot be combined with '// &
         'penetration_tolerance, because the load determines the closure')
   end subroutine check_rules

   !> Reject restitution and damping of joints in models whose contacts cannot have them.
   subroutine refuse_damping(group, joints, contact, error)
      type(group_type), intent(in) :: group  !< group of the input
      type(joint_type), intent(in) :: joints(:)  !< joints so far
      type(contact_settings_type), intent(in) :: contact  !< settings of the contacts
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      character(len=:), allocatable :: variable
      integer :: j

      if (.not. any(joints%restitution >= 0.0_wp .or. joints%damping > 0.0_wp)) return
      variable = 'damping'
      if (any(joints%restitution >= 0.0_wp)) variable = 'restitution'
      do j = 1, size(joints)
         if (.not. joints(j)%is_plain()) call fail_input(error, group, variable//' of a joint '// &
            'cannot be combined with a law, stiffness per area or contact_points, of this or '// &
            'another joint; leave out one of them')
      end do
      if (contact%original_rules) call fail_input(error, group, variable// &
         " cannot be combined with contact_rules = 'original' of &contact: leave out one of them")
      if (contact%penetration_tolerance > 0.0_wp) call fail_input(error, group, variable// &
         ' cannot be combined with penetration_tolerance of &contact, because contacts then '// &
         'have no springs; leave out one of them')
   end subroutine refuse_damping

   !> Reject initial velocities in a model that begins with a static stage.
   subroutine refuse_velocities(file, model, error)
      character(len=*), intent(in) :: file  !< path
      type(model_type), intent(in) :: model  !< model with its materials
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer :: m

      do m = 1, size(model%materials)
         if (norm2(model%materials(m)%initial_velocity) == 0.0_wp) cycle
         call fail(error, error_input, file//': material '// &
            quoted(trim(model%materials(m)%name))//' has an initial_velocity, but the '// &
            'run begins with a static stage; leave out one of them')
         return
      end do
   end subroutine refuse_velocities

   !> .true. if samples are at equal time steps.
   pure logical function is_uniform(stages)
      type(stage_type), intent(in) :: stages(:)  !< stages in order
      real(wp), allocatable :: steps(:)

      steps = pack(stages%time_step, .not. stages%static)
      is_uniform = .not. any(stages(2:)%static)
      if (is_uniform .and. size(steps) > 0) is_uniform = all(steps == steps(1))
   end function is_uniform

   !> Find the motions of the base by name.
   subroutine resolve_base_motion(model, groups, control, error)
      type(model_type), intent(inout) :: model  !< model; receives the values of groups
      type(group_type), intent(in) :: groups(:)  !< groups of the input, in its order
      type(control_values), intent(in) :: control  !< values of &control
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer :: axis

      associate (group => groups(minval(positions(groups, 'control'))), &
         found => model%control%base_motion)
         call find_motions(group, [control%base_motion_x, control%base_motion_y], model%motions, &
            found, error, 'base_motion_')
         do axis = 1, 2
            if (allocated(error)) return
            if (found(axis) == 0) cycle
            associate (motion => model%motions(found(axis)))
               if (motion%stops .and. .not. motion%curve%ends_at_rest) call fail_input(error, &
                  group, 'base_motion_'//merge('x', 'y', axis == 1)//': a body force '// &
                  'cannot stop the base at the end of the record; leave out after_end of '// &
                  '&motion '//quoted(trim(motion%name))//', or apply this motion to supports')
            end associate
         end do
      end associate
   end subroutine resolve_base_motion

   !> Read fixed points, loads and measured points.
   subroutine read_points(model, groups, error)
      type(model_type), intent(inout) :: model  !< model; receives the values of groups
      type(group_type), intent(in) :: groups(:)  !< groups of the input, in its order
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(fixed_point_type) :: fixed
      type(load_type) :: load
      type(point_type) :: point
      integer, allocatable :: group_numbers(:)
      integer :: i

      group_numbers = positions(groups, 'fixed_point')
      allocate (model%fixed_points(size(group_numbers)))
      do i = 1, size(group_numbers)
         call read_fixed_point(groups(group_numbers(i)), model, fixed, error)
         model%fixed_points(i) = fixed
      end do
      group_numbers = positions(groups, 'load')
      allocate (model%loads(size(group_numbers)))
      do i = 1, size(group_numbers)
         call read_load(groups(group_numbers(i)), model, load, error)
         model%loads(i) = load
      end do
      group_numbers = positions(groups, 'measured_point')
      allocate (model%points(size(group_numbers)))
      do i = 1, size(group_numbers)
         call read_point(groups(group_numbers(i)), model, point, error)
         call require_new_name(error, groups(group_numbers(i)), point%name, model%points(:i &
            - 1)%name)
         model%points(i) = point
      end do
   end subroutine read_points

   !> Read &stop; check that output intervals are whole numbers of fixed time steps.
   subroutine read_ends(model, groups, error)
      type(model_type), intent(inout) :: model  !< model with its blocks and stages
      type(group_type), intent(in) :: groups(:)  !< groups of the input, in its order
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer :: i

      do i = 1, size(groups)
         if (groups(i)%name == 'stop') call read_stop(groups(i), model, error)
         if (groups(i)%name == 'output' .and. .not. model%control%adaptive) &
            call check_output_times(error, groups(i), model%output, model%stages)
      end do
   end subroutine read_ends

   !> Read the amplifications that are printed after the run.
   subroutine read_amplifications(model, groups, error)
      type(model_type), intent(inout) :: model  !< model; receives the values of groups
      type(group_type), intent(in) :: groups(:)  !< groups of the input, in its order
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer, allocatable :: group_numbers(:)
      integer :: i

      group_numbers = positions(groups, 'amplification')
      allocate (model%amplifications(size(group_numbers)))
      do i = 1, size(group_numbers)
         call read_amplification(groups(group_numbers(i)), model%points, model%amplifications(i), &
            error)
         if (.not. is_uniform(model%stages)) call fail_input(error, groups(group_numbers(i)), &
            'a spectrum needs samples at equal times, so one time_step in all dynamic stages, '// &
            'and no static stage but the first')
         if (model%control%adaptive .and. model%output%history_seconds <= 0.0_wp) &
            call fail_input(error, groups(group_numbers(i)), 'a spectrum needs samples '// &
            'at equal times, unlike adaptive steps; give history_seconds in &output')
      end do
   end subroutine read_amplifications

end module dda_input
