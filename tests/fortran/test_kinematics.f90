! SPDX-License-Identifier: GPL-3.0-or-later
!> A driven support and a dynamic factor against closed forms (docs/method.md); displacement bound.
module test_kinematics
   use dda_kinds, only: wp, pi
   use dda_blocks, only: blocks_type, update_geometry
   use dda_kinematics, only: largest_displacement, integrate
   use dda_scheme, only: step_type
   use dda_outlines, only: add_outline, outlines_type
   use dda_simulation, only: simulation_type
   use models, only: begin, block_text, make_rock_blocks, contact_text, control_text, joint_text, &
      number, random_vector, rectangle, run, star
   use testing, only: case, check, check_close
   implicit none

   real(wp), parameter :: mass = 1000.0_wp, stiffness = 4.0e5_wp   !< ω = 20 /s
   type(simulation_type) :: simulation
   type(blocks_type) :: blocks

contains

   subroutine oscillators()
      call check_harmonic_drive(0.05_wp, 10.0_wp)
      call check_harmonic_drive(0.01_wp, 20.0_wp)
      call check_harmonic_drive(0.02_wp, 35.0_wp)
   end subroutine oscillators

   !> One block on a moved point at its centroid: a mass on a support in x and in y.
   subroutine begin_oscillator(time_step, steps, displacements)
      real(wp), intent(in) :: time_step
      integer, intent(in) :: steps
      character(len=*), intent(in) :: displacements  !< of the point, m

      call begin(simulation, control_text(time_step, steps, '')//contact_text(stiffness, &
         'fixed_point_ratio = 1.0')//joint_text(0.0_wp, 0.0_wp, 0.0_wp)// &
         ' &material density = 1000.0 young_modulus = 1.0e9 poisson_ratio = 0.2 /'// &
         " &motion name = 'm' quantity = 'displacement' time_step = "//number(time_step)// &
         ' values = '//displacements//' /'// &
         block_text('b', rectangle(-0.5_wp, -0.5_wp, 0.5_wp, 0.5_wp))// &
         " &fixed_point x = 0.0 y = 0.0 motion_x = 'm' /")
   end subroutine begin_oscillator

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
      call begin_oscillator(step, n, values)
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

end module test_kinematics
