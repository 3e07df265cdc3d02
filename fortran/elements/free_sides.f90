! SPDX-License-Identifier: GPL-3.0-or-later
!> Sides with a free field: the forces of neighbouring blocks in level ground, and dashpots on the
!> motion relative to this ground.
!>
!> The column of the side computes its step first and provides forces and motion (`dda_columns`).
!> A model of level ground moves like its column, so its dashpots exert no force.
!>
!> In statics only the forces of the column in equilibrium act.
module dda_free_sides
   use dda_kinds, only: wp
   use dda_absorbing, only: absorbing_type, new_absorbing_boundaries
   use dda_blocks, only: blocks_type
   use dda_free_field, only: free_field_type
   use dda_linear_terms, only: term_free_side
   use dda_motion, only: motion_type
   use dda_scheme, only: step_type
   implicit none
   private
   public :: free_sides_type, new_free_sides

   !> Gauss points of all free-field sides; `reaction` is the force of the neighbours.
   type, extends(absorbing_type) :: free_sides_type
      integer, allocatable :: field(:)    !< [points] free field of the point
      real(wp), allocatable :: ground_increment(:,:)  !< [2,points] Δu of the ground, m
   contains
      procedure :: freeze_for_statics, balance_reactions, motion_increment
   end type free_sides_type

contains

   !> Create the sides of a model, without neighbours.
   type(free_sides_type) function new_free_sides(fields) result(self)
      type(free_field_type), intent(in) :: fields(:)  !< fields of the model
      integer :: i, k

      self%absorbing_type = new_absorbing_boundaries([(fields(i)%boundary, i=1, size(fields))], &
         [motion_type ::], 0.0_wp)
      self%kind = term_free_side
      self%field = [((i, k=1, size(fields(i)%boundary%point)), i=1, size(fields))]
      allocate (self%ground_increment(2, size(self%point)), source=0.0_wp)
   end function new_free_sides

   !> Return the displacement of the free field over a step along the normal and along the edge, m.
   pure function motion_increment(self, i, step) result(increment)
      class(free_sides_type), intent(in) :: self   !< elements of this kind
      integer, intent(in) :: i                     !< number of the point
      type(step_type), intent(in) :: step          !< the present step
      real(wp) :: increment(2)

      increment = self%ground_increment(:, i)
   end function motion_increment

   !> Freeze the sides for statics: deactivate their dashpots.
   subroutine freeze_for_statics(self, blocks, time)
      class(free_sides_type), intent(inout) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks        !< blocks in their present state
      real(wp), intent(in) :: time                   !< time, s

      self%dashpot = 0.0_wp
   end subroutine freeze_for_statics

   !> Do nothing after statics, because the forces of the neighbours are prescribed.
   subroutine balance_reactions(self, blocks, unbalanced)
      class(free_sides_type), intent(inout) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks        !< blocks in static equilibrium
      real(wp), intent(in) :: unbalanced(:,:)        !< [6,blocks] sum of all forces, N/m …
   end subroutine balance_reactions

end module dda_free_sides
