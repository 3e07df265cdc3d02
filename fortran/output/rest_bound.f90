! SPDX-License-Identifier: GPL-3.0-or-later
!> Upper bound of movements due to rounding, which depends on loads and motions.
module dda_rest_bound
   use dda_kinds, only: wp
   use dda_model, only: model_type, half_size
   use dda_simulation, only: simulation_type, comes_suddenly
   implicit none
   private
   public :: is_at_rest

   !> movement due to rounding and tolerance of equilibrium (measured without loads) over model size
   real(wp), parameter :: rest_share = 1.0e-9_wp
   real(wp), parameter :: rounding_share = 100*epsilon(1.0_wp)  !< rounding over model size
   real(wp), parameter :: drive_share = 1.0e-9_wp               !< fraction of the prescribed motion

contains

   !> .true. if the largest movement is due to rounding.
   pure logical function is_at_rest(simulation, largest)
      type(simulation_type), intent(in) :: simulation  !< simulation at its present time
      real(wp), intent(in) :: largest                  !< displacement of a block so far, m

      associate (model => simulation%model, size_of => 2*half_size(simulation%model%blocks))
         if (is_driven(model)) then
            is_at_rest = largest <= max(rounding_share*size_of, drive_share*largest_motion(model))
         else
            is_at_rest = largest <= rest_share*size_of
         end if
      end associate
   end function is_at_rest

   !> .true. if motions, changing loads, initial velocities or sudden gravity move the model.
   pure logical function is_driven(model)
      type(model_type), intent(in) :: model  !< model of the run
      integer :: i

      is_driven = comes_suddenly(model)
      if (largest_motion(model) > 0.0_wp) is_driven = .true.
      if (.not. model%stages(1)%static) is_driven = is_driven .or. size(model%loads) &
         + size(model%edge_loads) + size(model%bolts) > 0
      do i = 1, size(model%materials)
         is_driven = is_driven .or. norm2(model%materials(i)%initial_velocity) > 0.0_wp
      end do
      do i = 1, size(model%loads)
         associate (force => model%loads(i)%force)
            is_driven = is_driven .or. any(abs(force - spread(force(:, 1), 2, size(force, 2))) &
               > 0.0_wp)
         end associate
      end do
      do i = 1, size(model%edge_loads)
         if (.not. allocated(model%edge_loads(i)%time)) cycle
         is_driven = is_driven .or. size(model%edge_loads(i)%time) > 1
      end do
   end function is_driven

   !> Largest displacement of all motions, m.
   pure real(wp) function largest_motion(model) result(largest)
      type(model_type), intent(in) :: model  !< model of the run
      integer :: i

      largest = 0.0_wp
      do i = 1, size(model%motions)
         associate (curve => model%motions(i)%curve)
            if (allocated(curve%displacement)) largest = max(largest, &
               maxval(abs(curve%displacement)))
         end associate
      end do
   end function largest_motion

end module dda_rest_bound
