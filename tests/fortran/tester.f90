! SPDX-License-Identifier: GPL-3.0-or-later
!> Runs the suite that the first argument names, or all; ends with status 1 if any check failed.
program tester
   use suites, only: run_suites
   use testing, only: checks, failures
   implicit none
   character(len=64) :: name
   logical :: found

   call get_command_argument(1, name)
   call run_suites(trim(name), found)
   if (.not. found) print '(3a)', 'there is no suite ''', trim(name), ''''
   print '(i0,a,i0,a)', checks - failures, ' passed, ', failures, ' failed'
   if (failures > 0 .or. .not. found) stop 1, quiet=.true.
end program tester
