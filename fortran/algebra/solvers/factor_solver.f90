! SPDX-License-Identifier: GPL-3.0-or-later
!> `direct` and `banded`: an exact factor of every matrix, sparse or (for comparison, and for long
!> narrow models) a band; one solve, and one step of iterative refinement where rounding asks for
!> it.
module dda_factor_solver
   use dda_kinds, only: wp
   use dda_abstract_solver, only: linear_solver_type, convergence_type, accuracy
   use dda_band_cholesky, only: band_cholesky_type, analyse_band, factorise_band, solve_band
   use dda_block_matrix, only: block_matrix_type, multiply
   use dda_cholesky_double, only: factor_type, analyse_sparse => analyse, &
      factorise_sparse => factorise, solve_sparse => solve
   use dda_conjugate_gradients, only: make_workspace
   use dda_errors, only: error_type
   use dda_ordered_sums, only: inner_product
   use dda_rank_one, only: rank_one_type
   implicit none
   private
   public :: factor_solver_type

   !> The factor of the present matrix; the name says which of the two it is.
   type, extends(linear_solver_type) :: factor_solver_type
      type(factor_type) :: sparse         !< of 'direct'
      type(band_cholesky_type) :: band    !< of 'banded'
   contains
      procedure :: analyse
      procedure :: renew
      procedure :: solve
   end type factor_solver_type

contains

   !> Order the rows and plan the factor.
   subroutine analyse(self, matrix)
      class(factor_solver_type), intent(inout) :: self  !< the solver
      type(block_matrix_type), intent(in) :: matrix  !< its pattern is read

      call make_workspace(self%work, matrix%n)
      if (self%name == 'banded') then
         call analyse_band(self%band, matrix)
      else
         call analyse_sparse(self%sparse, matrix)
      end if
   end subroutine analyse

   !> Factorise the new values.
   subroutine renew(self, matrix, changes, error)
      class(factor_solver_type), intent(inout) :: self  !< the solver
      type(block_matrix_type), intent(in) :: matrix  !< K̂
      type(rank_one_type), intent(in) :: changes  !< not used
      type(error_type), allocatable, intent(out) :: error  !< a pivot is not positive

      if (self%name == 'banded') then
         call factorise_band(self%band, matrix, error)
      else
         call factorise_sparse(self%sparse, matrix, error)
      end if
      self%factors = 1
   end subroutine renew

   !> x = K⁻¹ b; the x given is not used.
   subroutine solve(self, matrix, b, x, convergence)
      class(factor_solver_type), intent(inout) :: self  !< the solver
      type(block_matrix_type), intent(in) :: matrix  !< K̂
      real(wp), intent(in) :: b(6, matrix%n)  !< right-hand side, N
      real(wp), intent(inout) :: x(6, matrix%n)  !< solution, m
      type(convergence_type), intent(inout) :: convergence  !< asked and reached
      integer :: round

      x = 0.0_wp
      convergence%enough = .false.
      associate (work => self%work)
         work%r = b
         do round = 1, 2
            if (self%name == 'banded') then
               call solve_band(self%band, work%r, work%z)
            else
               call solve_sparse(self%sparse, work%r, work%z)
            end if
            x = x + work%z
            call multiply(matrix, x, work%q)
            work%r = b - work%q
            convergence%residual = sqrt(inner_product(matrix%n, work%r, work%r)) &
               /max(convergence%scale, tiny(1.0_wp))
            if (convergence%residual <= accuracy) return
         end do
      end associate
   end subroutine solve

end module dda_factor_solver
