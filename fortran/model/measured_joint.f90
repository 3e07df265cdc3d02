! SPDX-License-Identifier: GPL-3.0-or-later
!> A joint between two sets of blocks whose slip, opening and force are written to the output.
module dda_measured_joint
   implicit none
   private
   public :: measured_joint_type

   !> A measured joint and the blocks on its two sides.
   type :: measured_joint_type
      character(len=64) :: name = ''
      !> [blocks] 1: set whose slip and force are reported; 2: other set; 0: neither
      integer, allocatable :: side(:)
   end type measured_joint_type

end module dda_measured_joint
