! SPDX-License-Identifier: GPL-3.0-or-later
!> The group &stop: what ends a run before its duration.
module dda_input_stop
   use dda_kinds, only: wp, pi
   use dda_errors, only: error_type
   use dda_input_group, only: group_type, input_error, get, get_text, require_name, value_or, &
      unset, is_set, name_length
   use dda_input_names, only: mark_names
   use dda_model, only: model_type, half_size
   use dda_text, only: quoted, to_text
   implicit none
   private
   public :: read_stop

   real(wp), parameter :: usual_rest = 1.0e-6_wp  !< of the model's larger side

contains

   !> &stop; angles in degrees become radians.
   subroutine read_stop(group, model, error)
      type(group_type), intent(in) :: group       !< of the group
      type(model_type), intent(inout) :: model    !< with its blocks
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      real(wp) :: displacement, tilt, fallen, rest_time, rest_movement
      character(len=:), allocatable :: blocks
      character(len=name_length) :: reference

      displacement = unset
      tilt = unset
      fallen = unset
      rest_time = unset
      rest_movement = unset
      blocks = '*'
      reference = ''
      call get(group, 'displacement', displacement, error)
      call get(group, 'tilt', tilt, error)
      call get(group, 'fallen', fallen, error)
      call get(group, 'rest_time', rest_time, error)
      call get(group, 'rest_movement', rest_movement, error)
      call get_text(group, 'blocks', blocks)
      call get(group, 'reference', reference, error)
      call check_combination(error, group, [displacement, tilt, fallen, rest_time], rest_movement)
      associate (settings => model%stop)
         allocate (settings%watched(model%blocks%n), source=.false.)
         call mark_names(blocks, 'blocks', model%block_names, group, settings%watched, error)
         if (reference /= '' .and. .not. allocated(error)) call require_name(error, group, &
            'reference', reference, model%block_names, 'block', settings%reference)
         associate (same => count(model%block_names == reference))
            if (settings%reference > 0 .and. same > 1) call input_error(error, group, &
               'reference = '//quoted(reference)//' is the name of '//to_text(same)// &
               ' blocks: give the one that is meant a name of its own')
         end associate
         if (allocated(error)) return
         if (settings%reference > 0) settings%watched(settings%reference) = .false.
         settings%displacement = value_or(displacement, 0.0_wp)
         settings%tilt = value_or(tilt, 0.0_wp)*pi/180.0_wp
         settings%fallen = nint(value_or(fallen, 0.0_wp))
         settings%rest_time = value_or(rest_time, 0.0_wp)
         settings%rest_movement = value_or(rest_movement, 2*usual_rest*half_size(model%blocks))
         if (settings%fallen > count(settings%watched)) call input_error(error, group, &
            'fallen = '//to_text(settings%fallen)//': only '//to_text(count(settings%watched))// &
            ' blocks are watched')
      end associate
   end subroutine read_stop

   !> Something to watch is named, and a movement of rest has its time.
   pure subroutine check_combination(error, group, limits, rest_movement)
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(group_type), intent(in) :: group       !< of the group
      real(wp), intent(in) :: limits(4)           !< displacement, tilt, fallen, rest_time
      real(wp), intent(in) :: rest_movement       !< m, or `unset`

      if (.not. any(is_set(limits))) call input_error(error, group, &
         'give one at least of displacement, tilt, fallen and rest_time')
      if (is_set(rest_movement) .and. .not. is_set(limits(4))) call input_error(error, group, &
         'rest_movement needs rest_time: how long nothing may move by more than that')
   end subroutine check_combination

end module dda_input_stop
