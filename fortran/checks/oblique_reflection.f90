! SPDX-License-Identifier: GPL-3.0-or-later
!> Energy of plane waves in plane strain that is reflected by dashpots ρV_p along the normal and
!> ρV_s along the edge (Lysmer and Kuhlemeyer 1969).
!>
!> Units: V_s = 1, ρ = 1.  The incident wave has the direction (sin i, cos i) to the edge y = 0.  p
!> is the slowness along the edge, which is the same for the incident and the reflected P and S
!> waves.
module dda_oblique_reflection
   use dda_kinds, only: wp, pi
   implicit none
   private
   public :: wave_p, wave_s, reflected_energy, absorbed_angle

   integer, parameter :: wave_p = 1, wave_s = 2  !< kinds of waves

contains

   !> Fraction of the energy of a wave that is reflected as P and S waves together.
   pure real(wp) function reflected_energy(ratio, wave, angle)
      real(wp), intent(in) :: ratio  !< V_p/V_s, above √2
      integer, intent(in) :: wave    !< incident wave: wave_p or wave_s
      real(wp), intent(in) :: angle  !< angle from the normal, rad, below π/2
      complex(wp) :: normal(2), row(2, 2), known(2), amplitude(2), determinant
      real(wp) :: speed(2), p

      speed = [ratio, 1.0_wp]
      p = sin(angle)/speed(wave)
      normal = sqrt(cmplx(1.0_wp - (p*speed)**2, 0.0_wp, wp))  ! cosines of both waves
      if (p*ratio > 1.0_wp) normal(1) = -normal(1)             ! P decays inwards
      row(:, wave_p) = stress_imbalance(ratio, wave_p, p, -normal(wave_p))
      row(:, wave_s) = stress_imbalance(ratio, wave_s, p, -normal(wave_s))
      known = -stress_imbalance(ratio, wave, p, normal(wave))
      determinant = row(1, 1)*row(2, 2) - row(1, 2)*row(2, 1)
      amplitude = [known(1)*row(2, 2) - known(2)*row(1, 2), known(2)*row(1, 1) &
         - known(1)*row(2, 1)]/determinant
      reflected_energy = sum(abs(amplitude)**2*speed*real(normal))/(speed(wave)*real(normal(wave)))
   end function reflected_energy

   !> Normal and tangential stress on the edge due to a unit wave, minus the stress of the dashpots,
   !> divided by −iω.
   pure function stress_imbalance(ratio, wave, p, cosine)
      real(wp), intent(in) :: ratio       !< V_p/V_s
      integer, intent(in) :: wave         !< wave_p or wave_s
      real(wp), intent(in) :: p           !< slowness along the edge
      complex(wp), intent(in) :: cosine   !< cosine of the wave direction to the outward normal
      complex(wp) :: stress_imbalance(2)
      complex(wp) :: d(2), u(2)
      real(wp) :: speed, lambda

      lambda = ratio**2 - 2.0_wp
      speed = merge(ratio, 1.0_wp, wave == wave_p)
      d = [cmplx(p*speed, 0.0_wp, wp), cosine]
      u = d
      if (wave == wave_s) u = [cosine, -d(1)]
      stress_imbalance(1) = (lambda*sum(d*u) + 2.0_wp*d(2)*u(2))/speed - ratio*u(2)
      stress_imbalance(2) = (d(2)*u(1) + d(1)*u(2))/speed - u(1)
   end function stress_imbalance

   !> Largest whole angle, degrees, up to which at most a given energy fraction is reflected.
   pure integer function absorbed_angle(ratio, wave, share) result(angle)
      real(wp), intent(in) :: ratio  !< V_p/V_s
      integer, intent(in) :: wave    !< wave_p or wave_s
      real(wp), intent(in) :: share  !< fraction of the energy

      do angle = 0, 88
         if (reflected_energy(ratio, wave, (angle + 1)*pi/180.0_wp) > share) return
      end do
   end function absorbed_angle

end module dda_oblique_reflection
