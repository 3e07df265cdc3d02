! SPDX-License-Identifier: GPL-3.0-or-later
!> Spectral amplification that an input requests, computed from the complete output.
module dda_site_response
   use dda_kinds, only: wp
   use dda_errors, only: error_type
   use dda_model, only: model_type
   use dda_output_reader, only: read_history
   use dda_settings, only: amplification_type
   use dda_spectrum, only: spectral_peak_type, amplification, find_peak
   use dda_text, only: to_text
   implicit none
   private
   public :: response_peak_type, find_amplification_peak, peak_text

   !> Peak of an amplification in an output.
   type :: response_peak_type
      type(spectral_peak_type) :: spectral  !< peak of the ratio of the spectra
      !> largest acceleration in the last 5 % of the surface history/peak of this history
      real(wp) :: residual_ratio = 0.0_wp
   end type response_peak_type

contains

   !> Find the peak of the ratio of the accelerations at two points of an output file.
   subroutine find_amplification_peak(file, request, peak, error)
      character(len=*), intent(in) :: file  !< complete output
      type(amplification_type), intent(in) :: request  !< points, axis, band (Hz)
      type(response_peak_type), intent(out) :: peak  !< frequency (Hz) and amplitude
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      real(wp), allocatable :: surface_motion(:), base_motion(:), frequency(:)
      complex(wp), allocatable :: ratio(:)
      real(wp) :: time_step

      call read_series(file, request%surface, request%axis, surface_motion, time_step, error)
      if (.not. allocated(error)) call read_series(file, request%base, request%axis, base_motion, &
         time_step, error)
      if (.not. allocated(error)) call amplification(surface_motion, base_motion, time_step, &
         frequency, ratio, error, request%padding)
      if (.not. allocated(error)) call find_peak(frequency, abs(ratio), request%lowest, &
         request%highest, peak%spectral, error)
      if (.not. allocated(error)) &
         peak%residual_ratio = &
         maxval(abs(surface_motion(size(surface_motion) - &
         size(surface_motion)/20:))) /max(maxval(abs(surface_motion)), tiny(1.0_wp))
   end subroutine find_amplification_peak

   !> Read the acceleration of a point along an axis, and the time between samples.
   subroutine read_series(file, point, axis, series, time_step, error)
      character(len=*), intent(in) :: file  !< complete output
      integer, intent(in) :: point, axis  !< number of the point; 1 x, 2 y
      real(wp), allocatable, intent(out) :: series(:)  !< [samples] m/s²
      real(wp), intent(out) :: time_step  !< Δt, s
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      real(wp), allocatable :: time(:)

      time_step = 0.0_wp
      call read_history(file, 'acceleration', [axis, point], time, series, error)
      if (.not. allocated(error)) time_step = time(size(time))/max(1, size(time) - 1)
   end subroutine read_series

   !> Text that states a peak in one line.
   pure function peak_text(model, request, peak) result(text)
      type(model_type), intent(in) :: model  !< model as read from the input
      type(amplification_type), intent(in) :: request  !< points, axis, band (Hz)
      type(response_peak_type), intent(in) :: peak  !< frequency (Hz) and amplitude
      character(len=:), allocatable :: text
      character(len=16) :: amplitude, frequency

      write (amplitude, '(f0.3)') peak%spectral%amplitude
      write (frequency, '(f0.4)') peak%spectral%frequency
      text = 'amplification '//trim(model%points(request%surface)%name)//'/'// &
         trim(model%points(request%base)%name)//' ("within"): '//trim(amplitude)//' at '// &
         trim(frequency)//' Hz (bin width '//to_text(peak%spectral%bin_width)//' Hz, '// &
         merge('peak interpolated)', 'peak at a bin)    ', peak%spectral%interpolated)
   end function peak_text

end module dda_site_response
