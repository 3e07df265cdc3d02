! SPDX-License-Identifier: GPL-3.0-or-later
!> Law of the jumps of a welded face whose material yields: elastic and perfectly plastic.  The
!> cap limits the jump force to the force that the strain points of the face transmit.
!>
!> The force vector k (e − e^p) of the jump returns at t₀ + θΔt to a circle with the radius of the
!> cap, which is constant in a step.  By this generalised midpoint rule, losses are not negative.
module dda_jump_law
   use dda_kinds, only: wp
   use dda_material_law, only: material_law_type, strain_point_type, loss_plastic, loss_scheme, &
      losses
   use dda_plane_branches, only: return_to_cap
   use dda_scheme, only: step_type
   implicit none
   private
   public :: jump_law_type

   !> Law of all jumps; the cap and the stiffness belong to the point.
   type, extends(material_law_type) :: jump_law_type
   contains
      procedure :: state_size, respond => find_force, finish => finish_step, stored
   end type jump_law_type

contains

   !> Return the number of state variables: the plastic jump.
   pure integer function state_size(self)
      class(jump_law_type), intent(in) :: self  !< law

      state_size = 2
   end function state_size

   !> Find the change of the force in a step, and its tangent.
   pure subroutine find_force(self, point, state, strain, change, step, stress, tangent)
      class(jump_law_type), intent(in) :: self           !< law
      type(strain_point_type), intent(in) :: point       !< point
      real(wp), intent(in) :: state(:)                   !< [any] state at the start of the step
      real(wp), intent(in) :: strain(3), change(3)       !< jump at the start, and its change, m
      type(step_type), intent(in) :: step                !< the present step
      real(wp), intent(out) :: stress(3), tangent(3, 3)  !< force, N/m; tangent, N/m²
      real(wp) :: force(2), slope(2, 2)

      associate (k => point%elasticity(1, 1), theta => step%scheme%theta)
         call return_to_cap(point%start_stress(1:2) + k*(strain(1:2) - state(1:2) &
            + theta*change(1:2)), point%cap, force, slope)
         stress = [force - point%start_stress(1:2), 0.0_wp]
         tangent = 0.0_wp
         tangent(1:2, 1:2) = theta*k*slope
      end associate
   end subroutine find_force

   !> Find the state at the end of a step, and its losses.
   pure subroutine finish_step(self, point, state, strain, change, step, loss)
      class(jump_law_type), intent(in) :: self       !< law
      type(strain_point_type), intent(in) :: point   !< point
      real(wp), intent(inout) :: state(:)  !< [any] state at the start; on return at the end
      real(wp), intent(in) :: strain(3), change(3)   !< jump at the start, and its change, m
      type(step_type), intent(in) :: step            !< the present step
      real(wp), intent(out) :: loss(losses)          !< J/m
      real(wp) :: trial(2), force(2), slope(2, 2), flow(2)

      associate (k => point%elasticity(1, 1), theta => step%scheme%theta)
         trial = point%start_stress(1:2) + k*(strain(1:2) - state(1:2) + theta*change(1:2))
         call return_to_cap(trial, point%cap, force, slope)
         flow = (trial - force)/(theta*k)
         loss = 0.0_wp
         loss(loss_plastic) = dot_product(force, flow)
         loss(loss_scheme) = (theta - 0.5_wp)*k*sum((change(1:2) - flow)**2)
      end associate
      state(1:2) = state(1:2) + flow
   end subroutine finish_step

   !> Return the stored energy ψ, J/m.
   pure real(wp) function stored(self, point, state, strain)
      class(jump_law_type), intent(in) :: self      !< law
      type(strain_point_type), intent(in) :: point  !< point
      real(wp), intent(in) :: state(:)              !< [any] state of the point
      real(wp), intent(in) :: strain(3)             !< jump, m

      associate (elastic => strain(1:2) - state(1:2))
         stored = dot_product(elastic, point%start_stress(1:2) + 0.5_wp*point%elasticity(1, &
            1)*elastic)
      end associate
   end function stored

end module dda_jump_law
