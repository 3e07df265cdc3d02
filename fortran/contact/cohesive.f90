! SPDX-License-Identifier: GPL-3.0-or-later
!> Cohesive joint: (1 − D) bond + D contact, with a damage D that never decreases.
!>
!> The bond is linear, k δ.  Its opening g and the slip p of the parallel friction slider are scaled
!> by their values at the strengths, g_0 = T/k_n and p_0 = c/k_s:  λ² = (⟨g⟩/g_0)² + (p/p_0)².
!> Damage begins at λ = 1.  In pure mode I or II the traction then falls to 0,
!>
!> - linearly, (1 − D) λ = (λ_f − λ)/(λ_f − 1), up to λ_f;
!> - exponentially, (1 − D) λ = exp[−(λ − 1)/m], m = (λ_f − 1)/2,
!>
!> where λ_f = G/e, and e is the energy of the bond at λ = 1.  The dissipated energy is then G.
!> In mixed mode the dissipated parts G_n and G_s, in the ratio of the modes in e, satisfy
!> G_n/G_I + G_s/G_II = 1.  For each ratio of the modes the
!> dissipated energy is a function of D, g(D) = ∫ e λ(D)² dD.
module dda_cohesive
   use dda_kinds, only: wp, pi
   use dda_joint_law, only: column_type, joint_law_type, joint_state_type, strength_type
   use dda_group_values, only: unset
   use dda_material, only: joint_type
   use dda_text, only: quoted, to_text
   implicit none
   private
   public :: cohesive_type, new_cohesive, dissipation_bounds

   integer, parameter :: dissipation_bounds(2) = [4, 5] !< columns of its lower and upper bound

   !> smaller fractions of the strength count as zero
   real(wp), parameter :: least_fraction = 1.0e-6_wp
   integer, parameter :: most_steps = 60       !< iterations of Newton's method (monotone)

   !> Strength and fracture energies.
   type, extends(joint_law_type) :: cohesive_type
      real(wp) :: friction = 0.0_wp   !< tan φ
      real(wp) :: strengths(2) = 0.0_wp  !< T, c, Pa
      real(wp) :: energies(2) = 0.0_wp   !< G_I, G_II, N/m
      logical :: exponential = .false.   !< softening is exponential; else linear
   contains
      procedure :: strength, tension, damage, damage_in_step, bond_energy, check_and_derive
   end type cohesive_type

   !> Mixed-mode measure λ of a bond, with its values at failure and at the onset of damage.
   type :: mixture_type
      real(wp) :: measure   !< λ
      real(wp) :: ultimate  !< λ_f
      real(wp) :: onset     !< energy at λ = 1, N/m
   end type mixture_type

