! SPDX-License-Identifier: GPL-3.0-or-later
!> Damping of a block material by a generalised Maxwell body or by Rayleigh damping.
!>
!> Maxwell body, for damping that does not depend on frequency:
!>
!>     σ = D_u (e − Σ ζ_l),   dζ_l/dt + ω_l ζ_l = Y_l ω_l e ,   D_u = r D,
!>
!> where e is the strain since the end of statics.  The complex modulus over the given modulus,
!> g(ω) = r [1 − Σ Y_l ω_l/(ω_l + iω)], has Re g = 1 at the reference frequency.  The ω_l are
!> equally spaced in log ω, from a third of the lowest to three times the highest frequency of a
!> band.  The Y_l ≥ 0 are the least-squares solution of
!>
!>     Σ Y_l (ω_l ω + 2ζ ω_l²)/(ω_l² + ω²) = 2ζ ,
!>
!> that is, Im g = 2ζ Re g, at frequencies over the band.
!>
!> In steps of Δt the trapezoidal rule gives, with h_l = ω_l Δt/2,
!>
!>     Δζ_l = 2h_l/(1 + h_l) (Y_l e₀ − ζ_l) + h_l Y_l/(1 + h_l) Δε ,
!>
!> which in steady vibration equals the body at ω̃ = 2 tan(ωΔt/2)/Δt.  The loss of a step plus the
!> loss by the scheme, (θ − ½) ΔσΔε, is never negative for (θ − ½) ω_l Δt ≤ 4.
!>
!> Rayleigh damping: C = αM + βK acts on the mean velocity d/Δt of the block.
module dda_damping
   use dda_kinds, only: wp, pi
   use dda_errors, only: error_type, error_input, fail
   use dda_interpolation, only: log_spaced
   use dda_free_memory, only: require_for_blas
   use dda_nonnegative, only: solve_nonnegative
   use dda_text, only: to_text
   implicit none
   private
   public :: following, relaxing
   public :: damping_type, is_damped, has_body, fit_body, modulus_factor, set_rayleigh, &
      same_damping, rayleigh_ratio, max_mechanisms, highest_relaxation

   integer, parameter :: max_mechanisms = 16
   real(wp), parameter :: automatic_band(2) = [0.1_wp, 50.0_wp]  !< automatic band, Hz
   integer, parameter :: min_mechanisms = 4     !< smallest number of mechanisms that is tried
   !> target misfit if the number of mechanisms is automatic
   real(wp), parameter :: target_misfit = 3.5e-4_wp
   real(wp), parameter :: max_misfit = 0.05_wp   !< largest error of a fitted body
   real(wp), parameter :: band_margin = 3.0_wp  !< factor: ω_l beyond the ends of the band
   integer, parameter :: samples = 12             !< frequencies of the fit per mechanism

   !> Damping of a material.
   type :: damping_type
      real(wp) :: ratio = 0.0_wp                !< ζ of the body
      real(wp) :: reference = 0.0_wp            !< frequency of the given modulus, Hz
      real(wp) :: band(2) = 0.0_wp              !< band in which ζ is fitted, Hz; 0: automatic
      integer :: n = 0                          !< number of mechanisms; 0 before the fit: automatic
      real(wp) :: omega(max_mechanisms) = 0.0_wp   !< ω_l, rad/s
      real(wp) :: weight(max_mechanisms) = 0.0_wp  !< Y_l
      real(wp) :: unrelaxed = 1.0_wp            !< r = M_u/M
      real(wp) :: misfit = 0.0_wp               !< largest relative error of ζ over the band
      real(wp) :: alpha = 0.0_wp                !< α of Rayleigh damping, 1/s
      real(wp) :: beta = 0.0_wp                 !< β of Rayleigh damping, s
      !> a material law, not the block, applies this damping in steps, as its small-strain damping
      logical :: by_law = .false.
   end type damping_type

