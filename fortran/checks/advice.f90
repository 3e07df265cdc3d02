! SPDX-License-Identifier: GPL-3.0-or-later
!> Find the penalty (normal stiffness of contacts) for a given first frequency, or for a given
!> reduction of the first frequency.
module dda_advice
   use dda_kinds, only: wp, pi
   use dda_eigen, only: eigenpairs_type
   use dda_errors, only: error_type, error_input, error_solver, fail
   use dda_linear_model, only: linear_model_type, set_moduli_at, set_penalty
   use dda_modes, only: find_elastic
   use dda_text, only: to_text
   implicit none
   private
   public :: penalty_type
   public :: find_first_frequency, find_stiff_limit, find_penalty_for_frequency, &
      find_penalty_for_shift

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

   real(wp), parameter :: close_enough = 1.0e-9_wp  !< tolerance/target frequency

contains

   !> Find the first frequency above zero at a given penalty.
   !> All springs and supports are scaled to this penalty.
   subroutine find_first_frequency(linear, normal_stiffness, frequency, error)
      type(linear_model_type), intent(inout) :: linear  !< linearised model
      real(wp), intent(in) :: normal_stiffness  !< N/m per metre of thickness
      real(wp), intent(out) :: frequency  !< Hz
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      type(eigenpairs_type) :: pairs
      integer :: rigid, mechanisms

      frequency = 0.0_wp
      call set_penalty(linear, normal_stiffness)
      call find_elastic(linear, 1, pairs, rigid, mechanisms, error)
      if (allocated(error)) return
      if (pairs%n == 0) then
         call fail(error, error_input, 'the model has no mode with stiffness')
      else if (linear%terms%n == 0) then
         call fail(error, error_input, 'no contact is closed and nothing is fixed: the penalty '// &
            'has no effect')
      else
         frequency = sqrt(pairs%value(1))/(2.0_wp*pi)
      end if
   end subroutine find_first_frequency

   !> Find the first frequency of the same blocks for k → ∞.
   !> 1/f² is almost linear in 1/k, so a parabola through three stiff penalties is extrapolated.  If
   !> rounding prevents this, the stiffest penalty is used.
   subroutine find_stiff_limit(linear, frequency, error)
      type(linear_model_type), intent(inout) :: linear  !< linearised model
      real(wp), intent(out) :: frequency  !< Hz
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      real(wp), parameter :: stiffest = 1.0e3_wp  !< largest penalty over block modulus × 1 m
      real(wp) :: frequencies(3), compliance(3), extrapolated
      integer :: i

      frequency = 0.0_wp
      do i = 1, 3
         call find_first_frequency(linear, stiffest*linear%modulus/i, frequencies(i), error)
         if (allocated(error)) return
      end do
      compliance = 1.0_wp/frequencies**2
      extrapolated = 3.0_wp*compliance(1) - 3.0_wp*compliance(2) + compliance(3)
      frequency = frequencies(1)
      if (extrapolated > 0.0_wp) frequency = 1.0_wp/sqrt(extrapolated)
   end subroutine find_stiff_limit

   !> Find the penalty at which the first frequency is lower than a target by a percentage.
   !> The target is a given frequency, or the limit for k → ∞.
   subroutine find_penalty_for_shift(linear, percent, penalty, error, reference)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      real(wp), intent(in) :: percent                 !< reduction, %, between 0 and 100
      type(penalty_type), intent(out) :: penalty  !< normal stiffness and its effects
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      real(wp), intent(in), optional :: reference     !< reference frequency, Hz; default: k → ∞
      type(linear_model_type) :: work
      real(wp) :: reference_frequency

      if (.not. (percent > 0.0_wp .and. percent < 100.0_wp)) call fail(error, error_input, &
         'a shift of '//to_text(percent)//' % is not between 0 and 100')
      if (allocated(error)) return
      if (present(reference)) then
         reference_frequency = reference
      else
         work = linear
         call find_stiff_limit(work, reference_frequency, error)
         if (allocated(error)) return
      end if
      call find_penalty_for_frequency(linear, (1.0_wp - 0.01_wp*percent)*reference_frequency, &
         penalty, error)
   end subroutine find_penalty_for_shift

   !> Find the penalty for a target first frequency (the paper's Avdat calibration, §3.2).
   subroutine find_penalty_for_frequency(linear, target, penalty, error)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      real(wp), intent(in) :: target  !< Hz
      type(penalty_type), intent(out) :: penalty  !< normal stiffness and its effects
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      type(linear_model_type) :: work

      if (.not. target > 0.0_wp) call fail(error, error_input, 'a target frequency of '// &
         to_text(target)//' Hz is not positive')
      if (allocated(error)) return
      work = linear
      call set_moduli_at(work, target)
      penalty%target = target
      call find_stiff_limit(work, penalty%rigid_frequency, error)
      if (allocated(error)) return
      penalty%solves = 3
      if (target >= penalty%rigid_frequency) then
         penalty%text = 'no penalty gives '//to_text(target)// &
            ' Hz; even with rigid joints the first frequency is '// &
            to_text(penalty%rigid_frequency)//' Hz; the blocks themselves are too soft or too heavy'
         return
      end if
      call find_root(work, linear%normal_stiffness, penalty, error)
      if (allocated(error)) return
      if (penalty%reached) then
         penalty%text = 'normal_stiffness = '//to_text(penalty%normal_stiffness)// &
            ' gives a first frequency of '//to_text(penalty%frequency)//' Hz ('// &
            to_text(penalty%rigid_frequency)//' Hz with rigid joints)'
      else
         penalty%text = 'no penalty gives '//to_text(target)// &
            ' Hz, because the first frequency does not depend on the penalty'
      end if
   end subroutine find_penalty_for_frequency

   !> Find the root of 1/f² − 1/target², which is almost linear in s = 1/k.
   !> The root is bracketed and found by regula falsi with the Illinois weight.
   subroutine find_root(work, first_guess, penalty, error)
      type(linear_model_type), intent(inout) :: work  !< linearised model, changed
      real(wp), intent(in) :: first_guess  !< N/m per metre of thickness
      type(penalty_type), intent(inout) :: penalty  !< normal stiffness and its effects
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      real(wp) :: s(2), g(2), new_s, new_g
      integer :: i, last
      logical :: bracketed

      call bracket_root(work, first_guess, penalty, s, g, bracketed, error)
      if (allocated(error) .or. .not. bracketed) return
      last = 0
      do i = 1, 60
         new_s = (s(1)*g(2) - s(2)*g(1))/(g(2) - g(1))
         call compute_frequency_misfit(work, new_s, penalty, new_g, error)
         if (allocated(error)) return
         if (abs(new_g) <= 2.0_wp*close_enough/penalty%target**2) exit
         if (new_g < 0.0_wp) then
            if (last == 1) g(2) = 0.5_wp*g(2)
            s(1) = new_s
            g(1) = new_g
            last = 1
         else
            if (last == 2) g(1) = 0.5_wp*g(1)
            s(2) = new_s
            g(2) = new_g
            last = 2
         end if
      end do
      penalty%normal_stiffness = 1.0_wp/new_s
      penalty%reached = abs(penalty%frequency/penalty%target - 1.0_wp) < 1.0e-6_wp
      if (.not. penalty%reached) call fail(error, error_solver, 'the search for a penalty for '// &
         to_text(penalty%target)//' Hz has stopped at '//to_text(penalty%frequency)//' Hz')
   end subroutine find_root

   !> Bracket the root: g < 0 at s(1) (too stiff), g > 0 at s(2) (too soft).
   subroutine bracket_root(work, first_guess, penalty, s, g, bracketed, error)
      type(linear_model_type), intent(inout) :: work  !< linearised model, changed
      real(wp), intent(in) :: first_guess  !< penalty to begin with, N/m
      type(penalty_type), intent(inout) :: penalty  !< normal stiffness and its effects
      real(wp), intent(out) :: s(2), g(2)  !< ends of the bracket and their differences
      logical, intent(out) :: bracketed    !< the bracket contains the root
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      real(wp), parameter :: stride = 8.0_wp
      real(wp) :: new_s, new_g
      integer :: i, bracket_end

      ! Rigid joints are one end of the bracket.
      s = 0.0_wp
      g = [1.0_wp/penalty%rigid_frequency**2 - 1.0_wp/penalty%target**2, 0.0_wp]
      new_s = 1.0_wp/first_guess
      do i = 1, 20
         call compute_frequency_misfit(work, new_s, penalty, new_g, error)
         if (allocated(error)) return
         bracket_end = merge(1, 2, new_g < 0.0_wp)
         s(bracket_end) = new_s
         g(bracket_end) = new_g
         if (bracket_end == 2) exit
         new_s = new_s*stride
      end do
      bracketed = g(2) > 0.0_wp
   end subroutine bracket_root

   !> Compute 1/f² − 1/target² at the penalty 1/s.
   subroutine compute_frequency_misfit(work, s, penalty, g, error)
      type(linear_model_type), intent(inout) :: work  !< linearised model, changed
      real(wp), intent(in) :: s   !< 1/k, m/N
      type(penalty_type), intent(inout) :: penalty  !< normal stiffness and its effects
      real(wp), intent(out) :: g  !< difference, s²
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure

      g = 0.0_wp
      call find_first_frequency(work, 1.0_wp/s, penalty%frequency, error)
      if (allocated(error)) return
      penalty%solves = penalty%solves + 1
      g = 1.0_wp/penalty%frequency**2 - 1.0_wp/penalty%target**2
   end subroutine compute_frequency_misfit

end module dda_advice
