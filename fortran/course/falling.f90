! SPDX-License-Identifier: GPL-3.0-or-later
!> Groups of blocks that fall without limit: contacts cannot support them, and no block is below.
!>
!> Loads act along one direction, "down".  A block may be supported if an element acts on it, or if
!> it is above a block that may be supported.  The other blocks form groups in contact.  A group is
!> in equilibrium only if the forces of its contacts with other blocks balance its loads.  Each
!> force lies in a friction cone; the sum of the forces lies between the outermost directions of
!> these cones.  If the direction opposite to the loads is not in this range, the group falls,
!> because no block below can stop it.
module dda_falling
   use dda_kinds, only: wp, pi
   use dda_blocks, only: blocks_type
   use dda_contact, only: contacts_type
   use dda_friction, only: laws_type
   use dda_partition, only: join, name_parts
   use dda_sorting, only: merged_order
   implicit none
   private
   public :: find_falling

   real(wp), parameter :: rounding = 1.0e-9_wp  !< rounding of positions/half the model size
   real(wp), parameter :: parallel = 1.0e-6_wp  !< largest difference of equal directions, rad

   !> Extents of blocks: along the loads in m, across the loads in cells.  The sides of all blocks
   !> divide the axis across the loads into cells.
   type :: extents_type
      real(wp), allocatable :: top(:), bottom(:)      !< [blocks] positions along the loads, m
      integer, allocatable :: first(:), last(:)       !< [blocks] first and last cell across
      integer :: cells = 0                            !< number of cells across the loads
   end type extents_type

