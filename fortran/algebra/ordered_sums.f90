!> Sums in a fixed order: the same bits whatever the number of threads.
module dda_ordered_sums
   use dda_kinds, only: wp
   implicit none
   private
   public :: inner_product

   integer, parameter :: piece = 512          !< columns summed by one thread at a time
   integer, parameter :: parallel_from = 2000 !< columns from which threads repay their start

contains

   !> Σ x·y over [6,n]: pieces of fixed size, then the pieces one after the other.
   real(wp) function inner_product(n, x, y) result(total)
      integer, intent(in) :: n
      real(wp), intent(in) :: x(6, n), y(6, n)
      real(wp) :: part((n + piece - 1)/piece)
      integer :: p

      !$omp parallel do schedule(static) if (n >= parallel_from)
      do p = 1, size(part)
         part(p) = sum_of_piece(x(:, (p - 1)*piece + 1:min(n, p*piece)), y(:, (p - 1)*piece + 1:min(n, p*piece)))
      end do
      total = 0.0_wp
      do p = 1, size(part)
         total = total + part(p)
      end do
   end function inner_product

   !> Six running sums, which vector registers hold.
   pure real(wp) function sum_of_piece(x, y)
      real(wp), intent(in) :: x(:,:), y(:,:)
      real(wp) :: lane(6)
      integer :: i

      lane = 0.0_wp
      do i = 1, size(x, 2)
         lane = lane + x(:, i)*y(:, i)
      end do
      sum_of_piece = sum(lane)
   end function sum_of_piece

end module dda_ordered_sums
