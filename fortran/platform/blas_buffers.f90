! SPDX-License-Identifier: GPL-3.0-or-later
!> Buffers of OpenBLAS.
!>
!> A thread that calls OpenBLAS needs a buffer.  OpenBLAS allocates a buffer if none is free, and
!> never releases it.  If the system refuses memory, OpenBLAS repeats the request endlessly.
!> `allocate_buffers` therefore allocates all buffers at once, after a check that they fit.  Most
!> pages of buffers are never written to, so buffers use address space but little memory.
module dda_blas_buffers
   use, intrinsic :: iso_c_binding, only: c_int, c_null_ptr, c_ptr
   use dda_kinds, only: wp
   implicit none
   private
   public :: missing_buffers, allocate_buffers

   !> bytes of one buffer (BUFFER_SIZE and a page of OpenBLAS on 64-bit processors)
   real(wp), parameter :: buffer_bytes = 135266304.0_wp
   integer :: n_allocated = 0  !< buffers that OpenBLAS has allocated

   interface
      !> OpenBLAS: returns a free buffer, or a new one.
      type(c_ptr) function blas_memory_alloc(unused) bind(c, name='blas_memory_alloc')
         import :: c_int, c_ptr
         integer(c_int), value :: unused
      end function blas_memory_alloc

      !> OpenBLAS: marks the buffer as free for another call.
      subroutine blas_memory_free(buffer) bind(c, name='blas_memory_free')
         import :: c_ptr
         type(c_ptr), value :: buffer
      end subroutine blas_memory_free
   end interface

contains

   !> Address space for the buffers that are missing for simultaneous calls by some threads, bytes.
   real(wp) function missing_buffers(threads) result(bytes)  ! total
      integer, intent(in) :: threads  !< threads within a call at the same time

      bytes = buffer_bytes*max(0, threads - n_allocated)
   end function missing_buffers

   !> Let OpenBLAS allocate the buffers for a number of threads, which must fit.
   subroutine allocate_buffers(threads)
      integer, intent(in) :: threads  !< threads within a call at the same time
      type(c_ptr) :: buffer(threads)
      integer :: i

      if (threads <= n_allocated) return
      buffer = c_null_ptr
      do i = 1, threads
         buffer(i) = blas_memory_alloc(0_c_int)
      end do
      do i = 1, threads
         call blas_memory_free(buffer(i))
      end do
      n_allocated = threads
   end subroutine allocate_buffers

end module dda_blas_buffers
