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
      integer :: byte, bit_index, position
      integer(long) :: register

      do byte = 0, 255
         register = byte
         do bit_index = 1, 8
            register = merge(ieor(shiftr(register, 1), polynomial), shiftr(register, 1), &
               btest(register, 0))
         end do
         checksum%table(byte, 0) = register
      end do
      do position = 1, 15
         do byte = 0, 255
            register = checksum%table(byte, position - 1)
            checksum%table(byte, position) = ieor(checksum%table(low_byte(register), 0), &
               shiftr(register, 8))
         end do
      end do
   end subroutine begin_checksum

   !> Lowest eight bits of a word.
   pure integer function low_byte(register)
      integer(long), intent(in) :: register  !< eight bytes

      low_byte = int(iand(register, 255_long))
   end function low_byte

   !> Extend a checksum by more bytes.
   pure subroutine add_bytes(checksum, bytes)
      type(checksum_type), intent(inout) :: checksum  !< checksum of the bytes so far
      integer(int8), contiguous, intent(in) :: bytes(:)  !< [bytes]
      integer(long) :: register, first, second, i, aligned
      integer :: k

      register = not(checksum%value)
      aligned = size(bytes, kind=long)/16*16
      do i = 1, aligned, 16
         first = ieor(register, transfer(bytes(i:i + 7), register))
         second = transfer(bytes(i + 8:i + 15), register)
         register = 0
         do k = 0, 7
            register = ieor(register, ieor(checksum%table(low_byte(shiftr(first, 8*k)), 15 - k), &
               checksum%table(low_byte(shiftr(second, 8*k)), 7 - k)))
         end do
      end do
      do i = aligned + 1, size(bytes, kind=long)
         register = ieor(checksum%table(low_byte(ieor(register, int(bytes(i), long))), 0), &
            shiftr(register, 8))
      end do
      checksum%value = not(register)
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
