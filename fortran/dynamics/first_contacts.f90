! SPDX-License-Identifier: GPL-3.0-or-later
!> Slip and opening of the initially touching contacts, measured between the vertex and its initial
!> foot on the edge.  The foot divides the edge in a constant ratio, because block strains are
!> uniform.
!>
!> Contacts are scanned only if block displacements since the last scan can cause a value above both
!> the largest value so far and 1e-7 of the model size, because displacements of blocks bound the
!> movements of contacts.
module dda_first_contacts
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type
   use dda_contact, only: contacts_type, is_point
   use dda_maxima, only: largest_type, update_largest, of_slip, of_opening
   use dda_ordered_sums, only: pieces, first_of, last_of, most_pieces, parallel_from
   implicit none
   private
   public :: first_contacts_type, begin_first_contacts, reserve_first_contacts, add_movement, &
      may_exceed, drop_removed, count_moved, foot_movement

   !> bound on contact movement/block displacement: 2 for two blocks, plus less than 1 for finite
   !> rotations and feet beyond the ends of an edge
   real(wp), parameter :: both_sides = 3.0_wp

   !> The initially touching contacts, and the result of the last scan.
   type :: first_contacts_type
      ! unsaved, found before it is used: pressed
      integer, allocatable :: vertex(:), edge(:)  !< [contacts] vertex and edge
      real(wp), allocatable :: foot_fraction(:)   !< [contacts] position of the foot as a fraction
      real(wp), allocatable :: gap(:)             !< [contacts] initial distance, m; 0 for overlaps
      integer, allocatable :: pressed(:)  !< [vertices] edge that each vertex is pressed on; 0: none
      real(wp) :: shortest = 0.0_wp               !< length of the shortest edge, m
      real(wp) :: last_scan(3) = 0.0_wp  !< result of the last scan, m (see `scan_movements`)
      real(wp) :: path = 0.0_wp                   !< displacement of the blocks at the last scan, m
   end type first_contacts_type

