! SPDX-License-Identifier: GPL-3.0-or-later
!> Events of a run, in words and numbers: from its largest values and, of measured points and
!> joints, from the samples as they are written.
module dda_run_verdict
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
   use dda_kinds, only: wp
   use dda_base_motion, only: base_words, counts_from_motion
   use dda_check_report, only: first_mode, ringing_topic
   use dda_diagnostics, only: audit_warning, doubt_state
   use dda_doubts, only: add_doubt, add_doubts, doubt_type
   use dda_elements, only: body_energies
   use dda_energy, only: balance
   use dda_equilibrium, only: farthest_moved
   use dda_joint_motion, only: joint_columns
   use dda_maxima, only: maxima_table, of_tilt, of_displacement, of_velocity, of_strain, of_slip, &
      of_opening, of_penetration, of_contact_force, of_plastic_strain, of_point_displacement, &
      of_point_drift
   use dda_point_intensity, only: intensity_type, new_intensity, add_motion, main_axis, &
      arias_intensity
   use dda_resolved_band, only: resolved_frequency
   use dda_response_spectrum, only: low_passed_peak, spectral_acceleration
   use dda_rest_bound, only: is_at_rest
   use dda_running_maxima, only: least_movement
   use dda_simulation, only: simulation_type, ending, comes_suddenly
   use dda_text, only: counted, to_text, short_text, valid_text
   use dda_verdict_lines, only: verdict_lines_type, tell, add_value, add_figure, value_text
   implicit none
   private
   public :: run_verdict_type, new_verdict, add_samples, add_joint_samples, &
      judge_movement, conclude

   real(wp), parameter :: rounding = 1.0e-9_wp   !< of the largest displacement, or of a value
   real(wp), parameter :: much_above = 0.05_wp  !< of Arias at higher frequencies: more is said

   !> A verdict in the making.
   type, extends(verdict_lines_type) :: run_verdict_type
      real(wp) :: frequency = 0.0_wp                   !< that accelerations are told below, Hz
      type(intensity_type), allocatable :: shaken(:)   !< [measured points]
      real(wp), allocatable :: joints(:,:)             !< [columns, measured joints] last sample
      real(wp), allocatable :: joints_most(:,:)        !< [2, joints] largest slip, opening, m
   end type run_verdict_type

