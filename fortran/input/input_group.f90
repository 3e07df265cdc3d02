! SPDX-License-Identifier: GPL-3.0-or-later
!> Tools for reading one group: its place in the file, input errors that name it, checks of its
!> values against the catalogue.
module dda_input_group
   use dda_kinds, only: wp
   use dda_errors, only: error_type, error_input, fail
   use dda_input_catalogue, only: find_variable, unknown_variable
   use dda_input_variable, only: variable_type, above_zero, unset, usable
   use dda_namelist_groups, only: group_type
   use dda_text, only: to_text, quoted, lower_case
   implicit none
   private
   public :: place_type, place_of_group, input_error, check_read, require, require_given, &
      require_list, value_or, require_choice, require_name, unset, is_set, name_length

   integer, parameter :: name_length = 64

   !> Place of a group in the input, for messages.
   type :: place_type
      character(len=:), allocatable :: group  !< name
      character(len=:), allocatable :: text   !< "FILE, group &name (line N)"
   end type place_type

contains

   !> The place of a group.
   pure function place_of_group(file, group) result(place)
      character(len=*), intent(in) :: file    !< path, for messages
      type(group_type), intent(in) :: group  !< of the input
      type(place_type) :: place

      place%group = group%name
      place%text = file//', group &'//group%name//' (line '//to_text(group%line)//')'
   end function place_of_group

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

   !> An input error at a place.
   pure subroutine input_error(error, place, message)
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(place_type), intent(in) :: place                  !< of the group
      character(len=*), intent(in) :: message                !< a sentence without its full stop

      if (.not. allocated(error)) call fail(error, error_input, place%text//': '//message)
   end subroutine input_error

   !> A namelist read that failed, in words.
   pure subroutine check_read(error, place, status, message)
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(place_type), intent(in) :: place                  !< of the group
      integer, intent(in) :: status                          !< iostat of the read
      character(len=*), intent(in) :: message                !< iomsg of the read
      character(len=*), parameter :: bad_data = 'Bad data for namelist object '
      character(len=*), parameter :: letters = 'abcdefghijklmnopqrstuvwxyz'
      character(len=*), parameter :: unknown = 'Cannot match namelist object name '

      if (status == 0) return
      if (index(message, unknown) == 1) then
         if (verify(lower_case(message(len(unknown) + 1:len(unknown) + 1)), letters) > 0) then
            call input_error(error, place, quoted(message(len(unknown) + 1:))// &
               ' cannot be read here: it is no value of the variable before it, or one more '// &
               'than that variable holds')
         else
            call input_error(error, place, &
               unknown_variable(place%group, lower_case(trim(message(len(unknown) + 1:)))))
         end if
      else if (index(message, bad_data) == 1) then
         call input_error(error, place, 'the values of '//quoted(message(len(bad_data) + 1:))// &
            ' cannot be read: something in or after them is neither a number nor a variable of '// &
            'this group')
      else if (index(message, 'End of file') > 0) then
         ! The run-time library takes a byte of 255 for the end of the text.
         call input_error(error, place, 'the group ends in the middle of a value, or holds a '// &
            'byte that is no text')
      else
         call input_error(error, place, trim(message))
      end if
   end subroutine check_read

   !> Numbers that must be given and lie within the limits of the catalogue.
   pure subroutine require(error, place, names, values)
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(place_type), intent(in) :: place                  !< of the group
      character(len=*), intent(in) :: names                  !< of the variables: 'x y …'
      real(wp), intent(in) :: values(:)                      !< one of each, in their units
      integer :: i, first, last

      first = 1
      do i = 1, size(values)
         last = first + index(names(first:)//' ', ' ') - 2
         if (is_set(values(i))) then
            call check_number(error, place, find_variable(place%group, names(first:last)), &
               values(i))
         else
            call input_error(error, place, names(first:last)//' is missing')
         end if
         first = last + 2
      end do
   end subroutine require

   !> A number that may be left out lies within the range of the catalogue.
   pure subroutine require_given(error, place, name, value)
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(place_type), intent(in) :: place  !< of the group
      character(len=*), intent(in) :: name   !< of the variable
      real(wp), intent(in) :: value          !< as read, or `unset`

      if (is_set(value)) call require(error, place, name, [value])
   end subroutine require_given

   !> The values of one variable: all given, all within its limits.
   pure subroutine require_list(error, place, name, values)
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(place_type), intent(in) :: place                  !< of the group
      character(len=*), intent(in) :: name                   !< of the variable
      real(wp), intent(in) :: values(:)                      !< in its unit
      type(variable_type) :: variable
      integer :: i

      variable = find_variable(place%group, name)
      if (.not. all(is_set(values))) call input_error(error, place, name//': a value is left out')
      do i = 1, size(values)
         if (allocated(error)) return
         call check_number(error, place, variable, values(i))
      end do
   end subroutine require_list

   !> A number must lie within the limits of its variable.
   pure subroutine check_number(error, place, variable, value)
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(place_type), intent(in) :: place                  !< of the group
      type(variable_type), intent(in) :: variable            !< of the catalogue
      real(wp), intent(in) :: value                          !< in its unit
      character(len=:), allocatable :: failure

      if (.not. abs(value) <= usable) then
         failure = ' is not a usable number'
      else if (value <= 0.0_wp .and. variable%lowest > 0.0_wp .and. variable%kind /= 'integer') then
         failure = ' must be a positive number'
      else if (variable%lowest == above_zero) then
         return
      else if (value < variable%lowest .or. value > variable%highest) then
         failure = ' must lie between '//to_text(variable%lowest)//' and '// &
            to_text(variable%highest)
      else
         return
      end if
      call input_error(error, place, trim(variable%name)//' = '//to_text(value)//failure)
   end subroutine check_number

   !> A word must be one of those that the catalogue allows.
   pure subroutine require_choice(error, place, name, value)
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(place_type), intent(in) :: place                  !< of the group
      character(len=*), intent(in) :: name                   !< of the variable
      character(len=*), intent(in) :: value                  !< as the input has it
      type(variable_type) :: variable

      variable = find_variable(place%group, name)
      if (scan(value, "'") > 0 .or. index(variable%allowed, "'"//trim(value)//"'") == 0) &
         call input_error(error, place, name//' = '//quoted(value)//' must be one of '// &
         trim(variable%allowed))
   end subroutine require_choice

   !> The position of a name among those it may refer to; 0 and an input error if it is none.
   pure subroutine require_name(error, place, name, value, names, group, position)
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(place_type), intent(in) :: place                  !< of the group
      character(len=*), intent(in) :: name                   !< of the variable
      character(len=*), intent(in) :: value                  !< as the input has it
      character(len=*), intent(in) :: names(:)               !< known ones
      character(len=*), intent(in) :: group                  !< whose names they are: 'material', …
      integer, intent(out) :: position  !< in `names`

      position = findloc(names == value, .true., 1)
      if (position == 0) call input_error(error, place, name//' = '//quoted(value)// &
         ' is not the name of a &'//group)
   end subroutine require_name

end module dda_input_group
