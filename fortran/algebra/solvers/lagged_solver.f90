! SPDX-License-Identifier: GPL-3.0-or-later
!> `lagged`: conjugate gradients with a lagged factor as preconditioner.
!>
!> The factor is retained while a low-rank update can include the changed terms, and until the
!> additional iterations have cost as much as a new factor.
module dda_lagged_solver
   use dda_kinds, only: wp
   use dda_abstract_solver, only: linear_solver_type, convergence_type, accuracy
   use dda_archive, only: archive_type, serialise, serialise_label, serialise_list, &
      serialise_number, fail_archive
   use dda_block_matrix, only: block_matrix_type
   use dda_block_vectors, only: add_multiple
   use dda_cholesky_single, only: prepare_to_read
   use dda_conjugate_gradients, only: make_workspace, iterate_to_solution
   use dda_errors, only: error_type
   use dda_lagged_factor, only: lagged_factor_type, analyse_lagged, refactorise
   use dda_low_rank, only: plan_low_rank, update_low_rank, rebuild_low_rank
   use dda_rank_one, only: rank_one_type, most_changes
   implicit none
   private
   public :: lagged_solver_type

   integer, parameter :: most_iterations = 60
   integer, parameter :: usual_iterations = 4  !< iterations with a new factor
   integer, parameter :: factor_cost = 8       !< extra iterations with the cost of a new factor

   !> A factor of this or an earlier matrix.
   type, extends(linear_solver_type) :: lagged_solver_type
      type(lagged_factor_type) :: lagged
   contains
      procedure :: analyse, renew, renew_shifted, solve, correct, precondition, &
         serialise => serialise_factor
   end type lagged_solver_type

