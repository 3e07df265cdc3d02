! SPDX-License-Identifier: GPL-3.0-or-later
!> A text cut into groups: comments, quotes, line ends, and where each group begins.
module test_namelist_groups
   use dda_errors, only: error_input, error_type
   use dda_namelist_groups, only: group_type, split_groups
   use testing, only: case, check, check_fails, check_no_error
   implicit none
   private
   public :: namelist_groups_suite

   character, parameter :: newline = achar(10), carriage_return = achar(13), tab = achar(9)

contains

   subroutine namelist_groups_suite()
      call plain()
      call comments_and_quotes()
      call line_ends()
      call many()
      call nothing()
      call refusals()
      call any_cut()
   end subroutine namelist_groups_suite

   subroutine expect(text, names, lines)
      character(len=*), intent(in) :: text, names(:)
      integer, intent(in) :: lines(:)
      type(group_type), allocatable :: groups(:)
      type(error_type), allocatable :: error
      integer :: i

      call split_groups('f.nml', text, groups, error)
      call check_no_error(error, 'is read')
      if (allocated(error)) return
      call check(size(groups) == size(names), 'number of groups')
      if (size(groups) /= size(names)) return
      do i = 1, size(names)
         call check(groups(i)%name == names(i), 'name of group '//trim(names(i))//': '// &
            groups(i)%name)
         call check(groups(i)%line == lines(i), 'line of group '//trim(names(i)))
      end do
   end subroutine expect

   !> The text of the only group.
   subroutine expect_text(text, group)
      character(len=*), intent(in) :: text, group
      type(group_type), allocatable :: groups(:)
      type(error_type), allocatable :: error

      call split_groups('f.nml', text, groups, error)
      call check_no_error(error, 'is read')
      if (allocated(error)) return
      call check(size(groups) == 1, 'one group')
      if (size(groups) == 1) call check(groups(1)%text == group, 'its text: "'//groups(1)%text//'"')
   end subroutine expect_text

   subroutine refused(text, names)
      character(len=*), intent(in) :: text, names
      type(group_type), allocatable :: groups(:)
      type(error_type), allocatable :: error

      call split_groups('f.nml', text, groups, error)
      call check_fails(error, names)
      call check_fails(error, 'f.nml')
      if (allocated(error)) call check(error%kind == error_input, 'its kind')
   end subroutine refused

   subroutine plain()
      call case('plain groups')
      call expect('&run title = ''a'' /', ['run'], [1])
      call expect('&run /'//newline//newline//'  &CONTROL x = 1'//newline//'y = 2 /'//newline// &
         '&fixed_point /', [character(len=11) :: 'run', 'control', 'fixed_point'], [1, 3, 5])
      call expect('&a / &b / &c/', ['a', 'b', 'c'], [1, 1, 1])
      call expect_text('&a x = 1, 2 /', '&a x = 1, 2 /')
   end subroutine plain

   subroutine comments_and_quotes()
      call case('comments and quotes')
      call expect('! &no group / ''"'//newline//'&a x = 1 ! it''s / &b'//newline//'/ ! end', &
         ['a'], [2])
      call expect_text('&a x = ''a/b!c&d'' /', '&a x = ''a/b!c&d'' /')
      call expect_text('&a x = "it''s / here" /', '&a x = "it''s / here" /')
      call expect_text('&a x = ''it''''s'' /', '&a x = ''it''''s'' /')
      call expect_text('&a x = 1 ! / no end'//newline//' y = 2 /', '&a x = 1   y = 2 /')
      call expect('&a x = ''two'//newline//'lines'' / &b /', ['a', 'b'], [1, 2])
   end subroutine comments_and_quotes

   subroutine line_ends()
      call case('line ends and marks')
      call expect('&a'//carriage_return//newline//'x = 1'//carriage_return//newline//'/'// &
         carriage_return//newline//'&b /', ['a', 'b'], [1, 4])
      call expect_text('&a'//tab//'x = 1'//newline//'/', '&a x = 1 /')
      call expect(char(239)//char(187)//char(191)//'&a /', ['a'], [1])
      call expect('! Höhe – ☃'//newline//'&a /', ['a'], [2])
   end subroutine line_ends

   !> More groups than any first guess of their number.
   subroutine many()
      integer, parameter :: count = 1000
      character(len=:), allocatable :: text
      integer :: i

      call case('many groups')
      text = repeat('&block x = 1 /'//newline, count)
      call expect(text, spread('block', 1, count), [(i, i=1, count)])
   end subroutine many

   subroutine nothing()
      call case('nothing')
      call expect('', [character(len=1) ::], [integer ::])
      call expect('  '//newline//'! only a comment', [character(len=1) ::], [integer ::])
   end subroutine nothing

   subroutine refusals()
      call case('refusals')
      call refused(newline//newline//'run', 'line 3')
      call refused('&a / stray &b /', 'stray')
      call refused('&a x = 1'//newline//'&b /', '&a')
      call refused('&a /'//newline//'&b x = 1', 'line 2')
      call refused('&a x = ''open /', 'quote')
      call refused('&b x = "open'//newline//'/', 'no closing slash')
   end subroutine refusals

   !> A text cut off anywhere is read or refused; nothing else happens.
   subroutine any_cut()
      character(len=*), parameter :: text = char(239)//char(187)//char(191)//'! c'//newline// &
         '&a x = ''it''''s/'' ! d / '// &
         carriage_return//newline//tab//'/ &b y(2) = 1, "&" /'//newline
      type(group_type), allocatable :: groups(:)
      type(error_type), allocatable :: error
      integer :: i, read

      call case('cut off anywhere')
      read = 0
      do i = 0, len(text)
         call split_groups('f.nml', text(:i), groups, error)
         if (.not. allocated(error)) read = read + 1
      end do
      call check(read > 5 .and. read < len(text), 'some cuts are whole')
   end subroutine any_cut

end module test_namelist_groups
