!> Explicit interfaces of the two BLAS products the factor uses.
module dda_blas
   use dda_kinds, only: sp, wp
   implicit none
   private
   public :: dgemm, sgemm

   interface
      !> C = alpha op(A) op(B) + beta C, double precision.
      subroutine dgemm(transa, transb, m, n, k, alpha, a, lda, b, ldb, beta, c, ldc)
         import :: wp
         character(len=1), intent(in) :: transa, transb  !< 'N' or 'T'
         !> sizes of the product and leading dimensions
         integer, intent(in) :: m, n, k, lda, ldb, ldc
         real(wp), intent(in) :: alpha, beta, a(lda, *), b(ldb, *)  !< factors and operands
         real(wp), intent(inout) :: c(ldc, *)  !< [m,n]
      end subroutine dgemm

      !> C = alpha op(A) op(B) + beta C, single precision.
      subroutine sgemm(transa, transb, m, n, k, alpha, a, lda, b, ldb, beta, c, ldc)
         import :: sp
         character(len=1), intent(in) :: transa, transb  !< 'N' or 'T'
         !> sizes of the product and leading dimensions
         integer, intent(in) :: m, n, k, lda, ldb, ldc
         real(sp), intent(in) :: alpha, beta, a(lda, *), b(ldb, *)  !< factors and operands
         real(sp), intent(inout) :: c(ldc, *)  !< [m,n]
      end subroutine sgemm
   end interface

end module dda_blas
