! SPDX-License-Identifier: GPL-3.0-or-later
!> Incoming and actual motions of boundaries.  At a compliant base, these are the upward wave and
!> the mean motion of the edges; at a free-field side, the motion at the top of the soil column and
!> the motion of the model beside it.
module dda_boundary_motion
   use dda_kinds, only: wp
   use dda_baseline, only: displacement_at, velocity_at, acceleration_at
   use dda_boundary, only: boundary_motion_type
   use dda_columns, only: column_of
   use dda_measure, only: measure_point
   use dda_simulation, only: simulation_type
   implicit none
   private
   public :: take_boundary_motions

contains

   !> Collect the incoming and present motions of all boundaries.
   subroutine take_boundary_motions(simulation, motions)
      type(simulation_type), intent(in) :: simulation  !< simulation at its present time
      !> [2,boundary motions,6] displacement, velocity, acceleration (m, s): incoming, then actual
      real(wp), intent(out) :: motions(:,:,:)
      real(wp) :: part(2, 3)
      integer :: i, k

      motions = 0.0_wp
      do i = 1, size(simulation%model%boundary_motions)
         associate (motion => simulation%model%boundary_motions(i))
            motions(:, i, :3) = incoming_motion(simulation, motion)
            do k = 1, size(motion%point)
               call measure_point(simulation%blocks, motion%point(k), part(:, 1), part(:, 2), &
                  part(:, 3))
               motions(:, i, 4:) = motions(:, i, 4:) + motion%weight(k)*part
            end do
         end associate
      end do
   end subroutine take_boundary_motions

   !> Find displacement, velocity and acceleration of the incoming motion.
   function incoming_motion(simulation, motion) result(wave)
      type(simulation_type), intent(in) :: simulation  !< simulation at its present time
      type(boundary_motion_type), intent(in) :: motion  !< motion of a boundary
      real(wp) :: wave(2, 3)
      type(simulation_type), pointer :: column
      integer :: axis

      wave = 0.0_wp
      if (motion%field > 0) then
         column => column_of(simulation, motion%field)
         call measure_point(column%blocks, column%model%points(1), wave(:, 1), wave(:, 2), &
            wave(:, 3))
         return
      end if
      do axis = 1, 2
         if (motion%motion(axis) == 0) cycle
         associate (curve => simulation%model%motions(motion%motion(axis))%curve, &
            time => simulation%time)
            wave(axis, :) = motion%factor*[displacement_at(curve, time), &
               velocity_at(curve, time), acceleration_at(curve, time)]
         end associate
      end do
   end function incoming_motion

end module dda_boundary_motion
