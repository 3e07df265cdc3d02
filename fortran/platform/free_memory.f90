! SPDX-License-Identifier: GPL-3.0-or-later
!> Memory that this process may still allocate, so that a model that is too large is refused.
module dda_free_memory
   use, intrinsic :: iso_c_binding, only: c_int, c_long
   use dda_kinds, only: wp
   implicit none
   private
   public :: free_memory

   integer(c_int), parameter :: address_space = 9  !< RLIMIT_AS on Linux
   character(len=*), parameter :: key = 'MemAvailable:'

   interface
      !> POSIX: the limits of this process on a resource, now and at most (bytes); −1 as a signed
      !> number: none.
      integer(c_int) function getrlimit(resource, limits) bind(c, name='getrlimit')
         import :: c_int, c_long
         integer(c_int), value :: resource  !< RLIMIT_…
         integer(c_long), intent(out) :: limits(2)  !< bytes: now, at most
      end function getrlimit
   end interface

contains

   !> Bytes that the system and the limits of the process leave; huge where neither says.
   real(wp) function free_memory() result(bytes)
      integer(c_long) :: limits(2)

      bytes = available_memory()
      if (getrlimit(address_space, limits) /= 0) return
      if (limits(1) >= 0) bytes = min(bytes, real(limits(1), wp))
   end function free_memory

   !> Memory available without swapping (MemAvailable of Linux), bytes.
   real(wp) function available_memory() result(bytes)
      character(len=80) :: line
      real(wp) :: kibibytes
      integer :: unit, status

      bytes = huge(1.0_wp)
      open (newunit=unit, file='/proc/meminfo', status='old', action='read', iostat=status)
      if (status /= 0) return
      do
         read (unit, '(a)', iostat=status) line
         if (status /= 0) exit
         if (index(line, key) /= 1) cycle
         read (line(len(key) + 1:), *, iostat=status) kibibytes
         if (status == 0) bytes = 1024*kibibytes
         exit
      end do
      close (unit, iostat=status)
   end function available_memory

end module dda_free_memory
