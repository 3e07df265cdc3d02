! SPDX-License-Identifier: GPL-3.0-or-later
!> Acceleration response spectra of motions, computed sample by sample.
!>
!> An oscillator u'' + 2ζω u' + ω² u = −a has, with λ = −ζω + iω√(1 − ζ²) and q = u' − λ̄ u, one
!> complex equation of first order, q' = λq − a.  For an acceleration that is linear between its
!> samples, the step h is exact [Nigam and Jennings 1969]:
!>
!>     q₁ = e^z q₀ − h [ρ a₁ + (μ − ρ) a₀],   z = λh,   μ = (e^z − 1)/z,   ρ = (μ − 1)/z .
!>
!> The pseudo-spectral acceleration is the largest ω²|u|, u = Im q/Im λ, also in the free vibration
!> after the motion.  Oscillators with few samples per period are also evaluated between samples.
!>
!> With ζ = 1/√2 and ω = 2π 50 Hz, ω²u is the acceleration after a Butterworth low-pass of second
!> order.  Impacts and ringing contacts act mostly above 50 Hz.
module dda_response_spectrum
   use dda_kinds, only: wp, pi
   implicit none
   private
   public :: oscillators_type, response_spectrum_type, periods, new_oscillators, continue_motion, &
      find_spectral_acceleration
   public :: oscillator_peaks, low_passed_peak

   real(wp), parameter :: damping = 0.05_wp
   real(wp), parameter :: min_period = 0.02_wp, max_period = 5.0_wp  !< periods, s
   integer, parameter :: periods = 80  !< number of periods of a spectrum, at equal ratios
   integer, parameter :: samples_per_period = 50        !< samples for a peak error below 0.2 %
   integer, parameter :: together = 8                   !< oscillators in one vector operation
   real(wp), parameter :: coarsest = 0.5_wp*max_period  !< longest step that resolves any period, s
   real(wp), parameter :: finest = 0.005_wp*min_period     !< step required by free vibration, s
   real(wp), parameter :: same_step = 1.0e-9_wp         !< relative difference: rounding of times
   real(wp), parameter :: small_step = 1.0e-2_wp !< |z| below which μ and ρ are computed from series

   !> Factors of the oscillators, for any number of motions with the same step.
   !> Number 0 is the low-pass, which has the highest frequency.
   type :: oscillators_type
      real(wp) :: step = 0.0_wp                         !< step of the factors, s
      integer :: parts(0:periods) = 1                   !< parts into which a step is divided
      real(wp) :: part_length(0:periods) = 1.0_wp       !< length of a part/step
      integer :: last_divided = 0  !< last oscillator with more than one part
      real(wp), dimension(0:periods, 2) :: decay = 0.0_wp, before = 0.0_wp, after = 0.0_wp
      real(wp) :: weight(0:periods) = 0.0_wp            !< ω²/Im λ, 1/s
   end type oscillators_type

   !> States and peaks of the oscillators under one motion.
   type :: response_spectrum_type
      real(wp), dimension(0:periods, 2) :: q = 0.0_wp   !< state, m/s; real and imaginary part
      real(wp) :: largest(0:periods) = 0.0_wp           !< largest value so far, m/s²
   end type response_spectrum_type

