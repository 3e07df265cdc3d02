!> M = G Gᵀ for the block-diagonal mass matrix, and the standard eigenproblem that it makes.
!>
!> With y = Gᵀx the problem K x = ω² M x becomes S y = ω² y, S = G⁻¹KG⁻ᵀ, and the mass product xᵀMx
!> the plain yᵀy.  It also removes the difference of scale between translations and strains.
module dda_mass_factor
   use dda_kinds, only: wp
   use dda_errors, only: error_type, error_solver, fail
   use dda_text, only: to_text
   use dda_block_matrix, only: block_matrix_type
   use dda_dense_eigen, only: cholesky_block
   implicit none
   private
   public :: mass_factor_type, factor_mass, scale_matrix, to_places, from_places, apply_factor

   !> G and G⁻¹, lower triangles.
   type :: mass_factor_type
      real(wp), allocatable :: g(:,:,:)        !< [6,6,n]
      real(wp), allocatable :: inverse(:,:,:)  !< [6,6,n]
   end type mass_factor_type

contains

   !> Factorise the mass of each block.
   subroutine factor_mass(factor, mass, error)
      type(mass_factor_type), intent(out) :: factor  !< G and its inverse
      real(wp), intent(in) :: mass(:,:,:)  !< [6,6,n]
      type(error_type), allocatable, intent(out) :: error  !< a mass is not positive definite
      logical :: positive
      integer :: b

      allocate (factor%g(6, 6, size(mass, 3)), factor%inverse(6, 6, size(mass, 3)))
      do b = 1, size(mass, 3)
         call cholesky_block(mass(:, :, b), factor%g(:, :, b), positive)
         if (.not. positive) then
            call fail(error, error_solver, 'the mass matrix of block '//to_text(b)// &
               ' is not positive definite')
            return
         end if
         factor%inverse(:, :, b) = inverse_of(factor%g(:, :, b))
      end do
   end subroutine factor_mass

   !> Inverse of a lower triangular block.
   pure function inverse_of(g) result(inverse)
      real(wp), intent(in) :: g(6, 6)  !< lower triangle
      real(wp) :: inverse(6, 6)
      integer :: i, j

      inverse = 0.0_wp
      do j = 1, 6
         inverse(j, j) = 1.0_wp/g(j, j)
         do i = j + 1, 6
            inverse(i, j) = -dot_product(g(i, j:i - 1), inverse(j:i - 1, j))/g(i, i)
         end do
      end do
   end function inverse_of

   !> K becomes S = G⁻¹KG⁻ᵀ, block by block.
   pure subroutine scale_matrix(factor, matrix)
      type(mass_factor_type), intent(in) :: factor  !< G and its inverse
      type(block_matrix_type), intent(inout) :: matrix  !< K, becomes S
      integer :: i, e

      do i = 1, matrix%n
         matrix%diagonal(:, :, i) = scaled(factor%inverse(:, :, i), matrix%diagonal(:, :, i), &
            factor%inverse(:, :, i))
         do e = matrix%row_start(i), matrix%row_start(i + 1) - 1
            matrix%lower(:, :, e) = scaled(factor%inverse(:, :, i), matrix%lower(:, :, e), &
               factor%inverse(:, :, matrix%column(e)))
         end do
      end do
   end subroutine scale_matrix

   !> a k bᵀ
   pure function scaled(a, k, b) result(product)
      real(wp), intent(in) :: a(6, 6), k(6, 6), b(6, 6)  !< factors; a and b lower triangles
      real(wp) :: product(6, 6)
      real(wp) :: left(6, 6)
      integer :: i, j

      left = 0.0_wp
      product = 0.0_wp
      do j = 1, 6
         do i = 1, 6
            left(:, j) = left(:, j) + k(i, j)*a(:, i)
         end do
      end do
      do i = 1, 6
         do j = 1, 6
            product(:, j) = product(:, j) + b(j, i)*left(:, i)
         end do
      end do
   end function scaled

   !> x = G⁻ᵀ y: from coordinates of the standard problem to those of the blocks.
   pure subroutine to_places(factor, y, x)
      type(mass_factor_type), intent(in) :: factor  !< G and its inverse
      real(wp), intent(in) :: y(:,:)   !< [6,n]
      real(wp), intent(out) :: x(:,:)  !< [6,n]
      integer :: b, i

      do b = 1, size(y, 2)
         do i = 1, 6
            x(i, b) = dot_product(factor%inverse(i:6, i, b), y(i:6, b))
         end do
      end do
   end subroutine to_places

   !> y = Gᵀ x: from coordinates of the blocks to those of the standard problem.
   pure subroutine from_places(factor, x, y)
      type(mass_factor_type), intent(in) :: factor  !< G and its inverse
      real(wp), intent(in) :: x(:,:)   !< [6,n]
      real(wp), intent(out) :: y(6, *) !< [6,n]
      integer :: b, i

      do b = 1, size(x, 2)
         do i = 1, 6
            y(i, b) = dot_product(factor%g(i:6, i, b), x(i:6, b))
         end do
      end do
   end subroutine from_places

   !> f = G y: a force (M x, where y = Gᵀx) in coordinates of the blocks.
   pure subroutine apply_factor(factor, y, f)
      type(mass_factor_type), intent(in) :: factor  !< G and its inverse
      real(wp), intent(in) :: y(6, *)   !< [6,n]
      real(wp), intent(out) :: f(:,:)   !< [6,n]
      integer :: b, j

      do b = 1, size(f, 2)
         f(:, b) = 0.0_wp
         do j = 1, 6
            f(j:6, b) = f(j:6, b) + y(j, b)*factor%g(j:6, j, b)
         end do
      end do
   end subroutine apply_factor

end module dda_mass_factor
