! SPDX-License-Identifier: GPL-3.0-or-later
!> Side of a model with a free field.  The free field is the motion of a column of the blocks at
!> this side, whose two sides are tied to each other.  Dashpots absorb radiated waves.
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
      !> face of each tie and weld that is at the side of the model: 1 (right faces) or 2 (left)
      integer :: face = 0
      integer, allocatable :: block(:)       !< [any] blocks of the model that form the column
      type(point_type) :: top                !< upper end of the side in the model
      !> [any] ties of right with left faces, in vertices of the column
      type(tie_type), allocatable :: tie(:)
      type(weld_type), allocatable :: weld(:)  !< [any] welds of right with left faces of the column
      type(boundary_type) :: boundary        !< dashpots at the side, without a motion
   end type free_field_type

end module dda_free_field
