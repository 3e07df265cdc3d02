! SPDX-License-Identifier: GPL-3.0-or-later
!> Channels of water in their present geometry: apertures, volumes, conductances and storage.
!>
!> Apertures are linear along a channel.  With end apertures a₁ and a₂, length L and viscosity μ,
!> the conductance by the cubic law is 2a₁²a₂²/(a₁ + a₂)/(12μL) (Witherspoon et al.
!> 1980), exact for a wedge.  The volume of a node is ∫ N a ds with the linear shape functions N of
!> its channels, V = L (a₁/3 + a₂/6), and its storage is V/K_w.
module dda_flow_network
   use dda_kinds, only: wp
   use dda_block_matrix, only: set_zero
   use dda_blocks, only: blocks_type
   use dda_flow, only: flow_type
   implicit none
   private
   public :: network_type, new_network, update_network, stored_energy, growth_of, add_pressures, &
      fluxes_of, net_outflow

   real(wp), parameter :: same_node = 1.0_wp/3.0_wp, other_node = 1.0_wp/6.0_wp  !< ∫ N N ds over L

   !> Geometry of the network in a step.
   type :: network_type
      type(flow_type) :: flow
      logical :: flows = .true.                !< water flows from node to node
      logical, allocatable :: absent(:)        !< [channels] an adjacent block is removed
      !> [nodes+1] first row of each node in B; [rows] block of each row
      integer, allocatable :: first(:), block(:)
      integer, allocatable :: alike(:)         !< [nodes] nodes from here on with the same blocks
      real(wp), allocatable :: row(:,:)        !< [6,rows] ∂V/∂q per metre of thickness
      integer, allocatable :: row_of(:,:,:)  !< [sides,ends,channels] row of node and block in B
      real(wp), allocatable :: aperture(:,:)   !< [ends,channels] m
      real(wp), allocatable :: conductance(:)  !< [channels] m²/(Pa s); 0 without flow
      real(wp), allocatable :: volume(:)       !< [nodes] m³ per metre of thickness
      real(wp), allocatable :: storage(:)      !< [nodes] m³/Pa per metre of thickness
      real(wp), allocatable :: unit_weight(:)  !< [nodes] N/m³
      real(wp), allocatable :: elevation(:)    !< [nodes] unit weight times initial height, Pa
      real(wp), allocatable :: min_pressure(:)        !< [nodes] pressure of vapour or air, Pa
   end type network_type

