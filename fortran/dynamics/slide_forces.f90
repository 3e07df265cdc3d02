! SPDX-License-Identifier: GPL-3.0-or-later
!> Slide forces that follow the normal forces of the same solution, while the states of the contacts
!> are held.
!>
!> A fixed point that costs no new matrix; Anderson's method solves it like a linear system, also
!> where friction is so high that plain repetition would run away.
module dda_slide_forces
   use dda_kinds, only: wp
   use dda_anderson, only: anderson_type, forget, accelerate
   use dda_system, only: system_type
   use dda_contact, only: contacts_type, contact_slide
   use dda_contact_assembly, only: add_to_rows
   use dda_contact_gradients, only: relative_motion
   use dda_friction, only: acting_gap, laws_type, multiplier_of
   use dda_growth, only: grow
   use dda_joint_contact, only: slide_response
   use dda_ordered_sums, only: pieces, first_of, last_of, share_of_thread, parallel_from
   implicit none
   private
   public :: slides_type, list_slides, evaluate_slides, difference_of, farthest_off, assume_next

   !> The sliding contacts, and the fixed point of their forces.
   type :: slides_type
      integer :: n = 0
      integer, allocatable :: contact(:)   !< [n] which contacts slide
      !> assumed shear forces, N/m; where contacts dilate, then `normal_free` of each
      real(wp), allocatable :: force(:)
      real(wp), allocatable :: response(:) !< those that the law gives, N/m
      real(wp), allocatable :: rhs_change(:,:)  !< [6,blocks] of f̂ by the last change of forces, N
      logical :: dilating = .false.        !< joints of the model may dilate
      type(anderson_type) :: memory
   end type slides_type

