!> The symmetric matrix of DDA: one row of 6×6 blocks for each rock block (paper eq. 7).
!>
!> Only the diagonal blocks and the strictly lower blocks are kept, as contiguous 6×6
!> column-major arrays; the pattern is compressed by rows.
module dda_block_matrix
   use dda_kinds, only: wp
   implicit none
   private
   public :: block_matrix_type, set_pattern, entry_of, multiply, multiply_block

   !> Symmetric block-sparse matrix with 6×6 blocks.
   type :: block_matrix_type
      integer :: n = 0                         !< block rows
      integer, allocatable :: row_start(:)     !< [n+1] first lower entry of each row
      integer, allocatable :: column(:)        !< [entries] column < row, ascending in a row
      !> [n+1] first of the entries below the diagonal in each column
      integer, allocatable :: below_start(:)
      integer, allocatable :: below_row(:)     !< [entries] their rows
      integer, allocatable :: below_entry(:)   !< [entries] their place in `lower`
      real(wp), allocatable :: diagonal(:,:,:) !< [6,6,n]
      real(wp), allocatable :: lower(:,:,:)    !< [6,6,entries] block (row, column)
   end type block_matrix_type

   integer, parameter :: parallel_from = 500   !< block rows from which threads repay their start

contains

   !> Lay out the pattern that holds every pair (i, j), i ≠ j; pairs may repeat, in any order.
   pure subroutine set_pattern(matrix, n, pairs)
      type(block_matrix_type), intent(inout) :: matrix  !< gets the pattern, and zeros as values
      integer, intent(in) :: n           !< block rows
      integer, intent(in) :: pairs(:,:)  !< [2, any] coupled block rows
      integer, allocatable :: row_start(:), column(:)
      integer :: p, row, entries

      allocate (row_start(n + 1), source=0)
      do p = 1, size(pairs, 2)
         row = maxval(pairs(:, p))
         row_start(row + 1) = row_start(row + 1) + 1
      end do
      row_start(1) = 1
      do row = 1, n
         row_start(row + 1) = row_start(row) + row_start(row + 1)
      end do
      allocate (column(size(pairs, 2)))
      call scatter_pairs(row_start, pairs, column)
      call sort_rows(row_start, column, entries)

      matrix%n = n
      call move_alloc(row_start, matrix%row_start)
      matrix%column = column(:entries)
      if (allocated(matrix%diagonal)) deallocate (matrix%diagonal)
      if (allocated(matrix%lower)) deallocate (matrix%lower)
      allocate (matrix%diagonal(6, 6, n), matrix%lower(6, 6, entries), source=0.0_wp)
      call list_columns(matrix)
   end subroutine set_pattern

   !> The same entries seen by columns.
   pure subroutine list_columns(matrix)
      type(block_matrix_type), intent(inout) :: matrix  !< with its rows listed
      integer, allocatable :: start(:), row_of(:), entry(:), next(:)
      integer :: row, k, column

      allocate (start(matrix%n + 1), source=0)
      allocate (row_of(size(matrix%column)), entry(size(matrix%column)))
      do k = 1, size(matrix%column)
         start(matrix%column(k) + 1) = start(matrix%column(k) + 1) + 1
      end do
      start(1) = 1
      do column = 1, matrix%n
         start(column + 1) = start(column) + start(column + 1)
      end do
      next = start
      do row = 1, matrix%n
         do k = matrix%row_start(row), matrix%row_start(row + 1) - 1
            column = matrix%column(k)
            row_of(next(column)) = row
            entry(next(column)) = k
            next(column) = next(column) + 1
         end do
      end do
      call move_alloc(start, matrix%below_start)
      call move_alloc(row_of, matrix%below_row)
      call move_alloc(entry, matrix%below_entry)
   end subroutine list_columns

   !> Put each pair's column into its row's stretch.
   pure subroutine scatter_pairs(row_start, pairs, column)
      !> [n+1] starts of the rows, [2, any] coupled rows
      integer, intent(in) :: row_start(:), pairs(:,:)
      integer, intent(out) :: column(:)  !< [pairs] unsorted, with repeats
      integer :: next(size(row_start)), p, row

      next = row_start
      do p = 1, size(pairs, 2)
         row = maxval(pairs(:, p))
         column(next(row)) = minval(pairs(:, p))
         next(row) = next(row) + 1
      end do
   end subroutine scatter_pairs

   !> Sort each row, drop repeats, close the gaps.
   pure subroutine sort_rows(row_start, column, entries)
      integer, intent(inout) :: row_start(:), column(:)  !< [n+1], [pairs]
      integer, intent(out) :: entries  !< left after repeats are dropped
      integer :: row, first, last, e

      entries = 0
      do row = 1, size(row_start) - 1
         first = row_start(row)
         last = row_start(row + 1) - 1
         row_start(row) = entries + 1
         call insertion_sort(column(first:last))
         do e = first, last
            if (e > first) then
               if (column(e) == column(entries)) cycle
            end if
            entries = entries + 1
            column(entries) = column(e)
         end do
      end do
      row_start(size(row_start)) = entries + 1
   end subroutine sort_rows

   !> Rows are short: a block has a handful of neighbours.
   pure subroutine insertion_sort(list)
      integer, intent(inout) :: list(:)  !< any integers
      integer :: i, j, moving

      do i = 2, size(list)
         moving = list(i)
         j = i - 1
         do while (j >= 1)
            if (list(j) <= moving) exit
            list(j + 1) = list(j)
            j = j - 1
         end do
         list(j + 1) = moving
      end do
   end subroutine insertion_sort

   !> Position of the lower entry that couples block rows i and j; 0 if the pattern lacks it.
   pure integer function entry_of(matrix, i, j)
      type(block_matrix_type), intent(in) :: matrix  !< any with a pattern
      integer, intent(in) :: i, j  !< block rows, i ≠ j
      integer :: low, high, middle, wanted

      wanted = min(i, j)
      low = matrix%row_start(max(i, j))
      high = matrix%row_start(max(i, j) + 1) - 1
      entry_of = 0
      do while (low <= high)
         middle = (low + high)/2
         if (matrix%column(middle) == wanted) then
            entry_of = middle
            return
         else if (matrix%column(middle) < wanted) then
            low = middle + 1
         else
            high = middle - 1
         end if
      end do
   end function entry_of

   !> y = K x
   subroutine multiply(matrix, x, y)
      type(block_matrix_type), intent(in) :: matrix  !< K
      real(wp), intent(in) :: x(6, matrix%n)  !< any vector
      real(wp), intent(out) :: y(6, matrix%n)  !< K x

      if (matrix%n < parallel_from) then
         call multiply_rows(matrix, x, y)
      else
         !$omp parallel
         call multiply_rows(matrix, x, y)
         !$omp end parallel
      end if
   end subroutine multiply

   !> y = K x, gathered row by row and shared between the threads of a team: no two threads write the
   !> same row, whatever their number.
   subroutine multiply_rows(matrix, x, y)
      type(block_matrix_type), intent(in) :: matrix  !< K
      real(wp), intent(in) :: x(6, matrix%n)  !< any vector
      real(wp), intent(inout) :: y(6, matrix%n)  !< K x
      integer :: i

      !$omp do schedule(static)
      do i = 1, matrix%n
         call multiply_row(matrix, i, x, y(:, i))
      end do
      !$omp end do nowait
   end subroutine multiply_rows

   !> Block row i of K x.
   pure subroutine multiply_row(matrix, i, x, y)
      type(block_matrix_type), intent(in) :: matrix  !< K
      integer, intent(in) :: i  !< block row
      real(wp), intent(in) :: x(6, matrix%n)  !< any vector
      real(wp), intent(out) :: y(6)  !< its six products
      real(wp) :: row(6)
      integer :: k

      call multiply_block(matrix%diagonal(:, :, i), x(:, i), row)
      do k = matrix%row_start(i), matrix%row_start(i + 1) - 1
         call add_product(matrix%lower(:, :, k), x(:, matrix%column(k)), row)
      end do
      do k = matrix%below_start(i), matrix%below_start(i + 1) - 1
         call add_transposed_product(matrix%lower(:, :, matrix%below_entry(k)), &
            x(:, matrix%below_row(k)), row)
      end do
      y = row
   end subroutine multiply_row

   !> row = B x
   pure subroutine multiply_block(b, x, row)
      real(wp), intent(in) :: b(6, 6), x(6)  !< factors
      real(wp), intent(out) :: row(6)  !< product

      row = b(:, 1)*x(1) + b(:, 2)*x(2) + b(:, 3)*x(3) + b(:, 4)*x(4) + b(:, 5)*x(5) + b(:, 6)*x(6)
   end subroutine multiply_block

   !> row += B x
   pure subroutine add_product(b, x, row)
      real(wp), intent(in) :: b(6, 6), x(6)  !< factors
      real(wp), intent(inout) :: row(6)  !< sum

      row = row + (b(:, 1)*x(1) + b(:, 2)*x(2) + b(:, 3)*x(3) + b(:, 4)*x(4) + b(:, 5)*x(5) &
         + b(:, 6)*x(6))
   end subroutine add_product

   !> row += Bᵀ x
   pure subroutine add_transposed_product(b, x, row)
      real(wp), intent(in) :: b(6, 6), x(6)  !< factors
      real(wp), intent(inout) :: row(6)  !< sum
      integer :: j

      do j = 1, 6
         row(j) = row(j) + (b(1, j)*x(1) + b(2, j)*x(2) + b(3, j)*x(3) + b(4, j)*x(4) &
            + b(5, j)*x(5) + b(6, j)*x(6))
      end do
   end subroutine add_transposed_product

end module dda_block_matrix
