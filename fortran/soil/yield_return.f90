! SPDX-License-Identifier: GPL-3.0-or-later
!> Return of a trial stress to the strength of Mohr and Coulomb with a tension cut-off, in principal
!> stresses: σ₁ ≥ σ₂ in the plane, σ₃ out of the plane; tension positive.
!>
!> A stress is admissible if, for each pair i, j and each i,
!>
!>     ½(1 + sin φ) σ_i − ½(1 − sin φ) σ_j ≤ c cos φ ,   σ_i ≤ T .
!>
!> With a dilation angle ψ < φ, the part of friction beyond ψ acts on a frozen mean stress m_ij of
!> the pair, like the frozen normal force of a friction bound:
!>
!>     ½(1 + sin ψ) σ_i − ½(1 − sin ψ) σ_j ≤ c cos φ − (sin φ − sin ψ) m_ij .
!>
!> Each bound is a plane in principal stresses.  A trial stress beyond a plane is returned to the
!> nearest admissible stress in the norm of D⁻¹, on a plane, an edge or a corner: all multipliers
!> are ≥ 0 and all bounds are satisfied.  In plane stress σ₃ remains 0, and D has only the rows of
!> σ₁ and σ₂.
module dda_yield_return
   use dda_kinds, only: wp
   implicit none
   private
   public :: strength_type, return_type, return_principal

   integer, parameter :: bounds = 8, pairs = 5
   !> σ_i, σ_j of the pairs that a trial stress with σ₁ ≥ σ₂ can reach
   integer, parameter :: major(pairs) = [1, 1, 3, 2, 3], minor(pairs) = [2, 3, 2, 3, 1]
   real(wp), parameter :: rounding = 1.0e-13_wp   !< rounding error/trial stress
   real(wp), parameter :: singular = 1.0e-10_wp   !< ratio of pivot to diagonal: parallel planes

   !> Strength parameters of a point.
   type :: strength_type
      real(wp) :: cohesion = 0.0_wp  !< c, Pa
      real(wp) :: friction = 0.0_wp  !< φ, rad
      real(wp) :: dilation = 0.0_wp  !< ψ, rad, at most φ
      real(wp) :: tension = 0.0_wp   !< T, Pa, at most c cot φ
   end type strength_type

   !> Result of the return of a trial stress.
   type :: return_type
      logical :: yields = .false.
      real(wp) :: stress(3) = 0.0_wp    !< Pa
      real(wp) :: flow(3) = 0.0_wp      !< principal plastic strains
      real(wp) :: slope(3, 3) = 0.0_wp  !< ∂σ/∂ε, Pa
   end type return_type

