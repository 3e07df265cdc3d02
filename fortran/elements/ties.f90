! SPDX-License-Identifier: GPL-3.0-or-later
!> Ties as springs: what a bonded contact of the same geometry exerts (`dda_contact_geometry`), at
!> t₀ + θΔt, without an end to its strength.
!>
!> Where a corner of each face stands at the end of the overlap, the one whose foot lies on the
!> other face counts, as in the detection of contacts.
module dda_ties
   use dda_kinds, only: wp
   use dda_archive, only: archive_type, archive_values => serialise
   use dda_blocks, only: blocks_type
   use dda_contact_geometry, only: set_gradients
   use dda_element, only: element_type
   use dda_energy, only: energy_type, add_energy, energy_support, energy_algorithmic
   use dda_linear_terms, only: linear_terms_type, linear_term_type, add_term, term_tie, at_theta
   use dda_motion, only: motion_type
   use dda_scheme, only: step_type
   use dda_tie, only: tie_type
   implicit none
   private
   public :: ties_type, new_ties

   real(wp), parameter :: corner_share = 0.05_wp  !< as in `dda_detection`
   real(wp), parameter :: equal = 1.0e-9_wp       !< of a corner's size: no difference

   !> The springs of a tie in the present geometry.
   type :: spring_type
      integer :: block(2) = 0          !< of the vertex, of the edge
      integer :: face = 0              !< of the tie that the vertex belongs to
      real(wp) :: stretch(2) = 0.0_wp  !< gap and slip so far, m
      real(wp) :: row(6, 2, 2) = 0.0_wp !< [6, normal or shear, vertex or edge] of their changes
   end type spring_type

   !> All ties of a model.
   type, extends(element_type) :: ties_type
      type(tie_type), allocatable :: tie(:)
      real(wp) :: stiffness(2) = 0.0_wp       !< k_n and k_s, N/m per metre of thickness
      real(wp), allocatable :: slip(:)        !< [ties] stretch of the shear springs, m
   contains
      procedure :: add_linear
      procedure :: add_force
      procedure :: add_stored
      procedure :: account
      procedure :: accept
      procedure :: inherit
      procedure :: serialise
      procedure :: add_face_force
   end type ties_type

