! SPDX-License-Identifier: GPL-3.0-or-later
!> Butterworth low-pass of fourth order for accelerations, sample by sample.
!>
!> Two oscillators in series, u' = ωw and w' = ω(a − u − 2ζw) with ζ = cos(π/8) and cos(3π/8), are
!> stepped by the trapezoidal rule.  With ωh/2 = tan(πfh), half of the power at f passes for
!> any step h.
module dda_low_pass
   use dda_kinds, only: wp, pi
   implicit none
   private
   public :: low_pass_type, pass

   integer, parameter :: sections = 2
   real(wp), parameter :: damping(sections) = cos([1, 3]*pi/8)
   real(wp), parameter :: largest_ratio = 0.45_wp  !< largest f as a fraction of the sampling rate
   !> relative difference of equal steps, due to rounding
   real(wp), parameter :: same_step = 1.0e-9_wp

   !> Filter of one motion.
   type :: low_pass_type
      real(wp) :: frequency = 0.0_wp           !< f, Hz
      real(wp) :: step = 0.0_wp                !< step h of the factor, s
      real(wp) :: factor = 0.0_wp              !< ωh/2
      real(wp) :: rate(sections) = 0.0_wp      !< w, m/s²
      real(wp) :: passed(0:sections) = 0.0_wp  !< a, and u of each section, m/s²
   end type low_pass_type

contains

   !> Filter one more acceleration, m/s².
   pure subroutine pass(filter, acceleration, step, low)
      type(low_pass_type), intent(inout) :: filter  !< filter of the motion so far
      real(wp), intent(in) :: acceleration          !< acceleration, m/s²
      real(wp), intent(in) :: step                  !< time since the last acceleration, s
      real(wp), intent(out) :: low                  !< filtered acceleration, m/s²
      real(wp) :: sum, rate
      integer :: i

      if (abs(step - filter%step) > same_step*step) then
         filter%step = step
         filter%factor = tan(pi*min(filter%frequency*step, largest_ratio))
      end if
      sum = filter%passed(0) + acceleration
      filter%passed(0) = acceleration
      do i = 1, sections
         associate (c => filter%factor, u => filter%passed(i), w => filter%rate(i))
            rate = (w*(1.0_wp - c*(c + 2.0_wp*damping(i))) + c*(sum - 2.0_wp*u)) &
               /(1.0_wp + c*(c + 2.0_wp*damping(i)))
            sum = u + u + c*(w + rate)
            u = sum - u
            w = rate
         end associate
      end do
      low = filter%passed(sections)
   end subroutine pass

end module dda_low_pass
