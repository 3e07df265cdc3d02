! SPDX-License-Identifier: GPL-3.0-or-later
!> Histories are transferred from list to list: once, to the right contact, and unchanged.
module test_history
   use dda_kinds, only: wp
   use dda_contact, only: contact_open, contact_slide, contact_stick, contacts_type, &
      copy_contacts, for_each_variable, operation_type, reserve
   use dda_history, only: history_type, inherit, prepare_history
   use models, only: random, random_vector
   use testing, only: check, check_close
   implicit none

   integer, parameter :: vertices = 40
   real(wp), parameter :: upward(2) = [0.0_wp, 1.0_wp]

   !> Gives each variable of a list values of its own, or compares it with these values.
   type, extends(operation_type) :: marker_type
      integer :: n = 0                    !< variables so far
      integer, allocatable :: expected(:) !< contacts whose values are expected; else they are set
      logical :: equal = .true.
   contains
      procedure :: apply => mark_variable
   end type marker_type

contains

   !> One contact more.
   subroutine put(contacts, vertex, edge, corner, block_v, block_e, normal, gap)
      type(contacts_type), intent(inout) :: contacts
      integer, intent(in) :: vertex, edge, corner, block_v, block_e
      real(wp), intent(in) :: normal(2), gap

      contacts%with_strengths = .true.
      call reserve(contacts, contacts%n + 1)
      contacts%n = contacts%n + 1
      associate (c => contacts%n)
         contacts%vertex(c) = vertex
         contacts%edge(c) = edge
         contacts%corner(c) = corner
         contacts%block_v(c) = block_v
         contacts%block_e(c) = block_e
         contacts%normal(:, c) = normal
         contacts%gap(c) = gap
      end associate
   end subroutine put

   !> A history to transfer.
   subroutine mark(contacts, c, state, stretch)
      type(contacts_type), intent(inout) :: contacts
      integer, intent(in) :: c, state
      real(wp), intent(in) :: stretch

      contacts%state(c) = state
      contacts%stretch(c) = stretch
      contacts%joint(c) = nint(1.0e5_wp*stretch)
      contacts%bonded(c) = .true.
      contacts%bond_length(c) = 3.0_wp*stretch
      contacts%slide_force(c) = 7.0_wp*stretch
   end subroutine mark

   subroutine expect(contacts, c, state, stretch, label)
      type(contacts_type), intent(in) :: contacts
      integer, intent(in) :: c, state
      real(wp), intent(in) :: stretch
      character(len=*), intent(in) :: label

      call check(contacts%state(c) == state, label//': state')
      call check(contacts%bonded(c) .eqv. stretch /= 0.0_wp, label//': bond')
      call check(contacts%joint(c) == nint(1.0e5_wp*stretch), label//': joint')
      call check_close([contacts%stretch(c), contacts%bond_length(c), contacts%slide_force(c)], &
         stretch*[1.0_wp, 3.0_wp, 7.0_wp], label//': stretch, length, force')
   end subroutine expect

   subroutine transfer(new, old)
      type(contacts_type), intent(inout) :: new
      type(contacts_type), intent(in) :: old
      type(history_type) :: history

      call prepare_history(history, vertices, 0.0_wp)
      call inherit(new, old, history, .true.)
   end subroutine transfer

   subroutine the_same_contact()
      type(contacts_type) :: old, new

      call put(old, 1, 5, 0, 1, 2, upward, -1.0e-6_wp)
      call put(old, 2, 5, 0, 1, 2, upward, -1.0e-6_wp)
      call mark(old, 1, contact_slide, 1.0e-3_wp)
      call mark(old, 2, contact_stick, -2.0e-3_wp)
      call put(new, 2, 5, 0, 1, 2, [1.0_wp, 0.0_wp], 1.0e-6_wp)
      call put(new, 1, 5, 0, 1, 2, upward, 1.0e-6_wp)
      call transfer(new, old)
      call expect(new, 1, contact_stick, -2.0e-3_wp, 'second, whatever its normal')
      call expect(new, 2, contact_slide, 1.0e-3_wp, 'first')
   end subroutine the_same_contact

   subroutine no_predecessor()
      type(contacts_type) :: old, new

      call put(old, 1, 5, 0, 1, 2, upward, -1.0e-6_wp)
      call mark(old, 1, contact_slide, 1.0e-3_wp)
      call put(new, 3, 9, 0, 1, 3, upward, 1.0e-6_wp)
      call put(new, 3, 10, 0, 1, 3, upward, -1.0e-6_wp)
      call put(new, 1, 20, 0, 1, 4, upward, 1.0e-6_wp)
      call mark(new, 1, contact_slide, 5.0_wp)
      call transfer(new, old)
      call expect(new, 1, contact_open, 0.0_wp, 'apart: open, old marks wiped')
      call expect(new, 2, contact_stick, 0.0_wp, 'penetrating: sticks')
      call expect(new, 3, contact_open, 0.0_wp, 'same vertex on another block')
   end subroutine no_predecessor

   !> Corner to corner, the edge's block takes the vertex' part: same stretch.
   subroutine roles_change()
      type(contacts_type) :: old, new

      call put(old, 4, 5, 8, 1, 2, upward, -1.0e-6_wp)
      call mark(old, 1, contact_slide, 1.0e-3_wp)
      call put(new, 8, 4, 4, 2, 1, -upward, -1.0e-6_wp)
      call transfer(new, old)
      call expect(new, 1, contact_slide, 1.0e-3_wp, 'transferred')
      new%n = 0
      call put(new, 8, 4, 4, 2, 1, upward, -1.0e-6_wp)
      call transfer(new, old)
      call expect(new, 1, contact_stick, 0.0_wp, 'not if it pushes the other way')
   end subroutine roles_change

   !> From edge to edge over a blunt corner; not over a sharp one.
   subroutine corner_travel()
      type(contacts_type) :: old, new

      call put(old, 1, 5, 0, 1, 2, upward, -1.0e-6_wp)
      call mark(old, 1, contact_slide, 1.0e-3_wp)
      call put(new, 1, 6, 0, 1, 2, [sin(0.5_wp), cos(0.5_wp)], -1.0e-6_wp)
      call transfer(new, old)
      call expect(new, 1, contact_slide, 1.0e-3_wp, 'by 29°')
      new%n = 0
      call put(new, 1, 6, 0, 1, 2, [1.0_wp, 0.0_wp], 1.0e-6_wp)
      call transfer(new, old)
      call expect(new, 1, contact_open, 0.0_wp, 'by 90°')
   end subroutine corner_travel

   subroutine vertex_moves_to_another_block()
      type(contacts_type) :: old, new

      call put(old, 1, 5, 0, 1, 2, upward, -1.0e-6_wp)
      call mark(old, 1, contact_stick, 1.0e-3_wp)
      call put(new, 1, 9, 0, 1, 3, upward, -1.0e-6_wp)
      call transfer(new, old)
      call expect(new, 1, contact_stick, 0.0_wp, 'nothing is transferred')
   end subroutine vertex_moves_to_another_block

   !> Two new contacts that could both succeed one old one.
   subroutine transferred_once()
      type(contacts_type) :: old, new

      call put(old, 1, 5, 0, 1, 2, upward, -1.0e-6_wp)
      call mark(old, 1, contact_slide, 1.0e-3_wp)
      call put(new, 1, 6, 0, 1, 2, upward, -1.0e-6_wp)
      call put(new, 1, 7, 0, 1, 2, upward, -1.0e-6_wp)
      call transfer(new, old)
      call expect(new, 1, contact_slide, 1.0e-3_wp, 'the first')
      call expect(new, 2, contact_stick, 0.0_wp, 'not the second')
      new%n = 0
      call put(new, 1, 6, 0, 1, 2, upward, -1.0e-6_wp)
      call put(new, 1, 5, 0, 1, 2, upward, -1.0e-6_wp)
      call transfer(new, old)
      call expect(new, 1, contact_stick, 0.0_wp, 'the exact successor goes first')
      call expect(new, 2, contact_slide, 1.0e-3_wp, 'and takes it')
   end subroutine transferred_once

   !> A contact that first penetrates has no force; only further penetration exerts force, until the
   !> contact has opened.
   subroutine new_contact_in_penetration()
      type(contacts_type) :: old, new
      type(history_type) :: history
      real(wp), parameter :: distance(5) = [-4.0_wp, -6.0_wp, -3.0_wp, 1.0_wp, -2.0_wp]*1.0e-6_wp
      real(wp), parameter :: pressing(5) = [0.0_wp, -2.0_wp, 0.0_wp, 1.0_wp, -2.0_wp]*1.0e-6_wp
      integer :: step

      call prepare_history(history, vertices, 0.0_wp)
      call reserve(old, 1)
      do step = 1, size(distance)
         new%n = 0
         call put(new, 1, 5, 0, 1, 2, upward, distance(step))
         call inherit(new, old, history, .true.)
         call check_close(new%gap(1), pressing(step), 'what presses', absolute=1.0e-20_wp)
         call check_close(new%gap(1) + new%offset(1), distance(step), 'distance', &
            absolute=1.0e-20_wp)
         old = new
      end do
      new%n = 0
      call put(new, 1, 6, 0, 1, 2, [0.0_wp, -1.0_wp], -7.0e-6_wp)
      call inherit(new, old, history, .false.)
      call check_close(new%gap(1), -7.0e-6_wp, 'penetration of the first state presses')
   end subroutine new_contact_in_penetration

   !> New contacts with more penetration than a step can cause are removed; other contacts of the
   !> list do not change.
   subroutine new_contact_too_deep()
      type(contacts_type) :: old, new
      type(history_type) :: history
      real(wp), parameter :: distance(6) = [-4.0_wp, -1.0_wp, -7.0_wp, 2.0_wp, -9.0_wp, &
         -2.0_wp]*1.0e-6_wp
      integer, parameter :: retained(4) = [1, 2, 4, 6]
      integer :: c

      call prepare_history(history, vertices, 0.0_wp)
      history%max_penetration = 3.0e-6_wp
      call put(old, 1, 11, 0, 1, 4, upward, distance(1))
      old%new_gap(1) = distance(1)
      old%offset(1) = 0.0_wp
      call mark(old, 1, contact_slide, 0.25_wp)
      do c = 1, size(distance)
         call put(new, c, 10 + c, 0, 1, 4, [0.6_wp, 0.1_wp*c], distance(c))
         new%corner(c) = 20 + c
         new%pair(c) = 30 + c
         new%close_count(c) = 40 + c
         new%gradient_v(:, c) = 0.5_wp*c
         new%gradient_e(:, c) = -0.5_wp*c
      end do
      call inherit(new, old, history, .true.)
      call check(new%n == size(retained), 'how many stay')
      if (new%n /= size(retained)) return
      call check(all(new%vertex(:4) == retained .and. new%edge(:4) == 10 + retained &
         .and. new%corner(:4) &
         == 20 + retained .and. new%pair(:4) == 30 + retained .and. new%close_count(:4) == 40 &
         + retained), 'which stay')
      call check_close(new%gap(:4) + new%offset(:4), distance(retained), 'distances', &
         absolute=1.0e-20_wp)
      call check_close(new%gap(:4), [distance(1), 0.0_wp, distance(4), 0.0_wp], 'what presses', &
         absolute=1.0e-20_wp)
      call check_close(new%stretch(:4), [0.25_wp, 0.0_wp, 0.0_wp, 0.0_wp], 'histories')
      call check(all(new%joint(:4) == [25000, 0, 0, 0]), 'joints')
      call check_close(new%normal(2, :4), 0.1_wp*retained, 'normals')
      call check_close(new%gradient_v(12, :4) - new%gradient_e(1, :4), real(retained, wp), &
         'gradients')
   end subroutine new_contact_too_deep

   !> The spring energy of a contact that ends is transferred to a contact of the same vertex with
   !> the next block.
   subroutine across_a_joint()
      type(contacts_type) :: old, new

      call put(old, 1, 5, 0, 1, 2, upward, 0.0_wp)
      call put(old, 1, 9, 0, 1, 3, upward, 0.0_wp)
      old%new_gap(1:2) = [-4.0e-6_wp, -3.0e-6_wp]
      old%offset(2) = -7.0e-6_wp
      old%stretch(1:2) = [-8.0e-7_wp, 6.0e-7_wp]
      call put(new, 1, 9, 0, 1, 3, upward, -1.0e-5_wp)
      call transfer(new, old)
      call check_close(new%gap(1), -5.0e-6_wp, 'energies add up')
      call check_close(new%offset(1), -5.0e-6_wp, 'the rest does not press')
      call check_close(new%stretch(1), -1.0e-6_wp, 'shear energies add up')
      new%n = 0
      old%n = 1
      call put(new, 1, 9, 0, 1, 3, upward, -3.0e-6_wp)
      call transfer(new, old)
      call check_close([new%gap(1), new%offset(1)], [-3.0e-6_wp, 0.0_wp], &
         'no more than the penetration gives')
      new%n = 0
      call put(new, 1, 9, 0, 1, 3, [1.0_wp, 0.0_wp], -3.0e-6_wp)
      call transfer(new, old)
      call check_close(new%gap(1), 0.0_wp, 'nothing in another direction', absolute=0.0_wp)
   end subroutine across_a_joint

   !> Whatever the lists: no stretch is used twice or created, and the index is cleared for the
   !> next step.
   subroutine random_lists()
      type(contacts_type) :: old, new
      type(history_type) :: history
      integer :: step, c, k, n_used, n_wrong

      call prepare_history(history, vertices, 0.0_wp)
      call random_list(old)
      n_wrong = 0
      do step = 1, 200
         do c = 1, old%n
            call mark(old, c, contact_slide, random(0.1_wp, 1.0_wp))
         end do
         new%n = 0
         call random_list(new)
         call inherit(new, old, history, .true.)
         do c = 1, old%n
            n_used = count(new%stretch(:new%n) == old%stretch(c))
            if (n_used > 1) n_wrong = n_wrong + 1
         end do
         do c = 1, new%n
            if (new%stretch(c) == 0.0_wp) cycle
            k = findloc(old%stretch(:old%n) == new%stretch(c), .true., 1)
            if (k == 0) n_wrong = n_wrong + 1
            if (k > 0) n_wrong = n_wrong + merge(0, 1, involves(new, c, old, k))
         end do
         if (any(history%head /= 0)) n_wrong = n_wrong + 1
         old = new
      end do
      call check(n_wrong == 0, 'each stretch at most once, between the same two blocks, by a '// &
         'common vertex')
   end subroutine random_lists

   !> Up to 60 contacts among ten blocks of four vertices each.
   subroutine random_list(contacts)
      type(contacts_type), intent(inout) :: contacts
      real(wp) :: normal(2)
      integer :: i, v, e, w

      contacts%with_strengths = .true.
      call reserve(contacts, 60)
      do i = 1, int(random(0.0_wp, 60.0_wp))
         v = 1 + int(random(0.0_wp, 39.9_wp))
         e = 1 + modulo(v + 3 + int(random(0.0_wp, 8.0_wp)), vertices)
         if (block(v) == block(e)) cycle
         if (any(contacts%vertex(:contacts%n) == v .and. contacts%edge(:contacts%n) == e)) cycle
         w = 0
         if (random(0.0_wp, 1.0_wp) > 0.5_wp) w = e
         normal = random_vector(2)
         call put(contacts, v, e, w, block(v), block(e), normal/norm2(normal), &
            random(-1.0_wp, 1.0_wp))
      end do
   contains
      pure integer function block(vertex)
         integer, intent(in) :: vertex

         block = 1 + (vertex - 1)/4
      end function block
   end subroutine random_list

   logical function involves(new, c, old, k)
      type(contacts_type), intent(in) :: new, old
      integer, intent(in) :: c, k

      involves = any([new%vertex(c), new%corner(c)] == old%vertex(k)) .or. &
         (old%corner(k) > 0 .and. any([new%vertex(c), new%corner(c)] == old%corner(k)))
      involves = involves .and. min(new%block_v(c), new%block_e(c)) == min(old%block_v(k), &
         old%block_e(k))
      involves = involves .and. max(new%block_v(c), new%block_e(c)) == max(old%block_v(k), &
         old%block_e(k))
   end function involves

   subroutine mark_variable(operation, integers, logicals, reals, columns)
      class(marker_type), intent(inout) :: operation
      integer, allocatable, intent(inout), optional :: integers(:)
      logical, allocatable, intent(inout), optional :: logicals(:)
      real(wp), allocatable, intent(inout), optional :: reals(:), columns(:,:)
      integer, allocatable :: value(:)
      integer :: i, length

      operation%n = operation%n + 1
      length = 0
      if (present(integers)) length = size(integers)
      if (present(logicals)) length = size(logicals)
      if (present(reals)) length = size(reals)
      if (present(columns)) length = size(columns, 2)
      value = [(i, i=1, length)]
      if (allocated(operation%expected)) value = operation%expected
      value = 1000*operation%n + value
      if (.not. allocated(operation%expected)) then
         if (present(integers)) integers = value
         if (present(logicals)) logicals = modulo(value, 3) == 0
         if (present(reals)) reals = value
         if (present(columns)) columns = spread(real(value, wp), 1, size(columns, 1))
         return
      end if
      operation%equal = operation%equal .and. length == size(value)
      if (.not. operation%equal) return
      if (present(integers)) operation%equal = all(integers == value)
      if (present(logicals)) operation%equal = all(logicals .eqv. modulo(value, 3) == 0)
      if (present(reals)) operation%equal = all(reals == value)
      if (present(columns)) operation%equal = all(columns == spread(real(value, wp), 1, &
         size(columns, 1)))
   end subroutine mark_variable

   !> Every variable of a list is copied, and the arrays that exist only within a step.
   subroutine some_contacts_are_copied()
      type(contacts_type) :: contacts, copy
      type(marker_type) :: marker
      integer, parameter :: list(3) = [5, 1, 4]
      integer :: variables

      contacts%with_multipliers = .true.
      contacts%with_strengths = .true.
      contacts%with_damping = .true.
      contacts%with_laws = .true.
      contacts%with_net_slip = .true.
      contacts%initial_memory = [0.0_wp, 0.0_wp]
      contacts%time_step = 2.0_wp
      call reserve(contacts, 6)
      contacts%n = 6
      call for_each_variable(contacts, marker)
      variables = marker%n
      contacts%frozen_bound = [1.0_wp, 2.0_wp, 3.0_wp, 4.0_wp, 5.0_wp, 6.0_wp]
      contacts%fixed_motion = spread(contacts%frozen_bound, 1, 2)
      call copy_contacts(contacts, list, copy)
      marker = marker_type(expected=list)
      call for_each_variable(copy, marker)
      call check(marker%n == variables .and. copy%n == 3, 'all variables')
      call check(marker%equal, 'their values')
      call check(all(copy%frozen_bound == list) .and. all(copy%fixed_motion(2, :) == list), &
         'arrays of a step')
      call check(copy%time_step == 2.0_wp, 'time step')
   end subroutine some_contacts_are_copied

end module test_history
