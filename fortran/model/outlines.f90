!> Polygons being gathered, one by one or by generators, before they become blocks.
module dda_outlines
   use dda_kinds, only: wp
   implicit none
   private
   public :: outlines_type, add_outline, add_layers, add_drums, add_wall

   !> A growing list of polygons with what they are made of.
   type :: outlines_type
      integer :: n = 0
      integer :: n_vertices = 0
      integer, allocatable :: first(:)             !< [n+1]
      real(wp), allocatable :: vertices(:,:)       !< [2, any] counter-clockwise, m
      integer, allocatable :: material(:), joint(:)
      integer, allocatable :: source(:)            !< which input group each came from
      character(len=64), allocatable :: name(:)
   end type outlines_type

contains

   !> Append one polygon.
   subroutine add_outline(outlines, vertices, material, joint, source, name)
      type(outlines_type), intent(inout) :: outlines
      real(wp), intent(in) :: vertices(:,:)
      integer, intent(in) :: material, joint, source
      character(len=*), intent(in) :: name
      integer :: m

      m = size(vertices, 2)
      call make_room(outlines, m)
      outlines%vertices(:, outlines%n_vertices + 1:outlines%n_vertices + m) = vertices
      outlines%n = outlines%n + 1
      outlines%n_vertices = outlines%n_vertices + m
      outlines%first(outlines%n + 1) = outlines%n_vertices + 1
      outlines%material(outlines%n) = material
      outlines%joint(outlines%n) = joint
      outlines%source(outlines%n) = source
      outlines%name(outlines%n) = name
   end subroutine add_outline

   subroutine make_room(outlines, more)
      type(outlines_type), intent(inout) :: outlines
      integer, intent(in) :: more
      real(wp), allocatable :: larger(:,:)
      integer :: room

      if (.not. allocated(outlines%first)) then
         allocate (outlines%first(17), outlines%material(16), outlines%joint(16), &
            outlines%source(16), outlines%name(16))
         allocate (outlines%vertices(2, 64))
         outlines%first(1) = 1
      end if
      room = size(outlines%material)
      if (outlines%n == room) then
         outlines%first = [outlines%first, spread(0, 1, room)]
         outlines%material = [outlines%material, spread(0, 1, room)]
         outlines%joint = [outlines%joint, spread(0, 1, room)]
         outlines%source = [outlines%source, spread(0, 1, room)]
         outlines%name = [outlines%name, spread(outlines%name(1), 1, room)]
      end if
      if (outlines%n_vertices + more > size(outlines%vertices, 2)) then
         allocate (larger(2, 2*size(outlines%vertices, 2) + more))
         larger(:, :outlines%n_vertices) = outlines%vertices(:, :outlines%n_vertices)
         call move_alloc(larger, outlines%vertices)
      end if
   end subroutine make_room

   !> Rectangle from its lower left and upper right corner.
   pure function rectangle(left, bottom, right, top) result(vertices)
      real(wp), intent(in) :: left, bottom, right, top
      real(wp) :: vertices(2, 4)

      vertices = reshape([left, bottom, right, bottom, right, top, left, top], [2, 4])
   end function rectangle

   !> `count` equal layers stacked upwards.
   subroutine add_layers(outlines, left, bottom, width, thickness, count, material, joint, source, &
      name)
      type(outlines_type), intent(inout) :: outlines
      real(wp), intent(in) :: left, bottom, width, thickness
      integer, intent(in) :: count, material, joint, source
      character(len=*), intent(in) :: name
      integer :: i

      do i = 1, count
         call add_outline(outlines, rectangle(left, bottom + (i - 1)*thickness, left + width, &
            bottom + i*thickness), material, joint, source, numbered(name, i))
      end do
   end subroutine add_layers

   !> `count` drums of a column, upwards, tapering evenly from one width to the other.
   subroutine add_drums(outlines, centre, bottom, height, widths, count, material, joint, source, &
      name)
      type(outlines_type), intent(inout) :: outlines
      real(wp), intent(in) :: centre, bottom, height
      real(wp), intent(in) :: widths(2)     !< at the foot and at the top of the column, m
      integer, intent(in) :: count, material, joint, source
      character(len=*), intent(in) :: name
      real(wp) :: low, high, foot, head
      integer :: i

      do i = 1, count
         low = bottom + (i - 1)*height
         high = bottom + i*height
         foot = 0.5_wp*(widths(1) + (widths(2) - widths(1))*(i - 1)/count)
         head = 0.5_wp*(widths(1) + (widths(2) - widths(1))*i/count)
         call add_outline(outlines, reshape([centre - foot, low, centre + foot, low, &
            centre + head, high, centre - head, high], [2, 4]), material, joint, source, &
            numbered(name, i))
      end do
   end subroutine add_drums

   !> A running-bond wall: every other course begins and ends with half a brick.
   subroutine add_wall(outlines, left, bottom, brick, bricks, courses, material, joint, source, &
      name)
      type(outlines_type), intent(inout) :: outlines
      real(wp), intent(in) :: left, bottom
      real(wp), intent(in) :: brick(2)           !< length and height, m
      integer, intent(in) :: bricks, courses     !< bricks in a full course
      integer, intent(in) :: material, joint, source
      character(len=*), intent(in) :: name
      real(wp) :: from, to, low
      integer :: course, i, k

      k = 0
      do course = 1, courses
         low = bottom + (course - 1)*brick(2)
         do i = 1, bricks + merge(0, 1, modulo(course, 2) == 1)
            from = left + (i - 1)*brick(1)
            if (modulo(course, 2) == 0) from = max(left, from - 0.5_wp*brick(1))
            to = left + i*brick(1)
            if (modulo(course, 2) == 0) to = min(left + bricks*brick(1), to - 0.5_wp*brick(1))
            k = k + 1
            call add_outline(outlines, rectangle(from, low, to, bottom + course*brick(2)), &
               material, joint, source, numbered(name, k))
         end do
      end do
   end subroutine add_wall

   !> 'name_i', or nothing for a nameless generator.
   pure function numbered(name, i) result(full)
      character(len=*), intent(in) :: name
      integer, intent(in) :: i
      character(len=64) :: full

      full = ''
      if (name /= '') write (full, '(a,"_",i0)') trim(name), i
   end function numbered

end module dda_outlines
