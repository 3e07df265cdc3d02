! SPDX-License-Identifier: GPL-3.0-or-later
!> Verdict on a run: events, largest values and warnings, from the maxima of the run and from the
!> samples of measured points and joints.
module dda_run_verdict
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
   use dda_kinds, only: wp
   use dda_base_motion, only: base_text, has_reference_motion
   use dda_check_report, only: first_mode, ringing_topic
   use dda_diagnostics, only: audit_warning, doubt_state
   use dda_doubts, only: add_doubt, add_doubts, doubt_type
   use dda_elements, only: body_energies
   use dda_energy, only: energy_residual
   use dda_equilibrium, only: find_farthest_block
   use dda_output_schema
   use dda_point_intensity, only: intensity_type, new_intensity, add_motion, arias_intensity, &
      unfiltered, low_passed
   use dda_resolved_band, only: resolved_frequency
   use dda_response_spectrum, only: low_passed_peaks, find_spectral_accelerations, motions
   use dda_rest_bound, only: is_at_rest
   use dda_running_maxima, only: min_movement
   use dda_simulation, only: simulation_type, ending, gravity_is_sudden
   use dda_text, only: counted, to_text, short_text, valid_text
   use dda_verdict_lines, only: verdict_lines_type, add_sentence, add_value, add_figure, value_text
   implicit none
   private
   public :: run_verdict_type, new_verdict, add_samples, add_joint_samples, judge_movement, conclude

   real(wp), parameter :: rounding = 1.0e-9_wp   !< rounding error/largest value
   !> smallest ratio of the smaller to the larger value shown
   real(wp), parameter :: min_shown_ratio = 0.01_wp
   character(len=1), parameter :: axes(2) = ['x', 'y']
   !> smallest reported unresolved fraction of Arias intensity
   real(wp), parameter :: min_excess = 0.05_wp

   !> Verdict that is being computed.
   type, extends(verdict_lines_type) :: run_verdict_type
      real(wp) :: frequency = 0.0_wp         !< frequency below which accelerations are reported, Hz
      type(intensity_type), allocatable :: intensity(:)  !< [measured points]
      real(wp), allocatable :: joints(:,:)  !< [measured joints, columns] values of the last sample
      real(wp), allocatable :: largest_joints(:,:)     !< [joints, columns] largest absolute value
   end type run_verdict_type

