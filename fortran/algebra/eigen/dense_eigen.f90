! SPDX-License-Identifier: GPL-3.0-or-later
!> Eigenvalues of small dense symmetric matrices, by LAPACK.
module dda_dense_eigen
   use dda_kinds, only: wp
   use dda_errors, only: error_type, error_solver, fail
   use dda_free_memory, only: require_for_blas
   use dda_text, only: to_text
   implicit none
   private
   public :: solve_symmetric_eigen, solve_block_eigen, is_above, factorise_block

   interface
      !> LAPACK: eigenvalues, ascending, and vectors of a symmetric matrix.
      subroutine dsyev(jobz, uplo, n, a, lda, w, work, lwork, info)
         import :: wp
         character(len=1), intent(in) :: jobz, uplo  !< 'V': with vectors; 'L': lower triangle
         integer, intent(in) :: n, lda, lwork  !< size, dimensions
         real(wp), intent(inout) :: a(lda, *), work(*)  !< matrix, then vectors; workspace
         real(wp), intent(out) :: w(*)  !< [n] eigenvalues, ascending
         integer, intent(out) :: info  !< 0 on success
      end subroutine dsyev

      !> LAPACK: eigenvalues and vectors of A x = λ B x with B positive definite.
      subroutine dsygv(itype, jobz, uplo, n, a, lda, b, ldb, w, work, lwork, info)
         import :: wp
         integer, intent(in) :: itype, n, lda, ldb, lwork  !< 1: A x = λ B x; size, dimensions
         character(len=1), intent(in) :: jobz, uplo  !< 'V': with vectors; 'L': lower triangle
         real(wp), intent(inout) :: a(lda, *), b(ldb, *), work(*)  !< matrices, destroyed; workspace
         real(wp), intent(out) :: w(*)  !< [n] eigenvalues, ascending
         integer, intent(out) :: info  !< 0 on success
      end subroutine dsygv
   end interface

   integer, parameter :: work_columns = 34  !< workspace of dsyev over n

contains

   !> Solve A x = λ x; `a` is overwritten by the orthonormal vectors.
   subroutine solve_symmetric_eigen(a, values, error)
      real(wp), intent(inout) :: a(:,:)  !< [n,n] matrix; only its lower triangle is read
      real(wp), allocatable, intent(out) :: values(:)   !< [n] eigenvalues, ascending
      type(error_type), allocatable, intent(out) :: error  !< LAPACK has failed
      real(wp) :: work(work_columns*max(1, size(a, 1)))
      integer :: n, info

      n = size(a, 1)
      allocate (values(n))
      if (n == 0) return
      call require_for_blas(error)
      if (allocated(error)) return
      call dsyev('V', 'L', n, a, n, values, work, size(work), info)
      if (info /= 0) call fail(error, error_solver, 'LAPACK dsyev failed with info = '// &
         to_text(info))
   end subroutine solve_symmetric_eigen

   !> Solve K x = λ M x for one block (within a few µs).
   subroutine solve_block_eigen(k, m, values, vectors, error)
      real(wp), intent(in) :: k(6, 6), m(6, 6)  !< stiffness and mass of one block
      real(wp), intent(out) :: values(6)      !< eigenvalues, ascending
      real(wp), intent(out) :: vectors(6, 6)  !< eigenvectors, xᵀMx = 1
      type(error_type), allocatable, intent(out) :: error  !< LAPACK has failed
      real(wp) :: b(6, 6), work(6*work_columns)
      integer :: info

      call require_for_blas(error)
      if (allocated(error)) return
      vectors = k
      b = m
      call dsygv(1, 'V', 'L', 6, vectors, 6, b, 6, values, work, size(work), info)
      if (info /= 0) call fail(error, error_solver, 'LAPACK dsygv failed with info = '// &
         to_text(info)//' for one block')
   end subroutine solve_block_eigen

   !> .true. if all eigenvalues of K x = λ M x of one block are below `value`.
   !> Then value·M − K has a Cholesky factor, which costs 1/50 of the time for the eigenvalues.
   pure logical function is_above(value, k, m)
      real(wp), intent(in) :: value, k(6, 6), m(6, 6)  !< limit, 1/s²; stiffness; mass
      real(wp) :: factor(6, 6)

      call factorise_block(value*m - k, factor, is_above)
   end function is_above

   !> Compute the lower Cholesky factor of a 6×6 block, with zeros above the diagonal.
   pure subroutine factorise_block(block, factor, positive)
      real(wp), intent(in) :: block(6, 6)    !< block; only its lower triangle is read
      real(wp), intent(out) :: factor(6, 6)  !< lower triangle
      !> .false.: the block is not positive definite, and the factor is undefined
      logical, intent(out) :: positive
      real(wp) :: work(6, 6)
      integer :: j, k

      work = block
      factor = 0.0_wp
      do j = 1, 6
         positive = work(j, j) > 0.0_wp
         if (.not. positive) return
         factor(j:6, j) = work(j:6, j)/sqrt(work(j, j))
         do k = j + 1, 6
            work(k:6, k) = work(k:6, k) - factor(k, j)*factor(k:6, j)
         end do
      end do
   end subroutine factorise_block

end module dda_dense_eigen
