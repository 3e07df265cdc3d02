! SPDX-License-Identifier: GPL-3.0-or-later
!> Frequency band with most of the energy of the motions of a run.
module dda_check_band
   use dda_kinds, only: wp
   use dda_errors, only: error_type
   use dda_motion, only: motion_type
   use dda_spectrum, only: fourier_spectrum
   implicit none
   private
   public :: band_type, significant_band

   real(wp), parameter :: outside = 0.05_wp  !< fraction of the energy below the band, also above it

   !> Band from 5 to 95 % of the energy of the acceleration spectra.
   type :: band_type
      logical :: has_energy = .false.     !< at least one motion has energy
      real(wp) :: lowest = 0.0_wp    !< Hz
      real(wp) :: highest = 0.0_wp   !< Hz
   end type band_type

contains

   !> Find the band that contains the bands of all motions.
   subroutine significant_band(motions, band)
      type(motion_type), intent(in) :: motions(:)  !< prescribed motions
      type(band_type), intent(out) :: band  !< frequency band, Hz
      type(band_type) :: own_band
      integer :: i

      do i = 1, size(motions)
         call motion_band(motions(i), own_band)
         if (.not. own_band%has_energy) cycle
         if (.not. band%has_energy) band = own_band
         band%lowest = min(band%lowest, own_band%lowest)
         band%highest = max(band%highest, own_band%highest)
      end do
   end subroutine significant_band

   !> Find the band of one motion.
   subroutine motion_band(motion, band)
      type(motion_type), intent(in) :: motion  !< prescribed motion
      type(band_type), intent(out) :: band  !< frequency band, Hz
      real(wp), allocatable :: frequency(:)
      complex(wp), allocatable :: spectrum(:)
      type(error_type), allocatable :: error
      real(wp) :: total, below
      integer :: i

      call fourier_spectrum(motion%curve%acceleration, motion%curve%time_step, frequency, &
         spectrum, error)
      if (allocated(error)) return
      total = sum(abs(spectrum)**2)
      if (.not. total > 0.0_wp) return
      below = 0.0_wp
      do i = 1, size(frequency)
         below = below + abs(spectrum(i))**2
         if (below < outside*total) band%lowest = frequency(i)
         if (below <= (1.0_wp - outside)*total) band%highest = frequency(i)
      end do
      band%has_energy = band%highest > 0.0_wp
   end subroutine motion_band

end module dda_check_band
