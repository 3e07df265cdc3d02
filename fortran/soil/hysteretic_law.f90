! SPDX-License-Identifier: GPL-3.0-or-later
!> Hysteretic soil in the plane: branches (`dda_branches`) on the strains (εx − εy, γxy) of
!> maximum shear; volume is elastic.
!>
!> A Maxwell body gives the small-strain damping: in shear it is in series with a slider, as in a
!> column (`dda_branch_law`); in volume change it has no slider.  Its shear stress is returned to
!> the cap at the end of a step.  Like the branches, it acts with the values at both ends of the
!> step, weighted by 1 − θ and θ.
!>
!> In static stages the soil is elastic, so that hysteresis loops begin at equilibrium under
!> gravity.
module dda_hysteretic_law
   use dda_kinds, only: wp
   use dda_branches, only: branches_type, relaxed_modulus, secant_ratio
   use dda_damping, only: following, relaxing
   use dda_material_law, only: material_law_type, strain_point_type, loss_plastic, loss_damping, &
      loss_scheme, losses
   use dda_plane_branches, only: return_to_cap, compute_recoverable_stress, potential
   use dda_scheme, only: step_type
   use dda_text, only: short_text, to_text
   implicit none
   private
   public :: hysteretic_law_type, new_hysteretic_law

   real(wp), parameter :: max_misfit = 0.3_wp  !< largest unreported misfit, percentage points

   !> Branches of a soil in the plane.
   type, extends(material_law_type) :: hysteretic_law_type
      type(branches_type) :: branches
   contains
      procedure :: state_size, respond => find_stress, finish => finish_step, stored, rests, &
         secant, fit_text => body_fit_text, unmet => misfit_text
   end type hysteretic_law_type

   !> Small-strain body in a step: shear (two components) and volume.
   type :: maxwell_type
      real(wp) :: before(3) = 0.0_wp    !< stress at the start/modulus
      real(wp) :: trial(3) = 0.0_wp     !< trial stress at the end without slip
      real(wp) :: stiffness = 0.0_wp    !< derivative of the trial stress with respect to the strain
      real(wp) :: after(3) = 0.0_wp     !< stress at the end/modulus
      real(wp) :: slope(2, 2) = 0.0_wp  !< derivative of `after` in shear with respect to the strain
   end type maxwell_type

