!> An older Cholesky factor, in single precision, as preconditioner of conjugate gradients.
!>
!> Springs that have changed since are followed by a correction of low rank, so that only geometry
!> that drifts costs iterations, two or three.
module dda_lagged_factor
   use dda_kinds, only: wp
   use dda_block_matrix, only: block_matrix_type
   use dda_conjugate_gradients, only: preconditioner_type
   use dda_cholesky_single, only: factor_type, analyse, factorise, solve, solve_lower, solve_upper
   use dda_errors, only: error_type
   use dda_low_rank, only: low_rank_type, plan_low_rank, forget_low_rank, follow_changes, correct
   use dda_rank_one, only: rank_one_type
   implicit none
   private
   public :: lagged_factor_type, analyse_lagged, refresh, follow

   !> The factor and how old it is.
   type, extends(preconditioner_type) :: lagged_factor_type
      type(factor_type) :: factor
      type(low_rank_type) :: low                 !< what has changed since it was made
      logical :: made = .false.                  !< there is a factor for this pattern
      integer :: excess = 0                      !< iterations that its age has cost
   contains
      procedure :: apply
   end type lagged_factor_type

contains

   !> Plan the factor of a new pattern.
   subroutine analyse_lagged(stale, matrix)
      type(lagged_factor_type), intent(inout) :: stale
      type(block_matrix_type), intent(in) :: matrix

      call analyse(stale%factor, matrix)
      call plan_low_rank(stale%low, stale%factor%plan)
      stale%made = .false.
   end subroutine analyse_lagged

   !> Make the factor anew from the present matrix.
   subroutine refresh(stale, matrix, error)
      type(lagged_factor_type), intent(inout) :: stale
      type(block_matrix_type), intent(in) :: matrix
      type(error_type), allocatable, intent(out) :: error

      call factorise(stale%factor, matrix, error)
      stale%made = .not. allocated(error)
      stale%excess = 0
      call forget_low_rank(stale%low)
   end subroutine refresh

   !> Follow changes of springs; .false. if the factor has to be made anew for that.
   subroutine follow(stale, changes, done)
      type(lagged_factor_type), intent(inout) :: stale
      type(rank_one_type), intent(in) :: changes
      logical, intent(out) :: done

      call follow_changes(stale%low, stale%factor, changes, done)
   end subroutine follow

   !> z = P⁻¹ r
   subroutine apply(self, n, r, z)
      class(lagged_factor_type), intent(inout) :: self
      integer, intent(in) :: n
      real(wp), intent(in) :: r(6, n)
      real(wp), intent(out) :: z(6, n)

      if (self%low%springs%n == 0) then
         call solve(self%factor, r, z)
      else
         call solve_lower(self%factor, r)
         call correct(self%low, self%factor%plan, self%factor%vector)
         call solve_upper(self%factor, z)
      end if
   end subroutine apply

end module dda_lagged_factor
