! SPDX-License-Identifier: GPL-3.0-or-later
!> Checks of a simulation in its initial state; each check adds one or two lines to the report.
module dda_check_simulation
   use dda_kinds, only: wp, long, pi
   use dda_interrupts, only: fail_if_stopped
   use dda_advice, only: penalty_type, find_penalty_for_shift, find_stiff_limit
   use dda_blocks, only: blocks_type, smaller_side
   use dda_check_bodies, only: check_bodies, body_or_block_count, block_count_text, dispersion_text
   use dda_check_boundaries, only: check_boundaries
   use dda_contact, only: contact_open
   use dda_equilibrium, only: find_farthest_block
   use dda_check_material, only: check_laws, check_material
   use dda_check_band, only: band_type, find_significant_band
   use dda_check_report, only: add_check, add_line, first_mode, report_type, ringing_topic, &
      verdict_fail, verdict_ok, verdict_warn
   use dda_errors, only: error_type
   use dda_linear_model, only: linear_model_type, is_dispersive, linearise, set_moduli_at, &
      unrelaxed
   use dda_linear_terms, only: at_theta, term_normal
   use dda_impact_regime, only: impact_regime_type, find_impact_regime
   use dda_model, only: run_steps
   use dda_modes, only: find_modes
   use dda_omega_max, only: find_omega_max
   use dda_ringing, only: ringing_type, find_ringing
   use dda_scheme_response, only: forced_damping
   use dda_simulation, only: simulation_type, block_name, gravity_is_sudden
   use dda_stage, only: stage_type
   use dda_text, only: counted, quoted, to_text, short_text
   use dda_time_step, only: advance
   use dda_unresolved, only: count_unresolved
   implicit none
   private
   public :: check_simulation, check_model

   !> largest accepted number of steps in which the slowest alternating mode decays to 1/e
   real(wp), parameter :: max_ringing_steps = 1000.0_wp
   integer, parameter :: reported_modes = 5  !< number of reported modes
   !> number of timed steps; largest number of blocks of a timed model
   integer, parameter :: timed_steps = 3, timed_blocks = 5000
   integer, parameter :: many_blocks = 1000              !< for more blocks, sudden gravity is slow
   integer, parameter :: stiff_limit_blocks = 20000 !< most blocks for the effect of the penalty
   real(wp), parameter :: min_slope = 0.5_wp  !< |n·g|/|g| below which a joint is a head joint

