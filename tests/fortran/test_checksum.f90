! SPDX-License-Identifier: GPL-3.0-or-later
!> CRC-64 against its published check value and a bit-by-bit computation.
module test_checksum
   use, intrinsic :: iso_fortran_env, only: int8
   use dda_checksum, only: checksum_type, begin_checksum, add_bytes, checksum_of
   use dda_kinds, only: long
   use testing, only: check
   implicit none

contains

   !> CRC-64/XZ of "123456789", from the catalogue of parametrised CRC algorithms.
   subroutine check_value_of_crc_64_xz()
      integer(int8), parameter :: digits(9) = [49_int8, 50_int8, 51_int8, 52_int8, 53_int8, &
         54_int8, 55_int8, 56_int8, 57_int8]
      integer(int8) :: no_bytes(0)

      call check(checksum_of(digits) == -7395533204333446662_long, '995DC9BBDF1939FA')
      call check(checksum_of(no_bytes) == 0_long, 'nothing has the sum 0')
   end subroutine check_value_of_crc_64_xz

   !> The remainder of the division itself, one bit at a time.
   pure integer(long) function by_bits(bytes) result(rest)
      integer(int8), intent(in) :: bytes(:)
      integer(long), parameter :: polynomial = -3932672073523589310_long
      integer :: i, bit

      rest = -1
      do i = 1, size(bytes)
         rest = ieor(rest, iand(int(bytes(i), long), 255_long))
         do bit = 1, 8
            rest = merge(ieor(shiftr(rest, 1), polynomial), shiftr(rest, 1), btest(rest, 0))
         end do
      end do
      rest = not(rest)
   end function by_bits

   pure function sown(n) result(bytes)
      integer, intent(in) :: n
      integer(int8) :: bytes(n)
      integer :: i

      bytes = [(int(modulo(i*i*37 + 11*i, 256) - 128, int8), i=1, n)]
   end function sown

   subroutine eight_bytes_at_a_time_and_one_by_one()
      integer :: n

      do n = 0, 40
         call check(checksum_of(sown(n)) == by_bits(sown(n)), 'the same as bit by bit')
      end do
   end subroutine eight_bytes_at_a_time_and_one_by_one

   subroutine parts_of_any_length()
      type(checksum_type) :: checksum
      integer(int8) :: bytes(100)
      integer :: split

      bytes = sown(100)
      do split = 0, 100, 7
         call begin_checksum(checksum)
         call add_bytes(checksum, bytes(:split))
         call add_bytes(checksum, bytes(split + 1:))
         call check(checksum%value == checksum_of(bytes), 'the same as at once')
      end do
   end subroutine parts_of_any_length

end module test_checksum
