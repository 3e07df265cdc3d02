! SPDX-License-Identifier: GPL-3.0-or-later
!> Velocity that is left after impacts: by the joint, by the scheme, or by the phase of the step.
!>
!> A contact without `restitution` is resolved up to Ω = ωΔt of about ½, and leaves exp(−πχΩ/2);
!> beyond, anything up to 1/χ − 1 is left, by the phase at which the step meets it.
module dda_impact_regime
   use dda_kinds, only: wp, pi
   use dda_contact_damping, only: softness_of
   use dda_linear_model, only: linear_model_type, normal_slope
   use dda_simulation, only: simulation_type
   use dda_text, only: short_text, to_text
   implicit none
   private
   public :: impact_regime_type, find_impact_regime

   real(wp), parameter :: resolved = 0.5_wp  !< Ω up to which the phase does not matter

   !> Unbonded contacts in the list of a simulation.
   type :: impact_regime_type
      integer :: prescribed = 0              !< whose joint has a restitution
      integer :: others = 0                  !< whose joint has none
      real(wp) :: lowest = huge(1.0_wp)      !< Ω of the others
      real(wp) :: highest = 0.0_wp           !< Ω of the others
      character(len=:), allocatable :: words   !< blank: there are none
      character(len=:), allocatable :: advice
   end type impact_regime_type

contains

   !> Look at all contacts that are listed, closed or not.
   subroutine find_impact_regime(linear, simulation, regime)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      type(simulation_type), intent(in) :: simulation  !< a run and its state
      type(impact_regime_type), intent(out) :: regime  !< of its contacts
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
            if (.not. omega > 0.0_wp) cycle  ! it has no length yet
            regime%others = regime%others + 1
            regime%lowest = min(regime%lowest, omega)
            regime%highest = max(regime%highest, omega)
         end do
      end associate
      call put_in_words(regime, linear)
      if (.not. simulation%laws%plain) regime%advice = ''  ! laws go without restitution
   end subroutine find_impact_regime

   subroutine put_in_words(regime, linear)
      type(impact_regime_type), intent(inout) :: regime  !< of the contacts
      type(linear_model_type), intent(in) :: linear  !< linearised model
      real(wp) :: most

      regime%words = ''
      regime%advice = ''
      if (regime%prescribed > 0) regime%words = to_text(regime%prescribed)// &
         ' unbonded contacts have the restitution of their joint, at any time_step and penalty'
      if (regime%others == 0) return
      if (regime%words /= '') regime%words = regime%words//'; '
      regime%words = regime%words//to_text(regime%others)//' have no restitution, omega dt '// &
         short_text(regime%lowest)//' … '//short_text(regime%highest)//': '
      most = 1.0_wp/linear%scheme%chi - 1.0_wp
      if (regime%highest <= resolved) then
         regime%words = regime%words//'impacts are resolved and leave '// &
            short_text(left_of(linear, regime%highest))//' … '// &
            short_text(left_of(linear, regime%lowest))//' of a velocity, by the scheme'
      else if (most > 0.0_wp) then
         regime%words = regime%words//'an impact leaves from 0 to '//short_text(most)// &
            ' of a velocity, as it falls early or late in its step'
         regime%advice = 'restitution of &joint, where blocks hit each other'
      else
         regime%words = regime%words//'impacts leave nothing of a velocity'
      end if
   end subroutine put_in_words

   !> exp(−πζ) at Ω, with the damping ratio [(χ − ½) + ½] Ω/2 of unilateral contacts.
   pure real(wp) function left_of(linear, omega) result(left)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      real(wp), intent(in) :: omega  !< Ω

      left = exp(-0.5_wp*pi*linear%scheme%chi*omega)
   end function left_of

end module dda_impact_regime
