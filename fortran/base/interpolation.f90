! SPDX-License-Identifier: GPL-3.0-or-later
!> Where a time lies in a table.
module dda_interpolation
   use dda_kinds, only: wp
   implicit none
   private
   public :: find_interval

contains

   !> The interval of a table in which a time lies, and its share of it: the value there is
   !> v(k) + share (v(last) − v(k)).  Of times that are equal the last one counts.
   pure subroutine find_interval(times, time, k, last, share)
      real(wp), intent(in) :: times(:)  !< s, ascending, times(1) ≤ time ≤ times(size(times))
      real(wp), intent(in) :: time      !< s
      integer, intent(out) :: k, last   !< ends of the interval; the same in a table of one time
      real(wp), intent(out) :: share    !< 0 … 1
      integer :: middle

      k = 1
      last = size(times)
      do while (last - k > 1)
         middle = (k + last)/2
         if (times(middle) <= time) then
            k = middle
         else
            last = middle
         end if
      end do
      share = 1.0_wp
      if (times(last) > times(k)) share = (time - times(k))/(times(last) - times(k))
   end subroutine find_interval

end module dda_interpolation
