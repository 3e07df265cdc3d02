! SPDX-License-Identifier: GPL-3.0-or-later
!> A joint between two sets of blocks whose slip, opening and force are written to the output.
module dda_measured_joint
   implicit none
   private
   public :: measured_joint_type

   !> The blocks on its two sides.
   type :: measured_joint_type
      character(len=64) :: name = ''
      !> [blocks] 1: in the set whose slip and force are reported, 2: in the other set, 0: neither
      integer, allocatable :: side(:)
   end type measured_joint_type

end module dda_measured_joint
