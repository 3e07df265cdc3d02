! SPDX-License-Identifier: GPL-3.0-or-later
!> Contacts: a vertex of one block against an edge of another, with springs and a history.
!>
!> Lists are rebuilt every step from geometry; the history of a contact (state, shear stretch, bond)
!> is transferred from the list of the step before.  What a step alone needs, two thirds of a list,
!> only one of the two has: `hand_over` gives it to the other one.
!>
!> A new variable is declared in `contacts_type` and named in `for_each_kept`, if the next step asks
!> for it, or in `for_each_of_step` and `hand_over`: so it is reserved, compacted and serialised.
!> One that outlives the step is also named in `copy_history`.
module dda_contact
   use dda_growth, only: grow
   use dda_kinds, only: wp
   implicit none
   private
   public :: contacts_type, operation_type, for_each_variable, reserve, capacity_of, hand_over, &
      filter_contacts, copy_history, is_point, contact_open, contact_slide, contact_stick
   public :: not_damped, is_damped, is_struck, is_carried, is_lifted

   integer, parameter :: contact_open = 0   !< no force
   integer, parameter :: contact_slide = 1  !< normal spring, shear force at its limit
   integer, parameter :: contact_stick = 2  !< normal and shear spring

   ! How its springs act in this step, see dda_contact_damping.
   integer, parameter :: not_damped = 0     !< as springs alone
   integer, parameter :: is_damped = 1      !< with dashpots
   integer, parameter :: is_struck = 2      !< by the impact law: it is hit in this step
   integer, parameter :: is_carried = 3     !< by the impact law: one of its blocks is hit
   integer, parameter :: is_lifted = 4      !< opened by the impact: keeps a fraction of its force

   integer, parameter :: spare = 64         !< one more contact per so many is reserved

   !> A list of contacts as structure of arrays; entries 1 … n count.
   type :: contacts_type
      integer :: n = 0
      ! Identity
      integer, allocatable :: vertex(:)        !< vertex that touches; edge of a point that does
      integer, allocatable :: edge(:)          !< edge touched, named by its first vertex
      integer, allocatable :: corner(:)        !< vertex met corner to corner, else 0
      integer, allocatable :: block_v(:)       !< block of the vertex
      integer, allocatable :: block_e(:)       !< block of the edge
      integer, allocatable :: pair(:)          !< near pair that the two blocks are
      ! Geometry at the start of the step
      !> signed distance to the edge less `offset`, m; negative in compression
      real(wp), allocatable :: gap(:)
      real(wp), allocatable :: normal(:,:)     !< [2,n] outward normal of the edge
      !> [6,n] gradients of the vertex' and of the edge's block, see dda_contact_gradients
      real(wp), allocatable :: gradient_v(:,:), gradient_e(:,:)
      ! History
      integer, allocatable :: joint(:)         !< joint material, see dda_contact_joints
      integer, allocatable :: state(:)         !< open, slide or stick
      logical, allocatable :: bonded(:)        !< cohesion and tension not yet lost
      logical, allocatable :: was_bonded(:)    !< at the start of the step
      logical, allocatable :: was_closed(:)    !< its normal spring acted at the start of the step
      !> signed distance at which the normal spring is free of force, m, ≤ 0
      real(wp), allocatable :: offset(:)
      real(wp), allocatable :: stretch(:)      !< elastic stretch of the shear spring, m
      ! Where a model has multipliers, or joints that can lose a strength
      logical :: with_multipliers = .false.
      logical :: with_strengths = .false.
      real(wp), allocatable :: multiplier(:)   !< of the augmented Lagrangian, N/m
      real(wp), allocatable :: bond_length(:)  !< length that the bond acts on, m
      !> excess of force over the strength of a bond, of that strength
      real(wp), allocatable :: strength_ratio(:)
      ! History and linearised normal force of joint laws, where a model has other than plain ones
      logical :: with_laws = .false.
      real(wp), allocatable :: length(:)       !< tributary length, m; 0: not yet taken
      integer, allocatable :: point(:)         !< of an overlap, see dda_contact_points; 0: corner
      real(wp), allocatable :: fraction(:)     !< of a point: of the edge before it, else 0
      real(wp), allocatable :: share(:)        !< of the stiffness of a contact, 1 at a corner
      real(wp), allocatable :: slip_path(:)    !< slip beyond the elastic one, added up, m
      real(wp), allocatable :: weakened(:)     !< 0: peak strength, 1: residual strength
      real(wp), allocatable :: was_weakened(:) !< at the start of the step
      real(wp), allocatable :: tangent(:)      !< slope of the normal force, N/m
      real(wp), allocatable :: normal_free(:)  !< assumed normal force at no gap, N/m
      ! The same, where some law asks for the way of slip
      logical :: with_net_slip = .false.
      real(wp), allocatable :: net_slip(:)     !< slip beyond the elastic one, with its sign, m
      real(wp), allocatable :: lifted(:)       !< how far that has lifted the contact, m
      real(wp), allocatable :: spent(:,:)      !< [2,n] bounds of the fracture energy spent, N/m
      real(wp), allocatable :: acting_damage(:) !< at which its bond acts in this step, else 1
      real(wp), allocatable :: slider(:)       !< shear force of friction if nothing of it is bond
      !> in this step it has slipped back to its centre first: assumed; by the law at the solution
      logical, allocatable :: past_centre(:), trial_past_centre(:)
      ! Damping and impacts, where a model has joints with them
      logical :: with_damping = .false.
      integer, allocatable :: damping(:)       !< how it acts in this step
      real(wp), allocatable :: gap_rate(:)     !< velocity of the gap at the start of the step, m/s
      real(wp), allocatable :: slip_rate(:)    !< velocity of the slip then, m/s
      real(wp), allocatable :: lead(:)         !< s: its spring acts at gap + lead × gap_rate
      real(wp), allocatable :: spring_gap(:)   !< where that is at the start of the step, m
      real(wp), allocatable :: static_force(:) !< compression without that of impacts, N/m
      real(wp), allocatable :: normal_gain(:)  !< change of the acting gap by that of the gap
      real(wp), allocatable :: shear_gain(:)   !< the same of the stretch by the slip
      real(wp), allocatable :: normal_shift(:) !< of the acting gap, m
      real(wp), allocatable :: shear_shift(:)  !< of the acting stretch, m
      ! Open–close iteration: assumed forces, and the response to the solution d
      real(wp), allocatable :: slide_force(:)  !< assumed shear force while sliding, N/m
      real(wp), allocatable :: slip_sign(:)    !< assumed sign of the shear force while sliding
      !> [2,n] springs and forces at d = 0 in place of those of the states, N/m, see
      !> dda_static_relaxation; else not allocated
      real(wp), allocatable :: imposed_spring(:,:), imposed_force(:,:)
      !> frozen bounds of friction, N/m, see dda_friction_bounds; else not allocated
      real(wp), allocatable :: held_bound(:)
      !> share of a spring that the assumed state does without: of the shear spring of a sliding
      !> contact, of the normal spring of an open one
      real(wp), allocatable :: retained(:)
      real(wp), allocatable :: retained_at(:)  !< slip or gap at which that share has no force, m
      real(wp), allocatable :: spring(:,:)     !< [2,n] normal and shear stiffness in K̂, N/m
      real(wp), allocatable :: free_force(:,:) !< [2,n] assumed normal and shear force at d = 0, N/m
      integer, allocatable :: close_count(:)   !< how often it has closed in this step's iteration
      integer, allocatable :: trial_state(:)   !< state that the solution calls for
      !> largest difference between assumed and computed force, N/m
      real(wp), allocatable :: force_residual(:)
      real(wp), allocatable :: new_gap(:)      !< gap at the end of the step, linear in d, m
      real(wp), allocatable :: slip(:)         !< slip during the step, linear in d, m
      !> change of the gap and of the slip by the last solve, m, as soon as a line is searched
      real(wp), allocatable :: gap_change(:), slip_change(:)
      real(wp), allocatable :: normal_force(:) !< compression positive, N/m
      real(wp), allocatable :: shear_force(:)  !< resists slip of the vertex along the edge, N/m
   end type contacts_type

   !> An operation on every variable of a list, see `for_each_variable`.
   type, abstract :: operation_type
   contains
      procedure(apply_operation), deferred :: apply
   end type operation_type

   abstract interface
      !> Apply the operation to one variable: exactly one of the arrays is present.
      subroutine apply_operation(operation, integers, logicals, reals, columns)
         import :: operation_type, wp
         class(operation_type), intent(inout) :: operation
         integer, allocatable, intent(inout), optional :: integers(:)   !< [capacity]
         logical, allocatable, intent(inout), optional :: logicals(:)   !< [capacity]
         real(wp), allocatable, intent(inout), optional :: reals(:)     !< [capacity]
         real(wp), allocatable, intent(inout), optional :: columns(:,:) !< [any, capacity]
      end subroutine apply_operation
   end interface

   !> Enlarge the arrays.
   type, extends(operation_type) :: growth_type
      integer :: capacity  !< contacts
   contains
      procedure :: apply => grow_variable
   end type growth_type

   !> Compact the arrays.
   type, extends(operation_type) :: filter_type
      logical, allocatable :: keep(:)  !< [n]
   contains
      procedure :: apply => filter_variable
   end type filter_type

