! SPDX-License-Identifier: GPL-3.0-or-later
!> Materials of the ground: bodies of a damping ratio, branches of soil, a column of them.
module api_soils
   use, intrinsic :: iso_c_binding, only: c_double, c_int
   use api_failure, only: error
   use dda_branches, only: branches_type, curve_type, fit_branches, set_body
   use dda_damping, only: damping_type, fit_body, max_mechanisms
   use dda_errors, only: error_input, fail
   use dda_interrupts, only: fail_if_stopped
   use dda_shear_column, only: shear_column_type, shear_state_type, begin_column, shake_column, &
      end_accelerations, energy_balance
   use dda_text, only: to_text
   implicit none
   private
   public :: body_of, soil_branches, shake_soil

contains

   !> The generalised Maxwell body of a damping ratio over a band (Hz; 0: automatic) with a number
   !> of mechanisms (0: automatic) up to a frequency (rad/s): its mechanisms, and largest modulus,
   !> misfit and band.
   subroutine body_of(ratio, reference, band, mechanisms, limit, n, omega, weight, numbers)
      real(c_double), intent(in) :: ratio, reference, band(2), limit
      integer(c_int), intent(in) :: mechanisms
      integer(c_int), intent(out) :: n
      real(c_double), intent(out) :: omega(16), weight(16), numbers(4)
      type(damping_type) :: damping

      damping%ratio = ratio
      damping%reference = reference
      damping%band = band
      damping%n = mechanisms
      if (mechanisms /= 0 .and. (mechanisms < 2 .or. mechanisms > max_mechanisms)) then
         call fail(error, error_input, 'mechanisms must be in 2 ... 16')
      else
         call fit_body(damping, limit, error)
      end if
      n = damping%n
      omega = damping%omega
      weight = damping%weight
      numbers = [damping%unrelaxed, damping%misfit, damping%band]
   end subroutine body_of

   !> Branches of a soil from its curves over the strain (m rows), by Masing's rules or with the
   !> damping given, and a damping ratio of small strains: strains, moduli over that of small
   !> strains and shares that slip; strain from which the body of small strains slips, its cap,
   !> largest relative error of the modulus, largest error of the damping ratio.
   subroutine soil_branches(m, strain, reduction, damping, masing, ratio, reference, n, branches, &
      numbers)
      integer(c_int), intent(in) :: m, n, masing
      real(c_double), intent(in) :: strain(m), reduction(m), damping(m), ratio, reference
      real(c_double), intent(out) :: branches(n, 3), numbers(4)
      type(branches_type) :: fitted

      call fit_branches(curve_type(strain, reduction, damping), n, masing /= 0, &
         damping_type(ratio=ratio, reference=reference), huge(1.0_c_double), fitted, error)
      if (allocated(error)) return
      branches(:, 1) = fitted%strain
      branches(:, 2) = fitted%modulus
      branches(:, 3) = fitted%slipping
      numbers = [fitted%body_strain, fitted%body_cap, fitted%misfit]
   end subroutine soil_branches

   !> A column of cells (thickness, density, modulus), of soils with branches and a damping ratio of
   !> small strains, whose body slips from a strain on.  Its base has an acceleration at each step,
   !> or an outcrop of the half-space has it (density times velocity above 0).  Each `every`th step:
   !> accelerations and displacements of the nodes, strains and stresses of the cells; the largest
   !> of both in all steps, the energies at the end, iterations of each step.
   subroutine shake_soil(cells, layers, soil, soils, n, branches, ratio, limit, reference, &
      dashpot, time_step, steps, base, every, kept, acceleration, displacement, strain, stress, &
      largest, energy, iterations)
      integer(c_int), intent(in) :: cells, soils, n, steps, every, kept
      real(c_double), intent(in) :: layers(3, cells), branches(n, 3, soils), ratio(soils), &
         limit(soils), reference, dashpot, time_step, base(steps + 1)
      integer(c_int), intent(in) :: soil(cells)
      real(c_double), intent(out) :: acceleration(cells + 1, kept), displacement(cells + 1, kept), &
         strain(cells, kept), stress(cells, kept), largest(2, cells), energy(5)
      integer(c_int), intent(out) :: iterations(steps)
      type(shear_column_type) :: column
      type(shear_state_type) :: state
      real(c_double) :: velocity, change
      integer :: i

      call take_column(layers, soil, branches, ratio, limit, reference, dashpot, column)
      if (allocated(error)) return
      call begin_column(column, state)
      acceleration(:, 1) = end_accelerations(column, state, base(1), 0.0_c_double)
      displacement(:, 1) = 0.0_c_double
      strain(:, 1) = 0.0_c_double
      stress(:, 1) = 0.0_c_double
      velocity = 0.0_c_double
      do i = 1, steps
         if (mod(i, 256) == 0) call fail_if_stopped(error)
         if (allocated(error)) return
         change = 0.5_c_double*time_step*(base(i) + base(i + 1))
         call shake_column(column, time_step, velocity + 0.5_c_double*change, state, error)
         if (allocated(error)) error%message = 't = '//to_text(i*time_step)//' s: '//error%message
         if (allocated(error)) return
         velocity = velocity + change
         iterations(i) = state%iterations
         if (mod(i, every) /= 0) cycle
         associate (k => i/every + 1)
            acceleration(:, k) = end_accelerations(column, state, base(i + 1), velocity)
            displacement(:, k) = state%displacement
            strain(:, k) = state%strain
            stress(:, k) = state%stress
         end associate
      end do
      energy = energy_balance(column, state)
      largest = state%largest
   end subroutine shake_soil

   !> The column of `shake_soil`.
   subroutine take_column(layers, soil, branches, ratio, limit, reference, dashpot, column)
      real(c_double), intent(in) :: layers(:,:), branches(:,:,:), ratio(:), limit(:), &
         reference, dashpot
      integer(c_int), intent(in) :: soil(:)
      type(shear_column_type), intent(out) :: column
      integer :: s

      column%thickness = layers(1, :)
      column%density = layers(2, :)
      column%modulus = layers(3, :)
      column%soil = soil
      column%dashpot = dashpot
      allocate (column%branches(size(ratio)))
      do s = 1, size(ratio)
         associate (own => column%branches(s))
            own%n = size(branches, 1)
            own%strain = branches(:, 1, s)
            own%modulus = branches(:, 2, s)
            own%slipping = branches(:, 3, s)
            if (.not. allocated(error)) call set_body(own, &
               damping_type(ratio=ratio(s), reference=reference), huge(1.0_c_double), limit(s), &
               error)
         end associate
      end do
   end subroutine take_column

end module api_soils
