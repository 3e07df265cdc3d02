! SPDX-License-Identifier: GPL-3.0-or-later
!> Steady flow in a group of connected water nodes, with its water table and seepage faces.
!>
!> Heads satisfy H φ = Q.  Conductances are proportional to the cube of apertures, so their ratio
!> may exceed the precision of numbers.  The elimination therefore replaces a node and its channels
!> by channels between its neighbours (star–mesh transform): conductances are only added, never
!> subtracted, so each is accurate.  Iterative refinement improves the heads, which are sums of two
!> numbers: differences of nearly equal heads, and so the fluxes, are accurate also.
!>
!> Nodes open to the air are seepage faces: p = 0 while water flows out, else no flow and p ≤ 0.
module dda_steady_flow
   use dda_kinds, only: wp
   use dda_flow_groups, only: group_type
   use dda_flow_network, only: network_type
   use dda_text, only: to_text
   implicit none
   private
   public :: find_steady_flow

   !> Channels and nodes of a group, and their unknowns.
   type :: circuit_type
      integer, allocatable :: channel(:)       !< [channels] number in the model
      integer, allocatable :: ends(:,:)        !< [2,channels] nodes, numbered within the group
      real(wp), allocatable :: conductance(:)  !< [channels] divided by `unit`
      real(wp), allocatable :: flux(:)         !< [channels] from the first end, divided by `unit`
      real(wp) :: unit = 1.0_wp                !< largest conductance, m²/(Pa s)
      real(wp), allocatable :: elevation(:)    !< [nodes] Pa
      real(wp), allocatable :: source(:)       !< [nodes] prescribed inflow, divided by `unit`
      logical, allocatable :: is_open(:)       !< [nodes] open to the air
      logical, allocatable :: fixed(:)         !< [nodes] the head is known
      real(wp), allocatable :: head(:), rest(:)  !< [nodes] head φ, Pa, and its rounding error
   end type circuit_type

   !> State of a search for the water table.
   type :: table_type
      real(wp), allocatable :: wet(:)     !< [nodes] 1: below the table, 0: above it, else at it
      real(wp), allocatable :: wetness_step(:)    !< [nodes] last change of a partly wet node
      logical, allocatable :: rose(:)       !< [nodes] the last change was an increase
      integer, allocatable :: changes(:)  !< [nodes] number of changes
   end type table_type

   !> fraction of the conductance of channels above the water table in steady flow
   real(wp), parameter :: air_fraction = 1.0e-3_wp
   !> rounds of the search for the water table in which nodes are wet or dry, and most rounds
   integer, parameter :: free_rounds = 60, most_rounds = 300
   integer, parameter :: change_limit = 4  !< changes after which a node may be partly wet
   !> accepted pressure of a partly wet node/largest potential
   real(wp), parameter :: pressure_tolerance = 1.0e-6_wp
   real(wp), parameter :: growth = 1.2_wp, reduction = 0.5_wp  !< factors of `wetness_step`
   real(wp), parameter :: rounding = 1.0e-9_wp  !< rounding of potentials/largest potential
   integer, parameter :: most_passes = 6        !< passes of iterative refinement
   real(wp), parameter :: flux_error = 1.0e-14_wp  !< aim: surplus of a node/largest flux
   real(wp), parameter :: max_imbalance = 1.0e-6_wp  !< sum of inflows/largest inflow

