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
   use dda_support, only: load_at
   implicit none
   private
   public :: system_type, prepare_system, set_matrix_pattern, set_inertia, assemble_base, assemble_contacts
   public :: base_force, support_target

   !> Matrix, right-hand side and unknowns of a step.
   type :: system_type
      type(block_matrix_type) :: matrix            !< K̂
      integer, allocatable :: entry_of_pair(:)     !< lower entry of each near pair
      real(wp), allocatable :: inertia(:,:,:)      !< [6,6,n] 2M/Δt² + elasticity
      real(wp), allocatable :: base(:,:,:)         !< [6,6,n] the same + fixed points
      real(wp), allocatable :: load(:,:)           !< [6,n] f̂ without contacts
      real(wp), allocatable :: rhs(:,:)            !< [6,n] f̂
      real(wp), allocatable :: d(:,:)              !< [6,n] unknowns (paper eq. 2)
      real(wp), allocatable :: previous_d(:,:)     !< [6,n] those of the iteration before
      real(wp) :: inertia_step = 0.0_wp            !< Δt that `inertia` was made for, s
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
      if (allocated(system%entry_of_pair)) deallocate (system%entry_of_pair)
      allocate (system%entry_of_pair(neighbours%n_pairs))
      do p = 1, neighbours%n_pairs
         system%entry_of_pair(p) = entry_of(system%matrix, neighbours%pair(1, p), neighbours%pair(2, p))
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
      real(wp) :: strain_load(3)
      integer :: b

      call set_inertia(system, blocks, time_step)
      system%base = system%inertia
      do b = 1, blocks%n
         system%load(:, b) = 2.0_wp/time_step*matmul(blocks%inertia(:, :, b), blocks%velocity(:, b))
         strain_load = matmul(blocks%stiffness(:, :, b), blocks%position(4:6, b)) &
            + blocks%area(b)*blocks%initial_stress(:, b)
         system%load(4:6, b) = system%load(4:6, b) - strain_load
         system%load(1:2, b) = system%load(1:2, b) + blocks%mass(b)*base_force(model, time)
      end do
      call add_loads(system, model, blocks, time)
      call add_fixed_points(system, model, blocks, time)
   end subroutine assemble_base

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
   !> iteration where it would overshoot and leaves its solution as it is.
   subroutine assemble_contacts(system, contacts, normal_stiffness, shear_stiffness, kept, matrix_too)
      type(system_type), intent(inout) :: system
      type(contacts_type), intent(in) :: contacts
      real(wp), intent(in) :: normal_stiffness, shear_stiffness
      real(wp), intent(in) :: kept       !< share of the shear spring under sliding contacts
      logical, intent(in) :: matrix_too  !< .false. if K̂ still holds these springs
      integer :: c

      system%rhs = system%load
      if (matrix_too) then
         system%matrix%diagonal = system%base
         system%matrix%lower = 0.0_wp
      end if
      do c = 1, contacts%n
         if (contacts%state(c) == contact_open) cycle
         call add_contact_load(system%rhs(:, contacts%block_v(c)), system%rhs(:, contacts%block_e(c)), contacts, c, &
            normal_stiffness, shear_stiffness, kept)
         if (matrix_too) call add_springs(system, contacts, c, normal_stiffness, &
            merge(shear_stiffness, kept*shear_stiffness, contacts%state(c) == contact_stick))
      end do
   end subroutine assemble_contacts

   !> Forces of contact c at d = 0 in its assumed state.
   pure subroutine add_contact_load(rhs_v, rhs_e, contacts, c, normal_stiffness, shear_stiffness, kept)
      real(wp), intent(inout) :: rhs_v(6), rhs_e(6)
      type(contacts_type), intent(in) :: contacts
      integer, intent(in) :: c
      real(wp), intent(in) :: normal_stiffness, shear_stiffness, kept
      real(wp) :: push, drag

      push = contacts%pressure(c) - normal_stiffness*contacts%gap(c)
      drag = shear_stiffness*contacts%stretch(c)
      if (contacts%state(c) == contact_slide) drag = contacts%slide_force(c) - kept*shear_stiffness*contacts%slide_slip(c)
      rhs_v = rhs_v + push*contacts%normal_v(:, c) - drag*contacts%shear_v(:, c)
      rhs_e = rhs_e - push*contacts%normal_e(:, c) + drag*contacts%shear_e(:, c)
   end subroutine add_contact_load

   !> Normal and shear spring of contact c into the two diagonal blocks and the block that couples them.
   pure subroutine add_springs(system, contacts, c, normal_stiffness, shear_stiffness)
      type(system_type), intent(inout) :: system
      type(contacts_type), intent(in) :: contacts
      integer, intent(in) :: c
      real(wp), intent(in) :: normal_stiffness, shear_stiffness
      integer :: entry

      entry = system%entry_of_pair(contacts%pair(c))
      associate (nv => contacts%normal_v(:, c), ne => contacts%normal_e(:, c), &
         sv => contacts%shear_v(:, c), se => contacts%shear_e(:, c), i => contacts%block_v(c), j => contacts%block_e(c))
         call add_products(system%matrix%diagonal(:, :, i), nv, nv, normal_stiffness, sv, sv, shear_stiffness)
         call add_products(system%matrix%diagonal(:, :, j), ne, ne, normal_stiffness, se, se, shear_stiffness)
         if (i > j) then
            call add_products(system%matrix%lower(:, :, entry), nv, ne, -normal_stiffness, sv, se, -shear_stiffness)
         else
            call add_products(system%matrix%lower(:, :, entry), ne, nv, -normal_stiffness, se, sv, -shear_stiffness)
         end if
      end associate
   end subroutine add_springs

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
