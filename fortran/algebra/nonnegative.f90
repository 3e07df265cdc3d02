! SPDX-License-Identifier: GPL-3.0-or-later
!> Least squares with nonnegative unknowns (Lawson and Hanson 1974, chapter 23).
!>
!> The least-squares problem of each active set is solved by normal equations: for few unknowns.
module dda_nonnegative
   use dda_kinds, only: wp
   use dda_lapack, only: dposv
   implicit none
   private
   public :: solve_nonnegative

contains

   !> Minimise |A x − b|² over x ≥ 0.
   subroutine solve_nonnegative(a, b, x)
      real(wp), intent(in) :: a(:,:)   !< [m,n] A, m ≥ n, with independent columns
      real(wp), intent(in) :: b(:)     !< [m] right-hand side
      real(wp), intent(out) :: x(:)    !< [n] vector
      real(wp) :: normal(size(x), size(x)), rhs(size(x)), slope(size(x)), trial(size(x))
      real(wp) :: fraction
      logical :: is_free(size(x))
      integer :: i, entering

      normal = matmul(transpose(a), a)
      rhs = matmul(transpose(a), b)
      x = 0.0_wp
      is_free = .false.
      do i = 1, 10*size(x)
         slope = rhs - matmul(normal, x)
         entering = maxloc(slope, 1, mask=.not. is_free)
         if (entering == 0) return
         if (slope(entering) <= 1.0e-12_wp*maxval(abs(rhs))) return
         is_free(entering) = .true.
         do
            call solve_for_set(normal, rhs, is_free, trial)
            if (all(trial > 0.0_wp .or. .not. is_free)) exit
            ! The first unknown that becomes zero ends the step and is removed from the set.
            fraction = minval(x/(x - trial), mask=is_free .and. trial <= 0.0_wp)
            x = x + fraction*(trial - x)
            is_free = is_free .and. x > epsilon(1.0_wp)*maxval(x)
            where (.not. is_free) x = 0.0_wp
         end do
         x = trial
      end do
   end subroutine solve_nonnegative

   !> Solve the normal equations of the free unknowns; set the other unknowns to zero.
   subroutine solve_for_set(normal, rhs, is_free, x)
      real(wp), intent(in) :: normal(:,:), rhs(:)  !< AᵀA, Aᵀb
      logical, intent(in) :: is_free(:)                 !< unknowns of the set
      real(wp), intent(out) :: x(:)
      real(wp) :: matrix(count(is_free), count(is_free)), solution(count(is_free), 1)
      integer :: n, info, i, j
      integer :: at(count(is_free))

      n = count(is_free)
      at = pack([(i, i=1, size(is_free))], is_free)
      do j = 1, n
         matrix(:, j) = normal(at, at(j))
      end do
      solution(:, 1) = rhs(at)
      call dposv('L', n, 1, matrix, n, solution, n, info)
      x = 0.0_wp
      if (info == 0) x(at) = solution(:, 1)
   end subroutine solve_for_set

end module dda_nonnegative
