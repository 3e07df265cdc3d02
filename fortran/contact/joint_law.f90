! SPDX-License-Identifier: GPL-3.0-or-later
!> A joint law: the forces of one contact at a closure of its joint and a stretch of its shear
!> spring.
!>
!> What all laws share: the closure x counts from where the joint is free of force, so that it is
!> the penetration plus the lift of the dilation; the normal force has a convex potential `stored`;
!> the shear force is elastic up to `strength`, which follows the normal force.  A law overrides
!> what it has of its own.  Stiffness is that of a contact, or per area: times the tributary length
!> of the contact.
module dda_joint_law
   use dda_kinds, only: wp, pi
   use dda_material, only: joint_type
   implicit none
   private
   public :: joint_law_type, joint_state_type, strength_type, reduced_angle

   real(wp), parameter :: steepest = 89.0_wp  !< friction angle that an input may have, degrees

   !> Memory of a contact of a joint.
   type :: joint_state_type
      real(wp) :: length     !< tributary length, m
      real(wp) :: slip_path  !< slip beyond the elastic one, both ways added up, m
      real(wp) :: weakened   !< 0: peak strength, 1: residual strength
      real(wp) :: share = 1.0_wp  !< of the stiffness of a contact, where that is not per area
      real(wp) :: net_slip = 0.0_wp !< slip beyond the elastic one, with its sign, m
      real(wp) :: lifted = 0.0_wp   !< how far slip has lifted it, where the way matters, m
      real(wp) :: way = 1.0_wp      !< sign of the shear force that is asked about
   end type joint_state_type

   !> A variable of &joint that strength depends on.
   type :: strength_type
      character(len=32) :: name    !< in the input
      real(wp) :: value            !< in its unit there
   end type strength_type

   !> The parameters of one joint material.
   type, abstract :: joint_law_type
      real(wp) :: normal_stiffness = 0.0_wp  !< at small closure, N/m, or Pa/m per area
      real(wp) :: shear_stiffness = 0.0_wp   !< N/m, or Pa/m per area
      logical :: normal_per_area = .false.
      logical :: shear_per_area = .false.
      logical :: brittle = .false.           !< an intact contact sticks until it breaks
      logical :: curved = .false.            !< the normal force is not linear in the closure
      logical :: dilates = .false.           !< slip lifts the contact
      logical :: has_centre = .false.        !< slip from a centre and slip back to it differ
      logical :: cohesive = .false.          !< a bond beside the contact is damaged step by step
      integer :: points = 2                  !< contact points of an overlap, if not given
      !> variables of &joint that it cannot do without
      character(len=24) :: needs(3) = [character(len=24) :: 'friction_angle', '', '']
   contains
      procedure :: initial_spring
      procedure :: shear_spring
      procedure :: normal_force => linear_force
      procedure :: tangent => linear_tangent
      procedure :: closure => linear_closure
      procedure :: stored => linear_energy
      procedure(strength_at), deferred :: strength
      procedure(reduced_strength), deferred :: reduced
      procedure :: tension => no_tension
      procedure :: slipped => longer_path
      procedure :: lift => no_lift
      procedure :: sliding_force => force_without_lift
      procedure :: damage => same_damage
      procedure :: spent => nothing_spent
      procedure :: bond_energy => no_bond
      procedure :: complete => complete_nothing
   end type joint_law_type

   abstract interface
      !> Largest shear force, N/m.
      pure real(wp) function strength_at(law, state, normal_force)
         import :: joint_law_type, joint_state_type, wp
         class(joint_law_type), intent(in) :: law     !< of the joint
         type(joint_state_type), intent(in) :: state  !< of the contact
         real(wp), intent(in) :: normal_force         !< compression positive, N/m
      end function strength_at

      !> The variables of &joint with which all strength is divided by a factor.
      pure function reduced_strength(law, joint, factor) result(strengths)
         import :: joint_law_type, joint_type, strength_type, wp
         class(joint_law_type), intent(in) :: law  !< of the joint
         type(joint_type), intent(in) :: joint     !< that it was made of
         real(wp), intent(in) :: factor            !< above 0
         type(strength_type), allocatable :: strengths(:)
      end function reduced_strength
   end interface

