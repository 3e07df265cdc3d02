! SPDX-License-Identifier: GPL-3.0-or-later
!> Assembly of the springs and friction forces of contacts, in their assumed states, into K̂ and f̂.
!>
!> A block is dirty if its contacts have changed; its row is then summed again.  The order of the
!> terms is fixed: linear part, near pairs with earlier blocks, near pairs with later blocks; the
!> contacts of a pair in list order.  Thus the result is bit-identical for any number of threads.
module dda_contact_assembly
   use dda_kinds, only: wp
   use dda_block_matrix, only: block_matrix_type, copy_block
   use dda_compact_block, only: expand
   use dda_system, only: system_type
   use dda_contact, only: contacts_type
   use dda_contact_gradients, only: acting_rows, rows_type
   use dda_contact_terms, only: update_contact_terms, is_clean, is_dirty_force, &
      is_dirty_stiffness, is_free
   use dda_friction, only: laws_type
   use dda_linear_terms, only: add_products
   use dda_ordered_sums, only: find_thread_range
   use dda_stopwatch, only: record_lap, phase_assemble
   use dda_team, only: adjust_team
   implicit none
   private
   public :: assemble_contacts, assemble_terms, index_contacts, add_to_rows, rows_from

   integer, parameter :: rows_from = 500   !< smallest number of block rows to use threads

