! SPDX-License-Identifier: GPL-3.0-or-later
!> Joint laws: forces of a contact as functions of the closure of its joint and of the stretch of
!> its shear spring.
!>
!> All laws: the closure x is the penetration plus the lift by dilation, and 0 at zero force;
!> the normal force has a convex potential `stored`; the shear force is elastic up to `strength`,
!> which depends on the normal force.  A law overrides the procedures that differ.  The stiffness is
!> a stiffness of a contact, or a stiffness per area that is multiplied by the tributary length.
module dda_joint_law
   use dda_kinds, only: wp, pi
   use dda_material, only: joint_type
   implicit none
   private
   public :: joint_law_type, joint_state_type, column_type, response_type, strength_type, &
      divided_strengths, reduced_angle, add_columns, shared, slip_path, weakened, net_slip

   real(wp), parameter :: steepest = 89.0_wp  !< largest friction angle of an input, degrees

   integer, parameter :: most_law_columns = 4  !< columns of a law in addition to the shared ones
   ! Columns of every law; `net_slip` only in laws that depend on the direction of slip
   integer, parameter :: slip_path = 1, weakened = 2, net_slip = 3

   !> A variable that a law stores for each contact: a column of the memory of contacts, of
   !> checkpoints and of the output, whose schema gives its unit and meaning.
   type :: column_type
      character(len=24) :: name            !< name in the output, after `contact_`
      real(wp) :: initial = 0.0_wp         !< initial value without a history
      logical :: of_contact = .false.  !< not copied to new points of an overlap
      real(wp) :: limit = huge(1.0_wp)     !< limit above which results are uncertain
      character(len=96) :: advice = ''     !< reason, and what to do
   end type column_type

   type(column_type), parameter :: shared(3) = [column_type('slip_path'), &
      column_type('weakened', initial=1.0_wp), column_type('net_slip')]

   !> State of a contact as input of its law.
   type :: joint_state_type
      real(wp) :: length     !< tributary length, m
      real(wp) :: stiffness_fraction = 1.0_wp  !< fraction of the stiffness of a contact
      real(wp) :: slip_sign = 1.0_wp  !< direction of slip, sign of the shear force
      logical :: bonded = .false.         !< the bond is intact
      logical :: was_closed = .false.     !< the normal spring acted at the start of the step
      logical :: lifts = .false.          !< slip in this step lifts the contact
      logical :: past_centre = .false.    !< slip is assumed to pass zero net slip
      integer :: close_count = 0          !< number of closings in this step's iteration
      !> frozen friction, N/m, or frozen normal force of laws with dilation or a curve of slip; < 0:
      !> none is frozen
      real(wp) :: frozen_bound = -1.0_wp
      real(wp) :: frozen = -1.0_wp !< frozen normal force if slip lifts the contact, N/m, else < 0
      real(wp) :: lifting = 1.0_wp !< with a frozen force, fraction of the slip that lifts
      real(wp) :: memory(most_law_columns + 3) = 0.0_wp  !< memory of the law for this contact
      real(wp) :: stretch = 0.0_wp       !< stretch of the shear spring at the start of the step, m
      real(wp) :: time_step = 0.0_wp     !< Δt, s; 0: static
      real(wp) :: normal_force = 0.0_wp  !< normal force at the end of a solved step, N/m
      real(wp) :: closure = 0.0_wp       !< closure at the end of a solved step, without the lift, m
   end type joint_state_type

   !> State and forces at a gap and a slip.
   type :: response_type
      integer :: state = 0                  !< open, slide or stick
      real(wp) :: normal_force = 0.0_wp     !< compression positive, N/m
      real(wp) :: shear_force = 0.0_wp      !< k_s × elastic stretch, within the bound, N/m
      real(wp) :: bound = 0.0_wp            !< largest shear force, N/m
      !> (force − strength)/strength; ≤ 0: intact
      real(wp) :: strength_ratio = 0.0_wp
      real(wp) :: slider = 0.0_wp      !< friction force without the bond, N/m
      logical :: past_centre = .false. !< slip passes zero net slip
   end type response_type

   !> A variable of &joint on which the strength depends.
   type :: strength_type
      character(len=32) :: name      !< name in the input
      real(wp) :: value              !< value in the unit of the input
      logical :: is_angle = .false.  !< the strength is proportional to the tangent of the value
   end type strength_type

   !> A joint law with the parameters of a joint material.
   type, abstract :: joint_law_type
      real(wp) :: normal_stiffness = 0.0_wp  !< stiffness at small closure, N/m, or Pa/m per area
      real(wp) :: shear_stiffness = 0.0_wp   !< N/m, or Pa/m per area
      logical :: normal_per_area = .false.
      logical :: shear_per_area = .false.
      logical :: brittle = .false.           !< an intact contact sticks until it breaks
      logical :: curved = .false.            !< the normal force is not linear in the closure
      logical :: dilates = .false.           !< slip lifts the contact
      logical :: crushes = .false.           !< plastic closure lowers the contact
      logical :: has_centre = .false.        !< slip away from and towards zero net slip differ
      logical :: has_slip_curve = .false.    !< the shear force is a curve of slip, see `flow`
      logical :: cohesive = .false.   !< a bond parallel to the contact is damaged gradually
      integer :: points = 2                  !< default number of contact points of an overlap
      type(strength_type), allocatable :: inputs(:)  !< variables of &joint that set the strength
      !> further columns of the law in addition to the shared ones; unused entries have no name
      type(column_type) :: law_columns(most_law_columns) = column_type('')
      integer :: columns = 0                     !< columns of memory, including the shared ones
      !> numbers of these columns in the memory of contacts
      integer :: row(most_law_columns + 3) = 0
   contains
      procedure :: depends_on_direction, initial_spring, shear_spring, &
         normal_force => linear_force, tangent => linear_tangent, closure => linear_closure, &
         stored => linear_energy
      procedure(strength_at), deferred :: strength
      procedure :: reduced_strengths => divided_strengths, tension => no_tension, &
         state_after_slip => add_slip_path, lift => no_lift, rise => no_rise, &
         lifting_share => whole_share, sliding_force => force_without_lift, &
         flow => elastic_slip_curve, expected_slip => no_slip, check_and_derive => complete_nothing
   end type joint_law_type

   abstract interface
      !> Return the largest shear force, N/m.
      pure real(wp) function strength_at(law, state, normal_force)
         import :: joint_law_type, joint_state_type, wp
         class(joint_law_type), intent(in) :: law     !< law of the joint
         type(joint_state_type), intent(in) :: state  !< state of the contact
         real(wp), intent(in) :: normal_force         !< compression positive, N/m
      end function strength_at
   end interface

