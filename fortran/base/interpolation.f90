! SPDX-License-Identifier: GPL-3.0-or-later
!> Tables: interval of an abscissa, interpolation, logarithmic spacing.
module dda_interpolation
   use dda_kinds, only: wp
   implicit none
   private
   public :: find_interval, table_value, log_spaced

contains

   !> Find the interval of a table that contains a time, and the fraction of the time in it.  The
   !> value at this time is v(k) + fraction × (v(last) − v(k)).  Of equal times, the last is used.
   pure subroutine find_interval(times, time, k, last, fraction)
      real(wp), intent(in) :: times(:)  !< times, s, ascending, times(1) ≤ time ≤ times(size(times))
      real(wp), intent(in) :: time      !< time, s
      integer, intent(out) :: k, last   !< ends of the interval; equal in a table of one time
      real(wp), intent(out) :: fraction  !< fraction of the interval, 0 … 1
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
      fraction = 1.0_wp
      if (times(last) > times(k)) fraction = (time - times(k))/(times(last) - times(k))
   end subroutine find_interval

   !> Value of a table at an argument: linear between rows, constant beyond the ends.
   pure real(wp) function table_value(arguments, values, argument) result(value)
      real(wp), intent(in) :: arguments(:)  !< ascending
      real(wp), intent(in) :: values(:)     !< value at each argument
      real(wp), intent(in) :: argument      !< any
      real(wp) :: fraction
      integer :: k, last

      call find_interval(arguments, min(max(argument, arguments(1)), arguments(size(arguments))), &
         k, last, fraction)
      value = values(k) + fraction*(values(last) - values(k))
   end function table_value

   !> Numbers between two limits, equally spaced in their logarithm.
   pure function log_spaced(first, last, n) result(list)
      real(wp), intent(in) :: first, last  !< above 0
      integer, intent(in) :: n             !< 2 at least
      real(wp) :: list(n)
      integer :: i

      list = [(first*(last/first)**(real(i, wp)/(n - 1)), i=0, n - 1)]
   end function log_spaced

end module dda_interpolation
