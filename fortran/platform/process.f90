! SPDX-License-Identifier: GPL-3.0-or-later
!> The process in which the engine runs.
module dda_process
   use, intrinsic :: iso_c_binding, only: c_int
   implicit none
   private
   public :: process_id

   interface
      !> POSIX: the number of this process, which a fork changes.
      integer(c_int) function process_id() bind(c, name='getpid')  ! total
         import :: c_int
      end function process_id
   end interface

end module dda_process
