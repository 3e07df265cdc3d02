! SPDX-License-Identifier: GPL-3.0-or-later
!> A frame of the output as a row of numbers: blocks and contacts.
!>
!> It goes to the journal part by part, since the whole takes more than half a kilobyte a block.
module dda_frame
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type, stress_of
   use dda_contact, only: contacts_type
   use dda_errors, only: error_type
   use dda_journal, only: journal_type, begin_row, append_numbers, row_frame
   use dda_simulation, only: simulation_type
   implicit none
   private
   public :: most_columns, contact_columns, append_frame

   integer, parameter :: plain_columns = 9   !< of a contact
   integer, parameter :: most_columns = 12   !< of one under a joint law

contains

   !> Numbers of a contact.
   pure integer function contact_columns(simulation)
      type(simulation_type), intent(in) :: simulation  !< at its present time

      contact_columns = merge(plain_columns, most_columns, simulation%laws%plain)
   end function contact_columns

   !> Time, stage; coordinates, rates [6, n]; stresses [3, n]; vertices [2, vertices]; contacts
   !> [contacts, columns].
   subroutine append_frame(journal, simulation, error)
      type(journal_type), intent(inout) :: journal  !< of the run
      type(simulation_type), intent(in) :: simulation  !< at its present time
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      integer :: i

      associate (contacts => simulation%contacts(simulation%now))
         call begin_row(journal, row_frame, contacts%n, error)
         call append_numbers(journal, [simulation%time, real(simulation%stage, wp)], 2, error)
         call append_blocks(journal, simulation%blocks, simulation%model%origin, error)
         do i = 1, contact_columns(simulation)
            call append_numbers(journal, column_of(contacts, i), contacts%n, error)
         end do
      end associate
   end subroutine append_frame

   !> Coordinates, rates, stresses and vertices.
   subroutine append_blocks(journal, blocks, origin, error)
      type(journal_type), intent(inout) :: journal  !< of the run
      type(blocks_type), intent(in) :: blocks  !< in their places
      real(wp), intent(in) :: origin(2)  !< of the places, m
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      real(wp), allocatable :: part(:,:)
      integer :: b

      part = blocks%position
      do b = 1, blocks%n
         part(:2, b) = part(:2, b) + origin
      end do
      call append_numbers(journal, part, size(part), error)
      call append_numbers(journal, blocks%velocity, size(blocks%velocity), error)
      deallocate (part)
      allocate (part(3, blocks%n))
      do b = 1, blocks%n
         part(:, b) = stress_of(blocks, b)
      end do
      call append_numbers(journal, part, size(part), error)
      part = blocks%vertex
      do b = 1, size(part, 2)
         part(:, b) = part(:, b) + origin
      end do
      call append_numbers(journal, part, size(part), error)
   end subroutine append_blocks

   !> Vertex and edge from 0, state, bonded, joint from 0; distance, normal force, shear force,
   !> stretch; under a joint law also length, slip path, weakening.
   pure function column_of(contacts, number) result(column)
      type(contacts_type), intent(in) :: contacts  !< of the last step
      integer, intent(in) :: number  !< of the column
      real(wp) :: column(contacts%n)

      associate (n => contacts%n)
         select case (number)
         case (1); column = contacts%vertex(:n) - 1
         case (2); column = contacts%edge(:n) - 1
         case (3); column = contacts%state(:n)
         case (4); column = merge(1, 0, contacts%bonded(:n))
         case (5); column = contacts%joint(:n) - 1
         case (6); column = contacts%new_gap(:n) + contacts%offset(:n)
         case (7); column = contacts%normal_force(:n)
         case (8); column = contacts%shear_force(:n)
         case (9); column = contacts%stretch(:n)
         case (10); column = contacts%length(:n)
         case (11); column = contacts%slip_path(:n)
         case (12); column = contacts%weakened(:n)
         end select
      end associate
   end function column_of

end module dda_frame
