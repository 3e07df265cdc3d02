! SPDX-License-Identifier: GPL-3.0-or-later
!> Interface for programs in Fortran: an input, its check, its run step by step, its histories.
!>
!> A program needs only the procedures of this module; other modules may change from version to
!> version.  An error is returned as a value, and the program continues: it may run another
!> analysis. Several analyses may be open at once, in one thread.
module sitedda
   use dda_kinds, only: wp, long
   use dda_check_report, only: report_type, report_text, add_notes, verdict_fail
   use dda_check_simulation, only: check_simulation
   use dda_errors, only: error_type, error_input, error_check, error_convergence, error_solver, &
      error_file, error_interrupted, error_memory, error_checkpoint, exit_status, fail
   use dda_input, only: read_model_file
   use dda_measure, only: measure_point
   use dda_model, only: model_type
   use dda_model_notes, only: add_notes_to_error, model_notes
   use dda_settings, only: name_output
   use dda_output_reader, only: read_output => read_history
   use dda_run, only: run_type, begin_run, resume_run, continue_run, end_run, is_done
   use dda_simulation, only: simulation_type
   use dda_stages, only: begin_simulation
   use dda_text, only: joined, quoted
   use dda_version, only: version
   implicit none
   private
   public :: wp, error_type, exit_status, version
   public :: error_input, error_check, error_convergence, error_solver, error_file, &
      error_interrupted, error_memory, error_checkpoint
   public :: analysis_type, read_input, check_input, begin_analysis, advance_analysis, &
      end_analysis, is_complete, present_time, point_motion, read_history

   character(len=*), parameter :: axes = 'xy'

   !> An input and, once started, its run.
   type :: analysis_type
      private
      type(model_type), allocatable :: model
      type(run_type), allocatable :: run
   end type analysis_type

