! SPDX-License-Identifier: GPL-3.0-or-later
!> Journal: an append-only file, FILE.journal, with the samples and frames of a run so far.
!>
!> It contains the data of the output as rows of numbers in the order of the steps.  A checkpoint
!> stores the length and checksum of the journal; a resumed run truncates the journal to this length
!> and continues.  Only one run can open a journal at a time.
!>
!> The rows of the last second wait in memory, so that a short run neither writes nor reads its
!> journal.
module dda_journal
   use, intrinsic :: iso_c_binding, only: c_f_pointer, c_loc
   use, intrinsic :: iso_fortran_env, only: int8
   use dda_kinds, only: wp, long
   use dda_archive, only: archive_type, serialise, serialise_label
   use dda_byte_file, only: byte_file_type, open_file, open_again, to_append, lock_file, is_under, &
      write_bytes, read_bytes, go_to, cut_file, flush_stream, size_of_file, close_file
   use dda_checksum, only: checksum_type, begin_checksum, add_bytes
   use dda_errors, only: error_type, error_file, fail
   use dda_file_system, only: file_status_type, status_of
   use dda_large_pages, only: prefer_large_pages
   implicit none
   private
   public :: journal_type, open_journal, close_journal, keep_name, flush_journal, &
      extend_checksum, serialise_mark, return_to_mark, begin_row, append_numbers, journal_suffix
   public :: reader_type, open_reader, read_row, read_numbers, row_sample, row_frame

   integer, parameter :: row_sample = 1, row_frame = 2  !< kinds of rows
   character(len=*), parameter :: journal_suffix = '.journal'  !< of the name of an output
   integer, parameter :: bytes_of_number = storage_size(0.0_wp)/8  !< bytes of a number
   integer(long), parameter :: bytes_per_read = 1048576  !< bytes per read
   integer, parameter :: most_waiting = 4194304  !< numbers that wait in memory (32 MiB)
   integer, parameter :: few_waiting = 16384     !< the same if memory is lacking

   !> Journal with its length, checksum, and numbers of rows.
   type :: journal_type
      ! unsaved, opened again: file
      ! unsaved, equal to bytes in a checkpoint: summed
      ! unsaved, written before a checkpoint: waiting, n_waiting
      type(byte_file_type) :: file
      type(checksum_type) :: checksum   !< checksum of the bytes up to the last checkpoint
      integer(long) :: summed = 0       !< number of these bytes
      integer(long) :: bytes = 0
      integer :: samples = 0, frames = 0
      integer :: contacts = 0       !< number of contacts in all frames
      integer :: iterations = 0     !< largest number of iterations in a step since the last sample
      real(wp), allocatable :: waiting(:)  !< last numbers, not yet in the file
      integer :: n_waiting = 0      !< number of these numbers
   end type journal_type

   !> Reader of a journal, up to its length in `journal_type`.
   type :: reader_type
      type(byte_file_type) :: file
      integer(long) :: bytes_left = 0     !< remaining bytes of the file
      integer :: taken = 0                !< numbers read from memory
   end type reader_type

