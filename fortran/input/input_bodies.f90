! SPDX-License-Identifier: GPL-3.0-or-later
!> Read all blocks of an input, move them to the engine's origin, and check them together.
module dda_input_bodies
   use dda_kinds, only: wp, long
   use dda_blocks, only: set_blocks
   use dda_errors, only: error_type, error_input, fail
   use dda_free_memory, only: require_memory, require_for_blas
   use dda_input_blocks, only: read_blocks, is_block_group
   use dda_input_group, only: group_type, fail_input
   use dda_input_welds, only: block_title, weld_cells
   use dda_model, only: model_type
   use dda_neighbours, only: neighbours_type, find_near_pairs
   use dda_outlines, only: outlines_type
   use dda_polygon, only: area_of, overlap_depth
   use dda_text, only: to_text
   implicit none
   private
   public :: read_bodies

   real(wp), parameter :: touching = 1.0e-6_wp     !< tolerated overlap/size of the smaller block
   !> largest distance from the origin, m; farther, rounding exceeds gaps
   real(wp), parameter :: farthest = 1.0e9_wp
   real(wp), parameter :: min_extent = 1.0e-9_wp !< smallest size of a block, m
   !> smallest block size/model size: smaller blocks are within rounding errors
   real(wp), parameter :: min_ratio = 1.0e-9_wp
   !> smallest side of a block/model size: shorter sides have no direction
   real(wp), parameter :: min_side = 1.0e-12_wp
   real(wp), parameter :: min_area = 1.0e-12_wp  !< smallest block area/squared block size
   integer(long), parameter :: block_bytes = 7500  !< bytes per block of a wall, measured
   real(wp), parameter :: buffer_bytes = 1.1e7_wp  !< bytes of output and checkpoints, measured

