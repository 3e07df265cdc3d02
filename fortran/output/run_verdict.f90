! SPDX-License-Identifier: GPL-3.0-or-later
!> What happened in a run, in words and numbers: from its largest values and, of measured points and
!> joints, from the samples as they are written.
module dda_run_verdict
   use, intrinsic :: ieee_arithmetic, only: ieee_is_nan
   use dda_kinds, only: wp, pi
   use dda_base_motion, only: base_words, counts_from_motion
   use dda_diagnostics, only: audit_warning, state_warnings
   use dda_elements, only: body_energies
   use dda_energy, only: balance
   use dda_equilibrium, only: farthest_moved
   use dda_joint_motion, only: joint_columns
   use dda_maxima, only: largest_type, maxima_table, of_tilt, of_displacement, of_velocity, &
      of_acceleration, of_strain, of_slip, of_opening, of_penetration, of_penetration_ratio, &
      of_contact_force, of_point_displacement, of_point_velocity, of_point_acceleration, &
      of_point_drift
   use dda_model, only: half_size
   use dda_point_intensity, only: intensity_type, new_intensity, add_motion, main_axis, &
      arias_intensity
   use dda_response_spectrum, only: low_passed_peak, spectral_acceleration
   use dda_running_maxima, only: least_movement
   use dda_simulation, only: simulation_type, ending
   use dda_text, only: to_text, short_text, valid_text
   implicit none
   private
   public :: run_verdict_type, verdict_value_type, new_verdict, add_samples, add_joint_samples, &
      judge_movement, conclude

   real(wp), parameter :: low_share = 0.7_wp  !< of a peak acceleration below 50 Hz: less is said

   !> share of the model's size: less, at its largest, is rounding of a model at rest, measured
   real(wp), parameter :: rest_share = 1.0e-9_wp

   !> A number of the verdict.
   type :: verdict_value_type
      character(len=:), allocatable :: name  !< with its unit
      real(wp) :: value = 0.0_wp
   end type verdict_value_type

   !> A verdict in the making.
   type :: run_verdict_type
      character(len=:), allocatable :: words           !< "topic: sentence", a line each
      type(verdict_value_type), allocatable :: values(:)
      type(intensity_type), allocatable :: shaken(:)   !< [measured points]
      real(wp), allocatable :: joints(:,:)             !< [columns, measured joints] last sample
      real(wp), allocatable :: joints_most(:,:)        !< [2, joints] largest slip, opening, m
   end type run_verdict_type

