! SPDX-License-Identifier: GPL-3.0-or-later
!> Branches of a soil: their fit, and energies and tangents of single steps.
module test_branch_law
   use dda_kinds, only: wp, pi
   use dda_branches, only: branches_type, curve_type, fit_branches, loop_damping, secant_ratio
   use dda_branch_law, only: response_type, respond, respond_body, advance_branches, advance_body, &
      stored_by_branches, stored_by_body
   use dda_damping, only: damping_type
   use dda_text, only: to_text
   use models, only: random_vector
   use testing, only: case, check, check_close, check_no_error, error
   implicit none

   integer, parameter :: rows = 101
   real(wp), parameter :: reference = 1.0e-3_wp  !< γ_r of the hyperbola

   !> A strain point, and its stored, lost and supplied energy.
   type :: point_type
      real(wp) :: elastic(200) = 0.0_wp
      real(wp) :: memory(16) = 0.0_wp
      real(wp) :: strain = 0.0_wp
      real(wp) :: body = 0.0_wp
      real(wp) :: stress = 0.0_wp   !< that acted in the last step
      real(wp) :: work = 0.0_wp
      real(wp) :: loss_sum = 0.0_wp
      real(wp) :: min_loss = 0.0_wp    !< loss of a step
   end type point_type

contains

   subroutine both_kinds_of_loops()
      call loops(.true., 0.0_wp)
      call loops(.false., 0.01_wp)
   end subroutine both_kinds_of_loops

   !> A hyperbola with a damping ratio of 1 % and, beyond it, half of that of Masing's rules.
   subroutine make(masing, min_damping, branches)
      logical, intent(in) :: masing
      real(wp), intent(in) :: min_damping
      type(branches_type), intent(out) :: branches
      type(curve_type) :: curve
      integer :: i

      curve%strain = [(10.0_wp**(-7.0_wp + 6.0_wp*(i - 1)/(rows - 1)), i=1, rows)]
      curve%reduction = 1.0_wp/(1.0_wp + curve%strain/reference)
      curve%damping = min_damping + 0.5_wp*masing_ratio(curve%strain/reference)
      call fit_branches(curve, 40, masing, damping_type(ratio=min_damping, reference=1.0_wp), &
         huge(1.0_wp), branches, error)
      call check_no_error(error, 'fitted')
   end subroutine make

   !> Of a hyperbola, over γ/γ_r.
   elemental real(wp) function masing_ratio(x) result(ratio)
      real(wp), intent(in) :: x

      ratio = 2.0_wp/pi*(2.0_wp*(1.0_wp + 1.0_wp/x)*(1.0_wp - log(1.0_wp + x)/x) - 1.0_wp)
      if (x < 1.0e-3_wp) ratio = 2.0_wp*x/(3.0_wp*pi)
   end function masing_ratio

   !> Loaded once, they follow G_s/G, with any damping curve; small strains have all of G.
   subroutine backbone_of_branches()
      type(branches_type) :: branches
      type(point_type) :: point
      real(wp) :: x
      integer :: i

      call make(.false., 0.0_wp, branches)
      call check_close(sum(branches%modulus), 1.0_wp, 'all of the modulus', absolute=1.0e-14_wp)
      call check(all(branches%modulus >= 0.0_wp), 'no negative modulus')
      call check(all(branches%slipping >= 0.0_wp .and. branches%slipping <= 1.0_wp), 'shares')
      do i = 1, 2000
         call step(branches, 1.0e-5_wp, 1.0_wp, point)
         x = (point%strain - 0.5e-5_wp)/reference
         call check(abs(point%stress/(reference*x/(1.0_wp + x)) - 1.0_wp) <= 0.005_wp, &
            'stress at x = '//to_text(x))
      end do
   end subroutine backbone_of_branches

   !> Closed loops at 1 Hz, driven by a sine, against the curves and the closed form of the fit.
   subroutine loops(masing, min_damping)
      logical, intent(in) :: masing
      real(wp), intent(in) :: min_damping
      integer, parameter :: steps = 2000
      real(wp), parameter :: amplitude(4) = [1.0e-5_wp, 1.0e-4_wp, 1.0e-3_wp, 1.0e-2_wp]
      type(branches_type) :: branches
      type(point_type) :: point
      real(wp) :: ratio, expected, start_work, next
      integer :: a, i

      call case('loops of branches, least ratio '//to_text(min_damping))
      call make(masing, min_damping, branches)
      do a = 1, size(amplitude)
         point = point_type()
         do i = 1, 12*steps
            next = amplitude(a)*sin(2.0_wp*pi*i/steps)
            if (i == 11*steps + 1) start_work = point%work
            call step(branches, next - point%strain, 1.0_wp/steps, point)
         end do
         ratio = (point%work - start_work)/(2.0_wp*pi*amplitude(a)**2 &
            *sum(secant_ratio(branches, amplitude(a:a))))
         expected = min_damping + merge(1.0_wp, 0.5_wp, masing)*masing_ratio(amplitude(a)/reference)
         call check_close(ratio, expected, 'damping ratio at '//to_text(amplitude(a)), &
            absolute=0.003_wp)
         call check_close(ratio, sum(loop_damping(branches, amplitude(a:a))), &
            'closed form at '//to_text(amplitude(a)), absolute=0.0015_wp)
      end do
   end subroutine loops

   !> Random paths: work equals stored plus lost energy, and no step gains energy.
   subroutine losses_of_branches()
      type(branches_type) :: branches
      type(point_type) :: point
      real(wp) :: change(1), stored
      integer :: i, path

      call make(.false., 0.02_wp, branches)
      do path = 1, 20
         point = point_type()
         do i = 1, 2000
            change = random_vector(1)
            call step(branches, change(1)**5*10.0_wp**(-mod(path, 4) - 1), 0.003_wp, point)
         end do
         stored = stored_by_branches(branches, point%elastic, point%strain) &
            + stored_by_body(branches, point%memory, point%body)
         call check(point%min_loss >= -1.0e-18_wp, 'no step gains')
         call check_close(stored + point%loss_sum, point%work, 'work', &
            absolute=1.0e-12_wp*point%loss_sum)
         call check(abs(point%stress) <= 1.0_wp*reference, 'stress is bounded')
      end do
   end subroutine losses_of_branches

   !> Tangents are derivatives of the acting stress.
   subroutine tangents_of_branches()
      type(branches_type) :: branches
      type(point_type) :: point
      type(response_type) :: lower, upper, soil, body
      real(wp) :: change(1), body_change, slope
      real(wp), parameter :: h = 1.0e-12_wp
      integer :: i, n_wrong

      call make(.false., 0.02_wp, branches)
      n_wrong = 0
      do i = 1, 500
         change = 2.0e-3_wp*random_vector(1)**3
         soil = respond(branches, point%elastic, point%strain, change(1))
         lower = respond(branches, point%elastic, point%strain, change(1) - h)
         upper = respond(branches, point%elastic, point%strain, change(1) + h)
         slope = (upper%acting - lower%acting)/(2.0_wp*h)
         if (abs(slope - soil%tangent) > 1.0e-3_wp) n_wrong = n_wrong + 1
         call respond_body(branches, point%memory, point%body, change(1), 0.01_wp, body, &
            body_change)
         call respond_body(branches, point%memory, point%body, change(1) + h, 0.01_wp, upper, &
            body_change)
         call respond_body(branches, point%memory, point%body, change(1) - h, 0.01_wp, lower, &
            body_change)
         slope = (upper%acting - lower%acting)/(2.0_wp*h)
         if (abs(slope - body%tangent) > 1.0e-3_wp) n_wrong = n_wrong + 1
         call step(branches, change(1), 0.01_wp, point)
      end do
      call check(n_wrong <= 2, 'tangents, but at kinks')
   end subroutine tangents_of_branches

   !> Take a step.
   subroutine step(branches, change, time_step, point)
      type(branches_type), intent(in) :: branches
      real(wp), intent(in) :: change, time_step
      type(point_type), intent(inout) :: point
      type(response_type) :: soil, body
      real(wp) :: body_change, loss

      soil = respond(branches, point%elastic, point%strain, change)
      call respond_body(branches, point%memory, point%body, change, time_step, body, body_change)
      call advance_body(branches, point%body, body_change, time_step, point%memory, loss)
      call advance_branches(branches, change, point%elastic(:branches%n))
      point%body = point%body + body_change
      point%strain = point%strain + change
      point%stress = soil%acting + body%acting
      point%work = point%work + point%stress*change
      point%loss_sum = point%loss_sum + soil%loss + body%loss + loss
      point%min_loss = min(point%min_loss, soil%loss, body%loss, loss)
   end subroutine step

end module test_branch_law
