! SPDX-License-Identifier: GPL-3.0-or-later
!> Acceleration response spectra of motions, computed in the order of the samples.
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
   public :: oscillators_type, response_spectra_type, motions, continue_motions, &
      find_spectral_accelerations, oscillator_peaks, low_passed_peaks

   real(wp), parameter :: damping = 0.05_wp
   real(wp), parameter :: min_period = 0.02_wp, max_period = 5.0_wp  !< periods, s
   integer, parameter :: periods = 80  !< number of periods of a spectrum, at equal ratios
   integer, parameter :: samples_per_period = 50        !< samples for a peak error below 0.2 %
   integer, parameter :: together = 8                   !< oscillators in one vector operation
   real(wp), parameter :: coarsest = 0.5_wp*max_period  !< longest step that resolves any period, s
   real(wp), parameter :: finest = 0.005_wp*min_period     !< step required by free vibration, s
   real(wp), parameter :: same_step = 1.0e-9_wp         !< relative difference: rounding of times
   real(wp), parameter :: small_step = 1.0e-2_wp !< |z| below which μ and ρ are computed from series

   integer, parameter :: motions = 4  !< motions whose spectra are computed together

   !> Factors of the oscillators, for any number of motions with the same step.
   !> Number 0 is the low-pass, which has the highest frequency.
   type :: oscillators_type
      real(wp) :: step = 0.0_wp                         !< step of the factors, s
      integer :: parts(0:periods) = 1                   !< parts into which a step is divided
      real(wp), dimension(0:periods, 2) :: decay = 0.0_wp, before = 0.0_wp, after = 0.0_wp
   end type oscillators_type

   !> States and peaks of the oscillators under each motion.
   type :: response_spectra_type
      real(wp) :: q(0:periods, 2, motions) = 0.0_wp    !< state, m/s; real and imaginary part
      real(wp) :: largest(0:periods, motions) = 0.0_wp !< largest |Im q| so far, m/s
   end type response_spectra_type

