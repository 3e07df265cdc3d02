! SPDX-License-Identifier: GPL-3.0-or-later
!> Bolts: springs between material points of blocks, elastic–perfectly plastic, until they break.
!>
!> Along the axis the force is F = k (s − s_p), with the stretch s at the end of the step and the
!> stretch s_p at zero force.  The stretch of a cable is the length of all its legs, which have the
!> same force.  A bolt without compression is slack below s_p.  Beyond the yield force s_p
!> increases, which dissipates F Δs_p.  A step assumes each component elastic, yielding or slack,
!> and is solved again if the solution contradicts this state (`revise_states`).
!> The energy of an elastic bolt is ½ k (s − s_p)²; its numerical loss is defined in `dda_energy`.
!>
!> The tension N of the last step adds the geometric stiffness N ∂²s/∂q² across the legs: N/L for
!> the rotation of legs, and N times the lever arm along the leg if it is positive.  Without it, a
!> block that hangs from a bolt would gain energy while it swings.
module dda_bolts
   use dda_kinds, only: wp
   use dda_archive, only: archive_type, archive_values => serialise
   use dda_blocks, only: blocks_type, offset_of, position_of, shape_matrix
   use dda_bolt, only: bolt_type, axial, across, max_points
   use dda_element, only: element_type
   use dda_energy, only: energy_type, add_energy, energy_support, energy_algorithmic, energy_yield
   use dda_linear_terms, only: linear_terms_type, linear_term_type, add_term, set_rows, &
      stretch_of, term_bolt, at_end
   use dda_output_schema, only: columns_of, in_bolts
   use dda_scheme, only: step_type
   implicit none
   private
   public :: bolts_type, new_bolts, bolt_columns

   integer, parameter :: absent = 0, elastic = 1, yielding = 2, slack = 3, broken = 4
   integer, parameter :: bolt_columns = columns_of(in_bolts)  !< values of a bolt in the output

   !> All bolts of a model and their state.
   type, extends(element_type) :: bolts_type
      type(bolt_type), allocatable :: bolt(:)
      !> [2,bolts] elastic, yielding or slack component
      integer, allocatable :: component_state(:,:)
      logical, allocatable :: installed(:)    !< [bolts] the bolt is installed
      real(wp), allocatable :: zero_stretch(:,:)  !< [2,bolts] stretch at zero force s_p, m
      real(wp), allocatable :: first_stretch(:,:)  !< [2,bolts] stretch at installation, m
      real(wp), allocatable :: stretch(:,:)   !< [2,bolts] s at the end of the last solution, m
      real(wp), allocatable :: force(:,:)     !< [2,bolts] tension positive, N/m
   contains
      procedure :: add_linear_terms, add_force, add_stored_energy, add_to_budget, accept_step, &
         revise_states, inherit_state, serialise, columns
   end type bolts_type

