! SPDX-License-Identifier: GPL-3.0-or-later
!> Python as the host of the engine: errors, signals, names and version.
module api_host
   use, intrinsic :: iso_c_binding, only: c_associated, c_double, c_int, c_ptr
   use api_failure, only: error
   use dda_energy, only: energy_terms
   use dda_input_boundaries, only: boundary_kinds
   use dda_interrupts, only: register_host, request_stop
   use dda_output_schema, only: contact_columns, is_whole, maxima_table, output_variables
   use dda_stopwatch, only: phase_names
   use dda_text, only: joined, screen_width, wrapped
   use dda_verdict_lines, only: check_says_more, died_out, no_bars
   use dda_version, only: version, commit
   implicit none
   private
   public :: forget_error, take_error, hear_python, stop_engine, engine_version, engine_names, &
      printing_rules, wrapped_text

   interface
      !> Python: take the lock of the interpreter, which this thread may or may not hold; its state.
      integer(c_int) function take_lock() bind(c, name='PyGILState_Ensure')
         import :: c_int
      end function take_lock

      !> Python: give the lock back.
      subroutine give_lock(state) bind(c, name='PyGILState_Release')
         import :: c_int
         integer(c_int), value :: state  !< from `take_lock`
      end subroutine give_lock

      !> Python: the exception that waits to be raised in this thread, or null.
      type(c_ptr) function exception() bind(c, name='PyErr_Occurred')
         import :: c_ptr
      end function exception

      !> Python: call the handlers of signals that have come; not 0 if one raises an exception.
      integer(c_int) function call_handlers() bind(c, name='PyErr_CheckSignals')
         import :: c_int
      end function call_handlers
   end interface

contains

   !> From here on the next call counts.
   subroutine forget_error()
      if (allocated(error)) deallocate (error)
   end subroutine forget_error

   !> Status of the last call, 0 or the kind of its error, and the message of that.
   subroutine take_error(status, message)
      integer(c_int), intent(out) :: status
      character(len=2048), intent(out) :: message

      status = 0
      message = ''
      if (.not. allocated(error)) return
      status = error%kind
      message = error%message
   end subroutine take_error

   !> From here on a signal whose handler in Python raises an exception, as Ctrl-C does, ends what
   !> the engine is at; the exception is raised when the call returns.
   subroutine hear_python()
      call register_host(has_exception)
   end subroutine hear_python

   !> Whether a handler of a signal has raised an exception: 1 yes.
   integer(c_int) function has_exception() bind(c)
      integer(c_int) :: state

      state = take_lock()
      has_exception = 1
      if (.not. c_associated(exception())) has_exception = merge(1_c_int, 0_c_int, &
         call_handlers() /= 0)
      call give_lock(state)
   end function has_exception

   !> Ask the engine to stop in this thread, for a signal; 0: no longer.
   subroutine stop_engine(number)
      integer(c_int), intent(in) :: number  !< of the signal

      call request_stop(number)
   end subroutine stop_engine

   !> Version of the engine, and the commit that it was built from.
   subroutine engine_version(number, built_from)
      character(len=32), intent(out) :: number, built_from

      number = version
      built_from = commit
   end subroutine engine_version

   !> Names, with blanks between: 'energies', 'phases' and 'counts' in the order of their
   !> values, 'maxima' with their 'maxima units' and 'maxima numbers', 'boundary kinds' and more
   subroutine engine_names(what, names)
      character(len=*), intent(in) :: what       !< one of these; else the names are blank
      character(len=2048), intent(out) :: names

      names = ''
      select case (what)
      case ('energies')
         names = joined(energy_terms%name, ' ')
      case ('maxima')
         names = joined(maxima_table%name, ' ')
      case ('maxima units')
         names = joined(maxima_table%units, ' ')
      case ('maxima numbers')
         names = joined(maxima_table%number, ' ')
      case ('phases')
         names = joined(phase_names, ' ')
      case ('counts')
         names = 'steps iterations searches solves factors solver_iterations handed_over broken'
      case ('contacts')
         names = joined(output_variables(contact_columns)%name(9:), ' ')
      case ('whole contacts')
         associate (all => output_variables(contact_columns))
            names = joined(pack(all%name(9:), all%kind == is_whole), ' ')
         end associate
      case ('boundary kinds')
         names = joined(boundary_kinds%name, ' ')
      case ('boundary kinds at rest')
         names = joined(boundary_kinds%at_rest, ' ')
      case ('boundary directions')
         names = joined([character(len=6) :: merge(boundary_kinds%direction, 'none  ', &
            boundary_kinds%direction /= '')], ' ')
      end select
   end subroutine engine_names

   !> By what verdicts are printed: the share of the largest value below which that at the end has
   !> died out, characters of a line; who says more of what the check doubts, and of error bars, a
   !> line each.
   subroutine printing_rules(least_share, width, words)
      real(c_double), intent(out) :: least_share
      integer(c_int), intent(out) :: width
      character(len=256), intent(out) :: words

      least_share = died_out
      width = screen_width
      words = check_says_more//new_line('a')//no_bars
   end subroutine printing_rules

   !> A text on lines of a screen, each with its line end, see `wrapped`; 0 behind it.
   subroutine wrapped_text(words, indent, width, n, bytes)
      character(len=*), intent(in) :: words          !< with single blanks between
      integer(c_int), intent(in) :: indent, width    !< of further lines, of all
      integer(c_int), intent(in) :: n                !< bytes that are enough
      integer(c_int), intent(out) :: bytes(n)
      character(len=:), allocatable :: text
      integer :: i

      text = wrapped(words, indent, width)
      bytes = 0
      bytes(:len(text)) = [(iachar(text(i:i)), i=1, len(text))]
   end subroutine wrapped_text

end module api_host