contains

   !> Allocate the variables of n contacts.
   subroutine reserve_first_contacts(first, n, vertices)
      type(first_contacts_type), intent(out) :: first  !< allocated, without contacts
      integer, intent(in) :: n, vertices               !< number of contacts; number of vertices

      allocate (first%vertex(n), first%edge(n), source=0)
      allocate (first%foot_fraction(n), first%gap(n), source=0.0_wp)
      allocate (first%pressed(vertices), source=0)
   end subroutine reserve_first_contacts

   !> Store the contacts that touch at present.
   subroutine begin_first_contacts(first, contacts, blocks, touching)
      type(first_contacts_type), intent(out) :: first  !< initially touching contacts
      type(contacts_type), intent(in) :: contacts      !< contacts of the present state
      type(blocks_type), intent(in) :: blocks          !< blocks in their present state
      real(wp), intent(in) :: touching                 !< distance below which contacts touch, m
      real(wp) :: offset(2)
      logical :: touch(contacts%n)
      integer :: c

      do c = 1, contacts%n
         touch(c) = contacts%new_gap(c) + contacts%offset(c) <= touching .and. &
            .not. is_point(contacts, c)
      end do
      call reserve_first_contacts(first, count(touch), size(blocks%owner))
      first%vertex = pack(contacts%vertex(:contacts%n), touch)
      first%edge = pack(contacts%edge(:contacts%n), touch)
      first%shortest = minval(blocks%length)
      do c = 1, size(first%vertex)
         associate (v => first%vertex(c), e => first%edge(c))
            offset = blocks%vertex(:, v) - blocks%vertex(:, e)
            first%foot_fraction(c) = dot_product(offset, blocks%along(:, e))/blocks%length(e)
            first%gap(c) = max(0.0_wp, blocks%along(2, e)*offset(1) - blocks%along(1, e)*offset(2))
         end associate
      end do
   end subroutine begin_first_contacts

   !> Remove contacts of blocks that are no longer part of the model.
   pure subroutine drop_removed(first, blocks)
      type(first_contacts_type), intent(inout) :: first  !< initially touching contacts
      type(blocks_type), intent(in) :: blocks            !< blocks in their present state
      logical :: retained(size(first%vertex))

      retained = .not. (blocks%removed(blocks%owner(first%vertex)) .or. &
         blocks%removed(blocks%owner(first%edge)))
      if (all(retained)) return
      first%foot_fraction = pack(first%foot_fraction, retained)
      first%gap = pack(first%gap, retained)
      first%vertex = pack(first%vertex, retained)
      first%edge = pack(first%edge, retained)
   end subroutine drop_removed

   !> .true. if a scan of the contacts could find a new maximum that must be recorded.
   pure logical function may_exceed(first, largest, path, smallest)  ! total
      type(first_contacts_type), intent(in) :: first   !< initially touching contacts
      type(largest_type), intent(in) :: largest(:)     !< [maxima] largest values so far
      real(wp), intent(in) :: path  !< sum of the largest displacements of all steps, m
      real(wp), intent(in) :: smallest                    !< smallest movement that is recorded, m
      real(wp) :: distance

      may_exceed = .false.
      if (size(first%vertex) == 0) return
      distance = both_sides*(path - first%path)
      distance = distance*(1.0_wp + (first%last_scan(3) + distance)/first%shortest)  ! edges rotate
      may_exceed = any(first%last_scan(:2) + distance > max(smallest, &
         largest([of_slip, of_opening])%value))
   end function may_exceed

   !> Update the largest movements by a scan of all contacts.
   subroutine add_movement(first, largest, contacts, blocks, time, path)
      type(first_contacts_type), intent(inout) :: first  !< initially touching contacts
      type(largest_type), intent(inout) :: largest(:)    !< [maxima] largest values so far
      type(contacts_type), intent(in) :: contacts        !< contacts of the last step
      type(blocks_type), intent(in) :: blocks            !< blocks in their present state
      real(wp), intent(in) :: time                       !< s
      !> sum of the largest displacements of all steps, m; if absent, the scan is not stored
      real(wp), intent(in), optional :: path
      real(wp) :: peak(3, most_pieces), maxima(3)
      logical :: with_pressed
      integer :: p, n

      with_pressed = .false.
      associate (m => size(first%vertex))
         n = 1
         if (m >= parallel_from) n = pieces(m)
         if (n == 1) then
            call scan_movements(first, blocks, 1, m, peak(:, 1))
         else
            !$omp parallel do schedule(static)
            do p = 1, n
               call scan_movements(first, blocks, first_of(p, m), last_of(p, m), peak(:, p))
            end do
         end if
         do p = 1, n
            if (peak(1, p) <= largest(of_slip)%value .and. &
               peak(2, p) <= largest(of_opening)%value) cycle
            if (.not. with_pressed) call find_pressed(first, contacts)
            with_pressed = .true.
            call update_movements(first, largest, blocks, time, merge(1, first_of(p, m), n == 1), &
               merge(m, last_of(p, m), n == 1))
         end do
      end associate
      maxima = maxval(peak(:, :n), 2)
      if (.not. present(path)) return
      first%path = path
      first%last_scan = maxima
   end subroutine add_movement

   !> Find the largest slip, the largest opening and a bound on their sum, for contacts begin … end.
   pure subroutine scan_movements(first, blocks, begin, end, peak)
      type(first_contacts_type), intent(in) :: first  !< initially touching contacts
      type(blocks_type), intent(in) :: blocks         !< blocks in their present state
      integer, intent(in) :: begin, end               !< first and last contact
      real(wp), intent(out) :: peak(3)                !< m
      real(wp) :: slip, growth, smallest, x, y
      integer :: c, v, e

      slip = 0.0_wp
      growth = -huge(1.0_wp)
      smallest = huge(1.0_wp)
      !$omp simd reduction(max:slip, growth) reduction(min:smallest) &
      !$omp private(v, e, x, y)
      do c = begin, end
         v = first%vertex(c)
         e = first%edge(c)
         x = blocks%vertex(1, v) - blocks%vertex(1, e)
         y = blocks%vertex(2, v) - blocks%vertex(2, e)
         slip = max(slip, abs(x*blocks%along(1, e) + y*blocks%along(2, e) &
            - first%foot_fraction(c)*blocks%length(e)))
         x = x*blocks%along(2, e) - y*blocks%along(1, e) - first%gap(c)
         growth = max(growth, x)
         smallest = min(smallest, x)
      end do
      peak = [slip, growth, slip + max(growth, -smallest)]
   end subroutine scan_movements

   !> Update the largest slip and opening with the values of contacts begin … end.
   subroutine update_movements(first, largest, blocks, time, begin, end)
      type(first_contacts_type), intent(in) :: first   !< contacts after `find_pressed`
      type(largest_type), intent(inout) :: largest(:)  !< [maxima] largest values so far
      type(blocks_type), intent(in) :: blocks          !< blocks in their present state
      real(wp), intent(in) :: time                     !< s
      integer, intent(in) :: begin, end                !< first and last contact
      real(wp) :: movement(2)
      integer :: c, owners(2)

      do c = begin, end
         movement = contact_movement(first, blocks, c)
         owners = blocks%owner([first%vertex(c), first%edge(c)])
         call update_largest(largest(of_slip), abs(movement(1)), time, owners)
         call update_largest(largest(of_opening), max(0.0_wp, movement(2)), time, owners)
      end do
   end subroutine update_movements

   !> Return the slip and opening of contact c; in compression, the opening is due to dilation only.
   pure function contact_movement(first, blocks, c) result(movement)
      type(first_contacts_type), intent(in) :: first  !< contacts after `find_pressed`
      type(blocks_type), intent(in) :: blocks         !< blocks in their present state
      integer, intent(in) :: c                        !< number of the contact
      real(wp) :: movement(2)

      movement = foot_movement(first, blocks, c)
      if (first%pressed(first%vertex(c)) == first%edge(c)) movement(2) = min(movement(2), 0.0_wp)
   end function contact_movement

   !> Return the slip of the vertex of contact c along its edge, and the increase of its gap, m.
   pure function foot_movement(first, blocks, c) result(movement)
      type(first_contacts_type), intent(in) :: first  !< initially touching contacts
      type(blocks_type), intent(in) :: blocks         !< blocks in their present state
      integer, intent(in) :: c                        !< number of the contact
      real(wp) :: movement(2)

      associate (v => first%vertex(c), e => first%edge(c))
         associate (apart => blocks%vertex(:, v) - blocks%vertex(:, e), &
            along => blocks%along(:, e))
            movement(1) = dot_product(apart, along) - first%foot_fraction(c)*blocks%length(e)
            movement(2) = apart(1)*along(2) - apart(2)*along(1) - first%gap(c)
         end associate
      end associate
   end function foot_movement

   !> Find the edge that each vertex is pressed against; of several, the last one in the list.
   pure subroutine find_pressed(first, contacts)
      type(first_contacts_type), intent(inout) :: first  !< initially touching contacts
      type(contacts_type), intent(in) :: contacts        !< contacts of the last step
      integer :: c

      first%pressed = 0
      do c = 1, contacts%n
         if (is_point(contacts, c)) cycle
         if (contacts%normal_force(c) > 0.0_wp) first%pressed(contacts%vertex(c)) = contacts%edge(c)
      end do
   end subroutine find_pressed

   !> Count all contacts, contacts that have slipped, and contacts that have opened beyond a limit.
   subroutine count_moved(first, contacts, blocks, limit, numbers)
      type(first_contacts_type), intent(inout) :: first  !< initially touching contacts
      type(contacts_type), intent(in) :: contacts        !< contacts of the last step
      type(blocks_type), intent(in) :: blocks            !< blocks in their present state
      real(wp), intent(in) :: limit                      !< smallest counted movement, m
      integer, intent(out) :: numbers(3)  !< numbers of all, slipped and opened contacts
      real(wp) :: movement(2)
      integer :: c

      numbers = 0
      call find_pressed(first, contacts)
      do c = 1, size(first%vertex)
         movement = contact_movement(first, blocks, c)
         numbers = numbers + [1, merge(1, 0, abs(movement(1)) > limit), &
            merge(1, 0, movement(2) > limit)]
      end do
   end subroutine count_moved

end module dda_first_contacts
