!> The inverse diagonal blocks: the preconditioner for small p Δt²/m, and what SOR divides by.
module dda_block_jacobi
   use dda_kinds, only: wp
   use dda_block_matrix, only: block_matrix_type, multiply_block
   use dda_conjugate_gradients, only: preconditioner_type
   use dda_small_matrix, only: invert
   implicit none
   private
   public :: block_jacobi_type, invert_diagonal, most_iterations

   integer, parameter :: parallel_from = 500  !< blocks from which threads repay their start

   !> Inverses of the diagonal blocks.
   type, extends(preconditioner_type) :: block_jacobi_type
      real(wp), allocatable :: inverse(:,:,:)   !< [6,6,n]
   contains
      procedure :: apply
   end type block_jacobi_type

contains

   !> Invert the diagonal blocks of a matrix.
   subroutine invert_diagonal(jacobi, matrix)
      type(block_jacobi_type), intent(inout) :: jacobi
      type(block_matrix_type), intent(in) :: matrix
      integer :: i

      if (allocated(jacobi%inverse)) then
         if (size(jacobi%inverse, 3) /= matrix%n) deallocate (jacobi%inverse)
      end if
      if (.not. allocated(jacobi%inverse)) allocate (jacobi%inverse(6, 6, matrix%n))
      if (matrix%n < parallel_from) then
         do i = 1, matrix%n
            call invert(matrix%diagonal(:, :, i), jacobi%inverse(:, :, i))
         end do
         return
      end if
      !$omp parallel do schedule(static)
      do i = 1, matrix%n
         call invert(matrix%diagonal(:, :, i), jacobi%inverse(:, :, i))
      end do
   end subroutine invert_diagonal

   !> z = D⁻¹ r
   subroutine apply(self, n, r, z)
      class(block_jacobi_type), intent(inout) :: self
      integer, intent(in) :: n
      real(wp), intent(in) :: r(6, n)
      real(wp), intent(out) :: z(6, n)
      integer :: i

      if (n < parallel_from) then
         do i = 1, n
            call multiply_block(self%inverse(:, :, i), r(:, i), z(:, i))
         end do
         return
      end if
      !$omp parallel do schedule(static)
      do i = 1, n
         call multiply_block(self%inverse(:, :, i), r(:, i), z(:, i))
      end do
   end subroutine apply

   !> A bound on the iterations that conjugate gradients can need for a relative accuracy.
   !>
   !> D⁻¹K̂ has no eigenvalue above 2 (each spring enters two diagonal blocks) and none below
   !> μ = min λ(D⁻¹A) over the blocks, A their part without contacts; 1/trace(A⁻¹D) bounds μ from
   !> below. Chebyshev: ½ √(2/μ) ln(2/ε).
   real(wp) function most_iterations(matrix, alone, accuracy) result(bound)
      type(block_matrix_type), intent(in) :: matrix
      real(wp), intent(in) :: alone(6, 6, matrix%n)  !< A of each block
      real(wp), intent(in) :: accuracy
      real(wp) :: inverse(6, 6), worst
      integer :: i

      worst = 1.0_wp
      do i = 1, matrix%n
         call invert(alone(:, :, i), inverse)
         worst = max(worst, sum(inverse*matrix%diagonal(:, :, i)))
      end do
      bound = 0.5_wp*sqrt(2.0_wp*worst)*log(2.0_wp/accuracy)
   end function most_iterations

end module dda_block_jacobi
