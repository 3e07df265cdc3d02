! SPDX-License-Identifier: GPL-3.0-or-later
!> Nonlinear soil column under shear waves from below: cells of constant strain between nodes.
!>
!> The midpoint rule, v₁ = 2Δu/Δt − v₀, with forces at the middle of the step:
!>
!>     M (v₁ − v₀)/Δt + Bᵀ τ(Δγ) = f .
!>
!> M is the mean of the lumped and the consistent mass, which makes the error of waves of the order
!> (kh)⁴.  The base moves with the given acceleration, or rests on a half-space.  A dashpot ρ v of
!> the half-space acts on the velocity relative to the outcrop, f = ρ v (v_outcrop − Δu/Δt).  Apart
!> from small-strain damping, each step minimises a convex function.  It is solved by Newton's
!> method, with half steps while the residual grows.  The work at the base equals stored, kinetic
!> and dissipated energy.
module dda_shear_column
   use dda_kinds, only: wp
   use dda_branches, only: branches_type
   use dda_branch_law, only: response_type, respond, respond_body, advance_branches, advance_body, &
      stored_by_branches, stored_by_body
   use dda_errors, only: error_type, error_convergence, fail
   use dda_text, only: to_text
   implicit none
   private
   public :: shear_column_type, shear_state_type, begin_column, shake_column, end_accelerations, &
      energy_balance

   integer, parameter :: most_iterations = 100
   integer, parameter :: max_halvings = 12
   real(wp), parameter :: tolerance = 1.0e-11_wp  !< relative tolerance of forces

   !> A column, from the surface downwards.
   type :: shear_column_type
      real(wp), allocatable :: thickness(:)   !< [cells] h, m
      real(wp), allocatable :: density(:)     !< [cells] ρ, kg/m³
      real(wp), allocatable :: modulus(:)     !< [cells] G of small strains, Pa
      integer, allocatable :: soil(:)         !< [cells] number of the soil
      type(branches_type), allocatable :: branches(:)  !< [soils]
      real(wp) :: dashpot = 0.0_wp  !< ρ v of the half-space, Pa s/m; 0: the base motion is given
   end type shear_column_type

   !> State of the column.
   type :: shear_state_type
      real(wp), allocatable :: displacement(:), velocity(:)  !< [cells+1] m, m/s
      real(wp), allocatable :: strain(:)      !< [cells] γ
      real(wp), allocatable :: stress(:)      !< [cells] τ at the end of the step, Pa
      real(wp), allocatable :: largest(:,:)   !< [2,cells] |γ| and |τ| (Pa) of all steps so far
      real(wp), allocatable :: body_strain(:) !< [cells] e of the small-strain body
      real(wp), allocatable :: elastic(:,:)   !< [branches,cells] e of slipping branches
      real(wp), allocatable :: memory(:,:)    !< [mechanisms,cells] ζ
      real(wp) :: reaction = 0.0_wp           !< force on the base in the last step, Pa
      real(wp) :: work = 0.0_wp               !< work at the base, J/m²
      real(wp) :: slipped = 0.0_wp            !< loss by slip, J/m²
      real(wp) :: damped = 0.0_wp             !< loss by the small-strain mechanisms, J/m²
      integer :: iterations = 0               !< iterations of the last step
   end type shear_state_type

