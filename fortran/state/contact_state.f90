!> The state of the contacts: the last step's list, and the neighbours that the next ones are found
!> among.
module dda_contact_state
   use dda_archive, only: archive_type, serialise, serialise_count, serialise_label, &
      serialise_list, check_list
   use dda_blocks, only: blocks_type
   use dda_contact, only: contacts_type, reserve
   use dda_neighbours, only: neighbours_type
   implicit none
   private
   public :: serialise_contacts, serialise_neighbours

contains

   !> All of a list: the next step inherits from it, and frames are written from it.
   subroutine serialise_contacts(archive, contacts, blocks, neighbours, joints)
      type(archive_type), intent(inout) :: archive  !< written or read
      type(contacts_type), intent(inout) :: contacts  !< written or read
      type(blocks_type), intent(in) :: blocks  !< of the model
      type(neighbours_type), intent(in) :: neighbours  !< of the last search
      integer, intent(in) :: joints  !< joint materials
      integer :: n, vertices

      call serialise_label(archive, 'contacts')
      call serialise_count(archive, contacts%n)
      n = contacts%n
      vertices = size(blocks%owner)
      if (archive%reading) call reserve(contacts, n)
      call serialise_list(archive, contacts%vertex(:n), 1, vertices)
      call serialise_list(archive, contacts%edge(:n), 1, vertices)
      call serialise_list(archive, contacts%corner(:n), 0, vertices)
      call serialise_list(archive, contacts%block_v(:n), 1, blocks%n)
      call serialise_list(archive, contacts%block_e(:n), 1, blocks%n)
      call serialise_list(archive, contacts%pair(:n), 1, neighbours%n_pairs)
      call serialise_list(archive, contacts%joint(:n), 1, joints)
      call serialise_geometry(archive, contacts, n)
      call serialise_history(archive, contacts, n)
      call serialise_responses(archive, contacts, n)
   end subroutine serialise_contacts

   !> Gaps, normals and lever arms.
   subroutine serialise_geometry(archive, contacts, n)
      type(archive_type), intent(inout) :: archive  !< written or read
      type(contacts_type), intent(inout) :: contacts  !< written or read
      integer, intent(in) :: n  !< number of contacts

      call serialise(archive, contacts%gap(:n))
      call serialise(archive, contacts%normal(:, :n))
      call serialise(archive, contacts%normal_v(:, :n))
      call serialise(archive, contacts%normal_e(:, :n))
      call serialise(archive, contacts%shear_v(:, :n))
      call serialise(archive, contacts%shear_e(:, :n))
   end subroutine serialise_geometry

   !> State variables that steps inherit.
   subroutine serialise_history(archive, contacts, n)
      type(archive_type), intent(inout) :: archive  !< written or read
      type(contacts_type), intent(inout) :: contacts  !< written or read
      integer, intent(in) :: n  !< number of contacts

      call serialise(archive, contacts%state(:n))
      call serialise(archive, contacts%bonded(:n))
      call serialise(archive, contacts%was_bonded(:n))
      call serialise(archive, contacts%was_closed(:n))
      call serialise(archive, contacts%offset(:n))
      call serialise(archive, contacts%bond_length(:n))
      call serialise(archive, contacts%multiplier(:n))
      call serialise(archive, contacts%stretch(:n))
   end subroutine serialise_history

   !> Results of the last step.
   subroutine serialise_responses(archive, contacts, n)
      type(archive_type), intent(inout) :: archive  !< written or read
      type(contacts_type), intent(inout) :: contacts  !< written or read
      integer, intent(in) :: n  !< number of contacts

      call serialise(archive, contacts%slide_force(:n))
      call serialise(archive, contacts%slip_sign(:n))
      call serialise(archive, contacts%slide_slip(:n))
      call serialise(archive, contacts%force_residual(:n))
      call serialise(archive, contacts%close_count(:n))
      call serialise(archive, contacts%trial_state(:n))
      call serialise(archive, contacts%new_gap(:n))
      call serialise(archive, contacts%slip(:n))
      call serialise(archive, contacts%gap_change(:n))
      call serialise(archive, contacts%slip_change(:n))
      call serialise(archive, contacts%strength_ratio(:n))
      call serialise(archive, contacts%normal_force(:n))
      call serialise(archive, contacts%shear_force(:n))
   end subroutine serialise_responses

   !> Pairs and probes of the last search, which the geometry of now would not give again.
   subroutine serialise_neighbours(archive, neighbours, blocks)
      type(archive_type), intent(inout) :: archive  !< written or read
      type(neighbours_type), intent(inout) :: neighbours  !< written or read
      type(blocks_type), intent(in) :: blocks  !< of the model
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
