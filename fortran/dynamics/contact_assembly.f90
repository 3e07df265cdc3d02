!> The springs and slide forces of the contacts, in their assumed states, on top of the base of K̂
!> and f̂.
!>
!> A sliding contact may keep a part of its shear spring about the slip of the last iteration, which
!> slows the iteration where it would overshoot and leaves its solution as it is.  A block that is
!> due is summed from its base, always in the same order: near pairs with the blocks before it, then
!> with those after it, each with its contacts as they are listed.  So the bits are those of
!> assembling everything, by any number of threads.
module dda_contact_assembly
   !$ use omp_lib, only: omp_get_num_threads, omp_get_thread_num
   use dda_kinds, only: wp, long
   use dda_system, only: system_type
   use dda_contact, only: contacts_type
   use dda_held_springs, only: springs_type, hold_contacts, due_nothing, due_forces, due_springs
   use dda_stopwatch, only: lap, phase_assemble, phase_iterate
   implicit none
   private
   public :: assemble_contacts, add_shear_force

   integer, parameter :: rows_from = 500   !< block rows from which threads repay their start

contains

   !> Assemble what the assumed states have changed since the last time, or all of a new step.
   subroutine assemble_contacts(system, contacts, normal_stiffness, shear_stiffness, kept)
      type(system_type), intent(inout) :: system
      type(contacts_type), intent(in) :: contacts
      real(wp), intent(in) :: normal_stiffness, shear_stiffness
      real(wp), intent(in) :: kept       !< share of the shear spring under sliding contacts
      integer :: n, me, team

      call lap(system%watch, phase_iterate)
      if (system%held%anew) call index_contacts(system, contacts)
      call hold_contacts(system%held, contacts, springs_type(normal_stiffness, shear_stiffness, &
         kept))
      n = system%matrix%n
      if (n < rows_from) then
         call assemble_rows(system, contacts, normal_stiffness, 1, n)
      else
         me = 0
         team = 1
         !$omp parallel firstprivate(me, team)
         !$ me = omp_get_thread_num()
         !$ team = omp_get_num_threads()
         call assemble_rows(system, contacts, normal_stiffness, 1 + int(me*int(n, long)/team), &
            int((me + 1)*int(n, long)/team))
         !$omp end parallel
      end if
      system%held%due = due_nothing
      system%held%anew = .false.
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

   !> Block rows first … last of K̂ and f̂, which nobody else writes.
   !>
   !> A near pair within them is read once, for both its blocks; one that reaches beyond them is
   !> read for either.
   subroutine assemble_rows(system, contacts, normal, first, last)
      type(system_type), intent(inout) :: system
      type(contacts_type), intent(in) :: contacts
      real(wp), intent(in) :: normal  !< spring, N/m
      integer, intent(in) :: first, last
      integer :: i, k

      associate (matrix => system%matrix, due => system%held%due)
         do i = first, last
            if (due(i) >= due_forces) system%rhs(:, i) = system%load(:, i)
            if (due(i) == due_springs) matrix%diagonal(:, :, i) = system%base(:, :, i)
            do k = matrix%row_start(i), matrix%row_start(i + 1) - 1
               call assemble_pair(system, contacts, normal, i, matrix%column(k), k, .true., &
                  matrix%column(k) >= first)
            end do
         end do
         do i = first, last
            do k = matrix%below_start(i), matrix%below_start(i + 1) - 1
               if (matrix%below_row(k) > last) call assemble_pair(system, contacts, normal, &
                  matrix%below_row(k), i, matrix%below_entry(k), .false., .true.)
            end do
         end do
      end associate
   end subroutine assemble_rows

   !> What a near pair of blocks i > j gives to K̂ and f̂.
   subroutine assemble_pair(system, contacts, normal, i, j, entry, row_too, column_too)
      type(system_type), intent(inout) :: system
      type(contacts_type), intent(in) :: contacts
      real(wp), intent(in) :: normal
      integer, intent(in) :: i, j, entry
      logical, intent(in) :: row_too, column_too  !< block i, with the coupling; block j
      integer :: c, due_i, due_j
      logical :: coupled

      due_i = merge(system%held%due(i), due_nothing, row_too)
      due_j = merge(system%held%due(j), due_nothing, column_too)
      coupled = due_i == due_springs .and. system%held%due(j) == due_springs
      if (due_i == due_nothing .and. due_j == due_nothing) return
      if (coupled) system%matrix%lower(:, :, entry) = 0.0_wp
      associate (held => system%held, matrix => system%matrix)
         do c = system%first_contact(system%pair_of_entry(entry)), &
            system%first_contact(system%pair_of_entry(entry) + 1) - 1
            if (held%shear(c) < 0.0_wp) cycle
            if (contacts%block_v(c) == i) then
               call add_sides(due_i, due_j, normal, held%shear(c), held%push(c), held%drag(c), &
                  contacts%normal_v(:, c), contacts%shear_v(:, c), contacts%normal_e(:, c), &
                  contacts%shear_e(:, c), matrix%diagonal(:, :, i), matrix%diagonal(:, :, j), &
                  system%rhs(:, i), system%rhs(:, j))
               if (coupled) call add_products(matrix%lower(:, :, entry), contacts%normal_v(:, c), &
                  contacts%normal_e(:, c), -normal, contacts%shear_v(:, c), &
                  contacts%shear_e(:, c), -held%shear(c))
            else
               call add_sides(due_i, due_j, normal, held%shear(c), -held%push(c), -held%drag(c), &
                  contacts%normal_e(:, c), contacts%shear_e(:, c), contacts%normal_v(:, c), &
                  contacts%shear_v(:, c), matrix%diagonal(:, :, i), matrix%diagonal(:, :, j), &
                  system%rhs(:, i), system%rhs(:, j))
               if (coupled) call add_products(matrix%lower(:, :, entry), contacts%normal_e(:, c), &
                  contacts%normal_v(:, c), -normal, contacts%shear_e(:, c), &
                  contacts%shear_v(:, c), -held%shear(c))
            end if
         end do
      end associate
   end subroutine assemble_pair

   !> What a contact of blocks i and j gives to each of them; the forces are those on block i.
   pure subroutine add_sides(due_i, due_j, normal, shear, push, drag, normal_i, shear_i, normal_j, &
      shear_j, diagonal_i, diagonal_j, rhs_i, rhs_j)
      integer, intent(in) :: due_i, due_j
      real(wp), intent(in) :: normal, shear, push, drag
      real(wp), intent(in) :: normal_i(6), shear_i(6), normal_j(6), shear_j(6)
      real(wp), intent(inout) :: diagonal_i(6, 6), diagonal_j(6, 6), rhs_i(6), rhs_j(6)

      if (due_i >= due_forces) call add_forces(rhs_i, push, normal_i, drag, shear_i)
      if (due_j >= due_forces) call add_forces(rhs_j, -push, normal_j, -drag, shear_j)
      if (due_i == due_springs) call add_products(diagonal_i, normal_i, normal_i, normal, shear_i, &
         shear_i, shear)
      if (due_j == due_springs) call add_products(diagonal_j, normal_j, normal_j, normal, shear_j, &
         shear_j, shear)
   end subroutine add_sides

   !> rhs += push normal − drag shear
   pure subroutine add_forces(rhs, push, normal, drag, shear)
      real(wp), intent(inout) :: rhs(6)
      real(wp), intent(in) :: push, normal(6), drag, shear(6)

      rhs = rhs + push*normal - drag*shear
   end subroutine add_forces

   !> block += k₁ a₁b₁ᵀ + k₂ a₂b₂ᵀ
   !>
   !> Rows in loops of four and two fill vector registers as they lie; unrolled, they would be
   !> shuffled into longer ones.
   pure subroutine add_products(block, a1, b1, k1, a2, b2, k2)
      real(wp), intent(inout) :: block(6, 6)
      real(wp), intent(in) :: a1(6), b1(6), k1, a2(6), b2(6), k2
      integer :: column, row

      do column = 1, 6
         !GCC$ unroll 1
         do row = 1, 4
            block(row, column) = block(row, column) + (k1*b1(column))*a1(row) &
               + (k2*b2(column))*a2(row)
         end do
         !GCC$ unroll 1
         do row = 5, 6
            block(row, column) = block(row, column) + (k1*b1(column))*a1(row) &
               + (k2*b2(column))*a2(row)
         end do
      end do
   end subroutine add_products

   !> More shear force in contact c, N/m, of the same assumed states; its blocks are due when these
   !> change.
   pure subroutine add_shear_force(system, contacts, c, more)
      type(system_type), intent(inout) :: system
      type(contacts_type), intent(in) :: contacts
      integer, intent(in) :: c
      real(wp), intent(in) :: more

      associate (i => contacts%block_v(c), j => contacts%block_e(c))
         system%rhs(:, i) = system%rhs(:, i) - more*contacts%shear_v(:, c)
         system%rhs(:, j) = system%rhs(:, j) + more*contacts%shear_e(:, c)
         system%held%due(i) = max(system%held%due(i), due_forces)
         system%held%due(j) = max(system%held%due(j), due_forces)
      end associate
   end subroutine add_shear_force

end module dda_contact_assembly
