! SPDX-License-Identifier: GPL-3.0-or-later
!> Number of eigenvalues of K x = λ M x above a value s, by Sylvester's law of inertia.
!>
!> This number equals the number of positive pivots of K − sM = L D Lᵀ.  The factor is a band matrix
!> without pivoting, suitable for a few thousand blocks.  If a pivot is so small that its sign is
!> uncertain, the number is reported as uncertain.
module dda_inertia
   use dda_kinds, only: wp
   use dda_band_matrix, only: band_type, order_band, fill_band
   use dda_block_matrix, only: block_matrix_type
   use dda_mass_factor, only: mass_factor_type, scale_matrix
   implicit none
   private
   public :: count_above

   real(wp), parameter :: min_pivot = 1.0e-11_wp  !< pivot/largest entry of S with a certain sign

contains

   !> Count the eigenvalues above `value`.
   subroutine count_above(stiffness, mass, value, affordable, count, is_certain)
      type(block_matrix_type), intent(in) :: stiffness  !< K, N/m
      type(mass_factor_type), intent(in) :: mass      !< G
      real(wp), intent(in) :: value                     !< s, 1/s²
      real(wp), intent(in) :: affordable                !< largest number of multiplications
      integer, intent(out) :: count                     !< number of eigenvalues above
      logical, intent(out) :: is_certain  !< .false.: too costly, or uncertain sign of a pivot
      type(block_matrix_type) :: scaled_matrix
      type(band_type) :: factor

      count = 0
      is_certain = .false.
      call order_band(factor, stiffness)
      if (3.0_wp*real(stiffness%n, wp)*real(factor%half_width, wp)**2 > affordable) return
      allocate (factor%band(factor%half_width + 1, 6*stiffness%n))
      scaled_matrix = stiffness
      call scale_matrix(mass, scaled_matrix)
      call fill_band(factor, scaled_matrix)
      factor%band(1, :) = factor%band(1, :) - value
      call count_pivots(factor%band, count, is_certain)
   end subroutine count_above

   !> Eliminate column by column and count positive pivots.
   pure subroutine count_pivots(band, count, is_certain)
      real(wp), intent(inout) :: band(:,:)  !< [width+1, n] S − sI, lower storage; destroyed
      integer, intent(out) :: count  !< number of positive pivots
      logical, intent(out) :: is_certain  !< the signs of all pivots are certain
      real(wp) :: smallest_pivot, pivot, factor
      integer :: j, k, width

      count = 0
      is_certain = .true.
      smallest_pivot = min_pivot*maxval(abs(band))
      do j = 1, size(band, 2)
         pivot = band(1, j)
         if (abs(pivot) < smallest_pivot) then
            is_certain = .false.
            pivot = sign(smallest_pivot, pivot)
         end if
         if (pivot > 0.0_wp) count = count + 1
         width = min(size(band, 1) - 1, size(band, 2) - j)
         do k = 1, width
            if (band(k + 1, j) == 0.0_wp) cycle
            factor = band(k + 1, j)/pivot
            band(1:width - k + 1, j + k) = band(1:width - k + 1, j + k) &
               - factor*band(k + 1:width + 1, j)
         end do
      end do
   end subroutine count_pivots

end module dda_inertia
