! SPDX-License-Identifier: GPL-3.0-or-later
!> The groups that appear once: &run, &control, &contact, &output.
module dda_input_settings
   use dda_kinds, only: wp, long
   use dda_errors, only: error_type
   use dda_input_group, only: group_type, input_error, get, get_list, get_text, given, require, &
      value_or, unset, is_set, name_length
   use dda_input_integration, only: read_integration
   use dda_settings, only: control_type, contact_settings_type, output_settings_type
   use dda_stage, only: stage_type
   use dda_text, only: to_text
   implicit none
   private
   public :: read_control, read_contact, read_output, check_output_times, count_steps, &
      require_analysis

contains

   !> &control: how the run is stepped.
   subroutine read_control(group, staged, settings, base_motion, error)
      type(group_type), intent(in) :: group  !< of the input
      logical, intent(in) :: staged  !< the input has stages of its own
      type(control_type), intent(out) :: settings  !< defaults where the input is silent
      character(len=name_length), intent(out) :: base_motion(2)  !< names of motions, x and y
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      real(wp), allocatable :: gravity(:), displaced_by(:)
      character(len=name_length) :: words(3)
      real(wp) :: duration, steps

      base_motion = ''
      words = [character(len=name_length) :: 'fixed', '', settings%solver]
      duration = unset
      steps = unset
      call get(group, 'time_step', settings%time_step, error)
      settings%least_time_step = 1.0e-6_wp*settings%time_step
      call get(group, 'dynamic_factor', settings%dynamic_factor, error)
      call get(group, 'max_displacement_ratio', settings%max_displacement_ratio, error)
      call get(group, 'least_time_step', settings%least_time_step, error)
      call get_list(group, 'gravity', gravity, error)
      call get_list(group, 'displaced_by', displaced_by, error)
      call get(group, 'solver', words(3), error)
      call get(group, 'time_step_control', words(1), error)
      call get(group, 'analysis', words(2), error)
      call get(group, 'settle', settings%settle)
      call get(group, 'duration', duration, error)
      call get(group, 'steps', steps, error)
      call get(group, 'base_motion_x', base_motion(1), error)
      call get(group, 'base_motion_y', base_motion(2), error)
      if (.not. staged) call count_steps(error, group, settings%time_step, duration, steps)
      if (staged) call refuse_steps(error, group, duration, settings%settle, steps)
      if (allocated(error)) return
      settings%duration = value_or(duration, 0.0_wp)
      settings%steps = int(steps, long)
      if (size(gravity) > 0) settings%gravity = gravity
      if (size(displaced_by) > 0) settings%displaced_by = displaced_by
      settings%adaptive = words(1) == 'adaptive'
      settings%plane_strain = words(2) == 'plane_strain'
      settings%analysis_given = words(2) /= ''
      settings%solver = words(3)(:len(settings%solver))
      call read_integration(group, settings, error)
   end subroutine read_control

   !> Where waves count, plane strain or plane stress is chosen: it decides on their velocities.
   pure subroutine require_analysis(error, group, control, what)
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(group_type), intent(in) :: group        !< of the group that asks for it
      type(control_type), intent(in) :: control    !< as read
      character(len=*), intent(in) :: what         !< about waves in that group

      if (.not. control%analysis_given) call input_error(error, group, what//' ask for a '// &
         "choice of analysis in &control: 'plane_strain' (ground, which goes on across the "// &
         "plane) or 'plane_stress' (a plate between free faces, with slower P waves)")
   end subroutine require_analysis

   !> Stages have steps of their own.
   subroutine refuse_steps(error, group, duration, settle, steps)
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(group_type), intent(in) :: group     !< of the group
      real(wp), intent(in) :: duration          !< s, or `unset`
      logical, intent(in) :: settle             !< as read
      real(wp), intent(inout) :: steps          !< as read, becomes 0

      if (is_set(duration) .or. is_set(steps) .or. settle) call input_error(error, group, &
         'with &stage groups, duration, steps and settle have no place here: each &stage '// &
         "has its own, and kind = 'static' settles")
      steps = 0.0_wp
   end subroutine refuse_steps

   !> The number of steps, from `steps` or from `duration`.
   subroutine count_steps(error, group, time_step, duration, steps)
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(group_type), intent(in) :: group  !< of the group
      real(wp), intent(in) :: time_step, duration  !< s, or `unset`
      real(wp), intent(inout) :: steps  !< `unset` if `duration` is given

      if (allocated(error)) return
      if (is_set(duration) .eqv. is_set(steps)) then
         call input_error(error, group, 'give either duration or steps')
         return
      end if
      if (is_set(duration)) then
         steps = anint(duration/time_step)
         if (steps < 1.0_wp) call input_error(error, group, &
            'duration = '//to_text(duration)//' is shorter than one time_step')
         call require(error, group, 'steps', [steps])
      end if
   end subroutine count_steps

   !> &contact: springs and iteration.  A stiffness left out stays 0 and gets the model's default.
   subroutine read_contact(group, settings, error)
      type(group_type), intent(in) :: group  !< of the input
      type(contact_settings_type), intent(out) :: settings  !< defaults where the input is silent
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      character(len=name_length) :: rules
      real(wp) :: normal_stiffness

      rules = 'consistent'
      normal_stiffness = unset
      call get(group, 'normal_stiffness', normal_stiffness, error)
      call get(group, 'shear_ratio', settings%shear_ratio, error)
      call get(group, 'fixed_point_ratio', settings%fixed_point_ratio, error)
      call get(group, 'force_tolerance', settings%force_tolerance, error)
      call get(group, 'penetration_tolerance', settings%penetration_tolerance, error)
      call get(group, 'max_iterations', settings%max_iterations, error)
      call get(group, 'contact_rules', rules, error)
      settings%original_rules = rules == 'original'
      if (is_set(normal_stiffness)) settings%normal_stiffness = normal_stiffness
   end subroutine read_contact

   !> &output: where and how often.
   subroutine read_output(group, settings, error)
      type(group_type), intent(in) :: group  !< of the input
      type(output_settings_type), intent(inout) :: settings  !< with its defaults before
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays

      call get_text(group, 'file', settings%file)
      call get(group, 'checkpoint_interval', settings%checkpoint_interval, error)
      call get(group, 'checkpoint_minutes', settings%checkpoint_minutes, error)
      call set_interval(error, group, 'history', settings%history_interval, &
         settings%history_seconds)
      call set_interval(error, group, 'block', settings%block_interval, settings%block_seconds)
   end subroutine read_output

   !> How often samples or frames are taken: by steps or by seconds, not both.
   pure subroutine set_interval(error, group, what, interval, period)
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(group_type), intent(in) :: group     !< of the input
      character(len=*), intent(in) :: what      !< 'history' or 'block'
      integer, intent(inout) :: interval        !< steps, with its default before; 0: by seconds
      real(wp), intent(inout) :: period         !< s, with its default before

      if (given(group, what//'_interval') .and. given(group, what//'_seconds')) &
         call input_error(error, group, 'give either '//what//'_interval, in steps, or '//what// &
         '_seconds')
      call get(group, what//'_interval', interval, error)
      if (.not. given(group, what//'_seconds')) return
      interval = 0
      call get(group, what//'_seconds', period, error)
   end subroutine set_interval

   !> Steps that cannot be shortened must fit into an output interval.
   pure subroutine check_output_times(error, group, settings, stages)
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(group_type), intent(in) :: group                  !< of the group &output
      type(output_settings_type), intent(in) :: settings     !< as read
      type(stage_type), intent(in) :: stages(:)              !< of the model, with fixed steps
      real(wp) :: seconds, ratio
      integer :: kind, s

      do kind = 1, 2
         seconds = merge(settings%history_seconds, settings%block_seconds, kind == 1)
         if (seconds <= 0.0_wp) cycle
         do s = 1, size(stages)
            if (stages(s)%static) cycle
            ratio = seconds/stages(s)%time_step
            if (ratio < 0.5_wp .or. abs(ratio - anint(ratio)) > 1.0e-6_wp*ratio) &
               call input_error(error, group, trim(merge('history_seconds', 'block_seconds  ', &
               kind == 1))//' = '//to_text(seconds)//' is no whole number of time steps of '// &
               to_text(stages(s)%time_step)//' s; change one of them, or let steps end there '// &
               "by time_step_control = 'adaptive'")
         end do
      end do
   end subroutine check_output_times

end module dda_input_settings
