! SPDX-License-Identifier: GPL-3.0-or-later
!> Equations of one step, K̂ d = f̂ (paper eqs. 5–7), and their linear part (without contacts).
!>
!> K̂ is the sum of a linear part (inertia, elasticity, elements), which does not depend on contact
!> states, and of the contact springs in their assumed states (`dda_contact_assembly`).
module dda_system
   use dda_kinds, only: wp
   use dda_block_matrix, only: block_matrix_type, set_pattern, entry_of, set_zero, multiply_block
   use dda_blocks, only: blocks_type, mass_matrix, momentum_of
   use dda_compact_block, only: compact_size, compact, expand, multiply_compact
   use dda_contact_terms, only: contact_terms_type, is_dirty_stiffness
   use dda_elements, only: elements_type, list_linear_terms, pack_terms, add_packed, add_forces
   use dda_linear_terms, only: linear_terms_type, step_weights, add_to_matrix, coupled_blocks
   use dda_material_damping, only: add_damping_matrix, add_damping_loads
   use dda_neighbours, only: neighbours_type
   use dda_ordered_sums, only: pieces, first_of, last_of, parallel_from
   use dda_scheme, only: step_type, mass_weight, momentum_weight
   use dda_stopwatch, only: stopwatch_type
   implicit none
   private
   public :: system_type, prepare_system, set_matrix_pattern, fits_pattern, assemble_linear, &
      begin_diagonal, multiply_diagonal

   !> Matrix, right-hand side and unknowns of a step.
   type :: system_type
      ! unsaved, computed in each step with the pattern of the neighbours: matrix
      ! unsaved, the pattern: pair_of_entry, linear_entry
      ! unsaved, listed in each step: first_contact
      ! unsaved, computed again in each step: contact_terms
      ! unsaved, computed for a new time step: constant, constant_step
      ! unsaved, computed with constant: constant_damps
      ! unsaved, computed in each step: linear, has_terms, terms, load, rhs
      ! unsaved, predicted at the start of each step: d
      ! unsaved, set before it is used: previous_d
      ! unsaved, computing times: watch
      ! unsaved, set in each step: drifts
      ! unsaved, set in each step if `drifts`: drift, drift_load
      type(block_matrix_type) :: matrix            !< K̂
      !> [entries] pair of blocks of each 6×6 matrix below the diagonal; pairs + 1: no contact
      integer, allocatable :: pair_of_entry(:)
      integer, allocatable :: first_contact(:)     !< [pairs+2] first contact of each near pair
      type(contact_terms_type) :: contact_terms    !< assembled terms of the contacts
      type(linear_terms_type) :: terms             !< springs and dashpots of the elements
      !> [compact_size,n] M/(χΔt²) + θ × elasticity + damping (see dda_compact_block)
      real(wp), allocatable :: constant(:,:)
      !> linear part of K̂; its diagonal is valid only for blocks with elements, see `constant`
      type(block_matrix_type) :: linear
      logical, allocatable :: has_terms(:)         !< [n] an element acts on the block
      !> [entries] number in the linear part of each lower block of K̂, or 0; empty if no elements
      !> couple blocks
      integer, allocatable :: linear_entry(:)
      real(wp), allocatable :: load(:,:)           !< [6,n] f̂ without contacts
      real(wp), allocatable :: rhs(:,:)            !< [6,n] f̂
      real(wp), allocatable :: d(:,:)              !< [6,n] unknowns (paper eq. 2)
      real(wp), allocatable :: previous_d(:,:)     !< [6,n] unknowns of the last iteration
      logical :: drifts = .false.                  !< bodies translate in this step
      !> [6,n] d₀ of translating bodies, K̂d₀ without contacts, work space (see dda_body_drift)
      real(wp), allocatable :: drift(:,:), drift_load(:,:), reduced(:,:)
      type(step_type) :: constant_step             !< Δt for which `constant` was computed
      logical :: constant_damps = .false.        !< `constant` includes the damping of the materials
      type(stopwatch_type) :: watch                !< computing time of each phase
   end type system_type

