! SPDX-License-Identifier: GPL-3.0-or-later
!> Cholesky factor of a block matrix as a band, by LAPACK, after a bandwidth-reducing order.
module dda_band_cholesky
   use dda_kinds, only: wp
   use dda_errors, only: error_type, error_solver, fail
   use dda_free_memory, only: require_for_factor, fail_allocation
   use dda_text, only: to_text
   use dda_block_matrix, only: block_matrix_type
   use dda_block_graph, only: block_graph_type, graph_of
   use dda_ordering, only: bandwidth_order
   use dda_lapack, only: dpbtrf, dpbtrs
   implicit none
   private
   public :: band_cholesky_type, analyse_band, order_band, fill_band, factorise_band, solve_band

   !> Order, band and workspace; the band is [half_width+1, 6n], lower storage.
   type :: band_cholesky_type
      integer :: n = 0                       !< block rows
      integer :: half_width = 0              !< scalar sub-diagonals
      integer, allocatable :: permuted(:)    !< [n] permuted index of each block row
      real(wp), allocatable :: band(:,:)
      real(wp), allocatable :: work(:,:)     !< [6,n]
   end type band_cholesky_type

contains

   !> Order the pattern.
   subroutine analyse_band(factor, matrix)
      type(band_cholesky_type), intent(inout) :: factor  !< gets its order
      type(block_matrix_type), intent(in) :: matrix      !< its pattern is read

      call order_band(factor, matrix)
      if (allocated(factor%band)) deallocate (factor%band, factor%work)
   end subroutine analyse_band

   !> Allocate the band, unless it is there.
   subroutine take_memory(factor, error)
      type(band_cholesky_type), intent(inout) :: factor  !< analysed
      type(error_type), allocatable, intent(out) :: error  !< there is not enough memory
      character(len=*), parameter :: what = 'the band of the matrix'
      real(wp) :: needed
      integer :: status

      if (allocated(factor%band)) return
      needed = storage_size(1.0_wp)/8*real(factor%half_width + 1, wp)*6*factor%n
      call require_for_factor(needed, factor%n, 1, what, error)
      if (allocated(error)) return
      allocate (factor%band(factor%half_width + 1, 6*factor%n), stat=status)
      if (status /= 0) then
         call fail_allocation(needed, what, error)
         return
      end if
      allocate (factor%work(6, factor%n))
   end subroutine take_memory

   !> A bandwidth-reducing order and the half width that it gives.
   subroutine order_band(factor, matrix)
      type(band_cholesky_type), intent(inout) :: factor  !< gets order and half width
      type(block_matrix_type), intent(in) :: matrix      !< its pattern is read
      type(block_graph_type) :: graph
      integer, allocatable :: order(:)
      integer :: i, e, apart

      call graph_of(matrix, graph)
      call bandwidth_order(graph, order)
      factor%n = matrix%n
      factor%permuted = order
      factor%permuted(order) = [(i, i=1, matrix%n)]
      apart = 0
      do i = 1, matrix%n
         do e = matrix%row_start(i), matrix%row_start(i + 1) - 1
            apart = max(apart, abs(factor%permuted(i) - factor%permuted(matrix%column(e))))
         end do
      end do
      factor%half_width = 6*apart + 5
   end subroutine order_band

   !> Copy the values into the band and factorise it.
   subroutine factorise_band(factor, matrix, error)
      type(band_cholesky_type), intent(inout) :: factor  !< of the same pattern
      type(block_matrix_type), intent(in) :: matrix      !< K
      type(error_type), allocatable, intent(out) :: error  !< K is not positive definite
      integer :: info

      call take_memory(factor, error)
      if (allocated(error)) return
      call fill_band(factor, matrix)
      call dpbtrf('L', 6*factor%n, factor%half_width, factor%band, factor%half_width + 1, info)
      if (info /= 0) call fail(error, error_solver, &
         'the matrix is not positive definite at scalar row '//to_text(info)//' of the band')
   end subroutine factorise_band

   !> Copy the values of a matrix into the band.
   pure subroutine fill_band(factor, matrix)
      type(band_cholesky_type), intent(inout) :: factor  !< with a band of the right size
      type(block_matrix_type), intent(in) :: matrix      !< K
      integer :: i, e

      factor%band = 0.0_wp
      do i = 1, matrix%n
         call put_block(factor, matrix%diagonal(:, :, i), factor%permuted(i), factor%permuted(i))
         do e = matrix%row_start(i), matrix%row_start(i + 1) - 1
            call put_block(factor, matrix%lower(:, :, e), factor%permuted(i), &
               factor%permuted(matrix%column(e)))
         end do
      end do
   end subroutine fill_band

   !> Put a 6×6 block, or its transpose if it falls above the diagonal, into the band.
   pure subroutine put_block(factor, block, row, column)
      type(band_cholesky_type), intent(inout) :: factor  !< its band is filled
      real(wp), intent(in) :: block(6, 6)  !< values
      integer, intent(in) :: row, column  !< permuted indices of its block row and column
      integer :: i, j, first

      do j = 1, 6
         if (row == column) then
            factor%band(1:7 - j, 6*column - 6 + j) = block(j:6, j)
         else if (row > column) then
            first = 6*(row - column) + 2 - j
            factor%band(first:first + 5, 6*column - 6 + j) = block(:, j)
         else
            first = 6*(column - row) + 2 - j
            do i = 1, 6
               factor%band(first + i - 1, 6*row - 6 + j) = block(j, i)
            end do
         end if
      end do
   end subroutine put_block

   !> x = K⁻¹ b
   subroutine solve_band(factor, b, x)
      type(band_cholesky_type), intent(inout) :: factor  !< its workspace changes
      real(wp), intent(in) :: b(:,:)   !< [6,n]
      real(wp), intent(out) :: x(:,:)  !< [6,n]
      integer :: i, info

      do i = 1, factor%n
         factor%work(:, factor%permuted(i)) = b(:, i)
      end do
      call dpbtrs('L', 6*factor%n, factor%half_width, 1, factor%band, factor%half_width + 1, &
         factor%work, 6*factor%n, info)
      do i = 1, factor%n
         x(:, i) = factor%work(:, factor%permuted(i))
      end do
   end subroutine solve_band

end module dda_band_cholesky
