! SPDX-License-Identifier: GPL-3.0-or-later
!> `jacobi`: conjugate gradients preconditioned by the diagonal blocks, for small p Δt²/m.
module dda_jacobi_solver
   use dda_kinds, only: wp
   use dda_abstract_solver, only: linear_solver_type, convergence_type, accuracy
   use dda_block_jacobi, only: block_jacobi_type, invert_diagonal
   use dda_block_matrix, only: block_matrix_type
   use dda_conjugate_gradients, only: make_workspace, iterate_to_solution
   use dda_errors, only: error_type
   use dda_rank_one, only: rank_one_type
   implicit none
   private
   public :: jacobi_solver_type

   integer, parameter :: most_iterations = 3000

   !> Inverse diagonal blocks of the present matrix.
   type, extends(linear_solver_type) :: jacobi_solver_type
      type(block_jacobi_type) :: diagonal
   contains
      procedure :: analyse, renew, solve
   end type jacobi_solver_type

contains

   !> Allocate the vectors of the iteration, which depend only on the pattern.
   subroutine analyse(self, matrix)
      class(jacobi_solver_type), intent(inout) :: self  !< the solver
      type(block_matrix_type), intent(in) :: matrix  !< matrix; only its pattern is read

      call make_workspace(self%work, matrix%n)
   end subroutine analyse

   !> Invert the diagonal blocks of the new values.
   subroutine renew(self, matrix, changes, error)
      class(jacobi_solver_type), intent(inout) :: self  !< the solver
      type(block_matrix_type), intent(in) :: matrix  !< K̂
      type(rank_one_type), intent(in) :: changes           !< not used
      type(error_type), allocatable, intent(out) :: error  !< never allocated

      call invert_diagonal(self%diagonal, matrix)
   end subroutine renew

   !> Solve by conjugate gradients from the given x.
   subroutine solve(self, matrix, b, x, convergence)
      class(jacobi_solver_type), intent(inout) :: self  !< the solver
      type(block_matrix_type), intent(in) :: matrix  !< K̂
      real(wp), intent(in) :: b(6, matrix%n)  !< right-hand side, N
      real(wp), intent(inout) :: x(6, matrix%n)  !< first guess, becomes the solution, m
      type(convergence_type), intent(inout) :: convergence  !< requested and reached convergence

      call iterate_to_solution(matrix, self%diagonal, b, convergence%scale, x, accuracy, &
         convergence%reduction, most_iterations, self%work, self%iterations, &
         convergence%residual, convergence%reached)
   end subroutine solve

end module dda_jacobi_solver
