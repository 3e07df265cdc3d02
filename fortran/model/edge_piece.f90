! SPDX-License-Identifier: GPL-3.0-or-later
!> A part of an edge of a block on which a boundary, a traction or water acts.
!>
!> Displacements are linear along an edge, so two Gauss points integrate products of them exactly.
module dda_edge_piece
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type
   implicit none
   private
   public :: edge_piece_type, reference_at, piece_length, piece_normal, gauss_points

   !> A part of an edge; it moves and strains with its block.
   type :: edge_piece_type
      integer :: block = 0              !< block that owns the edge
      integer :: edge = 0               !< edge, given by its first vertex, counter-clockwise
      real(wp) :: from = 0.0_wp         !< start as a fraction of the edge length, 0 … 1
      real(wp) :: to = 1.0_wp           !< end as a fraction of the edge length
   end type edge_piece_type

contains

   !> Reference offset ρ, m, at a fraction of the part: 0 at its first end, 1 at its last end.
   pure function reference_at(blocks, piece, fraction) result(reference)
      type(blocks_type), intent(in) :: blocks      !< blocks
      type(edge_piece_type), intent(in) :: piece   !< part of an edge
      real(wp), intent(in) :: fraction             !< fraction, 0 … 1
      real(wp) :: reference(2)
      real(wp) :: at

      at = piece%from + fraction*(piece%to - piece%from)
      associate (last => blocks%next(piece%edge))
         reference = (1.0_wp - at)*blocks%reference(:, piece%edge) + at*blocks%reference(:, last)
      end associate
   end function reference_at

   !> Present length of the part, m.
   pure real(wp) function piece_length(blocks, piece)
      type(blocks_type), intent(in) :: blocks      !< blocks in their present state
      type(edge_piece_type), intent(in) :: piece   !< part of an edge

      piece_length = (piece%to - piece%from)*blocks%length(piece%edge)
   end function piece_length

   !> Present outward normal of the part; rotation by +90° gives the direction from first to last
   !> end.
   pure function piece_normal(blocks, piece) result(normal)
      type(blocks_type), intent(in) :: blocks      !< blocks in their present state
      type(edge_piece_type), intent(in) :: piece   !< part of an edge
      real(wp) :: normal(2)

      normal = [blocks%along(2, piece%edge), -blocks%along(1, piece%edge)]
   end function piece_normal

   !> Reference offsets ρ, m, of the two Gauss points, each with half the length as weight.
   pure function gauss_points(blocks, piece) result(reference)
      type(blocks_type), intent(in) :: blocks      !< blocks
      type(edge_piece_type), intent(in) :: piece   !< part of an edge
      real(wp) :: reference(2, 2)                  !< [2, points]
      real(wp), parameter :: near = 0.5_wp - 0.5_wp/sqrt(3.0_wp)

      reference(:, 1) = reference_at(blocks, piece, near)
      reference(:, 2) = reference_at(blocks, piece, 1.0_wp - near)
   end function gauss_points

end module dda_edge_piece
