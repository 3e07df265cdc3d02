! SPDX-License-Identifier: GPL-3.0-or-later
!> Cycles of an iteration, known by its residuals.
!>
!> Where friction is high, the open–close iteration may go round the same few states for ever.
module dda_residual_cycle
   use dda_kinds, only: wp
   implicit none
   private
   public :: residual_cycle_type, record_residual, is_cyclic

   integer, parameter :: longest = 8                !< iterations of a cycle
   integer, parameter :: compared = 2*longest       !< residuals that have to repeat themselves

   !> The last residuals.
   type :: residual_cycle_type
      integer :: n = 0                                     !< recorded so far
      real(wp) :: residual(compared + longest) = 0.0_wp    !< N/m, the last one first
   end type residual_cycle_type

contains

   !> Record the residual of one more iteration.
   pure subroutine record_residual(cycle, residual)
      type(residual_cycle_type), intent(inout) :: cycle  !< gets it
      real(wp), intent(in) :: residual                   !< N/m

      cycle%n = cycle%n + 1
      cycle%residual = eoshift(cycle%residual, -1, residual)
   end subroutine record_residual

   !> The last residuals are those of one cycle before, to a share of each.
   pure logical function is_cyclic(cycle, share)
      type(residual_cycle_type), intent(in) :: cycle  !< of one iteration from its beginning
      real(wp), intent(in) :: share                   !< by which residuals may differ
      integer :: length

      is_cyclic = .false.
      if (cycle%n < size(cycle%residual)) return
      associate (r => cycle%residual)
         do length = 1, longest
            is_cyclic = all(abs(r(:compared) - r(length + 1:length + compared)) &
               <= share*r(:compared))
            if (is_cyclic) return
         end do
      end associate
   end function is_cyclic

end module dda_residual_cycle
