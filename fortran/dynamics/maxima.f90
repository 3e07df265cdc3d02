! SPDX-License-Identifier: GPL-3.0-or-later
!> The largest values of a run over all its steps: which there are, and those of blocks and contacts
!> in one state.
!>
!> Of equal values the first in time counts, and of these that of the block or contact with the
!> lowest number, whatever the number of threads.
module dda_maxima
   use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
   use dda_kinds, only: wp
   use dda_blocks, only: blocks_type
   use dda_base_motion, only: base_type
   use dda_contact, only: contacts_type
   use dda_ordered_sums, only: pieces, first_of, last_of, most_pieces, parallel_from
   implicit none
   private
   public :: maximum_type, largest_type, maxima_table, take, known, add_blocks, add_contacts
   public :: of_tilt, of_displacement, of_velocity, of_acceleration, of_strain, of_slip, &
      of_opening, of_penetration, of_penetration_ratio, of_contact_force, of_point_displacement, &
      of_point_velocity, of_point_acceleration, of_point_drift, of_plastic_strain, number_of_maxima

   !> Kinds of largest values.
   type :: maximum_type
      character(len=18) :: name
      character(len=6) :: units    !< as pint reads them
      character(len=24) :: number  !< as a number of the verdict
      logical :: of_points         !< measured points, else blocks
   end type maximum_type

   ! Places in the table
   integer, parameter :: of_tilt = 1, of_displacement = 2, of_velocity = 3, of_acceleration = 4, &
      of_strain = 5, of_slip = 6, of_opening = 7, of_penetration = 8, of_penetration_ratio = 9, &
      of_contact_force = 10, of_point_displacement = 11, of_point_velocity = 12, &
      of_point_acceleration = 13, of_point_drift = 14, of_plastic_strain = 15
   integer, parameter :: number_of_maxima = 15

   type(maximum_type), parameter :: maxima_table(number_of_maxima) = [ &
      ! Rotation of a block
      maximum_type('tilt', 'rad', 'tilt_rad', .false.), &
      ! Displacement of the centroid of a block relative to the base
      maximum_type('displacement', 'm', 'displacement_m', .false.), &
      ! Velocity of the centroid of a block relative to the base
      maximum_type('velocity', 'm/s', 'velocity_m_s', .false.), &
      ! Acceleration of the centroid of a block relative to the base, mean of a step
      maximum_type('acceleration', 'm/s^2', 'acceleration_m_s2', .false.), &
      ! Principal strain of a block, by size
      maximum_type('strain', '1', 'strain', .false.), &
      ! Way of a vertex along the edge that it touched at first
      maximum_type('slip', 'm', 'slip_m', .false.), &
      ! Distance of a vertex from the edge that it touched at first
      maximum_type('opening', 'm', 'opening_m', .false.), &
      ! Depth of a vertex in another block
      maximum_type('penetration', 'm', 'penetration_m', .false.), &
      ! That depth over the root of the area of the smaller block or body
      maximum_type('penetration_ratio', '1', 'penetration_ratio', .false.), &
      ! Normal and shear force of a contact together, per metre of thickness
      maximum_type('contact_force', 'N/m', 'contact_force_n_m', .false.), &
      ! Displacement of a measured point relative to the base
      maximum_type('point_displacement', 'm', 'point_displacement_m', .true.), &
      ! Velocity of a measured point relative to the base
      maximum_type('point_velocity', 'm/s', 'point_velocity_m_s', .true.), &
      ! Acceleration of a measured point relative to the base
      maximum_type('point_acceleration', 'm/s^2', 'point_acceleration_m_s2', .true.), &
      ! Sideways displacement of a measured point against the one below it, over their height
      maximum_type('point_drift', '1', 'point_drift', .true.), &
      ! Plastic strain of a block whose material yields
      maximum_type('plastic_strain', '1', 'plastic_strain', .false.)]

   !> A value, and when and where it was; without one yet it is negative.
   type :: largest_type
      real(wp) :: value = -1.0_wp
      real(wp) :: time = 0.0_wp            !< s
      integer :: who(2) = 0                !< blocks or points, 0: none
   end type largest_type

