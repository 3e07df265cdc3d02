!> The equations of one step, K̂ d = f̂ (paper eqs. 5–7).
!>
!> K̂ is the sum of a part that no contact state changes (inertia, elasticity, fixed points) and of the
!> springs of the contacts in their assumed states.
module dda_assembly
   use dda_kinds, only: wp
   use dda_block_matrix, only: block_matrix_type, set_pattern, entry_of
   use dda_blocks, only: blocks_type, shape_matrix, place_of
   use dda_contact, only: contacts_type, contact_open, contact_slide, contact_stick
   use dda_model, only: model_type
   use dda_baseline, only: displacement_at, acceleration_at
   use dda_neighbours, only: neighbours_type
   use dda_ordered_sums, only: pieces, first_of, last_of, parallel_from
   use dda_stopwatch, only: stopwatch_type, lap, phase_assemble, phase_iterate
   use dda_support, only: load_at
   implicit none
   private
   public :: system_type, prepare_system, set_matrix_pattern, set_inertia, assemble_base, assemble_contacts
   public :: add_shear_force, base_force, support_target

   integer, parameter :: rows_from = 500   !< block rows from which threads repay their start

   !> Stiffness of all contacts.
   type :: springs_type
      real(wp) :: normal   !< k_n, N/m per metre of thickness
      real(wp) :: shear    !< k_s
      real(wp) :: kept     !< share of it under sliding contacts
   end type springs_type

   !> Matrix, right-hand side and unknowns of a step.
   type :: system_type
      type(block_matrix_type) :: matrix            !< K̂
      integer, allocatable :: pair_of_entry(:)     !< near pair of each lower entry
      integer, allocatable :: first_contact(:)     !< [pairs+1] first contact of each near pair
      real(wp), allocatable :: inertia(:,:,:)      !< [6,6,n] 2M/Δt² + elasticity
      real(wp), allocatable :: base(:,:,:)         !< [6,6,n] the same + fixed points
      real(wp), allocatable :: load(:,:)           !< [6,n] f̂ without contacts
      real(wp), allocatable :: rhs(:,:)            !< [6,n] f̂
      real(wp), allocatable :: d(:,:)              !< [6,n] unknowns (paper eq. 2)
      real(wp), allocatable :: previous_d(:,:)     !< [6,n] those of the iteration before
      real(wp) :: inertia_step = 0.0_wp            !< Δt that `inertia` was made for, s
      type(stopwatch_type) :: watch                !< over the phases of the steps
   end type system_type

