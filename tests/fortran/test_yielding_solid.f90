! SPDX-License-Identifier: GPL-3.0-or-later
!> A solid of Mohr and Coulomb at one point: closed forms, energies of each step, tangents.
module test_yielding_solid
   use dda_kinds, only: wp, pi
   use dda_material, only: material_type, elasticity
   use dda_material_law, only: strain_point_type, losses, loss_plastic
   use dda_mohr_coulomb_solid, only: mohr_coulomb_solid_type
   use dda_scheme, only: scheme_type, step_type
   use models, only: random, random_vector, walk
   use testing, only: check
   implicit none

   real(wp), parameter :: cohesion = 3.45e6_wp, angle = pi/6.0_wp

contains

   !> Rock of c 3.45 MPa, φ 30°.
   pure type(mohr_coulomb_solid_type) function rock(dilation, tension)
      real(wp), intent(in) :: dilation, tension  !< rad; Pa

      rock%peak%cohesion = cohesion
      rock%peak%friction = angle
      rock%peak%dilation = dilation
      rock%peak%tension = min(tension, cohesion/tan(angle))
      rock%residual = rock%peak
   end function rock

   !> A point in its stress.
   type(strain_point_type) function point_in(plane_strain, stress) result(point)
      logical, intent(in) :: plane_strain
      real(wp), intent(in) :: stress(3)  !< Pa

      point%plane_strain = plane_strain
      point%elasticity = elasticity(material_type(young_modulus=7.0e9_wp, poisson_ratio=0.21_wp), &
         plane_strain)
      point%start_stress = stress
      point%thickness = 0.1_wp
   end function point_in

   !> Stress at the end, where a point is compressed along y and the stress along x is held by
   !> Newton's method on εx.
   function driven(law, point, to) result(stress)
      type(mohr_coulomb_solid_type), intent(in) :: law
      type(strain_point_type), intent(inout) :: point
      real(wp), intent(in) :: to  !< εy at the end
      integer, parameter :: steps = 200
      type(step_type) :: step
      real(wp) :: stress(3), state(6), strain(3), change(3), tangent(3, 3), loss(losses)
      integer :: i, k

      step = step_type(scheme_type(1.0_wp, 1.0_wp), 0.0_wp, 0.01_wp)
      state = 0.0_wp
      strain = 0.0_wp
      do i = 1, steps
         change = [0.0_wp, to/steps, 0.0_wp]
         point%bounding = law%frozen_stress(point, state, strain, 0*change, step)
         do k = 1, 60
            call law%respond(point, state, strain, change, step, stress, tangent)
            if (abs(stress(1)) <= 1.0e-13_wp*(cohesion + abs(stress(2)))) exit
            change(1) = change(1) - stress(1)/max(tangent(1, 1), 1.0e-3_wp*point%elasticity(1, 1))
            point%bounding = law%frozen_stress(point, state, strain, change, step)
         end do
         call law%finish(point, state, strain, change, step, loss)
         call check(loss(loss_plastic) >= 0.0_wp, 'yielding loses')
         strain = strain + change
      end do
      stress = stress + point%start_stress
   end function driven

   !> q_u = 2c tan(45° + φ/2) and σ₃ tan²(45° + φ/2) + q_u, for any dilation, in both states.
   subroutine squeezed_points_have_the_strength_of_the_closed_form()
      real(wp), parameter :: confining(3) = [0.0_wp, 5.0e6_wp, 2.0e7_wp]
      real(wp), parameter :: dilations(3) = [0.0_wp, 0.3_wp, angle]
      real(wp) :: stress(3), ratio, expected_stress
      type(strain_point_type) :: point
      integer :: i, k, kind

      ratio = tan(0.25_wp*pi + 0.5_wp*angle)**2
      do kind = 1, 2
         do i = 1, size(confining)
            do k = 1, size(dilations)
               expected_stress = ratio*confining(i) + 2.0_wp*cohesion*sqrt(ratio)
               point = point_in(kind == 1, [-confining(i), -confining(i), 0.0_wp])
               ! Across a plane without stress the strength is that of no confinement.
               if (kind == 2) expected_stress = 2.0_wp*cohesion*sqrt(ratio)
               stress = driven(rock(dilations(k), huge(1.0_wp)), point, -0.03_wp)
               call check(abs(-stress(2) - expected_stress) <= 1.0e-9_wp*expected_stress, &
                  'the strength is exact')
            end do
         end do
      end do
   end subroutine squeezed_points_have_the_strength_of_the_closed_form

   !> σ = T.
   subroutine pulled_points_have_the_tensile_strength()
      type(strain_point_type) :: point
      real(wp) :: stress(3)
      integer :: kind

      do kind = 1, 2
         point = point_in(kind == 1, [0.0_wp, 0.0_wp, 0.0_wp])
         stress = driven(rock(0.0_wp, 1.0e6_wp), point, 0.001_wp)
         call check(abs(stress(2) - 1.0e6_wp) <= 1.0e-9_wp*1.0e6_wp, 'tension is cut off')
      end do
   end subroutine pulled_points_have_the_tensile_strength

   !> Under the pressure p a shear γ^p of ψ = 0 requires ½ p γ^p; γ^p = γ − (c cos φ + p sin φ)/G.
   subroutine shear_keeps_its_area_under_pressure()
      real(wp), parameter :: p = 5.0e6_wp, shear = 0.02_wp
      integer, parameter :: steps = 50
      type(mohr_coulomb_solid_type) :: law
      type(strain_point_type) :: point
      type(step_type) :: step
      real(wp) :: state(6), strain(3), change(3), loss(losses), expected
      integer :: i, kind

      law = rock(0.0_wp, huge(1.0_wp))
      step = step_type(scheme_type(1.0_wp, 1.0_wp), 0.0_wp, 0.01_wp)
      change = [0.0_wp, 0.0_wp, shear/steps]
      do kind = 1, 2
         point = point_in(kind == 1, [-p, -p, 0.0_wp])
         law%out_of_plane = -p*(1.0_wp - 2.0_wp*0.21_wp)  ! σz = −p in plane strain
         state = 0.0_wp
         do i = 1, steps
            strain = (i - 1)*change
            point%bounding = law%frozen_stress(point, state, strain, change, step)
            call law%finish(point, state, strain, change, step, loss)
         end do
         expected = 0.5_wp*p*(shear - (cohesion*cos(angle) + p*sin(angle))/point%elasticity(3, 3))
         call check(all(abs(law%shape_stress(state) - [0.0_wp, 0.0_wp, expected]) &
            <= 1.0e-9_wp*expected), 'half the pressure times the plastic shear')
      end do
   end subroutine shear_keeps_its_area_under_pressure

   !> s·Δε = Δψ + losses, each ≥ 0, on paths that turn, at three θ, in both states, with softening.
   subroutine each_step_balances_and_loses()
      real(wp), parameter :: thetas(3) = [0.5_wp, 0.75_wp, 1.0_wp]
      type(mohr_coulomb_solid_type) :: law
      type(strain_point_type) :: point
      real(wp) :: s(3, 2000)
      integer :: i, k, kind

      do kind = 1, 2
         point = point_in(kind == 1, [-1.0e6_wp, -2.0e6_wp, 5.0e5_wp])
         do k = 0, 2
            law = rock(0.5_wp*k*angle, merge(1.0e6_wp, huge(1.0_wp), k < 2))
            if (kind == 1) law%out_of_plane = -2.0e5_wp*k
            if (k == 1) then
               law%softening = 0.05_wp
               law%residual%cohesion = 0.0_wp
               law%residual%tension = 0.0_wp
            end if
            do i = 1, 3
               call walk(law, point, thetas(i), [1.0e-12_wp, 1.0e-14_wp], s)
               ! R ≤ c cos φ − p sin φ of the peak
               if (k == 2) call check(maxval(hypot(0.5_wp*(s(1, :) - s(2, :)), s(3, :)) &
                  + 0.5_wp*(s(1, :) + s(2, :))*sin(angle)) < cohesion*(cos(angle) + 1.0e-9_wp), &
                  'the stress is admitted')
            end do
         end do
      end do
   end subroutine each_step_balances_and_loses

   !> Away from corners, tangents agree with differences and are symmetric.
   subroutine tangents_are_derivatives()
      type(mohr_coulomb_solid_type) :: law
      type(strain_point_type) :: point
      type(step_type) :: step
      real(wp) :: change(3), shifted_change(3), stress(3), shifted_stress(3), tangent(3, 3), &
         ignored(3, 3), difference
      real(wp) :: state(6)
      integer :: i, k, n_wrong

      state = 0.0_wp
      step = step_type(scheme_type(1.0_wp, 1.0_wp), 0.0_wp, 0.01_wp)
      n_wrong = 0
      do i = 1, 2000
         point = point_in(modulo(i, 2) == 0, 1.0e6_wp*random_vector(3))
         law = rock(random(0.0_wp, angle), 1.0e6_wp)
         point%bounding = 1.0e6_wp*random_vector(3)
         change = 3.0e-3_wp*random_vector(3)
         call law%respond(point, state, [0.0_wp, 0.0_wp, 0.0_wp], change, step, stress, tangent)
         call check(maxval(abs(tangent - transpose(tangent))) <= 1.0e-12_wp &
            *point%elasticity(1, 1), 'the tangent is symmetric')
         difference = 0.0_wp
         do k = 1, 3
            shifted_change = change
            shifted_change(k) = shifted_change(k) + 1.0e-9_wp
            call law%respond(point, state, [0.0_wp, 0.0_wp, 0.0_wp], shifted_change, step, &
               shifted_stress, ignored)
            difference = max(difference, maxval(abs((shifted_stress - stress)/1.0e-9_wp - &
               tangent(:, k))))
         end do
         if (difference > 1.0e-4_wp*point%elasticity(1, 1)) n_wrong = n_wrong + 1
      end do
      call check(n_wrong <= 4, 'the tangent is the derivative')
   end subroutine tangents_are_derivatives

end module test_yielding_solid
