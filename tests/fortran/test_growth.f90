! SPDX-License-Identifier: GPL-3.0-or-later
!> Growing arrays: contents stay, the rest is zero, the room is there, few copies are made.
module test_growth
   use, intrinsic :: iso_fortran_env, only: int8
   use dda_growth, only: grow
   use dda_kinds, only: wp, long
   use testing, only: check
   implicit none

contains

   subroutine numbers_and_flags()
      integer, allocatable :: integers(:)
      real(wp), allocatable :: value(:)
      logical, allocatable :: flag(:)
      integer(int8), allocatable :: byte(:)

      call grow(integers, 0)
      call check(size(integers) == 0, 'an empty list exists')
      integers = [1, 2, 3]
      value = [1.0_wp, 2.0_wp, 3.0_wp]
      flag = [.true., .true.]
      byte = [1_int8, 2_int8]
      call grow(integers, 3)
      call check(size(integers) == 3, 'what has the room stays as it is')
      call grow(integers, 10)
      call grow(value, 10)
      call grow(flag, 10)
      call grow(byte, 10_long)
      call check(size(integers) >= 10 .and. all(integers(:3) == [1, 2, 3]), 'integers are kept')
      call check(all(integers(4:) == 0), 'new integers are zero')
      call check(all(value(:3) == [1.0_wp, 2.0_wp, 3.0_wp]) .and. all(value(4:10) == 0.0_wp), &
         'reals are kept, new ones zero')
      call check(all(flag(:2)) .and. .not. any(flag(3:10)), 'flags are kept, new ones false')
      call check(all(byte(:2) == [1_int8, 2_int8]) .and. all(byte(3:10) == 0_int8), &
         'bytes are kept, new ones zero')
   end subroutine numbers_and_flags

   subroutine texts_and_columns_that_grow()
      character(len=5), allocatable :: name(:)
      real(wp), allocatable :: value(:,:)
      integer, allocatable :: columns(:,:)

      name = [character(len=5) :: 'stone', 'sand']
      call grow(name, 7)
      call check(all(name(:2) == [character(len=5) :: 'stone', 'sand']) &
         .and. all(name(3:7) == ''), 'texts are kept, new ones blank')
      call grow(value, 2, 1)
      call check(all(shape(value) == [2, 1]), 'columns begin with the rows asked for')
      value(:, 1) = [3.0_wp, 4.0_wp]
      call grow(value, 2, 5)
      call check(all(value(:, 1) == [3.0_wp, 4.0_wp]) .and. all(value(:, 2:5) == 0.0_wp), &
         'columns are kept, new ones zero')
      columns = reshape([1, 2, 3, 4, 5, 6], [3, 2])
      call grow(columns, 3, 4)
      call check(all(columns(:, :2) == reshape([1, 2, 3, 4, 5, 6], [3, 2])) &
         .and. all(columns(:, 3:4) == 0), 'integer columns too')
   end subroutine texts_and_columns_that_grow

   !> The number of times that the array moves grows as log2 of its length.
   subroutine appended_one_by_one()
      integer, parameter :: n = 1000
      integer, allocatable :: list(:)
      integer :: i, former_size, moves

      moves = 0
      allocate (list(0))
      do i = 1, n
         former_size = size(list)
         call grow(list, i)
         list(i) = i
         if (size(list) > former_size) moves = moves + 1
      end do
      call check(all(list(:n) == [(i, i=1, n)]), 'all values are there')
      call check(moves <= 11, 'at most 1 + log2 1000 moves')
   end subroutine appended_one_by_one

end module test_growth
