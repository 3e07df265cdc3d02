! SPDX-License-Identifier: GPL-3.0-or-later
!> Geometry of a contact: gap, normal, and the gradients of gap and slip.
module dda_contact_geometry
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type
   use dda_contact, only: contacts_type
   use dda_contact_gradients, only: set_gradient
   implicit none
   private
   public :: candidate_type, set_contacts, set_point, on_edge

   !> A contact found by detection but not yet listed.
   type :: candidate_type
      integer :: vertex   !< vertex that touches
      integer :: edge     !< touched edge, given by its first vertex
      integer :: corner   !< vertex of a contact of two corners, else 0
      integer :: pair     !< number of the near pair of the two blocks
   end type candidate_type

contains

   !> Append candidates to the list as contacts, from position `first` on.
   !>
   !> ∂gap/∂q is exact for the material point of the edge block at the foot.  ∂slip/∂q uses the
   !> vertex as lever arm of both blocks, so that the pair of shear forces has no moment.  The lever
   !> arm of the normal force is the same for both blocks.
   pure subroutine set_contacts(contacts, first, blocks, n, candidate)
      type(contacts_type), intent(inout) :: contacts   !< list with capacity for the candidates
      integer, intent(in) :: first                     !< position of the first candidate
      type(blocks_type), intent(in) :: blocks          !< present geometry
      integer, intent(in) :: n                         !< number of candidates
      type(candidate_type), intent(in) :: candidate(n) !< candidates in the order of the list
      real(wp) :: along(2), normal(2), from(2), reference(2)
      integer :: c, i, j, v, e

      do c = first, first + n - 1
         v = candidate(c - first + 1)%vertex
         e = candidate(c - first + 1)%edge
         i = blocks%owner(v)
         j = blocks%owner(e)
         along = blocks%along(:, e)
         normal = [along(2), -along(1)]
         from = blocks%vertex(:, v) - blocks%vertex(:, e)
         contacts%vertex(c) = v
         contacts%edge(c) = e
         contacts%corner(c) = candidate(c - first + 1)%corner
         contacts%block_v(c) = i
         contacts%block_e(c) = j
         contacts%pair(c) = candidate(c - first + 1)%pair
         contacts%gap(c) = dot_product(normal, from)
         contacts%normal(:, c) = normal
         call set_gradient(blocks%axes(:, :, i), blocks%vertex(:, v) - blocks%position(1:2, i), &
            blocks%reference(:, v), normal, contacts%gradient_v(:, c))
         reference = blocks%reference(:, e) + (blocks%reference(:, blocks%next(e)) &
            - blocks%reference(:, e))*(dot_product(from, along)/blocks%length(e))
         call set_gradient(blocks%axes(:, :, j), blocks%vertex(:, v) - blocks%position(1:2, j), &
            reference, normal, contacts%gradient_e(:, c))
      end do
   end subroutine set_contacts

   !> Set the geometry of contact c between an edge and a material point of the edge `vertex`.
   pure subroutine set_point(contacts, c, blocks, fraction)
      type(contacts_type), intent(inout) :: contacts  !< list of contacts
      integer, intent(in) :: c                        !< number of the contact
      type(blocks_type), intent(in) :: blocks         !< present geometry
      real(wp), intent(in) :: fraction                !< position as a fraction of the edge
      real(wp) :: here(2), from(2)

      associate (e => contacts%edge(c), f => contacts%vertex(c), i => contacts%block_v(c), &
         j => contacts%block_e(c), normal => contacts%normal(:, c))
         here = on_edge(blocks%vertex, f, blocks%next(f), fraction)
         from = here - blocks%vertex(:, e)
         contacts%fraction(c) = fraction
         contacts%gap(c) = dot_product(normal, from)
         call set_gradient(blocks%axes(:, :, i), here - blocks%position(1:2, i), &
            on_edge(blocks%reference, f, blocks%next(f), fraction), normal, &
            contacts%gradient_v(:, c))
         call set_gradient(blocks%axes(:, :, j), here - blocks%position(1:2, j), &
            on_edge(blocks%reference, e, blocks%next(e), &
            dot_product(from, blocks%along(:, e))/blocks%length(e)), normal, &
            contacts%gradient_e(:, c))
      end associate
   end subroutine set_point

   !> Return the position of a point on the edge between two vertices.
   pure function on_edge(vertices, first, last, fraction) result(point)
      real(wp), intent(in) :: vertices(:,:)  !< [2,vertices] m
      integer, intent(in) :: first, last     !< first and last vertex of the edge
      real(wp), intent(in) :: fraction       !< position as a fraction of the edge
      real(wp) :: point(2)

      point = vertices(:, first) + (vertices(:, last) - vertices(:, first))*fraction
   end function on_edge

end module dda_contact_geometry