contains

   !> Create the network of a model.
   pure type(network_type) function new_network(flow, blocks) result(network)
      type(flow_type), intent(in) :: flow      !< flow of the model
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      integer :: c, k, node

      network%flow = flow
      associate (channels => size(flow%channel), nodes => size(flow%pressure))
         allocate (network%absent(channels), source=.false.)
         allocate (network%aperture(2, channels), network%conductance(channels), &
            network%volume(nodes), network%storage(nodes))
         allocate (network%unit_weight(nodes), network%elevation(nodes), &
            network%min_pressure(nodes), source=0.0_wp)
         do c = 1, channels
            network%absent(c) = any(blocks%removed(flow%channel(c)%block))
            associate (law => flow%law(flow%channel(c)%law))
               do k = 1, 2
                  node = flow%channel(c)%node(k)
                  network%unit_weight(node) = law%unit_weight
                  network%elevation(node) = law%unit_weight*flow%position(2, node)
                  if (flow%saturation(node) >= 1.0_wp) network%min_pressure(node) = law%cavitation
               end do
            end associate
         end do
      end associate
      call list_rows(network)
      call update_network(network, blocks)
   end function new_network

   !> List the blocks beside each node: rows of B.
   pure subroutine list_rows(network)
      type(network_type), intent(inout) :: network  !< with its channels
      integer :: count(size(network%volume) + 1), block(4*size(network%absent))
      integer :: c, k, side, node, n

      allocate (network%row_of(2, 2, size(network%absent)), source=0)
      count = 0  ! upper bounds, then numbers, of blocks of each node
      do c = 1, size(network%absent)
         associate (ends => network%flow%channel(c)%node)
            count(ends) = count(ends) + 2
         end associate
      end do
      network%first = [1, (0, node=1, size(network%volume))]
      do node = 1, size(network%volume)
         network%first(node + 1) = network%first(node) + count(node)
      end do
      count = 0
      do c = 1, size(network%absent)
         if (network%absent(c)) cycle
         do k = 1, 2
            node = network%flow%channel(c)%node(k)
            do side = 1, 2
               associate (own_block => network%flow%channel(c)%block(side), from => &
                  network%first(node))
                  n = findloc(block(from:from + count(node) - 1), own_block, 1)
                  if (n == 0) then
                     count(node) = count(node) + 1
                     n = count(node)
                     block(from + n - 1) = own_block
                  end if
                  network%row_of(side, k, c) = n
               end associate
            end do
         end do
      end do
      call compact_rows(network, count, block)
   end subroutine list_rows

   !> Move the rows together, without unused memory between them.
   pure subroutine compact_rows(network, count, block)
      type(network_type), intent(inout) :: network  !< network with rows numbered within each node
      integer, intent(in) :: count(:)               !< [nodes+1] blocks of each node
      integer, intent(in) :: block(:)               !< blocks of each node, from `first` on
      integer :: first(size(count)), c, k, node

      first(1) = 1
      do node = 1, size(count) - 1
         first(node + 1) = first(node) + count(node)
      end do
      allocate (network%block(first(size(first)) - 1))
      allocate (network%row(6, size(network%block)))
      do node = 1, size(count) - 1
         network%block(first(node):first(node + 1) - 1) = &
            block(network%first(node):network%first(node) + count(node) - 1)
      end do
      do c = 1, size(network%absent)
         do k = 1, 2
            network%row_of(:, k, c) = network%row_of(:, k, c) &
               + first(network%flow%channel(c)%node(k)) - 1
         end do
      end do
      network%first = first
      network%alike = [(1, node=1, size(count) - 1)]
      do node = size(count) - 2, 1, -1
         if (has_same_blocks(network, node, node + 1)) &
            network%alike(node) = network%alike(node + 1) + 1
      end do
   end subroutine compact_rows

   !> .true. if two nodes have the same blocks in the same order.
   pure logical function has_same_blocks(network, i, j) result(same)
      type(network_type), intent(in) :: network  !< network with its rows
      integer, intent(in) :: i, j                !< numbers of the nodes

      associate (first => network%first, block => network%block)
         same = first(i + 1) - first(i) == first(j + 1) - first(j)
         if (same) same = all(block(first(i):first(i + 1) - 1) == block(first(j):first(j + 1) - 1))
      end associate
   end function has_same_blocks

   !> Update the network to the present geometry.
   !>
   !> A row nᵀT(ρ) is linear in ρ, so that ∫ N nᵀT ds over a channel is L/2 nᵀT at the mean
   !> 2 ∫ N ρ ds/L.
   pure subroutine update_network(network, blocks)
      type(network_type), intent(inout) :: network  !< network of the model
      type(blocks_type), intent(in) :: blocks       !< blocks in their present state
      real(wp), parameter :: sign(2) = [-1.0_wp, 1.0_wp]  !< sign of the gap by side
      real(wp) :: normal(2), node_volume(2)
      integer :: c, k, side, node

      network%volume = 0.0_wp
      network%storage = 0.0_wp
      network%conductance = 0.0_wp
      call set_zero(network%aperture, size(network%aperture))
      call set_zero(network%row, size(network%row))
      do c = 1, size(network%absent)
         if (network%absent(c)) cycle
         associate (channel => network%flow%channel(c), a => network%aperture(:, c), &
            law => network%flow%law(network%flow%channel(c)%law))
            normal = channel_normal(network, blocks, c)
            a = apertures_of(network, blocks, c, normal)
            node_volume = channel%length*(same_node*a + other_node*[a(2), a(1)])
            do k = 1, 2
               node = channel%node(k)
               network%volume(node) = network%volume(node) + node_volume(k)
               network%storage(node) = network%storage(node) + node_volume(k)/law%bulk_modulus
            end do
            if (network%flows) network%conductance(c) = 2*a(1)**2*a(2)**2/(a(1) + a(2)) &
               /(12.0_wp*law%viscosity*channel%length)
            do side = 1, 2
               call add_rows(0.5_wp*sign(side)*channel%length, normal, blocks, &
                  channel%block(side), channel%reference(:, :, side), &
                  network%row_of(side, :, c), network%row)
            end do
         end associate
      end do
   end subroutine update_network

   !> Add factor × nᵀT (T: `shape_matrix`) at the means of both nodes of a channel to their rows.
   pure subroutine add_rows(factor, normal, blocks, b, reference, row_of, row)
      real(wp), intent(in) :: factor           !< m
      real(wp), intent(in) :: normal(2)        !< n
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      integer, intent(in) :: b                 !< number of the block
      real(wp), intent(in) :: reference(2, 2)  !< m, offsets ρ of the ends
      integer, intent(in) :: row_of(:)         !< [2] numbers of the rows of the ends
      real(wp), intent(inout) :: row(6, *)     !< [6,rows]
      real(wp) :: n(2), local(2), arm(2), mean(2)
      integer :: k

      n = factor*normal
      associate (f => blocks%gradient(:, :, b), axes => blocks%axes(:, :, b))
         local = [axes(1, 1)*n(1) + axes(2, 1)*n(2), axes(1, 2)*n(1) + axes(2, 2)*n(2)]
         arm = [n(2)*f(1, 1) - n(1)*f(2, 1), n(2)*f(1, 2) - n(1)*f(2, 2)]
      end associate
      do k = 1, 2
         mean = 2*(same_node*reference(:, k) + other_node*reference(:, 3 - k))
         associate (r => row(:, row_of(k)))
            r(1) = r(1) + n(1)
            r(2) = r(2) + n(2)
            r(3) = r(3) + arm(1)*mean(1) + arm(2)*mean(2)
            r(4) = r(4) + local(1)*mean(1)
            r(5) = r(5) + local(2)*mean(2)
            r(6) = r(6) + 0.5_wp*(local(1)*mean(2) + local(2)*mean(1))
         end associate
      end do
   end subroutine add_rows

   !> Return the apertures at the ends of channel c, m.
   pure function apertures_of(network, blocks, c, normal) result(a)
      type(network_type), intent(in) :: network  !< network of the model
      type(blocks_type), intent(in) :: blocks    !< blocks in their present state
      integer, intent(in) :: c                   !< channel
      real(wp), intent(in) :: normal(2)          !< n of the channel
      real(wp) :: a(2), height(2, 2)
      integer :: side

      associate (channel => network%flow%channel(c), &
         law => network%flow%law(network%flow%channel(c)%law))
         do side = 1, 2
            height(:, side) = end_heights(normal, blocks, channel%block(side), &
               channel%reference(:, :, side))
         end do
         a = max(law%min_aperture, min(law%max_aperture, law%aperture + law%opening_factor &
            *(height(:, 2) - height(:, 1))))
      end associate
   end function apertures_of

   !> Return the energy ½ pᵀSp of compressed water, J per metre of thickness.
   pure real(wp) function stored_energy(network, blocks, pressure) result(energy)
      type(network_type), intent(in) :: network  !< network of the model
      type(blocks_type), intent(in) :: blocks    !< blocks in their present state
      real(wp), intent(in) :: pressure(:)        !< [nodes] Pa
      real(wp) :: a(2)
      integer :: c

      energy = 0.0_wp
      do c = 1, size(network%absent)
         if (network%absent(c)) cycle
         a = apertures_of(network, blocks, c, channel_normal(network, blocks, c))
         associate (channel => network%flow%channel(c), &
            law => network%flow%law(network%flow%channel(c)%law))
            energy = energy + 0.5_wp*channel%length/law%bulk_modulus &
               *((same_node*a(1) + other_node*a(2))*pressure(channel%node(1))**2 &
               + (same_node*a(2) + other_node*a(1))*pressure(channel%node(2))**2)
         end associate
      end do
   end function stored_energy

   !> Return the heights n·x of two material points ρ of block b, m.
   pure function end_heights(normal, blocks, b, reference) result(height)
      real(wp), intent(in) :: normal(2)        !< n
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      integer, intent(in) :: b                 !< number of the block
      real(wp), intent(in) :: reference(2, 2)  !< m, offsets ρ of the ends
      real(wp) :: height(2)

      associate (f => blocks%gradient(:, :, b), x => blocks%position(:, b))
         height = normal(1)*x(1) + normal(2)*x(2) &
            + (normal(1)*f(1, 1) + normal(2)*f(2, 1))*reference(1, :) &
            + (normal(1)*f(1, 2) + normal(2)*f(2, 2))*reference(2, :)
      end associate
   end function end_heights

   !> Return the scalar product of two rows, written out for speed.
   pure real(wp) function scalar_product(a, b)
      real(wp), intent(in) :: a(6), b(6)  !< values of a block

      scalar_product = a(1)*b(1) + a(2)*b(2) + a(3)*b(3) + a(4)*b(4) + a(5)*b(5) + a(6)*b(6)
   end function scalar_product

   !> Return the normal of channel c, outward from its first block.
   pure function channel_normal(network, blocks, c) result(normal)
      type(network_type), intent(in) :: network  !< network of the model
      type(blocks_type), intent(in) :: blocks    !< blocks in their present state
      integer, intent(in) :: c                   !< channel
      real(wp) :: normal(2)

      associate (edge => network%flow%channel(c)%edge)
         normal = [blocks%along(2, edge), -blocks%along(1, edge)]
      end associate
   end function channel_normal

   !> Return the increase Bᵀd of the volumes of the nodes, m³ per metre of thickness.
   pure function growth_of(network, d) result(growth)
      type(network_type), intent(in) :: network  !< network of the model
      real(wp), intent(in), contiguous :: d(:,:)  !< [6,blocks] increments of the coordinates
      real(wp) :: growth(size(network%volume))
      integer :: node, r

      do node = 1, size(growth)
         growth(node) = 0.0_wp
         do r = network%first(node), network%first(node + 1) - 1
            growth(node) = growth(node) + scalar_product(network%row(:, r), d(:, network%block(r)))
         end do
      end do
   end function growth_of

   !> Add B p to the loads of the blocks.
   pure subroutine add_pressures(network, pressure, load)
      type(network_type), intent(in) :: network  !< network of the model
      real(wp), intent(in) :: pressure(:)        !< [nodes] Pa
      real(wp), intent(inout), contiguous :: load(:,:)  !< [6,blocks] forces, N/m …
      integer :: node, r, b

      do node = 1, size(pressure)
         do r = network%first(node), network%first(node + 1) - 1
            b = network%block(r)
            load(1:6, b) = load(1:6, b) + pressure(node)*network%row(1:6, r)
         end do
      end do
   end subroutine add_pressures

   !> Return the flux of each channel from its first node to its second, m²/s.
   pure function fluxes_of(network, conductance, potential) result(flux)
      type(network_type), intent(in) :: network    !< network of the model
      real(wp), intent(in) :: conductance(:)       !< [channels] m²/(Pa s)
      real(wp), intent(in) :: potential(:)         !< [nodes] p + γy, Pa
      real(wp) :: flux(size(conductance))
      integer :: c

      do c = 1, size(flux)
         associate (node => network%flow%channel(c)%node)
            flux(c) = conductance(c)*(potential(node(1)) - potential(node(2)))
         end associate
      end do
   end function fluxes_of

   !> Return the outflow of each node into its channels, m²/s.
   pure function net_outflow(network, flux) result(outflow)
      type(network_type), intent(in) :: network  !< network of the model
      real(wp), intent(in) :: flux(:)            !< [channels] m²/s
      real(wp) :: outflow(size(network%volume))
      integer :: c

      outflow = 0.0_wp
      do c = 1, size(flux)
         associate (node => network%flow%channel(c)%node)
            outflow(node(1)) = outflow(node(1)) + flux(c)
            outflow(node(2)) = outflow(node(2)) - flux(c)
         end associate
      end do
   end function net_outflow

end module dda_flow_network
