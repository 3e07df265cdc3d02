! SPDX-License-Identifier: GPL-3.0-or-later
!> Estimate, without simulation, of the weight of the blocks above each block.  The module also
!> finds the blocks that springs to the ground support, directly (grounded blocks) or through other
!> blocks.
!>
!> The model is cut into columns along gravity.  A block receives the weight above it in its
!> columns, adds its own weight, and distributes the sum evenly over these columns; a block that the
!> ground supports transfers no weight to blocks below.  All springs that act in any static stage
!> support blocks.
module dda_overburden
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type
   use dda_sorting, only: merged_order
   use dda_growth, only: grow
   use dda_elements, only: elements_type, set_elements, freeze_elements, list_linear_terms
   use dda_linear_terms, only: linear_terms_type, at_theta, at_end, blocks_in, block_of
   use dda_model, only: model_type, contact_distance
   use dda_neighbours, only: neighbours_type, find_near_pairs
   use dda_partition, only: join, name_parts
   use dda_scheme, only: step_type, scheme_type
   implicit none
   private
   public :: overburden_type, find_overburden, find_grounded, find_supported

   integer, parameter :: most_columns = 4096  !< largest number of columns along gravity

   !> Weights along gravity.
   type :: overburden_type
      real(wp), allocatable :: width(:)     !< [blocks] width across gravity, m
      real(wp), allocatable :: weight(:)  !< [blocks] weight of the block and the blocks above, N/m
      integer, allocatable :: n_below(:)    !< [blocks] number of blocks directly below
      integer, allocatable :: pair(:,:)     !< [2,≥ pairs] block; block directly below it
      integer :: pairs = 0
   end type overburden_type

   real(wp), parameter :: min_support = 1.0e-6_wp  !< smallest component of a spring along gravity

