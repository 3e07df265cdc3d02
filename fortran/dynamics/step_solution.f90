! SPDX-License-Identifier: GPL-3.0-or-later
!> Solve K̂ d = f̂ of a step; K̂ is not assembled if an earlier factorisation suffices.
!>
!> The residual f̂ − K̂d is the sum of the loads, the forces without contacts and the contact forces
!> at d.  If the contact springs are unchanged since a factorisation, its matrix differs from K̂
!> only by geometry (about 1e-6), and iterative refinement with this residual converges to d.  K̂
!> and f̂ are assembled only for a new factorisation and for iterative solvers.
module dda_step_solution
   use dda_kinds, only: wp
   use dda_abstract_solver, only: equations_type
   use dda_block_matrix, only: add_coupled_rows
   use dda_block_vectors, only: add_multiple
   use dda_body_drift, only: subtract_contacts
   use dda_contact, only: contacts_type
   use dda_contact_assembly, only: assemble_terms, index_contacts, rows_from
   use dda_contact_gradients, only: add_assumed_forces
   use dda_errors, only: error_type
   use dda_linear_solver, only: renew, solver_type, solve, solve_change, reuse_factor
   use dda_ordered_sums, only: find_thread_range
   use dda_rank_one, only: forget_changes
   use dda_stopwatch, only: record_lap, phase_factorise, phase_solve
   use dda_system, only: multiply_diagonal, system_type
   use dda_team, only: adjust_team
   implicit none
   private
   public :: solve_equations, find_residual

   !> Equations of a step, given by their residual without an assembled matrix.
   type, extends(equations_type) :: step_equations_type
      type(system_type), pointer :: system => null()      !< equations of the step
      type(contacts_type), pointer :: contacts => null()  !< contacts in their assumed states
   contains
      procedure :: residual
   end type step_equations_type

