! SPDX-License-Identifier: GPL-3.0-or-later
!> Damping of a spring of a welded face, by the materials of both cells.
!>
!> The equations of `dda_material_damping` apply, with the extension e of the spring since the end
!> of statics as strain.  Between two materials, each damps a fraction of the spring, equal to its
!> fraction of the energy due to a common traction.
module dda_weld_damping
   use dda_kinds, only: wp
   use dda_damping, only: damping_type, is_damped, following, relaxing
   use dda_scheme, only: step_type
   use dda_weld, only: weld_type
   implicit none
   private
   public :: damped_fractions, damping_factor, memory_stretch, relaxing_stretch, damping_energy, &
      add_damping_loss, change_memory

contains

   !> Return the fractions of the springs of a face that its two cells damp; 0 without damping.
   pure function damped_fractions(weld, material, modulus, damping) result(fraction)
      type(weld_type), intent(in) :: weld              !< face
      integer, intent(in) :: material(2)               !< materials of both cells
      real(wp), intent(in) :: modulus(2)               !< modulus for compression of both cells, Pa
      type(damping_type), intent(in) :: damping(:)     !< [materials] damping; empty: none
      real(wp) :: fraction(2)

      fraction = 0.0_wp
      if (size(damping) == 0) return
      fraction = [1.0_wp, 0.0_wp]
      if (material(1) /= material(2)) fraction = weld%area/modulus/sum(weld%area/modulus)
      where (.not. is_damped(damping(material))) fraction = 0.0_wp
   end function damped_fractions

   !> Return the damping part of the factor by which K̂ contains the stiffness of a spring.
   pure real(wp) function damping_factor(damping, step) result(factor)
      type(damping_type), intent(in) :: damping  !< damping of the material
      type(step_type), intent(in) :: step        !< the present step
      integer :: l

      factor = damping%unrelaxed - 1.0_wp
      do l = 1, damping%n
         factor = factor - damping%unrelaxed*following(damping, l, step%time_step)
      end do
      factor = step%scheme%theta*factor + damping%beta/step%time_step
   end function damping_factor

   !> Return the extension (r − 1) e − r Σ ζ_l due to the memory.
   pure real(wp) function memory_stretch(damping, e, memory) result(stretch)
      type(damping_type), intent(in) :: damping  !< damping of the material
      real(wp), intent(in) :: e                  !< m or a strain
      real(wp), intent(in) :: memory(:)          !< [mechanisms] ζ_l of a spring

      stretch = 0.0_wp
      if (damping%n > 0) stretch = (damping%unrelaxed - 1.0_wp)*e &
         - damping%unrelaxed*sum(memory(:damping%n))
   end function memory_stretch

   !> Return the relaxation r Σ 2h_l/(1 + h_l) (Y_l e₀ − ζ_l) of the mechanisms without motion.
   pure real(wp) function relaxing_stretch(damping, e, memory, time_step) result(stretch)
      type(damping_type), intent(in) :: damping  !< damping of the material
      real(wp), intent(in) :: e, memory(:)       !< see `memory_stretch`
      real(wp), intent(in) :: time_step          !< Δt, s
      integer :: l

      stretch = 0.0_wp
      do l = 1, damping%n
         stretch = stretch + damping%unrelaxed*relaxing(damping, l, time_step, e, memory(l))
      end do
   end function relaxing_stretch

   !> Return the energy ½ (r − 1) e² − r e Σ ζ_l + ½ r Σ ζ_l²/Y_l.
   pure real(wp) function damping_energy(damping, e, memory) result(energy)
      type(damping_type), intent(in) :: damping  !< damping of the material
      real(wp), intent(in) :: e, memory(:)       !< see `memory_stretch`

      energy = 0.0_wp
      if (damping%n == 0) return
      associate (r => damping%unrelaxed, z => memory(:damping%n))
         energy = 0.5_wp*(r - 1.0_wp)*e**2 - r*e*sum(z) &
            + 0.5_wp*r*sum(z**2/damping%weight(:damping%n))
      end associate
   end function damping_energy

   !> Update ζ_l at the end of a step.
   pure subroutine change_memory(damping, e, change, time_step, memory)
      type(damping_type), intent(in) :: damping  !< damping of the material
      real(wp), intent(in) :: e, change          !< extension at the start, and its increment
      real(wp), intent(in) :: time_step          !< Δt, s
      real(wp), intent(inout) :: memory(:)       !< [mechanisms] ζ_l
      integer :: l

      do l = 1, damping%n
         memory(l) = memory(l) + (relaxing(damping, l, time_step, e, memory(l)) &
            + following(damping, l, time_step)*change)
      end do
   end subroutine change_memory

   !> Add the losses of a step by damping, and Δσ·Δε of the damping stress.
   pure subroutine add_damping_loss(damping, stiffness, change, increment, time_step, loss)
      type(damping_type), intent(in) :: damping  !< damping of the material
      real(wp), intent(in) :: stiffness          !< fraction of the stiffness of the spring
      real(wp), intent(in) :: change             !< increment of the stretch
      real(wp), intent(in) :: increment(:)           !< [mechanisms] Δζ_l
      real(wp), intent(in) :: time_step          !< Δt, s
      real(wp), intent(inout) :: loss(2)  !< loss of material; of scheme, J per metre
      integer :: l

      do l = 1, damping%n
         loss(1) = loss(1) + stiffness*damping%unrelaxed*increment(l)**2 &
            /(damping%weight(l)*damping%omega(l)*time_step)
      end do
      loss(1) = loss(1) + stiffness*damping%beta/time_step*change**2
      loss(2) = loss(2) + stiffness*change*((damping%unrelaxed - 1.0_wp)*change &
         - damping%unrelaxed*sum(increment(:damping%n)))
   end subroutine add_damping_loss

end module dda_weld_damping
