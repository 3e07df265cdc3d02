! SPDX-License-Identifier: GPL-3.0-or-later
!> Solution of K̂ d = f̂ by a solver chosen by name or rule, with the direct solver as fallback.
!>
!>     call analyse(solver, matrix)                        ! the pattern has changed
!>     call renew(solver, matrix, alone, changes, error)   ! the values have changed
!>     call solve(solver, matrix, b, x, error)
!>
!> Types that extend `linear_solver_type` are the methods.  `auto` uses `direct` for small models,
!> else `jacobi` or `lagged`, according to a bound on the iterations or their last number.
!> Computing times are not used, so that runs are reproducible.  The residual of every solve is
!> checked; if it is too large, the direct solver repeats the solve.
module dda_linear_solver
   use dda_interrupts, only: fail_within_step, stop_within_step
   use dda_kinds, only: wp, long
   use dda_abstract_solver, only: equations_type, linear_solver_type, convergence_type, accuracy, &
      acceptable
   use dda_block_jacobi, only: max_condition, most_iterations
   use dda_block_matrix, only: block_matrix_type, terms_of_product
   use dda_compact_block, only: compact_size
   use dda_errors, only: error_type, error_input, error_interrupted, error_memory, &
      error_solver, fail
   use dda_ordered_sums, only: inner_product
   use dda_rank_one, only: rank_one_type
   use dda_solver_table, only: solver_names, is_solver_name, make_solver
   use dda_text, only: counted, quoted, to_text
   implicit none
   private
   public :: solver_type, choose_solver, analyse, set_method, renew, weigh_loads, &
      record_rigid_terms, solve, solve_change, reuse_factor, work_done, solver_names, is_solver_name

   integer, parameter :: direct_up_to = 60        !< number of blocks up to which `auto` is `direct`
   !> largest number of Jacobi iterations that cost no more than a solve with a lagged factor
   integer, parameter :: few_jacobi_iterations = 30
   real(wp), parameter :: rounding = 1.0e-14_wp   !< attainable ‖r‖/‖b‖
   !> condition number above which a pivot may become negative in single precision; in double
   !> precision six digits remain
   real(wp), parameter :: well_conditioned = 1.0e10_wp
   !> largest number of factors with a larger diagonal for one pattern: solves at a coarse tolerance
   !> with such a factor omit soft modes, which is acceptable only in a few steps
   integer, parameter :: max_shifted_factors = 2
   !> largest ‖r‖/‖|K| |x|‖ for which x is exact for a matrix within rounding errors of K
   real(wp), parameter :: rounding_of_product = 4*epsilon(1.0_wp)

   !> The active solver and counts of its work.
   type :: solver_type
      ! unsaved, the input: name
      ! unsaved, recomputed in each step: loads, least_error
      character(len=6) :: name = 'auto'           !< name in the input
      character(len=6) :: method = ''  !< method in use; 'auto' until the first values are set
      class(linear_solver_type), allocatable :: active
      real(wp) :: loads = 0.0_wp  !< norm of the loads; residuals are relative to at least this
      real(wp) :: least_error = 0.0_wp  !< ‖error‖ of x below the rounding of the coordinates, m
      logical :: rigid = .false.  !< b includes very stiff terms that make blocks rigid
      integer :: last_iterations = 0              !< iterations of the last solve
      integer :: n_shifted = 0  !< number of factors with a larger diagonal, for this pattern
      logical :: exact = .true.                   !< the last solve had full accuracy
      integer(long) :: solves = 0                 !< number of solved systems
      integer(long) :: factors = 0                !< number of factors
      integer(long) :: iterations = 0             !< iterations of all solves
      integer(long) :: repeated_directly = 0      !< solves that the direct solver repeated
   end type solver_type

