! SPDX-License-Identifier: GPL-3.0-or-later
!> Joint material of each contact, determined from the edges that touch.
!>
!> Each edge of a block has a joint.  A contact lies on the touched edge, and on the more nearly
!> parallel one of the two edges at its vertex; the weaker one of these two joints governs
!> (`weaker_joint`).  If both edges at the vertex make the same angle with the
!> touched edge, the weakest of the three joints governs.  The result depends neither on the order
!> of the blocks nor on which of two touching faces has the vertex.
!>
!> A closed contact retains an earlier joint in three cases:
!>
!> - The contact is bonded.
!> - The joint is that of the less parallel edge at the vertex, and the angle of this edge is at
!>   most twice the angle of the other.  A block that rocks on a corner then changes its joint only
!>   once, when it topples.
!> - The joint is that of a neighbour of the touched edge, and the vertex is near their common
!>   corner: within twice the penetration if it slides, within the size of the corner if it sticks.
!>   A vertex that vibrates about the end of an edge, or whose contact alternates between two edges,
!>   then does not change its joint.
!>
!> Of two edges in one straight line, the touched edge is the one that contains the foot.
module dda_contact_joints
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type
   use dda_contact, only: contacts_type, is_point, contact_open, contact_stick
   use dda_detection, only: detection_type, tolerance_of
   use dda_entrance, only: choice_type, project_vertex
   use dda_friction, only: laws_type, weaker_joint
   use dda_ordered_sums, only: pieces, first_of, last_of, parallel_from
   implicit none
   private
   public :: set_joints

   real(wp), parameter :: same_angle = 1.0e-6_wp  !< largest difference of equal sines
   real(wp), parameter :: straight = 0.9986_wp    !< cosine of 3°

