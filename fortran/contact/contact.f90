! SPDX-License-Identifier: GPL-3.0-or-later
!> Contacts: a vertex of one block on an edge of another, with springs and a history.
!>
!> Lists are rebuilt every step from geometry; the history of a contact (state, shear stretch, bond)
!> is transferred from the list of the last step.  Two thirds of the variables are needed only
!> within a step; `move_step_arrays` moves their arrays from the old list to the new one.
!>
!> To add a variable, declare it in `contacts_type`.  Name it in `for_each_of_history` if the next
!> step needs it, else in `for_each_of_step` and `move_step_arrays`.  If the next list inherits it,
!> name it in `copy_history` too.  A joint law stores its variables in columns of `memory` that it
!> declares, see `column_type` in dda_joint_law.
module dda_contact
   use dda_growth, only: grow
   use dda_kinds, only: wp
   implicit none
   private
   public :: contacts_type, operation_type, for_each_variable, reserve, capacity_of, &
      move_step_arrays, filter_contacts, copy_contacts, copy_history, is_point, contact_open, &
      contact_slide, contact_stick
   public :: not_damped, is_damped, is_struck, is_carried, is_lifted

   integer, parameter :: contact_open = 0   !< no force
   integer, parameter :: contact_slide = 1  !< normal spring, and shear force at the limit
   integer, parameter :: contact_stick = 2  !< normal and shear spring

   ! Damping and impact of a contact in this step, see dda_contact_damping.
   integer, parameter :: not_damped = 0     !< springs without dashpots
   integer, parameter :: is_damped = 1      !< springs with dashpots
   integer, parameter :: is_struck = 2      !< impact law: its gap must open in this step
   integer, parameter :: is_carried = 3     !< impact law: closed contact of a struck block
   !> impact law: opened by an impact, retains part of its force
   integer, parameter :: is_lifted = 4

   integer, parameter :: usual_variables = 60  !< initial number of variables in a copy
   integer, parameter :: spare = 64  !< memory for one more contact per 64 contacts is allocated

   !> List of contacts as structure of arrays; entries 1 … n are used.
   type :: contacts_type
      ! unsaved, the input: with_laws, initial_memory
      ! unsaved, set in each step: time_step
      ! unsaved, allocated only within a step: frozen_bound, frozen_lifting
      ! unsaved, allocated only in a region of a step: fixed_motion
      ! unsaved, allocated only within a static step: imposed_spring, imposed_force
      ! unsaved, set before it is used: gap_change, slip_change
      integer :: n = 0
      ! Identity
      integer, allocatable :: vertex(:)    !< touching vertex; for a point between corners, its edge
      integer, allocatable :: edge(:)          !< touched edge, given by its first vertex
      integer, allocatable :: corner(:)        !< vertex of a contact of two corners, else 0
      integer, allocatable :: block_v(:)       !< block that owns the vertex
      integer, allocatable :: block_e(:)       !< block that owns the edge
      integer, allocatable :: pair(:)          !< number of the near pair of the two blocks
      ! Geometry at the start of the step
      !> signed distance to the edge minus `offset`, m; negative in compression
      real(wp), allocatable :: gap(:)
      real(wp), allocatable :: normal(:,:)     !< [2,n] outward normal of the edge
      !> [12,n] gradients of gap and slip for the block of the vertex and of the edge, see
      !> dda_contact_gradients
      real(wp), allocatable :: gradient_v(:,:), gradient_e(:,:)
      ! History
      integer, allocatable :: joint(:)       !< number of the joint material, see dda_contact_joints
      integer, allocatable :: state(:)         !< open, slide or stick
      logical, allocatable :: bonded(:)        !< bond with cohesion and tension is intact
      logical, allocatable :: was_bonded(:)    !< bonded at the start of the step
      logical, allocatable :: was_closed(:)    !< the normal spring acted at the start of the step
      !> signed distance at zero normal force, m: > 0 only with initial stress
      real(wp), allocatable :: offset(:)
      real(wp), allocatable :: stretch(:)      !< elastic stretch of the shear spring, m
      ! Only in models with multipliers, or with joints that can lose strength
      logical :: with_multipliers = .false.
      logical :: with_strengths = .false.
      real(wp), allocatable :: multiplier(:)   !< multiplier of the augmented Lagrangian, N/m
      real(wp), allocatable :: bond_length(:)  !< bonded length, m
      !> overload of a bond, (force − strength)/strength
      real(wp), allocatable :: strength_ratio(:)
      ! History and linearised normal force, only in models with joint laws
      logical :: with_laws = .false.
      real(wp), allocatable :: length(:)       !< tributary length, m; 0: not yet set
      integer, allocatable :: point(:)   !< number in the overlap (dda_contact_points); 0: corner
      real(wp), allocatable :: fraction(:)  !< position of a point as a fraction of the edge, else 0
      !> fraction of k_n and k_s; 1 for two contact points
      real(wp), allocatable :: stiffness_fraction(:)
      real(wp), allocatable :: memory(:,:)     !< [columns,n] memory of the joint laws
      !> [columns] initial memory of a contact without history
      real(wp), allocatable :: initial_memory(:)
      real(wp), allocatable :: was_weakened(:) !< column `weakened` at the start of the step
      !> [2,n] slopes: of the normal force −dN/dgap, and of the shear force if sticking, N/m
      real(wp), allocatable :: tangent(:,:)
      real(wp), allocatable :: line(:,:)  !< [2,n] tangent forces at zero gap, zero stretch, N/m
      !> [2,n] rise per unit of slip of a sliding contact with dilation: assumed value; value in K̂.
      !> The normal force acts along gap − rise × slip; `slide_force` is the remaining friction
      real(wp), allocatable :: tilt(:,:)
      real(wp) :: time_step = 0.0_wp           !< Δt of this step, s; 0 in static steps
      ! Only in models with a law that depends on the direction of slip
      logical :: with_net_slip = .false.
      real(wp), allocatable :: acting_damage(:) !< damage of the acting bond, else 1
      real(wp), allocatable :: slider(:)       !< friction force without the bond
      !> slip passes zero net slip in this step: assumed value; value by the law at the solution
      logical, allocatable :: past_centre(:), trial_past_centre(:)
      ! Damping and impacts, only in models with such joints
      logical :: with_damping = .false.
      integer, allocatable :: damping(:)  !< not_damped, is_damped, … (see above)
      real(wp), allocatable :: rate(:,:)       !< [2,n] rates of gap and slip at the start, m/s
      real(wp), allocatable :: lead(:)         !< lead, s: the spring acts at gap + lead × rate
      real(wp), allocatable :: spring_gap(:)   !< gap + lead × rate at the start of the step, m
      real(wp), allocatable :: static_force(:) !< normal force without impacts, N/m
      !> [2,n] derivatives: of the acting gap by the gap, and of the acting stretch by the slip
      real(wp), allocatable :: gain(:,:)
      real(wp), allocatable :: shift(:,:)      !< [2,n] shift of the acting gap and stretch, m
      ! Open–close iteration: assumed forces, and the response to the solution d
      real(wp), allocatable :: slide_force(:)  !< assumed shear force while sliding, N/m
      real(wp), allocatable :: slip_sign(:)    !< assumed sign of the shear force while sliding
      !> [2,n] springs and forces at d = 0, N/m, that replace the values by the contact states in
      !> dda_static_relaxation; else not allocated
      real(wp), allocatable :: imposed_spring(:,:), imposed_force(:,:)
      !> frozen friction bounds, or normal forces of contacts with dilation or a curve of slip, N/m,
      !> see dda_friction_bounds; else not allocated
      real(wp), allocatable :: frozen_bound(:)
      !> with frozen bounds, fraction of the slip of the step that lifts a dilating contact
      real(wp), allocatable :: frozen_lifting(:)
      !> [2,n] gap and slip due to blocks that are fixed in the region, m, see dda_local_iteration
      real(wp), allocatable :: fixed_motion(:,:)
      !> fraction retained in K̂: of the shear spring if sliding, of the normal spring if open
      real(wp), allocatable :: retained(:)
      real(wp), allocatable :: retained_at(:)  !< slip or gap at which the retained force is zero, m
      real(wp), allocatable :: spring(:,:)     !< [2,n] normal and shear stiffness in K̂, N/m
      real(wp), allocatable :: free_force(:,:) !< [2,n] assumed normal and shear force at d = 0, N/m
      integer, allocatable :: close_count(:)   !< number of closings in this step's iteration
      integer, allocatable :: trial_state(:)   !< state by the law at the solution
      !> largest difference between assumed and computed force, N/m
      real(wp), allocatable :: force_residual(:)
      real(wp), allocatable :: new_gap(:)      !< gap at the end of the step, linear in d, m
      real(wp), allocatable :: slip(:)         !< slip during the step, linear in d, m
      !> change of the gap and of the slip by the last solve, m; set by the line search
      real(wp), allocatable :: gap_change(:), slip_change(:)
      real(wp), allocatable :: normal_force(:) !< compression positive, N/m
      real(wp), allocatable :: shear_force(:)  !< shear force against slip of the vertex, N/m
   end type contacts_type

   !> An operation on every variable of a list, see `for_each_variable`.
   type, abstract :: operation_type
   contains
      procedure(apply_operation), deferred :: apply
   end type operation_type

   abstract interface
      !> Apply the operation to one variable, the array argument that is present.
      subroutine apply_operation(operation, integers, logicals, reals, columns)
         import :: operation_type, wp
         class(operation_type), intent(inout) :: operation
         integer, allocatable, intent(inout), optional :: integers(:)   !< [capacity]
         logical, allocatable, intent(inout), optional :: logicals(:)   !< [capacity]
         real(wp), allocatable, intent(inout), optional :: reals(:)     !< [capacity]
         real(wp), allocatable, intent(inout), optional :: columns(:,:) !< [any, capacity]
      end subroutine apply_operation
   end interface

   !> Operation that enlarges the arrays.
   type, extends(operation_type) :: growth_type
      integer :: capacity  !< required number of contacts
   contains
      procedure :: apply => grow_variable
   end type growth_type

   !> Operation that compacts the arrays.
   type, extends(operation_type) :: filter_type
      logical, allocatable :: keep(:)  !< [n]
   contains
      procedure :: apply => filter_variable
   end type filter_type

   !> Copy of one variable; one of its arrays is allocated.
   type :: variable_type
      integer, allocatable :: integers(:)
      logical, allocatable :: logicals(:)
      real(wp), allocatable :: reals(:), columns(:,:)
   end type variable_type

   !> Operation that copies contacts from one list and inserts the copies into another list.
   type, extends(operation_type) :: copy_type
      integer, allocatable :: list(:)  !< contacts to copy; not allocated: insert the copies
      integer :: n = 0                 !< number of variables copied or inserted so far
      type(variable_type), allocatable :: copied(:)
   contains
      procedure :: apply => copy_variable
   end type copy_type

