! SPDX-License-Identifier: GPL-3.0-or-later
!> Largest movement of a model at rest; larger movements are not rounding errors.
module dda_rest_bound
   use dda_kinds, only: wp
   use dda_model, only: model_type, half_size
   use dda_simulation, only: simulation_type, gravity_is_sudden
   implicit none
   private
   public :: is_at_rest

   !> movement/model size due to rounding and the equilibrium tolerance, measured without loads
   real(wp), parameter :: rest_ratio = 1.0e-9_wp
   real(wp), parameter :: rounding_ratio = 100*epsilon(1.0_wp)  !< rounding error/model size
   real(wp), parameter :: motion_ratio = 1.0e-9_wp  !< movement due to rounding/prescribed motion

contains

   !> .true. if the largest movement is due to rounding.
   pure logical function is_at_rest(simulation, displacement)
      type(simulation_type), intent(in) :: simulation  !< simulation at its present time
      real(wp), intent(in) :: displacement                  !< displacement of a block so far, m

      associate (model => simulation%model, size_of => 2*half_size(simulation%model%blocks))
         if (has_excitation(model)) then
            is_at_rest = displacement <= max(rounding_ratio*size_of, &
               motion_ratio*largest_motion(model))
         else
            is_at_rest = displacement <= rest_ratio*size_of
         end if
      end associate
   end function is_at_rest

   !> .true. if motions, changing loads, initial velocities or sudden gravity move the model.
   pure logical function has_excitation(model)
      type(model_type), intent(in) :: model  !< model of the run
      integer :: i

      has_excitation = gravity_is_sudden(model)
      if (largest_motion(model) > 0.0_wp) has_excitation = .true.
      if (.not. model%stages(1)%static) has_excitation = has_excitation .or. size(model%loads) &
         + size(model%edge_loads) + size(model%bolts) > 0
      do i = 1, size(model%materials)
         has_excitation = has_excitation .or. norm2(model%materials(i)%initial_velocity) > 0.0_wp
      end do
      do i = 1, size(model%loads)
         associate (force => model%loads(i)%force)
            has_excitation = has_excitation .or. any(abs(force - spread(force(:, 1), 2, &
               size(force, 2))) > 0.0_wp)
         end associate
      end do
      do i = 1, size(model%edge_loads)
         if (.not. allocated(model%edge_loads(i)%time)) cycle
         has_excitation = has_excitation .or. size(model%edge_loads(i)%time) > 1
      end do
   end function has_excitation

   !> Largest displacement of all motions, m.
   pure real(wp) function largest_motion(model) result(displacement)
      type(model_type), intent(in) :: model  !< model of the run
      integer :: i

      displacement = 0.0_wp
      do i = 1, size(model%motions)
         associate (curve => model%motions(i)%curve)
            if (allocated(curve%displacement)) displacement = max(displacement, &
               maxval(abs(curve%displacement)))
         end associate
      end do
   end function largest_motion

end module dda_rest_bound
