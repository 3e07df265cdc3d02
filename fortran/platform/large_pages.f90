! SPDX-License-Identifier: GPL-3.0-or-later
!> Large memory pages for large arrays: with small pages, address translation (TLB misses) slows
!> reads of hundreds of megabytes.
module dda_large_pages
   use, intrinsic :: iso_c_binding, only: c_int, c_intptr_t, c_ptr, c_size_t
   use dda_kinds, only: long
   implicit none
   private
   public :: prefer_large_pages

   integer(c_intptr_t), parameter :: page = 4096_c_intptr_t
   !> MADV_HUGEPAGE of Linux; other systems ignore it
   integer(c_int), parameter :: huge_page = 14_c_int

   interface
      integer(c_int) function c_madvise(start, length, advice) bind(c, name='madvise')
         import :: c_int, c_intptr_t, c_size_t
         integer(c_intptr_t), value :: start  !< address of the first page
         integer(c_size_t), value :: length  !< bytes
         integer(c_int), value :: advice  !< MADV_…
      end function c_madvise
   end interface

contains

   !> Request large pages for memory that has not been written to.
   !> The request has no effect on systems without large pages.
   subroutine prefer_large_pages(memory, bytes)
      type(c_ptr), intent(in) :: memory  !< address of the memory
      integer(long), intent(in) :: bytes  !< size
      integer(c_intptr_t) :: first, last
      integer(c_int) :: unused

      first = transfer(memory, first)
      last = (first + bytes)/page*page
      first = (first + page - 1)/page*page
      if (last > first) unused = c_madvise(first, int(last - first, c_size_t), huge_page)
   end subroutine prefer_large_pages

end module dda_large_pages
