! SPDX-License-Identifier: GPL-3.0-or-later
!> The groups that make blocks: &block, &blocks, &layers, &drums, &wall.
module dda_input_blocks
   use dda_kinds, only: wp
   use dda_errors, only: error_type
   use dda_input_block_file, only: read_block_group
   use dda_input_group, only: group_type, input_error, get, get_list, require_name, name_length
   use dda_input_materials, only: find_substances
   use dda_model, only: model_type
   use dda_outlines, only: outlines_type, add_outline, add_layers, add_drums, add_wall, bury, &
      most_blocks, outline_failure
   use dda_text, only: quoted, to_text
   implicit none
   private
   public :: read_blocks, is_block_group

   !> of the name of generated blocks, which get a number
   integer, parameter :: longest_stem = name_length - 8

contains

   !> Whether a group makes blocks.
   pure logical function is_block_group(name)
      character(len=*), intent(in) :: name       !< of the group

      is_block_group = any(name == [character(len=6) :: 'block', 'blocks', 'layers', 'drums', &
         'wall'])
   end function is_block_group

   !> Any of the block groups.
   subroutine read_blocks(group, source, folder, model, outlines, error)
      type(group_type), intent(in) :: group      !< of the group
      integer, intent(in) :: source              !< number of the group
      character(len=*), intent(in) :: folder     !< of the input, '' or ending in '/'
      type(model_type), intent(inout) :: model   !< with its materials and joints
      type(outlines_type), intent(inout) :: outlines         !< the new blocks are added
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays

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

   !> The name of generated blocks, which leaves space for their number.
   subroutine get_stem(group, name, error)
      type(group_type), intent(in) :: group      !< of the input
      character(len=name_length), intent(inout) :: name      !< as the input has it
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays

      call get(group, 'name', name, error)
      if (len_trim(name) > longest_stem) call input_error(error, group, 'name = '//quoted(name)// &
         ' is too long: at most '//to_text(longest_stem)// &
         ' characters, since the blocks get numbers')
   end subroutine get_stem

   !> &block: one polygon.
   subroutine read_block(group, source, model, outlines, error)
      type(group_type), intent(in) :: group      !< of the input
      integer, intent(in) :: source              !< number of the group
      type(model_type), intent(in) :: model      !< with its materials and joints
      type(outlines_type), intent(inout) :: outlines         !< the new blocks are added
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      character(len=name_length) :: name, body
      real(wp), allocatable :: values(:)
      integer, allocatable :: joints(:)
      integer :: m, j, n

      name = ''
      body = ''
      call get(group, 'name', name, error)
      call get(group, 'body', body, error)
      call find_substances(group, model, m, j, error)
      call get_list(group, 'vertices', values, error)
      n = (size(values) + 1)/2
      if (n < 3) call input_error(error, group, 'vertices: '//to_text(n)// &
         ' given, a block needs at least 3')
      if (2*n > size(values)) call input_error(error, group, 'vertices: a value is left out')
      call resolve_edges(group, model, n, j, joints, error)
      if (allocated(error)) return
      call add_block(group, reshape(values, [2, n]), m, joints, source, name, body, outlines, error)
   end subroutine read_block

   !> A polygon that can be a block: counter-clockwise, simple.
   subroutine add_block(group, vertices, material, joints, source, name, body, outlines, error)
      type(group_type), intent(in) :: group  !< of the input
      real(wp), intent(in) :: vertices(:,:)  !< [2, vertices] m
      integer, intent(in) :: material, joints(:), source !< positions in the model; of the group
      character(len=*), intent(in) :: name   !< or blank
      character(len=*), intent(in) :: body   !< that it is a cell of, or blank
      type(outlines_type), intent(inout) :: outlines         !< gets the block
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      character(len=:), allocatable :: failure

      failure = outline_failure(vertices)
      if (failure /= '') then
         call input_error(error, group, 'vertices'//failure)
      else
         call add_outline(outlines, vertices, material, joints(1), source, name, joints, body)
      end if
   end subroutine add_block

   !> Positions of the joints of a block's edges; an edge without a name takes that of the block.
   subroutine resolve_edges(group, model, edges, joint, joints, error)
      type(group_type), intent(in) :: group          !< of the input
      type(model_type), intent(in) :: model          !< with its joints
      integer, intent(in) :: edges                   !< of the block
      integer, intent(in) :: joint                   !< of the block, position in the model's list
      integer, allocatable, intent(out) :: joints(:) !< [edges] positions in the model's list
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      character(len=name_length), allocatable :: names(:)
      integer :: i

      call get_list(group, 'edge_joints', names, error)
      if (size(names) > edges) call input_error(error, group, 'edge_joints: '// &
         to_text(size(names))//' names, but the block has '//to_text(edges)//' edges')
      allocate (joints(edges), source=joint)
      do i = 1, min(size(names), edges)
         if (names(i) /= '') call require_name(error, group, 'edge_joints('//to_text(i)//')', &
            names(i), model%joints%name, 'joint', joints(i))
      end do
   end subroutine resolve_edges

   !> The new blocks of a group begin with their weight as stress, if it says so.
   subroutine begin_at_rest(group, model, outlines, first, error)
      type(group_type), intent(in) :: group      !< of the input
      type(model_type), intent(in) :: model      !< with its gravity
      type(outlines_type), intent(inout) :: outlines         !< with the new blocks
      integer, intent(in) :: first               !< of the new blocks
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      real(wp) :: overburden
      logical :: geostatic

      overburden = 0.0_wp
      geostatic = .false.
      call get(group, 'overburden', overburden, error)
      call get(group, 'geostatic', geostatic)
      if (overburden > 0.0_wp .and. .not. geostatic) call input_error(error, group, &
         'overburden = '//to_text(overburden)//' is part of the stress of geostatic = .true., '// &
         'which is not set; loads are given by &traction')
      if (allocated(error) .or. .not. geostatic) return
      associate (gravity => model%control%gravity)
         if (abs(gravity(1)) > 0.0_wp .or. .not. gravity(2) < 0.0_wp) call input_error(error, &
            group, 'geostatic = .true. needs a gravity that acts downwards; gravity is '// &
            to_text(gravity(1))//', '//to_text(gravity(2)))
      end associate
      if (.not. allocated(error)) call bury(outlines, first, overburden)
   end subroutine begin_at_rest

   !> &layers: a stack of equal layers.
   subroutine read_layers(group, source, model, outlines, error)
      type(group_type), intent(in) :: group      !< of the input
      integer, intent(in) :: source              !< number of the group
      type(model_type), intent(in) :: model      !< with its materials and joints
      type(outlines_type), intent(inout) :: outlines         !< the new blocks are added
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      character(len=name_length) :: name
      real(wp) :: left, bottom, width, thickness
      integer :: m, j, count, first

      name = 'layer'
      left = 0.0_wp
      bottom = 0.0_wp
      count = 1
      call get(group, 'left', left, error)
      call get(group, 'bottom', bottom, error)
      call get(group, 'width', width, error)
      call get(group, 'thickness', thickness, error)
      call get(group, 'count', count, error)
      call get_stem(group, name, error)
      call find_substances(group, model, m, j, error)
      if (allocated(error)) return
      first = outlines%n + 1
      call add_layers(outlines, left, bottom, width, thickness, count, m, j, source, name)
      call begin_at_rest(group, model, outlines, first, error)
   end subroutine read_layers

   !> &drums: a column of drums, tapering from `width` to `top_width`.
   subroutine read_drums(group, source, model, outlines, error)
      type(group_type), intent(in) :: group      !< of the input
      integer, intent(in) :: source              !< number of the group
      type(model_type), intent(in) :: model      !< with its materials and joints
      type(outlines_type), intent(inout) :: outlines         !< the new blocks are added
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      character(len=name_length) :: name
      real(wp) :: centre, bottom, width(2), height
      integer :: m, j, count

      name = 'drum'
      centre = 0.0_wp
      bottom = 0.0_wp
      count = 1
      call get(group, 'centre', centre, error)
      call get(group, 'bottom', bottom, error)
      call get(group, 'width', width(1), error)
      width(2) = width(1)
      call get(group, 'top_width', width(2), error)
      call get(group, 'height', height, error)
      call get(group, 'count', count, error)
      call get_stem(group, name, error)
      call find_substances(group, model, m, j, error)
      if (.not. allocated(error)) call add_drums(outlines, centre, bottom, height, width, count, &
         m, j, source, name)
   end subroutine read_drums

   !> &wall: running bond.
   subroutine read_wall(group, source, model, outlines, error)
      type(group_type), intent(in) :: group      !< of the input
      integer, intent(in) :: source              !< number of the group
      type(model_type), intent(in) :: model      !< with its materials and joints
      type(outlines_type), intent(inout) :: outlines         !< the new blocks are added
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      character(len=name_length) :: name
      real(wp) :: left, bottom, brick(2), head_joint
      integer :: m, j, bricks, courses, first

      name = 'brick'
      left = 0.0_wp
      bottom = 0.0_wp
      bricks = 1
      courses = 1
      head_joint = 0.0_wp
      call get(group, 'left', left, error)
      call get(group, 'bottom', bottom, error)
      call get(group, 'brick_length', brick(1), error)
      call get(group, 'brick_height', brick(2), error)
      call get(group, 'bricks', bricks, error)
      call get(group, 'courses', courses, error)
      call get(group, 'head_joint', head_joint, error)
      call get_stem(group, name, error)
      call find_substances(group, model, m, j, error)
      if (allocated(error)) return
      if (head_joint >= 0.5_wp*brick(1)) call input_error(error, group, 'head_joint = '// &
         to_text(head_joint)//' m leaves nothing of half a brick of brick_length = '// &
         to_text(brick(1))//' m')
      if (real(courses, wp)*bricks > most_blocks) call input_error(error, group, 'courses = '// &
         to_text(courses)//' of '//to_text(bricks)//' bricks are more than '// &
         to_text(int(most_blocks))//' blocks')
      if (allocated(error)) return
      first = outlines%n + 1
      call add_wall(outlines, left, bottom, brick, bricks, courses, m, j, source, name, head_joint)
      call begin_at_rest(group, model, outlines, first, error)
   end subroutine read_wall

end module dda_input_blocks
