! SPDX-License-Identifier: GPL-3.0-or-later
!> Largest values of a run, updated in each step.
!>
!> Counting begins with the first frame of the output, in static equilibrium if the first stage is
!> static.  Every dynamic step counts.  Of a later static stage, only the end counts, without
!> velocities and accelerations, because static steps are not a motion in time.
module dda_running_maxima
   use dda_kinds, only: wp
   use dda_base_motion, only: begin_base, update_base
   use dda_blocks, only: position_of
   use dda_elements, only: plastic_strain
   use dda_first_contacts, only: begin_first_contacts, reserve_first_contacts, add_movement, &
      may_exceed, drop_removed, count_moved
   use dda_maxima, only: largest_type, number_of_maxima, update_largest, add_blocks, add_contacts, &
      of_plastic_strain, of_point_displacement, of_point_velocity, of_point_acceleration, &
      of_point_drift
   use dda_measure, only: measure_point
   use dda_model, only: half_size
   use dda_scheme, only: step_type
   use dda_simulation, only: simulation_type, finished
   implicit none
   private
   public :: begin_maxima, reserve_maxima, count_step, count_stage, restart_points, &
      collect_residuals, min_movement

   real(wp), parameter :: min_movement_ratio = 1.0e-5_wp  !< smallest reported movement/model size

   real(wp), parameter :: min_recorded_ratio = 1.0e-7_wp  !< slip/model size recorded at once

