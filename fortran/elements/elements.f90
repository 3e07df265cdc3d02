! SPDX-License-Identifier: GPL-3.0-or-later
!> Elements of a model: registration of their kinds, and sums over all of them.
module dda_elements
   use dda_kinds, only: wp
   use dda_added_mass, only: new_added_mass
   use dda_absorbing, only: new_absorbing_boundaries
   use dda_archive, only: archive_type
   use dda_block_matrix, only: block_matrix_type
   use dda_blocks, only: blocks_type, shape_matrix, stress_of
   use dda_body_force, only: body_force_type
   use dda_bolts, only: bolts_type, bolt_columns, new_bolts
   use dda_cohesive, only: cohesive_type
   use dda_crack_law, only: crack_law_type
   use dda_errors, only: error_type, error_input, fail
   use dda_edge_loads, only: edge_loads_type
   use dda_element, only: element_type
   use dda_energy, only: energy_type, energy_law, energy_support, energy_water, energy_welded
   use dda_fixed_points, only: new_fixed_points, new_spring_beds
   use dda_joint_flow, only: joint_flow_type, new_joint_flow, node_columns, channel_columns
   use dda_free_sides, only: free_sides_type, new_free_sides
   use dda_joint_laws, only: law_slot_type, create_joint_law
   use dda_linear_terms, only: linear_terms_type
   use dda_material_points, only: acts, has_law
   use dda_model, only: model_type
   use dda_point_loads, only: point_loads_type
   use dda_scheme, only: step_type
   use dda_strain_points, only: strain_points_type, new_strain_points, add_point_stress, max_updates
   use dda_ties, only: ties_type, new_ties
   use dda_welds, only: welds_type, new_welds, add_face_stress, add_jump_energies
   implicit none
   private
   public :: elements_type, set_elements, register, list_linear_terms, pack_terms, add_packed, &
      add_forces, update_stored, account_elements, prepare_elements, revise_elements, &
      slope_beyond, unconverged_block, has_unconverged_bounds, table_search_failed, check_flow, &
      bolt_states, get_flow_states, accept_elements, match_velocities, freeze_elements, &
      balance_elements, serialise_elements, face_forces, set_free_field_motion, node_columns, &
      channel_columns, block_stress, stress_error, plastic_strain, body_energies

   !> One kind of elements.
   type :: kind_type
      class(element_type), allocatable :: element
   end type kind_type

   !> All kinds of elements of a model.
   type :: elements_type
      type(kind_type), allocatable :: kind(:)
      logical :: nonlinear = .false.  !< some materials have nonlinear laws
   end type elements_type

