! SPDX-License-Identifier: GPL-3.0-or-later
!> Eigenvalues of random block systems against dense LAPACK; operators that are hard for Lanczos.
module test_eigen
   use dda_kinds, only: wp
   use dda_arnoldi, only: operator_type, find_largest_pairs
   use dda_block_matrix, only: block_matrix_type, set_pattern
   use dda_deflation, only: null_space_type
   use dda_dense_eigen, only: solve_block_eigen, is_above
   use dda_eigen, only: eigenpairs_type, find_largest_eigenvalue, find_lowest_eigenvalues, &
      find_all_eigenvalues
   use dda_inertia, only: count_above
   use dda_mass_factor, only: mass_factor_type, factor_mass
   use models, only: random, random_vector, sow
   use systems, only: add_spring, dense_of
   use testing, only: case, check, check_close, check_fails, check_no_error, error
   implicit none

   !> A diagonal matrix whose largest values are too close for an iteration to separate.
   type, extends(operator_type) :: crowded_type
   contains
      procedure :: apply => apply_crowded
   end type crowded_type

   interface
      !> LAPACK: all eigenvalues of A x = λ B x with B positive definite.
      subroutine dsygv(itype, jobz, uplo, n, a, lda, b, ldb, w, work, lwork, info)
         import :: wp
         integer, intent(in) :: itype, n, lda, ldb, lwork
         character(len=1), intent(in) :: jobz, uplo
         real(wp), intent(inout) :: a(lda, *), b(ldb, *), work(*)
         real(wp), intent(out) :: w(*)
         integer, intent(out) :: info
      end subroutine dsygv
   end interface

   type(block_matrix_type) :: matrix
   type(eigenpairs_type) :: pairs

