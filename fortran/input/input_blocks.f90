!> The groups that make blocks: &block, &layers, &drums, &wall.
module dda_input_blocks
   use dda_kinds, only: wp
   use dda_errors, only: error_type
   use dda_input_group, only: place_type, input_error, read_error, require_positive, &
      require_finite, unset, is_set, name_length, require_within
   use dda_material, only: material_type, joint_type
   use dda_outlines, only: outlines_type, add_outline, add_layers, add_drums, add_wall
   use dda_polygon, only: area_of, is_simple
   use dda_text, only: quoted, to_text
   implicit none
   private
   public :: read_blocks, is_block_group

   integer, parameter :: most_vertices = 512
   integer, parameter :: most_blocks = 2000000
   !> of the name of generated blocks, which get a number
   integer, parameter :: longest_stem = name_length - 8

contains

   pure logical function is_block_group(name)
      character(len=*), intent(in) :: name

      is_block_group = any(name == [character(len=6) :: 'block', 'layers', 'drums', 'wall'])
   end function is_block_group

   !> Any of the block groups.
   subroutine read_blocks(name, group, place, source, materials, joints, outlines, error)
      character(len=*), intent(in) :: name, group
      type(place_type), intent(in) :: place
      integer, intent(in) :: source            !< number of the group
      type(material_type), intent(in) :: materials(:)
      type(joint_type), intent(in) :: joints(:)
      type(outlines_type), intent(inout) :: outlines
      type(error_type), allocatable, intent(inout) :: error

      select case (name)
      case ('block')
         call read_block(group, place, source, materials, joints, outlines, error)
      case ('layers')
         call read_layers(group, place, source, materials, joints, outlines, error)
      case ('drums')
         call read_drums(group, place, source, materials, joints, outlines, error)
      case ('wall')
         call read_wall(group, place, source, materials, joints, outlines, error)
      end select
   end subroutine read_blocks

   !> Positions of a material and a joint by name; a blank name takes the only or first one.
   subroutine resolve(place, material, joint, materials, joints, m, j, error)
      type(place_type), intent(in) :: place
      character(len=*), intent(in) :: material, joint
      type(material_type), intent(in) :: materials(:)
      type(joint_type), intent(in) :: joints(:)
      integer, intent(out) :: m, j
      type(error_type), allocatable, intent(inout) :: error

      m = findloc(materials%name == material, .true., 1)
      j = findloc(joints%name == joint, .true., 1)
      if (material == '') m = 1
      if (joint == '') j = 1
      if (m == 0) call input_error(error, place, 'material = '//quoted(material)// &
         ' is not the name of a &material')
      if (j == 0) call input_error(error, place, 'joint = '//quoted(joint)// &
         ' is not the name of a &joint')
   end subroutine resolve

   !> Generated names must have room for their number.
   subroutine check_stem(place, name, error)
      type(place_type), intent(in) :: place
      character(len=*), intent(in) :: name
      type(error_type), allocatable, intent(inout) :: error

      if (len_trim(name) > longest_stem) call input_error(error, place, 'name = '//quoted(name)// &
         ' is too long: at most '//to_text(longest_stem)// &
         ' characters, since the blocks get numbers')
   end subroutine check_stem

   subroutine read_block(group, place, source, materials, joints, outlines, error)
      character(len=*), intent(in) :: group
      type(place_type), intent(in) :: place
      integer, intent(in) :: source
      type(material_type), intent(in) :: materials(:)
      type(joint_type), intent(in) :: joints(:)
      type(outlines_type), intent(inout) :: outlines
      type(error_type), allocatable, intent(inout) :: error
      character(len=name_length) :: name, material, joint
      real(wp) :: vertices(2, most_vertices)
      character(len=256) :: message
      integer :: status, m, j, count
      namelist /block/ name, material, joint, vertices

      name = ''
      material = ''
      joint = ''
      vertices = unset
      read (group, nml=block, iostat=status, iomsg=message)
      if (status /= 0) call read_error(error, place, message)
      call resolve(place, material, joint, materials, joints, m, j, error)
      count = last_set(vertices)
      call check_outline(place, vertices(:, :count), error)
      if (.not. allocated(error)) call add_outline(outlines, vertices(:, :count), m, j, source, &
         name)
   end subroutine read_block

   !> How many vertices were given.
   pure integer function last_set(vertices) result(last)
      real(wp), intent(in) :: vertices(:,:)

      last = size(vertices, 2)
      do while (last > 0)
         if (any(is_set(vertices(:, last)))) exit
         last = last - 1
      end do
   end function last_set

   !> A polygon that can be a block: enough finite vertices, counter-clockwise, simple.
   subroutine check_outline(place, vertices, error)
      type(place_type), intent(in) :: place
      real(wp), intent(in) :: vertices(:,:)
      type(error_type), allocatable, intent(inout) :: error
      real(wp) :: size_squared

      if (size(vertices, 2) < 3) call input_error(error, place, &
         'vertices: '//to_text(size(vertices, 2))//' given, a block needs at least 3')
      call require_finite(error, place, 'vertices', reshape(vertices, [size(vertices)]))
      if (allocated(error)) return
      size_squared = maxval(maxval(vertices, 2) - minval(vertices, 2))**2
      if (.not. is_simple(vertices)) then
         call input_error(error, place, 'vertices: the polygon crosses or touches itself, or '// &
            'repeats a vertex')
      else if (area_of(vertices) < 0.0_wp) then
         call input_error(error, place, 'vertices run clockwise; give them counter-clockwise')
      else if (.not. area_of(vertices) > 1.0e-12_wp*size_squared) then
         call input_error(error, place, 'vertices: the polygon has no area')
      end if
   end subroutine check_outline

   subroutine read_layers(group, place, source, materials, joints, outlines, error)
      character(len=*), intent(in) :: group
      type(place_type), intent(in) :: place
      integer, intent(in) :: source
      type(material_type), intent(in) :: materials(:)
      type(joint_type), intent(in) :: joints(:)
      type(outlines_type), intent(inout) :: outlines
      type(error_type), allocatable, intent(inout) :: error
      character(len=name_length) :: name, material, joint
      real(wp) :: left, bottom, width, thickness
      character(len=256) :: message
      integer :: status, m, j, count
      namelist /layers/ name, material, joint, left, bottom, width, thickness, count

      name = 'layer'
      material = ''
      joint = ''
      left = 0.0_wp
      bottom = 0.0_wp
      width = unset
      thickness = unset
      count = 1
      read (group, nml=layers, iostat=status, iomsg=message)
      if (status /= 0) call read_error(error, place, message)
      call require_finite(error, place, 'left', [left])
      call require_finite(error, place, 'bottom', [bottom])
      call require_positive(error, place, 'width', width)
      call require_positive(error, place, 'thickness', thickness)
      call require_within(error, place, 'count', real(count, wp), 1.0_wp, real(most_blocks, wp))
      call check_stem(place, name, error)
      call resolve(place, material, joint, materials, joints, m, j, error)
      if (.not. allocated(error)) call add_layers(outlines, left, bottom, width, thickness, count, &
         m, j, source, name)
   end subroutine read_layers

   subroutine read_drums(group, place, source, materials, joints, outlines, error)
      character(len=*), intent(in) :: group
      type(place_type), intent(in) :: place
      integer, intent(in) :: source
      type(material_type), intent(in) :: materials(:)
      type(joint_type), intent(in) :: joints(:)
      type(outlines_type), intent(inout) :: outlines
      type(error_type), allocatable, intent(inout) :: error
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
      read (group, nml=drums, iostat=status, iomsg=message)
      if (status /= 0) call read_error(error, place, message)
      call require_finite(error, place, 'centre', [centre])
      call require_finite(error, place, 'bottom', [bottom])
      call require_positive(error, place, 'width', width)
      if (.not. is_set(top_width)) top_width = width
      call require_positive(error, place, 'top_width', top_width)
      call require_positive(error, place, 'height', height)
      call require_within(error, place, 'count', real(count, wp), 1.0_wp, real(most_blocks, wp))
      call check_stem(place, name, error)
      call resolve(place, material, joint, materials, joints, m, j, error)
      if (.not. allocated(error)) call add_drums(outlines, centre, bottom, height, &
         [width, top_width], count, m, j, source, name)
   end subroutine read_drums

   subroutine read_wall(group, place, source, materials, joints, outlines, error)
      character(len=*), intent(in) :: group
      type(place_type), intent(in) :: place
      integer, intent(in) :: source
      type(material_type), intent(in) :: materials(:)
      type(joint_type), intent(in) :: joints(:)
      type(outlines_type), intent(inout) :: outlines
      type(error_type), allocatable, intent(inout) :: error
      character(len=name_length) :: name, material, joint
      real(wp) :: left, bottom, brick_length, brick_height
      character(len=256) :: message
      integer :: status, m, j, bricks, courses
      namelist /wall/ name, material, joint, left, bottom, brick_length, brick_height, bricks, &
         courses

      name = 'brick'
      material = ''
      joint = ''
      left = 0.0_wp
      bottom = 0.0_wp
      brick_length = unset
      brick_height = unset
      bricks = 1
      courses = 1
      read (group, nml=wall, iostat=status, iomsg=message)
      if (status /= 0) call read_error(error, place, message)
      call require_finite(error, place, 'left', [left])
      call require_finite(error, place, 'bottom', [bottom])
      call require_positive(error, place, 'brick_length', brick_length)
      call require_positive(error, place, 'brick_height', brick_height)
      call require_within(error, place, 'bricks', real(bricks, wp), 1.0_wp, 1.0e6_wp)
      call require_within(error, place, 'courses', real(courses, wp), 1.0_wp, &
         real(most_blocks, wp)/max(bricks, 1))
      call check_stem(place, name, error)
      call resolve(place, material, joint, materials, joints, m, j, error)
      if (.not. allocated(error)) call add_wall(outlines, left, bottom, &
         [brick_length, brick_height], bricks, courses, m, j, source, name)
   end subroutine read_wall

end module dda_input_blocks
