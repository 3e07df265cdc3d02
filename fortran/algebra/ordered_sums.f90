! SPDX-License-Identifier: GPL-3.0-or-later
!> Sums in a fixed order: bit-identical for any number of threads.
!>
!> Long loops are divided into parts of fixed size, which are distributed to threads.  Short loops
!> run without a parallel region, which costs a microsecond even with one thread.  A step of a small
!> model has ten such loops.
module dda_ordered_sums
   !$ use omp_lib, only: omp_get_num_threads, omp_get_thread_num
   use dda_kinds, only: wp, long
   implicit none
   private
   public :: inner_product, pieces, first_of, last_of, find_thread_range, most_pieces, parallel_from

   integer, parameter :: min_terms = 128          !< smallest number of terms per thread
   integer, parameter :: most_pieces = 256    !< largest number of parts
   integer, parameter :: parallel_from = 2000 !< smallest number of terms to use threads

contains

   !> Return the number of parts of a sum of n terms.
   pure integer function pieces(n)
      integer, intent(in) :: n  !< number of terms

      pieces = min(most_pieces, (n + min_terms - 1)/min_terms)
   end function pieces

   !> Return the first term of part p of a sum of n terms.
   pure integer function first_of(p, n)
      integer, intent(in) :: p, n  !< number of the part; number of terms

      first_of = 1 + int((p - 1)*int(n, long)/pieces(n))
   end function first_of

   !> Return the last term of part p of a sum of n terms.
   pure integer function last_of(p, n)
      integer, intent(in) :: p, n  !< number of the part; number of terms

      last_of = int(p*int(n, long)/pieces(n))
   end function last_of

   !> Find the range of n rows that the calling thread processes.
   subroutine find_thread_range(n, first, last)
      integer, intent(in) :: n             !< number of rows
      integer, intent(out) :: first, last  !< first and last index
      integer :: thread, team

      thread = 0
      team = 1
      !$ thread = omp_get_thread_num()
      !$ team = omp_get_num_threads()
      first = 1 + int(thread*int(n, long)/team)
      last = int((thread + 1)*int(n, long)/team)
   end subroutine find_thread_range

   !> Return Σ x·y over [6,n] as the sum, in order, of the sums of parts of fixed size.
   real(wp) function inner_product(n, x, y) result(total)
      integer, intent(in) :: n  !< number of block rows
      real(wp), intent(in) :: x(6, n), y(6, n)  !< any vectors
      real(wp) :: partial(most_pieces)
      integer :: p

      if (n < parallel_from) then
         total = sum_part(x, y)
         return
      end if
      !$omp parallel do schedule(static)
      do p = 1, pieces(n)
         partial(p) = sum_part(x(:, first_of(p, n):last_of(p, n)), &
            y(:, first_of(p, n):last_of(p, n)))
      end do
      total = sum(partial(:pieces(n)))
   end function inner_product

   !> Return Σ x·y of a part, from six partial sums in vector registers.
   pure real(wp) function sum_part(x, y)
      real(wp), intent(in) :: x(:,:), y(:,:)  !< [6, any] values of one part
      real(wp) :: partial(6)
      integer :: i

      partial = 0.0_wp
      do i = 1, size(x, 2)
         partial = partial + x(:, i)*y(:, i)
      end do
      sum_part = sum(partial)
   end function sum_part

end module dda_ordered_sums
