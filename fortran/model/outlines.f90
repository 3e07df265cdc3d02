! SPDX-License-Identifier: GPL-3.0-or-later
!> Polygons of an input, single or generated, from which blocks are created.
module dda_outlines
   use dda_growth, only: grow
   use dda_kinds, only: wp
   use dda_polygon, only: area_of, is_simple
   implicit none
   private
   public :: outlines_type, add_outline, add_layers, add_drums, add_wall, set_cover, &
      most_blocks, max_vertices, outline_failure

   real(wp), parameter :: most_blocks = 2.0e6_wp   !< largest number of blocks of a group
   integer, parameter :: max_vertices = 512       !< largest number of vertices of a block
   real(wp), parameter :: min_area = 1.0e-12_wp  !< smallest area/squared size

   !> A growing list of polygons with their materials.
   type :: outlines_type
      integer :: n = 0
      integer :: n_vertices = 0
      integer, allocatable :: first(:)             !< [n+1] first vertex of each polygon
      real(wp), allocatable :: vertices(:,:)       !< [2, any] counter-clockwise, m
      integer, allocatable :: material(:)          !< material of each polygon
      integer, allocatable :: joint(:)  !< [any] joint of the edge that begins at each vertex
      integer, allocatable :: source(:)            !< input group of each polygon
      character(len=64), allocatable :: name(:)
      character(len=64), allocatable :: body(:) !< body of each polygon that is a cell, else blank
      real(wp), allocatable :: cover(:)  !< height of ground that causes the initial stress, m
      real(wp), allocatable :: overburden(:)       !< additional vertical pressure, Pa
   end type outlines_type

