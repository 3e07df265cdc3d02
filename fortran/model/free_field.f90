! SPDX-License-Identifier: GPL-3.0-or-later
!> A side of the model with level ground beyond it: the column of blocks at that side, its own
!> neighbour on both sides, is the free field; dashpots absorb the radiated waves.
module dda_free_field
   use dda_boundary, only: boundary_type
   use dda_support, only: point_type
   use dda_tie, only: tie_type
   use dda_weld, only: weld_type
   implicit none
   private
   public :: free_field_type

   !> The free field at a side.
   type :: free_field_type
      character(len=8) :: side = ''          !< 'left' or 'right'
      !> which face of each tie and weld is at the side of the model: 1, of the right ones; 2, of
      !> the left
      integer :: face = 0
      integer, allocatable :: block(:)       !< [any] of the model, that the column is made of
      type(point_type) :: top                !< upper end of the side, in the model
      !> [any] its right with its left faces, in vertices of the column
      type(tie_type), allocatable :: tie(:)
      type(weld_type), allocatable :: weld(:)  !< [any] the same, where a body continues
      type(boundary_type) :: boundary        !< dashpots at the side, without a motion
   end type free_field_type

end module dda_free_field
