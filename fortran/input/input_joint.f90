! SPDX-License-Identifier: GPL-3.0-or-later
!> The group &joint: strength and stiffness of a joint material by its law.
module dda_input_joint
   use dda_kinds, only: wp
   use dda_barton_bandis, only: closure_of_joint
   use dda_errors, only: error_type
   use dda_input_group, only: place_type, input_error, check_read, place_of_group, require, &
      require_given, require_choice, value_or, unset, is_set, name_length
   use dda_joint_law, only: strength_type
   use dda_joint_laws, only: law_slot_type, new_joint_law
   use dda_material, only: joint_type
   use dda_namelist_groups, only: group_type, split_groups
   use dda_text, only: quoted, to_text
   implicit none
   private
   public :: read_joint, reduced_strengths

contains

   !> &joint
   subroutine read_joint(group, place, new, error)
      character(len=*), intent(in) :: group  !< its text, on one line
      type(place_type), intent(in) :: place  !< of the group
      type(joint_type), intent(out) :: new  !< as the group says
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      character(len=name_length) :: name
      character(len=16) :: law
      real(wp) :: friction_angle, cohesion, tensile_strength, normal_stiffness_per_area, jrc, jcs, &
         shear_stiffness_per_area, residual_friction_angle, residual_cohesion, dilation_angle, &
         residual_tensile_strength, weakening_slip, dilation_slip, compressive_strength, &
         max_closure, strength_reduction, restitution, damping
      character(len=256) :: message
      integer :: status, contact_points
      namelist /joint/ normal_stiffness_per_area, residual_tensile_strength, strength_reduction, &
         shear_stiffness_per_area, residual_friction_angle, compressive_strength, friction_angle, &
         residual_cohesion, tensile_strength, weakening_slip, dilation_angle, contact_points, &
         dilation_slip, max_closure, restitution, cohesion, damping, name, law, jrc, jcs

      name = ''
      law = 'coulomb'
      friction_angle = unset
      cohesion = unset
      tensile_strength = unset
      normal_stiffness_per_area = unset
      shear_stiffness_per_area = unset
      residual_friction_angle = unset
      residual_cohesion = unset
      residual_tensile_strength = unset
      weakening_slip = unset
      dilation_angle = unset
      dilation_slip = unset
      jrc = unset
      jcs = unset
      compressive_strength = unset
      max_closure = unset
      strength_reduction = unset
      restitution = unset
      damping = 0.0_wp
      contact_points = 2
      read (group, nml=joint, iostat=status, iomsg=message)
      call check_read(error, place, status, message)
      call require(error, place, 'friction_angle', [friction_angle])
      if (allocated(error)) return
      new = joint_type(name, friction_angle, law=law, contact_points=contact_points)
      call read_contacts(error, place, new, restitution, damping)
      call read_stiffness(error, place, new, normal_stiffness_per_area, shear_stiffness_per_area)
      call read_law(error, place, new, [cohesion, tensile_strength], [residual_friction_angle, &
         residual_cohesion, residual_tensile_strength, weakening_slip, dilation_angle, &
         dilation_slip], [jrc, jcs, compressive_strength, max_closure, strength_reduction])
   end subroutine read_joint

   !> The variables of a group &joint with which all strength is divided by a factor, as its law
   !> says.
   subroutine reduced_strengths(file, text, factor, strengths, error)
      character(len=*), intent(in) :: file  !< path, for messages
      character(len=*), intent(in) :: text  !< one group &joint
      real(wp), intent(in) :: factor        !< above 0
      type(strength_type), allocatable, intent(out) :: strengths(:)  !< names and values
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      type(group_type), allocatable :: groups(:)
      type(joint_type) :: joint
      type(law_slot_type) :: slot

      allocate (strengths(0))
      call split_groups(file, text, groups, error)
      if (allocated(error)) return
      call read_joint(groups(1)%text, place_of_group(file, groups(1)), joint, error)
      if (allocated(error)) return
      call new_joint_law(slot, joint, 1.0_wp, 1.0_wp)
      strengths = slot%law%reduced(joint, factor)
   end subroutine reduced_strengths

   !> Points of contact, what impacts leave of a velocity, and the dashpot.
   subroutine read_contacts(error, place, new, restitution, damping)
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(place_type), intent(in) :: place  !< of the group
      type(joint_type), intent(inout) :: new  !< with its points, gets the others
      real(wp), intent(in) :: restitution  !< 0 … 1, or unset
      real(wp), intent(in) :: damping  !< N s/m per metre of thickness

      if (all(new%contact_points /= [2, 3, 5])) call input_error(error, place, &
         'contact_points = '//to_text(new%contact_points)//' must be 2, 3 or 5')
      call require(error, place, 'damping', [damping])
      if (is_set(restitution)) call require(error, place, 'restitution', [restitution])
      if (allocated(error)) return
      new%damping = damping
      if (is_set(restitution)) new%restitution = restitution
   end subroutine read_contacts

   !> What the law of the joint has, and nothing of another law.
   subroutine read_law(error, place, new, strength, after, rough)
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(place_type), intent(in) :: place   !< of the group
      type(joint_type), intent(inout) :: new  !< with its law and friction angle
      real(wp), intent(in) :: strength(2)     !< cohesion, tensile strength, as given
      real(wp), intent(in) :: after(6)        !< residual strength, weakening, dilation, as given
      real(wp), intent(in) :: rough(5)        !< JRC, JCS, σ_c, V_m, reduction, as given
      type(law_slot_type) :: slot

      call require_choice(error, place, 'law', new%law)
      if (allocated(error)) return
      call new_joint_law(slot, new, 1.0_wp, 1.0_wp)
      if (.not. allocated(slot%law)) call input_error(error, place, 'law = '// &
         quoted(trim(new%law))//' is not registered in dda_joint_laws')
      if (new%law == 'barton_bandis') then
         call refuse(error, place, new%law, 'coulomb', 'cohesion tensile_strength', strength)
         call read_rough(error, place, new, rough(1), rough(2), rough(3), rough(4))
         call take(error, place, 'strength_reduction', rough(5), 1.0_wp, new%strength_reduction)
      else
         call read_strength(error, place, new, strength(1), strength(2))
         call refuse(error, place, new%law, 'barton_bandis', 'jrc jcs compressive_strength '// &
            'max_closure strength_reduction', rough)
      end if
      if (new%law == 'mohr_coulomb') then
         call read_residual(error, place, new, after(1), after(2), after(3))
         call read_slip(error, place, new, after(4), after(5), after(6))
      else
         call refuse(error, place, new%law, 'mohr_coulomb', 'residual_friction_angle '// &
            'residual_cohesion residual_tensile_strength weakening_slip dilation_angle '// &
            'dilation_slip', after)
      end if
   end subroutine read_law

   !> Numbers of another law must not be given.
   subroutine refuse(error, place, law, owner, names, values)
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(place_type), intent(in) :: place  !< of the group
      character(len=*), intent(in) :: law    !< of the joint
      character(len=*), intent(in) :: owner  !< law that has them
      character(len=*), intent(in) :: names  !< of the variables: 'x y …'
      real(wp), intent(in) :: values(:)      !< one of each, `unset` where not given
      integer :: i, first, last

      first = 1
      do i = 1, size(values)
         last = first + index(names(first:)//' ', ' ') - 2
         if (is_set(values(i))) call input_error(error, place, names(first:last)//' = '// &
            to_text(values(i))//' belongs to law = '//quoted(owner)//', the law here is '// &
            quoted(trim(law))//': change the law or leave it out')
         first = last + 2
      end do
   end subroutine refuse

   !> A number that may be left out: within its limits, else a default.
   subroutine take(error, place, name, value, default, taken)
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(place_type), intent(in) :: place  !< of the group
      character(len=*), intent(in) :: name   !< of the variable
      real(wp), intent(in) :: value          !< `unset` where not given
      real(wp), intent(in) :: default        !< in place of it
      real(wp), intent(out) :: taken         !< one of the two

      call require_given(error, place, name, value)
      taken = value_or(value, default)
   end subroutine take

   !> Stiffness per area, where the joint has its own.
   subroutine read_stiffness(error, place, new, normal, shear)
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(place_type), intent(in) :: place    !< of the group
      type(joint_type), intent(inout) :: new   !< gets them
      real(wp), intent(in) :: normal, shear    !< Pa/m, as given

      call take(error, place, 'normal_stiffness_per_area', normal, 0.0_wp, new%normal_stiffness)
      call take(error, place, 'shear_stiffness_per_area', shear, 0.0_wp, new%shear_stiffness)
   end subroutine read_stiffness

   !> Cohesion and tensile strength; what is left of them where the law says nothing else.
   subroutine read_strength(error, place, new, cohesion, tensile_strength)
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(place_type), intent(in) :: place    !< of the group
      type(joint_type), intent(inout) :: new   !< gets them
      real(wp), intent(in) :: cohesion, tensile_strength  !< Pa, as given

      call take(error, place, 'cohesion', cohesion, 0.0_wp, new%cohesion)
      call take(error, place, 'tensile_strength', tensile_strength, 0.0_wp, new%tensile_strength)
      new%residual_friction_angle = new%friction_angle
   end subroutine read_strength

   !> Residual strength, which is at most the peak strength.
   subroutine read_residual(error, place, new, friction_angle, cohesion, tensile_strength)
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(place_type), intent(in) :: place    !< of the group
      type(joint_type), intent(inout) :: new   !< with its peak strength
      real(wp), intent(in) :: friction_angle, cohesion, tensile_strength  !< degrees, Pa, as given

      call take(error, place, 'residual_friction_angle', friction_angle, new%friction_angle, &
         new%residual_friction_angle)
      call take(error, place, 'residual_cohesion', cohesion, 0.0_wp, new%residual_cohesion)
      call take(error, place, 'residual_tensile_strength', tensile_strength, 0.0_wp, &
         new%residual_tensile_strength)
      call compare('friction_angle', new%residual_friction_angle, new%friction_angle)
      call compare('cohesion', new%residual_cohesion, new%cohesion)
      call compare('tensile_strength', new%residual_tensile_strength, new%tensile_strength)

   contains

      subroutine compare(name, residual, peak)
         character(len=*), intent(in) :: name  !< of the peak's variable
         real(wp), intent(in) :: residual, peak

         if (residual > peak) call input_error(error, place, 'residual_'//name//' = '// &
            to_text(residual)//' is above the peak, '//name//' = '//to_text(peak)// &
            ': a joint does not grow stronger by failing')
      end subroutine compare

   end subroutine read_residual

   !> Weakening and dilation.
   subroutine read_slip(error, place, new, weakening_slip, dilation_angle, dilation_slip)
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(place_type), intent(in) :: place    !< of the group
      type(joint_type), intent(inout) :: new   !< with its strength
      real(wp), intent(in) :: weakening_slip, dilation_angle, dilation_slip  !< as given

      call take(error, place, 'weakening_slip', weakening_slip, 0.0_wp, new%weakening_slip)
      call take(error, place, 'dilation_angle', dilation_angle, 0.0_wp, new%dilation_angle)
      call take(error, place, 'dilation_slip', dilation_slip, huge(1.0_wp), new%dilation_slip)
      if (new%dilation_angle > new%residual_friction_angle) call input_error(error, place, &
         'dilation_angle = '//to_text(new%dilation_angle)//' is above the residual friction '// &
         'angle, '//to_text(new%residual_friction_angle)//': slip would give energy')
      if (is_set(dilation_slip) .and. new%dilation_angle <= 0.0_wp) call input_error(error, &
         place, 'dilation_slip has no meaning without a dilation_angle above 0')
   end subroutine read_slip

   !> Roughness, wall strength and closure of Barton and Bandis.
   subroutine read_rough(error, place, new, jrc, jcs, compressive_strength, max_closure)
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(place_type), intent(in) :: place    !< of the group
      type(joint_type), intent(inout) :: new   !< with its stiffness
      real(wp), intent(in) :: jrc, jcs, compressive_strength, max_closure  !< as given
      logical :: by_closure

      call require(error, place, 'jrc jcs', [jrc, jcs])
      by_closure = new%normal_stiffness > 0.0_wp .and. is_set(max_closure)
      if (is_set(compressive_strength)) then
         call require(error, place, 'compressive_strength', [compressive_strength])
         if (new%normal_stiffness > 0.0_wp .or. is_set(max_closure)) call input_error(error, &
            place, 'compressive_strength gives the closure of the joint: leave it out, or '// &
            'leave out normal_stiffness_per_area and max_closure')
      else if (.not. by_closure) then
         call input_error(error, place, 'the closure of the joint is missing: give '// &
            'normal_stiffness_per_area (k_ni) and max_closure (V_m), or compressive_strength')
      end if
      if (allocated(error)) return
      new%roughness = jrc
      new%wall_strength = jcs
      if (by_closure) then
         call require(error, place, 'max_closure', [max_closure])
         new%max_closure = max_closure
         return
      end if
      call closure_of_joint(jrc, jcs, compressive_strength, new%normal_stiffness, new%max_closure)
      if (.not. min(new%normal_stiffness, new%max_closure) > 0.0_wp) call input_error(error, &
         place, 'jrc = '//to_text(jrc)//', jcs = '//to_text(jcs)//' and compressive_strength '// &
         '= '//to_text(compressive_strength)//' are outside the range of the empirical '// &
         'formulas: they give no positive k_ni and V_m; give normal_stiffness_per_area and '// &
         'max_closure instead')
   end subroutine read_rough

end module dda_input_joint
