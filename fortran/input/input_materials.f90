! SPDX-License-Identifier: GPL-3.0-or-later
!> The group of motions, and substances by name: &motion.
module dda_input_materials
   use dda_kinds, only: wp
   use dda_baseline, only: baseline_type, make_motion_curve
   use dda_errors, only: error_type
   use dda_input_group, only: group_type, input_error, get, get_list, get_text, given, require, &
      require_name, unset, value_or, name_length
   use dda_model, only: model_type
   use dda_motion, only: motion_type
   use dda_record, only: record_type, read_record
   use dda_text, only: quoted, to_text
   implicit none
   private
   public :: read_motion, find_substances

contains

   !> &motion: a record file, or values in the input itself.
   subroutine read_motion(group, folder, new, error)
      type(group_type), intent(in) :: group  !< of the input
      !> that file names are relative to, '' or ending in '/'
      character(len=*), intent(in) :: folder
      type(motion_type), intent(out) :: new  !< as the group says
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(baseline_type) :: wanted
      type(record_type) :: record
      character(len=:), allocatable :: file
      real(wp) :: time_step
      integer :: drift_order, channel

      file = ''
      time_step = unset
      drift_order = -1
      channel = 1
      call get(group, 'name', new%name, error)
      call get(group, 'scale', wanted%scale, error)
      call get(group, 'taper', wanted%taper, error)
      call get(group, 'drift_order', drift_order, error)
      call get(group, 'channel', channel, error)
      call get(group, 'time_step', time_step, error)
      call get(group, 'after_end', wanted%after_end, error)
      call get_text(group, 'file', file)
      if ((file == '') .eqv. .not. given(group, 'values')) call input_error(error, group, &
         'give either file or values')
      if (allocated(error)) return
      if (file /= '') then
         call take_file(group, full_path(folder, file), time_step, channel, record, &
            error)
      else
         call take_values(group, time_step, record, error)
      end if
      if (.not. allocated(error)) call make_motion(group, record, drift_order, wanted, new, error)
   end subroutine read_motion

   !> A path of the input, relative to the working folder.
   pure function full_path(folder, file) result(path)
      !> folder of the input, '' or ending in '/'; path
      character(len=*), intent(in) :: folder, file
      character(len=:), allocatable :: path

      path = file
      if (file(1:1) /= '/') path = folder//file
   end function full_path

   !> Read the record file; its errors get the place of the group in front.
   subroutine take_file(group, path, time_step, channel, record, error)
      type(group_type), intent(in) :: group  !< of the input
      character(len=*), intent(in) :: path   !< of the record
      real(wp), intent(in) :: time_step  !< s, or `unset`
      integer, intent(in) :: channel     !< of a COSMOS file
      type(record_type), intent(out) :: record  !< as read
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(error_type), allocatable :: failure
      character(len=:), allocatable :: format, quantity, unit

      format = 'auto'
      quantity = ''
      unit = ''
      call get_text(group, 'format', format)
      call get_text(group, 'quantity', quantity)
      call get_text(group, 'unit', unit)
      call read_record(record, path, format, quantity, unit, failure, value_or(time_step, 0.0_wp), &
         channel)
      if (allocated(failure)) call input_error(error, group, failure%message)
   end subroutine take_file

   !> Values in the group are in SI units.
   subroutine take_values(group, time_step, record, error)
      type(group_type), intent(in) :: group  !< of the input
      real(wp), intent(in) :: time_step      !< s, or `unset`
      type(record_type), intent(out) :: record  !< as read
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      character(len=name_length) :: quantity, unit

      quantity = ''
      unit = ''
      call require(error, group, 'time_step', [time_step])
      call get_list(group, 'values', record%values, error)
      if (size(record%values) < 2) call input_error(error, group, &
         'values holds too few samples: at least 2 are needed')
      call get(group, 'quantity', quantity, error)
      if (quantity == '') call input_error(error, group, &
         "quantity is missing; give 'acceleration', 'velocity' or 'displacement'")
      call get(group, 'unit', unit, error)
      if (all(unit /= [character(len=4) :: '', 'm', 'm/s', 'm/s2'])) call input_error(error, &
         group, 'unit = '//quoted(unit)//': values in the input are in m, m/s or m/s2')
      if (allocated(error)) return
      record%time_step = time_step
      record%quantity = quantity
      record%station = ''
      record%description = 'values in the input'
      record%file = ''
   end subroutine take_values

   !> Acceleration, velocity and displacement from the record; drift is removed from accelerations
   !> unless the input says otherwise.
   subroutine make_motion(group, record, drift_order, wanted, new, error)
      type(group_type), intent(in) :: group  !< of the group
      type(record_type), intent(in) :: record  !< as read
      integer, intent(in) :: drift_order  !< of the polynomial; −1: by the quantity
      type(baseline_type), intent(in) :: wanted  !< what else is done to the record
      type(motion_type), intent(inout) :: new  !< gets its curves
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(error_type), allocatable :: failure
      type(baseline_type) :: baseline

      baseline = wanted
      new%stops = wanted%after_end == 'hold'
      baseline%order = drift_order
      if (drift_order == -1) baseline%order = merge(2, 0, record%quantity == 'acceleration')
      call make_motion_curve(new%curve, record%quantity, record%values, record%time_step, failure, &
         baseline)
      if (allocated(failure)) then
         call input_error(error, group, failure%message)
         return
      end if
      new%file = record%file
      new%source = trim(new%name)//': '//record%file//' '//record%station//' '// &
         record%description//', '//to_text(size(record%values))//' samples of '//record%quantity// &
         ' every '//to_text(record%time_step)//' s; '//new%curve%method
   end subroutine make_motion

   !> Positions of the material and the joint of a group; without a name the only or first one.
   subroutine find_substances(group, model, m, j, error)
      type(group_type), intent(in) :: group      !< of the input
      type(model_type), intent(in) :: model      !< with its materials and joints
      integer, intent(out) :: m, j               !< positions in the model's lists
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      character(len=name_length) :: material, joint

      material = ''
      joint = ''
      m = 1
      j = 1
      call get(group, 'material', material, error)
      call get(group, 'joint', joint, error)
      if (material /= '') call require_name(error, group, 'material', material, &
         model%materials%name, 'material', m)
      if (joint /= '') call require_name(error, group, 'joint', joint, model%joints%name, &
         'joint', j)
   end subroutine find_substances

end module dda_input_materials
