! SPDX-License-Identifier: GPL-3.0-or-later
!> Intensity of shaking of measured points: peak acceleration and velocity, Arias intensity and
!> spectral acceleration, computed from the samples, unfiltered and low-passed at the highest
!> frequency that the ground model resolves (`dda_resolved_band`).
module dda_point_intensity
   use dda_kinds, only: wp, pi
   use dda_low_pass, only: low_pass_type, pass
   use dda_response_spectrum, only: oscillators_type, response_spectrum_type, new_oscillators, &
      continue_motion
   implicit none
   private
   public :: intensity_type, new_intensity, add_motion, arias_intensity

   real(wp), parameter :: standard_gravity = 9.80665_wp  !< m/s²

   !> Shaking along one axis.
   type :: shaking_type
      real(wp) :: last_acceleration = 0.0_wp         !< acceleration at the last sample, m/s²
      real(wp) :: acceleration = 0.0_wp !< peak acceleration, m/s²
      real(wp) :: squared_integral = 0.0_wp      !< ∫a² dt so far, m²/s³
      type(response_spectrum_type) :: spectrum
   end type shaking_type

   !> Intensities of one point, along both axes.
   type :: intensity_type
      real(wp) :: time = 0.0_wp         !< time of the last sample, s
      real(wp) :: velocity(2) = 0.0_wp  !< largest absolute values, m/s
      type(oscillators_type) :: oscillators  !< of the spectra
      type(shaking_type) :: unfiltered(2)      !< shaking, unfiltered
      type(shaking_type) :: low_passed(2)      !< shaking, low-passed at the resolved frequency
      type(low_pass_type) :: filter(2)
   end type intensity_type

contains

   !> Intensity before the first sample.
   pure type(intensity_type) function new_intensity(frequency) result(intensity)
      real(wp), intent(in) :: frequency  !< frequency below which accelerations are reported, Hz

      intensity%oscillators = new_oscillators()
      intensity%filter = low_pass_type(frequency)
   end function new_intensity

   !> Add the next sample.
   pure subroutine add_motion(intensity, time, velocity, acceleration)
      type(intensity_type), intent(inout) :: intensity   !< intensity of the samples so far
      real(wp), intent(in) :: time                       !< time of the sample, s
      real(wp), intent(in) :: velocity(2)                !< m/s
      real(wp), intent(in) :: acceleration(2)            !< m/s²
      real(wp) :: time_step, filtered
      integer :: axis

      time_step = time - intensity%time
      do axis = 1, 2
         filtered = intensity%low_passed(axis)%last_acceleration
         if (time_step > 0.0_wp) call pass(intensity%filter(axis), acceleration(axis), time_step, &
            filtered)
         call add_acceleration(intensity%oscillators, intensity%unfiltered(axis), &
            acceleration(axis), time_step)
         call add_acceleration(intensity%oscillators, intensity%low_passed(axis), filtered, &
            time_step)
      end do
      intensity%velocity = max(intensity%velocity, abs(velocity))
      intensity%time = time
   end subroutine add_motion

   !> Add an acceleration to the intensity along one axis.
   pure subroutine add_acceleration(oscillators, shaking, acceleration, time_step)
      type(oscillators_type), intent(inout) :: oscillators  !< of the spectra
      type(shaking_type), intent(inout) :: shaking  !< shaking so far
      real(wp), intent(in) :: acceleration          !< m/s²
      real(wp), intent(in) :: time_step                  !< time since the last acceleration, s

      associate (last_value => shaking%last_acceleration)
         shaking%squared_integral = shaking%squared_integral + 0.5_wp*time_step*(last_value**2 + &
            acceleration**2)
         if (shaking%acceleration > 0.0_wp .or. abs(acceleration) > 0.0_wp) &
            call continue_motion(oscillators, shaking%spectrum, last_value, acceleration, time_step)
      end associate
      shaking%acceleration = max(shaking%acceleration, abs(acceleration))
      shaking%last_acceleration = acceleration
   end subroutine add_acceleration

   !> Arias intensity π/2g ∫a² dt, m/s.
   elemental real(wp) function arias_intensity(shaking)
      type(shaking_type), intent(in) :: shaking  !< shaking along an axis

      arias_intensity = 0.5_wp*pi/standard_gravity*shaking%squared_integral
   end function arias_intensity

end module dda_point_intensity
