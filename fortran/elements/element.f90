! SPDX-License-Identifier: GPL-3.0-or-later
!> Interface of elements, such as supports, loads, body forces, dashpots and bolts.
!>
!> Assembly, energy budget, checks and transfer functions use elements through this interface.  An
!> object contains all elements of its kind.  A new kind needs one file that extends `element_type`
!> and overrides the procedures that differ, and one line of registration in `dda_elements`.
module dda_element
   use dda_kinds, only: wp
   use dda_archive, only: archive_type
   use dda_block_matrix, only: block_matrix_type
   use dda_blocks, only: blocks_type
   use dda_energy, only: energy_type
   use dda_linear_terms, only: linear_terms_type
   use dda_motion, only: motion_type
   use dda_scheme, only: step_type
   implicit none
   private
   public :: element_type

   !> All elements of a kind.
   type, abstract :: element_type
      !> motions of the model, if the elements need them
      type(motion_type), allocatable :: motions(:)
      logical :: packs = .false.  !< `add_packed` can replace the list of `add_linear_terms`
   contains
      procedure :: add_linear_terms => add_no_linear
      procedure :: add_packed => add_none_packed
      procedure(force_interface), deferred :: add_force
      procedure :: add_stored_energy => add_no_stored
      procedure(budget_interface), deferred :: add_to_budget
      procedure :: accept_step => accept_nothing
      procedure :: match_velocity => match_nothing
      procedure :: freeze_for_statics => freeze_nothing
      procedure :: prepare_step => prepare_nothing
      procedure :: revise_states => revise_nothing
      procedure :: slope_beyond => no_slope
      procedure :: inherit_state => inherit_nothing
      procedure :: balance_reactions => balance_nothing
      procedure :: serialise => serialise_nothing
   end type element_type

   abstract interface
      !> Add the forces of a step at d = 0 to f̂.
      subroutine force_interface(self, blocks, step, load)
         import :: element_type, blocks_type, step_type, wp
         class(element_type), intent(in) :: self  !< elements of this kind
         type(blocks_type), intent(in) :: blocks       !< blocks at the start of the step
         type(step_type), intent(in) :: step  !< the present step
         real(wp), intent(inout) :: load(:,:)          !< [6,blocks] forces, N/m …
      end subroutine force_interface

      !> Add work, losses and stored energy of the converged increment d before it is applied.
      subroutine budget_interface(self, blocks, step, d, energy)
         import :: element_type, blocks_type, step_type, energy_type, wp
         class(element_type), intent(in) :: self  !< elements of this kind
         type(blocks_type), intent(in) :: blocks       !< blocks at the start of the step
         type(step_type), intent(in) :: step  !< the present step
         real(wp), intent(in) :: d(:,:)                !< [6,blocks] increments of the coordinates
         type(energy_type), intent(inout) :: energy    !< energy budget, J per metre
      end subroutine budget_interface
   end interface

contains

   !> Append springs and dashpots in the present geometry; default: none.
   subroutine add_no_linear(self, blocks, step, terms)
      class(element_type), intent(in) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(step_type), intent(in) :: step  !< the present step
      type(linear_terms_type), intent(inout) :: terms  !< springs and dashpots
   end subroutine add_no_linear

   !> Add the terms of `add_linear_terms` to K̂ without a list; default: none.
   subroutine add_none_packed(self, matrix, fits)
      class(element_type), intent(in) :: self  !< elements of this kind
      type(block_matrix_type), intent(inout) :: matrix  !< linear part of K̂
      logical, intent(inout) :: fits  !< set to .false. if the pattern lacks a pair
   end subroutine add_none_packed

   !> Add the energy stored in the present state; default: none.
   subroutine add_no_stored(self, blocks, step, energy)
      class(element_type), intent(in) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(step_type), intent(in) :: step           !< the next step
      type(energy_type), intent(inout) :: energy    !< energy budget, J per metre
   end subroutine add_no_stored

   !> Accept the step: update the state of the element; default: none.
   subroutine accept_nothing(self, blocks, step, d)
      class(element_type), intent(inout) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks       !< blocks at the start of the step
      type(step_type), intent(in) :: step  !< the present step
      real(wp), intent(in) :: d(:,:)                !< [6,blocks] increments of the coordinates
   end subroutine accept_nothing

   !> Linearise at an increment, before a step or a check of equilibrium; default: do nothing.
   subroutine prepare_nothing(self, blocks, step, d)
      class(element_type), intent(inout) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks       !< blocks at the start of the step
      type(step_type), intent(in) :: step           !< the present step
      real(wp), intent(in) :: d(:,:)                !< [6,blocks] increments of the coordinates
   end subroutine prepare_nothing

   !> Revise the assumed states that contradict a converged solution; default: none.
   subroutine revise_nothing(self, blocks, step, d, changed)
      class(element_type), intent(inout) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks       !< blocks at the start of the step
      type(step_type), intent(in) :: step           !< the present step
      real(wp), intent(in) :: d(:,:)                !< [6,blocks] increments of the coordinates
      integer, intent(inout) :: changed             !< number of changed states
   end subroutine revise_nothing

   !> Return the energy slope of nonlinear forces on the path between two increments; default: none.
   !> Unit: J per metre of thickness.
   real(wp) function no_slope(self, blocks, step, from, to, fraction)
      class(element_type), intent(in) :: self     !< elements of this kind
      type(blocks_type), intent(in) :: blocks     !< blocks at the start of the step
      type(step_type), intent(in) :: step         !< the present step
      real(wp), intent(in) :: from(:,:), to(:,:)  !< [6,blocks] increments of the coordinates
      real(wp), intent(in) :: fraction            !< fraction of the path, 0 … 1

      no_slope = 0.0_wp
   end function no_slope

   !> Correct initial velocities that a stiff element does not permit; default: none.
   subroutine match_nothing(self, blocks, step, velocity)
      class(element_type), intent(in) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(step_type), intent(in) :: step           !< the next step
      real(wp), intent(inout) :: velocity(:,:)      !< [6,blocks] velocities, 1/s …
   end subroutine match_nothing

   !> Freeze loads and prescribed positions at their values at a time; default: none.
   subroutine freeze_nothing(self, blocks, time)
      class(element_type), intent(inout) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks       !< blocks in their present state
      real(wp), intent(in) :: time  !< time at which loads and prescribed positions are frozen, s
   end subroutine freeze_nothing

   !> Inherit the state of the former element after a change of model or stage; default: none.
   subroutine inherit_nothing(self, former, blocks)
      class(element_type), intent(inout) :: self  !< elements of this kind
      class(element_type), intent(in) :: former     !< former element, of the same type
      type(blocks_type), intent(in) :: blocks       !< blocks in their present state
   end subroutine inherit_nothing

   !> Add unbalanced forces after statics to constant reactions; default: none.
   subroutine balance_nothing(self, blocks, unbalanced)
      class(element_type), intent(inout) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks       !< blocks in static equilibrium
      real(wp), intent(in) :: unbalanced(:,:)       !< [6,blocks] sum of all forces, N/m …
   end subroutine balance_nothing

   !> Save or restore the state of the element; default: none.
   subroutine serialise_nothing(self, archive)
      class(element_type), intent(inout) :: self  !< elements of this kind
      type(archive_type), intent(inout) :: archive  !< archive that is written or read
   end subroutine serialise_nothing

end module dda_element
