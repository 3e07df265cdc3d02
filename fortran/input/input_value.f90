! SPDX-License-Identifier: GPL-3.0-or-later
!> Values of one variable in the text of an input.
module dda_input_value
   use dda_growth, only: grow
   use dda_input_variable, only: variable_type, unset
   use dda_kinds, only: wp
   use dda_text, only: lower_case, quoted, whole_characters
   use dda_text_numbers, only: read_next_number, number_found
   implicit none
   private
   public :: value_type, take_values, skip_blank, is_assigned, first_word, unreadable, &
      name_characters

   character(len=*), parameter :: name_characters = 'abcdefghijklmnopqrstuvwxyz0123456789_'
   character(len=*), parameter :: letters = name_characters(:26)
   character(len=*), parameter :: digits = name_characters(27:36)
   character, parameter :: newline = achar(10), carriage_return = achar(13), tab = achar(9)
   character(len=*), parameter :: blanks = ' '//tab//newline//carriage_return
   character(len=*), parameter :: ends = blanks//',/!' !< characters that end a value without quotes

   !> A text that may be omitted.
   type :: word_type
      character(len=:), allocatable :: text
   end type word_type

   !> The values of a variable.
   type :: value_type
      integer :: variable = 0                 !< position in `input_variables`; 0: not given
      integer :: n = 0                        !< number of values, up to the last given one
      real(wp), allocatable :: numbers(:)     !< [n] `unset` if omitted; logical values are 0 and 1
      type(word_type), allocatable :: words(:)  !< [≥ n]
   contains
      procedure :: get_text => get_text_at
   end type value_type

   !> Positions of a list that an assignment sets.
   type :: part_type
      integer :: first = 1, step = 1, count = 1
   end type part_type

