! SPDX-License-Identifier: GPL-3.0-or-later
!> Names in the schema, and messages about unknown names.
module dda_input_catalogue
   use dda_input_schema, only: input_groups, input_variables
   use dda_input_variable, only: variable_type
   use dda_text, only: closest, joined, quoted
   implicit none
   private
   public :: find_group, groups_with, variables_of, find_variable, unknown_group, unknown_variable

contains

   !> Position of a group in `input_groups`; 0 if there is no group of that name.
   pure integer function find_group(name) result(g)  ! total
      character(len=*), intent(in) :: name            !< in lower case

      do g = size(input_groups), 1, -1
         if (input_groups(g)%name == name) return
      end do
   end function find_group

   !> Positions of the groups that have a variable.
   pure function groups_with(variable) result(list)
      character(len=*), intent(in) :: variable        !< name, in lower case
      integer, allocatable :: list(:)
      integer :: g

      allocate (list(0))
      do g = 1, size(input_groups)
         if (any(input_variables(input_groups(g)%first:input_groups(g)%last)%name == variable)) &
            list = [list, g]
      end do
   end function groups_with

   !> Variables of a group; none if there is no such group.
   pure function variables_of(group) result(list)
      character(len=*), intent(in) :: group           !< name, in lower case
      type(variable_type), allocatable :: list(:)
      integer :: g

      g = find_group(group)
      if (g == 0) then
         allocate (list(0))
      else
         list = input_variables(input_groups(g)%first:input_groups(g)%last)
      end if
   end function variables_of

   !> Find a variable by name; its name is blank if the group has no such variable.
   pure function find_variable(group, name) result(variable)
      character(len=*), intent(in) :: group, name     !< in lower case
      type(variable_type) :: variable
      integer :: g, i

      variable = variable_type('', '', 0)
      g = find_group(group)
      if (g == 0) return
      do i = input_groups(g)%first, input_groups(g)%last
         if (input_variables(i)%name == name) variable = input_variables(i)
      end do
   end function find_variable

   !> Message for an unknown group, or a group for `sitedda build`, with a suggestion or all names.
   pure function unknown_group(name, file) result(message)
      character(len=*), intent(in) :: name            !< text as in the input
      character(len=*), intent(in) :: file            !< path of the input
      character(len=:), allocatable :: message
      integer :: g

      associate (known => pack(input_groups%name, .not. input_groups%built))
         if (find_group(name) > 0) then
            message = "joints, regions and masonry are turned into blocks by 'sitedda build "// &
               file//"', whose result can be run"
            return
         end if
         g = closest(name, known)
         message = 'there is no such group; '
         if (g > 0) message = message//'is &'//trim(known(g))//' meant? '
         message = message//'known are &'//joined(known, ', &')
      end associate
   end function unknown_group

   !> Message for an unknown variable: the groups that have it, or a suggestion and all names.
   pure function unknown_variable(group, name) result(message)
      character(len=*), intent(in) :: group           !< name of the group
      character(len=*), intent(in) :: name            !< text as in the input
      character(len=:), allocatable :: message
      type(variable_type), allocatable :: variables(:)
      integer, allocatable :: owners(:)
      integer :: i

      variables = variables_of(group)
      owners = groups_with(name)
      message = 'there is no variable '//quoted(name)//' in this group; '
      if (size(owners) > 0) then
         message = message//'it belongs to &'//joined(input_groups(owners)%name, ', &')//'; '
         i = 0
      else
         i = closest(name, variables%name)
      end if
      if (i > 0) message = message//'is '//quoted(variables(i)%name)//' meant? '
      message = message//'known are '//joined(variables%name, ', ')
   end function unknown_variable

end module dda_input_catalogue