contains

   !> Create oscillators without a step.
   pure type(oscillators_type) function new_oscillators() result(oscillators)
      integer :: i

      do i = 0, periods
         oscillators%weight(i) = 2.0_wp*pi/period(i)/sqrt(1.0_wp - damping_of(i)**2)
      end do
   end function new_oscillators

   !> Period of oscillator i, s.
   pure real(wp) function period(i)
      integer, intent(in) :: i  !< 0 … `periods`

      period = min_period*(max_period/min_period)**(real(max(i, 1) - 1, wp)/(periods - 1))
   end function period

   !> Damping ratio of oscillator i.
   pure real(wp) function damping_of(i)
      integer, intent(in) :: i  !< 0 … `periods`

      damping_of = merge(sqrt(0.5_wp), damping, i == 0)
   end function damping_of

   !> Continue the motion from one acceleration to another, linearly.
   !> A step longer than `coarsest` resolves no period and is skipped; its terms would be unbounded.
   pure subroutine continue_motion(oscillators, spectrum, start_acceleration, end_acceleration, &
      time_step)
      type(oscillators_type), intent(inout) :: oscillators  !< factors; set for a new step
      type(response_spectrum_type), intent(inout) :: spectrum  !< spectrum of the motion so far
      real(wp), intent(in) :: start_acceleration, end_acceleration  !< m/s²
      real(wp), intent(in) :: time_step           !< time between them, s; 0: nothing is done
      real(wp) :: change, start, finish, q(2)
      integer :: i, last, division

      if (time_step <= 0.0_wp .or. time_step > coarsest) return
      if (abs(time_step - oscillators%step) > same_step*time_step) call set_step(oscillators, &
         time_step)
      last = periods
      associate (s => spectrum, by => oscillators)
         do division = 1, by%parts(1)
            if (division == 2) last = by%last_divided
            do while (by%parts(last) < division)  ! longer periods need fewer parts
               last = last - 1
            end do
            do i = 0, last
               change = (end_acceleration - start_acceleration)*by%part_length(i)
               start = start_acceleration + (division - 1)*change
               finish = start_acceleration + division*change
               q(1) = by%decay(i, 1)*s%q(i, 1) - by%decay(i, 2)*s%q(i, 2) + by%before(i, 1)*start &
                  + by%after(i, 1)*finish
               q(2) = by%decay(i, 2)*s%q(i, 1) + by%decay(i, 1)*s%q(i, 2) + by%before(i, 2)*start &
                  + by%after(i, 2)*finish
               s%q(i, :) = q
               s%largest(i) = max(s%largest(i), by%weight(i)*abs(q(2)))
            end do
         end do
      end associate
   end subroutine continue_motion

   !> Set the factors of a step.
   pure subroutine set_step(oscillators, time_step)
      type(oscillators_type), intent(inout) :: oscillators  !< oscillators; their factors are set
      real(wp), intent(in) :: time_step  !< Δt, s
      complex(wp) :: decay, start_factor, end_factor
      integer :: i

      oscillators%step = time_step
      do i = 0, periods
         oscillators%parts(i) = ceiling(samples_per_period*time_step/period(i))
         oscillators%part_length(i) = 1.0_wp/oscillators%parts(i)
         call set_factors(eigenvalue_of(1.0_wp/period(i), damping_of(i)), &
            time_step*oscillators%part_length(i), decay, start_factor, end_factor)
         oscillators%decay(i, :) = parts_of(decay)
         oscillators%before(i, :) = parts_of(start_factor)
         oscillators%after(i, :) = parts_of(end_factor)
      end do
      oscillators%last_divided = count(oscillators%parts > 1) - 1
   end subroutine set_step

   !> λ = −ζω + iω√(1 − ζ²), 1/s.
   elemental complex(wp) function eigenvalue_of(frequency, damping_ratio)
      real(wp), intent(in) :: frequency      !< natural frequency, Hz
      real(wp), intent(in) :: damping_ratio  !< ζ, at least 0 and below 1

      eigenvalue_of = 2.0_wp*pi*frequency*cmplx(-damping_ratio, sqrt(1.0_wp - damping_ratio**2), wp)
   end function eigenvalue_of

   !> Compute the factors of a step: q₁ = decay q₀ + before a₀ + after a₁.
   elemental subroutine set_factors(eigenvalue, h, decay, start_factor, end_factor)
      complex(wp), intent(in) :: eigenvalue  !< λ, 1/s
      real(wp), intent(in) :: h              !< step, s
      complex(wp), intent(out) :: decay      !< e^z
      complex(wp), intent(out) :: start_factor     !< −h (μ − ρ), s
      complex(wp), intent(out) :: end_factor      !< −h ρ, s
      complex(wp) :: z, mean, ramp

      z = eigenvalue*h
      if (abs(z) < small_step) then
         ramp = 0.5_wp + z/6.0_wp*(1.0_wp + z/4.0_wp*(1.0_wp + z/5.0_wp*(1.0_wp + z/6.0_wp)))
         mean = 1.0_wp + z*ramp
      else
         mean = (exp(z) - 1.0_wp)/z
         ramp = (mean - 1.0_wp)/z
      end if
      decay = exp(z)
      start_factor = -h*(mean - ramp)
      end_factor = -h*ramp
   end subroutine set_factors

   !> Largest displacement, velocity (relative) and absolute acceleration of oscillators.
   !> They are initially at rest; their values are evaluated up to the last sample.
   pure function oscillator_peaks(acceleration, time_step, frequency, damping_ratio) result(peaks)
      real(wp), intent(in) :: acceleration(:)  !< acceleration of the ground, [samples], m/s²
      real(wp), intent(in) :: time_step             !< time between samples, s
      real(wp), intent(in) :: frequency(:)     !< natural frequencies, Hz
      real(wp), intent(in) :: damping_ratio    !< ζ, at least 0 and below 1
      real(wp) :: peaks(3, size(frequency))  !< m, m/s, m/s²
      real(wp) :: of_group(3, together)
      integer :: parts(size(frequency)), first, last, i

      parts = ceiling(samples_per_period*frequency*time_step)
      first = 1
      do while (first <= size(frequency))
         last = first
         do while (last < min(first + together - 1, size(frequency)))
            if (parts(last + 1) /= parts(first)) exit
            last = last + 1
         end do
         call find_group_peaks(acceleration, time_step, parts(first), eigenvalue_of( &
            frequency([(min(i, last), i=first, first + together - 1)]), damping_ratio), of_group)
         peaks(:, first:last) = of_group(:, :last - first + 1)
         first = last + 1
      end do
   end function oscillator_peaks

   !> The same of a group, whose oscillators are moved together in vector operations.
   pure subroutine find_group_peaks(acceleration, time_step, parts, eigenvalue, peaks)
      real(wp), intent(in) :: acceleration(:)  !< acceleration of the ground, [samples], m/s²
      real(wp), intent(in) :: time_step        !< time between samples, s
      integer, intent(in) :: parts             !< parts of each time step
      complex(wp), intent(in) :: eigenvalue(together)  !< λ, 1/s
      real(wp), intent(out) :: peaks(3, together)      !< m, m/s, m/s²
      complex(wp), dimension(together) :: decay, start_factor, end_factor
      real(wp), dimension(together, 2) :: by, before, after, q  ! real and imaginary parts
      real(wp), dimension(together) :: largest_u, largest_v, largest_a, drag, square
      real(wp) :: start, finish, change, next(2), u, v
      integer :: sample, part, i

      call set_factors(eigenvalue, time_step/parts, decay, start_factor, end_factor)
      by = reshape([decay%re, decay%im], shape(by))
      before = reshape([start_factor%re, start_factor%im], shape(before))
      after = reshape([end_factor%re, end_factor%im], shape(after))
      drag = -2.0_wp*eigenvalue%re
      square = abs(eigenvalue)**2
      q = 0.0_wp
      largest_u = 0.0_wp
      largest_v = 0.0_wp
      largest_a = 0.0_wp
      do sample = 2, size(acceleration)
         change = (acceleration(sample) - acceleration(sample - 1))/parts
         do part = 1, parts
            start = acceleration(sample - 1) + (part - 1)*change
            finish = acceleration(sample - 1) + part*change
            do i = 1, together
               next(1) = by(i, 1)*q(i, 1) - by(i, 2)*q(i, 2) + before(i, 1)*start &
                  + after(i, 1)*finish
               next(2) = by(i, 2)*q(i, 1) + by(i, 1)*q(i, 2) + before(i, 2)*start &
                  + after(i, 2)*finish
               q(i, :) = next
               u = next(2)/eigenvalue(i)%im
               v = next(1) + eigenvalue(i)%re*u
               largest_u(i) = max(largest_u(i), abs(u))
               largest_v(i) = max(largest_v(i), abs(v))
               largest_a(i) = max(largest_a(i), abs(square(i)*u + drag(i)*v))
            end do
         end do
      end do
      peaks = transpose(reshape([largest_u, largest_v, largest_a], [together, 3]))
   end subroutine find_group_peaks

   !> Real and imaginary parts.
   pure function parts_of(z) result(parts)
      complex(wp), intent(in) :: z  !< any
      real(wp) :: parts(2)

      parts = [z%re, z%im]
   end function parts_of

   !> Find the largest spectral acceleration and its period, after a motion has ended.
   elemental subroutine find_spectral_acceleration(oscillators, spectrum, last, largest, at)
      type(oscillators_type), intent(in) :: oscillators  !< factors of the last step
      type(response_spectrum_type), intent(in) :: spectrum  !< spectrum of a motion
      real(wp), intent(in) :: last      !< acceleration at the end, after which it is zero, m/s²
      real(wp), intent(out) :: largest  !< largest spectral acceleration, m/s²
      real(wp), intent(out) :: at       !< its period, s
      type(response_spectrum_type) :: free
      type(oscillators_type) :: copy
      real(wp) :: step
      integer :: i

      free = spectrum
      copy = oscillators
      call continue_motion(copy, free, last, 0.0_wp, copy%step)
      if (copy%step > 0.0_wp) then
         step = max(copy%step, finest)
         do i = 1, ceiling(max_period/step)
            call continue_motion(copy, free, 0.0_wp, 0.0_wp, step)
         end do
      end if
      largest = maxval(free%largest(1:))
      at = period(maxloc(free%largest(1:), 1))
   end subroutine find_spectral_acceleration

   !> Largest acceleration after a low-pass at 50 Hz, m/s².
   elemental real(wp) function low_passed_peak(spectrum)
      type(response_spectrum_type), intent(in) :: spectrum  !< spectrum of a motion

      low_passed_peak = spectrum%largest(0)
   end function low_passed_peak

end module dda_response_spectrum