contains

   !> Begin with the contacts that are assumed to slide.
   subroutine list_slides(slides, contacts, dilating)
      type(slides_type), intent(inout) :: slides  !< sliding contacts
      type(contacts_type), intent(in) :: contacts  !< this step's list
      logical, intent(in) :: dilating  !< joints of the model may dilate
      integer :: c

      slides%dilating = dilating
      call make_room(slides, merge(2, 1, dilating)*contacts%n)
      call forget(slides%memory)
      slides%n = 0
      do c = 1, contacts%n
         if (contacts%state(c) /= contact_slide) cycle
         if (.not. weight_of(contacts, c) > 0.0_wp) cycle
         slides%n = slides%n + 1
         slides%contact(slides%n) = c
         slides%force(slides%n) = contacts%slide_force(c)
      end do
      if (dilating) slides%force(slides%n + 1:2*slides%n) = &
         contacts%normal_free(slides%contact(:slides%n))
   end subroutine list_slides

   !> Share of the friction of contact c that acts: a bond may have the rest.
   pure real(wp) function weight_of(contacts, c) result(weight)
      type(contacts_type), intent(in) :: contacts  !< this step's list
      integer, intent(in) :: c  !< number of the contact

      weight = 1.0_wp
      if (contacts%with_net_slip) weight = contacts%acting_damage(c)
   end function weight_of

   subroutine make_room(slides, wanted)
      type(slides_type), intent(inout) :: slides  !< sliding contacts
      integer, intent(in) :: wanted  !< how many

      if (allocated(slides%contact)) then
         if (size(slides%contact) >= wanted) return
         deallocate (slides%contact, slides%force, slides%response)
      end if
      allocate (slides%contact(2*wanted), slides%force(2*wanted), slides%response(2*wanted))
   end subroutine make_room

   !> The slide forces that the normal forces at d call for, in the assumed directions.
   subroutine evaluate_slides(slides, contacts, laws, d)
      type(slides_type), intent(inout) :: slides  !< sliding contacts
      type(contacts_type), intent(in) :: contacts  !< this step's list
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      real(wp), intent(in), contiguous :: d(:,:)  !< [6,blocks] increments of the coordinates
      integer :: p

      if (slides%n < parallel_from) then
         call evaluate_range(slides, contacts, laws, d, 1, slides%n)
         return
      end if
      !$omp parallel do schedule(static)
      do p = 1, pieces(slides%n)
         call evaluate_range(slides, contacts, laws, d, first_of(p, slides%n), &
            last_of(p, slides%n))
      end do
   end subroutine evaluate_slides

   !> Sliding contacts first … last.
   pure subroutine evaluate_range(slides, contacts, laws, d, first, last)
      type(slides_type), intent(inout) :: slides  !< sliding contacts
      type(contacts_type), intent(in) :: contacts  !< this step's list
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      real(wp), intent(in), contiguous :: d(:,:)  !< [6,blocks] increments of the coordinates
      integer, intent(in) :: first, last  !< of the range
      real(wp) :: change(2), gap, lifted
      integer :: i, c

      do i = first, last
         c = slides%contact(i)
         change = relative_motion(contacts, c, d(:, contacts%block_v(c)), d(:, contacts%block_e(c)))
         gap = contacts%gap(c) + change(1)
         if (.not. laws%plain) then
            call slide_response(contacts, laws%slot(contacts%joint(c))%law, c, gap, &
               contacts%stretch(c) + change(2), slides%response(i), lifted)
            if (slides%dilating) slides%response(slides%n + i) = lifted
            cycle
         end if
         if (allocated(contacts%held_bound)) then
            slides%response(i) = contacts%slip_sign(c)*contacts%held_bound(c)
            cycle
         end if
         if (laws%damped) gap = acting_gap(contacts, laws, c, gap)
         slides%response(i) = contacts%slip_sign(c)*laws%friction(contacts%joint(c)) &
            *max(0.0_wp, multiplier_of(contacts, c) - laws%normal_stiffness*gap)
      end do
   end subroutine evaluate_range

   !> Numbers that the iteration has to find.
   pure integer function unknowns(slides)
      type(slides_type), intent(in) :: slides  !< sliding contacts

      unknowns = merge(2, 1, slides%dilating)*slides%n
   end function unknowns

   !> Largest difference between assumed and answered, N/m.
   pure real(wp) function difference_of(slides)
      type(slides_type), intent(in) :: slides  !< sliding contacts

      associate (n => unknowns(slides))
         difference_of = maxval(abs(slides%response(:n) - slides%force(:n)))
      end associate
   end function difference_of

   !> The contact with that difference.
   pure integer function farthest_off(slides)
      type(slides_type), intent(in) :: slides  !< sliding contacts

      farthest_off = &
         slides%contact(maxloc(abs(slides%response(:slides%n) - slides%force(:slides%n)), 1))
   end function farthest_off

   !> Assume the next forces, in the contacts and in the right-hand side.
   subroutine assume_next(slides, contacts, system)
      type(slides_type), intent(inout) :: slides  !< sliding contacts
      type(contacts_type), intent(inout) :: contacts  !< this step's list
      type(system_type), intent(inout) :: system  !< equations of the step
      integer :: i, c, first, last, n

      n = size(system%rhs, 2)
      call grow(slides%rhs_change, 6, n)
      associate (m => unknowns(slides))
         call accelerate(slides%memory, slides%force(:m), slides%response(:m))
      end associate
      if (slides%n < parallel_from) then
         call assume_rows(slides, contacts, system, 1, n)
      else
         !$omp parallel private(first, last)
         call share_of_thread(n, first, last)
         call assume_rows(slides, contacts, system, first, last)
         !$omp end parallel
      end if
      do i = 1, slides%n
         c = slides%contact(i)
         contacts%free_force(2, c) = contacts%free_force(2, c) &
            + weight_of(contacts, c)*(slides%force(i) - contacts%slide_force(c))
         contacts%slide_force(c) = slides%force(i)
         if (.not. slides%dilating) cycle
         contacts%free_force(1, c) = contacts%free_force(1, c) &
            + (slides%force(slides%n + i) - contacts%normal_free(c))
         contacts%normal_free(c) = slides%force(slides%n + i)
      end do
   end subroutine assume_next

   !> The next forces in block rows first … last of the right-hand side.
   subroutine assume_rows(slides, contacts, system, first, last)
      type(slides_type), intent(inout) :: slides  !< sliding contacts, with the next forces
      type(contacts_type), intent(in) :: contacts  !< this step's list, with the present ones
      type(system_type), intent(inout) :: system  !< equations of the step
      integer, intent(in) :: first, last  !< of the range
      real(wp) :: more(2)
      integer :: i, c

      slides%rhs_change(:, first:last) = system%rhs(:, first:last)
      do i = 1, slides%n
         c = slides%contact(i)
         more = [0.0_wp, weight_of(contacts, c)*(slides%force(i) - contacts%slide_force(c))]
         if (slides%dilating) more(1) = slides%force(slides%n + i) - contacts%normal_free(c)
         call add_to_rows(system, contacts, c, more, first, last)
      end do
      slides%rhs_change(:, first:last) = system%rhs(:, first:last) &
         - slides%rhs_change(:, first:last)
   end subroutine assume_rows

end module dda_slide_forces
