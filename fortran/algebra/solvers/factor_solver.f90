! SPDX-License-Identifier: GPL-3.0-or-later
!> `direct`: a sparse Cholesky factor.
!>
!> The factor is retained while no contact springs change.  One or two steps of iterative refinement
!> correct small changes of geometry (about 1e-6 of the matrix), at a tenth of the cost of a
!> factorisation.
module dda_factor_solver
   use dda_kinds, only: wp
   use dda_abstract_solver, only: equations_type, linear_solver_type, convergence_type, accuracy
   use dda_archive, only: archive_type, archive_values => serialise, fail_archive, serialise_label
   use dda_block_matrix, only: block_matrix_type, multiply
   use dda_cholesky_double, only: factor_type, analyse_sparse => analyse, &
      apply_sparse => apply, prepare_to_read, factorise, solve_sparse => solve
   use dda_conjugate_gradients, only: make_workspace
   use dda_errors, only: error_type
   use dda_ordered_sums, only: inner_product
   use dda_rank_one, only: rank_one_type
   implicit none
   private
   public :: factor_solver_type

   !> largest number of corrections with the factor of the present matrix; more than one is needed
   !> if springs are very stiff
   integer, parameter :: most_rounds = 4

   !> A factor and its accuracy.
   type, extends(linear_solver_type) :: factor_solver_type
      type(factor_type) :: sparse         !< factor of this or an earlier matrix
      logical :: exact = .false.          !< the factor belongs to the present matrix
   contains
      procedure :: analyse, renew, solve, precondition, serialise
   end type factor_solver_type

   !> Equations with an assembled matrix.
   type, extends(equations_type) :: assembled_type
      type(block_matrix_type), pointer :: matrix => null()  !< K
      real(wp), pointer :: b(:,:) => null()                 !< [6,n] right-hand side, N
   contains
      procedure :: residual
   end type assembled_type

