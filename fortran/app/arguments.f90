! SPDX-License-Identifier: GPL-3.0-or-later
!> The command line of the native executable.
module dda_arguments
   use dda_errors, only: error_type, error_input, fail
   use dda_text, only: joined, quoted, to_text
   implicit none
   private
   public :: arguments_type, read_arguments, names_output, resume_command, usage

   integer, parameter :: longest_change = 1024

   !> The command line.
   type :: arguments_type
      character(len=:), allocatable :: command   !< 'run', 'resume', 'check', 'help' or 'version'
      character(len=:), allocatable :: file      !< input file
      character(len=:), allocatable :: output  !< output file; '': as in the input
      character(len=longest_change), allocatable :: changes(:)  !< 'NAME=VALUE' each
      logical :: quiet = .false.                 !< no progress lines
      logical :: check_first = .false.           !< run only if the check does not fail
   end type arguments_type

contains

   !> Read the command line; unknown arguments are errors.
   subroutine read_arguments(arguments, error)
      type(arguments_type), intent(out) :: arguments  !< arguments of the command line
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      character(len=:), allocatable :: argument
      integer :: i

      arguments%command = ''
      arguments%file = ''
      arguments%output = ''
      allocate (arguments%changes(0))
      i = 1
      do while (i <= command_argument_count())
         argument = command_argument(i)
         select case (argument)
         case ('-h', '--help')
            arguments%command = 'help'
            return
         case ('--version')
            arguments%command = 'version'
            return
         case ('-q', '--quiet')
            arguments%quiet = .true.
         case ('--check')
            arguments%check_first = .true.
         case ('-o', '--output')
            i = i + 1
            arguments%output = command_argument(i)
            if (arguments%output == '') call fail(error, error_input, '--output needs a file name')
         case ('--set')
            i = i + 1
            call read_change(arguments, command_argument(i), error)
         case default
            call read_word(arguments, argument, error)
         end select
         if (allocated(error)) return
         i = i + 1
      end do
      if (arguments%command == '') arguments%command = 'help'
      if (arguments%command /= 'help' .and. arguments%file == '') call fail(error, error_input, &
         arguments%command//' needs an input file')
   end subroutine read_arguments

   !> Read a change of the input, NAME=VALUE.
   subroutine read_change(arguments, text, error)
      type(arguments_type), intent(inout) :: arguments  !< arguments read so far
      character(len=*), intent(in) :: text  !< 'NAME=VALUE'
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      character(len=longest_change) :: change

      if (text == '') call fail(error, error_input, '--set needs NAME=VALUE')
      if (len(text) > longest_change) call fail(error, error_input, '--set accepts at most '// &
         to_text(longest_change)//' characters; '//quoted(text)//' has '//to_text(len(text)))
      change = text
      arguments%changes = [arguments%changes, change]
   end subroutine read_change

   !> Read a word: first the command, then the input file.
   subroutine read_word(arguments, argument, error)
      type(arguments_type), intent(inout) :: arguments  !< arguments read so far
      character(len=*), intent(in) :: argument  !< command or input file
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure

      if (arguments%command == '') then
         arguments%command = argument
         if (.not. any(argument == [character(len=6) :: 'run', 'resume', 'check'])) &
            call fail(error, error_input, 'there is no command '//quoted(argument)// &
            '; use run, resume or check')
      else if (arguments%file == '' .and. index(argument, '-') /= 1) then
         arguments%file = argument
      else
         call fail(error, error_input, 'the argument '//quoted(argument)//' is unknown')
      end if
   end subroutine read_word

   !> Argument of the command line; blank after the last one.
   function command_argument(i) result(argument)
      integer, intent(in) :: i  !< number, from 1
      character(len=:), allocatable :: argument
      integer :: length

      call get_command_argument(i, length=length)
      allocate (character(len=length) :: argument)
      call get_command_argument(i, argument)
   end function command_argument

   !> .true. if a change of the input names the output.
   pure logical function names_output(arguments)
      type(arguments_type), intent(in) :: arguments  !< arguments of the command line
      integer :: i

      names_output = .false.
      do i = 1, size(arguments%changes)
         associate (change => arguments%changes(i))
            names_output = names_output .or. change(:index(change, '=') - 1) == 'output.file'
         end associate
      end do
   end function names_output

   !> Command that continues an interrupted run.
   pure function resume_command(arguments) result(text)
      type(arguments_type), intent(in) :: arguments  !< arguments of the command line
      character(len=:), allocatable :: text
      integer :: i

      text = 'sitedda-native resume '//quote_for_shell(arguments%file)
      if (arguments%output /= '') text = text//' --output '//quote_for_shell(arguments%output)
      do i = 1, size(arguments%changes)
         text = text//' --set '//quote_for_shell(trim(arguments%changes(i)))
      end do
   end function resume_command

   !> A word as typed in a shell, in quotes if it needs them.
   pure function quote_for_shell(text) result(quoted)
      character(len=*), intent(in) :: text  !< any
      character(len=:), allocatable :: quoted
      character(len=*), parameter :: plain = 'abcdefghijklmnopqrstuvwxyz'// &
         'ABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-./=+:@%,'
      integer :: i

      quoted = text
      if (verify(text, plain) == 0) return
      quoted = ''
      do i = 1, len(text)
         if (text(i:i) == "'") then
            quoted = quoted//"'\''"
         else
            quoted = quoted//text(i:i)
         end if
      end do
      quoted = "'"//quoted//"'"
   end function quote_for_shell

   !> Text of --help.
   pure function usage() result(text)
      character(len=:), allocatable :: text
      character(len=*), parameter :: lines(*) = [character(len=84) :: &
         'usage: sitedda-native run FILE.nml [options]      run an input', &
         '       sitedda-native resume FILE.nml [options]   resume a run that ended early', &
         '       sitedda-native check FILE.nml              check a model before its run', &
         'options:', &
         '  -o, --output FILE.nc   output file; replaces the file in the input', &
         '      --set NAME=VALUE   change a variable of the input: time_step=5e-4,', &
         '                         material.clay.density=1900, joint[*].cohesion=0', &
         '      --check            check first, and do not start if the check fails', &
         '  -q, --quiet            no progress lines', &
         '  -h, --help             this text', &
         '      --version          the version', &
         'exit status: 0 done, 1 bad input, 2 the check fails, 3 a step does not converge,', &
         '  4 linear solver, 5 file, 6 interrupted (resume continues), 7 memory']

      text = joined(lines, new_line('a'))
   end function usage

end module dda_arguments
