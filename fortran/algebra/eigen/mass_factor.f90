! SPDX-License-Identifier: GPL-3.0-or-later
!> M = G Gᵀ for the block-diagonal mass matrix, and the resulting standard eigenproblem.
!>
!> With y = Gᵀx, K x = ω² M x becomes S y = ω² y, S = G⁻¹KG⁻ᵀ, and xᵀMx becomes yᵀy.  The scaling
!> also makes translations and strains equal in magnitude.
module dda_mass_factor
   use dda_kinds, only: wp
   use dda_errors, only: error_type, error_solver, fail
   use dda_text, only: to_text
   use dda_block_matrix, only: block_matrix_type
   use dda_dense_eigen, only: factorise_block
   use dda_small_matrix, only: invert_matrix
   implicit none
   private
   public :: mass_factor_type, factor_mass, scale_matrix, multiply_transposed, apply_factor

   !> G and G⁻¹, lower triangles.
   type :: mass_factor_type
      real(wp), allocatable :: g(:,:,:)        !< [6,6,n] G
      real(wp), allocatable :: inverse(:,:,:)  !< [6,6,n] G⁻¹
   end type mass_factor_type

contains

   !> Factorise the mass of each block.
   subroutine factor_mass(factor, mass, error)
      type(mass_factor_type), intent(out) :: factor  !< G and G⁻¹
      real(wp), intent(in) :: mass(:,:,:)  !< [6,6,n] M
      type(error_type), allocatable, intent(out) :: error  !< a mass is not positive definite
      logical :: positive
      integer :: b

      allocate (factor%g(6, 6, size(mass, 3)), factor%inverse(6, 6, size(mass, 3)))
      do b = 1, size(mass, 3)
         call factorise_block(mass(:, :, b), factor%g(:, :, b), positive)
         if (.not. positive) then
            call fail(error, error_solver, 'the mass matrix of block '//to_text(b)// &
               ' is not positive definite')
            return
         end if
         call invert_matrix(factor%g(:, :, b), factor%inverse(:, :, b))
      end do
   end subroutine factor_mass

   !> Replace K by S = G⁻¹KG⁻ᵀ, block by block.
   pure subroutine scale_matrix(factor, matrix)
      type(mass_factor_type), intent(in) :: factor  !< G and G⁻¹
      type(block_matrix_type), intent(inout) :: matrix  !< K; on return, S
      integer :: i, e

      do i = 1, matrix%n
         matrix%diagonal(:, :, i) = matmul(factor%inverse(:, :, i), &
            matmul(matrix%diagonal(:, :, i), transpose(factor%inverse(:, :, i))))
         do e = matrix%row_start(i), matrix%row_start(i + 1) - 1
            matrix%lower(:, :, e) = matmul(factor%inverse(:, :, i), &
               matmul(matrix%lower(:, :, e), transpose(factor%inverse(:, :, matrix%column(e)))))
         end do
      end do
   end subroutine scale_matrix

   !> Compute y = Tᵀx for a lower triangle T = G or G⁻¹, block by block.
   !> y = Gᵀx transforms block coordinates to the standard problem; x = G⁻ᵀy transforms them back.
   pure subroutine multiply_transposed(t, x, y)
      real(wp), intent(in) :: t(:,:,:)   !< [6,6,n] G or G⁻¹
      real(wp), intent(in) :: x(6, *)    !< [6,n]
      real(wp), intent(out) :: y(6, *)   !< [6,n]
      integer :: b

      do b = 1, size(t, 3)
         y(:, b) = matmul(x(:, b), t(:, :, b))
      end do
   end subroutine multiply_transposed

   !> Compute f = G y, the force M x in block coordinates if y = Gᵀx.
   pure subroutine apply_factor(factor, y, f)
      type(mass_factor_type), intent(in) :: factor  !< G and G⁻¹
      real(wp), intent(in) :: y(6, *)   !< [6,n]
      real(wp), intent(out) :: f(:,:)   !< [6,n]
      integer :: b

      do b = 1, size(f, 2)
         f(:, b) = matmul(factor%g(:, :, b), y(:, b))
      end do
   end subroutine apply_factor

end module dda_mass_factor
