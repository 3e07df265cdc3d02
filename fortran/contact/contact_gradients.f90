! SPDX-License-Identifier: GPL-3.0-or-later
!> Gap and slip of a contact, and their gradients in the coordinates q of its blocks.
!>
!> Each row is nᵀT or tᵀT with t = (−n₂, n₁) (T: `shape_matrix` of dda_blocks).  A list stores for
!> each block the row of the gap, then the row of the slip.
module dda_contact_gradients
   use dda_kinds, only: wp
   use dda_contact, only: contacts_type
   implicit none
   private
   public :: rows_type, acting_rows, add_assumed_forces, assumed_forces, find_rows, measure_range, &
      motion_in_step, relative_motion, set_gradient

   !> Gradients of gap and slip of a contact in the coordinates q of its two blocks.
   type :: rows_type
      real(wp) :: normal_v(6)  !< ∂gap/∂q of the vertex block
      real(wp) :: normal_e(6)  !< −∂gap/∂q of the edge block
      real(wp) :: shear_v(6)   !< ∂slip/∂q of the vertex block
      real(wp) :: shear_e(6)   !< −∂slip/∂q of the edge block
   end type rows_type

contains

   !> Compute the rows nᵀT and tᵀT of a material point.
   pure subroutine set_gradient(axes, offset, reference, normal, rows)
      real(wp), intent(in) :: axes(2, 2)    !< R(θ) of the block
      real(wp), intent(in) :: offset(2)     !< lever arm of the forces, m
      real(wp), intent(in) :: reference(2)  !< reference offset ρ of the point, m
      real(wp), intent(in) :: normal(2)     !< outward normal n of the edge
      real(wp), intent(out) :: rows(6, 2)   !< rows; 1 or m
      real(wp) :: xx, yy, xy, yx

      xx = (axes(1, 1)*normal(1) + axes(2, 1)*normal(2))*reference(1)
      xy = (axes(1, 1)*normal(1) + axes(2, 1)*normal(2))*reference(2)
      yx = (axes(1, 2)*normal(1) + axes(2, 2)*normal(2))*reference(1)
      yy = (axes(1, 2)*normal(1) + axes(2, 2)*normal(2))*reference(2)
      rows(:, 1) = [normal(1), normal(2), normal(2)*offset(1) - normal(1)*offset(2), xx, yy, &
         0.5_wp*(xy + yx)]
      rows(:, 2) = [-normal(2), normal(1), normal(1)*offset(1) + normal(2)*offset(2), -yx, xy, &
         0.5_wp*(xx - yy)]
   end subroutine set_gradient

   !> Compute the rows of gap and slip of contact c for its two blocks.
   pure subroutine find_rows(contacts, c, rows)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      integer, intent(in) :: c                     !< number of the contact
      type(rows_type), intent(out) :: rows         !< rows for the coordinates q of the two blocks

      call copy_rows(contacts%gradient_v(:, c), rows%normal_v, rows%shear_v)
      call copy_rows(contacts%gradient_e(:, c), rows%normal_e, rows%shear_e)
   end subroutine find_rows

   !> Copy the rows of gap and slip of a block; copies of whole rows would call memmove.
   pure subroutine copy_rows(rows, normal, shear)
      real(wp), intent(in) :: rows(6, 2)               !< rows of the block
      real(wp), intent(out) :: normal(6), shear(6)     !< their copies

      normal = [rows(1, 1), rows(2, 1), rows(3, 1), rows(4, 1), rows(5, 1), rows(6, 1)]
      shear = [rows(1, 2), rows(2, 2), rows(3, 2), rows(4, 2), rows(5, 2), rows(6, 2)]
   end subroutine copy_rows

   !> Compute the rows for the forces of contact c in K̂; with dilation, the normal row is tilted.
   pure subroutine acting_rows(contacts, c, rows)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      integer, intent(in) :: c                     !< number of the contact
      type(rows_type), intent(out) :: rows         !< rows for the coordinates q of the two blocks

      call find_rows(contacts, c, rows)
      if (.not. contacts%with_laws) return
      associate (rise => contacts%tilt(2, c))
         rows%normal_v = rows%normal_v - rise*rows%shear_v
         rows%normal_e = rows%normal_e - rise*rows%shear_e
      end associate
   end subroutine acting_rows

   !> Compute gap and slip of contacts first … last.
   pure subroutine measure_range(contacts, d, first, last)
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step
      real(wp), intent(in), contiguous :: d(:,:)  !< [6,blocks] increments of the coordinates
      integer, intent(in) :: first, last  !< first and last contact
      real(wp) :: change(2)
      integer :: c

      do c = first, last
         call find_motion(contacts%gradient_v(:, c), contacts%gradient_e(:, c), &
            d(:, contacts%block_v(c)), d(:, contacts%block_e(c)), change)
         contacts%new_gap(c) = contacts%gap(c) + change(1)
         contacts%slip(c) = change(2)
      end do
      if (.not. allocated(contacts%fixed_motion)) return
      contacts%new_gap(first:last) = contacts%new_gap(first:last) &
         + contacts%fixed_motion(1, first:last)
      contacts%slip(first:last) = contacts%slip(first:last) + contacts%fixed_motion(2, first:last)
   end subroutine measure_range

   !> Return opening and slip of contact c in this step, m, after `measure_range`.
   pure function motion_in_step(contacts, c) result(motion)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      integer, intent(in) :: c                     !< number of the contact
      real(wp) :: motion(2)

      motion = [contacts%new_gap(c) - contacts%gap(c), contacts%slip(c)]
   end function motion_in_step

   !> Return the compression and the resistance to slip that the linear equations assume in contact
   !> c, N/m.
   pure function assumed_forces(contacts, c, motion) result(forces)
      type(contacts_type), intent(in) :: contacts  !< contacts in their assumed states
      integer, intent(in) :: c                     !< number of the contact
      real(wp), intent(in) :: motion(2)            !< opening and slip in this step, m
      real(wp) :: forces(2), opening

      opening = motion(1)
      if (contacts%with_laws) opening = opening - contacts%tilt(2, c)*motion(2)
      forces(1) = contacts%free_force(1, c) - contacts%spring(1, c)*opening
      forces(2) = contacts%free_force(2, c) + contacts%spring(2, c)*motion(2)
      if (contacts%with_laws) forces(2) = forces(2) + contacts%tilt(2, c)*forces(1)
   end function assumed_forces

   !> Add the assumed forces of contacts first … last at d to the forces on blocks low … high.
   !> The block of the vertex receives N n − T t.  Contacts without springs and forces are skipped.
   pure subroutine add_assumed_forces(contacts, first, last, n, d, low, high, forces)
      type(contacts_type), intent(in) :: contacts  !< contacts in their assumed states
      integer, intent(in) :: first, last           !< first and last contact
      integer, intent(in) :: n                     !< number of blocks
      real(wp), intent(in) :: d(6, n)              !< increments of the coordinates
      integer, intent(in) :: low, high             !< first and last block that receive forces
      real(wp), intent(inout) :: forces(6, n)      !< forces on the blocks, N
      real(wp) :: motion(2), force(2)
      integer :: c, v, e

      do c = first, last
         if (is_unloaded(contacts, c)) cycle
         v = contacts%block_v(c)
         e = contacts%block_e(c)
         call find_motion(contacts%gradient_v(:, c), contacts%gradient_e(:, c), d(:, v), d(:, e), &
            motion)
         if (allocated(contacts%fixed_motion)) motion = motion + contacts%fixed_motion(:, c)
         force = assumed_forces(contacts, c, motion)
         if (v >= low .and. v <= high) call add_force(force(1), force(2), &
            contacts%gradient_v(:, c), forces(:, v))
         if (e >= low .and. e <= high) call add_force(-force(1), -force(2), &
            contacts%gradient_e(:, c), forces(:, e))
      end do
   end subroutine add_assumed_forces

   !> .true. if the linear equations assume neither springs nor forces in contact c.
   pure logical function is_unloaded(contacts, c)
      type(contacts_type), intent(in) :: contacts  !< contacts in their assumed states
      integer, intent(in) :: c                     !< number of the contact

      is_unloaded = contacts%spring(1, c) == 0.0_wp .and. contacts%spring(2, c) == 0.0_wp .and. &
         contacts%free_force(1, c) == 0.0_wp .and. contacts%free_force(2, c) == 0.0_wp
   end function is_unloaded

   !> Return the changes of the gap and slip of contact c due to changes of the coordinates.
   pure function relative_motion(contacts, c, of_v, of_e) result(change)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      integer, intent(in) :: c                     !< number of the contact
      real(wp), intent(in) :: of_v(6), of_e(6)     !< changes of the blocks of vertex and edge
      real(wp) :: change(2)

      call find_motion(contacts%gradient_v(:, c), contacts%gradient_e(:, c), of_v, of_e, change)
   end function relative_motion

   !> Compute the changes of a gap and slip due to changes of the coordinates.
   !> Four, then two coordinates fill vector registers, as in `add_force`.
   pure subroutine find_motion(gradient_v, gradient_e, of_v, of_e, change)
      real(wp), intent(in) :: gradient_v(6, 2), gradient_e(6, 2)  !< rows of both blocks
      real(wp), intent(in) :: of_v(6), of_e(6)     !< changes of the blocks of vertex and edge
      real(wp), intent(out) :: change(2)
      real(wp) :: part(6, 2)
      integer :: i, row

      do row = 1, 2
         !$omp simd
         do i = 1, 4
            part(i, row) = gradient_v(i, row)*of_v(i) - gradient_e(i, row)*of_e(i)
         end do
         !$omp simd
         do i = 5, 6
            part(i, row) = gradient_v(i, row)*of_v(i) - gradient_e(i, row)*of_e(i)
         end do
      end do
      change = (part(1, :) + part(3, :) + part(5, :)) + (part(2, :) + part(4, :) + part(6, :))
   end subroutine find_motion

   !> Add a normal force N and a shear force −T at a material point to the force on its block.
   pure subroutine add_force(normal_force, shear_force, rows, force)
      real(wp), intent(in) :: normal_force, shear_force  !< N and T, N/m
      real(wp), intent(in) :: rows(6, 2)         !< rows of the block
      real(wp), intent(inout) :: force(6)        !< force on the block, N
      integer :: i

      !$omp simd
      do i = 1, 4
         force(i) = force(i) + (normal_force*rows(i, 1) - shear_force*rows(i, 2))
      end do
      !$omp simd
      do i = 5, 6
         force(i) = force(i) + (normal_force*rows(i, 1) - shear_force*rows(i, 2))
      end do
   end subroutine add_force

end module dda_contact_gradients
