! SPDX-License-Identifier: GPL-3.0-or-later
!> Variables of an input changed by name, as --set does: 'time_step=5e-4',
!> 'joint[bedding].friction_angle=30', 'material.clay.density=1900', 'joint[*].cohesion=0'.
module dda_input_changes
   use dda_errors, only: error_type, error_input, fail
   use dda_input_catalogue, only: find_group, find_variable, groups_with, variables_of
   use dda_input_group, only: get_text, name_length
   use dda_input_schema, only: input_groups, input_variables
   use dda_input_text, only: group_type, span_type, parse_group, split_groups
   use dda_input_variable, only: variable_type
   use dda_text, only: closest, lower_case, quoted, to_text
   implicit none
   private
   public :: change_text

   character, parameter :: newline = achar(10), carriage_return = achar(13)

   !> What a change says.
   type :: change_type
      character(len=:), allocatable :: path                   !< as written, for messages
      character(len=:), allocatable :: group, which, variable !< which: '' where it is not said
      character(len=:), allocatable :: value                  !< as a namelist holds it
   end type change_type

   !> Where the assignments of a group stand.
   type :: spans_type
      type(span_type), allocatable :: list(:)
   end type spans_type

contains

   !> The text with one change made; every line keeps its number.
   subroutine change_text(file, text, assignment, error)
      character(len=*), intent(in) :: file                  !< path, for messages
      character(len=:), allocatable, intent(inout) :: text  !< of the input
      character(len=*), intent(in) :: assignment            !< 'NAME=VALUE'
      type(error_type), allocatable, intent(out) :: error   !< allocated on failure
      type(change_type) :: change
      type(group_type), allocatable :: groups(:)
      type(spans_type), allocatable :: spans(:)
      logical, allocatable :: chosen(:)
      integer :: i

      call parse(assignment, change, error)
      if (allocated(error)) return
      call split_groups(file, text, groups, error)
      if (allocated(error)) return
      allocate (spans(size(groups)))
      do i = 1, size(groups)
         allocate (spans(i)%list(0))
         if (groups(i)%name == change%group) call parse_group(text, groups(i), error, spans(i)%list)
      end do
      if (allocated(error)) return
      call choose(change, groups, chosen, error)
      if (allocated(error)) return
      do i = size(groups), 1, -1  ! from the end, so that the places of the others stay
         if (chosen(i)) call set_in(text, groups(i)%last, spans(i)%list, change)
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

   !> The variable `name` of a group; blank without one.
   pure function name_in(group) result(name)
      type(group_type), intent(in) :: group  !< with its values, or of another kind
      character(len=name_length) :: name
      character(len=:), allocatable :: text

      text = ''
      if (allocated(group%values)) call get_text(group, 'name', text)
      name = text
   end function name_in

   !> Mark the groups that a change means.
   subroutine choose(change, groups, chosen, error)
      type(change_type), intent(in) :: change   !< with group and name
      type(group_type), intent(in) :: groups(:) !< of the text
      logical, allocatable, intent(out) :: chosen(:)  !< [groups] none: the group is to be added
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      logical, allocatable :: of_kind(:)
      character(len=name_length) :: names(size(groups))
      integer :: i, number, status, kind

      names = [(name_in(groups(i)), i=1, size(groups))]
      of_kind = [(groups(i)%name == change%group, i=1, size(groups))]
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
      chosen = of_kind .and. names == change%which
      if (any(chosen)) return
      read (change%which, *, iostat=status) number
      if (status == 0 .and. verify(change%which, '0123456789') == 0) then
         do i = 1, size(groups)
            chosen(i) = of_kind(i) .and. count(of_kind(:i)) == number
         end do
      end if
      if (.not. any(chosen)) call refuse(change, 'there is no &'//change%group//' named '// &
         quoted(change%which)//meant(change%which, pack(names, of_kind)), error)
   end subroutine choose

   !> Set the variable in one group; giving a duration takes the number of steps out, and the other
   !> way round.
   subroutine set_in(text, last, spans, change)
      character(len=:), allocatable, intent(inout) :: text  !< of the input
      integer, intent(in) :: last                !< the slash of the group
      type(span_type), intent(in) :: spans(:)    !< its assignments
      type(change_type), intent(in) :: change    !< with its value
      character(len=:), allocatable :: new, other
      character(len=len(input_variables%name)) :: names(size(spans))
      integer :: i, first

      new = change%variable//' = '//change%value
      other = ''
      if (change%group == 'control' .and. change%variable == 'duration') other = 'steps'
      if (change%group == 'control' .and. change%variable == 'steps') other = 'duration'
      do i = 1, size(spans)
         names(i) = input_variables(spans(i)%variable)%name
      end do
      first = findloc(names == change%variable, .true., 1)
      if (first == 0) text = trim(text(:last - 1))//' '//new//' '//text(last:)
      do i = size(spans), 1, -1
         if (names(i) /= change%variable .and. names(i) /= other) cycle
         text = text(:spans(i)%first - 1)//trim(merge(new, repeat(' ', len(new)), i == first))// &
            line_ends(text(spans(i)%first:spans(i)%last))//text(spans(i)%last + 1:)
      end do
   end subroutine set_in

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
