! SPDX-License-Identifier: GPL-3.0-or-later
!> What K̂ and f̂ hold of the contacts, so that only what differs is assembled again.
!>
!> Within a step the geometry of the contacts stays and the open–close iteration changes few of
!> their states: a contact whose spring or force is other than held marks both its blocks as dirty.
module dda_contact_terms
   use dda_kinds, only: wp, long
   use dda_contact, only: contacts_type, contact_open, contact_slide, contact_stick
   use dda_friction, only: laws_type, acts_at_theta, shear_stiffness_of
   use dda_growth, only: grow
   use dda_ordered_sums, only: pieces, first_of, last_of, parallel_from
   implicit none
   private
   public :: contact_terms_type, prepare_contact_terms, hold_contacts, normal_spring, &
      line_spring, shear_spring, is_clean, is_dirty_force, is_dirty_stiffness

   integer, parameter :: is_clean = 0
   integer, parameter :: is_dirty_force = 1      !< the right-hand side
   integer, parameter :: is_dirty_stiffness = 2  !< the matrix too

   real(wp), parameter :: no_spring = -1.0_wp    !< in place of the shear spring of an open contact

   !> Springs and forces as they were last assembled.
   type :: contact_terms_type
      logical :: rebuild = .true.                !< the contacts or the linear part are others
      logical :: damped = .false.                !< some springs have a gain
      integer, allocatable :: dirty(:)           !< [blocks] what has to be assembled again
      integer, allocatable :: changed(:)         !< [contacts] what that is for
      real(wp), allocatable :: shear(:)          !< [contacts] spring, N/m; negative: it is open
      real(wp), allocatable :: normal(:)         !< [contacts] spring of a joint law, N/m
      real(wp), allocatable :: normal_offset(:)  !< [contacts] normal force at d = 0, N/m
      real(wp), allocatable :: shear_offset(:)   !< [contacts] shear force at d = 0, N/m
   end type contact_terms_type

