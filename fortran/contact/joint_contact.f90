! SPDX-License-Identifier: GPL-3.0-or-later
!> A contact under a joint law: its response, and the straight line that stands for its normal force
!> in the equations of an open–close iteration.
!>
!> The line N = N₀ − k g touches the law at a closure.  Where a joint closes more than the line
!> expected, the next line touches at the closure that belongs to the line's force, else at the
!> closure itself: Newton's method for the compliance and for the stiffness, each where it is safe.
module dda_joint_contact
   use dda_kinds, only: wp
   use dda_contact, only: contacts_type, contact_open, contact_slide, contact_stick
   use dda_joint_law, only: joint_law_type, joint_state_type
   implicit none
   private
   public :: response_type, state_of, joint_response, acts_before_end, closure_of, touch_law, &
      line_of, slide_response, joint_energy, centre_shift, opens_at_centre, slip_lifts, &
      most_closings

   integer, parameter :: most_closings = 8     !< in a step, after which what closes slides first
   real(wp), parameter :: first_share = 0.5_wp  !< of the force at closing, where a line begins

   !> State and forces at a gap and a slip.
   type :: response_type
      integer :: state         !< open, slide or stick
      real(wp) :: normal_force !< compression positive, N/m
      real(wp) :: shear_force  !< k_s × elastic stretch, within the bound, N/m
      real(wp) :: bound        !< largest shear force, N/m
      !> excess of force over the strength of a bond, of that strength; ≤ 0: it holds
      real(wp) :: strength_ratio
      real(wp) :: slider = 0.0_wp      !< shear force of friction if nothing of it is bond, N/m
      logical :: past_centre = .false. !< slip has come back to the centre, and goes on from there
   end type response_type

