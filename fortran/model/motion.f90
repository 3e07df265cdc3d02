! SPDX-License-Identifier: GPL-3.0-or-later
!> A prescribed motion: acceleration, velocity and displacement curves from a record.
module dda_motion
   use dda_kinds, only: wp
   use dda_baseline, only: motion_curve_type, displacement_at, velocity_at
   implicit none
   private
   public :: motion_type, displacement_of, velocity_of

   !> A motion of the ground or of a support.
   type :: motion_type
      character(len=64) :: name = ''
      character(len=:), allocatable :: file    !< record file; '' if the values are in the input
      character(len=:), allocatable :: source  !< record file and its processing, for provenance
      type(motion_curve_type) :: curve
      logical :: stops = .false.               !< the input requires a stop at the end of the record
   end type motion_type

contains

   !> Displacement along both axes by the motions with these numbers, m.
   pure function displacement_of(motions, number, time) result(displacement)
      type(motion_type), intent(in) :: motions(:)  !< motions of the model
      integer, intent(in) :: number(2)             !< numbers of the motions; 0: none
      real(wp), intent(in) :: time                 !< time, s
      real(wp) :: displacement(2)
      integer :: axis

      displacement = 0.0_wp
      do axis = 1, 2
         if (number(axis) > 0) displacement(axis) = displacement_at(motions(number(axis))%curve, &
            time)
      end do
   end function displacement_of

   !> Velocity along both axes by the motions with these numbers, m/s.
   pure function velocity_of(motions, number, time) result(velocity)
      type(motion_type), intent(in) :: motions(:)  !< motions of the model
      integer, intent(in) :: number(2)             !< numbers of the motions; 0: none
      real(wp), intent(in) :: time                 !< time, s
      real(wp) :: velocity(2)
      integer :: axis

      velocity = 0.0_wp
      do axis = 1, 2
         if (number(axis) > 0) velocity(axis) = velocity_at(motions(number(axis))%curve, time)
      end do
   end function velocity_of

end module dda_motion