contains

   !> .true. if there is any damping.
   elemental logical function is_damped(damping)
      type(damping_type), intent(in) :: damping  !< damping of a material

      is_damped = damping%ratio > 0.0_wp .or. damping%alpha > 0.0_wp .or. damping%beta > 0.0_wp
   end function is_damped

   !> .true. if there is a generalised Maxwell body.
   elemental logical function has_body(damping)
      type(damping_type), intent(in) :: damping  !< damping of a material

      has_body = damping%ratio > 0.0_wp
   end function has_body

   !> .true. if two materials have the same damping.
   elemental logical function same_damping(a, b) result(same)
      type(damping_type), intent(in) :: a, b  !< damping of two materials

      same = a%n == b%n .and. a%alpha == b%alpha .and. a%beta == b%beta .and. &
         a%unrelaxed == b%unrelaxed .and. all(a%omega == b%omega) .and. all(a%weight == b%weight)
   end function same_damping

   !> Set α and β for a damping ratio at two frequencies.
   pure subroutine set_rayleigh(damping, ratio, frequencies)
      type(damping_type), intent(inout) :: damping  !< damping; receives α and β
      real(wp), intent(in) :: ratio           !< ζ at both frequencies
      real(wp), intent(in) :: frequencies(2)  !< Hz, different
      real(wp) :: omega(2)

      omega = 2.0_wp*pi*frequencies
      damping%beta = 2.0_wp*ratio/sum(omega)
      damping%alpha = damping%beta*product(omega)
   end subroutine set_rayleigh

   !> Damping ratio ζ of Rayleigh damping, α/(2ω) + βω/2.
   elemental real(wp) function rayleigh_ratio(damping, frequency) result(ratio)
      type(damping_type), intent(in) :: damping  !< damping of a material
      real(wp), intent(in) :: frequency  !< Hz, above 0

      associate (omega => 2.0_wp*pi*frequency)
         ratio = 0.5_wp*(damping%alpha/omega + damping%beta*omega)
      end associate
   end function rayleigh_ratio

   !> Complex modulus of the body relative to the given modulus, at an angular frequency.
   elemental complex(wp) function modulus_factor(damping, omega) result(factor)
      type(damping_type), intent(in) :: damping  !< fitted damping
      real(wp), intent(in) :: omega  !< angular frequency, rad/s; pre-warped for steps of Δt
      integer :: l

      factor = 1.0_wp
      do l = 1, damping%n
         factor = factor - damping%weight(l)*damping%omega(l)/cmplx(damping%omega(l), omega, wp)
      end do
      factor = damping%unrelaxed*factor
   end function modulus_factor

   !> Largest ω_l that is permitted for a scheme and a time step, rad/s: (θ − ½) ω_l Δt ≤ 4.
   elemental real(wp) function highest_relaxation(theta, time_step) result(limit)
      real(wp), intent(in) :: theta      !< θ of the scheme, ½ … 1
      real(wp), intent(in) :: time_step  !< Δt, s

      limit = huge(1.0_wp)
      if (theta > 0.5_wp) limit = 4.0_wp/((theta - 0.5_wp)*time_step)
   end function highest_relaxation

   !> Fit the body to its ratio over its band, with ω_l up to a limit.
   subroutine fit_body(damping, limit, error)
      type(damping_type), intent(inout) :: damping  !< damping with ratio, reference, band and n
      real(wp), intent(in) :: limit  !< largest ω_l permitted by all stages, rad/s
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer :: n

      if (.not. damping%band(2) > 0.0_wp) damping%band = [automatic_band(1), &
         min(automatic_band(2), limit/(2.0_wp*pi*band_margin))]
      if (damping%band(2) <= damping%band(1)) call fail(error, error_input, 'the time step '// &
         'permits mechanisms only up to '//to_text(limit/(2.0_wp*pi))//' Hz, but damping_band '// &
         'begins at '//to_text(damping%band(1))//' Hz: give a smaller time_step, or '// &
         "integration = 'midpoint'")
      if (allocated(error)) return
      call require_for_blas(error)
      if (allocated(error)) return
      if (damping%n > 0) then
         call fit_mechanisms(damping, damping%n, limit)
      else
         do n = min_mechanisms, max_mechanisms
            call fit_mechanisms(damping, n, limit)
            if (damping%misfit <= target_misfit) exit
         end do
      end if
      if (damping%misfit <= max_misfit) return
      call fail(error, error_input, to_text(damping%n)//' mechanisms give the damping ratio '// &
         to_text(damping%ratio)//' from '//to_text(damping%band(1))//' to '// &
         to_text(damping%band(2))//' Hz with an error of '//to_text(100*damping%misfit)//' %'// &
         fit_advice(damping, limit))
   end subroutine fit_body

   !> Text on what to do if the fit is inaccurate.
   pure function fit_advice(damping, limit) result(text)
      type(damping_type), intent(in) :: damping  !< fitted damping
      real(wp), intent(in) :: limit  !< largest ω_l, rad/s
      character(len=:), allocatable :: text

      text = '; give more mechanisms or a narrower damping_band'
      if (2.0_wp*pi*band_margin*damping%band(2) > limit) text = '; the time step permits '// &
         'mechanisms only up to '//to_text(limit/(2.0_wp*pi))//' Hz, but the band needs '// &
         'mechanisms up to '//to_text(band_margin*damping%band(2))//' Hz; give a smaller '// &
         'time_step, a lower end of '//"damping_band, or integration = 'midpoint'"
   end function fit_advice

   !> Fit the body with a given number of mechanisms; mechanisms without weight are omitted.
   subroutine fit_mechanisms(damping, n, limit)
      type(damping_type), intent(inout) :: damping  !< damping; receives ω_l, Y_l, r and misfit
      integer, intent(in) :: n      !< mechanisms
      real(wp), intent(in) :: limit !< largest ω_l, rad/s
      real(wp) :: matrix(samples*n, n), rhs(samples*n), weight(n), omega_l(n), omega(samples*n)
      integer :: l, retained

      omega_l = 2.0_wp*pi*log_spaced(damping%band(1)/band_margin, min(band_margin*damping%band(2), &
         limit/(2.0_wp*pi)), n)
      omega = 2.0_wp*pi*log_spaced(damping%band(1), damping%band(2), samples*n)
      do l = 1, n
         matrix(:, l) = omega_l(l)*(omega + 2.0_wp*damping%ratio*omega_l(l))/(omega_l(l)**2 &
            + omega**2)
      end do
      rhs = 2.0_wp*damping%ratio
      call solve_nonnegative(matrix, rhs, weight)
      retained = count(weight > 0.0_wp)
      damping%n = retained
      damping%omega = 0.0_wp
      damping%weight = 0.0_wp
      damping%omega(:retained) = pack(omega_l, weight > 0.0_wp)
      damping%weight(:retained) = pack(weight, weight > 0.0_wp)
      damping%unrelaxed = 1.0_wp
      damping%unrelaxed = 1.0_wp/real(modulus_factor(damping, 2.0_wp*pi*damping%reference))
      damping%misfit = largest_misfit(damping)
   end subroutine fit_mechanisms

   !> Largest relative error of ζ over the band; huge if the body is unstable, Σ Y_l ≥ 1.
   pure real(wp) function largest_misfit(damping) result(misfit)
      type(damping_type), intent(in) :: damping  !< fitted damping
      real(wp) :: frequency(64*damping%n)
      complex(wp) :: factor(64*damping%n)

      misfit = huge(1.0_wp)
      if (damping%n == 0 .or. sum(damping%weight) >= 1.0_wp) return
      frequency = log_spaced(damping%band(1), damping%band(2), size(frequency))
      factor = modulus_factor(damping, 2.0_wp*pi*frequency)
      misfit = maxval(abs(0.5_wp*aimag(factor)/real(factor)/damping%ratio - 1.0_wp))
   end function largest_misfit

   !> Change h Y/(1 + h) of ζ per strain increment in a step.
   pure real(wp) function following(damping, l, time_step)
      type(damping_type), intent(in) :: damping  !< damping of the material
      integer, intent(in) :: l                   !< mechanism
      real(wp), intent(in) :: time_step          !< Δt, s

      associate (h => 0.5_wp*damping%omega(l)*time_step)
         following = h*damping%weight(l)/(1.0_wp + h)
      end associate
   end function following

   !> Change 2h/(1 + h) (Y e₀ − ζ) of ζ in a step at constant strain.
   pure real(wp) function relaxing(damping, l, time_step, strain, memory)
      type(damping_type), intent(in) :: damping   !< damping of the material
      integer, intent(in) :: l                    !< mechanism
      real(wp), intent(in) :: time_step           !< Δt, s
      real(wp), intent(in) :: strain, memory      !< e₀ and ζ

      associate (h => 0.5_wp*damping%omega(l)*time_step)
         relaxing = 2.0_wp*h/(1.0_wp + h)*(damping%weight(l)*strain - memory)
      end associate
   end function relaxing

end module dda_damping
