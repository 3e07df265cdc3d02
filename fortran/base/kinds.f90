! SPDX-License-Identifier: GPL-3.0-or-later
!> Number kinds and mathematical constants.
module dda_kinds
   use, intrinsic :: iso_fortran_env, only: int64, real32, real64
   implicit none
   private
   public :: wp, sp, long, pi

   integer, parameter :: wp = real64    !< working precision of all physics
   integer, parameter :: sp = real32    !< single precision, for preconditioners only
   integer, parameter :: long = int64   !< counters that may exceed 2**31

   real(wp), parameter :: pi = acos(-1.0_wp)

end module dda_kinds