contains

   !> Apply an operation to every variable of a list, in the order of the checkpoint.
   subroutine for_each_variable(contacts, operation)
      type(contacts_type), intent(inout) :: contacts            !< list operated on
      class(operation_type), intent(inout) :: operation         !< called for one array at a time

      call for_each_kept(contacts, operation)
      call for_each_of_step(contacts, operation)
   end subroutine for_each_variable

   !> Apply an operation to what the next step asks of a list.
   subroutine for_each_kept(contacts, operation)
      type(contacts_type), intent(inout) :: contacts            !< list operated on
      class(operation_type), intent(inout) :: operation         !< called for one array at a time

      call operation%apply(integers=contacts%vertex)
      call operation%apply(integers=contacts%edge)
      call operation%apply(integers=contacts%corner)
      call operation%apply(integers=contacts%block_v)
      call operation%apply(integers=contacts%block_e)
      call operation%apply(columns=contacts%normal)
      call operation%apply(integers=contacts%joint)
      call operation%apply(integers=contacts%state)
      call operation%apply(logicals=contacts%bonded)
      call operation%apply(reals=contacts%offset)
      call operation%apply(reals=contacts%stretch)
      call operation%apply(reals=contacts%slide_force)
      call operation%apply(reals=contacts%slip_sign)
      call operation%apply(columns=contacts%spring)
      call operation%apply(reals=contacts%new_gap)
      if (contacts%with_multipliers) call operation%apply(reals=contacts%multiplier)
      if (contacts%with_strengths) call operation%apply(reals=contacts%bond_length)
      if (contacts%with_damping) call operation%apply(reals=contacts%static_force)
      if (.not. contacts%with_laws) return
      call operation%apply(integers=contacts%point)
      call operation%apply(reals=contacts%fraction)
      call operation%apply(reals=contacts%share)
      call operation%apply(reals=contacts%length)
      call operation%apply(reals=contacts%slip_path)
      call operation%apply(reals=contacts%weakened)
      if (.not. contacts%with_net_slip) return
      call operation%apply(reals=contacts%net_slip)
      call operation%apply(reals=contacts%lifted)
      call operation%apply(columns=contacts%spent)
   end subroutine for_each_kept

   !> Apply an operation to what a list has for its own step alone.
   subroutine for_each_of_step(contacts, operation)
      type(contacts_type), intent(inout) :: contacts            !< list operated on
      class(operation_type), intent(inout) :: operation         !< called for one array at a time

      call operation%apply(integers=contacts%pair)
      call operation%apply(reals=contacts%gap)
      call operation%apply(columns=contacts%gradient_v)
      call operation%apply(columns=contacts%gradient_e)
      call operation%apply(logicals=contacts%was_bonded)
      call operation%apply(logicals=contacts%was_closed)
      call operation%apply(reals=contacts%retained)
      call operation%apply(reals=contacts%retained_at)
      call operation%apply(columns=contacts%free_force)
      call operation%apply(integers=contacts%close_count)
      call operation%apply(integers=contacts%trial_state)
      call operation%apply(reals=contacts%force_residual)
      call operation%apply(reals=contacts%slip)
      call operation%apply(reals=contacts%normal_force)
      call operation%apply(reals=contacts%shear_force)
      if (contacts%with_strengths) call operation%apply(reals=contacts%strength_ratio)
      if (contacts%with_damping) call for_each_of_damping(contacts, operation)
      if (.not. contacts%with_laws) return
      call operation%apply(reals=contacts%was_weakened)
      call operation%apply(reals=contacts%tangent)
      call operation%apply(reals=contacts%normal_free)
      if (.not. contacts%with_net_slip) return
      call operation%apply(logicals=contacts%past_centre)
      call operation%apply(logicals=contacts%trial_past_centre)
      call operation%apply(reals=contacts%acting_damage)
      call operation%apply(reals=contacts%slider)
   end subroutine for_each_of_step

   !> Apply an operation to the variables of damping and impacts.
   subroutine for_each_of_damping(contacts, operation)
      type(contacts_type), intent(inout) :: contacts            !< list operated on
      class(operation_type), intent(inout) :: operation         !< called for one array at a time

      call operation%apply(integers=contacts%damping)
      call operation%apply(reals=contacts%gap_rate)
      call operation%apply(reals=contacts%slip_rate)
      call operation%apply(reals=contacts%lead)
      call operation%apply(reals=contacts%spring_gap)
      call operation%apply(reals=contacts%normal_gain)
      call operation%apply(reals=contacts%shear_gain)
      call operation%apply(reals=contacts%normal_shift)
      call operation%apply(reals=contacts%shear_shift)
   end subroutine for_each_of_damping

   !> Give the memory of what a step alone needs to another list; its values are then undefined.
   pure subroutine hand_over(from, to)
      type(contacts_type), intent(inout) :: from, to  !< lists of one run

      if (.not. allocated(from%pair)) return
      call move_alloc(from%pair, to%pair)
      call move_alloc(from%gap, to%gap)
      call move_alloc(from%gradient_v, to%gradient_v)
      call move_alloc(from%gradient_e, to%gradient_e)
      call move_alloc(from%was_bonded, to%was_bonded)
      call move_alloc(from%was_closed, to%was_closed)
      call move_alloc(from%retained, to%retained)
      call move_alloc(from%retained_at, to%retained_at)
      call move_alloc(from%free_force, to%free_force)
      call move_alloc(from%close_count, to%close_count)
      call move_alloc(from%trial_state, to%trial_state)
      call move_alloc(from%force_residual, to%force_residual)
      call move_alloc(from%slip, to%slip)
      call move_alloc(from%normal_force, to%normal_force)
      call move_alloc(from%shear_force, to%shear_force)
      if (allocated(from%gap_change)) then
         call move_alloc(from%gap_change, to%gap_change)
         call move_alloc(from%slip_change, to%slip_change)
      end if
      if (from%with_strengths) call move_alloc(from%strength_ratio, to%strength_ratio)
      if (from%with_damping) call hand_over_damping(from, to)
      if (.not. from%with_laws) return
      call move_alloc(from%was_weakened, to%was_weakened)
      call move_alloc(from%tangent, to%tangent)
      call move_alloc(from%normal_free, to%normal_free)
      if (.not. from%with_net_slip) return
      call move_alloc(from%past_centre, to%past_centre)
      call move_alloc(from%trial_past_centre, to%trial_past_centre)
      call move_alloc(from%acting_damage, to%acting_damage)
      call move_alloc(from%slider, to%slider)
   end subroutine hand_over

   !> The same of the variables of damping and impacts.
   pure subroutine hand_over_damping(from, to)
      type(contacts_type), intent(inout) :: from, to  !< lists of one run

      call move_alloc(from%damping, to%damping)
      call move_alloc(from%gap_rate, to%gap_rate)
      call move_alloc(from%slip_rate, to%slip_rate)
      call move_alloc(from%lead, to%lead)
      call move_alloc(from%spring_gap, to%spring_gap)
      call move_alloc(from%normal_gain, to%normal_gain)
      call move_alloc(from%shear_gain, to%shear_gain)
      call move_alloc(from%normal_shift, to%normal_shift)
      call move_alloc(from%shear_shift, to%shear_shift)
   end subroutine hand_over_damping

   !> Contact c is a point between corners: its `vertex` names an edge.
   pure logical function is_point(contacts, c)
      type(contacts_type), intent(in) :: contacts  !< a list
      integer, intent(in) :: c                     !< number of the contact

      is_point = contacts%with_laws
      if (is_point) is_point = contacts%point(c) > 0
   end function is_point

   !> Copy the history of contacts from place `from` of the old list to `first` … `last` of the new.
   !>
   !> The slip of a vertex along an edge keeps its sign when the two blocks change roles, so the
   !> stretch is copied as it is.  Array by array: with most contacts in unchanged places, runs are
   !> long.
   pure subroutine copy_history(new, first, last, old, from)
      type(contacts_type), intent(inout) :: new  !< list that receives
      integer, intent(in) :: first, last         !< places in `new`
      type(contacts_type), intent(in) :: old     !< list of the step before
      integer, intent(in) :: from                !< first place in `old`
      integer :: to

      to = from + last - first
      new%joint(first:last) = old%joint(from:to)
      new%state(first:last) = old%state(from:to)
      new%bonded(first:last) = old%bonded(from:to)
      new%stretch(first:last) = old%stretch(from:to)
      new%slide_force(first:last) = old%slide_force(from:to)
      new%slip_sign(first:last) = old%slip_sign(from:to)
      new%spring(:, first:last) = old%spring(:, from:to)
      if (new%with_multipliers) new%multiplier(first:last) = old%multiplier(from:to)
      if (new%with_strengths) new%bond_length(first:last) = old%bond_length(from:to)
      if (new%with_damping) new%static_force(first:last) = old%static_force(from:to)
      if (.not. new%with_laws) return
      new%fraction(first:last) = old%fraction(from:to)
      new%share(first:last) = old%share(from:to)
      new%length(first:last) = old%length(from:to)
      new%slip_path(first:last) = old%slip_path(from:to)
      new%weakened(first:last) = old%weakened(from:to)
      if (.not. new%with_net_slip) return
      new%net_slip(first:last) = old%net_slip(from:to)
      new%lifted(first:last) = old%lifted(from:to)
      new%spent(:, first:last) = old%spent(:, from:to)
   end subroutine copy_history

   !> Contacts that a list has memory for; what goes along with a list is as long.
   pure integer function capacity_of(contacts) result(capacity)
      type(contacts_type), intent(in) :: contacts  !< any list

      capacity = 0
      if (allocated(contacts%new_gap)) capacity = size(contacts%new_gap)
   end function capacity_of

   !> Reserve memory for at least `wanted` contacts; the present ones stay.
   subroutine reserve(contacts, wanted)
      type(contacts_type), intent(inout) :: contacts  !< list to enlarge
      integer, intent(in) :: wanted                   !< contacts
      type(growth_type) :: growth

      if (.not. allocated(contacts%normal)) allocate (contacts%normal(2, 0), &
         contacts%spring(2, 0), contacts%spent(2, 0))
      if (.not. allocated(contacts%gradient_v)) allocate (contacts%gradient_v(6, 0), &
         contacts%gradient_e(6, 0), contacts%free_force(2, 0))
      growth%capacity = wanted + wanted/spare + 8
      if (size(contacts%normal, 2) < max(wanted, 1)) call for_each_kept(contacts, growth)
      if (size(contacts%gradient_v, 2) < max(wanted, 1)) call for_each_of_step(contacts, growth)
   end subroutine reserve

   subroutine grow_variable(operation, integers, logicals, reals, columns)
      class(growth_type), intent(inout) :: operation                 !< wanted capacity
      integer, allocatable, intent(inout), optional :: integers(:)   !< [capacity]
      logical, allocatable, intent(inout), optional :: logicals(:)   !< [capacity]
      real(wp), allocatable, intent(inout), optional :: reals(:)     !< [capacity]
      real(wp), allocatable, intent(inout), optional :: columns(:,:) !< [any, capacity]

      if (present(integers)) call grow(integers, operation%capacity, exactly=.true.)
      if (present(logicals)) call grow(logicals, operation%capacity, exactly=.true.)
      if (present(reals)) call grow(reals, operation%capacity, exactly=.true.)
      if (present(columns)) call grow(columns, size(columns, 1), operation%capacity, exactly=.true.)
   end subroutine grow_variable

   !> Keep some contacts of a list, in their order.
   subroutine filter_contacts(contacts, keep)
      type(contacts_type), intent(inout) :: contacts  !< list to compact
      logical, intent(in) :: keep(:)                  !< [n]
      type(filter_type) :: filter

      allocate (filter%keep, source=keep)
      call for_each_variable(contacts, filter)
      contacts%n = count(keep)
   end subroutine filter_contacts

   subroutine filter_variable(operation, integers, logicals, reals, columns)
      class(filter_type), intent(inout) :: operation                 !< which contacts stay
      integer, allocatable, intent(inout), optional :: integers(:)   !< [capacity]
      logical, allocatable, intent(inout), optional :: logicals(:)   !< [capacity]
      real(wp), allocatable, intent(inout), optional :: reals(:)     !< [capacity]
      real(wp), allocatable, intent(inout), optional :: columns(:,:) !< [any, capacity]
      integer :: c, to

      to = 0
      do c = 1, size(operation%keep)
         if (.not. operation%keep(c)) cycle
         to = to + 1
         if (present(integers)) integers(to) = integers(c)
         if (present(logicals)) logicals(to) = logicals(c)
         if (present(reals)) reals(to) = reals(c)
         if (present(columns)) columns(:, to) = columns(:, c)
      end do
   end subroutine filter_variable

end module dda_contact
