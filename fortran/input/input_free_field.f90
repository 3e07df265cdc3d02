! SPDX-License-Identifier: GPL-3.0-or-later
!> Column of a free-field side: the blocks between the side and the first vertical line that cuts no
!> block.  The left and right faces of the column must match.
module dda_input_free_field
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type
   use dda_column_model, only: copy_blocks
   use dda_edge_part, only: edge_part_type
   use dda_errors, only: error_type
   use dda_free_field, only: free_field_type
   use dda_input_group, only: group_type, fail_input, positions
   use dda_input_groups, only: boundary_values, read_values
   use dda_model, only: model_type
   use dda_outline, only: find_outline, parts_on_side
   use dda_text, only: to_text, quoted
   use dda_tie, only: tie_faces, tie_type
   use dda_weld, only: weld_type
   implicit none
   private
   public :: find_column, check_columns, check_ties

   real(wp), parameter :: touching = 1.0e-6_wp  !< gap/half the model size of touching blocks

contains

   !> Find blocks and ties of the column at a side.
   subroutine find_column(model, group, field, error)
      type(model_type), intent(in) :: model  !< model with its blocks
      type(group_type), intent(in) :: group  !< group of the input
      type(free_field_type), intent(inout) :: field  !< free field with its side
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(blocks_type) :: column
      type(edge_part_type), allocatable :: left_faces(:), right_faces(:)
      type(weld_type), allocatable :: inner_welds(:)
      real(wp) :: width

      call find_side_blocks(model%blocks, merge(-1.0_wp, 1.0_wp, field%side == 'left'), field%block)
      if (size(field%block) == model%blocks%n) call fail_input(error, group, 'the free field '// &
         'needs a separate column of blocks at the '//trim(field%side)//' side, but no '// &
         'vertical line passes between the blocks')
      if (allocated(error)) return
      call copy_blocks(model, field%block, column, inner_welds)
      call find_outline(column, spread(.true., 1, column%n), left_faces)
      right_faces = parts_on_side(column, left_faces, 'right')
      left_faces = parts_on_side(column, left_faces, 'left')
      field%face = merge(2, 1, field%side == 'left')
      width = maxval(column%vertex(1, :)) - minval(column%vertex(1, :))
      if (.not. cover_same_heights(column, left_faces, right_faces)) call fail_input(error, group, &
         'the column of blocks at the '//trim(field%side)//' side, '//to_text(width)// &
         ' m wide, does not match its own image; its left and right faces must be vertical, '// &
         'without gaps and at the same heights')
      if (allocated(error)) return
      call tie_faces(column, right_faces, left_faces, [width, 0.0_wp], field%tie, field%weld)
      call check_ties(model, group, column, field%tie, error)
   end subroutine find_column

   !> Check that the joints of ties have only the springs of &contact.
   subroutine check_ties(model, group, blocks, ties, error)
      type(model_type), intent(in) :: model  !< model with its joints
      type(group_type), intent(in) :: group  !< group of the input
      type(blocks_type), intent(in) :: blocks  !< tied blocks
      type(tie_type), intent(in) :: ties(:)    !< ties
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer :: i, k

      do i = 1, size(ties)
         do k = 1, 2
            associate (joint => model%joints(blocks%joint(ties(i)%edge(k))))
               if (.not. joint%is_plain()) call fail_input(error, group, 'sides are tied by '// &
                  'the springs of &contact, but their joint '//quoted(trim(joint%name))// &
                  ' has a law, a stiffness per area or contact_points; give the edges at the '// &
                  'sides another joint')
            end associate
         end do
      end do
   end subroutine check_ties

   !> Find blocks between a side and the first vertical line that passes between blocks.
   pure subroutine find_side_blocks(blocks, outward, list)
      type(blocks_type), intent(in) :: blocks  !< blocks of the model
      real(wp), intent(in) :: outward          !< −1: left side; 1: right side
      integer, allocatable, intent(out) :: list(:)
      real(wp) :: near_end(blocks%n), far_end(blocks%n), line, previous_line, tolerance
      integer :: b

      do b = 1, blocks%n
         associate (x => -outward*blocks%vertex(1, blocks%first(b):blocks%first(b + 1) - 1))
            near_end(b) = minval(x)
            far_end(b) = maxval(x)
         end associate
      end do
      tolerance = touching*blocks%half_size
      line = minval(near_end) + 2*tolerance
      do
         previous_line = line
         line = maxval(far_end, mask=near_end < previous_line - tolerance)
         if (line <= previous_line + tolerance) exit
      end do
      list = pack([(b, b=1, blocks%n)], near_end < line - tolerance)
   end subroutine find_side_blocks

   !> .true. if two lists of vertical faces cover the same heights, without gaps.
   pure logical function cover_same_heights(blocks, left_faces, right_faces)
      type(blocks_type), intent(in) :: blocks         !< blocks of the column
      type(edge_part_type), intent(in) :: left_faces(:), right_faces(:)  !< faces
      real(wp) :: span(3, 2)

      cover_same_heights = size(left_faces) > 0 .and. size(right_faces) > 0
      if (.not. cover_same_heights) return
      span(:, 1) = height_range(left_faces)
      span(:, 2) = height_range(right_faces)
      cover_same_heights = all(abs(span(:, 1) - span(:, 2)) <= touching*blocks%half_size) .and. &
         abs(span(2, 1) - span(1, 1) - span(3, 1)) <= touching*blocks%half_size

   contains

      !> Lowest and highest position, and sum of lengths, m.
      pure function height_range(parts) result(span)
         type(edge_part_type), intent(in) :: parts(:)  !< whole edges
         real(wp) :: span(3)

         span = [minval(blocks%vertex(2, [parts%edge, blocks%next(parts%edge)])), &
            maxval(blocks%vertex(2, [parts%edge, blocks%next(parts%edge)])), &
            sum(blocks%length(parts%edge))]
      end function height_range
   end function cover_same_heights

   !> Reject removals of blocks of columns, and edge loads on them.
   subroutine check_columns(model, groups, error)
      type(model_type), intent(in) :: model  !< complete model
      type(group_type), intent(in) :: groups(:)  !< groups of the input, in its order
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(boundary_values) :: boundary
      integer, allocatable :: group_numbers(:)
      integer :: i, k, g

      if (allocated(error)) return
      if (size(model%free_fields) == 0) return
      group_numbers = positions(groups, 'boundary')
      do i = 1, size(group_numbers)
         g = group_numbers(i)
         call read_values(groups(g), boundary, error)
         if (boundary%kind == 'free_field') exit
      end do
      do i = 1, size(model%free_fields)
         associate (block => model%free_fields(i)%block, side => model%free_fields(i)%side)
            do k = 1, size(model%stages)
               if (any(model%stages(k)%removed(block))) call fail_input(error, &
                  groups(g), 'stage '//quoted(trim(model%stages(k)%name))// &
                  ' removes blocks of the column that is the free field at the '//trim(side)// &
                  ' side; excavate farther from this side')
            end do
            do k = 1, size(model%edge_loads)
               if (share_number(block, model%edge_loads(k)%part%block)) call fail_input(error, &
                  groups(g), 'a load on edges acts on the free-field column at the '// &
                  trim(side)//' side, which cannot have loads; leave out the blocks of the column')
            end do
         end associate
      end do
   end subroutine check_columns

   !> .true. if two lists have a number in common.
   pure logical function share_number(first, second)
      integer, intent(in) :: first(:), second(:)
      integer :: i

      share_number = any([(any(first == second(i)), i=1, size(second))])
   end function share_number

end module dda_input_free_field
