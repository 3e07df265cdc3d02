!> Sparse Cholesky factor of the DDA matrix, in working or in single precision.
!>
!>     call analyse(factor, matrix)             ! when the pattern has changed
!>     call factorise(factor, matrix, error)    ! when the numbers have changed
!>     call solve(factor, b, x)
!>
!> The factor is multifrontal on 6×6 blocks (`dda_front_plan`).  With OpenMP, large systems are
!> shared between threads; results do not depend on their number, to the last bit.
module dda_block_cholesky
   use dda_cholesky_double, only: cholesky_type => factor_type, analyse_double => analyse, &
      factorise_double => factorise, solve_double => solve
   use dda_cholesky_single, only: cholesky_single_type => factor_type, analyse_single => analyse, &
      factorise_single => factorise, solve_single => solve
   implicit none
   private
   public :: cholesky_type, cholesky_single_type, analyse, factorise, solve

   !> Order and plan the factor of a matrix pattern.
   interface analyse
      procedure :: analyse_double
      procedure :: analyse_single
   end interface analyse

   !> Factorise the numbers of a matrix.
   interface factorise
      procedure :: factorise_double
      procedure :: factorise_single
   end interface factorise

   !> Solve K x = b with a factor.
   interface solve
      procedure :: solve_double
      procedure :: solve_single
   end interface solve

end module dda_block_cholesky