contains

   !> Set the joints of all contacts; on entry `joint` is the joint in the last step, or 0.
   !> One joint material needs no test.
   subroutine set_joints(contacts, blocks, laws, detection)
      type(contacts_type), intent(inout) :: contacts  !< with history
      type(blocks_type), intent(in) :: blocks         !< present geometry
      type(laws_type), intent(in) :: laws             !< strengths of the joint materials
      type(detection_type), intent(in) :: detection   !< penetrations and sizes of corners
      integer :: p

      if (size(laws%friction) == 1) then
         contacts%joint(:contacts%n) = 1
         return
      end if
      if (contacts%n < parallel_from) then
         call set_joints_range(contacts, blocks, laws, detection, 1, contacts%n)
         return
      end if
      !$omp parallel do schedule(static)
      do p = 1, pieces(contacts%n)
         call set_joints_range(contacts, blocks, laws, detection, first_of(p, contacts%n), &
            last_of(p, contacts%n))
      end do
   end subroutine set_joints

   !> Set the joints of contacts first … last; if all edges have one joint, no test is needed.
   pure subroutine set_joints_range(contacts, blocks, laws, detection, first, last)
      type(contacts_type), intent(inout) :: contacts  !< with history
      type(blocks_type), intent(in) :: blocks         !< present geometry
      type(laws_type), intent(in) :: laws             !< strengths of the joint materials
      type(detection_type), intent(in) :: detection   !< penetrations and sizes of corners
      integer, intent(in) :: first, last              !< first and last contact
      integer :: c

      do c = first, last
         if (is_point(contacts, c)) then
            if (.not. contacts%bonded(c)) contacts%joint(c) = weaker_joint(laws, &
               blocks%joint(contacts%vertex(c)), blocks%joint(contacts%edge(c)))
         else if (blocks%mixed(contacts%block_v(c)) .or. blocks%mixed(contacts%block_e(c))) then
            contacts%joint(c) = governing_joint(contacts, c, blocks, laws, detection)
         else
            contacts%joint(c) = weaker_joint(laws, blocks%joint(contacts%vertex(c)), &
               blocks%joint(contacts%edge(c)))
         end if
      end do
   end subroutine set_joints_range

   !> Return the joint of contact c, from the touching edges and the joint in the last step.
   pure integer function governing_joint(contacts, c, blocks, laws, detection) result(joint)
      type(contacts_type), intent(in) :: contacts    !< with history
      integer, intent(in) :: c                       !< contact
      type(blocks_type), intent(in) :: blocks        !< present geometry
      type(laws_type), intent(in) :: laws            !< strengths of the joint materials
      type(detection_type), intent(in) :: detection  !< penetrations and sizes of corners
      integer :: touched(2), vertex_edges(2), last_joint, i, k, n_touched, n_vertex_edges
      real(wp) :: sine(2)

      last_joint = contacts%joint(c)
      call list_touched_edges(contacts, c, blocks, detection, touched, n_touched)
      call list_vertex_edges(contacts, c, blocks, vertex_edges, sine)
      joint = weaker_joint(laws, blocks%joint(touched(1)), blocks%joint(vertex_edges(1)))
      if (sine(2) - sine(1) <= same_angle) joint = weaker_joint(laws, joint, &
         blocks%joint(vertex_edges(2)))
      if (last_joint == 0 .or. contacts%state(c) == contact_open) return
      n_vertex_edges = merge(2, 1, sine(2) <= 2*sine(1) + same_angle)
      if (contacts%bonded(c)) joint = last_joint
      do i = 1, n_touched
         do k = 1, n_vertex_edges
            if (weaker_joint(laws, blocks%joint(touched(i)), blocks%joint(vertex_edges(k))) &
               == last_joint) &
               joint = last_joint
         end do
      end do
   end function governing_joint

   !> List the touched edge, and its neighbour if the vertex is within the corner that they share.
   pure subroutine list_touched_edges(contacts, c, blocks, detection, edge, n)
      type(contacts_type), intent(in) :: contacts    !< with history
      integer, intent(in) :: c                       !< contact
      type(blocks_type), intent(in) :: blocks        !< present geometry
      type(detection_type), intent(in) :: detection  !< penetrations and sizes of corners
      integer, intent(out) :: edge(2)                !< edges; the first one is touched
      integer, intent(out) :: n                      !< number of edges that may be touched, 1 or 2
      type(choice_type) :: choice
      real(wp) :: size
      integer :: corner

      call project_vertex(blocks, contacts%vertex(c), contacts%edge(c), choice)
      edge = [choice%edge, blocks%previous(choice%edge)]
      corner = choice%edge
      if (choice%past_end) corner = blocks%next(choice%edge)
      if (choice%past_end) edge(2) = corner
      if (choice%overshoot > 0.0_wp) then
         if (dot_product(blocks%along(:, edge(1)), blocks%along(:, edge(2))) > straight) &
            edge = edge([2, 1])
      end if
      size = tolerance_of(detection, choice%vertex, corner)
      if (contacts%state(c) == contact_stick) &
         size = min(detection%corner(choice%vertex), detection%corner(corner))
      n = merge(2, 1, abs(choice%overshoot) <= size)
   end subroutine list_touched_edges

   !> List the two edges at the vertex, the one more nearly parallel to the touched edge first.
   pure subroutine list_vertex_edges(contacts, c, blocks, edge, sine)
      type(contacts_type), intent(in) :: contacts  !< with geometry
      integer, intent(in) :: c                     !< contact
      type(blocks_type), intent(in) :: blocks      !< present geometry
      integer, intent(out) :: edge(2)              !< edges, given by their first vertices
      real(wp), intent(out) :: sine(2)  !< sines of their angles with the touched edge, ≥ 0
      integer :: k

      edge = [contacts%vertex(c), blocks%previous(contacts%vertex(c))]
      do k = 1, 2
         sine(k) = abs(dot_product(contacts%normal(:, c), blocks%along(:, edge(k))))
      end do
      if (sine(2) >= sine(1)) return
      edge = edge([2, 1])
      sine = sine([2, 1])
   end subroutine list_vertex_edges

end module dda_contact_joints
