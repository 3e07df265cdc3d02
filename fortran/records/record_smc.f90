! SPDX-License-Identifier: GPL-3.0-or-later
!> USGS SMC format: 11 lines of text, 48 integers, 50 reals, comments, samples.
!>
!> Reference: USGS National Strong-Motion Program, *SMC- and BBF-format Data Files* (smcfmt.txt),
!> sections 2–4.  Integer 16 is the number of comment lines, integer 17 the number of samples,
!> real 2 the sampling rate; accelerations are in cm/s².
module dda_record_smc
   use dda_kinds, only: wp, long
   use dda_text, only: to_text
   use dda_text_lines, only: line_reader_type, fail_at
   use dda_text_numbers, only: whole_number
   use dda_record_type, only: record_type, acceleration, velocity, displacement
   use dda_record_samples, only: sample_list_type, read_values, read_trace, read_quantity, &
      read_line, skip_comments, check_count, check_time_step
   implicit none
   private
   public :: read_smc

   integer, parameter :: text_lines = 11
   integer(long), parameter :: integers = 48, reals = 50
   integer, parameter :: integer_lines = 6, real_lines = 10
   integer, parameter :: comments_at = 16, samples_at = 17, rate_at = 2
   integer(long), parameter :: max_comments = 100000

contains

   !> Read the trace of an SMC file, in the unit of the file.
   subroutine read_smc(reader, record)
      type(line_reader_type), intent(inout) :: reader        !< reader at the start of the file
      type(record_type), intent(inout) :: record  !< record, filled from the file
      integer(long) :: comments, samples

      call read_titles(reader, record)
      call read_integers(reader, comments, samples)
      call read_rate(reader, record%time_step)
      call skip_comments(reader, comments, '|')
      call read_trace(reader, samples, 'samples', record%values)
   end subroutine read_smc

   !> Read the quantity from the first line, event and station from lines 4 and 6.
   subroutine read_titles(reader, record)
      type(line_reader_type), intent(inout) :: reader  !< reader of the file
      type(record_type), intent(inout) :: record  !< record, filled from the file
      character(len=:), allocatable :: text
      integer :: line

      do line = 1, text_lines
         call read_line(reader, text, 'the 11 text lines of an SMC header')
         if (line == 1) call read_quantity(reader, text, record%quantity)
         if (line == 4) record%description = trim(adjustl(text))
         if (line == 6) record%station = trim(adjustl(text))
      end do
      if (record%quantity == acceleration) record%unit = 'cm/s2'
      if (record%quantity == velocity) record%unit = 'cm/s'
      if (record%quantity == displacement) record%unit = 'cm'
   end subroutine read_titles

   !> Read the integers of the header: numbers of comment lines and samples.
   subroutine read_integers(reader, comments, samples)
      type(line_reader_type), intent(inout) :: reader  !< reader of the file
      integer(long), intent(out) :: comments, samples  !< number of comment lines, of samples
      type(sample_list_type) :: list

      comments = 0
      samples = 0
      call read_header(reader, integers, integer_lines, 'integers of an SMC header', list)
      if (allocated(reader%error)) return
      call check_count(reader, list%values(samples_at), samples)
      comments = whole_number(list%values(comments_at))
      if (comments < 0 .or. comments > max_comments) call fail_at(reader, &
         'the header declares '//to_text(list%values(comments_at))//' comment lines')
   end subroutine read_integers

   !> Read the reals of the header: the sampling rate.
   subroutine read_rate(reader, time_step)
      type(line_reader_type), intent(inout) :: reader  !< reader of the file
      real(wp), intent(out) :: time_step  !< Δt, s
      type(sample_list_type) :: list

      time_step = 0.0_wp
      call read_header(reader, reals, real_lines, 'reals of an SMC header', list)
      if (allocated(reader%error)) return
      ! An unevenly digitised record has the "undefined" value 1.7e38 as its rate.
      if (list%values(rate_at) <= 0.0_wp .or. list%values(rate_at) > 1.0e30_wp) then
         call fail_at(reader, 'the sampling rate '//to_text(list%values(rate_at))// &
            ' samples/s (real 2 of the header) is out of range, so the record is not evenly '// &
            'sampled')
         return
      end if
      time_step = 1.0_wp/list%values(rate_at)
      call check_time_step(reader, time_step)
   end subroutine read_rate

   !> Read header numbers, and check that they fill the number of lines of the format.
   subroutine read_header(reader, declared, lines, items, list)
      type(line_reader_type), intent(inout) :: reader  !< reader of the file
      integer(long), intent(in) :: declared  !< number declared by the header
      integer, intent(in) :: lines  !< lines according to the format
      character(len=*), intent(in) :: items  !< name of the counted items, for messages
      type(sample_list_type), intent(out) :: list  !< numbers read
      integer :: previous_line

      previous_line = reader%line
      call read_values(reader, declared, items, list)
      if (reader%line - previous_line /= lines) call fail_at(reader, 'the '//to_text(declared)// &
         ' '//items//' are on '//to_text(reader%line - previous_line)//' lines instead of '// &
         to_text(lines))
   end subroutine read_header

end module dda_record_smc
