! SPDX-License-Identifier: GPL-3.0-or-later
!> The group &material: elasticity by moduli or by wave velocities, and damping.
module dda_input_material
   use dda_kinds, only: wp
   use dda_blocks, only: set_damping
   use dda_damping, only: damping_type, fit_body, has_body, highest_relaxation, set_rayleigh
   use dda_errors, only: error_type
   use dda_input_group, only: place_type, place_of_group, input_error, check_read, require, &
      require_list, unset, is_set, name_length
   use dda_material, only: material_type, set_velocities
   use dda_model, only: model_type
   use dda_namelist_groups, only: group_type
   use dda_scheme, only: scheme_type, scheme_named
   use dda_text, only: to_text
   implicit none
   private
   public :: read_material, fit_materials

   real(wp), parameter :: default_reference = 1.0_wp  !< Hz

   !> What the group says of damping.
   type :: damping_input_type
      real(wp) :: ratio = unset, reference = unset, alpha = unset, beta = unset, mechanisms = unset
      real(wp) :: band(2) = unset, rayleigh(2) = unset
   end type damping_input_type

contains

   !> &material
   subroutine read_material(group, place, new, error)
      character(len=*), intent(in) :: group  !< its text, on one line
      type(place_type), intent(in) :: place  !< of the group
      type(material_type), intent(out) :: new  !< as the group says
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      character(len=name_length) :: name
      real(wp) :: density, young_modulus, poisson_ratio, initial_stress(3), initial_velocity(3)
      real(wp) :: shear_velocity, pressure_velocity, damping_ratio, reference_frequency
      real(wp) :: damping_band(2), mechanisms, rayleigh_alpha, rayleigh_beta
      real(wp) :: rayleigh_frequencies(2)
      character(len=256) :: message
      integer :: status
      namelist /material/ name, density, young_modulus, poisson_ratio, initial_stress, &
         initial_velocity, shear_velocity, pressure_velocity, damping_ratio, &
         reference_frequency, damping_band, mechanisms, rayleigh_alpha, rayleigh_beta, &
         rayleigh_frequencies

      name = ''
      density = unset
      young_modulus = unset
      poisson_ratio = unset
      shear_velocity = unset
      pressure_velocity = unset
      initial_stress = 0.0_wp
      initial_velocity = 0.0_wp
      damping_ratio = unset
      reference_frequency = unset
      damping_band = unset
      mechanisms = unset
      rayleigh_alpha = unset
      rayleigh_beta = unset
      rayleigh_frequencies = unset
      read (group, nml=material, iostat=status, iomsg=message)
      call check_read(error, place, status, message)

      call require(error, place, 'density', [density])
      call require_list(error, place, 'initial_stress', initial_stress)
      call require_list(error, place, 'initial_velocity', initial_velocity)
      new%name = name
      new%density = density
      new%initial_stress = initial_stress
      new%initial_velocity = initial_velocity
      call take_elasticity(error, place, young_modulus, poisson_ratio, shear_velocity, &
         pressure_velocity, new)
      call take_damping(error, place, damping_input_type(damping_ratio, reference_frequency, &
         rayleigh_alpha, rayleigh_beta, mechanisms, damping_band, rayleigh_frequencies), &
         new%damping)
   end subroutine read_material

   !> Young's modulus and Poisson's ratio, or the velocities of S and P waves.
   subroutine take_elasticity(error, place, young, poisson, shear, pressure, new)
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(place_type), intent(in) :: place  !< of the group
      real(wp), intent(in) :: young, poisson, shear, pressure  !< as read
      type(material_type), intent(inout) :: new  !< has its density

      if (is_set(shear) .neqv. is_set(pressure)) call input_error(error, place, &
         'shear_velocity and pressure_velocity must be given together')
      if (.not. is_set(shear)) then
         call require(error, place, 'young_modulus poisson_ratio', [young, poisson])
         new%young_modulus = young
         new%poisson_ratio = poisson
         return
      end if
      if (is_set(young) .or. is_set(poisson)) call input_error(error, place, &
         'give young_modulus and poisson_ratio, or shear_velocity and pressure_velocity, not both')
      call require(error, place, 'shear_velocity pressure_velocity', [shear, pressure])
      if (allocated(error)) return
      if (pressure <= shear) then
         call input_error(error, place, 'pressure_velocity = '//to_text(pressure)// &
            ' m/s must be above shear_velocity = '//to_text(shear)//' m/s')
         return
      end if
      call set_velocities(new, shear, pressure)
      call check_derived(error, place, new)
   end subroutine take_elasticity

   !> Moduli that follow from velocities must be ones that could have been given.
   subroutine check_derived(error, place, new)
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(place_type), intent(in) :: place  !< of the group
      type(material_type), intent(in) :: new  !< with moduli from velocities
      type(error_type), allocatable :: failure

      call require(failure, place, 'young_modulus poisson_ratio', [new%young_modulus, &
         new%poisson_ratio])
      if (allocated(failure)) call input_error(error, place, &
         'shear_velocity and pressure_velocity give young_modulus = '// &
         to_text(new%young_modulus)//' Pa and poisson_ratio = '//to_text(new%poisson_ratio)// &
         ': '//failure%message(index(failure%message, '): ') + 3:))
   end subroutine check_derived

   !> A damping ratio at all frequencies, or Rayleigh damping.
   subroutine take_damping(error, place, input, damping)
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(place_type), intent(in) :: place  !< of the group
      type(damping_input_type), intent(in) :: input  !< as read
      type(damping_type), intent(inout) :: damping   !< as asked for, not fitted yet
      logical :: of_body

      of_body = is_set(input%reference) .or. any(is_set(input%band)) .or. is_set(input%mechanisms)
      if (is_set(input%alpha) .or. is_set(input%beta)) then
         if (is_set(input%ratio) .or. any(is_set(input%rayleigh)) .or. of_body) &
            call input_error(error, place, 'give rayleigh_alpha and rayleigh_beta, or '// &
            'damping_ratio, not both')
         if (is_set(input%alpha)) call require(error, place, 'rayleigh_alpha', [input%alpha])
         if (is_set(input%beta)) call require(error, place, 'rayleigh_beta', [input%beta])
         if (is_set(input%alpha)) damping%alpha = input%alpha
         if (is_set(input%beta)) damping%beta = input%beta
         return
      end if
      if (.not. is_set(input%ratio)) then
         if (of_body .or. any(is_set(input%rayleigh))) call input_error(error, place, &
            'damping_ratio is missing: reference_frequency, damping_band, mechanisms and '// &
            'rayleigh_frequencies say how it is meant')
         return
      end if
      call require(error, place, 'damping_ratio', [input%ratio])
      if (any(is_set(input%rayleigh))) then
         if (of_body) call input_error(error, place, 'reference_frequency, damping_band and '// &
            'mechanisms belong to a damping ratio at all frequencies: leave them out, or '// &
            'rayleigh_frequencies')
         call check_band(error, place, 'rayleigh_frequencies', input%rayleigh)
         if (.not. allocated(error)) call set_rayleigh(damping, input%ratio, input%rayleigh)
      else
         call take_body(error, place, input, damping)
      end if
   end subroutine take_damping

   !> What a generalised Maxwell body is fitted to.
   subroutine take_body(error, place, input, damping)
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(place_type), intent(in) :: place  !< of the group
      type(damping_input_type), intent(in) :: input  !< as read
      type(damping_type), intent(inout) :: damping   !< as asked for, not fitted yet

      damping%ratio = input%ratio
      damping%reference = default_reference
      if (is_set(input%reference)) then
         call require(error, place, 'reference_frequency', [input%reference])
         damping%reference = input%reference
      end if
      if (any(is_set(input%band))) then
         call check_band(error, place, 'damping_band', input%band)
         damping%band = input%band
      end if
      if (is_set(input%mechanisms)) then
         call require(error, place, 'mechanisms', [input%mechanisms])
         damping%n = nint(input%mechanisms)
         if (abs(damping%n - input%mechanisms) > 0.0_wp) call input_error(error, place, &
            'mechanisms = '//to_text(input%mechanisms)//' must be a whole number')
      end if
   end subroutine take_body

   !> Two frequencies, ascending.
   subroutine check_band(error, place, name, band)
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(place_type), intent(in) :: place  !< of the group
      character(len=*), intent(in) :: name   !< of the variable
      real(wp), intent(in) :: band(2)        !< Hz, as read

      call require_list(error, place, name, band)
      if (.not. allocated(error) .and. band(2) <= band(1)) call input_error(error, place, name// &
         ' = '//to_text(band(1))//', '//to_text(band(2))//' must ascend')
   end subroutine check_band

   !> Fit the bodies of all materials to what the time steps of all stages admit, and give them to
   !> the blocks.
   subroutine fit_materials(model, file, groups, error)
      type(model_type), intent(inout) :: model  !< with its stages
      character(len=*), intent(in) :: file  !< path
      type(group_type), intent(in) :: groups(:)  !< of the input, in its order
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      type(error_type), allocatable :: failure
      type(scheme_type) :: scheme
      real(wp) :: limit
      integer :: i, m

      limit = huge(1.0_wp)
      do i = 1, size(model%stages)
         associate (stage => model%stages(i))
            if (stage%static) cycle
            scheme = scheme_named(stage%integration, stage%theta)
            limit = min(limit, highest_relaxation(scheme%theta, stage%time_step))
         end associate
      end do
      m = 0
      do i = 1, size(groups)
         if (groups(i)%name /= 'material') cycle
         m = m + 1
         if (.not. has_body(model%materials(m)%damping)) cycle
         call fit_body(model%materials(m)%damping, limit, failure)
         if (.not. allocated(failure)) cycle
         call input_error(error, place_of_group(file, groups(i)), failure%message)
         return
      end do
      call set_damping(model%blocks, model%materials%damping)
   end subroutine fit_materials

end module dda_input_material
