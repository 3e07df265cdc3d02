! SPDX-License-Identifier: GPL-3.0-or-later
!> The symmetric matrix of DDA, with one row of 6×6 blocks for each rock block (paper eq. 7).
!>
!> Only the diagonal and strictly lower blocks are stored, as contiguous 6×6 column-major arrays;
!> the pattern is compressed by rows.
module dda_block_matrix
   use dda_kinds, only: wp
   use dda_counting_sort, only: sort_by_key
   use dda_ordered_sums, only: find_thread_range
   implicit none
   private
   public :: block_matrix_type, set_pattern, entry_of, set_zero, copy_block, multiply, &
      multiply_block, add_coupled_rows, terms_of_product

   !> Symmetric block-sparse matrix with 6×6 blocks.
   type :: block_matrix_type
      integer :: n = 0                         !< number of block rows
      integer, allocatable :: row_start(:)     !< [n+1] first lower entry of each row
      integer, allocatable :: column(:)        !< [entries] column < row, ascending in a row
      !> [n+1] start of each column in `below_row` and `below_entry`
      integer, allocatable :: below_start(:)
      integer, allocatable :: below_row(:)     !< [entries] row of each entry below the diagonal
      integer, allocatable :: below_entry(:)   !< [entries] position in `lower`
      real(wp), allocatable :: diagonal(:,:,:) !< [6,6,n]
      real(wp), allocatable :: lower(:,:,:)    !< [6,6,entries] block (row, column)
   end type block_matrix_type

   integer, parameter :: parallel_from = 500   !< smallest number of block rows to use threads

