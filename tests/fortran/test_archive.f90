!> Archives give back what was put in, and notice what does not fit.
module test_archive
   use dda_archive, only: archive_type, carry, carry_count, carry_label, carry_list, carry_number, read_archive, write_archive
   use dda_kinds, only: wp, sp, long
   use testing, only: case, check
   implicit none
   private
   public :: archive_suite

   !> One of each kind.
   type :: state_type
      integer :: number = 0
      integer(long) :: large = 0
      real(wp) :: value = 0.0_wp
      logical :: flag = .false.
      character(len=:), allocatable :: text
      integer :: list(3) = 0
      real(wp) :: rows(2, 3) = 0.0_wp
      real(sp) :: singles(4) = 0.0_sp
      logical :: flags(2) = .false.
   end type state_type

contains

   subroutine archive_suite()
      call there_and_back()
      call cut_short()
      call misfits()
      call limits()
   end subroutine archive_suite

   subroutine carry_state(archive, state)
      type(archive_type), intent(inout) :: archive
      type(state_type), intent(inout) :: state

      call carry_label(archive, 'state')
      call carry(archive, state%number)
      call carry(archive, state%large)
      call carry(archive, state%value)
      call carry(archive, state%flag)
      call carry(archive, state%text)
      call carry(archive, state%list)
      call carry(archive, state%rows)
      call carry(archive, state%rows(:, 2))
      call carry(archive, state%singles)
      call carry(archive, state%flags)
   end subroutine carry_state

   function full() result(state)
      type(state_type) :: state

      state%number = -7
      state%large = 2_long**60
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

   subroutine there_and_back()
      type(archive_type) :: archive, again
      type(state_type) :: state

      call case('there and back')
      call write_full(archive)
      call read_archive(archive)
      state%text = ''
      call carry_state(archive, state)
      call check(.not. allocated(archive%trouble), 'all is read')
      call check(state%text == 'größer' .and. state%flag .and. state%flags(1) .and. .not. state%flags(2), 'text and flags')
      call write_archive(again)
      call carry_state(again, state)
      call check(again%at == archive%at, 'as many bytes')
      call check(all(again%bytes(:again%at) == archive%bytes(:archive%at)), 'the same bytes')
   end subroutine there_and_back

   !> Whatever is missing at the end is noticed, and what is read goes nowhere else.
   subroutine cut_short()
      type(archive_type) :: archive, part
      type(state_type) :: state
      integer :: length

      call case('cut short')
      call write_full(archive)
      do length = 0, int(archive%at) - 1
         part%bytes = archive%bytes(:length)
         call read_archive(part)
         state%text = ''
         call carry_state(part, state)
         call check(allocated(part%trouble), 'trouble is noted')
      end do
   end subroutine cut_short

   subroutine misfits()
      type(archive_type) :: archive
      real(wp) :: four(4), five(5)

      call case('misfits')
      four = 1.0_wp
      five = 2.0_wp
      call write_archive(archive)
      call carry(archive, four)
      call read_archive(archive)
      call carry(archive, five)
      call check(allocated(archive%trouble), 'another size')
      call check(all(five == 2.0_wp), 'nothing is read')
      call write_archive(archive)
      call carry_label(archive, 'blocks')
      call read_archive(archive)
      call carry_label(archive, 'contacts')
      call check(index(archive%trouble, 'contacts') > 0, 'the part that is missing is named')
   end subroutine misfits

   subroutine limits()
      type(archive_type) :: archive
      integer :: list(3), count

      call case('limits')
      list = [1, 2, 9]
      count = 1000000
      call write_archive(archive)
      call carry_list(archive, list, 1, 3)
      call check(.not. allocated(archive%trouble), 'what is written is not judged')
      call read_archive(archive)
      call carry_list(archive, list, 1, 3)
      call check(allocated(archive%trouble), 'a list that points beyond its end')
      call write_archive(archive)
      call carry_count(archive, count)
      archive%bytes = archive%bytes(:archive%at)
      call read_archive(archive)
      call carry_count(archive, count)
      call check(allocated(archive%trouble) .and. count == 0, 'more than there can be')
      call write_archive(archive)
      call carry_number(archive, list(3), 1, 9)
      call read_archive(archive)
      call carry_number(archive, list(3), 1, 8)
      call check(allocated(archive%trouble) .and. list(3) == 1, 'a number out of range')
   end subroutine limits

end module test_archive
