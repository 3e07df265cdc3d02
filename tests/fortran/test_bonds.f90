! SPDX-License-Identifier: GPL-3.0-or-later
!> Bonds: joints that are intact at the start, their lengths, and the loads at which they break.
module test_bonds
   use dda_kinds, only: wp
   use dda_contact, only: contact_stick
   use dda_simulation, only: simulation_type
   use models, only: begin, block_text, contact_text, control_text, joint_text, number, rectangle, &
      rock, run, turned
   use testing, only: case, check, check_close
   implicit none

   !> So stiff that the bonds share a load as the springs of a rigid block do.
   character(len=*), parameter :: rigid = &
      " &material name = 'rigid' density = 2500.0 young_modulus = 1.0e13 poisson_ratio = 0.25 /"
   real(wp), parameter :: cohesion = 2.0e5_wp, tension = 1.0e5_wp, stiffness = 1.0e9_wp
   type(simulation_type) :: simulation

contains

   !> Check the number of bonds and the total bonded length.
   subroutine check_bonds(number, label, length)
      integer, intent(in) :: number
      character(len=*), intent(in) :: label
      real(wp), intent(in), optional :: length
      integer :: c

      associate (contacts => simulation%contacts(simulation%now))
         do c = 1, contacts%n
            if (contacts%bonded(c)) call check(contacts%state(c) == contact_stick, 'a bond sticks')
         end do
         call check(count(contacts%bonded(:contacts%n)) == number, label)
         if (present(length)) call check_close(sum(contacts%bond_length(:contacts%n), &
            contacts%bonded(:contacts%n)), length, label, relative=1.0e-12_wp)
      end associate
   end subroutine check_bonds

   subroutine two_blocks(lower, upper, joint)
      real(wp), intent(in) :: lower(:,:), upper(:,:)
      character(len=*), intent(in) :: joint

      call begin(simulation, control_text(1.0e-3_wp, 10, '')//contact_text(stiffness, '')//rock// &
         joint//block_text('lower', lower)//block_text('upper', upper))
   end subroutine two_blocks

   !> Two bonds share the overlap, at any inclination.
   subroutine lengths()
      character(len=:), allocatable :: joint
      real(wp) :: angle
      integer :: i

      joint = joint_text(30.0_wp, cohesion, tension)
      do i = 0, 6
         angle = 0.45_wp*i
         call case('equal width')
         call two_blocks(turned(rectangle(0.0_wp, 0.0_wp, 2.0_wp, 1.0_wp), angle), &
            turned(rectangle(0.0_wp, 1.0_wp, 2.0_wp, 2.0_wp), angle), joint)
         call check_bonds(2, 'over the whole joint', 2.0_wp)
         call case('half over half')
         call two_blocks(turned(rectangle(0.0_wp, 0.0_wp, 2.0_wp, 1.0_wp), angle), &
            turned(rectangle(1.2_wp, 1.0_wp, 3.2_wp, 2.0_wp), angle), joint)
         call check_bonds(2, 'over the overlap', 0.8_wp)
         call case('narrow on wide')
         call two_blocks(turned(rectangle(0.0_wp, 0.0_wp, 3.0_wp, 1.0_wp), angle), &
            turned(rectangle(1.0_wp, 1.0_wp, 1.7_wp, 2.0_wp), angle), joint)
         call check_bonds(2, 'over the narrow one', 0.7_wp)
      end do
   end subroutine lengths

   !> Each bond has the joint of the edges that it connects, over their overlap, also if the
   !> floor continues with another joint.
   subroutine joints_of_edges()
      character(len=:), allocatable :: joints, floor, upper
      integer :: order, c

      joints = " &joint name = 'none' friction_angle = 5.0 / &joint name = 'left' "// &
         "friction_angle = 30.0 cohesion = 1.0e5 / &joint name = 'right' friction_angle = 20.0 "// &
         "cohesion = 2.0e5 / &joint name = 'strong' friction_angle = 40.0 cohesion = 9.0e5 /"
      floor = block_text('floor', reshape([0.0_wp, 0.0_wp, 3.0_wp, 0.0_wp, 3.0_wp, 1.0_wp, 1.0_wp, &
         1.0_wp, 0.0_wp, 1.0_wp], [2, 5]), "joint = 'none' edge_joints = , , 'right', 'left'")
      upper = block_text('upper', rectangle(0.4_wp, 1.0_wp, 2.9_wp, 2.0_wp), &
         "joint = 'none' edge_joints = 'strong'")
      do order = 1, 2
         call begin(simulation, control_text(1.0e-3_wp, 10, '')//contact_text(stiffness, '')// &
            rock//joints//merge(floor//upper, upper//floor, order == 1))
         call check_bonds(2, 'over the whole joint', 2.5_wp)
         associate (contacts => simulation%contacts(simulation%now))
            do c = 1, contacts%n
               call check_close(contacts%bond_length(c), merge(0.6_wp, 1.9_wp, &
                  contacts%joint(c) == 2), 'of its own edge', relative=1.0e-12_wp)
               call check(any(contacts%joint(c) == [2, 3]), 'weaker of the two edges')
            end do
         end associate
         call run(simulation, 5)
         call check_bonds(2, 'and they hold')
      end do
   end subroutine joints_of_edges

   subroutine no_bond()
      call two_blocks(rectangle(0.0_wp, 0.0_wp, 2.0_wp, 1.0_wp), rectangle(0.0_wp, 1.001_wp, &
         2.0_wp, 2.0_wp), joint_text(30.0_wp, cohesion, tension))
      call check_bonds(0, 'over a gap')
      call two_blocks(rectangle(0.0_wp, 0.0_wp, 2.0_wp, 1.0_wp), rectangle(0.0_wp, 1.0_wp, &
         2.0_wp, 2.0_wp), joint_text(30.0_wp, 0.0_wp, 0.0_wp))
      call check_bonds(0, 'without strength')
      call two_blocks(rectangle(0.0_wp, 0.0_wp, 2.0_wp, 1.0_wp), reshape([1.0_wp, 1.0_wp, 2.0_wp, &
         1.2_wp, 1.0_wp, 2.0_wp], [2, 3]), joint_text(30.0_wp, cohesion, tension))
      call check_bonds(0, 'of edges that are not parallel')
   end subroutine no_bond

   !> A slow ramp pulls the upper block off: the bond holds tensile strength × length, no more.
   subroutine breaks_in_tension()
      call pull_until(tension*1.5_wp, 'force_y')
   end subroutine breaks_in_tension

   !> Without normal force, cohesion × length.
   subroutine breaks_in_shear()
      call pull_until(cohesion*1.5_wp, 'force_x')
   end subroutine breaks_in_shear

   !> Ramp a force from 0 to twice `strength` in 1 s, without inertia, and see when the joint gives
   !> way. The joint is 1.5 m long; a shear force acts in its plane so that it does not tilt it.
   subroutine pull_until(strength, force)
      real(wp), intent(in) :: strength
      character(len=*), intent(in) :: force
      real(wp) :: x
      integer :: i

      x = 0.75_wp
      if (force == 'force_x') x = 0.0_wp
      call begin(simulation, control_text(2.0e-3_wp, 500, 'dynamic_factor = 0.0')// &
         contact_text(stiffness, '')//rigid//joint_text(30.0_wp, cohesion, tension)// &
         block_text('lower', rectangle(0.0_wp, 0.0_wp, 1.5_wp, 1.0_wp))// &
         block_text('upper', rectangle(0.0_wp, 1.0_wp, 1.5_wp, 2.0_wp))// &
         ' &fixed_point x = 0.1 y = 0.1 / &fixed_point x = 1.4 y = 0.1 / &fixed_point x = 0.1 '// &
         'y = 0.9 /'//' &fixed_point x = 1.4 y = 0.9 / &load block = ''upper'' x = '//number(x)// &
         ' y = '//number(merge(1.0_wp, 2.0_wp, force == 'force_x'))//' time = 0.0 1.0 '//force// &
         ' = 0.0 '//number(2.0_wp*strength)//' /')
      do i = 1, 500
         call run(simulation, 1)
         if (simulation%counters%broken > 0) exit
      end do
      call check_close(simulation%time, 0.5_wp, 'breaks at its strength', absolute=0.01_wp)
      call check_bonds(0, 'both bonds at once')
      call check(simulation%counters%broken == 2, 'two are counted')
   end subroutine pull_until

end module test_bonds
