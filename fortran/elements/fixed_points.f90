! SPDX-License-Identifier: GPL-3.0-or-later
!> Fixed points: material points tied to a prescribed motion by a spring and a dashpot at the end of
!> the step (`dda_spring_element`).
module dda_fixed_points
   use dda_kinds, only: wp
   use dda_archive, only: archive_type, archive_values => serialise
   use dda_blocks, only: blocks_type, mass_matrix, shape_matrix
   use dda_linear_terms, only: at_end, at_theta, term_bed
   use dda_motion, only: motion_type, displacement_of, velocity_of
   use dda_scheme, only: step_type
   use dda_small_matrix, only: invert_matrix
   use dda_spring_element, only: spring_element_type, spring_type, ground_type, dashpots_of, &
      find_ground, target_rate
   use dda_support, only: fixed_point_type
   implicit none
   private
   public :: fixed_points_type, new_fixed_points, new_spring_beds, reaction_of

   real(wp), parameter :: stiffest = 1.0e10_wp  !< largest stiffness/mass in K̂; leaves 6 digits

   !> All fixed points of a model.
   type, extends(spring_element_type) :: fixed_points_type
      ! unsaved, the input: point
      type(fixed_point_type), allocatable :: point(:)
      real(wp), allocatable :: rate(:,:)      !< [2,points] velocity of the motions, m/s
   contains
      procedure :: get_spring, accept_step, match_velocity, freeze_for_statics, serialise
   end type fixed_points_type

