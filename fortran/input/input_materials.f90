! SPDX-License-Identifier: GPL-3.0-or-later
!> The group of motions, and substances by name: &motion.
module dda_input_materials
   use dda_kinds, only: wp
   use dda_baseline, only: baseline_type, make_motion_curve
   use dda_errors, only: error_type
   use dda_input_group, only: place_type, input_error, check_read, require, require_list, &
      require_choice, require_name, unset, is_set, name_length
   use dda_model, only: model_type
   use dda_motion, only: motion_type
   use dda_record, only: record_type, read_record
   use dda_text, only: quoted, to_text
   implicit none
   private
   public :: read_motion, find_substances

   integer, parameter :: most_values = 4096  !< of a motion given in the input itself

contains

   !> &motion: a record file, or values in the input itself.
   subroutine read_motion(group, place, folder, new, error)
      character(len=*), intent(in) :: group  !< its text, on one line
      type(place_type), intent(in) :: place  !< of the group
      !> that file names are relative to, '' or ending in '/'
      character(len=*), intent(in) :: folder
      type(motion_type), intent(out) :: new  !< as the group says
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      character(len=name_length) :: name, format, quantity, unit, after_end
      character(len=1024) :: file, message
      real(wp) :: time_step, values(most_values), scale, taper
      integer :: drift_order, channel, status
      type(record_type) :: record
      namelist /motion/ name, file, format, quantity, unit, time_step, values, scale, taper, &
         drift_order, channel, after_end

      name = ''
      file = ''
      format = 'auto'
      quantity = ''
      unit = ''
      time_step = unset
      values = unset
      scale = 1.0_wp
      taper = 0.0_wp
      drift_order = -1
      channel = 1
      after_end = ''
      read (group, nml=motion, iostat=status, iomsg=message)
      call check_read(error, place, status, message)

      if (name == '') call input_error(error, place, 'name is missing')
      call require(error, place, 'scale taper', [scale, taper])
      if (drift_order /= -1) call require(error, place, 'drift_order', [real(drift_order, wp)])
      if (is_set(time_step)) call require(error, place, 'time_step', [time_step])
      if (after_end /= '') call require_choice(error, place, 'after_end', after_end)
      if ((file == '') .eqv. .not. is_set(values(1))) call input_error(error, place, &
         'give either file or values')
      if (allocated(error)) return

      new%name = name
      if (file /= '') then
         call take_file(place, full_path(folder, trim(file)), trim(format), trim(quantity), &
            trim(unit), time_step, channel, record, error)
      else
         call take_values(place, values, time_step, trim(quantity), trim(unit), record, error)
      end if
      if (allocated(error)) return
      call make_motion(place, record, drift_order, baseline_type(taper=taper, scale=scale, &
         after_end=after_end(:8)), new, error)
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
   subroutine take_file(place, path, format, quantity, unit, time_step, channel, record, error)
      type(place_type), intent(in) :: place  !< of the group
      character(len=*), intent(in) :: path, format, quantity, unit  !< as the input gives them
      real(wp), intent(in) :: time_step  !< s
      integer, intent(in) :: channel  !< of a COSMOS file
      type(record_type), intent(out) :: record  !< as read
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(error_type), allocatable :: failure

      call read_record(record, path, format, quantity, unit, failure, merge(time_step, 0.0_wp, &
         is_set(time_step)), channel)
      if (allocated(failure)) call input_error(error, place, failure%message)
   end subroutine take_file

   !> Values in the group are in SI units.
   subroutine take_values(place, values, time_step, quantity, unit, record, error)
      type(place_type), intent(in) :: place  !< of the group
      real(wp), intent(in) :: values(:), time_step  !< samples, SI; s
      character(len=*), intent(in) :: quantity, unit  !< as the input gives them
      type(record_type), intent(out) :: record  !< as read
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      integer :: n

      n = count(is_set(values))
      call require(error, place, 'time_step', [time_step])
      call require_list(error, place, 'values', values(:n))
      if (n < 2) call input_error(error, place, &
         'values holds too few samples: at least 2 are needed')
      call require_choice(error, place, 'quantity', quantity)
      if (unit /= '' .and. unit /= 'm' .and. unit /= 'm/s' .and. unit /= 'm/s2') &
         call input_error(error, place, 'unit = '//quoted(unit)// &
         ': values in the input are in m, m/s or m/s2')
      if (allocated(error)) return
      record%time_step = time_step
      record%values = values(:n)
      record%quantity = quantity
      record%station = ''
      record%description = 'values in the input'
      record%file = ''
   end subroutine take_values

   !> Acceleration, velocity and displacement from the record; drift is removed from accelerations
   !> unless the input says otherwise.
   subroutine make_motion(place, record, drift_order, wanted, new, error)
      type(place_type), intent(in) :: place  !< of the group
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
         call input_error(error, place, failure%message)
         return
      end if
      new%file = record%file
      new%source = trim(new%name)//': '//record%file//' '//record%station//' '// &
         record%description//', '//to_text(size(record%values))//' samples of '//record%quantity// &
         ' every '//to_text(record%time_step)//' s; '//new%curve%method
   end subroutine make_motion

   !> Positions of a material and a joint by name; a blank name takes the only or first one.
   subroutine find_substances(place, material, joint, model, m, j, error)
      type(place_type), intent(in) :: place      !< of the group
      character(len=*), intent(in) :: material, joint        !< names, or blank
      type(model_type), intent(in) :: model      !< with its materials and joints
      integer, intent(out) :: m, j               !< positions in the model's lists
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays

      m = 1
      j = 1
      if (material /= '') call require_name(error, place, 'material', material, &
         model%materials%name, 'material', m)
      if (joint /= '') call require_name(error, place, 'joint', joint, model%joints%name, &
         'joint', j)
   end subroutine find_substances

end module dda_input_materials
