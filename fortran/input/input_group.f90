!> Small words for reading one group: where it stands, complaints that name it, checks of values.
module dda_input_group
   use dda_kinds, only: wp
   use dda_errors, only: error_type, error_input, fail
   use dda_namelist_groups, only: group_type
   use dda_text, only: to_text, quoted, lower_case
   implicit none
   private
   public :: place_type, place_of_group, input_error, read_error, require_positive, &
      require_within, require_finite
   public :: unset, is_set, name_length

   !> stands in a variable that the input does not mention
   real(wp), parameter :: unset = -huge(1.0_wp)
   integer, parameter :: name_length = 64

   !> Where a value stands.
   type :: place_type
      character(len=:), allocatable :: text   !< "FILE, group &name (line N)"
   end type place_type

contains

   pure function place_of_group(file, group) result(place)
      character(len=*), intent(in) :: file
      type(group_type), intent(in) :: group
      type(place_type) :: place

      place%text = file//', group &'//group%name//' (line '//to_text(group%line)//')'
   end function place_of_group

   pure logical elemental function is_set(value)
      real(wp), intent(in) :: value

      is_set = value /= unset
   end function is_set

   !> An input error at a place.
   pure subroutine input_error(error, place, message)
      type(error_type), allocatable, intent(inout) :: error
      type(place_type), intent(in) :: place
      character(len=*), intent(in) :: message

      if (.not. allocated(error)) call fail(error, error_input, place%text//': '//message)
   end subroutine input_error

   !> What a failed namelist read means, in words.
   pure subroutine read_error(error, place, message)
      type(error_type), allocatable, intent(inout) :: error
      type(place_type), intent(in) :: place
      character(len=*), intent(in) :: message  !< iomsg of the read
      character(len=*), parameter :: bad_data = 'Bad data for namelist object '
      character(len=*), parameter :: letters = 'abcdefghijklmnopqrstuvwxyz'
      character(len=*), parameter :: unknown = 'Cannot match namelist object name '

      if (index(message, unknown) == 1) then
         if (verify(lower_case(message(len(unknown) + 1:len(unknown) + 1)), letters) > 0) then
            call input_error(error, place, quoted(message(len(unknown) + 1:))// &
               ' cannot be read here: it is no value of the variable before it, or one more '// &
               'than that variable holds')
         else
            call input_error(error, place, 'there is no variable '// &
               quoted(message(len(unknown) + 1:))//' in this group')
         end if
      else if (index(message, bad_data) == 1) then
         call input_error(error, place, 'the values of '//quoted(message(len(bad_data) + 1:))// &
            ' cannot be read: something in or after them is neither a number nor a variable of '// &
            'this group')
      else if (index(message, 'End of file') > 0) then
         ! The run-time library takes a byte of 255 for the end of the text.
         call input_error(error, place, 'the group ends in the middle of a value, or holds a '// &
            'byte that is no text')
      else
         call input_error(error, place, trim(message))
      end if
   end subroutine read_error

   pure subroutine require_positive(error, place, name, value)
      type(error_type), allocatable, intent(inout) :: error
      type(place_type), intent(in) :: place
      character(len=*), intent(in) :: name
      real(wp), intent(in) :: value

      if (allocated(error)) return
      if (.not. is_set(value)) then
         call input_error(error, place, name//' is missing')
      else if (.not. (value > 0.0_wp .and. value <= huge(value))) then
         call input_error(error, place, name//' = '//to_text(value)//' must be a positive number')
      end if
   end subroutine require_positive

   pure subroutine require_within(error, place, name, value, low, high)
      type(error_type), allocatable, intent(inout) :: error
      type(place_type), intent(in) :: place
      character(len=*), intent(in) :: name
      real(wp), intent(in) :: value, low, high

      if (allocated(error)) return
      if (.not. (value >= low .and. value <= high)) call input_error(error, place, &
         name//' = '//to_text(value)//' must lie between '//to_text(low)//' and '//to_text(high))
   end subroutine require_within

   pure subroutine require_finite(error, place, name, values)
      type(error_type), allocatable, intent(inout) :: error
      type(place_type), intent(in) :: place
      character(len=*), intent(in) :: name
      real(wp), intent(in) :: values(:)
      integer :: i

      do i = 1, size(values)
         if (allocated(error)) return
         if (.not. is_set(values(i)) .and. size(values) > 1) then
            call input_error(error, place, name//': a value is left out')
         else if (.not. is_set(values(i))) then
            call input_error(error, place, name//' is missing')
         else if (.not. abs(values(i)) <= 1.0e30_wp) then
            call input_error(error, place, name//' = '//to_text(values(i))// &
               ' is not a usable number')
         end if
      end do
   end subroutine require_finite

end module dda_input_group
