! SPDX-License-Identifier: GPL-3.0-or-later
!> Check report: assessment of a run before its start.
!>
!> Each line has a verdict, a value with its limit, the source of the limit, and a remedy.
module dda_check_report
   use dda_kinds, only: wp
   use dda_check_band, only: band_type
   use dda_doubts, only: doubt_type
   use dda_modes, only: modes_type
   use dda_omega_max, only: omega_max_type
   use dda_text, only: screen_width, wrapped
   use dda_unresolved, only: unresolved_type
   implicit none
   private
   public :: add_check, add_line, add_notes, first_mode, line_type, report_text, report_type, &
      ringing_topic, verdict_fail, verdict_names, verdict_ok, verdict_warn

   !> topics of warnings that `remaining_doubts` (dda_run_verdict) may omit after the run
   character(len=*), parameter :: first_mode = 'first mode', ringing_topic = 'ringing'

   integer, parameter :: verdict_ok = 1, verdict_warn = 2, verdict_fail = 3
   character(len=4), parameter :: verdict_names(3) = ['ok  ', 'warn', 'FAIL']
   integer, parameter :: indent = 24      !< columns before the text of a line

   !> One line of the report.
   type :: line_type
      integer :: verdict = verdict_ok
      character(len=:), allocatable :: subject  !< subject
      character(len=:), allocatable :: finding  !< number and limit
      character(len=:), allocatable :: source   !< source of the limit
      character(len=:), allocatable :: advice   !< remedy, blank if none
      type(doubt_type) :: brief                 !< short form of the line in the verdict of a run
   end type line_type

   !> All lines, and the numbers computed for them.
   type :: report_type
      integer :: n = 0
      type(line_type), allocatable :: line(:)
      integer :: worst_verdict = verdict_ok
      type(omega_max_type) :: omega_max
      type(modes_type) :: modes
      type(unresolved_type) :: unresolved
      type(band_type) :: band
      logical :: has_highest = .false., has_modes = .false.
      real(wp) :: min_crossing_time(2) = 0.0_wp  !< of S and P waves in a block, s
      real(wp) :: max_crossing_time = 0.0_wp  !< longest crossing of a block by an S wave, s
      real(wp) :: slow_speed = 0.0_wp      !< S wave speed in the block of `max_crossing_time`, m/s
      real(wp) :: block_size(2) = 0.0_wp  !< smallest and largest shorter side of a block, m
      real(wp) :: speed(2) = 0.0_wp       !< smallest S and largest P wave speed, m/s
      real(wp) :: ringing_steps = 0.0_wp        !< steps to 1/e of the slowest alternating mode
      real(wp) :: frequency_shift = 0.0_wp  !< relative reduction of the first frequency by joints
      real(wp) :: memory_bytes = 0.0_wp         !< estimated memory of the run, bytes
      real(wp) :: run_seconds = 0.0_wp        !< estimated time of the run, s; 0: not known
   end type report_type

contains

   !> Append a line to the report.
   subroutine add_line(report, verdict, subject, finding, source, advice, topic, brief)
      type(report_type), intent(inout) :: report  !< check report
      integer, intent(in) :: verdict  !< verdict_ok, verdict_warn or verdict_fail
      !> subject; value and limit; source of the limit; remedy, blank if none
      character(len=*), intent(in) :: subject, finding, source, advice
      !> topic and text in the verdict of a run; default: subject; value and limit
      character(len=*), intent(in), optional :: topic, brief
      type(doubt_type) :: doubt

      doubt = doubt_type(subject, finding, .true.)
      if (present(topic)) doubt%topic = topic
      if (present(brief)) doubt%text = brief
      if (verdict == verdict_fail) doubt%text = doubt%text//' (FAIL)'
      if (report%n == 0) allocate (report%line(0))
      report%n = report%n + 1
      report%line = [report%line, line_type(verdict, subject, finding, source, advice, doubt)]
      report%worst_verdict = max(report%worst_verdict, verdict)
   end subroutine add_line

   !> Append a line: ok if the check passes, else a warning with its remedy.
   subroutine add_check(report, passes, subject, finding, source, remedy, topic, brief)
      type(report_type), intent(inout) :: report  !< check report
      logical, intent(in) :: passes               !< the check passes
      !> subject; value and limit; source of the limit; remedy of a warning
      character(len=*), intent(in) :: subject, finding, source, remedy
      !> topic and text in the verdict of a run; default: subject; value and limit
      character(len=*), intent(in), optional :: topic, brief

      if (passes) then
         call add_line(report, verdict_ok, subject, finding, source, '', topic, brief)
      else
         call add_line(report, verdict_warn, subject, finding, source, remedy, topic, brief)
      end if
   end subroutine add_check

   !> Append the notes on probable mistakes in a model.
   subroutine add_notes(report, notes)
      type(report_type), intent(inout) :: report  !< check report
      character(len=*), intent(in) :: notes(:)    !< [lines] notes
      integer :: i

      do i = 1, size(notes)
         call add_line(report, verdict_warn, 'input', trim(notes(i)), 'model', '')
      end do
   end subroutine add_notes

   !> Text of the report for a screen.
   pure function report_text(report) result(text)
      type(report_type), intent(in) :: report  !< check report
      character(len=:), allocatable :: text
      integer :: i

      text = ''
      do i = 1, report%n
         associate (line => report%line(i))
            text = text//verdict_names(line%verdict)//'  '//line%subject// &
               repeat(' ', max(1, indent - 6 - len(line%subject)))//wrapped(line%finding//' ['// &
               line%source//']', indent, screen_width)
            if (line%advice /= '') text = text//repeat(' ', indent)//wrapped('-> '// &
               line%advice, indent, screen_width)
         end associate
      end do
   end function report_text

end module dda_check_report
