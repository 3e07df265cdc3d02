! SPDX-License-Identifier: GPL-3.0-or-later
!> Transfer of history from the contacts of the last step to the contacts of this step.
!>
!> The predecessor of a contact is the contact of the same vertex and edge.  If a contact moves
!> around a corner or to another edge, its predecessor is a contact between the same two blocks with
!> the same vertex and nearly the same direction.  Each history is transferred once.
!>
!> A new contact starts without force: if it already penetrates (a vertex that passed a corner
!> within a step), its gap is offset until it opens.  If the successor of a contact has another
!> depth, or another block after sliding across a joint, it receives the force and spring energy.
module dda_history
   use dda_growth, only: grow
   use dda_kinds, only: wp
   use dda_contact, only: capacity_of, contacts_type, copy_history, filter_contacts, is_point, &
      contact_open, contact_stick
   use dda_sorting, only: merged_order
   use dda_ordered_sums, only: pieces, first_of, last_of, parallel_from
   implicit none
   private
   public :: history_type, prepare_history, inherit

   real(wp), parameter :: same_direction = cos(atan(1.0_wp))  !< change of direction < 45°
   !> largest gap change/penetration when vertex and edge exchange roles
   real(wp), parameter :: slack = 0.1_wp

   !> Limits of a transfer, and an index of old contacts whose position in the list changes.
   type :: history_type
      real(wp) :: max_penetration = huge(1.0_wp) !< deepest penetration of a new contact, m
      !> largest change of the distance from a contact to its successor on another edge, m
      real(wp) :: largest_jump = huge(1.0_wp)
      !> gap up to which a new contact is first assumed closed, m
      real(wp) :: touching = 0.0_wp
      integer, allocatable :: head(:)   !< [vertices] first old contact c, stored as 2c or 2c+1
      integer, allocatable :: next(:)   !< [2·contacts+1] next contact of the vertex
      logical, allocatable :: transferred(:) !< [old contacts] has a successor
      logical, allocatable :: matched(:)     !< [new contacts] has a predecessor
      integer :: n_unmatched = 0
      !> positions at which the two lists differ, ascending
      integer, allocatable :: unmatched(:)
   end type history_type

