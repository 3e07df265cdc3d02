!> What the time integration does to a linear oscillator: closed forms of the Newmark scheme with
!> β = ½, γ = 1 (paper eqs. 5 and 13, with Ω = ωΔt).
!>
!> Its amplification matrix has determinant 2/(2 + Ω²) and trace (4 − Ω²)/(2 + Ω²); a mode
!> oscillates as long as Ω < 4 and is damped beyond.  In steady harmonic motion −ω² becomes −(4/Δt²)
!> sin²(ωΔt/2) (1 − i tan(ωΔt/2)), a complex modulus with 2ζ = tan(ωΔt/2).
module dda_scheme
   use dda_kinds, only: wp, pi
   implicit none
   private
   public :: free_damping, period_elongation, forced_damping, step_for_damping, oscillates, &
      inertia_factor

contains

   !> The mode still swings at this step: Ω < 4 (paper eq. 13).
   elemental logical function oscillates(omega, time_step)
      real(wp), intent(in) :: omega      !< rad/s
      real(wp), intent(in) :: time_step  !< s

      oscillates = omega*time_step < 4.0_wp
   end function oscillates

   !> Phase of one step in free vibration, rad: the argument of the complex eigenvalues,
   !> tan φ = √(4 determinant − trace²)/trace = Ω √(16 − Ω²)/(4 − Ω²).
   elemental real(wp) function phase_of(turn)
      real(wp), intent(in) :: turn  !< Ω = ωΔt, below 4

      phase_of = atan2(turn*sqrt(16.0_wp - turn**2), 4.0_wp - turn**2)
   end function phase_of

   !> Damping ratio of a mode left to itself, ζ = ln(1/|λ|)/hypot(φ, ln|λ|) ≈ Ω/4; 1 if it does not
   !> swing.
   elemental real(wp) function free_damping(omega, time_step) result(ratio)
      real(wp), intent(in) :: omega      !< rad/s
      real(wp), intent(in) :: time_step  !< s
      real(wp) :: turn, decay

      turn = omega*time_step
      ratio = 1.0_wp
      if (.not. oscillates(omega, time_step)) return
      ratio = 0.25_wp*turn
      if (turn < 1.0e-8_wp) return
      decay = 0.5_wp*log(1.0_wp + 0.5_wp*turn**2)
      ratio = decay/hypot(phase_of(turn), decay)
   end function free_damping

   !> Period of a mode left to itself over its true period, less 1; −1 (no period) if it does not
   !> swing.
   elemental real(wp) function period_elongation(omega, time_step) result(elongation)
      real(wp), intent(in) :: omega      !< rad/s
      real(wp), intent(in) :: time_step  !< s
      real(wp) :: turn

      turn = omega*time_step
      elongation = -1.0_wp
      if (.not. oscillates(omega, time_step)) return
      elongation = 0.0_wp
      if (turn > 0.0_wp) elongation = turn/phase_of(turn) - 1.0_wp
   end function period_elongation

   !> Damping ratio in steady harmonic motion, tan(ωΔt/2)/2; huge from the Nyquist frequency on.
   elemental real(wp) function forced_damping(omega, time_step) result(ratio)
      real(wp), intent(in) :: omega      !< of the motion, rad/s
      real(wp), intent(in) :: time_step  !< s

      ratio = huge(1.0_wp)
      if (omega*time_step < pi) ratio = 0.5_wp*tan(0.5_wp*omega*time_step)
   end function forced_damping

   !> The step, s, that gives a damping ratio at a frequency: Δt = 2 atan(2ζ)/ω.
   elemental real(wp) function step_for_damping(ratio, omega) result(time_step)
      real(wp), intent(in) :: ratio  !< ζ
      real(wp), intent(in) :: omega  !< rad/s

      time_step = 2.0_wp*atan(2.0_wp*ratio)/omega
   end function step_for_damping

   !> What the scheme puts in place of −ω² in front of M in steady harmonic motion, 1/s².
   !>
   !> 2 (z−1)(z−f) / (z (z+f) Δt²) with z = exp(iωΔt) and the dynamic factor f that multiplies the
   !> velocity carried into a step; for f = 1 this is the complex modulus above.
   elemental complex(wp) function inertia_factor(omega, time_step, dynamic_factor) result(factor)
      real(wp), intent(in) :: omega           !< of the motion, rad/s, below π/Δt
      real(wp), intent(in) :: time_step       !< s
      real(wp), intent(in) :: dynamic_factor  !< 0 … 1
      complex(wp) :: z
      real(wp) :: half

      half = 0.5_wp*omega*time_step
      z = cmplx(cos(2*half), sin(2*half), wp)
      if (dynamic_factor == 1.0_wp) then
         factor = -(2.0_wp*sin(half)/time_step)**2*cmplx(1.0_wp, -tan(half), wp)
      else
         factor = 2.0_wp*(z - 1.0_wp)*(z - dynamic_factor)/(z*(z + dynamic_factor)*time_step**2)
      end if
   end function inertia_factor

end module dda_scheme