contains

   subroutine random_systems()
      integer :: n

      call case('random block systems against LAPACK')
      do n = 1, 24
         call against_lapack(n, .true.)
      end do
      call against_lapack(41, .true.)
      call case('singular ones')
      do n = 2, 20, 3
         call against_lapack(n, .false.)
      end do
   end subroutine random_systems

   !> A chain of springs with random rows, and some more between any two; mass and strains of random
   !> scales.
   subroutine random_system(n, definite, mass)
      integer, intent(in) :: n
      logical, intent(in) :: definite  !< else only one spring for each coupling
      real(wp), allocatable, intent(out) :: mass(:,:,:)
      integer :: pairs(2, n + n/2 - 1), i

      call sow(n)
      do i = 1, n - 1
         pairs(:, i) = [i, i + 1]
      end do
      do i = n, size(pairs, 2)
         pairs(1, i) = 1 + int(random(0.0_wp, real(n, wp)))
         pairs(2, i) = 1 + modulo(pairs(1, i), n)
      end do
      call set_pattern(matrix, n, pairs)
      allocate (mass(6, 6, n), source=0.0_wp)
      do i = 1, n
         mass(:, :, i) = random_definite(10.0_wp**random(-2.0_wp, 2.0_wp))
         if (definite) matrix%diagonal(:, :, i) = random_definite(10.0_wp**random(3.0_wp, 5.0_wp))
      end do
      do i = 1, size(pairs, 2)
         call add_spring(matrix, pairs(1, i), pairs(2, i), random_vector(6), random_vector(6), &
            10.0_wp**random(4.0_wp, 7.0_wp))
      end do
   end subroutine random_system

   function random_definite(scale) result(block)
      real(wp), intent(in) :: scale
      real(wp) :: block(6, 6), rows(6, 6)
      integer :: i

      rows = reshape(random_vector(36), [6, 6])
      block = scale*matmul(transpose(rows), rows)
      do i = 1, 6
         block(i, i) = block(i, i) + 0.2_wp*scale
      end do
   end function random_definite

   !> K and M as full matrices, and their eigenvalues by LAPACK dsygv.
   subroutine dense_values(mass, values)
      real(wp), intent(in) :: mass(:,:,:)
      real(wp), allocatable, intent(out) :: values(:)
      real(wp) :: k(6*matrix%n, 6*matrix%n), m(6*matrix%n, 6*matrix%n)
      real(wp) :: work(18*matrix%n)
      integer :: b, info

      allocate (values(6*matrix%n))
      k = dense_of(matrix)
      m = 0.0_wp
      do b = 1, matrix%n
         m(6*b - 5:6*b, 6*b - 5:6*b) = mass(:, :, b)
      end do
      call dsygv(1, 'N', 'L', 6*matrix%n, k, 6*matrix%n, m, 6*matrix%n, values, work, size(work), &
         info)
      call check(info == 0, 'LAPACK')
   end subroutine dense_values

   subroutine against_lapack(n, definite)
      integer, intent(in) :: n
      logical, intent(in) :: definite
      type(mass_factor_type) :: factor
      real(wp), allocatable :: mass(:,:,:), values(:)
      integer :: n_lowest, n_above
      logical :: is_certain

      call random_system(n, definite, mass)
      call dense_values(mass, values)
      call find_largest_eigenvalue(matrix, mass, 1.0e-10_wp, pairs, error)
      call check_no_error(error, 'largest')
      call check_close(pairs%value(1), values(6*n), 'largest eigenvalue', relative=1.0e-8_wp)
      call check(pairs%residual(1) <= 1.0e-9_wp, 'its residual')
      n_lowest = min(5, 6*n)
      call find_lowest_eigenvalues(matrix, mass, n_lowest, pairs, error)
      call check_no_error(error, 'lowest')
      call check_close(pairs%value, values(:n_lowest), 'lowest eigenvalues', relative=1.0e-8_wp, &
         absolute=1.0e-13_wp*values(6*n))
      call check_normalised(mass)
      call factor_mass(factor, mass, error)
      call count_above(matrix, factor, 0.5_wp*(values(2*n) + values(2*n + 1)), 1.0e9_wp, n_above, &
         is_certain)
      if (is_certain) call check(n_above == 4*n, 'count by inertia')
      call check(is_certain .or. .not. definite, 'the count is certain')
   end subroutine against_lapack

   subroutine check_normalised(mass)
      real(wp), intent(in) :: mass(:,:,:)
      real(wp) :: product
      integer :: i, j, b

      do i = 1, pairs%n
         do j = 1, i
            product = 0.0_wp
            do b = 1, size(mass, 3)
               product = product + dot_product(pairs%vector(:, b, i), &
                  matmul(mass(:, :, b), pairs%vector(:, b, j)))
            end do
            call check_close(product, merge(1.0_wp, 0.0_wp, i == j), 'mass product', &
               absolute=1.0e-8_wp)
         end do
      end do
   end subroutine check_normalised

   !> The Cholesky test of a block against its eigenvalues.
   subroutine uncoupled_blocks()
      real(wp) :: k(6, 6), m(6, 6), values(6), vectors(6, 6)
      integer :: i

      do i = 1, 20
         k = random_definite(1.0e6_wp)
         m = random_definite(3.0_wp)
         call solve_block_eigen(k, m, values, vectors, error)
         call check_no_error(error, 'block')
         call check_close(matmul(k, vectors(:, 6)), values(6)*matmul(m, vectors(:, 6)), 'pair', &
            relative=1.0e-9_wp)
         call check(is_above(values(6)*(1.0_wp + 1.0e-10_wp), k, m), 'just above')
         call check(.not. is_above(values(6)*(1.0_wp - 1.0e-10_wp), k, m), 'just below')
      end do
   end subroutine uncoupled_blocks

   !> Twelve equal blocks that do not touch: each eigenvalue twelve times.
   subroutine multiple_eigenvalues()
      integer, parameter :: n = 12
      real(wp) :: mass(6, 6, n)
      real(wp), allocatable :: values(:)
      integer :: b

      call set_pattern(matrix, n, reshape([integer ::], [2, 0]))
      matrix%diagonal = spread(random_definite(1.0e5_wp), 3, n)
      mass = spread(random_definite(1.0_wp), 3, n)
      call dense_values(mass, values)
      call find_lowest_eigenvalues(matrix, mass, 15, pairs, error)
      call check_no_error(error, 'lowest')
      call check_close(pairs%value, values(:15), 'all copies are found', relative=1.0e-8_wp)
      do b = 1, 3
         call find_largest_eigenvalue(matrix, mass, 1.0e-10_wp, pairs, error)
         call check_close(pairs%value(1), values(6*n), 'the largest', relative=1.0e-10_wp)
      end do
   end subroutine multiple_eigenvalues

   !> 1 − (i/n)²: the two largest values differ by a relative n⁻².  3,000 restarts take minutes with
   !> many blocks.
   subroutine nearly_equal_eigenvalues()
      integer, parameter :: n = 20000
      type(crowded_type) :: operator
      real(wp), allocatable :: values(:), vectors(:,:), residuals(:)

      call find_largest_pairs(operator, n, 1, 1.0e-10_wp, values, vectors, residuals, error)
      call check_fails(error, 'the eigenvalues are too close together')
      call check(operator%products < 5000, 'the work is bound by the size')
   end subroutine nearly_equal_eigenvalues

   subroutine apply_crowded(self, x, y)
      class(crowded_type), intent(inout) :: self
      real(wp), intent(in) :: x(:)
      real(wp), intent(out) :: y(:)
      integer :: i

      do i = 1, size(x)
         y(i) = (1.0_wp - (real(i, wp)/size(x))**2)*x(i)
      end do
   end subroutine apply_crowded

   !> A null space that is given is left out, dense or not.
   subroutine a_known_null_space()
      type(null_space_type) :: null_space
      real(wp), allocatable :: mass(:,:,:)
      real(wp) :: k(6, 6)
      integer :: n, i, b

      do n = 3, 15, 12
         call sow(n)
         call set_pattern(matrix, n, reshape([integer ::], [2, 0]))
         allocate (mass(6, 6, n), source=0.0_wp)
         null_space = null_space_type()
         null_space%groups = n
         null_space%group = [(b, b=1, n)]
         null_space%dimension = 2*n
         allocate (null_space%basis(6, 3, n), source=0.0_wp)
         do b = 1, n
            do i = 1, 6
               mass(i, i, b) = 2.0_wp*b
            end do
            k = 0.0_wp
            do i = 3, 6
               k(i, i) = 1.0e3_wp*b*i*2.0_wp*(1.0_wp + 0.01_wp*b)
            end do
            matrix%diagonal(:, :, b) = k
            null_space%basis(1, 1, b) = 1.0_wp/sqrt(2.0_wp*b)
            null_space%basis(2, 3, b) = 1.0_wp/sqrt(2.0_wp*b)
         end do
         call find_lowest_eigenvalues(matrix, mass, 3, pairs, error, null_space)
         call check_no_error(error, 'lowest')
         call check_close(pairs%value, [(3.0e3_wp*(1.0_wp + 0.01_wp*b), b=1, 3)], &
            'only the others', relative=1.0e-9_wp)
         call find_all_eigenvalues(matrix, mass, pairs, error, null_space)
         call check(pairs%n == 4*n .and. pairs%value(1) > 2.9e3_wp, 'all others')
         deallocate (mass, null_space%basis)
      end do
   end subroutine a_known_null_space

   subroutine bit_identical_eigenvalues()
      type(eigenpairs_type) :: first, second
      real(wp), allocatable :: mass(:,:,:)

      call random_system(30, .true., mass)
      call find_largest_eigenvalue(matrix, mass, 1.0e-10_wp, first, error)
      call find_lowest_eigenvalues(matrix, mass, 3, second, error)
      call find_largest_eigenvalue(matrix, mass, 1.0e-10_wp, second, error)
      call check(all(first%vector == second%vector) .and. all(first%value == second%value), &
         'the same again')
   end subroutine bit_identical_eigenvalues

   subroutine unsolvable_systems()
      real(wp), allocatable :: mass(:,:,:)

      call random_system(12, .true., mass)
      mass(3, 3, 7) = -1.0_wp
      call find_largest_eigenvalue(matrix, mass, 1.0e-10_wp, pairs, error)
      call check_fails(error, 'block 7')
      call random_system(310, .true., mass)
      call find_lowest_eigenvalues(matrix, mass, 1000, pairs, error)
      call check_fails(error, 'at most half')
   end subroutine unsolvable_systems

end module test_eigen
