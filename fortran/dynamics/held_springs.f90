!> What K̂ and f̂ hold of the contacts, so that only what differs is assembled again.
!>
!> Within a step the geometry of the contacts stays and the open–close iteration changes few of
!> their states: a spring or a force that is other than held makes both blocks of its contact due.
module dda_held_springs
   use dda_kinds, only: wp, long
   use dda_contact, only: contacts_type, contact_open, contact_slide, contact_stick
   use dda_ordered_sums, only: pieces, first_of, last_of, parallel_from
   implicit none
   private
   public :: springs_type, held_type, prepare_held, hold_contacts, due_nothing, due_forces, &
      due_springs

   integer, parameter :: due_nothing = 0
   integer, parameter :: due_forces = 1   !< the right-hand side
   integer, parameter :: due_springs = 2  !< the matrix too

   real(wp), parameter :: no_spring = -1.0_wp   !< in place of the shear spring of an open contact

   !> Stiffness of all contacts.
   type :: springs_type
      real(wp) :: normal   !< k_n, N/m per metre of thickness
      real(wp) :: shear    !< k_s
      real(wp) :: kept     !< share of it under sliding contacts
   end type springs_type

   !> Springs and forces as they were last assembled.
   type :: held_type
      logical :: anew = .true.               !< the contacts or the base are others: all is due
      integer, allocatable :: due(:)         !< [blocks] what has to be assembled again
      integer, allocatable :: news(:)        !< [contacts] what that is for
      !> [contacts] shear spring, N/m; negative: the contact is open
      real(wp), allocatable :: shear(:)
      real(wp), allocatable :: push(:)       !< [contacts] normal force at d = 0, N/m
      real(wp), allocatable :: drag(:)       !< [contacts] shear force at d = 0, N/m
   end type held_type

contains

   subroutine prepare_held(held, n)
      type(held_type), intent(out) :: held
      integer, intent(in) :: n  !< blocks

      allocate (held%due(n), source=due_springs)
      allocate (held%news(0), held%shear(0), held%push(0), held%drag(0))
   end subroutine prepare_held

   !> Hold the contacts in their assumed states; their blocks become due where that is news.
   subroutine hold_contacts(held, contacts, springs)
      type(held_type), intent(inout) :: held
      type(contacts_type), intent(in) :: contacts
      type(springs_type), intent(in) :: springs
      integer :: p, c

      if (size(held%news) < contacts%n) call make_room(held, size(contacts%state))
      if (contacts%n < parallel_from) then
         call hold_some(held, contacts, springs, 1, contacts%n)
      else
         !$omp parallel do schedule(static)
         do p = 1, pieces(contacts%n)
            call hold_some(held, contacts, springs, first_of(p, contacts%n), last_of(p, contacts%n))
         end do
      end if
      if (held%anew) held%due = due_springs
      if (held%anew) return
      do c = 1, contacts%n
         if (held%news(c) == due_nothing) cycle
         associate (v => contacts%block_v(c), e => contacts%block_e(c))
            held%due(v) = max(held%due(v), held%news(c))
            held%due(e) = max(held%due(e), held%news(c))
         end associate
      end do
   end subroutine hold_contacts

   subroutine make_room(held, room)
      type(held_type), intent(inout) :: held
      integer, intent(in) :: room

      deallocate (held%news, held%shear, held%push, held%drag)
      allocate (held%news(room), source=due_nothing)
      allocate (held%shear(room), held%push(room), held%drag(room), source=0.0_wp)
      held%anew = .true.
   end subroutine make_room

   pure subroutine hold_some(held, contacts, springs, first, last)
      type(held_type), intent(inout) :: held
      type(contacts_type), intent(in) :: contacts
      type(springs_type), intent(in) :: springs
      integer, intent(in) :: first, last
      real(wp) :: shear, push, drag
      integer :: c

      do c = first, last
         shear = shear_spring(contacts, springs, c)
         call forces_at_rest(contacts, springs, c, push, drag)
         held%news(c) = due_nothing
         if (.not. (same_bits(push, held%push(c)) .and. same_bits(drag, held%drag(c)))) &
            held%news(c) = due_forces
         if (.not. same_bits(shear, held%shear(c))) held%news(c) = due_springs
         held%shear(c) = shear
         held%push(c) = push
         held%drag(c) = drag
      end do
   end subroutine hold_some

   !> Also the sign of zero and what is no number.
   elemental logical function same_bits(a, b)
      real(wp), intent(in) :: a, b

      same_bits = transfer(a, 0_long) == transfer(b, 0_long)
   end function same_bits

   !> Shear stiffness of a contact in its assumed state.
   pure real(wp) function shear_spring(contacts, springs, c)
      type(contacts_type), intent(in) :: contacts
      type(springs_type), intent(in) :: springs
      integer, intent(in) :: c

      shear_spring = merge(springs%shear, springs%kept*springs%shear, &
         contacts%state(c) == contact_stick)
      if (contacts%state(c) == contact_open) shear_spring = no_spring
   end function shear_spring

   !> Normal and shear force of contact c at d = 0 in its assumed state.
   pure subroutine forces_at_rest(contacts, springs, c, push, drag)
      type(contacts_type), intent(in) :: contacts
      type(springs_type), intent(in) :: springs
      integer, intent(in) :: c
      real(wp), intent(out) :: push, drag

      push = 0.0_wp
      drag = 0.0_wp
      if (contacts%state(c) == contact_open) return
      push = contacts%multiplier(c) - springs%normal*contacts%gap(c)
      drag = springs%shear*contacts%stretch(c)
      if (contacts%state(c) == contact_slide) drag = contacts%slide_force(c) &
         - springs%kept*springs%shear*contacts%slide_slip(c)
   end subroutine forces_at_rest

end module dda_held_springs
