! SPDX-License-Identifier: GPL-3.0-or-later
!> What happened in a run, in words and numbers: from the frames as they are written, at no cost to
!> the steps.
!>
!> Slip and opening are those of the contacts that touch in the first frame: the vertex against the
!> point of the edge where its foot was, which keeps its share of the edge since strains of a block
!> are uniform.
module dda_run_verdict
   use dda_kinds, only: wp, pi
   use dda_diagnostics, only: audit_warning, state_warnings
   use dda_energy, only: balance
   use dda_model, only: half_size
   use dda_point_intensity, only: intensity_type, new_intensity, add_motion, main_axis, &
      arias_intensity
   use dda_response_spectrum, only: low_passed_peak, spectral_acceleration
   use dda_simulation, only: simulation_type, ending
   use dda_text, only: to_text, short_text, valid_text
   implicit none
   private
   public :: run_verdict_type, verdict_value_type, new_verdict, add_frame, add_corners, &
      add_column, add_samples, conclude

   real(wp), parameter :: low_share = 0.7_wp  !< of a peak acceleration below 50 Hz: less is said
   real(wp), parameter :: least_movement = 1.0e-5_wp  !< of the model's size: below, none is counted

   !> A number of the verdict.
   type :: verdict_value_type
      character(len=:), allocatable :: name  !< with its unit
      real(wp) :: value = 0.0_wp
   end type verdict_value_type

   !> The largest value of a kind so far: of which block, when.
   type :: largest_type
      real(wp) :: value = -1.0_wp
      integer :: block = 0
      real(wp) :: time = 0.0_wp              !< s
   end type largest_type

   !> A verdict in the making.
   type :: run_verdict_type
      character(len=:), allocatable :: words           !< "topic: sentence", a line each
      type(verdict_value_type), allocatable :: values(:)
      integer :: frames = 0
      real(wp), allocatable :: first(:,:)              !< [3, blocks] places in the first frame
      real(wp), allocatable :: corners(:,:)            !< [2, vertices] in the first frame, m
      integer, allocatable :: vertex(:), edge(:)       !< [contacts] that touch in the first frame
      type(largest_type) :: moved, turned              !< of all frames
      type(largest_type) :: moved_last, turned_last    !< of the last frame
      type(intensity_type), allocatable :: shaken(:)   !< [measured points]
   end type run_verdict_type