contains

   !> Create the law of a joint material, but do not set its stiffness.  All strengths and energies
   !> are reduced by the same factor, so openings and slips at failure do not change.
   pure type(cohesive_type) function new_cohesive(joint) result(law)
      type(joint_type), intent(in) :: joint  !< checked input

      law%friction = tan(joint%friction_angle*pi/180.0_wp)
      law%strengths = [joint%tensile_strength, joint%cohesion]
      law%energies = [joint%fracture_energy, joint%shear_fracture_energy]
      law%exponential = joint%softening == 'exponential'
      law%law_columns(:2) = [column_type('fracture_energy_lower', of_contact=.true.), &
         column_type('fracture_energy_upper', of_contact=.true.)]
      law%cohesive = .true.
      law%inputs = [strength_type('friction_angle', joint%friction_angle, is_angle=.true.), &
         strength_type('cohesion', joint%cohesion), &
         strength_type('tensile_strength', joint%tensile_strength), &
         strength_type('fracture_energy', joint%fracture_energy), &
         strength_type('shear_fracture_energy', joint%shear_fracture_energy)]
      law%points = 3
   end function new_cohesive

   !> Reject fracture energies that do not exceed the elastic energy of the joint at its strength.
   pure subroutine check_and_derive(law, joint, shear_ratio, wrong)
      class(cohesive_type), intent(in) :: law   !< law of the joint
      type(joint_type), intent(inout) :: joint  !< input of the law
      real(wp), intent(in) :: shear_ratio       !< k_n/k_s, if the joint does not set its own
      character(len=:), allocatable, intent(out) :: wrong  !< error message, blank if none
      real(wp) :: shear_stiffness

      wrong = ''
      if (joint%shear_fracture_energy == unset) joint%shear_fracture_energy = &
         10*joint%fracture_energy
      if (.not. min(joint%cohesion, joint%tensile_strength) > 0.0_wp) then
         wrong = 'a joint of law = '//quoted(trim(joint%law))//' needs cohesion and '// &
            'tensile_strength above 0'
         return
      end if
      shear_stiffness = joint%normal_stiffness/shear_ratio
      if (joint%shear_stiffness > 0.0_wp) shear_stiffness = joint%shear_stiffness
      wrong = brittle_text('fracture_energy', joint%fracture_energy, joint%tensile_strength, &
         joint%normal_stiffness)
      if (wrong == '') wrong = brittle_text('shear_fracture_energy', joint%shear_fracture_energy, &
         joint%cohesion, shear_stiffness)

   contains

      !> Return a message if a fracture energy does not exceed the elastic energy at the strength.
      pure function brittle_text(name, energy, strength, stiffness) result(words)
         character(len=*), intent(in) :: name  !< name of the fracture energy in the input
         real(wp), intent(in) :: energy, strength, stiffness !< N/m, Pa, Pa/m
         character(len=:), allocatable :: words

         words = ''
         if (energy <= 0.5_wp*strength**2/stiffness) words = name//' = '//to_text(energy)// &
            ' N/m is not above the energy stored at the strength, '// &
            to_text(0.5_wp*strength**2/stiffness)//' N/m: the joint would break at once; raise '// &
            'the fracture energy, or the stiffness per area'
      end function brittle_text

   end subroutine check_and_derive

   !> Return the largest shear force of the contact in parallel with the bond, N/m.
   pure real(wp) function strength(law, state, normal_force)  ! total
      class(cohesive_type), intent(in) :: law      !< law of the joint
      type(joint_state_type), intent(in) :: state  !< state of the contact
      real(wp), intent(in) :: normal_force         !< compression positive, N/m

      strength = law%friction*max(normal_force, 0.0_wp)
   end function strength

   !> Return the largest tension of an undamaged bond, N/m.
   pure real(wp) function tension(law, state)  ! total
      class(cohesive_type), intent(in) :: law      !< law of the joint
      type(joint_state_type), intent(in) :: state  !< state of the contact

      tension = law%strengths(1)*state%length
   end function tension

   !> Return the damage at an opening and a slip, never less than the earlier damage.
   pure real(wp) function damage(law, opening, slip, before)
      class(cohesive_type), intent(in) :: law  !< law of the joint
      real(wp), intent(in) :: opening, slip    !< m; opening < 0: closed
      real(wp), intent(in) :: before           !< damage at the start of the step
      type(mixture_type) :: mixture
      real(wp) :: integrity

      damage = before
      mixture = mixed_mode(law, opening, slip)
      if (mixture%measure <= 1.0_wp) return
      integrity = max(0.0_wp, mixture%ultimate - mixture%measure)/(mixture%ultimate - 1.0_wp)
      if (law%exponential) then
         integrity = exp(-2*(mixture%measure - 1.0_wp)/(mixture%ultimate - 1.0_wp))
         if (integrity < least_fraction) integrity = 0.0_wp
      end if
      damage = max(before, 1.0_wp - integrity/mixture%measure)
   end function damage

   !> Return the damage D* that acts in a step so that the step dissipates the fracture energy.
   pure real(wp) function damage_in_step(law, opening, slip, before) result(acting)
      class(cohesive_type), intent(in) :: law         !< law of the joint
      real(wp), intent(in) :: opening(2), slip(2)     !< values at the start and end of the step, m
      real(wp), intent(in) :: before                  !< damage at the start of the step
      real(wp) :: after, energy(2), surplus

      acting = before
      after = law%damage(opening(2), slip(2), before)
      if (.not. after > before) return
      energy = [law%bond_energy(opening(1), slip(1)), law%bond_energy(opening(2), slip(2))]
      surplus = energy(2)*(after - before) - dissipated_energy(law, opening(2), slip(2), before, &
         after)
      if (energy(2) > energy(1)) acting = before + max(0.0_wp, min(after - before, &
         surplus/(energy(2) - energy(1))))
   end function damage_in_step

   !> Return the fracture energy, N/m, dissipated by growing damage in the mode of opening and slip.
   pure real(wp) function dissipated_energy(law, opening, slip, from, to) result(dissipated)
      class(cohesive_type), intent(in) :: law  !< law of the joint
      real(wp), intent(in) :: opening, slip    !< m
      real(wp), intent(in) :: from, to         !< damage before and after
      type(mixture_type) :: mixture

      dissipated = 0.0_wp
      if (.not. to > from) return
      mixture = mixed_mode(law, opening, slip)
      dissipated = mixture%onset*(dissipated_fraction(law, mixture%ultimate, to) &
         - dissipated_fraction(law, mixture%ultimate, from))
   end function dissipated_energy

   !> Return the energy of the bond minus the energy of the parallel contact without friction, N/m.
   pure real(wp) function bond_energy(law, opening, slip) result(energy)
      class(cohesive_type), intent(in) :: law  !< law of the joint
      real(wp), intent(in) :: opening, slip    !< m

      energy = 0.5_wp*(law%normal_stiffness*max(opening, 0.0_wp)**2 + law%shear_stiffness*slip**2)
   end function bond_energy

   !> Compute λ, λ_f and e for an opening and a slip.
   pure type(mixture_type) function mixed_mode(law, opening, slip) result(mixture)
      class(cohesive_type), intent(in) :: law  !< law of the joint
      real(wp), intent(in) :: opening, slip    !< m
      real(wp) :: ratios(2), onset(2), mode_fractions(2)

      associate (stiffness => [law%normal_stiffness, law%shear_stiffness])
         ratios = [max(opening, 0.0_wp), abs(slip)]*stiffness/law%strengths
         onset = 0.5_wp*law%strengths**2/stiffness
      end associate
      mixture%measure = norm2(ratios)
      mode_fractions = [1.0_wp, 0.0_wp]
      if (mixture%measure > 0.0_wp) mode_fractions = (ratios/mixture%measure)**2
      mixture%onset = dot_product(mode_fractions, onset)
      mixture%ultimate = 1.0_wp/dot_product(mode_fractions, onset/law%energies)
   end function mixed_mode

   !> Return the dissipated energy g(D) as a fraction of e.
   pure real(wp) function dissipated_fraction(law, ultimate, damage) result(fraction)
      class(cohesive_type), intent(in) :: law  !< law of the joint
      real(wp), intent(in) :: ultimate, damage
      real(wp) :: m, measure, decay

      if (.not. law%exponential .or. damage >= 1.0_wp) then
         fraction = ultimate*damage/(ultimate - damage*(ultimate - 1.0_wp))
         return
      end if
      m = 0.5_wp*(ultimate - 1.0_wp)
      measure = measure_at_damage(m, damage)
      decay = exp(-(measure - 1.0_wp)/m)
      fraction = 1.0_wp + 2*m*(1.0_wp - decay) - measure*decay
   end function dissipated_fraction

   !> Solve λ + m ln λ = 1 − m ln(1 − D) for λ (exponential softening) by Newton's method.
   pure real(wp) function measure_at_damage(m, damage) result(measure)
      real(wp), intent(in) :: m       !< parameter of the softening
      real(wp), intent(in) :: damage  !< D < 1
      real(wp) :: residual
      integer :: i

      measure = 1.0_wp
      do i = 1, most_steps
         residual = measure + m*log(measure) - 1.0_wp + m*log(1.0_wp - damage)
         measure = measure - residual/(1.0_wp + m/measure)
         if (abs(residual) <= 4*epsilon(residual)*(measure + m)) exit
      end do
   end function measure_at_damage

end module dda_cohesive
