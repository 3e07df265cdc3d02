! SPDX-License-Identifier: GPL-3.0-or-later
!> Largest values of a run as part of a checkpoint, with their origins.
module dda_maxima_state
   use dda_archive, only: archive_type, serialise, serialise_count, serialise_label, &
      serialise_list, serialise_number
   use dda_base_motion, only: base_type, base_kinds
   use dda_first_contacts, only: first_contacts_type
   use dda_maxima, only: maxima_table, number_of_maxima
   use dda_running_maxima, only: reserve_maxima
   use dda_simulation, only: simulation_type
   implicit none
   private
   public :: serialise_maxima

contains

   !> Save or restore largest values; nothing for a run that does not count them.
   subroutine serialise_maxima(archive, simulation)
      type(archive_type), intent(inout) :: archive        !< written or read
      type(simulation_type), intent(inout) :: simulation  !< a run and its state
      integer :: contacts

      call serialise_label(archive, 'maxima')
      call serialise(archive, simulation%maxima%counting)
      if (.not. simulation%maxima%counting .or. allocated(archive%failure)) return
      contacts = 0
      if (.not. archive%reading) contacts = size(simulation%maxima%contacts%vertex)
      call serialise_count(archive, contacts)
      if (archive%reading .and. .not. allocated(archive%failure)) call reserve_maxima(simulation, &
         contacts)
      if (allocated(archive%failure)) return
      call serialise(archive, simulation%maxima%first)
      call serialise(archive, simulation%maxima%points_from)
      call serialise_base(archive, simulation%maxima%base, size(simulation%model%points))
      call serialise_contacts(archive, simulation%maxima%contacts, size(simulation%blocks%owner))
      call serialise_largest(archive, simulation)
   end subroutine serialise_maxima

   !> Save or restore the origin from which values count.
   subroutine serialise_base(archive, base, points)
      type(archive_type), intent(inout) :: archive  !< written or read
      type(base_type), intent(inout) :: base        !< of the model
      integer, intent(in) :: points                 !< measured

      call serialise_number(archive, base%kind, 0, base_kinds)
      call serialise_number(archive, base%point, 0, points)
      call serialise(archive, base%share)
      call serialise(archive, base%zero)
      call serialise(archive, base%displacement)
      call serialise(archive, base%velocity)
      call serialise(archive, base%acceleration)
   end subroutine serialise_base

   !> Save or restore the initial contacts, and their last scan.
   subroutine serialise_contacts(archive, first, vertices)
      type(archive_type), intent(inout) :: archive       !< written or read
      type(first_contacts_type), intent(inout) :: first  !< contacts, with memory for them
      integer, intent(in) :: vertices                    !< of the model

      call serialise_list(archive, first%vertex, 1, vertices)
      call serialise_list(archive, first%edge, 1, vertices)
      call serialise(archive, first%share)
      call serialise(archive, first%gap)
      call serialise(archive, first%shortest)
      call serialise(archive, first%found)
      call serialise(archive, first%path)
   end subroutine serialise_contacts

   !> Save or restore values, times, and their blocks or points.
   subroutine serialise_largest(archive, simulation)
      type(archive_type), intent(inout) :: archive        !< written or read
      type(simulation_type), intent(inout) :: simulation  !< a run and its state
      integer :: i, most

      do i = 1, number_of_maxima
         associate (largest => simulation%maxima%largest(i))
            most = simulation%blocks%n
            if (maxima_table(i)%of_points) most = size(simulation%model%points)
            call serialise(archive, largest%value)
            call serialise(archive, largest%time)
            call serialise_list(archive, largest%who, 0, most)
         end associate
      end do
   end subroutine serialise_largest

end module dda_maxima_state
