! SPDX-License-Identifier: GPL-3.0-or-later
!> Effect of the time integration on linear vibrations: exact formulas for a scheme (θ, χ).
!>
!> For one oscillator, with Ω = ωΔt and D = 1 + θχΩ², the amplification matrix has
!>
!>     determinant = [1 + (1 − θ)(1 − χ)Ω²]/D,   trace = 2 − (θ + χ)Ω²/D,
!>     4 determinant − trace² = Ω² [4 − (θ − χ)²Ω²]/D² .
!>
!> A mode therefore oscillates for Ω < 2/|θ − χ| (4 in DDA: paper eq. 13).  For larger Ω both roots
!> are real, and one root tends to 1 − 1/χ or 1 − 1/θ as Ω grows.  In DDA this limit is −1: the
!> velocity changes sign every step and hardly decays.  A support has the roots 1/(1 ± iΩ) of
!> backward Euler in every scheme.
!>
!> In steady vibration, z = exp(iωΔt), τ = tan(ωΔt/2), ω̃ = 2τ/Δt, the equations of a scheme have
!> ω̃ instead of ω and a complex modulus K (1 + i(2θ−1)τ)(1 + i(2χ−1)τ); see `steady_weights`.
module dda_scheme_response
   use dda_kinds, only: wp, pi
   use dda_scheme, only: scheme_type
   implicit none
   private
   public :: amplification_roots, oscillates, free_damping, period_elongation, forced_damping
   public :: step_for_damping, theta_for_damping, steps_to_decay, steady_type, steady_weights

   !> Factors of terms of the equations of motion in steady vibration; elastic terms have 1.
   type :: steady_type
      complex(wp) :: inertia        !< factor of M in place of −ω², 1/s²
      complex(wp) :: end_stiffness  !< factor of stiffness at the end of the step
      complex(wp) :: mean_dashpot   !< factor of dashpots on d/Δt, 1/s
      complex(wp) :: end_dashpot    !< factor of dashpots on the end velocity, 1/s
      complex(wp) :: load           !< factor of forces at t₀ + θΔt
   end type steady_type

