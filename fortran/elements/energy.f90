! SPDX-License-Identifier: GPL-3.0-or-later
!> The energy budget: every joule of a run has a name, and `balance` is what is left over.
!>
!> ΔT = d·F − (χ − ½) ΔvᵀMΔv holds exactly in a step (`dda_scheme`), so the loss that the scheme
!> makes in a force with a convex potential V at the end of the step is V₀ − V₁ − ∇V₁·(x₀ − x₁) ≥ 0.
!> Energy that the exact geometry at the start of the next step adds to the linear one is booked as
!> geometric.
!>
!> A new term is a name and a line of `energy_terms`.
module dda_energy
   use dda_kinds, only: wp
   implicit none
   private
   public :: energy_type, energy_term_type, energy_terms, total_energy, balance, turnover, &
      add_energy
   public :: energy_values, energy_initial, energy_kinetic, energy_strain, energy_contact, &
      energy_support, energy_gravity, energy_input, energy_friction, energy_fracture, &
      energy_algorithmic, energy_kinetic_damping, energy_damping, energy_geometric, &
      energy_balance, energy_static, energy_removed, energy_changed, energy_zeroed, &
      energy_material, energy_dilation, energy_length, energy_yield, energy_impact, energy_welded, &
      energy_law, energy_plastic, energy_breaking

   enum, bind(c)  ! in the order of energy_terms
      enumerator :: energy_kinetic = 1, energy_strain, energy_contact, energy_support, &
         energy_gravity, energy_initial, energy_input, energy_geometric, energy_friction, &
         energy_fracture, energy_algorithmic, energy_kinetic_damping, energy_damping, &
         energy_static, energy_removed, energy_changed, energy_zeroed, energy_material, &
         energy_dilation, energy_length, energy_yield, energy_impact, energy_welded, &
         energy_law, energy_plastic, energy_breaking, energy_balance
   end enum

   integer, parameter :: is_stored = 1, is_gain = 2, is_loss = 3, is_remainder = 4

   !> A term: its name in the output, what it is, and how it enters the balance.
   type :: energy_term_type
      character(len=16) :: name
      character(len=64) :: meaning
      integer :: role
   end type energy_term_type

   !> All terms, J per metre of thickness; stored ones are present, the others summed over the
   !> steps.
   type(energy_term_type), parameter :: energy_terms(*) = [ &
      energy_term_type('kinetic', 'v·Mv/2', is_stored), &
      energy_term_type('strain', 'elastic energy of the blocks', is_stored), &
      energy_term_type('contact', 'springs of contacts', is_stored), &
      energy_term_type('support', 'springs and dashpots of supports and bolts', is_stored), &
      energy_term_type('gravity', '-m g·(x - x0)', is_stored), &
      energy_term_type('initial', 'total at the start', is_gain), &
      energy_term_type('input', 'work of loads, moved supports and base acceleration', is_gain), &
      energy_term_type('geometric', 'gain by the exact geometry between steps', is_gain), &
      energy_term_type('friction', 'loss by slip', is_loss), &
      energy_term_type('fracture', 'loss by broken bonds', is_loss), &
      energy_term_type('algorithmic', 'loss by the time integration', is_loss), &
      energy_term_type('kinetic_damping', 'loss by a dynamic factor below 1', is_loss), &
      energy_term_type('damping', 'loss in dashpots', is_loss), &
      energy_term_type('static', 'loss on the way to rest in later static stages', is_loss), &
      energy_term_type('removed', 'loss with removed blocks and supports', is_loss), &
      energy_term_type('changed', 'gain by changed materials and joints', is_gain), &
      energy_term_type('zeroed', 'gravity when displacements were set to zero', is_gain), &
      energy_term_type('material_damping', 'loss by damping of the materials', is_loss), &
      energy_term_type('dilation', 'work of normal forces given back by slip', is_gain), &
      energy_term_type('length', 'gain by changed tributary lengths', is_gain), &
      energy_term_type('yield', 'loss by yielding and rupture of bolts', is_loss), &
      energy_term_type('impact', 'loss in impacts of joints with a restitution', is_loss), &
      energy_term_type('welded', 'elastic energy of welded faces of bodies', is_stored), &
      energy_term_type('law', 'strain energy of material laws beyond elasticity', is_stored), &
      energy_term_type('plastic', 'loss by yielding of materials', is_loss), &
      energy_term_type('breaking', 'gain where welded faces break or come apart', is_gain), &
      energy_term_type('balance', 'what is left over', is_remainder)]

   !> Value of each term but the balance, J per metre of thickness.
   type :: energy_type
      real(wp) :: value(size(energy_terms)) = 0.0_wp
   end type energy_type

contains

   !> Add to a term.
   pure subroutine add_energy(energy, term, more)
      type(energy_type), intent(inout) :: energy  !< J per metre of thickness
      integer, intent(in) :: term   !< one of energy_kinetic …
      real(wp), intent(in) :: more  !< J per metre of thickness

      energy%value(term) = energy%value(term) + more
   end subroutine add_energy

   !> Kinetic plus potential energy, J per metre of thickness.
   pure real(wp) function total_energy(energy)
      type(energy_type), intent(in) :: energy  !< J per metre of thickness

      total_energy = sum(energy%value, mask=energy_terms%role == is_stored)
   end function total_energy

   !> Total less all that explains it, J per metre of thickness: rounding and the tolerance of the
   !> open–close iteration.
   pure real(wp) function balance(energy)
      type(energy_type), intent(in) :: energy  !< J per metre of thickness
      integer :: i

      balance = total_energy(energy)
      do i = 1, size(energy_terms)
         if (energy_terms(i)%role == is_gain) balance = balance - energy%value(i)
         if (energy_terms(i)%role == is_loss) balance = balance + energy%value(i)
      end do
   end function balance

   !> Gross energy exchanged, J per metre of thickness: the scale of `balance` and of the geometric
   !> term.
   pure real(wp) function turnover(energy)
      type(energy_type), intent(in) :: energy  !< J per metre of thickness

      turnover = sum(abs(energy%value)) - abs(energy%value(energy_geometric)) &
         - abs(energy%value(energy_balance))
   end function turnover

   !> Values in the order of `energy_terms`, with the balance.
   pure function energy_values(energy) result(values)
      type(energy_type), intent(in) :: energy  !< J per metre of thickness
      real(wp) :: values(size(energy_terms))  !< J per metre of thickness

      values = energy%value
      values(energy_balance) = balance(energy)
   end function energy_values

end module dda_energy
