! SPDX-License-Identifier: GPL-3.0-or-later
!> How the last call of this thread failed, if it did; `take_error` of the host hands it over.
module api_failure
   use dda_errors, only: error_type, error_input, fail
   implicit none
   private
   public :: error, check_size

   type(error_type), allocatable :: error
   !$omp threadprivate(error)

contains

   !> An array of Python has the size that the model, or a record, requires.
   subroutine check_size(given, wanted)
      integer, intent(in) :: given, wanted

      if (given /= wanted) call fail(error, error_input, 'the array has not the size of the model')
   end subroutine check_size

end module api_failure
