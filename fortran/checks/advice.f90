! SPDX-License-Identifier: GPL-3.0-or-later
!> Find the penalty (normal stiffness of contacts) for a given first frequency, or for a given
!> reduction of the first frequency.
module dda_advice
   use dda_kinds, only: wp, pi
   use dda_eigen, only: eigenpairs_type
   use dda_errors, only: error_type, error_input, error_solver, fail
   use dda_linear_model, only: linear_model_type, energy_distribution_type, energy_of, &
      is_dispersive, set_moduli_at, set_penalty
   use dda_modes, only: find_elastic
   use dda_text, only: to_text
   implicit none
   private
   public :: penalty_type, first_mode_type
   public :: find_first_mode, find_stiff_limit, find_penalty_for_frequency, find_penalty_for_shift

   !> Recommended normal stiffness, and its effects.
   type :: penalty_type
      logical :: reached = .false.
      !> k_n, N/m per metre of thickness; ratios of other stiffnesses to k_n are constant
      real(wp) :: normal_stiffness = 0.0_wp
      real(wp) :: frequency = 0.0_wp         !< first frequency at this stiffness, Hz
      real(wp) :: target = 0.0_wp            !< target of the first frequency, Hz
      real(wp) :: rigid_frequency = 0.0_wp             !< first frequency for k → ∞, Hz
      integer :: solves = 0                  !< number of eigenvalue problems solved
      character(len=:), allocatable :: text
   end type penalty_type

   !> First mode with stiffness at one penalty k, as a point of the curve y(s) = 1/ω² over s = 1/k.
   type :: first_mode_type
      real(wp) :: softness = 0.0_wp          !< s, m/N
      real(wp) :: frequency = 0.0_wp         !< Hz
      real(wp) :: compliance = 0.0_wp        !< y, s²
      !> fraction of the elastic energy in springs proportional to the penalty: s y'/y
      real(wp) :: share = 0.0_wp
      integer :: mechanisms = 0              !< number of motions without stiffness
   end type first_mode_type

   real(wp), parameter :: close_enough = 1.0e-9_wp  !< tolerance/target frequency
   real(wp), parameter :: largest_penalty = 1.0e18_wp  !< largest normal stiffness of an input, N/m

