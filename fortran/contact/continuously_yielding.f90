! SPDX-License-Identifier: GPL-3.0-or-later
!> Continuously yielding joint [Cundall and Hart, 1984; Lemos, 1987]: shear stress approaches a
!> bounding strength τ_m = σ tan φ_m, which decreases with damage.
!>
!> Slip s du changes the stress by dτ = F k_s du, F = (1 − sτ/τ_m)/(1 − r).  At a reversal r is set
!> to sτ/τ_m, at most 0.75, so that the response is elastic.  The inelastic part du_p = (1 − F) du
!> wears the roughness R: dφ_m = −(φ_m − φ)/R du_p, φ_m = φ + (φ_m0 − φ) exp(−u_p/R).  With φ_m at
!> its value at the start of a step, sτ = τ_m − (τ_m − sτ_0) exp[−k_s|Δu|/(τ_m (1 − r))].
module dda_continuously_yielding
   use dda_kinds, only: wp, pi
   use dda_joint_law, only: column_type, joint_law_type, joint_state_type, slip_path, &
      strength_type
   use dda_material, only: joint_type
   use dda_text, only: to_text
   implicit none
   private
   public :: continuously_yielding_type, new_continuously_yielding

   integer, parameter :: reversal = 3, last_direction = 4  !< columns of r, sign of the last slip
   real(wp), parameter :: most_reversal = 0.75_wp     !< largest r, as published
   real(wp), parameter :: round_off = 1.0e-9_wp  !< smaller relative force changes are no reversal
   real(wp), parameter :: most_stress_ratio = 1.25_wp  !< largest initial stress/strength

   !> Friction angles, rad, and roughness.
   type, extends(joint_law_type) :: continuously_yielding_type
      real(wp) :: friction = 0.0_wp   !< φ
      real(wp) :: initial = 0.0_wp    !< φ_m0
      real(wp) :: roughness = 1.0_wp  !< R, m
   contains
      procedure :: strength, flow => slip_curve, state_after_slip, check_and_derive
   end type continuously_yielding_type

