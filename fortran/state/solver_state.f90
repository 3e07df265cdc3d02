! SPDX-License-Identifier: GPL-3.0-or-later
!> State of the linear solver: its method, its counts, and the data of the method.
module dda_solver_state
   use dda_archive, only: archive_type, serialise, serialise_label, fail_archive
   use dda_block_matrix, only: block_matrix_type
   use dda_linear_solver, only: solver_type, is_solver_name, set_method
   implicit none
   private
   public :: serialise_solver

contains

   !> Save or restore a solver that has analysed the matrix.
   subroutine serialise_solver(archive, solver, matrix)
      type(archive_type), intent(inout) :: archive  !< written or read
      type(solver_type), intent(inout) :: solver  !< linear solver
      type(block_matrix_type), intent(in) :: matrix  !< matrix; only its pattern is read
      character(len=:), allocatable :: method

      call serialise_label(archive, 'solver')
      method = trim(solver%method)
      call serialise(archive, method)
      if (.not. is_solver_name(method)) call fail_archive(archive, 'it names no solver')
      call serialise(archive, solver%last_iterations)
      call serialise(archive, solver%shifted)
      call serialise(archive, solver%exact)
      call serialise(archive, solver%solves)
      call serialise(archive, solver%factors)
      call serialise(archive, solver%iterations)
      call serialise(archive, solver%handed_over)
      if (allocated(archive%failure)) return
      if (method == 'auto') return
      if (method /= solver%method) call set_method(solver, matrix, method)
      call solver%active%serialise(matrix, archive)
   end subroutine serialise_solver

end module dda_solver_state
