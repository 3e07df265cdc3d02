! SPDX-License-Identifier: GPL-3.0-or-later
!> Pattern of the matrix of a run: near pairs of blocks, and blocks that elements couple.
!>
!> The pattern is renewed if it lacks a pair of blocks that the terms of the elements couple.
module dda_matrix_pattern
   use dda_errors, only: error_type, error_solver, fail
   use dda_linear_solver, only: analyse
   use dda_simulation, only: simulation_type, next_step
   use dda_system, only: assemble_linear, fits_pattern, set_matrix_pattern
   implicit none
   private
   public :: set_pattern_of_run, fit_pattern, assemble_step

contains

   !> Set the pattern for the present neighbours and elements.
   subroutine set_pattern_of_run(simulation)
      type(simulation_type), intent(inout) :: simulation  !< a run and its state

      call set_matrix_pattern(simulation%system, simulation%blocks, simulation%neighbours, &
         simulation%elements, next_step(simulation))
      call analyse(simulation%solver, simulation%system%matrix)
   end subroutine set_pattern_of_run

   !> Renew the pattern if elements couple other blocks.
   !> A resumed run sets its pattern from its elements, so the pattern of the first run must match.
   subroutine fit_pattern(simulation)
      type(simulation_type), intent(inout) :: simulation  !< between two steps

      if (.not. fits_pattern(simulation%system, simulation%blocks, simulation%elements, &
         next_step(simulation))) call set_pattern_of_run(simulation)
   end subroutine fit_pattern

   !> Assemble the linear part of a step; renew the pattern if it lacks couplings of elements.
   subroutine assemble_step(simulation, error)
      type(simulation_type), intent(inout) :: simulation  !< a run and its state
      type(error_type), allocatable, intent(out) :: error  !< couplings are missing
      integer :: attempt
      logical :: fits

      do attempt = 1, 2
         call assemble_linear(simulation%system, simulation%elements, simulation%blocks, &
            next_step(simulation), fits)
         if (fits) return
         call set_pattern_of_run(simulation)
      end do
      call fail(error, error_solver, 'the pattern of the matrix lacks couplings of elements')
   end subroutine assemble_step

end module dda_matrix_pattern
