! SPDX-License-Identifier: GPL-3.0-or-later
!> Fixed points: material points held to a prescribed motion by a spring and a dashpot.
!>
!> With the place y and the velocity w of the point relative to the motion, at the end of the step,
!> the support exerts −k y₁ − c w₁ with c = (1 − χ) k Δt.  Without the dashpot a velocity that the
!> spring has stopped changes its sign every step for ever (DDA: root −1 + 8/Ω²); with it both roots
!> are 1/(1 ± iΩ) in every member, those of backward Euler.
!>
!> The energy of a support is ½ k y² + ½ (1 − χ) c Δt w².  It never grows at rest: a step loses
!> ½ k Δy² by the scheme and c Δt [(2χ − 1) w₁² + ½ (1 − χ)(w₀ + w₁)²] in the dashpot.
!>
!> The velocity of a motion is the record's own where χ = ½.  Else it follows from its displacement
!> as that of a block does, v₁ = Δu/(χΔt) − (1/χ − 1) v₀: the record's own would leave the base
!> (1 − χ)(χ − ½)Ω² short of it.
module dda_fixed_points
   use dda_kinds, only: wp
   use dda_archive, only: archive_type, archive_values => serialise
   use dda_baseline, only: displacement_at, velocity_at
   use dda_blocks, only: blocks_type, mass_matrix, motion_of, place_of, shape_matrix
   use dda_element, only: element_type
   use dda_energy, only: energy_type, add_energy, energy_support, energy_algorithmic, &
      energy_damping, energy_input
   use dda_linear_terms, only: linear_terms_type, linear_term_type, add_term, term_support, &
      at_end, end_dashpot
   use dda_motion, only: motion_type
   use dda_scheme, only: step_type, end_time, end_rate, velocity_weight
   use dda_small_matrix, only: invert
   use dda_support, only: fixed_point_type
   implicit none
   private
   public :: fixed_points_type, new_fixed_points, reaction_of

   !> All fixed points of a model.
   type, extends(element_type) :: fixed_points_type
      type(fixed_point_type), allocatable :: point(:)
      real(wp) :: stiffness = 0.0_wp          !< k of each, N/m per metre of thickness
      real(wp), allocatable :: rate(:,:)      !< [2,points] velocity of their motions, m/s
   contains
      procedure :: add_linear
      procedure :: add_force
      procedure :: add_stored
      procedure :: account
      procedure :: accept
      procedure :: match_velocity
      procedure :: freeze
      procedure :: serialise
   end type fixed_points_type

