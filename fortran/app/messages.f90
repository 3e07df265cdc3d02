! SPDX-License-Identifier: GPL-3.0-or-later
!> Lines for the terminal or the log of a batch job, each flushed at once, in chronological
!> order.
module dda_messages
   use, intrinsic :: iso_fortran_env, only: error_unit, output_unit
   implicit none
   private
   public :: say, warn

contains

   !> Write a line of results to the standard output.
   subroutine say(line)
      character(len=*), intent(in) :: line   !< without its line end

      call write_line(output_unit, line)
   end subroutine say

   !> Write a line to the standard error, after all earlier output has been flushed.
   subroutine warn(line)
      character(len=*), intent(in) :: line   !< without its line end

      call write_line(error_unit, line)
   end subroutine warn

   !> Write a line and flush; a closed pipe does not end a run.
   subroutine write_line(unit, line)
      integer, intent(in) :: unit            !< unit of the standard output or error
      character(len=*), intent(in) :: line   !< without its line end
      integer :: unused

      write (unit, '(a)', iostat=unused) line
      flush (unit, iostat=unused)
   end subroutine write_line

end module dda_messages
