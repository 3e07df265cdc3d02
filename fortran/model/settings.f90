! SPDX-License-Identifier: GPL-3.0-or-later
!> Settings of a run: steps, contacts, output, early end.
module dda_settings
   use dda_group_values, only: contact_values, control_values, output_values
   use dda_kinds, only: wp, long
   implicit none
   private
   public :: control_type, contact_settings_type, output_settings_type, amplification_type, &
      stop_settings_type, name_output

   !> Group &control: time stepping and the frame of the analysis.
   type, extends(control_values) :: control_type
      integer(long) :: step_count = 0  !< number of steps of `time_step` in the present stage
      logical :: adaptive = .false.                !< Δt may decrease and increase
      logical :: plane_strain = .false.            !< plane strain; .false.: plane stress
      logical :: analysis_given = .false.          !< the input gives `analysis`
      integer :: base_motion(2) = 0  !< motions of the base as body force, x and y; 0: none
      integer :: displaced = 0                     !< block displaced when dynamics begin; 0: none
   end type control_type

   !> Group &contact: springs and the open–close iteration.
   type, extends(contact_values) :: contact_settings_type
      !> use the open–close rules of the original DDA, for comparison
      logical :: original_rules = .false.
   end type contact_settings_type

   !> Group &output.
   type, extends(output_values) :: output_settings_type
      !> the input names the file; only a caller may name a file in any folder
      logical :: named_by_input = .true.
   end type output_settings_type

   !> A spectral ratio between two measured points (group &amplification).
   type :: amplification_type
      integer :: surface = 0            !< upper measured point
      integer :: base = 0               !< lower measured point
      integer :: axis = 1               !< 1 x, 2 y
      real(wp) :: lowest = 0.0_wp       !< lower limit of the peak search, Hz
      real(wp) :: highest = 0.0_wp      !< Hz
      integer :: padding = 8            !< ratio of padded to original length
   end type amplification_type

   !> Rules that end a run before its duration (group &stop); each limit above 0 is active.
   type :: stop_settings_type
      real(wp) :: displacement = 0.0_wp    !< displacement of a centroid, m
      real(wp) :: tilt = 0.0_wp            !< tilt of a block in either direction, rad
      integer :: fallen = 0                !< number of blocks displaced by more than their size
      real(wp) :: rest_time = 0.0_wp       !< time without movement, s
      real(wp) :: rest_movement = 0.0_wp   !< tolerated movement of a vertex in this time, m
      integer :: reference = 0          !< reference block of movements; 0: initial positions
      logical, allocatable :: watched(:)   !< [blocks] selected; not allocated: no rule
   end type stop_settings_type

contains

   !> Set the output file that the command line or the caller names.
   subroutine name_output(settings, file)
      type(output_settings_type), intent(inout) :: settings  !< settings of the input
      character(len=*), intent(in) :: file                   !< path of the output

      settings%file = trim(file)
      settings%named_by_input = .false.
   end subroutine name_output

end module dda_settings
