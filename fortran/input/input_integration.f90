! SPDX-License-Identifier: GPL-3.0-or-later
!> Time integration of &control: a scheme of `dda_scheme`, given by its name, by θ, or by a damping
!> ratio at a frequency.
module dda_input_integration
   use dda_kinds, only: wp, pi
   use dda_errors, only: error_type
   use dda_input_group, only: group_type, input_error, given, is_set, require
   use dda_scheme, only: scheme_type
   use dda_scheme_response, only: forced_damping, theta_for_damping
   use dda_settings, only: control_type
   use dda_text, only: quoted, to_text
   implicit none
   private
   public :: set_integration

contains

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
         call input_error(error, group, 'theta, damping_ratio and damping_frequency need '// &
         "integration = 'theta', not "//quoted(integration))
      settings%integration = integration
      settings%theta = theta
      if (is_set(ratio)) call match_damping(error, group, ratio, frequency, settings)
      call require(error, group, 'theta', [settings%theta])
      if (settings%dynamic_factor < 1.0_wp .and. any(integration == [character(len=14) :: &
         'midpoint', 'theta'])) call input_error(error, group, 'dynamic_factor = '// &
         to_text(settings%dynamic_factor)//" needs integration = 'dda' or 'backward_euler': "// &
         'static steps of other schemes overshoot')
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
         call input_error(error, group, 'damping_frequency = '//to_text(frequency)// &
         ' must lie between 0 and 1/(2 time_step) = '//to_text(0.5_wp/settings%time_step)//' Hz')
      if (allocated(error)) return
      settings%theta = theta_for_damping(ratio, omega, settings%time_step)
      if (settings%theta > 1.0_wp) call input_error(error, group, 'damping_ratio = '// &
         to_text(ratio)//' is not possible at '//to_text(frequency)//' Hz with time_step = '// &
         to_text(settings%time_step)//': at most '//to_text(forced_damping(scheme_type(1.0_wp, &
         1.0_wp), omega, settings%time_step))//', with theta = 1; try a larger time_step')
   end subroutine match_damping

end module dda_input_integration