contains

   !> Read all blocks and move the middle of the model to the engine's origin.
   subroutine read_bodies(model, file, folder, groups, error)
      type(model_type), intent(inout) :: model  !< filled group by group
      character(len=*), intent(in) :: file, folder  !< path; its folder, '' or ending in '/'
      type(group_type), intent(in) :: groups(:)  !< groups of the input, in its order
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(outlines_type) :: outlines
      integer :: i

      do i = 1, size(groups)
         if (is_block_group(groups(i)%name)) call read_blocks(groups(i), &
            i, folder, model, outlines, error)
         if (allocated(error)) return
      end do
      if (outlines%n == 0) call fail(error, error_input, file// &
         ': there are no blocks; give &block, &blocks, &layers, &drums or &wall')
      call require_memory(real(outlines%n, wp)*block_bytes + buffer_bytes, file// &
         ': the model of '//to_text(outlines%n)//' blocks', &
         'use fewer blocks, or a machine with more', error)
      call require_for_blas(error)
      if (allocated(error)) return
      call check_sizes(groups, outlines, error)
      if (allocated(error)) call name_block_files(error, model)
      if (allocated(error)) return
      associate (vertices => outlines%vertices(:, :outlines%n_vertices))
         model%origin = 0.5_wp*(minval(vertices, 2) + maxval(vertices, 2))
         vertices = vertices - spread(model%origin, 2, outlines%n_vertices)
      end associate
      model%block_names = outlines%name(:outlines%n)
      call set_blocks(model%blocks, outlines%first(:outlines%n + 1), outlines%vertices, &
         outlines%material(:outlines%n), outlines%joint(:outlines%n_vertices), model%materials, &
         model%control%plane_strain)
      call add_weight_stress(model, outlines)
      call check_overlap(model, groups, outlines%source, error)
      call weld_cells(model, groups, outlines, error)
      if (allocated(error)) call name_block_files(error, model)
   end subroutine read_bodies

   !> Add the names of the block files to an error, because its blocks may be from these files.
   subroutine name_block_files(error, model)
      type(error_type), intent(inout) :: error  !< error of the blocks as a whole
      type(model_type), intent(in) :: model  !< model with its block files
      integer :: i

      do i = 1, size(model%block_files)
         error%message = error%message//'; block file '//model%block_files(i)%file
      end do
   end subroutine name_block_files

   !> Add vertical stress due to weight to buried blocks, in addition to that of their material.
   pure subroutine add_weight_stress(model, outlines)
      type(model_type), intent(inout) :: model  !< model with its blocks
      type(outlines_type), intent(in) :: outlines  !< outlines of all blocks
      integer :: b

      associate (blocks => model%blocks, weight => norm2(model%control%gravity))
         do b = 1, blocks%n
            blocks%initial_stress(2, b) = blocks%initial_stress(2, b) - outlines%overburden(b) &
               - weight*model%materials(blocks%material(b))%density*outlines%cover(b)
         end do
      end associate
   end subroutine add_weight_stress

   !> Check that no block is too far from the origin or too small for the rounding of positions.
   subroutine check_sizes(groups, outlines, error)
      type(group_type), intent(in) :: groups(:)  !< groups of the input, in its order
      type(outlines_type), intent(in) :: outlines  !< outlines of all blocks
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      character(len=:), allocatable :: failure
      real(wp) :: extent
      integer :: b

      extent = extent_of(outlines%vertices(:, :outlines%n_vertices))
      b = first_distant_block(outlines)
      failure = ''
      if (b > 0) failure = ' reaches farther than '//to_text(farthest)//' m from the origin'
      do while (failure == '' .and. b < outlines%n)
         b = b + 1
         failure = too_small_reason(outlines%vertices(:, outlines%first(b):outlines%first(b + 1) &
            - 1), extent)
      end do
      if (failure /= '') call fail_input(error, groups(outlines%source(b)), &
         block_title(b, outlines%name(b))//failure)
   end subroutine check_sizes

   !> Larger side of the bounding box of positions, m.
   pure real(wp) function extent_of(positions) result(extent)
      real(wp), intent(in) :: positions(:,:)  !< [2, positions] m

      extent = maxval(maxval(positions, 2) - minval(positions, 2))
   end function extent_of

   !> First block with a vertex that is too far away; 0 if there is none.
   pure integer function first_distant_block(outlines) result(b)
      type(outlines_type), intent(in) :: outlines  !< outlines of all blocks

      do b = 1, outlines%n
         if (.not. all(abs(outlines%vertices(:, outlines%first(b):outlines%first(b + 1) - 1)) &
            <= farthest)) return
      end do
      b = 0
   end function first_distant_block

   !> Reason why a block is too small for a model of a given size, or blank.
   pure function too_small_reason(vertices, extent) result(failure)
      real(wp), intent(in) :: vertices(:,:), extent  !< [2, vertices] m; size of the model, m
      character(len=:), allocatable :: failure
      real(wp) :: size_of

      size_of = extent_of(vertices)
      failure = ''
      if (size_of < min_extent) then
         failure = ' measures '//to_text(size_of)//' m, less than '//to_text(min_extent)//' m'
      else if (size_of < min_ratio*extent) then
         failure = ' measures '//to_text(size_of)//' m, too little compared with the '// &
            to_text(extent)//' m of the model'
      else if (.not. area_of(vertices) > min_area*size_of**2) then
         failure = ' has no area'
      else if (.not. shortest_side(vertices) > min_side*extent) then
         failure = ' has a side of '//to_text(shortest_side(vertices))// &
            ' m, too little compared with the '//to_text(extent)//' m of the model'
      end if
   end function too_small_reason

   !> Length of the shortest side of a polygon, m.
   pure real(wp) function shortest_side(vertices) result(length)
      real(wp), intent(in) :: vertices(:,:)  !< [2, vertices] m

      length = minval(norm2(cshift(vertices, 1, 2) - vertices, 1))
   end function shortest_side

   !> Check that no two blocks overlap.
   subroutine check_overlap(model, groups, source, error)
      type(model_type), intent(in) :: model  !< model as read from the input
      type(group_type), intent(in) :: groups(:)  !< groups of the input, in its order
      integer, intent(in) :: source(:)  !< [blocks] number of the group of each block
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(neighbours_type) :: neighbours
      real(wp) :: depth
      integer :: p

      associate (blocks => model%blocks)
         call find_near_pairs(neighbours, blocks, 0.0_wp)
         do p = 1, neighbours%n_pairs
            associate (a => neighbours%pair(1, p), b => neighbours%pair(2, p))
               depth = overlap_depth(blocks%vertex(:, blocks%first(a):blocks%first(a + 1) - 1), &
                  blocks%vertex(:, blocks%first(b):blocks%first(b + 1) - 1))
               if (depth <= touching*min(blocks%radius(a), blocks%radius(b))) cycle
               call fail_input(error, groups(source(b)), block_title(b, &
                  model%block_names(b))//' overlaps '//block_title(a, &
                  model%block_names(a))//' of &'//groups(source(a))%name//' (line '// &
                  to_text(groups(source(a))%line)//') by '//to_text(depth)//' m')
               return
            end associate
         end do
      end associate
   end subroutine check_overlap

end module dda_input_bodies
