! SPDX-License-Identifier: GPL-3.0-or-later
!> Block matrices, and random small systems of two blocks and a few contacts.
!>
!> Energy and gradient of a system are computed here from its definition, independently of the
!> program.  In every other system an element couples the two blocks.
module systems
   use dda_kinds, only: wp
   use dda_block_matrix, only: block_matrix_type, entry_of
   use dda_blocks, only: blocks_type
   use dda_compact_block, only: compact, compact_size
   use dda_system, only: prepare_system, set_matrix_pattern, system_type
   use dda_contact, only: contact_open, contacts_type, reserve
   use dda_contact_gradients, only: find_rows, rows_type
   use dda_element, only: element_type
   use dda_elements, only: elements_type, register
   use dda_energy, only: energy_type
   use dda_linear_terms, only: add_term, add_to_matrix, linear_term_type, linear_terms_type, &
      step_weights
   use dda_friction, only: laws_type, set_laws
   use dda_material, only: joint_type
   use dda_neighbours, only: neighbours_type
   use dda_scheme, only: step_type
   use models, only: random, random_vector
   implicit none
   private
   public :: add_spring, dense_of, diagonal_of, energy, flat, gap_row, gradient, linear_matrix, &
      normal_force, pattern_of, random_system, shear_stiffness, slip_row, stiffness, unbalanced, &
      unknowns

   real(wp), parameter :: stiffness = 1.0e3_wp
   real(wp), parameter :: shear_stiffness = stiffness/2.5_wp
   integer, parameter :: unknowns = 12

   !> Elements that act by given terms.
   type, extends(element_type) :: couplings_type
      type(linear_terms_type) :: terms
   contains
      procedure :: add_linear_terms
      procedure :: add_force
      procedure :: add_to_budget
   end type couplings_type

