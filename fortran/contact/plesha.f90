! SPDX-License-Identifier: GPL-3.0-or-later
!> Rough joint with asperities that wear [Plesha, 1987].
!>
!> Slip away from zero net slip (the centre) climbs asperities of angle α: the shear strength is
!> N tan(φ + α), and the joint rises by tan α per slip.  Slip towards the centre descends, at
!> N tan(φ − α).  The slip work W per area wears the asperities: α = α₀ exp(−cW).  Slip
!> dissipates N [tan(φ + α) − tan α] away from the centre and N [tan(φ − α) + tan α] towards it,
!> both positive for φ > 0.
!>
!> Because slip lifts the joint, its normal force at a trial stretch t follows from
!> N = k_n [x ± tan α (t − τ/k_s)] and τ = N tan(φ ± α).
module dda_plesha
   use dda_kinds, only: wp, pi
   use dda_joint_law, only: column_type, divided_strengths, joint_law_type, joint_state_type, &
      net_slip, slip_path, strength_type, weakened
   use dda_material, only: joint_type
   use dda_text, only: quoted, to_text
   implicit none
   private
   public :: plesha_type, new_plesha

   integer, parameter :: lifted = 4  !< column of the lift
   real(wp), parameter :: largest_climb = 89.0_wp   !< largest φ + α₀, degrees

   !> Friction of the faces, and their asperities.
   type, extends(joint_law_type) :: plesha_type
      real(wp) :: friction = 0.0_wp   !< φ, rad
      real(wp) :: asperity = 0.0_wp   !< α₀, rad
      real(wp) :: wear = 0.0_wp       !< c, m²/J
   contains
      procedure :: strength, reduced_strengths, state_after_slip, lift, rise, sliding_force, &
         check_and_derive
   end type plesha_type