contains

   subroutine prepare_system(system, n)
      type(system_type), intent(out) :: system
      integer, intent(in) :: n

      allocate (system%inertia(6, 6, n), system%base(6, 6, n))
      allocate (system%load(6, n), system%rhs(6, n), system%d(6, n), system%previous_d(6, n), source=0.0_wp)
   end subroutine prepare_system

   !> Lay out K̂ for all near pairs, so that the pattern lasts as long as the neighbours do.
   subroutine set_matrix_pattern(system, n, neighbours)
      type(system_type), intent(inout) :: system
      integer, intent(in) :: n
      type(neighbours_type), intent(in) :: neighbours
      integer :: p

      call set_pattern(system%matrix, n, neighbours%pair(:, :neighbours%n_pairs))
      if (allocated(system%pair_of_entry)) deallocate (system%pair_of_entry, system%first_contact)
      allocate (system%pair_of_entry(size(system%matrix%column)), system%first_contact(neighbours%n_pairs + 1))
      do p = 1, neighbours%n_pairs
         system%pair_of_entry(entry_of(system%matrix, neighbours%pair(1, p), neighbours%pair(2, p))) = p
      end do
   end subroutine set_matrix_pattern

   !> 2M/Δt² + elasticity, constants of a block as long as Δt stays.
   subroutine set_inertia(system, blocks, time_step)
      type(system_type), intent(inout) :: system
      type(blocks_type), intent(in) :: blocks
      real(wp), intent(in) :: time_step
      integer :: b

      if (system%inertia_step == time_step) return
      do b = 1, blocks%n
         system%inertia(:, :, b) = 2.0_wp/time_step**2*blocks%inertia(:, :, b)
         system%inertia(4:6, 4:6, b) = system%inertia(4:6, 4:6, b) + blocks%stiffness(:, :, b)
      end do
      system%inertia_step = time_step
   end subroutine set_inertia

   !> All of K̂ and f̂ that does not depend on contact states; `time` is the end of the step.
   subroutine assemble_base(system, model, blocks, time, time_step)
      type(system_type), intent(inout) :: system
      type(model_type), intent(in) :: model
      type(blocks_type), intent(in) :: blocks
      real(wp), intent(in) :: time, time_step
      real(wp) :: force(2)
      integer :: p

      call set_inertia(system, blocks, time_step)
      force = base_force(model, time)
      if (blocks%n < parallel_from) then
         call lay_base(system, blocks, force, time_step, 1, blocks%n)
      else
         !$omp parallel do schedule(static)
         do p = 1, pieces(blocks%n)
            call lay_base(system, blocks, force, time_step, first_of(p, blocks%n), last_of(p, blocks%n))
         end do
      end if
      call add_loads(system, model, blocks, time)
      call add_fixed_points(system, model, blocks, time)
   end subroutine assemble_base

   !> Inertia, elasticity and body force of some blocks.
   pure subroutine lay_base(system, blocks, force, time_step, first, last)
      type(system_type), intent(inout) :: system
      type(blocks_type), intent(in) :: blocks
      real(wp), intent(in) :: force(2), time_step
      integer, intent(in) :: first, last
      real(wp) :: strain_load(3)
      integer :: b

      do b = first, last
         system%base(:, :, b) = system%inertia(:, :, b)
         system%load(:, b) = 2.0_wp/time_step*matmul(blocks%inertia(:, :, b), blocks%velocity(:, b))
         strain_load = matmul(blocks%stiffness(:, :, b), blocks%position(4:6, b)) &
            + blocks%area(b)*blocks%initial_stress(:, b)
         system%load(4:6, b) = system%load(4:6, b) - strain_load
         system%load(1:2, b) = system%load(1:2, b) + blocks%mass(b)*force
      end do
   end subroutine lay_base

   !> Body force per unit mass, m/s²: gravity, and base acceleration in the frame of the base.
   pure function base_force(model, time) result(force)
      type(model_type), intent(in) :: model
      real(wp), intent(in) :: time
      real(wp) :: force(2)
      integer :: axis

      force = model%control%gravity
      do axis = 1, 2
         if (model%control%base_motion(axis) == 0) cycle
         force(axis) = force(axis) - acceleration_at(model%motions(model%control%base_motion(axis))%curve, time)
      end do
   end function base_force

   subroutine add_loads(system, model, blocks, time)
      type(system_type), intent(inout) :: system
      type(model_type), intent(in) :: model
      type(blocks_type), intent(in) :: blocks
      real(wp), intent(in) :: time
      integer :: i, b

      do i = 1, size(model%loads)
         b = model%loads(i)%block
         system%load(:, b) = system%load(:, b) &
            + matmul(load_at(model%loads(i), time), shape_matrix(blocks, b, model%loads(i)%reference))
      end do
   end subroutine add_loads

   !> Stiff springs to the prescribed places at the end of the step.
   subroutine add_fixed_points(system, model, blocks, time)
      type(system_type), intent(inout) :: system
      type(model_type), intent(in) :: model
      type(blocks_type), intent(in) :: blocks
      real(wp), intent(in) :: time
      real(wp) :: t(2, 6), stiffness, away(2)
      integer :: i, b, axis, column

      stiffness = model%contact%fixed_point_ratio*model%contact%normal_stiffness
      do i = 1, size(model%fixed_points)
         b = model%fixed_points(i)%block
         t = shape_matrix(blocks, b, model%fixed_points(i)%reference)
         away = place_of(blocks, b, model%fixed_points(i)%reference) - support_target(model, i, time)
         do axis = 1, 2
            if (.not. model%fixed_points(i)%held(axis)) cycle
            do column = 1, 6
               system%base(:, column, b) = system%base(:, column, b) + stiffness*t(axis, column)*t(axis, :)
            end do
            system%load(:, b) = system%load(:, b) - stiffness*away(axis)*t(axis, :)
         end do
      end do
   end subroutine add_fixed_points

   !> Where fixed point i is to be at a time, m.
   pure function support_target(model, i, time) result(target)
      type(model_type), intent(in) :: model
      integer, intent(in) :: i
      real(wp), intent(in) :: time
      real(wp) :: target(2)
      integer :: axis

      target = model%fixed_points(i)%place
      do axis = 1, 2
         if (model%fixed_points(i)%motion(axis) == 0) cycle
         target(axis) = target(axis) + displacement_at(model%motions(model%fixed_points(i)%motion(axis))%curve, time)
      end do
   end function support_target

   !> Put the springs and slide forces of the contacts, in their assumed states, on top of the base.
   !>
   !> A sliding contact may keep a part of its shear spring about the slip of the last iteration, which slows the
   !> iteration where it would overshoot and leaves its solution as it is.  Every block gathers what its own contacts
   !> give it, so threads write nothing in common and sums do not depend on their number.
   subroutine assemble_contacts(system, contacts, normal_stiffness, shear_stiffness, kept, matrix_too)
      type(system_type), intent(inout) :: system
      type(contacts_type), intent(in) :: contacts
      real(wp), intent(in) :: normal_stiffness, shear_stiffness
      real(wp), intent(in) :: kept       !< share of the shear spring under sliding contacts
      logical, intent(in) :: matrix_too  !< .false. if K̂ still holds these springs
      type(springs_type) :: springs
      integer :: p, n, entries

      call lap(system%watch, phase_iterate)
      springs = springs_type(normal_stiffness, shear_stiffness, kept)
      n = system%matrix%n
      entries = merge(size(system%pair_of_entry), 0, matrix_too)
      if (matrix_too) call index_contacts(system, contacts)
      if (n < rows_from) then
         call gather(system, contacts, springs, matrix_too, 1, n)
         call couple(system, contacts, springs, 1, entries)
      else
         !$omp parallel
         !$omp do schedule(static)
         do p = 1, pieces(n)
            call gather(system, contacts, springs, matrix_too, first_of(p, n), last_of(p, n))
         end do
         !$omp end do nowait
         !$omp do schedule(static)
         do p = 1, pieces(entries)
            call couple(system, contacts, springs, first_of(p, entries), last_of(p, entries))
         end do
         !$omp end do
         !$omp end parallel
      end if
      call lap(system%watch, phase_assemble)
   end subroutine assemble_contacts

   !> Where the contacts of each near pair stand in the list, which is in the order of the pairs.
   pure subroutine index_contacts(system, contacts)
      type(system_type), intent(inout) :: system
      type(contacts_type), intent(in) :: contacts
      integer :: c, pair

      pair = 0
      do c = 1, contacts%n
         if (contacts%pair(c) == pair) cycle
         system%first_contact(pair + 1:contacts%pair(c)) = c
         pair = contacts%pair(c)
      end do
      system%first_contact(pair + 1:) = contacts%n + 1
   end subroutine index_contacts

   !> Loads and diagonal blocks of some blocks: the base, and their sides of their contacts.
   pure subroutine gather(system, contacts, springs, matrix_too, first, last)
      type(system_type), intent(inout) :: system
      type(contacts_type), intent(in) :: contacts
      type(springs_type), intent(in) :: springs
      logical, intent(in) :: matrix_too
      integer, intent(in) :: first, last
      real(wp) :: rhs(6), diagonal(6, 6)
      integer :: b, k

      do b = first, last
         rhs = system%load(:, b)
         if (matrix_too) diagonal = system%base(:, :, b)
         do k = system%matrix%row_start(b), system%matrix%row_start(b + 1) - 1
            call add_side(system, contacts, springs, b, system%pair_of_entry(k), matrix_too, rhs, diagonal)
         end do
         do k = system%matrix%below_start(b), system%matrix%below_start(b + 1) - 1
            call add_side(system, contacts, springs, b, system%pair_of_entry(system%matrix%below_entry(k)), matrix_too, &
               rhs, diagonal)
         end do
         system%rhs(:, b) = rhs
         if (matrix_too) system%matrix%diagonal(:, :, b) = diagonal
      end do
   end subroutine gather

   !> What the contacts of a near pair give to one of its blocks.
   pure subroutine add_side(system, contacts, springs, b, pair, matrix_too, rhs, diagonal)
      type(system_type), intent(in) :: system
      type(contacts_type), intent(in) :: contacts
      type(springs_type), intent(in) :: springs
      integer, intent(in) :: b, pair
      logical, intent(in) :: matrix_too
      real(wp), intent(inout) :: rhs(6), diagonal(6, 6)
      real(wp) :: normal(6), shear(6), push, drag
      integer :: c

      do c = system%first_contact(pair), system%first_contact(pair + 1) - 1
         if (contacts%state(c) == contact_open) cycle
         if (contacts%block_v(c) == b) then
            normal = contacts%normal_v(:, c)
            shear = contacts%shear_v(:, c)
         else
            normal = -contacts%normal_e(:, c)
            shear = -contacts%shear_e(:, c)
         end if
         call forces_at_rest(contacts, springs, c, push, drag)
         rhs = rhs + push*normal - drag*shear
         if (matrix_too) call add_products(diagonal, normal, normal, springs%normal, shear, shear, &
            shear_spring(contacts, springs, c))
      end do
   end subroutine add_side

   !> Normal and shear force of contact c at d = 0 in its assumed state.
   pure subroutine forces_at_rest(contacts, springs, c, push, drag)
      type(contacts_type), intent(in) :: contacts
      type(springs_type), intent(in) :: springs
      integer, intent(in) :: c
      real(wp), intent(out) :: push, drag

      push = contacts%pressure(c) - springs%normal*contacts%gap(c)
      drag = springs%shear*contacts%stretch(c)
      if (contacts%state(c) == contact_slide) drag = contacts%slide_force(c) &
         - springs%kept*springs%shear*contacts%slide_slip(c)
   end subroutine forces_at_rest

   !> More shear force in contact c, N/m, of the same assumed states.
   pure subroutine add_shear_force(system, contacts, c, more)
      type(system_type), intent(inout) :: system
      type(contacts_type), intent(in) :: contacts
      integer, intent(in) :: c
      real(wp), intent(in) :: more

      associate (i => contacts%block_v(c), j => contacts%block_e(c))
         system%rhs(:, i) = system%rhs(:, i) - more*contacts%shear_v(:, c)
         system%rhs(:, j) = system%rhs(:, j) + more*contacts%shear_e(:, c)
      end associate
   end subroutine add_shear_force

   !> Shear stiffness of a closed contact in its assumed state.
   pure real(wp) function shear_spring(contacts, springs, c)
      type(contacts_type), intent(in) :: contacts
      type(springs_type), intent(in) :: springs
      integer, intent(in) :: c

      shear_spring = merge(springs%shear, springs%kept*springs%shear, contacts%state(c) == contact_stick)
   end function shear_spring

   !> Blocks of K̂ that couple the two blocks of near pairs.
   pure subroutine couple(system, contacts, springs, first, last)
      type(system_type), intent(inout) :: system
      type(contacts_type), intent(in) :: contacts
      type(springs_type), intent(in) :: springs
      integer, intent(in) :: first, last
      real(wp) :: block(6, 6)
      integer :: entry, c, pair

      do entry = first, last
         block = 0.0_wp
         pair = system%pair_of_entry(entry)
         do c = system%first_contact(pair), system%first_contact(pair + 1) - 1
            if (contacts%state(c) == contact_open) cycle
            associate (nv => contacts%normal_v(:, c), ne => contacts%normal_e(:, c), sv => contacts%shear_v(:, c), &
               se => contacts%shear_e(:, c), shear => shear_spring(contacts, springs, c))
               if (contacts%block_v(c) > contacts%block_e(c)) then
                  call add_products(block, nv, ne, -springs%normal, sv, se, -shear)
               else
                  call add_products(block, ne, nv, -springs%normal, se, sv, -shear)
               end if
            end associate
         end do
         system%matrix%lower(:, :, entry) = block
      end do
   end subroutine couple

   !> block += k₁ a₁b₁ᵀ + k₂ a₂b₂ᵀ
   pure subroutine add_products(block, a1, b1, k1, a2, b2, k2)
      real(wp), intent(inout) :: block(6, 6)
      real(wp), intent(in) :: a1(6), b1(6), k1, a2(6), b2(6), k2
      integer :: column

      do column = 1, 6
         block(:, column) = block(:, column) + (k1*b1(column))*a1 + (k2*b2(column))*a2
      end do
   end subroutine add_products

end module dda_assembly
