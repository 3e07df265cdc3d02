! SPDX-License-Identifier: GPL-3.0-or-later
!> Time integration in one step with two parameters, θ and χ.
!>
!>     M (v₁ − v₀)/Δt = f − K (q₀ + θ d) − C d/Δt − ∇U(q₁),   d = Δt [(1 − χ) v₀ + χ v₁] .
!>
!> Elastic stress, bonded joints and loads act at t₀ + θΔt.  Unilateral contacts, their friction and
!> supports have the potential U and act at the end of the step for any θ and χ.  For the unknown d,
!>
!>     K̂ = M/(χΔt²) + θK + C/Δt + ∂²U,   f̂ = f + M v₀/(χΔt) − K q₀ − …,
!>     v₁ = d/(χΔt) − (1/χ − 1) v₀ .
!>
!> Members: DDA (paper eq. 5: Newmark β = ½, γ = 1) is (1, ½); the midpoint rule (½, ½); the
!> θ-method of Moreau (1999) and Jean (1999) has θ = χ; backward Euler is (1, 1).  If θ, χ ≥ ½
!> and U is convex, no member gains energy:
!>
!>     ΔE = −(θ − ½) dᵀKd − (χ − ½) ΔvᵀMΔv − dᵀCd/Δt − [U(q₀) − U(q₁) + ∇U(q₁)·d] + work of loads.
module dda_scheme
   use dda_kinds, only: wp
   implicit none
   private
   public :: scheme_type, step_type, integration_names, default_theta, scheme_named
   public :: mass_weight, momentum_weight, velocity_weight, end_time, load_time, end_rate

   !> Values of `integration` in &control.
   character(len=*), parameter :: integration_names(4) = [character(len=14) :: 'dda', 'midpoint', &
      'theta', 'backward_euler']
   real(wp), parameter :: default_theta = 0.75_wp  !< default θ of 'theta'

   !> A member of the family of schemes.
   type :: scheme_type
      real(wp) :: theta = 1.0_wp  !< weight of the end of the step in elastic forces, ½ … 1
      real(wp) :: chi = 0.5_wp    !< weight of the end velocity in the displacement, ½ … 1
   end type scheme_type

   !> A time step: its start, its length and its scheme.
   type :: step_type
      type(scheme_type) :: scheme = scheme_type()
      real(wp) :: time = 0.0_wp       !< time at the start of the step, s
      real(wp) :: time_step = 0.0_wp  !< Δt, s
   end type step_type

contains

   !> Scheme of a name; `theta` is used only for 'theta'.
   pure type(scheme_type) function scheme_named(name, theta) result(scheme)
      character(len=*), intent(in) :: name  !< one of `integration_names`
      real(wp), intent(in) :: theta         !< θ = χ, ½ … 1

      select case (name)
      case ('midpoint')
         scheme = scheme_type(0.5_wp, 0.5_wp)
      case ('theta')
         scheme = scheme_type(theta, theta)
      case ('backward_euler')
         scheme = scheme_type(1.0_wp, 1.0_wp)
      end select
   end function scheme_named

   !> Factor of M in K̂, 1/s².
   pure real(wp) function mass_weight(step)
      type(step_type), intent(in) :: step  !< the present step

      mass_weight = 1.0_wp/(step%scheme%chi*step%time_step**2)
   end function mass_weight

   !> Factor of M v₀ in f̂, and of d in v₁, 1/s.
   pure real(wp) function momentum_weight(step)
      type(step_type), intent(in) :: step  !< the present step

      momentum_weight = 1.0_wp/(step%scheme%chi*step%time_step)
   end function momentum_weight

   !> Factor of −v₀ in v₁.
   pure real(wp) function velocity_weight(step)
      type(step_type), intent(in) :: step  !< the present step

      velocity_weight = 1.0_wp/step%scheme%chi - 1.0_wp
   end function velocity_weight

   !> Time of supports and unilateral contacts, s.
   pure real(wp) function end_time(step)
      type(step_type), intent(in) :: step  !< the present step

      end_time = step%time + step%time_step
   end function end_time

   !> Time of loads and body forces, t₀ + θΔt, s.
   pure real(wp) function load_time(step)
      type(step_type), intent(in) :: step  !< the present step

      load_time = step%time + step%scheme%theta*step%time_step
   end function load_time

   !> Velocity at the end of a step in which a coordinate moves by `increment`, per s.
   elemental real(wp) function end_rate(step, increment, rate)
      type(step_type), intent(in) :: step  !< the present step
      real(wp), intent(in) :: increment  !< increment of the coordinate
      real(wp), intent(in) :: rate   !< velocity at the start, per s

      end_rate = momentum_weight(step)*increment - velocity_weight(step)*rate
   end function end_rate

end module dda_scheme