contains

   !> Before the first sample.
   pure type(run_verdict_type) function new_verdict(simulation, points, joints) result(verdict)
      type(simulation_type), intent(in) :: simulation  !< of the run
      integer, intent(in) :: points, joints            !< measured ones, whose samples will be added

      verdict%happened = ''
      verdict%frequency = resolved_frequency(simulation%model, simulation%blocks)
      allocate (verdict%values(0), verdict%figures(0), verdict%doubts(0))
      allocate (verdict%shaken(points), source=new_intensity(verdict%frequency))
      allocate (verdict%joints(joint_columns, joints), verdict%joints_most(2, joints), &
         source=0.0_wp)
   end function new_verdict

   !> Take in samples, in the order of the run; point by point, whose oscillators then stay in the
   !> cache.
   pure subroutine add_samples(verdict, time, velocity, acceleration)
      type(run_verdict_type), intent(inout) :: verdict   !< of the samples so far
      real(wp), intent(in) :: time(:)                    !< [samples] s
      real(wp), intent(in) :: velocity(:,:)              !< [2 × points, samples] m/s
      real(wp), intent(in) :: acceleration(:,:)          !< [2 × points, samples] m/s²
      integer :: i, sample

      do i = 1, size(verdict%shaken)
         do sample = 1, size(time)
            call add_motion(verdict%shaken(i), time(sample), velocity(2*i - 1:2*i, sample), &
               acceleration(2*i - 1:2*i, sample))
         end do
      end do
   end subroutine add_samples

   !> Take in what the same samples have of measured joints.
   pure subroutine add_joint_samples(verdict, values)
      type(run_verdict_type), intent(inout) :: verdict   !< of the samples so far
      real(wp), intent(in) :: values(:,:)                !< [columns × joints, samples]
      integer :: i, sample

      do sample = 1, size(values, 2)
         verdict%joints = reshape(values(:, sample), shape(verdict%joints))
         do i = 1, size(verdict%joints, 2)
            verdict%joints_most(:, i) = max(verdict%joints_most(:, i), abs(verdict%joints(:2, i)))
         end do
      end do
   end subroutine add_joint_samples

   !> All of a run, after its last sample.
   subroutine conclude(verdict, simulation)
      type(run_verdict_type), intent(inout) :: verdict   !< of all samples
      type(simulation_type), intent(in) :: simulation    !< at the time of the last
      logical :: told
      integer :: i

      call judge_movement(verdict, simulation)
      told = size(simulation%model%motions) > 0
      if (told) told = .not. rests(simulation)
      do i = 1, size(verdict%shaken)
         call judge_point(verdict, simulation, i, told)
      end do
      call judge_joints(verdict, simulation)
      call add_value(verdict, 'energy_balance_j_m', balance(simulation%energy))
   end subroutine conclude

   !> Events, the largest values of all steps, and doubts.
   subroutine judge_movement(verdict, simulation)
      type(run_verdict_type), intent(inout) :: verdict   !< gets words, figures and values
      type(simulation_type), intent(in) :: simulation    !< at its present time
      character(len=:), allocatable :: words
      integer :: i

      associate (maxima => simulation%maxima)
         do i = 1, size(maxima_table)
            if (maxima%largest(i)%value >= 0.0_wp) call add_value(verdict, 'largest_'// &
               trim(maxima_table(i)%number), maxima%largest(i)%value)
            if (maxima%last(i)%value >= 0.0_wp) call add_value(verdict, 'residual_'// &
               trim(maxima_table(i)%number), maxima%last(i)%value)
         end do
      end associate
      call tell_movement(verdict, simulation)
      call tabulate(verdict, simulation)
      call add_doubts(verdict%doubts, standing_doubts(simulation))
      call doubt_state(simulation, verdict%doubts)
      if (comes_suddenly(simulation%model)) call add_doubt(verdict%doubts, 'start', &
         'gravity came on suddenly in the first step (settle = .true. begins at rest)')
      words = audit_warning(simulation)
      if (words /= '') call add_doubt(verdict%doubts, 'energy', words)
   end subroutine judge_movement

   !> Doubts of the check before the run, without what the run has answered: nothing rings at rest,
   !> and the first mode is of joints that stay closed.
   pure function standing_doubts(simulation) result(standing)
      type(simulation_type), intent(in) :: simulation    !< at its present time
      type(doubt_type), allocatable :: standing(:)
      logical :: at_rest, loose, answered
      integer :: i

      at_rest = rests(simulation)
      associate (moved => simulation%maxima%moved)
         loose = 2*(moved(2) + moved(3)) > moved(1)
      end associate
      allocate (standing(0))
      do i = 1, size(simulation%doubts)
         associate (doubt => simulation%doubts(i))
            answered = doubt%topic == first_mode .and. (at_rest .or. loose)
            answered = answered .or. (doubt%topic == ringing_topic .and. at_rest)
            if (.not. (answered .and. doubt%of_check)) call add_doubts(standing, [doubt])
         end associate
      end do
   end function standing_doubts

   !> One sentence: how far blocks moved, what contacts and bonds did, why the run has ended early.
   subroutine tell_movement(verdict, simulation)
      type(run_verdict_type), intent(inout) :: verdict   !< gets words and values
      type(simulation_type), intent(in) :: simulation    !< at its present time
      character(len=:), allocatable :: base
      integer :: moved(3)

      moved = simulation%maxima%moved
      if (rests(simulation)) then
         call tell(verdict, 'The model is at rest')
      else
         associate (largest => simulation%maxima%largest(of_displacement))
            base = ''
            if (counts_from_motion(simulation%maxima%base, simulation%model)) base = ', '// &
               base_words(simulation%maxima%base, simulation%model)
            call tell(verdict, 'Blocks moved by up to '//value_text(largest%value, 'm')//base)
         end associate
      end if
      if (moved(1) > 0) then
         if (all(moved(2:3) == 0)) then
            call tell(verdict, 'no contact has slipped or opened at the end')
         else
            call tell(verdict, to_text(moved(2))//' of '//to_text(moved(1))// &
               ' contacts have slipped and '//to_text(moved(3))//' have opened at the end')
         end if
         call add_value(verdict, 'contacts_slipped', real(moved(2), wp))
         call add_value(verdict, 'contacts_opened', real(moved(3), wp))
      end if
      associate (broken => simulation%counters%broken)
         if (broken > 0) then
            call tell(verdict, counted(to_text(broken), 'bond has broken', &
               'bonds have broken'))
            call add_value(verdict, 'bonds_broken', real(broken, wp))
         end if
      end associate
      if (simulation%stop%reason /= '') then
         call tell(verdict, ending(simulation))
         call add_value(verdict, 'end_s', simulation%time)
      end if
   end subroutine tell_movement

   !> All movement is rounding.
   pure logical function rests(simulation)
      type(simulation_type), intent(in) :: simulation    !< at its present time

      rests = is_at_rest(simulation, simulation%maxima%largest(of_displacement)%value)
   end function rests

   !> The largest values that are more than rounding.  Accelerations of blocks and velocities at the
   !> end are of contacts that ring or hit: they are numbers, and no figures.
   subroutine tabulate(verdict, simulation)
      type(run_verdict_type), intent(inout) :: verdict   !< gets figures
      type(simulation_type), intent(in) :: simulation    !< at its present time
      integer, parameter :: moving(*) = [of_displacement, of_tilt, of_velocity, &
         of_point_displacement, of_point_drift], loaded(*) = [of_strain, of_plastic_strain, &
         of_penetration, of_contact_force], along(*) = [of_slip, of_opening]
      integer :: i

      associate (largest => simulation%maxima%largest)
         if (.not. rests(simulation)) then
            do i = 1, size(moving)
               if (moving(i) == of_tilt) then
                  if (.not. turns(simulation)) cycle
               end if
               if (largest(moving(i))%value > 0.0_wp) call add_maximum(verdict, simulation, &
                  moving(i), moving(i) /= of_velocity)
            end do
         end if
         call add_drawn(verdict, simulation)
         do i = 1, size(along)
            if (largest(along(i))%value > least_movement(simulation)) call add_maximum(verdict, &
               simulation, along(i), .true.)
         end do
         do i = 1, size(loaded)
            if (largest(loaded(i))%value > 0.0_wp) call add_maximum(verdict, simulation, &
               loaded(i), .true.)
         end do
         call add_bodies(verdict, simulation)
      end associate
   end subroutine tabulate

   !> Tilts move the corners of a block by more than rounding.
   pure logical function turns(simulation)
      type(simulation_type), intent(in) :: simulation    !< at its present time

      associate (maxima => simulation%maxima)
         turns = maxima%largest(of_tilt)%value*maxima%least_size > &
            rounding*maxima%largest(of_displacement)%value
      end associate
   end function turns

   !> Error of the stresses of bodies at the end, by the jumps at faces of cells.
   subroutine add_bodies(verdict, simulation)
      type(run_verdict_type), intent(inout) :: verdict   !< gets a figure and its value
      type(simulation_type), intent(in) :: simulation    !< at its present time
      character(len=*), parameter :: key = 'stress_error'
      real(wp) :: energies(2), share

      energies = body_energies(simulation%elements, simulation%blocks)
      if (.not. energies(2) > 0.0_wp) return
      share = sqrt(energies(1)/energies(2))
      call add_value(verdict, key, share)
      call add_figure(verdict, 'error of stresses', [character(len=len(key)) :: '', key], &
         [0.0_wp, share], '1', 'of bodies, energy norm, by jumps at faces')
   end subroutine add_bodies

   !> A line of the table.
   subroutine add_maximum(verdict, simulation, k, ends)
      type(run_verdict_type), intent(inout) :: verdict   !< gets a figure
      type(simulation_type), intent(in) :: simulation    !< at its present time
      integer, intent(in) :: k                           !< place in the list of maxima
      logical, intent(in) :: ends                        !< its value at the end counts as well
      character(len=32) :: keys(2)
      character(len=:), allocatable :: name, place
      integer :: i

      associate (largest => simulation%maxima%largest(k), last => simulation%maxima%last(k), &
         kind => maxima_table(k))
         name = trim(kind%name)
         do i = 1, len(name)
            if (name(i:i) == '_') name(i:i) = ' '
         end do
         keys = [character(len=32) :: 'largest_'//kind%number, '']
         if (ends .and. last%value > rounding*largest%value) keys(2) = 'residual_'//kind%number
         place = who_text(simulation, k, largest%who)//', '//short_text(largest%time)//' s'
         call add_figure(verdict, name, keys, [largest%value, last%value], trim(kind%units), place)
      end associate
   end subroutine add_maximum

   !> Distance of blocks at the end from the model as drawn, where the run counts from rest.
   subroutine add_drawn(verdict, simulation)
      type(run_verdict_type), intent(inout) :: verdict   !< gets a value, and a figure
      type(simulation_type), intent(in) :: simulation    !< at its present time
      character(len=*), parameter :: key = 'displacement_from_drawn_m'
      real(wp) :: way
      integer :: b

      if (.not. simulation%model%stages(1)%static) return
      call farthest_moved(simulation%blocks, simulation%model%blocks%position, b, way)
      call add_value(verdict, key, way)
      if (b > 0) call add_figure(verdict, 'from as drawn', [character(len=len(key)) :: '', key], &
         [0.0_wp, way], 'm', label(simulation, b))
   end subroutine add_drawn

   !> Names of the blocks or points of a value.
   pure function who_text(simulation, k, who) result(text)
      type(simulation_type), intent(in) :: simulation    !< at its present time
      integer, intent(in) :: k                           !< place in the list of maxima
      integer, intent(in) :: who(2)                      !< blocks or points; 0: none
      character(len=:), allocatable :: text

      if (maxima_table(k)%of_points) then
         text = point_label(simulation%model%points(who(1))%name, who(1))
         if (who(2) > 0) text = text//' over '//point_label(simulation%model%points(who(2))%name, &
            who(2))
      else
         text = label(simulation, who(1))
         if (who(2) > 0) text = text//' on '//label(simulation, who(2))
      end if
   end function who_text

   !> Intensity of shaking of a measured point, along the axis of its largest velocity: numbers of
   !> all frequencies and of those that are motion of the ground, figures of the latter.
   subroutine judge_point(verdict, simulation, i, told)
      type(run_verdict_type), intent(inout) :: verdict   !< of all samples
      type(simulation_type), intent(in) :: simulation    !< at the time of the last
      integer, intent(in) :: i                           !< number of the point
      logical, intent(in) :: told                        !< it has figures
      character(len=:), allocatable :: name, place
      real(wp) :: spectral(2), period(2), low
      integer :: axis

      associate (shaken => verdict%shaken(i))
         if (.not. maxval(shaken%raw%acceleration) > 0.0_wp) return
         axis = main_axis(shaken)
         name = point_label(simulation%model%points(i)%name, i)
         associate (raw => shaken%raw(axis), resolved => shaken%low(axis))
            call spectral_acceleration(raw%spectrum, raw%last, spectral(1), period(1))
            call spectral_acceleration(resolved%spectrum, resolved%last, spectral(2), period(2))
            call add_value(verdict, 'pga_m_s2['//name//']', raw%acceleration)
            call add_value(verdict, 'pga_below_50_hz_m_s2['//name//']', &
               low_passed_peak(raw%spectrum))
            call add_value(verdict, 'arias_m_s['//name//']', arias_intensity(raw))
            call add_value(verdict, 'sa_m_s2['//name//']', spectral(1))
            call add_value(verdict, 'sa_period_s['//name//']', period(1))
            call add_value(verdict, 'pgv_m_s['//name//']', shaken%velocity(axis))
            call add_value(verdict, 'resolved_frequency_hz['//name//']', verdict%frequency)
            low = arias_intensity(resolved)
            place = name//', '//merge('x', 'y', axis == 1)//', below '// &
               short_text(verdict%frequency)//' Hz'
            call add_point('PGA', 'pga_resolved_m_s2', resolved%acceleration, 'm/s^2', place)
            call add_point('PGV', 'pgv_m_s', shaken%velocity(axis), 'm/s', name)
            call add_point('Arias intensity', 'arias_resolved_m_s', low, 'm/s', &
               place//above_text(1.0_wp - low/arias_intensity(raw)))
            call add_point('largest Sa, 5 %', 'sa_resolved_m_s2', spectral(2), 'm/s^2', &
               place//'; at '//short_text(period(2))//' s')
         end associate
      end associate

   contains

      !> A number of the point, and its figure.
      subroutine add_point(title, key, value, units, where)
         character(len=*), intent(in) :: title, key, units, where
         real(wp), intent(in) :: value

         if (index(key, 'resolved') > 0) call add_value(verdict, key//'['//name//']', value)
         if (told) call add_figure(verdict, title, [character(len=len(key) + len(name) + 2) :: &
            key//'['//name//']', ''], [value, 0.0_wp], units, where)
      end subroutine add_point
   end subroutine judge_point

   !> Slip, opening and force of measured joints.
   subroutine judge_joints(verdict, simulation)
      type(run_verdict_type), intent(inout) :: verdict   !< of all samples
      type(simulation_type), intent(in) :: simulation    !< at the time of the last
      character(len=*), parameter :: titles(*) = [character(len=12) :: 'slip', 'opening', &
         'normal force', 'shear force'], keys(*) = [character(len=23) :: 'joint_slip_m[', &
         'joint_opening_m[', 'joint_normal_force_n_m[', 'joint_shear_force_n_m['], &
         units(*) = [character(len=3) :: 'm', 'm', 'N/m', 'N/m']
      character(len=:), allocatable :: name
      character(len=160) :: key(2)
      integer :: i, k

      do i = 1, size(verdict%joints, 2)
         name = point_label(simulation%model%measured_joints(i)%name, i)
         associate (last => verdict%joints(:, i), most => verdict%joints_most(:, i))
            do k = 1, size(keys)
               key = ''
               if (k <= 2) key(1) = 'largest_'//trim(keys(k))//name//']'
               if (k <= 2) call add_value(verdict, trim(key(1)), most(k))
               if (.not. ieee_is_nan(last(k))) key(2) = trim(keys(k))//name//']'
               if (key(2) /= '') call add_value(verdict, trim(key(2)), last(k))
               if (any(key /= '')) call add_figure(verdict, trim(titles(k)), key, &
                  [most(min(k, 2)), last(k)], trim(units(k)), name)
            end do
            if (ieee_is_nan(last(1))) call tell(verdict, 'nothing is left of the joint '//name)
         end associate
      end do
   end subroutine judge_joints

   !> The share of an intensity at higher frequencies, where it is much.
   pure function above_text(share) result(text)
      real(wp), intent(in) :: share  !< 0 … 1
      character(len=:), allocatable :: text

      text = ''
      if (share > much_above) text = '; '//to_text(nint(100*share))//' % more above, of '// &
         'contacts that ring or hit'
   end function above_text

   !> The name of a measured point as names of attributes may have it, or its number.
   pure function point_label(name, number) result(label)
      character(len=*), intent(in) :: name  !< of the input
      integer, intent(in) :: number         !< of the point
      character(len=:), allocatable :: label

      label = clean(name)
      if (label == '') label = to_text(number)
   end function point_label

   !> The name of a block, or its number.
   pure function label(simulation, b) result(name)
      type(simulation_type), intent(in) :: simulation    !< a run and its state
      integer, intent(in) :: b                           !< number of the block
      character(len=:), allocatable :: name

      name = clean(simulation%model%block_names(b))
      if (name == '') name = 'block '//to_text(b)
   end function label

   !> A name without characters that attributes or lines of them cannot hold.
   pure function clean(name) result(text)
      character(len=*), intent(in) :: name  !< of the input
      character(len=:), allocatable :: text
      integer :: c

      text = valid_text(trim(name))
      do c = 1, len(text)
         if (text(c:c) == '/' .or. iachar(text(c:c)) < iachar(' ')) text(c:c) = '|'
      end do
   end function clean

end module dda_run_verdict
