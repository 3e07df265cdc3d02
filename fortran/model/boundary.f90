! SPDX-License-Identifier: GPL-3.0-or-later
!> Boundaries of a model: their edges, the half-spaces behind absorbing edges (dashpots at Gauss
!> points), and incoming motions.
module dda_boundary
   use dda_kinds, only: wp
   use dda_edge_part, only: edge_part_type
   use dda_support, only: fixed_point_type, point_type
   implicit none
   private
   public :: boundary_type, boundary_edge_type, boundary_motion_type

   !> A part of an edge of a group &boundary.
   type :: boundary_edge_type
      integer :: group = 0                          !< number of the group &boundary, from 1
      type(edge_part_type) :: part
      character(len=8) :: direction = 'xy'  !< direction of the boundary: 'xy', 'x', 'y', 'normal'
   end type boundary_edge_type

   !> An incoming motion of a boundary, and the points at which the motion of the model is measured.
   type :: boundary_motion_type
      character(len=64) :: name = ''
      type(point_type), allocatable :: point(:)     !< points whose mean motion is measured
      real(wp), allocatable :: weight(:)            !< [points] weights with sum 1
      integer :: motion(2) = 0                      !< incoming motions in x and y; 0: none
      real(wp) :: factor = 0.5_wp  !< ratio of the incoming wave to the given motion
      integer :: field = 0  !< free field to which the motion belongs; 0: none
   end type boundary_motion_type

   !> Edges with a half-space behind them and one incoming motion.
   type :: boundary_type
      character(len=64) :: name = ''
      character(len=16) :: kind = ''                !< 'viscous' or 'compliant'
      type(edge_part_type), allocatable :: part(:)
      real(wp), allocatable :: normal(:,:)          !< [2,parts] initial outward normals
      !> [2,parts] dashpots of a Gauss point along the normal and along the edge, ρV_p and ρV_s
      !> times half of the length, N s/m per metre of thickness
      real(wp), allocatable :: dashpot(:,:)
      type(fixed_point_type), allocatable :: point(:)  !< [2 × parts] supports in static stages
      integer :: motion(2) = 0                      !< incoming motions in x and y; 0: none
      real(wp) :: factor = 1.0_wp  !< ratio of the motion to an outcrop motion
   end type boundary_type

end module dda_boundary
