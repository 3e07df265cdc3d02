! SPDX-License-Identifier: GPL-3.0-or-later
!> The joint of a contact: from both edges, whichever block gives the vertex, and from its history.
module test_contact_joints
   use dda_kinds, only: wp, pi
   use dda_blocks, only: update_geometry
   use dda_contact, only: contact_open, contact_slide, contact_stick, contacts_type, reserve
   use dda_contact_joints, only: set_joints
   use dda_friction, only: laws_type, set_laws, weaker_joint
   use dda_material, only: joint_type
   use dda_simulation, only: simulation_type
   use models, only: begin, block_text, contact_text, control_text, rectangle, rock, turned
   use testing, only: check, check_close
   implicit none

   !> A wrong edge would give the weak joint, or one that is too strong.
   character(len=*), parameter :: joints = " &joint name = 'weak' friction_angle = 5.0 /"// &
      " &joint name = 'base' friction_angle = 20.0 / &joint name = 'side' friction_angle = "// &
      '40.0 /'//" &joint name = 'floor' friction_angle = 50.0 / &joint name = 'next' "// &
      'friction_angle = 10.0 /'
   integer, parameter :: weak = 1, base = 2, side = 3, floor = 4, next = 5
   integer, parameter :: contact_vertex = 6, lower_edge = 4  !< of `tilted` and `end_of_edge`
   type(simulation_type) :: simulation
   type(contacts_type) :: contacts

