! SPDX-License-Identifier: GPL-3.0-or-later
!> Estimate, without simulation, of the weight of the blocks above each block.
!>
!> The model is cut into columns along gravity.  A block receives the weight above it in its
!> columns, adds its own weight, and distributes the sum evenly over these columns; a block that the
!> ground supports transfers no weight to blocks below.
module dda_overburden
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type
   use dda_sorting, only: merged_order
   implicit none
   private
   public :: overburden_type, find_overburden

   integer, parameter :: most_columns = 4096  !< largest number of columns along gravity

   !> Weights along gravity.
   type :: overburden_type
      real(wp), allocatable :: width(:)     !< [blocks] width across gravity, m
      real(wp), allocatable :: weight(:)    !< [blocks] weight on the base, with the block, N/m
      integer, allocatable :: beneath(:)    !< [blocks] number of blocks directly below
      integer, allocatable :: pair(:,:)     !< [2,≥ pairs] block; block directly below it
      integer :: pairs = 0
   end type overburden_type

contains

   !> Find the weights on all blocks, and all pairs of a block and a block directly below it.
   pure subroutine find_overburden(blocks, gravity, held, overburden)
      type(blocks_type), intent(in) :: blocks  !< blocks in their initial state
      real(wp), intent(in) :: gravity(2)       !< gravity, not zero, m/s²
      logical, intent(in) :: held(:)           !< [blocks] supported by the ground
      type(overburden_type), intent(out) :: overburden  !< weights on all blocks
      integer, allocatable :: span(:,:), lowest(:)
      real(wp), allocatable :: carried(:)
      integer :: order(blocks%n), k, b, columns

      call set_columns(blocks, gravity/norm2(gravity), overburden, span, columns)
      allocate (carried(columns), source=0.0_wp)
      allocate (lowest(columns), source=0)
      allocate (overburden%pair(2, 64), overburden%weight(blocks%n))
      allocate (overburden%beneath(blocks%n), source=0)
      order = merged_order(matmul(gravity, blocks%position(1:2, :)))
      do k = 1, blocks%n
         b = order(k)
         associate (first => span(1, b), last => span(2, b))
            overburden%weight(b) = sum(carried(first:last)) + norm2(gravity)*blocks%mass(b)
            carried(first:last) = overburden%weight(b)/(last - first + 1)
            if (held(b)) carried(first:last) = 0.0_wp
            call add_pairs(overburden, lowest(first:last), b)
            lowest(first:last) = b
         end associate
      end do
   end subroutine find_overburden

   !> Set the width of each block across gravity, and the columns that it covers.
   pure subroutine set_columns(blocks, down, overburden, span, columns)
      type(blocks_type), intent(in) :: blocks  !< blocks in their initial state
      real(wp), intent(in) :: down(2)          !< unit vector
      type(overburden_type), intent(inout) :: overburden   !< widths are set
      integer, allocatable, intent(out) :: span(:,:)       !< [2,blocks] first and last column
      integer, intent(out) :: columns          !< number of columns
      real(wp) :: side(2, blocks%n), across(2), left, width
      integer :: b

      across = [-down(2), down(1)]
      do b = 1, blocks%n
         associate (place => matmul(across, blocks%vertex(:, blocks%first(b): &
            blocks%first(b + 1) - 1)))
            side(:, b) = [minval(place), maxval(place)]
         end associate
      end do
      overburden%width = side(2, :) - side(1, :)
      left = minval(side(1, :))
      width = maxval(side(2, :)) - left
      columns = ceiling(min(real(most_columns, wp), 4*width/minval(overburden%width)))
      allocate (span(2, blocks%n))
      span(1, :) = min(columns - 1, nint((side(1, :) - left)/width*columns)) + 1
      span(2, :) = max(span(1, :), nint((side(2, :) - left)/width*columns))
   end subroutine set_columns

   !> Add pairs of block b and the blocks directly above it in its columns.
   pure subroutine add_pairs(overburden, above, b)
      type(overburden_type), intent(inout) :: overburden  !< pairs are added
      integer, intent(in) :: above(:)  !< [columns] lowest block so far, 0: none
      integer, intent(in) :: b         !< block below the lowest blocks so far
      integer, allocatable :: more(:,:)
      integer :: i

      do i = 1, size(above)
         if (above(i) == 0) cycle
         if (i > 1) then
            if (above(i) == above(i - 1)) cycle
         end if
         if (overburden%pairs == size(overburden%pair, 2)) then
            allocate (more(2, 2*overburden%pairs))
            more(:, :overburden%pairs) = overburden%pair
            call move_alloc(more, overburden%pair)
         end if
         overburden%pairs = overburden%pairs + 1
         overburden%pair(:, overburden%pairs) = [above(i), b]
         overburden%beneath(above(i)) = overburden%beneath(above(i)) + 1
      end do
   end subroutine add_pairs

end module dda_overburden