contains

   !> Before the first sample.
   pure type(run_verdict_type) function new_verdict(points, joints) result(verdict)
      integer, intent(in) :: points, joints  !< that are measured

      verdict%words = ''
      allocate (verdict%values(0))
      allocate (verdict%shaken(points), source=new_intensity())
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

   !> Words and values, after the last sample.
   subroutine conclude(verdict, simulation)
      type(run_verdict_type), intent(inout) :: verdict   !< of all samples
      type(simulation_type), intent(in) :: simulation    !< at the time of the last
      character(len=8) :: left

      call judge_movement(verdict, simulation)
      call judge_points(verdict, simulation)
      call judge_joints(verdict, simulation)
      if (state_warnings(simulation) /= '') verdict%words = verdict%words//new_line('a')// &
         state_warnings(simulation)
      if (audit_warning(simulation) == '') then
         write (left, '(es8.1e2)') balance(simulation%energy)
         call say(verdict, 'energy', 'balances, '//trim(adjustl(left))//' J/m left over')
      else
         call say(verdict, 'energy', audit_warning(simulation))
      end if
      call note(verdict, 'energy_balance_j_m', balance(simulation%energy))
   end subroutine conclude

   !> Why the run has ended early, the largest values of its steps, and broken bonds.
   subroutine judge_movement(verdict, simulation)
      type(run_verdict_type), intent(inout) :: verdict   !< gets lines and values
      type(simulation_type), intent(in) :: simulation    !< at its present time
      integer :: i

      if (simulation%stop%reason /= '') then
         call say(verdict, 'end', ending(simulation))
         call note(verdict, 'end_s', simulation%time)
      end if
      associate (maxima => simulation%maxima)
         do i = 1, size(maxima_table)
            if (maxima%largest(i)%value >= 0.0_wp) call note(verdict, 'largest_'// &
               trim(maxima_table(i)%number), maxima%largest(i)%value)
            if (maxima%last(i)%value >= 0.0_wp) call note(verdict, 'residual_'// &
               trim(maxima_table(i)%number), maxima%last(i)%value)
         end do
      end associate
      call say_blocks(verdict, simulation)
      call judge_contacts(verdict, simulation)
      call say_points(verdict, simulation)
      call say_bodies(verdict, simulation)
      if (simulation%counters%broken > 0) then
         call say(verdict, 'bonds', to_text(simulation%counters%broken)//' broken')
         call note(verdict, 'bonds_broken', real(simulation%counters%broken, wp))
      end if
   end subroutine judge_movement

   !> How far the stresses of bodies are off at the end.
   subroutine say_bodies(verdict, simulation)
      type(run_verdict_type), intent(inout) :: verdict   !< gets a line
      type(simulation_type), intent(in) :: simulation    !< at its end
      real(wp) :: energies(2)

      energies = body_energies(simulation%elements, simulation%blocks)
      if (.not. energies(2) > 0.0_wp) return
      call say(verdict, 'bodies', 'at the end stresses are off by about '// &
         short_text(100*sqrt(energies(1)/energies(2)))//' % in the energy norm, by the jumps '// &
         'at faces of cells')
      call note(verdict, 'stress_error', sqrt(energies(1)/energies(2)))
   end subroutine say_bodies

   !> How far, how fast and how strongly blocks moved, turned and were strained.
   subroutine say_blocks(verdict, simulation)
      type(run_verdict_type), intent(inout) :: verdict   !< gets lines
      type(simulation_type), intent(in) :: simulation    !< at its present time
      integer, parameter :: topics(*) = [of_displacement, of_tilt, of_velocity, of_acceleration, &
         of_strain]
      character(len=:), allocatable :: words
      logical :: rests
      integer :: i

      rests = is_at_rest(simulation)
      if (rests) then
         words = 'none, at rest'
         call add_drawn(verdict, simulation, words)
         call say(verdict, trim(maxima_table(of_displacement)%name), words)
      end if
      do i = 1, size(topics)
         if (rests .and. topics(i) /= of_strain) cycle
         associate (k => topics(i), largest => simulation%maxima%largest, &
            last => simulation%maxima%last)
            if (i > 2 .and. .not. largest(k)%value > 0.0_wp) cycle
            words = 'largest '//largest_text(simulation, k)
            if (i <= 2) words = words//'; at the end '//value_text(k, last(k)%value)//', '// &
               who_text(simulation, k, last(k)%who)
            if (k == of_displacement) call add_drawn(verdict, simulation, words)
            if (k == of_displacement .and. counts_from_motion(simulation%maxima%base, &
               simulation%model)) words = words//'; '//base_words(simulation%maxima%base, &
               simulation%model)
            call say(verdict, trim(maxima_table(k)%name), words)
         end associate
      end do
   end subroutine say_blocks

   !> What moved is rounding.
   pure logical function is_at_rest(simulation)
      type(simulation_type), intent(in) :: simulation    !< at its present time

      is_at_rest = simulation%maxima%largest(of_displacement)%value <= rest_share*2 &
         *half_size(simulation%model%blocks)
   end function is_at_rest

   !> How far blocks are at the end from the model as drawn, where the run counts from rest.
   subroutine add_drawn(verdict, simulation, words)
      type(run_verdict_type), intent(inout) :: verdict   !< gets a value
      type(simulation_type), intent(in) :: simulation    !< at its present time
      character(len=:), allocatable, intent(inout) :: words  !< of the displacements
      real(wp) :: way
      integer :: b

      if (.not. simulation%model%stages(1)%static) return
      call farthest_moved(simulation%blocks, simulation%model%blocks%position, b, way)
      call note(verdict, 'displacement_from_drawn_m', way)
      if (b > 0) words = words//'; from the model as drawn '//length_text(way)//', '// &
         label(simulation, b)
   end subroutine add_drawn

   !> Slip and opening of the contacts that touched at first; penetrations and forces of all.
   subroutine judge_contacts(verdict, simulation)
      type(run_verdict_type), intent(inout) :: verdict   !< gets lines and values
      type(simulation_type), intent(in) :: simulation    !< at its present time
      character(len=:), allocatable :: words

      associate (moved => simulation%maxima%moved, largest => simulation%maxima%largest)
         if (moved(1) > 0) then
            words = to_text(moved(2))//' of '//to_text(moved(1))//' have slipped and '// &
               to_text(moved(3))//' have opened at the end'
            if (largest(of_slip)%value > least_movement(simulation)) words = words// &
               '; largest slip '//largest_text(simulation, of_slip)
            if (largest(of_opening)%value > least_movement(simulation)) words = words// &
               '; widest opening '//largest_text(simulation, of_opening)
            call say(verdict, 'contacts', words)
            call note(verdict, 'contacts_slipped', real(moved(2), wp))
            call note(verdict, 'contacts_opened', real(moved(3), wp))
         end if
         if (largest(of_penetration)%value > 0.0_wp) call say(verdict, 'penetration', &
            'deepest '//largest_text(simulation, of_penetration)//'; up to '// &
            value_text(of_penetration_ratio, largest(of_penetration_ratio)%value)// &
            ' of the size of a block')
         if (largest(of_contact_force)%value > 0.0_wp) call say(verdict, 'contact force', &
            'largest '//largest_text(simulation, of_contact_force))
      end associate
   end subroutine judge_contacts

   !> How measured points moved against the base and each other.
   subroutine say_points(verdict, simulation)
      type(run_verdict_type), intent(inout) :: verdict   !< gets a line
      type(simulation_type), intent(in) :: simulation    !< at its present time
      integer, parameter :: topics(*) = [of_point_displacement, of_point_velocity, &
         of_point_acceleration, of_point_drift]
      character(len=:), allocatable :: words
      integer :: i

      words = ''
      do i = 1, size(topics)
         if (is_at_rest(simulation)) exit
         if (.not. simulation%maxima%largest(topics(i))%value > 0.0_wp) cycle
         if (words /= '') words = words//'; '
         words = words//trim(maxima_table(topics(i))%name(len('point_') + 1:))//' '// &
            largest_text(simulation, topics(i))
      end do
      if (words /= '') call say(verdict, 'points', 'largest '//words)
   end subroutine say_points

   !> A largest value with its blocks or points and its time.
   function largest_text(simulation, k) result(text)
      type(simulation_type), intent(in) :: simulation    !< at its present time
      integer, intent(in) :: k                           !< place in the table
      character(len=:), allocatable :: text

      associate (largest => simulation%maxima%largest(k))
         text = value_text(k, largest%value)//', '//who_text(simulation, k, largest%who)//' at '// &
            to_text(largest%time)//' s'
      end associate
   end function largest_text

   !> A value as one says it.
   pure function value_text(k, value) result(text)
      integer, intent(in) :: k                           !< place in the table
      real(wp), intent(in) :: value                      !< in its unit
      character(len=:), allocatable :: text

      select case (maxima_table(k)%units)
      case ('rad')
         text = angle_text(value)
      case ('m')
         text = length_text(value)
      case ('1')
         text = short_text(100*value)//' %'
      case ('N/m')
         text = short_text(1.0e-3_wp*value)//' kN/m'
      case ('m/s^2')
         text = short_text(value)//' m/s²'
      case default
         text = short_text(value)//' '//trim(maxima_table(k)%units)
      end select
   end function value_text

   !> Names of the blocks or points of a value.
   pure function who_text(simulation, k, who) result(text)
      type(simulation_type), intent(in) :: simulation    !< at its present time
      integer, intent(in) :: k                           !< place in the table
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

   !> How strongly the measured points that moved were shaken, along the axis of the largest
   !> velocity; a peak acceleration that is of higher frequencies is told as such.
   subroutine judge_points(verdict, simulation)
      type(run_verdict_type), intent(inout) :: verdict   !< of all samples
      type(simulation_type), intent(in) :: simulation    !< at the time of the last
      character(len=:), allocatable :: name, along
      real(wp) :: arias, spectral, period, low
      logical :: rests
      integer :: i, axis

      rests = is_at_rest(simulation)
      do i = 1, size(verdict%shaken)
         associate (shaken => verdict%shaken(i))
            if (.not. maxval(shaken%acceleration) > 0.0_wp) cycle
            axis = main_axis(shaken)
            name = point_label(simulation%model%points(i)%name, i)
            along = 'along '//merge('x', 'y', axis == 1)
            arias = arias_intensity(shaken, axis)
            low = low_passed_peak(shaken%spectrum(axis))
            call spectral_acceleration(shaken%spectrum(axis), shaken%last(axis), spectral, period)
            if (.not. rests) call say(verdict, 'point '//name, along//': PGA '// &
               short_text(shaken%acceleration(axis))//' m/s², PGV '// &
               short_text(shaken%velocity(axis))//' m/s, Arias '//short_text(arias)//' m/s'// &
               low_peak_text(shaken%acceleration(axis), low))
            if (.not. rests) call say(verdict, 'Sa '//name, along//', 5 %: largest '// &
               short_text(spectral)//' m/s² at '//short_text(period)//' s')
            call note(verdict, 'pga_m_s2['//name//']', shaken%acceleration(axis))
            call note(verdict, 'pga_below_50_hz_m_s2['//name//']', low)
            call note(verdict, 'pgv_m_s['//name//']', shaken%velocity(axis))
            call note(verdict, 'arias_m_s['//name//']', arias)
            call note(verdict, 'sa_m_s2['//name//']', spectral)
            call note(verdict, 'sa_period_s['//name//']', period)
         end associate
      end do
   end subroutine judge_points

   !> Slip, opening and force of measured joints.
   subroutine judge_joints(verdict, simulation)
      type(run_verdict_type), intent(inout) :: verdict   !< of all samples
      type(simulation_type), intent(in) :: simulation    !< at the time of the last
      character(len=:), allocatable :: name, words
      integer :: i

      do i = 1, size(verdict%joints, 2)
         name = point_label(simulation%model%measured_joints(i)%name, i)
         associate (last => verdict%joints(:, i), most => verdict%joints_most(:, i))
            words = 'nothing is left of it'
            if (.not. ieee_is_nan(last(1))) words = 'slip '//length_text(last(1))// &
               ' at the end, largest '//length_text(most(1))//'; opening '// &
               length_text(last(2))//', widest '//length_text(most(2))//'; normal force '// &
               short_text(1.0e-3_wp*last(3))//' kN/m, shear force '// &
               short_text(1.0e-3_wp*last(4))//' kN/m'
            call say(verdict, 'joint '//name, words)
            call note(verdict, 'largest_joint_slip_m['//name//']', most(1))
            call note(verdict, 'largest_joint_opening_m['//name//']', most(2))
            if (ieee_is_nan(last(1))) cycle
            call note(verdict, 'joint_slip_m['//name//']', last(1))
            call note(verdict, 'joint_opening_m['//name//']', last(2))
            call note(verdict, 'joint_normal_force_n_m['//name//']', last(3))
            call note(verdict, 'joint_shear_force_n_m['//name//']', last(4))
         end associate
      end do
   end subroutine judge_joints

   !> The peak acceleration below 50 Hz, where much of the peak is of higher frequencies.
   pure function low_peak_text(peak, low) result(text)
      real(wp), intent(in) :: peak  !< acceleration, m/s²
      real(wp), intent(in) :: low   !< after a low-pass at 50 Hz, m/s²
      character(len=:), allocatable :: text

      text = ''
      if (low < low_share*peak) text = '; below 50 Hz the peak is '//short_text(low)// &
         ' m/s²: higher frequencies, as of impacts and ringing contacts, count in PGA and Arias'
   end function low_peak_text

   !> The name of a measured point as names of attributes may hold it, or its number.
   pure function point_label(name, number) result(label)
      character(len=*), intent(in) :: name  !< of the input
      integer, intent(in) :: number         !< of the point
      character(len=:), allocatable :: label
      integer :: c

      label = valid_text(trim(name))
      if (label == '') label = to_text(number)
      do c = 1, len(label)
         if (label(c:c) == '/' .or. iachar(label(c:c)) < iachar(' ')) label(c:c) = '|'
      end do
   end function point_label

   !> Add a line.
   subroutine say(verdict, topic, sentence)
      type(run_verdict_type), intent(inout) :: verdict   !< in the making
      character(len=*), intent(in) :: topic, sentence    !< of the line

      if (verdict%words /= '') verdict%words = verdict%words//new_line('a')
      verdict%words = verdict%words//topic//': '//sentence
   end subroutine say

   !> Add a value.
   pure subroutine note(verdict, name, value)
      type(run_verdict_type), intent(inout) :: verdict   !< in the making
      character(len=*), intent(in) :: name               !< with its unit
      real(wp), intent(in) :: value                      !< in that unit

      verdict%values = [verdict%values, verdict_value_type(name, value)]
   end subroutine note

   !> The name of a block, or its number.
   pure function label(simulation, b) result(name)
      type(simulation_type), intent(in) :: simulation    !< a run and its state
      integer, intent(in) :: b                           !< number of the block
      character(len=:), allocatable :: name

      name = trim(simulation%model%block_names(b))
      if (name == '') name = 'block '//to_text(b)
   end function label

   !> A length as one says it.
   pure function length_text(length) result(text)
      real(wp), intent(in) :: length             !< m
      character(len=:), allocatable :: text

      if (abs(length) >= 1.0_wp .or. abs(length) < 1.0e-9_wp) then
         text = short_text(length)//' m'
      else if (abs(length) >= 1.0e-3_wp) then
         text = short_text(1.0e3_wp*length)//' mm'
      else
         text = short_text(1.0e6_wp*length)//' µm'
      end if
   end function length_text

   !> An angle as one says it.
   pure function angle_text(angle) result(text)
      real(wp), intent(in) :: angle              !< rad
      character(len=:), allocatable :: text

      text = 'below 0.001°'
      if (abs(angle)*180/pi >= 1.0e-3_wp) text = short_text(abs(angle)*180/pi)//'°'
   end function angle_text

end module dda_run_verdict
