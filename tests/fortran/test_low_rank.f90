! SPDX-License-Identifier: GPL-3.0-or-later
!> A factor updated for added and removed springs, against the changed matrix.
module test_low_rank
   use dda_kinds, only: wp
   use dda_block_matrix, only: block_matrix_type, multiply, set_pattern
   use dda_low_rank, only: rebuild_low_rank, update_low_rank
   use dda_rank_one, only: add_change, forget_changes, most_changes, rank_one_type
   use dda_linear_solver, only: analyse, choose_solver, renew, solve, solver_type
   use dda_lagged_factor, only: analyse_lagged, refactorise, lagged_factor_type
   use systems, only: add_spring, diagonal_of
   use models, only: random, random_vector
   use testing, only: case, check, check_no_error, error
   !$ use omp_lib, only: omp_get_max_threads, omp_set_num_threads
   implicit none

   real(wp), parameter :: stiff = 1.0e4_wp   !< of a spring, where each block is held by 1 to 2
   type(block_matrix_type) :: matrix
   type(lagged_factor_type), allocatable :: lagged
   type(rank_one_type) :: changes
   logical :: success

contains

   subroutine any_number_of_changes()
      integer, parameter :: counts(6) = [1, 15, 16, 17, 90, most_changes]
      integer :: i

      do i = 1, size(counts)
         call follows(12, 9, counts(i), 1)
         call follows(40, 30, counts(i), min(4, counts(i)))
      end do
   end subroutine any_number_of_changes

   !> A wall of blocks on soft supports, joined to neighbours by some stiff springs; the matrix
   !> is not factorised.
   subroutine wall(columns, rows, matrix)
      integer, intent(in) :: columns, rows
      type(block_matrix_type), intent(out) :: matrix
      integer :: pairs(2, 2*columns*rows), i, j, n, k

      n = 0
      do j = 1, rows
         do i = 1, columns
            if (i < columns) call add_pair(i + columns*(j - 1), i + 1 + columns*(j - 1))
            if (j < rows) call add_pair(i + columns*(j - 1), i + columns*j)
         end do
      end do
      call set_pattern(matrix, columns*rows, pairs(:, :n))
      do i = 1, columns*rows
         do k = 1, 6
            matrix%diagonal(k, k, i) = random(1.0_wp, 2.0_wp)
         end do
      end do
      do i = 1, n
         do k = 1, 3
            call add_spring(matrix, pairs(1, i), pairs(2, i), random_vector(6), random_vector(6), &
               stiff)
         end do
      end do
      call forget_changes(changes)
      if (allocated(lagged)) deallocate (lagged)
      allocate (lagged)
   contains
      subroutine add_pair(a, b)
         integer, intent(in) :: a, b

         n = n + 1
         pairs(:, n) = [a, b]
      end subroutine add_pair
   end subroutine wall

   !> A wall, and a factor of its matrix.
   subroutine factor_wall(columns, rows)
      integer, intent(in) :: columns, rows

      call wall(columns, rows, matrix)
      call analyse_lagged(lagged, matrix)
      call refactorise(lagged, matrix, error, .false.)
      call check_no_error(error, 'the factor')
   end subroutine factor_wall

   !> Put some springs between neighbours into a matrix, and note them.
   subroutine change(matrix, changes, count)
      type(block_matrix_type), intent(inout) :: matrix
      type(rank_one_type), intent(inout) :: changes
      integer, intent(in) :: count
      real(wp) :: a(6), b(6)
      integer :: i, row, e

      do i = 1, count
         row = 1
         do while (matrix%row_start(row) == matrix%row_start(row + 1))
            row = 1 + int(random(0.0_wp, 0.999_wp)*matrix%n)
         end do
         e = matrix%row_start(row)
         a = random_vector(6)
         b = random_vector(6)
         if (modulo(i, 2) == 0) then
            call exchange(row, matrix%column(e))
         else
            call exchange(matrix%column(e), row)
         end if
      end do
   contains
      subroutine exchange(from, to)
         integer, intent(in) :: from, to

         call add_spring(matrix, from, to, a, b, stiff)
         call add_change(changes, from, a, to, b, stiff)
      end subroutine exchange
   end subroutine change

   !> A preconditioner that has followed all changes is the inverse of the changed matrix, to single
   !> precision.
   subroutine follows(columns, rows, count, parts)
      integer, intent(in) :: columns, rows, count
      integer, intent(in) :: parts  !< in which the changes come
      integer :: n_parts

      call case('springs put in')
      call factor_wall(columns, rows)
      do n_parts = 1, parts
         call forget_changes(changes)
         call change(matrix, changes, n_parts*count/parts - (n_parts - 1)*count/parts)
         call update_low_rank(lagged%update, lagged%factor, changes, success)
         call check(success, 'followed')
         call check_inverse(lagged, matrix)
      end do
      call check(lagged%update%terms%n == count, 'all springs')
   end subroutine follows

   !> P⁻¹ A x is x, as far as single precision can tell.
   subroutine check_inverse(lagged, matrix)
      type(lagged_factor_type), intent(inout) :: lagged
      type(block_matrix_type), intent(in) :: matrix
      ! rounding in single precision gives 5e-4 to 2e-3
      real(wp), parameter :: tolerance = 1.0e-2_wp
      real(wp) :: x(6, matrix%n), image(6, matrix%n), recovered(6, matrix%n)

      x = reshape(random_vector(6*matrix%n), [6, matrix%n])
      call multiply(matrix, x, image)
      call lagged%apply(matrix%n, image, recovered)
      call check(norm2(recovered - x) <= tolerance*norm2(x), 'the inverse of the changed matrix')
   end subroutine check_inverse

   !> Springs between blocks that nothing coupled are followed as well; the next factor is planned
   !> with them, and so are updates of that one.
   subroutine springs_where_none_were()
      integer :: round

      call wall(40, 30, matrix)
      matrix%lower(:, :, ::2) = 0.0_wp
      call analyse_lagged(lagged, matrix)
      do round = 1, 2
         call refactorise(lagged, matrix, error, .false.)
         call check_no_error(error, 'the factor')
         call check(lagged%factor%replanned, 'planned')
         call check_inverse(lagged, matrix)
         call forget_changes(changes)
         call change(matrix, changes, 40)
         call update_low_rank(lagged%update, lagged%factor, changes, success)
         call check(success, 'followed')
         call check_inverse(lagged, matrix)
      end do
   end subroutine springs_where_none_were

   !> Removal of springs restores the first matrix; springs added again, after a small change of
   !> geometry, need no further column and no correction.
   subroutine added_and_removed_springs()
      type(block_matrix_type) :: matrix, first
      type(rank_one_type) :: reversed

      call wall(20, 15, matrix)
      first = matrix
      call change(matrix, changes, 60)
      call analyse_lagged(lagged, matrix)
      call refactorise(lagged, matrix, error, .false.)
      reversed = changes
      reversed%k = -reversed%k
      call update_low_rank(lagged%update, lagged%factor, reversed, success)
      call check(success, 'taken out')
      call check_inverse(lagged, first)
      changes%u = (1.0_wp + 1.0e-5_wp)*changes%u
      call update_low_rank(lagged%update, lagged%factor, changes, success)
      call check(success, 'put in again')
      call check(lagged%update%terms%n == 60 .and. lagged%update%n == 0, 'the same columns')
      call check_inverse(lagged, matrix)
   end subroutine added_and_removed_springs

   !> Too many changes are rejected.
   subroutine too_many_changes()
      call factor_wall(12, 9)
      call change(matrix, changes, most_changes + 1)
      call check(changes%n == most_changes + 1, 'counted')
      call update_low_rank(lagged%update, lagged%factor, changes, success)
      call check(.not. success, 'refused')
      call forget_changes(changes)
      call change(matrix, changes, most_changes - 3)
      call update_low_rank(lagged%update, lagged%factor, changes, success)
      call check(success, 'the most')
      call forget_changes(changes)
      call change(matrix, changes, 4)
      call update_low_rank(lagged%update, lagged%factor, changes, success)
      call check(.not. success, 'one more')
   end subroutine too_many_changes

   !> A spring that does not exist cannot be removed.
   subroutine removal_of_a_missing_spring()
      call factor_wall(12, 9)
      call add_change(changes, 5, random_vector(6), 6, random_vector(6), -100.0_wp*stiff)
      call update_low_rank(lagged%update, lagged%factor, changes, success)
      call check(.not. success, 'refused')
   end subroutine removal_of_a_missing_spring

   !> The bits do not depend on threads or on the partition of the changes.
   subroutine the_same_bits_on_1_to_4_threads_in_one_or_three_parts()
      real(wp), allocatable :: b(:,:), one_thread(:,:), many_threads(:,:)
      integer :: n_before, threads, n_parts

      n_before = 1
      !$ n_before = omp_get_max_threads()
      call wall(60, 40, matrix)
      allocate (b(6, matrix%n), one_thread(6, matrix%n), many_threads(6, matrix%n))
      b = reshape(random_vector(6*matrix%n), [6, matrix%n])
      call analyse_lagged(lagged, matrix)
      call refactorise(lagged, matrix, error, .false.)
      call check(lagged%factor%plan%sharing%is_shared, 'large enough for threads')
      do n_parts = 1, 3
         call forget_changes(changes)
         call change(matrix, changes, 25)
         call update_low_rank(lagged%update, lagged%factor, changes, success)
      end do
      call lagged%apply(matrix%n, b, one_thread)
      do threads = 1, 4
         !$ call omp_set_num_threads(threads)
         call rebuild_low_rank(lagged%update, lagged%factor, 1, success)
         call check(success, 'followed again')
         call lagged%apply(matrix%n, b, many_threads)
         call check(all(abs(one_thread - many_threads) <= 0.0_wp), 'the same bits')
      end do
      !$ call omp_set_num_threads(n_before)
   end subroutine the_same_bits_on_1_to_4_threads_in_one_or_three_parts

   !> The solver follows changes without a new factor, and needs no more iterations than with one.
   subroutine the_lagged_solver_updates_its_factor()
      type(solver_type) :: solver
      real(wp), allocatable :: b(:,:), x(:,:), image(:,:)
      integer :: round

      call wall(20, 15, matrix)
      allocate (b(6, matrix%n), x(6, matrix%n), image(6, matrix%n))
      b = reshape(random_vector(6*matrix%n), [6, matrix%n])
      call choose_solver(solver, 'lagged', error)
      call analyse(solver, matrix)
      call renew(solver, matrix, diagonal_of(matrix), changes, error)
      do round = 1, 8
         call forget_changes(changes)
         call change(matrix, changes, 30)
         call renew(solver, matrix, diagonal_of(matrix), changes, error)
         x = 0.0_wp
         call solve(solver, matrix, b, x, error)
         call check_no_error(error, 'lagged')
         call multiply(matrix, x, image)
         call check(norm2(image - b) <= 1.0e-9_wp*norm2(b), 'the residual')
         call check(solver%last_iterations <= 6, 'few iterations')
      end do
      call check(solver%factors == 2, 'a new factor only where 160 springs are passed')
   end subroutine the_lagged_solver_updates_its_factor

end module test_low_rank
