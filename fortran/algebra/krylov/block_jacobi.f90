! SPDX-License-Identifier: GPL-3.0-or-later
!> The inverse diagonal blocks: preconditioner for small p Δt²/m (p: penalty), and for SOR.
module dda_block_jacobi
   use dda_kinds, only: wp
   use dda_block_matrix, only: block_matrix_type, multiply_block
   use dda_compact_block, only: compact_size, expand
   use dda_conjugate_gradients, only: preconditioner_type
   use dda_small_matrix, only: invert_matrix
   implicit none
   private
   public :: block_jacobi_type, invert_diagonal, most_iterations, max_condition

   integer, parameter :: parallel_from = 500  !< smallest number of blocks to use threads

   !> Inverses of the diagonal blocks.
   type, extends(preconditioner_type) :: block_jacobi_type
      real(wp), allocatable :: inverse(:,:,:)   !< [6,6,n] inverse blocks
   contains
      procedure :: apply
   end type block_jacobi_type

contains

   !> Invert the diagonal blocks of a matrix.
   subroutine invert_diagonal(jacobi, matrix)
      type(block_jacobi_type), intent(inout) :: jacobi  !< receives the inverses
      type(block_matrix_type), intent(in) :: matrix        !< positive definite matrix
      integer :: i

      if (allocated(jacobi%inverse)) then
         if (size(jacobi%inverse, 3) /= matrix%n) deallocate (jacobi%inverse)
      end if
      if (.not. allocated(jacobi%inverse)) allocate (jacobi%inverse(6, 6, matrix%n))
      !$omp parallel do schedule(static) if (matrix%n >= parallel_from)
      do i = 1, matrix%n
         call invert_matrix(matrix%diagonal(:, :, i), jacobi%inverse(:, :, i))
      end do
   end subroutine invert_diagonal

   !> Compute z = D⁻¹ r.
   subroutine apply(self, n, r, z)
      class(block_jacobi_type), intent(inout) :: self  !< D⁻¹
      integer, intent(in) :: n         !< number of block rows
      real(wp), intent(in) :: r(6, n)  !< residual
      real(wp), intent(out) :: z(6, n)  !< preconditioned residual

      if (n < parallel_from) then
         call apply_rows(n, self%inverse, r, z)
      else
         !$omp parallel
         call apply_rows(n, self%inverse, r, z)
         !$omp end parallel
      end if
   end subroutine apply

   !> Compute z = D⁻¹ r, divided between the threads of a team.
   subroutine apply_rows(n, inverse, r, z)
      integer, intent(in) :: n                    !< number of block rows
      real(wp), intent(in) :: inverse(6, 6, n), r(6, n)  !< D⁻¹, residual
      real(wp), intent(inout) :: z(6, n)  !< preconditioned residual
      integer :: i

      !$omp do schedule(static)
      do i = 1, n
         call multiply_block(inverse(:, :, i), r(:, i), z(:, i))
      end do
      !$omp end do nowait
   end subroutine apply_rows

   !> Return a bound on conjugate-gradient iterations for a relative accuracy ε: ½ √κ ln(2/ε).
   real(wp) function most_iterations(matrix, own_terms, accuracy) result(bound)
      type(block_matrix_type), intent(in) :: matrix  !< K̂
      real(wp), intent(in) :: own_terms(compact_size, matrix%n)  !< A, see `max_condition`
      real(wp), intent(in) :: accuracy               !< ε of the error in the energy norm

      bound = 0.5_wp*sqrt(max_condition(matrix, own_terms))*log(2.0_wp/accuracy)
   end function most_iterations

   !> Return an upper bound on the condition number κ of D⁻¹K̂.
   !>
   !> Let A be the sum of the terms of K̂ that act on one block each (inertia, strains, supports).
   !> Every other term E (contacts, elements that couple blocks) is positive semi-definite and
   !> couples two blocks.  Then K̂ − A ⪰ 0, so that no eigenvalue of D⁻¹K̂ is below μ = min λ(D⁻¹A),
   !> the minimum over the blocks.  From uᵀEu ≤ 2 Σ u_iᵀE_ii u_i follows 2D − K̂ ⪰ 0, so that no
   !> eigenvalue exceeds 2.  1/trace(A⁻¹D) bounds μ from below.
   !>
   !> The bound may be too small if A includes diagonal parts of coupling terms, or if a term
   !> couples m > 2 blocks (the factor 2 is then m).
   real(wp) function max_condition(matrix, own_terms) result(bound)
      type(block_matrix_type), intent(in) :: matrix  !< K̂
      !> A, the terms that act on one block only, see dda_compact_block
      real(wp), intent(in) :: own_terms(compact_size, matrix%n)
      real(wp) :: block(6, 6), inverse(6, 6), worst_condition
      integer :: i

      worst_condition = 1.0_wp
      do i = 1, matrix%n
         call expand(own_terms(:, i), block)
         call invert_matrix(block, inverse)
         worst_condition = max(worst_condition, sum(inverse*matrix%diagonal(:, :, i)))
      end do
      bound = 2.0_wp*worst_condition
   end function max_condition

end module dda_block_jacobi
