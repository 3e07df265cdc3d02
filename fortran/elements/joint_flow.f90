! SPDX-License-Identifier: GPL-3.0-or-later
!> Water flow in joints, solved together with the motion of the blocks in a step.
!>
!> Water balance of a node in a step: the inflow fills opening joints and the storage, or flows
!> out:
!>
!>     Bᵀd + S Δp + Δt H (p₁ + γy) − Δt Q = Δw ,
!>
!> where w is the volume without water.  A node is full (w = 0, p free) or partly full (p = p_v,
!> w ≥ 0); a step whose solution contradicts this is solved again with other states.  The balance
!> and the forces B p₁ on blocks form a symmetric positive definite system, which is stable for any
!> Δt.  Then
!>     p₁ᵀBᵀd = −Δ(½ pᵀSp) − ½ ΔpᵀSΔp − Δt φᵀHφ + Δt (γy)ᵀHφ + Δt p₁ᵀQ + p₁ᵀΔw ,  φ = p₁ + γy:
!>
!> The work on the blocks is the released energy of the water, minus the losses by scheme and
!> viscosity, plus the work of weight, inflow and vapour.
!>
!> In the undrained state H = 0.  In the steady state, the pressures of steady flow through the
!> apertures at the start of the step are a load without stiffness.
!>
!> A boundary node above its water is open to the air: p = 0, w ≥ 0, and no water flows in.
module dda_joint_flow
   use dda_kinds, only: wp
   use dda_archive, only: archive_type, archive_values => serialise
   use dda_block_matrix, only: block_matrix_type
   use dda_blocks, only: blocks_type
   use dda_edge_load, only: edge_load_type
   use dda_element, only: element_type
   use dda_energy, only: energy_type, add_energy, energy_algorithmic, energy_flow, energy_input, &
      energy_water
   use dda_flow, only: flow_type, find_boundary_pressure, value_at, flow_steady, flow_transient, &
      flow_undrained
   use dda_flow_groups, only: group_type, set_groups, set_springs, add_springs, &
      add_node_springs, add_changes
   use dda_flow_network, only: network_type, new_network, update_network, stored_energy, &
      growth_of, add_pressures, fluxes_of, net_outflow
   use dda_linear_terms, only: linear_terms_type
   use dda_output_schema, only: columns_of, in_flow_nodes, in_flow_channels
   use dda_scheme, only: step_type, end_time
   use dda_steady_flow, only: find_steady_flow
   implicit none
   private
   public :: joint_flow_type, new_joint_flow, node_columns, channel_columns

   !> number of output values of a node and of a channel
   integer, parameter :: node_columns = columns_of(in_flow_nodes)
   integer, parameter :: channel_columns = columns_of(in_flow_channels)
   !> rounds in which all nodes may change state; later one node per round, which ends (Murty 1974)
   integer, parameter :: free_rounds = 15
   real(wp), parameter :: rounding = 1.0e-12_wp !< rounding of pressures and volumes
   !> first and least fraction of a change of pressure by a given inflow, and factors of it
   real(wp), parameter :: first_relaxation = 0.1_wp, least_relaxation = 0.01_wp
   real(wp), parameter :: faster = 1.2_wp, slower = 0.5_wp

   !> Water of a model and its state.
   type, extends(element_type) :: joint_flow_type
      type(network_type) :: network
      type(group_type), allocatable :: group(:)
      logical :: frozen = .false.  !< static stage; boundaries have their values at `time`
      real(wp) :: time = 0.0_wp               !< s
      real(wp), allocatable :: pressure(:)    !< [nodes] Pa
      real(wp), allocatable :: empty_volume(:)       !< [nodes] volume without water w, m³ per metre
      logical, allocatable :: vented(:)       !< [nodes] the node is assumed partly full
      logical, allocatable :: is_dry(:)  !< [boundaries] the load of the boundary does not act
      ! Variables of the step
      type(step_type) :: step
      integer :: rounds = 0                   !< rounds of revised states
      logical :: table_failed = .false.          !< the search for the water table has failed
      character(len=:), allocatable :: failure   !< reason why the step has no steady flow
      logical, allocatable :: fixed(:)        !< [nodes] the pressure is prescribed
      logical, allocatable :: is_open(:)      !< [nodes] open to the air: only outflow
      real(wp), allocatable :: steady_flux(:)    !< [channels] m²/s
      real(wp), allocatable :: source(:)      !< [nodes] inflow Q, m²/s
      real(wp), allocatable :: conductance(:) !< [channels] effective conductance, m²/(Pa s)
      real(wp), allocatable :: predicted(:)       !< [nodes] p₁ at d = 0, Pa
      real(wp), allocatable :: residual(:)        !< [nodes] r, m³ per metre of thickness
      real(wp), allocatable :: head(:)        !< [nodes] φ at the end of the step, Pa
      real(wp), allocatable :: end_pressure(:)       !< [nodes] p₁ of the last solution, Pa
      real(wp), allocatable :: growth(:)  !< [nodes] volume increase Bᵀd of the last solution, m³/m
      ! Variables of the last accepted step
      real(wp), allocatable :: change(:)      !< [nodes] steady minus former pressure, Pa
      real(wp), allocatable :: relaxation(:)  !< [groups] fraction of this change in the next step
      real(wp), allocatable :: inflow(:)      !< [nodes] inflow from outside, m²/s
      real(wp), allocatable :: flux(:)  !< [channels] flux from the first node to the second, m²/s
   contains
      procedure :: add_linear_terms, add_packed, add_force, add_stored_energy, add_to_budget, &
         prepare_step, revise_states, accept_step, freeze_for_statics, inherit_state, serialise, &
         node_values, channel_values
   end type joint_flow_type

