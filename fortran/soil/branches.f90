! SPDX-License-Identifier: GPL-3.0-or-later
!> Shear of a soil by branches in parallel, fitted to its modulus reduction and damping curves.
!>
!> Branch j has the modulus g_j G and yields at γ_j.  A share F_j of it slips (elastic and
!> perfectly plastic), the rest is recoverable with the same cap.  Beside them stands the body of
!> the damping of small strains (`dda_damping`) in series with a slider: its springs hold g_b G in
!> the mean, and its stress has the cap y G that it reaches at the strain γ_b, so that it fades
!> where the soil yields.
!>
!> Under a load that only grows slipping and recoverable shares do the same, so g_j and γ_j make the
!> backbone,
!>
!>     G_s/G = Σ g_j min(1, γ_j/γ) + g_b min(1, γ_b/γ),   Σ g_j + g_b = 1,
!>
!> and F_j the loops.  A closed loop between ±γ loses, as damping ratio,
!>
!>     D(γ) = [Σ F_j 2 g_j γ_j (γ − γ_j)⁺ + π D_min min(γ, γ_b)² + 2 y (γ − γ_b)⁺] / (π γ² G_s/G) .
!>
!> Both fits are least squares: of relative errors of the modulus over g_j ≥ 0, of errors of the
!> damping ratio over 0 ≤ F_j ≤ 1.  F_j = 1 everywhere gives Masing's rules.
module dda_branches
   use dda_kinds, only: wp, pi
   use dda_damping, only: damping_type, fit_body
   use dda_errors, only: error_type, error_input, fail
   use dda_free_memory, only: require_for_blas
   use dda_interpolation, only: log_spaced, table_value
   use dda_nonnegative, only: nonnegative_least_squares
   implicit none
   private
   public :: branches_type, curve_type, fit_branches, set_body, relaxed_modulus, secant_ratio, &
      loop_damping

   integer, parameter :: samples = 8                !< strains of a fit for each branch
   real(wp), parameter :: sum_weight = 1.0e3_wp     !< of Σ g_j + g_b = 1 among relative errors
   real(wp), parameter :: bound_weight = 30.0_wp    !< of F_j ≤ 1 among errors of D
   real(wp), parameter :: first_reduction = 0.998_wp !< G_s/G at which branches begin
   real(wp), parameter :: body_reduction = 0.75_wp   !< G_s/G at which the body begins to slip
   real(wp), parameter :: least_strain = 1.0e-7_wp  !< of a branch
   real(wp), parameter :: misfit_range(2) = [1.0e-5_wp, 1.0e-2_wp] !< strains of the misfits

   !> Curves of a soil over the shear strain, straight in the logarithm of the strain.
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
      type(damping_type) :: body             !< of small strains, fitted
      real(wp) :: body_strain = huge(1.0_wp) !< γ_b
      real(wp) :: body_cap = huge(1.0_wp)    !< y
      real(wp) :: misfit(2) = 0.0_wp         !< largest relative error of G_s; error of D
   end type branches_type

