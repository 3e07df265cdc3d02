! SPDX-License-Identifier: GPL-3.0-or-later
!> Changes of variables of an input by name, such as with --set.  Examples: 'time_step=5e-4',
!> 'joint[bedding].friction_angle=30', 'material.clay.density=1900', 'joint[*].cohesion=0'.
module dda_input_changes
   use dda_errors, only: error_type, error_input, fail
   use dda_input_catalogue, only: find_group, groups_with, variables_of, &
      variable_of => find_variable
   use dda_input_group, only: positions, name_length
   use dda_input_schema, only: input_groups, input_variables
   use dda_input_text, only: group_type, span_type, parse_group, split_groups, text_of
   use dda_input_variable, only: group_entry_type
   use dda_text, only: closest, joined, lower_case, quoted, to_text
   implicit none
   private
   public :: change_type, change_text, typed_change

   character, parameter :: newline = achar(10), carriage_return = achar(13)
   integer, parameter :: max_names_listed = 8  !< number of names that a message lists

   !> A variable by its path, and its new value.
   type :: change_type
      character(len=:), allocatable :: path   !< path as typed
      character(len=:), allocatable :: value  !< value as typed; unallocated: remove the variable
      integer :: variable = 0                 !< position in `input_variables`, once found
      character(len=:), allocatable, private :: group, which, name  !< '' if not given in the path
   end type change_type

   !> Positions of the assignments of a group.
   type :: spans_type
      type(span_type), allocatable :: list(:)
   end type spans_type