contains

   !> Eigenvalues of the amplification matrix of one oscillator.
   pure function amplification_roots(scheme, omega, time_step) result(roots)
      type(scheme_type), intent(in) :: scheme  !< member (θ, χ)
      real(wp), intent(in) :: omega      !< undamped angular frequency, rad/s
      real(wp), intent(in) :: time_step  !< Δt, s
      complex(wp) :: roots(2)
      complex(wp) :: root
      real(wp) :: square, d, half_trace, determinant

      square = (omega*time_step)**2
      associate (theta => scheme%theta, chi => scheme%chi)
         d = 1.0_wp + theta*chi*square
         half_trace = 1.0_wp - 0.5_wp*(theta + chi)*square/d
         determinant = (1.0_wp + (1.0_wp - theta)*(1.0_wp - chi)*square)/d
         root = 0.5_wp*sqrt(cmplx(square*((theta - chi)**2*square - 4.0_wp), 0.0_wp, wp))/d
      end associate
      ! The larger root is computed first; the other root follows from the product without
      ! cancellation.
      roots(1) = half_trace + merge(root, -root, half_trace >= 0.0_wp)
      roots(2) = conjg(roots(1))
      if (real(root) > 0.0_wp) roots(2) = determinant/roots(1)
   end function amplification_roots

   !> .true. if a mode oscillates at this step: Ω < 2/|θ − χ| (DDA: 4, paper eq. 13).
   elemental logical function oscillates(scheme, omega, time_step)
      type(scheme_type), intent(in) :: scheme  !< member (θ, χ)
      real(wp), intent(in) :: omega      !< rad/s
      real(wp), intent(in) :: time_step  !< Δt, s

      oscillates = abs(scheme%theta - scheme%chi)*omega*time_step < 2.0_wp
   end function oscillates

   !> Phase of one step in free vibration, rad: the argument of the complex roots.
   !> tan φ = Ω √(4 − (θ − χ)²Ω²)/(2 + (2θχ − θ − χ)Ω²).
   elemental real(wp) function phase_of(scheme, omega_dt)
      type(scheme_type), intent(in) :: scheme  !< member (θ, χ)
      real(wp), intent(in) :: omega_dt  !< Ω = ωΔt of a mode that oscillates

      associate (theta => scheme%theta, chi => scheme%chi)
         phase_of = atan2(omega_dt*sqrt(max(0.0_wp, 4.0_wp - ((theta - chi)*omega_dt)**2)), &
            2.0_wp + (2.0_wp*theta*chi - theta - chi)*omega_dt**2)
      end associate
   end function phase_of

   !> Decay ln(1/|λ|) per step of a mode that oscillates.
   elemental real(wp) function decay_of(scheme, omega_dt)
      type(scheme_type), intent(in) :: scheme  !< member (θ, χ)
      real(wp), intent(in) :: omega_dt  !< Ω = ωΔt

      associate (theta => scheme%theta, chi => scheme%chi)
         ! (1 + a)/(1 + b) − 1 = (a − b)/(1 + b), a − b = −(θ + χ − 1)Ω², keeps small Ω exact.
         decay_of = -0.5_wp*log_of_one_and(-(theta + chi - 1.0_wp)*omega_dt**2 &
            /(1.0_wp + theta*chi*omega_dt**2))
      end associate
   end function decay_of

   !> Compute ln(1 + x), exact also for small x (Kahan).
   elemental real(wp) function log_of_one_and(x) result(value)
      real(wp), intent(in) :: x  !< > −1
      real(wp) :: sum

      sum = 1.0_wp + x
      value = x
      if (sum /= 1.0_wp) value = log(sum)*x/(sum - 1.0_wp)
   end function log_of_one_and

   !> Damping ratio of a free mode, ζ = ln(1/|λ|)/hypot(φ, ln|λ|); 1 without oscillation.
   !> For small Ω the ratio is about (θ + χ − 1)Ω/2.
   elemental real(wp) function free_damping(scheme, omega, time_step) result(ratio)
      type(scheme_type), intent(in) :: scheme  !< member (θ, χ)
      real(wp), intent(in) :: omega      !< rad/s
      real(wp), intent(in) :: time_step  !< Δt, s
      real(wp) :: decay

      ratio = 1.0_wp
      if (.not. oscillates(scheme, omega, time_step)) return
      ratio = 0.5_wp*(scheme%theta + scheme%chi - 1.0_wp)*omega*time_step
      if (omega*time_step < 1.0e-8_wp) return
      decay = decay_of(scheme, omega*time_step)
      ratio = decay/hypot(phase_of(scheme, omega*time_step), decay)
   end function free_damping

   !> Period of a free mode relative to its true period, minus 1; −1 without oscillation.
   elemental real(wp) function period_elongation(scheme, omega, time_step) result(elongation)
      type(scheme_type), intent(in) :: scheme  !< member (θ, χ)
      real(wp), intent(in) :: omega      !< rad/s
      real(wp), intent(in) :: time_step  !< Δt, s

      elongation = -1.0_wp
      if (.not. oscillates(scheme, omega, time_step)) return
      elongation = 0.0_wp
      if (omega*time_step > 0.0_wp) &
         elongation = omega*time_step/phase_of(scheme, omega*time_step) - 1.0_wp
   end function period_elongation

   !> Damping ratio in steady vibration, half the loss factor of the complex modulus.
   !> 2ζ = (a + b)τ/(1 − abτ²), a = 2θ − 1, b = 2χ − 1; huge if the real part is not positive.
   elemental real(wp) function forced_damping(scheme, omega, time_step) result(ratio)
      type(scheme_type), intent(in) :: scheme  !< member (θ, χ)
      real(wp), intent(in) :: omega      !< angular frequency of the motion, rad/s
      real(wp), intent(in) :: time_step  !< Δt, s
      real(wp) :: a, b, tau

      ratio = huge(1.0_wp)
      if (omega*time_step >= pi) return
      a = 2.0_wp*scheme%theta - 1.0_wp
      b = 2.0_wp*scheme%chi - 1.0_wp
      tau = tan(0.5_wp*omega*time_step)
      if (a*b*tau**2 < 1.0_wp) ratio = 0.5_wp*(a + b)*tau/(1.0_wp - a*b*tau**2)
   end function forced_damping

   !> Time step, s, for a damping ratio in steady vibration: the inverse of `forced_damping`.
   !> The result is huge for a scheme without damping.  DDA: 2 atan(2ζ)/ω.
   elemental real(wp) function step_for_damping(scheme, ratio, omega) result(time_step)
      type(scheme_type), intent(in) :: scheme  !< member (θ, χ)
      real(wp), intent(in) :: ratio  !< ζ > 0
      real(wp), intent(in) :: omega  !< rad/s
      real(wp) :: a, b

      a = 2.0_wp*scheme%theta - 1.0_wp
      b = 2.0_wp*scheme%chi - 1.0_wp
      time_step = huge(1.0_wp)
      ! τ solves 2ζab τ² + (a + b)τ − 2ζ = 0; this form of the root has no cancellation.
      if (a + b > 0.0_wp) time_step = 2.0_wp/omega*atan(4.0_wp*ratio &
         /(a + b + sqrt((a + b)**2 + 16.0_wp*a*b*ratio**2)))
   end function step_for_damping

   !> Find θ = χ for a damping ratio in steady vibration at a given Δt.
   !> θ = (1 + tan(½ atan 2ζ)/τ)/2; θ > 1 means that Δt is too short for this ratio.
   elemental real(wp) function theta_for_damping(ratio, omega, time_step) result(theta)
      real(wp), intent(in) :: ratio      !< ζ ≥ 0
      real(wp), intent(in) :: omega      !< rad/s, below π/Δt
      real(wp), intent(in) :: time_step  !< Δt, s

      theta = 0.5_wp*(1.0_wp + tan(0.5_wp*atan(2.0_wp*ratio))/tan(0.5_wp*omega*time_step))
   end function theta_for_damping

   !> Number of steps in which a mode that changes sign every step decays to 1/e.
   !> The result is 0 if the mode does not change sign every step, and huge if it does not decay.
   elemental real(wp) function steps_to_decay(scheme, omega, time_step) result(steps)
      type(scheme_type), intent(in) :: scheme  !< member (θ, χ)
      real(wp), intent(in) :: omega      !< rad/s
      real(wp), intent(in) :: time_step  !< Δt, s
      real(wp) :: decay
      complex(wp) :: roots(2)

      steps = 0.0_wp
      roots = amplification_roots(scheme, omega, time_step)
      if (real(roots(1)) >= 0.0_wp) return
      decay = decay_of(scheme, omega*time_step)
      if (abs(aimag(roots(1))) <= 0.0_wp) decay = slow_decay(scheme, omega*time_step, roots)
      steps = huge(1.0_wp)
      if (decay > epsilon(1.0_wp)) steps = 1.0_wp/decay
   end function steps_to_decay

   !> Decay ln(1/|λ|) of the larger of two real roots, without cancellation as λ tends to −1.
   !> 1 + λ = (1 + trace + determinant)/(1 + λ₂).
   pure real(wp) function slow_decay(scheme, omega_dt, roots) result(decay)
      type(scheme_type), intent(in) :: scheme  !< member (θ, χ)
      real(wp), intent(in) :: omega_dt  !< Ω = ωΔt
      complex(wp), intent(in) :: roots(2)
      real(wp) :: sum

      associate (theta => scheme%theta, chi => scheme%chi)
         sum = (4.0_wp + (2.0_wp*theta - 1.0_wp)*(2.0_wp*chi - 1.0_wp)*omega_dt**2) &
            /(1.0_wp + theta*chi*omega_dt**2)
      end associate
      decay = -log_of_one_and(-sum/(1.0_wp + real(roots(2))))
   end function slow_decay

   !> Factors of the terms at an angular frequency.
   !>
   !> Velocity v = (z − 1)x/(Δt [(1 − χ)f + χz]) and stiffness K (1 − θ + θz) x, with the dynamic
   !> factor f that multiplies the velocity at the start of a step; all divided by 1 − θ + θz.
   pure type(steady_type) function steady_weights(scheme, omega, time_step, dynamic_factor) &
      result(steady)
      type(scheme_type), intent(in) :: scheme  !< member (θ, χ)
      real(wp), intent(in) :: omega           !< angular frequency of the motion, rad/s, below π/Δt
      real(wp), intent(in) :: time_step       !< Δt, s
      real(wp), intent(in) :: dynamic_factor  !< 0 … 1
      complex(wp) :: z, elastic, velocity, velocity_change

      associate (half => 0.5_wp*omega*time_step)
         z = cmplx(cos(2*half), sin(2*half), wp)
         velocity_change = 2.0_wp*sin(half)*cmplx(-sin(half), cos(half), wp)  ! z − 1
      end associate
      elastic = 1.0_wp + scheme%theta*velocity_change
      velocity = velocity_change/(time_step*(dynamic_factor + scheme%chi*(z - dynamic_factor)))
      steady%inertia = velocity*(velocity_change + (1.0_wp - dynamic_factor))/(time_step*elastic)
      steady%end_stiffness = z/elastic
      steady%mean_dashpot = velocity_change/(time_step*elastic)
      steady%end_dashpot = z*velocity/elastic
      steady%load = exp(cmplx(0.0_wp, scheme%theta*omega*time_step, wp))/elastic
   end function steady_weights

end module dda_scheme_response
