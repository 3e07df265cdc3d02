! SPDX-License-Identifier: GPL-3.0-or-later
!> Notes on probable mistakes in a model; they do not prevent a run.
module dda_model_notes
   use dda_kinds, only: wp, pi
   use dda_blocks, only: smaller_side
   use dda_errors, only: error_type, error_interrupted
   use dda_linear_terms, only: linear_terms_type
   use dda_magnitudes, only: magnitude_notes, note_length
   use dda_model, only: model_type, block_label, default_stiffness
   use dda_overburden, only: overburden_type, find_grounded, find_overburden, find_supported
   use dda_repeated_names, only: find_repeated
   use dda_text, only: quoted, short_text, to_text
   use dda_flow, only: flow_steady, flow_transient, flow_undrained
   use dda_scheme, only: scheme_named, scheme_type
   implicit none
   private
   public :: model_notes, note_length, add_notes_to_error

   !> smallest plausible density, kg/m³: below geofoam, above values in g/cm³
   real(wp), parameter :: min_density = 10.0_wp
   !> range of angles in degrees that may be radians; smaller angles are probably intended
   real(wp), parameter :: radians(2) = [0.05_wp, 0.5_wp*pi]
   real(wp), parameter :: max_rounding = 0.01_wp  !< largest relative change of a duration
   real(wp), parameter :: most_strain = 0.02_wp    !< largest strain without a note
   real(wp), parameter :: most_penetration = 0.05_wp  !< largest penetration/smaller side of a block
   real(wp), parameter :: frequency = 1.0_wp  !< frequency of the reported depths in joints, Hz
   real(wp), parameter :: min_spacings = 2.0_wp !< smallest cohesive zone/spacing of contact points
   !> limit of `note_long_steps` over the time step with which the bounds of the fracture energy
   !> differ by at most 10 % if a joint fails suddenly (measured with bars)
   real(wp), parameter :: fine_steps = 20.0_wp

