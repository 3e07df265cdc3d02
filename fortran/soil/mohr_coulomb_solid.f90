! SPDX-License-Identifier: GPL-3.0-or-later
!> A solid that yields at the strength of Mohr and Coulomb, with a tension cut-off.
!>
!> A trial stress σ₀ + D(ε₀ − ε^p₀ + θΔε) beyond the strength returns to s (`dda_yield_return`),
!> the stress in the step.  Over the step Δε^p = n λ/θ, n λ = D⁻¹(trial − s), so that
!>
!>     s·Δε = Δψ + s·Δε^p + (θ − ½) Δε^e·DΔε^e .
!>
!> s is the derivative of a convex function of Δε, for frozen bounds (`dda_yield_return`).
!> In plane strain, the elastic and plastic strains out of the plane add up to zero.
!>
!> In each step κ grows by the largest difference of the principal plastic strains, or by the
!> largest plastic extension.  κ times the thickness of the point is a displacement, over which the
!> strength decreases linearly to the residual strength: the energy of a shear band does not depend
!> on the cell size.  During a step, the strength keeps its value at the start of the step.
module dda_mohr_coulomb_solid
   use dda_kinds, only: wp
   use dda_material_law, only: material_law_type, strain_point_type, loss_plastic, loss_scheme, &
      losses
   use dda_scheme, only: step_type
   use dda_yield_return, only: strength_type, return_type, return_principal
   implicit none
   private
   public :: mohr_coulomb_solid_type

   integer, parameter :: plastic(3) = [1, 2, 3]  !< state variables: ε^p in the plane
   integer, parameter :: across = 4              !< state variable: ε^p out of the plane
   integer, parameter :: plastic_measure = 5     !< κ
   integer, parameter :: mean_stress = 6         !< ½(σx + σy) of the last step, Pa
   !> fraction of the radius of the largest Mohr circle: bound of the jumps of a yielding face;
   !> docs/material_laws.md has limit loads for other fractions
   real(wp), parameter :: jump_fraction = 0.05_wp

   !> Strengths of a solid.
   type, extends(material_law_type) :: mohr_coulomb_solid_type
      type(strength_type) :: peak, residual
      real(wp) :: softening = 0.0_wp  !< displacement from peak to residual strength, m; 0: none
      real(wp) :: out_of_plane = 0.0_wp     !< σ_z − ν(σx + σy) at the start, Pa
   contains
      procedure :: state_size, respond => find_stress, finish => finish_step, stored, &
         frozen_stress, plastic_strain, yields, jump_cap, shape_stress, pressure, largest_thickness
   end type mohr_coulomb_solid_type

   !> A point in its principal stresses.
   type :: circle_type
      real(wp) :: elastic(3, 3) = 0.0_wp  !< D of principal strains, Pa
      real(wp) :: radius = 0.0_wp         !< R of the trial stress, Pa
      real(wp) :: direction(2) = [1.0_wp, 0.0_wp]  !< cosine and sine of twice the angle of σ₁
      type(return_type) :: to
   end type circle_type