contains

   !> Friction, then cohesion, then tensile strength, then the number; both ways round.
   subroutine the_weaker_of_two()
      type(laws_type) :: laws
      type(joint_type) :: list(6)
      integer :: i, j

      list%friction_angle = [10.0_wp, 20.0_wp, 20.0_wp, 20.0_wp, 20.0_wp, 30.0_wp]
      list%cohesion = [9.0_wp, 1.0_wp, 2.0_wp, 2.0_wp, 2.0_wp, 0.0_wp]
      list%tensile_strength = [9.0_wp, 9.0_wp, 3.0_wp, 4.0_wp, 4.0_wp, 0.0_wp]
      call set_laws(laws, list, 1.0e9_wp, 2.5_wp)
      do i = 1, 6
         do j = 1, 6
            call check(weaker_joint(laws, i, j) == min(i, j), 'the first of the two')
         end do
      end do
   end subroutine the_weaker_of_two

   !> All contacts of two faces have the weaker joint of these faces, at any inclination, with
   !> either block first and with vertices of either.
   subroutine faces()
      character(len=:), allocatable :: lower, upper
      real(wp), parameter :: shift(5) = [0.0_wp, 0.3_wp, -0.4_wp, 0.001_wp, -0.001_wp]
      real(wp) :: left, angle
      integer :: i, k

      do i = 0, 6
         angle = 0.45_wp*i
         do k = 1, 5
            left = shift(k)
            lower = block_text('lower', turned(rectangle(0.0_wp, 0.0_wp, 2.0_wp, 1.0_wp), angle), &
               "edge_joints = 'weak', 'weak', 'floor', 'weak'")
            upper = block_text('upper', turned(rectangle(left, 1.0_wp, left + 2.0_wp, 2.0_wp), &
               angle), "joint = 'weak' edge_joints = 'side'")
            call check_side(lower//upper, 'the joint of the faces')
            call check_side(upper//lower, 'in the other order')
         end do
      end do

   contains

      !> Both contacts of two blocks have the joint `side`.
      subroutine check_side(block_texts, label)
         character(len=*), intent(in) :: block_texts, label

         call begin(simulation, control_text(1.0e-3_wp, 10, '')//contact_text(1.0e9_wp, '')// &
            rock//joints//block_texts)
         associate (contacts => simulation%contacts(simulation%now))
            call check(contacts%n == 2 .and. all(contacts%joint(:contacts%n) == side), label)
         end associate
      end subroutine check_side
   end subroutine faces

   !> A block over a floor of three edges, two of them in line, with one contact between the block's
   !> lower left corner and the edge `lower_edge`.
   subroutine tilted(simulation, contacts)
      type(simulation_type), intent(out) :: simulation
      type(contacts_type), intent(out) :: contacts

      call begin(simulation, control_text(1.0e-3_wp, 10, '')//contact_text(1.0e9_wp, '')//rock// &
         joints//block_text('floor', reshape([-9.0_wp, -1.0_wp, 9.0_wp, -1.0_wp, 9.0_wp, 0.0_wp, &
         0.0_wp, 0.0_wp, -9.0_wp, 0.0_wp], [2, 5]), &
         "edge_joints = 'weak', 'weak', 'next', 'floor', 'weak'")// &
         block_text('block', rectangle(-5.0_wp, 0.0_wp, -4.0_wp, 1.0_wp), &
         "edge_joints = 'base', 'weak', 'weak', 'side'"))
      call reserve(contacts, 1)
      contacts%n = 1
      contacts%vertex(1) = contact_vertex
      contacts%edge(1) = lower_edge
      contacts%block_v(1) = 2
      contacts%block_e(1) = 1
      contacts%normal(:, 1) = [0.0_wp, 1.0_wp]
      contacts%state(1) = contact_stick
      simulation%detection%depth = 0.0_wp
   end subroutine tilted

   !> Joint of the contact with the block turned by an angle.
   integer function joint_at(degrees) result(joint)
      real(wp), intent(in) :: degrees

      simulation%blocks%position(3, 2) = degrees*pi/180.0_wp
      call update_geometry(simulation%blocks)
      call set_joints(contacts, simulation%blocks, simulation%laws, simulation%detection)
      joint = contacts%joint(1)
   end function joint_at

   !> Without history the nearer parallel edge counts; both edges count if neither is parallel.
   subroutine a_corner_between_two_edges()
      integer :: i, k

      call tilted(simulation, contacts)
      do k = 1, 2
         do i = -80, -10, 5
            contacts%joint(1) = merge(0, merge(base, side, i < -45), k == 1)
            contacts%state(1) = merge(contact_stick, contact_open, k == 1)
            call check(joint_at(real(i, wp)) == merge(side, base, i < -45), &
               'the edge more nearly parallel')
         end do
      end do
   end subroutine a_corner_between_two_edges

   !> A block that rocks on its corner keeps its joint until sin(90° − α) < sin(α)/2, on the way
   !> back likewise; a bonded one keeps it.
   subroutine toppling()
      real(wp) :: limit
      integer :: i

      limit = atan(2.0_wp)*180.0_wp/pi
      call tilted(simulation, contacts)
      contacts%joint(1) = base
      do i = 1, 89
         call check(joint_at(-real(i, wp)) == merge(base, side, i < limit), &
            'falls on its side')
      end do
      do i = 89, 1, -1
         call check(joint_at(-real(i, wp)) == merge(side, base, &
            i > 90 - limit), 'stands up again')
      end do
      contacts%bonded(1) = .true.
      call check(joint_at(-85.0_wp) == base, 'a bond keeps its joint')
   end subroutine toppling

   !> The vertex passes from the edge `floor` to the next one, `next`, and back: its joint changes
   !> at a distance beyond the end of twice the penetration if it slides, of the size of a corner if
   !> it sticks.
   subroutine the_end_of_an_edge()
      real(wp), parameter :: depth = 1.0e-4_wp
      real(wp) :: x, tolerance
      integer :: i, pass, direction, expected

      do pass = 1, 2
         call tilted(simulation, contacts)
         simulation%detection%depth(contact_vertex) = depth
         contacts%state(1) = merge(contact_slide, contact_stick, pass == 1)
         tolerance = merge(2*depth, simulation%detection%corner(contact_vertex), pass == 1)
         call check(tolerance <= simulation%detection%corner(contact_vertex), 'inside the corner')
         contacts%joint(1) = base
         do direction = 1, -1, -2
            do i = -99, 99, 2
               x = direction*i*tolerance/20.0_wp
               simulation%blocks%position(1, 2) = x + 0.5_wp - simulation%model%origin(1)
               contacts%edge(1) = merge(lower_edge, lower_edge - 1, x <= 0.0_wp)
               ! Where the edge that it has left is still listed, it counts like the other one.
               if (modulo(i, 4) == 1 .and. abs(x) < 0.5_wp) contacts%edge(1) = lower_edge
               expected = merge(base, next, direction*x <= tolerance .eqv. direction == 1)
               call check(joint_at(0.0_wp) == expected, &
                  'one change on the way')
            end do
         end do
      end do
      call check_close(simulation%blocks%length(lower_edge), 9.0_wp, 'the edges in line')
   end subroutine the_end_of_an_edge

end module test_contact_joints
