! SPDX-License-Identifier: GPL-3.0-or-later
!> Displacement, velocity and acceleration of a material point.
module dda_measure
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type, position_of, offset_of, motion_of
   use dda_support, only: point_type
   implicit none
   private
   public :: measure_point

contains

   !> Compute displacement, velocity and acceleration of a point.
   !> The acceleration is the value of the time integration plus the centripetal part.
   pure subroutine measure_point(blocks, point, displacement, velocity, acceleration)
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(point_type), intent(in) :: point  !< measured point
      !> motion of the point, m; m/s; m/s²
      real(wp), intent(out) :: displacement(2), velocity(2), acceleration(2)

      associate (b => point%block, reference => point%reference)
         displacement = position_of(blocks, b, reference) - point%position
         velocity = motion_of(blocks, b, reference, blocks%velocity(:, b))
         acceleration = motion_of(blocks, b, reference, blocks%acceleration(:, b)) &
            - blocks%velocity(3, b)**2*offset_of(blocks, b, reference)
      end associate
   end subroutine measure_point

end module dda_measure
