! SPDX-License-Identifier: GPL-3.0-or-later
!> Groups of material points (&fixed_point, &load, &measured_point), &amplification between two
!> measured points, and &measured_joint.
module dda_input_points
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type, reference_of
   use dda_errors, only: error_type
   use dda_input_group, only: group_type, fail_input, require_name, positions, require_new_name, &
      mark_names
   use dda_input_groups, only: amplification_values, fixed_point_values, load_values, &
      measured_point_values, point_values, read_values, measured_joint_values
   use dda_model, only: model_type
   use dda_motion, only: motion_type
   use dda_polygon, only: contains_point
   use dda_settings, only: amplification_type
   use dda_support, only: fixed_point_type, load_type, measured_joint_type, point_type
   use dda_text, only: quoted, to_text
   implicit none
   private
   public :: read_fixed_point, read_load, read_point, read_amplification, find_block, &
      find_motions, number_of_block, block_at, set_times, set_values, read_measured_joints

   !> distance/block size within which a point is on an edge
   real(wp), parameter :: on_boundary = 1.0e-9_wp

contains

   !> Find the block of a given name that contains a point; without a name, the first such block.
   subroutine find_block(group, model, name, point, b, error)
      type(group_type), intent(in) :: group  !< group of the input
      type(model_type), intent(in) :: model      !< model with its blocks
      character(len=*), intent(in) :: name     !< name or number of a block, or blank
      real(wp), intent(in) :: point(2)           !< m
      integer, intent(out) :: b  !< number of the block; 0 on failure
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      character(len=:), allocatable :: subject

      b = 0
      if (allocated(error)) return
      subject = 'the point ('//to_text(point + model%origin)//')'
      if (name == '') then
         b = block_at(model%blocks, point)
         if (b == 0) call fail_input(error, group, subject//' lies outside every block')
         return
      end if
      do b = 1, model%blocks%n  ! several blocks may have this name
         if (model%block_names(b) /= name) cycle
         if (is_inside(model%blocks, b, point)) return
      end do
      b = number_of_block(group, 'block', model%block_names, name, error)
      if (allocated(error)) return
      if (.not. is_inside(model%blocks, b, point)) call fail_input(error, group, subject// &
         ' lies outside block '//quoted(name))
   end subroutine find_block

   !> Number of the first block with a name, or of a number given as text; 0 with an error if none.
   integer function number_of_block(group, variable, names, name, error) result(b)
      type(group_type), intent(in) :: group      !< group of the input
      character(len=*), intent(in) :: variable   !< name of the variable
      character(len=*), intent(in) :: names(:)   !< [n] names of the blocks
      character(len=*), intent(in) :: name     !< name or number of a block
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer :: status

      b = findloc(names == name, .true., 1)
      if (b > 0) return
      read (name, *, iostat=status) b
      if (status == 0 .and. verify(trim(name), '0123456789') == 0 .and. b >= 1 &
         .and. b <= size(names)) return
      call fail_input(error, group, variable//' = '//quoted(name)// &
         ' is not the name or number of a block')
      b = 0
   end function number_of_block

   !> First block that contains a point; 0 if there is none.
   pure integer function block_at(blocks, point) result(b)
      type(blocks_type), intent(in) :: blocks  !< blocks of the model
      real(wp), intent(in) :: point(2)  !< m

      do b = 1, blocks%n
         if (is_inside(blocks, b, point)) return
      end do
      b = 0
   end function block_at

   !> .true. if a point lies in a block.
   pure logical function is_inside(blocks, b, point)
      type(blocks_type), intent(in) :: blocks  !< blocks of the model
      integer, intent(in) :: b  !< number of the block
      real(wp), intent(in) :: point(2)  !< m

      is_inside = .false.
      if (norm2(point - blocks%position(1:2, b)) > (1.0_wp + on_boundary)*blocks%radius(b)) return
      is_inside = contains_point(blocks%vertex(:, blocks%first(b):blocks%first(b + 1) - 1), &
         point, on_boundary*blocks%radius(b))
   end function is_inside

   !> Read &fixed_point.
   subroutine read_fixed_point(group, model, new, error)
      type(group_type), intent(in) :: group  !< group of the input
      type(model_type), intent(in) :: model  !< model with its blocks
      type(fixed_point_type), intent(out) :: new  !< values of the group
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(fixed_point_values) :: input

      call read_values(group, input, error)
      new%name = input%name
      new%fixed_along = [index(input%direction, 'x') > 0, index(input%direction, 'y') > 0]
      call find_point(group, model, input%point, new%position, new%reference, new%block, error)
      call find_motions(group, [input%motion_x, input%motion_y], model%motions, new%motion, error)
      if (any(new%motion > 0 .and. .not. new%fixed_along)) call fail_input(error, group, &
         'a motion is given in a direction in which the point is not fixed')
   end subroutine read_fixed_point

   !> Find the position of a group in engine coordinates, and the block that contains it.
   subroutine find_point(group, model, point, position, reference, b, error)
      type(group_type), intent(in) :: group  !< group of the input
      type(model_type), intent(in) :: model  !< model with its blocks
      type(point_values), intent(in) :: point  !< values of the group
      real(wp), intent(out) :: position(2), reference(2)  !< m; offset from the block's centroid, m
      integer, intent(out) :: b          !< number of the block; 0 on failure
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      position = [point%x, point%y] - model%origin
      call find_block(group, model, point%block, position, b, error)
      reference = 0.0_wp
      if (b > 0) reference = reference_of(model%blocks, b, position)
   end subroutine find_point

   !> Find the motions along x and y that a group names.
   subroutine find_motions(group, names, motions, indices, error, stem)
      type(group_type), intent(in) :: group        !< group of the input
      character(len=*), intent(in) :: names(2)     !< names, or blank
      type(motion_type), intent(in) :: motions(:)  !< motions of the model
      integer, intent(inout) :: indices(2)           !< positions; unchanged without a name
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      character(len=*), intent(in), optional :: stem  !< stem of the variables; default: motion_
      character(len=:), allocatable :: variable
      integer :: i

      variable = 'motion_'
      if (present(stem)) variable = stem
      do i = 1, 2
         if (names(i) /= '') call require_name(error, group, variable//merge('x', 'y', i == 1), &
            names(i), motions%name, 'motion', indices(i))
      end do
   end subroutine find_motions

   !> Read &load.
   subroutine read_load(group, model, new, error)
      type(group_type), intent(in) :: group  !< group of the input
      type(model_type), intent(in) :: model  !< model with its blocks
      type(load_type), intent(out) :: new  !< values of the group
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(load_values) :: input
      real(wp) :: position(2)
      integer :: n

      call read_values(group, input, error)
      call find_point(group, model, input%point, position, new%reference, new%block, error)
      new%name = input%name
      new%time = input%time
      n = size(new%time)
      call check_times(error, group, new%time)
      if (any([size(input%force_x), size(input%force_y)] /= 0 .and. [size(input%force_x), &
         size(input%force_y)] /= n)) call fail_input(error, group, &
         'force_x and force_y must have as many values as `time` ('//to_text(n)//')')
      if (allocated(error)) return
      allocate (new%force(2, n), source=0.0_wp)
      new%force(1, :size(input%force_x)) = input%force_x
      new%force(2, :size(input%force_y)) = input%force_y
   end subroutine read_load

   !> Check the times of a load: at least two, not descending.
   subroutine check_times(error, group, time)
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(group_type), intent(in) :: group      !< group of the input
      real(wp), intent(in) :: time(:)            !< as given, s

      if (size(time) < 2) call fail_input(error, group, '`time` requires at least 2 values')
      if (any(time(2:) < time(:size(time) - 1))) call fail_input(error, group, &
         '`time` must not decrease')
   end subroutine check_times

   !> Set the times of a history; without times it has one value.
   subroutine set_times(error, group, given_times, time)
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(group_type), intent(in) :: group      !< group of the input
      real(wp), intent(in) :: given_times(:)     !< times of the input, s
      real(wp), allocatable, intent(out) :: time(:)  !< at least one, s

      time = given_times
      if (size(time) > 0) call check_times(error, group, time)
      if (size(time) == 0) time = [0.0_wp]
   end subroutine set_times

   !> Set the values of a variable at the times of a history; one value applies to all times.
   subroutine set_values(error, group, name, given_values, time, values)
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(group_type), intent(in) :: group      !< group of the input
      character(len=*), intent(in) :: name       !< name of the variable
      real(wp), intent(in) :: given_values(:), time(:)  !< of the input; times, s
      real(wp), allocatable, intent(out) :: values(:)   !< [times]

      values = given_values
      if (size(values) == 1) values = spread(values(1), 1, size(time))
      if (size(values) /= size(time)) call fail_input(error, group, name// &
         ' must have one value, or as many values as `time` ('//to_text(size(time))//')')
   end subroutine set_values

   !> Read &measured_point.
   subroutine read_point(group, model, new, error)
      type(group_type), intent(in) :: group  !< group of the input
      type(model_type), intent(in) :: model  !< model with its blocks
      type(point_type), intent(out) :: new  !< values of the group
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(measured_point_values) :: input

      call read_values(group, input, error)
      new%name = input%name
      call find_point(group, model, input%point, new%position, new%reference, new%block, error)
      if (input%point%block == '' .and. new%block > 0) new%other = other_container(model%blocks, &
         new%block, new%position)
   end subroutine read_point

   !> Next block of another body that contains a point; 0 if there is none.
   pure integer function other_container(blocks, first, point) result(b)
      type(blocks_type), intent(in) :: blocks  !< blocks of the model
      integer, intent(in) :: first             !< first block that contains the point
      real(wp), intent(in) :: point(2)         !< m

      do b = first + 1, blocks%n
         if (blocks%body(b) > 0 .and. blocks%body(b) == blocks%body(first)) cycle
         if (is_inside(blocks, b, point)) return
      end do
      b = 0
   end function other_container

   !> Read &amplification: the spectral ratio of two measured points.
   subroutine read_amplification(group, points, new, error)
      type(group_type), intent(in) :: group  !< group of the input
      type(point_type), intent(in) :: points(:)  !< measured points of the model
      type(amplification_type), intent(out) :: new  !< points, axis, band (Hz)
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(amplification_values) :: input

      call read_values(group, input, error)
      if (input%highest <= input%lowest) call fail_input(error, group, &
         '`highest` must be above `lowest`')
      if (allocated(error)) return
      new%lowest = input%lowest
      new%highest = input%highest
      new%padding = input%padding
      new%axis = index('xy', trim(input%direction))
      call require_name(error, group, 'surface', input%surface, points%name, 'measured_point', &
         new%surface)
      call require_name(error, group, 'base', input%base, points%name, 'measured_point', new%base)
   end subroutine read_amplification

   !> Read all measured joints of an input.
   subroutine read_measured_joints(model, groups, error)
      type(model_type), intent(inout) :: model   !< model with its blocks
      type(group_type), intent(in) :: groups(:)  !< groups of the input, in its order
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(measured_joint_type) :: new
      integer, allocatable :: joints(:)
      integer :: i

      allocate (model%measured_joints(0))
      joints = positions(groups, 'measured_joint')
      do i = 1, size(joints)
         associate (group => groups(joints(i)))
            call read_measured_joint(group, model%block_names, new, error)
            if (allocated(error)) return
            call require_new_name(error, group, new%name, model%measured_joints%name)
         end associate
         model%measured_joints = [model%measured_joints, new]
      end do
   end subroutine read_measured_joints

   !> Read one group; default of `against` are all other blocks.
   subroutine read_measured_joint(group, names, new, error)
      type(group_type), intent(in) :: group    !< group of the input
      character(len=*), intent(in) :: names(:) !< [n] names of the blocks
      type(measured_joint_type), intent(out) :: new          !< values of the group
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(measured_joint_values) :: input
      logical :: side_a(size(names)), side_b(size(names))

      side_a = .false.
      side_b = .false.
      call read_values(group, input, error)
      if (allocated(error)) return
      new%name = input%name
      call mark_names(input%blocks, 'blocks', names, group, side_a, error)
      call mark_names(input%against, 'against', names, group, side_b, error)
      if (input%against == '') side_b = .not. side_a
      if (any(side_a .and. side_b)) call fail_input(error, group, 'block '//quoted(trim( &
         names(findloc(side_a .and. side_b, .true., 1))))//' is in both `blocks` and `against`')
      if (.not. any(side_b)) call fail_input(error, group, &
         '`blocks` selects all blocks, so none remains for `against`')
      new%side = merge(1, merge(2, 0, side_b), side_a)
   end subroutine read_measured_joint

end module dda_input_points
