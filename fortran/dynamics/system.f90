!> The equations of one step, K̂ d = f̂ (paper eqs. 5–7), and their base.
!>
!> K̂ is the sum of a part that no contact state changes, the base (inertia, elasticity, fixed
!> points), and of the springs of the contacts in their assumed states, which `dda_contact_assembly`
!> puts on top.
module dda_system
   use dda_kinds, only: wp
   use dda_block_matrix, only: block_matrix_type, set_pattern, entry_of
   use dda_blocks, only: blocks_type, shape_matrix, place_of
   use dda_held_springs, only: held_type, prepare_held
   use dda_model, only: model_type
   use dda_baseline, only: displacement_at, acceleration_at
   use dda_neighbours, only: neighbours_type
   use dda_ordered_sums, only: pieces, first_of, last_of, parallel_from
   use dda_stopwatch, only: stopwatch_type
   use dda_support, only: load_at
   implicit none
   private
   public :: system_type, prepare_system, set_matrix_pattern, set_inertia, assemble_base
   public :: base_force, support_target

   !> Matrix, right-hand side and unknowns of a step.
   type :: system_type
      type(block_matrix_type) :: matrix            !< K̂
      integer, allocatable :: pair_of_entry(:)     !< near pair of each lower entry
      integer, allocatable :: first_contact(:)     !< [pairs+1] first contact of each near pair
      type(held_type) :: held                      !< what K̂ and f̂ hold of the contacts
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
      allocate (system%load(6, n), system%rhs(6, n), system%d(6, n), system%previous_d(6, n), &
         source=0.0_wp)
      call prepare_held(system%held, n)
   end subroutine prepare_system

   !> Lay out K̂ for all near pairs, so that the pattern lasts as long as the neighbours do.
   subroutine set_matrix_pattern(system, n, neighbours)
      type(system_type), intent(inout) :: system
      integer, intent(in) :: n
      type(neighbours_type), intent(in) :: neighbours
      integer :: p

      system%held%anew = .true.
      call set_pattern(system%matrix, n, neighbours%pair(:, :neighbours%n_pairs))
      if (allocated(system%pair_of_entry)) deallocate (system%pair_of_entry, system%first_contact)
      allocate (system%pair_of_entry(size(system%matrix%column)), &
         system%first_contact(neighbours%n_pairs + 1))
      do p = 1, neighbours%n_pairs
         system%pair_of_entry(entry_of(system%matrix, neighbours%pair(1, p), &
            neighbours%pair(2, p))) = p
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
            call lay_base(system, blocks, force, time_step, first_of(p, blocks%n), &
               last_of(p, blocks%n))
         end do
      end if
      call add_loads(system, model, blocks, time)
      call add_fixed_points(system, model, blocks, time)
      system%held%anew = .true.
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
         force(axis) = force(axis) &
            - acceleration_at(model%motions(model%control%base_motion(axis))%curve, time)
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
         system%load(:, b) = system%load(:, b) + matmul(load_at(model%loads(i), time), &
            shape_matrix(blocks, b, model%loads(i)%reference))
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
         away = place_of(blocks, b, model%fixed_points(i)%reference) - support_target(model, i, &
            time)
         do axis = 1, 2
            if (.not. model%fixed_points(i)%held(axis)) cycle
            do column = 1, 6
               system%base(:, column, b) = system%base(:, column, b) + stiffness*t(axis, &
                  column)*t(axis, :)
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
         target(axis) = target(axis) &
            + displacement_at(model%motions(model%fixed_points(i)%motion(axis))%curve, time)
      end do
   end function support_target

end module dda_system
