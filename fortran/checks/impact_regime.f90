! SPDX-License-Identifier: GPL-3.0-or-later
!> Ratio of the velocities after and before an impact.  It depends on the restitution of the joint,
!> or else on the time integration and the instant of the impact in the step.
!>
!> Impacts at a contact without `restitution` are resolved up to Ω = ωΔt ≈ ½, with a velocity ratio
!> of exp(−πχΩ/2).  For larger Ω the ratio is between 0 and 1/χ − 1, depending on the instant.
module dda_impact_regime
   use dda_kinds, only: wp, pi
   use dda_contact_damping, only: softness_of
   use dda_linear_model, only: linear_model_type, normal_slope
   use dda_simulation, only: simulation_type
   use dda_text, only: short_text, to_text
   implicit none
   private
   public :: impact_regime_type, find_impact_regime

   real(wp), parameter :: resolved = 0.5_wp  !< largest Ω of resolved impacts

   !> Impact regime of the unbonded contacts of a simulation.
   type :: impact_regime_type
      integer :: prescribed = 0              !< number of contacts with a restitution
      integer :: unprescribed = 0            !< number of contacts without restitution
      real(wp) :: lowest_omega = huge(1.0_wp)      !< smallest Ω without restitution
      real(wp) :: highest_omega = 0.0_wp           !< largest Ω without restitution
      character(len=:), allocatable :: text   !< text; blank if no contact is unbonded
      character(len=:), allocatable :: advice
   end type impact_regime_type

contains

   !> Find the impact regime of all listed contacts, closed or open.
   subroutine find_impact_regime(linear, simulation, regime)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      type(simulation_type), intent(in) :: simulation  !< a run and its state
      type(impact_regime_type), intent(out) :: regime  !< regime of its contacts
      real(wp) :: omega
      integer :: c

      associate (contacts => simulation%contacts(simulation%now), laws => simulation%laws)
         do c = 1, contacts%n
            if (contacts%bonded(c)) cycle
            if (laws%restitution(contacts%joint(c)) >= 0.0_wp) then
               regime%prescribed = regime%prescribed + 1
               cycle
            end if
            omega = linear%time_step*sqrt(normal_slope(laws, contacts, c)*softness_of(contacts, &
               simulation%blocks, c))
            if (.not. omega > 0.0_wp) cycle  ! the contact has no length yet
            regime%unprescribed = regime%unprescribed + 1
            regime%lowest_omega = min(regime%lowest_omega, omega)
            regime%highest_omega = max(regime%highest_omega, omega)
         end do
      end associate
      call write_regime_text(regime, linear)
      if (.not. simulation%laws%plain) regime%advice = ''  ! joint laws have no restitution
   end subroutine find_impact_regime

   !> Write the text and the advice on the impact regime.
   subroutine write_regime_text(regime, linear)
      type(impact_regime_type), intent(inout) :: regime  !< regime of the contacts
      type(linear_model_type), intent(in) :: linear  !< linearised model
      real(wp) :: max_restitution

      regime%text = ''
      regime%advice = ''
      if (regime%prescribed > 0) regime%text = to_text(regime%prescribed)// &
         ' unbonded contacts have the restitution of their joint for any time_step and penalty'
      if (regime%unprescribed == 0) return
      if (regime%text /= '') regime%text = regime%text//'; '
      regime%text = regime%text//to_text(regime%unprescribed)//' contacts have no restitution, '// &
         'ω Δt = '//short_text(regime%lowest_omega)//' … '//short_text(regime%highest_omega)//': '
      max_restitution = 1.0_wp/linear%scheme%chi - 1.0_wp
      if (regime%highest_omega <= resolved) then
         regime%text = regime%text//'impacts are resolved; due to numerical damping, blocks '// &
            'rebound with '//short_text(speed_fraction(linear, regime%highest_omega))//' … '// &
            short_text(speed_fraction(linear, regime%lowest_omega))//' of their speed'
      else if (max_restitution > 0.0_wp) then
         regime%text = regime%text//'blocks rebound with 0 to '//short_text(max_restitution)// &
            ' of their speed, depending on the instant of the impact in a step'
         regime%advice = 'set restitution of &joint if impacts matter'
      else
         regime%text = regime%text//'blocks do not rebound'
      end if
   end subroutine write_regime_text

   !> Velocity ratio exp(−πζ) at Ω, with the damping ratio ζ = χΩ/2 of unilateral contacts.
   pure real(wp) function speed_fraction(linear, omega) result(reduced_ratio)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      real(wp), intent(in) :: omega  !< Ω

      reduced_ratio = exp(-0.5_wp*pi*linear%scheme%chi*omega)
   end function speed_fraction

end module dda_impact_regime
