! SPDX-License-Identifier: GPL-3.0-or-later
!> The line search minimises the energy, and retains a full step on which it does not rise.
module test_line_search
   use dda_kinds, only: wp
   use dda_system, only: system_type
   use dda_contact, only: contacts_type
   use dda_contact_evaluation, only: evaluate_contacts
   use dda_friction, only: laws_type
   use dda_line_search, only: descend
   use models, only: random, random_vector
   use systems, only: energy, gradient, random_system
   use testing, only: case, check
   implicit none

contains

   subroutine random_directions()
      integer :: i

      call case('too far downhill')
      do i = 1, 100
         call search(1 + modulo(i, 12), 10.0_wp**random(-3.0_wp, 0.0_wp))
      end do
      call case('a short way downhill')
      do i = 1, 20
         call keep(1 + modulo(i, 12))
      end do
   end subroutine random_directions

   !> From a random position down the gradient, by any length.
   subroutine search(count, length)
      integer, intent(in) :: count
      real(wp), intent(in) :: length
      type(system_type) :: system
      type(contacts_type) :: contacts
      type(laws_type) :: laws
      real(wp) :: from(6, 2), to(6, 2), fraction, minimum, result, scale, largest, residual
      integer :: k

      call random_system(system, contacts, laws, count, 0.0_wp)
      from = 0.1_wp*reshape(random_vector(12), [6, 2])
      to = from - length*reshape(gradient(system, contacts, from), [6, 2])
      system%previous_d = from
      system%d = to
      largest = 0.0_wp
      call evaluate_contacts(contacts, laws, to, largest, residual)
      call descend(system, contacts, laws, fraction)
      call check(fraction > 0.0_wp .and. fraction <= 1.0_wp, 'a part of the way')
      result = energy(system, contacts, system%d)
      minimum = huge(1.0_wp)
      do k = 0, 200
         minimum = min(minimum, energy(system, contacts, from + real(k, wp)/200*(to - from)))
      end do
      scale = energy(system, contacts, from) - minimum
      ! A slope that is 1 % of the first one, of a convex function: 2 % of the descent are left at
      ! most.
      call check(result <= minimum + 0.02_wp*scale, 'no place on the way is much lower')
      call check(maxval(abs(system%d - from - fraction*(to - from))) <= &
         1.0e-12_wp*maxval(abs(to)), 'it is on the way')
   end subroutine search

   subroutine keep(count)
      integer, intent(in) :: count
      type(system_type) :: system
      type(contacts_type) :: contacts
      type(laws_type) :: laws
      real(wp) :: to(6, 2), fraction, largest, residual

      call random_system(system, contacts, laws, count, 0.0_wp)
      system%previous_d = 0.1_wp*reshape(random_vector(12), [6, 2])
      to = system%previous_d - 1.0e-6_wp*reshape(gradient(system, contacts, system%previous_d), &
         [6, 2])
      system%d = to
      largest = 0.0_wp
      call evaluate_contacts(contacts, laws, to, largest, residual)
      call descend(system, contacts, laws, fraction)
      call check(fraction == 1.0_wp .and. all(system%d == to), 'is gone to its end')
   end subroutine keep

end module test_line_search
