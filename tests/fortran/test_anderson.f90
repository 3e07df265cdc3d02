! SPDX-License-Identifier: GPL-3.0-or-later
!> Anderson acceleration of affine fixed points, whose solution is known.
module test_anderson
   use dda_kinds, only: wp
   use dda_anderson, only: accelerate, anderson_type, discard_iterations
   use models, only: random_vector
   use testing, only: case, check, check_close
   implicit none

contains

   subroutine affine_maps()
      integer :: n, i

      do n = 1, 5
         call case('affine and contracting')
         do i = 1, 10
            call converge(n, 0.6_wp, n + 1)
         end do
         call case('affine and diverging')
         do i = 1, 10
            call converge(n, 3.0_wp, n + 1)
         end do
      end do
   end subroutine affine_maps

   !> x = A x + b with ‖A‖ about `size_a`: the solution after `evaluations` evaluations.
   subroutine converge(n, size_a, evaluations)
      integer, intent(in) :: n, evaluations
      real(wp), intent(in) :: size_a
      type(anderson_type) :: memory
      real(wp) :: a(n, n), solution(n), x(n)
      integer :: i, k

      a = size_a/real(n, wp)*reshape(random_vector(n*n), [n, n])
      do k = 1, n
         a(k, k) = a(k, k) - 0.5_wp*size_a
      end do
      solution = random_vector(n)
      x = 0.0_wp
      do i = 1, evaluations
         call accelerate(memory, x, solution + matmul(a, x - solution))
      end do
      call check_close(x, solution, 'solution', absolute=1.0e-6_wp)
   end subroutine converge

   !> More unknowns than memory: faster than the plain iteration.
   subroutine more_unknowns_than_memory()
      integer, parameter :: n = 40
      type(anderson_type) :: memory
      real(wp) :: x(n), plain_iterate(n), rate(n), solution(n)
      integer :: i

      rate = [(0.95_wp*real(i, wp)/real(n, wp), i=1, n)]
      solution = random_vector(n)
      x = 0.0_wp
      plain_iterate = 0.0_wp
      do i = 1, 40
         call accelerate(memory, x, solution + rate*(x - solution))
         plain_iterate = solution + rate*(plain_iterate - solution)
      end do
      call check(norm2(x - solution) < 1.0e-3_wp*norm2(plain_iterate - solution), &
         'a thousand times nearer in 40 iterations')
   end subroutine more_unknowns_than_memory

   subroutine begun_at_the_solution()
      type(anderson_type) :: memory
      real(wp) :: x(3), solution(3)
      integer :: i

      solution = [1.0_wp, -2.0_wp, 3.0_wp]
      x = solution
      do i = 1, 4
         call accelerate(memory, x, solution)
      end do
      call check_close(x, solution, 'it stays', relative=1.0e-15_wp)
   end subroutine begun_at_the_solution

   !> After `discard_iterations`, earlier sizes and maps have no effect.
   subroutine reuse_after_discard()
      type(anderson_type) :: memory, fresh
      real(wp) :: x(2), y(2), long(30)
      integer :: i

      long = 1.0_wp
      do i = 1, 9
         call accelerate(memory, long, 0.5_wp*cos(long))
      end do
      call discard_iterations(memory)
      x = 0.0_wp
      y = 0.0_wp
      do i = 1, 3
         call accelerate(memory, x, [1.0_wp - 2.0_wp*x(2), 0.5_wp*x(1)])
         call accelerate(fresh, y, [1.0_wp - 2.0_wp*y(2), 0.5_wp*y(1)])
      end do
      call check_close(x, y, 'as with a new memory')
      call check_close(x, [0.5_wp, 0.25_wp], 'solution', absolute=1.0e-10_wp)
   end subroutine reuse_after_discard

end module test_anderson
