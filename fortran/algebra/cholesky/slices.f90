!> How the factor is kept: in slices of a few rows and six columns, one after the other, as a solve
!> reads them.
!>
!> For each own column of blocks of a front, the inverse of its pivot block and the own rows below
!> that; then, column by column, the rows below the front.  Zeros pad each to whole slices.  A solve
!> so reads one stream, at the rate of the memory, in place of six columns at a time that end after
!> a few hundred bytes.
module dda_slices
   implicit none
   private
   public :: slice_rows, slice_size, slices_of, own_slices

   integer, parameter :: slice_rows = 8               !< a vector register of single precision
   integer, parameter :: slice_size = 6*slice_rows    !< numbers in a slice

contains

   !> Slices that hold so many rows of blocks.
   pure integer function slices_of(rows)
      integer, intent(in) :: rows

      slices_of = (6*rows + slice_rows - 1)/slice_rows
   end function slices_of

   !> Slices of the pivots and own rows of a front.
   pure integer function own_slices(own)
      integer, intent(in) :: own
      integer :: j

      own_slices = 0
      do j = 1, own
         own_slices = own_slices + 1 + slices_of(own - j)
      end do
   end function own_slices

end module dda_slices
