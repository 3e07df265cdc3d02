! SPDX-License-Identifier: GPL-3.0-or-later
!> A few of the largest eigenvalues of a symmetric operator, computed by ARPACK.
!>
!> The start vector is fixed and irregular, so that results are bit-identical and neither symmetric
!> nor antisymmetric vectors are missed.  The residual of each returned pair is checked.
module dda_arnoldi
   use dda_kinds, only: wp, long
   use dda_errors, only: error_type, error_solver, fail
   use dda_free_memory, only: require_for_blas
   use dda_arpack, only: dsaupd, dseupd
   use dda_interrupts, only: fail_if_stopped
   use dda_text, only: to_text
   implicit none
   private
   public :: operator_type, find_largest_pairs

   !> A symmetric linear operator.
   type, abstract :: operator_type
      integer(long) :: products = 0  !< number of products A x so far
   contains
      procedure(apply_operator), deferred :: apply
   end type operator_type

   abstract interface
      !> Compute y = A x.
      subroutine apply_operator(self, x, y)
         import :: operator_type, wp
         class(operator_type), intent(inout) :: self  !< A
         real(wp), intent(in) :: x(:)  !< [n] vector
         real(wp), intent(out) :: y(:)  !< [n] vector
      end subroutine apply_operator
   end interface

   !> State of ARPACK between calls.
   type :: iteration_type
      integer :: n, count, basis
      integer :: iparam(11) = 0, ipntr(11) = 0
      real(wp) :: tolerance
      real(wp), allocatable :: v(:,:), resid(:), workd(:), workl(:)
   end type iteration_type

   integer, parameter :: min_basis = 20
   !> restarts × size permitted beyond 100 restarts, at most 3,000; static models need few
   real(wp), parameter :: affordable = 5.0e6_wp