contains

   !> Before the first frame and sample.
   pure type(run_verdict_type) function new_verdict(points) result(verdict)
      integer, intent(in) :: points  !< that are measured

      allocate (verdict%values(0), verdict%vertex(0), verdict%edge(0))
      allocate (verdict%shaken(points), source=new_intensity())
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

   !> Take in the places of a frame, in the order of the run.
   subroutine add_frame(verdict, time, n, coordinates)
      type(run_verdict_type), intent(inout) :: verdict   !< of the frames so far
      real(wp), intent(in) :: time                       !< of the frame, s
      integer, intent(in) :: n                           !< number of blocks
      real(wp), intent(in) :: coordinates(6, n)          !< m, rad
      real(wp) :: moved(3)
      integer :: b

      verdict%frames = verdict%frames + 1
      if (verdict%frames == 1) verdict%first = coordinates(:3, :)
      verdict%moved_last = largest_type()
      verdict%turned_last = largest_type()
      do b = 1, n
         moved = coordinates(:3, b) - verdict%first(:, b)
         call take(verdict%moved_last, norm2(moved(:2)), b, time)
         call take(verdict%turned_last, abs(moved(3)), b, time)
      end do
      call take(verdict%moved, verdict%moved_last%value, verdict%moved_last%block, time)
      call take(verdict%turned, verdict%turned_last%value, verdict%turned_last%block, time)
   end subroutine add_frame

   !> Take in the vertices of the frame, m.
   subroutine add_corners(verdict, vertices, corners)
      type(run_verdict_type), intent(inout) :: verdict   !< of the frames so far
      integer, intent(in) :: vertices                    !< how many
      real(wp), intent(in) :: corners(2, vertices)       !< m

      if (verdict%frames == 1) verdict%corners = corners
   end subroutine add_corners

   !> Take in a column of the contacts of the frame, in the order of the output: of the first one
   !> those are kept that touch.
   subroutine add_column(verdict, simulation, name, column)
      type(run_verdict_type), intent(inout) :: verdict   !< of the frames so far
      type(simulation_type), intent(in) :: simulation    !< whose frame it is
      character(len=*), intent(in) :: name               !< of the variable
      real(wp), intent(in) :: column(:)                  !< [contacts]
      logical :: touches(size(column))

      if (verdict%frames > 1) return
      select case (name)
      case ('contact_vertex')
         verdict%vertex = nint(column) + 1
      case ('contact_edge')
         verdict%edge = nint(column) + 1
      case ('contact_gap')
         touches = column <= threshold(simulation)
         verdict%vertex = pack(verdict%vertex, touches)
         verdict%edge = pack(verdict%edge, touches)
      end select
   end subroutine add_column

   !> Keep a value if it is larger.
   pure subroutine take(largest, value, block, time)
      type(largest_type), intent(inout) :: largest  !< so far
      real(wp), intent(in) :: value, time           !< m or rad; s
      integer, intent(in) :: block                  !< number

      if (value > largest%value) largest = largest_type(value, block, time)
   end subroutine take

   !> Movement that counts, m.
   pure real(wp) function threshold(simulation)
      type(simulation_type), intent(in) :: simulation    !< a run and its state

      threshold = least_movement*2*half_size(simulation%model%blocks)
   end function threshold

   !> Words and values, after the last frame.
   subroutine conclude(verdict, simulation, vertices, corners)
      type(run_verdict_type), intent(inout) :: verdict   !< of all frames
      type(simulation_type), intent(in) :: simulation    !< at the time of the last
      integer, intent(in) :: vertices                    !< how many
      real(wp), intent(in) :: corners(2, vertices)       !< in the last frame, m
      character(len=8) :: left

      verdict%words = ''
      if (simulation%stop%reason /= '') then
         call say(verdict, 'end', ending(simulation))
         call note(verdict, 'end_s', simulation%time)
      end if
      call say_largest(verdict, simulation, 'displacement', verdict%moved, verdict%moved_last)
      call say_largest(verdict, simulation, 'tilt', verdict%turned, verdict%turned_last)
      call judge_contacts(verdict, simulation, corners)
      if (simulation%counters%broken > 0) then
         call say(verdict, 'bonds', to_text(simulation%counters%broken)//' broken')
         call note(verdict, 'bonds_broken', real(simulation%counters%broken, wp))
      end if
      call judge_points(verdict, simulation)
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

   !> The largest displacement or tilt of all times and of the end.
   subroutine say_largest(verdict, simulation, topic, largest, last)
      type(run_verdict_type), intent(inout) :: verdict   !< of all frames
      type(simulation_type), intent(in) :: simulation    !< at the time of the last
      character(len=*), intent(in) :: topic              !< 'displacement' or 'tilt'
      type(largest_type), intent(in) :: largest, last    !< of all frames and of the last one
      character(len=:), allocatable :: unit, seen

      seen = ''
      if (verdict%frames == 2 .and. topic == 'displacement') &
         seen = ' (of the first and the last frame alone)'
      call say(verdict, topic, 'largest '//size_text(topic, largest%value)//', '// &
         label(simulation, largest%block)//' at '//to_text(largest%time)// &
         ' s; at the end '//size_text(topic, last%value)//', '//label(simulation, last%block)//seen)
      unit = '_m'
      if (topic == 'tilt') unit = '_rad'
      call note(verdict, 'largest_'//topic//unit, largest%value)
      call note(verdict, 'residual_'//topic//unit, last%value)
   end subroutine say_largest

   !> A displacement or a tilt as one says it.
   pure function size_text(topic, value) result(text)
      character(len=*), intent(in) :: topic      !< 'displacement' or 'tilt'
      real(wp), intent(in) :: value              !< m or rad
      character(len=:), allocatable :: text

      if (topic == 'tilt') then
         text = angle_text(value)
      else
         text = length_text(value)
      end if
   end function size_text

   !> Slip and opening of the contacts since the first frame.
   subroutine judge_contacts(verdict, simulation, corners)
      type(run_verdict_type), intent(inout) :: verdict   !< of all frames
      type(simulation_type), intent(in) :: simulation    !< at the time of the last
      real(wp), intent(in) :: corners(:,:)               !< [2, vertices] in the last frame, m
      type(largest_type) :: slip, opening
      real(wp) :: moved(2)
      integer :: c, slipped, opened, total
      integer, allocatable :: touched(:)

      touched = touched_edges(simulation)
      slipped = 0
      opened = 0
      total = 0
      associate (blocks => simulation%blocks, limit => threshold(simulation))
         do c = 1, size(verdict%vertex)
            associate (v => verdict%vertex(c), e => verdict%edge(c))
               if (blocks%removed(blocks%owner(v)) .or. blocks%removed(blocks%owner(e))) cycle
               total = total + 1
               moved = gap_and_slip(corners, v, e, blocks%next(e), verdict%corners)
               if (touched(v) == e) moved(1) = min(moved(1), 0.0_wp)  ! lifted by dilation at most
               if (moved(1) > limit) opened = opened + 1
               if (abs(moved(2)) > limit) slipped = slipped + 1
               call take(opening, moved(1), c, 0.0_wp)
               call take(slip, abs(moved(2)), c, 0.0_wp)
            end associate
         end do
      end associate
      if (total == 0) return
      call say(verdict, 'contacts', to_text(slipped)//' of '//to_text(total)// &
         ' have slipped and '//to_text(opened)//' have opened at the end'// &
         where_text(verdict, simulation, slipped, '; largest slip ', slip)// &
         where_text(verdict, simulation, opened, '; widest opening ', opening))
      call note(verdict, 'contacts_slipped', real(slipped, wp))
      call note(verdict, 'contacts_opened', real(opened, wp))
      call note(verdict, 'largest_slip_m', slip%value)
      call note(verdict, 'largest_opening_m', max(opening%value, 0.0_wp))
   end subroutine judge_contacts

   !> An edge that each vertex presses on (of two, the last in order), 0 without one.
   pure function touched_edges(simulation) result(touched)
      type(simulation_type), intent(in) :: simulation  !< at the time of the last frame
      integer, allocatable :: touched(:)
      integer :: c

      allocate (touched(size(simulation%blocks%owner)), source=0)
      associate (contacts => simulation%contacts(simulation%now))
         do c = 1, contacts%n
            if (contacts%normal_force(c) > 0.0_wp) touched(contacts%vertex(c)) = contacts%edge(c)
         end do
      end associate
   end function touched_edges

   !> How strongly the measured points that moved were shaken, along the axis of the largest
   !> velocity; a peak acceleration that is of higher frequencies is told as such.
   subroutine judge_points(verdict, simulation)
      type(run_verdict_type), intent(inout) :: verdict   !< of all frames and samples
      type(simulation_type), intent(in) :: simulation    !< at the time of the last
      character(len=:), allocatable :: name, along
      real(wp) :: arias, spectral, period, low
      integer :: i, axis

      do i = 1, size(verdict%shaken)
         associate (shaken => verdict%shaken(i))
            if (.not. maxval(shaken%acceleration) > 0.0_wp) cycle
            axis = main_axis(shaken)
            name = point_label(simulation%model%points(i)%name, i)
            along = 'along '//merge('x', 'y', axis == 1)
            arias = arias_intensity(shaken, axis)
            low = low_passed_peak(shaken%spectrum(axis))
            call spectral_acceleration(shaken%spectrum(axis), shaken%last(axis), spectral, period)
            call say(verdict, 'point '//name, along//': PGA '// &
               short_text(shaken%acceleration(axis))//' m/s², PGV '// &
               short_text(shaken%velocity(axis))//' m/s, Arias '//short_text(arias)//' m/s'// &
               low_peak_text(shaken%acceleration(axis), low))
            call say(verdict, 'Sa '//name, along//', 5 %: largest '//short_text(spectral)// &
               ' m/s² at '//short_text(period)//' s')
            call note(verdict, 'pga_m_s2['//name//']', shaken%acceleration(axis))
            call note(verdict, 'pga_below_50_hz_m_s2['//name//']', low)
            call note(verdict, 'pgv_m_s['//name//']', shaken%velocity(axis))
            call note(verdict, 'arias_m_s['//name//']', arias)
            call note(verdict, 'sa_m_s2['//name//']', spectral)
            call note(verdict, 'sa_period_s['//name//']', period)
         end associate
      end do
   end subroutine judge_points

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

   !> How much, and between which blocks.
   function where_text(verdict, simulation, number, what, largest) result(text)
      type(run_verdict_type), intent(in) :: verdict   !< of all frames
      type(simulation_type), intent(in) :: simulation    !< at the time of the last
      integer, intent(in) :: number              !< of contacts; 0: nothing to say
      character(len=*), intent(in) :: what       !< it is
      type(largest_type), intent(in) :: largest  !< by number of the contact, m
      character(len=:), allocatable :: text

      text = ''
      if (number == 0) return
      associate (c => largest%block, owner => simulation%blocks%owner)
         text = what//length_text(largest%value)//' ('//label(simulation, &
            owner(verdict%vertex(c)))//' on '//label(simulation, owner(verdict%edge(c)))//')'
      end associate
   end function where_text

   !> Growth of the gap, and way of the vertex along the edge, since the first frame, m.
   pure function gap_and_slip(corners, v, e, next, start) result(moved)
      real(wp), intent(in) :: corners(:,:), start(:,:)  !< [2, vertices] now and at first, m
      integer, intent(in) :: v, e, next         !< vertex; ends of the edge
      real(wp) :: moved(2)
      real(wp) :: along(2), apart(2), share, gap

      along = start(:, next) - start(:, e)
      apart = start(:, v) - start(:, e)
      share = dot_product(apart, along)/dot_product(along, along)
      gap = (along(2)*apart(1) - along(1)*apart(2))/norm2(along)
      along = corners(:, next) - corners(:, e)
      apart = corners(:, v) - corners(:, e) - share*along
      along = along/norm2(along)
      moved = [along(2)*apart(1) - along(1)*apart(2) - gap, dot_product(apart, along)]
   end function gap_and_slip

   !> Add a line.
   subroutine say(verdict, topic, sentence)
      type(run_verdict_type), intent(inout) :: verdict   !< of all frames
      character(len=*), intent(in) :: topic, sentence    !< of the line

      if (verdict%words /= '') verdict%words = verdict%words//new_line('a')
      verdict%words = verdict%words//topic//': '//sentence
   end subroutine say

   !> Add a value.
   pure subroutine note(verdict, name, value)
      type(run_verdict_type), intent(inout) :: verdict   !< of all frames
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
