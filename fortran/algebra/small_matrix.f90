! SPDX-License-Identifier: GPL-3.0-or-later
!> Inversion of 6×6 matrices.
module dda_small_matrix
   use dda_kinds, only: wp
   implicit none
   private
   public :: invert_matrix

contains

   !> Invert a 6×6 matrix by Gauss–Jordan elimination without pivoting.
   pure subroutine invert_matrix(matrix, inverse)
      !> matrix: positive definite, or triangular with a positive diagonal
      real(wp), intent(in) :: matrix(6, 6)
      real(wp), intent(out) :: inverse(6, 6)  !< inverse of the matrix
      real(wp) :: pivot, factor(6)
      integer :: k, j

      inverse = matrix
      do k = 1, 6
         pivot = 1.0_wp/inverse(k, k)
         factor = inverse(:, k)
         factor(k) = 0.0_wp
         inverse(:, k) = 0.0_wp
         inverse(k, k) = 1.0_wp
         inverse(k, :) = pivot*inverse(k, :)
         do j = 1, 6
            inverse(:, j) = inverse(:, j) - factor*inverse(k, j)
         end do
      end do
   end subroutine invert_matrix

end module dda_small_matrix
