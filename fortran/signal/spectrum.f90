! SPDX-License-Identifier: GPL-3.0-or-later
!> Fourier spectra of uniformly sampled series, their amplification, and its peak.
module dda_spectrum
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use dda_kinds, only: wp, long
   use dda_errors, only: error_type, fail, error_input, error_solver
   use dda_text, only: to_text
   use dda_fftw, only: transform_forward
   use dda_taper, only: cosine_taper
   implicit none
   private
   public :: spectral_peak_type, compute_fourier_spectrum, amplification, find_peak

   ! largest number of samples with padding; 3 GiB of work space
   integer(long), parameter :: longest_series = 134217728_long
   ! limit of samples, so that sums of products do not overflow
   real(wp), parameter :: largest_value = 1.0e100_wp

   !> The largest amplitude in a band of frequencies.
   type :: spectral_peak_type
      real(wp) :: frequency = 0.0_wp     !< Hz, interpolated
      real(wp) :: amplitude = 0.0_wp     !< interpolated, in the unit of the amplitudes
      integer :: bin = 0                 !< index of the highest bin in the spectrum
      real(wp) :: bin_frequency = 0.0_wp !< frequency of the highest bin, Hz
      real(wp) :: bin_width = 0.0_wp     !< distance of bins, Hz
      !> .false.: the highest bin is at an end of the band and its neighbour is higher or missing
      logical :: interpolated = .false.
   end type spectral_peak_type

