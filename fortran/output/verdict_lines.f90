! SPDX-License-Identifier: GPL-3.0-or-later
!> Parts of a verdict (sentence on the events, table of results, warnings, named numbers), formatted
!> for the attributes of an output and for a screen.
module dda_verdict_lines
   use dda_kinds, only: wp, pi
   use dda_doubts, only: doubt_type, doubt_text
   use dda_text, only: padded, screen_width, short_text, wrapped
   implicit none
   private
   public :: verdict_lines_type, verdict_value_type, add_sentence, add_value, add_figure, &
      figure_lines, doubt_lines, screen_text, value_text, died_out, check_says_more, no_bars

   character(len=*), parameter :: check_says_more = 'what to change: sitedda check FILE.nml', &
      no_bars = 'these figures have no error bars: sitedda accuracy FILE.nml computes them'

   integer, parameter :: columns(3) = [20, 34, 48]  !< positions of the table columns
   !> final value/largest value below which the final value counts as zero
   real(wp), parameter :: died_out = 1.0e-5_wp

   !> Number of a verdict with its name.
   type :: verdict_value_type
      character(len=:), allocatable :: name  !< name that ends with the unit
      real(wp) :: value = 0.0_wp
   end type verdict_value_type

   !> Line of the table of results.
   type :: figure_type
      character(len=:), allocatable :: name        !< displayed name
      character(len=256) :: key(2) = ''  !< names of the largest and the final number, or blank
      character(len=:), allocatable :: unit        !< displayed unit
      character(len=:), allocatable :: location    !< position and time of the largest value
      real(wp) :: value(2) = 0.0_wp                !< values in the displayed unit
   end type figure_type

   !> Contents of a verdict.
   type :: verdict_lines_type
      character(len=:), allocatable :: events          !< sentence on the events
      type(doubt_type), allocatable :: doubts(:)
      type(figure_type), allocatable :: figures(:)
      type(verdict_value_type), allocatable :: values(:)
   end type verdict_lines_type

   !> Displayed unit, used for values of at least `from`.
   type :: unit_type
      character(len=6) :: units
      character(len=6) :: displayed
      real(wp) :: from, scale
   end type unit_type

   !> displayed units; the first one whose `from` does not exceed the value is used
   type(unit_type), parameter :: displayed_units(*) = [ &
      unit_type('m', 'm', 1.0_wp, 1.0_wp), unit_type('m', 'mm', 1.0e-3_wp, 1.0e3_wp), &
      unit_type('m', 'µm', 1.0e-6_wp, 1.0e6_wp), unit_type('m', 'nm', 0.0_wp, 1.0e9_wp), &
      unit_type('rad', '°', 0.0_wp, 180/pi), unit_type('1', '%', 0.0_wp, 100.0_wp), &
      unit_type('N/m', 'MN/m', 1.0e6_wp, 1.0e-6_wp), &
      unit_type('N/m', 'kN/m', 0.0_wp, 1.0e-3_wp), &
      unit_type('m/s^2', 'm/s²', 0.0_wp, 1.0_wp), unit_type('m/s', 'm/s', 0.0_wp, 1.0_wp)]

