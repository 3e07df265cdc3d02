! SPDX-License-Identifier: GPL-3.0-or-later
!> Soil in shear as branches in parallel, fitted to its modulus reduction and damping curves.
!>
!> Branch j has the modulus g_j G and yields at γ_j.  A fraction F_j of it slips (elastic and
!> perfectly plastic), the rest is recoverable with the same cap.  Parallel to them is the Maxwell
!> body of the small-strain damping (`dda_damping`) in series with a slider: its springs have g_b G
!> in the mean, and its stress has the cap y G, reached at the strain γ_b, so that its effect fades
!> when the soil yields.
!>
!> Under monotonic load, slipping and recoverable fractions act equally, so g_j and γ_j define
!> the backbone,
!>
!>     G_s/G = Σ g_j min(1, γ_j/γ) + g_b min(1, γ_b/γ),   Σ g_j + g_b = 1,
!>
!> and F_j defines the loops.  A closed loop between ±γ has the damping ratio
!>
!>     D(γ) = [Σ F_j 2 g_j γ_j (γ − γ_j)⁺ + π D_min min(γ, γ_b)² + 2 y (γ − γ_b)⁺] / (π γ² G_s/G) .
!>
!> Least squares fit relative errors of the modulus and errors of the damping ratio.  The unknowns
!> are slipping parts, F_j g_j ≥ 0, and recoverable parts, (1 − F_j) g_j ≥ 0; the fit is
!> repeated with new weights until the largest error of the damping ratio is small [Lawson, 1961].
!> Masing's rules are the case F_j = 1 for all branches.
module dda_branches
   use dda_kinds, only: wp, pi
   use dda_damping, only: damping_type, fit_body
   use dda_errors, only: error_type, error_input, fail
   use dda_free_memory, only: require_for_blas
   use dda_interpolation, only: log_spaced, table_value
   use dda_nonnegative, only: solve_nonnegative
   implicit none
   private
   public :: branches_type, curve_type, fit_branches, set_body, relaxed_modulus, secant_ratio, &
      loop_damping

   integer, parameter :: samples = 8                !< strains of a fit for each branch
   real(wp), parameter :: sum_weight = 1.0e3_wp     !< weight of Σ g_j + g_b = 1 relative to errors
   real(wp), parameter :: loop_weight = 3.0_wp  !< weight of errors of D relative to those of G_s
   real(wp), parameter :: small_misfit = 2.0e-3_wp  !< misfit of D below which weights are constant
   integer, parameter :: max_fits = 8              !< largest number of fits with new weights
   real(wp), parameter :: min_weight = 0.05_wp  !< smallest factor of a weight, used at zero error
   real(wp), parameter :: first_reduction = 0.998_wp !< G_s/G at which the first branch yields
   real(wp), parameter :: body_reduction = 0.8_wp    !< G_s/G at which the body begins to slip
   real(wp), parameter :: min_strain = 1.0e-7_wp  !< smallest γ_j
   real(wp), parameter :: misfit_range(2) = [1.0e-5_wp, 1.0e-2_wp] !< strains of the misfits

   !> Curves of a soil over the shear strain, linear in the logarithm of the strain.
   type :: curve_type
      real(wp), allocatable :: strain(:)     !< [any] ascending, –
      real(wp), allocatable :: reduction(:)  !< [any] G_s/G
      real(wp), allocatable :: damping(:)    !< [any] damping ratio, –
   end type curve_type

   !> Branches of a soil.
   type :: branches_type
      integer :: n = 0
      real(wp), allocatable :: strain(:)     !< [n] γ_j, ascending
      real(wp), allocatable :: modulus(:)    !< [n] g_j
      real(wp), allocatable :: slipping(:)   !< [n] F_j
      type(damping_type) :: body             !< small-strain body, fitted
      real(wp) :: body_strain = huge(1.0_wp) !< γ_b
      real(wp) :: body_cap = huge(1.0_wp)    !< y
      real(wp) :: misfit(2) = 0.0_wp         !< largest relative error of G_s; error of D
   end type branches_type

