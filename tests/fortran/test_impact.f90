! SPDX-License-Identifier: GPL-3.0-or-later
!> Impacts: restitution as a property of the joint, at any stiffness and phase; energy; dashpots.
module test_impact
   use dda_kinds, only: wp, pi
   use dda_blocks, only: update_geometry
   use dda_energy, only: energy_impact, total_energy
   use dda_simulation, only: simulation_type
   use dda_time_step, only: advance
   use models, only: begin, block_text, contact_text, control_text, number, random, &
      rectangle, relative_balance, rock, run, sow
   use testing, only: check, check_close, check_no_error, error
   implicit none

   real(wp), parameter :: mass = 2500.0_wp  !< of the block of 1 m, kg per metre
   type(simulation_type) :: simulation

contains

   !> A joint with a restitution, or any other variables.
   pure function joint_of(variables) result(text)
      character(len=*), intent(in) :: variables
      character(len=:), allocatable :: text

      text = ' &joint friction_angle = 30.0 '//variables//' /'
   end function joint_of

   !> A block of 1 m falls flat on a supported one at 1 m/s, at any Ω and phase of the step.
   subroutine bounces_at_random_phases()
      real(wp), parameter :: e(4) = [0.0_wp, 0.2_wp, 0.5_wp, 0.8_wp]
      real(wp), parameter :: omega(4) = [0.05_wp, 0.7_wp, 5.0_wp, 300.0_wp]
      real(wp) :: max_error, growth, unexplained
      integer :: i, j, k

      do i = 1, size(e)
         max_error = 0.0_wp
         growth = 0.0_wp
         unexplained = 0.0_wp
         do j = 1, size(omega)
            do k = 1, 5
               call begin_drop(omega(j), random(0.0_wp, 1.0_wp), 'restitution = '//number(e(i)))
               call follow(10, growth)
               max_error = max(max_error, abs(simulation%blocks%velocity(2, 2) - e(i)))
               unexplained = max(unexplained, relative_balance(simulation%energy))
            end do
         end do
         call check(max_error < 2.0e-4_wp, 'restitution '//number(e(i))//', off by '// &
            number(max_error))
         call check(growth < 1.0e-9_wp, 'no energy comes in: '//number(growth))
         call check(unexplained < 1.0e-6_wp, 'audit: '//number(unexplained))
      end do
   end subroutine bounces_at_random_phases

   !> A contact that is pressed by up to a quarter of its way of a step is hit, a deeper one rests.
   subroutine contacts_that_have_just_touched()
      real(wp), parameter :: depth(2) = [0.24e-3_wp, 0.26e-3_wp]
      real(wp) :: growth
      integer :: i

      growth = 0.0_wp
      do i = 1, 2
         call begin_drop(0.05_wp, -2.0_wp, 'restitution = 0.5')
         simulation%blocks%position(2, 2) = simulation%blocks%position(2, 2) - depth(i)
         call update_geometry(simulation%blocks)
         call follow(3, growth)
         call check((abs(simulation%blocks%velocity(2, 2) - 0.5_wp) < 1.0e-3_wp) .eqv. i == 1, &
            number(simulation%blocks%velocity(2, 2))//' from '//number(depth(i)))
      end do
   end subroutine contacts_that_have_just_touched

   !> The block falls from a phase of a step of 1 ms; Ω is the value of its two corners.
   subroutine begin_drop(omega, phase, joint)
      real(wp), intent(in) :: omega, phase
      character(len=*), intent(in) :: joint
      real(wp), parameter :: time_step = 1.0e-3_wp
      real(wp) :: rates(6, 2)

      rates = 0.0_wp
      rates(2, 2) = -1.0_wp
      call begin(simulation, control_text(time_step, 1000, 'max_displacement_ratio = 0.05')// &
         contact_text(0.5_wp*mass*(omega/time_step)**2, '')//rock//joint_of(joint)// &
         block_text('ground', rectangle(-2.0_wp, -1.0_wp, 2.0_wp, 0.0_wp))// &
         block_text('stone', rectangle(-0.5_wp, (2.0_wp + phase)*time_step, &
         0.5_wp, 1.0_wp + (2.0_wp + phase)*time_step))// &
         ' &fixed_point x = -2.0 y = -1.0 / &fixed_point x = 2.0 y = -1.0 /'// &
         ' &fixed_point x = -2.0 y = 0.0 / &fixed_point x = 2.0 y = 0.0 /', rates)
   end subroutine begin_drop

   !> Take steps; return the largest growth of the energy in a step, relative to the initial energy.
   subroutine follow(steps, growth)
      integer, intent(in) :: steps
      real(wp), intent(inout) :: growth
      real(wp) :: former_energy, first
      integer :: i

      first = total_energy(simulation%energy)
      do i = 1, steps
         former_energy = total_energy(simulation%energy)
         call advance(simulation, error)
         if (allocated(error)) exit
         growth = max(growth, (total_energy(simulation%energy) - former_energy)/first)
      end do
      call check_no_error(error, 'all steps close')
   end subroutine follow

   !> Two free blocks: momentum is conserved, the relative velocity is multiplied by −e.
   subroutine free_blocks_of_two_masses()
      real(wp) :: rates(6, 2)

      rates = 0.0_wp
      rates(1, 1) = 1.0_wp
      call begin(simulation, control_text(1.0e-3_wp, 1000, 'max_displacement_ratio = 0.05')// &
         contact_text(1.0e8_wp, '')//rock//joint_of('restitution = 0.6')// &
         block_text('left', rectangle(-1.0023_wp, 0.0_wp, -0.0023_wp, 1.0_wp))// &
         block_text('right', rectangle(0.0_wp, -0.5_wp, 2.0_wp, 1.5_wp)), rates)
      call run(simulation, 12)
      associate (v => simulation%blocks%velocity)
         call check_close(v(1, 1) + 4.0_wp*v(1, 2), 1.0_wp, 'momentum', relative=1.0e-9_wp)
         call check_close(v(1, 2) - v(1, 1), 0.6_wp, 'relative velocity', relative=1.0e-3_wp)
         call check_close(simulation%energy%value(energy_impact), 0.5_wp*mass*0.8_wp*(1.0_wp &
            - 0.36_wp), 'half the reduced mass × (1 − e²)', relative=1.0e-3_wp)
      end associate
   end subroutine free_blocks_of_two_masses

   !> Turned blocks that fall on each other with friction: no step gains energy, all is explained.
   subroutine random_piles()
      real(wp) :: growth, unexplained, largest_loss, max_energy_ratio, first, former_energy
      integer :: pile, i

      call sow(11)
      growth = 0.0_wp
      unexplained = 0.0_wp
      largest_loss = 0.0_wp
      max_energy_ratio = 0.0_wp
      do pile = 1, 12
         call begin_pile(simulation)
         first = total_energy(simulation%energy)
         do i = 1, 60
            former_energy = total_energy(simulation%energy)
            call run(simulation, 1)
            growth = max(growth, (total_energy(simulation%energy) - former_energy)/first)
            max_energy_ratio = max(max_energy_ratio, total_energy(simulation%energy)/first)
         end do
         unexplained = max(unexplained, relative_balance(simulation%energy))
         largest_loss = max(largest_loss, simulation%energy%value(energy_impact)/mass)
      end do
      ! Dashpots store at a place ahead by half a step: what comes back is of second order in it.
      call check(growth < 1.0e-4_wp, 'steps gain next to nothing: '//number(growth))
      call check(max_energy_ratio <= 1.0_wp + 1.0e-9_wp, 'never above the first: '// &
         number(max_energy_ratio))
      call check(unexplained < 1.0e-6_wp, 'audit: '//number(unexplained))
      call check(largest_loss > 0.1_wp, 'impacts take energy')
   end subroutine random_piles

   !> Three squares above each other, each thrown down with a spin.
   subroutine begin_pile(simulation)
      type(simulation_type), intent(out) :: simulation
      real(wp) :: rates(6, 4), left_end, bottom
      character(len=:), allocatable :: text
      integer :: b

      text = control_text(1.0e-3_wp, 1000, 'max_displacement_ratio = 0.05')// &
         contact_text(10.0_wp**random(6.0_wp, 13.0_wp), '')//rock// &
         joint_of('restitution = '//number(random(0.0_wp, 1.0_wp)))// &
         block_text('ground', rectangle(-4.0_wp, -1.0_wp, 4.0_wp, 0.0_wp))// &
         ' &fixed_point x = -4.0 y = -1.0 / &fixed_point x = 4.0 y = -1.0 /'
      rates = 0.0_wp
      do b = 1, 3
         left_end = random(-0.9_wp, -0.1_wp)
         bottom = 1.01_wp*(b - 1) + 0.01_wp
         text = text//block_text('b'//achar(48 + b), &
            rectangle(left_end, bottom, left_end + 1.0_wp, bottom + 1.0_wp))
         rates(1:3, b + 1) = [random(-1.0_wp, 1.0_wp), -random(0.5_wp, 1.0_wp)*b, &
            random(-0.5_wp, 0.5_wp)]
      end do
      call begin(simulation, text, rates)
   end subroutine begin_pile

   !> Stones fall on heavy ground that shakes: an iterative solution leaves no energy unexplained.
   subroutine ground_that_moves()
      character(len=:), allocatable :: text
      real(wp) :: left_end
      integer :: b

      text = control_text(1.0e-3_wp, 400, "max_displacement_ratio = 0.05 solver = 'lagged'"// &
         " integration = 'midpoint' gravity = 0.0 -9.81")//contact_text(2.0e11_wp, '')//rock// &
         joint_of('restitution = 0.0')//" &motion name = 'm' quantity = 'velocity'"// &
         ' time_step = 0.05 values = 0.0 0.4 0.0 -0.4 0.0 0.4 0.0 -0.4 0.0 /'// &
         block_text('ground', rectangle(-50.0_wp, -10.0_wp, 50.0_wp, 0.0_wp))
      do b = -1, 1
         text = text//' &fixed_point x = '//number(49.0_wp*b)//' y = -9.0 motion_x = "m" /'
      end do
      do b = 1, 8
         left_end = 4.0_wp*b - 18.0_wp
         text = text//block_text('b'//achar(48 + b), &
            rectangle(left_end, 0.01_wp*b, left_end + 2.0_wp, 0.01_wp*b + 1.0_wp))
      end do
      call begin(simulation, text)
      call run(simulation, 400)
      call check(simulation%impacts%steps > 10, 'stones hit the ground')
      call check(relative_balance(simulation%energy) < 1.0e-7_wp, 'audit: '// &
         number(relative_balance(simulation%energy)))
   end subroutine ground_that_moves

   !> A dashpot alone: free bounce with the force clipped where it would be tensile, for Δt → 0.
   subroutine resolved_dashpot()
      real(wp), parameter :: omega = 0.01_wp
      real(wp) :: ratio, expected, growth

      ratio = 0.3_wp  ! of the critical one, for the two corners together
      growth = 0.0_wp
      call begin_drop(omega, 0.3_wp, 'damping = '//number(ratio*mass*omega/1.0e-3_wp))
      call follow(700, growth)
      ! Schwager and Pöschel (2007), with what the scheme adds, ωΔt/4
      ratio = ratio + 0.25_wp*omega
      expected = exp(-ratio/sqrt(1.0_wp - ratio**2)*(pi - atan(2.0_wp*ratio*sqrt(1.0_wp &
         - ratio**2)/(1.0_wp - 2.0_wp*ratio**2))))
      call check_close(simulation%blocks%velocity(2, 2), expected, 'restitution', &
         absolute=3.0e-3_wp)
   end subroutine resolved_dashpot

end module test_impact
