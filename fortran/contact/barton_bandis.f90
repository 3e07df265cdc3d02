! SPDX-License-Identifier: GPL-3.0-or-later
!> Barton–Bandis joint: hyperbolic closure, and shear strength from roughness and wall strength.
!>
!> Normal stress σ = k_ni x/(1 − x/V_m), with the potential k_ni V_m [−V_m ln(1 − x/V_m) − x] and
!> the slope k_ni (1 − x/V_m)⁻².  Shear strength σ tan[φ_r + JRC log₁₀(JCS/σ)]; the bracket is
!> limited to φ_r … 70° [Barton and Choubey, 1977; Bandis, Lumsden and Barton, 1983].  Beyond
!> 100 JCS, more than any joint wall can support, the stress follows the tangent of the hyperbola,
!> so that stress and slope exist at any closure and rounding of coordinates has little effect.
module dda_barton_bandis
   use dda_kinds, only: wp, pi
   use dda_joint_law, only: joint_law_type, joint_state_type, strength_type
   use dda_group_values, only: unset
   use dda_material, only: joint_type
   use dda_text, only: to_text
   implicit none
   private
   public :: barton_bandis_type, new_barton_bandis, closure_of_joint

   real(wp), parameter :: steepest = 70.0_wp      !< largest angle of the shear strength, degrees
   real(wp), parameter :: most_stress = 100.0_wp  !< stress/JCS at the end of the hyperbola
   real(wp), parameter :: small = 1.0e-2_wp       !< x/V_m below which a series is more accurate
   real(wp), parameter :: mega = 1.0e6_wp, milli = 1.0e-3_wp

   !> Hyperbolic closure and rough shear strength.
   type, extends(joint_law_type) :: barton_bandis_type
      real(wp) :: max_closure = 1.0_wp     !< V_m, m
      real(wp) :: roughness = 0.0_wp       !< JRC
      real(wp) :: wall_strength = 1.0_wp   !< JCS, Pa
      real(wp) :: residual_angle = 0.0_wp  !< φ_r, degrees
      real(wp) :: reduction = 1.0_wp       !< divisor of the shear strength
   contains
      procedure :: normal_force, tangent, closure, stored, strength, reduced_strengths, &
         check_and_derive
      procedure, private :: last_closure
   end type barton_bandis_type

