! SPDX-License-Identifier: GPL-3.0-or-later
!> Ties as springs at t₀ + θΔt: a tie acts like a bonded contact of unlimited strength
!> (`dda_contact_geometry`).
!>
!> If corners of both faces lie at the end of the overlap, the corner whose foot lies on the other
!> face is used, as in the detection of contacts.
module dda_ties
   use dda_kinds, only: wp
   use dda_archive, only: archive_type, archive_values => serialise
   use dda_blocks, only: blocks_type
   use dda_contact_gradients, only: set_gradient
   use dda_element, only: element_type
   use dda_linear_terms, only: term_tie
   use dda_scheme, only: step_type
   use dda_spring_element, only: spring_element_type, spring_type, extension_change
   use dda_tie, only: tie_type
   implicit none
   private
   public :: ties_type, new_ties

   real(wp), parameter :: corner_ratio = 0.05_wp  !< see `dda_detection`
   real(wp), parameter :: equal_overshoots = 1.0e-9_wp  !< largest difference/size

   !> All ties of a model.
   type, extends(spring_element_type) :: ties_type
      type(tie_type), allocatable :: tie(:)
      real(wp) :: stiffness(2) = 0.0_wp       !< k_n and k_s, N/m per metre of thickness
      real(wp), allocatable :: slip(:)        !< [ties] stretch of the shear springs, m
   contains
      procedure :: get_spring, accept_step, inherit_state, serialise, add_face_force
   end type ties_type

