! SPDX-License-Identifier: GPL-3.0-or-later
!> Line search of the open–close iteration for the minimum of the energy of the step.
!>
!> With constant friction bounds the solution of the step minimises a convex function: inertia,
!> elasticity and loads are quadratic, and each contact adds ½ k min(gap, 0)² and the potential of
!> its friction, quadratic up to the bound and linear beyond.  The slope of this function increases
!> monotonically from the previous d to the new d; it vanishes at the step length α.
!>
!> If a contact is in the same branch of its law at both ends of the path, it is in this branch on
!> the whole path.  Its slope is linear and summed once.  Other contacts are evaluated at each trial
!> length.
module dda_line_search
   use dda_block_vectors, only: multiply_and_add
   use dda_growth, only: grow
   use dda_kinds, only: wp
   use dda_system, only: system_type, multiply_diagonal
   use dda_contact, only: capacity_of, contacts_type
   use dda_contact_gradients, only: relative_motion
   use dda_friction, only: find_response, laws_type, same_branch
   use dda_joint_law, only: response_type
   use dda_ordered_sums, only: pieces, first_of, last_of, most_pieces, parallel_from
   implicit none
   private
   public :: descend, other_slope_type

   !> Slope of the energy of forces that belong neither to the linear system nor to contacts.
   type, abstract :: other_slope_type
   contains
      procedure(slope_interface), deferred :: at
   end type other_slope_type

   abstract interface
      !> Return the slope of the energy at a fraction of the step, J/m.
      real(wp) function slope_interface(self, fraction)
         import :: other_slope_type, wp
         class(other_slope_type), intent(in) :: self  !< forces in a step
         real(wp), intent(in) :: fraction             !< fraction of the step, 0 … 1
      end function slope_interface
   end interface

   !> largest number of trial lengths, enough for bisection down to rounding errors
   integer, parameter :: most_steps = digits(1.0_wp)
   !> slope/first slope, or slope/increase of the slope, below which a slope counts as zero
   real(wp), parameter :: zero_slope = 1.0e-2_wp

