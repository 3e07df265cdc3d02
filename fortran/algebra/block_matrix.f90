!> The symmetric matrix of DDA: one row of 6×6 blocks for each rock block (paper eq. 7).
!>
!> Only the diagonal blocks and the strictly lower blocks are kept, as contiguous 6×6
!> column-major arrays; the pattern is compressed by rows.
module dda_block_matrix
   use dda_kinds, only: wp
   implicit none
   private
   public :: block_matrix_type, set_pattern, clear, entry_of, multiply

   !> Symmetric block-sparse matrix with 6×6 blocks.
   type :: block_matrix_type
      integer :: n = 0                         !< block rows
      integer, allocatable :: row_start(:)     !< [n+1] first lower entry of each row
      integer, allocatable :: column(:)        !< [entries] column < row, ascending in a row
      real(wp), allocatable :: diagonal(:,:,:) !< [6,6,n]
      real(wp), allocatable :: lower(:,:,:)    !< [6,6,entries] block (row, column)
   end type block_matrix_type

contains

   !> Lay out the pattern that holds every pair (i, j), i ≠ j; pairs may repeat, in any order.
   pure subroutine set_pattern(matrix, n, pairs)
      type(block_matrix_type), intent(inout) :: matrix
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
   end subroutine set_pattern

   !> Put each pair's column into its row's stretch.
   pure subroutine scatter_pairs(row_start, pairs, column)
      integer, intent(in) :: row_start(:), pairs(:,:)
      integer, intent(out) :: column(:)
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
      integer, intent(inout) :: row_start(:), column(:)
      integer, intent(out) :: entries
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
      integer, intent(inout) :: list(:)
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

   !> Set all values to zero, keep the pattern.
   pure subroutine clear(matrix)
      type(block_matrix_type), intent(inout) :: matrix

      matrix%diagonal = 0.0_wp
      matrix%lower = 0.0_wp
   end subroutine clear

   !> Position of the lower entry that couples block rows i and j; 0 if the pattern lacks it.
   pure integer function entry_of(matrix, i, j)
      type(block_matrix_type), intent(in) :: matrix
      integer, intent(in) :: i, j
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

   !> y = K x.
   pure subroutine multiply(matrix, x, y)
      type(block_matrix_type), intent(in) :: matrix
      real(wp), intent(in) :: x(6, matrix%n)
      real(wp), intent(out) :: y(6, matrix%n)
      integer :: i, e

      do i = 1, matrix%n
         y(:, i) = matmul(matrix%diagonal(:, :, i), x(:, i))
      end do
      do i = 1, matrix%n
         do e = matrix%row_start(i), matrix%row_start(i + 1) - 1
            y(:, i) = y(:, i) + matmul(matrix%lower(:, :, e), x(:, matrix%column(e)))
            y(:, matrix%column(e)) = y(:, matrix%column(e)) + matmul(x(:, i), matrix%lower(:, :, e))
         end do
      end do
   end subroutine multiply

end module dda_block_matrix
