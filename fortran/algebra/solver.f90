!> K̂ d = f̂ behind one interface: analyse a pattern, factorise values, solve.
module dda_solver
   use dda_kinds, only: wp
   use dda_errors, only: error_type, error_input, error_solver, fail
   use dda_text, only: quoted
   use dda_block_matrix, only: block_matrix_type
   use dda_band_cholesky, only: band_cholesky_type, analyse_band, factorise_band, solve_band
   implicit none
   private
   public :: solver_type, choose_solver, analyse, factorise, solve

   !> A solver chosen by name, with its factor.
   type :: solver_type
      character(len=16) :: name = 'banded'
      type(band_cholesky_type) :: band
   end type solver_type

contains

   !> Choose by name: 'auto' or 'banded'.
   subroutine choose_solver(solver, name, error)
      type(solver_type), intent(out) :: solver
      character(len=*), intent(in) :: name
      type(error_type), allocatable, intent(out) :: error

      select case (name)
      case ('auto', 'banded')
         solver%name = 'banded'
      case default
         call fail(error, error_input, 'solver '//quoted(name)//" is not known; use 'auto' or 'banded'")
      end select
   end subroutine choose_solver

   !> Prepare for a pattern; needed again only when the pattern changes.
   subroutine analyse(solver, matrix)
      type(solver_type), intent(inout) :: solver
      type(block_matrix_type), intent(in) :: matrix

      call analyse_band(solver%band, matrix)
   end subroutine analyse

   !> Factorise the values of a matrix with the analysed pattern.
   subroutine factorise(solver, matrix, error)
      type(solver_type), intent(inout) :: solver
      type(block_matrix_type), intent(in) :: matrix
      type(error_type), allocatable, intent(out) :: error

      call factorise_band(solver%band, matrix, error)
   end subroutine factorise

   !> x = K⁻¹ b with the last factor.
   subroutine solve(solver, b, x, error)
      type(solver_type), intent(inout) :: solver
      real(wp), intent(in) :: b(:,:)   !< [6,n]
      real(wp), intent(inout) :: x(:,:)  !< [6,n]
      type(error_type), allocatable, intent(out) :: error

      call solve_band(solver%band, b, x)
      if (.not. all(abs(x) <= huge(1.0_wp))) call fail(error, error_solver, 'the solution of the step is not finite')
   end subroutine solve

end module dda_solver
