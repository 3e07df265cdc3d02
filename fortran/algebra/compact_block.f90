! SPDX-License-Identifier: GPL-3.0-or-later
!> Compact storage of 6×6 blocks, such as the mass or elasticity of a block about its centroid, in
!> 11 numbers: one for both translations, and ten for the symmetric 4×4 part of rotation and
!> strains.
module dda_compact_block
   use dda_kinds, only: wp
   implicit none
   private
   public :: compact_size, compact, expand, main_diagonal, multiply_compact

   integer, parameter :: compact_size = 11  !< number of values of a block

contains

   !> Extract the 11 numbers of a 6×6 block.
   pure function compact(block) result(numbers)
      real(wp), intent(in) :: block(6, 6)  !< symmetric block with uncoupled translations
      real(wp) :: numbers(compact_size)

      numbers = [block(1, 1), block(3:6, 3), block(4:6, 4), block(5:6, 5), block(6, 6)]
   end function compact

   !> Build the 6×6 block from its 11 numbers.
   pure subroutine expand(numbers, block)
      real(wp), intent(in) :: numbers(compact_size)  !< values from `compact`
      real(wp), intent(out) :: block(6, 6)           !< block with these values

      block(:, 1:2) = 0.0_wp
      block(1:2, :) = 0.0_wp
      block(1, 1) = numbers(1)
      block(2, 2) = numbers(1)
      block(3:6, 3) = numbers(2:5)
      block(3:6, 4) = [numbers(3), numbers(6:8)]
      block(3:6, 5) = [numbers(4), numbers(7), numbers(9:10)]
      block(3:6, 6) = [numbers(5), numbers(8), numbers(10:11)]
   end subroutine expand

   !> Compute the product y of the block and a vector x.
   pure subroutine multiply_compact(numbers, x, y)
      real(wp), intent(in) :: numbers(compact_size)  !< values from `compact`
      real(wp), intent(in) :: x(6)   !< any vector
      real(wp), intent(out) :: y(6)  !< product

      associate (a => numbers)
         y(1) = a(1)*x(1)
         y(2) = a(1)*x(2)
         y(3) = a(2)*x(3) + a(3)*x(4) + a(4)*x(5) + a(5)*x(6)
         y(4) = a(3)*x(3) + a(6)*x(4) + a(7)*x(5) + a(8)*x(6)
         y(5) = a(4)*x(3) + a(7)*x(4) + a(9)*x(5) + a(10)*x(6)
         y(6) = a(5)*x(3) + a(8)*x(4) + a(10)*x(5) + a(11)*x(6)
      end associate
   end subroutine multiply_compact

   !> Return the main diagonal of the block.
   pure function main_diagonal(numbers) result(diagonal)
      real(wp), intent(in) :: numbers(compact_size)  !< values from `compact`
      real(wp) :: diagonal(6)

      diagonal = numbers([1, 1, 2, 6, 9, 11])
   end function main_diagonal

end module dda_compact_block
