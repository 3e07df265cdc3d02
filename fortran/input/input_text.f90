! SPDX-License-Identifier: GPL-3.0-or-later
!> Parser of the text of an input into groups of typed values with their positions.
!>
!> The language is that of Fortran's namelist groups, `&name variable = values /`, with repeat
!> counts (`20*3.5`), omitted values (`1, , 3`), parts of lists (`x(2:4) =`), doubled quotes and
!> comments.
module dda_input_text
   use dda_kinds, only: wp
   use dda_errors, only: error_type, error_input, fail
   use dda_input_catalogue, only: find_group, find_variable, unknown_variable
   use dda_input_schema, only: input_groups, input_rules, input_variables
   use dda_input_variable, only: rule_type, variable_type
   use dda_input_value, only: value_type, take_values, skip_blank, is_assigned, first_word, &
      unreadable, name_characters
   use dda_text, only: to_text, lower_case, quoted
   implicit none
   private
   public :: group_type, span_type, split_groups, parse_group, check_rules, fail_input, given, &
      text_of

   !> One group.
   type :: group_type
      character(len=:), allocatable :: name   !< in lower case
      character(len=:), allocatable :: location  !< "FILE, group &name (line N)"
      integer :: line = 0                     !< line number of its start
      integer :: first = 0, last = 0          !< positions of & and slash in the text
      type(value_type), allocatable :: values(:)  !< given values, in the order of the variables
   end type group_type

   character, parameter :: newline = achar(10)
   character(len=*), parameter :: or = ' or '  !< separator between alternatives of a rule

   !> Position of an assignment in a text.
   type :: span_type
      integer :: variable = 0          !< position of the variable in `input_variables`
      integer :: first = 0, last = 0   !< positions of the name and of the last value
   end type span_type

