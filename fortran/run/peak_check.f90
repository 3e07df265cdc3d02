! SPDX-License-Identifier: GPL-3.0-or-later
!> Comparison of the amplification peak of a run with the exact transfer function of its equations.
!>
!> If no contact has changed its state and no material has a law, the run was linear, and the peak
!> of its spectral ratio must equal the peak of the transfer function (`dda_transfer`).  A
!> difference is reported with its likely cause.
module dda_peak_check
   use dda_kinds, only: wp
   use dda_errors, only: error_type
   use dda_linear_model, only: linear_model_type, linearise, unrelaxed
   use dda_ringing, only: ringing_type, find_ringing
   use dda_settings, only: amplification_type
   use dda_simulation, only: simulation_type
   use dda_site_response, only: response_peak_type
   use dda_text, only: to_text, short_text
   use dda_transfer, only: transfer_type, transfer_peak_type, prepare_transfer, transfer_peak
   implicit none
   private
   public :: check_peak

   real(wp), parameter :: max_difference = 0.02_wp   !< tolerance of amplitude and frequency
   real(wp), parameter :: died_out = 1.0e-3_wp  !< final/peak motion above which a note is added
   !> steps of ringing above which it is a likely cause
   real(wp), parameter :: long_ringing = 100.0_wp

contains

   !> Warning if the peak of a run is incorrect; blank if it is correct or cannot be compared.
   subroutine check_peak(simulation, request, peak, text)
      type(simulation_type), intent(in) :: simulation   !< simulation at the end of the run
      type(amplification_type), intent(in) :: request    !< points, axis, band (Hz)
      type(response_peak_type), intent(in) :: peak      !< peak found in the output
      character(len=:), allocatable, intent(out) :: text  !< blank if both peaks agree
      type(linear_model_type) :: linear
      type(transfer_type) :: transfer
      type(transfer_peak_type) :: exact
      type(error_type), allocatable :: error

      text = ''
      if (simulation%counters%changes > 0 .or. simulation%model%control%adaptive) return
      if (any(simulation%model%materials%has_law())) return
      call linearise(linear, simulation, 'present', error)
      if (.not. allocated(error)) call prepare_transfer(transfer, linear, [request%surface, &
         request%base], spread(request%axis, 1, 2), request%axis, request%highest, error)
      if (allocated(error)) return
      call transfer_peak(transfer, request%lowest, &
         min(request%highest, 0.499_wp/linear%time_step), exact)
      if (.not. exact%is_interior) return
      if (abs(peak%spectral%amplitude/exact%amplitude - 1.0_wp) <= max_difference .and. &
         abs(peak%spectral%frequency/exact%frequency - 1.0_wp) <= max_difference) return
      text = 'the exact peak of this linear model at this time step is '// &
         short_text(exact%amplitude)//' at '//short_text(exact%frequency)//' Hz: '// &
         likely_cause(linear, simulation, peak)
   end subroutine check_peak

   !> Text on likely causes of the difference from the exact peak, and on remedies.
   function likely_cause(linear, simulation, peak) result(text)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      type(simulation_type), intent(in) :: simulation  !< a run and its state
      type(response_peak_type), intent(in) :: peak  !< frequency (Hz) and amplitude
      character(len=:), allocatable :: text
      type(ringing_type) :: ringing
      type(linear_model_type) :: stiff
      type(error_type), allocatable :: error

      text = ''
      if (peak%residual_ratio > died_out) text = text//'; at the end of the run the motion is '// &
         'still '//short_text(100*peak%residual_ratio)//' % of its peak; try more steps'
      if (simulation%model%output%history_interval > 1) text = text//'; history_interval = '// &
         to_text(simulation%model%output%history_interval)//' skips steps, so '// &
         'high frequencies alias; try history_interval = 1'
      call unrelaxed(linear, stiff)
      call find_ringing(stiff, ringing, error)
      if (.not. allocated(error)) then
         if (ringing%steps > long_ringing) text = text//'; '//ringing%text//': try '//ringing%advice
      end if
      if (text == '') text = '; the base motion may be almost zero at this frequency'
      text = 'likely cause: '//text(3:)
   end function likely_cause

end module dda_peak_check
