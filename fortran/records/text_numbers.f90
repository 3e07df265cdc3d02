! SPDX-License-Identifier: GPL-3.0-or-later
!> Numbers in untrusted text.
!>
!> List-directed reads of Fortran accept `3*5`, `/`, `NaN`, `1e400` and an empty field without an
!> error.  This module accepts only: sign, digits with at most one point, exponent with E or D.
!> Old programs write fixed-width numbers without blanks between (`1.0E+0-2.0E+0`).  On request, a
!> sign directly after a complete number therefore begins another number.
module dda_text_numbers
   use dda_kinds, only: wp, long
   implicit none
   private
   public :: read_next_number, word_at, whole_number
   public :: number_found, number_none, number_bad, number_large

   integer, parameter :: number_found = 0  !< a number was read
   integer, parameter :: number_none = 1   !< only blanks remain
   integer, parameter :: number_bad = 2    !< not a number
   integer, parameter :: number_large = 3  !< a number beyond 1e300

   integer, parameter :: max_digits = 18      ! of an integer(long) mantissa
   ! limits of the power of ten, so that scaling cannot overflow
   integer, parameter :: largest_power = 300, smallest_power = -400
   integer, parameter :: longest_number = 64   ! characters
   integer, parameter :: exact_power = 22      ! 10**22 is the last exact power of ten
   character(len=*), parameter :: tab = achar(9), signs = '+-', digits = '0123456789'

   !> A scanned number before its conversion: mantissa·10^power.
   type :: scan_type
      integer(long) :: mantissa = 0    ! leading digits as an integer
      integer :: n_digits = 0          ! digits in the mantissa
      integer :: n_dropped = 0         ! significant digits that did not fit
      integer :: n_all = 0             ! all digits
      integer :: power = 0             ! power of ten of the mantissa
      logical :: negative = .false.
   end type scan_type

