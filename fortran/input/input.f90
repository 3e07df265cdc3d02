! SPDX-License-Identifier: GPL-3.0-or-later
!> A namelist file becomes a model: everything it says checked, every name resolved.
module dda_input
   use dda_kinds, only: wp, long
   use dda_errors, only: error_type, error_input, fail
   use dda_free_memory, only: require_addresses
   use dda_input_group, only: group_type, input_error, get, get_text, require_name, &
      name_length
   use dda_input_catalogue, only: find_group, unknown_group
   use dda_input_schema, only: input_groups
   use dda_input_text, only: parse_group, split_groups
   use dda_input_changes, only: typed_change, change_text, change_type
   use dda_input_bodies, only: read_bodies
   use dda_input_bolts, only: read_bolts
   use dda_input_boundaries, only: read_boundaries, check_rest
   use dda_input_joint, only: read_joint
   use dda_input_edge_loads, only: read_edge_loads
   use dda_input_free_field, only: check_columns
   use dda_input_material, only: read_material, fit_materials
   use dda_input_materials, only: read_motion
   use dda_input_points, only: read_fixed_point, read_load, read_point, read_amplification, &
      number_of_block
   use dda_input_resolved, only: resolved_values
   use dda_input_settings, only: read_control, read_contact, read_output, &
      check_output_times, require_analysis
   use dda_input_stages, only: read_stages
   use dda_input_stop, only: read_stop
   use dda_input_welds, only: check_bodies
   use dda_material, only: joint_type
   use dda_model, only: model_type, default_stiffness
   use dda_plesha, only: steepest_return
   use dda_settings, only: contact_settings_type
   use dda_stage, only: stage_type
   use dda_text, only: quoted, to_text
   use dda_text_file, only: read_text_file
   implicit none
   private
   public :: read_model_file, read_model

   integer(long), parameter :: largest_input = 1024_long**3  !< bytes
   real(wp), parameter :: reading_bytes = 2.0_wp**20  !< of memory, whatever the input, measured
   integer, parameter :: text_copies = 3              !< of the input, as a whole and by groups

