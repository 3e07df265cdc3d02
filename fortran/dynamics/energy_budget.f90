!> Books of a step: where its energy went (see dda_energy).
module dda_energy_budget
   use dda_kinds, only: wp
   use dda_system, only: support_target, base_force
   use dda_blocks, only: blocks_type, place_of, shape_matrix
   use dda_contact, only: contacts_type
   use dda_energy, only: energy_type
   use dda_friction, only: laws_type
   use dda_model, only: model_type
   use dda_kinematics, only: kinetic_energy
   use dda_ordered_sums, only: pieces, first_of, last_of, most_pieces, parallel_from
   use dda_support, only: load_at
   implicit none
   private
   public :: start_energy_budget, update_geometric, update_step, update_state

contains

   !> Energies of the first state.
   subroutine start_energy_budget(energy, model, blocks, contacts, laws)
      type(energy_type), intent(out) :: energy
      type(model_type), intent(in) :: model
      type(blocks_type), intent(in) :: blocks
      type(contacts_type), intent(in) :: contacts
      type(laws_type), intent(in) :: laws

      energy%kinetic = kinetic_energy(blocks)
      energy%strain = strain_energy(blocks)
      energy%contact = contact_energy(contacts, laws)
      energy%support = support_energy(model, blocks, 0.0_wp)
      energy%initial = energy%kinetic + energy%strain + energy%contact + energy%support
   end subroutine start_energy_budget

   !> The exact geometry at the start of a step stores other spring energies than the linear one at
   !> the end of the step before.
   subroutine update_geometric(energy, model, blocks, contacts, laws, time)
      type(energy_type), intent(inout) :: energy
      type(model_type), intent(in) :: model
      type(blocks_type), intent(in) :: blocks
      type(contacts_type), intent(in) :: contacts
      type(laws_type), intent(in) :: laws
      real(wp), intent(in) :: time
      real(wp) :: contact, support

      contact = contact_energy(contacts, laws)
      support = support_energy(model, blocks, time)
      energy%geometric = energy%geometric + (contact - energy%contact) + (support - energy%support)
      energy%contact = contact
      energy%support = support
   end subroutine update_geometric

   !> Losses and work of the converged step, before its d is added to the coordinates.
   subroutine update_step(energy, model, blocks, contacts, laws, d, time, time_step)
      type(energy_type), intent(inout) :: energy
      type(model_type), intent(in) :: model
      type(blocks_type), intent(in) :: blocks
      type(contacts_type), intent(in) :: contacts
      type(laws_type), intent(in) :: laws
      real(wp), intent(in) :: d(:,:)
      real(wp), intent(in) :: time        !< end of the step
      real(wp), intent(in) :: time_step

      call update_contacts(energy, contacts, laws)
      call update_blocks(energy, model, blocks, d, time)
      call book_supports(energy, model, blocks, d, time, time_step)
      call book_loads(energy, model, blocks, d, time)
   end subroutine update_step

   !> Loss by the scheme in the strains, work of gravity and of the base acceleration.
   subroutine update_blocks(energy, model, blocks, d, time)
      type(energy_type), intent(inout) :: energy
      type(model_type), intent(in) :: model
      type(blocks_type), intent(in) :: blocks
      real(wp), intent(in) :: d(:,:), time
      real(wp) :: part(3, most_pieces), total(3), shaking(2)
      integer :: p

      if (blocks%n < parallel_from) then
         total = budget_of_blocks(blocks, d, 1, blocks%n)
      else
         !$omp parallel do schedule(static)
         do p = 1, pieces(blocks%n)
            part(:, p) = budget_of_blocks(blocks, d, first_of(p, blocks%n), last_of(p, blocks%n))
         end do
         total = sum(part(:, :pieces(blocks%n)), 2)
      end if
      shaking = base_force(model, time) - model%control%gravity
      energy%algorithmic = energy%algorithmic + 0.5_wp*total(1)
      energy%gravity = energy%gravity - dot_product(model%control%gravity, total(2:3))
      energy%input = energy%input + dot_product(shaking, total(2:3))
   end subroutine update_blocks

   !> Σ εᵀDε and Σ m d of some blocks.
   pure function budget_of_blocks(blocks, d, first, last) result(books)
      type(blocks_type), intent(in) :: blocks
      real(wp), intent(in) :: d(:,:)
      integer, intent(in) :: first, last
      real(wp) :: books(3)
      integer :: b

      books = 0.0_wp
      do b = first, last
         books(1) = books(1) + strain_form(blocks%stiffness(:, :, b), d(4:6, b))
         books(2:3) = books(2:3) + blocks%mass(b)*d(1:2, b)
      end do
   end function budget_of_blocks

   !> εᵀDε
   pure real(wp) function strain_form(stiffness, strain)
      real(wp), intent(in) :: stiffness(3, 3), strain(3)

      strain_form = dot_product(strain, stiffness(:, 1)*strain(1) + stiffness(:, 2)*strain(2) &
         + stiffness(:, 3)*strain(3))
   end function strain_form

   !> Energies that follow from the new state of the blocks.
   subroutine update_state(energy, blocks)
      type(energy_type), intent(inout) :: energy
      type(blocks_type), intent(in) :: blocks

      energy%kinetic = kinetic_energy(blocks)
      energy%strain = strain_energy(blocks)
   end subroutine update_state

   !> Stored energy at the end of the step and losses of all contacts.
   subroutine update_contacts(energy, contacts, laws)
      type(energy_type), intent(inout) :: energy
      type(contacts_type), intent(in) :: contacts
      type(laws_type), intent(in) :: laws
      real(wp) :: part(4, most_pieces), total(4)
      integer :: p

      if (contacts%n < parallel_from) then
         total = budget_of_contacts(contacts, laws, 1, contacts%n)
      else
         !$omp parallel do schedule(static)
         do p = 1, pieces(contacts%n)
            part(:, p) = budget_of_contacts(contacts, laws, first_of(p, contacts%n), &
               last_of(p, contacts%n))
         end do
         total = sum(part(:, :pieces(contacts%n)), 2)
      end if
      energy%contact = total(1)
      energy%friction = energy%friction + total(2)
      energy%fracture = energy%fracture + total(3)
      energy%algorithmic = energy%algorithmic + total(4)
   end subroutine update_contacts

   !> Stored energy, and losses by slip, by fracture and by the scheme, of some contacts.
   pure function budget_of_contacts(contacts, laws, first, last) result(books)
      type(contacts_type), intent(in) :: contacts
      type(laws_type), intent(in) :: laws
      integer, intent(in) :: first, last
      real(wp) :: books(4)
      integer :: c

      books = 0.0_wp
      do c = first, last
         call update_contact(books, contacts, laws, c)
      end do
   end function budget_of_contacts

   !> The same of one contact.
   pure subroutine update_contact(books, contacts, laws, c)
      real(wp), intent(inout) :: books(4)
      type(contacts_type), intent(in) :: contacts
      type(laws_type), intent(in) :: laws
      integer, intent(in) :: c
      real(wp) :: before, after, work, stretched, slipped, loss

      before = stored(laws, contacts%gap(c), contacts%was_closed(c), contacts%was_bonded(c), &
         contacts%stretch(c))
      stretched = contacts%shear_force(c)/laws%shear_stiffness
      after = stored(laws, contacts%new_gap(c), contacts%normal_force(c) /= 0.0_wp, &
         contacts%bonded(c), stretched)
      work = contacts%normal_force(c)*(contacts%new_gap(c) - contacts%gap(c)) &
         - contacts%shear_force(c)*contacts%slip(c)
      slipped = contacts%shear_force(c)*(contacts%slip(c) - (stretched - contacts%stretch(c)))
      loss = before - after - work - slipped
      books(1) = books(1) + after
      books(2) = books(2) + slipped
      if (contacts%was_bonded(c) .and. .not. contacts%bonded(c)) then
         books(3) = books(3) + loss
      else
         books(4) = books(4) + loss
      end if
   end subroutine update_contact

   !> Spring energy of a contact at a gap and a shear stretch.  With augmented Lagrangian the normal
   !> force is that of a rigid contact, which stores nothing.
   pure real(wp) function stored(laws, gap, closed, bonded, stretch)
      type(laws_type), intent(in) :: laws
      real(wp), intent(in) :: gap, stretch
      logical, intent(in) :: closed, bonded

      stored = 0.5_wp*laws%shear_stiffness*stretch**2
      if (bonded .or. (closed .and. .not. laws%augmented)) &
         stored = stored + 0.5_wp*laws%normal_stiffness*gap**2
   end function stored

   real(wp) function contact_energy(contacts, laws)
      type(contacts_type), intent(in) :: contacts
      type(laws_type), intent(in) :: laws
      real(wp) :: part(most_pieces)
      integer :: p

      if (contacts%n < parallel_from) then
         contact_energy = stored_in(contacts, laws, 1, contacts%n)
         return
      end if
      !$omp parallel do schedule(static)
      do p = 1, pieces(contacts%n)
         part(p) = stored_in(contacts, laws, first_of(p, contacts%n), last_of(p, contacts%n))
      end do
      contact_energy = sum(part(:pieces(contacts%n)))
   end function contact_energy

   !> The same of some contacts.
   pure real(wp) function stored_in(contacts, laws, first, last)
      type(contacts_type), intent(in) :: contacts
      type(laws_type), intent(in) :: laws
      integer, intent(in) :: first, last
      integer :: c

      stored_in = 0.0_wp
      do c = first, last
         stored_in = stored_in + stored(laws, contacts%gap(c), contacts%was_closed(c), &
            contacts%bonded(c), contacts%stretch(c))
      end do
   end function stored_in

   !> ½ A εᵀDε + A σ₀ᵀε of all blocks.
   real(wp) function strain_energy(blocks)
      type(blocks_type), intent(in) :: blocks
      real(wp) :: part(most_pieces)
      integer :: p

      if (blocks%n < parallel_from) then
         strain_energy = strain_energy_of(blocks, 1, blocks%n)
         return
      end if
      !$omp parallel do schedule(static)
      do p = 1, pieces(blocks%n)
         part(p) = strain_energy_of(blocks, first_of(p, blocks%n), last_of(p, blocks%n))
      end do
      strain_energy = sum(part(:pieces(blocks%n)))
   end function strain_energy

   !> The same of some blocks.
   pure real(wp) function strain_energy_of(blocks, first, last) result(energy)
      type(blocks_type), intent(in) :: blocks
      integer, intent(in) :: first, last
      integer :: b

      energy = 0.0_wp
      do b = first, last
         energy = energy + 0.5_wp*strain_form(blocks%stiffness(:, :, b), blocks%position(4:6, b)) &
            + blocks%area(b)*dot_product(blocks%initial_stress(:, b), blocks%position(4:6, b))
      end do
   end function strain_energy_of

   real(wp) function support_energy(model, blocks, time) result(sum)
      type(model_type), intent(in) :: model
      type(blocks_type), intent(in) :: blocks
      real(wp), intent(in) :: time
      real(wp) :: away(2)
      integer :: i

      sum = 0.0_wp
      do i = 1, size(model%fixed_points)
         associate (point => model%fixed_points(i))
            away = place_of(blocks, point%block, point%reference) - support_target(model, i, time)
            sum = sum + 0.5_wp*sum_of_squares(merge(away, 0.0_wp, point%held))
         end associate
      end do
      sum = sum*model%contact%fixed_point_ratio*model%contact%normal_stiffness
   end function support_energy

   pure real(wp) function sum_of_squares(list)
      real(wp), intent(in) :: list(2)

      sum_of_squares = sum(list**2)
   end function sum_of_squares

   !> Work of moved supports, energy of their springs at the end of the step, loss by the scheme.
   subroutine book_supports(energy, model, blocks, d, time, time_step)
      type(energy_type), intent(inout) :: energy
      type(model_type), intent(in) :: model
      type(blocks_type), intent(in) :: blocks
      real(wp), intent(in) :: d(:,:), time, time_step
      real(wp) :: stiffness, before(2), after(2), moved(2), t(2, 6)
      integer :: i

      stiffness = model%contact%fixed_point_ratio*model%contact%normal_stiffness
      energy%support = 0.0_wp
      do i = 1, size(model%fixed_points)
         associate (point => model%fixed_points(i))
            before = place_of(blocks, point%block, point%reference) - support_target(model, i, &
               time - time_step)
            moved = support_target(model, i, time) - support_target(model, i, time - time_step)
            t = shape_matrix(blocks, point%block, point%reference)
            after = before - moved + matmul(t, d(:, point%block))
            before = merge(before, 0.0_wp, point%held)
            after = merge(after, 0.0_wp, point%held)
         end associate
         energy%support = energy%support + 0.5_wp*stiffness*sum(after**2)
         energy%algorithmic = energy%algorithmic + 0.5_wp*stiffness*sum((after - before)**2)
         energy%input = energy%input - stiffness*dot_product(after, moved)
      end do
   end subroutine book_supports

   subroutine book_loads(energy, model, blocks, d, time)
      type(energy_type), intent(inout) :: energy
      type(model_type), intent(in) :: model
      type(blocks_type), intent(in) :: blocks
      real(wp), intent(in) :: d(:,:), time
      integer :: i, b

      do i = 1, size(model%loads)
         b = model%loads(i)%block
         energy%input = energy%input + dot_product(load_at(model%loads(i), time), &
            matmul(shape_matrix(blocks, b, model%loads(i)%reference), d(:, b)))
      end do
   end subroutine book_loads

end module dda_energy_budget
