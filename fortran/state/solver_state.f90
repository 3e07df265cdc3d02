!> The state of the linear solver: what it has chosen and counted, and the older factor that it still uses.
module dda_solver_state
   use dda_kinds, only: wp
   use dda_archive, only: archive_type, carry, carry_label, carry_list, carry_number, spoil
   use dda_block_matrix, only: block_matrix_type
   use dda_low_rank, only: follow_again
   use dda_rank_one, only: most_changes
   use dda_solver, only: solver_type, solver_names, plan_method
   use dda_stale_factor, only: stale_factor_type, analyse_stale
   implicit none
   private
   public :: carry_solver

contains

   !> The matrix must have its pattern, and the solver must have analysed it; plans follow from the pattern.
   subroutine carry_solver(archive, solver, matrix)
      type(archive_type), intent(inout) :: archive
      type(solver_type), intent(inout) :: solver
      type(block_matrix_type), intent(in) :: matrix
      character(len=:), allocatable :: method

      call carry_label(archive, 'solver')
      method = trim(solver%method)
      call carry(archive, method)
      if (.not. any(method == solver_names)) call spoil(archive, 'it names no solver')
      solver%method = method
      call carry(archive, solver%undecided)
      call carry(archive, solver%last_iterations)
      call carry(archive, solver%exact)
      call carry(archive, solver%solves)
      call carry(archive, solver%factors)
      call carry(archive, solver%iterations)
      call carry(archive, solver%handed_over)
      call carry_stale(archive, solver%stale, matrix)
      if (archive%reading .and. .not. allocated(archive%trouble)) call plan_method(solver, matrix)
   end subroutine carry_solver

   !> Numbers of the older factor; the matrix that they were made from is gone.
   subroutine carry_stale(archive, stale, matrix)
      type(archive_type), intent(inout) :: archive
      type(stale_factor_type), intent(inout) :: stale
      type(block_matrix_type), intent(in) :: matrix

      call carry_label(archive, 'factor')
      call carry(archive, stale%made)
      call carry(archive, stale%excess)
      if (.not. stale%made .or. allocated(archive%trouble)) return
      if (archive%reading) call analyse_stale(stale, matrix)
      call carry(archive, stale%factor%sliced)
      stale%made = .true.
      call carry_changes(archive, stale)
   end subroutine carry_stale

   !> The springs that have changed since the factor was made; what follows from them is made again.
   subroutine carry_changes(archive, stale)
      type(archive_type), intent(inout) :: archive
      type(stale_factor_type), intent(inout) :: stale
      logical :: done
      integer :: i

      associate (springs => stale%low%springs)
         call carry_number(archive, springs%n, 0, most_changes)
         do i = 1, springs%n
            call carry_list(archive, springs%block(:, i), 1, stale%factor%plan%n)
         end do
         call carry(archive, springs%u(:, :, :springs%n))
         call carry(archive, springs%k(:springs%n))
         if (.not. archive%reading .or. allocated(archive%trouble)) return
         done = all(abs(springs%k(:springs%n)) > 0.0_wp)
      end associate
      if (done) call follow_again(stale%low, stale%factor, done)
      if (.not. done) call spoil(archive, 'its changed springs do not fit its factor')
   end subroutine carry_changes

end module dda_solver_state
