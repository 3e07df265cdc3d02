! SPDX-License-Identifier: GPL-3.0-or-later
!> The energy audit of complete runs: the budget closes, losses are positive, and energies agree
!> with mechanics.
module test_energy_budget
   use dda_energy, only: energy_algorithmic, energy_contact, energy_fracture, energy_friction, &
      energy_geometric, energy_gravity, energy_input, energy_kinetic, energy_kinetic_damping, &
      energy_strain
   use dda_kinds, only: wp
   use dda_energy, only: energy_type, total_energy
   use dda_simulation, only: simulation_type
   use dda_time_step, only: advance
   use models, only: begin, block_text, contact_text, control_text, joint_text, on_floor, &
      rectangle, relative_balance, rock, turned
   use testing, only: check, check_close, check_no_error, error
   implicit none

   character(len=*), parameter :: gravity = 'gravity = 0.0 -9.81 '
   !> 0.4 s of displacement in samples of 0.05 s
   character(len=*), parameter :: shake = " &motion name = 'shake' quantity = 'displacement' "// &
      'time_step = 0.05 values = 0.0 0.01 0.04 0.03 -0.02 -0.04 -0.01 0.01 0.0 /'
   !> Rounding, and displacement × the tolerated error of forces in the open–close iteration
   real(wp), parameter :: rounding = 5.0e-8_wp
   type(simulation_type) :: simulation

