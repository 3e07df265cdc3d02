! SPDX-License-Identifier: GPL-3.0-or-later
!> The strict number parser: valid numbers, invalid numbers, and correct rounding.
module test_text_numbers
   use dda_kinds, only: long, wp
   use dda_text, only: short_text
   use dda_text_numbers, only: read_next_number, whole_number, word_at, number_found, number_none, &
      number_bad, number_large
   use testing, only: check, check_close
   implicit none

contains

   !> Exponents of one and of three digits.
   subroutine written_in_four_digits()
      call check(short_text(7.66412e305_wp) == '7.664e305', 'large: '//short_text(7.66412e305_wp))
      call check(short_text(-1.2e-120_wp) == '-1.2e-120', 'small: '//short_text(-1.2e-120_wp))
      call check(short_text(1.0e99_wp) == '1e99', 'from 1e99: '//short_text(1.0e99_wp))
      call check(short_text(2.5e7_wp) == '2.5e7', 'plain: '//short_text(2.5e7_wp))
      call check(short_text(12.5_wp) == '12.5', 'short: '//short_text(12.5_wp))
   end subroutine written_in_four_digits

   subroutine valid_numbers()
      call expect('1', 1.0_wp)
      call expect('  +1.5', 1.5_wp)
      call expect('-.5', -0.5_wp)
      call expect('5.', 5.0_wp)
      call expect('1e3', 1000.0_wp)
      call expect('1.25D-02', 0.0125_wp)
      call expect(achar(9)//'7 ', 7.0_wp)
      call expect('0e999', 0.0_wp)
      call expect('1e-400', 0.0_wp)
      call expect('000000000000000000000000001', 1.0_wp)
   end subroutine valid_numbers

   subroutine invalid_numbers_are_rejected()
      character(len=8), parameter :: invalid(16) = [character(len=8) :: 'NaN', 'Inf', '3*5', '/', &
         '1.2.3', 'e5', '.', '-', '1e', '1e+', '0x10', '1_8', '--1', '1,5', '****', '1.0-2.0']
      integer :: i

      do i = 1, size(invalid)
         call check(state_of(trim(invalid(i))) == number_bad, invalid(i))
      end do
      call check(state_of('  ') == number_none, 'blanks hold no number')
      call check(state_of('') == number_none, 'nothing holds no number')
      call check(word_at(' a 12x '//achar(9), 3) == '12x', 'the word is named')
   end subroutine invalid_numbers_are_rejected

   subroutine numbers_beyond_the_range()
      call check(state_of('1e400') == number_large, '1e400')
      call check(state_of('-1e99999999999999') == number_large, 'an exponent beyond any integer')
      call check(state_of('1e299') == number_found, '1e299')
   end subroutine numbers_beyond_the_range

   subroutine numbers_that_run_together()
      character(len=*), parameter :: text = ' 1.0E+0-2.5E+0-3.25E-1+4'
      real(wp) :: value(4)
      integer :: position, state, i

      position = 1
      do i = 1, 4
         call read_next_number(text, position, value(i), state, joined=.true.)
         call check(state == number_found, 'found')
      end do
      call check_close(value, [1.0_wp, -2.5_wp, -0.325_wp, 4.0_wp], 'all four')
      call read_next_number(text, position, value(1), state, joined=.true.)
      call check(state == number_none, 'no fifth')
      position = 1
      call read_next_number('100.123456200.123456', position, value(1), state, joined=.true.)
      call check(state == number_bad, 'two numbers without a sign between are not guessed at')
   end subroutine numbers_that_run_together

   subroutine commas_are_counted()
      character(len=*), parameter :: text = '1 , 2,3'
      real(wp) :: value(3)
      integer :: position, state, i

      position = 1
      do i = 1, 3
         call read_next_number(text, position, value(i), state, commas=.true.)
      end do
      call check_close(value, [1.0_wp, 2.0_wp, 3.0_wp], 'three')
      position = 1
      call read_next_number('1,,2', position, value(1), state, commas=.true.)
      call read_next_number('1,,2', position, value(2), state, commas=.true.)
      call check(state == number_bad, 'an empty field is not skipped')
   end subroutine commas_are_counted

   !> Against the compiler's own conversion of constants, to the last bit.
   subroutine rounding_is_right()
      call expect('0.1', 0.1_wp)
      call expect('9007199254740993', 9007199254740993.0_wp)
      call expect('1.7976931348623157e299', 1.7976931348623157e299_wp)
      call expect('123456789012345678901234567890', 123456789012345678901234567890.0_wp)
      call expect('6.62607015e-34', 6.62607015e-34_wp)
      call expect('0.000000000000000000000000000000000314159', 3.14159e-34_wp)
      call expect('-2225.194E-3', -2.225194_wp)
   end subroutine rounding_is_right

   subroutine counts_are_whole()
      call check(whole_number(4000.0_wp) == 4000, '4000')
      call check(whole_number(0.5_wp) == -1, 'a half')
      call check(whole_number(-1.0_wp) == -1, 'negative')
      call check(whole_number(1.0e30_wp) == -1, '1e30')
      call check(whole_number(1.0e12_wp) == 1000000000000_long, '1e12')
   end subroutine counts_are_whole

   subroutine expect(text, value)
      character(len=*), intent(in) :: text
      real(wp), intent(in) :: value
      real(wp) :: actual
      integer :: position, state

      position = 1
      call read_next_number(text, position, actual, state)
      call check(state == number_found, text//' is a number')
      call check_close(actual, value, text)
      call check(position > len_trim(text), text//' is stepped over')
   end subroutine expect

   function state_of(text) result(state)
      character(len=*), intent(in) :: text
      integer :: state
      real(wp) :: value
      integer :: position

      position = 1
      call read_next_number(text, position, value, state)
   end function state_of

end module test_text_numbers
