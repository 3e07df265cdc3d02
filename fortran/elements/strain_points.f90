! SPDX-License-Identifier: GPL-3.0-or-later
!> Contributions of material laws at their points (`dda_material_points`) to the equations of a
!> step.
!>
!> A step is solved by Newton's method: the additional stress c is linearised at an increment, then
!> at each solution, until c at the solution equals its linearised value.  c is the derivative of
!> the potential of the law minus the elastic potential.  If the law is convex, a step minimises a
!> convex function, and `slope_beyond` makes its line search exact.
!>
!> Frozen bounds of a law are updated from the stress of the last solution until they agree with it,
!> or until `max_updates` rounds.  Their error is then their change in the last round.
module dda_strain_points
   use dda_kinds, only: wp
   use dda_archive, only: archive_type, archive_values => serialise
   use dda_blocks, only: blocks_type
   use dda_crack_law, only: crack_law_type
   use dda_element, only: element_type
   use dda_energy, only: energy_type, add_energy, energy_algorithmic, energy_fracture, &
      energy_friction, energy_law, energy_material_damping, energy_plastic
   use dda_linear_terms, only: linear_term_type, linear_terms_type, add_term, at_damping, term_point
   use dda_material, only: material_type
   use dda_material_law, only: loss_damping, loss_plastic, loss_scheme, losses
   use dda_material_points, only: material_points_type, set_points, has_law, acts, is_inactive, &
      respond, jump_limit, total_strain, present_stress, shape_stress, beyond_elastic, &
      advance_point, copy_point_state
   use dda_ordered_sums, only: parallel_from
   use dda_scheme, only: step_type
   use dda_weld, only: weld_type, is_shifted
   use dda_weld_springs, only: n_deformations, cell_strain
   use dda_welds, only: derivatives_of
   implicit none
   private
   public :: strain_points_type, new_strain_points, add_point_stress, max_updates

   real(wp), parameter :: tolerance = 1.0e-11_wp     !< relative tolerance of a stress
   real(wp), parameter :: rounding = 1.0e-15_wp      !< rounding error/elastic stress
   !> relative tolerance of the stress that sets bounds
   real(wp), parameter :: bound_tolerance = 1.0e-7_wp
   real(wp), parameter :: damage_tolerance = 1.0e-4_wp  !< damage tolerance of broken faces
   integer, parameter :: max_updates = 15  !< largest number of updates of the frozen bounds
   real(wp), parameter :: zero_tangent = 1.0e-13_wp  !< tangent/D below which a tangent counts as 0

   !> Equations of all points in a step.
   type, extends(material_points_type) :: strain_points_type
      real(wp), allocatable :: operator(:,:,:,:)  !< [3,6,2,n] derivatives of Δε by d of both blocks
      real(wp), allocatable :: change(:,:)               !< [3,n] Δε at which c is linearised
      real(wp), allocatable :: stress(:,:)               !< [3,n] c at this Δε, Pa
      real(wp), allocatable :: tangent(:,:,:)            !< [3,3,n] ∂c/∂Δε at this Δε, Pa
      integer :: round = 0                               !< number of solutions so far
      integer :: unconverged = 0  !< point with the largest error; 0: all converged
   contains
      procedure :: prepare_step, add_linear_terms, add_force, slope_beyond, revise_states, &
         add_stored_energy, add_to_budget, accept_step, inherit_state, freeze_for_statics, &
         serialise, add_face_force
   end type strain_points_type

