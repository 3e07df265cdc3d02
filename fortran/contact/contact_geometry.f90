!> A contact that was found: its gap, its normal, and the rows that move gap and slip.
module dda_contact_geometry
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type
   use dda_contact, only: contacts_type
   implicit none
   private
   public :: find_type, set_contacts

   !> A contact that was found.
   type :: find_type
      integer :: vertex, edge
      integer :: corner        !< vertex met corner to corner, else 0
      integer :: pair          !< which near pair the two blocks are
   end type find_type

contains

   !> What was found becomes contacts from place `first` on.
   pure subroutine set_contacts(contacts, first, blocks, n, find)
      type(contacts_type), intent(inout) :: contacts
      integer, intent(in) :: first
      type(blocks_type), intent(in) :: blocks
      integer, intent(in) :: n
      type(find_type), intent(in) :: find(n)
      integer :: k

      do k = 1, n
         call set_contact(contacts, first + k - 1, blocks, find(k))
      end do
   end subroutine set_contacts

   !> A contact with its gap and the rows that move gap and slip.
   !>
   !> ∂gap/∂q is exact with the edge block's material point at the foot; ∂slip/∂q with its rotation
   !> taken at the vertex, so that the pair of shear forces carries no moment.
   pure subroutine set_contact(contacts, c, blocks, find)
      type(contacts_type), intent(inout) :: contacts
      integer, intent(in) :: c
      type(blocks_type), intent(in) :: blocks
      type(find_type), intent(in) :: find
      real(wp) :: along(2), normal(2), from(2), gap, reach(2), reference(2)
      integer :: i, j

      i = blocks%owner(find%vertex)
      j = blocks%owner(find%edge)
      along = blocks%along(:, find%edge)
      normal = [along(2), -along(1)]
      from = blocks%vertex(:, find%vertex) - blocks%vertex(:, find%edge)
      gap = dot_product(normal, from)
      contacts%vertex(c) = find%vertex
      contacts%edge(c) = find%edge
      contacts%corner(c) = find%corner
      contacts%block_v(c) = i
      contacts%block_e(c) = j
      contacts%pair(c) = find%pair
      contacts%gap(c) = gap
      contacts%normal(:, c) = normal
      reach = blocks%vertex(:, find%vertex) - blocks%position(1:2, i)
      call set_rows(blocks%axes(:, :, i), reach, reach, blocks%reference(:, find%vertex), normal, &
         contacts%normal_v(:, c), contacts%shear_v(:, c))
      reach = blocks%vertex(:, find%vertex) - blocks%position(1:2, j)
      reference = blocks%reference(:, find%edge) + (blocks%reference(:, blocks%next(find%edge)) &
         - blocks%reference(:, find%edge))*(dot_product(from, along)/blocks%length(find%edge))
      call set_rows(blocks%axes(:, :, j), reach - gap*normal, reach, reference, normal, &
         contacts%normal_e(:, c), contacts%shear_e(:, c))
   end subroutine set_contact

   !> What moves a material point along the normal, and along the edge (`direction_row`, for both).
   pure subroutine set_rows(axes, foot, reach, reference, normal, normal_row, shear_row)
      real(wp), intent(in) :: axes(2, 2)
      !> present offsets that turn the normal and the shear force
      real(wp), intent(in) :: foot(2), reach(2)
      real(wp), intent(in) :: reference(2), normal(2)
      real(wp), intent(out) :: normal_row(6), shear_row(6)
      real(wp) :: x, y

      x = axes(1, 1)*normal(1) + axes(2, 1)*normal(2)
      y = axes(1, 2)*normal(1) + axes(2, 2)*normal(2)
      normal_row = [normal(1), normal(2), normal(2)*foot(1) - normal(1)*foot(2), &
         x*reference(1), y*reference(2), 0.5_wp*(x*reference(2) + y*reference(1))]
      shear_row = [-normal(2), normal(1), normal(1)*reach(1) + normal(2)*reach(2), &
         -y*reference(1), x*reference(2), 0.5_wp*(x*reference(1) - y*reference(2))]
   end subroutine set_rows

end module dda_contact_geometry
