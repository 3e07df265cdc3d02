! SPDX-License-Identifier: GPL-3.0-or-later
!> The groups that make blocks: &block, &blocks, &layers, &drums, &wall.
module dda_input_blocks
   use dda_kinds, only: wp
   use dda_errors, only: error_type
   use dda_input_block_file, only: read_block_group
   use dda_input_group, only: place_type, input_error, check_read, require, require_list, &
      require_name, unset, is_set, name_length
   use dda_input_materials, only: find_substances
   use dda_model, only: model_type
   use dda_outlines, only: outlines_type, add_outline, add_layers, add_drums, add_wall, bury, &
      most_blocks, most_vertices, outline_failure
   use dda_text, only: quoted, to_text
   implicit none
   private
   public :: read_blocks, is_block_group

   character, parameter :: unnamed = achar(0)    !< edge that the input does not mention
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
   subroutine read_blocks(text, place, source, folder, model, outlines, error)
      character(len=*), intent(in) :: text       !< of the group
      type(place_type), intent(in) :: place      !< of the group
      integer, intent(in) :: source              !< number of the group
      character(len=*), intent(in) :: folder     !< of the input, '' or ending in '/'
      type(model_type), intent(inout) :: model   !< with its materials and joints
      type(outlines_type), intent(inout) :: outlines         !< the new blocks are added
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays

      select case (place%group)
      case ('block')
         call read_block(text, place, source, model, outlines, error)
      case ('blocks')
         call read_block_group(text, place, source, folder, model, outlines, error)
      case ('layers')
         call read_layers(text, place, source, model, outlines, error)
      case ('drums')
         call read_drums(text, place, source, model, outlines, error)
      case ('wall')
         call read_wall(text, place, source, model, outlines, error)
      end select
   end subroutine read_blocks

   !> Generated names must leave space for their number.
   subroutine check_stem(place, name, error)
      type(place_type), intent(in) :: place      !< of the group
      character(len=*), intent(in) :: name       !< as the input has it
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays

      if (len_trim(name) > longest_stem) call input_error(error, place, 'name = '//quoted(name)// &
         ' is too long: at most '//to_text(longest_stem)// &
         ' characters, since the blocks get numbers')
   end subroutine check_stem

   !> &block: one polygon.
   subroutine read_block(text, place, source, model, outlines, error)
      character(len=*), intent(in) :: text       !< of the group
      type(place_type), intent(in) :: place      !< of the group
      integer, intent(in) :: source              !< number of the group
      type(model_type), intent(in) :: model      !< with its materials and joints
      type(outlines_type), intent(inout) :: outlines         !< the new blocks are added
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      character(len=name_length) :: name, material, joint, edge_joints(most_vertices)
      real(wp) :: vertices(2, most_vertices)
      integer, allocatable :: joints(:)
      character(len=256) :: message
      integer :: status, m, j, count
      namelist /block/ name, material, joint, edge_joints, vertices

      name = ''
      material = ''
      joint = ''
      edge_joints = unnamed
      vertices = unset
      read (text, nml=block, iostat=status, iomsg=message)
      call check_read(error, place, status, message)
      call find_substances(place, material, joint, model, m, j, error)
      count = last_set(vertices)
      call check_outline(place, vertices(:, :count), error)
      call resolve_edges(place, edge_joints, model, count, j, joints, error)
      if (.not. allocated(error)) call add_outline(outlines, vertices(:, :count), m, j, source, &
         name, joints)
   end subroutine read_block

   !> Positions of the joints of a block's edges; an edge without a name takes that of the block.
   subroutine resolve_edges(place, names, model, edges, joint, joints, error)
      type(place_type), intent(in) :: place          !< of the group
      character(len=*), intent(in) :: names(:)       !< of the edges; blank or `unnamed`: none
      type(model_type), intent(in) :: model          !< with its joints
      integer, intent(in) :: edges                   !< of the block
      integer, intent(in) :: joint                   !< of the block, position in the model's list
      integer, allocatable, intent(out) :: joints(:) !< [edges] positions in the model's list
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      integer :: i, given

      given = findloc(names(:)(1:1) /= unnamed, .true., 1, back=.true.)
      if (given > edges) call input_error(error, place, 'edge_joints: '//to_text(given)// &
         ' names, but the block has '//to_text(edges)//' edges')
      allocate (joints(edges), source=joint)
      do i = 1, min(given, edges)
         if (names(i) == unnamed .or. names(i) == '') cycle
         call require_name(error, place, 'edge_joints('//to_text(i)//')', names(i), &
            model%joints%name, 'joint', joints(i))
      end do
   end subroutine resolve_edges

   !> Number of vertices given.
   pure integer function last_set(vertices) result(last)
      real(wp), intent(in) :: vertices(:,:)  !< [2, vertices] m

      last = size(vertices, 2)
      do while (last > 0)
         if (any(is_set(vertices(:, last)))) exit
         last = last - 1
      end do
   end function last_set

   !> A polygon that can be a block: enough finite vertices, counter-clockwise, simple.
   subroutine check_outline(place, vertices, error)
      type(place_type), intent(in) :: place  !< of the group
      real(wp), intent(in) :: vertices(:,:)  !< [2, vertices] m
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      character(len=:), allocatable :: failure

      if (size(vertices, 2) < 3) call input_error(error, place, &
         'vertices: '//to_text(size(vertices, 2))//' given, a block needs at least 3')
      call require_list(error, place, 'vertices', reshape(vertices, [size(vertices)]))
      if (allocated(error)) return
      failure = outline_failure(vertices)
      if (failure /= '') call input_error(error, place, 'vertices'//failure)
   end subroutine check_outline

   !> The new blocks of a group begin with their weight as stress, if it says so.
   subroutine begin_at_rest(place, model, outlines, first, geostatic, overburden, error)
      type(place_type), intent(in) :: place      !< of the group
      type(model_type), intent(in) :: model      !< with its gravity
      type(outlines_type), intent(inout) :: outlines         !< with the new blocks
      integer, intent(in) :: first               !< of the new blocks
      logical, intent(in) :: geostatic           !< as the input has it
      real(wp), intent(in) :: overburden         !< Pa, as the input has it
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays

      call require(error, place, 'overburden', [overburden])
      if (overburden > 0.0_wp .and. .not. geostatic) call input_error(error, place, &
         'overburden = '//to_text(overburden)//' is part of the stress of geostatic = .true., '// &
         'which is not set; loads are given by &traction')
      if (allocated(error) .or. .not. geostatic) return
      associate (gravity => model%control%gravity)
         if (abs(gravity(1)) > 0.0_wp .or. .not. gravity(2) < 0.0_wp) call input_error(error, &
            place, 'geostatic = .true. needs a gravity that acts downwards; gravity is '// &
            to_text(gravity(1))//', '//to_text(gravity(2)))
      end associate
      if (.not. allocated(error)) call bury(outlines, first, overburden)
   end subroutine begin_at_rest

   !> &layers: a stack of equal layers.
   subroutine read_layers(text, place, source, model, outlines, error)
      character(len=*), intent(in) :: text       !< of the group
      type(place_type), intent(in) :: place      !< of the group
      integer, intent(in) :: source              !< number of the group
      type(model_type), intent(in) :: model      !< with its materials and joints
      type(outlines_type), intent(inout) :: outlines         !< the new blocks are added
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      character(len=name_length) :: name, material, joint
      real(wp) :: left, bottom, width, thickness, overburden
      character(len=256) :: message
      integer :: status, m, j, count, first
      logical :: geostatic
      namelist /layers/ name, material, joint, left, bottom, width, thickness, count, geostatic, &
         overburden

      name = 'layer'
      material = ''
      joint = ''
      left = 0.0_wp
      bottom = 0.0_wp
      width = unset
      thickness = unset
      count = 1
      geostatic = .false.
      overburden = 0.0_wp
      read (text, nml=layers, iostat=status, iomsg=message)
      call check_read(error, place, status, message)
      call require(error, place, 'left bottom width thickness count', &
         [left, bottom, width, thickness, real(count, wp)])
      call check_stem(place, name, error)
      call find_substances(place, material, joint, model, m, j, error)
      if (allocated(error)) return
      first = outlines%n + 1
      call add_layers(outlines, left, bottom, width, thickness, count, m, j, source, name)
      call begin_at_rest(place, model, outlines, first, geostatic, overburden, error)
   end subroutine read_layers

   !> &drums: a column of drums, tapering from `width` to `top_width`.
   subroutine read_drums(text, place, source, model, outlines, error)
      character(len=*), intent(in) :: text       !< of the group
      type(place_type), intent(in) :: place      !< of the group
      integer, intent(in) :: source              !< number of the group
      type(model_type), intent(in) :: model      !< with its materials and joints
      type(outlines_type), intent(inout) :: outlines         !< the new blocks are added
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      character(len=name_length) :: name, material, joint
      real(wp) :: centre, bottom, width, top_width, height
      character(len=256) :: message
      integer :: status, m, j, count
      namelist /drums/ name, material, joint, centre, bottom, width, top_width, height, count

      name = 'drum'
      material = ''
      joint = ''
      centre = 0.0_wp
      bottom = 0.0_wp
      width = unset
      top_width = unset
      height = unset
      count = 1
      read (text, nml=drums, iostat=status, iomsg=message)
      call check_read(error, place, status, message)
      if (.not. is_set(top_width)) top_width = width
      call require(error, place, 'centre bottom width top_width height count', &
         [centre, bottom, width, top_width, height, real(count, wp)])
      call check_stem(place, name, error)
      call find_substances(place, material, joint, model, m, j, error)
      if (.not. allocated(error)) call add_drums(outlines, centre, bottom, height, &
         [width, top_width], count, m, j, source, name)
   end subroutine read_drums

   !> &wall: running bond.
   subroutine read_wall(text, place, source, model, outlines, error)
      character(len=*), intent(in) :: text       !< of the group
      type(place_type), intent(in) :: place      !< of the group
      integer, intent(in) :: source              !< number of the group
      type(model_type), intent(in) :: model      !< with its materials and joints
      type(outlines_type), intent(inout) :: outlines         !< the new blocks are added
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      character(len=name_length) :: name, material, joint
      real(wp) :: left, bottom, brick_length, brick_height, head_joint, overburden
      character(len=256) :: message
      integer :: status, m, j, bricks, courses, first
      logical :: geostatic
      namelist /wall/ name, material, joint, left, bottom, brick_length, brick_height, bricks, &
         courses, head_joint, geostatic, overburden

      name = 'brick'
      material = ''
      joint = ''
      left = 0.0_wp
      bottom = 0.0_wp
      brick_length = unset
      brick_height = unset
      bricks = 1
      courses = 1
      head_joint = 0.0_wp
      geostatic = .false.
      overburden = 0.0_wp
      read (text, nml=wall, iostat=status, iomsg=message)
      call check_read(error, place, status, message)
      call require(error, place, 'left bottom brick_length brick_height bricks courses '// &
         'head_joint', [left, bottom, brick_length, brick_height, real(bricks, wp), &
         real(courses, wp), head_joint])
      if (head_joint >= 0.5_wp*brick_length) call input_error(error, place, 'head_joint = '// &
         to_text(head_joint)//' m leaves nothing of half a brick of brick_length = '// &
         to_text(brick_length)//' m')
      if (real(courses, wp)*bricks > most_blocks) call input_error(error, place, 'courses = '// &
         to_text(courses)//' of '//to_text(bricks)//' bricks are more than '// &
         to_text(int(most_blocks))//' blocks')
      call check_stem(place, name, error)
      call find_substances(place, material, joint, model, m, j, error)
      if (allocated(error)) return
      first = outlines%n + 1
      call add_wall(outlines, left, bottom, [brick_length, brick_height], bricks, courses, m, j, &
         source, name, head_joint)
      call begin_at_rest(place, model, outlines, first, geostatic, overburden, error)
   end subroutine read_wall

end module dda_input_blocks
