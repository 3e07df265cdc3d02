! SPDX-License-Identifier: GPL-3.0-or-later
!> Archives restore what was written, and detect data that do not match.
module test_archive
   use dda_archive, only: archive_type, serialise, serialise_count, serialise_label, &
      serialise_list, serialise_number, read_archive, write_archive
   use dda_checked_file, only: begin_reading, begin_writing, end_reading, end_writing
   use dda_kinds, only: wp, sp, long
   use record_files, only: remove_scratch, scratch_name
   use testing, only: case, check, error
   implicit none

   !> One of each kind.
   type :: state_type
      integer :: number = 0
      integer(long) :: large_value = 0
      real(wp) :: value = 0.0_wp
      logical :: flag = .false.
      character(len=:), allocatable :: text
      integer :: list(3) = 0
      real(wp) :: rows(2, 3) = 0.0_wp
      real(sp) :: singles(4) = 0.0_sp
      logical :: flags(2) = .false.
   end type state_type

contains

   subroutine carry_state(archive, state)
      type(archive_type), intent(inout) :: archive
      type(state_type), intent(inout) :: state

      call serialise_label(archive, 'state')
      call serialise(archive, state%number)
      call serialise(archive, state%large_value)
      call serialise(archive, state%value)
      call serialise(archive, state%flag)
      call serialise(archive, state%text)
      call serialise(archive, state%list)
      call serialise(archive, state%rows)
      call serialise(archive, state%rows(:, 2))
      call serialise(archive, state%singles)
      call serialise(archive, state%flags)
   end subroutine carry_state

   function full() result(state)
      type(state_type) :: state

      state%number = -7
      state%large_value = 2_long**60
      state%value = -0.0_wp
      state%flag = .true.
      state%text = 'größer'
      state%list = [3, 2, 1]
      state%rows = reshape([1.0_wp, huge(1.0_wp), tiny(1.0_wp)/8, 4.0_wp, 5.0_wp, 6.0_wp], [2, 3])
      state%singles = [1.0_sp, 2.0_sp, 3.0_sp, 4.0_sp]
      state%flags = [.true., .false.]
   end function full

   subroutine write_full(archive)
      type(archive_type), intent(out) :: archive
      type(state_type) :: state

      state = full()
      call write_archive(archive)
      call carry_state(archive, state)
   end subroutine write_full

   subroutine write_and_read()
      type(archive_type) :: archive, second
      type(state_type) :: state

      call write_full(archive)
      call read_archive(archive)
      state%text = ''
      call carry_state(archive, state)
      call check(.not. allocated(archive%failure), 'all is read')
      call check(state%text == 'größer' .and. state%flag .and. state%flags(1) &
         .and. .not. state%flags(2), 'text and flags')
      call write_archive(second)
      call carry_state(second, state)
      call check(second%at == archive%at, 'as many bytes are read as written')
      call check(all(second%bytes(:second%at) == archive%bytes(:archive%at)), 'the same bytes')
   end subroutine write_and_read

   !> A truncated archive is detected, and reading writes to no other memory.
   subroutine truncated_archives()
      type(archive_type) :: archive, truncated
      type(state_type) :: state
      integer :: length

      call write_full(archive)
      do length = 0, int(archive%at) - 1
         truncated%bytes = archive%bytes(:length)
         call read_archive(truncated)
         state%text = ''
         call carry_state(truncated, state)
         call check(allocated(truncated%failure), 'trouble is noted')
      end do
   end subroutine truncated_archives

   subroutine mismatched_sizes()
      type(archive_type) :: archive
      real(wp) :: four(4), five(5)

      four = 1.0_wp
      five = 2.0_wp
      call write_archive(archive)
      call serialise(archive, four)
      call read_archive(archive)
      call serialise(archive, five)
      call check(allocated(archive%failure), 'another size')
      call check(all(five == 2.0_wp), 'nothing is read')
      call write_archive(archive)
      call serialise_label(archive, 'blocks')
      call read_archive(archive)
      call serialise_label(archive, 'contacts')
      call check(index(archive%failure, 'contacts') > 0, 'the part that is missing is named')
   end subroutine mismatched_sizes

   subroutine limits()
      type(archive_type) :: archive
      integer :: list(3), count

      list = [1, 2, 9]
      count = 1000000
      call write_archive(archive)
      call serialise_list(archive, list, 1, 3)
      call check(.not. allocated(archive%failure), 'what is written is not judged')
      call read_archive(archive)
      call serialise_list(archive, list, 1, 3)
      call check(allocated(archive%failure), 'a list that points beyond its end')
      call write_archive(archive)
      call serialise_count(archive, count)
      archive%bytes = archive%bytes(:archive%at)
      call read_archive(archive)
      call serialise_count(archive, count)
      call check(allocated(archive%failure) .and. count == 0, 'more than there can be')
      call write_archive(archive)
      call serialise_number(archive, list(3), 1, 9)
      call read_archive(archive)
      call serialise_number(archive, list(3), 1, 8)
      call check(allocated(archive%failure) .and. list(3) == 1, 'a number out of range')
   end subroutine limits

   !> States that do not fit into the buffer, of sizes that end anywhere in it.
   subroutine through_a_file()
      integer, parameter :: sizes(4) = [0, 131072 - 1, 131072, 400001]  ! 131072 reals are a buffer
      type(archive_type) :: archive
      type(state_type) :: state
      real(wp), allocatable :: long_list(:), restored(:)
      integer :: i, j

      do i = 1, size(sizes)
         call case('through a file')
         long_list = [(real(j, wp), j=1, sizes(i))]
         state = full()
         call begin_writing(scratch_name, archive, error)
         call serialise(archive, long_list)
         call carry_state(archive, state)
         call serialise(archive, long_list)
         call end_writing(archive, .false., error)
         allocate (restored(sizes(i)))
         state%text = ''
         call begin_reading(scratch_name, archive, error)
         call serialise(archive, restored)
         call check(all(restored == long_list), 'what was written first')
         call carry_state(archive, state)
         restored = 0.0_wp
         call serialise(archive, restored)
         call check(all(restored == long_list) .and. state%text == 'größer', &
            'what was written last')
         call check(archive%at == archive%length, 'all of it')
         call serialise(archive, state%number)
         call check(allocated(archive%failure) .and. state%number == -7, 'nothing behind it')
         call end_reading(archive, error)
         call check(.not. allocated(error), 'no error')
         deallocate (restored)
      end do
      call remove_scratch()
   end subroutine through_a_file

end module test_archive
