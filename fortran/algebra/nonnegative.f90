! SPDX-License-Identifier: GPL-3.0-or-later
!> Least squares with nonnegative unknowns (Lawson and Hanson 1974, chapter 23).
!>
!> The least-squares problem of each active set is solved by normal equations: for few unknowns.
module dda_nonnegative
   use dda_kinds, only: wp
   use dda_lapack, only: dposv
   implicit none
   private
   public :: nonnegative_least_squares

contains

   !> Minimise |A x − b|² over x ≥ 0.
   subroutine nonnegative_least_squares(a, b, x)
      real(wp), intent(in) :: a(:,:)   !< [m,n] A, m ≥ n, with independent columns
      real(wp), intent(in) :: b(:)     !< [m] right-hand side
      real(wp), intent(out) :: x(:)    !< [n] vector
      real(wp) :: normal(size(x), size(x)), right(size(x)), slope(size(x)), trial(size(x))
      real(wp) :: fraction
      logical :: free(size(x))
      integer :: i, entering

      normal = matmul(transpose(a), a)
      right = matmul(transpose(a), b)
      x = 0.0_wp
      free = .false.
      do i = 1, 10*size(x)
         slope = right - matmul(normal, x)
         entering = maxloc(slope, 1, mask=.not. free)
         if (entering == 0) return
         if (slope(entering) <= 1.0e-12_wp*maxval(abs(right))) return
         free(entering) = .true.
         do
            call solve_for_set(normal, right, free, trial)
            if (all(trial > 0.0_wp .or. .not. free)) exit
            ! The first unknown that becomes zero ends the step and is removed from the set.
            fraction = minval(x/(x - trial), mask=free .and. trial <= 0.0_wp)
            x = x + fraction*(trial - x)
            free = free .and. x > epsilon(1.0_wp)*maxval(x)
            where (.not. free) x = 0.0_wp
         end do
         x = trial
      end do
   end subroutine nonnegative_least_squares

   !> Solve the normal equations of the free unknowns; set the other unknowns to zero.
   subroutine solve_for_set(normal, right, free, x)
      real(wp), intent(in) :: normal(:,:), right(:)  !< AᵀA, Aᵀb
      logical, intent(in) :: free(:)                 !< unknowns of the set
      real(wp), intent(out) :: x(:)
      real(wp) :: matrix(count(free), count(free)), solution(count(free), 1)
      integer :: n, info, i, j
      integer :: at(count(free))

      n = count(free)
      at = pack([(i, i=1, size(free))], free)
      do j = 1, n
         matrix(:, j) = normal(at, at(j))
      end do
      solution(:, 1) = right(at)
      call dposv('L', n, 1, matrix, n, solution, n, info)
      x = 0.0_wp
      if (info == 0) x(at) = solution(:, 1)
   end subroutine solve_for_set

end module dda_nonnegative
