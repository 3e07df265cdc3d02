! SPDX-License-Identifier: GPL-3.0-or-later
!> Slight displacement of a block when dynamics begin, for a second run: both runs agree as long as
!> the motion is predictable.
!>
!> Bonds, joint crossings and the contacts whose slip is measured are determined before the
!> displacement, so that they are equal in both runs.
module dda_displaced_block
   use dda_kinds, only: wp
   use dda_blocks, only: update_geometry
   use dda_simulation, only: simulation_type
   implicit none
   private
   public :: displace_block

contains

   !> Displace the block that the input names.
   subroutine displace_block(simulation)
      type(simulation_type), intent(inout) :: simulation  !< between two steps
      real(wp) :: way(2)

      associate (control => simulation%model%control, blocks => simulation%blocks)
         associate (b => control%displaced)
            way = control%displaced_by*sqrt(blocks%area(b))
            blocks%position(1:2, b) = blocks%position(1:2, b) + way
            call update_geometry(blocks)
            simulation%neighbours%travel = simulation%neighbours%travel + norm2(way)
         end associate
      end associate
   end subroutine displace_block

end module dda_displaced_block