contains

   !> Apply an operation to every variable of a list, in the order of the checkpoint.
   subroutine for_each_variable(contacts, operation)
      type(contacts_type), intent(inout) :: contacts            !< list of contacts
      class(operation_type), intent(inout) :: operation  !< operation on each array

      call for_each_of_history(contacts, operation)
      call for_each_of_step(contacts, operation)
   end subroutine for_each_variable

   !> Apply an operation to the variables that the next step needs.
   subroutine for_each_of_history(contacts, operation)
      type(contacts_type), intent(inout) :: contacts            !< list of contacts
      class(operation_type), intent(inout) :: operation  !< operation on each array

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
      call operation%apply(reals=contacts%stiffness_fraction)
      call operation%apply(reals=contacts%length)
      call operation%apply(columns=contacts%tilt)
      call operation%apply(columns=contacts%memory)
   end subroutine for_each_of_history

   !> Apply an operation to the variables that are needed within a step only.
   subroutine for_each_of_step(contacts, operation)
      type(contacts_type), intent(inout) :: contacts            !< list of contacts
      class(operation_type), intent(inout) :: operation  !< operation on each array

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
      call operation%apply(columns=contacts%tangent)
      call operation%apply(columns=contacts%line)
      if (.not. contacts%with_net_slip) return
      call operation%apply(logicals=contacts%past_centre)
      call operation%apply(logicals=contacts%trial_past_centre)
      call operation%apply(reals=contacts%acting_damage)
      call operation%apply(reals=contacts%slider)
   end subroutine for_each_of_step

   !> Apply an operation to the variables of damping and impacts.
   subroutine for_each_of_damping(contacts, operation)
      type(contacts_type), intent(inout) :: contacts            !< list of contacts
      class(operation_type), intent(inout) :: operation  !< operation on each array

      call operation%apply(integers=contacts%damping)
      call operation%apply(columns=contacts%rate)
      call operation%apply(reals=contacts%lead)
      call operation%apply(reals=contacts%spring_gap)
      call operation%apply(columns=contacts%gain)
      call operation%apply(columns=contacts%shift)
   end subroutine for_each_of_damping

   !> Move the arrays of the variables of a step to another list; their values are undefined there.
   pure subroutine move_step_arrays(from, to)
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
      if (from%with_damping) call move_damping_arrays(from, to)
      if (.not. from%with_laws) return
      call move_alloc(from%was_weakened, to%was_weakened)
      call move_alloc(from%tangent, to%tangent)
      call move_alloc(from%line, to%line)
      if (.not. from%with_net_slip) return
      call move_alloc(from%past_centre, to%past_centre)
      call move_alloc(from%trial_past_centre, to%trial_past_centre)
      call move_alloc(from%acting_damage, to%acting_damage)
      call move_alloc(from%slider, to%slider)
   end subroutine move_step_arrays

   !> Move the arrays of the variables of damping and impacts to another list.
   pure subroutine move_damping_arrays(from, to)
      type(contacts_type), intent(inout) :: from, to  !< lists of one run

      call move_alloc(from%damping, to%damping)
      call move_alloc(from%rate, to%rate)
      call move_alloc(from%lead, to%lead)
      call move_alloc(from%spring_gap, to%spring_gap)
      call move_alloc(from%gain, to%gain)
      call move_alloc(from%shift, to%shift)
   end subroutine move_damping_arrays

   !> .true. if contact c is at a point between corners; `vertex` is then the edge of this point.
   pure logical function is_point(contacts, c)  ! total
      type(contacts_type), intent(in) :: contacts  !< a list
      integer, intent(in) :: c                     !< number of the contact

      is_point = contacts%with_laws
      if (is_point) is_point = contacts%point(c) > 0
   end function is_point

   !> Copy the history of contacts from position `from` of the old list to `first` … `last`.
   !>
   !> The slip of a vertex along an edge retains its sign when the two blocks exchange roles, so the
   !> stretch is copied without change.  Each array is copied in long ranges, because most contacts
   !> retain their order.
   pure subroutine copy_history(new, first, last, old, from)
      type(contacts_type), intent(inout) :: new  !< list that receives the history
      integer, intent(in) :: first, last         !< range in `new`
      type(contacts_type), intent(in) :: old     !< list of the last step
      integer, intent(in) :: from                !< start of the range in `old`
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
      new%stiffness_fraction(first:last) = old%stiffness_fraction(from:to)
      new%length(first:last) = old%length(from:to)
      new%tilt(:, first:last) = old%tilt(:, from:to)
      new%memory(:, first:last) = old%memory(:, from:to)
   end subroutine copy_history

   !> Return the number of contacts for which the arrays of a list have memory.
   pure integer function capacity_of(contacts) result(capacity)
      type(contacts_type), intent(in) :: contacts  !< any list

      capacity = 0
      if (allocated(contacts%new_gap)) capacity = size(contacts%new_gap)
   end function capacity_of

   !> Reserve memory for at least `wanted` contacts and retain the present contacts.
   subroutine reserve(contacts, wanted)
      type(contacts_type), intent(inout) :: contacts  !< list to enlarge
      integer, intent(in) :: wanted                   !< contacts
      type(growth_type) :: growth

      if (.not. allocated(contacts%normal)) allocate (contacts%normal(2, 0), &
         contacts%spring(2, 0), contacts%tilt(2, 0))
      if (contacts%with_laws .and. .not. allocated(contacts%memory)) &
         allocate (contacts%memory(size(contacts%initial_memory), 0))
      if (.not. allocated(contacts%gradient_v)) allocate (contacts%gradient_v(12, 0), &
         contacts%gradient_e(12, 0), contacts%free_force(2, 0))
      if (contacts%with_laws .and. .not. allocated(contacts%tangent)) &
         allocate (contacts%tangent(2, 0), contacts%line(2, 0))
      if (contacts%with_damping .and. .not. allocated(contacts%gain)) &
         allocate (contacts%rate(2, 0), contacts%gain(2, 0), contacts%shift(2, 0))
      growth%capacity = wanted + wanted/spare + 8
      if (size(contacts%normal, 2) < max(wanted, 1)) call for_each_of_history(contacts, growth)
      if (size(contacts%gradient_v, 2) < max(wanted, 1)) call for_each_of_step(contacts, growth)
   end subroutine reserve

   !> Enlarge one variable of a list to the wanted capacity.
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

   !> Retain the selected contacts of a list, in their order.
   subroutine filter_contacts(contacts, keep)
      type(contacts_type), intent(inout) :: contacts  !< list to compact
      logical, intent(in) :: keep(:)                  !< [n]
      type(filter_type) :: filter

      allocate (filter%keep, source=keep)
      call for_each_variable(contacts, filter)
      contacts%n = count(keep)
   end subroutine filter_contacts

   !> Compact one variable of a list to the selected contacts.
   subroutine filter_variable(operation, integers, logicals, reals, columns)
      class(filter_type), intent(inout) :: operation                 !< selected contacts
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

   !> Copy some contacts of a list.
   subroutine copy_contacts(contacts, list, copies)
      type(contacts_type), intent(inout) :: contacts  !< unchanged
      integer, intent(in) :: list(:)                  !< numbers of the contacts
      type(contacts_type), intent(out) :: copies      !< their copies
      type(copy_type) :: copy

      copies%n = size(list)
      copies%time_step = contacts%time_step
      copies%with_multipliers = contacts%with_multipliers
      copies%with_strengths = contacts%with_strengths
      copies%with_laws = contacts%with_laws
      copies%with_net_slip = contacts%with_net_slip
      copies%with_damping = contacts%with_damping
      if (allocated(contacts%frozen_bound)) copies%frozen_bound = contacts%frozen_bound(list)
      if (allocated(contacts%frozen_lifting)) copies%frozen_lifting = contacts%frozen_lifting(list)
      if (allocated(contacts%fixed_motion)) copies%fixed_motion = contacts%fixed_motion(:, list)
      allocate (copy%copied(usual_variables))
      copy%list = list
      call for_each_variable(contacts, copy)
      deallocate (copy%list)
      copy%n = 0
      call for_each_variable(copies, copy)
   end subroutine copy_contacts

   !> Copy one variable of a list, or insert its copy into another list.
   subroutine copy_variable(operation, integers, logicals, reals, columns)
      class(copy_type), intent(inout) :: operation                   !< contacts and copies
      integer, allocatable, intent(inout), optional :: integers(:)   !< [capacity]
      logical, allocatable, intent(inout), optional :: logicals(:)   !< [capacity]
      real(wp), allocatable, intent(inout), optional :: reals(:)     !< [capacity]
      real(wp), allocatable, intent(inout), optional :: columns(:,:) !< [any, capacity]

      operation%n = operation%n + 1
      if (operation%n > size(operation%copied)) &
         operation%copied = [operation%copied, variable_type()]
      associate (copied => operation%copied(operation%n))
         if (allocated(operation%list)) then
            if (present(integers)) copied%integers = integers(operation%list)
            if (present(logicals)) copied%logicals = logicals(operation%list)
            if (present(reals)) copied%reals = reals(operation%list)
            if (present(columns)) copied%columns = columns(:, operation%list)
         else
            if (present(integers)) call move_alloc(copied%integers, integers)
            if (present(logicals)) call move_alloc(copied%logicals, logicals)
            if (present(reals)) call move_alloc(copied%reals, reals)
            if (present(columns)) call move_alloc(copied%columns, columns)
         end if
      end associate
   end subroutine copy_variable

end module dda_contact
