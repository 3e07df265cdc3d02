!> `jacobi`: conjugate gradients with the inverse diagonal blocks, for small p Δt²/m.
module dda_jacobi_solver
   use dda_kinds, only: wp
   use dda_abstract_solver, only: convergence_type, accuracy
   use dda_block_matrix, only: block_matrix_type
   use dda_conjugate_gradients, only: iterate_to_solution
   use dda_diagonal_solver, only: diagonal_solver_type
   implicit none
   private
   public :: jacobi_solver_type

   integer, parameter :: most_iterations = 3000

   !> Its state is that of the parent type.
   type, extends(diagonal_solver_type) :: jacobi_solver_type
   contains
      procedure :: solve
   end type jacobi_solver_type

contains

   !> Iterate from the x given.
   subroutine solve(self, matrix, b, x, convergence)
      class(jacobi_solver_type), intent(inout) :: self  !< the solver
      type(block_matrix_type), intent(in) :: matrix  !< K̂
      real(wp), intent(in) :: b(6, matrix%n)  !< right-hand side, N
      real(wp), intent(inout) :: x(6, matrix%n)  !< first guess, becomes the solution, m
      type(convergence_type), intent(inout) :: convergence  !< asked and reached

      call iterate_to_solution(matrix, self%diagonal, b, convergence%scale, x, accuracy, &
         convergence%reduction, most_iterations, self%work, self%iterations, &
         convergence%residual, convergence%enough)
   end subroutine solve

end module dda_jacobi_solver
