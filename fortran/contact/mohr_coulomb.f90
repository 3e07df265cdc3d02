! SPDX-License-Identifier: GPL-3.0-or-later
!> Mohr–Coulomb joint with peak and residual strength, and dilation.
!>
!> Shear strength c(w) L + N tan φ(w) and tensile strength T(w) L are linear between peak (w = 0)
!> and residual (w = 1).  Without a slip distance the joint is brittle: an intact contact sticks
!> until it breaks, and w jumps to 1.  With a slip distance, w grows with the slip path.  Slip s
!> lifts the contact by min(s, s_max) tan ψ.  Including the lift in the step, a sliding contact has
!> N = k_n [x + tan ψ (t − τ/k_s)], τ = c L + N tan φ, at a trial stretch t.
module dda_mohr_coulomb
   use dda_kinds, only: wp, pi
   use dda_joint_law, only: joint_law_type, joint_state_type, strength_type, slip_path, weakened
   use dda_group_values, only: unset
   use dda_material, only: joint_type
   use dda_text, only: to_text
   implicit none
   private
   public :: mohr_coulomb_type, new_mohr_coulomb

   !> Peak and residual strength.
   type, extends(joint_law_type) :: mohr_coulomb_type
      real(wp) :: friction(2) = 0.0_wp   !< tan φ: peak, residual
      real(wp) :: cohesion(2) = 0.0_wp   !< Pa
      real(wp) :: tensile(2) = 0.0_wp    !< Pa
      real(wp) :: weakening_slip = 0.0_wp         !< m; 0: brittle
      real(wp) :: dilation = 0.0_wp               !< tan ψ
      real(wp) :: dilation_slip = huge(1.0_wp)    !< s_max, m
   contains
      procedure :: strength, tension, state_after_slip, lift, rise, lifting_share, sliding_force, &
         check_and_derive
   end type mohr_coulomb_type

