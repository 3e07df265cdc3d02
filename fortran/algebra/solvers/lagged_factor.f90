! SPDX-License-Identifier: GPL-3.0-or-later
!> A lagged Cholesky factor, in single precision, as preconditioner of conjugate gradients.
!>
!> A low-rank update includes terms that have been added or removed since the factorisation; other
!> changes cost iterations, two or three if only the geometry changes.
module dda_lagged_factor
   use dda_kinds, only: sp, wp
   use dda_block_matrix, only: block_matrix_type
   use dda_conjugate_gradients, only: preconditioner_type
   use dda_cholesky_single, only: factor_type, analyse, factorise, solve, solve_lower, solve_upper
   use dda_errors, only: error_type
   use dda_low_rank, only: low_rank_type, plan_low_rank, free_low_rank, correct
   use dda_rank_one, only: forget_changes
   implicit none
   private
   public :: lagged_factor_type, analyse_lagged, refactorise

   real(sp), parameter :: shift = 16*epsilon(1.0_sp)  !< diagonal shift, in rounding errors

   !> The factor and its age.
   type, extends(preconditioner_type) :: lagged_factor_type
      type(factor_type) :: factor
      type(low_rank_type) :: update                 !< update for the changed terms
      logical :: factorised = .false.            !< a factor exists for this pattern
      integer :: extra_iterations = 0            !< iterations in excess of a new factor, summed
   contains
      procedure :: apply
   end type lagged_factor_type

contains

   !> Set a new pattern.
   subroutine analyse_lagged(lagged, matrix)
      type(lagged_factor_type), intent(inout) :: lagged  !< on return without a factor
      type(block_matrix_type), intent(in) :: matrix  !< matrix; only its pattern is read

      call analyse(lagged%factor, matrix)
      call free_low_rank(lagged%update)
      lagged%factorised = .false.
   end subroutine analyse_lagged

   !> Factorise the present matrix as preconditioner, with a larger diagonal if `shifted`.
   subroutine refactorise(lagged, matrix, error, shifted)
      type(lagged_factor_type), intent(inout) :: lagged  !< receives a new factor
      type(block_matrix_type), intent(in) :: matrix  !< K̂
      !> memory error, or a pivot that is not positive in single precision
      type(error_type), allocatable, intent(out) :: error
      logical, intent(in) :: shifted  !< factorise with a larger diagonal

      lagged%factor%shift = merge(shift, 0.0_sp, shifted)
      call factorise(lagged%factor, matrix, error)
      if (lagged%factor%replanned) call free_low_rank(lagged%update)
      call plan_low_rank(lagged%update, lagged%factor%plan, error)
      lagged%factorised = .not. allocated(error)
      lagged%extra_iterations = 0
      call forget_changes(lagged%update%terms)
   end subroutine refactorise

   !> Compute z = P⁻¹ r.
   subroutine apply(self, n, r, z)
      class(lagged_factor_type), intent(inout) :: self  !< the solver
      integer, intent(in) :: n           !< number of block rows
      real(wp), intent(in) :: r(6, n)  !< residual
      real(wp), intent(out) :: z(6, n)  !< preconditioned residual

      if (self%update%terms%n == 0) then
         call solve(self%factor, r, z)
      else
         call solve_lower(self%factor, r)
         call correct(self%update, self%factor%plan, self%factor%vector)
         call solve_upper(self%factor, z)
      end if
   end subroutine apply

end module dda_lagged_factor
