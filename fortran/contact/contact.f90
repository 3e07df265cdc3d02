!> Contacts: a vertex of one block against an edge of another, with springs and a history.
!>
!> Lists are rebuilt every step from geometry; what a contact has lived through (state, shear
!> stretch, bond) is handed on from the list of the step before.
module dda_contact
   use dda_kinds, only: wp
   implicit none
   private
   public :: contacts_type, reserve, exchange_rows, keep_contacts, contact_open, contact_slide, &
      contact_stick

   integer, parameter :: contact_open = 0   !< no force
   integer, parameter :: contact_slide = 1  !< normal spring, shear force at its limit
   integer, parameter :: contact_stick = 2  !< normal and shear spring

   !> A list of contacts as structure of arrays; entries 1 … n count.
   type :: contacts_type
      integer :: n = 0
      ! Who touches whom
      integer, allocatable :: vertex(:)        !< vertex that touches
      integer, allocatable :: edge(:)          !< edge touched, named by its first vertex
      integer, allocatable :: corner(:)        !< vertex met corner to corner, else 0
      integer, allocatable :: block_v(:)       !< block of the vertex
      integer, allocatable :: block_e(:)       !< block of the edge
      integer, allocatable :: pair(:)          !< near pair that the two blocks are
      integer, allocatable :: joint(:)         !< joint material
      ! Geometry at the start of the step
      !> signed distance to the edge less `offset`, m, negative: it presses
      real(wp), allocatable :: gap(:)
      real(wp), allocatable :: normal(:,:)     !< [2,n] outward normal of the edge
      real(wp), allocatable :: normal_v(:,:)   !< [6,n] ∂gap/∂q of the vertex block
      real(wp), allocatable :: normal_e(:,:)   !< [6,n] −∂gap/∂q of the edge block
      real(wp), allocatable :: shear_v(:,:)    !< [6,n] ∂slip/∂q of the vertex block
      real(wp), allocatable :: shear_e(:,:)    !< [6,n] −∂slip/∂q of the edge block
      ! History
      integer, allocatable :: state(:)         !< open, slide or stick
      logical, allocatable :: bonded(:)        !< cohesion and tension not yet lost
      logical, allocatable :: was_bonded(:)    !< at the start of the step
      logical, allocatable :: was_closed(:)    !< its normal spring held at the start of the step
      !> distance at which the contact begins to press, m, ≤ 0
      real(wp), allocatable :: offset(:)
      real(wp), allocatable :: bond_length(:)  !< length that the bond acts on, m
      real(wp), allocatable :: multiplier(:)   !< augmented Lagrangian multiplier, N/m, else 0
      real(wp), allocatable :: stretch(:)      !< elastic stretch of the shear spring, m
      ! The iteration: what is assumed, and what the solution answers
      real(wp), allocatable :: slide_force(:)  !< assumed shear force while sliding, N/m
      real(wp), allocatable :: slip_sign(:)    !< assumed sign of the shear force while sliding
      real(wp), allocatable :: slide_slip(:)   !< slip at which that was answered, m
      integer, allocatable :: close_count(:)   !< how often it has closed in this step's iteration
      integer, allocatable :: trial_state(:)   !< state that the solution calls for
      !> largest difference between assumed and computed force, N/m
      real(wp), allocatable :: force_residual(:)
      real(wp), allocatable :: new_gap(:)      !< gap at the end of the step, linear in d, m
      real(wp), allocatable :: slip(:)         !< slip during the step, linear in d, m
      real(wp), allocatable :: gap_change(:)   !< change of the gap by the last solve, m
      real(wp), allocatable :: slip_change(:)  !< change of the slip by the last solve, m
      !> excess of force over the strength of a bond, of that strength
      real(wp), allocatable :: strength_ratio(:)
      real(wp), allocatable :: normal_force(:) !< compression positive, N/m
      real(wp), allocatable :: shear_force(:)  !< resists slip of the vertex along the edge, N/m
   end type contacts_type

