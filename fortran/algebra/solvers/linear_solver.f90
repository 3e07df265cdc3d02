!> K̂ d = f̂ behind one interface: a few solvers, chosen by name or by rule.
!>
!>     call analyse(solver, matrix)                        ! the pattern has changed
!>     call renew(solver, matrix, alone, changes, error)   ! the numbers have changed
!>     call solve(solver, matrix, b, x, error)
!>
!> `direct` factorises each matrix; `jacobi` is conjugate gradients with the diagonal blocks, for
!> small p Δt²/m; `stale` is conjugate gradients with an older factor in single precision; `banded`
!> is LAPACK's band factor; `sor` is the original DDA's.  `auto` takes `direct` for small models,
!> else `jacobi` or `stale` by the bound on the iterations and then by their last count.  All rules
!> count; none looks at a clock, so that runs are reproducible.  Every solve ends with a checked
!> residual; a solver that does not reach it hands over to the direct one.
module dda_linear_solver
   use dda_kinds, only: wp, long
   use dda_errors, only: error_type, error_input, error_solver, fail
   use dda_text, only: quoted, to_text
   use dda_band_cholesky, only: band_cholesky_type, analyse_band, factorise_band, solve_band
   use dda_block_cholesky, only: cholesky_type, analyse_factor => analyse, factorise, &
      solve_factor => solve
   use dda_block_jacobi, only: block_jacobi_type, invert_diagonal, most_iterations
   use dda_block_matrix, only: block_matrix_type, multiply
   use dda_conjugate_gradients, only: workspace_type, make_workspace, iterate_to_solution
   use dda_ordered_sums, only: inner_product
   use dda_rank_one, only: rank_one_type
   use dda_relaxation, only: relax_to_solution
   use dda_lagged_factor, only: lagged_factor_type, analyse_lagged, refresh, follow
   implicit none
   private
   public :: solver_type, choose_solver, analyse, plan_method, renew, weigh_loads, solve, &
      work_done, solver_names

   character(len=*), parameter :: solver_names(6) = [character(len=6) :: 'auto', 'direct', &
      'stale', 'jacobi', 'banded', 'sor']

   integer, parameter :: small = 60                  !< blocks up to which `auto` is `direct`
   !> Jacobi iterations that cost no more than a stale solve
   integer, parameter :: few = 30
   integer, parameter :: most_stale = 60, most_jacobi = 3000, most_sweeps = 200000
   real(wp), parameter :: accuracy = 1.0e-11_wp      !< ‖r‖/‖b‖ that iterations reach
   integer, parameter :: fresh = 4                   !< iterations that a good factor may take
   !> iterations beyond it that cost as much as a new factor
   integer, parameter :: worth = 8
   real(wp), parameter :: acceptable = 1.0e-9_wp     !< ‖r‖/‖b‖ above which a solve has failed

   !> A solver with its factors and what it has done.
   type :: solver_type
      character(len=6) :: name = 'auto'              !< as chosen
      character(len=6) :: method = ''                !< at work
      type(cholesky_type) :: direct
      type(band_cholesky_type) :: band
      type(lagged_factor_type) :: stale
      type(block_jacobi_type) :: jacobi
      type(workspace_type) :: work
      logical :: direct_planned = .false.            !< `direct` knows the pattern
      logical :: undecided = .true.                  !< `auto` has to choose again
      real(wp) :: loads = 0.0_wp                     !< least size that residuals are measured by
      integer :: last_iterations = 0                 !< of the last iterative solve
      logical :: exact = .true.                      !< the last solve was to full accuracy
      integer(long) :: solves = 0                    !< systems solved
      integer(long) :: factors = 0                   !< factors made
      integer(long) :: iterations = 0                !< of iterative solves
      integer(long) :: handed_over = 0               !< solves that the chosen solver could not do
   end type solver_type

