! SPDX-License-Identifier: GPL-3.0-or-later
!> Drift of bodies: the equations of a step are solved for displacements relative to it.
!>
!> If a body translates by d₀ in a step, the stiff springs between its cells exert no force, but
!> K̂d₀ has a relative rounding error of 10⁻¹⁶, with the same sign in each step: the error in a body
!> of E = 10¹⁴ Pa would be 10⁻⁸ of its weight.  Therefore K̂(d − d₀) = f̂ − K̂d₀ is solved.  K̂d₀ is
!> summed term by term, because the term of two welded cells is exactly zero.
module dda_body_drift
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type
   use dda_contact, only: contacts_type
   use dda_contact_gradients, only: acting_rows, relative_motion, rows_type
   use dda_linear_solver, only: solver_type, record_rigid_terms, weigh_loads
   use dda_linear_terms, only: blocks_in, get_row, instants, step_weights, stretch_of
   use dda_scheme, only: step_type
   use dda_system, only: system_type
   implicit none
   private
   public :: begin_drift, subtract_contacts

   real(wp), parameter :: least_drift = 1.0e-6_wp  !< smallest drift/half the model size
   !> factor of the remaining loads that scale residuals, because forces of moving supports and
   !> contacts far exceed the forces within bodies
   real(wp), parameter :: load_factor = 1.0e-3_wp

contains

   !> Find the translation d₀ of each body and the part of K̂d₀ without contacts.
   !> Scale the residuals of the solver by the remaining loads.
   subroutine begin_drift(system, solver, blocks, step)
      type(system_type), intent(inout) :: system  !< equations of the step, without contacts
      type(solver_type), intent(inout) :: solver  !< linear solver
      type(blocks_type), intent(in) :: blocks     !< blocks in their present state
      type(step_type), intent(in) :: step         !< the present step
      real(wp) :: weights(instants), row(6), force
      integer :: i, k, b

      system%drifts = .false.
      call weigh_loads(solver, system%load)
      solver%least_error = epsilon(1.0_wp)*maxval(abs(blocks%position(:2, :)))
      if (.not. any(blocks%body > 0)) return
      if (.not. allocated(system%drift)) allocate (system%drift(6, blocks%n), &
         system%drift_load(6, blocks%n), system%reduced(6, blocks%n))
      call translate_bodies(blocks, step%time_step, system%drift)
      system%drifts = any(abs(system%drift) > least_drift*blocks%half_size)
      if (.not. system%drifts) return
      do b = 1, blocks%n
         system%drift_load(:2, b) = system%constant(1, b)*system%drift(:2, b)
         system%drift_load(3:, b) = 0.0_wp
      end do
      weights = step_weights(step)
      do i = 1, system%terms%n
         associate (term => system%terms%term(i))
            force = weights(term%instant)*term%coefficient*stretch_of(term, system%drift)
            if (.not. abs(force) > 0.0_wp) cycle
            do k = 1, blocks_in(term)
               call get_row(term, k, b, row)
               system%drift_load(:, b) = system%drift_load(:, b) + force*row
            end do
         end associate
      end do
      system%reduced = load_factor*(system%load - system%drift_load)
      call weigh_loads(solver, system%reduced)
      call record_rigid_terms(solver)
   end subroutine begin_drift

   !> Set the drift of each cell to Δt × mean velocity of its body, and of other blocks to 0.
   pure subroutine translate_bodies(blocks, time_step, drift)
      type(blocks_type), intent(in) :: blocks    !< blocks in their present state
      real(wp), intent(in) :: time_step          !< s
      real(wp), intent(out) :: drift(:,:)        !< [6,blocks] drift, m
      real(wp) :: total(3, maxval(blocks%body))  ! momentum and mass of each body
      integer :: b

      total = 0.0_wp
      drift = 0.0_wp
      do b = 1, blocks%n
         if (blocks%body(b) == 0 .or. blocks%removed(b)) cycle
         associate (sum => total(:, blocks%body(b)))
            sum = sum + blocks%mass(b)*[blocks%velocity(1:2, b), 1.0_wp]
         end associate
      end do
      do b = 1, blocks%n
         if (blocks%body(b) == 0 .or. blocks%removed(b)) cycle
         associate (sum => total(:, blocks%body(b)))
            drift(1:2, b) = time_step*sum(1:2)/sum(3)
         end associate
      end do
   end subroutine translate_bodies

   !> Subtract from b the spring forces of all contacts due to d₀.
   pure subroutine subtract_contacts(b, drift, contacts)
      real(wp), intent(inout) :: b(:,:)            !< [6,n] right-hand side, N
      real(wp), intent(in) :: drift(:,:)           !< [6,n] d₀, m
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      type(rows_type) :: rows
      real(wp) :: force(2), motion(2)
      integer :: c

      do c = 1, contacts%n
         if (.not. any(abs(contacts%spring(:, c)) > 0.0_wp)) cycle
         associate (v => contacts%block_v(c), e => contacts%block_e(c))
            motion = relative_motion(contacts, c, drift(:, v), drift(:, e))
            if (contacts%with_laws) motion(1) = motion(1) - contacts%tilt(2, c)*motion(2)
            force = contacts%spring(:, c)*motion
            call acting_rows(contacts, c, rows)
            b(:, v) = b(:, v) - force(1)*rows%normal_v - force(2)*rows%shear_v
            b(:, e) = b(:, e) + force(1)*rows%normal_e + force(2)*rows%shear_e
         end associate
      end do
   end subroutine subtract_contacts

end module dda_body_drift
