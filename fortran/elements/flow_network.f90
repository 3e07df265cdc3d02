! SPDX-License-Identifier: GPL-3.0-or-later
!> Channels of water in their present geometry: apertures, volumes, conductances and storage.
!>
!> Apertures are linear along a channel.  With the ends' apertures a₁ and a₂, length L and the
!> viscosity μ the cubic law gives the conductance 2a₁²a₂²/(a₁ + a₂)/(12μL) (Witherspoon et al.
!> 1980), exact for a wedge.  A node's volume is ∫ N a ds with the linear shape functions N of its
!> channels, V = L (a₁/3 + a₂/6), and its storage is V/K_w.
module dda_flow_network
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type, place_of, shape_matrix
   use dda_flow, only: flow_type
   implicit none
   private
   public :: network_type, new_network, update_network, add_node_row, outflow_of

   real(wp), parameter :: own = 1.0_wp/3.0_wp, other = 1.0_wp/6.0_wp  !< ∫ N N ds over L

   !> Geometry of a step.
   type :: network_type
      type(flow_type) :: flow
      logical, allocatable :: absent(:)        !< [channels] a block beside it is removed
      real(wp), allocatable :: row(:,:,:,:)    !< [6,sides,ends,channels] ∂gap/∂q
      real(wp), allocatable :: aperture(:,:)   !< [ends,channels] m
      real(wp), allocatable :: conductance(:)  !< [channels] m²/(Pa s)
      real(wp), allocatable :: volume(:)       !< [nodes] m³ per metre of thickness
      real(wp), allocatable :: storage(:)      !< [nodes] m³/Pa per metre of thickness
      real(wp), allocatable :: elevation(:)       !< [nodes] unit weight times first height, Pa
      real(wp), allocatable :: floor(:)        !< [nodes] pressure of vapour or air, Pa
   end type network_type

contains

   !> The network of a model.
   pure type(network_type) function new_network(flow, blocks) result(network)
      type(flow_type), intent(in) :: flow      !< of the model
      type(blocks_type), intent(in) :: blocks  !< in their present state
      integer :: c, k

      network%flow = flow
      associate (channels => size(flow%channel), nodes => size(flow%pressure))
         allocate (network%absent(channels), source=.false.)
         allocate (network%row(6, 2, 2, channels), network%aperture(2, channels), &
            network%conductance(channels), network%volume(nodes), network%storage(nodes))
         allocate (network%elevation(nodes), network%floor(nodes), source=0.0_wp)
         do c = 1, channels
            network%absent(c) = any(blocks%removed(flow%channel(c)%block))
            associate (law => flow%law(flow%channel(c)%law))
               do k = 1, 2
                  associate (node => flow%channel(c)%node(k))
                     network%elevation(node) = law%unit_weight*flow%place(2, node)
                     if (flow%saturation(node) >= 1.0_wp) network%floor(node) = law%cavitation
                  end associate
               end do
            end associate
         end do
      end associate
      call update_network(network, blocks)
   end function new_network

   !> Take the present geometry.
   pure subroutine update_network(network, blocks)
      type(network_type), intent(inout) :: network  !< of the model
      type(blocks_type), intent(in) :: blocks       !< in their present state
      real(wp) :: share
      integer :: c, k

      network%volume = 0.0_wp
      network%storage = 0.0_wp
      do c = 1, size(network%absent)
         network%conductance(c) = 0.0_wp
         network%aperture(:, c) = 0.0_wp
         network%row(:, :, :, c) = 0.0_wp
         if (network%absent(c)) cycle
         call measure(network, blocks, c)
         associate (channel => network%flow%channel(c), a => network%aperture(:, c), &
            law => network%flow%law(network%flow%channel(c)%law))
            network%conductance(c) = 2*a(1)**2*a(2)**2/(a(1) + a(2)) &
               /(12.0_wp*law%viscosity*channel%length)
            do k = 1, 2
               share = channel%length*(own*a(k) + other*a(3 - k))
               associate (node => channel%node(k))
                  network%volume(node) = network%volume(node) + share
                  network%storage(node) = network%storage(node) + share/law%bulk_modulus
               end associate
            end do
         end associate
      end do
   end subroutine update_network

   !> Gaps at the ends of channel c, its apertures and the gradients of the gaps.
   pure subroutine measure(network, blocks, c)
      type(network_type), intent(inout) :: network  !< of the model
      type(blocks_type), intent(in) :: blocks       !< in their present state
      integer, intent(in) :: c                      !< channel
      real(wp) :: normal(2), gap
      integer :: k

      associate (channel => network%flow%channel(c), a => network%flow%channel(c)%block(1), &
         b => network%flow%channel(c)%block(2), &
         law => network%flow%law(network%flow%channel(c)%law))
         normal = [blocks%along(2, channel%edge), -blocks%along(1, channel%edge)]
         do k = 1, 2
            gap = dot_product(normal, place_of(blocks, b, channel%reference(:, k, 2)) &
               - place_of(blocks, a, channel%reference(:, k, 1)))
            network%aperture(k, c) = max(law%least, min(law%most, law%aperture &
               + law%opening_factor*gap))
            network%row(:, 1, k, c) = -matmul(normal, shape_matrix(blocks, a, &
               channel%reference(:, k, 1)))
            network%row(:, 2, k, c) = matmul(normal, shape_matrix(blocks, b, &
               channel%reference(:, k, 2)))
         end do
      end associate
   end subroutine measure

   !> Add ∂V/∂q of the node at end k of channel c, of the block on a side.
   pure subroutine add_node_row(network, c, k, side, row)
      type(network_type), intent(in) :: network  !< of the model
      integer, intent(in) :: c, k, side          !< channel; end; side
      real(wp), intent(inout) :: row(6)          !< m³ per unit of q and metre of thickness

      row = row + network%flow%channel(c)%length*(own*network%row(:, side, k, c) &
         + other*network%row(:, side, 3 - k, c))
   end subroutine add_node_row

   !> H φ: what flows out of each node, m²/s.
   pure function outflow_of(network, conductance, potential) result(outflow)
      type(network_type), intent(in) :: network    !< of the model
      real(wp), intent(in) :: conductance(:)       !< [channels] m²/(Pa s)
      real(wp), intent(in) :: potential(:)         !< [nodes] p + γy, Pa
      real(wp) :: outflow(size(potential))
      real(wp) :: flux
      integer :: c

      outflow = 0.0_wp
      do c = 1, size(conductance)
         associate (node => network%flow%channel(c)%node)
            flux = conductance(c)*(potential(node(1)) - potential(node(2)))
            outflow(node(1)) = outflow(node(1)) + flux
            outflow(node(2)) = outflow(node(2)) - flux
         end associate
      end do
   end function outflow_of

end module dda_flow_network
