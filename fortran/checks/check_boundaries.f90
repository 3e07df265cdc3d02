! SPDX-License-Identifier: GPL-3.0-or-later
!> Checks of absorbing boundaries: reflection at dashpots, waves from the sides, and difference
!> between the motions of the sides and of their free fields.
!>
!> Dashpots ρV_p along the normal and ρV_s along the edge reflect a part of the energy of plane
!> waves in plane strain (Lysmer and Kuhlemeyer 1969).  Units: V_s = 1, ρ = 1.  The incident wave
!> has the direction (sin i, cos i) to the edge y = 0.  p is the slowness along the edge, which is
!> the same for the incident and the reflected P and S waves.
!>
!> The difference of motions is estimated for waves that are long relative to the depth.  Ground of
!> depth H(x) on a radiating base moves horizontally like a bar, with u(x) constant over the depth:
!>
!>     (E'H u')' + (ρH ω² − iωZ) u = −2iωZ u_in ,
!>
!> with the modulus E' for plane strain, the impedance Z = ρV_s of the base, and dashpots at both
!> ends that connect the sides to the free field 2 u_in/(1 + iωρH/Z), the solution for level ground.
module dda_check_boundaries
   use dda_kinds, only: wp, pi
   use dda_blocks, only: blocks_type
   use dda_boundary, only: boundary_type
   use dda_check_report, only: add_check, report_type
   use dda_linear_model, only: linear_model_type
   use dda_model, only: model_type
   use dda_simulation, only: simulation_type
   use dda_text, only: short_text, to_text
   use dda_weld, only: is_shifted
   use dda_material, only: elasticity
   implicit none
   private
   public :: check_boundaries

   !> largest reflected fraction of amplitude accepted
   real(wp), parameter :: max_reflection = 0.02_wp
   real(wp), parameter :: absorbed = 0.99_wp        !< sufficient absorbed fraction of the energy
   real(wp), parameter :: max_departure = 0.1_wp  !< largest accepted difference of sides and fields
   real(wp), parameter :: touching_gap = 1.0e-6_wp  !< gap/half the model size of touching blocks
   character(len=*), parameter :: side_names(2) = [character(len=5) :: 'left', 'right']

   integer, parameter :: wave_p = 1, wave_s = 2  !< kinds of waves

   integer, parameter :: cells = 400  !< number of cells of the bar between both sides

   !> Bar with values per cell and at both ends.
   type :: bar_type
      real(wp) :: length = 0.0_wp                !< length of a cell, m
      real(wp) :: mass(cells) = 0.0_wp           !< ρH of each cell, kg/m²
      real(wp) :: modulus(cells) = 0.0_wp        !< E'H of each cell, N/m
      real(wp) :: impedance = 0.0_wp                  !< Z, Pa s/m
      real(wp) :: dashpot(2) = 0.0_wp  !< dashpot of the left and right side, N s/m per metre
   end type bar_type

