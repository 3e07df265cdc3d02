! SPDX-License-Identifier: GPL-3.0-or-later
!> A block matrix stored as a band, in a bandwidth-reducing order.
module dda_band_matrix
   use dda_kinds, only: wp
   use dda_block_matrix, only: block_matrix_type
   use dda_block_graph, only: block_graph_type, graph_of
   use dda_ordering, only: bandwidth_order
   implicit none
   private
   public :: band_type, order_band, fill_band

   !> Order and band; the band is [half_width+1, 6n], lower storage.
   type :: band_type
      integer :: n = 0                       !< number of block rows
      integer :: half_width = 0              !< number of scalar sub-diagonals
      integer, allocatable :: permuted(:)    !< [n] permuted index of each block row
      real(wp), allocatable :: band(:,:)
   end type band_type

contains

   !> Find a bandwidth-reducing order and its half width.
   subroutine order_band(factor, matrix)
      type(band_type), intent(inout) :: factor  !< band; receives order and half width
      type(block_matrix_type), intent(in) :: matrix      !< matrix; only its pattern is read
      type(block_graph_type) :: graph
      integer, allocatable :: order(:)
      integer :: i, e, distance

      call graph_of(matrix, graph)
      call bandwidth_order(graph, order)
      factor%n = matrix%n
      factor%permuted = order
      factor%permuted(order) = [(i, i=1, matrix%n)]
      distance = 0
      do i = 1, matrix%n
         do e = matrix%row_start(i), matrix%row_start(i + 1) - 1
            distance = max(distance, abs(factor%permuted(i) - factor%permuted(matrix%column(e))))
         end do
      end do
      factor%half_width = 6*distance + 5
   end subroutine order_band

   !> Copy the values of a matrix into the band.
   pure subroutine fill_band(factor, matrix)
      type(band_type), intent(inout) :: factor  !< band of the right size; receives values
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

   !> Copy a 6×6 block into the band, transposed if it lies above the diagonal.
   pure subroutine put_block(factor, block, row, column)
      type(band_type), intent(inout) :: factor  !< band; receives the block
      real(wp), intent(in) :: block(6, 6)  !< values
      integer, intent(in) :: row, column  !< permuted indices of the block row and column
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

end module dda_band_matrix
