! SPDX-License-Identifier: GPL-3.0-or-later
!> Rules that end a run before its duration (group &stop).
module dda_stop_settings
   use dda_kinds, only: wp
   implicit none
   private
   public :: stop_settings_type

   !> Limits; each limit above 0 is active.
   type :: stop_settings_type
      real(wp) :: displacement = 0.0_wp    !< displacement of a centroid, m
      real(wp) :: tilt = 0.0_wp            !< tilt of a block in either direction, rad
      integer :: fallen = 0                !< number of blocks displaced by more than their size
      real(wp) :: rest_time = 0.0_wp       !< time without movement, s
      real(wp) :: rest_movement = 0.0_wp   !< tolerated movement of a vertex in this time, m
      integer :: reference = 0          !< reference block of movements; 0: initial positions
      logical, allocatable :: watched(:)   !< [blocks] selected; not allocated: no rule
   end type stop_settings_type

end module dda_stop_settings
