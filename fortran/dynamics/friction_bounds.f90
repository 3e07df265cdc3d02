! SPDX-License-Identifier: GPL-3.0-or-later
!> Fixed-point iteration of the friction bounds, with an open–close iteration in each pass.
!>
!> With constant (frozen) friction bounds, the solution of a step is the unique minimum of a convex
!> function, which the open–close iteration finds.  Its normal forces determine new bounds.  This
!> map of bounds is continuous; it is bounded because frozen friction only dissipates.  By Brouwer's
!> theorem the map has a fixed point, the solution with friction, for any coefficient of friction.
!>
!> If a larger normal force increases the slip resistance, which increases the normal force, the
!> plain iteration diverges from one fixed point, often by 0.1 % per pass, towards another one at
!> which contacts lock.  Changes of the bounds that repeat their direction and do not decrease are
!> therefore extrapolated; other changes that do not decrease are damped.
module dda_friction_bounds
   use dda_kinds, only: wp
   use dda_contact, only: contacts_type
   use dda_friction, only: find_bound, laws_type
   implicit none
   private
   public :: bounds_type, hold_bounds, release_bounds, renew_bounds

   real(wp), parameter :: same_way = 0.99_wp !< least cosine of the angle between equal directions
   real(wp), parameter :: stretch = 4.0_wp  !< growth of the extrapolation factor per pass
   real(wp), parameter :: shorter = 0.5_wp  !< factor of `share` if the difference does not decrease
   real(wp), parameter :: longer = 1.2_wp     !< factor of `share` if the difference decreases

   !> Iteration of the bounds; a difference is the change of all bounds in a pass.
   type :: bounds_type
      integer :: worst = 0                     !< contact with the largest present difference
      real(wp) :: difference = 0.0_wp          !< largest present difference, N/m
      real(wp) :: share = 1.0_wp               !< fraction of a difference that is applied
      real(wp) :: stretched = 1.0_wp           !< last extrapolation factor
      real(wp) :: length = 0.0_wp              !< norm of the last difference, N/m
      real(wp), allocatable :: change(:)       !< [contacts] the last difference, N/m
   end type bounds_type

contains

   !> Freeze the friction bounds of the contacts at their present normal forces.
   pure subroutine hold_bounds(bounds, contacts, laws)
      type(bounds_type), intent(out) :: bounds  !< new iteration
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step, evaluated
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer :: c

      allocate (bounds%change(contacts%n))
      allocate (contacts%held_bound(contacts%n), contacts%held_lifting(contacts%n))
      call find_bound(contacts, laws, [(c, c=1, contacts%n)], contacts%held_bound, &
         contacts%held_lifting, bounds%change)
      bounds%change = 0.0_wp
   end subroutine hold_bounds

   !> Let the friction bounds depend on the normal forces again.
   pure subroutine release_bounds(contacts)
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step

      if (allocated(contacts%held_bound)) deallocate (contacts%held_bound, contacts%held_lifting)
   end subroutine release_bounds

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
      change = bound - contacts%held_bound
      length = norm2(change)
      along = dot_product(change, bounds%change)
      keeps_direction = length >= bounds%length .and. along > same_way*length*bounds%length
      if (along < 0.0_wp) bounds%stretched = 1.0_wp
      if (keeps_direction) then
         bounds%stretched = stretch*bounds%stretched
      else if (length >= bounds%length) then
         bounds%share = shorter*bounds%share
      else
         bounds%share = min(1.0_wp, longer*bounds%share)
      end if
      factor = merge(bounds%stretched, bounds%share, keeps_direction)
      contacts%held_bound = max(0.0_wp, contacts%held_bound + factor*change)
      contacts%held_lifting = contacts%held_lifting &
         + min(1.0_wp, factor)*(lifting - contacts%held_lifting)
      bounds%change = change
      bounds%length = length
      difference = max(difference, abs(change))
      bounds%worst = maxloc(difference, 1)
      bounds%difference = difference(bounds%worst)
   end subroutine renew_bounds

end module dda_friction_bounds
