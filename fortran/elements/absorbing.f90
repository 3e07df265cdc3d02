! SPDX-License-Identifier: GPL-3.0-or-later
!> Absorbing boundaries: dashpots ρV_p along the normal and ρV_s along the edge (Lysmer and
!> Kuhlemeyer 1969).  They act on d/Δt at two Gauss points of each edge, an exact integration.
!>
!> The half-space moves with the motion u of its outcrop, twice the incoming wave
!> (Joyner and Chen 1975): a dashpot exerts c (Δu − T d)/Δt over a step.  Its loss is
!> |Δu − T d|² c/Δt; the work of the half-space is this force times Δu.
!>
!> In static stages springs fix the edges.  At the end of these stages, the reactions of the springs
!> become constant forces on the blocks, and the dashpots begin to act.  Any unbalanced
!> force is added to the reactions, because the dashpots would let it move the model forever.
module dda_absorbing
   use dda_kinds, only: wp
   use dda_archive, only: archive_type, archive_values => serialise
   use dda_blocks, only: blocks_type, position_of, shape_matrix
   use dda_boundary, only: boundary_type
   use dda_element, only: element_type
   use dda_energy, only: energy_type, add_energy, energy_damping, energy_input
   use dda_fixed_points, only: fixed_points_type, new_fixed_points, reaction_of
   use dda_linear_terms, only: linear_terms_type, linear_term_type, add_term, term_boundary, &
      mean_dashpot
   use dda_motion, only: motion_type, displacement_of
   use dda_scheme, only: step_type, end_time
   use dda_support, only: fixed_point_type
   implicit none
   private
   public :: absorbing_type, new_absorbing_boundaries

   !> Gauss points of all absorbing boundaries.
   type, extends(element_type) :: absorbing_type
      !> [points] positions, and supports in statics
      type(fixed_point_type), allocatable :: point(:)
      real(wp), allocatable :: axes(:,:,:)             !< [2,2,points] normal and edge, in columns
      real(wp), allocatable :: dashpot(:,:)  !< [2,points] dashpots along these axes, N s/m per m
      integer, allocatable :: motion(:,:)  !< [2,points] motions of the half-space; 0: none
      real(wp), allocatable :: factor(:)               !< [points] factor of the motion
      integer, allocatable :: block(:)  !< [any] blocks with points, without repetition
      real(wp), allocatable :: reaction(:,:)  !< [6,any] constant force on each block, N/m …
      real(wp) :: stiffness = 0.0_wp                   !< stiffness of a static support, N/m per m
      integer :: kind = term_boundary                  !< kind of the terms
      type(fixed_points_type), allocatable :: support  !< supports in static stages
   contains
      procedure :: add_linear_terms, add_force, add_stored_energy, add_to_budget, &
         freeze_for_statics, inherit_state, balance_reactions, serialise, motion_increment
   end type absorbing_type

