! SPDX-License-Identifier: GPL-3.0-or-later
!> Elements that are pairs of springs between two blocks, or between a block and the ground.
!>
!> The extension y and its rate w are relative to a motion.  A spring at t₀ + θΔt exerts −k y.  A
!> spring at the end of the step has a dashpot and exerts −k y₁ − c w₁, c = (1 − χ) k Δt.  Without
!> the dashpot, the velocity at a stiff spring would change sign in every step (DDA: root −1 +
!> 8/Ω²); with it, both roots are 1/(1 ± iΩ) for any (θ, χ).
!>
!> The energy ½ k y² + ½ (1 − χ) c Δt w² never increases: a step loses (θ − ½) k Δy² by the scheme
!> (θ = 1 at the end of the step), and c Δt [(2χ − 1) w₁² + ½ (1 − χ)(w₀ + w₁)²] in the dashpot.
!>
!> For χ = ½ the velocity of a motion is the velocity of its record.  For other χ it is integrated
!> as for a block, v₁ = Δu/(χΔt) − (1/χ − 1) v₀, because with the recorded velocity the base would
!> lag by (1 − χ)(χ − ½)Ω².
module dda_spring_element
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type
   use dda_element, only: element_type
   use dda_energy, only: energy_type, add_energy, energy_support, energy_algorithmic, &
      energy_damping, energy_input
   use dda_linear_terms, only: linear_terms_type, linear_term_type, add_term, term_support, &
      at_theta, at_end, end_dashpot
   use dda_motion, only: motion_type, displacement_of, velocity_of
   use dda_scheme, only: step_type, end_time, end_rate, velocity_weight
   implicit none
   private
   public :: spring_element_type, spring_type, ground_type, extension_change, dashpots_of, &
      find_ground, target_rate

   !> The two springs of an element in the present geometry.
   type :: spring_type
      integer :: block(2) = 0           !< blocks; 0: ground; first 0: no springs
      real(wp) :: stiffness(2)          !< k, N/m per metre of thickness; 0: no spring
      real(wp) :: stretch(2)            !< m
      real(wp) :: row(6, 2, 2)          !< [6,springs,blocks] u and −u of the extension
      real(wp) :: position(2)              !< position of the element, m
      integer :: motion(2) = 0          !< motions to which the stretch is relative; 0: none
      real(wp) :: rate(2) = 0.0_wp      !< velocity of these motions at the start of the step, m/s
   end type spring_type

   !> Motions of the ground in a step.
   type :: ground_type
      integer :: motion(2) = -1  !< numbers of the motions; 0: none; −1: not evaluated
      real(wp) :: start(2)       !< displacement at the start of the step, m
      real(wp) :: end(2)         !< displacement at the end of the step, m
      real(wp) :: velocity(2)    !< velocity of the record at the end, m/s; only for χ = ½
   end type ground_type

   !> All elements of a kind with springs.
   type, abstract, extends(element_type) :: spring_element_type
      integer :: n = 0                 !< number of elements
      integer :: kind = term_support   !< kind of the terms
      integer :: instant = at_theta    !< instant of the springs, or at_end
      logical :: of_penalty = .true.   !< the stiffness is proportional to k_n
   contains
      procedure(springs_interface), deferred :: get_spring
      procedure :: add_linear_terms, add_force, add_stored_energy, add_to_budget
   end type spring_element_type

   abstract interface
      !> Set the springs of an element in the present geometry.
      pure subroutine springs_interface(self, i, blocks, spring)
         import :: spring_element_type, blocks_type, spring_type
         class(spring_element_type), intent(in) :: self  !< elements of this kind
         integer, intent(in) :: i                        !< number of the element
         type(blocks_type), intent(in) :: blocks         !< blocks in their present state
         type(spring_type), intent(out) :: spring        !< springs of the element
      end subroutine springs_interface
   end interface

