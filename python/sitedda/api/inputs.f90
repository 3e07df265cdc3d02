! SPDX-License-Identifier: GPL-3.0-or-later
!> Texts of inputs: their groups and values, and changes of them.
module api_inputs
   use, intrinsic :: iso_c_binding, only: c_double, c_int
   use api_failure, only: error
   use dda_input_catalogue, only: find_group
   use dda_input_changes, only: change_type, change_text
   use dda_input_joint, only: find_reduced_strengths
   use dda_input_text, only: group_type, parse_group, split_groups
   use dda_input_variable, only: unset
   use dda_joint_law, only: strength_type
   use dda_text, only: joined
   implicit none
   private
   public :: parse_input, parsed_input, make_changes, changed_text, reduced_group

   type(group_type), allocatable :: parsed(:)     !< of the text that was parsed last
   character(len=:), allocatable :: changed       !< text that was changed last

contains

   !> Read a text as groups of values, which `parsed_input` then hands out.
   subroutine parse_input(file, text, skipped, sizes)
      character(len=*), intent(in) :: file, text   !< path, for messages; of the input
      character(len=*), intent(in) :: skipped      !< groups whose values are not read: 'one two'
      integer(c_int), intent(out) :: sizes(4)      !< groups, values, numbers, bytes of texts
      integer :: i

      sizes = 0
      call split_groups(file, text, parsed, error)
      do i = 1, size(parsed)
         if (allocated(error)) exit
         if (index(' '//skipped//' ', ' '//parsed(i)%name//' ') == 0 .and. &
            find_group(parsed(i)%name) > 0) call parse_group(text, parsed(i), error)
         call count_values(parsed(i), sizes)
      end do
   end subroutine parse_input

   !> Add the sizes of a group to those of the groups before it.
   pure subroutine count_values(group, sizes)
      type(group_type), intent(inout) :: group   !< gets no values where it was not read
      integer(c_int), intent(inout) :: sizes(4)  !< see `parse_input`
      integer :: i, k

      if (.not. allocated(group%values)) allocate (group%values(0))
      sizes(1:2) = sizes(1:2) + [1, size(group%values)]
      do i = 1, size(group%values)
         associate (value => group%values(i))
            sizes(3) = sizes(3) + value%n
            if (.not. allocated(value%words)) cycle
            do k = 1, value%n
               if (allocated(value%words(k)%text)) sizes(4) = sizes(4) + len(value%words(k)%text)
            end do
         end associate
      end do
   end subroutine count_values

   !> The groups of the text that was parsed last: line, first and last byte, number of values;
   !> of each value the position of its variable in the schema, and how many it has; numbers, or
   !> the lengths of texts, and the texts.  Missing values are -huge.
   subroutine parsed_input(n_groups, n_values, n_numbers, n_bytes, groups, values, numbers, bytes)
      integer(c_int), intent(in) :: n_groups, n_values, n_numbers, n_bytes  !< of `parse_input`
      integer(c_int), intent(out) :: groups(4, n_groups), values(2, n_values)
      real(c_double), intent(out) :: numbers(n_numbers)
      integer(c_int), intent(out) :: bytes(n_bytes)
      integer :: g, i, k, v, n, b, c

      v = 0
      n = 0
      b = 0
      do g = 1, size(parsed)
         groups(:, g) = [parsed(g)%line, parsed(g)%first, parsed(g)%last, size(parsed(g)%values)]
         do i = 1, size(parsed(g)%values)
            v = v + 1
            associate (value => parsed(g)%values(i))
               values(:, v) = [value%variable, value%n]
               do k = 1, value%n
                  n = n + 1
                  numbers(n) = unset
                  if (allocated(value%numbers)) numbers(n) = value%numbers(k)
                  if (.not. allocated(value%words)) cycle
                  if (.not. allocated(value%words(k)%text)) cycle
                  numbers(n) = len(value%words(k)%text)
                  do c = 1, len(value%words(k)%text)
                     b = b + 1
                     bytes(b) = iachar(value%words(k)%text(c:c))
                  end do
               end do
            end associate
         end do
      end do
      deallocate (parsed)
   end subroutine parsed_input

   !> Change variables of a text, which `changed_text` gives then.
   subroutine make_changes(file, text, words, n, lengths, variables, length)
      character(len=*), intent(in) :: file, text   !< path, for messages; of the input
      character(len=*), intent(in) :: words        !< path and value of each change, without gaps
      integer(c_int), intent(in) :: n              !< changes
      integer(c_int), intent(in) :: lengths(2, n)  !< bytes of path and value; -1: takes it out
      integer(c_int), intent(out) :: variables(n)  !< their positions in the schema
      integer(c_int), intent(out) :: length        !< bytes of the new text
      type(change_type) :: changes(n)
      integer :: i, at

      at = 0
      do i = 1, n
         changes(i)%path = words(at + 1:at + lengths(1, i))
         at = at + lengths(1, i)
         if (lengths(2, i) >= 0) changes(i)%value = words(at + 1:at + lengths(2, i))
         at = at + max(0_c_int, lengths(2, i))
      end do
      changed = text
      call change_text(file, changed, changes, error)
      variables = changes%variable
      length = len(changed)
   end subroutine make_changes

   !> The text with the changes that were made last.
   subroutine changed_text(n, bytes)
      integer(c_int), intent(in) :: n
      integer(c_int), intent(out) :: bytes(n)
      integer :: i

      bytes = [(iachar(changed(i:i)), i=1, n)]
   end subroutine changed_text

   !> The variables of a &joint or &material with which all its strength is divided by a factor.
   subroutine reduced_group(text, factor, names, values)
      character(len=*), intent(in) :: text
      real(c_double), intent(in) :: factor
      character(len=2048), intent(out) :: names  !< with blanks between
      real(c_double), intent(out) :: values(32)
      type(strength_type), allocatable :: strengths(:)

      call find_reduced_strengths('model', text, factor, strengths, error)
      names = joined(strengths%name, ' ')
      values(:size(strengths)) = strengths%value
   end subroutine reduced_group

end module api_inputs
