! SPDX-License-Identifier: GPL-3.0-or-later
!> One recorded motion: uniformly sampled acceleration, velocity or displacement.
module dda_record_type
   use dda_kinds, only: wp
   implicit none
   private
   public :: record_type, quantity_in, acceleration, velocity, displacement

   character(len=*), parameter :: acceleration = 'acceleration' !< quantity in m/s²
   character(len=*), parameter :: velocity = 'velocity'         !< quantity in m/s
   character(len=*), parameter :: displacement = 'displacement' !< quantity in m

   !> A record as read, in SI units.
   type :: record_type
      real(wp) :: time_step = 0.0_wp                !< time between samples (s)
      real(wp), allocatable :: values(:)            !< samples (m/s², m/s or m) [samples]
      character(len=:), allocatable :: quantity     !< 'acceleration', 'velocity' or 'displacement'
      character(len=:), allocatable :: station      !< name in the header; blank if there is none
      character(len=:), allocatable :: description  !< event and component of the header
      character(len=:), allocatable :: file         !< file from which it was read
      !> 'smc', 'at2', 'knet', 'esm', 'cosmos' or 'text'
      character(len=:), allocatable :: format
      !> of the numbers in the file, as stated there or by the caller
      character(len=:), allocatable :: unit
   end type record_type

contains

   !> Quantity that a text names; blank if none.
   pure function quantity_in(text) result(quantity)
      character(len=*), intent(in) :: text   !< in lower case
      character(len=:), allocatable :: quantity

      quantity = ''
      if (index(text, 'accel') > 0) quantity = acceleration
      if (index(text, 'veloc') > 0) quantity = velocity
      if (index(text, 'displ') > 0) quantity = displacement
   end function quantity_in

end module dda_record_type