contains

   !> Create the law of fitted branches; branches without stiffness are omitted.
   pure type(hysteretic_law_type) function new_hysteretic_law(branches) result(law)
      type(branches_type), intent(in) :: branches  !< fitted branches

      law%branches = branches
      associate (is_stiff => branches%modulus > 0.0_wp)
         law%branches%n = count(is_stiff)
         law%branches%strain = pack(branches%strain, is_stiff)
         law%branches%modulus = pack(branches%modulus, is_stiff)
         law%branches%slipping = pack(branches%slipping, is_stiff)
      end associate
   end function new_hysteretic_law

   !> Number of state variables: strains of slipping branches, then strain and ζ of the body.
   pure integer function state_size(self)
      class(hysteretic_law_type), intent(in) :: self  !< law

      state_size = 2*self%branches%n + 3*(1 + self%branches%body%n)
   end function state_size

   !> .true. if the law is elastic in static stages; the first loops begin after them.
   pure logical function rests(self)
      class(hysteretic_law_type), intent(in) :: self  !< law

      rests = .true.
   end function rests

   !> Strain components (εx − εy, γxy, εx + εy).
   pure function strain_components(strain)
      real(wp), intent(in) :: strain(3)  !< εx, εy, γxy
      real(wp) :: strain_components(3)

      strain_components = [strain(1) - strain(2), strain(3), strain(1) + strain(2)]
   end function strain_components

   !> Moduli, Pa: G, and the modulus of area, (σx + σy)/2 over εx + εy.
   pure function shear_and_bulk(point)
      type(strain_point_type), intent(in) :: point  !< strain point of the law
      real(wp) :: shear_and_bulk(2)

      shear_and_bulk = [point%elasticity(3, 3), 0.5_wp*(point%elasticity(1, 1) &
         + point%elasticity(1, 2))]
   end function shear_and_bulk

   !> Compute the stress in a step, and its tangent.
   pure subroutine find_stress(self, point, state, strain, change, step, stress, tangent)
      class(hysteretic_law_type), intent(in) :: self     !< law
      type(strain_point_type), intent(in) :: point       !< strain point of the law
      real(wp), intent(in) :: state(:)                   !< [any] state at the start of the step
      real(wp), intent(in) :: strain(3), change(3)       !< ε at the start, Δε
      type(step_type), intent(in) :: step                !< the present step
      real(wp), intent(out) :: stress(3), tangent(3, 3)  !< Pa
      real(wp) :: e(3), increment(3), acting(3), slope(2, 2), volume, modulus(2)
      type(maxwell_type) :: maxwell

      e = strain_components(strain)
      increment = strain_components(change)
      modulus = shear_and_bulk(point)
      associate (theta => step%scheme%theta, relaxed => relaxed_modulus(self%branches%body))
         call add_branches(self%branches, state, e(1:2), increment(1:2), theta, acting(1:2), slope)
         maxwell = maxwell_of(self%branches, state, increment, step%time_step)
         acting(1:2) = acting(1:2) + maxwell%before(1:2) &
            + theta*(maxwell%after(1:2) - maxwell%before(1:2))
         slope = slope + theta*maxwell%slope
         acting(3) = relaxed*(e(3) + theta*increment(3)) + maxwell%before(3) &
            + theta*(maxwell%after(3) - maxwell%before(3))
         volume = modulus(2)*theta*(relaxed + maxwell%stiffness)
      end associate
      acting = acting*[modulus(1), modulus(1), modulus(2)]
      stress = [acting(3) + acting(1), acting(3) - acting(1), acting(2)]
      slope = modulus(1)*slope
      tangent(:, 1) = [volume + slope(1, 1), volume - slope(1, 1), slope(2, 1)]
      tangent(:, 2) = [volume - slope(1, 1), volume + slope(1, 1), -slope(2, 1)]
      tangent(:, 3) = [slope(1, 2), -slope(1, 2), slope(2, 2)]
   end subroutine find_stress

   !> Add the stress of all branches, divided by G.
   pure subroutine add_branches(branches, state, e, change, theta, acting, slope)
      type(branches_type), intent(in) :: branches   !< fitted branches
      real(wp), intent(in) :: state(:)              !< [any] state of the point
      real(wp), intent(in) :: e(2), change(2)       !< shear strains at the start, and their change
      real(wp), intent(in) :: theta                 !< θ
      real(wp), intent(out) :: acting(2), slope(2, 2)
      real(wp) :: p(2), slope_of_branch(2, 2), modulus
      integer :: j

      acting = 0.0_wp
      slope = 0.0_wp
      do j = 1, branches%n
         associate (slip_strain => state(2*j - 1:2*j), fraction => branches%slipping(j))
            modulus = fraction*branches%modulus(j)
            if (modulus > 0.0_wp) then
               call return_to_cap(slip_strain + change, branches%strain(j), p, slope_of_branch)
               acting = acting + modulus*(slip_strain + theta*(p - slip_strain))
               slope = slope + modulus*theta*slope_of_branch
            end if
            modulus = (1.0_wp - fraction)*branches%modulus(j)
            if (modulus > 0.0_wp) then
               call compute_recoverable_stress(e, change, branches%strain(j), theta, p, &
                  slope_of_branch)
               acting = acting + modulus*p
               slope = slope + modulus*slope_of_branch
            end if
         end associate
      end do
   end subroutine add_branches

   !> Return stresses and stiffness in a step of the Maxwell element that damps small strains.
   pure type(maxwell_type) function maxwell_of(branches, state, change, time_step) result(maxwell)
      type(branches_type), intent(in) :: branches  !< fitted branches
      real(wp), intent(in) :: state(:)             !< [any] state of the point at the start
      real(wp), intent(in) :: change(3)            !< change of the strains of shear and volume
      real(wp), intent(in) :: time_step            !< Δt, s
      integer :: l, i

      associate (law => branches%body, r => branches%body%unrelaxed, n => 2*branches%n)
         do l = 1, law%n
            do i = 1, 3
               associate (e => state(n + i), memory => state(n + 3*l + i))
                  maxwell%before(i) = maxwell%before(i) + r*(law%weight(l)*e - memory)
                  maxwell%trial(i) = maxwell%trial(i) - r*relaxing(law, l, time_step, e, memory)
               end associate
            end do
            maxwell%stiffness = maxwell%stiffness + r*(law%weight(l) - following(law, l, time_step))
         end do
         maxwell%trial = maxwell%before + maxwell%trial + maxwell%stiffness*change
         maxwell%after = maxwell%trial
         call return_to_cap(maxwell%trial(1:2), branches%body_cap, maxwell%after(1:2), &
            maxwell%slope)
         maxwell%slope = maxwell%stiffness*maxwell%slope
      end associate
   end function maxwell_of

   !> Find the state at the end of a step, and its losses.
   pure subroutine finish_step(self, point, state, strain, change, step, loss)
      class(hysteretic_law_type), intent(in) :: self  !< law
      type(strain_point_type), intent(in) :: point    !< strain point of the law
      real(wp), intent(inout) :: state(:)  !< [any] state at the start; on return at the end
      real(wp), intent(in) :: strain(3), change(3)    !< ε at the start, Δε
      type(step_type), intent(in) :: step             !< the present step
      real(wp), intent(out) :: loss(losses)           !< J/m³
      real(wp) :: e(3), increment(3), modulus(2), scheme

      e = strain_components(strain)
      increment = strain_components(change)
      modulus = shear_and_bulk(point)
      loss = 0.0_wp
      call finish_branches(self%branches, state, e(1:2), increment(1:2), step%scheme%theta, loss, &
         scheme)
      scheme = scheme + (step%scheme%theta - 0.5_wp)*relaxed_modulus(self%branches%body) &
         *increment(3)**2*modulus(2)/modulus(1)
      loss = modulus(1)*loss
      loss(loss_scheme) = modulus(1)*scheme
      if (self%branches%body%n > 0) call finish_maxwell(self%branches, state, increment, modulus, &
         step, loss)
   end subroutine finish_step

   !> Update the strains of the branches at the end of a step; find the losses by slip and scheme.
   pure subroutine finish_branches(branches, state, e, change, theta, loss, scheme)
      type(branches_type), intent(in) :: branches  !< fitted branches
      real(wp), intent(inout) :: state(:)          !< [any] state of the point
      real(wp), intent(in) :: e(2), change(2)      !< shear strains at the start, and their change
      real(wp), intent(in) :: theta                !< θ
      real(wp), intent(inout) :: loss(losses)      !< losses; the loss by slip is set
      real(wp), intent(out) :: scheme              !< loss by the scheme
      real(wp) :: p(2), slope_of_branch(2, 2), modulus, stored
      integer :: j

      scheme = 0.0_wp
      do j = 1, branches%n
         associate (slip_strain => state(2*j - 1:2*j), fraction => branches%slipping(j))
            call return_to_cap(slip_strain + change, branches%strain(j), p, slope_of_branch)
            modulus = fraction*branches%modulus(j)
            loss(loss_plastic) = loss(loss_plastic) + modulus*dot_product(0.5_wp*(slip_strain + &
               p), change - (p - slip_strain))
            scheme = scheme + modulus*(theta - 0.5_wp)*dot_product(p - slip_strain, change)
            slip_strain = p
            if (theta > 0.5_wp .and. fraction < 1.0_wp) then
               modulus = (1.0_wp - fraction)*branches%modulus(j)
               call compute_recoverable_stress(e, change, branches%strain(j), theta, p, &
                  slope_of_branch)
               stored = potential(e + change, branches%strain(j)) - potential(e, branches%strain(j))
               scheme = scheme + modulus*(dot_product(p, change) - stored)
            end if
         end associate
      end do
   end subroutine finish_branches

   !> Update strain and mechanisms of the body at the end of a step, and find its losses.
   pure subroutine finish_maxwell(branches, state, change, modulus, step, loss)
      type(branches_type), intent(in) :: branches  !< fitted branches
      real(wp), intent(inout) :: state(:)          !< [any] state of the point
      real(wp), intent(in) :: change(3)            !< change of the strains of shear and volume
      real(wp), intent(in) :: modulus(2)           !< moduli of shear and volume, Pa
      type(step_type), intent(in) :: step          !< the present step
      real(wp), intent(inout) :: loss(losses)      !< J/m³
      type(maxwell_type) :: maxwell
      real(wp) :: maxwell_change, memory_change, stiffness(3)
      integer :: l, i

      stiffness = [modulus(1), modulus(1), modulus(2)]
      maxwell = maxwell_of(branches, state, change, step%time_step)
      associate (law => branches%body, n => 2*branches%n)
         do i = 1, 3
            maxwell_change = change(i) - (maxwell%trial(i) - maxwell%after(i))/maxwell%stiffness
            loss(loss_plastic) = loss(loss_plastic) + stiffness(i)*0.5_wp*(maxwell%before(i) &
               + maxwell%after(i))*(change(i) - maxwell_change)
            loss(loss_scheme) = loss(loss_scheme) + stiffness(i)*(step%scheme%theta - 0.5_wp) &
               *(maxwell%after(i) - maxwell%before(i))*change(i)
            do l = 1, law%n
               associate (memory => state(n + 3*l + i))
                  memory_change = relaxing(law, l, step%time_step, state(n + i), memory) &
                     + following(law, l, step%time_step)*maxwell_change
                  loss(loss_damping) = loss(loss_damping) &
                     + stiffness(i)*law%unrelaxed*memory_change**2 &
                     /(law%weight(l)*law%omega(l)*step%time_step)
                  memory = memory + memory_change
               end associate
            end do
            state(n + i) = state(n + i) + maxwell_change
         end do
      end associate
   end subroutine finish_maxwell

   !> Stored energy ψ, J/m³.
   pure real(wp) function stored(self, point, state, strain)
      class(hysteretic_law_type), intent(in) :: self  !< law
      type(strain_point_type), intent(in) :: point    !< strain point of the law
      real(wp), intent(in) :: state(:)                !< [any] state of the point
      real(wp), intent(in) :: strain(3)               !< ε
      real(wp) :: e(3), energy(3), modulus(2)
      integer :: i, j, l

      e = strain_components(strain)
      energy = [0.0_wp, 0.0_wp, 0.5_wp*relaxed_modulus(self%branches%body)*e(3)**2]
      do j = 1, self%branches%n
         associate (fraction => self%branches%slipping(j))
            energy(1) = energy(1) + self%branches%modulus(j)*(0.5_wp*fraction*sum(state(2*j &
               - 1:2*j)**2) + (1.0_wp - fraction)*potential(e(1:2), self%branches%strain(j)))
         end associate
      end do
      associate (law => self%branches%body, n => 2*self%branches%n)
         do l = 1, law%n
            do i = 1, 3
               energy(i) = energy(i) + 0.5_wp*law%unrelaxed*(law%weight(l)*state(n + i) &
                  - state(n + 3*l + i))**2/law%weight(l)
            end do
         end do
      end associate
      modulus = shear_and_bulk(point)
      stored = modulus(1)*(energy(1) + energy(2)) + modulus(2)*energy(3) &
         + dot_product(point%start_stress, strain)
   end function stored

   !> Secant modulus ratio G_s/G of the branches.
   pure real(wp) function secant(self, strain)
      class(hysteretic_law_type), intent(in) :: self  !< law
      real(wp), intent(in) :: strain                  !< amplitude of the loops, above 0
      real(wp) :: ratio(1)

      ratio = secant_ratio(self%branches, [strain])
      secant = ratio(1)
   end function secant

   !> Text on the fit of the branches to their curves.
   function body_fit_text(self) result(text)
      class(hysteretic_law_type), intent(in) :: self  !< law
      character(len=:), allocatable :: text

      associate (misfit => 100*self%branches%misfit)
         text = to_text(self%branches%n)//' branches, moduli within '//short_text(misfit(1))//' %'
         if (misfit(2) > 0.0_wp) text = text//', damping ratios within '// &
            short_text(misfit(2))//' percentage points'
      end associate
   end function body_fit_text

   !> Text on parts of the curve that the branches do not match; blank: none.
   function misfit_text(self) result(text)
      class(hysteretic_law_type), intent(in) :: self  !< law
      character(len=:), allocatable :: text

      text = ''
      associate (misfit_points => 100*self%branches%misfit(2))
         if (misfit_points > max_misfit) text = 'damping ratios are up to '// &
            short_text(misfit_points)// &
            ' percentage points off their curve, more than '//short_text(max_misfit)
      end associate
   end function misfit_text

end module dda_hysteretic_law
