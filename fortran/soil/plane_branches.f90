! SPDX-License-Identifier: GPL-3.0-or-later
!> A branch of a soil in the plane: the vector of its strain e = (εx − εy, γxy) has the cap |e| ≤ y.
!>
!> The slipping part moves to p(e₀ + Δe), the nearest point within the cap; its stress in the step
!> weights both ends by 1 − θ and θ.  The stress p(e) of the recoverable part has a potential, and
!> its value in the step is
!>
!>     (2 − 2θ) ∫₀¹ p(e₀ + tΔe) dt + (2θ − 1) p(e₁) ,
!>
!> where the first term dissipates nothing.  Both are derivatives of convex functions of Δe.
module dda_plane_branches
   use dda_kinds, only: wp
   implicit none
   private
   public :: return_to_cap, compute_recoverable_stress, potential

   real(wp), parameter :: eye(2, 2) = reshape([1.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [2, 2])

contains

   !> Project e to p(e), and compute its derivative.
   pure subroutine return_to_cap(e, cap, p, slope)
      real(wp), intent(in) :: e(2), cap               !< strain; y
      real(wp), intent(out) :: p(2), slope(2, 2)      !< p(e), ∂p/∂e
      real(wp) :: r, direction(2)

      r = hypot(e(1), e(2))
      p = e
      slope = eye
      if (r <= cap) return
      direction = e/r
      p = cap*direction
      slope(:, 1) = cap/r*(eye(:, 1) - direction(1)*direction)
      slope(:, 2) = cap/r*(eye(:, 2) - direction(2)*direction)
   end subroutine return_to_cap

   !> Potential of p: ½|e|² within the cap, y|e| − ½y² beyond.
   pure real(wp) function potential(e, cap)
      real(wp), intent(in) :: e(2), cap  !< strain; y
      real(wp) :: r, capped

      r = hypot(e(1), e(2))
      capped = min(r, cap)
      potential = capped*(r - 0.5_wp*capped)
   end function potential

   !> Stress of a recoverable branch in a step, and its derivative with respect to Δe.
   pure subroutine compute_recoverable_stress(e, change, cap, theta, acting, slope)
      real(wp), intent(in) :: e(2), change(2), cap  !< e₀, Δe, y
      real(wp), intent(in) :: theta                 !< θ
      real(wp), intent(out) :: acting(2)            !< stress/modulus
      real(wp), intent(out) :: slope(2, 2)          !< ∂acting/∂Δe
      real(wp) :: p(2), of_end(2, 2)

      call return_to_cap(e + change, cap, p, of_end)
      if (max(sum(e**2), sum((e + change)**2)) <= cap**2) then
         acting = e + theta*change
         slope = theta*eye
         return
      end if
      call average_projection(e, change, cap, acting, slope)
      acting = (2.0_wp - 2.0_wp*theta)*acting + (2.0_wp*theta - 1.0_wp)*p
      slope = (2.0_wp - 2.0_wp*theta)*slope + (2.0_wp*theta - 1.0_wp)*of_end
   end subroutine compute_recoverable_stress

   !> Compute ∫₀¹ p(e₀ + tΔe) dt and ∫₀¹ t ∂p/∂e dt.
   !>
   !> Along the line e = q + (s₀ + t) t̂, q·t̂ = 0, the circle is crossed where s₀ + t is
   !> equal to ∓√(y² − q²).
   pure subroutine average_projection(e, change, cap, mean, slope)
      real(wp), intent(in) :: e(2), change(2), cap  !< e₀, Δe, y
      real(wp), intent(out) :: mean(2), slope(2, 2)
      real(wp), parameter :: rounding = 1.0e-13_wp  !< fraction of the cap: rounding
      real(wp) :: length, direction(2), foot(2), start, ends(2), half

      length = hypot(change(1), change(2))
      if (length <= rounding*cap) then
         call return_to_cap(e + 0.5_wp*change, cap, mean, slope)
         slope = 0.5_wp*slope
         return
      end if
      direction = change/length
      start = dot_product(e, direction)
      foot = e - start*direction
      half = sqrt(max(0.0_wp, cap**2 - sum(foot**2)))
      ends = max(0.0_wp, min(length, [-half, half] - start))
      mean = (ends(2) - ends(1))*(foot + (start + 0.5_wp*(ends(1) + ends(2)))*direction)
      slope = 0.5_wp*(ends(2) - ends(1))*(ends(1) + ends(2))*eye
      call add_beyond_cap(foot, direction, cap, start, 0.0_wp, ends(1), mean, slope)
      call add_beyond_cap(foot, direction, cap, start, ends(2), length, mean, slope)
      mean = mean/length
      slope = slope/length**2
   end subroutine average_projection

   !> Add the contribution of a segment beyond the cap to ∫ p dt and, by Gauss's rule, ∫ t ∂p/∂e dt.
   pure subroutine add_beyond_cap(foot, along, cap, start, from, to, mean, slope)
      real(wp), intent(in) :: foot(2), along(2), cap  !< q, t̂, y
      real(wp), intent(in) :: start, from, to         !< s₀; first and last t of the segment
      real(wp), intent(inout) :: mean(2), slope(2, 2)
      real(wp), parameter :: node = 0.577350269189625764_wp  !< Gauss point of the two-point rule
      real(wp) :: at, p(2), of_point(2, 2), ends(2), r(2)
      integer :: i

      if (to <= from) return
      ends = start + [from, to]
      r = sqrt(sum(foot**2) + ends**2)
      mean = mean + cap*(log_ratio(foot, to - from, ends, r)*foot &
         + (to - from)*sum(ends)/sum(r)*along)
      do i = -1, 1, 2
         at = 0.5_wp*(from + to) + 0.5_wp*i*node*(to - from)
         call return_to_cap(foot + (start + at)*along, cap, p, of_point)
         slope = slope + 0.5_wp*(to - from)*at*of_point
      end do
   end subroutine add_beyond_cap

   !> Compute ∫ ds/|e| = ln((s₁ + r₁)/(s₀ + r₀)), without differences of large numbers.
   pure real(wp) function log_ratio(foot, length, ends, r)
      real(wp), intent(in) :: foot(2), length, ends(2), r(2)  !< q; s₁ − s₀; s₀ and s₁; r₀ and r₁
      real(wp) :: ratio, distance

      ratio = sum(ends)/sum(r)  ! (r₁ − r₀)/(s₁ − s₀)
      if (ends(1) >= 0.0_wp) then
         log_ratio = log_1p(length*(1.0_wp + ratio)/(ends(1) + r(1)))
      else if (ends(2) <= 0.0_wp) then
         log_ratio = log_1p(length*(1.0_wp - ratio)/(r(2) - ends(2)))
      else
         distance = norm2(foot)  ! at least the cap, since the segment is beyond it
         log_ratio = asinh(ends(2)/distance) - asinh(ends(1)/distance)
      end if
   end function log_ratio

   !> Compute ln(1 + x) for x ≥ 0, exact for small x.
   pure real(wp) function log_1p(x)
      real(wp), intent(in) :: x  !< any
      real(wp) :: u

      u = 1.0_wp + x
      log_1p = x
      if (u > 1.0_wp) log_1p = log(u)*(x/(u - 1.0_wp))
   end function log_1p

end module dda_plane_branches
