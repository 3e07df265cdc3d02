! SPDX-License-Identifier: GPL-3.0-or-later
!> Highest frequency of a model, ω_max, for the limit Δt < 4/ω_max (paper eq. 13).
!>
!> ARPACK computes ω_max as a Ritz value, which does not exceed the exact value.  Two bounds need no
!> iteration; with the 6×6 diagonal block K_ii of block i, and (a + b)² ≤ 2a² + 2b² for each spring:
!>
!>     max λ(M⁻¹ K_ii) ≤ ω_max² ≤ max λ(M⁻¹ (2 K_ii^coupling + K_ii^elastic + K_ii^ground)) over i .
module dda_omega_max
   use dda_kinds, only: wp, long
   use dda_dense_eigen, only: solve_block_eigen, is_above
   use dda_eigen, only: eigenpairs_type, find_largest_eigenvalue, suggested_tolerance
   use dda_errors, only: error_type, error_solver, fail
   use dda_linear_model, only: linear_model_type, energy_distribution_type, energy_of, &
      energy_kinds, kind_names, stiffness_weights, block_label, term_label, strain_energy
   use dda_linear_terms, only: add_product, blocks_in, get_row
   use dda_text, only: short_text, to_text
   implicit none
   private
   public :: omega_max_type, bracket_type, find_omega_max, find_bracket, find_upper_blocks

   !> ratio up to which eigenvalues of blocks count as equal
   real(wp), parameter :: equal_ratio = 1.0_wp + 1.0e-12_wp

   !> Guaranteed bounds of ω_max, and the blocks from which they are computed.
   type :: bracket_type
      real(wp) :: lower = 0.0_wp    !< rad/s
      real(wp) :: upper = 0.0_wp    !< rad/s
      integer :: lower_block = 0
      integer :: upper_block = 0
   end type bracket_type

   !> Highest frequency, and the spring or block with the most energy in its mode.
   type :: omega_max_type
      real(wp) :: omega = 0.0_wp         !< ω_max, rad/s
      real(wp) :: tolerance = 0.0_wp     !< tolerance of the residual
      real(wp) :: residual = 0.0_wp      !< final residual ‖Kx − ω²Mx‖/ω² in the mass norm
      integer(long) :: products = 0      !< products of K with a vector
      type(bracket_type) :: bracket
      type(energy_distribution_type) :: energy  !< energy of the mode
      integer :: kind = 0                !< kind of term with the most energy
      integer :: spring = 0              !< spring of this kind with the most energy; 0: strain
      integer :: block(2) = 0  !< blocks of this spring, or block with the largest strain energy
      real(wp), allocatable :: shape(:,:)          !< [6,n] mass-normalised
      character(len=:), allocatable :: governs     !< text on the governing spring or block
      character(len=:), allocatable :: text       !< text on all results
   end type omega_max_type

