! SPDX-License-Identifier: GPL-3.0-or-later
!> sitedda-native: run an input without Python.
program sitedda_native
   use dda_arguments, only: arguments_type, read_arguments
   use dda_driver, only: act
   use dda_errors, only: error_type, exit_status
   use dda_interrupts, only: watch_interrupts
   use dda_messages, only: warn
   implicit none

   type(arguments_type) :: arguments
   type(error_type), allocatable :: error

   call watch_interrupts
   call read_arguments(arguments, error)
   if (.not. allocated(error)) call act(arguments, error)
   if (allocated(error)) then
      call warn('sitedda-native: '//error%message)
      stop exit_status(error), quiet=.true.
   end if

end program sitedda_native
