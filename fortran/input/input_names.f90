! SPDX-License-Identifier: GPL-3.0-or-later
!> Lists of names in one text, 'one, two, all_*'.
module dda_input_names
   use dda_errors, only: error_type
   use dda_input_group, only: group_type, input_error
   use dda_text, only: quoted
   implicit none
   private
   public :: mark_names

contains

   !> Mark all that a list 'one, two, all_*' names; each item must name something.
   subroutine mark_names(list, variable, names, group, marked, error)
      character(len=*), intent(in) :: list, variable  !< list as read; its variable
      character(len=*), intent(in) :: names(:)        !< known ones
      type(group_type), intent(in) :: group           !< of the group
      logical, intent(inout) :: marked(:)             !< [names] named in the list, or marked before
      type(error_type), allocatable, intent(inout) :: error  !< error, set on the first failure
      character(len=:), allocatable :: rest, entry
      integer :: comma, star, i
      logical :: found

      rest = trim(list)
      do while (len(rest) > 0 .and. .not. allocated(error))
         comma = index(rest//',', ',')
         entry = trim(adjustl(rest(:comma - 1)))
         rest = trim(rest(min(comma + 1, len(rest) + 1):))
         star = index(entry, '*')
         found = .false.
         do i = 1, size(names)
            if (star > 0) then
               if (star /= len(entry)) cycle
               if (index(names(i), entry(:star - 1)) /= 1) cycle
            else if (names(i) /= entry) then
               cycle
            end if
            found = entry /= ''
            marked(i) = marked(i) .or. found
         end do
         if (.not. found) call input_error(error, group, variable//': nothing is named '// &
            quoted(entry))
      end do
   end subroutine mark_names

end module dda_input_names