contains

   !> Keep a value if it is larger.
   pure subroutine take(largest, value, time, who)
      type(largest_type), intent(inout) :: largest  !< so far
      real(wp), intent(in) :: value        !< in the unit of its kind
      real(wp), intent(in) :: time         !< s
      integer, intent(in) :: who(2)        !< blocks or points, 0: none

      if (value > largest%value) largest = largest_type(value, time, who)
   end subroutine take

   !> The value, no number without one.
   elemental real(wp) function known(largest)
      type(largest_type), intent(in) :: largest  !< so far

      known = largest%value
      if (known < 0.0_wp) known = ieee_value(known, ieee_quiet_nan)
   end function known

   !> Those of all blocks in their present state: tilt, displacement and strain, and rates if they
   !> count.
   subroutine add_blocks(largest, blocks, first, base, time, rates)
      type(largest_type), intent(inout) :: largest(:)  !< [maxima] so far
      type(blocks_type), intent(in) :: blocks    !< in their present state
      real(wp), intent(in) :: first(:,:)         !< [3,blocks] places that displacements count from
      type(base_type), intent(in) :: base        !< at the same time
      real(wp), intent(in) :: time               !< s
      logical, intent(in) :: rates               !< velocities and accelerations count
      real(wp) :: square(of_strain, most_pieces)
      integer :: who(of_strain, most_pieces), p, n, i

      n = 1
      if (blocks%n >= parallel_from) n = pieces(blocks%n)
      do p = 1, n
         square(:, p) = square_of(largest(:of_strain))
      end do
      who(:, :n) = 0
      if (n == 1) then
         call scan_blocks(blocks, first, base, 1, blocks%n, rates, square(:, 1), who(:, 1))
      else
         !$omp parallel do schedule(static)
         do p = 1, n
            call scan_blocks(blocks, first, base, first_of(p, blocks%n), last_of(p, blocks%n), &
               rates, square(:, p), who(:, p))
         end do
      end if
      do p = 1, n
         do i = 1, of_strain
            if (who(i, p) > 0) call take(largest(i), sqrt(square(i, p)), time, [who(i, p), 0])
         end do
      end do
   end subroutine add_blocks

   !> Blocks first … last: squares that exceed what they are given, and whose they are.
   pure subroutine scan_blocks(blocks, first_place, base, first, last, rates, square, who)
      type(blocks_type), intent(in) :: blocks      !< in their present state
      real(wp), intent(in) :: first_place(:,:)     !< [3,blocks] m, m, rad
      type(base_type), intent(in) :: base          !< at the same time
      integer, intent(in) :: first, last           !< of the range
      logical, intent(in) :: rates                 !< velocities and accelerations count
      real(wp), intent(inout) :: square(of_strain) !< of the largest values
      integer, intent(inout) :: who(of_strain)     !< blocks, in place of those of smaller values
      real(wp) :: new(of_strain)
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
            ! No principal strain is larger than the root of this sum.
            new(of_strain) = dot_product(q(4:6), q(4:6))
            if (new(of_strain) > square(of_strain)) new(of_strain) = principal(q(4:6))**2
         end associate
         do i = 1, of_strain
            if (.not. new(i) > square(i)) cycle
            if (.not. rates .and. (i == of_velocity .or. i == of_acceleration)) cycle
            square(i) = new(i)
            who(i) = b
         end do
      end do
   end subroutine scan_blocks

   !> The principal strain that is larger by size.
   pure real(wp) function principal(strain)
      real(wp), intent(in) :: strain(3)  !< εx, εy, γxy

      principal = 0.5_wp*(abs(strain(1) + strain(2)) + sqrt((strain(1) - strain(2))**2 &
         + strain(3)**2))
   end function principal

   !> Penetrations and forces of the contacts of the last step.
   subroutine add_contacts(largest, contacts, size_of, least_size, time)
      type(largest_type), intent(inout) :: largest(:)  !< [maxima] so far
      type(contacts_type), intent(in) :: contacts      !< of the last step
      real(wp), intent(in) :: size_of(:)   !< [blocks] root of the area, m
      real(wp), intent(in) :: least_size   !< of all blocks, m
      real(wp), intent(in) :: time         !< s
      real(wp) :: most(3, most_pieces), bound
      integer :: p, n

      n = pieces(contacts%n)
      bound = least_size*largest(of_penetration_ratio)%value
      if (contacts%n < parallel_from) then
         do p = 1, n
            call scan_contacts(contacts, size_of, first_of(p, contacts%n), &
               last_of(p, contacts%n), bound, most(:, p))
         end do
      else
         !$omp parallel do schedule(static)
         do p = 1, n
            call scan_contacts(contacts, size_of, first_of(p, contacts%n), &
               last_of(p, contacts%n), bound, most(:, p))
         end do
      end if
      if (any(most(1, :n) > largest(of_penetration)%value) .or. &
         any(most(2, :n) > square_of(largest(of_contact_force))) .or. &
         any(most(3, :n) > largest(of_penetration_ratio)%value)) &
         call take_contacts(largest, contacts, size_of, time)
   end subroutine add_contacts

   !> The square that a value must exceed.
   elemental real(wp) function square_of(largest)
      type(largest_type), intent(in) :: largest  !< so far

      square_of = sign(largest%value**2, largest%value)
   end function square_of

   !> Of contacts first … last the largest depth and square of a force; the largest depth over the
   !> size of a block, where one exceeds a bound, else 0.
   pure subroutine scan_contacts(contacts, size_of, first, last, bound, most)
      type(contacts_type), intent(in) :: contacts  !< of the last step
      real(wp), intent(in) :: size_of(:)           !< [blocks] root of the area, m
      integer, intent(in) :: first, last           !< of the range
      real(wp), intent(in) :: bound                !< of depths that may be the largest ratio, m
      real(wp), intent(out) :: most(3)             !< m; (N/m)²; 1
      real(wp) :: depth, square
      integer :: c

      depth = 0.0_wp
      square = 0.0_wp
      !$omp simd reduction(max:depth, square)
      do c = first, last
         depth = max(depth, -(contacts%new_gap(c) + contacts%offset(c)))
         square = max(square, contacts%normal_force(c)**2 + contacts%shear_force(c)**2)
      end do
      most = [depth, square, 0.0_wp]
      if (.not. depth > bound) return
      do c = first, last
         depth = -(contacts%new_gap(c) + contacts%offset(c))
         if (depth > bound) most(3) = max(most(3), depth/min(size_of(contacts%block_v(c)), &
            size_of(contacts%block_e(c))))
      end do
   end subroutine scan_contacts

   !> The same with the contacts, one by one.
   pure subroutine take_contacts(largest, contacts, size_of, time)
      type(largest_type), intent(inout) :: largest(:)  !< [maxima] so far
      type(contacts_type), intent(in) :: contacts      !< of the last step
      real(wp), intent(in) :: size_of(:)   !< [blocks] root of the area, m
      real(wp), intent(in) :: time         !< s
      real(wp) :: depth
      integer :: c

      do c = 1, contacts%n
         associate (who => [contacts%block_v(c), contacts%block_e(c)])
            depth = max(0.0_wp, -(contacts%new_gap(c) + contacts%offset(c)))
            call take(largest(of_penetration), depth, time, who)
            call take(largest(of_penetration_ratio), depth/minval(size_of(who)), time, who)
            call take(largest(of_contact_force), sqrt(contacts%normal_force(c)**2 &
               + contacts%shear_force(c)**2), time, who)
         end associate
      end do
   end subroutine take_contacts

end module dda_maxima
