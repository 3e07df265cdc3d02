! SPDX-License-Identifier: GPL-3.0-or-later
!> Law of a material at a strain point: stress and tangent of a step, energies, state.
!>
!> The strains ε (εx, εy, γxy) of a point count from the start of its law, at the stress σ₀.
!> A material without a law is linear elastic, σ = σ₀ + Dε, and calls no procedure of this type.
!> In a step from ε to ε + Δε the acting stress s satisfies exactly
!>
!>     s·Δε = Δψ + loss by the law + loss by the scheme ,
!>
!> where ψ is the stored energy and both losses are ≥ 0.  A new law needs one file in `soil` that
!> extends `material_law_type`, and its name in `dda_input_material`.
module dda_material_law
   use dda_kinds, only: wp
   use dda_scheme, only: step_type
   implicit none
   private
   public :: material_law_type, strain_point_type, loss_plastic, loss_damping, loss_scheme, losses

   integer, parameter :: loss_plastic = 1  !< loss by slip or yielding
   integer, parameter :: loss_damping = 2  !< loss by small-strain damping
   integer, parameter :: loss_scheme = 3   !< loss by the time integration
   integer, parameter :: losses = 3

   !> Data of a point for its law.
   type :: strain_point_type
      real(wp) :: elasticity(3, 3) = 0.0_wp  !< D of small strains, Pa
      real(wp) :: start_stress(3) = 0.0_wp   !< σ₀, Pa
      logical :: plane_strain = .true.       !< plane strain; .false.: plane stress
      real(wp) :: length = 0.0_wp            !< root of the area, m
      real(wp) :: thickness = 0.0_wp         !< area/length for a face, else `length`, m
      real(wp) :: cap = huge(1.0_wp)         !< largest force of a jump, N/m
      real(wp) :: strength = 0.0_wp          !< strength of a broken face in tension, Pa
      real(wp) :: bounding(3) = 0.0_wp       !< stresses that set the frozen bounds, Pa
   end type strain_point_type

   !> A material law.
   type, abstract :: material_law_type
   contains
      procedure(state_interface), deferred :: state_size
      procedure(respond_interface), deferred :: respond
      procedure(finish_interface), deferred :: finish
      procedure(stored_interface), deferred :: stored
      procedure :: rests => never_rests
      procedure :: frozen_stress => no_frozen_stress
      procedure :: plastic_strain => no_plastic_strain
      procedure :: yields => never_yields
      procedure :: jump_cap => no_cap
      procedure :: shape_stress => no_shape_stress
      procedure :: pressure => no_pressure
      procedure :: secant => full_secant
      procedure :: fit_text => no_text
      procedure :: unmet => no_text
      procedure :: largest_thickness => any_thickness
   end type material_law_type

   abstract interface
      !> Number of state variables of a point; all are 0 at the start of the law.
      pure integer function state_interface(self)
         import :: material_law_type
         class(material_law_type), intent(in) :: self  !< law
      end function state_interface

      !> Stress in a step minus σ₀, and its derivative with respect to Δε, which is symmetric.
      pure subroutine respond_interface(self, point, state, strain, change, step, stress, tangent)
         import :: material_law_type, strain_point_type, step_type, wp
         class(material_law_type), intent(in) :: self       !< law
         type(strain_point_type), intent(in) :: point       !< data of the point
         real(wp), intent(in) :: state(:)                   !< [any] state at the start of the step
         real(wp), intent(in) :: strain(3), change(3)       !< ε at the start, Δε
         type(step_type), intent(in) :: step                !< the present step
         real(wp), intent(out) :: stress(3), tangent(3, 3)  !< Pa
      end subroutine respond_interface

      !> State at the end of a step, and its losses.
      pure subroutine finish_interface(self, point, state, strain, change, step, loss)
         import :: material_law_type, strain_point_type, step_type, losses, wp
         class(material_law_type), intent(in) :: self  !< law
         type(strain_point_type), intent(in) :: point  !< data of the point
         real(wp), intent(inout) :: state(:)  !< [any] state at the start; on return at the end
         real(wp), intent(in) :: strain(3), change(3)  !< ε at the start, Δε
         type(step_type), intent(in) :: step           !< the present step
         real(wp), intent(out) :: loss(losses)         !< J/m³
      end subroutine finish_interface

      !> Stored energy ψ, J/m³.
      pure real(wp) function stored_interface(self, point, state, strain)
         import :: material_law_type, strain_point_type, wp
         class(material_law_type), intent(in) :: self  !< law
         type(strain_point_type), intent(in) :: point  !< data of the point
         real(wp), intent(in) :: state(:)              !< [any] state of the point
         real(wp), intent(in) :: strain(3)             !< ε
      end function stored_interface
   end interface

