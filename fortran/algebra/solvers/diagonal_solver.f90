!> Iterations with the inverse diagonal blocks: what `jacobi` and `sor` have in common.
module dda_diagonal_solver
   use dda_abstract_solver, only: linear_solver_type
   use dda_block_jacobi, only: block_jacobi_type, invert_diagonal
   use dda_block_matrix, only: block_matrix_type
   use dda_conjugate_gradients, only: make_workspace
   use dda_errors, only: error_type
   use dda_rank_one, only: rank_one_type
   implicit none
   private
   public :: diagonal_solver_type

   !> The inverse diagonal blocks of the present matrix.
   type, abstract, extends(linear_solver_type) :: diagonal_solver_type
      type(block_jacobi_type) :: diagonal
   contains
      procedure :: analyse
      procedure :: renew
   end type diagonal_solver_type

contains

   !> Only the vectors of the iteration depend on the pattern.
   subroutine analyse(self, matrix)
      class(diagonal_solver_type), intent(inout) :: self  !< the solver
      type(block_matrix_type), intent(in) :: matrix  !< its pattern is read

      call make_workspace(self%work, matrix%n)
   end subroutine analyse

   !> Invert the diagonal blocks of the new values.
   subroutine renew(self, matrix, changes, error)
      class(diagonal_solver_type), intent(inout) :: self  !< the solver
      type(block_matrix_type), intent(in) :: matrix  !< K̂
      type(rank_one_type), intent(in) :: changes           !< not used
      type(error_type), allocatable, intent(out) :: error  !< never

      call invert_diagonal(self%diagonal, matrix)
   end subroutine renew

end module dda_diagonal_solver