contains

   !> Create bolts; active bolts have their pretension in the present geometry.
   pure type(bolts_type) function new_bolts(bolts, blocks) result(self)
      type(bolt_type), intent(in) :: bolts(:)  !< [bolts]
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      integer :: i, c, n

      n = size(bolts)
      allocate (self%bolt, source=bolts)
      allocate (self%component_state(2, n), source=absent)
      allocate (self%installed(n), source=.false.)
      allocate (self%zero_stretch(2, n), self%first_stretch(2, n), self%stretch(2, n), &
         self%force(2, n), source=0.0_wp)
      do i = 1, n
         if (.not. bolts(i)%present) cycle
         self%installed(i) = .true.
         do c = axial, component_count(self, i)
            self%first_stretch(c, i) = present_stretch(self, i, c, blocks)
         end do
         self%stretch(:, i) = self%first_stretch(:, i)
         self%zero_stretch(:, i) = self%first_stretch(:, i)
         self%zero_stretch(axial, i) = self%first_stretch(axial, i) &
            - bolts(i)%pretension/bolts(i)%stiffness(axial)
         self%force(axial, i) = bolts(i)%pretension
         self%component_state(:, i) = elastic
      end do
   end function new_bolts

   !> Return the vector from point k of bolt i to the next one, m.
   pure function leg_vector(self, i, k, blocks) result(leg)
      class(bolts_type), intent(in) :: self  !< elements of this kind
      integer, intent(in) :: i, k  !< number of the element; leg
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      real(wp) :: leg(2)

      associate (bolt => self%bolt(i))
         leg = position_of(blocks, bolt%block(k + 1), bolt%reference(:, k + 1)) &
            - position_of(blocks, bolt%block(k), bolt%reference(:, k))
      end associate
   end function leg_vector

   !> Return the unit vector of a component in leg k.
   pure function unit_direction(self, i, c, k, blocks) result(direction)
      class(bolts_type), intent(in) :: self  !< elements of this kind
      integer, intent(in) :: i, c, k  !< number of the element; component; leg
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      real(wp) :: direction(2)

      associate (bolt => self%bolt(i))
         if (bolt%grouted) then
            direction = matmul(blocks%axes(:, :, bolt%block(1)), bolt%direction)
         else
            direction = leg_vector(self, i, k, blocks)
            direction = direction/norm2(direction)
         end if
      end associate
      if (c == across) direction = [-direction(2), direction(1)]
   end function unit_direction

   !> Return the stretch of a component in the present geometry, m.
   pure real(wp) function present_stretch(self, i, c, blocks) result(stretch)
      class(bolts_type), intent(in) :: self  !< elements of this kind
      integer, intent(in) :: i, c  !< number of the element; component
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      integer :: k

      stretch = 0.0_wp
      do k = 1, point_count(self, i) - 1
         stretch = stretch + dot_product(unit_direction(self, i, c, k, blocks), &
            leg_vector(self, i, k, blocks))
      end do
   end function present_stretch

   !> Find the gradient of the stretch with respect to the coordinates of each point's block.
   !> A grouted bolt turns with its first block, so both of its forces act at the same point.
   pure subroutine find_stretch_gradient(self, i, c, blocks, row)
      class(bolts_type), intent(in) :: self  !< elements of this kind
      integer, intent(in) :: i, c  !< number of the element; component
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      real(wp), intent(out) :: row(6, max_points)  !< rows for the points of the bolt
      real(wp) :: direction(2), leg(2)
      integer :: k

      associate (bolt => self%bolt(i), n => point_count(self, i))
         row(:, :n) = 0.0_wp
         do k = 1, n - 1
            direction = unit_direction(self, i, c, k, blocks)
            leg = leg_vector(self, i, k, blocks)
            row(:, k) = row(:, k) - matmul(direction, shape_matrix(blocks, bolt%block(k), &
               bolt%reference(:, k)))
            row(3, k) = row(3, k) - (direction(2)*leg(1) - direction(1)*leg(2))
            row(:, k + 1) = row(:, k + 1) + matmul(direction, shape_matrix(blocks, &
               bolt%block(k + 1), bolt%reference(:, k + 1)))
         end do
      end associate
   end subroutine find_stretch_gradient

   !> Return the number of points of bolt i, including its ends.
   pure integer function point_count(self, i)
      class(bolts_type), intent(in) :: self  !< elements of this kind
      integer, intent(in) :: i  !< number of the element

      point_count = size(self%bolt(i)%block)
   end function point_count

   !> Return the number of force components of bolt i.
   pure integer function component_count(self, i)
      class(bolts_type), intent(in) :: self  !< elements of this kind
      integer, intent(in) :: i  !< number of the element

      component_count = merge(across, axial, self%bolt(i)%grouted)
   end function component_count

   !> Return the force of a component in an assumed mode at a stretch, N/m.
   pure real(wp) function component_force(self, i, c, stretch) result(force)
      class(bolts_type), intent(in) :: self  !< elements of this kind
      integer, intent(in) :: i, c  !< number of the element; component
      real(wp), intent(in) :: stretch  !< m

      force = 0.0_wp
      associate (trial => self%bolt(i)%stiffness(c)*(stretch - self%zero_stretch(c, i)))
         if (self%component_state(c, i) == elastic) force = trial
         if (self%component_state(c, i) == yielding) force = sign(self%bolt(i)%yield(c), trial)
      end associate
   end function component_force

   !> Return the mode (elastic, yielding or slack) of a component at a stretch.
   pure integer function component_mode(self, i, c, stretch) result(component_state)
      class(bolts_type), intent(in) :: self  !< elements of this kind
      integer, intent(in) :: i, c  !< number of the element; component
      real(wp), intent(in) :: stretch  !< m
      real(wp) :: trial

      trial = self%bolt(i)%stiffness(c)*(stretch - self%zero_stretch(c, i))
      component_state = elastic
      if (c == axial .and. trial < 0.0_wp .and. .not. self%bolt(i)%compression) then
         component_state = slack
      else if (abs(trial) > self%bolt(i)%yield(c)) then
         component_state = yielding
      end if
   end function component_mode

   !> .true. if bolt i acts.
   elemental logical function is_active(self, i)
      class(bolts_type), intent(in) :: self  !< elements of this kind
      integer, intent(in) :: i  !< number of the element

      is_active = self%component_state(axial, i) /= absent .and. self%component_state(axial, &
         i) /= broken
   end function is_active

   !> Append a spring for each elastic component.
   !> Other components have a term with zero stiffness, so that the matrix pattern is constant.
   subroutine add_linear_terms(self, blocks, step, terms)
      class(bolts_type), intent(in) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(step_type), intent(in) :: step  !< the present step
      type(linear_terms_type), intent(inout) :: terms  !< springs and dashpots
      type(linear_term_type) :: term
      real(wp) :: row(6, max_points)
      integer :: i, c

      do i = 1, size(self%bolt)
         if (.not. is_active(self, i)) cycle
         term = empty_term(self, i, blocks)
         do c = axial, component_count(self, i)
            call find_stretch_gradient(self, i, c, blocks, row)
            call set_rows(term, self%bolt(i)%block, row(:, :point_count(self, i)))
            term%coefficient = merge(self%bolt(i)%stiffness(c), 0.0_wp, self%component_state(c, &
               i) == elastic)
            call add_term(terms, term)
         end do
         do c = 1, curvature_count(self, i)
            call add_term(terms, curvature_term(self, i, c, blocks))
         end do
      end do
   end subroutine add_linear_terms

   !> Return the number of springs across bolt i due to its tension: one per leg and per point.
   pure integer function curvature_count(self, i)
      class(bolts_type), intent(in) :: self  !< elements of this kind
      integer, intent(in) :: i  !< number of the element

      curvature_count = merge(0, 2*point_count(self, i) - 1, self%bolt(i)%grouted)
   end function curvature_count

   !> Return spring j across bolt i: j = 1 … n for its points, then for its n − 1 legs.
   !> The spring of a point acts only on the rotation of its block, so it is not a support.
   pure type(linear_term_type) function curvature_term(self, i, j, blocks) result(term)
      class(bolts_type), intent(in) :: self  !< elements of this kind
      integer, intent(in) :: i, j  !< number of the element; spring
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      real(wp) :: row(6, 2), direction(2), tension
      integer :: a, b, n

      n = point_count(self, i)
      term = empty_term(self, i, blocks)
      tension = max(0.0_wp, self%force(axial, i))
      associate (block => self%bolt(i)%block, reference => self%bolt(i)%reference)
         a = modulo(j - 1, n) + 1
         b = findloc(block /= block(a), .true., 1)
         row = 0.0_wp
         if (j <= n) then
            row(3, 1) = 1.0_wp
            term%coefficient = tension*max(0.0_wp, curvature_arm(self, i, a, blocks))
         else if (block(a + 1) /= block(a)) then
            b = a + 1
            direction = unit_direction(self, i, across, a, blocks)
            row(:, 1) = -matmul(direction, shape_matrix(blocks, block(a), reference(:, a)))
            row(:, 2) = matmul(direction, shape_matrix(blocks, block(b), reference(:, b)))
            term%coefficient = tension/norm2(leg_vector(self, i, a, blocks))
         end if
         call set_rows(term, block([a, b]), row)
      end associate
   end function curvature_term

   !> Return the offset of point k of bolt i along the resultant of the unit forces of its legs, m.
   pure real(wp) function curvature_arm(self, i, k, blocks) result(arm)
      class(bolts_type), intent(in) :: self  !< elements of this kind
      integer, intent(in) :: i, k  !< number of the element; point
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      real(wp) :: resultant(2)

      resultant = 0.0_wp
      if (k < point_count(self, i)) resultant = unit_direction(self, i, axial, k, blocks)
      if (k > 1) resultant = resultant - unit_direction(self, i, axial, k - 1, blocks)
      arm = dot_product(resultant, offset_of(blocks, self%bolt(i)%block(k), &
         self%bolt(i)%reference(:, k)))
   end function curvature_arm

   !> Return the energy of the springs across a bolt in the increment d, J per metre of thickness.
   pure real(wp) function curvature_energy(self, i, blocks, d) result(energy)
      class(bolts_type), intent(in) :: self  !< elements of this kind
      integer, intent(in) :: i  !< number of the element
      type(blocks_type), intent(in) :: blocks  !< blocks at the start of the step
      real(wp), intent(in) :: d(:,:)  !< [6,blocks] increments of the coordinates
      type(linear_term_type) :: term
      integer :: j

      energy = 0.0_wp
      do j = 1, curvature_count(self, i)
         term = curvature_term(self, i, j, blocks)
         energy = energy + 0.5_wp*term%coefficient*stretch_of(term, d)**2
      end do
   end function curvature_energy

   !> Return a term of bolt i with zero stiffness.
   pure type(linear_term_type) function empty_term(self, i, blocks) result(term)
      class(bolts_type), intent(in) :: self  !< elements of this kind
      integer, intent(in) :: i  !< number of the element
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state

      term%kind = term_bolt
      term%instant = at_end
      term%source = i
      term%position = position_of(blocks, self%bolt(i)%block(1), self%bolt(i)%reference(:, 1))
   end function empty_term

   !> Add the forces −F ∂s/∂q at the stretch at the start of the step.
   subroutine add_force(self, blocks, step, load)
      class(bolts_type), intent(in) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(step_type), intent(in) :: step  !< the present step
      real(wp), intent(inout) :: load(:,:)  !< [6,blocks] forces, N/m …
      real(wp) :: row(6, max_points), force
      integer :: i, c, k, b

      do i = 1, size(self%bolt)
         if (.not. is_active(self, i)) cycle
         do c = axial, component_count(self, i)
            call find_stretch_gradient(self, i, c, blocks, row)
            force = component_force(self, i, c, present_stretch(self, i, c, blocks))
            do k = 1, point_count(self, i)
               b = self%bolt(i)%block(k)
               load(:, b) = load(:, b) - force*row(:, k)
            end do
         end do
      end do
   end subroutine add_force

   !> Add the energy ½ F²/k in the present state, J per metre of thickness.
   subroutine add_stored_energy(self, blocks, step, energy)
      class(bolts_type), intent(in) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(step_type), intent(in) :: step  !< the present step
      type(energy_type), intent(inout) :: energy  !< energy budget, J per metre
      integer :: i, c

      do i = 1, size(self%bolt)
         if (.not. is_active(self, i)) cycle
         do c = axial, component_count(self, i)
            call add_energy(energy, energy_support, component_energy(self, i, c, &
               present_stretch(self, i, c, blocks)))
         end do
      end do
   end subroutine add_stored_energy

   !> Return the energy of the spring of a component at a stretch, J per metre of thickness.
   pure real(wp) function component_energy(self, i, c, stretch) result(stored)
      class(bolts_type), intent(in) :: self  !< elements of this kind
      integer, intent(in) :: i, c  !< number of the element; component
      real(wp), intent(in) :: stretch  !< m
      real(wp) :: elongation

      elongation = stretch - self%zero_stretch(c, i)
      if (c == axial .and. .not. self%bolt(i)%compression) elongation = max(elongation, 0.0_wp)
      stored = 0.5_wp*self%bolt(i)%stiffness(c)*elongation**2
   end function component_energy

   !> Add stored energy at the end of the step, and losses by yield, rupture and scheme.
   subroutine add_to_budget(self, blocks, step, d, energy)
      class(bolts_type), intent(in) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(step_type), intent(in) :: step  !< the present step
      real(wp), intent(in) :: d(:,:)  !< [6,blocks] increments of the coordinates
      type(energy_type), intent(inout) :: energy  !< energy budget, J per metre
      real(wp) :: start_energy, end_energy, start, force, plastic_stretch, curvature
      integer :: i, c, term

      do i = 1, size(self%bolt)
         if (.not. is_active(self, i)) cycle
         term = merge(energy_yield, energy_support, is_ruptured(self, i))
         do c = axial, component_count(self, i)
            start = present_stretch(self, i, c, blocks)
            start_energy = component_energy(self, i, c, start)
            force = component_force(self, i, c, self%stretch(c, i))
            end_energy = 0.5_wp*force**2/self%bolt(i)%stiffness(c)
            plastic_stretch = force*plastic_increment(self, i, c)
            call add_energy(energy, energy_yield, plastic_stretch)
            call add_energy(energy, energy_algorithmic, start_energy + force*(self%stretch(c, i) &
               - start) - end_energy - plastic_stretch)
            call add_energy(energy, term, end_energy)
         end do
         curvature = curvature_energy(self, i, blocks, d)
         call add_energy(energy, term, curvature)
         call add_energy(energy, energy_algorithmic, curvature)
      end do
   end subroutine add_to_budget

   !> Return the plastic stretch of a component in the step, m.
   pure real(wp) function plastic_increment(self, i, c) result(increment)
      class(bolts_type), intent(in) :: self  !< elements of this kind
      integer, intent(in) :: i, c  !< number of the element; component

      increment = 0.0_wp
      if (self%component_state(c, i) == yielding) increment = self%stretch(c, i) &
         - self%zero_stretch(c, i) &
         - component_force(self, i, c, self%stretch(c, i))/self%bolt(i)%stiffness(c)
   end function plastic_increment

   !> .true. if the converged step stretches bolt i beyond its rupture.
   pure logical function is_ruptured(self, i)
      class(bolts_type), intent(in) :: self  !< elements of this kind
      integer, intent(in) :: i  !< number of the element

      is_ruptured = self%stretch(axial, i) - self%first_stretch(axial, &
         i) > self%bolt(i)%rupture(axial) .or. abs(self%stretch(across, i) &
            - self%first_stretch(across, i)) > self%bolt(i)%rupture(across)
   end function is_ruptured

   !> Revise stretches and modes for the converged increment d, and count changed modes.
   subroutine revise_states(self, blocks, step, d, changed)
      class(bolts_type), intent(inout) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks  !< blocks at the start of the step
      type(step_type), intent(in) :: step           !< the present step
      real(wp), intent(in) :: d(:,:)  !< [6,blocks] increments of the coordinates
      integer, intent(inout) :: changed  !< number of components with another mode
      real(wp) :: row(6, max_points)
      integer :: i, c, k, component_state

      do i = 1, size(self%bolt)
         if (.not. is_active(self, i)) cycle
         do c = axial, component_count(self, i)
            call find_stretch_gradient(self, i, c, blocks, row)
            self%stretch(c, i) = present_stretch(self, i, c, blocks)
            do k = 1, point_count(self, i)
               self%stretch(c, i) = self%stretch(c, i) + dot_product(row(:, k), &
                  d(:, self%bolt(i)%block(k)))
            end do
            component_state = component_mode(self, i, c, self%stretch(c, i))
            if (component_state /= self%component_state(c, i)) changed = changed + 1
            self%component_state(c, i) = component_state
         end do
      end do
   end subroutine revise_states

   !> Accept the step: update plastic stretches, and deactivate broken bolts.
   subroutine accept_step(self, blocks, step, d)
      class(bolts_type), intent(inout) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks  !< blocks at the start of the step
      type(step_type), intent(in) :: step  !< the present step
      real(wp), intent(in) :: d(:,:)  !< [6,blocks] increments of the coordinates
      integer :: i, c

      do i = 1, size(self%bolt)
         if (.not. is_active(self, i)) cycle
         do c = axial, component_count(self, i)
            self%force(c, i) = component_force(self, i, c, self%stretch(c, i))
            self%zero_stretch(c, i) = self%zero_stretch(c, i) + plastic_increment(self, i, c)
         end do
         if (.not. is_ruptured(self, i)) cycle
         self%component_state(:, i) = broken
         self%force(:, i) = 0.0_wp
      end do
   end subroutine accept_step

   !> Inherit the states of former bolts that are not removed.
   subroutine inherit_state(self, former, blocks)
      class(bolts_type), intent(inout) :: self  !< elements of this kind
      class(element_type), intent(in) :: former  !< former element, of the same type
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      integer :: i

      select type (former)
      type is (bolts_type)
         do i = 1, size(self%bolt)
            if (.not. former%installed(i)) cycle
            self%installed(i) = .true.
            self%component_state(:, i) = former%component_state(:, i)
            self%zero_stretch(:, i) = former%zero_stretch(:, i)
            self%first_stretch(:, i) = former%first_stretch(:, i)
            self%stretch(:, i) = former%stretch(:, i)
            self%force(:, i) = former%force(:, i)
            if (self%bolt(i)%present) cycle
            self%component_state(:, i) = absent
            self%force(:, i) = 0.0_wp
         end do
      end select
   end subroutine inherit_state

   !> Save or restore modes, stretches and forces.
   subroutine serialise(self, archive)
      class(bolts_type), intent(inout) :: self  !< elements of this kind
      type(archive_type), intent(inout) :: archive  !< archive that is written or read
      real(wp) :: flags(3, size(self%bolt))

      flags(:2, :) = self%component_state
      flags(3, :) = merge(1.0_wp, 0.0_wp, self%installed)
      call archive_values(archive, flags)
      self%component_state = nint(flags(:2, :))
      self%installed = flags(3, :) > 0.5_wp
      call archive_values(archive, self%zero_stretch)
      call archive_values(archive, self%first_stretch)
      call archive_values(archive, self%stretch)
      call archive_values(archive, self%force)
   end subroutine serialise

   !> Return the values of each bolt in the output: forces, stretch since installation, state.
   pure function columns(self) result(values)
      class(bolts_type), intent(in) :: self  !< elements of this kind
      real(wp) :: values(bolt_columns, size(self%bolt))  !< N/m, N/m, m, 0 … 4

      values(1:2, :) = self%force
      values(3, :) = merge(self%stretch(axial, :) - self%first_stretch(axial, :), 0.0_wp, &
         self%installed)
      values(4, :) = maxval(self%component_state, 1)
   end function columns

end module dda_bolts
