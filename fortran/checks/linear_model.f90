! SPDX-License-Identifier: GPL-3.0-or-later
!> Linearised model of a simulation: mass, and stiffness of strains, closed contacts and fixed
!> points.
!>
!> States of contacts: 'closed': all touching contacts stick; 'present': as in the run; 'settled':
!> as in static equilibrium (`dda_equilibrium`); 'auto': 'settled' with gravity, else 'closed'.
!> Contacts at the limit of friction in equilibrium stick in small vibrations, because each reversal
!> of the motion ends their slip; only contacts without friction slide.
!>
!> Damped materials are elastic in this model, with the given modulus.  `set_moduli_at` replaces it
!> by the real part of the complex modulus at a frequency, `unrelaxed` by the largest modulus.
module dda_linear_model
   use dda_kinds, only: wp, long, pi
   use dda_interrupts, only: fail_if_stopped
   use dda_block_matrix, only: block_matrix_type, set_pattern
   use dda_blocks, only: blocks_type, mass_matrix, shape_matrix
   use dda_damping, only: damping_type, is_damped, same_damping, modulus_factor
   use dda_columns, only: column_count, column_of
   use dda_contact_geometry, only: on_edge
   use dda_contact_gradients, only: find_rows, rows_type
   use dda_contact, only: contacts_type, is_point, contact_open, contact_slide, contact_stick
   use dda_elements, only: list_linear_terms
   use dda_friction, only: find_bound, laws_type, shear_stiffness_of
   use dda_joint_contact, only: state_of
   use dda_joint_law, only: weakened
   use dda_doubts, only: doubt_type
   use dda_joint_ends, only: bending_doubts
   use dda_equilibrium, only: equilibrium_type, equilibrate
   use dda_errors, only: error_type, error_input, fail
   use dda_linear_terms, only: linear_terms_type, linear_term_type, add_term, stretch_of, &
      add_product, add_to_matrix, coupled_blocks, scale_penalty, at_theta, at_end, end_dashpot, &
      of_mass, instants, term_normal, term_shear, term_kinds, term_names, term_labels
   use dda_scheme, only: scheme_type
   use dda_simulation, only: simulation_type, next_step
   use dda_support, only: point_type
   use dda_text, only: quoted, to_text
   implicit none
   private
   public :: linear_model_type, normal_slope, energy_distribution_type, linearise, set_penalty, &
      block_label, term_label, energy_of, stiffness_weights, set_moduli_at, unrelaxed, &
      is_dispersive, law_fractions, scheme_of_mode
   public :: strain_energy, energy_kinds, kind_names

   integer, parameter :: strain_energy = term_kinds + 1  !< kind of energy of strains
   integer, parameter :: energy_kinds = term_kinds + 1   !< number of kinds of energy
   character(len=*), parameter :: kind_names(energy_kinds) = [character(len=22) :: term_names, &
      'strain of blocks']
   !> gap/size of the smaller block of a touching contact
   real(wp), parameter :: touching = 1.0e-6_wp
   real(wp), parameter :: equal_energies = 1.0e-3_wp  !< relative difference of equal energies
   !> weight in K of terms by their instant in a step: 1 for springs, 0 for dashpots and masses
   real(wp), parameter :: stiffness_weights(instants) = [1.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, &
      0.0_wp, 0.0_wp]

   !> Matrices K and M of small motions, and the data from which they are assembled.
   type :: linear_model_type
      integer :: n = 0                              !< number of blocks
      type(block_matrix_type) :: stiffness          !< K, N/m per metre of thickness
      real(wp), allocatable :: mass(:,:,:)          !< [6,6,n] M
      real(wp), allocatable :: elastic(:,:,:)       !< [3,3,n] elastic matrix of the strains
      type(linear_terms_type) :: terms              !< terms of elements, then of closed contacts
      integer :: element_terms = 0                  !< number of terms of elements
      real(wp) :: normal_stiffness = 0.0_wp         !< k_n, N/m per metre of thickness
      type(damping_type), allocatable :: damping(:) !< distinct damping laws of the materials
      integer, allocatable :: law(:)                !< [n] damping law of each block; 0: none
      !> [3,3,n] `elastic` with the modulus of the input
      real(wp), allocatable :: input_elastic(:,:,:)
      real(wp), allocatable :: input_coefficients(:)  !< [terms] coefficients with this modulus
      type(scheme_type) :: scheme                   !< time integration of the run
      real(wp) :: time_step = 0.0_wp                !< Δt of the run, s
      real(wp) :: dynamic_factor = 1.0_wp           !< dynamic factor of the run
      integer :: n_closed = 0                         !< number of closed contacts
      integer :: n_sliding = 0                        !< number of sliding contacts
      integer :: n_by_penalty = 0  !< number of closed contacts with stiffness k_n
      integer :: n_unilateral = 0                     !< number of closed contacts without a bond
      real(wp) :: penetration = 0.0_wp              !< deepest penetration of closed contacts, m
      type(doubt_type), allocatable :: bending(:)   !< warnings on bending of bonded joints
      real(wp), allocatable :: block_mass(:)        !< [n] kg per metre of thickness
      real(wp), allocatable :: position(:,:)  !< [2,n] centroids, m, in the user's coordinates
      real(wp) :: origin(2) = 0.0_wp                !< origin of the user's coordinates, m
      character(len=64), allocatable :: name(:)     !< [n] name of the blocks
      integer :: base_motion(2) = 0                 !< motions of the base as body force
      type(point_type), allocatable :: points(:)    !< measured points
      real(wp), allocatable :: point_rows(:,:,:)    !< [2,6,points] shape matrices of the points
      type(equilibrium_type) :: equilibrium         !< result of the search for 'settled'
   end type linear_model_type

   !> Distribution of the elastic energy of a motion x over kinds of terms.
   type :: energy_distribution_type
      real(wp) :: total = 0.0_wp                  !< xᵀKx, summed without cancellation
      !> fractions of the energy, sum 1 (0 without energy)
      real(wp) :: fraction(energy_kinds) = 0.0_wp
      real(wp) :: of_penalty = 0.0_wp             !< fraction in springs proportional to k_n
      real(wp) :: at_end = 0.0_wp                 !< fraction in springs at the end of the step
      !> number of the term (for strains, block) with the largest energy of each kind
      integer :: largest_term(energy_kinds) = 0
      !> fraction of the total energy in this term
      real(wp) :: largest_fraction(energy_kinds) = 0.0_wp
   end type energy_distribution_type