contains

   !> Open the journal of an output; return an error if another run has opened it.
   subroutine open_journal(journal, output, error)
      type(journal_type), target, intent(out) :: journal  !< journal, open and locked
      character(len=*), intent(in) :: output  !< path of the output
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      logical :: locked
      integer :: status

      call begin_checksum(journal%checksum)
      allocate (journal%waiting(most_waiting), stat=status)
      if (status /= 0) allocate (journal%waiting(few_waiting))
      call prefer_large_pages(c_loc(journal%waiting), bytes_of_number*size(journal%waiting, &
         kind=long))
      call open_file(journal%file, output//journal_suffix, to_append, error)
      if (allocated(error)) return
      locked = lock_file(journal%file)
      if (.not. locked) call fail(error, error_file, output//' is being written by another run')
      if (.not. locked) call close_journal(journal, error)
   end subroutine open_journal

   !> Close a journal; numbers that wait in memory are lost.
   subroutine close_journal(journal, error)
      type(journal_type), intent(inout) :: journal  !< journal of the run
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      call close_file(journal%file, error)
      if (allocated(journal%waiting)) deallocate (journal%waiting)
      journal%n_waiting = 0
   end subroutine close_journal

   !> If the journal was deleted during the run, restore it from the open file.
   !> Return an error if another file has its name.
   subroutine keep_name(journal, error)
      type(journal_type), intent(inout) :: journal  !< journal of the run
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(file_status_type) :: entry
      type(byte_file_type) :: old, restored
      logical :: locked

      if (allocated(error)) return
      associate (name => journal%file%name)
         if (is_under(journal%file, name)) return
         entry = status_of(name)
         if (entry%exists) call fail(error, error_file, name//' has been replaced during the '// &
            'run: another run may be writing the same output')
         if (allocated(error)) return
         call flush_journal(journal, .false., error)
         if (.not. allocated(error)) call open_again(old, journal%file, error)
         if (.not. allocated(error)) call open_file(restored, name, to_append, error)
         if (allocated(error)) then
            error%message = name//' has been removed during the run; '//error%message
            call close_file(old, error)
            return
         end if
      end associate
      locked = lock_file(restored)
      call copy_bytes(old, restored, journal%bytes, error)
      call close_file(old, error)
      call close_file(journal%file, error)
      journal%file = restored
   end subroutine keep_name

   !> Write the numbers that wait in memory, for a checkpoint or a fork.
   subroutine flush_journal(journal, to_disk, error)
      type(journal_type), intent(inout) :: journal  !< journal of the run
      logical, intent(in) :: to_disk   !< wait until the file is on disk
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      call write_waiting(journal, error)
      call flush_stream(journal%file, to_disk, error)
   end subroutine flush_journal

   !> Write the numbers that wait in memory to the file.
   subroutine write_waiting(journal, error)
      type(journal_type), intent(inout) :: journal  !< journal of the run
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      if (journal%n_waiting == 0 .or. allocated(error)) return
      call write_numbers(journal%file, journal%waiting, journal%n_waiting, error)
      journal%n_waiting = 0
   end subroutine write_waiting

   !> Write numbers to the file of a journal.
   subroutine write_numbers(file, numbers, count, error)
      type(byte_file_type), intent(in) :: file      !< open
      integer, intent(in) :: count                  !< number of values
      real(wp), target, intent(in) :: numbers(count)  !< values
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer(int8), pointer, contiguous :: bytes(:)

      call c_f_pointer(c_loc(numbers), bytes, [bytes_of_number*count])
      call write_bytes(file, bytes, error)
   end subroutine write_numbers

   !> Copy a number of bytes from the beginning of a file to another file.
   subroutine copy_bytes(from, to, bytes, error)
      type(byte_file_type), intent(in) :: from, to  !< open files, at their beginnings
      integer(long), intent(in) :: bytes            !< number of bytes
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer(int8), allocatable :: buffer(:)
      integer(long) :: remaining, n

      allocate (buffer(min(bytes_per_read, bytes)))
      remaining = bytes
      do while (remaining > 0 .and. .not. allocated(error))
         n = min(bytes_per_read, remaining)
         call read_bytes(from, buffer(:n), error)
         call write_bytes(to, buffer(:n), error)
         remaining = remaining - n
      end do
      call flush_stream(to, .false., error)
   end subroutine copy_bytes

   !> Extend the checksum to all bytes of the journal, which has been flushed, for a checkpoint.
   subroutine extend_checksum(journal, error)
      type(journal_type), intent(inout) :: journal  !< journal of the run
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(byte_file_type) :: file

      if (allocated(error)) return
      call open_again(file, journal%file, error)
      call go_to(file, journal%summed, error)
      call add_file(journal%checksum, file, journal%bytes - journal%summed, error)
      call close_file(file, error)
      journal%summed = journal%bytes
   end subroutine extend_checksum

   !> Add the next bytes of a file to a checksum.
   subroutine add_file(checksum, file, count, error)
      type(checksum_type), intent(inout) :: checksum  !< checksum of the bytes so far
      type(byte_file_type), intent(in) :: file        !< open
      integer(long), intent(in) :: count              !< number of bytes
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer(int8), allocatable :: buffer(:)
      integer(long) :: remaining, n

      allocate (buffer(min(bytes_per_read, count)))
      remaining = count
      do while (remaining > 0 .and. .not. allocated(error))
         n = min(bytes_per_read, remaining)
         call read_bytes(file, buffer(:n), error)
         call add_bytes(checksum, buffer(:n))
         remaining = remaining - n
      end do
   end subroutine add_file

   !> Save or restore length and checksum of the journal, as part of a checkpoint.
   subroutine serialise_mark(archive, journal)
      type(archive_type), intent(inout) :: archive  !< archive that is written or read
      type(journal_type), intent(inout) :: journal  !< journal of the run

      call serialise_label(archive, 'journal')
      call serialise(archive, journal%bytes)
      call serialise(archive, journal%checksum%value)
      call serialise(archive, journal%samples)
      call serialise(archive, journal%frames)
      call serialise(archive, journal%contacts)
      call serialise(archive, journal%iterations)
   end subroutine serialise_mark

   !> Truncate the journal to its state at a checkpoint; return an error if earlier bytes changed.
   subroutine return_to_mark(journal, error)
      type(journal_type), intent(inout) :: journal  !< journal of the run
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(byte_file_type) :: file
      type(checksum_type) :: checksum
      integer(long) :: file_length

      call open_again(file, journal%file, error)
      if (allocated(error)) return
      call begin_checksum(checksum)
      file_length = size_of_file(file)
      call add_file(checksum, file, min(journal%bytes, file_length), error)
      journal%summed = journal%bytes
      if (.not. allocated(error) .and. (file_length < journal%bytes .or. checksum%value &
         /= journal%checksum%value)) call fail(error, error_file, journal%file%name// &
         ' has changed since the checkpoint')
      call close_file(file, error)
      call cut_file(journal%file, journal%bytes, error)
   end subroutine return_to_mark

   !> Append the header of a sample or a frame; the caller then appends the values.
   subroutine begin_row(journal, kind, contacts, error)
      type(journal_type), intent(inout) :: journal  !< journal of the run
      integer, intent(in) :: kind, contacts  !< `row_sample` or `row_frame`; number of contacts
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      call append_numbers(journal, [real(wp) :: kind, contacts], 2, error)
      if (kind == row_frame) then
         journal%frames = journal%frames + 1
         journal%contacts = journal%contacts + contacts
      else
         journal%samples = journal%samples + 1
         journal%iterations = 0
      end if
   end subroutine begin_row

   !> Append numbers of a row.
   subroutine append_numbers(journal, numbers, count, error)
      type(journal_type), intent(inout) :: journal  !< journal of the run
      integer, intent(in) :: count  !< number of values
      real(wp), intent(in) :: numbers(count)  !< values
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      if (allocated(error)) return
      journal%bytes = journal%bytes + bytes_of_number*int(count, long)
      if (journal%n_waiting + count > size(journal%waiting)) call write_waiting(journal, error)
      if (count > size(journal%waiting)) then
         call write_numbers(journal%file, numbers, count, error)
      else
         journal%waiting(journal%n_waiting + 1:journal%n_waiting + count) = numbers
         journal%n_waiting = journal%n_waiting + count
      end if
   end subroutine append_numbers

   !> Open a journal for reading from its start.
   subroutine open_reader(reader, journal, error)
      type(reader_type), intent(out) :: reader  !< reader of the journal
      type(journal_type), intent(in) :: journal  !< journal of the run
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      call flush_stream(journal%file, .false., error)
      if (.not. allocated(error)) call open_again(reader%file, journal%file, error)
      reader%bytes_left = journal%bytes - bytes_of_number*int(journal%n_waiting, long)
   end subroutine open_reader

   !> Read the kind of the next row, 0 at the end, and its number of contacts.
   subroutine read_row(reader, journal, kind, contacts, error)
      type(reader_type), intent(inout) :: reader  !< reader of the journal
      type(journal_type), intent(in) :: journal  !< journal of the run
      integer, intent(out) :: kind, contacts  !< `row_sample` or `row_frame`; number of contacts
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      real(wp) :: head(2)

      kind = 0
      contacts = 0
      if (reader%bytes_left <= 0 .and. reader%taken >= journal%n_waiting) return
      call read_numbers(reader, journal, head, error)
      if (allocated(error)) return
      kind = nint(head(1))
      contacts = nint(head(2))
   end subroutine read_row

   !> Read the next numbers of a row, first from the file and then from memory.
   subroutine read_numbers(reader, journal, numbers, error)
      type(reader_type), intent(inout) :: reader  !< reader of the journal
      type(journal_type), intent(in) :: journal  !< journal of the run
      real(wp), contiguous, target, intent(out) :: numbers(:)  !< [numbers] numbers of a row
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer(int8), pointer, contiguous :: bytes(:)
      integer :: in_file, in_memory

      in_file = int(min(int(size(numbers), long), reader%bytes_left/bytes_of_number))
      if (in_file > 0) then
         call c_f_pointer(c_loc(numbers), bytes, [bytes_of_number*in_file])
         call read_bytes(reader%file, bytes, error)
         reader%bytes_left = reader%bytes_left - size(bytes)
      end if
      in_memory = size(numbers) - in_file
      numbers(in_file + 1:) = journal%waiting(reader%taken + 1:reader%taken + in_memory)
      reader%taken = reader%taken + in_memory
   end subroutine read_numbers

end module dda_journal
