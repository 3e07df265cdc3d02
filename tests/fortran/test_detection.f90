! SPDX-License-Identifier: GPL-3.0-or-later
!> Contacts against the exact geometry: rows by finite differences, counts by reasoning.
module test_detection
   use dda_kinds, only: wp, pi
   use dda_blocks, only: blocks_type, shape_matrix, update_geometry
   use dda_contact, only: contacts_type, reserve
   use dda_contact_gradients, only: find_rows, relative_motion, rows_type
   use dda_detection, only: detect_contacts, detection_type, measure_depths, prepare_detection
   use dda_entrance, only: corners_type, entrance_edge, other_end
   use dda_neighbours, only: find_neighbours, neighbours_type
   use dda_outlines, only: add_layers, add_wall, outlines_type
   use dda_text, only: to_text
   use models, only: make_rock_blocks, place_blocks, random, random_vector, rectangle, shifted, &
      star, turned
   use testing, only: case, check, check_close
   implicit none

   real(wp), parameter :: distance = 0.02_wp
   !> vertices and edges of the contacts of `detect_corners_again`
   integer, parameter :: tip(2) = [11, 4], tip_edge(2) = [4, 10]
   type(blocks_type) :: blocks
   type(contacts_type) :: contacts

contains

   !> List all contacts in the present positions.
   subroutine list(blocks, contacts, reach)
      type(blocks_type), intent(in) :: blocks
      type(contacts_type), intent(out) :: contacts
      real(wp), intent(in) :: reach
      type(neighbours_type) :: neighbours
      type(detection_type) :: detection

      call find_neighbours(neighbours, blocks, 2.0_wp*reach)
      call prepare_detection(detection, blocks, reach)
      call detect_contacts(contacts, blocks, neighbours, detection)
   end subroutine list

   !> A strained, turned star with a corner of a triangle at a random position on an edge.
   subroutine rows_of_vertex_on_edge()
      integer :: i, c, n_contacts

      n_contacts = 0
      do i = 1, 60
         call vertex_near_edge(random(-0.01_wp, 0.015_wp), random(0.2_wp, 0.8_wp))
         call list(blocks, contacts, distance)
         do c = 1, contacts%n
            n_contacts = n_contacts + 1
            call check_rows(c)
         end do
      end do
      call check(n_contacts >= 60, 'a contact each time')
   end subroutine rows_of_vertex_on_edge

   !> Random corners near corners: all listed contacts have exact rows.
   subroutine rows_corner_to_corner()
      integer :: i, c, n_contacts

      n_contacts = 0
      do i = 1, 60
         call vertex_near_edge(random(-0.004_wp, 0.004_wp), random(-0.003_wp, 0.003_wp))
         call list(blocks, contacts, distance)
         do c = 1, contacts%n
            if (contacts%corner(c) > 0) n_contacts = n_contacts + 1
            call check_rows(c)
         end do
      end do
      call check(n_contacts >= 30, 'corners met')
   end subroutine rows_corner_to_corner

   !> Block 1 a strained star; block 2 a strained needle with its tip at `part` of an edge and `gap`
   !> off it.
   subroutine vertex_near_edge(gap, fraction)
      real(wp), intent(in) :: gap, fraction
      real(wp) :: a(2), b(2), normal(2), position(2), rotation
      integer :: e

      call place_blocks(blocks, star(5, 1.0_wp, 1.4_wp), &
         reshape([0.0_wp, 0.0_wp, 1.2_wp, -0.3_wp, 1.1_wp, 0.35_wp], [2, 3]))
      blocks%position(3, :) = 6.0_wp*random_vector(2)
      blocks%position(4:6, :) = 0.05_wp*reshape(random_vector(6), [3, 2])
      call update_geometry(blocks)
      e = 1 + int(random(0.0_wp, 4.9_wp))
      a = blocks%vertex(:, e)
      b = blocks%vertex(:, blocks%next(e))
      normal = [b(2) - a(2), a(1) - b(1)]/norm2(b - a)
      rotation = atan2(normal(2), normal(1)) + random(-0.3_wp, 0.3_wp)
      blocks%position(3, 2) = rotation
      call update_geometry(blocks)
      position = a + fraction*(b - a) + gap*normal
      blocks%position(1:2, 2) = blocks%position(1:2, 2) + position - blocks%vertex(:, 6)
      call update_geometry(blocks)
   end subroutine vertex_near_edge

   !> Gap and slip of a vertex along an edge, from positions only; slip is relative to the material
   !> point at `fraction` of the edge.
   function gap_and_slip(v, e, fraction) result(values)
      integer, intent(in) :: v, e
      real(wp), intent(in) :: fraction
      real(wp) :: values(2)
      real(wp) :: a(2), tangent(2), length

      a = blocks%vertex(:, e)
      tangent = blocks%vertex(:, blocks%next(e)) - a
      length = norm2(tangent)
      tangent = tangent/length
      associate (from => blocks%vertex(:, v) - a)
         values(1) = tangent(2)*from(1) - tangent(1)*from(2)
         values(2) = dot_product(tangent, from) - fraction*length
      end associate
   end function gap_and_slip

   !> Finite differences over all twelve coordinates.
   subroutine check_rows(c)
      integer, intent(in) :: c
      real(wp), parameter :: h = 1.0e-6_wp
      type(rows_type) :: actual
      real(wp) :: rows(6, 2, 2), q, forward(2), backward(2), fraction, present_gap(2), edge_length
      integer :: side, k, b, v, e

      v = contacts%vertex(c)
      e = contacts%edge(c)
      present_gap = gap_and_slip(v, e, 0.0_wp)
      call check_close(contacts%gap(c), present_gap(1), 'gap', absolute=1.0e-14_wp)
      edge_length = norm2(blocks%vertex(:, blocks%next(e)) - blocks%vertex(:, e))
      fraction = present_gap(2)/edge_length
      do side = 1, 2
         b = merge(contacts%block_v(c), contacts%block_e(c), side == 1)
         do k = 1, 6
            q = blocks%position(k, b)
            blocks%position(k, b) = q + h
            call update_geometry(blocks)
            forward = gap_and_slip(v, e, fraction)
            blocks%position(k, b) = q - h
            call update_geometry(blocks)
            backward = gap_and_slip(v, e, fraction)
            blocks%position(k, b) = q
            call update_geometry(blocks)
            rows(k, :, side) = (forward - backward)/(2.0_wp*h)
         end do
      end do
      call find_rows(contacts, c, actual)
      call check_close(actual%normal_v, rows(:, 1, 1), '∂gap/∂q of the vertex'' block', &
         absolute=1.0e-8_wp)
      call check_close(-actual%normal_e, rows(:, 1, 2), '∂gap/∂q of the edge''s block', &
         absolute=1.0e-8_wp)
      call check_close(actual%shear_v, rows(:, 2, 1), '∂slip/∂q of the vertex'' block', &
         absolute=1.0e-8_wp)
      call check_close(-actual%shear_e(1:3), rows(1:3, 2, 2), &
         '∂slip/∂q of the edge''s block', absolute=1.0e-8_wp)
      ! A strain of the edge's block also turns the edge: a fraction of the gap, left out.
      call check_close(-actual%shear_e(4:6), rows(4:6, 2, 2), &
         '∂slip/∂ε of the edge''s block', absolute=1.0e-8_wp + 1.2_wp*abs(present_gap(1)))
      call compare_with_shapes(c, fraction)
   end subroutine check_rows

   !> The rows nᵀT and tᵀT to all digits, and their products with a motion.
   subroutine compare_with_shapes(c, fraction)
      integer, intent(in) :: c
      real(wp), intent(in) :: fraction  !< of the edge before the foot
      type(rows_type) :: rows
      real(wp) :: of_v(6), of_e(6), axes(2, 2), lever(6)

      call find_rows(contacts, c, rows)
      associate (v => contacts%vertex(c), e => contacts%edge(c), next => blocks%next, &
         normal => contacts%normal(:, c), reference => blocks%reference)
         axes = reshape([normal(1), -normal(2), normal(2), normal(1)], [2, 2])
         call check_close(reshape([rows%normal_v, rows%shear_v], [6, 2]), &
            transpose(matmul(axes, shape_matrix(blocks, contacts%block_v(c), reference(:, v)))), &
            'rows of the vertex'' block', absolute=1.0e-13_wp)
         lever = [0.0_wp, 0.0_wp, contacts%gap(c), 0.0_wp, 0.0_wp, 0.0_wp]
         call check_close(reshape([rows%normal_e, rows%shear_e - lever], [6, 2]), &
            transpose(matmul(axes, shape_matrix(blocks, contacts%block_e(c), reference(:, e) &
            + fraction*(reference(:, next(e)) - reference(:, e))))), &
            'rows of the edge''s block', absolute=1.0e-13_wp)
      end associate
      of_v = random_vector(6)
      of_e = random_vector(6)
      call check_close(relative_motion(contacts, c, of_v, of_e), &
         [dot_product(rows%normal_v, of_v) - dot_product(rows%normal_e, of_e), &
         dot_product(rows%shear_v, of_v) - dot_product(rows%shear_e, of_e)], &
         'relative motion', absolute=1.0e-13_wp)
   end subroutine compare_with_shapes

   !> Two contacts per joint, one at each end, at any inclination.
   subroutine a_stack_of_equal_width()
      type(outlines_type) :: outlines, tilted_outlines
      integer :: i, k

      call add_layers(outlines, 0.0_wp, 0.0_wp, 15.0_wp, 1.0_wp, 8, 1, 1, 1, '')
      do k = 0, 10
         tilted_outlines = outlines
         tilted_outlines%vertices = turned(outlines%vertices, 0.37_wp*k)
         call make_rock_blocks(tilted_outlines, blocks)
         call list(blocks, contacts, distance)
         call check(contacts%n == 14, 'fourteen contacts for seven joints')
         do i = 1, 7
            call check(count_pair(i, i + 1) == 2, 'two in joint '//to_text(i))
         end do
         call check_close(contacts%gap(:contacts%n), 0.0_wp*contacts%gap(:contacts%n), &
            'all touch', absolute=1.0e-13_wp)
         call check(spread_along(1) > 14.9_wp, 'one at each end')
      end do
   end subroutine a_stack_of_equal_width

   integer function count_pair(a, b) result(found)
      integer, intent(in) :: a, b
      integer :: c

      found = 0
      do c = 1, contacts%n
         if (min(contacts%block_v(c), contacts%block_e(c)) == a .and. max(contacts%block_v(c), &
            contacts%block_e(c)) == b) &
            found = found + 1
      end do
   end function count_pair

   !> Distance between the touching vertices of blocks a and a + 1.
   real(wp) function spread_along(a) result(separated_blocks)
      integer, intent(in) :: a
      integer :: c, k

      separated_blocks = 0.0_wp
      do c = 1, contacts%n
         do k = 1, c - 1
            if (min(contacts%block_v(c), contacts%block_e(c)) /= a) cycle
            if (min(contacts%block_v(k), contacts%block_e(k)) /= a) cycle
            separated_blocks = max(separated_blocks, &
               norm2(blocks%vertex(:, contacts%vertex(c)) - blocks%vertex(:, contacts%vertex(k))))
         end do
      end do
   end function spread_along

   !> Each joint of a wall, bed or head, has two contacts: a brick rests on the two below it with
   !> four.
   subroutine running_bond()
      type(outlines_type) :: outlines
      integer :: k

      call add_wall(outlines, 0.0_wp, 0.0_wp, [0.6_wp, 0.3_wp], 3, 3, 1, 1, 1, '', 0.0_wp)
      do k = 0, 5
         if (k > 0) outlines%vertices = turned(outlines%vertices, 0.61_wp)
         call make_rock_blocks(outlines, blocks)
         call list(blocks, contacts, distance)
         ! Bricks 1–3 below, 4–7 above them (4 and 7 are halves), 8–10 on top.
         call check(count_pair(1, 5) == 2 .and. count_pair(2, 5) == 2, &
            'four below a brick')
         call check(count_pair(5, 8) == 2 .and. count_pair(5, 9) == 2, &
            'four above it')
         call check(count_pair(4, 5) == 2 .and. count_pair(5, 6) == 2, &
            'two in each head joint')
         call check(count_pair(1, 4) == 2, 'two below the half brick')
         ! Bed joints: 6 between courses 1 and 2, 6 above; head joints: 2, 3 and 2.
         call check(contacts%n == 2*(6 + 6 + 2 + 3 + 2), 'two per joint in all')
      end do
   end subroutine running_bond

   !> A corner in a right-angled notch touches both of its faces.
   subroutine a_corner_in_a_notch()
      real(wp) :: shape(2, 7), tip(2, 3), facing
      integer :: k, c

      shape = reshape([-2, -2, 2, -2, 2, 1, 1, 1, 0, 0, -1, 1, -2, 1]*1.0_wp, [2, 7])
      tip = reshape([0.0_wp, 0.001_wp, 0.5_wp, 1.5_wp, -0.5_wp, 1.5_wp], [2, 3])
      do k = 0, 9
         call place_blocks(blocks, turned(shape, 0.5_wp*k), &
            turned(shifted(tip, [0.0_wp, -0.002_wp*modulo(k, 2)]), 0.5_wp*k))
         call list(blocks, contacts, distance)
         call check(contacts%n == 2, 'two contacts')
         if (contacts%n /= 2) cycle
         facing = dot_product(contacts%normal(:, 1), contacts%normal(:, 2))
         call check_close(facing, 0.0_wp, 'at right angles', absolute=1.0e-13_wp)
         do c = 1, 2
            call check(contacts%vertex(c) == 8, 'of the tip')
            call check_close(contacts%gap(c), (0.001_wp - 0.002_wp*modulo(k, 2))*sqrt(0.5_wp), &
               'gap', absolute=1.0e-13_wp)
         end do
      end do
   end subroutine a_corner_in_a_notch

   !> A block slides over the end of an equal one: vertex on edge, corner to corner, vertex on edge.
   !> Two contacts push upwards at all times, and their gaps equal the penetration.
   subroutine over_the_end_of_a_block()
      real(wp), parameter :: depth = 1.0e-4_wp
      real(wp) :: x
      integer :: i, corners

      call place_blocks(blocks, rectangle(0.0_wp, 0.0_wp, 2.0_wp, 1.0_wp), &
         rectangle(0.0_wp, 1.0_wp, 2.0_wp, 2.0_wp))
      corners = 0
      do i = -400, 400
         x = sign(abs(real(i, wp)/400.0_wp)**3, real(i, wp))*0.1_wp
         blocks%position(1:2, 2) = [1.0_wp + x, 1.5_wp - depth]
         call update_geometry(blocks)
         call list(blocks, contacts, distance)
         if (any(contacts%corner(:contacts%n) > 0)) corners = corners + 1
         if (contacts%n /= 2) then
            call check(.false., to_text(contacts%n)//' contacts at x = '//to_text(x))
            cycle
         end if
         call check_close(contacts%gap(1:2), [-depth, -depth], 'gap', absolute=1.0e-12_wp)
         call check_close(abs(contacts%normal(2, 1:2)), [1.0_wp, 1.0_wp], 'up', absolute=1.0e-12_wp)
      end do
      call check(corners > 10 .and. corners < 790, 'both kinds occur')
   end subroutine over_the_end_of_a_block

   !> Edges within 3° of each other are parallel: they share an overlap, and either may be the
   !> entrance.
   subroutine edges_that_are_almost_parallel()
      type(corners_type) :: corners
      real(wp), parameter :: angle(2) = [2.99_wp, 3.01_wp]*pi/180.0_wp
      integer :: i

      blocks%inner = [.false.]
      corners%edge = 1
      corners%overshoot = -1.0_wp
      corners%glancing = .false.
      corners%gap = [0.0_wp, -1.0_wp, 0.01_wp, 1.0_wp]
      do i = 1, 2
         corners%along = reshape([1.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, -cos(angle(i)), &
            sin(angle(i)), 0.0_wp, 1.0_wp], [2, 4])
         corners%separation = [0.0_wp, 0.0_wp, -sin(angle(i)), -1.0_wp]
         call check(other_end(blocks, corners, 1, 1.0_wp, distance) == merge(3, 0, i == 1), 'ends')
         call check(entrance_edge(blocks, corners, 1.0_wp, 0.0_wp) == merge(3, 1, i == 1), 'edge')
      end do
   end subroutine edges_that_are_almost_parallel

   !> The tip of a needle passes around a blunt corner at a small distance: the gap follows the
   !> distance without jumps.
   subroutine round_a_corner()
      real(wp) :: corner(2), normal(2), tip(2), angle, gap, last, step, jump
      integer :: i

      call place_blocks(blocks, reshape([-1.0_wp, -1.0_wp, 1.0_wp, -1.0_wp, 1.0_wp, 0.0_wp, &
         -1.0_wp, 0.4_wp], [2, 4]), reshape([0.0_wp, 0.0_wp, 0.9_wp, 0.6_wp, 0.6_wp, 0.9_wp], [2, &
         3]))
      corner = blocks%vertex(:, 3)
      last = huge(1.0_wp)
      jump = 0.0_wp
      step = 1.0e-4_wp
      do i = -200, 200
         ! A straight way past the corner, at 45°, half a millimetre off it.
         angle = 0.25_wp*pi
         normal = [cos(angle), sin(angle)]
         tip = corner + 5.0e-4_wp*normal + real(i, wp)*step*[-normal(2), normal(1)]
         blocks%position(1:2, 2) = blocks%position(1:2, 2) + tip - blocks%vertex(:, 5)
         call update_geometry(blocks)
         call list(blocks, contacts, distance)
         gap = huge(1.0_wp)
         if (contacts%n > 0) gap = minval(contacts%gap(:contacts%n))
         if (last < 1.0_wp) jump = max(jump, abs(gap - last))
         last = gap
      end do
      call check_close(jump, 0.0_wp, 'the gap changes by no more than the motion', &
         absolute=step*1.001_wp)
   end subroutine round_a_corner

   !> A slab thinner than the contact distance is entered from its near face only.
   subroutine a_thin_slab()
      real(wp) :: depth
      integer :: i, c

      call place_blocks(blocks, rectangle(-5.0_wp, -0.005_wp, 5.0_wp, 0.0_wp), &
         rectangle(-0.5_wp, 0.0_wp, 0.5_wp, 1.0_wp))
      do i = -4, 4
         depth = 2.0e-4_wp*i
         blocks%position(2, 2) = 0.5_wp - depth
         call update_geometry(blocks)
         call list(blocks, contacts, distance)
         call check(contacts%n == 2, 'two contacts')
         do c = 1, contacts%n
            call check_close(contacts%normal(:, c), [0.0_wp, 1.0_wp], 'up', absolute=1.0e-12_wp)
            call check_close(contacts%gap(c), -depth, 'gap', absolute=1.0e-13_wp)
         end do
      end do
   end subroutine a_thin_slab

   !> The tip of a needle near a corner, deep behind the far edge only, is outside the block, convex
   !> or with a reentrant corner.  A tip inside is detected, also beyond the line of another edge.
   subroutine behind_a_block()
      real(wp), parameter :: convex(2, 4) = reshape([-1.0_wp, 0.0_wp, 3.0_wp, 0.0_wp, 1.5_wp, &
         1.0_wp, 0.5_wp, 1.0_wp], [2, 4])
      real(wp), parameter :: dented(2, 5) = reshape([-1.0_wp, 0.0_wp, 3.0_wp, 0.0_wp, 1.6_wp, &
         0.4_wp, 1.5_wp, 1.0_wp, 0.5_wp, 1.0_wp], [2, 5])
      real(wp), parameter :: outer_corner(2) = [0.41_wp, 1.285_wp], barely(2) = [0.499_wp, 1.003_wp]

      call check(.not. is_pressed(convex, outer_corner), 'outside a convex block')
      call check(.not. is_pressed(dented, outer_corner), 'outside a block with a dent')
      call check(.not. is_pressed(convex, barely), 'hardly outside a convex block')
      call check(.not. is_pressed(dented, barely), 'hardly outside a block with a dent')
      call check(is_pressed(convex, [1.0_wp, 0.5_wp]), 'in a convex block')
      call check(is_pressed(dented, [0.9_wp, 0.5_wp]), 'in a block with a dent')
      call check(is_pressed(dented, [2.0_wp, 0.1_wp]), 'in it, below the dent')
   end subroutine behind_a_block

   !> The tip of a needle has a contact in penetration, also with a large search distance.
   logical function is_pressed(shape_of, tip) result(pressed)
      real(wp), intent(in) :: shape_of(:,:), tip(2)
      type(neighbours_type) :: neighbours
      type(detection_type) :: detection

      call place_blocks(blocks, turned(shape_of, 0.3_wp), turned(shifted(reshape([0.0_wp, 0.0_wp, &
         0.3_wp, 4.0_wp, -0.3_wp, 4.0_wp], [2, 3]), tip), 0.3_wp))
      call find_neighbours(neighbours, blocks, 3.0_wp)
      call prepare_detection(detection, blocks, distance)
      detection%distance = 1.4_wp
      call detect_contacts(contacts, blocks, neighbours, detection)
      pressed = any(contacts%gap(:contacts%n) < 0.0_wp &
         .and. contacts%vertex(:contacts%n) == size(shape_of, 2) + 1)
   end function is_pressed

   !> The number of contacts and their penetrations do not depend on the order of two blocks.
   subroutine either_block_first()
      type(contacts_type) :: contacts_ab, contacts_ba
      real(wp) :: first(2, 4), second(2, 5)
      integer :: i, n_contacts

      n_contacts = 0
      do i = 1, 100
         first = turned(rectangle(-0.5_wp, -0.5_wp, 0.5_wp, 0.5_wp), 3.0_wp*random(-1.0_wp, 1.0_wp))
         second = shifted(star(5, 0.5_wp, 0.7_wp), random(0.9_wp, 1.2_wp)*[cos(0.7_wp*i), &
            sin(0.7_wp*i)])
         call place_blocks(blocks, first, second)
         call list(blocks, contacts_ab, distance)
         call place_blocks(blocks, second, first)
         call list(blocks, contacts_ba, distance)
         call check(contacts_ab%n == contacts_ba%n, 'as many contacts')
         n_contacts = n_contacts + contacts_ab%n
         if (contacts_ab%n == 0 .or. contacts_ab%n /= contacts_ba%n) cycle
         call check_close(sum(contacts_ab%gap(:contacts_ab%n)), &
            sum(contacts_ba%gap(:contacts_ab%n)), 'as deep', absolute=1.0e-12_wp)
      end do
      call check(n_contacts > 20, 'some meet')
   end subroutine either_block_first

   !> Two blocks that pass each other, corner by corner, so fast that a step leads beyond the
   !> corner: while an edge line separates them, no listed contact has a large penetration.
   subroutine fast_corners()
      call case('corners that pass each other fast')
      call pass_by(reshape([-0.13_wp, -0.08_wp, -0.04_wp, -0.13_wp, 0.0_wp, 0.0_wp, -0.10_wp, &
         -0.05_wp], [2, 4]), reshape([0.14_wp, 0.09_wp, 0.06_wp, 0.14_wp, 0.03_wp, 0.13_wp, &
         0.0_wp, 0.0_wp, 0.10_wp, 0.025_wp], [2, 5]), 0.01_wp, distance)
      call case('corners on two sides of a thin block')
      call pass_by(reshape([0.128_wp, -0.068_wp, 0.134_wp, -0.022_wp, 0.0_wp, 0.0_wp, -0.007_wp, &
         -0.022_wp, 0.045_wp, -0.058_wp], [2, 5]), &
         reshape([0.098_wp, -0.016_wp, 0.145_wp, 0.121_wp, 0.086_wp, 0.139_wp, -0.018_wp, &
         0.142_wp, -0.076_wp, 0.126_wp, -0.040_wp, 0.055_wp, 0.001_wp, 0.0_wp], [2, 7]), 0.005_wp, &
         1.5_wp*distance)
   end subroutine fast_corners

   !> The second block at many positions near its own; a step may be as long as the distance within
   !> which contacts are listed.
   subroutine pass_by(first, position, about, reach)
      real(wp), intent(in) :: first(:,:), position(:,:), about, reach
      real(wp), parameter :: tolerance = 4.0e-4_wp
      type(neighbours_type) :: neighbours
      type(detection_type) :: detection
      real(wp) :: second(2, size(position, 2))
      integer :: i, n_contacts

      n_contacts = 0
      do i = 1, 1000
         second = shifted(position, about*random_vector(2))
         if (separation_of(first, second) < 0.0_wp) cycle
         call place_blocks(blocks, first, second)
         blocks%velocity(1:2, :) = reshape(random_vector(4), [2, 2])
         call find_neighbours(neighbours, blocks, 2*reach)
         call prepare_detection(detection, blocks, reach)
         detection%travel = reach
         detection%depth = 0.5_wp*tolerance
         call detect_contacts(contacts, blocks, neighbours, detection)
         n_contacts = n_contacts + contacts%n
         call check(all(contacts%gap(:contacts%n) >= -tolerance), 'apart')
      end do
      call check(n_contacts > 500, 'many meet')
   end subroutine pass_by

   !> Two corners in vibrating contact keep the edge that they press on.
   subroutine corners_in_vibrating_contact()
      integer :: i

      do i = 1, 200
         call detect_corners_again(1 + modulo(i, 2), -3.0e-4_wp, .false.)
         call check(contacts%n == 1, 'one contact')
         call check(is_edge_of(1 + modulo(i, 2)), 'the edge pressed on')
      end do
   end subroutine corners_in_vibrating_contact

   !> Two bonded corners keep their edge in tension too; without the bond the geometry selects it.
   subroutine bonded_corners()
      integer :: i, kept

      kept = 0
      do i = 1, 200
         call detect_corners_again(1 + modulo(i, 2), 3.0e-5_wp, .true.)
         call check(contacts%n == 1, 'one contact')
         call check(is_edge_of(1 + modulo(i, 2)), 'the edge of the bond')
         call detect_corners_again(1 + modulo(i, 2), 3.0e-5_wp, .false.)
         if (is_edge_of(1 + modulo(i, 2))) kept = kept + 1
      end do
      call check(kept < 150, 'without a bond, the other edge is also selected')
   end subroutine bonded_corners

   !> Detect the contact of two corners that were in contact on edge k, after a random motion.
   subroutine detect_corners_again(k, gap, bonded)
      integer, intent(in) :: k        !< 1 or 2: edge of the first or of the second block
      real(wp), intent(in) :: gap     !< at the end of the last step, m
      logical, intent(in) :: bonded   !< the contact was bonded
      type(neighbours_type) :: neighbours
      type(detection_type) :: detection
      real(wp) :: first(2, 5), second(2, 6)

      first = reshape([-0.0134_wp, -0.1047_wp, 0.1038_wp, -0.0785_wp, 0.0670_wp, -0.0503_wp, &
         0.0_wp, 0.0_wp, -0.0139_wp, -0.0517_wp], [2, 5])
      second = reshape([-0.1408_wp, 0.0662_wp, -0.1890_wp, -0.0403_wp, -0.1689_wp, -0.1029_wp, &
         -0.1074_wp, -0.1008_wp, -0.0341_wp, -0.0571_wp, 0.00027_wp, -0.00014_wp], [2, 6])
      call place_blocks(blocks, first, shifted(second, 2.0e-5_wp*random_vector(2)))
      blocks%velocity(1:3, :) = reshape(random_vector(6), [3, 2])
      call find_neighbours(neighbours, blocks, 0.02_wp)
      call prepare_detection(detection, blocks, 0.01_wp)
      detection%travel = 1.0e-3_wp
      call reserve(contacts, 1)
      contacts%n = 1
      contacts%vertex(1) = tip(k)
      contacts%edge(1) = tip_edge(k)
      contacts%corner(1) = tip(3 - k)
      contacts%block_v(1) = blocks%owner(tip(k))
      contacts%block_e(1) = blocks%owner(tip_edge(k))
      contacts%bonded(1) = bonded
      contacts%new_gap(1) = gap
      contacts%offset(1) = 0.0_wp
      call measure_depths(detection, contacts, blocks)
      call detect_contacts(contacts, blocks, neighbours, detection)
   end subroutine detect_corners_again

   !> .true. if the contact of `detect_corners_again` is on edge k.
   logical function is_edge_of(k)  ! total
      integer, intent(in) :: k

      is_edge_of = contacts%n == 1
      if (is_edge_of) is_edge_of = contacts%vertex(1) == tip(k) .and. contacts%edge(1) == &
         tip_edge(k)
   end function is_edge_of

   !> Distance of two convex outlines along the best of their edges' normals, < 0 where they
   !> overlap.
   pure real(wp) function separation_of(first, second)
      real(wp), intent(in) :: first(:,:), second(:,:)

      separation_of = max(beyond_edges(first, second), beyond_edges(second, first))
   end function separation_of

   pure real(wp) function beyond_edges(outline, points) result(most)
      real(wp), intent(in) :: outline(:,:), points(:,:)
      real(wp) :: edge_direction(2)
      integer :: i

      most = -huge(1.0_wp)
      do i = 1, size(outline, 2)
         edge_direction = outline(:, 1 + modulo(i, size(outline, 2))) - outline(:, i)
         edge_direction = edge_direction/norm2(edge_direction)
         most = max(most, minval(edge_direction(2)*(points(1, :) - outline(1, i)) - &
            edge_direction(1)*(points(2, :) - outline(2, i))))
      end do
   end function beyond_edges

   subroutine separated_blocks()
      type(blocks_type) :: blocks
      type(contacts_type) :: contacts

      call place_blocks(blocks, rectangle(0.0_wp, 0.0_wp, 1.0_wp, 1.0_wp), &
         rectangle(0.0_wp, 1.0_wp + 1.01_wp*distance, 1.0_wp, 2.0_wp))
      call list(blocks, contacts, distance)
      call check(contacts%n == 0, 'nothing beyond the distance')
      call list(blocks, contacts, 1.02_wp*distance)
      call check(contacts%n == 2, 'two within a larger one')
   end subroutine separated_blocks

end module test_detection
