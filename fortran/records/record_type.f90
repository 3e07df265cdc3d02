! SPDX-License-Identifier: GPL-3.0-or-later
!> One recorded motion (uniformly sampled acceleration, velocity or displacement), and the units
!> that users and headers write.
module dda_record_type
   use dda_kinds, only: wp
   use dda_text, only: lower_case
   implicit none
   private
   public :: record_type, quantity_in, acceleration, velocity, displacement, unit_type, find_unit, &
      known_units

   character(len=*), parameter :: acceleration = 'acceleration' !< quantity in m/s²
   character(len=*), parameter :: velocity = 'velocity'         !< quantity in m/s
   character(len=*), parameter :: displacement = 'displacement' !< quantity in m

   !> A record in SI units.
   type :: record_type
      real(wp) :: time_step = 0.0_wp                !< time between samples (s)
      real(wp), allocatable :: values(:)            !< samples (m/s², m/s or m) [samples]
      character(len=:), allocatable :: quantity     !< 'acceleration', 'velocity' or 'displacement'
      character(len=:), allocatable :: station      !< name in the header; blank if there is none
      character(len=:), allocatable :: description  !< event and component from the header
      character(len=:), allocatable :: file         !< file from which the record was read
      character(len=:), allocatable :: format  !< 'smc', 'at2', 'knet', 'esm', 'cosmos' or 'text'
      !> unit of the numbers in the file, stated by its header or by the caller
      character(len=:), allocatable :: unit
   end type record_type

   !> A unit and its quantity.
   type :: unit_type
      !> 'm/s2', 'cm/s2', 'g', 'm/s', 'cm/s', 'm', 'cm' or 'mm'; blank: unknown
      character(len=16) :: name = ''
      character(len=16) :: quantity = ''  !< 'acceleration', 'velocity' or 'displacement'
      real(wp) :: scale = 0.0_wp          !< SI value of one unit (m/s², m/s or m)
   end type unit_type

   !> list of units for messages
   character(len=*), parameter :: known_units = "'m/s2', 'cm/s2', 'gal', 'g', 'm/s', "// &
      "'cm/s', 'm', 'cm', 'mm'"

   real(wp), parameter :: standard_gravity = 9.80665_wp   ! m/s², exact by definition (ISO 80000-3)

   !> Spellings of the units in the form of `plain_spelling`, and their meanings.
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

   !> Quantity that a text names; blank if it names none.
   pure function quantity_in(text) result(quantity)
      character(len=*), intent(in) :: text   !< text in lower case
      character(len=:), allocatable :: quantity

      quantity = ''
      if (index(text, 'accel') > 0) quantity = acceleration
      if (index(text, 'veloc') > 0) quantity = velocity
      if (index(text, 'displ') > 0) quantity = displacement
   end function quantity_in

   !> Find a unit; an unknown unit has a blank name.
   pure function find_unit(text) result(unit)
      character(len=*), intent(in) :: text   !< 'cm/s^2', 'CM/SEC/SEC', 'gal', …
      type(unit_type) :: unit
      integer :: i

      i = findloc(spellings == plain_spelling(text), .true., 1)
      if (i > 0) unit = units(i)
   end function find_unit

   !> Reduce spellings of a unit to one: lower case, no blanks, no power signs, seconds as `s`.
   pure function plain_spelling(text) result(short)
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
   end function plain_spelling

end module dda_record_type
