! SPDX-License-Identifier: GPL-3.0-or-later
!> Anderson acceleration of a fixed-point iteration x = g(x), with short memory.
!>
!> For an affine g it is equivalent to GMRES, with one evaluation of g per iteration.
!> D. G. Anderson, J. ACM 12 (1965) 547; H. F. Walker, P. Ni, SIAM J. Numer. Anal. 49 (2011) 1715.
module dda_anderson
   use dda_kinds, only: wp
   use dda_ordered_sums, only: pieces, first_of, last_of, most_pieces, parallel_from
   implicit none
   private
   public :: anderson_type, discard_iterations, accelerate

   integer, parameter :: depth = 10   !< number of stored differences
   integer, parameter :: parallel_length = 6*parallel_from  !< fewest unknowns that use threads
   !> regularisation: fraction of the diagonal added to it in the normal equations
   real(wp), parameter :: regular = depth*epsilon(1.0_wp)

   !> Differences of the last iterations.
   type :: anderson_type
      integer :: count = 0                            !< number of iterations since the start
      real(wp), allocatable :: image(:), residual(:)  !< [n] g and g − x of the last iteration
      real(wp), allocatable :: d_image(:,:), d_residual(:,:)  !< [n, depth] their differences
      real(wp) :: normal(depth, depth) = 0.0_wp  !< products of the columns d_residual
   end type anderson_type

contains

   !> Discard the stored iterations.
   pure subroutine discard_iterations(memory)
      type(anderson_type), intent(inout) :: memory  !< memory of the acceleration

      memory%count = 0
   end subroutine discard_iterations

   !> Compute the next x from the present x and g(x).
   subroutine accelerate(memory, x, image)
      type(anderson_type), intent(inout) :: memory  !< memory; receives this iteration
      real(wp), intent(inout) :: x(:)  !< [n] present x; on return, next x
      real(wp), intent(in) :: image(:)  !< [n] g(x)
      real(wp) :: coefficient(depth), partial(2*depth, most_pieces)
      integer :: n, columns, slot, p

      n = size(x)
      call allocate_memory(memory, n)
      slot = 0
      if (memory%count > 0) slot = modulo(memory%count - 1, depth) + 1
      columns = min(memory%count, depth)
      memory%count = memory%count + 1
      if (n < parallel_length) then
         call store_change(memory, slot, columns, x, image, 1, n, partial(:, 1))
         call solve_normal(memory, slot, columns, partial(:, 1), coefficient)
         call combine_iterates(memory, coefficient(:columns), x, 1, n)
         return
      end if
      !$omp parallel do schedule(static)
      do p = 1, pieces(n)
         call store_change(memory, slot, columns, x, image, first_of(p, n), last_of(p, n), &
            partial(:, p))
      end do
      call solve_normal(memory, slot, columns, sum(partial(:, :pieces(n)), 2), coefficient)
      !$omp parallel do schedule(static)
      do p = 1, pieces(n)
         call combine_iterates(memory, coefficient(:columns), x, first_of(p, n), last_of(p, n))
      end do
   end subroutine accelerate

   !> Store the differences from the last iteration for the unknowns first … last.
   !> Return the products of all columns of d_residual with the new column and with the residual.
   pure subroutine store_change(memory, slot, columns, x, image, first, last, products)
      type(anderson_type), intent(inout) :: memory  !< memory; receives this iteration
      integer, intent(in) :: slot, columns             !< column to store; number of columns
      real(wp), intent(in) :: x(:), image(:)        !< [n] x and g(x)
      integer, intent(in) :: first, last            !< first and last index
      real(wp), intent(out) :: products(2*depth)
      integer :: j

      if (slot > 0) then
         memory%d_image(first:last, slot) = image(first:last) - memory%image(first:last)
         memory%d_residual(first:last, slot) = (image(first:last) - x(first:last)) &
            - memory%residual(first:last)
      end if
      memory%image(first:last) = image(first:last)
      memory%residual(first:last) = image(first:last) - x(first:last)
      products = 0.0_wp
      do j = 1, columns
         products(j) = dot_product(memory%d_residual(first:last, j), &
            memory%d_residual(first:last, slot))
         products(depth + j) = dot_product(memory%d_residual(first:last, j), &
            memory%residual(first:last))
      end do
   end subroutine store_change

   !> Find the coefficients y that minimise ‖residual − Σ y d_residual‖, by the normal equations.
   pure subroutine solve_normal(memory, slot, columns, products, coefficient)
      type(anderson_type), intent(inout) :: memory  !< memory; receives the products
      integer, intent(in) :: slot, columns             !< stored column; number of columns
      real(wp), intent(in) :: products(2*depth)  !< products from `store_change`
      real(wp), intent(out) :: coefficient(depth)

      if (slot > 0) then
         memory%normal(:columns, slot) = products(:columns)
         memory%normal(slot, :columns) = products(:columns)
      end if
      coefficient = products(depth + 1:)
      call solve_definite(memory%normal(:columns, :columns), coefficient(:columns))
   end subroutine solve_normal

   !> Compute the unknowns first … last of the next x.
   pure subroutine combine_iterates(memory, coefficient, x, first, last)
      type(anderson_type), intent(in) :: memory  !< memory with this iteration
      real(wp), intent(in) :: coefficient(:)     !< coefficients of the differences
      real(wp), intent(inout) :: x(:)            !< [n] next iterate
      integer, intent(in) :: first, last         !< first and last index
      integer :: j

      x(first:last) = memory%image(first:last)
      do j = 1, size(coefficient)
         x(first:last) = x(first:last) - coefficient(j)*memory%d_image(first:last, j)
      end do
   end subroutine combine_iterates

   !> Allocate memory for n unknowns, if it is too small.
   subroutine allocate_memory(memory, n)
      type(anderson_type), intent(inout) :: memory  !< memory to allocate
      integer, intent(in) :: n  !< number of unknowns

      if (allocated(memory%image)) then
         if (size(memory%image) >= n) return
         deallocate (memory%image, memory%residual, memory%d_image, memory%d_residual)
      end if
      allocate (memory%image(2*n), memory%residual(2*n), memory%d_image(2*n, depth), &
         memory%d_residual(2*n, depth))
      memory%count = 0
   end subroutine allocate_memory

   !> Solve A y = b by Gauss elimination without pivoting, because A is definite.
   pure subroutine solve_definite(a, y)
      real(wp), intent(in) :: a(:,:)   !< [m,m] A
      real(wp), intent(inout) :: y(:)  !< [m] b; on return, the solution
      real(wp) :: reduced(size(y), size(y)), factor
      integer :: i, j, m

      m = size(y)
      reduced = a
      do j = 1, m
         reduced(j, j) = a(j, j)*(1.0_wp + regular) + tiny(1.0_wp)
      end do
      do j = 1, m
         do i = j + 1, m
            factor = reduced(i, j)/reduced(j, j)
            reduced(i, j:m) = reduced(i, j:m) - factor*reduced(j, j:m)
            y(i) = y(i) - factor*y(j)
         end do
      end do
      do j = m, 1, -1
         y(j) = (y(j) - dot_product(reduced(j, j + 1:m), y(j + 1:m)))/reduced(j, j)
      end do
   end subroutine solve_definite

end module dda_anderson
