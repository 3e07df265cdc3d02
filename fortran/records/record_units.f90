! SPDX-License-Identifier: GPL-3.0-or-later
!> Units of strong-motion records, as users and headers write them.
module dda_record_units
   use dda_kinds, only: wp
   use dda_text, only: lower_case
   use dda_record_type, only: acceleration, velocity, displacement
   implicit none
   private
   public :: unit_type, find_unit, known_units

   !> A unit and its quantity.
   type :: unit_type
      !> 'm/s2', 'cm/s2', 'g', 'm/s', 'cm/s', 'm', 'cm' or 'mm'; blank: unknown
      character(len=16) :: name = ''
      character(len=16) :: quantity = ''  !< 'acceleration', 'velocity' or 'displacement'
      real(wp) :: scale = 0.0_wp          !< SI value of one such unit (m/s², m/s or m)
   end type unit_type

   !> for messages
   character(len=*), parameter :: known_units = "'m/s2', 'cm/s2', 'gal', 'g', 'm/s', "// &
      "'cm/s', 'm', 'cm', 'mm'"

   real(wp), parameter :: standard_gravity = 9.80665_wp   ! m/s², exact by definition (ISO 80000-3)

   !> Spellings of the units in the form of `plain`, and their meanings.
   character(len=6), parameter :: spellings(11) = [character(len=6) :: 'm/s2', 'm/s/s', 'cm/s2', &
      'cm/s/s', 'gal', 'g', 'm/s', 'cm/s', 'm', 'cm', 'mm']
   type(unit_type), parameter :: units(11) = [ &
      unit_type('m/s2', acceleration, 1.0_wp), unit_type('m/s2', acceleration, 1.0_wp), &
      unit_type('cm/s2', acceleration, 0.01_wp), unit_type('cm/s2', acceleration, 0.01_wp), &
      unit_type('cm/s2', acceleration, 0.01_wp), unit_type('g', acceleration, standard_gravity), &
      unit_type('m/s', velocity, 1.0_wp), unit_type('cm/s', velocity, 0.01_wp), &
      unit_type('m', displacement, 1.0_wp), unit_type('cm', displacement, 0.01_wp), &
      unit_type('mm', displacement, 0.001_wp)]

contains

   !> Find a unit; an unknown unit has a blank name.
   pure function find_unit(text) result(unit)
      character(len=*), intent(in) :: text   !< 'cm/s^2', 'CM/SEC/SEC', 'gal', …
      type(unit_type) :: unit
      integer :: i

      i = findloc(spellings == plain(text), .true., 1)
      if (i > 0) unit = units(i)
   end function find_unit

   !> Reduce spellings to one: lower case, no blanks, no power signs, seconds as `s`.
   pure function plain(text) result(short)
      character(len=*), intent(in) :: text  !< text written by the caller or in a header
      character(len=:), allocatable :: short
      character(len=:), allocatable :: lowered
      integer :: i

      lowered = lower_case(text)
      short = ''
      do i = 1, min(len(lowered), 40)
         if (index(' ^*'//achar(9), lowered(i:i)) == 0) short = short//lowered(i:i)
      end do
      i = index(short, 'sec')
      do while (i > 0)
         short = short(:i)//short(i + 3:)
         i = index(short, 'sec')
      end do
   end function plain

end module dda_record_units
