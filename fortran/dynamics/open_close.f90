!> Open–close iteration: find the contact states that the solution itself calls for.
!>
!> Assume states, solve, see what each contact answers, change, repeat.  Both open–closed and
!> slip–stick changes count.  Convergence is judged by force: the largest difference between the
!> force that was assumed in a contact and the one that its law answers.
module dda_open_close
   use dda_kinds, only: wp
   use dda_errors, only: error_type, error_convergence, fail
   use dda_system, only: system_type
   use dda_contact, only: contacts_type, contact_open, contact_slide, contact_stick
   use dda_contact_assembly, only: assemble_contacts
   use dda_cycles, only: cycle_type, note_states, may_change
   use dda_friction, only: laws_type, response_type, law_of, respond
   use dda_line_search, only: descend
   use dda_rank_one, only: rank_one_type, forget_changes, note_many
   use dda_ordered_sums, only: pieces, first_of, last_of, parallel_from
   use dda_slide_forces, only: slides_type, list_slides, ask_slides, difference_of, farthest_off, &
      follow
   use dda_linear_solver, only: solver_type, renew, solve
   use dda_spring_changes, only: note_change
   use dda_stopwatch, only: lap, phase_factorise, phase_solve
   implicit none
   private
   public :: iteration_type, close_contacts, solve_assumed, measure_contacts, assumed_normal, &
      assumed_shear

   real(wp), parameter :: short_way = 0.5_wp      !< part left of a way that overshot
   real(wp), parameter :: very_short_way = 0.1_wp
   integer, parameter :: most_closings = 8       !< after which a contact that closes slides first
   !> solves for the slide forces while states are held
   integer, parameter :: most_follow = 60
   !> share of a system's first residual that is enough before the last solve
   real(wp), parameter :: loose = 1.0e-2_wp
   !> of their first difference, before states are asked again
   real(wp), parameter :: follow_share = 0.05_wp
   !> then one whole way, over whatever holds the search up
   integer, parameter :: most_short_ways = 6
   !> share of the shear springs to begin with
   real(wp), parameter :: least_kept = 0.01_wp

   !> Settings and outcome of the iteration of one step.
   type :: iteration_type
      integer :: max_iterations = 400
      real(wp) :: relative_tolerance = 1.0e-9_wp   !< of the largest force
      real(wp) :: weight = 0.0_wp                  !< largest block weight, N/m
      !> contact force that rounding of places makes, N/m
      real(wp) :: noise = 0.0_wp
      integer :: iterations = 0                    !< solves of this step
      integer :: changes = 0                       !< states changed in this step
      integer :: broken = 0                        !< bonds broken in this step
      real(wp) :: residual = 0.0_wp                !< largest force difference, N/m
      real(wp) :: tolerance = 0.0_wp               !< that it had to reach
      !> ways in a row that had to be shortened very much
      integer :: short_ways = 0
      integer :: worst = 0                         !< contact with that difference
      !> m; > 0: augmented Lagrangian, else penalty alone
      real(wp) :: penetration_tolerance = 0.0_wp
      !> share of the shear springs under sliding contacts
      real(wp) :: kept = 0.0_wp
      !> `loose` where the next solve is not likely to be the last
      real(wp) :: reduction = 0.0_wp
      !> that the next matrix has more or less than the last
      type(rank_one_type) :: springs
      type(slides_type) :: slides                  !< contacts that slide, whose forces follow
      type(cycle_type) :: past                     !< states that have been assumed in this step
   end type iteration_type

