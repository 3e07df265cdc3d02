! SPDX-License-Identifier: GPL-3.0-or-later
!> Conversion of a sampled record into a motion without drift.
!>
!> An offset of the accelerations, however small, grows with the square of time in the displacement.
!> The correction subtracts from the velocity a polynomial that vanishes at the start, fitted by
!> least squares.  Its order is at most two.  Order two removes an offset and a trend of the
!> acceleration, the usual instrument errors; its derivative is a straight line, so that the
!> corrected acceleration is still piecewise linear and integrates exactly.  With a higher
!> order the acceleration would not be piecewise linear, and the fit would remove long periods.
!>
!> By default the polynomial equals the velocity at the last sample, so that the corrected motion
!> ends at rest, at its last displacement.  If a final velocity remains, the motion continues at
!> this velocity, because a stop within one time step would be an impact.  A final velocity up to
!> 10⁻⁴ of the largest velocity counts as zero, because samples rounded to five digits leave about
!> 10⁻⁵ in the sum.  The acceleration of this stop is at most 10⁻⁴ PGV/Δt in one step; without it,
!> the motion would drift forever.  A displacement record ends at rest unless the motion is to
!> continue.  The acceleration may still jump at both ends; a cosine taper of the record before the
!> fit (an option) reduces these jumps.  The first sample of a velocity record is not changed: if
!> this velocity is not zero and the record is not tapered, the motion starts with a jump.
module dda_baseline
   use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
   use dda_kinds, only: wp
   use dda_errors, only: error_type, fail, error_input
   use dda_text, only: to_text, quoted
   use dda_taper, only: cosine_taper
   use dda_motion_curve, only: motion_curve_type, displacement_at, velocity_at, acceleration_at, &
      step_acceleration, join_accelerations, join_velocities, join_displacements
   implicit none
   private
   public :: baseline_type, make_motion_curve
   public :: motion_curve_type, displacement_at, velocity_at, acceleration_at, step_acceleration

   real(wp), parameter :: max_value = 1.0e12_wp  ! limit of values and times against overflow
   real(wp), parameter :: rest_ratio = 1.0e-4_wp  ! final/largest velocity that counts as zero

   !> Treatment of a record.
   type :: baseline_type
      integer :: order = 2  !< order of the polynomial removed from the velocity, 0 (none) to 2
      logical :: at_rest = .true.   !< the corrected velocity is zero at the last sample (order > 0)
      !> fraction of the record under a cosine taper, half at each end, 0 … 1
      real(wp) :: taper = 0.0_wp
      real(wp) :: scale = 1.0_wp    !< factor of the record
      !> 'continue': the final velocity is not corrected and continues; 'hold': the last
      !> displacement remains; '': a remaining final velocity continues
      character(len=8) :: after_end = ''
   end type baseline_type

