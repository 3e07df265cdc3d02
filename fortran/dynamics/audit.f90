!> Books of a step: where its energy went (see dda_energy).
module dda_audit
   use dda_kinds, only: wp
   use dda_assembly, only: support_target, base_force
   use dda_blocks, only: blocks_type, place_of, shape_matrix
   use dda_contact, only: contacts_type
   use dda_energy, only: energy_type
   use dda_friction, only: laws_type
   use dda_model, only: model_type
   use dda_newmark, only: kinetic_energy
   use dda_support, only: load_at
   implicit none
   private
   public :: open_books, book_geometry, book_step, book_motion

contains

   !> Energies of the first state.
   subroutine open_books(energy, model, blocks, contacts, laws)
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
   end subroutine open_books

   !> The exact geometry at the start of a step stores other spring energies than the linear one at
   !> the end of the step before.
   subroutine book_geometry(energy, model, blocks, contacts, laws, time)
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
   end subroutine book_geometry

   !> Losses and work of the converged step, before its d is added to the coordinates.
   subroutine book_step(energy, model, blocks, contacts, laws, d, time, time_step)
      type(energy_type), intent(inout) :: energy
      type(model_type), intent(in) :: model
      type(blocks_type), intent(in) :: blocks
      type(contacts_type), intent(in) :: contacts
      type(laws_type), intent(in) :: laws
      real(wp), intent(in) :: d(:,:)
      real(wp), intent(in) :: time        !< end of the step
      real(wp), intent(in) :: time_step
      integer :: c, b

      energy%contact = 0.0_wp
      do c = 1, contacts%n
         call book_contact(energy, contacts, laws, c)
      end do
      call book_supports(energy, model, blocks, d, time, time_step)
      call book_loads(energy, model, blocks, d, time)
      do b = 1, blocks%n
         associate (strain => d(4:6, b), force => blocks%mass(b)*base_force(model, time))
            energy%algorithmic = energy%algorithmic &
               + 0.5_wp*dot_product(strain, matmul(blocks%stiffness(:, :, b), strain))
            energy%gravity = energy%gravity - blocks%mass(b)*dot_product(model%control%gravity, d(1:2, b))
            energy%input = energy%input &
               + dot_product(force - blocks%mass(b)*model%control%gravity, d(1:2, b))
         end associate
      end do
   end subroutine book_step

   !> Energies that follow from the new state of the blocks.
   subroutine book_motion(energy, blocks)
      type(energy_type), intent(inout) :: energy
      type(blocks_type), intent(in) :: blocks

      energy%kinetic = kinetic_energy(blocks)
      energy%strain = strain_energy(blocks)
   end subroutine book_motion

   !> Stored energy at the end of the step and losses of one contact.
   pure subroutine book_contact(energy, contacts, laws, c)
      type(energy_type), intent(inout) :: energy
      type(contacts_type), intent(in) :: contacts
      type(laws_type), intent(in) :: laws
      integer, intent(in) :: c
      real(wp) :: before, after, work, stretched, slipped, loss

      before = stored(laws, contacts%gap(c), contacts%was_closed(c), contacts%was_bonded(c), contacts%stretch(c))
      stretched = contacts%shear_force(c)/laws%shear_stiffness
      after = stored(laws, contacts%new_gap(c), contacts%normal_force(c) /= 0.0_wp, contacts%bonded(c), stretched)
      work = contacts%normal_force(c)*(contacts%new_gap(c) - contacts%gap(c)) &
         - contacts%shear_force(c)*contacts%slip(c)
      slipped = contacts%shear_force(c)*(contacts%slip(c) - (stretched - contacts%stretch(c)))
      loss = before - after - work - slipped
      energy%contact = energy%contact + after
      energy%friction = energy%friction + slipped
      if (contacts%was_bonded(c) .and. .not. contacts%bonded(c)) then
         energy%fracture = energy%fracture + loss
      else
         energy%algorithmic = energy%algorithmic + loss
      end if
   end subroutine book_contact

   !> Spring energy of a contact at a gap and a shear stretch.  With augmented Lagrangian the normal force is
   !> that of a rigid contact, which stores nothing.
   pure real(wp) function stored(laws, gap, closed, bonded, stretch)
      type(laws_type), intent(in) :: laws
      real(wp), intent(in) :: gap, stretch
      logical, intent(in) :: closed, bonded

      stored = 0.5_wp*laws%shear_stiffness*stretch**2
      if (bonded .or. (closed .and. .not. laws%augmented)) stored = stored + 0.5_wp*laws%normal_stiffness*gap**2
   end function stored

   pure real(wp) function contact_energy(contacts, laws) result(sum)
      type(contacts_type), intent(in) :: contacts
      type(laws_type), intent(in) :: laws
      integer :: c

      sum = 0.0_wp
      do c = 1, contacts%n
         sum = sum + stored(laws, contacts%gap(c), contacts%was_closed(c), contacts%bonded(c), contacts%stretch(c))
      end do
   end function contact_energy

   !> ½ A εᵀDε + A σ₀ᵀε of all blocks.
   pure real(wp) function strain_energy(blocks) result(sum)
      type(blocks_type), intent(in) :: blocks
      integer :: b

      sum = 0.0_wp
      do b = 1, blocks%n
         associate (strain => blocks%position(4:6, b))
            sum = sum + 0.5_wp*dot_product(strain, matmul(blocks%stiffness(:, :, b), strain)) &
               + blocks%area(b)*dot_product(blocks%initial_stress(:, b), strain)
         end associate
      end do
   end function strain_energy

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
            sum = sum + 0.5_wp*sum_of_squares(pack(away, point%held))
         end associate
      end do
      sum = sum*model%contact%fixed_point_ratio*model%contact%normal_stiffness
   end function support_energy

   pure real(wp) function sum_of_squares(list)
      real(wp), intent(in) :: list(:)

      sum_of_squares = sum(list**2)
   end function sum_of_squares

   !> Work of moved supports, energy of their springs at the end of the step, loss by the scheme.
   subroutine book_supports(energy, model, blocks, d, time, time_step)
      type(energy_type), intent(inout) :: energy
      type(model_type), intent(in) :: model
      type(blocks_type), intent(in) :: blocks
      real(wp), intent(in) :: d(:,:), time, time_step
      real(wp) :: stiffness, before(2), after(2), moved(2)
      integer :: i

      stiffness = model%contact%fixed_point_ratio*model%contact%normal_stiffness
      energy%support = 0.0_wp
      do i = 1, size(model%fixed_points)
         associate (point => model%fixed_points(i))
            before = place_of(blocks, point%block, point%reference) - support_target(model, i, time - time_step)
            moved = support_target(model, i, time) - support_target(model, i, time - time_step)
            after = before - moved + matmul(shape_matrix(blocks, point%block, point%reference), d(:, point%block))
            where (.not. point%held)
               before = 0.0_wp
               after = 0.0_wp
            end where
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

end module dda_audit