contains

   !> Find the weights on all blocks, and all pairs of a block and a block directly below it.
   pure subroutine find_overburden(blocks, gravity, on_ground, overburden)
      type(blocks_type), intent(in) :: blocks  !< blocks in their initial state
      real(wp), intent(in) :: gravity(2)       !< gravity, not zero, m/s²
      logical, intent(in) :: on_ground(:)      !< [blocks] supported by the ground
      type(overburden_type), intent(out) :: overburden  !< weights on all blocks
      integer, allocatable :: span(:,:), lowest_block(:)
      real(wp), allocatable :: carried_weight(:)
      integer :: order(blocks%n), k, b, columns

      call set_columns(blocks, gravity/norm2(gravity), overburden, span, columns)
      allocate (carried_weight(columns), source=0.0_wp)
      allocate (lowest_block(columns), source=0)
      allocate (overburden%pair(2, 64), overburden%weight(blocks%n))
      allocate (overburden%n_below(blocks%n), source=0)
      order = merged_order(matmul(gravity, blocks%position(1:2, :)))
      do k = 1, blocks%n
         b = order(k)
         associate (first => span(1, b), last => span(2, b))
            overburden%weight(b) = sum(carried_weight(first:last)) + norm2(gravity)*blocks%mass(b)
            carried_weight(first:last) = overburden%weight(b)/(last - first + 1)
            if (on_ground(b)) carried_weight(first:last) = 0.0_wp
            call add_pairs(overburden, lowest_block(first:last), b)
            lowest_block(first:last) = b
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
      real(wp) :: extents(2, blocks%n), horizontal(2), left_end, width
      integer :: b

      horizontal = [-down(2), down(1)]
      do b = 1, blocks%n
         associate (distance => matmul(horizontal, blocks%vertex(:, blocks%first(b): &
            blocks%first(b + 1) - 1)))
            extents(:, b) = [minval(distance), maxval(distance)]
         end associate
      end do
      overburden%width = extents(2, :) - extents(1, :)
      left_end = minval(extents(1, :))
      width = maxval(extents(2, :)) - left_end
      columns = ceiling(min(real(most_columns, wp), 4*width/minval(overburden%width)))
      allocate (span(2, blocks%n))
      span(1, :) = min(columns - 1, nint((extents(1, :) - left_end)/width*columns)) + 1
      span(2, :) = max(span(1, :), nint((extents(2, :) - left_end)/width*columns))
   end subroutine set_columns

   !> Add pairs of block b and the blocks directly above it in its columns.
   pure subroutine add_pairs(overburden, block_above, b)
      type(overburden_type), intent(inout) :: overburden  !< pairs are added
      integer, intent(in) :: block_above(:)  !< [columns] lowest block so far, 0: none
      integer, intent(in) :: b         !< block below the lowest blocks so far
      integer :: i

      do i = 1, size(block_above)
         if (block_above(i) == 0) cycle
         if (i > 1) then
            if (block_above(i) == block_above(i - 1)) cycle
         end if
         overburden%pairs = overburden%pairs + 1
         call grow(overburden%pair, 2, overburden%pairs)
         overburden%pair(:, overburden%pairs) = [block_above(i), b]
         overburden%n_below(block_above(i)) = overburden%n_below(block_above(i)) + 1
      end do
   end subroutine add_pairs

   !> Find the blocks supported along gravity by springs to the ground, and the springs of elements.
   subroutine find_grounded(model, on_ground, terms)
      type(model_type), intent(in) :: model  !< model as read from the input
      !> [blocks] supported by springs to the ground
      logical, allocatable, intent(out) :: on_ground(:)
      type(linear_terms_type), intent(out) :: terms !< springs of elements in static stages
      type(model_type) :: staged
      type(elements_type) :: elements
      real(wp) :: down(2)
      integer :: i

      staged = model
      do i = 1, size(staged%fixed_points)
         associate (point => staged%fixed_points(i))
            point%fixed_along = point%fixed_along .or. point%waiting
         end associate
      end do
      call set_elements(elements, staged, model%blocks, 0.0_wp)
      call freeze_elements(elements, model%blocks, 0.0_wp)
      call list_linear_terms(elements, model%blocks, step_type(scheme_type(1.0_wp, 1.0_wp), &
         0.0_wp, 1.0_wp), terms)
      down = model%control%gravity/norm2(model%control%gravity)
      allocate (on_ground(model%blocks%n), source=.false.)
      do i = 1, terms%n
         associate (term => terms%term(i))
            if (term%block_b > 0 .or. all(term%instant /= [at_theta, at_end])) cycle
            if (abs(dot_product(term%row_a(1:2), down)) > min_support) on_ground(term%block_a) &
               = .true.
         end associate
      end do
   end subroutine find_grounded

   !> Find blocks supported directly or by other blocks.  A block is supported if it touches, is
   !> joined to by springs, or would fall on a supported block.
   subroutine find_supported(model, on_ground, terms, overburden, supported)
      type(model_type), intent(in) :: model  !< model as read from the input
      logical, intent(in) :: on_ground(:)    !< [blocks] supported by springs to the ground
      type(linear_terms_type), intent(in) :: terms        !< springs of elements
      type(overburden_type), intent(in) :: overburden     !< overburden with pairs of blocks
      !> [blocks] all .true. if there are too many pairs
      logical, allocatable, intent(out) :: supported(:)
      type(neighbours_type) :: neighbours
      integer :: part(model%blocks%n), i, k
      logical :: changed

      part = [(i, i=1, model%blocks%n)]
      supported = on_ground
      call find_near_pairs(neighbours, model%blocks, contact_distance(model))
      if (neighbours%overflowed) supported = .true.
      if (neighbours%overflowed) return
      do i = 1, neighbours%n_pairs
         call join(part, neighbours%pair(1, i), neighbours%pair(2, i))
      end do
      do i = 1, terms%n
         do k = 2, blocks_in(terms%term(i))
            call join(part, terms%term(i)%block_a, block_of(terms%term(i), k))
         end do
      end do
      call name_parts(part)
      do i = 1, size(part)
         if (on_ground(i)) supported(part(i)) = .true.
      end do
      changed = .true.
      do while (changed)
         changed = .false.
         do i = overburden%pairs, 1, -1
            associate (above => part(overburden%pair(1, i)), below => part(overburden%pair(2, i)))
               if (supported(above) .or. .not. supported(below)) cycle
               supported(above) = .true.
               changed = .true.
            end associate
         end do
      end do
      supported = supported(part)
   end subroutine find_supported

end module dda_overburden
