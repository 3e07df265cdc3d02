! SPDX-License-Identifier: GPL-3.0-or-later
!> What a check says of bodies and their cells.
module dda_check_bodies
   use dda_kinds, only: wp, pi
   use dda_blocks, only: blocks_type
   use dda_model, only: model_type
   use dda_text, only: to_text, short_text
   implicit none
   private
   public :: separate_blocks, blocks_in_words, dispersion_in_words

contains

   !> Number of bodies, and of blocks that are no cells.
   pure integer function separate_blocks(model)
      type(model_type), intent(in) :: model  !< with its blocks

      separate_blocks = size(model%body_names) + count(model%blocks%body == 0)
   end function separate_blocks

   !> How many blocks there are, and of how many cells.
   pure function blocks_in_words(model) result(words)
      type(model_type), intent(in) :: model  !< with its blocks
      character(len=:), allocatable :: words

      words = to_text(separate_blocks(model))//' blocks'
      if (size(model%body_names) > 0) words = words//', '//to_text(size(model%body_names))// &
         ' of them of '//to_text(count(model%blocks%body > 0))//' cells'
   end function blocks_in_words

   !> By how much S waves along a row of blocks are too fast, (kΔx)²/24, as displacements are linear
   !> in a block and its mass is spread over it; along a row of cells too slow, (kΔx)²/48.
   function dispersion_in_words(blocks, eta) result(words)
      type(blocks_type), intent(in) :: blocks  !< in any state
      real(wp), intent(in) :: eta              !< Δx/λ
      character(len=:), allocatable :: words

      if (any(blocks%body > 0)) then
         words = short_text(100*(2.0_wp*pi*eta)**2/48.0_wp)//' % too slow'
      else
         words = short_text(100*(2.0_wp*pi*eta)**2/24.0_wp)//' % too fast'
      end if
   end function dispersion_in_words

end module dda_check_bodies
