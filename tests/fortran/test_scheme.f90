! SPDX-License-Identifier: GPL-3.0-or-later
!> The closed forms of the time integration, against the recursion of one oscillator written down
!> again.
module test_scheme
   use dda_kinds, only: wp, pi
   use dda_scheme, only: scheme_type, scheme_named, step_type, end_rate, end_time, load_time, &
      mass_weight
   use dda_scheme_response, only: amplification_roots, oscillates, free_damping, &
      period_elongation, forced_damping, step_for_damping, theta_for_damping, steps_to_decay, &
      steady_type, steady_weights
   use eigenvalues, only: roots_of, distance_of
   use testing, only: case, check, check_close
   implicit none

   real(wp), parameter :: parameters(5) = [0.5_wp, 0.55_wp, 0.75_wp, 0.9_wp, 1.0_wp]
   real(wp), parameter :: resolutions(13) = [0.05_wp, 0.2_wp, 0.5_wp, 1.0_wp, 2.0_wp, 3.9_wp, &
      4.1_wp, 7.0_wp, 19.0_wp, 1.0e2_wp, 5.0e2_wp, 1.0e3_wp, 1.0e4_wp]
   real(wp), parameter :: omega = 30.0_wp   !< rad/s

contains

   subroutine every_member()
      integer :: i, j

      do i = 1, size(parameters)
         do j = 1, size(parameters)
            call free_vibration(scheme_type(parameters(i), parameters(j)))
            call steady_vibration(scheme_type(parameters(i), parameters(j)))
            call inverses(scheme_type(parameters(i), parameters(j)))
            call recursion(scheme_type(parameters(i), parameters(j)), 1.0_wp)
         end do
      end do
      call recursion(scheme_type(1.0_wp, 0.5_wp), 0.9_wp)
      call recursion(scheme_type(1.0_wp, 1.0_wp), 0.3_wp)
      call recursion(scheme_type(1.0_wp, 0.5_wp), 0.0_wp)
   end subroutine every_member

   subroutine members_by_name()
      type(step_type) :: step

      call check_member('dda', 1.0_wp, 0.5_wp)
      call check_member('midpoint', 0.5_wp, 0.5_wp)
      call check_member('theta', 0.6_wp, 0.6_wp)
      call check_member('backward_euler', 1.0_wp, 1.0_wp)
      step = step_type(scheme_type(0.75_wp, 0.8_wp), 3.0_wp, 0.1_wp)
      call check_close([end_time(step), load_time(step)], [3.1_wp, 3.075_wp], 'instants', &
         relative=1.0e-15_wp)
      call check_close(mass_weight(step), 125.0_wp, '1/(χΔt²)', relative=1.0e-14_wp)
      call check_close(0.1_wp*(0.2_wp*7.0_wp + 0.8_wp*end_rate(step, 2.0_wp, 7.0_wp)), 2.0_wp, &
         'd = Δt [(1 − χ) v₀ + χ v₁]', relative=1.0e-14_wp)
   end subroutine members_by_name

   subroutine check_member(name, theta, chi)
      character(len=*), intent(in) :: name
      real(wp), intent(in) :: theta, chi
      type(scheme_type) :: scheme

      scheme = scheme_named(name, 0.6_wp)
      call check(scheme%theta == theta .and. scheme%chi == chi, name)
   end subroutine check_member

   !> One step of (Ωq, Δt v) with m = 1, Δt = 1: v₁ − v₀ = −Ω² (q₀ + θd), d = (1 − χ) v₀ + χ v₁.
   pure function amplification(scheme, turn) result(matrix)
      type(scheme_type), intent(in) :: scheme
      real(wp), intent(in) :: turn  !< Ω
      real(wp) :: matrix(2, 2), state(2), d, v
      integer :: column

      do column = 1, 2
         state = merge([1.0_wp/turn, 0.0_wp], [0.0_wp, 1.0_wp], column == 1)
         v = (state(2) - turn**2*(state(1) + scheme%theta*(1.0_wp - scheme%chi)*state(2))) &
            /(1.0_wp + scheme%theta*scheme%chi*turn**2)
         d = (1.0_wp - scheme%chi)*state(2) + scheme%chi*v
         matrix(:, column) = [turn*(state(1) + d), v]
      end do
   end function amplification

   !> Roots, damping and period of a mode that is left to itself.
   subroutine free_vibration(scheme)
      type(scheme_type), intent(in) :: scheme
      complex(wp) :: expected(2), roots(2)
      real(wp) :: angle, decay, dt
      integer :: i

      call case('free vibration')
      do i = 1, size(resolutions)
         dt = resolutions(i)/omega
         expected = roots_of(amplification(scheme, resolutions(i)))
         roots = amplification_roots(scheme, omega, dt)
         call check_close(distance_of(roots, expected), 0.0_wp, 'roots', absolute=1.0e-10_wp)
         call check(abs(roots(1)) >= abs(roots(2))*(1.0_wp - 1.0e-14_wp), 'the larger one first')
         call check(oscillates(scheme, omega, dt) .eqv. &
            abs(scheme%theta - scheme%chi)*resolutions(i) < 2.0_wp, 'where it oscillates')
         call check(oscillates(scheme, omega, dt) .eqv. abs(aimag(expected(1))) > 0.0_wp, &
            'where the roots are complex')
         if (.not. oscillates(scheme, omega, dt)) then
            call check(free_damping(scheme, omega, dt) == 1.0_wp .and. &
               period_elongation(scheme, omega, dt) == -1.0_wp, 'no period')
            cycle
         end if
         angle = abs(atan2(aimag(expected(1)), real(expected(1))))
         decay = -log(abs(expected(1)))
         call check_close(free_damping(scheme, omega, dt), decay/hypot(angle, decay), 'ζ', &
            absolute=1.0e-10_wp)
         call check_close(period_elongation(scheme, omega, dt), resolutions(i)/angle - 1.0_wp, &
            'period', absolute=1.0e-10_wp*resolutions(i))
      end do
   end subroutine free_vibration

   !> Half the loss factor of the modulus that stands against −ω̃² M.
   subroutine steady_vibration(scheme)
      type(scheme_type), intent(in) :: scheme
      type(steady_type) :: weights
      complex(wp) :: modulus
      real(wp) :: dt
      integer :: i

      call case('steady vibration')
      do i = 1, 30
         dt = 0.1_wp*i/omega
         weights = steady_weights(scheme, omega, dt, 1.0_wp)
         modulus = -1.0_wp/weights%inertia
         if (real(modulus) > 0.0_wp) then
            call check_close(forced_damping(scheme, omega, dt), &
               0.5_wp*aimag(modulus)/real(modulus), 'ζ', relative=1.0e-10_wp, absolute=1.0e-14_wp)
         else
            call check(forced_damping(scheme, omega, dt) > 1.0e300_wp, 'overdamped')
         end if
      end do
   end subroutine steady_vibration

   !> Δt and θ for a damping ratio.
   subroutine inverses(scheme)
      type(scheme_type), intent(in) :: scheme
      real(wp), parameter :: ratios(5) = [1.0e-6_wp, 0.01_wp, 0.05_wp, 0.5_wp, 4.0_wp]
      real(wp) :: dt, theta
      integer :: i

      call case('step and θ for a damping ratio')
      do i = 1, size(ratios)
         dt = step_for_damping(scheme, ratios(i), omega)
         if (scheme%theta + scheme%chi > 1.0_wp) then
            call check_close(forced_damping(scheme, omega, dt), ratios(i), 'Δt', &
               relative=1.0e-12_wp)
         else
            call check(dt > 1.0e300_wp, 'a member without damping')
         end if
         theta = theta_for_damping(ratios(i), omega, 1.0_wp/omega)
         if (theta <= 1.0_wp) call check_close(forced_damping(scheme_type(theta, theta), omega, &
            1.0_wp/omega), ratios(i), 'θ', relative=1.0e-9_wp)
      end do
      call check(theta_for_damping(0.5_wp, omega, 0.01_wp/omega) > 1.0_wp, 'too short a step')
      call check(theta_for_damping(0.0_wp, omega, 0.01_wp/omega) == 0.5_wp, 'no damping')
   end subroutine inverses

   !> Spring at θ, spring at the end, dashpot on d/Δt, dashpot on the end velocity, driven at
   !> t₀ + θΔt until the transients are gone; the velocity carried into a step times `factor`.
   subroutine recursion(scheme, factor)
      type(scheme_type), intent(in) :: scheme
      real(wp), intent(in) :: factor
      real(wp), parameter :: mass = 1.3_wp, elastic = 700.0_wp, at_end = 500.0_wp, &
         mean = 9.0_wp, final = 7.0_wp, dt = 0.03_wp
      type(steady_type) :: weights
      complex(wp) :: x, v, d, turn, expected
      integer :: i

      call case('the recursion')
      weights = steady_weights(scheme, omega, dt, factor)
      expected = weights%load/(elastic + at_end*weights%end_stiffness + mass*weights%inertia &
         + mean*weights%mean_dashpot + final*weights%end_dashpot)
      associate (theta => scheme%theta, chi => scheme%chi)
         x = 0.0_wp
         v = 0.0_wp
         turn = exp(cmplx(0.0_wp, theta*omega*dt, wp))
         do i = 1, 2000
            v = factor*v
            d = dt*(1.0_wp - chi)*v
            ! d = Δt (1 − χ) v₀ + Δtχ v₁ put into the equation of motion leaves v₁.
            v = (mass*v/dt + turn - elastic*(x + theta*d) - at_end*(x + d) - mean*d/dt) &
               /(mass/dt + dt*chi*(theta*elastic + at_end) + chi*mean + final)
            x = x + d + dt*chi*v
            turn = turn*exp(cmplx(0.0_wp, omega*dt, wp))
         end do
         turn = exp(cmplx(0.0_wp, 2000*omega*dt, wp))
      end associate
      call check_close(abs(x/turn - expected), 0.0_wp, 'displacement', &
         absolute=1.0e-10_wp*abs(expected))
   end subroutine recursion

   !> Steps in which an alternating mode falls to 1/e.
   subroutine ringing()
      type(scheme_type) :: scheme
      complex(wp) :: roots(2)
      real(wp) :: omega_dt
      integer :: i, j

      scheme = scheme_type(1.0_wp, 0.5_wp)
      do i = 2, 7
         omega_dt = 10.0_wp**i
         call check_close(steps_to_decay(scheme, omega, omega_dt/omega), omega_dt**2/8.0_wp, &
            'DDA: Ω²/8', relative=10.0_wp/omega_dt**2 + 1.0e-8_wp)
      end do
      do i = 1, size(parameters)
         scheme = scheme_type(1.0_wp, parameters(i))
         do j = 1, size(resolutions)
            roots = roots_of(amplification(scheme, resolutions(j)))
            associate (steps => steps_to_decay(scheme, omega, resolutions(j)/omega), &
               slow => roots(maxloc(abs(roots), 1)))
               if (real(slow) < 0.0_wp) then
                  call check_close(-1.0_wp/steps, log(abs(slow)), 'ln |λ|', absolute=1.0e-10_wp)
               else
                  call check(steps == 0.0_wp, 'nothing rings')
               end if
            end associate
         end do
      end do
      scheme = scheme_type(0.5_wp, 0.5_wp)
      call check(steps_to_decay(scheme, omega, 50.0_wp/omega) > 1.0e300_wp, &
         'the midpoint rule rings for ever')
   end subroutine ringing

   !> Ends of the closed forms of DDA.
   subroutine limits()
      type(scheme_type), parameter :: dda = scheme_type(1.0_wp, 0.5_wp)

      call check_close(forced_damping(dda, 2*pi*13.95_wp, 1.0e-3_wp), 0.0219_wp, &
         'paper, table I', absolute=1.0e-4_wp)
      call check_close(free_damping(dda, 1.0_wp, 1.0e-3_wp), 0.25e-3_wp, 'ζ ≈ Ω/4', &
         relative=1.0e-6_wp)
      call check_close(free_damping(dda, 1.0_wp, 1.0e-12_wp), 0.25e-12_wp, 'tiny', &
         relative=1.0e-6_wp)
      call check_close(period_elongation(dda, 1.0_wp, 1.0e-3_wp), 11.0_wp/96.0_wp*1.0e-6_wp, &
         '11Ω²/96', relative=1.0e-4_wp)
      call check(forced_damping(dda, 4.0_wp, 1.0_wp) > 1.0e300_wp, 'beyond the Nyquist frequency')
   end subroutine limits

end module test_scheme
