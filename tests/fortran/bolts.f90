! SPDX-License-Identifier: GPL-3.0-or-later
!> A kind of elements that is not part of the engine, which uses only its abstract type: bolts,
!> each a spring and a dashpot on d/Δt along a direction between points of two blocks.
!>
!> The suites use it to show that an element is one file: assembly, energy budget, modes and
!> transfer function use its procedures.
module bolts
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type, position_of, shape_matrix
   use dda_element, only: element_type
   use dda_elements, only: register
   use dda_energy, only: energy_type, add_energy, energy_algorithmic, energy_damping, energy_support
   use dda_energy_budget, only: start_energy_budget
   use dda_linear_terms, only: add_term, at_theta, at_end, linear_term_type, linear_terms_type, &
      mean_dashpot
   use dda_scheme, only: step_type
   use dda_simulation, only: next_step, simulation_type
   implicit none
   private
   public :: bolt_type, bolts_type, put_bolts

   !> One bolt.
   type :: bolt_type
      integer :: block(2) = [1, 2]
      real(wp) :: reference(2, 2) = 0.0_wp         !< offsets ρ of its ends, m
      real(wp) :: along(2) = [1.0_wp, 0.0_wp]      !< unit vector
      real(wp) :: stiffness = 0.0_wp               !< N/m per metre of thickness
      real(wp) :: viscosity = 0.0_wp               !< N s/m per metre of thickness
      real(wp) :: length = 0.0_wp                  !< without force, from end 2 to end 1, m
      integer :: instant = at_theta                !< or at_end: when the spring acts
   end type bolt_type

   !> All bolts of a model.
   type, extends(element_type) :: bolts_type
      type(bolt_type), allocatable :: bolt(:)
   contains
      procedure :: add_linear_terms
      procedure :: add_force
      procedure :: add_stored_energy
      procedure :: add_to_budget
   end type bolts_type

contains

   !> Give a started simulation bolts without force in the present state; its next step searches
   !> for neighbours, so that the pattern of the matrix follows.
   subroutine put_bolts(simulation, list)
      type(simulation_type), intent(inout) :: simulation
      type(bolt_type), intent(in) :: list(:)
      type(bolts_type) :: element
      integer :: i

      element%bolt = list
      do i = 1, size(list)
         element%bolt(i)%length = distance(list(i), simulation%blocks)
      end do
      call register(simulation%elements, element)
      simulation%neighbours%reach = 0.0_wp
      call start_energy_budget(simulation%energy, simulation%blocks, &
         simulation%contacts(simulation%now), simulation%laws, simulation%elements, &
         next_step(simulation))
   end subroutine put_bolts

   !> From end 2 to end 1, m.
   pure real(wp) function distance(bolt, blocks)
      type(bolt_type), intent(in) :: bolt
      type(blocks_type), intent(in) :: blocks

      distance = dot_product(bolt%along, position_of(blocks, bolt%block(1), bolt%reference(:, 1)) &
         - position_of(blocks, bolt%block(2), bolt%reference(:, 2)))
   end function distance

   !> Row of end `side`: displacement along the bolt.
   pure function row_of(bolt, blocks, side) result(row)
      type(bolt_type), intent(in) :: bolt
      type(blocks_type), intent(in) :: blocks
      integer, intent(in) :: side
      real(wp) :: row(6)

      row = matmul(bolt%along, shape_matrix(blocks, bolt%block(side), bolt%reference(:, side)))
   end function row_of

   subroutine add_linear_terms(self, blocks, step, terms)
      class(bolts_type), intent(in) :: self
      type(blocks_type), intent(in) :: blocks
      type(step_type), intent(in) :: step
      type(linear_terms_type), intent(inout) :: terms
      type(linear_term_type) :: term
      integer :: i

      do i = 1, size(self%bolt)
         term%source = i
         term%block_a = self%bolt(i)%block(1)
         term%block_b = self%bolt(i)%block(2)
         term%row_a = row_of(self%bolt(i), blocks, 1)
         term%row_b = row_of(self%bolt(i), blocks, 2)
         term%instant = self%bolt(i)%instant
         term%coefficient = self%bolt(i)%stiffness
         call add_term(terms, term)
         term%instant = mean_dashpot
         term%coefficient = self%bolt(i)%viscosity
         call add_term(terms, term)
      end do
   end subroutine add_linear_terms

   !> −k s at the start of the step.
   subroutine add_force(self, blocks, step, load)
      class(bolts_type), intent(in) :: self
      type(blocks_type), intent(in) :: blocks
      type(step_type), intent(in) :: step
      real(wp), intent(inout) :: load(:,:)
      real(wp) :: force
      integer :: i

      do i = 1, size(self%bolt)
         force = -self%bolt(i)%stiffness*(distance(self%bolt(i), blocks) - self%bolt(i)%length)
         associate (a => self%bolt(i)%block(1), b => self%bolt(i)%block(2))
            load(:, a) = load(:, a) + force*row_of(self%bolt(i), blocks, 1)
            load(:, b) = load(:, b) - force*row_of(self%bolt(i), blocks, 2)
         end associate
      end do
   end subroutine add_force

   subroutine add_stored_energy(self, blocks, step, energy)
      class(bolts_type), intent(in) :: self
      type(blocks_type), intent(in) :: blocks
      type(step_type), intent(in) :: step
      type(energy_type), intent(inout) :: energy
      integer :: i

      do i = 1, size(self%bolt)
         call add_energy(energy, energy_support, 0.5_wp*self%bolt(i)%stiffness &
            *(distance(self%bolt(i), blocks) - self%bolt(i)%length)**2)
      end do
   end subroutine add_stored_energy

   !> ½ k s₁², (θ − ½) k Δs² (½ k Δs² at the end of the step) and c Δs²/Δt.
   subroutine add_to_budget(self, blocks, step, d, energy)
      class(bolts_type), intent(in) :: self
      type(blocks_type), intent(in) :: blocks
      type(step_type), intent(in) :: step
      real(wp), intent(in) :: d(:,:)
      type(energy_type), intent(inout) :: energy
      real(wp) :: stretch, change, theta
      integer :: i

      do i = 1, size(self%bolt)
         associate (bolt => self%bolt(i))
            theta = merge(1.0_wp, step%scheme%theta, bolt%instant == at_end)
            change = dot_product(row_of(bolt, blocks, 1), d(:, bolt%block(1))) &
               - dot_product(row_of(bolt, blocks, 2), d(:, bolt%block(2)))
            stretch = distance(bolt, blocks) - bolt%length
            call add_energy(energy, energy_support, 0.5_wp*bolt%stiffness*(stretch + change)**2)
            call add_energy(energy, energy_algorithmic, (theta - 0.5_wp)*bolt%stiffness*change**2)
            call add_energy(energy, energy_damping, bolt%viscosity*change**2/step%time_step)
         end associate
      end do
   end subroutine add_to_budget

end module bolts
