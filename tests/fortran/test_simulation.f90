! SPDX-License-Identifier: GPL-3.0-or-later
!> Complete runs against mechanics: flight, spin, sliding and sticking, and the actions and messages
!> of step control.
module test_simulation
   use dda_blocks, only: momentum_of, update_geometry
   use dda_diagnostics, only: doubt_state
   use dda_doubts, only: doubt_type
   use dda_equilibrium, only: equilibrate, equilibrium_type
   use dda_kinds, only: wp, pi
   use dda_polygon, only: area_of
   use dda_simulation, only: finished, simulation_type, summary
   use dda_time_step, only: advance
   use models, only: begin, block_text, contact_text, control_text, joint_text, &
      number, on_floor, rectangle, rock, run, turned
   use testing, only: case, check, check_close, check_no_error, error
   implicit none

   real(wp), parameter :: g = 9.81_wp
   character(len=*), parameter :: gravity = 'gravity = 0.0 -9.81 '
   type(simulation_type) :: simulation

contains

   subroutine inclines()
      call incline(0.0_wp, 1.0_wp)
      call incline(10.0_wp, 1.0_wp)
      call incline(20.0_wp, 1.0_wp)
      call incline(0.0_wp, 50.0_wp)
      call incline(10.0_wp, 50.0_wp)
      call incline(20.0_wp, 50.0_wp)
   end subroutine inclines

   !> Steps without a water table are counted and doubted; a run without them says nothing of it.
   subroutine unconverged_water_tables()
      type(doubt_type), allocatable :: doubts(:)

      call begin(simulation, control_text(1.0e-3_wp, 1, gravity)//rock// &
         joint_text(0.0_wp, 0.0_wp, 0.0_wp)//block_text('b', rectangle(0.0_wp, 0.0_wp, 1.0_wp, &
         2.0_wp)))
      call run(simulation, 1)
      allocate (doubts(0))
      call doubt_state(simulation, doubts)
      call check(size(doubts) == 0 .and. index(summary(simulation), 'table') == 0, 'no doubt')
      simulation%counters%tables_off = 2
      call doubt_state(simulation, doubts)
      call check(doubts(1)%topic == 'water table', doubts(1)%text)
      call check(index(summary(simulation), ', 2 steps without a water table') > 0, &
         summary(simulation))
   end subroutine unconverged_water_tables

   !> A hundred turns of a block without symmetry, in a hundred steps each.
   subroutine a_hundred_turns()
      real(wp) :: shape(2, 5), edges(5), momentum
      integer :: i

      shape = reshape([0.0_wp, 0.0_wp, 2.0_wp, 0.1_wp, 2.5_wp, 1.0_wp, 1.0_wp, 0.6_wp, 0.2_wp, &
         1.4_wp], [2, 5])
      call begin(simulation, control_text(1.0e-3_wp, 10000, '')//joint_text(0.0_wp, 0.0_wp, &
         0.0_wp)//' &material density = 1000.0 young_modulus = 1.0e9 poisson_ratio = 0.2 '// &
         'initial_velocity = 0.5 0.0 '//number(20.0_wp*pi)//' /'//block_text('b', shape))
      edges = norm2(shape - cshift(shape, 1, 2), 1)
      momentum = angular_momentum()
      call run(simulation, 10000)
      call check_close(simulation%blocks%position(3, 1), 200.0_wp*pi, 'angle', relative=1.0e-11_wp)
      call check_close(area_of(simulation%blocks%vertex), area_of(shape), 'area', &
         relative=1.0e-10_wp)
      call check_close(norm2(simulation%blocks%vertex - cshift(simulation%blocks%vertex, 1, 2), &
         1), edges, 'edges', relative=1.0e-10_wp)
      call check_close(angular_momentum(), momentum, 'angular momentum', relative=1.0e-10_wp)
      do i = 4, 6
         call check_close(simulation%blocks%position(i, 1), 0.0_wp, 'strain', absolute=1.0e-12_wp)
      end do
   contains
      real(wp) function angular_momentum()
         real(wp) :: momentum(6)

         momentum = momentum_of(simulation%blocks%inertia(:, 1), simulation%blocks%velocity(:, 1))
         angular_momentum = momentum(3)
      end function angular_momentum
   end subroutine a_hundred_turns

   !> A block on a held plane inclined by 30°.
   subroutine begin_incline(friction_angle, stiffness, time_step, steps)
      real(wp), intent(in) :: friction_angle, stiffness, time_step
      integer, intent(in) :: steps
      real(wp), parameter :: alpha = -pi/6.0_wp
      real(wp) :: base(2, 4)
      character(len=:), allocatable :: text
      integer :: i

      text = control_text(time_step, steps, gravity)//contact_text(stiffness, '')// &
         joint_text(friction_angle, 0.0_wp, 0.0_wp)// &
         ' &material density = 1000.0 young_modulus = 1.0e10 poisson_ratio = 0.2 /'// &
         block_text('plane', turned(rectangle(0.0_wp, -1.0_wp, 16.0_wp, 0.0_wp), alpha))// &
         block_text('slider', turned(rectangle(1.0_wp, 0.0_wp, 2.0_wp, 0.5_wp), alpha))
      base = turned(rectangle(0.5_wp, -0.9_wp, 15.5_wp, -0.1_wp), alpha)
      do i = 1, 4
         text = text//' &fixed_point x = '//number(base(1, i))//' y = '//number(base(2, i))// &
            " block = 'plane' /"
      end do
      call begin(simulation, text)
   end subroutine begin_incline

   !> Way down the incline since the start.
   pure real(wp) function way()
      way = dot_product(simulation%blocks%position(1:2, 2) - simulation%model%blocks%position(1:2, &
         2), [cos(pi/6.0_wp), -sin(pi/6.0_wp)])
   end function way

   !> s = ½ g (sin α − cos α tan φ) t², at a penalty of `factor` × E.
   subroutine incline(friction_angle, factor)
      real(wp), intent(in) :: friction_angle, factor
      real(wp) :: expected
      integer, parameter :: steps = 2000

      call case('sliding at φ = '//number(friction_angle)//', k/E = '//number(factor))
      call begin_incline(friction_angle, factor*1.0e10_wp, 1.0e-3_wp, steps)
      call run(simulation, steps)
      expected = 0.5_wp*g*(0.5_wp - sqrt(0.75_wp)*tan(friction_angle*pi/180.0_wp)) &
         *(1.0e-3_wp*steps)**2
      call check_close(way(), expected, 's', relative=1.0e-6_wp)
   end subroutine incline

   !> φ above α: it settles, then nothing moves any more.
   subroutine sticking_at_35_degrees_on_30_degrees()
      real(wp) :: settled

      call begin_incline(35.0_wp, 1.0e10_wp, 1.0e-3_wp, 3000)
      call run(simulation, 1000)
      settled = way()
      call check_close(settled, 0.0_wp, 'it moves by the give of its springs', absolute=5.0e-6_wp)
      call run(simulation, 2000)
      call check_close(way(), settled, 'no drift', absolute=1.0e-12_wp)
   end subroutine sticking_at_35_degrees_on_30_degrees

   !> A needle on its tip in a notch stays there while it is in balance.
   subroutine rest_in_a_notch()
      real(wp) :: from

      call begin(simulation, control_text(1.0e-3_wp, 300, gravity)//contact_text(1.0e9_wp, '')// &
         rock//joint_text(20.0_wp, 0.0_wp, 0.0_wp)// &
         block_text('base', reshape([-2, -2, 2, -2, 2, 1, 1, 1, 0, 0, -1, 1, -2, 1]*1.0_wp, &
         [2, 7]))//block_text('needle', reshape([0.0_wp, 0.0_wp, 0.2_wp, 0.8_wp, -0.2_wp, 0.8_wp], &
         [2, 3]))//' &fixed_point x = -1.5 y = -1.5 / &fixed_point x = 1.5 y = -1.5 / '// &
         '&fixed_point x = -1.5 y = 0.5 /'//' &fixed_point x = 1.5 y = 0.5 /')
      from = simulation%blocks%position(2, 2)
      call run(simulation, 300)
      call check_close(simulation%blocks%position(2, 2), from, 'it stays', absolute=1.0e-4_wp)
   end subroutine rest_in_a_notch

   !> A contact soft enough to give 1.6 cm, more than the contact distance, still throws the block
   !> back.
   subroutine penetration_beyond_the_contact_distance()
      real(wp) :: min_height
      integer :: i

      call begin(simulation, control_text(1.0e-4_wp, 6000, gravity// &
         'max_displacement_ratio = 0.002')//contact_text(1.0e8_wp, '')// &
         ' &material density = 2500.0 young_modulus = 1.0e15 poisson_ratio = 0.2 /'// &
         joint_text(0.0_wp, 0.0_wp, 0.0_wp)//on_floor(rectangle(-0.5_wp, 1.0_wp, 0.5_wp, 2.0_wp)))
      min_height = huge(1.0_wp)
      do i = 1, 6000
         call advance(simulation, error)
         if (allocated(error)) exit
         min_height = min(min_height, simulation%blocks%position(2, 2))
      end do
      if (allocated(error)) then
         call check(index(error%message, 'normal_stiffness') > 0, 'refused by name: '// &
            error%message)
      else
         call check(min_height > simulation%blocks%position(2, 1) + 0.9_wp, &
            'it never sinks deeper than 10 cm')
         call check(simulation%blocks%velocity(2, 2) > 0.0_wp, 'and goes up again')
      end if
   end subroutine penetration_beyond_the_contact_distance

   !> A block at rest with the penetration of its forces, then moved 30 cm into the floor, where
   !> contacts exert no force: forces balance, but equilibrium is the former position.
   subroutine contacts_that_are_deeper_than_their_force_explains()
      type(equilibrium_type) :: equilibrium
      real(wp) :: height

      call begin(simulation, control_text(1.0e-3_wp, 10, gravity//'settle = .true.')// &
         contact_text(1.0e9_wp, '')//rock//joint_text(30.0_wp, 0.0_wp, 0.0_wp)// &
         on_floor(rectangle(-0.5_wp, 0.0_wp, 0.5_wp, 1.0_wp)))
      call equilibrate(simulation, equilibrium, error)
      call check_no_error(error, 'it rests')
      height = simulation%blocks%position(2, 2)
      simulation%blocks%position(2, 2) = simulation%blocks%position(2, 2) - 0.3_wp
      call update_geometry(simulation%blocks)
      associate (contacts => simulation%contacts(simulation%now))
         contacts%offset(:contacts%n) = contacts%offset(:contacts%n) - 0.3_wp
      end associate
      call equilibrate(simulation, equilibrium, error)
      call check_no_error(error, 'it rests again')
      call check_close(simulation%blocks%position(2, 2), height, 'on the floor', &
         absolute=1.0e-9_wp)
   end subroutine contacts_that_are_deeper_than_their_force_explains

   !> Static steps in which a block falls are shortened; the search distance does not grow.
   subroutine a_fall_in_statics_is_searched_nearby()
      type(equilibrium_type) :: equilibrium

      call begin(simulation, control_text(1.0e-3_wp, 10, gravity)//contact_text(1.0e9_wp, '') &
         //rock//joint_text(30.0_wp, 0.0_wp, 0.0_wp)// &
         on_floor(rectangle(-0.5_wp, 0.2_wp, 0.5_wp, 1.2_wp)))
      call equilibrate(simulation, equilibrium, error)
      call check_no_error(error, 'it falls and rests')
      call check_close(simulation%blocks%position(2, 2) - simulation%blocks%position(2, 1), &
         1.0_wp, 'it lies', absolute=1.0e-3_wp)
      call check(simulation%counters%repeated > 0, 'long steps are shortened')
      call check(simulation%neighbours%reach < 10*simulation%detection%least, 'its reach')
   end subroutine a_fall_in_statics_is_searched_nearby

   !> Δt decreases while a block falls fast, recovers at rest and is reported; the run ends exactly
   !> at its duration.
   subroutine adaptive_time_step()
      real(wp) :: min_time_step, largest_at_rest
      integer :: i

      call begin(simulation, control_text(1.0e-2_wp, 200, gravity// &
         "time_step_control = 'adaptive' least_time_step = 1.0e-6 max_displacement_ratio = "// &
         '0.005')//contact_text(1.0e9_wp, '')//rock//joint_text(30.0_wp, 0.0_wp, 0.0_wp)// &
         on_floor(rectangle(-0.5_wp, 0.5_wp, 0.5_wp, 1.5_wp)))
      min_time_step = huge(1.0_wp)
      largest_at_rest = 0.0_wp
      do i = 1, 100000
         call advance(simulation, error)
         if (allocated(error) .or. finished(simulation)) exit
         min_time_step = min(min_time_step, simulation%last_time_step)
         if (simulation%time > 1.5_wp) largest_at_rest = max(largest_at_rest, &
            simulation%last_time_step)
      end do
      call check_no_error(error, 'all steps close')
      call check_close(simulation%time, 2.0_wp, 'the duration is met', relative=1.0e-12_wp)
      call check(min_time_step < 0.5e-2_wp, 'the step shrinks')
      call check(min_time_step >= 1.0e-6_wp, 'not below the least')
      call check(largest_at_rest > 0.99e-2_wp, 'and recovers')
      call check(simulation%counters%repeated > 0, 'repeated steps are counted')
      call check(index(summary(simulation), 'repeated with a smaller time step') > 0, &
         summary(simulation))
      call check_close(simulation%blocks%position(2, 2) - simulation%blocks%position(2, 1), &
         1.0_wp, 'it lies', absolute=1.0e-3_wp)
   end subroutine adaptive_time_step

end module test_simulation
