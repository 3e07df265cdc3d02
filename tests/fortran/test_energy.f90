!> The sums of the audit and the order of its terms.
module test_energy
   use dda_kinds, only: wp
   use dda_energy, only: balance, energy_names, energy_terms, energy_type, energy_values, &
      total_energy
   use testing, only: case, check, check_close
   implicit none
   private
   public :: energy_suite

contains

   !> Each term is a power of two: a sum shows which terms are in it.
   subroutine energy_suite()
      type(energy_type) :: energy
      character(len=16) :: names(energy_terms)
      real(wp) :: values(energy_terms)

      energy = energy_type(kinetic=1, strain=2, contact=4, support=8, gravity=16, input=32, &
         friction=64, fracture=128, algorithmic=256, kinetic_damping=512, geometric=1024, &
         initial=2048)
      call case('sums')
      call check_close(total_energy(energy), 31.0_wp, 'total')
      call check_close(balance(energy), 31.0_wp + 64 + 128 + 256 + 512 - 32 - 1024 - 2048, &
         'balance')
      call case('names and values')
      names = energy_names()
      values = energy_values(energy)
      call check_close(values(findloc(names, 'kinetic', 1)), 1.0_wp, 'kinetic')
      call check_close(values(findloc(names, 'strain', 1)), 2.0_wp, 'strain')
      call check_close(values(findloc(names, 'contact', 1)), 4.0_wp, 'contact')
      call check_close(values(findloc(names, 'support', 1)), 8.0_wp, 'support')
      call check_close(values(findloc(names, 'gravity', 1)), 16.0_wp, 'gravity')
      call check_close(values(findloc(names, 'input', 1)), 32.0_wp, 'input')
      call check_close(values(findloc(names, 'friction', 1)), 64.0_wp, 'friction')
      call check_close(values(findloc(names, 'fracture', 1)), 128.0_wp, 'fracture')
      call check_close(values(findloc(names, 'algorithmic', 1)), 256.0_wp, 'algorithmic')
      call check_close(values(findloc(names, 'kinetic_damping', 1)), 512.0_wp, 'kinetic damping')
      call check_close(values(findloc(names, 'geometric', 1)), 1024.0_wp, 'geometric')
      call check_close(values(findloc(names, 'initial', 1)), 2048.0_wp, 'initial')
      call check_close(values(findloc(names, 'balance', 1)), balance(energy), 'balance')
   end subroutine energy_suite

end module test_energy