contains

   !> Create fixed points that act from a given time on.
   pure type(fixed_points_type) function new_fixed_points(points, motions, stiffness, &
      time) result(self)
      type(fixed_point_type), intent(in) :: points(:)  !< [points]
      type(motion_type), intent(in) :: motions(:)  !< prescribed motions
      real(wp), intent(in) :: stiffness  !< default stiffness, N/m per metre
      real(wp), intent(in) :: time       !< time from which they act, s
      integer :: i

      allocate (self%point, source=points)
      self%n = size(points)
      self%instant = at_end
      self%motions = motions
      where (self%point%stiffness <= 0.0_wp) self%point%stiffness = stiffness
      allocate (self%rate(2, size(points)))
      do i = 1, size(points)
         self%rate(:, i) = velocity_of(motions, points(i)%motion, time)
      end do
   end function new_fixed_points

   !> Create a bed of springs [Winkler, 1867], which act in compression and tension at t₀ + θΔt.
   pure type(fixed_points_type) function new_spring_beds(points, motions, time) result(self)
      type(fixed_point_type), intent(in) :: points(:)  !< [points] points with their stiffness
      type(motion_type), intent(in) :: motions(:)      !< prescribed motions
      real(wp), intent(in) :: time                     !< time from which they act, s

      self = new_fixed_points(points, motions, 0.0_wp, time)
      self%kind = term_bed
      self%instant = at_theta
      self%of_penalty = .false.
   end function new_spring_beds

   !> Set the springs along the fixed directions of point i.
   pure subroutine get_spring(self, i, blocks, spring)
      class(fixed_points_type), intent(in) :: self  !< elements of this kind
      integer, intent(in) :: i                 !< number of the element
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(spring_type), intent(out) :: spring !< springs to the ground
      real(wp) :: shape(2, 6), offset(2)

      associate (point => self%point(i), axes => self%point(i)%axes)
         spring%block(1) = point%block
         spring%stiffness = merge(point%stiffness, 0.0_wp, point%fixed_along)
         shape = shape_matrix(blocks, point%block, point%reference)
         spring%position = blocks%position(1:2, point%block) + [shape(2, 3), -shape(1, 3)]
         offset = spring%position - point%position
         spring%stretch = [dot_product(offset, axes(:, 1)), dot_product(offset, axes(:, 2))]
         spring%row(:, 1, 1) = axes(1, 1)*shape(1, :) + axes(2, 1)*shape(2, :)
         spring%row(:, 2, 1) = axes(1, 2)*shape(1, :) + axes(2, 2)*shape(2, :)
         spring%motion = point%motion
         spring%rate = self%rate(:, i)
      end associate
   end subroutine get_spring

   !> Return the forces of the spring of point i on its block, N/m …, without the support motion.
   pure function reaction_of(self, i, blocks) result(force)
      type(fixed_points_type), intent(in) :: self  !< all points
      integer, intent(in) :: i  !< number of the element
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      real(wp) :: force(6)
      type(spring_type) :: spring

      call self%get_spring(i, blocks, spring)
      force = -matmul(spring%row(:, :, 1), spring%stiffness*spring%stretch)
   end function reaction_of

   !> Accept the step: store the velocities of the motions for the start of the next step.
   subroutine accept_step(self, blocks, step, d)
      class(fixed_points_type), intent(inout) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks  !< blocks at the start of the step
      type(step_type), intent(in) :: step  !< the present step
      real(wp), intent(in) :: d(:,:)  !< [6,blocks] increments of the coordinates
      type(ground_type) :: ground
      integer :: i

      do i = 1, size(self%point)
         call find_ground(ground, self%point(i)%motion, self%motions, step)
         self%rate(:, i) = target_rate(ground, self%rate(:, i), step)
      end do
   end subroutine accept_step

   !> Match velocities to stiff supports, so that a velocity jump stores no energy in them.
   !> Minimise ½ (v − v₀)ᵀM(v − v₀) + ½ (1 − χ) c Δt Σ [w + y/((1 − χ)Δt)]².
   subroutine match_velocity(self, blocks, step, velocity)
      class(fixed_points_type), intent(in) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(step_type), intent(in) :: step  !< the present step
      real(wp), intent(inout) :: velocity(:,:)  !< [6,blocks] velocities, 1/s …
      type(spring_type) :: spring
      real(wp) :: target(2, size(self%point))
      integer :: i
      logical :: matched(size(self%point))

      if (step%scheme%chi >= 1.0_wp .or. self%instant /= at_end) return
      do i = 1, size(self%point)
         call self%get_spring(i, blocks, spring)
         target(:, i) = self%rate(:, i) - (spring%stretch - displacement_of(self%motions, &
            spring%motion, step%time))/((1.0_wp - step%scheme%chi)*step%time_step)
      end do
      matched = .false.
      do i = 1, size(self%point)
         if (matched(i)) cycle
         call match_block(self, blocks, step, self%point(i)%block, target, velocity)
         matched = matched .or. self%point%block == self%point(i)%block
      end do
   end subroutine match_velocity

   !> Match the velocity of block b.
   pure subroutine match_block(self, blocks, step, b, target, velocity)
      class(fixed_points_type), intent(in) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(step_type), intent(in) :: step  !< the present step
      integer, intent(in) :: b  !< number of the block
      real(wp), intent(in) :: target(:,:)  !< [2,points] m/s
      real(wp), intent(inout) :: velocity(:,:)  !< [6,blocks] velocities, 1/s …
      type(spring_type) :: spring
      real(wp) :: matrix(6, 6), inverse(6, 6), impulse(6), weight(2)
      integer :: i, axis, column

      matrix = mass_matrix(blocks%inertia(:, b))
      impulse = matmul(matrix, velocity(:, b))
      do i = 1, size(self%point)
         if (self%point(i)%block /= b) cycle
         call self%get_spring(i, blocks, spring)
         weight = min(stiffest*blocks%mass(b), &
            (1.0_wp - step%scheme%chi)*dashpots_of(self, spring, step)*step%time_step)
         do axis = 1, 2
            associate (row => spring%row(:, axis, 1), w => weight(axis))
               impulse = impulse + w*target(axis, i)*row
               do column = 1, 6
                  matrix(:, column) = matrix(:, column) + w*row(column)*row
               end do
            end associate
         end do
      end do
      call invert_matrix(matrix, inverse)
      velocity(:, b) = matmul(inverse, impulse)
   end subroutine match_block

   !> Freeze the prescribed positions at their values at a time.
   subroutine freeze_for_statics(self, blocks, time)
      class(fixed_points_type), intent(inout) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      real(wp), intent(in) :: time  !< time, s
      integer :: i

      do i = 1, size(self%point)
         self%point(i)%position = self%point(i)%position &
            + displacement_of(self%motions, self%point(i)%motion, time)
         self%point(i)%motion = 0
      end do
      self%rate = 0.0_wp
   end subroutine freeze_for_statics

   !> Save or restore the velocities of the motions.
   subroutine serialise(self, archive)
      class(fixed_points_type), intent(inout) :: self  !< elements of this kind
      type(archive_type), intent(inout) :: archive  !< archive that is written or read

      call archive_values(archive, self%rate)
   end subroutine serialise

end module dda_fixed_points
