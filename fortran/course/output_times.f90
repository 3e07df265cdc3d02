! SPDX-License-Identifier: GPL-3.0-or-later
!> Output at equal intervals: samples and frames are written at whole multiples of their intervals
!> after the start of a stage, and adaptive steps are shortened to end at these times.
module dda_output_times
   use dda_kinds, only: wp, long
   use dda_simulation, only: simulation_type
   implicit none
   private
   public :: aim_type, aim_at_output, reach_output, is_output_time

   real(wp), parameter :: nearly = 1.0_wp + 1.0e-9_wp  !< factor that allows for rounding of times

   !> Output time at which the next step must end, and the shortened Δt of this step.
   type :: aim_type
      real(wp) :: time = 0.0_wp      !< time of the output at which the step must end, s
      real(wp) :: planned = 0.0_wp   !< Δt before shortening, s; 0: not shortened
      real(wp) :: shortened = 0.0_wp  !< Δt after shortening, s
      logical :: ends_at_time = .false.  !< the step ends at `time`
   end type aim_type

contains

   !> Shorten the next adaptive step to end at the next output time.
   !> If the output time is one to two steps ahead, the step ends half-way.
   pure subroutine aim_at_output(simulation, aim)
      type(simulation_type), intent(inout) :: simulation  !< between two steps
      type(aim_type), intent(out) :: aim                  !< target time
      real(wp) :: remaining_time

      associate (output => simulation%model%output)
         if (.not. simulation%model%control%adaptive) return
         if (max(output%history_seconds, output%block_seconds) <= 0.0_wp) return
         aim%time = min(next_output_time(simulation, output%history_seconds), &
            next_output_time(simulation, output%block_seconds))
      end associate
      remaining_time = aim%time - simulation%time
      aim%ends_at_time = remaining_time <= nearly*simulation%time_step
      if (.not. aim%ends_at_time .and. remaining_time >= 2*simulation%time_step) return
      aim%planned = simulation%time_step
      simulation%time_step = merge(remaining_time, 0.5_wp*remaining_time, aim%ends_at_time)
      aim%shortened = simulation%time_step
   end subroutine aim_at_output

   !> Set the exact time after the step, and restore Δt if the step was shortened.
   pure subroutine reach_output(simulation, aim)
      type(simulation_type), intent(inout) :: simulation  !< between two steps
      type(aim_type), intent(in) :: aim                   !< target time from `aim_at_output`
      real(wp) :: remaining_time

      if (aim%planned <= 0.0_wp .or. simulation%last_time_step /= aim%shortened) return
      if (aim%ends_at_time) simulation%time = aim%time
      simulation%time_step = max(simulation%time_step, aim%planned)
      associate (control => simulation%model%control)
         remaining_time = simulation%first_time + real(control%step_count, wp)*control%time_step &
            - simulation%time
      end associate
      if (remaining_time > 0.0_wp) simulation%time_step = min(simulation%time_step, remaining_time)
   end subroutine reach_output

   !> Next multiple of an interval after the start of the stage, s.
   pure real(wp) function next_output_time(simulation, interval)
      type(simulation_type), intent(in) :: simulation  !< between two steps
      real(wp), intent(in) :: interval                 !< s; 0: none

      next_output_time = huge(1.0_wp)
      if (interval > 0.0_wp) next_output_time = simulation%first_time + interval &
         *(aint((simulation%time - simulation%first_time)/interval*nearly) + 1.0_wp)
   end function next_output_time

   !> .true. if a step has ended at a multiple of an interval after the start of the stage.
   pure logical function is_output_time(simulation, interval) result(at_output)  ! total
      type(simulation_type), intent(in) :: simulation  !< between two steps
      real(wp), intent(in) :: interval                 !< s; 0: none
      real(wp) :: since

      at_output = .false.
      if (interval <= 0.0_wp) return
      since = simulation%time - simulation%first_time
      associate (control => simulation%model%control)
         if (control%adaptive) then
            at_output = abs(since - interval*anint(since/interval)) <= (nearly - 1.0_wp)*interval
         else
            at_output = modulo(simulation%step - simulation%first_step, &
               max(1_long, nint(interval/control%time_step, long))) == 0
         end if
      end associate
   end function is_output_time

end module dda_output_times
