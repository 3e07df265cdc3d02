! SPDX-License-Identifier: GPL-3.0-or-later
!> Integration and drift removal against closed forms, and that a, v and d never contradict.
module test_baseline
   use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
   use dda_kinds, only: wp, pi
   use dda_baseline, only: baseline_type, make_motion_curve, motion_curve_type, displacement_at, &
      velocity_at, acceleration_at
   use dda_record, only: record_type, read_record
   use dda_taper, only: cosine_taper
   use record_files, only: data_file, loma_prieta
   use testing, only: check, check_close, check_fails, check_no_error, error
   implicit none

   integer, parameter :: samples = 201
   real(wp), parameter :: step = 0.01_wp, duration = 2.0_wp, omega = 2.0_wp*pi
   type(baseline_type), parameter :: as_is = baseline_type(order=0, at_rest=.false.)
   type(baseline_type), parameter :: free_end = baseline_type(order=2, at_rest=.false.)
   type(motion_curve_type) :: curve

contains

   !> Piecewise linear accelerations are integrated exactly, between the samples too.
   subroutine constant_and_ramp()
      real(wp), parameter :: t = 1.2345_wp

      curve = made('acceleration', 3.0_wp + 0.0_wp*times(), as_is)
      call check_close(displacement_at(curve, t), 1.5_wp*t**2, 'displacement, constant', &
         relative=1.0e-13_wp)
      call check_close(velocity_at(curve, t), 3.0_wp*t, 'velocity, constant', relative=1.0e-13_wp)
      curve = made('acceleration', 6.0_wp*times(), as_is)
      call check_close(displacement_at(curve, t), t**3, 'displacement, ramp', relative=1.0e-13_wp)
      call check_close(velocity_at(curve, t), 3.0_wp*t**2, 'velocity, ramp', relative=1.0e-13_wp)
      call check_close(acceleration_at(curve, t), 6.0_wp*t, 'acceleration, ramp', &
         relative=1.0e-13_wp)
      curve = made('acceleration', 3.0_wp - 6.0_wp*times())
      call check_close(curve%displacement, 0.0_wp*times(), 'both are drift', absolute=1.0e-13_wp)
      curve = made('acceleration', 3.0_wp - 6.0_wp*times(), free_end)
      call check_close(curve%displacement, 0.0_wp*times(), 'both are drift, free end', &
         absolute=1.0e-13_wp)
   end subroutine constant_and_ramp

   !> The interpolation error of a sine is (ωh)²/12 of it.
   subroutine sine_of_accelerations()
      real(wp), parameter :: precision = (omega*step)**2/6.0_wp

      curve = made('acceleration', cos(omega*times()), as_is)
      call check_close(curve%velocity, sin(omega*times())/omega, 'velocity', relative=precision)
      call check_close(curve%displacement, (1.0_wp - cos(omega*times()))/omega**2, 'displacement', &
         relative=precision)
   end subroutine sine_of_accelerations

   subroutine an_offset_and_a_trend_leave_no_trace()
      type(motion_curve_type) :: clean, drifting
      real(wp) :: motion(samples)

      motion = sin(omega*times())*exp(-times())
      clean = made('acceleration', motion)
      drifting = made('acceleration', motion + 0.3_wp - 0.2_wp*times())
      call check_close(drifting%acceleration, clean%acceleration, 'acceleration', &
         absolute=1.0e-13_wp)
      call check_close(drifting%displacement, clean%displacement, 'displacement', &
         absolute=1.0e-13_wp)
      clean = made('acceleration', motion, free_end)
      drifting = made('acceleration', motion + 0.3_wp - 0.2_wp*times(), free_end)
      call check_close(drifting%displacement, clean%displacement, 'free end', absolute=1.0e-13_wp)
      clean = made('acceleration', motion, baseline_type(order=1, at_rest=.false.))
      drifting = made('acceleration', motion + 0.3_wp, baseline_type(order=1, at_rest=.false.))
      call check_close(drifting%displacement, clean%displacement, 'offset only', &
         absolute=1.0e-13_wp)
      call check(index(clean%method, 'least squares') > 0, clean%method)
   end subroutine an_offset_and_a_trend_leave_no_trace

   subroutine a_corrected_record_needs_no_correction()
      type(motion_curve_type) :: once, twice

      once = made('acceleration', sin(3.0_wp*times()) + 0.1_wp)
      twice = made('acceleration', once%acceleration)
      call check_close(twice%acceleration, once%acceleration, 'acceleration', absolute=1.0e-14_wp)
      once = made('velocity', sin(3.0_wp*times()) + 0.1_wp*times())
      twice = made('velocity', once%velocity)
      call check_close(twice%velocity, once%velocity, 'velocity', absolute=1.0e-14_wp)
   end subroutine a_corrected_record_needs_no_correction

   !> Velocity and acceleration are the central differences of displacement and velocity: at the
   !> samples, between them, and outside the record; for any record and correction.
   subroutine velocity_and_acceleration_are_derivatives()
      character(len=12), parameter :: quantity(3) = [character(len=12) :: 'acceleration', &
         'velocity', 'displacement']
      type(baseline_type), parameter :: baseline(3) = [baseline_type(), as_is, free_end]
      integer :: i, k

      do i = 1, size(quantity)
         do k = 1, size(baseline)
            call check_derivatives(made(trim(quantity(i)), 0.3_wp + sin(omega*times()) &
               + 0.2_wp*cos(17.0_wp*times()), baseline(k)), trim(quantity(i)))
         end do
      end do
   end subroutine velocity_and_acceleration_are_derivatives

   !> Four times in each interval, both ends, and as many times outside.
   subroutine check_derivatives(curve, quantity)
      type(motion_curve_type), intent(in) :: curve
      character(len=*), intent(in) :: quantity
      real(wp), parameter :: h = 1.0e-6_wp
      integer, parameter :: parts = 4, n = parts*(samples - 1)
      real(wp) :: jerk, t, d_rate(-n:2*n), v_rate(-n:2*n), velocity(-n:2*n), acceleration(-n:2*n)
      integer :: k

      ! Bounds the error of the differences, also across a sample, where the jerk jumps.
      jerk = maxval(matmul([6.0_wp, 24.0_wp*step, 60.0_wp*step**2], abs(curve%higher)))
      do k = -n, 2*n
         t = real(k, wp)*(step/real(parts, wp))
         if (k == n) t = curve%duration
         d_rate(k) = (displacement_at(curve, t + h) - displacement_at(curve, t - h))/(2.0_wp*h)
         v_rate(k) = (velocity_at(curve, t + h) - velocity_at(curve, t - h))/(2.0_wp*h)
         velocity(k) = velocity_at(curve, t)
         acceleration(k) = acceleration_at(curve, t)
      end do
      call check_close(d_rate(1:n - 1), velocity(1:n - 1), 'velocity from '//quantity, &
         absolute=h**2*jerk + 1.0e-8_wp)
      call check_close(v_rate(1:n - 1), acceleration(1:n - 1), 'acceleration from '//quantity, &
         absolute=h*jerk + 1.0e-6_wp)
      ! An end counts as inside: the difference across it is the mean of the limits.
      call check_close(d_rate([0, n]), 0.5_wp*(velocity([0, n]) + [0.0_wp, &
         curve%velocity_after]), 'ends, from '//quantity, &
         absolute=h*maxval(abs(curve%acceleration([1, samples]))) + h**2*jerk + 1.0e-8_wp)
      call check(all(velocity(:-1) == 0.0_wp .and. d_rate(:-1) == 0.0_wp .and. &
         acceleration(:-1) == 0.0_wp), 'zero before')
      call check(all(velocity(n + 1:) == curve%velocity_after .and. acceleration(n + 1:) &
         == 0.0_wp), 'steady after')
      call check_close(d_rate(n + 1:), velocity(n + 1:), 'steadily so far, from '//quantity, &
         absolute=1.0e-8_wp)
      call check(maxval(abs(velocity)) > 0.01_wp, 'it moves')
      call check_close(velocity(0:n:parts), curve%velocity, 'at the samples', absolute=1.0e-12_wp)
      t = 1.0_wp - 1.0e-12_wp
      call check_close([(velocity_at(curve, t*real(k, wp)*step), k=0, samples - 1)], &
         curve%velocity, 'no jump at a sample', absolute=1.0e-9_wp)
      call check_close([(acceleration_at(curve, t*real(k, wp)*step), k=0, samples - 1)], &
         curve%acceleration, 'nor of the acceleration', absolute=1.0e-11_wp*jerk + 1.0e-9_wp)
   end subroutine check_derivatives

   subroutine before_the_start_and_after_the_end()
      curve = made('acceleration', sin(5.0_wp*times()))
      call check_close(displacement_at(curve, -1.0_wp), 0.0_wp, 'nothing moves before')
      call check_close(velocity_at(curve, -1.0e-9_wp) + acceleration_at(curve, -1.0_wp), 0.0_wp, &
         'nor goes')
      call check_close(displacement_at(curve, 1.0e30_wp), curve%displacement(samples), 'held after')
      call check_close(velocity_at(curve, 1.0e30_wp) + acceleration_at(curve, 3.0_wp), 0.0_wp, &
         'at rest after')
      call check_close(velocity_at(curve, duration), 0.0_wp, 'no jump of the velocity', &
         absolute=1.0e-15_wp)
      call check_close(displacement_at(curve, duration), curve%displacement(samples), &
         'the last sample')
      call check(abs(curve%displacement(samples)) > 1.0e-3_wp, 'a displacement remains')
   end subroutine before_the_start_and_after_the_end

   !> With the velocity that is left, unless it is rounding or to be stopped.
   subroutine after_the_end()
      type(motion_curve_type) :: curve, continued
      real(wp), parameter :: push(samples) = 3.0_wp, later_time = duration + 2.0_wp
      type(baseline_type), parameter :: continuing = baseline_type(order=0, after_end='continue')
      real(wp) :: v, d

      curve = made('acceleration', push, as_is)
      v = 3.0_wp*duration
      d = 1.5_wp*duration**2
      call check_close(velocity_at(curve, later_time), v, 'goes on', relative=1.0e-14_wp)
      call check_close(displacement_at(curve, later_time), d + 2.0_wp*v, 'so far', &
         relative=1.0e-13_wp)
      call check_close(acceleration_at(curve, later_time), 0.0_wp, 'by itself')
      call check(.not. curve%ends_at_rest .and. index(curve%method, 'continues with') > 0, &
         curve%method)
      curve%start = 5.0_wp
      call check_close(displacement_at(curve, 5.0_wp + later_time), d + 2.0_wp*v, &
         'from its start', relative=1.0e-13_wp)
      curve = made('acceleration', push, baseline_type(order=0, after_end='hold'))
      call check_close([velocity_at(curve, later_time), displacement_at(curve, later_time)], &
         [0.0_wp, d], 'stopped where asked', relative=1.0e-13_wp)
      curve = made('acceleration', push)
      call check(curve%ends_at_rest .and. curve%velocity_after == 0.0_wp, 'at rest: held')
      call check_close(curve%removed, [v, d], 'all of it was drift', relative=1.0e-13_wp)
      curve = made('acceleration', times()**2)
      continued = made('acceleration', times()**2, baseline_type(after_end='continue'))
      call check(curve%velocity_after == 0.0_wp .and. abs(continued%velocity_after) > 1.0e-3_wp, &
         'the fit is free at its end')
      curve = made('velocity', sin(omega*times()) + 0.9e-4_wp*times()/duration, as_is)
      call check(curve%velocity_after == 0.0_wp, 'rounding is no velocity')
      curve = made('velocity', sin(omega*times()) + 1.1e-4_wp*times()/duration, as_is)
      call check_close(curve%velocity_after, 1.1e-4_wp, 'more is', relative=1.0e-9_wp)
      curve = made('displacement', times())
      call check(curve%velocity_after == 0.0_wp, 'a displacement ends at rest')
      call check_close(curve%cut_velocity, 1.0_wp, 'with a word', relative=1.0e-9_wp)
      curve = made('displacement', times(), continuing)
      call check_close(displacement_at(curve, later_time), later_time, 'or goes on', &
         relative=1.0e-9_wp)
      call check_close(velocity_at(curve, 0.0_wp), 0.0_wp, 'from rest')
   end subroutine after_the_end

   subroutine records_of_velocity()
      real(wp), parameter :: t = 0.7777_wp

      curve = made('velocity', times()**2, as_is)
      call check_close(displacement_at(curve, t), t**3/3.0_wp, 'a parabola is exact', &
         relative=1.0e-12_wp)
      call check_close(acceleration_at(curve, t), 2.0_wp*t, 'with its slope', relative=1.0e-12_wp)
      curve = made('velocity', sin(omega*times()), as_is)
      call check_close(curve%displacement, (1.0_wp - cos(omega*times()))/omega, 'sine', &
         absolute=1.0e-6_wp)
      call check_close(acceleration_at(curve, t), omega*cos(omega*t), 'its slope', &
         relative=1.0e-4_wp)
      curve = made('velocity', times() - 0.1_wp*times()**2)
      call check_close(curve%displacement, 0.0_wp*times(), 'drift is removed', absolute=1.0e-14_wp)
   end subroutine records_of_velocity

   subroutine records_of_displacement()
      real(wp), parameter :: t = 0.7777_wp

      curve = made('displacement', 2.0_wp + times()**2, as_is)
      call check_close(displacement_at(curve, t), t**2, 'a parabola is exact, and begins at zero', &
         relative=1.0e-12_wp)
      call check_close(velocity_at(curve, t), 2.0_wp*t, 'with its slope', relative=1.0e-10_wp)
      call check_close(acceleration_at(curve, t), 2.0_wp, 'and its bend', relative=1.0e-7_wp)
      curve = made('displacement', 1.0_wp - cos(omega*times()))
      call check_close(displacement_at(curve, t), 1.0_wp - cos(omega*t), 'sine', absolute=1.0e-6_wp)
      call check_close(velocity_at(curve, t), omega*sin(omega*t), 'its velocity', &
         relative=1.0e-5_wp)
      call check_close(acceleration_at(curve, t), omega**2*cos(omega*t), 'its acceleration', &
         relative=1.0e-3_wp)
      call check_close(velocity_at(curve, duration), 0.0_wp, 'at rest at the end', &
         absolute=1.0e-12_wp)
      call check(index(curve%method, 'no drift removed') > 0, curve%method)
   end subroutine records_of_displacement

   subroutine taper_and_scale()
      type(motion_curve_type) :: curve, twice
      real(wp) :: motion(samples)

      call check_close(cosine_taper(5, 1.0_wp), [0.0_wp, 0.5_wp, 1.0_wp, 0.5_wp, 0.0_wp], 'Hann', &
         absolute=1.0e-15_wp)
      call check_close(cosine_taper(5, 0.0_wp), [1.0_wp, 1.0_wp, 1.0_wp, 1.0_wp, 1.0_wp], 'none')
      call check_close(cosine_taper(9, 0.5_wp), [0.0_wp, 0.5_wp, 1.0_wp, 1.0_wp, 1.0_wp, 1.0_wp, &
         1.0_wp, 0.5_wp, 0.0_wp], 'half', absolute=1.0e-15_wp)
      motion = cos(omega*times())
      curve = made('acceleration', motion, baseline_type(order=0, taper=0.1_wp))
      call check_close(curve%acceleration([1, samples]), [0.0_wp, 0.0_wp], 'ends are zero')
      call check_close(curve%acceleration(100), motion(100), 'the middle is kept')
      curve = made('acceleration', motion)
      twice = made('acceleration', motion, baseline_type(scale=-2.0_wp))
      call check_close(twice%displacement, -2.0_wp*curve%displacement, 'scale', relative=1.0e-14_wp)
      call check(index(twice%method, 'scaled by -2') > 0, twice%method)
   end subroutine taper_and_scale

   !> The shortest records and every option: no division by zero, and rest at the end if requested.
   subroutine two_samples_and_a_few()
      character(len=12), parameter :: quantity(3) = [character(len=12) :: 'acceleration', &
         'velocity', 'displacement']
      real(wp), parameter :: samples(6) = [0.0_wp, 1.0_wp, -2.0_wp, 4.0_wp, 0.0_wp, 1.0_wp]
      integer :: i, n, order

      do i = 1, 3
         do n = 2, 6
            do order = 0, 2
               call make_motion_curve(curve, trim(quantity(i)), samples(:n), &
                  0.5_wp, error, baseline_type(order=order))
               call check_no_error(error, 'a short record')
               call check_close(displacement_at(curve, curve%duration), curve%displacement(n), &
                  'end', absolute=1.0e-12_wp)
            end do
         end do
      end do
   end subroutine two_samples_and_a_few

   !> The record of the project: its correction is within the known bounds.
   subroutine a_real_record()
      type(record_type) :: record

      call read_record(record, data_file(loma_prieta), 'auto', 'acceleration', '', error)
      call check_no_error(error, 'Loma Prieta')
      if (allocated(error)) return
      call make_motion_curve(curve, 'acceleration', record%values, record%time_step, error)
      call check_no_error(error, 'motion')
      call check(maxval(abs(curve%acceleration - record%values)) < 0.02_wp, &
         'the acceleration is hardly touched')
      call check_close(curve%velocity(7183), 0.0_wp, 'it ends at rest', absolute=1.0e-12_wp)
      call check(maxval(abs(curve%velocity)) < 1.0_wp, 'velocity of a strong earthquake')
      call check(maxval(abs(curve%displacement)) < 1.0_wp, 'displacement of a strong earthquake')
   end subroutine a_real_record

   subroutine requests_that_make_no_motion()
      real(wp), parameter :: samples(3) = [0.0_wp, 1.0_wp, 0.0_wp]

      call refused('jerk', samples, 0.1_wp, baseline_type(), 'jerk')
      call refused('acceleration', samples(:1), 0.1_wp, baseline_type(), '2 samples')
      call refused('acceleration', samples, 0.0_wp, baseline_type(), 'time step')
      call refused('acceleration', samples, 1.0e300_wp, baseline_type(), 'time step')
      call refused('acceleration', samples, 0.1_wp, baseline_type(order=3), 'order')
      call refused('acceleration', samples, 0.1_wp, baseline_type(taper=1.5_wp), 'taper')
      call refused('displacement', samples, 0.1_wp, baseline_type(taper=0.1_wp), 'tapered')
      call refused('acceleration', samples, 0.1_wp, baseline_type(scale=1.0e300_wp), 'factor')
      call refused('acceleration', samples*1.0e300_wp, 0.1_wp, baseline_type(), 'beyond')
      call refused('acceleration', [0.0_wp, ieee_value(0.0_wp, ieee_quiet_nan)], 0.1_wp, &
         baseline_type(), 'finite')
   end subroutine requests_that_make_no_motion

   subroutine refused(quantity, values, time_step, baseline, names)
      character(len=*), intent(in) :: quantity, names
      real(wp), intent(in) :: values(:), time_step
      type(baseline_type), intent(in) :: baseline

      call make_motion_curve(curve, quantity, values, time_step, error, baseline)
      call check_fails(error, names)
   end subroutine refused

   function made(quantity, values, baseline) result(curve)
      character(len=*), intent(in) :: quantity
      real(wp), intent(in) :: values(:)
      type(baseline_type), intent(in), optional :: baseline
      type(motion_curve_type) :: curve

      call make_motion_curve(curve, quantity, values, step, error, baseline)
      call check_no_error(error, 'motion of '//quantity)
   end function made

   function times() result(time)
      real(wp) :: time(samples)
      integer :: i

      time = [(real(i - 1, wp)*step, i=1, samples)]
   end function times

end module test_baseline
