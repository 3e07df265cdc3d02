! SPDX-License-Identifier: GPL-3.0-or-later
!> Changes of a model during a run: gravity, Δt, joints, loads, motions, fixed points.
!>
!> The values of a changed input replace the values of the run at the present time:
!>
!> - Bonds, closed contacts and their spring deformations are retained; new strengths apply.
!> - A point that is fixed again, or has another motion, retains its present position.
!> - A new Δt applies from the next step; the remaining time is rounded up to whole steps.
!> - The term `changed` of the energy budget contains the gain or loss of stored energy.
module dda_changes
   use dda_kinds, only: wp, long, pi
   use dda_added_stages, only: adopt_stages
   use dda_base_motion, only: renew_base
   use dda_blocks, only: blocks_type, position_of
   use dda_column_model, only: column_model
   use dda_columns, only: column_count, column_of
   use dda_damping, only: highest_relaxation
   use dda_elements, only: match_velocities, set_elements
   use dda_energy, only: energy_changed
   use dda_equilibrium, only: evaluate_present
   use dda_errors, only: error_type, error_input, fail
   use dda_friction, only: laws_type, set_laws
   use dda_model, only: model_type
   use dda_motion, only: motion_type, displacement_of
   use dda_simulation, only: simulation_type, next_step
   use dda_stage, only: never
   use dda_stages, only: update_budget
   use dda_support, only: fixed_point_type, load_type
   use dda_text, only: to_text
   implicit none
   private
   public :: change_now, adopt_values

