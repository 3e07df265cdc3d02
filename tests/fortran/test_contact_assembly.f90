! SPDX-License-Identifier: GPL-3.0-or-later
!> Assembly of changed entries is bit-identical to complete assembly, which yields the sums of
!> paper eq. 7.
module test_contact_assembly
   use dda_kinds, only: wp
   !$ use omp_lib, only: omp_get_max_threads, omp_set_num_threads
   use dda_system, only: system_type
   use dda_block_matrix, only: entry_of, multiply
   use dda_compact_block, only: compact_size, expand
   use dda_contact, only: contact_open, contact_slide, contact_stick, contacts_type, reserve
   use dda_contact_assembly, only: add_to_rows, assemble_contacts
   use dda_contact_gradients, only: find_rows, rows_type
   use dda_friction, only: laws_type
   use dda_neighbours, only: neighbours_type
   use dda_rank_one, only: forget_changes, rank_one_type
   use dda_step_solution, only: find_residual
   use models, only: random, random_vector, sow
   use systems, only: pattern_of
   use testing, only: case, check, check_close
   implicit none

   real(wp), parameter :: normal = 3.3_wp, shear = 1.7_wp, theta = 0.6_wp, untouched = -7.0_wp
   type(laws_type) :: laws = laws_type(normal_stiffness=normal, shear_stiffness=shear, &
      theta=theta, friction=null(), cohesion=null(), tension=null())