contains

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

   !> ω²/Im λ of all periods, 1/s: spectral acceleration/|Im q|.
   pure function weights() result(weight)
      real(wp) :: weight(0:periods)
      integer :: i

      do i = 0, periods
         weight(i) = 2.0_wp*pi/period(i)/sqrt(1.0_wp - damping_of(i)**2)
      end do
   end function weights

   !> Continue the motions, whose accelerations are linear between samples.
   !> A step longer than `coarsest` resolves no period and is skipped; its terms would be unbounded.
   pure subroutine continue_motions(oscillators, spectra, acceleration, time_step)
      type(oscillators_type), intent(inout) :: oscillators  !< factors; set for each new step
      type(response_spectra_type), intent(inout) :: spectra  !< spectra of the motions so far
      real(wp), intent(in) :: time_step(:)  !< [samples] time since the last sample, s; 0: skipped
      !> last sample before these, and these samples, m/s²
      real(wp), intent(in) :: acceleration(motions, 0:size(time_step))
      integer :: first, last

      first = 1
      do while (first <= size(time_step))
         last = first
         if (time_step(first) > 0.0_wp .and. time_step(first) <= coarsest) then
            if (.not. is_step(time_step(first))) call set_step(oscillators, time_step(first))
            do while (last < size(time_step))
               if (.not. is_step(time_step(last + 1))) exit
               last = last + 1
            end do
            call move_all(oscillators, spectra, acceleration(:, first - 1:last), last - first + 1)
         end if
         first = last + 1
      end do

   contains

      !> .true. if a time step is the step of the factors.
      pure logical function is_step(value)
         real(wp), intent(in) :: value  !< s

         is_step = abs(value - oscillators%step) <= same_step*value
      end function is_step
   end subroutine continue_motions

   !> Move all oscillators by a number of equal steps, if possible in groups with equal parts.
   !> Of short periods with many parts, too few have equal parts.
   pure subroutine move_all(by, spectra, acceleration, steps)
      type(oscillators_type), intent(in) :: by               !< factors of the step
      type(response_spectra_type), intent(inout) :: spectra  !< spectra of the motions so far
      integer, intent(in) :: steps                           !< number of steps
      real(wp), intent(in) :: acceleration(motions, 0:steps) !< m/s²
      real(wp) :: q(together, 2, motions), largest(together, motions)
      integer :: first, last, n, i, member(together)

      do first = 0, periods - 1
         if (group_size(by%parts(first:)) >= together/2) exit
      end do
      if (first > 0) call move_divided(by, spectra, first - 1, acceleration, steps)
      do while (first <= periods)
         n = group_size(by%parts(first:))
         last = first + n - 1
         member = [(min(i, last), i=first, first + together - 1)]
         q = spectra%q(member, :, :)
         largest = spectra%largest(member, :)
         call move_group(by%decay(member, :), by%before(member, :), by%after(member, :), &
            by%parts(first), acceleration, steps, q, largest)
         spectra%q(first:last, :, :) = q(:n, :, :)
         spectra%largest(first:last, :) = largest(:n, :)
         first = last + 1
      end do
   end subroutine move_all

   !> Number of oscillators, from the first one, that have equal parts and fit in a group.
   pure integer function group_size(parts)
      integer, intent(in) :: parts(:)  !< parts of a step, [oscillators], at least one

      group_size = 1
      do while (group_size < min(together, size(parts)))
         if (parts(group_size + 1) /= parts(1)) exit
         group_size = group_size + 1
      end do
   end function group_size

   !> Move a group by a number of equal steps.
   !> The states of the group remain in the registers of the processor during all steps.
   pure subroutine move_group(decay, before, after, parts, acceleration, steps, q, largest)
      real(wp), dimension(together, 2), intent(in) :: decay, before, after  !< factors of a part
      integer, intent(in) :: parts                           !< parts of each step
      integer, intent(in) :: steps                           !< number of steps
      real(wp), intent(in) :: acceleration(motions, 0:steps) !< m/s²
      real(wp), intent(inout) :: q(together, 2, motions)     !< states, m/s
      real(wp), intent(inout) :: largest(together, motions)  !< largest |Im q|, m/s
      real(wp) :: part_length, change, start, finish, next(2)
      integer :: step, part, m, i

      part_length = 1.0_wp/parts
      do step = 1, steps
         do part = 1, parts
            do m = 1, motions
               change = (acceleration(m, step) - acceleration(m, step - 1))*part_length
               start = acceleration(m, step - 1) + (part - 1)*change
               finish = acceleration(m, step - 1) + part*change
               do i = 1, together
                  next(1) = decay(i, 1)*q(i, 1, m) - decay(i, 2)*q(i, 2, m) + before(i, 1)*start &
                     + after(i, 1)*finish
                  next(2) = decay(i, 2)*q(i, 1, m) + decay(i, 1)*q(i, 2, m) + before(i, 2)*start &
                     + after(i, 2)*finish
                  q(i, :, m) = next
                  largest(i, m) = max(largest(i, m), abs(next(2)))
               end do
            end do
         end do
      end do
   end subroutine move_group

   !> Move the oscillators 0 … `most` by a number of steps, each of them divided into parts.
   pure subroutine move_divided(by, spectra, most, acceleration, steps)
      type(oscillators_type), intent(in) :: by               !< factors of the step
      type(response_spectra_type), intent(inout) :: spectra  !< spectra of the motions so far
      integer, intent(in) :: most                            !< last oscillator
      integer, intent(in) :: steps                           !< number of steps
      real(wp), intent(in) :: acceleration(motions, 0:steps) !< m/s²
      real(wp) :: change, start, finish, part_length(0:most), next(2)
      integer :: m, step, part, last, i

      part_length = 1.0_wp/by%parts(:most)
      do m = 1, motions
         do step = 1, steps
            last = most
            do part = 1, by%parts(0)
               do while (by%parts(last) < part)  ! longer periods need fewer parts
                  last = last - 1
               end do
               do i = 0, last
                  change = (acceleration(m, step) - acceleration(m, step - 1))*part_length(i)
                  start = acceleration(m, step - 1) + (part - 1)*change
                  finish = acceleration(m, step - 1) + part*change
                  next(1) = by%decay(i, 1)*spectra%q(i, 1, m) - by%decay(i, 2)*spectra%q(i, 2, m) &
                     + by%before(i, 1)*start + by%after(i, 1)*finish
                  next(2) = by%decay(i, 2)*spectra%q(i, 1, m) + by%decay(i, 1)*spectra%q(i, 2, m) &
                     + by%before(i, 2)*start + by%after(i, 2)*finish
                  spectra%q(i, :, m) = next
                  spectra%largest(i, m) = max(spectra%largest(i, m), abs(next(2)))
               end do
            end do
         end do
      end do
   end subroutine move_divided

   !> Set the factors of a step.
   pure subroutine set_step(oscillators, time_step)
      type(oscillators_type), intent(inout) :: oscillators  !< oscillators; their factors are set
      real(wp), intent(in) :: time_step  !< Δt, s
      complex(wp) :: decay, start_factor, end_factor
      integer :: i

      oscillators%step = time_step
      do i = 0, periods
         oscillators%parts(i) = ceiling(samples_per_period*time_step/period(i))
         call set_factors(eigenvalue_of(1.0_wp/period(i), damping_of(i)), &
            time_step*(1.0_wp/oscillators%parts(i)), decay, start_factor, end_factor)
         oscillators%decay(i, :) = parts_of(decay)
         oscillators%before(i, :) = parts_of(start_factor)
         oscillators%after(i, :) = parts_of(end_factor)
      end do
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
         last = first - 1 + group_size(parts(first:))
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

   !> Find the largest spectral accelerations and their periods, after the motions have ended.
   pure subroutine find_spectral_accelerations(oscillators, spectra, last, largest, at)
      type(oscillators_type), intent(in) :: oscillators   !< factors of the last step
      type(response_spectra_type), intent(in) :: spectra  !< spectra of the motions
      real(wp), intent(in) :: last(motions)      !< accelerations at the end, then zero, m/s²
      real(wp), intent(out) :: largest(motions)  !< largest spectral accelerations, m/s²
      real(wp), intent(out) :: at(motions)       !< their periods, s
      type(response_spectra_type) :: free
      type(oscillators_type) :: copy
      real(wp) :: value(0:periods)
      integer :: m

      free = spectra
      copy = oscillators
      if (copy%step > 0.0_wp) then
         call continue_motions(copy, free, reshape([last, 0.0_wp*last], [motions, 2]), [copy%step])
         if (copy%step < finest) call set_step(copy, finest)
         call vibrate_freely(copy, free)
      end if
      do m = 1, motions
         value = weights()*free%largest(:, m)
         largest(m) = maxval(value(1:))
         at(m) = period(maxloc(value(1:), 1))
      end do
   end subroutine find_spectral_accelerations

   !> Move each oscillator by its period without acceleration.
   !> |u| is largest in the first half of the period, because its later maxima decrease.
   pure subroutine vibrate_freely(oscillators, spectra)
      type(oscillators_type), intent(in) :: oscillators      !< factors of the step
      type(response_spectra_type), intent(inout) :: spectra  !< states and peaks
      real(wp) :: next(2)
      integer :: i, part, m

      do i = 0, periods
         associate (decay => oscillators%decay(i, :), q => spectra%q(i, :, :), &
            largest => spectra%largest(i, :))
            do part = 1, oscillators%parts(i)*ceiling(period(i)/oscillators%step)
               do m = 1, motions
                  next(1) = decay(1)*q(1, m) - decay(2)*q(2, m)
                  next(2) = decay(2)*q(1, m) + decay(1)*q(2, m)
                  q(:, m) = next
                  largest(m) = max(largest(m), abs(next(2)))
               end do
            end do
         end associate
      end do
   end subroutine vibrate_freely

   !> Largest accelerations after a low-pass at 50 Hz, m/s².
   pure function low_passed_peaks(spectra) result(peak)
      type(response_spectra_type), intent(in) :: spectra  !< spectra of the motions
      real(wp) :: peak(motions)
      real(wp) :: weight(0:periods)

      weight = weights()
      peak = weight(0)*spectra%largest(0, :)
   end function low_passed_peaks

end module dda_response_spectrum
