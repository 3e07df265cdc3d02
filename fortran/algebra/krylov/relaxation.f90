!> Successive over-relaxation by blocks: the original DDA's solver, kept for comparison.
module dda_relaxation
   use dda_kinds, only: wp
   use dda_block_matrix, only: block_matrix_type, multiply
   use dda_block_jacobi, only: block_jacobi_type
   use dda_ordered_sums, only: inner_product
   implicit none
   private
   public :: relax_to_solution

   real(wp), parameter :: factor = 1.5_wp     !< of the original
   integer, parameter :: look_every = 10      !< sweeps between looks at the residual
   real(wp), parameter :: hopeless = 1.0e30_wp !< a residual from which no sweep comes back

contains

   !> Sweep until ‖r‖ ≤ tolerance·‖b‖, `most` sweeps, or sweeps that diverge (as of a matrix that is
   !> not definite).
   subroutine relax_to_solution(matrix, jacobi, b, x, tolerance, most, residual_vector, sweeps, &
      residual)
      type(block_matrix_type), intent(in) :: matrix
      type(block_jacobi_type), intent(in) :: jacobi
      real(wp), intent(in) :: b(6, matrix%n)
      real(wp), intent(inout) :: x(6, matrix%n)
      real(wp), intent(in) :: tolerance
      integer, intent(in) :: most
      real(wp), intent(inout) :: residual_vector(6, matrix%n)  !< work space
      integer, intent(out) :: sweeps
      real(wp), intent(out) :: residual                        !< ‖r‖/‖b‖ reached
      real(wp) :: size_of_b

      sweeps = 0
      size_of_b = sqrt(inner_product(matrix%n, b, b))
      residual = 0.0_wp
      do while (sweeps < most)
         if (modulo(sweeps, look_every) == 0) then
            call multiply(matrix, x, residual_vector)
            residual_vector = b - residual_vector
            residual = sqrt(inner_product(matrix%n, residual_vector, &
               residual_vector))/max(size_of_b, tiny(1.0_wp))
            if (residual <= tolerance .or. .not. residual < hopeless) return
         end if
         call sweep(matrix, jacobi, b, x)
         sweeps = sweeps + 1
      end do
   end subroutine relax_to_solution

   !> One pass over all block rows.
   pure subroutine sweep(matrix, jacobi, b, x)
      type(block_matrix_type), intent(in) :: matrix
      type(block_jacobi_type), intent(in) :: jacobi
      real(wp), intent(in) :: b(6, matrix%n)
      real(wp), intent(inout) :: x(6, matrix%n)
      real(wp) :: row(6)
      integer :: i, k

      do i = 1, matrix%n
         row = b(:, i)
         do k = matrix%row_start(i), matrix%row_start(i + 1) - 1
            row = row - matmul(matrix%lower(:, :, k), x(:, matrix%column(k)))
         end do
         do k = matrix%below_start(i), matrix%below_start(i + 1) - 1
            row = row - matmul(x(:, matrix%below_row(k)), matrix%lower(:, :, matrix%below_entry(k)))
         end do
         x(:, i) = (1.0_wp - factor)*x(:, i) + factor*matmul(jacobi%inverse(:, :, i), row)
      end do
   end subroutine sweep

end module dda_relaxation