contains

   !> Allocate arrays for n blocks.
   subroutine prepare_system(system, n)
      type(system_type), intent(out) :: system  !< equations of the step
      integer, intent(in) :: n  !< number of blocks

      allocate (system%constant(compact_size, n))
      allocate (system%has_terms(n), source=.false.)
      allocate (system%load(6, n), system%rhs(6, n), system%d(6, n), system%previous_d(6, n), &
         source=0.0_wp)
      allocate (system%contact_terms%dirty(n), source=is_dirty_stiffness)  ! not assembled
   end subroutine prepare_system

   !> Allocate K̂ for all near pairs, and for all pairs of blocks in the terms of the elements.
   !> Terms with zero stiffness reserve entries of K̂ for couplings that may become stiff.
   subroutine set_matrix_pattern(system, blocks, neighbours, elements, step)
      type(system_type), intent(inout) :: system  !< equations of the step
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(neighbours_type), intent(in) :: neighbours  !< near pairs of blocks
      type(elements_type), intent(in) :: elements  !< elements of the model
      type(step_type), intent(in) :: step  !< the next step
      integer, allocatable :: pairs(:,:)
      integer :: p

      system%contact_terms%rebuild = .true.
      call list_linear_terms(elements, blocks, step, system%terms)
      pairs = coupled_blocks(system%terms)
      call set_pattern(system%linear, blocks%n, pairs, untouched=.true.)
      associate (near => neighbours%pair(:, :neighbours%n_pairs), matrix => system%matrix)
         if (size(pairs, 2) > 0) pairs = reshape([near, pairs], [2, size(near, 2) + size(pairs, 2)])
         if (size(pairs, 2) == 0) pairs = near
         call set_pattern(matrix, blocks%n, pairs)
         if (allocated(system%pair_of_entry)) deallocate (system%pair_of_entry, &
            system%first_contact)
         allocate (system%pair_of_entry(size(matrix%column)), source=size(near, 2) + 1)
         allocate (system%first_contact(size(near, 2) + 2))
         do p = 1, size(near, 2)
            system%pair_of_entry(entry_of(matrix, near(1, p), near(2, p))) = p
         end do
      end associate
      call index_linear(system)
   end subroutine set_matrix_pattern

   !> .true. if the pattern of the linear part couples exactly the blocks that elements couple.
   logical function fits_pattern(system, blocks, elements, step) result(fits)
      type(system_type), intent(inout) :: system  !< equations of the step; terms are listed again
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(elements_type), intent(in) :: elements  !< elements of the model
      type(step_type), intent(in) :: step  !< the next step
      type(block_matrix_type) :: required

      call list_linear_terms(elements, blocks, step, system%terms)
      call set_pattern(required, blocks%n, coupled_blocks(system%terms), untouched=.true.)
      fits = size(required%column) == size(system%linear%column)
      if (fits) fits = all(required%column == system%linear%column) .and. &
         all(required%row_start == system%linear%row_start)
   end function fits_pattern

   !> Find the number in the linear part of each lower block of K̂.
   subroutine index_linear(system)
      type(system_type), intent(inout) :: system  !< equations of the step
      integer :: row, k

      system%linear_entry = [integer ::]
      if (size(system%linear%column) == 0) return
      system%linear_entry = spread(0, 1, size(system%matrix%column))
      do row = 1, system%linear%n
         do k = system%linear%row_start(row), system%linear%row_start(row + 1) - 1
            system%linear_entry(entry_of(system%matrix, row, system%linear%column(k))) = k
         end do
      end do
   end subroutine index_linear

   !> Compute M/(χΔt²) + θ × elasticity + damping, unless Δt and scheme are unchanged.
   subroutine set_constant(system, blocks, step)
      type(system_type), intent(inout) :: system  !< equations of the step
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(step_type), intent(in) :: step  !< the present step
      real(wp) :: weight
      real(wp) :: block(6, 6)
      integer :: b

      associate (before => system%constant_step)
         if (before%time_step == step%time_step .and. before%scheme%theta == step%scheme%theta &
            .and. before%scheme%chi == step%scheme%chi .and. &
            (system%constant_damps .eqv. blocks%damps)) return
      end associate
      weight = mass_weight(step)
      do b = 1, blocks%n
         block = weight*mass_matrix(blocks%inertia(:, b))
         block(4:6, 4:6) = block(4:6, 4:6) &
            + step%scheme%theta*blocks%interior_fraction(b)*blocks%stiffness(:, :, b)
         if (blocks%damps) call add_damping_matrix(blocks, step, b, block)
         system%constant(:, b) = compact(block)
      end do
      system%constant_step = step
      system%constant_damps = blocks%damps
   end subroutine set_constant

   !> Assemble the part of K̂ and f̂ that does not depend on contact states.
   subroutine assemble_linear(system, elements, blocks, step, fits)
      type(system_type), intent(inout) :: system  !< equations of the step
      type(elements_type), intent(in) :: elements  !< elements of the model
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(step_type), intent(in) :: step  !< the present step
      logical, intent(out) :: fits  !< .false.: elements couple blocks outside the pattern
      logical :: packed
      integer :: p

      call set_constant(system, blocks, step)
      call set_zero(system%linear%lower, size(system%linear%lower))
      if (blocks%n < parallel_from) then
         call assemble_blocks(system, blocks, step, 1, blocks%n)
      else
         !$omp parallel do schedule(static)
         do p = 1, pieces(blocks%n)
            call assemble_blocks(system, blocks, step, first_of(p, blocks%n), last_of(p, blocks%n))
         end do
      end if
      if (blocks%damps) call add_damping_loads(blocks, step, system%load)
      packed = pack_terms(elements)
      if (packed) packed = .not. any(blocks%body > 0)  ! `begin_drift` needs the list
      call list_linear_terms(elements, blocks, step, system%terms, packed)
      call begin_terms(system, packed)
      call add_to_matrix(system%terms, step_weights(step), system%linear, fits)
      if (packed .and. fits) call add_packed(elements, system%linear, fits)
      call add_forces(elements, blocks, step, system%load)
      system%contact_terms%rebuild = .true.
   end subroutine assemble_linear

   !> Initialise the diagonal blocks of the linear part for all terms of the elements.
   pure subroutine begin_terms(system, packed)
      type(system_type), intent(inout) :: system  !< equations of the step, with terms
      logical, intent(in) :: packed  !< .true.: terms may act on any block, also beyond the list
      integer :: i, k

      system%has_terms = .false.
      if (packed) then
         do i = 1, size(system%has_terms)
            call begin_diagonal(system, i)
         end do
         return
      end if
      do i = 1, system%terms%n
         associate (term => system%terms%term(i))
            call begin_diagonal(system, term%block_a)
            if (term%block_b > 0) call begin_diagonal(system, term%block_b)
            if (.not. allocated(term%further_block)) cycle
            do k = 1, size(term%further_block)
               call begin_diagonal(system, term%further_block(k))
            end do
         end associate
      end do
   end subroutine begin_terms

   !> Initialise diagonal block b of the linear part, before its first term is added.
   pure subroutine begin_diagonal(system, b)
      type(system_type), intent(inout) :: system  !< equations of the step
      integer, intent(in) :: b  !< number of the block

      if (system%has_terms(b)) return
      system%has_terms(b) = .true.
      call expand(system%constant(:, b), system%linear%diagonal(:, :, b))
   end subroutine begin_diagonal

   !> Compute y = diagonal block b of the linear part × x.
   pure subroutine multiply_diagonal(system, b, x, y)
      type(system_type), intent(in) :: system  !< equations of the step
      integer, intent(in) :: b  !< number of the block
      real(wp), intent(in) :: x(6)  !< vector x
      real(wp), intent(out) :: y(6)  !< vector y

      if (system%has_terms(b)) then
         call multiply_block(system%linear%diagonal(:, :, b), x, y)
      else
         call multiply_compact(system%constant(:, b), x, y)
      end if
   end subroutine multiply_diagonal

   !> Set the loads of blocks first … last due to inertia and stress.
   pure subroutine assemble_blocks(system, blocks, step, first, last)
      type(system_type), intent(inout) :: system  !< equations of the step
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(step_type), intent(in) :: step  !< the present step
      integer, intent(in) :: first, last  !< first and last block
      integer :: b

      do b = first, last
         call set_load(momentum_weight(step), blocks%inertia(:, b), blocks%velocity(:, b), &
            blocks%stiffness(:, :, b), blocks%position(4:6, b), &
            blocks%area(b), blocks%initial_stress(:, b), blocks%interior_fraction(b), &
               system%load(:, b))
      end do
   end subroutine assemble_blocks

   !> Set the load of one block: weight × Mv minus the generalised forces of the stress.
   pure subroutine set_load(weight, inertia, velocity, stiffness, strain, area, initial_stress, &
      fraction, load)
      real(wp), intent(in) :: weight  !< weight of Mv, 1/s
      real(wp), intent(in) :: inertia(4), velocity(6)     !< see `blocks_type`
      real(wp), intent(in) :: stiffness(3, 3), strain(3)  !< area × D, N; strains
      real(wp), intent(in) :: area, initial_stress(3)     !< area, m²; stress, Pa
      real(wp), intent(in) :: fraction                     !< fraction of the area with this strain
      real(wp), intent(out) :: load(6)

      load = weight*momentum_of(inertia, velocity)
      load(4:6) = load(4:6) - fraction*(matmul(stiffness, strain) + area*initial_stress)
   end subroutine set_load

end module dda_system