contains

   !> Analyse the pattern for the factor.
   subroutine analyse(self, matrix)
      class(lagged_solver_type), intent(inout) :: self  !< the solver
      type(block_matrix_type), intent(in) :: matrix  !< matrix; only its pattern is read

      call make_workspace(self%work, matrix%n)
      call analyse_lagged(self%lagged, matrix)
      self%reusable = .false.
   end subroutine analyse

   !> Update the factor, or compute a new one.
   subroutine renew(self, matrix, changes, error)
      class(lagged_solver_type), intent(inout) :: self  !< the solver
      type(block_matrix_type), intent(in) :: matrix  !< K̂
      type(rank_one_type), intent(in) :: changes  !< changes of the values since the last call
      type(error_type), allocatable, intent(out) :: error  !< a pivot is not positive
      logical :: reusable

      reusable = self%lagged%factorised .and. self%lagged%extra_iterations <= factor_cost
      if (reusable .and. changes%n > 0) &
         call update_low_rank(self%lagged%update, self%lagged%factor, changes, reusable)
      if (reusable .and. changes%n > 0) then
         self%reusable = .true.
         self%contraction = 1.0_wp
      end if
      if (.not. reusable) call make_factor(self, matrix, .false., error)
   end subroutine renew

   !> Factorise a matrix.
   subroutine make_factor(self, matrix, shifted, error)
      class(lagged_solver_type), intent(inout) :: self  !< the solver
      type(block_matrix_type), intent(in) :: matrix  !< K̂
      logical, intent(in) :: shifted  !< factorise with a larger diagonal
      type(error_type), allocatable, intent(out) :: error  !< a pivot is not positive

      call refactorise(self%lagged, matrix, error, shifted)
      self%factors = 1
      self%reusable = .not. allocated(error)
      self%contraction = 1.0_wp
   end subroutine make_factor

   !> Factorise with a larger diagonal if rounding in single precision has made a pivot negative.
   subroutine renew_shifted(self, matrix, error)
      class(lagged_solver_type), intent(inout) :: self  !< the solver
      type(block_matrix_type), intent(in) :: matrix  !< K̂
      type(error_type), allocatable, intent(inout) :: error  !< error of `renew`, if any

      call make_factor(self, matrix, .true., error)
   end subroutine renew_shifted

   !> Solve by iteration; compute a new factor if the old one needs too many iterations.
   subroutine solve(self, matrix, b, x, convergence)
      class(lagged_solver_type), intent(inout) :: self  !< the solver
      type(block_matrix_type), intent(in) :: matrix  !< K̂
      real(wp), intent(in) :: b(6, matrix%n)  !< right-hand side, N
      real(wp), intent(inout) :: x(6, matrix%n)  !< first guess, becomes the solution, m
      type(convergence_type), intent(inout) :: convergence  !< requested and reached convergence
      type(error_type), allocatable :: error
      integer :: attempt

      do attempt = 1, 2
         call iterate_to_solution(matrix, self%lagged, b, convergence%scale, x, accuracy, &
            convergence%reduction, most_iterations, self%work, self%iterations, &
            convergence%residual, convergence%reached)
         self%lagged%extra_iterations = self%lagged%extra_iterations &
            + max(0, self%iterations - usual_iterations)
         if (convergence%reached .or. attempt == 2) return
         call make_factor(self, matrix, .false., error)
         if (allocated(error)) return
         x = 0.0_wp
      end do
   end subroutine solve

   !> Compute z = P⁻¹ r.
   subroutine precondition(self, n, r, z)
      class(lagged_solver_type), intent(inout) :: self  !< the solver
      integer, intent(in) :: n         !< number of block rows
      real(wp), intent(in) :: r(6, n)  !< residual
      real(wp), intent(out) :: z(6, n)  !< correction of the solution

      call self%lagged%apply(n, r, z)
   end subroutine precondition

   !> Compute x = x + P⁻¹ change, if the last solve with this matrix took one application of P⁻¹.
   subroutine correct(self, n, change, x, success)
      class(lagged_solver_type), intent(inout) :: self  !< the solver
      integer, intent(in) :: n  !< number of block rows
      real(wp), intent(in) :: change(6, n)  !< change of the right-hand side, N
      real(wp), intent(inout) :: x(6, n)  !< solution, m
      logical, intent(out) :: success  !< .false.: x is unchanged

      success = self%iterations == 1
      if (.not. success) return
      call self%lagged%apply(n, change, self%work%z)
      call add_multiple(n, 1.0_wp, self%work%z, x)
   end subroutine correct

   !> Save or restore the values of the factor of an earlier matrix.
   subroutine serialise_factor(self, matrix, archive)
      class(lagged_solver_type), intent(inout) :: self  !< the solver
      type(block_matrix_type), intent(in) :: matrix  !< matrix; only its pattern is read
      type(archive_type), intent(inout) :: archive  !< archive that is written or read
      type(error_type), allocatable :: error
      logical, allocatable :: coupled(:)

      call serialise_label(archive, 'factor')
      call serialise(archive, self%lagged%factorised)
      call serialise(archive, self%lagged%extra_iterations)
      call serialise(archive, self%reusable)
      call serialise(archive, self%contraction)
      call serialise(archive, self%reduction)
      if (.not. self%lagged%factorised .or. allocated(archive%failure)) return
      coupled = self%lagged%factor%coupled
      call serialise(archive, coupled)
      if (archive%reading) call prepare_to_read(self%lagged%factor, matrix, coupled, error)
      call plan_low_rank(self%lagged%update, self%lagged%factor%plan, error)
      if (allocated(error)) then
         call fail_archive(archive, error%message)
         return
      end if
      call serialise(archive, self%lagged%factor%packed)
      call serialise_changes(archive, self%lagged)
   end subroutine serialise_factor

   !> Save or restore the terms that have changed since the factorisation, and update the factor.
   subroutine serialise_changes(archive, lagged)
      type(archive_type), intent(inout) :: archive  !< archive that is written or read
      !> receives the terms and the update for them
      type(lagged_factor_type), intent(inout) :: lagged
      logical :: success
      integer :: i

      associate (terms => lagged%update%terms)
         call serialise_number(archive, terms%n, 0, most_changes)
         do i = 1, terms%n
            call serialise_list(archive, terms%block(:, i), 1, lagged%factor%plan%n)
         end do
         call serialise(archive, terms%u(:, :, :terms%n))
         call serialise(archive, terms%k(:terms%n))
         if (.not. archive%reading .or. allocated(archive%failure)) return
      end associate
      call rebuild_low_rank(lagged%update, lagged%factor, 1, success)
      if (.not. success) call fail_archive(archive, 'the changed terms do not match the factor')
   end subroutine serialise_changes

end module dda_lagged_solver
