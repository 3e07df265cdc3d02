! SPDX-License-Identifier: GPL-3.0-or-later
!> Sums and copies of vectors of [6,n] components; long vectors are divided between threads.
module dda_block_vectors
   use dda_kinds, only: wp
   use dda_ordered_sums, only: parallel_from
   implicit none
   private
   public :: add_multiple, multiply_and_add, copy_vector

contains

   !> Compute y = y + a x.
   subroutine add_multiple(n, a, x, y)
      integer, intent(in) :: n                !< number of block rows
      real(wp), intent(in) :: a, x(6, n)      !< factor, vector
      real(wp), intent(inout) :: y(6, n)      !< sum
      integer :: i

      if (n < parallel_from) then
         y = y + a*x
         return
      end if
      !$omp parallel do schedule(static)
      do i = 1, n
         y(:, i) = y(:, i) + a*x(:, i)
      end do
   end subroutine add_multiple

   !> Compute y = x + a y.
   subroutine multiply_and_add(n, x, a, y)
      integer, intent(in) :: n                !< number of block rows
      real(wp), intent(in) :: x(6, n), a      !< vector, factor
      real(wp), intent(inout) :: y(6, n)      !< sum
      integer :: i

      if (n < parallel_from) then
         y = x + a*y
         return
      end if
      !$omp parallel do schedule(static)
      do i = 1, n
         y(:, i) = x(:, i) + a*y(:, i)
      end do
   end subroutine multiply_and_add

   !> Compute y = x.
   subroutine copy_vector(n, x, y)
      integer, intent(in) :: n            !< number of block rows
      real(wp), intent(in) :: x(6, n)     !< vector
      real(wp), intent(inout) :: y(6, n)  !< copy of x
      integer :: i

      if (n < parallel_from) then
         y = x
         return
      end if
      !$omp parallel do schedule(static)
      do i = 1, n
         y(:, i) = x(:, i)
      end do
   end subroutine copy_vector

end module dda_block_vectors