contains

   !> Create ties without forces.
   pure type(ties_type) function new_ties(ties, stiffness) result(self)
      type(tie_type), intent(in) :: ties(:)     !< [ties]
      real(wp), intent(in) :: stiffness(2)      !< k_n and k_s, N/m per metre of thickness

      self%n = size(ties)
      self%kind = term_tie
      self%tie = ties
      self%stiffness = stiffness
      allocate (self%slip(size(ties)), source=0.0_wp)
      allocate (self%motions(0))
   end function new_ties

   !> Set the springs of tie i, with the stretch of the shear spring; none at a removed block.
   pure subroutine get_spring(self, i, blocks, spring)
      class(ties_type), intent(in) :: self      !< elements of this kind
      integer, intent(in) :: i                  !< number of the element
      type(blocks_type), intent(in) :: blocks   !< blocks in their present state
      type(spring_type), intent(out) :: spring  !< block of the vertex, block of the edge
      integer :: face

      associate (tie => self%tie(i))
         if (any(blocks%removed(blocks%owner(tie%edge)))) return
         face = corner_face(blocks, tie)
         call set_geometry(blocks, tie, face, spring)
         spring%stretch(2) = self%slip(i)
         spring%stiffness = self%stiffness
         spring%position = blocks%vertex(:, tie%edge(1))
      end associate
   end subroutine get_spring

   !> Return the face whose corner is used, 1 or 2.
   pure integer function corner_face(blocks, tie) result(face)
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(tie_type), intent(in) :: tie        !< tie
      real(wp) :: distance(2), tolerance

      distance = huge(1.0_wp)
      do face = 1, 2
         if (tie%corner(face) > 0) distance(face) = overshoot(blocks, tie, face)
      end do
      tolerance = equal_overshoots*corner_ratio*minval(blocks%length(tie%edge))
      face = merge(1, 2, tie%edge(1) < tie%edge(2))
      if (distance(face) > tolerance .and. distance(3 - face) < distance(face) &
         - tolerance) face = 3 - face
   end function corner_face

   !> Return the distance of the foot of a corner beyond the other face, m.
   pure real(wp) function overshoot(blocks, tie, face)
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(tie_type), intent(in) :: tie        !< tie
      integer, intent(in) :: face              !< face of the corner, 1 or 2
      real(wp) :: foot

      associate (e => tie%edge(3 - face))
         foot = dot_product(blocks%along(:, e), corner_offset(blocks, tie, face))
         overshoot = max(-foot, foot - blocks%length(e))
      end associate
   end function overshoot

   !> Return the vector from the first vertex of the other face to the corner of a face, m.
   pure function corner_offset(blocks, tie, face)
      type(blocks_type), intent(in) :: blocks  !< blocks in their present state
      type(tie_type), intent(in) :: tie        !< tie
      integer, intent(in) :: face              !< face of the corner, 1 or 2
      real(wp) :: corner_offset(2)

      corner_offset = blocks%vertex(:, tie%corner(face)) - blocks%vertex(:, tie%edge(3 - face)) &
         + merge(-1.0_wp, 1.0_wp, face == 1)*tie%shift
   end function corner_offset

   !> Set the geometry of a corner of one face on the other face.
   pure subroutine set_geometry(blocks, tie, face, spring)
      type(blocks_type), intent(in) :: blocks     !< blocks in their present state
      type(tie_type), intent(in) :: tie           !< tie
      integer, intent(in) :: face                 !< face of the corner, 1 or 2
      type(spring_type), intent(inout) :: spring  !< receives blocks, rows and the gap
      real(wp) :: normal(2), from(2), reference(2)

      associate (v => tie%corner(face), e => tie%edge(3 - face), next => blocks%next)
         spring%block = blocks%owner([v, e])
         normal = [blocks%along(2, e), -blocks%along(1, e)]
         from = corner_offset(blocks, tie, face)
         spring%stretch(1) = dot_product(normal, from)
         associate (i => spring%block(1), j => spring%block(2))
            call set_gradient(blocks%axes(:, :, i), blocks%vertex(:, v) &
               - blocks%position(1:2, i), blocks%reference(:, v), normal, spring%row(:, :, 1))
            reference = blocks%reference(:, e) + (blocks%reference(:, next(e)) &
               - blocks%reference(:, e))*(dot_product(from, blocks%along(:, e))/blocks%length(e))
            call set_gradient(blocks%axes(:, :, j), from + (blocks%vertex(:, e) &
               - blocks%position(1:2, j)), reference, normal, spring%row(:, :, 2))
         end associate
      end associate
   end subroutine set_geometry

   !> Add the forces of the ties on the blocks of one face, at t₀ + θΔt of a step with known d.
   subroutine add_face_force(self, face, blocks, step, d, load)
      class(ties_type), intent(in) :: self     !< elements of this kind
      integer, intent(in) :: face              !< face of each tie, 1 or 2
      type(blocks_type), intent(in) :: blocks  !< blocks at the start of the step
      type(step_type), intent(in) :: step      !< the present step
      real(wp), intent(in) :: d(:,:)           !< [6,blocks] increments of the coordinates
      real(wp), intent(inout) :: load(:,:)     !< [6,blocks] forces, N/m …
      type(spring_type) :: spring
      real(wp) :: force(2)
      integer :: i, side, b

      do i = 1, self%n
         call self%get_spring(i, blocks, spring)
         if (spring%block(1) == 0) cycle
         force = -spring%stiffness*(spring%stretch + step%scheme%theta*extension_change(spring, d))
         side = merge(1, 2, corner_face(blocks, self%tie(i)) == face)
         b = spring%block(side)
         load(:, b) = load(:, b) + merge(1.0_wp, -1.0_wp, side == 1) &
            *matmul(spring%row(:, :, side), force)
      end do
   end subroutine add_face_force

   !> Accept the step: update the slips.
   subroutine accept_step(self, blocks, step, d)
      class(ties_type), intent(inout) :: self      !< elements of this kind
      type(blocks_type), intent(in) :: blocks      !< blocks at the start of the step
      type(step_type), intent(in) :: step          !< the present step
      real(wp), intent(in) :: d(:,:)               !< [6,blocks] increments of the coordinates
      type(spring_type) :: spring
      real(wp) :: change(2)
      integer :: i

      do i = 1, self%n
         call self%get_spring(i, blocks, spring)
         if (spring%block(1) == 0) cycle
         change = extension_change(spring, d)
         self%slip(i) = self%slip(i) + change(2)
      end do
   end subroutine accept_step

   !> Inherit the slips of the former ties.
   subroutine inherit_state(self, former, blocks)
      class(ties_type), intent(inout) :: self    !< elements of this kind
      class(element_type), intent(in) :: former  !< former element, of the same type
      type(blocks_type), intent(in) :: blocks    !< blocks in their present state

      select type (former)
      class is (ties_type)
         self%slip = former%slip
      end select
   end subroutine inherit_state

   !> Save or restore the slips.
   subroutine serialise(self, archive)
      class(ties_type), intent(inout) :: self        !< elements of this kind
      type(archive_type), intent(inout) :: archive   !< archive that is written or read

      call archive_values(archive, self%slip)
   end subroutine serialise

end module dda_ties