contains

   !> Set what follows from other variables of &joint, and say what is wrong with those of the law;
   !> blank: nothing.
   pure subroutine complete_nothing(law, joint, shear_ratio, wrong)
      class(joint_law_type), intent(in) :: law       !< of the joint
      type(joint_type), intent(inout) :: joint       !< as read, with what the law needs
      real(wp), intent(in) :: shear_ratio            !< k_n/k_s, where the joint has none of its own
      character(len=:), allocatable, intent(out) :: wrong  !< in words; blank: nothing

      wrong = ''
   end subroutine complete_nothing

   !> Friction angle whose tangent is divided by a factor, degrees.
   pure real(wp) function reduced_angle(angle, factor)
      real(wp), intent(in) :: angle   !< degrees
      real(wp), intent(in) :: factor  !< above 0

      reduced_angle = min(steepest, atan(tan(angle*(pi/180.0_wp))/factor)*(180.0_wp/pi))
   end function reduced_angle

   !> Normal stiffness at no closure, N/m.
   pure real(wp) function initial_spring(law, state) result(spring)
      class(joint_law_type), intent(in) :: law     !< of the joint
      type(joint_state_type), intent(in) :: state  !< of the contact

      spring = law%normal_stiffness*merge(state%length, state%share, law%normal_per_area)
   end function initial_spring

   !> Shear stiffness, N/m.
   pure real(wp) function shear_spring(law, state) result(spring)
      class(joint_law_type), intent(in) :: law     !< of the joint
      type(joint_state_type), intent(in) :: state  !< of the contact

      spring = law%shear_stiffness*merge(state%length, state%share, law%shear_per_area)
   end function shear_spring

   !> Normal force at a closure, N/m.
   pure real(wp) function linear_force(law, state, closure) result(force)
      class(joint_law_type), intent(in) :: law     !< of the joint
      type(joint_state_type), intent(in) :: state  !< of the contact
      real(wp), intent(in) :: closure              !< m

      force = law%initial_spring(state)*closure
   end function linear_force

   !> Slope of the normal force, N/m.
   pure real(wp) function linear_tangent(law, state, closure) result(tangent)
      class(joint_law_type), intent(in) :: law     !< of the joint
      type(joint_state_type), intent(in) :: state  !< of the contact
      real(wp), intent(in) :: closure              !< m

      tangent = law%initial_spring(state)
   end function linear_tangent

   !> The closure at a normal force, m.
   pure real(wp) function linear_closure(law, state, force) result(closure)
      class(joint_law_type), intent(in) :: law     !< of the joint
      type(joint_state_type), intent(in) :: state  !< of the contact
      real(wp), intent(in) :: force                !< compression positive, N/m

      closure = force/law%initial_spring(state)
   end function linear_closure

   !> Potential of the normal force, J per metre of thickness.
   pure real(wp) function linear_energy(law, state, closure) result(energy)
      class(joint_law_type), intent(in) :: law     !< of the joint
      type(joint_state_type), intent(in) :: state  !< of the contact
      real(wp), intent(in) :: closure              !< m

      energy = 0.5_wp*law%initial_spring(state)*closure**2
   end function linear_energy

   !> Largest tension of a bonded contact, N/m; here: none.
   pure real(wp) function no_tension(law, state) result(tension)
      class(joint_law_type), intent(in) :: law     !< of the joint
      type(joint_state_type), intent(in) :: state  !< of the contact

      tension = 0.0_wp
   end function no_tension

   !> The state after a slip beyond the elastic one; here: the path of the slip is longer.
   pure type(joint_state_type) function longer_path(law, state, slip, shear_force) result(after)
      class(joint_law_type), intent(in) :: law     !< of the joint
      type(joint_state_type), intent(in) :: state  !< before
      real(wp), intent(in) :: slip                 !< with its sign, m
      real(wp), intent(in) :: shear_force          !< under which it slips, N/m

      after = state
      after%slip_path = state%slip_path + abs(slip)
   end function longer_path

   !> Lift of the contact by slip, m; here: none.
   pure real(wp) function no_lift(law, state) result(lift)
      class(joint_law_type), intent(in) :: law     !< of the joint
      type(joint_state_type), intent(in) :: state  !< of the contact

      lift = 0.0_wp
   end function no_lift

   !> Normal force of a contact that slides, N/m: with the lift of the slip of this step.
   pure real(wp) function force_without_lift(law, state, closure, stretch) result(force)
      class(joint_law_type), intent(in) :: law     !< of the joint
      type(joint_state_type), intent(in) :: state  !< at the start of the step
      real(wp), intent(in) :: closure              !< at the end, without the lift of this step, m
      real(wp), intent(in) :: stretch              !< of the shear spring if nothing slipped, ≥ 0, m

      force = law%normal_force(state, closure)
   end function force_without_lift

   !> Damage of a bond at an opening and a slip, at least that before; here: that.
   pure real(wp) function same_damage(law, opening, slip, before) result(damage)
      class(joint_law_type), intent(in) :: law  !< of the joint
      real(wp), intent(in) :: opening, slip     !< m
      real(wp), intent(in) :: before            !< damage so far

      damage = before
   end function same_damage

   !> Fracture energy spent between two damages, N/m; here: none.
   pure real(wp) function nothing_spent(law, opening, slip, from, to) result(spent)
      class(joint_law_type), intent(in) :: law  !< of the joint
      real(wp), intent(in) :: opening, slip     !< m
      real(wp), intent(in) :: from, to          !< damage

      spent = 0.0_wp
   end function nothing_spent

   !> Energy of a bond beyond that of the contact beside it, N/m; here: none.
   pure real(wp) function no_bond(law, opening, slip) result(energy)
      class(joint_law_type), intent(in) :: law  !< of the joint
      real(wp), intent(in) :: opening, slip     !< m

      energy = 0.0_wp
   end function no_bond

end module dda_joint_law
