! SPDX-License-Identifier: GPL-3.0-or-later
!> The groups that appear once: &run, &control, &contact, &output.
module dda_input_settings
   use dda_kinds, only: wp, long
   use dda_errors, only: error_type
   use dda_input_group, only: place_type, input_error, check_read, require, require_list, &
      require_choice, value_or, unset, is_set, name_length
   use dda_input_integration, only: check_integration
   use dda_linear_solver, only: current_name
   use dda_settings, only: control_type, contact_settings_type, output_settings_type
   use dda_stage, only: stage_type
   use dda_text, only: to_text
   implicit none
   private
   public :: read_run, read_control, read_contact, read_output, check_output_times, count_steps, &
      require_analysis

   integer, parameter :: no_interval = -huge(1)  !< stands in an interval that is not given

contains

   !> &run: the title.
   subroutine read_run(group, place, run_title, error)
      character(len=*), intent(in) :: group  !< its text, on one line
      type(place_type), intent(in) :: place  !< of the group
      character(len=:), allocatable, intent(out) :: run_title  !< title of the run
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      character(len=256) :: title, message
      integer :: status
      namelist /run/ title

      title = ''
      read (group, nml=run, iostat=status, iomsg=message)
      call check_read(error, place, status, message)
      run_title = trim(title)
   end subroutine read_run

   !> &control: how the run is stepped.
   subroutine read_control(group, place, staged, settings, base_motion, error)
      character(len=*), intent(in) :: group  !< its text, on one line
      type(place_type), intent(in) :: place  !< of the group
      logical, intent(in) :: staged  !< the input has stages of its own
      type(control_type), intent(out) :: settings  !< defaults where the input is silent
      character(len=name_length), intent(out) :: base_motion(2)  !< names of motions, x and y
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      real(wp) :: time_step, duration, steps, least_time_step, dynamic_factor, &
         max_displacement_ratio, gravity(2), theta, damping_ratio, damping_frequency
      character(len=name_length) :: time_step_control, analysis, solver, base_motion_x, &
         base_motion_y, integration
      character(len=256) :: message
      integer :: status
      logical :: settle
      namelist /control/ time_step, duration, steps, least_time_step, dynamic_factor, &
         max_displacement_ratio, gravity, time_step_control, analysis, solver, base_motion_x, &
         base_motion_y, integration, theta, damping_ratio, damping_frequency, settle

      call leave_unset(time_step, duration, steps, least_time_step, theta, damping_ratio, &
         damping_frequency, gravity)
      dynamic_factor = settings%dynamic_factor
      max_displacement_ratio = settings%max_displacement_ratio
      settle = settings%settle
      time_step_control = 'fixed'
      analysis = ''
      solver = settings%solver
      base_motion_x = ''
      base_motion_y = ''
      integration = settings%integration
      read (group, nml=control, iostat=status, iomsg=message)
      call check_read(error, place, status, message)
      if (.not. is_set(least_time_step) .and. is_set(time_step)) &
         least_time_step = 1.0e-6_wp*time_step
      call require(error, place, 'time_step dynamic_factor max_displacement_ratio '// &
         'least_time_step', [time_step, dynamic_factor, max_displacement_ratio, least_time_step])
      if (any(is_set(gravity))) call require_list(error, place, 'gravity', gravity)
      solver = current_name(solver)
      call check_choices(error, place, solver, time_step_control, analysis)
      if (.not. staged) call count_steps(error, place, time_step, duration, steps)
      if (staged) call refuse_steps(error, place, duration, settle, steps)
      if (allocated(error)) return
      settings = control_type(time_step, value_or(duration, 0.0_wp), int(steps, long), &
         time_step_control == 'adaptive', least_time_step=least_time_step, gravity=merge( &
         gravity, 0.0_wp, is_set(gravity)), dynamic_factor=dynamic_factor, &
         max_displacement_ratio=max_displacement_ratio, plane_strain=analysis == 'plane_strain', &
         analysis_given=analysis /= '', solver=solver(:16), settle=settle)
      call check_integration(error, place, integration, theta, damping_ratio, damping_frequency, &
         settings)
      base_motion = [base_motion_x, base_motion_y]
   end subroutine read_control

   !> Words of &control that name one of a few things.
   pure subroutine check_choices(error, place, solver, time_step_control, analysis)
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(place_type), intent(in) :: place     !< of the group
      character(len=*), intent(in) :: solver, time_step_control, analysis  !< as read

      call require_choice(error, place, 'solver', solver)
      call require_choice(error, place, 'time_step_control', time_step_control)
      if (analysis /= '') call require_choice(error, place, 'analysis', analysis)
   end subroutine check_choices

   !> Where waves count, plane strain or plane stress is chosen: it decides on their velocities.
   pure subroutine require_analysis(error, place, control, what)
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(place_type), intent(in) :: place        !< of the group that asks for it
      type(control_type), intent(in) :: control    !< as read
      character(len=*), intent(in) :: what         !< about waves in that group

      if (.not. control%analysis_given) call input_error(error, place, what//' ask for a '// &
         "choice of analysis in &control: 'plane_strain' (ground, which goes on across the "// &
         "plane) or 'plane_stress' (a plate between free faces, with slower P waves)")
   end subroutine require_analysis

   !> Numbers that the input may leave out.
   pure subroutine leave_unset(a, b, c, d, e, f, g, h)
      real(wp), intent(out) :: a, b, c, d, e, f, g, h(2)  !< variables of a group

      a = unset
      b = unset
      c = unset
      d = unset
      e = unset
      f = unset
      g = unset
      h = unset
   end subroutine leave_unset

   !> Stages have steps of their own.
   subroutine refuse_steps(error, place, duration, settle, steps)
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(place_type), intent(in) :: place     !< of the group
      real(wp), intent(in) :: duration          !< s, or `unset`
      logical, intent(in) :: settle             !< as read
      real(wp), intent(inout) :: steps          !< as read, becomes 0

      if (is_set(duration) .or. is_set(steps) .or. settle) call input_error(error, place, &
         'with &stage groups, duration, steps and settle have no place here: each &stage '// &
         "has its own, and kind = 'static' settles")
      steps = 0.0_wp
   end subroutine refuse_steps

   !> The number of steps, from `steps` or from `duration`.
   subroutine count_steps(error, place, time_step, duration, steps)
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(place_type), intent(in) :: place  !< of the group
      real(wp), intent(in) :: time_step, duration  !< s, or `unset`
      real(wp), intent(inout) :: steps  !< `unset` if `duration` is given

      if (allocated(error)) return
      if (is_set(duration) .eqv. is_set(steps)) then
         call input_error(error, place, 'give either duration or steps')
         return
      end if
      if (is_set(duration)) then
         call require(error, place, 'duration', [duration])
         if (allocated(error)) return
         steps = anint(duration/time_step)
         if (steps < 1.0_wp) call input_error(error, place, &
            'duration = '//to_text(duration)//' is shorter than one time_step')
      end if
      call require(error, place, 'steps', [steps])
      if (steps /= aint(steps)) call input_error(error, place, 'steps = '//to_text(steps)// &
         ' must be a whole number')
   end subroutine count_steps

   !> &contact: springs and iteration.  A stiffness left out stays 0 and gets the model's default.
   subroutine read_contact(group, place, settings, error)
      character(len=*), intent(in) :: group  !< its text, on one line
      type(place_type), intent(in) :: place  !< of the group
      type(contact_settings_type), intent(out) :: settings  !< defaults where the input is silent
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      real(wp) :: normal_stiffness, shear_ratio, fixed_point_ratio, force_tolerance, &
         penetration_tolerance
      character(len=name_length) :: contact_rules
      integer :: max_iterations
      character(len=256) :: message
      integer :: status
      namelist /contact/ normal_stiffness, shear_ratio, fixed_point_ratio, force_tolerance, &
         max_iterations, penetration_tolerance, contact_rules

      normal_stiffness = unset
      shear_ratio = settings%shear_ratio
      fixed_point_ratio = settings%fixed_point_ratio
      force_tolerance = settings%force_tolerance
      contact_rules = 'consistent'
      penetration_tolerance = settings%penetration_tolerance
      max_iterations = settings%max_iterations
      read (group, nml=contact, iostat=status, iomsg=message)
      call check_read(error, place, status, message)

      if (is_set(normal_stiffness)) then
         call require(error, place, 'normal_stiffness', [normal_stiffness])
         settings%normal_stiffness = normal_stiffness
      end if
      call require(error, place, 'shear_ratio fixed_point_ratio force_tolerance '// &
         'penetration_tolerance max_iterations', [shear_ratio, fixed_point_ratio, &
         force_tolerance, penetration_tolerance, real(max_iterations, wp)])
      call require_choice(error, place, 'contact_rules', contact_rules)
      settings%shear_ratio = shear_ratio
      settings%fixed_point_ratio = fixed_point_ratio
      settings%force_tolerance = force_tolerance
      settings%original_rules = contact_rules == 'original'
      settings%penetration_tolerance = penetration_tolerance
      settings%max_iterations = max_iterations
   end subroutine read_contact

   !> &output: where and how often.
   subroutine read_output(group, place, settings, error)
      character(len=*), intent(in) :: group  !< its text, on one line
      type(place_type), intent(in) :: place  !< of the group
      type(output_settings_type), intent(inout) :: settings  !< with its defaults before
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      character(len=1024) :: file
      character(len=256) :: message
      integer :: history_interval, block_interval, checkpoint_interval, status
      real(wp) :: history_seconds, block_seconds, checkpoint_minutes
      namelist /output/ file, history_interval, block_interval, checkpoint_interval, &
         checkpoint_minutes, history_seconds, block_seconds

      file = ''
      history_interval = no_interval
      block_interval = no_interval
      history_seconds = unset
      block_seconds = unset
      checkpoint_interval = settings%checkpoint_interval
      checkpoint_minutes = settings%checkpoint_minutes
      read (group, nml=output, iostat=status, iomsg=message)
      call check_read(error, place, status, message)

      call require(error, place, 'checkpoint_interval checkpoint_minutes', &
         [real(wp) :: checkpoint_interval, checkpoint_minutes])
      call set_interval(error, place, 'history', history_interval, history_seconds, &
         settings%history_interval, settings%history_seconds)
      call set_interval(error, place, 'block', block_interval, block_seconds, &
         settings%block_interval, settings%block_seconds)
      if (file /= '') settings%file = trim(file)
      settings%checkpoint_interval = checkpoint_interval
      settings%checkpoint_minutes = checkpoint_minutes
   end subroutine read_output

   !> How often samples or frames are taken: by steps or by seconds, not both.
   pure subroutine set_interval(error, place, what, steps, seconds, interval, period)
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(place_type), intent(in) :: place     !< of the group
      character(len=*), intent(in) :: what      !< 'history' or 'block'
      integer, intent(in) :: steps              !< as read, or `no_interval`
      real(wp), intent(in) :: seconds           !< as read, s, or `unset`
      integer, intent(inout) :: interval        !< steps, with its default before; 0: by seconds
      real(wp), intent(inout) :: period         !< s, with its default before

      if (steps /= no_interval .and. is_set(seconds)) call input_error(error, place, &
         'give either '//what//'_interval, in steps, or '//what//'_seconds')
      if (steps /= no_interval) then
         call require(error, place, what//'_interval', [real(steps, wp)])
         interval = steps
      else if (is_set(seconds)) then
         call require(error, place, what//'_seconds', [seconds])
         interval = 0
         period = seconds
      end if
   end subroutine set_interval

   !> Steps that cannot be shortened must fit into an output interval.
   pure subroutine check_output_times(error, place, settings, stages)
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(place_type), intent(in) :: place                  !< of the group &output
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
               call input_error(error, place, trim(merge('history_seconds', 'block_seconds  ', &
               kind == 1))//' = '//to_text(seconds)//' is no whole number of time steps of '// &
               to_text(stages(s)%time_step)//' s; change one of them, or let steps end there '// &
               "by time_step_control = 'adaptive'")
         end do
      end do
   end subroutine check_output_times

end module dda_input_settings
