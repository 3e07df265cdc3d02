! SPDX-License-Identifier: GPL-3.0-or-later
!> Memory that this process can still allocate; models that need more are rejected.
module dda_free_memory
   use, intrinsic :: iso_c_binding, only: c_int, c_long, c_size_t
   use, intrinsic :: iso_fortran_env, only: int8
   use dda_blas_buffers, only: missing_buffers, allocate_buffers
   use dda_errors, only: error_type, error_memory, fail
   use dda_kinds, only: wp, long
   use dda_text, only: short_text
   implicit none
   private
   public :: free_memory, require_memory, require_addresses, require_for_factor, require_for_blas, &
      fail_allocation
   public :: reserve_type, make_reserve

   !> RLIMIT_DATA and RLIMIT_AS on Linux: private pages, all addresses
   integer(c_int), parameter :: data_pages = 2, address_space = 9
   real(wp), parameter :: kibi = 1024.0_wp, giga = 1.0e9_wp
   real(wp), parameter :: unknown = huge(1.0_wp)/kibi  !< no known limit
   character(len=*), parameter :: own_status = '/proc/self/status', groups = '/sys/fs/cgroup'
   integer, parameter :: longest_line = 1024
   real(wp), parameter :: step_bytes = 3000.0_wp  !< bytes per block and step, measured
   real(wp), parameter :: worth_asking = 2.0_wp**23  !< smallest amount that is checked, bytes
   character(len=*), parameter :: advice_on_factors = "try solver = 'jacobi', which has no factor"
   character(len=*), parameter :: advice_on_limits = 'raise the limit of the process (ulimit -v)'

   !> memory of a LAPACK call without its buffer, bytes
   real(wp), parameter :: call_bytes = 2.0_wp**22

   !> Memory reserved for an operation that must not fail; it is deallocated before the operation.
   !> Pages of the reserve are never written to.
   type :: reserve_type
      integer(int8), allocatable :: bytes(:)
   end type reserve_type

   interface
      !> glibc: return unused pages to the system; 1 if there were any.
      integer(c_int) function malloc_trim(pad) bind(c, name='malloc_trim')
         import :: c_int, c_size_t
         integer(c_size_t), value :: pad  !< bytes to keep at the end
      end function malloc_trim

      !> POSIX: limits of this process on a resource, present and largest (bytes); −1 as a signed
      !> number: none.
      integer(c_int) function getrlimit(resource, limits) bind(c, name='getrlimit')
         import :: c_int, c_long
         integer(c_int), value :: resource  !< RLIMIT_…
         integer(c_long), intent(out) :: limits(2)  !< bytes: now, at most
      end function getrlimit
   end interface