contains

   !> Create the water of a model in its initial state.
   type(joint_flow_type) function new_joint_flow(flow, loads, blocks) result(self)
      type(flow_type), intent(in) :: flow      !< flow of the model
      type(edge_load_type), intent(in) :: loads(:)  !< loads of the model
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      integer :: n

      self%network = new_network(flow, blocks)
      self%is_dry = [(is_missing(flow%boundary(n)%load, loads), n=1, size(flow%boundary))]
      n = size(flow%pressure)
      self%pressure = flow%pressure
      self%empty_volume = (1.0_wp - flow%saturation)*self%network%volume
      self%vented = self%empty_volume > 0.0_wp
      allocate (self%fixed(n), self%is_open(n), source=.false.)
      allocate (self%source(n), self%inflow(n), source=0.0_wp)
      allocate (self%flux(size(flow%channel)), self%steady_flux(size(flow%channel)), source=0.0_wp)
      self%predicted = self%pressure
      self%residual = 0.0_wp*self%pressure
      self%end_pressure = self%pressure
      self%head = self%pressure
      self%growth = self%residual
      self%conductance = 0.0_wp*self%network%conductance
      call begin_state(self)
   end function new_joint_flow

   !> .true. if the load of a boundary is not among the loads.
   pure logical function is_missing(load, loads)
      integer, intent(in) :: load                   !< number of the load; 0: none
      type(edge_load_type), intent(in) :: loads(:)  !< loads of the model

      is_missing = load > 0
      if (is_missing) is_missing = .not. loads(load)%present
   end function is_missing

   !> Begin the flow state of a stage, and form its groups of nodes.
   subroutine begin_state(self)
      class(joint_flow_type), intent(inout) :: self  !< elements of this kind

      self%network%flows = stage_flow_state(self) /= flow_undrained
      self%packs = .not. (self%network%flows .or. self%frozen)  ! statics read the list
      call set_groups(self%network, self%group)
      self%change = 0.0_wp*self%pressure
      self%relaxation = spread(first_relaxation, 1, size(self%group))
      if (stage_flow_state(self) /= flow_steady) call set_springs(self%network, &
         self%conductance, self%fixed .or. self%vented, self%group)
   end subroutine begin_state

   !> Return the flow state of the stage: steady, transient or undrained.
   pure integer function stage_flow_state(self)
      class(joint_flow_type), intent(in) :: self  !< elements of this kind

      stage_flow_state = self%network%flow%state(merge(1, 2, self%frozen))
   end function stage_flow_state

   !> Prepare a step: apertures, boundaries, and pressures for d = 0.
   subroutine prepare_step(self, blocks, step, d)
      class(joint_flow_type), intent(inout) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks  !< blocks at the start of the step
      type(step_type), intent(in) :: step      !< the present step
      real(wp), intent(in) :: d(:,:)           !< [6,blocks] increments of the coordinates

      call update_network(self%network, blocks)
      self%step = step
      self%rounds = 0
      self%table_failed = .false.
      if (allocated(self%failure)) deallocate (self%failure)
      self%vented = self%empty_volume > 0.0_wp
      call set_boundaries(self, merge(self%time, end_time(step), self%frozen))
      call set_assumed_terms(self)
   end subroutine prepare_step

   !> Set the conductances in the assumed states by the cubic law.
   !> Outflow from a node with saturation s < 1 at the start of the step has the factor s²(3 − 2s),
   !> and an open node supplies at most its water.
   pure subroutine set_conductance(self)
      class(joint_flow_type), intent(inout) :: self  !< elements of this kind
      real(wp) :: saturation, drop
      logical :: is_airy(size(self%vented))
      integer :: c, from

      self%conductance = 0.0_wp
      if (stage_flow_state(self) /= flow_transient) return
      self%conductance = self%network%conductance
      is_airy = self%vented .or. self%is_open
      if (.not. any(is_airy)) return
      do c = 1, size(self%conductance)
         associate (node => self%network%flow%channel(c)%node, head => self%pressure &
            + self%network%elevation)
            from = node(merge(1, 2, head(node(1)) > head(node(2)) .or. (head(node(1)) >= &
               head(node(2)) .and. .not. is_airy(node(1)))))
            drop = abs(head(node(1)) - head(node(2)))
         end associate
         if (.not. is_airy(from)) cycle
         saturation = max(0.0_wp, 1.0_wp - self%empty_volume(from)/self%network%volume(from))
         self%conductance(c) = self%conductance(c)*saturation**2*(3.0_wp - 2.0_wp*saturation)
         if (self%is_open(from)) self%conductance(c) = min(self%conductance(c), &
            saturation*self%network%volume(from)/max(tiny(drop), self%step%time_step*drop))
      end do
   end subroutine set_conductance

   !> Set the pressures and inflows that the boundaries prescribe at a time.
   !> A node above the level of its water is open to the air, unless other water covers it.
   pure subroutine set_boundaries(self, time)
      class(joint_flow_type), intent(inout) :: self  !< elements of this kind
      real(wp), intent(in) :: time  !< time, s
      real(wp) :: pressure
      logical :: is_open
      integer :: b, i

      self%fixed = .false.
      self%is_open = .false.
      self%source = 0.0_wp
      associate (flow => self%network%flow)
         do b = 1, size(flow%boundary)
            do i = 1, size(flow%boundary(b)%node)
               associate (node => flow%boundary(b)%node(i))
                  if (flow%boundary(b)%inflow) then
                     self%source(node) = self%source(node) + value_at(flow%boundary(b), time) &
                        /size(flow%boundary(b)%node)
                     cycle
                  end if
                  call find_boundary_pressure(flow%boundary(b), time, &
                     self%network%unit_weight(node), self%network%elevation(node), pressure, &
                     is_open)
                  is_open = is_open .or. self%is_dry(b)
                  if (is_open .and. self%fixed(node)) cycle
                  self%fixed(node) = .true.
                  self%is_open(node) = is_open
                  self%predicted(node) = merge(0.0_wp, pressure, is_open)
               end associate
            end do
         end do
      end associate
      self%vented = self%vented .and. .not. self%fixed
   end subroutine set_boundaries

   !> Compute springs and pressures at d = 0 in the assumed states.
   subroutine set_assumed_terms(self)
      class(joint_flow_type), intent(inout) :: self  !< elements of this kind
      integer :: g

      where (.not. self%fixed) self%predicted = merge(self%network%min_pressure, self%pressure, &
         self%vented)
      if (stage_flow_state(self) == flow_steady) then
         self%head = self%predicted + self%network%elevation
         self%steady_flux = 0.0_wp
         do g = 1, size(self%group)
            call find_steady_flow(self%network, self%group(g), self%is_open, self%source, &
               self%fixed, self%head, self%steady_flux, self%table_failed, self%failure)
         end do
         self%predicted = steady_pressures(self)
         call relax_changes(self)
         return
      end if
      call set_conductance(self)
      call set_springs(self%network, self%step%time_step*self%conductance, self%fixed .or. &
         self%vented, self%group)
      self%residual = self%step%time_step*self%source
      if (self%network%flows) self%residual = self%residual - outflow_in_step(self, self%predicted)
      self%residual = merge(0.0_wp, self%residual - self%empty_volume, self%fixed .or. self%vented)
      call add_changes(self%network, self%group, self%residual, self%predicted)
   end subroutine set_assumed_terms

   !> Return the pressures of steady flow through the present apertures, Pa.
   pure function steady_pressures(self) result(pressure)
      class(joint_flow_type), intent(in) :: self  !< elements of this kind
      real(wp) :: pressure(size(self%head))

      pressure = merge(self%predicted, max(0.0_wp, self%head - self%network%elevation), self%fixed)
   end function steady_pressures

   !> Take only a fraction of the change to the steady pressures where an inflow is prescribed.
   !>
   !> Such a pressure is proportional to the inverse cube of apertures, which it widens, so that
   !> whole changes may grow from step to step.
   pure subroutine relax_changes(self)
      class(joint_flow_type), intent(inout) :: self  !< elements of this kind
      integer :: g

      if (.not. any(abs(self%source) > 0.0_wp)) return
      do g = 1, size(self%group)
         associate (node => self%group(g)%node)
            if (.not. any(abs(self%source(node)) > 0.0_wp)) cycle
            where (.not. self%fixed(node)) self%predicted(node) = self%pressure(node) &
               + self%relaxation(g)*(self%predicted(node) - self%pressure(node))
         end associate
      end do
   end subroutine relax_changes

   !> Revise the relaxation of each group: slower if the change of its pressures reverses.
   pure subroutine revise_relaxation(self)
      class(joint_flow_type), intent(inout) :: self  !< elements of this kind
      real(wp) :: change(size(self%head))
      integer :: g

      if (.not. any(abs(self%source) > 0.0_wp)) return
      change = merge(0.0_wp, steady_pressures(self) - self%pressure, self%fixed)
      do g = 1, size(self%group)
         associate (node => self%group(g)%node, fraction => self%relaxation(g))
            fraction = merge(max(least_relaxation, slower*fraction), min(1.0_wp, faster*fraction), &
               dot_product(change(node), self%change(node)) < 0.0_wp)
         end associate
      end do
      self%change = change
   end subroutine revise_relaxation

   !> Find the increase of volumes and the pressures at the end of a step with increment d.
   pure subroutine find_pressures(self, d)
      class(joint_flow_type), intent(inout) :: self  !< elements of this kind
      real(wp), intent(in) :: d(:,:)  !< [6,blocks] increments of the coordinates
      real(wp) :: residual(size(self%predicted))

      self%growth = growth_of(self%network, d)
      self%end_pressure = self%predicted
      if (stage_flow_state(self) == flow_steady) return
      residual = merge(0.0_wp, -self%growth, self%fixed .or. self%vented)
      call add_changes(self%network, self%group, residual, self%end_pressure)
   end subroutine find_pressures

   !> Return the surplus of each node, m³ per metre: increase of empty volume, or external inflow.
   pure function node_surplus(self) result(surplus)
      class(joint_flow_type), intent(in) :: self  !< elements of this kind
      real(wp) :: surplus(size(self%end_pressure))

      surplus = self%growth + self%network%storage*(self%end_pressure - self%pressure)
      if (self%network%flows) surplus = surplus + outflow_in_step(self, self%end_pressure)
      surplus = surplus - self%step%time_step*self%source
   end function node_surplus

   !> Return the volume Δt H (p + γy) that flows out of each node, m³ per metre of thickness.
   !> Not needed without flow.
   pure function outflow_in_step(self, pressure) result(outflow)
      class(joint_flow_type), intent(in) :: self  !< elements of this kind
      real(wp), intent(in) :: pressure(:)  !< [nodes] Pa
      real(wp) :: outflow(size(pressure))

      outflow = self%step%time_step*net_outflow(self%network, fluxes_of(self%network, &
         self%conductance, pressure + self%network%elevation))
   end function outflow_in_step

   !> Append the springs of enclosed water.
   subroutine add_linear_terms(self, blocks, step, terms)
      class(joint_flow_type), intent(in) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(step_type), intent(in) :: step  !< the present step
      type(linear_terms_type), intent(inout) :: terms  !< springs and dashpots

      if (stage_flow_state(self) /= flow_steady) call add_springs(self%network, self%fixed .or. &
         self%vented, self%group, terms)
   end subroutine add_linear_terms

   !> Add the springs of enclosed water, which does not flow, to K̂.
   subroutine add_packed(self, matrix, fits)
      class(joint_flow_type), intent(in) :: self  !< elements of this kind
      type(block_matrix_type), intent(inout) :: matrix  !< linear part of K̂
      logical, intent(inout) :: fits  !< set to .false. if the pattern lacks a pair

      call add_node_springs(self%network, self%fixed .or. self%vented, matrix, fits)
   end subroutine add_packed

   !> Add the forces B p₁ at d = 0.
   subroutine add_force(self, blocks, step, load)
      class(joint_flow_type), intent(in) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(step_type), intent(in) :: step  !< the present step
      real(wp), intent(inout) :: load(:,:)  !< [6,blocks] forces, N/m …

      call add_pressures(self%network, self%predicted, load)
   end subroutine add_force

   !> Add the energy ½ pᵀSp of compressed water.
   subroutine add_stored_energy(self, blocks, step, energy)
      class(joint_flow_type), intent(in) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(step_type), intent(in) :: step  !< the next step
      type(energy_type), intent(inout) :: energy  !< energy budget, J per metre

      call add_energy(energy, energy_water, stored_energy(self%network, blocks, self%pressure))
   end subroutine add_stored_energy

   !> Add the terms of the energy identity in the header of this module to the budget.
   subroutine add_to_budget(self, blocks, step, d, energy)
      class(joint_flow_type), intent(in) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks  !< blocks at the start of the step
      type(step_type), intent(in) :: step  !< the present step
      real(wp), intent(in) :: d(:,:)  !< [6,blocks] increments of the coordinates
      type(energy_type), intent(inout) :: energy  !< energy budget, J per metre
      real(wp) :: stored, former, viscous, loss, work
      integer :: i

      stored = 0.0_wp
      former = 0.0_wp
      work = 0.0_wp
      loss = 0.0_wp
      associate (before => self%pressure, after => self%end_pressure)
         do i = 1, size(after)  ! one loop, so that the sums overlap
            stored = stored + 0.5_wp*self%network%storage(i)*after(i)**2
            former = former + 0.5_wp*self%network%storage(i)*before(i)**2
            work = work + after(i)*self%growth(i)
            loss = loss + 0.5_wp*self%network%storage(i)*(after(i) - before(i))**2
            if (self%empty_volume(i) > 0.0_wp .and. .not. (self%vented(i) .or. self%fixed(i))) &
               loss = loss + (after(i) - self%network%min_pressure(i))*self%empty_volume(i)
         end do
      end associate
      viscous = 0.0_wp
      if (stage_flow_state(self) == flow_steady) loss = 0.0_wp
      if (stage_flow_state(self) == flow_transient) viscous = sum((self%end_pressure &
         + self%network%elevation)*outflow_in_step(self, self%end_pressure))
      call add_energy(energy, energy_water, stored)
      call add_energy(energy, energy_flow, viscous)
      call add_energy(energy, energy_algorithmic, loss)
      call add_energy(energy, energy_input, work + stored - former + viscous + loss)
   end subroutine add_to_budget

   !> Revise the states of nodes that contradict the solution.
   !> A node below the least pressure becomes partly full; one without empty volume becomes full.
   subroutine revise_states(self, blocks, step, d, changed)
      class(joint_flow_type), intent(inout) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks  !< blocks at the start of the step
      type(step_type), intent(in) :: step           !< the present step
      real(wp), intent(in) :: d(:,:)  !< [6,blocks] increments of the coordinates
      integer, intent(inout) :: changed  !< number of nodes with another state
      real(wp) :: empty_volume(size(self%predicted))
      logical :: is_wrong(size(self%predicted))
      integer :: first

      self%rounds = self%rounds + 1
      call find_pressures(self, d)
      if (stage_flow_state(self) == flow_steady) return
      if (.not. any(self%vented)) then
         if (all(self%end_pressure >= self%network%min_pressure)) return
      end if
      is_wrong = self%end_pressure < self%network%min_pressure - &
         rounding*maxval(abs(self%end_pressure))
      if (any(self%vented)) then
         empty_volume = self%empty_volume + node_surplus(self)
         is_wrong = merge(empty_volume < -rounding*self%network%volume, is_wrong, self%vented)
      end if
      is_wrong = is_wrong .and. .not. self%fixed
      if (.not. any(is_wrong)) return
      first = findloc(is_wrong, .true., 1)
      if (self%rounds > free_rounds) is_wrong(first + 1:) = .false.
      changed = changed + count(is_wrong)
      self%vented = self%vented .neqv. is_wrong
      call set_assumed_terms(self)
   end subroutine revise_states

   !> Accept the step: update pressures, empty volumes and flow.
   !> Air enters at an open node, and water in excess of its volume leaves.
   subroutine accept_step(self, blocks, step, d)
      class(joint_flow_type), intent(inout) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks  !< blocks at the start of the step
      type(step_type), intent(in) :: step  !< the present step
      real(wp), intent(in) :: d(:,:)  !< [6,blocks] increments of the coordinates
      real(wp) :: surplus(size(self%predicted))

      if (stage_flow_state(self) == flow_steady) then
         call revise_relaxation(self)
         self%flux = self%steady_flux
         self%inflow = merge(net_outflow(self%network, self%flux), self%source, self%fixed)
         where (self%end_pressure > 0.0_wp) self%empty_volume = 0.0_wp
      else
         self%head = self%end_pressure + self%network%elevation
         self%flux = fluxes_of(self%network, self%conductance, self%head)
         self%inflow = self%source
         if (any(self%fixed .or. self%vented)) then
            surplus = node_surplus(self)
            where (self%fixed) self%inflow = self%source + surplus/step%time_step
            surplus = self%empty_volume + surplus
            where (self%is_open) self%inflow = self%source + min(0.0_wp, surplus)/step%time_step
            self%empty_volume = merge(max(0.0_wp, surplus), 0.0_wp, self%vented .or. self%is_open)
         else
            self%empty_volume = 0.0_wp
         end if
      end if
      self%pressure = self%end_pressure
   end subroutine accept_step

   !> Fix the values of the water boundaries in static stages.
   subroutine freeze_for_statics(self, blocks, time)
      class(joint_flow_type), intent(inout) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      real(wp), intent(in) :: time  !< time, s

      self%frozen = .true.
      self%time = time
      call begin_state(self)
   end subroutine freeze_for_statics

   !> Inherit pressures and volumes of the former element.
   subroutine inherit_state(self, former, blocks)
      class(joint_flow_type), intent(inout) :: self  !< elements of this kind
      class(element_type), intent(in) :: former  !< former element, of the same type
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state

      select type (former)
      type is (joint_flow_type)
         self%pressure = former%pressure
         self%empty_volume = former%empty_volume
         self%vented = former%vented
         self%inflow = former%inflow
         self%flux = former%flux
         self%predicted = former%pressure
      end select
   end subroutine inherit_state

   !> Save or restore pressures, volumes without water and flow.
   subroutine serialise(self, archive)
      class(joint_flow_type), intent(inout) :: self  !< elements of this kind
      type(archive_type), intent(inout) :: archive  !< archive that is written or read

      call archive_values(archive, self%pressure)
      call archive_values(archive, self%empty_volume)
      call archive_values(archive, self%inflow)
      call archive_values(archive, self%flux)
      call archive_values(archive, self%change)
      call archive_values(archive, self%relaxation)
   end subroutine serialise

   !> Return the values of each node in the output: pressure, saturation, inflow.
   pure function node_values(self) result(values)
      class(joint_flow_type), intent(in) :: self  !< elements of this kind
      real(wp) :: values(node_columns, size(self%pressure))  !< Pa, –, m²/s

      values(1, :) = self%pressure
      values(2, :) = 1.0_wp
      where (self%empty_volume > 0.0_wp) values(2, :) = max(0.0_wp, 1.0_wp - self%empty_volume &
         /self%network%volume)
      values(3, :) = self%inflow
   end function node_values

   !> Return the values of each channel in the output: flux, aperture.
   pure function channel_values(self) result(values)
      class(joint_flow_type), intent(in) :: self  !< elements of this kind
      real(wp) :: values(channel_columns, size(self%flux))  !< m²/s, m

      values(1, :) = self%flux
      values(2, :) = 0.5_wp*sum(self%network%aperture, 1)
   end function channel_values

end module dda_joint_flow
