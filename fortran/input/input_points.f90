! SPDX-License-Identifier: GPL-3.0-or-later
!> The groups that stand at a material point: &fixed_point, &load, &measured_point,
!> and &amplification, between two of these.
module dda_input_points
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type, reference_of
   use dda_errors, only: error_type
   use dda_input_group, only: place_type, input_error, check_read, require, require_list, &
      require_choice, require_name, unset, is_set, name_length
   use dda_motion, only: motion_type
   use dda_polygon, only: contains_point
   use dda_settings, only: amplification_type
   use dda_support, only: fixed_point_type, load_type, point_type
   use dda_text, only: quoted, to_text
   implicit none
   private
   public :: read_fixed_point, read_load, read_point, read_amplification, find_block, holds

   integer, parameter :: most_times = 4096
   real(wp), parameter :: on_boundary = 1.0e-9_wp  !< of the block's size: still inside

contains

   !> The block that holds a point: the named one, else the first that does.
   subroutine find_block(place, blocks, names, origin, wanted, x, y, b, error)
      type(place_type), intent(in) :: place  !< of the group
      type(blocks_type), intent(in) :: blocks  !< of the model
      character(len=*), intent(in) :: names(:)   !< [n] of the blocks
      real(wp), intent(in) :: origin(2)          !< of the engine's coordinates, for messages
      character(len=*), intent(in) :: wanted     !< name or number of a block, or blank
      real(wp), intent(in) :: x, y  !< m
      integer, intent(out) :: b  !< its number; 0 on failure
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      character(len=:), allocatable :: point
      integer :: status

      b = 0
      call require(error, place, 'x y', [x, y])
      if (allocated(error)) return
      point = 'the point ('//to_text(x + origin(1))//', '//to_text(y + origin(2))//')'
      if (wanted == '') then
         do b = 1, blocks%n
            if (holds(blocks, b, [x, y])) return
         end do
         call input_error(error, place, point//' lies outside every block')
         return
      end if
      do b = 1, blocks%n  ! of several blocks of that name, the one that holds the point
         if (names(b) /= wanted) cycle
         if (holds(blocks, b, [x, y])) return
      end do
      b = findloc(names == wanted, .true., 1)
      if (b == 0) then
         read (wanted, *, iostat=status) b
         if (status /= 0 .or. verify(trim(wanted), '0123456789') > 0 .or. b < 1 &
            .or. b > blocks%n) then
            call input_error(error, place, 'block = '//quoted(wanted)// &
               ' is not the name or number of a block')
            return
         end if
      end if
      if (.not. holds(blocks, b, [x, y])) call input_error(error, place, point// &
         ' lies outside block '//quoted(wanted))
   end subroutine find_block

   !> Whether a block holds a point.
   pure logical function holds(blocks, b, point)
      type(blocks_type), intent(in) :: blocks  !< of the model
      integer, intent(in) :: b  !< number of the block
      real(wp), intent(in) :: point(2)  !< m

      holds = .false.
      if (norm2(point - blocks%position(1:2, b)) > (1.0_wp + on_boundary)*blocks%radius(b)) return
      holds = contains_point(blocks%vertex(:, blocks%first(b):blocks%first(b + 1) - 1), point, &
         on_boundary*blocks%radius(b))
   end function holds

   !> &fixed_point
   subroutine read_fixed_point(group, place, blocks, names, origin, motions, new, error)
      character(len=*), intent(in) :: group  !< its text, on one line
      type(place_type), intent(in) :: place  !< of the group
      type(blocks_type), intent(in) :: blocks  !< of the model
      character(len=*), intent(in) :: names(:)  !< [n] of the blocks
      real(wp), intent(in) :: origin(2)  !< m, of the engine's coordinates
      type(motion_type), intent(in) :: motions(:)  !< of the model
      type(fixed_point_type), intent(out) :: new  !< as the group says
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      real(wp) :: x, y
      character(len=name_length) :: block, direction, motion_x, motion_y, name
      character(len=256) :: message
      integer :: status
      namelist /fixed_point/ x, y, block, direction, motion_x, motion_y, name

      x = unset
      y = unset
      block = ''
      direction = 'xy'
      motion_x = ''
      motion_y = ''
      name = ''
      read (group, nml=fixed_point, iostat=status, iomsg=message)
      call check_read(error, place, status, message)
      call to_model_origin(x, y, origin)
      call find_block(place, blocks, names, origin, block, x, y, new%block, error)
      call require_choice(error, place, 'direction', direction)
      if (allocated(error)) return
      new%held = [index(direction, 'x') > 0, index(direction, 'y') > 0]
      new%name = name
      new%place = [x, y]
      new%reference = reference_of(blocks, new%block, new%place)
      if (motion_x /= '') call require_name(error, place, 'motion_x', motion_x, motions%name, &
         'motion', new%motion(1))
      if (motion_y /= '') call require_name(error, place, 'motion_y', motion_y, motions%name, &
         'motion', new%motion(2))
      if (any(new%motion > 0 .and. .not. new%held)) call input_error(error, place, &
         'a motion is given in a direction that the point is not held in')
   end subroutine read_fixed_point

   !> From coordinates of the input to those of the engine.
   pure subroutine to_model_origin(x, y, origin)
      real(wp), intent(inout) :: x, y  !< m, or `unset`
      real(wp), intent(in) :: origin(2)  !< m, of the engine's coordinates

      if (is_set(x)) x = x - origin(1)
      if (is_set(y)) y = y - origin(2)
   end subroutine to_model_origin

   !> &load
   subroutine read_load(group, place, blocks, names, origin, new, error)
      character(len=*), intent(in) :: group  !< its text, on one line
      type(place_type), intent(in) :: place  !< of the group
      type(blocks_type), intent(in) :: blocks  !< of the model
      character(len=*), intent(in) :: names(:)  !< [n] of the blocks
      real(wp), intent(in) :: origin(2)  !< m, of the engine's coordinates
      type(load_type), intent(out) :: new  !< as the group says
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      real(wp) :: x, y, time(most_times), force_x(most_times), force_y(most_times)
      character(len=name_length) :: block, name
      character(len=256) :: message
      integer :: status, n
      namelist /load/ x, y, block, name, time, force_x, force_y

      x = unset
      y = unset
      block = ''
      name = ''
      time = unset
      force_x = unset
      force_y = unset
      read (group, nml=load, iostat=status, iomsg=message)
      call check_read(error, place, status, message)
      call to_model_origin(x, y, origin)
      call find_block(place, blocks, names, origin, block, x, y, new%block, error)
      n = count(is_set(time))
      if (n < 2) call input_error(error, place, 'time: at least 2 values are needed')
      if (.not. any(is_set(force_x))) force_x(:n) = 0.0_wp
      if (.not. any(is_set(force_y))) force_y(:n) = 0.0_wp
      call require_list(error, place, 'time', time(:n))
      call require_list(error, place, 'force_x', force_x(:n))
      call require_list(error, place, 'force_y', force_y(:n))
      if (count(is_set(force_x)) /= n .or. count(is_set(force_y)) /= n) &
         call input_error(error, place, 'force_x and force_y must have as many values as time ('// &
         to_text(n)//')')
      if (any(time(2:n) < time(:n - 1))) call input_error(error, place, 'time must not decrease')
      if (allocated(error)) return
      new%reference = reference_of(blocks, new%block, [x, y])
      new%name = name
      new%time = time(:n)
      new%force = transpose(reshape([force_x(:n), force_y(:n)], [n, 2]))
   end subroutine read_load

   !> &measured_point
   subroutine read_point(group, place, blocks, names, origin, new, error)
      character(len=*), intent(in) :: group  !< its text, on one line
      type(place_type), intent(in) :: place  !< of the group
      type(blocks_type), intent(in) :: blocks  !< of the model
      character(len=*), intent(in) :: names(:)  !< [n] of the blocks
      real(wp), intent(in) :: origin(2)  !< m, of the engine's coordinates
      type(point_type), intent(out) :: new  !< as the group says
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      real(wp) :: x, y
      character(len=name_length) :: name, block
      character(len=256) :: message
      integer :: status
      namelist /measured_point/ name, x, y, block

      name = ''
      x = unset
      y = unset
      block = ''
      read (group, nml=measured_point, iostat=status, iomsg=message)
      call check_read(error, place, status, message)
      call to_model_origin(x, y, origin)
      call find_block(place, blocks, names, origin, block, x, y, new%block, error)
      if (name == '') call input_error(error, place, 'name is missing')
      if (allocated(error)) return
      new%name = name
      new%place = [x, y]
      new%reference = reference_of(blocks, new%block, new%place)
   end subroutine read_point

   !> &amplification: the spectral ratio of two measured points.
   subroutine read_amplification(group, place, points, new, error)
      character(len=*), intent(in) :: group  !< its text, on one line
      type(place_type), intent(in) :: place  !< of the group
      type(point_type), intent(in) :: points(:)  !< measured points of the model
      type(amplification_type), intent(out) :: new  !< points, axis, band (Hz)
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      character(len=name_length) :: surface, base, direction
      real(wp) :: lowest, highest
      integer :: padding, status
      character(len=256) :: message
      namelist /amplification/ surface, base, direction, lowest, highest, padding

      surface = 'surface'
      base = 'base'
      direction = 'x'
      lowest = unset
      highest = unset
      padding = new%padding
      read (group, nml=amplification, iostat=status, iomsg=message)
      call check_read(error, place, status, message)
      call require(error, place, 'lowest highest padding', [lowest, highest, real(padding, wp)])
      call require_choice(error, place, 'direction', direction)
      if (highest <= lowest) call input_error(error, place, 'highest must be above lowest')
      if (allocated(error)) return
      call require_name(error, place, 'surface', surface, points%name, 'measured_point', &
         new%surface)
      call require_name(error, place, 'base', base, points%name, 'measured_point', new%base)
      new%axis = index('xy', trim(direction))
      new%lowest = lowest
      new%highest = highest
      new%padding = padding
   end subroutine read_amplification

end module dda_input_points