contains

   !> Fit branches to the curves of a soil.
   subroutine fit_branches(curve, n, masing, damping, limit, branches, error)
      type(curve_type), intent(in) :: curve  !< curve of the soil, with at least two strains
      integer, intent(in) :: n               !< number of branches, at least 2
      logical, intent(in) :: masing  !< damping by Masing's rules instead of the curve
      type(damping_type), intent(in) :: damping  !< small-strain damping, not fitted
      real(wp), intent(in) :: limit          !< largest ω_l that the time steps admit, rad/s
      type(branches_type), intent(out) :: branches  !< fitted branches
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      if (n < 2 .or. n > 200) call fail(error, error_input, 'branches must be from 2 to 200')
      if (.not. allocated(error)) call require_for_blas(error)
      if (allocated(error)) return
      branches%n = n
      branches%strain = log_spaced(min(max(strain_at(curve, first_reduction), min_strain), &
         0.1_wp*last_strain(curve)), last_strain(curve), n)
      call set_body(branches, damping, limit, first_strain_at(curve, body_reduction), error)
      if (allocated(error)) return
      allocate (branches%modulus(n), branches%slipping(n))
      if (masing) then
         call fit_moduli(branches, curve)
      else
         call fit_both(branches, curve)
      end if
      call find_misfits(branches, curve, masing)
   end subroutine fit_branches

   !> Set the Maxwell body with a given damping ratio; it slips beyond a given strain.
   subroutine set_body(branches, damping, limit, strain, error)
      type(branches_type), intent(inout) :: branches  !< receives the body
      type(damping_type), intent(in) :: damping  !< damping with ratio D_min, not fitted; 0: none
      real(wp), intent(in) :: limit      !< largest ω_l that the time steps admit, rad/s
      real(wp), intent(in) :: strain     !< γ_b
      type(error_type), allocatable, intent(inout) :: error  !< error; an earlier one is retained

      if (damping%ratio <= 0.0_wp) return
      branches%body = damping
      call fit_body(branches%body, limit, error)
      branches%body_strain = strain
      if (strain < 1.0_wp) branches%body_cap = strain &
         *hypot(1.0_wp - relaxed_modulus(branches%body), 2.0_wp*damping%ratio)
   end subroutine set_body

   !> Long-term modulus of a body relative to G: 1 − g_b.
   pure real(wp) function relaxed_modulus(body)
      type(damping_type), intent(in) :: body  !< fitted body, or no body

      relaxed_modulus = body%unrelaxed*(1.0_wp - sum(body%weight(:body%n)))
   end function relaxed_modulus

   !> Secant modulus ratio G_s/G at strains.
   pure function secant_ratio(branches, strain) result(ratio)
      type(branches_type), intent(in) :: branches  !< fitted branches
      real(wp), intent(in) :: strain(:)            !< above 0
      real(wp) :: ratio(size(strain))
      integer :: i

      ratio = body_ratio(branches, strain)
      do i = 1, size(strain)
         ratio(i) = ratio(i) + sum(branches%modulus*min(1.0_wp, branches%strain/strain(i)))
      end do
   end function secant_ratio

   !> Contribution of the body to G_s/G.
   elemental real(wp) function body_ratio(branches, strain)
      type(branches_type), intent(in) :: branches  !< branches and body
      real(wp), intent(in) :: strain               !< above 0

      body_ratio = (1.0_wp - relaxed_modulus(branches%body)) &
         *(branches%body_strain/max(strain, branches%body_strain))  ! ordered to prevent overflow
   end function body_ratio

   !> Damping ratio of closed loops between ± the strains.
   pure function loop_damping(branches, strain) result(ratio)
      type(branches_type), intent(in) :: branches  !< fitted branches
      real(wp), intent(in) :: strain(:)            !< above 0
      real(wp) :: ratio(size(strain)), reduction(size(strain))

      reduction = secant_ratio(branches, strain)
      ratio = matmul(branch_damping(branches, strain, reduction), &
         branches%modulus*branches%slipping) + body_loops(branches, strain, reduction)
   end function loop_damping

   !> Contribution of the body to the damping ratio.
   elemental real(wp) function body_loops(branches, strain, reduction) result(ratio)
      type(branches_type), intent(in) :: branches  !< branches and body
      real(wp), intent(in) :: strain               !< above 0
      real(wp), intent(in) :: reduction            !< G_s/G

      associate (limit => branches%body_strain)
         ratio = branches%body%ratio*min(strain, limit)**2
         if (strain > limit) ratio = ratio + 2.0_wp/pi*branches%body_cap*(strain - limit)
      end associate
      ratio = ratio/(strain**2*reduction)
   end function body_loops

   !> Damping ratio at given strains that each branch would add if it had the modulus G and slipped.
   pure function branch_damping(branches, strain, reduction) result(ratio)
      type(branches_type), intent(in) :: branches  !< branches; γ_j are set
      real(wp), intent(in) :: strain(:)            !< above 0
      real(wp), intent(in) :: reduction(:)         !< G_s/G of the soil at these strains
      real(wp) :: ratio(size(strain), branches%n)
      integer :: j

      do j = 1, branches%n
         associate (limit => branches%strain(j))
            ratio(:, j) = 2.0_wp/pi*limit*max(0.0_wp, strain - limit)/(strain**2*reduction)
         end associate
      end do
   end function branch_damping

   !> Fit g_j to the secant moduli only, with F_j = 1: no fraction is recoverable.
   subroutine fit_moduli(branches, curve)
      type(branches_type), intent(inout) :: branches  !< branches with γ_j and the body
      type(curve_type), intent(in) :: curve           !< curve of the soil
      real(wp) :: matrix(samples*branches%n + 1, branches%n), rhs(samples*branches%n + 1)

      call set_modulus_equations(branches, curve, matrix, rhs)
      call solve_nonnegative(matrix, rhs, branches%modulus)
      branches%modulus = relaxed_modulus(branches%body)*branches%modulus/sum(branches%modulus)
      branches%slipping = 1.0_wp
   end subroutine fit_moduli

   !> Set up the equations for g_j: secant moduli, and the sum of g_j.
   subroutine set_modulus_equations(branches, curve, matrix, rhs)
      type(branches_type), intent(in) :: branches  !< branches with γ_j and the body
      type(curve_type), intent(in) :: curve        !< curve of the soil
      real(wp), intent(out) :: matrix(:,:)         !< [samples n + 1, n]
      real(wp), intent(out) :: rhs(:)            !< [samples n + 1]
      real(wp) :: strain(samples*branches%n), reduction(samples*branches%n)
      integer :: j, m

      m = size(strain)
      strain = strains_of_fit(branches)
      reduction = curve_value(curve, curve%reduction, strain)
      do j = 1, branches%n
         matrix(:m, j) = min(1.0_wp, branches%strain(j)/strain)/reduction
      end do
      rhs(:m) = 1.0_wp - body_ratio(branches, strain)/reduction
      matrix(m + 1, :) = sum_weight
      rhs(m + 1) = sum_weight*relaxed_modulus(branches%body)
   end subroutine set_modulus_equations

   !> Fit g_j and F_j to secant moduli and damping ratios.
   !> The last branch has only one unknown, because no strain of the curve exceeds its limit.
   subroutine fit_both(branches, curve)
      type(branches_type), intent(inout) :: branches  !< branches with γ_j and the body
      type(curve_type), intent(in) :: curve           !< curve of the soil
      real(wp), allocatable :: matrix(:,:), rhs(:), weight(:), strain(:), damping(:), misfit(:)
      real(wp) :: unknown(2*branches%n - 1), best_fit(branches%n, 2), smallest_misfit
      integer :: fit, m, n

      n = branches%n
      m = samples*n
      allocate (matrix(2*m + 1, 2*n - 1), rhs(2*m + 1))
      call set_modulus_equations(branches, curve, matrix(m + 1:, :n), rhs(m + 1:))
      matrix(m + 1:, n + 1:) = matrix(m + 1:, :n - 1)
      matrix(:m, n + 1:) = 0.0_wp
      strain = strains_of_fit(branches)
      damping = curve_value(curve, curve%damping, strain)
      allocate (weight(m), source=loop_weight)
      misfit = curve_value(curve, curve%reduction, strain)
      smallest_misfit = huge(1.0_wp)
      do fit = 1, max_fits
         matrix(:m, :n) = spread(weight, 2, n)*branch_damping(branches, strain, misfit)
         rhs(:m) = weight*(damping - body_loops(branches, strain, misfit))
         call solve_nonnegative(matrix, rhs, unknown)
         call set_branch_moduli(branches, unknown)
         misfit = abs(loop_damping(branches, strain) - damping)
         associate (largest => maxval(misfit, mask=is_counted(strain)))
            if (largest < smallest_misfit) best_fit = reshape([branches%modulus, &
               branches%slipping], [n, 2])
            smallest_misfit = min(smallest_misfit, largest)
            if (largest <= small_misfit .and. fit > 1) exit
            weight = weight*sqrt(min_weight + misfit/largest)
         end associate
         misfit = secant_ratio(branches, strain)
      end do
      branches%modulus = best_fit(:, 1)
      branches%slipping = best_fit(:, 2)
   end subroutine fit_both

   !> Set g_j and F_j from the slipping and the recoverable parts.
   pure subroutine set_branch_moduli(branches, unknown)
      type(branches_type), intent(inout) :: branches  !< receives g_j and F_j
      real(wp), intent(in) :: unknown(:)              !< [2n − 1] F_j g_j, then (1 − F_j) g_j
      integer :: n

      n = branches%n
      branches%modulus = unknown(:n)
      branches%modulus(:n - 1) = unknown(:n - 1) + unknown(n + 1:)
      branches%slipping = 1.0_wp
      where (branches%modulus > 0.0_wp) branches%slipping = unknown(:n)/branches%modulus
      branches%modulus = relaxed_modulus(branches%body)*branches%modulus/sum(branches%modulus)
   end subroutine set_branch_moduli

   !> Strains used in a fit.
   pure function strains_of_fit(branches) result(strain)
      type(branches_type), intent(in) :: branches  !< branches; γ_j are set
      real(wp) :: strain(samples*branches%n)

      strain = log_spaced(branches%strain(1)*0.1_wp, branches%strain(branches%n), size(strain))
   end function strains_of_fit

   !> .true. if the misfits at a strain are counted.
   elemental logical function is_counted(strain)
      real(wp), intent(in) :: strain  !< –

      is_counted = strain >= misfit_range(1) .and. strain <= misfit_range(2)
   end function is_counted

   !> Find the largest misfits over the counted strains of the curve.
   !> With Masing's rules, only misfits of the modulus are found.
   subroutine find_misfits(branches, curve, masing)
      type(branches_type), intent(inout) :: branches  !< fitted branches
      type(curve_type), intent(in) :: curve           !< curve to which the branches are fitted
      logical, intent(in) :: masing  !< damping by Masing's rules instead of the curve
      real(wp) :: strain(301), lowest, highest

      lowest = max(misfit_range(1), curve%strain(1))
      highest = min(misfit_range(2), last_strain(curve))
      if (lowest >= highest) then
         lowest = curve%strain(1)
         highest = last_strain(curve)
      end if
      strain = log_spaced(lowest, highest, size(strain))
      branches%misfit(1) = maxval(abs(secant_ratio(branches, strain) &
         /curve_value(curve, curve%reduction, strain) - 1.0_wp))
      if (.not. masing) branches%misfit(2) = maxval(abs(loop_damping(branches, strain) &
         - curve_value(curve, curve%damping, strain)))
   end subroutine find_misfits

   !> Largest strain of the table at which G_s/G is at least `reduction`.
   pure real(wp) function strain_at(curve, reduction) result(strain)
      type(curve_type), intent(in) :: curve  !< curve of the soil
      real(wp), intent(in) :: reduction      !< G_s/G
      integer :: i

      strain = curve%strain(1)
      do i = 1, size(curve%strain)
         if (curve%reduction(i) < reduction) exit
         strain = curve%strain(i)
      end do
   end function strain_at

   !> Strain at which the modulus first falls to a fraction of the small-strain modulus.
   !> If the modulus never falls so far, the result is the last strain of the curve.
   pure real(wp) function first_strain_at(curve, reduction) result(strain)
      type(curve_type), intent(in) :: curve  !< curve of the soil
      real(wp), intent(in) :: reduction      !< G_s/G
      integer :: i

      do i = 2, size(curve%strain)
         if (curve%reduction(i) < reduction) exit
      end do
      if (i > size(curve%strain)) then
         strain = last_strain(curve)
      else
         associate (before => curve%reduction(i - 1), after => curve%reduction(i))
            strain = curve%strain(i - 1)*(curve%strain(i)/curve%strain(i - 1)) &
               **max(0.0_wp, min(1.0_wp, (before - reduction)/(before - after)))
         end associate
      end if
   end function first_strain_at

   !> Strain of the last branch: the end of the curve.
   pure real(wp) function last_strain(curve)
      type(curve_type), intent(in) :: curve  !< curve of the soil

      last_strain = curve%strain(size(curve%strain))
   end function last_strain

   !> Values of a column of the curves at strains.
   pure function curve_value(curve, values, strain)
      type(curve_type), intent(in) :: curve  !< curve of the soil
      real(wp), intent(in) :: values(:)      !< column of the curves
      real(wp), intent(in) :: strain(:)      !< above 0
      real(wp) :: curve_value(size(strain))
      integer :: i

      curve_value = [(table_value(log(curve%strain), values, log(strain(i))), i=1, size(strain))]
   end function curve_value

end module dda_branches
