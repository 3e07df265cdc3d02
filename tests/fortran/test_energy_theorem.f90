! SPDX-License-Identifier: GPL-3.0-or-later
!> With θ, χ ≥ ½ no member gains energy, also if contacts open and close: random chains of elastic
!> blocks that hit, press and separate.
!>
!> All blocks move in y, so the geometry is linear and a step ends in the state of the next one.
module test_energy_theorem
   use dda_kinds, only: wp
   use dda_abstract_solver, only: accuracy
   use dda_contact, only: contact_open
   use dda_energy, only: energy_algorithmic, energy_type, total_energy
   use dda_simulation, only: simulation_type
   use dda_time_step, only: advance
   use models, only: begin, block_text, contact_text, control_text, joint_text, number, random, &
      rectangle
   use testing, only: case, check, check_no_error, error
   implicit none

   character(len=*), parameter :: members(6) = [character(len=40) :: "integration = 'dda'", &
      "integration = 'midpoint'", "integration = 'theta' theta = 0.55", &
      "integration = 'theta' theta = 0.75", "integration = 'theta' theta = 1.0", &
      "integration = 'backward_euler'"]
   integer, parameter :: chains = 200, steps = 30
   !> of the first energy: work of the residual that a solve may leave; most chains gain below 1e-14
   real(wp), parameter :: tolerance = accuracy

contains

   subroutine every_member()
      integer :: i

      do i = 1, size(members)
         call random_chains(trim(members(i)))
      end do
   end subroutine every_member

   !> The total of a step never grows beyond rounding, and the scheme only takes.
   subroutine random_chains(member)
      character(len=*), intent(in) :: member
      type(simulation_type) :: simulation
      type(energy_type) :: former
      real(wp) :: growth, gain, scale, loss
      integer :: chain, i, closings, former_closed, closed

      call case('random chains, '//member)
      growth = 0.0_wp
      gain = 0.0_wp
      loss = 0.0_wp
      closings = 0
      do chain = 1, chains
         call begin_chain(simulation, member)
         scale = total_energy(simulation%energy)
         former_closed = 0
         do i = 1, steps
            former = simulation%energy
            call advance(simulation, error)
            if (allocated(error)) exit
            growth = max(growth, (total_energy(simulation%energy) - total_energy(former))/scale)
            gain = max(gain, (former%value(energy_algorithmic) &
               - simulation%energy%value(energy_algorithmic))/scale)
            associate (contacts => simulation%contacts(simulation%now))
               closed = count(contacts%state(:contacts%n) /= contact_open)
            end associate
            if (closed /= former_closed) closings = closings + 1
            former_closed = closed
         end do
         call check_no_error(error, 'all steps close')
         loss = loss + (scale - total_energy(simulation%energy))/scale/chains
      end do
      call check(growth <= tolerance, 'no step gains energy: '//number(growth))
      call check(gain <= tolerance, 'the scheme only takes: '//number(gain))
      call check(closings > 3*chains, 'contacts open and close')
      call check(loss > 0.01_wp .or. index(member, 'midpoint') > 0, 'and energy is lost')
   end subroutine random_chains

   !> Three to six blocks with gaps or none, of random softness and speed, at any Ω of their
   !> contacts.
   subroutine begin_chain(simulation, member)
      type(simulation_type), intent(out) :: simulation
      character(len=*), intent(in) :: member
      character(len=:), allocatable :: text
      real(wp), allocatable :: rates(:,:)
      real(wp) :: top, height, penalty, omega_dt, dt
      integer :: i, n

      n = int(random(3.0_wp, 7.0_wp))
      penalty = 1.0e8_wp
      omega_dt = 10.0_wp**random(-1.0_wp, 2.5_wp)
      dt = omega_dt/sqrt(penalty/1250.0_wp)
      text = control_text(dt, steps, member//' max_displacement_ratio = 0.05')// &
         contact_text(penalty, 'force_tolerance = 1.0e-13')//joint_text(0.0_wp, 0.0_wp, 0.0_wp)// &
         ' &material density = 2500.0 young_modulus = '// &
         number(10.0_wp**random(8.0_wp, 11.0_wp))// &
         ' poisson_ratio = 0.0 /'
      allocate (rates(6, n), source=0.0_wp)
      top = 0.0_wp
      do i = 1, n
         height = random(0.5_wp, 1.5_wp)
         text = text//block_text('b', rectangle(-0.5_wp, top, 0.5_wp, top + height))
         top = top + height + max(0.0_wp, random(-0.005_wp, 0.005_wp))
         rates(2, i) = random(-1.0_wp, 1.0_wp)*0.005_wp/dt
      end do
      call begin(simulation, text, rates)
   end subroutine begin_chain

end module test_energy_theorem
