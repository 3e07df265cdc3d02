! SPDX-License-Identifier: GPL-3.0-or-later
!> Intensity of shaking of measured points: peak acceleration and velocity, Arias intensity and
!> spectral acceleration, computed from the samples, unfiltered and low-passed at the highest
!> frequency that the ground model resolves (`dda_resolved_band`).
module dda_point_intensity
   use dda_kinds, only: wp, pi
   use dda_low_pass, only: low_pass_type, pass
   use dda_response_spectrum, only: oscillators_type, response_spectra_type, motions, &
      continue_motions
   implicit none
   private
   public :: intensity_type, new_intensity, add_motion, arias_intensity, unfiltered, low_passed

   real(wp), parameter :: standard_gravity = 9.80665_wp  !< m/s²

   integer, parameter :: unfiltered(2) = [1, 2], low_passed(2) = [3, 4]  !< motions along x and y

   !> Intensities of one point, of the accelerations along both axes, unfiltered and low-passed at
   !> the resolved frequency.
   type :: intensity_type
      real(wp) :: time = 0.0_wp         !< time of the last sample, s
      real(wp) :: velocity(2) = 0.0_wp  !< largest absolute values, m/s
      real(wp) :: last_acceleration(motions) = 0.0_wp  !< accelerations at the last sample, m/s²
      real(wp) :: acceleration(motions) = 0.0_wp       !< peak accelerations, m/s²
      real(wp) :: squared_integral(motions) = 0.0_wp   !< ∫a² dt so far, m²/s³
      type(oscillators_type) :: oscillators  !< of the spectra
      type(response_spectra_type) :: spectra
      type(low_pass_type) :: filter(2)
   end type intensity_type

contains

   !> Intensity before the first sample.
   pure type(intensity_type) function new_intensity(frequency) result(intensity)
      real(wp), intent(in) :: frequency  !< frequency below which accelerations are reported, Hz

      intensity%filter = low_pass_type(frequency)
   end function new_intensity

   !> Add the next samples.
   pure subroutine add_motion(intensity, time, velocity, acceleration)
      type(intensity_type), intent(inout) :: intensity   !< intensity of the samples so far
      real(wp), intent(in) :: time(:)                    !< times, s [samples]
      real(wp), intent(in) :: velocity(:,:)              !< m/s [2, samples]
      real(wp), intent(in) :: acceleration(:,:)          !< m/s² [2, samples]
      real(wp) :: motion(motions, 0:size(time)), time_step(size(time))
      integer :: i, axis

      motion(:, 0) = intensity%last_acceleration
      do i = 1, size(time)
         time_step(i) = time(i) - intensity%time
         intensity%time = time(i)
         motion(unfiltered, i) = acceleration(:, i)
         motion(low_passed, i) = motion(low_passed, i - 1)
         if (time_step(i) > 0.0_wp) then
            do axis = 1, 2
               call pass(intensity%filter(axis), acceleration(axis, i), time_step(i), &
                  motion(low_passed(axis), i))
            end do
         end if
         intensity%squared_integral = intensity%squared_integral + 0.5_wp*time_step(i)* &
            (motion(:, i - 1)**2 + motion(:, i)**2)
         intensity%acceleration = max(intensity%acceleration, abs(motion(:, i)))
         intensity%velocity = max(intensity%velocity, abs(velocity(:, i)))
      end do
      if (any(intensity%acceleration > 0.0_wp)) call continue_motions(intensity%oscillators, &
         intensity%spectra, motion, time_step)
      intensity%last_acceleration = motion(:, size(time))
   end subroutine add_motion

   !> Arias intensities π/2g ∫a² dt, m/s.
   pure function arias_intensity(intensity) result(arias)
      type(intensity_type), intent(in) :: intensity  !< intensity of all samples
      real(wp) :: arias(motions)

      arias = 0.5_wp*pi/standard_gravity*intensity%squared_integral
   end function arias_intensity

end module dda_point_intensity
