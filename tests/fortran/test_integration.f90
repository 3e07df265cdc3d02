! SPDX-License-Identifier: GPL-3.0-or-later
!> The engine's time integration of one coordinate, against the closed forms of its members: a
!> bonded contact has the roots of (θ, χ), a closed unilateral contact those of (1, χ), a support
!> those of backward Euler, 1/(1 ± iΩ), in every member.
!>
!> Two equal, almost rigid blocks that nothing holds face each other in y; their distance is one
!> oscillator, ω² = 2k/m with the sum k of the normal springs.  A block on a fixed point at its
!> centroid is one in x.  The amplification matrix is measured column by column, from steps that
!> begin with a displacement alone and with a velocity alone.
module test_integration
   use dda_kinds, only: wp
   use dda_blocks, only: update_geometry
   use dda_contact, only: contact_open
   use dda_energy, only: energy_fracture
   use dda_scheme, only: scheme_type, scheme_named
   use dda_scheme_response, only: amplification_roots, free_damping, oscillates, period_elongation
   use dda_simulation, only: simulation_type
   use eigenvalues, only: roots_of, distance_of
   use models, only: begin, block_text, contact_text, control_text, joint_text, number, rectangle, &
      relative_balance, run
   use testing, only: case, check, check_close
   implicit none

   integer, parameter :: on_bond = 1, on_contact = 2, on_support = 3
   character(len=14), parameter :: names(5) = [character(len=14) :: 'dda', 'midpoint', 'theta', &
      'theta', 'backward_euler']
   real(wp), parameter :: thetas(5) = [0.75_wp, 0.75_wp, 0.75_wp, 0.55_wp, 0.75_wp]
   real(wp), parameter :: resolutions(10) = [0.05_wp, 0.2_wp, 0.7_wp, 2.0_wp, 3.9_wp, 5.0_wp, &
      20.0_wp, 1.0e2_wp, 1.0e3_wp, 1.0e4_wp]
   real(wp), parameter :: mass = 2500.0_wp, penalty = 1.0e6_wp, depth = 1.0e-3_wp, &
      size_of_x = 0.3_wp*depth
   real(wp), parameter :: tolerance = 1.0e-6_wp
   type(simulation_type) :: simulation