contains

   !> Create the points of a model.
   type(strain_points_type) function new_strain_points(welds, blocks, materials, cracks, &
      plane_strain) result(self)
      type(weld_type), intent(in) :: welds(:)          !< welds of the model
      type(blocks_type), intent(in) :: blocks          !< blocks in their present state
      type(material_type), intent(in) :: materials(:)  !< materials of the model
      type(crack_law_type), intent(in) :: cracks(:)    !< [joints] cracks of faces that break
      logical, intent(in) :: plane_strain              !< plane strain; .false.: plane stress

      call set_points(self, welds, blocks, materials, cracks, plane_strain)
      allocate (self%operator(3, 6, 2, self%n), self%change(3, self%n), self%stress(3, self%n), &
         self%tangent(3, 3, self%n), source=0.0_wp)
      where (self%crack > 0) self%tangent(1, 1, :) = 1.0_wp  ! couples both cells in the pattern
   end function new_strain_points

   !> Prepare a step: set the strains at its start, and linearise the stress c at an increment.
   subroutine prepare_step(self, blocks, step, d)
      class(strain_points_type), intent(inout) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks           !< blocks at the start of the step
      type(step_type), intent(in) :: step               !< the present step
      real(wp), intent(in) :: d(:,:)                    !< [6,blocks] increments of the coordinates
      integer :: p

      self%round = 0
      !$omp parallel do schedule(static) if (self%n >= parallel_from)
      do p = 1, self%n
         if (acts(self, p, blocks)) &
            self%strain(:, p) = total_strain(self, p, blocks) - self%reference(:, p)
      end do
      !$omp parallel do schedule(static) if (self%n >= parallel_from)
      do p = 1, self%n
         if (.not. acts(self, p, blocks)) cycle
         if (self%side_points(1, p) > 0) self%point(p)%cap = jump_limit(self, p)
         call freeze_bounds(self, p, [0.0_wp, 0.0_wp, 0.0_wp], step, 0.0_wp)
         call set_strain_operator(self, p, blocks, step)
         self%change(:, p) = strain_increment(self, p, d)
         call respond(self, p, self%strain(:, p), self%change(:, p), step, self%stress(:, p), &
            self%tangent(:, :, p))
      end do
   end subroutine prepare_step

   !> Freeze the bounds of point p at the stress for a strain increment, unless they agree with it.
   subroutine freeze_bounds(self, p, change, step, tolerance)
      class(strain_points_type), intent(inout) :: self  !< elements of this kind
      integer, intent(in) :: p                          !< number of the point
      real(wp), intent(in) :: change(3)                 !< Δε
      type(step_type), intent(in) :: step               !< the present step
      real(wp), intent(in) :: tolerance                   !< allowed error of bounds, Pa
      real(wp) :: stress(3)

      if (is_inactive(self, p)) return
      if (.not. has_law(self, self%material(p))) return
      stress = self%slot(self%material(p))%law%frozen_stress(self%point(p), self%state(:, p), &
         self%strain(:, p), change, step)
      if (any(abs(stress - self%point(p)%bounding) > tolerance)) self%point(p)%bounding = stress
   end subroutine freeze_bounds

   !> Set the operator that maps increments of blocks to Δε of point p.
   subroutine set_strain_operator(self, p, blocks, step)
      class(strain_points_type), intent(inout) :: self  !< elements of this kind
      integer, intent(in) :: p                          !< number of the point
      type(blocks_type), intent(in) :: blocks           !< blocks at the start of the step
      type(step_type), intent(in) :: step               !< the present step
      real(wp) :: g(n_deformations, 6, 2)
      integer :: i, k

      if (self%block(2, p) == 0) then
         self%operator(:, :, :, p) = 0.0_wp
         do i = 1, 3
            self%operator(i, 3 + i, 1, p) = 1.0_wp
         end do
         return
      end if
      g = derivatives_of(self%face(p), blocks, step)
      do k = 1, 2
         self%operator(:, :, k, p) = matmul(self%map(:, :, p), g(:, :, k))
      end do
   end subroutine set_strain_operator

   !> Return the strain increment Δε of point p.
   pure function strain_increment(self, p, d) result(change)
      class(strain_points_type), intent(in) :: self  !< prepared for the step
      integer, intent(in) :: p                       !< number of the point
      real(wp), intent(in) :: d(:,:)                 !< [6,blocks] increments of the coordinates
      real(wp) :: change(3)

      change = matmul(self%operator(:, :, 1, p), d(:, self%block(1, p)))
      if (self%block(2, p) > 0) change = change + matmul(self%operator(:, :, 2, p), &
         d(:, self%block(2, p)))
   end function strain_increment

   !> Append the tangents of all points, A T = Σ c u uᵀ.
   subroutine add_linear_terms(self, blocks, step, terms)
      class(strain_points_type), intent(in) :: self    !< elements of this kind
      type(blocks_type), intent(in) :: blocks          !< blocks in their present state
      type(step_type), intent(in) :: step              !< the present step
      type(linear_terms_type), intent(inout) :: terms  !< springs and dashpots
      type(linear_term_type) :: term
      real(wp) :: factor(3), direction(3, 3)
      integer :: p, i, n

      term%kind = term_point
      term%instant = at_damping
      do p = 1, self%n
         if (.not. acts(self, p, blocks)) cycle
         call split_dyads(self%tangent(:, :, p), zero_tangent*self%point(p)%elasticity(1, 1), n, &
            factor, direction)
         term%source = p
         term%block_a = self%block(1, p)
         term%position = blocks%position(1:2, term%block_a)
         do i = 1, n
            term%coefficient = self%area(p)*factor(i)
            term%block_b = self%block(2, p)
            term%row_a = matmul(direction(:, i), self%operator(:, :, 1, p))
            if (term%block_b > 0) term%row_b = -matmul(direction(:, i), self%operator(:, :, 2, p))
            if (term%block_b == term%block_a) term%row_a = term%row_a - term%row_b
            if (term%block_b == term%block_a) term%block_b = 0  ! image of the same block
            call add_term(terms, term)
         end do
      end do
   end subroutine add_linear_terms

   !> Split a symmetric matrix into Σ f u uᵀ, with the largest diagonal entry first.
   pure subroutine split_dyads(matrix, none, n, factor, direction)
      real(wp), intent(in) :: matrix(3, 3)             !< symmetric matrix
      real(wp), intent(in) :: none                     !< limit below which diagonal values are zero
      integer, intent(out) :: n                        !< terms
      real(wp), intent(out) :: factor(3), direction(3, 3)
      real(wp) :: inactive_strain(3, 3)
      integer :: i, j

      inactive_strain = 0.5_wp*(matrix + transpose(matrix))
      do n = 0, 2
         i = maxloc(abs([inactive_strain(1, 1), inactive_strain(2, 2), inactive_strain(3, 3)]), 1)
         if (abs(inactive_strain(i, i)) <= none) return
         factor(n + 1) = inactive_strain(i, i)
         direction(:, n + 1) = inactive_strain(:, i)/inactive_strain(i, i)
         do j = 1, 3
            inactive_strain(:, j) = inactive_strain(:, j) - factor(n + 1)*direction(j, n &
               + 1)*direction(:, n + 1)
         end do
      end do
   end subroutine split_dyads

   !> Add the forces −A Bᵀ(c − T Δε) of each point.
   subroutine add_force(self, blocks, step, load)
      class(strain_points_type), intent(in) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks        !< blocks in their present state
      type(step_type), intent(in) :: step            !< the present step
      real(wp), intent(inout) :: load(:,:)           !< [6,blocks] forces, N/m …
      real(wp) :: force(3)
      integer :: p, k, b

      do p = 1, self%n
         if (.not. acts(self, p, blocks)) cycle
         force = self%area(p)*(self%stress(:, p) - matmul(self%tangent(:, :, p), self%change(:, p)))
         do k = 1, 2
            b = self%block(k, p)
            if (b > 0) load(:, b) = load(:, b) - matmul(force, self%operator(:, :, k, p))
         end do
      end do
   end subroutine add_force

   !> Add the forces of images on the cells of one side due to c, in a step with a known d.
   subroutine add_face_force(self, side, blocks, step, d, load)
      class(strain_points_type), intent(in) :: self  !< prepared for the step
      integer, intent(in) :: side                    !< side of each face, 1 or 2
      type(blocks_type), intent(in) :: blocks        !< blocks at the start of the step
      type(step_type), intent(in) :: step            !< the present step
      real(wp), intent(in) :: d(:,:)                 !< [6,blocks] increments of the coordinates
      real(wp), intent(inout) :: load(:,:)           !< [6,blocks] forces, N/m …
      real(wp) :: stress(3), tangent(3, 3)
      integer :: p, b

      do p = 1, self%n
         if (.not. acts(self, p, blocks)) cycle
         if (self%block(2, p) == 0) cycle
         if (.not. is_shifted(self%face(p))) cycle
         call respond(self, p, self%strain(:, p), strain_increment(self, p, d), step, stress, &
            tangent)
         b = self%block(side, p)
         load(:, b) = load(:, b) - self%area(p)*matmul(stress, self%operator(:, :, side, p))
      end do
   end subroutine add_face_force

   !> Return the slope of the energy of the nonlinear part of c, on the path between two increments.
   !> Unit: J per metre of thickness.
   real(wp) function slope_beyond(self, blocks, step, from, to, fraction) result(slope)
      class(strain_points_type), intent(in) :: self  !< prepared for the step
      type(blocks_type), intent(in) :: blocks        !< blocks at the start of the step
      type(step_type), intent(in) :: step            !< the present step
      real(wp), intent(in) :: from(:,:), to(:,:)     !< [6,blocks] increments of the coordinates
      real(wp), intent(in) :: fraction               !< fraction of the path, 0 … 1
      real(wp) :: path(3), stress(3), tangent(3, 3), change(3), slopes(self%n)
      integer :: p

      !$omp parallel do schedule(static) private(path, stress, tangent, change) &
      !$omp if (self%n >= parallel_from)
      do p = 1, self%n
         slopes(p) = 0.0_wp
         if (.not. acts(self, p, blocks)) cycle
         change = strain_increment(self, p, from)
         path = strain_increment(self, p, to) - change
         change = change + fraction*path
         call respond(self, p, self%strain(:, p), change, step, stress, tangent)
         stress = stress - self%stress(:, p) - matmul(self%tangent(:, :, p), change &
            - self%change(:, p))
         slopes(p) = self%area(p)*dot_product(stress, path)
      end do
      slope = sum(slopes)
   end function slope_beyond

   !> Linearise all points at a solution if c at the solution differs from its linearised value.
   subroutine revise_states(self, blocks, step, d, changed)
      class(strain_points_type), intent(inout) :: self  !< prepared for the step
      type(blocks_type), intent(in) :: blocks           !< blocks at the start of the step
      type(step_type), intent(in) :: step               !< the present step
      real(wp), intent(in) :: d(:,:)                    !< [6,blocks] increments of the coordinates
      integer, intent(inout) :: changed                 !< number of changed states
      real(wp) :: stress(3), tangent(3, 3), change(3), deviation(self%n), scale(self%n), &
         noise(self%n)
      integer :: p

      self%round = self%round + 1
      deviation = 0.0_wp
      scale = 0.0_wp
      noise = 0.0_wp
      !$omp parallel do schedule(static) private(stress, tangent, change) &
      !$omp if (self%n >= parallel_from)
      do p = 1, self%n
         if (.not. acts(self, p, blocks)) cycle
         change = strain_increment(self, p, d)
         if (self%round <= max_updates) call freeze_bounds(self, p, change, step, &
            allowed_bound_error(self, p, change, step))
         call respond(self, p, self%strain(:, p), change, step, stress, tangent)
         associate (point => self%point(p), elastic => matmul(self%point(p)%elasticity, &
            self%strain(:, p) + step%scheme%theta*change))
            deviation(p) = point%length*norm2(stress - self%stress(:, p) &
               - matmul(self%tangent(:, :, p), change - self%change(:, p)))
            scale(p) = point%length*norm2(point%start_stress + elastic + stress)
            noise(p) = point%length*norm2(elastic)
            if (self%crack(p) > 0) noise(p) = point%length*point%cap*norm2(self%strain(:, p) &
               + change)
         end associate
         self%change(:, p) = change
         self%stress(:, p) = stress
         self%tangent(:, :, p) = tangent
      end do
      self%unconverged = 0
      if (self%n == 0) return
      if (maxval(deviation) > max(tolerance*maxval(scale), rounding*maxval(noise))) then
         self%unconverged = maxloc(deviation, 1)
         changed = changed + count(deviation > tolerance*maxval(scale))
      end if
   end subroutine revise_states

   !> Return the allowed error of the bounds of point p after a solution, Pa.
   pure real(wp) function allowed_bound_error(self, p, change, step) result(allowed)
      class(strain_points_type), intent(in) :: self  !< elements of this kind
      integer, intent(in) :: p                       !< number of the point
      real(wp), intent(in) :: change(3)              !< Δε
      type(step_type), intent(in) :: step            !< the present step

      associate (point => self%point(p), strain => self%strain(:, p))
         if (self%crack(p) > 0) then
            allowed = damage_tolerance*point%strength*min(1.0_wp, point%strength/(point%cap &
               *norm2(strain + change) + tiny(allowed)))
         else
            allowed = bound_tolerance*norm2(point%start_stress + self%stress(:, p) &
               + matmul(point%elasticity, strain + step%scheme%theta*change))
         end if
      end associate
   end function allowed_bound_error

   !> Add the energy of all points minus their elastic energy.
   subroutine add_stored_energy(self, blocks, step, energy)
      class(strain_points_type), intent(in) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks        !< blocks in their present state
      type(step_type), intent(in) :: step            !< the next step
      type(energy_type), intent(inout) :: energy     !< energy budget, J per metre
      real(wp) :: energies(self%n)
      integer :: p

      energies = 0.0_wp
      do p = 1, self%n
         if (acts(self, p, blocks)) energies(p) = self%area(p)*beyond_elastic(self, p, &
            self%state(:, p), total_strain(self, p, blocks) - self%reference(:, p))
      end do
      call add_energy(energy, energy_law, sum(energies))
   end subroutine add_stored_energy

   !> Add the energy at the end of the step, and the losses.
   subroutine add_to_budget(self, blocks, step, d, energy)
      class(strain_points_type), intent(in) :: self  !< prepared for the step
      type(blocks_type), intent(in) :: blocks        !< blocks at the start of the step
      type(step_type), intent(in) :: step            !< the present step
      real(wp), intent(in) :: d(:,:)                 !< [6,blocks] increments of the coordinates
      type(energy_type), intent(inout) :: energy     !< energy budget, J per metre
      real(wp) :: state(size(self%state, 1)), loss(losses), change(3), amounts(losses + 1, self%n)
      integer :: p

      amounts = 0.0_wp
      !$omp parallel do schedule(static) private(state, loss, change) &
      !$omp if (self%n >= parallel_from)
      do p = 1, self%n
         if (.not. acts(self, p, blocks)) cycle
         change = strain_increment(self, p, d)
         state = self%state(:, p)
         call advance_point(self, p, state, change, step, loss)
         amounts(:, p) = self%area(p)*[loss, beyond_elastic(self, p, state, self%strain(:, p) &
            + change)]
      end do
      call add_energy(energy, energy_law, sum(amounts(losses + 1, :)))
      associate (n => self%first_crack)
         call add_energy(energy, energy_plastic, sum(amounts(loss_plastic, :n)))
         call add_energy(energy, energy_material_damping, sum(amounts(loss_damping, :n)))
         call add_energy(energy, energy_fracture, sum(amounts(loss_plastic, n + 1:)))
         call add_energy(energy, energy_friction, sum(amounts(loss_damping, n + 1:)))
      end associate
      call add_energy(energy, energy_algorithmic, sum(amounts(loss_scheme, :)))
   end subroutine add_to_budget

   !> Accept the step: set the states at its end.
   subroutine accept_step(self, blocks, step, d)
      class(strain_points_type), intent(inout) :: self  !< prepared for the step
      type(blocks_type), intent(in) :: blocks           !< blocks at the start of the step
      type(step_type), intent(in) :: step               !< the present step
      real(wp), intent(in) :: d(:,:)                    !< [6,blocks] increments of the coordinates
      real(wp) :: loss(losses)
      integer :: p

      !$omp parallel do schedule(static) if (self%n >= parallel_from)
      do p = 1, self%n
         if (acts(self, p, blocks)) self%retained_stress(:, p) = self%retained_stress(:, p) &
            - shape_stress(self, p)
      end do
      !$omp parallel do schedule(static) private(loss) if (self%n >= parallel_from)
      do p = 1, self%n
         if (acts(self, p, blocks)) call advance_point(self, p, self%state(:, p), &
            strain_increment(self, p, d), step, loss)
      end do
      !$omp parallel do schedule(static) if (self%n >= parallel_from)
      do p = 1, self%n
         if (acts(self, p, blocks)) self%retained_stress(:, p) = self%retained_stress(:, p) &
            + shape_stress(self, p)
      end do
   end subroutine accept_step

   !> Deactivate laws that do not act in static stages; the inelastic part of their stress remains.
   subroutine freeze_for_statics(self, blocks, time)
      class(strain_points_type), intent(inout) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks           !< blocks in their present state
      real(wp), intent(in) :: time  !< time at which loads and prescribed positions are frozen, s
      integer :: p

      if (self%static) return
      do p = 1, self%n
         if (.not. acts(self, p, blocks)) cycle
         self%inactive_stress(:, p) = present_stress(self, p, blocks)
         self%inactive_strain(:, p) = total_strain(self, p, blocks) - self%reference(:, p)
      end do
      self%static = .true.
   end subroutine freeze_for_statics

   !> Inherit the states of the same points; an inactive law continues from its last strain.
   !> If a law is replaced, the inelastic part of its stress remains.
   subroutine inherit_state(self, former, blocks)
      class(strain_points_type), intent(inout) :: self  !< elements of this kind
      class(element_type), intent(in) :: former         !< former element, of the same type
      type(blocks_type), intent(in) :: blocks           !< blocks in their present state
      integer :: p

      select type (former)
      class is (strain_points_type)
         do p = 1, self%n
            ! a face within one material has its stress in the first of its two points
            call copy_point_state(self, p, former, merge(p - 1, p, former%area(p) <= 0.0_wp .and. &
               former%block(2, p) > 0), blocks)
         end do
      end select
   end subroutine inherit_state

   !> Save or restore the states of the points.
   subroutine serialise(self, archive)
      class(strain_points_type), intent(inout) :: self  !< elements of this kind
      type(archive_type), intent(inout) :: archive      !< archive that is written or read
      real(wp) :: stress(3, self%n), bounding(3, self%n)
      integer :: p

      do p = 1, self%n
         stress(:, p) = self%point(p)%start_stress
         bounding(:, p) = self%point(p)%bounding
      end do
      call archive_values(archive, stress)
      call archive_values(archive, bounding)
      call archive_values(archive, self%active)
      do p = 1, self%n
         self%point(p)%start_stress = stress(:, p)
         self%point(p)%bounding = bounding(:, p)
      end do
      call archive_values(archive, self%reference)
      call archive_values(archive, self%retained_stress)
      call archive_values(archive, self%state)
      call archive_values(archive, self%residual_work)
   end subroutine serialise

   !> Add the contribution of points to the mean stress of blocks, Pa, in the axes of the block.
   subroutine add_point_stress(self, blocks, stress)
      class(strain_points_type), intent(in) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks        !< blocks in their present state
      real(wp), intent(inout) :: stress(:,:)         !< [3,blocks] Pa
      real(wp) :: point_stress(3)
      integer :: p, i, k, b

      do p = 1, self%n
         if (self%side_points(1, p) > 0 .or. self%crack(p) > 0) exit  ! only strain points of cells
         if (.not. acts(self, p, blocks)) cycle
         point_stress = self%area(p)*(present_stress(self, p, blocks) - shape_stress(self, p))
         if (self%block(2, p) == 0) then
            b = self%block(1, p)
            stress(:, b) = stress(:, b) + point_stress/blocks%area(b)
            cycle
         end if
         do k = 1, 2
            b = self%block(k, p)
            do i = 1, 3
               stress(i, b) = stress(i, b) + dot_product(point_stress, &
                  self%map(:, cell_strain(i, k), p))/blocks%area(b)
            end do
         end do
      end do
   end subroutine add_point_stress

end module dda_strain_points
