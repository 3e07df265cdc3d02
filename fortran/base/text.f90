! SPDX-License-Identifier: GPL-3.0-or-later
!> Numbers and names as text, for messages.
module dda_text
   use dda_kinds, only: wp, long
   implicit none
   private
   public :: to_text, short_text, lower_case, quoted, whole_characters, valid_text, joined, &
      closest, counted, wrapped, padded, screen_width

   integer, parameter :: screen_width = 80  !< width of a screen, characters

   !> Write a number with as few characters as possible.
   interface to_text
      module procedure integer_to_text
      module procedure long_to_text
      module procedure real_to_text
      module procedure pair_to_text
   end interface to_text

contains

   !> Text of a default integer.
   pure function integer_to_text(value) result(text)
      integer, intent(in) :: value  !< any
      character(len=:), allocatable :: text

      text = long_to_text(int(value, long))
   end function integer_to_text

   !> Text of a 64-bit integer.
   pure function long_to_text(value) result(text)
      integer(long), intent(in) :: value  !< any
      character(len=:), allocatable :: text
      character(len=24) :: buffer

      write (buffer, '(i0)') value
      text = trim(buffer)
   end function long_to_text

   !> Text with six significant digits, in plain notation if that is short.
   pure function real_to_text(value) result(text)
      real(wp), intent(in) :: value  !< any
      character(len=:), allocatable :: text
      character(len=32) :: buffer

      if (value == 0.0_wp) then
         text = '0'
      else if (abs(value) >= 1.0e-3_wp .and. abs(value) < 1.0e6_wp) then
         write (buffer, '(f32.6)') value
         text = without_trailing_zeros(trim(adjustl(buffer)))
      else
         write (buffer, '(es13.5e3)') value
         text = short_exponent(trim(adjustl(buffer)))
      end if
   end function real_to_text

   !> Text of two numbers, such as a position: 'x, y'.
   pure function pair_to_text(values) result(text)
      real(wp), intent(in) :: values(2)  !< any
      character(len=:), allocatable :: text

      text = real_to_text(values(1))//', '//real_to_text(values(2))
   end function pair_to_text

   !> Text with four significant digits; with powers of ten if plain notation is long.
   pure function short_text(value) result(text)
      real(wp), intent(in) :: value  !< number to write
      character(len=:), allocatable :: text
      integer, parameter :: digits = 4
      character(len=24) :: buffer
      integer :: decimals

      if (.not. abs(value) > 0.0_wp .or. abs(value) > huge(value)) then
         text = to_text(value)
      else if (abs(value) < 1.0e-3_wp .or. abs(value) >= 1.0e6_wp) then
         write (buffer, '(es24.'//to_text(digits - 1)//'e3)') value
         text = short_exponent(trim(adjustl(buffer)))
      else
         decimals = max(0, digits - 1 - floor(log10(abs(value))))
         write (buffer, '(f24.'//to_text(decimals)//')') value
         text = without_trailing_zeros(trim(adjustl(buffer)))
      end if
   end function short_text

   !> Remove trailing zeros of a decimal number, and a trailing point.
   pure function without_trailing_zeros(digits) result(text)
      character(len=*), intent(in) :: digits  !< number such as 1.500
      character(len=:), allocatable :: text

      text = digits
      if (index(digits, '.') == 0) return
      text = digits(:verify(digits, '0', back=.true.))
      if (text(len(text):) == '.') text = text(:len(text) - 1)
   end function without_trailing_zeros

   !> Convert 1.500E-007 to 1.5e-7; other texts are unchanged.
   pure function short_exponent(number) result(text)
      character(len=*), intent(in) :: number  !< number with an exponent
      character(len=:), allocatable :: text
      integer :: e, power, status

      text = number
      e = index(number, 'E')
      if (e == 0) return
      read (number(e + 1:), *, iostat=status) power
      if (status == 0) text = without_trailing_zeros(number(:e - 1))//'e'//to_text(power)
   end function short_exponent

   !> Convert ASCII letters to lower case.
   pure function lower_case(text) result(lowered)  ! total
      character(len=*), intent(in) :: text  !< any
      character(len=len(text)) :: lowered
      integer :: i, code

      do i = 1, len(text)
         code = iachar(text(i:i))
         if (code >= iachar('A') .and. code <= iachar('Z')) code = code + 32
         lowered(i:i) = achar(code)
      end do
   end function lower_case

   !> Text in quotes, without trailing blanks, cut if it is very long.
   pure function quoted(text) result(content)
      character(len=*), intent(in) :: text  !< any
      character(len=:), allocatable :: content
      integer, parameter :: max_length = 80

      content = trim(text)
      if (len(content) > max_length) content = whole_characters(content(:max_length))//'…'
      content = "'"//content//"'"
   end function quoted

   !> Remove an incomplete character of several bytes from the end of a cut text (UTF-8).
   pure function whole_characters(text) result(complete)
      character(len=*), intent(in) :: text  !< any
      character(len=:), allocatable :: complete
      integer :: last

      last = len(text)
      do while (last > 0)
         if (iachar(text(last:last)) < 128) exit
         last = last - 1
         if (iachar(text(last + 1:last + 1)) >= 192) exit
      end do
      complete = text(:last)
      if (last < len(text)) then
         if (length_of_character(text(last + 1:last + 1)) == len(text) - last) complete = text
      end if
   end function whole_characters

   !> Number of bytes of a character, from its first byte.
   pure integer function length_of_character(first) result(bytes)
      character, intent(in) :: first  !< byte of a character

      bytes = 2
      if (iachar(first) >= 224) bytes = 3
      if (iachar(first) >= 240) bytes = 4
   end function length_of_character

   !> Replace bytes that belong to no character (UTF-8, RFC 3629) by question marks.
   pure function valid_text(text) result(valid)
      character(len=*), intent(in) :: text  !< any bytes
      character(len=len(text)) :: valid
      integer :: at, bytes

      valid = text
      at = 1
      do while (at <= len(text))
         bytes = 1
         if (iachar(text(at:at)) >= 128) then
            bytes = length_of_character(text(at:at))
            if (.not. is_character(text(at:min(at + bytes - 1, len(text))), bytes)) then
               bytes = 1
               valid(at:at) = '?'
            end if
         end if
         at = at + bytes
      end do
   end function valid_text

   !> .true. if bytes, the first of which is above 127, form one character.
   pure logical function is_character(bytes, length)
      character(len=*), intent(in) :: bytes  !< possible character
      integer, intent(in) :: length          !< length that the first byte requires
      integer :: code(4), i, lowest, highest

      is_character = .false.
      if (len(bytes) /= length) return
      code(:length) = [(iachar(bytes(i:i)), i=1, length)]
      lowest = 128
      highest = 191
      if (code(1) == 224) lowest = 160
      if (code(1) == 237) highest = 159
      if (code(1) == 240) lowest = 144
      if (code(1) == 244) highest = 143
      is_character = code(1) >= 194 .and. code(1) <= 244 .and. code(2) >= lowest &
         .and. code(2) <= highest .and. all(code(3:length) >= 128 .and. code(3:length) <= 191)
   end function is_character

   !> Text of a count with its noun: 1 step, 3 steps.
   pure function counted(count, singular, plural) result(text)
      character(len=*), intent(in) :: count      !< digits of the count
      character(len=*), intent(in) :: singular, plural  !< singular and plural of the noun
      character(len=:), allocatable :: text

      text = count//' '//plural
      if (count == '1') text = count//' '//singular
   end function counted

   !> Number of characters of a text in UTF-8.
   pure integer function characters(text)
      character(len=*), intent(in) :: text  !< valid UTF-8
      integer :: i

      characters = count([(iachar(text(i:i)) < 128 .or. iachar(text(i:i)) >= 192, i=1, len(text))])
   end function characters

   !> Pad a text with blanks to a minimum length.
   pure function padded(text, width) result(line)
      character(len=*), intent(in) :: text  !< in UTF-8
      integer, intent(in) :: width          !< characters
      character(len=:), allocatable :: line

      line = text//repeat(' ', max(0, width - characters(text)))
   end function padded

   !> Wrap a text at blanks to a width; every line ends with a line end.
   !> The caller has written the indent of the first line.
   pure function wrapped(words, indent, width) result(text)
      character(len=*), intent(in) :: words  !< words with single blanks between
      integer, intent(in) :: indent          !< blanks before each further line
      integer, intent(in) :: width           !< width of a line, indent included
      character(len=:), allocatable :: text
      integer :: from, to, column, word_width

      text = ''
      column = indent
      from = 1
      do while (from <= len_trim(words))
         to = from + index(words(from:)//' ', ' ') - 2
         word_width = characters(words(from:to))
         if (column > indent .and. column + 1 + word_width > width) then
            text = text//new_line('a')//repeat(' ', indent)
            column = indent
         else if (column > indent) then
            text = text//' '
            column = column + 1
         end if
         text = text//words(from:to)
         column = column + word_width
         from = to + 2
      end do
      text = text//new_line('a')
   end function wrapped

   !> Join words with a separator.
   pure function joined(items, separator) result(text)
      character(len=*), intent(in) :: items(:)   !< trailing blanks are dropped
      character(len=*), intent(in) :: separator    !< ', ' for example
      character(len=:), allocatable :: text
      integer :: i

      text = ''
      do i = 1, size(items)
         if (i > 1) text = text//separator
         text = text//trim(items(i))
      end do
   end function joined

   !> Find the most similar word; 0 if none is similar.
   !> A similar word differs in at most about a third of its letters (Levenshtein 1966), or begins
   !> with the given word.
   pure integer function closest(name, names) result(best)
      character(len=*), intent(in) :: name       !< word to find
      character(len=*), intent(in) :: names(:)   !< known words; trailing blanks are ignored
      integer :: i, difference, smallest_distance

      best = 0
      if (len_trim(name) < 2) return
      smallest_distance = max(1, (min(len_trim(name), 64) + 1)/3) + 1
      do i = 1, size(names)
         difference = edit_distance(lower_case(trim(name(:min(len(name), 64)))), trim(names(i)))
         if (difference < smallest_distance) best = i
         smallest_distance = min(smallest_distance, difference)
      end do
      do i = 1, size(names)
         if (best == 0 .and. index(names(i), lower_case(trim(name))) == 1) best = i
      end do
   end function closest

   !> Number of letters to insert, remove or replace to convert one word into another.
   pure integer function edit_distance(a, b)
      character(len=*), intent(in) :: a, b       !< trailing blanks count
      integer :: cost(0:len(b)), diagonal, above, i, j

      cost = [(j, j=0, len(b))]
      do i = 1, len(a)
         diagonal = cost(0)
         cost(0) = i
         do j = 1, len(b)
            above = cost(j)
            cost(j) = min(above + 1, cost(j - 1) + 1, diagonal + merge(0, 1, a(i:i) == b(j:j)))
            diagonal = above
         end do
      end do
      edit_distance = cost(len(b))
   end function edit_distance

end module dda_text
