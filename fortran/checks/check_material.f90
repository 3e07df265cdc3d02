! SPDX-License-Identifier: GPL-3.0-or-later
!> Checks of materials: damping ratio and its frequency band; fit of the curves of a law, resolution
!> of waves in softened soil, and cells that lose strength faster than they unload.
module dda_check_material
   use dda_kinds, only: wp
   use dda_check_report, only: add_check, add_line, report_type, verdict_warn
   use dda_damping, only: damping_type, has_body, modulus_factor, rayleigh_ratio
   use dda_dense_eigen, only: solve_block_eigen
   use dda_errors, only: error_type
   use dda_linear_model, only: linear_model_type, is_dispersive, law_fractions
   use dda_linear_terms, only: add_product, get_row
   use dda_simulation, only: simulation_type
   use dda_text, only: short_text, quoted
   use dda_blocks, only: smaller_side
   use dda_material, only: elasticity
   use dda_model, only: model_type
   implicit none
   private
   public :: check_material, check_laws

   !> largest accepted number of steps of decay to 1/e
   real(wp), parameter :: max_ringing_steps = 1000.0_wp
   real(wp), parameter :: good_fit = 0.01_wp        !< largest relative error of ζ without advice

   real(wp), parameter :: strains(2) = [1.0e-3_wp, 1.0e-2_wp]  !< shear strains of reported moduli
   real(wp), parameter :: coarsest = 1.0_wp/12                 !< largest block size/wavelength