contains

   !> Memory of contact c.
   pure type(joint_state_type) function state_of(contacts, c) result(state)
      type(contacts_type), intent(in) :: contacts  !< list with joint laws
      integer, intent(in) :: c                     !< number of the contact

      state = joint_state_type(contacts%length(c), contacts%slip_path(c), contacts%weakened(c), &
         contacts%share(c))
      if (.not. contacts%with_net_slip) return
      state%net_slip = contacts%net_slip(c)
      state%lifted = contacts%lifted(c)
   end function state_of

   !> The state of contact c from which its assumed spring acts: slip back to the centre is done.
   pure type(joint_state_type) function assumed_state(contacts, law, c) result(state)
      type(contacts_type), intent(in) :: contacts  !< list with joint laws
      class(joint_law_type), intent(in) :: law     !< of the contact
      integer, intent(in) :: c                     !< number of the contact

      state = state_of(contacts, c)
      if (starts_at_centre(contacts, c)) state = law%slipped(state, -state%net_slip, 0.0_wp)
   end function assumed_state

   !> Contact c is assumed to slip back to its centre first.
   pure logical function starts_at_centre(contacts, c)
      type(contacts_type), intent(in) :: contacts  !< list with joint laws
      integer, intent(in) :: c                     !< number of the contact

      starts_at_centre = contacts%with_net_slip
      if (starts_at_centre) starts_at_centre = contacts%past_centre(c)
   end function starts_at_centre

   !> Stretch of contact c that slip back to the centre takes off, m.
   pure real(wp) function centre_shift(contacts, c) result(shift)
      type(contacts_type), intent(in) :: contacts  !< list with joint laws
      integer, intent(in) :: c                     !< number of the contact

      shift = 0.0_wp
      if (starts_at_centre(contacts, c)) shift = contacts%net_slip(c)
   end function centre_shift

   !> A bonded contact that cannot slip acts at t₀ + θΔt, others at the end of the step.
   pure logical function acts_before_end(law, weakened)
      class(joint_law_type), intent(in) :: law  !< of the contact
      real(wp), intent(in) :: weakened          !< 0 … 1

      acts_before_end = law%brittle .and. weakened < 1.0_wp
   end function acts_before_end

   !> Closure of contact c at a gap, m: lifted as at the start of the step.
   pure real(wp) function closure_of(contacts, law, c, gap) result(closure)
      type(contacts_type), intent(in) :: contacts  !< list with joint laws
      class(joint_law_type), intent(in) :: law     !< of the contact
      integer, intent(in) :: c                     !< number of the contact
      real(wp), intent(in) :: gap                  !< m

      closure = -gap
      if (law%dilates) closure = law%lift(state_of(contacts, c)) - gap
   end function closure_of

   !> Slip of this step lifts contact c.  That of a step in which it closes does not: its normal
   !> force would jump as it touches.
   pure logical function slip_lifts(contacts, law, c)
      type(contacts_type), intent(in) :: contacts  !< this step's list
      class(joint_law_type), intent(in) :: law     !< of the contact
      integer, intent(in) :: c                     !< number of the contact

      slip_lifts = law%dilates
      if (slip_lifts) slip_lifts = contacts%was_closed(c)
   end function slip_lifts

   !> Contact c has opened in this step as slip comes down to its centre.
   pure logical function opens_at_centre(contacts, law, c)
      type(contacts_type), intent(in) :: contacts  !< this step's list, solved
      class(joint_law_type), intent(in) :: law     !< of the contact
      integer, intent(in) :: c                     !< number of the contact

      opens_at_centre = law%has_centre .and. contacts%trial_state(c) == contact_open
      if (opens_at_centre) opens_at_centre = contacts%was_closed(c)
   end function opens_at_centre

   !> Forces at a gap and a trial stretch, both at the instant at which the contact acts.
   pure type(response_type) function joint_response(contacts, law, c, gap, stretch) &
      result(response)
      type(contacts_type), intent(in) :: contacts  !< this step's list
      class(joint_law_type), intent(in) :: law     !< of the contact
      integer, intent(in) :: c                     !< number of the contact
      real(wp), intent(in) :: gap, stretch         !< m
      type(joint_state_type) :: state
      real(wp) :: closure
      logical :: intact, lifts

      response = response_type(contact_open, 0.0_wp, 0.0_wp, 0.0_wp, 0.0_wp)
      lifts = slip_lifts(contacts, law, c)
      closure = closure_of(contacts, law, c, gap)
      state = state_of(contacts, c)
      state%way = sign(1.0_wp, stretch)
      if (closure <= 0.0_wp .and. (law%cohesive .or. .not. contacts%bonded(c))) then
         ! A joint that slip lifts stays closed at a gap that grows less than the lift, also as it
         ! passes its centre.
         if (.not. lifts) return
         if (.not. law%has_centre) then
            if (law%sliding_force(state, closure, abs(stretch)) <= 0.0_wp) return
         end if
      end if
      ! What closes, or goes on to open and close, is not whole: its shear force would jump.
      intact = law%brittle .and. state%weakened < 1.0_wp .and. (contacts%bonded(c) .or. &
         (contacts%was_closed(c) .and. contacts%close_count(c) < most_closings))
      call stick_or_slide(law, state, closure, stretch, intact, lifts, response)
      if (law%has_centre .and. lifts) call pass_centre(law, state, closure, stretch, response)
      response%slider = response%shear_force
      if (.not. law%cohesive) response%strength_ratio = excess(contacts, law, c, state, response, &
         intact)
   end function joint_response

   !> Elastic in shear up to the strength.
   pure subroutine stick_or_slide(law, state, closure, stretch, intact, lifts, response)
      class(joint_law_type), intent(in) :: law         !< of the contact
      type(joint_state_type), intent(in) :: state      !< of the contact
      real(wp), intent(in) :: closure, stretch         !< m
      logical, intent(in) :: intact                    !< it breaks rather than slips
      logical, intent(in) :: lifts                     !< slip does
      type(response_type), intent(inout) :: response   !< gets state and forces
      real(wp) :: trial

      response%state = contact_stick
      response%normal_force = law%normal_force(state, closure)
      response%bound = law%strength(state, response%normal_force)
      trial = law%shear_spring(state)*stretch
      response%shear_force = trial
      if (abs(trial) > response%bound .and. .not. intact) then
         response%state = contact_slide
         if (lifts) response%normal_force = law%sliding_force(state, closure, abs(stretch))
         response%bound = law%strength(state, response%normal_force)
         response%shear_force = sign(response%bound, trial)
      end if
   end subroutine stick_or_slide

   !> Slip that comes back to its centre goes on from there, or sticks; where it comes down faster
   !> than the joint closes, the contact opens.
   pure subroutine pass_centre(law, state, closure, stretch, response)
      class(joint_law_type), intent(in) :: law        !< of the contact
      type(joint_state_type), intent(in) :: state     !< of the contact
      real(wp), intent(in) :: closure, stretch        !< m
      type(response_type), intent(inout) :: response  !< of slip the same way, changed if it ends
      type(joint_state_type) :: centre
      real(wp) :: slip

      if (response%state /= contact_slide) return
      slip = abs(stretch) - response%bound/law%shear_spring(state)
      if (state%way*state%net_slip < 0.0_wp .and. slip > abs(state%net_slip)) then
         response%past_centre = .true.
         centre = law%slipped(state, -state%net_slip, 0.0_wp)
         call stick_or_slide(law, centre, closure + law%lift(centre) - law%lift(state), &
            stretch + state%net_slip, .false., .true., response)
      end if
      if (response%normal_force <= 0.0_wp) response = response_type(contact_open, 0.0_wp, &
         0.0_wp, 0.0_wp, 0.0_wp)
   end subroutine pass_centre

   !> Force beyond the strength that a contact loses by breaking, over that strength.
   pure real(wp) function excess(contacts, law, c, state, response, intact)
      type(contacts_type), intent(in) :: contacts     !< this step's list
      class(joint_law_type), intent(in) :: law        !< of the contact
      integer, intent(in) :: c                        !< number of the contact
      type(joint_state_type), intent(in) :: state     !< of the contact
      type(response_type), intent(in) :: response     !< its forces
      logical, intent(in) :: intact                   !< it breaks rather than slips
      real(wp) :: tension

      excess = 0.0_wp
      tension = law%tension(state)
      if (contacts%bonded(c)) excess = -response%normal_force - tension
      if (intact) excess = max(excess, abs(response%shear_force) - response%bound)
      excess = excess/max(tension, response%bound, tiny(1.0_wp))
   end function excess

   !> The forces of a contact that slides as assumed: the shear force in a given direction at the
   !> normal force of its line, and that line with the lift of the slip.
   pure subroutine slide_response(contacts, law, c, gap, stretch, shear_force, lifted)
      type(contacts_type), intent(in) :: contacts  !< this step's list
      class(joint_law_type), intent(in) :: law     !< of the contact
      integer, intent(in) :: c                     !< number of the contact
      real(wp), intent(in) :: gap, stretch         !< at the end of the step, m
      real(wp), intent(out) :: shear_force         !< N/m
      real(wp), intent(out) :: lifted              !< `normal_free` that belongs to it, N/m
      type(joint_state_type) :: state
      real(wp) :: normal_force

      state = assumed_state(contacts, law, c)
      state%way = contacts%slip_sign(c)
      lifted = contacts%normal_free(c)
      normal_force = lifted - contacts%tangent(c)*gap
      if (slip_lifts(contacts, law, c)) then
         normal_force = law%sliding_force(state, law%lift(state) - gap, &
            max(0.0_wp, contacts%slip_sign(c)*(stretch + centre_shift(contacts, c))))
         lifted = normal_force + contacts%tangent(c)*gap
      end if
      shear_force = contacts%slip_sign(c)*law%strength(state, normal_force)
   end subroutine slide_response

   !> The line that touches the law at a closure, with the lift at the start of the step.
   pure subroutine touch_law(contacts, law, c, closure, tangent, normal_free)
      type(contacts_type), intent(in) :: contacts        !< this step's list
      class(joint_law_type), intent(in) :: law           !< of the contact
      integer, intent(in) :: c                           !< number of the contact
      real(wp), intent(in) :: closure                    !< m
      real(wp), intent(out) :: tangent, normal_free      !< N/m; N = normal_free − tangent × gap
      type(joint_state_type) :: state

      state = assumed_state(contacts, law, c)
      tangent = law%tangent(state, closure)
      normal_free = law%normal_force(state, closure) + tangent*(law%lift(state) - closure)
   end subroutine touch_law

   !> The line for the next iteration, after a solution at which the law gives a response.
   pure subroutine line_of(contacts, law, c, gap, response, tangent, normal_free)
      type(contacts_type), intent(in) :: contacts        !< this step's list
      class(joint_law_type), intent(in) :: law           !< of the contact
      integer, intent(in) :: c                           !< number of the contact
      real(wp), intent(in) :: gap                        !< at which the contact acts, m
      type(response_type), intent(in) :: response        !< of the law
      real(wp), intent(out) :: tangent, normal_free      !< N/m; N = normal_free − tangent × gap
      real(wp) :: closure, expected

      closure = law%lift(assumed_state(contacts, law, c)) - gap
      if (law%curved) then
         expected = contacts%normal_free(c) - contacts%tangent(c)*gap
         if (contacts%state(c) == contact_open) &
            expected = first_share*law%initial_spring(state_of(contacts, c))*closure
         if (expected > 0.0_wp .and. closure > 0.0_wp) &
            closure = min(closure, law%closure(state_of(contacts, c), expected))
      end if
      call touch_law(contacts, law, c, max(closure, 0.0_wp), tangent, normal_free)
      if (response%state == contact_slide .and. law%dilates) &
         normal_free = response%normal_force + tangent*gap
   end subroutine line_of

   !> Energy of the springs of contact c, J per metre of thickness.
   pure real(wp) function joint_energy(law, state, closure, stretch, closed)
      class(joint_law_type), intent(in) :: law     !< of the contact
      type(joint_state_type), intent(in) :: state  !< of the contact
      real(wp), intent(in) :: closure, stretch     !< m
      logical, intent(in) :: closed                !< the normal spring holds

      if (law%cohesive) then
         joint_energy = 0.5_wp*law%initial_spring(state)*max(closure, 0.0_wp)**2 &
            + 0.5_wp*law%shear_spring(state)*stretch**2
         if (state%weakened < 1.0_wp) joint_energy = joint_energy + (1.0_wp - state%weakened) &
            *(0.5_wp*law%initial_spring(state)*min(closure, 0.0_wp)**2 &
            + 0.5_wp*law%shear_spring(state)*((stretch + state%net_slip)**2 - stretch**2))
         return
      end if
      joint_energy = 0.5_wp*law%shear_spring(state)*stretch**2
      if (closed) joint_energy = joint_energy + law%stored(state, closure)
   end function joint_energy

end module dda_joint_contact
