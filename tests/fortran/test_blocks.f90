! SPDX-License-Identifier: GPL-3.0-or-later
!> Inertia, shape matrix and kinematics of blocks against quadrature and finite differences.
module test_blocks
   use dda_kinds, only: wp, pi
   use dda_blocks, only: blocks_type, is_convex, mass_matrix, momentum_of, motion_of, &
      position_of, reference_of, shape_matrix, stress_of, update_geometry
   use dda_material, only: elasticity, material_type
   use dda_polygon, only: area_of
   use models, only: fan, place_blocks, random, random_vector, rectangle, shifted, star
   use testing, only: check, check_close
   implicit none

   type(blocks_type) :: blocks

contains

   !> One star at a random position.
   subroutine make_star(vertices, m)
      real(wp), allocatable, intent(out) :: vertices(:,:)
      integer, intent(in) :: m

      vertices = shifted(star(m, 0.3_wp, 1.5_wp), 4.0_wp*random_vector(2))
      call place_blocks(blocks, vertices)
   end subroutine make_star

   !> M = ρ ∫ TᵀT by a rule that is exact for quadratics; turning the block changes nothing.
   subroutine masses()
      real(wp), allocatable :: vertices(:,:), points(:,:), weights(:)
      real(wp) :: m(6, 6), v(6), t(2, 6), centre(2)
      integer :: i, k, pass

      do i = 1, 50
         call make_star(vertices, 3 + modulo(i, 10))
         centre = blocks%position(1:2, 1)
         call fan(vertices, centre, points, weights)
         do pass = 1, 2
            m = 0.0_wp
            do k = 1, size(weights)
               t = shape_matrix(blocks, 1, points(:, k) - centre)
               m = m + 2500.0_wp*weights(k)*matmul(transpose(t), t)
            end do
            call check_close(mass_matrix(blocks%inertia(:, 1)), m, 'M', relative=1.0e-12_wp)
            v = [(random(-1.0_wp, 1.0_wp), k=1, 6)]
            call check_close(momentum_of(blocks%inertia(:, 1), v), matmul(m, v), 'M v', &
               relative=1.0e-12_wp)
            blocks%position(3, 1) = random(-10.0_wp, 10.0_wp)
            call update_geometry(blocks)
         end do
         call check_close(blocks%mass(1), 2500.0_wp*sum(weights), 'mass', relative=1.0e-13_wp)
      end do
   end subroutine masses

   !> T = ∂x/∂q at any rotation and strain.
   subroutine shape_matrices()
      real(wp), allocatable :: vertices(:,:)
      real(wp), parameter :: h = 1.0e-5_wp
      real(wp) :: t(2, 6), expected(2, 6), reference(2), q(6), forward(2), backward(2)
      integer :: i, k

      do i = 1, 50
         call make_star(vertices, 5)
         q = random_vector(6)*[3.0_wp, 3.0_wp, 9.0_wp, 0.1_wp, 0.1_wp, 0.2_wp]
         reference = random_vector(2)
         do k = 1, 6
            blocks%position(:, 1) = q
            blocks%position(k, 1) = q(k) + h
            call update_geometry(blocks)
            forward = position_of(blocks, 1, reference)
            blocks%position(k, 1) = q(k) - h
            call update_geometry(blocks)
            backward = position_of(blocks, 1, reference)
            expected(:, k) = (forward - backward)/(2.0_wp*h)
         end do
         blocks%position(:, 1) = q
         call update_geometry(blocks)
         t = shape_matrix(blocks, 1, reference)
         call check_close(t, expected, 'T', absolute=1.0e-9_wp)
         call check_close(motion_of(blocks, 1, reference, q), matmul(t, q), 'T d', &
            absolute=4*epsilon(1.0_wp)*sum(abs(t))*maxval(abs(q)))
      end do
   end subroutine shape_matrices

   subroutine positions_and_references()
      real(wp), allocatable :: vertices(:,:)
      real(wp) :: position(2)
      integer :: i, v

      do i = 1, 50
         call make_star(vertices, 6)
         call check_close(blocks%vertex, vertices, 'vertices at the start')
         blocks%position(:, 1) = random_vector(6)*[3.0_wp, 3.0_wp, 9.0_wp, 0.1_wp, 0.1_wp, 0.2_wp]
         call update_geometry(blocks)
         position = random_vector(2)
         call check_close(position_of(blocks, 1, reference_of(blocks, 1, position)), position, &
            'there and back', absolute=1.0e-13_wp)
         do v = 1, 6
            call check_close(position_of(blocks, 1, blocks%reference(:, v)), blocks%vertex(:, v), &
               'vertex', absolute=1.0e-14_wp)
         end do
         call check_close(blocks%radius(1), maxval(norm2(blocks%reference, 1)), 'radius', &
            relative=1.0e-15_wp)
      end do
   end subroutine positions_and_references

   !> A thousand large increments of rotation: no growth of area or edges.
   subroutine a_thousand_large_rotations()
      real(wp), allocatable :: vertices(:,:)
      real(wp) :: max_error
      integer :: i

      call make_star(vertices, 8)
      max_error = 0.0_wp
      do i = 1, 1000
         blocks%position(3, 1) = blocks%position(3, 1) + random(-3.0_wp, 3.0_wp)
         call update_geometry(blocks)
         max_error = max(max_error, abs(area_of(blocks%vertex)/blocks%area(1) - 1.0_wp))
      end do
      call check_close(max_error, 0.0_wp, 'area', absolute=1.0e-13_wp)
      call check_close(norm2(blocks%vertex(:, 2:) - blocks%vertex(:, :7), 1), &
         norm2(vertices(:, 2:) - vertices(:, :7), 1), 'edges', relative=1.0e-13_wp)
   end subroutine a_thousand_large_rotations

   !> Strain changes the area by det(I + ε).
   subroutine strained_area()
      real(wp), allocatable :: vertices(:,:)
      real(wp) :: e(3)

      call make_star(vertices, 7)
      e = [0.1_wp, -0.05_wp, 0.08_wp]
      blocks%position(3, 1) = 2.0_wp
      blocks%position(4:6, 1) = e
      call update_geometry(blocks)
      call check_close(area_of(blocks%vertex), blocks%area(1)*((1.0_wp + e(1))*(1.0_wp + e(2)) &
         - 0.25_wp*e(3)**2), 'area', relative=1.0e-13_wp)
   end subroutine strained_area

   !> Stress turns with the block: by 90°, σx and σy are exchanged; by any angle, Mohr's circle.
   subroutine stresses()
      real(wp), allocatable :: vertices(:,:)
      real(wp) :: stress(3), angle, mean, half
      integer :: i

      call make_star(vertices, 5)
      blocks%initial_stress(:, 1) = [-1.0e6_wp, 2.0e6_wp, 3.0e5_wp]
      blocks%position(4:6, 1) = [1.0e-4_wp, -3.0e-4_wp, 2.0e-4_wp]
      stress = blocks%initial_stress(:, 1) + matmul(elasticity(material_type('', 2500.0_wp, &
         5.0e9_wp, 0.25_wp, 0.0_wp, 0.0_wp), .false.), blocks%position(4:6, 1))
      call update_geometry(blocks)
      call check_close(stress_of(blocks, 1), stress, 'as it lies', relative=1.0e-14_wp)
      blocks%position(3, 1) = 0.5_wp*pi
      call update_geometry(blocks)
      call check_close(stress_of(blocks, 1), [stress(2), stress(1), -stress(3)], 'turned by 90°', &
         relative=1.0e-14_wp)
      mean = 0.5_wp*(stress(1) + stress(2))
      half = 0.5_wp*(stress(1) - stress(2))
      do i = 1, 20
         angle = random(-7.0_wp, 7.0_wp)
         blocks%position(3, 1) = angle
         call update_geometry(blocks)
         call check_close(stress_of(blocks, 1), [mean + half*cos(2*angle) &
            - stress(3)*sin(2*angle), &
            mean - half*cos(2*angle) + stress(3)*sin(2*angle), half*sin(2*angle) &
            + stress(3)*cos(2*angle)], 'turned', relative=1.0e-13_wp)
      end do
   end subroutine stresses

   subroutine rings_of_vertices()
      call place_blocks(blocks, rectangle(0.0_wp, 0.0_wp, 1.0_wp, 1.0_wp), &
         reshape([4, 0, 6, 0, 6, 2, 5, 2, 5, 1, 4, 1]*1.0_wp, [2, 6]))
      call check(blocks%next(4) == 1 .and. blocks%next(5) == 6 &
         .and. blocks%next(10) == 5, 'next')
      call check(blocks%previous(1) == 4 .and. blocks%previous(5) == 10, 'previous')
      call check(all(blocks%owner == [1, 1, 1, 1, 2, 2, 2, 2, 2, 2]), 'owners')
      call check(.not. is_convex(blocks, 9), 'the inner corner')
      call check(is_convex(blocks, 4) .and. is_convex(blocks, 5) .and. is_convex(blocks, 8) .and. &
         is_convex(blocks, 10), 'the others')
   end subroutine rings_of_vertices

end module test_blocks
