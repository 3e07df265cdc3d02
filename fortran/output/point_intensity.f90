! SPDX-License-Identifier: GPL-3.0-or-later
!> How strongly measured points were shaken: peak acceleration and velocity, Arias intensity and
!> spectral acceleration, from the samples as they are written.
module dda_point_intensity
   use dda_kinds, only: wp, pi
   use dda_response_spectrum, only: response_spectrum_type, new_response_spectrum, follow
   implicit none
   private
   public :: intensity_type, new_intensity, add_motion, main_axis, arias_intensity

   real(wp), parameter :: standard_gravity = 9.80665_wp  !< m/s²

   !> Intensities of one point, along both axes.
   type :: intensity_type
      real(wp) :: time = 0.0_wp                         !< of the last sample, s
      real(wp) :: last(2) = 0.0_wp                      !< acceleration then, m/s²
      real(wp) :: acceleration(2) = 0.0_wp              !< largest, m/s²
      real(wp) :: velocity(2) = 0.0_wp                  !< largest, m/s
      real(wp) :: squares(2) = 0.0_wp                   !< ∫a² dt, m²/s³
      type(response_spectrum_type) :: spectrum(2)
   end type intensity_type

contains

   !> Before the first sample.
   pure type(intensity_type) function new_intensity() result(intensity)

      intensity%spectrum = new_response_spectrum()
   end function new_intensity

   !> Take in a sample, in the order of the run.
   pure subroutine add_motion(intensity, time, velocity, acceleration)
      type(intensity_type), intent(inout) :: intensity   !< of the samples so far
      real(wp), intent(in) :: time                       !< of the sample, s
      real(wp), intent(in) :: velocity(2)                !< m/s
      real(wp), intent(in) :: acceleration(2)            !< m/s²
      real(wp) :: step
      integer :: axis

      step = time - intensity%time
      do axis = 1, 2
         associate (before => intensity%last(axis), after => acceleration(axis))
            intensity%squares(axis) = intensity%squares(axis) + 0.5_wp*step*(before**2 + after**2)
            if (intensity%acceleration(axis) > 0.0_wp .or. abs(after) > 0.0_wp) &
               call follow(intensity%spectrum(axis), before, after, step)
         end associate
      end do
      intensity%acceleration = max(intensity%acceleration, abs(acceleration))
      intensity%velocity = max(intensity%velocity, abs(velocity))
      intensity%last = acceleration
      intensity%time = time
   end subroutine add_motion

   !> The axis of the largest velocity: 1 x, 2 y.
   pure integer function main_axis(intensity)
      type(intensity_type), intent(in) :: intensity  !< of a point

      main_axis = maxloc(intensity%velocity, 1)
   end function main_axis

   !> π/2g ∫a² dt along an axis, m/s.
   pure real(wp) function arias_intensity(intensity, axis)
      type(intensity_type), intent(in) :: intensity  !< of a point
      integer, intent(in) :: axis                    !< 1 x, 2 y

      arias_intensity = 0.5_wp*pi/standard_gravity*intensity%squares(axis)
   end function arias_intensity

end module dda_point_intensity
