! SPDX-License-Identifier: GPL-3.0-or-later
!> Checks of materials with a law: fit of the curves, resolution of waves in softened soil, and
!> cells that lose strength faster than they unload.
module dda_check_laws
   use dda_kinds, only: wp
   use dda_blocks, only: smaller_side
   use dda_check_report, only: report_type, add_line, verdict_ok, verdict_warn, advice_if
   use dda_material, only: elasticity
   use dda_model, only: model_type
   use dda_simulation, only: simulation_type
   use dda_text, only: short_text, quoted
   implicit none
   private
   public :: check_laws

   real(wp), parameter :: strains(2) = [1.0e-3_wp, 1.0e-2_wp]  !< shear strains of reported moduli
   real(wp), parameter :: coarsest = 1.0_wp/12                 !< largest block size over wavelength

contains

   !> Check each material with a law.
   subroutine check_laws(simulation, report)
      type(simulation_type), intent(in) :: simulation  !< model with materials and blocks
      type(report_type), intent(inout) :: report  !< check report
      character(len=:), allocatable :: words
      real(wp) :: side
      integer :: m

      associate (model => simulation%model)
         do m = 1, size(model%materials)
            if (.not. any(model%blocks%material == m)) cycle
            if (.not. model%materials(m)%has_law()) cycle
            side = largest_block_side(simulation, m)
            if (model%materials(m)%own_law%in_words() /= '') &
               call check_curve_fit(model, m, side, report)
            words = model%materials(m)%own_law%unmet()
            if (words /= '') call add_line(report, verdict_warn, 'material law', &
               quoted(trim(model%materials(m)%name))//': '//words, 'fit of the branches', &
               'more branches; if this does not suffice, less damping at small strains')
            call check_softening(model, m, side, report)
         end do
      end associate
   end subroutine check_laws

   !> Report the fit of the curves, and check wavelengths in softened soil.
   subroutine check_curve_fit(model, m, side, report)
      type(model_type), intent(in) :: model       !< model with materials and blocks
      integer, intent(in) :: m                    !< material
      real(wp), intent(in) :: side                !< largest block of the material, m
      type(report_type), intent(inout) :: report  !< check report
      character(len=:), allocatable :: found
      real(wp) :: left(2), eta
      logical :: fine

      associate (material => model%materials(m))
         left = [material%own_law%secant(strains(1)), material%own_law%secant(strains(2))]
         found = quoted(trim(material%name))//': '//material%own_law%in_words()//'; at '// &
            '0.1 and 1 % shear strain G/G0 = '//short_text(left(1))//' and '// &
            short_text(left(2))//', wavelengths are reduced to '//short_text(sqrt(left(1)))// &
            ' and '//short_text(sqrt(left(2)))//' of their values at small strain'
         fine = .true.
         if (report%band%known) then
            eta = side*report%band%highest/sqrt(left(1)*material%young_modulus/(2.0_wp &
               *(1.0_wp + material%poisson_ratio)*material%density))
            found = found//'; at 0.1 % strain, block size λ/'//short_text(1.0_wp/eta)//' at '// &
               short_text(report%band%highest)//' Hz, limit λ/12'
            fine = eta <= coarsest
         end if
         call add_line(report, merge(verdict_ok, verdict_warn, fine), 'material law', found, &
            'secant moduli', advice_if(.not. fine, 'blocks no larger than '// &
            short_text(side*coarsest/eta)//' m in soil that will yield'))
      end associate
   end subroutine check_curve_fit

   !> Largest of the smaller sides of the blocks of a material, m.
   pure real(wp) function largest_block_side(simulation, m) result(side)
      type(simulation_type), intent(in) :: simulation  !< model with materials and blocks
      integer, intent(in) :: m                         !< material
      integer :: b

      side = 0.0_wp
      do b = 1, simulation%blocks%n
         if (simulation%model%blocks%material(b) == m) &
            side = max(side, smaller_side(simulation%blocks, b))
      end do
   end function largest_block_side

   !> Warn if blocks lose strength faster than they unload, which causes dynamic jumps.
   subroutine check_softening(model, m, side, report)
      type(model_type), intent(in) :: model       !< model with materials and blocks
      integer, intent(in) :: m                    !< material
      real(wp), intent(in) :: side                !< largest block of the material, m
      type(report_type), intent(inout) :: report  !< check report
      real(wp) :: limit

      associate (material => model%materials(m))
         limit = material%own_law%largest_thickness(elasticity(material, &
            model%control%plane_strain))
         if (.not. limit < huge(1.0_wp)) return
         call add_line(report, merge(verdict_ok, verdict_warn, side <= limit), 'material law', &
            quoted(trim(material%name))//': cells of '//short_text(side)//' m soften; '// &
            'above '//short_text(limit)//' m cells would lose strength faster than they unload', &
            'G or E times softening_displacement over the loss of strength', &
            advice_if(side > limit, 'smaller cells, or a larger softening_displacement'))
      end associate
   end subroutine check_softening

end module dda_check_laws
