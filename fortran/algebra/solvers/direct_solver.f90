!> `direct`: a sparse Cholesky factor of every matrix.
module dda_direct_solver
   use dda_kinds, only: wp
   use dda_block_matrix, only: block_matrix_type
   use dda_cholesky_double, only: factor_type, analyse_factor => analyse, &
      factorise_matrix => factorise, solve_factor => solve
   use dda_conjugate_gradients, only: make_workspace
   use dda_errors, only: error_type
   use dda_factor_solver, only: factor_solver_type
   implicit none
   private
   public :: direct_solver_type

   !> The factor of the present matrix.
   type, extends(factor_solver_type) :: direct_solver_type
      type(factor_type) :: factor
   contains
      procedure :: analyse
      procedure :: factorise
      procedure :: apply
   end type direct_solver_type

contains

   !> Order and plan the factor.
   subroutine analyse(self, matrix)
      class(direct_solver_type), intent(inout) :: self  !< the solver
      type(block_matrix_type), intent(in) :: matrix  !< its pattern is read

      call make_workspace(self%work, matrix%n)
      call analyse_factor(self%factor, matrix)
   end subroutine analyse

   !> Make the factor of a matrix.
   subroutine factorise(self, matrix, error)
      class(direct_solver_type), intent(inout) :: self  !< the solver
      type(block_matrix_type), intent(in) :: matrix  !< K̂
      type(error_type), allocatable, intent(out) :: error  !< a pivot is not positive

      call factorise_matrix(self%factor, matrix, error)
   end subroutine factorise

   !> x = K⁻¹ b
   subroutine apply(self, b, x)
      class(direct_solver_type), intent(inout) :: self  !< the solver
      real(wp), intent(in) :: b(:,:)   !< [6,n]
      real(wp), intent(out) :: x(:,:)  !< [6,n]

      call solve_factor(self%factor, b, x)
   end subroutine apply

end module dda_direct_solver
