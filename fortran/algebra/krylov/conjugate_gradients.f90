! SPDX-License-Identifier: GPL-3.0-or-later
!> Preconditioned conjugate gradients on 6×6 blocks.
!>
!> The preconditioner applies z = P⁻¹ r: with the inverse diagonal blocks, or with a lagged Cholesky
!> factor in single precision.
module dda_conjugate_gradients
   use dda_kinds, only: wp
   use dda_block_matrix, only: block_matrix_type, multiply
   use dda_block_vectors, only: add_multiple, multiply_and_add
   use dda_interrupts, only: stop_within_step
   use dda_ordered_sums, only: inner_product, parallel_from
   implicit none
   private
   public :: preconditioner_type, workspace_type, make_workspace, iterate_to_solution

   !> iterations for which the updated residual is accurate
   integer, parameter :: trusted_iterations = 10
   real(wp), parameter :: accepted_drift = 10.0_wp  !< accepted ratio of true to updated residual

   !> An approximate inverse of the matrix.
   type, abstract :: preconditioner_type
   contains
      procedure(apply_type), deferred :: apply
   end type preconditioner_type

   abstract interface
      !> Compute z = P⁻¹ r.
      subroutine apply_type(self, n, r, z)
         import :: preconditioner_type, wp
         class(preconditioner_type), intent(inout) :: self  !< P
         integer, intent(in) :: n  !< number of block rows
         real(wp), intent(in) :: r(6, n)  !< residual
         real(wp), intent(out) :: z(6, n)  !< preconditioned residual
      end subroutine apply_type
   end interface

   !> Vectors of the iteration.
   type :: workspace_type
      !> [6,n] residual r; P⁻¹ r, then K p; direction p, or K x
      real(wp), allocatable :: r(:,:), z(:,:), p(:,:)
   end type workspace_type

contains

   !> Allocate vectors for n block rows, if not yet allocated.
   subroutine make_workspace(work, n)
      type(workspace_type), intent(inout) :: work  !< vectors to allocate
      integer, intent(in) :: n  !< number of block rows

      if (allocated(work%r)) then
         if (size(work%r, 2) == n) return
         deallocate (work%r, work%z, work%p)
      end if
      allocate (work%r(6, n), work%z(6, n), work%p(6, n), source=0.0_wp)
   end subroutine make_workspace

   !> Solve K x = b from the given x, until ‖r‖ ≤ tolerance·size or ‖r‖ ≤ reduction·‖first r‖.
   !>
   !> After `trusted_iterations`, the residual is recomputed, because the updated residual may
   !> differ.
   subroutine iterate_to_solution(matrix, preconditioner, b, size, x, tolerance, reduction, limit, &
      work, iterations, residual, success)
      type(block_matrix_type), intent(in) :: matrix  !< K
      class(preconditioner_type), intent(inout) :: preconditioner  !< its workspace changes
      real(wp), intent(in) :: b(6, matrix%n)  !< right-hand side
      real(wp), intent(in) :: size  !< reference value of residuals, at least ‖b‖
      real(wp), intent(inout) :: x(6, matrix%n)  !< first guess; on return, solution
      real(wp), intent(in) :: tolerance, reduction !< limits of ‖r‖/size and of ‖r‖/‖first r‖
      integer, intent(in) :: limit               !< largest number of iterations
      type(workspace_type), intent(inout) :: work  !< vectors of the iteration
      integer, intent(out) :: iterations  !< number of iterations
      real(wp), intent(out) :: residual          !< reached ‖r‖/size
      logical, intent(out) :: success             !< the requested residual is reached
      real(wp) :: target, slope, old_slope, alpha
      integer :: n

      n = matrix%n
      iterations = 0
      residual = 0.0_wp
      success = .true.
      if (size <= 0.0_wp) then
         x = 0.0_wp
         return
      end if
      target = tolerance*size
      call find_residual(matrix, b, x, work)
      slope = 1.0_wp
      do
         residual = sqrt(inner_product(n, work%r, work%r))
         if (iterations == 0) target = max(target, reduction*residual)
         if (residual <= target .or. iterations == limit .or. .not. residual <= huge(1.0_wp)) exit
         if (is_stop_requested(n)) exit
         call preconditioner%apply(n, work%r, work%z)
         old_slope = slope
         slope = inner_product(n, work%r, work%z)
         call multiply_and_add(n, work%z, merge(0.0_wp, slope/old_slope, iterations == 0), work%p)
         call multiply(matrix, work%p, work%z)
         alpha = slope/inner_product(n, work%p, work%z)
         call add_multiple(n, alpha, work%p, x)
         call add_multiple(n, -alpha, work%z, work%r)
         iterations = iterations + 1
      end do
      if (iterations > trusted_iterations) then
         call find_residual(matrix, b, x, work)
         residual = sqrt(inner_product(n, work%r, work%r))
         target = accepted_drift*target
      end if
      success = residual <= target .and. residual <= huge(1.0_wp)
      residual = residual/size
   end subroutine iterate_to_solution

   !> .true. if a stop is requested; always .false. in small systems.
   logical function is_stop_requested(n)
      integer, intent(in) :: n  !< number of block rows

      is_stop_requested = n >= parallel_from
      if (is_stop_requested) is_stop_requested = stop_within_step()
   end function is_stop_requested

   !> Compute r = b − K x.
   subroutine find_residual(matrix, b, x, work)
      type(block_matrix_type), intent(in) :: matrix  !< K
      real(wp), intent(in) :: b(6, matrix%n), x(6, matrix%n)  !< right-hand side, iterate
      type(workspace_type), intent(inout) :: work  !< vectors; r is set

      call multiply(matrix, x, work%r)
      call multiply_and_add(matrix%n, b, -1.0_wp, work%r)
   end subroutine find_residual

end module dda_conjugate_gradients