contains

   !> Linearise a started simulation; the simulation does not change.
   subroutine linearise(linear, simulation, contact_choice, error, budget)
      type(linear_model_type), intent(out) :: linear  !< linearised model
      type(simulation_type), intent(in) :: simulation  !< a run and its state
      character(len=*), intent(in) :: contact_choice  !< 'closed', 'present', 'settled' or 'auto'
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      integer(long), intent(in), optional :: budget  !< most iterations to find equilibrium
      type(simulation_type) :: settled
      type(error_type), allocatable :: rest_error  ! equilibrium was not found
      integer :: i

      select case (contact_choice)
      case ('closed', 'present')
         call build_matrices(linear, simulation, contact_choice == 'closed')
      case ('settled', 'auto')
         if (norm2(simulation%model%control%gravity) == 0.0_wp .and. contact_choice == 'auto') then
            call build_matrices(linear, simulation, .true.)
            return
         end if
         settled = simulation
         do i = 1, column_count(settled)
            if (.not. allocated(rest_error)) call equilibrate(column_of(settled, i), &
               linear%equilibrium, rest_error, budget)
         end do
         if (.not. allocated(rest_error)) call equilibrate(settled, linear%equilibrium, &
            rest_error, budget)
         call fail_if_stopped(error)
         if (allocated(error)) return
         call build_matrices(linear, settled, .false.)
         call restore_run(linear, simulation)
         call assemble(linear)
      case default
         call fail(error, error_input, 'contacts '//quoted(contact_choice)// &
            " are not known; use 'closed', 'present', 'settled' or 'auto'")
      end select
   end subroutine linearise

   !> Build mass, stiffness and terms of a simulation in its present state.
   subroutine build_matrices(linear, simulation, all_closed)
      type(linear_model_type), intent(inout) :: linear  !< linearised model
      type(simulation_type), intent(in) :: simulation  !< a run and its state
      logical, intent(in) :: all_closed  !< all touching contacts stick
      integer :: p, b

      associate (model => simulation%model, blocks => simulation%blocks)
         linear%n = blocks%n
         linear%elastic = blocks%stiffness
         do b = 1, blocks%n
            linear%elastic(:, :, b) = blocks%interior_fraction(b)*blocks%stiffness(:, :, b)
         end do
         call collect_damping(linear, blocks)
         linear%block_mass = blocks%mass
         linear%origin = model%origin
         linear%position = blocks%position(1:2, :) + spread(model%origin, 2, blocks%n)
         linear%name = model%block_names
         linear%normal_stiffness = simulation%laws%normal_stiffness
         linear%points = model%points
         allocate (linear%point_rows(2, 6, size(model%points)))
         do p = 1, size(model%points)
            linear%point_rows(:, :, p) = shape_matrix(blocks, model%points(p)%block, &
               model%points(p)%reference)
         end do
      end associate
      associate (contacts => simulation%contacts(simulation%now))
         linear%bending = bending_doubts(simulation)
         linear%penetration = max(0.0_wp, -minval([0.0_wp, contacts%gap(:contacts%n)]))
         call restore_run(linear, simulation)
         call add_contacts(linear, simulation, contacts, all_closed)
      end associate
      call assemble(linear)
   end subroutine build_matrices

   !> List the distinct damping laws of the materials of blocks.
   pure subroutine collect_damping(linear, blocks)
      type(linear_model_type), intent(inout) :: linear  !< linearised model
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      integer :: law(size(blocks%damping)), m

      allocate (linear%damping(0))
      allocate (linear%law(blocks%n), source=0)
      do m = 1, size(law)
         law(m) = 0
         if (.not. is_damped(blocks%damping(m))) cycle
         law(m) = findloc(same_damping(linear%damping, blocks%damping(m)), .true., 1)
         if (law(m) > 0) cycle
         linear%damping = [linear%damping, blocks%damping(m)]
         law(m) = size(linear%damping)
      end do
      if (size(law) > 0) linear%law = law(blocks%material)
      linear%input_elastic = linear%elastic
   end subroutine collect_damping

   !> .true. if moduli depend on frequency.
   pure logical function is_dispersive(linear)  ! total
      type(linear_model_type), intent(in) :: linear  !< linearised model

      is_dispersive = any(linear%damping%n > 0)
   end function is_dispersive

   !> Set the moduli at a frequency: the real part of the complex moduli.
   subroutine set_moduli_at(linear, frequency)
      type(linear_model_type), intent(inout) :: linear  !< linearised model
      real(wp), intent(in) :: frequency  !< Hz

      call scale_moduli(linear, real(modulus_factor(linear%damping, 2.0_wp*pi*frequency)))
   end subroutine set_moduli_at

   !> Copy the model with the largest moduli, for an instantaneous change of strain.
   subroutine unrelaxed(linear, stiff)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      type(linear_model_type), intent(out) :: stiff  !< model with other moduli

      stiff = linear
      call scale_moduli(stiff, linear%damping%unrelaxed)
   end subroutine unrelaxed

   !> Multiply the given moduli of the blocks of each damping law by a factor.
   subroutine scale_moduli(linear, factor)
      type(linear_model_type), intent(inout) :: linear  !< linearised model
      real(wp), intent(in) :: factor(:)  !< [damping]
      real(wp) :: fraction(size(factor))
      integer :: b, i

      if (.not. is_dispersive(linear)) return
      do b = 1, linear%n
         if (linear%law(b) > 0) linear%elastic(:, :, b) = factor(linear%law(b)) &
            *linear%input_elastic(:, :, b)
      end do
      associate (term => linear%terms%term(:linear%terms%n))
         if (.not. allocated(linear%input_coefficients)) &
            linear%input_coefficients = term%coefficient
         do i = 1, linear%terms%n
            if (.not. any(term(i)%damped_fraction > 0.0_wp)) cycle
            fraction = law_fractions(linear, term(i))
            term(i)%coefficient = linear%input_coefficients(i)*(1.0_wp + sum(fraction*(factor &
               - 1.0_wp)))
         end do
      end associate
      call assemble(linear)
   end subroutine scale_moduli

   !> Return, for each damping law, the fraction of the stiffness of a welded face that it damps.
   pure function law_fractions(linear, term) result(fraction)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      type(linear_term_type), intent(in) :: term     !< term of the model
      real(wp) :: fraction(size(linear%damping))
      integer :: k

      fraction = 0.0_wp
      do k = 1, 2
         if (.not. term%damped_fraction(k) > 0.0_wp) cycle
         associate (law => linear%law(merge(term%block_a, term%block_b, k == 1)))
            if (law > 0) fraction(law) = fraction(law) + term%damped_fraction(k)
         end associate
      end do
   end function law_fractions

   !> Restore integration, motions and elements of the run, which static equilibrium omits.
   subroutine restore_run(linear, simulation)
      type(linear_model_type), intent(inout) :: linear  !< linearised model
      type(simulation_type), intent(in) :: simulation  !< a run and its state
      type(linear_terms_type) :: terms
      integer :: first_contact, i

      first_contact = linear%element_terms + 1
      linear%scheme = simulation%scheme
      linear%time_step = simulation%model%control%time_step
      linear%dynamic_factor = simulation%model%control%dynamic_factor
      linear%base_motion = simulation%model%control%base_motion
      call list_linear_terms(simulation%elements, simulation%blocks, next_step(simulation), terms)
      call assemble_masses(linear, simulation%blocks, terms)
      linear%element_terms = terms%n
      do i = first_contact, linear%terms%n
         call add_term(terms, linear%terms%term(i))
      end do
      linear%terms = terms
   end subroutine restore_run

   !> Assemble M from the blocks and from terms of mass, which are removed from the list.
   subroutine assemble_masses(linear, blocks, terms)
      type(linear_model_type), intent(inout) :: linear  !< linearised model
      type(blocks_type), intent(in) :: blocks           !< blocks in their present state
      type(linear_terms_type), intent(inout) :: terms   !< terms of the elements
      type(linear_terms_type) :: massless_terms
      integer :: b, i

      if (.not. allocated(linear%mass)) allocate (linear%mass(6, 6, blocks%n))
      do b = 1, blocks%n
         linear%mass(:, :, b) = mass_matrix(blocks%inertia(:, b))
      end do
      if (terms%n == 0) return
      if (.not. any(terms%term(:terms%n)%instant == of_mass)) return
      do i = 1, terms%n
         associate (term => terms%term(i))
            if (term%instant == of_mass) then
               call add_product(linear%mass(:, :, term%block_a), term%coefficient, term%row_a, &
                  term%row_a)
            else
               call add_term(massless_terms, term)
            end if
         end associate
      end do
      terms = massless_terms
   end subroutine assemble_masses

   !> Add the springs of closed contacts.
   subroutine add_contacts(linear, simulation, contacts, all_closed)
      type(linear_model_type), intent(inout) :: linear  !< linearised model
      type(simulation_type), intent(in) :: simulation  !< a run and its state
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      logical, intent(in) :: all_closed  !< all touching contacts stick
      type(linear_term_type) :: term
      type(rows_type) :: rows
      real(wp) :: tolerance
      integer :: c, state

      term%of_penalty = .true.
      do c = 1, contacts%n
         associate (v => contacts%block_v(c), e => contacts%block_e(c))
            state = contacts%state(c)
            if (all_closed) then
               tolerance = touching*min(simulation%blocks%radius(v), simulation%blocks%radius(e))
               state = merge(contact_stick, contact_open, contacts%gap(c) <= tolerance .or. &
                  contacts%bonded(c))
            end if
            if (contacts%bonded(c)) state = contact_stick
            if (state == contact_open) cycle
            if (linear%equilibrium%at_rest .and. .not. contacts%bonded(c)) &
               state = state_in_vibrations(simulation%laws, contacts, c)
            term%source = c
            term%block_a = v
            term%block_b = e
            term%position = simulation%blocks%vertex(:, contacts%vertex(c))
            term%instant = merge(at_theta, at_end, contacts%bonded(c))
            term%damped = .not. contacts%bonded(c) .and. &
               simulation%laws%restitution(contacts%joint(c)) >= 0.0_wp
            if (is_point(contacts, c)) term%position = on_edge(simulation%blocks%vertex, &
               contacts%vertex(c), simulation%blocks%next(contacts%vertex(c)), contacts%fraction(c))
            if (contacts%with_laws) call set_law_properties(simulation%laws, contacts, c, term)
            call find_rows(contacts, c, rows)
            call add_spring(linear, term, term_normal, normal_slope(simulation%laws, contacts, &
               c), rows%normal_v, rows%normal_e)
            if (state /= contact_slide) call add_spring(linear, term, term_shear, &
               shear_stiffness_of(contacts, simulation%laws, c), rows%shear_v, rows%shear_e)
            linear%n_closed = linear%n_closed + 1
            if (term%of_penalty) linear%n_by_penalty = linear%n_by_penalty + 1
            if (state == contact_slide) linear%n_sliding = linear%n_sliding + 1
            if (.not. contacts%bonded(c)) linear%n_unilateral = linear%n_unilateral + 1
         end associate
      end do
   end subroutine add_contacts

   !> State of closed contact c in small vibrations about equilibrium: it sticks if it has friction.
   pure integer function state_in_vibrations(laws, contacts, c) result(state)
      type(laws_type), intent(in) :: laws             !< stiffness and strength of the contacts
      type(contacts_type), intent(in) :: contacts     !< contacts in equilibrium, with forces
      integer, intent(in) :: c                        !< number of the contact
      real(wp) :: bound, unused(2)

      call find_bound(contacts, laws, c, bound, unused(1), unused(2))
      state = merge(contact_stick, contact_slide, bound > 0.0_wp)
   end function state_in_vibrations

   !> Set the instant at which the joint law of a contact acts.
   !> Also set whether the stiffness of the contact is a penalty.
   pure subroutine set_law_properties(laws, contacts, c, term)
      type(laws_type), intent(in) :: laws             !< stiffness and strength of the contacts
      type(contacts_type), intent(in) :: contacts     !< contacts of this step
      integer, intent(in) :: c                        !< number of the contact
      type(linear_term_type), intent(inout) :: term   !< spring of the contact

      associate (law => laws%slot(contacts%joint(c))%law)
         term%of_penalty = .not. law%normal_per_area
         if (law%cohesive) return  ! cohesive bonds act as other bonds
         if (.not. law%brittle .or. law%crushes .or. contacts%memory(weakened, c) >= 1.0_wp) &
            term%instant = at_end
      end associate
   end subroutine set_law_properties

   !> Slope of the normal force of contact c at its present closure, N/m per metre of thickness.
   pure real(wp) function normal_slope(laws, contacts, c) result(slope)
      type(laws_type), intent(in) :: laws             !< stiffness and strength of the contacts
      type(contacts_type), intent(in) :: contacts     !< contacts of this step
      integer, intent(in) :: c                        !< number of the contact

      slope = laws%normal_stiffness
      if (laws%plain) return
      associate (law => laws%slot(contacts%joint(c))%law)
         associate (state => state_of(contacts, law, c))
            slope = law%tangent(state, max(0.0_wp, law%lift(state) - contacts%gap(c)))
         end associate
      end associate
   end function normal_slope

   !> Append the normal or shear spring of a contact, with a dashpot if the contact is damped.
   subroutine add_spring(linear, term, kind, stiffness, row_v, row_e)
      type(linear_model_type), intent(inout) :: linear  !< linearised model
      type(linear_term_type), intent(inout) :: term  !< term of the list
      integer, intent(in) :: kind           !< term_normal or term_shear
      real(wp), intent(in) :: stiffness     !< N/m per metre of thickness
      real(wp), intent(in) :: row_v(6), row_e(6)  !< rows of the blocks of vertex and edge
      type(linear_term_type) :: dashpot

      term%kind = kind
      term%coefficient = stiffness
      term%row_a = row_v
      term%row_b = row_e
      call add_term(linear%terms, term)
      if (.not. term%damped) return
      dashpot = term
      dashpot%instant = end_dashpot
      dashpot%coefficient = (1.0_wp - linear%scheme%chi)*linear%time_step*stiffness
      call add_term(linear%terms, dashpot)
   end subroutine add_spring

   !> Set another normal stiffness, with the same ratios of shear springs and supports to it.
   subroutine set_penalty(linear, normal_stiffness)
      type(linear_model_type), intent(inout) :: linear  !< linearised model
      real(wp), intent(in) :: normal_stiffness  !< k_n, N/m per metre of thickness

      call scale_penalty(linear%terms, normal_stiffness/linear%normal_stiffness)
      linear%normal_stiffness = normal_stiffness
      call assemble(linear)
   end subroutine set_penalty

   !> Sum elasticity and terms into K, with the pattern of the terms.
   !> The pattern is set again, because bolts that break during a run change the elements.
   subroutine assemble(linear)
      type(linear_model_type), intent(inout) :: linear  !< linearised model
      integer :: b
      logical :: fits

      call set_pattern(linear%stiffness, linear%n, coupled_blocks(linear%terms))
      do b = 1, linear%n
         linear%stiffness%diagonal(4:6, 4:6, b) = linear%elastic(:, :, b)
      end do
      call add_to_matrix(linear%terms, stiffness_weights, linear%stiffness, fits)
   end subroutine assemble

   !> Distribute the elastic energy xᵀKx of a motion x over the kinds of terms.
   pure function energy_of(linear, x) result(energy)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      real(wp), intent(in) :: x(:,:)  !< [6,n] motion
      type(energy_distribution_type) :: energy
      real(wp) :: term_energy
      integer :: i

      do i = 1, linear%terms%n
         associate (term => linear%terms%term(i))
            term_energy = stiffness_weights(term%instant)*term%coefficient*stretch_of(term, x)**2
            call add_term_energy(energy, term%kind, i, term_energy)
            if (term%of_penalty) energy%of_penalty = energy%of_penalty + term_energy
            if (term%instant == at_end) energy%at_end = energy%at_end + term_energy
         end associate
      end do
      do i = 1, linear%n
         call add_term_energy(energy, strain_energy, i, &
            dot_product(x(4:6, i), matmul(linear%elastic(:, :, i), x(4:6, i))))
      end do
      energy%total = sum(energy%fraction)
      if (energy%total <= tiny(1.0_wp)) return
      energy%fraction = energy%fraction/energy%total
      energy%of_penalty = energy%of_penalty/energy%total
      energy%at_end = energy%at_end/energy%total
      energy%largest_fraction = energy%largest_fraction/energy%total
   end function energy_of

   !> Scheme of a mode: θ is the mean of the instants of its springs, weighted by their energies.
   pure type(scheme_type) function scheme_of_mode(linear, energy) result(scheme)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      type(energy_distribution_type), intent(in) :: energy  !< energies of the mode

      scheme = linear%scheme
      scheme%theta = scheme%theta + (1.0_wp - scheme%theta)*energy%at_end
   end function scheme_of_mode

   !> Add energy to a kind of terms; record its term or block with the most energy.
   pure subroutine add_term_energy(energy, kind, largest_term, term_energy)
      type(energy_distribution_type), intent(inout) :: energy  !< J per metre of thickness
      integer, intent(in) :: kind, largest_term  !< kind of term; number of the term or block
      real(wp), intent(in) :: term_energy         !< energy, J per metre of thickness

      energy%fraction(kind) = energy%fraction(kind) + term_energy
      ! of equal energies, the first term is recorded
      if (term_energy > (1.0_wp + equal_energies)*energy%largest_fraction(kind)) &
         energy%largest_term(kind) = largest_term
      energy%largest_fraction(kind) = max(energy%largest_fraction(kind), term_energy)
   end subroutine add_term_energy

   !> Text of a block: its number and name.
   pure function block_label(linear, b) result(label)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      integer, intent(in) :: b  !< number of the block
      character(len=:), allocatable :: label

      label = 'block '//to_text(b)
      if (linear%name(b) /= '') label = label//' '//quoted(linear%name(b))
   end function block_label

   !> Text of a term: its kind, blocks and position.
   pure function term_label(linear, i) result(label)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      integer, intent(in) :: i  !< number of the term
      character(len=:), allocatable :: label

      associate (term => linear%terms%term(i))
         label = trim(term_labels(term%kind))//merge(' between ', ' of      ', term%block_b > 0)
         label = trim(label)//' '//block_label(linear, term%block_a)
         if (term%block_b > 0) label = label//' and '//block_label(linear, term%block_b)
         label = label//' at ('//to_text(term%position + linear%origin)//') m'
      end associate
   end function term_label

end module dda_linear_model
