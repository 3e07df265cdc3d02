! SPDX-License-Identifier: GPL-3.0-or-later
!> Anderson acceleration of a fixed point x = g(x), of short memory.
!>
!> For an affine g it does what GMRES would, at one evaluation of g an iteration.
!> D. G. Anderson, J. ACM 12 (1965) 547; H. F. Walker, P. Ni, SIAM J. Numer. Anal. 49 (2011) 1715.
module dda_anderson
   use dda_kinds, only: wp
   implicit none
   private
   public :: anderson_type, forget, accelerate

   integer, parameter :: depth = 6                    !< differences remembered
   !> share of the diagonal added to the normal equations
   real(wp), parameter :: regular = 1.0e-14_wp

   !> Differences of the last iterations.
   type :: anderson_type
      integer :: count = 0                            !< iterations since the start
      real(wp), allocatable :: image(:), residual(:)  !< [n] g and g − x of the iteration before
      real(wp), allocatable :: d_image(:,:), d_residual(:,:)  !< [n, depth]
   end type anderson_type

contains

   !> Restart without memory.
   pure subroutine forget(memory)
      type(anderson_type), intent(inout) :: memory  !< forgets its iterations

      memory%count = 0
   end subroutine forget

   !> The next x, from the present x and g(x).
   subroutine accelerate(memory, x, image)
      type(anderson_type), intent(inout) :: memory  !< gets this iteration
      real(wp), intent(inout) :: x(:)  !< [n] in the units of the unknowns
      real(wp), intent(in) :: image(:)  !< [n] g(x)
      real(wp) :: share(depth)
      integer :: n, used, slot, j

      n = size(x)
      call reserve(memory, n)
      if (memory%count > 0) then
         slot = modulo(memory%count - 1, depth) + 1
         memory%d_image(:n, slot) = image - memory%image(:n)
         memory%d_residual(:n, slot) = (image - x) - memory%residual(:n)
      end if
      used = min(memory%count, depth)
      memory%count = memory%count + 1
      memory%image(:n) = image
      memory%residual(:n) = image - x
      call least_squares(memory%d_residual(:n, :used), memory%residual(:n), share(:used))
      x = image
      do j = 1, used
         x = x - share(j)*memory%d_image(:n, j)
      end do
   end subroutine accelerate

   !> Allocate for n unknowns, unless there is room.
   subroutine reserve(memory, n)
      type(anderson_type), intent(inout) :: memory  !< gets room
      integer, intent(in) :: n  !< unknowns

      if (allocated(memory%image)) then
         if (size(memory%image) >= n) return
         deallocate (memory%image, memory%residual, memory%d_image, memory%d_residual)
      end if
      allocate (memory%image(2*n), memory%residual(2*n), memory%d_image(2*n, depth), &
         memory%d_residual(2*n, depth))
      memory%count = 0
   end subroutine reserve

   !> min ‖b − A y‖ by the normal equations, Gauss elimination without pivoting (they are definite).
   pure subroutine least_squares(a, b, y)
      real(wp), intent(in) :: a(:,:), b(:)  !< [n,m], [n]
      real(wp), intent(out) :: y(:)  !< [m]
      real(wp) :: normal(depth, depth), factor
      integer :: i, j, m

      m = size(a, 2)
      do j = 1, m
         do i = 1, m
            normal(i, j) = dot_product(a(:, i), a(:, j))
         end do
         normal(j, j) = normal(j, j)*(1.0_wp + regular) + tiny(1.0_wp)
         y(j) = dot_product(a(:, j), b)
      end do
      do j = 1, m
         do i = j + 1, m
            factor = normal(i, j)/normal(j, j)
            normal(i, j:m) = normal(i, j:m) - factor*normal(j, j:m)
            y(i) = y(i) - factor*y(j)
         end do
      end do
      do j = m, 1, -1
         y(j) = (y(j) - dot_product(normal(j, j + 1:m), y(j + 1:m)))/normal(j, j)
      end do
   end subroutine least_squares

end module dda_anderson
