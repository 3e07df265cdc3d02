! SPDX-License-Identifier: GPL-3.0-or-later
!> Line search of Newton's method for the material laws.
!>
!> A step with its contacts is solved with stresses linearised at an increment d (see
!> `dda_strain_points`).  If the energy of the step has a minimum between this increment and the
!> solution, the minimum replaces the solution.
module dda_material_search
   use dda_elements, only: slope_beyond
   use dda_kinds, only: wp
   use dda_line_search, only: descend, other_slope_type
   use dda_open_close, only: evaluate
   use dda_simulation, only: simulation_type, next_step
   implicit none
   private
   public :: shorten_step

   !> Slope of the nonlinear part of the energy of the strain points.
   type, extends(other_slope_type) :: law_slope_type
      type(simulation_type), pointer :: simulation => null()
   contains
      procedure :: at
   end type law_slope_type

contains

   !> Shorten the path from the linearised increment to the solution, if the minimum lies between.
   subroutine shorten_step(simulation)
      type(simulation_type), intent(inout), target :: simulation  !< run with a solution of the step
      type(law_slope_type) :: slope
      real(wp) :: alpha

      slope%simulation => simulation
      simulation%system%previous_d = simulation%linear_about
      simulation%solution = simulation%system%d
      associate (contacts => simulation%contacts(simulation%now))
         call descend(simulation%system, contacts, simulation%laws, alpha, slope)
         if (alpha < 1.0_wp) call evaluate(simulation%iteration, simulation%system, contacts, &
            simulation%laws)
      end associate
   end subroutine shorten_step

   !> Return the slope of the energy at a fraction of the path, J per metre of thickness.
   real(wp) function at(self, fraction)
      class(law_slope_type), intent(in) :: self  !< forces in a step
      real(wp), intent(in) :: fraction           !< fraction of the path, 0 … 1

      at = slope_beyond(self%simulation%elements, self%simulation%blocks, &
         next_step(self%simulation), self%simulation%linear_about, self%simulation%solution, &
            fraction)
   end function at

end module dda_material_search
