! SPDX-License-Identifier: GPL-3.0-or-later
!> A boundary that absorbs waves: the half-space behind edges of the outline, as dashpots at their
!> Gauss points, with the motion that comes in from it.
module dda_boundary
   use dda_kinds, only: wp
   use dda_edge_piece, only: edge_piece_type
   use dda_support, only: fixed_point_type
   implicit none
   private
   public :: boundary_type

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