contains

   !> Allocate the index for the vertices of a model.
   subroutine prepare_history(history, vertices, touching)
      type(history_type), intent(out) :: history  !< ready for the first step
      integer, intent(in) :: vertices             !< number of vertices of all blocks
      real(wp), intent(in) :: touching            !< gap up to which a contact is closed, m

      history%touching = touching
      allocate (history%head(vertices), source=0)
      allocate (history%next(1), history%transferred(0), history%matched(0), history%unmatched(0))
   end subroutine prepare_history

   !> Transfer histories from the old list to the new one.
   !> Contacts without a predecessor begin unbonded, and are assumed to stick if they touch.
   subroutine inherit(new, old, history, has_started)
      !> `gap`: on entry the distance; on return minus `offset`
      type(contacts_type), intent(inout) :: new
      type(contacts_type), intent(in) :: old        !< list of the last step, solved
      type(history_type), intent(inout) :: history  !< limits of this step
      !> .false. in the first list of a run, in which initial penetrations cause forces
      logical, intent(in) :: has_started

      call grow(history%matched, capacity_of(new), exactly=.true.)
      call grow(history%transferred, capacity_of(old), exactly=.true.)
      call grow(history%unmatched, max(capacity_of(new), capacity_of(old)), exactly=.true.)
      call transfer_in_place(new, old, history, has_started)
      call list_unmatched(history, new%n, old%n)
      if (history%n_unmatched == 0) return
      call grow(history%next, 2*old%n + 1)
      call index_by_vertex(history, old)
      call transfer_unmatched(new, old, history)
      call subtract_offsets(new, history)
      if (force_remains(old, history)) call transfer_forces(new, old, history)
      call clear_index(history, old)
      if (has_started) call drop_deep_contacts(new, history)
   end subroutine inherit

   !> Copy histories of contacts with the same position in both lists, and initialise the others.
   subroutine transfer_in_place(new, old, history, has_started)
      type(contacts_type), intent(inout) :: new     !< receives history
      type(contacts_type), intent(in) :: old        !< list of the last step
      type(history_type), intent(inout) :: history  !< `matched` and `transferred` are set
      logical, intent(in) :: has_started            !< .false.: first list of the run
      integer :: p

      if (new%n < parallel_from) then
         call transfer_in_place_range(new, old, history, has_started, 1, new%n)
         return
      end if
      !$omp parallel do schedule(static)
      do p = 1, pieces(new%n)
         call transfer_in_place_range(new, old, history, has_started, first_of(p, new%n), &
            last_of(p, new%n))
      end do
   end subroutine transfer_in_place

   !> Copy histories at positions first … last of the new list.
   pure subroutine transfer_in_place_range(new, old, history, has_started, first, last)
      type(contacts_type), intent(inout) :: new     !< receives history
      type(contacts_type), intent(in) :: old        !< list of the last step
      type(history_type), intent(inout) :: history  !< `matched` and `transferred` are set
      logical, intent(in) :: has_started            !< .false.: first list of the run
      integer, intent(in) :: first, last            !< positions in the new list
      integer :: c, both

      both = min(last, old%n)
      history%matched(first:both) = new%vertex(first:both) == old%vertex(first:both) &
         .and. new%edge(first:both) == old%edge(first:both)
      if (new%with_laws) history%matched(first:both) = history%matched(first:both) &
         .and. new%point(first:both) == old%point(first:both)
      history%matched(max(first, both + 1):last) = .false.
      history%transferred(first:both) = history%matched(first:both)
      call copy_history(new, first, both, old, first)
      do c = first, last
         if (history%matched(c)) then
            new%offset(c) = offset_at_distance(old%offset(c), new%gap(c))
            new%gap(c) = new%gap(c) - new%offset(c)
         else
            call start_contact(new, c, history%touching, has_started)
         end if
      end do
   end subroutine transfer_in_place_range

   !> List the positions at which the two lists differ, in most steps few or none.
   pure subroutine list_unmatched(history, new, old)
      type(history_type), intent(inout) :: history  !< `unmatched` is set
      integer, intent(in) :: new, old               !< numbers of contacts
      integer :: c

      history%n_unmatched = 0
      do c = 1, max(new, old)
         if (c > new) then
            history%transferred(c) = .false.
         else if (history%matched(c)) then
            cycle
         end if
         history%n_unmatched = history%n_unmatched + 1
         history%unmatched(history%n_unmatched) = c
      end do
   end subroutine list_unmatched

   !> Transfer histories to the unmatched contacts of the new list.
   !> The predecessor has the same vertex and edge, or else the same two blocks.  Of the contacts
   !> without a predecessor on the same edge, those with the smallest change of distance are first.
   subroutine transfer_unmatched(new, old, history)
      type(contacts_type), intent(inout) :: new     !< receives history
      type(contacts_type), intent(in) :: old        !< list of the last step
      type(history_type), intent(inout) :: history  !< index of the unmatched contacts
      real(wp) :: away(history%n_unmatched)
      integer :: candidates(history%n_unmatched), n, k, from

      do k = 1, history%n_unmatched
         call transfer_to(new, history%unmatched(k), old, history, same_edge=.true.)
      end do
      n = 0
      do k = 1, history%n_unmatched
         from = predecessor(new, old, history, history%unmatched(k), same_edge=.false.)
         if (from == 0) cycle
         n = n + 1
         candidates(n) = history%unmatched(k)
         away(n) = distance_change(new, candidates(n), old, from)
      end do
      candidates(:n) = candidates(merged_order(away(:n)))
      do k = 1, n
         call transfer_to(new, candidates(k), old, history, same_edge=.false.)
      end do
   end subroutine transfer_unmatched

   !> Transfer the history of the predecessor to new contact c, if there is one.
   subroutine transfer_to(new, c, old, history, same_edge)
      type(contacts_type), intent(inout) :: new     !< receives history
      integer, intent(in) :: c                      !< position in either list
      type(contacts_type), intent(in) :: old        !< list of the last step
      type(history_type), intent(inout) :: history  !< index of the unmatched contacts
      !> select predecessors on the same edge; .false.: on other edges
      logical, intent(in) :: same_edge
      integer :: from

      from = predecessor(new, old, history, c, same_edge)
      if (from == 0) return
      call copy_history(new, c, c, old, from)
      history%transferred(from) = .true.
      history%matched(c) = .true.
      if (same_edge) then
         new%offset(c) = offset_at_distance(old%offset(from), new%gap(c))
      else if (new%bonded(c)) then
         new%offset(c) = 0.0_wp  ! a bonded contact has no offset
      else
         new%offset(c) = transferred_offset(new%gap(c), min(0.0_wp, old%new_gap(from)), &
            old%offset(from))
      end if
   end subroutine transfer_to

   !> Return the offset, m, of a contact at its present distance.
   !> A negative offset (penetration without force) ends when the contact opens; a positive offset
   !> (closure by initial stress) remains.
   elemental real(wp) function offset_at_distance(offset, distance) result(new_offset)
      real(wp), intent(in) :: offset    !< offset in the last step, m
      real(wp), intent(in) :: distance  !< distance between vertex and edge, m

      new_offset = min(max(0.0_wp, offset), max(offset, distance))
   end function offset_at_distance

   !> Return the absolute change of the distance, m, from an old contact to a new contact.
   pure real(wp) function distance_change(new, c, old, o)
      type(contacts_type), intent(in) :: new, old  !< new and old list of contacts
      integer, intent(in) :: c, o                  !< new and old contact

      distance_change = abs(new%gap(c) - (old%new_gap(o) + old%offset(o)))
   end function distance_change

   !> Subtract the offsets from the gaps, so that the normal force is zero at zero gap.
   pure subroutine subtract_offsets(new, history)
      type(contacts_type), intent(inout) :: new  !< distances become gaps
      type(history_type), intent(in) :: history  !< index of the unmatched contacts
      integer :: k, c

      do k = 1, history%n_unmatched
         c = history%unmatched(k)
         if (c > new%n) exit
         new%gap(c) = new%gap(c) - new%offset(c)
      end do
   end subroutine subtract_offsets

   !> Initialise contact c, which has no history.
   pure subroutine start_contact(new, c, touching, has_started)
      type(contacts_type), intent(inout) :: new  !< list with geometry
      integer, intent(in) :: c                   !< contact
      real(wp), intent(in) :: touching           !< gap up to which the contact is assumed closed, m
      logical, intent(in) :: has_started         !< .false.: first list of the run

      new%joint(c) = 0
      new%state(c) = merge(contact_stick, contact_open, new%gap(c) <= touching)
      new%bonded(c) = .false.
      new%offset(c) = merge(min(new%gap(c), 0.0_wp), 0.0_wp, has_started)
      new%stretch(c) = 0.0_wp
      new%slide_force(c) = 0.0_wp
      new%slip_sign(c) = 1.0_wp
      if (new%with_multipliers) new%multiplier(c) = 0.0_wp
      if (new%with_strengths) new%bond_length(c) = 0.0_wp
      if (new%with_damping) new%static_force(c) = 0.0_wp
      new%spring(:, c) = 0.0_wp
      if (.not. new%with_laws) return
      new%fraction(c) = 0.0_wp
      new%stiffness_fraction(c) = 1.0_wp
      new%length(c) = 0.0_wp
      new%tilt(:, c) = 0.0_wp
      new%memory(:, c) = new%initial_memory
   end subroutine start_contact

   !> Link each unmatched old contact to its touching vertex and to the corner that it touches.
   subroutine index_by_vertex(history, old)
      type(history_type), intent(inout) :: history  !< `head` and `next` are set
      type(contacts_type), intent(in) :: old        !< list of the last step
      integer :: k, c

      do k = history%n_unmatched, 1, -1
         c = history%unmatched(k)
         if (c > old%n) cycle
         history%next(2*c) = history%head(old%vertex(c))
         history%head(old%vertex(c)) = 2*c
         if (old%corner(c) == 0) cycle
         history%next(2*c + 1) = history%head(old%corner(c))
         history%head(old%corner(c)) = 2*c + 1
      end do
   end subroutine index_by_vertex

   !> Clear the index of unmatched old contacts.
   subroutine clear_index(history, old)
      type(history_type), intent(inout) :: history  !< `head` is zero again
      type(contacts_type), intent(in) :: old        !< list of the last step
      integer :: k, c

      do k = 1, history%n_unmatched
         c = history%unmatched(k)
         if (c > old%n) exit
         history%head(old%vertex(c)) = 0
         if (old%corner(c) > 0) history%head(old%corner(c)) = 0
      end do
   end subroutine clear_index

   !> Find the old contact whose history passes to a new contact; 0 if there is none, or if the
   !> contact already has a history.
   !>
   !> Both have the same vertex and edge, or else the same two blocks, a common vertex and the same
   !> direction.  The history must not have been transferred already.
   pure integer function predecessor(new, old, history, c, same_edge) result(position)
      type(contacts_type), intent(in) :: new, old  !< new and old list of contacts
      type(history_type), intent(in) :: history    !< index of the unmatched contacts
      integer, intent(in) :: c                     !< position in either list
      !> select predecessors on the same edge; .false.: on other edges
      logical, intent(in) :: same_edge
      integer :: k, link, o

      position = 0
      if (c > new%n) return
      if (history%matched(c)) return
      do k = 1, merge(1, 2, same_edge)
         link = 0
         if (k == 1) link = history%head(new%vertex(c))
         if (k == 2 .and. new%corner(c) > 0) link = history%head(new%corner(c))
         do while (link > 0 .and. position == 0)
            o = link/2
            if (.not. same_point(new, c, old, o)) then
               continue
            else if (same_edge) then
               if (old%vertex(o) == new%vertex(c) .and. old%edge(o) == new%edge(c)) position = o
            else if (.not. history%transferred(o)) then
               if (can_replace(new, c, old, o, history%largest_jump)) position = o
            end if
            link = history%next(link)
         end do
      end do
   end function predecessor

   !> .true. if contacts c and o are both at corners, or are points with the same number.
   pure logical function same_point(new, c, old, o)
      type(contacts_type), intent(in) :: new, old  !< new and old list of contacts
      integer, intent(in) :: c, o                  !< new and old contact

      same_point = .not. new%with_laws
      if (new%with_laws) same_point = new%point(c) == old%point(o)
   end function same_point

   !> .true. if new contact c can replace old contact o.
   !> Both must have the same two blocks, about the same distance, and the same direction.
   pure logical function can_replace(new, c, old, o, largest_jump)
      type(contacts_type), intent(in) :: new, old  !< new and old list of contacts
      integer, intent(in) :: c, o                  !< new and old contact
      real(wp), intent(in) :: largest_jump         !< largest change of the distance, m
      real(wp) :: cosine

      cosine = dot_product(new%normal(:, c), old%normal(:, o))
      can_replace = .false.
      if (distance_change(new, c, old, o) > largest_jump) return
      if (new%block_v(c) == old%block_v(o) .and. new%block_e(c) == old%block_e(o)) then
         can_replace = cosine > same_direction
      else if (new%block_v(c) == old%block_e(o) .and. new%block_e(c) == old%block_v(o)) then
         can_replace = -cosine > same_direction
      end if
   end function can_replace

   !> Return the offset, m, of a contact that replaces an old contact.
   !> The old offset is used unless it would immediately compress the spring much more.
   pure real(wp) function transferred_offset(distance, pressed, offset) result(transferred)
      real(wp), intent(in) :: distance  !< distance of the new contact, m
      real(wp), intent(in) :: pressed   !< gap of the old contact if in compression, else 0, m
      real(wp), intent(in) :: offset    !< offset of the old contact, m

      transferred = offset
      if (distance - offset < (1.0_wp + slack)*pressed) transferred = min(0.0_wp, &
         distance - pressed)
   end function transferred_offset

   !> .true. if an old contact without a successor was still in compression.
   pure logical function force_remains(old, history)
      type(contacts_type), intent(in) :: old     !< list of the last step
      type(history_type), intent(in) :: history  !< index of the unmatched contacts

      associate (c => pack(history%unmatched(:history%n_unmatched), &
         history%unmatched(:history%n_unmatched) <= old%n))
         force_remains = any(.not. history%transferred(c) .and. old%new_gap(c) < 0.0_wp)
      end associate
   end function force_remains

   !> Transfer the force of old contacts without a successor to another contact of the same vertex.
   !> Both have the same direction.  For example, a vertex slides across the joint of two blocks.
   subroutine transfer_forces(new, old, history)
      type(contacts_type), intent(inout) :: new     !< list with history
      type(contacts_type), intent(in) :: old        !< list of the last step
      type(history_type), intent(inout) :: history  !< index of the unmatched contacts
      real(wp) :: distance
      integer :: c, o

      do c = 1, new%n
         o = force_predecessor(new, old, history, c)
         if (o == 0) cycle
         history%transferred(o) = .true.
         history%matched(c) = .true.
         distance = new%gap(c) + new%offset(c)
         new%gap(c) = max(distance, combined_deformation(min(0.0_wp, new%gap(c)), old%new_gap(o)))
         new%offset(c) = distance - new%gap(c)
         new%stretch(c) = combined_deformation(new%stretch(c), old%stretch(o))
         if (new%state(c) == contact_open) new%state(c) = old%state(o)
         new%spring(:, c) = old%spring(:, o)
      end do
   end subroutine transfer_forces

   !> Remove new contacts whose penetration exceeds the displacement in a step.
   !> Their vertices were already inside the block and are now near another edge of the block.
   !> Points remain, because they inherit a history from neighbours.
   subroutine drop_deep_contacts(new, history)
      type(contacts_type), intent(inout) :: new     !< list with history
      type(history_type), intent(inout) :: history  !< `matched` is compacted too
      logical :: keep(new%n)
      integer :: k, c

      keep = .true.
      do k = 1, history%n_unmatched
         c = history%unmatched(k)
         if (c > new%n) exit
         keep(c) = history%matched(c) .or. new%offset(c) >= -history%max_penetration .or. &
            is_point(new, c)
      end do
      if (all(keep)) return
      history%matched(:count(keep)) = pack(history%matched(:new%n), keep)
      call filter_contacts(new, keep)
   end subroutine drop_deep_contacts

   !> Find the old contact without a successor whose force passes to penetrating contact c; 0: none.
   !> Both contacts have the same vertex and direction.
   pure integer function force_predecessor(new, old, history, c) result(position)
      type(contacts_type), intent(in) :: new, old  !< new and old list of contacts
      type(history_type), intent(in) :: history    !< index of the unmatched contacts
      integer, intent(in) :: c                     !< new contact
      integer :: link, o

      position = 0
      if (new%gap(c) + new%offset(c) >= 0.0_wp .or. is_point(new, c)) return
      link = history%head(new%vertex(c))
      do while (link > 0 .and. position == 0)
         o = link/2
         if (.not. (history%transferred(o) .or. is_point(old, o)) .and. old%new_gap(o) < 0.0_wp &
            .and. old%vertex(o) == new%vertex(c) .and. &
            dot_product(new%normal(:, c), old%normal(:, o)) > same_direction) position = o
         link = history%next(link)
      end do
   end function force_predecessor

   !> Return the deformation of a spring that has the energy of two equal springs: ± √(a² + b²).
   pure real(wp) function combined_deformation(a, b)
      real(wp), intent(in) :: a, b  !< deformations, m

      combined_deformation = sign(norm2([a, b]), merge(a, b, abs(a) > abs(b)))
   end function combined_deformation

end module dda_history