contains

   !> Fixed points from a time on.
   pure type(fixed_points_type) function new_fixed_points(points, motions, stiffness, &
      time) result(self)
      type(fixed_point_type), intent(in) :: points(:)  !< [points]
      type(motion_type), intent(in) :: motions(:)  !< prescribed ones
      real(wp), intent(in) :: stiffness  !< of each, N/m per metre of thickness
      real(wp), intent(in) :: time       !< s
      integer :: i, axis

      allocate (self%point, source=points)
      self%stiffness = stiffness
      allocate (self%rate(2, size(points)), source=0.0_wp)
      do i = 1, size(points)
         do axis = 1, 2
            if (points(i)%motion(axis) > 0) self%rate(axis, i) = &
               velocity_at(motions(points(i)%motion(axis))%curve, time)
         end do
      end do
   end function new_fixed_points

   !> c, N s/m per metre of thickness.
   pure real(wp) function dashpot_of(self, step)
      class(fixed_points_type), intent(in) :: self  !< elements of this kind
      type(step_type), intent(in) :: step  !< the one being taken

      dashpot_of = (1.0_wp - step%scheme%chi)*self%stiffness*step%time_step
   end function dashpot_of

   !> Displacement that point i is to have at a time, m.
   pure function target_displacement(self, i, motions, time) result(displacement)
      class(fixed_points_type), intent(in) :: self  !< elements of this kind
      integer, intent(in) :: i  !< number, from 1
      type(motion_type), intent(in) :: motions(:)  !< prescribed ones
      real(wp), intent(in) :: time  !< s
      real(wp) :: displacement(2)
      integer :: axis

      displacement = 0.0_wp
      do axis = 1, 2
         associate (motion => self%point(i)%motion(axis))
            if (motion > 0) displacement(axis) = displacement_at(motions(motion)%curve, time)
         end associate
      end do
   end function target_displacement

   !> Velocity that point i is to have at the end of a step, m/s.
   pure function target_rate(self, i, motions, step) result(rate)
      class(fixed_points_type), intent(in) :: self  !< elements of this kind
      integer, intent(in) :: i  !< number, from 1
      type(motion_type), intent(in) :: motions(:)  !< prescribed ones
      type(step_type), intent(in) :: step  !< the one being taken
      real(wp) :: rate(2)
      integer :: axis

      if (step%scheme%chi > 0.5_wp) then
         rate = end_rate(step, target_displacement(self, i, motions, end_time(step)) &
            - target_displacement(self, i, motions, step%time), self%rate(:, i))
         return
      end if
      rate = 0.0_wp
      do axis = 1, 2
         associate (motion => self%point(i)%motion(axis))
            if (motion > 0) rate(axis) = velocity_at(motions(motion)%curve, end_time(step))
         end associate
      end do
   end function target_rate

   !> Place of point i relative to its motion, m; zero where it is free.
   pure function away_from(self, i, blocks, wanted) result(away)
      class(fixed_points_type), intent(in) :: self  !< elements of this kind
      integer, intent(in) :: i  !< number, from 1
      type(blocks_type), intent(in) :: blocks  !< in their present state
      real(wp), intent(in) :: wanted(2)  !< displacement that it is to have, m
      real(wp) :: away(2)

      associate (point => self%point(i))
         ! In this order nothing is rounded: force and energy then see the same place.
         away = along(point%axes, place_of(blocks, point%block, point%reference) - point%place) &
            - wanted
         away = merge(away, 0.0_wp, point%held)
      end associate
   end function away_from

   !> Components of a vector along the axes of a point; of known size, so that nothing is allocated.
   pure function along(axes, vector)
      real(wp), intent(in) :: axes(2, 2)  !< unit vectors
      real(wp), intent(in) :: vector(2)
      real(wp) :: along(2)

      along = [dot_product(vector, axes(:, 1)), dot_product(vector, axes(:, 2))]
   end function along

   !> Displacement or velocity of point i along its axes, from increments or rates of all blocks.
   pure function motion_along(self, i, blocks, d) result(motion)
      class(fixed_points_type), intent(in) :: self  !< elements of this kind
      integer, intent(in) :: i  !< number, from 1
      type(blocks_type), intent(in) :: blocks  !< in their present state
      real(wp), intent(in) :: d(:,:)  !< [6,blocks] of their coordinates
      real(wp) :: motion(2)

      associate (point => self%point(i))
         motion = along(point%axes, motion_of(blocks, point%block, point%reference, &
            d(:, point%block)))
      end associate
   end function motion_along

   !> Rows of the displacement of point i along its axes.
   pure function rows_of(self, i, blocks) result(t)
      class(fixed_points_type), intent(in) :: self  !< elements of this kind
      integer, intent(in) :: i  !< number, from 1
      type(blocks_type), intent(in) :: blocks  !< in their present state
      real(wp) :: t(2, 6), shape(2, 6)

      associate (axes => self%point(i)%axes)
         shape = shape_matrix(blocks, self%point(i)%block, self%point(i)%reference)
         t(1, :) = axes(1, 1)*shape(1, :) + axes(2, 1)*shape(2, :)
         t(2, :) = axes(1, 2)*shape(1, :) + axes(2, 2)*shape(2, :)
      end associate
   end function rows_of

   !> What the spring of point i exerts on its block in the present state, N/m …; its motion does
   !> not count.
   pure function reaction_of(self, i, blocks) result(force)
      type(fixed_points_type), intent(in) :: self  !< all points
      integer, intent(in) :: i  !< number, from 1
      type(blocks_type), intent(in) :: blocks  !< in their present state
      real(wp) :: force(6)

      associate (point => self%point(i))
         force = matmul(merge(-self%stiffness*matmul(place_of(blocks, point%block, &
            point%reference) - point%place, point%axes), 0.0_wp, point%held), &
            rows_of(self, i, blocks))
      end associate
   end function reaction_of

   !> A spring and a dashpot for each direction in which a point is held.
   subroutine add_linear(self, blocks, step, terms)
      class(fixed_points_type), intent(in) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks  !< in their present state
      type(step_type), intent(in) :: step  !< the one being taken
      type(linear_terms_type), intent(inout) :: terms  !< springs and dashpots
      type(linear_term_type) :: term
      real(wp) :: t(2, 6)
      integer :: i, axis

      term%kind = term_support
      do i = 1, size(self%point)
         t = rows_of(self, i, blocks)
         term%source = i
         term%block_a = self%point(i)%block
         term%place = place_of(blocks, self%point(i)%block, self%point(i)%reference)
         term%of_penalty = .true.
         term%motion = self%point(i)%motion
         do axis = 1, 2
            if (.not. self%point(i)%held(axis)) cycle
            term%row_a = t(axis, :)
            term%instant = at_end
            term%coefficient = self%stiffness
            call add_term(terms, term)
            term%instant = end_dashpot
            term%coefficient = dashpot_of(self, step)
            call add_term(terms, term)
         end do
      end do
   end subroutine add_linear

   !> −k (x₀ − u₁) + c [(1/χ − 1) v₀ + u̇₁]
   subroutine add_force(self, blocks, motions, step, load)
      class(fixed_points_type), intent(in) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks  !< in their present state
      type(motion_type), intent(in) :: motions(:)  !< prescribed ones
      type(step_type), intent(in) :: step  !< the one being taken
      real(wp), intent(inout) :: load(:,:)  !< [6,blocks] N/m …
      real(wp) :: t(2, 6), force(2)
      integer :: i

      do i = 1, size(self%point)
         associate (b => self%point(i)%block)
            t = rows_of(self, i, blocks)
            force = dashpot_of(self, step)*(velocity_weight(step) &
               *motion_along(self, i, blocks, blocks%velocity) &
               + target_rate(self, i, motions, step))
            force = merge(force, 0.0_wp, self%point(i)%held) - self%stiffness &
               *away_from(self, i, blocks, target_displacement(self, i, motions, end_time(step)))
            load(:, b) = load(:, b) + (force(1)*t(1, :) + force(2)*t(2, :))
         end associate
      end do
   end subroutine add_force

   !> Energy of springs and dashpots in the present state.
   subroutine add_stored(self, blocks, motions, step, energy)
      class(fixed_points_type), intent(in) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks  !< in their present state
      type(motion_type), intent(in) :: motions(:)  !< prescribed ones
      type(step_type), intent(in) :: step  !< the one being taken
      type(energy_type), intent(inout) :: energy  !< J per metre of thickness
      integer :: i

      do i = 1, size(self%point)
         call add_energy(energy, energy_support, stored(self, step, &
            away_from(self, i, blocks, target_displacement(self, i, motions, step%time)), &
            motion_along(self, i, blocks, blocks%velocity) - self%rate(:, i), self%point(i)%held))
      end do
   end subroutine add_stored

   !> ½ k y² + ½ (1 − χ) c Δt w², J per metre of thickness.
   pure real(wp) function stored(self, step, y, w, held)
      class(fixed_points_type), intent(in) :: self  !< elements of this kind
      type(step_type), intent(in) :: step  !< the one being taken
      real(wp), intent(in) :: y(2), w(2)  !< m and m/s, relative to the motion
      logical, intent(in) :: held(2)      !< in x, in y

      stored = 0.5_wp*sum(merge(self%stiffness*y**2 + (1.0_wp - step%scheme%chi) &
         *dashpot_of(self, step)*step%time_step*w**2, 0.0_wp, held))
   end function stored

   !> Work of the motions, F·Δu + c w₁·(Δu − Δt [(1 − χ) u̇₀ + χ u̇₁]), and the losses.
   subroutine account(self, blocks, motions, step, d, energy)
      class(fixed_points_type), intent(in) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks  !< in their present state
      type(motion_type), intent(in) :: motions(:)  !< prescribed ones
      type(step_type), intent(in) :: step  !< the one being taken
      real(wp), intent(in) :: d(:,:)  !< [6,blocks] increments of the coordinates
      type(energy_type), intent(inout) :: energy  !< J per metre of thickness
      real(wp) :: wanted(2), moved(2), change(2), rate(2), y(2), w(2), w0(2), c
      integer :: i

      c = dashpot_of(self, step)
      associate (dt => step%time_step, chi => step%scheme%chi)
         do i = 1, size(self%point)
            associate (held => self%point(i)%held)
               wanted = target_displacement(self, i, motions, step%time)
               moved = target_displacement(self, i, motions, end_time(step)) - wanted
               rate = target_rate(self, i, motions, step)
               change = motion_along(self, i, blocks, d)
               w0 = motion_along(self, i, blocks, blocks%velocity)
               w = merge(end_rate(step, change, w0) - rate, 0.0_wp, held)
               w0 = merge(w0 - self%rate(:, i), 0.0_wp, held)
               change = merge(change - moved, 0.0_wp, held)
               y = away_from(self, i, blocks, wanted) + change
               moved = merge(moved, 0.0_wp, held)
               call add_energy(energy, energy_support, stored(self, step, y, w, held))
               call add_energy(energy, energy_algorithmic, 0.5_wp*self%stiffness*sum(change**2))
               call add_energy(energy, energy_damping, c*dt*sum((2.0_wp*chi - 1.0_wp)*w**2 &
                  + 0.5_wp*(1.0_wp - chi)*(w0 + w)**2))
               call add_energy(energy, energy_input, -dot_product(self%stiffness*y + c*w, moved) &
                  + c*dot_product(w, moved - dt*((1.0_wp - chi)*self%rate(:, i) + chi*rate)))
            end associate
         end do
      end associate
   end subroutine account

   !> The motions' velocities at the end of the step are those at the start of the next one.
   subroutine accept(self, blocks, motions, step, d)
      class(fixed_points_type), intent(inout) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks  !< at the start of the step
      type(motion_type), intent(in) :: motions(:)  !< prescribed ones
      type(step_type), intent(in) :: step  !< the one being taken
      real(wp), intent(in) :: d(:,:)  !< [6,blocks] increments of the coordinates
      integer :: i

      do i = 1, size(self%point)
         self%rate(:, i) = target_rate(self, i, motions, step)
      end do
   end subroutine accept

   !> Least of ½ |v − v₀|² in M plus ½ (1 − χ) c Δt Σ [w + y/((1 − χ)Δt)]²: a stiff support takes a
   !> jump of velocity at once, which it would else store as energy for a step.
   subroutine match_velocity(self, blocks, motions, step, velocity)
      class(fixed_points_type), intent(in) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks  !< in their present state
      type(motion_type), intent(in) :: motions(:)  !< prescribed ones
      type(step_type), intent(in) :: step  !< the one being taken
      real(wp), intent(inout) :: velocity(:,:)  !< [6,blocks] per s
      real(wp) :: wanted(2, size(self%point))
      integer :: i
      logical :: done(size(self%point))

      if (step%scheme%chi >= 1.0_wp) return
      do i = 1, size(self%point)
         wanted(:, i) = self%rate(:, i) - away_from(self, i, blocks, target_displacement(self, i, &
            motions, step%time))/((1.0_wp - step%scheme%chi)*step%time_step)
      end do
      done = .false.
      do i = 1, size(self%point)
         if (done(i)) cycle
         call match_block(self, blocks, step, self%point(i)%block, wanted, velocity)
         done = done .or. self%point%block == self%point(i)%block
      end do
   end subroutine match_velocity

   !> The same for block b.
   pure subroutine match_block(self, blocks, step, b, wanted, velocity)
      class(fixed_points_type), intent(in) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks  !< in their present state
      type(step_type), intent(in) :: step  !< the one being taken
      integer, intent(in) :: b  !< number of the block
      real(wp), intent(in) :: wanted(:,:)  !< [2,points] m/s
      real(wp), intent(inout) :: velocity(:,:)  !< [6,blocks] per s
      real(wp) :: matrix(6, 6), inverse(6, 6), impulse(6), t(2, 6), weight
      integer :: i, axis, column

      weight = (1.0_wp - step%scheme%chi)*dashpot_of(self, step)*step%time_step
      matrix = mass_matrix(blocks%inertia(:, b))
      impulse = matmul(matrix, velocity(:, b))
      do i = 1, size(self%point)
         if (self%point(i)%block /= b) cycle
         t = rows_of(self, i, blocks)
         do axis = 1, 2
            if (.not. self%point(i)%held(axis)) cycle
            impulse = impulse + weight*wanted(axis, i)*t(axis, :)
            do column = 1, 6
               matrix(:, column) = matrix(:, column) + weight*t(axis, column)*t(axis, :)
            end do
         end do
      end do
      call invert(matrix, inverse)
      velocity(:, b) = matmul(inverse, impulse)
   end subroutine match_block

   !> Keep the prescribed places constant at their values at a time.
   subroutine freeze(self, blocks, motions, time)
      class(fixed_points_type), intent(inout) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks  !< in their present state
      type(motion_type), intent(in) :: motions(:)  !< prescribed ones
      real(wp), intent(in) :: time  !< s
      integer :: i

      do i = 1, size(self%point)
         self%point(i)%place = self%point(i)%place + target_displacement(self, i, motions, time)
         self%point(i)%motion = 0
      end do
      self%rate = 0.0_wp
   end subroutine freeze

   !> The velocities of the motions.
   subroutine serialise(self, archive)
      class(fixed_points_type), intent(inout) :: self  !< elements of this kind
      type(archive_type), intent(inout) :: archive  !< written or read

      call archive_values(archive, self%rate)
   end subroutine serialise

end module dda_fixed_points