contains

   !> Shorten system%d towards system%previous_d if the minimum lies between them.
   !> `alpha` is the remaining fraction of the step.
   !>
   !> On entry the contacts are evaluated at the new d; other forces have slope 0 at the previous d.
   !> The zero of the slope is found by regula falsi with the Illinois rule: the slope of an end
   !> that does not move is halved, which makes convergence superlinear.
   subroutine descend(system, contacts, laws, alpha, other)
      type(system_type), intent(inout) :: system  !< equations of the step
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      real(wp), intent(out) :: alpha  !< fraction of the step
      class(other_slope_type), intent(in), optional :: other  !< other nonlinear forces
      real(wp) :: start, growth, slope_lo, slope_hi, alpha_lo, alpha_hi, slope, first, linear(2)
      integer :: i

      alpha = 1.0_wp
      call find_quadratic_slopes(system, start, growth)
      call measure_changes(system, contacts, slope_hi)
      slope_hi = start + growth + slope_hi
      if (present(other)) slope_hi = slope_hi + other%at(1.0_wp)
      if (slope_hi <= abs(growth)*zero_slope) return
      call sum_linear(contacts, laws, linear)
      start = start + linear(1)
      growth = growth + linear(2)
      slope_lo = start + contact_slope(contacts, laws, 0.0_wp)
      first = slope_lo
      alpha_lo = 0.0_wp
      alpha_hi = 1.0_wp
      do i = 1, most_steps
         ! bisect if rounding makes slopes equal or reverses their order
         alpha = alpha_lo
         if (slope_hi > slope_lo) &
            alpha = alpha_lo - slope_lo*(alpha_hi - alpha_lo)/(slope_hi - slope_lo)
         if (.not. (alpha > alpha_lo .and. alpha < alpha_hi)) alpha = 0.5_wp*(alpha_lo + alpha_hi)
         slope = start + alpha*growth + contact_slope(contacts, laws, alpha)
         if (present(other)) slope = slope + other%at(alpha)
         if (abs(slope) <= zero_slope*abs(first)) exit
         if (slope > 0.0_wp) then
            alpha_hi = alpha
            slope_hi = slope
            slope_lo = 0.5_wp*slope_lo
         else
            alpha_lo = alpha
            slope_lo = slope
            slope_hi = 0.5_wp*slope_hi
         end if
      end do
      associate (n => size(system%d, 2))
         ! first d₀ − d, then d₀ + α (d − d₀)
         call multiply_and_add(n, system%previous_d, -1.0_wp, system%d)
         call multiply_and_add(n, system%previous_d, -alpha, system%d)
      end associate
   end subroutine descend

   !> Find the slope of the quadratic energy at the previous d, and its change up to the new d.
   subroutine find_quadratic_slopes(system, start, growth)
      type(system_type), intent(in) :: system  !< equations of the step
      !> slope at the previous d; increase of the slope up to the new d
      real(wp), intent(out) :: start, growth
      real(wp) :: part(2, most_pieces), total(2)
      integer :: p, n

      n = size(system%d, 2)
      if (n < parallel_from) then
         total = sum_quadratic_range(system, 1, n)
      else
         !$omp parallel do schedule(static)
         do p = 1, pieces(n)
            part(:, p) = sum_quadratic_range(system, first_of(p, n), last_of(p, n))
         end do
         total = sum(part(:, :pieces(n)), 2)
      end if
      if (size(system%linear%lower, 3) > 0) total = total + sum_coupled_slopes(system)
      start = total(1)
      growth = total(2)
   end subroutine find_quadratic_slopes

   !> Sum the slope and its increase over blocks first … last, for the diagonal of the linear part.
   pure function sum_quadratic_range(system, first, last) result(slope)
      type(system_type), intent(in) :: system  !< equations of the step
      integer, intent(in) :: first, last  !< first and last in the range
      real(wp) :: slope(2), change(6), force(6)
      integer :: b

      slope = 0.0_wp
      do b = first, last
         change = system%d(:, b) - system%previous_d(:, b)
         call multiply_diagonal(system, b, system%previous_d(:, b), force)
         slope(1) = slope(1) + dot_product(change, force - system%load(:, b))
         call multiply_diagonal(system, b, change, force)
         slope(2) = slope(2) + dot_product(change, force)
      end do
   end function sum_quadratic_range

   !> Sum the slope and its increase over pairs of blocks coupled by elements.
   pure function sum_coupled_slopes(system) result(slope)
      type(system_type), intent(in) :: system  !< equations of the step
      real(wp) :: slope(2), change_i(6), change_j(6)
      integer :: i, k

      slope = 0.0_wp
      do i = 1, system%linear%n
         do k = system%linear%row_start(i), system%linear%row_start(i + 1) - 1
            associate (j => system%linear%column(k), block => system%linear%lower(:, :, k))
               change_i = system%d(:, i) - system%previous_d(:, i)
               change_j = system%d(:, j) - system%previous_d(:, j)
               slope(1) = slope(1) + dot_product(change_i, matmul(block, system%previous_d(:, j))) &
                  + dot_product(system%previous_d(:, i), matmul(block, change_j))
               slope(2) = slope(2) + 2.0_wp*dot_product(change_i, matmul(block, change_j))
            end associate
         end do
      end do
   end function sum_coupled_slopes

   !> Measure the changes of gap and slip of each contact from the previous d to the new d.
   !> Also sum the slope of all contacts at the new d.
   subroutine measure_changes(system, contacts, slope)
      type(system_type), intent(in) :: system  !< equations of the step
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step, evaluated
      real(wp), intent(out) :: slope  !< slope, J/m
      real(wp) :: part(most_pieces)
      integer :: p

      call grow(contacts%gap_change, capacity_of(contacts), exactly=.true.)
      call grow(contacts%slip_change, capacity_of(contacts), exactly=.true.)
      if (contacts%n < parallel_from) then
         call measure_changes_range(system, contacts, 1, contacts%n, slope)
         return
      end if
      !$omp parallel do schedule(static)
      do p = 1, pieces(contacts%n)
         call measure_changes_range(system, contacts, first_of(p, contacts%n), last_of(p, &
            contacts%n), part(p))
      end do
      slope = sum(part(:pieces(contacts%n)))
   end subroutine measure_changes

   !> Measure the changes of gap and slip of contacts first … last.
   pure subroutine measure_changes_range(system, contacts, first, last, slope)
      type(system_type), intent(in) :: system  !< equations of the step
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step, evaluated
      integer, intent(in) :: first, last  !< first and last in the range
      real(wp), intent(out) :: slope  !< slope, J/m
      real(wp) :: change_v(6), change_e(6), change(2)
      integer :: c

      slope = 0.0_wp
      do c = first, last
         change_v = system%d(:, contacts%block_v(c)) - system%previous_d(:, contacts%block_v(c))
         change_e = system%d(:, contacts%block_e(c)) - system%previous_d(:, contacts%block_e(c))
         change = relative_motion(contacts, c, change_v, change_e)
         contacts%gap_change(c) = change(1)
         contacts%slip_change(c) = change(2)
         slope = slope - contacts%normal_force(c)*contacts%gap_change(c) &
            + contacts%shear_force(c)*contacts%slip_change(c)
      end do
   end subroutine measure_changes_range

   !> Sum the slopes of contacts in the same branch at both ends, and set their changes to zero.
   subroutine sum_linear(contacts, laws, linear)
      type(contacts_type), intent(inout) :: contacts  !< contacts after `measure_changes`
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      real(wp), intent(out) :: linear(2)  !< slope at the previous d and its increase, J/m
      real(wp) :: part(2, most_pieces)
      integer :: p

      linear = 0.0_wp
      if (allocated(contacts%frozen_bound)) return
      if (contacts%n < parallel_from) then
         call sum_linear_range(contacts, laws, 1, contacts%n, linear)
         return
      end if
      !$omp parallel do schedule(static)
      do p = 1, pieces(contacts%n)
         call sum_linear_range(contacts, laws, first_of(p, contacts%n), last_of(p, contacts%n), &
            part(:, p))
      end do
      linear = sum(part(:, :pieces(contacts%n)), 2)
   end subroutine sum_linear

   !> Sum the linear slopes of contacts first … last.
   pure subroutine sum_linear_range(contacts, laws, first, last, linear)
      type(contacts_type), intent(inout) :: contacts  !< contacts after `measure_changes`
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: first, last  !< first and last in the range
      real(wp), intent(out) :: linear(2)  !< slope at the previous d and its increase, J/m
      type(response_type) :: before, after
      real(wp) :: slope
      integer :: c

      linear = 0.0_wp
      do c = first, last
         call respond_at(contacts, laws, c, 0.0_wp, before)
         call respond_at(contacts, laws, c, 1.0_wp, after)
         if (.not. same_branch(contacts, laws, c, before, after)) cycle
         slope = energy_slope(contacts, c, before)
         linear = linear + [slope, energy_slope(contacts, c, after) - slope]
         contacts%gap_change(c) = 0.0_wp
         contacts%slip_change(c) = 0.0_wp
      end do
   end subroutine sum_linear_range

   !> Sum the slope of all contacts at a fraction of the step from the previous d to the new d.
   real(wp) function contact_slope(contacts, laws, alpha) result(slope)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      real(wp), intent(in) :: alpha  !< fraction of the step
      real(wp) :: part(most_pieces)
      integer :: p

      if (contacts%n < parallel_from) then
         slope = sum_slopes_range(contacts, laws, alpha, 1, contacts%n)
         return
      end if
      !$omp parallel do schedule(static, 4)  ! nonlinear contacts may be contiguous
      do p = 1, pieces(contacts%n)
         part(p) = sum_slopes_range(contacts, laws, alpha, first_of(p, contacts%n), &
            last_of(p, contacts%n))
      end do
      slope = sum(part(:pieces(contacts%n)))
   end function contact_slope

   !> Sum the slope of contacts first … last.
   pure real(wp) function sum_slopes_range(contacts, laws, alpha, first, last) result(slope)
      type(contacts_type), intent(in) :: contacts  !< contacts after `measure_changes`
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      real(wp), intent(in) :: alpha  !< fraction of the step
      integer, intent(in) :: first, last  !< first and last in the range
      type(response_type) :: response
      integer :: c

      slope = 0.0_wp
      do c = first, last
         if (.not. abs(contacts%gap_change(c)) + abs(contacts%slip_change(c)) > 0.0_wp) cycle
         call respond_at(contacts, laws, c, alpha, response)
         slope = slope + energy_slope(contacts, c, response)
      end do
   end function sum_slopes_range

   !> Find the forces of contact c at a fraction of the step.
   pure subroutine respond_at(contacts, laws, c, alpha, response)
      type(contacts_type), intent(in) :: contacts  !< contacts after `measure_changes`
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: c  !< number of the contact
      real(wp), intent(in) :: alpha  !< fraction of the step
      type(response_type), intent(out) :: response  !< state and forces

      call find_response(contacts, laws, c, &
         contacts%new_gap(c) - (1.0_wp - alpha)*contacts%gap_change(c), &
         contacts%stretch(c) + contacts%slip(c) - (1.0_wp - alpha)*contacts%slip_change(c), &
         response)
   end subroutine respond_at

   !> Return the slope of the energy of contact c, J/m.
   pure real(wp) function energy_slope(contacts, c, response) result(slope)
      type(contacts_type), intent(in) :: contacts  !< contacts after `measure_changes`
      integer, intent(in) :: c  !< number of the contact
      type(response_type), intent(in) :: response  !< forces of the contact

      slope = response%shear_force*contacts%slip_change(c) &
         - response%normal_force*contacts%gap_change(c)
   end function energy_slope

end module dda_line_search
