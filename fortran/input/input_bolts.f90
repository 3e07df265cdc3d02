! SPDX-License-Identifier: GPL-3.0-or-later
!> Groups &bolt: bolts and cables between two anchors, which may have further points or be grouted
!> through joints.
module dda_input_bolts
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type, reference_of
   use dda_bolt, only: bolt_type, across, never
   use dda_errors, only: error_type
   use dda_input_group, only: group_type, fail_input, is_set, positions, &
      require_new_name, value_or, name_length
   use dda_input_groups, only: bolt_values, read_values
   use dda_input_points, only: block_at, find_block
   use dda_model, only: model_type
   use dda_text, only: quoted, to_text
   implicit none
   private
   public :: read_bolts

contains

   !> Read all bolts of an input.
   subroutine read_bolts(model, groups, error)
      type(model_type), intent(inout) :: model  !< model with its blocks
      type(group_type), intent(in) :: groups(:)  !< groups of the input, in its order
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(bolt_values) :: input
      type(bolt_type), allocatable :: new(:)
      integer, allocatable :: bolts(:)
      integer :: i

      if (allocated(error)) return
      allocate (model%bolts(0))
      bolts = positions(groups, 'bolt')
      do i = 1, size(bolts)
         associate (group => groups(bolts(i)))
            call read_values(group, input, error)
            call require_new_name(error, group, input%name, model%bolts%name)
            call check_values(input, group, error)
            if (.not. allocated(error)) call make_bolt(model, group, input, new, error)
            if (allocated(error)) return
         end associate
         model%bolts = [model%bolts, new]
      end do
   end subroutine read_bolts

   !> Check values that depend on each other.
   subroutine check_values(input, group, error)
      type(bolt_values), intent(in) :: input  !< values of the group
      type(group_type), intent(in) :: group  !< group of the input
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      associate (n => size(input%through, 2))
         if (any(input%through_block(n + 1:) /= '')) call fail_input(error, group, &
            '`through_block` names more blocks than `through` has points ('//to_text(n)//')')
      end associate
      if (is_set(input%yield_force) .and. input%pretension &
         > input%yield_force) call fail_input(error, group, 'pretension = '// &
         to_text(input%pretension)//' is above yield_force = '//to_text(input%yield_force))
   end subroutine check_values

   !> Create the springs of a bolt: one between its ends, or a pair at each joint that it crosses.
   subroutine make_bolt(model, group, input, new, error)
      type(model_type), intent(in) :: model  !< model with its blocks
      type(group_type), intent(in) :: group  !< group of the input
      type(bolt_values), intent(in) :: input  !< values of the group
      type(bolt_type), allocatable, intent(out) :: new(:)  !< springs of the bolt
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(bolt_type) :: bolt
      real(wp) :: point(2, size(input%through, 2) + 2)
      character(len=name_length) :: names(size(point, 2))
      integer :: owner(size(point, 2)), k

      point = reshape([input%from, input%through, input%to], shape(point)) &
         - spread(model%origin, 2, size(point, 2))
      names(1) = input%from_block
      names(2:) = ''
      k = min(size(input%through_block), size(names) - 2)
      names(2:k + 1) = input%through_block(:k)
      names(size(names)) = input%to_block
      do k = 1, size(owner)
         call find_block(group, model, names(k), point(:, k), owner(k), error)
      end do
      call check_points(model, group, point, owner, error)
      if (allocated(error)) return
      bolt%name = input%name
      bolt%grouted = input%grouted
      bolt%compression = input%compression
      bolt%pretension = input%pretension
      bolt%direction = (point(:, 2) - point(:, 1))/norm2(point(:, 2) - point(:, 1))
      bolt%stiffness = [input%axial_stiffness, input%shear_stiffness]
      if (bolt%grouted .and. bolt%stiffness(across) <= 0.0_wp) bolt%stiffness(across) = tiny(1.0_wp)
      bolt%yield = value_or([input%yield_force, input%shear_yield_force], never)
      bolt%rupture = value_or([input%rupture_elongation, input%rupture_slip], never)
      if (bolt%grouted) then
         call grout_crossings(model%blocks, group, bolt, point(:, 1), point(:, 2), owner, new, &
            error)
      else
         new = [spring_between(model%blocks, bolt, owner, point)]
      end if
   end subroutine make_bolt

   !> Check that the points of a bolt are at different positions and not all in one block.
   subroutine check_points(model, group, point, owner, error)
      type(model_type), intent(in) :: model  !< model with its blocks
      type(group_type), intent(in) :: group  !< group of the input
      real(wp), intent(in) :: point(:,:)  !< [2,points] m, in the coordinates of the engine
      integer, intent(in) :: owner(:)     !< [points] block of each point
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer :: k

      if (allocated(error)) return
      if (all(owner == owner(1))) call fail_input(error, group, 'all points of the bolt are in '// &
         'the same block, '//quoted(trim(model%block_names(owner(1)))))
      do k = 1, size(owner) - 1
         if (norm2(point(:, k + 1) - point(:, k)) > 0.0_wp) cycle
         call fail_input(error, group, 'two successive points of the bolt are at the same '// &
            'position, ('//to_text(point(:, k) + model%origin)//')')
      end do
   end subroutine check_points

   !> Create a spring between positions in blocks.
   pure type(bolt_type) function spring_between(blocks, bolt, owner, positions) result(spring)
      type(blocks_type), intent(in) :: blocks  !< blocks of the model
      type(bolt_type), intent(in) :: bolt  !< law of the bolt
      integer, intent(in) :: owner(:)  !< [points] block of each point
      real(wp), intent(in) :: positions(:,:)  !< [2,points] m
      integer :: k

      spring = bolt
      spring%block = owner
      spring%position = positions
      allocate (spring%reference, mold=positions)
      do k = 1, size(owner)
         spring%reference(:, k) = reference_of(blocks, owner(k), positions(:, k))
      end do
   end function spring_between

   !> Add a pair of springs at each crossing of a straight bolt from one block to the next.
   subroutine grout_crossings(blocks, group, bolt, from, to, ends, new, error)
      type(blocks_type), intent(in) :: blocks  !< blocks of the model
      type(group_type), intent(in) :: group  !< group of the input
      type(bolt_type), intent(in) :: bolt  !< law of the bolt
      real(wp), intent(in) :: from(2), to(2)  !< ends of the bolt, m
      integer, intent(in) :: ends(2)  !< blocks that contain the ends
      type(bolt_type), allocatable, intent(out) :: new(:)  !< springs of the bolt
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      real(wp), allocatable :: crossings(:)
      real(wp) :: at
      integer :: k, b, last

      allocate (new(0))
      call find_cuts(blocks, from, to, crossings)
      last = ends(1)
      at = 0.0_wp
      do k = 1, size(crossings)
         b = ends(2)
         if (k < size(crossings)) b = block_at(blocks, from + 0.5_wp*(crossings(k) + crossings(k + &
            1))*(to - from))
         if (b == 0 .or. b == last) cycle
         at = crossings(k)
         new = [new, spring_between(blocks, bolt, [last, b], spread(from + at*(to - from), 2, 2))]
         last = b
      end do
      if (size(new) == 0) call fail_input(error, group, 'the bolt crosses no joint')
   end subroutine grout_crossings

   !> Find crossings of a segment with edges, as ascending fractions of its length.
   pure subroutine find_cuts(blocks, from, to, crossings)
      type(blocks_type), intent(in) :: blocks  !< blocks of the model
      real(wp), intent(in) :: from(2), to(2)  !< ends of the bolt, m
      real(wp), allocatable, intent(out) :: crossings(:)  !< fractions, 0 … 1
      real(wp) :: edge(2), direction(2), offset(2), determinant, s, t
      integer :: v, k

      allocate (crossings(0))
      direction = to - from
      do v = 1, size(blocks%owner)
         edge = blocks%vertex(:, blocks%next(v)) - blocks%vertex(:, v)
         offset = blocks%vertex(:, v) - from
         determinant = direction(1)*edge(2) - direction(2)*edge(1)
         if (abs(determinant) <= epsilon(1.0_wp)*norm2(direction)*norm2(edge)) cycle
         s = (offset(1)*edge(2) - offset(2)*edge(1))/determinant
         t = (offset(1)*direction(2) - offset(2)*direction(1))/determinant
         if (s <= 0.0_wp .or. s >= 1.0_wp .or. t < 0.0_wp .or. t > 1.0_wp) cycle
         k = count(crossings <= s)
         crossings = [crossings(:k), s, crossings(k + 1:)]
      end do
   end subroutine find_cuts

end module dda_input_bolts
