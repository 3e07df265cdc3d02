! SPDX-License-Identifier: GPL-3.0-or-later
!> The groups &bolt: bolts and cables between two anchors, past further points or not, or grouted
!> through joints.
module dda_input_bolts
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type, reference_of
   use dda_bolt, only: bolt_type, axial, across, never
   use dda_errors, only: error_type
   use dda_input_group, only: group_type, input_error, get, get_list, value_or, unset, is_set, &
      name_length
   use dda_input_points, only: find_block, holds
   use dda_model, only: model_type
   use dda_text, only: quoted, to_text
   implicit none
   private
   public :: read_bolts

   !> A group as read.
   type :: reading_type
      character(len=name_length) :: name = ''
      character(len=name_length), allocatable :: blocks(:)  !< [points] that they are in, or blank
      real(wp), allocatable :: point(:,:)                   !< [2,points] m
      real(wp) :: axial_stiffness = unset, shear_stiffness = unset, pretension = 0.0_wp
      real(wp) :: yield_force = unset, shear_yield_force = unset
      real(wp) :: rupture_elongation = unset, rupture_slip = unset
      logical :: grouted = .false., compression = .false.
   end type reading_type

contains

   !> All bolts of an input.
   subroutine read_bolts(model, groups, error)
      type(model_type), intent(inout) :: model  !< with its blocks
      type(group_type), intent(in) :: groups(:)  !< of the input, in its order
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(reading_type) :: reading
      type(bolt_type), allocatable :: new(:)
      integer :: i

      if (allocated(error)) return
      allocate (model%bolts(0))
      do i = 1, size(groups)
         if (groups(i)%name /= 'bolt') cycle
         call read_bolt(groups(i), reading, error)
         if (any(model%bolts%name == reading%name)) call input_error(error, groups(i), 'name = '// &
            quoted(trim(reading%name))//' is used twice')
         call check_values(reading, groups(i), error)
         if (.not. allocated(error)) call make_bolt(model, groups(i), reading, new, error)
         if (allocated(error)) return
         model%bolts = [model%bolts, new]
      end do
   end subroutine read_bolts

   !> The variables of a group.
   subroutine read_bolt(group, reading, error)
      type(group_type), intent(in) :: group  !< of the input
      type(reading_type), intent(out) :: reading  !< as read
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      character(len=name_length), allocatable :: blocks(:)
      character(len=name_length) :: ends(2)
      real(wp), allocatable :: from(:), to(:), through(:)
      integer :: n

      ends = ''
      call get(group, 'name', reading%name, error)
      call get_list(group, 'from', from, error)
      call get_list(group, 'through', through, error)
      call get_list(group, 'to', to, error)
      call get(group, 'from_block', ends(1), error)
      call get(group, 'to_block', ends(2), error)
      call get_list(group, 'through_block', blocks, error)
      n = (size(through) + 1)/2
      if (2*n /= size(through) .or. size(from) + size(to) < 4) call input_error(error, group, &
         trim(merge('through', merge('from   ', 'to     ', size(from) < 2), &
         2*n /= size(through)))//': a value is left out')
      if (any(blocks(n + 1:) /= '')) call input_error(error, group, &
         'through_block names more blocks than through has points ('//to_text(n)//')')
      if (allocated(error)) return
      allocate (reading%blocks(n + 2))
      reading%blocks = ''
      reading%blocks(1) = ends(1)
      reading%blocks(2:min(n, size(blocks)) + 1) = blocks(:min(n, size(blocks)))
      reading%blocks(n + 2) = ends(2)
      reading%point = reshape([from, through, to], [2, n + 2])
      call get(group, 'grouted', reading%grouted)
      call get(group, 'compression', reading%compression)
      call get(group, 'axial_stiffness', reading%axial_stiffness, error)
      call get(group, 'pretension', reading%pretension, error)
      call get(group, 'shear_stiffness', reading%shear_stiffness, error)
      call get(group, 'yield_force', reading%yield_force, error)
      call get(group, 'shear_yield_force', reading%shear_yield_force, error)
      call get(group, 'rupture_elongation', reading%rupture_elongation, error)
      call get(group, 'rupture_slip', reading%rupture_slip, error)
   end subroutine read_bolt

   !> What only a grouted bolt has must not be given of another.
   subroutine check_values(reading, group, error)
      type(reading_type), intent(in) :: reading  !< as read
      type(group_type), intent(in) :: group  !< of the input
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays

      if (allocated(error)) return
      if (size(reading%blocks) > 2 .and. (reading%grouted .or. reading%compression)) &
         call input_error(error, group, &
         'a cable through points is not grouted and takes no compression')
      if (allocated(error)) return
      if (.not. reading%grouted .and. any(is_set([reading%shear_stiffness, &
         reading%shear_yield_force, reading%rupture_slip]))) call input_error(error, group, &
         'shear_stiffness, shear_yield_force and rupture_slip are those of a bolt with '// &
         'grouted = .true.')
      if (is_set(reading%yield_force) .and. reading%pretension > reading%yield_force) &
         call input_error(error, group, 'pretension = '//to_text(reading%pretension)// &
         ' is above yield_force = '//to_text(reading%yield_force))
   end subroutine check_values

   !> The springs of a bolt: one between its ends, or one at each joint that it crosses.
   subroutine make_bolt(model, group, reading, new, error)
      type(model_type), intent(in) :: model  !< with its blocks
      type(group_type), intent(in) :: group  !< of the input
      type(reading_type), intent(in) :: reading  !< as read
      type(bolt_type), allocatable, intent(out) :: new(:)  !< the springs
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(bolt_type) :: bolt
      real(wp), allocatable :: point(:,:)
      integer :: owner(size(reading%blocks)), k

      allocate (point, mold=reading%point)
      do k = 1, size(owner)
         point(:, k) = reading%point(:, k) - model%origin
         call find_block(group, model%blocks, model%block_names, model%origin, reading%blocks(k), &
            point(:, k), owner(k), error)
      end do
      call check_points(model, group, point, owner, error)
      if (allocated(error)) return
      bolt%name = reading%name
      bolt%grouted = reading%grouted
      bolt%compression = reading%compression
      bolt%pretension = reading%pretension
      bolt%direction = (point(:, 2) - point(:, 1))/norm2(point(:, 2) - point(:, 1))
      bolt%stiffness = [reading%axial_stiffness, value_or(reading%shear_stiffness, 0.0_wp)]
      if (bolt%grouted .and. bolt%stiffness(across) <= 0.0_wp) bolt%stiffness(across) = &
         tiny(1.0_wp)
      bolt%yield = value_or([reading%yield_force, reading%shear_yield_force], never)
      bolt%rupture = value_or([reading%rupture_elongation, reading%rupture_slip], never)
      if (reading%grouted) then
         call grout(model%blocks, group, bolt, point(:, 1), point(:, 2), owner, new, error)
      else
         new = [placed(model%blocks, bolt, owner, point)]
      end if
   end subroutine make_bolt

   !> The points of a bolt are apart, and not all in one block.
   subroutine check_points(model, group, point, owner, error)
      type(model_type), intent(in) :: model  !< with its blocks
      type(group_type), intent(in) :: group  !< of the group
      real(wp), intent(in) :: point(:,:)  !< [2,points] m, in the coordinates of the engine
      integer, intent(in) :: owner(:)     !< [points] block of each
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      integer :: k

      if (allocated(error)) return
      if (all(owner == owner(1))) call input_error(error, group, &
         'all points of the bolt are in the same block, '// &
         quoted(trim(model%block_names(owner(1)))))
      do k = 1, size(owner) - 1
         if (norm2(point(:, k + 1) - point(:, k)) > 0.0_wp) cycle
         call input_error(error, group, 'two points of the bolt that follow each other are at '// &
            'the same place, ('//to_text(point(1, k) + model%origin(1))//', '// &
            to_text(point(2, k) + model%origin(2))//')')
      end do
   end subroutine check_points

   !> A spring between places of blocks.
   pure type(bolt_type) function placed(blocks, bolt, owner, places) result(spring)
      type(blocks_type), intent(in) :: blocks  !< of the model
      type(bolt_type), intent(in) :: bolt  !< its law
      integer, intent(in) :: owner(:)  !< [points] block of each
      real(wp), intent(in) :: places(:,:)  !< [2,points] m
      integer :: k

      spring = bolt
      spring%block = owner
      spring%place = places
      allocate (spring%reference, mold=places)
      do k = 1, size(owner)
         spring%reference(:, k) = reference_of(blocks, owner(k), places(:, k))
      end do
   end function placed

   !> A pair of springs where a straight bolt passes from one block to the next.
   subroutine grout(blocks, group, bolt, from, to, ends, new, error)
      type(blocks_type), intent(in) :: blocks  !< of the model
      type(group_type), intent(in) :: group  !< of the input
      type(bolt_type), intent(in) :: bolt  !< its law
      real(wp), intent(in) :: from(2), to(2)  !< ends, m
      integer, intent(in) :: ends(2)  !< blocks that they are in
      type(bolt_type), allocatable, intent(out) :: new(:)  !< the springs
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      real(wp), allocatable :: cut(:)
      real(wp) :: at
      integer :: k, b, last

      allocate (new(0))
      call find_cuts(blocks, from, to, cut)
      last = ends(1)
      at = 0.0_wp
      do k = 1, size(cut)
         b = ends(2)
         if (k < size(cut)) b = block_at(blocks, from + 0.5_wp*(cut(k) + cut(k + 1))*(to - from))
         if (b == 0 .or. b == last) cycle
         at = cut(k)
         new = [new, placed(blocks, bolt, [last, b], spread(from + at*(to - from), 2, 2))]
         last = b
      end do
      if (size(new) == 0) call input_error(error, group, 'the bolt crosses no joint')
   end subroutine grout

   !> Where a segment meets edges, as shares of its length in ascending order.
   pure subroutine find_cuts(blocks, from, to, cut)
      type(blocks_type), intent(in) :: blocks  !< of the model
      real(wp), intent(in) :: from(2), to(2)  !< ends, m
      real(wp), allocatable, intent(out) :: cut(:)  !< 0 … 1
      real(wp) :: edge(2), along(2), apart(2), determinant, s, t
      integer :: v, k

      allocate (cut(0))
      along = to - from
      do v = 1, size(blocks%owner)
         edge = blocks%vertex(:, blocks%next(v)) - blocks%vertex(:, v)
         apart = blocks%vertex(:, v) - from
         determinant = along(1)*edge(2) - along(2)*edge(1)
         if (abs(determinant) <= epsilon(1.0_wp)*norm2(along)*norm2(edge)) cycle
         s = (apart(1)*edge(2) - apart(2)*edge(1))/determinant
         t = (apart(1)*along(2) - apart(2)*along(1))/determinant
         if (s <= 0.0_wp .or. s >= 1.0_wp .or. t < 0.0_wp .or. t > 1.0_wp) cycle
         k = count(cut <= s)
         cut = [cut(:k), s, cut(k + 1:)]
      end do
   end subroutine find_cuts

   !> The first block that holds a point; 0 if none does.
   pure integer function block_at(blocks, point) result(b)
      type(blocks_type), intent(in) :: blocks  !< of the model
      real(wp), intent(in) :: point(2)  !< m

      do b = 1, blocks%n
         if (holds(blocks, b, point)) return
      end do
      b = 0
   end function block_at

end module dda_input_bolts
