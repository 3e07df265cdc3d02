! SPDX-License-Identifier: GPL-3.0-or-later
!> The interface of every linear solver of K̂ d = f̂.
!>
!> A solver analyses a pattern, is renewed for new values, and then solves for any number of
!> right-hand sides.  `dda_linear_solver` sums the reported work, checks residuals and changes
!> solvers.
module dda_abstract_solver
   use dda_kinds, only: wp
   use dda_archive, only: archive_type
   use dda_block_matrix, only: block_matrix_type
   use dda_block_vectors, only: add_multiple
   use dda_conjugate_gradients, only: workspace_type
   use dda_errors, only: error_type
   use dda_ordered_sums, only: inner_product
   use dda_rank_one, only: rank_one_type
   implicit none
   private
   public :: equations_type, linear_solver_type, convergence_type, accuracy, acceptable

   real(wp), parameter :: accuracy = 1.0e-11_wp  !< tolerance of ‖r‖/scale
   real(wp), parameter :: acceptable = 1.0e-9_wp  !< ‖r‖/scale above which a solve has failed

   !> largest number of corrections with a factor of an earlier matrix; usually one or two suffice
   integer, parameter :: most_rounds = 4
   !> accepted ‖error‖/‖x‖ with an earlier factor.  In a column of 15 m that moves by 1e-5 m in a
   !> step, this error is about the rounding error of the coordinates
   real(wp), parameter :: accepted_error = 3.0e-11_wp
   real(wp), parameter :: safety = 2.0_wp  !< assumed contraction over the measured one
   real(wp), parameter :: ageing = 1.05_wp  !< growth of the assumed contraction per solve
   real(wp), parameter :: margin = 10.0_wp  !< estimated residual over contraction × residual
   real(wp), parameter :: rounding = 1.0e-15_wp  !< attainable ‖r‖/scale

   !> Requested and reached convergence of a solve.
   type :: convergence_type
      real(wp) :: scale = 0.0_wp                 !< reference value of residuals
      real(wp) :: reduction = 0.0_wp          !< required residual/first residual, or 0
      real(wp) :: residual = 0.0_wp              !< reached ‖r‖/scale
      real(wp) :: least_error = 0.0_wp           !< ‖error‖ that is always negligible, m
      logical :: reached = .false.               !< the iteration has reached the tolerance
   end type convergence_type

   !> Equations K x = b, with or without an assembled K.
   type, abstract :: equations_type
   contains
      procedure(residual_at), deferred :: residual
   end type equations_type

   !> A solution method; types that extend this one add its data.
   type, abstract :: linear_solver_type
      character(len=6) :: name = ''              !< one of `solver_names`
      integer :: factors = 0                     !< number of factors computed by the last call
      integer :: iterations = 0  !< iterations of the last solve; 0: exact factor
      type(workspace_type) :: work
      logical :: reusable = .false.  !< P, a factor of an earlier matrix, is accurate enough
      real(wp) :: contraction = 1.0_wp  !< assumed ratio of successive corrections with P
      real(wp) :: reduction = 1.0_wp    !< ratio of the first two residuals when it was measured
   contains
      procedure(analyse_pattern), deferred :: analyse
      procedure(renew_values), deferred :: renew
      procedure(solve_system), deferred :: solve
      procedure :: renew_shifted => keep_error, correct => correct_nothing, &
         precondition => copy_residual, reuse_factor, serialise => serialise_nothing
   end type linear_solver_type

   abstract interface
      !> Compute the residual r = b − K x.
      subroutine residual_at(self, x, r)
         import :: equations_type, wp
         class(equations_type), intent(in) :: self    !< the equations
         real(wp), intent(in), contiguous :: x(:,:)   !< [6,n] x, m
         real(wp), intent(out), contiguous :: r(:,:)  !< [6,n] residual, N
      end subroutine residual_at

      !> Analyse a new pattern.
      subroutine analyse_pattern(self, matrix)
         import :: linear_solver_type, block_matrix_type
         class(linear_solver_type), intent(inout) :: self  !< the solver
         type(block_matrix_type), intent(in) :: matrix  !< matrix; its values are not read
      end subroutine analyse_pattern

      !> Set new values of a matrix with the analysed pattern.
      subroutine renew_values(self, matrix, changes, error)
         import :: linear_solver_type, block_matrix_type, rank_one_type, error_type
         class(linear_solver_type), intent(inout) :: self  !< the solver
         type(block_matrix_type), intent(in) :: matrix  !< K̂
         type(rank_one_type), intent(in) :: changes  !< changes of the values since the last call
         type(error_type), allocatable, intent(out) :: error  !< a pivot is not positive
      end subroutine renew_values

      !> Solve K x = b; iterations start from the given x.
      subroutine solve_system(self, matrix, b, x, convergence)
         import :: linear_solver_type, block_matrix_type, convergence_type, wp
         class(linear_solver_type), intent(inout) :: self  !< the solver
         type(block_matrix_type), intent(in) :: matrix  !< matrix of the last call of `renew`
         real(wp), intent(in) :: b(6, matrix%n)  !< right-hand side, N
         real(wp), intent(inout) :: x(6, matrix%n)  !< first guess, becomes the solution, m
         type(convergence_type), intent(inout) :: convergence  !< requested and reached convergence
      end subroutine solve_system
   end interface

