!> What gravity closes: a copy of a simulation is let down statically until its contacts are steady.
!>
!> Velocities are dropped after each step (dynamic factor 0), so each step goes towards equilibrium
!> and the larger Δt, the farther.  Only gravity and initial stress act: loads and motions are left
!> out.
module dda_equilibrium
   use dda_kinds, only: wp, long
   use dda_elements, only: set_elements
   use dda_errors, only: error_type
   use dda_scheme, only: scheme_type
   use dda_contact, only: contacts_type
   use dda_model, only: half_size
   use dda_kinematics, only: farthest_move
   use dda_simulation, only: simulation_type
   use dda_time_step, only: advance
   use dda_support, only: load_type
   use dda_text, only: to_text
   implicit none
   private
   public :: equilibrium_type, equilibrate

   !> How the equilibrium went.
   type :: equilibrium_type
      integer :: steps = 0
      logical :: steady = .false.        !< contact states stay and nothing moves any more
      real(wp) :: last_move = 0.0_wp     !< of the last step, m
      character(len=:), allocatable :: words
   end type equilibrium_type

   integer, parameter :: most_steps = 100
   integer(long), parameter :: most_iterations = 5000  !< open–close iterations in all
   !> of half the model size, a move that no equilibrium makes
   real(wp), parameter :: fall = 1.0_wp
   integer, parameter :: quiet_steps = 2               !< in a row, to be steady
   !> of the contact distance, free fall in the first step
   real(wp), parameter :: first_fall = 1.0e-3_wp
   !> of half the model size, a move that counts as none
   real(wp), parameter :: quiet = 1.0e-7_wp
   !> of the first Δt: quiet means something from here on
   real(wp), parameter :: long_step = 1.0e2_wp
   real(wp), parameter :: longest_step = 1.0e4_wp      !< of the first Δt
   real(wp), parameter :: growth = 10.0_wp             !< of Δt after a good step

contains

   !> Settle a copy.  One that cannot come to rest is not an error: the words say it.
   subroutine equilibrate(settled, simulation, equilibrium)
      type(simulation_type), intent(out) :: settled
      type(simulation_type), intent(in) :: simulation
      type(equilibrium_type), intent(out) :: equilibrium
      type(error_type), allocatable :: error
      real(wp) :: first_step, quiet_move
      integer :: still
      logical :: same, still_long

      settled = simulation
      settled%counters%iterations = 0
      call leave_only_gravity(settled, first_step)
      quiet_move = quiet*half_size(settled%blocks)
      still = 0
      do while (equilibrium%steps < most_steps .and. still < quiet_steps)
         still_long = settled%time_step >= long_step*first_step
         call try_step(settled, first_step, same, error)
         if (allocated(error) .or. settled%counters%iterations > most_iterations) exit
         equilibrium%steps = equilibrium%steps + 1
         equilibrium%last_move = farthest_move(settled%blocks, settled%system%d)
         if (equilibrium%last_move > fall*half_size(simulation%blocks)) exit
         still = merge(still + 1, 0, same .and. still_long .and. equilibrium%last_move &
            <= quiet_move)
      end do
      equilibrium%steady = still >= quiet_steps
      equilibrium%words = 'settled under gravity in '//to_text(equilibrium%steps)//' static steps'
      if (equilibrium%steady) return
      equilibrium%words = 'not at rest under gravity after '//to_text(equilibrium%steps)// &
         ' static steps: the last one moves a vertex by '//to_text(equilibrium%last_move)//' m'
      if (allocated(error)) equilibrium%words = equilibrium%words//'; then '//error%message
   end subroutine equilibrate

   !> No motions, no loads, no velocities; a first Δt in which nothing can fall far.
   subroutine leave_only_gravity(settled, first_step)
      type(simulation_type), intent(inout) :: settled
      real(wp), intent(out) :: first_step
      real(wp) :: gravity
      type(load_type), allocatable :: no_loads(:)
      integer :: i

      allocate (no_loads(0))
      call move_alloc(no_loads, settled%model%loads)
      settled%model%control%base_motion = 0
      do i = 1, size(settled%model%fixed_points)
         settled%model%fixed_points(i)%motion = 0
      end do
      settled%model%control%dynamic_factor = 0.0_wp
      settled%model%control%adaptive = .false.
      settled%blocks%velocity = 0.0_wp
      settled%speed = 0.0_wp
      gravity = norm2(settled%model%control%gravity)
      first_step = settled%model%control%time_step
      if (gravity > 0.0_wp) first_step = sqrt(2.0_wp*first_fall*settled%detection%least/gravity)
      settled%time_step = first_step
      settled%scheme = scheme_type()  ! others overshoot in static steps
      settled%laws%theta = settled%scheme%theta
      call set_elements(settled%elements, settled%model)
   end subroutine leave_only_gravity

   !> One static step, with a smaller Δt if it fails (which leaves the blocks in place) and a larger
   !> one after success.
   subroutine try_step(settled, first_step, same, error)
      type(simulation_type), intent(inout) :: settled
      real(wp), intent(in) :: first_step
      logical, intent(out) :: same  !< no contact has changed its state
      type(error_type), allocatable, intent(out) :: error
      real(wp), parameter :: least = 1.0e-3_wp
      type(contacts_type) :: old

      old = settled%contacts(settled%now)
      do
         settled%speed = 0.0_wp
         call advance(settled, error)
         if (.not. allocated(error) .or. settled%time_step < least*first_step) exit
         settled%time_step = 0.25_wp*settled%time_step
      end do
      same = same_states(old, settled%contacts(settled%now))
      settled%time_step = min(growth*settled%time_step, longest_step*first_step)
   end subroutine try_step

   pure logical function same_states(old, new)
      type(contacts_type), intent(in) :: old, new

      same_states = old%n == new%n
      if (same_states) same_states = all(old%state(:old%n) == new%state(:new%n))
   end function same_states

end module dda_equilibrium
