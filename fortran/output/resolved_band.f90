! SPDX-License-Identifier: GPL-3.0-or-later
!> Resolved frequency: below it, accelerations of measured points are ground motion; above it,
!> ringing and impacts of contacts contaminate them.  It is the frequency of the shortest
!> wave that blocks or cells resolve, and at most a quarter of the sampling rate.
module dda_resolved_band
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type, smaller_side
   use dda_material, only: elasticity
   use dda_model, only: model_type
   implicit none
   private
   public :: resolved_frequency

   real(wp), parameter :: min_wavelength_ratio = 8.0_wp  !< resolved wavelength/block side
   real(wp), parameter :: sampling_fraction = 0.25_wp !< fraction of the sampling rate

contains

   !> Resolved frequency, Hz.  Blocks on rigid supports are omitted, because they transmit no waves.
   pure real(wp) function resolved_frequency(model, blocks) result(frequency)
      type(model_type), intent(in) :: model    !< model of the run
      type(blocks_type), intent(in) :: blocks  !< blocks of the run
      logical :: on_rigid_support(blocks%n)
      real(wp) :: d(3, 3)
      integer :: b

      on_rigid_support = .false.
      on_rigid_support(pack(model%fixed_points%block, &
         model%fixed_points%stiffness <= 0.0_wp)) = .true.
      if (all(on_rigid_support)) on_rigid_support = .false.
      frequency = sampling_fraction/sampling_interval(model)
      do b = 1, blocks%n
         if (on_rigid_support(b)) cycle
         d = blocks%area(b)*elasticity(model%materials(model%blocks%material(b)), &
            model%control%plane_strain)
         frequency = min(frequency, sqrt(d(3, 3)/model%blocks%mass(b))/ &
            (min_wavelength_ratio*smaller_side(blocks, b)))
      end do
   end function resolved_frequency

   !> Longest time between samples in any stage, s.
   pure real(wp) function sampling_interval(model) result(interval)
      type(model_type), intent(in) :: model  !< model of the run

      interval = maxval(model%stages%time_step, mask=.not. model%stages%static)
      if (.not. interval > 0.0_wp) interval = 1.0_wp
      if (model%output%history_seconds > 0.0_wp) then
         interval = max(interval, model%output%history_seconds)
      else
         interval = interval*max(1, model%output%history_interval)
      end if
   end function sampling_interval

end module dda_resolved_band
