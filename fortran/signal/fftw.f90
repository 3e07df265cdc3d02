! SPDX-License-Identifier: GPL-3.0-or-later
!> Interface to FFTW 3 (fftw.org, Fortran 2003 interface).
module dda_fftw
   ! The included interface needs most names of iso_c_binding, so there is no `only`.
   use, intrinsic :: iso_c_binding
   use dda_kinds, only: wp
   implicit none
   private
   public :: transform_forward

   include 'fftw3.f03'

contains

   !> Compute X(k) = Σ x(j) exp(−2πi j k/n), k = 0 … n/2, of a real series; not scaled.
   subroutine transform_forward(series, spectrum, success)
      real(wp), intent(inout) :: series(:)                  !< [n] series, unchanged on return
      complex(wp), intent(out) :: spectrum(:)               !< [n/2 + 1]
      logical, intent(out) :: success  !< .false.: memory is lacking
      ! An estimated plan is the same in every run.  Without assumptions on the alignment of arrays,
      ! the order of summation is the same too: results are bit-identical.
      integer(c_int), parameter :: flags = ior(FFTW_ESTIMATE, &
         ior(FFTW_UNALIGNED, FFTW_PRESERVE_INPUT))
      type(c_ptr) :: plan

      spectrum = (0.0_wp, 0.0_wp)
      plan = fftw_plan_dft_r2c_1d(int(size(series), c_int), series, spectrum, flags)
      success = c_associated(plan)
      if (.not. success) return
      call fftw_execute_dft_r2c(plan, series, spectrum)
      call fftw_destroy_plan(plan)
   end subroutine transform_forward

end module dda_fftw
