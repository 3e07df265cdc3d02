! SPDX-License-Identifier: GPL-3.0-or-later
!> Table of the variables of contacts, for the output and for programs that step a run.
module dda_contact_table
   use dda_kinds, only: wp
   use dda_contact, only: contacts_type
   use dda_friction, only: laws_type
   use dda_joint_law, only: weakened
   use dda_output_schema
   use dda_output_variables, only: families_of
   use dda_simulation, only: simulation_type
   implicit none
   private
   public :: contact_table, closed_contacts, copy_column

contains

   !> Copy a variable of successive contacts.
   pure subroutine copy_column(contacts, laws, variable, first, column)
      type(contacts_type), intent(in) :: contacts  !< contacts of the last step
      type(laws_type), intent(in) :: laws          !< laws of the joints
      integer, intent(in) :: variable  !< position of the variable in the schema
      integer, intent(in) :: first   !< first contact
      real(wp), intent(out) :: column(:)  !< [contacts] values
      integer :: last

      last = first + size(column) - 1
      select case (variable)
      case (out_contact_vertex); column = contacts%vertex(first:last) - 1
      case (out_contact_edge); column = contacts%edge(first:last) - 1
      case (out_contact_state); column = contacts%state(first:last)
      case (out_contact_bonded); column = merge(1, 0, contacts%bonded(first:last))
      case (out_contact_joint); column = contacts%joint(first:last) - 1
      case (out_contact_gap); column = contacts%new_gap(first:last) + contacts%offset(first:last)
      case (out_contact_normal_force); column = contacts%normal_force(first:last)
      case (out_contact_shear_force); column = contacts%shear_force(first:last)
      case (out_contact_stretch); column = contacts%stretch(first:last)
      case (out_contact_length); column = contacts%length(first:last)
      case (out_contact_damage); column = contacts%memory(weakened, first:last)
      case (out_contact_place); column = contacts%fraction(first:last)
      case default; column = contacts%memory(findloc(laws%columns%name, &
         output_variables(variable)%name(9:), 1), first:last)
      end select
   end subroutine copy_column

   !> Table of the contacts of the last step; columns of laws that the model lacks are 0.
   function contact_table(simulation) result(table)
      type(simulation_type), intent(in) :: simulation  !< simulation at its present time
      real(wp), allocatable :: table(:,:)   !< [contacts, columns]
      logical :: has(number_of_families)
      integer :: i

      has = families_of(simulation)
      associate (contacts => simulation%contacts(simulation%now))
         allocate (table(contacts%n, size(contact_columns)), source=0.0_wp)
         do i = 1, size(contact_columns)
            if (has(output_variables(contact_columns(i))%family)) &
               call copy_column(contacts, simulation%laws, contact_columns(i), 1, table(:, i))
         end do
      end associate
   end function contact_table

   !> Table of contacts under compression.
   !> Columns: vertex and edge (from 0), fraction of the edge, normal and shear force, N/m.
   function closed_contacts(simulation) result(table)
      type(simulation_type), intent(in) :: simulation  !< simulation at its present time
      real(wp), allocatable :: table(:,:)   !< [contacts, 5]
      integer, allocatable :: compressed(:)
      logical :: has(number_of_families)
      integer :: i

      associate (contacts => simulation%contacts(simulation%now))
         compressed = pack([(i, i=1, contacts%n)], contacts%normal_force(:contacts%n) > 0.0_wp)
         allocate (table(size(compressed), 5), source=0.0_wp)
         table(:, 1) = contacts%vertex(compressed) - 1
         table(:, 2) = contacts%edge(compressed) - 1
         has = families_of(simulation)
         if (has(in_contacts_between_corners)) table(:, 3) = contacts%fraction(compressed)
         table(:, 4) = contacts%normal_force(compressed)
         table(:, 5) = contacts%shear_force(compressed)
      end associate
   end function closed_contacts

end module dda_contact_table
