! SPDX-License-Identifier: GPL-3.0-or-later
!> Spectra of series whose transforms are known, amplification by a known filter, peaks of known
!> curves.
module test_spectrum
   use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
   use dda_kinds, only: wp, pi
   use dda_spectrum, only: spectral_peak_type, compute_fourier_spectrum, amplification, find_peak
   use testing, only: check, check_close, check_fails, check_no_error, error
   implicit none

   real(wp), parameter :: step = 0.01_wp
   real(wp), allocatable :: frequency(:)
   complex(wp), allocatable :: spectrum(:)
   type(spectral_peak_type) :: peak

contains

   !> Whole cycles fall into one bin: |S| = A T/2.
   subroutine sine_and_constant()
      integer, parameter :: n = 200
      real(wp) :: expected(n/2 + 1)
      integer :: i

      call compute_fourier_spectrum([(5.0_wp + 3.0_wp*sin(2.0_wp*pi*8.0_wp*real(i, wp)/real(n, &
         wp)), i=0, n - 1)], step, frequency, spectrum, error)
      call check_no_error(error, 'spectrum')
      expected = 0.0_wp
      expected(1) = 5.0_wp*step*real(n, wp)
      expected(9) = 1.5_wp*step*real(n, wp)
      call check_close(abs(spectrum), expected, 'amplitudes', absolute=1.0e-13_wp)
      call check_close(frequency(9), 4.0_wp, 'frequency', relative=1.0e-15_wp)
      call check_close(frequency(n/2 + 1), 50.0_wp, 'Nyquist frequency', relative=1.0e-15_wp)
   end subroutine sine_and_constant

   !> With padding, against the sum that defines it; odd and prime lengths, with a taper.
   subroutine definition_as_a_sum()
      integer, parameter :: n = 31, padding = 3
      complex(wp) :: direct
      real(wp) :: x(n), weight
      integer :: i, k

      x = [(cos(0.37_wp*real(i, wp)**1.5_wp), i=1, n)]
      call compute_fourier_spectrum(x, step, frequency, spectrum, error, padding=padding, &
         taper=1.0_wp)
      call check_no_error(error, 'spectrum')
      call check(size(spectrum) == 47, 'number of bins')
      do k = 1, size(spectrum), 5
         direct = (0.0_wp, 0.0_wp)
         do i = 1, n
            weight = 0.5_wp*(1.0_wp - cos(2.0_wp*pi*real(i - 1, wp)/real(n - 1, wp)))
            direct = direct + step*weight*x(i)*exp(cmplx(0.0_wp, &
               -2.0_wp*pi*frequency(k)*step*real(i - 1, wp), wp))
         end do
         call check_close(abs(spectrum(k) - direct), 0.0_wp, 'bin', absolute=1.0e-14_wp)
      end do
   end subroutine definition_as_a_sum

   !> Parseval: Σ x² Δt = Δf Σ |S|² over both sides.
   subroutine parseval_theorem()
      integer, parameter :: n = 256
      real(wp) :: x(n), two_sided_sum
      integer :: i

      x = [(sin(0.01_wp*real(i, wp)**2), i=1, n)]
      call compute_fourier_spectrum(x, step, frequency, spectrum, error)
      call check_no_error(error, 'spectrum')
      two_sided_sum = sum(abs([spectrum, spectrum(2:n/2)])**2)
      call check_close(frequency(2)*two_sided_sum, step*sum(x**2), 'Parseval', relative=1.0e-13_wp)
   end subroutine parseval_theorem

   !> y(n) = x(n) + 2r cos θ y(n−1) − r² y(n−2): H = 1/(1 − 2r cos θ z⁻¹ + r² z⁻²), z = exp(iωΔt).
   subroutine known_filter()
      integer, parameter :: n = 4096
      real(wp), parameter :: r = 0.98_wp, theta = 0.3_wp
      complex(wp), allocatable :: ratio(:), recovered(:)
      real(wp) :: x(n), y(n), summit
      integer :: i

      x = 0.0_wp
      x(1:4) = [1.0_wp, -0.5_wp, 0.3_wp, 0.1_wp]
      y = x
      y(2) = x(2) + 2.0_wp*r*cos(theta)*y(1)
      do i = 3, n
         y(i) = x(i) + 2.0_wp*r*cos(theta)*y(i - 1) - r**2*y(i - 2)
      end do
      call amplification(y, x, step, frequency, ratio, error, padding=4)
      call check_no_error(error, 'amplification')
      if (allocated(error)) return
      allocate (recovered(size(frequency)))
      recovered(:) = exp(cmplx(0.0_wp, -2.0_wp*pi*frequency*step, wp))
      call check_close(abs(ratio - 1.0_wp/(1.0_wp - 2.0_wp*r*cos(theta)*recovered + &
         r**2*recovered**2)), 0.0_wp*frequency, 'transfer function', absolute=1.0e-10_wp)
      summit = acos((1.0_wp + r**2)/(2.0_wp*r)*cos(theta))
      call find_peak(frequency, abs(ratio), 1.0_wp, 20.0_wp, peak, error)
      call check_no_error(error, 'peak')
      call check_close(peak%frequency, summit/(2.0_wp*pi*step), 'its frequency', relative=1.0e-6_wp)
      call check_close(peak%amplitude, 1.0_wp/((1.0_wp - r**2)*sin(theta)), 'its height', &
         relative=1.0e-6_wp)
      call check_close(peak%bin_width, 1.0_wp/(4.0_wp*real(n, wp)*step), 'bin width', &
         relative=1.0e-12_wp)
   end subroutine known_filter

   !> Without motion of the base the ratio is 0, and nothing is divided by zero.
   subroutine silent_bins()
      integer, parameter :: n = 64
      complex(wp), allocatable :: ratio(:)
      real(wp) :: x(n)
      integer :: i

      x = [(cos(2.0_wp*pi*4.0_wp*real(i, wp)/real(n, wp)), i=0, n - 1)]
      call amplification(2.0_wp*x, x, step, frequency, ratio, error)
      call check_no_error(error, 'amplification')
      call check_close(abs(ratio(5)), 2.0_wp, 'where it moves', relative=1.0e-13_wp)
      call check_close(sum(abs(ratio)), 2.0_wp, 'and nowhere else', relative=1.0e-13_wp)
      call amplification(x, 0.0_wp*x, step, frequency, ratio, error)
      call check_fails(error, 'base')
      call amplification(x, x(2:), step, frequency, ratio, error)
      call check_fails(error, '64 and 63')
   end subroutine silent_bins

   subroutine parabola()
      integer, parameter :: n = 11
      real(wp) :: frequency(n), amplitude(n)
      integer :: i

      frequency = [(0.5_wp*real(i - 1, wp), i=1, n)]
      amplitude = 7.0_wp - 0.3_wp*(frequency - 2.1_wp)**2
      call find_peak(frequency, amplitude, 0.0_wp, 5.0_wp, peak, error)
      call check_close(peak%frequency, 2.1_wp, 'vertex', relative=1.0e-13_wp)
      call check_close(peak%amplitude, 7.0_wp, 'height', relative=1.0e-13_wp)
      call check(peak%interpolated .and. peak%bin == 5, 'bin')
      call find_peak(frequency, amplitude, 3.0_wp, 5.0_wp, peak, error)
      call check(.not. peak%interpolated, 'the flank of a peak outside the band is not a peak')
      call check_close(peak%frequency, 3.0_wp, 'its edge')
      call find_peak(frequency, 0.0_wp*frequency, 0.0_wp, 5.0_wp, peak, error)
      call check_no_error(error, 'flat')
      call check(.not. peak%interpolated, 'a flat spectrum has no vertex')
      call find_peak(frequency, amplitude, 2.1_wp, 2.2_wp, peak, error)
      call check_fails(error, 'no bin')
      call find_peak(frequency, amplitude(2:), 2.1_wp, 2.2_wp, peak, error)
      call check_fails(error, '11 and 10')
   end subroutine parabola

   !> The result is bit-identical for any address of the arrays.
   subroutine same_bits()
      integer, parameter :: n = 1000
      real(wp) :: x(n + 1)
      complex(wp), allocatable :: first(:), second(:)
      integer :: i

      x = [(sin(real(i, wp)**1.3_wp), i=1, n + 1)]
      call compute_fourier_spectrum(x(2:), step, frequency, first, error)
      call compute_fourier_spectrum([(x(i), i=2, n + 1)], step, frequency, second, error)
      call check(maxval(abs(first - second)) <= 0.0_wp, 'same bits')
   end subroutine same_bits

   subroutine requests_without_a_spectrum()
      real(wp), parameter :: samples(4) = [1.0_wp, 2.0_wp, 3.0_wp, 4.0_wp]

      call refused(samples(:1), step, 1, 0.0_wp, '2 samples')
      call refused(samples, 0.0_wp, 1, 0.0_wp, 'time step')
      call refused(samples, 1.0e-305_wp, 1, 0.0_wp, 'time step')
      call refused(samples, step, 0, 0.0_wp, 'padding')
      call refused(samples, step, huge(1), 0.0_wp, 'padding')
      call refused(samples, step, 1, -0.1_wp, 'taper')
      call refused(samples*1.0e200_wp, step, 1, 0.0_wp, 'too large')
      call refused([samples, ieee_value(0.0_wp, ieee_quiet_nan)], step, 1, 0.0_wp, 'finite')
   end subroutine requests_without_a_spectrum

   subroutine refused(series, time_step, padding, taper, names)
      real(wp), intent(in) :: series(:), time_step, taper
      integer, intent(in) :: padding
      character(len=*), intent(in) :: names

      call compute_fourier_spectrum(series, time_step, frequency, spectrum, error, padding, taper)
      call check_fails(error, names)
   end subroutine refused

end module test_spectrum
