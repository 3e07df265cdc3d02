! SPDX-License-Identifier: GPL-3.0-or-later
!> Ground motions: records, spectra, oscillators under them.
module api_motions
   use, intrinsic :: iso_c_binding, only: c_double, c_double_complex, c_int
   use api_failure, only: check_size, error
   use dda_baseline, only: baseline_type, motion_curve_type, make_motion_curve
   use dda_record, only: record_type, read_record
   use dda_response_spectrum, only: oscillator_peaks
   use dda_spectrum, only: spectral_peak_type, compute_fourier_spectrum, amplification, find_peak
   implicit none
   private
   public :: read_ground_motion, spectrum_of, peak_of, oscillator_peaks_of

contains

   !> A record as acceleration, velocity and displacement [3, n] at its samples; n = 0 requires the
   !> size only. options: time step (s, or 0), drift order (-1: 2 for accelerations, else 0), taper,
   !> scale.
   subroutine read_ground_motion(file, form, quantity, unit, options, channel, n, samples, &
      time_step, motion, about)
      character(len=*), intent(in) :: file, form, quantity, unit
      real(c_double), intent(in) :: options(4)
      integer(c_int), intent(in) :: channel, n
      integer(c_int), intent(out) :: samples
      real(c_double), intent(out) :: time_step
      real(c_double), intent(out) :: motion(3, n)
      character(len=2048), intent(out) :: about
      type(record_type) :: record
      type(motion_curve_type) :: curve
      type(baseline_type) :: baseline

      call read_record(record, file, form, quantity, unit, error, options(1), channel)
      if (allocated(error)) return
      baseline%order = nint(options(2))
      if (baseline%order == -1) baseline%order = merge(2, 0, record%quantity == 'acceleration')
      baseline%taper = options(3)
      baseline%scale = options(4)
      call make_motion_curve(curve, record%quantity, record%values, record%time_step, error, &
         baseline)
      if (allocated(error)) return
      samples = size(curve%displacement)
      time_step = curve%time_step
      about = record%station//new_line('a')//record%description//new_line('a')//record%format// &
         new_line('a')//record%unit//new_line('a')//curve%method
      if (n > 0) call check_size(n, samples)
      if (n /= samples) return
      motion(1, :) = curve%acceleration
      motion(2, :) = curve%velocity
      motion(3, :) = curve%displacement
   end subroutine read_ground_motion

   !> One-sided Fourier spectrum of a series, or the ratio of it to that of a base (m = n; else 0),
   !> at padding*n/2 + 1 frequencies.
   subroutine spectrum_of(n, m, series, base, time_step, padding, taper, bins, frequency, spectrum)
      integer(c_int), intent(in) :: n, m, padding, bins
      real(c_double), intent(in) :: series(n), base(m), time_step, taper
      real(c_double), intent(out) :: frequency(bins)
      complex(c_double_complex), intent(out) :: spectrum(bins)
      real(c_double), allocatable :: f(:)
      complex(c_double_complex), allocatable :: s(:)

      if (m == 0) call compute_fourier_spectrum(series, time_step, f, s, error, padding, taper)
      if (m > 0) call amplification(series, base, time_step, f, s, error, padding, taper)
      if (.not. allocated(error)) call check_size(bins, size(f))
      if (allocated(error)) return
      frequency = f
      spectrum = s
   end subroutine spectrum_of

   !> Peak between two frequencies: frequency, amplitude, bin width, 1 if interpolated.
   subroutine peak_of(bins, frequency, amplitude, lowest, highest, peak)
      integer(c_int), intent(in) :: bins
      real(c_double), intent(in) :: frequency(bins), amplitude(bins), lowest, highest
      real(c_double), intent(out) :: peak(4)
      type(spectral_peak_type) :: found

      call find_peak(frequency, amplitude, lowest, highest, found, error)
      peak = [found%frequency, found%amplitude, found%bin_width, merge(1.0_c_double, 0.0_c_double, &
         found%interpolated)]
   end subroutine peak_of

   !> Largest displacement, velocity and absolute acceleration of oscillators under a motion.
   subroutine oscillator_peaks_of(n, acceleration, time_step, oscillators, frequency, damping, &
      largest)
      integer(c_int), intent(in) :: n, oscillators
      real(c_double), intent(in) :: acceleration(n), time_step, frequency(oscillators), damping
      real(c_double), intent(out) :: largest(3, oscillators)

      largest = oscillator_peaks(acceleration, time_step, frequency, damping)
   end subroutine oscillator_peaks_of

end module api_motions