contains

   !> Read the values after a variable's name, up to the next name or the slash.
   pure subroutine take_values(text, at, variable, value, last, failure)
      character(len=*), intent(in) :: text             !< text up to the slash of the group
      integer, intent(inout) :: at  !< position after the name; on return at the next token
      type(variable_type), intent(in) :: variable      !< variable of the schema
      type(value_type), intent(inout) :: value         !< earlier value, if given
      integer, intent(out) :: last                     !< end of the last value
      character(len=:), allocatable, intent(out) :: failure  !< text of the problem; blank: none
      type(part_type) :: part
      integer :: next, repeats
      logical :: is_due

      call read_part(text, at, variable, part, failure)
      last = at - 1
      next = 0
      is_due = .true.   ! a comma here means an omitted value
      do while (.not. allocated(failure))
         call skip_blank(text, at)
         if (text(at:at) == '/') exit
         if (text(at:at) == ',') then
            if (is_due) next = next + 1
            at = at + 1
         else
            if (is_assigned(text, at)) exit
            call read_repeats(text, at, variable, repeats, failure)
            if (allocated(failure)) exit
            if (index(ends, text(at:at)) == 0) call read_item(text, at, variable, &
               part_type(part%first + next*part%step, part%step, merge(repeats, 0, next + repeats &
               <= part%count)), value, failure)
            next = next + repeats
         end if
         last = at - 1
         is_due = text(at - 1:at - 1) == ','
      end do
      if (.not. allocated(value%numbers)) return
      if (size(value%numbers) > value%n) value%numbers = value%numbers(:value%n)
   end subroutine take_values

   !> Read the subscript that follows a variable's name, such as (2) or (3:6), and the equals sign.
   pure subroutine read_part(text, at, variable, part, failure)
      character(len=*), intent(in) :: text         !< text of the group
      integer, intent(inout) :: at  !< position after the name; on return after the equals sign
      type(variable_type), intent(in) :: variable  !< variable of the schema
      type(part_type), intent(out) :: part         !< positions to fill
      character(len=:), allocatable, intent(inout) :: failure  !< allocated if the part is invalid
      integer :: bracket, comma
      type(part_type) :: inner

      part = part_type(1, 1, max(variable%size, 1))
      call skip_blank(text, at)
      if (text(at:at) == '(') then
         bracket = at + index(text(at:), ')') - 1
         comma = index(text(at:bracket), ',')
         if (variable%size == 0) then
            part%count = 0
         else if (comma > 0 .and. variable%kind == 'points') then
            call read_range(text(at + 1:at + comma - 2), 2, inner)
            call read_range(text(at + comma:bracket - 1), variable%size/2, part)
            if (inner%count == 1) then
               part = part_type(2*part%first - 2 + inner%first, 2*part%step, part%count)
            else if (inner%count == 2 .and. (part%step == 1 .or. part%count == 1)) then
               part = part_type(2*part%first - 1, 1, 2*part%count)
            else
               part%count = 0
            end if
         else
            call read_range(text(at + 1:bracket - 1), variable%size, part)
            ! Further values are stored in the positions after the given subscript.
            if (part%count == 1) part%count = variable%size - part%first + 1
         end if
         if (part%count == 0) failure = trim(variable%name)//': there is no element '// &
            text(at:bracket)//' in the list'
         at = bracket + 1
      end if
      at = at + index(text(at:), '=')
   end subroutine read_part

   !> Read a range 'first:last:step', or one position.
   pure subroutine read_range(text, size, range)
      character(len=*), intent(in) :: text     !< text between brackets and commas
      integer, intent(in) :: size              !< size of the list
      type(part_type), intent(out) :: range    !< range; empty if outside the list
      integer :: colon, second, last, status(3)

      colon = index(text, ':')
      second = index(text, ':', back=.true.)
      last = size
      status = 0
      if (colon == 0) then
         call read_integer(text, range%first, status(1))
         last = range%first
      else
         call read_integer(text(:colon - 1), range%first, status(1))
         if (second > colon) call read_integer(text(second + 1:), range%step, status(3))
         if (second == colon) second = len(text) + 1
         call read_integer(text(colon + 1:second - 1), last, status(2))
      end if
      range%count = 0
      if (any(status /= 0) .or. range%first < 1 .or. last > size .or. range%step < 1) return
      range%count = max(0, (last - range%first)/range%step + 1)
   end subroutine read_range

   !> Read a whole number; unchanged if none is given.
   pure subroutine read_integer(text, number, status)
      character(len=*), intent(in) :: text  !< digits, or blanks
      integer, intent(inout) :: number      !< number
      integer, intent(out) :: status        !< 0: the text is a number
      character(len=:), allocatable :: word

      word = trim(adjustl(text))
      status = 0
      if (word == '') return
      status = verify(word, digits)
      if (status == 0) read (word, *, iostat=status) number
   end subroutine read_integer

   !> Read a repeat count before a value, such as 20*; 1 if there is none.
   pure subroutine read_repeats(text, at, variable, repeats, failure)
      character(len=*), intent(in) :: text         !< text of the group
      integer, intent(inout) :: at  !< position of the value; on return after the count
      type(variable_type), intent(in) :: variable  !< variable of the schema
      integer, intent(out) :: repeats              !< number of repetitions of the value
      character(len=:), allocatable, intent(inout) :: failure  !< allocated if the count is invalid
      integer :: length, status

      repeats = 1
      length = verify(text(at:), digits) - 1
      if (length < 1) return
      if (text(at + length:at + length) /= '*') return
      read (text(at:at + length - 1), *, iostat=status) repeats
      if (status /= 0 .or. repeats < 1 .or. repeats > max(variable%size, 1)) failure = &
         trim(variable%name)//': '//text(at:at + min(length, 20))//' is not a possible '// &
         'number of values'
      at = at + length + 1
   end subroutine read_repeats

   !> Read one value and store it in positions of the list.
   pure subroutine read_item(text, at, variable, positions, value, failure)
      character(len=*), intent(in) :: text         !< text of the group
      integer, intent(inout) :: at  !< position of the value; on return, behind the value
      type(variable_type), intent(in) :: variable  !< variable of the schema
      type(part_type), intent(in) :: positions        !< positions to fill; none if the list is full
      type(value_type), intent(inout) :: value     !< receives the value
      character(len=:), allocatable, intent(inout) :: failure  !< allocated if the value is invalid
      character(len=:), allocatable :: word
      real(wp) :: number
      logical :: fits

      if (positions%count < 1) then
         failure = unreadable(text(at:))
      else if (any(variable%kind == ['name', 'word', 'text'])) then
         call read_word(text, at, word)
         if (allocated(word)) then
            if (index(variable%allowed, "'"//lower_case(word)//"'") > 0) word = lower_case(word)
            call put_word(value, positions, word)
         else
            failure = trim(variable%name)//': '//first_word(text(at:))//' must be in quotes'
         end if
      else
         call read_number(text, at, variable%kind == 'logical', number, fits)
         if (fits) then
            call put_number(value, positions, number)
         else
            failure = trim(variable%name)//': '//first_word(text(at:))//' is '// &
               trim(merge('neither .true. nor .false.', 'not a number              ', &
               variable%kind == 'logical'))
         end if
      end if
   end subroutine read_item

   !> Read a text in quotes (two quotes inside mean one), or a text that begins with a digit.
   pure subroutine read_word(text, at, word)
      character(len=*), intent(in) :: text  !< text of the group
      integer, intent(inout) :: at          !< position of the text; on return, behind the text
      character(len=:), allocatable, intent(out) :: word  !< word; not allocated if missing
      integer :: length, i
      character :: quote

      quote = text(at:at)
      if (index(digits, quote) > 0) then
         length = scan(text(at:), ends) - 1
         word = text(at:at + length - 1)
         at = at + length
      else if (quote == "'" .or. quote == '"') then
         word = ''
         do
            length = index(text(at + 1:), quote)
            word = word//text(at + 1:at + length - 1)
            at = at + length + 1
            if (text(at:at) /= quote) exit
            word = word//quote
         end do
         do i = 1, len(word)
            if (iachar(word(i:i)) < 32) word(i:i) = ' '
         end do
         word = trim(word)
      end if
   end subroutine read_word

   !> Read a number, or a logical value as 0 or 1.
   pure subroutine read_number(text, at, logical_wanted, number, fits)
      character(len=*), intent(in) :: text    !< text of the group
      integer, intent(inout) :: at            !< position of the value; on return, behind the value
      logical, intent(in) :: logical_wanted   !< read a logical value: .true. or T, .false. or F
      real(wp), intent(out) :: number         !< number; infinite if too large
      logical, intent(out) :: fits            !< .false. if it is not a number
      character(len=:), allocatable :: word
      integer :: last, from, state

      last = at + scan(text(at:), ends//"'""") - 2
      number = 0.0_wp
      if (logical_wanted) then
         word = lower_case(text(at:min(last, at + 1)))
         if (index(word, '.') == 1) word = word(2:)
         fits = index(word, 't') == 1 .or. index(word, 'f') == 1
         if (index(word, 't') == 1) number = 1.0_wp
      else
         from = 1
         call read_next_number(text(at:last), from, number, state)
         fits = state == number_found
         if (.not. fits) call parse_unusual(lower_case(text(at:last)), number, fits)
      end if
      if (fits) at = last + 1
   end subroutine read_number

   !> Read infinities, NaN, and numbers in forms that only Fortran writes.
   pure subroutine parse_unusual(text, number, fits)
      character(len=*), intent(in) :: text  !< in lower case
      real(wp), intent(out) :: number       !< its value
      logical, intent(out) :: fits          !< .false. if it is not a number
      integer :: status, sign

      number = 0.0_wp
      sign = verify(text//'x', '+-')
      fits = sign <= 2 .and. (index(text(sign:), 'inf') == 1 .or. index(text(sign:), 'nan') == 1)
      if (.not. fits) fits = verify(text, digits//'+-.edq') == 0 .and. scan(text, digits) > 0
      if (.not. fits) return
      read (text, *, iostat=status) number
      if (status /= 0 .and. scan(text, digits) > 0 .and. scan(text, '+-', back=.true.) < 2) &
         number = huge(number)  ! the value is beyond the range
      fits = status == 0 .or. number > 0.0_wp
   end subroutine parse_unusual

   !> Store a number in positions of a list.
   pure subroutine put_number(value, positions, number)
      type(value_type), intent(inout) :: value  !< receives the value
      type(part_type), intent(in) :: positions     !< positions to fill
      real(wp), intent(in) :: number            !< its value
      integer :: last

      last = positions%first + (positions%count - 1)*positions%step
      if (last > value%n) then
         call grow(value%numbers, last)
         value%numbers(value%n + 1:last) = unset
         value%n = last
      end if
      value%numbers(positions%first:last:positions%step) = number
   end subroutine put_number

   !> Store a text in positions of a list.
   pure subroutine put_word(value, positions, text)
      type(value_type), intent(inout) :: value  !< receives the value
      type(part_type), intent(in) :: positions     !< positions to fill
      character(len=*), intent(in) :: text      !< the text
      type(word_type), allocatable :: longer(:)
      integer :: i, last

      last = positions%first + (positions%count - 1)*positions%step
      if (.not. allocated(value%words)) allocate (value%words(0))
      if (last > size(value%words)) then
         allocate (longer(max(last, 2*size(value%words))))
         do i = 1, value%n
            call move_alloc(value%words(i)%text, longer(i)%text)
         end do
         call move_alloc(longer, value%words)
      end if
      do i = positions%first, last, positions%step
         value%words(i)%text = text
      end do
      value%n = max(value%n, last)
   end subroutine put_word

   !> .true. if a variable name and its equals sign are at a position.
   pure logical function is_assigned(text, at)
      character(len=*), intent(in) :: text  !< text of the group
      integer, intent(in) :: at             !< position in the text
      integer :: next

      is_assigned = .false.
      if (index(letters, lower_case(text(at:at))) == 0) return
      next = at + verify(lower_case(text(at:min(len(text), at + 64)))//'/', name_characters) - 1
      call skip_blank(text, next)
      if (text(next:next) == '(') then
         next = next + index(text(next:), ')')
         call skip_blank(text, next)
      end if
      is_assigned = text(next:next) == '='
   end function is_assigned

   !> Move past blanks, line ends and comments.
   pure subroutine skip_blank(text, at, line)
      character(len=*), intent(in) :: text       !< text of the input
      integer, intent(inout) :: at               !< position in the text
      integer, intent(inout), optional :: line   !< line number at the position
      integer :: length

      do while (at <= len(text))
         if (text(at:at) == '!') then
            length = index(text(at:), newline)
            if (length == 0) length = len(text) - at + 2
            at = at + length - 1
            cycle
         end if
         if (text(at:at) > ' ' .and. text(at:at) /= achar(127)) return
         if (present(line) .and. text(at:at) == newline) line = line + 1
         at = at + 1
      end do
   end subroutine skip_blank

   !> First word of a text in quotes, for messages.
   pure function first_word(text) result(word)
      character(len=*), intent(in) :: text  !< text of the input
      character(len=:), allocatable :: word
      integer :: i, length

      if (scan(text(:1), '''"') > 0) then
         word = quoted(text(2:index(text(2:)//text(:1), text(:1))))
         do i = 1, len(word)
            if (iachar(word(i:i)) < 32) word(i:i) = ' '
         end do
         return
      end if
      length = scan(text//' ', ends) - 1
      if (length == 0) length = 1
      word = quoted(whole_characters(text(:min(length, 40))))
   end function first_word

   !> Message on a word that is neither a value nor the name of a variable.
   pure function unreadable(text) result(failure)
      character(len=*), intent(in) :: text  !< text of the input
      character(len=:), allocatable :: failure

      failure = first_word(text)//' cannot be read here, because it is not a valid value of '// &
         'the preceding variable, or that variable has all its values'
      if (scan(lower_case(text(:1)), letters) > 0) failure = failure//'; values have no units'
   end function unreadable

   !> Text at a position of the list, if one is given there.
   pure subroutine get_text_at(value, i, text)
      class(value_type), intent(in) :: value  !< value of a name, word or text
      integer, intent(in) :: i                !< position
      character(len=:), allocatable, intent(inout) :: text  !< text as given, or unchanged

      if (i > value%n) return
      if (allocated(value%words(i)%text)) text = value%words(i)%text
   end subroutine get_text_at

end module dda_input_value
