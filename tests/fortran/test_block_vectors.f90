! SPDX-License-Identifier: GPL-3.0-or-later
!> Sums of block vectors are bit-identical to sums of arrays, for any number of threads.
module test_block_vectors
   !$ use omp_lib, only: omp_get_max_threads, omp_set_num_threads
   use dda_kinds, only: wp
   use dda_block_vectors, only: add_multiple, copy_vector, multiply_and_add
   use dda_ordered_sums, only: parallel_from
   use models, only: random_vector
   use testing, only: case, check
   implicit none

contains

   subroutine sums_of_any_length()
      integer :: default_threads, threads

      default_threads = 1
      !$ default_threads = omp_get_max_threads()
      do threads = 1, 4
         !$ call omp_set_num_threads(threads)
         call case('a short vector')
         call against_whole_arrays(3)
         call case('a long one, which threads share')
         call against_whole_arrays(parallel_from + 7)
      end do
      !$ call omp_set_num_threads(default_threads)
   end subroutine sums_of_any_length

   subroutine against_whole_arrays(n)
      integer, intent(in) :: n
      real(wp), parameter :: half = -0.5_wp  ! whose products are exact
      real(wp), dimension(6, n) :: x, y, sum

      x = reshape(random_vector(6*n), [6, n])
      y = reshape(random_vector(6*n), [6, n])
      sum = y
      call add_multiple(n, half, x, sum)
      call check(all(sum == y + half*x), 'y + a x')
      sum = y
      call multiply_and_add(n, x, half, sum)
      call check(all(sum == x + half*y), 'x + a y')
      call copy_vector(n, x, sum)
      call check(all(sum == x), 'a copy')
   end subroutine against_whole_arrays

end module test_block_vectors