contains

   !> Analyse the pattern of a matrix.
   subroutine analyse(self, matrix)
      class(factor_solver_type), intent(inout) :: self  !< the solver
      type(block_matrix_type), intent(in) :: matrix  !< matrix; only its pattern is read

      call make_workspace(self%work, matrix%n)
      call analyse_sparse(self%sparse, matrix)
      self%reusable = .false.
   end subroutine analyse

   !> Factorise the new values, unless the earlier factor is accurate enough.
   subroutine renew(self, matrix, changes, error)
      class(factor_solver_type), intent(inout) :: self  !< the solver
      type(block_matrix_type), intent(in) :: matrix  !< K̂
      type(rank_one_type), intent(in) :: changes  !< changes of the values since the last call
      type(error_type), allocatable, intent(out) :: error  !< a pivot is not positive

      self%exact = .false.
      if (self%reusable .and. changes%n == 0) return
      call make_factor(self, matrix, error)
   end subroutine renew

   !> Factorise a matrix.
   subroutine make_factor(self, matrix, error)
      class(factor_solver_type), intent(inout) :: self  !< the solver
      type(block_matrix_type), intent(in) :: matrix  !< K̂
      type(error_type), allocatable, intent(out) :: error  !< a pivot is not positive

      call factorise(self%sparse, matrix, error)
      self%factors = 1
      self%exact = .not. allocated(error)
      self%reusable = self%exact
      self%contraction = 1.0_wp
   end subroutine make_factor

   !> Solve K x = b, with an earlier factor from the given x, else from zero.
   subroutine solve(self, matrix, b, x, convergence)
      class(factor_solver_type), intent(inout) :: self  !< the solver
      type(block_matrix_type), intent(in) :: matrix  !< K̂
      real(wp), intent(in) :: b(6, matrix%n)  !< right-hand side, N
      real(wp), intent(inout) :: x(6, matrix%n)  !< first guess, becomes the solution, m
      type(convergence_type), intent(inout) :: convergence  !< requested and reached convergence
      type(error_type), allocatable :: error
      logical :: success

      convergence%reached = .false.
      if (.not. self%exact) then
         call refine_assembled(self, matrix, b, x, convergence, success)
         if (success) return
         call make_factor(self, matrix, error)
         if (allocated(error)) return
      end if
      call solve_exactly(self, matrix, b, x, convergence)
   end subroutine solve

   !> Refine the solution of equations with an assembled matrix by an earlier factor.
   subroutine refine_assembled(self, matrix, b, x, convergence, success)
      class(factor_solver_type), intent(inout) :: self  !< the solver
      type(block_matrix_type), intent(in), target :: matrix  !< K̂
      real(wp), intent(in), target :: b(6, matrix%n)  !< right-hand side, N
      real(wp), intent(inout) :: x(6, matrix%n)  !< first guess, becomes the solution, m
      type(convergence_type), intent(inout) :: convergence  !< scale of residuals; reached residual
      logical, intent(out) :: success  !< .false.: x is not the solution
      type(assembled_type) :: equations

      equations%matrix => matrix
      equations%b => b
      call self%reuse_factor(equations, x, convergence, success)
   end subroutine refine_assembled

   !> Solve with the factor of the present matrix; correct the rounding errors of the solution.
   subroutine solve_exactly(self, matrix, b, x, convergence)
      class(factor_solver_type), intent(inout) :: self  !< the solver
      type(block_matrix_type), intent(in) :: matrix  !< K̂
      real(wp), intent(in) :: b(6, matrix%n)  !< right-hand side, N
      real(wp), intent(out) :: x(6, matrix%n)  !< solution, m
      type(convergence_type), intent(inout) :: convergence  !< requested and reached convergence
      integer :: round

      x = 0.0_wp
      self%work%r = b
      self%iterations = 0
      do round = 1, most_rounds
         call solve_sparse(self%sparse, self%work%r, self%work%z)
         x = x + self%work%z
         call multiply(matrix, x, self%work%r)
         self%work%r = b - self%work%r
         convergence%residual = sqrt(inner_product(matrix%n, self%work%r, self%work%r)) &
            /max(convergence%scale, tiny(1.0_wp))
         if (convergence%residual <= accuracy) return
      end do
   end subroutine solve_exactly

   !> Compute the residual of equations with an assembled matrix.
   subroutine residual(self, x, r)
      class(assembled_type), intent(in) :: self    !< equations
      real(wp), intent(in), contiguous :: x(:,:)   !< [6,n] x, m
      real(wp), intent(out), contiguous :: r(:,:)  !< [6,n] residual, N

      call multiply(self%matrix, x, r)
      r = self%b - r
   end subroutine residual

   !> Compute z = P⁻¹ r with the factor of this or an earlier matrix.
   subroutine precondition(self, n, r, z)
      class(factor_solver_type), intent(inout) :: self  !< the solver
      integer, intent(in) :: n         !< number of block rows
      real(wp), intent(in) :: r(6, n)  !< residual
      real(wp), intent(out) :: z(6, n)  !< correction of the solution

      call apply_sparse(self%sparse, r, z)
   end subroutine precondition

   !> Save or restore the values of a factor of an earlier matrix.
   subroutine serialise(self, matrix, archive)
      class(factor_solver_type), intent(inout) :: self  !< the solver
      type(block_matrix_type), intent(in) :: matrix  !< matrix; only its pattern is read
      type(archive_type), intent(inout) :: archive  !< archive that is written or read
      type(error_type), allocatable :: error
      logical, allocatable :: coupled(:)

      call serialise_label(archive, 'factor')
      call archive_values(archive, self%reusable)
      if (.not. self%reusable .or. allocated(archive%failure)) return
      call archive_values(archive, self%contraction)
      call archive_values(archive, self%reduction)
      coupled = self%sparse%coupled
      call archive_values(archive, coupled)
      if (archive%reading) call prepare_to_read(self%sparse, matrix, coupled, error)
      if (allocated(error)) then
         call fail_archive(archive, error%message)
         return
      end if
      call archive_values(archive, self%sparse%packed)
      call archive_values(archive, self%sparse%uses)
   end subroutine serialise

end module dda_factor_solver
