! SPDX-License-Identifier: GPL-3.0-or-later
!> The energy budget of a step (see `dda_energy`).
module dda_energy_budget
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type, momentum_of
   use dda_contact, only: contacts_type, not_damped
   use dda_contact_damping, only: losses_type, losses_of, spring_energy
   use dda_friction, only: end_stretch, slip_counts, inelastic_slip, laws_type
   use dda_joint_bond, only: bond_losses, bond_after, is_cohesive
   use dda_joint_contact, only: joint_energy, start_energy, state_of
   use dda_joint_law, only: joint_state_type, weakened
   use dda_elements, only: elements_type, update_stored, account_elements
   use dda_energy, only: energy_type, add_energy, total_energy, energy_kinetic, energy_strain, &
      energy_contact, energy_support, energy_initial, energy_friction, energy_fracture, &
      energy_algorithmic, energy_damping, energy_dilation, energy_geometric, energy_impact, &
      energy_law, energy_material_damping, energy_water, energy_welded
   use dda_kinematics, only: kinetic_energy
   use dda_material_damping, only: damping_losses, damping_energy
   use dda_ordered_sums, only: pieces, first_of, last_of, most_pieces, parallel_from
   use dda_scheme, only: step_type, momentum_weight, velocity_weight
   implicit none
   private
   public :: start_energy_budget, update_geometric, update_step, update_state, strain_energy

