! SPDX-License-Identifier: GPL-3.0-or-later
!> K-NET and KiK-net ASCII format: 17 header lines with a name in the first 18 columns, then
!> samples.
!>
!> Reference: NIED, *K-NET ASCII format* (www.kyoshin.bosai.go.jp): sampling frequency `100Hz`,
!> duration in seconds, scale factor `2000(gal)/8388608`; acceleration in gal is the integer
!> sample times the factor.  Raw records have an offset, which the baseline correction removes.
module dda_record_knet
   use dda_kinds, only: wp, long
   use dda_text, only: quoted, to_text
   use dda_text_lines, only: line_reader_type, fail_at
   use dda_record_type, only: record_type, acceleration
   use dda_record_samples, only: read_trace, read_line, check_count, check_time_step, &
      read_first_number
   implicit none
   private
   public :: read_knet

   integer, parameter :: header_lines = 17
   integer, parameter :: name_columns = 18
   ! limit of header values and samples (counts), so that products do not overflow
   real(wp), parameter :: largest = 1.0e12_wp

contains

   !> Read the trace of a K-NET file, in gal.
   subroutine read_knet(reader, record)
      type(line_reader_type), intent(inout) :: reader        !< reader at the start of the file
      type(record_type), intent(inout) :: record  !< record, filled from the file
      real(wp) :: frequency, duration, factor  ! samples/s, s, gal per count
      integer(long) :: samples

      record%quantity = acceleration
      record%unit = 'gal'
      call read_header(reader, record, frequency, duration, factor)
      if (frequency <= 0.0_wp .or. duration <= 0.0_wp .or. factor <= 0.0_wp) call fail_at(reader, &
         'sampling frequency, duration and scale factor must be positive numbers in the header')
      record%time_step = 1.0_wp/max(frequency, 1.0e-30_wp)
      call check_time_step(reader, record%time_step)
      call check_count(reader, anint(min(frequency*min(duration, largest), largest)), samples)
      call read_trace(reader, samples, 'samples (frequency × duration)', record%values)
      if (allocated(reader%error)) return
      if (maxval(abs(record%values)) > largest) call fail_at(reader, 'a sample of '// &
         to_text(maxval(abs(record%values)))//' counts')
      record%values = record%values*factor
   end subroutine read_knet

   !> Read the 17 header lines; missing values are negative.
   subroutine read_header(reader, record, frequency, duration, factor)
      type(line_reader_type), intent(inout) :: reader  !< reader of the file
      type(record_type), intent(inout) :: record  !< record, filled from the file
      real(wp), intent(out) :: frequency, duration, factor  !< samples/s, s, gal per count
      character(len=:), allocatable :: text, value
      integer :: line

      frequency = -1.0_wp
      duration = -1.0_wp
      factor = -1.0_wp
      do line = 1, header_lines
         call read_line(reader, text, 'the 17 header lines of K-NET')
         value = trim(adjustl(text(min(name_columns, len(text)) + 1:)))
         if (index(text, 'Origin Time') == 1) then
            record%description = 'event of '//value
         else if (index(text, 'Station Code') == 1) then
            record%station = value
         else if (index(text, 'Sampling Freq') == 1) then
            call read_first_number(reader, value, 'sampling frequency', frequency)
         else if (index(text, 'Duration Time') == 1) then
            call read_first_number(reader, value, 'duration', duration)
         else if (index(text, 'Scale Factor') == 1) then
            call read_factor(reader, value, factor)
         else if (index(text, 'Dir.') == 1) then
            record%description = record%description//', direction '//value
         end if
      end do
   end subroutine read_header

   !> Read a factor such as `2000(gal)/8388608`.
   subroutine read_factor(reader, text, factor)
      type(line_reader_type), intent(inout) :: reader  !< reader of the file; receives errors
      character(len=*), intent(in) :: text  !< value in the line
      real(wp), intent(out) :: factor  !< gal per count
      real(wp) :: full_scale, counts
      integer :: slash

      slash = index(text, '/')
      if (index(text, '(gal)/') == 0) call fail_at(reader, 'the scale factor '//quoted(text)// &
         " does not have the form 'number(gal)/number'")
      call read_first_number(reader, text(:slash - 1), 'scale factor', full_scale)
      call read_first_number(reader, text(slash + 1:), 'scale factor', counts)
      if (full_scale <= 0.0_wp .or. full_scale > largest .or. counts < 1.0_wp &
         .or. counts > largest) call fail_at(reader, 'the scale factor '//quoted(text)// &
         ' is not a positive number of gal per count')
      factor = full_scale/max(counts, 1.0_wp)
   end subroutine read_factor

end module dda_record_knet