contains

   !> Branches that fit the curves of a soil.
   subroutine fit_branches(curve, n, masing, damping, limit, branches, error)
      type(curve_type), intent(in) :: curve  !< two strains at least
      integer, intent(in) :: n               !< branches, 2 at least
      logical, intent(in) :: masing          !< damping of Masing's rules, in place of the curve's
      type(damping_type), intent(in) :: damping  !< of small strains, not fitted
      real(wp), intent(in) :: limit          !< largest ω_l that the time steps can take, rad/s
      type(branches_type), intent(out) :: branches  !< fitted
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays
      real(wp) :: strain(samples*n)

      if (n < 2 .or. n > 200) call fail(error, error_input, 'branches must be in 2 ... 200')
      if (.not. allocated(error)) call require_for_blas(error)
      if (allocated(error)) return
      branches%n = n
      branches%strain = log_spaced(first_strain(curve), last_strain(curve), n)
      call set_body(branches, damping, limit, strain_at(curve, body_reduction), error)
      if (allocated(error)) return
      strain = log_spaced(branches%strain(1)*0.1_wp, branches%strain(n), samples*n)
      call fit_moduli(branches, strain, at(curve, curve%reduction, strain))
      allocate (branches%slipping(n), source=1.0_wp)
      if (.not. masing) call fit_loops(branches, strain, at(curve, curve%damping, strain))
      call find_misfits(branches, curve, masing)
   end subroutine fit_branches

   !> The body of a damping ratio, which slips from a strain on.
   subroutine set_body(branches, damping, limit, strain, error)
      type(branches_type), intent(inout) :: branches  !< gets it
      type(damping_type), intent(in) :: damping  !< with its ratio D_min, 0: none; not fitted
      real(wp), intent(in) :: limit      !< largest ω_l that the time steps can take, rad/s
      real(wp), intent(in) :: strain     !< γ_b
      type(error_type), allocatable, intent(inout) :: error  !< the first one stays

      if (damping%ratio <= 0.0_wp) return
      branches%body = damping
      call fit_body(branches%body, limit, error)
      branches%body_strain = strain
      if (strain < 1.0_wp) branches%body_cap = strain &
         *hypot(1.0_wp - relaxed_modulus(branches%body), 2.0_wp*damping%ratio)
   end subroutine set_body

   !> What is left of the modulus of a body in the long run, over the given one: 1 − g_b.
   pure real(wp) function relaxed_modulus(body)
      type(damping_type), intent(in) :: body  !< fitted, or none

      relaxed_modulus = body%unrelaxed*(1.0_wp - sum(body%weight(:body%n)))
   end function relaxed_modulus

   !> G_s/G at strains.
   pure function secant_ratio(branches, strain) result(ratio)
      type(branches_type), intent(in) :: branches  !< fitted
      real(wp), intent(in) :: strain(:)            !< above 0
      real(wp) :: ratio(size(strain))
      integer :: i

      ratio = body_ratio(branches, strain)
      do i = 1, size(strain)
         ratio(i) = ratio(i) + sum(branches%modulus*min(1.0_wp, branches%strain/strain(i)))
      end do
   end function secant_ratio

   !> What the body adds to G_s/G.
   elemental real(wp) function body_ratio(branches, strain)
      type(branches_type), intent(in) :: branches  !< with their body
      real(wp), intent(in) :: strain               !< above 0

      body_ratio = (1.0_wp - relaxed_modulus(branches%body)) &
         *min(1.0_wp, branches%body_strain/strain)
   end function body_ratio

   !> Damping ratio of closed loops between ± the strains.
   pure function loop_damping(branches, strain) result(ratio)
      type(branches_type), intent(in) :: branches  !< fitted
      real(wp), intent(in) :: strain(:)            !< above 0
      real(wp) :: ratio(size(strain))

      ratio = matmul(loops(branches, strain), branches%slipping) + body_loops(branches, strain)
   end function loop_damping

   !> What the body adds to it.
   pure function body_loops(branches, strain) result(ratio)
      type(branches_type), intent(in) :: branches  !< with its moduli and body
      real(wp), intent(in) :: strain(:)            !< above 0
      real(wp) :: ratio(size(strain))

      associate (limit => branches%body_strain)
         ratio = branches%body%ratio*min(strain, limit)**2
         where (strain > limit) ratio = ratio + 2.0_wp/pi*branches%body_cap*(strain - limit)
      end associate
      ratio = ratio/(strain**2*secant_ratio(branches, strain))
   end function body_loops

   !> Damping ratio at strains that each branch would give if all of it slipped.
   pure function loops(branches, strain) result(ratio)
      type(branches_type), intent(in) :: branches  !< with its moduli
      real(wp), intent(in) :: strain(:)            !< above 0
      real(wp) :: ratio(size(strain), branches%n)
      integer :: j

      do j = 1, branches%n
         associate (limit => branches%strain(j))
            ratio(:, j) = 2.0_wp/pi*branches%modulus(j)*limit*max(0.0_wp, strain - limit) &
               /(strain**2*secant_ratio(branches, strain))
         end associate
      end do
   end function loops

   !> g_j of the secant moduli at strains.
   subroutine fit_moduli(branches, strain, reduction)
      type(branches_type), intent(inout) :: branches  !< with γ_j
      real(wp), intent(in) :: strain(:), reduction(:) !< [any] γ and G_s/G
      real(wp) :: matrix(size(strain) + 1, branches%n), right(size(strain) + 1)
      integer :: j, m

      m = size(strain)
      do j = 1, branches%n
         matrix(:m, j) = min(1.0_wp, branches%strain(j)/strain)/reduction
      end do
      right(:m) = 1.0_wp - body_ratio(branches, strain)/reduction
      matrix(m + 1, :) = sum_weight
      right(m + 1) = sum_weight*relaxed_modulus(branches%body)
      allocate (branches%modulus(branches%n))
      call nonnegative_least_squares(matrix, right, branches%modulus)
      branches%modulus = relaxed_modulus(branches%body)*branches%modulus/sum(branches%modulus)
   end subroutine fit_moduli

   !> F_j of the damping ratios at strains: F_j ≥ 0 with 1 − F_j ≥ 0, both as unknowns.
   subroutine fit_loops(branches, strain, damping)
      type(branches_type), intent(inout) :: branches  !< with γ_j and g_j
      real(wp), intent(in) :: strain(:), damping(:)   !< [any] γ and D
      real(wp) :: matrix(size(strain) + branches%n, 2*branches%n), unknown(2*branches%n)
      real(wp) :: right(size(strain) + branches%n)
      integer :: j, m

      m = size(strain)
      matrix = 0.0_wp
      matrix(:m, :branches%n) = loops(branches, strain)
      right(:m) = damping - body_loops(branches, strain)
      do j = 1, branches%n
         matrix(m + j, [j, branches%n + j]) = bound_weight
      end do
      right(m + 1:) = bound_weight
      call nonnegative_least_squares(matrix, right, unknown)
      branches%slipping = min(1.0_wp, unknown(:branches%n))
   end subroutine fit_loops

   !> Largest misfits over the strains that count and that the curve has; with Masing's rules of the
   !> modulus alone.
   subroutine find_misfits(branches, curve, masing)
      type(branches_type), intent(inout) :: branches  !< fitted
      type(curve_type), intent(in) :: curve           !< that it is to have
      logical, intent(in) :: masing                   !< the damping is not the curve's
      real(wp) :: strain(301), low, high

      low = max(misfit_range(1), curve%strain(1))
      high = min(misfit_range(2), last_strain(curve))
      if (low >= high) then
         low = curve%strain(1)
         high = last_strain(curve)
      end if
      strain = log_spaced(low, high, size(strain))
      branches%misfit(1) = maxval(abs(secant_ratio(branches, strain) &
         /at(curve, curve%reduction, strain) - 1.0_wp))
      if (.not. masing) branches%misfit(2) = maxval(abs(loop_damping(branches, strain) &
         - at(curve, curve%damping, strain)))
   end subroutine find_misfits

   !> The strain at which branches begin.
   pure real(wp) function first_strain(curve) result(first)
      type(curve_type), intent(in) :: curve  !< of the soil

      first = min(max(strain_at(curve, first_reduction), least_strain), 0.1_wp*last_strain(curve))
   end function first_strain

   !> The last strain of the table whose modulus is not below a share of that of small strains.
   pure real(wp) function strain_at(curve, reduction) result(strain)
      type(curve_type), intent(in) :: curve  !< of the soil
      real(wp), intent(in) :: reduction      !< G_s/G
      integer :: i

      strain = curve%strain(1)
      do i = 1, size(curve%strain)
         if (curve%reduction(i) < reduction) exit
         strain = curve%strain(i)
      end do
   end function strain_at

   !> The strain of the last branch: the end of the curve.
   pure real(wp) function last_strain(curve)
      type(curve_type), intent(in) :: curve  !< of the soil

      last_strain = curve%strain(size(curve%strain))
   end function last_strain

   !> A column of the curves at strains.
   pure function at(curve, values, strain)
      type(curve_type), intent(in) :: curve  !< of the soil
      real(wp), intent(in) :: values(:)      !< its column
      real(wp), intent(in) :: strain(:)      !< above 0
      real(wp) :: at(size(strain))
      integer :: i

      at = [(table_value(log(curve%strain), values, log(strain(i))), i=1, size(strain))]
   end function at

end module dda_branches
