! SPDX-License-Identifier: GPL-3.0-or-later
!> A stage of a run: the changes at its start, and its time stepping.
module dda_stage
   use dda_kinds, only: wp, long
   implicit none
   private
   public :: stage_type, never

   real(wp), parameter :: never = 0.5_wp*huge(1.0_wp)  !< time of events that have not begun, s

   !> One stage (group &stage).
   type :: stage_type
      character(len=64) :: name = ''
      logical :: static = .false.            !< static equilibrium; .false.: steps of Δt
      real(wp) :: time_step = 0.0_wp         !< Δt, s, of a dynamic stage
      integer(long) :: steps = 0             !< number of steps of a dynamic stage
      real(wp) :: duration = 0.0_wp          !< duration as given, s; 0: `steps` is given
      character(len=16) :: integration = ''  !< integration of a dynamic stage
      real(wp) :: theta = 0.75_wp            !< θ of integration 'theta'
      real(wp) :: displacement = huge(1.0_wp) !< limit for a block in a static stage, m
      logical :: zero_displacements = .false. !< displacements are measured from this stage
      logical, allocatable :: removed(:)     !< [blocks] removed
      logical, allocatable :: released(:)    !< [fixed points] released
      logical, allocatable :: added(:)       !< [bolts, then edge loads] added by the stage
      logical, allocatable :: dropped(:)     !< [bolts, then edge loads] removed by the stage
      logical, allocatable :: holds(:)       !< [fixed points] the point acts from this stage on
      logical, allocatable :: loads(:)       !< [loads] times are measured from this stage
      logical, allocatable :: begins(:)      !< [motions] begin with this stage
      integer, allocatable :: joint(:)       !< [joints] replacement of each joint
      integer, allocatable :: material(:)    !< [materials] replacement of each material
   end type stage_type

end module dda_stage