contains

   !> Ties without forces.
   pure type(ties_type) function new_ties(ties, stiffness) result(self)
      type(tie_type), intent(in) :: ties(:)     !< [ties]
      real(wp), intent(in) :: stiffness(2)      !< k_n and k_s, N/m per metre of thickness

      self%tie = ties
      self%stiffness = stiffness
      allocate (self%slip(size(ties)), source=0.0_wp)
   end function new_ties

   !> Springs of tie i, with the stretch of the shear spring.
   pure type(spring_type) function spring_of(self, i, blocks) result(spring)
      class(ties_type), intent(in) :: self     !< elements of this kind
      integer, intent(in) :: i                 !< number, from 1
      type(blocks_type), intent(in) :: blocks  !< in their present state
      real(wp) :: beyond(2), least
      integer :: first, face

      associate (tie => self%tie(i))
         first = merge(1, 2, tie%edge(1) < tie%edge(2))
         beyond = huge(1.0_wp)
         do face = 1, 2
            if (tie%corner(face) > 0) beyond(face) = overshoot(blocks, tie, face)
         end do
         least = equal*corner_share*minval(blocks%length(tie%edge))
         face = first
         if (beyond(first) > least .and. beyond(3 - first) < beyond(first) - least) face = 3 - first
         spring = vertex_on_edge(blocks, tie, face)
         spring%face = face
         spring%stretch(2) = self%slip(i)
      end associate
   end function spring_of

   !> How far the foot of a corner lies beyond the other face, m.
   pure real(wp) function overshoot(blocks, tie, face)
      type(blocks_type), intent(in) :: blocks  !< in their present state
      type(tie_type), intent(in) :: tie        !< of the list
      integer, intent(in) :: face              !< of the corner, 1 or 2
      real(wp) :: foot

      associate (e => tie%edge(3 - face))
         foot = dot_product(blocks%along(:, e), apart(blocks, tie, face))
         overshoot = max(-foot, foot - blocks%length(e))
      end associate
   end function overshoot

   !> From the first vertex of the other face to the corner of a face, m.
   pure function apart(blocks, tie, face)
      type(blocks_type), intent(in) :: blocks  !< in their present state
      type(tie_type), intent(in) :: tie        !< of the list
      integer, intent(in) :: face              !< of the corner, 1 or 2
      real(wp) :: apart(2)

      apart = blocks%vertex(:, tie%corner(face)) - blocks%vertex(:, tie%edge(3 - face)) &
         + merge(-1.0_wp, 1.0_wp, face == 1)*tie%shift
   end function apart

   !> The contact of a corner of one face with the other face.
   pure type(spring_type) function vertex_on_edge(blocks, tie, face) result(spring)
      type(blocks_type), intent(in) :: blocks  !< in their present state
      type(tie_type), intent(in) :: tie        !< of the list
      integer, intent(in) :: face              !< of the corner, 1 or 2
      real(wp) :: normal(2), from(2), offset(2), reference(2), gap

      associate (v => tie%corner(face), e => tie%edge(3 - face), next => blocks%next)
         spring%block = blocks%owner([v, e])
         normal = [blocks%along(2, e), -blocks%along(1, e)]
         from = apart(blocks, tie, face)
         gap = dot_product(normal, from)
         spring%stretch(1) = gap
         associate (i => spring%block(1), j => spring%block(2))
            offset = blocks%vertex(:, v) - blocks%position(1:2, i)
            call set_gradients(blocks%axes(:, :, i), offset, offset, blocks%reference(:, v), &
               normal, spring%row(:, 1, 1), spring%row(:, 2, 1))
            offset = from + (blocks%vertex(:, e) - blocks%position(1:2, j))
            reference = blocks%reference(:, e) + (blocks%reference(:, next(e)) &
               - blocks%reference(:, e))*(dot_product(from, blocks%along(:, e))/blocks%length(e))
            call set_gradients(blocks%axes(:, :, j), offset - gap*normal, offset, reference, &
               normal, spring%row(:, 1, 2), spring%row(:, 2, 2))
         end associate
      end associate
   end function vertex_on_edge

   !> Both blocks of tie i are there.
   pure logical function acts(self, i, blocks)
      class(ties_type), intent(in) :: self     !< elements of this kind
      integer, intent(in) :: i                 !< number, from 1
      type(blocks_type), intent(in) :: blocks  !< in their present state

      acts = .not. any(blocks%removed(blocks%owner(self%tie(i)%edge)))
   end function acts

   !> Change of a spring's stretch in an increment, m.
   pure function change_of(spring, d) result(change)
      type(spring_type), intent(in) :: spring  !< of a tie
      real(wp), intent(in) :: d(:,:)           !< [6,blocks] increments of the coordinates
      real(wp) :: change(2)

      change = matmul(d(:, spring%block(1)), spring%row(:, :, 1)) &
         - matmul(d(:, spring%block(2)), spring%row(:, :, 2))
   end function change_of

   !> Two springs for each tie.  A block tied to itself has both rows in one.
   subroutine add_linear(self, blocks, step, terms)
      class(ties_type), intent(in) :: self             !< elements of this kind
      type(blocks_type), intent(in) :: blocks          !< in their present state
      type(step_type), intent(in) :: step              !< the one being taken
      type(linear_terms_type), intent(inout) :: terms  !< springs and dashpots
      type(linear_term_type) :: term
      type(spring_type) :: spring
      integer :: i, kind

      term%kind = term_tie
      term%instant = at_theta
      term%of_penalty = .true.
      do i = 1, size(self%tie)
         if (.not. acts(self, i, blocks)) cycle
         spring = spring_of(self, i, blocks)
         term%source = i
         term%block_a = spring%block(1)
         term%block_b = merge(0, spring%block(2), spring%block(1) == spring%block(2))
         term%place = blocks%vertex(:, self%tie(i)%edge(1))
         do kind = 1, 2
            term%coefficient = self%stiffness(kind)
            term%row_a = spring%row(:, kind, 1)
            term%row_b = spring%row(:, kind, 2)
            if (term%block_b == 0) term%row_a = term%row_a - term%row_b
            call add_term(terms, term)
         end do
      end do
   end subroutine add_linear

   !> −k s of each spring.
   subroutine add_force(self, blocks, motions, step, load)
      class(ties_type), intent(in) :: self         !< elements of this kind
      type(blocks_type), intent(in) :: blocks      !< in their present state
      type(motion_type), intent(in) :: motions(:)  !< prescribed ones
      type(step_type), intent(in) :: step          !< the one being taken
      real(wp), intent(inout) :: load(:,:)         !< [6,blocks] N/m …
      type(spring_type) :: spring
      real(wp) :: force(2)
      integer :: i

      do i = 1, size(self%tie)
         if (.not. acts(self, i, blocks)) cycle
         spring = spring_of(self, i, blocks)
         force = -self%stiffness*spring%stretch
         associate (a => spring%block(1), b => spring%block(2))
            load(:, a) = load(:, a) + matmul(spring%row(:, :, 1), force)
            load(:, b) = load(:, b) - matmul(spring%row(:, :, 2), force)
         end associate
      end do
   end subroutine add_force

   !> Add what the ties exert on the blocks of one face, at t₀ + θΔt of a step whose increment d is
   !> known.
   subroutine add_face_force(self, face, blocks, step, d, load)
      class(ties_type), intent(in) :: self     !< elements of this kind
      integer, intent(in) :: face              !< of each tie, 1 or 2
      type(blocks_type), intent(in) :: blocks  !< at the start of the step
      type(step_type), intent(in) :: step      !< the one being taken
      real(wp), intent(in) :: d(:,:)           !< [6,blocks] increments of the coordinates
      real(wp), intent(inout) :: load(:,:)     !< [6,blocks] N/m …
      type(spring_type) :: spring
      real(wp) :: force(2)
      integer :: i, side

      do i = 1, size(self%tie)
         spring = spring_of(self, i, blocks)
         force = -self%stiffness*(spring%stretch + step%scheme%theta*change_of(spring, d))
         side = merge(1, 2, spring%face == face)
         associate (b => spring%block(side))
            load(:, b) = load(:, b) + merge(1.0_wp, -1.0_wp, side == 1) &
               *matmul(spring%row(:, :, side), force)
         end associate
      end do
   end subroutine add_face_force

   !> ½ k s² of each spring.
   subroutine add_stored(self, blocks, motions, step, energy)
      class(ties_type), intent(in) :: self         !< elements of this kind
      type(blocks_type), intent(in) :: blocks      !< in their present state
      type(motion_type), intent(in) :: motions(:)  !< prescribed ones
      type(step_type), intent(in) :: step          !< the one to come
      type(energy_type), intent(inout) :: energy   !< J per metre of thickness
      type(spring_type) :: spring
      integer :: i

      do i = 1, size(self%tie)
         if (.not. acts(self, i, blocks)) cycle
         spring = spring_of(self, i, blocks)
         call add_energy(energy, energy_support, 0.5_wp*sum(self%stiffness*spring%stretch**2))
      end do
   end subroutine add_stored

   !> Energy at the end of the step, and the loss (θ − ½) k Δs² of the scheme.
   subroutine account(self, blocks, motions, step, d, energy)
      class(ties_type), intent(in) :: self         !< elements of this kind
      type(blocks_type), intent(in) :: blocks      !< in their present state
      type(motion_type), intent(in) :: motions(:)  !< prescribed ones
      type(step_type), intent(in) :: step          !< the one being taken
      real(wp), intent(in) :: d(:,:)               !< [6,blocks] increments of the coordinates
      type(energy_type), intent(inout) :: energy   !< J per metre of thickness
      type(spring_type) :: spring
      real(wp) :: change(2)
      integer :: i

      do i = 1, size(self%tie)
         if (.not. acts(self, i, blocks)) cycle
         spring = spring_of(self, i, blocks)
         change = change_of(spring, d)
         call add_energy(energy, energy_support, &
            0.5_wp*sum(self%stiffness*(spring%stretch + change)**2))
         call add_energy(energy, energy_algorithmic, &
            (step%scheme%theta - 0.5_wp)*sum(self%stiffness*change**2))
      end do
   end subroutine account

   !> Slips at the end of the step.
   subroutine accept(self, blocks, motions, step, d)
      class(ties_type), intent(inout) :: self      !< elements of this kind
      type(blocks_type), intent(in) :: blocks      !< at the start of the step
      type(motion_type), intent(in) :: motions(:)  !< prescribed ones
      type(step_type), intent(in) :: step          !< the one being taken
      real(wp), intent(in) :: d(:,:)               !< [6,blocks] increments of the coordinates
      real(wp) :: change(2)
      integer :: i

      do i = 1, size(self%tie)
         if (.not. acts(self, i, blocks)) cycle
         change = change_of(spring_of(self, i, blocks), d)
         self%slip(i) = self%slip(i) + change(2)
      end do
   end subroutine accept

   !> Slips stay.
   subroutine inherit(self, before, blocks)
      class(ties_type), intent(inout) :: self    !< elements of this kind
      class(element_type), intent(in) :: before  !< those of the same type
      type(blocks_type), intent(in) :: blocks    !< in their present state

      select type (before)
      class is (ties_type)
         self%slip = before%slip
      end select
   end subroutine inherit

   !> The slips.
   subroutine serialise(self, archive)
      class(ties_type), intent(inout) :: self        !< elements of this kind
      type(archive_type), intent(inout) :: archive   !< written or read

      call archive_values(archive, self%slip)
   end subroutine serialise

end module dda_ties