contains

   !> Create a column at rest.
   subroutine begin_column(column, state)
      type(shear_column_type), intent(in) :: column  !< column
      type(shear_state_type), intent(out) :: state  !< state of the column, at rest
      integer :: n

      n = size(column%thickness)
      allocate (state%displacement(n + 1), state%velocity(n + 1), state%strain(n), &
         state%stress(n), state%body_strain(n), source=0.0_wp)
      allocate (state%largest(2, n), source=0.0_wp)
      allocate (state%elastic(maxval(column%branches%n), n), &
         state%memory(max(1, maxval(column%branches%body%n)), n), source=0.0_wp)
   end subroutine begin_column

   !> Perform one step.
   subroutine shake_column(column, time_step, base_acceleration, state, error)
      type(shear_column_type), intent(in) :: column  !< column
      real(wp), intent(in) :: time_step  !< Δt, s
      !> mean velocity in the step of the base, or of the outcrop of the half-space, m/s
      real(wp), intent(in) :: base_acceleration
      type(shear_state_type), intent(inout) :: state  !< state of the column
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      real(wp), dimension(size(state%velocity)) :: d, residual, load
      real(wp), dimension(size(state%strain)) :: stress, tangent
      real(wp) :: scale
      integer :: i

      load = 2.0_wp/time_step*mass_times(column, state%velocity)
      load(size(load)) = load(size(load)) + column%dashpot*base_acceleration
      d = time_step*state%velocity
      if (column%dashpot <= 0.0_wp) d(size(d)) = time_step*base_acceleration
      call find_forces(column, state, time_step, load, d, stress, tangent, residual, scale)
      do i = 0, most_iterations - 1
         if (all(abs(residual) <= tolerance*scale)) exit
         call iterate_newton(column, state, time_step, load, d, stress, tangent, residual, scale)
      end do
      state%iterations = i
      if (.not. all(abs(residual) <= tolerance*scale)) then  ! .true. for NaN as well
         call fail(error, error_convergence, 'the column does not converge in '// &
            to_text(most_iterations)//' iterations')
         return
      end if
      call end_step(column, state, time_step, base_acceleration, d, stress, load)
   end subroutine shake_column

   !> Perform one iteration of Newton's method; its step is halved while the residual grows.
   subroutine iterate_newton(column, state, time_step, load, d, stress, tangent, residual, scale)
      type(shear_column_type), intent(in) :: column    !< column
      type(shear_state_type), intent(in) :: state      !< state at the start of the step
      real(wp), intent(in) :: time_step                !< Δt, s
      real(wp), intent(in) :: load(:)                  !< [nodes] Pa
      real(wp), intent(inout) :: d(:)                  !< [nodes] Δu, m
      real(wp), intent(inout) :: stress(:), tangent(:) !< [cells] stress and tangent at d, Pa
      real(wp), intent(inout) :: residual(:)           !< [nodes] residual at d, Pa
      real(wp), intent(inout) :: scale                 !< largest force, Pa
      real(wp) :: correction(size(d)), from(size(d)), initial_residual, factor
      integer :: halving

      call solve_tangents(column, time_step, tangent, residual, correction)
      from = d
      initial_residual = maxval(abs(residual))
      factor = 1.0_wp
      do halving = 0, max_halvings
         d = from + factor*correction
         call find_forces(column, state, time_step, load, d, stress, tangent, residual, scale)
         if (maxval(abs(residual)) < max(initial_residual, tolerance*scale)) exit
         factor = 0.5_wp*factor
      end do
   end subroutine iterate_newton

   !> Compute stresses, tangents and residual forces for given displacement increments of the nodes.
   pure subroutine find_forces(column, state, time_step, load, d, stress, tangent, residual, scale)
      type(shear_column_type), intent(in) :: column  !< column
      type(shear_state_type), intent(in) :: state    !< state at the start of the step
      real(wp), intent(in) :: time_step              !< Δt, s
      real(wp), intent(in) :: load(:), d(:)          !< [nodes] Pa; Δu, m
      real(wp), intent(out) :: stress(:)             !< [cells] stress in the step, Pa
      real(wp), intent(out) :: tangent(:)            !< [cells] derivatives with respect to Δγ, Pa
      real(wp), intent(out) :: residual(:)           !< [nodes] Pa
      real(wp), intent(out) :: scale                 !< Pa
      type(response_type) :: soil, body
      real(wp) :: change, body_change
      integer :: i, n

      n = size(stress)
      do i = 1, n
         change = (d(i) - d(i + 1))/column%thickness(i)
         associate (branches => column%branches(column%soil(i)))
            soil = respond(branches, state%elastic(:, i), state%strain(i), change)
            call respond_body(branches, state%memory(:, i), state%body_strain(i), change, &
               time_step, body, body_change)
         end associate
         stress(i) = column%modulus(i)*(soil%acting + body%acting)
         tangent(i) = column%modulus(i)*(soil%tangent + body%tangent)
      end do
      residual = load - 2.0_wp/time_step**2*mass_times(column, d)
      residual(n + 1) = residual(n + 1) - column%dashpot/time_step*d(n + 1)
      residual(:n) = residual(:n) - stress
      residual(2:) = residual(2:) + stress
      if (column%dashpot <= 0.0_wp) residual(n + 1) = 0.0_wp
      scale = max(maxval(abs(load)), maxval(abs(stress)))
   end subroutine find_forces

   !> Solve the tangent equations for the correction of Δu.
   !> Elimination proceeds from the surface downwards.
   pure subroutine solve_tangents(column, time_step, tangent, residual, correction)
      type(shear_column_type), intent(in) :: column  !< column
      real(wp), intent(in) :: time_step     !< Δt, s
      real(wp), intent(in) :: tangent(:)    !< [cells] Pa
      real(wp), intent(in) :: residual(:)   !< [nodes] Pa
      real(wp), intent(out) :: correction(:)  !< [nodes] m
      real(wp) :: diagonal(size(correction)), off_diagonal(size(tangent))
      integer :: n

      n = size(tangent)
      call assemble_mass(column, diagonal, off_diagonal)
      diagonal = 2.0_wp/time_step**2*diagonal
      off_diagonal = 2.0_wp/time_step**2*off_diagonal - tangent/column%thickness
      diagonal(:n) = diagonal(:n) + tangent/column%thickness
      diagonal(2:) = diagonal(2:) + tangent/column%thickness
      diagonal(n + 1) = diagonal(n + 1) + column%dashpot/time_step
      if (column%dashpot <= 0.0_wp) then
         diagonal(n + 1) = 1.0_wp
         off_diagonal(n) = 0.0_wp
      end if
      call solve_tridiagonal(diagonal, off_diagonal, residual, correction)
   end subroutine solve_tangents

   !> Solve with a symmetric positive definite tridiagonal matrix.
   pure subroutine solve_tridiagonal(diagonal, off_diagonal, rhs, x)
      real(wp), intent(inout) :: diagonal(:)  !< [n] diagonal, overwritten
      real(wp), intent(in) :: off_diagonal(:)       !< [n-1]
      real(wp), intent(in) :: rhs(:)        !< [n]
      real(wp), intent(out) :: x(:)           !< [n] vector
      integer :: i

      x = rhs
      do i = 2, size(x)
         associate (factor => off_diagonal(i - 1)/diagonal(i - 1))
            diagonal(i) = diagonal(i) - factor*off_diagonal(i - 1)
            x(i) = x(i) - factor*x(i - 1)
         end associate
      end do
      x(size(x)) = x(size(x))/diagonal(size(x))
      do i = size(x) - 1, 1, -1
         x(i) = (x(i) - off_diagonal(i)*x(i + 1))/diagonal(i)
      end do
   end subroutine solve_tridiagonal

   !> Mass matrix M, the mean of lumped and consistent mass.
   pure subroutine assemble_mass(column, diagonal, off_diagonal)
      type(shear_column_type), intent(in) :: column  !< column
      real(wp), intent(out) :: diagonal(:), off_diagonal(:)  !< [nodes], [cells] kg/m²
      integer :: n

      n = size(off_diagonal)
      associate (mass => column%density*column%thickness)
         off_diagonal = mass/12.0_wp
         diagonal = 0.0_wp
         diagonal(:n) = 5.0_wp/12.0_wp*mass
         diagonal(2:) = diagonal(2:) + 5.0_wp/12.0_wp*mass
      end associate
   end subroutine assemble_mass

   !> Product M x.
   pure function mass_times(column, x) result(product_of)
      type(shear_column_type), intent(in) :: column  !< column
      real(wp), intent(in) :: x(:)   !< [nodes]
      real(wp) :: product_of(size(x)), diagonal(size(x)), off_diagonal(size(x) - 1)

      call assemble_mass(column, diagonal, off_diagonal)
      product_of = diagonal*x
      product_of(:size(off_diagonal)) = product_of(:size(off_diagonal)) + off_diagonal*x(2:)
      product_of(2:) = product_of(2:) + off_diagonal*x(:size(off_diagonal))
   end function mass_times

   !> Advance the state to the end of a step.
   subroutine end_step(column, state, time_step, base_velocity, d, stress, load)
      type(shear_column_type), intent(in) :: column  !< column
      type(shear_state_type), intent(inout) :: state  !< state of the column
      real(wp), intent(in) :: time_step      !< Δt, s
      real(wp), intent(in) :: base_velocity           !< velocity of base or outcrop, m/s
      real(wp), intent(in) :: d(:), load(:)  !< [nodes] Δu, m; Pa
      real(wp), intent(in) :: stress(:)      !< [cells] stress in the step, Pa
      real(wp) :: force(size(d))
      integer :: i, n

      n = size(stress)
      if (column%dashpot > 0.0_wp) then
         state%reaction = column%dashpot*(base_velocity - d(n + 1)/time_step)
      else
         force = 2.0_wp/time_step**2*mass_times(column, d) - load
         state%reaction = force(n + 1) - stress(n)
      end if
      state%work = state%work + state%reaction*d(n + 1)
      do i = 1, n
         call end_cell(column, state, i, (d(i) - d(i + 1))/column%thickness(i), time_step)
      end do
      state%velocity = 2.0_wp/time_step*d - state%velocity
      state%displacement = state%displacement + d
   end subroutine end_step

   !> Advance a cell to the end of a step.
   subroutine end_cell(column, state, i, change, time_step)
      type(shear_column_type), intent(in) :: column  !< column
      type(shear_state_type), intent(inout) :: state  !< state of the column
      integer, intent(in) :: i            !< number of the cell
      real(wp), intent(in) :: change      !< Δγ
      real(wp), intent(in) :: time_step   !< Δt, s
      type(response_type) :: soil, body
      real(wp) :: loss, body_change

      associate (branches => column%branches(column%soil(i)), g => column%modulus(i), &
         memory => state%memory(:, i), h => column%thickness(i))
         soil = respond(branches, state%elastic(:, i), state%strain(i), change)
         call respond_body(branches, memory, state%body_strain(i), change, time_step, body, &
            body_change)
         call advance_body(branches, state%body_strain(i), body_change, time_step, memory, loss)
         call advance_branches(branches, change, state%elastic(:branches%n, i))
         state%body_strain(i) = state%body_strain(i) + body_change
         state%strain(i) = state%strain(i) + change
         state%stress(i) = g*(soil%end + body%end)
         state%largest(:, i) = max(state%largest(:, i), abs([state%strain(i), state%stress(i)]))
         state%slipped = state%slipped + g*h*(soil%loss + body%loss)
         state%damped = state%damped + g*h*loss
      end associate
   end subroutine end_cell

   !> Accelerations of the nodes at the end of a step, from the forces at that time.
   function end_accelerations(column, state, base_acceleration, outcrop) result(acceleration)
      type(shear_column_type), intent(in) :: column  !< column
      type(shear_state_type), intent(in) :: state  !< state of the column
      real(wp), intent(in) :: base_acceleration     !< acceleration of a prescribed base, m/s²
      real(wp), intent(in) :: outcrop  !< velocity of an outcrop of the half-space, m/s
      real(wp) :: acceleration(size(state%velocity))
      real(wp), dimension(size(acceleration)) :: diagonal, force
      real(wp) :: off_diagonal(size(state%strain))
      integer :: n

      n = size(off_diagonal)
      force = 0.0_wp
      force(:n) = -state%stress
      force(2:) = force(2:) + state%stress
      call assemble_mass(column, diagonal, off_diagonal)
      if (column%dashpot > 0.0_wp) then
         force(n + 1) = force(n + 1) + column%dashpot*(outcrop - state%velocity(n + 1))
      else
         force(n) = force(n) - off_diagonal(n)*base_acceleration
         force(n + 1) = base_acceleration
         diagonal(n + 1) = 1.0_wp
         off_diagonal(n) = 0.0_wp
      end if
      call solve_tridiagonal(diagonal, off_diagonal, force, acceleration)
   end function end_accelerations

   !> Work at the base, kinetic and stored energy, losses by slip and by damping, J/m².
   function energy_balance(column, state) result(energy)
      type(shear_column_type), intent(in) :: column  !< column
      type(shear_state_type), intent(in) :: state  !< state of the column
      real(wp) :: energy(5), stored
      integer :: i

      stored = 0.0_wp
      do i = 1, size(state%strain)
         associate (soil => column%soil(i))
            stored = stored + column%modulus(i)*column%thickness(i)*(stored_by_branches( &
               column%branches(soil), state%elastic(:, i), state%strain(i)) &
               + stored_by_body(column%branches(soil), state%memory(:, i), state%body_strain(i)))
         end associate
      end do
      energy = [state%work, 0.5_wp*dot_product(state%velocity, mass_times(column, &
         state%velocity)), stored, state%slipped, state%damped]
   end function energy_balance

end module dda_shear_column
