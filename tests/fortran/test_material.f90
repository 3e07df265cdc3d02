! SPDX-License-Identifier: GPL-3.0-or-later
!> Elasticity against the compliance of Hooke's law.
module test_material
   use dda_kinds, only: wp
   use dda_material, only: elasticity, material_type
   use testing, only: case, check_close
   implicit none

contains

   subroutine elasticity_for_any_poisson_ratio()
      real(wp), parameter :: ratio(5) = [-0.5_wp, 0.0_wp, 0.2_wp, 0.25_wp, 0.45_wp]
      integer :: i

      do i = 1, size(ratio)
         call inverse_of_compliance(material_type('', 2643.0_wp, 4.788e9_wp, ratio(i), 0.0_wp, &
            0.0_wp))
      end do
   end subroutine elasticity_for_any_poisson_ratio

   !> ε = S σ: plane stress as it stands; plane strain with σz = ν(σx + σy).
   subroutine inverse_of_compliance(rock)
      type(material_type), intent(in) :: rock
      real(wp) :: s(3, 3), unit(3, 3), e, nu
      integer :: i

      e = rock%young_modulus
      nu = rock%poisson_ratio
      unit = 0.0_wp
      do i = 1, 3
         unit(i, i) = 1.0_wp
      end do
      call case('plane stress')
      s = reshape([1.0_wp, -nu, 0.0_wp, -nu, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, &
         2.0_wp*(1.0_wp + nu)], [3, 3])/e
      call check_close(matmul(elasticity(rock, .false.), s), unit, 'D S', absolute=1.0e-14_wp)
      call case('plane strain')
      s(1, 1) = (1.0_wp - nu**2)/e
      s(2, 2) = s(1, 1)
      s(1, 2) = -nu*(1.0_wp + nu)/e
      s(2, 1) = s(1, 2)
      call check_close(matmul(elasticity(rock, .true.), s), unit, 'D S', absolute=1.0e-13_wp)
   end subroutine inverse_of_compliance

end module test_material
