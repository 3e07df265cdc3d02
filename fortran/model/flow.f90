! SPDX-License-Identifier: GPL-3.0-or-later
!> Water in joints: network of channels, fluid, and prescribed values at nodes.
!>
!> A channel is the overlap, or a part of the overlap, of two edges of different blocks.  Its ends
!> are nodes; channels with ends at the same position have a common node.
module dda_flow
   use dda_kinds, only: wp
   use dda_interpolation, only: find_interval
   use dda_partition, only: join, name_parts
   implicit none
   private
   public :: flow_type, flow_law_type, flow_boundary_type, channel_type, value_at, acts_at, &
      find_boundary_pressure, connected_nodes, flow_states, flow_steady, flow_transient, &
      flow_undrained

   integer, parameter :: flow_steady = 1     !< pressures are in equilibrium with the boundaries
   integer, parameter :: flow_transient = 2  !< water is stored and flows
   integer, parameter :: flow_undrained = 3  !< water is stored but does not flow
   character(len=*), parameter :: flow_states(3) = [character(len=9) :: 'steady', 'transient', &
      'undrained']

   real(wp), parameter :: rounding = 1.0e-12_wp  !< rounding of potentials

   !> Apertures and fluid of the joints of a group &flow.
   type :: flow_law_type
      real(wp) :: aperture = 0.0_wp         !< hydraulic aperture of a joint that just touches, m
      real(wp) :: min_aperture = 0.0_wp            !< residual aperture, m
      real(wp) :: max_aperture = 0.0_wp             !< largest aperture, m
      real(wp) :: opening_factor = 1.0_wp   !< ratio of aperture change to opening
      real(wp) :: viscosity = 0.0_wp        !< dynamic viscosity, Pa s
      real(wp) :: bulk_modulus = 0.0_wp     !< Pa
      real(wp) :: unit_weight = 0.0_wp      !< N/m³ at 9.81 m/s²
      real(wp) :: cavitation = 0.0_wp       !< smallest pressure, Pa
   end type flow_law_type

   !> A part of the overlap of two edges.
   type :: channel_type
      integer :: block(2) = 0               !< blocks on both sides
      integer :: edge = 0                   !< edge of block(1), given by its first vertex
      integer :: node(2) = 0                !< nodes at its ends
      integer :: law = 0                    !< group &flow
      real(wp) :: length = 0.0_wp           !< m
      real(wp) :: reference(2, 2, 2) = 0.0_wp  !< [2,ends,sides] offsets ρ from the centroids, m
   end type channel_type

   !> Head, pressure or inflow at nodes over time (group &flow_boundary).
   type :: flow_boundary_type
      integer, allocatable :: node(:)       !< nodes on which the boundary acts
      logical :: inflow = .false.           !< values are inflows; .false.: pressures at y = 0
      logical :: head = .false.  !< values are heads; nodes above them are open to the air
      integer :: load = 0                   !< load on faces, which may end; 0: none
      logical :: acts_always = .true.       !< constant outside the times; .false.: does not act
      real(wp), allocatable :: time(:)      !< s
      real(wp), allocatable :: value(:)     !< [times] m, Pa, or total m²/s of all nodes
   end type flow_boundary_type

   !> Water in the joints of a model.
   type :: flow_type
      type(flow_law_type), allocatable :: law(:)
      type(channel_type), allocatable :: channel(:)
      type(flow_boundary_type), allocatable :: boundary(:)
      real(wp) :: origin(2) = 0.0_wp           !< m, of the positions
      real(wp), allocatable :: position(:,:)      !< [2,nodes] initial positions, m
      real(wp), allocatable :: pressure(:)     !< [nodes] pressure at the start, Pa
      real(wp), allocatable :: saturation(:)   !< [nodes] saturation at the start, 0 … 1
      integer :: state(2) = [flow_steady, flow_undrained]  !< state in static and dynamic stages
   end type flow_type

contains

   !> Return for each node the first of the nodes that channels connect with it.
   pure function connected_nodes(flow, absent) result(first)
      type(flow_type), intent(in) :: flow   !< flow of the model
      logical, intent(in) :: absent(:)      !< [channels] channels without water
      integer :: first(size(flow%position, 2)), c, i

      first = [(i, i=1, size(first))]
      do c = 1, size(flow%channel)
         if (.not. absent(c)) call join(first, flow%channel(c)%node(1), flow%channel(c)%node(2))
      end do
      call name_parts(first)
   end function connected_nodes

   !> .true. if a boundary acts at a given time.
   pure logical function acts_at(boundary, time)  ! total
      type(flow_boundary_type), intent(in) :: boundary  !< boundary with its times
      real(wp), intent(in) :: time                      !< time, s

      acts_at = boundary%acts_always .or. (time >= boundary%time(1) .and. &
         time <= boundary%time(size(boundary%time)))
   end function acts_at

   !> Find the pressure that a boundary with heads or pressures prescribes at a node.
   !> A node is open to the air, with p = 0, above a head and where no load acts.
   pure subroutine find_boundary_pressure(boundary, time, unit_weight, elevation, pressure, is_open)
      type(flow_boundary_type), intent(in) :: boundary  !< boundary with its times
      real(wp), intent(in) :: time                      !< time, s
      real(wp), intent(in) :: unit_weight, elevation    !< N/m³; unit weight times height, Pa
      real(wp), intent(out) :: pressure                 !< Pa
      logical, intent(out) :: is_open                   !< open to the air
      real(wp) :: potential

      is_open = .not. acts_at(boundary, time)
      pressure = value_at(boundary, time)
      if (boundary%head) then
         potential = unit_weight*pressure
         pressure = potential - elevation
         if (pressure < -rounding*(abs(potential) + abs(elevation))) is_open = .true.
         pressure = max(0.0_wp, pressure)
      end if
      if (is_open) pressure = 0.0_wp
   end subroutine find_boundary_pressure

   !> Value of a boundary at a time: linear between its times, constant beyond them.
   pure real(wp) function value_at(boundary, time)
      type(flow_boundary_type), intent(in) :: boundary  !< boundary with its times
      real(wp), intent(in) :: time                      !< time, s
      real(wp) :: fraction
      integer :: k, last

      call find_interval(boundary%time, min(max(time, boundary%time(1)), &
         boundary%time(size(boundary%time))), k, last, fraction)
      value_at = boundary%value(k) + fraction*(boundary%value(last) - boundary%value(k))
   end function value_at

end module dda_flow
