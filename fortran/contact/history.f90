!> What a contact has lived through passes to its successor in the next step's list.
!>
!> The successor is the same vertex on the same edge; or, when a contact travels round a corner or
!> from edge to edge, one between the same two blocks that involves the same vertex and pushes in
!> nearly the same direction.  Each history is handed on once.
!>
!> No contact begins with a force that was never built up: one that is first met in penetration (a
!> vertex that came round a corner within a step) presses only beyond the depth it was met at, until
!> it has opened.  A force goes over to a contact of another depth, or of another block when a
!> vertex slides across a joint, with the spring energy that it has.
module dda_history
   use dda_kinds, only: wp
   use dda_contact, only: contacts_type, keep_contacts, contact_open, contact_stick
   use dda_ordered_sums, only: pieces, first_of, last_of, parallel_from
   implicit none
   private
   public :: history_type, prepare_history, inherit

   real(wp), parameter :: same_direction = cos(atan(1.0_wp))  !< 45°
   !> of a penetration: what a change of roles may add by geometry
   real(wp), parameter :: slack = 0.1_wp

   !> Where the old contacts of each vertex are that do not stand in the same place of the new list.
   type :: history_type
      real(wp) :: deepest = huge(1.0_wp) !< penetration that a new contact may be met with, m
      real(wp) :: leap = huge(1.0_wp)   !< most that a gap changes where contacts change places, m
      !> gap up to which a new contact is taken to press at first, m
      real(wp) :: touching = 0.0_wp
      integer, allocatable :: head(:)   !< [vertices] first old contact of a vertex, as 2c or 2c+1
      integer, allocatable :: next(:)   !< [2·contacts+1] the next one
      logical, allocatable :: taken(:)  !< [contacts] already handed on
      logical, allocatable :: found(:)  !< [new contacts] the same vertex was on the same edge
      integer :: n_strays = 0
      !> places, ascending, where not the same contact stands in both lists
      integer, allocatable :: stray(:)
   end type history_type