contains

   !> Take steps; the budget closes in each, and losses never decrease.  Without energy input the
   !> total never grows by more than the energy of exact geometry.
   subroutine audit(steps, is_isolated)
      integer, intent(in) :: steps
      logical, intent(in) :: is_isolated   !< no input of energy
      type(energy_type) :: before
      real(wp) :: max_error, growth, loss, scale
      integer :: i

      max_error = 0.0_wp
      growth = 0.0_wp
      loss = 0.0_wp
      scale = tiny(1.0_wp)
      do i = 1, steps
         before = simulation%energy
         call advance(simulation, error)
         if (allocated(error)) exit
         associate (after => simulation%energy)
            max_error = max(max_error, relative_balance(after))
            scale = max(scale, after%value(energy_kinetic), abs(after%value(energy_gravity)), &
               after%value(energy_contact), after%value(energy_strain))
            growth = max(growth, (total_energy(after) - total_energy(before) &
               - (after%value(energy_geometric) - before%value(energy_geometric)))/scale)
            loss = max(loss, (before%value(energy_friction) - after%value(energy_friction))/scale, &
               (before%value(energy_algorithmic) - after%value(energy_algorithmic))/scale, &
               (before%value(energy_fracture) - after%value(energy_fracture))/scale, &
               (before%value(energy_kinetic_damping) - after%value(energy_kinetic_damping))/scale)
         end associate
      end do
      call check_no_error(error, 'all steps close')
      call check_close(max_error, 0.0_wp, 'balance', absolute=rounding)
      call check(loss <= rounding, 'friction, fracture and the scheme only dissipate energy')
      if (is_isolated) call check(growth <= rounding, 'the total never grows')
   end subroutine audit

   !> Audit a model of rock with dry joints under gravity, and other groups.
   subroutine audit_dry(time_step, steps, stiffness, friction, groups, settings, is_isolated)
      real(wp), intent(in) :: time_step, stiffness, friction  !< s, N/m, °
      integer, intent(in) :: steps
      character(len=*), intent(in) :: groups
      character(len=*), intent(in), optional :: settings  !< in &control
      logical, intent(in), optional :: is_isolated
      character(len=:), allocatable :: control
      logical :: isolated

      control = gravity
      if (present(settings)) control = control//settings
      isolated = .true.
      if (present(is_isolated)) isolated = is_isolated
      call begin(simulation, control_text(time_step, steps, control)//rock// &
         contact_text(stiffness, '')//joint_text(friction, 0.0_wp, 0.0_wp)//groups)
      call audit(steps, isolated)
   end subroutine audit_dry

   subroutine free_fall()
      call begin(simulation, control_text(1.0e-3_wp, 1000, gravity)//rock// &
         joint_text(0.0_wp, 0.0_wp, 0.0_wp)//block_text('b', rectangle(0.0_wp, 0.0_wp, 1.0_wp, &
         1.0_wp)))
      call audit(1000, .true.)
      call check_close(simulation%energy%value(energy_kinetic), 0.5_wp*2500.0_wp*9.81_wp**2, &
         'kinetic', relative=1.0e-10_wp)
      call check_close(simulation%energy%value(energy_gravity), -0.5_wp*2500.0_wp*9.81_wp**2, &
         'gravity', relative=1.0e-10_wp)
      call check_close(simulation%energy%value(energy_algorithmic), 0.0_wp, &
         'the scheme dissipates nothing', absolute=1.0e-6_wp)
   end subroutine free_fall

   subroutine bounce()
      real(wp), parameter :: time_step(3) = [2.0e-5_wp, 1.0e-4_wp, 1.0e-3_wp]
      integer :: i

      do i = 1, 3
         call audit_dry(time_step(i), nint(0.1_wp/time_step(i)), 1.0e9_wp, 30.0_wp, &
            on_floor(rectangle(-0.5_wp, 0.001_wp, 0.5_wp, 1.0_wp)))
         call check(simulation%energy%value(energy_algorithmic) > 0.0_wp, 'the scheme damps')
      end do
   end subroutine bounce

   !> A block thrown along the floor: all its kinetic energy becomes friction.
   subroutine sliding()
      call begin(simulation, control_text(1.0e-3_wp, 600, gravity)//contact_text(1.0e9_wp, '')// &
         joint_text(20.0_wp, 0.0_wp, 0.0_wp)// &
         " &material name = 'still' density = 2500.0 young_modulus = 5.0e9 poisson_ratio = "// &
         '0.25 /'//" &material name = 'thrown' density = 2500.0 young_modulus = 5.0e9 "// &
         'poisson_ratio = 0.25'//' initial_velocity = 1.5 0.0 0.0 /'// &
         on_floor(rectangle(-0.9_wp, 0.0_wp, 0.1_wp, 0.4_wp), "material = 'thrown' "))
      call audit(600, .true.)
      call check_close(simulation%energy%value(energy_friction), 0.5_wp*1000.0_wp*1.5_wp**2, &
         'friction', relative=1.0e-3_wp)
      call check(simulation%energy%value(energy_kinetic) < 1.0e-6_wp &
         *simulation%energy%value(energy_friction), 'at rest')
   end subroutine sliding

   !> Falls on a corner and tumbles: large rotations under contact.
   subroutine tumbling()
      call audit_dry(2.0e-4_wp, 5000, 1.0e9_wp, 35.0_wp, &
         on_floor(turned(rectangle(0.9_wp, 0.9_wp, 1.6_wp, 1.4_wp), 0.9_wp)))
      call check(abs(simulation%energy%value(energy_geometric)) < 0.02_wp &
         *abs(simulation%energy%value(energy_gravity)), 'exact geometry adds little')
   end subroutine tumbling

   subroutine settling_stack()
      real(wp), parameter :: time_step(4) = [1.0e-2_wp, 1.0e-3_wp, 1.0e-4_wp, 1.0e-5_wp]
      integer :: i

      do i = 1, 4
         call audit_dry(time_step(i), 300, 1.0e12_wp, 30.0_wp, on_floor()// &
            ' &layers left = -2.0 bottom = 0.0 width = 4.0 thickness = 1.0 count = 15 /')
      end do
   end subroutine settling_stack

   subroutine settling_wall()
      real(wp), parameter :: time_step(3) = [1.0e-2_wp, 1.0e-3_wp, 1.0e-4_wp]
      integer :: i

      do i = 1, 3
         call audit_dry(time_step(i), 200, 1.0e11_wp, 30.0_wp, on_floor()//' &wall left = -1.5 '// &
            'bottom = 0.0 brick_length = 0.6 brick_height = 0.3 bricks = 5 courses = 10 /')
      end do
   end subroutine settling_wall

   !> Fixed points that follow a sine: their work is the input.
   subroutine shaken_base()
      call audit_dry(1.0e-3_wp, 500, 1.0e9_wp, 15.0_wp, shake//on_floor(rectangle(-0.5_wp, 0.0_wp, &
         0.5_wp, 1.0_wp), point_text="motion_x = 'shake'"), is_isolated=.false.)
      call check(abs(simulation%energy%value(energy_input)) > 0.0_wp &
         .and. simulation%energy%value(energy_friction) > 0.0_wp, 'the base works, the block slips')
   end subroutine shaken_base

   !> The same shaking as acceleration of the base, in its frame.
   subroutine base_acceleration()
      call audit_dry(1.0e-3_wp, 500, 1.0e9_wp, 15.0_wp, shake//on_floor(rectangle(-0.5_wp, 0.0_wp, &
         0.5_wp, 1.0_wp)), "base_motion_x = 'shake'", .false.)
      call check(abs(simulation%energy%value(energy_input)) > 0.0_wp, 'it works')
   end subroutine base_acceleration

   !> Force × displacement of a free block.
   subroutine load()
      call begin(simulation, control_text(1.0e-3_wp, 1000, '')//rock//joint_text(0.0_wp, 0.0_wp, &
         0.0_wp)//block_text('b', rectangle(-0.5_wp, -0.5_wp, 0.5_wp, 0.5_wp))// &
         ' &load x = 0.0 y = 0.0 time = 0.0 2.0 force_x = 5000.0 5000.0 /')
      call audit(1000, .false.)
      call check_close(simulation%energy%value(energy_input), 5000.0_wp*1.0_wp, 'F ½ (F/m) t²', &
         relative=1.0e-10_wp)
      call check_close(simulation%energy%value(energy_kinetic), 5000.0_wp, 'all of it kinetic', &
         relative=1.0e-10_wp)
   end subroutine load

   subroutine breaking_bonds()
      call begin(simulation, control_text(1.0e-4_wp, 3000, gravity)//contact_text(1.0e9_wp, '')// &
         rock//joint_text(20.0_wp, 1.0e4_wp, 1.0e4_wp)// &
         on_floor(rectangle(-0.5_wp, 0.0_wp, 0.5_wp, 1.0_wp))// &
         ' &load block = ''b'' x = 0.2 y = 1.0 time = 0.0 0.3 force_x = 0.0 4.0e4 force_y = '// &
         '0.0 6.0e4 /')
      call audit(3000, .false.)
      call check(simulation%counters%broken == 2, 'both break')
      call check(simulation%energy%value(energy_fracture) > 0.0_wp, 'broken bonds dissipate energy')
   end subroutine breaking_bonds

   subroutine dynamic_factor()
      call audit_dry(1.0e-3_wp, 500, 1.0e9_wp, 30.0_wp, &
         on_floor(rectangle(-0.5_wp, 0.001_wp, 0.5_wp, 1.0_wp)), 'dynamic_factor = 0.97')
      call check(simulation%energy%value(energy_kinetic_damping) > 0.0_wp, 'it dissipates energy')
   end subroutine dynamic_factor

end module test_energy_budget