contains

   subroutine every_member()
      integer :: i, j

      do i = 1, size(names)
         do j = 1, size(resolutions)
            call roots_on(on_bond, i, resolutions(j))
            call roots_on(on_contact, i, resolutions(j))
            call roots_on(on_support, i, resolutions(j))
         end do
         call breaking_bond(i)
      end do
   end subroutine every_member

   !> Member i: its variables in &control.
   pure function member_text(i) result(text)
      integer, intent(in) :: i
      character(len=:), allocatable :: text

      text = " integration = '"//trim(names(i))//"' max_displacement_ratio = 0.1 "
      if (names(i) == 'theta') text = text//'theta = '//number(thetas(i))
   end function member_text

   !> Start a model of one oscillator; `push` presses the two blocks together, N/m.
   subroutine begin_on(kind, member, dt, push)
      integer, intent(in) :: kind, member
      real(wp), intent(in) :: dt, push
      character(len=*), parameter :: stiff = &
         ' &material density = 2500.0 young_modulus = 1.0e14 poisson_ratio = 0.25 /'
      character(len=:), allocatable :: text

      text = control_text(dt, 100, member_text(member))//stiff
      select case (kind)
      case (on_support)
         text = text//contact_text(penalty, 'fixed_point_ratio = 1.0')//joint_text(0.0_wp, 0.0_wp, &
            0.0_wp)//block_text('b', rectangle(-0.5_wp, -0.5_wp, 0.5_wp, 0.5_wp))// &
            ' &fixed_point x = 0.0 y = 0.0 /'
      case default
         text = text//contact_text(penalty, 'force_tolerance = 1.0e-14')
         if (kind == on_bond) text = text//joint_text(30.0_wp, 1.0e9_wp, 1.0e9_wp)
         if (kind == on_contact) text = text//joint_text(0.0_wp, 0.0_wp, 0.0_wp)
         text = text//block_text('low', rectangle(-0.5_wp, -1.0_wp, 0.5_wp, 0.0_wp))// &
            block_text('high', rectangle(-0.5_wp, 0.0_wp, 0.5_wp, 1.0_wp))
         if (kind == on_contact) text = text//' &load x = 0.0 y = -0.5 time = 0.0 1.0e9 '// &
            'force_y = 2*'//number(push)//' / &load x = 0.0 y = 0.5 time = 0.0 1.0e9 '// &
            'force_y = 2*'//number(-push)//' /'
      end select
      call begin(simulation, text)
   end subroutine begin_on

   !> Sum of the springs that act on the coordinate, N/m.
   real(wp) function spring_of(kind) result(stiffness)
      integer, intent(in) :: kind

      stiffness = penalty
      if (kind == on_support) return
      call begin_on(kind, 1, 1.0e-3_wp, penalty)
      if (kind == on_contact) call run(simulation, 1)
      associate (contacts => simulation%contacts(simulation%now))
         stiffness = penalty*count(contacts%state(:contacts%n) /= contact_open)
      end associate
   end function spring_of

   !> Start with a displacement from rest and a velocity of the coordinate; a unilateral contact is
   !> at rest if its spring balances the push.
   subroutine begin_from(kind, member, dt, push, x, v)
      integer, intent(in) :: kind, member
      real(wp), intent(in) :: dt, push
      real(wp), intent(in) :: x, v  !< m, m/s

      call begin_on(kind, member, dt, push)
      associate (blocks => simulation%blocks)
         if (kind == on_support) then
            blocks%position(1, 1) = blocks%position(1, 1) + x
            blocks%velocity(1, 1) = v
         else
            blocks%position(2, :) = blocks%position(2, :) &
               + 0.5_wp*(x - merge(depth, 0.0_wp, kind == on_contact))*[-1, 1]
            blocks%velocity(2, :) = 0.5_wp*v*[-1, 1]
         end if
         call update_geometry(blocks)
      end associate
   end subroutine begin_from

   !> The coordinate and its velocity, m, m/s.
   pure function state_of(kind) result(state)
      integer, intent(in) :: kind
      real(wp) :: state(2)

      associate (q => simulation%blocks%position, v => simulation%blocks%velocity)
         state = [q(1, 1), v(1, 1)]
         if (kind /= on_support) state = [q(2, 2) - q(2, 1), v(2, 2) - v(2, 1)]
      end associate
   end function state_of

   !> The state after one step.
   function step_from(kind, member, dt, push, x, v) result(state)
      integer, intent(in) :: kind, member
      real(wp), intent(in) :: dt, push, x, v
      real(wp) :: state(2)

      call begin_from(kind, member, dt, push, x, v)
      call run(simulation, 1)
      state = state_of(kind)
   end function step_from

   !> Roots, damping ratio and period, and a sequence of displacements that obeys their recursion.
   subroutine roots_on(kind, member, omega_dt)
      integer, intent(in) :: kind, member
      real(wp), intent(in) :: omega_dt  !< Ω = ωΔt
      character(len=*), parameter :: kind_names(3) = [character(len=10) :: 'a bond', 'a contact', &
         'a support']
      type(scheme_type) :: scheme
      complex(wp) :: roots(2), expected(2)
      real(wp) :: matrix(2, 2), equilibrium(2), omega, dt, spring, size_of_v

      call case(trim(names(member))//' on '//trim(kind_names(kind))//' at Ω = '//number(omega_dt))
      scheme = scheme_named(names(member), thetas(member))
      if (kind == on_contact) scheme%theta = 1.0_wp
      if (kind == on_support) scheme = scheme_type(1.0_wp, 1.0_wp)
      spring = spring_of(kind)
      omega = sqrt(spring*merge(1.0_wp, 2.0_wp, kind == on_support)/mass)
      dt = omega_dt/omega
      size_of_v = size_of_x/max(dt, 1.0_wp/omega)
      equilibrium = step_from(kind, member, dt, depth*spring, 0.0_wp, 0.0_wp)
      matrix(:, 1) = (step_from(kind, member, dt, depth*spring, size_of_x, 0.0_wp) - equilibrium) &
         *[1.0_wp, 1.0_wp/omega]/size_of_x
      matrix(:, 2) = (step_from(kind, member, dt, depth*spring, 0.0_wp, size_of_v) - equilibrium) &
         *[omega, 1.0_wp]/size_of_v
      roots = roots_of(matrix)
      expected = amplification_roots(scheme, omega, dt)
      if (kind == on_support) then
         expected = 1.0_wp/cmplx(1.0_wp, omega_dt*[1.0_wp, -1.0_wp], wp)
         if (omega_dt >= 1.0e4_wp) call check(maxval(abs(roots)) < 1.01e-4_wp, 'nothing is left')
      end if
      call check_close(distance_of(roots, expected), 0.0_wp, 'roots', absolute=tolerance)
      call check_damping(scheme, roots, omega, dt)
      ! The normal of a compressed contact rotates with its edge after each step.  At larger Ω this
      ! explicit term amplifies the rounding of rotations by depth·Ω² per step.
      if (kind /= on_contact .or. omega_dt <= 100.0_wp) &
         call check_sequence(kind, member, dt, depth*spring, size_of_v, expected)
   end subroutine roots_on

   !> Damping ratio and period of measured roots.
   subroutine check_damping(scheme, roots, omega, dt)
      type(scheme_type), intent(in) :: scheme
      complex(wp), intent(in) :: roots(2)
      real(wp), intent(in) :: omega, dt
      real(wp) :: angle, decay

      if (.not. oscillates(scheme, omega, dt)) then
         call check(all(abs(aimag(roots)) <= tolerance), 'it does not oscillate')
         return
      end if
      angle = abs(atan2(aimag(roots(1)), real(roots(1))))
      decay = -log(abs(roots(1)))
      call check_close(decay/hypot(angle, decay), free_damping(scheme, omega, dt), 'ζ', &
         absolute=tolerance)
      call check_close(omega*dt/angle/(1.0_wp + period_elongation(scheme, omega, dt)), 1.0_wp, &
         'period', absolute=tolerance)
   end subroutine check_damping

   !> x₂ = (λ₁ + λ₂) x₁ − λ₁λ₂ x₀ for the displacements of the steps of a run.
   subroutine check_sequence(kind, member, dt, push, speed, roots)
      integer, intent(in) :: kind, member
      real(wp), intent(in) :: dt, push, speed
      complex(wp), intent(in) :: roots(2)
      integer, parameter :: steps = 8
      real(wp) :: x(0:steps), increments(steps), state(2)
      real(wp), allocatable :: deviation(:)
      integer :: i, last

      call begin_from(kind, member, dt, push, size_of_x, speed)
      do i = 0, steps
         if (i > 0) call run(simulation, 1)
         state = state_of(kind)
         x(i) = state(1)
         if (i < 2) cycle
         ! What has come to rest shows rounding only.
         if (abs(x(i) - x(i - 1)) < 1.0e-9_wp*maxval(abs(x(1:i) - x(0)))) exit
      end do
      last = min(i, steps)
      ! Increments, as the place of rest is known except for the compression of the blocks.
      increments(:last) = x(1:last) - x(:last - 1)
      deviation = increments(3:last) - real(roots(1) + roots(2))*increments(2:last - 1) &
         + real(roots(1)*roots(2))*increments(:last - 2)
      call check_close(deviation, 0.0_wp*deviation, 'displacements', &
         absolute=tolerance*maxval(abs(increments(:last))))
   end subroutine check_sequence

   !> Two bonded blocks separate: in the repeated step in which the bond breaks, the contact is open
   !> without force; closed contacts continue with the force of the end of the step.
   subroutine breaking_bond(member)
      integer, intent(in) :: member
      real(wp) :: rates(6, 2)
      integer :: i

      call case('a bond that breaks, '//trim(names(member)))
      rates = 0.0_wp
      rates(2, :) = [-0.5_wp, 0.5_wp]
      call begin_bonded()
      do i = 1, 50
         rates = simulation%blocks%velocity
         call run(simulation, 1)
         if (simulation%counters%broken > 0) exit
      end do
      call check(simulation%counters%broken == 2, 'both contacts break')
      call check_close(simulation%blocks%velocity(2, :), rates(2, :), 'no force in this step', &
         relative=1.0e-9_wp)
      call check(simulation%energy%value(energy_fracture) >= 0.0_wp, 'fracture takes energy')
      call check(relative_balance(simulation%energy) < 1.0e-9_wp, 'the budget closes')
      call case('a bond that breaks in shear, '//trim(names(member)))
      rates(1, :) = [-1.0_wp, 1.0_wp]
      rates(2, :) = [0.1_wp, -0.1_wp]
      rates(3:, :) = 0.0_wp
      call begin_bonded()
      do i = 1, 50
         call run(simulation, 1)
         if (simulation%counters%broken > 0) exit
      end do
      call check(simulation%counters%broken > 0, 'contacts break')
      associate (contacts => simulation%contacts(simulation%now))
         do i = 1, contacts%n
            if (contacts%bonded(i)) cycle
            call check_close(contacts%normal_force(i), -penalty*min(0.0_wp, contacts%new_gap(i)), &
               'normal force of the end of the step', relative=1.0e-7_wp, absolute=1.0e-6_wp)
            call check(abs(contacts%shear_force(i)) <= tan(0.5_wp)*contacts%normal_force(i) &
               *(1.0_wp + 1.0e-7_wp), 'shear force within friction')
         end do
      end associate
      call check(relative_balance(simulation%energy) < 1.0e-6_wp, 'the budget closes')

   contains

      subroutine begin_bonded()
         call begin(simulation, control_text(1.0e-2_wp, 100, member_text(member))// &
            ' &material density = 2500.0 young_modulus = 1.0e15 poisson_ratio = 0.25 /'// &
            contact_text(penalty, '')//joint_text(28.64788975654116_wp, 2.0e4_wp, 2.0e4_wp)// &
            block_text('low', rectangle(-0.5_wp, -1.0_wp, 0.5_wp, 0.0_wp))// &
            block_text('high', rectangle(-0.5_wp, 0.0_wp, 0.5_wp, 1.0_wp)), rates)
      end subroutine begin_bonded
   end subroutine breaking_bond

end module test_integration