contains

   !> Replace the changeable values of a run by the values of a model at the present time.
   recursive subroutine change_now(simulation, model, error)
      type(simulation_type), intent(inout) :: simulation  !< between two steps
      type(model_type), intent(in) :: model  !< model of the changed input
      type(error_type), allocatable, intent(out) :: error  !< set if fixed values differ
      type(fixed_point_type), allocatable :: points(:)
      type(motion_type), allocatable :: motions(:)
      real(wp) :: speed
      integer :: i

      call check_unchanged(simulation%model, simulation%blocks, model, error)
      if (.not. allocated(error)) call check_maxwell_steps(simulation, model, error)
      do i = 1, column_count(simulation)
         if (.not. allocated(error)) call change_now(column_of(simulation, i), &
            column_model(model, model%free_fields(i)), error)
      end do
      if (allocated(error)) return
      speed = simulation%speed
      call evaluate_present(simulation, error)
      simulation%speed = speed
      if (allocated(error)) return
      points = simulation%model%fixed_points
      motions = simulation%model%motions
      call adopt_values(simulation, model)
      call set_targets_here(simulation, points, motions)
      call set_time_step(simulation, model%control%time_step)
      call set_elements(simulation%elements, simulation%model, simulation%blocks, simulation%time)
      call match_velocities(simulation%elements, simulation%blocks, next_step(simulation))
      call update_budget(simulation, energy_changed, 1.0_wp)
      if (simulation%maxima%counting) call renew_base(simulation%maxima%base, simulation%model, &
         simulation%blocks, simulation%time)
   end subroutine change_now

   !> Check that the model differs in changeable values only.
   subroutine check_unchanged(run_model, blocks, model, error)
      type(model_type), intent(in) :: run_model, model  !< model of the run, of the changed input
      type(blocks_type), intent(in) :: blocks   !< blocks or model of the run
      type(error_type), allocatable, intent(out) :: error  !< set if other values differ
      logical :: unchanged
      integer :: i

      unchanged = blocks%n == model%blocks%n .and. size(run_model%joints) == size(model%joints) &
         .and. size(run_model%motions) == size(model%motions) .and. size(run_model%stages) == &
         size(model%stages) .and. size(run_model%fixed_points) <= size(model%fixed_points) &
         .and. size(run_model%free_fields) == size(model%free_fields) &
         .and. size(run_model%loads) <= size(model%loads)
      if (unchanged) unchanged = size(blocks%owner) == size(model%blocks%owner)
      if (unchanged) unchanged = all(blocks%reference == model%blocks%reference)
      if (unchanged) unchanged = all([(run_model%fixed_points(i)%block &
         == model%fixed_points(i)%block .and. &
         all(run_model%fixed_points(i)%reference == model%fixed_points(i)%reference), &
         i=1, size(run_model%fixed_points))])
      if (.not. unchanged) call fail(error, error_input, model%file//': a run cannot change '// &
         'its blocks or the numbers of joints, motions and stages; '// &
         'it cannot add fixed points to fixed edges')
   end subroutine check_unchanged

   !> Check that the fitted Maxwell branches are valid for the new Δt; they are not fitted again.
   subroutine check_maxwell_steps(simulation, model, error)
      type(simulation_type), intent(in) :: simulation  !< between two steps
      type(model_type), intent(in) :: model  !< model of the changed input
      type(error_type), allocatable, intent(inout) :: error  !< allocated on failure
      real(wp), parameter :: rounding = 1.0_wp + 1.0e-9_wp  !< factor that allows for rounding
      real(wp) :: limit
      integer :: m

      limit = highest_relaxation(simulation%scheme%theta, model%control%time_step)
      do m = 1, size(simulation%blocks%damping)
         associate (body => simulation%blocks%damping(m))
            if (any(body%omega(:body%n) > rounding*limit)) call fail(error, error_input, &
               model%file//': time_step = '//to_text(model%control%time_step)//' s is too long '// &
               'for the damping of a material, which has been fitted with mechanisms up to '// &
               to_text(maxval(body%omega(:body%n))/(2.0_wp*pi))//' Hz; start with this time_step')
         end associate
      end do
   end subroutine check_maxwell_steps

   !> Copy the changed values; blocks and supports removed by stages remain removed, and motions
   !> retain their start times.
   recursive subroutine adopt_values(simulation, model)
      type(simulation_type), intent(inout) :: simulation  !< between two steps
      type(model_type), intent(in) :: model  !< model of the changed input
      type(laws_type) :: laws
      real(wp) :: start
      integer :: m, i

      associate (run_model => simulation%model)
         run_model%control%gravity = model%control%gravity
         simulation%iteration%weight = norm2(model%control%gravity)*maxval(run_model%blocks%mass)
         run_model%joints = model%joints
         call set_laws(laws, model%joints, simulation%laws%normal_stiffness, &
            run_model%contact%shear_ratio)
         laws%augmented = simulation%laws%augmented
         laws%theta = simulation%laws%theta
         simulation%laws = laws
         do m = 1, size(run_model%motions)
            start = run_model%motions(m)%curve%start
            run_model%motions(m) = model%motions(m)
            run_model%motions(m)%curve%start = start
         end do
         call adopt_loads(run_model, model, simulation%blocks%removed)
         call adopt_points(run_model, model, simulation%blocks%removed, simulation%stage)
         call adopt_stages(run_model, model)
      end associate
      do i = 1, column_count(simulation)
         call adopt_values(column_of(simulation, i), column_model(model, model%free_fields(i)))
      end do
   end subroutine adopt_values

   !> Replace the loads, whose number may increase; existing loads retain their start times.
   subroutine adopt_loads(run_model, model, is_removed)
      type(model_type), intent(inout) :: run_model  !< blocks or model of the run
      type(model_type), intent(in) :: model   !< model of the changed input
      logical, intent(in) :: is_removed(:)       !< [blocks]
      type(load_type), allocatable :: loads(:)
      integer :: i, s, n_loads

      loads = model%loads
      n_loads = size(run_model%loads)
      do i = 1, size(loads)
         if (i <= n_loads) loads(i)%start = run_model%loads(i)%start
         if (is_removed(loads(i)%block)) loads(i)%start = never
      end do
      do s = 1, size(run_model%stages)
         run_model%stages(s)%loads = [run_model%stages(s)%loads, spread(.false., 1, size(loads) &
            - n_loads)]
      end do
      call move_alloc(loads, run_model%loads)
   end subroutine adopt_loads

   !> Replace the fixed points, whose number may increase; released points remain released.
   subroutine adopt_points(run_model, model, is_removed, stage)
      type(model_type), intent(inout) :: run_model  !< blocks or model of the run
      type(model_type), intent(in) :: model   !< model of the changed input
      logical, intent(in) :: is_removed(:)       !< [blocks]
      integer, intent(in) :: stage            !< present stage
      type(fixed_point_type), allocatable :: points(:)
      integer :: i, s, n_added

      points = model%fixed_points
      n_added = size(points) - size(run_model%fixed_points)
      do i = 1, size(run_model%fixed_points)
         points(i)%position = run_model%fixed_points(i)%position
      end do
      do s = 1, size(run_model%stages)
         associate (stages => run_model%stages)
            stages(s)%released = [stages(s)%released, spread(.false., 1, n_added)]
            stages(s)%holds = [stages(s)%holds, spread(.false., 1, n_added)]
            if (s > stage) cycle
            do i = 1, size(points)
               if (stages(s)%holds(i)) points(i)%fixed_along = points(i)%waiting
               if (stages(s)%released(i)) points(i)%fixed_along = .false.
            end do
         end associate
      end do
      do i = 1, size(points)
         if (is_removed(points(i)%block)) points(i)%fixed_along = .false.
      end do
      call move_alloc(points, run_model%fixed_points)
   end subroutine adopt_points

   !> Set the targets of fixed points to their positions, for points that are fixed again or have
   !> another motion.  Other targets do not change.
   subroutine set_targets_here(simulation, former_points, motions)
      type(simulation_type), intent(inout) :: simulation  !< between two steps
      type(fixed_point_type), intent(in) :: former_points(:)  !< points before the change
      type(motion_type), intent(in) :: motions(:)      !< motions before the change
      real(wp) :: position(2), prescribed(2, 2), coordinate
      integer :: i, axis

      associate (points => simulation%model%fixed_points, time => simulation%time)
         do i = 1, size(points)
            position = position_of(simulation%blocks, points(i)%block, points(i)%reference)
            points(i)%position = 0.0_wp
            prescribed(:, 2) = displacement_of(simulation%model%motions, points(i)%motion, time)
            if (i <= size(former_points)) prescribed(:, 1) = displacement_of(motions, &
               former_points(i)%motion, time)
            do axis = 1, 2
               associate (direction => points(i)%axes(:, axis))
                  coordinate = dot_product(direction, position)
                  if (i <= size(former_points)) then
                     if (former_points(i)%fixed_along(axis)) coordinate = dot_product(direction, &
                        former_points(i)%position) + prescribed(axis, 1)
                  end if
                  points(i)%position = points(i)%position + direction*(coordinate - &
                     prescribed(axis, 2))
               end associate
            end do
         end do
      end associate
   end subroutine set_targets_here

   !> Set another Δt for the next steps.
   subroutine set_time_step(simulation, time_step)
      type(simulation_type), intent(inout) :: simulation  !< between two steps
      real(wp), intent(in) :: time_step  !< Δt, s
      real(wp) :: remaining_time

      associate (control => simulation%model%control)
         if (time_step == control%time_step) return
         remaining_time = simulation%first_time + real(control%step_count, wp)*control%time_step &
            - simulation%time
         simulation%first_time = simulation%time
         simulation%first_step = simulation%step
         control%time_step = time_step
         control%step_count = max(0_long, ceiling(remaining_time/time_step - 1.0e-9_wp, long))
         simulation%time_step = time_step
      end associate
   end subroutine set_time_step

end module dda_changes