contains

   subroutine prepare_history(history, vertices, touching)
      type(history_type), intent(out) :: history
      integer, intent(in) :: vertices
      real(wp), intent(in) :: touching  !< m

      history%touching = touching
      allocate (history%head(vertices), source=0)
      allocate (history%next(1), history%taken(0), history%found(0), history%stray(0))
   end subroutine prepare_history

   !> Give the new list the histories of the old one; contacts without one start unbonded, and are
   !> assumed to stick if they touch.  `gap` comes as the distance and becomes what presses.
   subroutine inherit(new, old, history, begun)
      type(contacts_type), intent(inout) :: new
      type(contacts_type), intent(in) :: old
      type(history_type), intent(inout) :: history
      !> .false. at the start, where penetration is part of the first state
      logical, intent(in) :: begun

      call make_room(history, new%n, old%n)
      call hand_on_in_place(new, old, history, begun)
      call list_strays(history, new%n, old%n)
      if (history%n_strays == 0) return
      call index_by_vertex(history, old)
      call hand_on_exactly(new, old, history)
      call hand_on_nearly(new, old, history)
      call press_strays(new, history)
      if (orphans_left(old, history)) call adopt_orphans(new, old, history)
      call forget_index(history, old)
      if (begun) call refuse_deep(new, history)
   end subroutine inherit

   subroutine make_room(history, new, old)
      type(history_type), intent(inout) :: history
      integer, intent(in) :: new, old  !< numbers of contacts

      if (size(history%found) < new) then
         deallocate (history%found)
         allocate (history%found(2*new))
      end if
      if (size(history%taken) < old) then
         deallocate (history%next, history%taken)
         allocate (history%next(4*old + 1), history%taken(2*old))
      end if
      if (size(history%stray) < max(new, old)) then
         deallocate (history%stray)
         allocate (history%stray(2*max(new, old)))
      end if
   end subroutine make_room

   !> Most contacts stand in the new list where they stood in the old one; the others begin without
   !> a history.
   subroutine hand_on_in_place(new, old, history, begun)
      type(contacts_type), intent(inout) :: new
      type(contacts_type), intent(in) :: old
      type(history_type), intent(inout) :: history
      logical, intent(in) :: begun
      integer :: p

      if (new%n < parallel_from) then
         call hand_on_some(new, old, history, begun, 1, new%n)
         return
      end if
      !$omp parallel do schedule(static)
      do p = 1, pieces(new%n)
         call hand_on_some(new, old, history, begun, first_of(p, new%n), last_of(p, new%n))
      end do
   end subroutine hand_on_in_place

   pure subroutine hand_on_some(new, old, history, begun, first, last)
      type(contacts_type), intent(inout) :: new
      type(contacts_type), intent(in) :: old
      type(history_type), intent(inout) :: history
      logical, intent(in) :: begun
      integer, intent(in) :: first, last
      integer :: c, both

      both = min(last, old%n)
      history%found(first:both) = new%vertex(first:both) == old%vertex(first:both) &
         .and. new%edge(first:both) == old%edge(first:both)
      history%found(max(first, both + 1):last) = .false.
      history%taken(first:both) = history%found(first:both)
      call hand_on_all(new, old, first, both)
      do c = first, last
         if (history%found(c)) then
            new%offset(c) = min(0.0_wp, max(old%offset(c), new%gap(c)))
            new%gap(c) = new%gap(c) - new%offset(c)
         else
            call begin(new, c, history%touching, begun)
         end if
      end do
   end subroutine hand_on_some

   !> As `hand_on`, from the same places of the old list: array by array, which is quick.
   pure subroutine hand_on_all(new, old, first, last)
      type(contacts_type), intent(inout) :: new
      type(contacts_type), intent(in) :: old
      integer, intent(in) :: first, last

      new%state(first:last) = old%state(first:last)
      new%bonded(first:last) = old%bonded(first:last)
      new%bond_length(first:last) = old%bond_length(first:last)
      new%stretch(first:last) = old%stretch(first:last)
      new%multiplier(first:last) = old%multiplier(first:last)
      new%slide_force(first:last) = old%slide_force(first:last)
      new%slip_sign(first:last) = old%slip_sign(first:last)
   end subroutine hand_on_all

   !> Where the lists differ, which is all that is left to look at: in most steps little or nothing.
   pure subroutine list_strays(history, new, old)
      type(history_type), intent(inout) :: history
      integer, intent(in) :: new, old  !< numbers of contacts
      integer :: c

      history%n_strays = 0
      do c = 1, new
         if (.not. history%found(c)) call note_stray(history, c)
      end do
      do c = new + 1, old
         history%taken(c) = .false.
         call note_stray(history, c)
      end do
   end subroutine list_strays

   pure subroutine note_stray(history, c)
      type(history_type), intent(inout) :: history
      integer, intent(in) :: c

      history%n_strays = history%n_strays + 1
      history%stray(history%n_strays) = c
   end subroutine note_stray

   !> From the same vertex on the same edge, elsewhere in the old list.
   subroutine hand_on_exactly(new, old, history)
      type(contacts_type), intent(inout) :: new
      type(contacts_type), intent(in) :: old
      type(history_type), intent(inout) :: history
      integer :: k, c, from

      do k = 1, history%n_strays
         c = history%stray(k)
         if (c > new%n) exit
         from = exact_predecessor(new, old, history, c)
         if (from == 0) cycle
         call hand_on(new, old, c, from)
         history%taken(from) = .true.
         history%found(c) = .true.
         new%offset(c) = min(0.0_wp, max(old%offset(from), new%gap(c)))
      end do
   end subroutine hand_on_exactly

   !> From a contact of the same two blocks, whose place the new one takes.
   subroutine hand_on_nearly(new, old, history)
      type(contacts_type), intent(inout) :: new
      type(contacts_type), intent(in) :: old
      type(history_type), intent(inout) :: history
      integer :: k, c, from

      do k = 1, history%n_strays
         c = history%stray(k)
         if (c > new%n) exit
         if (history%found(c)) cycle
         from = near_predecessor(new, old, history, c)
         if (from == 0) cycle
         call hand_on(new, old, c, from)
         history%taken(from) = .true.
         history%found(c) = .true.
         new%offset(c) = carried(new%gap(c), min(0.0_wp, old%new_gap(from)), old%offset(from))
         if (new%bonded(c)) new%offset(c) = 0.0_wp  ! a bond holds from its true length
      end do
   end subroutine hand_on_nearly

   !> What presses is the distance beyond the offset.
   pure subroutine press_strays(new, history)
      type(contacts_type), intent(inout) :: new
      type(history_type), intent(in) :: history
      integer :: k, c

      do k = 1, history%n_strays
         c = history%stray(k)
         if (c > new%n) exit
         new%gap(c) = new%gap(c) - new%offset(c)
      end do
   end subroutine press_strays

   !> A contact without a history.
   pure subroutine begin(new, c, touching, begun)
      type(contacts_type), intent(inout) :: new
      integer, intent(in) :: c
      real(wp), intent(in) :: touching
      logical, intent(in) :: begun

      new%state(c) = merge(contact_stick, contact_open, new%gap(c) <= touching)
      new%bonded(c) = .false.
      new%bond_length(c) = 0.0_wp
      new%offset(c) = merge(min(new%gap(c), 0.0_wp), 0.0_wp, begun)
      new%stretch(c) = 0.0_wp
      new%multiplier(c) = 0.0_wp
      new%slide_force(c) = 0.0_wp
      new%slip_sign(c) = 1.0_wp
   end subroutine begin

   !> Chain the other old contacts to their vertices (the one that touches and the corner it met).
   subroutine index_by_vertex(history, old)
      type(history_type), intent(inout) :: history
      type(contacts_type), intent(in) :: old
      integer :: k, c

      do k = history%n_strays, 1, -1
         c = history%stray(k)
         if (c > old%n) cycle
         history%next(2*c) = history%head(old%vertex(c))
         history%head(old%vertex(c)) = 2*c
         if (old%corner(c) == 0) cycle
         history%next(2*c + 1) = history%head(old%corner(c))
         history%head(old%corner(c)) = 2*c + 1
      end do
   end subroutine index_by_vertex

   subroutine forget_index(history, old)
      type(history_type), intent(inout) :: history
      type(contacts_type), intent(in) :: old
      integer :: k, c

      do k = 1, history%n_strays
         c = history%stray(k)
         if (c > old%n) exit
         history%head(old%vertex(c)) = 0
         if (old%corner(c) > 0) history%head(old%corner(c)) = 0
      end do
   end subroutine forget_index

   !> Old contact of the same vertex on the same edge; 0 if there is none.
   pure integer function exact_predecessor(new, old, history, c) result(found)
      type(contacts_type), intent(in) :: new, old
      type(history_type), intent(in) :: history
      integer, intent(in) :: c
      integer :: link

      found = 0
      link = history%head(new%vertex(c))
      do while (link > 0 .and. found == 0)
         if (old%vertex(link/2) == new%vertex(c) .and. old%edge(link/2) == new%edge(c)) &
            found = link/2
         link = history%next(link)
      end do
   end function exact_predecessor

   !> Old contact of the same two blocks through one of the same vertices, pushing the same way.
   pure integer function near_predecessor(new, old, history, c) result(found)
      type(contacts_type), intent(in) :: new, old
      type(history_type), intent(in) :: history
      integer, intent(in) :: c
      integer :: k, link

      found = 0
      do k = 1, 2
         link = 0
         if (k == 1) link = history%head(new%vertex(c))
         if (k == 2 .and. new%corner(c) > 0) link = history%head(new%corner(c))
         do while (link > 0 .and. found == 0)
            if (succeeds(new, c, old, link/2, history%leap) .and. .not. history%taken(link/2)) &
               found = link/2
            link = history%next(link)
         end do
      end do
   end function near_predecessor

   pure logical function succeeds(new, c, old, o, leap)
      type(contacts_type), intent(in) :: new, old
      integer, intent(in) :: c, o
      real(wp), intent(in) :: leap
      real(wp) :: facing

      facing = dot_product(new%normal(:, c), old%normal(:, o))
      succeeds = .false.
      if (abs(new%gap(c) - (old%new_gap(o) + old%offset(o))) > leap) return
      if (new%block_v(c) == old%block_v(o) .and. new%block_e(c) == old%block_e(o)) then
         succeeds = facing > same_direction
      else if (new%block_v(c) == old%block_e(o) .and. new%block_e(c) == old%block_v(o)) then
         succeeds = -facing > same_direction
      end if
   end function succeeds

   !> Offset of a contact that takes the place of another one, as that one's; but it must not press
   !> much harder at once.
   pure real(wp) function carried(distance, pressed, offset)
      real(wp), intent(in) :: distance  !< of the new contact, m
      real(wp), intent(in) :: pressed   !< gap of the old one where it pressed, else 0, m
      real(wp), intent(in) :: offset    !< of the old one, m

      carried = offset
      if (distance - carried < (1.0_wp + slack)*pressed) carried = min(0.0_wp, distance - pressed)
   end function carried

   !> An old contact without a successor still pressed.
   pure logical function orphans_left(old, history)
      type(contacts_type), intent(in) :: old
      type(history_type), intent(in) :: history
      integer :: k, c

      orphans_left = .false.
      do k = 1, history%n_strays
         c = history%stray(k)
         if (c > old%n) exit
         orphans_left = orphans_left .or. (.not. history%taken(c) .and. old%new_gap(c) < 0.0_wp)
      end do
   end function orphans_left

   !> What still pressed in a contact that has no successor goes over to a contact of the same
   !> vertex that pushes the same way: so a vertex slides across the joint between two blocks.
   subroutine adopt_orphans(new, old, history)
      type(contacts_type), intent(inout) :: new
      type(contacts_type), intent(in) :: old
      type(history_type), intent(inout) :: history
      real(wp) :: distance
      integer :: c, o

      do c = 1, new%n
         o = orphan_of(new, old, history, c)
         if (o == 0) cycle
         history%taken(o) = .true.
         history%found(c) = .true.
         distance = new%gap(c) + new%offset(c)
         new%gap(c) = max(distance, joined(min(0.0_wp, new%gap(c)), old%new_gap(o)))
         new%offset(c) = distance - new%gap(c)
         new%stretch(c) = joined(new%stretch(c), old%stretch(o))
         if (new%state(c) == contact_open) new%state(c) = old%state(o)
      end do
   end subroutine adopt_orphans

   !> What is first met deeper than a step can lead is no contact: a vertex that has come to stand
   !> before another edge of the block it is in.
   subroutine refuse_deep(new, history)
      type(contacts_type), intent(inout) :: new
      type(history_type), intent(in) :: history
      integer :: k, c

      do k = 1, history%n_strays
         c = history%stray(k)
         if (c > new%n) exit
         if (history%found(c) .or. .not. new%offset(c) < -history%deepest) cycle
         call keep_contacts(new, history%found(:new%n) .or. new%offset(:new%n) >= -history%deepest)
         exit
      end do
   end subroutine refuse_deep

   !> Old contact without a successor that pressed the vertex of a new one that now penetrates; 0 if
   !> there is none.
   pure integer function orphan_of(new, old, history, c) result(found)
      type(contacts_type), intent(in) :: new, old
      type(history_type), intent(in) :: history
      integer, intent(in) :: c
      integer :: link, o

      found = 0
      if (new%gap(c) + new%offset(c) >= 0.0_wp) return
      link = history%head(new%vertex(c))
      do while (link > 0 .and. found == 0)
         o = link/2
         if (.not. history%taken(o) .and. old%new_gap(o) < 0.0_wp .and. old%vertex(o) &
            == new%vertex(c) .and. dot_product(new%normal(:, c), old%normal(:, o)) &
            > same_direction) found = o
         link = history%next(link)
      end do
   end function orphan_of

   !> The deformation of one spring that stores what two of the same stiffness do.
   pure real(wp) function joined(a, b)
      real(wp), intent(in) :: a, b

      joined = sign(norm2([a, b]), merge(a, b, abs(a) > abs(b)))
   end function joined

   !> The slip of a vertex along an edge has the same sign when the two blocks change roles, so the
   !> stretch is handed on as it is.
   pure subroutine hand_on(new, old, c, from)
      type(contacts_type), intent(inout) :: new
      type(contacts_type), intent(in) :: old
      integer, intent(in) :: c, from

      new%state(c) = old%state(from)
      new%bonded(c) = old%bonded(from)
      new%bond_length(c) = old%bond_length(from)
      new%stretch(c) = old%stretch(from)
      new%multiplier(c) = old%multiplier(from)
      new%slide_force(c) = old%slide_force(from)
      new%slip_sign(c) = old%slip_sign(from)
   end subroutine hand_on

end module dda_history