contains

   !> Set an input error at the position of a group, unless there is an earlier error.
   pure subroutine fail_input(error, group, message)
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(group_type), intent(in) :: group    !< group of the message
      character(len=*), intent(in) :: message  !< sentence without the full stop

      if (.not. allocated(error)) call fail(error, error_input, group%location//': '//message)
   end subroutine fail_input

   !> Parse the values of a group.
   pure subroutine parse_group(text, group, error, spans)
      character(len=*), intent(in) :: text           !< text of the input
      type(group_type), intent(inout) :: group       !< a known group, with its position in the text
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      !> positions of its assignments, for changes of the text
      type(span_type), allocatable, intent(inout), optional :: spans(:)
      type(value_type), allocatable :: values(:)
      character(len=:), allocatable :: failure
      integer :: g, at, v, begin, last

      if (allocated(error)) return
      g = find_group(group%name)
      allocate (values(input_groups(g)%first:input_groups(g)%last))
      at = group%first + len(group%name) + 1
      do
         call skip_separators(text(:group%last), at)
         if (at >= group%last) exit
         begin = at
         call read_variable(text(:group%last), g, at, v, failure)
         if (.not. allocated(failure)) call take_values(text(:group%last), at, &
            input_variables(v), values(v), last, failure)
         if (allocated(failure)) call fail_input(error, group, failure)
         if (allocated(error)) return
         values(v)%variable = v
         if (present(spans)) spans = [spans, span_type(v, begin, last)]
      end do
      call trim_values(values, group%values)
      if (.not. present(spans)) call check_rules(group, g, .true., error)
   end subroutine parse_group

   !> Reduce the list to the given values; their contents are moved, not copied.
   pure subroutine trim_values(values, given_values)
      type(value_type), intent(inout) :: values(:)             !< values of all variables
      type(value_type), allocatable, intent(out) :: given_values(:)    !< values that are given
      integer :: i, n

      allocate (given_values(count(values%variable > 0)))
      n = 0
      do i = 1, size(values)
         if (values(i)%variable == 0) cycle
         n = n + 1
         given_values(n)%variable = values(i)%variable
         given_values(n)%n = values(i)%n
         call move_alloc(values(i)%numbers, given_values(n)%numbers)
         call move_alloc(values(i)%words, given_values(n)%words)
      end do
   end subroutine trim_values

   !> Read the variable whose name is at a position.
   pure subroutine read_variable(text, g, at, v, failure)
      character(len=*), intent(in) :: text   !< text up to the slash of the group
      integer, intent(in) :: g               !< position of the group in `input_groups`
      integer, intent(inout) :: at           !< position of the name; on return, behind the variable
      integer, intent(out) :: v              !< position in `input_variables`
      character(len=:), allocatable, intent(inout) :: failure  !< message; allocated on failure
      character(len=:), allocatable :: name

      v = 0
      if (.not. is_assigned(text, at)) then
         failure = unreadable(text(at:))
         return
      end if
      name = lower_case(text(at:min(len(text), at + 64)))
      name = name(:verify(name, name_characters) - 1)
      at = at + len(name)
      do v = input_groups(g)%first, input_groups(g)%last
         if (input_variables(v)%name == name) return
      end do
      failure = unknown_variable(trim(input_groups(g)%name), name)
   end subroutine read_variable

   !> Check that a group satisfies the rules of the schema: variables that need or exclude each
   !> other.
   pure subroutine check_rules(group, g, only_words, error)
      type(group_type), intent(in) :: group  !< group with its values
      integer, intent(in) :: g               !< position of the group in `input_groups`
      logical, intent(in) :: only_words  !< check only exclusions by words, for incomplete groups
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer :: r, at, first
      logical :: fulfilled

      do r = 1, size(input_rules)
         associate (rule => input_rules(r), item => input_rules(r)%item)
            if (rule%group /= g .or. allocated(error)) cycle
            if (only_words .and. (index(item, ' = ') == 0 .or. index(item, or) > 0)) cycle
            if (.not. satisfies(group, trim(rule%holder), .false.)) cycle
            fulfilled = .false.
            first = 1
            do while (first <= len_trim(item) .and. .not. fulfilled)
               at = index(item(first:)//or, or) - 1
               fulfilled = satisfies(group, trim(item(first:first + at - 1)), .not. rule%excludes)
               first = first + at + len(or)
            end do
            if (fulfilled .eqv. rule%excludes) call fail_input(error, group, &
               violation_text(group, rule))
         end associate
      end do
   end subroutine check_rules

   !> .true. if a group satisfies the condition of a rule.
   pure logical function satisfies(group, condition, unknown)
      type(group_type), intent(in) :: group      !< group with its values
      character(len=*), intent(in) :: condition  !< see `rule_type`
      logical, intent(in) :: unknown             !< result if a word has no valid value
      character(len=:), allocatable :: word
      integer :: at

      at = index(condition, ' = ')
      satisfies = condition == ''
      if (at > 0) then
         word = word_of(group, condition(:at - 1))
         satisfies = index(condition(at:), "'"//word//"'") > 0
         if (word == '') satisfies = unknown
      else if (given(group, condition)) then
         at = findloc(input_variables(group%values%variable)%name == condition, .true., 1)
         satisfies = .true.
         if (is_logical(group, condition)) satisfies = group%values(at)%numbers(1) > 0.0_wp
      end if
   end function satisfies

   !> Message on a violated rule, and what to do.
   pure function violation_text(group, rule) result(message)
      type(group_type), intent(in) :: group  !< group with its values
      type(rule_type), intent(in) :: rule    !< rule that the group violates
      character(len=:), allocatable :: message, owner, item

      owner = trim(rule%holder)
      item = trim(rule%item)
      if (index(owner, ' = ') > 0) owner = owner(:index(owner, ' = ') + 2)// &
         quoted(word_of(group, owner(:index(owner, ' = ') - 1)))
      if (is_logical(group, item)) item = item//' = .true.'
      if (rule%excludes .and. index(owner, ' = ') > 0) then
         message = owner//' excludes '//item//': leave it out'
      else if (rule%excludes) then
         message = 'give either '//owner//' or '//item//', not both'
      else if (owner == '') then
         message = 'give '//item
      else if (index(item, or) > 0) then
         message = owner//' needs '//item
      else if (index(item, "'") > 0) then
         item = item(:index(item, ' ') - 1)
         message = owner//' belongs to '//trim(rule%item)//', but the '//item//' here is '// &
            quoted(word_of(group, item))//': change the '//item//', or leave out '//owner
      else
         message = item//' is missing: '//owner//' needs it'
      end if
   end function violation_text

   !> .true. if the value of a variable is a logical value.
   pure logical function is_logical(group, name)
      type(group_type), intent(in) :: group   !< group of the input
      character(len=*), intent(in) :: name    !< name of the variable
      type(variable_type) :: variable

      variable = find_variable(group%name, name)
      is_logical = variable%kind == 'logical'
   end function is_logical

   !> Value of a word, as given or by default; blank if it is not permitted.
   pure function word_of(group, name) result(word)
      type(group_type), intent(in) :: group  !< group with its values
      character(len=*), intent(in) :: name   !< name of the variable
      character(len=:), allocatable :: word

      associate (variable => find_variable(group%name, name))
         word = text_of(group, name)
         if (word == '') word = trim(variable%usual)
         if (index(variable%allowed, "'"//word//"'") == 0) word = ''
      end associate
   end function word_of

   !> .true. if a group gives a variable.
   pure logical function given(group, name)  ! total
      type(group_type), intent(in) :: group   !< group of the input
      character(len=*), intent(in) :: name    !< name of the variable

      given = any(input_variables(group%values%variable)%name == name .and. group%values%n > 0)
   end function given

   !> Text that a group gives for a variable; blank if none.
   pure function text_of(group, name) result(text)  ! total
      type(group_type), intent(in) :: group  !< group with its values
      character(len=*), intent(in) :: name   !< name of the variable
      character(len=:), allocatable :: text
      integer :: i

      text = ''
      do i = 1, size(group%values)
         if (input_variables(group%values(i)%variable)%name == name) &
            call group%values(i)%get_text(1, text)
      end do
   end function text_of

   !> Move past blanks, comments and commas.
   pure subroutine skip_separators(text, at)
      character(len=*), intent(in) :: text  !< text of the input
      integer, intent(inout) :: at          !< position in the text

      do
         call skip_blank(text, at)
         if (at > len(text)) return
         if (text(at:at) /= ',') return
         at = at + 1
      end do
   end subroutine skip_separators

   !> Split a text into groups; outside them only comments and blanks are allowed.
   subroutine split_groups(file, text, groups, error)
      character(len=*), intent(in) :: file  !< for messages
      character(len=*), intent(in) :: text  !< text of the input
      type(group_type), allocatable, intent(out) :: groups(:)  !< groups in the order of the text
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      integer :: at, line, count

      allocate (groups(16))
      count = 0
      at = 1
      line = 1
      if (index(text, char(239)//char(187)//char(191)) == 1) at = 4   ! byte-order mark
      if (index(text, achar(0)) > 0) call fail(error, error_input, file// &
         ' is not a text file: byte '//to_text(index(text, achar(0)))//' is zero')
      do while (.not. allocated(error))
         call skip_blank(text, at, line)
         if (at > len(text)) exit
         if (text(at:at) /= '&') call fail(error, error_input, file//', line '//to_text(line)// &
            ': expected a group (&name), found '//first_word(text(at:))// &
            slash_text(groups(:count), text(:at - 1)))
         if (allocated(error)) return
         if (count == size(groups)) call reserve_groups(groups, 2*count)
         count = count + 1
         call read_group(file, text, at, line, groups(count), error)
      end do
      call reserve_groups(groups, count)
   end subroutine split_groups

   !> Text on a slash that is part of a unit but has closed a group; blank if there is none.
   pure function slash_text(groups, text) result(words)
      type(group_type), intent(in) :: groups(:)  !< groups so far
      character(len=*), intent(in) :: text       !< text before a word that belongs to no group
      character(len=:), allocatable :: words

      words = ''
      if (size(groups) == 0) return
      if (groups(size(groups))%last == len(text)) words = '; the slash before it closes &'// &
         groups(size(groups))%name//': values have no units'
   end function slash_text

   !> Read one group up to its closing slash.
   subroutine read_group(file, text, at, line, group, error)
      character(len=*), intent(in) :: file, text  !< path, for messages; text of the input
      integer, intent(inout) :: at, line  !< position in the text, line number
      type(group_type), intent(out) :: group  !< name and position of the group
      type(error_type), allocatable, intent(inout) :: error  !< allocated on failure
      integer :: length, lines

      group%line = line
      group%first = at
      length = max(0, verify(lower_case(text(at + 1:min(len(text), at + 64))), name_characters) - 1)
      group%name = lower_case(text(at + 1:at + length))
      group%location = file//', group &'//group%name//' (line '//to_text(line)//')'
      call find_slash(text, at, group%last, lines)
      if (group%last == 0) call fail(error, error_input, file//': group &'//group%name// &
         ' (line '//to_text(line)//') has no closing slash, or an unclosed quote')
      at = group%last + 1
      line = line + lines
   end subroutine read_group

   !> Find the slash that closes the group at `first`; 0 if the next group begins before it.
   pure subroutine find_slash(text, first, last, lines)
      character(len=*), intent(in) :: text  !< text of the input
      integer, intent(in) :: first  !< position of the & of the group
      integer, intent(out) :: last, lines  !< position of the slash; line ends before it
      character :: quote

      last = first
      lines = 0
      quote = ' '
      do
         last = last + 1
         if (quote == ' ') call skip_blank(text, last, lines)
         if (last > len(text)) exit
         select case (text(last:last))
         case ("'", '"')
            if (quote == ' ') then
               quote = text(last:last)
            else if (quote == text(last:last)) then
               quote = ' '
            end if
         case ('/')
            if (quote == ' ') return
         case ('&')
            if (quote == ' ') exit
         case (newline)
            lines = lines + 1
         end select
      end do
      last = 0
   end subroutine find_slash

   !> Reserve space for groups without copying their contents.
   subroutine reserve_groups(groups, n)
      type(group_type), allocatable, intent(inout) :: groups(:)  !< groups; on return [n]
      integer, intent(in) :: n                                   !< groups
      type(group_type), allocatable :: resized(:)
      integer :: i

      allocate (resized(n))
      do i = 1, min(n, size(groups))
         resized(i)%line = groups(i)%line
         resized(i)%first = groups(i)%first
         resized(i)%last = groups(i)%last
         call move_alloc(groups(i)%name, resized(i)%name)
         call move_alloc(groups(i)%location, resized(i)%location)
      end do
      call move_alloc(resized, groups)
   end subroutine reserve_groups

end module dda_input_text
