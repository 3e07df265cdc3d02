! SPDX-License-Identifier: GPL-3.0-or-later
!> Lowest modes: the paper's models, free vibration in time stepping, unsupported models.
module test_modes
   use dda_kinds, only: wp
   use dda_linear_model, only: linear_model_type, linearise, set_penalty
   use dda_linear_terms, only: term_shear
   use dda_modes, only: modes_type, find_modes
   use dda_simulation, only: simulation_type
   use dda_time_step, only: advance
   use dda_text, only: to_text
   use check_models, only: layered_site, layered_site_of_table_2, drum_column, brick_wall, &
      loose_blocks, hinged_bar, free_stack, linear_of
   use models, only: begin
   use testing, only: case, check, check_close, check_no_error, error
   implicit none

   type(linear_model_type) :: linear
   type(modes_type) :: modes

contains

   subroutine vibrating_models()
      call free_vibration(layered_site(), 3)
      call free_vibration(drum_column('4.0e8', ''), 2)
      call free_vibration(brick_wall(4, 6, '1.0e9', ''), 2)
      call free_vibration(drum_column('4.0e8', ", integration='midpoint'"), 2)
      call free_vibration(brick_wall(4, 6, '1.0e9', ', dynamic_factor=0.999'), 2)
   end subroutine vibrating_models

   subroutine layered_sites()
      call check_first(layered_site(), 13.961_wp, 0.002_wp)
      call check_first(layered_site_of_table_2(), 14.251_wp, 0.002_wp)
   end subroutine layered_sites

   subroutine check_first(text, frequency, tolerance)
      character(len=*), intent(in) :: text
      real(wp), intent(in) :: frequency, tolerance  !< Hz

      call linear_of(linear, text, 'closed')
      call find_modes(linear, 1, modes, error)
      call check_no_error(error, 'modes')
      call check_close(modes%frequency(1), frequency, 'first frequency', absolute=tolerance)
      call check(modes%rigid == 0 .and. modes%mechanisms == 0, 'nothing loose')
   end subroutine check_first

   !> The column of the paper's §3 as ten equal drums, at five penalties.
   subroutine column_of_ten_drums()
      character(len=5), parameter :: penalty(5) = ['1.0e8', '2.0e8', '4.0e8', '7.0e8', '1.0e9']
      real(wp), parameter :: frequency(5) = [1.63_wp, 2.30_wp, 3.25_wp, 4.30_wp, 5.14_wp]
      integer :: i

      do i = 1, 5
         call check_first(drum_column(penalty(i), ''), frequency(i), 0.01_wp*frequency(i))
      end do
   end subroutine column_of_ten_drums

   !> Over all modes the effective masses are the whole mass.
   subroutine all_masses()
      integer :: b
      real(wp) :: product

      call linear_of(linear, layered_site(), 'closed')
      call find_modes(linear, 96, modes, error)
      call check_no_error(error, 'modes')
      call check(modes%n == 96, 'as many modes as coordinates')
      call check_close(sum(modes%effective_mass, 2), [1.0_wp, 1.0_wp], 'sum of effective masses', &
         relative=1.0e-9_wp)
      call check(all(modes%omega(2:) >= modes%omega(:95)), 'ascending')
      product = 0.0_wp
      do b = 1, linear%n
         product = product + dot_product(modes%shape(:, b, 1), matmul(linear%mass(:, :, b), &
            modes%shape(:, b, 2)))
      end do
      call check_close(product, 0.0_wp, 'orthogonal', absolute=1.0e-9_wp)
      call check(modes%effective_mass(1, 1) > 0.7_wp, 'the first mode shears')
      call check(modes%effective_mass(2, 1) < 1.0e-9_wp, 'and does not bounce')
   end subroutine all_masses

   !> Start with the velocities of a mode: each shows its frequency and damping in time stepping.
   !>
   !> DDA damps an elastic spring by ζ = Ω/4, a support by Ω/2.
   subroutine free_vibration(text, count)
      character(len=*), intent(in) :: text
      integer, intent(in) :: count
      real(wp) :: omega, damping
      integer :: i

      call case('free vibration')
      call linear_of(linear, text, 'closed')
      call find_modes(linear, count, modes, error)
      call check_no_error(error, 'modes')
      do i = 1, count
         call watch(text, modes%shape(:, :, i), omega, damping)
         call check_close(omega, modes%omega(i)/(1.0_wp + modes%elongation(i))*sqrt(1.0_wp &
            + damping_term(damping)), 'frequency of mode '//to_text(i), relative=1.0e-3_wp)
         call check_close(damping, modes%damping(i), 'damping of mode '//to_text(i), &
            absolute=max(5.0e-6_wp, 1.0e-2_wp*modes%damping(i)))
      end do
   end subroutine free_vibration

   !> The undamped frequency √(φ² + ln²|λ|)/Δt belongs to a damped one φ/Δt: ω = ω_d/√(1 − ζ²).
   pure real(wp) function damping_term(damping)
      real(wp), intent(in) :: damping

      damping_term = damping**2/(1.0_wp - damping**2)
   end function damping_term

   !> Coordinate of the mode over some steps; q_{k+1} = trace q_k − determinant q_{k−1} by least
   !> squares.
   subroutine watch(text, shape, omega, damping)
      character(len=*), intent(in) :: text
      real(wp), intent(in) :: shape(:,:)
      real(wp), intent(out) :: omega, damping
      integer, parameter :: steps = 60
      real(wp), parameter :: speed = 1.0e-6_wp
      type(simulation_type) :: simulation
      real(wp) :: q(0:steps), first(6, linear%n), a(2, 2), b(2), solution(2), size_of_log
      integer :: k, block

      call begin(simulation, text, speed*shape/maxval(abs(shape)))
      first = simulation%blocks%position
      q(0) = 0.0_wp
      do k = 1, steps
         call advance(simulation, error)
         if (allocated(error)) exit
         q(k) = 0.0_wp
         do block = 1, linear%n
            q(k) = q(k) + dot_product(shape(:, block), matmul(linear%mass(:, :, block), &
               simulation%blocks%position(:, block) - first(:, block)))
         end do
      end do
      call check_no_error(error, 'steps')
      a(1, 1) = sum(q(1:steps - 1)**2)
      a(1, 2) = -sum(q(1:steps - 1)*q(0:steps - 2))
      a(2, 2) = sum(q(0:steps - 2)**2)
      b = [sum(q(2:)*q(1:steps - 1)), -sum(q(2:)*q(0:steps - 2))]
      solution = [a(2, 2)*b(1) - a(1, 2)*b(2), a(1, 1)*b(2) - a(1, 2)*b(1)]/(a(1, 1)*a(2, 2) &
         - a(1, 2)**2)
      size_of_log = hypot(acos(0.5_wp*solution(1)/sqrt(solution(2))), 0.5_wp*log(solution(2)))
      omega = size_of_log/simulation%model%control%time_step
      damping = -0.5_wp*log(solution(2))/size_of_log
   end subroutine watch

   !> Without bonds contacts are open until gravity closes them.
   subroutine contacts_that_gravity_closes()
      type(simulation_type) :: simulation
      real(wp) :: closed_frequency

      call linear_of(linear, drum_column('1.0e8', ', gravity=0.0, -9.81', is_bonded=.false.), &
         'closed')
      call find_modes(linear, 1, modes, error)
      closed_frequency = modes%frequency(1)
      call begin(simulation, drum_column('1.0e8', ', gravity=0.0, -9.81', is_bonded=.false.))
      call linearise(linear, simulation, 'present', error)
      call find_modes(linear, 3, modes, error)
      call check_no_error(error, 'present')
      call check(linear%n_closed == 20 .and. modes%rigid == 0, &
         'contacts in touch are taken to stick at first')
      call linearise(linear, simulation, 'auto', error)
      call check_no_error(error, 'settled')
      call check(linear%equilibrium%at_rest, 'at rest')
      call find_modes(linear, 3, modes, error)
      call check(linear%n_closed == 20 .and. modes%rigid == 0, 'all closed')
      call check_close(modes%frequency(1), closed_frequency, 'first frequency', relative=2.0e-3_wp)
      call check(linear%dynamic_factor == 1.0_wp .and. simulation%step == 0, 'the run is as it was')
      call check(index(modes%text, 'at rest') > 0, 'said in words')
   end subroutine contacts_that_gravity_closes

   !> Models without enough support are answered in words.
   subroutine unsupported_blocks()
      call case('blocks that do not touch')
      call linear_of(linear, loose_blocks(), 'closed')
      call find_modes(linear, 4, modes, error)
      call check_no_error(error, 'modes')
      call check(modes%rigid == 3*linear%n, 'each block is free')
      call check(modes%n == 4 .and. all(modes%omega > 1.0_wp), 'only strains have stiffness')
      call check(index(modes%text, 'no contact') > 0 .and. index(modes%text, 'rigid') > 0, &
         'said in words')
      call case('a stack on nothing')
      call linear_of(linear, free_stack(12), 'closed')
      call find_modes(linear, 4, modes, error)
      call check_no_error(error, 'modes')
      call check(modes%rigid == 3 .and. modes%mechanisms == 0 .and. modes%n == 4, &
         'moves as one body')
      call case('a bar on one fixed point')
      call linear_of(linear, hinged_bar(1.0e3_wp), 'closed')
      call find_modes(linear, 2, modes, error)
      call check_no_error(error, 'modes of a hill')
      call check(modes%rigid == 1, 'a hill swings')
      call linear_of(linear, hinged_bar(1.0_wp), 'closed')
      call find_modes(linear, 2, modes, error)
      call check_no_error(error, 'modes')
      call check(modes%rigid == 1 .and. modes%n == 2, 'it swings')
      call find_modes(linear, 50, modes, error)
      call check_no_error(error, 'more modes than there are')
      call check(modes%n == 5 .and. index(modes%text, 'only 5') > 0, 'only those there are')
      call case('joints that slide')
      call linear_of(linear, free_stack(12), 'closed')
      call slide(linear)
      call find_modes(linear, 3, modes, error)
      call check_no_error(error, 'modes')
      call check(modes%rigid == 3 .and. modes%mechanisms == 11 .and. modes%n == 3, &
         'eleven joints slide')
   end subroutine unsupported_blocks

   !> Make the shear springs void.
   subroutine slide(linear)
      type(linear_model_type), intent(inout) :: linear
      integer :: i

      do i = 1, linear%terms%n
         if (linear%terms%term(i)%kind == term_shear) linear%terms%term(i)%coefficient = 0.0_wp
      end do
      call set_penalty(linear, linear%normal_stiffness)
   end subroutine slide

end module test_modes
