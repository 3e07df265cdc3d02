! SPDX-License-Identifier: GPL-3.0-or-later
!> Eigenvalues of small matrices without symmetry, for suites that measure amplification matrices.
module eigenvalues
   use dda_kinds, only: wp
   implicit none
   private
   public :: roots_of, distance_of

   interface
      !> LAPACK: eigenvalues of a general matrix.
      subroutine dgeev(jobvl, jobvr, n, a, lda, wr, wi, vl, ldvl, vr, ldvr, work, lwork, info)
         import :: wp
         character(len=1), intent(in) :: jobvl, jobvr
         integer, intent(in) :: n, lda, ldvl, ldvr, lwork
         real(wp), intent(inout) :: a(lda, *)
         real(wp), intent(out) :: wr(*), wi(*), vl(ldvl, *), vr(ldvr, *), work(*)
         integer, intent(out) :: info
      end subroutine dgeev
   end interface

contains

   !> Eigenvalues of a 2×2 matrix.
   function roots_of(matrix) result(roots)
      real(wp), intent(in) :: matrix(2, 2)
      complex(wp) :: roots(2)
      real(wp) :: a(2, 2), re(2), im(2), left_vector(1, 1), right_vector(1, 1), work(32)
      integer :: info

      a = matrix
      call dgeev('N', 'N', 2, a, 2, re, im, left_vector, 1, right_vector, 1, work, size(work), info)
      roots = cmplx(re, im, wp)
      if (info /= 0) roots = huge(1.0_wp)
   end function roots_of

   !> Largest difference between two pairs of roots in the better of both orders.
   pure real(wp) function distance_of(a, b) result(distance)
      complex(wp), intent(in) :: a(2), b(2)

      distance = min(maxval(abs(a - b)), maxval(abs(a - b([2, 1]))))
   end function distance_of

end module eigenvalues
