! SPDX-License-Identifier: GPL-3.0-or-later
!> Changes of a symmetric matrix of 6×6 blocks: added or removed terms k u uᵀ, whose u has two
!> nonzero blocks.
module dda_rank_one
   use dda_kinds, only: wp
   implicit none
   private
   public :: rank_one_type, most_changes, ignored_change, forget_changes, add_change

   integer, parameter :: most_changes = 160   !< number of stored changes; more are only counted
   !> relative change of u that is ignored, due to small changes of geometry
   real(wp), parameter :: ignored_change = 1.0e-3_wp

   !> The changes, in chronological order.
   type :: rank_one_type
      integer :: n = 0                        !< number of changes, may exceed `most_changes`
      integer :: block(2, most_changes) = 0    !< block rows of the nonzero parts of u
      real(wp) :: u(6, 2, most_changes) = 0.0_wp
      real(wp) :: k(most_changes) = 0.0_wp    !< stiffness, N/m; negative for a removed term
   end type rank_one_type

contains

   !> Empty the list of changes.
   pure subroutine forget_changes(changes)
      type(rank_one_type), intent(inout) :: changes  !< list of changes

      changes%n = 0
   end subroutine forget_changes

   !> Add the change k u uᵀ, u = (a, −b) in two block rows.
   pure subroutine add_change(changes, block_a, a, block_b, b, k)
      type(rank_one_type), intent(inout) :: changes  !< list of changes
      integer, intent(in) :: block_a, block_b  !< numbers of the block rows
      !> parts of u, and stiffness, N/m; negative for a removed term
      real(wp), intent(in) :: a(6), b(6), k

      changes%n = changes%n + 1
      if (changes%n > most_changes) return
      changes%block(:, changes%n) = [block_a, block_b]
      changes%u(:, 1, changes%n) = a
      changes%u(:, 2, changes%n) = -b
      changes%k(changes%n) = k
   end subroutine add_change

end module dda_rank_one
