!> The state of the contacts: the last step's list, and the neighbours that the next ones are found among.
module dda_contact_state
   use dda_archive, only: archive_type, carry, carry_count, carry_label, carry_list, check_list
   use dda_blocks, only: blocks_type
   use dda_contact, only: contacts_type, reserve
   use dda_neighbours, only: neighbours_type
   implicit none
   private
   public :: carry_contacts, carry_neighbours

contains

   !> All of a list: the next step inherits from it, and frames are written from it.
   subroutine carry_contacts(archive, contacts, blocks, neighbours, joints)
      type(archive_type), intent(inout) :: archive
      type(contacts_type), intent(inout) :: contacts
      type(blocks_type), intent(in) :: blocks
      type(neighbours_type), intent(in) :: neighbours
      integer, intent(in) :: joints  !< joint materials
      integer :: n, vertices

      call carry_label(archive, 'contacts')
      call carry_count(archive, contacts%n)
      n = contacts%n
      vertices = size(blocks%owner)
      if (archive%reading) call reserve(contacts, n)
      call carry_list(archive, contacts%vertex(:n), 1, vertices)
      call carry_list(archive, contacts%edge(:n), 1, vertices)
      call carry_list(archive, contacts%corner(:n), 0, vertices)
      call carry_list(archive, contacts%block_v(:n), 1, blocks%n)
      call carry_list(archive, contacts%block_e(:n), 1, blocks%n)
      call carry_list(archive, contacts%pair(:n), 1, neighbours%n_pairs)
      call carry_list(archive, contacts%joint(:n), 1, joints)
      call carry_geometry(archive, contacts, n)
      call carry_history(archive, contacts, n)
      call carry_answers(archive, contacts, n)
   end subroutine carry_contacts

   subroutine carry_geometry(archive, contacts, n)
      type(archive_type), intent(inout) :: archive
      type(contacts_type), intent(inout) :: contacts
      integer, intent(in) :: n

      call carry(archive, contacts%gap(:n))
      call carry(archive, contacts%normal(:, :n))
      call carry(archive, contacts%normal_v(:, :n))
      call carry(archive, contacts%normal_e(:, :n))
      call carry(archive, contacts%shear_v(:, :n))
      call carry(archive, contacts%shear_e(:, :n))
   end subroutine carry_geometry

   subroutine carry_history(archive, contacts, n)
      type(archive_type), intent(inout) :: archive
      type(contacts_type), intent(inout) :: contacts
      integer, intent(in) :: n

      call carry(archive, contacts%state(:n))
      call carry(archive, contacts%bonded(:n))
      call carry(archive, contacts%was_bonded(:n))
      call carry(archive, contacts%was_closed(:n))
      call carry(archive, contacts%offset(:n))
      call carry(archive, contacts%bond_length(:n))
      call carry(archive, contacts%pressure(:n))
      call carry(archive, contacts%stretch(:n))
   end subroutine carry_history

   subroutine carry_answers(archive, contacts, n)
      type(archive_type), intent(inout) :: archive
      type(contacts_type), intent(inout) :: contacts
      integer, intent(in) :: n

      call carry(archive, contacts%slide_force(:n))
      call carry(archive, contacts%direction(:n))
      call carry(archive, contacts%slide_slip(:n))
      call carry(archive, contacts%unrest(:n))
      call carry(archive, contacts%closings(:n))
      call carry(archive, contacts%answer(:n))
      call carry(archive, contacts%new_gap(:n))
      call carry(archive, contacts%slip(:n))
      call carry(archive, contacts%opening(:n))
      call carry(archive, contacts%slipping(:n))
      call carry(archive, contacts%overload(:n))
      call carry(archive, contacts%normal_force(:n))
      call carry(archive, contacts%shear_force(:n))
   end subroutine carry_answers

   !> Pairs and probes of the last search, which the geometry of now would not give again.
   subroutine carry_neighbours(archive, neighbours, blocks)
      type(archive_type), intent(inout) :: archive
      type(neighbours_type), intent(inout) :: neighbours
      type(blocks_type), intent(in) :: blocks
      integer :: pairs, probes, edges

      call carry_label(archive, 'neighbours')
      edges = neighbours%first_edge(neighbours%n_probes + 1) - 1
      call carry_count(archive, neighbours%n_pairs)
      call carry_count(archive, neighbours%n_probes)
      call carry_count(archive, edges)
      pairs = neighbours%n_pairs
      probes = neighbours%n_probes
      if (archive%reading) then
         deallocate (neighbours%pair, neighbours%probe, neighbours%first_edge, neighbours%edge)
         allocate (neighbours%pair(2, pairs), neighbours%probe(2, probes), neighbours%first_edge(probes + 1), source=1)
         allocate (neighbours%edge(edges), source=1)
      end if
      call carry(archive, neighbours%pair(:, :pairs))
      call check_list(archive, neighbours%pair(1, :pairs), 1, blocks%n)
      call check_list(archive, neighbours%pair(2, :pairs), 1, blocks%n)
      call carry(archive, neighbours%probe(:, :probes))
      call check_list(archive, neighbours%probe(1, :probes), 1, size(blocks%owner))
      call check_list(archive, neighbours%probe(2, :probes), 1, pairs)
      call carry_list(archive, neighbours%first_edge(:probes + 1), 1, edges + 1)
      call carry_list(archive, neighbours%edge(:edges), 1, size(blocks%owner))
      call carry(archive, neighbours%reach)
      call carry(archive, neighbours%travel)
   end subroutine carry_neighbours

end module dda_contact_state
