! SPDX-License-Identifier: GPL-3.0-or-later
!> Largest values of all steps of a run, and their update with the present state.  Of equal values,
!> the earliest one is reported; at equal times, the value with the lowest number of its block or
!> contact.  This rule holds for any number of threads.
module dda_maxima
   use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type
   use dda_base_motion, only: base_type
   use dda_contact, only: contacts_type
   use dda_output_schema, only: maxima_table, number_of_maxima, maxima_of_blocks, of_tilt, &
      of_displacement, of_velocity, of_acceleration, of_strain, of_slip, of_opening, &
      of_penetration, of_penetration_ratio, of_contact_force, of_point_displacement, &
      of_point_velocity, of_point_acceleration, of_point_drift, of_plastic_strain
   use dda_ordered_sums, only: pieces, first_of, last_of, most_pieces, parallel_from
   implicit none
   private
   public :: largest_type, maxima_table, update_largest, stored_value, add_blocks, add_contacts
   public :: of_tilt, of_displacement, of_velocity, of_acceleration, of_strain, of_slip, &
      of_opening, of_penetration, of_penetration_ratio, of_contact_force, of_point_displacement, &
      of_point_velocity, of_point_acceleration, of_point_drift, of_plastic_strain, number_of_maxima

   !> Largest value with its time and its blocks or points; the value is negative until it is set.
   type :: largest_type
      real(wp) :: value = -1.0_wp
      real(wp) :: time = 0.0_wp            !< s
      integer :: owners(2) = 0             !< blocks or points, 0: none
   end type largest_type

