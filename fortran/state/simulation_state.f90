!> All that a run has changed since its start: written to an archive, and put back into a run just started.
module dda_simulation_state
   use dda_archive, only: archive_type, carry, carry_label, carry_number
   use dda_assembly, only: set_matrix_pattern
   use dda_blocks, only: blocks_type
   use dda_contact_state, only: carry_contacts, carry_neighbours
   use dda_energy, only: energy_type
   use dda_neighbours, only: find_corners
   use dda_open_close, only: iteration_type
   use dda_simulation, only: simulation_type
   use dda_solver, only: analyse
   use dda_solver_state, only: carry_solver
   implicit none
   private
   public :: carry_simulation

contains

   !> When the archive is read, the simulation must be one of the same model, and comes to stand where the other stood.
   subroutine carry_simulation(archive, simulation)
      type(archive_type), intent(inout) :: archive
      type(simulation_type), intent(inout) :: simulation

      call carry_clock(archive, simulation)
      call carry_counters(archive, simulation)
      call carry_energy(archive, simulation%energy)
      call carry_blocks(archive, simulation%blocks)
      call carry_neighbours(archive, simulation%neighbours, simulation%blocks)
      call carry_contacts(archive, simulation%contacts(simulation%now), simulation%blocks, simulation%neighbours, &
         size(simulation%model%joints))
      call carry_iteration(archive, simulation%iteration, simulation%contacts(simulation%now)%n)
      if (archive%reading .and. .not. allocated(archive%trouble)) then
         call find_corners(simulation%neighbours, simulation%blocks)
         call set_matrix_pattern(simulation%system, simulation%blocks%n, simulation%neighbours)
         call analyse(simulation%solver, simulation%system%matrix)
      end if
      call carry_solver(archive, simulation%solver, simulation%system%matrix)
      call carry_label(archive, 'end')
   end subroutine carry_simulation

   subroutine carry_clock(archive, simulation)
      type(archive_type), intent(inout) :: archive
      type(simulation_type), intent(inout) :: simulation

      call carry_label(archive, 'clock')
      call carry(archive, simulation%step)
      call carry(archive, simulation%time)
      call carry(archive, simulation%time_step)
      call carry(archive, simulation%last_time_step)
      call carry(archive, simulation%speed)
      call carry(archive, simulation%path)
      call carry_number(archive, simulation%now, 1, size(simulation%contacts))
   end subroutine carry_clock

   subroutine carry_counters(archive, simulation)
      type(archive_type), intent(inout) :: archive
      type(simulation_type), intent(inout) :: simulation

      call carry_label(archive, 'counters')
      associate (counters => simulation%counters)
         call carry(archive, counters%iterations)
         call carry(archive, counters%searches)
         call carry(archive, counters%repeated)
         call carry(archive, counters%too_far)
         call carry(archive, counters%broken)
         call carry(archive, counters%most_iterations)
      end associate
   end subroutine carry_counters

   subroutine carry_energy(archive, energy)
      type(archive_type), intent(inout) :: archive
      type(energy_type), intent(inout) :: energy

      call carry_label(archive, 'energy')
      call carry(archive, energy%kinetic)
      call carry(archive, energy%strain)
      call carry(archive, energy%contact)
      call carry(archive, energy%support)
      call carry(archive, energy%gravity)
      call carry(archive, energy%input)
      call carry(archive, energy%friction)
      call carry(archive, energy%fracture)
      call carry(archive, energy%algorithmic)
      call carry(archive, energy%kinetic_damping)
      call carry(archive, energy%geometric)
      call carry(archive, energy%initial)
   end subroutine carry_energy

   !> Outcome of the last step's iteration, whose tolerance the next one begins with; settings are the input's.
   subroutine carry_iteration(archive, iteration, contacts)
      type(archive_type), intent(inout) :: archive
      type(iteration_type), intent(inout) :: iteration
      integer, intent(in) :: contacts  !< contacts in the list

      call carry_label(archive, 'iteration')
      call carry(archive, iteration%iterations)
      call carry(archive, iteration%changes)
      call carry(archive, iteration%broken)
      call carry(archive, iteration%residual)
      call carry(archive, iteration%tolerance)
      call carry(archive, iteration%short_ways)
      call carry_number(archive, iteration%worst, 0, contacts)
      call carry(archive, iteration%kept)
      call carry(archive, iteration%reduction)
   end subroutine carry_iteration

   !> The state, and what follows from it: the first vertices are the input's own and not recomputed.
   subroutine carry_blocks(archive, blocks)
      type(archive_type), intent(inout) :: archive
      type(blocks_type), intent(inout) :: blocks

      call carry_label(archive, 'blocks')
      call carry(archive, blocks%position)
      call carry(archive, blocks%velocity)
      call carry(archive, blocks%acceleration)
      call carry(archive, blocks%axes)
      call carry(archive, blocks%gradient)
      call carry(archive, blocks%vertex)
      call carry(archive, blocks%along)
      call carry(archive, blocks%length)
      call carry(archive, blocks%along)
      call carry(archive, blocks%length)
   end subroutine carry_blocks

end module dda_simulation_state
