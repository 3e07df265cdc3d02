! SPDX-License-Identifier: GPL-3.0-or-later
!> `direct`: a sparse Cholesky factor.
!>
!> The factor is retained while no contact springs change.  One or two steps of iterative refinement
!> correct small changes of geometry (about 1e-6 of the matrix), at a tenth of the cost of a
!> factorisation.
module dda_factor_solver
   use dda_kinds, only: wp
   use dda_abstract_solver, only: equations_type, linear_solver_type, convergence_type, &
      accuracy
   use dda_archive, only: archive_type, archive_values => serialise, fail_archive, serialise_label
   use dda_block_matrix, only: block_matrix_type, multiply
   use dda_cholesky_double, only: factor_type, analyse_sparse => analyse, prepare_to_read, &
      factorise, solve_sparse => solve
   use dda_conjugate_gradients, only: make_workspace
   use dda_errors, only: error_type
   use dda_ordered_sums, only: inner_product
   use dda_rank_one, only: rank_one_type
   implicit none
   private
   public :: factor_solver_type

   !> largest number of refinement steps with an earlier factor; then a new factor is computed.
   !> With the factor of the present matrix, one step usually suffices, more if springs are very
   !> stiff
   integer, parameter :: most_rounds = 4

   real(wp), parameter :: accepted_growth = 2.0_wp  !< allowed growth of the contraction factor

   !> A factor and its accuracy.
   type, extends(linear_solver_type) :: factor_solver_type
      type(factor_type) :: sparse         !< factor of this or an earlier matrix
      logical :: reusable = .false.       !< the factor is reused while no spring changes
      logical :: exact = .false.          !< the factor belongs to the present matrix
      real(wp) :: contraction = 1.0_wp    !< ratio of successive corrections with an earlier factor
      real(wp) :: last_correction = 0.0_wp  !< length of the last correction
   contains
      procedure :: analyse
      procedure :: renew
      procedure :: solve
      procedure :: reuse_factor
      procedure :: serialise
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

      convergence%reached = .false.
      if (.not. self%exact) then
         if (self%reusable) call refine_assembled(self, matrix, b, x, convergence)
         if (self%reusable) return
         call make_factor(self, matrix, error)
         if (allocated(error)) return
      end if
      call refine_assembled(self, matrix, b, x, convergence)
   end subroutine solve

   !> Refine the solution of equations with an assembled matrix.
   subroutine refine_assembled(self, matrix, b, x, convergence)
      class(factor_solver_type), intent(inout) :: self  !< the solver
      type(block_matrix_type), intent(in), target :: matrix  !< K̂
      real(wp), intent(in), target :: b(6, matrix%n)  !< right-hand side, N
      real(wp), intent(inout) :: x(6, matrix%n)  !< first guess, becomes the solution, m
      type(convergence_type), intent(inout) :: convergence  !< requested and reached convergence
      type(assembled_type) :: equations

      equations%matrix => matrix
      equations%b => b
      if (self%exact) then
         x = 0.0_wp
         self%work%r = b
      else
         call equations%residual(x, self%work%r)
      end if
      call refine(self, equations, x, convergence)
   end subroutine refine_assembled

   !> Refine x with the factor of an earlier matrix; discard the factor if it is too inaccurate.
   subroutine reuse_factor(self, equations, x, convergence, success)
      class(factor_solver_type), intent(inout) :: self  !< the solver
      class(equations_type), intent(in) :: equations    !< equations with nearly the same matrix
      real(wp), intent(inout), contiguous :: x(:,:)  !< [6,n] first guess, becomes the solution, m
      type(convergence_type), intent(inout) :: convergence  !< requested and reached convergence
      logical, intent(out) :: success  !< .false.: x is not the solution

      self%exact = .false.
      if (self%reusable) then
         call equations%residual(x, self%work%r)
         call refine(self, equations, x, convergence)
      end if
      success = self%reusable
   end subroutine reuse_factor

   !> Compute the residual of equations with an assembled matrix.
   subroutine residual(self, x, r)
      class(assembled_type), intent(in) :: self    !< equations
      real(wp), intent(in), contiguous :: x(:,:)   !< [6,n] x, m
      real(wp), intent(out), contiguous :: r(:,:)  !< [6,n] residual, N

      call multiply(self%matrix, x, r)
      r = self%b - r
   end subroutine residual

   !> Refine x iteratively: x += P⁻¹ r, r = b − K x, from the residual in `work`.
   subroutine refine(self, equations, x, convergence)
      class(factor_solver_type), intent(inout) :: self  !< the solver
      class(equations_type), intent(in) :: equations    !< K x = b
      real(wp), intent(inout), contiguous :: x(:,:)  !< [6,n] first guess, becomes the solution, m
      type(convergence_type), intent(inout) :: convergence  !< requested and reached convergence
      integer :: round

      associate (work => self%work)
         do round = 1, most_rounds
            call solve_sparse(self%sparse, work%r, work%z)
            x = x + work%z
            self%iterations = merge(0, round, self%exact)
            call equations%residual(x, work%r)
            convergence%residual = sqrt(inner_product(size(x, 2), work%r, work%r)) &
               /max(convergence%scale, tiny(1.0_wp))
            if (self%exact .and. convergence%residual <= accuracy) return
            if (self%exact) cycle
            self%reusable = is_accurate_enough(self, x, round) .and. &
               convergence%residual <= accuracy
            if (self%reusable) return
         end do
      end associate
   end subroutine refine

   !> .true. if the next correction would be negligible.
   !>
   !> A small residual does not prove a small error in directions that only inertia restrains, so
   !> the remaining error is estimated from the ratio of two successive corrections.
   logical function is_accurate_enough(self, x, round)  ! total
      class(factor_solver_type), intent(inout) :: self  !< the solver; `work` has the correction
      real(wp), intent(in), contiguous :: x(:,:)  !< [6,n] solution, m
      integer, intent(in) :: round    !< number of the correction, from 1
      real(wp) :: length

      length = sqrt(inner_product(size(x, 2), self%work%z, self%work%z))
      if (round == 1) then
         self%contraction = min(1.0_wp, accepted_growth*self%contraction)
      else
         self%contraction = min(1.0_wp, length/max(self%last_correction, tiny(1.0_wp)))
      end if
      self%last_correction = length
      is_accurate_enough = self%contraction*length <= accuracy*sqrt(inner_product(size(x, 2), x, x))
   end function is_accurate_enough

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
      coupled = self%sparse%coupled
      call archive_values(archive, coupled)
      if (archive%reading) call prepare_to_read(self%sparse, matrix, coupled, error)
      if (allocated(error)) then
         call fail_archive(archive, error%message)
         return
      end if
      call archive_values(archive, self%sparse%packed)
   end subroutine serialise

end module dda_factor_solver
