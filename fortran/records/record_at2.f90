! SPDX-License-Identifier: GPL-3.0-or-later
!> PEER formats AT2, VT2 and DT2: four header lines, then samples.
!>
!> Reference: Pacific Earthquake Engineering Research Center, NGA ground motion database, header
!> lines `NPTS= 4000, DT= .0050 SEC` and, before 2004, `4000 0.0050 NPTS, DT`; the line before it
!> reads `… TIME SERIES IN UNITS OF G`.
module dda_record_at2
   use dda_kinds, only: wp, long
   use dda_text, only: lower_case, quoted
   use dda_text_lines, only: line_reader_type, fail_at
   use dda_text_numbers, only: read_next_number, number_found
   use dda_record_type, only: record_type, quantity_in, unit_type, find_unit
   use dda_record_samples, only: read_trace, read_line, check_count, check_time_step, &
      read_first_number
   implicit none
   private
   public :: read_at2

   integer, parameter :: max_header_lines = 10

contains

   !> Read the trace of a PEER file, in the unit of the file.
   subroutine read_at2(reader, record)
      type(line_reader_type), intent(inout) :: reader        !< reader at the start of the file
      type(record_type), intent(inout) :: record  !< record, filled from the file
      character(len=:), allocatable :: text
      integer(long) :: samples
      integer :: line

      do line = 1, max_header_lines
         call read_line(reader, text, 'a header line with NPTS')
         call read_title(text, line, record)
         if (index(lower_case(text), 'npts') > 0) exit
      end do
      if (line > max_header_lines) call fail_at(reader, &
         'the first lines do not state NPTS, as a PEER header does')
      call read_counts(reader, lower_case(text), samples, record%time_step)
      call read_trace(reader, samples, 'samples', record%values)
   end subroutine read_at2

   !> Read event and station from line 2, and quantity and unit from the words of any line.
   subroutine read_title(text, line, record)
      character(len=*), intent(in) :: text  !< line of the file
      integer, intent(in) :: line  !< number of the line
      type(record_type), intent(inout) :: record  !< record, filled from the file
      character(len=*), parameter :: before_unit = 'units of '
      character(len=:), allocatable :: title, name
      type(unit_type) :: unit
      integer :: at

      if (line == 2) record%description = trim(adjustl(text))
      title = lower_case(text)
      at = index(title, before_unit)
      if (at == 0) return
      if (quantity_in(title) /= '') record%quantity = quantity_in(title)
      name = adjustl(title(at + len(before_unit):))
      ! A full stop, a comma or further words may follow the unit ("G. FILTER POINTS: …").
      unit = find_unit(name(:scan(name//' ', ' .,;') - 1))
      record%unit = trim(unit%name)
   end subroutine read_title

   !> Read both styles of the line: `NPTS= number, DT= number` and `number number NPTS, DT`.
   subroutine read_counts(reader, text, samples, time_step)
      type(line_reader_type), intent(inout) :: reader  !< reader of the file; receives errors
      character(len=*), intent(in) :: text  !< line of the file, in lower case
      integer(long), intent(out) :: samples  !< number of samples by the header
      real(wp), intent(out) :: time_step  !< Δt, s
      real(wp) :: count
      integer :: position, first, second

      if (index(text, '=') > 0) then
         call read_named(reader, text, 'npts', count)
         call read_named(reader, text, 'dt', time_step)
      else
         position = 1
         call read_next_number(text, position, count, first, commas=.true.)
         call read_next_number(text, position, time_step, second, commas=.true.)
         if (first /= number_found .or. second /= number_found) call fail_at(reader, &
            quoted(text)//' does not begin with the number of samples and the time step')
      end if
      call check_count(reader, count, samples)
      call check_time_step(reader, time_step)
   end subroutine read_counts

   !> Read `name = number`.
   subroutine read_named(reader, text, name, value)
      type(line_reader_type), intent(inout) :: reader  !< reader of the file; receives errors
      character(len=*), intent(in) :: text, name  !< line in lower case; name: 'npts' or 'dt'
      real(wp), intent(out) :: value  !< value as stated
      character(len=:), allocatable :: remainder
      integer :: at

      at = index(text, name)
      remainder = adjustl(text(at + len(name):))
      if (at == 0 .or. index(remainder, '=') /= 1) &
         call fail_at(reader, quoted(text)//" does not state '"//name//"= number'")
      call read_first_number(reader, remainder(2:), name, value)
   end subroutine read_named

end module dda_record_at2
