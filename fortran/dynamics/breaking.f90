! SPDX-License-Identifier: GPL-3.0-or-later
!> Breaking of welded faces at the end of each step.
!>
!> If the traction of a face reaches the strength of its joint at one of three points, the joint
!> replaces the face and begins with the tractions of all three points.  The triangles of the face
!> are added to their cells.  No force changes, because the stress difference of triangle and cell
!> becomes an initial stress, which decreases with the damage of the joint.  When the bond has
!> failed and the face is open, its two edges become outer edges, which can have contacts.  The
!> energy of these changes is the term `breaking` of the energy budget.
module dda_breaking
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type, update_geometry
   use dda_broken_faces, only: face_force, find_face_strength, begin_joint, find_joint_damage, &
      joint_motion, crack_points
   use dda_cell_faces, only: separate_cells
   use dda_elements, only: set_elements, update_stored
   use dda_energy, only: add_energy, total_energy, energy_breaking
   use dda_energy_budget, only: update_state
   use dda_model, only: model_type
   use dda_ordered_sums, only: parallel_from
   use dda_simulation, only: simulation_type, next_step
   use dda_weld, only: is_shifted, is_intact, set_welds, assign_triangles, weld_cracked, weld_open
   use dda_weld_springs, only: cell_strain
   implicit none
   private
   public :: break_faces, can_break, restore_faces

   !> slip/face length after which the joint of the face no longer acts
   real(wp), parameter :: farthest = 0.1_wp

