! SPDX-License-Identifier: GPL-3.0-or-later
!> CRC-64 of bytes, as in xz (polynomial of ECMA-182, reflected): detects every burst of
!> errors up to 64 bits.
module dda_checksum
   use, intrinsic :: iso_fortran_env, only: int8
   use dda_kinds, only: long
   implicit none
   private
   public :: checksum_type, begin_checksum, add_bytes, checksum_of

   integer(long), parameter :: polynomial = -3932672073523589310_long  !< C96C5795D7870F42

   !> Checksum of the bytes so far, and tables to process 16 bytes at a time.
   type :: checksum_type
      integer(long) :: value = 0
      !> remainders of each byte value followed by 0 … 15 zero bytes
      integer(long) :: table(0:255, 0:15) = 0
   end type checksum_type

contains

   !> Begin a checksum, and compute its tables.
   pure subroutine begin_checksum(checksum)
      type(checksum_type), intent(out) :: checksum  !< checksum of no bytes
      integer :: byte, bit, behind
      integer(long) :: rest

      do byte = 0, 255
         rest = byte
         do bit = 1, 8
            rest = merge(ieor(shiftr(rest, 1), polynomial), shiftr(rest, 1), btest(rest, 0))
         end do
         checksum%table(byte, 0) = rest
      end do
      do behind = 1, 15
         do byte = 0, 255
            rest = checksum%table(byte, behind - 1)
            checksum%table(byte, behind) = ieor(checksum%table(low_byte(rest), 0), shiftr(rest, 8))
         end do
      end do
   end subroutine begin_checksum

   !> Lowest eight bits of a word.
   pure integer function low_byte(word)
      integer(long), intent(in) :: word  !< eight bytes

      low_byte = int(iand(word, 255_long))
   end function low_byte

   !> Extend a checksum by more bytes.
   pure subroutine add_bytes(checksum, bytes)
      type(checksum_type), intent(inout) :: checksum  !< checksum of the bytes so far
      integer(int8), contiguous, intent(in) :: bytes(:)  !< [bytes]
      integer(long) :: rest, first, second, i, whole
      integer :: k

      rest = not(checksum%value)
      whole = size(bytes, kind=long)/16*16
      do i = 1, whole, 16
         first = ieor(rest, transfer(bytes(i:i + 7), rest))
         second = transfer(bytes(i + 8:i + 15), rest)
         rest = 0
         do k = 0, 7
            rest = ieor(rest, ieor(checksum%table(low_byte(shiftr(first, 8*k)), 15 - k), &
               checksum%table(low_byte(shiftr(second, 8*k)), 7 - k)))
         end do
      end do
      do i = whole + 1, size(bytes, kind=long)
         rest = ieor(checksum%table(low_byte(ieor(rest, int(bytes(i), long))), 0), shiftr(rest, 8))
      end do
      checksum%value = not(rest)
   end subroutine add_bytes

   !> Checksum of an array of bytes.
   pure integer(long) function checksum_of(bytes) result(value)
      integer(int8), contiguous, intent(in) :: bytes(:)  !< [bytes]
      type(checksum_type) :: checksum

      call begin_checksum(checksum)
      call add_bytes(checksum, bytes)
      value = checksum%value
   end function checksum_of

end module dda_checksum
