! SPDX-License-Identifier: GPL-3.0-or-later
!> Closed forms of the time integrations.
module api_schemes
   use, intrinsic :: iso_c_binding, only: c_double, c_double_complex, c_int
   use api_failure, only: error
   use dda_errors, only: error_input, fail
   use dda_kinds, only: pi
   use dda_scheme, only: scheme_type, scheme_named, integration_names
   use dda_scheme_response, only: free_damping, period_elongation, forced_damping, steps_to_decay, &
      amplification_roots, steady_type, steady_weights, step_for_damping, theta_for_damping
   implicit none
   private
   public :: scheme_numbers, scheme_vibration, scheme_steady, scheme_for_damping

contains

   !> theta and chi of a time integration by name; theta counts for 'theta' only.
   subroutine scheme_numbers(name, theta, numbers)
      character(len=*), intent(in) :: name
      real(c_double), intent(in) :: theta
      real(c_double), intent(out) :: numbers(2)
      type(scheme_type) :: scheme

      if (.not. any(integration_names == name)) call fail(error, error_input, "integration '"// &
         name//"' is not known; there are 'dda', 'midpoint', 'theta' and 'backward_euler'")
      scheme = scheme_named(name, theta)
      numbers = [scheme%theta, scheme%chi]
   end subroutine scheme_numbers

   !> What the scheme (theta, chi) makes of oscillators with frequencies (Hz) at a time step (s):
   !> damping ratio and period elongation in free vibration, damping ratio in steady vibration,
   !> steps in which an alternating velocity falls to 1/e; both roots of the amplification matrix.
   subroutine scheme_vibration(theta, chi, time_step, n, frequency, values, roots)
      integer(c_int), intent(in) :: n
      real(c_double), intent(in) :: theta, chi, time_step, frequency(n)
      real(c_double), intent(out) :: values(4, n)
      complex(c_double_complex), intent(out) :: roots(2, n)
      type(scheme_type) :: scheme
      integer :: i

      scheme = scheme_type(theta, chi)
      associate (omega => 2.0_c_double*pi*frequency)
         values(1, :) = free_damping(scheme, omega, time_step)
         values(2, :) = period_elongation(scheme, omega, time_step)
         values(3, :) = forced_damping(scheme, omega, time_step)
         values(4, :) = steps_to_decay(scheme, omega, time_step)
         do i = 1, n
            roots(:, i) = amplification_roots(scheme, omega(i), time_step)
         end do
      end associate
   end subroutine scheme_vibration

   !> Factors of the equations in steady vibration at frequencies (Hz), elastic terms having 1: of M
   !> instead of -omega^2 (1/s^2), of stiffness at the end of the step, of dashpots on d/dt and on
   !> the end velocity (1/s), of loads.
   subroutine scheme_steady(theta, chi, time_step, dynamic_factor, n, frequency, factors)
      integer(c_int), intent(in) :: n
      real(c_double), intent(in) :: theta, chi, time_step, dynamic_factor, frequency(n)
      complex(c_double_complex), intent(out) :: factors(5, n)
      type(steady_type) :: steady
      integer :: i

      do i = 1, n
         steady = steady_weights(scheme_type(theta, chi), 2.0_c_double*pi*frequency(i), time_step, &
            dynamic_factor)
         factors(:, i) = [steady%inertia, steady%end_stiffness, steady%mean_dashpot, &
            steady%end_dashpot, steady%load]
      end do
   end subroutine scheme_steady

   !> The time step (s) of the scheme (theta, chi), and theta = chi at a time step, for damping
   !> ratios in steady vibration at frequencies (Hz).
   subroutine scheme_for_damping(theta, chi, time_step, n, damping, frequency, steps, thetas)
      integer(c_int), intent(in) :: n
      real(c_double), intent(in) :: theta, chi, time_step, damping(n), frequency(n)
      real(c_double), intent(out) :: steps(n), thetas(n)

      associate (omega => 2.0_c_double*pi*frequency)
         steps = step_for_damping(scheme_type(theta, chi), damping, omega)
         thetas = theta_for_damping(damping, omega, time_step)
      end associate
   end subroutine scheme_for_damping

end module api_schemes
