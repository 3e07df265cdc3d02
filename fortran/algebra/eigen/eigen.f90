! SPDX-License-Identifier: GPL-3.0-or-later
!> Largest and lowest eigenvalues ω² of K x = ω² M x with block-diagonal M = G Gᵀ.
!>
!> ARPACK solves large problems: with S = G⁻¹KG⁻ᵀ for the largest eigenvalues, and with
!> Gᵀ(K − σM)⁻¹G for the lowest; a small negative shift σ permits a singular K.  LAPACK solves small
!> problems.
module dda_eigen
   use dda_kinds, only: wp, long
   use dda_arnoldi, only: operator_type, find_largest_pairs
   use dda_cholesky_double, only: factor_type, analyse, factorise, solve
   use dda_block_matrix, only: block_matrix_type, multiply
   use dda_deflation, only: deflation_type, null_space_type, prepare_deflation, project_out, &
      deflate_vector
   use dda_dense_eigen, only: solve_symmetric_eigen
   use dda_interrupts, only: fail_if_stopped
   use dda_errors, only: error_type, error_solver, fail
   use dda_mass_factor, only: mass_factor_type, factor_mass, scale_matrix, apply_factor, &
      multiply_transposed
   use dda_text, only: to_text
   implicit none
   private
   public :: eigenpairs_type, find_largest_eigenvalue, find_lowest_eigenvalues, &
      find_all_eigenvalues, suggested_tolerance, select_pairs
   public :: shifted_inverse_type, prepare_inverse

   integer, parameter :: dense_blocks = 8          !< largest number of blocks for LAPACK
   integer, parameter :: max_dense_blocks = 300  !< blocks for LAPACK if most modes are wanted
   real(wp), parameter :: low_tolerance = 1.0e-10_wp

   !> Eigenvalues with mass-normalised vectors.
   type :: eigenpairs_type
      integer :: n = 0
      real(wp), allocatable :: value(:)       !< [n] ω², 1/s²
      real(wp), allocatable :: vector(:,:,:)  !< [6,blocks,n], xᵀMx = 1
      !> [n] relative residual of the iterated operator; 0 by LAPACK
      real(wp), allocatable :: residual(:)
      integer(long) :: products = 0           !< number of applications of the operator
   end type eigenpairs_type

   !> The operator S = G⁻¹KG⁻ᵀ.
   type, extends(operator_type) :: scaled_stiffness_type
      type(block_matrix_type) :: matrix
   contains
      procedure :: apply => apply_scaled
   end type scaled_stiffness_type

   !> Gᵀ(K − σM)⁻¹G, with deflated vectors projected out.
   type, extends(operator_type) :: shifted_inverse_type
      type(factor_type) :: factor
      type(mass_factor_type) :: mass
      type(deflation_type) :: deflation
      real(wp) :: shift = 0.0_wp              !< σ ≤ 0, 1/s²
      real(wp), allocatable :: force(:,:)     !< [6,n] workspace
   contains
      procedure :: apply => apply_inverse
   end type shifted_inverse_type

