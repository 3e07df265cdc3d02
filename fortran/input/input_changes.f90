! SPDX-License-Identifier: GPL-3.0-or-later
!> Variables of an input changed by name, as --set does: 'time_step=5e-4',
!> 'joint[bedding].friction_angle=30', 'material.clay.density=1900', 'joint[*].cohesion=0'.
module dda_input_changes
   use dda_errors, only: error_type, error_input, fail
   use dda_input_catalogue, only: find_group, find_variable, groups_with, variables_of
   use dda_input_schema, only: input_groups, input_variables
   use dda_input_variable, only: variable_type
   use dda_text, only: closest, lower_case, quoted, to_text
   implicit none
   private
   public :: change_text

   character(len=*), parameter :: name_characters = 'abcdefghijklmnopqrstuvwxyz0123456789_'
   character, parameter :: tab = achar(9), newline = achar(10), carriage_return = achar(13)

   !> What a change says.
   type :: change_type
      character(len=:), allocatable :: path                   !< as written, for messages
      character(len=:), allocatable :: group, which, variable !< which: '' where it is not said
      character(len=:), allocatable :: value                  !< as a namelist holds it
   end type change_type

   !> Where a group stands in a text.
   type :: span_type
      integer :: first = 0, last = 0          !< its & and its slash
      character(len=64) :: group = '', name = ''  !< kind, and its variable name
   end type span_type

