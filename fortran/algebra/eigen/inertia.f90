!> How many eigenvalues of K x = λ M x lie above a value, by Sylvester's law of inertia.
!>
!> K − sM = L D Lᵀ has as many positive pivots as there are eigenvalues above s.  The factor is a
!> plain band without exchanges, good for models of a few thousand blocks; where a pivot is so small
!> that its sign means nothing, the count is called uncertain.
module dda_inertia
   use dda_kinds, only: wp
   use dda_block_graph, only: block_graph_type, graph_of
   use dda_block_matrix, only: block_matrix_type
   use dda_mass_factor, only: mass_factor_type, scale_matrix
   use dda_ordering, only: bandwidth_order
   implicit none
   private
   public :: count_above

   !> S − sI as a band of scalar columns, lower storage.
   type :: band_type
      integer :: n = 0                    !< scalar rows
      integer :: width = 0                !< scalar sub-diagonals
      real(wp), allocatable :: value(:,:) !< [width+1,n]
   end type band_type

   real(wp), parameter :: doubtful = 1.0e-11_wp  !< pivot / largest entry of S

contains

   !> Count the eigenvalues above `value`.
   subroutine count_above(stiffness, mass, value, affordable, count, certain)
      type(block_matrix_type), intent(in) :: stiffness  !< K, N/m
      type(mass_factor_type), intent(in) :: mass  !< G
      real(wp), intent(in) :: value         !< 1/s²
      real(wp), intent(in) :: affordable    !< most multiplications to spend
      integer, intent(out) :: count  !< eigenvalues above
      logical, intent(out) :: certain       !< .false. if too expensive or a pivot is doubtful
      type(block_matrix_type) :: scaled
      type(band_type) :: band
      integer, allocatable :: permuted(:)

      count = 0
      certain = .false.
      call order_rows(stiffness, permuted, band%width)
      band%n = 6*stiffness%n
      if (0.5_wp*real(band%n, wp)*real(band%width, wp)**2 > affordable) return
      scaled = stiffness
      call scale_matrix(mass, scaled)
      call fill_band(band, scaled, permuted, value)
      call count_pivots(band, count, certain)
   end subroutine count_above

   !> A bandwidth-reducing order and the scalar half-width that it gives.
   subroutine order_rows(matrix, permuted, width)
      type(block_matrix_type), intent(in) :: matrix  !< its pattern is read
      integer, allocatable, intent(out) :: permuted(:)  !< [n] of each block row in the order
      integer, intent(out) :: width  !< scalar sub-diagonals
      type(block_graph_type) :: graph
      integer, allocatable :: order(:)
      integer :: i, e

      call graph_of(matrix%n, matrix%row_start, matrix%column, graph)
      call bandwidth_order(graph, order)
      allocate (permuted(matrix%n))
      do i = 1, matrix%n
         permuted(order(i)) = i
      end do
      width = 5
      do i = 1, matrix%n
         do e = matrix%row_start(i), matrix%row_start(i + 1) - 1
            width = max(width, 6*abs(permuted(i) - permuted(matrix%column(e))) + 5)
         end do
      end do
   end subroutine order_rows

   pure subroutine fill_band(band, matrix, permuted, value)
      type(band_type), intent(inout) :: band  !< gets S − sI
      type(block_matrix_type), intent(in) :: matrix  !< S
      integer, intent(in) :: permuted(:)  !< [n] index of each block row in the order
      real(wp), intent(in) :: value  !< s, 1/s²
      integer :: i, e

      allocate (band%value(band%width + 1, band%n), source=0.0_wp)
      do i = 1, matrix%n
         call put_block(band, matrix%diagonal(:, :, i), 6*permuted(i) - 6, 6*permuted(i) - 6)
         do e = matrix%row_start(i), matrix%row_start(i + 1) - 1
            if (permuted(i) > permuted(matrix%column(e))) then
               call put_block(band, matrix%lower(:, :, e), 6*permuted(i) - 6, &
                  6*permuted(matrix%column(e)) - 6)
            else
               call put_block(band, transpose(matrix%lower(:, :, e)), 6*permuted(matrix%column(e)) &
                  - 6, 6*permuted(i) - 6)
            end if
         end do
      end do
      band%value(1, :) = band%value(1, :) - value
   end subroutine fill_band

   pure subroutine put_block(band, block, row, column)
      type(band_type), intent(inout) :: band  !< being filled
      real(wp), intent(in) :: block(6, 6)  !< values
      integer, intent(in) :: row, column  !< scalar rows and columns before it
      integer :: i, j

      do j = 1, 6
         do i = 1, 6
            if (row + i >= column + j) band%value(row + i - column - j + 1, column + j) &
               = block(i, j)
         end do
      end do
   end subroutine put_block

   !> Eliminate column by column and count positive pivots.
   pure subroutine count_pivots(band, count, certain)
      type(band_type), intent(inout) :: band  !< destroyed
      integer, intent(out) :: count  !< positive pivots
      logical, intent(out) :: certain  !< no pivot is doubtful
      real(wp) :: least, pivot, factor
      integer :: j, k, reach

      count = 0
      certain = .true.
      least = doubtful*maxval(abs(band%value))
      do j = 1, band%n
         pivot = band%value(1, j)
         if (abs(pivot) < least) then
            certain = .false.
            pivot = sign(least, pivot)
         end if
         if (pivot > 0.0_wp) count = count + 1
         reach = min(band%width, band%n - j)
         do k = 1, reach
            if (band%value(k + 1, j) == 0.0_wp) cycle
            factor = band%value(k + 1, j)/pivot
            band%value(1:reach - k + 1, j + k) = band%value(1:reach - k + 1, j + k) &
               - factor*band%value(k + 1:reach + 1, j)
         end do
      end do
   end subroutine count_pivots

end module dda_inertia
