! SPDX-License-Identifier: GPL-3.0-or-later
!> Open–close iteration of regions: groups of blocks near contacts that change states; all other
!> blocks are fixed.
!>
!> In a global iteration, a few contacts that overshoot shorten the line search of the whole model,
!> and each solve includes all blocks.  After a global solution, each connected region is therefore
!> first iterated as a small model; the next global iteration starts from its states.  Convergence
!> is judged only for the whole model.
submodule(dda_open_close) dda_local_iteration
   use dda_block_matrix, only: entry_of, set_pattern
   use dda_compact_block, only: compact
   use dda_contact, only: copy_contacts
   use dda_contact_gradients, only: relative_motion
   use dda_counting_sort, only: sort_by_key
   use dda_linear_solver, only: analyse, choose_solver, weigh_loads
   use dda_system, only: prepare_system
   implicit none

   !> number of contacts between a changing contact and a fixed block
   integer, parameter :: region_reach = 2
   real(wp), parameter :: most_blocks = 0.4_wp     !< blocks in all regions over all blocks
   !> stiffness of fixed blocks, N/m: large enough that contact springs do not move them, small
   !> enough that no product overflows in single precision
   real(wp), parameter :: immovable = 1.0e30_wp

contains

   !> Iterate all regions, and set the increments d and the states in them.
   recursive module subroutine iterate_regions(iteration, system, contacts, laws)
      type(open_close_type), intent(inout) :: iteration  !< open–close iteration of the step
      type(system_type), intent(inout) :: system  !< equations of the step
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step, evaluated
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, allocatable :: blocks(:), list(:), block_start(:), start(:)
      integer :: region(system%matrix%n), position(system%matrix%n), regions, i

      if (.not. can_be_divided(iteration, system, contacts)) return
      call find_regions(contacts, iteration%tolerance, region, regions)
      if (count(region > 0) > most_blocks*system%matrix%n) return
      call list_by_region(region, regions, blocks, block_start)
      call list_by_region(max(region(contacts%block_v(:contacts%n)), &
         region(contacts%block_e(:contacts%n))), regions, list, start)
      iteration%region_residual = iteration%residual
      position(blocks) = [(i, i=1, size(blocks))] - block_start(region(blocks)) + 1
      do i = 1, regions
         associate (own => blocks(block_start(i):block_start(i + 1) - 1), &
            touching => list(start(i):start(i + 1) - 1))
            associate (v => contacts%block_v(touching), e => contacts%block_e(touching), &
               fixed_block => size(own) + 1)
               call iterate_region(iteration, system, contacts, laws, own, touching, &
                  merge(position(v), fixed_block, region(v) == i), &
                  merge(position(e), fixed_block, region(e) == i))
            end associate
         end associate
      end do
      if (regions > 0) call evaluate(iteration, system, contacts, laws, list)
   end subroutine iterate_regions

   !> .true. if the model can be divided into regions.  Conditions: only contacts couple its blocks;
   !> no bond is intact (with bonds, walls of 1,000 bricks would take 1.2 to 1.7 times as long); the
   !> last regions have reduced the residual.  In the first iteration, enough states must change to
   !> require a new factorisation, but not too many.  The same condition in later iterations would
   !> make shaken walls of 10,000 bricks take 1.25 times as long.
   pure logical function can_be_divided(iteration, system, contacts)
      type(open_close_type), intent(in) :: iteration  !< open–close iteration of the step
      type(system_type), intent(in) :: system  !< equations of the step
      type(contacts_type), intent(in) :: contacts  !< contacts of this step, evaluated
      integer :: changes

      can_be_divided = contacts%n >= parallel_from .and. .not. system%drifts &
         .and. size(system%linear%column) == 0 &
         .and. iteration%residual < iteration%region_residual
      if (can_be_divided) can_be_divided = .not. any(contacts%bonded(:contacts%n))
      if (.not. can_be_divided .or. iteration%iterations > 1) return
      changes = count(contacts%trial_state(:contacts%n) /= contacts%state(:contacts%n))
      can_be_divided = changes > most_changes .and. changes <= iteration%most_changes
   end function can_be_divided

   !> Find the connected groups of blocks near changing contacts, and number them.
   pure subroutine find_regions(contacts, tolerance, region, regions)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step, evaluated
      real(wp), intent(in) :: tolerance  !< tolerance of the force difference, N/m
      integer, intent(out) :: region(:)  !< [blocks] region of each block, 0 if fixed
      integer, intent(out) :: regions  !< number of regions
      logical :: near(size(region)), nearer(size(region))
      integer :: root(size(region)), pair(2, contacts%n), pairs, p, k, b
      logical :: coupled(contacts%n)

      call mark_changing(contacts, tolerance, near, pair, coupled, pairs)
      do k = 1, region_reach
         nearer = near
         do p = 1, pairs
            if (.not. coupled(p)) cycle
            if (nearer(pair(1, p)) .or. nearer(pair(2, p))) near(pair(:, p)) = .true.
         end do
      end do
      root = [(b, b=1, size(root))]
      do p = 1, pairs
         if (near(pair(1, p)) .and. near(pair(2, p))) call unite_trees(root, pair(1, p), pair(2, p))
      end do
      regions = 0
      region = 0
      do b = 1, size(root)
         if (.not. near(b)) cycle
         if (root(b) == b) regions = regions + 1
         region(b) = regions
         if (root(b) < b) region(b) = region(find_root(root, b))
      end do
   end subroutine find_regions

   !> Mark the blocks of changing contacts, and list the pairs of blocks in the list of contacts.
   pure subroutine mark_changing(contacts, tolerance, near, pair, coupled, pairs)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step, evaluated
      real(wp), intent(in) :: tolerance  !< tolerance of the force difference, N/m
      logical, intent(out) :: near(:)  !< [blocks] the block has a changing contact
      integer, intent(out) :: pair(2, contacts%n)  !< blocks of each pair
      logical, intent(out) :: coupled(contacts%n)  !< [pairs] a contact is or becomes closed
      integer, intent(out) :: pairs  !< number of pairs
      integer :: c, last

      near = .false.
      pairs = 0
      last = 0
      do c = 1, contacts%n
         associate (v => contacts%block_v(c), e => contacts%block_e(c), &
            before => contacts%state(c), after => contacts%trial_state(c))
            if (contacts%pair(c) /= last) then
               last = contacts%pair(c)
               pairs = pairs + 1
               pair(:, pairs) = [v, e]
               coupled(pairs) = .false.
            end if
            if (before == contact_open .and. after == contact_open) cycle
            coupled(pairs) = .true.
            if (before == after .or. contacts%force_residual(c) <= tolerance) cycle
            near(v) = .true.
            near(e) = .true.
         end associate
      end do
   end subroutine mark_changing

   !> Unite the trees of two blocks; the root of each tree is its first block.
   pure subroutine unite_trees(root, a, b)
      integer, intent(inout) :: root(:)  !< [blocks] parent block, nearer to the root
      integer, intent(in) :: a, b        !< blocks
      integer :: root_a, root_b

      root_a = find_root(root, a)
      root_b = find_root(root, b)
      root(max(root_a, root_b)) = min(root_a, root_b)
      root(a) = min(root_a, root_b)
      root(b) = min(root_a, root_b)
   end subroutine unite_trees

   !> Find the root of the tree of a block.
   pure integer function find_root(root, block)
      integer, intent(in) :: root(:)  !< [blocks] parent block, nearer to the root
      integer, intent(in) :: block    !< number of the block

      find_root = block
      do while (root(find_root) /= find_root)
         find_root = root(find_root)
      end do
   end function find_root

   !> List the blocks or contacts of each region.
   pure subroutine list_by_region(region, regions, items, start)
      integer, intent(in) :: region(:)  !< [items] region of each block or contact, 0 for none
      integer, intent(in) :: regions    !< number of regions
      integer, allocatable, intent(out) :: items(:)  !< items by region
      integer, allocatable, intent(out) :: start(:)  !< [regions+1] first item of each region
      integer, allocatable :: order(:)
      integer :: i

      items = pack([(i, i=1, size(region))], region > 0)
      call sort_by_key(regions, region(items), start, order)
      items = items(order)
   end subroutine list_by_region

   !> Iterate one region; leave it unchanged if the iteration does not converge.
   recursive subroutine iterate_region(iteration, system, contacts, laws, blocks, list, v, e)
      type(open_close_type), intent(in) :: iteration  !< iteration of the whole model
      type(system_type), intent(inout) :: system  !< whole system; d of the region is set
      type(contacts_type), intent(inout) :: contacts  !< contacts of the whole model; states are set
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: blocks(:), list(:)  !< blocks and contacts of the region
      integer, intent(in) :: v(:), e(:)  !< [contacts] block numbers in the region
      type(open_close_type) :: part_iteration
      type(system_type) :: part
      type(solver_type) :: solver
      type(contacts_type) :: part_contacts
      type(error_type), allocatable :: error
      integer, allocatable :: order(:)
      logical :: converged

      call copy_region_equations(system, blocks, part)
      call copy_region_contacts(system, contacts, list, v, e, part, part_contacts, order)
      part_iteration%max_iterations = few_solves
      part_iteration%relative_tolerance = 0.0_wp
      part_iteration%noise = iteration%tolerance
      part_iteration%may_stop = iteration%may_stop
      part_iteration%keeps_states = iteration%keeps_states
      call choose_solver(solver, 'auto', error)
      call weigh_loads(solver, part%load)
      call analyse(solver, part%matrix)
      call adopt_trial_states(part_contacts, 1, part_contacts%n)
      call iterate(part_iteration, part, solver, part_contacts, laws, converged, error)
      if (allocated(error) .or. .not. converged) return
      system%d(:, blocks) = part%d(:, :size(blocks))
      contacts%state(order) = part_contacts%state
      contacts%slide_force(order) = part_contacts%slide_force
      contacts%slip_sign(order) = part_contacts%slip_sign
   end subroutine iterate_region

   !> Copy the equations of a region without contacts; one more block represents all fixed blocks.
   subroutine copy_region_equations(system, blocks, part)
      type(system_type), intent(in) :: system  !< system of the whole model
      integer, intent(in) :: blocks(:)         !< blocks of the region
      type(system_type), intent(out) :: part   !< system of the region, without pattern
      real(wp) :: rigid(6, 6)
      integer :: i

      associate (fixed_block => size(blocks) + 1)
         call prepare_system(part, fixed_block)
         part%load(:, :fixed_block - 1) = system%load(:, blocks)
         part%d(:, :fixed_block - 1) = system%d(:, blocks)
         part%constant(:, :fixed_block - 1) = system%constant(:, blocks)
         part%has_terms(:fixed_block - 1) = system%has_terms(blocks)
         part%linear%n = fixed_block
         allocate (part%linear%diagonal(6, 6, fixed_block), part%linear%lower(6, 6, 0), &
            part%linear%column(0), part%linear_entry(0))
         do i = 1, fixed_block - 1
            if (part%has_terms(i)) &
               part%linear%diagonal(:, :, i) = system%linear%diagonal(:, :, blocks(i))
         end do
         rigid = 0.0_wp
         do i = 1, 6
            rigid(i, i) = immovable
         end do
         part%constant(:, fixed_block) = compact(rigid)
      end associate
   end subroutine copy_region_equations

   !> Copy the contacts of a region, sorted by pairs with fixed blocks last; set the pattern of K̂.
   subroutine copy_region_contacts(system, contacts, list, v, e, part, copy, order)
      type(system_type), intent(in) :: system  !< system of the whole model
      type(contacts_type), intent(inout) :: contacts  !< contacts of the whole model, unchanged
      integer, intent(in) :: list(:)  !< contacts of the region
      integer, intent(in) :: v(:), e(:)  !< [contacts] block numbers in the region
      type(system_type), intent(inout) :: part  !< system of the region; pattern is set
      type(contacts_type), intent(out) :: copy  !< contacts of the region
      integer, allocatable, intent(out) :: order(:)  !< numbers of `copy` in the whole model
      integer, allocatable :: start(:), sorted(:), key(:)
      real(wp), parameter :: at_rest(6) = 0.0_wp
      integer :: i, fixed_block

      fixed_block = part%linear%n
      key = merge(1 + min(v, e), 1, max(v, e) == fixed_block)
      call sort_by_key(fixed_block, key, start, sorted)
      order = list(sorted)
      call copy_contacts(contacts, order, copy)
      copy%block_v = v(sorted)
      copy%block_e = e(sorted)
      if (.not. allocated(copy%fixed_motion)) allocate (copy%fixed_motion(2, copy%n), source=0.0_wp)
      do i = 1, copy%n
         associate (motion => copy%fixed_motion(:, i), of_v => contacts%block_v(order(i)), &
            of_e => contacts%block_e(order(i)))
            if (copy%block_v(i) == fixed_block) motion = motion &
               + relative_motion(copy, i, system%d(:, of_v), at_rest)
            if (copy%block_e(i) == fixed_block) motion = motion &
               + relative_motion(copy, i, at_rest, system%d(:, of_e))
         end associate
      end do
      call allocate_pairs(part, copy, fixed_block)
   end subroutine copy_region_contacts

   !> Number the pairs of blocks in contact, and allocate K̂ for them.
   subroutine allocate_pairs(part, region_contacts, fixed_block)
      type(system_type), intent(inout) :: part  !< system of the region; pattern is set
      type(contacts_type), intent(inout) :: region_contacts  !< sorted by pairs; sets `pair`
      integer, intent(in) :: fixed_block  !< block that represents all fixed blocks
      integer :: pairs(2, region_contacts%n), n, i

      n = 0
      region_contacts%pair = region_contacts%block_v
      do i = 1, region_contacts%n
         associate (pair => [min(region_contacts%block_v(i), region_contacts%block_e(i)), &
            max(region_contacts%block_v(i), region_contacts%block_e(i))])
            if (n == 0) then
               n = 1
            else if (any(pairs(:, n) /= pair)) then
               n = n + 1
            end if
            pairs(:, n) = pair
         end associate
         region_contacts%pair(i) = n
      end do
      call set_pattern(part%matrix, fixed_block, pairs(:, :n))
      allocate (part%pair_of_entry(n), part%first_contact(n + 2))
      do i = 1, n
         part%pair_of_entry(entry_of(part%matrix, pairs(1, i), pairs(2, i))) = i
      end do
   end subroutine allocate_pairs

end submodule dda_local_iteration