contains

   !> Check the dashpots, the sides and the free fields of a model.
   subroutine check_boundaries(simulation, linear, report)
      type(simulation_type), intent(in) :: simulation  !< a run and its state
      type(linear_model_type), intent(in) :: linear  !< linearised model
      type(report_type), intent(inout) :: report  !< check report
      type(boundary_type), allocatable :: boundaries(:)
      real(wp), allocatable :: at(:,:)
      integer :: i

      associate (model => simulation%model, blocks => simulation%blocks)
         boundaries = [model%boundaries, (model%free_fields(i)%boundary, i=1, &
            size(model%free_fields))]
         if (size(boundaries) == 0) return
         call check_dashpots(blocks, boundaries, linear, report)
         at = model%blocks%position(1:2, blocks%owner) + blocks%reference
         if (size(model%boundaries) > 0) call check_sides(model, at, report)
         if (report%band%has_energy) call check_free_fields(model, at(1, :), report)
      end associate
   end subroutine check_boundaries

   !> Check the reflection at normal incidence, and the angle up to which dashpots absorb waves.
   subroutine check_dashpots(blocks, boundaries, linear, report)
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(boundary_type), intent(in) :: boundaries(:)  !< all boundaries with dashpots
      type(linear_model_type), intent(in) :: linear  !< linearised model
      type(report_type), intent(inout) :: report  !< check report
      character(len=:), allocatable :: finding, advice
      real(wp) :: ratio(2), by_blocks, by_scheme, largest_size
      integer :: i

      ratio = [huge(1.0_wp), 0.0_wp]
      largest_size = 0.0_wp
      do i = 1, size(boundaries)
         associate (quotient => boundaries(i)%dashpot(1, :)/boundaries(i)%dashpot(2, :))
            ratio = [min(ratio(1), minval(quotient)), max(ratio(2), maxval(quotient))]
         end associate
         largest_size = max(largest_size, slowest_crossing(blocks, boundaries(i)))
      end do
      finding = 'dashpots absorb 99 % of the energy of P waves up to '// &
         to_text(min(absorption_angle(ratio(1), wave_p), absorption_angle(ratio(2), wave_p)))// &
         '° from the normal, and of S waves up to '//to_text(min(absorption_angle(ratio(1), &
         wave_s), absorption_angle(ratio(2), wave_s)))//'°'
      advice = ''
      if (report%band%has_energy) then
         ! (kh)²/48, kh = ω h/V_s
         by_blocks = (2.0_wp*pi*report%band%highest*largest_size)**2/48.0_wp
         by_scheme = scheme_reflection(linear, report%band%highest)
         finding = finding//'; at normal incidence and '//short_text(report%band%highest)// &
            ' Hz they reflect '//short_text(100*by_blocks)//' % of the amplitude due to the '// &
            'block size and '//short_text(100*by_scheme)//' % due to the time step'
         if (by_blocks > max_reflection) advice = '; smaller blocks in front of the boundaries'
         if (by_scheme > max_reflection) advice = advice//'; a smaller time_step, or '// &
            "integration = 'midpoint' or 'theta'"
      end if
      call add_check(report, advice == '', 'dashpots', finding, &
         'Lysmer and Kuhlemeyer 1969', advice(min(3, len(advice) + 1):))
   end subroutine check_dashpots

   !> Longest time, s, in which an S wave crosses a block at a boundary.
   pure real(wp) function slowest_crossing(blocks, boundary) result(time)
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(boundary_type), intent(in) :: boundary  !< boundary with dashpots
      integer :: i

      time = 0.0_wp
      do i = 1, size(boundary%part)
         associate (b => boundary%part(i)%block, normal => boundary%normal(:, i))
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
   subroutine check_sides(model, at, report)
      type(model_type), intent(in) :: model  !< model as read from the input
      real(wp), intent(in) :: at(:,:)        !< [2,vertices] positions at the start, m
      type(report_type), intent(inout) :: report  !< check report
      real(wp) :: width, arrival, duration
      integer :: i
      logical :: arrives_late, sides_tied

      sides_tied = size(model%ties) > 0
      if (.not. sides_tied) sides_tied = any(is_shifted(model%welds))
      if (sides_tied .or. size(model%free_fields) == size(side_names)) return
      if (all([(is_side_fixed(model, at, side_names(i)), i=1, size(side_names))])) return
      duration = maxval([0.0_wp, (model%motions(i)%curve%duration, i=1, size(model%motions))])
      if (.not. duration > 0.0_wp) return
      width = maxval(at(1, :)) - minval(at(1, :))
      arrival = 0.5_wp*width/report%speed(2)
      arrives_late = arrival >= duration
      call add_check(report, arrives_late, 'sides', 'free or viscous '// &
         'sides do not move like level ground; waves from them reach the middle after '// &
         short_text(arrival)//' s (duration of the motion: '//short_text(duration)//' s)', &
         'width/(2 V_p)', "kind = 'free_field' at both sides, or 'tied' for level ground")
   end subroutine check_sides

   !> Warn if irregularities of the ground are too near to sides with free fields.
   subroutine check_free_fields(model, x, report)
      type(model_type), intent(in) :: model  !< model as read from the input
      real(wp), intent(in) :: x(:)           !< [vertices] positions at the start, m
      type(report_type), intent(inout) :: report  !< check report
      real(wp) :: frequency, departure, percent

      frequency = 0.5_wp*(report%band%lowest + report%band%highest)
      call find_side_departure(model, x, frequency, departure)
      if (departure < 0.0_wp) return
      percent = 0.01_wp*nint(1.0e4_wp*departure)
      call add_check(report, departure <= max_departure, 'sides', 'motions '// &
         'of the sides and their free fields will differ by about '//short_text(percent)//' %'// &
         ' at '//short_text(frequency)//' Hz, limit '//short_text(100.0_wp*max_departure) &
         //' %', 'long-wave estimate', 'more level ground before the sides')
   end subroutine check_free_fields

   !> .true. if a side has a free field, or a fixed point in its upper half.  Points at its foot fix
   !> only the base.
   logical function is_side_fixed(model, at, side)
      type(model_type), intent(in) :: model  !< model as read from the input
      real(wp), intent(in) :: at(:,:)        !< [2,vertices] positions at the start, m
      character(len=*), intent(in) :: side   !< 'left' or 'right'
      real(wp) :: line, middle, tolerance
      logical :: on_side(size(at, 2))
      integer :: i

      is_side_fixed = any([(model%free_fields(i)%side == side, i=1, size(model%free_fields))])
      tolerance = touching_gap*model%blocks%half_size
      line = merge(minval(at(1, :)), maxval(at(1, :)), side == 'left')
      on_side = abs(at(1, :) - line) <= tolerance
      middle = 0.5_wp*(minval(at(2, :), on_side) + maxval(at(2, :), on_side))
      do i = 1, size(model%fixed_points)
         associate (point => model%fixed_points(i))
            if (abs(point%position(1) - line) <= tolerance .and. point%position(2) > middle .and. &
               any(point%fixed_along)) is_side_fixed = .true.
         end associate
      end do
   end function is_side_fixed

   !> Fraction of the energy of a wave that is reflected as P and S waves together.
   pure real(wp) function reflected_energy(ratio, wave, angle)
      real(wp), intent(in) :: ratio  !< V_p/V_s, above √2
      integer, intent(in) :: wave    !< incident wave: wave_p or wave_s
      real(wp), intent(in) :: angle  !< angle from the normal, rad, below π/2
      complex(wp) :: normal(2), row(2, 2), rhs(2), amplitude(2), determinant
      real(wp) :: speed(2), p

      speed = [ratio, 1.0_wp]
      p = sin(angle)/speed(wave)
      normal = sqrt(cmplx(1.0_wp - (p*speed)**2, 0.0_wp, wp))  ! cosines of both waves
      if (p*ratio > 1.0_wp) normal(1) = -normal(1)  ! an evanescent P wave, which decays inwards
      row(:, wave_p) = stress_imbalance(ratio, wave_p, p, -normal(wave_p))
      row(:, wave_s) = stress_imbalance(ratio, wave_s, p, -normal(wave_s))
      rhs = -stress_imbalance(ratio, wave, p, normal(wave))
      determinant = row(1, 1)*row(2, 2) - row(1, 2)*row(2, 1)
      amplitude = [rhs(1)*row(2, 2) - rhs(2)*row(1, 2), rhs(2)*row(1, 1) &
         - rhs(1)*row(2, 1)]/determinant
      reflected_energy = sum(abs(amplitude)**2*speed*real(normal))/(speed(wave)*real(normal(wave)))
   end function reflected_energy

   !> Normal and tangential stress on the edge due to a unit wave, minus the stress of the dashpots,
   !> divided by −iω.
   pure function stress_imbalance(ratio, wave, p, cosine)
      real(wp), intent(in) :: ratio       !< V_p/V_s
      integer, intent(in) :: wave         !< wave_p or wave_s
      real(wp), intent(in) :: p           !< slowness along the edge
      complex(wp), intent(in) :: cosine   !< cosine of the wave direction to the outward normal
      complex(wp) :: stress_imbalance(2)
      complex(wp) :: d(2), u(2)
      real(wp) :: speed, lambda

      lambda = ratio**2 - 2.0_wp
      speed = merge(ratio, 1.0_wp, wave == wave_p)
      d = [cmplx(p*speed, 0.0_wp, wp), cosine]
      u = d
      if (wave == wave_s) u = [cosine, -d(1)]
      stress_imbalance(1) = (lambda*sum(d*u) + 2.0_wp*d(2)*u(2))/speed - ratio*u(2)
      stress_imbalance(2) = (d(2)*u(1) + d(1)*u(2))/speed - u(1)
   end function stress_imbalance

   !> Largest whole angle of incidence, degrees, up to which dashpots absorb nearly all energy.
   pure integer function absorption_angle(ratio, wave) result(angle)
      real(wp), intent(in) :: ratio  !< V_p/V_s
      integer, intent(in) :: wave    !< wave_p or wave_s

      do angle = 0, 88
         if (reflected_energy(ratio, wave, (angle + 1)*pi/180.0_wp) > 1.0_wp - absorbed) return
      end do
   end function absorption_angle

   !> Find the largest difference between a side and its free field, relative to the free field.
   !> It is negative (not defined) if no base radiates waves or no side has a free field.
   subroutine find_side_departure(model, x, frequency, departure)
      type(model_type), intent(in) :: model     !< model as read from the input
      real(wp), intent(in) :: x(:)              !< [vertices] positions at the start, m
      real(wp), intent(inout) :: frequency  !< Hz; reduced so that waves are at least 4 depths long
      real(wp), intent(out) :: departure        !< relative difference
      type(bar_type) :: bar
      complex(wp) :: u(cells + 1), field_motion(2)
      real(wp) :: omega

      departure = -1.0_wp
      bar = make_ground_bar(model, x)
      if (.not. (bar%impedance > 0.0_wp .and. maxval(bar%dashpot) > 0.0_wp)) return
      omega = min(2.0_wp*pi*frequency, 0.5_wp*pi*bar%impedance/maxval(bar%mass))
      frequency = omega/(2.0_wp*pi)
      field_motion = 2.0_wp/cmplx(1.0_wp, omega*bar%mass([1, cells])/bar%impedance, wp)
      u = bar_motion(bar, omega, field_motion)
      departure = maxval(abs(u([1, cells + 1])/field_motion - 1.0_wp), mask=bar%dashpot > 0.0_wp)
   end subroutine find_side_departure

   !> Distribute the blocks over the cells that they overlap, and set dashpots of base and sides.
   type(bar_type) function make_ground_bar(model, x) result(bar)
      type(model_type), intent(in) :: model  !< model as read from the input
      real(wp), intent(in) :: x(:)           !< [vertices] positions at the start, m
      real(wp) :: left_end, bottom, top, plane_modulus, overlap(cells)
      integer :: b, i

      left_end = minval(x)
      bar%length = (maxval(x) - left_end)/cells
      associate (blocks => model%blocks)
         do b = 1, blocks%n
            associate (block_x => x(blocks%first(b):blocks%first(b + 1) - 1), &
               elastic => blocks%area(b)*elasticity(model%materials(blocks%material(b)), &
               model%control%plane_strain))
               bottom = minval(block_x) - left_end
               top = maxval(block_x) - left_end
               overlap = [(max(0.0_wp, min(top, i*bar%length) - max(bottom, (i - 1)*bar%length)), &
                  i=1, cells)]/((top - bottom)*bar%length)
               plane_modulus = elastic(1, 1) - elastic(1, 2)**2/elastic(2, 2)
               bar%mass = bar%mass + overlap*blocks%mass(b)
               bar%modulus = bar%modulus + overlap*plane_modulus
            end associate
         end do
      end associate
      do i = 1, size(model%boundaries)
         if (model%boundaries(i)%kind == 'compliant') bar%impedance = bar%impedance &
            + 2.0_wp*sum(model%boundaries(i)%dashpot(2, :))/(cells*bar%length)
      end do
      do i = 1, size(model%free_fields)
         associate (field => model%free_fields(i), side => merge(1, 2, &
            model%free_fields(i)%side == 'left'))
            bar%dashpot(side) = 2.0_wp*sum(field%boundary%dashpot(1, :))
         end associate
      end do
   end function make_ground_bar

   !> Solve for the motion at the ends of the cells for u_in = 1, by tridiagonal elimination.
   pure function bar_motion(bar, omega, field_motion) result(u)
      type(bar_type), intent(in) :: bar   !< ground as a bar
      real(wp), intent(in) :: omega       !< rad/s
      complex(wp), intent(in) :: field_motion(2)  !< motion of the free fields of the sides
      complex(wp) :: u(cells + 1)
      complex(wp) :: diagonal(cells + 1), cell_term, side_dashpot(2)
      real(wp) :: k
      integer :: i

      diagonal = 0.0_wp
      u = 0.0_wp
      side_dashpot = cmplx(0.0_wp, omega*bar%dashpot, wp)
      diagonal([1, cells + 1]) = side_dashpot
      u([1, cells + 1]) = side_dashpot*field_motion
      do i = 1, cells
         cell_term = 0.5_wp*bar%length*cmplx(-omega**2*bar%mass(i), omega*bar%impedance, wp)
         diagonal(i:i + 1) = diagonal(i:i + 1) + bar%modulus(i)/bar%length + cell_term
         u(i:i + 1) = u(i:i + 1) + bar%length*cmplx(0.0_wp, omega*bar%impedance, wp)
      end do
      do i = 1, cells
         k = bar%modulus(i)/bar%length
         diagonal(i + 1) = diagonal(i + 1) - k**2/diagonal(i)
         u(i + 1) = u(i + 1) + k*u(i)/diagonal(i)
      end do
      u(cells + 1) = u(cells + 1)/diagonal(cells + 1)
      do i = cells, 1, -1
         u(i) = (u(i) + bar%modulus(i)/bar%length*u(i + 1))/diagonal(i)
      end do
   end function bar_motion

end module dda_check_boundaries
