! SPDX-License-Identifier: GPL-3.0-or-later
!> A frame of the output as a row of numbers: blocks and contacts.
!>
!> It goes to the journal part by part: the whole takes more than half a kilobyte a block.
module dda_frame
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type
   use dda_breaking, only: can_break
   use dda_broken_faces, only: edge_damage
   use dda_contact, only: contacts_type
   use dda_contact_table, only: contact_columns, take_column
   use dda_elements, only: block_stress, plastic_strain, stress_error
   use dda_errors, only: error_type
   use dda_journal, only: journal_type, begin_row, append_numbers, row_frame
   use dda_simulation, only: simulation_type
   implicit none
   private
   public :: append_frame

   integer, parameter :: at_once = 512       !< blocks, vertices or contacts

contains

   !> Time, stage; coordinates, rates [6, n]; stresses [3, n]; vertices [2, vertices]; of
   !> bodies, errors of stresses [n]; of what yields, plastic strains [n]; of what breaks, damage of
   !> edges [vertices]; contacts [contacts, columns].
   subroutine append_frame(journal, simulation, error)
      type(journal_type), intent(inout) :: journal  !< of the run
      type(simulation_type), intent(in) :: simulation  !< at its present time
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      integer :: i

      associate (contacts => simulation%contacts(simulation%now))
         call begin_row(journal, row_frame, contacts%n, error)
         call append_numbers(journal, [simulation%time, real(simulation%stage, wp)], 2, error)
         call append_blocks(journal, simulation%blocks, block_stress(simulation%elements, &
            simulation%blocks), simulation%model%origin, error)
         if (size(simulation%model%body_names) > 0) call append_numbers(journal, &
            stress_error(simulation%elements, simulation%blocks), simulation%blocks%n, error)
         if (any(simulation%model%materials%yields())) call append_numbers(journal, &
            plastic_strain(simulation%elements, simulation%blocks), simulation%blocks%n, error)
         if (can_break(simulation%model)) call append_numbers(journal, &
            edge_damage(simulation%elements, simulation%model%welds, &
            size(simulation%blocks%owner)), size(simulation%blocks%owner), error)
         do i = 1, contact_columns(simulation)
            call append_column(journal, contacts, i, error)
         end do
      end associate
   end subroutine append_frame

   !> Coordinates, rates, stresses and vertices.
   subroutine append_blocks(journal, blocks, stress, origin, error)
      type(journal_type), intent(inout) :: journal  !< of the run
      type(blocks_type), intent(in) :: blocks  !< in their places
      real(wp), intent(in) :: stress(:,:)  !< [3,n] Pa
      real(wp), intent(in) :: origin(2)  !< of the places, m
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays

      call append_places(journal, blocks%position, origin, error)
      call append_numbers(journal, blocks%velocity, size(blocks%velocity), error)
      call append_numbers(journal, stress, size(stress), error)
      call append_places(journal, blocks%vertex, origin, error)
   end subroutine append_blocks

   !> Columns whose first two numbers are a place from the engine's origin.
   subroutine append_places(journal, columns, origin, error)
      type(journal_type), intent(inout) :: journal  !< of the run
      real(wp), intent(in) :: columns(:,:)  !< [≤ 6, columns] m, …
      real(wp), intent(in) :: origin(2)  !< of the places, m
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      real(wp) :: part(6*at_once)
      integer :: rows, first, n, i, at

      rows = size(columns, 1)
      do first = 1, size(columns, 2), at_once
         n = min(at_once, size(columns, 2) - first + 1)
         do i = 1, n
            at = rows*(i - 1)
            part(at + 1:at + rows) = columns(:, first + i - 1)
            part(at + 1:at + 2) = part(at + 1:at + 2) + origin
         end do
         call append_numbers(journal, part, rows*n, error)
      end do
   end subroutine append_places

   !> A column of the contacts.
   subroutine append_column(journal, contacts, number, error)
      type(journal_type), intent(inout) :: journal  !< of the run
      type(contacts_type), intent(in) :: contacts  !< of the last step
      integer, intent(in) :: number  !< of the column
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      real(wp) :: part(at_once)
      integer :: first, n

      do first = 1, contacts%n, at_once
         n = min(at_once, contacts%n - first + 1)
         call take_column(contacts, number, first, part(:n))
         call append_numbers(journal, part, n, error)
      end do
   end subroutine append_column

end module dda_frame