contains

   !> Return an error if a given amount of memory is not free.
   subroutine require_memory(bytes, user, advice, error)
      real(wp), intent(in) :: bytes            !< bytes needed
      character(len=*), intent(in) :: user     !< user of the memory, for the message
      character(len=*), intent(in) :: advice   !< advice in the message
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      real(wp) :: free

      if (allocated(error)) return
      free = free_memory()
      if (bytes > free) call fail(error, error_memory, user//' needs '//short_text(bytes/giga)// &
         ' GB of memory, '//short_text(max(0.0_wp, free)/giga)//' GB are free'// &
         buffer_addresses_text()//'; '//advice)
   end subroutine require_memory

   !> Text on the address space for BLAS that a limit must permit in addition to the free memory.
   function buffer_addresses_text() result(text)
      character(len=:), allocatable :: text

      text = ''
      if (missing_buffers(1) > 0.0_wp .and. free_addresses() < unknown) text = ' besides '// &
         short_text(missing_buffers(1)/giga)//' GB of addresses for BLAS'
   end function buffer_addresses_text

   !> Return an error if a factor and the buffers of BLAS leave no memory for the steps; otherwise
   !> let BLAS allocate its buffers.  Unused pages are returned to the system before the test.
   subroutine require_for_factor(bytes, blocks, threads, user, error)
      real(wp), intent(in) :: bytes         !< bytes of the factor
      integer, intent(in) :: blocks         !< blocks of the matrix
      integer, intent(in) :: threads        !< threads that call BLAS at the same time
      character(len=*), intent(in) :: user  !< what needs the memory, for the message
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      character(len=*), parameter :: room = ', with room for the steps'
      real(wp) :: needed, buffers
      integer(c_int) :: unused

      buffers = missing_buffers(threads)
      if (allocated(error) .or. bytes + buffers <= worth_asking) return
      unused = malloc_trim(0_c_size_t)
      needed = bytes + blocks*step_bytes
      call require_memory(needed, user//room//',', advice_on_factors, error)
      if (allocated(error) .or. buffers <= 0.0_wp) return
      call require_addresses(needed + buffers, user//room//' and the buffers of BLAS,', &
         advice_on_factors, error)
      if (.not. allocated(error)) call allocate_buffers(threads)
   end subroutine require_for_factor

   !> Return an error if the buffer for a call of BLAS or LAPACK by one thread does not fit.
   subroutine require_for_blas(error)
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      if (allocated(error) .or. missing_buffers(1) <= 0.0_wp) return
      call require_addresses(missing_buffers(1) + call_bytes, 'a call of BLAS', advice_on_limits, &
         error)
      if (.not. allocated(error)) call allocate_buffers(1)
   end subroutine require_for_blas

   !> Return an error if the system refuses a reservation of address space, most of it never used.
   subroutine require_addresses(bytes, user, advice, error)
      real(wp), intent(in) :: bytes            !< bytes of addresses
      character(len=*), intent(in) :: user     !< user of the addresses, for the message
      character(len=*), intent(in) :: advice   !< advice in the message
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(reserve_type), volatile :: trial  ! prevents compilers from removing the unread array

      call make_reserve(trial, bytes, user, advice, error)
   end subroutine require_addresses

   !> Reserve memory, or return an error.
   subroutine make_reserve(reserve, bytes, user, advice, error)
      type(reserve_type), intent(inout) :: reserve  !< reserve; allocated unless it exists
      real(wp), intent(in) :: bytes            !< bytes to reserve
      character(len=*), intent(in) :: user     !< user of the memory, for the message
      character(len=*), intent(in) :: advice   !< advice in the message
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer :: status

      if (allocated(error) .or. allocated(reserve%bytes)) return
      allocate (reserve%bytes(int(bytes, long)), stat=status)
      if (status /= 0) call fail(error, error_memory, user//' needs '//short_text(bytes/giga)// &
         ' GB of memory, which the system refuses; '//advice)
   end subroutine make_reserve

   !> Return the error that the system has no memory for a factor.
   subroutine fail_allocation(bytes, user, error)
      real(wp), intent(in) :: bytes         !< bytes needed
      character(len=*), intent(in) :: user  !< user of the memory, for the message
      type(error_type), allocatable, intent(inout) :: error  !< error, allocated

      call fail(error, error_memory, user//' needs '//short_text(bytes/giga)// &
         ' GB of memory, which the system refuses; '//advice_on_factors)
   end subroutine fail_allocation

   !> Free memory, bytes: the least value by the system, the limits of the process and its control
   !> groups; huge if unknown.  A limit on addresses must also leave space for a buffer of BLAS.
   real(wp) function free_memory() result(bytes)
      bytes = min(kibi*number_after('/proc/meminfo', 'MemAvailable:', unknown), &
         free_in_groups(), free_addresses() - missing_buffers(1))
   end function free_memory

   !> Bytes that limits on addresses leave to this process.
   real(wp) function free_addresses() result(bytes)  ! total
      bytes = min(bytes_to_limit(data_pages, 'VmData:'), bytes_to_limit(address_space, 'VmSize:'))
   end function free_addresses

   !> Bytes that a limit of the process leaves.
   real(wp) function bytes_to_limit(resource, key) result(bytes)
      integer(c_int), intent(in) :: resource  !< RLIMIT_…
      character(len=*), intent(in) :: key !< name of the used amount in the status of a process
      integer(c_long) :: limits(2)

      bytes = unknown
      if (getrlimit(resource, limits) /= 0) return
      if (limits(1) < 0) return
      bytes = real(limits(1), wp) - kibi*number_after(own_status, key, 0.0_wp)
   end function bytes_to_limit

   !> Bytes that the control groups (version 2) leave to this process.
   !> Batch systems and containers set these limits.
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

   !> Number after a key at the start of a line.
   real(wp) function number_after(file, key, default) result(value)
      character(len=*), intent(in) :: file, key  !< path; key; '': the first line
      real(wp), intent(in) :: default          !< value if the line or file is missing
      character(len=:), allocatable :: text
      integer :: status

      text = text_after(file, key)
      read (text, *, iostat=status) value
      if (status /= 0) value = default
   end function number_after

   !> Text after a key at the start of a line of a file; blank if missing.
   function text_after(file, key) result(text)
      character(len=*), intent(in) :: file, key  !< path; key; '': the first line
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
