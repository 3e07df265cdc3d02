! SPDX-License-Identifier: GPL-3.0-or-later
!> Frequency band with most of the energy of the motions of a run.
module dda_check_band
   use dda_kinds, only: wp
   use dda_errors, only: error_type
   use dda_motion, only: motion_type
   use dda_spectrum, only: compute_fourier_spectrum
   implicit none
   private
   public :: band_type, find_significant_band

   real(wp), parameter :: tail_fraction = 0.05_wp  !< energy fraction below and above the band

   !> Band from 5 to 95 % of the energy of the acceleration spectra.
   type :: band_type
      logical :: has_energy = .false.     !< at least one motion has energy
      real(wp) :: lowest = 0.0_wp    !< Hz
      real(wp) :: highest = 0.0_wp   !< Hz
   end type band_type

contains

   !> Find the band that contains the bands of all motions.
   subroutine find_significant_band(motions, band)
      type(motion_type), intent(in) :: motions(:)  !< prescribed motions
      type(band_type), intent(out) :: band  !< frequency band, Hz
      type(band_type) :: motion_band
      integer :: i

      do i = 1, size(motions)
         call find_motion_band(motions(i), motion_band)
         if (.not. motion_band%has_energy) cycle
         if (.not. band%has_energy) band = motion_band
         band%lowest = min(band%lowest, motion_band%lowest)
         band%highest = max(band%highest, motion_band%highest)
      end do
   end subroutine find_significant_band

   !> Find the band of one motion.
   subroutine find_motion_band(motion, band)
      type(motion_type), intent(in) :: motion  !< prescribed motion
      type(band_type), intent(out) :: band  !< frequency band, Hz
      real(wp), allocatable :: frequency(:)
      complex(wp), allocatable :: spectrum(:)
      type(error_type), allocatable :: error
      real(wp) :: total, cumulative_energy
      integer :: i

      call compute_fourier_spectrum(motion%curve%acceleration, motion%curve%time_step, frequency, &
         spectrum, error)
      if (allocated(error)) return
      total = sum(abs(spectrum)**2)
      if (.not. total > 0.0_wp) return
      cumulative_energy = 0.0_wp
      do i = 1, size(frequency)
         cumulative_energy = cumulative_energy + abs(spectrum(i))**2
         if (cumulative_energy < tail_fraction*total) band%lowest = frequency(i)
         if (cumulative_energy <= (1.0_wp - tail_fraction)*total) band%highest = frequency(i)
      end do
      band%has_energy = band%highest > 0.0_wp
   end subroutine find_motion_band

end module dda_check_band