contains

   !> Create the elements that a model requires; new kinds are registered here.
   subroutine set_elements(elements, model, blocks, time)
      type(elements_type), intent(inout) :: elements  !< elements; states are retained
      type(model_type), intent(in) :: model  !< model with the changes of the stages so far
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      real(wp), intent(in) :: time  !< time from which elements act, s
      type(kind_type), allocatable :: former(:)

      call move_alloc(elements%kind, former)
      allocate (elements%kind(0))
      associate (control => model%control, contact => model%contact)
         if (any(abs(control%gravity) > 0.0_wp) .or. any(control%base_motion > 0)) &
            call register(elements, body_force_type(motions=model%motions, &
            gravity=control%gravity, base_motion=control%base_motion))
         if (size(model%loads) > 0) call register(elements, point_loads_type(load=model%loads))
         associate (points => model%fixed_points, soft => model%fixed_points%stiffness > 0.0_wp)
            if (.not. all(soft)) call register(elements, new_fixed_points( &
               pack(points, .not. soft), model%motions, &
               contact%fixed_point_ratio*contact%normal_stiffness, time))
            if (any(soft)) call register(elements, &
               new_spring_beds(pack(points, soft), model%motions, time))
         end associate
         if (size(model%boundaries) > 0) call register(elements, &
            new_absorbing_boundaries(model%boundaries, model%motions, &
            contact%fixed_point_ratio*contact%normal_stiffness))
      end associate
      if (size(model%ties) > 0) call register(elements, new_ties(model%ties, &
         model%contact%normal_stiffness*[1.0_wp, 1.0_wp/model%contact%shear_ratio]))
      if (size(model%free_fields) > 0) call register(elements, new_free_sides(model%free_fields))
      if (size(model%edge_loads) > 0) call register(elements, &
         edge_loads_type(load=model%edge_loads))
      if (any(model%edge_loads%reservoir > 0.0_wp)) call register(elements, &
         new_added_mass(model%edge_loads, model%control%base_motion, model%motions, blocks))
      if (size(model%bolts) > 0) call register(elements, new_bolts(model%bolts, blocks))
      if (allocated(model%flow)) call register(elements, new_joint_flow(model%flow, &
         model%edge_loads, blocks))
      if (size(model%welds) > 0) call register(elements, new_welds(model%welds, blocks, &
         model%materials, model%control%plane_strain))
      elements%nonlinear = any(model%materials%has_law()) .or. any(model%welds%joint > 0)
      if (elements%nonlinear) call register(elements, new_strain_points(model%welds, blocks, &
         model%materials, crack_laws(model), model%control%plane_strain))
      if (allocated(former)) call inherit_states(elements, former, blocks)
   end subroutine set_elements

   !> Return the laws of faces that break, by joint; unset for joints that cannot replace a face.
   function crack_laws(model) result(laws)
      type(model_type), intent(in) :: model  !< model with joints
      type(crack_law_type) :: laws(size(model%joints))
      type(law_slot_type) :: slot
      integer :: j

      do j = 1, size(model%joints)
         call create_joint_law(slot, model%joints(j), model%contact%normal_stiffness, &
            model%contact%shear_ratio)
         select type (law => slot%law)
         type is (cohesive_type)
            laws(j) = crack_law_type(joint=law)
         end select
      end do
   end function crack_laws

   !> Transfer states to the elements of the same type in a new model.
   subroutine inherit_states(elements, former, blocks)
      type(elements_type), intent(inout) :: elements  !< new elements
      type(kind_type), intent(in) :: former(:)        !< former elements
      type(blocks_type), intent(in) :: blocks         !< blocks in their present state
      integer :: i, k

      do i = 1, size(elements%kind)
         do k = 1, size(former)
            if (same_type_as(elements%kind(i)%element, former(k)%element)) &
               call elements%kind(i)%element%inherit_state(former(k)%element, blocks)
         end do
      end do
   end subroutine inherit_states

   !> Append a kind of elements.
   subroutine register(elements, element)
      type(elements_type), intent(inout) :: elements  !< elements of the model
      class(element_type), intent(in) :: element  !< elements of a kind
      type(kind_type), allocatable :: longer(:)
      integer :: i

      allocate (longer(size(elements%kind) + 1))
      do i = 1, size(elements%kind)
         call move_alloc(elements%kind(i)%element, longer(i)%element)
      end do
      allocate (longer(size(longer))%element, source=element)
      call move_alloc(longer, elements%kind)
   end subroutine register

   !> List all springs and dashpots in the present geometry.
   subroutine list_linear_terms(elements, blocks, step, terms, packed)
      type(elements_type), intent(in) :: elements  !< elements of the model
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(step_type), intent(in) :: step  !< the present step
      type(linear_terms_type), intent(inout) :: terms  !< springs and dashpots
      logical, intent(in), optional :: packed  !< .true.: without those that `add_packed` adds
      logical :: omit_packed
      integer :: i

      omit_packed = .false.
      if (present(packed)) omit_packed = packed
      terms%n = 0  ! the allocated memory is reused
      do i = 1, size(elements%kind)
         if (omit_packed .and. elements%kind(i)%element%packs) cycle
         call elements%kind(i)%element%add_linear_terms(blocks, step, terms)
      end do
   end subroutine list_linear_terms

   !> .true. if some elements can add their terms to K̂ without a list.
   pure logical function pack_terms(elements)
      type(elements_type), intent(in) :: elements  !< elements of the model
      integer :: i

      pack_terms = .false.
      do i = 1, size(elements%kind)
         pack_terms = pack_terms .or. elements%kind(i)%element%packs
      end do
   end function pack_terms

   !> Add all terms to K̂ that need no list.
   subroutine add_packed(elements, matrix, fits)
      type(elements_type), intent(in) :: elements  !< elements of the model
      type(block_matrix_type), intent(inout) :: matrix  !< linear part of K̂
      logical, intent(inout) :: fits  !< set to .false. if the pattern lacks a pair
      integer :: i

      do i = 1, size(elements%kind)
         if (elements%kind(i)%element%packs) call elements%kind(i)%element%add_packed(matrix, fits)
      end do
   end subroutine add_packed

   !> Add all forces of a step at d = 0 to f̂.
   subroutine add_forces(elements, blocks, step, load)
      type(elements_type), intent(in) :: elements  !< elements of the model
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(step_type), intent(in) :: step  !< the present step
      real(wp), intent(inout) :: load(:,:)  !< [6,blocks] forces, N/m …
      integer :: i

      do i = 1, size(elements%kind)
         call elements%kind(i)%element%add_force(blocks, step, load)
      end do
   end subroutine add_forces

   !> Sum the energy that elements store in the present state.
   subroutine update_stored(elements, blocks, step, energy)
      type(elements_type), intent(in) :: elements  !< elements of the model
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(step_type), intent(in) :: step         !< the next step
      type(energy_type), intent(inout) :: energy  !< energy budget, J per metre
      integer :: i

      energy%value([energy_support, energy_welded, energy_law, energy_water]) = 0.0_wp
      do i = 1, size(elements%kind)
         call elements%kind(i)%element%add_stored_energy(blocks, step, energy)
      end do
   end subroutine update_stored

   !> Add work, losses and stored energy of the converged increment d before it is applied.
   subroutine account_elements(elements, blocks, step, d, energy)
      type(elements_type), intent(in) :: elements  !< elements of the model
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(step_type), intent(in) :: step  !< the present step
      real(wp), intent(in) :: d(:,:)              !< [6,blocks] increments of the coordinates
      type(energy_type), intent(inout) :: energy  !< energy budget, J per metre
      integer :: i

      energy%value([energy_support, energy_welded, energy_law, energy_water]) = 0.0_wp
      do i = 1, size(elements%kind)
         call elements%kind(i)%element%add_to_budget(blocks, step, d, energy)
      end do
   end subroutine account_elements

   !> Prepare a step: linearise nonlinear terms at an increment.
   subroutine prepare_elements(elements, blocks, step, d)
      type(elements_type), intent(inout) :: elements  !< elements of the model
      type(blocks_type), intent(in) :: blocks  !< blocks at the start of the step
      type(step_type), intent(in) :: step      !< the present step
      real(wp), intent(in) :: d(:,:)           !< [6,blocks] increments of the coordinates
      integer :: i

      do i = 1, size(elements%kind)
         call elements%kind(i)%element%prepare_step(blocks, step, d)
      end do
   end subroutine prepare_elements

   !> Count and revise assumed states that contradict the converged increment d.
   subroutine revise_elements(elements, blocks, step, d, changed)
      type(elements_type), intent(inout) :: elements  !< elements of the model
      type(blocks_type), intent(in) :: blocks  !< blocks at the start of the step
      type(step_type), intent(in) :: step      !< the present step
      real(wp), intent(in) :: d(:,:)           !< [6,blocks] increments of the coordinates
      integer, intent(out) :: changed          !< number of changed states
      integer :: i

      changed = 0
      do i = 1, size(elements%kind)
         call elements%kind(i)%element%revise_states(blocks, step, d, changed)
      end do
   end subroutine revise_elements

   !> Return the slope of the nonlinear energy of a step on the path between two increments.
   !> Unit: J per metre of thickness.
   real(wp) function slope_beyond(elements, blocks, step, from, to, fraction) result(slope)
      type(elements_type), intent(in) :: elements  !< prepared for the step
      type(blocks_type), intent(in) :: blocks      !< blocks at the start of the step
      type(step_type), intent(in) :: step          !< the present step
      real(wp), intent(in) :: from(:,:), to(:,:)   !< [6,blocks] increments
      real(wp), intent(in) :: fraction             !< fraction of the path, 0 … 1
      integer :: i

      slope = 0.0_wp
      do i = 1, size(elements%kind)
         slope = slope + elements%kind(i)%element%slope_beyond(blocks, step, from, to, fraction)
      end do
   end function slope_beyond

   !> Return the block with the largest unconverged stress of a law; 0 if all have converged.
   pure integer function unconverged_block(elements) result(block)
      type(elements_type), intent(in) :: elements  !< elements of the model
      integer :: i

      block = 0
      do i = 1, size(elements%kind)
         select type (element => elements%kind(i)%element)
         type is (strain_points_type)
            if (element%unconverged > 0) block = element%block(1, element%unconverged)
         end select
      end do
   end function unconverged_block

   !> .true. if frozen bounds of materials have not converged in the step.
   pure logical function has_unconverged_bounds(elements)
      type(elements_type), intent(in) :: elements  !< elements of the model
      integer :: i

      has_unconverged_bounds = .false.
      do i = 1, size(elements%kind)
         select type (element => elements%kind(i)%element)
         type is (strain_points_type)
            has_unconverged_bounds = element%round > max_updates
         end select
      end do
   end function has_unconverged_bounds

   !> .true. if the search for the water table has failed in the step.
   pure logical function table_search_failed(elements)
      type(elements_type), intent(in) :: elements  !< elements of the model
      integer :: i

      table_search_failed = .false.
      do i = 1, size(elements%kind)
         select type (element => elements%kind(i)%element)
         type is (joint_flow_type)
            table_search_failed = element%table_failed
         end select
      end do
   end function table_search_failed

   !> Fail if water in joints has no steady flow in the prepared step.
   pure subroutine check_flow(elements, error)
      type(elements_type), intent(in) :: elements  !< elements of the model
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained
      integer :: i

      do i = 1, size(elements%kind)
         select type (element => elements%kind(i)%element)
         type is (joint_flow_type)
            if (allocated(element%failure)) call fail(error, error_input, element%failure)
         end select
      end do
   end subroutine check_flow

   !> Return the values of the bolts in the output.
   pure function bolt_states(elements, n) result(states)
      type(elements_type), intent(in) :: elements  !< elements of the model
      integer, intent(in) :: n                     !< bolts of the model
      real(wp) :: states(bolt_columns, n)
      integer :: i

      states = 0.0_wp
      do i = 1, size(elements%kind)
         select type (element => elements%kind(i)%element)
         type is (bolts_type)
            states = element%columns()
         end select
      end do
   end function bolt_states

   !> Return the values of the nodes and channels of water in the output.
   pure subroutine get_flow_states(elements, nodes, channels)
      type(elements_type), intent(in) :: elements  !< elements of the model
      real(wp), intent(out) :: nodes(:,:)     !< [`node_columns`,nodes]
      real(wp), intent(out) :: channels(:,:)  !< [`channel_columns`,channels]
      integer :: i

      do i = 1, size(elements%kind)
         select type (element => elements%kind(i)%element)
         type is (joint_flow_type)
            nodes = element%node_values()
            channels = element%channel_values()
         end select
      end do
   end subroutine get_flow_states

   !> Return the forces of ties and of welds with images on one face, in a step with a known d.
   !> The forces act at t₀ + θΔt.
   function face_forces(elements, face, blocks, step, d) result(force)
      type(elements_type), intent(in) :: elements  !< elements of the model
      integer, intent(in) :: face                  !< face of each tie and weld, 1 or 2
      type(blocks_type), intent(in) :: blocks      !< blocks at the start of the step
      type(step_type), intent(in) :: step          !< the present step
      real(wp), intent(in) :: d(:,:)               !< [6,blocks] increments of the coordinates
      real(wp) :: force(6, blocks%n)               !< N/m …
      integer :: i

      force = 0.0_wp
      do i = 1, size(elements%kind)
         select type (element => elements%kind(i)%element)
         type is (ties_type)
            call element%add_face_force(face, blocks, step, d, force)
         type is (welds_type)
            call element%add_face_force(face, blocks, step, d, force)
         type is (strain_points_type)
            call element%add_face_force(face, blocks, step, d, force)
         end select
      end do
   end function face_forces

   !> Return the mean stress (σx, σy, τxy) of each block or cell in the axes of the model, Pa.
   function block_stress(elements, blocks) result(stress)
      type(elements_type), intent(in) :: elements  !< elements of the model
      type(blocks_type), intent(in) :: blocks      !< blocks in their present state
      real(wp), allocatable :: stress(:,:)         !< [3,blocks]
      real(wp), allocatable :: of_faces(:,:)
      integer :: i, b

      allocate (stress(3, blocks%n))
      if (any(blocks%body > 0) .or. elements%nonlinear) allocate (of_faces(3, blocks%n), &
         source=0.0_wp)
      do i = 1, size(elements%kind)
         select type (element => elements%kind(i)%element)
         type is (welds_type)
            call add_face_stress(element, blocks, of_faces)
         type is (strain_points_type)
            call add_point_stress(element, blocks, of_faces)
         end select
      end do
      do b = 1, blocks%n
         if (allocated(of_faces)) then
            stress(:, b) = stress_of(blocks, b, of_faces(:, b))
         else
            stress(:, b) = stress_of(blocks, b)
         end if
      end do
   end function block_stress

   !> Return the estimated stress error of cells, Pa; 0 for other blocks.
   !> It is the uniaxial stress, at zero lateral strain, whose energy equals the energy of the jumps
   !> around a cell.
   function stress_error(elements, blocks) result(stress)
      type(elements_type), intent(in) :: elements  !< elements of the model
      type(blocks_type), intent(in) :: blocks      !< blocks in their present state
      real(wp) :: stress(blocks%n), strain_energy
      integer :: b

      call estimate_stress_errors(elements, blocks, stress, strain_energy)
      do b = 1, blocks%n
         stress(b) = sqrt(2*stress(b)*blocks%stiffness(1, 1, b))/blocks%area(b)
      end do
   end function stress_error

   !> Return the largest plastic strain within each block whose material yields.
   function plastic_strain(elements, blocks) result(strain)
      type(elements_type), intent(in) :: elements  !< elements of the model
      type(blocks_type), intent(in) :: blocks      !< blocks in their present state
      real(wp) :: strain(blocks%n), point_strain
      integer :: i, k, p, b

      strain = 0.0_wp
      do i = 1, size(elements%kind)
         select type (element => elements%kind(i)%element)
         type is (strain_points_type)
            do p = 1, element%n
               if (.not. acts(element, p, blocks)) cycle
               if (.not. has_law(element, element%material(p))) cycle
               point_strain = element%slot(element%material(p))%law%plastic_strain( &
                  element%state(:, p))
               do k = 1, count(element%block(:, p) > 0)
                  b = element%block(k, p)
                  strain(b) = max(strain(b), point_strain)
               end do
            end do
         end select
      end do
   end function plastic_strain

   !> Estimate the stress error of each cell by the energy of the jumps at its faces, and sum the
   !> strain energy of all faces, J per metre of thickness.
   subroutine estimate_stress_errors(elements, blocks, error, strain_energy)
      type(elements_type), intent(in) :: elements  !< elements of the model
      type(blocks_type), intent(in) :: blocks      !< blocks in their present state
      real(wp), intent(out) :: error(:), strain_energy    !< [blocks] energy of jumps; strain energy
      integer :: i

      error = 0.0_wp
      strain_energy = 0.0_wp
      do i = 1, size(elements%kind)
         select type (element => elements%kind(i)%element)
         type is (welds_type)
            call add_jump_energies(element, blocks, error, strain_energy)
         end select
      end do
   end subroutine estimate_stress_errors

   !> Return the energy of the jumps, which estimates the stress error, and the total energy of
   !> bodies, J per metre of thickness.
   function body_energies(elements, blocks) result(energies)
      type(elements_type), intent(in) :: elements  !< elements of the model
      type(blocks_type), intent(in) :: blocks      !< blocks in their present state
      real(wp) :: energies(2), error(blocks%n)
      integer :: b

      call estimate_stress_errors(elements, blocks, error, energies(2))
      energies(1) = sum(error)
      do b = 1, blocks%n
         if (blocks%body(b) == 0 .or. blocks%removed(b)) cycle
         associate (strain => blocks%position(4:6, b))
            energies(2) = energies(2) + 0.5_wp*blocks%interior_fraction(b) &
               *dot_product(strain, matmul(blocks%stiffness(:, :, b), strain))
         end associate
      end do
   end function body_energies

   !> Pass the motion of a free-field column in a step to a side of the model, with its forces.
   !> The forces act between the blocks of the column and their images.
   subroutine set_free_field_motion(elements, number, block, column, d, force)
      type(elements_type), intent(inout) :: elements  !< elements of the model
      integer, intent(in) :: number                   !< number of the free field
      integer, intent(in) :: block(:)                 !< [n] blocks of the model in the column
      type(blocks_type), intent(in) :: column  !< blocks of the column at the start of the step
      real(wp), intent(in) :: d(:,:)  !< [6,n] increments of these blocks in the step
      real(wp), intent(in) :: force(:,:)  !< [6,n] forces on these blocks at the side, N/m …
      integer :: i, k, b

      do i = 1, size(elements%kind)
         select type (element => elements%kind(i)%element)
         type is (free_sides_type)
            do k = 1, size(element%block)
               b = findloc(block, element%block(k), 1)
               if (b > 0) element%reaction(:, k) = force(:, b)
            end do
            do k = 1, size(element%point)
               if (element%field(k) /= number) cycle
               b = findloc(block, element%point(k)%block, 1)
               element%ground_increment(:, k) = matmul(matmul(shape_matrix(column, b, &
                  element%point(k)%reference), d(:, b)), element%axes(:, :, k))
            end do
         end select
      end do
   end subroutine set_free_field_motion

   !> Accept the step: update the states of all elements.
   subroutine accept_elements(elements, blocks, step, d)
      type(elements_type), intent(inout) :: elements  !< elements of the model
      type(blocks_type), intent(in) :: blocks  !< blocks at the start of the step
      type(step_type), intent(in) :: step  !< the present step
      real(wp), intent(in) :: d(:,:)  !< [6,blocks] increments of the coordinates
      integer :: i

      do i = 1, size(elements%kind)
         call elements%kind(i)%element%accept_step(blocks, step, d)
      end do
   end subroutine accept_elements

   !> Correct initial velocities that stiff elements do not permit.
   subroutine match_velocities(elements, blocks, step)
      type(elements_type), intent(in) :: elements  !< elements of the model
      type(blocks_type), intent(inout) :: blocks  !< blocks in their present state
      type(step_type), intent(in) :: step         !< the next step
      real(wp) :: velocity(6, blocks%n)
      integer :: i

      velocity = blocks%velocity
      do i = 1, size(elements%kind)
         call elements%kind(i)%element%match_velocity(blocks, step, velocity)
      end do
      blocks%velocity = velocity
   end subroutine match_velocities

   !> Fix loads and prescribed positions in static stages, and stop base motions.
   subroutine freeze_elements(elements, blocks, time)
      type(elements_type), intent(inout) :: elements  !< elements of the model
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      real(wp), intent(in) :: time  !< time, s
      integer :: i

      do i = 1, size(elements%kind)
         call elements%kind(i)%element%freeze_for_statics(blocks, time)
      end do
   end subroutine freeze_elements

   !> Add unbalanced forces after statics to constant reactions.
   subroutine balance_elements(elements, blocks, unbalanced)
      type(elements_type), intent(inout) :: elements  !< elements of the model
      type(blocks_type), intent(in) :: blocks  !< blocks in static equilibrium
      real(wp), intent(in) :: unbalanced(:,:)  !< [6,blocks] sum of all forces, N/m …
      integer :: i

      do i = 1, size(elements%kind)
         call elements%kind(i)%element%balance_reactions(blocks, unbalanced)
      end do
   end subroutine balance_elements

   !> Save or restore the states of all elements.
   subroutine serialise_elements(elements, archive)
      type(elements_type), intent(inout) :: elements  !< elements of the model
      type(archive_type), intent(inout) :: archive  !< archive that is written or read
      integer :: i

      do i = 1, size(elements%kind)
         call elements%kind(i)%element%serialise(archive)
      end do
   end subroutine serialise_elements

end module dda_elements
