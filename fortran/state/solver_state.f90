!> The state of the linear solver: what it has chosen and counted, and the older factor that it
!> still uses.
module dda_solver_state
   use dda_kinds, only: wp
   use dda_archive, only: archive_type, serialise, serialise_label, serialise_list, &
      serialise_number, fail_archive
   use dda_block_matrix, only: block_matrix_type
   use dda_low_rank, only: follow_again
   use dda_rank_one, only: most_changes
   use dda_linear_solver, only: solver_type, solver_names, plan_method
   use dda_lagged_factor, only: lagged_factor_type, analyse_lagged
   implicit none
   private
   public :: serialise_solver

contains

   !> The matrix must have its pattern, and the solver must have analysed it; plans follow from the
   !> pattern.
   subroutine serialise_solver(archive, solver, matrix)
      type(archive_type), intent(inout) :: archive
      type(solver_type), intent(inout) :: solver
      type(block_matrix_type), intent(in) :: matrix
      character(len=:), allocatable :: method

      call serialise_label(archive, 'solver')
      method = trim(solver%method)
      call serialise(archive, method)
      if (.not. any(method == solver_names)) call fail_archive(archive, 'it names no solver')
      solver%method = method
      call serialise(archive, solver%undecided)
      call serialise(archive, solver%last_iterations)
      call serialise(archive, solver%exact)
      call serialise(archive, solver%solves)
      call serialise(archive, solver%factors)
      call serialise(archive, solver%iterations)
      call serialise(archive, solver%handed_over)
      call serialise_lagged(archive, solver%stale, matrix)
      if (archive%reading .and. .not. allocated(archive%failure)) call plan_method(solver, matrix)
   end subroutine serialise_solver

   !> Numbers of the older factor; the matrix that they were made from is gone.
   subroutine serialise_lagged(archive, stale, matrix)
      type(archive_type), intent(inout) :: archive
      type(lagged_factor_type), intent(inout) :: stale
      type(block_matrix_type), intent(in) :: matrix

      call serialise_label(archive, 'factor')
      call serialise(archive, stale%made)
      call serialise(archive, stale%excess)
      if (.not. stale%made .or. allocated(archive%failure)) return
      if (archive%reading) call analyse_lagged(stale, matrix)
      call serialise(archive, stale%factor%sliced)
      stale%made = .true.
      call serialise_changes(archive, stale)
   end subroutine serialise_lagged

   !> The springs that have changed since the factor was made; what follows from them is made again.
   subroutine serialise_changes(archive, stale)
      type(archive_type), intent(inout) :: archive
      type(lagged_factor_type), intent(inout) :: stale
      logical :: done
      integer :: i

      associate (springs => stale%low%springs)
         call serialise_number(archive, springs%n, 0, most_changes)
         do i = 1, springs%n
            call serialise_list(archive, springs%block(:, i), 1, stale%factor%plan%n)
         end do
         call serialise(archive, springs%u(:, :, :springs%n))
         call serialise(archive, springs%k(:springs%n))
         if (.not. archive%reading .or. allocated(archive%failure)) return
         done = all(abs(springs%k(:springs%n)) > 0.0_wp)
      end associate
      if (done) call follow_again(stale%low, stale%factor, done)
      if (.not. done) call fail_archive(archive, 'its changed springs do not fit its factor')
   end subroutine serialise_changes

end module dda_solver_state
