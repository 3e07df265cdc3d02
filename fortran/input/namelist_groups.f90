! SPDX-License-Identifier: GPL-3.0-or-later
!> A namelist text cut into its groups, comments removed, each with the line it begins at.
module dda_namelist_groups
   use dda_errors, only: error_type, error_input, fail
   use dda_text, only: to_text, lower_case, quoted, whole_characters
   implicit none
   private
   public :: group_type, split_groups

   !> One group on one line, '&name … /'.
   type :: group_type
      character(len=:), allocatable :: name
      character(len=:), allocatable :: text
      integer :: line = 0
   end type group_type

   character(len=*), parameter :: name_characters = 'abcdefghijklmnopqrstuvwxyz0123456789_'
   character, parameter :: newline = achar(10), carriage_return = achar(13), tab = achar(9)

contains

   !> Cut `text` into groups.  Anything outside groups but comments and blanks is an error.
   subroutine split_groups(file, text, groups, error)
      character(len=*), intent(in) :: file  !< for messages
      character(len=*), intent(in) :: text  !< of the input
      type(group_type), allocatable, intent(out) :: groups(:)  !< in the order of the text
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      integer :: at, line, count

      allocate (groups(16))
      count = 0
      at = 1
      line = 1
      if (len(text) >= 3) then
         if (text(1:3) == char(239)//char(187)//char(191)) at = 4   ! byte-order mark
      end if
      if (index(text, achar(0)) > 0) then
         call fail(error, error_input, file//' is not a text file: byte '// &
            to_text(index(text, achar(0)))//' is zero')
         return
      end if
      do
         call skip_blank(text, at, line)
         if (at > len(text)) exit
         if (text(at:at) /= '&') then
            call fail(error, error_input, file//', line '//to_text(line)// &
               ': expected a group (&name), found '//quoted(first_word(text(at:))))
            return
         end if
         if (count == size(groups)) call double(groups)
         count = count + 1
         call take_group(file, text, at, line, groups(count), error)
         if (allocated(error)) return
      end do
      groups = groups(:count)
   end subroutine split_groups

   !> Move past blanks, line ends and comments.
   pure subroutine skip_blank(text, at, line)
      character(len=*), intent(in) :: text  !< of the input
      integer, intent(inout) :: at, line  !< position in the text, line number

      do while (at <= len(text))
         select case (text(at:at))
         case (newline)
            line = line + 1
         case (' ', tab, carriage_return)
            continue
         case ('!')
            call skip_comment(text, at)
            cycle
         case default
            return
         end select
         at = at + 1
      end do
   end subroutine skip_blank

   !> Move to the end of the line.
   pure subroutine skip_comment(text, at)
      character(len=*), intent(in) :: text  !< of the input
      integer, intent(inout) :: at  !< position in the text
      integer :: length

      length = index(text(at:), newline)
      at = merge(at + length - 1, len(text) + 1, length > 0)
   end subroutine skip_comment

   !> Take one group up to its closing slash.
   subroutine take_group(file, text, at, line, group, error)
      character(len=*), intent(in) :: file, text  !< path, for messages; text of the input
      integer, intent(inout) :: at, line  !< position in the text, line number
      type(group_type), intent(out) :: group  !< its name, text and line
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      integer :: length, last, lines

      group%line = line
      length = max(0, verify(lower_case(text(at + 1:min(len(text), at + 64))), name_characters) - 1)
      group%name = lower_case(text(at + 1:at + length))
      call find_close(text, at, last, lines)
      if (last == 0) then
         call fail(error, error_input, file//': group &'//group%name//' (line '//to_text(line)// &
            ') has no closing slash, or a quote in it stays open')
         return
      end if
      group%text = on_one_line(text(at:last))
      at = last + 1
      line = line + lines
   end subroutine take_group

   !> Position of the slash that closes the group at `first`; 0 if the next group begins before.
   pure subroutine find_close(text, first, last, lines)
      character(len=*), intent(in) :: text  !< of the input
      integer, intent(in) :: first  !< position of its &
      integer, intent(out) :: last, lines  !< position of its slash; line ends up to there
      character :: quote
      integer :: at

      last = 0
      lines = 0
      quote = ' '
      at = first + 1
      do while (at <= len(text))
         if (text(at:at) == newline) lines = lines + 1
         if (quote /= ' ') then
            if (text(at:at) == quote) quote = ' '
         else
            select case (text(at:at))
            case ("'", '"')
               quote = text(at:at)
            case ('!')
               call skip_comment(text, at)
               cycle
            case ('/')
               last = at
               return
            case ('&')
               return
            end select
         end if
         at = at + 1
      end do
   end subroutine find_close

   !> A group's text without comments, line ends and tabs.
   pure function on_one_line(text) result(copy)
      character(len=*), intent(in) :: text  !< of the input
      character(len=:), allocatable :: copy
      character :: quote
      integer :: at, length

      ! On the heap, whatever the length: a text of that length on the stack would end the program.
      allocate (character(len=len(text)) :: copy)
      quote = ' '
      length = 0
      at = 1
      do while (at <= len(text))
         if (quote == ' ' .and. text(at:at) == '!') then
            call skip_comment(text, at)
            cycle
         end if
         if (quote == ' ' .and. (text(at:at) == "'" .or. text(at:at) == '"')) then
            quote = text(at:at)
         else if (text(at:at) == quote) then
            quote = ' '
         end if
         length = length + 1
         copy(length:length) = text(at:at)
         if (iachar(text(at:at)) < 32) copy(length:length) = ' '
         at = at + 1
      end do
      copy = copy(:length)
   end function on_one_line

   !> The first word of a text, for messages.
   pure function first_word(text) result(word)
      character(len=*), intent(in) :: text  !< of the input
      character(len=:), allocatable :: word
      integer :: length

      length = scan(text//' ', ' '//tab//newline//carriage_return) - 1
      word = whole_characters(text(:min(length, 40)))
   end function first_word

   !> Space for twice as many groups.
   subroutine double(groups)
      !> twice as many elements afterwards
      type(group_type), allocatable, intent(inout) :: groups(:)
      type(group_type), allocatable :: larger(:)
      integer :: i

      allocate (larger(2*size(groups)))
      do i = 1, size(groups)
         larger(i)%line = groups(i)%line
         call move_alloc(groups(i)%name, larger(i)%name)
         call move_alloc(groups(i)%text, larger(i)%text)
      end do
      call move_alloc(larger, groups)
   end subroutine double

end module dda_namelist_groups