contains

   !> Verdict before the first sample.
   pure type(run_verdict_type) function new_verdict(simulation, points, joints) result(verdict)
      type(simulation_type), intent(in) :: simulation  !< run at its start
      integer, intent(in) :: points, joints            !< number of measured points, joints

      verdict%events = ''
      verdict%frequency = resolved_frequency(simulation%model, simulation%blocks)
      allocate (verdict%values(0), verdict%figures(0), verdict%doubts(0))
      allocate (verdict%intensity(points), source=new_intensity(verdict%frequency))
      allocate (verdict%joints(joints, columns_of(in_measured_joints)), &
         verdict%largest_joints(joints, columns_of(in_measured_joints)), source=0.0_wp)
   end function new_verdict

   !> Add samples in the order of the run.
   pure subroutine add_samples(verdict, time, velocity, acceleration)
      type(run_verdict_type), intent(inout) :: verdict   !< verdict of the samples so far
      real(wp), intent(in) :: time(:)                    !< [samples] s
      real(wp), intent(in) :: velocity(:,:)              !< [2 × points, samples] m/s
      real(wp), intent(in) :: acceleration(:,:)          !< [2 × points, samples] m/s²
      integer :: i

      do i = 1, size(verdict%intensity)
         call add_motion(verdict%intensity(i), time, velocity(2*i - 1:2*i, :), &
            acceleration(2*i - 1:2*i, :))
      end do
   end subroutine add_samples

   !> Add samples of the measured joints.
   pure subroutine add_joint_samples(verdict, values)
      type(run_verdict_type), intent(inout) :: verdict   !< verdict of the samples so far
      real(wp), intent(in) :: values(:,:)                !< [joints × columns, samples]
      integer :: sample, i, n

      n = size(verdict%joints, 1)
      do sample = 1, size(values, 2)
         do i = 1, size(verdict%joints, 2)
            verdict%joints(:, i) = values(n*(i - 1) + 1:n*i, sample)
         end do
         verdict%largest_joints = max(verdict%largest_joints, abs(verdict%joints))
      end do
   end subroutine add_joint_samples

   !> Complete the verdict of a run after its last sample.
   subroutine conclude(verdict, simulation)
      type(run_verdict_type), intent(inout) :: verdict   !< verdict of all samples
      type(simulation_type), intent(in) :: simulation  !< simulation at the time of the last sample
      logical :: with_table
      integer :: i

      call judge_movement(verdict, simulation)
      with_table = size(simulation%model%motions) > 0
      if (with_table) with_table = .not. is_without_movement(simulation)
      do i = 1, size(verdict%intensity)
         call judge_point(verdict, simulation, i, with_table)
      end do
      call judge_joints(verdict, simulation)
      call add_value(verdict, 'energy_balance_j_m', energy_residual(simulation%energy))
   end subroutine conclude

   !> Add events, the largest values of all steps, and warnings.
   subroutine judge_movement(verdict, simulation)
      type(run_verdict_type), intent(inout) :: verdict   !< words, figures and values are added
      type(simulation_type), intent(in) :: simulation    !< simulation at its present time
      character(len=:), allocatable :: warning
      integer :: i

      associate (maxima => simulation%maxima)
         do i = 1, size(maxima_table)
            if (maxima%largest(i)%value >= 0.0_wp) call add_value(verdict, 'largest_'// &
               trim(maxima_table(i)%number), maxima%largest(i)%value)
            if (maxima%last(i)%value >= 0.0_wp) call add_value(verdict, 'residual_'// &
               trim(maxima_table(i)%number), maxima%last(i)%value)
         end do
      end associate
      call add_movement_sentence(verdict, simulation)
      call tabulate_maxima(verdict, simulation)
      call add_doubts(verdict%doubts, remaining_doubts(simulation))
      call doubt_state(simulation, verdict%doubts)
      if (gravity_is_sudden(simulation%model)) call add_doubt(verdict%doubts, 'start', &
         'gravity acted suddenly from the first step; settle = .true. begins in static equilibrium')
      warning = audit_warning(simulation)
      if (warning /= '') call add_doubt(verdict%doubts, 'energy', warning)
   end subroutine judge_movement

   !> Warnings of the check before the run that are still relevant after the run.
   !> Without motion, ringing and the first mode are irrelevant.  If many contacts have slipped or
   !> opened, the first mode is irrelevant.
   pure function remaining_doubts(simulation) result(doubts)
      type(simulation_type), intent(in) :: simulation    !< simulation at its present time
      type(doubt_type), allocatable :: doubts(:)
      logical :: at_rest, mode_is_irrelevant, irrelevant
      integer :: i

      at_rest = is_without_movement(simulation)
      associate (moved => simulation%maxima%moved)
         mode_is_irrelevant = 2*(moved(2) + moved(3)) > moved(1)
      end associate
      allocate (doubts(0))
      do i = 1, size(simulation%doubts)
         associate (doubt => simulation%doubts(i))
            irrelevant = doubt%topic == first_mode .and. (at_rest .or. mode_is_irrelevant)
            irrelevant = irrelevant .or. (doubt%topic == ringing_topic .and. at_rest)
            if (.not. (irrelevant .and. doubt%of_check)) call add_doubts(doubts, [doubt])
         end associate
      end do
   end function remaining_doubts

   !> Add the sentence on movement of blocks, contacts and bonds, and on the end of the run.
   subroutine add_movement_sentence(verdict, simulation)
      type(run_verdict_type), intent(inout) :: verdict   !< words and values are added
      type(simulation_type), intent(in) :: simulation    !< simulation at its present time
      character(len=:), allocatable :: reference_text
      integer :: counts(3)

      counts = simulation%maxima%moved
      if (is_without_movement(simulation)) then
         call add_sentence(verdict, 'The model is at rest')
      else
         associate (largest => simulation%maxima%largest(of_displacement))
            reference_text = ''
            if (has_reference_motion(simulation%maxima%base, simulation%model)) reference_text = &
               ', '//base_text(simulation%maxima%base, simulation%model)
            call add_sentence(verdict, 'Blocks moved by up to '//value_text(largest%value, 'm')// &
               reference_text)
         end associate
      end if
      if (counts(1) > 0) then
         if (all(counts(2:3) == 0)) then
            call add_sentence(verdict, 'no contact has slipped or opened at the end')
         else
            call add_sentence(verdict, to_text(counts(2))//' of '//to_text(counts(1))// &
               ' contacts have slipped and '//to_text(counts(3))//' have opened at the end')
         end if
         call add_value(verdict, 'contacts_slipped', real(counts(2), wp))
         call add_value(verdict, 'contacts_opened', real(counts(3), wp))
      end if
      associate (broken => simulation%counters%broken)
         if (broken > 0) then
            call add_sentence(verdict, counted(to_text(broken), 'bond has broken', &
               'bonds have broken'))
            call add_value(verdict, 'bonds_broken', real(broken, wp))
         end if
      end associate
      call add_crushing_sentence(verdict, simulation)
      if (simulation%stop%reason /= '') then
         call add_sentence(verdict, ending(simulation))
         call add_value(verdict, 'end_s', simulation%time)
      end if
   end subroutine add_movement_sentence

   !> Add a sentence on blocks whose joints have crushed, with the largest plastic closure.
   subroutine add_crushing_sentence(verdict, simulation)
      type(run_verdict_type), intent(inout) :: verdict   !< words and values are added
      type(simulation_type), intent(in) :: simulation    !< simulation at its present time
      integer, parameter :: max_names_listed = 6
      logical :: has_crushed(simulation%blocks%n)
      character(len=:), allocatable :: names
      real(wp) :: largest_closure
      integer :: b, c, k

      k = findloc(simulation%laws%columns%name == 'crushed', .true., 1)
      if (k == 0) return
      has_crushed = .false.
      associate (contacts => simulation%contacts(simulation%now))
         largest_closure = maxval([0.0_wp, contacts%memory(k, :contacts%n)])
         if (.not. largest_closure > 0.0_wp) return
         do c = 1, contacts%n
            if (contacts%memory(k, c) > 0.0_wp) &
               has_crushed([contacts%block_v(c), contacts%block_e(c)]) = .true.
         end do
         call add_value(verdict, 'contacts_crushed', real(count(contacts%memory(k, :contacts%n) &
            > 0.0_wp), wp))
      end associate
      names = ''
      do b = 1, size(has_crushed)
         if (has_crushed(b) .and. count(has_crushed(:b)) <= max_names_listed) &
            names = names//', '//block_label(simulation, b)
      end do
      if (count(has_crushed) > max_names_listed) names = names//' and '// &
         to_text(count(has_crushed) - max_names_listed)//' more'
      call add_value(verdict, 'crushed_m', largest_closure)
      call add_sentence(verdict, 'joints have crushed by up to '// &
         value_text(largest_closure, 'm')//' at '//names(3:))
   end subroutine add_crushing_sentence

   !> .true. if no movement exceeds rounding.
   pure logical function is_without_movement(simulation)
      type(simulation_type), intent(in) :: simulation    !< simulation at its present time

      is_without_movement = is_at_rest(simulation, simulation%maxima%largest(of_displacement)%value)
   end function is_without_movement

   !> Add the maxima that exceed rounding to the table.
   !> Accelerations of blocks and velocities at the end are not in the table but stored as numbers,
   !> because ringing and impacts dominate them.
   subroutine tabulate_maxima(verdict, simulation)
      type(run_verdict_type), intent(inout) :: verdict   !< figures are added
      type(simulation_type), intent(in) :: simulation    !< simulation at its present time
      integer, parameter :: motions(*) = [of_displacement, of_tilt, of_velocity, &
         of_point_displacement, of_point_drift], loaded(*) = [of_strain, of_plastic_strain, &
         of_penetration, of_contact_force], along(*) = [of_slip, of_opening]
      integer :: i

      associate (largest => simulation%maxima%largest)
         if (.not. is_without_movement(simulation)) then
            do i = 1, size(motions)
               if (motions(i) == of_tilt) then
                  if (.not. has_rotated(simulation)) cycle
               end if
               if (largest(motions(i))%value > 0.0_wp) call add_maximum(verdict, simulation, &
                  motions(i), motions(i) /= of_velocity)
            end do
         end if
         call add_distance_from_input(verdict, simulation)
         do i = 1, size(along)
            if (largest(along(i))%value > min_movement(simulation)) call add_maximum(verdict, &
               simulation, along(i), .true.)
         end do
         do i = 1, size(loaded)
            if (largest(loaded(i))%value > 0.0_wp) call add_maximum(verdict, simulation, &
               loaded(i), .true.)
         end do
         call add_bodies(verdict, simulation)
      end associate
   end subroutine tabulate_maxima

   !> .true. if the largest tilt moves corners by more than rounding.
   pure logical function has_rotated(simulation)
      type(simulation_type), intent(in) :: simulation    !< simulation at its present time

      associate (maxima => simulation%maxima)
         has_rotated = maxima%largest(of_tilt)%value*maxima%least_size > &
            rounding*maxima%largest(of_displacement)%value
      end associate
   end function has_rotated

   !> Add the error of the final stresses of bodies, estimated from stress jumps at faces of cells.
   subroutine add_bodies(verdict, simulation)
      type(run_verdict_type), intent(inout) :: verdict   !< a figure and its value are added
      type(simulation_type), intent(in) :: simulation    !< simulation at its present time
      character(len=*), parameter :: key = 'stress_error'
      real(wp) :: energies(2), error

      energies = body_energies(simulation%elements, simulation%blocks)
      if (.not. energies(2) > 0.0_wp) return
      error = sqrt(energies(1)/energies(2))
      call add_value(verdict, key, error)
      call add_figure(verdict, 'stress error', [character(len=len(key)) :: '', key], [0.0_wp, &
         error], '1', 'of bodies, relative, in the energy norm, from stress jumps at faces')
   end subroutine add_bodies

   !> Add maximum k to the table.
   subroutine add_maximum(verdict, simulation, k, ends)
      type(run_verdict_type), intent(inout) :: verdict   !< a figure is added
      type(simulation_type), intent(in) :: simulation    !< simulation at its present time
      integer, intent(in) :: k                           !< position in the list of maxima
      logical, intent(in) :: ends                        !< also add the value at the end
      character(len=32) :: keys(2)
      character(len=:), allocatable :: owner

      associate (largest => simulation%maxima%largest(k), last => simulation%maxima%last(k), &
         kind => maxima_table(k))
         keys = [character(len=32) :: 'largest_'//kind%number, '']
         if (ends .and. last%value > rounding*largest%value) keys(2) = 'residual_'//kind%number
         owner = owner_names(simulation, k, largest%owners)//', '//short_text(largest%time)//' s'
         call add_figure(verdict, output_label(kind%name), keys, [largest%value, last%value], &
            trim(kind%units), owner)
      end associate
   end subroutine add_maximum

   !> Name of an output variable in words.
   pure function output_label(name) result(text)
      character(len=*), intent(in) :: name  !< name in the schema
      character(len=:), allocatable :: text
      integer :: i

      text = trim(name)
      do i = 1, len(text)
         if (text(i:i) == '_') text(i:i) = ' '
      end do
   end function output_label

   !> Add the largest distance of a block from its position in the input.
   !> The distance is added only if displacements are measured from equilibrium.
   subroutine add_distance_from_input(verdict, simulation)
      type(run_verdict_type), intent(inout) :: verdict   !< a value and a figure are added
      type(simulation_type), intent(in) :: simulation    !< simulation at its present time
      character(len=*), parameter :: key = 'displacement_from_drawn_m'
      real(wp) :: distance
      real(wp), allocatable :: input_position(:,:)
      integer :: b

      if (.not. simulation%model%stages(1)%static) return
      input_position = simulation%model%blocks%position
      input_position(1:2, :) = input_position(1:2, :) &
         + spread(simulation%maxima%base%displacement, 2, size(input_position, 2))
      call find_farthest_block(simulation%blocks, input_position, b, distance)
      call add_value(verdict, key, distance)
      if (b > 0) call add_figure(verdict, 'distance from input', [character(len=len(key)) :: '', &
         key], [0.0_wp, distance], 'm', block_label(simulation, b)//', including settlement')
   end subroutine add_distance_from_input

   !> Text with the names of the blocks or points of a value.
   pure function owner_names(simulation, k, owners) result(text)
      type(simulation_type), intent(in) :: simulation    !< simulation at its present time
      integer, intent(in) :: k                           !< position in the list of maxima
      integer, intent(in) :: owners(2)                      !< blocks or points; 0: none
      character(len=:), allocatable :: text

      if (maxima_table(k)%of_points) then
         text = point_label(simulation%model%points(owners(1))%name, owners(1))
         if (owners(2) > 0) text = text//' over '// &
            point_label(simulation%model%points(owners(2))%name, owners(2))
      else
         text = block_label(simulation, owners(1))
         if (owners(2) > 0) text = text//' on '//block_label(simulation, owners(2))
      end if
   end function owner_names

   !> Add the intensity of shaking of a measured point.
   !> Numbers are added for all frequencies and for resolved frequencies.  Table lines have resolved
   !> frequencies only, along the axis with the larger value.
   subroutine judge_point(verdict, simulation, i, with_table)
      type(run_verdict_type), intent(inout) :: verdict   !< verdict of all samples
      type(simulation_type), intent(in) :: simulation  !< simulation at the time of the last sample
      integer, intent(in) :: i                           !< number of the point
      logical, intent(in) :: with_table                  !< add table lines
      character(len=:), allocatable :: name
      real(wp), dimension(motions) :: sa, at, arias

      associate (intensity => verdict%intensity(i))
         if (.not. maxval(intensity%acceleration(unfiltered)) > 0.0_wp) return
         name = point_label(simulation%model%points(i)%name, i)
         call find_spectral_accelerations(intensity%oscillators, intensity%spectra, &
            intensity%last_acceleration, sa, at)
         call add_unfiltered(verdict, intensity, name, sa(unfiltered), at(unfiltered))
         call add_value(verdict, 'resolved_frequency_hz['//name//']', verdict%frequency)
         arias = arias_intensity(intensity)
         call add_point('PGA', 'pga_resolved_m_s2', intensity%acceleration(low_passed), 'm/s^2', '')
         call add_point('PGV', 'pgv_m_s', intensity%velocity, 'm/s', '')
         call add_point('Arias intensity', 'arias_resolved_m_s', arias(low_passed), 'm/s', &
            high_frequency_text(arias))
         call add_point('largest Sa, ζ=5 %', 'sa_resolved_m_s2', sa(low_passed), 'm/s^2', '; at ' &
            //short_text(0.01_wp*nint(100.0_wp*at(low_passed(maxloc(sa(low_passed), 1)))))//' s')
      end associate

   contains

      !> Add a result along both axes.
      !> The table line has the larger value and then the smaller one.
      subroutine add_point(title, key, values, units, suffix)
         character(len=*), intent(in) :: title, key, units, suffix
         real(wp), intent(in) :: values(2)
         character(len=:), allocatable :: location
         integer :: axis

         axis = maxloc(values, 1)
         if (.not. values(axis) > 0.0_wp) return
         call add_value(verdict, key//'['//name//']', values(axis))
         call add_value(verdict, key//'_x['//name//']', values(1))
         call add_value(verdict, key//'_y['//name//']', values(2))
         if (.not. with_table) return
         location = name//', '//axes(axis)
         if (values(3 - axis) > min_shown_ratio*values(axis)) &
            location = location//' ('//axes(3 - axis)//' '//value_text(values(3 - axis), units)//')'
         if (index(key, 'resolved') > 0) location = location//', below '// &
            short_text(verdict%frequency) //' Hz'
         call add_figure(verdict, title, [character(len=len(key) + len(name) + 2) :: &
            key//'['//name//']', ''], [values(axis), 0.0_wp], units, location//suffix)
      end subroutine add_point
   end subroutine judge_point

   !> Add the results for all frequencies, along the axis with the larger value.
   subroutine add_unfiltered(verdict, intensity, name, sa, period)
      type(run_verdict_type), intent(inout) :: verdict  !< values are added
      type(intensity_type), intent(in) :: intensity     !< shaking of a point along both axes
      character(len=*), intent(in) :: name              !< name of the point
      real(wp), intent(in) :: sa(2), period(2)  !< largest spectral accelerations, m/s²; periods, s
      real(wp), dimension(motions) :: below_50_hz, arias

      below_50_hz = low_passed_peaks(intensity%spectra)
      arias = arias_intensity(intensity)
      call add_value(verdict, 'pga_m_s2['//name//']', maxval(intensity%acceleration(unfiltered)))
      call add_value(verdict, 'pga_below_50_hz_m_s2['//name//']', maxval(below_50_hz(unfiltered)))
      call add_value(verdict, 'arias_m_s['//name//']', maxval(arias(unfiltered)))
      if (.not. maxval(sa) > 0.0_wp) return  ! the time steps are too long for a spectrum
      call add_value(verdict, 'sa_m_s2['//name//']', maxval(sa))
      call add_value(verdict, 'sa_period_s['//name//']', period(maxloc(sa, 1)))
   end subroutine add_unfiltered

   !> Add slip, opening and force of measured joints.
   subroutine judge_joints(verdict, simulation)
      type(run_verdict_type), intent(inout) :: verdict   !< verdict of all samples
      type(simulation_type), intent(in) :: simulation  !< simulation at the time of the last sample
      character(len=:), allocatable :: name
      real(wp) :: threshold(size(verdict%joints, 2))
      integer :: i, k

      do i = 1, size(verdict%joints, 1)
         name = point_label(simulation%model%measured_joints(i)%name, i)
         associate (last => verdict%joints(i, :), largest => verdict%largest_joints(i, :), &
            variables => output_variables(out_joint_slip:out_joint_slip + size(threshold) - 1))
            threshold = merge(min_movement(simulation), rounding*maxval(largest, &
               variables%units /= 'm'), variables%units == 'm')
            do k = 1, size(last)
               call judge_joint(verdict, variables(k), name, [largest(k), last(k)], threshold(k))
            end do
            if (ieee_is_nan(last(1))) call add_sentence(verdict, &
               'joint '//name//' has no contact at the end of the run')
         end associate
      end do
   end subroutine judge_joints

   !> Add the last value and, for a length, the largest value of a variable of a measured joint.
   !> Values below `threshold` count as 0; components of the resultant force are omitted.
   subroutine judge_joint(verdict, variable, joint, peak_and_last, threshold)
      type(run_verdict_type), intent(inout) :: verdict       !< figures and values are added
      type(output_variable_type), intent(in) :: variable     !< variable of the joint
      character(len=*), intent(in) :: joint                  !< name of the joint
      real(wp), intent(in) :: peak_and_last(2)  !< largest absolute value, last value; NaN: none
      real(wp), intent(in) :: threshold             !< smallest value above rounding errors
      character(len=160) :: key(2)
      real(wp) :: values(2)
      integer :: k

      if (index(variable%name, '_force_x') + index(variable%name, '_force_y') > 0) return
      key(2) = trim(variable%number)//'['//joint//']'
      key(1) = 'largest_'//key(2)
      if (variable%units /= 'm') key(1) = ''
      if (ieee_is_nan(peak_and_last(2))) key(2) = ''
      values = merge(0.0_wp, peak_and_last, abs(peak_and_last) <= threshold)
      do k = 1, 2
         if (key(k) /= '') call add_value(verdict, trim(key(k)), values(k))
      end do
      if (any(key /= '')) call add_figure(verdict, output_label(variable%name(len('joint_') &
         + 1:)), key, values, trim(variable%units), joint)
   end subroutine judge_joint

   !> Text on the fraction of an intensity at unresolved frequencies, if this fraction is large.
   pure function high_frequency_text(arias) result(text)
      real(wp), intent(in) :: arias(motions)  !< Arias intensities, m/s
      character(len=:), allocatable :: text
      real(wp) :: fraction
      integer :: axis

      text = ''
      axis = maxloc(arias(low_passed), 1)
      fraction = 1 - arias(low_passed(axis))/arias(unfiltered(axis))
      if (fraction > min_excess) text = '; '//to_text(nint(100*fraction))// &
         ' % more with higher frequencies, due to ringing or impacts'
   end function high_frequency_text

   !> Name of a measured point or joint for an attribute, or its number if it has no name.
   pure function point_label(name, number) result(block_label)
      character(len=*), intent(in) :: name  !< name in the input
      integer, intent(in) :: number         !< number of the point or joint
      character(len=:), allocatable :: block_label

      block_label = attribute_name(name)
      if (block_label == '') block_label = to_text(number)
   end function point_label

   !> Name of a block for an attribute, or 'block' and its number if it has no name.
   pure function block_label(simulation, b) result(name)
      type(simulation_type), intent(in) :: simulation    !< a run and its state
      integer, intent(in) :: b                           !< number of the block
      character(len=:), allocatable :: name

      name = attribute_name(simulation%model%block_names(b))
      if (name == '') name = 'block '//to_text(b)
   end function block_label

   !> Replace the characters of a name that would end a line or field of an attribute.
   pure function attribute_name(name) result(text)
      character(len=*), intent(in) :: name  !< name in the input
      character(len=:), allocatable :: text
      integer :: c

      text = valid_text(trim(name))
      do c = 1, len(text)
         if (text(c:c) == '/' .or. iachar(text(c:c)) < iachar(' ')) text(c:c) = '|'
      end do
   end function attribute_name

end module dda_run_verdict
