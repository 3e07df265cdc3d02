! SPDX-License-Identifier: GPL-3.0-or-later
!> Coulomb joint whose faces crush: the normal stress is at most the compressive strength σ_c.
!>
!> At a closure x, measured from the plastic closure p of the previous steps, the normal force is
!> min(k_n x, σ_c L), with a convex potential.  At the end of a step the closure in excess of
!> σ_c L/k_n is added to p, and σ_c L Δp is dissipated; unloading is elastic.  With a fracture
!> energy G_c, the strength in the next step is σ_c (1 − p σ_c/2G_c), which is 0 at p = 2 G_c/σ_c.
module dda_crushing
   use dda_kinds, only: wp
   use dda_coulomb, only: coulomb_type, new_coulomb
   use dda_group_values, only: unset
   use dda_joint_law, only: column_type, joint_state_type, strength_type, slip_path
   use dda_material, only: joint_type
   implicit none
   private
   public :: crushing_type, new_crushing

   integer, parameter :: crushed = 3  !< column of p
   real(wp), parameter :: round_off = 1.0e-9_wp  !< relative rounding of the strength

   !> Coulomb joint with a compressive strength.
   type, extends(coulomb_type) :: crushing_type
      real(wp) :: compressive = huge(1.0_wp)  !< σ_c, Pa
      real(wp) :: last = huge(1.0_wp)         !< plastic closure at which the strength is 0, m
   contains
      procedure :: normal_force, tangent, closure, stored, state_after_slip, lift
      procedure, private :: limit
   end type crushing_type

contains

   !> Create the law of a joint material, but do not set its stiffness.
   pure type(crushing_type) function new_crushing(joint) result(law)
      type(joint_type), intent(in) :: joint  !< checked input

      law%coulomb_type = new_coulomb(joint)
      law%compressive = joint%crushing_strength
      if (joint%crushing_energy /= unset) &
         law%last = 2*joint%crushing_energy/joint%crushing_strength
      law%law_columns(1) = column_type('crushed')
      law%curved = .true.
      law%crushes = .true.
      law%inputs = [law%inputs, strength_type('crushing_strength', joint%crushing_strength)]
      if (joint%crushing_energy /= unset) law%inputs = [law%inputs, &
         strength_type('crushing_energy', joint%crushing_energy)]
      law%points = 17
   end function new_crushing

   !> Return the largest normal force after the plastic closure so far, N/m.
   pure real(wp) function limit(law, state)
      class(crushing_type), intent(in) :: law      !< law of the joint
      type(joint_state_type), intent(in) :: state  !< state of the contact

      limit = law%compressive*state%length*max(0.0_wp, 1.0_wp - state%memory(crushed)/law%last)
   end function limit

   !> Return the normal force at a closure, N/m.
   pure real(wp) function normal_force(law, state, closure) result(force)
      class(crushing_type), intent(in) :: law      !< law of the joint
      type(joint_state_type), intent(in) :: state  !< state of the contact
      real(wp), intent(in) :: closure              !< m

      force = min(law%initial_spring(state)*closure, law%limit(state))
   end function normal_force

   !> Return the slope of the normal force, N/m.
   pure real(wp) function tangent(law, state, closure)
      class(crushing_type), intent(in) :: law      !< law of the joint
      type(joint_state_type), intent(in) :: state  !< state of the contact
      real(wp), intent(in) :: closure              !< m

      tangent = law%initial_spring(state)
      if (tangent*closure > (1.0_wp + round_off)*law%limit(state)) tangent = 0.0_wp
   end function tangent

   !> Return the closure at a normal force, m; infinite at the strength.
   pure real(wp) function closure(law, state, force)
      class(crushing_type), intent(in) :: law      !< law of the joint
      type(joint_state_type), intent(in) :: state  !< state of the contact
      real(wp), intent(in) :: force                !< compression positive, N/m

      closure = huge(1.0_wp)
      if (force < law%limit(state)) closure = force/law%initial_spring(state)
   end function closure

   !> Return the potential of the normal force, J per metre of thickness.
   pure real(wp) function stored(law, state, closure) result(energy)
      class(crushing_type), intent(in) :: law      !< law of the joint
      type(joint_state_type), intent(in) :: state  !< state of the contact
      real(wp), intent(in) :: closure              !< m
      real(wp) :: elastic

      elastic = min(closure, law%limit(state)/law%initial_spring(state))
      energy = 0.5_wp*law%initial_spring(state)*elastic**2 + law%limit(state)*(closure - elastic)
   end function stored

   !> Update the state after a step: add the slip to its path and the plastic closure to p.
   pure type(joint_state_type) function state_after_slip(law, state, slip, &
      shear_force) result(after)
      class(crushing_type), intent(in) :: law      !< law of the joint
      type(joint_state_type), intent(in) :: state  !< state before the slip
      real(wp), intent(in) :: slip                 !< slip with its sign, m
      real(wp), intent(in) :: shear_force          !< shear force during slip, N/m

      after = state
      after%memory(slip_path) = state%memory(slip_path) + abs(slip)
      after%memory(crushed) = state%memory(crushed) + max(0.0_wp, state%closure &
         - state%memory(crushed) - law%limit(state)/law%initial_spring(state))
   end function state_after_slip

   !> Return the distance, m, by which plastic closure lowers the contact.
   pure real(wp) function lift(law, state)
      class(crushing_type), intent(in) :: law      !< law of the joint
      type(joint_state_type), intent(in) :: state  !< state of the contact

      lift = -state%memory(crushed)
   end function lift

end module dda_crushing