contains

   !> Build the pattern for pairs (i, j), i ≠ j, of coupled rows; pairs may repeat, in any order.
   pure subroutine set_pattern(matrix, n, pairs, untouched)
      type(block_matrix_type), intent(inout) :: matrix  !< matrix; receives the pattern, and zeros
      integer, intent(in) :: n           !< number of block rows
      integer, intent(in) :: pairs(:,:)  !< [2, any] coupled block rows
      !> the diagonal is not cleared, so that its memory pages remain unused
      logical, intent(in), optional :: untouched
      integer, allocatable :: start(:), by_column(:), by_row(:), row_of(:)
      integer :: row

      call sort_by_key(n, minval(pairs, 1), start, by_column)
      call sort_by_key(n, maxval(pairs(:, by_column), 1), matrix%row_start, by_row)
      matrix%n = n
      matrix%column = minval(pairs(:, by_column(by_row)), 1)
      call drop_repeated_columns(matrix%row_start, matrix%column)
      call sort_by_key(n, matrix%column, matrix%below_start, matrix%below_entry)
      allocate (row_of(size(matrix%column)))
      do row = 1, n
         row_of(matrix%row_start(row):matrix%row_start(row + 1) - 1) = row
      end do
      matrix%below_row = row_of(matrix%below_entry)
      if (allocated(matrix%diagonal)) deallocate (matrix%diagonal)
      if (allocated(matrix%lower)) deallocate (matrix%lower)
      allocate (matrix%lower(6, 6, size(row_of)), source=0.0_wp)
      allocate (matrix%diagonal(6, 6, n))
      if (present(untouched)) then
         if (untouched) return
      end if
      matrix%diagonal = 0.0_wp
   end subroutine set_pattern

   !> Remove repeated columns from each row.
   pure subroutine drop_repeated_columns(row_start, column)
      integer, intent(inout) :: row_start(:)             !< [n+1] start of each row
      integer, allocatable, intent(inout) :: column(:)   !< [entries] ascending in each row
      integer :: row, first, last, e, entries

      entries = 0
      do row = 1, size(row_start) - 1
         first = row_start(row)
         last = row_start(row + 1) - 1
         row_start(row) = entries + 1
         do e = first, last
            if (e > first) then
               if (column(e) == column(entries)) cycle
            end if
            entries = entries + 1
            column(entries) = column(e)
         end do
      end do
      row_start(size(row_start)) = entries + 1
      column = column(:entries)
   end subroutine drop_repeated_columns

   !> Return the position of the entry that couples block rows i and j; 0 if the pattern lacks it.
   pure integer function entry_of(matrix, i, j)
      type(block_matrix_type), intent(in) :: matrix  !< matrix with a pattern
      integer, intent(in) :: i, j  !< block rows, i ≠ j
      integer :: lower, upper, middle, target

      target = min(i, j)
      lower = matrix%row_start(max(i, j))
      upper = matrix%row_start(max(i, j) + 1) - 1
      entry_of = 0
      do while (lower <= upper)
         middle = (lower + upper)/2
         if (matrix%column(middle) == target) then
            entry_of = middle
            return
         else if (matrix%column(middle) < target) then
            lower = middle + 1
         else
            upper = middle - 1
         end if
      end do
   end function entry_of

   !> Set n contiguous values, such as an array of any rank, to zero.
   pure subroutine set_zero(values, n)
      integer, intent(in) :: n  !< number of values
      real(wp), intent(out) :: values(n)  !< zeros

      values = 0.0_wp
   end subroutine set_zero

   !> Copy a block in an explicit loop, which the compiler can vectorise.
   pure subroutine copy_block(from, to)
      real(wp), intent(in) :: from(6, 6)  !< block
      real(wp), intent(out) :: to(6, 6)   !< copy of the block

      to = from
   end subroutine copy_block

   !> Compute y = K x.
   subroutine multiply(matrix, x, y)
      type(block_matrix_type), intent(in) :: matrix  !< K
      real(wp), intent(in) :: x(6, matrix%n)  !< any vector
      real(wp), intent(out) :: y(6, matrix%n)  !< K x
      integer :: first, last

      if (matrix%n < parallel_from) then
         call multiply_rows(matrix, 1, matrix%n, x, y)
         return
      end if
      !$omp parallel private(first, last)
      call find_thread_range(matrix%n, first, last)
      call multiply_rows(matrix, first, last, x, y)
      !$omp end parallel
   end subroutine multiply

   !> Compute the rows first … last of y = K x; no other thread writes these rows.
   pure subroutine multiply_rows(matrix, first, last, x, y)
      type(block_matrix_type), intent(in) :: matrix  !< K
      integer, intent(in) :: first, last  !< first and last index
      real(wp), intent(in) :: x(6, matrix%n)  !< any vector
      real(wp), intent(inout) :: y(6, matrix%n)  !< K x
      integer :: i

      do i = first, last
         call multiply_block(matrix%diagonal(:, :, i), x(:, i), y(:, i))
      end do
      call add_coupled_rows(matrix, first, last, x, y)
   end subroutine multiply_rows

   !> Add the products with off-diagonal blocks, y = y + (K − diag K) x, to rows first … last.
   !> No other thread writes these rows.  A block that couples two rows of the range is read once.
   !> The order of summation does not depend on the range: blocks to the left of the diagonal, then
   !> blocks below it.
   pure subroutine add_coupled_rows(matrix, first, last, x, y)
      type(block_matrix_type), intent(in) :: matrix  !< K
      integer, intent(in) :: first, last  !< first and last index
      real(wp), intent(in) :: x(6, matrix%n)  !< any vector
      real(wp), intent(inout) :: y(6, matrix%n)  !< sum
      integer :: i, k

      if (size(matrix%column) == 0) return
      do i = first, last
         do k = matrix%row_start(i), matrix%row_start(i + 1) - 1
            associate (j => matrix%column(k))
               call add_product(matrix%lower(:, :, k), x(:, j), y(:, i))
               if (j >= first) call add_transposed_product(matrix%lower(:, :, k), x(:, i), y(:, j))
            end associate
         end do
      end do
      if (last == matrix%n) return
      do i = first, last
         do k = matrix%below_start(i), matrix%below_start(i + 1) - 1
            if (matrix%below_row(k) > last) call add_transposed_product( &
               matrix%lower(:, :, matrix%below_entry(k)), x(:, matrix%below_row(k)), y(:, i))
         end do
      end do
   end subroutine add_coupled_rows

   !> Return the norm ‖ |K| |x| ‖, which scales the rounding error of K x even if its terms cancel.
   pure real(wp) function terms_of_product(matrix, x) result(norm)
      type(block_matrix_type), intent(in) :: matrix  !< K
      real(wp), intent(in) :: x(6, matrix%n)  !< any vector
      real(wp) :: row(6)
      integer :: i, k

      norm = 0.0_wp
      do i = 1, matrix%n
         row = matmul(abs(matrix%diagonal(:, :, i)), abs(x(:, i)))
         do k = matrix%row_start(i), matrix%row_start(i + 1) - 1
            row = row + matmul(abs(matrix%lower(:, :, k)), abs(x(:, matrix%column(k))))
         end do
         do k = matrix%below_start(i), matrix%below_start(i + 1) - 1
            row = row + matmul(abs(x(:, matrix%below_row(k))), &
               abs(matrix%lower(:, :, matrix%below_entry(k))))
         end do
         norm = norm + dot_product(row, row)
      end do
      norm = sqrt(norm)
   end function terms_of_product

   !> Compute row = B x.
   pure subroutine multiply_block(b, x, row)
      real(wp), intent(in) :: b(6, 6), x(6)  !< B and x
      real(wp), intent(out) :: row(6)  !< product

      row = b(:, 1)*x(1) + b(:, 2)*x(2) + b(:, 3)*x(3) + b(:, 4)*x(4) + b(:, 5)*x(5) + b(:, 6)*x(6)
   end subroutine multiply_block

   !> Compute row = row + B x.
   pure subroutine add_product(b, x, row)
      real(wp), intent(in) :: b(6, 6), x(6)  !< B and x
      real(wp), intent(inout) :: row(6)  !< sum

      row = row + (b(:, 1)*x(1) + b(:, 2)*x(2) + b(:, 3)*x(3) + b(:, 4)*x(4) + b(:, 5)*x(5) &
         + b(:, 6)*x(6))
   end subroutine add_product

   !> Compute row = row + Bᵀ x.
   pure subroutine add_transposed_product(b, x, row)
      real(wp), intent(in) :: b(6, 6), x(6)  !< B and x
      real(wp), intent(inout) :: row(6)  !< sum
      integer :: j

      do j = 1, 6
         row(j) = row(j) + (b(1, j)*x(1) + b(2, j)*x(2) + b(3, j)*x(3) + b(4, j)*x(4) &
            + b(5, j)*x(5) + b(6, j)*x(6))
      end do
   end subroutine add_transposed_product

end module dda_block_matrix
