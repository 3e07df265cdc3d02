! SPDX-License-Identifier: GPL-3.0-or-later
!> The project's own small test framework: named cases, checks that keep going, one verdict.
!>
!> A suite is a module `test_<name>`; each subroutine without arguments is a test, a case of its
!> name; one that has several calls `case('…')` before the checks of each.  The tester runs suites
!> by name and ends with status 1 if any check failed.
module testing
   use dda_kinds, only: wp
   use dda_errors, only: error_type
   implicit none
   private
   public :: case, check, check_close, check_no_error, check_fails, failures, checks, error

   integer, protected :: failures = 0   !< checks that failed
   integer, protected :: checks = 0     !< checks made
   character(len=:), allocatable :: current
   type(error_type), allocatable :: error  !< of the last call under test; none when a case begins

   !> |a − b| ≤ relative·max|b| + absolute, element by element against the largest.
   interface check_close
      module procedure check_close_number
      module procedure check_close_vector
      module procedure check_close_matrix
   end interface check_close

contains

   !> Set the name of the case of the next checks.
   subroutine case(name)
      character(len=*), intent(in) :: name

      current = name
      if (allocated(error)) deallocate (error)
   end subroutine case

   subroutine check(condition, label)
      logical, intent(in) :: condition
      character(len=*), intent(in) :: label

      checks = checks + 1
      if (condition) return
      failures = failures + 1
      print '(5a)', 'FAILED  ', current, ': ', label
   end subroutine check

   subroutine check_close_number(actual, expected, label, relative, absolute)
      real(wp), intent(in) :: actual, expected
      character(len=*), intent(in) :: label
      real(wp), intent(in), optional :: relative, absolute

      call check_close_vector([actual], [expected], label, relative, absolute)
   end subroutine check_close_number

   subroutine check_close_matrix(actual, expected, label, relative, absolute)
      real(wp), intent(in) :: actual(:,:), expected(:,:)
      character(len=*), intent(in) :: label
      real(wp), intent(in), optional :: relative, absolute

      call check_close_vector(reshape(actual, [size(actual)]), reshape(expected, &
         [size(expected)]), label, relative, absolute)
   end subroutine check_close_matrix

   subroutine check_close_vector(actual, expected, label, relative, absolute)
      real(wp), intent(in) :: actual(:), expected(:)
      character(len=*), intent(in) :: label
      real(wp), intent(in), optional :: relative, absolute
      real(wp) :: tolerance, max_error
      integer :: where_worst
      character(len=160) :: detail

      call check(size(actual) == size(expected), label//' (sizes differ)')
      if (size(actual) /= size(expected) .or. size(actual) == 0) return
      tolerance = 0.0_wp
      if (present(relative)) tolerance = relative*maxval(abs(expected))
      if (present(absolute)) tolerance = tolerance + absolute
      where_worst = maxloc(abs(actual - expected), 1)
      max_error = abs(actual(where_worst) - expected(where_worst))
      write (detail, '(a,es23.15,a,es23.15,a,es9.2,a,es9.2)') ' got', actual(where_worst), &
         ' expected', expected(where_worst), ' off by', max_error, ' allowed', tolerance
      call check(all(abs(actual - expected) <= tolerance), label//trim(detail))
   end subroutine check_close_vector

   subroutine check_no_error(error, label)
      type(error_type), allocatable, intent(in) :: error
      character(len=*), intent(in) :: label

      if (allocated(error)) then
         call check(.false., label//': '//error%message)
      else
         call check(.true., label)
      end if
   end subroutine check_no_error

   !> Check that an error exists and its message contains the given text.
   subroutine check_fails(error, names)
      type(error_type), allocatable, intent(in) :: error
      character(len=*), intent(in) :: names

      call check(allocated(error), 'an error that names "'//names//'"')
      if (.not. allocated(error)) return
      call check(index(error%message, names) > 0, '"'//names//'" named in: '//error%message)
   end subroutine check_fails

end module testing
