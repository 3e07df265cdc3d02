! SPDX-License-Identifier: GPL-3.0-or-later
!> Elements: the energy of supports and of faces between materials, first velocities, and a kind of
!> elements that only this tester knows, from the pattern of K̂ to the transfer function.
module test_elements
   use dda_kinds, only: wp, pi
   use bolts, only: bolt_type, put_bolts
   use dda_block_matrix, only: entry_of
   use dda_blocks, only: update_geometry
   use dda_elements, only: match_velocities, update_stored
   use dda_energy, only: energy_residual, energy_type, energy_damping, energy_input, &
      energy_kinetic, total_energy, turnover
   use dda_energy_budget, only: start_energy_budget
   use dda_kinematics, only: kinetic_energy
   use dda_linear_model, only: linear_model_type, linearise
   use dda_linear_terms, only: add_term, at_end, at_theta, linear_term_type, mean_dashpot
   use dda_material, only: elasticity, material_type
   use dda_modes, only: find_modes, modes_type
   use dda_scheme, only: scheme_type
   use dda_scheme_response, only: amplification_roots, steady_type, steady_weights
   use dda_simulation, only: next_step, simulation_type
   use dda_transfer, only: prepare_transfer, transfer_at, transfer_type
   use dda_weld, only: weld_type
   use dda_weld_springs, only: jump_stiffness, n_deformations, springs_of, strains_of
   use eigenvalues, only: distance_of, roots_of
   use models, only: begin, block_text, contact_text, control_text, joint_text, number, random, &
      random_vector, rectangle, rock, run
   use testing, only: case, check, check_close, check_no_error, error
   implicit none

   character(len=*), parameter :: members(5) = [character(len=40) :: "integration = 'dda'", &
      "integration = 'midpoint'", "integration = 'theta'", "integration = 'theta' theta = 0.55", &
      "integration = 'backward_euler'"]
   real(wp), parameter :: chi(5) = [0.5_wp, 0.5_wp, 0.75_wp, 0.55_wp, 1.0_wp]
   real(wp), parameter :: theta(5) = [1.0_wp, 0.5_wp, 0.75_wp, 0.55_wp, 1.0_wp]
   real(wp), parameter :: mass = 2500.0_wp
   type(simulation_type) :: simulation
   type(linear_model_type) :: linear

