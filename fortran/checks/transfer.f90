! SPDX-License-Identifier: GPL-3.0-or-later
!> Transfer functions of the linearised model between two measured points, for base motion, with the
!> time integration of the run.
!>
!> The forces of springs and dashpots on moving ground are coefficient × motion × factor of the
!> instant (`dda_scheme_response`).  For base motion as a body force, the right-hand side is
!> ω² w_l M x_s, with a unit translation x_s, and the result is the motion relative to the base.
module dda_transfer
   use dda_kinds, only: wp, pi
   use dda_cholesky_double, only: solve
   use dda_dense_eigen, only: solve_symmetric_eigen
   use dda_eigen, only: shifted_inverse_type, prepare_inverse
   use dda_errors, only: error_type, error_input, fail
   use dda_linear_model, only: linear_model_type
   use dda_linear_terms, only: at_end, at_theta, end_dashpot, instants, term_support, term_free_side
   use dda_reduced_model, only: reduced_model_type, weights_type, reduce_model, solve_reduced, &
      weights_at, undamped_weights
   use dda_text, only: to_text
   implicit none
   private
   public :: transfer_type, transfer_peak_type, prepare_transfer
   public :: transfer_at, undamped_transfer_at, transfer_peak

   !> Transfer function, ready for evaluation.
   type :: transfer_type
      type(linear_model_type) :: linear      !< model data in use: scheme, Δt, damping laws
      type(reduced_model_type) :: reduced
      logical :: body_force = .false.        !< base motion acts as a body force
      real(wp) :: base_fraction(2) = 0.0_wp           !< fraction of the base motion at both points
      real(wp), allocatable :: weight(:,:)   !< [2,m] displacements of the basis at the points
      real(wp), allocatable :: omega(:)      !< [m] undamped angular frequencies, rad/s
      character(len=:), allocatable :: text
   end type transfer_type

   !> Peak of the amplification.
   type :: transfer_peak_type
      real(wp) :: frequency = 0.0_wp  !< Hz
      real(wp) :: amplitude = 0.0_wp
      logical :: is_interior = .false.     !< the maximum is not at an end of the band
   end type transfer_peak_type

