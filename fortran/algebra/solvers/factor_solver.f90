!> Solvers with an exact factor: one solve, and one step of iterative refinement where rounding asks
!> for it.
module dda_factor_solver
   use dda_kinds, only: wp
   use dda_abstract_solver, only: linear_solver_type, convergence_type, accuracy
   use dda_block_matrix, only: block_matrix_type, multiply
   use dda_errors, only: error_type
   use dda_ordered_sums, only: inner_product
   use dda_rank_one, only: rank_one_type
   implicit none
   private
   public :: factor_solver_type

   !> A solver whose factor answers x = K⁻¹ b to rounding.
   type, abstract, extends(linear_solver_type) :: factor_solver_type
   contains
      procedure(factorise_values), deferred :: factorise
      procedure(apply_factor), deferred :: apply
      procedure :: renew => renew_factor
      procedure :: solve => solve_and_refine
   end type factor_solver_type

   abstract interface
      !> Make the factor of a matrix with the analysed pattern.
      subroutine factorise_values(self, matrix, error)
         import :: factor_solver_type, block_matrix_type, error_type
         class(factor_solver_type), intent(inout) :: self  !< the solver
         type(block_matrix_type), intent(in) :: matrix  !< K̂
         type(error_type), allocatable, intent(out) :: error  !< it is not positive definite
      end subroutine factorise_values

      !> x = K⁻¹ b with the factor at hand.
      subroutine apply_factor(self, b, x)
         import :: factor_solver_type, wp
         class(factor_solver_type), intent(inout) :: self  !< the solver
         real(wp), intent(in) :: b(:,:)   !< [6,n]
         real(wp), intent(out) :: x(:,:)  !< [6,n]
      end subroutine apply_factor
   end interface

contains

   !> Factorise the new values.
   subroutine renew_factor(self, matrix, changes, error)
      class(factor_solver_type), intent(inout) :: self  !< the solver
      type(block_matrix_type), intent(in) :: matrix  !< K̂
      type(rank_one_type), intent(in) :: changes  !< not used
      type(error_type), allocatable, intent(out) :: error  !< a pivot is not positive

      call self%factorise(matrix, error)
      self%factors = 1
   end subroutine renew_factor

   !> x = K⁻¹ b; the x given is not used.
   subroutine solve_and_refine(self, matrix, b, x, convergence)
      class(factor_solver_type), intent(inout) :: self  !< the solver
      type(block_matrix_type), intent(in) :: matrix  !< K̂
      real(wp), intent(in) :: b(6, matrix%n)  !< right-hand side, N
      real(wp), intent(inout) :: x(6, matrix%n)  !< solution, m
      type(convergence_type), intent(inout) :: convergence  !< asked and reached
      integer :: round

      x = 0.0_wp
      convergence%enough = .false.
      associate (work => self%work)
         call self%apply(b, work%z)
         do round = 1, 2
            x = x + work%z
            call multiply(matrix, x, work%q)
            work%r = b - work%q
            convergence%residual = sqrt(inner_product(matrix%n, work%r, work%r)) &
               /max(convergence%scale, tiny(1.0_wp))
            if (convergence%residual <= accuracy .or. round == 2) return
            call self%apply(work%r, work%z)
         end do
      end associate
   end subroutine solve_and_refine

end module dda_factor_solver
