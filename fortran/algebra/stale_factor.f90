!> An older Cholesky factor, in single precision, as preconditioner of conjugate gradients.
!>
!> It stays good while few springs have changed: geometry that drifts costs two or three iterations, a
!> changed spring a fraction of one.
module dda_stale_factor
   use dda_kinds, only: wp
   use dda_block_cholesky, only: cholesky_single_type, analyse, factorise, solve
   use dda_block_matrix, only: block_matrix_type
   use dda_conjugate_gradients, only: preconditioner_type
   use dda_errors, only: error_type
   implicit none
   private
   public :: stale_factor_type, analyse_stale, refresh

   !> The factor and how old it is.
   type, extends(preconditioner_type) :: stale_factor_type
      type(cholesky_single_type) :: factor
      logical :: made = .false.      !< there is a factor for this pattern
      integer :: changes = 0         !< springs changed since it was made
      integer :: excess = 0          !< iterations that its age has cost
   contains
      procedure :: apply
   end type stale_factor_type

contains

   !> Plan the factor of a new pattern.
   subroutine analyse_stale(stale, matrix)
      type(stale_factor_type), intent(inout) :: stale
      type(block_matrix_type), intent(in) :: matrix

      call analyse(stale%factor, matrix)
      stale%made = .false.
   end subroutine analyse_stale

   !> Make the factor anew from the present matrix.
   subroutine refresh(stale, matrix, error)
      type(stale_factor_type), intent(inout) :: stale
      type(block_matrix_type), intent(in) :: matrix
      type(error_type), allocatable, intent(out) :: error

      call factorise(stale%factor, matrix, error)
      stale%made = .not. allocated(error)
      stale%changes = 0
      stale%excess = 0
   end subroutine refresh

   !> z = (L Lᵀ)⁻¹ r
   subroutine apply(self, n, r, z)
      class(stale_factor_type), intent(inout) :: self
      integer, intent(in) :: n
      real(wp), intent(in) :: r(6, n)
      real(wp), intent(out) :: z(6, n)

      call solve(self%factor, r, z)
   end subroutine apply

end module dda_stale_factor
