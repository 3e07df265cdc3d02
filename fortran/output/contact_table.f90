! SPDX-License-Identifier: GPL-3.0-or-later
!> The columns of contacts, for the output and for who steps a run: their names and their numbers.
module dda_contact_table
   use dda_kinds, only: wp
   use dda_contact, only: contacts_type
   use dda_netcdf_calls, only: variable_type
   use dda_simulation, only: simulation_type
   use netcdf, only: nf90_double, nf90_int
   implicit none
   private
   public :: contact_variables, contact_columns, contact_table, closed_contacts, &
      take_column, whole_columns

   integer, parameter :: whole_columns = 5   !< of whole numbers, the first ones
   integer, parameter :: plain_columns = 9   !< of a contact
   integer, parameter :: law_columns = 12    !< of one under a joint law
   integer, parameter :: point_columns = 13  !< of one that may be between corners
   integer, parameter :: most_columns = 16   !< of one whose bond may be damaged

   !> Contact states of all frames, one after the other: the frame, then the columns of
   !> `take_column`.
   type(variable_type), parameter :: contact_variables(0:most_columns) = [ &
      variable_type('contact_frame', nf90_int, 'contact', '1', 'frame, from 0'), &
      variable_type('contact_vertex', nf90_int, 'contact', '1', 'vertex that touches, from 0'), &
      variable_type('contact_edge', nf90_int, 'contact', '1', &
         'edge touched, by its first vertex, from 0'), &
      variable_type('contact_state', nf90_int, 'contact', '1', '0 open, 1 slide, 2 stick'), &
      variable_type('contact_bonded', nf90_int, 'contact', '1', &
         '1 while cohesion and tension hold'), &
      variable_type('contact_joint', nf90_int, 'contact', '1', 'joint material, from 0'), &
      variable_type('contact_gap', nf90_double, 'contact', 'm', 'gap, negative is penetration'), &
      variable_type('contact_normal_force', nf90_double, 'contact', 'N/m', &
         'compression positive'), &
      variable_type('contact_shear_force', nf90_double, 'contact', 'N/m', 'resists slip'), &
      variable_type('contact_stretch', nf90_double, 'contact', 'm', 'elastic shear stretch'), &
      variable_type('contact_length', nf90_double, 'contact', 'm', &
         'length of joint that the contact stands for'), &
      variable_type('contact_slip_path', nf90_double, 'contact', 'm', &
         'slip beyond the elastic one, both ways added up'), &
      variable_type('contact_weakened', nf90_double, 'contact', '1', &
         '0 at peak strength, 1 at residual strength'), &
      variable_type('contact_place', nf90_double, 'contact', '1', &
         'share of the edge that begins at the vertex, before the point that touches'), &
      variable_type('contact_damage', nf90_double, 'contact', '1', &
         '0 whole bond of a cohesive joint, 1 contact alone'), &
      variable_type('contact_fracture_energy_lower', nf90_double, 'contact', 'N/m', &
         'lower bound of the fracture energy spent, per area'), &
      variable_type('contact_fracture_energy_upper', nf90_double, 'contact', 'N/m', &
         'upper bound of the fracture energy spent, per area')]

contains

   !> Numbers of a contact.
   pure integer function contact_columns(simulation)
      type(simulation_type), intent(in) :: simulation  !< at its present time

      contact_columns = merge(plain_columns, law_columns, simulation%laws%plain)
      if (simulation%laws%pointed) contact_columns = point_columns
      if (simulation%laws%cohesive) contact_columns = most_columns
   end function contact_columns

   !> Vertex and edge from 0, state, bonded, joint from 0; distance, normal force, shear force,
   !> stretch; under a joint law also length, slip path, weakening; with points between corners,
   !> place; with cohesive joints, damage and bounds of the fracture energy.
   pure subroutine take_column(contacts, number, first, column)
      type(contacts_type), intent(in) :: contacts  !< of the last step
      integer, intent(in) :: number  !< of the column
      integer, intent(in) :: first   !< contact
      real(wp), intent(out) :: column(:)  !< [contacts from the first]
      integer :: last

      last = first + size(column) - 1
      select case (number)
      case (1); column = contacts%vertex(first:last) - 1
      case (2); column = contacts%edge(first:last) - 1
      case (3); column = contacts%state(first:last)
      case (4); column = merge(1, 0, contacts%bonded(first:last))
      case (5); column = contacts%joint(first:last) - 1
      case (6); column = contacts%new_gap(first:last) + contacts%offset(first:last)
      case (7); column = contacts%normal_force(first:last)
      case (8); column = contacts%shear_force(first:last)
      case (9); column = contacts%stretch(first:last)
      case (10); column = contacts%length(first:last)
      case (11); column = contacts%slip_path(first:last)
      case (12); column = contacts%weakened(first:last)
      case (13); column = contacts%fraction(first:last)
      case (14); column = contacts%weakened(first:last)
      case (15:16); column = contacts%spent(number - 14, first:last)
      end select
   end subroutine take_column

   !> All columns of the contacts of the last step; those that no joint has are 0.
   function contact_table(simulation) result(table)
      type(simulation_type), intent(in) :: simulation  !< at its present time
      real(wp), allocatable :: table(:,:)   !< [contacts, columns]
      integer :: i

      associate (contacts => simulation%contacts(simulation%now))
         allocate (table(contacts%n, most_columns), source=0.0_wp)
         do i = 1, contact_columns(simulation)
            call take_column(contacts, i, 1, table(:, i))
         end do
      end associate
   end function contact_table

   !> Contacts that press: vertex and edge from 0, place, normal force, shear force.
   function closed_contacts(simulation) result(table)
      type(simulation_type), intent(in) :: simulation  !< at its present time
      real(wp), allocatable :: table(:,:)   !< [contacts, 5]
      integer, allocatable :: closed(:)
      integer :: i

      associate (contacts => simulation%contacts(simulation%now))
         closed = pack([(i, i=1, contacts%n)], contacts%normal_force(:contacts%n) > 0.0_wp)
         allocate (table(size(closed), 5), source=0.0_wp)
         table(:, 1) = contacts%vertex(closed) - 1
         table(:, 2) = contacts%edge(closed) - 1
         if (contact_columns(simulation) >= point_columns) table(:, 3) = contacts%fraction(closed)
         table(:, 4) = contacts%normal_force(closed)
         table(:, 5) = contacts%shear_force(closed)
      end associate
   end function closed_contacts

end module dda_contact_table
