! SPDX-License-Identifier: GPL-3.0-or-later
!> Twin of a run in which a block is displaced slightly when dynamics begin; its results are the
!> same as long as the motion is predictable.
!>
!> Bonds, crossings and the reference contacts of slip are those of the run, because they are
!> determined earlier.
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
