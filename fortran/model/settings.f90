! SPDX-License-Identifier: GPL-3.0-or-later
!> How a run is stepped, how contacts are treated, what is written.
module dda_settings
   use dda_kinds, only: wp, long
   implicit none
   private
   public :: control_type, contact_settings_type, output_settings_type, amplification_type, &
      name_output

   !> Time stepping and the frame of the analysis (group &control).
   type :: control_type
      real(wp) :: time_step = 0.0_wp               !< Δt, s; the largest one when adaptive
      real(wp) :: duration = 0.0_wp                !< as given, s; 0: `steps` are
      integer(long) :: steps = 0                   !< of `time_step`, of the present stage
      logical :: adaptive = .false.                !< Δt may shrink and recover
      character(len=16) :: integration = 'dda'     !< member of the family of `dda_scheme`, by name
      real(wp) :: theta = 0.75_wp                  !< θ = χ of integration 'theta'
      real(wp) :: least_time_step = 0.0_wp         !< s, when adaptive
      real(wp) :: dynamic_factor = 1.0_wp          !< 1 fully dynamic … 0 static
      real(wp) :: max_displacement_ratio = 0.01_wp !< of half the model size, per step
      real(wp) :: gravity(2) = 0.0_wp              !< m/s²
      logical :: plane_strain = .false.            !< else plane stress
      logical :: analysis_given = .false.          !< the input says which
      !> motions of the base as body force, x and y; 0 none
      integer :: base_motion(2) = 0
      logical :: settle = .false.                  !< begin at rest under gravity
      character(len=16) :: solver = 'auto'         !< linear solver by name
      integer :: displaced_block = 0               !< when dynamics begin; 0 none
      real(wp) :: displaced_by(2) = 1.0e-9_wp      !< x and y, of its size
   end type control_type

   !> Contact springs and the open–close iteration (group &contact).
   type :: contact_settings_type
      real(wp) :: normal_stiffness = 0.0_wp    !< k_n, N/m per metre of thickness
      real(wp) :: shear_ratio = 2.5_wp         !< k_n / k_s
      real(wp) :: fixed_point_ratio = 100.0_wp !< stiffness of fixed points / k_n
      real(wp) :: penetration_tolerance = 0.0_wp !< m; > 0: augmented Lagrangian down to it
      !> the original DDA's open–close rules, for comparison
      logical :: original_rules = .false.
      integer :: max_iterations = 400          !< open–close iterations in a step
      real(wp) :: force_tolerance = 1.0e-9_wp  !< of the largest block weight or contact force
   end type contact_settings_type

   !> The output file (group &output).
   type :: output_settings_type
      character(len=:), allocatable :: file     !< netCDF-4; default: the input's name with .nc
      !> and not by who starts the run, who may name any place
      logical :: named_by_input = .true.
      integer :: history_interval = 1           !< steps between samples of points and energies
      !> steps between block and contact states; 0: first and last
      integer :: block_interval = 0
      real(wp) :: history_seconds = 0.0_wp      !< in place of steps; 0: by steps
      real(wp) :: block_seconds = 0.0_wp        !< in place of steps; 0: by steps
      integer :: checkpoint_interval = 0        !< steps between checkpoints; 0: none by steps
      !> of the clock between checkpoints; 0: none by the clock
      real(wp) :: checkpoint_minutes = 1.0_wp
   end type output_settings_type

   !> A spectral ratio between two measured points, wanted after the run (group &amplification).
   type :: amplification_type
      integer :: surface = 0            !< measured point above
      integer :: base = 0               !< measured point below
      integer :: axis = 1               !< 1 x, 2 y
      real(wp) :: lowest = 0.0_wp       !< Hz, where the peak is looked for
      real(wp) :: highest = 0.0_wp      !< Hz
      integer :: padding = 8            !< length with zeros over length
   end type amplification_type

contains

   !> Let who starts the run say where its output goes.
   subroutine name_output(settings, file)
      type(output_settings_type), intent(inout) :: settings  !< of the input
      character(len=*), intent(in) :: file                   !< path of the output

      settings%file = trim(file)
      settings%named_by_input = .false.
   end subroutine name_output

end module dda_settings