contains

   !> Read an input file; an open analysis is discarded.
   subroutine read_input(analysis, file, error, changes)
      type(analysis_type), intent(out) :: analysis  !< analysis, ready to be checked or begun
      character(len=*), intent(in) :: file          !< path of the namelist file
      type(error_type), allocatable, intent(out) :: error  !< error with file, group, line and value
      !> variables to change, as 'joint[bedding].friction_angle=30'
      character(len=*), intent(in), optional :: changes(:)

      allocate (analysis%model)
      call read_model_file(analysis%model, file, error, changes)
      if (allocated(error)) deallocate (analysis%model)
   end subroutine read_input

   !> Check a run before it begins: damping, resolution, ringing, cost.
   subroutine check_input(analysis, report, passes, error)
      type(analysis_type), intent(in) :: analysis  !< analysis whose input has been read
      character(len=:), allocatable, intent(out) :: report  !< text of the report
      logical, intent(out) :: passes               !< the report has no failure
      type(error_type), allocatable, intent(out) :: error  !< the check could not be performed
      type(simulation_type), allocatable :: simulation
      type(report_type), allocatable :: result

      report = ''
      passes = .false.
      call require_that(allocated(analysis%model), 'no input has been read', error)
      if (allocated(error)) return
      allocate (simulation, result)
      call add_notes(result, model_notes(analysis%model))
      call begin_simulation(simulation, analysis%model, error)
      if (.not. allocated(error)) call check_simulation(simulation, result, error)
      call add_notes_to_error(error, model_notes(analysis%model))
      if (allocated(error)) return
      report = report_text(result)
      passes = result%worst_verdict /= verdict_fail
   end subroutine check_input

   !> Begin the run of the input, or continue a run that ended early.
   subroutine begin_analysis(analysis, error, output, resume)
      type(analysis_type), intent(inout) :: analysis  !< analysis whose input has been read
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      !> path of the output, which replaces the path in the input; blank: no output is written
      character(len=*), intent(in), optional :: output
      logical, intent(in), optional :: resume  !< continue from the last checkpoint, if any
      logical :: writes, from_checkpoint

      call require_that(allocated(analysis%model), 'no input has been read', error)
      if (allocated(error)) return
      writes = .true.
      if (present(output)) then
         writes = output /= ''
         if (writes) call name_output(analysis%model%output, output)
      end if
      from_checkpoint = .false.
      if (present(resume)) from_checkpoint = resume
      if (allocated(analysis%run)) deallocate (analysis%run)
      allocate (analysis%run)
      if (from_checkpoint) then
         call resume_run(analysis%run, analysis%model, error)
      else
         call begin_run(analysis%run, analysis%model, writes, error)
      end if
      if (allocated(error)) deallocate (analysis%run)
   end subroutine begin_analysis

   !> Advance by a number of steps, or until the run is complete.
   subroutine advance_analysis(analysis, steps, error)
      type(analysis_type), intent(inout) :: analysis  !< analysis that has begun
      integer, intent(in) :: steps                    !< number of steps
      type(error_type), allocatable, intent(out) :: error  !< error with step, contact and blocks

      call require_that(allocated(analysis%run), 'the analysis has not begun', error)
      if (.not. allocated(error)) call continue_run(analysis%run, int(steps, long), error)
   end subroutine advance_analysis

   !> Write the output; an incomplete run is written as FILE.partial, with a checkpoint.
   subroutine end_analysis(analysis, error)
      type(analysis_type), intent(inout) :: analysis  !< analysis; it can begin again from its input
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure

      call require_that(allocated(analysis%run), 'the analysis has not begun', error)
      if (allocated(error)) return
      call end_run(analysis%run, error)
      deallocate (analysis%run)
   end subroutine end_analysis

   !> .true. if the run has reached its duration, or a rule of &stop has ended it.
   pure logical function is_complete(analysis)
      type(analysis_type), intent(in) :: analysis  !< analysis in any state

      is_complete = .false.
      if (allocated(analysis%run)) is_complete = is_done(analysis%run)
   end function is_complete

   !> Present time of the run, s.
   pure real(wp) function present_time(analysis)
      type(analysis_type), intent(in) :: analysis  !< analysis in any state

      present_time = 0.0_wp
      if (allocated(analysis%run)) present_time = analysis%run%simulation%time
   end function present_time

   !> Present motion of a measured point.
   subroutine point_motion(analysis, name, displacement, velocity, acceleration, error)
      type(analysis_type), intent(in) :: analysis  !< analysis that has begun
      character(len=*), intent(in) :: name         !< name of the point
      real(wp), intent(out) :: displacement(2)     !< displacement since the start, m
      real(wp), intent(out) :: velocity(2)         !< m/s
      real(wp), intent(out) :: acceleration(2)     !< m/s²
      type(error_type), allocatable, intent(out) :: error  !< the point is unknown
      integer :: point

      displacement = 0.0_wp
      velocity = 0.0_wp
      acceleration = 0.0_wp
      call require_that(allocated(analysis%run), 'the analysis has not begun', error)
      if (.not. allocated(error)) call find_point(analysis%model, name, point, error)
      if (allocated(error)) return
      associate (simulation => analysis%run%simulation)
         call measure_point(simulation%blocks, simulation%model%points(point), displacement, &
            velocity, acceleration)
      end associate
   end subroutine point_motion

   !> Read a history from the output of an analysis that has ended.
   subroutine read_history(analysis, quantity, time, values, error, point, axis)
      type(analysis_type), intent(in) :: analysis  !< analysis whose output is complete
      !> name in the output: displacement, velocity, acceleration; energy_kinetic …
      character(len=*), intent(in) :: quantity
      real(wp), allocatable, intent(out) :: time(:)    !< [samples] s
      real(wp), allocatable, intent(out) :: values(:)  !< [samples] values in SI units
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      character(len=*), intent(in), optional :: point  !< measured point; requires an axis
      character, intent(in), optional :: axis          !< 'x' or 'y'
      integer, allocatable :: at(:)
      integer :: number

      at = [integer ::]
      number = 0
      call require_that(allocated(analysis%model), 'no input has been read', error)
      if (.not. allocated(error)) call require_that(present(point) .eqv. present(axis), &
         'a point also needs an axis', error)
      if (.not. allocated(error) .and. present(axis)) then
         call require_that(index(axes, axis) > 0, quoted(axis)//" is not an axis: use 'x', 'y'", &
            error)
         if (.not. allocated(error)) call find_point(analysis%model, point, number, error)
         at = [index(axes, axis), number]
      end if
      if (.not. allocated(error)) call read_output(analysis%model%output%file, quantity, at, &
         time, values, error)
   end subroutine read_history

   !> Number of a measured point.
   subroutine find_point(model, name, point, error)
      type(model_type), intent(in) :: model  !< model as read from the input
      character(len=*), intent(in) :: name   !< name of the point
      integer, intent(out) :: point          !< number, from 1
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      point = findloc(model%points%name == name, .true., 1)
      call require_that(point > 0, model%file//': there is no measured point '//quoted(name)// &
         '; there are '//joined(model%points%name, ', '), error)
   end subroutine find_point

   !> Return an error unless a condition is true.
   subroutine require_that(condition, message, error)
      logical, intent(in) :: condition
      character(len=*), intent(in) :: message  !< message of the error
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      if (.not. (condition .or. allocated(error))) call fail(error, error_input, message)
   end subroutine require_that

end module sitedda