contains

   !> Return the change of the extension due to increments or rates of all blocks.
   pure function extension_change(spring, d) result(change)
      type(spring_type), intent(in) :: spring  !< both springs of an element
      real(wp), intent(in) :: d(:,:)           !< [6,blocks] increments or rates of the coordinates
      real(wp) :: change(2)

      change = matmul(d(:, spring%block(1)), spring%row(:, :, 1))
      if (spring%block(2) > 0) change = change - matmul(d(:, spring%block(2)), spring%row(:, :, 2))
   end function extension_change

   !> Return the dashpot coefficient c, N s/m per metre of thickness.
   pure function dashpots_of(self, spring, step) result(dashpot)
      class(spring_element_type), intent(in) :: self  !< elements of this kind
      type(spring_type), intent(in) :: spring         !< spring of one element
      type(step_type), intent(in) :: step             !< the present step
      real(wp) :: dashpot(2)

      dashpot = 0.0_wp
      if (self%instant == at_end) dashpot = (1.0_wp - step%scheme%chi)*spring%stiffness &
         *step%time_step
   end function dashpots_of

   !> Return the fraction of a step after which the springs act.
   pure real(wp) function act_fraction(self, step) result(fraction)
      class(spring_element_type), intent(in) :: self  !< elements of this kind
      type(step_type), intent(in) :: step             !< the present step

      fraction = merge(1.0_wp, step%scheme%theta, self%instant == at_end)
   end function act_fraction

   !> Evaluate the motions with these numbers, unless `ground` contains them already.
   pure subroutine find_ground(ground, motion, motions, step)
      type(ground_type), intent(inout) :: ground   !< motions of the last element
      integer, intent(in) :: motion(2)             !< numbers of the motions; 0: none
      type(motion_type), intent(in) :: motions(:)  !< prescribed motions
      type(step_type), intent(in) :: step          !< the present step

      if (ground%motion(1) == motion(1) .and. ground%motion(2) == motion(2)) return
      ground%motion = motion
      ground%start = displacement_of(motions, motion, step%time)
      ground%end = displacement_of(motions, motion, end_time(step))
      if (.not. step%scheme%chi > 0.5_wp) &
         ground%velocity = velocity_of(motions, motion, end_time(step))
   end subroutine find_ground

   !> Return the velocity of the motions at the end of a step, m/s.
   pure function target_rate(ground, start_rate, step) result(rate)
      type(ground_type), intent(in) :: ground  !< motions in the step
      real(wp), intent(in) :: start_rate(2)    !< velocity at the start of the step, m/s
      type(step_type), intent(in) :: step      !< the present step
      real(wp) :: rate(2)

      if (step%scheme%chi > 0.5_wp) then
         rate = end_rate(step, ground%end - ground%start, start_rate)
      else
         rate = ground%velocity
      end if
   end function target_rate

   !> Append springs and their dashpots; if both ends belong to one block, their rows are added.
   subroutine add_linear_terms(self, blocks, step, terms)
      class(spring_element_type), intent(in) :: self   !< elements of this kind
      type(blocks_type), intent(in) :: blocks          !< blocks in their present state
      type(step_type), intent(in) :: step              !< the present step
      type(linear_terms_type), intent(inout) :: terms  !< springs and dashpots
      type(linear_term_type) :: term
      type(spring_type) :: spring
      real(wp) :: dashpot(2)
      integer :: i, k

      term%kind = self%kind
      term%of_penalty = self%of_penalty
      do i = 1, self%n
         call self%get_spring(i, blocks, spring)
         if (spring%block(1) == 0) cycle
         dashpot = dashpots_of(self, spring, step)
         term%source = i
         term%block_a = spring%block(1)
         term%block_b = merge(0, spring%block(2), spring%block(1) == spring%block(2))
         term%position = spring%position
         term%motion = spring%motion
         do k = 1, 2
            if (.not. spring%stiffness(k) > 0.0_wp) cycle
            term%row_a = spring%row(:, k, 1)
            if (term%block_b > 0) term%row_b = spring%row(:, k, 2)
            if (spring%block(2) == spring%block(1)) term%row_a = term%row_a - spring%row(:, k, 2)
            term%instant = self%instant
            term%coefficient = spring%stiffness(k)
            call add_term(terms, term)
            if (.not. dashpot(k) > 0.0_wp) cycle
            term%instant = end_dashpot
            term%coefficient = dashpot(k)
            call add_term(terms, term)
         end do
      end do
   end subroutine add_linear_terms

   !> Add the forces −k (s₀ − u) + c [(1/χ − 1) v₀ + u̇₁], with u at the instant of the spring.
   subroutine add_force(self, blocks, step, load)
      class(spring_element_type), intent(in) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks         !< blocks in their present state
      type(step_type), intent(in) :: step             !< the present step
      real(wp), intent(inout) :: load(:,:)            !< [6,blocks] forces, N/m …
      type(spring_type) :: spring
      type(ground_type) :: ground
      real(wp) :: force(2), target(2), c(2), fraction
      integer :: i

      fraction = act_fraction(self, step)
      do i = 1, self%n
         call self%get_spring(i, blocks, spring)
         if (spring%block(1) == 0) cycle
         call find_ground(ground, spring%motion, self%motions, step)
         target = ground%end
         if (fraction < 1.0_wp) target = target + (1.0_wp - fraction)*(ground%start - target)
         force = -spring%stiffness*(spring%stretch - target)
         c = dashpots_of(self, spring, step)
         if (any(c > 0.0_wp)) force = force + c*(velocity_weight(step)*extension_change(spring, &
            blocks%velocity) + target_rate(ground, spring%rate, step))
         associate (row => spring%row, a => spring%block(1), b => spring%block(2))
            load(:, a) = load(:, a) + (force(1)*row(:, 1, 1) + force(2)*row(:, 2, 1))
            if (b > 0) load(:, b) = load(:, b) - (force(1)*row(:, 1, 2) + force(2)*row(:, 2, 2))
         end associate
      end do
   end subroutine add_force

   !> Add the energy of springs and dashpots in the present state.
   subroutine add_stored_energy(self, blocks, step, energy)
      class(spring_element_type), intent(in) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks         !< blocks in their present state
      type(step_type), intent(in) :: step             !< the next step
      type(energy_type), intent(inout) :: energy      !< energy budget, J per metre
      type(spring_type) :: spring
      type(ground_type) :: ground
      integer :: i

      do i = 1, self%n
         call self%get_spring(i, blocks, spring)
         if (spring%block(1) == 0) cycle
         call find_ground(ground, spring%motion, self%motions, step)
         call add_energy(energy, energy_support, spring_energy(self, spring, step, &
            spring%stretch - ground%start, extension_change(spring, blocks%velocity) - spring%rate))
      end do
   end subroutine add_stored_energy

   !> Return the energy ½ k y² + ½ (1 − χ) c Δt w², J per metre of thickness.
   pure real(wp) function spring_energy(self, spring, step, y, w)
      class(spring_element_type), intent(in) :: self  !< elements of this kind
      type(spring_type), intent(in) :: spring         !< spring of one element
      type(step_type), intent(in) :: step             !< the present step
      real(wp), intent(in) :: y(2), w(2)  !< extension, m, and its rate, m/s, relative to the motion

      spring_energy = 0.5_wp*sum(spring%stiffness*y**2 + (1.0_wp - step%scheme%chi) &
         *dashpots_of(self, spring, step)*step%time_step*w**2)
   end function spring_energy

   !> Add the work −k y·Δu − c w₁·Δt [(1 − χ) u̇₀ + χ u̇₁] of the motions, and the losses.
   subroutine add_to_budget(self, blocks, step, d, energy)
      class(spring_element_type), intent(in) :: self  !< elements of this kind
      type(blocks_type), intent(in) :: blocks         !< blocks in their present state
      type(step_type), intent(in) :: step             !< the present step
      real(wp), intent(in) :: d(:,:)                  !< [6,blocks] increments of the coordinates
      type(energy_type), intent(inout) :: energy      !< energy budget, J per metre
      type(spring_type) :: spring
      type(ground_type) :: ground
      real(wp) :: y(2), motion_change(2), change(2), rate(2), w(2), w0(2), c(2), fraction
      integer :: i

      fraction = act_fraction(self, step)
      associate (dt => step%time_step, chi => step%scheme%chi, k => spring%stiffness)
         do i = 1, self%n
            call self%get_spring(i, blocks, spring)
            if (spring%block(1) == 0) cycle
            c = dashpots_of(self, spring, step)
            call find_ground(ground, spring%motion, self%motions, step)
            motion_change = ground%end - ground%start
            change = extension_change(spring, d)
            w = 0.0_wp
            if (any(c > 0.0_wp)) then
               rate = target_rate(ground, spring%rate, step)
               w0 = extension_change(spring, blocks%velocity)
               w = end_rate(step, change, w0) - rate
               call add_energy(energy, energy_damping, dt*sum(c*((2.0_wp*chi - 1.0_wp)*w**2 &
                  + 0.5_wp*(1.0_wp - chi)*(w0 - spring%rate + w)**2)))
               call add_energy(energy, energy_input, -dt*dot_product(c*w, &
                  (1.0_wp - chi)*spring%rate + chi*rate))
            end if
            change = change - motion_change
            y = spring%stretch - ground%start
            call add_energy(energy, energy_support, spring_energy(self, spring, step, y + change, &
               w))
            call add_energy(energy, energy_algorithmic, (fraction - 0.5_wp)*sum(k*change**2))
            call add_energy(energy, energy_input, -dot_product(k*(y + fraction*change), &
               motion_change))
         end do
      end associate
   end subroutine add_to_budget

end module dda_spring_element
