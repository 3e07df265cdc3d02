! SPDX-License-Identifier: GPL-3.0-or-later
!> Stress, tangent and energies of branches (`dda_branches`) in a step of the midpoint rule, in
!> simple shear; all values are divided by the small-strain modulus G.
!>
!> A slipping branch returns to its cap at the end of the step, e₁ = clip(e₀ + Δγ, ±γ_j), and its
!> stress in the step is the mean of both ends; the stress of a recoverable branch is its mean over
!> the step, (1/Δγ) ∫ clip dγ.  A step therefore dissipates
!>
!>     Σ F_j g_j ½ (e₀ + e₁) (Δγ − Δe) ≥ 0
!>
!> and stores the rest of the work exactly; the stress is the derivative of a convex function of Δγ.
!>
!> The Maxwell body for small strains, σ = r Σ (Y_l e − ζ_l) with the mechanisms of `dda_damping`,
!> receives the part Δe of Δγ that limits |σ₁| to its cap; its stress is also the mean of both ends.
module dda_branch_law
   use dda_kinds, only: wp
   use dda_branches, only: branches_type
   implicit none
   private
   public :: response_type, respond, respond_body, advance_branches, advance_body, &
      stored_by_branches, stored_by_body

   !> Response of a strain point to a change of its strain.
   type :: response_type
      real(wp) :: acting = 0.0_wp   !< stress that acts in the step, divided by G
      real(wp) :: tangent = 0.0_wp  !< derivative with respect to Δγ
      real(wp) :: end = 0.0_wp      !< stress at the end of the step, divided by G
      real(wp) :: loss = 0.0_wp     !< loss of the step/G, J/m³ per Pa
   end type response_type