contains

   !> Find the heads and fluxes of steady flow in a group; without a known head nothing flows.
   !>
   !> Water exists only below the water table: a channel with both nodes above it conducts little
   !> (residual flow, Desai 1976).  If nodes are wet and dry in turn, the table passes through them:
   !> their pressure is 0, and a fraction of the conductance is found that yields it.
   pure subroutine find_steady_flow(network, group, is_open, source, fixed, head, flux, &
      unconverged, failure)
      type(network_type), intent(in) :: network  !< network of the model
      type(group_type), intent(in) :: group      !< component of the network
      logical, intent(in) :: is_open(:)          !< [nodes] open to the air
      real(wp), intent(in) :: source(:)          !< [nodes] inflow, m²/s
      logical, intent(inout) :: fixed(:)         !< [nodes] head is known; open nodes may change
      real(wp), intent(inout) :: head(:)         !< [nodes] φ, Pa; known at fixed nodes
      real(wp), intent(inout) :: flux(:)         !< [channels] m²/s; set in this group
      logical, intent(inout) :: unconverged      !< set to .true. if no water table is found
      character(len=:), allocatable, intent(inout) :: failure  !< reason why there is no solution
      type(circuit_type) :: circuit
      type(table_type) :: table
      real(wp) :: link(size(group%node), size(group%node)), sum_of_links(size(group%node))
      real(wp) :: pressure(size(group%node)), scale
      integer, allocatable :: order(:)
      logical :: table_found, faces_found
      integer :: round, n

      if (.not. any(fixed(group%node))) then
         if (any(abs(source(group%node)) > 0.0_wp)) failure = 'steady flow with a prescribed '// &
            'inflow needs a head or pressure at a node of the connected joints; none acts '// &
            'beside'//place_of(network, group%node(maxloc(abs(source(group%node)), 1)))
         return
      end if
      circuit = circuit_of(network, group, is_open, source, fixed, head)
      n = size(group%node)
      table = table_type(spread(1.0_wp, 1, n), spread(0.5_wp, 1, n), spread(.true., 1, n), &
         spread(0, 1, n))
      do round = 1, most_rounds
         call set_conductances(circuit, network, table%wet)
         call eliminate_nodes(circuit, link, sum_of_links, order)
         call improve_heads(circuit, link, sum_of_links, order, .true.)
         scale = maxval(abs(circuit%head))
         pressure = merge(0.0_wp, circuit%head - circuit%elevation, circuit%fixed)
         call move_table(table, pressure, scale, round > free_rounds, table_found)
         call revise_seepage(circuit, pressure, rounding*scale, faces_found)
         if (table_found .and. faces_found) exit
      end do
      if (round <= most_rounds) call improve_heads(circuit, link, sum_of_links, order, .false.)
      fixed(group%node) = circuit%fixed
      head(group%node) = circuit%head
      flux(circuit%channel) = circuit%unit*circuit%flux
      if (round > most_rounds) then
         unconverged = .true.
      else
         call check_flow(network, group, circuit, pressure_tolerance*scale, failure)
      end if
   end subroutine find_steady_flow

   !> Set up the channels and nodes of a group; those without a known head begin with a mean head.
   pure type(circuit_type) function circuit_of(network, group, is_open, source, fixed, head) &
      result(circuit)
      type(network_type), intent(in) :: network  !< network of the model
      type(group_type), intent(in) :: group      !< component of the network
      logical, intent(in) :: is_open(:), fixed(:)    !< [nodes] open to the air; head is known
      real(wp), intent(in) :: source(:), head(:)     !< [nodes] inflow, m²/s; φ, Pa
      integer :: index(size(fixed)), c, i

      index = 0
      index(group%node) = [(i, i=1, size(group%node))]
      circuit%channel = pack([(c, c=1, size(network%absent))], [(.not. network%absent(c) .and. &
         index(network%flow%channel(c)%node(1)) > 0, c=1, size(network%absent))])
      allocate (circuit%ends(2, size(circuit%channel)))
      do c = 1, size(circuit%channel)
         circuit%ends(:, c) = index(network%flow%channel(circuit%channel(c))%node)
      end do
      circuit%unit = max(tiny(1.0_wp), maxval(network%conductance(circuit%channel)))
      circuit%elevation = network%elevation(group%node)
      circuit%source = source(group%node)/circuit%unit
      circuit%is_open = is_open(group%node)
      circuit%fixed = fixed(group%node)
      circuit%head = head(group%node)
      where (.not. circuit%fixed) circuit%head = sum(circuit%head, circuit%fixed) &
         /count(circuit%fixed)
      circuit%rest = 0.0_wp*circuit%head
      allocate (circuit%conductance(size(circuit%channel)), circuit%flux(size(circuit%channel)))
   end function circuit_of

   !> Set the conductances for the present water table.
   pure subroutine set_conductances(circuit, network, wet)
      type(circuit_type), intent(inout) :: circuit  !< receives the conductances
      type(network_type), intent(in) :: network     !< network of the model
      real(wp), intent(in) :: wet(:)                !< [nodes] see `table_type`
      integer :: c

      do c = 1, size(circuit%channel)
         circuit%conductance(c) = network%conductance(circuit%channel(c))/circuit%unit &
            *conducting(wet(circuit%ends(1, c)), wet(circuit%ends(2, c)))
      end do
   end subroutine set_conductances

   !> Find heads once for new conductances, or else their rounding errors by iterative refinement.
   pure subroutine improve_heads(circuit, link, sum_of_links, order, is_new)
      type(circuit_type), intent(inout) :: circuit  !< receives heads and fluxes
      real(wp), intent(in), contiguous :: link(:,:), sum_of_links(:)  !< see `eliminate_nodes`
      integer, intent(in) :: order(:)               !< eliminated nodes in their order
      logical, intent(in) :: is_new                 !< the conductances have changed
      real(wp) :: surplus(size(circuit%head))
      integer :: pass

      if (is_new) circuit%rest = 0.0_wp
      if (is_new) call set_fluxes(circuit)
      do pass = 1, merge(1, most_passes, is_new)
         surplus = merge(0.0_wp, circuit%source - outflow_of_nodes(circuit), circuit%fixed)
         if (maxval(abs(surplus)) <= flux_error*maxval(abs(circuit%flux))) exit
         call find_heads_of(surplus, link, sum_of_links, order)
         if (is_new) then
            circuit%head = circuit%head + surplus
         else
            circuit%rest = circuit%rest + surplus
         end if
         call set_fluxes(circuit)
      end do
   end subroutine improve_heads

   !> Find the changes of head that carry away a surplus at each node.
   pure subroutine find_heads_of(surplus, link, sum_of_links, order)
      real(wp), intent(inout) :: surplus(:)   !< [nodes] m²/s divided by `unit`; becomes heads, Pa
      real(wp), intent(in), contiguous :: link(:,:), sum_of_links(:)  !< see `eliminate_nodes`
      integer, intent(in) :: order(:)         !< eliminated nodes in their order
      integer :: k

      do k = 1, size(order)
         associate (i => order(k))
            surplus = surplus + link(:, i)*(surplus(i)/sum_of_links(i))
         end associate
      end do
      do k = size(order), 1, -1
         associate (i => order(k))
            surplus(i) = (surplus(i) + dot_product(link(:, i), surplus))/sum_of_links(i)
         end associate
      end do
   end subroutine find_heads_of

   !> Eliminate the nodes without known heads, those with fewest neighbours first.
   !> The column of a node then holds its conductances to nodes that are eliminated later.
   pure subroutine eliminate_nodes(circuit, link, sum_of_links, order)
      type(circuit_type), intent(in) :: circuit   !< with conductances
      real(wp), intent(out), contiguous :: link(:,:)  !< [nodes,nodes] conductances between nodes
      real(wp), intent(out) :: sum_of_links(:)    !< [nodes] also to nodes of known head
      integer, allocatable, intent(out) :: order(:)  !< eliminated nodes in their order
      real(wp) :: to_fixed(size(link, 1)), share
      integer :: neighbours(size(link, 1)), near(size(link, 1)), count_near, c, i, j, k

      allocate (order(count(.not. circuit%fixed)))
      link = 0.0_wp
      to_fixed = 0.0_wp
      neighbours = merge(huge(1), 0, circuit%fixed)
      do c = 1, size(circuit%conductance)
         associate (g => circuit%conductance(c), a => circuit%ends(1, c), b => circuit%ends(2, c))
            if (circuit%fixed(a)) then
               to_fixed(b) = to_fixed(b) + g
            else if (circuit%fixed(b)) then
               to_fixed(a) = to_fixed(a) + g
            else if (a /= b) then
               if (.not. link(a, b) > 0.0_wp) then
                  neighbours(a) = neighbours(a) + 1
                  neighbours(b) = neighbours(b) + 1
               end if
               link(a, b) = link(a, b) + g
               link(b, a) = link(a, b)
            end if
         end associate
      end do
      do k = 1, size(order)
         order(k) = minloc(neighbours, 1)
         associate (node => order(k))
            count_near = 0
            do i = 1, size(link, 1)
               if (.not. link(i, node) > 0.0_wp) cycle
               count_near = count_near + 1
               near(count_near) = i
            end do
            sum_of_links(node) = to_fixed(node) + sum(link(near(:count_near), node))
            neighbours(node) = huge(1)
            do j = 1, count_near
               share = link(near(j), node)/sum_of_links(node)
               to_fixed(near(j)) = to_fixed(near(j)) + share*to_fixed(node)
               call join_neighbours(share, link(:, node), near(:count_near), near(j), &
                  link(:, near(j)), neighbours(near(j)))
               link(node, near(j)) = 0.0_wp
            end do
         end associate
      end do
   end subroutine eliminate_nodes

   !> Connect a node with the other neighbours of an eliminated node.
   pure subroutine join_neighbours(share, eliminated, near, own, column, neighbours)
      real(wp), intent(in) :: share            !< conductance to the eliminated node/its sum
      real(wp), intent(in), contiguous :: eliminated(:)  !< column of the eliminated node
      integer, intent(in), contiguous :: near(:)         !< its neighbours
      integer, intent(in) :: own                         !< the node, one of them
      real(wp), intent(inout), contiguous :: column(:)   !< column of the node
      integer, intent(inout) :: neighbours     !< number of neighbours of the node
      integer :: i

      do i = 1, size(near)
         if (near(i) == own) cycle
         if (.not. column(near(i)) > 0.0_wp) neighbours = neighbours + 1
         column(near(i)) = column(near(i)) + share*eliminated(near(i))
      end do
      neighbours = neighbours - 1  ! the eliminated node
   end subroutine join_neighbours

   !> Set the fluxes that follow from the heads.
   pure subroutine set_fluxes(circuit)
      type(circuit_type), intent(inout) :: circuit  !< with heads
      integer :: c

      do c = 1, size(circuit%flux)
         associate (a => circuit%ends(1, c), b => circuit%ends(2, c))
            circuit%flux(c) = circuit%conductance(c)*((circuit%head(a) - circuit%head(b)) &
               + (circuit%rest(a) - circuit%rest(b)))
         end associate
      end do
   end subroutine set_fluxes

   !> Return the outflow from each node into its channels, m²/s divided by `unit`.
   pure function outflow_of_nodes(circuit) result(outflow)
      type(circuit_type), intent(in) :: circuit  !< with fluxes
      real(wp) :: outflow(size(circuit%head))
      integer :: c

      outflow = 0.0_wp
      do c = 1, size(circuit%flux)
         associate (a => circuit%ends(1, c), b => circuit%ends(2, c))
            outflow(a) = outflow(a) + circuit%flux(c)
            outflow(b) = outflow(b) - circuit%flux(c)
         end associate
      end do
   end function outflow_of_nodes

   !> Revise which open nodes have p = 0: those with water from the air close, and those with
   !> pressure discharge.  The last known head remains, so that the lowest outlet holds the water.
   pure subroutine revise_seepage(circuit, pressure, tolerance, found)
      type(circuit_type), intent(inout) :: circuit  !< with heads and fluxes
      real(wp), intent(in) :: pressure(:)           !< [nodes] Pa
      real(wp), intent(in) :: tolerance             !< rounding of heads, Pa
      logical, intent(out) :: found                 !< no node has changed
      real(wp) :: inflow(size(pressure)), conductance(size(pressure))
      logical :: closes(size(pressure)), opens(size(pressure))
      integer :: c, lowest

      found = .true.
      if (.not. any(circuit%is_open)) return
      conductance = 0.0_wp
      do c = 1, size(circuit%conductance)
         conductance(circuit%ends(:, c)) = conductance(circuit%ends(:, c)) + circuit%conductance(c)
      end do
      inflow = outflow_of_nodes(circuit) - circuit%source
      closes = circuit%is_open .and. circuit%fixed .and. inflow > tolerance*conductance
      opens = circuit%is_open .and. .not. circuit%fixed .and. pressure > tolerance
      if (.not. any(circuit%fixed .and. .not. closes)) then
         lowest = minloc(circuit%elevation, 1, circuit%fixed)
         closes(lowest) = .false.
      end if
      found = .not. any(closes .or. opens)
      circuit%fixed = circuit%fixed .neqv. (closes .or. opens)
      where (opens) circuit%head = circuit%elevation
   end subroutine revise_seepage

   !> Explain a flow that does not balance, or that would require suction.
   pure subroutine check_flow(network, group, circuit, tolerance, failure)
      type(network_type), intent(in) :: network    !< network of the model
      type(group_type), intent(in) :: group        !< component of the network
      type(circuit_type), intent(in) :: circuit    !< solved
      real(wp), intent(in) :: tolerance            !< accepted suction, Pa
      character(len=:), allocatable, intent(inout) :: failure  !< reason why there is no solution
      real(wp) :: inflow(size(circuit%head))
      logical :: is_dry_well(size(circuit%head))
      integer :: i

      inflow = merge(outflow_of_nodes(circuit), circuit%source, circuit%fixed)
      if (.not. abs(sum(inflow)) <= max_imbalance*maxval(abs(inflow))) failure = &
         'the steady flow in joints beside'//place_of(network, group%node(1))//' does not '// &
         'balance: inflows of at most '//to_text(circuit%unit*maxval(abs(inflow)))// &
         ' m²/s have the sum '//to_text(circuit%unit*sum(inflow))// &
         ' m²/s; apertures differ too much'
      is_dry_well = circuit%source < 0.0_wp .and. .not. circuit%fixed .and. &
         circuit%head - circuit%elevation < -tolerance
      if (.not. any(is_dry_well)) return
      i = findloc(is_dry_well, .true., 1)
      failure = 'the outflow '//to_text(-circuit%unit*circuit%source(i))//' m²/s prescribed at'// &
         place_of(network, group%node(i))//' exceeds what flows to this node: it would '// &
         'require suction'
   end subroutine check_flow

   !> Return the place of a node, for messages.
   pure function place_of(network, node) result(text)
      type(network_type), intent(in) :: network  !< network of the model
      integer, intent(in) :: node                !< number of the node
      character(len=:), allocatable :: text

      text = ' ('//to_text(network%flow%position(:, node) + network%flow%origin)//')'
   end function place_of

   !> Revise which nodes are wet; nodes that have changed often may become partly wet.
   pure subroutine move_table(table, pressure, scale, partly, converged)
      type(table_type), intent(inout) :: table  !< state of the search
      real(wp), intent(in) :: pressure(:)       !< [nodes] Pa
      real(wp), intent(in) :: scale             !< largest potential, Pa
      logical, intent(in) :: partly             !< nodes may become partly wet
      logical, intent(out) :: converged         !< all nodes are as their pressures require
      real(wp) :: target, tolerance
      logical :: rises
      integer :: i

      converged = .true.
      do i = 1, size(pressure)
         associate (wet => table%wet(i), step => table%wetness_step(i), changes => table%changes(i))
            rises = .not. pressure(i) < -rounding*scale
            target = merge(1.0_wp, 0.0_wp, rises)
            tolerance = merge(pressure_tolerance*scale, 0.0_wp, partly .and. changes > change_limit)
            if (.not. abs(target - wet) > 0.0_wp .or. abs(pressure(i)) < tolerance) cycle
            converged = .false.
            if (partly .and. changes > change_limit) then
               step = min(0.5_wp, merge(growth, reduction, rises .eqv. table%rose(i))*step)
               wet = min(1.0_wp, max(0.0_wp, wet + merge(step, -step, rises)))
            else
               wet = target
               changes = changes + 1
            end if
            table%rose(i) = rises
         end associate
      end do
   end subroutine move_table

   !> Return the fraction of its conductance that a channel has, from the wetness of its nodes.
   elemental real(wp) function conducting(wet_a, wet_b)
      real(wp), intent(in) :: wet_a, wet_b  !< 0 … 1
      real(wp) :: wetter

      wetter = max(wet_a, wet_b)
      conducting = merge(1.0_wp, air_fraction + (1.0_wp - air_fraction)*wetter, wetter >= 1.0_wp)
   end function conducting

end module dda_steady_flow