contains

   !> Create the law of a joint material, but do not set its stiffness.
   pure type(mohr_coulomb_type) function new_mohr_coulomb(joint) result(law)
      type(joint_type), intent(in) :: joint  !< checked input

      law%friction = tan([joint%friction_angle, joint%residual_friction_angle]*pi/180.0_wp)
      law%cohesion = [joint%cohesion, joint%residual_cohesion]
      law%tensile = [joint%tensile_strength, joint%residual_tensile_strength]
      law%weakening_slip = joint%weakening_slip
      law%brittle = joint%weakening_slip <= 0.0_wp .and. any([law%friction(1), law%cohesion(1), &
         law%tensile(1)] > [law%friction(2), law%cohesion(2), law%tensile(2)])
      law%dilation = tan(joint%dilation_angle*pi/180.0_wp)
      if (joint%dilation_slip > 0.0_wp) law%dilation_slip = joint%dilation_slip
      law%dilates = joint%dilation_angle > 0.0_wp
      law%inputs = [strength_type('friction_angle', joint%friction_angle, is_angle=.true.), &
         strength_type('cohesion', joint%cohesion), &
         strength_type('tensile_strength', joint%tensile_strength), &
         strength_type('residual_friction_angle', joint%residual_friction_angle, is_angle=.true.), &
         strength_type('residual_cohesion', joint%residual_cohesion), &
         strength_type('residual_tensile_strength', joint%residual_tensile_strength), &
         strength_type('dilation_angle', joint%dilation_angle, is_angle=.true.)]
   end function new_mohr_coulomb

   !> Reject a residual strength above the peak, and a dilation angle above the residual φ.
   pure subroutine check_and_derive(law, joint, shear_ratio, wrong)
      class(mohr_coulomb_type), intent(in) :: law  !< law of the joint
      type(joint_type), intent(inout) :: joint     !< input of the law
      real(wp), intent(in) :: shear_ratio          !< k_n/k_s
      character(len=:), allocatable, intent(out) :: wrong  !< error message, blank if none

      if (joint%residual_friction_angle == unset) joint%residual_friction_angle = &
         joint%friction_angle
      wrong = excess_text('friction_angle', joint%residual_friction_angle, joint%friction_angle)
      if (wrong == '') wrong = excess_text('cohesion', joint%residual_cohesion, joint%cohesion)
      if (wrong == '') wrong = excess_text('tensile_strength', joint%residual_tensile_strength, &
         joint%tensile_strength)
      if (wrong /= '') return
      if (joint%dilation_angle > joint%residual_friction_angle) &
         wrong = 'dilation_angle = '//to_text(joint%dilation_angle)//' is above the residual '// &
            'friction angle, '//to_text(joint%residual_friction_angle)//': slip would add energy'

   contains

      !> Return a message if a residual strength exceeds the peak strength.
      pure function excess_text(name, residual, peak) result(words)
         character(len=*), intent(in) :: name  !< variable of the peak
         real(wp), intent(in) :: residual, peak
         character(len=:), allocatable :: words

         words = ''
         if (residual > peak) words = 'residual_'//name//' = '//to_text(residual)// &
            ' is above the peak, '//name//' = '//to_text(peak)// &
            ': failure cannot strengthen a joint'
      end function excess_text

   end subroutine check_and_derive

   !> Interpolate between peak and residual value.
   pure real(wp) function weakened_value(values, weakened)
      real(wp), intent(in) :: values(2), weakened

      weakened_value = values(1) + weakened*(values(2) - values(1))
   end function weakened_value

   !> Return the largest shear force, N/m.
   pure real(wp) function strength(law, state, normal_force)  ! total
      class(mohr_coulomb_type), intent(in) :: law  !< law of the joint
      type(joint_state_type), intent(in) :: state  !< state of the contact
      real(wp), intent(in) :: normal_force         !< compression positive, N/m

      strength = weakened_value(law%friction, state%memory(weakened))*max(normal_force, 0.0_wp) &
         + weakened_value(law%cohesion, state%memory(weakened))*state%length
   end function strength

   !> Return the largest tension of a bonded contact, N/m.
   pure real(wp) function tension(law, state)  ! total
      class(mohr_coulomb_type), intent(in) :: law  !< law of the joint
      type(joint_state_type), intent(in) :: state  !< state of the contact

      tension = weakened_value(law%tensile, state%memory(weakened))*state%length
   end function tension

   !> Update the state after a slip: the contact weakens unless it is brittle.
   pure type(joint_state_type) function state_after_slip(law, state, slip, &
      shear_force) result(after)
      class(mohr_coulomb_type), intent(in) :: law  !< law of the joint
      type(joint_state_type), intent(in) :: state  !< state before the slip
      real(wp), intent(in) :: slip                 !< slip with its sign, m
      real(wp), intent(in) :: shear_force          !< shear force during slip, N/m

      after = state
      after%memory(slip_path) = state%memory(slip_path) + abs(slip)
      if (law%weakening_slip > 0.0_wp) after%memory(weakened) = max(state%memory(weakened), &
         min(1.0_wp, after%memory(slip_path)/law%weakening_slip))
   end function state_after_slip

   !> Return the lift of the contact by slip, m.
   pure real(wp) function lift(law, state)
      class(mohr_coulomb_type), intent(in) :: law  !< law of the joint
      type(joint_state_type), intent(in) :: state  !< state of the contact

      lift = law%dilation*min(state%memory(slip_path), law%dilation_slip)
   end function lift

   !> Return the rise of the contact per unit of slip, up to the largest slip.
   pure real(wp) function rise(law, state, slip)
      class(mohr_coulomb_type), intent(in) :: law  !< law of the joint
      type(joint_state_type), intent(in) :: state  !< state at the start of the step
      real(wp), intent(in) :: slip                 !< inelastic slip, ≥ 0, m

      rise = merge(law%dilation, 0.0_wp, state%memory(slip_path) + slip < law%dilation_slip)
   end function rise

   !> Return the fraction of the slip of a step that lifts the contact, up to the largest slip.
   pure real(wp) function lifting_share(law, state, slip) result(share)
      class(mohr_coulomb_type), intent(in) :: law  !< law of the joint
      type(joint_state_type), intent(in) :: state  !< state at the start of the step
      real(wp), intent(in) :: slip                 !< inelastic slip, ≥ 0, m
      real(wp) :: remaining_slip

      remaining_slip = law%dilation_slip - state%memory(slip_path)
      share = 1.0_wp
      if (slip > remaining_slip) share = max(0.0_wp, remaining_slip)/slip
   end function lifting_share

   !> Return the normal force of a sliding contact, N/m, with the lift by the slip of this step.
   pure real(wp) function sliding_force(law, state, closure, stretch) result(force)
      class(mohr_coulomb_type), intent(in) :: law  !< law of the joint
      type(joint_state_type), intent(in) :: state  !< state at the start of the step
      real(wp), intent(in) :: closure  !< closure at the end, without the lift of this step, m
      real(wp), intent(in) :: stretch  !< stretch of the shear spring without slip, ≥ 0, m
      real(wp) :: k_n, k_s, remaining_slip

      k_n = law%initial_spring(state)
      force = k_n*closure
      remaining_slip = law%dilation_slip - state%memory(slip_path)
      if (.not. law%dilates .or. remaining_slip <= 0.0_wp) return
      k_s = law%shear_spring(state)
      force = k_n*(closure + law%dilation*max(0.0_wp, stretch - law%strength(state, 0.0_wp)/k_s)) &
         /(1.0_wp + k_n*law%dilation*weakened_value(law%friction, state%memory(weakened))/k_s)
      if (stretch - law%strength(state, force)/k_s > remaining_slip) &
         force = k_n*(closure + law%dilation*remaining_slip)
   end function sliding_force

end module dda_mohr_coulomb