contains

   !> Nothing is held yet.
   subroutine prepare_contact_terms(held, n)
      type(contact_terms_type), intent(out) :: held  !< what K̂ and f̂ hold of the contacts
      integer, intent(in) :: n  !< blocks

      allocate (held%dirty(n), source=is_dirty_stiffness)
      allocate (held%changed(0), held%shear(0), held%normal(0), held%normal_offset(0), &
         held%shear_offset(0))
   end subroutine prepare_contact_terms

   !> Hold the contacts in their assumed states; blocks of those that have changed become dirty.
   subroutine hold_contacts(held, contacts, laws, retained)
      type(contact_terms_type), intent(inout) :: held  !< what K̂ and f̂ hold of the contacts
      type(contacts_type), intent(in) :: contacts  !< this step's list
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      real(wp), intent(in) :: retained  !< share of the shear springs under sliding contacts
      integer :: p, c

      if (size(held%changed) < contacts%n) call make_room(held, size(contacts%state), &
         contacts%with_laws)
      held%damped = laws%damped
      if (contacts%n < parallel_from) then
         call hold_range(held, contacts, laws, retained, 1, contacts%n)
      else
         !$omp parallel do schedule(static)
         do p = 1, pieces(contacts%n)
            call hold_range(held, contacts, laws, retained, first_of(p, contacts%n), &
               last_of(p, contacts%n))
         end do
      end if
      if (held%rebuild) held%dirty = is_dirty_stiffness
      if (held%rebuild) return
      do c = 1, contacts%n
         if (held%changed(c) == is_clean) cycle
         associate (v => contacts%block_v(c), e => contacts%block_e(c))
            held%dirty(v) = max(held%dirty(v), held%changed(c))
            held%dirty(e) = max(held%dirty(e), held%changed(c))
         end associate
      end do
   end subroutine hold_contacts

   subroutine make_room(held, room, with_laws)
      type(contact_terms_type), intent(inout) :: held  !< what K̂ and f̂ hold of the contacts
      integer, intent(in) :: room  !< contacts
      logical, intent(in) :: with_laws  !< normal springs differ

      call grow(held%changed, room)
      call grow(held%shear, room)
      call grow(held%normal_offset, room)
      if (with_laws) call grow(held%normal, room)
      call grow(held%shear_offset, room)
      held%rebuild = .true.
   end subroutine make_room

   !> Contacts first … last.
   pure subroutine hold_range(held, contacts, laws, retained, first, last)
      type(contact_terms_type), intent(inout) :: held  !< what K̂ and f̂ hold of the contacts
      type(contacts_type), intent(in) :: contacts  !< this step's list
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      real(wp), intent(in) :: retained  !< share of the shear springs under sliding contacts
      integer, intent(in) :: first, last  !< of the range
      real(wp) :: shear, normal_offset, shear_offset
      integer :: c

      do c = first, last
         shear = no_spring
         if (contacts%state(c) /= contact_open) shear = shear_spring(contacts, laws, c, &
            contacts%state(c), contacts%bonded(c), retained)
         if (laws%damped .and. shear > 0.0_wp) shear = contacts%shear_gain(c)*shear
         call forces_at_rest(contacts, laws, retained, c, normal_offset, shear_offset)
         held%changed(c) = is_clean
         if (.not. (same_bits(normal_offset, held%normal_offset(c)) .and. &
            same_bits(shear_offset, held%shear_offset(c)))) held%changed(c) = is_dirty_force
         if (.not. same_bits(shear, held%shear(c))) held%changed(c) = is_dirty_stiffness
         if (contacts%with_laws) call hold_line(held, contacts, laws, c)
         held%shear(c) = shear
         held%normal_offset(c) = normal_offset
         held%shear_offset(c) = shear_offset
      end do
   end subroutine hold_range

   !> The normal spring of a contact under a joint law.
   pure subroutine hold_line(held, contacts, laws, c)
      type(contact_terms_type), intent(inout) :: held  !< what K̂ and f̂ hold of the contacts
      type(contacts_type), intent(in) :: contacts  !< this step's list
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c  !< number of the contact
      real(wp) :: normal

      normal = line_spring(contacts, laws, c)
      if (.not. same_bits(normal, held%normal(c))) held%changed(c) = is_dirty_stiffness
      held%normal(c) = normal
   end subroutine hold_line

   !> Normal stiffness of contact c under a joint law in K̂, N/m: the slope of its line.
   pure real(wp) function line_spring(contacts, laws, c)
      type(contacts_type), intent(in) :: contacts  !< this step's list
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c  !< number of the contact

      line_spring = contacts%tangent(c)
      if (acts_at_theta(contacts, laws, c)) line_spring = laws%theta*line_spring
   end function line_spring

   !> Also the sign of zero and what is no number.
   elemental logical function same_bits(a, b)
      real(wp), intent(in) :: a, b

      same_bits = transfer(a, 0_long) == transfer(b, 0_long)
   end function same_bits

   !> Normal stiffness of a closed contact in K̂, N/m: θ k_n where it is bonded.
   pure real(wp) function normal_spring(laws, bonded)
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      logical, intent(in) :: bonded  !< the contact is

      normal_spring = laws%normal_stiffness
      if (bonded) normal_spring = laws%theta*laws%normal_stiffness
   end function normal_spring

   !> Shear stiffness of a closed contact in K̂, N/m.
   pure real(wp) function shear_spring(contacts, laws, c, state, bonded, retained)
      type(contacts_type), intent(in) :: contacts  !< this step's list
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c          !< number of the contact
      integer, intent(in) :: state      !< contact_slide or contact_stick
      logical, intent(in) :: bonded  !< the contact is
      real(wp), intent(in) :: retained  !< share of the spring under a sliding contact

      if (.not. laws%plain) then
         shear_spring = shear_stiffness_of(contacts, laws, c)
         if (state /= contact_stick) shear_spring = retained*shear_spring
         if (acts_at_theta(contacts, laws, c)) shear_spring = laws%theta*shear_spring
         return
      end if
      shear_spring = laws%shear_stiffness
      if (state /= contact_stick) shear_spring = retained*laws%shear_stiffness
      if (bonded) shear_spring = laws%theta*laws%shear_stiffness
   end function shear_spring

   !> Normal and shear force of contact c at d = 0 in its assumed state, N/m.
   pure subroutine forces_at_rest(contacts, laws, retained, c, normal_offset, shear_offset)
      type(contacts_type), intent(in) :: contacts  !< this step's list
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      real(wp), intent(in) :: retained  !< share of the shear springs under sliding contacts
      integer, intent(in) :: c  !< number of the contact
      real(wp), intent(out) :: normal_offset, shear_offset
      real(wp) :: stiffness

      normal_offset = 0.0_wp
      shear_offset = 0.0_wp
      if (contacts%state(c) == contact_open) return
      normal_offset = contacts%multiplier(c) - laws%normal_stiffness*contacts%gap(c)
      stiffness = laws%shear_stiffness
      if (.not. laws%plain) then
         normal_offset = contacts%normal_free(c) - contacts%tangent(c)*contacts%gap(c)
         stiffness = shear_stiffness_of(contacts, laws, c)
      end if
      shear_offset = stiffness*contacts%stretch(c)
      if (contacts%state(c) == contact_slide) shear_offset = contacts%slide_force(c) &
         - retained*stiffness*contacts%slide_slip(c)
      if (.not. laws%damped .or. contacts%bonded(c)) return
      normal_offset = contacts%multiplier(c) - laws%normal_stiffness*(contacts%gap(c) &
         + contacts%normal_shift(c))
      shear_offset = laws%shear_stiffness*(contacts%stretch(c) + contacts%shear_shift(c))
      if (contacts%state(c) == contact_slide) shear_offset = contacts%slide_force(c) &
         - retained*laws%shear_stiffness*contacts%shear_gain(c)*contacts%slide_slip(c)
   end subroutine forces_at_rest

end module dda_contact_terms
