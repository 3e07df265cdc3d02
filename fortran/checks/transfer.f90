!> Exact transfer functions of the linearised model between two measured points, for base motion.
!>
!> A base that moves by g carries the model along its static answer x_s g; what is left obeys
!> (K + cM) x = −c M x_s g, where the scheme puts c (`dda_scheme`) in place of −ω².  Motion given as
!> a body force has x_s = a unit translation and ω² M x_s g on the right.  In modes φ_j,
!>
!>     x = x_s + a Σ φ_j p_j / (λ_j + c),  p_j = φ_jᵀMx_s,  a = −c or ω²,
!>
!> with all modes of a small model, and the Ritz vectors of the load (`dda_ritz`) of a large one.
module dda_transfer
   use dda_kinds, only: wp, pi
   use dda_cholesky_double, only: solve
   use dda_eigen, only: eigenpairs_type, all_eigenvalues, shifted_inverse_type, prepare_inverse
   use dda_errors, only: error_type, error_input, fail
   use dda_linear_model, only: linear_model_type, point_row
   use dda_mass_factor, only: from_places, to_places
   use dda_ritz, only: ritz_type, start_ritz, extend_ritz, solve_ritz
   use dda_scheme, only: inertia_factor
   use dda_springs, only: spring_fixed
   use dda_text, only: to_text
   implicit none
   private
   public :: transfer_type, peak_type, prepare_transfer
   public :: transfer_at, undamped_transfer_at, transfer_error, transfer_peak

   !> A transfer function, ready to be evaluated.
   type :: transfer_type
      real(wp) :: time_step = 0.0_wp         !< Δt, s
      real(wp) :: dynamic_factor = 1.0_wp
      logical :: body_force = .false.        !< base motion as acceleration in the frame of the base
      real(wp) :: still(2) = 0.0_wp          !< static answer of the two points: out, in
      real(wp), allocatable :: lambda(:)     !< [m] ω² of modes or Ritz vectors, 1/s²
      real(wp), allocatable :: load(:)       !< [m] p_j, √kg
      real(wp), allocatable :: weight(:,:)   !< [2,m] their displacement at the two points
      !> [m] share of each Ritz vector that leaves the space; 0 for modes
      real(wp), allocatable :: leaving(:)
      character(len=:), allocatable :: words
   end type transfer_type

   !> A peak of the amplification.
   type :: peak_type
      real(wp) :: frequency = 0.0_wp  !< Hz
      real(wp) :: amplitude = 0.0_wp
      logical :: inside = .false.     !< a maximum, not the edge of the band
   end type peak_type

   integer, parameter :: dense_blocks = 50      !< all modes are taken up to here
   integer, parameter :: ritz_step = 20, most_ritz = 200
   real(wp), parameter :: wanted_error = 1.0e-8_wp