contains

   !> Parse 'NAME=VALUE'; without an equals sign the path is not allocated.
   pure type(change_type) function typed_change(text) result(change)
      character(len=*), intent(in) :: text  !< change as typed
      integer :: equals

      equals = index(text, '=')
      change%path = trim(adjustl(text(:max(0, equals - 1))))
      change%value = text(equals + 1:)
   end function typed_change

   !> Apply changes to the text, one after the other; line numbers do not change.
   subroutine change_text(file, text, changes, error)
      character(len=*), intent(in) :: file                  !< path, for messages
      character(len=:), allocatable, intent(inout) :: text  !< text of the input
      type(change_type), intent(inout) :: changes(:)        !< changes; their variables are found
      type(error_type), allocatable, intent(inout) :: error !< error; an earlier one is retained
      type(group_type), allocatable :: groups(:)
      integer :: i

      do i = 1, size(changes)
         if (.not. allocated(error)) call split_groups(file, text, groups, error)
         if (.not. allocated(error)) call resolve_path(changes(i), groups, text, error)
         if (.not. allocated(error)) call apply_change(changes(i), groups, text, error)
      end do
   end subroutine change_text

   !> Apply one change.
   subroutine apply_change(change, groups, text, error)
      type(change_type), intent(in) :: change       !< change with its variable
      type(group_type), intent(inout) :: groups(:)  !< groups of the text; values are parsed
      character(len=:), allocatable, intent(inout) :: text   !< text of the input
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer, allocatable :: group_numbers(:)
      logical, allocatable :: is_selected(:)
      type(spans_type), allocatable :: spans(:)
      character(len=name_length), allocatable :: names(:)
      character(len=:), allocatable :: assignment
      integer :: i

      group_numbers = positions(groups, change%group)
      allocate (spans(size(group_numbers)), names(size(group_numbers)))
      do i = 1, size(group_numbers)
         allocate (spans(i)%list(0))
         call parse_group(text, groups(group_numbers(i)), error, spans(i)%list)
         if (allocated(error)) return
         names(i) = text_of(groups(group_numbers(i)), 'name')
      end do
      call mark_groups(change, names, is_selected, error)
      if (allocated(error)) return
      assignment = ''
      if (allocated(change%value)) assignment = change%name//' = '//value_text(change)
      do i = size(group_numbers), 1, -1  ! backwards: changes move later text
         if (is_selected(i)) call set_in_group(text, groups(group_numbers(i))%last, spans(i)%list, &
            change, assignment)
      end do
      if (size(group_numbers) > 0 .or. assignment == '') return
      if (len(text) > 0) then
         if (text(len(text):) /= newline) text = text//newline
      end if
      text = text//'&'//change%group//' '//assignment//' /'//newline
   end subroutine apply_change

   !> Set an error that names the change.
   pure subroutine refuse_change(change, message, error)
      type(change_type), intent(in) :: change  !< change with its path
      character(len=*), intent(in) :: message  !< sentence without the full stop
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      if (.not. allocated(error)) call fail(error, error_input, change%path//': '//message)
   end subroutine refuse_change

   !> Find group, name and variable of a path.
   subroutine resolve_path(change, groups, text, error)
      type(change_type), intent(inout) :: change  !< change with its path and value
      type(group_type), intent(in) :: groups(:)   !< groups of the text
      character(len=*), intent(in) :: text        !< text of the input
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer :: dot, last

      if (change%path == '') then
         change%path = change%value
         call refuse_change(change, 'must have the form NAME=VALUE', error)
         return
      end if
      associate (path => change%path)
         change%which = ''
         dot = scan(path, '.[')
         last = index(path, '.', back=.true.)
         change%name = lower_case(trim(adjustl(path(last + 1:))))
         if (dot == 0) then
            call find_owner_group(change, groups, text, error)
         else
            change%group = lower_case(trim(path(:dot - 1)))
            if (path(dot:dot) == '[') then
               change%which = path(dot + 1:max(dot, index(path, ']', back=.true.) - 1))
            else if (last > dot) then
               change%which = path(dot + 1:last - 1)
            end if
         end if
      end associate
      call find_variable(change, error)
      if (allocated(error) .or. .not. allocated(change%value)) return
      if (change%value == '' .and. input_variables(change%variable)%kind /= 'text') &
         call refuse_change(change, 'a value is needed', error)
   end subroutine resolve_path

   !> Find the only group that can have a variable given without a group.
   subroutine find_owner_group(change, groups, text, error)
      type(change_type), intent(inout) :: change  !< change with the name of its variable
      type(group_type), intent(in) :: groups(:)   !< groups of the text
      character(len=*), intent(in) :: text        !< text of the input
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(group_entry_type), allocatable :: owners(:)
      character(len=2*len(input_variables%name)), allocatable :: paths(:)
      logical, allocatable :: counts(:)
      integer :: i, g

      owners = input_groups(groups_with(change%name))
      ! Groups of `sitedda build` count only if the input has them.
      if (.not. all(owners%built)) owners = pack(owners, .not. owners%built .or. &
         [(any([(groups(i)%name == owners(g)%name, i=1, size(groups))]), g=1, size(owners))])
      if (any(owners%name == 'control')) owners = pack(owners, owners%name == 'control')
      counts = [(is_meant(text, groups, owners(g)%name, change%name), g=1, size(owners))]
      if (any(counts)) owners = pack(owners, counts)
      if (size(owners) == 1) then
         change%group = trim(owners(1)%name)
      else if (size(owners) > 1) then
         allocate (paths(size(owners)))
         do i = 1, size(owners)
            paths(i) = trim(owners(i)%name)//'.'//change%name
         end do
         call refuse_change(change, 'several groups have this variable; name one, for example '// &
            joined(paths, ' or '), error)
      else if (find_group(change%name) > 0) then
         call refuse_change(change, 'this is a group; name one of its variables, such as '// &
            change%name//'.'// &
            trim(input_variables(input_groups(find_group(change%name))%first)%name), error)
      else
         call refuse_change(change, 'no group has this variable'//names_hint(change%name, &
            input_variables%name, ''), error)
      end if
   end subroutine find_owner_group

   !> .true. if the variable is used in this group: it depends on no other variable, or the other
   !> variable has a suitable value, in the text or by default.
   pure logical function is_meant(text, groups, group, variable)
      character(len=*), intent(in) :: text              !< text of the input
      type(group_type), intent(in) :: groups(:)         !< groups of the text
      character(len=*), intent(in) :: group, variable   !< names
      integer :: i

      associate (group_numbers => variable_of(group, variable))
         is_meant = group_numbers%belongs == ''
         if (is_meant) return
         associate (switch => variable_of(group, trim(group_numbers%switch)))
            if (any([(groups(i)%name == group, i=1, size(groups))])) &
               is_meant = index(group_numbers%belongs, "'"//trim(switch%usual)//"'") > 0
         end associate
         if (.not. is_meant) is_meant = is_given(text, groups, group, trim(group_numbers%switch))
      end associate
   end function is_meant

   !> .true. if a group of that name gives the variable in the text.
   pure logical function is_given(text, groups, group, variable)
      character(len=*), intent(in) :: text              !< text of the input
      type(group_type), intent(in) :: groups(:)         !< groups of the text
      character(len=*), intent(in) :: group, variable   !< names
      type(group_type) :: entry
      type(error_type), allocatable :: error
      type(span_type), allocatable :: spans(:)
      integer :: i

      is_given = .false.
      do i = 1, size(groups)
         if (groups(i)%name /= group) cycle
         entry = groups(i)
         spans = [span_type ::]
         call parse_group(text, entry, error, spans)
         if (allocated(error)) return
         if (any(input_variables(spans%variable)%name == variable)) is_given = .true.
      end do
   end function is_given

   !> Suggest the most similar name, or list the known names.
   pure function names_hint(name, names, intro) result(hint)
      character(len=*), intent(in) :: name, names(:)  !< unknown word; known words
      character(len=*), intent(in) :: intro  !< text before the list of known names
      character(len=:), allocatable :: hint
      integer :: i

      hint = ''
      i = closest(trim(name), names)
      if (i > 0) then
         hint = '; did you mean '//quoted(names(i))//'?'
      else if (intro /= '') then
         hint = '; '//intro//' '//name_list(names)
      end if
   end function names_hint

   !> List the first names, separated by commas.
   pure function name_list(names) result(list)
      character(len=*), intent(in) :: names(:)  !< trailing blanks are dropped
      character(len=:), allocatable :: list

      list = joined(names(:min(size(names), max_names_listed)), ', ')
      if (size(names) > max_names_listed) list = list//' …'
   end function name_list

   !> Find the named variable in an existing group.
   subroutine find_variable(change, error)
      type(change_type), intent(inout) :: change  !< change with its group
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer :: g, v

      if (allocated(error)) return
      g = find_group(change%group)
      if (g == 0) call refuse_change(change, 'there is no group &'//change%group// &
         names_hint(change%group, input_groups%name, ''), error)
      if (allocated(error)) return
      do v = input_groups(g)%first, input_groups(g)%last
         if (input_variables(v)%name == change%name) change%variable = v
      end do
      associate (group_numbers => variables_of(change%group))
         if (change%variable == 0) call refuse_change(change, 'group &'//change%group// &
            ' has no variable '//quoted(change%name)//names_hint(change%name, group_numbers%name, &
            'it has'), error)
      end associate
   end subroutine find_variable

   !> Value in the syntax of an input: texts in quotes, logical values with dots.
   pure function value_text(change) result(text)
      type(change_type), intent(in) :: change  !< change with its value and variable
      character(len=:), allocatable :: text
      character(len=8) :: kind
      integer :: i

      text = trim(adjustl(change%value))
      kind = input_variables(change%variable)%kind
      if (kind == 'logical' .and. lower_case(text) == 'true') text = '.true.'
      if (kind == 'logical' .and. lower_case(text) == 'false') text = '.false.'
      if (all(kind /= ['name', 'word', 'text']) .or. scan(text//' ', '''"') == 1) return
      do i = len(text), 1, -1
         if (text(i:i) == "'") text = text(:i)//text(i:)
      end do
      text = "'"//text//"'"
   end function value_text

   !> Mark the groups that a change selects: the only group, a group by name or number, or all (*).
   subroutine mark_groups(change, names, is_selected, error)
      type(change_type), intent(in) :: change   !< change with group and name
      character(len=*), intent(in) :: names(:)  !< names of the groups of its kind, or blank
      logical, allocatable, intent(out) :: is_selected(:)  !< [groups] selected; none: add the group
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      character(len=max(len(names), 16)) :: labels(size(names))
      integer :: i

      do i = 1, size(names)
         labels(i) = names(i)
         if (labels(i) == '') labels(i) = to_text(i)
      end do
      is_selected = [(change%which == '' .or. change%which == '*', i=1, size(names))]
      if (size(names) == 0) then
         if (change%which /= '' .or. input_groups(find_group( &
            change%group))%repeats) call refuse_change(change, 'the input has no group &'// &
            change%group//' to change', error)
      else if (change%which == '' .and. size(names) > 1 .and. &
         input_groups(find_group(change%group))%repeats) then
         call refuse_change(change, 'the input has '//to_text(size(names))//' groups &'// &
            change%group//' ('//name_list(labels)//'); name one, for example '//change%group// &
            '['//trim(labels(1))//'].'//change%name//', or all: '//change%group//'[*].'// &
            change%name, error)
      else if (.not. any(is_selected)) then
         is_selected = labels == change%which
         if (.not. any(is_selected)) is_selected = [(to_text(i) == change%which, i=1, size(names))]
         if (.not. any(is_selected)) call refuse_change(change, 'there is no &'//change%group// &
            ' named '//quoted(change%which)//names_hint(change%which, labels, 'there are'), error)
      end if
   end subroutine mark_groups

   !> Set or remove the variable in one group.
   !> A new `duration` replaces `steps`, and vice versa.
   subroutine set_in_group(text, last, spans, change, assignment)
      character(len=:), allocatable, intent(inout) :: text  !< text of the input
      integer, intent(in) :: last                !< position of the slash of the group
      type(span_type), intent(in) :: spans(:)    !< assignments of the group
      type(change_type), intent(in) :: change    !< change with its variable
      character(len=*), intent(in) :: assignment        !< 'NAME = VALUE'; blank: remove
      character(len=:), allocatable :: alternative
      character(len=len(input_variables%name)) :: names(size(spans))
      integer :: i, first

      alternative = ''
      if (change%group == 'control' .and. change%name == 'duration') alternative = 'steps'
      if (change%group == 'control' .and. change%name == 'steps') alternative = 'duration'
      if (assignment == '') alternative = ''
      names = input_variables(spans%variable)%name
      first = findloc(names == change%name, .true., 1)
      if (first == 0 .and. assignment /= '') text = trim(text(:last - 1))//' '//assignment//' '// &
         text(last:)
      do i = size(spans), 1, -1
         if (names(i) /= change%name .and. names(i) /= alternative) cycle
         text = text(:spans(i)%first - 1)//trim(merge(assignment, repeat(' ', len(assignment)), &
            i == first))//line_ends(text(spans(i)%first:spans(i)%last))//text(spans(i)%last + 1:)
      end do
   end subroutine set_in_group

   !> Return the line ends of a text.
   pure function line_ends(text) result(ends)
      character(len=*), intent(in) :: text  !< text of a value
      character(len=:), allocatable :: ends
      integer :: i

      ends = ''
      do i = 1, len(text)
         if (scan(text(i:i), newline//carriage_return) > 0) ends = ends//text(i:i)
      end do
   end function line_ends

end module dda_input_changes
