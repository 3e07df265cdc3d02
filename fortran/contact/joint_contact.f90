! SPDX-License-Identifier: GPL-3.0-or-later
!> Forces of a contact under a joint law, and its normal force linearised for an iteration.
!>
!> The line N = N₀ − k g is tangent to the law at a closure.  If the joint closes more than the line
!> predicted, the next tangent is taken at the closure that has the force of the line, else at the
!> computed closure.  This is Newton's method for compliance or stiffness, whichever is monotone.
module dda_joint_contact
   use dda_kinds, only: wp
   use dda_contact, only: contacts_type, contact_open, contact_slide, contact_stick
   use dda_joint_law, only: joint_law_type, joint_state_type, net_slip, response_type, weakened
   implicit none
   private
   public :: state_of, assumed_state, store_state, joint_response, linearise_normal, &
      linearise_shear, line_of, tilt_line, joint_bound, frozen_friction, joint_slide, &
      limit_friction, joint_energy, start_energy, centre_shift, most_closings

   integer, parameter :: most_closings = 8 !< after more closings in a step, contacts first slide
   !> first assumed force over initial spring force
   real(wp), parameter :: first_force_ratio = 0.5_wp

contains

   !> Return the state of contact c at the start of the step, with its frozen quantities.
   !> There is no lift in the step in which c closes, because the normal force would jump.
   pure type(joint_state_type) function state_of(contacts, law, c) result(state)
      type(contacts_type), intent(in) :: contacts  !< list with joint laws
      class(joint_law_type), intent(in) :: law     !< law of the contact
      integer, intent(in) :: c                     !< number of the contact

      state = joint_state_type(contacts%length(c), contacts%stiffness_fraction(c), &
         bonded=contacts%bonded(c), was_closed=contacts%was_closed(c), &
         lifts=law%dilates .and. contacts%was_closed(c), close_count=contacts%close_count(c), &
         stretch=contacts%stretch(c), time_step=contacts%time_step, &
         normal_force=contacts%normal_force(c), closure=-contacts%new_gap(c))
      state%memory(:law%columns) = contacts%memory(law%row(:law%columns), c)
      if (contacts%with_net_slip) state%past_centre = contacts%past_centre(c)
      if (.not. allocated(contacts%frozen_bound)) return
      state%frozen_bound = contacts%frozen_bound(c)
      if (.not. state%lifts) return
      state%frozen = state%frozen_bound
      if (state%bonded) state%frozen = max(state%frozen, tiny(1.0_wp))  ! cohesion in tension
      state%lifting = contacts%frozen_lifting(c)
   end function state_of

   !> Store the memory of contact c.
   pure subroutine store_state(contacts, law, c, state)
      type(contacts_type), intent(inout) :: contacts  !< list with joint laws
      class(joint_law_type), intent(in) :: law        !< law of the contact
      integer, intent(in) :: c                        !< number of the contact
      type(joint_state_type), intent(in) :: state     !< after the step

      contacts%memory(law%row(:law%columns), c) = state%memory(:law%columns)
   end subroutine store_state

   !> Return the state from which slip is assumed to start: at zero net slip, if the contact is
   !> assumed to pass it.
   pure type(joint_state_type) function assumed_state(law, state) result(start)
      class(joint_law_type), intent(in) :: law     !< law of the contact
      type(joint_state_type), intent(in) :: state  !< state at the start of the step

      start = state
      if (state%past_centre) start = state_at_centre(law, state)
   end function assumed_state

   !> Return the state after slip back to zero net slip.
   pure type(joint_state_type) function state_at_centre(law, state) result(centre)
      class(joint_law_type), intent(in) :: law     !< law of the contact
      type(joint_state_type), intent(in) :: state  !< state at the start of the step

      centre = law%state_after_slip(state, -state%memory(net_slip), 0.0_wp)
   end function state_at_centre

   !> Return the stretch that contact c loses by slip back to zero net slip, m.
   pure real(wp) function centre_shift(contacts, c) result(shift)
      type(contacts_type), intent(in) :: contacts  !< list with joint laws
      integer, intent(in) :: c                     !< number of the contact

      shift = 0.0_wp
      if (.not. contacts%with_net_slip) return
      if (contacts%past_centre(c)) shift = contacts%memory(net_slip, c)
   end function centre_shift

   !> Compute the forces for a gap and a trial stretch at the instant at which the contact acts.
   !> Frozen friction acts from zero net slip, if slip has passed it.
   pure type(response_type) function joint_response(law, start, gap, stretch) result(response)
      class(joint_law_type), intent(in) :: law     !< law of the contact
      type(joint_state_type), intent(in) :: start  !< state at the start of the step
      real(wp), intent(in) :: gap, stretch         !< m
      type(joint_state_type) :: state, sliding
      logical :: breaks_first

      state = start
      state%slip_sign = slip_direction(law, state, law%lift(state) - gap, stretch)
      call find_forces(law, state, gap, stretch, breaks_first, response)
      if (state%frozen_bound >= 0.0_wp .and. .not. (breaks_first .or. (state%lifts .and. &
         response%state /= contact_open))) then
         if (law%has_slip_curve) then
            call apply_slip_curve(law, state, state%frozen_bound, stretch, response)
         else
            sliding = sliding_state(law, state, response%past_centre, state%slip_sign)
            call limit_friction(response, frozen_friction(law, sliding), law%shear_spring(state) &
               *merge(stretch + state%memory(net_slip), stretch, response%past_centre))
         end if
      end if
      response%slider = response%shear_force
      if (.not. law%cohesive .and. response%state /= contact_open) &
         response%strength_ratio = overload(law, state, response, breaks_first)
   end function joint_response

   !> Return the direction of slip at a stretch, which is usually its sign.
   !>
   !> With a frozen force, a normal force far above it can drive a descent, b₋ − N tan α < 0, at any
   !> stretch above the negative limit.
   pure real(wp) function slip_direction(law, state, closure, stretch) result(direction)
      class(joint_law_type), intent(in) :: law     !< law of the contact
      type(joint_state_type), intent(in) :: state  !< state of the contact
      real(wp), intent(in) :: closure, stretch     !< m
      type(joint_state_type) :: opposite
      real(wp) :: limit

      direction = sign(1.0_wp, stretch)
      if (.not. (law%has_centre .and. state%frozen >= 0.0_wp .and. closure > 0.0_wp)) return
      opposite = state
      opposite%slip_sign = -direction
      limit = available_friction(law, opposite, law%normal_force(opposite, closure))
      if (law%shear_spring(state)*abs(stretch) < -limit) direction = -direction
   end function slip_direction

   !> Return the frozen friction without the part due to dilation, N/m.
   pure real(wp) function frozen_friction(law, state) result(friction)
      class(joint_law_type), intent(in) :: law     !< law of the contact
      type(joint_state_type), intent(in) :: state  !< state with the direction of slip

      friction = state%frozen_bound
      if (state%lifts) friction = friction_without_rise(law, state)
   end function frozen_friction

   !> Find the frozen quantities of contact c for the next pass, from the solution of the last one:
   !> the largest friction, and the fraction of slip that lifts.
   !>
   !> If slip lifts the contact, its friction depends on the direction of slip.  Its normal force is
   !> therefore frozen in place of its friction.  Then the map of the passes is continuous if slip
   !> reverses, and the energy remains convex, because b₊ and b₋ in −b₋ ≤ T − N tan α ≤ b₊ are
   !> constant.
   !>
   !> The lift of this fraction, distributed over the whole slip, is the lift by the law.  With a
   !> constant fraction the energy of the step is convex, also in the step in which dilation ends.
   pure subroutine joint_bound(law, start, shear_force, at, bound, lifting, difference)
      class(joint_law_type), intent(in) :: law     !< law of the contact
      type(joint_state_type), intent(in) :: start  !< state of the contact, solved
      real(wp), intent(in) :: shear_force          !< shear force of the solution, N/m
      real(wp), intent(in) :: at(2)                !< gap and stretch, m
      real(wp), intent(out) :: bound               !< N/m
      real(wp), intent(out) :: lifting             !< 0 … 1
      real(wp), intent(out) :: difference          !< of the forces from their law, N/m
      type(joint_state_type) :: state
      type(response_type) :: response
      real(wp) :: normal_force, friction
      logical :: breaks_first

      state = start
      state%frozen = -1.0_wp
      state%slip_sign = sign(1.0_wp, at(2))
      call find_forces(law, state, at(1), at(2), breaks_first, response)
      bound = response%bound
      friction = response%bound
      lifting = 1.0_wp
      difference = 0.0_wp
      if (.not. state%lifts) return
      normal_force = max(0.0_wp, state%normal_force)
      difference = max(abs(normal_force - max(0.0_wp, response%normal_force)), &
         abs(shear_force - response%shear_force))
      state = sliding_state(law, state, response%past_centre, at(2))
      if (response%state /= contact_open .or. normal_force > 0.0_wp) &
         friction = law%strength(state, normal_force)
      lifting = law%lifting_share(state, max(0.0_wp, abs(at(2)) - friction/law%shear_spring(state)))
      bound = normal_force
   end subroutine joint_bound

   !> Return the state that determines strength and rise in the direction of slip.
   pure type(joint_state_type) function sliding_state(law, start, past_centre, stretch) &
      result(state)
      class(joint_law_type), intent(in) :: law     !< law of the contact
      type(joint_state_type), intent(in) :: start  !< state at the start of the step
      logical, intent(in) :: past_centre           !< slip has returned to zero net slip
      real(wp), intent(in) :: stretch              !< its sign is the direction of slip

      state = start
      if (past_centre) state = state_at_centre(law, start)
      state%slip_sign = sign(1.0_wp, stretch)
   end function sliding_state

   !> Apply friction as a curve of slip, at the normal force of this iteration or a frozen one.
   pure subroutine apply_slip_curve(law, state, normal_force, stretch, response)
      class(joint_law_type), intent(in) :: law        !< law of the contact
      type(joint_state_type), intent(in) :: state     !< state of the contact
      real(wp), intent(in) :: normal_force            !< present or frozen normal force, N/m
      real(wp), intent(in) :: stretch                 !< stretch of the shear spring without slip, m
      type(response_type), intent(inout) :: response  !< response; receives the shear force
      real(wp) :: tangent

      response%bound = max(0.0_wp, normal_force)
      call law%flow(state, response%bound, stretch, response%shear_force, tangent)
   end subroutine apply_slip_curve

   !> Apply friction at a frozen bound, for any normal force and also if the contact opens.
   pure subroutine limit_friction(response, bound, trial_shear_force)
      type(response_type), intent(inout) :: response  !< response with the normal force
      real(wp), intent(in) :: bound  !< N/m
      real(wp), intent(in) :: trial_shear_force  !< shear force without slip, N/m

      response%bound = bound
      response%shear_force = sign(min(bound, abs(trial_shear_force)), trial_shear_force)
      response%slider = response%shear_force
      if (response%state /= contact_open) &
         response%state = merge(contact_stick, contact_slide, abs(trial_shear_force) <= bound)
   end subroutine limit_friction

   !> Find the forces of a contact whose friction is not a curve of slip.
   pure subroutine find_forces(law, state, gap, stretch, breaks_first, response)
      class(joint_law_type), intent(in) :: law     !< law of the contact
      type(joint_state_type), intent(in) :: state  !< state of the contact
      real(wp), intent(in) :: gap, stretch         !< m
      logical, intent(out) :: breaks_first  !< the joint breaks before it slips
      type(response_type), intent(out) :: response !< state and forces
      real(wp) :: closure

      response%state = contact_open
      breaks_first = .false.
      closure = law%lift(state) - gap
      if (closure <= 0.0_wp .and. (law%cohesive .or. .not. state%bonded)) then
         ! With dilation, the joint remains closed while its gap grows less than the lift, also
         ! beyond zero net slip.
         if (.not. state%lifts) return
         if (law%shear_spring(state)*abs(stretch) <= friction_without_rise(law, state)) return
         if (.not. law%has_centre) then
            if (lifted_force(law, state, closure, abs(stretch)) <= 0.0_wp) return
         end if
      end if
      ! A contact that closes in this step, or that opens and closes repeatedly, is not intact:
      ! otherwise its shear force would jump.
      breaks_first = law%brittle .and. state%memory(weakened) < 1.0_wp .and. (state%bonded .or. &
         (state%was_closed .and. state%close_count < most_closings))
      call set_shear_force_and_state(law, state, closure, stretch, breaks_first, response)
      if (law%has_centre .and. state%lifts) call pass_centre(law, state, closure, stretch, response)
   end subroutine find_forces

   !> Set the shear force, which is elastic up to the strength, and the state.
   pure subroutine set_shear_force_and_state(law, state, closure, stretch, breaks_first, response)
      class(joint_law_type), intent(in) :: law         !< law of the contact
      type(joint_state_type), intent(in) :: state      !< state of the contact
      real(wp), intent(in) :: closure, stretch         !< of the normal and shear spring, m
      logical, intent(in) :: breaks_first              !< the joint breaks before it slips
      type(response_type), intent(inout) :: response   !< response; receives state and forces
      real(wp) :: trial_shear_force

      response%state = contact_stick
      response%normal_force = law%normal_force(state, closure)
      if (law%has_slip_curve) then
         call apply_slip_curve(law, state, response%normal_force, stretch, response)
         return
      end if
      response%bound = available_friction(law, state, response%normal_force)
      if (breaks_first) response%bound = law%strength(state, response%normal_force)
      trial_shear_force = law%shear_spring(state)*stretch
      response%shear_force = trial_shear_force
      if (state%slip_sign*trial_shear_force > response%bound .and. .not. breaks_first) then
         response%state = contact_slide
         if (state%lifts) response%normal_force = lifted_force(law, state, closure, &
            state%slip_sign*stretch)
         response%bound = available_friction(law, state, response%normal_force)
         response%shear_force = state%slip_sign*response%bound  ! a descent may drive slip
      end if
   end subroutine set_shear_force_and_state

   !> Return the friction at the frozen normal force without the part due to dilation, N/m; −1 if
   !> no force is frozen.
   pure real(wp) function friction_without_rise(law, state) result(friction)
      class(joint_law_type), intent(in) :: law     !< law of the contact
      type(joint_state_type), intent(in) :: state  !< state of the contact

      friction = min(0.0_wp, state%frozen)
      if (state%frozen > 0.0_wp) friction = law%strength(state, state%frozen) &
         - state%lifting*law%rise(state, 0.0_wp)*state%frozen
   end function friction_without_rise

   !> Return the largest friction, N/m, at a normal force: by the law, or with a frozen force.
   !> The part due to dilation is added to frozen friction.
   pure real(wp) function available_friction(law, state, normal_force) result(friction)
      class(joint_law_type), intent(in) :: law     !< law of the contact
      type(joint_state_type), intent(in) :: state  !< state of the contact
      real(wp), intent(in) :: normal_force         !< N/m

      if (state%frozen < 0.0_wp) then
         friction = law%strength(state, normal_force)
      else
         friction = friction_without_rise(law, state) &
            + state%lifting*law%rise(state, 0.0_wp)*max(0.0_wp, normal_force)
      end if
   end function available_friction

   !> Return the normal force, N/m, of a sliding contact that is lifted by slip.
   !> With a frozen bound, dilation acts as in an associated joint.
   pure real(wp) function lifted_force(law, state, closure, stretch) result(force)
      class(joint_law_type), intent(in) :: law     !< law of the contact
      type(joint_state_type), intent(in) :: state  !< state at the start of the step
      real(wp), intent(in) :: closure, stretch     !< m
      real(wp) :: springs(2), rise

      if (state%frozen < 0.0_wp) then
         force = law%sliding_force(state, closure, stretch)
         return
      end if
      springs = [law%initial_spring(state), law%shear_spring(state)]
      rise = state%lifting*law%rise(state, 0.0_wp)
      force = max(0.0_wp, springs(1)*(closure + rise*(stretch - friction_without_rise(law, state) &
         /springs(2)))/(1.0_wp + springs(1)*rise**2/springs(2)))
   end function lifted_force

   !> Decide whether slip that reaches zero net slip stops there or continues beyond.
   !> If slip lowers the contact faster than the joint closes, the contact opens.
   pure subroutine pass_centre(law, state, closure, stretch, response)
      class(joint_law_type), intent(in) :: law        !< law of the contact
      type(joint_state_type), intent(in) :: state     !< state of the contact
      real(wp), intent(in) :: closure, stretch        !< m
      type(response_type), intent(inout) :: response !< response for one direction of slip
      type(joint_state_type) :: centre
      real(wp) :: slip

      if (response%state /= contact_slide) return
      slip = state%slip_sign*stretch - response%bound/law%shear_spring(state)
      if (state%slip_sign*state%memory(net_slip) < 0.0_wp .and. &
         slip > abs(state%memory(net_slip))) then
         response%past_centre = .true.
         centre = state_at_centre(law, state)
         call set_shear_force_and_state(law, centre, closure + law%lift(centre) - law%lift(state), &
            stretch + state%memory(net_slip), .false., response)
      end if
      ! With frozen friction, an open contact is still dragged beyond zero net slip.
      if (response%normal_force <= 0.0_wp) response = response_type(contact_open, &
         past_centre=response%past_centre .and. state%frozen >= 0.0_wp)
   end subroutine pass_centre

   !> Return the overload (force − strength)/strength of a bond or intact joint; ≤ 0: no failure.
   pure real(wp) function overload(law, state, response, breaks_first)
      class(joint_law_type), intent(in) :: law        !< law of the contact
      type(joint_state_type), intent(in) :: state     !< state of the contact
      type(response_type), intent(in) :: response     !< forces of the contact
      logical, intent(in) :: breaks_first  !< the joint breaks before it slips
      real(wp) :: tension

      overload = 0.0_wp
      tension = law%tension(state)
      if (state%bonded) overload = -response%normal_force - tension
      if (breaks_first) overload = max(overload, abs(response%shear_force) - response%bound)
      overload = overload/max(tension, response%bound, tiny(1.0_wp))
   end function overload

   !> Return the friction, N/m, of a contact that slides in the assumed direction, without dilation.
   !> The normal force is given by its line, or by the law with the lift due to slip.
   pure real(wp) function joint_slide(contacts, law, c, gap, stretch) result(friction)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      class(joint_law_type), intent(in) :: law     !< law of the contact
      integer, intent(in) :: c                     !< number of the contact
      real(wp), intent(in) :: gap, stretch         !< gap and stretch at the end of the step, m
      type(joint_state_type) :: state
      real(wp) :: normal_force

      state = assumed_state(law, state_of(contacts, law, c))
      state%slip_sign = contacts%slip_sign(c)
      normal_force = contacts%line(1, c) - contacts%tangent(1, c)*gap
      if (state%lifts) normal_force = law%sliding_force(state, law%lift(state) &
         - gap, max(0.0_wp, contacts%slip_sign(c)*(stretch + centre_shift(contacts, c))))
      friction = contacts%slip_sign(c)*law%strength(state, normal_force) &
         - contacts%tilt(1, c)*normal_force
      if (state%frozen_bound >= 0.0_wp) friction = contacts%slip_sign(c)*frozen_friction(law, state)
   end function joint_slide

   !> Tilt the line of contact c with dilation: its normal spring acts along gap − rise × slip, in
   !> series with the shear spring.
   pure subroutine tilt_line(contacts, law, c, at, response)
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step; tilt and line change
      class(joint_law_type), intent(in) :: law        !< law of the contact
      integer, intent(in) :: c                        !< number of the contact
      real(wp), intent(in) :: at(2)                   !< gap and stretch, m
      type(response_type), intent(in) :: response     !< response of the law
      type(joint_state_type) :: state
      real(wp) :: stretch

      contacts%tilt(1, c) = 0.0_wp
      state = state_of(contacts, law, c)
      if (contacts%trial_state(c) /= contact_slide .or. .not. state%lifts) return
      stretch = at(2) + centre_shift(contacts, c)
      state = sliding_state(law, state, response%past_centre, slip_direction(law, state, &
         law%lift(state) - at(1), at(2)))
      associate (normal => contacts%tangent(1, c), shear => law%shear_spring(state), &
         tilt => contacts%tilt(1, c))
         if (allocated(contacts%frozen_lifting)) then
            tilt = state%slip_sign*contacts%frozen_lifting(c)*law%rise(state, 0.0_wp)
         else
            tilt = state%slip_sign*law%rise(state, max(0.0_wp, abs(stretch) - response%bound/shear))
         end if
         normal = normal*shear/(shear + normal*tilt**2)
         contacts%line(1, c) = response%normal_force + normal*(at(1) - tilt*stretch)
      end associate
   end subroutine tilt_line

   !> Return the tangent line of the normal force at a closure, with the lift before the step.
   pure subroutine linearise_normal(law, start, closure, tangent, normal_free)
      class(joint_law_type), intent(in) :: law           !< law of the contact
      type(joint_state_type), intent(in) :: start        !< state at the start of the step
      real(wp), intent(in) :: closure                    !< m
      real(wp), intent(out) :: tangent, normal_free      !< N/m; N = normal_free − tangent × gap
      type(joint_state_type) :: state

      state = assumed_state(law, start)
      tangent = law%tangent(state, closure)
      normal_free = law%normal_force(state, closure) + tangent*(law%lift(state) - closure)
   end subroutine linearise_normal

   !> Set the shear spring of a sticking contact to the tangent of the law at a stretch.
   pure subroutine linearise_shear(contacts, law, c, normal_force, stretch)
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step
      class(joint_law_type), intent(in) :: law        !< law of the contact
      integer, intent(in) :: c                        !< number of the contact
      real(wp), intent(in) :: normal_force            !< normal force that bounds friction, N/m
      real(wp), intent(in) :: stretch                 !< m
      type(joint_state_type) :: state
      real(wp) :: force

      state = state_of(contacts, law, c)
      contacts%tangent(2, c) = law%shear_spring(state)
      contacts%line(2, c) = 0.0_wp
      if (.not. law%has_slip_curve) return
      call law%flow(state, max(0.0_wp, normal_force), stretch, force, contacts%tangent(2, c))
      contacts%line(2, c) = force - contacts%tangent(2, c)*stretch
   end subroutine linearise_shear

   !> Return the line of the next iteration, from the response of the law at a solution.
   pure subroutine line_of(contacts, law, c, gap, response, tangent, normal_free)
      type(contacts_type), intent(in) :: contacts        !< contacts of this step
      class(joint_law_type), intent(in) :: law           !< law of the contact
      integer, intent(in) :: c                           !< number of the contact
      real(wp), intent(in) :: gap                        !< gap at which the contact acts, m
      type(response_type), intent(in) :: response        !< response of the law
      real(wp), intent(out) :: tangent, normal_free      !< N/m; N = normal_free − tangent × gap
      type(joint_state_type) :: state
      real(wp) :: closure, estimate

      state = state_of(contacts, law, c)
      closure = law%lift(assumed_state(law, state)) - gap
      if (law%curved) then
         estimate = contacts%line(1, c) - contacts%tangent(1, c)*gap
         if (contacts%state(c) == contact_open .or. estimate <= 0.0_wp) &
            estimate = first_force_ratio*law%initial_spring(state)*closure
         if (closure > 0.0_wp) closure = min(closure, law%closure(state, estimate))
      end if
      call linearise_normal(law, state, max(closure, 0.0_wp), tangent, normal_free)
      ! With frozen bounds, the line is the tangent at the solution, which reduces the energy.
      if ((response%state == contact_slide .and. law%dilates) .or. &
         (response%state /= contact_open .and. allocated(contacts%frozen_bound))) &
         normal_free = response%normal_force + tangent*gap
   end subroutine line_of

   !> Return the energy of the springs of contact c at the start of the step, J per metre.
   pure real(wp) function start_energy(contacts, law, c, closed)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      class(joint_law_type), intent(in) :: law     !< law of the contact
      integer, intent(in) :: c                     !< number of the contact
      logical, intent(in) :: closed                !< the normal spring acts
      type(joint_state_type) :: state

      state = state_of(contacts, law, c)
      start_energy = joint_energy(law, state, law%lift(state) - contacts%gap(c), state%stretch, &
         closed)
   end function start_energy

   !> Return the energy of the springs of a contact, J per metre of thickness.
   pure real(wp) function joint_energy(law, state, closure, stretch, closed)
      class(joint_law_type), intent(in) :: law     !< law of the contact
      type(joint_state_type), intent(in) :: state  !< state of the contact
      real(wp), intent(in) :: closure, stretch     !< m
      logical, intent(in) :: closed                !< the normal spring acts

      if (law%cohesive) then
         joint_energy = 0.5_wp*law%initial_spring(state)*max(closure, 0.0_wp)**2 &
            + 0.5_wp*law%shear_spring(state)*stretch**2
         if (state%memory(weakened) < 1.0_wp) joint_energy = joint_energy &
            + (1.0_wp - state%memory(weakened)) &
            *(0.5_wp*law%initial_spring(state)*min(closure, 0.0_wp)**2 &
            + 0.5_wp*law%shear_spring(state)*((stretch + state%memory(net_slip))**2 - stretch**2))
         return
      end if
      joint_energy = 0.5_wp*law%shear_spring(state)*stretch**2
      if (closed) joint_energy = joint_energy + law%stored(state, closure)
   end function joint_energy

end module dda_joint_contact
