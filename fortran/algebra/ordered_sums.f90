!> Sums in a fixed order: the same bits whatever the number of threads.
module dda_ordered_sums
   use dda_kinds, only: wp
   implicit none
   private
   public :: inner_product, pieces, first_of, last_of, parallel_from

   integer, parameter :: piece = 512          !< terms summed by one thread at a time
   integer, parameter :: parallel_from = 2000 !< terms from which threads repay their start

contains

   !> Number of pieces of n terms.
   pure integer function pieces(n)
      integer, intent(in) :: n

      pieces = (n + piece - 1)/piece
   end function pieces

   !> First term of piece p.
   pure integer function first_of(p)
      integer, intent(in) :: p

      first_of = (p - 1)*piece + 1
   end function first_of

   !> Last term of piece p of n terms.
   pure integer function last_of(p, n)
      integer, intent(in) :: p, n

      last_of = min(n, p*piece)
   end function last_of

   !> Σ x·y over [6,n]: pieces of fixed size, then the pieces one after the other.
   real(wp) function inner_product(n, x, y) result(total)
      integer, intent(in) :: n
      real(wp), intent(in) :: x(6, n), y(6, n)
      real(wp) :: part(pieces(n))
      integer :: p

      !$omp parallel do schedule(static) if (n >= parallel_from)
      do p = 1, size(part)
         part(p) = sum_of_piece(x(:, first_of(p):last_of(p, n)), y(:, first_of(p):last_of(p, n)))
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
