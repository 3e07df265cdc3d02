! SPDX-License-Identifier: GPL-3.0-or-later
!> What a group says: the values of its variables, checked by the schema.
!>
!> A variable that the group does not give leaves what it is read into as it was: there stands the
!> default, or `unset`.
module dda_input_group
   use dda_kinds, only: wp
   use dda_errors, only: error_type
   use dda_input_catalogue, only: find_variable
   use dda_input_schema, only: input_variables
   use dda_input_text, only: group_type, input_error
   use dda_input_value, only: value_type
   use dda_input_variable, only: variable_type, above_zero, unset, usable
   use dda_text, only: to_text, quoted
   implicit none
   private
   public :: group_type, input_error, get, get_list, get_text, given, require, &
      require_name, unset, is_set, value_or, name_length

   integer, parameter :: name_length = 64

   !> The value of a variable: number, whole number, logical value, name or word.
   interface get
      module procedure get_real, get_integer, get_logical, get_name
   end interface get

   !> The values of a variable, none where it is not given: numbers or names.
   interface get_list
      module procedure get_numbers, get_names
   end interface get_list

contains

   !> Whether the input gives a value.
   pure logical elemental function is_set(value)
      real(wp), intent(in) :: value           !< `unset` before the group was read

      is_set = value /= unset
   end function is_set

   !> A value, or what stands for one that is not given.
   pure elemental real(wp) function value_or(value, otherwise)
      real(wp), intent(in) :: value, otherwise  !< as read, or `unset`; in its place

      value_or = merge(value, otherwise, is_set(value))
   end function value_or

   !> Whether a group gives a variable at all.
   pure logical function given(group, name)
      type(group_type), intent(in) :: group   !< of the input
      character(len=*), intent(in) :: name    !< of the variable

      given = position_of(group, name) > 0
      if (given) given = group%values(position_of(group, name))%n > 0
   end function given

   !> Position of a variable among the values of a group; 0 if it is not given.
   pure integer function position_of(group, name) result(i)
      type(group_type), intent(in) :: group   !< of the input
      character(len=*), intent(in) :: name    !< of the variable

      do i = size(group%values), 1, -1
         if (input_variables(group%values(i)%variable)%name == name) return
      end do
   end function position_of

   !> A number within the limits of its variable; a variable that is required is given.
   pure subroutine get_real(group, name, value, error)
      type(group_type), intent(in) :: group   !< of the input
      character(len=*), intent(in) :: name    !< of the variable
      real(wp), intent(inout) :: value        !< in its unit
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(variable_type) :: variable

      variable = find_variable(group%name, name)
      if (given(group, name)) then
         value = group%values(position_of(group, name))%numbers(1)
         call check_number(error, group, variable, value)
      else if (variable%required) then
         call input_error(error, group, name//' is missing')
      end if
   end subroutine get_real

   !> A whole number.
   pure subroutine get_integer(group, name, value, error)
      type(group_type), intent(in) :: group   !< of the input
      character(len=*), intent(in) :: name    !< of the variable
      integer, intent(inout) :: value         !< as given
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      real(wp) :: number

      number = unset
      call get_real(group, name, number, error)
      if (is_set(number) .and. .not. allocated(error)) value = int(min(number, &
         real(huge(value), wp)))
   end subroutine get_integer

   !> A logical value.
   pure subroutine get_logical(group, name, value)
      type(group_type), intent(in) :: group   !< of the input
      character(len=*), intent(in) :: name    !< of the variable
      logical, intent(inout) :: value         !< as given

      if (given(group, name)) value = group%values(position_of(group, name))%numbers(1) > 0.0_wp
   end subroutine get_logical

   !> A name or word; a word is one of those that the schema allows.
   pure subroutine get_name(group, name, value, error)
      type(group_type), intent(in) :: group     !< of the input
      character(len=*), intent(in) :: name      !< of the variable
      character(len=*), intent(inout) :: value  !< as given
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      character(len=:), allocatable :: text
      type(variable_type) :: variable

      text = ''
      call get_text(group, name, text)
      variable = find_variable(group%name, name)
      if (text /= '') then
         if (variable%kind == 'word') call check_word(error, group, variable, text)
         if (len(text) > name_length) call input_error(error, group, name//' = '//quoted(text)// &
            ' is too long: at most '//to_text(name_length)//' bytes')
         value = text
      else if (variable%required) then
         call input_error(error, group, name//' is missing')
      end if
   end subroutine get_name

   !> A text of any length.
   pure subroutine get_text(group, name, text)
      type(group_type), intent(in) :: group   !< of the input
      character(len=*), intent(in) :: name    !< of the variable
      character(len=:), allocatable, intent(inout) :: text  !< as given
      integer :: i

      i = position_of(group, name)
      if (i > 0) call group%values(i)%get_text(1, text)
   end subroutine get_text

   !> Numbers within the limits of their variable, none left out.
   pure subroutine get_numbers(group, name, values, error)
      type(group_type), intent(in) :: group   !< of the input
      character(len=*), intent(in) :: name    !< of the variable
      real(wp), allocatable, intent(out) :: values(:)  !< in its unit
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(variable_type) :: variable
      integer :: i

      allocate (values(0))
      variable = find_variable(group%name, name)
      i = position_of(group, name)
      if (i > 0) then
         if (group%values(i)%n > 0) values = group%values(i)%numbers
      end if
      if (.not. all(is_set(values)) .or. (variable%size == 2 .and. size(values) == 1)) &
         call input_error(error, group, name//': a value is left out')
      if (size(values) == 0 .and. variable%required) call input_error(error, group, name// &
         ' is missing')
      do i = 1, size(values)
         if (allocated(error)) return
         call check_number(error, group, variable, values(i))
      end do
   end subroutine get_numbers

   !> Names, blank where one is left out.
   pure subroutine get_names(group, name, values, error)
      type(group_type), intent(in) :: group   !< of the input
      character(len=*), intent(in) :: name    !< of the variable
      character(len=name_length), allocatable, intent(out) :: values(:)  !< as given
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      character(len=:), allocatable :: text
      integer :: i, k, n

      i = position_of(group, name)
      n = 0
      if (i > 0) n = group%values(i)%n
      allocate (values(n))
      do k = 1, n
         text = ''
         call group%values(i)%get_text(k, text)
         if (len(text) > name_length) call input_error(error, group, &
            name//'('//to_text(k)//') = '//quoted(text)// &
            ' is too long: at most '//to_text(name_length)//' bytes')
         values(k) = text
      end do
   end subroutine get_names

   !> Numbers that must be there and lie within the limits of the schema.
   pure subroutine require(error, group, names, values)
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(group_type), intent(in) :: group                  !< of the input
      character(len=*), intent(in) :: names                  !< of the variables: 'x y …'
      real(wp), intent(in) :: values(:)                      !< one of each, in their units
      integer :: i, first, last

      first = 1
      do i = 1, size(values)
         last = first + index(names(first:)//' ', ' ') - 2
         if (is_set(values(i))) then
            call check_number(error, group, find_variable(group%name, names(first:last)), &
               values(i))
         else
            call input_error(error, group, names(first:last)//' is missing')
         end if
         first = last + 2
      end do
   end subroutine require

   !> A number must lie within the limits of its variable.
   pure subroutine check_number(error, group, variable, value)
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(group_type), intent(in) :: group                  !< of the input
      type(variable_type), intent(in) :: variable            !< of the schema
      real(wp), intent(in) :: value                          !< in its unit
      character(len=:), allocatable :: failure

      failure = ''
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
      if (failure /= '') call input_error(error, group, trim(variable%name)//' = '// &
         to_text(value)//failure)
   end subroutine check_number

   !> A word must be one of those that the schema allows.
   pure subroutine check_word(error, group, variable, value)
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(group_type), intent(in) :: group                  !< of the input
      type(variable_type), intent(in) :: variable            !< of the schema
      character(len=*), intent(in) :: value                  !< as the input has it

      if (scan(value, "'") > 0 .or. index(variable%allowed, "'"//trim(value)//"'") == 0) &
         call input_error(error, group, trim(variable%name)//' = '//quoted(value)// &
         ' must be one of '//trim(variable%allowed))
   end subroutine check_word

   !> The position of a name among those it may refer to; 0 and an input error if it is none.
   pure subroutine require_name(error, group, name, value, names, kind, position)
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(group_type), intent(in) :: group                  !< of the input
      character(len=*), intent(in) :: name                   !< of the variable
      character(len=*), intent(in) :: value                  !< as the input has it
      character(len=*), intent(in) :: names(:)               !< known ones
      character(len=*), intent(in) :: kind                   !< whose names they are: 'material', …
      integer, intent(out) :: position  !< in `names`

      position = findloc(names == value, .true., 1)
      if (position == 0) call input_error(error, group, name//' = '//quoted(value)// &
         ' is not the name of a &'//kind)
   end subroutine require_name

end module dda_input_group
