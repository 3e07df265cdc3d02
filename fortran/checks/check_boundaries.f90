! SPDX-License-Identifier: GPL-3.0-or-later
!> Checks of absorbing boundaries: reflection at dashpots, waves from the sides, and difference
!> between the motions of the sides and of their free fields.
module dda_check_boundaries
   use dda_kinds, only: wp, pi
   use dda_blocks, only: blocks_type
   use dda_boundary, only: boundary_type
   use dda_check_report, only: report_type, add_line, verdict_ok, verdict_warn, advice_if
   use dda_linear_model, only: linear_model_type
   use dda_model, only: model_type
   use dda_oblique_reflection, only: wave_p, wave_s, absorbed_angle
   use dda_side_departure, only: find_side_departure
   use dda_simulation, only: simulation_type
   use dda_text, only: short_text, to_text
   use dda_weld, only: is_shifted
   implicit none
   private
   public :: check_boundaries

   real(wp), parameter :: most_reflected = 0.02_wp  !< largest reflected amplitude without a warning
   real(wp), parameter :: absorbed = 0.99_wp        !< sufficient absorbed fraction of the energy
   real(wp), parameter :: most_departure = 0.1_wp   !< largest difference of sides and fields
   real(wp), parameter :: touching = 1.0e-6_wp      !< largest closed gap over half the model size
   character(len=*), parameter :: side_names(2) = [character(len=5) :: 'left', 'right']