contains

   !> Set the energies of the initial state.
   subroutine start_energy_budget(energy, blocks, contacts, laws, elements, step)
      type(energy_type), intent(out) :: energy  !< J per metre of thickness
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      type(elements_type), intent(in) :: elements  !< elements of the model
      type(step_type), intent(in) :: step  !< first step

      call update_state(energy, blocks)
      energy%value(energy_contact) = contact_energy(contacts, laws)
      call update_stored(elements, blocks, step, energy)
      energy%value(energy_initial) = total_energy(energy)
   end subroutine start_energy_budget

   !> Add the geometric energy of a step to the budget: the spring energy in the exact geometry
   !> after the step minus the spring energy in the linearised geometry of the step.
   subroutine update_geometric(energy, blocks, contacts, laws, elements, step)
      type(energy_type), intent(inout) :: energy  !< J per metre of thickness
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      type(elements_type), intent(in) :: elements  !< elements of the model
      type(step_type), intent(in) :: step  !< the next step
      integer, parameter :: stored(5) = [energy_contact, energy_support, energy_welded, &
         energy_law, energy_water]
      real(wp) :: change(5)
      integer :: i

      change = energy%value(stored)
      energy%value(energy_contact) = contact_energy(contacts, laws)
      call update_stored(elements, blocks, step, energy)
      change = energy%value(stored) - change
      call add_energy(energy, energy_geometric, change(1) + change(2))
      do i = 3, size(stored)
         call add_energy(energy, energy_geometric, change(i))
      end do
   end subroutine update_geometric

   !> Add losses and work of the converged step, before d is added to the coordinates.
   subroutine update_step(energy, blocks, contacts, laws, elements, step, d)
      type(energy_type), intent(inout) :: energy  !< J per metre of thickness
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      type(elements_type), intent(in) :: elements  !< elements of the model
      type(step_type), intent(in) :: step  !< the present step
      real(wp), intent(in) :: d(:,:)  !< [6,blocks] increments of the coordinates

      call update_contacts(energy, contacts, laws, step)
      call add_block_losses(energy, blocks, step, d)
      call account_elements(elements, blocks, step, d, energy)
   end subroutine update_step

   !> Set the energies that follow from the new state of the blocks.
   subroutine update_state(energy, blocks)
      type(energy_type), intent(inout) :: energy  !< J per metre of thickness
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state

      energy%value(energy_kinetic) = kinetic_energy(blocks)
      energy%value(energy_strain) = strain_energy(blocks)
   end subroutine update_state

   !> Add the losses of all blocks by damping and by the scheme: (θ − ½) ΔσΔε + (χ − ½) ΔvᵀMΔv.
   subroutine add_block_losses(energy, blocks, step, d)
      type(energy_type), intent(inout) :: energy  !< J per metre of thickness
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(step_type), intent(in) :: step  !< the present step
      real(wp), intent(in) :: d(:,:)  !< [6,blocks] increments of the coordinates
      real(wp) :: part(2, most_pieces), total(2), damping(2)
      integer :: p

      if (blocks%n < parallel_from) then
         total = sum_quadratic_forms(blocks, step, d, 1, blocks%n)
      else
         !$omp parallel do schedule(static)
         do p = 1, pieces(blocks%n)
            part(:, p) = sum_quadratic_forms(blocks, step, d, first_of(p, blocks%n), &
               last_of(p, blocks%n))
         end do
         total = sum(part(:, :pieces(blocks%n)), 2)
      end if
      call add_energy(energy, energy_algorithmic, (step%scheme%theta - 0.5_wp)*total(1) &
         + (step%scheme%chi - 0.5_wp)*total(2))
      if (.not. blocks%damps) return
      damping = damping_losses(blocks, step, d)
      call add_energy(energy, energy_material_damping, damping(1))
      call add_energy(energy, energy_algorithmic, (step%scheme%theta - 0.5_wp)*damping(2))
   end subroutine add_block_losses

   !> Sum dᵀKd of the strains and, if χ > ½, ΔvᵀMΔv of blocks first … last.
   pure function sum_quadratic_forms(blocks, step, d, first, last) result(total)
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(step_type), intent(in) :: step  !< the present step
      real(wp), intent(in) :: d(:,:)  !< [6,blocks] increments of the coordinates
      integer, intent(in) :: first, last  !< first and last in the range
      real(wp) :: total(2), velocity_change(6)
      integer :: b

      total = 0.0_wp
      do b = first, last
         total(1) = total(1) + blocks%interior_fraction(b)*quadratic_form( &
            blocks%stiffness(:, :, b), d(4:6, b))
         if (.not. step%scheme%chi > 0.5_wp) cycle
         velocity_change = momentum_weight(step)*d(:, b) &
            - (velocity_weight(step) + 1.0_wp)*blocks%velocity(:, b)
         total(2) = total(2) + dot_product(velocity_change, &
            momentum_of(blocks%inertia(:, b), velocity_change))
      end do
   end function sum_quadratic_forms

   !> Return the quadratic form εᵀDε.
   pure real(wp) function quadratic_form(stiffness, strain)
      real(wp), intent(in) :: stiffness(3, 3), strain(3)  !< area × D, N; strain of a block

      quadratic_form = dot_product(strain, stiffness(:, 1)*strain(1) + stiffness(:, 2)*strain(2) &
         + stiffness(:, 3)*strain(3))
   end function quadratic_form

   !> Set the stored energy at the end of the step and add the losses of all contacts.
   subroutine update_contacts(energy, contacts, laws, step)
      type(energy_type), intent(inout) :: energy  !< J per metre of thickness
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      type(step_type), intent(in) :: step  !< the present step
      real(wp) :: part(7, most_pieces), total(7)
      integer :: p

      if (contacts%n < parallel_from) then
         total = sum_contacts(contacts, laws, step, 1, contacts%n)
      else
         !$omp parallel do schedule(static)
         do p = 1, pieces(contacts%n)
            part(:, p) = sum_contacts(contacts, laws, step, first_of(p, contacts%n), &
               last_of(p, contacts%n))
         end do
         total = sum(part(:, :pieces(contacts%n)), 2)
      end if
      energy%value(energy_contact) = total(1)
      call add_energy(energy, energy_friction, total(2))
      call add_energy(energy, energy_fracture, total(3))
      call add_energy(energy, energy_algorithmic, total(4))
      call add_energy(energy, energy_dilation, total(5))
      call add_energy(energy, energy_damping, total(6))
      call add_energy(energy, energy_impact, total(7))
   end subroutine update_contacts

   !> Sum seven energies of contacts first … last, J per metre of thickness: stored; lost by slip,
   !> by fracture, by the scheme; gained by dilation; lost in dashpots, in impacts.
   pure function sum_contacts(contacts, laws, step, first, last) result(total)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      type(step_type), intent(in) :: step  !< the present step
      integer, intent(in) :: first, last  !< first and last in the range
      real(wp) :: total(7)
      type(losses_type) :: losses
      integer :: c

      total = 0.0_wp
      do c = first, last
         if (is_damped(contacts, laws, c)) then
            losses = losses_of(contacts, laws, step, c)
            total = total + [losses%stored, losses%friction, 0.0_wp, losses%algorithmic, 0.0_wp, &
               losses%damping, losses%impact]
         else if (has_bond(contacts, laws, c)) then
            call add_bond(total(:5), contacts, laws, c)
         else
            call add_contact(total(:5), contacts, laws, c)
         end if
      end do
   end function sum_contacts

   !> .true. if dashpots or impacts act in contact c.
   pure logical function is_damped(contacts, laws, c)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c  !< number of the contact

      is_damped = laws%damped
      if (is_damped) is_damped = contacts%damping(c) /= not_damped
   end function is_damped

   !> Add stored energy, and losses by slip, by fracture and by the scheme, of one contact.
   !> Friction includes the work that lifts the contact, which `total(5)` contains as a gain.
   pure subroutine add_contact(total, contacts, laws, c)
      real(wp), intent(inout) :: total(5)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c  !< number of the contact
      real(wp) :: first_energy, end_energy, lift, stretched, work, slip_loss, loss
      logical :: breaks

      stretched = end_stretch(contacts, laws, c)
      if (laws%plain) then
         lift = 0.0_wp
         first_energy = stored_energy(laws, contacts%gap(c), contacts%was_closed(c), &
            contacts%was_bonded(c), contacts%stretch(c))
         end_energy = stored_energy(laws, contacts%new_gap(c), contacts%normal_force(c) /= 0.0_wp, &
            contacts%bonded(c), stretched)
      else
         call find_joint_energies(contacts, laws, c, stretched, first_energy, end_energy, lift)
      end if
      work = contacts%normal_force(c)*(contacts%new_gap(c) - contacts%gap(c) - lift) &
         - contacts%shear_force(c)*contacts%slip(c)
      slip_loss = contacts%shear_force(c)*(contacts%slip(c) - (stretched - contacts%stretch(c)))
      breaks = contacts%was_bonded(c) .and. .not. contacts%bonded(c)
      total(1) = total(1) + end_energy
      total(2) = total(2) + slip_loss
      if (.not. laws%plain) then
         breaks = breaks .or. contacts%was_weakened(c) < contacts%memory(weakened, c)
         if (laws%slot(contacts%joint(c))%law%crushes) then
            total(3) = total(3) - contacts%normal_force(c)*lift
         else
            total(5) = total(5) + contacts%normal_force(c)*lift
         end if
      end if
      loss = first_energy - end_energy - work - slip_loss
      if (breaks) then
         total(3) = total(3) + loss
      else
         total(4) = total(4) + loss
      end if
   end subroutine add_contact

   !> Find the energies of a contact under a joint law at the start and at the end of the step, and
   !> its lift by slip or plastic closure in the step.
   pure subroutine find_joint_energies(contacts, laws, c, stretched, first_energy, end_energy, lift)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c  !< number of the contact
      real(wp), intent(in) :: stretched  !< stretch of the shear spring at the end, m
      real(wp), intent(out) :: first_energy, end_energy, lift  !< J per metre; m
      type(joint_state_type) :: state
      real(wp) :: slip

      associate (law => laws%slot(contacts%joint(c))%law)
         state = state_of(contacts, law, c)
         slip = 0.0_wp
         if (slip_counts(contacts, laws, c)) slip = inelastic_slip(contacts, laws, c)
         lift = law%lift(law%state_after_slip(state, slip, contacts%shear_force(c))) &
            - law%lift(state)
         first_energy = start_energy(contacts, law, c, contacts%was_closed(c) .or. &
            contacts%was_bonded(c))
         end_energy = joint_energy(law, state, law%lift(state) - contacts%new_gap(c) + lift, &
            stretched, contacts%normal_force(c) /= 0.0_wp .or. contacts%bonded(c))
      end associate
   end subroutine find_joint_energies

   !> .true. if contact c has a bond with gradual damage.
   pure logical function has_bond(contacts, laws, c)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c  !< number of the contact

      has_bond = laws%cohesive
      if (has_bond) has_bond = is_cohesive(contacts, laws%slot(contacts%joint(c))%law, c)
   end function has_bond

   !> Add the energies of one contact with a gradually damaged bond.
   pure subroutine add_bond(total, contacts, laws, c)
      real(wp), intent(inout) :: total(5)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c  !< number of the contact
      type(joint_state_type) :: after
      real(wp) :: first_energy, end_energy, losses(2), loss

      associate (law => laws%slot(contacts%joint(c))%law)
         first_energy = start_energy(contacts, law, c, .true.)
         after = bond_after(contacts, law, c)
         end_energy = joint_energy(law, after, -contacts%new_gap(c), end_stretch(contacts, laws, &
            c), .true.)
         losses = bond_losses(contacts, law, c, after)
      end associate
      loss = first_energy - end_energy - contacts%normal_force(c)*(contacts%new_gap(c) &
         - contacts%gap(c)) + contacts%shear_force(c)*contacts%slip(c)
      total(1) = total(1) + end_energy
      total(2:3) = total(2:3) + losses
      total(4) = total(4) + loss - losses(1) - losses(2)
   end subroutine add_bond

   !> Return the spring energy of a contact at a gap and a shear stretch.
   !> With an augmented Lagrangian the contact is rigid, so the normal force stores no energy.
   pure real(wp) function stored_energy(laws, gap, closed, bonded, stretch)
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      real(wp), intent(in) :: gap, stretch  !< gap and shear stretch, m
      logical, intent(in) :: closed, bonded  !< the contact is closed; bonded

      stored_energy = 0.5_wp*laws%shear_stiffness*stretch**2
      if (bonded .or. (closed .and. .not. laws%augmented)) &
         stored_energy = stored_energy + 0.5_wp*laws%normal_stiffness*gap**2
   end function stored_energy

   !> Return the energy in the springs of all contacts in the present geometry, J per metre.
   real(wp) function contact_energy(contacts, laws)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      real(wp) :: part(most_pieces)
      integer :: p

      if (contacts%n < parallel_from) then
         contact_energy = sum_stored(contacts, laws, 1, contacts%n)
         return
      end if
      !$omp parallel do schedule(static)
      do p = 1, pieces(contacts%n)
         part(p) = sum_stored(contacts, laws, first_of(p, contacts%n), last_of(p, contacts%n))
      end do
      contact_energy = sum(part(:pieces(contacts%n)))
   end function contact_energy

   !> Sum the spring energies of contacts first … last.
   pure real(wp) function sum_stored(contacts, laws, first, last)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: first, last  !< first and last in the range
      integer :: c

      sum_stored = 0.0_wp
      if (.not. laws%plain) then
         do c = first, last
            associate (law => laws%slot(contacts%joint(c))%law)
               sum_stored = sum_stored + start_energy(contacts, law, c, contacts%was_closed(c) &
                  .or. contacts%bonded(c))
            end associate
         end do
         return
      end if
      do c = first, last
         if (is_damped(contacts, laws, c)) then
            sum_stored = sum_stored + spring_energy(contacts, laws, c)
            cycle
         end if
         sum_stored = sum_stored + stored_energy(laws, contacts%gap(c), contacts%was_closed(c), &
            contacts%bonded(c), contacts%stretch(c))
      end do
   end function sum_stored

   !> Sum of ½ A εᵀDε + A σ₀ᵀε over all blocks, and the energy of the Maxwell branches.
   real(wp) function strain_energy(blocks)
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      real(wp) :: part(most_pieces)
      integer :: p

      if (blocks%n < parallel_from) then
         strain_energy = sum_strain(blocks, 1, blocks%n)
      else
         !$omp parallel do schedule(static)
         do p = 1, pieces(blocks%n)
            part(p) = sum_strain(blocks, first_of(p, blocks%n), last_of(p, blocks%n))
         end do
         strain_energy = sum(part(:pieces(blocks%n)))
      end if
      if (blocks%damps) strain_energy = strain_energy + damping_energy(blocks)
   end function strain_energy

   !> Sum of ½ A εᵀDε + A σ₀ᵀε over blocks first … last.
   pure real(wp) function sum_strain(blocks, first, last) result(energy)
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      integer, intent(in) :: first, last  !< first and last in the range
      integer :: b

      energy = 0.0_wp
      do b = first, last
         energy = energy + blocks%interior_fraction(b)*(0.5_wp*quadratic_form(blocks%stiffness(:, &
            :, b), &
            blocks%position(4:6, b)) + blocks%area(b)*dot_product(blocks%initial_stress(:, b), &
            blocks%position(4:6, b)))
      end do
   end function sum_strain

end module dda_energy_budget
