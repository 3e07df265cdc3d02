! SPDX-License-Identifier: GPL-3.0-or-later
!> The sums of the energy budget and the names of its terms.
module test_energy
   use dda_kinds, only: wp
   use dda_energy, only: energy_residual, energy_balance, energy_terms, energy_type, &
      energy_values, total_energy, turnover
   use testing, only: case, check, check_close
   implicit none

contains

   !> Each term is a power of two: a sum shows which terms are in it.
   subroutine sums_and_names()
      type(energy_type) :: energy
      real(wp) :: values(size(energy_terms))
      integer :: i

      energy%value = [(2.0_wp**i, i=0, size(energy_terms) - 1)]
      energy%value(energy_balance) = 0.0_wp
      call case('sums')
      call check_close(total_energy(energy), of('kinetic') + of('strain') + of('contact') &
         + of('support') + of('gravity') + of('welded') + of('law') + of('water'), 'total')
      call check_close(energy_residual(energy), total_energy(energy) + of('friction') &
         + of('fracture') + of('algorithmic') + of('kinetic_damping') + of('damping') &
         + of('static') + of('removed') + of('material_damping') + of('yield') + of('impact') &
         + of('plastic') + of('flow') - of('changed') - of('breaking') &
         - of('zeroed') - of('input') - of('dilation') - of('length') - of('geometric') &
         - of('initial'), 'balance')
      call check_close(turnover(energy), sum(energy%value) - of('geometric'), 'turnover')
      call case('names and values')
      values = energy_values(energy)
      call check_close(values(energy_balance), energy_residual(energy), 'balance')
      call check(all(values(:energy_balance - 1) == energy%value(:energy_balance - 1)), 'the rest')
      call check(all([(count(energy_terms%name == energy_terms(i)%name) == 1, &
         i=1, size(energy_terms))]), 'no name twice')

   contains

      !> Value of the term with a name.
      real(wp) function of(name)
         character(len=*), intent(in) :: name

         of = energy%value(findloc(energy_terms%name == name, .true., 1))
      end function of
   end subroutine sums_and_names

end module test_energy