contains

   !> Check the dashpots of a model, and its sides.
   subroutine check_boundaries(simulation, linear, report)
      type(simulation_type), intent(in) :: simulation  !< a run and its state
      type(linear_model_type), intent(in) :: linear  !< linearised model
      type(report_type), intent(inout) :: report  !< check report
      type(boundary_type), allocatable :: all_of(:)
      real(wp), allocatable :: x(:)
      integer :: i

      associate (model => simulation%model, blocks => simulation%blocks)
         all_of = [model%boundaries, (model%free_fields(i)%boundary, i=1, size(model%free_fields))]
         if (size(all_of) == 0) return
         call check_dashpots(blocks, all_of, linear, report)
         x = model%blocks%position(1, blocks%owner) + blocks%reference(1, :)
         if (size(model%boundaries) > 0) call check_sides(model, x, report)
         if (report%band%known) call check_free_fields(model, x, report)
      end associate
   end subroutine check_boundaries

   !> Check the reflection of normally incident waves and the angle up to which dashpots absorb.
   subroutine check_dashpots(blocks, boundaries, linear, report)
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(boundary_type), intent(in) :: boundaries(:)  !< all boundaries with dashpots
      type(linear_model_type), intent(in) :: linear  !< linearised model
      type(report_type), intent(inout) :: report  !< check report
      character(len=:), allocatable :: found, advice
      real(wp) :: ratio(2), by_blocks, by_scheme, worst
      integer :: i

      ratio = [huge(1.0_wp), 0.0_wp]
      worst = 0.0_wp
      do i = 1, size(boundaries)
         associate (quotient => boundaries(i)%dashpot(1, :)/boundaries(i)%dashpot(2, :))
            ratio = [min(ratio(1), minval(quotient)), max(ratio(2), maxval(quotient))]
         end associate
         worst = max(worst, slowest_crossing(blocks, boundaries(i)))
      end do
      found = '99 % of the energy is absorbed up to '// &
         to_text(min(absorption_angle(ratio(1), wave_p), absorption_angle(ratio(2), wave_p)))// &
         '° from the normal for P waves, '//to_text(min(absorption_angle(ratio(1), wave_s), &
         absorption_angle(ratio(2), wave_s)))//'° for S waves'
      advice = ''
      if (report%band%known) then
         ! (kh)²/48, kh = ω h/V_s
         by_blocks = (2.0_wp*pi*report%band%highest*worst)**2/48.0_wp
         by_scheme = scheme_reflection(linear, report%band%highest)
         found = found//'; at normal incidence and '//short_text(report%band%highest)// &
            ' Hz dashpots reflect '//short_text(100*by_blocks)//' % due to the block size and '// &
            short_text(100*by_scheme)//' % due to the time step'
         if (by_blocks > most_reflected) advice = '; smaller blocks in front of the boundaries'
         if (by_scheme > most_reflected) advice = advice//'; a smaller time_step, or '// &
            "integration = 'midpoint' or 'theta'"
      end if
      call add_line(report, merge(verdict_ok, verdict_warn, advice == ''), 'dashpots', found, &
         'Lysmer and Kuhlemeyer 1969', advice(min(3, len(advice) + 1):))
   end subroutine check_dashpots

   !> Angle of incidence, degrees, up to which the dashpots absorb nearly all energy of a wave.
   pure integer function absorption_angle(ratio, wave)
      real(wp), intent(in) :: ratio  !< V_p/V_s
      integer, intent(in) :: wave    !< wave_p or wave_s

      absorption_angle = absorbed_angle(ratio, wave, 1.0_wp - absorbed)
   end function absorption_angle

   !> Longest time, s, in which an S wave crosses a block at a boundary.
   pure real(wp) function slowest_crossing(blocks, boundary) result(time)
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(boundary_type), intent(in) :: boundary  !< boundary with dashpots
      integer :: i

      time = 0.0_wp
      do i = 1, size(boundary%piece)
         associate (b => boundary%piece(i)%block, normal => boundary%normal(:, i))
            if (blocks%removed(b)) cycle
            associate (depth => matmul(normal, blocks%reference(:, &
               blocks%first(b):blocks%first(b + 1) - 1)))
               time = max(time, (maxval(depth) - minval(depth)) &
                  /sqrt(blocks%stiffness(3, 3, b)/blocks%mass(b)))
            end associate
         end associate
      end do
   end function slowest_crossing

   !> Reflected fraction of the amplitude at matched dashpots due to the time integration.
   !> In steady vibration stresses have the factor (1 + iaτ)(1 + ibτ), a = 2θ − 1, b = 2χ − 1, and
   !> dashpot forces have 1 + ibτ.  In the original DDA the result is τ/4, about ωΔt/8.
   pure real(wp) function scheme_reflection(linear, frequency) result(reflected)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      real(wp), intent(in) :: frequency  !< Hz
      complex(wp) :: impedance
      real(wp) :: tau

      tau = tan(min(pi*frequency*linear%time_step, 0.499_wp*pi))
      impedance = sqrt(cmplx(1.0_wp, (2.0_wp*linear%scheme%theta - 1.0_wp)*tau, wp) &
         /cmplx(1.0_wp, (2.0_wp*linear%scheme%chi - 1.0_wp)*tau, wp))
      reflected = abs((impedance - 1.0_wp)/(impedance + 1.0_wp))
   end function scheme_reflection

   !> Warn if waves from free or viscous sides reach the middle of the model during the motion.
   subroutine check_sides(model, x, report)
      type(model_type), intent(in) :: model  !< model as read from the input
      real(wp), intent(in) :: x(:)           !< [vertices] positions at the start, m
      type(report_type), intent(inout) :: report  !< check report
      real(wp) :: width, arrival, duration
      integer :: i
      logical :: late, tied

      tied = size(model%ties) > 0
      if (.not. tied) tied = any(is_shifted(model%welds))
      if (tied .or. size(model%free_fields) == size(side_names)) return
      if (all([(is_side_fixed(model, x, side_names(i)), i=1, size(side_names))])) return
      duration = 0.0_wp
      do i = 1, size(model%motions)
         duration = max(duration, model%motions(i)%curve%duration)
      end do
      if (.not. duration > 0.0_wp) return
      width = maxval(x) - minval(x)
      arrival = 0.5_wp*width/report%speed(2)
      late = arrival >= duration
      call add_line(report, merge(verdict_ok, verdict_warn, late), 'sides', 'free or viscous '// &
         'sides do not move like level ground; their waves reach the middle after '// &
         short_text(arrival)//' s of '//short_text(duration)//' s of motion', 'width/(2 V_p)', &
         advice_if(.not. late, "kind = 'free_field' at both sides, or 'tied' for level ground"))
   end subroutine check_sides

   !> Warn if irregularities of the ground are too near to sides with free fields.
   subroutine check_free_fields(model, x, report)
      type(model_type), intent(in) :: model  !< model as read from the input
      real(wp), intent(in) :: x(:)           !< [vertices] positions at the start, m
      type(report_type), intent(inout) :: report  !< check report
      real(wp) :: frequency, departure, percent
      logical :: near

      frequency = 0.5_wp*(report%band%lowest + report%band%highest)
      call find_side_departure(model, x, frequency, departure)
      if (departure < 0.0_wp) return
      near = departure > most_departure
      percent = 0.01_wp*nint(1.0e4_wp*departure)
      call add_line(report, merge(verdict_warn, verdict_ok, near), 'sides', 'motions '// &
         'of the sides and their free fields will differ by about '//short_text(percent)//' %'// &
         ' at '//short_text(frequency)//' Hz, limit '//short_text(100.0_wp*most_departure) &
         //' %', 'long-wave estimate', advice_if(near, 'more level ground before the sides'))
   end subroutine check_free_fields

   !> .true. if fixed points or a free field are on a side.
   logical function is_side_fixed(model, x, side)
      type(model_type), intent(in) :: model  !< model as read from the input
      real(wp), intent(in) :: x(:)           !< [vertices] positions at the start, m
      character(len=*), intent(in) :: side   !< 'left' or 'right'
      real(wp) :: line, small
      integer :: i

      is_side_fixed = any([(model%free_fields(i)%side == side, i=1, size(model%free_fields))])
      small = touching*model%blocks%half_size
      line = merge(minval(x), maxval(x), side == 'left')
      do i = 1, size(model%fixed_points)
         associate (point => model%fixed_points(i))
            if (abs(point%place(1) - line) <= small .and. any(point%held)) is_side_fixed = .true.
         end associate
      end do
   end function is_side_fixed

end module dda_check_boundaries
