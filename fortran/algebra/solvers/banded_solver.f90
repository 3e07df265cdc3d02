!> `banded`: the band factor of LAPACK, for comparison and for long narrow models.
module dda_banded_solver
   use dda_kinds, only: wp
   use dda_block_matrix, only: block_matrix_type
   use dda_band_cholesky, only: band_cholesky_type, analyse_band, factorise_band, solve_band
   use dda_conjugate_gradients, only: make_workspace
   use dda_errors, only: error_type
   use dda_factor_solver, only: factor_solver_type
   implicit none
   private
   public :: banded_solver_type

   !> The factor of the present matrix.
   type, extends(factor_solver_type) :: banded_solver_type
      type(band_cholesky_type) :: factor
   contains
      procedure :: analyse
      procedure :: factorise
      procedure :: apply
   end type banded_solver_type

contains

   !> Order the rows and lay out the band.
   subroutine analyse(self, matrix)
      class(banded_solver_type), intent(inout) :: self  !< the solver
      type(block_matrix_type), intent(in) :: matrix  !< its pattern is read

      call make_workspace(self%work, matrix%n)
      call analyse_band(self%factor, matrix)
   end subroutine analyse

   !> Make the factor of a matrix.
   subroutine factorise(self, matrix, error)
      class(banded_solver_type), intent(inout) :: self  !< the solver
      type(block_matrix_type), intent(in) :: matrix  !< K̂
      type(error_type), allocatable, intent(out) :: error  !< a pivot is not positive

      call factorise_band(self%factor, matrix, error)
   end subroutine factorise

   !> x = K⁻¹ b
   subroutine apply(self, b, x)
      class(banded_solver_type), intent(inout) :: self  !< the solver
      real(wp), intent(in) :: b(:,:)   !< [6,n]
      real(wp), intent(out) :: x(:,:)  !< [6,n]

      call solve_band(self%factor, b, x)
   end subroutine apply

end module dda_banded_solver
