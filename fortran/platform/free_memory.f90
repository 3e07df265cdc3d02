! SPDX-License-Identifier: GPL-3.0-or-later
!> Memory that this process may still allocate, so that a model that is too large is refused.
module dda_free_memory
   use, intrinsic :: iso_c_binding, only: c_int, c_long
   use dda_errors, only: error_type, error_memory, fail
   use dda_kinds, only: wp
   use dda_text, only: short_text
   implicit none
   private
   public :: free_memory, require_memory, require_for_factor, fail_allocation

   !> RLIMIT_DATA and RLIMIT_AS on Linux: private pages, all addresses
   integer(c_int), parameter :: data_pages = 2, address_space = 9
   real(wp), parameter :: kibi = 1024.0_wp, giga = 1.0e9_wp
   real(wp), parameter :: unknown = huge(1.0_wp)/kibi  !< no limit that anything says
   character(len=*), parameter :: own_status = '/proc/self/status', groups = '/sys/fs/cgroup'
   integer, parameter :: longest_line = 1024
   real(wp), parameter :: step_bytes = 3000.0_wp  !< of a block, iterations and output, measured
   real(wp), parameter :: worth_asking = 2.0_wp**23  !< bytes; less is taken without a question
   character(len=*), parameter :: advice_on_factors = "try solver = 'jacobi', which makes none"

   interface
      !> POSIX: the limits of this process on a resource, now and at most (bytes); −1 as a signed
      !> number: none.
      integer(c_int) function getrlimit(resource, limits) bind(c, name='getrlimit')
         import :: c_int, c_long
         integer(c_int), value :: resource  !< RLIMIT_…
         integer(c_long), intent(out) :: limits(2)  !< bytes: now, at most
      end function getrlimit
   end interface

contains

   !> An error if that much memory is not free.
   subroutine require_memory(bytes, what, advice, error)
      real(wp), intent(in) :: bytes            !< needed
      character(len=*), intent(in) :: what     !< what needs it, for the message
      character(len=*), intent(in) :: advice   !< what to do
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      real(wp) :: free

      if (allocated(error)) return
      free = free_memory()
      if (bytes > free) call fail(error, error_memory, what//' needs '//short_text(bytes/giga)// &
         ' GB of memory, '//short_text(max(0.0_wp, free)/giga)//' GB are free; '//advice)
   end subroutine require_memory

   !> An error if a factor leaves no memory for the steps with it, which ask for none.
   subroutine require_for_factor(bytes, blocks, what, error)
      real(wp), intent(in) :: bytes         !< of the factor
      integer, intent(in) :: blocks         !< of the matrix
      character(len=*), intent(in) :: what  !< what needs it, for the message
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays

      if (bytes > worth_asking) call require_memory(bytes + blocks*step_bytes, &
         what//', with room for the steps,', advice_on_factors, error)
   end subroutine require_for_factor

   !> The error of a factor that the system has no memory for.
   subroutine fail_allocation(bytes, what, error)
      real(wp), intent(in) :: bytes         !< needed
      character(len=*), intent(in) :: what  !< what needs it, for the message
      type(error_type), allocatable, intent(inout) :: error  !< allocated

      call fail(error, error_memory, what//' needs '//short_text(bytes/giga)// &
         ' GB of memory, which the system does not give; '//advice_on_factors)
   end subroutine fail_allocation

   !> Bytes that the system, the limits of the process and of its control groups leave; huge where
   !> none of them says.
   real(wp) function free_memory() result(bytes)
      bytes = min(kibi*number_after('/proc/meminfo', 'MemAvailable:', unknown), &
         free_in_groups(), below_limit(data_pages, 'VmData:'), &
         below_limit(address_space, 'VmSize:'))
   end function free_memory

   !> Bytes that a limit of the process leaves.
   real(wp) function below_limit(resource, taken) result(bytes)
      integer(c_int), intent(in) :: resource  !< RLIMIT_…
      character(len=*), intent(in) :: taken   !< what it counts, as the status of a process has it
      integer(c_long) :: limits(2)

      bytes = unknown
      if (getrlimit(resource, limits) /= 0 .or. limits(1) < 0) return
      bytes = real(limits(1), wp) - kibi*number_after(own_status, taken, 0.0_wp)
   end function below_limit

   !> Bytes that the control groups of this process (version 2) leave, as batch systems and
   !> containers set them.
   real(wp) function free_in_groups() result(bytes)
      character(len=:), allocatable :: folder
      real(wp) :: limit
      integer :: slash

      limit = unknown
      folder = text_after('/proc/self/cgroup', '0::')
      do
         limit = min(limit, number_after(groups//folder//'/memory.max', '', unknown))
         slash = index(folder, '/', back=.true.)
         if (slash == 0) exit
         folder = folder(:slash - 1)
      end do
      bytes = limit - kibi*number_after(own_status, 'VmRSS:', 0.0_wp)
   end function free_in_groups

   !> The number behind a key at the beginning of a line.
   real(wp) function number_after(file, key, otherwise) result(value)
      character(len=*), intent(in) :: file, key  !< path; '': the first line
      real(wp), intent(in) :: otherwise          !< where there is none, or no such file
      character(len=:), allocatable :: text
      integer :: status

      text = text_after(file, key)
      read (text, *, iostat=status) value
      if (status /= 0) value = otherwise
   end function number_after

   !> What stands behind a key at the beginning of a line of a file; blank where there is none.
   function text_after(file, key) result(text)
      character(len=*), intent(in) :: file, key  !< path; '': the first line
      character(len=:), allocatable :: text
      character(len=longest_line) :: line
      integer :: unit, status

      text = ''
      open (newunit=unit, file=file, status='old', action='read', iostat=status)
      if (status /= 0) return
      do
         read (unit, '(a)', iostat=status) line
         if (status /= 0) exit
         if (index(line, key) /= 1) cycle
         text = trim(adjustl(line(len(key) + 1:)))
         exit
      end do
      close (unit, iostat=status)
   end function text_after

end module dda_free_memory
