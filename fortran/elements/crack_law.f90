! SPDX-License-Identifier: GPL-3.0-or-later
!> Law of a point of a broken face: a cohesive joint, (1 − D) bond + D contact, as in
!> `dda_joint_bond` for contacts.
!>
!> The variables are the opening g and the slip s of the face, with tractions instead of stresses.
!> The bond acts at t₀ + θΔt, the contact at the end of the step.  The damage D* that acts in a step
!> lies between its initial and final values D₀ and D₁; with it the step dissipates exactly the
!> fracture energy.  D* and the pressure that bounds friction are frozen in each solution of a step,
!> which then minimises a convex function.
module dda_crack_law
   use dda_kinds, only: wp
   use dda_cohesive, only: cohesive_type
   use dda_material_law, only: material_law_type, strain_point_type, loss_damping, loss_plastic, &
      loss_scheme, losses
   use dda_scheme, only: step_type
   implicit none
   private
   public :: crack_law_type, has_failed

   integer, parameter :: damage_index = 1  !< index of D in a state
   integer, parameter :: slip_index = 2  !< index of the slip of the friction slider, m
   !> smallest tangent/stiffness, which couples both cells in the matrix
   real(wp), parameter :: min_tangent = 1.0e-9_wp

   !> Law of a joint material.
   type, extends(material_law_type) :: crack_law_type
      type(cohesive_type) :: joint
   contains
      procedure :: state_size, respond => find_traction, finish => finish_step, stored, &
         frozen_stress, traction_ratio, springs
   end type crack_law_type

   !> Motion of a point in a step.
   type :: motion_type
      real(wp) :: opening(2) = 0.0_wp   !< g at the start and end of the step, m
      real(wp) :: slip(2) = 0.0_wp      !< s at the start and end of the step, m
      real(wp) :: slider(2) = 0.0_wp    !< slip of the friction slider in the step, m
      logical :: sticks = .true.        !< the slider does not slip
   end type motion_type

