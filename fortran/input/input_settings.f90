! SPDX-License-Identifier: GPL-3.0-or-later
!> Groups that appear once: &run, &control, &contact, &output.
module dda_input_settings
   use dda_kinds, only: wp, long
   use dda_errors, only: error_type
   use dda_input_group, only: group_type, input_error, given, require, value_or, is_set
   use dda_input_groups, only: control_values, output_values, read_values
   use dda_input_integration, only: set_integration
   use dda_settings, only: control_type, contact_settings_type, output_settings_type
   use dda_stage, only: stage_type
   use dda_text, only: to_text
   implicit none
   private
   public :: read_control, read_contact, read_output, check_output_times, count_steps, &
      require_analysis

contains

   !> Read &control: the time stepping of the run.
   subroutine read_control(group, staged, settings, own, error)
      type(group_type), intent(in) :: group  !< group of the input
      logical, intent(in) :: staged  !< the input has groups &stage
      type(control_type), intent(out) :: settings  !< by the group
      type(control_values), intent(out) :: own     !< values of the group
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      call read_values(group, own, error)
      if (.not. staged) call count_steps(error, group, own%time_step, own%duration, own%steps)
      if (staged .and. (is_set(own%duration) .or. is_set(own%steps) .or. own%settle)) call &
         input_error(error, group, 'with &stage groups, duration, steps and settle are not '// &
         "allowed here: each &stage has its own, and kind = 'static' settles")
      if (allocated(error)) return
      settings%control_values = own
      settings%duration = value_or(own%duration, 0.0_wp)
      settings%step_count = int(value_or(own%steps, 0.0_wp), long)
      settings%least_time_step = value_or(own%least_time_step, 1.0e-6_wp*own%time_step)
      settings%adaptive = own%time_step_control == 'adaptive'
      settings%plane_strain = own%analysis == 'plane_strain'
      settings%analysis_given = given(group, 'analysis')
      call set_integration(group, trim(own%integration), own%theta, own%damping_ratio, &
         own%damping_frequency, settings, error)
   end subroutine read_control

   !> Require that `analysis` is given, because wave velocities depend on it.
   pure subroutine require_analysis(error, group, control, what)
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(group_type), intent(in) :: group        !< group of the input
      type(control_type), intent(in) :: control    !< settings as read
      character(len=*), intent(in) :: what         !< text on the waves

      if (.not. control%analysis_given) call input_error(error, group, what//' require a '// &
         "choice of analysis in &control: 'plane_strain' (ground, which goes on across the "// &
         "plane) or 'plane_stress' (a plate between free faces, with slower P waves)")
   end subroutine require_analysis

   !> Find the number of steps from `steps` or `duration`.
   subroutine count_steps(error, group, time_step, duration, steps)
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(group_type), intent(in) :: group  !< group of the input
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

   !> Read &contact: springs and iteration.  An omitted stiffness is 0 (default of the model).
   subroutine read_contact(group, settings, error)
      type(group_type), intent(in) :: group  !< group of the input
      type(contact_settings_type), intent(out) :: settings  !< by the group
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      call read_values(group, settings%contact_values, error)
      settings%original_rules = settings%contact_rules == 'original'
   end subroutine read_contact

   !> Read &output: file and intervals.
   subroutine read_output(group, settings, error)
      type(group_type), intent(in) :: group  !< group of the input
      type(output_settings_type), intent(inout) :: settings  !< settings with the default file
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(output_values) :: own

      call read_values(group, own, error)
      if (is_set(own%history_seconds)) own%history_interval = 0
      if (is_set(own%block_seconds)) own%block_interval = 0
      if (own%file == '') own%file = settings%file
      own%history_seconds = value_or(own%history_seconds, 0.0_wp)
      own%block_seconds = value_or(own%block_seconds, 0.0_wp)
      settings%output_values = own
   end subroutine read_output

   !> Check that an output interval is a multiple of fixed time steps.
   pure subroutine check_output_times(error, group, settings, stages)
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(group_type), intent(in) :: group                  !< group of the input
      type(output_settings_type), intent(in) :: settings     !< settings as read
      type(stage_type), intent(in) :: stages(:)  !< stages of the model, with fixed steps
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
               kind == 1))//' = '//to_text(seconds)//' is not a whole number of steps of '// &
               to_text(stages(s)%time_step)//' s; change one of them, or let steps end then '// &
               "by time_step_control = 'adaptive'")
         end do
      end do
   end subroutine check_output_times

end module dda_input_settings
