! SPDX-License-Identifier: GPL-3.0-or-later
!> Friction that depends on the slip velocity v and on a state θ [Dieterich, 1979; Ruina, 1983]:
!>
!> μ = μ₀ + a ln[(v + v_c)/v₀] + b ln(θv₀/L), dθ/dt = 1 − vθ/L (ageing law).
!>
!> v_c is a regularisation: below N μ(v = 0) the joint sticks elastically.  For b = 0, friction
!> depends only on the velocity.  In a step, v is the mean slip velocity and θ the state at the
!> start: the friction at a given normal force then has a convex potential for all a ≥ 0.  At the
!> end of the step θ is integrated exactly with this v.  If the joint slips, the shear force at a
!> trial stretch t is the solution of k_s (t − vΔt) = N μ(v), convex in ln u, u = v + v_c.
module dda_rate_state
   use dda_kinds, only: wp, pi
   use dda_joint_law, only: column_type, joint_law_type, joint_state_type, slip_path, &
      strength_type
   use dda_material, only: joint_type
   implicit none
   private
   public :: rate_state_type, new_rate_state

   !> columns: θ, s; v with its sign, m/s; largest slip of a step over L
   integer, parameter :: age = 3, slip_rate = 4, slip_share = 5
   !> largest slip/L per step, for an error of θ below 10 %
   real(wp), parameter :: most_slip = 0.2_wp
   integer, parameter :: most_steps = 60         !< iterations of Newton's method (monotone)

   !> Friction and its parameters.
   type, extends(joint_law_type) :: rate_state_type
      real(wp) :: friction = 0.0_wp    !< μ₀
      real(wp) :: direct = 0.0_wp      !< a
      real(wp) :: evolution = 0.0_wp   !< b
      real(wp) :: reference = 1.0_wp   !< v₀, m/s
      real(wp) :: threshold = 1.0_wp   !< v_c, m/s
      real(wp) :: distance = 1.0_wp    !< L, m
      real(wp) :: first_age = 1.0_wp   !< θ at the start, s
   contains
      procedure :: strength, flow => slip_curve, expected_slip, state_after_slip, check_and_derive
   end type rate_state_type

