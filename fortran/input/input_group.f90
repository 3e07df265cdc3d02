! SPDX-License-Identifier: GPL-3.0-or-later
!> Values of the variables of a group, checked by the schema.
!>
!> `dda_input_groups`, which is generated from the schema, has a type for the values of each group.
module dda_input_group
   use dda_kinds, only: wp
   use dda_errors, only: error_type
   use dda_group_values, only: name_length
   use dda_input_catalogue, only: find_variable
   use dda_input_schema, only: input_variables
   use dda_input_text, only: group_type, fail_input, given
   use dda_input_variable, only: variable_type, above_zero, unset, usable
   use dda_text, only: to_text, quoted
   implicit none
   private
   public :: group_type, fail_input, given, positions, require, require_name, require_new_name, &
      unset, is_set, value_or, name_length, take_integer, take_logical, take_name, take_names, &
      take_numbers, take_points, take_real, take_text, take_tuple, mark_names

   !> .true. if the input gives a value; a value that is not given is `unset`.
   interface is_set
      module procedure is_set_real, is_set_integer
   end interface is_set

contains

   !> .true. if the input gives a number.
   pure logical elemental function is_set_real(value) result(is)
      real(wp), intent(in) :: value           !< value in its unit

      is = value /= unset
   end function is_set_real

   !> .true. if the input gives a whole number.
   pure logical elemental function is_set_integer(value) result(is)
      integer, intent(in) :: value            !< as given

      is = value /= -huge(value)
   end function is_set_integer

   !> Return the given value, or a substitute if it is `unset`.
   pure elemental real(wp) function value_or(value, substitute)
      real(wp), intent(in) :: value, substitute  !< value, or `unset`; substitute

      value_or = merge(value, substitute, is_set(value))
   end function value_or

   !> Positions of the groups with a given name.
   pure function positions(groups, name) result(list)
      type(group_type), intent(in) :: groups(:)  !< groups of the input, in its order
      character(len=*), intent(in) :: name       !< name of the groups
      integer, allocatable :: list(:)
      integer :: i

      list = pack([(i, i=1, size(groups))], [(groups(i)%name == name, i=1, size(groups))])
   end function positions

   !> Find the values of a variable in a group; 0 if missing, with an error if it is required.
   pure subroutine find_values(group, v, i, error)
      type(group_type), intent(in) :: group  !< group of the input
      integer, intent(in) :: v               !< position in `input_variables`
      integer, intent(out) :: i              !< position in `group%values`
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      do i = size(group%values), 1, -1
         if (group%values(i)%variable == v .and. group%values(i)%n > 0) return
      end do
      if (input_variables(v)%required) call fail_input(error, group, &
         trim(input_variables(v)%name)//' is missing')
   end subroutine find_values

   !> Read a number within the limits of its variable.
   pure subroutine take_real(group, v, value, error)
      type(group_type), intent(in) :: group  !< group of the input
      integer, intent(in) :: v               !< position in `input_variables`
      real(wp), intent(inout) :: value       !< value in its unit; unchanged if not given
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer :: i

      call find_values(group, v, i, error)
      if (i == 0) return
      value = group%values(i)%numbers(1)
      call check_number(error, group, input_variables(v), value)
   end subroutine take_real

   !> Read a whole number.
   pure subroutine take_integer(group, v, value, error)
      type(group_type), intent(in) :: group  !< group of the input
      integer, intent(in) :: v               !< position in `input_variables`
      integer, intent(inout) :: value        !< value; unchanged if not given
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      real(wp) :: number

      number = unset
      call take_real(group, v, number, error)
      if (number /= unset .and. .not. allocated(error)) value = int(min(number, real(huge(value), &
         wp)))
   end subroutine take_integer

   !> Read a logical value.
   pure subroutine take_logical(group, v, value, error)
      type(group_type), intent(in) :: group  !< group of the input
      integer, intent(in) :: v               !< position in `input_variables`
      logical, intent(inout) :: value        !< value; unchanged if not given
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer :: i

      call find_values(group, v, i, error)
      if (i > 0) value = group%values(i)%numbers(1) > 0.0_wp
   end subroutine take_logical

   !> Read a name, or one of the words that the schema allows.
   pure subroutine take_name(group, v, value, error)
      type(group_type), intent(in) :: group     !< group of the input
      integer, intent(in) :: v                  !< position in `input_variables`
      character(len=*), intent(inout) :: value  !< value; unchanged if not given or blank
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(variable_type) :: variable
      character(len=:), allocatable :: text
      integer :: i

      call find_values(group, v, i, error)
      if (i == 0) return
      text = ''
      call group%values(i)%get_text(1, text)
      variable = input_variables(v)
      if (text == '' .and. variable%required) call fail_input(error, group, &
         trim(variable%name)//' is missing')
      if (variable%kind == 'word' .and. (scan(text, "'") > 0 .or. &
         index(variable%allowed, "'"//trim(text)//"'") == 0)) call fail_input(error, group, &
         trim(variable%name)//' = '//quoted(text)//' must be one of '//trim(variable%allowed))
      if (len(text) > name_length) call check_length(error, group, trim(variable%name), text)
      if (text /= '') value = text
   end subroutine take_name

   !> Read a text of any length.
   pure subroutine take_text(group, v, text, error)
      type(group_type), intent(in) :: group   !< group of the input
      integer, intent(in) :: v                !< position in `input_variables`
      character(len=:), allocatable, intent(out) :: text  !< text; the default if not given
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer :: i

      text = trim(input_variables(v)%usual)
      call find_values(group, v, i, error)
      if (i > 0) call group%values(i)%get_text(1, text)
      if (text == '' .and. input_variables(v)%required) call fail_input(error, group, &
         trim(input_variables(v)%name)//' is missing')
   end subroutine take_text

   !> Read numbers within the limits of their variable; no value may be omitted.
   pure subroutine take_numbers(group, v, values, error)
      type(group_type), intent(in) :: group  !< group of the input
      integer, intent(in) :: v               !< position in `input_variables`
      real(wp), allocatable, intent(out) :: values(:)  !< given or default values; may be empty
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(variable_type) :: variable
      integer :: i

      call find_values(group, v, i, error)
      variable = input_variables(v)
      if (i == 0) then
         values = pack([variable%preset], variable%preset /= unset)
         return
      end if
      values = group%values(i)%numbers
      if (.not. all(is_set(values)) .or. (variable%size == 2 .and. size(values) == 1)) &
         call fail_input(error, group, trim(variable%name)//': a value is missing')
      do i = 1, size(values)
         if (allocated(error)) return
         call check_number(error, group, variable, values(i))
      end do
   end subroutine take_numbers

   !> Read a fixed number of values.
   pure subroutine take_tuple(group, v, values, error)
      type(group_type), intent(in) :: group   !< group of the input
      integer, intent(in) :: v                !< position in `input_variables`
      real(wp), intent(inout) :: values(:)    !< values; unchanged if not given
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      real(wp), allocatable :: input(:)

      call take_numbers(group, v, input, error)
      values(:size(input)) = input
   end subroutine take_tuple

   !> Read points as pairs of x and y.
   pure subroutine take_points(group, v, points, error)
      type(group_type), intent(in) :: group   !< group of the input
      integer, intent(in) :: v                !< position in `input_variables`
      real(wp), allocatable, intent(out) :: points(:,:)  !< [2, points] m; none if not given
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      real(wp), allocatable :: values(:)

      call take_numbers(group, v, values, error)
      if (modulo(size(values), 2) == 1) call fail_input(error, group, &
         trim(input_variables(v)%name)//': a value is missing')
      points = reshape(values, [2, size(values)/2])
   end subroutine take_points

   !> Read names; omitted names are blank.
   pure subroutine take_names(group, v, values, error)
      type(group_type), intent(in) :: group   !< group of the input
      integer, intent(in) :: v                !< position in `input_variables`
      character(len=name_length), allocatable, intent(out) :: values(:)  !< as given
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      character(len=:), allocatable :: text
      integer :: i, k, n

      call find_values(group, v, i, error)
      n = 0
      if (i > 0) n = group%values(i)%n
      allocate (values(n))
      do k = 1, n
         text = ''
         call group%values(i)%get_text(k, text)
         call check_length(error, group, trim(input_variables(v)%name)//'('//to_text(k)//')', text)
         values(k) = text
      end do
   end subroutine take_names

   !> Check that names do not exceed the largest length.
   pure subroutine check_length(error, group, name, text)
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(group_type), intent(in) :: group     !< group of the input
      character(len=*), intent(in) :: name, text  !< name and value of the variable

      if (len(text) > name_length) call fail_input(error, group, name//' = '//quoted(text)// &
         ' is too long: at most '//to_text(name_length)//' bytes')
   end subroutine check_length

   !> Require numbers to be given and to be within the limits of the schema.
   pure subroutine require(error, group, names, values)
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(group_type), intent(in) :: group                  !< group of the input
      character(len=*), intent(in) :: names                  !< names of the variables: 'x y …'
      real(wp), intent(in) :: values(:)  !< one value per variable, in its unit
      integer :: i, first, last

      first = 1
      do i = 1, size(values)
         last = first + index(names(first:)//' ', ' ') - 2
         if (is_set(values(i))) then
            call check_number(error, group, find_variable(group%name, names(first:last)), values(i))
         else
            call fail_input(error, group, names(first:last)//' is missing')
         end if
         first = last + 2
      end do
   end subroutine require

   !> Check that a number is within the limits of its variable.
   pure subroutine check_number(error, group, variable, value)
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(group_type), intent(in) :: group                  !< group of the input
      type(variable_type), intent(in) :: variable            !< variable of the schema
      real(wp), intent(in) :: value                          !< value in its unit
      character(len=:), allocatable :: failure

      if (.not. abs(value) <= usable) then
         failure = ' is not a usable number'
      else if (value <= 0.0_wp .and. variable%lowest > 0.0_wp .and. variable%kind /= 'integer') then
         failure = ' must be a positive number'
      else if (variable%lowest /= above_zero .and. (value < variable%lowest .or. &
         value > variable%highest)) then
         failure = ' must lie between '//to_text(variable%lowest)//' and '// &
            to_text(variable%highest)
      else if (variable%kind == 'integer' .and. value /= aint(value)) then
         failure = ' must be a whole number'
      end if
      if (allocated(failure)) call fail_input(error, group, trim(variable%name)//' = '// &
         to_text(value)//failure)
   end subroutine check_number

   !> Set an error if a name is used twice.
   pure subroutine require_new_name(error, group, name, names)
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(group_type), intent(in) :: group                  !< group of the input
      character(len=*), intent(in) :: name                   !< new name
      character(len=*), intent(in) :: names(:)              !< earlier names of this kind

      if (any(names == name)) call fail_input(error, group, 'name = '//quoted(trim(name))// &
         ' is used twice')
   end subroutine require_new_name

   !> Find a name in a list; 0 with an input error if it is unknown.
   pure subroutine require_name(error, group, name, value, names, kind, position)
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(group_type), intent(in) :: group                  !< group of the input
      character(len=*), intent(in) :: name                   !< name of the variable
      character(len=*), intent(in) :: value                  !< text as in the input
      character(len=*), intent(in) :: names(:)               !< known names
      character(len=*), intent(in) :: kind                   !< kind of the names: 'material', …
      integer, intent(out) :: position  !< position in `names`

      position = findloc(names == value, .true., 1)
      if (position == 0) call fail_input(error, group, name//' = '//quoted(value)// &
         ' is not the name of a &'//kind)
   end subroutine require_name

   !> Mark the names that a list 'one, two, all_*' selects; each item must match a name.
   subroutine mark_names(list, variable, names, group, marked, error)
      character(len=*), intent(in) :: list, variable  !< list as read; name of the variable
      character(len=*), intent(in) :: names(:)        !< known names
      type(group_type), intent(in) :: group           !< group of the input
      logical, intent(inout) :: marked(:)             !< [names] marks; marks of the list are added
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      character(len=:), allocatable :: remainder, entry
      integer :: comma, star, i
      logical :: matched

      remainder = trim(list)
      do while (len(remainder) > 0 .and. .not. allocated(error))
         comma = index(remainder//',', ',')
         entry = trim(adjustl(remainder(:comma - 1)))
         remainder = trim(remainder(min(comma + 1, len(remainder) + 1):))
         star = index(entry, '*')
         matched = .false.
         do i = 1, size(names)
            if (star > 0) then
               if (star /= len(entry)) cycle
               if (index(names(i), entry(:star - 1)) /= 1) cycle
            else if (names(i) /= entry) then
               cycle
            end if
            matched = entry /= ''
            marked(i) = marked(i) .or. matched
         end do
         if (.not. matched) call fail_input(error, group, variable//': nothing is named '// &
            quoted(entry))
      end do
   end subroutine mark_names

end module dda_input_group