contains

   !> .true. if the law depends on the direction of slip.
   pure logical function depends_on_direction(law)  ! total
      class(joint_law_type), intent(in) :: law  !< law of the joint

      depends_on_direction = law%has_centre .or. law%cohesive
   end function depends_on_direction

   !> Assign the memory of a law to columns of the contacts' memory, after the shared columns.
   !> Variables with equal names share one column.
   pure subroutine add_columns(columns, law)
      type(column_type), allocatable, intent(inout) :: columns(:)  !< columns of the model
      class(joint_law_type), intent(inout) :: law  !< law; receives the numbers of its columns
      type(column_type), allocatable :: law_columns(:)
      integer :: i

      law_columns = [shared(:merge(3, 2, law%depends_on_direction())), pack(law%law_columns, &
         law%law_columns%name /= '')]
      law%columns = size(law_columns)
      do i = 1, size(law_columns)
         if (all(columns%name /= law_columns(i)%name)) columns = [columns, law_columns(i)]
         law%row(i) = findloc(columns%name == law_columns(i)%name, .true., 1)
      end do
   end subroutine add_columns

   !> Check the variables of the law and compute missing ones; default: do nothing.
   pure subroutine complete_nothing(law, joint, shear_ratio, wrong)
      class(joint_law_type), intent(in) :: law       !< law of the joint
      type(joint_type), intent(inout) :: joint       !< input with the variables that the law needs
      real(wp), intent(in) :: shear_ratio           !< k_n/k_s, if the joint does not set its own
      character(len=:), allocatable, intent(out) :: wrong  !< error message, blank if none

      wrong = ''
   end subroutine complete_nothing

   !> Return the strengths of a joint divided by a factor, as values of variables of &joint.
   pure function divided_strengths(law, factor) result(strengths)
      class(joint_law_type), intent(in) :: law  !< law of the joint
      real(wp), intent(in) :: factor            !< above 0
      type(strength_type), allocatable :: strengths(:)

      strengths = law%inputs
      where (strengths%is_angle)
         strengths%value = reduced_angle(strengths%value, factor)
      else where
         strengths%value = strengths%value/factor
      end where
   end function divided_strengths

   !> Return the angle, degrees, whose tangent is tan(friction angle) divided by a factor.
   elemental real(wp) function reduced_angle(angle, factor)
      real(wp), intent(in) :: angle   !< degrees
      real(wp), intent(in) :: factor  !< above 0

      reduced_angle = min(steepest, atan(tan(angle*(pi/180.0_wp))/factor)*(180.0_wp/pi))
   end function reduced_angle

   !> Return the normal stiffness at zero closure, N/m.
   pure real(wp) function initial_spring(law, state) result(spring)
      class(joint_law_type), intent(in) :: law     !< law of the joint
      type(joint_state_type), intent(in) :: state  !< state of the contact

      spring = law%normal_stiffness*merge(state%length, state%stiffness_fraction, &
         law%normal_per_area)
   end function initial_spring

   !> Return the shear stiffness, N/m.
   pure real(wp) function shear_spring(law, state) result(spring)
      class(joint_law_type), intent(in) :: law     !< law of the joint
      type(joint_state_type), intent(in) :: state  !< state of the contact

      spring = law%shear_stiffness*merge(state%length, state%stiffness_fraction, law%shear_per_area)
   end function shear_spring

   !> Return the normal force at a closure, N/m.
   pure real(wp) function linear_force(law, state, closure) result(force)
      class(joint_law_type), intent(in) :: law     !< law of the joint
      type(joint_state_type), intent(in) :: state  !< state of the contact
      real(wp), intent(in) :: closure              !< m

      force = law%initial_spring(state)*closure
   end function linear_force

   !> Return the slope of the normal force, N/m.
   pure real(wp) function linear_tangent(law, state, closure) result(tangent)
      class(joint_law_type), intent(in) :: law     !< law of the joint
      type(joint_state_type), intent(in) :: state  !< state of the contact
      real(wp), intent(in) :: closure              !< m

      tangent = law%initial_spring(state)
   end function linear_tangent

   !> Return the closure at a normal force, m.
   pure real(wp) function linear_closure(law, state, force) result(closure)
      class(joint_law_type), intent(in) :: law     !< law of the joint
      type(joint_state_type), intent(in) :: state  !< state of the contact
      real(wp), intent(in) :: force                !< compression positive, N/m

      closure = force/law%initial_spring(state)
   end function linear_closure

   !> Return the potential of the normal force, J per metre of thickness.
   pure real(wp) function linear_energy(law, state, closure) result(energy)
      class(joint_law_type), intent(in) :: law     !< law of the joint
      type(joint_state_type), intent(in) :: state  !< state of the contact
      real(wp), intent(in) :: closure              !< m

      energy = 0.5_wp*law%initial_spring(state)*closure**2
   end function linear_energy

   !> Return the largest tension of a bonded contact, N/m; default: none.
   pure real(wp) function no_tension(law, state) result(tension)
      class(joint_law_type), intent(in) :: law     !< law of the joint
      type(joint_state_type), intent(in) :: state  !< state of the contact

      tension = 0.0_wp
   end function no_tension

   !> Update the state after an inelastic slip; default: add the slip to the slip path.
   pure type(joint_state_type) function add_slip_path(law, state, slip, shear_force) result(after)
      class(joint_law_type), intent(in) :: law     !< law of the joint
      type(joint_state_type), intent(in) :: state  !< state before the slip
      real(wp), intent(in) :: slip                 !< slip with its sign, m
      real(wp), intent(in) :: shear_force          !< shear force during slip, N/m

      after = state
      after%memory(slip_path) = state%memory(slip_path) + abs(slip)
   end function add_slip_path

   !> Return the lift of the contact by slip, m; default: none.
   pure real(wp) function no_lift(law, state) result(lift)
      class(joint_law_type), intent(in) :: law     !< law of the joint
      type(joint_state_type), intent(in) :: state  !< state of the contact

      lift = 0.0_wp
   end function no_lift

   !> Return the rise of the contact per unit of slip in the direction of `state`; default: none.
   pure real(wp) function no_rise(law, state, slip) result(rise)
      class(joint_law_type), intent(in) :: law     !< law of the joint
      type(joint_state_type), intent(in) :: state  !< state at the start of the step
      real(wp), intent(in) :: slip                 !< inelastic slip, ≥ 0, m

      rise = 0.0_wp
   end function no_rise

   !> Return the fraction of the slip of a step that lifts the contact; default: 1.
   pure real(wp) function whole_share(law, state, slip) result(share)
      class(joint_law_type), intent(in) :: law     !< law of the joint
      type(joint_state_type), intent(in) :: state  !< state at the start of the step
      real(wp), intent(in) :: slip                 !< inelastic slip, ≥ 0, m

      share = 1.0_wp
   end function whole_share

   !> Return the normal force of a sliding contact, N/m, with the lift by the slip of this step.
   pure real(wp) function force_without_lift(law, state, closure, stretch) result(force)
      class(joint_law_type), intent(in) :: law     !< law of the joint
      type(joint_state_type), intent(in) :: state  !< state at the start of the step
      real(wp), intent(in) :: closure  !< closure at the end, without the lift of this step, m
      real(wp), intent(in) :: stretch  !< stretch of the shear spring without slip, ≥ 0, m

      force = law%normal_force(state, closure)
   end function force_without_lift

   !> Find the shear force as a curve of slip, and its slope; default: the spring.
   pure subroutine elastic_slip_curve(law, state, normal_force, stretch, shear_force, tangent)
      class(joint_law_type), intent(in) :: law            !< law of the joint
      type(joint_state_type), intent(in) :: state         !< state at the start of the step
      real(wp), intent(in) :: normal_force                !< ≥ 0, N/m
      real(wp), intent(in) :: stretch  !< stretch of the shear spring without slip, m
      real(wp), intent(out) :: shear_force, tangent       !< N/m; tangent ≥ 0, N/m per m

      tangent = law%shear_spring(state)
      shear_force = tangent*stretch
   end subroutine elastic_slip_curve

   !> Return the first guess of the slip in this step, m; default: none.
   pure real(wp) function no_slip(law, state) result(slip)
      class(joint_law_type), intent(in) :: law     !< law of the joint
      type(joint_state_type), intent(in) :: state  !< state at the start of the step

      slip = 0.0_wp
   end function no_slip

end module dda_joint_law
