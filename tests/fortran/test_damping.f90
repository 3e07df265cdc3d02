! SPDX-License-Identifier: GPL-3.0-or-later
!> Damping of materials: the fit, the energy of a step, rest without creep, refusals.
module test_damping
   use dda_kinds, only: wp, pi
   use dda_damping, only: damping_type, fit_body, has_body, highest_relaxation, modulus_factor, &
      rayleigh_ratio, set_rayleigh
   use dda_energy, only: energy_residual, total_energy, energy_algorithmic, energy_damping, &
      energy_material_damping
   use dda_nonnegative, only: solve_nonnegative
   use dda_simulation, only: simulation_type
   use dda_text, only: to_text
   use models, only: begin, block_text, contact_text, control_text, joint_text, random_vector, &
      rectangle, run
   use testing, only: case, check, check_close, check_no_error, error
   implicit none

   character(len=*), parameter :: members(4) = [character(len=40) :: "integration = 'dda'", &
      "integration = 'midpoint'", "integration = 'theta'", "integration = 'backward_euler'"]

contains

   subroutine every_member()
      integer :: i

      do i = 1, size(members)
         call losses(trim(members(i)), 'damping_ratio = 0.2')
         call losses(trim(members(i)), 'damping_ratio = 0.05 rayleigh_frequencies = 2.0 12.0')
      end do
      call rest('damping_ratio = 0.05')
      call rest('rayleigh_alpha = 1.0')
   end subroutine every_member

   !> The conditions of Karush, Kuhn and Tucker: x ≥ 0, slope ≤ 0 if x = 0, otherwise slope = 0.
   subroutine min_squares_without_negative_unknowns()
      real(wp) :: a(12, 5), b(12), x(5), slope(5)
      integer :: trial, j

      do trial = 1, 50
         do j = 1, 5
            a(:, j) = random_vector(12)
         end do
         b = random_vector(12)
         call solve_nonnegative(a, b, x)
         slope = matmul(transpose(a), b - matmul(a, x))
         call check(all(x >= 0.0_wp), 'no negative unknown')
         call check(all(slope <= 1.0e-10_wp), 'nothing can enter')
         call check_close(x*slope, 0.0_wp*x, 'complementary', absolute=1.0e-10_wp)
      end do
   end subroutine min_squares_without_negative_unknowns

   !> ζ over the band, the given modulus at the reference frequency, Σ Y_l < 1.
   subroutine fitted_bodies()
      real(wp), parameter :: ratio(5) = [0.001_wp, 0.01_wp, 0.05_wp, 0.1_wp, 0.2_wp]
      !> largest errors over 0.1 … 50 Hz with 6, 8 and 10 mechanisms, published to two digits
      real(wp), parameter :: misfit_limit(3) = [1.7e-2_wp, 3.2e-3_wp, 8.0e-4_wp]
      type(damping_type) :: damping
      complex(wp) :: factor
      integer :: i, k

      call case('a damping ratio at all frequencies')
      do i = 1, size(ratio)
         damping = damping_type(ratio=ratio(i), reference=3.0_wp)
         call fit_body(damping, huge(1.0_wp), error)
         call check_no_error(error, 'fit')
         call check(damping%misfit < 1.0e-3_wp, 'enough mechanisms for the misfit')
         call check(sum(damping%weight) < 1.0_wp, 'stable')
         call check(all(damping%weight(:damping%n) > 0.0_wp), 'positive weights')
         do k = 0, 100
            factor = modulus_factor(damping, 2.0_wp*pi*0.1_wp*500.0_wp**(0.01_wp*k))
            call check_close(0.5_wp*aimag(factor)/real(factor), ratio(i), 'ζ', relative=1.0e-3_wp)
         end do
         call check_close(real(modulus_factor(damping, 6.0_wp*pi)), 1.0_wp, 'given modulus', &
            relative=1.0e-14_wp)
         call check(real(modulus_factor(damping, 1.0e9_wp)) <= damping%unrelaxed .and. &
            damping%unrelaxed > 1.0_wp, 'stiffest at once')
      end do
      do k = 1, size(misfit_limit)
         damping = damping_type(ratio=0.2_wp, reference=1.0_wp, n=4 + 2*k)
         call fit_body(damping, huge(1.0_wp), error)
         call check(damping%n == 4 + 2*k .and. damping%misfit < misfit_limit(k), &
            to_text(4 + 2*k)//' mechanisms')
      end do
      call case('mechanisms that a time step admits')
      damping = damping_type(ratio=0.05_wp, reference=1.0_wp)
      call fit_body(damping, highest_relaxation(1.0_wp, 1.0e-2_wp), error)
      call check_no_error(error, 'DDA at 10 ms')
      call check(maxval(damping%omega) <= 800.0_wp*(1 + 1.0e-12_wp), '(θ − ½) ω Δt ≤ 4')
      call check(damping%misfit < 1.0e-3_wp, 'over a narrower band')
   end subroutine fitted_bodies

   !> 5 % at 2 and 12 Hz.
   subroutine rayleigh_damping()
      type(damping_type) :: damping

      call set_rayleigh(damping, 0.05_wp, [2.0_wp, 12.0_wp])
      call check(.not. has_body(damping), 'no body')
      call check_close(damping%alpha, 1.0771175_wp, 'α', relative=1.0e-7_wp)
      call check_close(damping%beta, 1.136821e-3_wp, 'β', relative=1.0e-6_wp)
      call check_close(rayleigh_ratio(damping, [1.0_wp, 2.0_wp, 4.89898_wp, 12.0_wp, 24.0_wp]), &
         [8.92857e-2_wp, 0.05_wp, 3.49927e-2_wp, 0.05_wp, 8.92857e-2_wp], 'ζ', relative=1.0e-6_wp)
   end subroutine rayleigh_damping

   !> Two bonded blocks with initial velocities: all energy is explained; the loss of the material
   !> never decreases, nor its sum with the loss of the scheme, at the longest admissible step.
   subroutine losses(member, damping)
      character(len=*), intent(in) :: member, damping
      type(simulation_type) :: simulation
      real(wp) :: rates(6, 2), total, former_losses(2), first
      integer :: i

      call case('losses, '//member//', '//damping)
      rates = 1.0e-4_wp*reshape(random_vector(12), [6, 2])
      call begin(simulation, pair_text(8.0e-3_wp, member, damping), rates)
      first = total_energy(simulation%energy)
      total = first
      former_losses = 0.0_wp
      do i = 1, 300
         call run(simulation, 1)
         associate (value => simulation%energy%value)
            call check(value(energy_material_damping) >= former_losses(1), 'the material loses')
            call check(value(energy_material_damping) + value(energy_algorithmic) &
               + value(energy_damping) >= former_losses(2) - 1.0e-12_wp*first, &
               'all losses together')
            former_losses = value(energy_material_damping)
            former_losses(2) = former_losses(2) + value(energy_algorithmic) + value(energy_damping)
         end associate
         call check(total_energy(simulation%energy) <= total + 1.0e-9_wp*first, 'no gain')
         total = total_energy(simulation%energy)
      end do
      call check(former_losses(1) > 0.01_wp*first, 'the material has lost something')
      call check_close(energy_residual(simulation%energy), 0.0_wp, 'balance', &
         absolute=1.0e-9_wp*first)
   end subroutine losses

   !> Two stacked blocks at rest under gravity do not move.
   subroutine rest(damping)
      character(len=*), intent(in) :: damping
      type(simulation_type) :: simulation
      real(wp) :: initial_position(6, 2), sag

      call case('rest, '//damping)
      call begin(simulation, pair_text(1.0e-2_wp, 'settle = .true. gravity = 0.0 -10.0', damping))
      initial_position = simulation%blocks%position
      sag = maxval(abs(initial_position(4:5, :)))
      call run(simulation, 1000)
      call check(sag > 1.0e-7_wp, 'the weight acts')
      ! Statics leave 10⁻⁶ of the weight; a body that creeps moves by more than half of the sag.
      call check_close(simulation%blocks%position, initial_position, 'no creep', &
         absolute=1.0e-8_wp*sag)
   end subroutine rest

   !> Two soft blocks on top of each other, bonded, the lower one held.
   function pair_text(time_step, settings, damping) result(text)
      real(wp), intent(in) :: time_step
      character(len=*), intent(in) :: settings, damping
      character(len=:), allocatable :: text

      text = control_text(time_step, 10000, settings)//contact_text(2.0e9_wp, '')// &
         ' &material density = 2000.0 young_modulus = 5.0e7 poisson_ratio = 0.3 '//damping// &
         ' /'//joint_text(40.0_wp, 1.0e9_wp, 1.0e9_wp)// &
         block_text('low', rectangle(0.0_wp, 0.0_wp, 1.0_wp, 1.0_wp))// &
         block_text('high', rectangle(0.0_wp, 1.0_wp, 1.0_wp, 2.0_wp))// &
         ' &fixed_point x = 0.1 y = 0.1 / &fixed_point x = 0.9 y = 0.1 /'
   end function pair_text

end module test_damping
