! SPDX-License-Identifier: GPL-3.0-or-later
!> Known vectors that are excluded from an eigenvalue search.
!>
!> These are full vectors found in earlier searches, and null vectors on groups of block rows: up to
!> three rigid-body modes per unsupported part of a model.  Both are orthonormal in the coordinates
!> of the standard problem (`dda_mass_factor`).
module dda_deflation
   use dda_kinds, only: wp
   use dda_growth, only: grow
   use dda_mass_factor, only: mass_factor_type, multiply_transposed
   implicit none
   private
   public :: null_space_type, deflation_type, prepare_deflation, deflate_vector, project_out

   !> Null vectors of a stiffness matrix, mass-orthonormal, each on one group of block rows.
   type :: null_space_type
      integer :: groups = 0
      integer :: dimension = 0                !< number of null vectors
      integer, allocatable :: group(:)        !< [n] group of each block row
      !> [6,3,n] up to three vectors of the group of each row, else zero
      real(wp), allocatable :: basis(:,:,:)
   end type null_space_type

   !> Vectors to be projected out.
   type :: deflation_type
      type(null_space_type) :: null_space          !< `basis` in coordinates of the standard problem
      integer :: n_vectors = 0                !< number of full vectors
      real(wp), allocatable :: vector(:,:)    !< [6n,any] full vectors
   end type deflation_type

contains

   !> Begin a deflation with the null space, if there is one, and without full vectors.
   pure subroutine prepare_deflation(deflation, mass, null_space)
      type(deflation_type), intent(out) :: deflation  !< deflation without full vectors
      type(mass_factor_type), intent(in) :: mass  !< factor of M
      type(null_space_type), intent(in), optional :: null_space  !< vectors in block coordinates
      integer :: i

      if (.not. present(null_space)) return
      if (null_space%dimension == 0) return
      deflation%null_space = null_space
      do i = 1, 3
         call multiply_transposed(mass%g, null_space%basis(:, i, :), deflation%null_space%basis(:, &
            i, :))
      end do
   end subroutine prepare_deflation

   !> Add an eigenvector found by a search to the vectors that are projected out.
   pure subroutine deflate_vector(deflation, vector)
      type(deflation_type), intent(inout) :: deflation  !< deflation; receives the vector
      real(wp), intent(in) :: vector(:)  !< [6n] vector of length 1

      call grow(deflation%vector, size(vector), deflation%n_vectors + 1)
      deflation%n_vectors = deflation%n_vectors + 1
      deflation%vector(:, deflation%n_vectors) = vector
   end subroutine deflate_vector

   !> Remove from y its components along all vectors.
   pure subroutine project_out(deflation, y)
      type(deflation_type), intent(in) :: deflation  !< known vectors
      real(wp), intent(inout) :: y(:)  !< [6n] vector
      integer :: i

      if (deflation%null_space%dimension > 0) call remove_null_components(deflation%null_space, y)
      do i = 1, deflation%n_vectors
         y = y - dot_product(deflation%vector(:, i), y)*deflation%vector(:, i)
      end do
   end subroutine project_out

   !> Remove the components along the null vectors, group by group.
   pure subroutine remove_null_components(null_space, y)
      type(null_space_type), intent(in) :: null_space  !< vectors of the standard problem
      real(wp), intent(inout) :: y(6, *)  !< [6,n]
      real(wp) :: component(3, null_space%groups)
      integer :: b

      component = 0.0_wp
      do b = 1, size(null_space%group)
         component(:, null_space%group(b)) = component(:, null_space%group(b)) &
            + matmul(y(:, b), null_space%basis(:, :, b))
      end do
      do b = 1, size(null_space%group)
         y(:, b) = y(:, b) - matmul(null_space%basis(:, :, b), component(:, null_space%group(b)))
      end do
   end subroutine remove_null_components

end module dda_deflation
