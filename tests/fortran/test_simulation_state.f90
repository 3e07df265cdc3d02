! SPDX-License-Identifier: GPL-3.0-or-later
!> A state that is put into another run of the same model makes that run go on as the first one: to
!> the last bit, whatever the other run had done before.
module test_simulation_state
   use dda_archive, only: archive_type, read_archive, write_archive
   use dda_kinds, only: wp
   use dda_simulation, only: simulation_type
   use dda_simulation_state, only: serialise_simulation
   use models, only: begin, contact_text, control_text, joint_text, rock, run
   use testing, only: case, check
   implicit none

   character(len=*), parameter :: gravity = 'gravity = 0.0 -9.81 '
   integer, parameter :: steps = 60

contains

   subroutine every_solver()
      call goes_on(gravity//" solver = 'direct'", '', 3)
      call goes_on(gravity//" solver = 'lagged'", '', 3)
      call goes_on(gravity//" solver = 'jacobi'", '', 3)
      call goes_on(gravity//" solver = 'sor'", '', 2)
      call goes_on(gravity, '', 9)
      call goes_on(gravity//" time_step_control = 'adaptive' dynamic_factor = 0.9", '', 3)
      call goes_on(gravity//" integration = 'theta'", '', 3)
      call goes_on(gravity//" integration = 'midpoint'", '', 2)
      call goes_on(gravity, 'penetration_tolerance = 1.0e-6', 3)
      call goes_on(gravity, "contact_rules = 'original'", 3)
   end subroutine every_solver

   !> A wall that slides and rocks on a base shaken hard.
   pure function wall_text(control, contact, bricks) result(text)
      character(len=*), intent(in) :: control, contact
      integer, intent(in) :: bricks  !< in a course, and courses
      character(len=:), allocatable :: text
      character(len=1) :: count

      write (count, '(i1)') bricks
      text = control_text(1.0e-3_wp, 10*steps, control)//contact_text(1.0e9_wp, contact)//rock// &
         joint_text(15.0_wp, 1.0e3_wp, 1.0e3_wp)// &
         " &layers name = 'base' left = -0.5 bottom = -0.5 width = 11.0 thickness = 0.5 /"// &
         ' &wall bottom = 0.0 brick_length = 1.0 brick_height = 0.5 bricks = '//count// &
         ' courses = '//count//' /'//" &motion name = 'cycle' quantity = 'velocity' time_step "// &
         '= 0.01 values = 0.0 1.0 -1.0 1.5 -1.5 0.5 0.0 /'// &
         " &fixed_point x = 0.0 y = -0.25 motion_x = 'cycle' / &fixed_point x = 9.0 y = -0.25 "// &
         "motion_x = 'cycle' /"
   end function wall_text

   subroutine goes_on(control, contact, bricks)
      character(len=*), intent(in) :: control, contact
      integer, intent(in) :: bricks
      type(simulation_type), allocatable :: interrupted, continuous
      type(archive_type) :: archive

      call case('goes on: '//trim(control)//' '//contact)
      allocate (interrupted, continuous)
      call begin(interrupted, wall_text(control, contact, bricks))
      call run(interrupted, steps)
      call write_archive(archive)
      call serialise_simulation(archive, interrupted)
      call run(interrupted, steps/2)
      call begin(continuous, wall_text(control, contact, bricks))
      call run(continuous, 2*steps + 7)
      call read_archive(archive)
      call serialise_simulation(archive, continuous)
      call check(.not. allocated(archive%failure), 'the state is read')
      call run(continuous, steps/2)
      call check(same(interrupted, continuous), 'the same bits')
   end subroutine goes_on

   !> .true. if the states of two runs have the same bytes.
   logical function same(run_a, run_b)
      type(simulation_type), intent(inout) :: run_a, run_b
      type(archive_type) :: first, second

      call write_archive(first)
      call serialise_simulation(first, run_a)
      call write_archive(second)
      call serialise_simulation(second, run_b)
      same = first%at == second%at
      if (same) same = all(first%bytes(:first%at) == second%bytes(:second%at))
   end function same

   !> Also before the first step, when the vertices are those of the input.
   subroutine at_the_start()
      type(simulation_type), allocatable :: original, restored
      type(archive_type) :: archive

      allocate (original, restored)
      call begin(original, wall_text(gravity, '', 2))
      call write_archive(archive)
      call serialise_simulation(archive, original)
      call begin(restored, wall_text(gravity, '', 2))
      call run(restored, 5)
      call read_archive(archive)
      call serialise_simulation(archive, restored)
      call run(original, 5)
      call run(restored, 5)
      call check(same(original, restored), 'the same bits')
   end subroutine at_the_start

   subroutine another_model()
      type(simulation_type), allocatable :: original, different
      type(archive_type) :: archive

      allocate (original, different)
      call begin(original, wall_text(gravity, '', 2))
      call begin(different, wall_text(gravity, '', 3))
      call write_archive(archive)
      call serialise_simulation(archive, original)
      call read_archive(archive)
      call serialise_simulation(archive, different)
      call check(allocated(archive%failure), 'is refused')
   end subroutine another_model

end module test_simulation_state
