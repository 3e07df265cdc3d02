! SPDX-License-Identifier: GPL-3.0-or-later
!> A bolt: one or two springs between material points, with an elastic–plastic law.
!>
!> A bolt with two anchors is one spring along the line between them; a cable passes more points
!> between its ends, without friction.  A grouted bolt is a pair of springs, along and across its
!> axis, at each joint that it crosses.
module dda_bolt
   use dda_kinds, only: wp
   implicit none
   private
   public :: bolt_type, axial, across, never, max_points

   integer, parameter :: axial = 1, across = 2  !< components of a bolt
   integer, parameter :: max_points = 64  !< largest number of points of a bolt, with its ends
   real(wp), parameter :: never = 0.1_wp*huge(1.0_wp)  !< strength that is never reached

   !> One spring of a bolt (group &bolt).
   type :: bolt_type
      character(len=64) :: name = ''
      logical :: grouted = .false.  !< grouted at a joint; .false.: between two anchors
      logical :: compression = .false.              !< the bolt also resists compression
      logical :: present = .true.                   !< the bolt is part of the model in this stage
      integer, allocatable :: block(:)              !< [points] block of each point
      real(wp), allocatable :: reference(:,:)       !< [2,points] offsets ρ from the centroids, m
      real(wp), allocatable :: position(:,:)           !< [2,points] initial positions, m
      real(wp) :: direction(2) = 0.0_wp  !< initial axis, which turns with the first block
      real(wp) :: stiffness(2) = 0.0_wp             !< axial, across; N/m per metre of thickness
      real(wp) :: pretension = 0.0_wp               !< N per metre of thickness
      real(wp) :: yield(2) = never                  !< yield forces, N/m
      real(wp) :: rupture(2) = never                !< stretch since installation, m
   end type bolt_type

end module dda_bolt
