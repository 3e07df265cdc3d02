! SPDX-License-Identifier: GPL-3.0-or-later
!> The sparse factor against dense LAPACK, and against itself on another number of threads.
module test_block_cholesky
   use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value
   use dda_kinds, only: wp
   use dda_block_graph, only: block_graph_type, graph_of
   use dda_block_matrix, only: block_matrix_type, multiply, set_pattern
   use dda_cholesky_double, only: factor_type, analyse, apply, factorise, solve
   use dda_cholesky_single, only: single_factor_type => factor_type, analyse_single => analyse, &
      factorise_single => factorise, solve_single => solve
   use dda_lapack, only: dposv
   use dda_ordering, only: bandwidth_order, dissection_order, fill_order, minimum_degree_order
   use dda_packed_panels, only: packed_size
   use dda_text, only: to_text
   use models, only: random_pairs
   use systems, only: dense_of
   use testing, only: case, check, check_close, check_fails, check_no_error, error
   !$ use omp_lib, only: omp_get_max_threads, omp_set_num_threads
   implicit none

   type(block_matrix_type) :: matrix

contains

   !> Each order is a permutation; Cuthill–McKee narrows the band of a grid.
   subroutine orders_of_elimination()
      type(block_graph_type) :: graph
      integer, allocatable :: order(:)
      logical :: success

      call grid_graph(30, 20, graph)
      call fill_order(graph, order)
      call check_permutation(order, 'fill')
      call minimum_degree_order(graph, order, success)
      call check(success, 'minimum degree does not give up')
      call check_permutation(order, 'minimum degree')
      call dissection_order(graph, order, success)
      call check(success, 'dissection does not give up')
      call check_permutation(order, 'dissection')
      call bandwidth_order(graph, order)
      call check_permutation(order, 'bandwidth')
      call check(bandwidth(graph, order) <= 25, 'the band of a 30 × 20 grid is about 20 wide')
      call set_pattern(matrix, 5, reshape([integer ::], [2, 0]))
      call graph_of(matrix, graph)
      call bandwidth_order(graph, order)
      call check_permutation(order, 'bandwidth without couplings')
   end subroutine orders_of_elimination

   !> Patterns of one idea each.
   subroutine test_small_patterns()
      integer :: i

      call case('no block')
      call check_against_dense(0, reshape([integer ::], [2, 0]))
      call case('one block')
      call check_against_dense(1, reshape([integer ::], [2, 0]))
      call case('two blocks')
      call check_against_dense(2, reshape([1, 2], [2, 1]))
      call case('two blocks apart')
      call check_against_dense(2, reshape([integer ::], [2, 0]))
      call case('diagonal only')
      call check_against_dense(40, reshape([integer ::], [2, 0]))
      call case('chain')
      call check_against_dense(16, reshape([(i, i + 1, i=1, 15)], [2, 15]))
      call case('chain backwards and apart')
      call check_against_dense(12, reshape([(13 - i, 12 - i, i=1, 5), (i, i + 1, i=1, 5)], [2, 10]))
      call case('arrow with its point first')
      call check_against_dense(30, reshape([(1, i, i=2, 30)], [2, 29]))
      call case('arrow with its point last')
      call check_against_dense(30, reshape([(i, 30, i=1, 29)], [2, 29]))
      call case('dense')
      call check_against_dense(25, all_pairs(25))
   end subroutine test_small_patterns

   subroutine random_graphs()
      integer :: degree

      do degree = 1, 6
         call check_against_dense(60, random_pairs(60, 30*degree))
      end do
   end subroutine random_graphs

   !> Wide fronts: several strips, tiles and products.
   subroutine test_grid()
      call check_against_dense(150, grid_pairs(15, 10))
      call check_against_dense(120, all_pairs(120))
   end subroutine test_grid

   !> Many trees and no trunk: shared between threads, nothing on top.
   subroutine test_forest()
      integer, parameter :: trees = 2500
      integer :: i, j

      call check_residuals(5*trees, reshape([((5*j + i, 5*j + i + 1, i=1, 4), j=0, trees - 1)], &
         [2, 4*trees]))
   end subroutine test_forest

   !> A factor serves again, with and without a new analysis.
   subroutine new_values_and_new_pattern()
      type(factor_type) :: factor
      integer :: i

      do i = 1, 2
         call set_pattern(matrix, 20*i, random_pairs(20*i, 40*i))
         call fill_definite(matrix)
         call analyse(factor, matrix)
         call factorise(factor, matrix, error)
         call check_no_error(error, 'first numbers')
         call fill_definite(matrix)
         call factorise(factor, matrix, error)
         call check_no_error(error, 'new numbers')
         call check(residual(factor) < 1.0e-12_wp, 'residual after new numbers')
      end do
   end subroutine new_values_and_new_pattern

   !> Lower blocks that are zero cause no fill.  If nonzero later, the factor is planned again;
   !> this plan is retained if they become zero again.
   subroutine zero_couplings()
      type(factor_type) :: factor
      integer, parameter :: coupled(4) = [3, 1, 3, 5]
      integer :: i

      call set_pattern(matrix, 40, random_pairs(40, 80))
      call fill_definite(matrix)
      matrix%lower = 0.0_wp
      call analyse(factor, matrix)
      call factorise(factor, matrix, error)
      call check_no_error(error, 'diagonal blocks alone')
      call check(size(factor%packed) == packed_size*matrix%n, 'one packed panel for each block')
      call check(residual(factor) < 1.0e-12_wp, 'residual of diagonal blocks alone')
      do i = 1, size(coupled)
         call fill_definite(matrix)
         matrix%lower(:, :, coupled(i) + 1:) = 0.0_wp
         call factorise(factor, matrix, error)
         call check_no_error(error, 'with couplings')
         call check(factor%replanned .eqv. coupled(i) > maxval([0, coupled(:i - 1)]), &
            'planned anew where a coupling has come')
         call check(residual(factor) < 1.0e-12_wp, 'residual with couplings')
      end do
   end subroutine zero_couplings

   !> b and x may hold the same values.
   subroutine solution_in_place()
      type(factor_type) :: factor
      real(wp) :: b(6, 30), x(6, 30)

      call set_pattern(matrix, 30, random_pairs(30, 60))
      call fill_definite(matrix)
      call analyse(factor, matrix)
      call factorise(factor, matrix, error)
      call random_number(b)
      call solve(factor, b, x)
      call solve(factor, (b), b)
      call check(all(abs(b - x) <= 0.0_wp), 'the same values whether or not x was b')
   end subroutine solution_in_place

   !> A coupling that is NaN is not omitted as if it were zero.
   subroutine nan_couplings()
      use, intrinsic :: ieee_exceptions, only: ieee_all, ieee_set_halting_mode  ! restored on return
      type(factor_type) :: factor

      call ieee_set_halting_mode(ieee_all, .false.)
      call set_pattern(matrix, 25, grid_pairs(5, 5))
      call fill_definite(matrix)
      matrix%lower(:, :, 7) = 0.0_wp
      matrix%lower(2, 3, 7) = ieee_value(1.0_wp, ieee_quiet_nan)
      call analyse(factor, matrix)
      call factorise(factor, matrix, error)
      call check_fails(error, 'positive pivot')
   end subroutine nan_couplings

   !> A pivot that is not positive is an error that names the row of blocks.
   subroutine not_positive_definite()
      type(factor_type) :: factor
      type(single_factor_type) :: single_factor
      integer :: failed_row

      do failed_row = 1, 400, 57
         call set_pattern(matrix, 1600, grid_pairs(40, 40))
         call fill_definite(matrix)
         matrix%diagonal(3, 3, failed_row) = -1.0_wp
         call analyse(factor, matrix)
         call factorise(factor, matrix, error)
         call check_fails(error, 'positive pivot')
         call analyse_single(single_factor, matrix)
         call factorise_single(single_factor, matrix, error)
         call check_fails(error, 'positive pivot')
      end do
      call set_pattern(matrix, 3, reshape([integer ::], [2, 0]))
      call fill_definite(matrix)
      matrix%diagonal(:, :, 2) = 0.0_wp
      call analyse(factor, matrix)
      call factorise(factor, matrix, error)
      call check_fails(error, 'row 2 of blocks')
      call fill_definite(matrix)
      call factorise(factor, matrix, error)
      call check_no_error(error, 'the same factor with better numbers')
   end subroutine not_positive_definite

   subroutine pattern_not_analysed()
      type(factor_type) :: factor

      call set_pattern(matrix, 3, reshape([1, 2], [2, 1]))
      call fill_definite(matrix)
      call factorise(factor, matrix, error)
      call check_fails(error, 'analysed')
      call analyse(factor, matrix)
      call set_pattern(matrix, 3, reshape([1, 2, 2, 3], [2, 2]))
      call fill_definite(matrix)
      call factorise(factor, matrix, error)
      call check_fails(error, 'analysed')
   end subroutine pattern_not_analysed

   !> The order of sums does not depend on threads, for any widths of the top fronts.
   subroutine the_same_bits_on_1_to_4_threads()
      integer, parameter :: width(6) = [2, 4, 6, 9, 14, 40]
      integer :: i

      do i = 1, size(width)
         call set_pattern(matrix, 60*width(i)*(60/width(i)), grid_pairs(width(i), 60*(60/width(i))))
         call fill_definite(matrix)
         call check_same_bits(matrix)
      end do
   end subroutine the_same_bits_on_1_to_4_threads

   subroutine check_same_bits(matrix)
      type(block_matrix_type), intent(in) :: matrix
      real(wp) :: b(6, matrix%n), x_one(6, matrix%n), x_many(6, matrix%n)
      integer :: threads, default_threads

      default_threads = 1
      !$ default_threads = omp_get_max_threads()
      call random_number(b)
      !$ call omp_set_num_threads(1)
      call solve_both(matrix, b, x_one)
      do threads = 2, 4
         !$ call omp_set_num_threads(threads)
         call solve_both(matrix, b, x_many)
         call check(all(abs(x_one - x_many) <= 0.0_wp), 'bits differ on '//to_text(threads)// &
            ' threads')
      end do
      !$ call omp_set_num_threads(default_threads)
   end subroutine check_same_bits

   !> The sum of the solutions in both precisions.
   subroutine solve_both(matrix, b, x)
      type(block_matrix_type), intent(in) :: matrix
      real(wp), intent(in) :: b(:,:)
      real(wp), intent(out) :: x(:,:)
      type(factor_type) :: factor
      type(single_factor_type) :: single_factor
      real(wp), allocatable :: y(:,:)

      allocate (y, mold=x)
      call analyse(factor, matrix)
      call analyse_single(single_factor, matrix)
      call factorise(factor, matrix, error)
      call check_no_error(error, 'factor')
      call check(factor%plan%sharing%is_shared, 'large enough for threads')
      call factorise_single(single_factor, matrix, error)
      call check_no_error(error, 'single factor')
      call solve(factor, b, x)
      call solve_single(single_factor, b, y)
      x = x + y
   end subroutine solve_both

   !> Solve a random definite matrix of this pattern with both factors and with LAPACK.
   subroutine check_against_dense(n, pairs)
      integer, intent(in) :: n, pairs(:,:)
      type(factor_type) :: factor
      type(single_factor_type) :: single_factor
      real(wp) :: b(6, n), x(6, n), expected(6*n, 1)
      real(wp), allocatable :: dense(:,:)
      integer :: info, i

      call set_pattern(matrix, n, pairs)
      call fill_definite(matrix)
      dense = dense_of(matrix)
      call random_number(b)
      expected(:, 1) = reshape(b, [6*n])
      call dposv('L', 6*n, 1, dense, max(1, 6*n), expected, max(1, 6*n), info)
      call check(info == 0, 'dense factor')
      call analyse(factor, matrix)
      call factorise(factor, matrix, error)
      call check_no_error(error, 'factor')
      call solve(factor, b, x)
      call check_close(reshape(x, [6*n]), expected(:, 1), 'solution', relative=1.0e-12_wp)
      do i = 1, 41  ! the last one uses inverted fronts
         call apply(factor, b, x)
      end do
      call check(factor%inverted .neqv. factor%plan%sharing%is_shared, 'fronts are inverted')
      call check_close(reshape(x, [6*n]), expected(:, 1), 'products', relative=1.0e-12_wp)
      matrix%diagonal = 2*matrix%diagonal
      matrix%lower = 2*matrix%lower
      call factorise(factor, matrix, error)
      call check_no_error(error, 'factor of the doubled matrix')
      call apply(factor, 2*b, x)
      call check_close(reshape(x, [6*n]), expected(:, 1), 'new factor', relative=1.0e-12_wp)
      do i = 1, 41
         call apply(factor, 2*b, x)
      end do
      call check_close(reshape(x, [6*n]), expected(:, 1), 'new products', relative=1.0e-12_wp)
      call analyse_single(single_factor, matrix)
      call factorise_single(single_factor, matrix, error)
      call check_no_error(error, 'single factor')
      call solve_single(single_factor, 2*b, x)
      call check_close(reshape(x, [6*n]), expected(:, 1), 'single solution', relative=2.0e-5_wp)
   end subroutine check_against_dense

   !> Residuals of both factors for a system that is too large for LAPACK.
   subroutine check_residuals(n, pairs)
      integer, intent(in) :: n, pairs(:,:)
      type(factor_type) :: factor
      type(single_factor_type) :: single_factor
      real(wp) :: b(6, n), x(6, n), kx(6, n)

      call set_pattern(matrix, n, pairs)
      call fill_definite(matrix)
      call analyse(factor, matrix)
      call factorise(factor, matrix, error)
      call check_no_error(error, 'factor')
      call check(factor%plan%sharing%is_shared, 'large enough for threads')
      call check(residual(factor) < 1.0e-13_wp, 'residual')
      call analyse_single(single_factor, matrix)
      call factorise_single(single_factor, matrix, error)
      call check_no_error(error, 'single factor')
      call random_number(b)
      call solve_single(single_factor, b, x)
      call multiply(matrix, x, kx)
      call check(norm2(kx - b) < 5.0e-6_wp*norm2(b), 'single residual')
   end subroutine check_residuals

   !> |K x − b|/|b| of a solution with the factor.
   real(wp) function residual(factor)
      type(factor_type), intent(inout) :: factor
      real(wp) :: b(6, matrix%n), x(6, matrix%n), kx(6, matrix%n)

      call random_number(b)
      call solve(factor, b, x)
      call multiply(matrix, x, kx)
      residual = norm2(kx - b)/norm2(b)
   end function residual

   !> Random numbers, made definite by a heavy diagonal.
   subroutine fill_definite(matrix)
      type(block_matrix_type), intent(inout) :: matrix
      real(wp) :: block(6, 6)
      integer :: i, k, e

      call random_number(matrix%lower)
      matrix%lower = matrix%lower - 0.5_wp
      do i = 1, matrix%n
         call random_number(block)
         matrix%diagonal(:, :, i) = matmul(block, transpose(block))
      end do
      do i = 1, matrix%n
         do e = matrix%row_start(i), matrix%row_start(i + 1) - 1
            do k = 1, 6
               matrix%diagonal(k, k, i) = matrix%diagonal(k, k, i) + 1.5_wp
               matrix%diagonal(k, k, matrix%column(e)) = matrix%diagonal(k, k, matrix%column(e)) &
                  + 1.5_wp
            end do
         end do
         do k = 1, 6
            matrix%diagonal(k, k, i) = matrix%diagonal(k, k, i) + 0.1_wp
         end do
      end do
   end subroutine fill_definite

   function all_pairs(n) result(pairs)
      integer, intent(in) :: n
      integer, allocatable :: pairs(:,:)
      integer :: i, j

      pairs = reshape([((i, j, j=1, i - 1), i=1, n)], [2, n*(n - 1)/2])
   end function all_pairs

   !> Neighbours to the right and above in a grid.
   function grid_pairs(width, height) result(pairs)
      integer, intent(in) :: width, height
      integer, allocatable :: pairs(:,:)
      integer :: i, j

      pairs = reshape([((width*(j - 1) + i, width*(j - 1) + i + 1, i=1, width - 1), j=1, height), &
                       ((width*(j - 1) + i, width*j + i, i=1, width), j=1, height - 1)], &
                      [2, (width - 1)*height + width*(height - 1)])
   end function grid_pairs

   subroutine grid_graph(width, height, graph)
      integer, intent(in) :: width, height
      type(block_graph_type), intent(out) :: graph
      type(block_matrix_type) :: matrix

      call set_pattern(matrix, width*height, grid_pairs(width, height))
      call graph_of(matrix, graph)
   end subroutine grid_graph

   subroutine check_permutation(order, name)
      integer, intent(in) :: order(:)
      character(len=*), intent(in) :: name
      integer :: times(size(order)), k

      times = 0
      call check(all(order >= 1 .and. order <= size(order)), name//' order in range')
      do k = 1, size(order)
         times(order(k)) = times(order(k)) + 1
      end do
      call check(all(times == 1), name//' order is a permutation')
   end subroutine check_permutation

   !> Largest distance between coupled rows in the order.
   integer function bandwidth(graph, order)
      type(block_graph_type), intent(in) :: graph
      integer, intent(in) :: order(:)
      integer :: permuted(size(order)), v, e, k

      permuted(order) = [(k, k=1, size(order))]
      bandwidth = 0
      do v = 1, graph%n
         do e = graph%start(v), graph%start(v + 1) - 1
            bandwidth = max(bandwidth, abs(permuted(v) - permuted(graph%neighbour(e))))
         end do
      end do
   end function bandwidth

end module test_block_cholesky