contains

   !> Create the law of a joint material, but do not set its stiffness.
   pure type(continuously_yielding_type) function new_continuously_yielding(joint) result(law)
      type(joint_type), intent(in) :: joint  !< checked input

      law%friction = joint%friction_angle*(pi/180.0_wp)
      law%initial = joint%initial_friction_angle*(pi/180.0_wp)
      law%roughness = joint%roughness
      law%law_columns(:2) = [column_type('reversal'), column_type('slip_direction')]
      law%has_slip_curve = .true.
      law%inputs = [strength_type('friction_angle', joint%friction_angle, is_angle=.true.), &
         strength_type('initial_friction_angle', joint%initial_friction_angle, is_angle=.true.)]
   end function new_continuously_yielding

   !> Check that the strength decreases with damage.
   pure subroutine check_and_derive(law, joint, shear_ratio, wrong)
      class(continuously_yielding_type), intent(in) :: law  !< law of the joint
      type(joint_type), intent(inout) :: joint              !< input of the law
      real(wp), intent(in) :: shear_ratio                   !< k_n/k_s
      character(len=:), allocatable, intent(out) :: wrong   !< error message, blank if none

      wrong = ''
      if (joint%initial_friction_angle < joint%friction_angle) &
         wrong = 'initial_friction_angle = '//to_text(joint%initial_friction_angle)// &
         ' is below friction_angle = '//to_text(joint%friction_angle)// &
         ', the angle of the worn joint'
   end subroutine check_and_derive

   !> Return the friction angle φ_m, rad.
   pure real(wp) function angle(law, state)
      class(continuously_yielding_type), intent(in) :: law  !< law of the joint
      type(joint_state_type), intent(in) :: state           !< state of the contact

      angle = law%friction + (law%initial - law%friction) &
         *exp(-state%memory(slip_path)/law%roughness)
   end function angle

   !> Return the bounding strength, N/m.
   pure real(wp) function strength(law, state, normal_force)  ! total
      class(continuously_yielding_type), intent(in) :: law  !< law of the joint
      type(joint_state_type), intent(in) :: state           !< state of the contact
      real(wp), intent(in) :: normal_force                  !< compression positive, N/m

      strength = tan(angle(law, state))*max(normal_force, 0.0_wp)
   end function strength

   !> Compute the shear force at the end of a step, and its slope.
   pure subroutine slip_curve(law, state, normal_force, stretch, shear_force, tangent)
      class(continuously_yielding_type), intent(in) :: law  !< law of the joint
      type(joint_state_type), intent(in) :: state           !< state at the start of the step
      real(wp), intent(in) :: normal_force                  !< ≥ 0, N/m
      real(wp), intent(in) :: stretch  !< stretch of the shear spring without slip, m
      real(wp), intent(out) :: shear_force, tangent         !< N/m; tangent ≥ 0, N/m per m
      real(wp) :: k_s, bound, slip, direction, fraction, ratio, decay

      shear_force = 0.0_wp
      tangent = 0.0_wp
      bound = law%strength(state, normal_force)
      if (.not. bound > 0.0_wp) return
      k_s = law%shear_spring(state)
      slip = stretch - state%stretch
      direction = sign(1.0_wp, slip)
      if (.not. abs(slip) > 0.0_wp .and. state%memory(last_direction) < 0.0_wp) direction = -1.0_wp
      fraction = direction*initial_stress_ratio(law, state, normal_force)
      ratio = stress_ratio(state, direction, fraction)
      decay = exp(-k_s*abs(slip)/(bound*(1.0_wp - ratio)))
      shear_force = direction*bound*(1.0_wp - (1.0_wp - fraction)*decay)
      tangent = max(0.0_wp, k_s*(1.0_wp - fraction)*decay/(1.0_wp - ratio))
   end subroutine slip_curve

   !> Return r for slip in a direction, from the stress as a fraction of τ_m.
   pure real(wp) function stress_ratio(state, direction, fraction)
      type(joint_state_type), intent(in) :: state  !< state at the start of the step
      real(wp), intent(in) :: direction, fraction

      stress_ratio = state%memory(reversal)
      if (direction*state%memory(last_direction) < 0.0_wp) stress_ratio = min(most_reversal, &
         fraction)
   end function stress_ratio

   !> Return the signed shear force/strength at the start of a step, within ± `most_stress_ratio`.
   !> It may exceed 1 if the strength has decreased by slip or normal force.
   pure real(wp) function initial_stress_ratio(law, state, normal_force) result(fraction)
      class(continuously_yielding_type), intent(in) :: law  !< law of the joint
      type(joint_state_type), intent(in) :: state           !< state at the start of the step
      real(wp), intent(in) :: normal_force                  !< > 0, N/m

      fraction = law%shear_spring(state)*state%stretch/law%strength(state, normal_force)
      fraction = sign(min(abs(fraction), most_stress_ratio), fraction)
   end function initial_stress_ratio

   !> Update the state after an inelastic slip.
   pure type(joint_state_type) function state_after_slip(law, state, slip, &
      shear_force) result(after)
      class(continuously_yielding_type), intent(in) :: law  !< law of the joint
      type(joint_state_type), intent(in) :: state           !< state before the slip
      real(wp), intent(in) :: slip                          !< slip with sign, m
      real(wp), intent(in) :: shear_force  !< shear force at the end of the step, N/m
      real(wp) :: change, bound

      after = state
      after%memory(slip_path) = state%memory(slip_path) + abs(slip)
      change = law%shear_spring(state)*(slip - state%stretch) + shear_force
      bound = law%strength(state, state%normal_force)
      if (abs(change) <= round_off*bound .or. .not. bound > 0.0_wp) return
      after%memory(last_direction) = sign(1.0_wp, change)
      after%memory(reversal) = stress_ratio(state, after%memory(last_direction), &
         after%memory(last_direction) &
         *initial_stress_ratio(law, state, state%normal_force))
   end function state_after_slip

end module dda_continuously_yielding
