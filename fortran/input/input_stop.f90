! SPDX-License-Identifier: GPL-3.0-or-later
!> Group &stop: conditions that end a run before its duration.
module dda_input_stop
   use dda_kinds, only: wp, pi
   use dda_errors, only: error_type
   use dda_input_group, only: group_type, input_error, is_set, require_name, value_or, mark_names
   use dda_input_groups, only: stop_values, read_values
   use dda_model, only: model_type, half_size
   use dda_text, only: quoted, to_text
   implicit none
   private
   public :: read_stop

   real(wp), parameter :: usual_rest = 1.0e-6_wp  !< default displacement over the larger model side

contains

   !> Read &stop; degrees are converted to radians.
   subroutine read_stop(group, model, error)
      type(group_type), intent(in) :: group       !< group of the input
      type(model_type), intent(inout) :: model    !< model with its blocks
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      type(stop_values) :: own

      call read_values(group, own, error)
      associate (settings => model%stop)
         allocate (settings%watched(model%blocks%n), source=.false.)
         call mark_names(own%blocks, 'blocks', model%block_names, group, settings%watched, error)
         if (own%reference /= '' .and. .not. allocated(error)) call require_name(error, group, &
            'reference', own%reference, model%block_names, 'block', settings%reference)
         associate (same => count(model%block_names == own%reference))
            if (settings%reference > 0 .and. same > 1) call input_error(error, group, &
               'reference = '//quoted(own%reference)//' is the name of '//to_text(same)// &
               ' blocks: give it a unique name')
         end associate
         if (allocated(error)) return
         if (settings%reference > 0) settings%watched(settings%reference) = .false.
         settings%displacement = value_or(own%displacement, 0.0_wp)
         settings%tilt = value_or(own%tilt, 0.0_wp)*pi/180.0_wp
         if (is_set(own%fallen)) settings%fallen = own%fallen
         settings%rest_time = value_or(own%rest_time, 0.0_wp)
         settings%rest_movement = value_or(own%rest_movement, 2*usual_rest*half_size(model%blocks))
         if (settings%fallen > count(settings%watched)) call input_error(error, group, &
            'fallen = '//to_text(settings%fallen)//': only '//to_text(count(settings%watched))// &
            ' blocks are selected')
      end associate
   end subroutine read_stop

end module dda_input_stop