contains

   !> Compute the response of branches.
   pure type(response_type) function respond(branches, elastic, strain, change) result(response)
      type(branches_type), intent(in) :: branches  !< fitted branches
      real(wp), intent(in) :: elastic(:)  !< [n] e₀ of slipping branches
      real(wp), intent(in) :: strain      !< γ₀
      real(wp), intent(in) :: change      !< Δγ

      call add_slipping(branches, elastic, change, response)
      call add_recoverable(branches, strain, change, response)
   end function respond

   !> Add the slipping parts of the branches.
   pure subroutine add_slipping(branches, elastic, change, response)
      type(branches_type), intent(in) :: branches  !< fitted branches
      real(wp), intent(in) :: elastic(:)           !< [n] e₀
      real(wp), intent(in) :: change               !< Δγ
      type(response_type), intent(inout) :: response   !< response, extended
      real(wp) :: end_strain, mean, modulus
      integer :: j

      do j = 1, branches%n
         modulus = branches%slipping(j)*branches%modulus(j)
         end_strain = clip(elastic(j) + change, branches%strain(j))
         mean = 0.5_wp*(elastic(j) + end_strain)
         response%acting = response%acting + modulus*mean
         response%end = response%end + modulus*end_strain
         response%loss = response%loss + modulus*mean*(change - (end_strain - elastic(j)))
         if (abs(elastic(j) + change) < branches%strain(j)) response%tangent = response%tangent &
            + 0.5_wp*modulus
      end do
   end subroutine add_slipping

   !> Add the recoverable parts of the branches.
   pure subroutine add_recoverable(branches, strain, change, response)
      type(branches_type), intent(in) :: branches  !< fitted branches
      real(wp), intent(in) :: strain               !< γ₀
      real(wp), intent(in) :: change               !< Δγ
      type(response_type), intent(inout) :: response   !< response, extended
      real(wp) :: mean, modulus
      integer :: j

      do j = 1, branches%n
         modulus = (1.0_wp - branches%slipping(j))*branches%modulus(j)
         if (modulus <= 0.0_wp) cycle
         associate (limit => branches%strain(j))
            mean = mean_of_clip(strain, change, limit)
            response%acting = response%acting + modulus*mean
            response%end = response%end + modulus*clip(strain + change, limit)
            response%tangent = response%tangent + modulus &
               *recoverable_tangent(strain, change, limit, mean)
         end associate
      end do
   end subroutine add_recoverable

   !> Update e₁ of the slipping branches.
   pure subroutine advance_branches(branches, change, elastic)
      type(branches_type), intent(in) :: branches  !< fitted branches
      real(wp), intent(in) :: change               !< Δγ
      real(wp), intent(inout) :: elastic(:)        !< [n] e₀, becomes e₁

      elastic = clip(elastic + change, branches%strain)
   end subroutine advance_branches

   !> Energy stored by branches, J/m³, divided by G.
   pure real(wp) function stored_by_branches(branches, elastic, strain) result(energy)
      type(branches_type), intent(in) :: branches  !< fitted branches
      real(wp), intent(in) :: elastic(:)           !< [n] e of slipping branches
      real(wp), intent(in) :: strain               !< γ
      real(wp) :: capped_strain
      integer :: j

      energy = 0.0_wp
      do j = 1, branches%n
         associate (fraction => branches%slipping(j))
            capped_strain = min(abs(strain), branches%strain(j))
            energy = energy + branches%modulus(j)*(0.5_wp*fraction*elastic(j)**2 &
               + (1.0_wp - fraction)*capped_strain*(abs(strain) - 0.5_wp*capped_strain))
         end associate
      end do
   end function stored_by_branches

   !> Compute the response of the small-strain body, and its part of the strain change.
   pure subroutine respond_body(branches, memory, strain, change, time_step, response, body_change)
      type(branches_type), intent(in) :: branches  !< fitted branches
      real(wp), intent(in) :: memory(:)            !< [mechanisms] ζ
      real(wp), intent(in) :: strain               !< e₀
      real(wp), intent(in) :: change               !< Δγ
      real(wp), intent(in) :: time_step            !< Δt, s
      type(response_type), intent(out) :: response     !< response of the body
      real(wp), intent(out) :: body_change         !< Δe
      real(wp) :: elastic_stress, relaxing, stiffness, weight, h
      integer :: l

      body_change = change
      if (branches%body%n == 0) return
      associate (body => branches%body)
         elastic_stress = 0.0_wp
         relaxing = 0.0_wp
         stiffness = 0.0_wp
         do l = 1, body%n
            h = 0.5_wp*body%omega(l)*time_step
            weight = body%weight(l)*strain - memory(l)
            elastic_stress = elastic_stress + body%unrelaxed*weight
            relaxing = relaxing - body%unrelaxed*2.0_wp*h/(1.0_wp + h)*weight
            stiffness = stiffness + body%unrelaxed*body%weight(l)/(1.0_wp + h)
         end do
      end associate
      response%end = clip(elastic_stress + relaxing + stiffness*change, branches%body_cap)
      response%tangent = 0.5_wp*stiffness
      if (abs(elastic_stress + relaxing + stiffness*change) >= branches%body_cap) then
         body_change = (response%end - elastic_stress - relaxing)/stiffness
         response%tangent = 0.0_wp
      end if
      response%acting = 0.5_wp*(elastic_stress + response%end)
      response%loss = response%acting*(change - body_change)
   end subroutine respond_body

   !> Advance the mechanisms of the body to the end of a step; return their loss, J/m³ over G.
   pure subroutine advance_body(branches, strain, body_change, time_step, memory, loss)
      type(branches_type), intent(in) :: branches  !< fitted branches
      real(wp), intent(in) :: strain               !< e₀
      real(wp), intent(in) :: body_change          !< Δe
      real(wp), intent(in) :: time_step            !< Δt, s
      real(wp), intent(inout) :: memory(:)  !< [mechanisms] ζ at the start; on return at the end
      real(wp), intent(out) :: loss                !< J/m³, divided by G
      real(wp) :: h, increment
      integer :: l

      loss = 0.0_wp
      associate (body => branches%body)
         do l = 1, body%n
            h = 0.5_wp*body%omega(l)*time_step
            increment = (2.0_wp*h*(body%weight(l)*strain - memory(l)) &
               + h*body%weight(l)*body_change) /(1.0_wp + h)
            loss = loss + body%unrelaxed*increment**2/(body%weight(l)*body%omega(l)*time_step)
            memory(l) = memory(l) + increment
         end do
      end associate
   end subroutine advance_body

   !> Energy stored by the springs of the body, J/m³, divided by G.
   pure real(wp) function stored_by_body(branches, memory, strain) result(energy)
      type(branches_type), intent(in) :: branches  !< fitted branches
      real(wp), intent(in) :: memory(:)            !< [mechanisms] ζ
      real(wp), intent(in) :: strain               !< e

      associate (body => branches%body)
         energy = 0.5_wp*body%unrelaxed*sum((body%weight(:body%n)*strain - memory(:body%n))**2 &
            /body%weight(:body%n))
      end associate
   end function stored_by_body

   !> A strain, or its limit if the strain exceeds this limit.
   elemental real(wp) function clip(strain, limit)
      real(wp), intent(in) :: strain, limit  !< strain; limit ≥ 0

      clip = max(-limit, min(limit, strain))
   end function clip

   !> Mean of clip(γ, ±limit) from γ₀ to γ₀ + Δγ, without differences of large numbers.
   elemental real(wp) function mean_of_clip(strain, change, limit) result(mean)
      real(wp), intent(in) :: strain, change, limit  !< γ₀, Δγ, cap of γ
      real(wp) :: lower, upper, inner_lower, inner_upper

      lower = min(strain, strain + change)
      upper = max(strain, strain + change)
      if (upper <= limit .and. lower >= -limit) then
         mean = 0.5_wp*(lower + upper)
      else if (lower >= limit .or. upper <= -limit) then
         mean = sign(limit, lower + upper)
      else
         inner_lower = max(lower, -limit)
         inner_upper = min(upper, limit)
         mean = ((inner_upper - inner_lower)*0.5_wp*(inner_upper + inner_lower) &
            + limit*((upper - inner_upper) - (inner_lower - lower)))/(upper - lower)
      end if
   end function mean_of_clip

   !> Derivative of `mean_of_clip` by Δγ: (clip(γ₁) − mean)/Δγ; half the slope as Δγ tends to 0.
   elemental real(wp) function recoverable_tangent(strain, change, limit, mean) result(tangent)
      real(wp), intent(in) :: strain, change, limit  !< γ₀, Δγ, cap of γ
      real(wp), intent(in) :: mean                   !< mean over the step

      if (abs(strain) <= limit .and. abs(strain + change) <= limit) then
         tangent = 0.5_wp
      else if (abs(strain) >= limit .and. abs(strain + change) >= limit &
         .and. (strain > 0.0_wp .eqv. strain + change > 0.0_wp)) then
         tangent = 0.0_wp
      else
         tangent = (clip(strain + change, limit) - mean)/change
      end if
   end function recoverable_tangent

end module dda_branch_law
