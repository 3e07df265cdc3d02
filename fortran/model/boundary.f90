! SPDX-License-Identifier: GPL-3.0-or-later
!> Boundaries of a model: the edges that they take, the half-space behind those that absorb waves,
!> as dashpots at their Gauss points, and the motion that comes in from it.
module dda_boundary
   use dda_kinds, only: wp
   use dda_edge_piece, only: edge_piece_type
   use dda_support, only: fixed_point_type, point_type
   implicit none
   private
   public :: boundary_type, boundary_edge_type, boundary_motion_type

   !> A piece of an edge that a group &boundary takes.
   type :: boundary_edge_type
      integer :: group = 0                          !< number of the group &boundary, from 1
      type(edge_piece_type) :: piece
      character(len=8) :: direction = 'xy'          !< in which it acts: 'xy', 'x', 'y', 'normal'
   end type boundary_edge_type

   !> A motion that comes in through a boundary, and where that of the boundary itself is measured.
   type :: boundary_motion_type
      character(len=64) :: name = ''
      type(point_type), allocatable :: point(:)     !< whose mean counts
      real(wp), allocatable :: weight(:)            !< [points] shares, together 1
      integer :: motion(2) = 0                      !< that comes in, x and y; 0: none
      real(wp) :: factor = 0.5_wp                   !< of it, in the wave that comes in
      integer :: field = 0                          !< free field that it is the motion of; 0: none
   end type boundary_motion_type

   !> Edges with a half-space behind them and one incoming motion.
   type :: boundary_type
      character(len=64) :: name = ''
      character(len=16) :: kind = ''                !< 'viscous' or 'compliant'
      type(edge_piece_type), allocatable :: piece(:)
      real(wp), allocatable :: normal(:,:)          !< [2,pieces] outward, at the start
      !> [2,pieces] ρV_p and ρV_s times half of the length: dashpots of a Gauss point along the
      !> normal and along the edge, N s/m per metre of thickness
      real(wp), allocatable :: dashpot(:,:)
      type(fixed_point_type), allocatable :: point(:)  !< [2 × pieces] as static stages hold them
      integer :: motion(2) = 0                      !< that come in, x and y; 0: none
      real(wp) :: factor = 1.0_wp                   !< of the motion in that of an outcrop
   end type boundary_type

end module dda_boundary
