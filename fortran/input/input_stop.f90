! SPDX-License-Identifier: GPL-3.0-or-later
!> The group &stop: what ends a run before its duration.
module dda_input_stop
   use dda_kinds, only: wp, pi
   use dda_errors, only: error_type
   use dda_input_group, only: place_type, input_error, check_read, require_given, require_name, &
      value_or, unset, is_set, name_length
   use dda_input_names, only: list_length, mark_names
   use dda_model, only: model_type, half_size
   use dda_text, only: quoted, to_text
   implicit none
   private
   public :: read_stop

   real(wp), parameter :: usual_rest = 1.0e-6_wp  !< of the model's larger side

contains

   !> &stop; angles in degrees become radians.
   subroutine read_stop(group, place, model, error)
      character(len=*), intent(in) :: group       !< its text, on one line
      type(place_type), intent(in) :: place       !< of the group
      type(model_type), intent(inout) :: model    !< with its blocks
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      real(wp) :: displacement, tilt, fallen, rest_time, rest_movement
      character(len=list_length) :: blocks
      character(len=name_length) :: reference
      character(len=256) :: message
      integer :: status
      namelist /stop/ displacement, tilt, fallen, rest_time, rest_movement, blocks, reference

      displacement = unset
      tilt = unset
      fallen = unset
      rest_time = unset
      rest_movement = unset
      blocks = '*'
      reference = ''
      read (group, nml=stop, iostat=status, iomsg=message)
      call check_read(error, place, status, message)
      call require_given(error, place, 'displacement', displacement)
      call require_given(error, place, 'tilt', tilt)
      call require_given(error, place, 'fallen', fallen)
      call require_given(error, place, 'rest_time', rest_time)
      call require_given(error, place, 'rest_movement', rest_movement)
      call check_combination(error, place, [displacement, tilt, fallen, rest_time], rest_movement)
      associate (settings => model%stop)
         allocate (settings%watched(model%blocks%n), source=.false.)
         call mark_names(blocks, 'blocks', model%block_names, place, settings%watched, error)
         if (reference /= '' .and. .not. allocated(error)) call require_name(error, place, &
            'reference', reference, model%block_names, 'block', settings%reference)
         associate (same => count(model%block_names == reference))
            if (settings%reference > 0 .and. same > 1) call input_error(error, place, &
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
         if (settings%fallen > count(settings%watched)) call input_error(error, place, &
            'fallen = '//to_text(settings%fallen)//': only '//to_text(count(settings%watched))// &
            ' blocks are watched')
      end associate
   end subroutine read_stop

   !> Something to watch is named, and a movement of rest has its time.
   pure subroutine check_combination(error, place, limits, rest_movement)
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(place_type), intent(in) :: place       !< of the group
      real(wp), intent(in) :: limits(4)           !< displacement, tilt, fallen, rest_time
      real(wp), intent(in) :: rest_movement       !< m, or `unset`

      if (.not. any(is_set(limits))) call input_error(error, place, &
         'give one at least of displacement, tilt, fallen and rest_time')
      if (is_set(rest_movement) .and. .not. is_set(limits(4))) call input_error(error, place, &
         'rest_movement needs rest_time: how long nothing may move by more than that')
      if (is_set(limits(3)) .and. limits(3) /= aint(limits(3))) call input_error(error, place, &
         'fallen = '//to_text(limits(3))//' must be a whole number')
   end subroutine check_combination

end module dda_input_stop
