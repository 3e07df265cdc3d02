! SPDX-License-Identifier: GPL-3.0-or-later
!> A text as groups of values: comments, quotes, line ends, where each group begins, and all forms
!> of numbers, logical values, texts and lists.
module test_input_text
   use dda_errors, only: error_input
   use dda_input_groups, only: control_values, run_values, traction_values, read_values
   use dda_input_text, only: group_type, parse_group, split_groups
   use dda_kinds, only: wp
   use testing, only: check, check_fails, check_no_error, error
   implicit none

   character, parameter :: newline = achar(10), carriage_return = achar(13), tab = achar(9)

contains

   subroutine expect(text, names, lines)
      character(len=*), intent(in) :: text, names(:)
      integer, intent(in) :: lines(:)
      type(group_type), allocatable :: groups(:)
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

   !> The only group with its values.
   subroutine parse(text, group)
      character(len=*), intent(in) :: text
      type(group_type), intent(out) :: group
      type(group_type), allocatable :: groups(:)

      call split_groups('f.nml', text, groups, error)
      if (allocated(error)) return
      group = groups(1)
      call parse_group(text, group, error)
   end subroutine parse

   !> The times of a load.
   subroutine expect_times(values, times)
      character(len=*), intent(in) :: values   !< of the text, with the name
      real(wp), intent(in) :: times(:)
      type(group_type) :: group
      type(traction_values) :: traction

      call parse('&traction normal = 1 '//values//' /', group)
      if (.not. allocated(error)) call read_values(group, traction, error)
      call check_no_error(error, values)
      if (.not. allocated(error)) then
         call check(size(traction%time) == size(times), 'number of '//values)
         if (size(traction%time) == size(times)) call check(all(traction%time == times), values)
      end if
   end subroutine expect_times

   !> The title of a run.
   subroutine expect_title(value, title)
      character(len=*), intent(in) :: value, title
      type(group_type) :: group
      type(run_values) :: run

      call parse('&run title = '//value//' /', group)
      call check_no_error(error, value)
      if (allocated(error)) return
      call read_values(group, run, error)
      call check(run%title == title, value//' is "'//run%title//'"')
   end subroutine expect_title

   !> Whether a model settles.
   subroutine expect_settle(value, settles)
      character(len=*), intent(in) :: value
      logical, intent(in) :: settles
      type(group_type) :: group
      type(control_values) :: control

      control%settle = .not. settles
      call parse('&control settle = '//value//' time_step = 1 /', group)
      call check_no_error(error, value)
      if (.not. allocated(error)) call read_values(group, control, error)
      call check(control%settle .eqv. settles, 'settle = '//value)
   end subroutine expect_settle

   subroutine wrong(text, message)
      character(len=*), intent(in) :: text, message
      type(group_type) :: group

      call parse(text, group)
      call check_fails(error, message)
   end subroutine wrong

   subroutine refused(text, names)
      character(len=*), intent(in) :: text, names
      type(group_type), allocatable :: groups(:)

      call split_groups('f.nml', text, groups, error)
      call check_fails(error, names)
      call check_fails(error, 'f.nml')
      if (allocated(error)) call check(error%kind == error_input, 'its kind')
   end subroutine refused

   subroutine plain_groups()
      call expect('&run title = ''a'' /', ['run'], [1])
      call expect('&run /'//newline//newline//'  &CONTROL x = 1'//newline//'y = 2 /'//newline// &
         '&fixed_point /', [character(len=11) :: 'run', 'control', 'fixed_point'], [1, 3, 5])
      call expect('&a / &b / &c/', ['a', 'b', 'c'], [1, 1, 1])
   end subroutine plain_groups

   subroutine comments_and_quotes()
      call expect('! &no group / ''"'//newline//'&a x = 1 ! it''s / &b'//newline//'/ ! end', &
         ['a'], [2])
      call expect_title('''a/b!c&d''', 'a/b!c&d')
      call expect_title('"it''s / here"', 'it''s / here')
      call expect_title('''it''''s''', 'it''s')
      call expect_title('""""', '"')
      call expect_title('''two'//newline//'lines''', 'two lines')
      call expect_title('12', '12')
      call expect('&a x = ''two'//newline//'lines'' / &b /', ['a', 'b'], [1, 2])
   end subroutine comments_and_quotes

   subroutine line_ends_and_marks()
      call expect('&a'//carriage_return//newline//'x = 1'//carriage_return//newline//'/'// &
         carriage_return//newline//'&b /', ['a', 'b'], [1, 4])
      call expect(char(239)//char(187)//char(191)//'&a /', ['a'], [1])
      call expect('! Höhe – ☃'//newline//'&a /', ['a'], [2])
   end subroutine line_ends_and_marks

   !> More groups than any first guess of their number.
   subroutine many_groups()
      integer, parameter :: count = 1000
      character(len=:), allocatable :: text
      integer :: i

      text = repeat('&block x = 1 /'//newline, count)
      call expect(text, spread('block', 1, count), [(i, i=1, count)])
   end subroutine many_groups

   subroutine empty_input()
      call expect('', [character(len=1) ::], [integer ::])
      call expect('  '//newline//'! only a comment', [character(len=1) ::], [integer ::])
   end subroutine empty_input

   subroutine numbers()
      call expect_times('time = 1 2.5, -3e2 4d-1 5q0 +6. .7', [1.0_wp, 2.5_wp, -300.0_wp, 0.4_wp, &
         5.0_wp, 6.0_wp, 0.7_wp])
      call expect_times('time = 1.5+2 ! not 3'//newline//' 4', [150.0_wp, 4.0_wp])
      call expect_times('time=0.1 ,1e-30', [0.1_wp, 1.0e-30_wp])
      call expect_times('time = 123456789012345678901234567890', [1.2345678901234568e29_wp])
      call expect_times('TIME = 1 normal = 2', [1.0_wp])
      call expect_times('time = 5.562684646268003e-309 1e-330', [0.25_wp*tiny(1.0_wp), 0.0_wp])
   end subroutine numbers

   subroutine lists()
      call expect_times('time = 3*1.5', [1.5_wp, 1.5_wp, 1.5_wp])
      call expect_times('time = 1 2*2, 3,', [1.0_wp, 2.0_wp, 2.0_wp, 3.0_wp])
      call expect_times('time(2) = 5 time(1) = 4', [4.0_wp, 5.0_wp])
      call expect_times('time(2:3) = 5 6 time ( 1 ) = 4', [4.0_wp, 5.0_wp, 6.0_wp])
      call expect_times('time(1:3:2) = 5 6 time(2) = 4', [5.0_wp, 4.0_wp, 6.0_wp])
      call expect_times('time = 1 2 3 time = 4', [4.0_wp, 2.0_wp, 3.0_wp])
      call expect_times('time = 1 2 3 time = , 4', [1.0_wp, 4.0_wp, 3.0_wp])
      call expect_times('time = 1 2 3 time = 1* 4', [1.0_wp, 4.0_wp, 3.0_wp])
      call expect_times('time = normal = 2', [real(wp) ::])
   end subroutine lists

   subroutine logical_values()
      call expect_settle('.true.', .true.)
      call expect_settle('T', .true.)
      call expect_settle('.f.', .false.)
      call expect_settle('false,', .false.)
   end subroutine logical_values

   subroutine invalid_values()
      call wrong('&load time = 1 x2 /', '''x2'' is not a number')
      call wrong('&load time = ''1 2'' /', 'time: ''1 2'' is not a number')
      call wrong('&load x = 1 kN /', 'has all its values; values have no units')
      call refused('&load x = 1 kg/m3 /', &
         'found ''m3''; the slash before it closes &load: values have no units')
      call wrong('&load time = 5000*1 /', '5000*')
      call wrong('&load time = 4000*1 200*1 /', 'has all its values')
      call wrong('&load time(5000) = 1 /', 'there is no element (5000)')
      call wrong('&load time(0) = 1 /', 'there is no element (0)')
      call wrong('&load x(1) = 1 /', 'there is no element (1)')
      call wrong('&load x = 1 2 /', '''2'' cannot be read here')
      call wrong('&load x y = 1 /', '''x'' cannot be read here')
      call wrong('&load xx = 1 /', '''xx''')
      call wrong('&run title = word /', '''word'' must be in quotes')
      call wrong('&control settle = 1 /', 'neither .true. nor .false.')
   end subroutine invalid_values

   subroutine refusals()
      call refused(newline//newline//'run', 'line 3')
      call refused('&a / stray &b /', 'stray')
      call refused('&a x = 1'//newline//'&b /', '&a')
      call refused('&a /'//newline//'&b x = 1', 'line 2')
      call refused('&a x = ''open /', 'quote')
      call refused('&b x = "open'//newline//'/', 'no closing slash')
   end subroutine refusals

   !> A text cut off anywhere is read or refused; nothing else happens.
   subroutine truncated_text()
      character(len=*), parameter :: text = char(239)//char(187)//char(191)//'! c'//newline// &
         '&a x = ''it''''s/'' ! d / '// &
         carriage_return//newline//tab//'/ &b y(2) = 1, "&" /'//newline
      type(group_type), allocatable :: groups(:)
      integer :: i, n_read

      n_read = 0
      do i = 0, len(text)
         call split_groups('f.nml', text(:i), groups, error)
         if (.not. allocated(error)) n_read = n_read + 1
      end do
      call check(n_read > 5 .and. n_read < len(text), 'some cuts are whole')
   end subroutine truncated_text

end module test_input_text