contains

   !> Create the law of a joint material, but do not set its stiffness.
   pure type(rate_state_type) function new_rate_state(joint) result(law)
      type(joint_type), intent(in) :: joint  !< checked input

      law%friction = tan(joint%friction_angle*(pi/180.0_wp))
      law%direct = joint%direct_effect
      law%evolution = joint%evolution_effect
      law%reference = joint%reference_velocity
      law%threshold = joint%threshold_velocity
      law%distance = joint%state_distance
      law%first_age = joint%initial_age
      law%law_columns(:3) = [column_type('age'), column_type('slip_rate'), &
         column_type('slip_share', limit=most_slip, advice='slip per step over '// &
         'state_distance, above which age is inaccurate; try a smaller time_step')]
      law%has_slip_curve = .true.
      law%inputs = [strength_type('friction_angle', joint%friction_angle, is_angle=.true.), &
         strength_type('direct_effect', joint%direct_effect)]
      if (joint%evolution_effect > 0.0_wp) law%inputs = [law%inputs, &
         strength_type('evolution_effect', joint%evolution_effect)]
   end function new_rate_state

   !> Set the initial velocity and state.
   pure subroutine check_and_derive(law, joint, shear_ratio, wrong)
      class(rate_state_type), intent(in) :: law  !< law of the joint
      type(joint_type), intent(inout) :: joint   !< input of the law
      real(wp), intent(in) :: shear_ratio        !< k_n/k_s
      character(len=:), allocatable, intent(out) :: wrong  !< error message, blank if none

      wrong = ''
      if (.not. joint%state_distance > 0.0_wp) joint%state_distance = 1.0_wp  ! no effect if b = 0
      if (.not. joint%reference_velocity > 0.0_wp) &
         joint%reference_velocity = joint%threshold_velocity
      if (.not. joint%initial_age > 0.0_wp) &
         joint%initial_age = joint%state_distance/joint%reference_velocity
   end subroutine check_and_derive

   !> Return the part of μ that does not depend on velocity: μ at u = v + v_c = 1 m/s.
   pure real(wp) function slow_friction(law, state) result(friction)
      class(rate_state_type), intent(in) :: law    !< law of the joint
      type(joint_state_type), intent(in) :: state  !< state of the contact

      friction = law%friction - law%direct*log(law%reference)
      if (law%evolution > 0.0_wp) friction = friction &
         + law%evolution*log(state_variable(law, state)*law%reference/law%distance)
   end function slow_friction

   !> Return the state θ, s.
   pure real(wp) function state_variable(law, state) result(theta)
      class(rate_state_type), intent(in) :: law    !< law of the joint
      type(joint_state_type), intent(in) :: state  !< state of the contact

      theta = state%memory(age)
      if (.not. theta > 0.0_wp) theta = law%first_age
   end function state_variable

   !> Return the largest shear force without slip, N/m.
   pure real(wp) function strength(law, state, normal_force)  ! total
      class(rate_state_type), intent(in) :: law    !< law of the joint
      type(joint_state_type), intent(in) :: state  !< state of the contact
      real(wp), intent(in) :: normal_force         !< compression positive, N/m

      strength = max(0.0_wp, slow_friction(law, state) + law%direct*log(law%threshold)) &
         *max(normal_force, 0.0_wp)
   end function strength

   !> Compute the shear force at the end of a step, and its slope.
   pure subroutine slip_curve(law, state, normal_force, stretch, shear_force, tangent)
      class(rate_state_type), intent(in) :: law      !< law of the joint
      type(joint_state_type), intent(in) :: state    !< state at the start of the step
      real(wp), intent(in) :: normal_force           !< ≥ 0, N/m
      real(wp), intent(in) :: stretch                !< stretch of the shear spring without slip, m
      real(wp), intent(out) :: shear_force, tangent  !< N/m; tangent ≥ 0, N/m per m
      real(wp) :: k_s, sticking, direct, slow, u, slope

      k_s = law%shear_spring(state)
      tangent = k_s
      shear_force = k_s*stretch
      sticking = law%strength(state, normal_force)
      if (abs(shear_force) <= sticking) return
      direct = law%direct*normal_force
      slow = slow_friction(law, state)*normal_force
      slope = 0.0_wp
      if (state%time_step > 0.0_wp .and. direct > 0.0_wp) then
         u = velocity_at(direct, k_s*state%time_step, k_s*(abs(stretch) &
            + law%threshold*state%time_step) - slow, abs(stretch)/state%time_step + law%threshold)
         sticking = max(0.0_wp, slow + direct*log(u))
         if (sticking > 0.0_wp) slope = direct/(u*state%time_step)
      end if
      shear_force = sign(sticking, stretch)
      tangent = k_s*slope/(k_s + slope)
   end subroutine slip_curve

   !> Solve a ln u + c u = f by Newton's method in ln u, from above, because the function is convex.
   pure real(wp) function velocity_at(a, c, f, upper_bound) result(u)
      real(wp), intent(in) :: a, c, f  !< > 0, > 0, any
      real(wp), intent(in) :: upper_bound     !< upper bound of u, m/s
      real(wp) :: y, residual
      integer :: i

      y = min(log(upper_bound), f/a)
      do i = 1, most_steps
         u = exp(y)
         residual = a*y + c*u - f
         y = y - residual/(a + c*u)
         if (abs(residual) <= 4*epsilon(residual)*(abs(a*y) + c*u)) exit
      end do
      u = exp(y)
   end function velocity_at

   !> Return the slip at the velocity of the last step, m.
   pure real(wp) function expected_slip(law, state) result(slip)
      class(rate_state_type), intent(in) :: law    !< law of the joint
      type(joint_state_type), intent(in) :: state  !< state at the start of the step

      slip = state%memory(slip_rate)*state%time_step
   end function expected_slip

   !> Update the state after an inelastic slip, with θ for a constant velocity in the step.
   pure type(joint_state_type) function state_after_slip(law, state, slip, &
      shear_force) result(after)
      class(rate_state_type), intent(in) :: law    !< law of the joint
      type(joint_state_type), intent(in) :: state  !< state before the slip
      real(wp), intent(in) :: slip                 !< slip with sign, m
      real(wp), intent(in) :: shear_force          !< shear force during slip, N/m
      real(wp) :: x, theta, decay

      after = state
      after%memory(slip_path) = state%memory(slip_path) + abs(slip)
      if (.not. state%time_step > 0.0_wp) return
      after%memory(slip_rate) = slip/state%time_step
      theta = state_variable(law, state)
      x = abs(slip)/law%distance
      if (law%evolution > 0.0_wp) after%memory(slip_share) = max(state%memory(slip_share), x)
      decay = 1.0_wp - 0.5_wp*x*(1.0_wp - x/3.0_wp)  ! (1 − exp(−x))/x
      if (x > 1.0e-4_wp) decay = (1.0_wp - exp(-x))/x
      after%memory(age) = theta*exp(-x) + state%time_step*decay
   end function state_after_slip

end module dda_rate_state