contains

   !> Append one polygon.
   subroutine add_outline(outlines, vertices, material, joint, source, name, edge_joints, body)
      type(outlines_type), intent(inout) :: outlines  !< list
      real(wp), intent(in) :: vertices(:,:)           !< [2, any] counter-clockwise, m
      integer, intent(in) :: material, joint, source  !< see `outlines_type`
      character(len=*), intent(in) :: name            !< name; '' if there is none
      integer, intent(in), optional :: edge_joints(:) !< [edges] instead of `joint`
      character(len=*), intent(in), optional :: body  !< body of which the polygon is a cell
      integer :: n, last

      n = outlines%n + 1
      last = outlines%n_vertices + size(vertices, 2)
      call grow(outlines%first, n + 1)
      call grow(outlines%vertices, 2, last)
      call grow(outlines%material, n)
      call grow(outlines%joint, last)
      call grow(outlines%source, n)
      call grow(outlines%body, n)
      call grow(outlines%name, n)
      call grow(outlines%cover, n)
      call grow(outlines%overburden, n)
      outlines%vertices(:, outlines%n_vertices + 1:last) = vertices
      outlines%first(n:n + 1) = [outlines%n_vertices, last] + 1
      outlines%material(n) = material
      outlines%joint(outlines%n_vertices + 1:last) = joint
      if (present(edge_joints)) outlines%joint(outlines%n_vertices + 1:last) = edge_joints
      outlines%source(n) = source
      outlines%body(n) = ''
      if (present(body)) outlines%body(n) = body
      outlines%name(n) = name
      if (name == '') outlines%name(n) = outlines%body(n)
      outlines%n = n
      outlines%n_vertices = last
   end subroutine add_outline

   !> Reason why a polygon of finite vertices cannot be a block, else blank.
   pure function outline_failure(vertices) result(failure)
      real(wp), intent(in) :: vertices(:,:)  !< [2, ≥ 3] m
      character(len=:), allocatable :: failure
      real(wp) :: size_squared

      size_squared = maxval(maxval(vertices, 2) - minval(vertices, 2))**2
      failure = ''
      if (.not. is_simple(vertices)) then
         failure = ': the polygon crosses or touches itself, or repeats a vertex'
      else if (area_of(vertices) < 0.0_wp) then
         failure = ' run clockwise; give them counter-clockwise'
      else if (.not. area_of(vertices) > min_area*size_squared) then
         failure = ': the polygon has no area'
      end if
   end function outline_failure

   !> Rectangle, given by its lower left and upper right corner.
   pure function rectangle(left, bottom, right, top) result(vertices)
      real(wp), intent(in) :: left, bottom, right, top  !< m
      real(wp) :: vertices(2, 4)

      vertices = reshape([left, bottom, right, bottom, right, top, left, top], [2, 4])
   end function rectangle

   !> Add `count` equal layers, stacked upwards.
   subroutine add_layers(outlines, left, bottom, width, thickness, count, material, joint, source, &
      name)
      type(outlines_type), intent(inout) :: outlines  !< list to append to
      real(wp), intent(in) :: left, bottom            !< lower left corner of the lowest layer, m
      real(wp), intent(in) :: width, thickness        !< width and thickness of each layer, m
      integer, intent(in) :: count                    !< number of layers
      integer, intent(in) :: material, joint, source  !< see `outlines_type`
      character(len=*), intent(in) :: name            !< see `numbered_name`
      integer :: i

      do i = 1, count
         call add_outline(outlines, rectangle(left, bottom + (i - 1)*thickness, left + width, &
            bottom + i*thickness), material, joint, source, numbered_name(name, i))
      end do
   end subroutine add_layers

   !> Add `count` drums of a column, upwards, tapering linearly between two widths.
   subroutine add_drums(outlines, centre, bottom, height, widths, count, material, joint, source, &
      name)
      type(outlines_type), intent(inout) :: outlines  !< list to append to
      real(wp), intent(in) :: centre, bottom          !< axis and foot of the column, m
      real(wp), intent(in) :: height                  !< height of each drum, m
      real(wp), intent(in) :: widths(2)  !< widths at the foot and at the top of the column, m
      integer, intent(in) :: count                    !< number of drums
      integer, intent(in) :: material, joint, source  !< see `outlines_type`
      character(len=*), intent(in) :: name            !< see `numbered_name`
      real(wp) :: lower, upper, foot, head
      integer :: i

      do i = 1, count
         lower = bottom + (i - 1)*height
         upper = bottom + i*height
         foot = 0.5_wp*(widths(1) + (widths(2) - widths(1))*(i - 1)/count)
         head = 0.5_wp*(widths(1) + (widths(2) - widths(1))*i/count)
         call add_outline(outlines, reshape([centre - foot, lower, centre + foot, lower, &
            centre + head, upper, centre - head, upper], [2, 4]), material, joint, source, &
            numbered_name(name, i))
      end do
   end subroutine add_drums

   !> Add a running-bond wall: every other course begins and ends with half a brick.
   subroutine add_wall(outlines, left, bottom, brick, bricks, courses, material, joint, source, &
      name, head_joint)
      type(outlines_type), intent(inout) :: outlines  !< list to append to
      real(wp), intent(in) :: left, bottom            !< lower left corner, m
      real(wp), intent(in) :: brick(2)                !< length and height, m
      integer, intent(in) :: bricks, courses  !< bricks of a full course; courses of the wall
      integer, intent(in) :: material, joint, source  !< see `outlines_type`
      character(len=*), intent(in) :: name            !< see `numbered_name`
      real(wp), intent(in) :: head_joint              !< gap between bricks of a course, m
      real(wp) :: from, to, course_bottom
      integer :: course, i, k, last

      k = 0
      do course = 1, courses
         course_bottom = bottom + (course - 1)*brick(2)
         last = bricks + merge(0, 1, modulo(course, 2) == 1)
         do i = 1, last
            from = left + (i - 1)*brick(1)
            if (modulo(course, 2) == 0) from = max(left, from - 0.5_wp*brick(1))
            to = left + i*brick(1)
            if (modulo(course, 2) == 0) to = min(left + bricks*brick(1), to - 0.5_wp*brick(1))
            if (i > 1) from = from + 0.5_wp*head_joint
            if (i < last) to = to - 0.5_wp*head_joint
            k = k + 1
            call add_outline(outlines, rectangle(from, course_bottom, to, bottom + &
               course*brick(2)), material, joint, source, numbered_name(name, k))
         end do
      end do
   end subroutine add_wall

   !> Set the cover of polygon `first` and of all later ones, for their initial stress: the depth of
   !> each below the highest vertex, and the overburden on this vertex.
   pure subroutine set_cover(outlines, first, overburden)
      type(outlines_type), intent(inout) :: outlines  !< list
      integer, intent(in) :: first                    !< number of the polygon
      real(wp), intent(in) :: overburden  !< vertical pressure on the highest vertex, Pa
      real(wp) :: top
      integer :: i

      top = maxval(outlines%vertices(2, outlines%first(first):outlines%n_vertices))
      do i = first, outlines%n
         associate (y => outlines%vertices(2, outlines%first(i):outlines%first(i + 1) - 1))
            outlines%cover(i) = top - 0.5_wp*(minval(y) + maxval(y))
         end associate
         outlines%overburden(i) = overburden
      end do
   end subroutine set_cover

   !> Name 'name_i'; blank for a generator without a name.
   pure function numbered_name(name, i) result(long_name)
      character(len=*), intent(in) :: name  !< name of the generator
      integer, intent(in) :: i              !< polygon of the generator
      character(len=64) :: long_name

      long_name = ''
      if (name /= '') write (long_name, '(a,"_",i0)') trim(name), i
   end function numbered_name

end module dda_outlines