contains

   !> Add a line for materials with constant damping ratio, and one for Rayleigh damping.
   subroutine check_material(simulation, linear, report)
      type(simulation_type), intent(in) :: simulation  !< a run and its state
      type(linear_model_type), intent(in) :: linear  !< linearised model
      type(report_type), intent(inout) :: report  !< check report

      if (is_dispersive(linear)) call check_maxwell_bodies(simulation, linear, report)
      if (any(linear%damping%alpha > 0.0_wp .or. linear%damping%beta > 0.0_wp)) &
         call check_rayleigh(linear, report)
   end subroutine check_material

   !> Check damping by generalised Maxwell bodies: the fit, moduli at the first mode, the band of
   !> the record, and creep under sudden gravity.
   subroutine check_maxwell_bodies(simulation, linear, report)
      type(simulation_type), intent(in) :: simulation  !< a run and its state
      type(linear_model_type), intent(in) :: linear  !< linearised model
      type(report_type), intent(inout) :: report  !< check report
      type(damping_type), allocatable :: body(:)
      character(len=:), allocatable :: finding, advice
      real(wp) :: band(2), misfit

      body = pack(linear%damping, has_body(linear%damping))
      band = [maxval(body%band(1)), minval(body%band(2))]
      misfit = maxval(body%misfit)
      finding = 'damping ratio '//range_text(100*minval(body%ratio), 100*maxval(body%ratio))// &
         ' % over '//short_text(band(1))//' … '//short_text(band(2))//' Hz, largest relative '// &
         'error '//short_text(100*misfit)//' %, '// &
         range_text(real(minval(body%n), wp), real(maxval(body%n), wp))//' mechanisms'
      if (report%has_modes) then
         associate (factor => real(modulus_factor(body, report%modes%omega(1))))
            finding = finding//'; moduli '//range_text(minval(factor), maxval(factor))// &
               ' times the input values at the first mode, '// &
               short_text(maxval(body%unrelaxed))//' times at high frequencies'
         end associate
      end if
      advice = ''
      if (misfit > good_fit) advice = '; more mechanisms, or a narrower damping_band'
      if (report%band%has_energy) then
         if (report%band%lowest < band(1) .or. report%band%highest > band(2)) then
            finding = finding//'; the record contains '//short_text(report%band%lowest)//' … '// &
               short_text(report%band%highest)//' Hz, but damping is smaller outside the band'
            advice = advice//'; a damping_band that contains the record'
         end if
      end if
      if (norm2(simulation%model%control%gravity) > 0.0_wp .and. &
         .not. simulation%model%stages(1)%static) then
         finding = finding//'; gravity acts suddenly, so blocks creep under their weight'
         advice = advice//'; settle = .true.'
      end if
      call add_check(report, advice == '', 'material damping', &
         finding, 'generalised Maxwell bodies', advice(min(3, len(advice) + 1):))
   end subroutine check_maxwell_bodies

   !> Check Rayleigh damping: damping ratios, the speed limit of falling blocks due to α, and
   !> ringing of strains due to β.
   subroutine check_rayleigh(linear, report)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      type(report_type), intent(inout) :: report  !< check report
      character(len=:), allocatable :: finding, advice, brief
      real(wp) :: alpha, steps

      alpha = maxval(linear%damping%alpha)
      finding = 'largest α '//short_text(alpha)//' 1/s, largest β '// &
         short_text(maxval(linear%damping%beta))//' s'
      if (report%has_modes) finding = finding//'; '//damping_ratio_text(report%modes%frequency(1))
      if (report%band%has_energy) then
         if (report%band%lowest > 0.0_wp) finding = finding//'; '// &
            damping_ratio_text(report%band%lowest)
         finding = finding//'; '//damping_ratio_text(report%band%highest)
      end if
      advice = ''
      brief = ''
      if (alpha > 0.0_wp .and. (linear%n_unilateral > 0 .or. report%modes%rigid > 0 .or. &
         linear%n_closed == 0)) then
         finding = finding//'; free blocks fall at most at a speed of '// &
            short_text(9.81_wp/alpha)//' m/s due to α'
         advice = '; rayleigh_alpha = 0 for blocks without bonds'
         brief = 'α limits the speed of falling blocks to '//short_text(9.81_wp/alpha)//' m/s'
      end if
      steps = strain_ringing_steps(linear)
      if (steps > 0.0_wp) finding = finding//'; the rate of the stiffest strain of a block '// &
         'changes its sign in each step and decays to 1/e in '//short_text(steps)//' steps'
      if (steps > max_ringing_steps) then
         advice = advice//'; a smaller time_step or rayleigh_beta'
         brief = 'strains ring and decay to 1/e in '//short_text(steps)//' steps'
      end if
      call add_check(report, advice == '', 'Rayleigh damping', finding, 'ζ = α/(2ω) + βω/2', &
         advice(min(3, len(advice) + 1):), brief=brief)

   contains

      !> Text on the damping ratios at a frequency.
      function damping_ratio_text(frequency) result(text)
         real(wp), intent(in) :: frequency  !< Hz
         character(len=:), allocatable :: text

         associate (ratio => 100*rayleigh_ratio(pack(linear%damping, linear%damping%alpha &
            > 0.0_wp .or. linear%damping%beta > 0.0_wp), frequency))
            text = 'damping ratio '//range_text(minval(ratio), maxval(ratio))//' % at '// &
               short_text(frequency)//' Hz'
         end associate
      end function damping_ratio_text
   end subroutine check_rayleigh

   !> Number of steps in which the stiffest strain decays to 1/e if it rings; otherwise 0.
   !> A strain rings if its rate changes sign in each step due to dashpots.
   !>
   !> If only a dashpot c acts on a mass m, v₁/v₀ = [1 − (1 − χ) cΔt/m]/[1 + χ cΔt/m].
   real(wp) function strain_ringing_steps(linear) result(steps)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      real(wp) :: values(6), vectors(6, 6), rate, root
      real(wp), allocatable :: dashpot(:,:,:)  ! [6,6,n] βK
      type(error_type), allocatable :: error
      integer :: b

      rate = 0.0_wp
      call collect_dashpots(linear, dashpot)
      do b = 1, linear%n
         if (.not. any(abs(dashpot(:, :, b)) > 0.0_wp)) cycle
         call solve_block_eigen(dashpot(:, :, b), linear%mass(:, :, b), values, vectors, error)
         if (allocated(error)) cycle
         rate = max(rate, linear%damping(linear%law(b))%alpha + values(6))
      end do
      rate = rate*linear%time_step
      steps = 0.0_wp
      root = (1.0_wp - (1.0_wp - linear%scheme%chi)*rate)/(1.0_wp + linear%scheme%chi*rate)
      if (root < 0.0_wp) steps = -1.0_wp/log(-root)
   end function strain_ringing_steps

   !> Collect βK of each block, with all other blocks fixed.
   !> Both cells of a welded face receive the full springs of the face.
   subroutine collect_dashpots(linear, dashpot)
      type(linear_model_type), intent(in) :: linear  !< linearised model
      real(wp), allocatable, intent(out) :: dashpot(:,:,:)  !< [6,6,n] βK, N s/m
      real(wp) :: row(6)
      integer :: b, i, k

      allocate (dashpot(6, 6, linear%n), source=0.0_wp)
      do b = 1, linear%n
         if (linear%law(b) > 0) dashpot(4:6, 4:6, b) = linear%damping(linear%law(b))%beta &
            *linear%input_elastic(:, :, b)
      end do
      do i = 1, linear%terms%n
         associate (term => linear%terms%term(i), fraction => law_fractions(linear, &
            linear%terms%term(i)))
            if (.not. any(fraction > 0.0_wp)) cycle
            do k = 1, 2
               call get_row(term, k, b, row)
               if (linear%law(b) > 0) call add_product(dashpot(:, :, b), &
                  2.0_wp*sum(fraction*linear%damping%beta)*term%coefficient, row, row)
            end do
         end associate
      end do
   end subroutine collect_dashpots

   !> Text of a number, or of a range of two numbers.
   pure function range_text(lowest, highest) result(text)
      real(wp), intent(in) :: lowest, highest  !< ends of the range
      character(len=:), allocatable :: text

      text = short_text(lowest)
      if (short_text(highest) /= text) text = text//' … '//short_text(highest)
   end function range_text

   !> Check each material with a law.
   subroutine check_laws(simulation, report)
      type(simulation_type), intent(in) :: simulation  !< model with materials and blocks
      type(report_type), intent(inout) :: report  !< check report
      character(len=:), allocatable :: defect
      real(wp) :: block_size
      integer :: m

      associate (model => simulation%model)
         do m = 1, size(model%materials)
            if (.not. any(model%blocks%material == m)) cycle
            if (.not. model%materials(m)%has_law()) cycle
            block_size = largest_block_side(simulation, m)
            if (model%materials(m)%own_law%fit_text() /= '') &
               call check_curve_fit(model, m, block_size, report)
            defect = model%materials(m)%own_law%unmet()
            if (defect /= '') call add_line(report, verdict_warn, 'material law', &
               quoted(trim(model%materials(m)%name))//': '//defect, 'fit of the branches', &
               'more branches; if this does not suffice, less damping at small strains')
            call check_softening(model, m, block_size, report)
         end do
      end associate
   end subroutine check_laws

   !> Report the fit of the curves, and check wavelengths in softened soil.
   subroutine check_curve_fit(model, m, block_size, report)
      type(model_type), intent(in) :: model       !< model with materials and blocks
      integer, intent(in) :: m                    !< material
      real(wp), intent(in) :: block_size                !< largest block of the material, m
      type(report_type), intent(inout) :: report  !< check report
      character(len=:), allocatable :: finding, remedy
      real(wp) :: reduction(2), eta
      logical :: is_resolved

      associate (material => model%materials(m))
         reduction = [material%own_law%secant(strains(1)), material%own_law%secant(strains(2))]
         finding = quoted(trim(material%name))//': '//material%own_law%fit_text()//'; at '// &
            '0.1 and 1 % shear strain G/G0 = '//short_text(reduction(1))//' and '// &
            short_text(reduction(2))//', wavelengths are reduced to '// &
            short_text(sqrt(reduction(1)))//' and '//short_text(sqrt(reduction(2)))// &
            ' of their values at small strain'
         is_resolved = .true.
         if (report%band%has_energy) then
            eta = block_size*report%band%highest/sqrt(reduction(1)*material%young_modulus/(2.0_wp &
               *(1.0_wp + material%poisson_ratio)*material%density))
            finding = finding//'; at 0.1 % strain, block size λ/'//short_text(1.0_wp/eta)// &
               ' at '//short_text(report%band%highest)//' Hz, limit λ/12'
            is_resolved = eta <= coarsest
         end if
         remedy = ''
         if (.not. is_resolved) remedy = 'blocks no larger than '// &
            short_text(block_size*coarsest/eta)//' m in soil that will yield'
         call add_check(report, is_resolved, 'material law', finding, 'secant moduli', remedy)
      end associate
   end subroutine check_curve_fit

   !> Largest of the smaller sides of the blocks of a material, m.
   pure real(wp) function largest_block_side(simulation, m) result(side)
      type(simulation_type), intent(in) :: simulation  !< model with materials and blocks
      integer, intent(in) :: m                         !< material
      integer :: b

      side = maxval([(smaller_side(simulation%blocks, b), b=1, simulation%blocks%n)], &
         mask=simulation%model%blocks%material == m)
   end function largest_block_side

   !> Warn if blocks lose strength faster than they unload, which causes dynamic jumps.
   subroutine check_softening(model, m, block_size, report)
      type(model_type), intent(in) :: model       !< model with materials and blocks
      integer, intent(in) :: m                    !< material
      real(wp), intent(in) :: block_size                !< largest block of the material, m
      type(report_type), intent(inout) :: report  !< check report
      real(wp) :: limit

      associate (material => model%materials(m))
         limit = material%own_law%largest_thickness(elasticity(material, &
            model%control%plane_strain))
         if (.not. limit < huge(1.0_wp)) return
         call add_check(report, block_size <= limit, 'material law', &
            quoted(trim(material%name))//': cells of '//short_text(block_size)//' m soften; '// &
            'above '//short_text(limit)//' m cells would lose strength faster than they unload', &
            'G or E × softening_displacement / loss of strength', &
            'smaller cells, or a larger softening_displacement')
      end associate
   end subroutine check_softening

end module dda_check_material
