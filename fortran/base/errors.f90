! SPDX-License-Identifier: GPL-3.0-or-later
!> Errors are returned as values: the library never stops its host.
!>
!> A procedure that can fail takes `type(error_type), allocatable, intent(out) :: error`;
!> unallocated means success.
module dda_errors
   implicit none
   private
   public :: error_type, fail, exit_status
   public :: error_input, error_check, error_convergence, error_solver, error_file, &
      error_interrupted, error_memory, error_checkpoint

   !> An error: its kind, and a message with position and remedy.
   type :: error_type
      integer :: kind                          !< one of the `error_…` constants
      character(len=:), allocatable :: message !< one or more sentences for the user
   end type error_type

   integer, parameter :: error_input = 1        !< the input cannot be run
   integer, parameter :: error_check = 2        !< the check rejects the run
   integer, parameter :: error_convergence = 3  !< a step does not converge
   integer, parameter :: error_solver = 4       !< the linear system cannot be solved
   integer, parameter :: error_file = 5         !< a file cannot be read or written
   integer, parameter :: error_interrupted = 6  !< stopped on request; results so far are saved
   integer, parameter :: error_memory = 7       !< there is not enough memory
   integer, parameter :: error_checkpoint = 8   !< no checkpoint can be used to continue from

contains

   !> Set an error: its kind and its message.
   pure subroutine fail(error, kind, message)
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      integer, intent(in) :: kind  !< kind: `error_…`
      character(len=*), intent(in) :: message  !< one or more sentences for the user

      error = error_type(kind, message)
   end subroutine fail

   !> Exit status of the executable: the kind of the error; checkpoint errors count as file errors.
   pure integer function exit_status(error)
      type(error_type), intent(in) :: error  !< error that ends the program

      exit_status = error%kind
      if (error%kind == error_checkpoint) exit_status = error_file
   end function exit_status

end module dda_errors
