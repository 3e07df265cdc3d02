! SPDX-License-Identifier: GPL-3.0-or-later
!> A prescribed motion by name: a record made into acceleration, velocity and displacement curves.
module dda_motion
   use dda_baseline, only: motion_curve_type
   implicit none
   private
   public :: motion_type

   !> A motion of the ground or of a support.
   type :: motion_type
      character(len=64) :: name = ''
      character(len=:), allocatable :: file    !< record file, '' if the values stand in the input
      !> record file and what was done to it, for provenance
      character(len=:), allocatable :: source
      type(motion_curve_type) :: curve
      logical :: stops = .false.               !< the input says that it is held after its end
   end type motion_type

end module dda_motion
