! SPDX-License-Identifier: GPL-3.0-or-later
!> State of the contacts: the list of the last step, and the neighbours among which the next
!> contacts are found.
module dda_contact_state
   use dda_archive, only: archive_type, serialise, serialise_count, serialise_label, &
      serialise_list, check_list
   use dda_blocks, only: blocks_type
   use dda_contact, only: contacts_type, operation_type, for_each_variable, reserve
   use dda_kinds, only: wp
   use dda_neighbours, only: neighbours_type
   implicit none
   private
   public :: serialise_contacts, serialise_neighbours

   !> Write the arrays to an archive, or read them from it.
   type, extends(operation_type) :: serialisation_type
      integer :: n                              !< contacts
      type(archive_type), pointer :: archive => null()
   contains
      procedure :: apply => serialise_variable
   end type serialisation_type

contains

   !> Save or restore the complete list: the next step inherits from it, and frames contain it.
   subroutine serialise_contacts(archive, contacts, blocks, neighbours, joints)
      type(archive_type), target, intent(inout) :: archive  !< written or read
      type(contacts_type), intent(inout) :: contacts        !< list, replaced when read
      type(blocks_type), intent(in) :: blocks               !< of the model
      type(neighbours_type), intent(in) :: neighbours       !< already written or read
      integer, intent(in) :: joints                         !< joint materials
      type(serialisation_type) :: serialisation
      integer :: n, vertices

      call serialise_label(archive, 'contacts')
      call serialise_count(archive, contacts%n)
      n = contacts%n
      vertices = size(blocks%owner)
      if (archive%reading) call reserve(contacts, n)
      serialisation%n = n
      serialisation%archive => archive
      call for_each_variable(contacts, serialisation)
      call check_list(archive, contacts%vertex(:n), 1, vertices)
      call check_list(archive, contacts%edge(:n), 1, vertices)
      call check_list(archive, contacts%corner(:n), 0, vertices)
      call check_list(archive, contacts%block_v(:n), 1, blocks%n)
      call check_list(archive, contacts%block_e(:n), 1, blocks%n)
      call check_list(archive, contacts%pair(:n), 1, neighbours%n_pairs)
      call check_list(archive, contacts%joint(:n), 1, joints)
   end subroutine serialise_contacts

   !> Save or restore one variable of a list.
   subroutine serialise_variable(operation, integers, logicals, reals, columns)
      class(serialisation_type), intent(inout) :: operation          !< archive, and how many
      integer, allocatable, intent(inout), optional :: integers(:)   !< [capacity]
      logical, allocatable, intent(inout), optional :: logicals(:)   !< [capacity]
      real(wp), allocatable, intent(inout), optional :: reals(:)     !< [capacity]
      real(wp), allocatable, intent(inout), optional :: columns(:,:) !< [any, capacity]

      associate (archive => operation%archive, n => operation%n)
         if (present(integers)) call serialise(archive, integers(:n))
         if (present(logicals)) call serialise(archive, logicals(:n))
         if (present(reals)) call serialise(archive, reals(:n))
         if (present(columns)) call serialise(archive, columns(:, :n))
      end associate
   end subroutine serialise_variable

   !> Save or restore pairs and probes of the last search, which cannot be recomputed.
   subroutine serialise_neighbours(archive, neighbours, blocks)
      type(archive_type), intent(inout) :: archive        !< written or read
      type(neighbours_type), intent(inout) :: neighbours  !< replaced when read
      type(blocks_type), intent(in) :: blocks             !< of the model
      integer :: pairs, probes, edges

      call serialise_label(archive, 'neighbours')
      edges = neighbours%first_edge(neighbours%n_probes + 1) - 1
      call serialise_count(archive, neighbours%n_pairs)
      call serialise_count(archive, neighbours%n_probes)
      call serialise_count(archive, edges)
      pairs = neighbours%n_pairs
      probes = neighbours%n_probes
      if (archive%reading) then
         deallocate (neighbours%pair, neighbours%probe, neighbours%first_edge, neighbours%edge)
         allocate (neighbours%pair(2, pairs), neighbours%probe(2, probes), &
            neighbours%first_edge(probes + 1), source=1)
         allocate (neighbours%edge(edges), source=1)
      end if
      call serialise(archive, neighbours%pair(:, :pairs))
      call check_list(archive, neighbours%pair(1, :pairs), 1, blocks%n)
      call check_list(archive, neighbours%pair(2, :pairs), 1, blocks%n)
      call serialise(archive, neighbours%probe(:, :probes))
      call check_list(archive, neighbours%probe(1, :probes), 1, size(blocks%owner))
      call check_list(archive, neighbours%probe(2, :probes), 1, pairs)
      call serialise_list(archive, neighbours%first_edge(:probes + 1), 1, edges + 1)
      call serialise_list(archive, neighbours%edge(:edges), 1, size(blocks%owner))
      call serialise(archive, neighbours%reach)
      call serialise(archive, neighbours%travel)
   end subroutine serialise_neighbours

end module dda_contact_state