contains

   !> Return a trial stress.
   pure type(return_type) function return_principal(strength, elastic, trial, frozen) result(to)
      type(strength_type), intent(in) :: strength  !< strength of the point
      real(wp), intent(in) :: elastic(3, 3)        !< D of principal strains, Pa
      real(wp), intent(in) :: trial(3)             !< σ₁ ≥ σ₂, σ₃, Pa
      real(wp), intent(in) :: frozen(3)            !< principal stresses with frozen means, Pa
      real(wp) :: gradient(3, bounds), bound(bounds), violation, min_violation
      type(return_type) :: candidate
      integer :: n
      integer, parameter :: indices(bounds) = [(n, n=1, bounds)]
      integer :: bound_set, active(bounds)

      to%stress = trial
      to%slope = elastic
      call set_strength_planes(strength, frozen, gradient, bound)
      if (all(matmul(trial, gradient) <= bound)) return
      min_violation = huge(1.0_wp)
      do n = 1, 3
         do bound_set = 1, 2**bounds - 1
            if (popcnt(bound_set) /= n) cycle
            active(:n) = pack(indices, btest(bound_set, indices - 1))
            if (any(bound(active(:n)) >= huge(1.0_wp))) cycle
            call return_to_planes(elastic, trial, gradient, bound, active(:n), candidate, violation)
            if (violation >= min_violation) cycle
            min_violation = violation
            to = candidate
            if (violation <= rounding*maxval(abs(trial))) return
         end do
      end do
   end function return_principal

   !> Planes of strength: gradients and bounds.
   pure subroutine set_strength_planes(strength, frozen, gradient, bound)
      type(strength_type), intent(in) :: strength  !< strength of the point
      real(wp), intent(in) :: frozen(3)            !< principal stresses with frozen means, Pa
      real(wp), intent(out) :: gradient(3, bounds)
      real(wp), intent(out) :: bound(bounds)       !< Pa
      real(wp) :: sine, frozen_sine
      integer :: i

      sine = sin(strength%dilation)
      frozen_sine = sin(strength%friction) - sine
      gradient = 0.0_wp
      do i = 1, pairs
         gradient(major(i), i) = 0.5_wp*(1.0_wp + sine)
         gradient(minor(i), i) = -0.5_wp*(1.0_wp - sine)
         bound(i) = strength%cohesion*cos(strength%friction)
         if (frozen_sine > 0.0_wp) bound(i) = max(0.0_wp, bound(i) - frozen_sine*0.5_wp &
            *(frozen(major(i)) + frozen(minor(i))))
      end do
      do i = 1, 3
         gradient(i, pairs + i) = 1.0_wp
         bound(pairs + i) = strength%tension
      end do
   end subroutine set_strength_planes

   !> Return a trial stress to the intersection of some planes.
   !> Also find the largest violation: of a bound, or of the condition that multipliers are ≥ 0, Pa.
   pure subroutine return_to_planes(elastic, trial, gradient, bound, list, to, violation)
      real(wp), intent(in) :: elastic(3, 3)      !< D of principal strains, Pa
      real(wp), intent(in) :: trial(3)           !< Pa
      real(wp), intent(in) :: gradient(3, bounds)
      real(wp), intent(in) :: bound(bounds)      !< Pa
      integer, intent(in) :: list(:)             !< planes
      type(return_type), intent(out) :: to       !< returned stress
      real(wp), intent(out) :: violation         !< violation; huge if the planes do not intersect
      real(wp) :: n(3, 3), stiff(3, 3), matrix(3, 3), rhs(3, 4)
      logical :: meets

      violation = huge(1.0_wp)
      associate (k => size(list))
         n(:, :k) = gradient(:, list)
         stiff(:, :k) = matmul(elastic, n(:, :k))
         matrix(:k, :k) = matmul(transpose(n(:, :k)), stiff(:, :k))
         rhs(:k, 1) = matmul(trial, n(:, :k)) - bound(list)
         rhs(:k, 2:4) = transpose(stiff(:, :k))
         call solve_small_system(matrix(:k, :k), rhs(:k, :), meets)
         if (.not. meets) return
         violation = -minval(rhs(:k, 1))*elastic(1, 1)
         to%yields = .true.
         to%flow = matmul(n(:, :k), rhs(:k, 1))
         to%stress = trial - matmul(stiff(:, :k), rhs(:k, 1))
         violation = max(violation, maxval(matmul(to%stress, gradient) - bound))
         to%slope = elastic - matmul(stiff(:, :k), rhs(:k, 2:4))
      end associate
   end subroutine return_to_planes

   !> Solve a small system of equations by elimination.
   pure subroutine solve_small_system(matrix, rhs, regular)
      real(wp), intent(inout) :: matrix(:,:)  !< [n,n] with positive diagonal; overwritten
      real(wp), intent(inout) :: rhs(:,:)   !< [n,any] becomes the solutions
      logical, intent(out) :: regular         !< the system has one solution
      real(wp) :: scale(size(matrix, 1)), factor
      integer :: i, k

      scale = [(abs(matrix(i, i)), i=1, size(matrix, 1))]
      regular = .false.
      do i = 1, size(matrix, 1)
         if (abs(matrix(i, i)) <= singular*scale(i)) return
         do k = 1, size(matrix, 1)
            if (k == i) cycle
            factor = matrix(k, i)/matrix(i, i)
            matrix(k, :) = matrix(k, :) - factor*matrix(i, :)
            rhs(k, :) = rhs(k, :) - factor*rhs(i, :)
         end do
      end do
      regular = .true.
      do i = 1, size(matrix, 1)
         rhs(i, :) = rhs(i, :)/matrix(i, i)
      end do
   end subroutine solve_small_system

end module dda_yield_return
