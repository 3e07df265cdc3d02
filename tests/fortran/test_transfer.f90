! SPDX-License-Identifier: GPL-3.0-or-later
!> Transfer functions: the paper's layered sites, the same from time stepping, and a large model.
module test_transfer
   use dda_kinds, only: wp, pi
   use dda_baseline, only: baseline_type, make_motion_curve, acceleration_at
   use dda_input, only: read_model
   use dda_linear_model, only: linear_model_type, linearise
   use dda_linear_terms, only: at_end, end_dashpot, instants, term_support
   use dda_measure, only: measure_point
   use dda_model, only: model_type
   use dda_scheme, only: scheme_type
   use dda_reduced_model, only: solve_reduced, weights_at
   use dda_simulation, only: simulation_type
   use dda_stages, only: begin_simulation
   use dda_time_step, only: advance
   use dda_transfer, only: transfer_type, transfer_peak_type, prepare_transfer, transfer_at, &
      undamped_transfer_at, transfer_peak
   use check_models, only: layered_site, layered_site_of_table_2, brick_wall, linear_of
   use systems, only: dense_of
   use testing, only: case, check, check_close, check_fails, check_no_error, error
   implicit none

   real(wp), parameter :: probed(5) = [1.0_wp, 8.0_wp, 13.9_wp, 23.0_wp, 42.0_wp]  !< Hz
   type(linear_model_type) :: linear
   type(transfer_type) :: transfer
   type(transfer_peak_type) :: peak