contains

   !> Return a tolerance with affordable cost for n blocks; the spectra of large models are dense.
   pure real(wp) function suggested_tolerance(n) result(tolerance)
      integer, intent(in) :: n  !< number of blocks

      tolerance = 1.0e-10_wp
      if (n > 500) tolerance = 1.0e-6_wp
      if (n > 3000) tolerance = 1.0e-3_wp
   end function suggested_tolerance

   !> Find the largest ω²; the result is a lower bound with an error of second order.
   subroutine find_largest_eigenvalue(stiffness, mass, tolerance, pairs, error)
      type(block_matrix_type), intent(in) :: stiffness  !< K, N/m
      real(wp), intent(in) :: mass(:,:,:)           !< [6,6,n] M
      real(wp), intent(in) :: tolerance             !< tolerance of the residual / ω²
      type(eigenpairs_type), intent(out) :: pairs   !< the largest eigenvalue and its vector
      type(error_type), allocatable, intent(out) :: error  !< M is not definite, or no convergence
      type(scaled_stiffness_type) :: operator
      type(mass_factor_type) :: factor
      real(wp), allocatable :: values(:), vectors(:,:)

      if (stiffness%n <= dense_blocks) then
         call find_all_eigenvalues(stiffness, mass, pairs, error)
         if (.not. allocated(error)) call select_pairs(pairs, [pairs%n])
         return
      end if
      call factor_mass(factor, mass, error)
      if (allocated(error)) return
      operator%matrix = stiffness
      call scale_matrix(factor, operator%matrix)
      call find_largest_pairs(operator, 6*stiffness%n, 1, tolerance, values, vectors, &
         pairs%residual, error)
      if (allocated(error)) return
      pairs%products = operator%products
      call unscale_vectors(factor, values, vectors, pairs)
   end subroutine find_largest_eigenvalue

   !> Find the `count` lowest ω² (or all, if fewer exist), without those of a known null space.
   subroutine find_lowest_eigenvalues(stiffness, mass, count, pairs, error, null_space)
      type(block_matrix_type), intent(in) :: stiffness  !< K, N/m
      real(wp), intent(in) :: mass(:,:,:)           !< [6,6,n] M
      integer, intent(in) :: count  !< requested number of eigenvalues
      type(eigenpairs_type), intent(out) :: pairs   !< pairs in ascending order
      type(error_type), allocatable, intent(out) :: error  !< M is not definite, or no convergence
      type(null_space_type), intent(in), optional :: null_space  !< null vectors of K to omit
      type(shifted_inverse_type) :: operator
      real(wp), allocatable :: values(:), vectors(:,:)
      integer :: available, request, i

      available = 6*stiffness%n
      if (present(null_space)) available = available - null_space%dimension
      request = min(count, available)
      if (stiffness%n <= dense_blocks &
         .or. (request > available/2 .and. stiffness%n <= max_dense_blocks)) then
         call find_all_eigenvalues(stiffness, mass, pairs, error, null_space)
         if (.not. allocated(error)) call select_pairs(pairs, [(i, i=1, min(request, pairs%n))])
         return
      else if (request > available/2) then
         call fail(error, error_solver, to_text(request)//' of '//to_text(available)// &
            ' modes requested, but at most half can be computed')
         return
      end if
      call prepare_inverse(operator, stiffness, mass, error, null_space)
      if (allocated(error)) return
      call find_largest_pairs(operator, 6*stiffness%n, request, low_tolerance, values, vectors, &
         pairs%residual, error)
      if (.not. allocated(error)) call add_missing_copies(operator, values, vectors, &
         pairs%residual, error)
      if (allocated(error)) return
      pairs%products = operator%products
      call unscale_vectors(operator%mass, operator%shift + 1.0_wp/values, vectors, pairs)
   end subroutine find_lowest_eigenvalues

   !> Find all eigenvalues by LAPACK, ascending, without those of a known null space.
   subroutine find_all_eigenvalues(stiffness, mass, pairs, error, null_space)
      type(block_matrix_type), intent(in) :: stiffness  !< K, N/m
      real(wp), intent(in) :: mass(:,:,:)           !< [6,6,n] M
      type(eigenpairs_type), intent(out) :: pairs  !< pairs in ascending order
      type(error_type), allocatable, intent(out) :: error  !< M is not definite, or no convergence
      type(null_space_type), intent(in), optional :: null_space  !< null vectors of K to omit
      type(scaled_stiffness_type) :: operator
      type(mass_factor_type) :: factor
      type(deflation_type) :: deflation
      real(wp), allocatable :: a(:,:), values(:), unit(:)
      integer :: i, size_all

      call factor_mass(factor, mass, error)
      if (allocated(error)) return
      operator%matrix = stiffness
      call scale_matrix(factor, operator%matrix)
      call prepare_deflation(deflation, factor, null_space)
      size_all = 6*stiffness%n
      allocate (a(size_all, size_all), unit(size_all))
      do i = 1, size_all
         call fail_if_stopped(error)
         if (allocated(error)) return
         unit = 0.0_wp
         unit(i) = 1.0_wp
         call project_out(deflation, unit)
         call operator%apply(unit, a(:, i))
         call project_out(deflation, a(:, i))
      end do
      ! After deflation, the null space has the lowest eigenvalues, which are then omitted.
      if (deflation%null_space%dimension > 0) call deflate_matrix(deflation, a)
      call solve_symmetric_eigen(a, values, error)
      if (allocated(error)) return
      i = deflation%null_space%dimension + 1
      allocate (pairs%residual(size_all - i + 1), source=0.0_wp)
      call unscale_vectors(factor, values(i:), a(:, i:), pairs)
   end subroutine find_all_eigenvalues

   !> Subtract s ZZᵀ from a, with s larger than every eigenvalue.
   subroutine deflate_matrix(deflation, a)
      type(deflation_type), intent(in) :: deflation  !< deflation with Z
      real(wp), intent(inout) :: a(:,:)  !< [6n,6n] matrix a
      real(wp) :: unit(size(a, 1)), scale
      integer :: i

      scale = 1.0_wp
      do i = 1, size(a, 1)
         scale = scale + abs(a(i, i))
      end do
      do i = 1, size(a, 1)
         unit = 0.0_wp
         unit(i) = 1.0_wp
         call project_out(deflation, unit)
         a(:, i) = a(:, i) + scale*unit
         a(i, i) = a(i, i) - scale
      end do
   end subroutine deflate_matrix

   !> Factorise K − σM with the least |σ| for which rounding leaves it regular if K is singular.
   subroutine prepare_inverse(operator, stiffness, mass, error, null_space)
      type(shifted_inverse_type), intent(out) :: operator  !< operator that can be applied
      type(block_matrix_type), intent(in) :: stiffness  !< K, N/m
      real(wp), intent(in) :: mass(:,:,:)           !< [6,6,n] M
      type(error_type), allocatable, intent(out) :: error  !< M is not definite, or no convergence
      type(null_space_type), intent(in), optional :: null_space  !< null vectors of K to omit
      real(wp), parameter :: first_shift = 1.0e-12_wp, last_shift = 1.0e-6_wp
      type(block_matrix_type) :: shifted_matrix
      real(wp) :: relative

      call factor_mass(operator%mass, mass, error)
      if (allocated(error)) return
      call prepare_deflation(operator%deflation, operator%mass, null_space)
      allocate (operator%force(6, stiffness%n))
      shifted_matrix = stiffness
      call analyse(operator%factor, shifted_matrix)
      relative = first_shift
      do
         operator%shift = -relative*largest_trace(operator%mass, stiffness)
         shifted_matrix%diagonal = stiffness%diagonal - operator%shift*mass
         call factorise(operator%factor, shifted_matrix, error)
         if (.not. allocated(error) .or. relative >= last_shift) return
         relative = 100*relative
      end do
   end subroutine prepare_inverse

   !> Return the largest trace of a diagonal block of S, which has the magnitude of the largest ω².
   pure real(wp) function largest_trace(mass, stiffness) result(largest)
      type(mass_factor_type), intent(in) :: mass  !< G
      type(block_matrix_type), intent(in) :: stiffness  !< K, N/m
      real(wp) :: trace
      integer :: b, i

      largest = tiny(1.0_wp)
      do b = 1, stiffness%n
         trace = 0.0_wp
         do i = 1, 6
            trace = trace + dot_product(mass%inverse(i, :i, b), &
               matmul(stiffness%diagonal(:i, :i, b), mass%inverse(i, :i, b)))
         end do
         largest = max(largest, trace)
      end do
   end function largest_trace

   !> Add copies of multiple eigenvalues that a Lanczos iteration may have missed.
   !> Known vectors are projected out of each search.  The search ends if no larger value is found.
   subroutine add_missing_copies(operator, values, vectors, residuals, error)
      type(shifted_inverse_type), intent(inout) :: operator  !< found vectors are deflated
      !> [count] eigenvalues, [6n,count] vectors, [count] residuals
      real(wp), intent(inout) :: values(:), vectors(:,:), residuals(:)
      type(error_type), allocatable, intent(out) :: error  !< M is not definite, or no convergence
      real(wp), parameter :: growth = 1.0_wp + 1.0e-7_wp, coarse_tolerance = 1.0e-3_wp
      real(wp), allocatable :: new_value(:), new_vector(:,:), new_residual(:)
      integer :: i, n, count, at

      n = size(vectors, 1)
      count = size(values)
      do i = 1, count
         call deflate_vector(operator%deflation, vectors(:, i))
      end do
      do i = 1, count
         ! A coarse tolerance suffices to show that no larger eigenvalue remains.
         call find_largest_pairs(operator, n, 1, coarse_tolerance, new_value, new_vector, &
            new_residual, error, start_seed=i)
         if (allocated(error)) return
         if (new_value(1)*(1.0_wp + 10*coarse_tolerance) < values(count)) return
         call find_largest_pairs(operator, n, 1, low_tolerance, new_value, new_vector, &
            new_residual, error, start_seed=i)
         if (allocated(error)) return
         if (new_value(1) <= growth*values(count)) return
         call deflate_vector(operator%deflation, new_vector(:, 1))
         at = findloc(values < new_value(1), .true., 1)
         values(at:) = [new_value(1), values(at:count - 1)]
         residuals(at:) = [new_residual(1), residuals(at:count - 1)]
         vectors(:, at + 1:) = vectors(:, at:count - 1)
         vectors(:, at) = new_vector(:, 1)
      end do
   end subroutine add_missing_copies

   !> Transform eigenvectors of the standard problem to eigenvectors of K x = ω² M x.
   subroutine unscale_vectors(factor, values, vectors, pairs)
      type(mass_factor_type), intent(in) :: factor  !< G
      real(wp), intent(in) :: values(:), vectors(:,:)  !< [n] ω²; [6 × blocks, n] vectors
      type(eigenpairs_type), intent(inout) :: pairs  !< pairs; receives values and vectors
      integer :: i, blocks

      blocks = size(factor%g, 3)
      pairs%n = size(values)
      pairs%value = values
      allocate (pairs%vector(6, blocks, pairs%n))
      do i = 1, pairs%n
         call multiply_transposed(factor%inverse, vectors(:, i), pairs%vector(:, :, i))
      end do
   end subroutine unscale_vectors

   !> Retain only the selected pairs, in a given order.
   pure subroutine select_pairs(pairs, order)
      type(eigenpairs_type), intent(inout) :: pairs  !< all pairs; on return, selected pairs
      integer, intent(in) :: order(:)  !< [any] numbers of the selected pairs

      pairs%value = pairs%value(order)
      pairs%residual = pairs%residual(order)
      pairs%vector = pairs%vector(:, :, order)
      pairs%n = size(order)
   end subroutine select_pairs

   !> Multiply a vector by S = G⁻¹KG⁻ᵀ.
   subroutine apply_scaled(self, x, y)
      class(scaled_stiffness_type), intent(inout) :: self  !< S
      real(wp), intent(in) :: x(:)  !< [6n] vector
      real(wp), intent(out) :: y(:)  !< [6n] vector

      call multiply(self%matrix, x, y)
   end subroutine apply_scaled

   !> Multiply a vector by Gᵀ(K − σM)⁻¹G and remove the deflated vectors.
   subroutine apply_inverse(self, x, y)
      class(shifted_inverse_type), intent(inout) :: self  !< operator; its workspace changes
      real(wp), intent(in) :: x(:)  !< [6n] vector
      real(wp), intent(out) :: y(:)  !< [6n] vector
      real(wp) :: clean(size(x))

      clean = x
      call project_out(self%deflation, clean)
      call apply_factor(self%mass, clean, self%force)
      call solve(self%factor, self%force, self%force)
      call multiply_transposed(self%mass%g, self%force, y)
      call project_out(self%deflation, y)
   end subroutine apply_inverse

end module dda_eigen