contains

   !> Compute the `count` algebraically largest eigenvalues, descending, with orthonormal vectors.
   subroutine find_largest_pairs(operator, n, count, tolerance, values, vectors, residuals, error, &
      start_seed, max_restarts)
      class(operator_type), intent(inout) :: operator  !< operator; its products are counted
      integer, intent(in) :: n          !< size of the operator
      integer, intent(in) :: count      !< number of eigenvalues, 1 … n−1
      real(wp), intent(in) :: tolerance !< tolerance of residual/eigenvalue
      real(wp), allocatable, intent(out) :: values(:)    !< [count] eigenvalues
      real(wp), allocatable, intent(out) :: vectors(:,:) !< [n,count] vectors
      real(wp), allocatable, intent(out) :: residuals(:) !< [count] ‖Av − λv‖ / |λ|
      type(error_type), allocatable, intent(out) :: error !< error if not converged to the tolerance
      integer, intent(in), optional :: start_seed     !< number that changes the start vector
      integer, intent(in), optional :: max_restarts  !< largest number of restarts, default 3000
      type(iteration_type) :: iteration

      if (count < 1 .or. count >= n) then
         call fail(error, error_solver, 'a problem of size '//to_text(n)// &
            ' is too small to compute '//to_text(count)//' eigenvalues by ARPACK')
         return
      end if
      call prepare_arpack(iteration, n, count, tolerance)
      iteration%iparam(3) = int(min(3000.0_wp, 100.0_wp + affordable/n))
      if (present(max_restarts)) iteration%iparam(3) = max_restarts
      iteration%resid = pseudo_random_vector(n, start_seed)
      call require_for_blas(error)
      if (.not. allocated(error)) call iterate_arpack(iteration, operator, error)
      if (allocated(error)) return
      call extract_pairs(iteration, values, vectors, error)
      if (allocated(error)) return
      call check_pairs(operator, tolerance, values, vectors, residuals, error)
   end subroutine find_largest_pairs

   !> Set the parameters of ARPACK and allocate its workspace.
   subroutine prepare_arpack(iteration, n, count, tolerance)
      type(iteration_type), intent(out) :: iteration  !< state of ARPACK
      integer, intent(in) :: n, count  !< size, requested eigenvalues
      real(wp), intent(in) :: tolerance  !< tolerance of residual/eigenvalue

      iteration%n = n
      iteration%count = count
      iteration%basis = min(n, max(2*count + 10, min_basis))
      iteration%tolerance = max(tolerance, 2*epsilon(1.0_wp))
      iteration%iparam(1) = 1
      iteration%iparam(4) = 1
      iteration%iparam(7) = 1
      associate (basis => iteration%basis)
         allocate (iteration%v(n, basis), iteration%workd(3*n), &
            iteration%workl(basis*(basis + 8)), source=0.0_wp)
      end associate
   end subroutine prepare_arpack

   !> Iterate: supply ARPACK with matrix products until it has finished.
   subroutine iterate_arpack(iteration, operator, error)
      type(iteration_type), intent(inout) :: iteration  !< state of ARPACK
      class(operator_type), intent(inout) :: operator  !< operator; its products are counted
      type(error_type), allocatable, intent(out) :: error  !< ARPACK has not converged
      integer :: ido, info, from, to

      ido = 0
      info = 1
      do
         call dsaupd(ido, 'I', iteration%n, 'LA', iteration%count, iteration%tolerance, &
            iteration%resid, iteration%basis, iteration%v, iteration%n, iteration%iparam, &
            iteration%ipntr, iteration%workd, iteration%workl, size(iteration%workl), info)
         if (abs(ido) /= 1) exit
         call fail_if_stopped(error)
         if (allocated(error)) return
         from = iteration%ipntr(1)
         to = iteration%ipntr(2)
         call operator%apply(iteration%workd(from:from + iteration%n - 1), &
            iteration%workd(to:to + iteration%n - 1))
         operator%products = operator%products + 1
      end do
      if (info == 1) then
         call fail(error, error_solver, 'ARPACK has converged '//to_text(iteration%iparam(5))// &
            ' of '//to_text(iteration%count)//' eigenvalues to '//to_text(iteration%tolerance)// &
            ' after '//to_text(iteration%iparam(3))//' restarts, because the eigenvalues are '// &
            'too close together, or too far below the largest one')
      else if (info /= 0) then
         call fail(error, error_solver, 'ARPACK dsaupd failed with info = '//to_text(info))
      end if
   end subroutine iterate_arpack

   !> Extract eigenvalues and eigenvectors in descending order.
   subroutine extract_pairs(iteration, values, vectors, error)
      type(iteration_type), intent(inout) :: iteration  !< state of ARPACK
      real(wp), allocatable, intent(out) :: values(:), vectors(:,:)  !< [count], [n,count] pairs
      type(error_type), allocatable, intent(out) :: error  !< ARPACK has failed
      logical :: select(iteration%basis)
      integer :: info, count

      count = iteration%count
      allocate (values(count), vectors(iteration%n, count))
      select = .true.
      call dseupd(.true., 'A', select, values, vectors, iteration%n, 0.0_wp, 'I', iteration%n, &
         'LA', count, iteration%tolerance, iteration%resid, iteration%basis, iteration%v, &
         iteration%n, iteration%iparam, iteration%ipntr, iteration%workd, iteration%workl, &
         size(iteration%workl), info)
      if (info /= 0) then
         call fail(error, error_solver, 'ARPACK dseupd failed with info = '//to_text(info))
         return
      end if
      values = values(count:1:-1)
      vectors = vectors(:, count:1:-1)
   end subroutine extract_pairs

   !> Check the residuals of the pairs with the operator, independently of ARPACK.
   subroutine check_pairs(operator, tolerance, values, vectors, residuals, error)
      class(operator_type), intent(inout) :: operator  !< operator; its products are counted
      real(wp), intent(in) :: tolerance, values(:), vectors(:,:)  !< [count], [n,count] pairs
      real(wp), allocatable, intent(out) :: residuals(:)  !< [count] relative residuals
      type(error_type), allocatable, intent(out) :: error  !< a residual is too large
      real(wp), parameter :: slack = 10.0_wp, rounding = 1.0e-12_wp
      real(wp), allocatable :: image(:)
      real(wp) :: scale
      integer :: i

      allocate (image(size(vectors, 1)), residuals(size(values)))
      do i = 1, size(values)
         call operator%apply(vectors(:, i), image)
         operator%products = operator%products + 1
         scale = max(abs(values(i)), tiny(1.0_wp))
         residuals(i) = norm2(image - values(i)*vectors(:, i))/scale
         if (residuals(i) <= slack*tolerance + rounding*max(1.0_wp, abs(values(1))/scale)) cycle
         call fail(error, error_solver, 'eigenvalue '//to_text(i)//' of '//to_text(size(values))// &
            ' has a relative residual of '//to_text(residuals(i))//', allowed '// &
            to_text(tolerance))
         return
      end do
   end subroutine check_pairs

   !> Return reproducible numbers between −1 and 1 by a linear congruence.
   pure function pseudo_random_vector(n, start_seed) result(vector)
      integer, intent(in) :: n  !< length of the vector
      integer, intent(in), optional :: start_seed  !< number that changes the sequence
      real(wp) :: vector(n)
      integer(long), parameter :: modulus = 2147483647_long, factor = 48271_long
      integer(long) :: seed
      integer :: i

      seed = 12345_long
      if (present(start_seed)) seed = seed + 7919_long*int(abs(start_seed), long)
      do i = 1, n
         seed = modulo(factor*seed, modulus)
         vector(i) = 2.0_wp*real(seed, wp)/real(modulus, wp) - 1.0_wp
      end do
   end function pseudo_random_vector

end module dda_arnoldi