contains

   !> Smallest contact movement that is reported, m.
   pure real(wp) function min_movement(simulation)
      type(simulation_type), intent(in) :: simulation  !< a run and its state

      min_movement = min_movement_ratio*2*half_size(simulation%model%blocks)
   end function min_movement

   !> Begin the maxima with the present state.
   subroutine begin_maxima(simulation)
      type(simulation_type), intent(inout) :: simulation  !< between two steps

      call reserve_maxima(simulation, 0)
      associate (maxima => simulation%maxima, contacts => simulation%contacts(simulation%now))
         call begin_first_contacts(maxima%contacts, contacts, simulation%blocks, &
            min_movement(simulation))
         maxima%first = simulation%blocks%position(1:3, :)
      end associate
      call count_state(simulation, .true., .true.)
   end subroutine begin_maxima

   !> Allocate the counters for a number of initial contacts.
   subroutine reserve_maxima(simulation, contacts)
      type(simulation_type), intent(inout) :: simulation  !< started
      integer, intent(in) :: contacts  !< number of contacts whose slip is measured
      type(largest_type) :: none
      integer :: i

      associate (maxima => simulation%maxima, blocks => simulation%blocks, &
         points => simulation%model%points)
         maxima%counting = .true.
         maxima%largest = none
         maxima%points_from = 0.0_wp
         if (allocated(maxima%first)) deallocate (maxima%first, maxima%size_of, maxima%below)
         allocate (maxima%first(3, blocks%n), source=0.0_wp)
         allocate (maxima%size_of, source=sqrt(blocks%whole_area))
         maxima%least_size = minval(maxima%size_of)
         allocate (maxima%below(size(points)))
         do i = 1, size(points)
            maxima%below(i) = point_below(simulation, i)
         end do
         call begin_base(maxima%base, simulation%model, blocks, simulation%time)
         call reserve_first_contacts(maxima%contacts, contacts, size(blocks%owner))
      end associate
   end subroutine reserve_maxima

   !> Find the nearest measured point below point i, initially within 45° of the vertical; 0: none.
   pure integer function point_below(simulation, i) result(lower_point)
      type(simulation_type), intent(in) :: simulation  !< a run and its state
      integer, intent(in) :: i                         !< measured point
      real(wp) :: offset(2), nearest_distance
      integer :: k

      lower_point = 0
      nearest_distance = huge(1.0_wp)
      do k = 1, size(simulation%model%points)
         offset = reference_position(simulation, i) - reference_position(simulation, k)
         if (offset(2) <= 0.0_wp .or. offset(2) < abs(offset(1)) .or. norm2(offset) &
            >= nearest_distance) cycle
         nearest_distance = norm2(offset)
         lower_point = k
      end do
   end function point_below

   !> Position of a measured point in the reference shape of its block, m.
   pure function reference_position(simulation, i) result(position)
      type(simulation_type), intent(in) :: simulation  !< a run and its state
      integer, intent(in) :: i                         !< measured point
      real(wp) :: position(2)

      associate (point => simulation%model%points(i))
         position = simulation%model%blocks%position(1:2, point%block) + point%reference
      end associate
   end function reference_position

   !> Update the largest values after a dynamic step.
   subroutine count_step(simulation)
      type(simulation_type), intent(inout) :: simulation  !< between two steps
      logical :: with_contacts

      associate (maxima => simulation%maxima, dt => simulation%last_time_step, &
         size_of_model => 2*half_size(simulation%model%blocks))
         call update_base(maxima%base, simulation%model, simulation%blocks, &
            step_type(simulation%scheme, simulation%time - dt, dt), simulation%time)
         ! `path` increases by at most half the model size per step; faster steps are recorded.
         with_contacts = may_exceed(maxima%contacts, maxima%largest, simulation%path, &
            min_recorded_ratio*size_of_model) .or. 2*simulation%speed*dt >= size_of_model
      end associate
      with_contacts = with_contacts .or. finished(simulation)
      call count_state(simulation, .true., with_contacts)
   end subroutine count_step

   !> Update the maxima after the start of a stage, for removed blocks and static equilibrium.
   subroutine count_stage(simulation)
      type(simulation_type), intent(inout) :: simulation  !< between two steps

      call drop_removed(simulation%maxima%contacts, simulation%blocks)
      if (.not. simulation%model%stages(simulation%stage)%static) return
      call count_state(simulation, .false., .true.)
   end subroutine count_stage

   !> Update the maxima with the present state.
   subroutine count_state(simulation, rates, with_contacts)
      type(simulation_type), intent(inout) :: simulation  !< between two steps
      logical, intent(in) :: rates             !< include velocities and accelerations
      logical, intent(in) :: with_contacts     !< include slip and opening
      type(largest_type) :: maxima(number_of_maxima)

      maxima = simulation%maxima%largest
      call add_state(simulation, maxima, rates)
      if (with_contacts) call add_movement(simulation%maxima%contacts, maxima, &
         simulation%contacts(simulation%now), simulation%blocks, simulation%time, simulation%path)
      simulation%maxima%largest = maxima
   end subroutine count_state

   !> Update the maxima with the present state, except slip and opening.
   subroutine add_state(simulation, largest, rates)
      type(simulation_type), intent(in) :: simulation   !< between two steps
      type(largest_type), intent(inout) :: largest(:)   !< [maxima] largest values so far
      logical, intent(in) :: rates                      !< include velocities and accelerations
      real(wp), allocatable :: strain(:)
      integer :: b

      associate (maxima => simulation%maxima, blocks => simulation%blocks, time => simulation%time)
         call add_blocks(largest, blocks, maxima%first, maxima%base, time, rates)
         call add_contacts(largest, simulation%contacts(simulation%now), maxima%size_of, &
            maxima%least_size, time)
         if (size(maxima%below) > 0) call add_points(simulation, largest, rates)
      end associate
      if (.not. any(simulation%model%materials%yields())) return
      strain = plastic_strain(simulation%elements, simulation%blocks)
      b = maxloc(strain, 1)
      call update_largest(largest(of_plastic_strain), strain(b), simulation%time, [b, 0])
   end subroutine add_state

   !> Update the largest motions relative to the base, and the largest drift, of measured points.
   subroutine add_points(simulation, largest, rates)
      type(simulation_type), intent(in) :: simulation   !< between two steps
      type(largest_type), intent(inout) :: largest(:)   !< [maxima] largest values so far
      logical, intent(in) :: rates                      !< include velocities and accelerations
      real(wp) :: motion(2, 3), offset(2)
      integer :: i, k

      associate (maxima => simulation%maxima, base => simulation%maxima%base, &
         points => simulation%model%points, time => simulation%time)
         do i = 1, size(points)
            if (simulation%blocks%removed(points(i)%block)) cycle
            call measure_point(simulation%blocks, points(i), motion(:, 1), motion(:, 2), &
               motion(:, 3))
            motion(:, 1) = motion(:, 1) - (base%displacement - maxima%points_from)
            call update_largest(largest(of_point_displacement), norm2(motion(:, 1)), time, [i, 0])
            if (rates) call update_largest(largest(of_point_velocity), norm2(motion(:, 2) &
               - base%velocity), time, [i, 0])
            if (rates) call update_largest(largest(of_point_acceleration), norm2(motion(:, 3) &
               - base%acceleration), time, [i, 0])
            k = maxima%below(i)
            if (k == 0) cycle
            if (simulation%blocks%removed(points(k)%block)) cycle
            offset = reference_position(simulation, i) - reference_position(simulation, k)
            call update_largest(largest(of_point_drift), &
               abs(horizontal_displacement(simulation, i) &
               - horizontal_displacement(simulation, k))/offset(2), time, [i, k])
         end do
      end associate
   end subroutine add_points

   !> Displacement of a measured point in x, m.
   pure real(wp) function horizontal_displacement(simulation, i)
      type(simulation_type), intent(in) :: simulation   !< between two steps
      integer, intent(in) :: i                          !< measured point
      real(wp) :: displacement(2)

      associate (point => simulation%model%points(i))
         displacement = position_of(simulation%blocks, point%block, point%reference) - &
            point%position
      end associate
      horizontal_displacement = displacement(1)
   end function horizontal_displacement

   !> Restart the maxima of measured points after their displacements have been set to zero.
   subroutine restart_points(simulation)
      type(simulation_type), intent(inout) :: simulation  !< between two steps
      type(largest_type) :: none

      simulation%maxima%points_from = simulation%maxima%base%displacement
      simulation%maxima%largest(of_point_displacement) = none
      simulation%maxima%largest(of_point_drift) = none
   end subroutine restart_points

   !> Collect the residual (present) values, and the number of contacts that have moved.
   subroutine collect_residuals(simulation)
      type(simulation_type), intent(inout) :: simulation  !< between two steps
      type(largest_type) :: last(number_of_maxima)

      call add_state(simulation, last, .true.)
      call add_movement(simulation%maxima%contacts, last, simulation%contacts(simulation%now), &
         simulation%blocks, simulation%time)
      simulation%maxima%last = last
      call count_moved(simulation%maxima%contacts, simulation%contacts(simulation%now), &
         simulation%blocks, min_movement(simulation), simulation%maxima%moved)
   end subroutine collect_residuals

end module dda_running_maxima
