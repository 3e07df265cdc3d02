! SPDX-License-Identifier: GPL-3.0-or-later
!> Requests to stop, by signals that the executable watches or by the host program of the engine.
!>
!> Long loops poll `stop_requested` and end with an error.  The present step is completed before the
!> end, so that a checkpoint can be written; it is abandoned if it takes longer than `patience`.
!> The engine watches no signals unless `watch_interrupts` is called.
module dda_interrupts
   use, intrinsic :: iso_c_binding, only: c_funloc, c_funptr, c_int, c_intptr_t
   !$ use omp_lib, only: omp_get_thread_num
   use dda_errors, only: error_type, error_interrupted, fail
   use dda_kinds, only: wp, long
   implicit none
   private
   public :: watch_interrupts, register_host, request_stop, stop_requested, stop_was_requested, &
      stop_within_step, fail_if_stopped, fail_within_step

   !> SIGINT, SIGUSR1, SIGTERM, SIGXFSZ of Linux
   integer(c_int), parameter :: interrupt = 2_c_int, user = 10_c_int, terminate = 15_c_int, &
      file_size = 25_c_int
   integer(c_intptr_t), parameter :: ignored = 1_c_intptr_t   !< SIG_IGN
   real(wp), parameter :: patience = 0.3_wp  !< processor time after which a step is abandoned, s
   real(wp), parameter :: call_interval = 0.05_wp  !< time between two calls of the host, s

   !> Messages to the working thread.
   type :: request_type
      integer(c_int) :: signal = 0      !< signal that requested this thread to stop; 0: none
      logical :: host = .false.         !< the host requests a stop
      integer(long) :: last_poll = 0        !< clock count of the last call of the host
      real(wp) :: since = -1.0_wp       !< processor time when a step first noticed the request, s
   end type request_type

   integer(c_int), volatile :: last_signal = 0   !< last signal that the process has received
   type(request_type) :: request
   !$omp threadprivate(request)
   procedure(host_type), pointer :: host => null()

   abstract interface
      !> Host function: nonzero if the calling thread is requested to stop.
      integer(c_int) function host_type() bind(c)
         import :: c_int
      end function host_type
   end interface

   interface
      !> C library: set the handler of a signal.
      type(c_funptr) function c_signal(number, handler) bind(c, name='signal')
         import :: c_funptr, c_int
         integer(c_int), value :: number  !< number of the signal
         type(c_funptr), value :: handler  !< SIG_IGN or a procedure
      end function c_signal
   end interface

contains

   !> Begin to watch signals, which then only set a flag.
   !> A write beyond a file size limit then returns an error instead of ending the process.
   subroutine watch_interrupts()
      type(c_funptr) :: former_handler, ignore

      ignore = transfer(ignored, ignore)
      former_handler = c_signal(interrupt, c_funloc(record_signal))
      former_handler = c_signal(user, c_funloc(record_signal))
      former_handler = c_signal(terminate, c_funloc(record_signal))
      former_handler = c_signal(file_size, ignore)
   end subroutine watch_interrupts

   !> Handle a signal by recording it.
   subroutine record_signal(number) bind(c)
      integer(c_int), value :: number  !< number of the signal

      last_signal = number
   end subroutine record_signal

   !> Register the host function, which is polled from now on.
   subroutine register_host(question)
      procedure(host_type) :: question  !< function of the host

      host => question
   end subroutine register_host

   !> Request this thread to stop; 0 withdraws the request.
   subroutine request_stop(number)
      integer(c_int), intent(in) :: number  !< number of the signal that ends the step

      request%signal = number
   end subroutine request_stop

   !> .true. if a signal has arrived, or the host requests this thread to stop.  In a team only the
   !> thread that called the engine polls the host: it may own a lock of the host, for which other
   !> threads would wait endlessly.
   logical function stop_requested()  ! total
      logical :: may_ask

      stop_requested = last_signal /= 0 .or. request%signal /= 0
      may_ask = associated(host)
      !$ may_ask = may_ask .and. omp_get_thread_num() == 0
      if (stop_requested .or. .not. may_ask) return
      call poll_host
      stop_requested = request%host .or. request%signal /= 0
   end function stop_requested

   !> .true. if a stop has been requested, without a new call of the host.
   logical function stop_was_requested()  ! total
      stop_was_requested = last_signal /= 0 .or. request%signal /= 0 .or. request%host
   end function stop_was_requested

   !> Poll the host, unless it was polled recently without a request.
   subroutine poll_host()
      integer(long) :: time, rate

      call system_clock(time, rate)
      if (.not. request%host .and. abs(time - request%last_poll) < call_interval*rate) return
      request%last_poll = time
      request%host = host() /= 0
   end subroutine poll_host

   !> .true. if the present step must be abandoned.  SIGUSR1, which batch systems send some time
   !> before the end of a job, does not abandon a step.
   logical function stop_within_step() result(now)
      real(wp) :: seconds

      now = stop_requested()
      if (.not. now) then
         request%since = -1.0_wp
         return
      end if
      now = .false.
      if (max(last_signal, request%signal) == user) return
      call cpu_time(seconds)
      if (request%since < 0.0_wp) request%since = seconds
      now = seconds - request%since >= patience
   end function stop_within_step

   !> Return an error if a stop is requested.
   subroutine fail_if_stopped(error)
      type(error_type), allocatable, intent(inout) :: error  !< error of the ended operation

      if (stop_requested()) call fail(error, error_interrupted, 'interrupted')
   end subroutine fail_if_stopped

   !> Return the error of an abandoned step.
   subroutine fail_within_step(error)
      type(error_type), allocatable, intent(out) :: error  !< allocated

      call fail(error, error_interrupted, 'interrupted within a step that takes too long '// &
         'to complete; resume continues from the last checkpoint')
   end subroutine fail_within_step

end module dda_interrupts