contains

   !> Prepare x_out(ω)/x_in(ω) for base motion along an axis.
   subroutine prepare_transfer(transfer, linear, points, axes, base_axis, highest, error, time_step)
      type(transfer_type), intent(out) :: transfer
      type(linear_model_type), intent(in) :: linear
      integer, intent(in) :: points(2)      !< numbers of the measured points: out, in
      integer, intent(in) :: axes(2)        !< 1: x, 2: y, of each
      integer, intent(in) :: base_axis      !< along which the base moves
      real(wp), intent(in) :: highest       !< frequency up to which it will be asked for, Hz
      type(error_type), allocatable, intent(out) :: error
      real(wp), intent(in), optional :: time_step  !< s; default: that of the run
      real(wp), allocatable :: static(:,:), rows(:,:,:)
      integer :: i

      if (any(points < 1 .or. points > size(linear%points))) then
         call fail(error, error_input, 'a transfer function needs two measured points; the '// &
            'model has '//to_text(size(linear%points)))
         return
      end if
      transfer%time_step = linear%time_step
      if (present(time_step)) transfer%time_step = time_step
      transfer%dynamic_factor = linear%dynamic_factor
      call static_response(transfer, linear, base_axis, static, error)
      if (allocated(error)) return
      allocate (rows(6, linear%n, 2), source=0.0_wp)
      do i = 1, 2
         rows(:, linear%points(points(i))%block, i) = point_row(linear, points(i), axes(i))
         transfer%still(i) = sum(rows(:, :, i)*static)
      end do
      if (linear%n <= dense_blocks) then
         call take_modes(transfer, linear, static, rows, error)
      else
         call take_ritz_vectors(transfer, linear, static, rows, highest, error)
      end if
   end subroutine prepare_transfer

   !> The static answer x_s to a unit motion of the base.
   subroutine static_response(transfer, linear, axis, static, error)
      type(transfer_type), intent(inout) :: transfer
      type(linear_model_type), intent(in) :: linear
      integer, intent(in) :: axis
      real(wp), allocatable, intent(out) :: static(:,:)  !< [6,n]
      type(error_type), allocatable, intent(out) :: error
      type(shifted_inverse_type) :: inverse
      real(wp), allocatable :: force(:,:)
      integer :: held, moved

      allocate (static(6, linear%n), source=0.0_wp)
      static(axis, :) = 1.0_wp
      transfer%body_force = linear%base_motion(axis) > 0
      call push_fixed_points(linear, axis, force, held, moved)
      transfer%words = 'base motion as body force'
      if (transfer%body_force) return
      transfer%words = 'all fixed points move together'
      if (held == 0) then
         call fail(error, error_input, 'there is no base: no fixed point is held in '// &
            merge('x', 'y', axis == 1)//' and there is no base motion in it')
      else if (moved > 0 .and. moved < held) then
         transfer%words = to_text(moved)//' of '//to_text(held)//' fixed points move'
         call prepare_inverse(inverse, linear%stiffness, linear%mass, error)
         if (.not. allocated(error)) call solve(inverse%factor, force, static)
      end if
   end subroutine static_response

   !> Force of the fixed points that follow the first of their motions along an axis, for a unit
   !> motion.
   subroutine push_fixed_points(linear, axis, force, held, moved)
      type(linear_model_type), intent(in) :: linear
      integer, intent(in) :: axis
      real(wp), allocatable, intent(out) :: force(:,:)  !< [6,n]
      integer, intent(out) :: held                      !< fixed points held along the axis
      integer, intent(out) :: moved                     !< those that follow the motion
      integer :: i, motion

      allocate (force(6, linear%n), source=0.0_wp)
      held = 0
      moved = 0
      motion = 0
      associate (springs => linear%springs)
         do i = 1, springs%n
            if (springs%kind(i) /= spring_fixed .or. springs%row_a(axis, i) /= 1.0_wp) cycle
            held = held + 1
            associate (own => linear%fixed_points(springs%source(i))%motion(axis), &
               b => springs%block_a(i))
               if (motion == 0) motion = own
               if (own == 0 .or. own /= motion) cycle
               moved = moved + 1
               force(:, b) = force(:, b) + linear%constants(spring_fixed)*springs%row_a(:, i)
            end associate
         end do
      end associate
   end subroutine push_fixed_points

   !> All modes of a small model.
   subroutine take_modes(transfer, linear, static, rows, error)
      type(transfer_type), intent(inout) :: transfer
      type(linear_model_type), intent(in) :: linear
      real(wp), intent(in) :: static(:,:), rows(:,:,:)
      type(error_type), allocatable, intent(out) :: error
      type(eigenpairs_type) :: pairs
      real(wp) :: momentum(6, linear%n)
      integer :: j, b

      call all_eigenvalues(linear%stiffness, linear%mass, pairs, error)
      if (allocated(error)) return
      do b = 1, linear%n
         momentum(:, b) = matmul(linear%mass(:, :, b), static(:, b))
      end do
      transfer%lambda = max(pairs%value, 0.0_wp)
      allocate (transfer%load(pairs%n), transfer%weight(2, pairs%n))
      allocate (transfer%leaving(pairs%n), source=0.0_wp)
      do j = 1, pairs%n
         transfer%load(j) = sum(pairs%vector(:, :, j)*momentum)
         transfer%weight(:, j) = [sum(pairs%vector(:, :, j)*rows(:, :, 1)), &
            sum(pairs%vector(:, :, j)*rows(:, :, 2))]
      end do
      transfer%words = transfer%words//'; all '//to_text(pairs%n)//' modes'
   end subroutine take_modes

   !> Ritz vectors of the load, until the highest frequency is answered well.
   subroutine take_ritz_vectors(transfer, linear, static, rows, highest, error)
      type(transfer_type), intent(inout) :: transfer
      type(linear_model_type), intent(in) :: linear
      real(wp), intent(in) :: static(:,:), rows(:,:,:), highest
      type(error_type), allocatable, intent(out) :: error
      type(shifted_inverse_type) :: operator
      type(ritz_type) :: ritz
      real(wp), allocatable :: load(:,:)

      call prepare_inverse(operator, linear%stiffness, linear%mass, error)
      if (allocated(error)) return
      allocate (load(6, linear%n))
      call from_places(operator%mass, static, load)
      call start_ritz(ritz, reshape(load, [6*linear%n]), most_ritz)
      do
         call extend_ritz(ritz, operator, ritz%m + ritz_step)
         call solve_ritz(ritz, error)
         if (allocated(error)) return
         transfer%lambda = max(0.0_wp, operator%shift + 1.0_wp/ritz%value)
         transfer%load = ritz%load*ritz%vector(1, :)
         transfer%leaving = ritz%beta(ritz%m)*ritz%vector(ritz%m, :)
         if (ritz%complete .or. ritz%m + ritz_step > most_ritz) exit
         if (transfer_error(transfer, highest) < wanted_error) exit
      end do
      call weigh_points(transfer, operator, ritz, rows)
      transfer%words = transfer%words//'; '//to_text(ritz%m)// &
         ' Ritz vectors, relative residual '//to_text(transfer_error(transfer, highest))//' at '// &
         to_text(highest)//' Hz'
   end subroutine take_ritz_vectors

   !> Displacement of each Ritz vector at the two points.
   subroutine weigh_points(transfer, operator, ritz, rows)
      type(transfer_type), intent(inout) :: transfer
      type(shifted_inverse_type), intent(in) :: operator
      type(ritz_type), intent(in) :: ritz
      real(wp), intent(in) :: rows(:,:,:)
      real(wp) :: place(size(rows, 1), size(rows, 2)), of_basis(2, ritz%m)
      integer :: j

      do j = 1, ritz%m
         call to_places(operator%mass, reshape(ritz%q(:, j), shape(place)), place)
         of_basis(:, j) = [sum(rows(:, :, 1)*place), sum(rows(:, :, 2)*place)]
      end do
      transfer%weight = matmul(of_basis, ritz%vector)
   end subroutine weigh_points

   !> Transfer function at a frequency, with the damping of the scheme; 0 < f < 1/(2Δt).
   pure complex(wp) function transfer_at(transfer, frequency)
      type(transfer_type), intent(in) :: transfer
      real(wp), intent(in) :: frequency  !< Hz

      transfer_at = ratio_at(transfer, 2.0_wp*pi*frequency, factor_at(transfer, frequency))
   end function transfer_at

   !> The same of the model in continuous time, without any damping; cut off at a resonance.
   pure complex(wp) function undamped_transfer_at(transfer, frequency)
      type(transfer_type), intent(in) :: transfer
      real(wp), intent(in) :: frequency  !< Hz

      undamped_transfer_at = ratio_at(transfer, 2.0_wp*pi*frequency, &
         cmplx(-(2.0_wp*pi*frequency)**2, 0.0_wp, wp))
   end function undamped_transfer_at

   pure complex(wp) function factor_at(transfer, frequency)
      type(transfer_type), intent(in) :: transfer
      real(wp), intent(in) :: frequency  !< Hz
      real(wp), parameter :: short_of_nyquist = 0.5_wp*(1.0_wp - 1.0e-9_wp)

      factor_at = inertia_factor(2.0_wp*pi*min(abs(frequency), &
         short_of_nyquist/transfer%time_step), transfer%time_step, transfer%dynamic_factor)
   end function factor_at

   pure complex(wp) function ratio_at(transfer, omega, c) result(ratio)
      type(transfer_type), intent(in) :: transfer
      real(wp), intent(in) :: omega   !< rad/s
      complex(wp), intent(in) :: c    !< in place of −ω²
      complex(wp) :: push, answer(2), part, below
      real(wp) :: least
      integer :: j

      push = -c
      if (transfer%body_force) push = omega**2
      answer = transfer%still
      do j = 1, size(transfer%lambda)
         below = transfer%lambda(j) + c
         ! No division by zero on a resonance, nor at rest.
         least = 1.0e-14_wp*(transfer%lambda(j) + abs(c)) + tiny(1.0_wp)
         if (abs(below) < least) below = least
         part = push*transfer%load(j)/below
         answer = answer + part*transfer%weight(:, j)
      end do
      ratio = 0.0_wp
      if (abs(answer(2)) > tiny(1.0_wp)) ratio = answer(1)/answer(2)
   end function ratio_at

   !> Relative residual of the equations of motion at a frequency; 0 where all modes are taken.
   pure real(wp) function transfer_error(transfer, frequency) result(residual)
      type(transfer_type), intent(in) :: transfer
      real(wp), intent(in) :: frequency  !< Hz
      complex(wp) :: c, u(size(transfer%lambda))
      real(wp) :: length

      c = factor_at(transfer, frequency)
      u = -c*transfer%load/(transfer%lambda + c)
      length = sqrt(sum(abs(u)**2))
      residual = 0.0_wp
      if (length > 0.0_wp) residual = abs(c*sum(transfer%leaving*u))/length
   end function transfer_error

   !> The largest amplification |H| in a band, refined by golden section.
   subroutine transfer_peak(transfer, low, high, peak)
      type(transfer_type), intent(in) :: transfer
      real(wp), intent(in) :: low, high  !< Hz
      type(peak_type), intent(out) :: peak
      real(wp), allocatable :: frequency(:), amplitude(:)
      real(wp) :: a, b
      integer :: i, best

      call choose_frequencies(transfer, low, high, frequency)
      allocate (amplitude(size(frequency)))
      do i = 1, size(frequency)
         amplitude(i) = abs(transfer_at(transfer, frequency(i)))
      end do
      best = maxloc(amplitude, 1)
      a = frequency(max(1, best - 1))
      b = frequency(min(size(frequency), best + 1))
      call climb(transfer, a, b, peak)
      if (amplitude(best) > peak%amplitude) then
         peak%frequency = frequency(best)
         peak%amplitude = amplitude(best)
      end if
      peak%inside = min(peak%frequency - low, high - peak%frequency) > 1.0e-6_wp*(high - low)
   end subroutine transfer_peak

   !> An even grid over a band and the frequencies of the modes in it, ascending.
   pure subroutine choose_frequencies(transfer, low, high, frequency)
      type(transfer_type), intent(in) :: transfer
      real(wp), intent(in) :: low, high
      real(wp), allocatable, intent(out) :: frequency(:)
      real(wp) :: own(size(transfer%lambda))
      integer, parameter :: steps = 200
      real(wp) :: moving
      integer :: i, j

      own = sqrt(transfer%lambda)/(2.0_wp*pi)
      frequency = [pack(own, own > low .and. own < high), &
         [(low + (high - low)*i/steps, i=0, steps)]]
      do i = 2, size(frequency)
         moving = frequency(i)
         j = i - 1
         do while (j >= 1)
            if (frequency(j) <= moving) exit
            frequency(j + 1) = frequency(j)
            j = j - 1
         end do
         frequency(j + 1) = moving
      end do
   end subroutine choose_frequencies

   !> Golden section for the maximum between a and b.
   subroutine climb(transfer, a, b, peak)
      type(transfer_type), intent(in) :: transfer
      real(wp), intent(inout) :: a, b
      type(peak_type), intent(inout) :: peak
      real(wp), parameter :: golden = 0.5_wp*(sqrt(5.0_wp) - 1.0_wp)
      real(wp) :: x(2), h(2)
      integer :: i

      x = [b - golden*(b - a), a + golden*(b - a)]
      h = [abs(transfer_at(transfer, x(1))), abs(transfer_at(transfer, x(2)))]
      do i = 1, 60
         if (h(1) >= h(2)) then
            b = x(2)
            x = [b - golden*(b - a), x(1)]
            h = [abs(transfer_at(transfer, x(1))), h(1)]
         else
            a = x(1)
            x = [x(2), a + golden*(b - a)]
            h = [h(2), abs(transfer_at(transfer, x(2)))]
         end if
         if (b - a <= 1.0e-9_wp*b) exit
      end do
      peak%frequency = x(maxloc(h, 1))
      peak%amplitude = maxval(h)
   end subroutine climb

end module dda_transfer