contains

   !> Break faces and separate broken faces after a step.
   subroutine break_faces(simulation)
      type(simulation_type), intent(inout) :: simulation  !< between two steps
      real(wp), allocatable :: traction(:,:,:)
      integer, allocatable :: broken(:), opened(:)
      real(wp) :: former_energy
      integer :: i

      if (.not. can_break(simulation%model)) return
      broken = break_faces_at_strength(simulation)
      opened = separate_gaping_faces(simulation)
      former_energy = total_energy(simulation%energy)
      call release_stresses(simulation)
      if (size(broken) + size(opened) > 0) then
         allocate (traction(2, crack_points, size(broken)))
         do i = 1, size(broken)
            call break_face(simulation, broken(i), traction(:, :, i))
         end do
         do i = 1, size(opened)
            call reduce_initial_stress(simulation, opened(i), 0.0_wp)
            simulation%model%welds(opened(i))%state = weld_open
         end do
         call update_cell_areas(simulation, size(opened) > 0)
         call set_elements(simulation%elements, simulation%model, simulation%blocks, &
            simulation%time)
         do i = 1, size(broken)
            call begin_joint(simulation%elements, broken(i), simulation%blocks, traction(:, :, i))
         end do
         simulation%counters%broken = simulation%counters%broken + size(broken)
      end if
      call update_state(simulation%energy, simulation%blocks)
      if (size(broken) + size(opened) > 0) call update_stored(simulation%elements, &
         simulation%blocks, next_step(simulation), simulation%energy)
      call add_energy(simulation%energy, energy_breaking, total_energy(simulation%energy) &
         - former_energy)
   end subroutine break_faces

   !> .true. if some faces of a model can break.
   pure logical function can_break(model)
      type(model_type), intent(in) :: model  !< model as read from the input

      can_break = allocated(model%welds)
      if (can_break) can_break = any(model%welds%joint > 0)
   end function can_break

   !> Break the intact faces whose traction has reached their strength; return their numbers.
   function break_faces_at_strength(simulation) result(faces)
      type(simulation_type), intent(in) :: simulation  !< between two steps
      integer, allocatable :: faces(:)
      logical :: reached(size(simulation%model%welds))
      real(wp) :: traction(2, crack_points), ratio
      integer :: i

      reached = .false.
      associate (welds => simulation%model%welds, blocks => simulation%blocks)
         !$omp parallel do schedule(static) private(traction, ratio) &
         !$omp if (size(welds) >= parallel_from)
         do i = 1, size(welds)
            if (welds(i)%joint == 0 .or. .not. is_intact(welds(i))) cycle
            if (any(blocks%removed(welds(i)%block))) cycle
            call find_face_strength(simulation%elements, i, face_force(simulation%elements, i, &
               blocks), traction, ratio)
            reached(i) = ratio >= 1.0_wp
         end do
         faces = pack([(i, i=1, size(welds))], reached)
      end associate
   end function break_faces_at_strength

   !> Separate faces with a failed bond that are open at all points or have slipped far.
   !> Return their numbers.
   function separate_gaping_faces(simulation) result(faces)
      type(simulation_type), intent(in) :: simulation  !< between two steps
      integer, allocatable :: faces(:)
      logical :: gapes(size(simulation%model%welds)), spent
      real(wp) :: motion(2, crack_points), damage
      integer :: i

      gapes = .false.
      associate (welds => simulation%model%welds)
         do i = 1, size(welds)
            if (welds(i)%state /= weld_cracked) cycle
            call find_joint_damage(simulation%elements, i, damage, spent)
            if (.not. spent) cycle
            motion = joint_motion(simulation%elements, i, simulation%blocks)
            gapes(i) = all(motion(1, :) > 0.0_wp) .or. &
               maxval(abs(motion(2, :))) > farthest*welds(i)%length
         end do
         faces = pack([(i, i=1, size(welds))], gapes)
      end associate
   end function separate_gaping_faces

   !> Reduce the initial stresses of broken faces in proportion to the damage of their joints.
   subroutine release_stresses(simulation)
      type(simulation_type), intent(inout) :: simulation  !< between two steps
      real(wp) :: damage
      logical :: spent
      integer :: i

      do i = 1, size(simulation%model%welds)
         if (simulation%model%welds(i)%state /= weld_cracked) cycle
         call find_joint_damage(simulation%elements, i, damage, spent)
         call reduce_initial_stress(simulation, i, 1.0_wp - damage)
      end do
   end subroutine release_stresses

   !> Set the initial stress due to the break of face i to a fraction of its value at the break.
   subroutine reduce_initial_stress(simulation, i, fraction)
      type(simulation_type), intent(inout) :: simulation  !< between two steps
      integer, intent(in) :: i                            !< broken face
      real(wp), intent(in) :: fraction                    !< remaining fraction
      integer :: k

      associate (weld => simulation%model%welds(i), blocks => simulation%blocks)
         do k = 1, 2
            associate (b => weld%block(k))
               if (.not. blocks%interior_fraction(b) > 0.0_wp) cycle
               blocks%initial_stress(:, b) = blocks%initial_stress(:, b) + (fraction &
                  - weld%break_fraction) &
                  *weld%break_stress(:, k)/(blocks%interior_fraction(b)*blocks%area(b))
            end associate
         end do
         weld%break_fraction = fraction
      end associate
   end subroutine reduce_initial_stress

   !> Break face i: add its triangles to its cells without changing any force.
   subroutine break_face(simulation, i, traction)
      type(simulation_type), intent(inout) :: simulation    !< between two steps
      integer, intent(in) :: i                              !< intact face
      real(wp), intent(out) :: traction(2, crack_points)  !< traction at the points of the face, Pa
      real(wp) :: force(size(cell_strain) + 4), ratio, elastic(3), area
      integer :: k

      force = face_force(simulation%elements, i, simulation%blocks)
      call find_face_strength(simulation%elements, i, force, traction, ratio)
      associate (weld => simulation%model%welds(i), blocks => simulation%blocks)
         do k = 1, 2
            associate (b => weld%block(k))
               ! The area-weighted mean of remainder and triangle preserves the sum of A σ.
               area = blocks%interior_fraction(b)*blocks%area(b)
               elastic = matmul(blocks%stiffness(:, :, b), blocks%position(4:6, b))/blocks%area(b)
               weld%break_stress(:, k) = force(cell_strain(:, k)) - weld%area(k)*(elastic &
                  + blocks%initial_stress(:, b))
               blocks%initial_stress(:, b) = blocks%initial_stress(:, b) + weld%break_stress(:, k) &
                  /(area + weld%area(k))
               blocks%interior_fraction(b) = blocks%interior_fraction(b) &
                  + weld%area(k)/blocks%area(b)
            end associate
         end do
         weld%state = weld_cracked
         weld%break_fraction = 1.0_wp
      end associate
   end subroutine break_face

   !> Update the part of each cell's area that is outside the triangles of its faces.
   !> If faces have opened, update sides, joints and neighbours too.
   subroutine update_cell_areas(simulation, opened)
      type(simulation_type), intent(inout) :: simulation  !< between two steps
      logical, intent(in) :: opened                       !< some faces have been separated
      type(blocks_type) :: initial_blocks
      integer :: i, e, b

      initial_blocks = simulation%blocks
      initial_blocks%position = simulation%model%blocks%position
      call update_geometry(initial_blocks)
      associate (welds => simulation%model%welds, blocks => simulation%blocks)
         call set_welds(initial_blocks, pack(welds, .not. is_shifted(welds)))
         call assign_triangles(initial_blocks, pack(welds, is_shifted(welds)))
         blocks%interior_fraction = initial_blocks%interior_fraction
         simulation%system%constant_step%time_step = 0.0_wp  ! K has changed
         if (.not. opened) return
         blocks%inner = initial_blocks%inner
         blocks%outline = initial_blocks%outline
         call separate_cells(blocks, simulation%model%blocks, welds)
         do i = 1, size(welds)
            if (welds(i)%state /= weld_open) cycle
            do e = 1, 2
               b = welds(i)%block(e)
               blocks%joint(welds(i)%edge(e)) = welds(i)%joint
               associate (joint => blocks%joint(blocks%first(b):blocks%first(b + 1) - 1))
                  blocks%mixed(b) = any(joint /= joint(1))
               end associate
            end do
         end do
      end associate
      simulation%neighbours%reach = 0.0_wp  ! search neighbours again
   end subroutine update_cell_areas

   !> Restore the model from the states of faces in a checkpoint.
   subroutine restore_faces(simulation)
      !> new simulation with face states from the checkpoint
      type(simulation_type), intent(inout) :: simulation
      real(wp) :: search_distance

      if (all(is_intact(simulation%model%welds))) return
      search_distance = simulation%neighbours%reach
      call update_cell_areas(simulation, .true.)
      simulation%neighbours%reach = search_distance
   end subroutine restore_faces

end module dda_breaking
