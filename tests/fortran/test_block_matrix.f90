! SPDX-License-Identifier: GPL-3.0-or-later
!> The block matrix against the dense matrix that it represents.
module test_block_matrix
   use dda_kinds, only: wp
   use dda_block_matrix, only: block_matrix_type, entry_of, multiply, set_pattern, terms_of_product
   use dda_linear_terms, only: add_parallel_terms, add_term, add_to_matrix, coupled_blocks, &
      instants, linear_term_type, linear_terms_type
   use models, only: random_pairs, random_vector
   use testing, only: case, check, check_close
   implicit none

contains

   subroutine any_pattern()
      integer :: i

      call case('a block alone')
      call try_pattern(1, reshape([integer ::], [2, 0]))
      call case('blocks apart')
      call try_pattern(5, reshape([integer ::], [2, 0]))
      call case('a pair, named twice and backwards')
      call try_pattern(2, reshape([1, 2, 2, 1], [2, 2]))
      call case('random patterns')
      do i = 1, 20
         call try_pattern(4 + i, random_pairs(4 + i, 6*i))
      end do
   end subroutine any_pattern

   subroutine try_pattern(n, pairs)
      integer, intent(in) :: n, pairs(:,:)
      type(block_matrix_type) :: matrix
      logical :: coupled(n, n)
      integer :: p, i, j, entry, n_wrong

      call set_pattern(matrix, n, pairs)
      coupled = .false.
      do p = 1, size(pairs, 2)
         coupled(pairs(1, p), pairs(2, p)) = .true.
         coupled(pairs(2, p), pairs(1, p)) = .true.
      end do
      call check(size(matrix%column) == count(coupled)/2, 'each pair once')
      call check(matrix%row_start(n + 1) == size(matrix%column) + 1, 'the rows hold all entries')
      n_wrong = 0
      do i = 1, n
         do j = 1, n
            if (i == j) cycle
            entry = entry_of(matrix, i, j)
            if ((entry > 0) .neqv. coupled(i, j)) n_wrong = n_wrong + 1
            if (entry /= entry_of(matrix, j, i)) n_wrong = n_wrong + 1
            if (entry > 0) n_wrong = n_wrong + merge(0, 1, matrix%column(entry) == min(i, j))
         end do
         associate (row => matrix%column(matrix%row_start(i):matrix%row_start(i + 1) - 1))
            if (any(row(2:) <= row(:size(row) - 1)) .or. any(row >= i)) n_wrong = n_wrong + 1
         end associate
      end do
      call check(n_wrong == 0, 'every pair is found, no other; rows ascend below the diagonal')
      call try_product(matrix)
   end subroutine try_pattern

   subroutine try_product(matrix)
      type(block_matrix_type), intent(inout) :: matrix
      real(wp) :: dense(6*matrix%n, 6*matrix%n), x(6, matrix%n), y(6, matrix%n)
      integer :: i, e, r, c

      dense = 0.0_wp
      do i = 1, matrix%n
         r = 6*i - 5
         matrix%diagonal(:, :, i) = reshape(random_vector(36), [6, 6])
         dense(r:r + 5, r:r + 5) = matrix%diagonal(:, :, i)
         do e = matrix%row_start(i), matrix%row_start(i + 1) - 1
            c = 6*matrix%column(e) - 5
            matrix%lower(:, :, e) = reshape(random_vector(36), [6, 6])
            dense(r:r + 5, c:c + 5) = matrix%lower(:, :, e)
            dense(c:c + 5, r:r + 5) = transpose(matrix%lower(:, :, e))
         end do
      end do
      x = reshape(random_vector(6*matrix%n), [6, matrix%n])
      call multiply(matrix, x, y)
      call check_close(reshape(y, [6*matrix%n]), matmul(dense, reshape(x, [6*matrix%n])), 'K x', &
         relative=1.0e-14_wp)
      call check_close(terms_of_product(matrix, x), &
         norm2(matmul(abs(dense), abs(reshape(x, [6*matrix%n])))), 'norm of |K| |x|', &
         relative=1.0e-14_wp)
   end subroutine try_product

   subroutine another_pattern_in_the_same_matrix()
      type(block_matrix_type) :: matrix

      call set_pattern(matrix, 3, reshape([1, 2, 2, 3], [2, 2]))
      matrix%diagonal = 1.0_wp
      matrix%lower = 1.0_wp
      call set_pattern(matrix, 4, reshape([1, 4], [2, 1]))
      call check(all(shape(matrix%diagonal) == [6, 6, 4]) &
         .and. all(shape(matrix%lower) == [6, 6, 1]), 'its size')
      call check(entry_of(matrix, 1, 2) == 0 .and. entry_of(matrix, 4, 1) == 1, 'its entries')
      call check_close(sum(abs(matrix%diagonal)) + sum(abs(matrix%lower)), 0.0_wp, &
         'its values are zero')
   end subroutine another_pattern_in_the_same_matrix

   !> The pattern of two blocks lacks the pair of a term: nothing is written, and that is reported.
   subroutine terms_beyond_the_pattern()
      type(block_matrix_type) :: matrix
      type(linear_terms_type) :: terms
      real(wp), parameter :: weights(instants) = 1.0_wp
      logical :: fits
      integer :: k

      call set_pattern(matrix, 4, reshape([1, 2], [2, 1]))
      do k = 1, 2
         terms%n = 0
         call add_term(terms, linear_term_type(block_a=1, block_b=3, coefficient=1.0_wp, &
            row_a=random_vector(6), row_b=random_vector(6)))
         if (k == 2) then
            terms%term(1)%block_b = 2
            terms%term(1)%further_block = [4]
            terms%term(1)%further_row = reshape(random_vector(6), [6, 1])
         end if
         matrix%lower = 0.0_wp
         call add_to_matrix(terms, weights, matrix, fits)
         call check(.not. fits, 'the pattern lacks a pair')
         call check(k == 2 .or. .not. any(abs(matrix%lower) > 0.0_wp), 'nothing is written')
         call set_pattern(matrix, 4, coupled_blocks(terms))
         call add_to_matrix(terms, weights, matrix, fits)
         call check(fits, 'the pattern of the terms')
         call add_term(terms, terms%term(1))
         call check(size(coupled_blocks(terms), 2) == merge(1, 3, k == 1), 'pairs are listed once')
         call set_pattern(matrix, 4, reshape([1, 2], [2, 1]))
      end do
   end subroutine terms_beyond_the_pattern

   !> Terms between the same blocks: the sum of single terms, in a pattern that has their pairs.
   subroutine terms_between_the_same_blocks()
      integer, parameter :: block(3) = [4, 1, 3]
      type(block_matrix_type) :: matrix, single
      type(linear_terms_type) :: terms
      real(wp), parameter :: weights(instants) = 1.0_wp
      real(wp) :: row(6, 3, 3), c(3)
      logical :: fits
      integer :: n, i

      do n = 1, 3
         row = reshape(random_vector(54), [6, 3, 3])
         c = random_vector(3)
         terms%n = 0
         do i = 1, n
            call add_term(terms, linear_term_type(block_a=4, block_b=1, coefficient=c(i), &
               row_a=row(:, 1, i), row_b=-row(:, 2, i), further_block=[3], &
               further_row=row(:, 3:, i)))
         end do
         call set_pattern(single, 4, coupled_blocks(terms))
         call set_pattern(matrix, 4, coupled_blocks(terms))
         call add_to_matrix(terms, weights, single, fits)
         call add_parallel_terms(n, 3, c, block, row, matrix, fits)
         call check(fits, 'the pattern of the terms')
         call check_close([matrix%lower, matrix%diagonal], [single%lower, single%diagonal], &
            'the sum of single terms', relative=1.0e-14_wp)
         call set_pattern(matrix, 4, reshape([1, 4], [2, 1]))
         call add_parallel_terms(n, 3, c, block, row, matrix, fits)
         call check(.not. fits, 'the pattern lacks a pair')
      end do
   end subroutine terms_between_the_same_blocks

end module test_block_matrix
