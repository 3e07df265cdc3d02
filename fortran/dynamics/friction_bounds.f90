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
!> Changes of the bounds that repeat their direction and do not decrease are therefore extrapolated;
!> other changes that do not decrease are damped.
module dda_friction_bounds
   use dda_kinds, only: wp
   use dda_contact, only: contacts_type
   use dda_friction, only: find_bound, laws_type
   implicit none
   private
   public :: bounds_type, freeze_bounds, unfreeze_bounds, renew_bounds

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
   end type bounds_type

contains

   !> Freeze the friction bounds of the contacts at their present normal forces.
   pure subroutine freeze_bounds(bounds, contacts, laws)
      type(bounds_type), intent(out) :: bounds  !< new iteration
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step, evaluated
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer :: c

      allocate (bounds%change(contacts%n))
      allocate (contacts%frozen_bound(contacts%n), contacts%frozen_lifting(contacts%n))
      call find_bound(contacts, laws, [(c, c=1, contacts%n)], contacts%frozen_bound, &
         contacts%frozen_lifting, bounds%change)
      bounds%change = 0.0_wp
   end subroutine freeze_bounds

   !> Let the friction bounds depend on the normal forces again.
   pure subroutine unfreeze_bounds(contacts)
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step

      if (allocated(contacts%frozen_bound)) &
         deallocate (contacts%frozen_bound, contacts%frozen_lifting)
   end subroutine unfreeze_bounds

   !> Set the next bounds from the normal forces of the solution with the present frozen bounds.
   pure subroutine renew_bounds(bounds, contacts, laws)
      type(bounds_type), intent(inout) :: bounds  !< iteration of the bounds
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step, solved
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      real(wp), dimension(contacts%n) :: bound, lifting, difference, change
      real(wp) :: factor, length, along
      logical :: keeps_direction
      integer :: c

      call find_bound(contacts, laws, [(c, c=1, contacts%n)], bound, lifting, difference)
      change = bound - contacts%frozen_bound
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
      contacts%frozen_bound = max(0.0_wp, contacts%frozen_bound + factor*change)
      contacts%frozen_lifting = contacts%frozen_lifting &
         + min(1.0_wp, factor)*(lifting - contacts%frozen_lifting)
      bounds%change = change
      bounds%length = length
      difference = max(difference, abs(change))
      bounds%unconverged = maxloc(difference, 1)
      bounds%difference = difference(bounds%unconverged)
   end subroutine renew_bounds

end module dda_friction_bounds
