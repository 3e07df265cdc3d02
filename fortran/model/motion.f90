!> A prescribed motion by name: a record made into acceleration, velocity and displacement curves.
module dda_motion
   use dda_baseline, only: motion_curve_type
   implicit none
   private
   public :: motion_type, motion_named

   !> A motion of the ground or of a support.
   type :: motion_type
      character(len=64) :: name = ''
      character(len=:), allocatable :: file    !< record file, '' if the values stand in the input
      !> record file and what was done to it, for provenance
      character(len=:), allocatable :: source
      type(motion_curve_type) :: curve
   end type motion_type

contains

   !> Position of the motion with a name; 0 if there is none.
   pure integer function motion_named(motions, name) result(found)
      type(motion_type), intent(in) :: motions(:)
      character(len=*), intent(in) :: name
      integer :: i

      found = 0
      do i = 1, size(motions)
         if (motions(i)%name == name) found = i
      end do
   end function motion_named

end module dda_motion
