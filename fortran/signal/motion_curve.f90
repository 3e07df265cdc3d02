! SPDX-License-Identifier: GPL-3.0-or-later
!> A motion defined for all times: displacement, velocity and acceleration that are derivatives of
!> each other.
!>
!> Within each interval of the samples the displacement is one polynomial of degree five at most;
!> velocity and acceleration are its exact derivatives, so that all evaluations are consistent.
!> Before the first sample there is no motion; after the last one the motion continues with the
!> final velocity, or the displacement is constant.  At the first and the last sample, velocity and
!> acceleration have the limits from inside the record, and jump unless the record begins and ends
!> at rest; the velocity does not jump if the motion continues.
module dda_motion_curve
   use dda_kinds, only: wp
   implicit none
   private
   public :: motion_curve_type, displacement_at, velocity_at, acceleration_at, step_acceleration
   public :: join_accelerations, join_velocities, join_displacements

   !> Samples of a motion and their interpolation.
   type :: motion_curve_type
      real(wp) :: time_step = 0.0_wp           !< time between samples (s)
      real(wp) :: duration = 0.0_wp            !< time of the last sample (s) after the first
      real(wp) :: start = 0.0_wp               !< time of the first sample (s)
      real(wp), allocatable :: displacement(:) !< displacement at the samples (m) [samples]
      real(wp), allocatable :: velocity(:)     !< velocity at the samples (m/s) [samples]
      real(wp), allocatable :: acceleration(:) !< acceleration at the samples (m/s²) [samples]
      real(wp), allocatable :: higher(:,:)  !< coefficients of s³, s⁴, s⁵ (m/s³ …) [3, samples − 1]
      real(wp) :: velocity_after = 0.0_wp      !< velocity after the last sample (m/s)
      logical :: ends_at_rest = .true.         !< the final velocity is zero except for rounding
      !> velocity between the last two samples of a displacement that ends at rest (m/s)
      real(wp) :: cut_velocity = 0.0_wp
      real(wp) :: removed(2) = 0.0_wp          !< largest removed drift (m/s, m)
      character(len=:), allocatable :: method  !< processing of the record, for a report
   end type motion_curve_type

