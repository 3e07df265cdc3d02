! SPDX-License-Identifier: GPL-3.0-or-later
!> Crossings of joints: corners that lie across, and the end of this state.
module test_crossings
   use dda_crossings, only: release_separated, release_removed
   use dda_kinds, only: wp
   use dda_simulation, only: simulation_type
   use models, only: begin, block_text, contact_text, control_text, joint_text, number, rectangle, &
      rock, run, turned
   use testing, only: check
   implicit none

   type(simulation_type) :: simulation

contains

   !> Four rectangles around a point, the second row shifted to the right, all rotated.
   subroutine lattice(shift, gap, angle)
      real(wp), intent(in) :: shift, gap, angle

      call begin(simulation, control_text(1.0e-3_wp, 10, '')//contact_text(1.0e9_wp, '')//rock// &
         joint_text(30.0_wp, 0.0_wp, 0.0_wp)// &
         block_text('a', turned(rectangle(0.0_wp, 0.0_wp, 1.3_wp, 1.0_wp), angle))// &
         block_text('b', turned(rectangle(1.3_wp, 0.0_wp, 2.0_wp, 1.0_wp), angle))// &
         block_text('c', turned(rectangle(shift, 1.0_wp + gap, 1.3_wp + shift, 2.0_wp), angle))// &
         block_text('d', turned(rectangle(1.3_wp + shift, 1.0_wp + gap, 2.0_wp, 2.0_wp), angle)))
   end subroutine lattice

   !> Corners that have others across.
   pure integer function across()
      across = count(simulation%detection%across > 0)
   end function across

   !> Contacts between two blocks.
   pure integer function between(b1, b2)
      integer, intent(in) :: b1, b2
      integer :: c

      between = 0
      associate (list => simulation%contacts(simulation%now))
         do c = 1, list%n
            if (min(list%block_v(c), list%block_e(c)) == b1 .and. &
               max(list%block_v(c), list%block_e(c)) == b2) between = between + 1
         end do
      end associate
   end function between

   !> Four corners, two pairs across, no contacts between them; at any inclination.
   subroutine four_blocks()
      integer :: i

      do i = 0, 7
         call lattice(0.0_wp, 0.0_wp, 0.4_wp*i)
         call run(simulation, 2)
         call check(across() == 4, 'two pairs across')
         call check(between(1, 4) == 0, 'no contact across')
         call check(between(2, 3) == 0, 'nor of the other two')
         call check(between(1, 3) == 2, 'faces have theirs')
      end do
   end subroutine four_blocks

   !> If the joint is offset, two of the four share a face.
   subroutine an_offset()
      call lattice(0.3_wp, 0.0_wp, 0.0_wp)
      call run(simulation, 2)
      call check(across() == 0, 'nothing across')
      call check(between(2, 3) == 2, 'the face has contacts')
   end subroutine an_offset

   !> Each corner has two neighbours and three across.
   subroutine six_triangles()
      character(len=:), allocatable :: text
      real(wp), parameter :: sixth = acos(0.5_wp)
      real(wp) :: from, to
      integer :: i

      text = control_text(1.0e-3_wp, 10, '')//contact_text(1.0e9_wp, '')//rock// &
         joint_text(30.0_wp, 0.0_wp, 0.0_wp)
      do i = 1, 6
         from = sixth*i
         to = sixth*(i + 1)
         text = text//block_text('t'//number(real(i, wp)), reshape([0.0_wp, 0.0_wp, cos(from), &
            sin(from), cos(to), sin(to)], [2, 3]))
      end do
      call begin(simulation, text)
      call check(across() == 18, 'nine pairs')
      call check(between(1, 4) == 0, 'without contacts')
   end subroutine six_triangles

   !> Corners that do not touch are not joined, so that nothing lies across.
   subroutine an_open_joint()
      call lattice(0.0_wp, 1.0e-4_wp, 0.0_wp)
      call check(across() == 0, 'nothing across')
   end subroutine an_open_joint

   !> After block c is removed, a and d can touch, and b has no block across.
   subroutine a_block_is_removed()
      call lattice(0.0_wp, 0.0_wp, 0.0_wp)
      associate (list => simulation%contacts(simulation%now))
         call release_removed(simulation%detection%across, list, [.false., .false., .true., &
            .false.])
      end associate
      call check(across() == 0, 'nothing across')
   end subroutine a_block_is_removed

   subroutine corners_move_apart()
      call lattice(0.0_wp, 0.0_wp, 0.0_wp)
      call release_separated(simulation%detection%across, simulation%blocks, 0.01_wp)
      call check(across() == 4, 'still across')
      associate (blocks => simulation%blocks)
         blocks%vertex(1, blocks%first(4):blocks%first(5) - 1) = 0.02_wp &
            + blocks%vertex(1, blocks%first(4):blocks%first(5) - 1)
      end associate
      call release_separated(simulation%detection%across, simulation%blocks, 0.01_wp)
      call check(across() == 2, 'one pair is left')
   end subroutine corners_move_apart

end module test_crossings