contains

   !> .true. if the material is linear elastic in static stages; default: .false.
   pure logical function never_rests(self)
      class(material_law_type), intent(in) :: self  !< law

      never_rests = .false.
   end function never_rests

   !> Return the stresses that set the frozen bounds of a law in a step; default: 0.
   pure function no_frozen_stress(self, point, state, strain, change, step) result(stress)
      class(material_law_type), intent(in) :: self  !< law
      type(strain_point_type), intent(in) :: point  !< data of the point
      real(wp), intent(in) :: state(:)              !< [any] state at the start of the step
      real(wp), intent(in) :: strain(3), change(3)  !< ε at the start, Δε
      type(step_type), intent(in) :: step           !< the present step
      real(wp) :: stress(3)

      stress = 0.0_wp
   end function no_frozen_stress

   !> Magnitude of the plastic strain of a point; default: 0.
   pure real(wp) function no_plastic_strain(self, state)
      class(material_law_type), intent(in) :: self  !< law
      real(wp), intent(in) :: state(:)              !< [any] state of a point

      no_plastic_strain = 0.0_wp
   end function no_plastic_strain

   !> .true. if the law limits stresses, including stresses of jumps of welded faces; default:
   !> .false.
   pure logical function never_yields(self)
      class(material_law_type), intent(in) :: self  !< law

      never_yields = .false.
   end function never_yields

   !> Largest stress of the jumps of a face in a step, Pa; default: no limit.
   pure real(wp) function no_cap(self, point, state, strain)
      class(material_law_type), intent(in) :: self  !< law
      type(strain_point_type), intent(in) :: point  !< point of the face
      real(wp), intent(in) :: state(:)              !< [any] state of the point
      real(wp), intent(in) :: strain(3)             !< ε at the start of the step

      no_cap = huge(1.0_wp)
   end function no_cap

   !> Stress, Pa, for the work of the mean stress on the area change that tr ε neglects; default: 0.
   pure function no_shape_stress(self, state) result(stress)
      class(material_law_type), intent(in) :: self  !< law
      real(wp), intent(in) :: state(:)              !< [any] state of the point
      real(wp) :: stress(3)

      stress = 0.0_wp
   end function no_shape_stress

   !> Mean in-plane pressure at the end of the last step, Pa; default: 0.
   pure real(wp) function no_pressure(self, state)
      class(material_law_type), intent(in) :: self  !< law
      real(wp), intent(in) :: state(:)              !< [any] state of the point

      no_pressure = 0.0_wp
   end function no_pressure

   !> Ratio of the secant modulus at a shear strain to the small-strain modulus; default: 1.
   pure real(wp) function full_secant(self, strain)
      class(material_law_type), intent(in) :: self  !< law
      real(wp), intent(in) :: strain                !< amplitude of the loops, above 0

      full_secant = 1.0_wp
   end function full_secant

   !> Text on the fit of the law to its curves; default: blank.
   function no_text(self) result(text)
      class(material_law_type), intent(in) :: self  !< law
      character(len=:), allocatable :: text

      text = ''
   end function no_text

   !> Thickness of a point, m, above which it softens faster than it unloads; default: no limit.
   pure real(wp) function any_thickness(self, elasticity)
      class(material_law_type), intent(in) :: self  !< law
      real(wp), intent(in) :: elasticity(3, 3)      !< D of small strains, Pa

      any_thickness = huge(1.0_wp)
   end function any_thickness

end module dda_material_law
