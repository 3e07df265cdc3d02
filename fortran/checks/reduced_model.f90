! SPDX-License-Identifier: GPL-3.0-or-later
!> Reduced model for the response of the linearised model to one excitation over a frequency band.
!>
!> In steady vibration (`dda_scheme_response`) the equations are A(ω) x = b with the complex
!> symmetric
!>
!>     A = K + (w_e − 1) K_e + w_c C + w_d C_e + w_m M + Σ (g − 1 + β w_c) K_g + α w_c M_g ,
!>
!> where K_e are springs that act at the end of the step, C and C_e are dashpots, and K_g and M_g
!> belong to the blocks of one damping law, whose complex modulus at the pre-warped frequency is g
!> times the given modulus (`dda_damping`).  The damping is not classical, so real modes do not
!> suffice.  The equations are projected on a real basis, orthonormal in M.  The basis begins with
!> the static response, if it exists, and is extended by the real and imaginary parts of (K + sM)⁻¹
!> times the residual at sample frequencies until the residual is small at all of them.  The shift
!> s, with √s far below the end of the band, permits a singular K, such as of a model on dashpots.
module dda_reduced_model
   use dda_kinds, only: wp, pi
   use dda_cholesky_double, only: solve
   use dda_block_matrix, only: block_matrix_type, multiply
   use dda_eigen, only: shifted_inverse_type, prepare_inverse
   use dda_damping, only: modulus_factor
   use dda_errors, only: error_type, error_solver, fail
   use dda_lapack, only: zsysv
   use dda_linear_model, only: linear_model_type, law_fractions
   use dda_linear_terms, only: linear_term_type, blocks_in, get_row, stretch_of, at_theta, &
      at_end, mean_dashpot, end_dashpot, instants
   use dda_scheme_response, only: steady_type, steady_weights
   use dda_text, only: to_text
   implicit none
   private
   public :: reduced_model_type, weights_type, reduce_model, solve_reduced, weights_at, &
      undamped_weights

   integer, parameter :: max_vectors = 240           !< largest number of vectors of the basis
   integer, parameter :: samples = 16                 !< number of evenly spaced sample frequencies
   integer, parameter :: max_expansions = 60  !< largest number of vectors added at one frequency
   real(wp), parameter :: accuracy = 1.0e-10_wp  !< relative tolerance of (K + sM)⁻¹ residual
   real(wp), parameter :: rounding = 1.0e-8_wp  !< tolerance if rounding prevents a smaller one
   real(wp), parameter :: accepted_residual = 1.0e-5_wp  !< largest accepted relative residual
   real(wp), parameter :: min_independence = 1.0e-8_wp  !< smallest fraction outside the basis
   real(wp), parameter :: shift_ratio = 0.05_wp       !< √s/end of the band

   !> Factors of the parts of A in steady vibration.
   type :: weights_type
      complex(wp) :: inertia = 0.0_wp         !< factor of M, instead of −ω², 1/s²
      complex(wp) :: load = 0.0_wp            !< factor of forces at t₀ + θΔt
      complex(wp) :: ground(instants) = 0.0_wp  !< [instants] factors of ground forces
      !> [instants + 2 laws] factors of terms by instant, then of K_g and M_g of each damping law
      complex(wp), allocatable :: part(:)
   end type weights_type

   !> Projected matrices, and the basis.
   type :: reduced_model_type
      integer :: m = 0                           !< number of vectors of the basis
      real(wp), allocatable :: basis(:,:,:)      !< [6,n,room] orthonormal in M
      real(wp), allocatable :: stiffness(:,:)    !< [room,room] K
      real(wp), allocatable :: part(:,:,:)       !< [room,room,parts] in the order of `weights_type`
      real(wp), allocatable :: force(:,:)        !< [room,instants] b
      real(wp) :: residual = 0.0_wp              !< largest relative residual
   end type reduced_model_type

