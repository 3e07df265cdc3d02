! SPDX-License-Identifier: GPL-3.0-or-later
!> Resolved input as JSON: the given, default or derived value of each variable of all groups except
!> groups of blocks.  The output contains this JSON, so that its readers do not need the input.
module dda_input_resolved
   use dda_input_boundaries, only: effective_kind
   use dda_input_group, only: group_type
   use dda_input_schema, only: input_groups, input_variables
   use dda_input_value, only: value_type
   use dda_input_variable, only: variable_type, unset
   use dda_kinds, only: wp
   use dda_material, only: joint_type
   use dda_model, only: model_type
   use dda_stage, only: stage_type
   use dda_text, only: to_text
   implicit none
   private
   public :: resolved_values

   character(len=*), parameter :: of_blocks(*) = [character(len=8) :: 'block', 'blocks', &
      'layers', 'drums', 'wall']  !< groups that define blocks
   character(len=*), parameter :: always(*) = [character(len=7) :: 'contact', 'output']

   !> A text that can be extended.
   type :: page_type
      character(len=:), allocatable :: text
      integer :: n = 0
   end type page_type

contains

   !> Text of all values: {"group": [{"variable": value, …}, …], …}.
   pure function resolved_values(model, groups) result(text)
      type(model_type), intent(in) :: model      !< model of the input
      type(group_type), intent(in) :: groups(:)  !< groups of the input, in its order
      character(len=:), allocatable :: text
      type(page_type) :: page
      integer, allocatable :: settings(:), group_numbers(:)
      integer :: g, i, k

      settings = pack([(i, i=1, size(groups))], [(all(groups(i)%name /= of_blocks), &
         i=1, size(groups))])
      allocate (character(len=4096) :: page%text)
      do g = 1, size(input_groups)
         group_numbers = pack(settings, [(groups(settings(i))%name == input_groups(g)%name, i=1, &
            size(settings))])
         if (size(group_numbers) == 0 .and. all(input_groups(g)%name /= always)) cycle
         call append_text(page, merge(',"', '{"', page%n > 0)//trim(input_groups(g)%name)//'": [')
         if (size(group_numbers) == 0) call add_group(page, g, &
            group_type(name=trim(input_groups(g)%name), values=[value_type ::]), 1, model)
         do k = 1, size(group_numbers)
            if (k > 1) call append_text(page, ', ')
            call add_group(page, g, groups(group_numbers(k)), k, model)
         end do
         call append_text(page, ']')
      end do
      text = page%text(:page%n)//'}'
   end function resolved_values

   !> Add the variables of a group.
   pure subroutine add_group(page, g, group, k, model)
      type(page_type), intent(inout) :: page   !< page to append to
      integer, intent(in) :: g                 !< position of the group in `input_groups`
      type(group_type), intent(in) :: group    !< group with its values
      integer, intent(in) :: k                 !< number of the group among all of its kind
      type(model_type), intent(in) :: model    !< model of the input
      character(len=:), allocatable :: value, separator
      integer :: v, i

      separator = '{'
      do v = input_groups(g)%first, input_groups(g)%last
         value = derived_value(model, group, trim(input_variables(v)%name), k)
         do i = 1, size(group%values)
            if (value == '' .and. group%values(i)%variable == v) value = given_value( &
               group%values(i), input_variables(v))
         end do
         if (value == '') value = default_value(input_variables(v))
         if (value == '') cycle
         call append_text(page, separator//'"'//trim(input_variables(v)%name)//'": '//value)
         separator = ', '
      end do
      call append_text(page, trim(merge('{} ', '}  ', separator == '{')))
   end subroutine add_group

   !> Value in the model that replaces a given value or is derived from other values.
   pure function derived_value(model, group, name, k) result(value)
      type(model_type), intent(in) :: model    !< model of the input
      type(group_type), intent(in) :: group    !< group with its values
      character(len=*), intent(in) :: name     !< name of the variable
      integer, intent(in) :: k                 !< number of the group among all of its kind
      character(len=:), allocatable :: value

      value = ''
      select case (group%name//'.'//name)
      case ('control.gravity')
         value = '['//number_text(model%control%gravity(1))//', '// &
            number_text(model%control%gravity(2))//']'
      case ('material.young_modulus')
         value = number_text(model%materials(k)%young_modulus)
      case ('material.poisson_ratio')
         value = number_text(model%materials(k)%poisson_ratio)
      case ('material.damping_ratio')
         if (model%materials(k)%damping%by_law) value = &
            number_text(model%materials(k)%damping%ratio)
      case ('contact.normal_stiffness')
         value = number_text(model%contact%normal_stiffness)
      case ('output.file')
         value = quoted_text(model%output%file)
      case ('boundary.kind')
         value = quoted_text(effective_kind(group))
      case ('measured_point.block')
         value = quoted_text(model%block_names(model%points(k)%block))
      case ('load.block')
         value = quoted_text(model%block_names(model%loads(k)%block))
      end select
      if (group%name == 'joint') value = derived_joint_value(model%joints(k), name)
      if (group%name == 'stage') value = derived_stage_value(model%stages(k), name)
   end function derived_value

   !> Stiffness and strength of a joint that are derived from other variables.
   pure function derived_joint_value(joint, name) result(value)
      type(joint_type), intent(in) :: joint    !< joint of the model
      character(len=*), intent(in) :: name     !< name of the variable
      character(len=:), allocatable :: value

      value = ''
      select case (name)
      case ('normal_stiffness_per_area')
         if (joint%normal_stiffness > 0.0_wp) value = number_text(joint%normal_stiffness)
      case ('contact_points')
         value = to_text(joint%contact_points)
      case ('max_closure')
         if (joint%max_closure > 0.0_wp) value = number_text(joint%max_closure)
      case ('residual_friction_angle')
         if (joint%law == 'mohr_coulomb') value = number_text(joint%residual_friction_angle)
      end select
   end function derived_joint_value

   !> Settings of the steps of a dynamic stage, given or from &control.
   pure function derived_stage_value(stage, name) result(value)
      type(stage_type), intent(in) :: stage    !< stage of the model
      character(len=*), intent(in) :: name     !< name of the variable
      character(len=:), allocatable :: value

      value = ''
      if (stage%static) return
      if (name == 'time_step') value = number_text(stage%time_step)
      if (name == 'integration') value = quoted_text(stage%integration)
      if (name == 'theta') value = number_text(stage%theta)
   end function derived_stage_value

   !> Text of a given value; null for an omitted value of a list.
   pure function given_value(input_value, variable) result(value)
      type(value_type), intent(in) :: input_value         !< value as read
      type(variable_type), intent(in) :: variable   !< variable of the schema
      character(len=:), allocatable :: value
      type(page_type) :: page
      integer :: i

      value = ''
      if (input_value%n == 0) return
      allocate (character(len=64) :: page%text)
      do i = 1, input_value%n
         if (i > 1) call append_text(page, ', ')
         if (any(variable%kind == ['name', 'word', 'text'])) then
            value = ''
            call input_value%get_text(i, value)
            value = quoted_text(value)
         else if (variable%kind == 'logical') then
            value = trim(merge('true ', 'false', input_value%numbers(i) > 0.0_wp))
         else if (variable%kind == 'integer') then
            value = number_text(input_value%numbers(i), is_integer=.true.)
         else
            value = number_text(input_value%numbers(i))
         end if
         call append_text(page, value)
      end do
      value = page%text(:page%n)
      if (variable%size > 0) value = '['//value//']'
   end function given_value

   !> Default of the schema; blank if there is none, or if it depends on another variable.
   pure function default_value(variable) result(value)
      type(variable_type), intent(in) :: variable   !< variable of the schema
      character(len=:), allocatable :: value

      value = ''
      if (variable%switch /= '') then
         return
      else if (variable%usual /= '') then
         value = quoted_text(variable%usual)
      else if (variable%kind == 'logical') then
         value = trim(merge('true ', 'false', variable%preset > 0.0_wp))
      else if (variable%preset /= unset .and. variable%kind == 'integer') then
         value = number_text(variable%preset, is_integer=.true.)
      else if (variable%preset /= unset) then
         value = number_text(variable%preset)
      end if
   end function default_value

   !> Text of a number with all its digits; real numbers have a point.
   pure function number_text(value, is_integer) result(text)
      real(wp), intent(in) :: value                 !< `unset`: null
      logical, intent(in), optional :: is_integer        !< the number is an integer
      character(len=:), allocatable :: text
      character(len=24) :: buffer

      if (value == unset) then
         text = 'null'
      else if (value == aint(value) .and. abs(value) < 1.0e9_wp) then
         text = to_text(int(value))
         if (.not. present(is_integer)) text = text//'.0'
      else
         write (buffer, '(es24.16e3)') value
         text = trim(adjustl(buffer))
      end if
   end function number_text

   !> Text in quotes; control characters, which netCDF and JSON do not allow, become blanks.
   pure function quoted_text(value) result(text)
      character(len=*), intent(in) :: value         !< trailing blanks are dropped
      character(len=:), allocatable :: text
      integer :: i

      text = trim(value)
      do i = len(text), 1, -1
         if (iachar(text(i:i)) < 32) text(i:i) = ' '
         if (scan(text(i:i), '"\') > 0) text = text(:i - 1)//'\'//text(i:)
      end do
      text = '"'//text//'"'
   end function quoted_text

   !> Append a text to a page.
   pure subroutine append_text(page, new_text)
      type(page_type), intent(inout) :: page        !< page to append to
      character(len=*), intent(in) :: new_text         !< text to append
      character(len=:), allocatable :: longer

      if (page%n + len(new_text) > len(page%text)) then
         allocate (character(len=2*(page%n + len(new_text))) :: longer)
         longer(:page%n) = page%text(:page%n)
         call move_alloc(longer, page%text)
      end if
      page%text(page%n + 1:page%n + len(new_text)) = new_text
      page%n = page%n + len(new_text)
   end subroutine append_text

end module dda_input_resolved
