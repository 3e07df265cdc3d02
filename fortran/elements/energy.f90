! SPDX-License-Identifier: GPL-3.0-or-later
!> Energy budget: each energy of a run belongs to a named term; the rest is unexplained.
!>
!> ΔT = d·F − (χ − ½) ΔvᵀMΔv is exact in a step (`dda_scheme`), so the numerical loss
!> in a force with a convex potential V at the end of the step is V₀ − V₁ − ∇V₁·(x₀ − x₁) ≥ 0.  The
!> geometric energy is the spring energy in exact geometry at the start of the next step minus the
!> spring energy in the linearised geometry of this step.
!>
!> Lines of `schema.txt` in `output` give the names and roles of the terms.
module dda_energy
   use dda_kinds, only: wp
   use dda_output_schema, only: energy_terms, is_stored, is_gain, is_loss, energy_kinetic, &
      energy_strain, energy_contact, energy_support, energy_gravity, energy_initial, energy_input, &
      energy_geometric, energy_friction, energy_fracture, energy_algorithmic, &
      energy_kinetic_damping, energy_damping, energy_static, energy_removed, energy_changed, &
      energy_zeroed, energy_material_damping, energy_dilation, energy_length, energy_yield, &
      energy_impact, energy_welded, energy_law, energy_plastic, energy_breaking, energy_water, &
      energy_flow, energy_balance
   implicit none
   private
   public :: energy_type, energy_terms, total_energy, energy_residual, turnover, add_energy, &
      energy_values, energy_kinetic, energy_strain, energy_contact, energy_support, &
      energy_gravity, energy_initial, energy_input, energy_geometric, energy_friction, &
      energy_fracture, energy_algorithmic, energy_kinetic_damping, energy_damping, &
      energy_static, energy_removed, energy_changed, energy_zeroed, energy_material_damping, &
      energy_dilation, energy_length, energy_yield, energy_impact, energy_welded, energy_law, &
      energy_plastic, energy_breaking, energy_water, energy_flow, energy_balance

   !> Value of each term except the balance, J per metre of thickness.
   type :: energy_type
      real(wp) :: value(size(energy_terms)) = 0.0_wp
   end type energy_type

contains

   !> Add an amount to a term.
   pure subroutine add_energy(energy, term, amount)
      type(energy_type), intent(inout) :: energy  !< energy budget, J per metre
      integer, intent(in) :: term   !< one of energy_kinetic …
      real(wp), intent(in) :: amount  !< J per metre of thickness

      energy%value(term) = energy%value(term) + amount
   end subroutine add_energy

   !> Return the kinetic plus potential energy, J per metre of thickness.
   pure real(wp) function total_energy(energy)
      type(energy_type), intent(in) :: energy  !< energy budget, J per metre

      total_energy = sum(energy%value, mask=energy_terms%role == is_stored)
   end function total_energy

   !> Return the residual, J per metre: total energy minus all terms that explain its change.
   !> It is due to rounding and to the tolerance of the open–close iteration.
   pure real(wp) function energy_residual(energy)  ! total
      type(energy_type), intent(in) :: energy  !< energy budget, J per metre
      integer :: i

      energy_residual = total_energy(energy)
      do i = 1, size(energy_terms)
         if (energy_terms(i)%role == is_gain) energy_residual = energy_residual - energy%value(i)
         if (energy_terms(i)%role == is_loss) energy_residual = energy_residual + energy%value(i)
      end do
   end function energy_residual

   !> Sum of all exchanged energies, J per metre of thickness.
   !> It is the reference value of `energy_residual` and of the geometric term.
   pure real(wp) function turnover(energy)
      type(energy_type), intent(in) :: energy  !< energy budget, J per metre

      turnover = sum(abs(energy%value)) - abs(energy%value(energy_geometric)) &
         - abs(energy%value(energy_balance))
   end function turnover

   !> Return the values of all terms in the order of `energy_terms`, with the balance.
   pure function energy_values(energy) result(values)
      type(energy_type), intent(in) :: energy  !< energy budget, J per metre
      real(wp) :: values(size(energy_terms))  !< J per metre of thickness

      values = energy%value
      values(energy_balance) = energy_residual(energy)
   end function energy_values

end module dda_energy