contains

   !> Append a text to the sentence on the events.
   pure subroutine add_sentence(lines, clause)
      class(verdict_lines_type), intent(inout) :: lines  !< verdict that is being computed
      character(len=*), intent(in) :: clause              !< main clause

      if (lines%events /= '') lines%events = lines%events//'; '
      lines%events = lines%events//clause
   end subroutine add_sentence

   !> Add a number.
   pure subroutine add_value(lines, name, value)
      class(verdict_lines_type), intent(inout) :: lines  !< verdict that is being computed
      character(len=*), intent(in) :: name               !< name that ends with the unit
      real(wp), intent(in) :: value                      !< value in this unit

      lines%values = [lines%values, verdict_value_type(name, value)]
   end subroutine add_value

   !> Add a line to the table.
   pure subroutine add_figure(lines, name, keys, value, units, location)
      class(verdict_lines_type), intent(inout) :: lines  !< verdict that is being computed
      character(len=*), intent(in) :: name               !< displayed name
      character(len=*), intent(in) :: keys(2)            !< names of the numbers, see `figure_type`
      real(wp), intent(in) :: value(2)                   !< value; ignored for a blank key
      character(len=*), intent(in) :: units              !< unit of the values
      character(len=*), intent(in) :: location           !< position and time of the largest value
      character(len=:), allocatable :: displayed
      real(wp) :: scale

      call find_displayed_unit(units, maxval(abs(value), keys /= ''), displayed, scale)
      lines%figures = [lines%figures, figure_type(name, [character(len=256) :: keys], &
         displayed, location, scale*value)]
   end subroutine add_figure

   !> Find the displayed unit of a value, and its factor; a zero is displayed in the given unit.
   pure subroutine find_displayed_unit(units, value, displayed, scale)
      character(len=*), intent(in) :: units  !< units as in the list of maxima
      real(wp), intent(in) :: value          !< not negative
      character(len=:), allocatable, intent(out) :: displayed  !< displayed unit
      real(wp), intent(out) :: scale         !< factor from the unit to the displayed unit
      integer :: i

      displayed = units
      scale = 1.0_wp
      do i = 1, size(displayed_units)
         if (displayed_units(i)%units /= units .or. value < displayed_units(i)%from) cycle
         if (.not. value > 0.0_wp .and. any(units == ['m  ', 'N/m'])) return
         displayed = trim(displayed_units(i)%displayed)
         scale = displayed_units(i)%scale
         return
      end do
   end subroutine find_displayed_unit

   !> Value and unit as displayed.
   pure function value_text(value, units) result(text)
      real(wp), intent(in) :: value          !< value in its unit
      character(len=*), intent(in) :: units  !< units as in the list of maxima
      character(len=:), allocatable :: text, displayed
      real(wp) :: scale

      call find_displayed_unit(units, abs(value), displayed, scale)
      text = short_text(scale*value)//' '//displayed
   end function value_text

   !> Table for an output: displayed name, names of numbers, displayed unit and location of each
   !> result, in one line per result with fields separated by tabs.
   pure function figure_lines(lines) result(text)
      class(verdict_lines_type), intent(in) :: lines  !< complete verdict
      character(len=:), allocatable :: text
      character, parameter :: tab = achar(9)
      integer :: i

      text = ''
      do i = 1, size(lines%figures)
         associate (figure => lines%figures(i))
            if (i > 1) text = text//new_line('a')
            text = text//figure%name//tab//trim(figure%key(1))//tab//trim(figure%key(2))//tab// &
               figure%unit//tab//figure%location
         end associate
      end do
   end function figure_lines

   !> Warnings for an output, one per line.
   pure function doubt_lines(lines) result(text)
      class(verdict_lines_type), intent(in) :: lines  !< complete verdict
      character(len=:), allocatable :: text
      integer :: i

      text = ''
      do i = 1, size(lines%doubts)
         if (i > 1) text = text//new_line('a')
         text = text//doubt_text(lines%doubts(i))
      end do
   end function doubt_lines

   !> Verdict for a screen: sentence, warnings of the check, table, and other warnings.
   pure function screen_text(lines) result(text)
      class(verdict_lines_type), intent(in) :: lines  !< complete verdict
      character(len=:), allocatable :: text
      integer :: i

      text = wrapped(lines%events//'.', 0, screen_width)//screen_doubts(lines%doubts, .true.)
      if (size(lines%figures) > 0) text = text//new_line('a')// &
         padded(padded(padded('', columns(1))//'largest', columns(2))//'at the end', columns(3))// &
         'where, when'//new_line('a')
      do i = 1, size(lines%figures)
         text = text//figure_text(lines%figures(i))
      end do
      text = text//screen_doubts(lines%doubts, .false.)
      text = text(:len(text) - 1)
   end function screen_text

   !> Warnings for a screen, either of the check or of the run.
   pure function screen_doubts(doubts, of_check) result(text)
      type(doubt_type), intent(in) :: doubts(:)  !< all warnings
      logical, intent(in) :: of_check            !< select warnings of the check
      character(len=:), allocatable :: text
      integer :: i

      text = ''
      do i = 1, size(doubts)
         if (doubts(i)%of_check .eqv. of_check) text = text//'doubt  '// &
            wrapped(doubt_text(doubts(i)), len('doubt  '), screen_width)
      end do
      if (of_check .and. text /= '') text = text//check_says_more//new_line('a')
      if (text /= '') text = new_line('a')//text
   end function screen_doubts

   !> Line of the table for a screen.
   pure function figure_text(figure) result(text)
      type(figure_type), intent(in) :: figure  !< line of the table
      character(len=:), allocatable :: text
      real(wp) :: value(2)
      integer :: k

      value = figure%value
      if (figure%key(1) /= '' .and. abs(value(2)) < died_out*abs(value(1))) value(2) = 0.0_wp
      text = figure%name
      do k = 1, 2
         text = padded(text, columns(k))
         if (figure%key(k) /= '') text = text//short_text(value(k))//' '//figure%unit
      end do
      text = padded(text, columns(3))//wrapped(figure%location, columns(3), screen_width)
   end function figure_text

end module dda_verdict_lines
