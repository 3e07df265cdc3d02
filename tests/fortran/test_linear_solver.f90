! SPDX-License-Identifier: GPL-3.0-or-later
!> The solvers with one interface: each method against the direct one, the change of method after
!> a failure, and the message if all methods fail.
module test_linear_solver
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use dda_kinds, only: wp
   use dda_abstract_solver, only: equations_type
   use dda_band_matrix, only: band_type, order_band
   use dda_block_matrix, only: block_matrix_type, multiply, set_pattern
   use dda_errors, only: error_input, error_solver
   use dda_compact_block, only: compact, compact_size
   use dda_rank_one, only: most_changes, rank_one_type
   use dda_linear_solver, only: analyse, choose_solver, renew, reuse_factor, solve, solve_change, &
      solver_names, solver_type, weigh_loads
   use systems, only: add_spring, diagonal_of
   use models, only: random_vector, sow
   use testing, only: case, check, check_fails, check_no_error, error
   implicit none

   !> Equations of the present chain.
   type, extends(equations_type) :: chain_type
      real(wp), allocatable :: b(:,:)
   contains
      procedure :: residual => chain_residual
   end type chain_type

   type(block_matrix_type) :: matrix
   type(solver_type) :: solver

contains

   subroutine every_solver()
      integer :: i

      do i = 1, size(solver_names)
         call case('solver '//trim(solver_names(i)))
         call solves(trim(solver_names(i)), 80, 1.0_wp)
         call solves(trim(solver_names(i)), 7, 1.0_wp)
         call follows(trim(solver_names(i)))
         call no_numbers(trim(solver_names(i)))
         call no_pivot(trim(solver_names(i)))
      end do
   end subroutine every_solver

   subroutine an_unknown_solver()
      call choose_solver(solver, 'magic', error)
      call check_fails(error, "'magic'")
      if (allocated(error)) call check(error%kind == error_input, 'its kind')
   end subroutine an_unknown_solver

   !> Any numbering of a chain has a band one block wide.
   subroutine a_chain_numbered_at_random()
      type(band_type) :: factor

      call set_pattern(matrix, 7, reshape([4, 1, 1, 6, 6, 2, 2, 7, 7, 3, 3, 5], [2, 6]))
      call order_band(factor, matrix)
      call check(factor%half_width == 11, 'half width 11')
   end subroutine a_chain_numbered_at_random

   !> A chain of blocks joined by stiff springs; `own_stiffness` holds each block alone.
   subroutine chain(n, own_stiffness)
      integer, intent(in) :: n
      real(wp), intent(in) :: own_stiffness
      integer :: pairs(2, n - 1), i, k

      do i = 1, n - 1
         pairs(:, i) = [i, i + 1]
      end do
      call set_pattern(matrix, n, pairs)
      call sow(n)
      do i = 1, n
         do k = 1, 6
            matrix%diagonal(k, k, i) = own_stiffness
         end do
      end do
      do i = 1, n - 1
         call add_springs(i, 2)
      end do
   end subroutine chain

   !> Add springs for elongations a·(d_i − d_(i+1)).
   subroutine add_springs(i, count)
      integer, intent(in) :: i, count
      real(wp) :: a(6)
      integer :: k

      do k = 1, count
         a = random_vector(6)
         call add_spring(matrix, i, i + 1, a, a, 10.0_wp)
      end do
   end subroutine add_springs

   subroutine prepare(name)
      character(len=*), intent(in) :: name

      call choose_solver(solver, name, error)
      call check_no_error(error, name)
      call analyse(solver, matrix)
      call renew(solver, matrix, diagonal_of(matrix), rank_one_type(), error)
   end subroutine prepare

   subroutine solves(name, n, own_stiffness)
      character(len=*), intent(in) :: name
      integer, intent(in) :: n
      real(wp), intent(in) :: own_stiffness
      real(wp) :: b(6, n)

      call chain(n, own_stiffness)
      b = reshape(random_vector(6*n), [6, n])
      call prepare(name)
      call check_no_error(error, name)
      call check_solution(b, 1.0e-8_wp)
   end subroutine solves

   !> Solve K x = b from x = 0; the residual must be a small part of b.
   subroutine check_solution(b, tolerance_factor)
      real(wp), intent(in) :: b(:,:), tolerance_factor
      real(wp) :: x(6, matrix%n), image(6, matrix%n)

      x = 0.0_wp
      call solve(solver, matrix, b, x, error)
      call check_no_error(error, solver%method)
      call multiply(matrix, x, image)
      call check(norm2(image - b) <= tolerance_factor*norm2(b), solver%method//': the residual')
   end subroutine check_solution

   !> The solution follows a change of the right-hand side: with a good factor at one application,
   !> with one that lags so far behind that the last solve took more by another solve.
   subroutine follows(name)
      character(len=*), intent(in) :: name
      integer, parameter :: n = 80
      real(wp), parameter :: coarse_tolerance = 1.0e-2_wp
      real(wp) :: x(6, n), b(6, n), image(6, n), change(6, n)
      integer :: pass

      call case('a change of the right-hand side, '//name)
      call chain(n, 1.0_wp)
      call prepare(name)
      b = reshape(random_vector(6*n), [6, n])
      x = 0.0_wp
      do pass = 1, 2
         call solve(solver, matrix, b, x, error, coarse_tolerance)
         call check_no_error(error, name)
         call multiply(matrix, x, image)
         change = reshape(random_vector(6*n), [6, n]) + (b - image)
         b = image + change
         call solve_change(solver, matrix, b, change, x, error, coarse_tolerance)
         call check_no_error(error, name)
         call multiply(matrix, x, image)
         call check(norm2(image - b) <= coarse_tolerance*norm2(change), name//': the residual')
         ! half the blocks are held so much more firmly that the factor is no good any more
         matrix%diagonal(:, :, ::2) = 1.0e2_wp*matrix%diagonal(:, :, ::2)
         call renew(solver, matrix, diagonal_of(matrix), rank_one_type(), error)
         call check_no_error(error, name)
      end do
   end subroutine follows

   !> Numbers that single precision cannot hold: the lagged factor hands over to the direct solver.
   subroutine beyond_single_precision()
      use, intrinsic :: ieee_exceptions, only: ieee_all, ieee_set_halting_mode  ! restored on return
      integer, parameter :: n = 70

      call ieee_set_halting_mode(ieee_all, .false.)
      call chain(n, 1.0_wp)
      matrix%diagonal = 1.0e60_wp*matrix%diagonal
      matrix%lower = 1.0e60_wp*matrix%lower
      call prepare('lagged')
      call check_no_error(error, 'lagged')
      call check_solution(spread([real(wp) :: 1, 1, 1, 1, 1, 1], 2, n), 1.0e-8_wp)
      call check(solver%repeated_directly == 1 .and. solver%method == 'direct', 'handed over')
   end subroutine beyond_single_precision

   !> A chain on supports so soft that single precision loses a pivot: a larger diagonal in the
   !> factor, with more iterations, still solves the system, but not repeatedly, and not if double
   !> precision retains only a few digits.
   subroutine a_pivot_lost_to_single_precision()
      integer, parameter :: n = 70
      real(wp) :: b(6, n), diagonal(compact_size, n)
      integer :: i

      call stiff_chain(n, 1.0e-7_wp, diagonal)
      b = reshape(random_vector(6*n), [6, n])
      call choose_solver(solver, 'lagged', error)
      call analyse(solver, matrix)
      do i = 1, 3
         call renew_all(diagonal)
         call check_no_error(error, 'lagged')
         call check_solution(b, 1.0e-6_wp)
         call check(solver%repeated_directly == merge(1, 0, i > 2), 'handed over at the third time')
      end do
      call stiff_chain(n, 1.0e-10_wp, diagonal)
      call choose_solver(solver, 'lagged', error)
      call analyse(solver, matrix)
      call renew_all(diagonal)
      call check(solver%repeated_directly == 1 .and. solver%method == 'direct', &
         'handed over at once')
   end subroutine a_pivot_lost_to_single_precision

   !> A chain with only rigid-body modes, and the springs that hold each block.
   subroutine stiff_chain(n, own_stiffness, diagonal)
      integer, intent(in) :: n
      real(wp), intent(in) :: own_stiffness
      real(wp), intent(out) :: diagonal(compact_size, n)
      real(wp) :: block(6, 6)
      integer :: i, k

      call chain(n, own_stiffness)
      do i = 1, n - 1
         call add_springs(i, 6)
      end do
      block = 0.0_wp
      do k = 1, 6
         block(k, k) = own_stiffness
      end do
      diagonal = spread(compact(block), 2, n)
   end subroutine stiff_chain

   !> All values are others: the factor that there was will not do.
   subroutine renew_all(diagonal)
      real(wp), intent(in) :: diagonal(compact_size, matrix%n)
      type(rank_one_type) :: changes

      changes%n = most_changes + 1
      call renew(solver, matrix, diagonal, changes, error)
   end subroutine renew_all

   !> A factor so old that the iterations with it fail is made again.
   subroutine a_factor_that_is_too_old()
      integer, parameter :: n = 70
      real(wp) :: x(6, n), b(6, n)

      call chain(n, 1.0_wp)
      b = reshape(random_vector(6*n), [6, n])
      x = 0.0_wp
      call prepare('lagged')
      matrix%diagonal(:, :, ::2) = 1.0e7_wp*matrix%diagonal(:, :, ::2)
      call renew(solver, matrix, diagonal_of(matrix), rank_one_type(), error)
      call solve(solver, matrix, b, x, error)
      call check_no_error(error, 'lagged')
      call check(solver%method == 'lagged' .and. solver%factors == 2, 'a second factor')
   end subroutine a_factor_that_is_too_old

   !> A reused factor yields a small residual, also if the guess has a small error that only inertia
   !> restrains, and large errors of free coordinates; a factor of another matrix is discarded.
   subroutine a_factor_is_reused()
      integer, parameter :: n = 100
      type(chain_type) :: equations
      real(wp) :: x(6, n), r(6, n)
      real(wp), parameter :: stiffness(3) = [1.0e5_wp, 1.0e6_wp, 1.0e7_wp], solution = 1.0e-3_wp
      logical :: success
      integer :: i

      do i = 1, size(stiffness)
         call chain_along_x(n, stiffness(i))
         call prepare('lagged')
         allocate (equations%b(6, n))
         x = solution
         call multiply(matrix, x, equations%b)
         x(1, :) = x(1, :) + 1.0e-2_wp/stiffness(i)
         x(2, :) = x(2, :) + 1.0e-4_wp*random_vector(n)
         call weigh_loads(solver, equations%b)
         call reuse_factor(solver, equations, x, 0.0_wp, success)
         call equations%residual(x, r)
         call check(success .or. i > 1, 'the factor suffices for the softest chain')
         call check(.not. success .or. norm2(r) <= 1.0e-11_wp*norm2(equations%b), &
            'success is a small residual')
         deallocate (equations%b)
      end do
      matrix%diagonal(:, :, ::2) = 1.0e7_wp*matrix%diagonal(:, :, ::2)
      equations%b = reshape(random_vector(6*n), [6, n])
      call reuse_factor(solver, equations, x, 0.0_wp, success)
      call check(.not. success, 'a factor of another matrix')
      call reuse_factor(solver, equations, x, 0.0_wp, success)
      call check(.not. success .and. solver%active%iterations == 0, 'it is not used again')
   end subroutine a_factor_is_reused

   !> After a solve for one coordinate, another coordinate with a poorer factor and a negligible
   !> residual is corrected twice.
   subroutine a_poorer_direction_is_corrected_again()
      integer, parameter :: n = 100
      real(wp), parameter :: stiff = 1.0e7_wp, large = 1.0e2_wp, small = 1.0e-2_wp
      type(chain_type) :: equations
      real(wp) :: x(6, n)
      logical :: success

      call chain_along_x(n, 0.0_wp)
      matrix%diagonal(1, 1, :) = stiff
      call prepare('lagged')
      matrix%diagonal(2, 2, :) = 1.001_wp
      allocate (equations%b(6, n), source=0.0_wp)
      equations%b(1, :) = stiff*large
      x = 0.0_wp
      call weigh_loads(solver, equations%b)
      call reuse_factor(solver, equations, x, 0.0_wp, success)
      call check(success, 'the stiff coordinate')
      equations%b(2, :) = 1.001_wp*small
      call reuse_factor(solver, equations, x, 0.0_wp, success)
      call check(success .and. maxval(abs(x(2, :) - small)) < 1.0e-4_wp*small, 'the soft one')
   end subroutine a_poorer_direction_is_corrected_again

   !> A chain of unit masses joined by springs along x.
   subroutine chain_along_x(n, stiffness)
      integer, intent(in) :: n
      real(wp), intent(in) :: stiffness
      real(wp), parameter :: x_axis(6) = [1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp]
      integer :: i

      call chain(n, 1.0_wp)
      matrix%lower = 0.0_wp
      matrix%diagonal = 0.0_wp
      do i = 1, 6
         matrix%diagonal(i, i, :) = 1.0_wp
      end do
      do i = 1, n - 1
         call add_spring(matrix, i, i + 1, x_axis, x_axis, stiffness)
      end do
   end subroutine chain_along_x

   !> Residual of the chain.
   subroutine chain_residual(self, x, r)
      class(chain_type), intent(in) :: self
      real(wp), intent(in), contiguous :: x(:,:)
      real(wp), intent(out), contiguous :: r(:,:)

      call multiply(matrix, x, r)
      r = self%b - r
   end subroutine chain_residual

   !> If diagonal blocks require many iterations, `auto` changes to a factor.
   subroutine slow_iterations_with_the_diagonal_blocks()
      integer, parameter :: n = 80
      real(wp) :: x(6, n), b(6, n)

      call chain(n, 1.0e4_wp)
      call prepare('auto')
      call check(solver%method == 'jacobi', 'a good matrix')
      call chain(n, 1.0e-3_wp)
      b = reshape(random_vector(6*n), [6, n])
      x = 0.0_wp
      call renew(solver, matrix, diagonal_of(matrix), rank_one_type(), error)
      call check(solver%method == 'jacobi', 'not yet known')
      call solve(solver, matrix, b, x, error)
      call check_no_error(error, 'jacobi')
      call renew(solver, matrix, diagonal_of(matrix), rank_one_type(), error)
      call check(solver%method == 'lagged', 'a matrix that was slow')
      call check_solution(b, 1.0e-8_wp)
   end subroutine slow_iterations_with_the_diagonal_blocks

   !> A NaN in the right-hand side must not yield a solution.
   subroutine no_numbers(name)
      use, intrinsic :: ieee_exceptions, only: ieee_all, ieee_set_halting_mode  ! restored on return
      character(len=*), intent(in) :: name
      integer, parameter :: n = 70
      real(wp) :: x(6, n), b(6, n)

      call case('no number on the right, '//name)
      call ieee_set_halting_mode(ieee_all, .false.)
      call chain(n, 1.0_wp)
      b = 1.0_wp
      b(3, 5) = ieee_value(1.0_wp, ieee_quiet_nan)
      x = 0.0_wp
      call prepare(name)
      call solve(solver, matrix, b, x, error)
      call check_fails(error, 'cannot be solved')
      if (allocated(error)) call check(error%kind == error_solver, 'its kind')
   end subroutine no_numbers

   !> A matrix that is not definite is refused; conjugate gradients may be lucky, and must then be
   !> right.
   subroutine no_pivot(name)
      use, intrinsic :: ieee_exceptions, only: ieee_all, ieee_set_halting_mode  ! restored on return
      character(len=*), intent(in) :: name
      integer, parameter :: n = 70
      real(wp) :: x(6, n), b(6, n), image(6, n)

      call case('no positive pivot, '//name)
      call ieee_set_halting_mode(ieee_all, .false.)  ! iterations may diverge
      call chain(n, 1.0_wp)
      matrix%diagonal(:, :, 40) = -matrix%diagonal(:, :, 40)
      b = 1.0_wp
      x = 0.0_wp
      call prepare(name)
      if (.not. allocated(error)) call solve(solver, matrix, b, x, error)
      if (allocated(error)) then
         call check_fails(error, 'positive')
         call check(error%kind == error_solver, 'its kind')
      else
         call multiply(matrix, x, image)
         call check(norm2(image - b) <= 1.0e-8_wp*norm2(b), 'a right solution')
      end if
   end subroutine no_pivot

end module test_linear_solver
