!> The energy audit: every joule of a run has a name (`balance` is what is left over).
!>
!> The scheme gives ΔT = d·F(x₁) exactly, so each force contributes the loss V₀ − V₁ − ∇V₁·(x₀ − x₁)
!> ≥ 0 of its convex potential as algorithmic damping.  What the exact geometry at the start of the
!> next step adds to the linear one at the end of a step is booked as geometric.
module dda_energy
   use dda_kinds, only: wp
   implicit none
   private
   public :: energy_type, total_energy, balance, turnover, energy_names, energy_values, energy_terms

   integer, parameter :: energy_terms = 13

   !> Joule per metre of thickness.
   type :: energy_type
      ! Present
      real(wp) :: kinetic = 0.0_wp      !< ½ vᵀMv
      real(wp) :: strain = 0.0_wp       !< ½ A εᵀDε + A σ₀ᵀε
      real(wp) :: contact = 0.0_wp      !< springs of contacts
      real(wp) :: support = 0.0_wp      !< springs of fixed points
      real(wp) :: gravity = 0.0_wp      !< −m g·(x − x₀)
      ! Summed over the steps
      real(wp) :: input = 0.0_wp        !< work of loads, moved supports and base acceleration
      real(wp) :: friction = 0.0_wp     !< loss by slip
      real(wp) :: fracture = 0.0_wp     !< loss by broken bonds
      real(wp) :: algorithmic = 0.0_wp  !< loss by the scheme
      real(wp) :: kinetic_damping = 0.0_wp  !< loss by a dynamic factor below 1
      real(wp) :: geometric = 0.0_wp    !< gain by exact geometry between steps
      real(wp) :: initial = 0.0_wp      !< total at the start
   end type energy_type

contains

   !> Kinetic plus potential energy.
   pure real(wp) function total_energy(energy)
      type(energy_type), intent(in) :: energy

      total_energy = energy%kinetic + energy%strain + energy%contact + energy%support &
         + energy%gravity
   end function total_energy

   !> Total less all that explains it: rounding and the tolerance of the open–close iteration.
   pure real(wp) function balance(energy)
      type(energy_type), intent(in) :: energy

      balance = total_energy(energy) - energy%initial - energy%input - energy%geometric &
         + energy%friction + energy%fracture + energy%algorithmic + energy%kinetic_damping
   end function balance

   !> What has changed hands: the scale that `balance` and `geometric` are measured by.
   pure real(wp) function turnover(energy)
      type(energy_type), intent(in) :: energy

      turnover = energy%kinetic + abs(energy%strain) + energy%contact + energy%support &
         + abs(energy%gravity) + abs(energy%input) + abs(energy%initial) + energy%friction &
         + energy%fracture + energy%algorithmic + energy%kinetic_damping
   end function turnover

   !> Names of the terms, as in the output file.
   pure function energy_names() result(names)
      character(len=16) :: names(energy_terms)

      names = [character(len=16) :: 'kinetic', 'strain', 'contact', 'support', 'gravity', 'input', &
         'friction', 'fracture', 'algorithmic', 'kinetic_damping', 'geometric', 'initial', &
         'balance']
   end function energy_names

   !> Values in the order of `energy_names`.
   pure function energy_values(energy) result(values)
      type(energy_type), intent(in) :: energy
      real(wp) :: values(energy_terms)

      values = [energy%kinetic, energy%strain, energy%contact, energy%support, energy%gravity, &
         energy%input, energy%friction, energy%fracture, energy%algorithmic, &
         energy%kinetic_damping, energy%geometric, energy%initial, balance(energy)]
   end function energy_values

end module dda_energy