contains

   subroutine time_steps()
      call time_stepping(.false., 1.0_wp)
      call time_stepping(.true., 1.0_wp)
      call time_stepping(.false., 0.98_wp)
      call time_stepping(.false., 1.0_wp, 'damping_ratio=0.05, reference_frequency=14.2')
      call time_stepping(.true., 1.0_wp, 'damping_ratio=0.03, rayleigh_frequencies=5.0, 20.0')
   end subroutine time_steps

   !> Paper figures 15 and 16, exact: DDA there gives 29.07 @ 13.95 and 28.76 @ 14.23 Hz.
   subroutine layered_sites()
      call check_site(layered_site(), 29.065_wp, 13.948_wp)
      call check_site(layered_site_of_table_2(), 28.761_wp, 14.238_wp)
   end subroutine layered_sites

   subroutine check_site(text, amplitude, frequency)
      character(len=*), intent(in) :: text
      real(wp), intent(in) :: amplitude, frequency

      call linear_of(linear, text, 'closed')
      call prepare_transfer(transfer, linear, [2, 1], [1, 1], 1, 50.0_wp, error)
      call check_no_error(error, 'transfer')
      call transfer_peak(transfer, 10.0_wp, 20.0_wp, peak)
      call check(peak%is_interior, 'a peak inside the band')
      call check_close(peak%amplitude, amplitude, 'amplification', relative=1.0e-3_wp)
      call check_close(peak%frequency, frequency, 'resonance', relative=1.0e-3_wp)
      call check_close(abs(transfer_at(transfer, 1.0e-3_wp)), 1.0_wp, 'static', absolute=1.0e-6_wp)
      call check(abs(undamped_transfer_at(transfer, peak%frequency)) > 2*peak%amplitude, &
         'higher without damping')
   end subroutine check_site

   !> Table I in the midpoint rule under a rigid base, with the same damping ratio at all
   !> frequencies: peaks computed by another program from a body of its own fit.
   subroutine constant_damping_peaks()
      character(len=*), parameter :: ratio(4) = ['0.01', '0.05', '0.10', '0.20']
      real(wp), parameter :: amplitude(4) = [66.073_wp, 13.2507_wp, 6.6820_wp, 3.4539_wp]
      real(wp), parameter :: frequency(4) = [13.950_wp, 13.964_wp, 14.014_wp, 14.220_wp]
      character(len=:), allocatable :: text
      integer :: i

      do i = 1, size(ratio)
         call case('Table I with a damping ratio of '//ratio(i))
         text = layered_site('damping_ratio='//ratio(i)//', reference_frequency=14.2')
         text(index(text, 'y=14.5'):index(text, 'y=14.5') + 5) = 'y=15.0'
         call linear_of(linear, text, 'closed')
         linear%scheme = scheme_type(0.5_wp, 0.5_wp)
         call prepare_transfer(transfer, linear, [2, 1], [1, 1], 1, 30.0_wp, error)
         call check_no_error(error, 'transfer')
         call transfer_peak(transfer, 10.0_wp, 20.0_wp, peak)
         call check_close(peak%amplitude, amplitude(i), 'amplification', relative=5.0e-4_wp)
         call check_close(peak%frequency, frequency(i), 'resonance', absolute=5.0e-3_wp)
      end do
   end subroutine constant_damping_peaks

   !> The ratio of two histories of a run, at any frequency, is the transfer function.
   subroutine time_stepping(body_force, dynamic_factor, damping)
      logical, intent(in) :: body_force
      real(wp), intent(in) :: dynamic_factor
      character(len=*), intent(in), optional :: damping  !< in &material
      type(simulation_type) :: simulation
      complex(wp) :: ratio(size(probed)), expected(size(probed))
      integer :: i

      call case('time stepping'//merge(' with body force', '                ', body_force))
      call shaken(simulation, body_force, dynamic_factor, damping)
      call linearise(linear, simulation, 'closed', error)
      call check_no_error(error, 'linearise')
      call prepare_transfer(transfer, linear, [2, 1], [1, 1], 1, 50.0_wp, error)
      call check_no_error(error, 'transfer')
      if (allocated(error)) return
      call measure_ratio(simulation, body_force, ratio)
      do i = 1, size(probed)
         expected(i) = transfer_at(transfer, probed(i))
      end do
      call check_close(real(ratio), real(expected), 'real part', relative=2.0e-4_wp)
      call check_close(aimag(ratio), aimag(expected), 'imaginary part', relative=2.0e-4_wp)
   end subroutine time_stepping

   !> The layered site with a short pulse at its base.
   subroutine shaken(simulation, body_force, dynamic_factor, damping)
      type(simulation_type), intent(out) :: simulation
      logical, intent(in) :: body_force
      real(wp), intent(in) :: dynamic_factor
      character(len=*), intent(in), optional :: damping
      integer, parameter :: samples = 41
      real(wp), parameter :: height = 1.0e-6_wp
      type(model_type) :: model
      real(wp) :: pulse(samples)
      integer :: i

      call read_model(model, 'text.nml', layered_site(damping), error)
      call check_no_error(error, 'input')
      pulse = [(height*sin(pi*(i - 1)/(samples - 1))**4, i=1, samples)]
      deallocate (model%motions)
      allocate (model%motions(1))
      if (body_force) then
         model%control%base_motion(1) = 1
         call make_motion_curve(model%motions(1)%curve, 'acceleration', 1.0e4_wp*pulse, 1.0e-3_wp, &
            error, baseline_type(order=0))
      else
         model%fixed_points%motion(1) = 1
         call make_motion_curve(model%motions(1)%curve, 'displacement', pulse, 1.0e-3_wp, error, &
            baseline_type(order=0))
      end if
      call check_no_error(error, 'motion')
      model%control%dynamic_factor = dynamic_factor
      call begin_simulation(simulation, model, error)
      call check_no_error(error, 'start')
   end subroutine shaken

   !> Fourier sums of both points over a run that dies away.
   subroutine measure_ratio(simulation, body_force, ratio)
      type(simulation_type), intent(inout) :: simulation
      logical, intent(in) :: body_force
      complex(wp), intent(out) :: ratio(:)
      integer, parameter :: steps = 8000
      complex(wp) :: sums(size(ratio), 3), turn(size(ratio))
      real(wp) :: output(2), input(2), rate(2), bend(2), base_motion
      integer :: i

      sums = 0.0_wp
      base_motion = 0.0_wp
      do i = 1, steps
         call advance(simulation, error)
         if (allocated(error)) then
            call check_no_error(error, 'step')
            return
         end if
         call measure_point(simulation%blocks, simulation%model%points(2), output, rate, bend)
         call measure_point(simulation%blocks, simulation%model%points(1), input, rate, bend)
         if (body_force) base_motion = acceleration_at(simulation%model%motions(1)%curve, &
            simulation%time)
         turn = exp(cmplx(0.0_wp, -2.0_wp*pi*probed*simulation%time, wp))
         sums(:, 1) = sums(:, 1) + output(1)*turn
         sums(:, 2) = sums(:, 2) + input(1)*turn
         sums(:, 3) = sums(:, 3) - base_motion*turn/(2.0_wp*pi*probed)**2
      end do
      ratio = (sums(:, 1) + sums(:, 3))/(sums(:, 2) + sums(:, 3))
   end subroutine measure_ratio

   subroutine peak_against_a_fine_grid()
      real(wp) :: largest
      integer :: i

      call linear_of(linear, layered_site(), 'closed')
      call prepare_transfer(transfer, linear, [2, 1], [1, 1], 1, 50.0_wp, error)
      call transfer_peak(transfer, 30.0_wp, 60.0_wp, peak)
      largest = 0.0_wp
      do i = 0, 30000
         largest = max(largest, abs(transfer_at(transfer, 30.0_wp + 1.0e-3_wp*i)))
      end do
      call check_close(peak%amplitude, largest, 'second peak', relative=1.0e-6_wp)
      call transfer_peak(transfer, 16.0_wp, 18.0_wp, peak)
      call check(.not. peak%is_interior, 'the flank of a peak is not a peak')
   end subroutine peak_against_a_fine_grid

   !> A wall answers as a direct solution of all its equations does.
   subroutine ritz_vectors()
      complex(wp) :: x(6), expected
      integer :: i

      call linear_of(linear, brick_wall(6, 8, '1.0e10', ''), 'closed')
      call prepare_transfer(transfer, linear, [2, 1], [1, 1], 1, 200.0_wp, error)
      call check_no_error(error, 'transfer')
      call check(transfer%reduced%m < 6*linear%n, 'fewer vectors than modes')
      call check(transfer%reduced%residual < 1.0e-8_wp, 'residual')
      x = [1.0_wp, 20.0_wp, 60.0_wp, 65.0_wp, 130.0_wp, 190.0_wp]
      do i = 1, size(x)
         call solve_directly(real(x(i)), expected)
         call check_close(abs(transfer_at(transfer, real(x(i))) - expected), 0.0_wp, &
            'against a direct solution', absolute=1.0e-6_wp*abs(expected))
      end do
   end subroutine ritz_vectors

   !> For any band, residuals at the level of rounding require no vectors.
   subroutine rounding_adds_no_vectors()
      integer, parameter :: ends = 200
      integer :: i, largest_count

      call linear_of(linear, layered_site(), 'closed')
      largest_count = 0
      do i = 1, ends
         call prepare_transfer(transfer, linear, [2, 1], [1, 1], 1, 24.0_wp + 2.0_wp*i/ends, error)
         call check_no_error(error, 'transfer')
         largest_count = max(largest_count, transfer%reduced%m)
      end do
      call check(largest_count <= 40, 'vectors')
   end subroutine rounding_adds_no_vectors

   !> [K + iω̃ C + ω̃ i (1 − 1/z)/Δt M] x = F + iω̃ F_c by LAPACK, dense and complex: DDA with
   !> supports whose dashpots C act on the velocity at the end of the step.
   subroutine solve_directly(frequency, ratio)
      real(wp), intent(in) :: frequency
      complex(wp), intent(out) :: ratio
      interface
         !> LAPACK: dense complex solution.
         subroutine zgesv(n, nrhs, a, lda, ipiv, b, ldb, info)
            import :: wp
            integer, intent(in) :: n, nrhs, lda, ldb
            complex(wp), intent(inout) :: a(lda, *), b(ldb, *)
            integer, intent(out) :: ipiv(*), info
         end subroutine zgesv
      end interface
      complex(wp) :: a(6*linear%n, 6*linear%n), x(6, linear%n), rate, inertia, factor
      integer :: i, b, info, pivot(6*linear%n)

      associate (dt => linear%time_step, turn => 2.0_wp*pi*frequency*linear%time_step)
         rate = cmplx(0.0_wp, 2.0_wp/dt*tan(0.5_wp*turn), wp)
         inertia = rate*(1.0_wp - exp(cmplx(0.0_wp, -turn, wp)))/dt
      end associate
      a = dense_of(linear%stiffness)
      do b = 1, linear%n
         a(6*b - 5:6*b, 6*b - 5:6*b) = a(6*b - 5:6*b, 6*b - 5:6*b) + inertia*linear%mass(:, :, b)
      end do
      x = 0.0_wp
      do i = 1, linear%terms%n
         associate (term => linear%terms%term(i))
            if (term%kind /= term_support) cycle
            b = term%block_a
            factor = term%coefficient*merge(rate, (1.0_wp, 0.0_wp), term%instant == end_dashpot)
            if (term%instant == end_dashpot) a(6*b - 5:6*b, 6*b - 5:6*b) = &
               a(6*b - 5:6*b, 6*b - 5:6*b) + factor*spread(term%row_a, 2, 6) &
               *spread(term%row_a, 1, 6)
            if (term%row_a(1) == 1.0_wp) x(:, b) = x(:, b) + factor*term%row_a
         end associate
      end do
      call zgesv(6*linear%n, 1, a, 6*linear%n, pivot, x, 6*linear%n, info)
      call check(info == 0, 'zgesv')
      ratio = sum(linear%point_rows(1, :, 2)*x(:, linear%points(2)%block)) &
         /sum(linear%point_rows(1, :, 1)*x(:, linear%points(1)%block))
   end subroutine solve_directly

   !> Only some of the fixed points move: the static answer is solved for.
   subroutine supports_that_move_apart()
      complex(wp), allocatable :: y(:)
      integer :: i

      call linear_of(linear, layered_site(), 'closed')
      do i = 1, linear%terms%n
         associate (term => linear%terms%term(i))
            if (term%kind == term_support .and. any(term%source == [1, 2])) term%motion = 1
         end associate
      end do
      call prepare_transfer(transfer, linear, [2, 1], [1, 1], 1, 50.0_wp, error)
      call check_no_error(error, 'transfer')
      call check(index(transfer%text, '2 of 4 fixed points move') == 1, 'in words')
      call solve_reduced(transfer%reduced, weights_at(linear, 1.0e-3_wp), &
         [(cmplx(merge(1, 0, i == at_end), 0, wp), i=1, instants)], y)
      call check_close(abs(sum(transfer%weight(2, :)*y)), 0.5_wp, &
         'the middle of the base follows half', relative=1.0e-3_wp)
      call check_close(abs(transfer_at(transfer, 1.0e-3_wp)), 1.0_wp, 'static', absolute=1.0e-3_wp)
   end subroutine supports_that_move_apart

   subroutine no_transfer_function()
      call linear_of(linear, layered_site(), 'closed')
      call prepare_transfer(transfer, linear, [3, 1], [1, 1], 1, 50.0_wp, error)
      call check_fails(error, 'measured points')
      linear%terms%n = 0
      call prepare_transfer(transfer, linear, [2, 1], [1, 1], 1, 50.0_wp, error)
      call check_fails(error, 'no base')
   end subroutine no_transfer_function

end module test_transfer
