! SPDX-License-Identifier: GPL-3.0-or-later
!> Groups of water nodes that are solved together, and their effect on the blocks as springs.
!>
!> The pressures of a group satisfy M Δp = r − Bᵀd.  With M = L Lᵀ the force on the blocks is
!> B (p₀ + M⁻¹r) − G Gᵀd with G = B L⁻ᵀ: each column of G is a spring of stiffness 1 between all
!> blocks of the group, at a cost of nodes × blocks².  Without flow there are no groups: the spring
!> of a node is B with the stiffness 1/S, and couples only the blocks around the node.
module dda_flow_groups
   use dda_kinds, only: wp
   use dda_block_matrix, only: block_matrix_type
   use dda_counting_sort, only: sort_by_key
   use dda_flow, only: connected_nodes
   use dda_flow_network, only: network_type
   use dda_lapack, only: dpotrf, dtrsm
   use dda_linear_terms, only: linear_term_type, linear_terms_type, reserve_term, blocks_in, &
      add_parallel_terms, at_end, term_water
   implicit none
   private
   public :: group_type, set_groups, set_springs, add_springs, add_node_springs, add_changes

   !> A group of nodes that are solved together.
   type :: group_type
      integer, allocatable :: node(:)
      integer, allocatable :: block(:)        !< blocks beside the nodes
      real(wp), allocatable :: factor(:,:)    !< [nodes,nodes] L
      real(wp), allocatable :: spring(:,:,:)  !< [6,blocks,nodes] G
      integer, allocatable :: position(:)        !< [blocks of the model] position in `block`
   end type group_type

