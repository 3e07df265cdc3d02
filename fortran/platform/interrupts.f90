! SPDX-License-Identifier: GPL-3.0-or-later
!> Ask the run to stop: Ctrl-C, SIGTERM, and SIGUSR1, which batch systems send before a time limit.
module dda_interrupts
   use, intrinsic :: iso_c_binding, only: c_funloc, c_funptr, c_int, c_intptr_t
   implicit none
   private
   public :: watch_interrupts, stop_requested

   !> SIGINT, SIGUSR1, SIGTERM, SIGXFSZ of Linux
   integer(c_int), parameter :: interrupt = 2_c_int, user = 10_c_int, terminate = 15_c_int, &
      file_size = 25_c_int
   integer(c_intptr_t), parameter :: ignored = 1_c_intptr_t   !< SIG_IGN

   integer(c_int), volatile :: last_signal = 0

   interface
      !> C library: call a handler when a signal comes.
      type(c_funptr) function c_signal(number, handler) bind(c, name='signal')
         import :: c_funptr, c_int
         integer(c_int), value :: number  !< of the signal
         type(c_funptr), value :: handler  !< SIG_IGN or a procedure
      end function c_signal
   end interface

contains

   !> From here on the signals only set a mark, and a file that may not grow is an error of its
   !> write.
   subroutine watch_interrupts()
      type(c_funptr) :: before, ignore

      ignore = transfer(ignored, ignore)
      before = c_signal(interrupt, c_funloc(note))
      before = c_signal(user, c_funloc(note))
      before = c_signal(terminate, c_funloc(note))
      before = c_signal(file_size, ignore)
   end subroutine watch_interrupts

   !> The handler: only note the signal.
   subroutine note(number) bind(c)
      integer(c_int), value :: number  !< of the signal

      last_signal = number
   end subroutine note

   !> One of the signals has come.
   logical function stop_requested()
      stop_requested = last_signal /= 0
   end function stop_requested

end module dda_interrupts
