! SPDX-License-Identifier: GPL-3.0-or-later
!> `sor`: block successive over-relaxation, the solver of the original DDA, for comparison.
module dda_sor_solver
   use dda_kinds, only: wp
   use dda_abstract_solver, only: convergence_type, accuracy
   use dda_block_jacobi, only: block_jacobi_type
   use dda_block_matrix, only: block_matrix_type, multiply
   use dda_jacobi_solver, only: jacobi_solver_type
   use dda_ordered_sums, only: inner_product
   implicit none
   private
   public :: sor_solver_type

   integer, parameter :: sweeps_between = 10    !< sweeps between two tests of the residual
   integer, parameter :: stall_sweeps = 1000    !< sweeps in which `stall_reduction` is required
   real(wp), parameter :: stall_reduction = 0.1_wp  !< reduction of the residual
   real(wp), parameter :: omega = 1.5_wp        !< relaxation factor of the original DDA
   real(wp), parameter :: diverged = 1.0e30_wp  !< residual at which the iteration diverges

   !> Inverse diagonal blocks of the matrix, used in SOR sweeps.
   type, extends(jacobi_solver_type) :: sor_solver_type
   contains
      procedure :: solve
   end type sor_solver_type

contains

   !> Sweep until ‖r‖ ≤ accuracy·‖b‖, the requested reduction is reached, or convergence is slow.
   !> Slow convergence is due to rounding errors or to a matrix that is not definite.
   subroutine solve(self, matrix, b, x, convergence)
      class(sor_solver_type), intent(inout) :: self  !< the solver
      type(block_matrix_type), intent(in) :: matrix  !< K̂
      real(wp), intent(in) :: b(6, matrix%n)  !< right-hand side, N
      real(wp), intent(inout) :: x(6, matrix%n)  !< first guess, becomes the solution, m
      type(convergence_type), intent(inout) :: convergence  !< convergence; scale is set to ‖b‖
      real(wp) :: size_of_b, target, limit

      self%iterations = 0
      size_of_b = sqrt(inner_product(matrix%n, b, b))
      convergence%residual = 0.0_wp
      convergence%reached = .false.
      target = diverged
      limit = accuracy
      associate (r => self%work%r)
         do
            if (modulo(self%iterations, sweeps_between) == 0) then
               call multiply(matrix, x, r)
               r = b - r
               convergence%residual = sqrt(inner_product(matrix%n, r, r)) &
                  /max(size_of_b, tiny(1.0_wp))
               if (self%iterations == 0) limit = max(accuracy, &
                  convergence%reduction*convergence%residual)
               convergence%reached = convergence%residual <= limit
               if (convergence%reached) return
               if (modulo(self%iterations, stall_sweeps) == 0) then
                  if (.not. convergence%residual < target) return
                  target = stall_reduction*convergence%residual
               end if
            end if
            call sweep(matrix, self%diagonal, b, x)
            self%iterations = self%iterations + 1
         end do
      end associate
   end subroutine solve

   !> Update all block rows once.
   pure subroutine sweep(matrix, diagonal, b, x)
      type(block_matrix_type), intent(in) :: matrix  !< K̂
      type(block_jacobi_type), intent(in) :: diagonal  !< inverse diagonal blocks
      real(wp), intent(in) :: b(6, matrix%n)  !< right-hand side, N
      real(wp), intent(inout) :: x(6, matrix%n)  !< first guess, becomes the solution, m
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
         x(:, i) = (1.0_wp - omega)*x(:, i) + omega*matmul(diagonal%inverse(:, :, i), row)
      end do
   end subroutine sweep

end module dda_sor_solver