contains

   !> Factorise the last values with a larger diagonal; default: retain the error.
   subroutine keep_error(self, matrix, error)
      class(linear_solver_type), intent(inout) :: self  !< the solver
      type(block_matrix_type), intent(in) :: matrix  !< K̂
      type(error_type), allocatable, intent(inout) :: error  !< error of `renew`, if any
   end subroutine keep_error

   !> Update x for a change of b by one preconditioner application; default: not possible.
   subroutine correct_nothing(self, n, change, x, success)
      class(linear_solver_type), intent(inout) :: self  !< the solver
      integer, intent(in) :: n  !< number of block rows
      real(wp), intent(in) :: change(6, n)  !< change of the right-hand side, N
      real(wp), intent(inout) :: x(6, n)  !< solution, m
      logical, intent(out) :: success  !< .false.: x is unchanged

      success = .false.
   end subroutine correct_nothing

   !> Compute z = P⁻¹ r; default: P = 1, for solvers without a factor.
   subroutine copy_residual(self, n, r, z)
      class(linear_solver_type), intent(inout) :: self  !< the solver
      integer, intent(in) :: n         !< number of block rows
      real(wp), intent(in) :: r(6, n)  !< residual
      real(wp), intent(out) :: z(6, n)  !< correction of the solution

      z = r
   end subroutine copy_residual

   !> Refine x iteratively with the factor of an earlier matrix: x += P⁻¹ r, r = b − K x.
   !>
   !> A small residual does not prove a small error in directions that only inertia restrains.
   !> Therefore the error after a correction is estimated by the contraction times the correction.
   !> The contraction is measured by two corrections.  In later solves it is assumed to grow slowly,
   !> and as much as the ratio of the first two residuals.  If the residual before the last of
   !> several corrections is acceptable, the residual after it, (P − K) z, is estimated by the
   !> measured contraction with a margin.  P is discarded if some corrections do not suffice.
   subroutine reuse_factor(self, equations, x, convergence, success)
      class(linear_solver_type), intent(inout) :: self  !< the solver
      class(equations_type), intent(in) :: equations    !< equations with nearly the same matrix
      real(wp), intent(inout), contiguous :: x(:,:)  !< [6,n] first guess, becomes the solution, m
      type(convergence_type), intent(inout) :: convergence  !< scale of residuals; reached residual
      logical, intent(out) :: success  !< .false.: x is another first guess
      real(wp) :: length, last_length, norm, last_norm, ratio, growth, error
      integer :: n, round

      success = .false.
      self%iterations = 0
      if (.not. self%reusable) return
      n = size(x, 2)
      associate (r => self%work%r, z => self%work%z)
         call equations%residual(x, r)
         norm = sqrt(inner_product(n, r, r))
         do round = 1, most_rounds
            call self%precondition(n, r, z)
            call add_multiple(n, 1.0_wp, z, x)
            self%iterations = round
            length = sqrt(inner_product(n, z, z))
            if (round > 1) then
               ratio = length/max(last_length, tiny(1.0_wp))
               self%contraction = min(1.0_wp, safety*ratio)
               if (round == 2) self%reduction = norm/max(last_norm, tiny(1.0_wp))
               error = self%contraction*length
               if (norm <= acceptable*convergence%scale) &
                  success = is_accurate(convergence, margin*ratio*norm, error, n, x)
               if (success) exit
            end if
            last_length = length
            last_norm = norm
            call equations%residual(x, r)
            norm = sqrt(inner_product(n, r, r))
            if (round == 1) then
               growth = norm/max(safety*self%reduction*last_norm + rounding*convergence%scale, &
                  tiny(1.0_wp))
               self%contraction = min(1.0_wp, ageing*self%contraction)
               error = min(1.0_wp, self%contraction*max(1.0_wp, growth))*length
            end if
            success = is_accurate(convergence, norm, error, n, x)
            if (success .or. .not. norm < last_norm) exit
         end do
      end associate
      convergence%residual = norm/max(convergence%scale, tiny(1.0_wp))
      self%reusable = success
      if (.not. norm <= huge(1.0_wp)) x = 0.0_wp
   end subroutine reuse_factor

   !> .true. if the residual and the estimated error of x are within their tolerances.
   logical function is_accurate(convergence, residual, error, n, x)
      type(convergence_type), intent(in) :: convergence  !< scale of residuals; least error
      real(wp), intent(in) :: residual  !< ‖r‖, computed or estimated, N
      real(wp), intent(in) :: error     !< estimated ‖error‖ of x, m
      integer, intent(in) :: n          !< number of block rows
      real(wp), intent(in) :: x(6, n)   !< solution, m

      is_accurate = residual <= accuracy*convergence%scale
      if (is_accurate) is_accurate = error <= max(convergence%least_error, &
         accepted_error*sqrt(inner_product(n, x, x)))
   end function is_accurate

   !> Save or restore stored values; default: none, because the solver is rebuilt from the matrix.
   subroutine serialise_nothing(self, matrix, archive)
      class(linear_solver_type), intent(inout) :: self  !< the solver
      type(block_matrix_type), intent(in) :: matrix  !< matrix; only its pattern is read
      type(archive_type), intent(inout) :: archive  !< archive that is written or read
   end subroutine serialise_nothing

end module dda_abstract_solver