contains

   !> Displacement at any time (m), in O(1).
   pure function displacement_at(curve, time) result(displacement)
      type(motion_curve_type), intent(in) :: curve  !< joined samples
      real(wp), intent(in) :: time                  !< time, s
      real(wp) :: displacement
      integer :: i
      real(wp) :: s

      displacement = 0.0_wp
      if (time - curve%start > curve%duration) &
         displacement = curve%displacement(size(curve%displacement)) &
         + curve%velocity_after*(time - curve%start - curve%duration)
      call locate_time(curve, time, i, s)
      if (i == 0) return
      displacement = curve%displacement(i) + s*(curve%velocity(i) &
         + s*(0.5_wp*curve%acceleration(i) + s*(curve%higher(1, i) + s*(curve%higher(2, i) &
         + s*curve%higher(3, i)))))
   end function displacement_at

   !> Velocity at any time (m/s), in O(1).
   pure function velocity_at(curve, time) result(velocity)
      type(motion_curve_type), intent(in) :: curve  !< joined samples
      real(wp), intent(in) :: time                  !< time, s
      real(wp) :: velocity
      integer :: i
      real(wp) :: s

      velocity = 0.0_wp
      if (time - curve%start > curve%duration) velocity = curve%velocity_after
      call locate_time(curve, time, i, s)
      if (i == 0) return
      velocity = curve%velocity(i) + s*(curve%acceleration(i) + s*(3.0_wp*curve%higher(1, i) &
         + s*(4.0_wp*curve%higher(2, i) + s*5.0_wp*curve%higher(3, i))))
   end function velocity_at

   !> Acceleration at any time (m/s²), in O(1).
   pure function acceleration_at(curve, time) result(acceleration)
      type(motion_curve_type), intent(in) :: curve  !< joined samples
      real(wp), intent(in) :: time                  !< time, s
      real(wp) :: acceleration
      integer :: i
      real(wp) :: s

      acceleration = 0.0_wp
      call locate_time(curve, time, i, s)
      if (i == 0) return
      acceleration = curve%acceleration(i) + s*(6.0_wp*curve%higher(1, i) &
         + s*(12.0_wp*curve%higher(2, i) + s*20.0_wp*curve%higher(3, i)))
   end function acceleration_at

   !> Acceleration of a motion for a step, m/s².
   !> It is the value at a time within the step.  If the record ends within the step, it is the mean
   !> over the step.
   pure function step_acceleration(curve, from, to, time) result(acceleration)
      type(motion_curve_type), intent(in) :: curve  !< joined samples
      real(wp), intent(in) :: from, to              !< start and end of the step, s
      real(wp), intent(in) :: time                  !< time within the step, s
      real(wp) :: acceleration

      acceleration = acceleration_at(curve, time)
      if (from - curve%start < 0.0_wp .or. from - curve%start >= curve%duration .or. &
         to - curve%start <= curve%duration) return
      acceleration = (curve%velocity(size(curve%velocity)) - velocity_at(curve, from))/(to - from)
   end function step_acceleration

   !> Find the interval of a time, and the time since its first sample.
   pure subroutine locate_time(curve, time, i, s)
      type(motion_curve_type), intent(in) :: curve  !< joined samples
      real(wp), intent(in) :: time                  !< time, s
      integer, intent(out) :: i  !< number of the interval; 0 before and after the record
      real(wp), intent(out) :: s                    !< time since its first sample, s
      real(wp) :: since

      i = 0
      s = 0.0_wp
      since = time - curve%start
      if (.not. (since >= 0.0_wp .and. since <= curve%duration)) return
      i = min(int(since/curve%time_step) + 1, size(curve%higher, 2))
      s = since - real(i - 1, wp)*curve%time_step
   end subroutine locate_time

   !> Join accelerations by straight lines and integrate twice, exactly: the displacement is cubic.
   pure subroutine join_accelerations(curve, acceleration, time_step)
      type(motion_curve_type), intent(out) :: curve  !< joined samples
      real(wp), intent(in) :: acceleration(:)  !< m/s² [samples]
      real(wp), intent(in) :: time_step        !< Δt, s
      integer :: i, last

      call allocate_curve(curve, size(acceleration), time_step)
      curve%acceleration = acceleration
      last = size(acceleration)
      do i = 1, last - 1
         curve%velocity(i + 1) = curve%velocity(i) + 0.5_wp*time_step*(acceleration(i) &
            + acceleration(i + 1))
         curve%displacement(i + 1) = curve%displacement(i) + time_step*(curve%velocity(i) &
            + time_step*(2.0_wp*acceleration(i) + acceleration(i + 1))/6.0_wp)
      end do
      curve%higher(1, :) = (acceleration(2:) - acceleration(:last - 1))/(6.0_wp*time_step)
   end subroutine join_accelerations

   !> Join velocities by cubics with continuous slope and integrate them exactly.
   pure subroutine join_velocities(curve, velocity, time_step)
      type(motion_curve_type), intent(out) :: curve  !< joined samples
      real(wp), intent(in) :: velocity(:)      !< m/s [samples]
      real(wp), intent(in) :: time_step        !< Δt, s
      integer :: i
      real(wp) :: h, step, first, second

      h = time_step
      call allocate_curve(curve, size(velocity), h)
      curve%velocity = velocity
      curve%acceleration = first_derivatives(velocity, h)
      do i = 1, size(velocity) - 1
         step = (velocity(i + 1) - velocity(i))/h
         first = curve%acceleration(i)
         second = curve%acceleration(i + 1)
         ! v = v₀ + a₀ s + b s² + c s³ (Hermite), integrated term by term.
         curve%higher(1, i) = (3.0_wp*step - 2.0_wp*first - second)/(3.0_wp*h)
         curve%higher(2, i) = (first + second - 2.0_wp*step)/(4.0_wp*h**2)
         curve%displacement(i + 1) = curve%displacement(i) &
            + h*(0.5_wp*(velocity(i) + velocity(i + 1)) + h*(first - second)/12.0_wp)
      end do
   end subroutine join_velocities

   !> Join displacements by quintics with continuous velocity and acceleration.
   !>
   !> Velocity and acceleration at the samples are central differences of fourth order.
   pure subroutine join_displacements(curve, displacement, time_step, from_rest, to_rest)
      type(motion_curve_type), intent(out) :: curve  !< joined samples
      real(wp), intent(in) :: displacement(:)  !< m [samples]
      real(wp), intent(in) :: time_step        !< Δt, s
      logical, intent(in) :: from_rest         !< zero velocity and acceleration at the first sample
      logical, intent(in) :: to_rest           !< zero velocity and acceleration at the last sample
      integer :: i, last

      last = size(displacement)
      call allocate_curve(curve, last, time_step)
      curve%displacement = displacement
      curve%velocity = first_derivatives(displacement, time_step)
      curve%acceleration = second_derivatives(displacement, time_step)
      if (from_rest) curve%velocity(1) = 0.0_wp
      if (from_rest) curve%acceleration(1) = 0.0_wp
      if (to_rest) curve%velocity(last) = 0.0_wp
      if (to_rest) curve%acceleration(last) = 0.0_wp
      do i = 1, last - 1
         curve%higher(:, i) = quintic_coefficients(curve, i)
      end do
   end subroutine join_displacements

   !> Coefficients of s³, s⁴, s⁵ that match the displacement, velocity and acceleration at the end
   !> of an interval.
   pure function quintic_coefficients(curve, i) result(factor)
      type(motion_curve_type), intent(in) :: curve  !< curve; values at the samples are set
      integer, intent(in) :: i                      !< interval
      real(wp) :: factor(3)
      real(wp) :: h, d, v, a  ! values at the end minus the terms up to s², as displacements (m)

      h = curve%time_step
      d = curve%displacement(i + 1) - curve%displacement(i) - h*(curve%velocity(i) &
         + 0.5_wp*h*curve%acceleration(i))
      v = h*(curve%velocity(i + 1) - curve%velocity(i) - h*curve%acceleration(i))
      a = h**2*(curve%acceleration(i + 1) - curve%acceleration(i))
      factor(1) = (10.0_wp*d - 4.0_wp*v + 0.5_wp*a)/h**3
      factor(2) = (-15.0_wp*d + 7.0_wp*v - a)/h**4
      factor(3) = (6.0_wp*d - 3.0_wp*v + 0.5_wp*a)/h**5
   end function quintic_coefficients

   !> Allocate a curve at rest with a number of samples.
   pure subroutine allocate_curve(curve, count, time_step)
      type(motion_curve_type), intent(inout) :: curve  !< allocated, at rest
      integer, intent(in) :: count                     !< samples
      real(wp), intent(in) :: time_step                !< Δt, s

      curve%time_step = time_step
      curve%duration = real(count - 1, wp)*time_step
      allocate (curve%displacement(count), source=0.0_wp)
      allocate (curve%velocity(count), source=0.0_wp)
      allocate (curve%higher(3, count - 1), source=0.0_wp)
      curve%method = ''
   end subroutine allocate_curve

   !> First derivative at the samples, of fourth order inside.
   !> It is of second order at the two samples of each end.
   pure function first_derivatives(value, h) result(slope)
      real(wp), intent(in) :: value(:)         !< [samples]
      real(wp), intent(in) :: h                !< s
      real(wp) :: slope(size(value))
      integer :: i, n

      n = size(value)
      slope = (value(n) - value(1))/(real(n - 1, wp)*h)
      if (n < 3) return
      slope(1) = (4.0_wp*value(2) - 3.0_wp*value(1) - value(3))/(2.0_wp*h)
      slope(n) = (3.0_wp*value(n) - 4.0_wp*value(n - 1) + value(n - 2))/(2.0_wp*h)
      slope(2:n - 1) = (value(3:) - value(:n - 2))/(2.0_wp*h)
      do i = 3, n - 2
         slope(i) = (8.0_wp*(value(i + 1) - value(i - 1)) &
            - (value(i + 2) - value(i - 2)))/(12.0_wp*h)
      end do
   end function first_derivatives

   !> Second derivative at the samples, with the orders of `first_derivatives`; an end sample has
   !> the value of its neighbour.
   pure function second_derivatives(value, h) result(bend)
      real(wp), intent(in) :: value(:)         !< [samples]
      real(wp), intent(in) :: h                !< s
      real(wp) :: bend(size(value))
      integer :: i, n

      n = size(value)
      bend = 0.0_wp
      if (n < 3) return
      bend(2:n - 1) = (value(3:) - 2.0_wp*value(2:n - 1) + value(:n - 2))/h**2
      do i = 3, n - 2
         bend(i) = (16.0_wp*(value(i + 1) + value(i - 1)) - (value(i + 2) + value(i - 2)) &
            - 30.0_wp*value(i))/(12.0_wp*h**2)
      end do
      bend(1) = bend(2)
      bend(n) = bend(n - 1)
   end function second_derivatives

end module dda_motion_curve