contains

   !> Make a motion from a record.
   subroutine make_motion_curve(curve, quantity, values, time_step, error, baseline)
      type(motion_curve_type), intent(out) :: curve            !< curve; undefined after an error
      character(len=*), intent(in) :: quantity  !< 'acceleration', 'velocity' or 'displacement'
      real(wp), intent(in) :: values(:)                        !< m/s², m/s or m [samples]
      real(wp), intent(in) :: time_step                        !< Δt, s
      type(error_type), allocatable, intent(out) :: error      !< allocated if an argument is wrong
      type(baseline_type), intent(in), optional :: baseline  !< default: order 2, at rest, no taper
      type(baseline_type) :: processing

      if (present(baseline)) processing = baseline
      call check_arguments(quantity, values, time_step, processing, error)
      if (allocated(error)) return
      if (quantity == 'displacement') then
         call shift_displacement(curve, processing%scale*values, time_step, processing)
      else
         call integrate_rates(curve, quantity == 'velocity', processing%scale*values, time_step, &
            processing)
      end if
      call continue_velocity(curve, processing)
   end subroutine make_motion_curve

   !> Continue the motion at its final velocity, unless it ends at rest or its displacement is held.
   pure subroutine continue_velocity(curve, processing)
      type(motion_curve_type), intent(inout) :: curve  !< joined samples
      type(baseline_type), intent(in) :: processing        !< processing of the record
      real(wp) :: end_velocity

      end_velocity = curve%velocity(size(curve%velocity))
      curve%ends_at_rest = .not. abs(end_velocity) > rest_ratio*maxval(abs(curve%velocity))
      if (ends_at_rest(processing) .and. processing%order > 0) curve%ends_at_rest = .true.
      if (processing%after_end == 'hold' .or. curve%ends_at_rest) return
      curve%velocity_after = end_velocity
      curve%method = curve%method//'; after the end it continues with '//to_text(end_velocity)// &
         ' m/s'
   end subroutine continue_velocity

   !> .true. if the corrected velocity is zero at the last sample.
   pure logical function ends_at_rest(processing)  ! total
      type(baseline_type), intent(in) :: processing  !< processing of the record

      ends_at_rest = processing%at_rest .and. processing%after_end /= 'continue'
   end function ends_at_rest

   !> Make a motion from accelerations or velocities, without drift.
   !> Accelerations are integrated, their drift is removed, and the result is integrated again.
   !> The fitted drift is subtracted from velocities, which are then joined by cubics.
   subroutine integrate_rates(curve, is_velocity, values, time_step, processing)
      type(motion_curve_type), intent(out) :: curve  !< complete motion
      logical, intent(in) :: is_velocity         !< else acceleration
      real(wp), intent(in) :: values(:)          !< m/s or m/s² [samples]
      real(wp), intent(in) :: time_step          !< Δt, s
      type(baseline_type), intent(in) :: processing  !< processing of the record
      real(wp) :: corrected(size(values)), drift(2)
      character(len=:), allocatable :: method

      corrected = values
      method = 'accelerations joined by straight lines and integrated exactly'
      if (is_velocity) method = 'velocities joined by cubics with continuous acceleration and '// &
         'integrated exactly'
      drift = 0.0_wp
      call apply_taper(corrected, processing, method)
      if (processing%order > 0 .and. is_velocity) then
         drift = fit_drift(corrected, processing)
         corrected = corrected - polynomial(drift, size(corrected))
      else if (processing%order > 0) then
         call join_accelerations(curve, corrected, time_step)
         drift = fit_drift(curve%velocity, processing)
         corrected = corrected - (drift(1) + 2.0_wp*drift(2)*unit_times(size(corrected))) &
            /(real(size(corrected) - 1, wp)*time_step)
      end if
      if (is_velocity) then
         call join_velocities(curve, corrected, time_step)
      else
         call join_accelerations(curve, corrected, time_step)
      end if
      curve%removed = largest_drift(drift, curve%duration)
      curve%method = scale_text(processing)//method// &
         drift_text(drift, curve%duration, processing)// &
         '; displacement at the end '//to_text(curve%displacement(size(corrected)))//' m'
   end subroutine integrate_rates

   !> Make a motion from displacements, shifted to start at zero.
   subroutine shift_displacement(curve, displacement, time_step, processing)
      type(motion_curve_type), intent(out) :: curve  !< complete motion
      real(wp), intent(in) :: displacement(:)    !< m [samples]
      real(wp), intent(in) :: time_step          !< Δt, s
      type(baseline_type), intent(in) :: processing  !< processing of the record
      character(len=:), allocatable :: method

      call join_displacements(curve, displacement - displacement(1), time_step, &
         processing%at_rest, ends_at_rest(processing))
      if (ends_at_rest(processing)) curve%cut_velocity = (displacement(size(displacement)) &
         - displacement(size(displacement) - 1))/time_step
      method = 'displacements joined by quintics with continuous acceleration'
      if (abs(displacement(1)) > 0.0_wp) method = method//', shifted by '// &
         to_text(-displacement(1))//' m so that it begins at zero'
      if (ends_at_rest(processing)) then
         method = method//', at rest at both ends'
      else if (processing%at_rest) then
         method = method//', at rest at the start'
      end if
      curve%method = scale_text(processing)//method//'; no drift removed'
   end subroutine shift_displacement

   !> Taper a series; if a baseline is removed, the mean is removed first.
   !> Otherwise the taper would turn the mean into a pulse.
   pure subroutine apply_taper(series, processing, method)
      real(wp), intent(inout) :: series(:)       !< [samples]
      type(baseline_type), intent(in) :: processing  !< processing of the record
      character(len=:), allocatable, intent(inout) :: method  !< report on the processing, extended

      if (.not. processing%taper > 0.0_wp) return
      if (processing%order > 0) then
         series = series - sum(series)/real(size(series), wp)
         method = method//', mean removed'
      end if
      series = series*cosine_taper(size(series), processing%taper)
      method = method//', cosine taper over '//to_text(50.0_wp*processing%taper)// &
         ' % of the length at each end'
   end subroutine apply_taper

   !> Fit the drift by least squares: v ≈ c₁ τ + c₂ τ², τ = t/T from 0 to 1.
   pure function fit_drift(velocity, processing) result(drift)
      real(wp), intent(in) :: velocity(:)      !< m/s
      type(baseline_type), intent(in) :: processing  !< processing of the record
      real(wp) :: drift(2)                     ! c₁, c₂ (m/s)
      real(wp) :: tau(size(velocity)), bow(size(velocity))
      integer :: n

      n = size(velocity)
      tau = unit_times(n)
      drift = 0.0_wp
      if (ends_at_rest(processing) .or. n < 3) then
         ! With c₁ + c₂ = v(T), one function remains free; it vanishes at both ends.
         drift(1) = velocity(n)
         if (processing%order < 2 .or. n < 3) return
         bow = tau**2 - tau
         drift(2) = dot_product(bow, velocity - velocity(n)*tau)/dot_product(bow, bow)
         drift(1) = drift(1) - drift(2)
      else if (processing%order == 1) then
         drift(1) = dot_product(tau, velocity)/dot_product(tau, tau)
      else
         drift = fit_parabola(tau, velocity)
      end if
   end function fit_drift

   !> Fit both c₁ and c₂ by least squares: two normal equations.
   pure function fit_parabola(tau, velocity) result(drift)
      real(wp), intent(in) :: tau(:), velocity(:)  !< t/T; m/s [samples]
      real(wp) :: drift(2)
      real(wp) :: square, cube, fourth, first, second, determinant

      square = sum(tau**2)
      cube = sum(tau**3)
      fourth = sum(tau**4)
      first = dot_product(tau, velocity)
      second = dot_product(tau**2, velocity)
      ! From 1/21 (n = 3) to 1/16 (long records) of the product of the diagonal: not singular.
      determinant = square*fourth - cube**2
      drift = [first*fourth - second*cube, second*square - first*cube]/determinant
   end function fit_parabola

   !> Largest |c₁ τ + c₂ τ²| and its largest integral, for τ from 0 to 1.
   pure function largest_drift(drift, duration) result(largest)
      real(wp), intent(in) :: drift(2), duration  !< c₁, c₂ (m/s); s
      real(wp) :: largest(2)                         ! m/s, m
      real(wp) :: tau(3), extremes(2)

      ! The ends of the record, and zeros of the derivatives: c₁ + 2 c₂ τ, c₁ + c₂ τ.
      extremes = 1.0_wp
      if (abs(drift(2)) > 0.0_wp) extremes = -drift(1)/[2.0_wp*drift(2), drift(2)]
      tau = [1.0_wp, min(max(extremes, 0.0_wp), 1.0_wp)]
      largest(1) = maxval(abs(tau*(drift(1) + tau*drift(2))))
      largest(2) = duration*maxval(abs(tau**2*(drift(1)/2.0_wp + tau*drift(2)/3.0_wp)))
   end function largest_drift

   !> Times t/T of the samples.
   pure function unit_times(count) result(tau)
      integer, intent(in) :: count             !< samples
      real(wp) :: tau(count)
      integer :: i

      tau = [(real(i - 1, wp)/real(count - 1, wp), i=1, count)]
   end function unit_times

   !> Polynomial c₁ τ + c₂ τ² at the samples.
   pure function polynomial(drift, count) result(velocity)
      real(wp), intent(in) :: drift(2)         !< c₁, c₂ (m/s)
      integer, intent(in) :: count             !< samples
      real(wp) :: velocity(count)              ! m/s

      velocity = unit_times(count)
      velocity = velocity*(drift(1) + velocity*drift(2))
   end function polynomial

   !> Text on the factor of the record; blank if it is 1.
   pure function scale_text(processing) result(text)
      type(baseline_type), intent(in) :: processing  !< processing of the record
      character(len=:), allocatable :: text

      text = ''
      if (abs(processing%scale - 1.0_wp) > 0.0_wp) text = 'scaled by '// &
         to_text(processing%scale)//'; '
   end function scale_text

   !> Text on the removed drift.
   pure function drift_text(drift, duration, processing) result(text)
      real(wp), intent(in) :: drift(2), duration !< c₁, c₂ (m/s); s
      type(baseline_type), intent(in) :: processing  !< processing of the record
      character(len=:), allocatable :: text

      text = '; no drift removed'
      if (processing%order == 0) return
      text = '; drift removed: velocity '//to_text(drift(1)/duration)//' t'
      if (processing%order > 1) text = text//' + '//to_text(drift(2)/duration**2)//' t² (m/s, s)'
      text = text//' by least squares'
      if (ends_at_rest(processing)) text = text//', to end at rest'
   end function drift_text

   !> Check the arguments of `make_motion_curve`.
   subroutine check_arguments(quantity, values, time_step, processing, error)
      character(len=*), intent(in) :: quantity   !< see `make_motion_curve`
      real(wp), intent(in) :: values(:)          !< [samples]
      real(wp), intent(in) :: time_step          !< Δt, s
      type(baseline_type), intent(in) :: processing  !< processing of the record
      type(error_type), allocatable, intent(out) :: error  !< message on the first invalid argument

      if (.not. any(quantity == [character(len=12) :: 'acceleration', 'velocity', &
         'displacement'])) then
         call fail(error, error_input, 'a motion cannot have the quantity '//quoted(quantity)// &
            '; use acceleration, velocity or displacement')
      else if (size(values) < 2) then
         call fail(error, error_input, 'a motion needs at least 2 samples, not '// &
            to_text(size(values)))
      else if (.not. (time_step > 1.0_wp/max_value .and. time_step < max_value/real(size(values), &
         wp))) then
         call fail(error, error_input, 'a motion needs a positive time step')
      else if (processing%order < 0 .or. processing%order > 2) then
         call fail(error, error_input, 'the order of the baseline is 0, 1 or 2, not '// &
            to_text(processing%order))
      else if (.not. (processing%taper >= 0.0_wp .and. processing%taper <= 1.0_wp)) then
         call fail(error, error_input, 'the taper fraction of a record must be between 0 and 1')
      else if (processing%taper > 0.0_wp .and. quantity == 'displacement') then
         call fail(error, error_input, 'a displacement cannot be tapered, because the taper '// &
            'would return it to its start')
      else if (.not. any(processing%after_end == [character(len=8) :: '', 'continue', 'hold'])) then
         call fail(error, error_input, 'after_end must be continue or hold, not '// &
            quoted(processing%after_end))
      else if (.not. abs(processing%scale) <= max_value) then
         call fail(error, error_input, 'the factor of a record is too large, or not a number')
      else if (.not. all(ieee_is_finite(values))) then
         call fail(error, error_input, 'a sample of the record is not a finite number')
      else if (maxval(abs(values)) > max_value) then
         call fail(error, error_input, 'a sample of '//to_text(maxval(abs(values)))// &
            ' is beyond any motion')
      end if
   end subroutine check_arguments

end module dda_baseline
