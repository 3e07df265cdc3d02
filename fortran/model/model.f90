! SPDX-License-Identifier: GPL-3.0-or-later
!> Checked content of an input file, which a run does not change.
module dda_model
   use dda_kinds, only: wp, long
   use dda_settings, only: control_type, contact_settings_type, output_settings_type, &
      amplification_type, stop_settings_type
   use dda_material, only: material_type, joint_type
   use dda_support, only: fixed_point_type, load_type, measured_joint_type, point_type
   use dda_motion, only: motion_type
   use dda_stage, only: stage_type
   use dda_text, only: quoted, to_text
   use dda_tie, only: tie_type
   use dda_weld, only: weld_type
   use dda_blocks, only: blocks_type
   use dda_bolt, only: bolt_type
   use dda_boundary, only: boundary_type, boundary_edge_type, boundary_motion_type
   use dda_edge_load, only: edge_load_type
   use dda_flow, only: flow_type
   use dda_free_field, only: free_field_type
   implicit none
   private
   public :: model_type, block_source_type, half_size, contact_distance, default_stiffness, &
      force_noise, run_steps, run_duration, block_sources, drift_velocity, block_label

   !> A file of blocks.
   type :: block_source_type
      character(len=:), allocatable :: file
      integer(long) :: checksum = 0                  !< checksum of its content
   end type block_source_type

   !> A model; blocks have their initial state.
   type :: model_type
      character(len=:), allocatable :: title
      character(len=:), allocatable :: file          !< file from which the model was read
      character(len=:), allocatable :: text          !< text of the input, for provenance
      character(len=:), allocatable :: values  !< all values of the input, see `resolved_values`
      !> added to each position in the output; the engine computes relative to this origin
      real(wp) :: origin(2) = 0.0_wp
      type(control_type) :: control
      type(contact_settings_type) :: contact
      type(output_settings_type) :: output
      type(stop_settings_type) :: stop
      type(material_type), allocatable :: materials(:)
      type(joint_type), allocatable :: joints(:)
      type(motion_type), allocatable :: motions(:)
      type(fixed_point_type), allocatable :: fixed_points(:)
      type(boundary_edge_type), allocatable :: boundary_edges(:)  !< edges of all groups &boundary
      type(boundary_type), allocatable :: boundaries(:)  !< absorbing boundaries
      type(boundary_motion_type), allocatable :: boundary_motions(:)  !< motions for the output
      type(tie_type), allocatable :: ties(:)         !< ties of the left with the right side
      type(weld_type), allocatable :: welds(:)       !< faces of bodies
      type(free_field_type), allocatable :: free_fields(:)  !< free fields at the sides
      type(load_type), allocatable :: loads(:)
      type(edge_load_type), allocatable :: edge_loads(:) !< tractions and water
      type(bolt_type), allocatable :: bolts(:)
      type(flow_type), allocatable :: flow           !< not allocated: no water flows in joints
      type(point_type), allocatable :: points(:)
      type(measured_joint_type), allocatable :: measured_joints(:)
      type(stage_type), allocatable :: stages(:)     !< stages in order, at least one
      type(amplification_type), allocatable :: amplifications(:)
      character(len=64), allocatable :: block_names(:)
      character(len=64), allocatable :: body_names(:)
      type(block_source_type), allocatable :: block_files(:)  !< empty if all blocks are in the text
      type(blocks_type) :: blocks
      !> [2,blocks] ∂σx/∂y and ∂σy/∂y of initial stress, Pa/m; not allocated: no gradient
      real(wp), allocatable :: stress_gradient(:,:)
   end type model_type