contains

   !> Iterate until every contact answers what it was assumed to do.
   subroutine close_contacts(iteration, system, solver, contacts, laws, error)
      type(iteration_type), intent(inout) :: iteration
      type(system_type), intent(inout) :: system
      type(solver_type), intent(inout) :: solver
      type(contacts_type), intent(inout) :: contacts
      type(laws_type), intent(in) :: laws
      type(error_type), allocatable, intent(out) :: error
      integer :: changed, runaway, i
      logical :: new_matrix, tightened, exactly

      call begin_iteration(iteration, contacts)
      exactly = .not. any(contacts%state(:contacts%n) == contact_slide)
      if (.not. exactly) iteration%reduction = loose
      new_matrix = .true.
      do i = 1, iteration%max_iterations
         iteration%iterations = i
         call solve_assumed(iteration, system, solver, contacts, laws, new_matrix, error)
         if (allocated(error)) return
         call follow_normal_forces(iteration, system, solver, contacts, laws, exactly, runaway, &
            error)
         if (allocated(error)) return
         call lap(system%watch, phase_solve)
         if (runaway > 0) then
            call hold(iteration, system, contacts, laws, runaway)
            new_matrix = .true.
            exactly = .false.
            cycle
         end if
         call ask_contacts(iteration, system%d, contacts, laws)
         if (iteration%residual <= iteration%tolerance) call finish_solve(iteration, system, &
            solver, contacts, laws, error)
         if (allocated(error)) return
         iteration%reduction = loose
         if (iteration%residual <= iteration%tolerance) then
            call break_bonds(iteration, contacts, changed)
            if (changed == 0) call tighten(iteration, contacts, tightened)
            if (changed == 0 .and. .not. tightened) return
         end if
         call globalise(iteration, system, contacts, laws, new_matrix)
         call adopt_answers(iteration, contacts, laws, changed)
         new_matrix = new_matrix .or. changed > 0
         exactly = changed == 0
         iteration%changes = iteration%changes + changed
      end do
      call fail(error, error_convergence, 'the open–close iteration does not converge')
   end subroutine close_contacts

   pure subroutine begin_iteration(iteration, contacts)
      type(iteration_type), intent(inout) :: iteration
      type(contacts_type), intent(inout) :: contacts

      iteration%iterations = 0
      iteration%changes = 0
      iteration%broken = 0
      iteration%kept = 0.0_wp
      iteration%reduction = 0.0_wp
      iteration%short_ways = 0
      iteration%past = cycle_type()
      iteration%worst = 0  ! of the last step's list
      call forget_changes(iteration%springs)
      contacts%close_count(:contacts%n) = 0
   end subroutine begin_iteration

   !> Where states change, do not go up: shorten the way from the last d if the energy rises on it.
   !>
   !> A way that had to be shortened much overshot in contacts that slide freely and are then found
   !> to stick; they keep a growing part of their shear springs until the way is good again.
   subroutine globalise(iteration, system, contacts, laws, new_matrix)
      type(iteration_type), intent(inout) :: iteration
      type(system_type), intent(inout) :: system
      type(contacts_type), intent(inout) :: contacts
      type(laws_type), intent(in) :: laws
      logical, intent(out) :: new_matrix  !< the part that is kept has changed
      real(wp) :: part, before
      logical :: overshot

      new_matrix = .false.
      if (iteration%iterations == 1) return
      part = 1.0_wp
      overshot = any(contacts%state(:contacts%n) == contact_slide &
         .and. contacts%trial_state(:contacts%n) == contact_stick)
      if (iteration%short_ways < most_short_ways .and. &
         any(contacts%trial_state(:contacts%n) /= contacts%state(:contacts%n))) then
         call descend(system, contacts, laws, part)
         if (part < 1.0_wp) call ask_contacts(iteration, system%d, contacts, laws)
      end if
      iteration%short_ways = merge(iteration%short_ways + 1, 0, part < very_short_way)
      before = iteration%kept
      if (part < short_way .and. overshot) iteration%kept = min(1.0_wp, max(least_kept, 3*before))
      if (part > short_way) iteration%kept = before/10
      if (iteration%kept < 0.1_wp*least_kept) iteration%kept = 0.0_wp
      new_matrix = iteration%kept /= before
      if (new_matrix) call note_many(iteration%springs)
   end subroutine globalise

   !> Solve for d with the contacts in their assumed states.
   subroutine solve_assumed(iteration, system, solver, contacts, laws, new_matrix, error)
      type(iteration_type), intent(inout) :: iteration
      type(system_type), intent(inout) :: system
      type(solver_type), intent(inout) :: solver
      type(contacts_type), intent(in) :: contacts
      type(laws_type), intent(in) :: laws
      !> .false. if only slide forces changed since the last solve
      logical, intent(in) :: new_matrix
      type(error_type), allocatable, intent(out) :: error

      call assemble_contacts(system, contacts, laws%normal_stiffness, laws%shear_stiffness, &
         iteration%kept)
      if (new_matrix) call renew(solver, system%matrix, system%base, iteration%springs, error)
      if (allocated(error)) return
      call forget_changes(iteration%springs)
      call lap(system%watch, phase_factorise)
      system%previous_d = system%d
      call solve(solver, system%matrix, system%rhs, system%d, error, iteration%reduction)
      call lap(system%watch, phase_solve)
   end subroutine solve_assumed

   !> A solve that was stopped early has led to answers within the tolerance: make it exact, and ask
   !> again.
   subroutine finish_solve(iteration, system, solver, contacts, laws, error)
      type(iteration_type), intent(inout) :: iteration
      type(system_type), intent(inout) :: system
      type(solver_type), intent(inout) :: solver
      type(contacts_type), intent(inout) :: contacts
      type(laws_type), intent(in) :: laws
      type(error_type), allocatable, intent(out) :: error

      if (solver%exact) return
      call solve(solver, system%matrix, system%rhs, system%d, error)
      if (.not. allocated(error)) call ask_contacts(iteration, system%d, contacts, laws)
   end subroutine finish_solve

   !> While the states are held, let the slide forces follow the normal forces of the same solution.
   subroutine follow_normal_forces(iteration, system, solver, contacts, laws, exactly, runaway, &
      error)
      type(iteration_type), intent(inout) :: iteration
      type(system_type), intent(inout) :: system
      type(solver_type), intent(inout) :: solver
      type(contacts_type), intent(inout) :: contacts
      type(laws_type), intent(in) :: laws
      logical, intent(in) :: exactly  !< to the tolerance, else to a share of the first difference
      integer, intent(out) :: runaway !< contact whose slide force finds no rest, else 0
      type(error_type), allocatable, intent(out) :: error
      real(wp) :: difference, wanted, enough
      integer :: i

      runaway = 0
      call list_slides(iteration%slides, contacts)
      if (iteration%slides%n == 0) return
      wanted = iteration%tolerance
      do i = 1, most_follow
         call ask_slides(iteration%slides, contacts, laws, system%d)
         difference = difference_of(iteration%slides)
         if (i == 1 .and. .not. exactly) wanted = max(wanted, follow_share*difference)
         enough = loose
         if (difference > wanted) then
            call follow(iteration%slides, contacts, system)
         else if (exactly .and. .not. solver%exact) then
            enough = 0.0_wp
         else
            return
         end if
         call solve(solver, system%matrix, system%rhs, system%d, error, enough)
         if (allocated(error)) return
      end do
      runaway = farthest_off(iteration%slides)
   end subroutine follow_normal_forces

   !> Stick the contact whose slide force runs away from its normal force: sliding as assumed has no
   !> solution, which happens where friction is high enough to lock.  The solution that ran away is
   !> dropped.
   pure subroutine hold(iteration, system, contacts, laws, runaway)
      type(iteration_type), intent(inout) :: iteration
      type(system_type), intent(inout) :: system
      type(contacts_type), intent(inout) :: contacts
      type(laws_type), intent(in) :: laws
      integer, intent(in) :: runaway

      call note_change(iteration%springs, contacts, laws, runaway, contact_stick)
      contacts%state(runaway) = contact_stick
      contacts%slide_force(:contacts%n) = 0.0_wp
      system%d = system%previous_d
   end subroutine hold

   !> What each contact answers to d, and how far that is from what was assumed.
   subroutine ask_contacts(iteration, d, contacts, laws)
      type(iteration_type), intent(inout) :: iteration
      real(wp), intent(in), contiguous :: d(:,:)
      type(contacts_type), intent(inout) :: contacts
      type(laws_type), intent(in) :: laws
      real(wp) :: largest, residual
      integer :: p

      call measure_contacts(contacts, d)
      residual = 0.0_wp
      largest = iteration%weight
      if (contacts%n < parallel_from) then
         call ask_some(iteration, contacts, laws, 1, contacts%n, largest, residual)
      else
         !$omp parallel do reduction(max:largest, residual) schedule(static)
         do p = 1, pieces(contacts%n)
            call ask_some(iteration, contacts, laws, first_of(p, contacts%n), &
               last_of(p, contacts%n), largest, residual)
         end do
      end if
      iteration%residual = residual
      iteration%worst = 0
      if (residual > 0.0_wp) iteration%worst = maxloc(contacts%force_residual(:contacts%n), 1)
      iteration%tolerance = max(iteration%relative_tolerance*largest, iteration%noise)
   end subroutine ask_contacts

   !> What some contacts answer; the largest force and the largest difference grow.
   pure subroutine ask_some(iteration, contacts, laws, first, last, largest, residual)
      type(iteration_type), intent(in) :: iteration
      type(contacts_type), intent(inout) :: contacts
      type(laws_type), intent(in) :: laws
      integer, intent(in) :: first, last
      real(wp), intent(inout) :: largest, residual
      type(response_type) :: response
      integer :: c

      do c = first, last
         response = respond(law_of(laws, contacts%joint(c), contacts%bonded(c), &
            contacts%bond_length(c), contacts%multiplier(c)), contacts%new_gap(c), &
            contacts%stretch(c) + contacts%slip(c))
         contacts%force_residual(c) = &
            max(abs(response%normal_force - assumed_normal(contacts, laws, c)), &
            abs(response%shear_force - assumed_shear(iteration, contacts, laws, c)))
         residual = max(residual, contacts%force_residual(c))
         contacts%trial_state(c) = next_state(contacts, response, c)
         contacts%normal_force(c) = response%normal_force
         contacts%shear_force(c) = response%shear_force
         contacts%strength_ratio(c) = response%strength_ratio
         largest = max(largest, abs(response%normal_force), abs(response%shear_force))
      end do
   end subroutine ask_some

   !> The state to assume next.  Slip that turns round sticks first: the trial from the other bound
   !> would otherwise jump between the two bounds for ever.  A contact that closes again and again
   !> slides first: stuck, its shear force would pull it open each time.
   pure integer function next_state(contacts, response, c)
      type(contacts_type), intent(in) :: contacts
      type(response_type), intent(in) :: response
      integer, intent(in) :: c

      next_state = response%state
      if (contacts%state(c) == contact_slide .and. response%state == contact_slide &
         .and. response%shear_force*contacts%slip_sign(c) < 0.0_wp) next_state = contact_stick
      if (contacts%state(c) /= contact_open .or. contacts%close_count(c) < most_closings &
         .or. contacts%bonded(c)) return
      if (response%state == contact_stick) next_state = contact_slide
   end function next_state

   !> Gap and slip of all contacts at d.
   subroutine measure_contacts(contacts, d)
      type(contacts_type), intent(inout) :: contacts
      real(wp), intent(in), contiguous :: d(:,:)
      integer :: p

      if (contacts%n < parallel_from) then
         call measure_some(contacts, d, 1, contacts%n)
         return
      end if
      !$omp parallel do schedule(static)
      do p = 1, pieces(contacts%n)
         call measure_some(contacts, d, first_of(p, contacts%n), last_of(p, contacts%n))
      end do
   end subroutine measure_contacts

   pure subroutine measure_some(contacts, d, first, last)
      type(contacts_type), intent(inout) :: contacts
      real(wp), intent(in), contiguous :: d(:,:)
      integer, intent(in) :: first, last
      integer :: c

      do c = first, last
         associate (d_v => d(:, contacts%block_v(c)), d_e => d(:, contacts%block_e(c)))
            contacts%new_gap(c) = contacts%gap(c) + dot_product(contacts%normal_v(:, c), d_v) &
               - dot_product(contacts%normal_e(:, c), d_e)
            contacts%slip(c) = dot_product(contacts%shear_v(:, c), d_v) &
               - dot_product(contacts%shear_e(:, c), d_e)
         end associate
      end do
   end subroutine measure_some

   !> Normal force that the solve assumed in contact c.
   pure real(wp) function assumed_normal(contacts, laws, c)
      type(contacts_type), intent(in) :: contacts
      type(laws_type), intent(in) :: laws
      integer, intent(in) :: c

      assumed_normal = 0.0_wp
      if (contacts%state(c) /= contact_open) assumed_normal = contacts%multiplier(c) - &
         laws%normal_stiffness*contacts%new_gap(c)
   end function assumed_normal

   !> Shear force that the solve assumed in contact c.
   pure real(wp) function assumed_shear(iteration, contacts, laws, c)
      type(iteration_type), intent(in) :: iteration
      type(contacts_type), intent(in) :: contacts
      type(laws_type), intent(in) :: laws
      integer, intent(in) :: c

      assumed_shear = 0.0_wp
      if (contacts%state(c) == contact_stick) assumed_shear = &
         laws%shear_stiffness*(contacts%stretch(c) + contacts%slip(c))
      if (contacts%state(c) == contact_slide) assumed_shear = contacts%slide_force(c) &
         + iteration%kept*laws%shear_stiffness*(contacts%slip(c) - contacts%slide_slip(c))
   end function assumed_shear

   !> Break the bonds that the converged solution overloads; the iteration then goes on without
   !> them.
   subroutine break_bonds(iteration, contacts, broken)
      type(iteration_type), intent(inout) :: iteration
      type(contacts_type), intent(inout) :: contacts
      integer, intent(out) :: broken
      integer :: c

      broken = 0
      do c = 1, contacts%n
         if (.not. contacts%bonded(c) .or. contacts%strength_ratio(c) <= 0.0_wp) cycle
         contacts%bonded(c) = .false.
         broken = broken + 1
      end do
      iteration%broken = iteration%broken + broken
   end subroutine break_bonds

   !> Contacts that press must neither penetrate nor gape beyond the tolerance, if there is one;
   !> where they do, the multipliers take over the forces.
   !>
   !> Augmented Lagrangian by Uzawa's iteration: the next solve starts from contacts that already
   !> press.
   subroutine tighten(iteration, contacts, tightened)
      type(iteration_type), intent(in) :: iteration
      type(contacts_type), intent(inout) :: contacts
      logical, intent(out) :: tightened  !< the multipliers have changed
      integer :: c

      tightened = .false.
      if (iteration%penetration_tolerance <= 0.0_wp) return
      tightened = any(abs(contacts%new_gap(:contacts%n)) > iteration%penetration_tolerance .and. &
         contacts%state(:contacts%n) /= contact_open .and. .not. contacts%bonded(:contacts%n))
      if (.not. tightened) return
      do c = 1, contacts%n
         if (.not. contacts%bonded(c)) contacts%multiplier(c) &
            = max(0.0_wp, contacts%normal_force(c))
      end do
   end subroutine tighten

   !> Assume what the contacts answered; note the springs and count the states that change.
   pure subroutine adopt_answers(iteration, contacts, laws, changed)
      type(iteration_type), intent(inout) :: iteration
      type(contacts_type), intent(inout) :: contacts
      type(laws_type), intent(in) :: laws
      integer, intent(out) :: changed
      integer :: n, c

      n = contacts%n
      changed = 0
      call note_states(iteration%past, contacts%state(:n))
      do c = 1, n
         if (.not. may_change(iteration%past, c)) contacts%trial_state(c) = contacts%state(c)
         if (contacts%trial_state(c) == contacts%state(c)) cycle
         changed = changed + 1
         call note_change(iteration%springs, contacts, laws, c, contacts%trial_state(c))
      end do
      where (contacts%state(:n) == contact_open .and. contacts%trial_state(:n) /= contact_open) &
         contacts%close_count(:n) = contacts%close_count(:n) + 1
      contacts%state(:n) = contacts%trial_state(:n)
      contacts%slide_slip(:n) = contacts%slip(:n)
      contacts%slide_force(:n) = contacts%shear_force(:n)
      contacts%slip_sign(:n) = sign(1.0_wp, contacts%shear_force(:n))
   end subroutine adopt_answers

end module dda_open_close
