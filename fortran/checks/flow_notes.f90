! SPDX-License-Identifier: GPL-3.0-or-later
!> Notes on water flow in joints: missing boundary conditions and channels that are too long.
!>
!> A harmonic pressure of angular frequency ω penetrates a joint to the depth √(2c/ω), with the
!> diffusivity c = a³/(12μ)/(1/k + a/K_w).
module dda_flow_notes
   use dda_kinds, only: wp, pi
   use dda_flow, only: flow_steady, flow_transient, flow_undrained
   use dda_magnitudes, only: note_length
   use dda_model, only: model_type
   use dda_text, only: short_text
   implicit none
   private
   public :: flow_notes

   real(wp), parameter :: frequency = 1.0_wp  !< frequency of the reported depths, Hz

contains

   !> Notes on the water flow in a model; none without &flow.
   pure function flow_notes(model) result(notes)
      type(model_type), intent(in) :: model  !< model as read from the input
      character(len=note_length), allocatable :: notes(:)
      real(wp) :: depth, longest, own
      integer :: c

      allocate (notes(0))
      if (.not. allocated(model%flow)) return
      associate (flow => model%flow)
         if (size(flow%boundary) == 0 .and. any(flow%state == flow_steady)) notes = &
            [character(len=note_length) :: notes, 'water in joints: no head, pressure or '// &
            'inflow is given, so steady pressures equal those at the start; add &flow_boundary']
         depth = huge(1.0_wp)
         longest = 0.0_wp
         do c = 1, size(flow%channel)
            own = pressure_depth(model, c)
            if (own >= depth) cycle
            depth = own
            longest = flow%channel(c)%length
         end do
         if (flow%state(2) == flow_transient .and. longest > 0.5_wp*depth) notes = &
            [character(len=note_length) :: notes, 'water in joints: pressures of '// &
            short_text(frequency)//' Hz reach '//short_text(depth)//' m into a joint, '// &
            'but a channel is '//short_text(longest)//' m long; give channel_length = '// &
            short_text(0.25_wp*depth)//', or state = ''undrained''']
         if (flow%state(2) == flow_undrained .and. depth > longest) notes = &
            [character(len=note_length) :: notes, 'water in joints: pressures of '// &
            short_text(frequency)//' Hz reach '//short_text(depth)//' m into a joint, past '// &
            'the next node, but state = ''undrained'' allows no flow between nodes; use '// &
            'state = ''transient''']
      end associate
   end function flow_notes

   !> Depth, m, to which a pressure penetrates the joint of channel c.
   pure real(wp) function pressure_depth(model, c) result(depth)
      type(model_type), intent(in) :: model  !< model with flow
      integer, intent(in) :: c               !< channel
      real(wp) :: stiffness, diffusivity

      associate (channel => model%flow%channel(c), law => &
         model%flow%law(model%flow%channel(c)%law), joint => &
         model%joints(model%blocks%joint(model%flow%channel(c)%edge)))
         stiffness = joint%normal_stiffness
         if (.not. stiffness > 0.0_wp) stiffness = 2*model%contact%normal_stiffness/channel%length
         diffusivity = law%aperture**3/(12.0_wp*law%viscosity) &
            /(1.0_wp/stiffness + law%aperture/law%bulk_modulus)
         depth = sqrt(diffusivity/(pi*frequency))
      end associate
   end function pressure_depth

end module dda_flow_notes
