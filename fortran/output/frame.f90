! SPDX-License-Identifier: GPL-3.0-or-later
!> Frame of the output as a row of numbers: variables of blocks and contacts.
!>
!> A frame is written to the journal in parts to save memory: it has over 500 bytes per block.
module dda_frame
   use dda_kinds, only: wp
   use dda_broken_faces, only: edge_damage
   use dda_contact_table, only: copy_column
   use dda_elements, only: block_stress, plastic_strain, stress_error
   use dda_errors, only: error_type
   use dda_journal, only: journal_type, begin_row, append_numbers, row_frame
   use dda_output_schema
   use dda_output_variables, only: families_of, is_in
   use dda_simulation, only: simulation_type
   implicit none
   private
   public :: append_frame

   integer, parameter :: columns_per_part = 512  !< columns or contacts per part

contains

   !> Append a frame, variable by variable, in the order of the schema: blocks, then contacts.
   subroutine append_frame(journal, simulation, error)
      type(journal_type), intent(inout) :: journal  !< journal of the run
      type(simulation_type), intent(in) :: simulation  !< simulation at its present time
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      logical :: has(number_of_families)
      integer :: i

      has = families_of(simulation)
      associate (contacts => simulation%contacts(simulation%now), all => output_variables)
         call begin_row(journal, row_frame, contacts%n, error)
         do i = 1, size(all)
            if (is_in(all(i), each_frame, has(all(i)%family))) &
               call append_variable(journal, simulation, i, error)
         end do
         do i = 1, size(all)
            if (is_in(all(i), each_contact, has(all(i)%family))) &
               call append_column(journal, simulation, i, error)
         end do
      end associate
   end subroutine append_frame

   !> Append a variable of the run or of its blocks.
   subroutine append_variable(journal, simulation, variable, error)
      type(journal_type), intent(inout) :: journal  !< journal of the run
      type(simulation_type), intent(in) :: simulation  !< simulation at its present time
      integer, intent(in) :: variable               !< position of the variable in the schema
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      associate (blocks => simulation%blocks, elements => simulation%elements, &
         origin => simulation%model%origin)
         select case (variable)
         case (out_frame, out_frame_time)
            call append_numbers(journal, [simulation%time], 1, error)
         case (out_frame_stage)
            call append_numbers(journal, [real(simulation%stage, wp)], 1, error)
         case (out_frame_base)
            call append_numbers(journal, simulation%maxima%base%displacement, 2, error)
         case (out_block_coordinates)
            call append_positions(journal, blocks%position, origin, error)
         case (out_block_rates)
            call append_numbers(journal, blocks%velocity, size(blocks%velocity), error)
         case (out_block_stress)
            call append_numbers(journal, block_stress(elements, blocks), 3*blocks%n, error)
         case (out_vertices)
            call append_positions(journal, blocks%vertex, origin, error)
         case (out_block_stress_error)
            call append_numbers(journal, stress_error(elements, blocks), blocks%n, error)
         case (out_block_plastic_strain)
            call append_numbers(journal, plastic_strain(elements, blocks), blocks%n, error)
         case (out_edge_damage)
            call append_numbers(journal, edge_damage(elements, simulation%model%welds, &
               size(blocks%owner)), size(blocks%owner), error)
         end select
      end associate
   end subroutine append_variable

   !> Append columns; the origin is added to their first two values, which are a position.
   subroutine append_positions(journal, columns, origin, error)
      type(journal_type), intent(inout) :: journal  !< journal of the run
      real(wp), intent(in) :: columns(:,:)  !< [≤ 6, columns] values; first two: position, m
      real(wp), intent(in) :: origin(2)  !< origin of the positions, m
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      real(wp) :: buffer(6*columns_per_part)
      integer :: rows, first, n, i, at

      rows = size(columns, 1)
      do first = 1, size(columns, 2), columns_per_part
         n = min(columns_per_part, size(columns, 2) - first + 1)
         do i = 1, n
            at = rows*(i - 1)
            buffer(at + 1:at + rows) = columns(:, first + i - 1)
            buffer(at + 1:at + 2) = buffer(at + 1:at + 2) + origin
         end do
         call append_numbers(journal, buffer, rows*n, error)
      end do
   end subroutine append_positions

   !> Append a variable of all contacts.
   subroutine append_column(journal, simulation, variable, error)
      type(journal_type), intent(inout) :: journal  !< journal of the run
      type(simulation_type), intent(in) :: simulation  !< simulation at its present time
      integer, intent(in) :: variable  !< position of the variable in the schema
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      real(wp) :: buffer(columns_per_part)
      integer :: first, n

      associate (contacts => simulation%contacts(simulation%now))
         do first = 1, contacts%n, columns_per_part
            n = min(columns_per_part, contacts%n - first + 1)
            call copy_column(contacts, simulation%laws, variable, first, buffer(:n))
            call append_numbers(journal, buffer, n, error)
         end do
      end associate
   end subroutine append_column

end module dda_frame
