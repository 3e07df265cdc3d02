! SPDX-License-Identifier: GPL-3.0-or-later
!> Primal–dual interior-point method for the forces of unilateral contacts with Coulomb friction.
!>
!> A contact presses with N ≥ 0, and w = N + k_n g ≥ 0 is what keeps it open, N w = 0.  Friction
!> T = k_s s − λ₁ + λ₂ leaves b − T ≥ 0 and b + T ≥ 0 to its bound b, with λ₁ (b − T) = 0 and
!> λ₂ (b + T) = 0.  These complementarity products are positive and equal to a barrier parameter ε²
!> on the central path, which leads to the law as ε goes to 0: all contacts keep springs, whose
!> shares N/(N + w) and 1/(1 + λ₁/(b − T) + λ₂/(b + T)) tend to those of open and closed, slide and
!> stick.  On the path N differs from the law by ε at most.
!>
!> Newton's method for the products, with predictor and correctors: S. Mehrotra, SIAM J. Optim. 2
!> (1992) 575; J. Gondzio, Comput. Optim. Appl. 6 (1996) 137.  The bound follows the normal force of
!> the last Newton step, since K̂ is symmetric.
module dda_interior_point
   use dda_kinds, only: wp
   use dda_contact, only: contacts_type
   use dda_friction, only: laws_type
   use dda_ordered_sums, only: pieces, first_of, last_of, most_pieces, parallel_from
   implicit none
   private
   public :: interior_type, begin_interior, set_base_point, set_targets, correct_targets, &
      set_bound_steps, assume_interior, find_step, take_step, mean_product

   integer, parameter :: pressed = 1, backward = 2, forward = 3  !< products of a contact
   integer, parameter :: slack_sign(2) = [1, -1]  !< s of the slacks b − s T
   real(wp), parameter :: neighbourhood = 10.0_wp !< ratio of products to their target, at most
   real(wp), parameter :: first_share = 0.9_wp    !< of the bound, that |T| begins within

   !> Iterates of all contacts, and the Newton step of the last solution.
   type :: interior_type
      integer :: n = 0                            !< contacts
      real(wp), allocatable :: factor(:,:,:)      !< [2,3,n] N, w; λ₁, b − T; λ₂, b + T, N/m
      real(wp), allocatable :: factor_step(:,:,:) !< [2,3,n] their Newton steps, N/m
      real(wp), allocatable :: target(:,:)        !< [3,n] of the products, (N/m)²
      real(wp), allocatable :: shear(:)           !< [n] T, N/m
      real(wp), allocatable :: shear_step(:)      !< [n] its Newton step, N/m
      real(wp), allocatable :: bound(:)           !< [n] b, N/m
      real(wp), allocatable :: bound_step(:)      !< [n] its step, N/m
      real(wp), allocatable :: trial(:,:)         !< [2,n] −k_n g, k_s s at the base point, N/m
      real(wp), allocatable :: base(:,:)          !< [2,n] gap and slip at the base point, m
   end type interior_type