contains

   !> Notes on a model, at most one line of each kind.
   function model_notes(model) result(notes)
      type(model_type), intent(in) :: model  !< model as read from the input
      character(len=note_length), allocatable :: notes(:)

      allocate (notes(0))
      call note_densities(model, notes)
      call note_stiffest(model, notes)
      call note_angles(model, notes)
      call note_durations(model, notes)
      call note_names(model, notes)
      call note_points(model, notes)
      if (model%control%gravity(2) > 0.0_wp) then
         call append_note(notes, 'gravity = '//to_text(model%control%gravity)// &
            ' m/s² points upwards, but weight needs a negative second value')
      else if (norm2(model%control%gravity) > 0.0_wp) then
         call note_weight_effects(model, notes)
      end if
      call note_motions(model, notes)
      call note_softening(model, notes)
      if (allocated(model%flow)) call note_flow(model, notes)
      notes = [character(len=note_length) :: notes, magnitude_notes(model)]
   end function model_notes

   !> Add notes to the error of a run that cannot begin, because they may name its cause.
   subroutine add_notes_to_error(error, notes)
      type(error_type), allocatable, intent(inout) :: error  !< error, if any
      character(len=*), intent(in) :: notes(:)  !< notes on the model
      integer :: i

      if (.not. allocated(error)) return
      if (error%kind == error_interrupted) return
      do i = 1, size(notes)
         error%message = error%message//'; note: '//trim(notes(i))
      end do
   end subroutine add_notes_to_error

   !> Note a material that no block uses, but that determines the default penalty.
   pure subroutine note_stiffest(model, notes)
      type(model_type), intent(in) :: model  !< model as read from the input
      character(len=note_length), allocatable, intent(inout) :: notes(:)  !< notes so far
      integer :: m, s, k

      m = maxloc(model%materials%young_modulus, 1)
      if (any(model%blocks%material == m)) return
      do s = 1, size(model%stages)
         if (.not. allocated(model%stages(s)%material)) cycle
         do k = 1, size(model%stages(s)%material)
            if (k == m) cycle
            if (model%stages(s)%material(k) == m) return
         end do
      end do
      associate (default => default_stiffness(model%materials))
         if (abs(model%contact%normal_stiffness - default) > epsilon(1.0_wp)*default) return
      end associate
      call append_note(notes, 'no block has material '//quoted(trim(model%materials(m)%name))// &
         ', but its young_modulus determines the default of normal_stiffness')
   end subroutine note_stiffest

   !> Note cohesive joints that are not resolved by their points or by the time steps.
   subroutine note_softening(model, notes)
      type(model_type), intent(in) :: model  !< model as read from the input
      character(len=note_length), allocatable, intent(inout) :: notes(:)  !< notes so far
      integer :: j

      do j = 1, size(model%joints)
         if (model%joints(j)%law /= 'cohesive') cycle
         if (.not. any(model%blocks%joint == j)) cycle
         call note_coarse_points(model, j, notes)
         call note_long_steps(model, j, notes)
      end do
   end subroutine note_softening

   !> Append a note to the list.
   pure subroutine append_note(notes, text)
      character(len=note_length), allocatable, intent(inout) :: notes(:)  !< notes so far
      character(len=*), intent(in) :: text  !< a line

      notes = [character(len=note_length) :: notes, text]
   end subroutine append_note

   !> Text ' (and 3 more)' for further cases; blank if there are none.
   pure function more_text(number) result(text)
      integer, intent(in) :: number  !< number of further cases
      character(len=:), allocatable :: text

      text = ''
      if (number > 0) text = ' (and '//to_text(number)//' more)'
   end function more_text

   !> Note densities that may be in g/cm³.
   pure subroutine note_densities(model, notes)
      type(model_type), intent(in) :: model  !< model as read from the input
      character(len=note_length), allocatable, intent(inout) :: notes(:)  !< notes so far
      integer :: first

      first = findloc(model%materials%density < min_density, .true., 1)
      if (first == 0) return
      associate (material => model%materials(first))
         call append_note(notes, 'density = '//to_text(material%density)//' kg/m³ of &material '// &
            quoted(material%name)//more_text(count(model%materials%density < min_density) - 1)// &
            ': is it meant in g/cm³? Water has 1000 kg/m³')
      end associate
   end subroutine note_densities

   !> Note friction angles that may be in radians.
   pure subroutine note_angles(model, notes)
      type(model_type), intent(in) :: model  !< model as read from the input
      character(len=note_length), allocatable, intent(inout) :: notes(:)  !< notes so far
      integer :: first

      associate (angle => model%joints%friction_angle)
         associate (small => angle >= radians(1) .and. angle < radians(2))
            first = findloc(small, .true., 1)
            if (first > 0) call append_note(notes, 'friction_angle = '//to_text(angle(first))// &
               '° of &joint '//quoted(model%joints(first)%name)//more_text(count(small) - 1)// &
               ': is it meant in radians? '//to_text(angle(first))//' rad are '// &
               short_text(angle(first)*180.0_wp/pi)//'°')
         end associate
      end associate
   end subroutine note_angles

   !> Note durations that are not a whole number of steps.
   pure subroutine note_durations(model, notes)
      type(model_type), intent(in) :: model  !< model as read from the input
      character(len=note_length), allocatable, intent(inout) :: notes(:)  !< notes so far
      real(wp) :: length
      integer :: s

      do s = 1, size(model%stages)
         associate (stage => model%stages(s))
            if (.not. stage%duration > 0.0_wp) cycle
            length = real(stage%steps, wp)*stage%time_step
            if (abs(length - stage%duration) <= max_rounding*stage%duration) cycle
            call append_note(notes, 'duration = '//to_text(stage%duration)//' s of stage '// &
               quoted(stage%name)//' is not a multiple of time_step = '// &
               to_text(stage%time_step)//' s, so it is rounded to '//to_text(length)// &
               ' s (steps: '//to_text(stage%steps)//')')
            return
         end associate
      end do
   end subroutine note_durations

   !> Note blocks with equal names, except cells of a body, which have the name of the body.
   pure subroutine note_names(model, notes)
      type(model_type), intent(in) :: model  !< model as read from the input
      character(len=note_length), allocatable, intent(inout) :: notes(:)  !< notes so far
      integer :: first, repeated

      associate (names => pack(model%block_names, model%blocks%body == 0))
         call find_repeated(names, first, repeated)
         if (first == 0) return
         call append_note(notes, to_text(count(names == names(first)))//' blocks are named '// &
            quoted(names(first))//more_text(repeated)//': this name in a list selects all of them')
      end associate
   end subroutine note_names

   !> Note measured points on a common edge or corner of two blocks.
   pure subroutine note_points(model, notes)
      type(model_type), intent(in) :: model  !< model as read from the input
      character(len=note_length), allocatable, intent(inout) :: notes(:)  !< notes so far
      integer :: first

      first = findloc(model%points%other > 0, .true., 1)
      if (first == 0) return
      associate (point => model%points(first))
         call append_note(notes, 'measured point '//quoted(point%name)// &
            more_text(count(model%points%other > 0) - 1)//' lies on '//block_label(model, &
            point%block)//' and '//block_label(model, point%other)// &
            ' and follows the first one; set its variable `block`, or move the point')
      end associate
   end subroutine note_points

   !> Note effects of the weight on a model: unsupported blocks, strains, penetration.
   subroutine note_weight_effects(model, notes)
      type(model_type), intent(in) :: model  !< model with gravity
      character(len=note_length), allocatable, intent(inout) :: notes(:)  !< notes so far
      type(linear_terms_type) :: terms
      type(overburden_type) :: overburden
      logical, allocatable :: on_ground(:), supported(:)
      integer :: first

      call find_grounded(model, on_ground, terms)
      if (.not. any(on_ground)) then
         call append_note(notes, 'nothing supports the blocks against gravity, because no '// &
            '&fixed_point and no &boundary fixes a block in that direction')
         return
      end if
      call find_overburden(model%blocks, model%control%gravity, on_ground, overburden)
      call find_supported(model, on_ground, terms, overburden, supported)
      first = findloc(supported, .false., 1)
      if (first > 0) call append_note(notes, 'nothing supports '//block_label(model, first)// &
         more_text(count(.not. supported) - 1)//' against gravity, and no block is below')
      call note_strain(model, overburden, notes)
      call note_penetration(model, overburden, on_ground, notes)
   end subroutine note_weight_effects

   !> Note the largest strain σ/E due to the weight above a block and half its own weight.
   !> Models with initial stress are excluded, because this stress balances the weight.
   pure subroutine note_strain(model, overburden, notes)
      type(model_type), intent(in) :: model  !< model as read from the input
      type(overburden_type), intent(in) :: overburden  !< weights on all blocks
      character(len=note_length), allocatable, intent(inout) :: notes(:)  !< notes so far
      real(wp) :: stress(model%blocks%n), strain(model%blocks%n)
      integer :: b

      associate (blocks => model%blocks, g => norm2(model%control%gravity))
         if (any(abs(blocks%initial_stress) > 0.0_wp)) return
         stress = (overburden%weight - 0.5_wp*g*blocks%mass)/overburden%width
         strain = stress/model%materials(blocks%material)%young_modulus
         b = maxloc(strain, 1)
         if (strain(b) <= most_strain) return
         call append_note(notes, 'the weight strains '//block_label(model, b)//' by about '// &
            short_text(100*strain(b))//' %, limit '//short_text(100*most_strain)// &
            ' %: '//short_text(stress(b))//' Pa / young_modulus = '// &
            to_text(model%materials(blocks%material(b))%young_modulus)//' Pa')
      end associate
   end subroutine note_strain

   !> Note the largest penetration of a block into a support due to weight.
   !> The penetration is relative to the smaller side of the block.
   pure subroutine note_penetration(model, overburden, on_ground, notes)
      type(model_type), intent(in) :: model  !< model as read from the input
      type(overburden_type), intent(in) :: overburden  !< weights on all blocks
      logical, intent(in) :: on_ground(:)    !< [blocks] supported by the ground
      character(len=note_length), allocatable, intent(inout) :: notes(:)  !< notes so far
      real(wp) :: depth, fraction, largest_fraction
      integer :: b, softest

      if (model%contact%penetration_tolerance > 0.0_wp) return
      if (any(abs(model%blocks%initial_stress) > 0.0_wp)) return
      largest_fraction = most_penetration
      softest = 0
      do b = 1, model%blocks%n
         if (on_ground(b) .or. overburden%n_below(b) == 0) cycle
         fraction = weight_penetration(model, overburden, b)/smaller_side(model%blocks, b)
         if (fraction <= largest_fraction) cycle
         largest_fraction = fraction
         softest = b
      end do
      if (softest == 0) return
      depth = weight_penetration(model, overburden, softest)
      call append_note(notes, 'the weight presses '//block_label(model, softest)//' about '// &
         short_text(depth)//' m into its support, '//short_text(100*largest_fraction)// &
         ' % of its smaller side; contacts with normal_stiffness = '// &
         to_text(model%contact%normal_stiffness)//' N/m, or with its joint stiffness, are soft')
   end subroutine note_penetration

   !> Penetration of block b under the weight on it, m: the smallest value of all edges, with two
   !> contacts per block below or the stiffness per area of the joint.
   pure real(wp) function weight_penetration(model, overburden, b) result(depth)
      type(model_type), intent(in) :: model  !< model as read from the input
      type(overburden_type), intent(in) :: overburden  !< weights on all blocks
      integer, intent(in) :: b               !< number of the block
      real(wp) :: value
      integer :: v

      depth = huge(1.0_wp)
      do v = model%blocks%first(b), model%blocks%first(b + 1) - 1
         associate (joint => model%joints(model%blocks%joint(v)))
            value = overburden%weight(b)/(2*overburden%n_below(b)*model%contact%normal_stiffness)
            if (joint%normal_stiffness > 0.0_wp) value = overburden%weight(b) &
               /(overburden%width(b)*joint%normal_stiffness)
            if (joint%max_closure > 0.0_wp) value = min(value, joint%max_closure)
            depth = min(depth, value)
         end associate
      end do
   end function weight_penetration

   !> Note motions that no support uses.
   pure subroutine note_motions(model, notes)
      type(model_type), intent(in) :: model  !< model as read from the input
      character(len=note_length), allocatable, intent(inout) :: notes(:)  !< notes so far
      logical :: is_used(0:size(model%motions))
      integer :: i

      is_used = .false.
      is_used(model%control%base_motion) = .true.
      do i = 1, size(model%fixed_points)
         is_used(model%fixed_points(i)%motion) = .true.
      end do
      do i = 1, size(model%boundaries)
         is_used(model%boundaries(i)%motion) = .true.
      end do
      i = findloc(is_used(1:), .false., 1)
      if (i > 0) call append_note(notes, '&motion '//quoted(model%motions(i)%name)// &
         more_text(count(.not. is_used(1:)) - 1)//' is not used, because no motion_x, '// &
         'motion_y, base_motion_x or base_motion_y names it')
   end subroutine note_motions

   !> Note missing boundary conditions of water in joints, and channels that are too long.
   !>
   !> A harmonic pressure of angular frequency ω penetrates a joint to the depth √(2c/ω), with the
   !> diffusivity c = a³/(12μ)/(1/k + a/K_w).
   pure subroutine note_flow(model, notes)
      type(model_type), intent(in) :: model  !< model with flow
      character(len=note_length), allocatable, intent(inout) :: notes(:)  !< notes so far
      real(wp) :: depth, longest_channel, joint_depth
      integer :: c

      associate (flow => model%flow)
         if (size(flow%boundary) == 0 .and. any(flow%state == flow_steady)) call append_note( &
            notes, 'water in joints has no given head, pressure or inflow, so steady pressures '// &
            'equal those at the start; add &flow_boundary')
         depth = huge(1.0_wp)
         longest_channel = 0.0_wp
         do c = 1, size(flow%channel)
            joint_depth = pressure_depth(model, c)
            if (joint_depth >= depth) cycle
            depth = joint_depth
            longest_channel = flow%channel(c)%length
         end do
         if (flow%state(2) == flow_transient .and. longest_channel > &
            0.5_wp*depth) call append_note(notes, 'water in joints: pressures of '// &
            short_text(frequency)//' Hz reach '// &
            short_text(depth)//' m into a joint, but a channel is '// &
            short_text(longest_channel)//' m long; give channel_length = '// &
            short_text(0.25_wp*depth)//', or state = ''undrained''')
         if (flow%state(2) == flow_undrained .and. depth > longest_channel) call append_note( &
            notes, 'water in joints: pressures of '//short_text(frequency)//' Hz reach '// &
            short_text(depth)//' m into a joint, past the next node, but state = '// &
            "'undrained' allows no flow between nodes; use state = 'transient'")
      end associate
   end subroutine note_flow

   !> Depth, m, to which a pressure penetrates the joint of channel c.
   pure real(wp) function pressure_depth(model, c) result(depth)
      type(model_type), intent(in) :: model  !< model with flow
      integer, intent(in) :: c               !< channel
      real(wp) :: stiffness, diffusivity

      associate (channel => model%flow%channel(c), law => &
         model%flow%law(model%flow%channel(c)%law), joint => &
         model%joints(model%blocks%joint(model%flow%channel(c)%edge)))
         stiffness = joint%normal_stiffness
         if (.not. stiffness > 0.0_wp) stiffness = 2*model%contact%normal_stiffness/channel%length
         diffusivity = law%aperture**3/(12.0_wp*law%viscosity) &
            /(1.0_wp/stiffness + law%aperture/law%bulk_modulus)
         depth = sqrt(diffusivity/(pi*frequency))
      end associate
   end function pressure_depth

   !> Note a cohesive joint whose zone E'G/T² has fewer than three contact points.
   pure subroutine note_coarse_points(model, j, notes)
      type(model_type), intent(in) :: model  !< model as read from the input
      integer, intent(in) :: j               !< joint
      character(len=note_length), allocatable, intent(inout) :: notes(:)  !< notes so far
      integer, parameter :: choices(3) = [5, 9, 17]  ! numbers of points above the default
      real(wp) :: zone, spacing
      character(len=:), allocatable :: remedy
      integer :: choice

      remedy = 'smaller blocks'
      associate (joint => model%joints(j))
         zone = minval(model%materials%young_modulus)*joint%fracture_energy &
            /joint%tensile_strength**2
         spacing = longest_edge(model, j)/(joint%contact_points - 1)
         if (zone >= min_spacings*spacing) return
         choice = findloc(zone*(choices - 1) >= min_spacings*longest_edge(model, j), .true., 1)
         if (choice > 0) remedy = 'contact_points = '//to_text(choices(choice))//' or '//remedy
         call append_note(notes, 'the cohesive zone EG/T² of joint '//quoted(trim(joint%name))// &
            ' is '//short_text(zone)//' m long, but its contact points are up to '// &
            short_text(spacing)//' m apart, so the strength depends on the size of the blocks; '// &
            'try '//remedy)
      end associate
   end subroutine note_coarse_points

   !> Note a cohesive joint that softens faster than inertia can resist within a step.
   !> Condition: M/(χΔt²) < T²/(2G) with the two lightest blocks.
   pure subroutine note_long_steps(model, j, notes)
      type(model_type), intent(in) :: model  !< model as read from the input
      integer, intent(in) :: j               !< joint
      character(len=note_length), allocatable, intent(inout) :: notes(:)  !< notes so far
      type(scheme_type) :: scheme
      real(wp) :: slope, limit

      scheme = scheme_named(model%control%integration, model%control%theta)
      associate (joint => model%joints(j))
         slope = 0.5_wp*max(joint%tensile_strength**2/joint%fracture_energy, &
            joint%cohesion**2/joint%shear_fracture_energy)
         if (joint%softening == 'exponential') slope = 2*slope
         limit = sqrt(0.5_wp*min_mass(model, j)/(scheme%chi*slope))
         if (model%control%time_step <= limit) return
         call append_note(notes, 'joint '//quoted(trim(joint%name))//' softens within a step '// &
            'of time_step = '//short_text(model%control%time_step)//' s: above '// &
            short_text(limit)//' s the time of failure depends on time_step; below '// &
            short_text(limit/fine_steps)//' s the bounds of its fracture energy differ by at '// &
            'most 10 %, even in sudden failure')
      end associate
   end subroutine note_long_steps

   !> Length of the longest edge with joint j, m.
   pure real(wp) function longest_edge(model, j) result(length)
      type(model_type), intent(in) :: model  !< model as read from the input
      integer, intent(in) :: j               !< joint
      integer :: v

      length = 0.0_wp
      associate (blocks => model%blocks)
         do v = 1, size(blocks%owner)
            if (blocks%joint(v) == j) length = max(length, &
               norm2(blocks%reference(:, blocks%next(v)) - blocks%reference(:, v)))
         end do
      end associate
   end function longest_edge

   !> Smallest block mass per length of edge with joint j, kg/m².
   pure real(wp) function min_mass(model, j) result(mass)
      type(model_type), intent(in) :: model  !< model as read from the input
      integer, intent(in) :: j               !< joint
      integer :: v

      mass = huge(1.0_wp)
      associate (blocks => model%blocks)
         do v = 1, size(blocks%owner)
            if (blocks%joint(v) == j) mass = min(mass, blocks%mass(blocks%owner(v)) &
               /norm2(blocks%reference(:, blocks%next(v)) - blocks%reference(:, v)))
         end do
      end associate
   end function min_mass

end module dda_model_notes
