! SPDX-License-Identifier: GPL-3.0-or-later
!> Friction forces of sliding contacts ("slide forces") that are consistent with the normal forces
!> of the same solution, at fixed contact states.  They are the fixed point of an iteration with a
!> constant matrix.  With Anderson acceleration the iteration converges even for high friction, at
!> which the plain iteration would diverge.
module dda_slide_forces
   use dda_kinds, only: wp
   use dda_anderson, only: anderson_type, discard_iterations, accelerate
   use dda_system, only: system_type
   use dda_contact, only: contacts_type, contact_slide
   use dda_contact_assembly, only: add_to_rows
   use dda_contact_gradients, only: relative_motion
   use dda_friction, only: laws_type, slide_response
   use dda_growth, only: grow
   use dda_ordered_sums, only: pieces, first_of, last_of, find_thread_range, parallel_from
   implicit none
   private
   public :: slides_type, list_slides, evaluate_slides, slide_difference, least_converged, &
      assume_next_forces

   !> The sliding contacts and the fixed-point iteration of their forces.
   type :: slides_type
      integer :: n = 0                     !< number of sliding contacts
      integer, allocatable :: contact(:)   !< [n] numbers of the contacts
      real(wp), allocatable :: force(:)    !< [n] assumed forces, without dilation, N/m
      real(wp), allocatable :: response(:) !< [n] forces by the law, N/m
      real(wp), allocatable :: rhs_change(:,:)  !< [6,blocks] change of f̂, N
      type(anderson_type) :: memory
   end type slides_type

contains

   !> List the contacts that are assumed to slide.
   subroutine list_slides(slides, contacts)
      type(slides_type), intent(inout) :: slides  !< sliding contacts
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      integer :: c

      call grow(slides%contact, contacts%n)
      call grow(slides%force, contacts%n)
      call grow(slides%response, contacts%n)
      call discard_iterations(slides%memory)
      slides%n = 0
      do c = 1, contacts%n
         if (contacts%state(c) /= contact_slide) cycle
         if (.not. friction_fraction(contacts, c) > 0.0_wp) cycle
         slides%n = slides%n + 1
         slides%contact(slides%n) = c
         slides%force(slides%n) = contacts%slide_force(c)
      end do
   end subroutine list_slides

   !> Return the fraction of contact c in which friction acts; the remaining fraction is bonded.
   pure real(wp) function friction_fraction(contacts, c) result(weight)
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      integer, intent(in) :: c  !< number of the contact

      weight = 1.0_wp
      if (contacts%with_net_slip) weight = contacts%acting_damage(c)
   end function friction_fraction

   !> Evaluate the slide forces for the normal forces at d, in the assumed directions.
   subroutine evaluate_slides(slides, contacts, laws, d)
      type(slides_type), intent(inout) :: slides  !< sliding contacts
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
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

   !> Evaluate sliding contacts first … last.
   pure subroutine evaluate_range(slides, contacts, laws, d, first, last)
      type(slides_type), intent(inout) :: slides  !< sliding contacts
      type(contacts_type), intent(in) :: contacts  !< contacts of this step
      type(laws_type), intent(in) :: laws  !< stiffness and strength of the contacts
      real(wp), intent(in), contiguous :: d(:,:)  !< [6,blocks] increments of the coordinates
      integer, intent(in) :: first, last  !< first and last in the range
      real(wp) :: change(2)
      integer :: i, c

      do i = first, last
         c = slides%contact(i)
         change = relative_motion(contacts, c, d(:, contacts%block_v(c)), d(:, contacts%block_e(c)))
         if (allocated(contacts%fixed_motion)) change = change + contacts%fixed_motion(:, c)
         slides%response(i) = slide_response(contacts, laws, c, contacts%gap(c) + change(1), &
            contacts%stretch(c) + change(2))
      end do
   end subroutine evaluate_range

   !> Return the largest difference between assumed forces and forces by the law, N/m.
   pure real(wp) function slide_difference(slides)
      type(slides_type), intent(in) :: slides  !< sliding contacts

      slide_difference = maxval(abs(slides%response(:slides%n) - slides%force(:slides%n)))
   end function slide_difference

   !> Return the contact with the largest force difference.
   pure integer function least_converged(slides)
      type(slides_type), intent(in) :: slides  !< sliding contacts

      least_converged = &
         slides%contact(maxloc(abs(slides%response(:slides%n) - slides%force(:slides%n)), 1))
   end function least_converged

   !> Compute the next assumed forces; update the contacts and the right-hand side.
   subroutine assume_next_forces(slides, contacts, system)
      type(slides_type), intent(inout) :: slides  !< sliding contacts
      type(contacts_type), intent(inout) :: contacts  !< contacts of this step
      type(system_type), intent(inout) :: system  !< equations of the step
      real(wp) :: increment(2)
      integer :: i, c, first, last, n

      n = size(system%rhs, 2)
      call grow(slides%rhs_change, 6, n)
      call accelerate(slides%memory, slides%force(:slides%n), slides%response(:slides%n))
      if (slides%n < parallel_from) then
         call assume_rows(slides, contacts, system, 1, n)
      else
         !$omp parallel private(first, last)
         call find_thread_range(n, first, last)
         call assume_rows(slides, contacts, system, first, last)
         !$omp end parallel
      end if
      do i = 1, slides%n
         c = slides%contact(i)
         increment = next_increments(slides, contacts, i)
         contacts%free_force(:, c) = contacts%free_force(:, c) + increment
         if (contacts%with_laws) contacts%line(1, c) = contacts%line(1, c) + increment(1)
         contacts%slide_force(c) = slides%force(i)
      end do
   end subroutine assume_next_forces

   !> Return the increments of normal and shear force of sliding contact i to the next forces, N/m.
   !> More friction reduces slip and thus dilation, which changes the normal force.
   pure function next_increments(slides, contacts, i) result(increment)
      type(slides_type), intent(in) :: slides      !< sliding contacts, with the next forces
      type(contacts_type), intent(in) :: contacts  !< contacts of this step, with the present forces
      integer, intent(in) :: i                     !< index in `slides`
      real(wp) :: increment(2)

      associate (c => slides%contact(i))
         increment = [0.0_wp, friction_fraction(contacts, c)*(slides%force(i) &
            - contacts%slide_force(c))]
         if (contacts%with_laws) increment(1) = -contacts%tilt(2, c)*contacts%spring(1, c) &
            /contacts%tangent(2, c)*increment(2)
      end associate
   end function next_increments

   !> Add the increments to block rows first … last of the right-hand side.
   subroutine assume_rows(slides, contacts, system, first, last)
      type(slides_type), intent(inout) :: slides  !< sliding contacts, with the next forces
      type(contacts_type), intent(in) :: contacts  !< contacts of this step, with the present forces
      type(system_type), intent(inout) :: system  !< equations of the step
      integer, intent(in) :: first, last  !< first and last in the range
      integer :: i, c

      slides%rhs_change(:, first:last) = system%rhs(:, first:last)
      do i = 1, slides%n
         c = slides%contact(i)
         call add_to_rows(system, contacts, c, next_increments(slides, contacts, i), first, last)
      end do
      slides%rhs_change(:, first:last) = system%rhs(:, first:last) &
         - slides%rhs_change(:, first:last)
   end subroutine assume_rows

end module dda_slide_forces
