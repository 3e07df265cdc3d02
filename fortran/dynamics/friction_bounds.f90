! SPDX-License-Identifier: GPL-3.0-or-later
!> Outer iteration of the friction bounds around the open–close iteration.
!>
!> With frozen friction bounds a step has one solution, the minimum of a convex function, and the
!> iteration finds it.  Its normal forces give new bounds.  This map of bounds is continuous, and
!> bounded because frozen friction only dissipates.  By Brouwer's theorem it has a fixed point, a
!> solution with friction, for any coefficient of friction.
!>
!> If more normal force leads to more slip resistance and thereby to more normal force, simple
!> repetition diverges from one fixed point, often by 0.1 % an iteration, towards another at which
!> contacts lock.  Differences that keep their direction and do not decrease are therefore
!> extrapolated; other differences that do not decrease are damped.
module dda_friction_bounds
   use dda_kinds, only: wp
   use dda_contact, only: contacts_type
   use dda_friction, only: friction_bound, laws_type
   implicit none
   private
   public :: bounds_type, hold_bounds, release_bounds, renew_bounds

   real(wp), parameter :: same_way = 0.99_wp !< cosine between differences that keep their direction
   real(wp), parameter :: stretch = 4.0_wp  !< factor of such a difference, relative to the last one
   real(wp), parameter :: shorter = 0.5_wp    !< factor of other differences that do not decrease
   real(wp), parameter :: longer = 1.2_wp     !< factor of those that decrease

   !> Differences of the bounds.
   type :: bounds_type
      integer :: worst = 0                     !< contact with the largest present difference
      real(wp) :: difference = 0.0_wp          !< largest present difference, N/m
      real(wp) :: share = 1.0_wp               !< fraction of a difference that is applied
      real(wp) :: stretched = 1.0_wp           !< last factor of extrapolation
      real(wp) :: length = 0.0_wp              !< norm of the last differences, N/m
      real(wp), allocatable :: change(:)       !< [n] the last differences, N/m
   end type bounds_type

contains

   !> Freeze the friction bounds of the contacts at their present normal forces.
   pure subroutine hold_bounds(bounds, contacts, laws)
      type(bounds_type), intent(out) :: bounds  !< no differences yet
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step, evaluated
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      integer :: c

      allocate (bounds%change(contacts%n), source=0.0_wp)
      contacts%held_bound = friction_bound(contacts, laws, [(c, c=1, contacts%n)])
   end subroutine hold_bounds

   !> Release the friction bounds, so that they depend on the normal forces again.
   pure subroutine release_bounds(contacts)
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step

      if (allocated(contacts%held_bound)) deallocate (contacts%held_bound)
   end subroutine release_bounds

   !> Set the next bounds from the normal forces at the frozen ones.
   pure subroutine renew_bounds(bounds, contacts, laws)
      type(bounds_type), intent(inout) :: bounds  !< of the step
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step, solved
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      real(wp) :: change(contacts%n), length, along
      logical :: keeps_direction
      integer :: c

      change = friction_bound(contacts, laws, [(c, c=1, contacts%n)]) - contacts%held_bound
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
      contacts%held_bound = max(0.0_wp, contacts%held_bound &
         + merge(bounds%stretched, bounds%share, keeps_direction)*change)
      bounds%change = change
      bounds%length = length
      bounds%worst = maxloc(abs(change), 1)
      bounds%difference = abs(change(bounds%worst))
   end subroutine renew_bounds

end module dda_friction_bounds
