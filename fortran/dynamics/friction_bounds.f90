! SPDX-License-Identifier: GPL-3.0-or-later
!> Fixed-point iteration of the friction bounds, with an open–close iteration in each pass.
!>
!> With constant (frozen) friction bounds, the solution of a step is the unique minimum of a convex
!> function, which the open–close iteration finds.  Its normal forces determine new bounds.  This
!> map of bounds is continuous; it is bounded because frozen friction only dissipates.  By Brouwer's
!> theorem the map has a fixed point, the solution with friction, for any coefficient of friction.
!>
!> If normal force and slip resistance increase each other, the plain iteration diverges from one
!> fixed point, often by 0.1 % per pass, towards another fixed point at which contacts lock.
!> Two methods alternate, because each finds fixed points that the other does not find.  Relaxation
!> extrapolates changes of the bounds that repeat their direction and do not decrease, and damps
!> other changes that do not decrease.  The other method is Anderson acceleration.
!>
!> Of 72 hard walls per law, runs that complete with relaxation, acceleration, and both:
!> dilating joints 70, 66, 71; Barton–Bandis 71, 69, 72; continuously yielding 60, 66, 69.
module dda_friction_bounds
   use dda_kinds, only: wp
   use dda_anderson, only: anderson_type, accelerate
   use dda_contact, only: contacts_type
   use dda_friction, only: find_bound, laws_type
   implicit none
   private
   public :: bounds_type, freeze_bounds, unfreeze_bounds, renew_bounds

   !> mixing factor of Anderson acceleration in successive searches of a step; 0: relaxation
   real(wp), parameter :: mixing(4) = [0.0_wp, 0.3_wp, 0.0_wp, 1.0_wp]
   !> least cosine of the angle between equal directions
   real(wp), parameter :: least_cosine = 0.99_wp
   real(wp), parameter :: stretch = 4.0_wp  !< growth of `extrapolation` per pass
   !> factor of `fraction` if the difference does not decrease
   real(wp), parameter :: shorter = 0.5_wp
   real(wp), parameter :: longer = 1.2_wp     !< factor of `fraction` if the difference decreases

   !> Iteration of the bounds; a difference is the change of a bound in a pass.
   type :: bounds_type
      integer :: unconverged = 0               !< contact with the largest present difference
      real(wp) :: difference = 0.0_wp          !< largest present difference, N/m
      real(wp) :: fraction = 1.0_wp            !< fraction of a difference that is applied
      real(wp) :: extrapolation = 1.0_wp       !< last extrapolation factor
      real(wp) :: length = 0.0_wp              !< norm of the last difference, N/m
      real(wp), allocatable :: change(:)       !< [contacts] the last difference, N/m
      real(wp) :: mixing = 0.0_wp              !< see `mixing`
      type(anderson_type) :: memory            !< memory of Anderson acceleration
   end type bounds_type

contains

   !> Freeze the friction bounds of the contacts at their present normal forces.
   pure subroutine freeze_bounds(bounds, contacts, laws, round)
      type(bounds_type), intent(out) :: bounds  !< new iteration
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step, evaluated
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer, intent(in) :: round  !< number of the iteration in this step, from 1
      real(wp), allocatable :: bound(:), lifting(:)
      integer :: c

      bounds%mixing = mixing(modulo(round - 1, size(mixing)) + 1)
      allocate (bounds%change(contacts%n), bound(contacts%n), lifting(contacts%n))
      call find_bound(contacts, laws, [(c, c=1, contacts%n)], bound, lifting, bounds%change)
      call move_alloc(bound, contacts%frozen_bound)
      call move_alloc(lifting, contacts%frozen_lifting)
      bounds%change = 0.0_wp
   end subroutine freeze_bounds

   !> Let the friction bounds depend on the normal forces again.
   pure subroutine unfreeze_bounds(contacts)
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step

      if (allocated(contacts%frozen_bound)) &
         deallocate (contacts%frozen_bound, contacts%frozen_lifting)
   end subroutine unfreeze_bounds

   !> Set the next bounds from the normal forces of the solution with the present frozen bounds.
   subroutine renew_bounds(bounds, contacts, laws, tolerance)
      type(bounds_type), intent(inout) :: bounds  !< iteration of the bounds
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step, solved
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      real(wp), intent(in) :: tolerance  !< of forces, N/m
      real(wp), dimension(contacts%n) :: bound, lifting, difference, change
      logical :: vanishes(contacts%n)
      real(wp) :: factor
      integer :: c

      call find_bound(contacts, laws, [(c, c=1, contacts%n)], bound, lifting, difference)
      change = bound - contacts%frozen_bound
      vanishes = .not. bound > 0.0_wp
      factor = 1.0_wp
      if (bounds%mixing > 0.0_wp) then
         bound = contacts%frozen_bound
         call accelerate(bounds%memory, bound, contacts%frozen_bound + bounds%mixing*change)
      else
         call find_factor(bounds, change, factor)
         bound = contacts%frozen_bound + factor*change
      end if
      ! A small force that remains would retain the whole cohesion of an open contact.
      where (vanishes .and. bound <= tolerance) bound = 0.0_wp
      contacts%frozen_bound = max(0.0_wp, bound)
      contacts%frozen_lifting = contacts%frozen_lifting &
         + min(1.0_wp, factor)*(lifting - contacts%frozen_lifting)
      difference = max(difference, abs(change))
      bounds%unconverged = maxloc(difference, 1)
      bounds%difference = difference(bounds%unconverged)
   end subroutine renew_bounds

   !> Find the fraction of a change to apply, above 1 to extrapolate; store the change.
   pure subroutine find_factor(bounds, change, factor)
      type(bounds_type), intent(inout) :: bounds  !< iteration of the bounds
      real(wp), intent(in) :: change(:)           !< [contacts] present change of the bounds, N/m
      real(wp), intent(out) :: factor             !< fraction of the change
      real(wp) :: length, along
      logical :: keeps_direction

      ! The first change counts as an increase, so half of it is applied: the whole change would
      ! need 8 to 16 % more iterations in hard walls.
      length = norm2(change)
      along = dot_product(change, bounds%change)
      keeps_direction = length >= bounds%length .and. along > least_cosine*length*bounds%length
      if (along < 0.0_wp) bounds%extrapolation = 1.0_wp
      if (keeps_direction) then
         bounds%extrapolation = stretch*bounds%extrapolation
      else if (length >= bounds%length) then
         bounds%fraction = shorter*bounds%fraction
      else
         bounds%fraction = min(1.0_wp, longer*bounds%fraction)
      end if
      factor = merge(bounds%extrapolation, bounds%fraction, keeps_direction)
      bounds%change = change
      bounds%length = length
   end subroutine find_factor

end module dda_friction_bounds
