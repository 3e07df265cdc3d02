! SPDX-License-Identifier: GPL-3.0-or-later
!> Types of groups and variables in the schema.
module dda_input_variable
   use dda_group_values, only: unset
   use dda_kinds, only: wp
   implicit none
   private
   public :: group_entry_type, rule_type, variable_type, above_zero, unset, usable

   real(wp), parameter :: usable = 1.0e30_wp           !< largest magnitude of an input number
   real(wp), parameter :: above_zero = tiny(1.0_wp)    !< `lowest` for any positive number

   !> A group of the input.
   type :: group_entry_type
      character(len=16) :: name
      logical :: repeats          !< may appear more than once
      logical :: built            !< `sitedda build` converts the group into blocks
      integer :: first, last      !< range of the variables in `input_variables`
   end type group_entry_type

   !> A variable of a group.
   type :: variable_type
      character(len=26) :: name
      character(len=8) :: kind    !< 'real', 'integer', 'logical', 'name', 'word', 'text', 'points'
      integer :: size             !< largest number of values; 0: a single value, no list
      real(wp) :: lowest = -usable, highest = usable  !< limits of each number
      real(wp) :: preset = unset  !< default of a number
      character(len=128) :: allowed = ''  !< allowed words: "'one', 'another'"
      logical :: required = .false.
      character(len=16) :: usual = ''    !< default of a word
      character(len=12) :: switch = ''   !< variable on which this variable depends, or blank
      character(len=128) :: belongs = '' !< values of `switch` for which the variable is used
   end type variable_type

   !> Requirement or exclusion for a group that satisfies a condition.  The condition "name" means
   !> that the variable is given (and true); a condition may also be "name = 'one', 'two'".
   type :: rule_type
      integer :: group              !< position in `input_groups`
      character(len=128) :: holder  !< condition; blank: always
      character(len=128) :: item    !< other condition, or several joined by ` or `
      logical :: excludes           !< .true.: no item is allowed; .false.: one item is required
   end type rule_type

end module dda_input_variable