contains

   !> Prepare x_out(ω)/x_in(ω) for base motion along an axis.
   !> Point 0 is the prescribed motion.
   subroutine prepare_transfer(transfer, linear, points, axes, base_axis, highest_frequency, error)
      type(transfer_type), intent(out) :: transfer  !< prepared transfer function
      type(linear_model_type), intent(in) :: linear  !< linearised model
      integer, intent(in) :: points(2)      !< output and input point; 0: prescribed motion
      integer, intent(in) :: axes(2)        !< axes at both points; 1: x, 2: y
      integer, intent(in) :: base_axis      !< direction of the base motion
      real(wp), intent(in) :: highest_frequency       !< highest frequency of evaluation, Hz
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      real(wp), allocatable :: static(:,:), force(:,:,:)
      integer :: i, j

      if (any(linear%terms%term(:linear%terms%n)%kind == term_free_side)) call fail(error, &
         error_input, 'free-field columns have their own motion, so the model has no single '// &
         'transfer function; run the model, or use kind = '//"'tied' for level ground")
      if (allocated(error)) return
      if (any(points < 0 .or. points > size(linear%points))) call fail(error, error_input, &
         'a transfer function needs two measured points; the model has '// &
         to_text(size(linear%points)))
      if (allocated(error)) return
      call find_base_excitation(transfer, linear, base_axis, static, force, error)
      if (.not. allocated(error)) &
         call reduce_model(transfer%reduced, linear, static, force, highest_frequency, error)
      if (allocated(error)) return
      allocate (transfer%weight(2, transfer%reduced%m), source=0.0_wp)
      do i = 1, 2
         if (points(i) == 0) then
            transfer%base_fraction(i) = 1.0_wp
            cycle
         end if
         associate (b => linear%points(points(i))%block, row => linear%point_rows(axes(i), :, &
            points(i)))
            if (transfer%body_force) transfer%base_fraction(i) = dot_product(row, static(:, b))
            do j = 1, transfer%reduced%m
               transfer%weight(i, j) = dot_product(row, transfer%reduced%basis(:, b, j))
            end do
         end associate
      end do
      deallocate (transfer%reduced%basis)
      transfer%linear%scheme = linear%scheme
      transfer%linear%time_step = linear%time_step
      transfer%linear%dynamic_factor = linear%dynamic_factor
      transfer%linear%damping = linear%damping
      call find_resonances(transfer, error)
      transfer%text = transfer%text//'; '//to_text(transfer%reduced%m)// &
         ' basis vectors, relative residual '//to_text(transfer%reduced%residual)//' up to '// &
         to_text(highest_frequency)//' Hz'
   end subroutine prepare_transfer

   !> Compute the forces for a unit base motion, and the static response to it.
   !> The static response is a translation if all ground terms move together.
   subroutine find_base_excitation(transfer, linear, axis, static, force, error)
      type(transfer_type), intent(inout) :: transfer  !< prepared transfer function
      type(linear_model_type), intent(in) :: linear  !< linearised model
      integer, intent(in) :: axis  !< 1: x, 2: y
      real(wp), allocatable, intent(out) :: static(:,:)   !< [6,n] response
      real(wp), allocatable, intent(out) :: force(:,:,:)  !< [6,n,instants] forces
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      type(shifted_inverse_type) :: inverse
      integer :: n_resisting, n_moving, b

      allocate (static(6, linear%n), force(6, linear%n, instants), source=0.0_wp)
      static(axis, :) = 1.0_wp
      transfer%body_force = linear%base_motion(axis) > 0
      if (transfer%body_force) then
         transfer%text = 'base motion as body force'
         do b = 1, linear%n
            force(:, b, at_theta) = matmul(linear%mass(:, :, b), static(:, b))
         end do
         return
      end if
      call find_ground_forces(linear, axis, force, n_resisting, n_moving)
      if (n_resisting == 0) then
         call fail(error, error_input, 'there is no base, because no fixed point or dashpot '// &
            'supports the model in '//merge('x', 'y', axis == 1)//', and there is no base motion')
      else if (n_moving < n_resisting) then
         transfer%text = to_text(n_moving)//' of '//to_text(n_resisting)//' '// &
            supports_text(linear)//' move'
         call prepare_inverse(inverse, linear%stiffness, linear%mass, error)
         if (.not. allocated(error)) call solve(inverse%factor, force(:, :, at_theta) &
            + force(:, :, at_end), static)
      else
         transfer%text = 'all '//supports_text(linear)//' move together'
      end if
   end subroutine find_base_excitation

   !> Name the kinds of supports of the model.
   pure function supports_text(linear) result(name)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      character(len=:), allocatable :: name

      name = 'fixed points'
      associate (term => linear%terms%term(:linear%terms%n))
         if (any(term%block_b == 0 .and. term%kind /= term_support)) name = 'supports and dashpots'
      end associate
   end function supports_text

   !> Compute the forces for a unit displacement of the ground.
   !> Ground terms with the first motion along the axis move; if no term has a motion, all terms
   !> move.
   pure subroutine find_ground_forces(linear, axis, force, n_resisting, n_moving)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      integer, intent(in) :: axis  !< 1: x, 2: y
      real(wp), intent(inout) :: force(:,:,:)  !< [6,n,instants] forces
      integer, intent(out) :: n_resisting      !< number of terms that resist along the axis
      integer, intent(out) :: n_moving         !< number of terms that move
      integer :: i, motion
      logical :: counts

      n_resisting = 0
      n_moving = 0
      motion = 0
      associate (term => linear%terms%term(:linear%terms%n))
         do i = 1, size(term)
            if (motion == 0 .and. resists_axis(i)) motion = term(i)%motion(axis)
         end do
         do i = 1, size(term)
            if (.not. resists_axis(i)) cycle
            ! The dashpot of a support is part of the support.
            counts = .not. (term(i)%kind == term_support .and. term(i)%instant == end_dashpot)
            if (counts) n_resisting = n_resisting + 1
            if (term(i)%motion(axis) /= motion) cycle
            if (counts) n_moving = n_moving + 1
            associate (part => force(:, term(i)%block_a, term(i)%instant))
               part = part + term(i)%coefficient*term(i)%row_a(axis)*term(i)%row_a
            end associate
         end do
      end associate

   contains

      pure logical function resists_axis(i)  ! total
         integer, intent(in) :: i  !< number of the term

         resists_axis = linear%terms%term(i)%block_b == 0 .and. &
            abs(linear%terms%term(i)%row_a(axis)) > 0.0_wp
      end function resists_axis
   end subroutine find_ground_forces

   !> Find the undamped frequencies of the reduced model, each with the moduli at this frequency.
   subroutine find_resonances(transfer, error)
      type(transfer_type), intent(inout) :: transfer  !< prepared transfer function
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      integer, parameter :: passes = 4
      real(wp) :: matrix(transfer%reduced%m, transfer%reduced%m), square
      type(weights_type) :: weights
      integer :: i, j, pass

      associate (m => transfer%reduced%m)
         matrix = transfer%reduced%stiffness(:m, :m)
         call solve_symmetric_eigen(matrix, transfer%omega, error)
         if (allocated(error)) return
         transfer%omega = sqrt(max(0.0_wp, transfer%omega))
         if (size(transfer%linear%damping) == 0) return
         do i = 1, m
            square = transfer%omega(i)**2
            do pass = 1, passes
               weights = weights_at(transfer%linear, transfer%omega(i)/(2.0_wp*pi))
               transfer%omega(i) = square
               do j = instants + 1, size(weights%part)
                  transfer%omega(i) = transfer%omega(i) + real(weights%part(j)) &
                     *dot_product(matrix(:, i), matmul(transfer%reduced%part(:m, :m, j), &
                     matrix(:, i)))
               end do
               transfer%omega(i) = sqrt(max(0.0_wp, transfer%omega(i)))
            end do
         end do
      end associate
   end subroutine find_resonances

   !> Transfer function at a frequency, with numerical damping; 0 < f < 1/(2Δt).
   complex(wp) function transfer_at(transfer, frequency)
      type(transfer_type), intent(in) :: transfer  !< prepared transfer function
      real(wp), intent(in) :: frequency  !< Hz

      transfer_at = ratio_at(transfer, frequency, weights_at(transfer%linear, frequency))
   end function transfer_at

   !> Transfer function in continuous time without damping, limited near resonances.
   complex(wp) function undamped_transfer_at(transfer, frequency)
      type(transfer_type), intent(in) :: transfer  !< prepared transfer function
      real(wp), intent(in) :: frequency  !< Hz

      undamped_transfer_at = ratio_at(transfer, frequency, undamped_weights(frequency))
   end function undamped_transfer_at

   !> Ratio of the output to the input at a frequency with given factors.
   complex(wp) function ratio_at(transfer, frequency, weights) result(ratio)
      type(transfer_type), intent(in) :: transfer  !< prepared transfer function
      real(wp), intent(in) :: frequency  !< Hz
      type(weights_type), intent(in) :: weights  !< factors in steady vibration
      complex(wp), allocatable :: y(:)
      complex(wp) :: load(instants), response(2)

      load = weights%ground
      if (transfer%body_force) load(at_theta) = (2.0_wp*pi*frequency)**2*weights%load
      call solve_reduced(transfer%reduced, weights, load, y)
      response = transfer%base_fraction + matmul(transfer%weight, y)
      ratio = 0.0_wp
      if (abs(response(2)) > tiny(1.0_wp)) ratio = response(1)/response(2)
   end function ratio_at

   !> Find the largest amplification |H| in a band, refined by golden section.
   subroutine transfer_peak(transfer, lowest, highest, peak)
      type(transfer_type), intent(in) :: transfer  !< prepared transfer function
      real(wp), intent(in) :: lowest, highest  !< Hz
      type(transfer_peak_type), intent(out) :: peak  !< frequency (Hz) and amplitude
      integer, parameter :: steps = 200  !< frequencies of a grid, in addition to the resonances
      real(wp), allocatable :: frequency(:), amplitude(:)
      real(wp) :: a, b
      integer :: i, peak_index

      associate (own => transfer%omega/(2.0_wp*pi))
         frequency = [pack(own, own > lowest .and. own < highest), &
            [(lowest + (highest - lowest)*i/steps, i=0, steps)]]
      end associate
      allocate (amplitude(size(frequency)))
      do i = 1, size(frequency)
         amplitude(i) = abs(transfer_at(transfer, frequency(i)))
      end do
      peak_index = maxloc(amplitude, 1)
      a = maxval(frequency, mask=frequency < frequency(peak_index))
      b = minval(frequency, mask=frequency > frequency(peak_index))
      call refine_maximum(transfer, max(a, lowest), min(b, highest), peak)
      if (amplitude(peak_index) > peak%amplitude) then
         peak%frequency = frequency(peak_index)
         peak%amplitude = amplitude(peak_index)
      end if
      peak%is_interior = min(peak%frequency - lowest, highest - peak%frequency) > &
         1.0e-6_wp*(highest - lowest)
   end subroutine transfer_peak

   !> Find the maximum between two frequencies by golden section.
   subroutine refine_maximum(transfer, lowest, highest, peak)
      type(transfer_type), intent(in) :: transfer  !< prepared transfer function
      real(wp), intent(in) :: lowest, highest  !< Hz
      type(transfer_peak_type), intent(inout) :: peak  !< frequency (Hz) and amplitude
      real(wp), parameter :: golden = 0.5_wp*(sqrt(5.0_wp) - 1.0_wp)
      real(wp) :: a, b, x(2), h(2)
      integer :: i

      a = lowest
      b = highest
      x = [b - golden*(b - a), a + golden*(b - a)]
      h = [abs(transfer_at(transfer, x(1))), abs(transfer_at(transfer, x(2)))]
      do i = 1, 60
         if (h(1) >= h(2)) then
            b = x(2)
            x = [b - golden*(b - a), x(1)]
            h = [abs(transfer_at(transfer, x(1))), h(1)]
         else
            a = x(1)
            x = [x(2), a + golden*(b - a)]
            h = [h(2), abs(transfer_at(transfer, x(2)))]
         end if
         if (b - a <= 1.0e-9_wp*b) exit
      end do
      peak%frequency = x(maxloc(h, 1))
      peak%amplitude = maxval(h)
   end subroutine refine_maximum

end module dda_transfer