contains

   !> Find ω_max, its bracket and its governing spring or block.
   subroutine find_omega_max(linear, result, error, tolerance)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      type(omega_max_type), intent(out) :: result  !< highest frequency
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      !> tolerance of the relative residual; the default depends on the number of blocks
      real(wp), intent(in), optional :: tolerance
      type(eigenpairs_type) :: pairs

      result%tolerance = suggested_tolerance(linear%n)
      if (present(tolerance)) result%tolerance = tolerance
      call find_bracket(linear, result%bracket, error)
      if (allocated(error)) return
      call find_largest_eigenvalue(linear%stiffness, linear%mass, result%tolerance, pairs, error)
      if (allocated(error)) then
         error%message = 'ω_max was not found (it lies between '// &
            bracket_text(result%bracket)//'): '//error%message
         return
      end if
      result%omega = sqrt(max(pairs%value(1), 0.0_wp))
      result%residual = pairs%residual(1)
      result%products = pairs%products
      result%shape = pairs%vector(:, :, 1)
      result%energy = energy_of(linear, result%shape)
      call find_governing_term(linear, result)
      call write_omega_text(linear, result)
      call check_bracket(result, error)
   end subroutine find_omega_max

   !> Find bounds of ω_max from the 6×6 eigenvalue problems of single blocks.
   subroutine find_bracket(linear, bracket, error)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      type(bracket_type), intent(out) :: bracket  !< bounds of ω_max, rad/s
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      real(wp), allocatable :: upper(:,:,:)

      call find_largest_block_omega(linear%stiffness%diagonal, linear%mass, bracket%lower, &
         bracket%lower_block, error)
      if (allocated(error)) return
      call find_upper_blocks(linear, upper)
      call find_largest_block_omega(upper, linear%mass, bracket%upper, bracket%upper_block, error)
      bracket%upper = equal_ratio*bracket%upper
   end subroutine find_bracket

   !> Sum K_ii^elastic and, for each term on m blocks (m = 1: on one block and the ground), m K_ii.
   !> The factor m follows from (u₁ + … + u_m)² ≤ m (u₁² + … + u_m²).
   subroutine find_upper_blocks(linear, upper)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      real(wp), allocatable, intent(out) :: upper(:,:,:)  !< [6,6,n]
      real(wp) :: k, row(6)
      integer :: b, i, j, m

      upper = 2.0_wp*linear%stiffness%diagonal
      do b = 1, linear%n
         upper(4:6, 4:6, b) = upper(4:6, 4:6, b) - linear%elastic(:, :, b)
      end do
      do i = 1, linear%terms%n
         associate (term => linear%terms%term(i))
            m = blocks_in(term)
            if (m == 2) cycle
            k = (m - 2)*stiffness_weights(term%instant)*term%coefficient
            do j = 1, m
               call get_row(term, j, b, row)
               call add_product(upper(:, :, b), k, row, row)
            end do
         end associate
      end do
   end subroutine find_upper_blocks

   !> Find the block with the largest eigenvalue λ of k x = λ m x, and ω = √λ.
   subroutine find_largest_block_omega(k, m, omega, block, error)
      real(wp), intent(in) :: k(:,:,:), m(:,:,:)  !< [6,6,n]
      real(wp), intent(out) :: omega              !< rad/s
      integer, intent(out) :: block  !< number of the block
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      real(wp) :: values(6), vectors(6, 6), largest_eigenvalue
      integer :: b

      largest_eigenvalue = 0.0_wp
      block = 0
      do b = 1, size(k, 3)
         if (block > 0) then
            if (is_above(equal_ratio*largest_eigenvalue, k(:, :, b), m(:, :, b))) cycle
         end if
         call solve_block_eigen(k(:, :, b), m(:, :, b), values, vectors, error)
         if (allocated(error)) return
         if (values(6) > largest_eigenvalue) block = b
         largest_eigenvalue = max(largest_eigenvalue, values(6))
      end do
      omega = sqrt(largest_eigenvalue)
   end subroutine find_largest_block_omega

   !> Find the kind of term, and its spring or block, with the most energy in the highest mode.
   subroutine find_governing_term(linear, result)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      type(omega_max_type), intent(inout) :: result  !< highest frequency
      integer :: largest_term

      result%kind = maxloc(result%energy%fraction, 1)
      largest_term = result%energy%largest_term(result%kind)
      if (result%kind == strain_energy) then
         result%block = [max(1, largest_term), 0]
         result%governs = 'a strain mode of '//block_label(linear, result%block(1))
      else
         result%spring = largest_term
         result%block = [linear%terms%term(largest_term)%block_a, &
            linear%terms%term(largest_term)%block_b]
         result%governs = term_label(linear, largest_term)
      end if
   end subroutine find_governing_term

   !> Write the text on ω_max, its bounds and the governing term.
   subroutine write_omega_text(linear, result)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      type(omega_max_type), intent(inout) :: result  !< highest frequency
      integer :: kind

      associate (energy => result%energy)
         result%text = 'ω_max = '//short_text(result%omega)//' rad/s, guaranteed between '// &
            bracket_text(result%bracket)//'; relative residual '//short_text(result%residual)// &
            '; governed by '//result%governs//' with '// &
            percent_text(energy%largest_fraction(result%kind))//' of the energy of the mode ('
         do kind = 1, energy_kinds
            if (energy%fraction(kind) > 0.0_wp) result%text = result%text// &
               trim(kind_names(kind))//' '//percent_text(energy%fraction(kind))//', '
         end do
         result%text = result%text(:len(result%text) - 2)//'); the upper bound is due to '// &
            block_label(linear, result%bracket%upper_block)
      end associate
   end subroutine write_omega_text

   !> Return an error if ω_max is outside its bounds, which is a failure of the eigenvalue solver.
   subroutine check_bracket(result, error)
      type(omega_max_type), intent(in) :: result  !< highest frequency
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      real(wp) :: slack

      slack = result%residual + 1.0e-10_wp
      if (result%omega >= (1.0_wp - slack)*result%bracket%lower .and. &
         result%omega <= (1.0_wp + slack)*result%bracket%upper) return
      call fail(error, error_solver, 'ω_max = '//to_text(result%omega)//' rad/s lies outside '// &
         'its bounds '//bracket_text(result%bracket)//'; the eigenvalue search has failed')
   end subroutine check_bracket

   !> Text on the bounds of the highest frequency.
   pure function bracket_text(bracket) result(text)
      type(bracket_type), intent(in) :: bracket  !< bounds of ω_max, rad/s
      character(len=:), allocatable :: text

      text = short_text(bracket%lower)//' and '//short_text(bracket%upper)
   end function bracket_text

   !> Text of a fraction as a percentage.
   pure function percent_text(fraction) result(text)
      real(wp), intent(in) :: fraction  !< fraction of the energy
      character(len=:), allocatable :: text

      text = to_text(nint(100*fraction))//' %'
      if (fraction < 0.1_wp) text = to_text(0.1_wp*nint(1000*fraction))//' %'
   end function percent_text

end module dda_omega_max