contains

   !> Store a value if it is larger than the stored one.
   pure subroutine update_largest(largest, value, time, owners)
      type(largest_type), intent(inout) :: largest  !< largest value so far
      real(wp), intent(in) :: value        !< value, in its own unit
      real(wp), intent(in) :: time         !< s
      integer, intent(in) :: owners(2)     !< blocks or points, 0: none

      if (value > largest%value) largest = largest_type(value, time, owners)
   end subroutine update_largest

   !> Return the stored value; NaN if there is none.
   elemental real(wp) function stored_value(largest)
      type(largest_type), intent(in) :: largest  !< largest value so far

      stored_value = largest%value
      if (stored_value < 0.0_wp) stored_value = ieee_value(stored_value, ieee_quiet_nan)
   end function stored_value

   !> Update the maxima of blocks: tilt, displacement, strain; with `rates`, also velocity and
   !> acceleration.
   subroutine add_blocks(largest, blocks, first, base, time, rates)
      type(largest_type), intent(inout) :: largest(:)  !< [maxima] largest values so far
      type(blocks_type), intent(in) :: blocks    !< blocks in their present state
      real(wp), intent(in) :: first(:,:)      !< [3,blocks] initial positions
      type(base_type), intent(in) :: base        !< base at the same time
      real(wp), intent(in) :: time               !< s
      logical, intent(in) :: rates               !< include velocities and accelerations
      real(wp) :: square(maxima_of_blocks, most_pieces)
      integer :: owners(maxima_of_blocks, most_pieces), p, n, i

      n = 1
      if (blocks%n >= parallel_from) n = pieces(blocks%n)
      do p = 1, n
         square(:, p) = square_to_exceed(largest(:maxima_of_blocks))
      end do
      owners(:, :n) = 0
      if (n == 1) then
         call scan_blocks(blocks, first, base, 1, blocks%n, rates, square(:, 1), owners(:, 1))
      else
         !$omp parallel do schedule(static)
         do p = 1, n
            call scan_blocks(blocks, first, base, first_of(p, blocks%n), last_of(p, blocks%n), &
               rates, square(:, p), owners(:, p))
         end do
      end if
      do p = 1, n
         do i = 1, maxima_of_blocks
            if (owners(i, p) > 0) call update_largest(largest(i), sqrt(square(i, p)), time, &
               [owners(i, p), 0])
         end do
      end do
   end subroutine add_blocks

   !> Search blocks first … last for values whose squares exceed given squares.
   pure subroutine scan_blocks(blocks, first_place, base, first, last, rates, square, owners)
      type(blocks_type), intent(in) :: blocks      !< blocks in their present state
      real(wp), intent(in) :: first_place(:,:)     !< [3,blocks] initial positions, m, m, rad
      type(base_type), intent(in) :: base          !< base at the same time
      integer, intent(in) :: first, last           !< first and last in the range
      logical, intent(in) :: rates                 !< include velocities and accelerations
      real(wp), intent(inout) :: square(maxima_of_blocks) !< squares of the largest values
      !> blocks of the new largest values
      integer, intent(inout) :: owners(maxima_of_blocks)
      real(wp) :: new(maxima_of_blocks)
      integer :: b, i

      do b = first, last
         if (blocks%removed(b)) cycle
         associate (q => blocks%position(:, b), v => blocks%velocity(:, b), &
            a => blocks%acceleration(:, b), q0 => first_place(:, b))
            new(of_tilt) = (q(3) - q0(3))**2
            new(of_displacement) = (q(1) - q0(1) - base%displacement(1))**2 &
               + (q(2) - q0(2) - base%displacement(2))**2
            new(of_velocity) = (v(1) - base%velocity(1))**2 + (v(2) - base%velocity(2))**2
            new(of_acceleration) = (a(1) - base%acceleration(1))**2 &
               + (a(2) - base%acceleration(2))**2
            ! The square root of this sum is an upper bound of the principal strains.
            new(of_strain) = dot_product(q(4:6), q(4:6))
            if (new(of_strain) > square(of_strain)) new(of_strain) = principal_strain(q(4:6))**2
         end associate
         do i = 1, maxima_of_blocks
            if (.not. new(i) > square(i)) cycle
            if (.not. rates .and. (i == of_velocity .or. i == of_acceleration)) cycle
            square(i) = new(i)
            owners(i) = b
         end do
      end do
   end subroutine scan_blocks

   !> Return the principal strain with the larger magnitude.
   pure real(wp) function principal_strain(strain)
      real(wp), intent(in) :: strain(3)  !< εx, εy, γxy

      principal_strain = 0.5_wp*(abs(strain(1) + strain(2)) + sqrt((strain(1) - strain(2))**2 &
         + strain(3)**2))
   end function principal_strain

   !> Update the maxima of penetrations and forces with the contacts of the last step.
   subroutine add_contacts(largest, contacts, size_of, least_size, time)
      type(largest_type), intent(inout) :: largest(:)  !< [maxima] largest values so far
      type(contacts_type), intent(in) :: contacts      !< contacts of the last step
      real(wp), intent(in) :: size_of(:)   !< [blocks] square root of the area, m
      real(wp), intent(in) :: least_size   !< smallest size of all blocks, m
      real(wp), intent(in) :: time         !< s
      real(wp) :: peak(3, most_pieces), bound
      integer :: p, n

      n = pieces(contacts%n)
      bound = least_size*largest(of_penetration_ratio)%value
      if (contacts%n < parallel_from) then
         do p = 1, n
            call scan_contacts(contacts, size_of, first_of(p, contacts%n), &
               last_of(p, contacts%n), bound, peak(:, p))
         end do
      else
         !$omp parallel do schedule(static)
         do p = 1, n
            call scan_contacts(contacts, size_of, first_of(p, contacts%n), &
               last_of(p, contacts%n), bound, peak(:, p))
         end do
      end if
      if (any(peak(1, :n) > largest(of_penetration)%value) .or. &
         any(peak(2, :n) > square_to_exceed(largest(of_contact_force))) .or. &
         any(peak(3, :n) > largest(of_penetration_ratio)%value)) &
         call update_contact_maxima(largest, contacts, size_of, time)
   end subroutine add_contacts

   !> Return the square of the largest value so far, for comparison with squares of new values.
   elemental real(wp) function square_to_exceed(largest)  ! total
      type(largest_type), intent(in) :: largest  !< largest value so far

      square_to_exceed = sign(largest%value**2, largest%value)
   end function square_to_exceed

   !> Find three maxima of contacts first … last: penetration, squared force, penetration ratio.
   !> The ratio (penetration/block size) is 0 unless the penetration exceeds `bound`.
   pure subroutine scan_contacts(contacts, size_of, first, last, bound, peak)
      type(contacts_type), intent(in) :: contacts  !< contacts of the last step
      real(wp), intent(in) :: size_of(:)           !< [blocks] square root of the area, m
      integer, intent(in) :: first, last           !< first and last in the range
      real(wp), intent(in) :: bound       !< least penetration for a new largest ratio, m
      real(wp), intent(out) :: peak(3)             !< maxima, m; (N/m)²; 1
      real(wp) :: depth, square
      integer :: c

      depth = 0.0_wp
      square = 0.0_wp
      !$omp simd reduction(max:depth, square)
      do c = first, last
         depth = max(depth, -(contacts%new_gap(c) + contacts%offset(c)))
         square = max(square, contacts%normal_force(c)**2 + contacts%shear_force(c)**2)
      end do
      peak = [depth, square, 0.0_wp]
      if (.not. depth > bound) return
      do c = first, last
         depth = -(contacts%new_gap(c) + contacts%offset(c))
         if (depth > bound) peak(3) = max(peak(3), depth/min(size_of(contacts%block_v(c)), &
            size_of(contacts%block_e(c))))
      end do
   end subroutine scan_contacts

   !> Update the maxima with the values of each contact.
   pure subroutine update_contact_maxima(largest, contacts, size_of, time)
      type(largest_type), intent(inout) :: largest(:)  !< [maxima] largest values so far
      type(contacts_type), intent(in) :: contacts      !< contacts of the last step
      real(wp), intent(in) :: size_of(:)   !< [blocks] square root of the area, m
      real(wp), intent(in) :: time         !< s
      real(wp) :: depth
      integer :: c

      do c = 1, contacts%n
         associate (owners => [contacts%block_v(c), contacts%block_e(c)])
            depth = max(0.0_wp, -(contacts%new_gap(c) + contacts%offset(c)))
            call update_largest(largest(of_penetration), depth, time, owners)
            call update_largest(largest(of_penetration_ratio), depth/minval(size_of(owners)), &
               time, owners)
            call update_largest(largest(of_contact_force), sqrt(contacts%normal_force(c)**2 &
               + contacts%shear_force(c)**2), time, owners)
         end associate
      end do
   end subroutine update_contact_maxima

end module dda_maxima