contains

   !> Create the Gauss points of boundaries, without reactions.
   pure function new_absorbing_boundaries(boundaries, motions, stiffness) result(self)
      type(boundary_type), intent(in) :: boundaries(:)  !< boundaries of the model
      type(motion_type), intent(in) :: motions(:)       !< motions of the model
      real(wp), intent(in) :: stiffness  !< stiffness of a support in static stages, N/m per m
      type(absorbing_type) :: self
      integer :: n, i, g, at

      n = sum([(size(boundaries(i)%point), i=1, size(boundaries))])
      self%motions = motions
      self%stiffness = stiffness
      allocate (self%point(n), self%axes(2, 2, n), self%dashpot(2, n), self%motion(2, n), &
         self%factor(n))
      at = 0
      do i = 1, size(boundaries)
         do g = 1, size(boundaries(i)%point)
            at = at + 1
            associate (normal => boundaries(i)%normal(:, (g + 1)/2))
               self%axes(:, :, at) = reshape([normal(1), normal(2), -normal(2), normal(1)], [2, 2])
            end associate
            self%point(at) = boundaries(i)%point(g)
            self%dashpot(:, at) = boundaries(i)%dashpot(:, (g + 1)/2)
            self%motion(:, at) = boundaries(i)%motion
            self%factor(at) = boundaries(i)%factor
         end do
      end do
      self%block = pack(self%point%block, [(all(self%point(:i - 1)%block /= self%point(i)%block), &
         i=1, n)])
      allocate (self%reaction(6, size(self%block)), source=0.0_wp)
   end function new_absorbing_boundaries

   !> Return the rows of a point's displacement along the normal and the edge; 0 for a removed
   !> block.
   pure function displacement_rows(self, i, blocks) result(t)
      class(absorbing_type), intent(in) :: self  !< elements of this kind
      integer, intent(in) :: i                   !< number of the point
      type(blocks_type), intent(in) :: blocks    !< blocks in their present state
      real(wp) :: t(2, 6)

      t = 0.0_wp
      associate (b => self%point(i)%block)
         if (.not. blocks%removed(b)) t = matmul(transpose(self%axes(:, :, i)), &
            shape_matrix(blocks, b, self%point(i)%reference))
      end associate
   end function displacement_rows

   !> Return the displacement Δu of the outcrop over a step along the normal and along the edge, m.
   pure function motion_increment(self, i, step) result(increment)
      class(absorbing_type), intent(in) :: self    !< elements of this kind
      integer, intent(in) :: i                     !< number of the point
      type(step_type), intent(in) :: step          !< the present step
      real(wp) :: increment(2)

      increment = self%factor(i)*(displacement_of(self%motions, self%motion(:, i), end_time(step)) &
         - displacement_of(self%motions, self%motion(:, i), step%time))
      increment = matmul(increment, self%axes(:, :, i))
   end function motion_increment

   !> Add two dashpots for each point, or springs in statics.
   subroutine add_linear_terms(self, blocks, step, terms)
      class(absorbing_type), intent(in) :: self        !< elements of this kind
      type(blocks_type), intent(in) :: blocks          !< blocks in their present state
      type(step_type), intent(in) :: step              !< the present step
      type(linear_terms_type), intent(inout) :: terms  !< springs and dashpots
      type(linear_term_type) :: term
      real(wp) :: t(2, 6)
      integer :: i, axis

      if (allocated(self%support)) then
         call self%support%add_linear_terms(blocks, step, terms)
         return
      end if
      term%kind = self%kind
      term%instant = mean_dashpot
      do i = 1, size(self%point)
         t = displacement_rows(self, i, blocks)
         term%source = i
         term%block_a = self%point(i)%block
         term%position = position_of(blocks, term%block_a, self%point(i)%reference)
         term%motion = self%motion(:, i)
         do axis = 1, 2
            term%row_a = t(axis, :)
            term%coefficient = self%dashpot(axis, i)
            call add_term(terms, term)
         end do
      end do
   end subroutine add_linear_terms

   !> Add the constant reactions of statics and the dashpot forces c Δu/Δt.
   subroutine add_force(self, blocks, step, load)
      class(absorbing_type), intent(in) :: self    !< elements of this kind
      type(blocks_type), intent(in) :: blocks      !< blocks in their present state
      type(step_type), intent(in) :: step          !< the present step
      real(wp), intent(inout) :: load(:,:)         !< [6,blocks] forces, N/m …
      real(wp) :: force(2)
      integer :: i, b

      do i = 1, size(self%block)
         b = self%block(i)
         if (.not. blocks%removed(b)) load(:, b) = load(:, b) + self%reaction(:, i)
      end do
      if (allocated(self%support)) then
         call self%support%add_force(blocks, step, load)
         return
      end if
      do i = 1, size(self%point)
         force = self%dashpot(:, i)*self%motion_increment(i, step)/step%time_step
         if (.not. any(abs(force) > 0.0_wp)) cycle
         b = self%point(i)%block
         load(:, b) = load(:, b) + matmul(force, displacement_rows(self, i, blocks))
      end do
   end subroutine add_force

   !> Add the energy of the springs of static stages.
   subroutine add_stored_energy(self, blocks, step, energy)
      class(absorbing_type), intent(in) :: self    !< elements of this kind
      type(blocks_type), intent(in) :: blocks      !< blocks in their present state
      type(step_type), intent(in) :: step          !< the next step
      type(energy_type), intent(inout) :: energy   !< energy budget, J per metre

      if (allocated(self%support)) call self%support%add_stored_energy(blocks, step, energy)
   end subroutine add_stored_energy

   !> Add the work of the reactions and of the half-space, and the loss of the dashpots.
   subroutine add_to_budget(self, blocks, step, d, energy)
      class(absorbing_type), intent(in) :: self    !< elements of this kind
      type(blocks_type), intent(in) :: blocks      !< blocks in their present state
      type(step_type), intent(in) :: step          !< the present step
      real(wp), intent(in) :: d(:,:)               !< [6,blocks] increments of the coordinates
      type(energy_type), intent(inout) :: energy   !< energy budget, J per metre
      real(wp) :: displacement(2), increment(2), force(2)
      integer :: i, b

      do i = 1, size(self%block)
         b = self%block(i)
         if (.not. blocks%removed(b)) call add_energy(energy, energy_input, &
            dot_product(self%reaction(:, i), d(:, b)))
      end do
      if (allocated(self%support)) then
         call self%support%add_to_budget(blocks, step, d, energy)
         return
      end if
      do i = 1, size(self%point)
         if (blocks%removed(self%point(i)%block)) cycle
         displacement = matmul(displacement_rows(self, i, blocks), d(:, self%point(i)%block))
         increment = self%motion_increment(i, step)
         force = self%dashpot(:, i)*(increment - displacement)/step%time_step
         call add_energy(energy, energy_input, dot_product(force, increment))
         call add_energy(energy, energy_damping, dot_product(force, increment - displacement))
      end do
   end subroutine add_to_budget

   !> Fix the points at their present positions by springs in static stages.
   subroutine freeze_for_statics(self, blocks, time)
      class(absorbing_type), intent(inout) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks       !< blocks in their present state
      real(wp), intent(in) :: time                  !< time, s
      type(fixed_point_type) :: fixed(size(self%point))
      integer :: i

      fixed = self%point
      do i = 1, size(fixed)
         fixed(i)%position = position_of(blocks, fixed(i)%block, fixed(i)%reference)
         fixed(i)%fixed_along = fixed(i)%fixed_along .and. .not. blocks%removed(fixed(i)%block)
      end do
      self%support = new_fixed_points(fixed, self%motions, self%stiffness, time)
   end subroutine freeze_for_statics

   !> Inherit the reactions of the former element, and add the reactions of its static springs.
   subroutine inherit_state(self, former, blocks)
      class(absorbing_type), intent(inout) :: self  !< elements of this kind
      class(element_type), intent(in) :: former     !< former element, of the same type
      type(blocks_type), intent(in) :: blocks       !< blocks in their present state
      integer :: i, k

      select type (former)
      class is (absorbing_type)
         self%reaction = former%reaction
         if (.not. allocated(former%support)) return
         do i = 1, size(self%point)
            k = findloc(self%block, self%point(i)%block, 1)
            self%reaction(:, k) = self%reaction(:, k) + reaction_of(former%support, i, blocks)
         end do
      end select
   end subroutine inherit_state

   !> Add the unbalanced forces of the blocks to the reactions, so that all forces sum to zero.
   subroutine balance_reactions(self, blocks, unbalanced)
      class(absorbing_type), intent(inout) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks       !< blocks in static equilibrium
      real(wp), intent(in) :: unbalanced(:,:)       !< [6,blocks] sum of all forces, N/m …
      real(wp) :: total(3)
      integer :: i, b

      total = 0.0_wp
      do b = 1, blocks%n
         if (blocks%removed(b) .or. any(self%block == b)) cycle
         associate (centre => blocks%position(1:2, b), force => unbalanced(1:3, b))
            total = total + [force(1), force(2), force(3) + centre(1)*force(2) - centre(2)*force(1)]
         end associate
      end do
      do i = 1, size(self%block)
         b = self%block(i)
         self%reaction(:, i) = self%reaction(:, i) - unbalanced(:, b)
      end do
      total = total/size(self%block)
      do i = 1, size(self%block)
         associate (centre => blocks%position(1:2, self%block(i)))
            self%reaction(1:3, i) = self%reaction(1:3, i) - [total(1), total(2), total(3) &
               - (centre(1)*total(2) - centre(2)*total(1))]
         end associate
      end do
   end subroutine balance_reactions

   !> Save or restore the reactions.
   subroutine serialise(self, archive)
      class(absorbing_type), intent(inout) :: self   !< elements of this kind
      type(archive_type), intent(inout) :: archive   !< archive that is written or read

      call archive_values(archive, self%reaction)
   end subroutine serialise

end module dda_absorbing
