! SPDX-License-Identifier: GPL-3.0-or-later
!> Group &blocks: the blocks of a netCDF file, and the materials and joints that the file names.
module dda_input_block_file
   use dda_block_file, only: block_file_type, read_block_file
   use dda_errors, only: error_type
   use dda_input_group, only: group_type, input_error, name_length
   use dda_input_groups, only: blocks_values, read_values
   use dda_input_materials, only: find_substances
   use dda_model, only: model_type, block_source_type
   use dda_outlines, only: outlines_type, add_outline, outline_failure
   use dda_text, only: closest, quoted, to_text
   implicit none
   private
   public :: read_block_group

contains

   !> Read &blocks.
   subroutine read_block_group(group, source, folder, model, outlines, error)
      type(group_type), intent(in) :: group      !< group of the input
      integer, intent(in) :: source              !< number of the group
      character(len=*), intent(in) :: folder     !< folder of the input, '' or ending in '/'
      type(model_type), intent(inout) :: model !< model with materials and joints; receives the file
      type(outlines_type), intent(inout) :: outlines         !< outlines; new blocks are added
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(block_file_type) :: found
      type(error_type), allocatable :: failure
      type(blocks_values) :: own
      character(len=:), allocatable :: path
      integer :: m, j

      call read_values(group, own, error)
      call find_substances(group, own%naming, model, m, j, error)
      if (allocated(error)) return
      path = own%file
      if (path(1:1) /= '/') path = folder//path
      call read_block_file(found, path, failure)
      if (allocated(failure)) then
         call input_error(error, group, failure%message)
         return
      end if
      call add_blocks(group, path, found, source, m, j, model, outlines, error)
      model%block_files = [model%block_files, block_source_type(path, found%checksum)]
   end subroutine read_block_group

   !> Add the blocks of a file, whose polygons must be valid.
   subroutine add_blocks(group, path, found, source, m, j, model, outlines, error)
      type(group_type), intent(in) :: group          !< group of the input
      character(len=*), intent(in) :: path           !< path of the file, for messages
      type(block_file_type), intent(in) :: found     !< content of the file
      integer, intent(in) :: source                  !< number of the group
      integer, intent(in) :: m, j                    !< material and joint of blocks without names
      type(model_type), intent(in) :: model          !< model with its materials and joints
      type(outlines_type), intent(inout) :: outlines !< outlines; new blocks are added
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer, allocatable :: materials(:), joints(:)
      character(len=:), allocatable :: failure
      character(len=name_length) :: body
      integer :: b

      call find_names(group, path, 'material', found%materials, found%material, &
         model%materials%name, m, materials, error)
      call find_names(group, path, 'joint', found%joints, found%edge_joint, model%joints%name, j, &
         joints, error)
      do b = 1, size(found%names)
         if (allocated(error)) return
         body = ''
         if (found%body(b) > 0) body = found%bodies(found%body(b))
         associate (first => found%first(b), last => found%first(b + 1) - 1)
            failure = outline_failure(found%vertices(:, first:last))
            if (failure /= '') then
               call input_error(error, group, trim(path//': block '//to_text(b)//' '// &
                  found%names(b))//': vertices'//failure)
            else
               call add_outline(outlines, found%vertices(:, first:last), &
                  materials(found%material(b)), j, source, found%names(b), &
                  joints(found%edge_joint(first:last)), body)
            end if
         end associate
      end do
   end subroutine add_blocks

   !> Find the positions in the model of the materials or joints that a file uses.
   subroutine find_names(group, path, kind, names, used, known, usual, positions, error)
      type(group_type), intent(in) :: group      !< group of the input
      character(len=*), intent(in) :: path, kind !< path of the file; 'material' or 'joint'
      character(len=*), intent(in) :: names(:)   !< names in the file
      integer, intent(in) :: used(:)             !< numbers of the names that are used; 0: none
      character(len=*), intent(in) :: known(:)   !< known names
      integer, intent(in) :: usual               !< position for number 0
      integer, allocatable, intent(out) :: positions(:)      !< [0:names]
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      character(len=:), allocatable :: hint
      integer :: i, near

      allocate (positions(0:size(names)), source=usual)
      do i = 1, size(names)
         if (names(i) == '') cycle
         positions(i) = findloc(known == names(i), .true., 1)
         if (positions(i) > 0 .or. .not. any(used == i)) cycle
         near = closest(trim(names(i)), known)
         hint = ''
         if (near > 0) hint = '; is '//quoted(known(near))//' meant?'
         call input_error(error, group, path//': '//kind//'_name = '//quoted(names(i))// &
            ' is not the name of a &'//kind//hint)
         return
      end do
   end subroutine find_names

end module dda_input_block_file