contains

   !> Return the number of state variables: D, and the slip of the slider.
   pure integer function state_size(self)
      class(crack_law_type), intent(in) :: self  !< law

      state_size = 2
   end function state_size

   !> Return the stiffnesses for opening and slip, Pa/m.
   pure function springs(self) result(k)
      class(crack_law_type), intent(in) :: self  !< law
      real(wp) :: k(2)

      k = [self%joint%normal_stiffness, self%joint%shear_stiffness]
   end function springs

   !> Return the ratio of traction to strength; damage begins at 1.
   pure real(wp) function traction_ratio(self, traction) result(ratio)
      class(crack_law_type), intent(in) :: self  !< law
      real(wp), intent(in) :: traction(2)        !< tension, shear, Pa

      associate (shear => max(0.0_wp, abs(traction(2)) - self%joint%friction &
         *max(0.0_wp, -traction(1))))
         ratio = norm2([max(0.0_wp, traction(1)), shear]/self%joint%strengths)
      end associate
   end function traction_ratio

   !> Compute the motion of a point in a step, with the frozen pressure.
   pure type(motion_type) function point_motion(self, point, state, strain, change) result(motion)
      class(crack_law_type), intent(in) :: self     !< law
      type(strain_point_type), intent(in) :: point  !< point
      real(wp), intent(in) :: state(:)              !< [any] state at the start of the step
      real(wp), intent(in) :: strain(3), change(3)  !< g and s at the start; their changes, m
      real(wp) :: elastic, slip_limit

      motion%opening = strain(1) + [0.0_wp, change(1)]
      motion%slip = strain(2) + [0.0_wp, change(2)]
      motion%slider = state(slip_index)
      slip_limit = self%joint%friction*point%bounding(1)/self%joint%shear_stiffness
      elastic = motion%slip(2) - state(slip_index)
      motion%sticks = abs(elastic) <= slip_limit
      if (.not. motion%sticks) motion%slider(2) = motion%slip(2) - sign(slip_limit, elastic)
   end function point_motion

   !> Return D* of a point, which is frozen in a solution.
   pure real(wp) function acting_damage(self, point, state) result(fraction)
      class(crack_law_type), intent(in) :: self     !< law
      type(strain_point_type), intent(in) :: point  !< point
      real(wp), intent(in) :: state(:)              !< [any] state at the start of the step

      fraction = max(state(damage_index), min(1.0_wp, point%bounding(2)/self%joint%strengths(1)))
   end function acting_damage

   !> Return the values that are frozen in a solution: the pressure that bounds friction, and D* ×
   !> tensile strength.
   pure function frozen_stress(self, point, state, strain, change, step) result(stress)
      class(crack_law_type), intent(in) :: self     !< law
      type(strain_point_type), intent(in) :: point  !< point
      real(wp), intent(in) :: state(:)              !< [any] state at the start of the step
      real(wp), intent(in) :: strain(3), change(3)  !< g and s at the start; their changes, m
      type(step_type), intent(in) :: step           !< the present step
      real(wp) :: stress(3)
      type(motion_type) :: motion

      motion = point_motion(self, point, state, strain, change)
      associate (joint => self%joint)
         stress = [joint%normal_stiffness*max(0.0_wp, -motion%opening(2)), joint%strengths(1) &
            *joint%damage_in_step(motion%opening, motion%slider, state(damage_index)), 0.0_wp]
      end associate
   end function frozen_stress

   !> Find the traction that acts in a step, and its tangent.
   pure subroutine find_traction(self, point, state, strain, change, step, stress, tangent)
      class(crack_law_type), intent(in) :: self          !< law
      type(strain_point_type), intent(in) :: point       !< point
      real(wp), intent(in) :: state(:)                   !< [any] state at the start of the step
      real(wp), intent(in) :: strain(3), change(3)       !< g and s at the start; their changes, m
      type(step_type), intent(in) :: step                !< the present step
      real(wp), intent(out) :: stress(3), tangent(3, 3)  !< traction, Pa; tangent, Pa/m
      type(motion_type) :: motion
      real(wp) :: fraction, slope(2)

      motion = point_motion(self, point, state, strain, change)
      fraction = acting_damage(self, point, state)
      associate (k => self%springs(), theta => step%scheme%theta)
         stress(1) = (1.0_wp - fraction)*(strain(1) + theta*change(1)) &
            + fraction*min(0.0_wp, motion%opening(2))
         stress(2) = (1.0_wp - fraction)*(strain(2) + theta*change(2)) &
            + fraction*(motion%slip(2) - motion%slider(2))
         stress = [k*stress(1:2), 0.0_wp]
         slope = (1.0_wp - fraction)*theta
         if (motion%opening(2) < 0.0_wp) slope(1) = slope(1) + fraction
         if (motion%sticks) slope(2) = slope(2) + fraction
         slope = k*max(min_tangent, slope)
      end associate
      tangent = 0.0_wp
      tangent(1, 1) = slope(1)
      tangent(2, 2) = slope(2)
   end subroutine find_traction

   !> Find the state at the end of a step, and its losses by fracture, friction and scheme.
   pure subroutine finish_step(self, point, state, strain, change, step, loss)
      class(crack_law_type), intent(in) :: self      !< law
      type(strain_point_type), intent(in) :: point   !< point
      real(wp), intent(inout) :: state(:)  !< [any] state at the start; on return at the end
      real(wp), intent(in) :: strain(3), change(3)   !< g and s at the start; their changes, m
      type(step_type), intent(in) :: step            !< the present step
      real(wp), intent(out) :: loss(losses)          !< J/m²
      type(motion_type) :: motion
      real(wp) :: fraction, end_damage, rise(2), stretch(2), k(2), closure(2)

      motion = point_motion(self, point, state, strain, change)
      fraction = acting_damage(self, point, state)
      k = self%springs()
      associate (joint => self%joint, slider => motion%slider, theta => step%scheme%theta)
         end_damage = max(fraction, joint%damage(motion%opening(2), slider(2), state(damage_index)))
         rise = [fraction - state(damage_index), end_damage - fraction]
         stretch = motion%slip - slider
         closure = min(0.0_wp, motion%opening)
         loss(loss_plastic) = rise(1)*joint%bond_energy(motion%opening(1), slider(1)) &
            + rise(2)*joint%bond_energy(motion%opening(2), slider(2))
         loss(loss_damping) = k(2)*(fraction*stretch(2)*(slider(2) - slider(1)) &
            + dot_product(rise, slider*stretch))
         loss(loss_scheme) = (1.0_wp - fraction)*(theta - 0.5_wp)*dot_product(k, change(1:2)**2) &
            + fraction*(k(1)*(closure(2)*change(1) - 0.5_wp*(closure(2)**2 - closure(1)**2)) &
            + 0.5_wp*k(2)*(stretch(2) - stretch(1))**2)
         state(damage_index) = end_damage
         state(slip_index) = slider(2)
      end associate
   end subroutine finish_step

   !> Return the energy of bond and contact, J/m².
   pure real(wp) function stored(self, point, state, strain)
      class(crack_law_type), intent(in) :: self     !< law
      type(strain_point_type), intent(in) :: point  !< point
      real(wp), intent(in) :: state(:)              !< [any] state of the point
      real(wp), intent(in) :: strain(3)             !< g and s, m
      real(wp) :: k(2)

      k = self%springs()
      associate (left => 1.0_wp - state(damage_index))
         stored = 0.5_wp*k(1)*(min(0.0_wp, strain(1))**2 + left*max(0.0_wp, strain(1))**2) &
            + 0.5_wp*k(2)*(state(damage_index)*(strain(2) - state(slip_index))**2 + &
            left*strain(2)**2)
      end associate
   end function stored

   !> .true. if the bond of a point has failed.
   pure logical function has_failed(state)  ! total
      real(wp), intent(in) :: state(:)  !< [any] state of the point

      has_failed = state(damage_index) >= 1.0_wp
   end function has_failed

end module dda_crack_law
