! SPDX-License-Identifier: GPL-3.0-or-later
!> Blocks supported along gravity by springs to the ground ("grounded"), and blocks that grounded
!> blocks support.  All springs that act in any static stage are included.
module dda_held_blocks
   use dda_kinds, only: wp
   use dda_elements, only: elements_type, set_elements, freeze_elements, linear_terms_of
   use dda_linear_terms, only: linear_terms_type, at_theta, at_end, blocks_in, block_of
   use dda_model, only: model_type, contact_distance
   use dda_neighbours, only: neighbours_type, find_near_pairs
   use dda_partition, only: join, name_parts
   use dda_overburden, only: overburden_type
   use dda_scheme, only: step_type, scheme_type
   implicit none
   private
   public :: find_grounded, find_supported

   real(wp), parameter :: least_share = 1.0e-6_wp  !< least part of a spring along gravity

contains

   !> Find the blocks supported along gravity by springs to the ground, and the springs of elements.
   subroutine find_grounded(model, held, terms)
      type(model_type), intent(in) :: model  !< model as read from the input
      logical, allocatable, intent(out) :: held(:)  !< [blocks] supported by springs to the ground
      type(linear_terms_type), intent(out) :: terms !< springs of elements in static stages
      type(model_type) :: staged
      type(elements_type) :: elements
      real(wp) :: down(2)
      integer :: i

      staged = model
      do i = 1, size(staged%fixed_points)
         associate (point => staged%fixed_points(i))
            point%held = point%held .or. point%waiting
         end associate
      end do
      call set_elements(elements, staged, model%blocks, 0.0_wp)
      call freeze_elements(elements, model%blocks, 0.0_wp)
      call linear_terms_of(elements, model%blocks, step_type(scheme_type(1.0_wp, 1.0_wp), 0.0_wp, &
         1.0_wp), terms)
      down = model%control%gravity/norm2(model%control%gravity)
      allocate (held(model%blocks%n), source=.false.)
      do i = 1, terms%n
         associate (term => terms%term(i))
            if (term%block_b > 0 .or. all(term%instant /= [at_theta, at_end])) cycle
            if (abs(dot_product(term%row_a(1:2), down)) > least_share) held(term%block_a) = .true.
         end associate
      end do
   end subroutine find_grounded

   !> Find blocks supported directly or by other blocks: blocks that touch a supported block, are
   !> joined to it by springs, or would fall on it.
   subroutine find_supported(model, held, terms, overburden, supported)
      type(model_type), intent(in) :: model  !< model as read from the input
      logical, intent(in) :: held(:)         !< [blocks] supported by springs to the ground
      type(linear_terms_type), intent(in) :: terms        !< springs of elements
      type(overburden_type), intent(in) :: overburden     !< overburden with pairs of blocks
      logical, allocatable, intent(out) :: supported(:) !< [blocks] all if pairs are too many
      type(neighbours_type) :: near
      integer :: part(model%blocks%n), i, k
      logical :: changed

      part = [(i, i=1, model%blocks%n)]
      supported = held
      call find_near_pairs(near, model%blocks, contact_distance(model))
      if (near%crowded) supported = .true.
      if (near%crowded) return
      do i = 1, near%n_pairs
         call join(part, near%pair(1, i), near%pair(2, i))
      end do
      do i = 1, terms%n
         do k = 2, blocks_in(terms%term(i))
            call join(part, terms%term(i)%block_a, block_of(terms%term(i), k))
         end do
      end do
      call name_parts(part)
      do i = 1, size(part)
         if (held(i)) supported(part(i)) = .true.
      end do
      changed = .true.
      do while (changed)
         changed = .false.
         do i = overburden%pairs, 1, -1
            associate (above => part(overburden%pair(1, i)), below => part(overburden%pair(2, i)))
               if (supported(above) .or. .not. supported(below)) cycle
               supported(above) = .true.
               changed = .true.
            end associate
         end do
      end do
      supported = supported(part)
   end subroutine find_supported

end module dda_held_blocks
