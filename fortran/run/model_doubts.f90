! SPDX-License-Identifier: GPL-3.0-or-later
!> Warnings of the check of a model, for the verdict of its run.
!>
!> A check takes the time of about 100 steps and the memory of two models.  It is performed if the
!> model is small, or if it is of medium size and the run is long.
module dda_model_doubts
   use dda_kinds, only: long
   use dda_check_report, only: report_type, add_notes, verdict_ok
   use dda_check_simulation, only: check_model
   use dda_doubts, only: add_doubt, add_doubts
   use dda_errors, only: error_type
   use dda_interrupts, only: stop_requested
   use dda_joint_ends, only: bending_topic
   use dda_model, only: model_type, run_steps
   use dda_model_notes, only: model_notes
   use dda_simulation, only: simulation_type
   implicit none
   private
   public :: doubt_as_read, doubt_as_begun

   integer, parameter :: few_blocks = 200  !< largest model that is checked for every run
   integer, parameter :: many_blocks = 5000       !< largest model that is checked for long runs
   integer(long), parameter :: many_steps = 2500 !< steps of a long run: a check takes less than 5 %
   !> Least limit of open–close iterations in the search for equilibrium; the number of steps of the
   !> run, if larger.  Stable models need fewer; the search in a failing model costs at most its
   !> run.
   integer(long), parameter :: least_budget = 200

contains

   !> Add notes on probable mistakes in a model to the warnings of its run.
   subroutine doubt_as_read(simulation, model)
      type(simulation_type), intent(inout) :: simulation  !< run of the model
      type(model_type), intent(in) :: model               !< model as read from the input
      type(report_type), allocatable :: report

      allocate (report)
      call add_notes(report, model_notes(model))
      call add_lines(simulation, report)
   end subroutine doubt_as_read

   !> Add lines of the check that are not ok to the warnings of a run that begins.
   subroutine doubt_as_begun(simulation)
      type(simulation_type), intent(inout) :: simulation  !< simulation whose first stage has begun
      type(report_type), allocatable :: report
      type(error_type), allocatable :: error
      logical :: long

      long = run_steps(simulation%model) >= many_steps
      associate (n => simulation%blocks%n)
         if (n > many_blocks .or. (n > few_blocks .and. .not. long)) return
      end associate
      allocate (report)
      call check_model(simulation, report, error, &
         budget=max(least_budget, run_steps(simulation%model)))
      if (stop_requested()) return  ! the run reports the stop
      call add_lines(simulation, report)
      if (allocated(error)) call add_doubt(simulation%doubts, '', error%message, .true.)
   end subroutine doubt_as_begun

   !> Add the short text of each line that is not ok, except bending, which the end of the run
   !> reports.
   pure subroutine add_lines(simulation, report)
      type(simulation_type), intent(inout) :: simulation  !< warnings are added
      type(report_type), intent(in) :: report             !< report of the check
      integer :: i

      do i = 1, report%n
         associate (line => report%line(i))
            if (line%verdict == verdict_ok .or. line%brief%topic == bending_topic) cycle
            call add_doubts(simulation%doubts, [line%brief])
         end associate
      end do
   end subroutine add_lines

end module dda_model_doubts
