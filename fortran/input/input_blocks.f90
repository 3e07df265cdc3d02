! SPDX-License-Identifier: GPL-3.0-or-later
!> Groups that make blocks: &block, &blocks (of a netCDF file), &layers, &drums, &wall.
module dda_input_blocks
   use dda_kinds, only: wp
   use dda_errors, only: error_type
   use dda_input_group, only: group_type, fail_input, require_name, value_or, name_length
   use dda_input_groups, only: block_values, drums_values, layers_values, rest_values, &
      wall_values, read_values, blocks_values
   use dda_input_materials, only: find_substances
   use dda_model, only: model_type, block_source_type
   use dda_outlines, only: outlines_type, add_outline, add_layers, add_drums, add_wall, set_cover, &
      most_blocks, outline_failure
   use dda_text, only: quoted, to_text, closest
   use dda_block_file, only: block_file_type, read_block_file
   implicit none
   private
   public :: read_blocks, is_block_group

contains

   !> .true. if a group makes blocks.
   pure logical function is_block_group(name)
      character(len=*), intent(in) :: name       !< name of the group

      is_block_group = any(name == [character(len=6) :: 'block', 'blocks', 'layers', 'drums', &
         'wall'])
   end function is_block_group

   !> Read any of the block groups.
   subroutine read_blocks(group, source, folder, model, outlines, error)
      type(group_type), intent(in) :: group      !< group of the input
      integer, intent(in) :: source              !< number of the group
      character(len=*), intent(in) :: folder     !< folder of the input, '' or ending in '/'
      type(model_type), intent(inout) :: model   !< model with its materials and joints
      type(outlines_type), intent(inout) :: outlines         !< outlines; new blocks are added
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      select case (group%name)
      case ('block')
         call read_block(group, source, model, outlines, error)
      case ('blocks')
         call read_block_group(group, source, folder, model, outlines, error)
      case ('layers')
         call read_layers(group, source, model, outlines, error)
      case ('drums')
         call read_drums(group, source, model, outlines, error)
      case ('wall')
         call read_wall(group, source, model, outlines, error)
      end select
   end subroutine read_blocks

   !> Read &block: one polygon.
   subroutine read_block(group, source, model, outlines, error)
      type(group_type), intent(in) :: group      !< group of the input
      integer, intent(in) :: source              !< number of the group
      type(model_type), intent(in) :: model      !< model with its materials and joints
      type(outlines_type), intent(inout) :: outlines         !< outlines; new blocks are added
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(block_values) :: input
      integer, allocatable :: joints(:)
      integer :: m, j, n

      call read_values(group, input, error)
      call find_substances(group, input%naming, model, m, j, error)
      n = size(input%vertices, 2)
      if (n < 3) call fail_input(error, group, 'vertices: '//to_text(n)// &
         ' given, but a block needs at least 3')
      call resolve_edges(group, model, n, j, input%edge_joints, joints, error)
      if (.not. allocated(error)) call add_block(group, input, m, joints, source, outlines, error)
   end subroutine read_block

   !> Add a block if its polygon is simple and counter-clockwise.
   subroutine add_block(group, input, material, joints, source, outlines, error)
      type(group_type), intent(in) :: group   !< group of the input
      type(block_values), intent(in) :: input  !< values of the group
      integer, intent(in) :: material, joints(:), source !< positions; number of the group
      type(outlines_type), intent(inout) :: outlines         !< receives the block
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      character(len=:), allocatable :: failure

      failure = outline_failure(input%vertices)
      if (failure /= '') then
         call fail_input(error, group, 'vertices'//failure)
      else
         call add_outline(outlines, input%vertices, material, joints(1), source, input%name, &
            joints, input%body)
      end if
   end subroutine add_block

   !> Find the joints of a block's edges; an edge without a name has the joint of the block.
   subroutine resolve_edges(group, model, edges, joint, names, joints, error)
      type(group_type), intent(in) :: group          !< group of the input
      type(model_type), intent(in) :: model          !< model with its joints
      integer, intent(in) :: edges                   !< number of edges of the block
      integer, intent(in) :: joint  !< joint of the block, position in the model's list
      character(len=*), intent(in) :: names(:)       !< names of the first edges, or blank
      integer, allocatable, intent(out) :: joints(:) !< [edges] positions in the model's list
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer :: i

      if (size(names) > edges) call fail_input(error, group, 'edge_joints: '// &
         to_text(size(names))//' names, but the block has '//to_text(edges)//' edges')
      allocate (joints(edges), source=joint)
      do i = 1, min(size(names), edges)
         if (names(i) /= '') call require_name(error, group, 'edge_joints('//to_text(i)//')', &
            names(i), model%joints%name, 'joint', joints(i))
      end do
   end subroutine resolve_edges

   !> Set the stress due to weight in the new blocks of a group, if requested.
   subroutine set_weight_stress(group, stress, model, outlines, first, error)
      type(group_type), intent(in) :: group      !< group of the input
      type(rest_values), intent(in) :: stress      !< values of the variables of initial stress
      type(model_type), intent(in) :: model      !< model with its gravity
      type(outlines_type), intent(inout) :: outlines         !< outlines with the new blocks
      integer, intent(in) :: first               !< number of the first new block
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      if (allocated(error) .or. .not. stress%geostatic) return
      associate (gravity => model%control%gravity)
         if (abs(gravity(1)) > 0.0_wp .or. .not. gravity(2) < 0.0_wp) call fail_input(error, &
            group, 'geostatic = .true. needs a gravity that acts downwards; gravity is '// &
            to_text(gravity))
      end associate
      if (.not. allocated(error)) call set_cover(outlines, first, stress%overburden)
   end subroutine set_weight_stress

   !> Read &layers: a stack of equal layers.
   subroutine read_layers(group, source, model, outlines, error)
      type(group_type), intent(in) :: group      !< group of the input
      integer, intent(in) :: source              !< number of the group
      type(model_type), intent(in) :: model      !< model with its materials and joints
      type(outlines_type), intent(inout) :: outlines         !< outlines; new blocks are added
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(layers_values) :: input
      integer :: m, j, first

      call read_values(group, input, error)
      call find_substances(group, input%naming, model, m, j, error, stem=input%name)
      if (allocated(error)) return
      first = outlines%n + 1
      call add_layers(outlines, input%left, input%bottom, input%width, input%thickness, &
         input%count, m, j, source, input%name)
      call set_weight_stress(group, input%rest, model, outlines, first, error)
   end subroutine read_layers

   !> Read &drums: a column of drums, tapering from `width` to `top_width`.
   subroutine read_drums(group, source, model, outlines, error)
      type(group_type), intent(in) :: group      !< group of the input
      integer, intent(in) :: source              !< number of the group
      type(model_type), intent(in) :: model      !< model with its materials and joints
      type(outlines_type), intent(inout) :: outlines         !< outlines; new blocks are added
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(drums_values) :: input
      integer :: m, j

      call read_values(group, input, error)
      call find_substances(group, input%naming, model, m, j, error, stem=input%name)
      if (allocated(error)) return
      call add_drums(outlines, input%centre, input%bottom, input%height, [input%width, &
         value_or(input%top_width, input%width)], input%count, m, j, source, input%name)
   end subroutine read_drums

   !> Read &wall: running bond.
   subroutine read_wall(group, source, model, outlines, error)
      type(group_type), intent(in) :: group      !< group of the input
      integer, intent(in) :: source              !< number of the group
      type(model_type), intent(in) :: model      !< model with its materials and joints
      type(outlines_type), intent(inout) :: outlines         !< outlines; new blocks are added
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(wall_values) :: input
      integer :: m, j, first

      call read_values(group, input, error)
      call find_substances(group, input%naming, model, m, j, error, stem=input%name)
      if (allocated(error)) return
      if (input%head_joint >= 0.5_wp*input%brick_length) call fail_input(error, group, &
         'head_joint = '//to_text(input%head_joint)//' m must be shorter than half of '// &
         'brick_length = '//to_text(input%brick_length)//' m')
      if (real(input%courses, wp)*input%bricks > most_blocks) call fail_input(error, group, &
         'courses = '//to_text(input%courses)//' of '// &
         to_text(input%bricks)//' bricks are more than '//to_text(int(most_blocks))//' blocks')
      if (allocated(error)) return
      first = outlines%n + 1
      call add_wall(outlines, input%left, input%bottom, [input%brick_length, input%brick_height], &
         input%bricks, input%courses, m, j, source, input%name, input%head_joint)
      call set_weight_stress(group, input%rest, model, outlines, first, error)
   end subroutine read_wall

   !> Read &blocks.
   subroutine read_block_group(group, source, folder, model, outlines, error)
      type(group_type), intent(in) :: group      !< group of the input
      integer, intent(in) :: source              !< number of the group
      character(len=*), intent(in) :: folder     !< folder of the input, '' or ending in '/'
      type(model_type), intent(inout) :: model !< model with materials and joints; receives the file
      type(outlines_type), intent(inout) :: outlines         !< outlines; new blocks are added
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(block_file_type) :: content
      type(error_type), allocatable :: failure
      type(blocks_values) :: input
      character(len=:), allocatable :: path
      integer :: m, j

      call read_values(group, input, error)
      call find_substances(group, input%naming, model, m, j, error)
      if (allocated(error)) return
      path = input%file
      if (path(1:1) /= '/') path = folder//path
      call read_block_file(content, path, failure)
      if (allocated(failure)) call fail_input(error, group, failure%message)
      if (allocated(error)) return
      call add_blocks(group, path, content, source, m, j, model, outlines, error)
      model%block_files = [model%block_files, block_source_type(path, content%checksum)]
   end subroutine read_block_group

   !> Add the blocks of a file, whose polygons must be valid.
   subroutine add_blocks(group, path, content, source, m, j, model, outlines, error)
      type(group_type), intent(in) :: group          !< group of the input
      character(len=*), intent(in) :: path           !< path of the file, for messages
      type(block_file_type), intent(in) :: content     !< content of the file
      integer, intent(in) :: source                  !< number of the group
      integer, intent(in) :: m, j  !< default material and joint, if the file names none
      type(model_type), intent(in) :: model          !< model with its materials and joints
      type(outlines_type), intent(inout) :: outlines !< outlines; new blocks are added
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer, allocatable :: materials(:), joints(:)
      character(len=:), allocatable :: failure
      character(len=name_length) :: body
      integer :: b

      call find_names(group, path, 'material', content%materials, content%material, &
         model%materials%name, m, materials, error)
      call find_names(group, path, 'joint', content%joints, content%edge_joint, model%joints%name, &
         j, joints, error)
      do b = 1, size(content%names)
         if (allocated(error)) return
         body = ''
         if (content%body(b) > 0) body = content%bodies(content%body(b))
         associate (first => content%first(b), last => content%first(b + 1) - 1)
            failure = outline_failure(content%vertices(:, first:last))
            if (failure /= '') then
               call fail_input(error, group, trim(path//': block '//to_text(b)//' '// &
                  content%names(b))//': vertices'//failure)
            else
               call add_outline(outlines, content%vertices(:, first:last), &
                  materials(content%material(b)), j, source, content%names(b), &
                  joints(content%edge_joint(first:last)), body)
            end if
         end associate
      end do
   end subroutine add_blocks

   !> Find the positions in the model of the materials or joints that a file uses.
   subroutine find_names(group, path, kind, names, used_numbers, model_names, default_position, &
      positions, error)
      type(group_type), intent(in) :: group      !< group of the input
      character(len=*), intent(in) :: path, kind !< path of the file; 'material' or 'joint'
      character(len=*), intent(in) :: names(:)   !< names in the file
      integer, intent(in) :: used_numbers(:)  !< numbers of the names that are used; 0: none
      character(len=*), intent(in) :: model_names(:)   !< names in the model
      integer, intent(in) :: default_position    !< position for number 0
      integer, allocatable, intent(out) :: positions(:)      !< [0:names]
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      character(len=:), allocatable :: hint
      integer :: i, similar

      allocate (positions(0:size(names)), source=default_position)
      do i = 1, size(names)
         if (names(i) == '') cycle
         positions(i) = findloc(model_names == names(i), .true., 1)
         if (positions(i) > 0 .or. .not. any(used_numbers == i)) cycle
         similar = closest(trim(names(i)), model_names)
         hint = ''
         if (similar > 0) hint = '; is '//quoted(model_names(similar))//' meant?'
         call fail_input(error, group, path//': '//kind//'_name = '//quoted(names(i))// &
            ' is not the name of a &'//kind//hint)
         return
      end do
   end subroutine find_names

end module dda_input_blocks