contains

   !> One-sided Fourier spectrum S(f) = Δt Σ w(j) x(j) exp(−2πi f jΔt), without scaling.
   !> It is an estimate of the Fourier integral.
   subroutine compute_fourier_spectrum(series, time_step, frequency, spectrum, error, padding, &
      taper)
      real(wp), intent(in) :: series(:)                      !< x [samples]
      real(wp), intent(in) :: time_step                      !< Δt (s)
      real(wp), allocatable, intent(out) :: frequency(:)     !< 0 … 1/(2Δt) (Hz) [bins]
      complex(wp), allocatable, intent(out) :: spectrum(:)   !< S, unit of x times s [bins]
      type(error_type), allocatable, intent(out) :: error    !< allocated if an argument is wrong
      !> length with added zeros/length of the series, ≥ 1 (default 1)
      integer, intent(in), optional :: padding
      !> fraction of the length under the cosine taper, 0 … 1 (default 0)
      real(wp), intent(in), optional :: taper
      real(wp), allocatable :: padded(:)
      logical :: success
      integer :: bin

      call prepare_series(series, time_step, padded, error, padding, taper)
      if (allocated(error)) return
      allocate (spectrum(size(padded)/2 + 1), frequency(size(padded)/2 + 1))
      call transform_forward(padded, spectrum, success)
      if (.not. success) call fail(error, error_solver, 'FFTW lacks memory for '// &
         to_text(size(padded))//' samples')
      if (allocated(error)) return
      spectrum = time_step*spectrum
      do bin = 1, size(frequency)
         frequency(bin) = real(bin - 1, wp)/(real(size(padded), wp)*time_step)
      end do
   end subroutine compute_fourier_spectrum

   !> Ratio of the complex spectra of two motions, surface / base.
   !>
   !> Bins in which the base is below `min_ratio` of its largest bin are set to 0, since their ratio
   !> would contain only rounding errors.
   subroutine amplification(surface_motion, base_motion, time_step, frequency, ratio, error, &
      padding, taper)
      real(wp), intent(in) :: surface_motion(:), base_motion(:)  !< motions of one kind [samples]
      real(wp), intent(in) :: time_step                      !< Δt, s
      real(wp), allocatable, intent(out) :: frequency(:)     !< Hz [bins]
      complex(wp), allocatable, intent(out) :: ratio(:)      !< [bins]
      type(error_type), allocatable, intent(out) :: error    !< allocated if an argument is wrong
      integer, intent(in), optional :: padding               !< see `compute_fourier_spectrum`
      real(wp), intent(in), optional :: taper                !< see `compute_fourier_spectrum`
      real(wp), parameter :: min_ratio = 1.0e-10_wp
      complex(wp), allocatable :: surface_spectrum(:), base_spectrum(:)
      real(wp), allocatable :: magnitude(:)
      real(wp) :: floor

      if (size(surface_motion) /= size(base_motion)) call fail(error, error_input, &
         'amplification needs two series of equal length, not '//to_text(size(surface_motion))// &
         ' and '//to_text(size(base_motion)))
      if (allocated(error)) return
      call compute_fourier_spectrum(surface_motion, time_step, frequency, surface_spectrum, error, &
         padding, taper)
      if (.not. allocated(error)) call compute_fourier_spectrum(base_motion, time_step, frequency, &
         base_spectrum, error, padding, taper)
      if (allocated(error)) return
      magnitude = abs(base_spectrum)
      floor = min_ratio*maxval(magnitude)
      if (.not. floor > tiny(floor)) call fail(error, error_input, 'amplification needs a '// &
         'moving base, but its spectrum is zero')
      if (allocated(error)) return
      allocate (ratio(size(base_spectrum)), source=(0.0_wp, 0.0_wp))
      where (magnitude > floor) ratio = surface_spectrum/base_spectrum
   end subroutine amplification

   !> Find the largest amplitude between two frequencies.
   !>
   !> The vertex of the parabola through the highest bin and its two neighbours refines frequency
   !> and amplitude; zero padding to 4 times the length makes bins dense enough.
   subroutine find_peak(frequency, amplitude, lowest, highest, peak, error)
      real(wp), intent(in) :: frequency(:)                   !< evenly spaced, rising (Hz) [bins]
      real(wp), intent(in) :: amplitude(:)                   !< [bins]
      real(wp), intent(in) :: lowest, highest                !< limits of the band (Hz), included
      type(spectral_peak_type), intent(out) :: peak  !< frequency (Hz) and amplitude
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure

      if (size(frequency) /= size(amplitude) .or. size(frequency) < 2) call fail(error, &
         error_input, 'a peak needs equal numbers of frequencies and amplitudes, at least two '// &
         'of each, not '//to_text(size(frequency))//' and '//to_text(size(amplitude)))
      if (allocated(error)) return
      peak%bin = maxloc(amplitude, 1, frequency >= lowest .and. frequency <= highest)
      if (peak%bin == 0) call fail(error, error_input, 'no bin of the spectrum lies between '// &
         to_text(lowest)//' and '//to_text(highest)//' Hz')
      if (allocated(error)) return
      peak%bin_width = frequency(2) - frequency(1)
      peak%bin_frequency = frequency(peak%bin)
      peak%frequency = peak%bin_frequency
      peak%amplitude = amplitude(peak%bin)
      if (peak%bin > 1 .and. peak%bin < size(amplitude)) &
         call refine_peak(amplitude(peak%bin - 1:peak%bin + 1), peak)
   end subroutine find_peak

   !> Refine a peak by the vertex of the parabola through three bins, if the middle is highest.
   pure subroutine refine_peak(amplitude, peak)
      real(wp), intent(in) :: amplitude(3)
      type(spectral_peak_type), intent(inout) :: peak  !< frequency (Hz) and amplitude
      real(wp) :: curvature, shift

      curvature = amplitude(1) - 2.0_wp*amplitude(2) + amplitude(3)
      if (amplitude(2) < max(amplitude(1), amplitude(3)) .or. .not. curvature < 0.0_wp) return
      shift = 0.5_wp*(amplitude(1) - amplitude(3))/curvature
      peak%frequency = peak%bin_frequency + shift*peak%bin_width
      peak%amplitude = amplitude(2) - 0.25_wp*(amplitude(1) - amplitude(3))*shift
      peak%interpolated = .true.
   end subroutine refine_peak

   !> Taper and pad a series, after checking that it can be transformed.
   subroutine prepare_series(series, time_step, padded, error, padding, taper)
      real(wp), intent(in) :: series(:)                      !< [samples]
      real(wp), intent(in) :: time_step                      !< Δt, s
      real(wp), allocatable, intent(out) :: padded(:)        !< [padding × samples]
      type(error_type), allocatable, intent(out) :: error    !< allocated if an argument is wrong
      integer, intent(in), optional :: padding               !< see `compute_fourier_spectrum`
      real(wp), intent(in), optional :: taper                !< see `compute_fourier_spectrum`
      integer :: factor
      real(wp) :: fraction

      factor = 1
      if (present(padding)) factor = padding
      fraction = 0.0_wp
      if (present(taper)) fraction = taper
      call check_window(series, time_step, factor, fraction, error)
      if (allocated(error)) return
      allocate (padded(factor*size(series)), source=0.0_wp)
      padded(:size(series)) = series*cosine_taper(size(series), fraction)
   end subroutine prepare_series

   !> Check the arguments of a spectrum.
   subroutine check_window(series, time_step, padding, taper, error)
      real(wp), intent(in) :: series(:)                      !< [samples]
      real(wp), intent(in) :: time_step                      !< Δt, s
      real(wp), intent(in) :: taper                          !< see `compute_fourier_spectrum`
      integer, intent(in) :: padding                         !< see `compute_fourier_spectrum`
      type(error_type), allocatable, intent(out) :: error    !< allocated if an argument is wrong

      if (size(series) < 2) then
         call fail(error, error_input, 'a spectrum needs at least 2 samples, not '// &
            to_text(size(series)))
      else if (.not. (time_step > 1.0_wp/largest_value .and. time_step < largest_value)) then
         call fail(error, error_input, 'a spectrum needs a positive time step')
      else if (padding < 1 .or. int(padding, long)*size(series, kind=long) > longest_series) then
         call fail(error, error_input, 'a padding of '//to_text(padding)//' times '// &
            to_text(size(series))//' samples must be at least 1 time, and give at most '// &
            to_text(longest_series)//' samples')
      else if (.not. (taper >= 0.0_wp .and. taper <= 1.0_wp)) then
         call fail(error, error_input, 'the taper fraction of a series must be between 0 and 1')
      else if (.not. all(ieee_is_finite(series))) then
         call fail(error, error_input, 'a spectrum needs finite samples, but a sample is '// &
            'infinite or not a number')
      else if (maxval(abs(series)) > largest_value) then
         call fail(error, error_input, 'a sample of '//to_text(maxval(abs(series)))// &
            ' is too large for a spectrum')
      end if
   end subroutine check_window

end module dda_spectrum