contains

   !> Check a started simulation and estimate the cost of its run; the simulation does not change.
   subroutine check_simulation(simulation, report, error)
      type(simulation_type), intent(in) :: simulation  !< a run and its state
      type(report_type), intent(inout) :: report  !< check report, with notes on the model if any
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      integer(long) :: off_diagonals

      call check_model(simulation, report, error, off_diagonals)
      if (allocated(error)) return
      call check_cost(simulation, off_diagonals, report)
      call fail_if_stopped(error)
   end subroutine check_simulation

   !> Check a started simulation, which does not change.
   subroutine check_model(simulation, report, error, off_diagonals, budget)
      type(simulation_type), intent(in) :: simulation  !< a run and its state
      type(report_type), intent(inout) :: report  !< check report, with notes on the model if any
      type(error_type), allocatable, intent(out) :: error  !< allocated on failure
      integer(long), intent(out), optional :: off_diagonals  !< number of off-diagonal blocks of K̂
      integer(long), intent(in), optional :: budget  !< most iterations to find equilibrium
      type(linear_model_type) :: linear, stiff
      type(impact_regime_type) :: impacts
      integer :: i

      call linearise(linear, simulation, 'auto', error, budget)
      if (allocated(error)) return
      call unrelaxed(linear, stiff)
      call find_significant_band(simulation%model%motions, report%band)
      call measure_blocks(simulation%blocks, report)
      call check_contacts(simulation, linear, report)
      call check_stages(simulation%model%stages, report)
      call check_sudden_gravity(simulation, report)
      do i = 1, size(linear%bending)
         call add_line(report, verdict_warn, linear%bending(i)%topic, linear%bending(i)%text, &
            'linear stress', '')
      end do
      call check_omega_max(stiff, report)
      call fail_if_stopped(error)
      if (allocated(error)) return
      call check_ringing(stiff, report)
      call find_impact_regime(linear, simulation, impacts)
      if (impacts%text /= '') call add_line(report, verdict_ok, 'impacts', impacts%text, &
         'closed forms', impacts%advice)
      call fail_if_stopped(error)
      if (allocated(error)) return
      call check_modes(linear, report)
      call fail_if_stopped(error)
      if (allocated(error)) return
      if (report%has_modes) call set_moduli_at(linear, report%modes%frequency(1))
      call check_penalty(simulation, linear, report, with_advice=.not. present(budget))
      call check_penalty_bounds(simulation, linear, report)
      call check_resolution(simulation%blocks, linear%time_step, report)
      call check_damping(linear, report)
      call check_material(simulation, linear, report)
      call check_laws(simulation, report)
      call check_bodies(simulation, report)
      call check_boundaries(simulation, linear, report)
      if (present(off_diagonals)) off_diagonals = size(linear%stiffness%column, kind=long)
      call fail_if_stopped(error)
   end subroutine check_model

   !> Warn if a later dynamic stage has longer steps or another integration than the first dynamic
   !> stage, which the report describes.
   subroutine check_stages(stages, report)
      type(stage_type), intent(in) :: stages(:)  !< stages of the model
      type(report_type), intent(inout) :: report  !< check report
      integer :: first, s

      first = findloc(stages%static, .false., 1)
      do s = first + 1, merge(size(stages), 0, first > 0)
         associate (stage => stages(s), checked => stages(first))
            if (stage%static) cycle
            if (stage%time_step <= checked%time_step .and. &
               stage%integration == checked%integration) cycle
            call add_line(report, verdict_warn, 'stages', 'lines on time steps describe stage '// &
               quoted(trim(checked%name))//'; stage '//quoted(trim(stage%name))// &
               ' has time_step = '//short_text(stage%time_step)//' s and integration = '// &
               quoted(trim(stage%integration)), 'input', 'a check without the earlier stages')
            return
         end associate
      end do
   end subroutine check_stages

   !> Determine the sizes of blocks and their wave speeds for the report.
   subroutine measure_blocks(blocks, report)
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(report_type), intent(inout) :: report  !< check report
      real(wp) :: smaller_length, density, speed(2)
      integer :: b

      report%block_size = [huge(1.0_wp), 0.0_wp]
      report%speed = [huge(1.0_wp), 0.0_wp]
      report%min_crossing_time = huge(1.0_wp)
      report%max_crossing_time = 0.0_wp
      do b = 1, blocks%n
         if (blocks%removed(b)) cycle
         smaller_length = smaller_side(blocks, b)
         density = blocks%mass(b)
         report%block_size = [min(report%block_size(1), smaller_length), max(report%block_size(2), &
            smaller_length)]
         speed = sqrt([blocks%stiffness(3, 3, b), blocks%stiffness(1, 1, b)]/density)
         report%speed = [min(report%speed(1), speed(1)), max(report%speed(2), speed(2))]
         report%min_crossing_time = min(report%min_crossing_time, smaller_length/speed)
         if (smaller_length/speed(1) > report%max_crossing_time) report%slow_speed = speed(1)
         report%max_crossing_time = max(report%max_crossing_time, smaller_length/speed(1))
      end do
   end subroutine measure_blocks

   !> Report blocks and closed contacts; warn if separate blocks do not touch.
   subroutine check_contacts(simulation, linear, report)
      type(simulation_type), intent(in) :: simulation  !< a run and its state
      type(linear_model_type), intent(in) :: linear  !< linearised model
      type(report_type), intent(inout) :: report  !< check report
      character(len=:), allocatable :: start_text
      real(wp) :: distance
      integer :: b, n_bodies

      start_text = ''
      if (allocated(linear%equilibrium%text)) start_text = '; '//linear%equilibrium%text
      b = 0
      if (simulation%model%stages(1)%static) call find_farthest_block(simulation%blocks, &
         simulation%model%blocks%position, b, distance)
      if (b > 0) start_text = start_text//'; block '//block_name(simulation, b)// &
         ' is '//short_text(distance)//' m from its position in the input'
      n_bodies = body_or_block_count(simulation%model)
      if (linear%n_closed == 0 .and. n_bodies > 1) then
         call add_line(report, verdict_warn, 'contacts', 'no contact is closed'//start_text, &
            'model', 'contacts exist only at edges that touch; check the vertices')
      else
         call add_line(report, verdict_ok, 'contacts', block_count_text(simulation%model)//', '// &
            counted(to_text(linear%n_closed), 'closed contact', 'closed contacts')//start_text, &
            'model', '')
      end if
   end subroutine check_contacts

   !> Warn if gravity acts suddenly on many blocks with closed head joints.
   !> Contacts of head joints neither press nor open until the first wave of settlement has passed.
   subroutine check_sudden_gravity(simulation, report)
      type(simulation_type), intent(in) :: simulation  !< a run and its state
      type(report_type), intent(inout) :: report  !< check report
      integer :: c, head_joints

      associate (contacts => simulation%contacts(simulation%now), model => simulation%model)
         if (model%blocks%n <= many_blocks .or. .not. gravity_is_sudden(model)) return
         head_joints = count([(contacts%state(c) /= contact_open .and. &
            abs(dot_product(contacts%normal(:, c), model%control%gravity)) < &
            min_slope*norm2(model%control%gravity), c=1, contacts%n)])
         if (head_joints == 0) return
         call add_line(report, verdict_warn, 'start', 'gravity acts suddenly on '// &
            to_text(model%blocks%n)//' blocks with '//to_text(head_joints)//' closed contacts '// &
            'in head joints, so the first steps take 10 to 50 times as long as later ones', &
            'model', 'geostatic = .true. and a head_joint of &wall above 0')
      end associate
   end subroutine check_sudden_gravity

   !> Report ω_max, and Δt relative to 4/ω_max.
   subroutine check_omega_max(linear, report)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      type(report_type), intent(inout) :: report  !< check report
      type(error_type), allocatable :: error
      real(wp) :: limit
      logical :: resolved
      character(len=:), allocatable :: finding

      call find_omega_max(linear, report%omega_max, error)
      if (allocated(error)) then
         report%omega_max%omega = 0.0_wp     ! it was not found
         report%omega_max%residual = 0.0_wp
         call add_line(report, verdict_warn, 'highest frequency', error%message, 'ARPACK', '')
         return
      end if
      report%has_highest = report%omega_max%omega > 0.0_wp
      call add_line(report, verdict_ok, 'highest frequency', report%omega_max%text, &
         'ARPACK and bracket', '')
      if (.not. report%has_highest) return
      limit = 4.0_wp/report%omega_max%omega
      call count_unresolved(linear, linear%time_step, report%unresolved, error)
      resolved = linear%time_step < limit
      finding = 'time_step = '//short_text(linear%time_step)//' s '//merge('<', '>', resolved)// &
         ' 4/ω = '//short_text(limit)//' s of the highest frequency'
      if (.not. (resolved .or. allocated(error))) finding = finding//'; '//report%unresolved%text
      ! No warning: most contacts are similarly stiff, and the line on ringing shows the effect.
      call add_line(report, verdict_ok, 'time step', finding, 'paper eq. 13', '')
   end subroutine check_omega_max

   !> Report the decay of velocities that change sign in each step.
   !> Warn if the decay takes more than `max_ringing_steps` steps.
   subroutine check_ringing(linear, report)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      type(report_type), intent(inout) :: report  !< check report
      type(ringing_type) :: ringing
      type(error_type), allocatable :: error

      call find_ringing(linear, ringing, error)
      if (allocated(error)) then
         call add_line(report, verdict_warn, 'ringing', error%message, 'ARPACK', '')
         return
      end if
      report%ringing_steps = ringing%steps
      call add_check(report, .not. ringing%steps > max_ringing_steps, 'ringing', ringing%text, &
         'roots of the scheme', ringing%advice, ringing_topic, ringing%brief)
   end subroutine check_ringing

   !> Report the lowest modes, and check whether the first one oscillates with the present Δt.
   subroutine check_modes(linear, report)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      type(report_type), intent(inout) :: report  !< check report
      type(error_type), allocatable :: error
      character(len=:), allocatable :: frequencies
      integer :: i

      call find_modes(linear, reported_modes, report%modes, error)
      if (allocated(error)) then
         call add_line(report, verdict_warn, 'lowest modes', error%message, 'ARPACK', '')
         return
      end if
      report%has_modes = report%modes%n > 0
      frequencies = ''
      do i = 1, report%modes%n
         if (i > 1) frequencies = frequencies//', '
         frequencies = frequencies//short_text(report%modes%frequency(i))
      end do
      if (report%has_modes) frequencies = frequencies//' Hz; '
      call add_check(report, report%has_modes, 'lowest modes', frequencies//report%modes%text, &
         'ARPACK', '')
      if (.not. report%has_modes) return
      if (report%modes%elongation(1) < 0.0_wp) then
         call add_line(report, verdict_fail, 'first mode', 'this mode does not oscillate, '// &
            'because ω Δt = '//short_text(report%modes%omega(1)*linear%time_step)//' > 4', &
            'paper eq. 13', 'time_step below '//short_text(0.1_wp/report%modes%frequency(1))// &
            ' s', first_mode, 'does not oscillate, ω Δt = '// &
            short_text(report%modes%omega(1)*linear%time_step)//' > 4')
      else
         call add_check(report, report%modes%elongation(1) < 0.01_wp, 'first mode', &
            'the time integration lengthens the period by '// &
            short_text(100*report%modes%elongation(1))//' %, limit 1 %', 'scheme', &
            'a smaller time_step', first_mode, 'period '// &
            short_text(100*report%modes%elongation(1))//' % too long')
      end if
   end subroutine check_modes

   !> Report the ratio of penalty to block stiffness, and the effect on the first frequency.
   subroutine check_penalty(simulation, linear, report, with_advice)
      type(simulation_type), intent(in) :: simulation  !< a run and its state
      type(linear_model_type), intent(in) :: linear  !< linearised model, moduli at the first mode
      type(report_type), intent(inout) :: report  !< check report
      logical, intent(in) :: with_advice  !< report costs, and the penalty for a shift of 1 %
      character(len=*), parameter :: source = 'paper section 2.2: 40 E'
      type(error_type), allocatable :: error
      type(linear_model_type) :: work
      real(wp) :: rigid_frequency
      character(len=:), allocatable :: finding

      finding = 'normal_stiffness = '//short_text(linear%normal_stiffness)//' N/m = '// &
         short_text(linear%normal_stiffness/maxval(simulation%model%materials%young_modulus))// &
         ' × Young''s modulus × 1 m'
      if (linear%n > stiff_limit_blocks) finding = finding//'; its effect on the first '// &
         'frequency is computed up to '//to_text(stiff_limit_blocks)//' blocks'
      if (.not. report%has_modes .or. linear%n_by_penalty == 0 &
         .or. linear%n > stiff_limit_blocks) then
         call add_line(report, verdict_ok, 'penalty', finding, source, '')
         return
      end if
      work = linear
      call find_stiff_limit(work, rigid_frequency, error)
      if (allocated(error)) then
         call add_line(report, verdict_ok, 'penalty', finding//'; '//error%message, source, '')
         return
      end if
      report%frequency_shift = 1.0_wp - report%modes%frequency(1)/rigid_frequency
      finding = finding//'; joints lower the first frequency by '// &
         short_text(100*report%frequency_shift)//' %, limit 5 %'
      if (with_advice) finding = finding//'; '//penalty_cost_text(linear, rigid_frequency)
      call add_check(report, report%frequency_shift < 0.05_wp, 'penalty', finding, 'stiff limit', &
         'a higher normal_stiffness, unless soft joints are intended', first_mode, &
         'joints lower the frequency by '//short_text(100*report%frequency_shift)//' % ('// &
         counted(to_text(linear%n_by_penalty), 'contact', 'contacts')//')')
   end subroutine check_penalty

   !> Text on what the penalty costs and saves, now and if it reduces the first frequency by 1 %.
   !>
   !> The contact iteration converges more slowly for a larger condition number of K̂ relative to
   !> inertia, κ ≈ 1 + χ z k_n Δt²/m; z k_n/m is the largest ratio of contact stiffness to block
   !> mass.  Bonded contacts act at t₀ + θΔt and count θ times.  Penetrations are proportional to
   !> 1/k_n.
   function penalty_cost_text(linear, rigid_frequency) result(text)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      real(wp), intent(in) :: rigid_frequency  !< first frequency for k → ∞, Hz
      character(len=:), allocatable :: text
      type(penalty_type) :: penalty
      type(error_type), allocatable :: error
      real(wp) :: springs(linear%n), cost, spring, ratio
      integer :: i

      springs = 0.0_wp
      do i = linear%element_terms + 1, linear%terms%n
         associate (term => linear%terms%term(i))
            if (term%kind /= term_normal .or. .not. term%of_penalty) cycle
            spring = term%coefficient
            if (term%instant == at_theta) spring = linear%scheme%theta*spring
            springs(term%block_a) = springs(term%block_a) + spring
            if (term%block_b > 0) springs(term%block_b) = springs(term%block_b) + spring
         end associate
      end do
      cost = linear%scheme%chi*linear%time_step**2*maxval(springs/linear%block_mass, &
         mask=linear%block_mass > 0.0_wp)
      text = penetration_text(1.0_wp)//'the condition number of the contact iteration is about '// &
         short_text(1.0_wp + cost)
      if (is_dispersive(linear)) then
         call find_penalty_for_shift(linear, 1.0_wp, penalty, error)
      else
         call find_penalty_for_shift(linear, 1.0_wp, penalty, error, reference=rigid_frequency)
      end if
      if (allocated(error) .or. .not. penalty%reached) return
      ratio = penalty%normal_stiffness/linear%normal_stiffness
      text = text//'; with normal_stiffness = '//short_text(penalty%normal_stiffness)// &
         ' N/m, joints lower it by 1 %, '//penetration_text(ratio)// &
         'the condition number is about '//short_text(1.0_wp + ratio*cost)

   contains

      !> Text on the penetration with a multiple of the penalty; empty without penetration.
      pure function penetration_text(factor) result(penetrates)
         real(wp), intent(in) :: factor  !< new k_n over present k_n
         character(len=:), allocatable :: penetrates

         penetrates = ''
         if (linear%penetration > 0.0_wp) penetrates = 'static contacts penetrate by '// &
            short_text(linear%penetration/factor)//' m, '
      end function penetration_text
   end function penalty_cost_text

   !> Check the static penetration and the forces due to rounding of positions.
   !> A higher penalty reduces the penetration and increases the forces due to rounding.
   subroutine check_penalty_bounds(simulation, linear, report)
      type(simulation_type), intent(in) :: simulation  !< a run and its state
      type(linear_model_type), intent(in) :: linear  !< linearised model
      type(report_type), intent(inout) :: report  !< check report
      real(wp), parameter :: most_penetration = 0.01_wp, max_noise = 1.0e-3_wp
      real(wp) :: depth, noise, weight
      character(len=:), allocatable :: brief, remedy

      weight = norm2(simulation%model%control%gravity)*minval(simulation%blocks%mass, &
         mask=.not. simulation%blocks%removed)
      if (weight == 0.0_wp .or. linear%n_closed == 0) return
      depth = linear%penetration/report%block_size(1)
      noise = simulation%iteration%noise/weight
      brief = 'rounding of contact forces reaches '//short_text(100*noise)// &
         ' % of the smallest weight'
      remedy = 'a lower normal_stiffness'
      if (depth > most_penetration) then
         brief = 'static contacts penetrate by '//short_text(100*depth)//' % of the smallest block'
         remedy = 'a higher normal_stiffness, or set penetration_tolerance'
         if (noise > max_noise) remedy = 'set penetration_tolerance'
      end if
      call add_check(report, depth <= most_penetration .and. noise <= max_noise, 'penalty bounds', &
         'static contacts penetrate by '//short_text(100*depth)//' % of the smallest block, '// &
         'limit '//short_text(100*most_penetration)//' %; rounding of contact forces reaches '// &
         short_text(100*noise)//' % of the smallest weight, limit '//short_text(100*max_noise)// &
         ' %', 'statics', remedy, brief=brief)
   end subroutine check_penalty_bounds

   !> Report ratios of block size to wavelength, and of Δt to the time in which waves cross blocks.
   subroutine check_resolution(blocks, time_step, report)
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      real(wp), intent(in) :: time_step  !< Δt, s
      type(report_type), intent(inout) :: report  !< check report
      real(wp), parameter :: coarsest = 1.0_wp/12  ! of a wavelength or a period
      real(wp) :: eta, period
      character(len=:), allocatable :: remedy

      call add_line(report, verdict_ok, 'CFL', 'wave fronts require time_step below Δx/v = '// &
         short_text(report%min_crossing_time(2))//' s (P), '// &
         short_text(report%min_crossing_time(1))//' s (S); '// &
         'the scheme is stable for larger time steps', 'paper eq. 14', '')
      if (.not. report%band%has_energy) return
      period = 1.0_wp/report%band%highest
      eta = report%max_crossing_time*report%band%highest
      remedy = ''
      if (eta > coarsest) remedy = 'blocks no larger than '// &
         short_text(coarsest*report%slow_speed/report%band%highest)//' m'
      call add_line(report, merge(verdict_ok, merge(verdict_warn, verdict_fail, eta <= 0.5_wp), &
         eta <= coarsest), 'element size', 'the block size is λ/'//short_text(1/eta)//' at '// &
         short_text(report%band%highest)//' Hz, limit λ/12 (strict: λ/20); these waves are '// &
         dispersion_text(blocks, eta), 'paper eq. 12', remedy, 'element size: '// &
         counted(to_text(count_longer(blocks, coarsest*period)), 'block', 'blocks')//', λ/'// &
         short_text(1/eta)//' at '//short_text(report%band%highest)//' Hz, limit λ/12')
      ! Small blocks do not require a smaller time step than the wave does.
      call add_check(report, time_step < max(eta, coarsest)*period, 'time resolution', &
         'time_step = '//short_text(time_step)//' s; limit: the larger of T/12 = '// &
         short_text(coarsest*period)//' s and the time in which an S wave crosses a block, '// &
         short_text(eta*period)//' s', 'paper eq. 15', 'a smaller time_step')
   end subroutine check_resolution

   !> Number of blocks in which a shear wave takes more than a given time to cross the smaller side.
   pure integer function count_longer(blocks, limit) result(count)
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      real(wp), intent(in) :: limit            !< s
      integer :: b

      count = 0
      do b = 1, blocks%n
         if (blocks%removed(b)) cycle
         if (smaller_side(blocks, b)*sqrt(blocks%mass(b)/blocks%stiffness(3, 3, b)) > limit) &
            count = count + 1
      end do
   end function count_longer

   !> Report the numerical damping ratio at the first mode and over the band of the record.
   subroutine check_damping(linear, report)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      type(report_type), intent(inout) :: report  !< check report
      real(wp) :: first_ratio
      logical :: resolves_band
      character(len=:), allocatable :: finding, advice, topic, brief

      first_ratio = 0.0_wp
      finding = ''
      if (report%has_modes) then
         first_ratio = report%modes%of_scheme(1)
         finding = short_text(100*first_ratio)//' % at '// &
            short_text(report%modes%frequency(1))//' Hz'
      end if
      resolves_band = .true.
      if (report%band%has_energy) then
         resolves_band = report%band%highest < 0.5_wp/linear%time_step
         if (finding /= '') finding = finding//'; '
         finding = finding//damping_range_text(report%band, linear)
      end if
      if (finding == '') return
      advice = 'time_step for a given ratio (sitedda.time_step_for_damping), or '// &
         "integration = 'theta' with damping_ratio and damping_frequency"
      topic = first_mode
      brief = 'numerical damping '//short_text(100*first_ratio)//' %'
      if (.not. resolves_band) then
         advice = 'time_step below '//short_text(0.5_wp/report%band%highest)//' s'
         topic = 'time step'
         brief = 'motions reach '//short_text(report%band%highest)//' Hz, steps '// &
            'resolve only '//short_text(0.5_wp/linear%time_step)//' Hz'
      end if
      call add_check(report, first_ratio < 0.1_wp .and. resolves_band, 'damping', &
         'numerical damping ratio '//finding, '2ζ = (a + b) τ/(1 − a b τ²), τ = tan(ω Δt/2)', &
         advice, topic, brief)
   end subroutine check_damping

   !> Text on the numerical damping ratio over a band up to the Nyquist frequency.
   pure function damping_range_text(band, linear) result(text)
      type(band_type), intent(in) :: band  !< band of the motions, Hz
      type(linear_model_type), intent(in) :: linear  !< linearised model
      character(len=:), allocatable :: text
      character(len=:), allocatable :: limit_text
      real(wp) :: nyquist  ! Hz

      nyquist = 0.5_wp/linear%time_step
      limit_text = 'beyond 1/(2 Δt) = '//short_text(nyquist)//' Hz, which steps cannot resolve'
      if (band%lowest >= nyquist) then
         text = 'the band of the record, '//short_text(band%lowest)//' … '// &
            short_text(band%highest)//' Hz, is '//limit_text
      else if (band%highest >= nyquist) then
         text = short_text(100*damping_at(linear, band%lowest))//' % at '// &
            short_text(band%lowest)//' Hz; the band of the record reaches '// &
            short_text(band%highest)//' Hz, '//limit_text
      else
         text = short_text(100*damping_at(linear, band%lowest))//' … '// &
            short_text(100*damping_at(linear, band%highest))//' % over '// &
            short_text(band%lowest)//' … '//short_text(band%highest)//' Hz'
      end if
   end function damping_range_text

   !> Numerical damping ratio in steady vibration at a frequency.
   pure real(wp) function damping_at(linear, frequency)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      real(wp), intent(in) :: frequency  !< Hz

      damping_at = forced_damping(linear%scheme, 2.0_wp*pi*frequency, linear%time_step)
   end function damping_at

   !> Report number of steps, memory and estimated time of the run.
   subroutine check_cost(simulation, off_diagonals, report)
      type(simulation_type), intent(in) :: simulation  !< a run and its state
      integer(long), intent(in) :: off_diagonals  !< number of off-diagonal blocks of K̂
      type(report_type), intent(inout) :: report  !< check report
      character(len=:), allocatable :: finding

      ! Memory of blocks with their matrices, of contacts, of K̂, and of the factor (about 3 × K̂).
      associate (n => simulation%blocks%n, contacts => simulation%contacts(simulation%now)%n)
         report%memory_bytes = 8.0_wp*(n*300.0_wp + 60.0_wp*contacts + 4*36.0_wp*(n + &
            off_diagonals))
      end associate
      finding = to_text(run_steps(simulation%model))//' steps, about '// &
         short_text(report%memory_bytes/2.0_wp**20)//' MiB of memory'
      report%run_seconds = seconds_per_step(simulation)*run_steps(simulation%model)
      if (report%run_seconds > 0.0_wp) finding = finding//', '//short_text(report%run_seconds)// &
         ' s at the speed of the first '//to_text(timed_steps)//' steps'
      call add_line(report, verdict_ok, 'cost', finding, 'measured', '')
   end subroutine check_cost

   !> Computing time of a step, s, measured in a few steps of a copy of the run.
   !> It is 0 for large models, and if the steps fail.
   real(wp) function seconds_per_step(simulation) result(seconds)
      type(simulation_type), intent(in) :: simulation  !< a run and its state
      type(simulation_type), allocatable :: copy
      type(error_type), allocatable :: error
      integer(long) :: start_count, end_count, rate
      integer :: i

      seconds = 0.0_wp
      if (simulation%blocks%n > timed_blocks) return
      copy = simulation
      call system_clock(start_count, rate)
      do i = 1, timed_steps
         call advance(copy, error)
         if (allocated(error)) return
      end do
      call system_clock(end_count)
      seconds = real(end_count - start_count, wp)/real(rate, wp)/timed_steps
   end function seconds_per_step

end module dda_check_simulation