contains

   !> Assemble the terms of the contacts in their assumed states.
   subroutine assemble_contacts(system, contacts, laws)
      type(system_type), intent(inout) :: system  !< equations of the step
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts

      call update_contact_terms(system%contact_terms, contacts, laws)
      call assemble_terms(system, contacts)
   end subroutine assemble_contacts

   !> Assemble the terms that have changed since the last assembly, or all terms in a new step.
   subroutine assemble_terms(system, contacts)
      type(system_type), intent(inout) :: system  !< equations of the step
      type(contacts_type), intent(in) :: contacts  !< contacts of this step, with their terms
      integer :: n, first, last

      if (system%contact_terms%rebuild) call index_contacts(system, contacts)
      n = system%matrix%n
      if (n < rows_from) then
         call assemble_rows(system, contacts, 1, n)
      else
         call adjust_team
         !$omp parallel private(first, last)
         call find_thread_range(n, first, last)
         call assemble_rows(system, contacts, first, last)
         !$omp end parallel
      end if
      system%contact_terms%dirty = is_clean
      system%contact_terms%rebuild = .false.
      call record_lap(system%watch, phase_assemble)
   end subroutine assemble_terms

   !> Find the first contact of each near pair in the list, which is sorted by pairs.
   pure subroutine index_contacts(system, contacts)
      type(system_type), intent(inout) :: system  !< equations of the step
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      integer :: c, pair

      pair = 0
      do c = 1, contacts%n
         if (contacts%pair(c) == pair) cycle
         system%first_contact(pair + 1:contacts%pair(c)) = c
         pair = contacts%pair(c)
      end do
      system%first_contact(pair + 1:) = contacts%n + 1
   end subroutine index_contacts

   !> Assemble block rows first … last of K̂ and f̂; no other thread writes these rows.
   !> A pair with both blocks in the range is read once; any other pair is read once per block.
   subroutine assemble_rows(system, contacts, first, last)
      type(system_type), intent(inout) :: system  !< equations of the step
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      integer, intent(in) :: first, last  !< first and last row
      integer :: i, k

      associate (matrix => system%matrix, dirty => system%contact_terms%dirty)
         do i = first, last
            if (dirty(i) >= is_dirty_force) call copy_block_row(system%load(:, i), system%rhs(:, i))
            if (dirty(i) == is_dirty_stiffness) call begin_row(system, i)
            do k = matrix%row_start(i), matrix%row_start(i + 1) - 1
               if (dirty(i) == is_clean .and. dirty(matrix%column(k)) == is_clean) cycle
               call assemble_pair(system, contacts, i, matrix%column(k), k, .true., &
                  matrix%column(k) >= first)
            end do
         end do
         do i = first, last
            if (dirty(i) == is_clean) cycle
            do k = matrix%below_start(i), matrix%below_start(i + 1) - 1
               if (matrix%below_row(k) > last) call assemble_pair(system, contacts, &
                  matrix%below_row(k), i, matrix%below_entry(k), .false., .true.)
            end do
         end do
      end associate
   end subroutine assemble_rows

   !> Assemble the terms of a near pair of blocks i > j in K̂ and f̂.
   subroutine assemble_pair(system, contacts, i, j, entry, write_i, write_j)
      type(system_type), intent(inout) :: system  !< equations of the step
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      integer, intent(in) :: i, j, entry  !< blocks; number of lower block (i, j) of K̂
      logical, intent(in) :: write_i, write_j     !< write row i; write row j
      type(rows_type) :: rows
      integer :: c, dirty_i, dirty_j
      logical :: coupled

      dirty_i = merge(system%contact_terms%dirty(i), is_clean, write_i)
      dirty_j = merge(system%contact_terms%dirty(j), is_clean, write_j)
      coupled = dirty_i == is_dirty_stiffness .and. &
         system%contact_terms%dirty(j) == is_dirty_stiffness
      if (dirty_i == is_clean .and. dirty_j == is_clean) return
      if (coupled) call begin_coupling(system%linear, system%linear_entry, entry, &
         system%matrix%lower(:, :, entry))
      associate (matrix => system%matrix)
         do c = system%first_contact(system%pair_of_entry(entry)), &
            system%first_contact(system%pair_of_entry(entry) + 1) - 1
            if (is_free(contacts, c)) cycle
            associate (v => contacts%block_v(c), e => contacts%block_e(c), &
               normal => contacts%spring(1, c), shear => contacts%spring(2, c))
               call acting_rows(contacts, c, rows)
               call add_sides(merge(dirty_i, dirty_j, v == i), merge(dirty_j, dirty_i, v == i), &
                  normal, shear, force_at_zero(contacts, c), rows, matrix%diagonal(:, :, v), &
                  matrix%diagonal(:, :, e), system%rhs(:, v), system%rhs(:, e))
               if (.not. coupled) cycle
               if (v == i) then
                  call add_products(matrix%lower(:, :, entry), rows%normal_v, rows%normal_e, &
                     -normal, rows%shear_v, rows%shear_e, -shear)
               else
                  call add_products(matrix%lower(:, :, entry), rows%normal_e, rows%normal_v, &
                     -normal, rows%shear_e, rows%shear_v, -shear)
               end if
            end associate
         end do
      end associate
   end subroutine assemble_pair

   !> Return the compression and resistance to slip of contact c at d = 0, N/m.
   pure function force_at_zero(contacts, c) result(force)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      integer, intent(in) :: c  !< number of the contact
      real(wp) :: force(2), motion(2)

      force = contacts%free_force(:, c)
      if (.not. allocated(contacts%fixed_motion)) return
      motion = contacts%fixed_motion(:, c)
      if (contacts%with_laws) motion(1) = motion(1) - contacts%tilt(2, c)*motion(2)
      force = force + contacts%spring(:, c)*[-motion(1), motion(2)]
   end function force_at_zero

   !> Set a diagonal block of K̂ to its part without contacts.
   pure subroutine begin_row(system, i)
      type(system_type), intent(inout) :: system  !< equations of the step
      integer, intent(in) :: i  !< block row

      if (system%has_terms(i)) then
         call copy_block(system%linear%diagonal(:, :, i), system%matrix%diagonal(:, :, i))
      else
         call expand(system%constant(:, i), system%matrix%diagonal(:, :, i))
      end if
   end subroutine begin_row

   !> Set a lower block of K̂ to its part without contacts.
   pure subroutine begin_coupling(linear, linear_entry, entry, block)
      type(block_matrix_type), intent(in) :: linear  !< linear part of K̂
      integer, intent(in) :: linear_entry(:)         !< see `system_type`
      integer, intent(in) :: entry                   !< number of the lower block
      real(wp), intent(out) :: block(6, 6)           !< block of K̂

      block = 0.0_wp
      if (size(linear_entry) == 0) return
      if (linear_entry(entry) > 0) block = linear%lower(:, :, linear_entry(entry))
   end subroutine begin_coupling

   !> Copy the six values of a block row.
   pure subroutine copy_block_row(from, to)
      real(wp), intent(in) :: from(6)  !< values of a block
      real(wp), intent(out) :: to(6)   !< their copy

      to = from
   end subroutine copy_block_row

   !> Add the terms of a contact to the rows of the blocks of its vertex and its edge.
   !> The given forces act on the block of the vertex; the block of the edge receives the opposite.
   pure subroutine add_sides(dirty_v, dirty_e, normal, shear, force, rows, diagonal_v, diagonal_e, &
      rhs_v, rhs_e)
      integer, intent(in) :: dirty_v, dirty_e
      real(wp), intent(in) :: normal, shear, force(2)
      type(rows_type), intent(in) :: rows
      real(wp), intent(inout) :: diagonal_v(6, 6), diagonal_e(6, 6), rhs_v(6), rhs_e(6)

      if (dirty_v >= is_dirty_force) &
         call add_forces(rhs_v, force(1), rows%normal_v, force(2), rows%shear_v)
      if (dirty_e >= is_dirty_force) &
         call add_forces(rhs_e, -force(1), rows%normal_e, -force(2), rows%shear_e)
      if (dirty_v == is_dirty_stiffness) call add_products(diagonal_v, rows%normal_v, &
         rows%normal_v, normal, rows%shear_v, rows%shear_v, shear)
      if (dirty_e == is_dirty_stiffness) call add_products(diagonal_e, rows%normal_e, &
         rows%normal_e, normal, rows%shear_e, rows%shear_e, shear)
   end subroutine add_sides

   !> Add forces: rhs += N normal − T shear.
   pure subroutine add_forces(rhs, normal_force, normal, shear_force, shear)
      real(wp), intent(inout) :: rhs(6)
      real(wp), intent(in) :: normal_force, normal(6), shear_force, shear(6)

      rhs = rhs + normal_force*normal - shear_force*shear
   end subroutine add_forces

   !> Add an additional force of contact c to those rows of f̂ that lie in first … last.
   !> The assumed state of the contact must be unchanged since the rows were assembled.
   pure subroutine add_to_rows(system, contacts, c, more, first, last)
      type(system_type), intent(inout) :: system  !< equations of the step
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      integer, intent(in) :: c            !< number of the contact
      real(wp), intent(in) :: more(2)     !< additional compression and resistance to slip, N/m
      integer, intent(in) :: first, last  !< first and last row
      type(rows_type) :: rows

      associate (v => contacts%block_v(c), e => contacts%block_e(c))
         if (max(v, e) < first .or. min(v, e) > last) return
         call acting_rows(contacts, c, rows)
         if (v >= first .and. v <= last) then
            call add_forces(system%rhs(:, v), more(1), rows%normal_v, more(2), rows%shear_v)
            system%contact_terms%dirty(v) = max(system%contact_terms%dirty(v), is_dirty_force)
         end if
         if (e >= first .and. e <= last) then
            call add_forces(system%rhs(:, e), -more(1), rows%normal_e, -more(2), rows%shear_e)
            system%contact_terms%dirty(e) = max(system%contact_terms%dirty(e), is_dirty_force)
         end if
      end associate
   end subroutine add_to_rows

end module dda_contact_assembly
