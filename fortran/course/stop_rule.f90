! SPDX-License-Identifier: GPL-3.0-or-later
!> End of a run before its duration, due to displacement or tilt beyond a limit, fallen blocks, or
!> static equilibrium.
!>
!> Movement is measured from the first frame of the output, in equilibrium if the first stage is
!> static.  Equilibrium is judged by positions, because velocities of stiff modes may change sign in
!> each step while no block moves.
module dda_stop_rule
   use dda_kinds, only: wp, pi
   use dda_edge_load, only: history_of
   use dda_model, only: drift_velocity
   use dda_simulation, only: simulation_type, block_name
   use dda_stage, only: never
   use dda_text, only: to_text
   implicit none
   private
   public :: prepare_stop_rule, begin_stop_rule, apply_stop_rule

contains

   !> Allocate the positions from which movement is measured.
   pure subroutine prepare_stop_rule(simulation)
      type(simulation_type), intent(inout) :: simulation  !< new run

      simulation%stop%reason = ''
      if (.not. allocated(simulation%model%stop%watched)) return
      allocate (simulation%stop%first(3, simulation%blocks%n), &
         simulation%stop%window(3, simulation%blocks%n), source=0.0_wp)
   end subroutine prepare_stop_rule

   !> Begin to measure movement from the present state.
   pure subroutine begin_stop_rule(simulation)
      type(simulation_type), intent(inout) :: simulation  !< between two steps

      if (.not. allocated(simulation%stop%first)) return
      simulation%stop%first = simulation%blocks%position(1:3, :)
      call begin_window(simulation)
   end subroutine begin_stop_rule

   !> Begin the time window in which blocks must not move.
   pure subroutine begin_window(simulation)
      type(simulation_type), intent(inout) :: simulation  !< between two steps

      simulation%stop%window = simulation%blocks%position(1:3, :)
      simulation%stop%since = simulation%time
   end subroutine begin_window

   !> Find the reason to end the run after a step, if there is one.
   pure subroutine apply_stop_rule(simulation)
      type(simulation_type), intent(inout) :: simulation  !< between two steps

      if (.not. allocated(simulation%stop%first)) return
      call judge_movement(simulation)
      if (simulation%stop%reason == '') call judge_rest(simulation)
   end subroutine apply_stop_rule

   !> Judge displacement, tilt and fallen blocks, relative to the reference block.
   pure subroutine judge_movement(simulation)
      type(simulation_type), intent(inout) :: simulation  !< between two steps
      real(wp) :: reference_movement(3), movement(3), distance
      integer :: b, fallen

      fallen = 0
      associate (settings => simulation%model%stop, state => simulation%stop, &
         blocks => simulation%blocks)
         reference_movement = 0.0_wp
         b = settings%reference
         if (b > 0) reference_movement = blocks%position(1:3, b) - state%first(:, b)
         do b = 1, blocks%n
            if (.not. settings%watched(b) .or. blocks%removed(b)) cycle
            movement = blocks%position(1:3, b) - state%first(:, b) - reference_movement
            distance = norm2(movement(:2))
            if (settings%displacement > 0.0_wp .and. distance > settings%displacement) then
               state%reason = 'block '//block_name(simulation, b)//' has moved by '// &
                  to_text(distance)//' m; displacement of &stop is '// &
                  to_text(settings%displacement)//' m'
            else if (settings%tilt > 0.0_wp .and. abs(movement(3)) > settings%tilt) then
               state%reason = 'block '//block_name(simulation, b)//' has tilted by '// &
                  to_text(to_degrees(abs(movement(3))))//'°; tilt of &stop is '// &
                  to_text(to_degrees(settings%tilt))//'°'
            end if
            if (distance**2 > blocks%whole_area(b)) then
               if (is_counted_block(blocks%body, b)) fallen = fallen + 1
            end if
            if (settings%fallen > 0 .and. fallen >= settings%fallen) &
               state%reason = to_text(fallen)//trim(merge(' block has  ', ' blocks have', &
               fallen == 1))//' moved farther than their size, the last of them '// &
               block_name(simulation, b)
            if (state%reason /= '') return
         end do
      end associate
   end subroutine judge_movement

   !> .true. if block b is counted: blocks outside bodies, and the first cell of each body.
   pure logical function is_counted_block(body, b)
      integer, intent(in) :: body(:)  !< [blocks] body of which the block is a cell; 0: none
      integer, intent(in) :: b        !< number of the block

      is_counted_block = body(b) == 0
      if (.not. is_counted_block) is_counted_block = findloc(body, body(b), 1) == b
   end function is_counted_block

   !> Angle in degrees.
   pure real(wp) function to_degrees(angle)
      real(wp), intent(in) :: angle  !< rad

      to_degrees = angle*180.0_wp/pi
   end function to_degrees

   !> End the run if no vertex has moved in the time window.
   !> The rule applies in the last stage, after the end of all motions and changes of loads.
   !> If all supports continue at the same velocity after their records, movement is relative to
   !> the supports.
   pure subroutine judge_rest(simulation)
      type(simulation_type), intent(inout) :: simulation  !< between two steps
      real(wp) :: movement(3), drift(2)
      integer :: b

      associate (settings => simulation%model%stop, state => simulation%stop, &
         blocks => simulation%blocks)
         if (settings%rest_time <= 0.0_wp) return
         drift = drift_velocity(simulation%model)*(simulation%time - max(state%since, &
            excitation_end(simulation)))
         do b = 1, blocks%n
            if (.not. settings%watched(b) .or. blocks%removed(b)) cycle
            movement = blocks%position(1:3, b) - state%window(:, b)
            movement(:2) = movement(:2) - drift
            if (norm2(movement(:2)) &
               + abs(movement(3))*blocks%radius(b) > settings%rest_movement) then
               call begin_window(simulation)
               return
            end if
         end do
         if (simulation%time - state%since < settings%rest_time) return
         if (simulation%stage < size(simulation%model%stages)) return
         if (simulation%time - excitation_end(simulation) < settings%rest_time) return
         state%reason = 'rest: no vertex has moved by more than '// &
            to_text(settings%rest_movement)//' m within '//to_text(settings%rest_time)//' s'
      end associate
   end subroutine judge_rest

   !> Time at which the last motion ends and the last load changes, s.
   pure real(wp) function excitation_end(simulation)
      type(simulation_type), intent(in) :: simulation  !< between two steps
      integer :: i, k

      excitation_end = 0.0_wp
      associate (model => simulation%model)
         do i = 1, size(model%motions)
            associate (curve => model%motions(i)%curve)
               if (curve%start < never) excitation_end = max(excitation_end, curve%start &
                  + curve%duration)
            end associate
         end do
         do i = 1, size(model%loads)
            associate (load => model%loads(i))
               if (load%start < never) excitation_end = max(excitation_end, load%start &
                  + last_change(load%time, load%force, simulation%time - load%start))
            end associate
         end do
         do i = 1, size(model%edge_loads)
            associate (load => model%edge_loads(i))
               if (load%present .and. size(load%time) > 1) excitation_end = max(excitation_end, &
                  last_change(load%time, reshape([(history_of(load, k), k=1, size(load%time))], &
                  [3, size(load%time)]), simulation%time))
            end associate
         end do
      end associate
   end function excitation_end

   !> Time of the last change of a load that is linear between given times, s.
   pure real(wp) function last_change(times, values, time)
      real(wp), intent(in) :: times(:)     !< s, ascending
      real(wp), intent(in) :: values(:,:)  !< [components,times]
      real(wp), intent(in) :: time          !< s
      integer :: k

      k = size(times)
      if (times(k) > time) then
         do k = size(times), 2, -1
            if (any(values(:, k) /= values(:, k - 1))) exit
         end do
      end if
      last_change = times(k)
   end function last_change

end module dda_stop_rule