contains

   !> Form groups: the components of the network; none without flow.
   pure subroutine set_groups(network, groups)
      type(network_type), intent(in) :: network  !< network of the model
      type(group_type), allocatable, intent(out) :: groups(:)  !< groups of all nodes, or none
      integer :: first(size(network%volume)), owner(size(network%volume)), i, n
      integer, allocatable :: start(:), order(:)

      if (.not. network%flows) then
         allocate (groups(0))
         return
      end if
      first = connected_nodes(network%flow, network%absent)
      n = 0
      do i = 1, size(first)
         if (first(i) == i) n = n + 1
         owner(i) = n
         if (first(i) /= i) owner(i) = owner(first(i))
      end do
      call sort_by_key(n, owner, start, order)
      allocate (groups(n))
      do i = 1, n
         groups(i)%node = order(start(i):start(i + 1) - 1)
         associate (nodes => size(groups(i)%node))
            allocate (groups(i)%factor(nodes, nodes))
            call find_blocks(network, groups(i))
         end associate
      end do
   end subroutine set_groups

   !> Find the blocks beside the nodes of a group, and allocate its springs.
   pure subroutine find_blocks(network, group)
      type(network_type), intent(in) :: network  !< network of the model
      type(group_type), intent(inout) :: group   !< group with its nodes
      integer :: index(maxval(network%block)), i, r

      index = 0
      allocate (group%block(0))
      do i = 1, size(group%node)
         do r = network%first(group%node(i)), network%first(group%node(i) + 1) - 1
            if (index(network%block(r)) > 0) cycle
            group%block = [group%block, network%block(r)]
            index(network%block(r)) = size(group%block)
         end do
      end do
      group%position = index
      allocate (group%spring(6, size(group%block), size(group%node)))
   end subroutine find_blocks

   !> Compute factors and springs of all groups from M = S + Δt H of the free nodes.
   pure subroutine set_springs(network, conductance, fixed, groups)
      type(network_type), intent(in) :: network       !< network of the model
      real(wp), intent(in) :: conductance(:)          !< [channels] Δt times the conductance, m²/Pa
      logical, intent(in) :: fixed(:)                 !< [nodes] the pressure is known
      type(group_type), intent(inout) :: groups(:)    !< receive new values
      integer :: index(size(fixed)), owner(size(fixed)), g, i

      if (.not. network%flows) return
      do g = 1, size(groups)
         groups(g)%factor = 0.0_wp
         do i = 1, size(groups(g)%node)
            index(groups(g)%node(i)) = i
            owner(groups(g)%node(i)) = g
            groups(g)%factor(i, i) = network%storage(groups(g)%node(i))
            if (groups(g)%factor(i, i) <= 0.0_wp) groups(g)%factor(i, i) = 1.0_wp  ! no channel
         end do
      end do
      call add_conductances(network, conductance, fixed, index, owner, groups)
      do g = 1, size(groups)
         call set_rows(network, fixed, groups(g))
         call factorise_group(groups(g))
      end do
   end subroutine set_springs

   !> Add Δt H between free nodes, and between free and fixed nodes.
   pure subroutine add_conductances(network, conductance, fixed, index, owner, groups)
      type(network_type), intent(in) :: network       !< network of the model
      real(wp), intent(in) :: conductance(:)          !< [channels] Δt times the conductance, m²/Pa
      logical, intent(in) :: fixed(:)                 !< [nodes] the pressure is known
      integer, intent(in) :: index(:), owner(:)       !< [nodes] position in the group; group
      type(group_type), intent(inout) :: groups(:)    !< receive new values
      integer :: c, i, k

      do c = 1, size(conductance)
         if (.not. conductance(c) > 0.0_wp) cycle
         associate (node => network%flow%channel(c)%node, &
            m => groups(owner(network%flow%channel(c)%node(1)))%factor)
            do k = 1, 2
               i = index(node(k))
               if (.not. fixed(node(k))) m(i, i) = m(i, i) + conductance(c)
            end do
            if (any(fixed(node))) cycle
            m(index(node(1)), index(node(2))) = m(index(node(1)), index(node(2))) - conductance(c)
            m(index(node(2)), index(node(1))) = m(index(node(2)), index(node(1))) - conductance(c)
         end associate
      end do
   end subroutine add_conductances

   !> Set the rows B of the free nodes of a group.
   pure subroutine set_rows(network, fixed, group)
      type(network_type), intent(in) :: network  !< network of the model
      logical, intent(in) :: fixed(:)            !< [nodes] the pressure is known
      type(group_type), intent(inout) :: group   !< receives new values
      integer :: i, r

      group%spring = 0.0_wp
      do i = 1, size(group%node)
         if (fixed(group%node(i))) cycle
         do r = network%first(group%node(i)), network%first(group%node(i) + 1) - 1
            group%spring(:, group%position(network%block(r)), i) = network%row(:, r)
         end do
      end do
   end subroutine set_rows

   !> Factorise M = L Lᵀ, and compute G = B L⁻ᵀ.
   pure subroutine factorise_group(group)
      type(group_type), intent(inout) :: group  !< group with M and B; becomes L and G
      integer :: n, info

      n = size(group%node)
      call dpotrf('L', n, group%factor, n, info)
      if (size(group%spring) > 0) call dtrsm('R', 'L', 'T', 'N', 6*size(group%block), n, &
         1.0_wp, group%factor, n, group%spring, 6*size(group%block))
   end subroutine factorise_group

   !> Append the springs of all nodes.
   !> Fixed nodes have springs without stiffness, so that the pattern is constant.
   pure subroutine add_springs(network, fixed, groups, terms)
      type(network_type), intent(in) :: network         !< network of the model
      logical, intent(in) :: fixed(:)                   !< [nodes] the pressure is known
      type(group_type), intent(in) :: groups(:)         !< groups of all nodes
      type(linear_terms_type), intent(inout) :: terms   !< springs and dashpots
      integer :: g, i

      if (.not. network%flows) then
         do i = 1, size(fixed)
            associate (first => network%first(i), blocks => network%first(i + 1) - network%first(i))
               if (blocks < 2) cycle
               call add_spring(network, i, merge(0.0_wp, 1.0_wp/compliance_of(network, i), &
                  fixed(i)), blocks, network%block(first), network%row(1, first), terms)
            end associate
         end do
         return
      end if
      do g = 1, size(groups)
         associate (group => groups(g))
            do i = 1, size(group%node)
               call add_spring(network, group%node(i), merge(0.0_wp, 1.0_wp, &
                  fixed(group%node(i))), size(group%block), group%block, group%spring(:, :, i), &
                  terms)
            end do
         end associate
      end do
   end subroutine add_springs

   !> Add the springs of all nodes without flow to a matrix, without a list.
   pure subroutine add_node_springs(network, fixed, matrix, fits)
      type(network_type), intent(in) :: network  !< network of the model, without flow
      logical, intent(in) :: fixed(:)            !< [nodes] the pressure is known
      type(block_matrix_type), intent(inout) :: matrix  !< linear part of K̂
      logical, intent(inout) :: fits  !< set to .false. if the pattern lacks a pair
      real(wp) :: stiffness(size(fixed))
      integer :: node

      do node = 1, size(fixed)
         stiffness(node) = merge(0.0_wp, 1.0_wp/compliance_of(network, node), fixed(node))
      end do
      node = 1
      do while (node <= size(fixed) .and. fits)
         associate (first => network%first(node), nodes => network%alike(node), blocks => &
            network%first(node + 1) - network%first(node))
            if (blocks > 1) call add_parallel_terms(nodes, blocks, stiffness(node), &
               network%block(first), network%row(1, first), matrix, fits)
         end associate
         node = node + network%alike(node)
      end do
   end subroutine add_node_springs

   !> Append the spring of a node with n blocks, unless it is only one.
   pure subroutine add_spring(network, node, stiffness, n, block, row, terms)
      type(network_type), intent(in) :: network  !< network of the model
      integer, intent(in) :: node                !< number of the node
      real(wp), intent(in) :: stiffness          !< stiffness; 0 at a fixed node
      integer, intent(in) :: n, block(n)         !< blocks beside the node
      real(wp), intent(in) :: row(6, n)          !< row of the spring
      type(linear_terms_type), intent(inout) :: terms  !< springs and dashpots
      integer :: k

      if (n < 2) return
      call reserve_term(terms)
      associate (term => terms%term(terms%n))
         if (.not. is_spring_of(term, node, block)) term = new_spring(node, block)
         term%position = network%flow%position(:, node)
         term%coefficient = stiffness
         term%row_a = row(:, 1)
         term%row_b = -row(:, 2)
         do k = 3, n
            term%further_row(1:6, k - 2) = row(1:6, k)
         end do
      end associate
   end subroutine add_spring

   !> .true. if a term of the last step is the spring of a node and of the same blocks.
   pure logical function is_spring_of(term, node, block)
      type(linear_term_type), intent(in) :: term  !< term, perhaps of another kind
      integer, intent(in) :: node      !< number of the node
      integer, intent(in) :: block(:)  !< blocks beside the node

      is_spring_of = term%kind == term_water .and. term%source == node
      if (is_spring_of) is_spring_of = blocks_in(term) == size(block)
      if (is_spring_of) is_spring_of = term%block_a == block(1) .and. term%block_b == block(2)
      if (is_spring_of .and. size(block) > 2) is_spring_of = all(term%further_block == block(3:))
   end function is_spring_of

   !> Return the spring of a node, without its values.
   pure type(linear_term_type) function new_spring(node, block) result(term)
      integer, intent(in) :: node      !< number of the node
      integer, intent(in) :: block(:)  !< blocks beside the node

      term = linear_term_type(kind=term_water, instant=at_end, source=node, block_a=block(1), &
         block_b=block(2))
      if (size(block) == 2) return
      term%further_block = block(3:)
      allocate (term%further_row(6, size(term%further_block)))
   end function new_spring

   !> Return the storage of a node without flow; 1 for a node without channels.
   pure real(wp) function compliance_of(network, node) result(compliance)
      type(network_type), intent(in) :: network  !< network of the model
      integer, intent(in) :: node                !< number of the node

      compliance = merge(network%storage(node), 1.0_wp, network%storage(node) > 0.0_wp)
   end function compliance_of

   !> Add M⁻¹ r to the pressures.
   pure subroutine add_changes(network, groups, residual, pressure)
      type(network_type), intent(in) :: network !< network of the model
      type(group_type), intent(in) :: groups(:) !< groups with factors
      real(wp), intent(in) :: residual(:)           !< [nodes] r, m³ per metre of thickness
      real(wp), intent(inout) :: pressure(:)    !< [nodes] Pa
      integer :: g

      if (.not. network%flows) then
         do g = 1, size(residual)
            pressure(g) = pressure(g) + residual(g)/compliance_of(network, g)
         end do
      end if
      do g = 1, size(groups)
         call add_group_change(groups(g), residual, pressure)
      end do
   end subroutine add_changes

   !> Add M⁻¹ r to the pressures of a group.
   pure subroutine add_group_change(group, residual, pressure)
      type(group_type), intent(in) :: group     !< group with its factor
      real(wp), intent(in) :: residual(:)           !< [nodes] r, m³ per metre of thickness
      real(wp), intent(inout) :: pressure(:)    !< [nodes] Pa
      real(wp) :: change(size(group%node), 1)

      associate (n => size(group%node))
         change(:, 1) = residual(group%node)
         call dtrsm('L', 'L', 'N', 'N', n, 1, 1.0_wp, group%factor, n, change, n)
         call dtrsm('L', 'L', 'T', 'N', n, 1, 1.0_wp, group%factor, n, change, n)
         pressure(group%node) = pressure(group%node) + change(:, 1)
      end associate
   end subroutine add_group_change

end module dda_flow_groups
