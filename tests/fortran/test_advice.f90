! SPDX-License-Identifier: GPL-3.0-or-later
!> The recommended parameters yield the requested values.
module test_advice
   use dda_kinds, only: wp
   use dda_advice, only: penalty_type, first_mode_type, find_first_mode, find_stiff_limit, &
      find_penalty_for_frequency, find_penalty_for_shift
   use dda_linear_model, only: linear_model_type
   use check_models, only: layered_site, drum_column, brick_wall, loose_blocks, linear_of
   use testing, only: check, check_close, check_fails, check_no_error, error
   implicit none

   type(linear_model_type) :: linear
   type(penalty_type) :: penalty

contains

   !> The paper finds the penalty of its column by trial (§3.2).
   subroutine penalty_that_matches_a_frequency()
      real(wp), parameter :: targets(4) = [1.0_wp, 3.2_wp, 4.3_wp, 50.0_wp]
      type(first_mode_type) :: mode
      integer :: i

      call linear_of(linear, drum_column('1.0e8', ''), 'closed')
      do i = 1, size(targets)
         call find_penalty_for_frequency(linear, targets(i), penalty, error)
         call check_no_error(error, 'penalty')
         call check(penalty%reached .and. penalty%solves < 30, 'found soon')
         call find_first_mode(linear, penalty%normal_stiffness, mode, error)
         call check_close(mode%frequency, targets(i), 'frequency with it', relative=1.0e-7_wp)
      end do
      call check(index(penalty%text, 'normal_stiffness') == 1, 'in words')
      call find_penalty_for_frequency(linear, 200.0_wp, penalty, error)
      call check_no_error(error, 'too high')
      call check(.not. penalty%reached .and. index(penalty%text, 'no penalty') == 1, &
         'too high, in words')
      ! Springs as soft as that hold nothing: the first mode that is left is one of strains.
      call find_penalty_for_frequency(linear, 1.0e-8_wp, penalty, error)
      call check_no_error(error, 'too low')
      call check(.not. penalty%reached .and. index(penalty%text, 'does not depend') > 0, &
         'too low, in words')
   end subroutine penalty_that_matches_a_frequency

   subroutine penalty_within_a_shift()
      real(wp) :: limit
      type(first_mode_type) :: mode

      call linear_of(linear, layered_site(), 'closed')
      call find_stiff_limit(linear, limit, error)
      call check_no_error(error, 'limit')
      call find_first_mode(linear, 1.0e15_wp, mode, error)
      call check_close(limit, mode%frequency, 'limit', relative=1.0e-4_wp)
      call check(limit > 14.188_wp .and. limit < 14.25_wp, 'a little above the continuum''s Vs/4H')
      call find_penalty_for_shift(linear, 1.0_wp, penalty, error)
      call check_no_error(error, 'shift')
      call check_close(penalty%frequency, 0.99_wp*limit, 'one per cent below', relative=1.0e-7_wp)
      call find_penalty_for_shift(linear, 60.0_wp, penalty, error)
      call check_no_error(error, 'more than half')
      call find_penalty_for_shift(linear, 2.0_wp, penalty, error, reference=14.188_wp)
      call check_close(penalty%frequency, 0.98_wp*14.188_wp, 'of a given frequency', &
         relative=1.0e-7_wp)
      call linear_of(linear, brick_wall(8, 8, '1.0e10', ''), 'closed')
      call find_penalty_for_shift(linear, 5.0_wp, penalty, error)
      call check_no_error(error, 'wall')
      call check_close(penalty%frequency, 0.95_wp*penalty%rigid_frequency, 'wall', &
         relative=1.0e-6_wp)
   end subroutine penalty_within_a_shift

   subroutine questions_without_an_answer()
      call linear_of(linear, layered_site(), 'closed')
      call find_penalty_for_frequency(linear, 0.0_wp, penalty, error)
      call check_fails(error, 'not positive')
      call find_penalty_for_shift(linear, 100.0_wp, penalty, error)
      call check_fails(error, 'between 0 and 100')
      call linear_of(linear, loose_blocks(), 'closed')
      call find_penalty_for_frequency(linear, 5.0_wp, penalty, error)
      call check_fails(error, 'no effect')
   end subroutine questions_without_an_answer

end module test_advice