contains

   !> The diagonal blocks of a matrix as compact blocks.
   pure function diagonal_of(matrix) result(numbers)
      type(block_matrix_type), intent(in) :: matrix
      real(wp) :: numbers(compact_size, matrix%n)
      integer :: i

      do i = 1, matrix%n
         numbers(:, i) = compact(matrix%diagonal(:, :, i))
      end do
   end function diagonal_of

   !> Prepare a system of n blocks with the pattern of its near pairs and of given couplings.
   subroutine pattern_of(system, n, neighbours, couplings)
      type(system_type), intent(out) :: system
      integer, intent(in) :: n  !< blocks
      type(neighbours_type), intent(in) :: neighbours
      type(linear_terms_type), intent(in), optional :: couplings
      type(blocks_type) :: blocks
      type(elements_type) :: elements

      call prepare_system(system, n)
      blocks%n = n
      allocate (elements%kind(0))
      if (present(couplings)) call register(elements, couplings_type(terms=couplings))
      call set_matrix_pattern(system, blocks, neighbours, elements, step_type(time_step=1.0_wp))
   end subroutine pattern_of

   subroutine add_linear_terms(self, blocks, step, terms)
      class(couplings_type), intent(in) :: self
      type(blocks_type), intent(in) :: blocks
      type(step_type), intent(in) :: step
      type(linear_terms_type), intent(inout) :: terms
      integer :: i

      do i = 1, self%terms%n
         call add_term(terms, self%terms%term(i))
      end do
   end subroutine add_linear_terms

   !> Couplings are free of force at d = 0.
   subroutine add_force(self, blocks, step, load)
      class(couplings_type), intent(in) :: self
      type(blocks_type), intent(in) :: blocks
      type(step_type), intent(in) :: step
      real(wp), intent(inout) :: load(:,:)
   end subroutine add_force

   subroutine add_to_budget(self, blocks, step, d, energy)
      class(couplings_type), intent(in) :: self
      type(blocks_type), intent(in) :: blocks
      type(step_type), intent(in) :: step
      real(wp), intent(in) :: d(:,:)
      type(energy_type), intent(inout) :: energy
   end subroutine add_to_budget

   !> The linear part of K̂ of two blocks as a full matrix.
   pure function linear_matrix(system) result(k)
      type(system_type), intent(in) :: system
      real(wp) :: k(unknowns, unknowns)

      k = dense_of(system%linear)
   end function linear_matrix

   !> The full matrix of a block matrix.
   pure function dense_of(matrix) result(dense)
      type(block_matrix_type), intent(in) :: matrix
      real(wp) :: dense(6*matrix%n, 6*matrix%n)
      integer :: i, j, e

      dense = 0.0_wp
      do i = 1, matrix%n
         dense(6*i - 5:6*i, 6*i - 5:6*i) = matrix%diagonal(:, :, i)
         do e = matrix%row_start(i), matrix%row_start(i + 1) - 1
            j = matrix%column(e)
            dense(6*i - 5:6*i, 6*j - 5:6*j) = matrix%lower(:, :, e)
            dense(6*j - 5:6*j, 6*i - 5:6*i) = transpose(matrix%lower(:, :, e))
         end do
      end do
   end function dense_of

   !> Add a spring of stiffness k between blocks i and j: matrix += k u uᵀ with u = (a, −b).
   subroutine add_spring(matrix, i, j, a, b, k)
      type(block_matrix_type), intent(inout) :: matrix
      integer, intent(in) :: i, j
      real(wp), intent(in) :: a(6), b(6), k

      matrix%diagonal(:, :, i) = matrix%diagonal(:, :, i) + k*outer(a, a)
      matrix%diagonal(:, :, j) = matrix%diagonal(:, :, j) + k*outer(b, b)
      associate (e => entry_of(matrix, max(i, j), min(i, j)))
         if (i > j) then
            matrix%lower(:, :, e) = matrix%lower(:, :, e) - k*outer(a, b)
         else
            matrix%lower(:, :, e) = matrix%lower(:, :, e) - k*outer(b, a)
         end if
      end associate
   end subroutine add_spring

   pure function outer(a, b) result(product)
      real(wp), intent(in) :: a(6), b(6)
      real(wp) :: product(6, 6)

      product = spread(a, 2, 6)*spread(b, 1, 6)
   end function outer

   !> Make a random system of two blocks with some contacts.
   subroutine random_system(system, contacts, laws, count, friction_angle)
      type(system_type), intent(out) :: system
      type(contacts_type), intent(out) :: contacts
      type(laws_type), intent(out) :: laws
      integer, intent(in) :: count
      real(wp), intent(in) :: friction_angle
      type(neighbours_type) :: neighbours
      type(linear_terms_type) :: couplings
      real(wp) :: a(6, 6)
      integer :: b, c, k
      logical :: fits

      neighbours%n_pairs = 1
      neighbours%pair = reshape([1, 2], [2, 1])
      if (random(0.0_wp, 1.0_wp) > 0.5_wp) then
         do k = 1, 3
            call add_term(couplings, linear_term_type(block_a=1, block_b=2, &
               coefficient=random(0.0_wp, 300.0_wp), row_a=random_vector(6), &
               row_b=random_vector(6)))
         end do
      end if
      call pattern_of(system, 2, neighbours, couplings)
      do b = 1, 2
         a = reshape(random_vector(36), [6, 6])
         system%has_terms(b) = .true.
         system%linear%diagonal(:, :, b) = 100.0_wp*matmul(a, transpose(a))
         do k = 1, 6
            system%linear%diagonal(k, k, b) = system%linear%diagonal(k, k, b) + 30.0_wp
         end do
         system%load(:, b) = 10.0_wp*random_vector(6)
      end do
      call add_to_matrix(couplings, step_weights(step_type(time_step=1.0_wp)), system%linear, fits)
      call set_laws(laws, [joint_type('', friction_angle, 0.0_wp, 0.0_wp)], stiffness, 2.5_wp)
      contacts%with_strengths = .true.
      call reserve(contacts, count)
      contacts%n = count
      do c = 1, count
         contacts%block_v(c) = 1 + modulo(c, 2)
         contacts%block_e(c) = 2 - modulo(c, 2)
         contacts%pair(c) = 1
         contacts%joint(c) = 1
         contacts%vertex(c) = c
         contacts%edge(c) = c
         contacts%normal(:, c) = random_vector(2)
         contacts%gradient_v(:, c) = random_vector(12)
         contacts%gradient_e(:, c) = random_vector(12)
         contacts%gap(c) = random(-0.05_wp, 0.05_wp)
         contacts%stretch(c) = random(-0.01_wp, 0.01_wp)
         contacts%state(c) = contact_open
      end do
   end subroutine random_system

   pure function flat(d) result(vector)
      real(wp), intent(in) :: d(6, 2)
      real(wp) :: vector(unknowns)

      vector = reshape(d, [unknowns])
   end function flat

   !> ∂gap/∂d of contact c.
   pure function gap_row(contacts, c) result(row)
      type(contacts_type), intent(in) :: contacts
      integer, intent(in) :: c
      real(wp) :: row(unknowns)
      type(rows_type) :: rows

      call find_rows(contacts, c, rows)
      row = placed(rows%normal_v, rows%normal_e, contacts%block_v(c))
   end function gap_row

   !> ∂slip/∂d of contact c.
   pure function slip_row(contacts, c) result(row)
      type(contacts_type), intent(in) :: contacts
      integer, intent(in) :: c
      real(wp) :: row(unknowns)
      type(rows_type) :: rows

      call find_rows(contacts, c, rows)
      row = placed(rows%shear_v, rows%shear_e, contacts%block_v(c))
   end function slip_row

   pure function placed(of_vertex, of_edge, block_v) result(row)
      real(wp), intent(in) :: of_vertex(6), of_edge(6)
      integer, intent(in) :: block_v
      real(wp) :: row(unknowns)

      row = [of_vertex, -of_edge]
      if (block_v == 2) row = [-of_edge, of_vertex]
   end function placed

   !> Normal force of contact c at the displacements of the system, N/m.
   pure real(wp) function normal_force(system, contacts, c)
      type(system_type), intent(in) :: system
      type(contacts_type), intent(in) :: contacts
      integer, intent(in) :: c

      normal_force = max(0.0_wp, -stiffness*(contacts%gap(c) + dot_product(gap_row(contacts, c), &
         flat(system%d))))
   end function normal_force

   !> Forces on the blocks at d by the law of friction, in the geometry before the step, N/m.
   pure function unbalanced(system, contacts, mu) result(residual)
      type(system_type), intent(in) :: system
      type(contacts_type), intent(in) :: contacts
      real(wp), intent(in) :: mu  !< tan φ
      real(wp) :: residual(unknowns), normal, shear
      integer :: c

      residual = flat(system%load) - matmul(linear_matrix(system), flat(system%d))
      do c = 1, contacts%n
         normal = normal_force(system, contacts, c)
         shear = shear_stiffness*(contacts%stretch(c) + dot_product(slip_row(contacts, c), &
            flat(system%d)))
         shear = max(-mu*normal, min(mu*normal, shear))
         residual = residual + normal*gap_row(contacts, c) - shear*slip_row(contacts, c)
      end do
   end function unbalanced

   !> ½ dᵀBd − fᵀd + Σ ½ k min(gap, 0)²; with sliders ½ k_s s² up to their bounds, linear beyond.
   pure real(wp) function energy(system, contacts, d, bounds)
      type(system_type), intent(in) :: system
      type(contacts_type), intent(in) :: contacts
      real(wp), intent(in) :: d(6, 2)
      real(wp), intent(in), optional :: bounds(:)  !< frozen, N/m; else without friction
      integer :: c

      energy = dot_product(flat(d), 0.5_wp*matmul(linear_matrix(system), flat(d)) &
         - flat(system%load))
      do c = 1, contacts%n
         energy = energy + 0.5_wp*stiffness*min(0.0_wp, contacts%gap(c) &
            + dot_product(gap_row(contacts, c), flat(d)))**2
         if (present(bounds)) energy = energy + slider(bounds(c), contacts%stretch(c) &
            + dot_product(slip_row(contacts, c), flat(d)))
      end do

   contains

      pure real(wp) function slider(bound, stretch)
         real(wp), intent(in) :: bound, stretch

         slider = 0.5_wp*shear_stiffness*stretch**2
         if (shear_stiffness*abs(stretch) > bound) &
            slider = bound*(abs(stretch) - 0.5_wp*bound/shear_stiffness)
      end function slider

   end function energy

   !> The gradient of `energy`.
   pure function gradient(system, contacts, d, bounds) result(slope)
      type(system_type), intent(in) :: system
      type(contacts_type), intent(in) :: contacts
      real(wp), intent(in) :: d(6, 2)
      real(wp), intent(in), optional :: bounds(:)  !< frozen, N/m; else without friction
      real(wp) :: slope(unknowns), trial
      integer :: c

      slope = matmul(linear_matrix(system), flat(d)) - flat(system%load)
      do c = 1, contacts%n
         slope = slope + stiffness*min(0.0_wp, contacts%gap(c) + dot_product(gap_row(contacts, c), &
            flat(d))) *gap_row(contacts, c)
         if (.not. present(bounds)) cycle
         trial = shear_stiffness*(contacts%stretch(c) + dot_product(slip_row(contacts, c), flat(d)))
         slope = slope + sign(min(bounds(c), abs(trial)), trial)*slip_row(contacts, c)
      end do
   end function gradient

end module systems