contains

   !> Find the blocks that fall without limit.
   subroutine find_falling(blocks, contacts, laws, load, on_element, is_falling)
      type(blocks_type), intent(in) :: blocks      !< blocks in their present state
      type(contacts_type), intent(in) :: contacts  !< contacts of the present state
      type(laws_type), intent(in) :: laws          !< friction of the joints
      real(wp), intent(in) :: load(:,:)  !< [6,blocks] loads without contact forces, N/m and N
      logical, intent(in) :: on_element(:)         !< [blocks] an element acts on the block
      logical, intent(out) :: is_falling(:)             !< [blocks] the block falls without limit
      type(extents_type) :: extents
      real(wp) :: load_direction(2)
      logical :: is_supported(blocks%n)
      integer :: group(blocks%n), c, b

      is_falling = .false.
      if (all(on_element .or. blocks%removed)) return
      load_direction = [(sum(load(c, :), mask=.not. (on_element .or. blocks%removed)), c=1, 2)]
      if (.not. norm2(load_direction) > tiny(1.0_wp)) return
      load_direction = load_direction/norm2(load_direction)
      call set_extents(extents, blocks, load_direction)
      is_supported = on_element .and. .not. blocks%removed
      call find_blocks_above(extents, blocks%removed, is_supported)
      if (all(is_supported .or. blocks%removed)) return
      group = [(b, b=1, blocks%n)]
      do c = 1, contacts%n
         if (.not. (is_supported(contacts%block_v(c)) .or. is_supported(contacts%block_e(c)))) &
            call join(group, contacts%block_v(c), contacts%block_e(c))
      end do
      call name_parts(group)
      is_falling = .not. (is_supported .or. blocks%removed)
      call retain_unbalanced(blocks, contacts, laws, load, load_direction, group, is_supported, &
         is_falling)
   end subroutine find_falling

   !> Set the extents of blocks along and across the loads; blocks that only touch do not overlap.
   subroutine set_extents(extents, blocks, load_direction)
      type(extents_type), intent(out) :: extents  !< extents of all blocks
      type(blocks_type), intent(in) :: blocks     !< blocks in their present state
      real(wp), intent(in) :: load_direction(2)             !< unit vector along the loads
      real(wp) :: block_sides(2*blocks%n), last_position
      integer :: order(2*blocks%n), cell(2*blocks%n), b, k

      associate (n => blocks%n)
         allocate (extents%top(n), extents%bottom(n))
         do b = 1, n
            associate (corner => blocks%vertex(:, blocks%first(b):blocks%first(b + 1) - 1))
               extents%top(b) = minval(matmul(load_direction, corner))
               extents%bottom(b) = maxval(matmul(load_direction, corner))
               block_sides(b) = minval(matmul([-load_direction(2), load_direction(1)], corner))
               block_sides(n + b) = maxval(matmul([-load_direction(2), load_direction(1)], corner))
            end associate
         end do
         order = merged_order(block_sides)
         last_position = -huge(1.0_wp)
         do k = 1, 2*n
            if (block_sides(order(k)) - last_position > rounding*blocks%half_size) then
               extents%cells = extents%cells + 1
               last_position = block_sides(order(k))
            end if
            cell(order(k)) = extents%cells
         end do
         extents%first = cell(:n)
         extents%last = cell(n + 1:) - 1
      end associate
   end subroutine set_extents

   !> Mark all blocks above any part of a marked block, because they may be supported.
   subroutine find_blocks_above(extents, is_removed, is_supported)
      type(extents_type), intent(in) :: extents   !< extents of all blocks
      logical, intent(in) :: is_removed(:)           !< [blocks]
      logical, intent(inout) :: is_supported(:)  !< [blocks] on entry: an element acts
      real(wp) :: deepest(extents%cells)          ! lowest point of supported blocks in a cell, m
      integer :: order(size(is_supported)), b, k
      logical :: changed

      deepest = -huge(1.0_wp)
      do b = 1, size(is_supported)
         if (is_supported(b)) call add_supported_block(b)
      end do
      order = merged_order(-extents%top)
      changed = .true.
      do while (changed)
         changed = .false.
         do k = 1, size(is_supported)
            b = order(k)
            if (is_supported(b) .or. is_removed(b)) cycle
            if (.not. any(deepest(extents%first(b):extents%last(b)) > extents%top(b))) cycle
            is_supported(b) = .true.
            changed = .true.
            call add_supported_block(b)
         end do
      end do

   contains

      !> Update the lowest supported points of the cells of supported block b.
      subroutine add_supported_block(b)
         integer, intent(in) :: b  !< number of the block

         associate (over => deepest(extents%first(b):extents%last(b)))
            over = max(over, extents%bottom(b))
         end associate
      end subroutine add_supported_block
   end subroutine find_blocks_above

  !> Retain in `is_falling` only groups whose contacts with other blocks cannot balance their loads.
   subroutine retain_unbalanced(blocks, contacts, laws, load, load_direction, group, is_supported, &
      is_falling)
      type(blocks_type), intent(in) :: blocks      !< blocks in their present state
      type(contacts_type), intent(in) :: contacts  !< contacts of the present state
      type(laws_type), intent(in) :: laws          !< friction of the joints
      real(wp), intent(in) :: load(:,:)  !< [6,blocks] loads without contact forces, N/m and N
      real(wp), intent(in) :: load_direction(2)              !< unit vector along the loads
      integer, intent(in) :: group(:)               !< [blocks] first block of the group
      logical, intent(in) :: is_supported(:)          !< [blocks] the block may be supported
      logical, intent(inout) :: is_falling(:)           !< [blocks] the block may fall without limit
      !> [2,blocks] first and last direction of forces on a group, as angles from the direction
      !> opposite to its loads, rad
      real(wp) :: range(2, blocks%n), direction, friction
      logical :: balances(blocks%n)
      integer :: c, b

      do b = 1, blocks%n
         balances(b) = is_falling(b) .and. .not. dot_product(load(1:2, b), load_direction) &
            > (1.0_wp - 0.5_wp*parallel**2)*norm2(load(1:2, b))
      end do
      range(1, :) = 2.0_wp*pi
      range(2, :) = 0.0_wp
      do c = 1, contacts%n
         associate (v => contacts%block_v(c), e => contacts%block_e(c))
            if (is_supported(v) .eqv. is_supported(e)) cycle
            b = merge(e, v, is_supported(v))
            if (.not. is_falling(b)) cycle
            associate (into => merge(1.0_wp, -1.0_wp, b == v)*contacts%normal(:, c))
               direction = modulo(atan2(load_direction(1)*into(2) - load_direction(2)*into(1), &
                  dot_product(load_direction, into)) - pi, 2.0_wp*pi)
            end associate
            friction = pi/2
            if (laws%plain) friction = laws%friction_angle(contacts%joint(c))*pi/180.0_wp
            balances(b) = balances(b) .or. contacts%bonded(c) &
               .or. min(direction, 2.0_wp*pi - direction) <= friction + parallel
            range(1, group(b)) = min(range(1, group(b)), direction - friction)
            range(2, group(b)) = max(range(2, group(b)), direction + friction)
         end associate
      end do
      do b = 1, blocks%n
         if (balances(b)) balances(group(b)) = .true.
      end do
      balances = balances .or. range(2, :) - range(1, :) >= pi - parallel
      is_falling = is_falling .and. .not. balances(group)
   end subroutine retain_unbalanced

end module dda_falling
