! SPDX-License-Identifier: GPL-3.0-or-later
!> Load histories: linear between their times, zero outside.
module test_support
   use dda_kinds, only: wp
   use dda_support, only: load_at, load_type
   use models, only: random
   use testing, only: check_close
   implicit none

contains

   subroutine a_ramp()
      type(load_type) :: load

      load = load_type(1, 0.0_wp, [1.0_wp, 3.0_wp], reshape([2.0_wp, -4.0_wp, 6.0_wp, 0.0_wp], &
         [2, 2]))
      call check_close(load_at(load, 0.999_wp), [0.0_wp, 0.0_wp], 'before')
      call check_close(load_at(load, 1.0_wp), [2.0_wp, -4.0_wp], 'at its start')
      call check_close(load_at(load, 1.5_wp), [3.0_wp, -3.0_wp], 'between', relative=1.0e-15_wp)
      call check_close(load_at(load, 3.0_wp), [6.0_wp, 0.0_wp], 'at its end')
      call check_close(load_at(load, 3.001_wp), [0.0_wp, 0.0_wp], 'after')
   end subroutine a_ramp

   !> A time given twice is a jump to the second value.
   subroutine steps()
      type(load_type) :: load

      load%time = [0.0_wp, 1.0_wp, 1.0_wp, 2.0_wp, 2.0_wp, 3.0_wp]
      load%force = reshape([0, 0, 0, 0, 5, 1, 5, 1, 0, 0, 0, 0]*1.0_wp, [2, 6])
      call check_close(load_at(load, 0.999999_wp), [0.0_wp, 0.0_wp], 'before')
      call check_close(load_at(load, 1.0_wp), [5.0_wp, 1.0_wp], 'at the step')
      call check_close(load_at(load, 1.7_wp), [5.0_wp, 1.0_wp], 'held', relative=1.0e-15_wp)
      call check_close(load_at(load, 2.0_wp), [0.0_wp, 0.0_wp], 'released')
      call check_close(load_at(load, 2.5_wp), [0.0_wp, 0.0_wp], 'gone')
      load%time = [1.0_wp, 1.0_wp]
      load%force = reshape([3, 0, 4, 0]*1.0_wp, [2, 2])
      call check_close(load_at(load, 1.0_wp), [4.0_wp, 0.0_wp], 'an instant alone')
      call check_close(load_at(load, 1.1_wp), [0.0_wp, 0.0_wp], 'and no more')
   end subroutine steps

   !> Against a search from the front.
   subroutine random_history()
      integer, parameter :: n = 40
      type(load_type) :: load
      real(wp) :: t, ratio
      integer :: i, k

      allocate (load%time(n), load%force(2, n))
      load%time(1) = 0.5_wp
      do i = 1, n
         if (i > 1) load%time(i) = load%time(i - 1) + random(0.001_wp, 1.0_wp)
         load%force(:, i) = [random(-1.0e6_wp, 1.0e6_wp), random(-1.0e6_wp, 1.0e6_wp)]
      end do
      do k = 1, 200
         t = random(load%time(1), load%time(n))
         do i = 1, n - 2
            if (load%time(i + 1) > t) exit
         end do
         ratio = (t - load%time(i))/(load%time(i + 1) - load%time(i))
         call check_close(load_at(load, t), (1.0_wp - ratio)*load%force(:, i) &
            + ratio*load%force(:, i + 1), 'force', absolute=1.0e-6_wp)
      end do
   end subroutine random_history

end module test_support