contains

   !> Find the first mode above zero at a given penalty.
   !> All springs and supports are scaled to this penalty.
   subroutine find_first_mode(linear, normal_stiffness, mode, error)
      type(linear_model_type), intent(inout) :: linear  !< linearised model
      real(wp), intent(in) :: normal_stiffness  !< N/m per metre of thickness
      type(first_mode_type), intent(out) :: mode  !< the mode
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      type(eigenpairs_type) :: pairs
      type(energy_distribution_type) :: energy
      integer :: rigid

      call set_penalty(linear, normal_stiffness)
      call find_elastic(linear, 1, pairs, rigid, mode%mechanisms, error)
      if (allocated(error)) return
      if (pairs%n == 0) then
         call fail(error, error_input, 'the model has no mode with stiffness')
      else if (linear%terms%n == 0) then
         call fail(error, error_input, 'no contact is closed and nothing is fixed: the penalty '// &
            'has no effect')
      else
         energy = energy_of(linear, pairs%vector(:, :, 1))
         mode%softness = 1.0_wp/normal_stiffness
         mode%compliance = 1.0_wp/pairs%value(1)
         mode%frequency = sqrt(pairs%value(1))/(2.0_wp*pi)
         mode%share = energy%of_penalty
      end if
   end subroutine find_first_mode

   !> Find the first frequency of the same blocks for k → ∞.
   !>
   !> The penalty is increased until its springs have a small share of the elastic energy.  Then the
   !> cubic through y and its slope y' = share·y/s at this penalty and at a quarter of it is
   !> extrapolated to s = 0; its error is of the order of share⁴.
   subroutine find_stiff_limit(linear, frequency, error)
      type(linear_model_type), intent(inout) :: linear  !< on return, with a stiff penalty
      real(wp), intent(out) :: frequency  !< Hz
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      real(wp), parameter :: small_share = 0.02_wp, wanted_share = 0.01_wp, most_growth = 1.0e3_wp
      integer, parameter :: most_increases = 6
      type(first_mode_type) :: stiff, soft
      real(wp) :: growth
      integer :: i, mechanisms

      frequency = 0.0_wp
      call find_first_mode(linear, linear%normal_stiffness, stiff, error)
      if (allocated(error)) return
      mechanisms = stiff%mechanisms
      do i = 1, most_increases
         if (stiff%share <= small_share) exit
         growth = min(most_growth, stiff%share/(wanted_share*max(epsilon(1.0_wp), &
            1.0_wp - stiff%share)))
         call find_first_mode(linear, growth/stiff%softness, stiff, error)
         if (allocated(error)) return
      end do
      if (stiff%mechanisms > mechanisms) then
         call fail(error, error_solver, 'rounding prevents the computation of the first '// &
            'frequency with rigid joints, because it is too low relative to the highest')
      else if (stiff%share > small_share) then
         call fail(error, error_input, 'the first frequency increases with the penalty without '// &
            'limit, because rigid joints would prevent all motion')
      end if
      if (allocated(error)) return
      call find_first_mode(linear, 0.25_wp/stiff%softness, soft, error)
      if (.not. allocated(error)) frequency = 1.0_wp/(2.0_wp*pi*sqrt(rigid_compliance(stiff, soft)))
   end subroutine find_stiff_limit

   !> Return y(0) of the cubic through y and y' of two modes.
   pure real(wp) function rigid_compliance(stiff, soft) result(y)
      type(first_mode_type), intent(in) :: stiff, soft  !< modes with a smaller and a larger s
      real(wp) :: h, t

      h = soft%softness - stiff%softness
      t = -stiff%softness/h
      y = stiff%compliance*((1.0_wp + 2.0_wp*t)*(1.0_wp - t)**2 &
         + stiff%share*h/stiff%softness*t*(1.0_wp - t)**2) &
         + soft%compliance*(t**2*(3.0_wp - 2.0_wp*t) + soft%share*h/soft%softness*t**2*(t - 1.0_wp))
   end function rigid_compliance

   !> Find the penalty at which the first frequency is lower than a reference by a percentage.
   !> The reference is a given frequency, or the limit for k → ∞ with the moduli at the target.
   subroutine find_penalty_for_shift(linear, percent, penalty, error, reference)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      real(wp), intent(in) :: percent                 !< reduction, %, between 0 and 100
      type(penalty_type), intent(out) :: penalty  !< normal stiffness and its effects
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      real(wp), intent(in), optional :: reference     !< reference frequency, Hz; default: k → ∞
      real(wp) :: limit, remaining

      remaining = 1.0_wp - 0.01_wp*percent
      if (.not. (percent > 0.0_wp .and. percent < 100.0_wp)) then
         call fail(error, error_input, 'a reduction of '//to_text(percent)// &
            ' % is not between 0 and 100 %')
      else if (linear%n_by_penalty == 0) then
         call fail(error, error_input, 'no closed contact has the stiffness normal_stiffness, '// &
            'so it does not lower the first frequency')
      else if (present(reference)) then
         limit = reference
      else
         call find_limit_at_target(linear, remaining, limit, error)
      end if
      if (.not. allocated(error)) &
         call find_penalty_for_frequency(linear, remaining*limit, penalty, error, limit)
   end subroutine find_penalty_for_shift

   !> Find the limit for k → ∞ with the moduli of damped materials at a fraction of this limit.
   subroutine find_limit_at_target(linear, fraction, limit, error)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      real(wp), intent(in) :: fraction  !< target frequency/limit
      real(wp), intent(out) :: limit  !< Hz
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      integer, parameter :: most_passes = 20
      type(linear_model_type) :: work
      real(wp) :: last
      integer :: pass

      work = linear
      call find_stiff_limit(work, limit, error)
      do pass = 1, most_passes
         if (allocated(error) .or. .not. is_dispersive(linear)) exit
         last = limit
         call set_moduli_at(work, fraction*limit)
         call find_stiff_limit(work, limit, error)
         if (abs(limit - last) <= close_enough*limit) exit
      end do
   end subroutine find_limit_at_target

   !> Find the penalty for a target first frequency (the paper's Avdat calibration, §3.2).
   subroutine find_penalty_for_frequency(linear, target, penalty, error, limit)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      real(wp), intent(in) :: target  !< Hz
      type(penalty_type), intent(out) :: penalty  !< normal stiffness and its effects
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      real(wp), intent(in), optional :: limit  !< first frequency for k → ∞ if known, Hz
      type(linear_model_type) :: work

      if (.not. target > 0.0_wp) call fail(error, error_input, 'a target frequency of '// &
         to_text(target)//' Hz is not positive')
      if (allocated(error)) return
      work = linear
      call set_moduli_at(work, target)
      penalty%target = target
      if (present(limit)) then
         penalty%rigid_frequency = limit
      else
         call find_stiff_limit(work, penalty%rigid_frequency, error)
      end if
      if (.not. (allocated(error) .or. target >= penalty%rigid_frequency)) &
         call find_root(work, linear%normal_stiffness, penalty, error)
      if (.not. allocated(error)) call describe(penalty)
   end subroutine find_penalty_for_frequency

   !> Write the text of a penalty, and reject a value that an input cannot have.
   pure subroutine describe(penalty)
      type(penalty_type), intent(inout) :: penalty  !< normal stiffness and its effects

      if (penalty%target >= penalty%rigid_frequency) then
         penalty%text = 'no penalty gives '//to_text(penalty%target)// &
            ' Hz; even with rigid joints the first frequency is '// &
            to_text(penalty%rigid_frequency)//' Hz; the blocks themselves are too soft or too heavy'
      else if (.not. penalty%reached) then
         penalty%text = 'no penalty gives '//to_text(penalty%target)// &
            ' Hz, because the first frequency does not depend on the penalty'
      else if (penalty%normal_stiffness > largest_penalty) then
         penalty%reached = .false.
         penalty%text = 'a first frequency of '//to_text(penalty%target)//' Hz requires '// &
            'normal_stiffness = '//to_text(penalty%normal_stiffness)// &
            ' N/m, but the largest permitted value is '//to_text(largest_penalty)//' N/m'
      else
         penalty%text = 'normal_stiffness = '//to_text(penalty%normal_stiffness)// &
            ' gives a first frequency of '//to_text(penalty%frequency)//' Hz ('// &
            to_text(penalty%rigid_frequency)//' Hz with rigid joints)'
      end if
   end subroutine describe

   !> Find the root of y(s) − 1/ω², with ω of the target, by Newton's method.
   !> y is almost linear in s.  Bisection replaces a step out of the bracket of the root; while no s
   !> is known to be too soft, a step increases s at most by `most_growth`.
   subroutine find_root(work, first_guess, penalty, error)
      type(linear_model_type), intent(inout) :: work  !< linearised model, changed
      real(wp), intent(in) :: first_guess  !< N/m per metre of thickness
      type(penalty_type), intent(inout) :: penalty  !< normal stiffness and its effects
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      integer, parameter :: most_solves = 60, most_increases = 20
      real(wp), parameter :: most_growth = 100.0_wp
      type(first_mode_type) :: mode
      real(wp) :: s, stiff, soft, newton, misfit, wanted
      integer :: i

      wanted = (2.0_wp*pi*penalty%target)**(-2)
      s = 1.0_wp/first_guess
      stiff = 0.0_wp  ! bracket: too stiff and too soft
      soft = huge(1.0_wp)
      do i = 1, most_solves
         call find_first_mode(work, 1.0_wp/s, mode, error)
         if (allocated(error)) return
         penalty%solves = i
         misfit = mode%compliance - wanted
         if (abs(misfit) <= 2.0_wp*close_enough*wanted) exit
         if (misfit < 0.0_wp) then
            stiff = s
         else
            soft = s
         end if
         if (i > most_increases .and. soft >= huge(1.0_wp)) return
         newton = s
         if (mode%share > 0.0_wp) newton = s*(1.0_wp - misfit/(mode%share*mode%compliance))
         s = min(newton, most_growth*s)
         if (s <= stiff .or. s >= soft) s = merge(most_growth*stiff, 0.5_wp*(stiff + soft), &
            soft >= huge(1.0_wp))
      end do
      penalty%normal_stiffness = 1.0_wp/s
      penalty%frequency = mode%frequency
      penalty%reached = abs(penalty%frequency/penalty%target - 1.0_wp) < 1.0e-6_wp
      if (.not. penalty%reached) call fail(error, error_solver, 'the search for a penalty for '// &
         to_text(penalty%target)//' Hz has stopped at '//to_text(penalty%frequency)//' Hz')
   end subroutine find_root

end module dda_advice
