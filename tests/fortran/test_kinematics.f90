! SPDX-License-Identifier: GPL-3.0-or-later
!> A support against its closed forms (docs/method.md), and the coordinates from step to step: one
!> block on one fixed point at its centroid is a mass on a support in x and in y.
module test_kinematics
   use dda_kinds, only: wp, pi
   use dda_blocks, only: blocks_type, update_geometry
   use dda_kinematics, only: damp_velocity, largest_displacement, integrate, kinetic_energy
   use dda_scheme, only: scheme_type, step_type
   use dda_outlines, only: add_outline, outlines_type
   use dda_simulation, only: simulation_type
   use models, only: begin, block_text, make_rock_blocks, contact_text, control_text, fan, &
      joint_text, number, place_blocks, random_vector, rectangle, run, star
   use testing, only: case, check, check_close
   implicit none

   real(wp), parameter :: mass = 1000.0_wp, stiffness = 4.0e5_wp   !< ω = 20 /s
   real(wp), parameter :: omega = 20.0_wp
   type(simulation_type) :: simulation
   type(blocks_type) :: blocks

contains

   subroutine oscillators()
      real(wp), parameter :: omega_dt(7) = [0.01_wp, 0.1_wp, 0.5_wp, 1.0_wp, 2.0_wp, 3.5_wp, &
         10.0_wp]
      integer :: i

      do i = 1, size(omega_dt)
         call check_free_vibration(omega_dt(i))
      end do
      call check_harmonic_drive(0.05_wp, 10.0_wp)
      call check_harmonic_drive(0.01_wp, 20.0_wp)
      call check_harmonic_drive(0.02_wp, 35.0_wp)
      call check_accepted_step(0.5_wp)
      call check_accepted_step(0.75_wp)
      call check_accepted_step(1.0_wp)
   end subroutine oscillators

   subroutine begin_oscillator(time_step, steps, velocity, motion)
      real(wp), intent(in) :: time_step
      integer, intent(in) :: steps
      character(len=*), intent(in) :: velocity, motion

      call begin(simulation, control_text(time_step, steps, '')//contact_text(stiffness, &
         'fixed_point_ratio = 1.0')//joint_text(0.0_wp, 0.0_wp, 0.0_wp)// &
         ' &material density = 1000.0 young_modulus = 1.0e9 poisson_ratio = 0.2'// &
         ' initial_velocity = '//velocity//' 0.0 0.0 /'//motion// &
         block_text('b', rectangle(-0.5_wp, -0.5_wp, 0.5_wp, 0.5_wp))// &
         ' &fixed_point x = 0.0 y = 0.0 '//merge("motion_x = 'm'", '              ', &
         motion /= '')//' /')
   end subroutine begin_oscillator

   !> From four samples of the motion, the recursion x₂ = trace x₁ − det x₀ and with it |λ|, phase
   !> and damping.
   subroutine check_free_vibration(omega_dt)
      real(wp), intent(in) :: omega_dt   !< Ω = ωΔt
      real(wp) :: x(0:3), det, trace, determinant, radius, phase, damping
      integer :: i

      call case('free vibration at Ω = '//number(omega_dt))
      call begin_oscillator(omega_dt/omega, 100, '1.0', '')
      call run(simulation, 1)
      do i = 0, 3
         x(i) = simulation%blocks%position(1, 1)
         call run(simulation, 1)
      end do
      determinant = x(1)**2 - x(0)*x(2)
      trace = (x(2)*x(1) - x(3)*x(0))/determinant
      det = (x(2)**2 - x(3)*x(1))/determinant
      call check_close(det, 1.0_wp/(1.0_wp + omega_dt**2), 'det', relative=1.0e-8_wp)
      call check_close(trace, 2.0_wp/(1.0_wp + omega_dt**2), 'trace', absolute=1.0e-8_wp)
      radius = sqrt(det)
      phase = acos(0.5_wp*trace/radius)
      call check_close(radius, (1.0_wp + omega_dt**2)**(-0.5_wp), '|λ|', relative=1.0e-8_wp)
      call check_close(phase, atan(omega_dt), 'phase of 1 + iΩ', relative=1.0e-7_wp)
      damping = -log(radius)/hypot(phase, log(radius))
      if (omega_dt <= 0.1_wp) call check_close(damping, 0.5_wp*omega_dt, 'ζ = Ω/2', &
         relative=1.0e-2_wp)
      if (omega_dt <= 0.1_wp) call check_close(phase, omega_dt, 'phase', relative=1.0e-2_wp)
   end subroutine check_free_vibration

   !> Steady state: M ω̃ i (1 − 1/z)/Δt x = −k (x − u) − c (iω̃ x − u̇), c = kΔt/2, with
   !> z = exp(iωΔt), ω̃ = (2/Δt) tan(ωΔt/2) and the velocity of the motion as the curve
   !> differentiates its samples, u̇ = i (8 sin ωΔt − sin 2ωΔt)/(6Δt) u.
   subroutine check_harmonic_drive(step, frequency)
      real(wp), intent(in) :: step, frequency   !< s, /s
      complex(wp) :: response, expected, inertia, rate, target_rate
      real(wp) :: drive, position, dashpot, time, period
      character(len=:), allocatable :: values
      integer :: i, n, last

      call case('harmonic drive of '//number(frequency)//' /s')
      n = 1500
      ! A whole number of samples in a period, so that the sum over periods is exact.
      period = real(nint(2.0_wp*pi/(frequency*step)), wp)
      drive = 2.0_wp*pi/(period*step)
      values = ''
      do i = 0, n
         values = values//number(1.0e-3_wp*sin(drive*step*real(i, wp)))//' '
      end do
      call begin_oscillator(step, n, '0.0', &
         " &motion name = 'm' quantity = 'displacement' time_step = "//number(step)// &
         ' values = '//values//' /')
      last = n - nint(period)*(200/nint(period) + 1)
      response = 0.0_wp
      position = 0.0_wp
      do i = 1, n - 1
         call run(simulation, 1)
         time = real(i, wp)*step
         if (i < last .or. i >= last + nint(period)) cycle
         position = simulation%blocks%position(1, 1)
         response = response + position*cmplx(sin(drive*time), cos(drive*time), wp)
      end do
      response = response*2.0_wp/(period*1.0e-3_wp)
      ! x(t) = Im(H exp(iωt)) ⇒ the sum above is conj(H) turned: real part with sin, imaginary with
      ! cos.
      dashpot = 0.5_wp*stiffness*step
      rate = cmplx(0.0_wp, 2.0_wp/step*tan(0.5_wp*drive*step), wp)
      inertia = mass*rate*(1.0_wp - exp(cmplx(0.0_wp, -drive*step, wp)))/step
      target_rate = cmplx(0.0_wp, (8.0_wp*sin(drive*step) - sin(2.0_wp*drive*step))/(6.0_wp*step), &
         wp)
      expected = (stiffness + dashpot*target_rate)/(stiffness + dashpot*rate + inertia)
      call check_close([real(response), aimag(response)], [real(expected), aimag(expected)], &
         'transfer function', relative=1.0e-5_wp)
   end subroutine check_harmonic_drive

   !> Without force, velocity is f times the velocity of the last step.
   subroutine dynamic_factor()
      call begin(simulation, control_text(1.0e-2_wp, 100, 'dynamic_factor = 0.99')// &
         joint_text(0.0_wp, 0.0_wp, 0.0_wp)// &
         ' &material density = 1000.0 young_modulus = 1.0e9 poisson_ratio = 0.2 '// &
         'initial_velocity = 2.0 1.0 0.5 /'//block_text('b', rectangle(0.0_wp, 0.0_wp, 1.0_wp, &
         1.0_wp)))
      call run(simulation, 100)
      call check_close(simulation%blocks%velocity(1:3, 1), 0.99_wp**100*[2.0_wp, 1.0_wp, 0.5_wp], &
         'fⁿ v', relative=1.0e-12_wp)
      call begin(simulation, control_text(1.0e-2_wp, 100, &
         'dynamic_factor = 0.0 gravity = 0.0 -10.0')//joint_text(0.0_wp, 0.0_wp, 0.0_wp)// &
         ' &material density = 1000.0 young_modulus = 1.0e9 poisson_ratio = 0.2 /'// &
         block_text('b', rectangle(-0.5_wp, -0.5_wp, 0.5_wp, 0.5_wp)))
      call run(simulation, 100)
      call check_close(simulation%blocks%position(2, 1), -100*0.5_wp*10.0_wp*1.0e-4_wp, &
         'static: ½ g Δt² a step', relative=1.0e-12_wp)
   end subroutine dynamic_factor

   subroutine make_blocks(n)
      integer, intent(in) :: n
      type(outlines_type) :: outlines
      integer :: i

      do i = 1, n
         call add_outline(outlines, star(7, 0.5_wp, 1.5_wp), 1, 1, 1, '')
      end do
      call make_rock_blocks(outlines, blocks)
   end subroutine make_blocks

   !> d = Δt [(1 − χ) v₀ + χ v₁], a = (v₁ − v₀)/Δt, and the loss of a dynamic factor.
   subroutine check_accepted_step(chi)
      real(wp), intent(in) :: chi
      real(wp) :: d(6, 3), v(6, 3), q(6, 3), loss, start_energy
      real(wp), parameter :: time_step = 0.03_wp

      call case('an accepted step')
      call make_blocks(3)
      d = 0.01_wp*reshape(random_vector(18), [6, 3])
      v = reshape(random_vector(18), [6, 3])
      q = blocks%position
      blocks%velocity = v
      call integrate(blocks, d, step_type(scheme_type(1.0_wp, chi), 0.0_wp, time_step))
      call check_close(blocks%position, q + d, 'coordinates', relative=1.0e-15_wp)
      call check_close(blocks%velocity, (d/time_step - (1.0_wp - chi)*v)/chi, 'rates', &
         relative=1.0e-14_wp)
      call check_close(blocks%position, q + time_step*((1.0_wp - chi)*v + chi*blocks%velocity), &
         'd = Δt [(1 − χ) v₀ + χ v₁]', relative=1.0e-14_wp)
      call check_close(blocks%acceleration, (d - v*time_step)/(chi*time_step**2), 'accelerations', &
         relative=1.0e-13_wp)
      start_energy = kinetic_energy(blocks)
      call damp_velocity(blocks, 1.0_wp, loss)
      call check_close(loss, 0.0_wp, 'a factor of 1 takes nothing')
      call damp_velocity(blocks, 0.6_wp, loss)
      call check_close([loss, kinetic_energy(blocks)], [0.64_wp, 0.36_wp]*start_energy, &
         'one of 0.6 takes 1 − 0.36', relative=1.0e-14_wp)
   end subroutine check_accepted_step

   !> No vertex exceeds the bound, and a translation reaches it.
   subroutine displacement_bound()
      real(wp) :: d(6, 4), former(2, 28), bound
      integer :: i, n_wrong

      call make_blocks(4)
      n_wrong = 0
      do i = 1, 200
         blocks%position(3:6, :) = reshape(random_vector(16), [4, 4])*0.1_wp
         blocks%position(3, :) = 50.0_wp*blocks%position(3, :)
         blocks%position(4:6, :) = 1.0e-3_wp*blocks%position(4:6, :)
         call update_geometry(blocks)
         former = blocks%vertex
         d = 10.0_wp**(-modulo(i, 6))*reshape(random_vector(24), [6, 4])
         d(4:6, :) = 0.01_wp*d(4:6, :)
         bound = largest_displacement(blocks, d)
         call integrate(blocks, d, step_type(time_step=1.0_wp))
         if (maxval(norm2(blocks%vertex - former, 1)) > bound*(1.0_wp + 1.0e-3_wp)) &
            n_wrong = n_wrong + 1
      end do
      call check(n_wrong == 0, 'no vertex moves farther')
      d = 0.0_wp
      d(1:2, 3) = [0.3_wp, -0.4_wp]
      call check_close(largest_displacement(blocks, d), 0.5_wp, 'a translation', &
         relative=1.0e-15_wp)
   end subroutine displacement_bound

   !> ½ ρ ∫ |ẋ|² by quadrature.
   subroutine kinetic()
      real(wp), allocatable :: points(:,:), weights(:)
      real(wp) :: vertices(2, 7), sum, velocity(2), v(6)
      integer :: i, k

      do i = 1, 20
         vertices = star(7, 0.5_wp, 1.5_wp)
         call place_blocks(blocks, vertices)
         v = random_vector(6)
         blocks%velocity(:, 1) = v
         call fan(vertices, [0.0_wp, 0.0_wp], points, weights)
         sum = 0.0_wp
         do k = 1, size(weights)
            associate (x => points(1, k) - blocks%position(1, 1), y => points(2, k) &
               - blocks%position(2, 1))
               velocity = [v(1) - y*v(3) + x*v(4) + 0.5_wp*y*v(6), v(2) + x*v(3) + y*v(5) &
                  + 0.5_wp*x*v(6)]
            end associate
            sum = sum + 0.5_wp*2500.0_wp*weights(k)*dot_product(velocity, velocity)
         end do
         call check_close(kinetic_energy(blocks), sum, '½ ρ ∫ v²', relative=1.0e-12_wp)
      end do
   end subroutine kinetic

end module test_kinematics