contains

   !> Choose a solver by name.
   subroutine choose_solver(solver, name, error)
      type(solver_type), intent(out) :: solver  !< solver without a pattern
      character(len=*), intent(in) :: name  !< name in the input
      type(error_type), allocatable, intent(out) :: error  !< the name is unknown
      integer :: i
      character(len=:), allocatable :: names

      solver%name = name
      if (is_solver_name(name)) return
      names = ''
      do i = 1, size(solver_names)
         names = names//' '//trim(solver_names(i))
      end do
      call fail(error, error_input, 'unknown solver '//quoted(name)//'; use one of:'//names)
   end subroutine choose_solver

   !> Analyse the pattern of a matrix; must be repeated only when the pattern changes.
   subroutine analyse(solver, matrix)
      type(solver_type), intent(inout) :: solver  !< solver and counts
      type(block_matrix_type), intent(in) :: matrix  !< matrix; its values are not read

      solver%n_shifted = 0
      if (solver%name == 'auto' .and. matrix%n > direct_up_to) then
         solver%method = 'auto'
      else
         call set_method(solver, matrix, merge('direct', solver%name, solver%name == 'auto'))
      end if
   end subroutine analyse

   !> Select a method and analyse the pattern of a matrix.
   subroutine set_method(solver, matrix, method)
      type(solver_type), intent(inout) :: solver  !< solver and counts
      type(block_matrix_type), intent(in) :: matrix  !< matrix; only its pattern is read
      character(len=*), intent(in) :: method  !< one of `solver_names`, except 'auto'

      solver%method = method
      if (allocated(solver%active)) then
         if (solver%active%name /= method) deallocate (solver%active)
      end if
      if (.not. allocated(solver%active)) call make_solver(method, solver%active)
      call solver%active%analyse(matrix)
   end subroutine set_method

   !> Set new values of a matrix with the analysed pattern.
   subroutine renew(solver, matrix, own_terms, changes, error)
      type(solver_type), intent(inout) :: solver  !< solver and counts
      type(block_matrix_type), intent(in) :: matrix  !< K̂
      !> part of each diagonal block from terms of that block alone, for the bound `most_iterations`
      real(wp), intent(in) :: own_terms(compact_size, matrix%n)
      type(rank_one_type), intent(in) :: changes  !< changes of the values since the last call
      type(error_type), allocatable, intent(out) :: error  !< a pivot is not positive

      if (solver%name == 'auto') call choose_jacobi_or_lagged(solver, matrix, own_terms)
      call solver%active%renew(matrix, changes, error)
      call count_factors(solver)
      if (.not. allocated(error) .or. solver%method == 'direct') return
      if (any(error%kind == [error_memory, error_interrupted])) return
      if (solver%n_shifted < max_shifted_factors) then
         if (max_condition(matrix, own_terms) <= well_conditioned) then
            call solver%active%renew_shifted(matrix, error)
            call count_factors(solver)
            solver%n_shifted = solver%n_shifted + 1
         end if
      end if
      if (allocated(error)) call use_direct_solver(solver, matrix, error)
   end subroutine renew

   !> Choose `jacobi` or `lagged`: first by the guaranteed bound, later by the last iteration count.
   subroutine choose_jacobi_or_lagged(solver, matrix, own_terms)
      type(solver_type), intent(inout) :: solver  !< solver and counts
      type(block_matrix_type), intent(in) :: matrix  !< K̂
      real(wp), intent(in) :: own_terms(compact_size, matrix%n)  !< see `renew`
      character(len=6) :: method

      method = solver%method
      if (solver%method == 'auto') then
         method = 'lagged'
         if (0.5_wp*most_iterations(matrix, own_terms, accuracy) <= 2*few_jacobi_iterations) &
            method = 'jacobi'
      else if (solver%method == 'jacobi' .and. solver%last_iterations > few_jacobi_iterations) then
         method = 'lagged'
      end if
      if (method /= solver%method) call set_method(solver, matrix, method)
   end subroutine choose_jacobi_or_lagged

   !> Use the direct solver until the pattern changes.
   subroutine use_direct_solver(solver, matrix, error)
      type(solver_type), intent(inout) :: solver  !< solver and counts
      type(block_matrix_type), intent(in) :: matrix  !< K̂
      type(error_type), allocatable, intent(out) :: error  !< a pivot is not positive

      solver%repeated_directly = solver%repeated_directly + 1
      call set_method(solver, matrix, 'direct')
      call solver%active%renew(matrix, rank_one_type(), error)
      call count_factors(solver)
   end subroutine use_direct_solver

   !> Add the factors of the last call to the count.
   subroutine count_factors(solver)
      type(solver_type), intent(inout) :: solver  !< solver and counts

      solver%factors = solver%factors + solver%active%factors
      solver%active%factors = 0
   end subroutine count_factors

   !> Set the loads of the next right-hand sides, which scale the accepted residuals.
   !> Residuals may reach the rounding errors of these loads.
   subroutine weigh_loads(solver, load)
      type(solver_type), intent(inout) :: solver  !< solver and counts
      real(wp), intent(in) :: load(:,:)  !< [6,n] loads, N

      solver%loads = sqrt(inner_product(size(load, 2), load, load))
      solver%rigid = .false.
   end subroutine weigh_loads

   !> Record that the matrix and b contain terms that make blocks rigid.
   !> Such terms far exceed the forces, so a residual relative to b would not resolve the forces.
   pure subroutine record_rigid_terms(solver)
      type(solver_type), intent(inout) :: solver  !< solver and counts

      solver%rigid = .true.
   end subroutine record_rigid_terms

   !> Solve K x = b from the given x, to full accuracy or to a fraction of the first residual.
   subroutine solve(solver, matrix, b, x, error, reduction)
      type(solver_type), intent(inout) :: solver  !< solver and counts
      type(block_matrix_type), intent(in) :: matrix  !< matrix of the last call of `renew`
      real(wp), intent(in) :: b(6, matrix%n)  !< right-hand side, N
      real(wp), intent(inout) :: x(6, matrix%n)  !< first guess, becomes the solution, m
      type(error_type), allocatable, intent(out) :: error  !< a pivot is not positive
      !> required residual/first residual; if absent, full accuracy
      real(wp), intent(in), optional :: reduction
      type(convergence_type) :: convergence

      convergence%scale = residual_scale(solver, b)
      if (present(reduction)) convergence%reduction = reduction
      solver%solves = solver%solves + 1
      do
         call solver%active%solve(matrix, b, x, convergence)
         call count_factors(solver)
         solver%last_iterations = solver%active%iterations
         solver%iterations = solver%iterations + solver%last_iterations
         solver%exact = convergence%residual <= accuracy .or. .not. convergence%reached &
            .or. convergence%reduction <= 0.0_wp
         if (convergence%residual <= acceptable .or. convergence%reached) return
         if (convergence%residual*convergence%scale &
            <= rounding_of_product*terms_of_product(matrix, x)) return
         if (stop_within_step()) then
            call fail_within_step(error)
            return
         end if
         if (solver%method == 'direct') exit
         call use_direct_solver(solver, matrix, error)
         if (allocated(error)) return
      end do
      call fail(error, error_solver, 'the linear system cannot be solved: relative residual '// &
         to_text(convergence%residual)//', allowed '//to_text(acceptable))
   end subroutine solve

   !> Solve K x = b with an earlier factor of nearly the same K, if there is one.
   !> If low accuracy suffices, an iteration with the assembled matrix takes less time (3 %
   !> in shaken walls of 1,000 bricks).
   subroutine reuse_factor(solver, equations, x, reduction, success)
      type(solver_type), intent(inout) :: solver      !< solver and counts
      class(equations_type), intent(in) :: equations  !< K x = b
      real(wp), intent(inout), contiguous :: x(:,:)   !< [6,n] first guess, becomes the solution, m
      real(wp), intent(in) :: reduction  !< required residual/first residual
      logical, intent(out) :: success                    !< .false.: x is not the solution
      type(convergence_type) :: convergence

      success = .false.
      if (.not. allocated(solver%active)) return
      if (reduction > 0.0_wp .and. solver%method /= 'direct') return
      convergence%scale = solver%loads
      convergence%least_error = solver%least_error
      call solver%active%reuse_factor(equations, x, convergence, success)
      solver%iterations = solver%iterations + solver%active%iterations
      if (.not. success) return
      solver%solves = solver%solves + 1
      solver%last_iterations = solver%active%iterations
      solver%exact = .true.
   end subroutine reuse_factor

   !> Update x after a small change of b, or with low accuracy.
   !> If one preconditioner application sufficed in the last solve with this matrix, it is used
   !> again; else the system is solved.
   subroutine solve_change(solver, matrix, b, change, x, error, reduction)
      type(solver_type), intent(inout) :: solver  !< solver and counts
      type(block_matrix_type), intent(in) :: matrix  !< matrix of the last `renew` and solve
      real(wp), intent(in) :: b(6, matrix%n)  !< changed right-hand side, N
      real(wp), intent(in) :: change(6, matrix%n)  !< change of the right-hand side, N
      real(wp), intent(inout) :: x(6, matrix%n)  !< last solution; on return the new solution, m
      type(error_type), allocatable, intent(out) :: error  !< a pivot is not positive
      real(wp), intent(in) :: reduction  !< required residual/first residual
      logical :: success

      call solver%active%correct(matrix%n, change, x, success)
      if (.not. success) then
         call solve(solver, matrix, b, x, error, reduction)
         return
      end if
      solver%solves = solver%solves + 1
      solver%iterations = solver%iterations + 1
      solver%exact = .false.
   end subroutine solve_change

   !> Return the scale of residuals: the norm of b, or of the loads if they nearly cancel in b.
   !> For rigid terms, it is the rounding error of b.
   real(wp) function residual_scale(solver, b) result(scale)
      type(solver_type), intent(in) :: solver  !< solver and counts
      real(wp), intent(in) :: b(:,:)  !< [6,n] right-hand side, N

      scale = sqrt(inner_product(size(b, 2), b, b))
      if (solver%rigid) scale = rounding/accuracy*scale
      if (scale < solver%loads) scale = solver%loads  ! NaN remains NaN
   end function residual_scale

   !> Return a text on the numbers of solves, factors and iterations so far.
   pure function work_done(solver) result(text)
      type(solver_type), intent(in) :: solver  !< solver and counts
      character(len=:), allocatable :: text

      text = trim(solver%method)//', '//counted(to_text(solver%solves), 'system', 'systems')// &
         ' solved, '//counted(to_text(solver%factors), 'factor', 'factors')//', '// &
         counted(to_text(solver%iterations), 'iteration', 'iterations')//', '// &
         counted(to_text(solver%repeated_directly), 'solve', 'solves')//' repeated by the '// &
         'direct solver'
   end function work_done

end module dda_linear_solver
