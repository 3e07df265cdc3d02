! SPDX-License-Identifier: GPL-3.0-or-later
!> Beds of springs [Winkler, 1867]: points of edges on springs with a stiffness per area, which act
!> in compression and tension at t₀ + θΔt.
module dda_spring_beds
   use dda_kinds, only: wp
   use dda_fixed_points, only: fixed_points_type, new_fixed_points
   use dda_linear_terms, only: term_bed, at_theta
   use dda_motion, only: motion_type
   use dda_support, only: fixed_point_type
   implicit none
   private
   public :: new_spring_beds

contains

   !> Create springs that act from a time on.
   pure type(fixed_points_type) function new_spring_beds(points, motions, time) result(self)
      type(fixed_point_type), intent(in) :: points(:)  !< [points] points with their stiffness
      type(motion_type), intent(in) :: motions(:)      !< prescribed ones
      real(wp), intent(in) :: time                     !< s

      self = new_fixed_points(points, motions, 0.0_wp, time)
      self%kind = term_bed
      self%instant = at_theta
      self%of_penalty = .false.
   end function new_spring_beds

end module dda_spring_beds
