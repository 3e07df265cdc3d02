! SPDX-License-Identifier: GPL-3.0-or-later
!> Ties: springs of an unbreakable joint between two faces, at the ends of their overlap.  The
!> second face may be shifted, as in a periodic model.  Faces of the same body are welded instead,
!> which continues the body.
module dda_tie
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type
   use dda_edge_part, only: edge_part_type
   use dda_weld, only: weld_type, new_weld
   implicit none
   private
   public :: tie_type, tie_faces

   real(wp), parameter :: coincidence = 1.0e-6_wp !< distance/edge length of coinciding corners

   !> One end of an overlap, with a corner of at least one of the two faces.
   type :: tie_type
      integer :: edge(2) = 0            !< the faces, given by their first vertices
      integer :: corner(2) = 0          !< vertex of each face at this end; 0: none
      real(wp) :: shift(2) = 0.0_wp     !< added to positions of the block of the second face, m
   end type tie_type

contains

   !> Tie or weld faces of two lists that coincide if the second list is shifted.
   pure subroutine tie_faces(blocks, first, second, shift, ties, welds)
      type(blocks_type), intent(in) :: blocks             !< blocks at the start
      type(edge_part_type), intent(in) :: first(:)       !< faces
      type(edge_part_type), intent(in) :: second(:)      !< faces with opposite normals
      real(wp), intent(in) :: shift(2)                    !< shift of the second faces, m
      type(tie_type), allocatable, intent(out) :: ties(:)  !< two ties per pair of touching faces
      type(weld_type), allocatable, intent(out) :: welds(:)  !< one weld per pair of cells
      integer :: i, k

      allocate (ties(0), welds(0))
      do i = 1, size(first)
         do k = 1, size(second)
            call tie_pair(blocks, first(i)%edge, second(k)%edge, shift, ties, welds)
         end do
      end do
   end subroutine tie_faces

   !> .true. if two edges belong to one body.
   pure logical function are_welded(blocks, e, f)
      type(blocks_type), intent(in) :: blocks  !< blocks at the start
      integer, intent(in) :: e, f              !< edges, given by their first vertices

      associate (body => blocks%body(blocks%owner([e, f])))
         are_welded = body(1) > 0 .and. body(1) == body(2)
      end associate
   end function are_welded

   !> Append two ties (one at each end of the overlap) or one weld of two faces.
   pure subroutine tie_pair(blocks, e, f, shift, ties, welds)
      type(blocks_type), intent(in) :: blocks             !< blocks at the start
      integer, intent(in) :: e, f                         !< faces, given by their first vertices
      real(wp), intent(in) :: shift(2)                    !< shift of the second face, m
      type(tie_type), allocatable, intent(inout) :: ties(:)
      type(weld_type), allocatable, intent(inout) :: welds(:)
      real(wp) :: low, high, length, tolerance

      associate (along => blocks%along(:, e), next => blocks%next)
         length = blocks%length(e)
         tolerance = coincidence*min(length, blocks%length(f))
         ! The second face runs in the opposite direction.
         low = dot_product(along, blocks%vertex(:, next(f)) + shift - blocks%vertex(:, e))
         high = dot_product(along, blocks%vertex(:, f) + shift - blocks%vertex(:, e))
         if (min(high, length) - max(low, 0.0_wp) <= tolerance) return
         if (are_welded(blocks, e, f)) then
            welds = [welds, new_weld(blocks, e, f, max(low, 0.0_wp), min(high, length), shift)]
            return
         end if
         ties = [ties, &
            tie_type([e, f], [merge(e, 0, low <= tolerance), &
            merge(next(f), 0, low >= -tolerance)], shift), &
            tie_type([e, f], [merge(next(e), 0, high >= length - tolerance), &
            merge(f, 0, high <= length + tolerance)], shift)]
      end associate
   end subroutine tie_pair

end module dda_tie
