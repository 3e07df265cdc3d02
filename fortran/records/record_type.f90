!> One recorded motion: uniformly sampled acceleration, velocity or displacement.
module dda_record_type
   use dda_kinds, only: wp
   implicit none
   private
   public :: record_type, acceleration, velocity, displacement

   character(len=*), parameter :: acceleration = 'acceleration' !< quantity in m/s²
   character(len=*), parameter :: velocity = 'velocity'         !< quantity in m/s
   character(len=*), parameter :: displacement = 'displacement' !< quantity in m

   !> A record as read, in SI units.
   type :: record_type
      real(wp) :: time_step = 0.0_wp                !< time between samples (s)
      real(wp), allocatable :: values(:)            !< samples (m/s², m/s or m) [samples]
      character(len=:), allocatable :: quantity     !< 'acceleration', 'velocity' or 'displacement'
      character(len=:), allocatable :: station      !< as the header names it, blank if it does not
      character(len=:), allocatable :: description  !< what the header says of event and component
      character(len=:), allocatable :: file         !< where it was read from
      !> 'smc', 'at2', 'knet', 'esm', 'cosmos' or 'text'
      character(len=:), allocatable :: format
      !> of the numbers in the file, as given there or by the caller
      character(len=:), allocatable :: unit
   end type record_type

end module dda_record_type