contains

   !> Half of the larger side of the initial bounding box of all blocks, m (w0 of the original DDA).
   pure real(wp) function half_size(blocks)
      type(blocks_type), intent(in) :: blocks  !< blocks

      half_size = blocks%half_size
   end function half_size

   !> Least distance, m, at which contacts are listed.
   !> It is 2.5 times the largest displacement per step.  It is at most a fraction of the smallest
   !> block, because otherwise large models would list many open contacts.
   pure real(wp) function contact_distance(model)
      type(model_type), intent(in) :: model  !< complete model

      contact_distance = min(2.5_wp*max(model%control%max_displacement_ratio, &
         4.0e-4_wp)*half_size(model%blocks), 0.2_wp*minval(model%blocks%radius))
   end function contact_distance

   !> Common velocity, m/s, along x and y of all supports and boundaries after their motions; zero
   !> if they have different velocities.
   pure function drift_velocity(model) result(velocity)
      type(model_type), intent(in) :: model  !< model as read from the input
      real(wp) :: velocity(2)
      real(wp) :: end_velocity, velocity_after(0:size(model%motions))
      logical :: has_support
      integer :: i, axis

      velocity_after = [0.0_wp, (model%motions(i)%curve%velocity_after, i=1, size(model%motions))]
      do axis = 1, 2
         has_support = .false.
         velocity(axis) = 0.0_wp
         do i = 1, size(model%fixed_points) + size(model%boundaries)
            if (i <= size(model%fixed_points)) then
               if (.not. model%fixed_points(i)%fixed_along(axis)) cycle
               end_velocity = velocity_after(model%fixed_points(i)%motion(axis))
            else
               end_velocity = velocity_after(model%boundaries(i &
                  - size(model%fixed_points))%motion(axis))
            end if
            if (has_support .and. end_velocity /= velocity(axis)) velocity = 0.0_wp
            if (has_support .and. end_velocity /= velocity(axis)) return
            has_support = .true.
            velocity(axis) = end_velocity
         end do
      end do
   end function drift_velocity

   !> Number of steps of all stages; repeated steps count once.
   pure integer(long) function run_steps(model)
      type(model_type), intent(in) :: model  !< model as read from the input

      run_steps = sum(model%stages%steps)
   end function run_steps

   !> Duration of all stages, s; static stages have none.
   pure real(wp) function run_duration(model)
      type(model_type), intent(in) :: model  !< model as read from the input

      run_duration = sum(model%stages%steps*model%stages%time_step)
   end function run_duration

   !> Text with one line per block file: path, and checksum of its content.
   pure function block_sources(model) result(text)  ! total
      type(model_type), intent(in) :: model  !< model as read from the input
      character(len=:), allocatable :: text
      character(len=16) :: digits
      integer :: i

      text = ''
      if (.not. allocated(model%block_files)) return
      do i = 1, size(model%block_files)
         associate (source => model%block_files(i))
            write (digits, '(z16.16)') source%checksum
            text = text//source%file(index(source%file, '/', back=.true.) + 1:)//', CRC-64 '// &
               digits//new_line('a')
         end associate
      end do
   end function block_sources

   !> Contact force due to rounding of positions, N/m.
   pure real(wp) function force_noise(model, stiffness)
      type(model_type), intent(in) :: model  !< model as read from the input
      real(wp), intent(in) :: stiffness  !< stiffness of joints that are stiffer than contacts, N/m

      force_noise = 16*epsilon(1.0_wp)*half_size(model%blocks) &
         *max(model%contact%normal_stiffness, stiffness)
   end function force_noise

   !> Default penalty: 40 × the largest Young's modulus × 1 m (paper §2.2).
   pure real(wp) function default_stiffness(materials)
      type(material_type), intent(in) :: materials(:)  !< [materials] materials of the model

      default_stiffness = 40.0_wp*maxval(materials%young_modulus)
   end function default_stiffness

   !> Text of a block: its name, or its number if it has none.
   pure function block_label(model, b) result(label)
      type(model_type), intent(in) :: model  !< model with its blocks
      integer, intent(in) :: b               !< number of the block
      character(len=:), allocatable :: label

      label = 'block '//to_text(b)
      if (model%block_names(b) /= '') label = 'block '//quoted(trim(model%block_names(b)))
   end function block_label

end module dda_model
