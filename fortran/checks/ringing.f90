! SPDX-License-Identifier: GPL-3.0-or-later
!> Ringing: modes whose velocities change sign in each step, and the number of steps in which the
!> most persistent of these modes decays to 1/e.
!>
!> If Ω = ωΔt exceeds 2/|θ − χ| (4 in DDA), one root of the scheme is negative and tends to 1 − 1/χ
!> for large Ω, in DDA to −1: a stiff contact rings for about Ω²/8 steps after an impact.  Bonded
!> contacts and strains have the roots of (θ, χ), unilateral contacts the roots of (1, χ), and other
!> modes those of their mean θ.  Supports have the roots of backward Euler and do not ring; their
!> stiffness is omitted here.
module dda_ringing
   use dda_kinds, only: wp
   use dda_eigen, only: eigenpairs_type, find_largest_eigenvalue, suggested_tolerance
   use dda_errors, only: error_type
   use dda_linear_model, only: linear_model_type, energy_distribution_type, energy_of, &
      scheme_of_mode, set_penalty, kind_names
   use dda_scheme, only: scheme_type
   use dda_scheme_response, only: steps_to_decay
   use dda_text, only: short_text
   implicit none
   private
   public :: ringing_type, find_ringing

   !> Slowest mode with alternating velocity.
   type :: ringing_type
      real(wp) :: steps = 0.0_wp  !< steps of decay to 1/e; 0: no mode rings; huge: no decay
      real(wp) :: resolution = 0.0_wp        !< Ω = ωΔt of this mode
      character(len=:), allocatable :: text
      character(len=:), allocatable :: advice
      character(len=:), allocatable :: brief
   end type ringing_type

contains

   !> Find the slowest alternating mode of a linearised model at the Δt of its run.
   subroutine find_ringing(linear, ringing, error)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      type(ringing_type), intent(out) :: ringing  !< slowest alternating mode
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      type(linear_model_type) :: ungrounded
      type(eigenpairs_type) :: pairs
      type(energy_distribution_type) :: energy
      real(wp) :: omega

      call copy_without_ground(linear, ungrounded)
      call find_largest_eigenvalue(ungrounded%stiffness, ungrounded%mass, max(1.0e-4_wp, &
         suggested_tolerance(ungrounded%n)), pairs, error)
      if (allocated(error)) return
      omega = sqrt(max(0.0_wp, pairs%value(1)))
      energy = energy_of(ungrounded, pairs%vector(:, :, 1))
      ringing%steps = steps_to_decay(scheme_of_mode(linear, energy), omega, linear%time_step)
      ! Bonded contacts may ring longer, in a mode that is less stiff.
      if (linear%n_unilateral < linear%n_closed) ringing%steps = max(ringing%steps, &
         steps_to_decay(linear%scheme, omega, linear%time_step))
      ringing%resolution = omega*linear%time_step
      call write_ringing_text(ringing, linear%scheme, trim(kind_names(maxloc(energy%fraction, 1))))
   end subroutine find_ringing

   !> Copy the model without springs to the ground and without springs with dashpots.
   subroutine copy_without_ground(linear, ungrounded)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      type(linear_model_type), intent(out) :: ungrounded  !< model without these springs
      integer :: i

      ungrounded = linear
      do i = 1, ungrounded%terms%n
         associate (term => ungrounded%terms%term(i))
            if (term%block_b == 0 .or. term%damped) term%coefficient = 0.0_wp
         end associate
      end do
      call set_penalty(ungrounded, linear%normal_stiffness)
   end subroutine copy_without_ground

   !> Write the texts on the slowest alternating mode, and the advice.
   subroutine write_ringing_text(ringing, scheme, kind)
      type(ringing_type), intent(inout) :: ringing  !< slowest alternating mode
      type(scheme_type), intent(in) :: scheme  !< time integration (θ, χ)
      character(len=*), intent(in) :: kind  !< kind of term with the most energy

      ringing%text = 'no modal velocity changes its sign from step to step'
      ringing%brief = ringing%text
      ringing%advice = "a smaller time_step, a lower normal_stiffness, or integration = 'theta'"
      if (scheme%chi > 0.5_wp) &
         ringing%advice = 'a smaller time_step, a lower normal_stiffness, or a larger theta'
      if (.not. ringing%steps > 0.0_wp) return
      ringing%text = 'the stiffest mode ('//kind//', ω Δt = '//short_text(ringing%resolution)// &
         ') changes the sign of its velocity in each step and '
      if (ringing%steps < 1.0e12_wp) then
         ringing%text = ringing%text//'decays to 1/e in '//short_text(ringing%steps)//' steps'
         ringing%brief = '1/e in '//short_text(ringing%steps)//' steps'
      else
         ringing%text = ringing%text//'does not decay'
         ringing%brief = 'does not decay'
      end if
      ringing%brief = kind//', '//ringing%brief
   end subroutine write_ringing_text

end module dda_ringing