contains

   !> The text with one change made; every line keeps its number.
   subroutine change_text(text, assignment, error)
      character(len=:), allocatable, intent(inout) :: text  !< of the input
      character(len=*), intent(in) :: assignment            !< 'NAME=VALUE'
      type(error_type), allocatable, intent(out) :: error   !< allocated on failure
      type(change_type) :: change
      type(span_type), allocatable :: spans(:)
      logical, allocatable :: chosen(:)
      integer :: i

      call parse(assignment, change, error)
      if (allocated(error)) return
      spans = spans_of(text)
      call choose(change, spans, chosen, error)
      if (allocated(error)) return
      do i = size(spans), 1, -1  ! from the end, so that the places of the others stay
         if (chosen(i)) call set_in(text, spans(i), change)
      end do
      if (any(chosen)) return
      if (len(text) > 0) then
         if (text(len(text):) /= newline) text = text//newline
      end if
      text = text//'&'//change%group//' '//change%variable//' = '//change%value//' /'//newline
   end subroutine change_text

   !> An error that names the change.
   subroutine refuse(change, message, error)
      type(change_type), intent(in) :: change  !< with its path
      character(len=*), intent(in) :: message  !< for a person
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays

      if (.not. allocated(error)) call fail(error, error_input, '--set '//change%path//': '// &
         message)
   end subroutine refuse

   !> Group, name and variable of a path, and the value.
   subroutine parse(assignment, change, error)
      character(len=*), intent(in) :: assignment  !< 'NAME=VALUE'
      type(change_type), intent(out) :: change    !< what it says
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      character(len=:), allocatable :: path
      integer :: equals, dot, last

      equals = index(assignment, '=')
      change%path = trim(adjustl(assignment(:max(0, equals - 1))))
      if (equals < 2) then
         change%path = assignment
         call refuse(change, 'must read NAME=VALUE', error)
         return
      end if
      path = change%path
      change%which = ''
      dot = scan(path, '.[')
      if (dot == 0) then
         change%variable = lower_case(path)
         call find_home(change, error)
      else
         change%group = lower_case(trim(path(:dot - 1)))
         last = index(path, '.', back=.true.)
         change%variable = lower_case(trim(adjustl(path(last + 1:))))
         if (path(dot:dot) == '[') then
            change%which = path(dot + 1:max(dot, index(path, ']') - 1))
         else if (last > dot) then
            change%which = path(dot + 1:last - 1)
         end if
      end if
      if (.not. allocated(error)) call check_variable(change, error)
      if (allocated(error)) return
      change%value = value_text(change, assignment(equals + 1:))
      if (change%value == '') call refuse(change, 'a value is needed', error)
   end subroutine parse

   !> The one group that a variable without a group can mean.
   subroutine find_home(change, error)
      type(change_type), intent(inout) :: change  !< with its variable
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      integer, allocatable :: homes(:)

      homes = groups_with(change%variable)
      if (any(homes == find_group('control'))) homes = [find_group('control')]
      if (size(homes) == 1) then
         change%group = trim(input_groups(homes(1))%name)
      else if (size(homes) > 1) then
         call refuse(change, 'this is a variable of several groups: name one, as '// &
            trim(input_groups(homes(1))%name)//'.'//change%variable, error)
      else
         call refuse(change, 'no group has this variable'//meant(change%variable, &
            input_variables%name), error)
      end if
   end subroutine find_home

   !> A hint at the name that is spelt most like another, or nothing.
   pure function meant(word, words) result(hint)
      character(len=*), intent(in) :: word, words(:)  !< not known; known ones
      character(len=:), allocatable :: hint
      integer :: i

      hint = ''
      i = closest(trim(word), words)
      if (i > 0) hint = '; did you mean '//quoted(words(i))//'?'
   end function meant

   !> The group must exist and have the variable.
   subroutine check_variable(change, error)
      type(change_type), intent(in) :: change  !< with group and variable
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(variable_type), allocatable :: own(:)
      type(variable_type) :: variable

      if (find_group(change%group) == 0) then
         call refuse(change, 'there is no group &'//change%group//meant(change%group, &
            input_groups%name), error)
         return
      end if
      variable = find_variable(change%group, change%variable)
      if (variable%name /= '') return
      own = variables_of(change%group)
      call refuse(change, 'group &'//change%group//' has no variable '//quoted(change%variable)// &
         meant(change%variable, own%name), error)
   end subroutine check_variable

   !> The value as a namelist holds it: texts in quotes, logical values with dots.
   function value_text(change, given) result(text)
      type(change_type), intent(in) :: change  !< with group and variable
      character(len=*), intent(in) :: given    !< behind the equals sign
      character(len=:), allocatable :: text
      type(variable_type) :: variable
      integer :: i

      text = trim(adjustl(given))
      variable = find_variable(change%group, change%variable)
      if (variable%kind == 'logical' .and. lower_case(text) == 'true') text = '.true.'
      if (variable%kind == 'logical' .and. lower_case(text) == 'false') text = '.false.'
      if (all(variable%kind /= ['name', 'word', 'text']) .or. scan(text//' ', '''"') == 1) return
      do i = len(text), 1, -1
         if (text(i:i) == "'") text = text(:i)//text(i:)
      end do
      text = "'"//text//"'"
   end function value_text

   !> All groups of a text; what the reader refuses later may be missing.
   function spans_of(text) result(spans)
      character(len=*), intent(in) :: text  !< of the input
      type(span_type), allocatable :: spans(:)
      type(span_type) :: span
      integer :: at, name_end

      allocate (spans(0))
      at = 0
      do
         at = next_mark(text, at + 1)
         if (at > len(text)) return
         if (text(at:at) == '&' .and. span%first == 0) then
            span%first = at
            name_end = verify(lower_case(text(at + 1:min(len(text), at + 64)))//'/', &
               name_characters) - 1
            span%group = lower_case(text(at + 1:at + name_end))
         else if (text(at:at) == '/' .and. span%first > 0) then
            span%last = at
            span%name = name_in(text(span%first:span%last))
            spans = [spans, span]
            span = span_type()
         end if
      end do
   end function spans_of

   !> The next position, from one on, that stands neither in quotes nor in a comment and is &, /, =
   !> or ends the text.
   pure integer function next_mark(text, from) result(at)
      character(len=*), intent(in) :: text  !< of the input
      integer, intent(in) :: from           !< first position looked at
      integer :: length

      at = from
      do while (at <= len(text))
         select case (text(at:at))
         case ('&', '/', '=')
            return
         case ('''', '"')
            length = index(text(at + 1:), text(at:at))
            at = merge(at + length, len(text), length > 0)
         case ('!')
            length = index(text(at:), newline)
            at = merge(at + length - 1, len(text), length > 0)
         end select
         at = at + 1
      end do
   end function next_mark

   !> Where the assignment of a variable begins in the text of a group, where its value begins, and
   !> where it ends; zeros if it is not given.
   pure subroutine find_assignment(text, variable, first, begin, last)
      character(len=*), intent(in) :: text, variable  !< from & to slash; name
      integer, intent(out) :: first, begin, last      !< positions
      integer :: at, start, stop

      first = 0
      begin = 0
      last = 0
      at = 0
      do
         at = next_mark(text, at + 1)
         if (at > len(text)) exit
         if (text(at:at) /= '=') cycle
         call name_before(text, at, start, stop)
         if (first > 0) then
            last = start - 1
            return
         end if
         if (lower_case(text(start:stop)) /= variable) cycle
         first = start
         begin = at + 1
      end do
      if (first > 0) last = len(text) - 1
   end subroutine find_assignment

   !> The name before an equals sign, without a subscript.
   pure subroutine name_before(text, equals, start, stop)
      character(len=*), intent(in) :: text  !< of a group
      integer, intent(in) :: equals         !< position of the sign
      integer, intent(out) :: start, stop   !< of the name

      stop = len_trim(text(:equals - 1))
      if (text(stop:stop) == ')') stop = len_trim(text(:index(text(:stop), '(', back=.true.) - 1))
      start = verify(lower_case(text(:stop)), name_characters, back=.true.) + 1
   end subroutine name_before

   !> The variable `name` of a group; blank without one.
   pure function name_in(text) result(name)
      character(len=*), intent(in) :: text  !< from & to slash
      character(len=64) :: name
      character(len=:), allocatable :: value
      integer :: first, begin, last

      name = ''
      call find_assignment(text, 'name', first, begin, last)
      if (first == 0) return
      value = adjustl(text(begin:last))
      if (scan(value(:1), '''"') == 1) name = adjustl(value(2:index(value(2:), value(:1))))
   end function name_in

   !> Mark the groups that a change means.
   subroutine choose(change, spans, chosen, error)
      type(change_type), intent(in) :: change   !< with group and name
      type(span_type), intent(in) :: spans(:)   !< groups of the text
      logical, allocatable, intent(out) :: chosen(:)  !< [spans] none: the group is to be added
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      logical, allocatable :: of_kind(:)
      integer :: i, number, status, kind

      allocate (of_kind(size(spans)))
      of_kind = spans%group == change%group
      chosen = of_kind
      kind = find_group(change%group)
      if (change%which == '*' .and. any(of_kind)) return
      if (change%which == '') then
         if (count(of_kind) > 1) call refuse(change, 'the input has '//to_text(count(of_kind))// &
            ' groups &'//change%group//'; name one, as '//change%group//'[1].'// &
            change%variable//', or all: '//change%group//'[*].'//change%variable, error)
         if (.not. any(of_kind) .and. input_groups(kind)%repeats) call refuse(change, &
            'the input has no group &'//change%group//' to change', error)
         return
      end if
      chosen = of_kind .and. spans%name == change%which
      if (any(chosen)) return
      read (change%which, *, iostat=status) number
      if (status == 0 .and. verify(change%which, '0123456789') == 0) then
         do i = 1, size(spans)
            chosen(i) = of_kind(i) .and. count(of_kind(:i)) == number
         end do
      end if
      if (.not. any(chosen)) call refuse(change, 'there is no &'//change%group//' named '// &
         quoted(change%which)//meant(change%which, pack(spans%name, of_kind)), error)
   end subroutine choose

   !> Set the variable in one group; giving a duration takes the number of steps out, and the other
   !> way round.
   subroutine set_in(text, span, change)
      character(len=:), allocatable, intent(inout) :: text  !< of the input
      type(span_type), intent(in) :: span       !< of the group
      type(change_type), intent(in) :: change   !< with its value
      character(len=:), allocatable :: group

      group = text(span%first:span%last)
      if (change%group == 'control') then
         if (change%variable == 'duration') call replace(group, 'steps', '')
         if (change%variable == 'steps') call replace(group, 'duration', '')
      end if
      call replace(group, change%variable, change%variable//' = '//change%value)
      text = text(:span%first - 1)//group//text(span%last + 1:)
   end subroutine set_in

   !> Another assignment in place of that of a variable, behind which everything stays; without one,
   !> before the slash.  Assignments of its elements go.
   recursive subroutine replace(group, variable, new)
      character(len=:), allocatable, intent(inout) :: group  !< from & to slash
      character(len=*), intent(in) :: variable, new  !< name; its new assignment, '': none
      character(len=:), allocatable :: behind
      integer :: first, begin, last, length

      call find_assignment(group, variable, first, begin, last)
      if (first > 0) then
         behind = group(last + 1:)
         call replace(behind, variable, '')
         length = length_of_value(group(begin:last))
         group = group(:first - 1)//new//line_ends(group(begin:begin + length - 1))// &
            group(begin + length:last)//behind
      else if (new /= '') then
         group = trim(group(:len(group) - 1))//' '//new//' /'
      end if
   end subroutine replace

   !> Length of a value without the blanks, line ends and comments that follow it.
   pure integer function length_of_value(text) result(length)
      character(len=*), intent(in) :: text  !< behind the equals sign
      integer :: at, more

      length = 0
      at = 1
      do while (at <= len(text))
         more = 1
         select case (text(at:at))
         case ('!')
            more = index(text(at:)//newline, newline)
         case (' ', tab, newline, carriage_return)
         case ('''', '"')
            more = index(text(at + 1:)//text(at:at), text(at:at)) + 1
            length = min(at + more - 1, len(text))
         case default
            length = at
         end select
         at = at + more
      end do
   end function length_of_value

   !> The line ends of a text.
   pure function line_ends(text) result(ends)
      character(len=*), intent(in) :: text  !< of a value
      character(len=:), allocatable :: ends
      integer :: i

      ends = ''
      do i = 1, len(text)
         if (scan(text(i:i), newline//carriage_return) > 0) ends = ends//text(i:i)
      end do
   end function line_ends

end module dda_input_changes
