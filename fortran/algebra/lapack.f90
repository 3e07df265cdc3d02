! SPDX-License-Identifier: GPL-3.0-or-later
!> Explicit interfaces of the BLAS and LAPACK routines that are used.
module dda_lapack
   use dda_kinds, only: sp, wp
   implicit none
   private
   public :: dgemm, sgemm, dposv, dpotrf, dtrsm, zsysv

   interface
      !> Compute C = alpha op(A) op(B) + beta C in double precision.
      subroutine dgemm(transa, transb, m, n, k, alpha, a, lda, b, ldb, beta, c, ldc)
         import :: wp
         character(len=1), intent(in) :: transa, transb  !< 'N' or 'T'
         !> sizes of the product and leading dimensions
         integer, intent(in) :: m, n, k, lda, ldb, ldc
         real(wp), intent(in) :: alpha, beta, a(lda, *), b(ldb, *)  !< factors and operands
         real(wp), intent(inout) :: c(ldc, *)  !< [m,n] C
      end subroutine dgemm

      !> Compute C = alpha op(A) op(B) + beta C in single precision.
      subroutine sgemm(transa, transb, m, n, k, alpha, a, lda, b, ldb, beta, c, ldc)
         import :: sp
         character(len=1), intent(in) :: transa, transb  !< 'N' or 'T'
         !> sizes of the product and leading dimensions
         integer, intent(in) :: m, n, k, lda, ldb, ldc
         real(sp), intent(in) :: alpha, beta, a(lda, *), b(ldb, *)  !< factors and operands
         real(sp), intent(inout) :: c(ldc, *)  !< [m,n] C
      end subroutine sgemm

      !> Solve a symmetric positive definite system.
      subroutine dposv(uplo, n, nrhs, a, lda, b, ldb, info)
         import :: wp
         character(len=1), intent(in) :: uplo  !< 'L': lower triangle
         integer, intent(in) :: n, nrhs, lda, ldb  !< sizes and leading dimensions
         real(wp), intent(inout) :: a(lda, *)  !< [n,n] matrix; on return, factor
         real(wp), intent(inout) :: b(ldb, *)  !< [n,nrhs] right-hand sides; on return, solutions
         integer, intent(out) :: info  !< row with a pivot that is not positive, else 0
      end subroutine dposv

      !> Compute the Cholesky factor of a symmetric positive definite matrix.
      pure subroutine dpotrf(uplo, n, a, lda, info)
         import :: wp
         character(len=1), intent(in) :: uplo  !< 'L': lower triangle
         integer, intent(in) :: n, lda  !< size and leading dimension
         real(wp), intent(inout) :: a(lda, *)  !< [n,n] matrix; on return, factor
         integer, intent(out) :: info  !< row with a pivot that is not positive, else 0
      end subroutine dpotrf

      !> Solve with a triangular matrix.
      pure subroutine dtrsm(side, uplo, transa, diag, m, n, alpha, a, lda, b, ldb)
         import :: wp
         !> 'L': left or 'R': right of b; 'L': lower triangle; 'T': transposed; 'N': diagonal is not
         !> 1
         character(len=1), intent(in) :: side, uplo, transa, diag
         integer, intent(in) :: m, n, lda, ldb  !< sizes of b and leading dimensions
         real(wp), intent(in) :: alpha, a(lda, *)  !< factor of b; the matrix
         real(wp), intent(inout) :: b(ldb, *)  !< [m,n] right-hand sides; on return, solutions
      end subroutine dtrsm

      !> Solve a complex symmetric system (Bunch–Kaufman).
      subroutine zsysv(uplo, n, nrhs, a, lda, ipiv, b, ldb, work, lwork, info)
         import :: wp
         character(len=1), intent(in) :: uplo
         integer, intent(in) :: n, nrhs, lda, ldb, lwork
         complex(wp), intent(inout) :: a(lda, *), b(ldb, *), work(*)
         integer, intent(out) :: ipiv(*), info
      end subroutine zsysv
   end interface

end module dda_lapack
