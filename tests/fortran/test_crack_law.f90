! SPDX-License-Identifier: GPL-3.0-or-later
!> A point of a broken face: energies of each step, fracture energy, and onset of damage.
module test_crack_law
   use dda_kinds, only: wp
   use dda_cohesive, only: cohesive_type, new_cohesive
   use dda_crack_law, only: crack_law_type, has_failed
   use dda_material, only: joint_type
   use dda_material_law, only: strain_point_type, losses, loss_plastic, loss_scheme
   use dda_scheme, only: scheme_type, step_type
   use models, only: random_vector
   use testing, only: check
   implicit none

   real(wp), parameter :: tension = 2.0e6_wp, cohesion = 5.0e6_wp, energies(2) = [60.0_wp, 400.0_wp]
   real(wp), parameter :: stiffness(2) = [1.0e12_wp, 4.0e11_wp]

contains

   !> A joint of φ 30°.
   type(crack_law_type) function law_of(softening) result(law)
      character(len=*), intent(in) :: softening  !< linear or exponential
      type(joint_type) :: joint
      type(cohesive_type) :: bond

      joint%friction_angle = 30.0_wp
      joint%tensile_strength = tension
      joint%cohesion = cohesion
      joint%fracture_energy = energies(1)
      joint%shear_fracture_energy = energies(2)
      joint%softening = softening
      bond = new_cohesive(joint)
      bond%normal_stiffness = stiffness(1)
      bond%shear_stiffness = stiffness(2)
      law%joint = bond
   end function law_of

   !> s·Δw = Δψ + losses to rounding, in all states, and damage never decreases.
   subroutine steps_of_a_broken_face_balance()
      type(crack_law_type) :: law
      type(strain_point_type) :: point
      type(step_type) :: step
      real(wp) :: state(2), strain(3), change(3), stress(3), tangent(3, 3), loss(losses)
      real(wp) :: stored, damage, max_error, work, smallest_loss
      integer :: i, k

      do k = 1, 3
         step = step_type(scheme_type(0.25_wp + 0.25_wp*k, 1.0_wp), 0.0_wp, 0.01_wp)
         law = law_of(merge('linear     ', 'exponential', k < 3))
         point%bounding = 0.0_wp
         state = 0.0_wp
         strain = 0.0_wp
         work = 0.0_wp
         max_error = 0.0_wp
         smallest_loss = 0.0_wp
         do i = 1, 2000
            change = 2.0e-6_wp*random_vector(3) - 0.03_wp*strain
            change(3) = 0.0_wp
            stored = law%stored(point, state, strain)
            damage = state(1)
            point%bounding = law%frozen_stress(point, state, strain, change, step)
            call law%respond(point, state, strain, change, step, stress, tangent)
            call law%finish(point, state, strain, change, step, loss)
            strain = strain + change
            work = work + abs(dot_product(stress, change))
            max_error = max(max_error, abs(dot_product(stress, change) - law%stored(point, state, &
               strain) + stored - sum(loss)))
            smallest_loss = min(smallest_loss, loss(loss_plastic), loss(loss_scheme))
            call check(state(1) >= damage, 'damage does not fall')
         end do
         call check(max_error <= 1.0e-12_wp*work, 'the step balances')
         call check(smallest_loss >= -1.0e-12_wp*work, 'fracture and scheme lose')
         call check(state(1) > 0.1_wp, 'it is damaged')
      end do
   end subroutine steps_of_a_broken_face_balance

   !> Opened, or sheared without pressure, in steps that are solved for D*.
   subroutine opening_and_slip_spend_the_fracture_energy()
      type(crack_law_type) :: law
      type(strain_point_type) :: point
      type(step_type) :: step
      real(wp) :: state(2), strain(3), change(3), stress(3), tangent(3, 3), loss(losses), spent
      integer :: mode, i, k

      step = step_type(scheme_type(0.5_wp, 0.5_wp), 0.0_wp, 0.01_wp)
      do mode = 1, 2
         law = law_of('linear')
         point%bounding = 0.0_wp
         state = 0.0_wp
         strain = 0.0_wp
         spent = 0.0_wp
         change = 0.0_wp
         change(mode) = 2.2_wp*energies(mode)/merge(tension, cohesion, mode == 1)/40
         do i = 1, 40
            do k = 1, 3
               point%bounding = law%frozen_stress(point, state, strain, change, step)
            end do
            call law%respond(point, state, strain, change, step, stress, tangent)
            call law%finish(point, state, strain, change, step, loss)
            spent = spent + loss(loss_plastic)
            strain = strain + change
         end do
         call check(has_failed(state), 'the bond is gone')
         call check(abs(spent - energies(mode)) <= 1.0e-9_wp*energies(mode), 'its energy is spent')
         call check(law%stored(point, state, strain) <= 1.0e-12_wp*spent, 'nothing is stored')
      end do
   end subroutine opening_and_slip_spend_the_fracture_energy

   !> T in tension, c + σ tan φ in shear.
   subroutine damage_begins_at_the_strength()
      type(crack_law_type) :: law

      law = law_of('linear')
      call check(abs(law%traction_ratio([tension, 0.0_wp]) - 1.0_wp) <= 1.0e-14_wp, 'tension')
      call check(abs(law%traction_ratio([-1.0e6_wp, cohesion + 1.0e6_wp/sqrt(3.0_wp)]) - 1.0_wp) &
         <= 1.0e-12_wp, 'shear under pressure')
      call check(abs(law%traction_ratio([0.6_wp*tension, -0.8_wp*cohesion]) - 1.0_wp) &
         <= 1.0e-14_wp, 'both')
   end subroutine damage_begins_at_the_strength

end module test_crack_law