contains

   !> Reduce a model that is excited by the ground through terms of each instant.
   subroutine reduce_model(reduced, linear, static, force, highest_frequency, error)
      type(reduced_model_type), intent(out) :: reduced  !< projected model
      type(linear_model_type), intent(in) :: linear  !< linearised model
      real(wp), intent(in) :: static(:,:)    !< [6,n] static response, first vector of the basis
      real(wp), intent(in) :: force(:,:,:)   !< [6,n,instants] forces, N/m and N
      real(wp), intent(in) :: highest_frequency        !< end of the band, Hz
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      type(shifted_inverse_type) :: inverse
      type(block_matrix_type) :: shifted_matrix
      integer :: capacity, i
      logical :: is_added

      shifted_matrix = linear%stiffness
      shifted_matrix%diagonal = shifted_matrix%diagonal + &
         (2.0_wp*pi*shift_ratio*highest_frequency)**2*linear%mass
      call prepare_inverse(inverse, shifted_matrix, linear%mass, error)
      if (allocated(error)) return
      capacity = min(max_vectors, 6*linear%n)
      allocate (reduced%basis(6, linear%n, capacity), reduced%force(capacity, size(force, 3)))
      allocate (reduced%stiffness(capacity, capacity), reduced%part(capacity, capacity, instants &
         + 2*size(linear%damping)), source=0.0_wp)
      call add_vector(reduced, linear, force, static, is_added)
      do i = samples, 1, -1
         call fit_frequency(reduced, linear, inverse, force, highest_frequency*i/samples)
      end do
      if (.not. reduced%residual <= accepted_residual) call fail(error, error_solver, &
         'the transfer function has a residual of '//to_text(reduced%residual)// &
         ' with '//to_text(reduced%m)//' basis vectors up to '//to_text(highest_frequency)// &
         ' Hz; choose lower frequencies')
   end subroutine reduce_model

   !> Extend the basis until the residual at a frequency is small.
   subroutine fit_frequency(reduced, linear, inverse, force, frequency)
      type(reduced_model_type), intent(inout) :: reduced  !< projected model
      type(linear_model_type), intent(in) :: linear  !< linearised model
      type(shifted_inverse_type), intent(inout) :: inverse  !< factor of K + sM
      real(wp), intent(in) :: force(:,:,:)  !< [6,n,instants] forces, N/m and N
      real(wp), intent(in) :: frequency  !< Hz
      type(weights_type) :: weights
      complex(wp), allocatable :: y(:)
      real(wp), dimension(6, linear%n) :: re, im, d_re, d_im
      real(wp) :: error, previous_error
      integer :: i
      logical :: is_added(2)

      previous_error = huge(1.0_wp)
      weights = weights_at(linear, frequency)
      do i = 1, max_expansions
         call solve_reduced(reduced, weights, weights%ground, y)
         call residual_of(reduced, linear, weights, force, y, re, im)
         call solve(inverse%factor, re, d_re)
         call solve(inverse%factor, im, d_im)
         error = sqrt(mass_product(linear, d_re, d_re) + mass_product(linear, d_im, d_im)) &
            /max(norm2(abs(y)), tiny(1.0_wp))
         if (error <= accuracy .or. reduced%m == size(reduced%basis, 3)) exit
         if (error <= rounding .and. error > 0.5_wp*previous_error) exit
         previous_error = error
         call add_vector(reduced, linear, force, d_re, is_added(1))
         call add_vector(reduced, linear, force, d_im, is_added(2))
         if (.not. any(is_added)) exit
      end do
      reduced%residual = max(reduced%residual, error)
   end subroutine fit_frequency

   !> Factors of the parts of A at a frequency, which is limited to the Nyquist frequency.
   pure type(weights_type) function weights_at(linear, frequency) result(weights)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      real(wp), intent(in) :: frequency  !< Hz
      real(wp), parameter :: highest_ratio = 0.5_wp*(1.0_wp - 1.0e-9_wp)
      type(steady_type) :: steady
      real(wp) :: omega
      integer :: k

      omega = 2.0_wp*pi*min(abs(frequency), highest_ratio/linear%time_step)
      steady = steady_weights(linear%scheme, omega, linear%time_step, linear%dynamic_factor)
      weights%inertia = steady%inertia
      weights%load = steady%load
      weights%ground(at_theta) = 1.0_wp
      weights%ground(at_end) = steady%end_stiffness
      weights%ground(mean_dashpot) = steady%mean_dashpot
      weights%ground(end_dashpot) = steady%end_dashpot
      allocate (weights%part(instants + 2*size(linear%damping)))
      weights%part(:instants) = weights%ground
      weights%part([at_theta, at_end]) = weights%part([at_theta, at_end]) - 1.0_wp
      omega = 2.0_wp*tan(0.5_wp*omega*linear%time_step)/linear%time_step
      do k = 1, size(linear%damping)
         associate (damping => linear%damping(k))
            weights%part(elastic_index(k)) = modulus_factor(damping, omega) - 1.0_wp &
               + damping%beta*steady%mean_dashpot
            weights%part(mass_index(k)) = damping%alpha*steady%mean_dashpot
         end associate
      end do
   end function weights_at

   !> Index of the part with the elasticity of a damping law.
   pure integer function elastic_index(k)
      integer, intent(in) :: k  !< number of the damping

      elastic_index = instants + 2*k - 1
   end function elastic_index

   !> Index of the part with the mass of a damping law.
   pure integer function mass_index(k)
      integer, intent(in) :: k  !< number of the damping

      mass_index = instants + 2*k
   end function mass_index

   !> Factors of the parts of A in continuous time without damping.
   pure type(weights_type) function undamped_weights(frequency) result(weights)
      real(wp), intent(in) :: frequency  !< Hz

      weights%inertia = -(2.0_wp*pi*frequency)**2
      weights%load = 1.0_wp
      weights%ground([at_theta, at_end]) = 1.0_wp
      weights%part = spread((0.0_wp, 0.0_wp), 1, instants)
   end function undamped_weights

   !> Solve for the response to Σ factor × force vector, in coordinates of the basis.
   subroutine solve_reduced(reduced, weights, load, y)
      type(reduced_model_type), intent(in) :: reduced  !< projected model
      type(weights_type), intent(in) :: weights  !< factors in steady vibration
      complex(wp), intent(in) :: load(:)              !< [instants] factors of the forces
      complex(wp), allocatable, intent(out) :: y(:)   !< [m] response
      complex(wp) :: a(reduced%m, reduced%m), work(32*reduced%m)
      integer :: pivot(reduced%m), i, info

      associate (m => reduced%m)
         a = reduced%stiffness(:m, :m)
         do i = 1, size(weights%part)
            if (abs(weights%part(i)) > 0.0_wp) a = a + weights%part(i)*reduced%part(:m, :m, i)
         end do
         do i = 1, m
            a(i, i) = a(i, i) + weights%inertia
         end do
         y = matmul(reduced%force(:m, :), load)
         if (m == 0) return  ! without basis vectors the response is empty
         call zsysv('L', m, 1, a, m, pivot, y, m, work, size(work), info)
         ! At an undamped resonance the system is singular; rounding limits the solution.
         if (info > 0) y = y/(epsilon(1.0_wp)*abs(weights%inertia))
      end associate
   end subroutine solve_reduced

   !> Compute the real and imaginary parts of b − A x.
   subroutine residual_of(reduced, linear, weights, force, y, re, im)
      type(reduced_model_type), intent(in) :: reduced  !< projected model
      type(linear_model_type), intent(in) :: linear  !< linearised model
      type(weights_type), intent(in) :: weights  !< factors in steady vibration
      real(wp), intent(in) :: force(:,:,:)  !< [6,n,instants] forces, N/m and N
      complex(wp), intent(in) :: y(:)       !< coordinates of the solution in the reduced model
      real(wp), intent(out) :: re(6, linear%n), im(6, linear%n)
      real(wp), dimension(6, linear%n) :: x_re, x_im
      complex(wp) :: pull
      integer :: i, b

      x_re = linear_combination(reduced%basis, real(y))
      x_im = linear_combination(reduced%basis, aimag(y))
      call multiply(linear%stiffness, x_re, re)
      call multiply(linear%stiffness, x_im, im)
      re = linear_combination(force, real(weights%ground)) - re
      im = linear_combination(force, aimag(weights%ground)) - im
      do b = 1, linear%n
         associate (c => weights%inertia, m_re => matmul(linear%mass(:, :, b), x_re(:, b)), &
            m_im => matmul(linear%mass(:, :, b), x_im(:, b)))
            re(:, b) = re(:, b) - (real(c)*m_re - aimag(c)*m_im)
            im(:, b) = im(:, b) - (real(c)*m_im + aimag(c)*m_re)
         end associate
         if (linear%law(b) > 0) call subtract_damping(linear, weights, b, &
            cmplx(x_re(:, b), x_im(:, b), wp), re(:, b), im(:, b))
      end do
      do i = 1, linear%terms%n
         associate (term => linear%terms%term(i))
            pull = -term%coefficient*weights%part(term%instant) &
               *cmplx(stretch_of(term, x_re), stretch_of(term, x_im), wp)
            if (any(term%damped_fraction > 0.0_wp)) pull = pull + weld_damping_force(linear, &
               weights, term, cmplx(stretch_of(term, x_re), stretch_of(term, x_im), wp))
            if (.not. abs(pull) > 0.0_wp) cycle
            call add_term_row(term, real(pull), re)
            call add_term_row(term, aimag(pull), im)
         end associate
      end do
   end subroutine residual_of

   !> Force of a spring of a welded face due to material damping, N/m.
   pure complex(wp) function weld_damping_force(linear, weights, term, stretch) result(force)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      type(weights_type), intent(in) :: weights  !< factors in steady vibration
      type(linear_term_type), intent(in) :: term  !< term of the model
      complex(wp), intent(in) :: stretch          !< extension, m
      real(wp) :: fraction(size(linear%damping))
      integer :: k

      fraction = law_fractions(linear, term)
      force = 0.0_wp
      do k = 1, size(fraction)
         force = force - term%coefficient*fraction(k)*weights%part(elastic_index(k))*stretch
      end do
   end function weld_damping_force

   !> Subtract the damping part of A x from the residual of block b.
   pure subroutine subtract_damping(linear, weights, b, x, re, im)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      type(weights_type), intent(in) :: weights  !< factors in steady vibration
      integer, intent(in) :: b  !< number of the block
      complex(wp), intent(in) :: x(6)  !< motion of the block
      real(wp), intent(inout) :: re(6), im(6)  !< residual of the block
      complex(wp) :: force(6)

      associate (k => linear%law(b))
         force = weights%part(mass_index(k))*matmul(linear%mass(:, :, b), x)
         force(4:6) = force(4:6) + weights%part(elastic_index(k)) &
            *matmul(linear%elastic(:, :, b), x(4:6))
      end associate
      re = re - real(force)
      im = im - aimag(force)
   end subroutine subtract_damping

   !> Compute Σ factor_i × vector_i.
   pure function linear_combination(vectors, factors) result(combination)
      real(wp), intent(in) :: vectors(:,:,:), factors(:)
      real(wp) :: combination(size(vectors, 1), size(vectors, 2))
      integer :: j

      combination = 0.0_wp
      do j = 1, size(factors)
         if (abs(factors(j)) > 0.0_wp) combination = combination + factors(j)*vectors(:, :, j)
      end do
   end function linear_combination

   !> Add c times the row u of a term to x.
   pure subroutine add_term_row(term, c, x)
      type(linear_term_type), intent(in) :: term  !< term of the list
      real(wp), intent(in) :: c          !< factor
      real(wp), intent(inout) :: x(:,:)  !< [6,n] sum
      real(wp) :: row(6)
      integer :: k, b

      do k = 1, blocks_in(term)
         call get_row(term, k, b, row)
         x(:, b) = x(:, b) + c*row
      end do
   end subroutine add_term_row

   !> Compute xᵀMy.
   pure real(wp) function mass_product(linear, x, y) result(total)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      real(wp), intent(in) :: x(:,:), y(:,:)
      integer :: b

      total = 0.0_wp
      do b = 1, linear%n
         total = total + dot_product(x(:, b), matmul(linear%mass(:, :, b), y(:, b)))
      end do
   end function mass_product

   !> Orthonormalise a vector, append it to the basis and extend the projected matrices.
   !> A vector that is almost linearly dependent, or for which memory is lacking, is skipped.
   subroutine add_vector(reduced, linear, force, vector, is_added)
      type(reduced_model_type), intent(inout) :: reduced  !< projected model
      type(linear_model_type), intent(in) :: linear  !< linearised model
      real(wp), intent(in) :: force(:,:,:), vector(:,:)  !< [6,n,instants] N/m, N; [6,n] vector
      logical, intent(out) :: is_added  !< the vector was appended
      real(wp) :: v(6, linear%n), initial_length, length
      integer :: pass, j

      is_added = .false.
      if (reduced%m == size(reduced%basis, 3)) return
      v = vector
      initial_length = sqrt(mass_product(linear, v, v))
      if (.not. initial_length > 0.0_wp) return
      v = v/initial_length
      length = 1.0_wp
      do pass = 1, 3
         do j = 1, reduced%m
            v = v - mass_product(linear, reduced%basis(:, :, j), v)*reduced%basis(:, :, j)
         end do
         length = length*sqrt(mass_product(linear, v, v))
         if (.not. length > min_independence) return
         v = v/sqrt(mass_product(linear, v, v))
      end do
      reduced%m = reduced%m + 1
      reduced%basis(:, :, reduced%m) = v
      call extend_projection(reduced, linear, force, v)
      is_added = .true.
   end subroutine add_vector

   !> Compute the rows and columns of the projected matrices for the last vector v.
   subroutine extend_projection(reduced, linear, force, v)
      type(reduced_model_type), intent(inout) :: reduced  !< projected model
      type(linear_model_type), intent(in) :: linear  !< linearised model
      real(wp), intent(in) :: force(:,:,:), v(:,:)
      real(wp) :: product(6, linear%n, 0:instants)
      integer :: i, j, m

      call multiply(linear%stiffness, v, product(:, :, 0))
      product(:, :, 1:) = 0.0_wp
      do i = 1, linear%terms%n
         associate (term => linear%terms%term(i))
            call add_term_row(term, term%coefficient*stretch_of(term, v), &
               product(:, :, term%instant))
         end associate
      end do
      m = reduced%m
      do j = 1, m
         reduced%stiffness(m, j) = sum(reduced%basis(:, :, j)*product(:, :, 0))
         reduced%stiffness(j, m) = reduced%stiffness(m, j)
         do i = 1, instants
            reduced%part(m, j, i) = sum(reduced%basis(:, :, j)*product(:, :, i))
            reduced%part(j, m, i) = reduced%part(m, j, i)
         end do
      end do
      do j = 1, size(force, 3)
         reduced%force(m, j) = sum(v*force(:, :, j))
      end do
      if (size(linear%damping) > 0) call extend_damping_projection(reduced, linear, v)
   end subroutine extend_projection

   !> Compute the rows and columns of the projected damping parts for the last vector.
   subroutine extend_damping_projection(reduced, linear, v)
      type(reduced_model_type), intent(inout) :: reduced  !< projected model
      type(linear_model_type), intent(in) :: linear  !< linearised model
      real(wp), intent(in) :: v(:,:)
      real(wp) :: elastic(3), inertial(6)
      integer :: b, i, j, k

      do b = 1, linear%n
         if (linear%law(b) == 0) cycle
         elastic = matmul(linear%elastic(:, :, b), v(4:6, b))
         inertial = matmul(linear%mass(:, :, b), v(:, b))
         associate (m => reduced%m, of_k => elastic_index(linear%law(b)), &
            of_m => mass_index(linear%law(b)))
            do j = 1, m
               reduced%part(m, j, of_k) = reduced%part(m, j, of_k) &
                  + dot_product(reduced%basis(4:6, b, j), elastic)
               reduced%part(m, j, of_m) = reduced%part(m, j, of_m) &
                  + dot_product(reduced%basis(:, b, j), inertial)
            end do
         end associate
      end do
      do i = 1, linear%terms%n
         associate (term => linear%terms%term(i), fraction => law_fractions(linear, &
            linear%terms%term(i)), m => reduced%m)
            do k = 1, size(fraction)
               if (.not. fraction(k) > 0.0_wp) cycle
               do j = 1, m
                  reduced%part(m, j, elastic_index(k)) = reduced%part(m, j, elastic_index(k)) &
                     + fraction(k)*term%coefficient*stretch_of(term, v) &
                     *stretch_of(term, reduced%basis(:, :, j))
               end do
            end do
         end associate
      end do
      do j = 1, reduced%m
         reduced%part(j, reduced%m, instants + 1:) = reduced%part(reduced%m, j, instants + 1:)
      end do
   end subroutine extend_damping_projection

end module dda_reduced_model
