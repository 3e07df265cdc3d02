! SPDX-License-Identifier: GPL-3.0-or-later
!> Cosine taper at both ends of a series.
module dda_taper
   use dda_kinds, only: wp, pi
   implicit none
   private
   public :: cosine_taper

contains

   !> Weights of a Tukey window (Harris 1978): half a cosine from 0 to 1, ones, half a cosine to 0.
   pure function cosine_taper(count, fraction) result(weight)
      integer, intent(in) :: count           !< samples
      !> fraction of the length that is tapered, half at each end, 0 … 1
      real(wp), intent(in) :: fraction
      real(wp) :: weight(count)              !< [samples], between 0 and 1
      real(wp) :: width                      ! width of one flank, in samples
      integer :: i

      weight = 1.0_wp
      width = 0.5_wp*fraction*real(count - 1, wp)
      if (.not. width > 0.0_wp) return
      do i = 1, count
         ! Half a cosine by the distance to the nearer end.
         weight(i) = 0.5_wp*(1.0_wp - cos(pi*min(1.0_wp, real(min(i - 1, count - i), wp)/width)))
      end do
   end function cosine_taper

end module dda_taper
