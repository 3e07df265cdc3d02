! SPDX-License-Identifier: GPL-3.0-or-later
!> A hysteretic law on paths that turn in the plane: energies of each step, convexity.
module test_plane_law
   use dda_kinds, only: wp
   use dda_branches, only: branches_type, fit_branches, curve_type
   use dda_damping, only: damping_type
   use dda_hysteretic_law, only: hysteretic_law_type, new_hysteretic_law
   use dda_material, only: material_type, elasticity
   use dda_material_law, only: strain_point_type
   use dda_plane_branches, only: compute_recoverable_stress, potential
   use dda_soil_curves, only: soil_type, find_curve
   use models, only: random, random_vector, walk
   use testing, only: check, error
   implicit none

contains

   !> The work of the stress of a recoverable branch equals the change of its potential for θ = ½;
   !> its slope agrees with differences.
   subroutine recoverable_branches_lose_nothing_and_are_gradients()
      real(wp) :: e(2), change(2), acting(2), slope(2, 2), shifted_change(2), of_more(2, 2), &
         max_error(3), scale
      integer :: i, k

      max_error = 0.0_wp
      do i = 1, 4000
         e = 3.0_wp*random_vector(2)
         scale = 10.0_wp**random(-9.0_wp, 0.0_wp)
         change = 2.0_wp*scale*random_vector(2)
         call compute_recoverable_stress(e, change, 1.0_wp, 0.5_wp, acting, slope)
         max_error(1) = max(max_error(1), abs(dot_product(acting, change) - potential(e + change, &
            1.0_wp) + potential(e, 1.0_wp)))
         max_error(2) = max(max_error(2), norm2(acting) - 1.0_wp)
         if (norm2(change) > 0.3_wp) cycle
         do k = 1, 2
            shifted_change = change
            shifted_change(k) = shifted_change(k) + 1.0e-6_wp
            call compute_recoverable_stress(e, shifted_change, 1.0_wp, 0.5_wp, shifted_change, &
               of_more)
            max_error(3) = max(max_error(3), maxval(abs((shifted_change - acting)/1.0e-6_wp - &
               slope(:, k))))
         end do
      end do
      call check(max_error(1) < 4.0e-15_wp, 'work is the growth of the potential')
      call check(max_error(2) < 1.0e-14_wp, 'the cap holds')
      call check(max_error(3) < 0.05_wp, 'the slope is the derivative')
   end subroutine recoverable_branches_lose_nothing_and_are_gradients

   !> s·Δε = Δψ + losses, each ≥ 0, on random paths, with target loops and Masing's, at three θ.
   subroutine each_step_balances_and_loses()
      real(wp), parameter :: thetas(3) = [0.5_wp, 0.75_wp, 1.0_wp]
      type(hysteretic_law_type) :: law
      type(strain_point_type) :: point
      real(wp) :: path(3, 2000)
      integer :: i, kind

      point%elasticity = elasticity(material_type(young_modulus=2.0e8_wp, poisson_ratio=0.3_wp), &
         .true.)
      point%start_stress = [-1.0e5_wp, -2.0e5_wp, 3.0e4_wp]
      do kind = 1, 2
         call make_law(kind == 2, law)
         call check(.not. allocated(error), 'the law is fitted')
         do i = 1, 3
            call walk(law, point, thetas(i), [1.0e-13_wp, 1.0e-13_wp], path)
         end do
      end do
   end subroutine each_step_balances_and_loses

   !> Darendeli's soil.
   subroutine make_law(masing, law)
      logical, intent(in) :: masing
      type(hysteretic_law_type), intent(out) :: law
      type(curve_type) :: curve
      type(branches_type) :: branches
      type(soil_type) :: soil

      soil%curve = 'darendeli'
      soil%plasticity = 15.0_wp
      call find_curve(soil, curve, error)
      call fit_branches(curve, 20, masing, damping_type(ratio=0.01_wp, reference=1.0_wp), &
         100.0_wp, branches, error)
      law = new_hysteretic_law(branches)
   end subroutine make_law

end module test_plane_law
