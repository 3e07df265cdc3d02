! SPDX-License-Identifier: GPL-3.0-or-later
!> The solver interface.
module test_solver_interface
   use dda_kinds, only: wp
   use dda_band_matrix, only: band_type, order_band
   use dda_block_matrix, only: block_matrix_type, set_pattern
   use dda_errors, only: error_input
   use dda_rank_one, only: rank_one_type
   use dda_linear_solver, only: analyse, choose_solver, renew, solve, solver_names, solver_type
   use systems, only: diagonal_of
   use models, only: random_vector
   use testing, only: case, check, check_close, check_fails, check_no_error, error
   implicit none

contains

   !> Any numbering of a chain has a band one block wide.
   subroutine a_chain_numbered_at_random()
      type(band_type) :: factor
      type(block_matrix_type) :: matrix

      call set_pattern(matrix, 7, reshape([4, 1, 1, 6, 6, 2, 2, 7, 7, 3, 3, 5], [2, 6]))
      call order_band(factor, matrix)
      call check(factor%half_width == 11, 'half width 11')
   end subroutine a_chain_numbered_at_random

   !> Random values, made definite by the diagonal.
   subroutine fill_definite(matrix, dense)
      type(block_matrix_type), intent(inout) :: matrix
      real(wp), intent(out) :: dense(:,:)
      real(wp) :: block(6, 6)
      integer :: i, e, k, r, c

      dense = 0.0_wp
      do i = 1, matrix%n
         r = 6*i - 5
         block = reshape(random_vector(36), [6, 6])
         block = matmul(block, transpose(block))
         do k = 1, 6
            block(k, k) = block(k, k) + 6.0_wp*(1.0_wp + real(count_row(matrix, i), wp))
         end do
         matrix%diagonal(:, :, i) = block
         dense(r:r + 5, r:r + 5) = block
         do e = matrix%row_start(i), matrix%row_start(i + 1) - 1
            c = 6*matrix%column(e) - 5
            matrix%lower(:, :, e) = reshape(random_vector(36), [6, 6])
            dense(r:r + 5, c:c + 5) = matrix%lower(:, :, e)
            dense(c:c + 5, r:r + 5) = transpose(matrix%lower(:, :, e))
         end do
      end do
   end subroutine fill_definite

   !> How many blocks row i is coupled to.
   pure integer function count_row(matrix, i)
      type(block_matrix_type), intent(in) :: matrix
      integer, intent(in) :: i

      count_row = matrix%row_start(i + 1) - matrix%row_start(i) + count(matrix%column == i)
   end function count_row

   !> Every solver gives the same solution, with new values too.
   subroutine solver_interface()
      type(solver_type) :: solver
      integer :: k

      call case('the solver interface')
      call choose_solver(solver, 'no such one', error)
      call check_fails(error, 'no such one')
      if (allocated(error)) call check(error%kind == error_input, 'its kind')
      do k = 1, size(solver_names)
         call case('solver '//solver_names(k))
         call choose_solver(solver, trim(solver_names(k)), error)
         call check_no_error(error, 'is known')
         call try_solver(solver)
      end do
   end subroutine solver_interface

   subroutine try_solver(solver)
      type(solver_type), intent(inout) :: solver
      type(block_matrix_type) :: matrix
      real(wp) :: dense(24, 24), b(6, 4), x(6, 4)
      integer :: pass

      call set_pattern(matrix, 4, reshape([1, 2, 2, 4, 4, 3], [2, 3]))
      call analyse(solver, matrix)
      x = 0.0_wp
      do pass = 1, 3
         call fill_definite(matrix, dense)
         b = reshape(random_vector(24), [6, 4])
         call renew(solver, matrix, diagonal_of(matrix), rank_one_type(), error)
         call check_no_error(error, 'takes the values')
         call solve(solver, matrix, b, x, error)
         call check_no_error(error, 'solves')
         call check_close(matmul(dense, reshape(x, [24])), reshape(b, [24]), 'K x = b', &
            relative=1.0e-9_wp)
      end do
   end subroutine try_solver

end module test_solver_interface