contains

   !> Choose by name.
   subroutine choose_solver(solver, name, error)
      type(solver_type), intent(out) :: solver
      character(len=*), intent(in) :: name
      type(error_type), allocatable, intent(out) :: error
      integer :: i
      character(len=:), allocatable :: known

      solver%name = name
      if (any(solver_names == name)) return
      known = ''
      do i = 1, size(solver_names)
         known = known//' '//trim(solver_names(i))
      end do
      call fail(error, error_input, 'solver '//quoted(name)//' is not known; there are:'//known)
   end subroutine choose_solver

   !> Prepare for a pattern; needed again only when the pattern changes.
   subroutine analyse(solver, matrix)
      type(solver_type), intent(inout) :: solver
      type(block_matrix_type), intent(in) :: matrix

      solver%method = solver%name
      solver%undecided = solver%name == 'auto'
      if (solver%undecided .and. matrix%n <= small) then
         solver%method = 'direct'
         solver%undecided = .false.
      end if
      solver%direct_planned = .false.
      solver%stale%made = .false.
      if (allocated(solver%work%r)) then
         if (size(solver%work%r, 2) /= matrix%n) call make_workspace(solver%work, matrix%n)
      else
         call make_workspace(solver%work, matrix%n)
      end if
      call plan_method(solver, matrix)
   end subroutine analyse

   !> The symbolic work of the method at work.
   subroutine plan_method(solver, matrix)
      type(solver_type), intent(inout) :: solver
      type(block_matrix_type), intent(in) :: matrix

      select case (solver%method)
      case ('direct')
         if (.not. solver%direct_planned) call analyse_factor(solver%direct, matrix)
         solver%direct_planned = .true.
      case ('banded')
         call analyse_band(solver%band, matrix)
      case ('stale')
         if (.not. solver%stale%made) call analyse_lagged(solver%stale, matrix)
      end select
   end subroutine plan_method

   !> Take new values of a matrix with the analysed pattern.
   subroutine renew(solver, matrix, alone, changes, error)
      type(solver_type), intent(inout) :: solver
      type(block_matrix_type), intent(in) :: matrix
      real(wp), intent(in) :: alone(6, 6, matrix%n)  !< diagonal blocks without contacts
      type(rank_one_type), intent(in) :: changes     !< springs that differ from the last values
      type(error_type), allocatable, intent(out) :: error

      if (solver%name == 'auto' .and. matrix%n > small) call decide(solver, matrix, alone)
      select case (solver%method)
      case ('direct')
         call factorise(solver%direct, matrix, error)
         solver%factors = solver%factors + 1
      case ('banded')
         call factorise_band(solver%band, matrix, error)
         solver%factors = solver%factors + 1
      case ('jacobi', 'sor')
         call invert_diagonal(solver%jacobi, matrix)
      case ('stale')
         call renew_lagged(solver, matrix, changes, error)
      end select
   end subroutine renew

   !> Jacobi or stale: by the guaranteed bound at first, then by what the last solve needed.
   subroutine decide(solver, matrix, alone)
      type(solver_type), intent(inout) :: solver
      type(block_matrix_type), intent(in) :: matrix
      real(wp), intent(in) :: alone(6, 6, matrix%n)
      character(len=6) :: method

      method = solver%method
      if (solver%undecided) then
         method = 'stale'
         if (0.5_wp*most_iterations(matrix, alone, accuracy) <= 2*few) method = 'jacobi'
      else if (solver%method == 'jacobi' .and. solver%last_iterations > few) then
         method = 'stale'
      end if
      solver%undecided = .false.
      if (method == solver%method) return
      solver%method = method
      call plan_method(solver, matrix)
   end subroutine decide

   !> Keep the old factor while it can follow the springs that change and has not yet cost as many
   !> iterations as a new one.
   subroutine renew_lagged(solver, matrix, changes, error)
      type(solver_type), intent(inout) :: solver
      type(block_matrix_type), intent(in) :: matrix
      type(rank_one_type), intent(in) :: changes
      type(error_type), allocatable, intent(out) :: error
      logical :: good

      good = solver%stale%made .and. solver%stale%excess <= worth
      if (good .and. changes%n > 0) call follow(solver%stale, changes, good)
      if (good) return
      call refresh(solver%stale, matrix, error)
      solver%factors = solver%factors + 1
      if (.not. allocated(error)) return
      ! A pivot lost to single precision: the direct solver takes over.
      deallocate (error)
      call hand_over(solver, matrix, error)
   end subroutine renew_lagged

   !> Solve with the direct solver from here on.
   subroutine hand_over(solver, matrix, error)
      type(solver_type), intent(inout) :: solver
      type(block_matrix_type), intent(in) :: matrix
      type(error_type), allocatable, intent(out) :: error

      solver%handed_over = solver%handed_over + 1
      solver%method = 'direct'
      call plan_method(solver, matrix)
      call factorise(solver%direct, matrix, error)
      solver%factors = solver%factors + 1
   end subroutine hand_over

   !> Tell what loads the right sides to come are the balance of: residuals need not be smaller than
   !> rounding of these.
   subroutine weigh_loads(solver, load)
      type(solver_type), intent(inout) :: solver
      real(wp), intent(in) :: load(:,:)  !< [6,n]

      solver%loads = sqrt(inner_product(size(load, 2), load, load))
   end subroutine weigh_loads

   !> x = K⁻¹ b; iterative methods begin at the x given, and may stop at a share of its residual.
   subroutine solve(solver, matrix, b, x, error, reduction)
      type(solver_type), intent(inout) :: solver
      type(block_matrix_type), intent(in) :: matrix
      real(wp), intent(in) :: b(6, matrix%n)
      real(wp), intent(inout) :: x(6, matrix%n)
      type(error_type), allocatable, intent(out) :: error
      !> share of the first residual that is enough; else full accuracy
      real(wp), intent(in), optional :: reduction
      real(wp) :: residual, share
      logical :: enough

      share = 0.0_wp
      if (present(reduction)) share = reduction
      enough = .false.
      solver%solves = solver%solves + 1
      select case (solver%method)
      case ('direct', 'banded')
         call solve_directly(solver, matrix, b, x, residual)
      case ('jacobi')
         call iterate_to_solution(matrix, solver%jacobi, b, size_of(solver, b), x, accuracy, &
            share, most_jacobi, solver%work, solver%last_iterations, residual, enough)
      case ('sor')
         call relax_to_solution(matrix, solver%jacobi, b, x, accuracy, most_sweeps, solver%work%r, &
            solver%last_iterations, residual)
      case default
         call solve_lagged(solver, matrix, b, x, share, residual, enough, error)
      end select
      if (allocated(error)) return
      if (solver%method /= 'direct' .and. solver%method /= 'banded') &
         solver%iterations = solver%iterations + solver%last_iterations
      solver%exact = residual <= accuracy .or. .not. enough .or. share <= 0.0_wp
      if (residual <= acceptable .or. enough) return
      if (solver%method /= 'direct') call hand_over(solver, matrix, error)
      if (.not. allocated(error)) call solve_directly(solver, matrix, b, x, residual)
      if (.not. allocated(error) .and. .not. residual <= acceptable) &
         call fail(error, error_solver, 'the linear system cannot be solved: relative residual '// &
         to_text(residual)//', allowed '//to_text(acceptable))
   end subroutine solve

   !> What residuals are measured by: b, or the loads that it is the balance of, which may all but
   !> cancel.
   real(wp) function size_of(solver, b)
      type(solver_type), intent(in) :: solver
      real(wp), intent(in) :: b(:,:)

      size_of = sqrt(inner_product(size(b, 2), b, b))
      if (size_of < solver%loads) size_of = solver%loads  ! what is no number stays none
   end function size_of

   !> Solve with the factor at hand, then refine once if the residual asks for it.
   subroutine solve_directly(solver, matrix, b, x, residual)
      type(solver_type), intent(inout) :: solver
      type(block_matrix_type), intent(in) :: matrix
      real(wp), intent(in) :: b(6, matrix%n)
      real(wp), intent(inout) :: x(6, matrix%n)
      real(wp), intent(out) :: residual
      integer :: round

      x = 0.0_wp
      call solve_by_factor(solver, b, solver%work%z)
      do round = 1, 2
         x = x + solver%work%z
         call multiply(matrix, x, solver%work%q)
         solver%work%r = b - solver%work%q
         residual = sqrt(inner_product(matrix%n, solver%work%r, &
            solver%work%r))/max(size_of(solver, b), tiny(1.0_wp))
         if (residual <= accuracy .or. round == 2) return
         call solve_by_factor(solver, solver%work%r, solver%work%z)
      end do
   end subroutine solve_directly

   subroutine solve_by_factor(solver, b, x)
      type(solver_type), intent(inout) :: solver
      real(wp), intent(in) :: b(:,:)
      real(wp), intent(out) :: x(:,:)

      if (solver%method == 'banded') then
         call solve_band(solver%band, b, x)
      else
         call solve_factor(solver%direct, b, x)
      end if
   end subroutine solve_by_factor

   !> Iterate with the old factor; if it has grown too old for this matrix, make it anew.
   subroutine solve_lagged(solver, matrix, b, x, reduction, residual, enough, error)
      type(solver_type), intent(inout) :: solver
      type(block_matrix_type), intent(in) :: matrix
      real(wp), intent(in) :: b(6, matrix%n)
      real(wp), intent(inout) :: x(6, matrix%n)
      real(wp), intent(in) :: reduction
      real(wp), intent(out) :: residual
      logical, intent(out) :: enough
      type(error_type), allocatable, intent(out) :: error
      integer :: attempt

      do attempt = 1, 2
         call iterate_to_solution(matrix, solver%stale, b, size_of(solver, b), x, accuracy, &
            reduction, most_stale, solver%work, solver%last_iterations, residual, enough)
         solver%stale%excess = solver%stale%excess + max(0, solver%last_iterations - fresh)
         if (enough .or. attempt == 2) return
         x = 0.0_wp
         call refresh(solver%stale, matrix, error)
         solver%factors = solver%factors + 1
         if (allocated(error)) return
      end do
   end subroutine solve_lagged

   !> What the solver did so far, in words.
   pure function work_done(solver) result(text)
      type(solver_type), intent(in) :: solver
      character(len=:), allocatable :: text

      text = trim(solver%method)//', '//to_text(solver%solves)//' systems solved, '// &
         to_text(solver%factors)//' factors, '//to_text(solver%iterations)//' iterations, '// &
         to_text(solver%handed_over)//' solves handed over to the direct solver'
   end function work_done

end module dda_linear_solver
