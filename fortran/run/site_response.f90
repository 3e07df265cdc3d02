! SPDX-License-Identifier: GPL-3.0-or-later
!> Spectral amplification that an input requests, computed from the complete output.
module dda_site_response
   use dda_kinds, only: wp
   use dda_errors, only: error_type
   use dda_model, only: model_type
   use dda_output_reader, only: read_histories
   use dda_settings, only: amplification_type
   use dda_spectrum, only: spectral_peak_type, amplification, find_peak
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
      real(wp), allocatable :: time(:), motion(:,:), frequency(:)
      complex(wp), allocatable :: ratio(:)
      integer :: n

      call read_histories(file, 'acceleration', reshape([request%axis, request%surface, &
         request%axis, request%base], [2, 2]), time, motion, error)
      if (allocated(error)) return
      n = size(time)
      call amplification(motion(:, 1), motion(:, 2), time(n)/max(1, n - 1), frequency, ratio, &
         error, request%padding)
      if (.not. allocated(error)) call find_peak(frequency, abs(ratio), request%lowest, &
         request%highest, peak%spectral, error)
      if (.not. allocated(error)) peak%residual_ratio = maxval(abs(motion(n - n/20:, 1))) &
         /max(maxval(abs(motion(:, 1))), tiny(1.0_wp))
   end subroutine find_amplification_peak

   !> Text that states a peak in one line.
   pure function peak_text(model, request, peak) result(text)
      type(model_type), intent(in) :: model  !< model as read from the input
      type(amplification_type), intent(in) :: request  !< points, axis, band (Hz)
      type(response_peak_type), intent(in) :: peak  !< frequency (Hz) and amplitude
      character(len=:), allocatable :: text
      character(len=16) :: amplitude, frequency, bin_width

      write (amplitude, '(f16.3)') peak%spectral%amplitude
      write (frequency, '(f16.4)') peak%spectral%frequency
      write (bin_width, '(f16.6)') peak%spectral%bin_width
      text = 'amplification '//trim(model%points(request%surface)%name)//'/'// &
         trim(model%points(request%base)%name)//' ("within"): '//trim(adjustl(amplitude))// &
         ' at '//trim(adjustl(frequency))//' Hz (bin width '//trim(adjustl(bin_width))//' Hz, '// &
         merge('peak interpolated)', 'peak at a bin)    ', peak%spectral%interpolated)
   end function peak_text

end module dda_site_response