contains

   !> Create the law of a joint material, but do not set its stiffness.
   pure type(plesha_type) function new_plesha(joint) result(law)
      type(joint_type), intent(in) :: joint  !< checked input

      law%friction = joint%friction_angle*(pi/180.0_wp)
      law%asperity = joint%asperity_angle*(pi/180.0_wp)
      law%wear = joint%asperity_wear
      law%law_columns(1) = column_type('lifted')
      law%dilates = .true.
      law%has_centre = .true.
      law%inputs = [strength_type('friction_angle', joint%friction_angle, is_angle=.true.), &
         strength_type('asperity_angle', joint%asperity_angle, is_angle=.true.)]
   end function new_plesha

   !> Reject asperities that slip cannot climb, or from which the joint slips or jumps back.
   pure subroutine check_and_derive(law, joint, shear_ratio, wrong)
      class(plesha_type), intent(in) :: law     !< law of the joint
      type(joint_type), intent(inout) :: joint  !< input of the law
      real(wp), intent(in) :: shear_ratio       !< k_n/k_s, if the joint does not set its own
      character(len=:), allocatable, intent(out) :: wrong  !< error message, blank if none
      real(wp) :: ratio

      wrong = ''
      ratio = shear_ratio
      if (joint%normal_stiffness > 0.0_wp .and. joint%shear_stiffness > 0.0_wp) &
         ratio = joint%normal_stiffness/joint%shear_stiffness
      associate (angle => joint%asperity_angle, friction => joint%friction_angle)
         if (angle > friction) then
            wrong = 'asperity_angle = '//to_text(angle)//' is above friction_angle = '// &
               to_text(friction)//': the joint would slip back by itself'
         else if (angle + friction > largest_climb) then
            wrong = 'asperity_angle = '//to_text(angle)//' and friction_angle = '// &
               to_text(friction)//' must not add up to more than '//to_text(largest_climb)// &
               ': otherwise no shear force moves the joint'
         else if (joint%shear_stiffness > 0.0_wp .and. .not. joint%normal_stiffness > 0.0_wp) then
            wrong = 'shear_stiffness_per_area of a joint of law = '//quoted(trim(joint%law))// &
               ' needs normal_stiffness_per_area too'
         else if (ratio >= steepest_return(joint)) then
            wrong = 'the normal stiffness is '//to_text(ratio)//' times the shear stiffness; '// &
               'from '//to_text(steepest_return(joint))//' on, slip would jump back to zero: '// &
               'give a larger shear_stiffness_per_area or a smaller asperity_angle'
         end if
      end associate
   end subroutine check_and_derive

   !> Return the largest k_n/k_s at which slip back to the centre is stable for any wear.
   !> For a larger ratio, descent would reduce the strength faster than the shear spring unloads.
   !> tan α tan(φ − α) is largest at α = φ/2.
   pure real(wp) function steepest_return(joint) result(ratio)
      type(joint_type), intent(in) :: joint  !< checked input
      real(wp) :: phi, alpha

      phi = joint%friction_angle*(pi/180.0_wp)
      alpha = min(0.5_wp*phi, joint%asperity_angle*(pi/180.0_wp))
      ratio = 1.0_wp/max(tan(alpha)*tan(phi - alpha), tiny(1.0_wp))
   end function steepest_return

   !> Return the angle of the asperities in the direction of slip, rad: positive if slip climbs.
   pure real(wp) function angle(law, state)
      class(plesha_type), intent(in) :: law        !< law of the joint
      type(joint_state_type), intent(in) :: state  !< state of the contact

      angle = law%asperity*(1.0_wp - state%memory(weakened))
      if (state%slip_sign*state%memory(net_slip) < 0.0_wp) angle = -angle
   end function angle

   !> Return the largest shear force, N/m.
   pure real(wp) function strength(law, state, normal_force)  ! total
      class(plesha_type), intent(in) :: law        !< law of the joint
      type(joint_state_type), intent(in) :: state  !< state of the contact
      real(wp), intent(in) :: normal_force         !< compression positive, N/m

      strength = tan(law%friction + angle(law, state))*max(normal_force, 0.0_wp)
   end function strength

   !> Return tan φ and tan α₀, divided by a reduction factor; α₀ is limited by `largest_climb`.
   pure function reduced_strengths(law, factor) result(strengths)
      class(plesha_type), intent(in) :: law   !< law of the joint
      real(wp), intent(in) :: factor          !< above 0
      type(strength_type), allocatable :: strengths(:)

      strengths = divided_strengths(law, factor)
      strengths(2)%value = min(strengths(2)%value, largest_climb - strengths(1)%value)
   end function reduced_strengths

   !> Update net slip, lift and wear after a slip.
   pure type(joint_state_type) function state_after_slip(law, state, slip, &
      shear_force) result(after)
      class(plesha_type), intent(in) :: law        !< law of the joint
      type(joint_state_type), intent(in) :: state  !< state before the slip
      real(wp), intent(in) :: slip                 !< slip with its sign, m
      real(wp), intent(in) :: shear_force          !< shear force during slip, N/m

      after = state
      after%memory(slip_path) = state%memory(slip_path) + abs(slip)
      after%memory(net_slip) = state%memory(net_slip) + slip
      after%memory(lifted) = state%memory(lifted) &
         + tan(law%asperity*(1.0_wp - state%memory(weakened))) &
         *(abs(after%memory(net_slip)) - abs(state%memory(net_slip)))
      after%memory(weakened) = 1.0_wp - (1.0_wp - state%memory(weakened)) &
         *exp(-law%wear*abs(shear_force*slip)/state%length)
   end function state_after_slip

   !> Return the lift of the contact by slip, m.
   pure real(wp) function lift(law, state)
      class(plesha_type), intent(in) :: law        !< law of the joint
      type(joint_state_type), intent(in) :: state  !< state of the contact

      lift = state%memory(lifted)
   end function lift

   !> Return the rise of the contact per unit of slip; negative if slip descends.
   pure real(wp) function rise(law, state, slip)
      class(plesha_type), intent(in) :: law        !< law of the joint
      type(joint_state_type), intent(in) :: state  !< state at the start of the step
      real(wp), intent(in) :: slip                 !< inelastic slip, ≥ 0, m

      rise = tan(angle(law, state))
   end function rise

   !> Return the normal force of a sliding contact, N/m, with the lift by the slip of this step.
   pure real(wp) function sliding_force(law, state, closure, stretch) result(force)
      class(plesha_type), intent(in) :: law        !< law of the joint
      type(joint_state_type), intent(in) :: state  !< state at the start of the step
      real(wp), intent(in) :: closure  !< closure at the end, without the lift of this step, m
      real(wp), intent(in) :: stretch  !< stretch of the shear spring without slip, ≥ 0, m
      real(wp) :: k_n, slope

      k_n = law%initial_spring(state)
      slope = tan(angle(law, state))
      force = k_n*max(0.0_wp, closure + slope*stretch)/(1.0_wp + k_n*slope &
         *tan(law%friction + angle(law, state))/law%shear_spring(state))
   end function sliding_force

end module dda_plesha