contains

   !> Read a model from a file, with changes made to its text.
   subroutine read_model_file(model, file, error, changes)
      type(model_type), intent(out) :: model  !< as the input says
      character(len=*), intent(in) :: file  !< path
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      character(len=*), intent(in), optional :: changes(:) !< 'NAME=VALUE' each
      character(len=:), allocatable :: text
      type(change_type), allocatable :: wanted(:)
      integer :: i

      call read_text_file(file, text, largest_input, error)
      if (present(changes)) then
         allocate (wanted(size(changes)))
         do i = 1, size(changes)
            wanted(i) = typed_change(trim(changes(i)))
         end do
         call change_text(file, text, wanted, error)
      end if
      if (.not. allocated(error)) call read_model(model, file, text, error)
   end subroutine read_model_file

   !> Read a model from a text; files that it names are relative to the folder of `file`.
   subroutine read_model(model, file, text, error)
      type(model_type), intent(out) :: model  !< as the input says
      character(len=*), intent(in) :: file   !< where the text comes from
      character(len=*), intent(in) :: text  !< of the input
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      type(group_type), allocatable :: groups(:)
      character(len=name_length) :: base_motion(2)
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
      if (.not. allocated(error)) call read_settings(model, file, groups, base_motion, error)
      if (.not. allocated(error)) call read_substances(model, file, folder, groups, error)
      if (.not. allocated(error)) call resolve_base_motion(model, groups, base_motion, error)
      if (.not. allocated(error)) call read_bodies(model, file, folder, groups, error)
      if (.not. allocated(error)) call resolve_displaced(model, groups, error)
      if (.not. allocated(error)) call read_points(model, groups, error)
      if (.not. allocated(error)) call read_bolts(model, groups, error)
      if (.not. allocated(error)) call read_edge_loads(model, groups, error)
      if (.not. allocated(error)) call read_boundaries(model, groups, error)
      if (.not. allocated(error)) call read_stages(model, groups, error)
      if (.not. allocated(error)) call read_ends(model, groups, error)
      if (.not. allocated(error)) call fit_materials(model, groups, error)
      call check_rest(model, groups, error)
      call check_columns(model, groups, error)
      call check_bodies(model, error)
      if (allocated(error)) return
      if (model%stages(1)%static) call refuse_velocities(file, model, error)
      call read_amplifications(model, groups, error)
      if (.not. allocated(error)) model%values = resolved_values(model, groups)
   end subroutine read_model

   !> Every group must be known, and appear once if it may not repeat.
   subroutine check_names(file, groups, error)
      character(len=*), intent(in) :: file  !< path
      type(group_type), intent(in) :: groups(:)  !< of the input, in its order
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      integer :: i, g, seen(size(input_groups))

      seen = 0
      do i = 1, size(groups)
         g = find_group(groups(i)%name)
         if (g > 0) then
            if (input_groups(g)%built) g = 0
         end if
         if (g == 0) then
            call input_error(error, groups(i), unknown_group(groups(i)%name, file))
            return
         end if
         seen(g) = seen(g) + 1
         if (seen(g) > 1 .and. .not. input_groups(g)%repeats) call input_error(error, &
            groups(i), 'this group may appear only once')
      end do
      if (count_groups(groups, 'control') == 0) call missing(error, file, 'the group &control')
   end subroutine check_names

   !> The error for a group that every input must have.
   subroutine missing(error, file, group)
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      character(len=*), intent(in) :: file, group  !< path; name of the group

      if (.not. allocated(error)) call fail(error, error_input, file//': '//group//' is missing')
   end subroutine missing

   !> Number of groups of a name.
   pure integer function count_groups(groups, name)
      type(group_type), intent(in) :: groups(:)  !< of the input, in its order
      character(len=*), intent(in) :: name  !< of a group
      integer :: i

      count_groups = 0
      do i = 1, size(groups)
         if (groups(i)%name == name) count_groups = count_groups + 1
      end do
   end function count_groups

   !> The groups that appear once.
   subroutine read_settings(model, file, groups, base_motion, error)
      type(model_type), intent(inout) :: model  !< filled group by group
      character(len=*), intent(in) :: file  !< path
      type(group_type), intent(in) :: groups(:)  !< of the input, in its order
      !> names of motions, x and y, or blank
      character(len=name_length), intent(out) :: base_motion(2)
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      integer :: i

      model%title = ''
      base_motion = ''
      model%output%file = default_output(file)
      do i = 1, size(groups)
         select case (groups(i)%name)
         case ('run')
            call get_text(groups(i), 'title', model%title)
         case ('control')
            call read_control(groups(i), count_groups(groups, 'stage') > 0, model%control, &
               base_motion, error)
         case ('contact')
            call read_contact(groups(i), model%contact, error)
         case ('output')
            call read_output(groups(i), model%output, error)
         end select
         if (allocated(error)) return
      end do
      if (model%contact%original_rules .and. model%control%integration /= 'dda') &
         call fail(error, error_input, file//": contact_rules = 'original' of &contact needs "// &
         "integration = 'dda' of &control, not "//quoted(trim(model%control%integration)))
      if (model%contact%original_rules .and. model%control%settle) call fail(error, error_input, &
         file//": contact_rules = 'original' of &contact has no static stage: settle of "// &
         '&control must be .false.')
      if (model%contact%original_rules .and. count_groups(groups, 'stage') > 0) call fail(error, &
         error_input, file//": contact_rules = 'original' of &contact knows no &stage")
   end subroutine read_settings

   !> The input's name with .nc in place of .nml, in the working folder.
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

   !> Materials, joints and motions.
   subroutine read_substances(model, file, folder, groups, error)
      type(model_type), intent(inout) :: model  !< filled group by group
      character(len=*), intent(in) :: file, folder  !< path; its folder, '' or ending in '/'
      type(group_type), intent(in) :: groups(:)  !< of the input, in its order
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      integer :: i, m, j, k

      allocate (model%materials(count_groups(groups, 'material')), &
         model%joints(count_groups(groups, 'joint')), model%motions(count_groups(groups, 'motion')))
      if (size(model%materials) == 0) call missing(error, file, 'the group &material')
      if (size(model%joints) == 0) call missing(error, file, 'the group &joint')
      m = 0
      j = 0
      k = 0
      do i = 1, size(groups)
         if (allocated(error)) return
         select case (groups(i)%name)
         case ('material')
            m = m + 1
            call read_material(groups(i), model%materials(m), error)
            if (model%materials(m)%has_velocities) call require_analysis(error, groups(i), &
               model%control, 'shear_velocity and pressure_velocity')
            call check_new_name(groups(i), model%materials(:m)%name, error)
         case ('joint')
            j = j + 1
            call read_joint(groups(i), model%joints(j), error)
            call check_rules(groups(i), model%joints(j), model%contact, error)
            call check_new_name(groups(i), model%joints(:j)%name, error)
            call refuse_damping(groups(i), model%joints(:j), model%contact, error)
         case ('motion')
            k = k + 1
            call read_motion(groups(i), folder, model%motions(k), error)
            call check_new_name(groups(i), model%motions(:k)%name, error)
         end select
      end do
      if (allocated(error)) return
      if (model%contact%normal_stiffness == 0.0_wp) model%contact%normal_stiffness = &
         default_stiffness(model%materials)
   end subroutine read_substances

   !> Contact rules that a joint law does not go with.
   subroutine check_rules(group, joint, contact, error)
      type(group_type), intent(in) :: group  !< of the joint's group
      type(joint_type), intent(in) :: joint  !< as read
      type(contact_settings_type), intent(in) :: contact  !< of the model
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays

      if (allocated(error)) return
      if (joint%is_plain()) return
      if (contact%original_rules) call input_error(error, group, "contact_rules = 'original' "// &
         'know one stiffness, no law but Coulomb friction and contacts at corners: leave out '// &
         'law, stiffness per area and contact_points')
      if (contact%penetration_tolerance > 0.0_wp) call input_error(error, group, 'a joint with '// &
         'a law, stiffness or contact_points of its own closes by what its load asks for: it '// &
         'does not go with penetration_tolerance')
      if (joint%law == 'plesha') call check_return(group, joint, contact%shear_ratio, error)
      if (joint%law == 'cohesive') call check_fracture(group, joint, contact%shear_ratio, error)
   end subroutine check_rules

   !> A joint holds less energy at its strength than it takes to spend it.
   subroutine check_fracture(group, joint, shear_ratio, error)
      type(group_type), intent(in) :: group  !< of the joint's group
      type(joint_type), intent(in) :: joint  !< as read
      real(wp), intent(in) :: shear_ratio    !< k_n/k_s, where the joint has none of its own
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      real(wp) :: shear_stiffness

      shear_stiffness = joint%normal_stiffness/shear_ratio
      if (joint%shear_stiffness > 0.0_wp) shear_stiffness = joint%shear_stiffness
      call compare('fracture_energy', joint%fracture_energy, joint%tensile_strength, &
         joint%normal_stiffness)
      call compare('shear_fracture_energy', joint%shear_fracture_energy, joint%cohesion, &
         shear_stiffness)

   contains

      subroutine compare(name, energy, strength, stiffness)
         character(len=*), intent(in) :: name                !< of the energy's variable
         real(wp), intent(in) :: energy, strength, stiffness !< N/m, Pa, Pa/m

         if (energy > 0.5_wp*strength**2/stiffness) return
         call input_error(error, group, name//' = '//to_text(energy)//' N/m is not above what '// &
            'the joint stores up to its strength, '//to_text(0.5_wp*strength**2/stiffness)// &
            ' N/m: it would break at once; raise it, or the stiffness per area')
      end subroutine compare

   end subroutine check_fracture

   !> Slip of rough joints back to their centre is stable.
   subroutine check_return(group, joint, shear_ratio, error)
      type(group_type), intent(in) :: group  !< of the joint's group
      type(joint_type), intent(in) :: joint  !< as read
      real(wp), intent(in) :: shear_ratio    !< k_n/k_s, where the joint has none of its own
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      real(wp) :: ratio

      ratio = shear_ratio
      if (joint%normal_stiffness > 0.0_wp .and. joint%shear_stiffness > 0.0_wp) &
         ratio = joint%normal_stiffness/joint%shear_stiffness
      if (ratio >= steepest_return(joint)) call input_error(error, group, 'the normal '// &
         'stiffness is '//to_text(ratio)//' of the shear stiffness: from '// &
         to_text(steepest_return(joint))//' on the joint would jump back to its centre; give '// &
         'a larger shear_stiffness_per_area, or less asperity_angle')
   end subroutine check_return

   !> Restitution and dashpots of a joint need contacts of the own rules with springs.
   subroutine refuse_damping(group, joints, contact, error)
      type(group_type), intent(in) :: group  !< of the input
      type(joint_type), intent(in) :: joints(:)  !< so far
      type(contact_settings_type), intent(in) :: contact  !< of the same input
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      character(len=:), allocatable :: variable
      integer :: j

      if (.not. any(joints%restitution >= 0.0_wp .or. joints%damping > 0.0_wp)) return
      variable = 'damping'
      if (any(joints%restitution >= 0.0_wp)) variable = 'restitution'
      do j = 1, size(joints)
         if (.not. joints(j)%is_plain()) call input_error(error, group, variable//' of a joint '// &
            'does not go with a law, stiffness per area or contact_points, of this or another '// &
            'joint: leave out one of them')
      end do
      if (contact%original_rules) call input_error(error, group, variable// &
         " does not go with contact_rules = 'original' of &contact: leave out one of them")
      if (contact%penetration_tolerance > 0.0_wp) call input_error(error, group, variable// &
         ' does not go with penetration_tolerance of &contact, whose contacts have no springs: '// &
         'leave out one of them')
   end subroutine refuse_damping

   !> A model that begins at rest has no first velocities.
   subroutine refuse_velocities(file, model, error)
      character(len=*), intent(in) :: file  !< path
      type(model_type), intent(in) :: model  !< with its materials
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      integer :: m

      do m = 1, size(model%materials)
         if (norm2(model%materials(m)%initial_velocity) == 0.0_wp) cycle
         call fail(error, error_input, file//': material '// &
            quoted(trim(model%materials(m)%name))//' has an initial_velocity, and the '// &
            'run begins at rest: leave out one of them')
         return
      end do
   end subroutine refuse_velocities

   !> Samples stand at equal times.
   pure logical function is_uniform(stages)
      type(stage_type), intent(in) :: stages(:)  !< in order
      real(wp), allocatable :: steps(:)

      steps = pack(stages%time_step, .not. stages%static)
      is_uniform = .not. any(stages(2:)%static)
      if (is_uniform .and. size(steps) > 0) is_uniform = all(steps == steps(1))
   end function is_uniform

   !> The last name must not have been used before.
   subroutine check_new_name(group, names, error)
      type(group_type), intent(in) :: group  !< of the group
      character(len=*), intent(in) :: names(:)  !< of all such groups so far
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays

      associate (last => names(size(names)))
         if (any(names(:size(names) - 1) == last)) call input_error(error, group, 'name = '// &
            quoted(last)//' is used twice')
      end associate
   end subroutine check_new_name

   !> The motions of the base by name.
   subroutine resolve_base_motion(model, groups, base_motion, error)
      type(model_type), intent(inout) :: model  !< filled group by group
      type(group_type), intent(in) :: groups(:)  !< of the input, in its order
      character(len=*), intent(in) :: base_motion(2)  !< names of motions, x and y, or blank
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(group_type) :: group
      integer :: axis, i

      do i = 1, size(groups)
         if (groups(i)%name == 'control') group = groups(i)
      end do
      do axis = 1, 2
         if (base_motion(axis) == '') cycle
         call require_name(error, group, 'base_motion_'//merge('x', 'y', axis == 1), &
            base_motion(axis), model%motions%name, 'motion', model%control%base_motion(axis))
         if (allocated(error)) return
         associate (motion => model%motions(model%control%base_motion(axis)))
            if (motion%stops .and. .not. motion%curve%ends_at_rest) call input_error(error, group, &
               'base_motion_'//merge('x', 'y', axis == 1)//': as body force nothing stops the '// &
               'base at the end of the record: leave after_end of &motion '// &
               quoted(trim(motion%name))//' out, or move supports by it')
         end associate
      end do
   end subroutine resolve_base_motion

   !> The displaced block by its name or number.
   subroutine resolve_displaced(model, groups, error)
      type(model_type), intent(inout) :: model  !< with its blocks
      type(group_type), intent(in) :: groups(:)  !< of the input, in its order
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      character(len=name_length) :: name
      integer :: i

      name = ''
      do i = 1, size(groups)
         if (groups(i)%name /= 'control') cycle
         call get(groups(i), 'displaced_block', name, error)
         if (name == '' .or. allocated(error)) return
         model%control%displaced_block = number_of_block(groups(i), 'displaced_block', &
            model%block_names, name, error)
      end do
   end subroutine resolve_displaced

   !> Fixed points, loads and measured points.
   subroutine read_points(model, groups, error)
      type(model_type), intent(inout) :: model  !< filled group by group
      type(group_type), intent(in) :: groups(:)  !< of the input, in its order
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      integer :: i, f, l, p

      allocate (model%fixed_points(count_groups(groups, 'fixed_point')), &
         model%loads(count_groups(groups, 'load')), &
         model%points(count_groups(groups, 'measured_point')))
      f = 0
      l = 0
      p = 0
      do i = 1, size(groups)
         if (allocated(error)) return
         select case (groups(i)%name)
         case ('fixed_point')
            f = f + 1
            call read_fixed_point(groups(i), model%blocks, model%block_names, model%origin, &
               model%motions, model%fixed_points(f), error)
         case ('load')
            l = l + 1
            call read_load(groups(i), model%blocks, model%block_names, model%origin, &
               model%loads(l), error)
         case ('measured_point')
            p = p + 1
            call read_point(groups(i), model%blocks, model%block_names, model%origin, &
               model%points(p), error)
            call check_new_name(groups(i), model%points(:p)%name, error)
         end select
      end do
   end subroutine read_points

   !> What ends the run early, and output times that its steps must meet.
   subroutine read_ends(model, groups, error)
      type(model_type), intent(inout) :: model  !< with its blocks and stages
      type(group_type), intent(in) :: groups(:)  !< of the input, in its order
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      integer :: i

      do i = 1, size(groups)
         if (groups(i)%name == 'stop') call read_stop(groups(i), model, error)
         if (groups(i)%name == 'output' .and. .not. model%control%adaptive) &
            call check_output_times(error, groups(i), model%output, model%stages)
      end do
   end subroutine read_ends

   !> The amplifications to be printed after the run.
   subroutine read_amplifications(model, groups, error)
      type(model_type), intent(inout) :: model  !< filled group by group
      type(group_type), intent(in) :: groups(:)  !< of the input, in its order
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      integer :: i, a

      allocate (model%amplifications(count_groups(groups, 'amplification')))
      a = 0
      do i = 1, size(groups)
         if (allocated(error)) return
         if (groups(i)%name /= 'amplification') cycle
         a = a + 1
         call read_amplification(groups(i), model%points, model%amplifications(a), error)
         if (.not. is_uniform(model%stages)) call input_error(error, groups(i), 'a spectrum '// &
            'needs samples at equal times: one time_step in all dynamic stages, and no static '// &
            'stage but the first')
         if (model%control%adaptive .and. model%output%history_seconds <= 0.0_wp) &
            call input_error(error, groups(i), 'a spectrum needs samples '// &
            'at equal times, and adaptive steps are not: give history_seconds in &output')
      end do
   end subroutine read_amplifications

end module dda_input
