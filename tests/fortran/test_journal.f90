! SPDX-License-Identifier: GPL-3.0-or-later
!> Rows of a journal are read in their order, whether they wait in memory or are in the file.
module test_journal
   use dda_kinds, only: wp
   use dda_errors, only: error_type, error_file, fail
   use dda_file_system, only: remove_file
   use dda_journal, only: journal_type, open_journal, close_journal, flush_journal, begin_row, &
      append_numbers, reader_type, open_reader, read_row, read_numbers, journal_suffix, &
      row_sample, row_frame
   use dda_byte_file, only: close_file, size_of_file
   use testing, only: check, check_close, check_no_error
   implicit none

   character(len=*), parameter :: output = 'test_journal.nc'
   integer, parameter :: samples = 7, values = 3, frame_values = 5
   type(error_type), allocatable :: error

contains

   !> Flush before each row in turn, and also between the header and the values of a row.
   subroutine rows_in_order()
      integer :: flushed

      do flushed = 0, 2*samples + 2
         call write_and_read(flushed)
      end do
   end subroutine rows_in_order

   !> An earlier error retains the numbers that wait in memory.
   subroutine rows_after_an_error()
      type(journal_type) :: journal
      type(error_type), allocatable :: earlier

      call open_journal(journal, output, error)
      call append_sample(journal, 1, .false.)
      call fail(earlier, error_file, 'an earlier error')
      call flush_journal(journal, .false., earlier)
      call check_rows(journal, 1, 0)
      call remove(journal)
   end subroutine rows_after_an_error

   !> Write samples and a frame, with a flush after a number of parts of rows, and read them.
   subroutine write_and_read(flushed)
      integer, intent(in) :: flushed
      type(journal_type) :: journal
      integer :: i

      call open_journal(journal, output, error)
      call check_no_error(error, 'open')
      do i = 1, samples
         if (2*i - 2 == flushed) call flush_journal(journal, .false., error)
         call append_sample(journal, i, 2*i - 1 == flushed)
      end do
      if (2*samples == flushed) call flush_journal(journal, .false., error)
      call begin_row(journal, row_frame, 2, error)
      if (2*samples + 1 == flushed) call flush_journal(journal, .false., error)
      call append_numbers(journal, [(real(i, wp), i=1, frame_values)], frame_values, error)
      call check_no_error(error, 'append')
      if (flushed == 0) call check(size_of_file(journal%file) == 0, 'short journals stay in memory')
      call check_rows(journal, samples, 1)
      call remove(journal)
   end subroutine write_and_read

   subroutine append_sample(journal, i, flush_within)
      type(journal_type), intent(inout) :: journal
      integer, intent(in) :: i
      logical, intent(in) :: flush_within

      call begin_row(journal, row_sample, 0, error)
      if (flush_within) call flush_journal(journal, .false., error)
      call append_numbers(journal, sample(i), values, error)
   end subroutine append_sample

   pure function sample(i) result(numbers)
      integer, intent(in) :: i
      real(wp) :: numbers(values)

      numbers = [10.0_wp*i, 10.0_wp*i + 1.0_wp, 10.0_wp*i + 2.0_wp]
   end function sample

   !> Check all rows and the end; a second reader finds the same.
   subroutine check_rows(journal, n_samples, n_frames)
      type(journal_type), intent(in) :: journal
      integer, intent(in) :: n_samples, n_frames
      type(reader_type) :: reader
      real(wp) :: numbers(values), frame(frame_values)
      integer :: i, again, kind, contacts

      do again = 1, 2
         call open_reader(reader, journal, error)
         do i = 1, n_samples
            call read_row(reader, journal, kind, contacts, error)
            call check(kind == row_sample .and. contacts == 0, 'a sample')
            call read_numbers(reader, journal, numbers, error)
            call check_close(numbers, sample(i), 'its values', absolute=0.0_wp)
         end do
         do i = 1, n_frames
            call read_row(reader, journal, kind, contacts, error)
            call check(kind == row_frame .and. contacts == 2, 'a frame')
            call read_numbers(reader, journal, frame, error)
            call check_close(frame, [1.0_wp, 2.0_wp, 3.0_wp, 4.0_wp, 5.0_wp], 'its values', &
               absolute=0.0_wp)
         end do
         call read_row(reader, journal, kind, contacts, error)
         call check(kind == 0, 'the end')
         call check_no_error(error, 'read')
         call close_file(reader%file, error)
      end do
   end subroutine check_rows

   subroutine remove(journal)
      type(journal_type), intent(inout) :: journal

      call close_journal(journal, error)
      call remove_file(output//journal_suffix)
   end subroutine remove

end module test_journal
