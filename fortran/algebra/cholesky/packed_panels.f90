! SPDX-License-Identifier: GPL-3.0-or-later
!> Packed panels, the storage of the factor: eight rows by six columns each, in the order of a
!> solve.
!>
!> First, each pivot block column of a front has the inverse T of its pivot block and the pivot rows
!> below it, times T.  The rows below the front, times T, follow column by column.  Zeros complete
!> the last panels.  A solve then reads memory sequentially, at full bandwidth.
module dda_packed_panels
   implicit none
   private
   public :: packed_rows, packed_size, panels_of, pivot_panels

   integer, parameter :: packed_rows = 8  !< rows of a panel: a vector register of reals
   integer, parameter :: packed_size = 6*packed_rows    !< values in a packed panel

contains

   !> Return the number of packed panels for the given number of block rows.
   pure integer function panels_of(rows)
      integer, intent(in) :: rows  !< number of block rows

      panels_of = (6*rows + packed_rows - 1)/packed_rows
   end function panels_of

   !> Return the number of packed panels of the pivot rows of a front.
   pure integer function pivot_panels(pivots)
      integer, intent(in) :: pivots  !< block columns that the front eliminates
      integer :: j

      pivot_panels = 0
      do j = 1, pivots
         pivot_panels = pivot_panels + 1 + panels_of(pivots - j)
      end do
   end function pivot_panels

end module dda_packed_panels