contains

   !> Create the law of a joint material, but do not set its stiffness.
   pure type(barton_bandis_type) function new_barton_bandis(joint) result(law)
      type(joint_type), intent(in) :: joint  !< checked input

      law%curved = .true.
      law%max_closure = joint%max_closure
      law%roughness = joint%jrc
      law%wall_strength = joint%jcs
      law%residual_angle = joint%friction_angle
      law%reduction = joint%strength_reduction
   end function new_barton_bandis

   !> Compute the closure parameters k_ni and V_m, if the input lacks them, from joint indices.
   pure subroutine check_and_derive(law, joint, shear_ratio, wrong)
      class(barton_bandis_type), intent(in) :: law  !< law of the joint
      type(joint_type), intent(inout) :: joint      !< input of the law
      real(wp), intent(in) :: shear_ratio           !< k_n/k_s
      character(len=:), allocatable, intent(out) :: wrong  !< error message, blank if none

      wrong = ''
      associate (stiffness => joint%normal_stiffness, closure => joint%max_closure)
         if (joint%compressive_strength == unset) return
         call closure_of_joint(joint%jrc, joint%jcs, joint%compressive_strength, stiffness, closure)
         if (.not. min(stiffness, closure) > 0.0_wp) wrong = 'jrc = '//to_text(joint%jrc)// &
            ', jcs = '//to_text(joint%jcs)//' and compressive_strength = '// &
            to_text(joint%compressive_strength)//' are outside the range of the empirical '// &
            'formulas: they give no positive k_ni and V_m; give normal_stiffness_per_area and '// &
            'max_closure instead'
      end associate
   end subroutine check_and_derive

   !> Compute the initial stiffness k_ni and the largest closure V_m from joint indices.
   !> The formulas of Bandis, Lumsden and Barton (1983) are in MPa/mm and mm.
   !> The aperture is a_j = JRC/5 (0.2 σ_c/JCS − 0.1) mm.
   pure subroutine closure_of_joint(roughness, wall_strength, rock_strength, stiffness, max_closure)
      real(wp), intent(in) :: roughness      !< JRC
      real(wp), intent(in) :: wall_strength  !< JCS, Pa
      real(wp), intent(in) :: rock_strength  !< σ_c, Pa
      real(wp), intent(out) :: stiffness     !< k_ni, Pa/m; may be negative
      real(wp), intent(out) :: max_closure   !< V_m, m; may be negative
      real(wp) :: aperture, ratio

      aperture = roughness/5.0_wp*(0.2_wp*rock_strength/wall_strength - 0.1_wp)
      stiffness = -1.0_wp
      max_closure = -1.0_wp
      if (aperture <= 0.0_wp) return
      ratio = wall_strength/mega/aperture
      stiffness = (-7.15_wp + 1.75_wp*roughness + 0.02_wp*ratio)*mega/milli
      max_closure = (-0.296_wp - 0.0056_wp*roughness + 2.241_wp*ratio**(-0.245_wp))*milli
   end subroutine closure_of_joint

   !> Return the closure at the end of the hyperbola, m.
   pure real(wp) function last_closure(law, state) result(last)
      class(barton_bandis_type), intent(in) :: law !< law of the joint
      type(joint_state_type), intent(in) :: state  !< state of the contact
      real(wp) :: force

      force = most_stress*law%wall_strength*state%length
      last = force/(law%initial_spring(state) + force/law%max_closure)
   end function last_closure

   !> Return the normal force, N/m; beyond the end of the hyperbola it follows the tangent.
   pure real(wp) function normal_force(law, state, closure) result(force)
      class(barton_bandis_type), intent(in) :: law !< law of the joint
      type(joint_state_type), intent(in) :: state  !< state of the contact
      real(wp), intent(in) :: closure              !< m
      real(wp) :: x

      x = min(closure, law%last_closure(state))
      force = law%initial_spring(state)*x/(1.0_wp - max(x, 0.0_wp)/law%max_closure) &
         + law%tangent(state, x)*(closure - x)
   end function normal_force

   !> Return the slope of the normal force, N/m.
   pure real(wp) function tangent(law, state, closure)
      class(barton_bandis_type), intent(in) :: law !< law of the joint
      type(joint_state_type), intent(in) :: state  !< state of the contact
      real(wp), intent(in) :: closure              !< m
      real(wp) :: x

      x = max(0.0_wp, min(closure, law%last_closure(state)))
      tangent = law%initial_spring(state)/(1.0_wp - x/law%max_closure)**2
   end function tangent

   !> Return the closure for a given normal force, m.
   pure real(wp) function closure(law, state, force)
      class(barton_bandis_type), intent(in) :: law !< law of the joint
      type(joint_state_type), intent(in) :: state  !< state of the contact
      real(wp), intent(in) :: force                !< compression positive, N/m

      real(wp) :: beyond

      beyond = max(0.0_wp, force - most_stress*law%wall_strength*state%length)
      associate (on_curve => force - beyond)
         closure = on_curve/(law%initial_spring(state) + max(on_curve, 0.0_wp)/law%max_closure)
      end associate
      if (beyond > 0.0_wp) closure = closure + beyond/law%tangent(state, closure)
   end function closure

   !> Return the potential of the normal force, J per metre of thickness.
   pure real(wp) function stored(law, state, closure) result(energy)
      class(barton_bandis_type), intent(in) :: law !< law of the joint
      type(joint_state_type), intent(in) :: state  !< state of the contact
      real(wp), intent(in) :: closure              !< m
      real(wp) :: x, u, beyond

      x = min(closure, law%last_closure(state))
      beyond = closure - x
      u = x/law%max_closure
      if (u <= 0.0_wp) then
         energy = 0.5_wp*u**2
      else if (u < small) then
         energy = u**2*(1.0_wp/2 + u*(1.0_wp/3 + u*(1.0_wp/4 + u*(1.0_wp/5 + u*(1.0_wp/6 &
            + u*(1.0_wp/7 + u*(1.0_wp/8 + u/9)))))))
      else
         energy = -log(1.0_wp - u) - u
      end if
      energy = law%initial_spring(state)*law%max_closure**2*energy
      if (beyond > 0.0_wp) energy = energy + beyond*(law%normal_force(state, x) &
         + 0.5_wp*law%tangent(state, x)*beyond)
   end function stored

   !> Return the largest shear force, N/m.
   pure real(wp) function strength(law, state, normal_force)  ! total
      class(barton_bandis_type), intent(in) :: law !< law of the joint
      type(joint_state_type), intent(in) :: state  !< state of the contact
      real(wp), intent(in) :: normal_force         !< compression positive, N/m
      real(wp) :: angle

      strength = 0.0_wp
      if (normal_force <= 0.0_wp) return
      angle = law%residual_angle + law%roughness &
         *max(0.0_wp, log10(law%wall_strength*state%length/normal_force))
      angle = max(law%residual_angle, min(steepest, angle))
      strength = normal_force*tan(angle*pi/180.0_wp)/law%reduction
   end function strength

   !> Return the shear strength, divided by a reduction factor.
   pure function reduced_strengths(law, factor) result(strengths)
      class(barton_bandis_type), intent(in) :: law  !< law of the joint
      real(wp), intent(in) :: factor                !< above 0
      type(strength_type), allocatable :: strengths(:)

      strengths = [strength_type('strength_reduction', factor*law%reduction)]
   end function reduced_strengths

end module dda_barton_bandis
