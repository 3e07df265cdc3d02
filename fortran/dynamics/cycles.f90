! SPDX-License-Identifier: GPL-3.0-or-later
!> Cycles of the open–close iteration: detected when a set of states repeats, broken by changing
!> only some of the contacts that want to change.
!>
!> A pseudo-random choice by the numbers of contact and iteration: the same input gives the same
!> iterates, and no cycle survives, since the choice differs each time it comes round.
module dda_cycles
   use dda_kinds, only: long
   implicit none
   private
   public :: cycle_type, record_states, may_change

   integer, parameter :: memory = 32                         !< iterations that are remembered
   integer(long), parameter :: prime = 2147483647_long, base = 48271_long  !< of hash and choice
   integer, parameter :: state_radix = 4                     !< more than any state
   integer, parameter :: together = 15                       !< such digits stay below `prime`

   !> Hashes of the last sets of states.
   type :: cycle_type
      integer(long) :: mark(memory) = -1
      integer :: noted = 0
      logical :: back = .false.   !< the present states have been assumed before
   end type cycle_type

contains

   !> Remember a set of states by its hash, and see whether it repeats one.
   pure subroutine record_states(past, state)
      type(cycle_type), intent(inout) :: past  !< states that have been assumed
      integer, intent(in) :: state(:)  !< contact_open, contact_slide or contact_stick
      integer(long) :: mark, digits
      integer :: c, first

      mark = 1
      do first = 1, size(state), together
         digits = 0
         do c = first, min(first + together - 1, size(state))
            digits = state_radix*digits + state(c)
         end do
         mark = modulo(base*mark + digits, prime)
      end do
      past%back = any(past%mark == mark)
      past%noted = past%noted + 1
      past%mark(1 + modulo(past%noted, memory)) = mark
   end subroutine record_states

   !> Contact c may change in this iteration: always, or by choice while states repeat.
   elemental logical function may_change(past, c)
      type(cycle_type), intent(in) :: past  !< states that have been assumed
      integer, intent(in) :: c  !< number of the contact

      may_change = .true.
      if (past%back) may_change = modulo(base*modulo(base*(c + 1009_long*past%noted), prime), &
         prime) > prime/2
   end function may_change

end module dda_cycles