contains

   subroutine every_member()
      integer :: i

      do i = 1, size(members)
         call supports_at_rest(members(i))
         call moved_supports(members(i))
         call first_velocities(members(i), chi(i))
         call static_stretch(members(i))
         call bolted_pair(i, 0.0_wp)
         call bolted_pair(i, 4.0e3_wp)
         call bolts_and_contacts(members(i))
         call bolted_transfer(i)
         call dashpot_to_ground(i)
      end do
   end subroutine every_member

   !> One block of 1 m × 1 m on supports of stiffness `stiffness` at given positions.
   subroutine begin_supported(member, stiffness, positions, groups, rates)
      character(len=*), intent(in) :: member   !< in &control
      real(wp), intent(in) :: stiffness        !< N/m
      real(wp), intent(in) :: positions(:,:)      !< [2,points] m
      character(len=*), intent(in) :: groups     !< in each &fixed_point and before them
      real(wp), intent(in), optional :: rates(:,:)
      character(len=:), allocatable :: text
      integer :: i

      text = ''
      do i = 1, size(positions, 2)
         text = text//' &fixed_point x = '//number(positions(1, i))//' y = '// &
            number(positions(2, i))
         if (groups /= '') text = text//" motion_x = 'm' motion_y = 'm'"
         text = text//' /'
      end do
      call begin(simulation, control_text(1.0e-3_wp, 100, trim(member)// &
         ' max_displacement_ratio = 0.1')//contact_text(stiffness, 'fixed_point_ratio = 1.0')// &
         joint_text(0.0_wp, 0.0_wp, 0.0_wp)//rock//groups//block_text('b', rectangle(-0.5_wp, &
         -0.5_wp, 0.5_wp, 0.5_wp))//text, rates)
   end subroutine begin_supported

   !> From any position and velocity, at any Ω, the energy never grows and the budget closes.
   subroutine supports_at_rest(member)
      character(len=*), intent(in) :: member
      real(wp), parameter :: centroid(2, 1) = 0.0_wp
      type(energy_type) :: former
      real(wp) :: growth, max_error, omega_dt
      integer :: i, k

      call case('supports at rest, '//trim(member))
      growth = 0.0_wp
      max_error = 0.0_wp
      do i = 1, 20
         omega_dt = 10.0_wp**random(-1.0_wp, 4.0_wp)
         call begin_supported(member, mass*omega_dt**2/1.0e-3_wp**2, centroid, '')
         associate (blocks => simulation%blocks, energy => simulation%energy)
            blocks%position(1:2, 1) = 1.0e-3_wp*random_vector(2)
            blocks%velocity(1:2, 1) = min(omega_dt, 10.0_wp)*random_vector(2)
            call update_geometry(blocks)
            call start_energy_budget(energy, blocks, simulation%contacts(simulation%now), &
               simulation%laws, simulation%elements, next_step(simulation))
            do k = 1, 20
               former = energy
               call run(simulation, 1)
               growth = max(growth, (total_energy(energy) - total_energy(former)) &
                  /total_energy(former))
               max_error = max(max_error, abs(energy_residual(energy))/turnover(energy))
            end do
         end associate
      end do
      call check(growth <= 1.0e-14_wp, 'it never grows: '//number(growth))
      call check(max_error <= 1.0e-12_wp, 'the budget closes: '//number(max_error))
   end subroutine supports_at_rest

   !> Input, stored energy and losses of supports that move close.
   subroutine moved_supports(member)
      character(len=*), intent(in) :: member
      character(len=:), allocatable :: motion
      real(wp) :: max_error, u
      integer :: i, k

      call case('moved supports, '//trim(member))
      max_error = 0.0_wp
      do i = 1, 6
         motion = " &motion name = 'm' quantity = 'displacement' time_step = 7.0e-3 values = 0.0"
         u = 0.0_wp
         do k = 1, 8
            u = u + random(-1.0e-3_wp, 1.0e-3_wp)
            motion = motion//' '//number(u)
         end do
         call begin_supported(member, 10.0_wp**(4 + i), reshape([0.0_wp, 0.0_wp], &
            [2, 1]), motion//' /')
         do k = 1, 60
            call run(simulation, 1)
            max_error = max(max_error, abs(energy_residual(simulation%energy)) &
            /turnover(simulation%energy))
         end do
         call check(abs(simulation%energy%value(energy_input)) > 0.0_wp, 'it works')
      end do
      call check(max_error <= 1.0e-10_wp, 'the budget closes: '//number(max_error))
   end subroutine moved_supports

   !> A support takes a first velocity as a plastic impact on a mass W = (1 − χ)² k Δt² does:
   !> v' = M v/(M + W) at the centroid; more supports never add energy.
   subroutine first_velocities(member, chi)
      character(len=*), intent(in) :: member
      real(wp), intent(in) :: chi
      real(wp), parameter :: stiffness(4) = [1.0e-3_wp, 1.0e6_wp, 1.0e9_wp, 1.0e16_wp]
      type(energy_type) :: energy
      real(wp) :: rates(6, 1), end_rate(6), weight, start_energy
      integer :: i

      call case('first velocities, '//trim(member))
      do i = 1, size(stiffness)
         rates(:, 1) = random_vector(6)
         call begin_supported(member, stiffness(i), reshape([0.0_wp, 0.0_wp], [2, 1]), '', rates)
         weight = (1.0_wp - chi)**2*stiffness(i)*1.0e-3_wp**2
         end_rate = rates(:, 1)
         end_rate(1:2) = mass/(mass + weight)*end_rate(1:2)
         call check_close(simulation%blocks%velocity(:, 1), end_rate, 'plastic impact', &
            relative=1.0e-12_wp)
         call begin_supported(member, stiffness(i), reshape([-0.4_wp, -0.3_wp, 0.4_wp, &
            -0.2_wp, 0.1_wp, 0.45_wp], [2, 3]), '')
         simulation%blocks%velocity = rates
         start_energy = kinetic_energy(simulation%blocks)
         call match_velocities(simulation%elements, simulation%blocks, next_step(simulation))
         call update_stored(simulation%elements, simulation%blocks, next_step(simulation), energy)
         energy%value(energy_kinetic) = kinetic_energy(simulation%blocks)
         call check(total_energy(energy) <= start_energy*(1.0_wp + 1.0e-13_wp), &
            'no energy is gained')
         if (i == 1 .or. chi == 1.0_wp) call check_close(simulation%blocks%velocity, rates, &
            'a soft support leaves it alone', relative=1.0e-9_wp)
         if (i == 4 .and. chi < 0.9_wp) call check(total_energy(energy) < 0.9_wp*start_energy, &
            'a stiff one does not')
      end do
   end subroutine first_velocities

   !> Two blocks 1 m apart in x.
   subroutine begin_pair(member, dt, groups)
      character(len=*), intent(in) :: member, groups
      real(wp), intent(in) :: dt

      call begin(simulation, control_text(dt, 1000, trim(member)// &
         ' max_displacement_ratio = 0.1')//contact_text(1.0e9_wp, '')// &
         joint_text(20.0_wp, 0.0_wp, 0.0_wp)//rock// &
         block_text('a', rectangle(0.0_wp, 0.0_wp, 1.0_wp, 1.0_wp))// &
         block_text('b', rectangle(2.0_wp, 0.0_wp, 3.0_wp, 1.0_wp))//groups)
   end subroutine begin_pair

   !> A load on a bolt stretches it by F/k.
   subroutine static_stretch(member)
      character(len=*), intent(in) :: member
      type(bolt_type) :: bolt
      real(wp), parameter :: force = 1.0e4_wp
      real(wp) :: first
      integer :: entry

      call case('static stretch, '//trim(member))
      if (index(member, 'dda') + index(member, 'backward') == 0) return  ! no static steps
      call begin_pair(trim(member)//' dynamic_factor = 0.0', 10.0_wp, &
         ' &fixed_point x = 0.1 y = 0.1 / &fixed_point x = 0.1 y = 0.9 / &load x = 2.5 y = 0.5'// &
         ' time = 0.0 1.0e9 force_x = 2*'//number(force)//' /')
      bolt%reference(:, 1) = [0.4_wp, 0.0_wp]
      bolt%reference(:, 2) = [-0.4_wp, 0.0_wp]
      bolt%stiffness = 1.0e8_wp
      call put_bolts(simulation, [bolt])
      first = end_distance()
      call run(simulation, 40)
      call check_close(end_distance() - first, force/bolt%stiffness, 'F/k', relative=1.0e-9_wp)
      entry = entry_of(simulation%system%matrix, 1, 2)
      call check(entry > 0, 'K̂ couples blocks that do not touch')
      if (entry > 0) call check_close(simulation%system%matrix%lower(1, 1, entry), &
         -bolt%stiffness, 'by its stiffness', relative=1.0e-4_wp)

   contains

      !> From the end in block 1 to the one in block 2, m.
      real(wp) function end_distance()
         associate (q => simulation%blocks%position)
            end_distance = q(1, 2) - 0.4_wp*(1.0_wp + q(4, 2)) - q(1, 1) - 0.4_wp*(1.0_wp + q(4, 1))
         end associate
      end function end_distance
   end subroutine static_stretch

   !> Two free blocks on a bolt between their centroids are one oscillator: its amplification matrix
   !> against the roots of the scheme, with the dashpot against the recursion written down again.
   subroutine bolted_pair(member, viscosity)
      integer, intent(in) :: member
      real(wp), intent(in) :: viscosity  !< N s/m
      real(wp), parameter :: turns(5) = [0.05_wp, 0.5_wp, 3.0_wp, 50.0_wp, 1.0e3_wp]
      real(wp), parameter :: dt = 1.0e-2_wp
      type(bolt_type) :: bolt
      real(wp) :: matrix(2, 2), expected(2, 2), x, v, d, drag, expected_velocity
      integer :: i, column, entry

      call case('two blocks on a bolt, '//trim(members(member)))
      do i = 1, size(turns)
         bolt%viscosity = viscosity
         bolt%stiffness = 0.5_wp*mass*(turns(i)/dt)**2
         drag = 2.0_wp*viscosity*dt/mass
         do column = 1, 2
            call begin_pair(members(member), dt, '')
            call put_bolts(simulation, [bolt])
            x = merge(1.0e-3_wp/max(1.0_wp, turns(i)), 0.0_wp, column == 1)
            v = merge(1.0e-3_wp, 0.0_wp, column == 2)
            simulation%blocks%position(1, :) = simulation%blocks%position(1, :) + 0.5_wp*x*[1, -1]
            simulation%blocks%velocity(1, :) = 0.5_wp*v/dt*[1, -1]
            call update_geometry(simulation%blocks)
            call run(simulation, 1)
            associate (q => simulation%blocks%position)
               matrix(:, column) = [turns(i)*(q(1, 1) - q(1, 2) + 2.0_wp), &
                  dt*(simulation%blocks%velocity(1, 1) - simulation%blocks%velocity(1, 2))] &
                  /merge(turns(i)*x, v, column == 1)
            end associate
            associate (theta => theta(member), chi => chi(member), square => turns(i)**2)
               x = merge(1.0_wp/turns(i), 0.0_wp, column == 1)
               v = merge(1.0_wp, 0.0_wp, column == 2)
               expected_velocity = (v - square*(x + theta*(1.0_wp - chi)*v) - drag*(1.0_wp - &
                  chi)*v) /(1.0_wp + theta*chi*square + drag*chi)
               d = (1.0_wp - chi)*v + chi*expected_velocity
               expected(:, column) = [turns(i)*(x + d), expected_velocity]
            end associate
         end do
         call check_close(distance_of(roots_of(matrix), roots_of(expected)), 0.0_wp, 'roots', &
            absolute=1.0e-7_wp)
         if (viscosity == 0.0_wp) call check_close(distance_of(roots_of(matrix), &
            amplification_roots(scheme_type(theta(member), chi(member)), turns(i), 1.0_wp)), &
            0.0_wp, 'roots of the scheme', absolute=1.0e-7_wp)
         entry = entry_of(simulation%system%matrix, 1, 2)
         call check_close(simulation%system%matrix%lower(1, 1, entry), &
            -theta(member)*bolt%stiffness - viscosity/dt, 'coupling', relative=1.0e-12_wp)
      end do
   end subroutine bolted_pair

   !> Six blocks fall on a floor and on each other, tied by bolts that skip a block: states change,
   !> the line search works, and the budget closes.
   subroutine bolts_and_contacts(member)
      character(len=*), intent(in) :: member
      real(wp) :: max_error
      integer :: i

      call case('bolts and contacts, '//trim(member))
      call begin_heap(trim(member))
      max_error = 0.0_wp
      do i = 1, 150
         call run(simulation, 1)
         max_error = max(max_error, abs(energy_residual(simulation%energy)) &
            /turnover(simulation%energy))
      end do
      call check(max_error <= 1.0e-8_wp, 'the budget closes: '//number(max_error))
      call check(simulation%counters%most_iterations > 3, 'states change')
      call check(simulation%energy%value(energy_damping) > 0.0_wp, 'dashpots take energy')
   end subroutine bolts_and_contacts

   !> Blocks above a floor, each bolted to the next but one.
   subroutine begin_heap(control)
      character(len=*), intent(in) :: control
      type(bolt_type) :: bolt(5)
      character(len=:), allocatable :: text
      real(wp) :: rates(6, 7)
      real(wp) :: left_end
      integer :: i

      text = control_text(2.0e-3_wp, 1000, 'gravity = 0.0 -9.81 max_displacement_ratio = 0.02 '// &
         control)//contact_text(1.0e9_wp, '')//joint_text(30.0_wp, 0.0_wp, 0.0_wp)//rock// &
         block_text('floor', rectangle(-3.0_wp, -1.0_wp, 3.0_wp, 0.0_wp))// &
         ' &fixed_point x = -2.0 y = -0.5 / &fixed_point x = 2.0 y = -0.5 /'
      do i = 1, 6
         left_end = -0.5_wp + 0.1_wp*modulo(i, 3)
         text = text//block_text('b', rectangle(left_end, 0.51_wp*i - 0.505_wp, left_end + 1.0_wp, &
            0.51_wp*i - 0.005_wp))
      end do
      rates = 0.0_wp
      rates(2, 2:) = -1.0_wp
      call begin(simulation, text, rates)
      do i = 1, size(bolt)
         bolt(i) = bolt_type([i, i + 2], reshape([0.2_wp, 0.1_wp, -0.3_wp, 0.0_wp], [2, 2]), &
            [0.6_wp, 0.8_wp], 1.0e7_wp*i, 2.0e4_wp, 0.0_wp, merge(at_end, at_theta, i == 3))
      end do
      call put_bolts(simulation, bolt)
   end subroutine begin_heap

   !> The lowest mode with stiffness of two free blocks on a bolt.
   subroutine modes_of_two_blocks_on_a_bolt()
      type(modes_type) :: modes
      type(bolt_type) :: bolt

      call begin_pair('', 1.0e-3_wp, '')
      bolt%stiffness = 1.0e6_wp
      bolt%viscosity = 1.0e3_wp
      call put_bolts(simulation, [bolt])
      call linearise(linear, simulation, 'closed', error)
      call check_no_error(error, 'linearise')
      call find_modes(linear, 1, modes, error)
      call check_no_error(error, 'modes')
      call check_close(modes%omega(1), sqrt(2.0_wp*bolt%stiffness/mass), 'ω = √(2k/m)', &
         relative=1.0e-9_wp)
      call check(modes%rigid + modes%mechanisms == 5, 'all other rigid motions are free')
      call check_close(modes%damping(1) - modes%of_scheme(1), bolt%viscosity &
         /(mass*modes%omega(1)), 'damping ratio c/(mω) by the dashpot', relative=1.0e-9_wp)
   end subroutine modes_of_two_blocks_on_a_bolt

   !> A block on a bolt to one that supports move: H = (k + w_c c)/(k + w_c c + w_m m), with the
   !> spring at the end of the step w_e k instead of k.  A bolt is no support.
   subroutine bolted_transfer(member)
      integer, intent(in) :: member
      real(wp), parameter :: dt = 4.0e-3_wp
      type(transfer_type) :: transfer
      type(steady_type) :: weights
      type(bolt_type) :: bolt
      complex(wp) :: numerator, expected
      real(wp) :: frequency
      integer :: i, instant

      call case('transfer function over a bolt, '//trim(members(member)))
      do instant = at_theta, at_end
         call begin_pair(members(member), dt, ' &fixed_point x = 0.1 y = 0.1 /'// &
            ' &fixed_point x = 0.1 y = 0.9 / &fixed_point x = 0.9 y = 0.1 /'// &
            " &fixed_point x = 2.5 y = 0.0 direction = 'y' /"// &
            " &fixed_point x = 2.5 y = 1.0 direction = 'y' /"// &
            " &measured_point name = 'a' x = 0.5 y = 0.5 /"// &
            " &measured_point name = 'b' x = 2.5 y = 0.5 /")
         bolt = bolt_type(block=[2, 1], stiffness=4.0e7_wp, viscosity=5.0e4_wp, instant=instant)
         call put_bolts(simulation, [bolt])
         call linearise(linear, simulation, 'closed', error)
         call prepare_transfer(transfer, linear, [2, 1], [1, 1], 1, 60.0_wp, error)
         call check_no_error(error, 'transfer')
         if (allocated(error)) return
         call check(index(transfer%text, 'all fixed points move together') == 1, &
            'only fixed points are supports')
         do i = 1, 12
            frequency = 5.0_wp*i
            weights = steady_weights(linear%scheme, 2*pi*frequency, dt, 1.0_wp)
            numerator = bolt%stiffness*merge((1.0_wp, 0.0_wp), weights%end_stiffness, &
               instant == at_theta) + bolt%viscosity*weights%mean_dashpot
            expected = numerator/(numerator + mass*weights%inertia)
            call check_close(abs(transfer_at(transfer, frequency) - expected), 0.0_wp, 'H', &
               absolute=1.0e-8_wp*abs(expected))
         end do
      end do
   end subroutine bolted_transfer

   !> A free block on a dashpot to a ground that moves: H = w_c c/(w_c c + w_m m).
   subroutine dashpot_to_ground(member)
      integer, intent(in) :: member
      real(wp), parameter :: dt = 4.0e-3_wp, viscosity = 5.0e4_wp
      type(transfer_type) :: transfer
      type(steady_type) :: weights
      type(linear_term_type) :: term
      integer :: i

      call case('a block on a dashpot alone, '//trim(members(member)))
      call begin_pair(members(member), dt, " &measured_point name = 'a' x = 0.5 y = 0.5 /")
      call linearise(linear, simulation, 'closed', error)
      term%block_a = 1
      term%instant = mean_dashpot
      term%row_a(1) = 1.0_wp
      term%coefficient = viscosity
      linear%terms%n = 0
      call add_term(linear%terms, term)
      call prepare_transfer(transfer, linear, [1, 0], [1, 1], 1, 60.0_wp, error)
      call check_no_error(error, 'transfer')
      if (allocated(error)) return
      do i = 1, 12
         weights = steady_weights(linear%scheme, 2*pi*5.0_wp*i, dt, 1.0_wp)
         associate (numerator => viscosity*weights%mean_dashpot)
            call check_close(abs(transfer_at(transfer, 5.0_wp*i) - numerator/(numerator &
               + mass*weights%inertia)), 0.0_wp, 'H', absolute=1.0e-8_wp)
         end associate
      end do
   end subroutine dashpot_to_ground

   !> The strains of both sides give a face one traction, and the energy that its springs have.
   subroutine faces_between_materials()
      type(weld_type) :: weld
      real(wp) :: moduli(3, 3, 2), strains(3, n_deformations, 2), q(n_deformations), by_springs, &
         by_strains, stress(3, 2), traction(2, 2)
      integer :: i, k

      weld%length = 1.3_wp
      weld%area = [0.7_wp, 0.3_wp]
      weld%along = [0.6_wp, 0.8_wp]
      do k = 1, 2
         moduli(:, :, k) = elasticity(material_type(young_modulus=3.0_wp/k**2, &
            poisson_ratio=0.2_wp*k), plane_strain=.true.)
      end do
      strains = strains_of(weld, moduli)
      do i = 1, 20
         q = random_vector(n_deformations)
         associate (springs => springs_of(weld, moduli))
            by_springs = sum(springs%stiffness(:springs%n) &
               *matmul(q, springs%weight(:, :springs%n))**2)
         end associate
         by_strains = dot_product(jump_stiffness(weld, moduli), [sum(q(:2)**2), sum(q(3:4)**2)])
         do k = 1, 2
            associate (strain => matmul(strains(:, :, k), q), n => [weld%along(2), -weld%along(1)])
               stress(:, k) = matmul(moduli(:, :, k), strain)
               by_strains = by_strains + weld%area(k)*dot_product(strain, stress(:, k))
               traction(:, k) = [dot_product(n, stress([1, 3], k)), &
                  dot_product(n, stress([3, 2], k))]
            end associate
         end do
         call check(norm2(traction(:, 2) - traction(:, 1)) < 1.0e-13_wp, 'one traction')
         call check_close(by_strains, by_springs, 'energy', relative=1.0e-13_wp)
      end do
   end subroutine faces_between_materials

end module test_elements
