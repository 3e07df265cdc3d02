! SPDX-License-Identifier: GPL-3.0-or-later
!> Displacement, velocity and acceleration of a material point.
module dda_measure
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type, place_of, offset_of, shape_matrix
   use dda_support, only: point_type
   implicit none
   private
   public :: measure_point

contains

   !> Motion of a point, m, m/s, m/s²; the acceleration is the scheme's, with the centripetal part.
   pure subroutine measure_point(blocks, point, displacement, velocity, acceleration)
      type(blocks_type), intent(in) :: blocks  !< in their present state
      type(point_type), intent(in) :: point  !< measured point
      !> m; [6,blocks] per s; m/s²
      real(wp), intent(out) :: displacement(2), velocity(2), acceleration(2)
      real(wp) :: t(2, 6)

      t = shape_matrix(blocks, point%block, point%reference)
      displacement = place_of(blocks, point%block, point%reference) - point%place
      velocity = matmul(t, blocks%velocity(:, point%block))
      acceleration = matmul(t, blocks%acceleration(:, point%block)) &
         - blocks%velocity(3, point%block)**2*offset_of(blocks, point%block, point%reference)
   end subroutine measure_point

end module dda_measure
