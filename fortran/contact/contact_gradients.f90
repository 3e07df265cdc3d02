! SPDX-License-Identifier: GPL-3.0-or-later
!> Gap and slip of a contact, and their gradients in the coordinates q of its blocks.
!>
!> Each row is nᵀT or tᵀT (T: `shape_matrix` of dda_blocks).  A list stores only the entries of the
!> rotation and of the two axial strains: the translation has the entries n and t = (−n₂, n₁), and
!> the entry of the shear strain follows from the axial ones.
module dda_contact_gradients
   use dda_kinds, only: wp
   use dda_contact, only: contacts_type
   use dda_ordered_sums, only: pieces, first_of, last_of, parallel_from
   implicit none
   private
   public :: rows_type, acting_rows, add_assumed_forces, assumed_forces, find_rows, &
      measure_contacts, measure_range, motion_in_step, relative_motion, set_gradient, normal_row, &
      shear_row

   !> Gradients of gap and slip of a contact in the coordinates q of its two blocks.
   type :: rows_type
      real(wp) :: normal_v(6)  !< ∂gap/∂q of the vertex block
      real(wp) :: normal_e(6)  !< −∂gap/∂q of the edge block
      real(wp) :: shear_v(6)   !< ∂slip/∂q of the vertex block
      real(wp) :: shear_e(6)   !< −∂slip/∂q of the edge block
   end type rows_type

contains

   !> Compute the stored entries (θ, ε_x, ε_y) of the rows of a material point, first for n, then t.
   pure subroutine set_gradient(axes, offset, reference, normal, gradient)
      real(wp), intent(in) :: axes(2, 2)    !< R(θ) of the block
      real(wp), intent(in) :: offset(2)     !< lever arm of the forces, m
      real(wp), intent(in) :: reference(2)  !< reference offset ρ of the point, m
      real(wp), intent(in) :: normal(2)     !< outward normal n of the edge
      real(wp), intent(out) :: gradient(6)  !< stored entries, m
      real(wp) :: x, y

      x = axes(1, 1)*normal(1) + axes(2, 1)*normal(2)
      y = axes(1, 2)*normal(1) + axes(2, 2)*normal(2)
      gradient = [normal(2)*offset(1) - normal(1)*offset(2), x*reference(1), y*reference(2), &
         normal(1)*offset(1) + normal(2)*offset(2), -y*reference(1), x*reference(2)]
   end subroutine set_gradient

   !> Compute the rows of gap and slip of contact c for its two blocks.
   pure subroutine find_rows(contacts, c, rows)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      integer, intent(in) :: c                     !< number of the contact
      type(rows_type), intent(out) :: rows         !< rows for the coordinates q of the two blocks

      associate (normal => contacts%normal(:, c), of_v => contacts%gradient_v(:, c), &
         of_e => contacts%gradient_e(:, c))
         rows%normal_v = normal_row(normal, of_v)
         rows%normal_e = normal_row(normal, of_e)
         rows%shear_v = shear_row(normal, of_v)
         rows%shear_e = shear_row(normal, of_e)
      end associate
   end subroutine find_rows

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

   !> Compute gap and slip of all contacts at d.
   subroutine measure_contacts(contacts, d)
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step
      real(wp), intent(in), contiguous :: d(:,:)  !< [6,blocks] increments of the coordinates
      integer :: p

      if (contacts%n < parallel_from) then
         call measure_range(contacts, d, 1, contacts%n)
         return
      end if
      !$omp parallel do schedule(static)
      do p = 1, pieces(contacts%n)
         call measure_range(contacts, d, first_of(p, contacts%n), last_of(p, contacts%n))
      end do
   end subroutine measure_contacts

   !> Compute gap and slip of contacts first … last.
   pure subroutine measure_range(contacts, d, first, last)
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step
      real(wp), intent(in), contiguous :: d(:,:)  !< [6,blocks] increments of the coordinates
      integer, intent(in) :: first, last  !< first and last contact
      real(wp) :: change(2)
      integer :: c

      do c = first, last
         change = relative_motion(contacts, c, d(:, contacts%block_v(c)), d(:, contacts%block_e(c)))
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
   !> The block of the vertex receives N n − T t.
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
         v = contacts%block_v(c)
         e = contacts%block_e(c)
         motion = relative_motion(contacts, c, d(:, v), d(:, e))
         if (allocated(contacts%fixed_motion)) motion = motion + contacts%fixed_motion(:, c)
         force = assumed_forces(contacts, c, motion)
         if (v >= low .and. v <= high) forces(:, v) = forces(:, v) &
            + (force(1)*normal_row(contacts%normal(:, c), contacts%gradient_v(:, c)) &
            - force(2)*shear_row(contacts%normal(:, c), contacts%gradient_v(:, c)))
         if (e >= low .and. e <= high) forces(:, e) = forces(:, e) &
            - (force(1)*normal_row(contacts%normal(:, c), contacts%gradient_e(:, c)) &
            - force(2)*shear_row(contacts%normal(:, c), contacts%gradient_e(:, c)))
      end do
   end subroutine add_assumed_forces

   !> Return the changes of the gap and slip of contact c due to changes of the coordinates.
   pure function relative_motion(contacts, c, of_v, of_e) result(change)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      integer, intent(in) :: c                     !< number of the contact
      real(wp), intent(in) :: of_v(6), of_e(6)     !< changes of the blocks of vertex and edge
      real(wp) :: change(2)

      associate (normal => contacts%normal(:, c), gradient_v => contacts%gradient_v(:, c), &
         gradient_e => contacts%gradient_e(:, c))
         change = [scalar_product(normal_row(normal, gradient_v), of_v) &
            - scalar_product(normal_row(normal, gradient_e), of_e), &
            scalar_product(shear_row(normal, gradient_v), of_v) &
            - scalar_product(shear_row(normal, gradient_e), of_e)]
      end associate
   end function relative_motion

   !> Return a · b, written out because the compiler would otherwise generate slow gather loads.
   pure real(wp) function scalar_product(a, b)
      real(wp), intent(in) :: a(6), b(6)  !< six values of a block

      scalar_product = a(1)*b(1) + a(2)*b(2) + a(3)*b(3) + a(4)*b(4) + a(5)*b(5) + a(6)*b(6)
   end function scalar_product

   !> Return the row nᵀT of a material point.
   pure function normal_row(normal, gradient) result(row)
      real(wp), intent(in) :: normal(2)    !< outward normal n of the edge
      real(wp), intent(in) :: gradient(6)  !< stored entries, m
      real(wp) :: row(6)

      row = [normal(1), normal(2), gradient(1), gradient(2), gradient(3), &
         0.5_wp*(gradient(6) - gradient(5))]
   end function normal_row

   !> Return the row tᵀT of a material point.
   pure function shear_row(normal, gradient) result(row)
      real(wp), intent(in) :: normal(2)    !< outward normal n of the edge; t = (−n₂, n₁)
      real(wp), intent(in) :: gradient(6)  !< stored entries, m
      real(wp) :: row(6)

      row = [-normal(2), normal(1), gradient(4), gradient(5), gradient(6), &
         0.5_wp*(gradient(2) - gradient(3))]
   end function shear_row

end module dda_contact_gradients
