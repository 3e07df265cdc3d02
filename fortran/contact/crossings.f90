! SPDX-License-Identifier: GPL-3.0-or-later
!> Corners across a crossing of joints.
!>
!> At a crossing of joints, such as four blocks of a lattice or three at a step of its surface,
!> opposite blocks share a corner but no face.  Such a pair has no joint length, but its coinciding
!> corners could touch in the direction of either joint, and a spring across a slipping joint would
!> lock it.  Such corners therefore have no contact until their distance exceeds their size.  A
!> block that slides farther over a crossing touches the edge of the opposite block, with the gap
!> offset by the penetration at that time.
module dda_crossings
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type
   use dda_contact, only: contacts_type
   use dda_tributary, only: contact_overlap
   implicit none
   private
   public :: most_across, find_crossings, release_removed, release_separated

   integer, parameter :: most_across = 3        !< most corners opposite a vertex (six triangles)
   !> largest gap or overlap that counts as 0/edge length
   real(wp), parameter :: touching = 1.0e-6_wp

contains

   !> Find opposite corners at crossings and mark their contacts.
   !> Blocks of opposite corners have no common face; touching faces of other blocks connect them.
   pure subroutine find_crossings(contacts, blocks, across, is_opposite)
      type(contacts_type), intent(in) :: contacts   !< first list of the run
      type(blocks_type), intent(in) :: blocks       !< blocks in their first state
      integer, intent(inout) :: across(:,:)  !< [most_across,vertices] opposite vertices, else 0
      logical, intent(out) :: is_opposite(:)        !< [n] contacts of opposite corners
      logical :: joined(contacts%n), has_overlap(contacts%n)
      integer :: node(size(across, 2)), free_slot(2), c

      do c = 1, contacts%n
         associate (e => contacts%edge(c))
            has_overlap(c) = contact_overlap(blocks, e, contacts%vertex(c)) &
               > touching*blocks%length(e)
            joined(c) = has_overlap(c) .and. contacts%gap(c) <= touching*blocks%length(e)
         end associate
      end do
      call number_nodes(contacts, joined, node)
      is_opposite = .false.
      do c = 1, contacts%n
         associate (v => contacts%vertex(c), w => contacts%corner(c))
            if (has_overlap(c) .or. w == 0) cycle
            if (node(v) /= node(w)) cycle
            free_slot = [findloc(across(:, v), 0, 1), findloc(across(:, w), 0, 1)]
            is_opposite(c) = all(free_slot > 0)
            if (.not. is_opposite(c)) cycle
            across(free_slot(1), v) = w
            across(free_slot(2), w) = v
         end associate
      end do
   end subroutine find_crossings

   !> Assign a node number to each vertex; touching faces give coinciding corners the same node.
   pure subroutine number_nodes(contacts, joined, node)
      type(contacts_type), intent(in) :: contacts  !< first list of the run
      logical, intent(in) :: joined(:)             !< [n] contacts of touching faces
      integer, intent(out) :: node(:)              !< [vertices]
      logical :: changed
      integer :: c, v

      node = [(v, v=1, size(node))]
      changed = .true.
      do while (changed)
         changed = .false.
         do c = 1, contacts%n
            associate (v => contacts%vertex(c), w => contacts%corner(c))
               if (.not. joined(c) .or. w == 0) cycle
               if (node(v) == node(w)) cycle
               node([v, w]) = min(node(v), node(w))
               changed = .true.
            end associate
         end do
      end do
   end subroutine number_nodes

   !> Allow contacts of corners that were opposite to corners of removed blocks.
   pure subroutine release_removed(across, contacts, removed)
      integer, intent(inout) :: across(:,:)  !< [most_across,vertices or 0] opposite vertices or 0
      type(contacts_type), intent(in) :: contacts  !< contacts, including removed blocks
      logical, intent(in) :: removed(:)            !< [blocks]
      integer :: c

      if (size(across) == 0) return
      do c = 1, contacts%n
         if (.not. (removed(contacts%block_v(c)) .or. removed(contacts%block_e(c)))) cycle
         call allow_vertex_contacts(across, contacts%vertex(c))
         if (contacts%corner(c) > 0) call allow_vertex_contacts(across, contacts%corner(c))
      end do
   end subroutine release_removed

   !> Allow contacts at corners that have moved apart.
   pure subroutine release_separated(across, blocks, distance)
      integer, intent(inout) :: across(:,:)    !< [most_across,vertices or 0] opposite vertices or 0
      type(blocks_type), intent(in) :: blocks  !< present geometry
      real(wp), intent(in) :: distance         !< distance above the size of any corner, m
      integer :: v, i

      do v = 1, size(across, 2)
         do i = 1, size(across, 1)
            if (across(i, v) == 0) cycle
            if (norm2(blocks%vertex(:, v) - blocks%vertex(:, across(i, v))) > distance) &
               across(i, v) = 0
         end do
      end do
   end subroutine release_separated

   !> Allow contacts of a vertex with the corners across the crossing.
   pure subroutine allow_vertex_contacts(across, v)
      integer, intent(inout) :: across(:,:)  !< [most_across,vertices] opposite vertices, else 0
      integer, intent(in) :: v               !< vertex
      integer :: i

      do i = 1, size(across, 1)
         associate (w => across(i, v))
            if (w > 0) where (across(:, w) == v) across(:, w) = 0
         end associate
      end do
      across(:, v) = 0
   end subroutine allow_vertex_contacts

end module dda_crossings