contains

   !> Read the number at or after `position` and move past it.
   !>
   !> If no valid number is found, `position` is the position of the invalid word.
   pure subroutine read_next_number(text, position, value, state, joined, commas)
      character(len=*), intent(in) :: text  !< text to scan
      integer, intent(inout) :: position             !< first character to scan
      real(wp), intent(out) :: value  !< value; 0 if there is no number
      integer, intent(out) :: state                  !< `number_…`
      logical, intent(in), optional :: joined  !< a sign may begin the next number without a blank
      logical, intent(in), optional :: commas        !< .true.: a comma may follow the number
      type(scan_type) :: scan
      integer :: at
      logical :: complete

      value = 0.0_wp
      position = position + count_blanks(text, position)
      state = number_none
      if (position > len(text)) return
      at = position
      call scan_mantissa(text, at, scan)
      call scan_exponent(text, at, scan, complete)
      state = number_bad
      if (.not. complete .or. scan%n_all == 0 .or. at - position > longest_number) return
      if (.not. ends_number(text, at, joined, commas)) return
      call to_value(text(position:at - 1), scan, value, state)
      if (state /= number_found) return
      position = at
      if (.not. present(commas)) return
      at = position + count_blanks(text, position)
      if (commas .and. is_one_of(text, at, ',')) position = at + 1
   end subroutine read_next_number

   !> A value converted to a count; −1 if the value is negative, not whole or too large.
   pure function whole_number(value) result(count)
      real(wp), intent(in) :: value  !< any
      integer(long) :: count

      count = -1_long
      if (value < 0.0_wp .or. value > 1.0e15_wp) return
      if (abs(value - aint(value)) <= 0.0_wp) count = int(value, long)
   end function whole_number

   !> Word at or after a position, for messages.
   pure function word_at(text, position) result(word)
      character(len=*), intent(in) :: text  !< text to scan
      integer, intent(in) :: position  !< first character to scan
      character(len=:), allocatable :: word
      integer :: first

      first = position + count_blanks(text, position)
      word = text(first:first + scan(text(first:)//' ', ' '//tab) - 2)
   end function word_at

   !> Number of blanks and tabs from a position on.
   pure function count_blanks(text, position) result(count)
      character(len=*), intent(in) :: text  !< text to scan
      integer, intent(in) :: position  !< first character to scan
      integer :: count

      count = verify(text(position:), ' '//tab) - 1
      if (count < 0) count = len(text) - position + 1
   end function count_blanks

   !> Scan sign, digits and at most one point.
   pure subroutine scan_mantissa(text, at, scan)
      character(len=*), intent(in) :: text  !< text to scan
      integer, intent(inout) :: at  !< position in the text
      type(scan_type), intent(out) :: scan  !< sign and mantissa
      logical :: after_point

      scan%negative = is_one_of(text, at, '-')
      if (is_one_of(text, at, signs)) at = at + 1
      after_point = .false.
      do
         if (is_one_of(text, at, digits)) then
            call append_digit(scan, iachar(text(at:at)) - iachar('0'), after_point)
         else if (is_one_of(text, at, '.') .and. .not. after_point) then
            after_point = .true.
         else
            exit
         end if
         at = at + 1
      end do
   end subroutine scan_mantissa

   !> Append a digit to the mantissa, unless the mantissa is full.
   pure subroutine append_digit(scan, digit, after_point)
      type(scan_type), intent(inout) :: scan  !< number so far
      integer, intent(in) :: digit  !< 0 … 9
      logical, intent(in) :: after_point  !< the digit is a decimal

      scan%n_all = scan%n_all + 1
      if (scan%n_digits < max_digits) then
         scan%mantissa = 10_long*scan%mantissa + int(digit, long)
         if (scan%mantissa > 0) scan%n_digits = scan%n_digits + 1
         if (after_point) scan%power = scan%power - 1
      else
         scan%n_dropped = scan%n_dropped + 1
         if (.not. after_point) scan%power = scan%power + 1
      end if
   end subroutine append_digit

   !> Scan `E` or `D`, sign, digits; an empty exponent is valid, a letter without digits is not.
   pure subroutine scan_exponent(text, at, scan, complete)
      character(len=*), intent(in) :: text  !< text to scan
      integer, intent(inout) :: at  !< position in the text
      type(scan_type), intent(inout) :: scan  !< number so far
      logical, intent(out) :: complete  !< the exponent has digits, or there is none
      ! largest stored exponent: beyond any valid exponent, without overflow
      integer, parameter :: capped = 100000
      integer :: power
      logical :: negative

      complete = .true.
      if (.not. is_one_of(text, at, 'EeDd')) return
      negative = is_one_of(text, at + 1, '-')
      at = at + merge(2, 1, is_one_of(text, at + 1, signs))
      complete = is_one_of(text, at, digits)
      power = 0
      do while (is_one_of(text, at, digits))
         power = min(10*power + iachar(text(at:at)) - iachar('0'), capped)
         at = at + 1
      end do
      scan%power = scan%power + merge(-power, power, negative)
   end subroutine scan_exponent

   !> .true. if the character at a position is one of a set.
   pure function is_one_of(text, at, characters) result(is)  ! total
      character(len=*), intent(in) :: text  !< text to scan
      integer, intent(in) :: at  !< position in the text
      character(len=*), intent(in) :: characters  !< the set
      logical :: is

      is = .false.
      if (at <= len(text)) is = index(characters, text(at:at)) > 0
   end function is_one_of

   !> .true. if a number may end before the character at a position.
   pure function ends_number(text, at, joined, commas) result(ends)
      character(len=*), intent(in) :: text  !< text to scan
      integer, intent(in) :: at  !< position in the text
      logical, intent(in), optional :: joined, commas  !< options of `read_next_number`
      logical :: ends

      ends = at > len(text) .or. is_one_of(text, at, ' '//tab)
      if (present(joined)) ends = ends .or. (joined .and. is_one_of(text, at, signs))
      if (present(commas)) ends = ends .or. (commas .and. is_one_of(text, at, ','))
   end function ends_number

   !> Convert a scanned number to its value, rounded correctly.
   pure subroutine to_value(number, scan, value, state)
      character(len=*), intent(in) :: number  !< complete text of the number
      type(scan_type), intent(in) :: scan  !< complete number
      real(wp), intent(out) :: value  !< value; 0 if there is no number
      integer, intent(out) :: state  !< `number_…`
      character(len=longest_number) :: padded
      integer :: status

      value = 0.0_wp
      state = number_found
      if (scan%mantissa == 0 .or. scan%power + scan%n_digits < smallest_power) return
      state = number_large
      if (scan%power + scan%n_digits > largest_power) return
      state = number_found
      if (scan%n_dropped == 0 .and. scan%mantissa < 2_long**53 &
         .and. abs(scan%power) <= exact_power) then
         ! Both factors are exact, so one operation rounds once (Clinger 1990, PLDI '90).
         value = real(scan%mantissa, wp)
         if (scan%power >= 0) value = value*10.0_wp**scan%power
         if (scan%power < 0) value = value/10.0_wp**(-scan%power)
         if (scan%negative) value = -value
      else
         padded = number
         read (padded, '(f64.0)', iostat=status) value
         if (status /= 0) state = number_bad
      end if
   end subroutine to_value

end module dda_text_numbers