contains

   !> Solve K̂ d = f̂ with the contacts in their assumed states.
   !> If `change` is present, solve only for this change of f̂ (see `solve_change`).
   !> Forces that were added to f̂ remain sums of increments until the next solve without `added`,
   !> which assembles these rows again.
   subroutine solve_equations(system, solver, contacts, error, reduction, added, change)
      type(system_type), intent(inout), target :: system      !< equations of the step; d changes
      type(solver_type), intent(inout) :: solver              !< linear solver
      type(contacts_type), intent(inout), target :: contacts  !< contacts of this step
      type(error_type), allocatable, intent(out) :: error     !< allocated on failure
      real(wp), intent(in) :: reduction  !< required residual/first residual
      logical, intent(in), optional :: added  !< f̂ includes all changes since the last solve
      real(wp), intent(in), optional :: change(:,:)  !< [6,n] change of f̂ since the last solve, N
      logical :: success, assembled

      success = .false.
      if (system%contact_terms%rebuild) &
         call solve_unassembled(system, solver, contacts, reduction, success)
      if (success) return
      assembled = present(added) .and. .not. system%contact_terms%rebuild
      if (assembled) assembled = added
      if (.not. assembled) call renew_matrix(system, solver, contacts, error)
      if (allocated(error)) return
      call record_lap(system%watch, phase_factorise)
      if (.not. system%drifts) then
         call solve_for(system%rhs, system%d)
      else
         associate (n => system%matrix%n)
            system%reduced = system%rhs - system%drift_load
            call subtract_contacts(system%reduced, system%drift, contacts)
            call add_multiple(n, -1.0_wp, system%drift, system%d)
            call solve_for(system%reduced, system%d)
            call add_multiple(n, 1.0_wp, system%drift, system%d)
         end associate
      end if

   contains

      !> Solve K̂ x = b with the matrix of the step, or only for the change of f̂.
      subroutine solve_for(b, x)
         real(wp), intent(in) :: b(:,:)     !< [6,n] right-hand side, N
         real(wp), intent(inout) :: x(:,:)  !< [6,n] first guess; on return, solution, m

         if (present(change)) then
            call solve_change(solver, system%matrix, b, change, x, error, reduction)
         else
            call solve(solver, system%matrix, b, x, error, reduction)
         end if
      end subroutine solve_for
   end subroutine solve_equations

   !> Solve with an earlier factorisation, if no contact spring has changed since then.
   subroutine solve_unassembled(system, solver, contacts, reduction, success)
      type(system_type), intent(inout), target :: system      !< equations of the step; d changes
      type(solver_type), intent(inout) :: solver              !< linear solver
      type(contacts_type), intent(inout), target :: contacts  !< contacts of this step
      real(wp), intent(in) :: reduction  !< required residual/first residual
      logical, intent(out) :: success  !< d is the solution; if .false., K̂ is needed
      type(step_equations_type) :: equations

      success = .false.
      if (system%contact_terms%spring_changes%n > 0 .or. system%drifts .or. &
         allocated(contacts%imposed_spring)) return
      call index_contacts(system, contacts)
      equations%system => system
      equations%contacts => contacts
      call reuse_factor(solver, equations, system%d, reduction, success)
   end subroutine solve_unassembled

   !> Assemble K̂ and f̂, and renew the solver if K̂ has changed.
   subroutine renew_matrix(system, solver, contacts, error)
      type(system_type), intent(inout) :: system    !< equations of the step
      type(solver_type), intent(inout) :: solver    !< linear solver
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure

      call assemble_terms(system, contacts)
      associate (terms => system%contact_terms)
         if (terms%matrix_changed) call renew(solver, system%matrix, system%constant, &
            terms%spring_changes, error)
         terms%matrix_changed = .false.
         call forget_changes(terms%spring_changes)
      end associate
   end subroutine renew_matrix

   !> Compute the residual of the equations of the step.
   subroutine residual(self, x, r)
      class(step_equations_type), intent(in) :: self  !< equations
      real(wp), intent(in), contiguous :: x(:,:)      !< [6,n] d, m
      real(wp), intent(out), contiguous :: r(:,:)     !< [6,n] residual, N

      call find_residual(self%system, self%contacts, x, r)
   end subroutine residual

   !> Compute r = f̂ − K̂d without K̂, for contacts that are indexed.
   !> The result is bit-identical for any number of threads.
   subroutine find_residual(system, contacts, d, r)
      type(system_type), intent(in) :: system         !< equations of the step
      type(contacts_type), intent(in) :: contacts     !< contacts in their assumed states
      real(wp), intent(in), contiguous :: d(:,:)      !< [6,n] d, m
      real(wp), intent(out), contiguous :: r(:,:)     !< [6,n] residual, N
      integer :: first, last

      if (size(d, 2) < rows_from) then
         call find_residual_rows(system, contacts, d, r, 1, size(d, 2))
         return
      end if
      call adjust_team
      !$omp parallel private(first, last)
      call find_thread_range(size(d, 2), first, last)
      call find_residual_rows(system, contacts, d, r, first, last)
      !$omp end parallel
   end subroutine find_residual

   !> Compute block rows first … last of the residual; no other thread writes these rows.
   pure subroutine find_residual_rows(system, contacts, d, r, first, last)
      type(system_type), intent(in) :: system         !< equations of the step
      type(contacts_type), intent(in) :: contacts     !< contacts in their assumed states
      real(wp), intent(in), contiguous :: d(:,:)      !< [6,n] d, m
      real(wp), intent(inout), contiguous :: r(:,:)   !< [6,n] residual, N
      integer, intent(in) :: first, last              !< first and last row
      integer :: i, k, pair

      do i = first, last
         call multiply_diagonal(system, i, d(:, i), r(:, i))
      end do
      call add_coupled_rows(system%linear, first, last, d, r)
      r(:, first:last) = system%load(:, first:last) - r(:, first:last)
      call add_assumed_forces(contacts, first_of_row(contacts, first), &
         first_of_row(contacts, last + 1) - 1, size(d, 2), d, first, last, r)
      associate (matrix => system%matrix)
         do i = first, merge(0, last, last == matrix%n)
            do k = matrix%below_start(i), matrix%below_start(i + 1) - 1
               if (matrix%below_row(k) <= last) cycle
               pair = system%pair_of_entry(matrix%below_entry(k))
               call add_assumed_forces(contacts, system%first_contact(pair), &
                  system%first_contact(pair + 1) - 1, size(d, 2), d, first, last, r)
            end do
         end do
      end associate
   end subroutine find_residual_rows

   !> Return the first contact of a block with an earlier block, by bisection of the sorted list.
   pure integer function first_of_row(contacts, block)
      type(contacts_type), intent(in) :: contacts  !< list, sorted by the later block
      integer, intent(in) :: block                 !< block, or 1 after the last one
      integer :: low, middle

      low = 1
      first_of_row = contacts%n + 1
      do while (low < first_of_row)
         middle = (low + first_of_row)/2
         if (max(contacts%block_v(middle), contacts%block_e(middle)) < block) then
            low = middle + 1
         else
            first_of_row = middle
         end if
      end do
   end function first_of_row

end module dda_step_solution
