! SPDX-License-Identifier: GPL-3.0-or-later
!> Groups that appear once: &run, &control, &contact, &output, &stop.
!>
!> The time integration of &control and &stage is a scheme of `dda_scheme`, given by its name, by θ,
!> or by a damping ratio at a frequency.
module dda_input_settings
   use dda_kinds, only: wp, long, pi
   use dda_errors, only: error_type
   use dda_input_group, only: group_type, fail_input, given, require, value_or, is_set, &
      require_name, mark_names
   use dda_input_groups, only: control_values, output_values, read_values, stop_values
   use dda_settings, only: control_type, output_settings_type
   use dda_stage, only: stage_type
   use dda_text, only: to_text, quoted
   use dda_scheme, only: scheme_type
   use dda_scheme_response, only: forced_damping, theta_for_damping
   use dda_model, only: model_type, half_size
   implicit none
   private
   public :: read_control, read_output, check_output_times, count_steps, &
      require_analysis, set_integration, read_stop

   real(wp), parameter :: default_rest = 1.0e-6_wp  !< default displacement/larger side of the model

contains

   !> Read &control: the time stepping of the run.
   subroutine read_control(group, staged, settings, input, error)
      type(group_type), intent(in) :: group  !< group of the input
      logical, intent(in) :: staged  !< the input has groups &stage
      type(control_type), intent(out) :: settings  !< settings of the group
      type(control_values), intent(out) :: input   !< values of the group
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      call read_values(group, input, error)
      if (.not. staged) call count_steps(error, group, input%time_step, input%duration, input%steps)
      if (staged .and. (is_set(input%duration) .or. is_set(input%steps) .or. input%settle)) call &
         fail_input(error, group, 'with &stage groups, duration, steps and settle are not '// &
         "allowed here: each &stage has its own, and kind = 'static' settles")
      if (allocated(error)) return
      settings%control_values = input
      settings%duration = value_or(input%duration, 0.0_wp)
      settings%step_count = int(value_or(input%steps, 0.0_wp), long)
      settings%least_time_step = value_or(input%least_time_step, 1.0e-6_wp*input%time_step)
      settings%adaptive = input%time_step_control == 'adaptive'
      settings%plane_strain = input%analysis == 'plane_strain'
      settings%analysis_given = given(group, 'analysis')
      call set_integration(group, trim(input%integration), input%theta, input%damping_ratio, &
         input%damping_frequency, settings, error)
   end subroutine read_control

   !> Require that `analysis` is given, because wave velocities depend on it.
   pure subroutine require_analysis(error, group, control, subject)
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(group_type), intent(in) :: group        !< group of the input
      type(control_type), intent(in) :: control    !< settings as read
      character(len=*), intent(in) :: subject         !< text on the waves

      if (.not. control%analysis_given) call fail_input(error, group, subject//' require a '// &
         "choice of analysis in &control: 'plane_strain' (ground, which continues across the "// &
         "plane) or 'plane_stress' (a plate between free faces, with slower P waves)")
   end subroutine require_analysis

   !> Find the number of steps from `steps` or `duration`.
   subroutine count_steps(error, group, time_step, duration, steps)
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(group_type), intent(in) :: group  !< group of the input
      real(wp), intent(in) :: time_step, duration  !< s, or `unset`
      real(wp), intent(inout) :: steps  !< `unset` if `duration` is given

      if (allocated(error)) return
      if (is_set(duration) .eqv. is_set(steps)) call fail_input(error, group, &
         'give either `duration` or `steps`')
      if (allocated(error)) return
      if (is_set(duration)) then
         steps = anint(duration/time_step)
         if (steps < 1.0_wp) call fail_input(error, group, &
            'duration = '//to_text(duration)//' is shorter than one time_step')
         call require(error, group, 'steps', [steps])
      end if
   end subroutine count_steps

   !> Read &output: file and intervals.
   subroutine read_output(group, settings, error)
      type(group_type), intent(in) :: group  !< group of the input
      type(output_settings_type), intent(inout) :: settings  !< settings with the default file
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(output_values) :: input

      call read_values(group, input, error)
      if (is_set(input%history_seconds)) input%history_interval = 0
      if (is_set(input%block_seconds)) input%block_interval = 0
      if (input%file == '') input%file = settings%file
      input%history_seconds = value_or(input%history_seconds, 0.0_wp)
      input%block_seconds = value_or(input%block_seconds, 0.0_wp)
      settings%output_values = input
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
               call fail_input(error, group, trim(merge('history_seconds', 'block_seconds  ', &
               kind == 1))//' = '//to_text(seconds)//' is not a whole number of steps of '// &
               to_text(stages(s)%time_step)//' s; change one of them, or set '// &
               "time_step_control = 'adaptive', whose steps end at output times")
         end do
      end do
   end subroutine check_output_times

   !> Set the integration that a group requires; the settings contain Δt and the dynamic factor.
   subroutine set_integration(group, integration, theta, ratio, frequency, settings, error)
      type(group_type), intent(in) :: group          !< &control or &stage
      character(len=*), intent(in) :: integration    !< name of the scheme
      real(wp), intent(in) :: theta                  !< θ as given, or its default
      real(wp), intent(in) :: ratio, frequency       !< ratio and frequency, Hz, or `unset`
      type(control_type), intent(inout) :: settings  !< settings; integration and θ are set
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      if (allocated(error)) return
      if (integration /= 'theta' .and. (given(group, 'theta') .or. is_set(ratio))) &
         call fail_input(error, group, 'theta, damping_ratio and damping_frequency need '// &
         "integration = 'theta', not "//quoted(integration))
      settings%integration = integration
      settings%theta = theta
      if (is_set(ratio)) call match_damping(error, group, ratio, frequency, settings)
      call require(error, group, 'theta', [settings%theta])
      if (settings%dynamic_factor < 1.0_wp .and. any(integration == [character(len=14) :: &
         'midpoint', 'theta'])) call fail_input(error, group, 'dynamic_factor = '// &
         to_text(settings%dynamic_factor)//" needs integration = 'dda' or 'backward_euler', "// &
         'because static steps of other schemes overshoot')
   end subroutine set_integration

   !> Find θ for a damping ratio at a frequency and the Δt of the settings.
   subroutine match_damping(error, group, ratio, frequency, settings)
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(group_type), intent(in) :: group
      real(wp), intent(in) :: ratio
      real(wp), intent(in) :: frequency  !< Hz
      type(control_type), intent(inout) :: settings  !< settings of &control; θ is set
      real(wp) :: omega

      omega = 2.0_wp*pi*frequency
      if (omega*settings%time_step >= pi) &
         call fail_input(error, group, 'damping_frequency = '//to_text(frequency)// &
         ' must lie between 0 and 1/(2 time_step) = '//to_text(0.5_wp/settings%time_step)//' Hz')
      if (allocated(error)) return
      settings%theta = theta_for_damping(ratio, omega, settings%time_step)
      if (settings%theta > 1.0_wp) call fail_input(error, group, 'damping_ratio = '// &
         to_text(ratio)//' is not possible at '//to_text(frequency)//' Hz with time_step = '// &
         to_text(settings%time_step)//': at most '//to_text(forced_damping(scheme_type(1.0_wp, &
         1.0_wp), omega, settings%time_step))//', with theta = 1; try a larger time_step')
   end subroutine match_damping

   !> Read &stop; degrees are converted to radians.
   subroutine read_stop(group, model, error)
      type(group_type), intent(in) :: group       !< group of the input
      type(model_type), intent(inout) :: model    !< model with its blocks
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(stop_values) :: input

      call read_values(group, input, error)
      associate (settings => model%stop)
         allocate (settings%watched(model%blocks%n), source=.false.)
         call mark_names(input%blocks, 'blocks', model%block_names, group, settings%watched, error)
         if (input%reference /= '' .and. .not. allocated(error)) call require_name(error, group, &
            'reference', input%reference, model%block_names, 'block', settings%reference)
         associate (same => count(model%block_names == input%reference))
            if (settings%reference > 0 .and. same > 1) call fail_input(error, group, &
               'reference = '//quoted(input%reference)//' is the name of '//to_text(same)// &
               ' blocks; give one block a unique name')
         end associate
         if (allocated(error)) return
         if (settings%reference > 0) settings%watched(settings%reference) = .false.
         settings%displacement = value_or(input%displacement, 0.0_wp)
         settings%tilt = value_or(input%tilt, 0.0_wp)*pi/180.0_wp
         if (is_set(input%fallen)) settings%fallen = input%fallen
         settings%rest_time = value_or(input%rest_time, 0.0_wp)
         settings%rest_movement = value_or(input%rest_movement, &
            2*default_rest*half_size(model%blocks))
         if (settings%fallen > count(settings%watched)) call fail_input(error, group, &
            'fallen = '//to_text(settings%fallen)//': only '//to_text(count(settings%watched))// &
            ' blocks are selected')
      end associate
   end subroutine read_stop

end module dda_input_settings