contains

   subroutine assembly_of_changes()
      call after_changes(40, augmented=.false.)
      call after_changes(800, augmented=.false.)
      call after_changes(40, augmented=.true.)
   end subroutine assembly_of_changes

   !> Blocks with random near pairs and up to three contacts in each, in random states.
   subroutine random_contacts(system, contacts, n)
      type(system_type), intent(out) :: system
      type(contacts_type), intent(out) :: contacts
      integer, intent(in) :: n
      type(neighbours_type) :: neighbours
      integer :: i, j, p, c

      neighbours%pair = reshape([((merge([i, j], [j, i], modulo(i + j, 2) == 0), j=max(1, i - 3), &
         i - 1), i=1, n)], [2, 3*n - 6])
      neighbours%pair = neighbours%pair(:, pack([(i, i=1, size(neighbours%pair, 2))], &
         random_vector(size(neighbours%pair, 2)) > -0.4_wp))
      neighbours%n_pairs = size(neighbours%pair, 2)
      call pattern_of(system, n, neighbours)
      system%constant = reshape(random_vector(compact_size*n), [compact_size, n])
      system%load = reshape(random_vector(6*n), [6, n])
      contacts%with_multipliers = .true.
      call reserve(contacts, 3*neighbours%n_pairs)
      do p = 1, neighbours%n_pairs
         do i = 1, int(random(0.0_wp, 4.0_wp))
            contacts%n = contacts%n + 1
            c = contacts%n
            j = int(random(1.0_wp, 3.0_wp))
            contacts%pair(c) = p
            contacts%block_v(c) = neighbours%pair(j, p)
            contacts%block_e(c) = neighbours%pair(3 - j, p)
            call set_randomly(contacts, c)
         end do
      end do
   end subroutine random_contacts

   subroutine set_randomly(contacts, c)
      type(contacts_type), intent(inout) :: contacts
      integer, intent(in) :: c

      contacts%normal(:, c) = random_vector(2)
      contacts%gradient_v(:, c) = random_vector(12)
      contacts%gradient_e(:, c) = random_vector(12)
      contacts%gap(c) = random(-1.0_wp, 1.0_wp)
      contacts%stretch(c) = random(-1.0_wp, 1.0_wp)
      contacts%slide_force(c) = random(-1.0_wp, 1.0_wp)
      contacts%retained_at(c) = random(-1.0_wp, 1.0_wp)
      contacts%retained(c) = merge(0.0_wp, random(0.0_wp, 1.0_wp), modulo(c, 3) == 0)
      contacts%multiplier(c) = random(-1.0_wp, 1.0_wp)
      contacts%state(c) = int(random(0.0_wp, 3.0_wp))
      contacts%bonded(c) = random(0.0_wp, 1.0_wp) > 0.5_wp
      if (contacts%state(c) /= contact_stick) contacts%bonded(c) = .false.
   end subroutine set_randomly

   !> Everything, on top of values that must not be seen.
   subroutine assemble_all(system, contacts)
      type(system_type), intent(inout) :: system
      type(contacts_type), intent(inout) :: contacts

      system%matrix%diagonal = untouched
      system%matrix%lower = untouched
      system%rhs = untouched
      system%contact_terms%rebuild = .true.
      call assemble_contacts(system, contacts, laws)
   end subroutine assemble_all

   subroutine check_same(system, expected)
      type(system_type), intent(in) :: system, expected

      call check(all(system%rhs == expected%rhs), 'the right-hand side')
      call check(all(system%matrix%diagonal == expected%matrix%diagonal), 'the diagonal blocks')
      call check(all(system%matrix%lower == expected%matrix%lower), 'the coupling blocks')
   end subroutine check_same

   !> The residual without the matrix is that of the assembled equations, also if slip lifts, and
   !> has the same bits for any number of threads.
   subroutine residual_without_matrix()
      integer :: threads
      !$ integer :: default_threads

      call residual_of_blocks(40, lifts=.false.)
      call residual_of_blocks(40, lifts=.true.)
      !$ default_threads = omp_get_max_threads()
      do threads = 1, 3
         !$ call omp_set_num_threads(threads)
         call residual_of_blocks(600, lifts=.false., fixed=.true.)
      end do
      !$ call omp_set_num_threads(default_threads)
   end subroutine residual_without_matrix

   subroutine residual_of_blocks(n, lifts, fixed)
      integer, intent(in) :: n
      logical, intent(in) :: lifts
      logical, intent(in), optional :: fixed  !< the same numbers in each call
      type(system_type) :: system
      type(contacts_type) :: contacts
      real(wp) :: d(6, n), r(6, n), product(6, n)
      real(wp), allocatable, save :: first_residual(:,:)

      call case('residual without the matrix, lift: '//merge('yes', 'no ', lifts))
      if (present(fixed)) call sow(17)
      call random_contacts(system, contacts, n)
      if (lifts) then
         contacts%with_laws = .true.
         contacts%tilt = spread(random_vector(contacts%n), 1, 2)
      end if
      call assemble_all(system, contacts)
      d = reshape(random_vector(6*n), [6, n])
      call multiply(system%matrix, d, product)
      call find_residual(system, contacts, d, r)
      call check_close(r, system%rhs - product, 'residual', absolute=1.0e-12_wp)
      call check(maxval(abs(r)) > 1.0_wp, 'it is not zero')
      if (.not. present(fixed)) return
      if (.not. allocated(first_residual)) first_residual = r
      call check(all(r == first_residual), 'bits for any number of threads')
   end subroutine residual_of_blocks

   !> Springs along the rows of gap and slip, written out.
   subroutine against_dense_sums()
      type(system_type) :: system
      type(contacts_type) :: contacts
      type(rows_type) :: rows
      real(wp), allocatable :: k(:,:), f(:), gap_row(:), slip_row(:)
      real(wp) :: push, spring, press, drag
      integer, parameter :: n = 12
      integer :: c, i, j

      call random_contacts(system, contacts, n)
      call assemble_all(system, contacts)
      allocate (k(6*n, 6*n), gap_row(6*n), slip_row(6*n), source=0.0_wp)
      f = reshape(system%load, [6*n])
      do i = 1, n
         call expand(system%constant(:, i), k(6*i - 5:6*i, 6*i - 5:6*i))
      end do
      do c = 1, contacts%n
         i = 6*contacts%block_v(c)
         j = 6*contacts%block_e(c)
         gap_row = 0.0_wp
         slip_row = 0.0_wp
         call find_rows(contacts, c, rows)
         gap_row(i - 5:i) = rows%normal_v
         gap_row(j - 5:j) = -rows%normal_e
         slip_row(i - 5:i) = rows%shear_v
         slip_row(j - 5:j) = -rows%shear_e
         associate (share => contacts%retained(c), at => contacts%retained_at(c))
            select case (contacts%state(c))
            case (contact_open)
               push = share*normal
               spring = 0.0_wp
               press = push*(at - contacts%gap(c))
               drag = 0.0_wp
            case (contact_slide)
               push = normal
               spring = share*shear
               press = contacts%multiplier(c) - normal*contacts%gap(c)
               drag = contacts%slide_force(c) - spring*at
            case (contact_stick)
               push = merge(theta, 1.0_wp, contacts%bonded(c))*normal
               spring = merge(theta, 1.0_wp, contacts%bonded(c))*shear
               press = contacts%multiplier(c) - normal*contacts%gap(c)
               drag = shear*contacts%stretch(c)
            end select
         end associate
         k = k + push*spread(gap_row, 2, 6*n)*spread(gap_row, 1, 6*n) &
            + spring*spread(slip_row, 2, 6*n)*spread(slip_row, 1, 6*n)
         f = f + press*gap_row - drag*slip_row
      end do
      call check_close(reshape(system%rhs, [6*n]), f, 'right-hand side', relative=1.0e-14_wp)
      do i = 1, n
         call check_close(system%matrix%diagonal(:, :, i), k(6*i - 5:6*i, 6*i - 5:6*i), &
            'diagonal', relative=1.0e-14_wp)
         do j = 1, i - 1
            c = entry_of(system%matrix, i, j)
            if (c > 0) call check_close(system%matrix%lower(:, :, c), k(6*i - 5:6*i, 6*j - 5:6*j), &
               'coupling', relative=1.0e-14_wp, absolute=1.0e-14_wp)
         end do
      end do
   end subroutine against_dense_sums

   !> Rows are dealt out to the threads; their sums are not.
   subroutine any_number_of_threads()
      type(system_type) :: system, parallel_system
      type(contacts_type) :: contacts
      integer :: default_threads, threads

      call random_contacts(system, contacts, 520)
      default_threads = 1
      !$ default_threads = omp_get_max_threads()
      !$ call omp_set_num_threads(1)
      call assemble_all(system, contacts)
      do threads = 2, 4
         parallel_system = system
         !$ call omp_set_num_threads(threads)
         call assemble_all(parallel_system, contacts)
         call check_same(parallel_system, system)
      end do
      !$ call omp_set_num_threads(default_threads)
   end subroutine any_number_of_threads

   !> More shear force in contact c, as two threads add it.
   subroutine add_shear_force(system, contacts, c, force)
      type(system_type), intent(inout) :: system
      type(contacts_type), intent(inout) :: contacts
      integer, intent(in) :: c
      real(wp), intent(in) :: force
      integer :: middle

      middle = system%matrix%n/2
      contacts%free_force(2, c) = contacts%free_force(2, c) + force
      call add_to_rows(system, contacts, c, [0.0_wp, force], 1, middle)
      call add_to_rows(system, contacts, c, [0.0_wp, force], middle + 1, system%matrix%n)
   end subroutine add_shear_force

   !> States, forces, multipliers and retained shares change, a few at a time, as in the iteration
   !> of a step; K̂ changes by the springs that are noted for the solver.
   !>
   !> Without an augmented Lagrangian the forces of contacts that do not slide do not change.
   subroutine after_changes(n, augmented)
      integer, intent(in) :: n
      logical, intent(in) :: augmented
      type(system_type) :: system, full_system
      type(contacts_type) :: contacts
      real(wp), allocatable :: noted(:,:,:)
      integer :: round, i, c

      call case('after changes')
      laws%augmented = augmented
      call random_contacts(system, contacts, n)
      call assemble_all(system, contacts)
      do round = 1, 40
         do i = 1, modulo(round, 4)
            c = 1 + int(random(0.0_wp, real(contacts%n, wp)))
            select case (modulo(round + i, 5))
            case (0, 1)
               contacts%state(c) = int(random(0.0_wp, 3.0_wp))
            case (2)
               contacts%slide_force(c) = random(-1.0_wp, 1.0_wp)
            case (3)
               if (augmented) contacts%multiplier(c) = random(-1.0_wp, 1.0_wp)
            case (4)  ! there and back: only rounding is left of it
               if (.not. augmented .and. contacts%state(c) /= contact_slide) cycle
               call add_shear_force(system, contacts, c, 1.0e3_wp/3)
               call add_shear_force(system, contacts, c, -1.0e3_wp/3)
            end select
         end do
         c = findloc(contacts%state(:contacts%n) == contact_open .and. &
            .not. contacts%bonded(:contacts%n), .true., 1)
         call check(c > 0, 'an open contact')
         contacts%retained(c) = merge(0.3_wp, 0.0_wp, modulo(round, 2) == 0)
         noted = system%matrix%diagonal
         call forget_changes(system%contact_terms%spring_changes)
         call assemble_contacts(system, contacts, laws)
         call add_noted(system%contact_terms%spring_changes, noted)
         call check(maxval(abs(system%matrix%diagonal - noted)) <= 1.0e-13_wp*maxval(abs(noted)), &
            'the noted changes')
         full_system = system
         call assemble_all(full_system, contacts)
         call check_same(system, full_system)
      end do
      laws%augmented = .false.
   end subroutine after_changes

   !> diagonal += k u uᵀ of all changes.
   subroutine add_noted(changes, diagonal)
      type(rank_one_type), intent(in) :: changes
      real(wp), intent(inout) :: diagonal(:,:,:)
      integer :: i, block_side

      do i = 1, changes%n
         do block_side = 1, 2
            associate (u => changes%u(:, block_side, i), block => changes%block(block_side, i))
               diagonal(:, :, block) = diagonal(:, :, block) &
                  + changes%k(i)*spread(u, 2, 6)*spread(u, 1, 6)
            end associate
         end do
      end do
   end subroutine add_noted

   !> A state changes: both its blocks and their coupling are assembled, and no others.  A force: no
   !> matrix.
   subroutine nothing_else()
      type(system_type) :: system
      type(contacts_type) :: contacts
      integer :: c

      call random_contacts(system, contacts, 40)
      call assemble_all(system, contacts)
      system%matrix%diagonal = untouched
      system%matrix%lower = untouched
      system%rhs = untouched
      c = contacts%n/2
      contacts%bonded(c) = .false.
      contacts%state(c) = modulo(contacts%state(c) + 1, 3)
      call assemble_contacts(system, contacts, laws)
      call check(count(any(system%rhs /= untouched, 1)) == 2, 'two blocks of the right-hand side')
      call check(count(any(any(system%matrix%diagonal /= untouched, 1), 1)) == 2, &
         'two diagonal blocks')
      call check(count(any(any(system%matrix%lower /= untouched, 1), 1)) == 1, 'one coupling block')
      system%matrix%diagonal = untouched
      system%rhs = untouched
      contacts%state(c) = contact_slide
      call assemble_contacts(system, contacts, laws)
      system%matrix%diagonal = untouched
      system%rhs = untouched
      contacts%slide_force(c) = 2*contacts%slide_force(c)
      call assemble_contacts(system, contacts, laws)
      call check(count(any(system%rhs /= untouched, 1)) == 2, 'two blocks for a force')
      call check(all(system%matrix%diagonal == untouched), 'no matrix for a force')
   end subroutine nothing_else

end module test_contact_assembly
