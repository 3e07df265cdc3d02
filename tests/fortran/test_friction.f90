! SPDX-License-Identifier: GPL-3.0-or-later
!> The law of one contact against its definition, and against its potential.
module test_friction
   use dda_kinds, only: wp, pi
   use dda_contact, only: contact_open, contact_slide, contact_stick
   use dda_coulomb, only: coulomb_contact_type, respond
   use dda_friction, only: law_of, laws_type, set_laws
   use dda_joint_law, only: response_type
   use dda_material, only: joint_type
   use models, only: random
   use testing, only: check, check_close
   implicit none

   real(wp), parameter :: stiffness = 1.0e9_wp, length = 0.5_wp
   type(laws_type) :: laws

contains

   subroutine make_laws(laws)
      type(laws_type), intent(out) :: laws

      call set_laws(laws, [joint_type('', 0.0_wp, 0.0_wp, 0.0_wp), joint_type('', 30.0_wp, &
         2.0e6_wp, 1.0e6_wp)], stiffness, 2.5_wp)
   end subroutine make_laws

   subroutine states()
      type(coulomb_contact_type) :: law
      type(response_type) :: response

      call make_laws(laws)
      law = law_of(laws, 2, .false., length, 0.0_wp)
      call respond(law, 1.0e-12_wp, 1.0_wp, response)
      call check(response%state == contact_open, 'a gap, however small, is open')
      call check_close([response%normal_force, response%shear_force], [0.0_wp, 0.0_wp], &
         'without force')
      call respond(law, -1.0e-12_wp, 0.0_wp, response)
      call check(response%state == contact_stick, 'penetration, however small, presses')
      call check_close(response%normal_force, 1.0e-3_wp, 'with k times depth', relative=1.0e-14_wp)
      call respond(law, -1.0e-4_wp, 1.0e-4_wp, response)
      call check(response%state == contact_stick, 'below the bound it sticks')
      call check_close(response%shear_force, 4.0e4_wp, 'with k_s times stretch', &
         relative=1.0e-14_wp)
      call respond(law, -1.0e-4_wp, -1.0e-2_wp, response)
      call check(response%state == contact_slide, 'above it slides')
      call check_close(response%shear_force, -1.0e5_wp*tan(pi/6.0_wp), 'with μN', &
         relative=1.0e-14_wp)
      call respond(law_of(laws, 1, .false., length, 0.0_wp), -1.0e-4_wp, 1.0e-9_wp, response)
      call check_close(response%shear_force, 0.0_wp, 'no friction, no shear force')
   end subroutine states

   !> N = max(0, −k g) or, with a multiplier p, max(0, p − k g); |S| ≤ μN; S elastic inside.
   subroutine random_gaps_and_stretches()
      type(response_type) :: response
      real(wp) :: gap, stretch, pressure, normal, bound, max_error(2), mu
      integer :: i, joint

      call make_laws(laws)
      max_error = 0.0_wp
      do i = 1, 2000
         joint = 1 + modulo(i, 2)
         mu = merge(0.0_wp, tan(pi/6.0_wp), joint == 1)
         gap = random(-1.0e-3_wp, 1.0e-3_wp)
         stretch = random(-1.0e-3_wp, 1.0e-3_wp)
         pressure = max(0.0_wp, random(-1.0e6_wp, 1.0e6_wp))
         call respond(law_of(laws, joint, .false., length, pressure), gap, stretch, response)
         normal = max(0.0_wp, pressure - stiffness*gap)
         bound = mu*normal
         max_error(1) = max(max_error(1), abs(response%normal_force - normal))
         max_error(2) = max(max_error(2), &
            abs(response%shear_force - max(-bound, min(bound, stiffness/2.5_wp*stretch))))
      end do
      call check_close(max_error, [0.0_wp, 0.0_wp], 'normal and shear force', absolute=1.0e-8_wp)
   end subroutine random_gaps_and_stretches

   !> No dead band, no jump: forces are Lipschitz in gap and stretch.
   subroutine continuity()
      type(coulomb_contact_type) :: law
      type(response_type) :: first, second
      real(wp) :: gap, stretch, max_error
      real(wp), parameter :: h = 1.0e-9_wp
      integer :: i

      call make_laws(laws)
      law = law_of(laws, 2, .false., length, 0.0_wp)
      max_error = 0.0_wp
      do i = -1000, 1000
         gap = 0.5_wp*h*real(i, wp)
         stretch = 0.3_wp*gap + h*modulo(i, 7)
         call respond(law, gap, stretch, first)
         call respond(law, gap + h, stretch + h, second)
         max_error = max(max_error, abs(first%normal_force - second%normal_force), &
            abs(first%shear_force - second%shear_force))
      end do
      call check(max_error <= stiffness*h*(1.0_wp + 1.0e-9_wp), &
         'no force changes faster than its spring')
   end subroutine continuity

   !> Overload is positive exactly if tension or shear exceeds its limit.
   subroutine strength_ratio()
      type(laws_type) :: laws
      type(response_type) :: response
      real(wp) :: gap, stretch
      logical :: exceeds
      integer :: i, n_wrong

      call make_laws(laws)
      n_wrong = 0
      do i = 1, 2000
         gap = random(-3.0e-3_wp, 1.0e-3_wp)
         stretch = random(-6.0e-3_wp, 6.0e-3_wp)
         call respond(law_of(laws, 2, .true., length, 0.0_wp), gap, stretch, response)
         exceeds = stiffness*gap > 0.5e6_wp .or. &
            abs(stiffness/2.5_wp*stretch) > 1.0e6_wp + tan(pi/6.0_wp)*max(0.0_wp, -stiffness*gap)
         if (exceeds .neqv. response%strength_ratio > 0.0_wp) n_wrong = n_wrong + 1
         if (response%state /= contact_stick) n_wrong = n_wrong + 1
      end do
      call check(n_wrong == 0, 'where tension or shear is over its limit, and only there')
   end subroutine strength_ratio

end module test_friction