contains

   !> Iterates near the central path at a radius ε, for the present gaps and slips.
   subroutine begin_interior(points, contacts, laws, radius)
      type(interior_type), intent(out) :: points  !< of the list
      type(contacts_type), intent(in) :: contacts !< this step's list, measured
      type(laws_type), intent(in) :: laws         !< plain, not damped
      real(wp), intent(in) :: radius              !< ε, N/m
      real(wp) :: trial(2), shear
      integer :: c, n

      n = contacts%n
      points%n = n
      allocate (points%factor(2, 3, n), points%factor_step(2, 3, n), points%target(3, n), &
         points%shear(n), points%shear_step(n), points%bound(n), points%bound_step(n), &
         points%trial(2, n), points%base(2, n))
      points%factor_step = 0.0_wp
      points%shear = 0.0_wp
      points%shear_step = 0.0_wp
      points%bound = 0.0_wp
      do c = 1, n
         trial = trial_forces(contacts, laws, c)
         points%factor(:, :, c) = 0.0_wp
         if (contacts%bonded(c)) cycle
         associate (factor => points%factor(:, :, c), bound => points%bound(c))
            factor(:, pressed) = [rounded(trial(1), radius), rounded(-trial(1), radius)]
            bound = max(laws%friction(contacts%joint(c)), epsilon(bound))*factor(1, pressed)
            shear = min(abs(trial(2)), first_share*bound)
            factor(2, backward:forward) = bound - slack_sign*sign(shear, trial(2))
            factor(1, backward:forward) = radius**2/factor(2, backward:forward)
            points%shear(c) = sign(shear, trial(2))
         end associate
      end do
   end subroutine begin_interior

   !> max(x, 0) with a corner of radius ε: its product with the same of −x is ε².
   elemental real(wp) function rounded(x, radius)
      real(wp), intent(in) :: x       !< N/m
      real(wp), intent(in) :: radius  !< ε, N/m

      rounded = 0.5_wp*(abs(x) + hypot(x, 2*radius))
      if (x < 0.0_wp) rounded = radius**2/rounded
   end function rounded

   !> Forces of contact c at its gap and slip if it is closed and sticks, N/m.
   pure function trial_forces(contacts, laws, c) result(forces)
      type(contacts_type), intent(in) :: contacts  !< this step's list, measured
      type(laws_type), intent(in) :: laws          !< plain, not damped
      integer, intent(in) :: c                     !< number of the contact
      real(wp) :: forces(2)

      forces = [contacts%multiplier(c) - laws%normal_stiffness*contacts%new_gap(c), &
         laws%shear_stiffness*(contacts%stretch(c) + contacts%slip(c))]
   end function trial_forces

   !> Newton steps begin at the present gaps and slips.
   subroutine set_base_point(points, contacts, laws)
      type(interior_type), intent(inout) :: points !< of the list
      type(contacts_type), intent(in) :: contacts  !< this step's list, measured
      type(laws_type), intent(in) :: laws          !< plain, not damped
      integer :: c

      !$omp parallel do schedule(static) &
      !$omp if (points%n >= parallel_from)
      do c = 1, points%n
         points%trial(:, c) = trial_forces(contacts, laws, c)
         points%base(:, c) = [contacts%new_gap(c), contacts%slip(c)]
      end do
   end subroutine set_base_point

   !> The bounds step to those of the normal forces at a step length along the last Newton step.
   subroutine set_bound_steps(points, contacts, laws, length)
      type(interior_type), intent(inout) :: points !< of the list
      type(contacts_type), intent(in) :: contacts  !< this step's list
      type(laws_type), intent(in) :: laws          !< strength of the contacts
      real(wp), intent(in) :: length               !< 0: at the present ones
      integer :: c

      !$omp parallel do schedule(static) &
      !$omp if (points%n >= parallel_from)
      do c = 1, points%n
         points%bound_step(c) = laws%friction(contacts%joint(c))*max(0.0_wp, &
            points%factor(1, pressed, c) + length*points%factor_step(1, pressed, c)) &
            - points%bound(c)
      end do
   end subroutine set_bound_steps

   !> One target for all products, less the products of the last Newton steps within a limit
   !> (Mehrotra's term of second order).
   subroutine set_targets(points, barrier, most)
      type(interior_type), intent(inout) :: points !< of the list
      real(wp), intent(in) :: barrier              !< ε², (N/m)²
      real(wp), intent(in) :: most                 !< limit of that term, (N/m)²
      integer :: c

      !$omp parallel do schedule(static) &
      !$omp if (points%n >= parallel_from)
      do c = 1, points%n
         points%target(:, c) = barrier &
            - max(-most, min(most, product(points%factor_step(:, :, c), 1)))
      end do
   end subroutine set_targets

   !> Correct the targets of products that would leave the neighbourhood of the barrier parameter at
   !> a step length along the last Newton step (Gondzio).
   subroutine correct_targets(points, barrier, length)
      type(interior_type), intent(inout) :: points !< of the list
      real(wp), intent(in) :: barrier              !< ε², (N/m)²
      real(wp), intent(in) :: length               !< of the step
      real(wp) :: product_at(3)
      integer :: c

      !$omp parallel do private(product_at) schedule(static) &
      !$omp if (points%n >= parallel_from)
      do c = 1, points%n
         product_at = product(points%factor(:, :, c) + length*points%factor_step(:, :, c), 1)
         points%target(:, c) = points%target(:, c) + max(-neighbourhood*barrier, &
            min(neighbourhood*barrier, max(barrier/neighbourhood, product_at)) - product_at)
      end do
   end subroutine correct_targets

   !> Forces of the Newton step to the targets, linear in gap and slip: the contacts assume them.
   subroutine assume_interior(points, contacts, laws)
      type(interior_type), intent(in) :: points       !< of the list
      type(contacts_type), intent(inout) :: contacts  !< gets `imposed_spring`, `imposed_force`
      type(laws_type), intent(in) :: laws             !< stiffness of the contacts
      real(wp) :: share(2), forces(2)
      integer :: c

      !$omp parallel do private(share, forces) schedule(static) &
      !$omp if (points%n >= parallel_from)
      do c = 1, points%n
         share = spring_shares(points, contacts, c)
         forces = [points%factor(1, pressed, c), points%shear(c)] + steps_at(points, contacts, c, &
            [0.0_wp, 0.0_wp])
         associate (springs => contacts%imposed_spring(:, c))
            springs = share*[laws%normal_stiffness, laws%shear_stiffness]
            contacts%imposed_force(:, c) = forces + springs &
               *[points%base(1, c) - contacts%gap(c), -points%base(2, c)]
         end associate
      end do
   end subroutine assume_interior

   !> Shares of the springs that act in contact c.
   pure function spring_shares(points, contacts, c) result(share)
      type(interior_type), intent(in) :: points    !< of the list
      type(contacts_type), intent(in) :: contacts  !< this step's list
      integer, intent(in) :: c                     !< number of the contact
      real(wp) :: share(2)

      share = 1.0_wp
      if (contacts%bonded(c)) return
      associate (factor => points%factor(:, :, c))
         share(1) = factor(1, pressed)/sum(factor(:, pressed))
         share(2) = 1.0_wp/(1.0_wp + sum(factor(1, backward:forward)/factor(2, backward:forward)))
      end associate
   end function spring_shares

   !> Changes of normal and shear force of contact c, N/m, by those of its trial forces.
   pure function steps_at(points, contacts, c, trial_step) result(steps)
      type(interior_type), intent(in) :: points    !< of the list
      type(contacts_type), intent(in) :: contacts  !< this step's list
      integer, intent(in) :: c                     !< number of the contact
      real(wp), intent(in) :: trial_step(2)        !< N/m
      real(wp) :: steps(2), residual(3), multiplier_step(2), share(2)

      associate (factor => points%factor(:, :, c), trial => points%trial(:, c), &
         shear => points%shear(c))
         steps = trial + trial_step - [factor(1, pressed), shear]
         if (contacts%bonded(c)) return
         share = spring_shares(points, contacts, c)
         residual = points%target(:, c) - product(factor, 1)
         steps(1) = residual(1)/sum(factor(:, pressed)) &
            + share(1)*(factor(2, pressed) - factor(1, pressed) + trial(1) + trial_step(1))
         multiplier_step = (residual(backward:forward) - factor(1, backward:forward) &
            *slack_steps(points, c))/factor(2, backward:forward)
         steps(2) = share(2)*(trial(2) + trial_step(2) - shear &
            - dot_product(slack_sign, factor(1, backward:forward) + multiplier_step))
      end associate
   end function steps_at

   !> Changes of b − T and b + T while T stays, N/m.
   pure function slack_steps(points, c) result(steps)
      type(interior_type), intent(in) :: points  !< of the list
      integer, intent(in) :: c                   !< number of the contact
      real(wp) :: steps(2)

      steps = points%bound(c) + points%bound_step(c) - slack_sign*points%shear(c) &
         - points%factor(2, backward:forward, c)
   end function slack_steps

   !> The Newton step of the last solution, and the step length that keeps all factors positive.
   subroutine find_step(points, contacts, laws, longest)
      type(interior_type), intent(inout) :: points !< of the list
      type(contacts_type), intent(in) :: contacts  !< this step's list, measured at the solution
      type(laws_type), intent(in) :: laws          !< stiffness of the contacts
      real(wp), intent(out) :: longest             !< at most 1
      real(wp) :: steps(2), residual(3)
      integer :: c

      longest = 1.0_wp
      !$omp parallel do private(steps, residual) reduction(min:longest) schedule(static) &
      !$omp if (points%n >= parallel_from)
      do c = 1, points%n
         if (contacts%bonded(c)) cycle
         associate (factor => points%factor(:, :, c), step => points%factor_step(:, :, c))
            steps = steps_at(points, contacts, c, &
               trial_forces(contacts, laws, c) - points%trial(:, c))
            residual = points%target(:, c) - product(factor, 1)
            step(:, pressed) = [steps(1), (residual(1) - factor(2, pressed)*steps(1)) &
               /factor(1, pressed)]
            points%shear_step(c) = steps(2)
            step(2, backward:forward) = slack_steps(points, c) - slack_sign*steps(2)
            step(1, backward:forward) = (residual(backward:forward) - factor(1, backward:forward) &
               *step(2, backward:forward))/factor(2, backward:forward)
            longest = min(longest, minval(-factor/step, step < 0.0_wp))
         end associate
      end do
   end subroutine find_step

   !> Take the Newton step at a step length.
   subroutine take_step(points, length)
      type(interior_type), intent(inout) :: points !< of the list
      real(wp), intent(in) :: length               !< less than the longest
      integer :: c

      !$omp parallel do schedule(static) &
      !$omp if (points%n >= parallel_from)
      do c = 1, points%n
         points%factor(:, :, c) = points%factor(:, :, c) + length*points%factor_step(:, :, c)
         points%shear(c) = points%shear(c) + length*points%shear_step(c)
         points%bound(c) = points%bound(c) + length*points%bound_step(c)
      end do
   end subroutine take_step

   !> Mean complementarity product at a step length along the Newton step, (N/m)².
   real(wp) function mean_product(points, length)
      type(interior_type), intent(in) :: points !< of the list
      real(wp), intent(in) :: length            !< of the step
      real(wp) :: piece(most_pieces)
      integer :: p

      !$omp parallel do schedule(static) &
      !$omp if (points%n >= parallel_from)
      do p = 1, pieces(points%n)
         associate (first => first_of(p, points%n), last => last_of(p, points%n))
            piece(p) = sum(product(points%factor(:, :, first:last) &
               + length*points%factor_step(:, :, first:last), 1))
         end associate
      end do
      mean_product = sum(piece(:pieces(points%n)))/(3*points%n)
   end function mean_product

end module dda_interior_point
