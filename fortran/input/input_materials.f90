! SPDX-License-Identifier: GPL-3.0-or-later
!> Group &motion, and search of materials and joints by name.
module dda_input_materials
   use dda_kinds, only: wp
   use dda_baseline, only: baseline_type, make_motion_curve
   use dda_errors, only: error_type
   use dda_input_group, only: group_type, fail_input, is_set, require_name, value_or, name_length
   use dda_input_groups, only: motion_values, naming_values, read_values
   use dda_model, only: model_type
   use dda_motion, only: motion_type
   use dda_record, only: record_type, read_record
   use dda_text, only: quoted, to_text
   implicit none
   private
   public :: read_motion, find_substances

   !> length of the name of generated blocks, to which a number is added
   integer, parameter :: longest_stem = name_length - 8

contains

   !> Read &motion: a record file, or values in the input.
   subroutine read_motion(group, folder, new, error)
      type(group_type), intent(in) :: group  !< group of the input
      !> folder to which file names are relative, '' or ending in '/'
      character(len=*), intent(in) :: folder
      type(motion_type), intent(out) :: new  !< values of the group
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(motion_values) :: input
      type(record_type) :: record
      type(error_type), allocatable :: failure
      character(len=:), allocatable :: path

      call read_values(group, input, error)
      new%name = input%name
      if (allocated(error)) return
      if (input%file /= '') then
         path = input%file
         if (path(1:1) /= '/') path = folder//path
         call read_record(record, path, trim(input%format), trim(input%quantity), &
            trim(input%unit), failure, value_or(input%time_step, 0.0_wp), input%channel)
         if (allocated(failure)) call fail_input(error, group, failure%message)
      else
         call read_samples(group, input, record, error)
      end if
      if (.not. allocated(error)) call make_motion(group, record, input, new, error)
   end subroutine read_motion

   !> Read values from the group, in SI units.
   subroutine read_samples(group, input, record, error)
      type(group_type), intent(in) :: group  !< group of the input
      type(motion_values), intent(in) :: input !< values of the group
      type(record_type), intent(out) :: record  !< record
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      if (size(input%values) < 2) call fail_input(error, group, &
         '`values` has too few samples; at least 2 are needed')
      if (all(input%unit /= [character(len=4) :: '', 'm', 'm/s', 'm/s2'])) call fail_input(error, &
         group, 'unit = '//quoted(input%unit)//': values in the input are in m, m/s or m/s2')
      if (allocated(error)) return
      record%time_step = input%time_step
      record%values = input%values
      record%quantity = trim(input%quantity)
      record%station = ''
      record%description = 'values in the input'
      record%file = ''
   end subroutine read_samples

   !> Compute acceleration, velocity and displacement of the record.
   !> By default, drift is removed from accelerations.
   subroutine make_motion(group, record, input, new, error)
      type(group_type), intent(in) :: group  !< group of the input
      type(record_type), intent(in) :: record  !< record
      type(motion_values), intent(in) :: input !< values of the group
      type(motion_type), intent(inout) :: new  !< receives the curves
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(error_type), allocatable :: failure
      type(baseline_type) :: baseline

      baseline%scale = input%scale
      baseline%taper = input%taper
      baseline%after_end = input%after_end
      new%stops = input%after_end == 'hold'
      baseline%order = merge(2, 0, record%quantity == 'acceleration')
      if (is_set(input%drift_order)) baseline%order = input%drift_order
      call make_motion_curve(new%curve, record%quantity, record%values, record%time_step, failure, &
         baseline)
      if (allocated(failure)) call fail_input(error, group, failure%message)
      if (allocated(error)) return
      new%file = record%file
      new%source = trim(new%name)//': '//record%file//' '//record%station//' '// &
         record%description//', '//to_text(size(record%values))//' samples of '//record%quantity// &
         ' every '//to_text(record%time_step)//' s; '//new%curve%method
   end subroutine make_motion

   !> Find a material and a joint by name; without a name, return the first one.
   subroutine find_substances(group, names, model, m, j, error, stem)
      type(group_type), intent(in) :: group      !< group of the input
      type(naming_values), intent(in) :: names   !< names in the group, or blank
      type(model_type), intent(in) :: model      !< model with its materials and joints
      integer, intent(out) :: m, j               !< positions in the model's lists
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      character(len=*), intent(in), optional :: stem  !< name of generated blocks without numbers

      if (present(stem)) then
         if (len_trim(stem) > longest_stem) call fail_input(error, group, 'name = '// &
            quoted(stem)//' is too long: at most '//to_text(longest_stem)// &
            ' characters, because numbers are added to it')
      end if
      m = 1
      j = 1
      if (names%material /= '') call require_name(error, group, 'material', names%material, &
         model%materials%name, 'material', m)
      if (names%joint /= '') call require_name(error, group, 'joint', names%joint, &
         model%joints%name, 'joint', j)
   end subroutine find_substances

end module dda_input_materials
