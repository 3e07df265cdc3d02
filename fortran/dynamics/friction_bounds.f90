! SPDX-License-Identifier: GPL-3.0-or-later
!> Friction bounds found from outside the open–close iteration.
!>
!> With frozen bounds of friction a step has one solution, the least of a convex function, and
!> the iteration finds it.  Its normal forces give new bounds.  This map of bounds is continuous,
!> and frozen bounds only take energy, so that it stays within limits: by Brouwer's theorem it has a
!> fixed point, a solution with friction, however high friction is.
!>
!> Where more normal force leads to more slip resistance and so to yet more normal force, plain
!> repetition runs away from one fixed point, often by parts in a thousand, towards another at which
!> contacts lock.  Differences that keep their direction and do not fall are therefore stretched; of
!> others that do not fall a smaller share is taken.
module dda_friction_bounds
   use dda_kinds, only: wp
   use dda_contact, only: contacts_type
   use dda_friction, only: laws_type
   implicit none
   private
   public :: bounds_type, hold_bounds, release_bounds, renew_bounds

   real(wp), parameter :: same_way = 0.99_wp  !< cosine of differences that keep their direction
   real(wp), parameter :: stretch = 4.0_wp    !< of such a difference, over the last stretched one
   real(wp), parameter :: shorter = 0.5_wp    !< share taken of others that do not fall
   real(wp), parameter :: longer = 1.2_wp     !< the same of those that fall

   !> Differences of the bounds.
   type :: bounds_type
      integer :: worst = 0                     !< contact with the largest of the present ones
      real(wp) :: difference = 0.0_wp          !< that one, N/m
      real(wp) :: share = 1.0_wp               !< of a difference that is taken
      real(wp) :: stretched = 1.0_wp           !< the last stretch
      real(wp) :: length = 0.0_wp              !< of the last differences, N/m
      real(wp), allocatable :: change(:)       !< [n] the last differences, N/m
   end type bounds_type

contains

   !> Hold the friction of the contacts at the bounds of their present normal forces.
   pure subroutine hold_bounds(bounds, contacts, laws)
      type(bounds_type), intent(out) :: bounds  !< no differences yet
      type(contacts_type), intent(inout) :: contacts  !< this step's list, evaluated
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts

      allocate (bounds%change(contacts%n), source=0.0_wp)
      contacts%held_bound = bounds_of(contacts, laws)
   end subroutine hold_bounds

   !> Bounds of friction are those of the normal forces again.
   pure subroutine release_bounds(contacts)
      type(contacts_type), intent(inout) :: contacts  !< this step's list

      if (allocated(contacts%held_bound)) deallocate (contacts%held_bound)
   end subroutine release_bounds

   !> The next bounds, from the normal forces that the frozen ones have led to.
   pure subroutine renew_bounds(bounds, contacts, laws)
      type(bounds_type), intent(inout) :: bounds  !< of the step
      type(contacts_type), intent(inout) :: contacts  !< this step's list, solved
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      real(wp) :: change(contacts%n), length, along
      logical :: keeps_direction

      change = bounds_of(contacts, laws) - contacts%held_bound
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

   !> Friction that the normal forces allow, N/m.
   pure function bounds_of(contacts, laws) result(bound)
      type(contacts_type), intent(in) :: contacts  !< this step's list, evaluated
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      real(wp) :: bound(contacts%n)

      bound = laws%friction(contacts%joint(:contacts%n)) &
         *max(0.0_wp, contacts%normal_force(:contacts%n))
   end function bounds_of

end module dda_friction_bounds