contains

   !> Make room for at least `wanted` contacts; what is in the list stays.
   subroutine reserve(contacts, wanted)
      type(contacts_type), intent(inout) :: contacts
      integer, intent(in) :: wanted
      integer :: room

      if (allocated(contacts%vertex)) then
         if (size(contacts%vertex) >= wanted) return
      end if
      room = wanted + wanted/4 + 8
      call grow_list(contacts%vertex, room)
      call grow_list(contacts%edge, room)
      call grow_list(contacts%corner, room)
      call grow_list(contacts%block_v, room)
      call grow_list(contacts%block_e, room)
      call grow_list(contacts%pair, room)
      call grow_list(contacts%joint, room)
      call grow_list(contacts%state, room)
      call grow_flags(contacts%bonded, room)
      call grow_flags(contacts%was_bonded, room)
      call grow_flags(contacts%was_closed, room)
      call grow_values(contacts%gap, room)
      call grow_values(contacts%offset, room)
      call grow_values(contacts%bond_length, room)
      call grow_values(contacts%stretch, room)
      call grow_values(contacts%multiplier, room)
      call grow_list(contacts%trial_state, room)
      call grow_list(contacts%close_count, room)
      call grow_values(contacts%slide_force, room)
      call grow_values(contacts%force_residual, room)
      call grow_values(contacts%slide_slip, room)
      call grow_values(contacts%slip_sign, room)
      call grow_values(contacts%new_gap, room)
      call grow_values(contacts%slip, room)
      call grow_values(contacts%gap_change, room)
      call grow_values(contacts%slip_change, room)
      call grow_values(contacts%strength_ratio, room)
      call grow_values(contacts%normal_force, room)
      call grow_values(contacts%shear_force, room)
      call grow_rows(contacts%normal, 2, room)
      call grow_rows(contacts%normal_v, 6, room)
      call grow_rows(contacts%normal_e, 6, room)
      call grow_rows(contacts%shear_v, 6, room)
      call grow_rows(contacts%shear_e, 6, room)
   end subroutine reserve

   !> Two lists of the same room exchange the memory of their rows.
   pure subroutine exchange_rows(a, b)
      type(contacts_type), intent(inout) :: a, b

      if (size(a%vertex) /= size(b%vertex)) return
      call exchange(a%normal_v, b%normal_v)
      call exchange(a%normal_e, b%normal_e)
      call exchange(a%shear_v, b%shear_v)
      call exchange(a%shear_e, b%shear_e)
   end subroutine exchange_rows

   pure subroutine exchange(a, b)
      real(wp), allocatable, intent(inout) :: a(:,:), b(:,:)
      real(wp), allocatable :: kept(:,:)

      call move_alloc(a, kept)
      call move_alloc(b, a)
      call move_alloc(kept, b)
   end subroutine exchange

   !> Drop contacts from a list that has identities, geometry and history, and no answers yet.
   subroutine keep_contacts(contacts, kept)
      type(contacts_type), intent(inout) :: contacts
      logical, intent(in) :: kept(:)  !< [n]
      integer :: c, to

      to = 0
      do c = 1, contacts%n
         if (.not. kept(c)) cycle
         to = to + 1
         if (to < c) call move_contact(contacts, c, to)
      end do
      contacts%n = to
   end subroutine keep_contacts

   pure subroutine move_contact(contacts, from, to)
      type(contacts_type), intent(inout) :: contacts
      integer, intent(in) :: from, to

      contacts%vertex(to) = contacts%vertex(from)
      contacts%edge(to) = contacts%edge(from)
      contacts%corner(to) = contacts%corner(from)
      contacts%block_v(to) = contacts%block_v(from)
      contacts%block_e(to) = contacts%block_e(from)
      contacts%pair(to) = contacts%pair(from)
      contacts%joint(to) = contacts%joint(from)
      contacts%gap(to) = contacts%gap(from)
      contacts%normal(:, to) = contacts%normal(:, from)
      contacts%normal_v(:, to) = contacts%normal_v(:, from)
      contacts%normal_e(:, to) = contacts%normal_e(:, from)
      contacts%shear_v(:, to) = contacts%shear_v(:, from)
      contacts%shear_e(:, to) = contacts%shear_e(:, from)
      contacts%state(to) = contacts%state(from)
      contacts%bonded(to) = contacts%bonded(from)
      contacts%offset(to) = contacts%offset(from)
      contacts%bond_length(to) = contacts%bond_length(from)
      contacts%multiplier(to) = contacts%multiplier(from)
      contacts%stretch(to) = contacts%stretch(from)
      contacts%slide_force(to) = contacts%slide_force(from)
      contacts%slip_sign(to) = contacts%slip_sign(from)
   end subroutine move_contact

   subroutine grow_list(list, room)
      integer, allocatable, intent(inout) :: list(:)
      integer, intent(in) :: room
      integer, allocatable :: larger(:)

      allocate (larger(room), source=0)
      if (allocated(list)) larger(:size(list)) = list
      call move_alloc(larger, list)
   end subroutine grow_list

   subroutine grow_flags(list, room)
      logical, allocatable, intent(inout) :: list(:)
      integer, intent(in) :: room
      logical, allocatable :: larger(:)

      allocate (larger(room), source=.false.)
      if (allocated(list)) larger(:size(list)) = list
      call move_alloc(larger, list)
   end subroutine grow_flags

   subroutine grow_values(list, room)
      real(wp), allocatable, intent(inout) :: list(:)
      integer, intent(in) :: room
      real(wp), allocatable :: larger(:)

      allocate (larger(room), source=0.0_wp)
      if (allocated(list)) larger(:size(list)) = list
      call move_alloc(larger, list)
   end subroutine grow_values

   subroutine grow_rows(list, rows, room)
      real(wp), allocatable, intent(inout) :: list(:,:)
      integer, intent(in) :: rows, room
      real(wp), allocatable :: larger(:,:)

      allocate (larger(rows, room), source=0.0_wp)
      if (allocated(list)) larger(:, :size(list, 2)) = list
      call move_alloc(larger, list)
   end subroutine grow_rows

end module dda_contact
