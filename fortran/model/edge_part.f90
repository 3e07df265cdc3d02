! SPDX-License-Identifier: GPL-3.0-or-later
!> A part of an edge of a block on which a boundary, a traction or water acts.
!>
!> Displacements are linear along an edge, so two Gauss points integrate products of them exactly.
module dda_edge_part
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type
   implicit none
   private
   public :: edge_part_type, reference_at, part_length, part_normal, gauss_points

   !> A part of an edge; it moves and strains with its block.
   type :: edge_part_type
      integer :: block = 0              !< block that owns the edge
      integer :: edge = 0               !< edge, given by its first vertex, counter-clockwise
      real(wp) :: from = 0.0_wp         !< start as a fraction of the edge length, 0 … 1
      real(wp) :: to = 1.0_wp           !< end as a fraction of the edge length
   end type edge_part_type

contains

   !> Reference offset ρ, m, at a fraction of the part: 0 at its first end, 1 at its last end.
   pure function reference_at(blocks, part, fraction) result(reference)
      type(blocks_type), intent(in) :: blocks      !< blocks
      type(edge_part_type), intent(in) :: part   !< part of an edge
      real(wp), intent(in) :: fraction             !< fraction, 0 … 1
      real(wp) :: reference(2)
      real(wp) :: at

      at = part%from + fraction*(part%to - part%from)
      associate (last => blocks%next(part%edge))
         reference = (1.0_wp - at)*blocks%reference(:, part%edge) + at*blocks%reference(:, last)
      end associate
   end function reference_at

   !> Present length of the part, m.
   pure real(wp) function part_length(blocks, part)
      type(blocks_type), intent(in) :: blocks      !< blocks in their present state
      type(edge_part_type), intent(in) :: part   !< part of an edge

      part_length = (part%to - part%from)*blocks%length(part%edge)
   end function part_length

   !> Present outward normal of the part; rotation by +90° gives the direction from first to last
   !> end.
   pure function part_normal(blocks, part) result(normal)
      type(blocks_type), intent(in) :: blocks      !< blocks in their present state
      type(edge_part_type), intent(in) :: part   !< part of an edge
      real(wp) :: normal(2)

      normal = [blocks%along(2, part%edge), -blocks%along(1, part%edge)]
   end function part_normal

   !> Reference offsets ρ, m, of the two Gauss points, each with half the length as weight.
   pure function gauss_points(blocks, part) result(reference)
      type(blocks_type), intent(in) :: blocks      !< blocks
      type(edge_part_type), intent(in) :: part   !< part of an edge
      real(wp) :: reference(2, 2)                  !< [2, points]
      real(wp), parameter :: first_gauss = 0.5_wp - 0.5_wp/sqrt(3.0_wp)

      reference(:, 1) = reference_at(blocks, part, first_gauss)
      reference(:, 2) = reference_at(blocks, part, 1.0_wp - first_gauss)
   end function gauss_points

end module dda_edge_part