contains

   !> Number of state variables: ε^p in and out of the plane, κ, the mean stress.
   pure integer function state_size(self)
      class(mohr_coulomb_solid_type), intent(in) :: self  !< law

      state_size = 6
   end function state_size

   !> Strength after a plastic strain κ.
   pure type(strength_type) function strength_at(self, point, strain) result(strength)
      class(mohr_coulomb_solid_type), intent(in) :: self  !< law
      type(strain_point_type), intent(in) :: point        !< at its position
      real(wp), intent(in) :: strain                      !< κ
      real(wp) :: fraction

      strength = self%peak
      if (self%softening <= 0.0_wp) return
      fraction = min(1.0_wp, strain*point%thickness/self%softening)
      associate (peak => self%peak, residual => self%residual)
         strength%cohesion = interpolate(peak%cohesion, residual%cohesion)
         strength%friction = atan(interpolate(tan(peak%friction), tan(residual%friction)))
         strength%dilation = atan(interpolate(tan(peak%dilation), tan(residual%dilation)))
         strength%tension = interpolate(peak%tension, residual%tension)
      end associate
      if (strength%friction > 0.0_wp) strength%tension = min(strength%tension, &
         strength%cohesion/tan(strength%friction))

   contains

      !> Interpolate between a peak and a residual value.
      pure real(wp) function interpolate(from, to)
         real(wp), intent(in) :: from, to  !< peak value, residual value

         interpolate = from
         if (to < from) interpolate = from + fraction*(to - from)
      end function interpolate
   end function strength_at

   !> Compute the trial stress of a strain, counted from the start of the law, and return it.
   pure subroutine return_stress(self, point, state, strain, circle)
      class(mohr_coulomb_solid_type), intent(in) :: self  !< law
      type(strain_point_type), intent(in) :: point        !< strain point of the law
      real(wp), intent(in) :: state(:)                    !< [any] state at the start of the step
      real(wp), intent(in) :: strain(3)                   !< ε₀ + θΔε
      type(circle_type), intent(out) :: circle            !< returned stress
      real(wp) :: trial(3), mean, third
      integer :: i

      associate (d => point%elasticity, e => circle%elastic)
         trial = point%start_stress + matmul(d, strain - state(plastic))
         third = 0.0_wp
         e(1:2, 1:2) = d(1:2, 1:2)
         if (point%plane_strain) then
            e = d(1, 2)
            do i = 1, 3
               e(i, i) = d(1, 1)
            end do
            trial(1:2) = trial(1:2) - d(1, 2)*state(across)
            third = self%out_of_plane + poisson_ratio(d)*sum(point%start_stress(1:2)) + d(1, &
               2)*sum(strain(1:2) - state(1:2)) - d(1, 1)*state(across)
         end if
      end associate
      mean = 0.5_wp*(trial(1) + trial(2))
      circle%radius = hypot(0.5_wp*(trial(1) - trial(2)), trial(3))
      if (circle%radius > 0.0_wp) circle%direction = [0.5_wp*(trial(1) - trial(2)), trial(3)] &
         /circle%radius
      circle%to = return_principal(strength_at(self, point, state(plastic_measure)), &
         circle%elastic, [mean + circle%radius, mean - circle%radius, third], point%bounding)
   end subroutine return_stress

   !> Principal stresses of frozen bounds.
   pure function frozen_stress(self, point, state, strain, change, step) result(stress)
      class(mohr_coulomb_solid_type), intent(in) :: self  !< law
      type(strain_point_type), intent(in) :: point        !< at its position
      real(wp), intent(in) :: state(:)                    !< [any] state at the start of the step
      real(wp), intent(in) :: strain(3), change(3)        !< ε at the start, Δε
      type(step_type), intent(in) :: step                 !< the present step
      real(wp) :: stress(3)
      type(circle_type) :: circle

      stress = point%bounding
      if (self%peak%dilation >= self%peak%friction) return
      call return_stress(self, point, state, strain + step%scheme%theta*change, circle)
      stress = circle%to%stress
   end function frozen_stress

   !> Poisson's ratio ν of the elasticity of plane strain.
   pure real(wp) function poisson_ratio(d)
      real(wp), intent(in) :: d(3, 3)  !< D, Pa

      poisson_ratio = d(1, 2)/(d(1, 1) + d(1, 2))
   end function poisson_ratio

   !> Components of a stress in the plane with two principal values.
   pure function plane_components(direction, principal) result(stress)
      real(wp), intent(in) :: direction(2)  !< cosine and sine of twice the angle of σ₁
      real(wp), intent(in) :: principal(2)  !< Pa
      real(wp) :: stress(3)

      associate (mean => 0.5_wp*sum(principal), radius => 0.5_wp*(principal(1) - principal(2)))
         stress = [mean + radius*direction(1), mean - radius*direction(1), radius*direction(2)]
      end associate
   end function plane_components

   !> Compute the stress in a step minus σ₀, and its tangent.
   pure subroutine find_stress(self, point, state, strain, change, step, stress, tangent)
      class(mohr_coulomb_solid_type), intent(in) :: self  !< law
      type(strain_point_type), intent(in) :: point        !< at its position
      real(wp), intent(in) :: state(:)                    !< [any] state at the start of the step
      real(wp), intent(in) :: strain(3), change(3)        !< ε at the start, Δε
      type(step_type), intent(in) :: step                 !< the present step
      real(wp), intent(out) :: stress(3), tangent(3, 3)   !< Pa
      type(circle_type) :: circle
      real(wp) :: basis(3, 3), principal_slope(3, 3)

      call return_stress(self, point, state, strain + step%scheme%theta*change, circle)
      associate (to => circle%to, u => circle%direction)
         if (.not. to%yields) then
            stress = matmul(point%elasticity, strain - state(plastic) + step%scheme%theta*change)
            if (point%plane_strain) stress(1:2) = stress(1:2) - point%elasticity(1, 2) &
               *state(across)
            tangent = step%scheme%theta*point%elasticity
            return
         end if
         stress = plane_components(u, to%stress(1:2)) - point%start_stress
         ! Strains conjugate to σ₁, to σ₂ and to shear between both.
         basis(:, 1) = plane_components(u, [1.0_wp, 0.0_wp])
         basis(:, 2) = plane_components(u, [0.0_wp, 1.0_wp])
         basis(:, 3) = [-u(2), u(2), u(1)]
         principal_slope = 0.0_wp
         principal_slope(1:2, 1:2) = to%slope(1:2, 1:2)
         if (circle%radius > 0.0_wp) principal_slope(3, 3) = point%elasticity(3, 3) &
            *0.5_wp*(to%stress(1) - to%stress(2))/circle%radius
         tangent = step%scheme%theta*matmul(basis, matmul(principal_slope, transpose(basis)))
      end associate
   end subroutine find_stress

   !> Find the state at the end of a step, and its losses.
   pure subroutine finish_step(self, point, state, strain, change, step, loss)
      class(mohr_coulomb_solid_type), intent(in) :: self  !< law
      type(strain_point_type), intent(in) :: point        !< at its position
      real(wp), intent(inout) :: state(:)  !< [any] state at the start; on return at the end
      real(wp), intent(in) :: strain(3), change(3)    !< ε at the start, Δε
      type(step_type), intent(in) :: step             !< the present step
      real(wp), intent(out) :: loss(losses)           !< J/m³
      type(circle_type) :: circle
      real(wp) :: elastic(3), flow(3)

      call return_stress(self, point, state, strain + step%scheme%theta*change, circle)
      flow = circle%to%flow/step%scheme%theta
      loss = 0.0_wp
      loss(loss_plastic) = dot_product(circle%to%stress, flow)
      elastic = change
      if (circle%to%yields) then
         associate (own => plane_components(circle%direction, flow(1:2)))
            elastic = change - [own(1), own(2), 2.0_wp*own(3)]
         end associate
         state(plastic) = state(plastic) + change - elastic
         state(across) = state(across) + flow(3)
         state(plastic_measure) = state(plastic_measure) + maxval(flow) - min(0.0_wp, minval(flow))
      end if
      state(mean_stress) = 0.5_wp*(circle%to%stress(1) + circle%to%stress(2))
      loss(loss_scheme) = (step%scheme%theta - 0.5_wp)*double_energy(point, elastic, flow(3))
   end subroutine finish_step

   !> Twice the elastic energy, J/m³: ε^e·Dε^e with −ε^p out of the plane.
   pure real(wp) function double_energy(point, elastic, third)
      type(strain_point_type), intent(in) :: point  !< strain point of the law
      real(wp), intent(in) :: elastic(3), third     !< ε^e in the plane, ε^p out of the plane

      double_energy = dot_product(elastic, matmul(point%elasticity, elastic))
      if (point%plane_strain) double_energy = double_energy + third*(point%elasticity(1, 1)*third &
         - 2.0_wp*point%elasticity(1, 2)*(elastic(1) + elastic(2)))
   end function double_energy

   !> Stored energy ψ, J/m³.
   pure real(wp) function stored(self, point, state, strain)
      class(mohr_coulomb_solid_type), intent(in) :: self  !< law
      type(strain_point_type), intent(in) :: point        !< at its position
      real(wp), intent(in) :: state(:)                    !< [any] state of the point
      real(wp), intent(in) :: strain(3)                   !< ε

      associate (elastic => strain - state(plastic))
         stored = dot_product(elastic, point%start_stress) + 0.5_wp*double_energy(point, elastic, &
            state(across))
         if (point%plane_strain) stored = stored - state(across)*(self%out_of_plane &
            + poisson_ratio(point%elasticity)*sum(point%start_stress(1:2)))
      end associate
   end function stored

   !> Plastic strain κ.
   pure real(wp) function plastic_strain(self, state)
      class(mohr_coulomb_solid_type), intent(in) :: self  !< law
      real(wp), intent(in) :: state(:)                    !< [any] state of a point

      plastic_strain = state(plastic_measure)
   end function plastic_strain

   !> .true., since the law limits stresses.
   pure logical function yields(self)
      class(mohr_coulomb_solid_type), intent(in) :: self  !< law

      yields = .true.
   end function yields

   !> Largest stress of the jumps of a face, Pa: largest radius minus present radius.
   !> Its lower bound is a fraction of the largest radius at the start of a step.
   pure real(wp) function jump_cap(self, point, state, strain)
      class(mohr_coulomb_solid_type), intent(in) :: self  !< law
      type(strain_point_type), intent(in) :: point        !< strain point of the face
      real(wp), intent(in) :: state(:)                    !< [any] state of the point
      real(wp), intent(in) :: strain(3)                   !< ε at the start of a step
      type(circle_type) :: circle
      type(strength_type) :: strength
      real(wp) :: largest_radius

      call return_stress(self, point, state, strain, circle)
      strength = strength_at(self, point, state(plastic_measure))
      associate (mean => 0.5_wp*(circle%to%stress(1) + circle%to%stress(2)))
         largest_radius = min(strength%cohesion*cos(strength%friction) - &
            mean*sin(strength%friction), strength%tension - mean)
         jump_cap = max(0.0_wp, jump_fraction*largest_radius, largest_radius - &
            0.5_wp*(circle%to%stress(1) - circle%to%stress(2)))
      end associate
   end function jump_cap

   !> Stress σ_m ∂det ε^p/∂ε^p: the mean stress works on the change of area, tr ε + det ε.
   !> With the trace only, a shear γ loses γ²/4 of its area, and a pressure p reduces stress by ½pγ.
   pure function shape_stress(self, state) result(stress)
      class(mohr_coulomb_solid_type), intent(in) :: self  !< law
      real(wp), intent(in) :: state(:)                    !< [any] state of the point
      real(wp) :: stress(3)

      stress = state(mean_stress)*[state(2), state(1), -0.5_wp*state(3)]
   end function shape_stress

   !> Pressure −σ_m of the last step, if positive.
   pure real(wp) function pressure(self, state)
      class(mohr_coulomb_solid_type), intent(in) :: self  !< law
      real(wp), intent(in) :: state(:)                    !< [any] state of the point

      pressure = max(0.0_wp, -state(mean_stress))
   end function pressure

   !> Thickness of a point above which its strength falls faster with strain than its stiffness D.
   pure real(wp) function largest_thickness(self, elasticity) result(thickness)
      class(mohr_coulomb_solid_type), intent(in) :: self  !< law
      real(wp), intent(in) :: elasticity(3, 3)            !< D of small strains, Pa
      real(wp) :: shear, tension

      shear = self%peak%cohesion*cos(self%peak%friction) &
         - self%residual%cohesion*cos(self%residual%friction)
      tension = self%peak%tension - self%residual%tension
      thickness = huge(1.0_wp)
      if (self%softening <= 0.0_wp) return
      if (shear > 0.0_wp) thickness = elasticity(3, 3)*self%softening/shear
      if (tension > 0.0_wp) thickness = min(thickness, (elasticity(1, 1) - elasticity(1, 2)**2 &
         /elasticity(2, 2))*self%softening/tension)
   end function largest_thickness

end module dda_mohr_coulomb_solid
